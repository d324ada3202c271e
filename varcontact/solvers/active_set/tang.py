"""TANG: Kalker's active-set algorithm for the tangential problem (paper,
section 5.3), as printed and variants.

Source: J. J. Kalker, Three-Dimensional Elastic Bodies in Rolling Contact,
Kluwer 1990.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from varcontact.discrete.problems import RawSolution, TangentialProblem
from varcontact.discrete.residuals import tangential_residual
from varcontact.interfaces.potential import dot, magnitude, project
from varcontact.solvers.full_slip import full_slip
from varcontact.solvers.interface import (
    Settings,
    TangentialSolver,
    better,
    check_time,
    counted,
    ignored,
)
from varcontact.solvers.trace import Follower
from varcontact.system.process import changed, interruptible

MAX_EXCHANGES = 200
MAX_NEWTON = 200
"""Newton steps on given areas at most: 100 leave one in twenty problems unsolved."""
NEWTON_TOL_INEXACT = 1e-3
"""Relative error of the shift at which inexact Newton's method stops while areas still change."""
NEWTON_TOL_EXACT = 1e-13
"""Relative error of the shift at which exact Newton's method stops."""
NEWTON_ROUNDING = 1e-9
"""Relative error of the shift below which Newton's method stops once the error no longer falls."""
RESIDUAL_MIN = 1e-13
"""Residual at which the safeguarded version stops: rounding of some hundred elements in line."""
RESIDUAL_SOLVED = 1e-11
"""Residual from which it calls a problem solved: near saturation rounding leaves more."""
REUSE_RATIO = 1e-3
"""Ratio of residuals of a step below which the next step reuses its factors."""
MAX_IDLE_STEPS = 5
"""Newton steps without a smaller residual after which the safeguarded version tries another
start."""
SPLITTING_TOLS = (1e-2, 1e-4, 1e-6)
"""Residuals to which splitting solves in turn, where the safeguarded version fails from its own
start."""
NATURAL_MAPS = 3
"""Natural maps before the first Newton step of steady rolling; in a shift their steps are too
short."""
STEP_PARTS = (1.0, 0.5, 0.25, 0.1, 0.03)
"""Parts of a Newton step that the line search of the safeguarded version tries in turn."""


@dataclass(frozen=True, eq=False)
class PointOnAreas:
    """A point with its stick and slip areas, about which Newton's equations are linearised."""

    problem: TangentialProblem
    at: RawSolution
    sticks: np.ndarray
    # places of the stick elements (h,), and of their tractions among all (c h,)
    stuck: np.ndarray
    held: np.ndarray
    # places of the slip elements, whose traction turns (t,); none where there is but one component
    turning: np.ndarray
    # their tractions (c, t), these turned by a right angle, and unit vectors along the latter
    slipping: np.ndarray
    turned: np.ndarray
    across: np.ndarray
    # E (c, n)
    shift: np.ndarray

    @classmethod
    def of(cls, problem: TangentialProblem, sticks: np.ndarray, at: RawSolution) -> PointOnAreas:
        (stuck,) = sticks.nonzero()
        held = stuck
        turning = stuck[:0]
        if problem.components > 1:
            held = np.concatenate([stuck, problem.size + stuck])
            (turning,) = (~sticks).nonzero()
        slipping = at.traction.take(turning, axis=1)
        turned = slipping[::-1].copy()
        turned[0] *= -1
        across = turned / problem.bound.take(turning)
        shift = shift_of(problem, at)
        return cls(problem, at, sticks, stuck, held, turning, slipping, turned, across, shift)

    @property
    def parts(self) -> tuple[slice, slice, slice]:
        """Places among the unknowns: of the tractions that stick, of the angles, of the rigid
        shifts.
        """
        sticking = self.held.size
        end = sticking + self.turning.size
        return slice(sticking), slice(sticking, end), slice(end, None)

    def moved(self, step: np.ndarray, part: float = 1.0) -> RawSolution:
        """A part of a step, turning the slip tractions on their bound."""
        sticking, turning, shifting = self.parts
        if part != 1:
            step = part * step
        traction = self.at.traction.copy()
        traction.reshape(-1)[self.held] += step[sticking]
        if self.turning.size:
            angle = step[turning]
            turned = np.cos(angle) * self.slipping + np.sin(angle) * self.turned
            traction[:, self.turning] = turned
        rigid = self.at.rigid
        if self.problem.free:
            rigid = rigid.copy()
            rigid[self.problem.free] += step[shifting]
        return RawSolution(traction, rigid)


