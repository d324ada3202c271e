"""The potential contact: how large it must be, and whether it holds the contact."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np

from varcontact import memory
from varcontact.clock import Clock
from varcontact.coupling import ContactState
from varcontact.discretisation import Discretisation, discretise
from varcontact.elasticity.halfspace import influence_numbers
from varcontact.elasticity.plane_strain import strip_influence_numbers
from varcontact.errors import SceneError
from varcontact.grid import Grid
from varcontact.motion import Transient
from varcontact.scene import Scene
from varcontact.steps import Steps, contact, unloaded
from varcontact.surfaces import SampledDistance, Surface

AUTO, AUTO_LINE = Grid(nx=24, ny=24), Grid(nx=100)
"""What grid="auto" stands for, in three dimensions and in line contact."""


MOVED = 0.1
"""Room on each side, by the contact's width, for what tractions of unlike bodies move it during a history."""

Box = tuple[float, float, float, float]


def first_grid(scene: Scene, pressure_on: Callable[[Discretisation], ContactState]) -> Grid:
    """An explicit grid for a scene: its own, or one across the bounding box of the contact.

    A Hertzian contact has its ellipse. For sampled distances the box is found by looks at the frictionless
    contact, first across all samples, then closer and closer.

    Parameters
    ----------
    scene : Scene
    pressure_on : callable
        Solves the frictionless normal problem of a discretisation.
    """
    spec = known_grid(scene)
    if spec.explicit:
        return spec
    surface = scene.surface
    assert isinstance(surface, SampledDistance)
    box = surface.box
    depth = None if scene.approach is None else surface.reference_depth  # which may lie within the samples
    for _ in range(60):
        look = Grid(nx=24, ny=None if scene.line else 24, margin=0).spread(box)
        lowest = _lowest_in_elements(surface, look, depth)
        state = pressure_on(discretise(replace(scene, surface=lowest, grid=look, motion=None, friction=None), look))
        contact = contact_box(look, state.pressure)
        if min(_across(state.pressure)) >= (1 if scene.line else 8) and max(_across(state.pressure)) >= 8:
            break
        box = _clipped(contact_box(look, state.pressure, around=1), surface)
    return within(spec.spread(contact), surface)


def wanted_grid(scene: Scene) -> Grid:
    """The grid that a scene asks for, in its own form; refused where not even fields on it fit into memory."""
    spec = _spec(scene)
    margin = 0 if spec.explicit else 2 * spec.margin
    size = 400.0 * (spec.nx + margin) * (spec.rows + (0 if spec.line else margin))
    memory.need("a grid of this size", size, "a grid with fewer elements would fit")
    return spec


def known_grid(scene: Scene) -> Grid:
    """The grid of a scene as far as it is known without a solution: of samples with coordinates not where it lies."""
    spec = wanted_grid(scene)
    hertz = None if spec.explicit else scene.hertz
    return spec if hertz is None else spec.spread((-hertz.a, hertz.a, -hertz.b, hertz.b))


def on_a_grid_that_holds_it(scene: Scene, steps: Steps) -> tuple[Discretisation, ContactState]:
    """Solve; where the contact goes on outside a grid of our choice, enlarge that and solve again.

    The contact without tangential tractions settles the grid; of unlike bodies it is then that with tractions.
    """
    closed_form, coupled = steps.plan.normal == "hertz", steps.plan.coupling != "none"
    with steps.clock("grid"):
        looks = Steps(replace(steps.plan, normal="norm"), 1e-6, True, Clock())
        grid = first_grid(scene, lambda disc: looks.pressure(disc, unloaded(disc.grid)))
    moved = 0
    for attempt in range(20):
        disc = discretise(scene, grid)
        state = steps.pressure(disc, unloaded(grid))
        with steps.clock("grid"):
            overlap = outside(disc, state, closed_form)
            closer = fitted(scene, grid, state.pressure) if attempt < 3 else None
        if (overlap is None and closer is None) or (coupled and moved):
            state = contact(disc, steps, state)
            if not coupled:
                return disc, state
            with steps.clock("grid"):
                overlap = outside(disc, state)
                closer = fitted(scene, grid, state.pressure, any_surface=True) if 0 < moved < 4 else None
            if overlap is None and closer is None:
                return disc, state
            moved += 1
        if overlap is not None:
            grid = enlarged(scene, grid, state.pressure, overlap, 0.1 * (moved > 0))
        elif closer is not None:
            grid = closer
    raise SceneError("grid", scene.grid, "explicit: no potential contact was found that holds the contact")


