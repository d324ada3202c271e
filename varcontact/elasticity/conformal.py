"""Conformal contact: influence numbers on a reference surface that is curved along y, and the same along x.

A traction acts in the frame of its own element, whose y and z are turned about x by the inclination there. With the
angle ``t = alpha_J - alpha_I`` from the element I of a displacement to the loaded element J, and the numbers A of the
flat surface by arc length, the symmetric variant is ``B = R(t/2) A R(t/2)`` (Vollebregt, Segal, VSD 52 (2014) 455;
Blanco-Lorenzo et al., Tribol. Int. 103 (2016) 647): it alone keeps reciprocity.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from varcontact.elasticity.halfspace import Medium
from varcontact.elasticity.operators import GridOperator, fft_box, wrapped
from varcontact.scene.grid import Grid
from varcontact.scene.interpolation import continuation

STRAIGHT = 1e-10
"""Departure of inclinations [rad] from a constant curvature that counts as rounding."""

NINE = tuple(row + column for row in "xyz" for column in "xyz")

Harmonics = dict[tuple[int, int, int], tuple[np.ndarray | None, np.ndarray | None]]
"""By the number m of half turns, row and column: tables C and S of ``cos(m t/2) C + sin(m t/2) S``."""

Transforms = dict[int, dict[tuple[int, int], list[np.ndarray | None]]]
"""Those of the tables, by half turns, then by row and column."""


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

    @property
    def curvature(self) -> float:
        """The largest, between the places given."""
        turns = np.abs(np.diff(self.angles)) / np.diff(self.y)
        return float(turns.max(initial=0.0))

    def influence(self, grid: Grid, x: np.ndarray, y: np.ndarray, components: Iterable[str]) -> dict[str, np.ndarray]:
        """Influence numbers by offset, on a surface of the mean curvature."""
        span = self.y[-1] - self.y[0]
        angle = -np.asarray(y) * ((self.angles[-1] - self.angles[0]) / span if span else 0.0)
        return turned(self.flat.influence(grid, x, y, NINE), angle, components)

    def normal_displacement(
        self, flat: dict[str, np.ndarray], loads: np.ndarray, centres: np.ndarray, y: np.ndarray
    ) -> np.ndarray:
        """Displacement along z at points y, by loads (3, n) at the centres' y, from numbers of the flat surface.

        As ``R(t/2) = R(alpha_J/2) R(-alpha_I/2)``, only loads and sums are turned; blocks that are absent are zero.
        """
        point, load = np.exp(0.5j * self.angles_at(y)), np.exp(-0.5j * self.angles_at(centres))
        across = loads[1] + 1j * loads[2]
        weights = np.array([loads[0] * load, across / 2, across.conj() * load**2 / 2])
        parts = np.concatenate([weights.real, weights.imag])
        sums = {name: (real := parts @ numbers)[:3] + 1j * real[3:] for name, numbers in flat.items()}
        none = np.zeros((3, y.size))
        zx, zy, yz, yx, yy, zz = (sums.get(name, none) for name in ("zx", "zy", "yz", "yx", "yy", "zz"))
        turned_back = point * (zx + 1j * yx)[0] + point**2 * (zy - yz + 1j * (yy + zz))[2]
        return np.asarray(np.real(turned_back + (zy + yz + 1j * (yy - zz))[1]))


def turned(flat: dict[str, np.ndarray], angle: np.ndarray, components: Iterable[str]) -> dict[str, np.ndarray]:
    """Influence numbers from all nine of the flat surface, and the angles t."""
    blocks = {(name[0], name[1]): numbers for name, numbers in flat.items()}
    c, s = np.cos(angle / 2), np.sin(angle / 2)
    waves = (1.0, 0.0), (c, s), (c * c - s * s, 2 * c * s)
    found = {}
    for name in components:
        found[name] = np.zeros(blocks["x", "x"].shape)
        for half_turns, *tables in _harmonics_of(blocks, name[0], name[1]):
            for wave, numbers in zip(waves[half_turns], tables, strict=True):
                found[name] += 0.0 if numbers is None else wave * numbers
    return found


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
    for i, row in enumerate(rows):
        for j, column in enumerate(columns):
            for half_turns, even, odd in _harmonics_of(blocks, row, column):
                cosine, sine = (each if each is not None and each.any() else None for each in (even, odd))
                if cosine is not None or sine is not None:
                    harmonics[half_turns, i, j] = cosine, sine
    steps = np.arange(1 - angles.size, angles.size)
    slope = 0.0 if angles.size == 1 else (angles[-1] - angles[0]) / (angles.size - 1)
    shape = len(rows), len(columns), *table.table.shape[2:]
    angle, summed = -slope * steps[:, None], np.zeros(shape)  # of the mean curvature: by the offset alone
    for (half_turns, i, j), (cosine, sine) in harmonics.items():
        if cosine is not None:
            summed[i, j] += np.cos(half_turns * angle / 2) * cosine
        if sine is not None:
            summed[i, j] += np.sin(half_turns * angle / 2) * sine
    alike = GridOperator(table.shape, summed)
    if np.abs(angles - angles[0] - slope * np.arange(angles.size)).max() <= STRAIGHT:
        return alike
    return ConformalOperator(table.shape, alike.table, angles, harmonics)


def _harmonics_of(
    blocks: dict[tuple[str, str], np.ndarray], row: str, column: str
) -> list[tuple[int, np.ndarray | None, np.ndarray | None]]:
    """How ``R(t/2) A R(t/2)`` between two components depends on t: half turns m, and factors of cosine and sine."""
    if row == column == "x":
        return [(0, blocks["x", "x"], None)]
    if row == "x":
        along, normal = blocks["x", "y"], blocks["x", "z"]
        return [(1, along, normal)] if column == "y" else [(1, normal, -along)]
    if column == "x":
        along, normal = blocks["y", "x"], blocks["z", "x"]
        return [(1, along, -normal)] if row == "y" else [(1, normal, along)]
    mean, half = (blocks["y", "y"] + blocks["z", "z"]) / 2, (blocks["y", "y"] - blocks["z", "z"]) / 2
    skew, even = (blocks["y", "z"] - blocks["z", "y"]) / 2, (blocks["y", "z"] + blocks["z", "y"]) / 2
    if row == column:
        return [(0, half if row == "y" else -half, None), (2, mean, skew)]
    return [(0, even, None), (2, skew, -mean) if row == "y" else (2, -skew, mean)]


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
        for (half_turns, i, j), tables in self.harmonics.items():
            for wave, table in zip((np.cos, np.sin), tables, strict=True):
                if table is not None:
                    own = GridOperator(self.shape, table[None, None]).dense(elements, loaded)
                    blocks[i, :, j] += wave(half_turns * angle / 2) * own
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
        single = tractions.dtype == np.float32
        for half_turns, blocks in (self._single_transforms if single else self._transforms).items():
            angle = (half_turns * self.angles[:, None] / 2).astype(tractions.dtype)
            waves = (np.cos(angle), np.sin(angle)) if half_turns else (np.ones_like(angle),)
            columns = {j: fft.fft([wave * loads[j] for wave in waves], box[0], axis=-2) for _, j in blocks}
            images: dict[int, np.ndarray] = {}
            for (i, j), (even, odd) in blocks.items():
                image = images.setdefault(i, np.zeros_like(columns[j]))
                if even is not None:
                    image += even * columns[j]
                if odd is not None:
                    image[0] += odd * columns[j][1]
                    image[1] -= odd * columns[j][0]
            for i, image in images.items():
                shifts = fft.ifft(image, axis=-2, overwrite_x=True)[:, :ny]
                found[i] += sum(map(np.multiply, waves, shifts))
        return np.asarray(fft.irfft(found, box[1], axis=-1)[..., : self.shape[1]])

    def _part(self, rows: tuple[int, ...], columns: tuple[int, ...]) -> GridOperator:
        chosen = {
            (half_turns, rows.index(i), columns.index(j)): tables
            for (half_turns, i, j), tables in self.harmonics.items()
            if i in rows and j in columns
        }
        return ConformalOperator(self.shape, self.table[np.ix_(rows, columns)], self.angles, chosen)

    def symmetric_part(self, sign: float = 1.0) -> ConformalOperator:
        found: Harmonics = {}
        for half_turns, i, j in {*self.harmonics, *((m, j, i) for m, i, j in self.harmonics)}:
            own = self.harmonics.get((half_turns, i, j), (None, None))
            other = self.harmonics.get((half_turns, j, i), (None, None))
            turned = [None if table is None else table[::-1, ::-1] for table in other]
            found[half_turns, i, j] = (_mean(own[0], turned[0], sign), _mean(own[1], turned[1], -sign))
        table = super().symmetric_part(sign).table
        return ConformalOperator(self.shape, table, self.angles, found)

    def has_mirror(self, first: int, last: int) -> bool:
        """Whether inclinations of the rows from `first` to `last` are odd about their middle."""
        sums = self.angles[first : last + 1] + self.angles[first : last + 1][::-1]
        return bool(np.ptp(sums) <= STRAIGHT)

    @cached_property
    def _single_transforms(self) -> Transforms:
        return {
            half_turns: {at: [None if each is None else each.astype(np.complex64) for each in own] for at, own in found}
            for half_turns, found in ((m, blocks.items()) for m, blocks in self._transforms.items())
        }

    @cached_property
    def _transforms(self) -> Transforms:
        from scipy import fft

        box = fft_box(*self.shape)
        symbols: Transforms = {}
        for (half_turns, i, j), tables in self.harmonics.items():
            own = [None if table is None else fft.rfft2(wrapped(table, box)) for table in tables]
            symbols.setdefault(half_turns, {})[i, j] = own
        return symbols


def in_blocks(blocks: list[list[GridOperator]]) -> GridOperator:
    """Operators on one surface as a single one, by rows of blocks."""
    first, harmonics, transforms, row = blocks[0][0], Harmonics(), Transforms(), 0
    table = np.concatenate([np.concatenate([block.table for block in line], axis=1) for line in blocks])
    if not isinstance(first, ConformalOperator):
        whole = GridOperator(first.shape, table)
        symbols = [np.concatenate([block._symbol for block in line], axis=1) for line in blocks]
        whole.__dict__["_symbol"] = np.concatenate(symbols)
        return whole
    for line in blocks:
        column = 0
        for block in line:
            assert isinstance(block, ConformalOperator)
            harmonics |= {(m, row + i, column + j): tables for (m, i, j), tables in block.harmonics.items()}
            for m, own in block._transforms.items():
                transforms.setdefault(m, {}).update({(row + i, column + j): each for (i, j), each in own.items()})
            column += block.table.shape[1]
        row += line[0].table.shape[0]
    varying = ConformalOperator(first.shape, table, first.angles, harmonics)
    varying.__dict__["_transforms"] = transforms
    return varying


def _mean(table: np.ndarray | None, other: np.ndarray | None, sign: float) -> np.ndarray | None:
    if table is None:
        return None if other is None else sign * other / 2
    return table / 2 if other is None else (table + sign * other) / 2
