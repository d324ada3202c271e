"""How solvers are put together: refined, polished, with another to fall back on."""

import dataclasses

import numpy as np
import pytest

import varcontact as vc
from tests.solvers.conftest import random_normal
from varcontact.discrete.discretisation import discretise
from varcontact.discrete.problems import RawSolution
from varcontact.discrete.residuals import tangential_residual
from varcontact.discrete.state import ContactState, hertz_pressure, unloaded
from varcontact.results.plan import Plan
from varcontact.solvers.interface import Settings
from varcontact.solvers.registry import SOLVERS
from varcontact.solving.coupling import Limits, fixed_point
from varcontact.solving.pipeline import march, solve_problem
from varcontact.solving.selection import select

GRID = vc.Grid(nx=8, ny=8)


def problem_of(scene):
    """The tangential problem under Hertz's pressure."""
    disc = discretise(scene, vc.solve(dataclasses.replace(scene, motion=None, friction=None)).grid)
    return disc.tangential_problem(hertz_pressure(disc, unloaded(disc.grid)).pressure)


def gives_up(problem, settings, start):
    """A solver that brings nothing."""
    return RawSolution(
        np.zeros_like(problem.rigid_shift), np.zeros(2), 7, "MaxIterations", solved=False
    )


@pytest.fixture
def replaced(monkeypatch):
    """A function: put solvers of the tangential problem in the place of those of these names, as
    long as these have no start.
    """

    def replace(**solvers):
        for name, each in solvers.items():
            spec = SOLVERS["tangential", name.replace("_", "-")]

            def solve(problem, settings, start, each=each, spec=spec):
                instead = each if start is None else spec.solve
                return instead(problem, settings, start)

            changed = dataclasses.replace(spec, solve=solve)
            monkeypatch.setitem(SOLVERS, (spec.kind, spec.name), changed)

    return replace


def solved(scene, tol=1e-8, polish=True, **methods):
    """The tangential problem under Hertz's pressure, solved: problem, answer, and (count,
    iterations) of solvers.
    """
    problem, plan = problem_of(scene), select(scene, vc.Methods(**methods))
    settings = Settings(tol, plan.formulation)
    raw = solve_problem(problem, plan, polish, settings, None)
    calls = {name: (each.count, each.iterations) for name, each in settings.stats.calls[""].items()}
    return problem, raw, calls


@pytest.mark.parametrize("motion", [vc.Steady(vx=0.05, spin=0.1), vc.Shift(Fx=0.1, rotation=0.1)])
@pytest.mark.parametrize("name", ["tang-safeguarded", "newton"])
def test_splitting_where_others_fail(rolling, replaced, motion, name):
    """From nothing that they brought, it has the answer; all who were asked are counted."""
    replaced(**{name.replace("-", "_"): gives_up})
    problem, raw, calls = solved(rolling(motion=motion, grid=GRID), tangential=name)
    assert tangential_residual(problem, raw.traction, raw.rigid) <= 1e-8
    assert (raw.solver, raw.solved) == ("splitting", True)
    assert raw.reason == f"{name} missed the tolerance, splitting was used"
    assert list(calls) == [name, "splitting"]
    assert calls["splitting"] == (1, raw.iterations - 7)


def test_splitting_where_norm_fails(monkeypatch):
    """Pressures likewise; by the method "kalker" nothing takes over."""

    def cycles(problem, settings, start):
        nothing = np.zeros_like(problem.distance)
        return RawSolution(nothing, np.zeros(1), 7, "Cycled", False, "norm")

    spec = dataclasses.replace(SOLVERS["normal", "norm"], solve=cycles)
    monkeypatch.setitem(SOLVERS, ("normal", "norm"), spec)
    problem = random_normal(4)
    for method, expected in (("auto", "splitting"), ("kalker", "norm")):
        plan = Plan("norm", "none", "none", method=method)
        raw = solve_problem(problem, plan, True, Settings(1e-9), None)
        assert (raw.solver, raw.solved) == (expected, expected == "splitting")


def test_no_splitting_where_active_sets_succeed(rolling):
    _, raw, calls = solved(rolling(grid=GRID))
    assert (raw.solver, raw.reason) == ("tang-safeguarded", "")
    assert list(calls) == ["tang-safeguarded"]


@pytest.mark.parametrize("methods", [{"tangential": "tang"}, {"method": "kalker"}])
def test_no_fallback_for_methods_as_printed(rolling, replaced, methods):
    """They keep their answer, whatever it is."""
    replaced(tang=gives_up, tang_exact=gives_up)
    _, raw, calls = solved(rolling(grid=GRID), **methods)
    assert raw.status == "MaxIterations"
    assert list(calls.values()) == [(1, 7)]


def test_conic_answers_are_refined_by_splitting(rolling):
    """To a hundredth of the tolerance, which passes need; and the answer says so."""
    problem, raw, calls = solved(rolling(grid=GRID), tol=1e-7, method="conic")
    assert list(calls) == ["clarabel", "splitting"]
    assert (raw.solver, raw.reason) == ("splitting", "clarabel, refined by splitting")
    assert tangential_residual(problem, raw.traction, raw.rigid) <= 1e-9


def test_refinement_never_spoils_an_answer(rolling, monkeypatch):
    spec = dataclasses.replace(SOLVERS["tangential", "splitting"], solve=gives_up)
    monkeypatch.setitem(SOLVERS, ("tangential", "splitting"), spec)
    problem, raw, _ = solved(rolling(grid=GRID), tol=1e-9, method="conic")
    assert (raw.solver, raw.reason) == ("clarabel", "")
    assert tangential_residual(problem, raw.traction, raw.rigid) < 1e-6


