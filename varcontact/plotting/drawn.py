"""What pictures of tractions show: the elements, or their parts where a solution was corrected."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from varcontact.discrete.stick_slip import EXTERIOR, SLIP, STICK
from varcontact.results.refinement import Refinement
from varcontact.results.solution import Solution
from varcontact.scene.grid import Grid

REACHED = 0.88
"""Part of its bound from which on the traction on a part of an element slips: beside edges interpolated ones miss it.

Of nine scenes on 12 and 20 elements 3 and 2 per cent of the parts then differ from grids of 96, 7 and 4 by the state
of their elements; the fewest of all numbers from 0.75 to 1.
"""


@dataclass(frozen=True, eq=False)
class Drawn:
    """Fields on a grid, as of `Solution`.

    Attributes
    ----------
    grid : Grid
        Explicit: the elements, or their parts.
    traction, slip : ndarray, shape (2, ny, nx)
    power_density : ndarray, shape (ny, nx)
    state : ndarray, shape (ny, nx)
    bounds : tuple of Grid and ndarray
        The traction bound, and the elements or parts that it is known on.
    words : str
        For titles: what each element is divided into; empty where it is not.
    """

    grid: Grid
    traction: np.ndarray
    slip: np.ndarray
    power_density: np.ndarray
    state: np.ndarray
    bounds: tuple[Grid, np.ndarray]
    words: str = ""


def drawn(sol: Solution) -> Drawn:
    """The fields of a solution that its pictures show.

    Parameters
    ----------
    sol : Solution
    """
    found, bounds = sol.refinement, (sol.grid, sol.traction_bound)
    if found is None or not sol.pressure.any():
        return Drawn(sol.grid, sol.traction, sol.slip, sol.power_density, sol.state, bounds)
    rows, columns = found.cells
    parts = f"{columns}" if sol.scene.line else f"{columns} x {rows}"
    words = f"\n(corrected, on {parts} parts)"
    bound = _bound_on_parts(sol, found)
    if bound is None:
        state = np.where(found.traction.any(axis=0), _on_parts(found, sol.state, sol.state), EXTERIOR)
        return Drawn(found.grid, found.traction, found.slip, found.power_density, state, bounds, words)
    slips = np.hypot(*found.traction) >= REACHED * bound
    hertz = sol.scene.hertz
    assert hertz is not None
    inside = hertz.pressure(found.grid.x[None, :], found.grid.y[:, None]) > 0  # the centre tells, as of elements
    state = np.where(inside, np.where(slips, SLIP, STICK), EXTERIOR)
    return Drawn(found.grid, found.traction, found.slip, found.power_density, state, (found.grid, bound), words)


def _bound_on_parts(sol: Solution, found: Refinement) -> np.ndarray | None:
    """The traction bound on the parts, (ny, nx), where Hertz tells the pressure there; otherwise None."""
    hertz, friction = sol.scene.hertz, sol.scene.friction if sol.friction is None else sol.friction
    if hertz is None or not sol.plan.closed_form or friction is None:
        return None
    pressure = hertz.mean_pressure(*found.grid.lines)
    coefficient = np.broadcast_to(np.asarray(friction, dtype=float), sol.grid.shape)
    known = sol.pressure > 0 if sol.friction is not None else np.ones(sol.grid.shape)
    bound = np.zeros(found.grid.shape)
    np.multiply(_on_parts(found, coefficient, known), pressure, out=bound, where=pressure > 0)
    return bound


def _on_parts(found: Refinement, values: np.ndarray, known: np.ndarray) -> np.ndarray:
    """Values of elements (ny, nx) on their parts; where they are not `known`, those of the nearest where they are."""
    from scipy.ndimage import distance_transform_edt

    rows, columns = found.cells
    nearest = distance_transform_edt(np.asarray(known) == 0, return_distances=False, return_indices=True)
    return np.repeat(np.repeat(values[tuple(nearest)], rows, axis=0), columns, axis=1)
