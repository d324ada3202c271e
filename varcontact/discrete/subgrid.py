"""Equal parts of elements, where those at the contact's edge count in part.

The elements bear the means of their parts' pressures, and are covered as far as the parts are in contact. These
pressures are found before any tractions, which must not change them.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from varcontact.discrete.discretisation import Discretisation, Subgrid, undeformed_distance
from varcontact.discrete.problems import NormalProblem
from varcontact.scene.grid import Cells

SQUARE: Cells = (3, 3)
"""Parts of an element along y and x: 2 by 2 and 4 by 4 are as good (docs/sampling.md), and odd numbers have a part in
the middle."""
STRIPS: Cells = (1, 7)
"""The same in line contact. With fewer errors jump more, with more they are hardly smaller."""


def cells_of(edge: str, line: bool) -> Cells:
    """Parts of an element on which a pressure without a closed form is solved for, by `Grid.edge`."""
    if edge == "centres":
        return 1, 1
    return STRIPS if line else SQUARE


def means(values: np.ndarray, cells: Cells) -> np.ndarray:
    """Means (..., ny, nx) of values (..., ny rows, nx columns) over the parts of each element."""
    rows, columns = cells
    ny, nx = values.shape[-2] // rows, values.shape[-1] // columns
    return np.asarray(values.reshape(*values.shape[:-2], ny, rows, nx, columns).mean(axis=(-3, -1)))


def divided(disc: Discretisation, cells: Cells) -> Discretisation:
    """The same contact on parts of the elements, in the same scales, for its normal problem.

    The elements have their centres within the samples, where there are samples: parts may lie beyond.
    """
    grid = disc.grid.divided(cells)
    distance = undeformed_distance(disc.surface, disc.hertz, grid, beyond=max(disc.grid.sides) / 2)
    return replace(disc, grid=grid, distance=distance, operators=disc.operators.divided(cells), subgrid=None)


def with_subgrid(disc: Discretisation, pressure: np.ndarray | None) -> Discretisation:
    """The same with the physical pressure on parts of the elements that a solution has; without one as it is."""
    if pressure is None:
        return disc
    (rows, columns), (ny, nx) = pressure.shape, disc.grid.shape
    parts = divided(disc, (rows // ny, columns // nx))
    return replace(disc, subgrid=Subgrid(parts, pressure / disc.scales.pressure))


def without_pressure(disc: Discretisation) -> Discretisation:
    """The same with a subgrid that bears nothing, where bodies are apart."""
    return with_subgrid(disc, np.zeros(disc.grid.divided(cells_of(disc.grid.edge, disc.line)).shape))


def as_solved(disc: Discretisation, pressure: np.ndarray, approach: float) -> tuple[Discretisation, np.ndarray, float]:
    """A contact, its pressure (ny, nx) and approach, dimensionless, on the lattice of its normal problem."""
    if disc.subgrid is None:
        return disc, pressure, approach
    parts = disc.subgrid.disc
    return parts, disc.subgrid.pressure, approach + (disc.base - parts.base) / disc.scales.displacement


def normal_as_solved(
    disc: Discretisation, pressure: np.ndarray, approach: float, traction: np.ndarray | None = None
) -> tuple[NormalProblem, np.ndarray, np.ndarray]:
    """The normal problem as it was solved, on elements or on parts of them, its pressure (n,) and approach (1,).

    Given are those of the elements, and the tractions (2, ny, nx) of unlike bodies; all is dimensionless.
    """
    lattice, pressure, approach = as_solved(disc, pressure, approach)
    coupled = traction is not None and disc.K != 0 and bool(np.any(traction))
    return lattice.normal_problem(traction if coupled else None), pressure.ravel(), np.array([approach])