def common_grid(scene: Scene, grids: list[Grid]) -> Grid:
    """One grid for the contacts of a history without tractions: the scene's number of elements across all of them."""
    spec, margin = _spec(scene), _given(scene).margin
    if len(grids) == 1 and spec.margin == margin:
        return grids[0]
    boxes = np.array([_inner_box(grid, margin) for grid in grids])
    left, bottom = boxes[:, [0, 2]].min(axis=0)
    right, top = boxes[:, [1, 3]].max(axis=0)
    grid = spec.spread((float(left), float(right), float(bottom), float(top)))
    for surface in scene.surfaces:
        grid = within(grid, surface)
    return grid


def _inner_box(grid: Grid, margin: int) -> Box:
    """A grid's box without its margin."""
    rows = 0 if grid.line else margin
    return grid.window(margin, grid.nx - margin, rows, grid.rows - rows).box


def fitted(scene: Scene, grid: Grid, pressure: np.ndarray, any_surface: bool = False) -> Grid | None:
    """A grid that lies closer around the contact, where the scene's number of elements across it is not met.

    Hertzian contacts are where they are expected, unless `any_surface` says that tractions may have moved them.
    """
    spec, surface = _spec(scene), scene.surface
    columns, rows = _across(pressure)
    if spec.explicit or not (any_surface or isinstance(surface, SampledDistance)):
        return None
    if columns >= 0.93 * spec.nx and rows >= 0.93 * spec.rows:
        return None
    closer = spec.spread(contact_box(grid, pressure))
    return within(closer, surface)


def _spec(scene: Scene) -> Grid:
    """The grid in the scene's own form, with the margin that the contact needs to move in."""
    spec = _given(scene)
    if spec.explicit or not isinstance(scene.motion, Transient) or scene.bodies.K == 0 or scene.frictionless:
        return spec
    return replace(spec, margin=spec.margin + math.ceil(MOVED * max(spec.nx, spec.rows)))


def _given(scene: Scene) -> Grid:
    if isinstance(scene.grid, Grid):
        return scene.grid
    return AUTO_LINE if scene.line else AUTO


def _across(pressure: np.ndarray) -> tuple[int, int]:
    """Columns and rows with contact in them."""
    contact = pressure > 0
    return int(contact.any(axis=0).sum()), int(contact.any(axis=1).sum())


def _lowest_in_elements(surface: SampledDistance, grid: Grid, depth: float | None) -> SampledDistance:
    """The lowest distance known in each element: no summit falls between the centres of a coarse look."""
    distance = surface.distance(grid).copy()
    x, y = surface.coordinates
    (dx, dy), (x0, _, y0, _) = grid.sides, grid.box
    ix, iy = (np.floor((x - x0) / dx).astype(int), np.floor((y - y0) / dy).astype(int))
    ix[x == grid.box[1]], iy[y == grid.box[3]] = grid.nx - 1, grid.rows - 1
    columns, rows = (ix >= 0) & (ix < grid.nx), (iy >= 0) & (iy < grid.rows)
    flat = (iy[rows, None] * grid.nx + ix[None, columns]).ravel()
    np.minimum.at(distance.ravel(), flat, surface.samples[np.ix_(rows, columns)].ravel())
    return SampledDistance(distance[0] if grid.line else distance, reference_depth=depth)


def outside(disc: Discretisation, state: ContactState, closed_form: bool = False) -> Box | None:
    """The box of the places outside the potential contact where the bodies would overlap, or None.

    Looked for on the lattice one element further, where the contact reaches the potential contact's edge; and
    at all samples that lie outside, where a sampled distance has its own coordinates.

    Parameters
    ----------
    disc : Discretisation
    state : ContactState
    closed_form : bool
        Whether the pressure is Hertz's: then his ellipse tells.
    """
    contact = state.pressure > 0
    grid = disc.grid.extended()
    overlap = np.zeros(grid.shape, dtype=bool)
    if (contact & _rim(disc.grid)).any():
        if closed_form:
            assert disc.hertz is not None
            overlap = disc.hertz.pressure(grid.x[None, :], grid.y[:, None]) > 0
        else:
            overlap = _deformed_distance(disc, grid, state) < -1e-9 * abs(state.approach)
        overlap &= _rim(grid)
    if overlap.any():
        return contact_box(grid, overlap)
    return _overlapping_samples(disc, state)


