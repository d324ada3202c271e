"""Fields over the contact: maps of stick and slip with tractions and of others in colours; curves
along rows.
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
"""Left, right, bottom and top of what is shown [length]."""


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
    "power_density": Field("Power density of friction", "work by area", "power density", "YlOrBr"),
    "temperature": Field(
        "Temperature of body 1", "temperature [degrees]", "1", "inferno", outside=True
    ),
}
"""By the word for `Solution.plot`, which is the name in the solution."""


def is_shift(sol: Solution) -> bool:
    return sol.motion is not None and sol.motion.rolls == 0


def draw_states(
    ax: Axes, state: np.ndarray, x: np.ndarray, y: np.ndarray, plastic: bool, **options: Any
) -> None:
    """Areas of elements (ny, nx) by their state, between lines at x and y; each in one rectangle
    for a run along x.
    """
    for number, (name, look) in enumerate(list(style.LOOKS.items())[: 2 + plastic], 1):
        inside = np.pad(state == number, ((0, 0), (0, 1))).ravel()
        first, end = np.flatnonzero(np.diff(inside, prepend=False)).reshape(-1, 2).T
        row = first // x.size
        left, right, low, high = x[first % x.size], x[end % x.size], y[row], y[row + 1]
        corners = np.array([[left, low], [right, low], [right, high], [left, high], [left, low]])
        codes = [Path.MOVETO, Path.LINETO, Path.LINETO, Path.LINETO, Path.CLOSEPOLY] * row.size
        outline = Path(corners.transpose(2, 0, 1).reshape(-1, 2), codes)
        ax.add_patch(PathPatch(outline, gid=name, label=name, **look, **options))


def draw_areas(
    ax: Axes, sol: Solution, box: Box | None = None, largest: float | None = None
) -> None:
    """Stick and slip areas, traction arrows on them, and the spin pole where it lies in the
    picture.

    `box` is the contact with a margin, `largest` the largest traction, that with the longest arrow,
    if not given.
    """
    shown = box_of(sol.state > 0, sol.grid) if box is None else box
    lengths = measure(sol.scene, "length", sol.grid.box)
    state = sol.state
    # slip at the leading edge, before elements that stick, is grid error
    if isinstance(sol.motion, Steady):
        around = np.pad(state, ((0, 0), (1, 1)))
        leading = (around[:, 2:] == EXTERIOR) & (around[:, :-2] == STICK)
        state = np.where(leading & (state == SLIP), STICK, state)
    x, y = sol.grid.lines
    draw_states(ax, state, lengths(x), lengths(y), sol.plastic is not None)
    size = np.hypot(*sol.traction).max(initial=0.0)
    if _draw_arrows(ax, sol.grid, sol.traction, sol.state > 0, 26, lengths, shown, largest or size):
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
    left, right, bottom, top = shown
    if spin != 0 and left < -vy / spin < right and bottom < vx / spin < top:
        ax.plot(lengths(-vy / spin), lengths(vx / spin), "k.", markersize=7, label="spin pole")
    ax.set_title("Tangential traction on body 1")
    _frame(ax, sol, lengths, shown)
    style.legend_below(ax, columns=2)


def draw_field(ax: Axes, sol: Solution, name: str) -> None:
    """One of `FIELDS`: in colours with its bar, slip with its directions, and outside the contact
    its edge; or a curve.

    In line contact vectors are drawn by their components, over stick and slip areas.
    """
    field, lengths = FIELDS[name], measure(sol.scene, "length", sol.grid.box)
    values = np.asarray(getattr(sol, name))
    if name == "temperature":
        values = values[0]
    values = values if field.outside else np.where(sol.state > 0, values, np.nan)
    size = np.hypot(*values) if values.ndim == 3 else values
    measured = measure(sol.scene, moved(field.quantity, is_shift(sol)), size)
    ax.set_title(field.title)
    if sol.scene.line:
        if sol.scene.motion is not None:
            _line_areas(ax, sol, lengths)
        x, label = lengths(sol.grid.x), field.label
        if values.ndim == 3:
            label = "shift" if is_shift(sol) else "relative slip"
            ax.set_title(f"{label.capitalize()} of body 1 over body 2")
            _draw_components(ax, x, measured(values[:, 0]), True)
        else:
            ax.plot(x, measured(values[0]), "o-", color=style.TRACTION_COLOUR)
        ax.set_ylabel(measured.label(label))
        _section_frame(ax, sol, lengths, box_of(sol.state > 0, sol.grid))
        return
    shown = np.ma.masked_invalid(size)
    image = ax.imshow(
        measured(1.0) * shown,
        origin="lower",
        extent=tuple(lengths(sol.grid.box).tolist()),
        cmap=field.colours,
        vmin=0.0 if shown.count() and shown.min() >= -1e-6 * shown.max() else None,
        aspect="auto",
    )
    style.colour_bar(ax, image, measured.label(field.label))
    box = sol.grid.box if field.outside else box_of(sol.state > 0, sol.grid)
    if values.ndim == 3:
        _draw_arrows(ax, sol.grid, values, sol.state == SLIP, 20, lengths, box, float(shown.max()))
    _frame(ax, sol, lengths, box)
    contact = sol.state > 0
    if field.outside and contact.any():
        ax.contour(
            lengths(sol.grid.x), lengths(sol.grid.y), contact, [0.5], colors="w", linewidths=1.0
        )
        ax.plot([], [], color="0.6", linewidth=1.0, label="contact edge")
        style.legend_below(ax)


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
    line, grid = sol.scene.line, sol.grid
    row, lengths = int(np.argmax(sol.pressure.max(axis=1))), measure(sol.scene, "length", grid.box)
    if y is not None:
        y = checks.number("y", y)
        if line:
            raise SceneError("y", y, "left out in line contact, which is the same in all sections")
        _, _, bottom, top = grid.box
        if not bottom <= y <= top:
            raise SceneError("y", y, f"on the grid, from {bottom:.6g} to {top:.6g}")
        row = _nearest_row(grid, y)
    if sol.scene.motion is None:
        measured = measure(sol.scene, "pressure", sol.pressure[row])
        ax.plot(lengths(grid.x), measured(sol.pressure[row]), "o-", color=style.TRACTION_COLOUR)
        ax.set_ylabel(measured.label("pressure"))
    else:
        x, traction, bound = lengths(grid.x), sol.traction[:, row], sol.traction_bound[row]
        most = np.abs([*traction.ravel(), *bound[np.isfinite(bound)]]).max(initial=0.0)
        measured = measure(sol.scene, "pressure", most if largest is None else largest)
        if line:
            _line_areas(ax, sol, lengths)
        if np.all(np.isfinite(bound)):
            ends = measured(bound)
            if not line:
                ax.fill_between(x, -ends, ends, color="0.93", linewidth=0)
            ax.plot(x, ends, color=style.BOUND_COLOUR, linewidth=0.9, label="$\\pm$ traction bound")
            ax.plot(x, -ends, color=style.BOUND_COLOUR, linewidth=0.9)
        if not line or traction[1].any():
            ax.plot(x, measured(np.hypot(*traction)), color="k", linewidth=1.6, label="$|p|$")
        _draw_components(ax, x, measured(traction), line)
        ax.set_ylabel(measured.label("traction"))
    place = float(grid.y[row])
    at = lengths.text(0.0 if abs(place) < 1e-9 * grid.sides[1] else place)
    of_line = "Section along x" if sol.scene.motion is None else "Tangential traction on body 1"
    ax.set_title(of_line if line else f"Section at y = {at}")
    in_row = np.zeros_like(sol.state, dtype=bool)
    in_row[row] = sol.state[row] > 0
    _section_frame(ax, sol, lengths, box_of(in_row, grid) if box is None else box)
    if largest:
        ax.set_ylim(*measured([-1.08 * largest, 1.08 * largest]))


def _nearest_row(grid: Grid, y: float) -> int:
    return int(np.argmin(np.abs(grid.y - y)))


def box_of(contact: np.ndarray, grid: Grid) -> Box:
    """Some elements (ny, nx) with a margin of two; of none, the whole grid."""
    if not contact.any():
        return grid.box
    (dx, dy), x, y = grid.sides, grid.x[contact.any(axis=0)], grid.y[contact.any(axis=1)]
    return x[0] - 2.5 * dx, x[-1] + 2.5 * dx, y[0] - 2.5 * dy, y[-1] + 2.5 * dy


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
    """Arrows on some elements, `most` along a side, the longest nearly two distances long; whether
    there are any.
    """
    every = max(1, int(np.ceil(max(grid.shape) / most)))
    iy, ix = (
        every * i + every // 2 for i in np.nonzero(where[every // 2 :: every, every // 2 :: every])
    )
    if largest <= 0 or ix.size == 0:
        return False
    u, v = values[:, iy, ix] / largest
    # if axes are not to one scale, directions are kept on the page, and the longest arrow is a
    # twentieth of its width
    scale: dict[str, Any] = {"angles": "uv", "scale_units": "width", "scale": 20}
    if to_scale(box):
        length = 1.6 * every * float(lengths(max(grid.sides)))
        scale = {"angles": "xy", "scale_units": "xy", "scale": 1 / length}
    x, y = lengths(grid.x[ix]), lengths(grid.y[iy])
    ax.quiver(x, y, u, v, color=style.TRACTION_COLOUR, width=0.005, pivot="tail", zorder=3, **scale)
    return True


def _frame(ax: Axes, sol: Solution, lengths: Measure, box: Box) -> None:
    """Labels, limits, and axes to one scale, or a word where they are not."""
    equal = to_scale(box)
    ax.set_aspect("equal" if equal else "auto")
    ax.set_xlabel(_x_label(sol, lengths) + ("" if equal else "\n(x and y not to one scale)"))
    ax.set_ylabel(lengths.label("y"))
    ax.set_xlim(*lengths(box[:2]))
    ax.set_ylim(*lengths(box[2:]))


def to_scale(box: Box) -> bool:
    """Whether a box is so near a square that its axes are to one scale."""
    left, right, bottom, top = box
    return 0.2 < (right - left) / (top - bottom) < 5


def _x_label(sol: Solution, lengths: Measure) -> str:
    return lengths.label("x") + style.ROLLING.get(
        sol.motion.rolls if sol.motion is not None else 0, ""
    )


def _line_areas(ax: Axes, sol: Solution, lengths: Measure) -> None:
    x, page = lengths(sol.grid.lines[0]), np.array([0.0, 1.0])
    draw_states(
        ax,
        sol.state,
        x,
        page,
        sol.plastic is not None,
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
