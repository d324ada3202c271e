"""The potential contact: the grid that a scene asks for, closer around its contact or larger where
that goes on.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from varcontact.errors import SceneError, TooCoarse
from varcontact.scene.consistency import bodies_apart
from varcontact.scene.grid import Cells, Grid, usual_grid
from varcontact.scene.interpolation import how_to_smooth
from varcontact.scene.scene import Scene
from varcontact.scene.surfaces import SampledDistance, Surface
from varcontact.scene.transient import Transient
from varcontact.system.process import SMALLER, need

Box = tuple[float, float, float, float]
"""Left, right, bottom, top, in the unit of the grid."""

HISTORY_MARGIN = 0.1
"""Room on each side, relative to the contact's width, for its movement by tractions of unlike
bodies during a history."""


def wanted_grid(scene: Scene) -> Grid:
    """The grid that a scene asks for, in its own form."""
    spec = _spec(scene)
    need("a grid of this size", 400.0 * math.prod(shape_with_margin(spec)), SMALLER)
    return spec


def shape_with_margin(spec: Grid) -> tuple[int, int]:
    """Rows and columns of elements, with the margin of a grid that is not placed yet."""
    if spec.explicit:
        return spec.rows, spec.nx
    if spec.line:
        return spec.rows, spec.nx + 2 * spec.margin
    return spec.rows + 2 * spec.margin, spec.nx + 2 * spec.margin


def known_grid(scene: Scene) -> Grid:
    """The grid of a scene as far as it is known without a solution: of samples with coordinates not
    where it lies.
    """
    spec = wanted_grid(scene)
    if spec.explicit or scene.hertz is None:
        return spec
    a = scene.hertz.a
    b = scene.hertz.b
    return spec.spread((-a, a, -b, b))


def common_grid(scene: Scene, grids: list[Grid]) -> Grid:
    """One grid for the contacts of a history without tractions: the scene's number of elements
    across all of them.
    """
    spec = _spec(scene)
    margin = given_grid(scene).margin
    if len(grids) == 1 and spec.margin == margin:
        return grids[0]
    margin_rows = 0
    if not spec.line:
        margin_rows = margin
    contacts = [
        grid.window(margin, grid.nx - margin, margin_rows, grid.rows - margin_rows)
        for grid in grids
    ]
    boxes = np.array([contact.box for contact in contacts])
    left, bottom = boxes[:, [0, 2]].min(axis=0)
    right, top = boxes[:, [1, 3]].max(axis=0)
    grid = spec.spread((float(left), float(right), float(bottom), float(top)))
    for surface in scene.surfaces:
        grid = within(grid, surface)
    return grid


def fitted(
    scene: Scene, grid: Grid, pressure: np.ndarray, any_surface: bool = False
) -> Grid | None:
    """A grid that lies closer around the contact, where the scene's number of elements across it is
    not met.

    Hertzian contacts are where they are expected, unless `any_surface` says that tractions may have
    moved them.
    """
    spec = _spec(scene)
    if spec.explicit or (scene.hertz is not None and not any_surface):
        return None
    columns, rows = across(pressure)
    if columns >= 0.93 * spec.nx and rows >= 0.93 * spec.rows:
        return None
    return within(spec.spread(contact_box(grid, pressure)), scene.surface)


def _spec(scene: Scene) -> Grid:
    """The grid in the scene's own form, with the margin that the contact needs to move in."""
    spec = given_grid(scene)
    motion = scene.motion
    if spec.explicit or not isinstance(motion, Transient):
        return spec
    elements = max(spec.nx, spec.rows)
    margin = spec.margin
    # heights move and widen the contact
    hertz = scene.hertz
    if hertz is not None and motion.height_range > 0:
        wider = math.sqrt(1 + motion.height_range / (hertz.a**2 / hertz.Rx)) - 1
        margin += math.ceil(wider * elements / 2)
    # so do tractions of unlike bodies
    if scene.coupled and not scene.frictionless:
        margin += math.ceil(HISTORY_MARGIN * elements)
    return replace(spec, margin=margin)


