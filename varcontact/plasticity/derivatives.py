"""Bounds on what interpolation of a half-space's stress over a box misses, by the kinks of bilinear
tractions.

Second derivatives along x and y are stresses by the kinks of the tractions, lines of load of the
length of an element either side of a node; along z, ``e_zz = -(d^2/dx^2 + d^2/dy^2) W``, W being a
stress, too (`half_space.depth_matrix`). A line at the distance d has, with ``|K| <= C/r^2`` for a
point, at most ``C min(pi/d, side/d^2)``; its derivatives, with ``|K'| <= C'/r^3``, at most ``C'
min(2/d^2, side/d^3)``.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from varcontact.plasticity.half_space import (
    FOURTH,
    HalfSpace,
    depth_matrix,
    point_derivatives,
    stress_matrix,
)
from varcontact.scene.grid import Grid
from varcontact.system.process import lazy_property

DIRECTIONS = 240
"""Intervals of the polar angle and of the azimuth in a quarter of the hemisphere of directions;
kernels are evaluated at their ends, and bounds for those in between are about 1 % larger."""
SECOND = (0.0378, 0.1125)
"""Error bound of quadratic interpolation on the length 1, second derivatives being at most 1: with
the third place in the middle, and its increase per distance of that place from there. From the
largest integral of Peano's kernel; tested, as the next ones."""
TOUCHED = (0.1645, 0.245)
"""Error bound of quadratic interpolation on the length 1, and its increase, as of `SECOND`, for
second derivatives of at most 1/s, s being the distance from one end."""
ASIDE_MAX = 0.2
"""Largest distance of the third place from the middle for which the bounds `SECOND` and `TOUCHED`
hold."""
TOUCHING = 1e-9
"""Distance of a line, divided by its length, that counts as zero."""
STEP = 1e-5
"""Step of the differences that give the derivatives of kernels."""
PAIRS = 50_000
"""Pairs of boxes and nodes computed at once."""
SINGLE = np.float32
"""Sums over pairs are in single precision, in half the time."""
ROUNDED = 1 + 1e-3
"""Factor on these sums that covers rounding in single precision."""


@dataclass(frozen=True, eq=False)
class KernelBounds:
    """Bounds on the coordinates (3 tractions, 5) of point loads of 1 at the distance 1.

    Attributes
    ----------
    stress, down : ndarray
        Of the stress, and of W.
    along_x, along_y, down_slope : ndarray
        Of the derivatives of the stress along x and y, and of W along z.
    """

    stress: np.ndarray
    down: np.ndarray
    along_x: np.ndarray
    along_y: np.ndarray
    down_slope: np.ndarray


@lru_cache(maxsize=16)
def kernel_bounds(nu: float) -> KernelBounds:
    """The bounds for a Poisson's ratio; in the other quarters sizes are the same."""
    angle = np.linspace(0, np.pi / 2, DIRECTIONS + 1)
    polar_angle = angle[:, None]
    azimuth = angle[None, :]
    place = np.array(
        [
            (np.sin(polar_angle) * np.cos(azimuth)).ravel(),
            (np.sin(polar_angle) * np.sin(azimuth)).ravel(),
            (np.cos(polar_angle) + 0 * azimuth).ravel(),
        ]
    )
    own = stress_matrix(nu)
    depth = depth_matrix(nu)
    stress = _kernel(own)
    down = _kernel(depth)
    return KernelBounds(
        stress=_largest(stress(place), own, 2),
        down=_largest(down(place), depth, 2),
        along_x=_largest(_slope(stress, place, 0), own, 3),
        along_y=_largest(_slope(stress, place, 1), own, 3),
        down_slope=_largest(_slope(down, place, 2), depth, 3),
    )


def _kernel(matrix: np.ndarray) -> Callable[[np.ndarray], np.ndarray]:
    def at(place: np.ndarray) -> np.ndarray:
        values = point_derivatives(*place)
        values[-len(FOURTH) :] *= place[2]
        return np.einsum("tcd,dn->tcn", matrix, values, optimize=True)

    return at