def _rim(grid: Grid) -> np.ndarray:
    """The outermost elements; in line contact those at the two ends."""
    rim = np.ones(grid.shape, dtype=bool)
    rim[:, 1:-1] = not grid.line
    rim[1:-1, 1:-1] = False
    return rim


def _deformed_distance(disc: Discretisation, grid: Grid, state: ContactState) -> np.ndarray:
    """Deformed distance on a grid one element wider, (ny, nx), dimensionless."""
    wider = replace(disc, grid=grid, distance=_distance_beyond(disc, grid))
    distance = (wider.distance - disc.base) / disc.displacement - state.approach
    around = ((0, 0), (0, 0) if grid.line else (1, 1), (1, 1))
    distance = distance + wider.normal_operator.apply(np.pad(state.pressure[None], around))[0]
    if disc.scene.bodies.K != 0 and np.any(state.traction):
        distance = distance + wider.traction_to_distance.apply(np.pad(state.traction, around))[0]
    return distance


def _overlapping_samples(disc: Discretisation, state: ContactState) -> Box | None:
    """The box of the samples away from the contact elements where the bodies would overlap."""
    surface = disc.scene.surface
    if not isinstance(surface, SampledDistance) or not surface.placed:
        return None
    distance = (surface.samples - disc.base) / disc.displacement - state.approach
    suspects = (distance < _lowered_at_most(disc, state)) & ~_near_contact(disc, state, surface)
    if not suspects.any():
        return None
    iy, ix = np.nonzero(suspects)
    (all_x, all_y), below = surface.coordinates, distance[iy, ix]
    x, y = all_x[ix] / disc.length, all_y[iy] / disc.length
    raised = below + _raised_about(disc, state, x, y)
    lowest = np.argsort(raised)[:500]
    doubtful = lowest[raised[lowest] < 0.02 * float(np.abs(below).max())]
    x, y = x[doubtful], y[doubtful]
    over = below[doubtful] + _raised(disc, state, x, y) < -1e-9 * abs(state.approach)
    if not over.any():
        return None
    x, y = x[over] * disc.length, y[over] * disc.length
    return float(x.min()), float(x.max()), float(y.min()), float(y.max())


def _lowered_at_most(disc: Discretisation, state: ContactState) -> float:
    """How far tractions of unlike bodies draw the surfaces together, at most, an element or more away.

    Pressures only push them apart.
    """
    if disc.scene.bodies.K == 0 or not np.any(state.traction):
        return 0.0
    load = float(np.hypot(*state.traction).sum()) * disc.lattice.area
    return abs(disc.scene.bodies.K) * load / (1.0 if disc.scene.line else np.pi * min(disc.lattice.sides))


def _loaded(disc: Discretisation, state: ContactState) -> tuple[np.ndarray, np.ndarray]:
    """Centres (2, n) of the contact elements, and their tractions along x, along y and z, (3, n)."""
    elements = np.flatnonzero(state.pressure)
    tractions = np.concatenate([state.traction, state.pressure[None]]).reshape(3, -1)
    return disc.points.reshape(2, -1)[:, elements], tractions[:, elements]


