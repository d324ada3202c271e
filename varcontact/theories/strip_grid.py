"""Strip theory and FaStrip on the elements of a grid, see `varcontact.theories.strip_theory`."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from varcontact.theories.simplified import PEAK
from varcontact.theories.strip_theory import SMALLEST, slip_depth, strip_creepages

if TYPE_CHECKING:
    from varcontact.scene.grid import Grid


def strip_on_grid(
    grid: Grid,
    a: float,
    b: float,
    G: float,
    limit: float,
    bound: np.ndarray,
    creepage: np.ndarray,
    factors: tuple[float, float, float],
    against: np.ndarray | None = None,
) -> tuple[np.ndarray, np.ndarray]:
    """Tractions of `strip` or of `fastrip` at the element centres of a grid, and where they slip.

    Parameters
    ----------
    grid : Grid
        An explicit lattice.
    a, b, G, limit : float
        As of `strip`.
    bound : ndarray, shape (ny, nx)
        Traction bound at the centres, Hertz's [force/area].
    creepage : ndarray, shape (3,)
        vx, vy [-] and spin [1/length].
    factors : tuple of float
        Of vx, vy and spin, see `kalker_factors`.
    against : ndarray, shape (2, ny, nx), optional
        Vectors against which the slip area's tractions point; the rigid slip if not given.

    Returns
    -------
    traction : ndarray, shape (2, ny, nx)
        On body 1 [force/area].
    slips : ndarray of bool, shape (ny, nx)
    """
    vx, vy, spin = creepage
    scaled = strip_creepages(a, b, G, limit, vx, vy, spin, factors)
    across, place = grid.y[:, None] / b, grid.x[None, :] / a
    edge = np.sqrt(np.maximum(1 - across**2, 0.0))
    x, turn = scaled.x - across * scaled.x_by_place, scaled.turn
    y = np.full_like(x, scaled.y)
    d = slip_depth(x, y, turn, edge)
    outer = np.sqrt(np.maximum(edge**2 - place**2, 0.0))
    inner = np.sqrt(np.maximum((edge - d) ** 2 - (place - d) ** 2, 0.0))
    slips = (place <= 2 * d - edge) & (bound > 0)
    # S - s by the difference of the squares
    less = 2 * (edge - place) / np.maximum(outer + inner, SMALLEST)
    sticking = -np.stack([less * x, less * (y + turn * d) + turn * inner]) * PEAK["elliptic"] * limit / (a * b)
    toward = np.stack(np.broadcast_arrays(x, y + turn * place)) if against is None else against
    size = np.hypot(*toward)
    sliding = -bound * toward / np.where(size > 0, size, 1.0)
    traction = np.where(slips, sliding, np.where(bound > 0, sticking, 0.0))
    size = np.hypot(*traction)
    return traction * np.minimum(1.0, bound / np.where(size > 0, size, 1.0)), slips