@dataclass(frozen=True, eq=False)
class Equations:
    """Newton's equations for given areas, factored: good for steps from other points nearby.

    E = 0 where it sticks, E along the traction where it slips, the prescribed forces. Unknowns: the
    components of the traction where it sticks, its direction where it slips, the missing rigid
    shifts.
    """

    sticks: np.ndarray
    factors: tuple[np.ndarray, np.ndarray] | None

    @classmethod
    def of(cls, point: PointOnAreas) -> Equations:
        """Equations at a point; without factors where they are singular."""
        from scipy.linalg.lapack import dgetrf

        jacobian = _jacobian(point)
        if not len(jacobian):
            return cls(point.sticks, None)
        factors, swaps, singular = interruptible(
            lambda: dgetrf(jacobian.T, overwrite_a=True), len(jacobian)
        )
        return cls(point.sticks, None if singular else (factors, swaps))

    def step(self, point: PointOnAreas, turn: float = math.inf) -> np.ndarray:
        """Changes of the stick tractions, of the directions of those that turn, no more than
        `turn`, of rigid shifts.

        Zero where the equations are singular.
        """
        from scipy.linalg.lapack import dgetrs

        error = _errors(point)
        if self.factors is None:
            return np.zeros(error.size)
        step, _ = dgetrs(*self.factors, -error, trans=1)
        _, turning, _ = point.parts
        if math.isfinite(turn):
            angles = step[turning]
            np.minimum(np.maximum(angles, -turn), turn, out=angles)
        return np.asarray(step)


def _errors(point: PointOnAreas) -> np.ndarray:
    """Errors of Newton's equations: E where it sticks, E across the tractions that slip, the excess
    of the forces.
    """
    problem = point.problem
    shift = point.shift
    if problem.potential.flow is not None:
        shift = shift + flow_of(problem, point.at)[0]
    errors = [shift.take(point.held)]
    if point.turning.size:
        errors.append(dot(point.across, shift.take(point.turning, axis=1)))
    if problem.free:
        forces = [F / problem.area for F in problem.force if F is not None]
        errors.append(point.at.traction[problem.free].sum(axis=1) - forces)
    return np.concatenate(errors)


def _jacobian(point: PointOnAreas) -> np.ndarray:
    """Matrix of Newton's equations: rows of the stick area, of the slip area, of the forces."""
    problem = point.problem
    n = problem.size
    matrix = problem.operator.matrix
    T = point.turning
    across = point.across
    _, turning, _ = point.parts
    # shifts of the stick area, and across the tractions of the slip area, by all tractions
    places = np.concatenate([point.held, T])
    rows = matrix.take(places, axis=0)
    if T.size:
        of_y = matrix.take(n + T, axis=0)
        of_y *= across[1, :, None]
        rows[turning] *= across[0, :, None]
        rows[turning] += of_y
    # by the stick tractions, and by the angles of the slip tractions
    jacobian = rows.take(places, axis=1)
    if T.size:
        by_y = rows.take(n + T, axis=1)
        by_y *= point.turned[1]
        jacobian[:, turning] *= point.turned[0]
        jacobian[:, turning] += by_y
        angles = np.arange(turning.start, turning.stop)
        jacobian[angles, angles] += magnitude(point.shift.take(T, axis=1))
    if problem.potential.flow is not None:
        _add_flow(jacobian, point)
    if problem.free:
        return _with_forces(jacobian, point)
    return jacobian


