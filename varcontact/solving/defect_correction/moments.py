"""Tractions on elements by their means and first moments; over an ellipse those whose displacement is known."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from varcontact.scene.grid import Grid
from varcontact.solving.defect_correction.rooted import LEAST, NODES, ROWS_AT_ONCE


@dataclass(frozen=True, eq=False)
class Spread:
    """A traction by its means over elements, and how it is spread within them.

    Attributes
    ----------
    mean : ndarray, shape (..., ny, nx)
    along, across : ndarray, shape (..., ny, nx)
        Means of the traction times the distance from the element's middle along x and y, by the element's side.
    """

    mean: np.ndarray
    along: np.ndarray
    across: np.ndarray

    @property
    def placed(self) -> np.ndarray:
        """Constant tractions on the elements that have the same force and moments.

        A moment is a pair of forces on the elements beside; at the grid's border on the element itself and the one
        inside.

        Examples
        --------
        >>> middle = np.array([[0.0, 1.0, 0.0]])
        >>> Spread(middle, 0.2 * middle, 0 * middle).placed
        array([[-0.1,  1. ,  0.1]])
        >>> ends = np.array([[1.0, 0.0, 2.0]])
        >>> Spread(ends, 0.1 * ends, 0 * ends).placed
        array([[ 0.9, -0.1,  2.2]])
        """
        return self.mean + _pairs(self.along) + np.swapaxes(_pairs(np.swapaxes(self.across, -1, -2)), -1, -2)


def _pairs(moments: np.ndarray) -> np.ndarray:
    """Pairs of forces along the last axis that have the moments; none where that has a single element."""
    found = np.zeros_like(moments)
    if moments.shape[-1] > 1:
        found[..., 1:] += moments[..., :-1] / 2
        found[..., :-1] -= moments[..., 1:] / 2
        found[..., :2] += moments[..., :1] * [-1.0, 0.5]
        found[..., -2:] += moments[..., -1:] * [-0.5, 1.0]
    return found


@dataclass(frozen=True, eq=False)
class Weight:
    """The weight ``sqrt((e - x)/(e + x))`` over an ellipse, e its half length at y, on the elements of a grid.

    Attributes
    ----------
    mean : ndarray, shape (ny, nx)
    x, y : ndarray, shape (ny, nx)
        Where the weight in each element is centred; the element's middle where there is none.
    along, across : ndarray, shape (ny, nx)
        Mean of the weight times the square of the distance from there along x and y, by the element's side.
    """

    mean: np.ndarray
    x: np.ndarray
    y: np.ndarray
    along: np.ndarray
    across: np.ndarray


def over_ellipse(grid: Grid, a: float, b: float) -> tuple[Weight, Spread, Spread]:
    """The weight, the tractions 1, x and y over ``r = sqrt(1 - (x/a)^2 - (y/b)^2)``, and those three times r.

    Parameters
    ----------
    grid : Grid
        Explicit.
    a, b : float
        Semi-axes along x and y, in the unit of the grid; b is infinite in line contact.

    Returns
    -------
    Weight
    Spread, Spread
        Of shape (3, ny, nx).
    """
    found = [_over_rows(grid, a, b, slice(first, first + ROWS_AT_ONCE)) for first in range(0, grid.rows, ROWS_AT_ONCE)]
    (mean, x, y, along, across), *spreads = (np.concatenate(each, axis=-2) for each in zip(*found, strict=True))
    touched = mean > LEAST * mean.max()
    weight = Weight(np.where(touched, mean, 0.0), *(np.where(touched, one, no) for one, no in (
        (x, grid.x[None, :]), (y, grid.y[:, None]), (along, 0.0), (across, 0.0)
    )))  # fmt: skip
    return weight, Spread(*spreads[0]), Spread(*spreads[1])


def _over_rows(grid: Grid, a: float, b: float, rows: slice) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The same in some rows: (5, ...) of the weight, and (3, 3, ...) of the tractions."""
    powers = _powers(grid, a, b, rows)
    wide = 0.0 if grid.line else b  # there y is left out
    dx, dy = grid.sides
    X, Y = np.meshgrid(grid.x / a, grid.y[rows] / b)

    def over_root(i: int, j: int) -> np.ndarray:
        return np.asarray(powers[i, 0, j])

    def times_root(i: int, j: int) -> np.ndarray:
        return np.asarray(powers[i, 2, j] - powers[i + 2, 0, j])

    def rolled(i: int, j: int) -> np.ndarray:
        return np.asarray(powers[i, 1, j] - powers[i + 1, 0, j])

    def spread(of: Callable[[int, int], np.ndarray]) -> np.ndarray:
        found = []
        for i, j, unit in ((0, 0, 1.0), (1, 0, a), (0, 1, wide)):
            mean = of(i, j)
            moments = (of(i + 1, j) - X * mean) * (a / dx), (of(i, j + 1) - Y * mean) * (wide / dy)
            found.append([unit * each for each in (mean, *moments)])
        return np.array(found).swapaxes(0, 1)

    mean = rolled(0, 0)
    safe = np.where(mean > 0, mean, 1.0)
    x, y = rolled(1, 0) / safe, rolled(0, 1) / safe
    along = np.maximum(rolled(2, 0) - x**2 * mean, 0.0) * a**2 / dx
    across = np.maximum(rolled(0, 2) - y**2 * mean, 0.0) * wide**2 / dy
    return np.array([mean, a * x, wide * y, along, across]), spread(over_root), spread(times_root)


def _powers(grid: Grid, a: float, b: float, rows: slice) -> np.ndarray:
    """Means over elements of ``X^k h^m Y^l / sqrt(h^2 - X^2)`` with X = x/a, Y = y/b, h^2 = 1 - Y^2, by k, m and l.

    Along x the integrals are in closed form, across by Gauss's rule.
    """
    if grid.line:
        share, Y = np.ones(1), np.zeros((1, 1))
    else:
        place, share = np.polynomial.legendre.leggauss(NODES)
        Y, share = (grid.y[rows, None] + grid.sides[1] * place / 2) / b, share / 2
    h = np.sqrt(np.maximum(1 - Y**2, 0.0))
    X = np.clip(grid.lines[0] / a, -h[..., None], h[..., None])  # (rows, nodes, lines)
    angle = np.arcsin(X / np.where(h > 0, h, 1.0)[..., None])
    integrals, power = [angle, -np.sqrt(h[..., None] ** 2 - X**2)], X
    for k in (2, 3, 4):
        integrals.append((power * integrals[1] + (k - 1) * h[..., None] ** 2 * integrals[k - 2]) / k)
        power = power * X
    between = np.diff(np.array(integrals)) * (a / grid.sides[0])
    factors = np.array([[h**m * Y**n * share for n in range(3)] for m in range(3)])
    return np.asarray(np.einsum("mlrn,krnx->kmlrx", factors, between, optimize=True))
