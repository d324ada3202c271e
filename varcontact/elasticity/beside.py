"""Displacement differences by loads beside the contact (paper, 1.8), dimensionless."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from varcontact.elasticity.held import holding_loads
from varcontact.elasticity.of_scenes import medium_of
from varcontact.elasticity.operators import Homogeneous
from varcontact.scene.bodies import Bodies, BodyPair, loaded_alone
from varcontact.scene.grid import Grid
from varcontact.scene.scene import Scene
from varcontact.transports import Stencil

COMPONENTS = "xyz"


@dataclass(frozen=True)
class Part:
    """A rectangle with uniform tractions along x and y and a pressure, on bodies of a medium."""

    medium: Homogeneous
    element: Grid
    tractions: tuple[float, float, float]

    def displacement(self, along: str, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        """Displacement differences (components, ...) at places x and y, which broadcast."""
        acting = [
            name for name, value in zip(COMPONENTS, self.tractions, strict=True) if value != 0
        ]
        if self.medium.K == 0:
            acting = [name for name in acting if (name == "z") == (along == "z")]
        names = [row + column for row in along for column in acting]
        from_x = x - self.element.x[0]
        from_y = y - self.element.y[0]
        total = np.zeros((len(along), *np.broadcast_shapes(x.shape, y.shape)))
        if not names:
            return total
        numbers = self.medium.influence(self.element, from_x, from_y, names)
        for i, row in enumerate(along):
            for column in acting:
                traction = self.tractions[COMPONENTS.index(column)]
                total[i] += traction * numbers[row + column]
        return total


@dataclass(frozen=True, eq=False)
class LoadsBeside:
    """Loads beside the contact, their parts in units of a length; displacements on a grid are
    computed once.
    """

    parts: tuple[Part, ...]
    length: float
    _on_grids: dict[Any, np.ndarray] = field(default_factory=dict, init=False, repr=False)

    def distance_at(self, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        """Added distance at places x and y, which broadcast [length]."""
        return self._displacement("z", x, y)[0]

    def distance(self, grid: Grid) -> np.ndarray:
        """Added distance at the centres of elements, (ny, nx) [length]."""
        if grid not in self._on_grids:
            self._on_grids[grid] = self.distance_at(grid.x[None, :], grid.y[:, None])
        return self._on_grids[grid]

    def shift(self, grid: Grid, stencil: Stencil) -> np.ndarray:
        """Displacement differences along the surface, combined over a stencil in units of the
        length, (2, ny, nx) [length].
        """
        key = grid, stencil
        if key not in self._on_grids:
            places = [
                (grid.x[None, :] + ahead * self.length, grid.y[:, None]) for ahead, _ in stencil
            ]
            terms = [
                weight * self._displacement("xy", *place)
                for place, (_, weight) in zip(places, stencil, strict=True)
            ]
            self._on_grids[key] = np.sum(terms, axis=0)
        return self._on_grids[key]

    def _displacement(self, along: str, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        total = np.zeros((len(along), *np.broadcast_shapes(x.shape, y.shape)))
        for part in self.parts:
            total += part.displacement(along, x / self.length, y / self.length)
        return total * self.length


def loads_beside(scene: Scene, length: float) -> LoadsBeside | None:
    """The loads beside the contact of a scene, and those that hold prescribed displacements without
    the contact, their influence numbers in units of a length; None without any.
    """
    depth = scene.reference_depth
    if depth is not None:
        depth = depth / length
    parts: list[Part] = []
    for load in (*(scene.loads or ()), *holding_loads(scene, length)):
        assert isinstance(scene.bodies, Bodies | BodyPair)
        bodies = loaded_alone(scene.bodies, load.body)
        medium = medium_of(bodies, length, depth)
        assert isinstance(medium, Homogeneous)
        grid = load.grid.scaled(length)
        values = load.parts / bodies.combined_G
        for row, column in np.argwhere(load.loaded):
            element = grid.window(column, column + 1, row, row + 1)
            acting = values[:, row, column].tolist()
            parts.append(Part(medium, element, (acting[0], acting[1], acting[2])))
    if not parts:
        return None
    return LoadsBeside(tuple(parts), length)
