"""Line contact against its closed forms, with fitted convergence rates, and against long rows in
three dimensions.
"""

import numpy as np
import pytest

import varcontact as vc
from tests.scenes import make_scene
from varcontact.reference import bufler, carter, cattaneo_line, line_contact

BODIES, R, LOAD, F = vc.Bodies(G=2.0, nu=0.28), 3.0, 0.01, 0.3
HERTZ = line_contact(R, BODIES, force=LOAD)
UNLIKE = vc.Bodies(G=(1.0, np.inf), nu=(0.286, 0.0))
CELLS = np.array([20, 40, 80, 160])


def scene(**changes):
    base = {"bodies": BODIES, "surface": vc.Cylinders(R=R), "normal_force": LOAD, "friction": F}
    return vc.Scene(**(base | changes))


def rate(errors, cells=CELLS):
    """Order of convergence: minus the slope of the line through the logarithms."""
    return -np.polyfit(np.log(cells), np.log(np.abs(errors)), 1)[0]


def distance(field, expected):
    return np.linalg.norm(field - expected) / np.linalg.norm(expected)


def test_hertz():
    """The pressure with order 1 (its edges), approach and force with order 2; the width to half an
    element.
    """
    depth = 50.0
    surface, pressure, approach, force = vc.Cylinders(R=R, reference_depth=depth), [], [], []
    for n in CELLS:
        sol = vc.solve(scene(surface=surface, grid=vc.Grid(nx=n)), normal="clarabel")
        pressure.append(distance(sol.pressure[0], HERTZ.pressure(sol.grid.x)))
        approach.append(sol.approach / HERTZ.approach(depth) - 1)
        assert abs(sol.areas["contact"] / 2 - HERTZ.a) <= sol.grid.sides[0] / 2
        prescribed = {"normal_force": None, "approach": HERTZ.approach(depth)}
        sol = vc.solve(scene(surface=surface, grid=vc.Grid(nx=n), **prescribed), normal="clarabel")
        assert sol.approach == pytest.approx(HERTZ.approach(depth), rel=1e-14)
        force.append(sol.normal_force / LOAD - 1)
    assert rate(pressure) == pytest.approx(1.0, abs=0.02)
    assert rate(approach) == pytest.approx(2.0, abs=0.03)
    assert rate(force) == pytest.approx(2.0, abs=0.03)
    assert pressure[-1] < 0.0015
    assert abs(approach[-1]) < 3e-6


@pytest.mark.parametrize(
    ("given", "orders"), [("creepage", (1.0, 0.95, 0.96)), ("force", (0.99, 0.82, 0.95))]
)
def test_carter(given, orders):
    """Order 1 (in the traction h times a logarithm: its slope ends in a root) where the stick area
    ends at an edge.
    """
    for sign in (-1, 1):
        exact = carter(HERTZ, F, force=0.75 * sign * F * LOAD)  # stick half-width a/2
        motion = vc.Steady(vx=exact.creepage) if given == "creepage" else vc.Steady(Fx=exact.force)
        errors = []
        for n in CELLS:
            sol = vc.solve(scene(motion=motion, grid=vc.Grid(nx=n)))
            x = sol.grid.x
            assert abs(sol.areas["stick"] / 2 - exact.stick_half_width) <= sol.grid.sides[0] / 2
            assert np.abs(sol.traction[1]).max() < 1e-13 * sol.pressure.max()
            found, known = (
                (sol.force[0], exact.force)
                if given == "creepage"
                else (sol.creepage[0], exact.creepage)
            )
            traction = distance(sol.traction[0, 0], exact.traction(x))
            errors.append(
                (
                    abs(found / known - 1),
                    traction,
                    distance(sol.slip[0, 0], np.nan_to_num(exact.slip(x))),
                )
            )
        for column, order in zip(np.transpose(errors), orders, strict=True):
            assert rate(column) == pytest.approx(order, abs=0.02)
            assert np.all(np.diff(np.log2(column)) < -0.75)
        assert errors[-1][0] < 0.0035
        assert errors[-1][1] < 0.0041


@pytest.mark.parametrize(("part", "order"), [(-0.75, 0.92), (0.36, 0.85), (0.51, 0.88)])
def test_cattaneo(part, order):
    """Order 1 in the traction (times a logarithm), 1.5 in the slip, where the stick area ends at
    edges of elements.
    """
    exact, traction, slip = cattaneo_line(HERTZ, F, part * F * LOAD), [], []
    for n in CELLS:
        sol = vc.solve(scene(motion=vc.Shift(Fx=exact.force), grid=vc.Grid(nx=n)))
        traction.append(distance(sol.traction[0, 0], exact.traction(sol.grid.x)))
        slip.append(distance(sol.slip[0, 0], np.nan_to_num(exact.slip(sol.grid.x))))
        assert sol.areas["stick"] / 2 == pytest.approx(exact.stick_half_width, rel=1e-9)
        assert np.isnan(sol.creepage[0]), "without a reference depth the rigid shift is open"
        np.testing.assert_allclose(
            sol.traction[0], sol.traction[0, :, ::-1], atol=1e-12 * sol.pressure.max()
        )
    assert rate(traction) == pytest.approx(order, abs=0.02)
    assert rate(slip) == pytest.approx(1.46, abs=0.03)
    assert traction[-1] < 0.003
    assert slip[-1] < 0.003


