"""Products with influence numbers on a box of equal elements, and their
approximate inverse, by FFT (float32).

Influence numbers are divided by a unit of the operator.

The preconditioner inverts the kernel on a periodic box. A circulant would be
exact for a contact that repeats itself; a Parzen window takes the kernel to
zero at the ends of the box, which keeps the symbol positive.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from varcontact.elasticity.fft_products import fields_of, repeated, spectrum_of, wrapped
from varcontact.elasticity.operators import GridOperator, RestrictedOperator
from varcontact.system.process import lazy_property

Product = Callable[[np.ndarray], np.ndarray]
"""M times tractions (c, ny, nx), both float32."""

KERNELS = 4
"""Kernels that an operator keeps: those of the last contacts on its grid."""
WIDER = 1.125
"""Width of the periodic box of the preconditioner, divided by that of the contact."""
CAUSAL = 0.03
"""Value to which a weight along x falls over one period, in rolling, where particles carry
displacements along."""
STICK_SHIFT = 0.05
"""Number added to the symbol in the stick area."""
SKEW = 0.3
"""Skewness above which a kernel is one of rolling."""


def fast_box(rows: int, columns: int) -> tuple[int, int]:
    """The next lengths for which transforms are fast."""
    from scipy.fft import next_fast_len

    return next_fast_len(rows), next_fast_len(columns, real=True)


def symmetric_product(symbol: np.ndarray, transform: np.ndarray) -> np.ndarray:
    """Product of a symmetric symbol (xx, xy, yy; or one) with the transform of two components (or
    of one).
    """
    if len(symbol) == 1:
        return symbol * transform
    xx, xy, yy = symbol
    product = np.empty_like(transform)
    other = xy * transform[1]
    np.multiply(xx, transform[0], out=product[0])
    product[0] += other
    np.multiply(xy, transform[0], out=product[1])
    np.multiply(yy, transform[1], out=other)
    product[1] += other
    return product


class Kernel:
    """Influence numbers by offset, float32 (m, 2 ny - 1, 2 nx - 1): m = 3 for xx, xy and yy, 1 for
    one component.

    `shape`: (ny, nx) of the box; `period`: axes along which numbers repeat, with the box as period.
    """

    def __init__(self, numbers: np.ndarray, period: tuple[bool, bool] = (False, False)) -> None:
        self.numbers = numbers
        self.period = period
        self.shape = (numbers.shape[1] + 1) // 2, (numbers.shape[2] + 1) // 2
        self._box = repeated(fast_box(*numbers.shape[1:]), self.shape, period)

    @lazy_property
    def row_size(self) -> float:
        """Euclidean length of a row of the matrix, the root mean square of the symbol."""
        return float(np.sqrt(np.mean(np.sum(self.numbers[[0, -1]] ** 2, axis=(1, 2), dtype=float))))

    @lazy_property
    def halved(self) -> Kernel:
        """Kernel of elements twice as large, in displacement units twice as large: means over the
        small elements.
        """
        numbers = self.numbers
        for axis in (1, 2) if self.shape[0] > 1 else (2,):
            lines = np.moveaxis(numbers, axis, -1)
            last = lines.shape[-1] // 4 * 2  # even offset of small elements
            padded = np.pad(lines, ((0, 0), (0, 0), (1, 1)), "edge")
            middle = lines.shape[-1] // 2 + 1
            before = padded[..., middle - last - 1 : middle + last : 2]
            same = padded[..., middle - last : middle + last + 1 : 2]
            after = padded[..., middle - last + 1 : middle + last + 2 : 2]
            numbers = np.moveaxis(same + (before + after) / 2, -1, axis)
        even = [size % 2 == 0 for size in self.shape]
        return Kernel(numbers / 2, (self.period[0] and even[0], self.period[1] and even[1]))

    @lazy_property
    def halved_in_rolling(self) -> Kernel:
        """Kernel of elements and a rolling step twice as large: on half-spaces its numbers are the
        first ones of this kernel.
        """
        ny, nx = self.shape
        rows = (ny + 1) // 2
        columns = (nx + 1) // 2
        return Kernel(self.numbers[:, ny - rows : ny + rows - 1, nx - columns : nx + columns - 1])

    @lazy_property
    def symbol(self) -> np.ndarray:
        """Transform of the numbers on a box of twice the size, complex64."""
        return spectrum_of(wrapped(self.numbers, self._box, self.period), self._box)

    @lazy_property
    def circulant(self) -> Circulant:
        return Circulant(self)

    def __call__(self, traction: np.ndarray) -> np.ndarray:
        """Displacements by tractions (c, ny, nx), both float32."""
        product = symmetric_product(self.symbol, spectrum_of(traction, self._box))
        return fields_of(product, self._box, self.shape)


class SoftenedKernel:
    """A kernel with numbers (c, ny, nx), float32, added to its diagonal: elements that give way to
    their own traction.

    Tractions are divided by `scale` (ny, nx) and displacements multiplied by it, so that the
    diagonal is that of the kernel: natural maps then treat a soft element as they treat the others.
    """

    def __init__(self, kernel: Product, softening: np.ndarray) -> None:
        self.kernel = kernel
        self.scale: np.ndarray = 1 / np.sqrt(1 + softening.mean(axis=0))
        self._diagonal = softening * self.scale**2

    def __call__(self, traction: np.ndarray) -> np.ndarray:
        product = self.kernel(traction * self.scale)
        product *= self.scale
        product += self._diagonal * traction
        return product


class WholeKernel:
    """Kernel of an operator that depends on the place, or whose blocks are not symmetric: products
    on its whole grid, for a box from a row and a column of it.
    """

    def __init__(self, operator: GridOperator, corner: tuple[int, int]) -> None:
        self.operator = operator
        self.corner = corner
        self._unit = np.float32(unit(operator))

    def __call__(self, traction: np.ndarray) -> np.ndarray:
        ny, nx = traction.shape[1:]
        row, column = self.corner
        box = slice(None), slice(row, row + ny), slice(column, column + nx)
        whole = np.zeros((len(traction), *self.operator.shape), np.float32)
        whole[box] = traction / self._unit
        displacement: np.ndarray = self.operator.apply(whole)[box]
        return displacement


class Circulant:
    """The windowed kernel on a periodic box, and its inverses: one for the stick area, one for the
    slip area.

    `rolling`: 1 or -1 where the bodies roll, by the direction; 0 in a shift. By how much more
    tractions act ahead of them along x than behind: 0 in a shift, nearly all in steady rolling as
    long as a step is shorter than the box. `growth`: the causal weight along x, (nx,), all ones in
    a shift. `symbol`: transform of the weighted kernel.
    """

    def __init__(self, kernel: Kernel) -> None:
        self.kernel = kernel
        ny, nx = kernel.shape
        self.rolling = _rolling(kernel.numbers[0])
        period = kernel.period
        if self.rolling != 0:
            period = False, False
        wider = fast_box(int(WIDER * ny), int(WIDER * nx))
        rows, columns = self._box = repeated(wider, kernel.shape, period)
        growth = np.exp(-self.rolling * np.log(CAUSAL) / columns * np.arange(nx))
        self.growth = growth.astype(np.float32)
        x = np.arange(-(nx - 1), nx)
        y = np.arange(-(ny - 1), ny)
        causal = np.exp(-self.rolling * np.log(CAUSAL) * x / columns)
        window = np.outer(parzen(y / rows), parzen(x / columns))
        if period[0]:
            window[:] = parzen(x / columns)
        if period[1]:
            window[:] = window[:, nx - 1 : nx]
        window *= causal
        numbers = kernel.numbers * window.astype(np.float32)
        self.symbol = spectrum_of(wrapped(numbers, self._box, period), self._box)

    @lazy_property
    def stick(self) -> np.ndarray:
        """The inverse for the stick area."""
        return self.inverse(STICK_SHIFT)

    def inverse(self, shift: float) -> np.ndarray:
        """Symbol (xx, xy, yy; or one) of the inverse of the kernel plus a number on its
        diagonal.
        """
        if len(self.symbol) == 1:
            return 1 / (self.symbol + np.float32(shift))
        xx = self.symbol[0] + np.float32(shift)
        xy = self.symbol[1]
        yy = self.symbol[2] + np.float32(shift)
        determinant = xx * yy - xy * xy
        inverse = np.array([yy, -xy, xx])
        inverse /= determinant
        return inverse

    def apply(self, inverses: np.ndarray, fields: np.ndarray) -> np.ndarray:
        """Inverses (m, k, ...) times fields (c, k, ny, nx), both weighted by `growth`."""
        product = symmetric_product(inverses, spectrum_of(fields, self._box))
        return fields_of(product, self._box, self.kernel.shape)


def _rolling(numbers: np.ndarray) -> int:
    """The direction of rolling by the skewness of influence numbers along x, (2 ny - 1, 2 nx - 1);
    0 in a shift.
    """
    nx = (numbers.shape[1] + 1) // 2
    behind = numbers[:, : nx - 1]
    ahead = numbers[:, nx:]
    total = float(np.abs(behind).sum(dtype=float) + np.abs(ahead).sum(dtype=float))
    skewness = float(ahead.sum(dtype=float) - behind.sum(dtype=float))
    if abs(skewness) < SKEW * total or total == 0:
        return 0
    return int(np.sign(skewness))


def parzen(t: np.ndarray) -> np.ndarray:
    """Parzen's window on [-1, 1]: its transform is positive."""
    t = np.abs(t)
    return np.where(t < 0.5, 1 - 6 * t**2 + 6 * t**3, 2 * np.maximum(1 - t, 0.0) ** 3)


