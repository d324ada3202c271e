"""The projection on tractions within their bounds, with prescribed sums."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from varcontact.interfaces.potential import magnitude
from varcontact.solvers.newton.driver import GridConditions
from varcontact.system.process import lazy_property

SUM_STEPS_MAX = 100
"""Newton steps at most for the multipliers of prescribed sums."""
SUM_STEP_MIN = 1e-3
"""Least part of such a step."""
SUM_GAIN = 0.9
"""Part of the slope of the dual function that may be left after a step."""
SUM_TOL = 1e-12
"""Excess, relative to the size of all tractions, that counts as rounding where no step lowers
it."""


def projected(
    conditions: GridConditions, gamma: float, trial: np.ndarray, multipliers: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """The projection of trial tractions, and the multipliers (k,) of the prescribed sums.

    The multipliers are rigid shifts. The sums fall as they rise: they are slopes of a convex
    function, whose minimum Newton's method finds, or where it is flat one multiplier after the
    other.
    """
    sums = PrescribedSums(conditions, gamma, trial)
    if not conditions.forces.components:
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
        """Largest sum that tractions as large as the largest one could have."""
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
            if self.nearly(at):
                break
            part /= 2
        return None

    def _slopes(self, at: Balance) -> np.ndarray:
        """Minus the derivatives of the sums by the rigid shifts (k, k), divided by gamma."""
        forces = self.conditions.forces
        size = magnitude(at.moved)
        sticks = self.conditions.sticks(at.moved, 1 / self.gamma)
        held = sticks.astype(float)
        np.divide(magnitude(at.clipped), size, out=held, where=size > 0)
        weighted = held * np.asarray(forces.scale) ** 2
        # where it slides nothing is left along the traction
        if len(at.moved) == 1:
            return np.array([[np.vdot(weighted, sticks)]])
        sliding = np.where(sticks, 0.0, weighted)
        np.divide(sliding, size * size, out=sliding, where=size > 0)
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
