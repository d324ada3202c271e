"""Potential contact: the grid that a scene asks for, refined around its contact or enlarged where
the contact is larger; and the scales of the problem on it.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from varcontact.errors import SceneError, TooCoarse
from varcontact.reference.pin_in_hole import pin_in_hole
from varcontact.scene.bodies import Bodies
from varcontact.scene.consistency import bodies_apart
from varcontact.scene.grid import Cells, Grid
from varcontact.scene.interpolation import how_to_smooth
from varcontact.scene.pin import PinInHole
from varcontact.scene.scene import Scene
from varcontact.scene.surface_displacement import SurfaceDisplacement
from varcontact.scene.surface_load import SurfaceLoad
from varcontact.scene.surfaces import SampledDistance, Surface
from varcontact.scene.transient import Transient
from varcontact.scene.units import Scales
from varcontact.system.process import SMALLER, need

Box = tuple[float, float, float, float]
"""Left, right, bottom and top, in the unit of the grid."""

HISTORY_MARGIN = 0.1
"""Margin on each side, divided by the contact width, for the movement of the contact by tractions
of unlike bodies during a history."""

EXPONENT_MAX = 280
"""Largest power of ten of forces and their work: floating point ends at 308."""

PIN_ROOM = 1.02
"""Width of a pin's first grid divided by the contact width of like bodies; unlike bodies have
another width."""


@dataclass(frozen=True, eq=False)
class PotentialContact:
    """The grid of a scene, decided before anything is solved.

    `form`: the number of elements across the contact and the margin in which it can move, or the
    explicit grid of the scene. `placed`: that grid at its place, None if the contact must be
    searched for.
    """

    form: Grid
    placed: Grid | None
    surface: Surface
    hertzian: bool

    @classmethod
    def of(cls, scene: Scene) -> PotentialContact:
        """The potential contact of a scene."""
        form = _with_room_to_move(scene)
        hertz = scene.hertz
        placed = None
        if form.explicit:
            placed = form
        elif hertz is not None:
            placed = form.spread((-hertz.a, hertz.a, -hertz.b, hertz.b))
        elif isinstance(scene.surface, PinInHole):
            half = _half_width_of_pin(scene, scene.surface)
            placed = form.spread((-half, half, -math.inf, math.inf))
        return cls(form, placed, scene.surface, hertz is not None)

    @property
    def known(self) -> Grid:
        """Grid as far as it is known before the solution; `TooLarge` for one that does not fit into
        memory.
        """
        self.check_size()
        if self.placed is None:
            return self.form
        return self.placed

    def check_size(self) -> None:
        """Refuse a grid that does not fit into memory."""
        elements = math.prod(shape_with_margin(self.form))
        need("a grid of this size", 400.0 * elements, SMALLER)

    def around(self, box: Box) -> Grid:
        """The grid across a contact, without elements beyond the samples of a surface."""
        return within(self.form.spread(box), self.surface)

    def reduced(self, grid: Grid, pressure: np.ndarray, any_surface: bool = False) -> Grid | None:
        """A grid that lies closer around the contact, where the number of elements across it is
        not met.

        Hertzian contacts are where they are expected, unless `any_surface` says that tractions may
        have moved them.
        """
        if self.form.explicit or (self.hertzian and not any_surface):
            return None
        columns, rows = across(pressure)
        if columns >= 0.93 * self.form.nx and rows >= 0.93 * self.form.rows:
            return None
        return self.around(contact_box(grid, pressure))

    def enlarged(self, grid: Grid, pressure: np.ndarray, overlap: Box, more: float = 0.0) -> Grid:
        """A grid that contains the overlap found outside, with the number of elements across the
        contact.

        Where the contact went beyond a side, the grid goes on by `more` of the contact's length: of
        a contact that tractions move, only the next elements are known.
        """
        surface = self.surface
        if self.form.explicit or holds(grid, overlap):
            raise beyond(surface, grid, pressure, overlap)
        if isinstance(surface, SampledDistance) and within_samples(overlap, surface) != overlap:
            allowed = "a larger region: the contact reaches the edge of the samples"
            raise SceneError("surface", _rounded(surface.box, grid.line), allowed)
        inner = np.array(contact_box(grid, pressure))
        outer = np.array(overlap)
        outwards = np.array([-1, 1, -1, 1])
        room = outwards * more * np.repeat(np.diff(inner)[::2], 2)
        sides = np.where(outwards * (outer - inner) > 0, outer + room, inner)
        left, right, bottom, top = sides.tolist()
        return self.around((left, right, bottom, top))


def _half_width_of_pin(scene: Scene, pin: PinInHole) -> float:
    """Half the width of the contact of a pin, of one material with the hole and without
    friction.
    """
    assert scene.normal_force is not None
    assert isinstance(scene.bodies, Bodies)
    contact = pin_in_hole(pin.R, pin.clearance, scene.bodies, force=scene.normal_force)
    return PIN_ROOM * contact.half_angle * pin.R


def shape_with_margin(form: Grid) -> tuple[int, int]:
    """Rows and columns of elements, with the margin of a grid that is not placed yet."""
    if form.explicit:
        return form.rows, form.nx
    if form.line:
        return form.rows, form.nx + 2 * form.margin
    return form.rows + 2 * form.margin, form.nx + 2 * form.margin


def common_grid(scene: Scene, potential: PotentialContact, grids: list[Grid]) -> Grid:
    """One grid for the contacts of a history without tractions: the scene's number of elements
    across all of them.
    """
    form = potential.form
    margin = scene.own_grid.margin
    if len(grids) == 1 and form.margin == margin:
        return grids[0]
    margin_rows = 0
    if not form.line:
        margin_rows = margin
    contacts = [
        grid.window(margin, grid.nx - margin, margin_rows, grid.rows - margin_rows)
        for grid in grids
    ]
    boxes = np.array([contact.box for contact in contacts])
    left, bottom = boxes[:, [0, 2]].min(axis=0)
    right, top = boxes[:, [1, 3]].max(axis=0)
    grid = form.spread((float(left), float(right), float(bottom), float(top)))
    for surface in scene.surfaces:
        grid = within(grid, surface)
    return grid


def _with_room_to_move(scene: Scene) -> Grid:
    """The scene's grid with the margin in which the contact of a history moves."""
    form = scene.own_grid
    motion = scene.motion
    if form.explicit or not isinstance(motion, Transient):
        return form
    elements = max(form.nx, form.rows)
    margin = form.margin
    # heights move and widen the contact
    hertz = scene.hertz
    if hertz is not None and motion.height_range > 0:
        wider = math.sqrt(1 + motion.height_range / (hertz.a**2 / hertz.Rx)) - 1
        margin += math.ceil(wider * elements / 2)
    # tractions of unlike bodies move the contact, too
    if scene.coupled and not scene.frictionless:
        margin += math.ceil(HISTORY_MARGIN * elements)
    return replace(form, margin=margin)


