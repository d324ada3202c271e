"""U and C of a solution's problems: equal there, apart by the gap elsewhere, and one above the
other everywhere.
"""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import varcontact as vc
from varcontact.energy import (
    complementary_energy,
    gap,
    normal_gap,
    normal_residual,
    posed,
    potential_energy,
    tangential_residual,
)
from varcontact.interfaces.potential import project

LOADS = {
    "force": {"normal_force": 1e-2},
    "approach": {"normal_force": None, "approach": 0.04},
    "unlike bodies": {
        "normal_force": 1e-2,
        "bodies": vc.Bodies(G=(1.0, 3.0), nu=(0.3, 0.1)),
        "motion": vc.Shift(ux=1e-3),
    },
}
MOTIONS = {
    "shift": vc.Shift(ux=0.1, uy=0.05, rotation=0.1),
    "shift by a force": vc.Shift(Fx=-0.2, uy=0.02),
}


@pytest.fixture(scope="module", params=LOADS)
def pressed(request, rolling):
    """A normal problem, solved on the grid, and its solution."""
    base = {
        "surface": vc.Paraboloids(1.0, 0.7),
        "motion": None,
        "friction": None,
        "grid": vc.Grid(nx=14, ny=14),
    }
    changes = base | LOADS[request.param]
    if changes["motion"] is not None:
        changes["friction"] = 0.3
    sol = vc.solve(rolling(**changes), normal="norm", tol=1e-11)
    return sol, posed(sol)


@pytest.fixture(scope="module", params=MOTIONS)
def shifted(request, rolling):
    sol = vc.solve(rolling(motion=MOTIONS[request.param]))
    return sol, posed(sol)


def test_normal_energies_are_equal_at_the_solution(pressed):
    """U = C, and both are the work that pressing takes: in physical units, from the solution's own
    fields.
    """
    sol, problem = pressed
    U = potential_energy(problem.normal, problem.pressure)
    C = complementary_energy(problem.normal, problem.pressure)
    assert U == pytest.approx(C, rel=1e-11)
    assert normal_residual(problem.normal, problem.pressure, problem.approach) < 1e-11
    y, x = np.meshgrid(sol.grid.y, sol.grid.x, indexing="ij")
    undeformed = x**2 / 2 + y**2 / 1.4
    stored = 0.5 * np.sum(sol.pressure * (sol.distance - undeformed + sol.approach)) * sol.grid.area
    if sol.scene.bodies.K == 0:  # the distance has the displacement by tractions in it
        base = undeformed.min()
        work = 0.0 if sol.scene.approach is not None else sol.normal_force * (sol.approach - base)
        assert problem.unit * U == pytest.approx(stored - work, rel=1e-10)


@settings(max_examples=25)
@given(seed=st.integers(0, 2**32 - 1), size=st.floats(-6, 0))
def test_normal_energies_elsewhere(pressed, seed, size):
    """Any other pressures of the same force have less C; with admissible displacements more U; U -
    C is the gap.
    """
    _, problem = pressed
    normal, exact = problem.normal, problem.pressure
    noise = np.random.default_rng(seed).normal(size=exact.shape)
    pressure = np.maximum(exact + 10**size * exact.max() * noise * (exact > 0), 0.0)
    if normal.force is not None:
        pressure *= normal.force / (pressure.sum() * normal.area)
    C, best = complementary_energy(normal, pressure), complementary_energy(normal, exact)
    slack = 1e-12 * abs(best)
    assert C <= best + slack
    if normal.force is not None:
        U = potential_energy(normal, pressure)
        assert U >= best - slack
        assert U - C == pytest.approx(
            normal_gap(normal, pressure, problem.approach)[0], rel=1e-9, abs=slack
        )
    else:
        overlap = float(
            np.max(normal.approach - normal.distance - normal.operator.apply(pressure[None])[0])
        )
        raised = pressure + max(overlap, 0.0) / float(
            normal.operator.apply(np.ones((1, pressure.size))).min()
        )
        assert potential_energy(normal, raised) >= best - slack


