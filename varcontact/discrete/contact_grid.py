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

MOVED = 0.1
"""Room on each side, by the contact's width, for what tractions of unlike bodies move it during a
history."""


def wanted_grid(scene: Scene) -> Grid:
    """The grid that a scene asks for, in its own form."""
    spec = _spec(scene)
    need("a grid of this size", 400.0 * math.prod(shape_with_margin(spec)), SMALLER)
    return spec


def shape_with_margin(spec: Grid) -> tuple[int, int]:
    """Rows and columns of elements, with the margin of a grid that is not placed yet."""
    margin = 0 if spec.explicit else 2 * spec.margin
    return spec.rows + (0 if spec.line else margin), spec.nx + margin


def known_grid(scene: Scene) -> Grid:
    """The grid of a scene as far as it is known without a solution: of samples with coordinates not
    where it lies.
    """
    spec = wanted_grid(scene)
    hertz = None if spec.explicit else scene.hertz
    return spec if hertz is None else spec.spread((-hertz.a, hertz.a, -hertz.b, hertz.b))


def common_grid(scene: Scene, grids: list[Grid]) -> Grid:
    """One grid for the contacts of a history without tractions: the scene's number of elements
    across all of them.
    """
    spec, margin = _spec(scene), given_grid(scene).margin
    if len(grids) == 1 and spec.margin == margin:
        return grids[0]
    rows = 0 if spec.line else margin
    boxes = np.array(
        [grid.window(margin, grid.nx - margin, rows, grid.rows - rows).box for grid in grids]
    )
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
    spec, (columns, rows) = _spec(scene), across(pressure)
    if spec.explicit or (scene.hertz is not None and not any_surface):
        return None
    if columns >= 0.93 * spec.nx and rows >= 0.93 * spec.rows:
        return None
    return within(spec.spread(contact_box(grid, pressure)), scene.surface)


def _spec(scene: Scene) -> Grid:
    """The grid in the scene's own form, with the margin that the contact needs to move in."""
    spec = given_grid(scene)
    highest, hertz = (
        scene.motion.height_range if isinstance(scene.motion, Transient) else 0.0,
        scene.hertz,
    )
    # heights move and widen the contact
    if highest > 0 and not spec.explicit and hertz is not None:
        wider = math.sqrt(1 + highest / (hertz.a**2 / hertz.Rx)) - 1
        spec = replace(spec, margin=spec.margin + math.ceil(wider * max(spec.nx, spec.rows) / 2))
    coupled = scene.coupled and not scene.frictionless
    if spec.explicit or not isinstance(scene.motion, Transient) or not coupled:
        return spec
    return replace(spec, margin=spec.margin + math.ceil(MOVED * max(spec.nx, spec.rows)))


def given_grid(scene: Scene) -> Grid:
    return scene.grid if isinstance(scene.grid, Grid) else usual_grid(scene.line)


def across(pressure: np.ndarray) -> tuple[int, int]:
    contact = pressure > 0
    return int(contact.any(axis=0).sum()), int(contact.any(axis=1).sum())


def enlarged(
    scene: Scene, grid: Grid, pressure: np.ndarray, overlap: Box, more: float = 0.0
) -> Grid:
    """A grid that takes in what was found outside, with the scene's number of elements across the
    contact.

    Where the contact went beyond a side, the grid goes on by `more` of the contact's length: of a
    contact that tractions move, only the next elements are seen.
    """
    spec = _spec(scene)
    left, right, bottom, top = grid.box
    if left < overlap[0] and overlap[1] < right and bottom < overlap[2] and overlap[3] < top:
        middle = (overlap[0] + overlap[1]) / 2, (overlap[2] + overlap[3]) / 2
        place = f"x = {middle[0]:.6g}" if grid.line else f"({middle[0]:.6g}, {middle[1]:.6g})"
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
    inner, beyond, outwards = (
        np.array(contact_box(grid, pressure)),
        np.array(overlap),
        np.array([-1, 1, -1, 1]),
    )
    room = outwards * more * np.repeat(np.diff(inner)[::2], 2)
    left, right, bottom, top = np.where(
        outwards * (beyond - inner) > 0, beyond + room, inner
    ).tolist()
    return within(spec.spread((left, right, bottom, top)), surface)