def _add_flow(jacobian: np.ndarray, point: PointOnAreas) -> None:
    """The derivatives of what flows within the bound, added to the rows of the stick area."""
    _, along, direction = flow_of(point.problem, point.at)
    h = point.stuck.size
    c = len(direction)
    for i, j in np.ndindex(c, c):
        block = along[1] * (i == j) + (along[0] - along[1]) * direction[i] * direction[j]
        jacobian[i * h + np.arange(h), j * h + np.arange(h)] += block[point.stuck]


def _with_forces(jacobian: np.ndarray, point: PointOnAreas) -> np.ndarray:
    """The matrix with columns of the rigid shifts that are unknown, and rows of the sums of
    tractions that are prescribed.
    """
    free = point.problem.free
    h = point.stuck.size
    _, turning, shifting = point.parts
    bordered = np.zeros((shifting.start + len(free), shifting.start + len(free)))
    bordered[: shifting.start, : shifting.start] = jacobian
    for place, component in enumerate(free, start=shifting.start):
        part = slice(component * h, (component + 1) * h)
        bordered[part, place] = 1.0
        bordered[place, part] = 1.0
        if point.turning.size:
            bordered[turning, place] = point.across[component]
            bordered[place, turning] = point.turned[component]
    return bordered


def shift_of(problem: TangentialProblem, at: RawSolution) -> np.ndarray:
    """E by the dense matrix, which Newton's method needs anyway, (c, n)."""
    return problem.operator.apply_densely(at.traction) + problem.rigid_shift + at.rigid[:, None]


def flow_of(
    problem: TangentialProblem, at: RawSolution
) -> tuple[np.ndarray, tuple[np.ndarray, np.ndarray], np.ndarray]:
    """The plastic shift linearised where the natural map leads, at a point (c, n); its derivatives;
    its direction.
    """
    flow = problem.potential.flow
    assert flow is not None
    weight = problem.operator.row_size
    trial = _trial(problem, at)
    size = magnitude(trial)
    direction = trial / np.where(size > 0, size, 1.0)
    image = direction * flow.sizes(size, weight)
    along, across = flow.tangent(image)
    missing = at.traction - image
    turned = across * missing + (along - across) * dot(direction, missing) * direction
    return flow.shift(image) + turned, (along, across), direction


def tang(
    problem: TangentialProblem,
    start: RawSolution | None = None,
    newton: Literal["exact", "inexact"] = "inexact",
    deadline: float = math.inf,
    follow: Follower = ignored,
) -> RawSolution:
    """TANG (5.3): active sets, with Newton's method on given areas to the end, as printed, or ended
    early.

    It begins with every element in the stick area. On given areas it solves ``E = 0`` in the stick
    area (linear) and ``|p| = g`` with p along E in the slip area (nonlinear, by Newton's method);
    then it moves all stick elements beyond the bound to the slip area or, where there are none, all
    slip elements whose slip goes with the traction instead of against it back to the stick area.
    Prescribed forces are further equations (5.3.1).

    A start gives its areas and directions in place of the printed ones. By "exact", Newton's method
    goes to the end on given areas, as point 3 has it; by "inexact", not the paper's, no further
    than exchanges need, and to the end only where there is nothing left to exchange.

    The answer is the best iterate by its residual. `status` is "Solved", "Cycled" (areas came
    back), "NewtonFailed" or "MaxIterations": there is no proof of convergence. `iterations` counts
    Newton steps.
    """
    if problem.no_slip:
        return no_slip(problem)
    at = _unloaded(problem)
    sticks = np.ones(problem.size, dtype=bool)
    if start is not None:
        trial = _trial(problem, start)
        sticks = ~problem.potential.slips(trial, problem.operator.row_size)
        at = _on_bound(problem, sticks, start, trial)
    tolerances = [NEWTON_TOL_EXACT]
    if newton == "inexact":
        tolerances = [NEWTON_TOL_INEXACT, NEWTON_TOL_EXACT]
    previous_areas: set[bytes] = set()
    best = start or _admissible(problem, at)
    count = 0
    status = "MaxIterations"
    for _ in range(MAX_EXCHANGES):
        if sticks.tobytes() in previous_areas:
            status = "Cycled"
            break
        previous_areas.add(sticks.tobytes())
        for tol in tolerances:
            at, steps, converged = _on_areas(problem, sticks, at, tol, deadline)
            count += steps
            new_sticks = _exchanged(problem, sticks, at)
            unchanged = np.array_equal(new_sticks, sticks)
            if not (unchanged and converged):
                break
        admissible = _admissible(problem, at)
        follow(admissible)
        best = better(problem, best, admissible)
        if not converged:
            status = "NewtonFailed"
            break
        if unchanged:
            status = "Solved"
            break
        sticks = new_sticks
    return replace(best, iterations=count, status=status, solved=status == "Solved")


