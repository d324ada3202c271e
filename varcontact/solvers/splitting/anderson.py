"""Anderson's extrapolation of a fixed-point iteration.

Source: D. G. Anderson, J. ACM 12 (1965) 547-560.
"""

from __future__ import annotations

import numpy as np

MEMORY = 15
"""Differences that are combined."""
DAMPING = 1e-12
"""Damping of the normal equations, relative to their diagonal: rounding of their products."""


class Extrapolation:
    """The last differences of points and of their steps, with the products of the steps."""

    def __init__(self, size: int) -> None:
        self._points = np.empty((MEMORY, size))
        self._steps = np.empty((MEMORY, size))
        self._products = np.zeros((MEMORY, MEMORY))
        self._count = 0
        self._last: tuple[np.ndarray, np.ndarray] | None = None

    def forget(self) -> None:
        self._count = 0
        self._last = None

    def next_point(self, point: np.ndarray, step: np.ndarray) -> np.ndarray:
        """The point of which the linear model of the iteration has the smallest step, with that
        step added.
        """
        shape = point.shape
        point = point.ravel()
        step = step.ravel()
        self._remember(point, step)
        count = min(self._count, MEMORY)
        moved = point + step
        if count == 0:
            return moved.reshape(shape)
        steps = self._steps[:count]
        products = self._products[:count, :count]
        lengths = np.sqrt(np.diagonal(products)) + np.finfo(float).tiny
        normal = products / lengths / lengths[:, None] + DAMPING * count * np.eye(count)
        right = steps @ step / lengths
        weights = np.linalg.solve(normal, right) / lengths
        moved -= weights @ self._points[:count]
        moved -= weights @ steps
        return moved.reshape(shape)

    def _remember(self, point: np.ndarray, step: np.ndarray) -> None:
        if self._last is not None:
            last_point, last_step = self._last
            place = self._count % MEMORY
            self._points[place] = point - last_point
            self._steps[place] = step - last_step
            self._count += 1
            count = min(self._count, MEMORY)
            products = self._steps[:count] @ self._steps[place]
            self._products[place, :count] = products
            self._products[:count, place] = products
        self._last = point, step
