"""Newton's method on the natural map of a contact problem, inexact, on one grid.

Each step's linear equations are solved by GCR to a rough residual; a line search, damping, and, where these fail,
steps of Tseng's splitting keep it converging.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np

from varcontact.solvers.newton import krylov
from varcontact.solvers.newton.krylov import Forces, Room, Step, System
from varcontact.solvers.newton.linearisation import dot
from varcontact.solvers.newton.safeguard import (
    LARGEST,
    Balancing,
    Point,
    balanced,
    damped,
    forward_backward_forward,
    searched,
)
from varcontact.solvers.settings import Settings, check_time
from varcontact.solvers.statistics import SolveStats

MAX_STEPS = 100
ROUGH, FINE = 0.3, 1e-2
"""Relative residuals of the linear equations, at first and at least."""
FALLING = 1.5
"""Their power of what the last step left of the residual: Newton's method is as exact as it is successful."""
NEAR = 30.0
"""Residual, in tolerances, from which a step is to reach the tolerance."""
NOISE, EXACT = 3e-7, 1e-15
"""Error of the shift in single and in double precision, by the largest traction."""
STUCK, IDLE = 6, 0.999
"""How many more steps without gain than with it lead to others, and what no gain is."""
CRAWLING = 10
"""Steps in a row under the largest damping after which it is lifted."""
GUARD_STEPS, GUARD_DAMPING = 20, 0.3


class NewtonSystem(System, Protocol):
    """Newton's equations at given tractions."""

    @property
    def right(self) -> np.ndarray:
        """Right-hand sides (c, ny, nx)."""

    def bent(self, traction: np.ndarray, step: Step) -> Step:
        """The step, better where tractions bend.

        Parameters
        ----------
        traction : ndarray, shape (c, ny, nx)
        step : Step
        """


class Conditions(Balancing, Protocol):
    """A contact problem on a box: what Newton's method has to know of it."""

    @property
    def kernel(self) -> Callable[[np.ndarray], np.ndarray]:
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
        """The tractions of the natural map.

        Parameters
        ----------
        trial : ndarray, shape (c, ny, nx)
            ``p - E``.

        Returns
        -------
        ndarray, shape (c, ny, nx)
        """

    def admissible(self, traction: np.ndarray, trial: np.ndarray) -> np.ndarray:
        """Admissible tractions near given ones.

        Parameters
        ----------
        traction, trial : ndarray, shape (c, ny, nx)
            p and ``p - E``.

        Returns
        -------
        ndarray, shape (c, ny, nx)
        """

    def linearised(self, traction: np.ndarray, shift: np.ndarray, trial: np.ndarray, damping: float) -> NewtonSystem:
        """Newton's equations.

        Parameters
        ----------
        traction, shift, trial : ndarray, shape (c, ny, nx)
            p, E and ``p - E``.
        damping : float
            Added to the diagonal of M, in units of the kernel.
        """


class Finest(Protocol):
    """The problem itself, in double precision."""

    def shift(self, traction: np.ndarray, rigid: np.ndarray) -> np.ndarray:
        """E on the box.

        Parameters
        ----------
        traction : ndarray, shape (c, ny, nx)
            In units of the kernel.
        rigid : ndarray, shape (c, 1, 1)
            The unknown rigid shifts.

        Returns
        -------
        ndarray, shape (c, ny, nx)
        """

    def error(self, at: Point) -> float:
        """The residual or the gap of an answer, as a certificate has it: the larger.

        Parameters
        ----------
        at : Point

        Returns
        -------
        float
            Relative [-].
        """


@dataclass(frozen=True, eq=False)
class Result:
    """Where Newton's method ended on a grid.

    Attributes
    ----------
    at : Point
    status : str
        "Solved", "MaxIterations", or "NotANumber".
    steps : int
        Newton steps.
    """

    at: Point
    status: str
    steps: int


@dataclass(frozen=True, eq=False)
class _Measure:
    """How far a point is from the solution: the largest error by the largest traction, and the size of all."""

    trial: np.ndarray
    residual: float
    merit: float
    largest: float


def point(conditions: Conditions, traction: np.ndarray, rigid: np.ndarray) -> Point:
    """Tractions with their shift, in single precision.

    Parameters
    ----------
    conditions : Conditions
    traction : ndarray, shape (c, ny, nx)
        In units of the kernel.
    rigid : ndarray, shape (c, 1, 1)
        The unknown rigid shifts.
    """
    return Point(traction, _shift(conditions)(traction, rigid), rigid, NOISE)


