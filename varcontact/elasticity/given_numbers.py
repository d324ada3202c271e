"""Bodies given by influence numbers: by the offset of elements, or from each element to each other
one.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from varcontact import checks
from varcontact.elasticity.by_element import ELEMENTS_MAX, ElementOperator
from varcontact.elasticity.by_row import RowOperator
from varcontact.elasticity.halfspace import influence_numbers
from varcontact.elasticity.operators import SAME_NUMBERS, GridOperator
from varcontact.errors import SceneError
from varcontact.scene.given_bodies import Numbers
from varcontact.scene.grid import Grid
from varcontact.scene.motion import Shift, Steady
from varcontact.system.process import lazy_property
from varcontact.transports import HERE, Stencil

if TYPE_CHECKING:
    from varcontact.scene.scene import Scene

ON_LATTICE = 1e-9
"""Difference from whole elements, or between sides of elements, that counts as rounding."""

SYMMETRY = 1e-9
"""Departure from Betti's theorem, divided by the largest number, that counts as rounding."""
SYMMETRIC_MATRIX = 1e-9
"""Asymmetry of a matrix, relative to its largest number, that counts as rounding; beyond it the
matrix is used as given, and no bounds are claimed."""


def checked_kernel(kernel: Any, components: str) -> Numbers:
    """Influence numbers between components by offset, or by both rows and the offset along x,
    checked for reciprocity (Betti's theorem).
    """
    field = "bodies.kernel"
    table = checks.array(field, as_array(kernel), 4, 5)
    c = len(components)
    *_, rows, columns = table.shape
    by_row = table.ndim == 5
    fits = rows % 2 == 1
    if by_row:
        fits = table.shape[2] == rows
    if not fits or table.shape[:2] != (c, c) or columns % 2 == 0 or columns < 3:
        allowed = (
            f"({c}, {c}, 2 ny - 1, 2 nx - 1), displacements by tractions and by offset, or "
            f"({c}, {c}, ny, ny, 2 nx - 1), by rows and offset along x"
        )
        raise checks.wrong_shape(field, table.shape, allowed)
    _check_reciprocal(field, table)
    if by_row:
        for row in range(rows):
            _check_positive(f"{field}, row {row}", table[:, :, row, row, columns // 2])
    else:
        _check_positive(field, table[:, :, rows // 2, columns // 2])
    return Numbers.of(table)


def _check_reciprocal(field: str, table: np.ndarray) -> None:
    """Refuse numbers that violate Betti's theorem when elements are exchanged; the error names the
    worst entry.
    """
    image = table[..., ::-1].swapaxes(0, 1)
    if table.ndim == 5:
        image = image.swapaxes(2, 3)
    else:
        image = image[:, :, ::-1]
    off = np.abs(table - image)
    if off.max() <= SYMMETRY * np.abs(table).max():
        return
    place = tuple(int(each) for each in np.unravel_index(int(np.argmax(off)), off.shape))
    i, j, *between, x = place
    if table.ndim == 5:
        between.reverse()
    else:
        between = [table.shape[2] - 1 - between[0]]
    other = [j, i, *between, table.shape[-1] - 1 - x]
    allowed = f"that of {other}, {image[place]:.6g}: by Betti's theorem B_ij(r) = B_ji(-r)"
    raise SceneError(f"{field}{list(place)}", float(table[place]), allowed)


def checked_matrix(matrix: Any, components: str) -> tuple[Numbers, ...]:
    """A, or A and C, between components of all elements."""
    field = "bodies.matrix"
    if not isinstance(matrix, list | tuple):
        matrix = (matrix,)
    if len(matrix) not in (1, 2):
        raise SceneError(field, matrix, "A, or (A, C)")
    arrays = [checks.array(f"{field}[{k}]", as_array(each), 2) for k, each in enumerate(matrix)]
    size = arrays[0].shape[0]
    c = len(components)
    for k, each in enumerate(arrays):
        if each.shape != (size, size) or size % c != 0 or size < 2 * c:
            allowed = f"({c} n, {c} n), of n elements, and the same of A and C; A is {size} high"
            raise checks.wrong_shape(f"{field}[{k}]", each.shape, allowed)
    n = size // c
    if n > ELEMENTS_MAX:
        raise SceneError(field, f"of {n} elements", f"of at most {ELEMENTS_MAX} elements")
    own = np.einsum("injn->ijn", arrays[0].reshape(c, n, c, n))
    for k in range(n):
        _check_positive(f"{field}[0], element {k}", own[:, :, k])
    return tuple(Numbers.of(each) for each in arrays)


def as_array(values: Any) -> Any:
    """Array from the numbers of a file; other values unchanged."""
    if isinstance(values, Numbers):
        return values.array
    return values


def _check_positive(field: str, own: np.ndarray) -> None:
    """Check that work is needed to load an element: its influence on itself (3, 3) is positive
    definite.
    """
    least = float(np.linalg.eigvalsh((own + own.T) / 2)[0])
    if not least > 0:
        allowed = "positive definite: an element gives way to its own tractions"
        raise SceneError(field, f"on itself of least eigenvalue {least:.4g}", allowed)


def asymmetry(matrix: np.ndarray) -> tuple[float, tuple[int, int]]:
    """Largest difference from the transpose, divided by the largest number, and its place."""
    off = np.abs(matrix - matrix.T)
    row, column = np.unravel_index(int(np.argmax(off)), off.shape)
    return float(off.max() / np.abs(matrix).max()), (int(row), int(column))


def check_own_grid(scene: Scene, sides: tuple[float, ...]) -> None:
    """Check that the grid is that of the numbers: explicit, with elements of the same sides."""
    grid = scene.grid
    if not isinstance(grid, Grid) or not grid.explicit:
        allowed = "explicit (nx, ny, dx, dy, x0, y0; in line contact nx, dx, x0), as of the numbers"
        raise SceneError("grid", grid, allowed)
    if (len(sides) == 1) != scene.line:
        allowed = "(dx, dy), or (dx,) in line contact"
        raise SceneError("bodies.sides", sides, allowed)
    own = grid.sides[: len(sides)]
    if np.abs(np.array(own) / sides - 1).max() > ON_LATTICE:
        raise SceneError("bodies.sides", sides, f"the sides of the grid's elements, {own}")
    if grid.edge != "centres":
        allowed = '"centres": there are no influence numbers of parts of elements'
        raise SceneError("grid.edge", grid.edge, allowed)


def check_of_matrix(scene: Scene, matrix: tuple[Numbers, ...], n: int) -> None:
    """Check that a matrix is that of all n elements, that the scene adds no curvature and no layer,
    and that its motion, if any, is a shift or steady rolling, for which there is a C.
    """
    assert isinstance(scene.grid, Grid)
    if scene.grid.size != n:
        raise SceneError("grid", scene.grid, f"of {n} elements, as bodies.matrix is")
    check_by_place(scene, "bodies.matrix", f"of {n} elements")
    motion = scene.motion
    if not isinstance(motion, Steady | Shift | None):
        allowed = "None, Shift or Steady: bodies.matrix has no numbers for histories"
        raise SceneError("motion", type(motion).__name__, allowed)
    if not isinstance(motion, Steady):
        return
    if len(matrix) == 1:
        allowed = "(A, C): steady rolling needs displacements where particles come from"
        raise SceneError("bodies.matrix", "A alone", allowed)
    if motion.slip_difference != "first-order":
        allowed = '"first-order": C has the displacements one step before'
        raise SceneError("motion.slip_difference", motion.slip_difference, allowed)


def check_by_place(scene: Scene, field: str, of: str) -> None:
    """Refuse a curved surface or an elastic layer for numbers by place, which already contain
    them.
    """
    if scene.conformal or scene.layer_compliance > 0:
        allowed = (
            "a kernel by offset, or a symbol: these have curvature and layers in their numbers"
        )
        raise SceneError(field, of, allowed)


def half_spaces_of(own: np.ndarray, sides: tuple[float, ...]) -> tuple[float, float]:
    """G and nu of half-spaces with the same numbers xx + yy and zz of an element on itself (xx, yy
    and zz, or zz alone); in line contact less those on the next strip, which do not depend on a
    depth.
    """
    x = np.zeros(1)
    _, dy = (*sides, math.inf)[:2]
    unit = float(influence_numbers(x, x, sides[0], dy, nu=0.0)["zz"][0])
    if len(sides) == 1:
        unit -= float(influence_numbers(x + sides[0], x, sides[0], dy, nu=0.0)["zz"][0])
    tangential = float(own[:-1].sum())
    normal = float(own[-1])
    nu = 0.0
    if tangential > normal:
        nu = min(max(1 - normal / (tangential - normal), 0.0), 0.5)
    return unit * (1 - nu) / normal, nu


def places(some: str, components: str) -> list[int]:
    """Places of some components among others."""
    return [components.index(each) for each in some]


def lattice_order(nodes: np.ndarray) -> tuple[np.ndarray, tuple[float, ...]]:
    """The order of nodes (n,) or (n, 2) along the rows of their lattice, and its sides."""
    columns = nodes.reshape(len(nodes), -1)
    if columns.shape[1] > 2:
        raise checks.wrong_shape("nodes", nodes.shape, "(n,) or (n, 2)")
    sides = []
    sizes = []
    for axis, values in zip("xy", columns.T, strict=False):
        # a coordinate counts once, but for rounding
        spread = float(np.ptp(values))
        lines = np.unique(np.round(values / max(spread, 1e-300), 9)) * max(spread, 1e-300)
        steps = np.diff(lines)
        if steps.size == 0 or np.ptp(steps) > 1e-6 * steps.max():
            allowed = f"at least two lines across {axis} at equal distances"
            raise SceneError("nodes", f"{lines.size} lines across {axis}", allowed)
        sides.append(float(spread / steps.size))
        sizes.append(lines.size)
    first = columns.min(axis=0)
    at = np.round((columns - first) / sides).astype(int)
    place = at[:, 0]
    if len(sides) == 2:
        place = at[:, 1] * sizes[0] + at[:, 0]
    order = np.argsort(place)
    if not np.array_equal(place[order], np.arange(math.prod(sizes))):
        raise SceneError("nodes", f"{len(nodes)} nodes", f"a full lattice, {math.prod(sizes)}")
    return order, tuple(sides)


class GivenMedium:
    """Base class of media with given numbers: elastic bodies that do not relax, with the K of their
    scene.
    """

    K: float

    @property
    def at_once(self) -> GivenMedium:
        """Elastic bodies do not relax."""
        return self

    def at_end(self, time: float) -> GivenMedium:
        """Elastic bodies do not relax."""
        return self


@dataclass(frozen=True)
class KernelMedium(GivenMedium):
    """Dimensionless numbers of elements with some sides: (3, 3, 2 ny - 1, 2 nx - 1) by offset, or
    (3, 3, ny, ny, 2 nx - 1) by both rows and the offset along x.
    """

    kernel: Numbers
    components: str
    sides: tuple[float, ...]
    K: float

    @lazy_property
    def even(self) -> bool:
        """True where numbers are even or odd in x."""
        table = self.kernel.array
        sign = np.array([(-1.0) ** each.count("x") for each in self.components])
        between = (sign[:, None] * sign).reshape(len(sign), len(sign), *[1] * (table.ndim - 2))
        image = table[..., ::-1] * between
        return bool(np.abs(image - table).max() <= SAME_NUMBERS * np.abs(table).max())

    @property
    def reciprocal(self) -> bool:
        """True: kernels that are not are refused."""
        return True

    def operator(
        self, lattice: Grid, rows: str, columns: str, stencil: Stencil = HERE
    ) -> GridOperator:
        """Displacements along `rows` by tractions along `columns`, combined over a stencil."""
        dx = lattice.sides[0]
        own = np.array(self.sides)
        if np.abs(lattice.sides[: own.size] / own - 1).max() > ON_LATTICE:
            message = (
                "bodies.kernel has influence numbers of elements with other sides than the grid's; "
                "solve on the grid that it was made for"
            )
            raise SceneError("grid", lattice, message=message)
        wanted = places(rows, self.components), places(columns, self.components)
        table = self._of_rows(self.kernel.array[np.ix_(*wanted)], lattice)
        parts = [weight * self._along_x(table, lattice, ahead / dx) for ahead, weight in stencil]
        total = np.sum(parts, axis=0)
        if total.ndim == 5:
            return RowOperator.of(total)
        return GridOperator(lattice.shape, total)

    @staticmethod
    def _of_rows(table: np.ndarray, lattice: Grid) -> np.ndarray:
        """Numbers between the rows of a lattice: by offset those that are nearest, by row all."""
        ny = lattice.rows
        if table.ndim == 5:
            if table.shape[2] != ny:
                raise _too_few(table, f"{ny} rows")
            return table
        known = (table.shape[2] + 1) // 2
        if ny > known:
            raise _too_few(table, f"{ny} rows")
        return table[:, :, known - ny : known + ny - 1]

    @staticmethod
    def _along_x(table: np.ndarray, lattice: Grid, columns: float) -> np.ndarray:
        """Numbers of a lattice for displacements `columns` further along x, a whole number."""
        ahead = round(columns)
        if abs(columns - ahead) > ON_LATTICE * max(1.0, abs(columns)):
            allowed = "a whole number of elements: bodies.kernel has no numbers between them"
            raise SceneError("motion.dq", f"{columns:.6g} elements", allowed)
        known = (table.shape[-1] + 1) // 2
        needed = lattice.nx + abs(ahead)
        if needed > known:
            raise _too_few(table, f"{needed} columns")
        first = known - lattice.nx + ahead
        return table[..., first : first + 2 * lattice.nx - 1]


def _too_few(table: np.ndarray, needed: str) -> SceneError:
    """Error for a kernel with too few offsets for a grid and motion."""
    columns = (table.shape[-1] + 1) // 2
    if table.ndim == 5:
        own = f"between {table.shape[2]} rows of {columns} elements"
    else:
        own = f"for {(table.shape[2] + 1) // 2} rows of {columns} elements"
    message = f"bodies.kernel has numbers {own}; this grid and motion need {needed}"
    return SceneError("bodies.kernel", f"of shape {table.shape}", message=message)


@dataclass(frozen=True)
class MatrixMedium(GivenMedium):
    """Dimensionless matrices (3 n, 3 n) of all displacements by all tractions, component by
    component: A, and C at the places that particles have left a step before.
    """

    matrices: tuple[Numbers, ...]
    components: str
    K: float
    reciprocal: bool
    even: ClassVar[bool] = False

    def operator(
        self, lattice: Grid, rows: str, columns: str, stencil: Stencil = HERE
    ) -> GridOperator:
        """Displacements along `rows` by tractions along `columns`, combined over a stencil."""
        n = self.matrices[0].array.shape[0] // len(self.components)
        if lattice.size != n:
            message = f"bodies.matrix is that of {n} elements, and the grid has {lattice.size}"
            raise SceneError("grid", lattice, message=message)
        total = np.zeros((len(rows), n, len(columns), n))
        for ahead, weight in stencil:
            total += weight * self._blocks(rows, columns, ahead)
        return element_operator(lattice.shape, total)

    def _blocks(self, rows: str, columns: str, ahead: float) -> np.ndarray:
        """Displacements at the same places, at those that particles come from, or at those they go
        to: in bodies uniform along x the latter are C' by Betti's theorem.
        """
        matrix = self.matrices[0].array
        if ahead != 0:
            matrix = self.matrices[1].array
        if ahead < 0:
            matrix = matrix.T
        c = len(self.components)
        n = matrix.shape[0] // c
        blocks = matrix.reshape(c, n, c, n)[places(rows, self.components)]
        return np.asarray(blocks[:, :, places(columns, self.components)])


def element_operator(shape: tuple[int, int], numbers: np.ndarray) -> ElementOperator:
    """An operator from its numbers (rows, n, columns, n); its table has their means by offset."""
    ny, nx = shape
    n = ny * nx
    iy, ix = np.divmod(np.arange(n), nx)
    width = 2 * nx - 1
    place = ((iy[:, None] - iy + ny - 1) * width + ix[:, None] - ix + nx - 1).ravel()
    size = (2 * ny - 1) * width
    counts = np.bincount(place, minlength=size)
    rows, _, columns, _ = numbers.shape
    table = np.empty((rows, columns, size))
    for i in range(rows):
        for j in range(columns):
            table[i, j] = np.bincount(place, numbers[i, :, j].ravel(), size) / counts
    return ElementOperator(shape, table.reshape(rows, columns, 2 * ny - 1, width), numbers)