def given_grid(scene: Scene) -> Grid:
    if isinstance(scene.grid, Grid):
        return scene.grid
    return usual_grid(scene.line)


def across(pressure: np.ndarray) -> tuple[int, int]:
    contact = pressure > 0
    return int(contact.any(axis=0).sum()), int(contact.any(axis=1).sum())


def enlarged(
    scene: Scene, grid: Grid, pressure: np.ndarray, overlap: Box, more: float = 0.0
) -> Grid:
    """A grid that contains the overlap found outside, with the scene's number of elements across
    the contact.

    Where the contact went beyond a side, the grid goes on by `more` of the contact's length: of a
    contact that tractions move, only the next elements are known.
    """
    spec = _spec(scene)
    left, right, bottom, top = grid.box
    if left < overlap[0] and overlap[1] < right and bottom < overlap[2] and overlap[3] < top:
        place = _place((overlap[0] + overlap[1]) / 2, (overlap[2] + overlap[3]) / 2, grid.line)
        message = (
            f"grid is too coarse: the contact at {place} falls between the centres of the elements"
        )
        raise TooCoarse("grid", grid, message=message + if_noise(scene, grid))
    if spec.explicit:
        remedy = "make it larger, or, where a body ends, add elements with a large distance"
        message = (
            f"{_not_containing(grid)}, which extends to {_rounded(overlap, grid.line)}; {remedy}"
        )
        raise SceneError("grid", _rounded(grid.box, grid.line), message=message)
    surface = scene.surface
    if isinstance(surface, SampledDistance) and clipped(overlap, surface) != overlap:
        allowed = "a larger region: the contact reaches the edge of the samples"
        raise SceneError("surface", _rounded(surface.box, grid.line), allowed)
    inner = np.array(contact_box(grid, pressure))
    outer = np.array(overlap)
    outwards = np.array([-1, 1, -1, 1])
    room = outwards * more * np.repeat(np.diff(inner)[::2], 2)
    sides = np.where(outwards * (outer - inner) > 0, outer + room, inner)
    left, right, bottom, top = sides.tolist()
    return within(spec.spread((left, right, bottom, top)), surface)


def if_noise(scene: Scene, grid: Grid) -> str:
    """Advice against noise, where samples have a summit between the elements, or no grid holds
    their contact.
    """
    if not isinstance(scene.surface, SampledDistance) or scene.surface.x is None:
        return ""
    side = grid.sides[0]
    if not grid.line:
        side = max(grid.sides)
    return f"; or, if this is noise, {how_to_smooth(f'{4 * side:.3g}')}, at least"


def _not_containing(grid: Grid) -> str:
    sides = "left, right"
    if not grid.line:
        sides += ", bottom, top"
    return f"grid ({sides}) = {_rounded(grid.box, grid.line)} does not contain the contact"


def _rounded(box: Box, line: bool) -> tuple[float, ...]:
    """Sides of a box for a message: of line contact only left and right."""
    count = 2 if line else 4
    return tuple(float(f"{value:.6g}") for value in box[:count])


def _place(x: float, y: float, line: bool) -> str:
    if line:
        return f"x = {x:.6g}"
    return f"({x:.6g}, {y:.6g})"


def clipped(box: Box, surface: SampledDistance) -> Box:
    """Part of a box within the samples of a surface."""
    left, right, bottom, top = surface.box
    return max(box[0], left), min(box[1], right), max(box[2], bottom), min(box[3], top)


def within(grid: Grid, surface: Surface) -> Grid:
    """The grid without the elements whose centres lie beyond the samples, where a surface has
    such.
    """
    if not isinstance(surface, SampledDistance):
        return grid
    left, right, bottom, top = surface.box
    columns = np.flatnonzero((grid.x >= left) & (grid.x <= right))
    rows = np.flatnonzero((grid.y >= bottom) & (grid.y <= top))
    return grid.window(columns[0], columns[-1] + 1, rows[0], rows[-1] + 1)