def _exchanged(problem: TangentialProblem, sticks: np.ndarray, at: RawSolution) -> np.ndarray:
    """Stick area without the elements beyond the bound (point 4); if there are none, with the
    elements whose slip has the direction of their traction (point 5).
    """
    beyond = sticks & (magnitude(at.traction) > problem.bound)
    if beyond.any():
        return sticks & ~beyond
    slip = shift_of(problem, at) + problem.potential.flowed(at.traction)
    forward = ~sticks & (dot(at.traction, slip) > 0)
    return sticks | forward


def tang_safeguarded(
    problem: TangentialProblem,
    start: RawSolution | None = None,
    max_steps: int = 60,
    settings: Settings | None = None,
) -> RawSolution:
    """TANG with the areas renewed after each Newton step, steps shortened until they help, and a
    way back.

    An element belongs to the slip area where the natural map ``p - E/rho`` leaves the bound, which
    is the paper's points 4 and 5 in one. Steps are judged by the residual of that map. Where no way
    leads down from the start, projection and contraction (`splitting`), which converges from
    anywhere, comes near enough for Newton's method. With forces prescribed TANG with inexact Newton
    steps is asked before.

    From a given start only that is tried, for `max_steps` Newton steps. The answer is the best
    iterate by its residual; `status` is "Solved" or "MaxIterations". `iterations` counts Newton
    steps.
    """
    if problem.no_slip:
        return no_slip(problem)
    settings = settings or Settings()
    slipping = full_slip(problem, settings, start)
    if slipping is not None:
        return slipping
    if start is not None:
        return _descend(problem, _admissible(problem, start), max_steps, settings)
    at = _begin(problem)
    best = _descend(problem, at, max_steps, settings)
    if best.solved:
        return best
    count = best.iterations
    # each of these starts is needed by some random problems
    for begin, iterations in _further_starts(problem, at, settings):
        raw = _descend(problem, begin, max_steps, settings)
        count += iterations + raw.iterations
        if raw.solved:
            return replace(raw, iterations=count)
        best = better(problem, best, raw)
    return replace(best, iterations=count, status="MaxIterations", solved=False)


def _begin(problem: TangentialProblem) -> RawSolution:
    """Tractions to begin with: in full slip; else, in steady rolling with given creepages, after a
    few natural maps; else of infinite friction, cut off at the bound.
    """
    at = _sliding(problem)
    if at is None and not (problem.symmetric or problem.free):
        at = _unloaded(problem)
        for _ in range(NATURAL_MAPS):
            at = RawSolution(_Iterate.of(problem, at).image, at.rigid)
    if at is None:
        at = _admissible(problem, no_slip(problem))
    if not at.finite:  # numbers overflow
        at = _unloaded(problem)
    return at


def _sliding(problem: TangentialProblem) -> RawSolution | None:
    """Tractions in full slip, at the bound against the rigid shift; None if that is at most an
    element's own compliance times its bound, or if an element would not slip against its traction.
    """
    size = magnitude(problem.rigid_shift)
    if problem.free or not np.all(size > problem.operator.diagonal * problem.bound):
        return None
    traction = -problem.rigid_shift * (problem.bound / size)
    at = RawSolution(traction, np.zeros(problem.components))
    if np.any(dot(traction, shift_of(problem, at)) > 0):
        return None
    return at


