"""From a scene to its dimensionless problems: what the mesh and the step may be."""

from dataclasses import replace

import numpy as np
import pytest

import varcontact as vc
from tests.scenes import refused
from varcontact.discrete import problems as symmetry
from varcontact.discrete.discretisation import discretise
from varcontact.discrete.problems import mirror_of
from varcontact.discrete.state import hertz_pressure, unloaded


def tangential_problem(rolling, ratio, part, nu=0.28, motion=vc.Steady, cells=10):
    """The problem of an ellipse meshed with elements of dx/dy = ratio, in steps of `part`
    elements.
    """
    a, b = np.sqrt(ratio), 1 / np.sqrt(ratio)
    given = {"vx": 0.04, "dq": part * 2 * a / cells} if motion is vc.Steady else {"ux": 0.04}
    scene = rolling(
        bodies=vc.Bodies(G=1.0, nu=nu), surface=vc.Ellipse(a=a, b=b), motion=motion(**given)
    )
    grid = vc.Grid(nx=cells, ny=cells).spread((-a, a, -b, b))
    disc = discretise(scene, grid)
    return disc.tangential_problem(hertz_pressure(disc, unloaded(grid)).pressure)


@pytest.mark.parametrize(("ratio", "part", "nu", "monotone"), [
    (1, 0.1, 0.28, True),
    (3, 0.3, 0.28, False),
    (3, 0.5, 0.28, True),
    (10, 0.1, 0.28, False),
    (10, 0.1, 0.0, True),
    (10, 0.5, 0.5, False),
    (10, 0.7, 0.5, True),
    (10, 1.0, 0.5, True),
])  # fmt: skip
def test_monotone_tells_the_sign_of_the_symmetric_part(rolling, ratio, part, nu, monotone):
    problem = tangential_problem(rolling, ratio, part, nu)
    matrix = problem.operator.matrix
    least = np.linalg.eigvalsh(matrix + matrix.T)[0]
    assert (least > 0) is np.bool_(monotone)
    assert (problem.symmetric_part is not None) is monotone


def test_a_shift_is_always_monotone(rolling):
    assert tangential_problem(rolling, 10, 1.0, nu=0.5, motion=vc.Shift).symmetric_part is not None


def test_the_approach_is_prescribed_or_the_mean_where_the_pressure_acts(rolling):
    """Of a pressure that solves the problem it is the answer's own."""
    scene = rolling(
        surface=vc.Paraboloids(Rx=1.0, Ry=1.0),
        normal_force=1e-3,
        grid=vc.Grid(nx=8, ny=8, dx=0.04, dy=0.04, x0=-0.16, y0=-0.16),
    )
    sol = vc.solve(scene, normal="norm")
    disc = discretise(scene, sol.grid)
    problem = disc.normal_problem(None)
    pressure = sol.pressure.ravel() / disc.scales.pressure
    found = problem.mean_approach(pressure) * disc.scales.displacement + disc.base
    assert found == pytest.approx(sol.approach, rel=1e-6)
    assert problem.mean_approach(0 * pressure) == 0
    assert replace(problem, force=None, approach=0.7).mean_approach(pressure) == 0.7


@pytest.mark.parametrize("part", [0.99e-6, 1e-9, 1e-30])
def test_steps_too_short_for_floating_point_are_refused(rolling, part):
    """A - C is a difference: of a step of 1e-9 elements nothing is left but rounding."""
    posed = rolling(motion=vc.Steady(vx=0.04, dq=part * 0.2))
    refused(lambda: vc.solve(posed), "motion.dq", "at least 1e-06 of the element's dx, 0.2")


@pytest.mark.parametrize("normal", ["hertz", "clarabel"])
@pytest.mark.parametrize(
    "lattice",
    [
        {"nx": 3, "ny": 3, "dx": 10.0, "dy": 10.0, "x0": -15.0, "y0": -15.0},
        {"nx": 13, "ny": 1, "dx": 0.2, "dy": 10.0, "x0": -1.3, "y0": -5.0},
    ],
)
def test_elements_larger_than_the_contact_are_refused(rolling, lattice, normal):
    """One element's centre lies in the ellipse, but the ellipse is lost in it."""
    refused(
        lambda: vc.solve(rolling(grid=vc.Grid(**lattice)), normal=normal),
        "grid",
        "the contact is 2.4 by 1.8",
    )


def test_distances_count_from_the_lowest_point():
    """The same dimensionless problem, wherever the height is measured from."""
    grid = vc.Grid(nx=8, ny=8, dx=0.1, dy=0.1, x0=-0.4, y0=-0.4)
    bowl = (grid.x[None, :] ** 2 + grid.y[:, None] ** 2) / 2
    scenes = [
        vc.Scene(
            bodies=vc.Bodies(G=1.0, nu=0.3),
            surface=vc.SampledDistance(bowl + c),
            approach=c + 0.05,
            grid=grid,
        )
        for c in (0.0, 1024.0, -1024.0)
    ]
    first, *others = (discretise(scene, grid).normal_problem() for scene in scenes)
    assert first.distance.min() == 0
    for other in others:
        np.testing.assert_allclose(other.distance, first.distance, atol=1e-10)
        assert other.approach == pytest.approx(first.approach, rel=1e-10)


