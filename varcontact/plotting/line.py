"""Pictures of a line contact: tractions within their bound, and other fields, over stick and slip areas."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from varcontact.discrete.stick_slip import SLIP, STICK
from varcontact.plotting.fields import FIELDS, Box, box_of, corrected, is_shift, lengths_of, runs, x_label
from varcontact.plotting.style import (
    BOUND_COLOUR,
    LATERAL_COLOUR,
    SLIP_LOOK,
    STICK_LOOK,
    TRACTION_COLOUR,
    legend_below,
    readable_ticks,
)
from varcontact.plotting.unit_labels import measure_of
from varcontact.results.finest_fields import FinestFields, finest_fields

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from varcontact.results.solution import Solution
    from varcontact.scene.grid import Grid


def draw_line_traction(ax: Axes, sol: Solution, box: Box | None = None, largest: float | None = None) -> None:
    """Tractions along x between plus and minus the traction bound, over stick and slip areas.

    `box` is the contact with a margin, `largest` the traction that has room, all of this solution if not given.
    """
    field, lengths = finest_fields(sol), lengths_of(sol)
    traction, bound = field.traction[:, 0], field.bound[0]
    finite = bool(np.all(np.isfinite(bound)))
    most = max(float(bound.max()) if finite else 0.0, float(np.abs(traction).max()))
    measured = measure_of(sol.scene, "pressure", most if largest is None else largest)
    _draw_areas(ax, sol, field)
    if finite:
        x = lengths(field.bound_grid.x)
        ax.plot(x, measured(bound), color=BOUND_COLOUR, linewidth=0.9, label="$\\pm$ traction bound")
        ax.plot(x, -measured(bound), color=BOUND_COLOUR, linewidth=0.9)
    _draw_components(ax, sol, field.grid, measured(traction))
    ax.set_title(f"Tangential traction on body 1{corrected(field)}")
    _frame(ax, sol, measured.label("traction"), box)
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
        _draw_areas(ax, sol, finest_fields(sol))
    if values.ndim == 3:
        label = "shift" if is_shift(sol) else "relative slip"
        title = f"{label.capitalize()} of body 1 over body 2"
        _draw_components(ax, sol, grid, measured(along))
    else:
        ax.plot(lengths_of(sol)(grid.x), measured(along), "o-", color=TRACTION_COLOUR)
    ax.set_title(title + words)
    _frame(ax, sol, measured.label(label))


def _draw_areas(ax: Axes, sol: Solution, field: FinestFields) -> None:
    """Stick and slip areas as strips over the whole height."""
    edges = lengths_of(sol)(field.grid.lines[0])
    for number, name, look in ((STICK, "stick", STICK_LOOK), (SLIP, "slip", SLIP_LOOK)):
        label = name
        for left, right in edges[runs(field.state[0] == number)]:
            ax.axvspan(left, right, zorder=0, label=label, **look)
            label = "_" + name  # matplotlib lists the first of them only


def _draw_components(ax: Axes, sol: Solution, grid: Grid, values: np.ndarray) -> None:
    """Values (2, nx) along x; their second component where there is lateral motion."""
    motion, x = sol.motion, lengths_of(sol)(grid.x)
    ax.plot(x, values[0], "o-", color=TRACTION_COLOUR, label="along x")
    if motion is not None and (motion.rigid[1] != 0 or motion.Fy is not None):
        ax.plot(x, values[1], "s--", color=LATERAL_COLOUR, label="along y")


def _frame(ax: Axes, sol: Solution, name: str, box: Box | None = None) -> None:
    """Labels, and the contact with a margin."""
    readable_ticks(ax)
    lengths = lengths_of(sol)
    left, right, _, _ = box_of(sol.state > 0, sol.grid) if box is None else box
    ax.set_xlim(*lengths((left, right)))
    ax.axhline(0, color="k", linewidth=0.5)
    ax.set_ylabel(name)
    ax.set_xlabel(x_label(sol, lengths))
    legend_below(ax, columns=5)
