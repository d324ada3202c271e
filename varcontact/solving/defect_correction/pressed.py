"""The pressure on parts of coarse elements: Hertz's in closed form, or solved for on a finer lattice."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from varcontact.discrete.discretisation import Discretisation
from varcontact.discrete.subgrid import means
from varcontact.elasticity.ellipsoidal import ellipsoidal_gradients
from varcontact.elasticity.operators import GridOperator, influence_operator
from varcontact.scene.grid import Cells, Grid

BEHIND = 0.25
"""Part of an element that is added to distances from the trailing edge of a pressure that is solved for.

With half of one, forces without slip are a third farther off, and with a thirtieth they are noise.
"""
FINER = 2
"""Parts of a part along each side, on which a pressure is solved for: with four the error is hardly less."""


@dataclass(frozen=True, eq=False)
class Pressed:
    """The pressure on the parts of elements, and what it says of its edge. Dimensionless.

    Attributes
    ----------
    pressure : ndarray, shape (ny rows, nx columns)
        Means over the parts.
    shift : ndarray, shape (2, 2, ny rows, nx columns)
        Minus the derivative along x of the displacement (first axis) by the pressure acting as a traction along x or y
        (second axis), times a part's length.
    weights : tuple of two ndarrays
        What tractions are in proportion to where nothing slips up to the trailing edge, on the elements and on the
        parts: they grow there like one over the root of the distance.
    """

    pressure: np.ndarray
    shift: np.ndarray
    weights: tuple[np.ndarray, np.ndarray]


def hertz_pressed(disc: Discretisation, cells: Cells, weight: np.ndarray) -> Pressed:
    """Hertz's pressure: its derivative is linear in x and y, and the weights are exact means.

    Parameters
    ----------
    disc : Discretisation
    cells : tuple of int
        (rows, columns): parts of an element along y and x.
    weight : ndarray, shape (ny rows, nx columns)
        What tractions are in proportion to without slip, on the parts.

    Returns
    -------
    Pressed
    """
    hertz = disc.hertz
    assert hertz is not None
    grid, lattice = disc.grid.divided(cells), disc.lattice.divided(cells)
    x, y = np.meshgrid(lattice.x, lattice.y)
    a, b = hertz.a / disc.scales.length, hertz.b / disc.scales.length
    gradients = ellipsoidal_gradients(x, y, a, b, nu=disc.operators.nu)
    return Pressed(
        hertz.mean_pressure(*grid.lines) / disc.scales.pressure,
        -lattice.sides[0] * hertz.peak_pressure / disc.scales.pressure * gradients,
        (means(weight, cells), weight),
    )


def solved_pressed(disc: Discretisation, cells: Cells, elements: np.ndarray, finer: np.ndarray) -> Pressed:
    """A pressure that was solved for on parts of the parts.

    Parameters
    ----------
    disc : Discretisation
    cells : tuple of int
        (rows, columns): parts of an element along y and x.
    elements : ndarray, shape (ny, nx)
        On the elements, dimensionless.
    finer : ndarray, shape (ny rows finer, nx columns finer)
        Dimensionless; on the parts that `within_parts` says.

    Returns
    -------
    Pressed
    """
    within = within_parts(disc)
    both = (cells[0] * within[0], cells[1] * within[1])
    pressure, grid = means(finer, within), disc.grid.divided(both)
    operator, nothing = derivative(disc, disc.lattice.divided(both)), np.zeros_like(finer)
    shift = np.array([operator.apply(np.array(each)) for each in ((finer, nothing), (nothing, finer))]).swapaxes(0, 1)
    weight = np.where(pressure > 0, pressure, 1.0)  # by the pressure: beyond the edge the derivative says nothing

    def behind(lattice: Grid, trailing: np.ndarray) -> np.ndarray:
        distance = np.maximum(lattice.x[None, :] - trailing, 0.0) + BEHIND * disc.grid.sides[0]
        return np.asarray(distance / disc.scales.length)

    on_elements = elements / behind(disc.grid, _trailing(finer, grid, both))
    on_parts = pressure / behind(disc.grid.divided(cells), _trailing(finer, grid, within))
    return Pressed(pressure, means(shift * finer, within) / weight * within[1], (on_elements, on_parts))


def within_parts(disc: Discretisation) -> Cells:
    """Parts of a part along y and x, on which a pressure is solved for.

    Parameters
    ----------
    disc : Discretisation
    """
    return (1 if disc.line else FINER, FINER)


def _trailing(pressure: np.ndarray, grid: Grid, cells: Cells) -> np.ndarray:
    """Means over coarser rectangles of the x at which the patch under each element ends at the trailing side."""
    contact = pressure > 0
    begins = contact & ~np.pad(contact, ((0, 0), (1, 0)))[:, :-1]
    lines = grid.x - grid.sides[0] / 2
    edge = np.maximum.accumulate(np.where(begins, lines, lines[0]), axis=1)
    share = means(contact.astype(float), cells)
    found = means(np.where(contact, edge, 0.0), cells) / np.where(share > 0, share, 1.0)
    return np.asarray(np.where(share > 0, found, np.inf))


def derivative(disc: Discretisation, lattice: Grid) -> GridOperator:
    """Minus the derivative of displacement along x, times an element's length: its mean over each element.

    Parameters
    ----------
    disc : Discretisation
    lattice : Grid
        Dimensionless.

    Returns
    -------
    GridOperator
    """
    side, operators = lattice.sides[0], disc.operators
    return influence_operator(lattice, "xy", "xy", nu=operators.nu, depth=operators.depth, lag=side, offset=-side / 2)
