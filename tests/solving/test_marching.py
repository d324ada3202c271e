"""Marching: transient steps until nothing changes, against the gap program."""

import dataclasses

import numpy as np
import pytest

import varcontact as vc
from varcontact.discrete.problems import RawSolution
from varcontact.solving.pipeline import march

GRID = vc.Grid(nx=8, ny=8)
MOTIONS = [vc.Steady(vx=0.05, vy=-0.02, spin=0.03), vc.Steady(Fx=-0.15, vy=-0.02), vc.Steady(Fx=-0.1, Fy=0.1)]


@pytest.mark.parametrize("motion", MOTIONS)
@pytest.mark.parametrize("inner", ["tang", "tang-exact", "tang-safeguarded"])
def test_exact_steps_tend_to_the_gap_solution(rolling, check_kkt, inner, motion):
    """Unpolished, at the tolerance asked for: the end of the march is accepted by the residual of steady rolling."""
    gap = vc.solve(rolling(motion=motion, grid=GRID), formulation="gap")
    for tol in (1e-5, 1e-8):
        sol = vc.solve(rolling(motion=motion, grid=GRID), tangential=inner, formulation="marching", tol=tol)
        assert sol.status["tangential"] == "Steady"
        assert sol.plan.formulation == "marching"
        check_kkt(sol, tol)
        # The rest of a geometric row of steps: its sum is a few times its last term.
        assert np.abs(sol.traction - gap.traction).max() < 30 * tol * gap.traction_bound.max()
        assert sol.creepage == pytest.approx(gap.creepage, rel=100 * tol)


@pytest.mark.parametrize("inner", ["clarabel", "scs"])
def test_programs_tend_to_the_gap_solution(rolling, inner):
    scene = rolling(motion=MOTIONS[0], grid=GRID)
    gap = vc.solve(scene, formulation="gap")
    try:
        sol = vc.solve(scene, tangential=inner, formulation="marching", polish=False, tol=1e-5)
    except vc.NotConverged as error:
        sol = error.solution
    assert sol.status["tangential"] == "Steady"
    assert np.abs(sol.traction - gap.traction).max() < 1e-3 * gap.traction_bound.max()
    polished = vc.solve(scene, tangential=inner, formulation="marching")
    np.testing.assert_allclose(polished.traction, gap.traction, atol=1e-12)


def test_a_solver_that_fails_is_not_taken_for_a_steady_state(rolling):
    """One that leaves its start as it is changes nothing: its own word stands, and not "Steady"."""
    from varcontact.discrete.discretisation import discretise
    from varcontact.discrete.state import hertz_pressure, unloaded
    from varcontact.solvers.interface import Settings

    grid = GRID.spread((-1.2, 1.2, -0.9, 0.9))
    disc = discretise(rolling(), grid)
    problem = disc.tangential_problem(hertz_pressure(disc, unloaded(grid)).pressure, marching=True)

    def lazy(step, settings, start):
        return dataclasses.replace(start, status="Tired", solved=False)

    def broken(step, settings, start):
        return RawSolution(np.full((2, step.size), np.nan), np.zeros(2), 1, "Lost", False)

    raw = march(lazy, problem, Settings(), None)
    assert raw.status == "Tired" and not raw.solved
    raw = march(broken, problem, Settings(), None)
    assert raw.status == "Lost" and not raw.solved
    assert np.isfinite(raw.traction).all()
