"""Maps of the contact: stick and slip with tractions on them, and fields in colours."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from varcontact.discrete.stick_slip import SLIP, STICK
from varcontact.plotting.drawn import Drawn, drawn
from varcontact.plotting.quantities import Measure, measure_of
from varcontact.plotting.style import (
    HATCH,
    ROLLING,
    SLIP_COLOUR,
    SLIP_INK,
    STICK_COLOUR,
    TRACTION_COLOUR,
    area_patches,
    colour_bar,
    legend_below,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.path import Path

    from varcontact.results.solution import Solution
    from varcontact.scene.grid import Grid

Box = tuple[float, float, float, float]
NOT_EQUAL = "(x and y not to one scale)"


@dataclass(frozen=True)
class Field:
    """A field over the contact that has a picture.

    Attributes
    ----------
    title : str
        Of the panel.
    name : str
        On the colour bar, or along y.
    values : callable
        From a solution its field, (ny, nx), or of a vector (2, ny, nx).
    quantity : callable
        From a solution what it is measured in, as of `measure`.
    colours : str
        A map that rises in brightness.
    outside : bool
        Whether it is shown outside the contact as well.
    of_tractions : bool
        Whether it is on parts of the elements where a solution was corrected.
    """

    title: str
    name: str
    values: Callable[[Solution], np.ndarray]
    quantity: Callable[[Solution], str]
    colours: str = "viridis"
    outside: bool = False
    of_tractions: bool = False

    def on(self, sol: Solution) -> tuple[Grid, np.ndarray, str]:
        """The grid it is on, the state of its elements, and what its title says of them.

        Parameters
        ----------
        sol : Solution
        """
        if not self.of_tractions:
            return sol.grid, sol.state, ""
        shown = drawn(sol)
        return shown.grid, shown.state, shown.words


def _shifts(sol: Solution) -> bool:
    return sol.motion is not None and sol.motion.rolls == 0


FIELDS = {
    "pressure": Field("Pressure", "pressure", lambda sol: sol.pressure, lambda _: "pressure"),
    "slip": Field(
        "Slip of body 1 over body 2",
        "slip",
        lambda sol: drawn(sol).slip,
        lambda sol: "length" if _shifts(sol) else "1",
        "YlOrBr",
        of_tractions=True,
    ),
    "distance": Field(
        "Distance of the bodies", "distance", lambda sol: sol.distance, lambda _: "length", "cividis", True
    ),
    "power_density": Field(
        "Power density of friction",
        "work by area",
        lambda sol: sol.power_density if sol.refinement is None else drawn(sol).power_density,
        lambda sol: "line force" if _shifts(sol) else "pressure",
        "YlOrBr",
        of_tractions=True,
    ),
}
"""By the word for `Solution.plot`."""


def draw_areas(ax: Axes, sol: Solution, box: Box | None = None, largest: float | None = None) -> None:
    """Stick and slip areas, traction arrows on them, and the spin pole where it lies in the picture.

    Of a corrected solution they are those of the parts of the elements.

    Parameters
    ----------
    ax : Axes
    sol : Solution
    box : tuple of float, optional
        Left, right, bottom and top of what is shown [length]; the contact with a margin if not given.
    largest : float, optional
        Traction with the longest arrow [force/area]; the largest of this solution if not given.
    """
    from matplotlib.lines import Line2D

    shown = _box(sol) if box is None else box
    lengths, field = _lengths(sol), drawn(sol)
    _draw_stick_and_slip(ax, field, lengths)
    handles = area_patches()
    every = max(1, int(np.ceil(max(field.grid.shape) / 26)))
    iy, ix = np.nonzero(field.state[every // 2 :: every, every // 2 :: every])
    arrows = iy * every + every // 2, ix * every + every // 2
    size = np.hypot(*field.traction).max(initial=0.0)
    if _draw_arrows(
        ax, field.grid, field.traction, arrows, lengths, every, shown, size if largest is None else largest
    ):
        words = f"traction, up to {measure_of(sol.scene, 'pressure', size).text(size)}"
        handles.append(Line2D([], [], color=TRACTION_COLOUR, marker=r"$\rightarrow$", markersize=9, ls="", label=words))
    first, second, turn = sol.creepage
    left, right, bottom, top = shown
    if turn != 0 and left < -second / turn < right and bottom < first / turn < top:
        place = lengths(-second / turn), lengths(first / turn)
        handles += ax.plot(*place, "k.", markersize=7, label="spin pole")
    ax.set_title(f"Tangential traction on body 1{field.words}")
    _frame(ax, sol, lengths, shown)
    legend_below(ax, handles, columns=2)


def draw_field(ax: Axes, sol: Solution, name: str) -> None:
    """A field in colours with its bar; slip with its directions, and outside the contact its edge.

    Parameters
    ----------
    ax : Axes
    sol : Solution
    name : str
        One of `FIELDS`.
    """
    field, lengths = FIELDS[name], _lengths(sol)
    values, (grid, state, words) = field.values(sol), field.on(sol)
    size = np.hypot(*values) if values.ndim == 3 else values
    shown = np.ma.masked_invalid(size if field.outside else np.where(state > 0, size, np.nan))
    measured = measure_of(sol.scene, field.quantity(sol), shown.filled(0.0))
    left, right, bottom, top = (float(lengths(edge)) for edge in sol.grid.box)
    image = ax.imshow(
        shown * measured.factor,
        origin="lower",
        extent=(left, right, bottom, top),
        cmap=field.colours,
        vmin=0.0 if shown.count() and (words or shown.min() >= -1e-6 * shown.max()) else None,
        aspect="auto",
    )
    colour_bar(ax, image, measured.label(field.name))
    box = sol.grid.box if field.outside else _box(sol)
    if values.ndim == 3:
        every = max(1, int(np.ceil(max(grid.shape) / 20)))
        iy, ix = np.nonzero((state == SLIP)[every // 2 :: every, every // 2 :: every])
        arrows = iy * every + every // 2, ix * every + every // 2
        _draw_arrows(ax, grid, values, arrows, lengths, every, box, float(size.max(initial=0.0)))
    ax.set_title(field.title + words)
    _frame(ax, sol, lengths, box)
    if field.outside:
        _draw_edge(ax, sol, lengths)
        legend_below(ax)


def elements_path(chosen: np.ndarray, grid: Grid, factor: float = 1.0) -> Path:
    """The outline of some elements, in one rectangle for each run along x.

    Parameters
    ----------
    chosen : ndarray of bool, shape (ny, nx)
    grid : Grid
        Explicit.
    factor : float
        Of lengths.
    """
    from matplotlib.path import Path

    (dx, dy), vertices = grid.sides, []
    left, bottom = grid.x[0] - dx / 2, grid.y[0] - dy / 2
    for row in np.flatnonzero(chosen.any(axis=1)):
        changes = np.flatnonzero(np.diff(chosen[row], prepend=False, append=False))
        low, high = bottom + row * dy, bottom + (row + 1) * dy
        for begin, end in (left + dx * changes).reshape(-1, 2):
            vertices += [(begin, low), (end, low), (end, high), (begin, high), (begin, low)]
    codes = [Path.MOVETO, Path.LINETO, Path.LINETO, Path.LINETO, Path.CLOSEPOLY] * (len(vertices) // 5)
    return Path(factor * np.array(vertices, dtype=float).reshape(-1, 2), codes)


def _draw_stick_and_slip(ax: Axes, field: Drawn, lengths: Measure) -> None:
    from matplotlib.patches import PathPatch

    looks: dict[int, dict[str, Any]] = {
        STICK: {"facecolor": STICK_COLOUR, "gid": "stick"},
        SLIP: {"facecolor": SLIP_COLOUR, "edgecolor": SLIP_INK, "hatch": HATCH, "gid": "slip"},
    }
    for number, look in looks.items():
        ax.add_patch(PathPatch(elements_path(field.state == number, field.grid, lengths.factor), linewidth=0, **look))


def _draw_arrows(
    ax: Axes,
    grid: Grid,
    values: np.ndarray,
    arrows: tuple[np.ndarray, np.ndarray],
    lengths: Measure,
    every: int,
    box: Box,
    largest: float,
) -> bool:
    """Arrows at some elements, the longest as long as nearly two of the elements shown; whether there are any."""
    if largest <= 0 or arrows[0].size == 0:
        return False
    u, v = values[:, *arrows] / largest
    scale: dict[str, Any]
    if _equal(box):
        length = 1.6 * every * float(lengths(max(grid.sides)))
        scale = {"angles": "xy", "scale_units": "xy", "scale": 1 / length}
    else:  # directions are kept on the page, and the longest arrow is a twentieth of its width
        scale = {"angles": "uv", "scale_units": "width", "scale": 20}
    x, y = lengths(grid.x[arrows[1]]), lengths(grid.y[arrows[0]])
    ax.quiver(x, y, u, v, color=TRACTION_COLOUR, width=0.005, pivot="tail", zorder=3, **scale)
    return True


def _draw_edge(ax: Axes, sol: Solution, lengths: Measure) -> None:
    """The edge of the contact, along the sides of its elements."""
    from matplotlib.collections import LineCollection

    inside = np.pad(sol.state > 0, 1)
    (dx, dy), x, y = sol.grid.sides, sol.grid.x, sol.grid.y
    x, y = np.append(x - dx / 2, x[-1] + dx / 2), np.append(y - dy / 2, y[-1] + dy / 2)
    upright = [((x[i], y[j]), (x[i], y[j + 1])) for j, i in np.argwhere(np.diff(inside[1:-1], axis=1))]
    level = [((x[i], y[j]), (x[i + 1], y[j])) for j, i in np.argwhere(np.diff(inside[:, 1:-1], axis=0))]
    if upright:
        ax.add_collection(LineCollection(list(lengths(upright + level)), colors="w", linewidths=1.0))
        ax.plot([], [], color="0.6", linewidth=1.0, label="edge of the contact (white)")


def _frame(ax: Axes, sol: Solution, lengths: Measure, box: Box) -> None:
    """Labels, limits, and axes to one scale, or a word where they are not."""
    from varcontact.plotting.ticks import readable_ticks

    readable_ticks(ax)
    rolls = ROLLING.get(sol.motion.rolls if sol.motion is not None else 0, "")
    equal = _equal(box)
    ax.set_xlabel(lengths.label("x") + rolls + ("" if equal else f"\n{NOT_EQUAL}"))
    ax.set_ylabel(lengths.label("y"))
    box_aspect = ax.get_box_aspect()  # of our own figures, whose panels are of one height
    left, right, bottom, top = lengths(box if box_aspect is None or not equal else _spread(box, box_aspect))
    ax.set_xlim(left, right)
    ax.set_ylim(bottom, top)
    if box_aspect is None:
        ax.set_aspect("equal" if equal else "auto")


def shape_of(sol: Solution) -> float:
    """Height by width of panels that suits a contact.

    Parameters
    ----------
    sol : Solution
    """
    left, right, bottom, top = box = _box(sol)
    return float(np.clip((top - bottom) / (right - left), 0.7, 1.3)) if _equal(box) else 1.0


def _spread(box: Box, shape: float) -> Box:
    """More of the plane, so that lengths are the same along x and y in axes of this height by width."""
    left, right, bottom, top = box
    width, height = max(right - left, (top - bottom) / shape), max(top - bottom, (right - left) * shape)
    x, y = (left + right) / 2, (bottom + top) / 2
    return x - width / 2, x + width / 2, y - height / 2, y + height / 2


def _lengths(sol: Solution) -> Measure:
    """How lengths in the plane are shown."""
    return measure_of(sol.scene, "length", sol.grid.box)


def _box(sol: Solution) -> Box:
    return box_of(sol.state > 0, sol.grid)


def box_of(contact: np.ndarray, grid: Grid) -> Box:
    """Left, right, bottom and top of some elements with a margin of two; of none, those of the grid [length].

    Parameters
    ----------
    contact : ndarray of bool, shape (ny, nx)
    grid : Grid
        Explicit.
    """
    if not contact.any():
        return grid.box
    (dx, dy), x, y = grid.sides, grid.x[contact.any(axis=0)], grid.y[contact.any(axis=1)]
    return x[0] - 2.5 * dx, x[-1] + 2.5 * dx, y[0] - 2.5 * dy, y[-1] + 2.5 * dy


def _equal(box: Box) -> bool:
    left, right, bottom, top = box
    return 0.2 < (right - left) / (top - bottom) < 5