def test_tangential_energies_are_equal_at_the_solution(shifted):
    _, problem = shifted
    U = potential_energy(problem.tangential, problem.traction, problem.rigid)
    C = complementary_energy(problem.tangential, problem.traction)
    assert U == pytest.approx(C, rel=1e-10)
    assert tangential_residual(problem.tangential, problem.traction, problem.rigid) < 1e-10
    worse = project(0.9 * problem.traction, problem.tangential.bound)
    if not problem.tangential.free:
        apart = potential_energy(problem.tangential, worse) - complementary_energy(
            problem.tangential, worse
        )
        assert apart == pytest.approx(gap(problem.tangential, worse, problem.rigid)[0], rel=1e-9)
        assert apart > 1e-4 * abs(C)


@settings(max_examples=25)
@given(seed=st.integers(0, 2**32 - 1), size=st.floats(-6, 0))
def test_tangential_energies_elsewhere(shifted, seed, size):
    """Tractions of the same force, within their bound: less C, more U, and the gap between them."""
    _, problem = shifted
    tangential, exact = problem.tangential, problem.traction
    noise = np.random.default_rng(seed).normal(size=exact.shape)
    traction = project(exact + 10**size * tangential.bound * noise, tangential.bound)
    for i in tangential.free:  # evenly, until the force is the prescribed one
        missing = tangential.force[i] / tangential.area - traction[i].sum()
        traction[i] += missing / traction[i].size
    inside = bool(np.all(np.hypot(*traction) <= tangential.bound))
    C, U = (
        complementary_energy(tangential, traction),
        potential_energy(tangential, traction, problem.rigid),
    )
    best = complementary_energy(tangential, exact)
    slack = 1e-12 * abs(best)
    assert U >= best - slack
    if inside:
        assert C <= best + slack
    if not tangential.free:
        assert U - C == pytest.approx(
            gap(tangential, traction, problem.rigid)[0], rel=1e-9, abs=slack
        )


def test_the_energy_of_infinite_friction_is_elastic(rolling):
    problem = posed(vc.solve(rolling(friction=np.inf, motion=vc.Shift(ux=0.1, rotation=0.05))))
    U = potential_energy(problem.tangential, problem.traction)
    assert U == pytest.approx(complementary_energy(problem.tangential, problem.traction), rel=1e-10)


def test_posed_closes_the_gap_of_every_kind(rolling):
    """Steady rolling under a force, a law of friction, unlike bodies: what was found is put back
    where it belongs.
    """
    law = vc.StaticKinetic(0.3, 0.2)
    unlike = {
        "bodies": vc.Bodies(G=(1.0, 3.0), nu=0.3),
        "surface": vc.Paraboloids(1.0, 1.0),
        "normal_force": 1e-2,
    }
    for changes in ({"motion": vc.Steady(Fx=-0.1, spin=0.1)}, {"friction": law}, unlike):
        sol = vc.solve(rolling(**changes))
        problem = posed(sol)
        absolute, relative = gap(problem.tangential, problem.traction, problem.rigid)
        assert 0 <= relative < 1e-9
        assert absolute * problem.unit == pytest.approx(
            sol.certificate.gap, rel=1e-6, abs=1e-12 * problem.unit
        )
        with pytest.raises(vc.SceneError, match=r"others have a gap, and no energy"):
            potential_energy(problem.tangential, problem.traction)
        with pytest.raises(vc.SceneError, match="others have a gap"):
            complementary_energy(problem.tangential, problem.traction)


def test_nothing_tangential(rolling):
    assert posed(vc.solve(rolling(motion=None, friction=None))).tangential is None
    assert posed(vc.solve(rolling(friction=0.0))).tangential is None


def test_what_has_no_problems_is_refused(rolling):
    with pytest.raises(vc.SceneError, match="solution = 3 is not allowed: must be a Solution"):
        posed(3)
    scene = rolling(surface=vc.Paraboloids(1.0, 1.0), motion=vc.Transient(steps=1, dq=0.1))
    with pytest.raises(vc.SceneError, match=r"solution = .a step of a history. .* one of steady"):
        posed(vc.solve(scene)[0])
