"""Pictures of a line contact: tractions within their bound, and other fields, over stick and slip areas."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from varcontact.discrete.stick_slip import SLIP, STICK
from varcontact.plotting.drawn import Drawn, drawn
from varcontact.plotting.maps import FIELDS, Box, box_of
from varcontact.plotting.quantities import measure_of
from varcontact.plotting.style import (
    BOUND_COLOUR,
    HATCH,
    LATERAL_COLOUR,
    ROLLING,
    SLIP_COLOUR,
    SLIP_INK,
    STICK_COLOUR,
    TRACTION_COLOUR,
    legend_below,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from varcontact.results.solution import Solution
    from varcontact.scene.grid import Grid


def draw_line_traction(ax: Axes, sol: Solution, box: Box | None = None, largest: float | None = None) -> None:
    """Tractions along x between plus and minus the traction bound, over stick and slip areas.

    Of a corrected solution they are those of the parts of the elements.

    Parameters
    ----------
    ax : Axes
    sol : Solution
    box : tuple of float, optional
        Left and right of what is shown, and two more [length]; the contact with a margin if not given.
    largest : float, optional
        What has room along the ordinate [force/area]; all of this solution if not given.
    """
    field = drawn(sol)
    (grid, known), traction = field.bounds, field.traction[:, 0]
    bound = known[0]
    finite = bool(np.all(np.isfinite(bound)))
    most = max(float(bound.max()) if finite else 0.0, float(np.abs(traction).max()))
    measured = measure_of(sol.scene, "pressure", most if largest is None else largest)
    _draw_areas(ax, sol, field)
    if finite:
        x = measure_of(sol.scene, "length", sol.grid.box)(grid.x)
        ax.plot(x, measured(bound), color=BOUND_COLOUR, linewidth=0.9, label="$\\pm$ traction bound")
        ax.plot(x, -measured(bound), color=BOUND_COLOUR, linewidth=0.9)
    _draw_components(ax, sol, field.grid, measured(traction))
    ax.set_title(f"Tangential traction on body 1{field.words}")
    _frame(ax, sol, measured.label("traction"), box)
    if largest:
        ax.set_ylim(*measured([-1.08 * largest, 1.08 * largest]))


def draw_line_field(ax: Axes, sol: Solution, name: str) -> None:
    """A field along x: slip, over stick and slip areas, by its components.

    Parameters
    ----------
    ax : Axes
    sol : Solution
    name : str
        One of `FIELDS`.
    """
    field = FIELDS[name]
    values, (grid, state, words) = field.values(sol), field.on(sol)
    along = values[..., 0, :] if field.outside else np.where(state[0] > 0, values[..., 0, :], np.nan)
    measured = measure_of(sol.scene, field.quantity(sol), along)
    title, label = field.title, field.name
    if sol.scene.motion is not None:
        _draw_areas(ax, sol, drawn(sol))
    if values.ndim == 3:
        shift = field.quantity(sol) == "length"
        title = f"{'Shift' if shift else 'Relative slip'} of body 1 over body 2"
        label = "shift" if shift else "relative slip"
        _draw_components(ax, sol, grid, measured(along))
    else:
        x = measure_of(sol.scene, "length", sol.grid.box)(grid.x)
        ax.plot(x, measured(along), "o-", color=TRACTION_COLOUR)
    ax.set_title(title + words)
    _frame(ax, sol, measured.label(label))


def _draw_areas(ax: Axes, sol: Solution, field: Drawn) -> None:
    """Stick and slip areas as strips over the whole height."""
    lengths = measure_of(sol.scene, "length", sol.grid.box)
    edges = lengths(field.grid.lines[0])
    looks: tuple[tuple[int, str, dict[str, Any]], ...] = (
        (STICK, "stick", {"facecolor": STICK_COLOUR}),
        (SLIP, "slip", {"facecolor": SLIP_COLOUR, "edgecolor": SLIP_INK, "hatch": HATCH}),
    )
    for number, name, look in looks:
        changes = np.flatnonzero(np.diff(field.state[0] == number, prepend=False, append=False))
        for left, right in edges[changes].reshape(-1, 2):
            ax.axvspan(left, right, linewidth=0, zorder=0, label=name, **look)
            name = "_" + name  # matplotlib lists the first of them only


def _draw_components(ax: Axes, sol: Solution, grid: Grid, values: np.ndarray) -> None:
    """Values (2, nx) along x; their second component where there is lateral motion."""
    motion = sol.motion
    x = measure_of(sol.scene, "length", sol.grid.box)(grid.x)
    ax.plot(x, values[0], "o-", color=TRACTION_COLOUR, label="along x")
    if motion is not None and (motion.rigid[1] != 0 or motion.Fy is not None):
        ax.plot(x, values[1], "s--", color=LATERAL_COLOUR, label="along y")


def _frame(ax: Axes, sol: Solution, name: str, box: Box | None = None) -> None:
    """Labels, and the contact with a margin."""
    from varcontact.plotting.ticks import readable_ticks

    readable_ticks(ax)
    lengths = measure_of(sol.scene, "length", sol.grid.box)
    ax.set_xlim(*lengths((box_of(sol.state > 0, sol.grid) if box is None else box)[:2]))
    ax.axhline(0, color="k", linewidth=0.5)
    ax.set_ylabel(name)
    ax.set_xlabel(lengths.label("x") + ROLLING.get(sol.motion.rolls if sol.motion is not None else 0, ""))
    legend_below(ax, columns=5)