def if_noise(scene: Scene, grid: Grid) -> str:
    """What else may be wrong where samples have a summit between the elements, or no grid holds
    their contact.
    """
    if not isinstance(scene.surface, SampledDistance) or scene.surface.x is None:
        return ""
    wavelength = 4 * (grid.sides[0] if grid.line else max(grid.sides))
    return f"; or, if this is noise, {how_to_smooth(f'{wavelength:.3g}')}, at least"


def _not_containing(grid: Grid) -> str:
    sides = "left, right" if grid.line else "left, right, bottom, top"
    return f"grid ({sides}) = {_rounded(grid.box, grid.line)} does not contain the contact"


def _rounded(box: Box, line: bool) -> tuple[float, ...]:
    """For people: of line contact only left and right."""
    return tuple(float(f"{value:.6g}") for value in (box[:2] if line else box))


def clipped(box: Box, surface: SampledDistance) -> Box:
    """What of a box lies within the samples of a surface."""
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
    rows, columns = np.flatnonzero((mask > 0).any(axis=1)), np.flatnonzero((mask > 0).any(axis=0))
    (dx, dy), (x0, _, y0, _) = grid.sides, grid.box
    return (
        x0 + (columns[0] - around) * dx,
        x0 + (columns[-1] + 1 + around) * dx,
        y0 + (rows[0] - around) * dy,
        y0 + (rows[-1] + 1 + around) * dy,
    )


def no_element_in_contact(surface: Surface, approach: float | None, grid: Grid) -> SceneError:
    """Why no element of a grid is in contact: the bodies are apart, the contact is elsewhere, or
    falls between.
    """
    left, right, bottom, top = grid.box
    x = y = 0.0
    if isinstance(surface, SampledDistance):
        iy, ix = np.unravel_index(np.argmin(surface.samples), surface.samples.shape)
        least = float(surface.samples[iy, ix])
        if approach is not None and approach <= least:
            return bodies_apart(approach, least)
        if surface.x is not None:
            x, y = (
                float(points[i]) for points, i in zip(surface.coordinates, (ix, iy), strict=True)
            )
        else:
            x, y = left, bottom
    if not (left <= x <= right and bottom <= y <= top):
        where = f"x = {x:.6g}" if grid.line else f"({x:.6g}, {y:.6g})"
        message = f"{_not_containing(grid)}, which is at {where}"
        return SceneError("grid", grid.box[:2] if grid.line else grid.box, message=message)
    message = "grid is too coarse to hold one contact element: no element's centre is in contact"
    return TooCoarse("grid", grid, message=message)


def sampled(grid: Grid, field: np.ndarray, other: Grid) -> np.ndarray:
    """A field (ny, nx) in the elements where the centres of another grid lie; zero outside."""
    x0, _, y0, _ = grid.box
    dx, dy = grid.sides
    ix = np.floor((other.x - x0) / dx).astype(int)
    iy = np.zeros(1, dtype=int) if grid.line else np.floor((other.y - y0) / dy).astype(int)
    inside = ((iy >= 0) & (iy < grid.rows))[:, None] & ((ix >= 0) & (ix < grid.nx))
    return np.where(
        inside, field[np.ix_(np.clip(iy, 0, grid.rows - 1), np.clip(ix, 0, grid.nx - 1))], 0
    )


def interpolated(grid: Grid, fields: np.ndarray, other: Grid) -> np.ndarray:
    """Fields (k, ny, nx), linearly, at the element centres of another grid; zero outside."""
    if grid == other:
        return fields
    dx, dy = grid.sides
    found = fields @ _linear(other.x, grid.x, dx).T
    return found if grid.line else _linear(other.y, grid.y, dy) @ found


def on_parts(values: np.ndarray, cells: Cells) -> np.ndarray:
    """Values (..., ny, nx) on equal parts of elements, bilinear between the centres, with zeros
    around the grid.
    """
    grid = Grid(nx=values.shape[-1], ny=values.shape[-2], dx=1.0, dy=1.0, x0=0.0, y0=0.0)
    padded = np.pad(values, [(0, 0)] * (values.ndim - 2) + [(1, 1), (1, 1)])
    return interpolated(grid.extended(), padded, grid.divided(cells))


def _linear(places: np.ndarray, known: np.ndarray, side: float) -> np.ndarray:
    """Weights (places, known) of linear interpolation between equally spaced places, zero beyond
    these.
    """
    apart = np.abs(places[:, None] - known) / side
    inside = (places >= known[0]) & (places <= known[-1])
    return np.where(inside[:, None], np.maximum(1 - apart, 0.0), 0.0)
