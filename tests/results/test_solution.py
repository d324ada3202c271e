"""What a solution offers: dataset, file, report, picture."""

import dataclasses
import json

import numpy as np
import pytest

import varcontact as vc
from varcontact.discrete.certificate import ForceBounds


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


def test_edges_of_the_contact(sol, rolling):
    """The leading one is the mirror image of the trailing one, and changes its place where rolling
    turns round; in a shift all of the edge is neutral.
    """
    leading, trailing, neutral = sol.edges.values()
    contact = sol.state > 0
    rows = contact.any(axis=1)
    assert leading.sum() == trailing.sum() == rows.sum()
    assert np.all(sol.grid.x[leading.argmax(axis=1)[rows]] > 0)
    np.testing.assert_array_equal(leading, trailing[:, ::-1])
    assert not np.any(neutral & (leading | trailing))
    assert neutral.any()
    surrounded = contact[1:-1, :-2] & contact[1:-1, 2:] & contact[:-2, 1:-1] & contact[2:, 1:-1]
    inside = contact.copy()
    inside[1:-1, 1:-1] &= surrounded
    inside[[0, -1]] = inside[:, [0, -1]] = False
    np.testing.assert_array_equal(contact & ~inside, leading | trailing | neutral)
    back = vc.solve(rolling(motion=vc.Transient(steps=1, dq=0.2, direction=-1, vx=0.04)))[0]
    np.testing.assert_array_equal(back.edges["leading"], back.edges["trailing"][:, ::-1])
    assert np.all(back.grid.x[back.edges["leading"].argmax(axis=1)[rows]] < 0)
    shifted = vc.solve(rolling(motion=vc.Shift(ux=0.1)))
    assert not shifted.edges["leading"].any() and not shifted.edges["trailing"].any()
    np.testing.assert_array_equal(shifted.edges["neutral"], leading | trailing | neutral)


def test_edges_of_a_line_contact():
    scene = vc.Scene(
        bodies=vc.Bodies(1.0, 0.3),
        surface=vc.Cylinders(R=1.0),
        normal_force=0.01,
        friction=0.3,
        motion=vc.Steady(vx=0.001),
        grid=vc.Grid(nx=12),
    )
    found = vc.solve(scene)
    contact = np.flatnonzero(found.state[0])
    assert np.flatnonzero(found.edges["leading"][0]) == [contact[-1]]
    assert np.flatnonzero(found.edges["trailing"][0]) == [contact[0]]
    assert not found.edges["neutral"].any()


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


def test_save_and_load(sol, tmp_path):
    path = tmp_path / "solution.nc"
    sol.save(path)
    again = vc.load(path)
    assert again.report() == sol.report()
    assert vc.solve(again.scene).force == pytest.approx(sol.force)
    assert [p.name for p in tmp_path.iterdir()] == ["solution.nc"]
    sol.save(path)  # over itself


@pytest.mark.parametrize("name", ["x.xlsx", "x.vtk", "x.npz", "x.nc.txt", "x", ".nc"])
def test_endings_of_no_format_are_refused(sol, tmp_path, monkeypatch, name):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(vc.OutputError) as refused:
        sol.save(name)
    allowed = "the name must end in .nc, .csv, .vtu, .vti, .mat, .html"
    assert str(refused.value) == f"path = {name!r}: {allowed}"
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("name", ["a" * 300 + ".nc", "a\0b.nc"])
def test_names_that_no_file_can_have(sol, tmp_path, name):
    with pytest.raises(vc.OutputError, match="cannot be written"):
        sol.save(tmp_path / name)
    assert not list(tmp_path.iterdir())


@pytest.mark.long
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


DAMAGES = {
    "cut in x": lambda data: data.isel(x=slice(0, 5)),
    "one component": lambda data: data.isel(component=slice(0, 1)),
    "turned": lambda data: data.assign(traction=data["traction"].transpose("y", "x", "component")),
    "two creepages": lambda data: data.isel(rigid=slice(0, 2)),
    "no pressure": lambda data: data.drop_vars("pressure"),
    "another grid": lambda data: edited(
        data, grid={"nx": 3, "ny": 14, "dx": 1.0, "dy": 1.0, "x0": 0.0, "y0": 0.0}
    ),
    "no certificate": lambda data: edited(data, certificate=3),
    "no scene": lambda data: edited(data, scene=[]),
    "no record": lambda data: data.assign(record=((), "{")),
    "no iterations": lambda data: edited(data, iterations=None),
    "timing in a list": lambda data: edited(data, timing=[]),
    "converged in words": lambda data: edited(data, converged="no"),
    "words for pressures": lambda data: data.assign(pressure=data["pressure"].astype(str)),
    "pressures that are no numbers": lambda data: data.assign(pressure=data["pressure"] * np.nan),
}


def edited(data, **changes):
    """The dataset with other entries in its JSON record."""
    return data.assign(
        record=((), json.dumps({**json.loads(str(data["record"].values)), **changes}))
    )


@pytest.mark.parametrize("damage", DAMAGES)
def test_damaged_files_are_refused(tmp_path, sol, damage):
    path = tmp_path / "a.nc"
    DAMAGES[damage](sol.to_xarray()).to_netcdf(path, engine="h5netcdf")
    with pytest.raises(vc.OutputError, match="is damaged"):
        vc.load(path)