def kernel(operator: GridOperator, shape: tuple[int, int]) -> Kernel:
    """The kernel of a box from the first offsets of an operator's table, which remembers it."""
    kept: dict[tuple[int, int], Kernel] = operator.kernels
    made = kept.pop(shape, None) or _of_table(operator, shape)
    kept[shape] = made
    # solves in other threads share it
    for oldest in list(kept)[:-KERNELS]:
        kept.pop(oldest, None)
    return made


def _of_table(operator: GridOperator, shape: tuple[int, int]) -> Kernel:
    ny, nx = shape
    rows, columns = operator.shape
    table = operator.table[:, :, rows - ny : rows + ny - 1, columns - nx : columns + nx - 1]
    blocks = [table[0, 0]] if len(table) == 1 else [table[0, 0], table[0, 1], table[1, 1]]
    period = operator.period[0] and ny == rows, operator.period[1] and nx == columns
    numbers = (np.array(blocks) / unit(operator)).astype(np.float32)
    return Kernel(numbers, period)


def product_and_plain(
    operator: RestrictedOperator, shape: tuple[int, int]
) -> tuple[Product, Kernel]:
    """The operator on a box, and its kernel there: of numbers by place the mean ones."""
    whole = operator.grid_operator
    plain = kernel(whole, shape)
    if whole.toeplitz and whole.symmetric_in_blocks:
        return plain, plain
    row, column = np.divmod(operator.elements, whole.shape[1])
    return WholeKernel(whole, (int(row.min()), int(column.min()))), plain


def unit(operator: GridOperator) -> float:
    """The influence that counts as one: that of an element on itself.

    In steps of rolling shorter than half an element the neighbours have more: half of the influence
    of the nine elements around then.
    """
    rows, columns = operator.shape
    own = operator.diagonal
    near = operator.table[:, :, max(rows - 2, 0) : rows + 1, max(columns - 2, 0) : columns + 1]
    return max(own, float(np.sqrt(np.trace(np.sum(near**2, axis=(2, 3))) / len(near))) / 2)
