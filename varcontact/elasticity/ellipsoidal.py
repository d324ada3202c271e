"""Displacement gradients under tractions over an ellipse: one like Hertz's pressure, and those over its root."""

from __future__ import annotations

import math

import numpy as np

from varcontact.reference.hertz import elliptic_integrals


def ellipsoidal_gradients(x: np.ndarray, y: np.ndarray, a: float, b: float, *, nu: float, G: float = 1.0) -> np.ndarray:
    """Derivatives along x of displacement differences by tractions ``sqrt(1 - (x/a)^2 - (y/b)^2)``, within the ellipse.

    Parameters
    ----------
    x, y : array_like
        Points [length]; their shapes broadcast. Outside the ellipse the values are those of the same polynomial.
    a, b : float
        Semi-axes along x and y [length]; b may be infinite: a line contact.
    nu, G : float
        Combined constants (58), (59).

    Returns
    -------
    ndarray, shape (2, 2, ...)
        ``[i, j]``: of the displacement i by the traction j of size 1 in the middle [1/(force/area)].

    Notes
    -----
    In polar coordinates about the point, the double integral (217) is one over chords through it. Along a chord in the
    direction ``(c, s)`` the traction integrates to ``pi/2 (F + H^2/A)/sqrt(A)`` with ``A = (c/a)^2 + (s/b)^2``,
    ``H = x c/a^2 + y s/b^2`` and ``F = 1 - (x/a)^2 - (y/b)^2``, whose derivative is linear in x and y:
    ``du/dx = 1/(G a^2 b^2) integral_0^pi f(c, s) A^(-3/2) (-x s^2 + y s c)``, with f = 1 - nu s^2 (xx), 1 - nu c^2 (yy)
    and nu s c (xy). The integrals are B, C and D of `elliptic_integrals`.

    Examples
    --------
    A line contact, in which a Hertzian traction leaves a linear strain, ``-2 (1 - nu) x/(G a)``:

    >>> print(ellipsoidal_gradients(0.5, 0.0, 1.0, np.inf, nu=0.25)[0, 0])
    -0.75
    """
    x, y = np.broadcast_arrays(np.asarray(x, dtype=float), np.asarray(y, dtype=float))
    along, across = _integrals(a, b)
    xx, yy, xy = along - nu * (along - across), along - nu * across, nu * across
    return np.array([[-x * xx, y * xy], [y * xy, -x * yy]]) / G


def rooted_gradients(a: float, b: float, *, nu: float, G: float = 1.0) -> np.ndarray:
    """Derivatives along x of displacement differences by 1, x and y over ``sqrt(1 - (x/a)^2 - (y/b)^2)``.

    Such tractions leave displacements that are constant or linear within the ellipse, so the derivatives are constant.

    Parameters
    ----------
    a, b : float
        Semi-axes along x and y [length]; b may be infinite: a line contact.
    nu, G : float
        Combined constants (58), (59).

    Returns
    -------
    ndarray, shape (3, 2, 2)
        ``[k, i, j]``: of the displacement i by the traction j of size 1, x or y (k) over the root; within the ellipse.

    Notes
    -----
    As for `ellipsoidal_gradients`: along a chord the tractions integrate to ``pi/sqrt(A)`` times 1, ``x - c H/A`` and
    ``y - s H/A``. The derivatives of these along x are 0, ``s^2/(b^2 A)`` and ``-s c/(a^2 A)``.

    Examples
    --------
    A line contact, in which x over the root leaves a uniform strain, ``2 (1 - nu)/G``:

    >>> print(rooted_gradients(1.0, np.inf, nu=0.25)[1, 0, 0])
    1.5
    """
    along, across = _integrals(a, b)
    xx, yy, xy = along - nu * (along - across), along - nu * across, nu * across
    linear_in_y = 0.0 if math.isinf(b) else -xy * b**2
    found = np.zeros((3, 2, 2))
    found[1], found[2] = np.diag([xx, yy]) * a**2, [[0.0, linear_in_y], [linear_in_y, 0.0]]
    return found / G


def _integrals(a: float, b: float) -> tuple[float, float]:
    """The integrals of s^2 and of s^2 c^2, with ``A^(-3/2)/(a b)^2``, over half a turn."""
    if math.isinf(b):
        return 2 / a, 0.0
    integrals = elliptic_integrals(min(a, b) / max(a, b))
    if a < b:
        return 2 * integrals.B / a, 2 * integrals.C * a / b**2
    return 2 * integrals.D * b / a**2, 2 * integrals.C * b / a**2
