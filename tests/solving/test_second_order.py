"""The discretisation for forces on coarse grids: a slip difference of second order, and softened
edges.
"""

import dataclasses

import numpy as np
import pytest

import varcontact as vc
from tests.scenes import carters_cylinders, make_scene
from tests.steady_forces import forces, read, scene
from varcontact.discrete.discretisation import discretise
from varcontact.discrete.edge_compliance import edge_compliance
from varcontact.transports import DIFFERENCES


def errors(every, cells, second_order=True):
    """Largest errors of Fx, Fy, Mz by f Fz (a b = 1), (scenes,)."""
    found = []
    for numbers, reference in read()[::every]:
        posed = scene(numbers, cells)
        found.append(
            np.abs(forces(posed.second_order() if second_order else posed) - reference).max()
        )
    return np.array(found)


def test_differences_are_consistent():
    """Both are minus the derivative by steps; the second has no error on quadratics either, and a
    symbol Re d >= 0.
    """
    for name, parts in DIFFERENCES.items():
        ahead, weights = np.array(parts).T
        assert weights.sum() == pytest.approx(0, abs=1e-15)
        assert weights @ ahead == pytest.approx(-1, rel=1e-14)
        assert weights @ ahead**2 == pytest.approx(0.0 if name == "second-order" else -1, abs=1e-14)
        wave = np.linspace(0.01, np.pi, 50)
        real = np.cos(np.outer(wave, ahead)) @ weights
        expected = 1 - np.cos(wave) if name == "first-order" else 7 / 12 * (1 - np.cos(wave)) ** 2
        np.testing.assert_allclose(real, expected, rtol=1e-9, atol=1e-14)


def test_leading_element_of_a_half_plane():
    """The weights 5/12 and 7/12: on tractions like the root of the distance from the edge, the
    first row is exact.
    """

    def strip(x):
        ends = np.array([x + 0.5, x - 0.5])
        first, second = ends * np.log(np.where(ends == 0, 1.0, np.abs(ends))) - ends
        return second - first

    def left(parts, cells=2000):
        edges, R = -np.arange(cells + 1.0), cells / 2
        angle = np.arcsin(np.clip((edges + R) / R, -1, 1))
        means = -np.diff(R**2 / 2 * (angle + np.sin(2 * angle) / 2))
        elements = (edges[1:] + edges[:-1]) / 2
        moved = sum(weight * strip(-0.5 + ahead - elements) for ahead, weight in parts) @ means
        return (moved - np.pi * (R - 0.5)) / np.sqrt(cells)

    assert abs(left(DIFFERENCES["first-order"])) > 0.5
    assert abs(left(DIFFERENCES["second-order"])) < 0.01


def test_softening_is_in_the_matrix(rolling):
    """On the diagonal, of elements that are cut; the same by the matrix, by FFT, and from half a
    problem.
    """
    posed = rolling(grid=vc.Grid(nx=12, ny=12)).second_order()
    disc = discretise(posed, posed.grid.spread((-1.2, 1.2, -0.9, 0.9)))
    problem = disc.tangential_problem(disc.hertz.on_elements(disc.grid))
    operator, plain = problem.operator, problem.operator.grid_operator.on(problem.operator.elements)
    extra = operator.matrix - plain.matrix
    np.testing.assert_allclose(np.diag(extra), operator.softening.ravel())
    assert not (extra - np.diag(np.diag(extra))).any()
    covered = disc.hertz.covered(*disc.grid.lines).ravel()[operator.elements]
    assert ((operator.softening > 0) == (covered < 1)).all()
    traction = np.random.default_rng(0).normal(size=(2, problem.size))
    np.testing.assert_allclose(
        operator.apply(traction).ravel(), operator.matrix @ traction.ravel(), rtol=1e-11, atol=1e-13
    )
    np.testing.assert_allclose(
        edge_compliance(np.array([1.0, 0.3, 0.0]))[[0, 1]], [0, edge_compliance(np.array([0.0]))[0]]
    )


@pytest.mark.long
def test_errors_are_below_those_of_centres():
    """Ten scenes with 12 and 24 cells: below stated ones, of an order well above one; centres have
    over three times.
    """
    coarse, fine = errors(4, 12), errors(4, 24)
    assert np.median(coarse) < 0.006
    assert coarse.max() < 0.015
    assert fine.max() < 0.006
    assert np.log2(np.median(coarse) / np.median(fine)) > 1.3
    assert np.median(errors(4, 24, second_order=False)) > 3 * np.median(fine)


def no_slip(ratio, cells):
    """Discrete C11, C22, C23, -C32, C33 of an ellipse with nu = 0."""
    a, b = ratio**0.5, ratio**-0.5
    grid = vc.Grid(nx=cells, ny=cells).spread((-a, a, -b, b))
    posed = make_scene(
        vc.Ellipse(a, b), 1.0, vc.Steady(), grid, np.inf, vc.Bodies(G=1.0, nu=0.0)
    ).second_order()
    units = [
        dataclasses.replace(posed.motion, vx=vx, vy=vy, spin=spin) for vx, vy, spin in np.eye(3)
    ]
    solved = [vc.solve(dataclasses.replace(posed, motion=unit), certify="none") for unit in units]
    F = np.array([[*sol.force, sol.moment] for sol in solved]).T
    return -np.array([F[0, 0], F[1, 1], F[1, 2], -F[2, 1], F[2, 2]])


