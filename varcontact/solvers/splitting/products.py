"""Products with M and its transpose on a box, and the circulant that approximates their inverses.

Fields are (c, ny, nx), in double or in single precision; displacements are in units of the
influence of an element on itself.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np

from varcontact.elasticity.fft_products import by_symbol, spectrum_of, wrapped
from varcontact.elasticity.operators import GridOperator, RestrictedOperator
from varcontact.solvers.newton.hierarchy import Box
from varcontact.solvers.newton.kernel import WIDER, Kernel, fast_box, parzen, unit
from varcontact.system.process import lazy_property

INFLUENCES_KEPT = 2
"""Boxes whose influence numbers an operator keeps, for the next pass or step."""
CIRCULANTS_KEPT = 4
"""Circulants that influence numbers keep."""


Gamma = float | tuple[float, ...]
"""A step gamma, of all components or of each."""


class Applied(Protocol):
    """M on a box of elements."""

    def apply(self, field: np.ndarray) -> np.ndarray:
        """M times a field."""


class Product(Applied, Protocol):
    """M and its transpose."""

    def transposed(self, field: np.ndarray) -> np.ndarray:
        """The transpose of M times a field."""


@dataclass(frozen=True, eq=False)
class Influence:
    """Influence numbers by offset, (c, c, 2 ny - 1, 2 nx - 1)."""

    table: np.ndarray

    @classmethod
    def on_box(cls, operator: GridOperator, shape: tuple[int, int]) -> Influence:
        """The first offsets of an operator's table; the last few are remembered."""
        kept: dict[tuple[int, int], Influence] = operator.__dict__.setdefault("_influences", {})
        if shape not in kept:
            ny, nx = shape
            rows, columns = operator.shape
            table = operator.table[:, :, rows - ny : rows + ny - 1, columns - nx : columns + nx - 1]
            kept[shape] = cls(table / unit(operator))
            for oldest in list(kept)[:-INFLUENCES_KEPT]:
                del kept[oldest]
        return kept[shape]

    @classmethod
    def of_kernel(cls, kernel: Kernel) -> Influence:
        """The numbers of a coarse grid."""
        numbers = kernel.numbers.astype(float)
        if len(numbers) == 1:
            return cls(numbers[None])
        xx, xy, yy = numbers
        return cls(np.array([[xx, xy], [xy, yy]]))

    @lazy_property
    def shape(self) -> tuple[int, int]:
        rows, columns = self.table.shape[2:]
        return (rows + 1) // 2, (columns + 1) // 2

    @lazy_property
    def _box(self) -> tuple[int, int]:
        rows, columns = self.table.shape[2:]
        return fast_box(rows, columns)

    @lazy_property
    def _symbol(self) -> np.ndarray:
        return spectrum_of(wrapped(self.table, self._box), self._box)

    def circulant(self, gamma: Gamma) -> Circulant:
        """The circulant for a step gamma; the last few are remembered."""
        kept: dict[Gamma, Circulant] = self.__dict__.setdefault("_circulants", {})
        if gamma not in kept:
            kept[gamma] = Circulant(self.table, gamma)
            for oldest in list(kept)[:-CIRCULANTS_KEPT]:
                del kept[oldest]
        return kept[gamma]

    @lazy_property
    def _single_symbol(self) -> np.ndarray:
        return self._symbol.astype(np.complex64)

    def apply(self, field: np.ndarray) -> np.ndarray:
        symbol = self._single_symbol if field.dtype == np.float32 else self._symbol
        return by_symbol(symbol, field, self._box, self.shape)

    def transposed(self, field: np.ndarray) -> np.ndarray:
        symbol = self._single_symbol if field.dtype == np.float32 else self._symbol
        adjoint = np.conj(symbol.swapaxes(0, 1))
        return by_symbol(adjoint, field, self._box, self.shape)


