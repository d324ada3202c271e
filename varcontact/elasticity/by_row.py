"""Influence numbers of bodies that are uniform along x, such as rails: between all rows of
elements, by offset along x.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np

from varcontact.elasticity.operators import SAME_NUMBERS, GridOperator
from varcontact.system.process import lazy_property


@dataclass(frozen=True, eq=False)
class RowOperator(GridOperator):
    """An operator by its numbers (rows, columns, ny, ny, 2 nx - 1): components, row of the field
    element and of the loaded one, offset along x. Products are transforms along x, and sums over
    rows.

    Its `table` has the means by offset of rows, which is what preconditioners need.
    """

    toeplitz: ClassVar[bool] = False
    numbers: np.ndarray

    @classmethod
    def of(cls, numbers: np.ndarray) -> RowOperator:
        """The operator of its numbers."""
        rows, columns, ny, _, width = numbers.shape
        table = np.empty((rows, columns, 2 * ny - 1, width))
        for offset in range(1 - ny, ny):
            # a diagonal has field rows that many above the loaded ones
            diagonal = np.diagonal(numbers, -offset, axis1=2, axis2=3)
            table[:, :, offset + ny - 1] = diagonal.mean(axis=-1)
        return cls((ny, (width + 1) // 2), table, numbers)

    def dense(self, elements: np.ndarray, loaded: np.ndarray | None = None) -> np.ndarray:
        """The matrix from tractions on `loaded` to displacements in `elements`, see
        `GridOperator.dense`.
        """
        if loaded is None:
            loaded = elements
        nx = self.shape[1]
        iy, ix = (each[:, None] for each in np.divmod(elements, nx))
        jy, jx = np.divmod(loaded, nx)
        rows, columns = self.table.shape[:2]
        blocks = self.numbers[:, :, iy, jy, ix - jx + nx - 1]
        return blocks.swapaxes(1, 2).reshape(rows * elements.size, columns * loaded.size)

    def _product(self, tractions: np.ndarray) -> np.ndarray:
        from scipy import fft

        nx = self.shape[1]
        transform = self._transform
        if tractions.dtype == np.float32:
            transform = self._single_transform
        spectrum = fft.rfft(tractions, self._length, axis=-1)
        # a matrix between components and rows for each wave number
        loads = spectrum.reshape(-1, spectrum.shape[-1]).T[:, :, None]
        product = (transform @ loads)[:, :, 0].T
        fields = fft.irfft(product.reshape(-1, *spectrum.shape[1:]), self._length, axis=-1)
        return np.asarray(fields[..., :nx])

    @property
    def _length(self) -> int:
        """Length of transforms along x, padded."""
        from scipy.fft import next_fast_len

        return int(next_fast_len(2 * self.shape[1] - 1, real=True))

    @lazy_property
    def _transform(self) -> np.ndarray:
        """Transforms along x (wave numbers, components x rows, components x rows)."""
        from scipy import fft

        rows, columns, ny, _, width = self.numbers.shape
        nx = (width + 1) // 2
        periodic = np.zeros((*self.numbers.shape[:-1], self._length))
        periodic[..., :nx] = self.numbers[..., nx - 1 :]
        periodic[..., self._length - nx + 1 :] += self.numbers[..., : nx - 1]
        by_wave = np.moveaxis(fft.rfft(periodic, axis=-1), -1, 0).swapaxes(2, 3)
        return np.ascontiguousarray(by_wave.reshape(-1, rows * ny, columns * ny))

    @lazy_property
    def _single_transform(self) -> np.ndarray:
        return self._transform.astype(np.complex64)

    def _part(self, rows: tuple[int, ...], columns: tuple[int, ...]) -> RowOperator:
        part = np.ix_(rows, columns)
        return replace(self, table=self.table[part], numbers=self.numbers[part])

    def couples(self, row: int, column: int) -> bool:
        return bool(self.numbers[row, column].any())

    @property
    def smallest(self) -> float:
        return float(self.numbers.min())

    @property
    def largest(self) -> float:
        return float(self.numbers.max())

    @property
    def norm(self) -> float:
        """The largest norm of the matrices by wave number on the padded length, an upper bound."""
        return float(np.linalg.norm(self._transform, axis=(1, 2)).max())

    def has_mirror(self, rows: slice) -> bool:
        """True where numbers between some `rows` are those of the rows mirrored in their middle."""
        part = self.numbers[:, :, rows, rows]
        signs = np.ones(part.shape[:2])
        if len(signs) > 1:
            signs[0, 1] = signs[1, 0] = -1.0
        image = part[:, :, ::-1, ::-1] * signs[..., None, None, None]
        return bool(np.abs(image - part).max() <= SAME_NUMBERS * np.abs(self.numbers).max())

    @classmethod
    def in_blocks(cls, blocks: list[list[GridOperator]]) -> RowOperator:
        by_row = [[each for each in row if isinstance(each, RowOperator)] for row in blocks]
        rows = [np.concatenate([each.numbers for each in row], axis=1) for row in by_row]
        return cls.of(np.concatenate(rows))

    @property
    def transposed(self) -> RowOperator:
        return RowOperator.of(self.numbers[..., ::-1].swapaxes(0, 1).swapaxes(2, 3))

    def symmetric_part(self, sign: float = 1.0) -> RowOperator:
        return RowOperator.of((self.numbers + sign * self.transposed.numbers) / 2)
