"""Fields of one grid on another."""

from __future__ import annotations

import numpy as np

from varcontact.scene.grid import Grid


def same_lattice(one: Grid, other: Grid) -> bool:
    """Whether two lattices are the same but for rounding."""
    size = max(abs(side) for side in other.box)
    return one.shape == other.shape and bool(np.allclose(one.box, other.box, rtol=0, atol=1e-9 * size))


def sampled(grid: Grid, field: np.ndarray, other: Grid) -> np.ndarray:
    """A field (ny, nx) in the elements where the centres of another grid lie; zero outside."""
    x0, _, y0, _ = grid.box
    dx, dy = grid.sides
    ix = np.floor((other.x - x0) / dx).astype(int)
    iy = np.zeros(1, dtype=int) if grid.line else np.floor((other.y - y0) / dy).astype(int)
    inside = ((iy >= 0) & (iy < grid.rows))[:, None] & ((ix >= 0) & (ix < grid.nx))
    return np.where(inside, field[np.ix_(np.clip(iy, 0, grid.rows - 1), np.clip(ix, 0, grid.nx - 1))], 0)


def interpolated(grid: Grid, fields: np.ndarray, other: Grid) -> np.ndarray:
    """Fields (k, ny, nx), linearly, at the element centres of another grid; zero outside."""
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
