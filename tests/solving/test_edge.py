"""Which elements that the contact's edge cuts are in contact: by their centres, or all that it
touches.
"""

import dataclasses

import numpy as np
import pytest

import varcontact as vc
from tests.scenes import carters_cylinders, refused

TOUCHED = vc.Grid(nx=12, ny=12, edge="touched")


def fx(scene, cells, edge):
    """Longitudinal force by elements of one kind."""
    grid = vc.Grid(nx=cells, ny=None if scene.line else cells, edge=edge)
    return vc.solve(dataclasses.replace(scene, grid=grid), tangential="tang-safeguarded").force[0]


def test_touched_elements_are_those_with_a_point_inside(rolling):
    sol = vc.solve(rolling(grid=TOUCHED))
    (dx, dy), (x, y) = sol.grid.sides, np.meshgrid(np.abs(sol.grid.x), np.abs(sol.grid.y))
    nearest = np.maximum(x - dx / 2, 0) / 1.2, np.maximum(y - dy / 2, 0) / 0.9
    np.testing.assert_array_equal(sol.pressure > 0, np.hypot(*nearest) < 1 - 1e-9)
    assert sol.normal_force == pytest.approx(1.0, rel=1e-14)
    assert sol.certificate.relative_gap < 1e-12
    assert np.all(np.hypot(*sol.traction) <= 0.3 * sol.pressure * (1 + 1e-12))
    by_centres = vc.solve(rolling())
    assert np.all((sol.pressure > 0) >= (by_centres.pressure > 0))
    assert sol.grid.edge == "touched"


@pytest.mark.parametrize("cells", [7, 12, 60])
def test_the_plan_knows_them(rolling, cells):
    """Elements as they then are; mirror images on both sides of y = 0 where no row lies on it."""
    scene = rolling(grid=vc.Grid(nx=cells, ny=cells, edge="touched"), motion=vc.Steady(spin=0.05))
    plan = vc.plan(scene, tangential="tang-safeguarded")
    sizes = plan.sizes
    assert sizes.exact
    assert sizes.mirrored == (cells % 2 == 0)
    if cells < 20:
        sol = vc.solve(scene)
        assert sizes.elements["tangential"] == sol.elements["contact"]


def test_error_is_regular(rolling):
    """Forces follow a straight line in the element size, twice as closely as by centres."""
    scene, cells = rolling(), np.arange(8, 17, 2)
    left = {}
    for edge in ("centres", "touched"):
        forces = np.array([fx(scene, n, edge) for n in cells])
        line = np.polyfit(1 / cells, forces, 1)
        left[edge] = np.abs(forces - np.polyval(line, 1 / cells)).max() / abs(line[1])
        if edge == "touched":
            assert 2 * forces[4] - forces[0] == pytest.approx(line[1], rel=0.006)
            assert abs(forces[4] / line[1] - 1) > 0.02
    assert left["touched"] < left["centres"] / 2
    assert left["touched"] < 0.004


def test_line_contact():
    """All elements are inside; the averaged pressure, too, leads to Carter's force, with the order
    one.
    """
    exact, scene = carters_cylinders()
    cells = np.array([20, 40, 80, 160])
    errors = [fx(scene, n, "touched") / exact.force - 1 for n in cells]
    order = -np.polyfit(np.log(cells), np.log(np.abs(errors)), 1)[0]
    assert 0.9 < order < 1.2
    assert abs(errors[-1]) < 3e-3


def test_moved_lattice_has_the_same_force(rolling):
    """An explicit lattice anywhere; one that does not hold all touched elements is refused."""
    sides = {"dx": 0.2, "dy": 0.15, "edge": "touched"}
    sol = vc.solve(rolling(grid=vc.Grid(nx=13, ny=13, x0=-1.27, y0=-0.98, **sides)))
    assert sol.normal_force == pytest.approx(1.0, rel=1e-14)
    with pytest.raises(vc.SceneError, match="does not contain the contact"):
        vc.solve(rolling(grid=vc.Grid(nx=12, ny=13, x0=-1.17, y0=-0.98, **sides)))
    shorter = vc.Grid(nx=12, ny=13, x0=-1.17, y0=-0.98, dx=0.2, dy=0.15)
    assert vc.solve(rolling(grid=shorter)).elements["contact"] > 100  # by centres it holds them


def test_a_steady_state_stays(rolling):
    steady = vc.solve(rolling(grid=TOUCHED))
    motion = vc.Transient(steps=2, start=steady, vx=0.04, vy=-0.02, spin=0.05)
    for grid in (steady.grid, "auto"):
        history = vc.solve(rolling(motion=motion, grid=grid))
        distance = np.abs(history[-1].traction - steady.traction).max()
        assert distance < 1e-8 * steady.pressure.max()
        assert history[-1].grid.edge == "touched"
    by_centres = vc.solve(rolling(motion=motion, grid=vc.Grid(nx=12, ny=12)))[-1]
    assert (
        by_centres.grid.edge == "centres"
        and by_centres.elements["contact"] < steady.elements["contact"]
    )


@pytest.mark.long
def test_converge_keeps_the_edge(rolling, tmp_path):
    """No staircase is fitted; both kinds of elements tend to the same force, within their error
    bars.
    """
    touched, centres = (
        vc.converge(
            rolling(grid=vc.Grid(nx=1, ny=1, edge=edge)),
            [6, 8, 10, 12],
            offsets=2,
            store=tmp_path / f"{edge}.csv",
        )
        for edge in ("touched", "centres")
    )
    assert touched.runs["staircase"].isna().all() and centres.runs["staircase"].notna().all()
    one, other = touched.limit("Fx"), centres.limit("Fx")
    assert (
        abs(one["value"] - other["value"]) < one["error"] + other["error"] < 0.2 * abs(one["value"])
    )
    assert (touched.runs["contact_area"] > np.pi * 1.2 * 0.9).all()
    with pytest.raises(vc.SceneError, match="holds a study of another scene"):
        vc.converge(rolling(grid=TOUCHED), [8, 12], offsets=1, store=tmp_path / "centres.csv")


def test_refused_where_tractions_change_the_pressure(rolling):
    with pytest.raises(vc.SceneError, match=r'use "centres"$') as refused:
        vc.solve(rolling(grid=TOUCHED, bodies=vc.Bodies(G=(1.0, 3.0), nu=(0.3, 0.2))))
    assert (refused.value.field, refused.value.value) == ("grid.edge", "touched")


def test_pressures_to_be_judged_are_those_on_parts(rolling):
    sol = vc.solve(rolling(grid=TOUCHED))
    explicit = rolling(grid=sol.grid)
    assert vc.certify(explicit, sol.traction).relative_gap < 1e-12
    with pytest.raises(
        vc.SceneError, match=r"pressure has shape \(14, 14\); it must be of shape \(42, 42\)"
    ):
        vc.certify(explicit, sol.traction, sol.pressure)


def test_words():
    with pytest.raises(vc.SceneError, match=r"grid\.edge.*did you mean touched"):
        vc.Grid(nx=4, ny=4, edge="touch")
    refused(lambda: vc.Grid(nx=4, ny=4, edge=1), match=r"grid\.edge")
    own = TOUCHED.spread((-1.2, 1.2, -0.9, 0.9))
    for grid in (
        own.extended(),
        own.scaled(2.0),
        vc.Grid(nx=4, edge="touched").spread((-1, 1, 0, 0)),
    ):
        assert grid.edge == "touched"
