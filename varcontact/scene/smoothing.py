"""Samples without their short waves: what is smooth, parabolas included, stays as it is."""

from __future__ import annotations

import math

import numpy as np

from varcontact.system.threads import one_blas_thread

LONGEST = 400
"""Longest wavelength in samples: beyond, rounding is felt."""


@one_blas_thread()
def smoothed(values: np.ndarray, points: np.ndarray, wavelength: float) -> np.ndarray:
    """Samples along the last axis without the waves shorter than a wavelength."""
    from scipy.linalg import solveh_banded

    count = points.size
    if count < 4:
        return values
    unit = float(np.mean(np.diff(points)))  # dimensionless: sixth powers of lengths leave floating point
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
            part = weight * differences[k] * differences[k + lag]
            banded[3 - lag, k + lag : count - 3 + k + lag] += part
    flat = values.reshape(-1, count).T
    parabolas = np.vander((x - x[0]) / (x[-1] - x[0]), 3)  # which stay, and would only be rounded
    smooth = parabolas @ np.linalg.lstsq(parabolas, flat, rcond=None)[0]
    found = smooth + solveh_banded(banded, share[:, None] * (flat - smooth), check_finite=False)
    return np.asarray(found.T.reshape(values.shape))


def smoothed_field(values: np.ndarray, x: np.ndarray, y: np.ndarray, wavelength: float) -> np.ndarray:
    """The same along both axes."""
    return smoothed(smoothed(values, x, wavelength).T, y, wavelength).T


def how_to_smooth(wavelength: str) -> str:
    """Advice on noise, in the words of a scene or case file and in those of `SampledDistance` and of profiles."""
    return f"smooth the samples: smoothing = {wavelength} in the file, or .smoothed({wavelength})"
