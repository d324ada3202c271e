"""Newton's method on the natural map of a contact problem, inexact and without
a matrix: from a start or coarse grids.

Each step's linear equations are solved by GCR to a rough residual; a line
search keeps it converging. Small problems that it leaves unsolved go to dense
active sets.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any, Generic, TypeVar

import numpy as np

from varcontact.discrete.problems import NormalProblem, RawSolution, TangentialProblem
from varcontact.solvers.interface import Settings, Solver, better, check_time
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
from varcontact.system.process import lazy_property

MAX_STEPS, PATIENCE = 100, 40
"""Newton steps at most, and where active sets can take over: it takes 10 to 30, but for steps of
rolling below dx/20."""
DENSE = 2000
"""Elements up to which a problem that Newton's method leaves unsolved is given to dense active
sets."""
COARSE_TOL = 1e-2
"""Residual on all grids but the finest."""
ROUNDED = 0.9
"""Part of the tolerance to reach, as the certificate rounds differently."""
REFINED, LEAST, REFINING = 1e-3, 1e-12, 4
"""Part of the tolerance that a solved problem of so few elements is refined to, the least residual
that is asked for, and the steps that may take: a tenth of the time, which leaves hardly more than
rounding."""
ROUGH, FINE = 0.3, 1e-2
"""Relative residuals of the linear equations, at first and at least."""
FALLING = 1.5
"""Their power of what the last step left of the residual: Newton's method is as exact as it is
successful."""
NEAR = 30.0
"""Residual, in tolerances, from which a step is to reach the tolerance."""
NOISE, EXACT = 3e-7, 1e-15
"""Error of the shift in single and in double precision, by the largest traction."""

C = TypeVar("C", bound=Conditions)
G = TypeVar("G", bound="GridConditions")


@dataclass(frozen=True, eq=False)
class Problem(ABC, Generic[C]):
    """A contact problem in its own units, judged in double precision."""

    conditions: C

    @abstractmethod
    def shift(self, traction: np.ndarray, rigid: np.ndarray) -> np.ndarray:
        """E on the box, from tractions (c, ny, nx) and rigid shifts (c, 1, 1)."""

    @abstractmethod
    def error(self, at: Point) -> float:
        """The residual or the relative gap of an answer, as a certificate has it: the larger."""

    @abstractmethod
    def physical(self, traction: np.ndarray, rigid: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Tractions and rigid shifts as the solver's caller has them."""


