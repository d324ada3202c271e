"""Elastic shear layer between the bodies: its displacement is its compliance times the traction."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from varcontact.elasticity.operators import GridOperator, Medium
from varcontact.scene.grid import Grid
from varcontact.transports import HERE, Stencil


@dataclass(frozen=True)
class ShearLayer:
    """Medium with a shear layer between its bodies; the compliance is dimensionless, G = 1."""

    bodies: Medium
    compliance: float

    @property
    def K(self) -> float:
        return self.bodies.K

    @property
    def even(self) -> bool:
        return self.bodies.even

    @property
    def reciprocal(self) -> bool:
        return self.bodies.reciprocal

    @property
    def at_once(self) -> ShearLayer:
        return replace(self, bodies=self.bodies.at_once)

    def at_end(self, time: float) -> ShearLayer:
        return replace(self, bodies=self.bodies.at_end(time))

    def operator(
        self, lattice: Grid, rows: str, columns: str, stencil: Stencil = HERE
    ) -> GridOperator:
        """The operator of the bodies, with the shear of the layer, linear between the centres of
        elements.
        """
        bare = self.bodies.operator(lattice, rows, columns, stencil)
        compliances = {"x": self.compliance, "y": self.compliance}
        sprung = springs(lattice, rows, columns, stencil, compliances)
        return GridOperator(bare.shape, bare.table + sprung.table)


def springs(
    lattice: Grid, rows: str, columns: str, stencil: Stencil, compliances: dict[str, float]
) -> GridOperator:
    """Displacements by tractions at the same place, linear between the centres of elements;
    compliances by component.
    """
    ny, nx = lattice.shape
    table = np.zeros((len(rows), len(columns), 2 * ny - 1, 2 * nx - 1))
    for ahead, weight in stencil:
        whole, part = divmod(round(ahead / lattice.sides[0], 9), 1.0)
        for column, share in ((int(whole), 1 - part), (int(whole) + 1, part)):
            if share == 0 or abs(column) >= nx:
                continue
            for name, compliance in compliances.items():
                if name in rows and name in columns:
                    place = rows.index(name), columns.index(name), ny - 1, nx - 1 - column
                    table[place] += weight * share * compliance
    return GridOperator(lattice.shape, table)
