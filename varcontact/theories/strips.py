"""Contacts cut into strips along the rolling direction, through which the material marches.

Strips are those of an ellipse on the unit disk: lengths are in units of a along x, and of b across it.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from varcontact.checks import choice, whole
from varcontact.theories.simplified import PEAK

CHUNK_POINTS = 5000
"""Strips times triples marched at once: the arrays of a chunk (40 kB each) then stay in a core's cache."""
MOST = 100_000
"""Intervals along a strip, and strips, at most."""
LARGEST_STEP = 1e100
"""In units of the bound; beyond, directions are kept and sizes cut, as squares must not overflow."""


@dataclass(frozen=True, eq=False)
class Strips:
    """A division of the ellipse, and factors that make the sums over its points exact.

    Attributes
    ----------
    across : ndarray, shape (n,)
        The strips' places y/b.
    width : ndarray, shape (n,)
        By which a sum over strips is an integral over y/b.
    along : ndarray, shape (points,)
        Places in each strip by its half-length, from the leading edge down.
    bounds : ndarray, shape (points,)
        The traction bound there, by its peak in the strip.
    step : float
        Distance of points by the strip's half-length.
    first : float
        Distance of the first point from the leading edge, in steps.
    bound : str
        "parabolic" or "elliptic".
    by_bound, by_creepage, by_spin : float
        Factors on the bound, on vx and vy, and on the spin.
    """

    across: np.ndarray
    width: np.ndarray
    along: np.ndarray
    bounds: np.ndarray
    step: float
    first: float
    bound: str
    by_bound: float = 1.0
    by_creepage: float = 1.0
    by_spin: float = 1.0

    @property
    def edge(self) -> np.ndarray:
        """Half-lengths a(y)/a, shape (n,)."""
        return np.sqrt((1 - self.across) * (1 + self.across))

    @property
    def peak(self) -> np.ndarray:
        """The bound's peak in the strips by that in the middle, shape (n,)."""
        return self.edge if self.bound == "elliptic" else self.edge**2


def printed(m: int, n: int, bound: str) -> Strips:
    """Kalker's division: equal strips, points at the ends of intervals, the last one (where the bound is 0) left out.

    Parameters
    ----------
    m, n : int
        Intervals along a strip (2 or more), and strips; `MOST` of each at most.
    bound : {"parabolic", "elliptic"}

    Raises
    ------
    SceneError
        If m or n is no whole number in range, or there is no such bound.
    """
    m, n = whole("m", m, least=2, most=MOST), whole("n", n, most=MOST)
    choice("bound", bound, PEAK)
    along = 1 - 2 * np.arange(1, m) / m
    inside = (1 - along) * (1 + along)
    across = 1 - (2 * np.arange(n) + 1) / n
    bounds = inside if bound == "parabolic" else np.sqrt(inside)
    return Strips(across, np.full(n, 2 / n), along, bounds, 2 / m, 1.0, bound)


def calibrated(m: int, n: int, bound: str) -> Strips:
    """A division whose sums have the slopes of the linear theory, and ``f Fz`` in full slip, to rounding.

    Strips are at Chebyshev's points, points in the middles of intervals, and the bound is its mean over an interval.
    What the sums still lack are factors.

    Parameters
    ----------
    m, n : int
        Intervals along a strip (2 or more), and strips; `MOST` of each at most.
    bound : {"parabolic", "elliptic"}

    Raises
    ------
    SceneError
        If m or n is no whole number in range, or there is no such bound.
    """
    m, n = whole("m", m, least=2, most=MOST), whole("n", n, most=MOST)
    choice("bound", bound, PEAK)
    angle = np.pi * np.arange(1, n + 1) / (n + 1)
    across, edge = np.cos(angle), np.sin(angle)
    width = np.pi / (n + 1) * edge
    along = 1 - (2 * np.arange(m) + 1) / m
    ends = np.linspace(1.0, -1.0, m + 1)
    whole_strip = ends - ends**3 / 3 if bound == "parabolic" else caps(ends)
    bounds = -np.diff(whole_strip) * m / 2
    square, cube = 4 / 3 / np.sum(width * edge**2), 3 * np.pi / 8 / np.sum(width * edge**3)
    by_bound = cube if bound == "parabolic" else square
    return Strips(across, width, along, bounds, 2 / m, 0.5, bound, by_bound, square, cube / (1 + 0.5 / m**2))


