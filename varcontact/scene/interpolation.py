"""Interpolation between samples of a distance."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from varcontact.system.process import lazy_property, one_blas_thread

if TYPE_CHECKING:
    from scipy.interpolate import RectBivariateSpline

STEEP = 0.05
"""Difference of the two interpolations in the middle of a cell, divided by the range of the samples
around it, at which the cell counts as a cliff."""
SWING = 12
"""Cells from a cliff over which the oscillation of a spline dies out."""


@dataclass(frozen=True, eq=False)
class Interpolation:
    """Samples h on (y, x): a bicubic spline, and Akima's interpolation near cliffs, where splines
    oscillate.
    """

    x: np.ndarray  # ascending [length]
    y: np.ndarray  # ascending [length]
    h: np.ndarray  # (y.size, x.size) [length]

    @classmethod
    def of(cls, x: np.ndarray, y: np.ndarray | None, h: np.ndarray) -> Interpolation:
        """Interpolation of samples; without y of one row, which stands four times."""
        if y is None:
            return cls(x, np.arange(-1.5, 2.0), np.tile(h, (4, 1)))
        return cls(x, y, h)

    def at(self, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        """Values at the points of a grid, whose lines are in any order, and may be there twice."""
        x, to_x = np.unique(x, return_inverse=True)
        y, to_y = np.unique(y, return_inverse=True)
        values = self._spline(y, x)
        if self._cliffs.any():
            from scipy.ndimage import maximum_filter

            x = np.clip(x, self.x[0], self.x[-1])
            y = np.clip(y, self.y[0], self.y[-1])
            column = np.clip(np.searchsorted(self.x, x) - 1, 0, self.x.size - 2)
            row = np.clip(np.searchsorted(self.y, y) - 1, 0, self.y.size - 2)
            beside = maximum_filter(self._cliffs, 2 * SWING + 1)[np.ix_(row, column)]
            values = np.where(beside, self._akima(x, y), values)
        return np.asarray(values[np.ix_(to_y, to_x)])

    @lazy_property
    def _spline(self) -> RectBivariateSpline:
        from scipy.interpolate import RectBivariateSpline

        return RectBivariateSpline(
            self.y, self.x, self.h, s=0, kx=min(3, self.y.size - 1), ky=min(3, self.x.size - 1)
        )

    def _akima(self, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        from scipy.interpolate import Akima1DInterpolator

        rows = Akima1DInterpolator(self.y, self.h)(y)
        return np.asarray(Akima1DInterpolator(self.x, rows, axis=1)(x))

    @lazy_property
    def _cliffs(self) -> np.ndarray:
        """The cells in whose middle the two interpolations differ."""
        from scipy.ndimage import maximum_filter, minimum_filter

        x = (self.x[1:] + self.x[:-1]) / 2
        y = (self.y[1:] + self.y[:-1]) / 2
        around = (maximum_filter(self.h, 4) - minimum_filter(self.h, 4))[1:, 1:]
        return np.asarray(np.abs(self._spline(y, x) - self._akima(x, y)) > STEEP * around)


LONGEST = 400
"""Longest wavelength in samples, beyond which rounding errors become visible."""


@one_blas_thread()
def smoothed(values: np.ndarray, points: np.ndarray, wavelength: float) -> np.ndarray:
    """Samples along the last axis without the waves shorter than a wavelength."""
    from scipy.linalg import solveh_banded

    count = points.size
    if count < 4:
        return values
    # dimensionless: sixth powers of lengths leave floating point
    unit = float(np.mean(np.diff(points)))
    x = points / unit
    share = np.gradient(x)
    stiffness = (min(wavelength / unit, LONGEST) / (2 * math.pi)) ** 6
    differences = np.zeros((4, count - 3))
    for k in range(4):
        others = [x[k : count - 3 + k] - x[j : count - 3 + j] for j in range(4) if j != k]
        differences[k] = 6 / np.prod(others, axis=0)
    weight = stiffness * (x[3:] - x[:-3]) / 3
    banded = np.zeros((4, count))
    banded[3] = share
    for lag in range(4):
        for k in range(4 - lag):
            banded[3 - lag, k + lag : count - 3 + k + lag] += (
                weight * differences[k] * differences[k + lag]
            )
    flat = values.reshape(-1, count).T
    parabolas = np.vander((x - x[0]) / (x[-1] - x[0]), 3)  # which stay, and would only be rounded
    smooth = parabolas @ np.linalg.lstsq(parabolas, flat, rcond=None)[0]
    found = smooth + solveh_banded(banded, share[:, None] * (flat - smooth), check_finite=False)
    return np.asarray(found.T.reshape(values.shape))


def smoothed_field(
    values: np.ndarray, x: np.ndarray, y: np.ndarray, wavelength: float
) -> np.ndarray:
    """Values (ny, nx) smoothed along both axes, as by `smoothed`."""
    return smoothed(smoothed(values, x, wavelength).T, y, wavelength).T


def how_to_smooth(wavelength: str) -> str:
    """Advice on noise, in the words of a scene or case file and in those of `SampledDistance` and
    of profiles.
    """
    return f"smooth the samples: smoothing = {wavelength} in the file, or .smoothed({wavelength})"


def continuation(places: np.ndarray, values: np.ndarray) -> Callable[[np.ndarray], np.ndarray]:
    """Interpolation without oscillations between ascending places, linear beyond them."""
    from scipy.interpolate import PchipInterpolator

    if places.size == 1:
        return lambda at: np.full(at.shape, values[0])
    between = PchipInterpolator(places, values)
    first, last = places[[0, -1]]
    slopes = between(places[[0, -1]], 1)

    def continued(at: np.ndarray) -> np.ndarray:
        within = np.clip(at, first, last)
        return np.asarray(between(within) + np.where(at < within, *slopes) * (at - within))

    return continued
