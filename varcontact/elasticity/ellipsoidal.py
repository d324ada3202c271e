"""Displacement gradients under tractions over an ellipse: those like Hertz's
pressure, and those over its root.

Semi-axes are a and b; b may be infinite: a line contact. Gradients are
derivatives along x of displacement differences, ``[..., i, j]`` of the
displacement i by the traction j; outside the ellipse they are those of the same
polynomial.
"""

from __future__ import annotations

import math

import numpy as np

from varcontact.reference.hertz import elliptic_integrals

STEP, REACH = 0.15, 40.0
"""Of the trapezoidal rule in the logarithm of the tangent of an angle, and how far beyond that of b/a it goes.

The integrands are analytic as far as i pi/2 and fall exponentially: both errors are far below rounding.
"""


def ellipsoidal_gradients(x: np.ndarray, y: np.ndarray, a: float, b: float, *, nu: float, G: float = 1.0) -> np.ndarray:
    """Gradients (2, 2, ...) by tractions ``sqrt(1 - (x/a)^2 - (y/b)^2)``, in points within the ellipse.

    In polar coordinates about the point, the double integral (217) is one over chords through it. Along a chord in the
    direction ``(c, s)`` the traction integrates to ``pi/2 (F + H^2/A)/sqrt(A)`` with ``A = (c/a)^2 + (s/b)^2``,
    ``H = x c/a^2 + y s/b^2`` and ``F = 1 - (x/a)^2 - (y/b)^2``, whose derivative is linear in x and y:
    ``du/dx = 1/(G a^2 b^2) integral_0^pi f(c, s) A^(-3/2) (-x s^2 + y s c)``, with f = 1 - nu s^2 (xx), 1 - nu c^2 (yy)
    and nu s c (xy). The integrals are B, C and D of `elliptic_integrals`.
    """
    x, y = np.broadcast_arrays(np.asarray(x, dtype=float), np.asarray(y, dtype=float))
    xx, yy, xy = _integrals(a, b, nu)
    return np.array([[-x * xx, y * xy], [y * xy, -x * yy]]) / G


def rooted_gradients(a: float, b: float, *, nu: float, G: float = 1.0) -> np.ndarray:
    """Gradients (3, 2, 2) by 1, x and y over ``sqrt(1 - (x/a)^2 - (y/b)^2)``, constant within the ellipse.

    As for `ellipsoidal_gradients`: along a chord the tractions integrate to ``pi/sqrt(A)`` times 1, ``x - c H/A`` and
    ``y - s H/A``. The derivatives of these along x are 0, ``s^2/(b^2 A)`` and ``-s c/(a^2 A)``.
    """
    xx, yy, xy = _integrals(a, b, nu)
    found = np.zeros((3, 2, 2))
    found[1], found[2] = np.diag([xx, yy]) * a**2, np.array([[0.0, -xy], [-xy, 0.0]]) * b**2
    return found / G


def sloped_gradients(x: np.ndarray, y: np.ndarray, a: float, b: float, *, nu: float, G: float = 1.0) -> np.ndarray:
    """Gradients (2, 2, 2, ...) by x and y times ``sqrt(1 - (x/a)^2 - (y/b)^2)``.

    As for `ellipsoidal_gradients`. With the shares ``p = (c/a)^2/A`` and ``q = (s/b)^2/A``, half the length of a
    chord through the middle ``h = A^(-1/2) = sqrt(a^2 p + b^2 q)`` and ``m = x/a sqrt(q) - y/b sqrt(p)``, the
    derivatives are ``1/(2 G)`` times the integrals of ``f q h (1 - 3 m^2)`` and of ``-f (b/a) sqrt(p q) h (1 - 3 m^2)``
    over half a turn. The variable of the quadrature is ``t = log sqrt(q/p)``, and the angle's step
    ``a b sqrt(p q)/h^2 dt``.
    """
    x, y = np.broadcast_arrays(np.asarray(x, dtype=float), np.asarray(y, dtype=float))
    reach = REACH + abs(math.log(a / b))
    t = np.arange(-reach, reach, STEP)
    p, q = (1 / (1 + np.exp(np.clip(sign * 2 * t, None, 700.0))) for sign in (1, -1))
    p, q, turn = np.tile(p, 2), np.tile(q, 2), np.repeat([1.0, -1.0], t.size)  # both signs of the direction along x
    h = np.hypot(a * np.sqrt(p), b * np.sqrt(q))
    c, s = turn * a * np.sqrt(p) / h, b * np.sqrt(q) / h
    f = np.array([[1 - nu * s**2, nu * s * c], [nu * s * c, 1 - nu * c**2]])
    share = STEP * a * b * np.sqrt(p * q) / h
    weights = np.array([q, -(b / a) * turn * np.sqrt(p * q)])[:, None, None] * f * share
    squares = np.array([q, -2 * turn * np.sqrt(p * q), p])  # of x/a and y/b in m^2
    constant, curved = weights.sum(axis=-1), np.einsum("kijn,mn->kijm", weights, squares)
    X, Y = x / a, y / b
    bent = np.tensordot(curved, np.array([X * X, X * Y, Y * Y]), axes=1)
    return np.asarray(constant.reshape(2, 2, 2, *(1,) * x.ndim) - 3 * bent) / (2 * G)


def _integrals(a: float, b: float, nu: float) -> tuple[float, float, float]:
    """The integrals of s^2 f (xx and yy), and of s c f (xy), with ``A^(-3/2)/(a b)^2``, over half a turn."""
    integrals = elliptic_integrals(min(a, b) / max(a, b))
    along, across = 2 * integrals.D * b / a**2, 2 * integrals.C * b / a**2
    if a < b:
        along, across = 2 * integrals.B / a, 2 * integrals.C * a / b**2
    return along - nu * (along - across), along - nu * across, nu * across
