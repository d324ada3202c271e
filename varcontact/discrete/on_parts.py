"""The normal problem on equal parts of elements, where elements at the contact's edge count in part.

The elements bear the means of their parts' pressures, and are covered as far as the parts are in contact. These
pressures are found before any tractions, which must not change them.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from varcontact.discrete.discretisation import Discretisation
from varcontact.discrete.discretise import undeformed_distance
from varcontact.discrete.problem import NormalProblem
from varcontact.scene.grid import Cells

SQUARE: Cells = (3, 3)
"""Parts of an element along y and x: 2 by 2 and 4 by 4 are as good (docs/sampling.md), and odd numbers have a part in
the middle."""
STRIPS: Cells = (1, 7)
"""The same in line contact. With fewer errors jump more, with more they are hardly smaller."""


def cells_of(edge: str, line: bool) -> Cells:
    """Parts of an element along y and x on which a pressure without a closed form is solved for.

    Parameters
    ----------
    edge : str
        As of `Grid`.
    line : bool
        Whether it is line contact.

    Examples
    --------
    >>> cells_of("centres", line=False), cells_of("softened", line=False), cells_of("softened", line=True)
    ((1, 1), (3, 3), (1, 7))
    """
    if edge == "centres":
        return 1, 1
    return STRIPS if line else SQUARE


def parted(disc: Discretisation, cells: Cells) -> Discretisation:
    """The same contact on parts of the elements, in the same scales, for its normal problem.

    Parameters
    ----------
    disc : Discretisation
        Whose elements have their centres within the samples, where there are samples: parts may lie beyond.
    cells : tuple of int
        (rows, columns): parts of an element along y and x.
    """
    grid = disc.grid.divided(cells)
    distance = undeformed_distance(disc.surface, disc.hertz, grid, beyond=max(disc.grid.sides) / 2)
    operators = disc.operators.divided(cells)
    return replace(disc, grid=grid, distance=distance, operators=operators, pressure_on_parts=None, parts=None)


def with_parts(disc: Discretisation, pressure: np.ndarray | None) -> Discretisation:
    """The same with the physical `pressure` on parts of the elements that a solution has; without one as it is.

    Parameters
    ----------
    disc : Discretisation
    pressure : ndarray, shape (ny rows, nx columns), or None
        [force/area]
    """
    if pressure is None:
        return disc
    (rows, columns), (ny, nx) = pressure.shape, disc.grid.shape
    parts = parted(disc, (rows // ny, columns // nx))
    return replace(disc, pressure_on_parts=pressure / disc.pressure, parts=parts)


def unpressed(disc: Discretisation) -> Discretisation:
    """The same without pressure on the parts, where bodies are apart.

    Parameters
    ----------
    disc : Discretisation
    """
    return with_parts(disc, np.zeros(disc.grid.divided(cells_of(disc.grid.edge, disc.line)).shape))


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
    if disc.pressure_on_parts is None or disc.parts is None:
        return disc, pressure, approach
    parts = disc.parts
    return parts, disc.pressure_on_parts, approach + (disc.base - parts.base) / disc.displacement


def normal_as_solved(
    disc: Discretisation, pressure: np.ndarray, approach: float, traction: np.ndarray | None = None
) -> tuple[NormalProblem, np.ndarray, np.ndarray]:
    """The normal problem as it was solved, on elements or on parts of them, with its solution.

    Parameters
    ----------
    disc : Discretisation
    pressure : ndarray, shape (ny, nx)
        On the elements, dimensionless.
    approach : float
        Dimensionless.
    traction : ndarray, shape (2, ny, nx), optional
        Of unlike bodies, dimensionless.

    Returns
    -------
    NormalProblem
    ndarray, shape (n,)
        The pressure, dimensionless.
    ndarray, shape (1,)
        The approach, dimensionless.
    """
    lattice, pressed, level = as_solved(disc, pressure, approach)
    coupled = traction is not None and disc.K != 0 and bool(np.any(traction))
    return lattice.normal_problem(traction if coupled else None), pressed.ravel(), np.array([level])
