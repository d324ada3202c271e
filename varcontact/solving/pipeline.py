"""The attempts at a problem, in their order: the plan's solver, what refines
its answer, and what takes over.

The next attempt is made where the best answer so far misses the tolerance, a
natural-map residual. Each call of a solver is counted under its own name.

- By active sets, Newton's method or splitting: the solver. From the best answer of NORM, of the
  safeguarded TANG and of Newton's method splitting takes over, but for the method "kalker".
- By a program: tractions that stick all over or NORM and TANG from a start, the program polished by
  these; or, unpolished, the program asked for a hundredth of the tolerance; by the method "conic"
  the program refined by splitting. Where the gap is not convex TANG takes the program's place, or
  the formulation is refused.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from varcontact.discrete.problems import NormalProblem, RawSolution, TangentialProblem
from varcontact.discrete.residuals import tangential_residual
from varcontact.errors import SceneError
from varcontact.results.plan import Plan
from varcontact.solvers.active_set.tang import no_slip
from varcontact.solvers.interface import (
    Settings,
    TangentialSolver,
    better,
    counted,
    natural_residual,
)
from varcontact.solvers.registry import (
    Kind,
    SolverSpec,
    solver,
)
from varcontact.system.process import SMALLER, need

UNPOLISHED = 1e-2
"""Part of the tolerance that is asked of a solver whose answer no active set improves."""
POLISH_TOLS = (1e-2, 1e-4, 1e-6)
"""Accuracies asked of a solver of programs, each where the one before is not enough for active
sets."""
CONIC_TOL = 1e-6
"""Accuracy asked of a solver of programs whose answer is refined by splitting."""
POLISHED_TOL = 1e-9
"""Residual at which a polished answer is not improved any more."""
MARCH_STEPS_MAX = 2000
"""Steps of a march at most."""
IDLE_STEPS = 5
"""Steps without gain after which a march ends that hardly moves."""
IDLE_CHANGE = 1e-4
"""Change in a step, relative to the largest traction, with which a march hardly moves."""

BYTES_MATRIX_FREE = 900.0
"""Bytes of memory at the peak of Newton's method without a matrix, per unknown, with influence
numbers and fields."""
DENSE_MATRICES = 4.3
"""Dense matrices at the peak of active sets; a program takes three times as many for each of its
blocks."""
BYTES_CVXPY = 5e-3
"""Bytes at the peak of CVXPY, which compiles the gap program, by the fourth power of the
unknowns."""

NO_SLIP: TangentialSolver = counted("no-slip", lambda problem, settings, start: no_slip(problem))


@dataclass(frozen=True)
class Task:
    """A problem with the plan to solve it by, and where to begin."""

    problem: NormalProblem | TangentialProblem
    plan: Plan
    polish: bool
    settings: Settings
    start: RawSolution | None

    def residual(self, answer: RawSolution) -> float:
        return natural_residual(self.problem, answer)

    def solved(self, tol: float) -> RawSolution:
        """The answer of the plan's solver, in steps of a march where the plan marches."""
        settings = replace(self.settings, tol=tol)
        if isinstance(self.problem, NormalProblem):
            return solver("normal", self.plan.normal)(self.problem, settings, self.start)
        named: TangentialSolver = solver("tangential", self.plan.tangential)
        if self.plan.formulation == "marching":
            named = partial(march, named)
        return named(self.problem, settings, self.start)


