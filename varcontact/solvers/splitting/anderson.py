"""Anderson's extrapolation of a fixed-point iteration.

Source: D. G. Anderson, J. ACM 12 (1965) 547-560.
"""

from __future__ import annotations

import numpy as np

MEMORY = 20
"""Differences that are combined."""
DAMPING = 1e-12
"""Damping of the normal equations, relative to their diagonal: rounding of their products."""


class Extrapolation:
    """The last differences of steps and of the points they lead to, with the products of the
    steps.
    """

    def __init__(self, size: int) -> None:
        self._ends = np.empty((MEMORY, size))
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
        end = point + step
        self._remember(end, step)
        count = min(self._count, MEMORY)
        if count == 0:
            return end.reshape(shape)
        steps = self._steps[:count]
        products = self._products[:count, :count]
        lengths = np.sqrt(np.diagonal(products)) + np.finfo(float).tiny
        normal = products / lengths / lengths[:, None] + DAMPING * count * np.eye(count)
        right = steps @ step / lengths
        weights = np.linalg.solve(normal, right) / lengths
        return np.asarray(end - weights @ self._ends[:count]).reshape(shape)

    def _remember(self, end: np.ndarray, step: np.ndarray) -> None:
        if self._last is not None:
            last_end, last_step = self._last
            place = self._count % MEMORY
            np.subtract(end, last_end, out=self._ends[place])
            np.subtract(step, last_step, out=self._steps[place])
            self._count += 1
            count = min(self._count, MEMORY)
            products = self._steps[:count] @ self._steps[place]
            self._products[place, :count] = products
            self._products[:count, place] = products
        self._last = end, step
