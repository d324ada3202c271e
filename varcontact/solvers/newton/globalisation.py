"""What leads Newton's method to the solution: line search, balanced forces."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass, replace

import numpy as np

from varcontact.solvers.newton.gcr import Forces, Step, System
from varcontact.solvers.newton.kernel import Product

PARTS = (1.0, 0.6, 0.3, 0.15, 0.07, 0.03, 0.01)
"""Of a step, tried one after the other."""


@dataclass(frozen=True, eq=False)
class Conditions(ABC):
    """A contact problem on a box, dimensionless: what Newton's method has to know of it. Fields are
    (c, ny, nx).
    """

    kernel: Product
    known: np.ndarray
    forces: Forces

    @property
    def linear(self) -> bool:
        """Whether nothing bounds the tractions: Newton's equations are then the problem's."""
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
    """Tractions p and their shift E (c, ny, nx), rigid shifts (c, 1, 1), and the error of E by the
    largest p.
    """

    traction: np.ndarray
    shift: np.ndarray
    rigid: np.ndarray
    noise: float


def dot(one: np.ndarray, other: np.ndarray) -> np.ndarray:
    """Scalar products (ny, nx) of vectors (c, ny, nx)."""
    product: np.ndarray = one[0] * other[0]
    for first, second in zip(one[1:], other[1:], strict=True):
        product += first * second
    return product


def balanced(conditions: Conditions, at: Point) -> Point:
    """The point with the rigid shifts at which the tractions of its natural map have the prescribed
    forces.
    """
    from scipy.optimize import root

    forces, trial, components = conditions.forces, at.traction - at.shift, len(at.traction)

    def lacking(change: np.ndarray) -> np.ndarray:
        moved = trial - forces.spread(change, components) * forces.scale
        return forces.lacking(conditions.projected(moved))

    rigid = forces.spread(
        root(lacking, np.zeros(len(forces.components)), method="lm").x, components
    )
    return replace(at, shift=at.shift + rigid * forces.scale, rigid=at.rigid + rigid)


@dataclass(frozen=True, eq=False)
class Measure:
    """How far a point is from the solution: the largest error by the largest traction, and the size
    of all.
    """

    trial: np.ndarray
    residual: float
    merit: float
    largest: float


def measured(conditions: Conditions, at: Point) -> Measure:
    """By the natural map, whose trial tractions are kept."""
    trial = at.traction - at.shift
    image = conditions.projected(trial)
    error, lacking = at.traction - image, conditions.forces.lacking(at.traction)
    square = dot(error, error)
    largest = float(np.sqrt(max(dot(at.traction, at.traction).max(), dot(image, image).max())))
    largest = largest if largest > 0 else 1.0
    residual = max(float(np.sqrt(square.max())), float(np.abs(lacking).max(initial=0.0))) / largest
    return Measure(trial, residual, float(np.sqrt(square.sum() + lacking @ lacking)), largest)


def line_search(
    conditions: Conditions, at: Point, step: Step, now: Measure
) -> tuple[Point, Measure]:
    """After the first part of a step that lowers the merit enough, or the best of all; where none
    does, as it was.
    """
    best, least = at, now
    for part in PARTS:
        traction, rigid = at.traction + part * step.traction, at.rigid + part * step.rigid
        # E is linear, and no product needed
        there = Point(traction, at.shift + part * step.shift, rigid, at.noise)
        then = measured(conditions, there)
        if then.merit <= least.merit:
            best, least = there, then
        if then.merit < (1 - 0.1 * part) * now.merit:
            break
    return best, least
