"""Newton's method on the natural map of a contact problem, inexact, on one grid.

Each step's linear equations are solved by GCR to a rough residual; a line search, damping, and in the end steps that
converge by themselves keep it on the way.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from varcontact.problem.tally import Tally
from varcontact.solvers.matrix_free import krylov
from varcontact.solvers.matrix_free.kernel import Kernel
from varcontact.solvers.matrix_free.krylov import Forces, Room, Step, System
from varcontact.solvers.matrix_free.linearisation import dot
from varcontact.solvers.matrix_free.safeguard import (
    Balancing,
    Point,
    balanced,
    damped,
    forward_backward_forward,
    searched,
)

MAX_STEPS = 100
ROUGH, FINE = 0.3, 1e-2
"""Relative residuals of the linear equations: far from the solution, and at most."""
NEAR = 30.0
"""Residual, in tolerances, from which a step is to reach the tolerance."""
NOISE, EXACT = 3e-7, 1e-15
"""Error of the shift in single and in double precision, by the largest traction."""
STUCK, IDLE = 6, 0.999
"""How many more steps without gain than with it lead to others, and what no gain is."""
GUARD_STEPS, GUARD_DAMPING = 20, 0.3


class NewtonSystem(System, Protocol):
    """Newton's equations at given tractions."""

    @property
    def right(self) -> np.ndarray:
        """Right-hand sides (c, ny, nx)."""

    def bent(self, traction: np.ndarray, step: Step) -> Step:
        """The step, better where tractions bend."""


class Conditions(Balancing, Protocol):
    """A contact problem on a box: what Newton's method has to know of it."""

    @property
    def kernel(self) -> Kernel:
        """M."""

    @property
    def known(self) -> np.ndarray:
        """W, (c, ny, nx)."""

    @property
    def forces(self) -> Forces:
        """Prescribed sums."""

    @property
    def linear(self) -> bool:
        """Whether nothing bounds the tractions: Newton's equations are the problem's."""

    def projected(self, trial: np.ndarray) -> np.ndarray:
        """The tractions of the natural map for ``p - E``."""

    def admissible(self, traction: np.ndarray, trial: np.ndarray) -> np.ndarray:
        """Admissible tractions near given ones."""

    def linearised(self, traction: np.ndarray, shift: np.ndarray, trial: np.ndarray, damping: float) -> NewtonSystem:
        """Newton's equations."""


class Finest(Protocol):
    """The problem itself, in double precision."""

    def shift(self, traction: np.ndarray, rigid: np.ndarray) -> np.ndarray:
        """E on the box."""

    def error(self, at: Point) -> float:
        """The residual or the gap of an answer, as a certificate has it: the larger."""


@dataclass(frozen=True, eq=False)
class Result:
    """Where Newton's method ended on a grid.

    Attributes
    ----------
    at : Point
    status : str
        "Solved", "MaxIterations", or "NotANumber".
    steps, iterations, guards : int
        Newton steps, iterations of GCR, and how often steps that converge by themselves were taken.
    """

    at: Point
    status: str
    steps: int
    iterations: int
    guards: int


@dataclass(frozen=True, eq=False)
class _Measure:
    """How far a point is from the solution: the largest error by the largest traction, and the size of all."""

    trial: np.ndarray
    residual: float
    merit: float
    largest: float


def point(conditions: Conditions, traction: np.ndarray, rigid: np.ndarray) -> Point:
    """Tractions with their shift, in single precision."""
    return Point(traction, _shift(conditions)(traction, rigid), rigid, NOISE)


