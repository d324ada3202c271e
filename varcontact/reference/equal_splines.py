"""Cubic splines over equal intervals, as sums of B-splines; for one place as for many."""

from __future__ import annotations

from typing import Any

import numpy as np

FOUR = np.arange(4)
"""So many B-splines are not zero on an interval."""


def near_splines(place: Any, intervals: int) -> tuple[Any, tuple[Any, Any, Any, Any]]:
    """The B-splines that are not zero at a place: the number of the first of four, and their values."""
    if isinstance(place, float):
        first: Any = min(int(place), intervals - 1)
    else:
        first = np.minimum(place.astype(np.intp), intervals - 1)
    f = place - first
    g = 1 - f
    ff, gg = f * f / 6, g * g / 6
    return first, (g * gg, (3 * f - 6) * ff + 2 / 3, (3 * g - 6) * gg + 2 / 3, f * ff)


def splines_at_knots(values: np.ndarray, axis: int = 0) -> np.ndarray:
    """Coefficients of the B-splines whose sum has given values at the knots; the outermost inner knots are none."""
    values = np.moveaxis(values, axis, 0)
    n = len(values)
    matrix = np.zeros((n + 2, n + 2))
    for i in range(n):
        matrix[i + 1, i : i + 3] = 1 / 6, 4 / 6, 1 / 6
    matrix[0, :5] = matrix[-1, -5:] = 1, -4, 6, -4, 1
    found = np.tensordot(np.linalg.inv(matrix)[:, 1:-1], values, 1)
    return np.moveaxis(found, 0, axis)
