"""Kalker's creepage and spin coefficients of the linear theory (paper, section 2.1.1, Table 3)."""

from __future__ import annotations

import csv
from dataclasses import dataclass
from functools import cache
from importlib.resources import files
from typing import TYPE_CHECKING, Any

import numpy as np

from varcontact.checks import numbers_within, positives
from varcontact.errors import SceneError

if TYPE_CHECKING:
    from scipy.interpolate import CubicSpline

NAMES = ("C11", "C22", "C23", "C33")
LEAST_RATIO, GREATEST_RATIO = 0.1, 10.0
"""The range of a/b in Table 3."""


@dataclass(frozen=True)
class CreepageCoefficients:
    """Coefficients of ``Fx = -G ab C11 vx`` and so on, (118)-(119); ``C32 = -C23``. Pure numbers (or arrays).

    Attributes
    ----------
    C11, C22, C23, C33 : float or ndarray
        [-]
    """

    C11: float
    C22: float
    C23: float
    C33: float


def creepage_coefficients(a: float, b: float, nu: float) -> CreepageCoefficients:
    """Creepage and spin coefficients of an elliptic contact, interpolated in Table 3.

    Parameters
    ----------
    a, b : float or array_like
        Semi-axes along the rolling direction and across it [length]; a/b in [0.1, 10].
    nu : float or array_like
        Poisson's ratio (combined), in [0, 0.5].

    Returns
    -------
    CreepageCoefficients
        Floats; or arrays, where the arguments are arrays (which broadcast).

    Raises
    ------
    SceneError
        If a length is not positive and finite, or a/b or nu is out of the table's range.

    Notes
    -----
    Between the rows a cubic spline of log C over log(a/b). In nu a parabola through the table's two columns and
    a third at nu = 0.25: of 1/C for C11, C22 and C23 (1/C is nearly linear in nu), and of C itself for C33.
    The paper prints nu = 0 and 0.5 only; a straight line of 1/C between them misses C23 by 3 % at a/b = 0.1, and
    C33 by a third at a/b = 10. The third column is that of Kalker's full table (Three-dimensional elastic bodies
    in rolling contact, 1990). Two things confirm it: all its entries lie within 1.2 % (nearly all within 0.5 %) of
    this package's own no-slip solution; and the paper's Table 4 (nu = 0.25) follows from it to the printed digit,
    but for two misprints, .784 for .727 (GL2/a at a/b = 1) and .352 for .332 (GL3/a at a/b = 1/.3).

    Examples
    --------
    >>> coefficients = creepage_coefficients(6.0e-3, 4.0e-3, 0.28)
    >>> print(f"{coefficients.C11:.2f} {coefficients.C22:.2f} {coefficients.C23:.2f} {coefficients.C33:.3f}")
    4.72 4.35 2.06 0.927
    """
    ratio, nu_ = _ratio(a, b), numbers_within("nu", nu, 0.0, 0.5)
    first, middle, last = np.moveaxis(np.exp(_spline()(np.log(ratio))), -2, 0)  # each (..., 4)
    # Lagrange's parabola through nu = 0, 0.25, 0.5
    weights = [(4 * nu_ - 1) * (2 * nu_ - 1), 8 * nu_ * (1 - 2 * nu_), 2 * nu_ * (4 * nu_ - 1)]
    values = []
    for i, name in enumerate(NAMES):
        power = 1 if name == "C33" else -1
        columns = (first[..., i], middle[..., i], last[..., i])
        value = sum(weight * column**power for weight, column in zip(weights, columns, strict=True)) ** power
        values.append(float(value) if np.ndim(value) == 0 else value)
    return CreepageCoefficients(*values)


def in_table(a: float, b: float, nu: float) -> bool:
    """Whether the table reaches an ellipse and a Poisson's ratio.

    Parameters
    ----------
    a, b : float
        Semi-axes along the rolling direction and across it, in one unit.
    nu : float
        Combined Poisson's ratio (59) [-].
    """
    return LEAST_RATIO <= a / b <= GREATEST_RATIO and 0 <= nu <= 0.5


@cache
def _spline() -> CubicSpline:
    """Logarithms of the table's columns, (nu, coefficient), over log(a/b)."""
    from scipy.interpolate import CubicSpline

    with files("varcontact.reference").joinpath("table3.csv").open(encoding="utf-8") as lines:
        rows = [{key: float(value) for key, value in row.items()} for row in csv.DictReader(lines)]
    ratios = [row["a"] / row["b"] for row in rows]
    table = [[[row[f"{name}_nu{nu}"] for name in NAMES] for nu in ("0", "025", "05")] for row in rows]
    return CubicSpline(np.log(ratios), np.log(table))


def _ratio(a: Any, b: Any) -> np.ndarray:
    ratio = positives("a", a) / positives("b", b)
    outside = (ratio < LEAST_RATIO * (1 - 1e-12)) | (ratio > GREATEST_RATIO * (1 + 1e-12))  # 0.3 / 0.03 > 10
    if np.any(outside):
        raise SceneError("a/b", float(np.atleast_1d(ratio[outside])[0]), "in [0.1, 10], the range of Kalker's table")
    return np.asarray(ratio)
