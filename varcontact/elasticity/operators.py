"""Influence numbers on a grid as an operator: products by FFT, or by the matrix for few elements;
dense blocks.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field, replace
from functools import lru_cache
from typing import Any, ClassVar, Protocol, TypeVar

import numpy as np

from varcontact.elasticity.dense_matrix import matrix_of_table
from varcontact.elasticity.fft_products import (
    by_symbol,
    fft_box,
    repeated,
    spectrum_of,
    wrapped,
)
from varcontact.scene.grid import Grid
from varcontact.system.process import changed, lazy_property, one_blas_thread
from varcontact.transports import DIFFERENCES, HERE, Stencil

T = TypeVar("T")
RESTRICTED_KEPT = 2
"""Sets of elements for which an operator keeps a dense matrix and its factor."""

DENSE_ELEMENTS = 160
"""Elements of a grid up to which a product with its assembled matrix is faster than one by FFT."""

KEPT_NUMBERS = 33_000
"""Largest table (blocks times stencil points times elements) that is kept between solves, with its
transforms and preconditioners; the last 48 take at most 210 MB."""

SAME_NUMBERS = 1e-13
"""Relative difference, divided by the largest number, below which influence numbers count as the
same."""


@dataclass(eq=False)
class TableProducts:
    """Data for products with a table, computed on first use and shared by the operators of a kept
    table.
    """

    whole: np.ndarray | None = None  # the matrix between all elements
    symbol: np.ndarray | None = None
    # kernels of boxes, with their preconditioners, for solvers without a matrix
    kernels: dict[tuple[int, int], Any] = field(default_factory=dict)


@dataclass(frozen=True, eq=False)
class GridOperator:
    """A block-Toeplitz operator from tractions to displacements on a grid.

    Attributes
    ----------
    shape : (ny, nx)
        Shape of the grid.
    table : ndarray, shape (rows, columns, 2 ny - 1, 2 nx - 1)
        Influence number of each pair of components by the offset (field element
        minus loaded element), from ``-(n - 1)`` to ``n - 1``.
    period : pair of bool
        True along the axes (y, x) that numbers repeat along, with the grid as their period.
    """

    shape: tuple[int, int]
    table: np.ndarray
    period: tuple[bool, bool] = field(default=(False, False), kw_only=True)
    _products: TableProducts = field(default_factory=TableProducts, init=False, repr=False)
    # made from the numbers once: by elements and by components
    _on_elements: dict[tuple[bytes, ...], dict[str, Any]] = field(
        default_factory=dict, init=False, repr=False
    )
    _parts: dict[tuple[tuple[int, ...], tuple[int, ...]], GridOperator] = field(
        default_factory=dict, init=False, repr=False
    )
    toeplitz: ClassVar[bool] = True
    """True where the table has all influence numbers: they depend on the offset alone."""

    def dense(self, elements: np.ndarray, loaded: np.ndarray | None = None) -> np.ndarray:
        """The matrix from tractions on `loaded` to displacements in `elements`.

        Parameters
        ----------
        elements, loaded : int arrays
            Flat indices of elements (``iy * nx + ix``); `loaded` is `elements`
            if not given.

        Returns
        -------
        ndarray, shape (rows * n, columns * m)
            Component by component: all x first, then all y.
        """
        if loaded is None:
            loaded = elements
        return matrix_of_table(self.table, self.shape, elements, loaded)

    @one_blas_thread()
    def apply(self, tractions: np.ndarray) -> np.ndarray:
        """Product with tractions on the whole grid, by zero-padded FFT; with
        few elements by the matrix.

        Parameters
        ----------
        tractions : ndarray, shape (columns, ny, nx)
            In single precision (float32), where that is enough.

        Returns
        -------
        ndarray, shape (rows, ny, nx)
        """
        if tractions.dtype != np.float32 and self.whole is not None:
            return (self.whole @ tractions.ravel()).reshape(-1, *self.shape)
        return np.ascontiguousarray(self._product(tractions))

    def _product(self, tractions: np.ndarray) -> np.ndarray:
        symbol = self._single_symbol if tractions.dtype == np.float32 else self._symbol
        return by_symbol(symbol, tractions, self._box, self.shape)

    def on(self, elements: np.ndarray, softening: np.ndarray | None = None) -> RestrictedOperator:
        """Operator between tractions and displacements of some elements only; its matrices are
        shared, see `made_for`.

        Parameters
        ----------
        elements : int ndarray, shape (n,)
            Places of the elements on the grid, row by row.
        softening : ndarray, shape (columns, n), optional
            Added to the diagonal.
        """
        return RestrictedOperator(self, elements, softening=softening)

    def made_for(self, arrays: Sequence[np.ndarray | None]) -> dict[str, Any]:
        """Matrices and factors made for these elements, by name: the last few sets are kept, so
        that passes and scans over the same contact assemble and factor its matrix once.

        It refers to no operator: matrices go with the last reference to this one.

        Parameters
        ----------
        arrays : sequence of ndarray or None
            Places of the elements, and what else the matrices are made of; they are the key.
        """
        key = tuple(b"" if each is None else each.tobytes() for each in arrays)
        made = self._on_elements.pop(key, {})
        self._on_elements[key] = made
        for oldest in list(self._on_elements)[:-RESTRICTED_KEPT]:
            del self._on_elements[oldest]
        return made

    def between(self, rows: tuple[int, ...], columns: tuple[int, ...]) -> GridOperator:
        """Part of the operator: some components of displacement (`rows`) and of traction
        (`columns`).
        """
        if (len(rows), len(columns)) == self.table.shape[:2]:
            return self
        if (rows, columns) not in self._parts:
            self._parts[rows, columns] = self._part(rows, columns)
        return self._parts[rows, columns]

    def _part(self, rows: tuple[int, ...], columns: tuple[int, ...]) -> GridOperator:
        return replace(self, table=self.table[np.array(rows)[:, None], list(columns)])

    def couples(self, row: int, column: int) -> bool:
        """True where tractions along one direction (`column`) cause displacements along another
        (`row`).
        """
        return bool(self.table[row, column].any())

    @lazy_property
    def diagonal(self) -> float:
        """Mean of an element's direct influence on itself."""
        centre = self.table[:, :, self.table.shape[2] // 2, self.table.shape[3] // 2]
        return float(np.trace(centre) / centre.shape[0])

    @lazy_property
    def smallest(self) -> float:
        """The smallest influence number."""
        return float(self.table.min())

    @lazy_property
    def largest(self) -> float:
        """The largest influence number; of a symmetric positive definite operator an element's
        influence on itself.
        """
        return float(self.table.max())

    @property
    def norm(self) -> float:
        """An upper bound on the 2-norm, between any elements: of the symbol on the periodic box."""
        spectrum = spectrum_of(wrapped(self.table, self._box, self.period), self._box)
        return float(np.sqrt(np.sum(np.abs(spectrum) ** 2, axis=(0, 1)).max()))

    def has_mirror(self, rows: slice) -> bool:
        """True where numbers of some `rows` of elements are even or odd about the line in their
        middle.
        """
        return self._even_in_y

    @lazy_property
    def _even_in_y(self) -> bool:
        """True of numbers between tangential directions that are even in y, xy and yx odd."""
        signs = np.ones(self.table.shape[:2])
        if len(signs) > 1:
            signs[0, 1] = signs[1, 0] = -1.0
        image = self.table[:, :, ::-1] * signs[..., None, None]
        return bool(np.abs(image - self.table).max() <= SAME_NUMBERS * np.abs(self.table).max())

    @lazy_property
    def symmetric_in_blocks(self) -> bool:
        """True where block ij equals block ji at each offset."""
        image = self.table.swapaxes(0, 1)
        if image.shape != self.table.shape:
            return False
        return bool(np.abs(image - self.table).max() <= SAME_NUMBERS * np.abs(self.table).max())

    @classmethod
    def in_blocks(cls, blocks: list[list[GridOperator]]) -> GridOperator:
        """Operators on one surface, rows of blocks, as a single one."""
        rows = [np.concatenate([block.table for block in row], axis=1) for row in blocks]
        first = blocks[0][0]
        return GridOperator(first.shape, np.concatenate(rows), period=first.period)

    @property
    def transposed(self) -> GridOperator:
        """M', by the mirrored table."""
        return replace(self, table=self.table[:, :, ::-1, ::-1].swapaxes(0, 1))

    def symmetric_part(self, sign: float = 1.0) -> GridOperator:
        """``(M + s M')/2``, s the `sign`, of a square operator."""
        return replace(self, table=(self.table + sign * self.transposed.table) / 2)

    @property
    def whole(self) -> np.ndarray | None:
        """The matrix between all elements, with which products are taken; None where they are more
        than `DENSE_ELEMENTS`.
        """
        size = self.shape[0] * self.shape[1]
        if size > DENSE_ELEMENTS:
            return None
        products = self._products
        if products.whole is None:
            whole = self.dense(np.arange(size))
            whole.setflags(write=False)
            products.whole = whole
        return products.whole

    @property
    def _symbol(self) -> np.ndarray:
        products = self._products
        if products.symbol is None:
            symbol = spectrum_of(wrapped(self.table, self._box, self.period), self._box)
            symbol.setflags(write=False)
            products.symbol = symbol
        return products.symbol

    @property
    def kernels(self) -> dict[tuple[int, int], Any]:
        """Kernels of boxes, and their preconditioners, for solvers without a matrix."""
        return self._products.kernels

    @lazy_property
    def _box(self) -> tuple[int, int]:
        """Lengths of transforms: padded, but along axes that repeat."""
        return repeated(fft_box(*self.shape), self.shape, self.period)

    @lazy_property
    def _single_symbol(self) -> np.ndarray:
        return self._symbol.astype(np.complex64)


@dataclass(frozen=True, eq=False)
class RestrictedOperator:
    """A `GridOperator` between n elements only, named by their places on the grid, row by row.

    The softening (columns, n) is added to the diagonal: additional compliance of elements that the
    contact covers in part.
    """

    grid_operator: GridOperator
    elements: np.ndarray
    softening: np.ndarray | None = field(default=None, kw_only=True)
    copies: ClassVar[int] = 1
    """Number of elements that each element represents."""

    @lazy_property
    def _made(self) -> dict[str, Any]:
        if self._everywhere:  # these have the whole matrix
            return {}
        return self.grid_operator.made_for(self._places)

    @lazy_property
    def _everywhere(self) -> bool:
        """True where the elements are all of the grid, in its order."""
        ny, nx = self.grid_operator.shape
        return np.array_equal(self.elements, np.arange(ny * nx))

    @property
    def _places(self) -> tuple[np.ndarray | None, ...]:
        """Arrays that distinguish its matrix from others of the same grid."""
        return self.elements, self.softening

    def once(self, name: str, make: Callable[[], T]) -> T:
        """Object that `make` derives from the matrix between these elements; made once, kept by
        `name`.
        """
        if name not in self._made:
            self._made[name] = make()
        made: T = self._made[name]
        return made

    @lazy_property
    def matrix(self) -> np.ndarray:
        """Dense matrix, (rows * n, columns * n), assembled once."""
        return self.once("matrix", self._assembled)

    def _assembled(self) -> np.ndarray:
        operator = self.grid_operator
        if self._everywhere and operator.whole is not None:
            matrix = operator.whole.copy()
        else:
            matrix = operator.dense(self.elements)
        if self.softening is not None:
            np.einsum("ii->i", matrix)[:] += self.softening.ravel()
        return matrix

    @property
    def cholesky(self) -> tuple[np.ndarray, bool]:
        """Cholesky's factor of the matrix, symmetric and positive definite: for scipy's
        ``cho_solve``.
        """
        return self.once("cholesky", self._factored)

    def _factored(self) -> tuple[np.ndarray, bool]:
        from scipy.linalg import cho_factor

        matrix = self._assembled().T  # the same matrix, in LAPACK's order: no copy
        factor: tuple[np.ndarray, bool] = cho_factor(matrix, overwrite_a=True, check_finite=False)
        return factor

    @property
    def diagonal(self) -> float:
        """Mean of an element's direct influence on itself."""
        return self.grid_operator.diagonal

    @lazy_property
    def row_size(self) -> float:
        """Root mean square of the Euclidean lengths of the matrix's rows."""
        return self.once("row size", self._size_of_rows)

    def _size_of_rows(self) -> float:
        return float(np.linalg.norm(self.matrix) / np.sqrt(len(self.matrix)))

    def apply(self, tractions: np.ndarray) -> np.ndarray:
        """Displacements (rows, n) by tractions (columns, n), as a product on the whole grid."""
        ny, nx = self.grid_operator.shape
        if self._everywhere and self.softening is None:
            whole = self.grid_operator.apply(tractions.reshape(-1, ny, nx))
            return whole.reshape(-1, ny * nx)
        fields = np.zeros((tractions.shape[0], ny * nx))
        fields[:, self.elements] = tractions
        whole = self.grid_operator.apply(fields.reshape(-1, ny, nx))
        product = whole.reshape(-1, ny * nx).take(self.elements, axis=1)
        if self.softening is None:
            return product
        return product + self.softening * tractions

    def apply_densely(self, tractions: np.ndarray) -> np.ndarray:
        """Displacements (rows, n) by tractions (columns, n), by the dense matrix between the
        elements.
        """
        return np.asarray((self.matrix @ tractions.ravel()).reshape(-1, self.elements.size))


class Medium(Protocol):
    """Two bodies as solvers meet them, dimensionless: the combined modulus of
    rigidity of their surfaces is 1.

    Solvers know bodies by their medium alone. Media that are equal have equal
    influence numbers.
    """

    @property
    def K(self) -> float:
        """Size of the coupling of pressure and tractions; for half-spaces the constant (60); 0 if
        uncoupled.
        """

    @property
    def even(self) -> bool:
        """True where influence numbers are even or odd in x."""

    @property
    def reciprocal(self) -> bool:
        """True of elastic bodies: the matrix of all displacements by all tractions is symmetric."""

    def operator(
        self, lattice: Grid, rows: str, columns: str, stencil: Stencil = HERE
    ) -> GridOperator:
        """Displacements along `rows` by tractions along `columns`, combined over a stencil."""

    @property
    def at_once(self) -> Medium:
        """The bodies before anything relaxes; elastic ones themselves."""

    def at_end(self, time: float) -> Medium:
        """The bodies at the end of a step that takes a time; elastic ones themselves."""


class Homogeneous(ABC):
    """A medium that is the same everywhere along x and y: influence numbers depend on the offset
    alone.
    """

    @property
    @abstractmethod
    def K(self) -> float:
        """Size of the coupling of pressure and tractions; 0: independent."""

    @property
    def even(self) -> bool:
        """True where influence numbers are even or odd in x."""
        return True

    @property
    def even_y(self) -> bool:
        """True where influence numbers are even or odd in y."""
        return True

    @property
    def reciprocal(self) -> bool:
        """True of elastic bodies; where isotropic ones are not even in x, they relax."""
        return self.even

    @abstractmethod
    def influence(
        self, grid: Grid, x: np.ndarray, y: np.ndarray, components: Iterable[str]
    ) -> dict[str, np.ndarray]:
        """Influence numbers of an element of a grid at points from its centre, which broadcast
        together.

        In line contact elements are strips, and y does not matter.
        """

    def operator(
        self, lattice: Grid, rows: str, columns: str, stencil: Stencil = HERE
    ) -> GridOperator:
        """Displacements along `rows` by tractions along `columns`, combined over a stencil."""
        if len(rows) * len(columns) * len(stencil) * lattice.size > KEPT_NUMBERS:
            return GridOperator(lattice.shape, _table_of(lattice, rows, columns, stencil, self))
        table, products = _kept_table(lattice, rows, columns, stencil, self)
        return changed(GridOperator(lattice.shape, table), _products=products)

    @property
    def at_once(self) -> Homogeneous:
        """Elastic bodies do not relax."""
        return self

    def at_end(self, time: float) -> Homogeneous:
        """Elastic bodies do not relax."""
        return self


def influence_operator(
    grid: Grid,
    rows: Iterable[str],
    columns: Iterable[str],
    *,
    nu: float = 0.0,
    K: float = 0.0,
    depth: float = 1.0,
    medium: Medium | None = None,
    lag: float | None = None,
    difference: str = "first-order",
    offset: float = 0.0,
) -> GridOperator:
    """Influence numbers A on a grid, or their difference over a step of rolling
    where a `lag` is given.

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
    medium : Medium, optional
        Other bodies than half-spaces of these constants.
    lag : float, optional
        Distance `dq` [length]: C is B at the previous positions of the
        particles, ``x + dq`` (231).
    difference : {"first-order", "second-order"}
        Which difference over that step.
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
    from varcontact.elasticity.halfspace import HalfSpaces

    steps = DIFFERENCES[difference] if lag is not None else HERE
    stencil = tuple((offset + ahead * (lag or 0.0), weight) for ahead, weight in steps)
    bodies = medium or HalfSpaces(nu, K, depth)
    return bodies.operator(grid, "".join(rows), "".join(columns), stencil)


def _tables_at(
    grid: Grid, offsets: tuple[float, ...], names: tuple[str, ...], medium: Homogeneous
) -> np.ndarray:
    """Influence numbers (offsets, components, 2 ny - 1, 2 nx - 1) by offset of elements, at points
    further along x.

    Where all points lie on the lattice of the elements, as with steps of whole elements, tables
    share nearly all of theirs: those of one place are made once.
    """
    dx, dy = grid.sides
    steps = np.arange(-(grid.nx - 1), grid.nx)
    ahead = np.array(offsets)[:, None] / dx
    rounding = 4 * np.finfo(float).eps * np.maximum(np.abs(ahead), 1.0)
    whole = np.abs(ahead - np.round(ahead)) <= rounding
    x = np.where(whole, (steps + np.round(ahead)) * dx, steps * dx + np.array(offsets)[:, None])
    places, index = np.unique(np.abs(x) if medium.even else x, return_inverse=True)
    rows = np.arange(1 - grid.rows, grid.rows)
    if medium.even_y:
        rows = rows[grid.rows - 1 :]
    half = medium.influence(grid, places, rows[:, None] * dy, names)
    tables = np.empty((len(offsets), len(names), 2 * grid.rows - 1, x.shape[1]))
    for i, name in enumerate(names):
        full = half[name].reshape(rows.size, -1)
        if medium.even_y:  # numbers of rows above, mirrored to those below
            below = full[:0:-1]
            full = np.concatenate([-below if name.count("y") == 1 else below, full])
        tables[:, i] = full[:, index.reshape(x.shape)].swapaxes(0, 1)
        if medium.even and name.count("x") == 1:
            tables[:, i] *= np.where(x < 0, -1.0, 1.0)[:, None]
    return tables


def _table_of(
    lattice: Grid, rows: str, columns: str, stencil: Stencil, medium: Homogeneous
) -> np.ndarray:
    """Influence numbers (rows, columns, 2 ny - 1, 2 nx - 1), combined over a stencil."""
    names = tuple(row + column for row in rows for column in columns)
    offsets = tuple(ahead for ahead, _ in stencil)
    tables = _tables_at(lattice, offsets, names, medium)
    if len(stencil) == 1 and stencil[0][1] == 1.0:
        table = tables[0]
    else:
        table = sum(weight * each for (_, weight), each in zip(stencil, tables, strict=True))
    table = table.reshape(len(rows), len(columns), *table.shape[1:])
    table.setflags(write=False)
    return table


@lru_cache(maxsize=48)
def _kept_table(
    lattice: Grid, rows: str, columns: str, stencil: Stencil, medium: Homogeneous
) -> tuple[np.ndarray, TableProducts]:
    """Table of a small lattice, with the data that its operators compute for their products."""
    return _table_of(lattice, rows, columns, stencil, medium), TableProducts()
