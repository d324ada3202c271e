"""From the entries of a table book to its splines.

Entries are few, and near full slip forces turn quickly with the direction. So a simple law in closed form is taken from
them, which has the same full slip and turns alike; what is left is interpolated between the entries, and the law is
added again at the knots of the splines, which are many.
"""

from __future__ import annotations

import math

import numpy as np
from scipy.interpolate import make_interp_spline

from varcontact.reference.creepage_coefficients import CreepageCoefficients
from varcontact.reference.equal_splines import splines_at_knots
from varcontact.theories.table_book import HALFWAY, linear_part, magnitudes, spin_scale

KNOTS = 20, 16, 32
"""Intervals of the splines: of t, of the angle from vx up to pi/2, of the angle of (vy, spin) up to pi."""
PARITY = np.array([[-1.0, 1.0, 1.0], [1.0, -1.0, -1.0]])
"""Signs of Fx, Fy, Mz where vx, and where vy and spin, change theirs."""
REACH, NUGGET = 1.0, 1e-6
"""Of the correlation between directions, as a distance of unit vectors; and what is added to its diagonal."""
FULL = 1e9
"""A magnitude at which nothing is left of the way to full slip."""
TINY = 1e-300
FIRST = 1e-3
"""Where the splines begin in place of t = 0, which is the linear theory whatever they are."""


