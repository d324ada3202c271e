"""The plan's solvers, with what is done to their answers: refined, polished, or replaced by another solver's.

Everything that may be called for a problem is put together here, once; each call is counted under its own name. In all
of it `settings.tol` is the natural-map residual to reach.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial

import numpy as np

from varcontact.discrete.problems import NormalProblem, RawSolution, TangentialProblem
from varcontact.discrete.residuals import magnitude, normal_residual, tangential_residual
from varcontact.errors import SceneError, TooLarge
from varcontact.planning import memory
from varcontact.planning.plan import Plan
from varcontact.solvers.active_set.tang import no_slip, tang_safeguarded
from varcontact.solvers.conic.backends import solve_joint
from varcontact.solvers.interface import NormalSolver, Problem, Settings, Solver, Start, TangentialSolver, counted
from varcontact.solvers.marching import march
from varcontact.solvers.newton.driver import DENSE
from varcontact.solvers.registry import normal_solver, states_programs, tangential_solver
from varcontact.solvers.splitting import refine_both, refine_normal, refine_tangential
from varcontact.system.memory import SMALLER, need

UNPOLISHED = 1e-2
"""Part of the tolerance that is asked of a solver whose answer no active set improves."""

TO_POLISH, TO_REFINE = (1e-2, 1e-4, 1e-6), (1e-6, 1e-8)
"""Accuracies asked of a solver of programs, each where the one before did not do for active sets, and for splitting."""

NEWTON_STEPS_FROM_START = 8
"""Newton steps of TANG from the pass or the step before, until it must have come nearer."""

Residual = Callable[[Problem, np.ndarray, np.ndarray], float]
JointSolver = Callable[[NormalProblem, TangentialProblem, np.ndarray, Settings], tuple[RawSolution, RawSolution]]

NO_SLIP: TangentialSolver = counted("no-slip", lambda problem, settings, start: no_slip(problem))
TANG: TangentialSolver = counted(
    "tang-safeguarded", lambda problem, settings, start: tang_safeguarded(problem, start, settings=settings)
)
BRIEF_TANG: Solver[TangentialProblem, RawSolution] = counted(
    "tang-safeguarded",
    lambda problem, settings, start: tang_safeguarded(problem, start, NEWTON_STEPS_FROM_START, settings),
)
"""One linear system, tractions that stick everywhere; the polish, and the polish for a few steps."""


def normal_road(plan: Plan, polish: bool) -> NormalSolver:
    """The plan's solver of the normal problem, with what is done to its answer.

    Parameters
    ----------
    plan : Plan
    polish : bool
        Whether active sets take the answer of a program to rounding; never by the method "convex".
    """
    solver = normal_solver(plan.normal)
    if not states_programs(plan.normal):
        return solver
    if plan.convex:
        return _closer(refined(solver, counted("splitting", refine_normal), normal_residual))
    if polish:
        return _polished(solver, normal_solver("norm"), normal_residual, normal_solver("norm"))
    return _closer(_without_noise(solver))


def tangential_road(plan: Plan, polish: bool) -> TangentialSolver:
    """The plan's solver of the tangential problem, with what is done to its answer, and the fallback.

    Parameters
    ----------
    plan : Plan
    polish : bool
        Whether active sets take the answer of a program to rounding; never by the method "convex".
    """
    solver, marches = tangential_solver(plan.tangential), plan.marches
    if plan.convex:
        solver = refined(solver, counted("splitting", refine_tangential), tangential_residual)
    if marches:
        solver = partial(march, solver)
    road = solver if plan.matrix_free else _closer(solver)
    if not plan.programs:
        road = with_fallback(road, plan.fallback) if plan.fallback != "none" and not marches else road
    elif plan.convex or not polish:
        road = _where_convex(road, _refused)
    else:
        road = _polished(solver, TANG, tangential_residual, _from_start)
        road = unless_all_sticks(_where_convex(road, _by_active_sets))
    return road if plan.matrix_free else _with_a_bound(road)


def joint_road(plan: Plan, polish: bool) -> JointSolver:
    """The plan's solver of the joint program of a shift, with what is done to its answer.

    Parameters
    ----------
    plan : Plan
    polish : bool
        Whether passes of both problems in turn come after it: then a rough answer is enough.
    """
    name = plan.tangential

    def solve(
        normal: NormalProblem, tangential: TangentialProblem, coupling: np.ndarray, settings: Settings
    ) -> tuple[RawSolution, RawSolution]:
        exact = replace(settings, tol=UNPOLISHED * settings.tol)
        rough = replace(settings, tol=TO_REFINE[0])
        with settings.stats.called(name):
            asked = rough if polish or plan.convex else exact
            pressed, rubbed = solve_joint(name, normal, tangential, coupling, asked)
            settings.stats.iterated(name, rubbed.iterations)
        if not plan.convex or not (_finite(pressed) and _finite(rubbed)):
            return replace(pressed, solver=name), replace(rubbed, solver=name)
        with settings.stats.called("splitting"):
            nearer, near = refine_both(normal, tangential, coupling, exact, (pressed, rubbed))
            settings.stats.iterated("splitting", near.iterations)
        answer = replace(near, iterations=rubbed.iterations, solver="splitting")
        return replace(nearer, solver="splitting"), answer

    return solve


def _closer(solver: Solver[Problem, Start]) -> Solver[Problem, Start]:
    """A solver that is asked for a hundredth of the tolerance, as nothing improves its answer."""

    def solve(problem: Problem, settings: Settings, start: Start) -> RawSolution:
        return solver(problem, replace(settings, tol=UNPOLISHED * settings.tol), start)

    return solve


def refined(
    solver: Solver[Problem, RawSolution | None], refine: Solver[Problem, RawSolution], residual: Residual[Problem]
) -> Solver[Problem, RawSolution | None]:
    """A solver of programs whose answer is refined by splitting, to the tolerance or as near as that comes.

    The solver is called in any case, for an answer that is near, and once more, for a nearer one, if that did not do.

    Parameters
    ----------
    solver : callable
        From a problem, `Settings` and a start to a `RawSolution`.
    refine : callable
        The same, from an answer that is near.
    residual : callable
        Natural-map residual of tractions and rigid shifts in a problem [-].
    """

    def solve(problem: Problem, settings: Settings, start: RawSolution | None) -> RawSolution:
        best = None
        for accuracy in TO_REFINE:
            answer = solver(problem, replace(settings, tol=max(accuracy, settings.tol)), start)
            best = _better(problem, residual, best, answer)
            if _finite(answer) and residual(problem, best.traction, best.rigid) > settings.tol:
                near = replace(refine(problem, settings, answer), iterations=answer.iterations)
                best = _better(problem, residual, best, near)
            if residual(problem, best.traction, best.rigid) <= settings.tol:
                break
        assert best is not None
        return best

    return solve


def _polished(
    solver: Solver[Problem, RawSolution | None],
    polish: Solver[Problem, RawSolution | None],
    residual: Residual[Problem],
    near: Solver[Problem, RawSolution],
) -> Solver[Problem, RawSolution | None]:
    """A solver of programs whose answer active sets take to rounding.

    Where they do so from a start (the pass or the step before), `near`, the solver is not called at all.
    """

    def solve(problem: Problem, settings: Settings, start: RawSolution | None) -> RawSolution:
        best = None if start is None else replace(near(problem, settings, start), iterations=0)
        return _by_program(solver, polish, residual, problem, settings, start, best)

    return solve


def with_fallback(solver: TangentialSolver, program: str) -> TangentialSolver:
    """Another solver, and the polished answer of a solver of programs where that misses the tolerance.

    Without a convex program, or with too many elements for it, its own is the answer all the same.

    Parameters
    ----------
    solver : callable
        From a problem, `Settings` and a start to a `RawSolution`.
    program : str
        The solver of programs.
    """

    def solve(problem: TangentialProblem, settings: Settings, start: RawSolution | None) -> RawSolution:
        raw = solver(problem, settings, start)
        if problem.size > DENSE or tangential_residual(problem, raw.traction, raw.rigid) <= settings.tol:
            return raw
        formulation = "complementary" if problem.symmetric else "gap"
        try:
            peak = memory.peak(program, formulation, problem.rigid_shift.size)
            need("the tangential program", peak, SMALLER)
        except TooLarge:
            return raw
        if formulation == "gap" and not problem.monotone:
            return raw
        asked = replace(settings, formulation=formulation)
        best = _by_program(tangential_solver(program), TANG, tangential_residual, problem, asked, None, raw)
        return best if best is raw else replace(best, reason=f"{raw.solver} missed the tolerance, {program} was used")

    return solve


def _where_convex(solver: TangentialSolver, otherwise: TangentialSolver) -> TangentialSolver:
    """A solver of the gap program, and another where that is not convex."""

    def solve(problem: TangentialProblem, settings: Settings, start: RawSolution | None) -> RawSolution:
        convex = settings.formulation != "gap" or problem.monotone
        return (solver if convex else otherwise)(problem, settings, start)

    return solve


def unless_all_sticks(solver: TangentialSolver) -> TangentialSolver:
    """A solver, unless friction is nowhere exhausted: then the linear solution is the solution.

    Parameters
    ----------
    solver : callable
        From a problem, `Settings` and a start to a `RawSolution`.
    """

    def solve(problem: TangentialProblem, settings: Settings, start: RawSolution | None) -> RawSolution:
        if start is None or not problem.symmetric:
            sticking = NO_SLIP(problem, settings, start)
            if np.all(magnitude(sticking.traction) <= problem.bound):
                return sticking
        return solver(problem, settings, start)

    return solve


def _with_a_bound(solver: TangentialSolver) -> TangentialSolver:
    """A solver, unless friction is infinite."""

    def solve(problem: TangentialProblem, settings: Settings, start: RawSolution | None) -> RawSolution:
        return (NO_SLIP if problem.no_slip else solver)(problem, settings, start)

    return solve


def without_noise(problem: NormalProblem, raw: RawSolution) -> RawSolution:
    """A solver's answer without the small pressures that it leaves where the bodies are apart.

    An element is in contact where the natural map ``p - e/rho`` is positive: the pressure outweighs the distance.

    Parameters
    ----------
    problem : NormalProblem
    raw : RawSolution
        Pressures (n,) and the approach (1,), dimensionless.
    """
    distance = problem.distance - raw.rigid[0] + problem.operator.apply(raw.traction[None])[0]
    return replace(raw, traction=raw.traction * (raw.traction > distance / problem.operator.diagonal))


def _without_noise(solver: NormalSolver) -> NormalSolver:
    return lambda problem, settings, start: without_noise(problem, solver(problem, settings, start))


def _by_program(
    solver: Solver[Problem, RawSolution | None],
    polish: Solver[Problem, RawSolution | None],
    residual: Residual[Problem],
    problem: Problem,
    settings: Settings,
    start: RawSolution | None,
    best: RawSolution | None,
) -> RawSolution:
    """A solver's answer, polished, where `best` is not good enough: it is asked for no more than the polish needs.

    Near saturation the polish can be lost beside the solution, where almost nothing sticks: then it begins on its own.
    """
    enough, answer = min(settings.tol, 1e-9), start if start is not None else best
    for accuracy in TO_POLISH:
        if best is not None and residual(problem, best.traction, best.rigid) <= enough:
            break
        answer = solver(problem, replace(settings, tol=accuracy), start)
        if _finite(answer):
            raw = replace(polish(problem, settings, answer), iterations=answer.iterations)
            best = _better(problem, residual, best, raw)
    assert answer is not None
    if best is None:
        return answer
    if residual(problem, best.traction, best.rigid) > settings.tol:
        alone = replace(polish(problem, settings, None), iterations=answer.iterations)
        best = _better(problem, residual, best, alone)
    return best


def _better(problem: Problem, residual: Residual[Problem], one: RawSolution | None, other: RawSolution) -> RawSolution:
    """The one with the smaller residual, or the only one."""
    if one is None or not _finite(one):
        return other
    errors = [residual(problem, raw.traction, raw.rigid) for raw in (one, other)]
    return other if errors[1] < errors[0] else one


def _finite(raw: RawSolution) -> bool:
    return bool(np.isfinite(raw.traction).all() and np.isfinite(raw.rigid).all())


def _from_start(problem: TangentialProblem, settings: Settings, start: RawSolution) -> RawSolution:
    """TANG from the pass or the step before; given up soon where it does not converge, as a solver of programs will."""
    near = BRIEF_TANG(problem, settings, start)
    before, after = (tangential_residual(problem, raw.traction, raw.rigid) for raw in (start, near))
    return near if near.solved or after > 1e-2 * before else TANG(problem, settings, near)


def _by_active_sets(problem: TangentialProblem, settings: Settings, start: RawSolution | None) -> RawSolution:
    """Active sets, whose answer the certificate judges."""
    raw = TANG(problem, settings, None)
    return replace(raw, reason=f"the gap is not convex on these elements, so {raw.solver} was used")


def _refused(problem: TangentialProblem, settings: Settings, start: RawSolution | None) -> RawSolution:
    raise SceneError(
        "formulation",
        "gap",
        '"marching", or a longer motion.dq',
        message='formulation = "gap": the gap is not convex for elements so long and motion.dq '
        'so short; use "marching", or a longer motion.dq',
    )
