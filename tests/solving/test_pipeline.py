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
from varcontact.solving import pipeline
from varcontact.solving.pipeline import solve_tangential
from varcontact.solving.selection import select

CELLS = vc.Grid(nx=8, ny=8)


def problem_of(scene):
    """The tangential problem under Hertz's pressure."""
    disc = discretise(scene, vc.solve(dataclasses.replace(scene, motion=None, friction=None)).grid)
    return disc.tangential_problem(hertz_pressure(disc, unloaded(disc.grid)).pressure)


def gives_up(problem, settings, start):
    """A solver that brings nothing."""
    return RawSolution(np.zeros_like(problem.rigid_shift), np.zeros(2), 7, "MaxIterations", solved=False)


@pytest.fixture
def replaced(monkeypatch):
    """A function: put solvers of the tangential problem in the place of those of these names."""

    def replace(**solvers):
        known = {name.replace("_", "-"): counted(name.replace("_", "-"), each) for name, each in solvers.items()}
        monkeypatch.setattr(pipeline, "tangential_solver", lambda name: known.get(name) or tangential_solver(name))

    return replace


def solved(scene, tol=1e-8, polish=True, **methods):
    """The tangential problem under Hertz's pressure, solved: problem, answer, and (count, iterations) of solvers."""
    problem, plan = problem_of(scene), select(scene, **methods)
    settings = Settings(tol, plan.formulation)
    raw = solve_tangential(problem, plan, polish, settings, None)
    calls = {name: (each.count, each.iterations) for name, each in settings.stats.calls[""].items()}
    return problem, raw, calls


@pytest.mark.parametrize("motion", [vc.Steady(vx=0.05, spin=0.1), vc.Shift(Fx=0.1, rotation=0.1)])
def test_the_program_where_active_sets_fail(rolling, replaced, motion):
    """From nothing that active sets brought, the fallback has the answer; all who were asked are counted."""
    replaced(tang_safeguarded=gives_up)
    problem, raw, calls = solved(rolling(motion=motion, grid=CELLS))
    assert tangential_residual(problem, raw.traction, raw.rigid) < 1e-12
    assert raw.solver == "tang-safeguarded"
    assert raw.reason == "tang-safeguarded missed the tolerance, clarabel was used"
    assert list(calls) == ["tang-safeguarded", "clarabel"]
    assert calls["clarabel"] == (1, raw.iterations)


def test_no_program_where_active_sets_succeed(rolling):
    _, raw, calls = solved(rolling(grid=CELLS))
    assert (raw.solver, raw.reason) == ("tang-safeguarded", "")
    assert list(calls) == ["tang-safeguarded"]


def test_no_fallback_where_the_gap_is_not_convex(rolling, replaced):
    """Active sets keep their answer, whatever it is: there is no convex program to ask."""
    replaced(tang_safeguarded=gives_up)
    a, b = np.sqrt(5), 1 / np.sqrt(5)
    motion = vc.Steady(vx=0.04, vy=-0.02, spin=0.05, dq=0.4 * 2 * a / 8)
    _, raw, calls = solved(rolling(surface=vc.Ellipse(a=a, b=b), motion=motion, grid=CELLS))
    assert (raw.solver, raw.status) == ("tang-safeguarded", "MaxIterations")
    assert calls == {"tang-safeguarded": (1, 7)}


def test_a_better_answer_is_asked_for_where_refinement_does_not_do(rolling, replaced, monkeypatch):
    """A solver whose first answer is far away, and a refinement that does not help it: asked again, for more."""
    clarabel, refine, asked = tangential_solver("clarabel"), pipeline.refine_tangential, []

    def far(problem, settings, start):
        asked.append(settings.tol)
        return clarabel(problem, settings, start) if len(asked) > 1 else gives_up(problem, settings, start)

    def little(problem, settings, start):
        return start if start.status == "MaxIterations" else refine(problem, settings, start)

    replaced(clarabel=far)
    monkeypatch.setattr(pipeline, "refine_tangential", little)
    problem, raw, _ = solved(rolling(grid=CELLS), tol=1e-7, method="convex")
    assert asked == [1e-6, 1e-8]
    assert raw.solver == "splitting"
    assert tangential_residual(problem, raw.traction, raw.rigid) <= 1e-9


def test_refinement_never_spoils_an_answer(rolling, monkeypatch):
    """The better of both is kept, and says whose it is."""
    monkeypatch.setattr(pipeline, "refine_tangential", gives_up)
    problem, raw, _ = solved(rolling(grid=CELLS), tol=1e-30, method="convex")
    assert raw.solver == "clarabel"
    assert tangential_residual(problem, raw.traction, raw.rigid) < 1e-6


def test_no_program_where_friction_is_nowhere_exhausted(rolling):
    problem, raw, calls = solved(rolling(motion=vc.Shift(ux=1e-3), friction=1e3, grid=CELLS), tangential="clarabel")
    assert raw.solver == "no-slip"
    assert tangential_residual(problem, raw.traction, raw.rigid) < 1e-12
    assert calls == {"no-slip": (1, 1)}
