"""Sections along x: the tractions and their size beside the traction bound, or the pressure."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from varcontact import checks
from varcontact.errors import SceneError
from varcontact.plotting.fields import corrected, lengths_of
from varcontact.plotting.style import BOUND_COLOUR, LATERAL_COLOUR, TRACTION_COLOUR, legend_below, readable_ticks
from varcontact.plotting.unit_labels import measure_of
from varcontact.results.finest_fields import FinestFields, finest_fields

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from varcontact.results.solution import Solution
    from varcontact.scene.grid import Grid


def row_of(sol: Solution, y: float | None) -> int:
    """The row of elements of a section at y, checked; that with the largest pressure if y is not given."""
    if y is None:
        return int(np.argmax(sol.pressure.max(axis=1)))
    y = checks.moderate("y", y)
    if sol.scene.line:
        raise SceneError("y", y, "left out in line contact, which is the same in all sections")
    _, _, bottom, top = sol.grid.box
    if not bottom <= y <= top:
        raise SceneError("y", y, f"on the grid, from {bottom:.6g} to {top:.6g}")
    return _nearest_row(sol.grid, y)


def draw_section(ax: Axes, sol: Solution, y: float | None = None) -> None:
    """A row of elements: tractions and their size beside the traction bound; without a motion the pressure."""
    row, lengths = row_of(sol, y), lengths_of(sol)
    contact = sol.pressure[row] > 0
    ends = np.flatnonzero(contact) if contact.any() else np.array([0, contact.size])
    shown = slice(max(ends[0] - 1, 0), ends[-1] + 2)
    place, words = float(sol.grid.y[row]), ""
    if sol.scene.motion is None:
        pressure = sol.pressure[row, shown]
        measured = measure_of(sol.scene, "pressure", pressure)
        ax.plot(lengths(sol.grid.x[shown]), measured(pressure), "o-", color=TRACTION_COLOUR)
        ax.set_ylabel(measured.label("pressure"))
    else:
        field = finest_fields(sol)
        left, right = sol.grid.lines[0][[shown.start, min(shown.stop, sol.grid.nx)]]
        row = _nearest_row(field.grid, place if y is None else y)
        _draw_tractions(ax, sol, field, row, (left, right))
        place, words = float(field.grid.y[row]), corrected(field)
    ax.axhline(0, color="k", linewidth=0.5)
    readable_ticks(ax)
    ax.set_xlabel(lengths.label("x"))
    at = lengths.text(0.0 if abs(place) < 1e-9 * sol.grid.sides[1] else place)
    ax.set_title(("Section along x" if sol.scene.line else f"Section at y = {at}") + words)
    legend_below(ax, columns=2)


def _draw_tractions(ax: Axes, sol: Solution, field: FinestFields, row: int, ends: tuple[float, float]) -> None:
    """Between the bounds of either sign their size and components, the lateral one where there is any."""
    lengths = lengths_of(sol)
    at, of_bound = ((ends[0] < grid.x) & (grid.x < ends[1]) for grid in (field.grid, field.bound_grid))
    x, traction = lengths(field.grid.x[at]), field.traction[:, row, at]
    bound = field.bound[_nearest_row(field.bound_grid, float(field.grid.y[row])), of_bound]
    finite = bool(np.all(np.isfinite(bound)))
    most = max(float(bound.max(initial=0.0)) if finite else 0.0, float(np.abs(traction).max(initial=0.0)))
    measured = measure_of(sol.scene, "pressure", most)
    if finite:
        places, bounds = lengths(field.bound_grid.x[of_bound]), measured(bound)
        ax.fill_between(places, -bounds, bounds, color="0.93", linewidth=0)
        ax.plot(places, bounds, color=BOUND_COLOUR, linewidth=0.9, label="$\\pm$ traction bound")
        ax.plot(places, -bounds, color=BOUND_COLOUR, linewidth=0.9)
    size = np.hypot(*traction)
    ax.plot(x, measured(size), color="k", linewidth=1.6, label="$|p|$")
    ax.plot(x, measured(traction[0]), "o-", color=TRACTION_COLOUR, markersize=2.5, linewidth=0.9, label="$p_x$")
    if np.abs(traction[1]).max(initial=0.0) > 1e-9 * size.max(initial=0.0):
        ax.plot(x, measured(traction[1]), "s--", color=LATERAL_COLOUR, markersize=2.5, linewidth=0.9, label="$p_y$")
    ax.set_ylabel(measured.label("traction"))


def _nearest_row(grid: Grid, y: float) -> int:
    return int(np.argmin(np.abs(grid.y - y)))
