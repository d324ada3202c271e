"""From the entries of a table book to its splines.

Entries are few, and near full slip forces turn quickly with the direction. So a simple law in closed form is taken from
them, which has the same full slip and turns alike; what is left is interpolated between the entries, and the law is
added again at the knots of the splines, which are many.
"""

from __future__ import annotations

import math

import numpy as np

from varcontact.reference.creepage_coefficients import CreepageCoefficients, no_slip_coefficients
from varcontact.reference.equal_splines import splines_at_knots
from varcontact.theories.table_nodes import HALFWAY, lagrange, linear_part, magnitudes, spin_scale

POLAR, ANGLES = 16, 32
"""Intervals of the splines: of the angle from vx up to pi/2, of the angle of (vy, spin) up to pi."""
PARITY = np.array([[-1.0, 1.0, 1.0], [1.0, -1.0, -1.0]])
"""Signs of Fx, Fy, Mz where vx, and where vy and spin, change theirs."""
REACH, NUGGET = 1.0, 1e-6
"""Of the correlation between directions, as a distance of unit vectors; and what is added to its diagonal."""
FULL = 1e9
"""A magnitude at which nothing is left of the way to full slip."""
TINY = 1e-300


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


def splines_through(nu: float, ratios: np.ndarray, directions: np.ndarray, left: np.ndarray) -> np.ndarray:
    """The splines of a book.

    Parameters
    ----------
    nu : float
    ratios : ndarray, shape (r,)
        a/b of the entries.
    directions : ndarray, shape (d, 3)
    left : ndarray, shape (r, m, d, 3)
        The entries less the local law.

    Returns
    -------
    ndarray, shape (h, i, j, k, 3)
        Coefficients, as in `TableBook.splines`.
    """
    polar, angle = (np.linspace(0.0, part, n + 1) for part, n in ((math.pi / 2, POLAR), (math.pi, ANGLES)))
    polar, angle = polar[:, None], angle[:-1]
    parts = np.cos(polar), np.sin(polar) * np.cos(angle), np.sin(polar) * np.sin(angle)
    knots = np.stack(np.broadcast_arrays(*parts), axis=-1)
    between = _between_directions(directions, knots.reshape(-1, 3))
    least, greatest = np.log(ratios[[0, -1]])
    places = np.linspace(least, greatest, max(3, 5 * (len(ratios) - 1) // 4) + 1)
    each = np.einsum("ikd,hr,rtdi->htki", between, lagrange(np.log(ratios), places), left, optimize=True)
    S = np.stack(
        [_at_knots(nu, ratio, knots.reshape(-1, 3), rest) for ratio, rest in zip(np.exp(places), each, strict=True)]
    )
    return splines_at_knots(_around(splines_at_knots(S.reshape(*S.shape[:2], *knots.shape), 1)))


def _at_knots(nu: float, ratio: float, knots: np.ndarray, left: np.ndarray) -> np.ndarray:
    """S of one ratio at the knots (t, knot, 3), from what is left there of the entries."""
    coefficients, rough, fine = no_slip_coefficients(float(ratio), nu), quadrature(ratio), quadrature(ratio, 80)
    t = magnitudes(len(left))
    finite = [
        local_law(HALFWAY * each / (1 - each) * knots, ratio, coefficients, *rough) + rest
        for each, rest in zip(t, left, strict=True)
    ]
    full = local_law(FULL * knots, ratio, coefficients, *fine)
    found = _rising(np.stack([*finite, full]), knots / spin_scale(coefficients, ratio))
    t = np.append(t, 1.0)[:, None, None]
    x, y, z = knots.T
    linear = np.stack(linear_part(x, y, z, ratio, coefficients), axis=-1)
    S = (found - (HALFWAY * t * (1 - t)) * linear) / t**2
    first = min(4, len(S))
    at_zero = lagrange(np.arange(1.0, first + 1), np.zeros(1))[0] @ S[:first].reshape(first, -1)
    return np.concatenate([at_zero.reshape(1, *S.shape[1:]), S])


def _rising(forces: np.ndarray, creepages: np.ndarray) -> np.ndarray:
    """Forces (t, knot, 3) changed by as little as it takes that more creepage never meets less resistance.

    With monotone influence of tractions on slip, ``-F.v`` by |v| rises along a ray of creepages v up to full slip.

    Parameters
    ----------
    forces : ndarray, shape (t, k, 3)
        At rising magnitudes, the last of them full slip.
    creepages : ndarray, shape (k, 3)
        Directions of the rays.
    """
    unit = creepages / np.linalg.norm(creepages, axis=1)[:, None]
    resistance = -(forces * unit).sum(axis=-1)
    capped = np.minimum(resistance, resistance[-1])
    above, below = np.maximum.accumulate(capped), np.minimum.accumulate(capped[::-1])[::-1]
    return np.asarray(forces - ((above + below) / 2 - resistance)[..., None] * unit)


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


def _around(values: np.ndarray) -> np.ndarray:
    """Coefficients of cubic B-splines in both angles, through values at the knots (..., polar, angle, 3).

    By symmetry the values go on to all directions.
    """
    _, polar, angle = (n - m for n, m in zip(values.shape[-4:-1], (0, 1, 0), strict=True))
    around = np.concatenate([values, PARITY[1] * values], axis=-2)
    half = np.concatenate([around, PARITY[0] * around[..., -2::-1, :, :]], axis=-3)  # to pi
    whole = np.concatenate([half, np.roll(half[..., -2:0:-1, :, :], angle, axis=-2)], axis=-3)
    for axis in (-3, -2):
        n = whole.shape[axis]
        filtered = 3 / (2 + np.cos(2 * math.pi * np.arange(n // 2 + 1) / n))
        filtered = filtered.reshape(-1, *[1] * (-axis - 1))
        whole = np.fft.irfft(np.fft.rfft(whole, axis=axis) * filtered, n, axis=axis)
    whole = whole.take(np.arange(-1, polar + 2), axis=-3, mode="wrap")
    return whole.take(np.arange(-1, angle + 2), axis=-2, mode="wrap")
