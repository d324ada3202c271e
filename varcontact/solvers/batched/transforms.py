"""Transforms of many small fields by dense matrices of cosines and sines, two
products of matrices each.

Influence numbers are even or odd along x and y, so that their transforms are
real. On fewer than some 40 elements a side this takes less time than FFT.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache, partial
from typing import Any

import numpy as np

from varcontact.solvers.newton.kernel import CAUSAL, parzen


@dataclass(frozen=True, eq=False)
class Transforms:
    """Matrices of a lattice's transforms, in single and double precision: `along_x` and `along_y`
    of what they name.
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
        ways = (self.even, self.odd, self.even)
        return np.stack(
            [rows_then_columns(each, way) for each, way in zip(numbers, ways, strict=True)]
        )


@lru_cache(maxsize=32)
def transforms(ny: int, nx: int, ahead: tuple[tuple[int, float], ...]) -> Transforms:
    """The difference over a step is in the way back: a displacement k elements ahead has its own
    cosines.
    """
    farthest = nx - 1 + max(abs(k) for k, _ in ahead)
    rows, columns = np.arange(ny), np.arange(farthest + 1)
    wave_y, wave_x = 2 * np.pi * rows / (2 * ny - 1), 2 * np.pi * columns / (2 * farthest + 1)
    twice_y, twice_x = np.where(rows == 0, 1, 2), np.where(columns == 0, 1, 2)
    x, signs = np.arange(nx), (1, -1)

    def both(wave: np.ndarray, places: np.ndarray, sign: int) -> np.ndarray:
        return np.concatenate(
            [np.cos(np.outer(wave, places)), sign * np.sin(np.outer(wave, places))]
        )

    to_x = np.array([both(wave_x, x, sign) for sign in signs])[:, None]
    to_y = np.array([both(wave_y, rows, sign) for sign in signs])
    weight_x, weight_y = (
        np.tile(twice_x / (2 * farthest + 1), 2),
        np.tile(twice_y / (2 * ny - 1), 2),
    )
    from_x = np.array(
        [
            np.sum([w * both(wave_x, x + k, sign) for k, w in ahead], axis=0).T * weight_x
            for sign in signs
        ]
    )[:, None]
    from_y = np.array([both(wave_y, rows, sign).T * weight_y for sign in signs])

    period_y, period_x = ny | 1, nx | 1
    low_y, low_x = (
        2 * np.pi * np.arange(period // 2 + 1) / period for period in (period_y, period_x)
    )
    causal = 1.0 if len(ahead) == 1 else CAUSAL
    offsets = np.arange(1 - nx, nx)
    wave = np.outer(low_x, offsets)
    kernel = (
        np.concatenate([np.cos(wave), -np.sin(wave)])
        * parzen(offsets / period_x)
        * causal ** (-offsets / period_x)
    )
    stepped, stepped_odd = (np.zeros((2 * nx - 1, farthest + 1)) for _ in range(2))
    for k, w in ahead:
        at = np.arange(2 * nx - 1), np.abs(offsets + k)
        np.add.at(stepped, at, w)
        np.add.at(stepped_odd, at, w * np.sign(offsets + k))
    window = parzen(rows / period_y)
    growth = causal ** (-x / period_x)
    cos, sin = np.cos(np.outer(low_x, x)), np.sin(np.outer(low_x, x))
    into_x = np.array([np.concatenate([cos, -sin]), np.concatenate([sin, cos])])[:, None]
    into_y = np.array([both(low_y, rows, sign) for sign in signs])
    share_x, share_y = (np.where(np.arange(len(low)) == 0, 1, 2) for low in (low_x, low_y))
    out_x = np.swapaxes(into_x / growth, -1, -2) * np.tile(share_x / period_x, 2)
    out_y = np.swapaxes(into_y, -1, -2) * np.tile(share_y / period_y, 2)

    def of(kind: type, *matrices: np.ndarray) -> Any:
        return tuple(np.ascontiguousarray(each, kind) for each in matrices)

    single, double = partial(of, np.float32), partial(of, np.float64)
    low_rows = np.outer(low_y, rows)
    return Transforms(
        even=double(
            np.cos(np.outer(wave_x, columns)) * twice_x, np.cos(np.outer(wave_y, rows)) * twice_y
        ),
        odd=double(np.sin(np.outer(wave_x, columns)) * 2, np.sin(np.outer(wave_y, rows)) * 2),
        forward=(single(to_x, to_y), double(to_x, to_y)),
        backward=(single(from_x, from_y), double(from_x, from_y)),
        windowed_even=single(kernel @ stepped, np.cos(low_rows) * twice_y * window),
        windowed_odd=single(kernel @ stepped_odd, np.sin(low_rows) * 2 * window),
        periodic=single(into_x * growth, into_y),
        unperiodic=single(out_x, out_y),
        columns=farthest + 1,
    )


def rows_then_columns(field: np.ndarray, matrices: tuple[np.ndarray, np.ndarray]) -> np.ndarray:
    """A transform of fields (..., ny, nx, n), along x first."""
    field = np.matmul(matrices[0], field)
    shape = field.shape
    return np.matmul(matrices[1], field.reshape(*shape[:-2], -1)).reshape(
        *shape[:-3], -1, *shape[-2:]
    )


def columns_then_rows(field: np.ndarray, matrices: tuple[np.ndarray, np.ndarray]) -> np.ndarray:
    """A transform of fields (..., ny, nx, n), along y first."""
    shape = field.shape
    field = np.matmul(matrices[1], field.reshape(*shape[:-2], -1)).reshape(
        *shape[:-3], -1, *shape[-2:]
    )
    return np.matmul(matrices[0], field)
