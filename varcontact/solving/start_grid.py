"""Fields of the grid of a start on that of a history."""

from __future__ import annotations

import numpy as np

from varcontact.scene.grid import Grid


def words(grid: Grid) -> str:
    """A grid in words, for messages.

    Parameters
    ----------
    grid : Grid
    """
    return f"{grid.nx} x {grid.rows} elements over {tuple(float(f'{side:.6g}') for side in grid.box)}"


def same(one: Grid, other: Grid) -> bool:
    """Whether two lattices are the same but for rounding.

    Parameters
    ----------
    one, other : Grid
    """
    size = max(abs(side) for side in other.box)
    return one.shape == other.shape and bool(np.allclose(one.box, other.box, rtol=0, atol=1e-9 * size))


def sampled(grid: Grid, field: np.ndarray, other: Grid) -> np.ndarray:
    """A field of one grid in the elements where the centres of another lie; zero outside.

    Parameters
    ----------
    grid : Grid
    field : ndarray, shape (ny, nx)
        In any unit.
    other : Grid
    """
    x0, _, y0, _ = grid.box
    dx, dy = grid.sides
    ix = np.floor((other.x - x0) / dx).astype(int)
    iy = np.zeros(1, dtype=int) if grid.line else np.floor((other.y - y0) / dy).astype(int)
    inside = ((iy >= 0) & (iy < grid.rows))[:, None] & ((ix >= 0) & (ix < grid.nx))
    return np.where(inside, field[np.ix_(np.clip(iy, 0, grid.rows - 1), np.clip(ix, 0, grid.nx - 1))], 0)


def interpolated(grid: Grid, fields: np.ndarray, other: Grid) -> np.ndarray:
    """Fields of one grid, linearly, at the element centres of another; zero outside.

    Parameters
    ----------
    grid : Grid
    fields : ndarray, shape (k, ny, nx)
        In any unit.
    other : Grid
    """
    along = _between(fields, grid.x, other.x)
    return along if grid.line else np.swapaxes(_between(np.swapaxes(along, -1, -2), grid.y, other.y), -1, -2)


def _between(fields: np.ndarray, known: np.ndarray, places: np.ndarray) -> np.ndarray:
    """Fields along their last axis, linear between `known`, equally spaced places, and zero beyond these."""
    if len(known) == 1:
        return np.where(places == known, fields, 0.0)
    at = (places - known[0]) / (known[1] - known[0])
    before = np.clip(np.floor(at).astype(int), 0, len(known) - 2)
    part = at - before
    values = fields[..., before] * (1 - part) + fields[..., before + 1] * part
    return np.where((places < known[0]) | (places > known[-1]), 0.0, values)