def solve_problem(
    problem: NormalProblem | TangentialProblem,
    plan: Plan,
    polish: bool,
    settings: Settings,
    start: RawSolution | None,
) -> RawSolution:
    """The best answer of the attempts at a problem."""
    task = Task(problem, plan, polish, settings, start)
    if isinstance(problem, NormalProblem):
        if plan.states_program("normal"):
            return _by_program(task)
        return _with_fallback(task, "normal", settings.tol)
    # active sets, Newton's method and splitting
    if problem.no_slip and not plan.matrix_free("tangential"):
        return NO_SLIP(problem, settings, None)
    if not plan.states_program("tangential"):
        tol = settings.tol
        if not plan.matrix_free("tangential"):
            tol = UNPOLISHED * tol
        return _with_fallback(task, "tangential", tol)
    # programs
    if settings.formulation != "gap" or problem.symmetric_part is not None:
        return _by_program(task)
    if plan.method == "conic" or not polish:
        why = "the gap is not convex for elements so long and steps so short"
        raise SceneError("formulation", "gap", f'"marching", or a longer motion.dq: {why}')
    raw = _active_sets(task, None)  # the certificate judges them
    return replace(raw, reason=f"the gap is not convex on these elements, so {raw.solver} was used")


def _with_fallback(task: Task, kind: Kind, tol: float) -> RawSolution:
    """The answer of the plan's solver; where it misses the tolerance, splitting from there."""
    raw = task.solved(tol)
    spec = task.plan.solver_of(kind)
    if spec is None or not spec.falls_back or task.plan.method == "kalker":
        return raw
    if task.residual(raw) <= task.settings.tol:
        return raw
    problem = task.problem
    if isinstance(problem, TangentialProblem):
        implicit = problem.potential.implicit
        if implicit or task.plan.formulation == "marching":
            return raw
    best = _split(task, raw, tol)
    if best is raw:
        return raw
    return replace(best, reason=f"{raw.solver} missed the tolerance, splitting was used")


def _split(task: Task, start: RawSolution, tol: float) -> RawSolution:
    """The answer of splitting from a start, or the start where that is better."""
    settings = replace(task.settings, tol=tol)
    kind: Kind = "normal" if isinstance(task.problem, NormalProblem) else "tangential"
    raw = solver(kind, "splitting")(task.problem, settings, start)
    if not raw.solved and better(task.problem, start, raw) is start:
        return start
    return replace(raw, iterations=start.iterations + raw.iterations)


def march(
    solver: TangentialSolver,
    problem: TangentialProblem,
    settings: Settings,
    start: RawSolution | None,
) -> RawSolution:
    """Steady rolling without the gap program: transient steps, from no traction at all, until
    nothing changes.

    Source: J. J. Kalker, Three-Dimensional Elastic Bodies in Rolling Contact, Kluwer 1990.

    In a step the displacements ``u' = C p'`` of the step before are known, and the `solver` takes a
    problem like that of a shift with the rigid shift ``W - u'``: symmetric, and an optimisation.
    `status` is "Steady", "MaxSteps", or the solver's own word where it gave no number, or failed in
    a last step short of the tolerance.
    """
    assert problem.instant is not None
    inner = replace(settings, formulation="auto", tol=0.1 * settings.tol)
    last = start or RawSolution(np.zeros_like(problem.rigid_shift), np.zeros(problem.components))
    iterations = 0
    status = "MaxSteps"
    least = np.inf
    idle = 0
    for _ in range(MARCH_STEPS_MAX):
        # a step, with u' = C p' of the step before
        displacement = problem.instant.apply(last.traction) - problem.operator.apply(last.traction)
        step = replace(
            problem,
            operator=problem.instant,
            rigid_shift=problem.rigid_shift - displacement,
            symmetric=True,
            instant=None,
        )
        raw = solver(step, inner, last)
        iterations += raw.iterations
        if not raw.finite:
            status = raw.status
            break

        # its gain; a solver that fails may give back its start, then nothing changes either
        change = float(np.abs(raw.traction - last.traction).max())
        last = raw
        residual = tangential_residual(problem, raw.traction, raw.rigid)
        idle = 0 if residual < least else idle + 1
        least = min(least, residual)
        still = change <= IDLE_CHANGE * float(np.abs(raw.traction).max())
        if residual <= settings.tol or (still and idle >= IDLE_STEPS):
            status = raw.status
            if residual <= settings.tol or raw.solved:
                status = "Steady"
            break
    steady = status == "Steady"
    return RawSolution(last.traction, last.rigid, iterations, status, steady, last.solver)


