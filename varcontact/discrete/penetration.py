"""Where the bodies would overlap outside the potential contact: whether it holds the contact."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from varcontact.discrete.contact_grid import Box, contact_box
from varcontact.discrete.discretisation import Discretisation, undeformed_distance
from varcontact.discrete.operators import Operators
from varcontact.discrete.state import ContactState, as_solved, unloaded
from varcontact.scene.grid import Grid
from varcontact.scene.surfaces import SampledDistance

BETWEEN_CENTRES = 0.03
"""Overlap of samples that counts, by the approach, in one over the elements across: displacements
that are linear between the elements' centres are off by less."""


def outside(disc: Discretisation, state: ContactState, closed_form: bool = False) -> Box | None:
    """The box of the places outside the potential contact where the bodies would overlap, or None.

    Looked for on the lattice one element further, where the contact reaches the potential contact's
    edge; and at all samples that lie outside, where a sampled distance has its own coordinates.
    Where the pressure was solved for on parts of the elements, the next parts are looked at.
    """
    if disc.subgrid is None:
        found = _beyond(disc, state, closed_form)
    else:
        parts, pressure, approach = as_solved(disc, state.pressure, state.approach)
        solved = replace(unloaded(parts.grid), pressure=pressure, approach=approach)
        found = _beyond(parts, solved, closed_form)
        # centres of parts may lie beyond the samples
        if found is None and isinstance(parts.surface, SampledDistance):
            (left, right, bottom, top), grid = parts.surface.box, parts.grid
            x, y, slack = grid.x[None, :], grid.y[:, None], 1e-9 * max(grid.sides)
            within = (
                (x >= left - slack)
                & (x <= right + slack)
                & (y >= bottom - slack)
                & (y <= top + slack)
            )
            beyond = (solved.pressure > 0) & ~within
            found = contact_box(grid, beyond) if beyond.any() else None
    return _overlapping_samples(disc, state) if found is None else found


def _beyond(disc: Discretisation, state: ContactState, closed_form: bool) -> Box | None:
    """The box of the next elements outside the potential contact where the bodies would overlap, or
    None.
    """
    grid = disc.grid.extended()
    overlap = np.zeros(grid.shape, dtype=bool)
    if ((state.pressure > 0) & _rim(disc.grid)).any():
        if closed_form:
            assert disc.hertz is not None
            overlap = disc.hertz.on_elements(grid) > 0
        else:
            around = disc.operators.of(disc.operators.medium, disc.lattice.extended())
            distance = (
                _distance_beyond(disc, grid) - disc.base
            ) / disc.scales.displacement - state.approach
            margin = ((0, 0), (0, 0) if grid.line else (1, 1), (1, 1))
            distance = distance + around.normal.apply(np.pad(state.pressure[None], margin))[0]
            if disc.K != 0 and np.any(state.traction):
                distance = (
                    distance + around.traction_to_distance.apply(np.pad(state.traction, margin))[0]
                )
            if (
                disc.loading.previous_step is not None
                and disc.loading.previous_step.distance is not None
            ):
                distance = distance + disc.loading.previous_step.distance
            overlap = distance < -1e-9 * abs(state.approach)
        overlap &= _rim(grid)
    return contact_box(grid, overlap) if overlap.any() else None


def _rim(grid: Grid) -> np.ndarray:
    rim = np.ones(grid.shape, dtype=bool)
    rim[:, 1:-1] = not grid.line
    rim[1:-1, 1:-1] = False
    return rim


def _overlapping_samples(disc: Discretisation, state: ContactState) -> Box | None:
    """The box of the samples away from the contact elements where the bodies would overlap."""
    from scipy.ndimage import binary_dilation

    surface = disc.surface
    if not isinstance(surface, SampledDistance) or surface.x is None:
        return None
    # contact elements and those next to them are left out: there displacements are known at centres
    # only
    near = binary_dilation(np.pad(state.pressure > 0, 2), np.ones((3, 3)))
    (all_x, all_y), (dx, dy), (x0, _, y0, _) = surface.coordinates, disc.grid.sides, disc.grid.box
    column = np.clip(np.floor((all_x - x0) / dx).astype(int) + 2, 0, near.shape[1] - 1)
    row = np.clip(np.floor((all_y - y0) / dy).astype(int) + 2, 0, near.shape[0] - 1)
    # pressures only push the surfaces apart, but beside the load on a layer that keeps its volume
    drawn = disc.operators.normal.table.min() < 0 or (disc.K != 0 and np.any(state.traction))
    distance = (surface.samples - disc.base) / disc.scales.displacement - state.approach
    iy, ix = np.nonzero(
        (distance < (abs(state.approach) if drawn else 0.0)) & ~near[np.ix_(row, column)]
    )
    if not iy.size:
        return None
    below = distance[iy, ix]
    x, y = all_x[ix], all_y[iy]
    raised = _between_centres(disc, state, x / disc.scales.length, y / disc.scales.length)
    over = below + raised < -BETWEEN_CENTRES / max(disc.grid.shape) * abs(state.approach)
    if not over.any():
        return None
    return float(x[over].min()), float(x[over].max()), float(y[over].min()), float(y[over].max())


def _between_centres(
    disc: Discretisation, state: ContactState, x: np.ndarray, y: np.ndarray
) -> np.ndarray:
    """Normal displacement difference at points, by FFT, linear between the elements' centres."""
    from scipy.ndimage import map_coordinates

    lattice, (ny, nx) = disc.lattice, disc.grid.shape
    column = (x - lattice.x[0]) / lattice.sides[0]
    row = np.zeros(x.shape) if lattice.line else (y - lattice.y[0]) / lattice.sides[1]
    (left, right), (bottom, top) = (
        (min(0, math.floor(at.min())), math.ceil(at.max()) + 1) for at in (column, row)
    )
    right, top = max(right, nx), max(top, ny)
    fields = np.concatenate([state.traction, state.pressure[None]])
    fields = np.pad(fields, ((0, 0), (-bottom, top - ny), (-left, right - nx)))
    operators = Operators(lattice.window(left, right, bottom, top), disc.operators.medium)
    raised = operators.normal.apply(fields[2:])
    if disc.K != 0:
        raised = raised + operators.traction_to_distance.apply(fields[:2])
    return np.asarray(map_coordinates(raised[0], [row - bottom, column - left], order=1))


def _distance_beyond(disc: Discretisation, grid: Grid) -> np.ndarray:
    """Undeformed distance on a grid one element wider: known, or extrapolated from the samples."""
    surface = disc.surface
    if not isinstance(surface, SampledDistance):
        return undeformed_distance(surface, disc.hertz, grid)
    if surface.x is not None:
        left, right, bottom, top = surface.box
        if grid.x[0] >= left and grid.x[-1] <= right and grid.y[0] >= bottom and grid.y[-1] <= top:
            return surface.distance(grid)
    distance = disc.distance
    for axis in (1,) if grid.line else (0, 1):  # quadratic, or of few layers linear or constant
        weights = ((1,), (2, -1), (3, -3, 1))[min(3, distance.shape[axis]) - 1]
        before = sum(weight * np.take(distance, [k], axis) for k, weight in enumerate(weights))
        after = sum(weight * np.take(distance, [-1 - k], axis) for k, weight in enumerate(weights))
        distance = np.concatenate([before, distance, after], axis=axis)
    return distance
