"""The variables of a table book: reduced creepages, the linear theory in them, and the nodes of the entries."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from varcontact.reference.creepage_coefficients import CreepageCoefficients

HALFWAY = 1.5
"""The magnitude that is half of the way to full slip: Vermeulen and Johnson's line ends at 3, their full slip."""
KNEE, ROOM = 1.8, 0.35
"""A magnitude about which full slip begins, and what part of the way to full slip is kept for those about it."""
SPIN = 0.5
"""Spin counts by this part of the slip that it makes a distance sqrt(a^2 + b^2) away."""


def spin_scale(coefficients: CreepageCoefficients, ratio: Any) -> np.ndarray:
    """Scales of vx, vy and spin times sqrt(ab) in the reduced creepage, but for G ab / (f Fz).

    Parameters
    ----------
    coefficients : CreepageCoefficients
    ratio : float or ndarray, shape (n,)
        a/b.

    Returns
    -------
    ndarray, shape (3, ...)
    """
    return np.array(scales(coefficients, ratio))


def scales(coefficients: CreepageCoefficients, ratio: Any) -> tuple[Any, Any, Any]:
    """Those of `spin_scale`, each by itself.

    Parameters
    ----------
    coefficients : CreepageCoefficients
    ratio : float or ndarray
        a/b.
    """
    C = coefficients
    return C.C11, C.C22, SPIN * C.C11 * (ratio + 1 / ratio) ** 0.5


def linear_part(x: Any, y: Any, z: Any, ratio: Any, coefficients: CreepageCoefficients) -> tuple[Any, Any, Any]:
    """Normalised forces of the linear theory for reduced creepages.

    Parameters
    ----------
    x, y, z : float or ndarray
        Along vx, vy and the spin.
    ratio : float or ndarray
        a/b.
    coefficients : CreepageCoefficients

    Returns
    -------
    tuple of three floats or ndarrays
        Fx, Fy, Mz.
    """
    C, by_spin = coefficients, scales(coefficients, ratio)[2]
    return -x, -y - (C.C23 / by_spin) * z, (C.C23 / C.C22) * y - (C.C33 / by_spin) * z


def places(t: Any) -> Any:
    """Where a magnitude stands among the splines, from 0, no slip, to 1, full slip.

    It has more room than t for the magnitudes about `KNEE`, where full slip begins.

    Parameters
    ----------
    t : float or ndarray
        ``r/(r + 1.5)`` of a magnitude r.
    """
    rest = (1 - t) * (KNEE / HALFWAY)
    cube = t * t * t
    return t + ROOM * (cube / (cube + rest * rest * rest) - t)


def magnitudes(count: int) -> np.ndarray:
    """Points t of the magnitudes ``1.5 t/(1 - t)`` of the entries, without 0 and 1: equal steps of `places`.

    Parameters
    ----------
    count : int
    """
    low, high = np.zeros(count), np.ones(count)
    wanted = np.arange(1, count + 1) / (count + 1)
    for _ in range(60):
        middle = (low + high) / 2
        below = places(middle) < wanted
        low, high = np.where(below, middle, low), np.where(below, high, middle)
    return (low + high) / 2


def ratio_nodes(least: float, greatest: float, count: int) -> np.ndarray:
    """Chebyshev's points in log(a/b), both ends included.

    Parameters
    ----------
    least, greatest : float
    count : int
    """
    middle, half = math.log(least * greatest) / 2, math.log(greatest / least) / 2
    return np.asarray(np.exp(middle - half * np.cos(math.pi * np.arange(count) / (count - 1))))


def direction_nodes(degree: int) -> np.ndarray:
    """Directions that determine polynomials of the direction: circles of (vy, spin), half of each.

    Parameters
    ----------
    degree : int
        Odd.

    Returns
    -------
    ndarray, shape (d, 3)
        From pure vx to none of it.
    """
    circles = (degree + 3) // 2
    found = [np.array([[1.0, 0.0, 0.0]])]
    for k in range(1, circles + 1):
        count = min(4 + 2 * k, degree + 3)
        angle, radius = math.pi * np.arange(count) / count, math.sin(math.pi * k / (2 * circles))
        height = math.cos(math.pi * k / (2 * circles)) if k < circles else 0.0
        found.append(np.stack([np.full(count, height), radius * np.cos(angle), radius * np.sin(angle)], axis=1))
    return np.concatenate(found)


def lagrange(nodes: np.ndarray, at: np.ndarray) -> np.ndarray:
    """Weights of values at some nodes in the values of the polynomial through them.

    Parameters
    ----------
    nodes : ndarray, shape (r,)
    at : ndarray, shape (n,)

    Returns
    -------
    ndarray, shape (n, r)
    """
    same = np.eye(len(nodes), dtype=bool)
    parts = np.where(same, 1.0, at[:, None, None] - nodes) / np.where(same, 1.0, nodes[:, None] - nodes)
    return np.asarray(parts.prod(axis=-1))
