"""Newton's method on the natural map of a contact problem, inexact and without
a matrix: from a start or coarse grids.

Each step's linear equations are solved by GCR to a rough residual; a line
search keeps it converging.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Generic, TypeVar

import numpy as np

from varcontact.discrete.problems import NormalProblem, RawSolution, TangentialProblem
from varcontact.solvers.interface import Settings, SolveStats, check_time
from varcontact.solvers.newton.gcr import Forces, gcr, room_for
from varcontact.solvers.newton.globalisation import (
    Conditions,
    Point,
    balanced,
    line_search,
    measured,
)
from varcontact.solvers.newton.hierarchy import LEAST_SIDE, Box, doubled, halved, halved_mean
from varcontact.solvers.newton.kernel import Kernel
from varcontact.system.process import changed, lazy_property

MAX_STEPS = 40
"""Largest number of Newton steps: 10 to 30 are usual, except for rolling steps below dx/20, which
are left to splitting."""
REFINED_ELEMENTS_MAX = 2000
"""Elements up to which a solved problem is refined further."""
COARSE_TOL = 5e-2
"""Residual to reach on all grids but the finest."""
ROUNDED = 0.9
"""Factor on the tolerance to be reached, as the certificate rounds differently."""
REFINED_PART = 1e-3
"""Factor on the tolerance for this refinement of a solved problem."""
REFINED_TOL_MIN = 1e-12
"""Least tolerance of that refinement."""
REFINED_STEPS = 4
"""Largest number of Newton steps of that refinement, a tenth of the time; they leave hardly more
than rounding."""
GCR_TOL_MAX = 0.3
GCR_TOL_MIN = 1e-5
"""Relative residuals of the linear equations, at most and at least."""
GCR_TOL_FACTOR = 3.0
"""Factor on the square of the residual, to which the linear equations of a step are solved:
Newton's method leaves a few times the square."""
LAST_STEP_PART = 0.3
"""Part of the goal to which the linear equations of the last step are solved."""
LACKING_PART = 0.01
"""Largest share of missing forces in the errors of a start: GCR hardly converges where they are all
of it."""
NOISE_SINGLE = 3e-7
NOISE_DOUBLE = 1e-15
"""Error of the shift in single and in double precision, relative to the largest traction."""

C = TypeVar("C", bound=Conditions)
G = TypeVar("G", bound="GridConditions")


def ignored_point(at: Point) -> None:
    """Follower that records nothing."""