def _by_program(task: Task) -> RawSolution:
    """The plan's program, refined by splitting, polished by active sets, or as it is; active sets
    from a start may do without.
    """
    problem = task.problem
    start = task.start
    if task.plan.method == "conic":
        return _refined(task)
    if task.polish:
        if start is None:
            return _polished(task, None)
        return _polished(task, replace(_active_sets(task, start), iterations=0))
    raw = task.solved(UNPOLISHED * task.settings.tol)
    if isinstance(problem, TangentialProblem):
        return raw
    # without the small pressures that it leaves where the bodies are apart, by the natural map ``p
    # - e/rho``
    distance = problem.shift(raw.traction, raw.rigid)
    return replace(
        raw, traction=raw.traction * (raw.traction > distance / problem.operator.diagonal)
    )


def _refined(task: Task) -> RawSolution:
    """The answer of a program, refined by splitting."""
    answer = task.solved(max(CONIC_TOL, task.settings.tol))
    if not answer.finite:
        return answer
    refined = _split(task, answer, UNPOLISHED * task.settings.tol)
    if refined is answer:
        return answer
    return replace(
        refined, iterations=answer.iterations, reason=f"{answer.solver}, refined by splitting"
    )


def _polished(task: Task, best: RawSolution | None) -> RawSolution:
    """The answer of the plan's program after active sets, which need it no more exact than this.

    Near saturation they can be lost beside the solution, where almost nothing sticks: then they
    begin on their own.
    """
    enough = min(task.settings.tol, POLISHED_TOL)
    answer = task.start
    if answer is None:
        answer = best
    for accuracy in POLISH_TOLS:
        if best is not None and task.residual(best) <= enough:
            break
        answer = task.solved(accuracy)
        if answer.finite:
            best = better(
                task.problem,
                best,
                replace(_active_sets(task, answer), iterations=answer.iterations),
            )
    assert answer is not None
    if best is None:
        return answer
    if task.residual(best) > task.settings.tol:
        best = better(
            task.problem, best, replace(_active_sets(task, None), iterations=answer.iterations)
        )
    return best


def _active_sets(task: Task, start: RawSolution | None) -> RawSolution:
    """NORM, or the safeguarded TANG."""
    if isinstance(task.problem, NormalProblem):
        return solver("normal", "norm")(task.problem, task.settings, start)
    return solver("tangential", "tang-safeguarded").once(task.problem, task.settings, start)


def peak(spec: SolverSpec | None, formulation: str, unknowns: float) -> float:
    """Bytes that a solver takes at its peak; None is one system of linear equations.

    >>> print(f"{peak(solver('tangential', 'clarabel'), 'gap', 2 * 812) / 2**20:.0f} MiB")
    519 MiB
    """
    if spec is not None and spec.matrix_free:
        return BYTES_MATRIX_FREE * unknowns
    blocks = 2 if formulation in ("gap", "potential") else 1
    matrices = DENSE_MATRICES
    if spec is not None and spec.states_program:
        matrices *= 3 * blocks
    needed = 8 * matrices * unknowns**2
    if spec is not None and "cvxpy" in spec.needs and blocks == 2:
        return max(needed, BYTES_CVXPY * unknowns**4)
    return needed


def check_memory(problem: str, spec: SolverSpec | None, formulation: str, unknowns: float) -> None:
    """Refuse a problem that does not fit into memory; a `TooLarge` says what does."""
    taken = peak(spec, formulation, unknowns)
    remedy = SMALLER
    if spec is None or not spec.matrix_free:
        by_newton = peak(solver("tangential", "newton"), "", unknowns)
        remedy = f'"newton" needs about {by_newton / 2**30:.2g} GiB; or {SMALLER}'
    need(f"the {problem} problem", taken, remedy)
