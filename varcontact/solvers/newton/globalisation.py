"""Globalisation of Newton's method: line search, balanced forces."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass

import numpy as np

from varcontact.interfaces.potential import dot
from varcontact.solvers.newton.gcr import Forces, Step, System
from varcontact.solvers.newton.kernel import Product
from varcontact.system.process import changed

STEP_PARTS = (1.0, 0.6, 0.3, 0.15, 0.07, 0.03, 0.01)
"""Parts of a Newton step, tried one after the other."""


@dataclass(frozen=True, eq=False)
class Conditions(ABC):
    """A dimensionless contact problem on a box for Newton's method; fields are (c, ny, nx)."""

    kernel: Product
    known: np.ndarray
    forces: Forces

    @property
    def linear(self) -> bool:
        """True where nothing bounds the tractions: Newton's equations are then the problem's."""
        return False

    @abstractmethod
    def projected(self, trial: np.ndarray) -> np.ndarray:
        """The tractions of the natural map, from the trial tractions ``p - E``."""

    @abstractmethod
    def admissible(self, traction: np.ndarray, trial: np.ndarray) -> np.ndarray: ...

    @abstractmethod
    def linearised(self, traction: np.ndarray, shift: np.ndarray, trial: np.ndarray) -> System:
        """Newton's equations."""


@dataclass(frozen=True, eq=False)
class Point:
    """Tractions p and their shift E (c, ny, nx), rigid shifts (c, 1, 1), and the rounding error of
    E relative to the largest p.
    """

    traction: np.ndarray
    shift: np.ndarray
    rigid: np.ndarray
    noise: float


def balanced(conditions: Conditions, at: Point) -> Point:
    """Point with the rigid shifts at which the tractions of its natural map have the prescribed
    forces; unchanged if none are prescribed.
    """
    from scipy.optimize import root

    forces = conditions.forces
    if not forces.components or conditions.linear or not np.isfinite(at.shift).all():
        return at
    trial = at.traction - at.shift
    components = len(at.traction)

    def lacking(change: np.ndarray) -> np.ndarray:
        moved = trial - forces.spread(change, components) * forces.scale
        return forces.lacking(conditions.projected(moved))

    change = root(lacking, np.zeros(len(forces.components)), method="lm").x
    rigid = forces.spread(change, components)
    return changed(at, shift=at.shift + rigid * forces.scale, rigid=at.rigid + rigid)


@dataclass(frozen=True, eq=False)
class PointMeasure:
    """Distance of a point from the solution: the largest error relative to the largest traction,
    and the norm of all.
    """

    trial: np.ndarray
    residual: float
    merit: float
    largest: float


def measured(conditions: Conditions, at: Point) -> PointMeasure:
    """Measure of a point by the natural map, whose trial tractions are kept."""
    trial = at.traction - at.shift
    image = conditions.projected(trial)
    error = at.traction - image
    lacking = conditions.forces.lacking(at.traction)
    square = dot(error, error)
    largest = float(np.sqrt(max(dot(at.traction, at.traction).max(), dot(image, image).max())))
    if not largest > 0:
        largest = 1.0
    residual = max(float(np.sqrt(square.max())), float(np.abs(lacking).max(initial=0.0))) / largest
    return PointMeasure(trial, residual, float(np.sqrt(square.sum() + lacking @ lacking)), largest)


def line_search(
    conditions: Conditions, at: Point, step: Step, now: PointMeasure
) -> tuple[Point, PointMeasure]:
    """The point after the first part of a step that lowers the merit enough, or the best of all;
    where none does, the point as it was.
    """
    best = at
    best_measure = now
    for part in STEP_PARTS:
        candidate = Point(
            traction=at.traction + part * step.traction,
            shift=at.shift + part * step.shift,  # E is linear, and no product needed
            rigid=at.rigid + part * step.rigid,
            noise=at.noise,
        )
        measure = measured(conditions, candidate)
        if measure.merit <= best_measure.merit:
            best = candidate
            best_measure = measure
        if measure.merit < (1 - 0.1 * part) * now.merit:
            break
    return best, best_measure
