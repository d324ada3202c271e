"""A contact problem as a variational inequality on a box of elements, in its own units.

Sought is u in K with ``(v - u)'(W + M u) >= 0`` for all v in K: pressures that
are not negative, or tractions within their bounds, with the prescribed sums.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from varcontact.elasticity.operators import RestrictedOperator
from varcontact.interfaces.potential import magnitude
from varcontact.solvers.newton.driver import GridConditions, GridProblem
from varcontact.solvers.newton.globalisation import Point
from varcontact.solvers.newton.kernel import unit
from varcontact.solvers.splitting.products import (
    Circulant,
    Influence,
    OfOperator,
    Product,
    Softened,
)
from varcontact.system.process import lazy_property

GAMMA_SLIDING = 0.4
GAMMA_SLIDING_ROLLING = 0.5
"""Step gamma where all elements slide, of symmetric problems and of rolling, in units of an
element's influence on itself (fitted on eleven scenes of 208 to 12.9k elements, where the rounds
are within 20 to 50 % of those with the best constant one)."""
GAMMA_STICKING = 1.0
"""Step gamma where all elements stick, of symmetric problems."""
ROLLING_COLUMNS = 32
"""Columns of the box at which it is one in rolling, too; it rises with their square root."""
GAMMA_ROLLING_MAX = 3.0
GAMMA_DIGITS = 1
ROLLING_SHARE = 0.2
"""Share of sticking elements from which rolling has the step of a contact that sticks all over."""
SUM_STEPS_MAX = 100
"""Newton steps at most for the multipliers of prescribed sums."""
SUM_STEP_MIN = 1e-3
"""Least part of such a step."""
SUM_GAIN = 0.9
"""Part of the slope of the dual function that may be left after a step."""
SUM_TOL = 1e-12
"""Excess, relative to the size of all tractions, that counts as rounding where no step lowers
it."""


@dataclass(frozen=True, eq=False)
class Iterate:
    """A point u with ``M u``, its projection and the multipliers of the prescribed sums (k,).

    `error` is e, the point less its projection; `noise` the estimated error of ``M u``, relative to
    the largest traction.
    """

    u: np.ndarray
    image: np.ndarray
    projection: np.ndarray
    multipliers: np.ndarray
    noise: float

    @lazy_property
    def error(self) -> np.ndarray:
        return np.asarray(self.u - self.projection)

    @lazy_property
    def size(self) -> float:
        """The norm of e."""
        return float(np.linalg.norm(self.error))


class Inequality:
    """The inequality with its step gamma, and the circulants that belong to it."""

    def __init__(
        self, conditions: GridConditions, product: Product, influence: Influence, symmetric: bool
    ) -> None:
        self.conditions = conditions
        self.product = product
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
        self.gamma = GAMMA_STICKING
        trial = start.traction - start.shift
        sticks = self.conditions.sticks(trial, 1.0)
        share = np.count_nonzero(sticks) / np.count_nonzero(self.conditions.contact)
        if not self.conditions.slides:
            self.gamma = GAMMA_SLIDING
        elif self.symmetric:
            self.gamma = GAMMA_SLIDING + (GAMMA_STICKING - GAMMA_SLIDING) * share
        else:
            columns = self.conditions.bound.shape[1]
            sticking = np.sqrt(columns / ROLLING_COLUMNS)
            sticking = float(np.clip(sticking, GAMMA_SLIDING_ROLLING, GAMMA_ROLLING_MAX))
            part = min(share / ROLLING_SHARE, 1.0)
            self.gamma = GAMMA_SLIDING_ROLLING + (sticking - GAMMA_SLIDING_ROLLING) * part
        # passes with nearly the same share have the same circulant
        self.gamma = round(self.gamma, GAMMA_DIGITS)

    def inverse(self, field: np.ndarray) -> np.ndarray:
        """Nearly ``(I + gamma M)^-1`` times a field."""
        return self._circulant.inverse(field, self.conditions.contact)

    def metric(self, field: np.ndarray) -> np.ndarray:
        """``H^-1`` times a field."""
        return self._circulant.metric(field, self.conditions.contact)

    @lazy_property
    def _circulant(self) -> Circulant:
        """The circulant of the step gamma, which has been chosen."""
        return self.influence.circulant(self.gamma)

    @property
    def words(self) -> str:
        ny, nx = self.conditions.bound.shape
        return f"{nx} x {ny} elements"

    # ------------------------------------------------------------------------------------ iterates

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
        return Iterate(u, image, projection, multipliers, noise)

    def in_double_precision(self, at: Iterate) -> Iterate:
        return self.iterate(at.u, self.product.apply(at.u), at.multipliers)

    def residual(self, at: Iterate) -> float:
        """A bound on the natural map of the projection with gamma = 1, relative to the largest
        traction.
        """
        largest = _largest(at.projection)
        if not largest > 0:
            largest = 1.0
        return _largest(at.error) / largest / min(self.gamma, 1.0)

    def point(self, at: Iterate) -> Point:
        """The projection as a point, with the shift of the iterate."""
        forces = self.conditions.forces
        rigid = forces.spread(at.multipliers, len(at.u))
        shift = at.image + self.conditions.known + rigid * forces.scale
        return Point(at.projection, shift, rigid, at.noise)

    # ------------------------------------------------------------------------------- the projection

    def projected(
        self, trial: np.ndarray, multipliers: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """The projection on K of trial tractions, and the multipliers of the prescribed sums.

        The multipliers are rigid shifts. The sums fall as they rise: they are slopes of a convex
        function, whose minimum Newton's method finds, or where it is flat one multiplier after the
        other.
        """
        sums = PrescribedSums(self.conditions, self.gamma, trial)
        if not self.conditions.forces.components:
            return sums.clipped(trial), multipliers
        at = sums.at(multipliers)
        one_by_one = False
        for _ in range(SUM_STEPS_MAX):
            if sums.rounded(at):
                break
            newer = sums.newton(at)
            if newer is not None:
                at = newer
                one_by_one = False
                continue
            if one_by_one or sums.nearly(at):
                break  # rounding is reached
            at = sums.one_by_one(at)
            one_by_one = True
        return at.clipped, at.multipliers


def _largest(field: np.ndarray) -> float:
    """The largest length of the vectors of a field (c, ny, nx)."""
    return float(np.sqrt(np.einsum("i...,i...->...", field, field).max()))


@dataclass(frozen=True, eq=False)
class Balance:
    """Trial tractions moved by multipliers (k,), what the bounds leave of them, and the excess of
    their sums (k,).
    """

    multipliers: np.ndarray
    moved: np.ndarray
    clipped: np.ndarray
    excess: np.ndarray


@dataclass(frozen=True, eq=False)
class PrescribedSums:
    """The equations of prescribed sums, for the multipliers at some trial tractions."""

    conditions: GridConditions
    gamma: float
    trial: np.ndarray

    def clipped(self, trial: np.ndarray) -> np.ndarray:
        """The proximal map of the potential, without the sums."""
        return self.conditions.proximal(trial, 1 / self.gamma)

    def at(self, multipliers: np.ndarray) -> Balance:
        forces = self.conditions.forces
        rigid = forces.spread(multipliers, len(self.trial))
        moved = self.trial - self.gamma * rigid * forces.scale
        clipped = self.clipped(moved)
        return Balance(multipliers, moved, clipped, forces.of(clipped) - forces.sums)

    @lazy_property
    def _largest(self) -> float:
        return float(np.abs(self.trial).max())

    @lazy_property
    def _count(self) -> int:
        return int(np.count_nonzero(self.conditions.contact))

    def _size(self, at: Balance) -> float:
        """The sum of tractions that are all as large as the largest."""
        scale = float(np.max(self.conditions.forces.scale))
        return float(np.abs(at.clipped).max()) * scale * self._count

    def rounded(self, at: Balance) -> bool:
        """True where the excess is that of rounding: of the sum, and of the trial tractions."""
        size = self._size(at) + 4 * np.sqrt(self._count) * self._largest
        return float(np.abs(at.excess).max()) <= np.finfo(float).eps * size

    def nearly(self, at: Balance) -> bool:
        """True where the excess may be that of rounding."""
        return float(np.abs(at.excess).max()) <= SUM_TOL * self._size(at)

    def newton(self, at: Balance) -> Balance | None:
        """The balance after a Newton step, halved until the dual function falls; None where no
        part of it does.
        """
        slopes = self._slopes(at) * self.gamma
        if len(slopes) > 1:
            step = np.linalg.lstsq(slopes, at.excess, rcond=1e-13)[0]
        elif slopes[0, 0] > 0:
            step = at.excess / slopes[0]
        else:
            return None
        slope = abs(float(at.excess @ step))
        part = 1.0
        while part > SUM_STEP_MIN and slope > 0:
            newer = self.at(at.multipliers + part * step)
            if abs(float(newer.excess @ step)) <= SUM_GAIN * slope:
                return newer
            part /= 2
        return None

    def _slopes(self, at: Balance) -> np.ndarray:
        """Minus the derivatives of the sums by the rigid shifts (k, k), divided by gamma."""
        forces = self.conditions.forces
        size = magnitude(at.moved)
        sticks = self.conditions.sticks(at.moved, 1 / self.gamma)
        inverse = 1 / np.where(size > 0, size, 1.0)
        held = np.where(size > 0, magnitude(at.clipped) * inverse, sticks)
        weighted = held * np.asarray(forces.scale) ** 2
        # where it slides nothing is left along the traction
        sliding = np.where(sticks, 0.0, weighted) * inverse**2
        slopes = np.zeros((len(forces.components), len(forces.components)))
        for row, i in enumerate(forces.components):
            for column, j in enumerate(forces.components):
                along = float(np.vdot(sliding * at.moved[i], at.moved[j]))
                slopes[row, column] = (weighted.sum() if i == j else 0.0) - along
        return slopes

    def one_by_one(self, at: Balance) -> Balance:
        """The balance after one multiplier and then the next, each where its own sum is right."""
        from scipy.optimize import brentq

        multipliers = at.multipliers.copy()
        width = max(self._largest / self.gamma, 1e-12)
        for i in range(len(multipliers)):

            def excess(value: float, i: int = i) -> float:
                moved = multipliers.copy()
                moved[i] = value
                return float(self.at(moved).excess[i])

            reach = width
            while np.isfinite(reach) and not excess(-reach) >= 0 >= excess(reach):
                reach *= 4
            if np.isfinite(reach):
                tiny = np.finfo(float).tiny
                multipliers[i] = brentq(excess, -reach, reach, xtol=tiny, rtol=1e-15)
        return self.at(multipliers)
