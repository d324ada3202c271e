"""Transforms of many small fields by dense matrices of cosines and sines, two
products of matrices each.

Influence numbers are even or odd along x and y, so that their transforms are
real. On fewer than some 40 elements a side this takes less time than FFT.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np

from varcontact.solvers.newton.kernel import CAUSAL, parzen


@dataclass(frozen=True, eq=False)
class Transforms:
    """Matrices of a lattice's transforms, in pairs: along x, along y. Those of fields and
    displacements are in single and in double precision.
    """

    even: tuple[np.ndarray, np.ndarray]  # numbers by offset, even along both axes
    odd: tuple[np.ndarray, np.ndarray]
    # fields, by precision
    forward: tuple[tuple[np.ndarray, np.ndarray], tuple[np.ndarray, np.ndarray]]
    # displacements over the step
    backward: tuple[tuple[np.ndarray, np.ndarray], tuple[np.ndarray, np.ndarray]]
    windowed_even: tuple[np.ndarray, np.ndarray]  # numbers of the preconditioner
    windowed_odd: tuple[np.ndarray, np.ndarray]
    periodic: tuple[np.ndarray, np.ndarray]  # fields of the preconditioner, and back
    unperiodic: tuple[np.ndarray, np.ndarray]
    columns: int  # offsets along x from 0

    def symbol(self, numbers: np.ndarray) -> np.ndarray:
        """The transforms of influence numbers xx, xy and yy by offset, (3, ny, columns, n)."""
        return _by_component(numbers, self.even, self.odd)

    def windowed_symbol(self, numbers: np.ndarray) -> np.ndarray:
        """Transforms for the preconditioner, complex along x."""
        parts = _by_component(numbers, self.windowed_even, self.windowed_odd)
        half = parts.shape[2] // 2
        return parts[:, :, :half] + 1j * parts[:, :, half:]


def _by_component(
    numbers: np.ndarray, even: tuple[np.ndarray, np.ndarray], odd: tuple[np.ndarray, np.ndarray]
) -> np.ndarray:
    """Transforms of influence numbers: xx and yy are even along both axes, xy is odd."""
    xx, xy, yy = numbers
    return np.stack(
        [rows_then_columns(xx, even), rows_then_columns(xy, odd), rows_then_columns(yy, even)]
    )


SIGNS = (1, -1)
"""Signs of the sines in the transforms of two components: that of the second is reversed."""


@lru_cache(maxsize=32)
def transforms(ny: int, nx: int, ahead: tuple[tuple[int, float], ...]) -> Transforms:
    """The transforms of a lattice.

    The difference over a step is in the way back: a displacement k elements ahead has its own
    cosines.
    """
    farthest = nx - 1 + max(abs(k) for k, _ in ahead)
    x = np.arange(nx)
    rows = np.arange(ny)
    columns = np.arange(farthest + 1)
    wave_x = 2 * np.pi * columns / (2 * farthest + 1)
    wave_y = 2 * np.pi * rows / (2 * ny - 1)
    twice_x = np.where(columns == 0, 1, 2)
    twice_y = np.where(rows == 0, 1, 2)

    # tractions to waves
    to_x = np.array([_cosines_and_sines(wave_x, x, sign) for sign in SIGNS])[:, None]
    to_y = np.array([_cosines_and_sines(wave_y, rows, sign) for sign in SIGNS])
    # waves to displacements over the step
    weight_x = np.tile(twice_x / (2 * farthest + 1), 2)
    weight_y = np.tile(twice_y / (2 * ny - 1), 2)
    steps_x = []
    for sign in SIGNS:
        moved = [w * _cosines_and_sines(wave_x, x + k, sign) for k, w in ahead]
        steps_x.append(np.sum(moved, axis=0).T * weight_x)
    from_x = np.array(steps_x)[:, None]
    from_y = np.array([_cosines_and_sines(wave_y, rows, sign).T * weight_y for sign in SIGNS])
    # influence numbers to their symbol
    even_x = np.cos(np.outer(wave_x, columns)) * twice_x
    even_y = np.cos(np.outer(wave_y, rows)) * twice_y
    odd_x = np.sin(np.outer(wave_x, columns)) * 2
    odd_y = np.sin(np.outer(wave_y, rows)) * 2
    windowed_even, windowed_odd, periodic, unperiodic = _preconditioner(ny, nx, ahead, twice_y)
    return Transforms(
        even=_contiguous(np.float64, even_x, even_y),
        odd=_contiguous(np.float64, odd_x, odd_y),
        forward=(_contiguous(np.float32, to_x, to_y), _contiguous(np.float64, to_x, to_y)),
        backward=(_contiguous(np.float32, from_x, from_y), _contiguous(np.float64, from_x, from_y)),
        windowed_even=windowed_even,
        windowed_odd=windowed_odd,
        periodic=periodic,
        unperiodic=unperiodic,
        columns=farthest + 1,
    )


def _preconditioner(
    ny: int, nx: int, ahead: tuple[tuple[int, float], ...], twice_y: np.ndarray
) -> tuple[Any, Any, Any, Any]:
    """Matrices of the windowed numbers, even and odd, and of fields on the periodic box and
    back.
    """
    period_x = nx | 1
    period_y = ny | 1
    x = np.arange(nx)
    rows = np.arange(ny)
    low_x = 2 * np.pi * np.arange(period_x // 2 + 1) / period_x
    low_y = 2 * np.pi * np.arange(period_y // 2 + 1) / period_y
    # the kernel of a step along x, windowed and with the causal weight
    causal = 1.0 if len(ahead) == 1 else CAUSAL
    offsets = np.arange(1 - nx, nx)
    wave = np.outer(low_x, offsets)
    kernel = (
        np.concatenate([np.cos(wave), -np.sin(wave)])
        * parzen(offsets / period_x)
        * causal ** (-offsets / period_x)
    )
    farthest = nx - 1 + max(abs(k) for k, _ in ahead)
    stepped = np.zeros((2 * nx - 1, farthest + 1))
    stepped_odd = np.zeros((2 * nx - 1, farthest + 1))
    for k, w in ahead:
        at = np.arange(2 * nx - 1), np.abs(offsets + k)
        np.add.at(stepped, at, w)
        np.add.at(stepped_odd, at, w * np.sign(offsets + k))
    low_rows = np.outer(low_y, rows)
    window = parzen(rows / period_y)
    even_y = np.cos(low_rows) * twice_y * window
    odd_y = np.sin(low_rows) * 2 * window
    # fields to waves of the periodic box, and back
    growth = causal ** (-x / period_x)
    cos = np.cos(np.outer(low_x, x))
    sin = np.sin(np.outer(low_x, x))
    into_x = np.array([np.concatenate([cos, -sin]), np.concatenate([sin, cos])])[:, None]
    into_y = np.array([_cosines_and_sines(low_y, rows, sign) for sign in SIGNS])
    share_x = np.where(np.arange(len(low_x)) == 0, 1, 2)
    share_y = np.where(np.arange(len(low_y)) == 0, 1, 2)
    out_x = np.swapaxes(into_x / growth, -1, -2) * np.tile(share_x / period_x, 2)
    out_y = np.swapaxes(into_y, -1, -2) * np.tile(share_y / period_y, 2)
    return (
        _contiguous(np.float32, kernel @ stepped, even_y),
        _contiguous(np.float32, kernel @ stepped_odd, odd_y),
        _contiguous(np.float32, into_x * growth, into_y),
        _contiguous(np.float32, out_x, out_y),
    )


def _cosines_and_sines(wave: np.ndarray, places: np.ndarray, sign: int) -> np.ndarray:
    angle = np.outer(wave, places)
    return np.concatenate([np.cos(angle), sign * np.sin(angle)])


def _contiguous(kind: type, *matrices: np.ndarray) -> Any:
    return tuple(np.ascontiguousarray(matrix, kind) for matrix in matrices)


def rows_then_columns(field: np.ndarray, matrices: tuple[np.ndarray, np.ndarray]) -> np.ndarray:
    """A transform of fields (..., ny, nx, n), along x first."""
    return _along_y(np.matmul(matrices[0], field), matrices[1])


def columns_then_rows(field: np.ndarray, matrices: tuple[np.ndarray, np.ndarray]) -> np.ndarray:
    """A transform of fields (..., ny, nx, n), along y first."""
    return np.matmul(matrices[0], _along_y(field, matrices[1]))


def _along_y(field: np.ndarray, matrix: np.ndarray) -> np.ndarray:
    shape = field.shape
    product = np.matmul(matrix, field.reshape(*shape[:-2], -1))
    return product.reshape(*shape[:-3], -1, *shape[-2:])
