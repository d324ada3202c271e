"""Newton's method on the natural map of a contact problem, inexact and without a matrix: from a start or coarse grids.

Each step's linear equations are solved by GCR to a rough residual; a line search and damping keep it converging.
Small problems that it leaves unsolved go to dense active sets.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Generic, TypeVar

import numpy as np

from varcontact.discrete.problems import RawSolution
from varcontact.solvers.interface import Settings, check_time
from varcontact.solvers.newton.gcr import gcr, room_for
from varcontact.solvers.newton.globalisation import Conditions, Point, balanced, line_search, measured, next_damping
from varcontact.solvers.newton.hierarchy import Box

MAX_STEPS, PATIENCE = 100, 40
"""Newton steps at most, and where active sets can take over: it takes 10 to 30, but for steps of rolling below
dx/20."""
DENSE = 2000
"""Elements up to which a problem that Newton's method leaves unsolved is given to dense active sets."""
COARSE_TOL = 1e-2
"""Residual on all grids but the finest."""
ROUNDED = 0.9
"""Part of the tolerance to reach, as the certificate rounds differently."""
REFINED, LEAST, REFINING = 1e-3, 1e-12, 4
"""Part of the tolerance that a solved problem of so few elements is refined to, the least residual that is asked for,
and the steps that may take: a tenth of the time, which leaves hardly more than rounding."""
ROUGH, FINE = 0.3, 1e-2
"""Relative residuals of the linear equations, at first and at least."""
FALLING = 1.5
"""Their power of what the last step left of the residual: Newton's method is as exact as it is successful."""
NEAR = 30.0
"""Residual, in tolerances, from which a step is to reach the tolerance."""
NOISE, EXACT = 3e-7, 1e-15
"""Error of the shift in single and in double precision, by the largest traction."""

C = TypeVar("C", bound=Conditions)


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
class GridProblem(Problem[C]):
    """One that coarser grids lead to, and that dense active sets solve, too.

    `load` is the traction, `displacement` the distance or shift that counts as one.
    """

    box: Box
    load: float
    displacement: float
    settings: Settings

    @abstractmethod
    def initial_guess(self, start: RawSolution) -> Point:
        """Where a start leads."""

    @abstractmethod
    def coarser(self, fine: C) -> C | None:
        """The problem with elements twice as large, if that is fine enough to help."""

    @abstractmethod
    def first(self, coarsest: C) -> Point:
        """Where the coarsest grid begins."""

    @abstractmethod
    def finer(self, at: Point, coarse: C, fine: C) -> Point: ...

    @abstractmethod
    def residual(self, raw: RawSolution) -> float: ...

    @abstractmethod
    def by_active_sets(self, near: RawSolution) -> RawSolution: ...


def solve(problem: GridProblem[C], start: RawSolution | None, settings: Settings) -> RawSolution:
    """Newton's method from a start; without one, or if that fails, from coarse grids; then active sets."""
    tol, spent, raw = ROUNDED * settings.tol, 0, None
    small = len(problem.box.places) <= DENSE
    most = PATIENCE if small else MAX_STEPS
    if start is not None and start.finite:
        raw = solve_from(problem, problem.initial_guess(start), tol, settings, most)
        spent = raw.iterations
    if raw is None or not raw.solved:
        at, steps = _from_coarse_grids(problem, settings)
        raw = solve_from(problem, at, tol, settings, most)
        spent += steps + raw.iterations
    raw = replace(raw, iterations=spent)
    if not small or (raw.solved and settings.loose_tolerance):
        return raw
    if raw.solved:
        fine = solve_from(problem, problem.initial_guess(raw), max(REFINED * tol, LEAST), settings, REFINING)
        if not problem.residual(fine) < problem.residual(raw):
            return raw
        return replace(fine, iterations=spent + fine.iterations, status=raw.status, solved=True)
    other = problem.by_active_sets(raw)
    if not (other.finite and problem.residual(other) < problem.residual(raw)):
        return raw
    return replace(other, iterations=spent, reason=f"newton missed the tolerance, {other.solver} was used")