def newton(
    conditions: Conditions,
    at: Point,
    tol: float,
    settings: Settings,
    finest: Finest | None = None,
    most: int = MAX_STEPS,
) -> Result:
    """Solve a contact problem on one grid.

    Parameters
    ----------
    conditions : Conditions
    at : Point
        Where to begin.
    tol : float
        Residual of the natural map to reach, by the largest traction.
    settings : Settings
        Where calls of Tseng's splitting are counted, and the deadline.
    finest : Finest, optional
        Where the answer is to be judged in double precision; else single precision is enough.
    most : int
        Steps.
    """
    goal, damping, idle, guards, crawled = tol, 0.0, 0, 0, 0
    best, least, before = at, np.inf, 0.0
    room = Room.of(at.traction.size, conditions.forces)
    for count in range(most):
        check_time(settings.deadline)
        at, now = _seen(conditions, at, goal, finest)
        if count == 0 or damping > 0:
            at, now = _balanced(conditions, at, now, in_any_case=count == 0)
        if not np.isfinite(now.merit):
            return Result(best, "NotANumber", count)
        ny, nx = at.traction.shape[1:]
        settings.stats.tell(f"{nx} x {ny} elements, step {count}, residual {now.residual:.1e}")
        if now.residual < least:
            best, least = at, now.residual
        if now.residual <= goal:
            best = at = _admissible(conditions, at, finest)
            error = 0.0 if finest is None else finest.error(at)
            if error <= tol:
                return Result(at, "Solved", count)
            goal *= min(0.3 * tol / error, 0.3)
            now = _measured(conditions, at)
        if idle >= STUCK:
            guards, idle, damping = guards + 1, 0, GUARD_DAMPING
            at = _guarded(conditions, best, GUARD_STEPS * guards, settings.stats, finest)
            continue
        step = _step(conditions, at, now, goal, damping, room, now.residual / before if before else 1.0)
        before = now.residual
        if not (np.isfinite(step.traction).all() and np.isfinite(step.shift).all()):
            idle = STUCK
            continue
        noise = at.noise + NOISE * float(np.abs(step.traction).max()) / now.largest
        at, merit, part = searched(at, step, lambda there: _measured(conditions, there).merit, now.merit)
        at = replace(at, noise=noise)
        damping = damped(damping, part, merit / now.merit)
        crawled = crawled + 1 if damping >= LARGEST else 0
        if crawled >= CRAWLING:
            damping, crawled = 0.0, 0
        idle = idle + 1 if merit >= IDLE * now.merit else max(idle - 1, 0)
    return Result(_admissible(conditions, best, finest), "MaxIterations", most)


def _seen(conditions: Conditions, at: Point, goal: float, finest: Finest | None) -> tuple[Point, _Measure]:
    """A point and how far it is from the solution, with its shift in double precision where noise would be seen."""
    now = _measured(conditions, at)
    if finest is None or at.noise <= 0.1 * max(now.residual, goal):
        return at, now
    at = replace(at, shift=finest.shift(at.traction, at.rigid), noise=EXACT)
    return at, _measured(conditions, at)


def _balanced(conditions: Conditions, at: Point, now: _Measure, in_any_case: bool) -> tuple[Point, _Measure]:
    """With rigid shifts at which prescribed forces are there, where that brings it nearer."""
    if conditions.linear or not conditions.forces.components or not np.isfinite(now.merit):
        return at, now
    there = balanced(conditions, at)
    then = _measured(conditions, there)
    return (there, then) if in_any_case or then.merit < now.merit else (at, now)


def _step(
    conditions: Conditions, at: Point, now: _Measure, goal: float, damping: float, room: Room, left: float
) -> Step:
    """Newton's step, as exact as it pays, which what the last one `left` of the residual tells.

    Eisenstat and Walker, SIAM J. Sci. Comput. 17 (1996) 16-32.
    """
    system = conditions.linearised(at.traction, at.shift, now.trial, damping)
    near = conditions.linear or now.residual <= NEAR * goal
    enough = float(np.clip(0.3 * goal / now.residual if near else left**FALLING, FINE, ROUGH))
    lacking = conditions.forces.lacking(at.traction)
    return system.bent(at.traction, krylov.gcr(system, system.right, conditions.forces, lacking, enough, room))


def _guarded(conditions: Conditions, at: Point, steps: int, stats: SolveStats, finest: Finest | None) -> Point:
    """After steps that converge wherever M is monotone."""
    shift = _shift(conditions) if finest is None else finest.shift
    with stats.called("tseng"):
        at = forward_backward_forward(at, shift, conditions.projected, conditions.forces, steps)
        stats.iterated("tseng", steps)
    return replace(at, noise=NOISE if finest is None else EXACT)


def _admissible(conditions: Conditions, at: Point, finest: Finest | None) -> Point:
    """Admissible tractions, on the finest grid with their shift in double precision."""
    traction = conditions.admissible(at.traction, at.traction - at.shift)
    if finest is None:
        return replace(at, traction=traction)
    return replace(at, traction=traction, shift=finest.shift(traction, at.rigid), noise=EXACT)


def _shift(conditions: Conditions) -> Callable[[np.ndarray, np.ndarray], np.ndarray]:
    """E of tractions and rigid shifts, in single precision but for what is known."""

    def shift(traction: np.ndarray, rigid: np.ndarray) -> np.ndarray:
        return conditions.known + conditions.forces.moved(rigid) + conditions.kernel(traction.astype(np.float32))

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