def contact_box(grid: Grid, mask: np.ndarray, around: int = 0) -> Box:
    """Bounding box of marked elements, with a margin of elements around."""
    rows = np.flatnonzero((mask > 0).any(axis=1))
    columns = np.flatnonzero((mask > 0).any(axis=0))
    dx, dy = grid.sides
    x0, _, y0, _ = grid.box
    return (
        x0 + (columns[0] - around) * dx,
        x0 + (columns[-1] + 1 + around) * dx,
        y0 + (rows[0] - around) * dy,
        y0 + (rows[-1] + 1 + around) * dy,
    )


def no_element_in_contact(surface: Surface, approach: float | None, grid: Grid) -> SceneError:
    """The error where no element of a grid is in contact: the bodies are apart, the contact is
    elsewhere, or falls between.
    """
    left, right, bottom, top = grid.box
    # place of the least distance
    x = y = 0.0
    if isinstance(surface, SampledDistance):
        iy, ix = np.unravel_index(np.argmin(surface.samples), surface.samples.shape)
        least = float(surface.samples[iy, ix])
        if approach is not None and approach <= least:
            return bodies_apart(approach, least)
        x, y = left, bottom
        if surface.x is not None:
            all_x, all_y = surface.coordinates
            x, y = float(all_x[ix]), float(all_y[iy])
    if not (left <= x <= right and bottom <= y <= top):
        message = f"{_not_containing(grid)}, which is at {_place(x, y, grid.line)}"
        count = 2 if grid.line else 4
        return SceneError("grid", grid.box[:count], message=message)
    message = "grid is too coarse to hold one contact element: no element's centre is in contact"
    return TooCoarse("grid", grid, message=message)


def sampled(grid: Grid, field: np.ndarray, other: Grid) -> np.ndarray:
    """A field (ny, nx) in the elements where the centres of another grid lie; zero outside."""
    x0, _, y0, _ = grid.box
    dx, dy = grid.sides
    ix = np.floor((other.x - x0) / dx).astype(int)
    iy = np.zeros(1, dtype=int)
    if not grid.line:
        iy = np.floor((other.y - y0) / dy).astype(int)
    inside = ((iy >= 0) & (iy < grid.rows))[:, None] & ((ix >= 0) & (ix < grid.nx))
    nearest = np.ix_(np.clip(iy, 0, grid.rows - 1), np.clip(ix, 0, grid.nx - 1))
    return np.where(inside, field[nearest], 0)


def interpolated(grid: Grid, fields: np.ndarray, other: Grid) -> np.ndarray:
    """Fields (k, ny, nx), linearly, at the element centres of another grid; zero outside."""
    if grid == other:
        return fields
    dx, dy = grid.sides
    along_x = fields @ _linear(other.x, grid.x, dx).T
    if grid.line:
        return along_x
    return _linear(other.y, grid.y, dy) @ along_x


def on_parts(values: np.ndarray, cells: Cells) -> np.ndarray:
    """Values (..., ny, nx) on equal parts of elements, bilinear between the centres, with zeros
    around the grid.
    """
    grid = Grid(nx=values.shape[-1], ny=values.shape[-2], dx=1.0, dy=1.0, x0=0.0, y0=0.0)
    padded = np.pad(values, [(0, 0)] * (values.ndim - 2) + [(1, 1), (1, 1)])
    return interpolated(grid.extended(), padded, grid.divided(cells))


def _linear(places: np.ndarray, nodes: np.ndarray, side: float) -> np.ndarray:
    """Weights (places, nodes) of linear interpolation between equally spaced nodes, zero beyond
    these.
    """
    apart = np.abs(places[:, None] - nodes) / side
    inside = (places >= nodes[0]) & (places <= nodes[-1])
    return np.where(inside[:, None], np.maximum(1 - apart, 0.0), 0.0)
