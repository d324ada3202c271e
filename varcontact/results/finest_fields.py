"""Fields of a solution on its elements, or on their parts where it was corrected, as pictures show them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from varcontact.discrete.stick_slip import EXTERIOR
from varcontact.results.solution import Solution
from varcontact.scene.grid import Grid


@dataclass(frozen=True, eq=False)
class FinestFields:
    """Fields of a solution on its elements, or on their parts where it was corrected, with the shapes of `Solution`.

    The state of a part is that of its element, or of the nearest one. `parts` says into what each element is divided.
    """

    grid: Grid
    traction: np.ndarray
    slip: np.ndarray
    power_density: np.ndarray
    state: np.ndarray
    parts: str = ""


def finest_fields(sol: Solution) -> FinestFields:
    """The fields of a solution on the finest grid that it has them on."""
    found = sol.refinement
    if found is None or not sol.pressure.any():
        return FinestFields(sol.grid, sol.traction, sol.slip, sol.power_density, sol.state)
    from scipy.ndimage import distance_transform_edt

    rows, columns = found.cells
    nearest = distance_transform_edt(sol.state == EXTERIOR, return_distances=False, return_indices=True)
    state = sol.state[tuple(nearest)].repeat(rows, axis=0).repeat(columns, axis=1)
    state = np.where(found.traction.any(axis=0), state, EXTERIOR)
    parts = f"{columns}" if sol.scene.line else f"{columns} x {rows}"
    return FinestFields(found.grid, found.traction, found.slip, found.power_density, state, parts)
