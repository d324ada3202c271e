"""A contact problem as a variational inequality on a box of elements, in its own units.

Sought is u in K with ``(v - u)'(W + M u) >= 0`` for all v in K: pressures that
are not negative, or tractions within their bounds, with the prescribed sums.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from varcontact.elasticity.operators import RestrictedOperator
from varcontact.solvers.newton.driver import GridConditions, GridProblem
from varcontact.solvers.newton.globalisation import Conditions, Point
from varcontact.solvers.newton.kernel import unit
from varcontact.solvers.splitting.products import (
    Applied,
    Circulant,
    Influence,
    OfOperator,
    Product,
    Softened,
)
from varcontact.solvers.splitting.projection import projected
from varcontact.system.process import lazy_property

GAMMA_SLIDING = 0.4
GAMMA_SLIDING_ROLLING = 0.5
"""Step gamma where all elements slide, of symmetric problems and of rolling, in units of an
element's influence on itself (fitted on eleven scenes of 208 to 12.9k elements, where the rounds
are within 20 to 50 % of those with the best constant one)."""
GAMMA_STICKING = 1.0
"""Step gamma where all elements stick, of symmetric problems."""
ROLLING_COLUMNS = 32
"""Columns of the box at which gamma is one in rolling, too; it rises with their square root."""
GAMMA_ROLLING_MAX = 3.0
GAMMA_DIGITS = 1
ROLLING_SHARE = 0.2
"""Share of sticking elements above which rolling has the step gamma of full stick."""


@dataclass(frozen=True, eq=False)
class Iterate:
    """A point u with ``M u``, its projection and the multipliers of the prescribed sums (k,).

    `error` is e, the point less its projection; `residual` a bound on the natural map of the
    projection with gamma = 1, relative to the largest traction; `noise` the estimated error of
    ``M u``, relative to the same.
    """

    u: np.ndarray
    image: np.ndarray
    projection: np.ndarray
    multipliers: np.ndarray
    error: np.ndarray
    residual: float
    noise: float

    @lazy_property
    def size(self) -> float:
        """The norm of e."""
        return float(np.linalg.norm(self.error))


class FixedPoint(ABC):
    """The map ``P(u - gamma (W + M u))`` whose fixed point is the solution; P the projection."""

    gamma: float | np.ndarray
    groups: tuple[slice, ...] = (slice(None),)
    """Components whose residuals are relative to their own largest traction."""

    def __init__(self, conditions: Conditions, product: Applied) -> None:
        self.conditions = conditions
        self.product = product

    @abstractmethod
    def projected(
        self, trial: np.ndarray, multipliers: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """The projection of trial tractions, and the multipliers of the prescribed sums."""

    @abstractmethod
    def inverse(self, field: np.ndarray) -> np.ndarray:
        """Nearly ``(I + gamma M)^-1`` times a field."""

    @property
    def words(self) -> str:
        ny, nx = self.conditions.known.shape[1:]
        return f"{nx} x {ny} elements"

    @lazy_property
    def least_gamma(self) -> float:
        """The least gamma, at most one, once it has been chosen."""
        return float(np.min(self.gamma, initial=1.0))

    def start(self, at: Point) -> Iterate:
        """The iterate of a point, whose ``M u`` follows from its shift."""
        forces = self.conditions.forces
        image = at.shift - self.conditions.known - at.rigid * forces.scale
        multipliers = at.rigid.ravel()[list(forces.components)]
        return self.iterate(at.traction, image, multipliers, at.noise)

    def iterate(
        self, u: np.ndarray, image: np.ndarray, multipliers: np.ndarray, noise: float = 0.0
    ) -> Iterate:
        """The iterate of a point with ``M u``, from multipliers nearby."""
        trial = u - self.gamma * (image + self.conditions.known)
        projection, multipliers = self.projected(trial, multipliers)
        error = u - projection
        residual = self._residual(projection, error)
        return Iterate(u, image, projection, multipliers, error, residual, noise)

    def in_double_precision(self, at: Iterate) -> Iterate:
        return self.iterate(at.u, self.product.apply(at.u), at.multipliers)

    def _residual(self, projection: np.ndarray, error: np.ndarray) -> float:
        """The largest error, relative to the largest traction of its group, by gamma."""
        residuals = []
        for group in self.groups:
            largest = _largest(projection[group])
            if not largest > 0:
                largest = 1.0
            residuals.append(_largest(error[group]) / largest)
        return max(residuals) / self.least_gamma

    def point(self, at: Iterate) -> Point:
        """The projection as a point, with the shift of the iterate."""
        forces = self.conditions.forces
        rigid = forces.spread(at.multipliers, len(at.u))
        shift = at.image + self.conditions.known + rigid * forces.scale
        return Point(at.projection, shift, rigid, at.noise)


class Inequality(FixedPoint):
    """The inequality with its step gamma, and the circulants that belong to it."""

    conditions: GridConditions
    product: Product
    gamma: float

    def __init__(
        self, conditions: GridConditions, product: Product, influence: Influence, symmetric: bool
    ) -> None:
        super().__init__(conditions, product)
        self.influence = influence
        self.symmetric = symmetric
        self.gamma = GAMMA_STICKING

    @classmethod
    def of(cls, problem: GridProblem[Any], symmetric: bool) -> Inequality:
        """The inequality of a problem, on its own grid."""
        conditions = problem.conditions
        operator = problem.problem.operator
        whole = operator.grid_operator
        influence = Influence.on_box(whole, conditions.bound.shape)
        product: Product = influence
        softening = operator.softening
        if not (whole.toeplitz and type(operator) is RestrictedOperator):
            without = replace(operator, softening=None)
            product = OfOperator(without, problem.box, unit(whole))
        if softening is not None:
            scale = np.asarray(conditions.forces.scale, dtype=float)
            diagonal = problem.box.field(softening) / unit(whole) * scale**2
            product = Softened(product, scale, diagonal)
        return cls(conditions, product, influence, symmetric)

    @classmethod
    def coarse(cls, conditions: GridConditions, symmetric: bool) -> Inequality:
        """The inequality of a coarse grid."""
        influence = Influence.of_kernel(conditions.plain)
        return cls(conditions, influence, influence, symmetric)

    def choose_gamma(self, start: Point) -> None:
        """Take the step gamma that suits the share of sticking elements at a start; it stays."""
        trial = start.traction - start.shift
        sticks = self.conditions.sticks(trial, 1.0)
        share = np.count_nonzero(sticks) / np.count_nonzero(self.conditions.contact)
        self.gamma = GAMMA_SLIDING
        if self.conditions.slides:
            columns = self.conditions.bound.shape[1]
            self.gamma = tangential_gamma(share, columns, self.symmetric)

    def projected(
        self, trial: np.ndarray, multipliers: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        return projected(self.conditions, self.gamma, trial, multipliers)

    def inverse(self, field: np.ndarray) -> np.ndarray:
        return self._circulant.inverse(field, self.conditions.contact)

    def metric(self, field: np.ndarray) -> np.ndarray:
        """``H^-1`` times a field."""
        return self._circulant.metric(field, self.conditions.contact)

    @lazy_property
    def _circulant(self) -> Circulant:
        """The circulant of the step gamma, which has been chosen."""
        return self.influence.circulant(self.gamma)


def tangential_gamma(share: float, columns: int, symmetric: bool) -> float:
    """Step gamma for a share of sticking elements, in a box with a number of columns."""
    if symmetric:
        gamma = GAMMA_SLIDING + (GAMMA_STICKING - GAMMA_SLIDING) * share
    else:
        sticking = np.sqrt(columns / ROLLING_COLUMNS)
        sticking = float(np.clip(sticking, GAMMA_SLIDING_ROLLING, GAMMA_ROLLING_MAX))
        part = min(share / ROLLING_SHARE, 1.0)
        gamma = GAMMA_SLIDING_ROLLING + (sticking - GAMMA_SLIDING_ROLLING) * part
    # passes with nearly the same share have the same circulant
    return round(gamma, GAMMA_DIGITS)


def _largest(field: np.ndarray) -> float:
    """The largest length of the vectors of a field (c, ny, nx)."""
    return float(np.sqrt(np.einsum("i...,i...->...", field, field).max()))