# ---------------- Half of a problem that is its own mirror image has the same solution as the whole


UNLIKE = vc.Bodies(G=(2.0, 0.7), nu=(0.25, 0.4))
MIRRORED = {
    "vx": ({"motion": vc.Steady(vx=0.05)}, {}),
    "vy and spin": ({"motion": vc.Steady(vy=-0.05, spin=0.1)}, {}),
    "Fx": ({"motion": vc.Steady(Fx=-0.15)}, {}),
    "Fy and spin": ({"motion": vc.Steady(Fy=0.1, spin=0.1)}, {}),
    "shift": ({"motion": vc.Shift(ux=0.05)}, {}),
    "shift by Fy": ({"motion": vc.Shift(Fy=0.1, rotation=0.1)}, {"formulation": "potential"}),
    "no slip": ({"motion": vc.Steady(vx=0.05), "friction": np.inf}, {}),
    "marching": ({"motion": vc.Steady(vx=0.05)}, {"formulation": "marching"}),
    "tang": ({"motion": vc.Steady(vx=0.05)}, {"tangential": "tang"}),
    "tang-safeguarded": ({"motion": vc.Steady(vx=0.05)}, {"tangential": "tang-safeguarded"}),
    "scs": ({"motion": vc.Steady(vx=0.05)}, {"tangential": "scs"}),
    "unlike": ({"motion": vc.Steady(vx=0.05), "bodies": UNLIKE}, {"method": "active-set"}),
}


def mirrors(monkeypatch):
    """The mirror images, or None, of the tangential problems that are solved from now on."""
    found = []
    monkeypatch.setattr(
        "varcontact.solving.contact_solver.mirror_of",
        lambda problem: found.append(mirror_of(problem)) or found[-1],
    )
    return found


@pytest.mark.parametrize("name", MIRRORED)
def test_half_of_a_problem_has_the_solution_of_the_whole(rolling, monkeypatch, name, check_kkt):
    changes, methods = MIRRORED[name]
    scene = rolling(**changes)
    found = mirrors(monkeypatch)
    half = vc.solve(scene, **methods)
    assert all(found)
    monkeypatch.setattr("varcontact.solving.contact_solver.mirror_of", lambda problem: None)
    whole = vc.solve(scene, **methods)
    largest = np.abs(whole.traction).max()
    np.testing.assert_allclose(half.traction, whole.traction, atol=2e-8 * largest)
    np.testing.assert_allclose(half.creepage, whole.creepage, atol=1e-8)
    check_kkt(half, 1e-8)


FOURTEEN = vc.Grid(nx=14, ny=14, dx=0.2, dy=0.15, x0=-1.4, y0=-1.05)
GRADED = np.linspace(0.2, 0.4, 14)[:, None] * np.ones(14)


@pytest.mark.parametrize("changes", [
    {},  # vx with vy and spin
    {"motion": vc.Steady(vx=0.05, vy=1e-6)},
    {"motion": vc.Steady(Fx=-0.1, Fy=0.0)},
    {"motion": vc.Steady(vx=0.05), "grid": vc.Grid(nx=12, ny=13)},
    {"motion": vc.Steady(vx=0.05), "grid": vc.Grid(nx=14, ny=14, dx=0.2, dy=0.15, x0=-1.4, y0=-1.04)},
    {"motion": vc.Steady(vx=0.05), "friction": GRADED, "grid": FOURTEEN},
    {"motion": vc.Steady(vy=0.05), "bodies": UNLIKE},
    {"surface": vc.Cylinders(R=1.0), "grid": vc.Grid(nx=20), "motion": vc.Steady(vx=0.05)},
])  # fmt: skip
def test_what_is_no_mirror_image_is_solved_whole(rolling, monkeypatch, changes):
    found = mirrors(monkeypatch)
    vc.solve(rolling(**changes))
    assert not any(found)


def test_the_folded_operator_is_the_whole_one_on_mirrored_tractions(rolling):
    """By matrix and by FFT, against the whole matrix on tractions written out on both sides."""
    scene = rolling(motion=vc.Steady(vy=0.05), grid=FOURTEEN)
    disc = discretise(scene, scene.grid)
    pressure = disc.hertz.pressure(disc.grid.x[None, :], disc.grid.y[:, None])
    posed = disc.tangential_problem(pressure)
    mirror = mirror_of(posed)
    assert mirror.signs == (-1.0, 1.0)
    half = np.random.default_rng(1).normal(size=(2, posed.size // 2))
    whole = np.zeros((2, posed.size))
    whole[:, mirror.half], whole[:, mirror.images] = half, half * [[-1.0], [1.0]]
    expected = (posed.operator.matrix @ whole.ravel()).reshape(2, -1)
    np.testing.assert_allclose(
        expected[:, mirror.images], expected[:, mirror.half] * [[-1.0], [1.0]], atol=1e-12
    )
    folded = mirror.fold(posed).operator
    np.testing.assert_allclose(
        (folded.matrix @ half.ravel()).reshape(2, -1), expected[:, mirror.half], atol=1e-12
    )
    np.testing.assert_allclose(folded.apply(half), expected[:, mirror.half], atol=1e-12)
    assert symmetry.mirror_of(mirror.fold(posed)) is None
