"""Tractions that grow like one over the root of the distance from the edge of Hertz's contact."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from varcontact.elasticity.ellipsoidal import rooted_gradients
from varcontact.elasticity.operators import GridOperator
from varcontact.problem.discretisation import Discretisation
from varcontact.scene.grid import Grid

NODES = 32
"""Of Gauss's rule across an element; along it means are in closed form."""

TURNS = 4
"""Of correcting derivatives along one axis by those along the other: three places nearly in line say little."""


@dataclass(frozen=True, eq=False)
class Rooted:
    """Tractions 1, x and y over the root ``sqrt(1 - (x/a)^2 - (y/b)^2)``, or times it, on parts. Dimensionless.

    Attributes
    ----------
    means : ndarray, shape (3, ny, nx)
        Over each part; zero outside the ellipse.
    missing : ndarray, shape (3, 2, 2, ny, nx)
        Minus the derivative along x of the displacement (second axis) by each traction (first axis) acting along x or y
        (third axis), times a part's length, less what their means over the parts have of it.
    """

    means: np.ndarray
    missing: np.ndarray

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
        inside = root > 0
        safe = np.where(inside, root, 1.0)
        factor, x, y = traction / safe, x / safe, y / safe  # means over the root are values where its weight is centred
        along, across = gradients(factor, x, y, inside)
        terms = np.array([factor - along * x - across * y, along, across])
        return np.einsum("kij...,kj...->i...", self.missing, terms)


def rooted(disc: Discretisation, lattice: Grid, derivative: GridOperator) -> Rooted:
    """The tractions over the root on a lattice.

    Parameters
    ----------
    disc : Discretisation
        Of Hertz's contact.
    lattice : Grid
        Parts of its elements, dimensionless.
    derivative : GridOperator
        Minus the derivative of displacement along x on it, times an element's length.

    Returns
    -------
    Rooted
    """
    hertz = disc.hertz
    assert hertz is not None
    a, b = hertz.a / disc.length, hertz.b / disc.length
    found, nothing = over_root(lattice, a, b), np.zeros(lattice.shape)
    exact = -lattice.sides[0] * rooted_gradients(a, b, nu=disc.operators.nu)
    parts = [[derivative.apply(np.array(each)) for each in ((one, nothing), (nothing, one))] for one in found[:3]]
    return Rooted(found[:3], exact[..., None, None] - np.array(parts).swapaxes(1, 2))


def over_root(grid: Grid, a: float, b: float) -> np.ndarray:
    """Means over each element of 1, x and y over the root, and of the root of leading by trailing distance.

    Parameters
    ----------
    grid : Grid
        Explicit.
    a, b : float
        Semi-axes of the ellipse along x and y, in the unit of the grid; b is infinite in line contact.

    Returns
    -------
    ndarray, shape (4, ny, nx)
        The last of ``sqrt((e - x)/(e + x))``, e the half length of the ellipse at y: what tractions are in proportion
        to where a row sticks from end to end.
    """
    if grid.line:
        lines, y, share = grid.lines[0], np.zeros((1, 1)), np.ones(1)
    else:
        lines, across = grid.lines
        place, share = np.polynomial.legendre.leggauss(NODES)
        y, share = across[:-1, None] + np.diff(across)[:, None] * (place + 1) / 2, share / 2
    half = a * np.sqrt(np.maximum(1 - (y / b) ** 2, 0.0))[:, None, :]
    x = np.clip(lines[:, None], -half, half)
    angle, depth = np.arcsin(x / np.where(half > 0, half, 1.0)), np.sqrt(half**2 - x**2)
    integrals = np.array([a * angle, -a * depth, a * angle * y[:, None, :], half * angle + depth])
    return np.asarray(np.diff(integrals, axis=2) @ share / np.diff(lines))


def gradients(values: np.ndarray, x: np.ndarray, y: np.ndarray, known: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Derivatives along x and y of values in parts, each where its weight is centred.

    Parts that the edge cuts have their places beside the lines of the others: what the values change along the one
    direction counts in the differences along the other.

    Parameters
    ----------
    values : ndarray, shape (n, ny, nx)
    x, y : ndarray, shape (ny, nx)
        Places, rising along rows and along columns where there are values.
    known : bool ndarray, shape (ny, nx)
        Where there are values.

    Returns
    -------
    ndarray, ndarray, shape (n, ny, nx)

    Examples
    --------
    Of 2 x + 3 y, where a corner is cut.

    >>> x, y = np.array([[0.3, 1.0], [0.0, 1.0]]), np.array([[0.3, 0.0], [1.0, 1.0]])
    >>> along, across = gradients((2 * x + 3 * y)[None], x, y, np.full((2, 2), True))
    >>> print(along.round(2)[0].tolist(), across.round(2)[0].tolist())
    [[2.0, 2.0], [2.0, 2.0]] [[3.0, 3.0], [3.0, 3.0]]
    """

    def upwards(of: np.ndarray) -> np.ndarray:
        return slopes(of.swapaxes(1, 2), y.T, known.T).swapaxes(1, 2)

    rows, columns, aside, askew = slopes(values, x, known), upwards(values), slopes(y[None], x, known), upwards(x[None])
    across = columns
    for _ in range(TURNS):
        along = rows - across * aside
        across = columns - along * askew
    return along, across


def slopes(values: np.ndarray, places: np.ndarray, known: np.ndarray) -> np.ndarray:
    """Derivatives along the last axis: by the parabola through both neighbours, or the line through one.

    Parameters
    ----------
    values : ndarray, shape (n, rows, columns)
    places : ndarray, shape (rows, columns)
        Rising.
    known : bool ndarray, shape (rows, columns)
        Where there are values.

    Returns
    -------
    ndarray, shape (n, rows, columns)
        Zero where no neighbour is known.

    Examples
    --------
    >>> slopes(np.array([[[0.0, 1.0, 9.0, 7.0]]]), np.array([[0.0, 1.0, 3.0, 4.0]]), np.array([[True] * 3 + [False]]))
    array([[[1., 2., 4., 0.]]])
    """
    steps, pairs = np.diff(places), known[:, 1:] & known[:, :-1]
    rises = np.where(pairs, np.diff(values) / np.where(pairs, steps, 1.0), 0.0)
    lengths = np.where(pairs, steps, 0.0)
    before, after = (np.pad(rises, ((0, 0), (0, 0), side)) for side in ((1, 0), (0, 1)))
    behind, ahead = (np.pad(lengths, ((0, 0), side)) for side in ((1, 0), (0, 1)))
    both, either = (behind > 0) & (ahead > 0), behind + ahead
    parabola = (before * ahead + after * behind) / np.where(either > 0, either, 1.0)
    return np.where(both, parabola, before + after)
