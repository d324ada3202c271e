"""Exports read back by the programs' own readers: equal to the last digit, and never half
written.
"""

import dataclasses
import json
import os

import meshio
import numpy as np
import pandas as pd
import pytest
from scipy.io import loadmat

import varcontact as vc
from tests.command import ROLLING_SPHERES, assert_bad_input, run
from tests.scenes import wheel_on_rail
from varcontact.io.export import LOADS, QUANTITIES

BALL = wheel_on_rail(vc.Steady(vx=1e-3, spin=0.2), vc.Grid(nx=7, ny=5), units=vc.SI)
CASES = {
    "rolling": BALL,
    "shift": dataclasses.replace(BALL, motion=vc.Shift(ux=1e-6), units=None),
    "no slip": dataclasses.replace(BALL, friction=np.inf),
    "pressure": dataclasses.replace(BALL, motion=None, friction=None),
    "line": dataclasses.replace(
        BALL,
        surface=vc.Cylinders(R=0.46),
        normal_force=8e6,
        motion=vc.Steady(vx=1e-3),
        grid=vc.Grid(nx=9),
    ),
}


@pytest.fixture(scope="module", params=CASES)
def sol(request):
    return vc.solve(CASES[request.param])


@pytest.fixture(scope="module")
def one():
    return vc.solve(BALL)


def fields(sol):
    """What each element has, by the names of the columns."""
    names = ("pressure", "traction_bound", "distance", "state", "power_density")
    found = {name: getattr(sol, name).ravel() for name in names}
    for name in ("traction", "slip"):
        found |= {f"{name}_{axis}": getattr(sol, name)[i].ravel() for i, axis in enumerate("xy")}
    x, y = np.meshgrid(sol.grid.x, sol.grid.y)
    return found | {"x": x.ravel(), "y": y.ravel()}


def test_the_table_has_a_row_per_element(sol):
    table = sol.to_dataframe()
    assert list(table) == list(QUANTITIES) and len(table) == sol.grid.size
    for name, values in fields(sol).items():
        np.testing.assert_array_equal(table[name], values)
    assert table["traction_x"].sum() * sol.grid.area == pytest.approx(sol.Fx, rel=1e-12, abs=1e-9)


def test_units_of_the_table(one):
    """In the scene's; in a shift slip is a length, and work is by area alone."""
    units = one.to_dataframe().attrs["units"]
    names = ("x", "pressure", "slip_x", "power_density", "Mz", "spin")
    assert [units[name] for name in names] == ["m", "N/m^2", "1", "N/m^2", "N m", "1/m"]
    shifted = vc.solve(CASES["shift"]).to_dataframe().attrs["units"]
    assert (shifted["slip_x"], shifted["power_density"]) == ("length", "force/length")


def test_csv(sol, tmp_path):
    sol.save(tmp_path / "sol.csv")
    lines = (tmp_path / "sol.csv").read_text().splitlines()
    assert lines[0] == ",".join(QUANTITIES)
    read = np.array([[float(value) for value in line.split(",")] for line in lines[1:]])
    for column, name in zip(read.T, QUANTITIES, strict=True):
        np.testing.assert_array_equal(column, fields(sol)[name])
    again = pd.read_csv(tmp_path / "sol.csv")
    assert np.allclose(again["pressure"], fields(sol)["pressure"], rtol=1e-15)


def test_matlab(sol, tmp_path):
    sol.save(tmp_path / "sol.mat")
    read = loadmat(tmp_path / "sol.mat", simplify_cells=True)
    assert (
        np.ravel(read["x"]).tolist() == sol.grid.x.tolist()
        and np.ravel(read["y"]).tolist() == sol.grid.y.tolist()
    )
    for name in set(QUANTITIES) - {"x", "y"}:
        np.testing.assert_array_equal(
            read[name].reshape(sol.grid.shape), fields(sol)[name].reshape(sol.grid.shape)
        )
    for name in LOADS:
        assert read[name] == getattr(sol, name) or (
            np.isnan(read[name]) and np.isnan(getattr(sol, name))
        )
    assert read["units"]["pressure"] == ("force/length^2" if sol.scene.units is None else "N/m^2")
    assert json.loads(read["scene"])["bodies"]["nu"] == 0.28


