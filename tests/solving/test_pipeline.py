"""How solvers are put together: refined, polished, with another to fall back on."""

import dataclasses

import numpy as np
import pytest

import varcontact as vc
from varcontact.discrete.discretisation import discretise
from varcontact.discrete.problems import RawSolution
from varcontact.discrete.residuals import tangential_residual
from varcontact.discrete.state import hertz_pressure, unloaded
from varcontact.solvers.interface import Settings, counted
from varcontact.solvers.registry import tangential_solver
from varcontact.solvers.splitting import refine_tangential
from varcontact.solving.pipeline import refined, unless_all_sticks, with_fallback

CELLS = vc.Grid(nx=8, ny=8)


def problem_of(scene):
    """The tangential problem under Hertz's pressure."""
    disc = discretise(scene, vc.solve(dataclasses.replace(scene, motion=None, friction=None)).grid)
    return disc.tangential_problem(hertz_pressure(disc, unloaded(disc.grid)).pressure)


def gives_up(problem, settings, start):
    """Active sets that bring nothing."""
    return RawSolution(np.zeros_like(problem.rigid_shift), np.zeros(2), 7, "MaxIterations", solved=False)


def calls(settings):
    return {name: (each.count, each.iterations) for name, each in settings.stats.calls[""].items()}


@pytest.mark.parametrize("motion", [vc.Steady(vx=0.05, spin=0.1), vc.Shift(Fx=0.1, rotation=0.1)])
def test_the_program_where_active_sets_fail(rolling, motion):
    """From nothing that active sets brought, the fallback has the answer; all who were asked are counted."""
    problem, settings = problem_of(rolling(motion=motion, grid=CELLS)), Settings(1e-8)
    raw = with_fallback(counted("tang", gives_up), "clarabel")(problem, settings, None)
    assert tangential_residual(problem, raw.traction, raw.rigid) < 1e-12
    assert raw.solver == "tang-safeguarded"
    assert raw.reason == "tang missed the tolerance, clarabel was used"
    counted_calls = calls(settings)
    assert list(counted_calls) == ["tang", "clarabel", "tang-safeguarded"]
    assert counted_calls["tang"] == (1, 7)
    assert counted_calls["clarabel"] == (1, raw.iterations)


def test_no_program_where_active_sets_succeed(rolling):
    problem, settings = problem_of(rolling(grid=CELLS)), Settings(1e-8)
    raw = with_fallback(tangential_solver("tang-safeguarded"), "clarabel")(problem, settings, None)
    assert (raw.solver, raw.reason) == ("tang-safeguarded", "")
    assert list(calls(settings)) == ["tang-safeguarded"]


def test_no_fallback_where_the_gap_is_not_convex(rolling):
    """Active sets keep their answer, whatever it is: there is no convex program to ask."""
    a, b = np.sqrt(5), 1 / np.sqrt(5)
    motion = vc.Steady(vx=0.04, vy=-0.02, spin=0.05, dq=0.4 * 2 * a / 8)
    problem, settings = problem_of(rolling(surface=vc.Ellipse(a=a, b=b), motion=motion, grid=CELLS)), Settings(1e-8)
    raw = with_fallback(counted("tang", gives_up), "clarabel")(problem, settings, None)
    assert (raw.solver, raw.status) == ("tang", "MaxIterations")
    assert calls(settings) == {"tang": (1, 7)}


def test_a_better_answer_is_asked_for_where_refinement_does_not_do(rolling):
    """A solver whose first answer is far away, and a refinement of few rounds: asked again, for more."""
    problem, settings, clarabel = problem_of(rolling(grid=CELLS)), Settings(1e-9), tangential_solver("clarabel")
    asked = []

    def far(problem, settings, start):
        asked.append(settings.tol)
        return clarabel(problem, settings, start) if len(asked) > 1 else gives_up(problem, settings, start)

    def little(problem, settings, start):
        near = start.status != "MaxIterations"
        return refine_tangential(problem, settings, start) if near else start

    raw = refined(far, counted("splitting", little), tangential_residual)(problem, settings, None)
    assert asked == [1e-6, 1e-8]
    assert raw.solver == "splitting"
    assert tangential_residual(problem, raw.traction, raw.rigid) <= 1e-9


def test_refinement_never_spoils_an_answer(rolling):
    """The better of both is kept, and says whose it is."""
    problem, settings = problem_of(rolling(grid=CELLS)), Settings(1e-30)
    spoilt = counted("splitting", gives_up)
    raw = refined(tangential_solver("clarabel"), spoilt, tangential_residual)(problem, settings, None)
    assert raw.solver == "clarabel"
    assert tangential_residual(problem, raw.traction, raw.rigid) < 1e-6


def test_nothing_is_called_where_friction_is_nowhere_exhausted(rolling):
    problem, settings = problem_of(rolling(motion=vc.Shift(ux=1e-3), friction=1e3, grid=CELLS)), Settings(1e-8)
    raw = unless_all_sticks(gives_up)(problem, settings, None)
    assert raw.solver == "no-slip"
    assert tangential_residual(problem, raw.traction, raw.rigid) < 1e-12
    assert calls(settings) == {"no-slip": (1, 1)}