def local_law(
    reduced: np.ndarray, ratio: float, coefficients: CreepageCoefficients, points: np.ndarray, load: np.ndarray
) -> np.ndarray:
    """Normalised forces if traction follows rigid slip at each point, as in Vermeulen and Johnson's formula.

    With s = C11 |w| in the units of the reduced creepage, it has the parts ``1 - (1 - s/3)^3`` of the traction bound,
    and all of it from s = 3. Full slip is exact.

    Parameters
    ----------
    reduced : ndarray, shape (n, 3)
    ratio : float
        a/b.
    coefficients : CreepageCoefficients
    points : ndarray, shape (2, p)
        x and y by sqrt(ab).
    load : ndarray, shape (p,)
        Parts of f Fz that they carry.

    Returns
    -------
    ndarray, shape (n, 3)
    """
    x, y = points
    sums = np.stack([np.ones_like(x), x, y, x**2 + y**2], axis=1) * load[:, None]
    scale, found = spin_scale(coefficients, ratio), np.empty_like(reduced)
    at_once = max(1, 20_000 // len(load))
    for k in range(0, len(reduced), at_once):
        vx, vy, spin = (reduced[k : k + at_once] / scale).T
        wx, wy = vx[:, None] - spin[:, None] * y, vy[:, None] + spin[:, None] * x
        third = np.sqrt(wx * wx + wy * wy) * (scale[0] / 3)
        inside = np.minimum(third, 1.0)
        by_slip = ((inside - 3) * inside + 3) * inside / np.maximum(third, TINY)
        by_slip[third < TINY] = 3.0
        zeroth, by_x, by_y, second = (by_slip @ sums).T * (-scale[0] / 3)
        found[k : k + at_once, 0] = vx * zeroth - spin * by_y
        found[k : k + at_once, 1] = vy * zeroth + spin * by_x
        found[k : k + at_once, 2] = vy * by_x - vx * by_y + spin * second
    return found


def quadrature(ratio: float, count: int = 24) -> tuple[np.ndarray, np.ndarray]:
    """Points of an ellipse with ab = 1 and parts of Hertz's load: Gauss's rule outwards, the trapezoidal one around.

    Parameters
    ----------
    ratio : float
        a/b.
    count : int
        Points outwards; twice as many around.

    Returns
    -------
    points : ndarray, shape (2, p)
    load : ndarray, shape (p,)
    """
    height, weight = np.polynomial.legendre.leggauss(count)
    height, weight = (height + 1) / 2, weight / 2
    angle = math.pi / count * (np.arange(2 * count) + 0.5)
    radius = np.sqrt(1 - height**2)[:, None]
    x, y = math.sqrt(ratio) * radius * np.cos(angle), radius * np.sin(angle) / math.sqrt(ratio)
    load = np.broadcast_to((1.5 * height**2 * weight)[:, None] / count, x.shape)
    return np.stack([x.ravel(), y.ravel()]), load.ravel()


def splines_through(
    coefficients: list[CreepageCoefficients], ratios: np.ndarray, directions: np.ndarray, left: np.ndarray
) -> np.ndarray:
    """The splines of a book.

    Parameters
    ----------
    coefficients : list of CreepageCoefficients
        Of the ratios.
    ratios : ndarray, shape (r,)
    directions : ndarray, shape (d, 3)
    left : ndarray, shape (r, m, d, 3)
        The entries less the local law.

    Returns
    -------
    ndarray, shape (i, j, k, r, 3)
        Coefficients, as in `TableBook.splines`.
    """
    t = np.linspace(0.0, 1.0, KNOTS[0] + 1)
    t[0] = FIRST
    polar, angle = (
        math.pi / part * np.arange(n) / m for part, n, m in ((2, KNOTS[1] + 1, KNOTS[1]), (1, *KNOTS[2:] * 2))
    )
    knots = np.stack(
        np.broadcast_arrays(
            np.cos(polar)[:, None], np.sin(polar)[:, None] * np.cos(angle), np.outer(np.sin(polar), np.sin(angle))
        ),
        -1,
    ).reshape(-1, 3)
    between = _between_directions(directions, knots)
    values = [
        _at_knots(each, float(ratio), t, directions, knots, between, entries)
        for each, ratio, entries in zip(coefficients, ratios, left, strict=True)
    ]
    S = np.stack(values, axis=-2).reshape(len(t), len(polar), len(angle), len(ratios), 3)
    return _splines(S).astype(np.float32)


def _at_knots(
    coefficients: CreepageCoefficients,
    ratio: float,
    t: np.ndarray,
    directions: np.ndarray,
    knots: np.ndarray,
    between: np.ndarray,
    entries: np.ndarray,
) -> np.ndarray:
    """S of one ratio at the knots (t, knot, 3)."""
    rough, fine = quadrature(ratio), quadrature(ratio, 80)

    def law(reduced: np.ndarray, points: tuple[np.ndarray, np.ndarray] = rough) -> np.ndarray:
        return local_law(reduced, ratio, coefficients, *points)

    def linear(unit: np.ndarray) -> np.ndarray:
        return np.stack(linear_part(*unit.T, ratio, coefficients), axis=-1)

    nodes = magnitudes(len(entries))
    slope = HALFWAY * (linear(directions) - law(1e-9 * directions) / 1e-9)
    of_t = np.concatenate([slope[None], entries / nodes[:, None, None], np.zeros((1, *slope.shape))])
    ends = np.concatenate([[0.0], nodes, [1.0]])
    degree = 5 if len(ends) > 5 else 3  # two entries at least, so four values
    to_knots = make_interp_spline(ends, np.eye(len(ends)), degree)(t)
    rest = t[:, None, None] * np.einsum("ikd,tj,jdi->tki", between, to_knots, of_t, optimize=True)
    found = [law(HALFWAY * each / (1 - each) * knots) for each in t[:-1]]
    found.append(law(FULL * knots, fine))
    square, near = (t**2)[:, None, None], (HALFWAY * t * (1 - t))[:, None, None]
    return (rest + np.stack(found) - near * linear(knots)) / square


def _between_directions(nodes: np.ndarray, at: np.ndarray) -> np.ndarray:
    """Interpolation on the sphere (3, at, nodes), by Matern's correlation of order 5/2, with the symmetries of each."""
    return np.stack(
        [
            _correlation(at, nodes, i) @ np.linalg.inv(_correlation(nodes, nodes, i) + NUGGET * np.eye(len(nodes)))
            for i in range(3)
        ]
    )


def _correlation(one: np.ndarray, other: np.ndarray, component: int) -> np.ndarray:
    """Of directions, which has the symmetries of a component."""
    found = np.zeros((len(one), len(other)))
    for along, across in ((1, 1), (1, -1), (-1, 1), (-1, -1)):
        sign = (PARITY[0, component] if along < 0 else 1.0) * (PARITY[1, component] if across < 0 else 1.0)
        image = other * (along, across, across)
        s = math.sqrt(5) / REACH * np.linalg.norm(one[:, None] - image, axis=-1)
        found += sign * (1 + s + s**2 / 3) * np.exp(-s)
    return found


def _splines(values: np.ndarray) -> np.ndarray:
    """Coefficients of cubic B-splines through values at the knots (t, polar, angle, ...), which go on by symmetry."""
    _, polar, angle = (n - m for n, m in zip(values.shape[:3], (1, 1, 0), strict=True))
    around = np.concatenate([values, PARITY[1] * values], axis=2)
    half = np.concatenate([around, PARITY[0] * around[:, -2::-1]], axis=1)  # to pi
    whole = np.concatenate([half, np.roll(half[:, -2:0:-1], angle, axis=2)], axis=1)
    for axis in (1, 2):
        n = whole.shape[axis]
        filtered = 3 / (2 + np.cos(2 * math.pi * np.arange(n // 2 + 1) / n))
        shape = [1] * whole.ndim
        shape[axis] = -1
        whole = np.fft.irfft(np.fft.rfft(whole, axis=axis) * filtered.reshape(shape), n, axis=axis)
    whole = whole.take(np.arange(-1, polar + 2), axis=1, mode="wrap").take(
        np.arange(-1, angle + 2), axis=2, mode="wrap"
    )
    return splines_at_knots(whole)
