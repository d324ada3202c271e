"""Stresses and fits as datasets, tables, files and pictures."""

import meshio
import numpy as np
import pytest
import xarray as xr

import varcontact as vc
from varcontact.io.labelled import Labelled

SCENE = vc.Scene(
    bodies=vc.Bodies(G=82e3, nu=0.28),
    surface=vc.Ellipse(a=5.0, b=4.0),
    normal_force=50e3,
    friction=0.3,
    motion=vc.Steady(vx=1e-3),
    grid=vc.Grid(nx=6, ny=6),
    units=vc.Units(length="mm", force="N"),
)


@pytest.fixture(scope="module")
def solution():
    return vc.solve(SCENE)


@pytest.mark.parametrize("body", [1, 2])
def test_stresses_on_a_grid_are_over_its_axes(solution, body, tmp_path):
    below = vc.stress_below(solution, [0.0, 2.0, 5.0], body)
    data = below.to_xarray()
    assert data["stress_xz"].dims == ("z", "y", "x") and data["stress_xz"].units == "N/mm^2"
    assert data["z"].values.tolist() == [[0.0, 2.0, 5.0], [-0.0, -2.0, -5.0]][body - 1]
    assert np.array_equal(data["stress_xz"], below.stress[0, 2])
    assert np.array_equal(data["displacement_y"], below.displacement[1])
    assert np.array_equal(data["tresca"], below.tresca)
    below.save(tmp_path / "stress.vtu")
    below.save(tmp_path / "stress.vtu")  # its own kind may be replaced
    mesh = meshio.read(tmp_path / "stress.vtu")
    assert mesh.points == pytest.approx(below.points.reshape(3, -1).T)
    assert mesh.point_data["stress"][:, 2] == pytest.approx(below.stress[0, 2].ravel())
    assert mesh.point_data["von_mises"] == pytest.approx(below.von_mises.ravel())
    (cells,) = mesh.cells
    corners = mesh.points[cells.data]
    volume = np.einsum(
        "ni,ni->n",
        np.cross(corners[:, 1] - corners[:, 0], corners[:, 3] - corners[:, 0]),
        corners[:, 4] - corners[:, 0],
    )
    assert cells.type == "hexahedron" and (volume > 0).all()
    box = np.ptp(mesh.points, axis=0)
    assert volume.sum() == pytest.approx(box.prod())


def test_stresses_at_points_are_in_their_order(solution, tmp_path):
    points = np.array([[0.0, 1.0], [0.0, 2.0], [1.0, 3.0]])
    field = vc.stress(solution, points)
    data = field.to_xarray()
    assert data["stress_zz"].dims == ("point",)
    assert data["z"].values.tolist() == [1.0, 3.0]
    table = field.to_dataframe()
    assert table["stress_zz"].tolist() == field.stress[2, 2].tolist()
    assert table.attrs["units"]["x"] == "mm"
    field.save(tmp_path / "points.vtu")
    assert meshio.read(tmp_path / "points.vtu").cells[0].type == "vertex"
    field.save(tmp_path / "points.nc")
    with xr.open_dataset(tmp_path / "points.nc") as again:
        assert again["stress_zz"].values.tolist() == field.stress[2, 2].tolist()


@pytest.fixture(scope="module")
def fit():
    vx = np.linspace(5e-4, 8e-3, 8)
    measured = vc.creep_curve(SCENE, {"polach": {"k_A": 0.5, "k_S": 0.3}}, vx=vx)
    forces = measured.Fx[0].to_numpy().copy()
    forces[3] = np.nan
    guesses = {"k_A": (0.9, 0.1, 1.0), "k_S": (0.4, 0.1, 1.0)}
    return vc.fit_creep_curve(SCENE, guesses, vx=vx, Fx=forces, method="polach", sigma=200.0)


def test_a_fit_keeps_its_points(fit):
    data = fit.to_xarray()
    assert data["value"].sel(parameter="k_A").item() == pytest.approx(0.5, abs=1e-4)
    assert data["measured_Fx"].units == "N"
    apart = (data["measured_Fx"] - data["fitted_Fx"]).dropna("point")
    assert apart.size == 7
    assert np.sqrt((apart**2).mean()).item() == pytest.approx(fit.rms, abs=1e-6)
    table = fit.to_dataframe().set_index("parameter")
    assert table.loc["k_S", "error"] == fit.errors["k_S"]
    assert fit._repr_html_().startswith("<pre>")


def test_a_fit_draws_its_points_with_bars(fit):
    (ax,) = fit.plot().axes
    ((points, _, (bars,)),) = ax.containers
    assert points.get_ydata() == pytest.approx(fit.measured["Fx"], nan_ok=True)
    lengths = [segment[1, 1] - segment[0, 1] for segment in bars.get_segments() if len(segment)]
    assert np.nanmax(lengths) == pytest.approx(400.0)
    assert "k_A" in ax.get_title()


def test_all_results_that_the_page_names_are_labelled():
    from varcontact import wheel_rail
    from varcontact.results.stress import SubsurfaceStress
    from varcontact.study.fit import CreepCurveFit

    wheels = [getattr(wheel_rail, name) for name in ("WheelRailSolution", "WheelSetSolution")]
    others = [wheel_rail.Wear, wheel_rail.GeometryTable, SubsurfaceStress, CreepCurveFit]
    for kind in (*wheels, *others):
        assert issubclass(kind, Labelled)
        for method in ("to_xarray", "to_dataframe", "save", "_repr_html_"):
            assert callable(getattr(kind, method))
