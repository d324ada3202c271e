"""The normal problem on equal parts of elements, where elements at the contact's edge count in part.

The elements bear the means of their parts' pressures, and are covered as far as the parts are in contact. Tractions do
not change these pressures: they are found first, and with like bodies only.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from varcontact.problem.discretisation import Discretisation
from varcontact.problem.discretise import undeformed_distance
from varcontact.scene.grid import Cells

SQUARE: Cells = (3, 3)
"""Parts of an element along y and x. With 4 by 4, forces are a quarter more exact for a third more time."""
STRIPS: Cells = (1, 8)
"""The same in line contact. Fewer let the error jump, with more it is hardly smaller."""


def cells_of(edge: str, line: bool) -> Cells:
    """Parts of an element along y and x, on which a pressure is solved for.

    Parameters
    ----------
    edge : str
        As of `Grid`.
    line : bool
        Whether it is line contact.

    Examples
    --------
    >>> cells_of("centres", line=False), cells_of("softened", line=False), cells_of("softened", line=True)
    ((1, 1), (2, 2), (1, 8))
    """
    if edge == "centres":
        return 1, 1
    return STRIPS if line else SQUARE


def parted(disc: Discretisation, cells: Cells) -> Discretisation:
    """The same contact on parts of the elements, in the same scales, for its normal problem.

    Parameters
    ----------
    disc : Discretisation
    cells : tuple of int
        (rows, columns): parts of an element along y and x.
    """
    grid = disc.grid.divided(cells)
    distance = undeformed_distance(disc.surface, disc.hertz, grid)
    return replace(disc, grid=grid, distance=distance, operators=disc.operators.divided(cells), on_parts=None)


def with_parts(disc: Discretisation, pressure: np.ndarray | None) -> Discretisation:
    """The same with the physical `pressure` on parts of the elements that a solution has; without one as it is.

    Parameters
    ----------
    disc : Discretisation
    pressure : ndarray, shape (ny rows, nx columns), or None
        [force/area]
    """
    return disc if pressure is None else replace(disc, on_parts=pressure / disc.pressure)


def apart(disc: Discretisation) -> Discretisation:
    """The same, whose parts of elements are all without pressure.

    Parameters
    ----------
    disc : Discretisation
    """
    rows, columns = cells_of(disc.grid.edge, disc.line)
    return replace(disc, on_parts=np.zeros((disc.grid.rows * rows, disc.grid.nx * columns)))


def as_solved(disc: Discretisation, pressure: np.ndarray, approach: float) -> tuple[Discretisation, np.ndarray, float]:
    """A contact with its pressure on that lattice on which the normal problem was solved.

    Parameters
    ----------
    disc : Discretisation
    pressure : ndarray, shape (ny, nx)
        On the elements, dimensionless.
    approach : float
        Dimensionless.

    Returns
    -------
    Discretisation
        Of the elements, or of their parts.
    ndarray
        The pressure there, dimensionless.
    float
        The approach, dimensionless.
    """
    if disc.on_parts is None:
        return disc, pressure, approach
    parts = parted(disc, disc.cells)
    return parts, disc.on_parts, approach + (disc.base - parts.base) / disc.displacement
