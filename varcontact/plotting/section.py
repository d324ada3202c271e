"""Sections along x: the tractions and their size beside the traction bound, or the pressure."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from varcontact import checks
from varcontact.errors import SceneError
from varcontact.plotting.quantities import Measure, measure_of
from varcontact.plotting.style import BOUND_COLOUR, LATERAL_COLOUR, TRACTION_COLOUR, legend_below

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from varcontact.results.solution import Solution


def row_of(sol: Solution, y: float | None) -> int:
    """The row of elements of a section.

    Parameters
    ----------
    sol : Solution
    y : float, optional
        [length]; the row with the largest pressure if not given.

    Raises
    ------
    SceneError
        If there is no element at that y, or in line contact.
    """
    if y is None:
        return int(np.argmax(sol.pressure.max(axis=1)))
    y = checks.moderate("y", y)
    if sol.scene.line:
        raise SceneError("y", y, "left out in line contact, which is the same in all sections")
    _, _, bottom, top = sol.grid.box
    if not bottom <= y <= top:
        raise SceneError("y", y, f"on the grid, from {bottom:.6g} to {top:.6g}")
    return int(np.argmin(np.abs(sol.grid.y - y)))


def draw_section(ax: Axes, sol: Solution, y: float | None = None) -> None:
    """A row of elements: tractions and their size beside the traction bound; without a motion the pressure.

    Parameters
    ----------
    ax : Axes
    sol : Solution
    y : float, optional
        Of the section [length]; the row with the largest pressure if not given.

    Raises
    ------
    SceneError
        If there is no element at that y.
    """
    from varcontact.plotting.ticks import readable_ticks

    row = row_of(sol, y)
    contact = sol.pressure[row] > 0
    ends = np.flatnonzero(contact) if contact.any() else np.array([0, contact.size])
    shown = slice(max(ends[0] - 1, 0), ends[-1] + 2)
    lengths = measure_of(sol.scene, "length", sol.grid.box)
    x = lengths(sol.grid.x[shown])
    if sol.scene.motion is None:
        _draw_pressure(ax, sol, row, shown, x)
    else:
        _draw_tractions(ax, sol, row, shown, x)
    ax.axhline(0, color="k", linewidth=0.5)
    readable_ticks(ax)
    ax.set_xlabel(lengths.label("x"))
    ax.set_title("Section along x" if sol.scene.line else f"Section at y = {_place(sol, row, lengths)}")
    legend_below(ax, columns=2)


def _draw_pressure(ax: Axes, sol: Solution, row: int, shown: slice, x: np.ndarray) -> None:
    pressure = sol.pressure[row, shown]
    measured = measure_of(sol.scene, "pressure", pressure)
    ax.plot(x, measured(pressure), "o-", color=TRACTION_COLOUR)
    ax.set_ylabel(measured.label("pressure"))


def _draw_tractions(ax: Axes, sol: Solution, row: int, shown: slice, x: np.ndarray) -> None:
    """Between the bounds of either sign their size and components, the lateral one where there is any."""
    bound, traction = sol.traction_bound[row, shown], sol.traction[:, row, shown]
    finite = bool(np.all(np.isfinite(bound)))
    measured = measure_of(sol.scene, "pressure", [bound if finite else np.zeros_like(bound), *traction])
    if finite:
        bounds = measured(bound)
        ax.fill_between(x, -bounds, bounds, color="0.93", linewidth=0)
        ax.plot(x, bounds, color=BOUND_COLOUR, linewidth=0.9, label="$\\pm$ traction bound")
        ax.plot(x, -bounds, color=BOUND_COLOUR, linewidth=0.9)
    size = np.hypot(*traction)
    ax.plot(x, measured(size), color="k", linewidth=1.6, label="$|p|$, its size")
    ax.plot(x, measured(traction[0]), "o-", color=TRACTION_COLOUR, markersize=2.5, linewidth=0.9, label="$p_x$")
    if np.abs(traction[1]).max(initial=0.0) > 1e-9 * size.max(initial=0.0):
        ax.plot(x, measured(traction[1]), "s--", color=LATERAL_COLOUR, markersize=2.5, linewidth=0.9, label="$p_y$")
    ax.set_ylabel(measured.label("traction"))


def _place(sol: Solution, row: int, lengths: Measure) -> str:
    y = float(sol.grid.y[row])
    return lengths.text(0.0 if abs(y) < 1e-9 * sol.grid.sides[1] else y)