def across(pressure: np.ndarray) -> tuple[int, int]:
    contact = pressure > 0
    return int(contact.any(axis=0).sum()), int(contact.any(axis=1).sum())


def holds(grid: Grid, overlap: Box) -> bool:
    """True if an overlap lies within a grid."""
    left, right, bottom, top = grid.box
    inside = left < overlap[0] and overlap[1] < right
    return inside and bottom < overlap[2] and overlap[3] < top


def beyond(surface: Surface, grid: Grid, pressure: np.ndarray, overlap: Box) -> SceneError:
    """Error for a contact with a pressure on an explicit grid that continues outside it, or falls
    between the elements.
    """
    if holds(grid, overlap):
        place = _place((overlap[0] + overlap[1]) / 2, (overlap[2] + overlap[3]) / 2, grid.line)
        message = (
            f"grid is too coarse: the contact at {place} falls between the centres of the elements"
        )
        return TooCoarse("grid", grid, message=message + if_noise(surface, grid))
    remedy = "make it larger, or, where a body ends, add elements with a large distance"
    left, right, bottom, top = zip(contact_box(grid, pressure), overlap, strict=True)
    extent = min(left), max(right), min(bottom), max(top)
    extends = f"which extends to {_rounded(extent, grid.line)} or further; {remedy}"
    message = f"{_not_containing(grid)}, {extends}"
    return SceneError("grid", _rounded(grid.box, grid.line), message=message)


def if_noise(surface: Surface, grid: Grid) -> str:
    """Advice against noise, for samples with a summit between the elements or a contact that no
    grid holds.
    """
    if not isinstance(surface, SampledDistance) or surface.x is None:
        return ""
    side = grid.sides[0]
    if not grid.line:
        side = max(grid.sides)
    return f"; or, if this is noise, {how_to_smooth(f'{4 * side:.3g}')}, at least"