def caps(x: np.ndarray) -> np.ndarray:
    """Area under half a circle of radius 1 from its middle to x.

    Parameters
    ----------
    x : ndarray
        In [-1, 1].
    """
    return 0.5 * (x * np.sqrt((1 - x) * (1 + x)) + np.arcsin(x))


def march(strips: Strips, steps: np.ndarray) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    """Tractions of FASTSIM at one point of all strips after the other, from the leading edge.

    Parameters
    ----------
    strips : Strips
    steps : ndarray, shape (4, k)
        What a step in the middle strip adds: by vx, by vy, by spin at y = b, and by spin at x = a; in units of the
        bound's peak.

    Yields
    ------
    px, py : ndarray, shape (n, k)
        In units of the strip's own peak, so that the bound at a point is one number for all strips. The same two
        arrays every time: fresh ones would cost as much as the arithmetic.
    """
    edge, peak = strips.edge[:, None], strips.peak[:, None]
    vx, vy, spin_y, spin_x = steps
    step_x = -(edge / peak) * (vx - strips.across[:, None] * spin_y)
    by_place = -(edge / peak) * edge * spin_x
    middle = 1 - strips.first * strips.step / 2  # of the interval ahead of the first point
    plain_y = -(edge / peak) * vy
    px, py = strips.first * step_x, strips.first * (plain_y + middle * by_place)
    step_y = plain_y + (strips.along[0] - strips.step / 2) * by_place
    by_place *= strips.step
    square, scratch = np.empty_like(px), np.empty_like(px)
    for i, limit in enumerate(strips.bounds):
        if i > 0:
            px += step_x
            py += step_y
            step_y -= by_place
        np.multiply(px, px, out=square)
        np.multiply(py, py, out=scratch)
        square += scratch
        np.maximum(square, limit * limit, out=square)
        np.sqrt(square, out=square)
        np.divide(limit, square, out=square)  # 1 in the stick area
        px *= square
        py *= square
        yield px, py


def moderate_steps(steps: np.ndarray) -> np.ndarray:
    """Steps whose squares do not overflow: of the same direction, and beyond the bound by far.

    Parameters
    ----------
    steps : ndarray, shape (4, k)
        As of `march`.
    """
    return np.asarray(steps * np.minimum(1.0, LARGEST_STEP / np.maximum(np.abs(steps).max(axis=0), 1.0)))


def march_sums(strips: Strips, steps: np.ndarray) -> np.ndarray:
    """Integrals over the unit disk of px, py, y px and x py by FASTSIM, (4, k), in units of the bound's peak.

    Parameters
    ----------
    strips : Strips
    steps : ndarray, shape (4, k)
        As of `march`. The strips' factors are applied here.
    """
    steps = steps * np.array([strips.by_creepage, strips.by_creepage, strips.by_spin, strips.by_spin])[:, None]
    steps /= strips.by_bound
    steps = moderate_steps(steps)
    sums = np.empty((4, steps.shape[1]))
    size = max(CHUNK_POINTS // strips.width.size, 2)
    for start in range(0, steps.shape[1], size):
        chunk = slice(start, start + size)
        sums[:, chunk] = _chunk_sums(strips, steps[:, chunk])
    return sums * strips.by_bound


def _chunk_sums(strips: Strips, steps: np.ndarray) -> np.ndarray:
    """All strips of a few triples, through the contact at once."""
    if steps.shape[1] == 1:  # a sum over axis 0 of one column alone would be taken in another order
        return _chunk_sums(strips, np.repeat(steps, 2, axis=1))[:, :1]
    sum_x, sum_y, moment, scratch = np.zeros((4, strips.width.size, steps.shape[1]))
    for place, (px, py) in zip(strips.along, march(strips, steps), strict=True):
        sum_x += px
        sum_y += py
        np.multiply(py, place, out=scratch)
        moment += scratch
    edge = strips.edge[:, None]
    weight = strips.width[:, None] * strips.step * edge * strips.peak[:, None]
    sum_x *= weight
    sum_y *= weight
    moment *= weight * edge
    across = strips.across[:, None]
    return np.stack([sum_x.sum(axis=0), sum_y.sum(axis=0), (across * sum_x).sum(axis=0), moment.sum(axis=0)])