def _further_starts(
    problem: TangentialProblem, at: RawSolution, settings: Settings
) -> Iterator[tuple[RawSolution, int]]:
    """Further starts, with the Newton steps they took: TANG, if forces are prescribed, then
    splitting to smaller and smaller residuals.
    """
    from varcontact.solvers.splitting.method import splitting_tangential

    if problem.free:
        inexact: TangentialSolver = counted(
            "tang",
            lambda problem, settings, _: tang(
                problem, deadline=settings.deadline, follow=settings.stats.follow(problem)
            ),
        )
        raw = inexact(problem, settings, None)
        yield raw, raw.iterations
    splitting: TangentialSolver = counted("splitting", splitting_tangential)
    for tol in SPLITTING_TOLS:
        at = splitting(problem, replace(settings, tol=tol), at)
        yield at, 0


def no_slip(problem: TangentialProblem) -> RawSolution:
    """Tractions in full stick, E = 0, whatever the bound: one linear solve (infinite friction)."""
    point = PointOnAreas.of(problem, np.ones(problem.size, dtype=bool), _unloaded(problem))
    step = Equations.of(point).step(point)
    return replace(point.moved(step), iterations=1, status="Solved")


def _unloaded(problem: TangentialProblem) -> RawSolution:
    return RawSolution(np.zeros_like(problem.rigid_shift), np.zeros(problem.components))


def _trial(problem: TangentialProblem, at: RawSolution) -> np.ndarray:
    """The natural map before its projection, ``p - E/rho``.

    Any positive rho has the same solutions. In short steps of rolling an element hardly moves
    itself, and all around it do: by its own influence areas would change at random, by the whole
    row they do not.
    """
    return at.traction - shift_of(problem, at) / problem.operator.row_size


def _on_bound(
    problem: TangentialProblem, sticks: np.ndarray, at: RawSolution, towards: np.ndarray
) -> RawSolution:
    """The tractions with those of the slip area on the bound, in the directions of `towards`."""
    size = magnitude(towards)
    on_bound = towards / np.where(size > 0, size, 1.0) * problem.bound
    return RawSolution(np.where(sticks, at.traction, on_bound), at.rigid)


def _on_areas(
    problem: TangentialProblem, sticks: np.ndarray, at: RawSolution, tol: float, deadline: float
) -> tuple[RawSolution, int, bool]:
    """Newton's method on given areas (the paper's point 3), its steps, and whether it converged."""
    at = _on_bound(problem, sticks, at, at.traction)
    point = PointOnAreas.of(problem, sticks, at)
    scale = max(
        float(np.abs(problem.rigid_shift).max()),
        1e-3 * problem.operator.diagonal * float(problem.bound.max()),
    )
    error = np.inf
    previous_error = np.inf
    count = 0
    while count < MAX_NEWTON and error > tol and not previous_error <= error < NEWTON_ROUNDING:
        check_time(deadline)
        count += 1
        previous_error = error
        at = point.moved(Equations.of(point).step(point))
        point = PointOnAreas.of(problem, sticks, at)
        shift = point.shift + problem.potential.flowed(at.traction)
        turned = dot(point.across, shift.take(point.turning, axis=1))
        largest = max(np.abs(shift[:, sticks]).max(initial=0.0), np.abs(turned).max(initial=0.0))
        error = largest / scale
    return at, count, bool(error < max(tol, NEWTON_ROUNDING))


