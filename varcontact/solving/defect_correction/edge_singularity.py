"""Tractions with the roots of Hertz's edge: their means over the parts of elements, and what constant parts miss."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from varcontact.elasticity.ellipsoidal import ellipsoidal_gradients, sloped_gradients
from varcontact.elasticity.operators import GridOperator
from varcontact.scene.grid import Grid

NODES = 32
"""Of Gauss's rule across an element; along it means are in closed form."""
ROWS_AT_ONCE = 16
"""Rows of elements whose integrals are computed in one go."""
LEAST = 1e-7
"""Mean of a traction, by the largest, from which on an element counts as touched: less may be rounding."""
TURNS = 4
"""Of correcting derivatives along one axis by those along the other: three places nearly in line say little."""


@dataclass(frozen=True, eq=False)
class RootMeans:
    """Means over elements, with ``r = sqrt(1 - (x/a)^2 - (y/b)^2)``; zero outside the ellipse."""

    over: np.ndarray  # (3, ny, nx) Of 1, x and y over r, and times r
    times: np.ndarray  # (3, ny, nx) Of 1, x and y over r, and times r
    weight: np.ndarray


def root_means(grid: Grid, a: float, b: float) -> RootMeans:
    """The means over the elements of an explicit grid, for an ellipse of semi-axes a and b."""
    (x, across), (place, share) = grid.lines, np.polynomial.legendre.leggauss(NODES)
    y = across[:-1, None] + np.diff(across)[:, None] * (place + 1) / 2
    blocks = [y[first : first + ROWS_AT_ONCE] for first in range(0, len(y), ROWS_AT_ONCE)]
    found = np.concatenate([_means_in_rows(x, each[:, None], share / 2, a, b) for each in blocks], axis=1)
    return RootMeans(found[:3], found[3:6], found[6])


def _means_in_rows(lines: np.ndarray, y: np.ndarray, share: np.ndarray, a: float, b: float) -> np.ndarray:
    """Means between the lines, in closed form along x, and by nodes y with these shares across: (7, rows, columns)."""
    half = a * np.sqrt(np.maximum(1 - (y / b) ** 2, 0.0))
    x = np.clip(lines[:, None], -half, half)
    angle, depth = np.arcsin(x / np.where(half > 0, half, 1.0)), np.sqrt(half**2 - x**2)
    lens = (x * depth + half**2 * angle) / (2 * a)
    over, times = (a * angle, -a * depth, a * angle * y), (lens, -(depth**3) / (3 * a), lens * y)
    return np.asarray(np.diff(np.array([*over, *times, half * angle + depth]), axis=2) @ share / np.diff(lines))


@dataclass(frozen=True, eq=False)
class KnownTractions:
    """Tractions 1, x and y over the root, or times it, whose displacement is known in closed form."""

    means: np.ndarray  # (3, ny, nx) Over each part; zero outside the ellipse
    missing: np.ndarray

    @classmethod
    def on(cls, means: np.ndarray, gradients: np.ndarray, side: float, derivative: GridOperator) -> KnownTractions:
        """From the exact gradients (3, 2, 2, ...) and the derivative on the parts, of length `side`."""
        nothing = np.zeros(means.shape[1:])
        found = [[derivative.apply(np.array(each)) for each in ((one, nothing), (nothing, one))] for one in means]
        missing = -side * gradients - np.array(found).swapaxes(1, 2)
        return cls(means * (means[0] > LEAST * means[0].max()), missing)

    def missed(self, traction: np.ndarray) -> np.ndarray:
        """What parts miss of a traction (2, ny, nx): a factor of the first one, linear around each part."""
        root = self.means[0]
        within = np.where(root > 0, root, 1.0)
        factor, (x, y) = traction * (root > 0) / within, self.means[1:] / within  # where the first is centred
        along, across = LocalGradient.at(x, y, root > 0).of(factor)
        terms = np.array([factor - along * x - across * y, along, across])
        return np.einsum("kij...,kj...->i...", self.missing, terms)


def times_root_gradients(grid: Grid, a: float, b: float, nu: float) -> np.ndarray:
    """Derivatives along x of displacements by 1, x and y times the root, means over elements, (3, 2, 2, ny, nx).

    They are of second degree at most: four points give exact means.
    """
    x, y = np.meshgrid(grid.x, grid.y)
    dx, dy = (side / np.sqrt(12) for side in grid.sides)
    linear = ellipsoidal_gradients(x, y, a, b, nu=nu)[None]
    corners = [(-dx, -dy), (-dx, dy), (dx, -dy), (dx, dy)]
    bent = np.mean([sloped_gradients(x + right, y + up, a, b, nu=nu) for right, up in corners], axis=0)
    return np.concatenate([linear, bent])


@dataclass(frozen=True, eq=False)
class LocalGradient:
    """Derivatives along x and y of values in parts of elements, each known where its weight is centred.

    Parts that the edge cuts have their centres beside the lines of the others: what values change along the one
    direction counts in the differences along the other.
    """

    rows: np.ndarray
    columns: np.ndarray
    aside: np.ndarray  # (ny, nx) What y changes along rows by x, and x along columns by y
    askew: np.ndarray  # (ny, nx) What y changes along rows by x, and x along columns by y

    @classmethod
    def at(cls, x: np.ndarray, y: np.ndarray, known: np.ndarray) -> LocalGradient:
        """Of values at places that rise along rows and columns, where they are known, each (ny, nx)."""
        rows, columns = _rise_shares(x, known), _rise_shares(y.T, known.T)
        return cls(rows, columns, _along_rows(y, rows), _along_rows(x.T, columns).T)

    def of(self, values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Derivatives along x and y of values (n, ny, nx) that are zero where they are not known."""
        rows = _along_rows(values, self.rows)
        columns = _along_rows(values.swapaxes(1, 2), self.columns).swapaxes(1, 2)
        across = columns
        for _ in range(TURNS):
            along = rows - across * self.aside
            across = columns - along * self.askew
        return along, across


def _rise_shares(places: np.ndarray, known: np.ndarray) -> np.ndarray:
    """Shares of `LocalGradient`: of the parabola through both neighbours, or the line through the one that is known."""
    lengths = np.where(known[:, 1:] & known[:, :-1], np.diff(places), 0.0)
    behind, ahead = (np.pad(lengths, ((0, 0), side)) for side in ((1, 0), (0, 1)))
    both, either = (behind > 0) & (ahead > 0), np.where(behind + ahead > 0, behind + ahead, 1.0)
    return np.array(
        [
            np.where(one > 0, np.where(both, other / either, 1.0) / np.where(one > 0, one, 1.0), 0.0)
            for one, other in ((behind, ahead), (ahead, behind))
        ]
    )


def _along_rows(values: np.ndarray, shares: np.ndarray) -> np.ndarray:
    """Derivatives of values (..., rows, columns) along their rows."""
    rises, found = np.diff(values), np.zeros(values.shape)
    found[..., 1:] += rises * shares[0, :, 1:]
    found[..., :-1] += rises * shares[1, :, :-1]
    return found
