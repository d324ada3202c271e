"""Transports: how the particles of rolling bodies carry fields over a grid, from step to step."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

Join = Callable[[np.ndarray, np.ndarray], np.ndarray]
"""What a particle has after a step, from what it had and what the step does."""


def along_rows(own: np.ndarray, columns: float, fresh: float, join: Join) -> np.ndarray:
    """What particles have gathered on their way along the rows (..., ny, nx) in steady rolling.

    From what a step does, joined with what they had one step of so many columns before; where steps are
    shorter than a column, one column before.
    """
    nx = own.shape[-1]
    way = min(max(columns, 1.0), float(nx))
    whole = int(way)
    part = way % 1.0
    room = [(0, 0)] * (own.ndim - 1) + [(0, nx + 1)]
    gathered = np.pad(own, room, constant_values=fresh)
    for i in range(nx - 1, -1, -1):
        before = gathered[..., i + whole]
        if part:
            # linear between the centres of two elements
            before = before + part * (gathered[..., i + whole + 1] - before)
        gathered[..., i] = join(before, gathered[..., i])
    return np.asarray(gathered[..., :nx])


def further_along(field: np.ndarray, columns: float, beyond: float | None = 0.0) -> np.ndarray:
    """Values (..., ny, nx) so many columns further along x, linear between the centres of two elements.

    `beyond` is the value outside the grid; None: as at its end.
    """
    nx = field.shape[-1]
    columns = max(-nx - 1.0, min(nx + 1.0, columns))
    whole = math.floor(columns)
    room = [(0, 0)] * (field.ndim - 1) + [(nx + 1, nx + 2)]
    if beyond is None:
        padded = np.pad(field, room, mode="edge")
    else:
        padded = np.pad(field, room, constant_values=beyond)
    first = nx + 1 + whole
    near = padded[..., first : first + nx]
    if columns == whole:
        return near
    far = padded[..., first + 1 : first + 1 + nx]
    return np.asarray(near + (columns - whole) * (far - near))
