"""Contact of a scene under a given pressure, or Hertz's: nothing is solved."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from varcontact import checks
from varcontact.discrete.discretisation import Discretisation, discretise
from varcontact.discrete.state import (
    ContactState,
    cells_of,
    hertz_pressure,
    means,
    unloaded,
    with_subgrid,
)
from varcontact.errors import SceneError
from varcontact.scene.grid import Grid
from varcontact.scene.scene import Scene

TRACTION_RANGE = 1e50
"""Largest accepted pressure or traction, divided by the scale of pressures: products of larger ones
overflow."""


def check_placed(scene: Scene, purpose: str) -> None:
    """Refuse a scene whose grid is not placed before it is solved."""
    placed = isinstance(scene.grid, Grid) and scene.grid.explicit
    if not placed and scene.hertz is None:
        allowed = f"explicit, with dx, dy, x0 and y0, {purpose}"
        raise SceneError("grid", scene.grid, allowed)


def contact_under(
    scene: Scene, grid: Grid, pressure: np.ndarray | None, traction: np.ndarray | None = None
) -> tuple[Discretisation, ContactState]:
    """The contact under a pressure [force/area], on the parts of its elements where these count in
    part; under Hertz's where none is given. Tractions change the approach of unlike bodies.
    """
    disc = discretise(scene, grid)
    scale = disc.scales.pressure
    state = unloaded(grid)
    if traction is not None:
        tractions = field_of("traction", traction, (2, *grid.shape), scale) / scale
        state = replace(state, traction=tractions)
    if pressure is None:
        return disc, hertz_pressure(disc, state)
    cells = cells_of(grid.edge, grid.line)
    pressures = field_of("pressure", pressure, grid.divided(cells).shape, scale)
    if np.any(pressures < 0) or not np.any(pressures):
        allowed = "zero or positive, and positive somewhere"
        raise SceneError("pressure", float(pressures.min()), allowed)
    base = disc.base
    if cells != (1, 1):
        disc = with_subgrid(disc, pressures)
    lattice = disc if disc.subgrid is None else disc.subgrid.disc
    pressures = pressures / scale

    # approach from the elements, or from their parts, that the pressure acts on
    acting = None
    if disc.K != 0:
        acting = state.traction
    problem = lattice.normal_problem(acting)
    approach = problem.mean_approach(pressures.ravel())
    approach += (lattice.base - base) / disc.scales.displacement
    return disc, replace(state, pressure=means(pressures, cells), approach=approach)


def field_of(name: str, values: np.ndarray, shape: tuple[int, ...], scale: float) -> np.ndarray:
    """Array of a shape, with values that are safe to compute with relative to the scale of
    pressures.
    """
    array = checks.array(name, values, shape=shape)
    largest = float(np.abs(array).max())
    if largest > TRACTION_RANGE * scale:
        raise SceneError(
            name,
            largest,
            f"at most {TRACTION_RANGE:g} times the contact's pressures, {scale:.3g}",
        )
    return array