@dataclass(frozen=True, eq=False)
class Problem(ABC, Generic[C]):
    """Contact problem in its own units, evaluated in double precision."""

    conditions: C

    @abstractmethod
    def shift(self, traction: np.ndarray, rigid: np.ndarray) -> np.ndarray:
        """E on the box, from tractions (c, ny, nx) and rigid shifts (c, 1, 1)."""

    @abstractmethod
    def error(self, at: Point) -> float:
        """Error of an answer as in a certificate: the larger of residual and relative gap."""

    @abstractmethod
    def physical(self, traction: np.ndarray, rigid: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Tractions and rigid shifts in the units of the solver's caller."""

    @abstractmethod
    def follower(self, stats: SolveStats) -> Callable[[Point], None]:
        """The function that records points on the way."""


@dataclass(frozen=True, eq=False)
class GridConditions(Conditions):
    """Conditions of one of the two problems: `bound` (ny, nx) is zero where nothing can act;
    `plain` has equal elements.
    """

    bound: np.ndarray
    plain: Kernel

    @lazy_property
    def contact(self) -> np.ndarray:
        """Elements where tractions can act."""
        return self.bound > 0

    @property
    def slides(self) -> bool:
        """True for tractions, which slide at their bound; False for pressures."""
        return True

    @abstractmethod
    def proximal(self, trial: np.ndarray, weight: float) -> np.ndarray:
        """The proximal map of the potential, of trial tractions ``p - E/weight``."""

    @abstractmethod
    def sticks(self, trial: np.ndarray, weight: float) -> np.ndarray:
        """Elements (ny, nx) whose trial tractions ``p - E/weight`` are within their bound."""

    @property
    def coarsens(self) -> bool:
        """True where a start from coarse grids is faster."""
        ny, nx = self.bound.shape
        side = min(ny, nx) if ny > 1 else nx
        return side >= 2 * LEAST_SIDE and not self.linear

    @property
    def of_step(self) -> bool:
        """True where the shift is that of a rolling step, which doubles with the element size."""
        return self.plain.circulant.rolling != 0

    def coarser(self: G) -> G:
        """Conditions on elements twice as large, in displacement units twice as large, and a step
        twice as long.
        """
        scale = self.forces.scale
        if self.of_step:
            plain = self.plain.halved_in_rolling
            unit = 1.0
        else:
            plain = self.plain.halved
            unit = 0.5
        known = halved_mean(self.known / scale, self.contact) * unit
        bound = halved(self.bound * scale)
        small_elements = 4 if self.bound.shape[0] > 1 else 2
        sums = self.forces.sums / small_elements
        forces = Forces(self.forces.components, sums, 1 / np.sqrt(np.count_nonzero(bound)))
        return replace(self, kernel=plain, known=known, forces=forces, bound=bound, plain=plain)

    def first(self) -> Point:
        """Start of the coarsest grid: no tractions."""
        return point(self, np.zeros_like(self.known), np.zeros((len(self.known), 1, 1)))

    def sliding(self) -> Point | None:
        """Tractions at the bound in full slip; None where they would stick somewhere, and for
        pressures.
        """
        return None

    def refined(self, at: Point, coarse: GridConditions) -> Point:
        """Point interpolated from a coarser grid."""
        traction = doubled(at.traction, coarse.contact, self.bound.shape)
        return point(self, self.projected(traction), at.rigid * (1.0 if self.of_step else 2.0))


@dataclass(frozen=True, eq=False)
class GridProblem(Problem[G]):
    """One of the two problems, on the box around its elements.

    `load` is the traction, `displacement` the distance or shift that counts as one; rigid shifts
    are `sign` times those of the problem.
    """

    problem: NormalProblem | TangentialProblem
    box: Box
    load: float
    displacement: float
    sign: float = 1.0

    def initial_guess(self, start: RawSolution) -> Point:
        """Point of given tractions, which may be near the solution: their shift is in double
        precision.
        """
        forces = self.conditions.forces
        traction = self.box.field(np.atleast_2d(start.traction)) / (self.load * forces.scale)
        traction = self.conditions.admissible(traction, traction)
        unknown = self.sign * start.rigid[list(forces.components)] / self.displacement
        rigid = forces.spread(unknown, len(traction))
        return Point(traction, self.shift(traction, rigid), rigid, NOISE_DOUBLE)

    def shift(self, traction: np.ndarray, rigid: np.ndarray) -> np.ndarray:
        shift = np.atleast_2d(self.problem.shift(*self.physical(traction, rigid)))
        return self.box.field(shift) / self.displacement * self.conditions.forces.scale

    def follower(self, stats: SolveStats) -> Callable[[Point], None]:
        if not stats.traces:
            return ignored_point
        follow = stats.follow(self.problem)
        return lambda at: follow(RawSolution(*self.physical(at.traction, at.rigid)))

    def physical(self, traction: np.ndarray, rigid: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        values = self.box.values(traction * self.conditions.forces.scale) * self.load
        return values, self.sign * rigid.ravel() * self.displacement


def solve(problem: GridProblem[G], start: RawSolution | None, settings: Settings) -> RawSolution:
    """Newton's method from a start; without one, or if that fails, from coarse grids."""
    tol = ROUNDED * settings.tol
    refined_tol = tol
    if len(problem.box.places) <= REFINED_ELEMENTS_MAX and not settings.loose_tolerance:
        refined_tol = min(tol, max(REFINED_PART * tol, REFINED_TOL_MIN))
    steps = 0
    # from the start
    if start is not None and start.finite:
        raw = solve_from(problem, problem.initial_guess(start), tol, settings, refined_tol)
        if raw.solved:
            return raw
        steps = raw.iterations
    # from tractions in full slip, or from coarse grids
    at = problem.conditions.sliding()
    coarse_steps = 0
    if at is None:
        at, coarse_steps = _from_coarse_grids(problem.conditions, settings)
    raw = solve_from(problem, at, tol, settings, refined_tol)
    return changed(raw, iterations=steps + coarse_steps + raw.iterations)


def _from_coarse_grids(conditions: GridConditions, settings: Settings) -> tuple[Point, int]:
    """A point on the finest grid, and the Newton steps on the coarse ones."""
    grids = [conditions]
    while grids[-1].coarsens:
        grids.append(grids[-1].coarser())
    at = grids[-1].first()
    steps = 0
    for coarse, fine in pairwise(reversed(grids)):
        at, _, coarse_steps, _ = newton(coarse, at, COARSE_TOL, settings)
        at = fine.refined(at, coarse)
        steps += coarse_steps
    return at, steps


def solve_from(
    problem: Problem[C],
    at: Point,
    tol: float,
    settings: Settings,
    refined_tol: float | None = None,
    max_steps: int = MAX_STEPS,
) -> RawSolution:
    conditions = problem.conditions
    at, status, steps, error = newton(
        conditions, at, tol, settings, problem, refined_tol, max_steps
    )
    traction, rigid = problem.physical(at.traction, at.rigid)
    return RawSolution(traction, rigid, steps, status, status == "Solved", residual=error)


@dataclass
class _Goal:
    """Residual that a run aims at, and the step at which it ends: a few steps beyond the
    tolerance.
    """

    tol: float
    refined_tol: float
    end: int
    residual: float
    status: str = "MaxIterations"

    def reached(self, error: float, count: int) -> bool:
        """True where the refined tolerance is reached; else the goal is lowered."""
        solved = self.status == "Solved"
        if error <= self.tol:
            self.status = "Solved"
        if error <= self.refined_tol:
            return True
        if self.status != "Solved":
            self.residual *= min(0.3 * self.tol / error, 0.3)
        elif solved:
            self.residual *= 0.3
        else:
            self.residual = self.refined_tol
            self.end = min(self.end, count + REFINED_STEPS)
        return False


def newton(
    conditions: Conditions,
    at: Point,
    tol: float,
    settings: Settings,
    finest: Problem[C] | None = None,
    refined_tol: float | None = None,
    max_steps: int = MAX_STEPS,
) -> tuple[Point, str, int, float]:
    """Solve a contact problem on one grid, from a point, to a residual of the natural map relative
    to the largest traction.

    With `finest` the answer is judged in double precision; else single precision is enough. With a
    `refined_tol` a few more steps lead towards that. Also "Solved", "MaxIterations" or
    "NotANumber", the steps, and the error where it was judged, else NaN.
    """
    goal = _Goal(tol, refined_tol or tol, end=max_steps, residual=tol)
    forces = conditions.forces
    at = _with_forces(conditions, at)
    now = measured(conditions, at)
    best = at
    least = np.inf
    idle = 0
    count = 0
    room = room_for(at.traction.size, forces)
    follow = _follower(finest, settings)
    while count < goal.end:
        check_time(settings.deadline)
        # E in double precision where its error is more than a step is to leave
        if at.noise > _residual_after(now.residual, goal, conditions.linear):
            at = _in_double_precision(at, finest)
            now = measured(conditions, at)
        if not np.isfinite(now.merit):
            return best, "NotANumber", count, math.nan
        ny, nx = at.traction.shape[1:]
        settings.stats.tell(f"{nx} x {ny} elements, step {count}, residual {now.residual:.1e}")
        follow(at)
        if now.residual < least:
            best = at
            least = now.residual
        # admissible tractions are evaluated as by the certificate
        if now.residual <= goal.residual:
            at = _admissible(conditions, at, finest)
            best = at
            error = _error(at, finest)
            if goal.reached(error, count):
                return at, "Solved", count, error
            now = measured(conditions, at)
            if now.residual == 0:
                break  # no step is left to take
        # a step, and a line search
        gcr_tol = _residual_after(now.residual, goal, conditions.linear) / now.residual
        system = conditions.linearised(at.traction, at.shift, now.trial)
        lacking = forces.lacking(at.traction)
        step = gcr(system, conditions.kernel, forces, lacking, gcr_tol, room)
        if not step.finite:
            break
        noise = at.noise + NOISE_SINGLE * float(np.abs(step.traction).max()) / now.largest
        at, measure = line_search(conditions, at, step, now)
        count += 1
        idle = idle + 1 if measure is now else 0
        if idle == 2:
            break  # no part of the step decreases the merit
        at = changed(at, noise=noise)
        now = measure
    return _admissible(conditions, best, finest), goal.status, count, math.nan


def _with_forces(conditions: Conditions, at: Point) -> Point:
    """Start of Newton's method, balanced if the missing forces are more than a small part of its
    errors.
    """
    lacking = conditions.forces.lacking(at.traction)
    if np.linalg.norm(lacking) <= LACKING_PART * measured(conditions, at).merit:
        return at
    return balanced(conditions, at)


def _follower(finest: Problem[C] | None, settings: Settings) -> Callable[[Point], None]:
    """The function that records points on the finest grid."""
    if finest is None:
        return ignored_point
    return finest.follower(settings.stats)


def _error(at: Point, finest: Problem[C] | None) -> float:
    """Error as a certificate has it; zero on coarse grids."""
    return 0.0 if finest is None else finest.error(at)


def _residual_after(residual: float, goal: _Goal, linear: bool) -> float:
    """Residual to be left by a step, as small as worthwhile: what Newton's method leaves by itself,
    or the goal.
    """
    after = LAST_STEP_PART * min(goal.residual, goal.refined_tol)
    if not linear:
        after = max(after, GCR_TOL_FACTOR * residual**2)
    return min(max(after, GCR_TOL_MIN * residual), GCR_TOL_MAX * residual)


def _admissible(conditions: Conditions, at: Point, finest: Problem[C] | None) -> Point:
    """Admissible tractions, on the finest grid with their shift in double precision."""
    at = changed(at, traction=conditions.admissible(at.traction, at.traction - at.shift))
    return _in_double_precision(at, finest)


def _in_double_precision(at: Point, finest: Problem[C] | None) -> Point:
    """Point with its shift recomputed in double precision; unchanged on coarse grids."""
    if finest is None:
        return at
    return changed(at, shift=finest.shift(at.traction, at.rigid), noise=NOISE_DOUBLE)


def point(conditions: Conditions, traction: np.ndarray, rigid: np.ndarray) -> Point:
    """Tractions (c, ny, nx) and rigid shifts (c, 1, 1) with their shift, its elastic part in single
    precision.
    """
    displacement = conditions.known + rigid * conditions.forces.scale
    shift = displacement + conditions.kernel(traction.astype(np.float32))
    return Point(traction, shift, rigid, NOISE_SINGLE)
