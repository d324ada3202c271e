"""Products with influence numbers on a box of equal elements, in single precision, by FFT.

All is dimensionless: influence numbers count in a unit of the operator, so that the numbers of a grid twice as coarse
are the first of the same table. Those of strips are so but for a constant, as a logarithm grows by one.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from varcontact.elasticity.operators import GridOperator

KERNELS = 16
"""Kernels that an operator remembers: those of the levels of two or three contacts."""


@dataclass(frozen=True, eq=False)
class Kernel:
    """Influence numbers on a box of elements, by their offset.

    Attributes
    ----------
    numbers : float32 ndarray, shape (m, 2 ny - 1, 2 nx - 1)
        m = 3: xx, xy and yy; m = 1: of the one component that there is.
    """

    numbers: np.ndarray

    @cached_property
    def shape(self) -> tuple[int, int]:
        """(ny, nx), the shape of the box."""
        return (self.numbers.shape[1] + 1) // 2, (self.numbers.shape[2] + 1) // 2

    @cached_property
    def row_size(self) -> float:
        """Euclidean length of a row of the matrix, the root mean square of the symbol."""
        return float(np.sqrt(np.mean(np.sum(self.numbers[[0, -1]] ** 2, axis=(1, 2), dtype=float))))

    @cached_property
    def skewness(self) -> float:
        """By how much more tractions act on what is ahead of them along x than on what is behind: 0 in a shift.

        Between -1 and 1; of steady rolling near 1, as long as a step is shorter than the box.
        """
        middle = self.shape[1]
        behind, ahead = self.numbers[0, :, : middle - 1], self.numbers[0, :, middle:]
        total = float(np.abs(behind).sum(dtype=float) + np.abs(ahead).sum(dtype=float))
        return float(ahead.sum(dtype=float) - behind.sum(dtype=float)) / total if total > 0 else 0.0

    @cached_property
    def symbol(self) -> np.ndarray:
        """Transform of the numbers on a box of twice the size, complex64."""
        return wrapped_transform(self.numbers, self._lengths)

    @cached_property
    def _lengths(self) -> tuple[int, int]:
        from scipy.fft import next_fast_len

        ny, nx = self.shape
        return next_fast_len(2 * ny - 1), next_fast_len(2 * nx - 1, real=True)

    def __call__(self, traction: np.ndarray) -> np.ndarray:
        """Displacements by tractions (c, ny, nx), both float32.

        Transformed are only the rows that have tractions, and back only those that are asked for.
        """
        from scipy import fft

        (ny, nx), (rows, columns) = self.shape, self._lengths
        spectrum = fft.fft(fft.rfft(traction, columns, axis=-1), rows, axis=-2, overwrite_x=True)
        image = fft.ifft(weighted(self.symbol, spectrum), axis=-2, overwrite_x=True)[:, :ny]
        return fft.irfft(image, columns, axis=-1)[..., :nx]


@dataclass(frozen=True, eq=False)
class SoftenedKernel:
    """A kernel whose elements give way to their own traction by more than it has, each by its own number.

    Tractions count by `scale` and displacements are multiplied by it, so that the diagonal is that of the kernel:
    natural maps then take an element that is soft for what the others are.

    Attributes
    ----------
    kernel : Kernel
    softening : float32 ndarray, shape (c, ny, nx)
        What is added to the diagonal, in units of the kernel.
    """

    kernel: Kernel
    softening: np.ndarray

    @cached_property
    def scale(self) -> np.ndarray:
        """Traction that counts as one, float32, (ny, nx): the root of the kernel's diagonal by the whole one."""
        scale: np.ndarray = 1 / np.sqrt(1 + self.softening.mean(axis=0))
        return scale

    @cached_property
    def _own(self) -> np.ndarray:
        own: np.ndarray = self.softening * self.scale**2
        return own

    @property
    def row_size(self) -> float:
        """That of the kernel."""
        return self.kernel.row_size

    def __call__(self, traction: np.ndarray) -> np.ndarray:
        """Displacements by tractions (c, ny, nx), both float32."""
        product: np.ndarray = self.kernel(traction * self.scale)
        product *= self.scale
        product += self._own * traction
        return product


def softened(kernel: Kernel, softening: np.ndarray | None) -> Kernel | SoftenedKernel:
    """A kernel with what is added to its diagonal, if anything is.

    Parameters
    ----------
    kernel : Kernel
    softening : ndarray, shape (c, ny, nx), or None
        In units of the kernel.
    """
    return kernel if softening is None else SoftenedKernel(kernel, softening.astype(np.float32))