@dataclass(frozen=True, eq=False)
class GridConditions(Conditions):
    """Those of one of the two problems: `bound` (ny, nx) is zero where nothing can act; `plain` has
    equal elements.
    """

    bound: np.ndarray
    plain: Kernel

    @lazy_property
    def contact(self) -> np.ndarray:
        """Where tractions can act."""
        return self.bound > 0

    @property
    def coarsens(self) -> bool:
        """Whether coarse grids lead to a solution sooner."""
        shape = self.bound.shape
        return min(shape if shape[0] > 1 else shape[1:]) >= 2 * LEAST_SIDE and not self.linear

    @property
    def of_step(self) -> bool:
        """Whether the shift is that of a step of rolling, which becomes twice as long with the
        elements.
        """
        return self.plain.circulant.rolling != 0

    def coarser(self: G) -> G:
        """With elements twice as large, in units of displacement that are so, too; and a step that
        is twice as long.
        """
        each, scale = 4 if self.bound.shape[0] > 1 else 2, self.forces.scale
        known = halved_mean(self.known / scale, self.contact) * (1.0 if self.of_step else 0.5)
        bound = halved(self.bound * scale)
        forces = Forces(
            self.forces.components, self.forces.sums / each, 1 / np.sqrt(np.count_nonzero(bound))
        )
        plain = self.plain.halved_in_rolling if self.of_step else self.plain.halved
        return replace(self, kernel=plain, known=known, forces=forces, bound=bound, plain=plain)

    def first(self) -> Point:
        """Where the coarsest grid begins: without tractions."""
        return point(self, np.zeros_like(self.known), np.zeros((len(self.known), 1, 1)))

    def refined(self, at: Point, coarse: GridConditions) -> Point:
        """A point of a coarser grid."""
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
        """From given tractions, which may be near the solution: their shift is in double
        precision.
        """
        scale, forces = self.conditions.forces.scale, self.conditions.forces
        traction = self.box.field(np.atleast_2d(start.traction)) / (self.load * scale)
        traction = self.conditions.admissible(traction, traction)
        rigid = forces.spread(
            self.sign * start.rigid[list(forces.components)] / self.displacement, len(traction)
        )
        return Point(traction, self.shift(traction, rigid), rigid, EXACT)

    def shift(self, traction: np.ndarray, rigid: np.ndarray) -> np.ndarray:
        shift = np.atleast_2d(self.problem.shift(*self.physical(traction, rigid)))
        return self.box.field(shift) / self.displacement * self.conditions.forces.scale

    def physical(self, traction: np.ndarray, rigid: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        values = self.box.values(traction * self.conditions.forces.scale) * self.load
        return values, self.sign * rigid.ravel() * self.displacement


def solve(
    problem: GridProblem[G],
    start: RawSolution | None,
    settings: Settings,
    active_sets: Solver[Any, RawSolution],
) -> RawSolution:
    """Newton's method from a start; without one, or if that fails, from coarse grids; then active
    sets.
    """
    tol, spent, raw = ROUNDED * settings.tol, 0, None
    small = len(problem.box.places) <= DENSE
    most = PATIENCE if small else MAX_STEPS
    if start is not None and start.finite:
        raw = solve_from(problem, problem.initial_guess(start), tol, settings, most)
        spent = raw.iterations
    if raw is None or not raw.solved:
        grids = [problem.conditions]
        while grids[-1].coarsens:
            grids.append(grids[-1].coarser())
        at = grids[-1].first()
        for coarse, fine in pairwise(reversed(grids)):
            at, _, steps = newton(coarse, at, COARSE_TOL, settings)
            at, spent = fine.refined(at, coarse), spent + steps
        raw = solve_from(problem, at, tol, settings, most)
        spent += raw.iterations
    raw = replace(raw, iterations=spent)
    if not small or (raw.solved and settings.loose_tolerance):
        return raw
    if raw.solved:
        found = solve_from(
            problem, problem.initial_guess(raw), max(REFINED * tol, LEAST), settings, REFINING
        )
        refined = replace(
            found, iterations=spent + found.iterations, status=raw.status, solved=True
        )
        return better(problem.problem, raw, refined)
    other = active_sets(problem.problem, settings, raw)
    reason = f"newton missed the tolerance, {other.solver} was used"
    return better(problem.problem, raw, replace(other, iterations=spent, reason=reason))


def solve_from(
    problem: Problem[C], at: Point, tol: float, settings: Settings, most: int
) -> RawSolution:
    at, status, steps = newton(problem.conditions, at, tol, settings, problem, most)
    return RawSolution(*problem.physical(at.traction, at.rigid), steps, status, status == "Solved")


def newton(
    conditions: Conditions,
    at: Point,
    tol: float,
    settings: Settings,
    finest: Problem[C] | None = None,
    most: int = MAX_STEPS,
) -> tuple[Point, str, int]:
    """Solve a contact problem on one grid, from a point, to a residual of the natural map by the
    largest traction.

    With `finest` the answer is judged in double precision; else single precision is enough. Also
    "Solved", "MaxIterations" or "NotANumber", and the steps.
    """
    goal, forces = tol, conditions.forces
    if forces.components and not conditions.linear and np.isfinite(at.shift).all():
        at = balanced(conditions, at)
    best, least, before, idle = at, np.inf, 0.0, 0
    now, room = measured(conditions, at), room_for(at.traction.size, forces)
    for count in range(most):
        check_time(settings.deadline)
        if finest is not None and at.noise > 0.1 * max(now.residual, goal):
            at = replace(at, shift=finest.shift(at.traction, at.rigid), noise=EXACT)
            now = measured(conditions, at)
        if not np.isfinite(now.merit):
            return best, "NotANumber", count
        ny, nx = at.traction.shape[1:]
        settings.stats.tell(f"{nx} x {ny} elements, step {count}, residual {now.residual:.1e}")
        if now.residual < least:
            best, least = at, now.residual
        if now.residual <= goal:
            best = at = _admissible(conditions, at, finest)
            error = 0.0 if finest is None else finest.error(at)
            if error <= tol:
                return at, "Solved", count
            goal *= min(0.3 * tol / error, 0.3)
            now = measured(conditions, at)
            if now.residual == 0:
                break  # no step is left to take
        # as exact as it pays: S. C. Eisenstat and H. F. Walker, SIAM J. Sci. Comput. 17 (1996)
        # 16-32
        left, before = now.residual / before if before else 1.0, now.residual
        near = conditions.linear or now.residual <= NEAR * goal
        enough = float(np.clip(0.3 * goal / now.residual if near else left**FALLING, FINE, ROUGH))
        system, lacking = (
            conditions.linearised(at.traction, at.shift, now.trial),
            forces.lacking(at.traction),
        )
        step = gcr(system, conditions.kernel, forces, lacking, enough, room)
        if not (np.isfinite(step.traction).all() and np.isfinite(step.shift).all()):
            break
        noise = at.noise + NOISE * float(np.abs(step.traction).max()) / now.largest
        at, then = line_search(conditions, at, step, now)
        idle = idle + 1 if then is now else 0
        if idle == 2:
            break  # no part of a step leads down
        at, now = replace(at, noise=noise), then
    return _admissible(conditions, best, finest), "MaxIterations", most


def _admissible(conditions: Conditions, at: Point, finest: Problem[C] | None) -> Point:
    """Admissible tractions, on the finest grid with their shift in double precision."""
    traction = conditions.admissible(at.traction, at.traction - at.shift)
    if finest is None:
        return replace(at, traction=traction)
    return replace(at, traction=traction, shift=finest.shift(traction, at.rigid), noise=EXACT)


def point(conditions: Conditions, traction: np.ndarray, rigid: np.ndarray) -> Point:
    """Tractions (c, ny, nx) and rigid shifts (c, 1, 1) with their shift, in single precision but
    for what is known.
    """
    displacement = conditions.known + rigid * conditions.forces.scale
    return Point(
        traction, displacement + conditions.kernel(traction.astype(np.float32)), rigid, NOISE
    )