def solve_from(problem: Problem[C], at: Point, tol: float, settings: Settings, most: int) -> RawSolution:
    at, status, steps = newton(problem.conditions, at, tol, settings, problem, most)
    return RawSolution(*problem.physical(at.traction, at.rigid), steps, status, status == "Solved")


def _from_coarse_grids(problem: GridProblem[C], settings: Settings) -> tuple[Point, int]:
    """Where coarser grids lead, and the Newton steps taken there."""
    grids = [problem.conditions]
    while (coarser := problem.coarser(grids[-1])) is not None:
        grids.append(coarser)
    at, steps = problem.first(grids[-1]), 0
    for coarse, fine in pairwise(reversed(grids)):
        at, _, count = newton(coarse, at, COARSE_TOL, settings)
        at, steps = problem.finer(at, coarse, fine), steps + count
    return at, steps


def newton(
    conditions: Conditions,
    at: Point,
    tol: float,
    settings: Settings,
    finest: Problem[C] | None = None,
    most: int = MAX_STEPS,
) -> tuple[Point, str, int]:
    """Solve a contact problem on one grid, from a point, to a residual of the natural map by the largest traction.

    With `finest` the answer is judged in double precision; else single precision is enough. Also "Solved",
    "MaxIterations" or "NotANumber", and the steps.
    """
    goal, damping = tol, 0.0
    best, least, before = at, np.inf, 0.0
    forces, now = conditions.forces, measured(conditions, at)
    room = room_for(at.traction.size, forces)
    for count in range(most):
        check_time(settings.deadline)
        if finest is not None and at.noise > 0.1 * max(now.residual, goal):
            at = replace(at, shift=finest.shift(at.traction, at.rigid), noise=EXACT)
            now = measured(conditions, at)
        if forces.components and not conditions.linear and (count == 0 or damping > 0) and np.isfinite(now.merit):
            there = balanced(conditions, at)
            then = measured(conditions, there)
            if count == 0 or then.merit < now.merit:
                at, now = there, then
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
        # as exact as it pays: S. C. Eisenstat and H. F. Walker, SIAM J. Sci. Comput. 17 (1996) 16-32
        left, before = now.residual / before if before else 1.0, now.residual
        near = conditions.linear or now.residual <= NEAR * goal
        enough = float(np.clip(0.3 * goal / now.residual if near else left**FALLING, FINE, ROUGH))
        system, lacking = conditions.linearised(at.traction, at.shift, now.trial, damping), forces.lacking(at.traction)
        step = gcr(system, conditions.kernel, forces, lacking, enough, room)
        if not (np.isfinite(step.traction).all() and np.isfinite(step.shift).all()):
            break
        noise = at.noise + NOISE * float(np.abs(step.traction).max()) / now.largest
        at, then, part = line_search(conditions, at, step, now)
        at = replace(at, noise=noise)
        damping = next_damping(damping, part, then.merit / now.merit)
        now = then
    return _admissible(conditions, best, finest), "MaxIterations", most


def _admissible(conditions: Conditions, at: Point, finest: Problem[C] | None) -> Point:
    """Admissible tractions, on the finest grid with their shift in double precision."""
    traction = conditions.admissible(at.traction, at.traction - at.shift)
    if finest is None:
        return replace(at, traction=traction)
    return replace(at, traction=traction, shift=finest.shift(traction, at.rigid), noise=EXACT)


def point(conditions: Conditions, traction: np.ndarray, rigid: np.ndarray) -> Point:
    """Tractions (c, ny, nx) and rigid shifts (c, 1, 1) with their shift, in single precision but for what is known."""
    displacement = conditions.known + conditions.forces.displacement(rigid)
    return Point(traction, displacement + conditions.kernel(traction.astype(np.float32)), rigid, NOISE)