@np.errstate(over="ignore", invalid="ignore")  # in full slip, a step for a force is unbounded
def _descend(
    problem: TangentialProblem, at: RawSolution, max_steps: int, settings: Settings
) -> RawSolution:
    """Newton steps with the areas renewed after each, shortened until the natural map's residual
    falls.
    """
    follow = settings.stats.follow(problem)
    iterate = _Iterate.of(problem, at)
    follow(_admissible(problem, at))
    best = iterate
    residual = _small_residual(problem, best)
    equations = None
    count = 0
    idle = 0
    while count < max_steps and residual > RESIDUAL_MIN:
        # once solved, one step without gain ends the search
        if idle >= (1 if residual <= RESIDUAL_SOLVED else MAX_IDLE_STEPS):
            break
        check_time(settings.deadline)
        count += 1
        iterate, equations = _newton_step(problem, iterate, equations)
        if settings.stats.traces:
            follow(_admissible(problem, iterate.at))
        # steps without gain, and the best point so far
        gain = 0.5 if residual <= RESIDUAL_SOLVED else 0.99
        if iterate.merit < gain * best.merit:
            idle = 0
        else:
            idle += 1
        if iterate.merit < best.merit:
            best = iterate
            residual = _small_residual(problem, best)
    if not math.isfinite(residual):
        residual = _residual(problem, best)
    solved = residual <= RESIDUAL_SOLVED
    status = "Solved" if solved else "MaxIterations"
    return changed(
        _admissible(problem, best.at),
        iterations=count,
        status=status,
        solved=solved,
        residual=residual,
    )


def _newton_step(
    problem: TangentialProblem, iterate: _Iterate, equations: Equations | None
) -> tuple[_Iterate, Equations | None]:
    """Iterate after a Newton step with updated areas, and the equations if the next step can reuse
    them.
    """
    # areas updated, and Newton's equations unless the last ones can be reused
    sticks = ~problem.potential.slips(iterate.trial, problem.operator.row_size)
    traction = np.where(sticks, iterate.at.traction, iterate.image)
    begin = RawSolution(traction, iterate.at.rigid)
    point = PointOnAreas.of(problem, sticks, begin)
    if equations is None or (sticks != equations.sticks).any():
        equations = Equations.of(point)
    # a step, shortened until the merit falls
    after = _line_search(point, equations.step(point, turn=2.0), iterate)
    if after.merit < REUSE_RATIO * iterate.merit:
        return after, equations
    return after, None


@dataclass(frozen=True, eq=False)
class _Iterate:
    """A point of the descent, its shift E, its trial tractions and their image by the natural map
    (c, n), and the norm of what this changes.
    """

    at: RawSolution
    shift: np.ndarray
    trial: np.ndarray
    image: np.ndarray
    merit: float

    @classmethod
    def of(cls, problem: TangentialProblem, at: RawSolution) -> _Iterate:
        weight = problem.operator.row_size
        shift = shift_of(problem, at)
        trial = at.traction - shift / weight
        image = problem.potential.projected(trial, weight)
        error = (at.traction - image).ravel()
        return cls(at, shift, trial, image, math.sqrt(error @ error))


def _line_search(point: PointOnAreas, step: np.ndarray, iterate: _Iterate) -> _Iterate:
    """The first part of a Newton step that lowers the merit enough, or the best of all."""
    best = changed(iterate, merit=np.inf)
    for part in STEP_PARTS:
        candidate = _Iterate.of(point.problem, point.moved(step, part))
        if candidate.merit < best.merit:
            best = candidate
        if best.merit < (1 - 0.1 * part) * iterate.merit:
            break
    return best


def _small_residual(problem: TangentialProblem, iterate: _Iterate) -> float:
    """Residual of an iterate; infinite where the merit shows that it is no solution."""
    tractions = iterate.at.traction.ravel()
    least = iterate.merit / math.sqrt(tractions.size * (tractions @ tractions) or 1.0)
    if least > RESIDUAL_SOLVED:
        return math.inf
    return _residual(problem, iterate)


def _residual(problem: TangentialProblem, iterate: _Iterate) -> float:
    """The natural map's residual of an iterate made admissible, with E by the dense matrix."""
    admissible = _admissible(problem, iterate.at)
    shift = iterate.shift
    if (admissible.traction != iterate.at.traction).any():
        shift = shift_of(problem, admissible)
    return tangential_residual(problem, admissible.traction, admissible.rigid, shift)


def _admissible(problem: TangentialProblem, at: RawSolution) -> RawSolution:
    return RawSolution(project(at.traction, problem.bound), at.rigid)
