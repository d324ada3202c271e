"""Pictures of a solution, in the field's way."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, get_args

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from varcontact import checks
from varcontact.errors import SceneError
from varcontact.plotting import style
from varcontact.plotting.fields import (
    FIELDS,
    corrected,
    draw_areas,
    draw_field,
    draw_line_field,
    draw_line_traction,
    lengths_of,
    shape_of,
)
from varcontact.plotting.unit_labels import measure_of
from varcontact.results.finest_fields import FinestFields, finest_fields
from varcontact.results.solution import Panel, Solution
from varcontact.scene.friction import BRANCHES, Law
from varcontact.scene.friction_laws import kind_of
from varcontact.scene.grid import Grid

PANELS = get_args(Panel)


def plot(
    sol: Solution,
    what: Panel | Sequence[Panel] | None = None,
    *,
    ax: Axes | None = None,
    figsize: tuple[float, float] | None = None,
    y: float | None = None,
) -> Figure:
    """The picture of a solution, see `Solution.plot`."""
    names, line = _names(sol, what, ax), sol.scene.line
    if y is not None:
        row_of(sol, y)
        if "section" not in names:
            raise SceneError("y", y, 'left out, or with the panel "section"')
    with style.styled():
        if ax is not None:
            style.figure_size(figsize, (1.0, 1.0))
            _draw(ax, sol, names[0], y)
            return style.figure_of(ax)
        if line:  # below each other over the same abscissa
            size = style.figure_size(figsize, (1.3 * style.COLUMN, 0.4 + 2.1 * len(names)))
            figure, axes = style.new_figure(len(names), 1, size, sharex=True)
        else:  # panels of one height, three to a row
            rows, columns, shape = -(-len(names) // 3), min(len(names), 3), shape_of(sol)
            width = style.COLUMN if columns == 1 else style.PAGE / 3 * columns
            side = width / columns - (0.7 if columns == 1 else 1.05)  # beside which there are labels and a colour bar
            figure, axes = style.new_figure(
                rows, columns, style.figure_size(figsize, (width, rows * (shape * side + 1.3)))
            )
        for panel, name in zip(axes, names, strict=False):
            if not line:
                panel.set_box_aspect(shape)
            _draw(panel, sol, name, y)
        for panel in axes[len(names) :]:
            panel.set_axis_off()
        if line:
            _one_legend(axes)
        else:
            figure.draw_without_rendering()
        return figure


def _names(sol: Solution, what: Any, ax: Any) -> list[str]:
    style.check_axes(ax)
    if what is None:
        if sol.scene.motion is None:
            names = ["pressure"] if sol.scene.line else ["pressure", "section"]
        else:
            names = ["traction", "slip"] if sol.scene.line else ["pressure", "traction", "section"]
        return names if ax is None else [names[0] if sol.scene.line or sol.scene.motion is None else "traction"]
    names = [what] if isinstance(what, str) or not isinstance(what, Sequence) else list(what)
    for name in names:
        checks.choice("what", name, PANELS)
        if name not in ("pressure", "distance", "section") and sol.scene.motion is None:
            raise SceneError("what", name, "pressure, distance or section, where there is no motion")
        if name == "temperature" and sol.temperature is None:
            raise SceneError("what", name, "another panel: temperatures need thermal data, and steady rolling")
        if name == "power_density" and np.isnan(sol.power_density).all():
            allowed = f"another panel: {sol.plan.tangential} has no moment, and so no power of spin"
            raise SceneError("what", name, allowed)
    if not names or (ax is not None and len(names) > 1):
        raise SceneError("what", what, "one panel" + (" for one ax" if ax is not None else " at least"))
    return names


def _draw(ax: Axes, sol: Solution, name: str, y: float | None) -> None:
    if sol.scene.line and name == "traction":
        draw_line_traction(ax, sol)
    elif sol.scene.line and name in FIELDS:
        draw_line_field(ax, sol, name)
    elif name == "traction":
        draw_areas(ax, sol)
    elif name == "section":
        draw_section(ax, sol, y)
    else:
        draw_field(ax, sol, name)


def _one_legend(axes: list[Axes]) -> None:
    """Panels below each other with the same abscissa: its label and one legend at the foot."""
    entries: dict[str, Any] = {}
    for ax in axes:
        for handle, label in zip(*ax.get_legend_handles_labels(), strict=True):
            entries.setdefault(label, handle)
        legend = ax.get_legend()
        if legend is not None:
            legend.remove()
    for ax in axes[:-1]:
        ax.set_xlabel("")
    if entries:
        style.figure_of(axes[0]).legend(
            entries.values(), entries.keys(), ncols=5, loc="outside lower center", frameon=False
        )


def plot_passes(sol: Solution) -> Figure:
    """Change and residual of the whole against the passes, see `Solution.plot_passes`."""
    if not sol.passes:
        message = f"solution has no passes to plot (coupling {sol.plan.coupling}): loops and laws of friction have them"
        raise SceneError("solution", sol.plan.coupling, message=message)
    if isinstance(sol.scene.friction, Law):
        shown, changed = f"{kind_of(sol.scene.friction)} friction, from {BRANCHES[sol.branch]}", "coefficients"
    else:
        shown = f"{sol.plan.coupling}, {sol.scene.difference}"
        changed = "pressure" if sol.plan.coupling == "joint" else "tractions"
    with style.styled():
        figure, (ax,) = style.new_figure(1, 1, (style.COLUMN, 2.6))
        changes, residuals = np.array(sol.passes).T
        passes = np.arange(1, len(residuals) + 1)
        ax.semilogy(passes, residuals, "o-", color=style.TRACTION_COLOUR, label="residual of the whole")
        ax.semilogy(passes[1:], changes[1:], "s--", color="0.5", label=f"change of the {changed}")
        ax.xaxis.set_major_locator(MaxNLocator(6, integer=True))
        ax.set_xlabel("pass")
        ax.set_ylabel("relative")
        ax.set_title(f"Passes: {shown}" + ("" if sol.converged else " (not converged)"))
        ax.legend()
    return figure


def row_of(sol: Solution, y: float | None) -> int:
    """The row of elements of a section at y, checked; that with the largest pressure if y is not given."""
    if y is None:
        return int(np.argmax(sol.pressure.max(axis=1)))
    y = checks.number("y", y)
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
        ax.plot(lengths(sol.grid.x[shown]), measured(pressure), "o-", color=style.TRACTION_COLOUR)
        ax.set_ylabel(measured.label("pressure"))
    else:
        field = finest_fields(sol)
        left, right = sol.grid.lines[0][[shown.start, min(shown.stop, sol.grid.nx)]]
        row = _nearest_row(field.grid, place if y is None else y)
        _draw_tractions(ax, sol, field, row, (left, right))
        place, words = float(field.grid.y[row]), corrected(field)
    ax.axhline(0, color="k", linewidth=0.5)
    style.readable_ticks(ax)
    ax.set_xlabel(lengths.label("x"))
    at = lengths.text(0.0 if abs(place) < 1e-9 * sol.grid.sides[1] else place)
    ax.set_title(("Section along x" if sol.scene.line else f"Section at y = {at}") + words)
    style.legend_below(ax, columns=2)


def _draw_tractions(ax: Axes, sol: Solution, field: FinestFields, row: int, ends: tuple[float, float]) -> None:
    """Between the bounds of either sign their size and components, the lateral one where there is any."""
    lengths = lengths_of(sol)
    at, of_bound = ((ends[0] < grid.x) & (grid.x < ends[1]) for grid in (field.grid, sol.grid))
    x, traction = lengths(field.grid.x[at]), field.traction[:, row, at]
    bound = sol.traction_bound[_nearest_row(sol.grid, float(field.grid.y[row])), of_bound]
    finite = bool(np.all(np.isfinite(bound)))
    most = max(float(bound.max(initial=0.0)) if finite else 0.0, float(np.abs(traction).max(initial=0.0)))
    measured = measure_of(sol.scene, "pressure", most)
    if finite:
        places, bounds = lengths(sol.grid.x[of_bound]), measured(bound)
        ax.fill_between(places, -bounds, bounds, color="0.93", linewidth=0)
        ax.plot(places, bounds, color=style.BOUND_COLOUR, linewidth=0.9, label="$\\pm$ traction bound")
        ax.plot(places, -bounds, color=style.BOUND_COLOUR, linewidth=0.9)
    size = np.hypot(*traction)
    ax.plot(x, measured(size), color="k", linewidth=1.6, label="$|p|$")
    ax.plot(x, measured(traction[0]), "o-", color=style.TRACTION_COLOUR, markersize=2.5, linewidth=0.9, label="$p_x$")
    if np.abs(traction[1]).max(initial=0.0) > 1e-9 * size.max(initial=0.0):
        ax.plot(
            x, measured(traction[1]), "s--", color=style.LATERAL_COLOUR, markersize=2.5, linewidth=0.9, label="$p_y$"
        )
    ax.set_ylabel(measured.label("traction"))


def _nearest_row(grid: Grid, y: float) -> int:
    return int(np.argmin(np.abs(grid.y - y)))
