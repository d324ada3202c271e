"""What a solution offers: dataset, file, report, picture."""

import dataclasses
import json

import numpy as np
import pytest

import varcontact as vc


@pytest.fixture(scope="module")
def sol(rolling):
    return vc.solve(rolling(units=vc.Units(length="mm", force="N")))


def test_forces_are_sums_of_tractions(sol):
    area = np.prod(sol.grid.sides)
    assert sol.normal_force == pytest.approx(sol.pressure.sum() * area)
    assert sol.force == pytest.approx(sol.traction.sum(axis=(1, 2)) * area)
    expected = sum(
        area * (x * sol.traction[1, iy, ix] - y * sol.traction[0, iy, ix])
        for iy, y in enumerate(sol.grid.y)
        for ix, x in enumerate(sol.grid.x)
    )
    assert sol.moment == pytest.approx(expected)
    assert sol.areas["contact"] == pytest.approx(np.pi * 1.2 * 0.9, rel=0.05)


def test_dataset(sol):
    data = sol.to_xarray()
    assert data["pressure"].dims == ("y", "x")
    assert data["traction"].dims == ("component", "y", "x")
    assert data["pressure"].attrs["units"] == "N/mm^2"
    assert data["x"].attrs["units"] == "mm"
    assert data["moment"].attrs["units"] == "N mm"
    total = data["traction"].sel(component="x").sum() * np.prod(sol.grid.sides)
    assert float(total) == pytest.approx(float(data["force"].sel(component="x")))
    assert float(data["creepage"].sel(rigid="spin")) == 0.05
    np.testing.assert_array_equal(data["y"], sol.grid.y)


def test_dataset_without_units_says_what_they_are_of(rolling):
    data = vc.solve(rolling(motion=vc.Shift(ux=0.1))).to_xarray()
    assert data["pressure"].attrs["units"] == "force/length^2"
    assert data["slip"].attrs["units"] == "length"
    assert list(data["rigid"].values) == ["ux", "uy", "rotation"]


def test_save_and_load(sol, tmp_path):
    path = tmp_path / "solution.nc"
    sol.save(path)
    again = vc.load(path)
    for name in ("pressure", "traction", "slip", "distance", "state"):
        np.testing.assert_array_equal(getattr(again, name), getattr(sol, name))
    assert json.dumps(again.summary()) == json.dumps(sol.summary())
    assert again.report() == sol.report()
    assert vc.solve(again.scene).force == pytest.approx(sol.force)
    assert [p.name for p in tmp_path.iterdir()] == ["solution.nc"]
    sol.save(path)  # over itself


def test_unlike_bodies_and_infinite_friction_survive_the_file(rolling, tmp_path):
    for changes in ({"friction": np.inf}, {"bodies": vc.Bodies(G=(1.0, np.inf), nu=0.3), "motion": vc.Steady(vx=0.02)}):
        solution = vc.solve(rolling(**changes))
        solution.save(tmp_path / "a.nc")
        again = vc.load(tmp_path / "a.nc")
        np.testing.assert_array_equal(again.certificate.force_bound, solution.certificate.force_bound)
        assert json.loads(json.dumps(again.summary(), allow_nan=False)) == again.summary()


def test_unwritable(sol, tmp_path):
    (tmp_path / "folder.nc").mkdir()
    for path in (tmp_path / "none" / "a.nc", tmp_path / "folder.nc"):
        with pytest.raises(vc.OutputError) as failure:
            sol.save(path)
        assert str(path) in str(failure.value)
    assert [p.name for p in tmp_path.iterdir()] == ["folder.nc"]


def test_interrupted_writing_leaves_the_old_file(sol, tmp_path, monkeypatch):
    path = tmp_path / "a.nc"
    sol.save(path)
    before = path.read_bytes()

    def fail(*_, **__):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("pathlib.Path.write_bytes", fail)
    with pytest.raises(vc.OutputError, match="No space left"):
        sol.save(path)
    assert path.read_bytes() == before
    assert [p.name for p in tmp_path.iterdir()] == ["a.nc"]


def test_foreign_files_are_refused(tmp_path, sol):
    text = tmp_path / "a.nc"
    text.write_text("no netCDF")
    foreign = tmp_path / "b.nc"
    sol.to_xarray().assign_attrs(format="else").to_netcdf(foreign, engine="h5netcdf")
    damaged = tmp_path / "c.nc"
    sol.to_xarray().drop_vars("record").to_netcdf(damaged, engine="h5netcdf")
    for path in (text, foreign, damaged, tmp_path / "none.nc"):
        with pytest.raises(vc.OutputError):
            vc.load(path)


def test_report_says_what_matters(sol, rolling):
    text = str(sol)
    for words in ("Steady rolling", "quasi-identical", "N/mm^2", "relative gap", "guaranteed", "hertz", "clarabel"):
        assert words in text
    assert f"{sol.force[0]:.6g}" in text
    assert f"{sol.elements['stick']} stick" in text
    shifted = vc.solve(rolling(motion=vc.Shift(ux=0.1), bodies=vc.Bodies(G=(1.0, 2.0), nu=0.3)))
    assert "rigid shift" in shifted.report()
    assert "unlike bodies" in shifted.report()
    assert "NOT CONVERGED" in dataclasses.replace(sol, converged=False).report()
    assert "Normal contact" in vc.solve(rolling(motion=None)).report()


@pytest.mark.parametrize(
    ("changes", "panels"),
    [
        ({}, 3),
        ({"motion": None}, 2),
        ({"friction": np.inf}, 3),
        ({"friction": 0.0}, 3),
        ({"motion": vc.Shift(uy=0.1)}, 3),
    ],
)
def test_picture(rolling, changes, panels):
    """Panels, arrows where there is traction, and the bound in the section."""
    import matplotlib as mpl

    mpl.use("Agg")
    from matplotlib import pyplot as plt
    from matplotlib.quiver import Quiver

    solution = vc.solve(rolling(**changes))
    figure = solution.plot()
    axes = [ax for ax in figure.axes if ax.get_title()]
    assert len(axes) == panels
    arrows = [artist for ax in axes for artist in ax.get_children() if isinstance(artist, Quiver)]
    assert bool(arrows) == bool(solution.traction.any())
    if arrows:
        assert arrows[0].N == solution.elements["contact"]
    figure.canvas.draw()
    plt.close(figure)
