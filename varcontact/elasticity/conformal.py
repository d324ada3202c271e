"""Conformal contact: influence numbers on a reference surface that is curved
along y, along x, or along both.

A traction acts in the frame of its own element, whose y and z are turned about
x by the inclination there (curved along y), or whose x and z are turned about y
(curved along x). With the angle ``t = alpha_J - alpha_I`` from the element I of
a displacement to the loaded element J, and the numbers A of the flat surface by
arc length, the symmetric variant is ``B = R(t/2) A R(t/2)`` (Vollebregt, Segal,
VSD 52 (2014) 455; Blanco-Lorenzo et al., Tribol. Int. 103 (2016) 647): it alone
keeps reciprocity. Curved along both, R is half of the rotation from the frame of
I to that of J. In rolling A is the difference between displacements here and
ahead, along the axes of I.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from typing import ClassVar

import numpy as np

from varcontact.elasticity.by_element import turned_operator
from varcontact.elasticity.fft_products import fft_box, wrapped
from varcontact.elasticity.operators import GridOperator, Medium
from varcontact.scene.frames import frames_of_elements
from varcontact.scene.grid import Grid
from varcontact.scene.interpolation import continuation
from varcontact.system.process import lazy_property
from varcontact.transports import HERE, Stencil

Transforms = dict[tuple[int, ...], np.ndarray]
"""Transforms by harmonic, row and column."""

STRAIGHT = 1e-10
"""Departure of inclinations [rad] from a constant curvature that counts as rounding."""

AXES = {"x": 0, "y": 1, "z": 2}

STRAIGHT_AXIS = {"y": "x", "x": "y"}
"""Other axis for each axis along which a surface is curved."""

TURNED = np.array([[1, 1j], [-1j, 1]]) / 2
"""Rotations of x or y, and z, by an angle t are twice the real part of ``exp(i t)`` times this."""

COSINES = 1, 3
"""Harmonics of `_waves` that are cosines, each followed by the sine of its angle."""

TRANSPOSE_SIGNS = np.array([1, 1, -1, 1, -1]).reshape(5, 1, 1, 1, 1)
"""Signs of the harmonics where field and loaded element change places: the angle is reversed."""


@dataclass(frozen=True)
class Inclination:
    """Inclinations at some places, ascending [rad]; beyond them with the curvature at the ends."""

    places: tuple[float, ...]
    angles: tuple[float, ...]

    @property
    def turn(self) -> float:
        return max(self.angles) - min(self.angles)

    def at(self, places: np.ndarray) -> np.ndarray:
        return continuation(np.array(self.places), np.array(self.angles))(places)


@dataclass(frozen=True)
class Conformal:
    """A medium whose bodies meet on a curved surface: that on the flat one, and the inclinations by
    row (curved along y) and by column (along x).
    """

    flat: Medium
    by_row: Inclination | None = None
    by_column: Inclination | None = None

    @property
    def K(self) -> float:
        """Size of the coupling: pressures rotated by an angle t act as tractions, also for like
        bodies.
        """
        turns = [each.turn for each in (self.by_row, self.by_column) if each is not None]
        return abs(self.flat.K) + min(sum(turns), 1.0)

    @property
    def even(self) -> bool:
        return self.flat.even

    @property
    def reciprocal(self) -> bool:
        return self.flat.reciprocal

    @property
    def at_once(self) -> Conformal:
        return replace(self, flat=self.flat.at_once)

    def at_end(self, time: float) -> Conformal:
        return replace(self, flat=self.flat.at_end(time))

    def operator(
        self, lattice: Grid, rows: str, columns: str, stencil: Stencil = HERE
    ) -> GridOperator:
        flat = partial(self.flat.operator, lattice, stencil=stencil)
        if self.by_column is None:
            assert self.by_row is not None
            return conformal_operator(rows, columns, self.by_row.at(lattice.y), flat)
        along_x = self.by_column.at(lattice.x)
        if self.by_row is None:
            return conformal_operator(rows, columns, along_x, flat, "x")
        frames = frames_of_elements(self.by_row.at(lattice.y), along_x)
        return turned_operator(rows, columns, frames, flat("xyz", "xyz"))


def conformal_operator(
    rows: str,
    columns: str,
    angles: np.ndarray,
    flat: Callable[[str, str], GridOperator],
    curved: str = "y",
) -> GridOperator:
    """The operator on a curved surface, from that on the flat one.

    Parameters
    ----------
    rows, columns : str
        Displacement and traction components, in the frames of the elements.
    angles : ndarray, shape (ny,) or (nx,)
        Inclination alpha of each row, or column, of elements [rad].
    flat : callable
        The operator on the flat surface, between components.
    curved : {"y", "x"}
        The axis along which the surface is curved.

    Returns
    -------
    GridOperator
        Block-Toeplitz where the curvature is constant, else a
        `ConformalOperator`.

    Examples
    --------
    >>> from varcontact.elasticity.operators import influence_operator
    >>> from varcontact.scene.grid import Grid
    >>> grid = Grid(nx=4, ny=3, dx=1.0, dy=1.0, x0=0.0, y0=0.0)
    >>> flat = lambda rows, columns: influence_operator(grid, rows, columns, nu=0.3)
    >>> angles = np.array([0.0, 0.1, 0.3])
    >>> matrix = conformal_operator("xyz", "xyz", angles, flat).dense(np.arange(12))
    >>> bool(np.allclose(matrix, matrix.T, rtol=0, atol=1e-16))
    True
    >>> bool(np.linalg.eigvalsh(matrix).min() > 0)
    True
    """
    flat_rows = _turned_components(rows, curved)
    flat_columns = _turned_components(columns, curved)
    table = flat(flat_rows, flat_columns)
    plane = [AXES[curved], AXES["z"]]
    turned = np.zeros((3, 3), complex)
    turned[np.ix_(plane, plane)] = TURNED
    still = np.zeros((3, 3))
    straight = AXES[STRAIGHT_AXIS[curved]]
    still[straight, straight] = 1.0

    def product(left: np.ndarray, right: np.ndarray) -> np.ndarray:
        """Parts of two rotations around the numbers of the flat surface."""
        total = np.zeros((len(rows), len(columns), *table.table.shape[2:]), complex)
        for (i, row), (a, inner) in itertools.product(enumerate(rows), enumerate(flat_rows)):
            for (j, column), (b, outer) in itertools.product(
                enumerate(columns), enumerate(flat_columns)
            ):
                factor = left[AXES[row], AXES[inner]] * right[AXES[outer], AXES[column]]
                if factor:
                    total[i, j] += factor * table.table[a, b]
        return total

    # harmonics of half the angle between two elements
    constant = (product(still, still) + 2 * product(turned, turned.conj())).real
    once = 2 * (product(still, turned) + product(turned, still))
    twice = 2 * product(turned, turned)
    harmonics = np.array([constant, once.real, -once.imag, twice.real, -twice.imag])
    # the mean curvature, which depends on the offset alone
    slope = 0.0 if angles.size == 1 else (angles[-1] - angles[0]) / (angles.size - 1)
    mean = _waves(slope * np.arange(angles.size - 1, -angles.size, -1))
    by_offset = np.expand_dims(mean, {"y": 2, "x": 1}[curved])
    summed = sum(map(np.multiply, by_offset, harmonics))
    if np.abs(angles - angles[0] - slope * np.arange(angles.size)).max() <= STRAIGHT:
        return GridOperator(table.shape, summed)
    return ConformalOperator(table.shape, summed, angles, harmonics, curved)


def _turned_components(names: str, curved: str) -> str:
    """Components on the flat surface that contribute to some on the curved surface."""
    straight = STRAIGHT_AXIS[curved]
    if names == straight:
        return straight
    if straight in names:
        return "xyz"
    return curved + "z"


def _waves(angle: np.ndarray) -> np.ndarray:
    """Harmonics (5, ...) of half an angle: the constant, cosine and sine, and these of the whole
    angle.
    """
    return np.array(
        [np.ones_like(angle), np.cos(angle / 2), np.sin(angle / 2), np.cos(angle), np.sin(angle)]
    )


@dataclass(frozen=True, eq=False)
class ConformalOperator(GridOperator):
    """An operator on a surface whose curvature varies: products by FFT with fields modulated along
    the axis that is curved.

    Its `table` is that of the mean curvature: exact for elements on themselves, and what
    preconditioners need.
    """

    toeplitz: ClassVar[bool] = False
    angles: np.ndarray
    harmonics: np.ndarray  # (5, rows, columns, 2 ny - 1, 2 nx - 1) tables, in the order of `_waves`
    curved: str = "y"

    def dense(self, elements: np.ndarray, loaded: np.ndarray | None = None) -> np.ndarray:
        """The matrix from tractions on `loaded` to displacements in `elements`, see
        `GridOperator.dense`.
        """
        if loaded is None:
            loaded = elements
        rows, columns = self.table.shape[:2]
        of_field = self._angles_of(elements)
        waves = _waves(self._angles_of(loaded) - of_field[:, None])
        matrix = np.zeros((rows, elements.size, columns, loaded.size))
        for wave, table in zip(waves, self.harmonics, strict=True):
            harmonic = GridOperator(self.shape, table).dense(elements, loaded)
            matrix += harmonic.reshape(matrix.shape) * wave[:, None]
        return matrix.reshape(rows * elements.size, columns * loaded.size)

    def _angles_of(self, elements: np.ndarray) -> np.ndarray:
        places = dict(zip("yx", np.divmod(elements, self.shape[1]), strict=True))
        return self.angles[places[self.curved]]

    def _product(self, tractions: np.ndarray) -> np.ndarray:
        """Product with tractions (columns, ny, nx) on the whole grid, in their precision.

        Cosine and sine of ``alpha_J - alpha_I`` are sums of products of those of alpha_J, which
        tractions are multiplied by before the transform along the curved axis, and of alpha_I,
        which displacements are after it. That axis comes first here, as y.
        """
        from scipy import fft

        tractions = self._curved_first(tractions)
        ny, nx = tractions.shape[-2:]
        box = fft_box(ny, nx)
        single = tractions.dtype == np.float32
        transforms = self._single_transforms if single else self._transforms
        waves = self._waves_used
        fields = _waves(self.angles)[waves, None, :, None].astype(tractions.dtype)
        place = {wave: k for k, wave in enumerate(waves)}

        # tractions times the waves of alpha_J
        loads = fft.rfft(tractions, box[1], axis=-1)
        columns = fft.fft(fields * loads, box[0], axis=-2, overwrite_x=True)
        images = np.zeros((len(waves), self.table.shape[0], *columns.shape[2:]), columns.dtype)
        for (wave, i, j), symbol in transforms.items():
            k = place[wave]
            if wave == 0:
                images[k, i] += symbol * columns[k, j]
            elif wave in COSINES:
                images[k : k + 2, i] += symbol * columns[k : k + 2, j]
            else:
                images[k - 1, i] += symbol * columns[k, j]
                images[k, i] -= symbol * columns[k - 1, j]

        # displacements times those of alpha_I
        shifts = fft.ifft(images, axis=-2, overwrite_x=True)[..., :ny, :]
        total = (fields * shifts).sum(axis=0)
        return self._curved_first(fft.irfft(total, box[1], axis=-1)[..., :nx])

    def _curved_first(self, fields: np.ndarray) -> np.ndarray:
        """Fields (..., ny, nx) with the curved axis before the other; or back."""
        if self.curved == "y":
            return fields
        return fields.swapaxes(-2, -1)

    @lazy_property
    def _waves_used(self) -> list[int]:
        """Harmonics that products need, cosine and sine of an angle together."""
        used = {wave for wave, *_ in self._transforms}
        for cosine in COSINES:
            if used & {cosine, cosine + 1}:
                used |= {cosine, cosine + 1}
        return sorted(used)

    def _part(self, rows: tuple[int, ...], columns: tuple[int, ...]) -> GridOperator:
        table = self.table[np.ix_(rows, columns)]
        harmonics = self.harmonics[:, rows][:, :, columns]
        return replace(self, table=table, harmonics=harmonics)

    def has_mirror(self, rows: slice) -> bool:
        if self.curved == "x":
            return True
        angles = self.angles[rows]
        return float(np.ptp(angles + angles[::-1])) <= STRAIGHT

    @classmethod
    def in_blocks(cls, blocks: list[list[GridOperator]]) -> ConformalOperator:
        curved = [
            [block for block in row if isinstance(block, ConformalOperator)] for row in blocks
        ]
        rows = [np.concatenate([block.harmonics for block in row], axis=2) for row in curved]
        harmonics = np.concatenate(rows, axis=1)
        flat = GridOperator.in_blocks(blocks)
        return replace(curved[0][0], table=flat.table, harmonics=harmonics)

    @property
    def transposed(self) -> ConformalOperator:
        harmonics = TRANSPOSE_SIGNS * self.harmonics[..., ::-1, ::-1].swapaxes(1, 2)
        return replace(self, table=super().transposed.table, harmonics=harmonics)

    def symmetric_part(self, sign: float = 1.0) -> ConformalOperator:
        harmonics = (self.harmonics + sign * self.transposed.harmonics) / 2
        table = super().symmetric_part(sign).table
        return replace(self, table=table, harmonics=harmonics)

    @lazy_property
    def _single_transforms(self) -> Transforms:
        return {key: each.astype(np.complex64) for key, each in self._transforms.items()}

    @lazy_property
    def _transforms(self) -> Transforms:
        """Transforms of the tables that are not zero."""
        from scipy import fft

        harmonics = self._curved_first(self.harmonics)
        rows, columns = harmonics.shape[-2:]
        box = fft_box((rows + 1) // 2, (columns + 1) // 2)
        nonzero = np.argwhere(harmonics.any(axis=(-2, -1)))
        return {
            key: np.asarray(fft.rfft2(wrapped(harmonics[key], box)))
            for key in map(tuple, nonzero.tolist())
        }