def _slope(kernel: Callable[[np.ndarray], np.ndarray], place: np.ndarray, axis: int) -> np.ndarray:
    moved = np.zeros((3, 1))
    moved[axis] = STEP
    return (kernel(place + moved) - kernel(place - moved)) / (2 * STEP)


def _largest(values: np.ndarray, matrix: np.ndarray, degree: int) -> np.ndarray:
    """Bounds on kernels, homogeneous of a degree -2, or -3 if they are slopes of such, from their
    values (3, 5, n) at directions.

    Where a kernel is largest it has no slope along the sphere, so that a direction at the distance
    s has less by ``s^2/2`` times its second derivative, at most: that in space, and degree times
    the value itself by the curvature of the sphere.
    """
    squared = 2 * (np.pi / 2 / DIRECTIONS / 2) ** 2
    third = np.abs(matrix[..., : -len(FOURTH)]).sum(axis=-1)
    fourth = np.abs(matrix[..., -len(FOURTH) :]).sum(axis=-1)
    # the product rule of z and a derivative
    second = third * derivative_bound(degree + 3)
    second += fourth * (derivative_bound(degree + 4) + degree * derivative_bound(degree + 3))
    return (np.abs(values).max(axis=-1) + squared / 2 * second) / (1 - squared / 2 * degree)


def derivative_bound(order: int) -> float:
    """Bound on derivatives of this order of Omega, in any directions, at the distance 1 above the
    surface.

    Omega is a double integral along z of 1/rho, whose derivatives are at most ``n!/rho^(n + 1)``.
    """
    once = math.gamma(order / 2) / math.gamma((order + 1) / 2)
    twice = math.gamma((order - 1) / 2) / math.gamma(order / 2)
    return math.factorial(order) * math.pi / 4 * once * twice


