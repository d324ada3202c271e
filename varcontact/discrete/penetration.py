"""Where the bodies would overlap outside the potential contact: whether it holds the contact."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import replace

import numpy as np

from varcontact.discrete.contact_grid import Box, contact_box
from varcontact.discrete.discretisation import Discretisation, undeformed_distance
from varcontact.discrete.state import ContactState, as_solved, unloaded
from varcontact.elasticity.conformal import Conformal
from varcontact.elasticity.halfspace import HalfSpaces, Medium
from varcontact.elasticity.operators import influence_operator
from varcontact.scene.grid import Grid
from varcontact.scene.surfaces import SampledDistance

BLOCKS, BLUR = 16, 0.5
"""Blocks of elements across the grid that samples are sorted out by first, then twice and four times as many; and the
error of such displacements by the greatest depth, by one over the blocks across: four times what was measured."""
MOST_SAMPLES = 500
"""The lowest samples that displacements are found for exactly."""


def outside(disc: Discretisation, state: ContactState, closed_form: bool = False) -> Box | None:
    """The box of the places outside the potential contact where the bodies would overlap, or None.

    Looked for on the lattice one element further, where the contact reaches the potential contact's edge; and
    at all samples that lie outside, where a sampled distance has its own coordinates. Where the pressure was solved for
    on parts of the elements, the next parts are looked at.
    """
    if disc.subgrid is None:
        found = _beyond(disc, state, closed_form)
    else:
        parts, pressure, approach = as_solved(disc, state.pressure, state.approach)
        solved = replace(unloaded(parts.grid), pressure=pressure, approach=approach)
        found = _beyond(parts, solved, closed_form)
        if found is None and isinstance(parts.surface, SampledDistance):  # centres of parts may lie beyond the samples
            (left, right, bottom, top), grid = parts.surface.box, parts.grid
            x, y, slack = grid.x[None, :], grid.y[:, None], 1e-9 * max(grid.sides)
            within = (x >= left - slack) & (x <= right + slack) & (y >= bottom - slack) & (y <= top + slack)
            beyond = (solved.pressure > 0) & ~within
            found = contact_box(grid, beyond) if beyond.any() else None
    return _overlapping_samples(disc, state) if found is None else found


def _beyond(disc: Discretisation, state: ContactState, closed_form: bool) -> Box | None:
    """The box of the next elements outside the potential contact where the bodies would overlap, or None."""
    grid = disc.grid.extended()
    overlap = np.zeros(grid.shape, dtype=bool)
    if ((state.pressure > 0) & _rim(disc.grid)).any():
        if closed_form:
            assert disc.hertz is not None
            overlap = disc.hertz.on_elements(grid) > 0
        else:
            around = disc.operators.around
            distance = (_distance_beyond(disc, grid) - disc.base) / disc.scales.displacement - state.approach
            margin = ((0, 0), (0, 0) if grid.line else (1, 1), (1, 1))
            distance = distance + around.normal.apply(np.pad(state.pressure[None], margin))[0]
            if disc.K != 0 and np.any(state.traction):
                distance = distance + around.traction_to_distance.apply(np.pad(state.traction, margin))[0]
            if disc.loading.previous_step is not None and disc.loading.previous_step.distance is not None:
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
    surface = disc.surface
    if not isinstance(surface, SampledDistance) or not surface.placed:
        return None
    distance = (surface.samples - disc.base) / disc.scales.displacement - state.approach
    suspects = (distance < _lowered_at_most(disc, state)) & ~_near_contact(disc, state, surface)
    if not suspects.any():
        return None
    iy, ix = np.nonzero(suspects)
    (all_x, all_y), below = surface.coordinates, distance[iy, ix]
    x, y = all_x[ix] / disc.scales.length, all_y[iy] / disc.scales.length
    below = below + _lagging(disc, state, x, y)
    deepest, elements = float(np.abs(below).max()), max(disc.grid.shape)
    for across in sorted({min(blocks, elements) for blocks in (BLOCKS, 2 * BLOCKS, 4 * BLOCKS, elements)}):
        raised = below + _raised_about(disc, *_in_blocks(disc, state, across), x, y)
        doubtful = raised < BLUR / across * deepest
        x, y, below, raised = x[doubtful], y[doubtful], below[doubtful], raised[doubtful]
    lowest = np.argsort(raised)[:MOST_SAMPLES]
    x, y, below = x[lowest], y[lowest], below[lowest]
    raised = _displacement(_at_once(disc), disc.lattice, *_loaded(disc, state), x, y)
    over = below + raised < -1e-9 * abs(state.approach)
    if not over.any():
        return None
    x, y = x[over] * disc.scales.length, y[over] * disc.scales.length
    return float(x.min()), float(x.max()), float(y.min()), float(y.max())


def _in_blocks(disc: Discretisation, state: ContactState, across: int) -> tuple[np.ndarray, np.ndarray]:
    """Centres of load (2, n) of blocks of elements, so many `across` the grid at most, and loads along x, y, z."""
    centres, tractions = _loaded(disc, state)
    size = math.ceil(max(disc.grid.shape) / across)
    iy, ix = np.divmod(np.flatnonzero(state.pressure), disc.grid.nx)
    _, block = np.unique(iy // size * disc.grid.nx + ix // size, return_inverse=True)
    loads = np.array([np.bincount(block, each) for each in tractions * disc.lattice.area])
    return np.array([np.bincount(block, tractions[2] * each) for each in centres]) * disc.lattice.area / loads[2], loads


def _lowered_at_most(disc: Discretisation, state: ContactState) -> float:
    """How far tractions of unlike bodies draw the surfaces together, at most, an element or more away.

    Pressures only push them apart, but beside the load on a layer that keeps its volume.
    """
    by_pressure = float(state.pressure.sum()) * max(-float(disc.operators.normal.table.min()), 0.0)
    if disc.K == 0 or not np.any(state.traction):
        return by_pressure
    load, medium = float(np.hypot(*state.traction).sum()) * disc.lattice.area, disc.operators.medium
    if disc.grid.line:
        return by_pressure + abs(disc.K) * load
    nearest, K = np.pi * min(disc.lattice.sides), disc.K
    if isinstance(medium, Conformal):  # what turning adds falls by one over the distance, and grows by the angle
        K = abs(medium.flat.K) + medium.curvature * min(disc.lattice.sides)
    return by_pressure + abs(K) * load / nearest


def _loaded(disc: Discretisation, state: ContactState) -> tuple[np.ndarray, np.ndarray]:
    """Centres (2, n) of the contact elements, and their tractions along x, along y and z, (3, n)."""
    elements = np.flatnonzero(state.pressure)
    tractions = np.concatenate([state.traction, state.pressure[None]]).reshape(3, -1)
    return disc.points.reshape(2, -1)[:, elements], tractions[:, elements]


def _displacement(
    medium: Medium,
    lattice: Grid,
    centres: np.ndarray,
    loads: np.ndarray,
    x: np.ndarray,
    y: np.ndarray,
    forces: bool = False,
) -> np.ndarray:
    """Normal displacement difference at points, by loads (3, n) at some centres: tractions on elements, or `forces`."""
    where = lattice, x - centres[0][:, None], y - centres[1][:, None]
    turns, flat = isinstance(medium, Conformal), medium.flat if isinstance(medium, Conformal) else medium
    names = ("yx", "yy", "zz") if turns else ("zz",)
    if flat.K != 0:
        names = ("zx", "zy", "zz", *(("yx", "yy", "yz") if turns else ()))
    numbers = _by_forces(flat, *where, names) if forces else flat.influence(*where, names)
    if isinstance(medium, Conformal):
        return medium.normal_displacement(numbers, loads, centres[1], y)
    return np.sum([loads["xyz".index(name[1])] @ each for name, each in numbers.items()], axis=0)


def _at_once(disc: Discretisation) -> Medium:
    """The bodies without what lags behind, which pressures raise no less."""
    medium = disc.operators.medium
    glassy: Medium = medium if medium.even else getattr(medium, "glassy", medium)
    return glassy


def _lagging(disc: Discretisation, state: ContactState, x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """What viscoelastic bodies add to the normal displacement at points: smooth, and so linear between the centres."""
    medium, lattice = disc.operators.medium, disc.lattice
    if medium.even:
        return np.zeros(x.shape)
    from scipy.ndimage import map_coordinates

    (dx, dy), left, bottom = lattice.sides, lattice.x[0], lattice.y[0]
    column, row = (x - left) / dx, np.zeros(x.shape) if disc.grid.line else (y - bottom) / dy
    before = [max(0, math.ceil(-at.min())) for at in (row, column)]
    behind = [max(0, math.ceil(at.max()) - n + 1) for at, n in zip((row, column), lattice.shape, strict=True)]
    ny, nx = (n + sum(more) for n, *more in zip(lattice.shape, before, behind, strict=True))
    wider = replace(lattice, nx=nx, ny=None if disc.grid.line else ny)
    fields = np.pad(
        state.pressure[None] if disc.K == 0 else np.concatenate([state.traction, state.pressure[None]]),
        ((0, 0), *zip(before, behind, strict=True)),
    )
    loads = "z" if disc.K == 0 else "xyz"
    whole, at_once = (
        influence_operator(wider, "z", loads, medium=each).apply(fields) for each in (medium, _at_once(disc))
    )
    return np.asarray(map_coordinates((whole - at_once)[0], [row + before[0], column + before[1]], order=1))


def _near_contact(disc: Discretisation, state: ContactState, surface: SampledDistance) -> np.ndarray:
    """The samples in contact elements and in those next to them, where displacements are known at centres only."""
    x, y = surface.coordinates
    wide = np.pad(state.pressure > 0, 2)
    shifts = [(i, j) for i in (-1, 0, 1) for j in (-1, 0, 1)]
    near = np.any([np.roll(wide, shift, axis=(0, 1)) for shift in shifts], axis=0)
    (dx, dy), (x0, _, y0, _) = disc.grid.sides, disc.grid.box
    column = np.clip(np.floor((x - x0) / dx).astype(int) + 2, 0, wide.shape[1] - 1)
    row = np.clip(np.floor((y - y0) / dy).astype(int) + 2, 0, wide.shape[0] - 1)
    return np.asarray(near[np.ix_(row, column)])


def _raised_about(
    disc: Discretisation, centres: np.ndarray, loads: np.ndarray, x: np.ndarray, y: np.ndarray
) -> np.ndarray:
    """Normal displacement difference at points away from the contact, by point or line forces at some centres."""
    medium, raised = _at_once(disc), np.empty(x.size)
    for part in np.array_split(np.arange(x.size), 1 + x.size * loads.shape[1] // 200_000):
        raised[part] = _displacement(medium, disc.lattice, centres, loads, x[part], y[part], forces=True)
    return raised


def _by_forces(
    medium: Medium, lattice: Grid, x: np.ndarray, y: np.ndarray, components: Iterable[str]
) -> dict[str, np.ndarray]:
    """Displacements by a point or line force of one; of bodies that are no half-spaces by one on an element."""
    if not isinstance(medium, HalfSpaces):
        numbers = medium.influence(lattice, x, y, components)
        return {name: each / lattice.area for name, each in numbers.items()}
    x, y = x.astype(np.float32), y.astype(np.float32)
    nu, K, square = float(medium.nu), float(medium.K), x**2 + y**2
    if lattice.line:
        along = {
            "zz": lambda: -(1 - nu) * np.log(square / medium.depth**2) / np.pi,
            "zx": lambda: K * np.sign(x),
            "zy": lambda: 0.0 * square,
        }
        return {name: along[name]() for name in components}
    per_distance = 1 / (np.pi * np.sqrt(square))
    by_square = K / (np.pi * square)
    forms = {
        "xx": lambda: (1 - nu * y**2 / square) * per_distance,
        "yy": lambda: (1 - nu * x**2 / square) * per_distance,
        "xy": lambda: nu * x * y / square * per_distance,
        "zz": lambda: (1 - nu) * per_distance,
        "zx": lambda: x * by_square,
        "zy": lambda: y * by_square,
        "xz": lambda: -x * by_square,
        "yz": lambda: -y * by_square,
    }
    forms["yx"] = forms["xy"]
    return {name: forms[name]() for name in components}


def _distance_beyond(disc: Discretisation, grid: Grid) -> np.ndarray:
    """Undeformed distance on a grid one element wider: known, or extrapolated from the samples."""
    surface = disc.surface
    if not isinstance(surface, SampledDistance):
        return undeformed_distance(surface, disc.hertz, grid)
    if surface.placed:
        left, right, bottom, top = surface.box
        if grid.x[0] >= left and grid.x[-1] <= right and grid.y[0] >= bottom and grid.y[-1] <= top:
            return surface.distance(grid)
    distance = disc.distance
    for axis in (1,) if grid.line else (0, 1):
        distance = np.concatenate([_next(distance, axis, 0), distance, _next(distance, axis, -1)], axis=axis)
    return distance


def _next(values: np.ndarray, axis: int, end: int) -> np.ndarray:
    """One more layer by quadratic (or, of few layers, linear or constant) extrapolation."""
    layers = [np.take(values, [end + (k if end == 0 else -k)], axis=axis) for k in range(min(3, values.shape[axis]))]
    weights = {1: (1,), 2: (2, -1), 3: (3, -3, 1)}[len(layers)]
    return np.sum([w * layer for w, layer in zip(weights, layers, strict=True)], axis=0)
