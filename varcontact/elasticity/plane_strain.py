"""Influence numbers of line contact: displacement difference by uniform tractions on an infinite strip.

Plane strain (44) for pressure and longitudinal traction, anti-plane shear for lateral traction. Displacements count
from the points of the surface at the distance `depth` of a line load, ``-ln(|x|/depth)``.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np


def strip_influence_numbers(
    x: np.ndarray,
    dx: float,
    *,
    nu: float,
    K: float = 0.0,
    G: float = 1.0,
    depth: float = 1.0,
    components: Iterable[str] = ("xx", "yy", "zz"),
) -> dict[str, np.ndarray]:
    """Influence numbers B_ij of a strip of width dx.

    Parameters
    ----------
    x : array_like
        Field point minus the strip's centre line [length].
    dx : float
        Width of the strip [length].
    nu, K, G : float
        Combined constants (58)-(60).
    depth : float
        Distance at which displacements along the traction are zero [length].
    components : iterable of str
        Which of the nine: "xz" is the displacement difference along x by a unit pressure.

    Returns
    -------
    dict
        Component to array of the shape of x [length/(force/area)].

    Notes
    -----
    With ``L = -[[s ln(|s|/d) - s]]`` (the integral of ``-ln(|x - x'|/d)`` over the strip, s from ``x - dx/2`` to
    ``x + dx/2``) and ``J = [[|s|]]`` (the integral of ``sgn(x - x')``): ``pi G B`` is ``2 (1 - nu) L`` (xx and zz),
    ``2 L`` (yy), ``-pi K J`` (xz), ``pi K J`` (zx); all others are zero. They are the limits of the rectangle's as
    its length along y grows, but for constants.

    Examples
    --------
    >>> B = strip_influence_numbers(np.array([0.0, 3.0]), 1.0, nu=0.25, components=["zz"])["zz"]
    >>> print((B * np.pi / 1.5).round(6))
    [ 1.693147 -1.093944]
    """
    x = np.asarray(x, dtype=float)
    return combined(*strip_integrals(x, dx, depth), nu, K, G, components)


def strip_integrals(x: np.ndarray, dx: float, depth: float) -> tuple[np.ndarray, np.ndarray]:
    """L and J, without cancellation far away.

    With r = |x| and h = dx/2, L is ``-dx (ln(r/d) - 1) - h ln|1 - t^2| - r ln|(1 + t)/(1 - t)|``, t = h/r; the last
    three terms but ln(r/d) add up to ``dx (t^2/6 + t^4/20 + ...)`` where t is small.
    """
    from scipy.special import xlogy

    half, r = dx / 2, np.abs(x)
    near = r < 8 * dx
    logarithm = np.empty(r.shape)
    right, left = (r[near] + half) / depth, (r[near] - half) / depth
    logarithm[near] = dx - depth * (xlogy(right, right) - xlogy(left, np.abs(left)))
    t2 = (half / r[~near]) ** 2
    series = sum(t2**k / (2 * k * (2 * k + 1)) for k in range(1, 7))  # t < 1/16: the next term is below 1e-19
    logarithm[~near] = dx * (series - np.log(r[~near] / depth))
    return logarithm, np.clip(2 * x, -dx, dx)


def combined(
    logarithm: np.ndarray, sign: np.ndarray, nu: float, K: float, G: float, components: Iterable[str]
) -> dict[str, np.ndarray]:
    """Influence numbers from the integrals L and J, or from their means over the past."""
    plane, antiplane = 2 * (1 - nu), 2.0
    of_logarithm = {"xx": plane, "yy": antiplane, "zz": plane}
    of_sign = {"xz": -np.pi * K, "zx": np.pi * K}
    return {
        name: (of_logarithm.get(name, 0.0) * logarithm + of_sign.get(name, 0.0) * sign) / (np.pi * G)
        for name in components
    }