ATTEMPTS = {
    "auto": ["tang-safeguarded", "splitting"],
    "kalker": ["tang-exact"],
    "conic": ["clarabel", "splitting"],
    "convex": ["splitting"],
}


@pytest.mark.parametrize("method", ATTEMPTS)
def test_the_plan_has_the_attempts_and_solvers_are_called_in_their_order(rolling, method):
    plan = select(rolling(grid=GRID), vc.Methods(method=method))
    names = [attempt.solver for attempt in plan.attempts("tangential")]
    assert names == ATTEMPTS[method]
    _, _, calls = solved(rolling(grid=GRID), method=method)
    assert list(calls) == names[: len(calls)]
    assert not plan.attempts("normal")  # a closed form


def test_attempts_of_a_polished_program():
    """Programs more and more exact, active sets from each, and in the end on their own."""
    attempts = Plan("osqp", "none", "none").attempts("normal")
    assert [attempt.solver for attempt in attempts] == ["norm", *3 * ["osqp", "norm"], "norm"]
    assert [attempt.begin for attempt in attempts[::7]] == ["only given", "none"]
    asked = [attempt.asked(1e-8) for attempt in attempts if attempt.solver == "osqp"]
    assert asked == [1e-2, 1e-4, 1e-6]
    [only] = Plan("osqp", "none", "none").attempts("normal", polish=False)
    assert only.asked(1e-8) == 1e-10


# ---------------------------------------------------------------------- The coupling loop by itself


SIZE = 40
START = ContactState(np.ones((1, SIZE)), 0.0, np.zeros((2, 1, SIZE)), np.zeros(2))
MATRIX = np.diag(np.linspace(-0.9, 0.9, SIZE))


def passes(says, useless=True):
    """How many passes it makes of ``p = 1 + M q, q = p``, where solvers say so whether they solved
    it.
    """
    answers = iter(says)

    def normal(state):
        return dataclasses.replace(state, pressure=1 + state.traction[0] @ MATRIX)

    def tangential(state):
        told = {"tangential": next(answers, True)}
        traction = np.stack([state.pressure] * 2)
        if useless and not told["tangential"]:
            traction = state.traction
        return dataclasses.replace(state, traction=traction, solved=told)

    def residual(state):
        return float(np.abs(state.traction[0] - 1 - state.traction[0] @ MATRIX).max())

    def one(state):
        after = tangential(normal(state))
        return after, residual(after)

    first = tangential(START)
    best = fixed_point(one, first, residual(first), ("traction",), Limits(1e-8, passes=500))
    return len(best.passes) - 1, best


def test_solvers_that_solve():
    """The fixed point ``(1 - M)^-1 1``, sooner than by repeating at the rate 0.9, which takes some
    170 passes.
    """
    count, state = passes([])
    np.testing.assert_allclose(state.pressure[0], 1 / (1 - np.diag(MATRIX)), rtol=1e-6)
    assert 6 < count < 100


@pytest.mark.parametrize(
    ("solved", "expected"),
    [([True, True, False, False], 3), ([True, True, False, True, False, False], 5)],
)
def test_two_failures_in_a_row_end_it(solved, expected):
    """The first answer of all is the start of the loop, and no pass."""
    assert passes(solved)[0] == expected


def test_single_failures_do_not_end_it():
    count, state = passes([False, False, True, False])
    assert count > 6
    np.testing.assert_allclose(state.pressure[0], 1 / (1 - np.diag(MATRIX)), rtol=1e-6)


def test_solvers_that_fail_and_come_nearer_all_the_same():
    """An interior point may say AlmostSolved in every pass: while the whole comes nearer, that ends
    nothing.
    """
    count, state = passes([False] * 300, useless=False)
    assert count == passes([])[0]
    np.testing.assert_allclose(state.pressure[0], 1 / (1 - np.diag(MATRIX)), rtol=1e-6)


# ----------------------------------------------------------------------------- Marching


MOTIONS = [
    vc.Steady(vx=0.05, vy=-0.02, spin=0.03),
    vc.Steady(Fx=-0.15, vy=-0.02),
    vc.Steady(Fx=-0.1, Fy=0.1),
]


@pytest.mark.long
@pytest.mark.parametrize("motion", MOTIONS)
@pytest.mark.parametrize("inner", ["tang", "tang-exact", "tang-safeguarded"])
def test_exact_steps_tend_to_the_gap_solution(rolling, check_kkt, inner, motion):
    """Unpolished, at the tolerance asked for: the end of the march is accepted by the residual of
    steady rolling.
    """
    gap = vc.solve(rolling(motion=motion, grid=GRID), formulation="gap")
    for tol in (1e-5, 1e-8):
        sol = vc.solve(
            rolling(motion=motion, grid=GRID), tangential=inner, formulation="marching", tol=tol
        )
        assert sol.status["tangential"] == "Steady"
        assert sol.plan.formulation == "marching"
        check_kkt(sol, tol)
        # The rest of a geometric row of steps: its sum is a few times its last term.
        assert np.abs(sol.traction - gap.traction).max() < 30 * tol * gap.traction_bound.max()
        assert sol.creepage == pytest.approx(gap.creepage, rel=100 * tol)


@pytest.mark.long
@pytest.mark.parametrize("inner", ["clarabel", "scs"])
def test_programs_tend_to_the_gap_solution(rolling, inner):
    scene = rolling(motion=MOTIONS[0], grid=vc.Grid(nx=6, ny=6))
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