def weighted(symbol: np.ndarray, spectrum: np.ndarray) -> np.ndarray:
    """Product of a symmetric symbol (xx, xy, yy; or one) with the spectrum of two components (or of one).

    Parameters
    ----------
    symbol : ndarray, shape (3, ...) or (1, ...)
        Of the operator, as the transform of its numbers.
    spectrum : ndarray, shape (c, ...)
        Transform of a field; c = 2 with a symbol of three parts, else 1.

    Returns
    -------
    ndarray, shape (c, ...)
    """
    if len(symbol) == 1:
        return symbol * spectrum
    xx, xy, yy = symbol
    product = np.empty_like(spectrum)
    other = xy * spectrum[1]
    np.multiply(xx, spectrum[0], out=product[0])
    product[0] += other
    np.multiply(xy, spectrum[0], out=product[1])
    np.multiply(yy, spectrum[1], out=other)
    product[1] += other
    return product


def wrapped_transform(numbers: np.ndarray, box: tuple[int, int]) -> np.ndarray:
    """Transform of numbers by offset on a periodic box, those that fall on each other added up.

    Parameters
    ----------
    numbers : ndarray, shape (m, 2 ny - 1, 2 nx - 1)
    box : tuple of int
        Rows and columns of the periodic box.

    Returns
    -------
    complex ndarray
        Shape (m, rows, columns // 2 + 1).
    """
    from scipy import fft

    ny, nx = (numbers.shape[1] + 1) // 2, (numbers.shape[2] + 1) // 2
    wrapped = np.zeros((len(numbers), *box), dtype=numbers.dtype)
    for rows, to_rows in ((slice(0, ny - 1), slice(box[0] - ny + 1, None)), (slice(ny - 1, None), slice(0, ny))):
        for columns, to_columns in (
            (slice(0, nx - 1), slice(box[1] - nx + 1, None)),
            (slice(nx - 1, None), slice(0, nx)),
        ):
            wrapped[:, to_rows, to_columns] += numbers[:, rows, columns]
    return np.asarray(fft.fft(fft.rfft(wrapped, axis=-1), axis=-2, overwrite_x=True))


def kernel(operator: GridOperator, shape: tuple[int, int], halvings: int = 0) -> Kernel:
    """The kernel of a box, from the first offsets of an operator's table; remembered by the operator.

    Parameters
    ----------
    operator : GridOperator
    shape : tuple of int
        (ny, nx) of the box; no larger than the operator's grid.
    halvings : int
        How often the operator's elements are doubled in size on the box.

    Returns
    -------
    Kernel
        In the operator's `unit`, single precision.
    """
    kept: dict[tuple[int, int, int], Kernel] = operator.__dict__.setdefault("_kernels", {})
    key = *shape, halvings
    if key not in kept:
        (ny, nx), (rows, columns) = shape, operator.shape
        table = operator.table[:, :, rows - ny : rows + ny - 1, columns - nx : columns + nx - 1]
        if halvings and rows == 1:
            table = table - halvings * _fall(operator.table)
        blocks = [table[0, 0]] if len(table) == 1 else [table[0, 0], table[0, 1], table[1, 1]]
        kept[key] = Kernel((np.array(blocks) / unit(operator)).astype(np.float32))
        for oldest in list(kept)[:-KERNELS]:
            del kept[oldest]
    return kept[key]


def _fall(table: np.ndarray) -> np.ndarray:
    """By how much the even part of a line contact's influence falls from a distance to twice of it, (c, c, 1, 1).

    A logarithm falls by as much from any distance; differences of it, of steady rolling, have no even part far away.
    """
    middle = table.shape[-1] // 2
    far, half = (table[..., middle - at] + table[..., middle + at] for at in (middle // 2 * 2, middle // 2))
    return ((half - far) / 2)[..., None]


def unit(operator: GridOperator) -> float:
    """The influence that counts as one: that of an element on itself.

    In steps of rolling shorter than half an element that is less than what the neighbours have: half of the influence
    of the nine elements around then.

    Parameters
    ----------
    operator : GridOperator

    Returns
    -------
    float
        In the unit of the operator's numbers: within solvers dimensionless.
    """
    rows, columns = operator.shape
    own = operator.on(np.arange(1)).diagonal
    near = operator.table[:, :, max(rows - 2, 0) : rows + 1, max(columns - 2, 0) : columns + 1]
    around = float(np.sqrt(np.trace(np.sum(near**2, axis=(2, 3))) / len(near)))
    return max(own, around / 2)
