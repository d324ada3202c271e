"""The pressures and tractions on a grid that pass from one solver to the next,
and equal parts of its elements.

Elements at the contact's edge may count in part: they carry the means of their
parts' pressures, and are covered as far as the parts are in contact. These
pressures are found before any tractions, which must not change them.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from varcontact.discrete.contact_grid import no_element_in_contact
from varcontact.discrete.discretisation import Discretisation, Subgrid
from varcontact.discrete.problems import NormalProblem
from varcontact.elasticity.of_scenes import FREE_DEPTH
from varcontact.reference.line_contact import line_contact
from varcontact.scene.bodies import Bodies
from varcontact.scene.grid import Cells, Grid
from varcontact.scene.surfaces import Cylinders
from varcontact.system.process import changed

SQUARE: Cells = (3, 3)
"""Parts of an element along y and x: 2 by 2 and 4 by 4 are as accurate (docs/sampling.md), and an
odd number has a part in the middle."""
STRIPS: Cells = (1, 7)
"""Parts of a strip along y and x in line contact. With fewer parts errors jump more from grid to
grid, with more they hardly fall."""


@dataclass(frozen=True, eq=False)
class ContactState:
    """Pressure (ny, nx) and tractions (2, ny, nx) on the whole grid, dimensionless, and the records
    of the solvers.
    """

    pressure: np.ndarray
    approach: float
    traction: np.ndarray
    rigid: np.ndarray  # (2,) Uniform rigid shift where a force is prescribed, else 0
    iterations: dict[str, int] = field(default_factory=dict)
    status: dict[str, str] = field(default_factory=dict)
    solved: dict[str, bool] = field(default_factory=dict)
    solved_by: dict[str, str] = field(default_factory=dict)
    reasons: dict[str, str] = field(default_factory=dict)
    # for each pass of a coupling loop: its change, and the overall residual after it
    passes: tuple[tuple[float, float], ...] = ()
    pass_count: int = 0  # of all loops so far, including nested ones
    bound_pressure: np.ndarray | None = None
    # (ny, nx) Slip area, if a theory gives it; otherwise it follows from the natural map
    slips: np.ndarray | None = None
    # implicit fields of the interfaces in the next pass, (ny, nx), and where the search for them
    # began
    fields: Mapping[str, np.ndarray] = field(default_factory=dict)
    branch: str = ""

    def under(self, fields: Mapping[str, np.ndarray]) -> ContactState:
        """Copy with these implicit fields added."""
        return changed(self, fields={**self.fields, **fields})


def unloaded(grid: Grid) -> ContactState:
    return ContactState(np.zeros(grid.shape), 0.0, np.zeros((2, *grid.shape)), np.zeros(2))


def hertz_pressure(disc: Discretisation, state: ContactState) -> ContactState:
    """State with Hertz's pressure on the elements, scaled to carry exactly Hertz's force."""
    assert disc.hertz is not None
    pressure = disc.hertz.on_elements(disc.grid)
    if not pressure.any():
        raise no_element_in_contact(disc.surface, disc.loading.approach, disc.grid)
    pressure *= disc.hertz.force / (pressure.sum() * disc.grid.area)
    return changed(state, pressure=pressure / disc.scales.pressure, approach=hertz_approach(disc))


def hertz_approach(disc: Discretisation) -> float:
    """The approach of Hertz's contact, dimensionless."""
    assert disc.hertz is not None
    approach = disc.hertz.approach
    if disc.grid.line:  # from the depth that its influence numbers have
        assert isinstance(disc.bodies, Bodies)
        assert isinstance(disc.surface, Cylinders)
        depth = disc.surface.reference_depth
        if depth is None:
            depth = FREE_DEPTH * disc.scales.length
        approach = line_contact(disc.hertz.Rx, disc.bodies, a=disc.hertz.a).approach(depth)
    return (approach - disc.base) / disc.scales.displacement


def cells_of(edge: str, line: bool) -> Cells:
    """Parts of an element on which a pressure without a closed form is solved for, by
    `Grid.edge`.
    """
    if edge == "centres":
        return 1, 1
    if line:
        return STRIPS
    return SQUARE


def means(values: np.ndarray, cells: Cells) -> np.ndarray:
    """Means (..., ny, nx) of values (..., ny rows, nx columns) over the parts of each element."""
    rows, columns = cells
    ny, nx = values.shape[-2] // rows, values.shape[-1] // columns
    return np.asarray(values.reshape(*values.shape[:-2], ny, rows, nx, columns).mean(axis=(-3, -1)))


def divided(disc: Discretisation, cells: Cells) -> Discretisation:
    """Discretisation for the normal problem on parts of the elements, in the same scales.

    The elements have their centres within the samples, where there are samples: parts may lie
    beyond.
    """
    grid = disc.grid.divided(cells)
    distance = disc.undeformed_distance(grid, beyond=max(disc.grid.sides) / 2)
    operators = disc.operators.of(disc.operators.medium, disc.lattice.divided(cells))
    return replace(disc, grid=grid, distance=distance, operators=operators, subgrid=None)


def with_subgrid(disc: Discretisation, pressure: np.ndarray | None) -> Discretisation:
    """Copy with the physical pressure [force/area] of a solution on parts of the elements;
    unchanged if `pressure` is None.
    """
    if pressure is None:
        return disc
    rows, columns = pressure.shape
    ny, nx = disc.grid.shape
    parts = divided(disc, (rows // ny, columns // nx))
    return replace(disc, subgrid=Subgrid(parts, pressure / disc.scales.pressure))


def as_solved(
    disc: Discretisation, pressure: np.ndarray, approach: float
) -> tuple[Discretisation, np.ndarray, float]:
    """A contact, its pressure (ny, nx) and approach, dimensionless, on the lattice of its normal
    problem.
    """
    if disc.subgrid is None:
        return disc, pressure, approach
    parts = disc.subgrid.disc
    approach = approach + (disc.base - parts.base) / disc.scales.displacement
    return parts, disc.subgrid.pressure, approach


def normal_as_solved(
    disc: Discretisation, pressure: np.ndarray, approach: float, traction: np.ndarray | None = None
) -> tuple[NormalProblem, np.ndarray, np.ndarray]:
    """The normal problem as it was solved, on elements or on parts of them, its pressure (n,) and
    approach (1,).

    Given are those of the elements, and the tractions (2, ny, nx) of unlike bodies; all is
    dimensionless.
    """
    if traction is not None and (disc.K == 0 or not np.any(traction)):
        traction = None
    lattice, pressure, approach = as_solved(disc, pressure, approach)
    return lattice.normal_problem(traction), pressure.ravel(), np.array([approach])