def _raised(disc: Discretisation, state: ContactState, x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Normal displacement difference at points."""
    (centre_x, centre_y), tractions = _loaded(disc, state)
    (dx, dy), bodies = disc.lattice.sides, disc.scene.bodies
    loads = {"zz": tractions[2]} if bodies.K == 0 else {"zx": tractions[0], "zy": tractions[1], "zz": tractions[2]}
    constants: dict[str, Any] = {"nu": bodies.combined_nu, "K": bodies.K, "components": loads}
    from_x, from_y = x - centre_x[:, None], y - centre_y[:, None]
    if disc.scene.line:
        numbers = strip_influence_numbers(from_x, dx, depth=disc.depth, **constants)
    else:
        numbers = influence_numbers(from_x, from_y, dx, dy, **constants)
    return np.sum([load @ numbers[name] for name, load in loads.items()], axis=0)


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


def _raised_about(disc: Discretisation, state: ContactState, x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Normal displacement difference at points away from the contact, each element's load as a point or line force."""
    centres, tractions = _loaded(disc, state)
    load_x, load_y, load_z = tractions * disc.lattice.area
    nu, K = disc.scene.bodies.combined_nu, disc.scene.bodies.K
    raised = np.empty(x.size)
    for part in np.array_split(np.arange(x.size), 1 + x.size * load_z.size // 2_000_000):
        from_x, from_y = x[part] - centres[0][:, None], y[part] - centres[1][:, None]
        r = np.hypot(from_x, from_y)
        if disc.scene.line:
            raised[part] = (1 - nu) * load_z @ (-2 * np.log(r / disc.depth)) + np.pi * K * load_x @ np.sign(from_x)
        else:
            raised[part] = (1 - nu) * load_z @ (1 / r) + K * (load_x @ (from_x / r**2) + load_y @ (from_y / r**2))
    return raised / np.pi


def enlarged(scene: Scene, grid: Grid, pressure: np.ndarray, overlap: Box, more: float = 0.0) -> Grid:
    """A grid that takes in what was found outside, with the scene's number of elements across the contact.

    Where the contact went beyond a side, the grid goes on by `more` of the contact's length: of a contact that
    tractions move, only the next elements are seen.

    Raises
    ------
    SceneError
        If the scene's own explicit grid does not hold the contact, or the samples end within it.
    """
    spec = _spec(scene)
    left, right, bottom, top = grid.box
    if left < overlap[0] and overlap[1] < right and bottom < overlap[2] and overlap[3] < top:
        middle = (overlap[0] + overlap[1]) / 2, (overlap[2] + overlap[3]) / 2
        place = f"x = {middle[0]:.6g}" if grid.line else f"({middle[0]:.6g}, {middle[1]:.6g})"
        raise SceneError("grid", grid, f"finer: the contact at {place} falls between the centres of the elements")
    if spec.explicit:
        raise SceneError(
            "grid",
            _rounded(grid.box, grid.line),
            f"a potential contact (left, right{'' if grid.line else ', bottom, top'}) that contains the contact, which "
            f"goes on at {_rounded(overlap, grid.line)}; where a body ends there, add elements with a large distance",
        )
    surface = scene.surface
    if isinstance(surface, SampledDistance) and _clipped(overlap, surface) != overlap:
        raise SceneError(
            "surface", _rounded(surface.box, grid.line), "sampled beyond the contact, which reaches the samples' edge"
        )
    inner = contact_box(grid, pressure)
    along_x, along_y = more * (inner[1] - inner[0]), more * (inner[3] - inner[2])
    left = min(inner[0], overlap[0] - along_x) if overlap[0] < inner[0] else inner[0]
    right = max(inner[1], overlap[1] + along_x) if overlap[1] > inner[1] else inner[1]
    bottom = min(inner[2], overlap[2] - along_y) if overlap[2] < inner[2] else inner[2]
    top = max(inner[3], overlap[3] + along_y) if overlap[3] > inner[3] else inner[3]
    wider = spec.spread((left, right, bottom, top))
    return within(wider, surface) if isinstance(surface, SampledDistance) else wider


def contact_box(grid: Grid, mask: np.ndarray, around: int = 0) -> Box:
    """Bounding box of marked elements, with so many elements around."""
    rows, columns = np.flatnonzero((mask > 0).any(axis=1)), np.flatnonzero((mask > 0).any(axis=0))
    (dx, dy), (x0, _, y0, _) = grid.sides, grid.box
    return (
        x0 + (columns[0] - around) * dx,
        x0 + (columns[-1] + 1 + around) * dx,
        y0 + (rows[0] - around) * dy,
        y0 + (rows[-1] + 1 + around) * dy,
    )


def _rounded(box: Box, line: bool) -> tuple[float, ...]:
    """For people: of line contact only left and right."""
    return tuple(float(f"{value:.6g}") for value in (box[:2] if line else box))


def _clipped(box: Box, surface: SampledDistance) -> Box:
    left, right, bottom, top = surface.box
    return max(box[0], left), min(box[1], right), max(box[2], bottom), min(box[3], top)


def within(grid: Grid, surface: Surface) -> Grid:
    """The grid without the elements whose centres lie beyond the samples, where a surface has such."""
    if not isinstance(surface, SampledDistance):
        return grid
    left, right, bottom, top = surface.box
    columns = np.flatnonzero((grid.x >= left) & (grid.x <= right))
    rows = np.flatnonzero((grid.y >= bottom) & (grid.y <= top))
    return grid.window(columns[0], columns[-1] + 1, rows[0], rows[-1] + 1)


def _distance_beyond(disc: Discretisation, grid: Grid) -> np.ndarray:
    """Undeformed distance on a grid one element wider: known, or extrapolated from the samples."""
    surface = disc.scene.surface
    if disc.hertz is not None:
        return discretise(disc.scene, grid).distance
    assert isinstance(surface, SampledDistance)
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
