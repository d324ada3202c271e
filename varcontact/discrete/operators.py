"""Influence numbers of a lattice: one object owns all tables, and builds each on first use."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from varcontact.elasticity.operators import GridOperator, Medium
from varcontact.errors import SceneError
from varcontact.scene.grid import Grid
from varcontact.system.process import lazy_property
from varcontact.transports import HERE, Stencil

STENCILS_MAX = 4
"""Operators of each kind with a distance that are kept in memory: steps in time, and steps of
steady rolling."""

MEDIA_MAX = 12
"""Media whose operators are kept in memory: parts of viscoelastic bodies, and steps of other
lengths in time."""


@dataclass(frozen=True)
class Operators:
    """The operators between tractions and displacements on a lattice, dimensionless (G = 1).

    What is derived from a discretisation holds the same object: whoever builds a table first,
    builds it for all.
    """

    lattice: Grid
    medium: Medium
    _tables: dict[tuple[str, str, Stencil], GridOperator] = field(
        default_factory=dict, repr=False, compare=False
    )
    _parts: dict[tuple[Grid, Medium], Operators] = field(
        default_factory=dict, repr=False, compare=False
    )

    @lazy_property
    def points(self) -> np.ndarray:
        """x and y of the element centres, (2, ny, nx)."""
        return self.lattice.centres

    @property
    def normal(self) -> GridOperator:
        """A_zz: distances by pressures."""
        return self._table("z", "z")

    def tangential(self, stencil: Stencil = HERE) -> GridOperator:
        """A_tt, shifts by tractions; in steady rolling A_tt - C_tt."""
        return self._table("xy", "xy", stencil)

    def pressure_to_shift(self, stencil: Stencil = HERE) -> GridOperator:
        """A_tz, shifts by pressures, where K != 0; in steady rolling A_tz - C_tz."""
        return self._table("xy", "z", stencil)

    @property
    def traction_to_distance(self) -> GridOperator:
        """A_zt: distances by tractions, where K != 0."""
        return self._table("z", "xy")

    def carrying(self, distance: float) -> GridOperator:
        """C: displacements of the particles that come from further along x, by all tractions that
        contribute.
        """
        columns = "xy"
        if self.medium.K != 0:
            columns = "xyz"
        return self._table("xy", columns, ((distance, 1.0),))

    @property
    def every(self) -> GridOperator:
        """Displacements along all axes by tractions along all axes."""
        return self._table("xyz", "xyz")

    def without_matrices(self) -> Operators:
        """Copy of the tables without the matrices assembled from them, to be kept after a solve."""
        tables = {key: replace(each) for key, each in self._tables.items()}
        return Operators(self.lattice, self.medium, tables)

    def of(self, medium: Medium, lattice: Grid | None = None) -> Operators:
        """Operators of another medium (a part of this one) on this lattice, or on another one."""
        key = lattice or self.lattice, medium
        if key == (self.lattice, self.medium):
            return self
        if key not in self._parts:
            for oldest in list(self._parts)[: max(len(self._parts) + 1 - MEDIA_MAX, 0)]:
                del self._parts[oldest]
            self._parts[key] = Operators(*key)
        return self._parts[key]

    @property
    def at_once(self) -> Operators:
        """Operators of the instantaneous response of viscoelastic bodies; for elastic bodies
        unchanged.
        """
        return self.of(self.medium.at_once)

    def at_end(self, time: float | None) -> Operators:
        """Operators of viscoelastic bodies at the end of a step that lasts some time; for elastic
        bodies unchanged.
        """
        if time is None:
            return self
        return self.of(self.medium.at_end(time))

    def _table(self, rows: str, columns: str, stencil: Stencil = HERE) -> GridOperator:
        key = rows, columns, stencil
        if key not in self._tables:
            if stencil != HERE:
                self._drop_oldest(len(stencil))
            operator = self.medium.operator(self.lattice, *key)
            self._check_shape(operator, rows, columns)
            self._tables[key] = operator
        return self._tables[key]

    def _drop_oldest(self, points: int) -> None:
        """Drop the oldest operator with a distance, to make room: of a step in time (its stencil
        has one point) or of steady rolling.
        """
        kind = [
            key for key in self._tables if key[2] != HERE and (len(key[2]) == 1) == (points == 1)
        ]
        for oldest in kind[: max(len(kind) + 1 - STENCILS_MAX, 0)]:
            del self._tables[oldest]

    def _check_shape(self, operator: GridOperator, rows: str, columns: str) -> None:
        """Refuse an operator that is not between these components on this lattice."""
        ny, nx = self.lattice.shape
        expected = (len(rows), len(columns), 2 * ny - 1, 2 * nx - 1)
        if operator.shape != (ny, nx) or operator.table.shape != expected:
            message = (
                f"the operator of {type(self.medium).__name__} from {columns} to {rows} "
                f"has a table of shape {operator.table.shape} on {operator.shape} elements; "
                f"{expected} is needed"
            )
            raise SceneError("bodies", self.medium, message=message)
