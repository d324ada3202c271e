"""Kalker's creepage and spin coefficients of the linear theory (paper, section 2.1.1, Table 3), for
any ellipse.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cache, lru_cache
from importlib.resources import files
from typing import Any

import numpy as np

from varcontact import checks
from varcontact.checks import broadcasting, poisson, positives


@dataclass(frozen=True)
class CreepageCoefficients:
    """Coefficients of ``Fx = -G ab C11 vx`` and so on, (118)-(119);
    ``C32 = -C23``. Pure numbers (or arrays).

    Attributes
    ----------
    C11, C22, C23, C33 : float or ndarray
        [-]
    """

    C11: Any
    C22: Any
    C23: Any
    C33: Any


@checks.named_options()
def no_slip_coefficients(a_over_b: Any, nu: Any) -> CreepageCoefficients:
    """Creepage and spin coefficients of an elliptic contact, for any axial
    ratio and Poisson's ratio.

    Parameters
    ----------
    a_over_b : float or array_like
        Semi-axis along the rolling direction by that across it [-].
    nu : float or array_like
        Combined Poisson's ratio (59), in (-1, 0.5].

    Returns
    -------
    CreepageCoefficients
        Floats; or arrays, where the arguments are arrays (which broadcast).

    Raises
    ------
    SceneError
        If a ratio is not positive and finite, or nu is out of its range (in an
        array the first of these is named by its index), or their shapes do not
        broadcast.

    Notes
    -----
    Interpolated in a table of what `no_slip_ellipse` computes: 121 ratios from 1e-3 to 1e3 by a
    cubic spline over log(a/b), 13 Poisson's ratios by Chebyshev's polynomials. ``python -m
    varcontact.reference.no_slip_table`` makes it. Compared with what it is made from, and that with
    twice as many polynomials, the error is below 2e-5 for a/b from 0.01 to 100, and below 1e-4 from
    1e-3 to 1e3 (of C23 where it passes through 0: of the terms it consists of).

    Beyond the table the coefficients follow their asymptotes, joined to its
    last entries. With ``L = ln(16 max(a/b, b/a)^2)``, wide contacts (a/b to 0)
    have ``C11 = pi^2/(4 (1 - nu))``, ``C22 = pi^2/4``,
    ``C33 = pi^2/(16 (1 - nu)) b/a``, and C23 by sqrt(a/b) grows like
    ``pi nu L/(6 (1 - nu))``. Slender ones have

        C11 = 2 pi (a/b)/(L - 3 + ln 4 - 2 nu)               C23 = 2 pi (a/b)^1.5/(3 D)
        C22 = 2 pi (a/b)/((1 - nu) (L - 3 + ln 4) + 2 nu)    C33 = pi/4 (1 - nu (L - 4)/D)^2

    where ``D = (1 - nu) L - 2 + 4 nu``. In wide contacts with nu < 0, C23 may
    be negative.

    Kalker's Table 3, of 1967, has three digits, of which the last is often off:
    the largest difference is 1.3 %, of C33 at a/b = 0.1. The reference manual
    of this package compares all its entries.

    Examples
    --------
    >>> coefficients = no_slip_coefficients(1.5, 0.28)
    >>> print(f"{coefficients.C11:.4f} {coefficients.C22:.4f}")
    4.7140 4.3555
    >>> print(f"{coefficients.C23:.4f} {coefficients.C33:.4f}")
    2.0577 0.9267
    """
    if (
        type(a_over_b) is float
        and type(nu) is float
        and 1e-100 <= a_over_b <= 1e100
        and -1 < nu <= 0.5
    ):
        return _single(a_over_b, nu)
    ratio = positives("a_over_b", a_over_b)
    nu = poisson(nu)
    if ratio.ndim == nu.ndim == 0:
        return _single(float(ratio), float(nu))
    broadcasting({"a_over_b": ratio, "nu": nu})
    return CreepageCoefficients(*_values(ratio, nu))


def creepage_coefficients(a: Any, b: Any, nu: Any) -> CreepageCoefficients:
    """Creepage and spin coefficients of an elliptic contact of given axes.

    Parameters
    ----------
    a, b : float or array_like
        Semi-axes along the rolling direction and across it [length].
    nu : float or array_like
        Combined Poisson's ratio (59), in (-1, 0.5].

    Returns
    -------
    CreepageCoefficients
        As of `no_slip_coefficients`, at a/b.

    Raises
    ------
    SceneError
        If a length is not positive and finite, or nu is out of its range.

    Examples
    --------
    >>> coefficients = creepage_coefficients(6.0e-3, 4.0e-3, 0.28)
    >>> print(f"{coefficients.C11:.4f} {coefficients.C22:.4f}")
    4.7140 4.3555
    >>> print(f"{coefficients.C23:.4f} {coefficients.C33:.4f}")
    2.0577 0.9267
    """
    return no_slip_coefficients(positives("a", a) / positives("b", b), nu)


@lru_cache(maxsize=1024)
def _single(ratio: float, nu: float) -> CreepageCoefficients:
    return CreepageCoefficients(*_values(np.array(ratio), np.array(nu)).tolist())


def _values(ratio: np.ndarray, nu: np.ndarray) -> np.ndarray:
    """The four coefficients, in front of the shape of both."""
    x = np.log(ratio)
    inside = np.minimum(np.maximum(x, -END), END)
    place = (inside + END) * (INTERVALS / (2 * END))
    first, weights = near_splines(place if x.ndim else float(place), INTERVALS)
    splines = _table() if nu.ndim else coefficient_splines(float(nu))
    near_coefficients = splines[np.asarray(first)[..., None] + FOUR]
    near = np.einsum("k...,...kc->...c", np.array(weights), near_coefficients)
    if nu.ndim:
        near = np.einsum("...ck,...k->...c", near.reshape(*x.shape, 4, _POWERS), _powers(nu))
    by_x, by_y, by_spin, turning = np.moveaxis(near, -1, 0)
    by_spin = by_spin + np.pi * nu / (3 * (1 - nu)) * (inside - np.minimum(x, inside))
    root = np.hypot(1.0, ratio)
    values = np.array(
        [root / by_x, root / by_y, np.sqrt(ratio) * root * by_spin, root / ratio * turning]
    )
    if np.any(x > END):
        values *= _slender(np.maximum(x, END), nu) / _slender(np.full_like(x, END), nu)
    return values


@lru_cache(maxsize=64)
def coefficient_splines(nu: float) -> np.ndarray:
    return np.asarray(_table().reshape(-1, 4, _POWERS) @ _powers(np.array([nu]))[0])


def _powers(nu: np.ndarray) -> np.ndarray:
    return np.polynomial.chebyshev.chebvander((nu + 0.25) / 0.75, _POWERS - 1)


END = math.log(1e3)
"""Range of the table: log(a/b) from -END to END."""
INTERVALS = 120
"""Equal intervals of the table."""
_POWERS = 13


@cache
def _table() -> np.ndarray:
    """Splines over log(a/b) of Chebyshev's coefficients in nu: (k, 4 times 13).

    With ``q = (1 + (a/b)^2)^(1/2)`` they have q/C11, q/C22, C23/((a/b)^(1/2) q) and C33 (a/b)/q. In
    wide contacts all but the third tend to constants, and the third to a straight line; in slender
    ones the first two do.
    """
    file = files("varcontact.reference").joinpath("creepage_coefficients.csv")
    text = file.read_text(encoding="utf-8")
    rows = np.loadtxt(text.splitlines(), delimiter=",", skiprows=1)
    rows = rows.reshape(INTERVALS + 1, _POWERS, 6)
    ratio = rows[:, :1, 0]
    nu = rows[0, :, 1]
    C11, C22, C23, C33 = np.moveaxis(rows[:, :, 2:], -1, 0)
    root = np.hypot(1.0, ratio)
    scaled = np.stack(
        [root / C11, root / C22, C23 / (np.sqrt(ratio) * root), C33 * ratio / root], axis=1
    )
    coefficients = scaled @ np.linalg.inv(_powers(nu)).T
    return splines_at_knots(coefficients.reshape(INTERVALS + 1, -1))


def _slender(x: Any, nu: np.ndarray) -> np.ndarray:
    """Asymptotes of slender contacts up to constant factors: the change with log(a/b) beyond the
    table.
    """
    L = math.log(16) + 2 * x
    less = L - 3 + math.log(4)
    D = (1 - nu) * L - 2 + 4 * nu
    return np.stack(
        [1 / (less - 2 * nu), 1 / ((1 - nu) * less + 2 * nu), 1 / D, (1 - nu * (L - 4) / D) ** 2]
    )


FOUR = np.arange(4)
"""Offsets of the B-splines that are not zero on an interval."""


def near_splines(place: Any, intervals: int) -> tuple[Any, tuple[Any, Any, Any, Any]]:
    """The B-splines that are not zero at a place: the number of the first of four, and their
    values.
    """
    if isinstance(place, float):
        first: Any = min(int(place), intervals - 1)
    else:
        first = np.minimum(place.astype(np.intp), intervals - 1)
    f = place - first
    g = 1 - f
    ff = f * f / 6
    gg = g * g / 6
    return first, (g * gg, (3 * f - 6) * ff + 2 / 3, (3 * g - 6) * gg + 2 / 3, f * ff)


def splines_at_knots(values: np.ndarray, axis: int = 0) -> np.ndarray:
    """Coefficients of the B-splines whose sum has given values at the knots, with the not-a-knot
    condition at both ends.
    """
    values = np.moveaxis(values, axis, 0)
    n = len(values)
    matrix = np.zeros((n + 2, n + 2))
    for i in range(n):
        matrix[i + 1, i : i + 3] = 1 / 6, 4 / 6, 1 / 6
    matrix[0, :5] = [1, -4, 6, -4, 1]
    matrix[-1, -5:] = [1, -4, 6, -4, 1]
    coefficients = np.tensordot(np.linalg.inv(matrix)[:, 1:-1], values, 1)
    return np.moveaxis(coefficients, 0, axis)