def test_vtk_unstructured(sol, tmp_path):
    """Quadrilaterals around the elements' centres, in the order of the table."""
    sol.save(tmp_path / "sol.vtu")
    mesh = meshio.read(tmp_path / "sol.vtu")
    (cells,) = mesh.cells
    assert cells.type == "quad" and len(cells.data) == sol.grid.size
    corners = mesh.points[cells.data]
    centres = corners.mean(axis=1)
    expected = fields(sol)
    scale = np.abs(sol.grid.box).max()
    np.testing.assert_allclose(centres[:, :2].T, [expected["x"], expected["y"]], atol=1e-14 * scale)
    u, v = corners[:, 1] - corners[:, 0], corners[:, 3] - corners[:, 0]
    assert (u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]) == pytest.approx(
        np.prod(sol.grid.sides), rel=1e-9
    )
    data = {name: values[0] for name, values in mesh.cell_data.items()}
    for name in ("pressure", "traction_bound", "distance", "state", "power_density"):
        np.testing.assert_array_equal(data[name], expected[name])
    for name in ("traction", "slip"):
        np.testing.assert_array_equal(
            data[name], np.stack([*getattr(sol, name).reshape(2, -1), 0 * expected["x"]], 1)
        )


def test_vtk_image_has_the_same_cells(sol, tmp_path):
    """The arrays of the other file, letter by letter, on the grid that its head describes."""
    sol.save(tmp_path / "sol.vtu")
    sol.save(tmp_path / "sol.vti")
    other, image = ((tmp_path / f"sol.{kind}").read_text() for kind in ("vtu", "vti"))
    cells = other[other.index("<CellData>") : other.index("</CellData>")]
    assert cells in image and len(cells) > 1000
    head = next(line for line in image.splitlines() if line.startswith("<ImageData"))
    words = {
        part.split("=")[0].split()[-1]: part.split('"')[1]
        for part in head.replace('" ', '"\n').split("\n")
    }
    (ny, nx), (dx, dy) = sol.grid.shape, sol.grid.sides
    assert words["WholeExtent"] == f"0 {nx} 0 {ny} 0 0"
    assert [float(word) for word in words["Spacing"].split()] == [dx, dy, 1]
    left, _, bottom, _ = sol.grid.box
    assert [float(word) for word in words["Origin"].split()] == [left, bottom, 0]


@pytest.mark.parametrize("ending", ["csv", "mat", "vtu", "vti", "nc"])
def test_only_a_solution_is_replaced(one, tmp_path, ending):
    """By one in the same format; what another wrote is left alone, and nothing is left beside
    it.
    """
    path = tmp_path / f"a.{ending}"
    one.save(path)
    one.save(path)
    path.write_text("my own\n")
    with pytest.raises(
        vc.OutputError,
        match=r"no solution of varcontact's; name another file, or give overwrite=True",
    ):
        one.save(path)
    assert path.read_text() == "my own\n"
    one.save(path, overwrite=True)
    assert path.stat().st_size > 500 and os.listdir(tmp_path) == [path.name]


@pytest.mark.parametrize("ending", ["csv", "mat", "vtu", "vti", "nc"])
def test_a_failure_leaves_the_old_file(one, tmp_path, ending, monkeypatch):
    """As where the disk is full."""
    path = tmp_path / f"a.{ending}"
    one.save(path)
    before = path.read_bytes()

    def full(descriptor):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "fsync", full)
    with pytest.raises(vc.OutputError, match="No space left on device"):
        one.save(path)
    assert path.read_bytes() == before and os.listdir(tmp_path) == [path.name]


@pytest.mark.long
def test_from_the_command_line(tmp_path):
    """A table of elements; of a history netCDF alone, and a moving picture."""
    (tmp_path / "scene.toml").write_text(ROLLING_SPHERES)
    done = run("solve", "scene.toml", "--out", "a.csv", "--plot", "a.gif", folder=tmp_path)
    assert done.returncode == 0, done.stderr
    sol = vc.solve(vc.read_scene(tmp_path / "scene.toml")[0])
    np.testing.assert_allclose(
        pd.read_csv(tmp_path / "a.csv")["pressure"], sol.pressure.ravel(), rtol=1e-12
    )
    (tmp_path / "scene.toml").write_text(
        ROLLING_SPHERES.replace('"steady"', '"transient", steps = 2, dq = 0.1')
    )
    assert_bad_input(
        run("solve", "scene.toml", "--out", "b.csv", folder=tmp_path), "the name must end in .nc"
    )
    done = run("solve", "scene.toml", "--out", "b.nc", "--plot", "b.gif", folder=tmp_path)
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "b.gif").read_bytes().startswith(b"GIF89a")
    assert not (tmp_path / "b.csv").exists()
