"""Fields over the contact: maps of stick and slip with tractions, colour maps of other fields, and
curves along rows.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import PathPatch
from matplotlib.path import Path

from varcontact import checks
from varcontact.discrete.stick_slip import EXTERIOR, SLIP, STICK
from varcontact.errors import SceneError
from varcontact.plotting import style
from varcontact.plotting.unit_labels import Measure, measure
from varcontact.results.solution import Solution
from varcontact.scene.grid import Grid
from varcontact.scene.motion import Steady
from varcontact.scene.units import moved

Box = tuple[float, float, float, float]
"""Left, right, bottom and top of the picture [length]."""


@dataclass(frozen=True)
class Field:
    """A field of a solution, (ny, nx) or of vectors (2, ny, nx), that has a picture.

    `quantity` is one of `measure`, in rolling and in a shift.
    """

    title: str
    label: str
    quantity: str
    colours: str
    outside: bool = False


FIELDS = {
    "pressure": Field("Pressure", "pressure", "pressure", "viridis"),
    "slip": Field("Slip of body 1 over body 2", "slip", "slip", "YlOrBr"),
    "distance": Field("Distance of the bodies", "distance", "length", "cividis", outside=True),
    "power_density": Field("Power density of friction", "work per area", "power density", "YlOrBr"),
    "temperature": Field(
        "Temperature of body 1", "temperature [degrees]", "1", "inferno", outside=True
    ),
}
"""Fields by the word for `Solution.plot`, which is the name in the solution."""


def is_shift(sol: Solution) -> bool:
    return sol.motion is not None and sol.motion.rolls == 0


def draw_states(
    ax: Axes, state: np.ndarray, x: np.ndarray, y: np.ndarray, states: int, **options: Any
) -> None:
    """Areas of elements (ny, nx) by their state, between lines at x and y; each in one rectangle
    for a run along x.
    """
    for number, (name, look) in enumerate(list(style.LOOKS.items())[:states], 1):
        inside = np.pad(state == number, ((0, 0), (0, 1))).ravel()
        first, end = np.flatnonzero(np.diff(inside, prepend=False)).reshape(-1, 2).T
        row = first // x.size
        left = x[first % x.size]
        right = x[end % x.size]
        low = y[row]
        high = y[row + 1]
        corners = np.array([[left, low], [right, low], [right, high], [left, high], [left, low]])
        codes = [Path.MOVETO, Path.LINETO, Path.LINETO, Path.LINETO, Path.CLOSEPOLY] * row.size
        outline = Path(corners.transpose(2, 0, 1).reshape(-1, 2), codes)
        ax.add_patch(PathPatch(outline, gid=name, label=name, **look, **options))


def draw_areas(
    ax: Axes, sol: Solution, box: Box | None = None, largest: float | None = None
) -> None:
    """Stick and slip areas, traction arrows on them, and the spin pole if it is within the picture.

    `box` is the contact with a margin, `largest` the largest traction, that with the longest arrow,
    if not given.
    """
    if box is None:
        box = box_of(sol.state > 0, sol.grid)
    lengths = measure(sol.scene, "length", sol.grid.box)
    state = sol.state
    # slip at the leading edge, before elements that stick, is grid error
    if isinstance(sol.motion, Steady):
        around = np.pad(state, ((0, 0), (1, 1)))
        leading = (around[:, 2:] == EXTERIOR) & (around[:, :-2] == STICK)
        state = np.where(leading & (state == SLIP), STICK, state)
    x, y = sol.grid.lines
    draw_states(ax, state, lengths(x), lengths(y), len(sol.states))
    size = np.hypot(*sol.traction).max(initial=0.0)
    arrows = Arrows(sol.traction, sol.state > 0, 26, largest or size)
    if _draw_arrows(ax, sol.grid, arrows, lengths, box):
        words = f"traction, up to {measure(sol.scene, 'pressure', size).text(size)}"
        ax.plot(
            [],
            [],
            color=style.TRACTION_COLOUR,
            marker=r"$\rightarrow$",
            markersize=9,
            ls="",
            label=words,
        )
    vx, vy, spin = sol.creepage
    left, right, bottom, top = box
    if spin != 0 and left < -vy / spin < right and bottom < vx / spin < top:
        ax.plot(lengths(-vy / spin), lengths(vx / spin), "k.", markersize=7, label="spin pole")
    ax.set_title("Tangential traction on body 1")
    _frame(ax, sol, lengths, box)
    style.legend_below(ax, columns=2)


def draw_field(ax: Axes, sol: Solution, name: str) -> None:
    """One of `FIELDS`: in colours with its bar, slip with its directions, and outside the contact
    its edge; or a curve.

    In line contact vectors are drawn by their components, over stick and slip areas.
    """
    field = FIELDS[name]
    contact = sol.state > 0
    values = np.asarray(getattr(sol, name))
    if name == "temperature":
        values = values[0]
    if not field.outside:
        values = np.where(contact, values, np.nan)
    size = np.hypot(*values) if values.ndim == 3 else values
    measured = measure(sol.scene, moved(field.quantity, is_shift(sol)), size)
    ax.set_title(field.title)
    if sol.scene.line:
        _draw_line_field(ax, sol, field, values, measured)
        return
    lengths = measure(sol.scene, "length", sol.grid.box)
    shown = np.ma.masked_invalid(size)
    least = None
    if shown.count() and shown.min() >= -1e-6 * shown.max():
        least = 0.0
    image = ax.imshow(
        measured(1.0) * shown,
        origin="lower",
        extent=tuple(lengths(sol.grid.box).tolist()),
        cmap=field.colours,
        vmin=least,
        aspect="auto",
    )
    style.colour_bar(ax, image, measured.label(field.label))
    box = sol.grid.box
    if not field.outside:
        box = box_of(contact, sol.grid)
    if values.ndim == 3:
        arrows = Arrows(values, sol.state == SLIP, 20, float(shown.max()))
        _draw_arrows(ax, sol.grid, arrows, lengths, box)
    _frame(ax, sol, lengths, box)
    if field.outside and contact.any():
        x = lengths(sol.grid.x)
        y = lengths(sol.grid.y)
        ax.contour(x, y, contact, [0.5], colors="w", linewidths=1.0)
        ax.plot([], [], color="0.6", linewidth=1.0, label="contact edge")
        style.legend_below(ax)


def _draw_line_field(
    ax: Axes, sol: Solution, field: Field, values: np.ndarray, measured: Measure
) -> None:
    """A field of a line contact as a curve, of vectors as two."""
    lengths = measure(sol.scene, "length", sol.grid.box)
    if sol.scene.motion is not None:
        _line_areas(ax, sol, lengths)
    x = lengths(sol.grid.x)
    label = field.label
    if values.ndim == 3:
        label = "shift" if is_shift(sol) else "relative slip"
        ax.set_title(f"{label.capitalize()} of body 1 over body 2")
        _draw_components(ax, x, measured(values[:, 0]), True)
    else:
        ax.plot(x, measured(values[0]), "o-", color=style.TRACTION_COLOUR)
    ax.set_ylabel(measured.label(label))
    _section_frame(ax, sol, lengths, box_of(sol.state > 0, sol.grid))


def draw_section(
    ax: Axes,
    sol: Solution,
    y: float | None = None,
    box: Box | None = None,
    largest: float | None = None,
) -> None:
    """A row of elements: tractions and their size within the traction bound; without a motion the
    pressure.

    In line contact over stick and slip areas; then `box` is the contact with a margin, `largest`
    the traction that has room, all of this solution if not given.
    """
    lengths = measure(sol.scene, "length", sol.grid.box)
    row = _section_row(sol, y)
    if sol.scene.motion is None:
        measured = measure(sol.scene, "pressure", sol.pressure[row])
        x = lengths(sol.grid.x)
        ax.plot(x, measured(sol.pressure[row]), "o-", color=style.TRACTION_COLOUR)
        ax.set_ylabel(measured.label("pressure"))
    else:
        measured = _draw_row_of_tractions(ax, sol, row, largest)
    ax.set_title(_section_title(sol, row, lengths))
    if box is None:
        contact = np.zeros_like(sol.state, dtype=bool)
        contact[row] = sol.state[row] > 0
        box = box_of(contact, sol.grid)
    _section_frame(ax, sol, lengths, box)
    if largest:
        ax.set_ylim(*measured([-1.08 * largest, 1.08 * largest]))


def _section_row(sol: Solution, y: float | None) -> int:
    """The row of elements nearest to y, or the one with the largest pressure."""
    if y is None:
        return int(np.argmax(sol.pressure.max(axis=1)))
    y = checks.number("y", y)
    if sol.scene.line:
        raise SceneError("y", y, "left out in line contact, which is the same in all sections")
    _, _, bottom, top = sol.grid.box
    if not bottom <= y <= top:
        raise SceneError("y", y, f"on the grid, from {bottom:.6g} to {top:.6g}")
    return int(np.argmin(np.abs(sol.grid.y - y)))


def _section_title(sol: Solution, row: int, lengths: Measure) -> str:
    if not sol.scene.line:
        place = float(sol.grid.y[row])
        if abs(place) < 1e-9 * sol.grid.sides[1]:
            place = 0.0
        return f"Section at y = {lengths.text(place)}"
    if sol.scene.motion is None:
        return "Section along x"
    return "Tangential traction on body 1"


def _draw_row_of_tractions(ax: Axes, sol: Solution, row: int, largest: float | None) -> Measure:
    """Tractions of a row, their size and the traction bound; how they are measured."""
    line = sol.scene.line
    lengths = measure(sol.scene, "length", sol.grid.box)
    x = lengths(sol.grid.x)
    traction = sol.traction[:, row]
    bound = sol.traction_bound[row]
    if largest is None:
        finite = bound[np.isfinite(bound)]
        largest = np.abs([*traction.ravel(), *finite]).max(initial=0.0)
    measured = measure(sol.scene, "pressure", largest)
    if line:
        _line_areas(ax, sol, lengths)
    if np.all(np.isfinite(bound)):
        ends = measured(bound)
        if not line:
            ax.fill_between(x, -ends, ends, color="0.93", linewidth=0)
        look: dict[str, Any] = {"color": style.BOUND_COLOUR, "linewidth": 0.9}
        ax.plot(x, ends, **look, label="$\\pm$ traction bound")
        ax.plot(x, -ends, **look)
    if not line or traction[1].any():
        ax.plot(x, measured(np.hypot(*traction)), color="k", linewidth=1.6, label="$|p|$")
    _draw_components(ax, x, measured(traction), line)
    ax.set_ylabel(measured.label("traction"))
    return measured


def box_of(contact: np.ndarray, grid: Grid) -> Box:
    """Box around some elements (ny, nx) with a margin of two; around the whole grid if there are
    none.
    """
    if not contact.any():
        return grid.box
    dx, dy = grid.sides
    x = grid.x[contact.any(axis=0)]
    y = grid.y[contact.any(axis=1)]
    return x[0] - 2.5 * dx, x[-1] + 2.5 * dx, y[0] - 2.5 * dy, y[-1] + 2.5 * dy


@dataclass(frozen=True, eq=False)
class Arrows:
    """Vectors (2, ny, nx) drawn as arrows on some elements of an area, at most so many along a
    side; a vector of the largest size is nearly two distances long.
    """

    vectors: np.ndarray
    area: np.ndarray
    along_side: int
    largest: float


def _draw_arrows(ax: Axes, grid: Grid, arrows: Arrows, lengths: Measure, box: Box) -> bool:
    """Draw arrows; returns False if there are none."""
    every = max(1, int(np.ceil(max(grid.shape) / arrows.along_side)))
    first = every // 2
    drawn = arrows.area[first::every, first::every]
    iy, ix = (every * i + first for i in np.nonzero(drawn))
    if arrows.largest <= 0 or ix.size == 0:
        return False
    u, v = arrows.vectors[:, iy, ix] / arrows.largest
    # if axes are not to one scale, directions are kept on the page, and the longest arrow is a
    # twentieth of its width
    scale: dict[str, Any] = {"angles": "uv", "scale_units": "width", "scale": 20}
    if to_scale(box):
        length = 1.6 * every * float(lengths(max(grid.sides)))
        scale = {"angles": "xy", "scale_units": "xy", "scale": 1 / length}
    x = lengths(grid.x[ix])
    y = lengths(grid.y[iy])
    ax.quiver(x, y, u, v, color=style.TRACTION_COLOUR, width=0.005, pivot="tail", zorder=3, **scale)
    return True


def _frame(ax: Axes, sol: Solution, lengths: Measure, box: Box) -> None:
    """Labels, limits, and equal scales on both axes, or a remark where they are not equal."""
    x_label = _x_label(sol, lengths)
    if to_scale(box):
        ax.set_aspect("equal")
        box = _filling(ax, box)
    else:
        ax.set_aspect("auto")
        x_label += "\n(x and y not to one scale)"
    ax.set_xlabel(x_label)
    ax.set_ylabel(lengths.label("y"))
    ax.set_xlim(*lengths(box[:2]))
    ax.set_ylim(*lengths(box[2:]))


def _filling(ax: Axes, box: Box) -> Box:
    """Box widened to the aspect ratio of axes that have one, so that matplotlib need not widen
    it.
    """
    shape = ax.get_box_aspect()
    if shape is None:
        return box
    left, right, bottom, top = box
    width = max(right - left, (top - bottom) / shape)
    height = shape * width
    x = (left + right) / 2
    y = (bottom + top) / 2
    return x - width / 2, x + width / 2, y - height / 2, y + height / 2


def to_scale(box: Box) -> bool:
    """True for a box close enough to a square for equal scales on both axes."""
    left, right, bottom, top = box
    return 0.2 < (right - left) / (top - bottom) < 5


def _x_label(sol: Solution, lengths: Measure) -> str:
    label = lengths.label("x")
    if sol.motion is None:
        return label
    return label + style.ROLLING.get(sol.motion.rolls, "")


def _line_areas(ax: Axes, sol: Solution, lengths: Measure) -> None:
    x = lengths(sol.grid.lines[0])
    page = np.array([0.0, 1.0])
    draw_states(
        ax,
        sol.state,
        x,
        page,
        len(sol.states),
        transform=ax.get_xaxis_transform(),
        zorder=0,
    )


def _draw_components(ax: Axes, x: np.ndarray, values: np.ndarray, line: bool) -> None:
    """Values (2, nx) along x; their second component where there is any."""
    names = ("along x", "along y") if line else ("$p_x$", "$p_y$")
    look: dict[str, Any] = {"markersize": 2.5, "linewidth": 0.9}
    ax.plot(x, values[0], "o-", color=style.TRACTION_COLOUR, label=names[0], **look)
    sizes = np.abs(np.nan_to_num(values))
    if sizes[1].max() > 1e-9 * sizes.max():
        ax.plot(x, values[1], "s--", color=style.LATERAL_COLOUR, label=names[1], **look)


def _section_frame(ax: Axes, sol: Solution, lengths: Measure, box: Box) -> None:
    ax.set_xlim(*lengths(box[:2]))
    ax.axhline(0, color="k", linewidth=0.5)
    ax.set_xlabel(_x_label(sol, lengths))
    style.legend_below(ax, columns=5 if sol.scene.line else 2)