@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_summary_is_strict_json_whatever_came_out(sol, value):
    bounds = ForceBounds(np.array([value, 0.1, value]), np.zeros(3))
    bad = dataclasses.replace(
        sol,
        traction=np.full_like(sol.traction, value),
        pressure=np.full_like(sol.pressure, value),
        approach=value,
        creepage=(value, 0.0, 0.0),
        certificate=dataclasses.replace(
            sol.certificate, gap=value, relative_gap=value, residual=value, bounds=bounds
        ),
    )
    with np.errstate(invalid="ignore"):
        summary = json.loads(json.dumps(bad.summary(), allow_nan=False))
    assert summary["certificate"]["force_bound"] == [None, 0.1, None]
    for name in ("gap", "relative_gap", "residual"):
        assert summary["certificate"][name] is None
    assert summary["creepage"] == [None, 0.0, 0.0]
    assert summary["normal_force"] is None
    assert summary["approach"] is None


def test_report_says_what_matters(sol, rolling):
    text = str(sol)
    methods = ("hertz", "tang-safeguarded")
    for words in (
        "Steady rolling",
        "quasi-identical",
        "N/mm^2",
        "relative gap",
        "guaranteed",
        *methods,
    ):
        assert words in text
    assert f"{sol.force[0]:.6g}" in text
    assert f"{sol.elements['stick']} stick" in text
    shifted = vc.solve(rolling(motion=vc.Shift(ux=0.1), bodies=vc.Bodies(G=(1.0, 2.0), nu=0.3)))
    assert "rigid shift" in shifted.report()
    assert "unlike bodies" in shifted.report()
    assert "NOT CONVERGED" in dataclasses.replace(sol, converged=False).report()
    assert "Normal contact" in vc.solve(rolling(motion=None)).report()


def test_report_says_why_there_is_no_bound(rolling):
    """Each by its name: bodies that are unlike, and those of a conformal contact."""
    unlike = vc.solve(rolling(bodies=vc.Bodies(G=(1.0, 2.0), nu=0.3)))
    assert (
        "the bodies are unlike, and the traction bound depends on the solution" in unlike.report()
    )
    grid = vc.Grid(nx=12, ny=10, dx=0.2, dy=0.2, x0=-1.2, y0=-1.0)
    surface = vc.SampledDistance(np.add.outer(grid.y**2, grid.x**2) / 20, inclination=grid.y / 10)
    conformal = vc.solve(rolling(surface=surface, grid=grid, normal_force=None, approach=0.03))
    assert (
        "the bodies are conformal, and the traction bound depends on the solution"
        in conformal.report()
    )


@pytest.mark.long
@pytest.mark.parametrize(
    "surface", [vc.Ellipse(a=1.2, b=0.9), vc.Ellipse(a=8.0, b=0.4), vc.Ellipse(a=0.4, b=8.0)]
)
def test_arrows_point_along_the_tractions_on_the_page(rolling, surface):
    """Also where the contact is so long that the axes are not equal: otherwise all arrows look
    along it.
    """
    from matplotlib.quiver import Quiver

    sol = vc.solve(rolling(surface=surface, motion=vc.Steady(vx=0.3, vy=-0.2, spin=0.05)))
    figure = sol.plot()
    figure.canvas.draw()
    (ax,) = (ax for ax in figure.axes if ax.get_title().startswith("Tangential"))
    (arrows,) = (artist for artist in ax.get_children() if isinstance(artist, Quiver))
    to_page = arrows.get_transform()
    u, v = np.asarray(arrows.U), np.asarray(arrows.V)
    long = np.hypot(u, v) > 0.5 * np.hypot(u, v).max()
    for k in np.flatnonzero(long):
        corners = to_page.transform(arrows.get_paths()[k].vertices) - to_page.transform((0, 0))
        tip = corners[np.argmax(np.hypot(*corners.T))]
        along = tip @ (u[k], v[k]) / np.hypot(u[k], v[k])
        assert along > 0.99 * np.hypot(*tip)
        assert along < 0.25 * min(ax.bbox.size)


def test_creepage_is_open_without_friction(rolling):
    free = vc.solve(rolling(friction=0.0, motion=vc.Steady(Fx=0.0, vy=0.01, spin=0.1)))
    assert np.isnan(free.creepage[0])
    assert free.creepage[1:] == (0.01, 0.1)
    assert free.summary()["creepage"][0] is None
    assert "vx = nan" in free.report()


@pytest.mark.parametrize(
    "error", [vc.TooLarge("a product", 2e10, 1e10, "a smaller grid"), KeyError("a slip of ours")]
)
def test_errors_of_our_own_are_no_damage_of_a_file(sol, tmp_path, monkeypatch, error):
    def fails(*arguments):
        raise error

    path = tmp_path / "sound.nc"
    sol.save(path)
    monkeypatch.setattr("varcontact.solving.verify.certificate_of", fails)
    with pytest.raises(type(error)) as caught:
        vc.load(path)
    assert caught.value is error
    history = dataclasses.replace(sol.scene, motion=vc.Transient(steps=2, dq=0.1, vx=0.01))
    vc.solve(history).save(tmp_path / "history.nc")
    with pytest.raises(type(error)) as caught:
        vc.load(tmp_path / "history.nc")[0]
    assert caught.value is error