def check_loads(scene: Scene, grid: Grid, elements: np.ndarray, region: str) -> None:
    """Refuse loads and prescribed displacements beside the contact that lie on some elements (ny,
    nx) of a grid.
    """
    prescribed: dict[str, Sequence[SurfaceLoad | SurfaceDisplacement] | None] = {
        "loads": scene.loads,
        "displacements": scene.displacements,
    }
    words = {"loads": "tractions", "displacements": "displacements"}
    for name, beside in prescribed.items():
        for k, each in enumerate(beside or ()):
            if each.overlaps(grid, elements):
                box = _rounded(contact_box(grid, elements), grid.line)
                message = (
                    f"{name}[{k}] overlaps the {region}, {box}: "
                    f"{words[name]} are prescribed outside the contact only"
                )
                raise SceneError(f"{name}[{k}]", each, message=message)


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


def within_samples(box: Box, surface: Surface) -> Box:
    """Part of a box within the samples of a surface, where that has samples with coordinates."""
    if not isinstance(surface, SampledDistance) or surface.x is None:
        return box
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
    """Error for a grid without elements in contact: the bodies are apart, or the contact is
    elsewhere or between elements.
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


# ----------------------------------------------------------------------------- scales on a grid


def check_depth(scene: Scene, grid: Grid) -> None:
    """Refuse a reference depth within the potential contact or the relaxation length."""
    depth = scene.reference_depth
    if depth is None or isinstance(scene.surface, PinInHole):
        return
    lengths = {"the length of the potential contact": grid.nx * grid.sides[0]}
    if scene.bodies.relaxes:
        relaxation = (scene.speed or 0.0) * scene.bodies.longest_relaxation
        lengths["the longest relaxation length, motion.speed times tau"] = relaxation
    for name, least in lengths.items():
        if depth < least:
            raise SceneError("surface.reference_depth", depth, f"at least {name}, {least:.6g}")


def check_element_size(scene: Scene, grid: Grid) -> None:
    """Refuse elements larger than a Hertzian contact."""
    hertz = scene.hertz
    dx, dy = grid.sides
    if hertz is None or not (dx > 2.000001 * hertz.a or dy > 2.000001 * hertz.b):
        return
    contact = f"{2 * hertz.a:.6g}"
    element = f"{dx:.6g}"
    value: float | tuple[float, float] = dx
    if not scene.line:
        contact += f" by {2 * hertz.b:.6g}"
        element += f" by {dy:.6g}"
        value = (dx, dy)
    message = (
        "grid is too coarse to hold one contact element: "
        f"the contact is {contact}, an element {element}"
    )
    raise TooCoarse("grid", value, message=message)


def scales_of(scene: Scene, grid: Grid, distance: np.ndarray) -> Scales:
    """Scales of a problem: the size of the potential contact and a typical pressure."""
    dx, dy = grid.sides
    modulus = scene.bodies.combined_G
    # size of the potential contact
    length = grid.nx * dx
    if not scene.line:
        length = math.sqrt(length * grid.rows * dy)
    # typical pressure: Hertz's peak, the mean, or that of the overlap
    if scene.hertz is not None:
        pressure = scene.hertz.peak_pressure
    elif scene.normal_force is not None and scene.line:
        pressure = scene.normal_force / length
    elif scene.normal_force is not None:
        pressure = scene.normal_force / length**2
    else:
        assert scene.approach is not None
        overlap = scene.approach - float(distance.min())
        if overlap <= 0:
            raise no_element_in_contact(scene.surface, scene.approach, grid)
        pressure = modulus * overlap / length
    return Scales(length, pressure, modulus, scene.line)


def check_range(scales: Scales) -> None:
    """Refuse units in which forces or their work leave the range of floating point."""
    L, p, G = map(_power_of_ten, (scales.length, scales.pressure, scales.modulus))
    force = p + 2 * L
    if scales.line:
        force = p + L
    largest = max(map(abs, (L, p, p + L - G, force, force + p + L - G)))
    if not largest < EXPONENT_MAX:
        sizes = (
            f"lengths of {scales.length:.3g}, pressures of {scales.pressure:.3g}, "
            f"combined modulus {scales.modulus:.3g}"
        )
        allowed = (
            "in units in which forces and their work are within "
            f"1e-{EXPONENT_MAX} and 1e{EXPONENT_MAX}"
        )
        raise SceneError("scene", sizes, allowed)


def _power_of_ten(size: float) -> float:
    """Decimal logarithm of a size; minus infinity for zero."""
    if not size > 0:
        return -math.inf
    return math.log10(size)
