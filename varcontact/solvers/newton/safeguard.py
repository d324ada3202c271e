"""What leads Newton's method to the solution: a line search, damping, and steps that converge by themselves."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np

from varcontact.solvers.newton.krylov import Forces, Step

PARTS = (1.0, 0.6, 0.3, 0.15, 0.07, 0.03, 0.01)
"""Of a step, tried one after the other."""
GROWTH = 1.0
"""By which the merit may grow in a step for which none of these lowers it."""
LEAST_DAMPING, FIRST, LARGEST = 0.02, 0.1, 3.0
NEGLIGIBLE = 1e-6
"""Length of a step of Tseng's below which it is not shortened any more."""


BALANCING, BALANCED, LONGEST = 30, 1e-9, 2.0
"""Steps to balance forces, at most; what they may lack of them; the longest step by the trial tractions."""


class Balancing(Protocol):
    """Conditions that know how forces change with rigid shifts."""

    @property
    def forces(self) -> Forces:
        """Prescribed sums."""

    def work(self, trial: np.ndarray, change: np.ndarray) -> tuple[float, np.ndarray, np.ndarray]:
        """The work after a change of the rigid shifts (k,), its slope (k,) and its curvature (k, k).

        Parameters
        ----------
        trial : ndarray, shape (c, ny, nx)
            ``p - E``.
        change : ndarray, shape (k,)
            Of the rigid shifts of the k prescribed forces.

        Returns
        -------
        work : float
        slope : ndarray, shape (k,)
        curvature : ndarray, shape (k, k)
        """


@dataclass(frozen=True, eq=False)
class Point:
    """Tractions with their shift, in the units of the kernel.

    Attributes
    ----------
    traction, shift : ndarray, shape (c, ny, nx)
        p and E.
    rigid : ndarray, shape (c, 1, 1)
        The unknown rigid shifts.
    noise : float
        The error of E by the largest p.
    """

    traction: np.ndarray
    shift: np.ndarray
    rigid: np.ndarray
    noise: float

    def moved(self, step: Step, part: float) -> Point:
        """After a part of a step: E is linear, and no product needed.

        Parameters
        ----------
        step : Step
        part : float
            Of the step, in [0, 1].
        """
        traction = self.traction + part * step.traction
        return Point(traction, self.shift + part * step.shift, self.rigid + part * step.rigid, self.noise)


def balanced(conditions: Balancing, at: Point) -> Point:
    """The point with the rigid shifts at which the tractions of its natural map have the prescribed forces.

    They are where a convex function is least, the work of these tractions against the shift and of the forces against
    the rigid shift; by Newton's method, with steps shortened until it falls.

    Parameters
    ----------
    conditions : Balancing
    at : Point
    """
    forces, trial = conditions.forces, at.traction - at.shift
    change, identity = np.zeros(len(forces.components)), np.eye(len(forces.components))
    work, lacking, stiffness = conditions.work(trial, change)
    for _ in range(BALANCING):
        if not np.abs(lacking).max(initial=0.0) > BALANCED * np.abs(forces.sums).max(initial=1.0):
            break
        direction = -np.linalg.solve(stiffness + 1e-12 * (1 + np.trace(stiffness)) * identity, lacking)
        farthest = LONGEST * float(np.abs(trial).max() + np.abs(change).max())
        length = min(1.0, farthest / float(np.abs(direction).max()))
        while length > NEGLIGIBLE * NEGLIGIBLE:
            there = conditions.work(trial, change + length * direction)
            if there[0] <= work + 1e-4 * length * float(lacking @ direction):
                break
            length *= 0.3
        else:
            break
        change = change + length * direction
        work, lacking, stiffness = there
    rigid = forces.spread(change, len(at.traction))
    return Point(at.traction, at.shift + forces.moved(rigid), at.rigid + rigid, at.noise)


def searched(at: Point, step: Step, merit: Callable[[Point], float], before: float) -> tuple[Point, float, float]:
    """The first part of a step that lowers the merit enough, or the best of all.

    Parameters
    ----------
    at : Point
    step : Step
    merit : callable
        From a point to what shall fall.
    before : float
        The merit of the point.

    Returns
    -------
    point : Point
    merit, part : float
    """
    best, least, chosen = at, np.inf, 0.0
    for part in PARTS:
        there = at.moved(step, part)
        value = merit(there)
        if value < least:
            best, least, chosen = there, value, part
        if value < (1 - 0.1 * part) * before:
            break
    if not least <= GROWTH * before:
        return at, before, 0.0
    return best, least, chosen


def damped(damping: float, part: float, ratio: float) -> float:
    """The damping of the next step.

    Parameters
    ----------
    damping : float
        Of the step before, in units of the kernel.
    part : float
        How much of that was taken, in [0, 1].
    ratio : float
        The merit after it by that before.
    """
    if part < 0.5 or ratio > 0.9:
        return min(max(2 * damping, FIRST), LARGEST)
    return damping / 5 if damping > LEAST_DAMPING else 0.0


def forward_backward_forward(
    at: Point,
    shift: Callable[[np.ndarray, np.ndarray], np.ndarray],
    project: Callable[[np.ndarray], np.ndarray],
    forces: Forces,
    steps: int,
) -> Point:
    """Tseng's splitting, from a point: it converges wherever M is monotone, slowly; two products a step.

    P. Tseng, SIAM J. Control Optim. 38 (2000) 431-446, applied to ``0 in E(p) + normal cone``, and the equations of
    prescribed forces.

    Parameters
    ----------
    at : Point
    shift : callable
        From tractions (c, ny, nx) and rigid shifts (c, 1, 1) to E.
    project : callable
        From tractions to the nearest admissible ones.
    forces : Forces
    steps : int
    """
    components, length = len(at.traction), 1.0
    traction, rigid = project(at.traction), at.rigid

    def field(traction: np.ndarray, rigid: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        return shift(traction, rigid), forces.spread(forces.weight * forces.lacking(traction), components)

    for _ in range(steps):
        E, lacking = field(traction, rigid)
        while True:
            there, moved = project(traction - length * E), rigid - length * lacking
            E_there, lacking_there = field(there, moved)
            change = np.hypot(np.linalg.norm(E_there - E), np.linalg.norm(lacking_there - lacking))
            distance = np.hypot(np.linalg.norm(there - traction), np.linalg.norm(moved - rigid))
            if length * change <= 0.9 * distance or length < NEGLIGIBLE:
                break
            length *= 0.6
        traction = project(there - length * (E_there - E))
        rigid = moved - length * (lacking_there - lacking)
        length *= 1.05
    return replace(at, traction=traction, shift=shift(traction, rigid), rigid=rigid)
