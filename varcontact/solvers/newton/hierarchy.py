"""Boxes of elements, and transfer between coarse and fine grids. Fields are (..., ny, nx), in any
unit.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from varcontact.discrete.contact_grid import on_parts
from varcontact.elasticity.operators import RestrictedOperator

LEAST_SIDE = 12
"""Least number of elements along the smaller side of the coarsest grid, or along a line contact; it
has less than twice as many."""


@dataclass(frozen=True, eq=False)
class Box:
    """The rectangle around some elements of a grid, with their flat indices in it (n,)."""

    shape: tuple[int, int]
    places: np.ndarray

    @classmethod
    def around(cls, operator: RestrictedOperator) -> Box:
        row, column = np.divmod(operator.elements, operator.grid_operator.shape[1])
        row = row - row.min()
        column = column - column.min()
        shape = int(row.max()) + 1, int(column.max()) + 1
        return cls(shape, row * shape[1] + column)

    def field(self, values: np.ndarray) -> np.ndarray:
        """Values of the elements (..., n) as a field, zero elsewhere."""
        field = np.zeros((*values.shape[:-1], self.shape[0] * self.shape[1]), dtype=values.dtype)
        field[..., self.places] = values
        return field.reshape(*values.shape[:-1], *self.shape)

    def values(self, field: np.ndarray) -> np.ndarray:
        return field.reshape(*field.shape[:-2], -1)[..., self.places]


def halved(field: np.ndarray) -> np.ndarray:
    """Means over two by two elements, or over two strips of a line contact; zero beyond the
    edge.
    """
    ny, nx = field.shape[-2:]
    line = ny == 1
    beyond_y = 0 if line else ny % 2
    field = np.pad(field, [(0, 0)] * (field.ndim - 2) + [(0, beyond_y), (0, nx % 2)])
    rows = field if line else (field[..., ::2, :] + field[..., 1::2, :]) / 2
    return (rows[..., ::2] + rows[..., 1::2]) / 2


def halved_mean(field: np.ndarray, contact: np.ndarray) -> np.ndarray:
    """Means over those of the elements that are in contact; zero where none is."""
    return halved(np.where(contact, field, 0.0)) / np.maximum(halved(contact.astype(float)), 0.25)


def doubled(field: np.ndarray, contact: np.ndarray, shape: tuple[int, int]) -> np.ndarray:
    """A field on a grid (of that shape) of half the element size: bilinear, between elements in
    contact only.
    """
    values = on_parts(field * contact, (2, 2))
    weights = on_parts(contact.astype(float), (2, 2))
    fine = np.where(weights > 0, values / np.where(weights > 0, weights, 1.0), 0.0)
    return fine[..., : shape[0], : shape[1]]
