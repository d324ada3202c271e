"""Influence numbers on a grid as an operator: products by FFT, where elements are few by the matrix; dense blocks."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from varcontact.elasticity.halfspace import influence_numbers
from varcontact.elasticity.plane_strain import strip_influence_numbers
from varcontact.scene.grid import Grid
from varcontact.system.threads import one_blas_thread

REMEMBERED = 2
"""Number of restricted operators that an operator keeps: each may have a dense matrix and its factor."""

FEW = 160
"""Elements of a grid up to which a product with its whole matrix, assembled once, is faster than one by FFT."""

ROWS_AT_ONCE = 64
"""Rows of elements of a dense matrix that are assembled in one go."""


@dataclass(frozen=True, eq=False)
class GridOperator:
    """A block-Toeplitz operator from tractions to displacements on a grid.

    Attributes
    ----------
    shape : (ny, nx)
        Of the grid.
    table : ndarray, shape (rows, columns, 2 ny - 1, 2 nx - 1)
        Influence number of each pair of components by the offset (field element minus loaded element),
        from ``-(n - 1)`` to ``n - 1``.
    """

    shape: tuple[int, int]
    table: np.ndarray

    def dense(self, elements: np.ndarray, loaded: np.ndarray | None = None) -> np.ndarray:
        """The matrix from tractions on `loaded` to displacements in `elements`.

        Parameters
        ----------
        elements, loaded : int arrays
            Flat indices of elements (``iy * nx + ix``); `loaded` is `elements` if not given.

        Returns
        -------
        ndarray, shape (rows * n, columns * m)
            Component by component: all x first, then all y.
        """
        ny, nx = self.shape
        loaded = elements if loaded is None else loaded
        (iy, ix), (jy, jx) = np.divmod(elements, nx), np.divmod(loaded, nx)
        place, back = iy * (2 * nx - 1) + ix, jy * (2 * nx - 1) + jx - (ny - 1) * (2 * nx - 1) - nx + 1
        rows, columns = self.table.shape[:2]
        n, m = elements.size, loaded.size
        tables = self.table.reshape(rows, columns, -1)
        matrix = np.empty((rows, n, columns, m))
        for first in range(0, n, ROWS_AT_ONCE):  # their offsets take as much memory as a block of the matrix
            part = slice(first, first + ROWS_AT_ONCE)
            offset = place[part, None] - back
            for i in range(rows):
                for j in range(columns):
                    matrix[i, part, j] = tables[i, j].take(offset)
        return matrix.reshape(rows * n, columns * m)

    @one_blas_thread()
    def apply(self, tractions: np.ndarray) -> np.ndarray:
        """Product with tractions on the whole grid, by zero-padded FFT; with few elements by the matrix.

        Parameters
        ----------
        tractions : ndarray, shape (columns, ny, nx)

        Returns
        -------
        ndarray, shape (rows, ny, nx)
        """
        if self.whole is not None:
            return (self.whole @ tractions.ravel()).reshape(-1, *self.shape)
        from scipy import fft

        (ny, nx), (height, width) = self.shape, self._fft_shape
        spectrum = fft.fft(fft.rfft(tractions, width, axis=-1), height, axis=-2, overwrite_x=True)
        product = np.array([sum(map(np.multiply, row, spectrum)) for row in self._kernel])
        image = fft.ifft(product, axis=-2, overwrite_x=True)[:, :ny]  # along x only the rows that are asked for
        return np.ascontiguousarray(fft.irfft(image, width, axis=-1)[..., :nx])

    def between(self, rows: tuple[int, ...], columns: tuple[int, ...]) -> GridOperator:
        """The same operator between some components of traction and displacement only.

        Remembered, as it remembers its matrix.

        Parameters
        ----------
        rows, columns : tuple of int
            Components of displacement and of traction, by their places in the table.
        """
        if (len(rows), len(columns)) == self.table.shape[:2]:
            return self
        parts: dict[tuple[tuple[int, ...], tuple[int, ...]], GridOperator] = self.__dict__.setdefault("_parts", {})
        if (rows, columns) not in parts:
            parts[rows, columns] = GridOperator(self.shape, self.table[np.ix_(rows, columns)])
        return parts[rows, columns]

    def on(self, elements: np.ndarray, softening: np.ndarray | None = None) -> RestrictedOperator:
        """The same operator between tractions and displacements of some elements only.

        The last few are remembered: passes and scans over the same contact assemble and factor its matrix once.

        Parameters
        ----------
        elements : int ndarray, shape (n,)
            Places of the elements on the grid, row by row.
        softening : ndarray, shape (columns, n), optional
            Added to the diagonal.
        """
        kept: list[RestrictedOperator] = self.__dict__.setdefault("_kept", [])
        new = RestrictedOperator(self, elements, softening=softening)
        operator = next((one for one in kept if one.same(new)), new)
        if elements.size < self.shape[0] * self.shape[1]:
            kept[:] = [operator, *(one for one in kept if one is not operator)][:REMEMBERED]
        return operator

    def forget(self) -> None:
        """Let go of the restricted operators that are remembered, and of their matrices."""
        self.__dict__.pop("_kept", None)
        for part in self.__dict__.pop("_parts", {}).values():
            part.forget()

    @cached_property
    def whole(self) -> np.ndarray | None:
        """The matrix between all elements, with which products are taken; None where they are more than `FEW`."""
        size = self.shape[0] * self.shape[1]
        return self.dense(np.arange(size)) if size <= FEW else None

    @cached_property
    def _fft_shape(self) -> tuple[int, int]:
        return _fft_shape(*self.shape)

    @cached_property
    def _kernel(self) -> np.ndarray:
        """Transform of the table, the offset zero first."""
        from scipy import fft

        (ny, nx), (height, width) = self.shape, self._fft_shape
        wrapped = np.zeros((*self.table.shape[:2], height, width))
        below, left = slice(height - ny + 1, None), slice(width - nx + 1, None)
        wrapped[..., :ny, :nx] = self.table[..., ny - 1 :, nx - 1 :]
        wrapped[..., below, :nx] = self.table[..., : ny - 1, nx - 1 :]
        wrapped[..., :ny, left] = self.table[..., ny - 1 :, : nx - 1]
        wrapped[..., below, left] = self.table[..., : ny - 1, : nx - 1]
        return np.asarray(fft.fft(fft.rfft(wrapped, axis=-1), axis=-2, overwrite_x=True))


@dataclass(frozen=True, eq=False)
class RestrictedOperator:
    """A `GridOperator` between some elements only.

    Attributes
    ----------
    grid_operator : GridOperator
    elements : int ndarray, shape (n,)
        Places of the elements on the grid, row by row.
    softening : ndarray, shape (columns, n), optional
        Added to the diagonal: elements that the contact covers in part give way more.
    """

    grid_operator: GridOperator
    elements: np.ndarray
    softening: np.ndarray | None = field(default=None, kw_only=True)

    def same(self, other: RestrictedOperator) -> bool:
        """Whether another operator of the same grid is on the same elements, as soft.

        Parameters
        ----------
        other : RestrictedOperator
        """
        if not np.array_equal(self.elements, other.elements):
            return False
        if self.softening is None or other.softening is None:
            return self.softening is other.softening
        return np.array_equal(self.softening, other.softening)

    @property
    def components(self) -> int:
        """Number of traction components."""
        return int(self.grid_operator.table.shape[1])

    @cached_property
    def matrix(self) -> np.ndarray:
        """Dense matrix, (rows * n, columns * n), assembled once."""
        return self._softened(self._assembled())

    def _assembled(self) -> np.ndarray:
        own = self.grid_operator
        everywhere = self.elements.size == own.shape[0] * own.shape[1]
        return own.whole.copy() if everywhere and own.whole is not None else own.dense(self.elements)

    def _softened(self, matrix: np.ndarray) -> np.ndarray:
        if self.softening is not None:
            np.einsum("ii->i", matrix)[:] += self.softening.ravel()
        return matrix

    @cached_property
    def cholesky(self) -> tuple[np.ndarray, bool]:
        """Cholesky's factor of the matrix, symmetric and positive definite: for scipy's ``cho_solve``."""
        from scipy.linalg import cho_factor

        matrix = self._softened(self._assembled()).T  # which is the same, in the order that LAPACK has: no copy
        factor: tuple[np.ndarray, bool] = cho_factor(matrix, overwrite_a=True, check_finite=False)
        return factor

    @cached_property
    def diagonal(self) -> float:
        """Mean of an element's direct influence on itself."""
        table = self.grid_operator.table
        centre = table[:, :, table.shape[2] // 2, table.shape[3] // 2]
        return float(np.trace(centre) / centre.shape[0])

    @cached_property
    def row_size(self) -> float:
        """Root mean square of the Euclidean lengths of the matrix's rows."""
        return float(np.linalg.norm(self.matrix) / np.sqrt(len(self.matrix)))

    def apply(self, tractions: np.ndarray) -> np.ndarray:
        """Product on the grid, as that of the whole operator.

        Parameters
        ----------
        tractions : ndarray, shape (columns, n)
            In the unit of what the influence numbers are multiplied by; within solvers dimensionless.

        Returns
        -------
        ndarray, shape (rows, n)
            Displacements.
        """
        ny, nx = self.grid_operator.shape
        field = np.zeros((tractions.shape[0], ny * nx))
        field[:, self.elements] = tractions
        product = self.grid_operator.apply(field.reshape(-1, ny, nx))
        return self._with_own(product.reshape(-1, ny * nx)[:, self.elements], tractions)

    def _with_own(self, product: np.ndarray, tractions: np.ndarray) -> np.ndarray:
        return product if self.softening is None else product + self.softening * tractions


def _fft_shape(ny: int, nx: int) -> tuple[int, int]:
    """Lengths of the transforms on a grid: products wrap around below index n - 1, where they are not read."""
    from scipy.fft import next_fast_len

    return next_fast_len(2 * ny - 1, real=True), next_fast_len(2 * nx - 1, real=True)


def table_bytes(ny: int, nx: int, blocks: int) -> int:
    """Memory for a table of influence numbers and its transform.

    Parameters
    ----------
    ny, nx : int
        Of the grid.
    blocks : int
        Pairs of components.

    Returns
    -------
    int
        Bytes.
    """
    rows, columns = _fft_shape(ny, nx)
    return 8 * blocks * ((2 * ny - 1) * (2 * nx - 1) + 2 * rows * (columns // 2 + 1))


def influence_operator(
    grid: Grid,
    rows: Iterable[str],
    columns: Iterable[str],
    *,
    nu: float,
    K: float = 0.0,
    depth: float = 1.0,
    lag: float | None = None,
    difference: str = "first-order",
    offset: float = 0.0,
) -> GridOperator:
    """Influence numbers A on a grid, or their difference over a step of rolling where a `lag` is given.

    Parameters
    ----------
    grid : Grid
        Explicit lattice, of rectangles or, in line contact, of strips.
    rows, columns : iterable of "x", "y", "z"
        Displacement and traction components: only their blocks are built.
    nu, K : float
        Combined constants (59), (60); the modulus is 1.
    depth : float
        In line contact: the depth from which displacements count [length].
    lag : float, optional
        Distance `dq` [length]: C is B at the previous positions of the particles, ``x + dq`` (231).
    difference : str
        Which difference over that step, see `DIFFERENCES`.
    offset : float
        Displacements are those at ``x + offset`` [length]: of `dq`, C itself.

    Examples
    --------
    >>> grid = Grid(nx=4, ny=3, dx=1.0, dy=1.0, x0=0.0, y0=0.0)
    >>> operator = influence_operator(grid, "z", "z", nu=0.3)
    >>> field = np.arange(12.0).reshape(1, 3, 4)
    >>> dense = operator.dense(np.arange(12)) @ field.ravel()
    >>> bool(np.allclose(operator.apply(field).ravel(), dense, rtol=1e-14))
    True
    >>> influence_operator(Grid(nx=3, dx=0.1, x0=0.0), "xy", "xy", nu=0.3, depth=4.0).table.shape
    (2, 2, 1, 5)
    """
    rows, columns = list(rows), list(columns)
    names = [row + column for row in rows for column in columns]
    parts = ((0, 1.0),) if lag is None else DIFFERENCES[difference]
    tables = _tables_at(grid, [offset + ahead * (lag or 0.0) for ahead, _ in parts], names, nu, K, depth)
    weights = [weight for _, weight in parts]
    found = tables[0] if lag is None else {name: _weighted(weights, [each[name] for each in tables]) for name in names}
    table = np.array([found[name] for name in names])
    return GridOperator(grid.shape, table.reshape(len(rows), len(columns), 2 * grid.rows - 1, 2 * grid.nx - 1))


DIFFERENCES = {
    "first-order": ((0, 1.0), (1, -1.0)),
    "second-order": ((-1, 5 / 24), (0, 21 / 24), (1, -33 / 24), (2, 7 / 24)),
}
"""Differences of displacements over a step of rolling: how many steps ahead each is taken, and its weight.

The second is 5/12 of the central difference and 7/12 of the second-order one from here and ahead: docs/sampling.md.
"""


def _weighted(weights: list[float], tables: list[np.ndarray]) -> np.ndarray:
    total = weights[0] * tables[0]
    for weight, each in zip(weights[1:], tables[1:], strict=True):
        total = total + weight * each
    return total


def _tables_at(
    grid: Grid, offsets: list[float], names: list[str], nu: float, K: float, depth: float
) -> list[dict[str, np.ndarray]]:
    """Influence numbers by offset of elements, each table at points further along x: those of one place made once.

    Numbers are even or odd in x and in y. Where all points lie on the lattice of the elements, as with steps of whole
    elements, tables share nearly all of theirs.
    """
    (dx, dy), steps = grid.sides, np.arange(-(grid.nx - 1), grid.nx)
    x = np.array([(steps + round(at / dx)) * dx if _whole(at / dx) else steps * dx + at for at in offsets])
    places, index = np.unique(np.abs(x), return_inverse=True)
    if grid.line:
        strips = strip_influence_numbers(places, dx, nu=nu, K=K, depth=depth, components=names)
        half = {name: values[None] for name, values in strips.items()}
    else:
        y = np.arange(grid.rows)[:, None] * dy
        half = influence_numbers(places, y, dx, dy, nu=nu, K=K, components=names)
    full = {name: _mirrored(values, odd=name.count("y") == 1) for name, values in half.items()}
    sign = {name: np.where(x < 0, -1.0, 1.0) if name.count("x") == 1 else np.ones(x.shape) for name in names}
    index = index.reshape(x.shape)
    return [{name: full[name][:, index[k]] * sign[name][k] for name in names} for k in range(len(offsets))]


def _whole(number: float) -> bool:
    """Whether a number is whole, but for rounding."""
    return bool(abs(number - round(number)) <= 4 * np.finfo(float).eps * max(abs(number), 1.0))


def _mirrored(half: np.ndarray, odd: bool) -> np.ndarray:
    """The table for all offsets in y from those with y >= 0: exactly even or odd."""
    below = half[:0:-1]
    return np.concatenate([-below if odd else below, half])
