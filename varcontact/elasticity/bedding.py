"""Winkler beddings: displacements at a point by the traction there alone (paper, 1.2 and 3.2)."""

from __future__ import annotations

from dataclasses import dataclass

from varcontact.elasticity.operators import GridOperator
from varcontact.elasticity.shear_layer import springs
from varcontact.scene.grid import Grid
from varcontact.transports import HERE, Stencil


@dataclass(frozen=True)
class Bedding:
    """A medium of springs, with dimensionless compliances along normal and surface."""

    normal: float
    tangential: float

    @property
    def K(self) -> float:
        """Zero: pressures cause no tangential displacements."""
        return 0.0

    @property
    def even(self) -> bool:
        return True

    @property
    def reciprocal(self) -> bool:
        return True

    @property
    def at_once(self) -> Bedding:
        return self

    def at_end(self, time: float) -> Bedding:
        """Springs do not relax."""
        return self

    def operator(
        self, lattice: Grid, rows: str, columns: str, stencil: Stencil = HERE
    ) -> GridOperator:
        """Displacements along `rows` by tractions along `columns`, combined over a stencil."""
        compliances = {"x": self.tangential, "y": self.tangential, "z": self.normal}
        return springs(lattice, rows, columns, stencil, compliances)