@pytest.mark.parametrize("ratio", [0.2, 1.0])
def test_creepage_coefficients(paper_table, ratio):
    """Within 2.5 % of Table 3, which has three digits, and C23 = -C32 to rounding."""
    row = next(
        row for row in paper_table("table3_creepage_coefficients.csv") if row["a_over_b"] == ratio
    )
    found = no_slip(ratio, 24)
    expected = [row["C11_nu0"], row["C22_nu0"], row["C23_nu0"], row["C23_nu0"], row["C33_nu0"]]
    np.testing.assert_allclose(found, expected, rtol=0.025)
    assert found[2] == pytest.approx(found[3], rel=1e-10)


def test_carter():
    """Line contact: less than a fifth of the error of centres."""
    (exact, cylinders), found = carters_cylinders(), {}
    for second_order in (False, True):
        for n in (20, 40, 80):
            posed = dataclasses.replace(cylinders, grid=vc.Grid(nx=n))
            sol = vc.solve(posed.second_order() if second_order else posed)
            found[second_order, n] = abs(sol.force[0] / exact.force - 1)
    assert all(found[True, n] < found[False, n] / 5 for n in (20, 40, 80))


def test_computed_pressures():
    """Unlike bodies: the difference alone, elements by their centres. Limits from 96 and 192 cells,
    to 5e-4.
    """
    limit = np.array([-0.5604, -0.0901, -0.1865])
    motion, bodies = (
        vc.Steady(vx=0.02, vy=-0.015, spin=0.04),
        vc.Bodies(G=(1.0, 3.0), nu=(0.25, 0.3)),
    )
    posed = make_scene(vc.Ellipse(a=1.2, b=0.9), 1.0, motion, vc.Grid(nx=24, ny=24), bodies=bodies)
    off = []
    for each in (posed, posed.second_order()):
        sol = vc.solve(each, certify="none", tol=1e-5)
        off.append(np.abs(np.array([*sol.force, sol.moment]) / 0.3 - limit).max())
    assert off[0] > 0.01
    assert off[1] < 0.005


def test_mirror_and_direction(rolling):
    numbers = {"vx": 0.04, "vy": -0.02, "spin": 0.05}
    sol = vc.solve(rolling(motion=vc.Steady(**numbers)).second_order())
    mirrored = vc.solve(rolling(motion=vc.Steady(vx=0.04, vy=0.02, spin=-0.05)).second_order())
    np.testing.assert_allclose(mirrored.force, sol.force * [1, -1], rtol=1e-9)
    assert mirrored.moment == pytest.approx(-sol.moment, rel=1e-9)
    against = vc.solve(
        rolling(
            motion=vc.Steady(**{name: -value for name, value in numbers.items()})
        ).second_order()
    )
    np.testing.assert_allclose(against.force, -sol.force, rtol=1e-9)


def test_sensitivity(rolling):
    posed = rolling().second_order()
    slope, step = np.asarray(vc.solve(posed).sensitivity())[0, 0], 1e-6
    moved = [dataclasses.replace(posed.motion, vx=0.04 + s) for s in (-step, step)]
    ends = [vc.solve(dataclasses.replace(posed, motion=motion)).force[0] for motion in moved]
    assert slope == pytest.approx((ends[1] - ends[0]) / (2 * step), rel=1e-4)


def test_the_preset(rolling):
    posed = rolling(motion=vc.Steady(vx=0.01)).second_order()
    assert posed.motion == vc.Steady(vx=0.01, slip_difference="second-order")
    assert posed.grid.edge == "softened"
    unlike = rolling(bodies=vc.Bodies(G=(1.0, 2.0), nu=(0.2, 0.3))).second_order()
    assert (unlike.grid.edge, unlike.motion.slip_difference) == ("centres", "second-order")
    assert vc.solve(unlike).certificate.residual < 1e-8


def test_refused(rolling):
    with pytest.raises(vc.SceneError, match=r"motion\.slip_difference.*did you mean second-order"):
        vc.Steady(slip_difference="second-ordre")
    with pytest.raises(vc.SceneError, match="in a history of steps"):
        rolling(motion=vc.Transient(steps=2, vx=0.01), grid=vc.Grid(nx=8, ny=8, edge="softened"))
    with pytest.raises(vc.SceneError, match="only its slip is a difference in space"):
        rolling(motion=vc.Shift(ux=0.01)).second_order()
    with pytest.raises(vc.SceneError, match='"auto" or "gap" with motion'):
        vc.solve(rolling().second_order(), formulation="marching")
    unlike = rolling(
        bodies=vc.Bodies(G=(1.0, 3.0), nu=(0.25, 0.3)), grid=vc.Grid(nx=8, ny=8, edge="softened")
    )
    with pytest.raises(
        vc.SceneError,
        match=r'grid\.edge = "softened" is for a pressure that tractions do not change',
    ):
        vc.solve(unlike)
