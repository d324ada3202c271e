"""The bodies as a solver meets them: the influence numbers of two bodies, dimensionless, and what is true of them.

The combined modulus of rigidity of the surfaces is 1. Another kind of body is another `Medium`, and nothing else.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from varcontact.elasticity.halfspace import influence_numbers
from varcontact.elasticity.plane_strain import strip_influence_numbers
from varcontact.errors import SceneError
from varcontact.scene.bodies import Bodies, BodyPair
from varcontact.scene.grid import Grid


class Medium(Protocol):
    """Two bodies; media that are equal have equal influence numbers.

    Attributes
    ----------
    nu : float
        Combined Poisson's ratio (59) of the surfaces' material.
    K : float
        Size of the coupling of pressure and tractions, of half-spaces the constant (60); 0: independent.
    depth : float
        In line contact: the depth from which displacements count.
    even : bool
        Whether numbers are even or odd in x. All are even or odd in y.
    """

    @property
    def nu(self) -> float: ...
    @property
    def K(self) -> float: ...
    @property
    def depth(self) -> float: ...
    @property
    def even(self) -> bool: ...

    def influence(self, grid: Grid, x: np.ndarray, y: np.ndarray, components: Iterable[str]) -> dict[str, np.ndarray]:
        """Influence numbers of an element of a grid at points from its centre, which broadcast together.

        In line contact elements are strips, and y does not matter.
        """
        ...


@dataclass(frozen=True)
class HalfSpaces:
    """Two homogeneous, isotropic, elastic half-spaces (paper, section 2)."""

    nu: float
    K: float = 0.0
    depth: float = 1.0

    @property
    def even(self) -> bool:
        """As of all elastic bodies that are the same everywhere along x."""
        return True

    def influence(self, grid: Grid, x: np.ndarray, y: np.ndarray, components: Iterable[str]) -> dict[str, np.ndarray]:
        """Influence numbers in closed form."""
        dx, dy = grid.sides
        if grid.line:
            return strip_influence_numbers(x, dx, nu=self.nu, K=self.K, depth=self.depth, components=components)
        return influence_numbers(x, y, dx, dy, nu=self.nu, K=self.K, components=components)


def medium_of(bodies: Bodies | BodyPair, length: float, depth: float, coupled: bool = True) -> Medium:
    """The medium of a scene's bodies in units of a length; without their coupling unless `coupled`.

    `depth` is in units of that length already.
    """
    if isinstance(bodies, Bodies):
        return HalfSpaces(bodies.combined_nu, bodies.K if coupled else 0.0, depth)
    raise SceneError("bodies", bodies, "half-spaces, Bodies(G, nu)")
