"""Roots of one function of one variable, or two of two, that have kinks and jumps.

On a lattice of points, cut into triangles, the search goes along those between
which the first function changes its sign, until the second one does, too. That
passes folds, and needs no derivatives: piecewise linear continuation, E. L.
Allgower, K. Georg, Numerical Continuation Methods (1990), chapter 12.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from itertools import combinations

import numpy as np

HALVINGS = 20
"""Bisections of a simplex around a root."""
HALVINGS_TO_ROOT = 4
"""Bisections between two trials of the root of the linear interpolant."""
HALVINGS_OF_SIDE = 8
"""Bisections of a triangle's side on which both functions change sign."""
OUTSIDE = -0.3
"""Barycentric coordinate below which a root of the linear interpolant is not taken as one of the
functions."""

Point = tuple[float, ...]
Nearest = tuple[int, np.ndarray, float]
"""Number (0 or 1) of the function that is not zero, the point, and its value there."""
OnCurve = tuple[np.ndarray, float]
"""Point at which the first function is zero, and the value of the second there."""
Functions = Callable[[Point], "np.ndarray | None"]


class Lattice:
    """Functions at points by their coordinates on a lattice around 0, None where there are no
    values.

    The first one falls along the first axis near the root that is sought, the second along the
    second. `nearest` to a root is a point where the first function, or the second with the first
    zero, is least: its number, and the value.
    """

    def __init__(self, functions: Functions, reach: int) -> None:
        self._functions = functions
        self._reach = reach
        self._values: dict[Point, np.ndarray | None] = {}
        self.nearest: Nearest | None = None

    def at(self, point: Point) -> np.ndarray | None:
        if point not in self._values:
            self._values[point] = self._functions(point)
        return self._values[point]

    def brackets(self, axes: int) -> Iterator[tuple[np.ndarray, bool]]:
        """Points that come ever nearer to a root; True with the last one: a root, or a jump across
        it.
        """
        if axes == 1:
            for segment in self._segments(axes):
                yield from self._within(segment)
            return
        for triangle, on_curve in self._triangles():
            yield on_curve, False
            yield from self._within(triangle)

    def _segments(self, axes: int) -> Iterator[list[Point]]:
        """Neighbours between which the first function changes its sign: along each axis, the way
        that it falls first.

        Along the second one it grows.
        """
        origin = (0.0,) * axes
        begin = self.at(origin)
        if begin is None:
            return
        for axis in range(axes):
            falling = (-1.0) ** axis
            if begin[0] <= 0:
                falling = -falling
            for direction in (falling, -falling):
                step = [0.0] * axes
                step[axis] = direction
                segment = self._change(origin, tuple(step))
                if segment is not None:
                    yield segment

    def _change(self, point: Point, step: Point) -> list[Point] | None:
        """The first segment, of those that follow each other, in which the first function changes
        its sign.
        """
        value = self.at(point)
        for _ in range(self._reach):
            after = tuple(a + b for a, b in zip(point, step, strict=True))
            if value is None:
                return None
            self._note(0, np.array(point), float(value[0]))
            beyond = self.at(after)
            if beyond is None:
                return None
            if (value[0] > 0) != (beyond[0] > 0):
                return [point, after]
            point = after
            value = beyond
        return None

    def _triangles(self) -> Iterator[tuple[list[Point], np.ndarray]]:
        """Triangles in which both functions change their sign, along the curve on which the first
        is zero, and the point on the curve where the second is.
        """
        for segment in self._segments(2):
            positive, negative = sorted(segment, key=lambda point: -float(self._value(point)[0]))
            begin = self._on_curve(positive, negative)
            along = np.subtract(negative, positive)
            # the corners of both triangles at the segment
            low = np.minimum(positive, negative)
            across = np.abs(along[[1, 0]])
            corners = [low + np.ones(2), low - across]
            # where the second function is positive, its root is on the left as seen from the
            # positive end
            towards = corners[0] - positive
            left = along[0] * towards[1] - along[1] * towards[0] > 0
            if left != (begin[1] > 0):
                corners.reverse()
            for corner in corners:
                found = self._along(positive, negative, tuple(corner.tolist()), begin)
                if found is not None:
                    yield found

    def _along(
        self, positive: Point, negative: Point, corner: Point, begin: OnCurve
    ) -> tuple[list[Point], np.ndarray] | None:
        """The first triangle, of those that follow each other, in which the second function changes
        its sign.
        """
        last = begin
        for _ in range(self._reach):
            value = self.at(corner)
            if value is None:
                return None
            triangle = [positive, negative, corner]
            # the side through which the curve continues, and the corner left behind
            if value[0] > 0:
                left = positive
                positive = corner
            else:
                left = negative
                negative = corner
            point, second = self._on_curve(positive, negative)
            if second * begin[1] <= 0:
                part = last[1] / (last[1] - second)
                return triangle, (1 - part) * last[0] + part * point
            last = point, second
            # the next triangle is the mirror image at the middle of the side
            corner = tuple(a + b - c for a, b, c in zip(positive, negative, left, strict=True))
        return None

    def _on_curve(self, positive: Point, negative: Point) -> OnCurve:
        """The point of a side at which the first function is zero, and the second one there."""
        positive, negative = self._narrowed(positive, negative)
        first = self._value(positive)
        other = self._value(negative)
        part = first[0] / (first[0] - other[0])
        point = (1 - part) * np.array(positive) + part * np.array(negative)
        second = float((1 - part) * first[1] + part * other[1])
        self._note(1, point, second)
        return point, second

    def _narrowed(self, positive: Point, negative: Point) -> tuple[Point, Point]:
        """Part of a side in which the first function changes sign and the second does not: near a
        jump, where interpolation is unreliable, the second one's sign would be a guess.
        """
        for _ in range(HALVINGS_OF_SIDE):
            if self._value(positive)[1] * self._value(negative)[1] > 0:
                break
            middle = tuple(((np.array(positive) + negative) / 2).tolist())
            value = self.at(middle)
            if value is None:
                break
            if value[0] > 0:
                positive = middle
            else:
                negative = middle
        return positive, negative

    def _value(self, point: Point) -> np.ndarray:
        value = self.at(point)
        assert value is not None
        return value

    def _note(self, k: int, point: np.ndarray, value: float) -> None:
        if self.nearest is None or (self.nearest[0], -abs(self.nearest[2])) < (k, -abs(value)):
            self.nearest = k, point, value

    def _within(self, simplex: list[Point]) -> Iterator[tuple[np.ndarray, bool]]:
        """Roots of the linear functions on a simplex, which is cut in two at its longest side again
        and again.
        """
        for k in range(HALVINGS + 1):
            weights = self._weights(simplex)
            # across a jump it may be outside: then the middle
            if weights.min() < OUTSIDE:
                weights = np.full(len(simplex), 1 / len(simplex))
            if k % HALVINGS_TO_ROOT == 0:
                yield weights @ np.array(simplex), k == HALVINGS
            # the half in which the root is, or which is nearer to it
            sides = combinations(range(len(simplex)), 2)
            i, j = max(sides, key=lambda ends: _length(simplex, ends))
            middle = tuple(((np.array(simplex[i]) + simplex[j]) / 2).tolist())
            if self.at(middle) is None:
                yield np.mean(simplex, axis=0), True
                return
            halves = []
            for end in (i, j):
                half = list(simplex)
                half[end] = middle
                halves.append(half)
            simplex = max(halves, key=lambda half: float(self._weights(half).min()))

    def _weights(self, simplex: list[Point]) -> np.ndarray:
        """Weights of the corners in the root of the linear functions by their values: all positive
        where it is inside.
        """
        values = np.array([self._value(point)[: len(simplex) - 1] for point in simplex])
        equations = np.vstack([values.T, np.ones(len(simplex))])
        return np.linalg.lstsq(equations, np.eye(len(simplex))[-1], rcond=None)[0]


def _length(simplex: list[Point], ends: tuple[int, int]) -> float:
    return math.dist(simplex[ends[0]], simplex[ends[1]])