def newton(conditions: Conditions, at: Point, tol: float, tally: Tally, finest: Finest | None = None) -> Result:
    """Solve a contact problem on one grid.

    Parameters
    ----------
    conditions : Conditions
    at : Point
        Where to begin.
    tol : float
        Residual of the natural map to reach, by the largest traction.
    tally : Tally
        Where calls of Tseng's splitting are counted.
    finest : Finest, optional
        Where the answer is to be judged in double precision; else single precision is enough.
    """
    shift = _shift(conditions) if finest is None else finest.shift
    goal, damping, iterations, idle, guards = tol, 0.0, 0, 0, 0
    best, least = at, np.inf
    room = Room.of(at.traction.size, conditions.forces)
    for count in range(MAX_STEPS):
        now = _measured(conditions, at)
        if finest is not None and at.noise > 0.1 * max(now.residual, goal):
            at = Point(at.traction, shift(at.traction, at.rigid), at.rigid, EXACT)
            now = _measured(conditions, at)
        if conditions.forces.components and (count == 0 or damping > 0) and not conditions.linear:
            there = balanced(conditions, at)
            then = _measured(conditions, there)
            if count == 0 or then.merit < now.merit:
                at, now = there, then
        if not np.isfinite(now.merit):
            return Result(best, "NotANumber", count, iterations, guards)
        if now.residual < least:
            best, least = at, now.residual
        if now.residual <= goal:
            traction = conditions.admissible(at.traction, now.trial)
            if finest is None:
                return Result(Point(traction, at.shift, at.rigid, NOISE), "Solved", count, iterations, guards)
            best = at = Point(traction, shift(traction, at.rigid), at.rigid, EXACT)
            error = finest.error(at)
            if error <= tol:
                return Result(at, "Solved", count, iterations, guards)
            goal *= min(0.3 * tol / error, 0.3)
            now = _measured(conditions, at)
        if idle >= STUCK:
            guards, idle, damping = guards + 1, 0, GUARD_DAMPING
            rounds = GUARD_STEPS * guards
            with tally.called("tseng"):
                at = forward_backward_forward(best, shift, conditions.projected, conditions.forces, rounds)
                tally.iterated("tseng", rounds)
            continue
        system = conditions.linearised(at.traction, at.shift, now.trial, damping)
        lacking = conditions.forces.lacking(at.traction)
        near = conditions.linear or now.residual <= NEAR * goal
        enough = float(np.clip(0.3 * goal / now.residual, FINE, ROUGH)) if near else ROUGH
        step = krylov.gcr(system, system.right, conditions.forces, lacking, enough, room)
        iterations += step.iterations
        if not (np.isfinite(step.traction).all() and np.isfinite(step.shift).all()):
            idle = STUCK
            continue
        step = system.bent(at.traction, step)
        noise = at.noise + NOISE * float(np.abs(step.traction).max()) / now.largest
        at, merit, part = searched(at, step, lambda there: _measured(conditions, there).merit, now.merit)
        at = Point(at.traction, at.shift, at.rigid, noise)
        damping = damped(damping, part, merit / now.merit)
        idle = idle + 1 if merit >= IDLE * now.merit else max(idle - 1, 0)
    if finest is not None:
        traction = conditions.admissible(best.traction, best.traction - best.shift)
        best = Point(traction, shift(traction, best.rigid), best.rigid, EXACT)
    return Result(best, "MaxIterations", MAX_STEPS, iterations, guards)


def _shift(conditions: Conditions) -> Callable[[np.ndarray, np.ndarray], np.ndarray]:
    """E of tractions and rigid shifts, in single precision but for what is known."""

    def shift(traction: np.ndarray, rigid: np.ndarray) -> np.ndarray:
        return conditions.known + rigid + conditions.kernel(traction.astype(np.float32))

    return shift


def _measured(conditions: Conditions, at: Point) -> _Measure:
    trial = at.traction - at.shift
    image = conditions.projected(trial)
    error, lacking = at.traction - image, conditions.forces.lacking(at.traction)
    square = dot(error, error)
    largest = float(np.sqrt(max(dot(at.traction, at.traction).max(), dot(image, image).max())))
    largest = largest if largest > 0 else 1.0
    residual = max(float(np.sqrt(square.max())), float(np.abs(lacking).max(initial=0.0))) / largest
    return _Measure(trial, residual, float(np.sqrt(square.sum() + lacking @ lacking)), largest)