@dataclass(frozen=True, eq=False)
class Remainders:
    """Bounds on the coordinates of the stress in boxes with the corners `low` and `high` (n, 3)."""

    field: HalfSpace

    def quadratic(self, low: np.ndarray, middle: np.ndarray, high: np.ndarray) -> np.ndarray:
        """Error bounds (n, 3 axes, 5) of quadratic interpolation along each axis, through the ends
        and a place between them.
        """
        return self.in_blocks(low, high, (low, middle, high))

    def in_blocks(
        self, low: np.ndarray, high: np.ndarray, box: tuple[np.ndarray, np.ndarray, np.ndarray]
    ) -> np.ndarray:
        """Error bounds (n, 3 axes, 5) of quadratic interpolation in any box with the sides of `box`
        (low, middle, high) within larger boxes, from `low` to `high`.
        """
        bounds = kernel_bounds(self.field.nu)
        slopes = (bounds.along_x, bounds.along_y)
        found = np.empty((len(low), 3, 5))
        for chosen in self._chunks(len(low)):
            first = low[chosen]
            last = high[chosen]
            sides = tuple(each[chosen] for each in box)
            down = _Steps.along(sides, 2)
            found[chosen, 2] = 0.0
            for axis, lines in enumerate(self._kinks):
                pairs = lines.pairs(first, last)
                inside = lines.inside(first, last, axis)
                steps = _Steps.along(sides, axis)
                missed = lines.missed(pairs, steps, bounds.stress, slopes[axis], inside)
                found[chosen, axis] = missed
                found[chosen, 2] += lines.missed(pairs, down, bounds.down, bounds.down_slope)
        return ROUNDED * found

    def stress(self, low: np.ndarray, high: np.ndarray) -> np.ndarray:
        """Bounds (n, 5) on the stress itself, by the distances from all elements."""
        field = self.field
        dx, dy = field.grid.sides
        nodes = _Lines.of(np.abs(field.load) * field.grid.area, field.grid, (dx, dy))
        found = np.empty((len(low), 3))
        for chosen in self._chunks(len(low)):
            distance, _ = nodes.distances(low[chosen], high[chosen])
            with np.errstate(divide="ignore"):
                found[chosen] = (1 / distance**2) @ nodes.size
        return found @ kernel_bounds(field.nu).stress

    @lazy_property
    def _kinks(self) -> tuple[_Lines, _Lines]:
        """Changes of the slopes of the tractions along x, and along y."""
        grid = self.field.grid
        dx, dy = grid.sides
        load = np.pad(self.field.load, ((0, 0), (1, 1), (1, 1)))
        along_x = np.abs(np.diff(load, 2, axis=2))[:, 1:-1] / dx
        along_y = np.abs(np.diff(load, 2, axis=1))[:, :, 1:-1] / dy
        return _Lines.of(along_x, grid, (0.0, dy)), _Lines.of(along_y, grid, (dx, 0.0))

    def _chunks(self, count: int) -> list[slice]:
        size = max(1, PAIRS // self.field.load[0].size)
        return [slice(first, first + size) for first in range(0, count, size)]


@dataclass(frozen=True, eq=False)
class _Pairs:
    """Boxes and lines (boxes, n): bounds on second and third derivatives for kernels of 1, and
    where a node is the nearest of its line.
    """

    second: np.ndarray
    third: np.ndarray
    nearest: np.ndarray


@dataclass(frozen=True, eq=False)
class _Lines:
    """Loads at nodes that reach by `half` along x and y to either side.

    Attributes
    ----------
    x, y : ndarray, shape (n,)
    size : ndarray, shape (n, 3)
        By traction.
    added : ndarray, shape (n, 3)
        What the largest of a node and both beside it is more.
    half : tuple of float
    """

    x: np.ndarray
    y: np.ndarray
    size: np.ndarray
    added: np.ndarray
    half: tuple[float, float]

    @classmethod
    def of(cls, size: np.ndarray, grid: Grid, half: tuple[float, float]) -> _Lines:
        """Lines from their sizes (3, ny, nx) at nodes, but those that are zero among zero ones."""
        axis = 2 - int(np.argmax(half))
        padding = [(0, 0)] * 3
        padding[axis] = (1, 1)
        wide = np.moveaxis(np.pad(size, padding), axis, 0)
        largest = np.maximum(np.maximum(wide[:-2], wide[1:-1]), wide[2:])
        largest = np.moveaxis(largest, 0, axis)
        rows, columns = np.nonzero(largest.any(axis=0))
        own = size[:, rows, columns].T
        added = largest[:, rows, columns].T - own
        return cls(grid.x[columns], grid.y[rows], own, added, half)

    @property
    def length(self) -> float:
        return max(self.half)

    @property
    def axis(self) -> int:
        """The axis along which they reach."""
        return int(np.argmax(self.half))

    def distances(self, low: np.ndarray, high: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Distances (boxes, n) from boxes, and where a node is the nearest of its line.

        Loads of nodes in one line overlap, and add up to at most the largest: the nearest stands
        for all beside it within an element, of which the outer halves alone remain.
        """
        along = _apart(low[:, 0, None], high[:, 0, None], self.x, self.half[0])
        across = _apart(low[:, 1, None], high[:, 1, None], self.y, self.half[1])
        axis = self.axis
        middle = (low[:, axis, None] + high[:, axis, None]) / 2
        from_middle = np.abs((self.x, self.y)[axis] - middle) / self.length
        side = (high - low)[:, axis, None] / self.length
        short = side < 0.6
        nearest = short & (from_middle <= 0.5)
        beside = short & (from_middle > 0.5) & (from_middle < 1.5)
        outer = np.where(beside, self.length * np.maximum(from_middle - side / 2, 0.0), 0.0)
        if axis == 0:
            along = np.maximum(along, outer)
        else:
            across = np.maximum(across, outer)
        return np.sqrt(along**2 + across**2 + low[:, 2, None] ** 2), nearest

    def pairs(self, low: np.ndarray, high: np.ndarray) -> _Pairs:
        """All pairs of boxes and lines."""
        distance, nearest = self.distances(low, high)
        near = 1 / np.maximum(distance, TOUCHING * self.length).astype(SINGLE)
        far = SINGLE(self.length) * near
        return _Pairs(
            near * np.minimum(SINGLE(np.pi), far),
            near**2 * np.minimum(SINGLE(2), far),
            nearest,
        )

    def missed(
        self,
        pairs: _Pairs,
        steps: _Steps,
        kernel: np.ndarray,
        slope: np.ndarray,
        inside: np.ndarray | None = None,
    ) -> np.ndarray:
        """Bounds (boxes, 5) on the interpolation error, by kernels (3, 5) and their slopes along
        the axis.

        Each line is bounded by its second or its third derivative. A line `inside` a box at the
        surface has no bound.
        """
        near = SINGLE(np.pi) * steps.touching
        if inside is not None:
            near = np.where(inside, SINGLE(np.inf), near)
        second = np.minimum(near, steps.second * pairs.second)
        third = steps.third * pairs.third
        smooth = third < SINGLE(kernel.max() / slope.max()) * second
        by_third = self._summed(third * smooth, pairs.nearest)
        second[smooth] = 0.0
        by_second = self._summed(second, pairs.nearest)
        return np.asarray(by_third @ slope + by_second @ kernel)

    def _summed(self, bound: np.ndarray, nearest: np.ndarray) -> np.ndarray:
        """Sums (boxes, 3) of bounds (boxes, n) times sizes, the nearest with those beside them."""
        size, added = self._in_single
        return np.asarray(bound @ size + (bound * nearest) @ added)

    @lazy_property
    def _in_single(self) -> tuple[np.ndarray, np.ndarray]:
        return self.size.astype(SINGLE), self.added.astype(SINGLE)

    def inside(self, low: np.ndarray, high: np.ndarray, axis: int) -> np.ndarray:
        """True (boxes, n) where a line is between the ends along an axis."""
        place = (self.x, self.y)[axis]
        slack = 1e-6 * self.length
        return (low[:, axis, None] < place - slack) & (place + slack < high[:, axis, None])


def _apart(low: np.ndarray, high: np.ndarray, place: np.ndarray, half: float) -> np.ndarray:
    return np.maximum(np.maximum(low - place, place - high) - half, 0.0)


@dataclass(frozen=True, eq=False)
class _Steps:
    """Largest errors of quadratic interpolation along one axis of boxes.

    Attributes
    ----------
    second : ndarray, shape (n, 1)
        Of functions whose second derivative is at most 1.
    third : ndarray, shape (n, 1)
        Of those whose third derivative is at most 1.
    touching : ndarray, shape (n, 1)
        Of those whose second derivative is at most 1/s, with the distance s from one end.
    """

    second: np.ndarray
    third: np.ndarray
    touching: np.ndarray

    @classmethod
    def along(cls, box: tuple[np.ndarray, ...], axis: int) -> _Steps:
        low, middle, high = (each[:, axis, None] for each in box)
        side = high - low
        share = (middle - low) / side
        aside = np.abs(share - 0.5)
        near = aside <= ASIDE_MAX
        second = np.where(near, SECOND[0] + SECOND[1] * aside, 1 / 4)
        # by linear interpolation 1/e of the length, as of s ln s, and by the third place
        own = np.maximum(-share * np.log(share), -(1 - share) * np.log(1 - share))
        far = 1 / math.e + own / (4 * share * (1 - share))
        touching = np.where(near, TOUCHED[0] + TOUCHED[1] * aside, far)
        each = (second * side**2, cubic_remainder(low, middle, high), touching * side)
        return cls(*(values.astype(SINGLE) for values in each))


def cubic_remainder(low: np.ndarray, middle: np.ndarray, high: np.ndarray) -> np.ndarray:
    """Largest ``|(s - low) (s - middle) (s - high)|/6`` between the ends."""
    side = high - low
    share = (middle - low) / side
    root = np.sqrt(1 - share + share**2)
    extremes = np.array([(1 + share - root) / 3, (1 + share + root) / 3])
    cubic = np.abs(extremes * (extremes - share) * (extremes - 1)).max(axis=0)
    return np.asarray(cubic * side**3 / 6)
