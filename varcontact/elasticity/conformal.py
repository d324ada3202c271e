"""Conformal contact: influence numbers on a reference surface that is curved along y, and the same along x.

A traction acts in the frame of its own element, whose y and z are turned about x by the inclination there. With the
angle ``t = alpha_J - alpha_I`` from the element I of a displacement to the loaded element J, and the numbers A of the
flat surface by arc length, the symmetric variant is ``B = R(t/2) A R(t/2)`` (Vollebregt, Segal, VSD 52 (2014) 455;
Blanco-Lorenzo et al., Tribol. Int. 103 (2016) 647): it alone keeps reciprocity.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from itertools import product

import numpy as np

from varcontact.elasticity.halfspace import Medium
from varcontact.elasticity.operators import GridOperator, fft_box, wrapped
from varcontact.scene.interpolation import continuation

STRAIGHT = 1e-10
"""Departure of inclinations [rad] from a constant curvature that counts as rounding."""

Harmonics = dict[tuple[int, int, int, int], np.ndarray]
"""Tables by the number m of half turns, wave (0 for ``cos(m t/2)``, 1 for ``sin(m t/2)``), row and column."""

WAVES = np.cos, np.sin


@dataclass(frozen=True)
class Conformal:
    """Bodies that meet on a curved surface: a medium on the flat one, and the inclination at some y, ascending."""

    flat: Medium
    y: tuple[float, ...]
    angles: tuple[float, ...]

    @property
    def K(self) -> float:
        """Size of the coupling: pressures turned by t act on tractions, also of like bodies."""
        return abs(self.flat.K) + min(max(self.angles) - min(self.angles), 1.0)

    @property
    def even(self) -> bool:
        return self.flat.even

    @cached_property
    def angles_at(self) -> Callable[[np.ndarray], np.ndarray]:
        """Inclination by y; beyond those given with the curvature that it has at the ends."""
        return continuation(np.array(self.y), np.array(self.angles))


def conformal_operator(
    rows: str, columns: str, angles: np.ndarray, flat: Callable[[str, str], GridOperator]
) -> GridOperator:
    """The operator on a curved surface, from that on the flat one.

    Parameters
    ----------
    rows, columns : str
        Displacement and traction components, in the frames of the elements.
    angles : ndarray, shape (ny,)
        Inclination alpha of each row of elements [rad].
    flat : callable
        The operator on the flat surface, between components.

    Returns
    -------
    GridOperator
        Block-Toeplitz where the curvature is constant, else a `ConformalOperator`.

    Examples
    --------
    >>> from varcontact.elasticity.operators import influence_operator
    >>> from varcontact.scene.grid import Grid
    >>> grid = Grid(nx=4, ny=3, dx=1.0, dy=1.0, x0=0.0, y0=0.0)
    >>> flat = lambda rows, columns: influence_operator(grid, rows, columns, nu=0.3)
    >>> matrix = conformal_operator("xyz", "xyz", np.array([0.0, 0.1, 0.3]), flat).dense(np.arange(12))
    >>> bool(np.allclose(matrix, matrix.T, rtol=0, atol=1e-16) and np.linalg.eigvalsh(matrix).min() > 0)
    True
    """
    above, across = ("x" if names == "x" else "xyz" if "x" in names else "yz" for names in (rows, columns))
    table = flat(above, across)
    blocks = {(row, column): table.table[i, j] for i, row in enumerate(above) for j, column in enumerate(across)}
    harmonics: Harmonics = {}
    for (i, row), (j, column) in product(enumerate(rows), enumerate(columns)):
        for half_turns, *tables in _harmonics_of(blocks, row, column):
            harmonics |= {(half_turns, wave, i, j): each for wave, each in enumerate(tables) if each.any()}
    steps = np.arange(1 - angles.size, angles.size)
    slope = 0.0 if angles.size == 1 else (angles[-1] - angles[0]) / (angles.size - 1)
    angle = -slope * steps[:, None]  # of the mean curvature: by the offset alone
    summed = np.zeros((len(rows), len(columns), *table.table.shape[2:]))
    for (half_turns, wave, i, j), numbers in harmonics.items():
        summed[i, j] += WAVES[wave](half_turns * angle / 2) * numbers
    if np.abs(angles - angles[0] - slope * np.arange(angles.size)).max() <= STRAIGHT:
        return GridOperator(table.shape, summed)
    return ConformalOperator(table.shape, summed, angles, harmonics)


def _harmonics_of(
    blocks: dict[tuple[str, str], np.ndarray], row: str, column: str
) -> list[tuple[int, np.ndarray] | tuple[int, np.ndarray, np.ndarray]]:
    """How ``R(t/2) A R(t/2)`` between two components depends on t: half turns m, and factors of cosine and sine."""
    if row == column == "x":
        return [(0, blocks["x", "x"])]
    if row == "x":
        along, normal = blocks["x", "y"], blocks["x", "z"]
        return [(1, along, normal)] if column == "y" else [(1, normal, -along)]
    if column == "x":
        along, normal = blocks["y", "x"], blocks["z", "x"]
        return [(1, along, -normal)] if row == "y" else [(1, normal, along)]
    mean, half = (blocks["y", "y"] + blocks["z", "z"]) / 2, (blocks["y", "y"] - blocks["z", "z"]) / 2
    skew, even = (blocks["y", "z"] - blocks["z", "y"]) / 2, (blocks["y", "z"] + blocks["z", "y"]) / 2
    if row == column:
        return [(0, half if row == "y" else -half), (2, mean, skew)]
    return [(0, even), (2, skew, -mean) if row == "y" else (2, -skew, mean)]


@dataclass(frozen=True, eq=False)
class ConformalOperator(GridOperator):
    """An operator on a surface whose curvature varies: products by FFT with fields modulated along y.

    Its `table` is that of the mean curvature: exact for elements on themselves, and what preconditioners need.
    """

    angles: np.ndarray
    harmonics: Harmonics

    def dense(self, elements: np.ndarray, loaded: np.ndarray | None = None) -> np.ndarray:
        """The matrix from tractions on `loaded` to displacements in `elements`, see `GridOperator.dense`."""
        loaded = elements if loaded is None else loaded
        nx, (rows, columns) = self.shape[1], self.table.shape[:2]
        angle = self.angles[loaded // nx] - self.angles[elements // nx][:, None]
        blocks = np.zeros((rows, elements.size, columns, loaded.size))
        for (half_turns, wave, i, j), table in self.harmonics.items():
            own = GridOperator(self.shape, table[None, None]).dense(elements, loaded)
            blocks[i, :, j] += WAVES[wave](half_turns * angle / 2) * own
        return blocks.reshape(rows * elements.size, columns * loaded.size)

    def _product(self, tractions: np.ndarray) -> np.ndarray:
        """Product with tractions (columns, ny, nx) on the whole grid, in their precision.

        Cosine and sine of ``alpha_J - alpha_I`` are sums of products of those of alpha_J, which tractions are
        multiplied by before the transform along y, and of alpha_I, which displacements are after it.
        """
        from scipy import fft

        box, ny = fft_box(*self.shape), self.shape[0]
        loads = fft.rfft(tractions, box[1], axis=-1)
        found = np.zeros((self.table.shape[0], ny, loads.shape[-1]), dtype=loads.dtype)
        transforms = self._single_transforms if tractions.dtype == np.float32 else self._transforms
        for half_turns in {key[0] for key in transforms}:
            angle = (half_turns * self.angles[:, None] / 2).astype(tractions.dtype)
            waves = [wave(angle) for wave in WAVES[: 2 if half_turns else 1]]
            columns: dict[int, np.ndarray] = {}
            images: dict[int, np.ndarray] = {}
            for (turns, odd, i, j), symbol in transforms.items():
                if turns != half_turns:
                    continue
                if j not in columns:
                    columns[j] = fft.fft([wave * loads[j] for wave in waves], box[0], axis=-2)
                image = images.setdefault(i, np.zeros_like(columns[j]))
                if odd:
                    image[0] += symbol * columns[j][1]
                    image[1] -= symbol * columns[j][0]
                else:
                    image += symbol * columns[j]
            for i, image in images.items():
                shifts = fft.ifft(image, axis=-2, overwrite_x=True)[:, :ny]
                found[i] += sum(map(np.multiply, waves, shifts))
        return np.asarray(fft.irfft(found, box[1], axis=-1)[..., : self.shape[1]])

    def _part(self, rows: tuple[int, ...], columns: tuple[int, ...]) -> GridOperator:
        chosen = {
            (half_turns, wave, rows.index(i), columns.index(j)): table
            for (half_turns, wave, i, j), table in self.harmonics.items()
            if i in rows and j in columns
        }
        return ConformalOperator(self.shape, self.table[np.ix_(rows, columns)], self.angles, chosen)

    def symmetric_part(self, sign: float = 1.0) -> ConformalOperator:
        found: Harmonics = {}
        for (half_turns, odd, i, j), table in self.harmonics.items():
            turned = (-sign if odd else sign) * table[::-1, ::-1]
            for key, each in (((half_turns, odd, i, j), table), ((half_turns, odd, j, i), turned)):
                found[key] = found.get(key, 0.0) + each / 2
        return ConformalOperator(self.shape, super().symmetric_part(sign).table, self.angles, found)

    def has_mirror(self, first: int, last: int) -> bool:
        """Whether inclinations of the rows from `first` to `last` are odd about their middle."""
        sums = self.angles[first : last + 1] + self.angles[first : last + 1][::-1]
        return bool(np.ptp(sums) <= STRAIGHT)

    @cached_property
    def _single_transforms(self) -> Harmonics:
        return {key: each.astype(np.complex64) for key, each in self._transforms.items()}

    @cached_property
    def _transforms(self) -> Harmonics:
        from scipy import fft

        box = fft_box(*self.shape)
        return {key: np.asarray(fft.rfft2(wrapped(table, box))) for key, table in self.harmonics.items()}


def in_blocks(blocks: list[list[GridOperator]]) -> GridOperator:
    """Operators on one surface as a single one: two rows of two blocks, the first one a single component."""
    first, harmonics = blocks[0][0], Harmonics()
    table = np.concatenate([np.concatenate([block.table for block in line], axis=1) for line in blocks])
    if not isinstance(first, ConformalOperator):
        return GridOperator(first.shape, table)
    for row, column in np.ndindex(2, 2):
        block = blocks[row][column]
        assert isinstance(block, ConformalOperator)
        harmonics |= {(m, odd, row + i, column + j): each for (m, odd, i, j), each in block.harmonics.items()}
    return ConformalOperator(first.shape, table, first.angles, harmonics)
