"""Influence numbers on a surface that is curved along x and y: a dense matrix, by element."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np

from varcontact.elasticity.operators import GridOperator
from varcontact.errors import SceneError
from varcontact.scene.frames import half_turns

ELEMENTS_MAX = 2500
"""Largest number of elements on a surface curved along both axes: its matrix of all components
takes 450 MB."""

LOADED_AT_ONCE = 64
"""Loaded elements whose numbers are rotated at a time."""


def turned_operator(
    rows: str, columns: str, frames: np.ndarray, flat: GridOperator
) -> ElementOperator:
    """The operator between components in the frames (3, 3, ny, nx) of elements, from the `flat` one
    between all components.

    ``Q A Q`` for each pair of elements, Q half of the rotation between their frames.
    """
    size = flat.shape[0] * flat.shape[1]
    if size > ELEMENTS_MAX:
        allowed = (
            f"at most {ELEMENTS_MAX} elements where the surface is curved along x and y, "
            "which takes a dense matrix; leave out surface.inclination or inclination_x, "
            "or give a coarser grid"
        )
        raise SceneError("grid", f"{size} elements", allowed)
    every = np.arange(size)
    axes = frames.reshape(3, 3, size)
    taken = ["xyz".index(name) for name in rows]
    given = ["xyz".index(name) for name in columns]
    matrix = np.empty((len(rows), size, len(columns), size))
    for first in range(0, size, LOADED_AT_ONCE):
        loaded = every[first : first + LOADED_AT_ONCE]
        half = half_turns(axes, axes[:, :, loaded])
        numbers = flat.dense(every, loaded).reshape(3, size, 3, loaded.size)
        left = np.einsum("iknm,knlm->inlm", half[taken], numbers)
        matrix[..., loaded] = np.einsum("inlm,ljnm->injm", left, half[:, given])
    table = flat.table[np.ix_(taken, given)]
    return ElementOperator(flat.shape, table, matrix)


@dataclass(frozen=True, eq=False)
class ElementOperator(GridOperator):
    """An operator by its numbers (rows, n, columns, n) between all elements.

    Its `table` is that of the flat surface: exact for elements on themselves, and what
    preconditioners need.
    """

    toeplitz: ClassVar[bool] = False
    numbers: np.ndarray

    def dense(self, elements: np.ndarray, loaded: np.ndarray | None = None) -> np.ndarray:
        """The matrix from tractions on `loaded` to displacements in `elements`, see
        `GridOperator.dense`.
        """
        if loaded is None:
            loaded = elements
        rows, _, columns, _ = self.numbers.shape
        part = self.numbers[:, elements][..., loaded]
        return part.reshape(rows * elements.size, columns * loaded.size)

    def _product(self, tractions: np.ndarray) -> np.ndarray:
        numbers = self.numbers.astype(tractions.dtype, copy=False)
        product = np.tensordot(numbers, tractions.reshape(len(tractions), -1), 2)
        return product.reshape(-1, *self.shape)

    def _part(self, rows: tuple[int, ...], columns: tuple[int, ...]) -> ElementOperator:
        table = self.table[np.ix_(rows, columns)]
        numbers = self.numbers[list(rows)][:, :, list(columns)]
        return replace(self, table=table, numbers=numbers)

    def couples(self, row: int, column: int) -> bool:
        return bool(self.numbers[row, :, column].any())

    @property
    def smallest(self) -> float:
        return float(self.numbers.min())

    @property
    def largest(self) -> float:
        return float(self.numbers.max())

    @property
    def norm(self) -> float:
        """The Frobenius norm, which is an upper bound."""
        return float(np.linalg.norm(self.numbers))

    def has_mirror(self, rows: slice) -> bool:
        return False

    @classmethod
    def in_blocks(cls, blocks: list[list[GridOperator]]) -> ElementOperator:
        flat = GridOperator.in_blocks(blocks)
        dense = [[each for each in row if isinstance(each, ElementOperator)] for row in blocks]
        rows = [np.concatenate([each.numbers for each in row], axis=2) for row in dense]
        return ElementOperator(flat.shape, flat.table, np.concatenate(rows))

    @property
    def transposed(self) -> ElementOperator:
        numbers = self.numbers.transpose(2, 3, 0, 1)
        return ElementOperator(self.shape, super().transposed.table, numbers)

    def symmetric_part(self, sign: float = 1.0) -> ElementOperator:
        table = super().symmetric_part(sign).table
        numbers = (self.numbers + sign * self.transposed.numbers) / 2
        return ElementOperator(self.shape, table, numbers)