def test_bufler():
    """No slip between unlike cylinders: the creepage, pressure and traction, on grids that fit the
    contact.
    """
    exact, creepage, pressure, traction = bufler(100.0, UNLIKE, a=1.0), [], [], []
    for n in CELLS:
        dx = 2 / n
        grid = vc.Grid(nx=n + 10, dx=dx, x0=-1 - 5 * dx)
        sol = vc.solve(
            make_scene(vc.Cylinders(R=100.0), exact.force, vc.Steady(Fx=0.0), grid, np.inf, UNLIKE)
        )
        assert sol.elements == {"contact": n, "stick": n, "slip": 0}
        assert abs(sol.force[0]) < 1e-9 * exact.force
        creepage.append(sol.creepage[0] / exact.creepage - 1)
        pressure.append(distance(sol.pressure[0], exact.pressure(sol.grid.x)))
        traction.append(distance(sol.traction[0, 0], exact.traction(sol.grid.x)))
    assert rate(creepage) == pytest.approx(0.75, abs=0.03)
    assert rate(pressure) == pytest.approx(0.77, abs=0.04)
    assert rate(traction) == pytest.approx(0.61, abs=0.06)
    assert np.all(np.diff(np.log(np.abs(creepage))) < -0.49)
    assert abs(creepage[-1]) < 0.0125
    assert pressure[-1] < 0.0035


def test_flat_punch():
    """p = P/(pi sqrt(a^2 - x^2)) between sharp edges, in the middle with order 1."""
    errors, cells = [], np.array([11, 21, 41, 81])
    for n in cells:
        dx = 2 / n
        grid = vc.Grid(nx=n + 8, dx=dx, x0=-1 - 4 * dx)
        surface = vc.SampledDistance(np.where(np.abs(grid.x) < 1, 0.0, 1e3))
        sol = vc.solve(vc.Scene(bodies=BODIES, surface=surface, normal_force=LOAD, grid=grid))
        assert sol.elements["contact"] == n
        errors.append(sol.pressure[0, (n + 8) // 2] * np.pi / LOAD - 1)
        inner = np.abs(grid.x) < 0.8
        exact = LOAD / np.pi / np.sqrt(1 - grid.x[inner] ** 2)
        np.testing.assert_allclose(sol.pressure[0, inner], exact, rtol=1 / n)
    assert rate(errors, cells) == pytest.approx(0.97, abs=0.03)


def test_a_long_thin_row_in_three_dimensions_is_line_contact():
    """Elements L half-widths long: normal and tangential tractions and creepages tend to line
    contact.
    """
    for bodies, order in ((vc.Bodies(G=1.0, nu=0.28), 2), (UNLIKE, 1)):
        a, n = line_contact(1.0, bodies, force=1.0).a, 32
        dx = 2.4 * a / n
        strips, motion = vc.Grid(nx=n, dx=dx, x0=-1.2 * a), vc.Steady(Fx=-0.15, Fy=0.1)
        line = vc.solve(
            make_scene(vc.Cylinders(R=1.0), 1.0, motion, strips, bodies=bodies), normal="clarabel"
        )
        errors = []
        for length in (1e2 * a, 1e3 * a):
            grid = vc.Grid(nx=n, ny=3, dx=dx, dy=length, x0=-1.2 * a, y0=-1.5 * length)
            h = np.tile(grid.x**2 / 2, (3, 1))
            h[[0, 2]] = 1e9  # the bodies end
            motion = vc.Steady(Fx=-0.15 * length, Fy=0.1 * length)
            row = vc.solve(make_scene(vc.SampledDistance(h), length, motion, grid, bodies=bodies))
            peak = line.pressure.max()
            errors.append(
                [
                    np.abs(row.pressure[1] - line.pressure[0]).max() / peak,
                    np.abs(row.traction[:, 1] - line.traction[:, 0]).max() / peak,
                    abs(row.creepage[0] / line.creepage[0] - 1),
                ]
            )
        np.testing.assert_allclose(
            np.log10(np.array(errors[0]) / errors[1]), order, atol=0.05, err_msg=str(errors)
        )
        assert max(errors[1]) < 0.004
