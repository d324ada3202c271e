"""Tractions 1, x and y over the root of Hertz's pressure, or times it: their means, and what parts miss of them."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from varcontact.elasticity.ellipsoidal import ellipsoidal_gradients, sloped_gradients
from varcontact.elasticity.operators import GridOperator
from varcontact.scene.grid import Grid
from varcontact.solving.defect_correction.slopes import Around

NODES = 32
"""Of Gauss's rule across an element; along it means are in closed form."""
ROWS_AT_ONCE = 16
"""Rows of elements whose integrals are computed in one go."""
LEAST = 1e-7
"""Mean of a traction, by the largest, from which on an element counts as touched: less may be rounding."""


@dataclass(frozen=True, eq=False)
class RootMeans:
    """Means over the elements of a grid, by the root ``r = sqrt(1 - (x/a)^2 - (y/b)^2)``; zero outside the ellipse.

    Attributes
    ----------
    over, times : ndarray, shape (3, ny, nx)
        Of 1, x and y over r, and times r.
    weight : ndarray, shape (ny, nx)
        Of ``sqrt((e - x)/(e + x))``, e the half length of the ellipse at y: what tractions are in proportion to where a
        row sticks from end to end.
    """

    over: np.ndarray
    times: np.ndarray
    weight: np.ndarray


def root_means(grid: Grid, a: float, b: float) -> RootMeans:
    """The means over the elements of a grid.

    Parameters
    ----------
    grid : Grid
        Explicit.
    a, b : float
        Semi-axes of the ellipse along x and y, in the unit of the grid; b is infinite in line contact.

    Returns
    -------
    RootMeans
    """
    if grid.line:
        y, share = np.zeros((1, 1)), np.ones(1)
    else:
        (_, across), (place, share) = grid.lines, np.polynomial.legendre.leggauss(NODES)
        y, share = across[:-1, None] + np.diff(across)[:, None] * (place + 1) / 2, share / 2
    parts = [y[first : first + ROWS_AT_ONCE] for first in range(0, len(y), ROWS_AT_ONCE)]
    found = np.concatenate([_over_rows(grid.lines[0], each[:, None], share, a, b) for each in parts], axis=1)
    return RootMeans(found[:3], found[3:6], found[6])


def _over_rows(lines: np.ndarray, y: np.ndarray, share: np.ndarray, a: float, b: float) -> np.ndarray:
    """Means between the lines, in closed form along x, and by nodes y with these shares across: (7, rows, columns)."""
    half = a * np.sqrt(np.maximum(1 - (y / b) ** 2, 0.0))
    x = np.clip(lines[:, None], -half, half)
    angle, depth = np.arcsin(x / np.where(half > 0, half, 1.0)), np.sqrt(half**2 - x**2)
    lens = (x * depth + half**2 * angle) / (2 * a)
    over, times = (a * angle, -a * depth, a * angle * y), (lens, -(depth**3) / (3 * a), lens * y)
    return np.asarray(np.diff(np.array([*over, *times, half * angle + depth]), axis=2) @ share / np.diff(lines))


@dataclass(frozen=True, eq=False)
class Rooted:
    """Tractions 1, x and y over the root, or times it, on parts. Dimensionless.

    Attributes
    ----------
    means : ndarray, shape (3, ny, nx)
        Over each part; zero outside the ellipse.
    missing : ndarray, shape (3, 2, 2, ny, nx)
        Minus the derivative along x of the displacement (second axis) by each traction (first axis) acting along x or y
        (third axis), times a part's length, less what parts have of it.
    """

    means: np.ndarray
    missing: np.ndarray

    @cached_property
    def around(self) -> Around:
        """Derivatives around the places where the tractions in the parts are centred."""
        root, x, y = self.means
        safe = np.where(root > 0, root, 1.0)  # means over the root are values where its weight is centred
        return Around.at(x / safe, y / safe, root > 0)

    def lacking(self, traction: np.ndarray) -> np.ndarray:
        """What the parts miss of a traction that is a smooth factor over the root, or times it.

        Around each part the factor is linear, with the differences to the neighbours.

        Parameters
        ----------
        traction : ndarray, shape (2, ny, nx)
            Zero outside the contact.

        Returns
        -------
        ndarray, shape (2, ny, nx)
        """
        root, x, y = self.means
        safe = np.where(root > 0, root, 1.0)
        factor = traction * (root > 0) / safe
        along, across = self.around.gradients(factor)
        terms = np.array([factor - along * (x / safe) - across * (y / safe), along, across])
        return np.einsum("kij...,kj...->i...", self.missing, terms)


def rooted(
    means: np.ndarray, gradients: np.ndarray, side: float, derivative: GridOperator, acting: np.ndarray | None = None
) -> Rooted:
    """Tractions on parts, of which the derivative of the displacement is known.

    Parameters
    ----------
    means : ndarray, shape (3, ny, nx)
        Of 1, x and y over the root, or times it.
    gradients : ndarray, shape (3, 2, 2, ...)
        Derivatives along x of the displacement differences, for G = 1: uniform, or on each part.
    side : float
        Length of a part.
    derivative : GridOperator
        Minus the derivative of displacement along x on the parts, times their length.
    acting : ndarray, shape (3, ny, nx), optional
        The constant tractions that the parts have; their means, if not given.

    Returns
    -------
    Rooted
    """
    nothing = np.zeros(means.shape[1:])
    tractions = means if acting is None else acting
    found = [[derivative.apply(np.array(each)) for each in ((one, nothing), (nothing, one))] for one in tractions]
    exact = gradients if gradients.ndim > 3 else gradients[..., None, None]
    return Rooted(means * (means[0] > LEAST * means[0].max()), -side * exact - np.array(found).swapaxes(1, 2))


def mean_gradients(grid: Grid, a: float, b: float, nu: float) -> np.ndarray:
    """Derivatives along x of displacement differences by 1, x and y times the root, means over the elements.

    Parameters
    ----------
    grid : Grid
        Explicit.
    a, b : float
        Semi-axes along x and y, in the unit of the grid; b is infinite in line contact.
    nu : float
        Combined constant (59).

    Returns
    -------
    ndarray, shape (3, 2, 2, ny, nx)
        As of `sloped_gradients`, for G = 1. They are of second degree at most: four points give exact means.
    """
    x, y = np.meshgrid(grid.x, grid.y)
    dx, dy = (side / np.sqrt(12) for side in grid.sides)
    linear = ellipsoidal_gradients(x, y, a, b, nu=nu)[None]
    corners = [(-dx, -dy), (-dx, dy), (dx, -dy), (dx, dy)]
    bent = np.mean([sloped_gradients(x + right, y + up, a, b, nu=nu) for right, up in corners], axis=0)
    return np.concatenate([linear, bent])