@dataclass(frozen=True, eq=False)
class Softened:
    """M with numbers (c, ny, nx) added to its diagonal; tractions are divided by `scale` (ny, nx)
    and displacements multiplied by it.
    """

    product: Product
    scale: np.ndarray
    diagonal: np.ndarray

    def apply(self, field: np.ndarray) -> np.ndarray:
        return self._softened(field, self.product.apply(self._scaled(field)))

    def transposed(self, field: np.ndarray) -> np.ndarray:
        return self._softened(field, self.product.transposed(self._scaled(field)))

    def _scaled(self, field: np.ndarray) -> np.ndarray:
        return field * self.scale.astype(field.dtype)

    def _softened(self, field: np.ndarray, image: np.ndarray) -> np.ndarray:
        softened = image * self.scale + self.diagonal * field
        return softened.astype(field.dtype)


@dataclass(frozen=True, eq=False)
class OfOperator:
    """M by the operator of a whole grid: of a surface whose curvature varies, or of one half of a
    symmetric contact.
    """

    operator: RestrictedOperator
    box: Box
    unit: float

    @lazy_property
    def _transposed(self) -> RestrictedOperator:
        return replace(self.operator, grid_operator=self.operator.grid_operator.transposed)

    def apply(self, field: np.ndarray) -> np.ndarray:
        return self._by(self.operator, field)

    def transposed(self, field: np.ndarray) -> np.ndarray:
        return self._by(self._transposed, field)

    def _by(self, operator: RestrictedOperator, field: np.ndarray) -> np.ndarray:
        image = operator.apply(self.box.values(field)) / self.unit
        return self.box.field(image).astype(field.dtype)


class Circulant:
    """The inverse of ``I + gamma M`` on a periodic box, and times its adjoint the metric, in single
    precision.

    The windowed kernel repeats itself on a box that is a little wider than the contact. Restricted
    to the elements, ``C C'`` of an invertible C is positive definite, however far C is from the
    inverse.
    """

    def __init__(self, table: np.ndarray, gamma: Gamma) -> None:
        ny = (table.shape[2] + 1) // 2
        nx = (table.shape[3] + 1) // 2
        self._box = fast_box(int(np.ceil(WIDER * ny)), int(np.ceil(WIDER * nx)))
        rows, columns = self._box
        along_y = parzen(np.arange(1 - ny, ny) / rows)
        along_x = parzen(np.arange(1 - nx, nx) / columns)
        windowed = table * (along_y[:, None] * along_x)
        symbol = spectrum_of(wrapped(windowed, self._box), self._box)
        matrices = np.moveaxis(symbol, (0, 1), (-2, -1))
        scaled = np.reshape(gamma, (-1, 1)) * matrices
        self._inverses = np.linalg.inv(np.eye(len(symbol)) + scaled).astype(np.complex64)
        self._inverse = _by_components(self._inverses)

    @lazy_property
    def _metric(self) -> np.ndarray:
        return _by_components(self._inverses @ np.conj(self._inverses.swapaxes(-1, -2)))

    def inverse(self, field: np.ndarray, contact: np.ndarray) -> np.ndarray:
        """Nearly ``(I + gamma M)^-1`` times a field, on the elements in contact."""
        return self._by(self._inverse, field, contact)

    def metric(self, field: np.ndarray, contact: np.ndarray) -> np.ndarray:
        """``H^-1`` times a field, on the elements in contact."""
        return self._by(self._metric, field, contact)

    def _by(self, symbol: np.ndarray, field: np.ndarray, contact: np.ndarray) -> np.ndarray:
        image = by_symbol(symbol, (field * contact).astype(np.float32), self._box, field.shape[1:])
        return (image * contact).astype(float)


def _by_components(matrices: np.ndarray) -> np.ndarray:
    """Matrices by wave number (..., c, c) as a symbol (c, c, ...)."""
    return np.ascontiguousarray(np.moveaxis(matrices, (-2, -1), (0, 1)))
