"""Fields of a solution on its elements, or on their parts where it was corrected, as pictures show them."""

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
class FinestFields:
    """Fields of a solution on its elements, or on their parts where it was corrected, with the shapes of `Solution`.

    The traction bound may be known on another grid only. `parts` says into what each element is divided.
    """

    grid: Grid
    traction: np.ndarray
    slip: np.ndarray
    power_density: np.ndarray
    state: np.ndarray
    bound_grid: Grid
    bound: np.ndarray
    parts: str = ""


def finest_fields(sol: Solution) -> FinestFields:
    """The fields of a solution on the finest grid that it has them on."""
    found, bounds = sol.refinement, (sol.grid, sol.traction_bound)
    if found is None or not sol.pressure.any():
        return FinestFields(sol.grid, sol.traction, sol.slip, sol.power_density, sol.state, *bounds)
    rows, columns = found.cells
    parts = f"{columns}" if sol.scene.line else f"{columns} x {rows}"
    fields = found.grid, found.traction, found.slip, found.power_density
    hertz, friction = sol.scene.hertz, sol.scene.friction if sol.friction is None else sol.friction
    if hertz is None or not sol.plan.closed_form or friction is None:
        state = np.where(found.traction.any(axis=0), _on_parts(found, sol.state, sol.state), EXTERIOR)
        return FinestFields(*fields, state, *bounds, parts)
    pressure = hertz.mean_pressure(*found.grid.lines)
    coefficient = np.broadcast_to(np.asarray(friction, dtype=float), sol.grid.shape)
    known = sol.pressure > 0 if sol.friction is not None else np.ones(sol.grid.shape)
    bound = np.zeros(found.grid.shape)
    np.multiply(_on_parts(found, coefficient, known), pressure, out=bound, where=pressure > 0)
    slips = np.hypot(*found.traction) >= REACHED * bound
    inside = hertz.pressure(found.grid.x[None, :], found.grid.y[:, None]) > 0  # the centre tells, as of elements
    state = np.where(inside, np.where(slips, SLIP, STICK), EXTERIOR)
    return FinestFields(*fields, state, found.grid, bound, parts)


def _on_parts(found: Refinement, values: np.ndarray, known: np.ndarray) -> np.ndarray:
    """Values of elements (ny, nx) on their parts; where they are not `known`, those of the nearest where they are."""
    from scipy.ndimage import distance_transform_edt

    rows, columns = found.cells
    nearest = distance_transform_edt(np.asarray(known) == 0, return_distances=False, return_indices=True)
    return np.repeat(np.repeat(values[tuple(nearest)], rows, axis=0), columns, axis=1)
