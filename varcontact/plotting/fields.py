"""Fields over the contact: maps of stick and slip with tractions and of others in colours; in line contact curves."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.lines import Line2D
from matplotlib.patches import PathPatch
from matplotlib.path import Path

from varcontact.discrete.stick_slip import EXTERIOR, SLIP, STICK
from varcontact.plotting import style
from varcontact.plotting.unit_labels import Measure, measure_of
from varcontact.results.finest_fields import FinestFields, finest_fields
from varcontact.results.solution import Solution
from varcontact.scene.grid import Grid
from varcontact.scene.motion import Steady
from varcontact.scene.units import moved

Box = tuple[float, float, float, float]
"""Left, right, bottom and top of what is shown [length]."""
NOT_EQUAL = "(x and y not to one scale)"


@dataclass(frozen=True)
class Field:
    """A field over the contact, (ny, nx) or of vectors (2, ny, nx), that has a picture.

    `quantity` is that of `measure`, in rolling and in a shift; `on_parts` are fields of corrected solutions.
    """

    title: str
    name: str
    values: Callable[[Solution], np.ndarray]
    quantity: str
    colours: str = "viridis"
    outside: bool = False
    on_parts: bool = False

    def measured(self, sol: Solution, values: np.ndarray) -> Measure:
        return measure_of(sol.scene, moved(self.quantity, is_shift(sol)), values)

    def place(self, sol: Solution) -> tuple[Grid, np.ndarray, str]:
        """The grid it is on, the state of its elements, and what its title adds."""
        if not self.on_parts:
            return sol.grid, sol.state, ""
        finest = finest_fields(sol)
        return finest.grid, finest.state, corrected(finest)


FIELDS = {
    "pressure": Field("Pressure", "pressure", lambda sol: sol.pressure, "pressure"),
    "slip": Field(
        "Slip of body 1 over body 2", "slip", lambda sol: finest_fields(sol).slip, "slip", "YlOrBr", on_parts=True
    ),
    "distance": Field(
        "Distance of the bodies", "distance", lambda sol: sol.distance, "length", "cividis", outside=True
    ),
    "power_density": Field(
        "Power density of friction",
        "work by area",
        lambda sol: finest_fields(sol).power_density,
        "power density",
        "YlOrBr",
        on_parts=True,
    ),
    "temperature": Field(
        "Temperature of body 1",
        "temperature [degrees]",
        lambda sol: np.asarray(sol.temperature)[0],
        "1",
        "inferno",
        outside=True,
    ),
}
"""By the word for `Solution.plot`."""


def is_shift(sol: Solution) -> bool:
    return sol.motion is not None and sol.motion.rolls == 0


def corrected(finest: FinestFields) -> str:
    """What a title says of fields on parts of the elements."""
    return f"\n(corrected, on {finest.parts} parts)" if finest.parts else ""


def lengths_of(sol: Solution) -> Measure:
    """How lengths in the plane are shown."""
    return measure_of(sol.scene, "length", sol.grid.box)


def x_label(sol: Solution, lengths: Measure) -> str:
    return lengths.label("x") + style.ROLLING.get(sol.motion.rolls if sol.motion is not None else 0, "")


def draw_areas(ax: Axes, sol: Solution, box: Box | None = None, largest: float | None = None) -> None:
    """Stick and slip areas, traction arrows on them, and the spin pole where it lies in the picture.

    `box` is the contact with a margin, `largest` the largest traction, that with the longest arrow, if not given.
    """
    shown = box_of(sol.state > 0, sol.grid) if box is None else box
    lengths, field = lengths_of(sol), finest_fields(sol)
    state = field.state
    if isinstance(sol.motion, Steady):  # slip at the leading edge, before elements that stick, is grid error
        around = np.pad(state, ((0, 0), (1, 1)))
        leading = (around[:, 2:] == EXTERIOR) & (around[:, :-2] == STICK)
        state = np.where(leading & (state == SLIP), STICK, state)
    for number, (name, look) in list(style.LOOKS.items())[: 2 + (sol.plastic is not None)]:
        outline = _elements_path(state == number, field.grid, lengths.factor)
        ax.add_patch(PathPatch(outline, gid=name, **look))
    handles: list[Any] = [*style.area_patches(sol.plastic is not None)]
    size = np.hypot(*field.traction).max(initial=0.0)
    scale = size if largest is None else largest
    if _draw_arrows(ax, field.grid, field.traction, field.state > 0, 26, lengths, shown, scale):
        words = f"traction, up to {measure_of(sol.scene, 'pressure', size).text(size)}"
        handles.append(
            Line2D([], [], color=style.TRACTION_COLOUR, marker=r"$\rightarrow$", markersize=9, ls="", label=words)
        )
    vx, vy, spin = sol.creepage
    left, right, bottom, top = shown
    if spin != 0 and left < -vy / spin < right and bottom < vx / spin < top:
        handles += ax.plot(lengths(-vy / spin), lengths(vx / spin), "k.", markersize=7, label="spin pole")
    ax.set_title(f"Tangential traction on body 1{corrected(field)}")
    _frame(ax, sol, lengths, shown)
    style.legend_below(ax, handles, columns=2)


def draw_field(ax: Axes, sol: Solution, name: str) -> None:
    """One of `FIELDS` in colours with its bar; slip with its directions, and outside the contact its edge."""
    field, lengths = FIELDS[name], lengths_of(sol)
    values, (grid, state, words) = field.values(sol), field.place(sol)
    size = np.hypot(*values) if values.ndim == 3 else values
    shown = np.ma.masked_invalid(size if field.outside else np.where(state > 0, size, np.nan))
    measured = field.measured(sol, shown.filled(0.0))
    left, right, bottom, top = (float(lengths(edge)) for edge in sol.grid.box)
    image = ax.imshow(
        shown * measured.factor,
        origin="lower",
        extent=(left, right, bottom, top),
        cmap=field.colours,
        vmin=0.0 if shown.count() and (words or shown.min() >= -1e-6 * shown.max()) else None,
        aspect="auto",
    )
    style.colour_bar(ax, image, measured.label(field.name))
    box = sol.grid.box if field.outside else box_of(sol.state > 0, sol.grid)
    if values.ndim == 3:
        _draw_arrows(ax, grid, values, state == SLIP, 20, lengths, box, float(size.max(initial=0.0)))
    ax.set_title(field.title + words)
    _frame(ax, sol, lengths, box)
    if field.outside:
        inside = np.pad(sol.state > 0, 1)
        x, y = sol.grid.lines
        upright = [((x[i], y[j]), (x[i], y[j + 1])) for j, i in np.argwhere(np.diff(inside[1:-1], axis=1))]
        level = [((x[i], y[j]), (x[i + 1], y[j])) for j, i in np.argwhere(np.diff(inside[:, 1:-1], axis=0))]
        if upright:
            ax.add_collection(LineCollection(list(lengths(upright + level)), colors="w", linewidths=1.0))
            ax.plot([], [], color="0.6", linewidth=1.0, label="contact edge")
        style.legend_below(ax)


def box_of(contact: np.ndarray, grid: Grid) -> Box:
    """Some elements (ny, nx) with a margin of two; of none, the whole grid."""
    if not contact.any():
        return grid.box
    (dx, dy), x, y = grid.sides, grid.x[contact.any(axis=0)], grid.y[contact.any(axis=1)]
    return x[0] - 2.5 * dx, x[-1] + 2.5 * dx, y[0] - 2.5 * dy, y[-1] + 2.5 * dy


def shape_of(sol: Solution) -> float:
    """Height by width of panels that suits a contact."""
    left, right, bottom, top = box = box_of(sol.state > 0, sol.grid)
    return float(np.clip((top - bottom) / (right - left), 0.7, 1.3)) if _equal(box) else 1.0


def rectangles_path(corners: list[tuple[float, float, float, float]]) -> Path:
    """The outline of rectangles by their left, right, lower and upper sides."""
    vertices = [
        point
        for left, right, low, high in corners
        for point in ((left, low), (right, low), (right, high), (left, high), (left, low))
    ]
    codes = [Path.MOVETO, Path.LINETO, Path.LINETO, Path.LINETO, Path.CLOSEPOLY] * len(corners)
    return Path(np.array(vertices, dtype=float).reshape(-1, 2), codes)


def runs(chosen: np.ndarray) -> np.ndarray:
    """The first and the one after the last of each run of chosen places, (n, 2)."""
    return np.flatnonzero(np.diff(chosen, prepend=False, append=False)).reshape(-1, 2)


def _elements_path(chosen: np.ndarray, grid: Grid, factor: float) -> Path:
    """The outline of some elements, in one rectangle for each run along x, with lengths times a factor."""
    dx, dy = (factor * side for side in grid.sides)
    left, bottom = factor * grid.x[0] - dx / 2, factor * grid.y[0] - dy / 2
    return rectangles_path(
        [
            (left + dx * begin, left + dx * end, bottom + row * dy, bottom + (row + 1) * dy)
            for row in np.flatnonzero(chosen.any(axis=1))
            for begin, end in runs(chosen[row])
        ]
    )


def _draw_arrows(
    ax: Axes,
    grid: Grid,
    values: np.ndarray,
    where: np.ndarray,
    most: int,
    lengths: Measure,
    box: Box,
    largest: float,
) -> bool:
    """Arrows on some elements, `most` along a side, the longest nearly two distances long; whether there are any."""
    every = max(1, int(np.ceil(max(grid.shape) / most)))
    iy, ix = (every * i + every // 2 for i in np.nonzero(where[every // 2 :: every, every // 2 :: every]))
    if largest <= 0 or ix.size == 0:
        return False
    u, v = values[:, iy, ix] / largest
    scale: dict[str, Any]
    if _equal(box):
        length = 1.6 * every * float(lengths(max(grid.sides)))
        scale = {"angles": "xy", "scale_units": "xy", "scale": 1 / length}
    else:  # directions are kept on the page, and the longest arrow is a twentieth of its width
        scale = {"angles": "uv", "scale_units": "width", "scale": 20}
    x, y = lengths(grid.x[ix]), lengths(grid.y[iy])
    ax.quiver(x, y, u, v, color=style.TRACTION_COLOUR, width=0.005, pivot="tail", zorder=3, **scale)
    return True


def _frame(ax: Axes, sol: Solution, lengths: Measure, box: Box) -> None:
    """Labels, limits, and axes to one scale, or a word where they are not."""
    style.readable_ticks(ax)
    equal = _equal(box)
    ax.set_xlabel(x_label(sol, lengths) + ("" if equal else f"\n{NOT_EQUAL}"))
    ax.set_ylabel(lengths.label("y"))
    shape = ax.get_box_aspect()  # of our own figures, whose panels are of one height
    left, right, bottom, top = box
    if shape is None:
        ax.set_aspect("equal" if equal else "auto")
    elif equal:  # more of the plane, so that lengths are the same along x and y
        width, height = max(right - left, (top - bottom) / shape), max(top - bottom, (right - left) * shape)
        x, y = (left + right) / 2, (bottom + top) / 2
        left, right, bottom, top = x - width / 2, x + width / 2, y - height / 2, y + height / 2
    ax.set_xlim(*lengths((left, right)))
    ax.set_ylim(*lengths((bottom, top)))


def _equal(box: Box) -> bool:
    left, right, bottom, top = box
    return 0.2 < (right - left) / (top - bottom) < 5


def draw_line_traction(ax: Axes, sol: Solution, box: Box | None = None, largest: float | None = None) -> None:
    """Tractions along x between plus and minus the traction bound, over stick and slip areas.

    `box` is the contact with a margin, `largest` the traction that has room, all of this solution if not given.
    """
    field, lengths = finest_fields(sol), lengths_of(sol)
    traction, bound = field.traction[:, 0], sol.traction_bound[0]
    finite = bool(np.all(np.isfinite(bound)))
    most = max(float(bound.max()) if finite else 0.0, float(np.abs(traction).max()))
    measured = measure_of(sol.scene, "pressure", most if largest is None else largest)
    _line_areas(ax, sol, field)
    if finite:
        x = lengths(sol.grid.x)
        ax.plot(x, measured(bound), color=style.BOUND_COLOUR, linewidth=0.9, label="$\\pm$ traction bound")
        ax.plot(x, -measured(bound), color=style.BOUND_COLOUR, linewidth=0.9)
    _line_components(ax, sol, field.grid, measured(traction))
    ax.set_title(f"Tangential traction on body 1{corrected(field)}")
    _line_frame(ax, sol, measured.label("traction"), box)
    if largest:
        ax.set_ylim(*measured([-1.08 * largest, 1.08 * largest]))


def draw_line_field(ax: Axes, sol: Solution, name: str) -> None:
    """One of `FIELDS` along x: slip, over stick and slip areas, by its components."""
    field = FIELDS[name]
    values, (grid, state, words) = field.values(sol), field.place(sol)
    along = values[..., 0, :] if field.outside else np.where(state[0] > 0, values[..., 0, :], np.nan)
    measured = field.measured(sol, along)
    title, label = field.title, field.name
    if sol.scene.motion is not None:
        _line_areas(ax, sol, finest_fields(sol))
    if values.ndim == 3:
        label = "shift" if is_shift(sol) else "relative slip"
        title = f"{label.capitalize()} of body 1 over body 2"
        _line_components(ax, sol, grid, measured(along))
    else:
        ax.plot(lengths_of(sol)(grid.x), measured(along), "o-", color=style.TRACTION_COLOUR)
    ax.set_title(title + words)
    _line_frame(ax, sol, measured.label(label))


def _line_areas(ax: Axes, sol: Solution, field: FinestFields) -> None:
    edges = lengths_of(sol)(field.grid.lines[0])
    for number, (name, look) in style.LOOKS.items():
        label = name
        for left, right in edges[runs(field.state[0] == number)]:
            ax.axvspan(left, right, zorder=0, label=label, **look)
            label = "_" + name  # matplotlib lists the first of them only


def _line_components(ax: Axes, sol: Solution, grid: Grid, values: np.ndarray) -> None:
    """Values (2, nx) along x; their second component where there is lateral motion."""
    motion, x = sol.motion, lengths_of(sol)(grid.x)
    ax.plot(x, values[0], "o-", color=style.TRACTION_COLOUR, label="along x")
    if motion is not None and (motion.rigid[1] != 0 or motion.Fy is not None):
        ax.plot(x, values[1], "s--", color=style.LATERAL_COLOUR, label="along y")


def _line_frame(ax: Axes, sol: Solution, name: str, box: Box | None = None) -> None:
    style.readable_ticks(ax)
    lengths = lengths_of(sol)
    left, right, _, _ = box_of(sol.state > 0, sol.grid) if box is None else box
    ax.set_xlim(*lengths((left, right)))
    ax.axhline(0, color="k", linewidth=0.5)
    ax.set_ylabel(name)
    ax.set_xlabel(x_label(sol, lengths))
    style.legend_below(ax, columns=5)
