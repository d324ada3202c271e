"""The best answer of the attempts that a plan has at a problem, see `Plan.attempts`; sizes of
problems and their memory.

An attempt is made where the best answer so far misses what is wanted of it, by the residual of the
natural map. Each call of a solver is counted under its own name. Where the gap is not convex, TANG
takes the program's place, or the formulation is refused.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from varcontact.discrete.problems import NormalProblem, RawSolution, TangentialProblem
from varcontact.discrete.residuals import tangential_residual
from varcontact.errors import SceneError
from varcontact.results.plan import Attempt, Plan
from varcontact.scene.bodies import Bodies
from varcontact.scene.friction import FrictionBound
from varcontact.scene.grid import Grid
from varcontact.scene.motion import Shift, Steady
from varcontact.scene.scene import Scene
from varcontact.scene.surfaces import SampledDistance
from varcontact.scene.transient import Transient
from varcontact.solvers.active_set.tang import no_slip
from varcontact.solvers.interface import (
    Settings,
    TangentialSolver,
    better,
    counted,
    natural_residual,
)
from varcontact.solvers.registry import Kind, SolverSpec, solver
from varcontact.system.process import SMALLER, changed, need

MARCH_STEPS_MAX = 2000
"""Largest number of steps of a march."""
IDLE_STEPS = 5
"""Steps without gain after which a nearly stationary march ends."""
IDLE_CHANGE = 1e-4
"""Change in a step, relative to the largest traction, below which a march is nearly stationary."""

DENSE_MATRICES = 4.3
"""Dense matrices at the peak of active sets; a program takes three times as many for each of its
blocks."""
BYTES_CVXPY = 5e-3
"""Memory at the peak of CVXPY, which compiles the gap program, divided by the fourth power of the
unknowns [bytes]."""

NO_SLIP: TangentialSolver = counted("no-slip", lambda problem, settings, start: no_slip(problem))


def solve_problem(
    problem: NormalProblem | TangentialProblem,
    plan: Plan,
    polish: bool,
    settings: Settings,
    start: RawSolution | None,
) -> RawSolution:
    """The best answer of the attempts at a problem."""
    if isinstance(problem, NormalProblem):
        raw = _best_answer(problem, plan.attempts("normal", polish), settings, start)
        if plan.states_program("normal") and plan.method != "conic" and not polish:
            return _without_small_pressures(problem, raw)
        return raw
    if problem.no_slip and not plan.matrix_free("tangential"):
        return NO_SLIP(problem, settings, None)
    attempts = plan.attempts("tangential", polish)
    if not plan.states_program("tangential"):
        return _best_answer(problem, attempts, settings, start)
    if settings.formulation != "gap" or problem.symmetric_part is not None:
        return _best_answer(problem, attempts, settings, start)
    # no convex program
    if plan.method == "conic" or not polish:
        why = "the gap is not found to be convex for elements so long and steps so short"
        raise SceneError("formulation", "gap", f'"marching", or a longer motion.dq: {why}')
    raw = _best_answer(problem, attempts[-1:], settings, None)  # the certificate judges them
    return replace(raw, reason=f"the gap is not found to be convex here, so {raw.solver} was used")


def _best_answer(
    problem: NormalProblem | TangentialProblem,
    attempts: tuple[Attempt, ...],
    settings: Settings,
    start: RawSolution | None,
) -> RawSolution:
    """Best answer of the attempts, each made only if the earlier ones are not good enough."""
    best: RawSolution | None = None
    last = start
    for attempt in attempts:
        if best is not None and natural_residual(problem, best) <= attempt.enough(settings.tol):
            continue
        begins = {"given": start, "only given": start, "last": last, "best": best, "none": None}
        begin = begins[attempt.begin]
        if not _can_be_made(problem, attempt, begin, last):
            continue
        raw = _answer(problem, attempt, settings, begin)
        last = _with_record(raw, attempt, last)
        if attempt.judged:
            best = better(problem, best, last)
    answer = last if best is None else best
    assert answer is not None
    return answer


def _can_be_made(
    problem: NormalProblem | TangentialProblem,
    attempt: Attempt,
    begin: RawSolution | None,
    last: RawSolution | None,
) -> bool:
    """False without the start that an attempt needs, after a solver that gave no numbers, and for
    splitting where the potential follows from the tractions.
    """
    if attempt.begin == "only given":
        return begin is not None
    if attempt.begin in ("last", "none"):
        return last is None or last.finite
    if attempt.begin == "best" and isinstance(problem, TangentialProblem):
        return not problem.potential.implicit
    return True


def _with_record(raw: RawSolution, attempt: Attempt, last: RawSolution | None) -> RawSolution:
    """Answer with the iterations counted together with the previous answer, and the reason for
    it.
    """
    if last is None:
        return raw
    iterations = raw.iterations
    if attempt.polishes:
        iterations = last.iterations
    elif attempt.begin == "best":
        iterations += last.iterations
    return changed(raw, iterations=iterations, reason=attempt.reason.format(last.solver))


def _answer(
    problem: NormalProblem | TangentialProblem,
    attempt: Attempt,
    settings: Settings,
    begin: RawSolution | None,
) -> RawSolution:
    """The answer of one attempt."""
    kind: Kind = "normal" if isinstance(problem, NormalProblem) else "tangential"
    spec = solver(kind, attempt.solver)
    settings = changed(settings, tol=attempt.asked(settings.tol))
    if attempt.polishes:
        return spec.once(problem, settings, begin)
    if attempt.marches and isinstance(problem, TangentialProblem):
        return march(spec, problem, settings, begin)
    return spec(problem, settings, begin)


def _without_small_pressures(problem: NormalProblem, raw: RawSolution) -> RawSolution:
    """Answer of a program without the small pressures left where the bodies are apart, by the
    natural map ``p - e/rho``.
    """
    distance = problem.shift(raw.traction, raw.rigid)
    return replace(
        raw, traction=raw.traction * (raw.traction > distance / problem.operator.diagonal)
    )


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

        # its gain; a solver that fails may return its start, and then nothing changes either
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


# ----------------------------------------------------------------------------- sizes and memory


def peak(spec: SolverSpec | None, formulation: str, unknowns: float) -> float:
    """Bytes that a solver takes at its peak; None is one system of linear equations.

    >>> print(f"{peak(solver('tangential', 'clarabel'), 'gap', 2 * 812) / 2**20:.0f} MiB")
    519 MiB
    """
    if spec is not None and spec.matrix_free:
        return spec.bytes_per_unknown * unknowns
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


def one_direction(scene: Scene) -> bool:
    """True if tractions can arise along x only or along y only: in line contact, where nothing
    moves along y or x.
    """
    motion = scene.motion
    if not scene.line or not isinstance(motion, (Steady, Shift)):
        return False
    along_x = motion.rigid[0] != 0 or motion.Fx is not None or scene.coupled
    along_y = motion.rigid[1] != 0 or motion.Fy is not None
    return not (along_x and along_y)


def own_image(scene: Scene) -> bool:
    """True if a Hertzian contact with an even number of rows is known to be its own mirror image
    about the x-axis.

    With x its tractions along x are even in y and those along y odd where nothing moves along y, or
    about z; and the other way round where nothing moves along x.
    """
    motion = scene.motion
    grid = scene.grid
    placed = isinstance(grid, Grid) and not grid.explicit and grid.rows % 2 == 0
    if not placed or scene.line or scene.hertz is None or not isinstance(motion, (Steady, Shift)):
        return False
    by_element = isinstance(scene.friction, np.ndarray | FrictionBound)
    if any((scene.coupled, scene.loaded, by_element)):
        return False
    along_x, along_y, about_z = motion.rigid
    straight = along_y == about_z == 0 and motion.Fy is None
    return straight or (along_x == 0 and motion.Fx is None)


def elements_in_contact(scene: Scene) -> tuple[float, float]:
    """Approximate number of elements in contact, and their length along x; zero where that is not
    known.
    """
    grid = scene.own_grid
    # each step of a history has its own
    hertz = None if isinstance(scene.motion, Transient) else scene.hertz
    if not grid.explicit:
        rows = 1.0 if grid.line else np.pi / 4 * grid.rows
        dx = 0.0 if hertz is None else 2 * hertz.a / grid.nx
        return grid.nx * rows, dx
    dx, dy = grid.sides
    if hertz is None:
        return _elements_overlapping(scene, grid), dx
    if grid.line:
        return 2 * hertz.a / dx, dx
    return np.pi * hertz.a * hertz.b / dy / dx, dx


def _elements_overlapping(scene: Scene, grid: Grid) -> float:
    """Half of the elements that overlap, which are in contact in Hertz's, and fewer in line
    contact; all where the approach is not known.
    """
    surface = scene.surface
    if type(scene.bodies) is not Bodies or not isinstance(surface, SampledDistance):
        return grid.size
    if not isinstance(scene.approach, float):
        return grid.size
    return float(np.count_nonzero(surface.distance(grid) < scene.approach)) / 2


def tangential_unknowns(scene: Scene, plan: Plan, elements: float) -> float:
    """Traction components on a number of elements, on one side of a line of symmetry where the plan
    uses it.
    """
    unknowns = elements
    if not one_direction(scene):
        unknowns = 2 * elements
    if plan.solves and not plan.matrix_free("tangential") and own_image(scene):
        return unknowns / 2
    return unknowns


def check_fits(scene: Scene, plan: Plan) -> None:
    """Refuse a contact that cannot fit into memory before any work; otherwise each problem is
    checked when it is posed.
    """
    plan.potential_contact.check_size()
    if plan.closed_form and plan.solves and not isinstance(scene.motion, Transient):
        unknowns = tangential_unknowns(scene, plan, elements_in_contact(scene)[0])
        check_memory("tangential", plan.solver_of("tangential"), plan.formulation, unknowns)
