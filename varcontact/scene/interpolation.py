"""Samples of a distance between their points."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from scipy.interpolate import Akima1DInterpolator, RectBivariateSpline

STEEP = 0.05
"""Difference of the two interpolations in the middle of a cell, by the range of the samples around, at a cliff."""
SWING = 12
"""Cells from a cliff within which a spline's swing has died out."""


@dataclass(frozen=True, eq=False)
class Interpolation:
    """Samples h on (y, x): a bicubic spline, and Akima's interpolation beside cliffs, where splines swing."""

    x: np.ndarray  # ascending [length]
    y: np.ndarray  # ascending [length]
    h: np.ndarray  # (y.size, x.size) [length]

    def at(self, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        """Values at the points of a grid."""
        if not self._cliffs.any():
            return np.asarray(self._spline(y, x))
        from scipy.ndimage import maximum_filter

        x, y = np.clip(x, self.x[0], self.x[-1]), np.clip(y, self.y[0], self.y[-1])
        column = np.clip(np.searchsorted(self.x, x) - 1, 0, self.x.size - 2)
        row = np.clip(np.searchsorted(self.y, y) - 1, 0, self.y.size - 2)
        beside = maximum_filter(self._cliffs, 2 * SWING + 1)[np.ix_(row, column)]
        return np.where(beside, self._calm(x, y), self._spline(y, x))

    @cached_property
    def _spline(self) -> RectBivariateSpline:
        from scipy.interpolate import RectBivariateSpline

        return RectBivariateSpline(self.y, self.x, self.h, s=0, kx=min(3, self.y.size - 1), ky=min(3, self.x.size - 1))

    def _calm(self, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        from scipy.interpolate import Akima1DInterpolator

        return np.asarray(Akima1DInterpolator(self.x, self._along_y(y), axis=1)(x))

    @cached_property
    def _along_y(self) -> Akima1DInterpolator:
        from scipy.interpolate import Akima1DInterpolator

        return Akima1DInterpolator(self.y, self.h)

    @cached_property
    def _cliffs(self) -> np.ndarray:
        """The cells in whose middle the two interpolations differ."""
        from scipy.ndimage import maximum_filter, minimum_filter

        x, y = (self.x[1:] + self.x[:-1]) / 2, (self.y[1:] + self.y[:-1]) / 2
        around = (maximum_filter(self.h, 4) - minimum_filter(self.h, 4))[1:, 1:]
        return np.asarray(np.abs(self._spline(y, x) - self._calm(x, y)) > STEEP * around)
