"""Overlap of the bodies outside the potential contact: where there is any, the grid does not hold
the contact.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from varcontact.discrete.contact_grid import Box, contact_box, within_samples
from varcontact.discrete.discretisation import Discretisation
from varcontact.discrete.state import ContactState, as_solved, unloaded
from varcontact.scene.given_bodies import GivenBodies
from varcontact.scene.grid import Grid
from varcontact.scene.surfaces import SampledDistance, Surface

INTERPOLATION_ERROR = 0.03
"""Least overlap of samples that counts, divided by the approach per element across; displacements
interpolated linearly between element centres have a smaller error."""


def outside(disc: Discretisation, state: ContactState, closed_form: bool = False) -> Box | None:
    """The box of the places outside the potential contact where the bodies would overlap, or None.

    The search covers the lattice one element further, where the contact reaches the edge of the
    potential contact; and all samples outside, where a sampled distance has its own coordinates.
    Where the pressure was solved on parts of the elements, the next parts are examined.
    """
    if disc.subgrid is None:
        box = _beyond(disc, state, closed_form)
    else:
        parts, pressure, approach = as_solved(disc, state.pressure, state.approach)
        solved = replace(unloaded(parts.grid), pressure=pressure, approach=approach)
        box = _beyond(parts, solved, closed_form)
        # centres of parts may lie beyond the samples
        if box is None and _beyond_samples(parts.surface, parts.grid, pressure > 0):
            box = contact_box(parts.grid, pressure)
    if box is None:
        box = _overlapping_samples(disc, state)
    return box


def _beyond_samples(surface: Surface, grid: Grid, elements: np.ndarray) -> bool:
    """True if a centre of the marked elements of a grid lies beyond the samples of a surface."""
    if not isinstance(surface, SampledDistance) or surface.x is None:
        return False
    left, right, bottom, top = surface.box
    slack = 1e-9 * max(grid.sides)
    x = grid.x[elements.any(axis=0)]
    y = grid.y[elements.any(axis=1)]
    along_x = left - slack <= x[0] and x[-1] <= right + slack
    return not (along_x and bottom - slack <= y[0] and y[-1] <= top + slack)


def _beyond(disc: Discretisation, state: ContactState, closed_form: bool) -> Box | None:
    """The box of the next elements outside the potential contact where the bodies would overlap, or
    None.
    """
    if not ((state.pressure > 0) & _rim(disc.grid)).any():
        return None
    grid = disc.grid.extended()
    if disc.grid.periodic:
        return None
    if isinstance(disc.bodies, GivenBodies) and not disc.bodies.reaches(grid):
        return None
    if closed_form:
        assert disc.hertz is not None
        overlap = disc.hertz.on_elements(grid) > 0
    else:
        overlap = _distance_around(disc, state, grid) < -1e-9 * abs(state.approach)
    overlap &= _rim(grid)
    if not overlap.any():
        return None
    box = contact_box(grid, overlap)
    if _beyond_samples(disc.surface, grid, overlap):
        return box
    return within_samples(box, disc.surface)


def _distance_around(disc: Discretisation, state: ContactState, grid: Grid) -> np.ndarray:
    """Deformed distance on a grid one element wider, dimensionless."""
    around = disc.operators.of(disc.operators.medium, disc.lattice.extended())
    undeformed = (_distance_beyond(disc, grid) - disc.base) / disc.scales.displacement
    distance = undeformed - state.approach
    # by pressures, by tractions of unlike bodies, by past tractions on viscoelastic ones
    margin = [(0, 0), (1, 1), (1, 1)]
    if grid.line:
        margin[1] = (0, 0)
    distance = distance + around.normal.apply(np.pad(state.pressure[None], margin))[0]
    if disc.K != 0 and np.any(state.traction):
        by_traction = around.traction_to_distance.apply(np.pad(state.traction, margin))[0]
        distance = distance + by_traction
    previous = disc.loading.previous_step
    if previous is not None and previous.distance is not None:
        distance = distance + previous.distance
    return distance


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
    near_contact = binary_dilation(np.pad(state.pressure > 0, 2), np.ones((3, 3)))
    all_x, all_y = surface.coordinates
    dx, dy = disc.grid.sides
    x0, _, y0, _ = disc.grid.box
    column = np.clip(np.floor((all_x - x0) / dx).astype(int) + 2, 0, near_contact.shape[1] - 1)
    row = np.clip(np.floor((all_y - y0) / dy).astype(int) + 2, 0, near_contact.shape[0] - 1)
    # samples that may overlap: pressures only push the surfaces apart, but beside the load on a
    # layer that keeps its volume
    highest = 0.0
    if disc.operators.normal.smallest < 0 or (disc.K != 0 and np.any(state.traction)):
        highest = abs(state.approach)
    distance = (surface.samples - disc.base) / disc.scales.displacement - state.approach
    if disc.loading.beside is not None:
        raised = disc.loading.beside.distance_at(all_x[None, :], all_y[:, None])
        distance = distance + raised / disc.scales.displacement
    iy, ix = np.nonzero((distance < highest) & ~near_contact[np.ix_(row, column)])
    if not iy.size:
        return None
    # those that do, with the displacements
    undeformed = distance[iy, ix]
    x, y = all_x[ix], all_y[iy]
    raised = _between_centres(disc, state, x / disc.scales.length, y / disc.scales.length)
    tolerance = INTERPOLATION_ERROR / max(disc.grid.shape) * abs(state.approach)
    overlap = undeformed + raised < -tolerance
    if not overlap.any():
        return None
    x, y = x[overlap], y[overlap]
    return float(x.min()), float(x.max()), float(y.min()), float(y.max())


def _between_centres(
    disc: Discretisation, state: ContactState, x: np.ndarray, y: np.ndarray
) -> np.ndarray:
    """Normal displacement difference at points, by FFT, linear between the elements' centres."""
    from scipy.ndimage import map_coordinates

    lattice = disc.lattice
    ny, nx = disc.grid.shape
    # a window of the lattice around grid and points
    column = (x - lattice.x[0]) / lattice.sides[0]
    row = np.zeros(x.shape)
    if not lattice.line:
        row = (y - lattice.y[0]) / lattice.sides[1]
    left = min(0, math.floor(column.min()))
    right = max(math.ceil(column.max()) + 1, nx)
    bottom = min(0, math.floor(row.min()))
    top = max(math.ceil(row.max()) + 1, ny)
    # displacements in that window
    fields = np.concatenate([state.traction, state.pressure[None]])
    fields = np.pad(fields, ((0, 0), (-bottom, top - ny), (-left, right - nx)))
    window = lattice.window(left, right, bottom, top)
    operators = disc.operators.of(disc.operators.medium, window)
    raised = operators.normal.apply(fields[2:])
    if disc.K != 0:
        raised = raised + operators.traction_to_distance.apply(fields[:2])
    return np.asarray(map_coordinates(raised[0], [row - bottom, column - left], order=1))


def _distance_beyond(disc: Discretisation, grid: Grid) -> np.ndarray:
    """Undeformed distance on a grid one element wider: known, or extrapolated from the samples."""
    surface = disc.surface
    if not isinstance(surface, SampledDistance) or surface.x is not None:
        return disc.undeformed_distance(grid, beyond=math.inf)
    # samples without coordinates: extrapolated, quadratic, or of few layers linear or constant
    distance = disc.distance
    axes = [0, 1]
    if grid.line:
        axes = [1]
    for axis in axes:
        weights = ((1,), (2, -1), (3, -3, 1))[min(3, distance.shape[axis]) - 1]
        before = sum(weight * np.take(distance, [k], axis) for k, weight in enumerate(weights))
        after = sum(weight * np.take(distance, [-1 - k], axis) for k, weight in enumerate(weights))
        distance = np.concatenate([before, distance, after], axis=axis)
    return distance
