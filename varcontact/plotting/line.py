"""Pictures of a line contact: tractions within their bound, and the slip, over stick and slip areas."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from varcontact.plotting.solution import ROLLING, SLIP_COLOUR, STICK_COLOUR, TRACTION_COLOUR, label

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from varcontact.results.solution import Solution


def plot_line(sol: Solution) -> Figure:
    """Tractions between the traction bounds, below them the slip; without a motion the pressure.

    Parameters
    ----------
    sol : Solution
        Of a line contact.
    """
    from matplotlib import pyplot as plt

    if sol.scene.motion is None:
        figure, ax = plt.subplots(figsize=(6.4, 4.6), layout="constrained")
        _draw_line_pressure(ax, sol)
        return figure
    figure, axes = plt.subplots(2, 1, figsize=(6.4, 7.2), layout="constrained", sharex=True, height_ratios=(3, 2))
    _draw_line_traction(axes[0], sol)
    _draw_line_slip(axes[1], sol)
    axes[0].set_xlabel("")
    figure.legend(*axes[0].get_legend_handles_labels(), ncols=5, loc="outside lower center", frameon=False)
    return figure


def _draw_line_pressure(ax: Axes, sol: Solution) -> None:
    """Pressure along x."""
    ax.plot(sol.grid.x, sol.pressure[0], "o-", color=TRACTION_COLOUR, markersize=3)
    ax.set_title("Pressure")
    _frame(ax, sol, label("pressure", "pressure", sol))


def _draw_line_traction(ax: Axes, sol: Solution) -> None:
    """Tractions along x between plus and minus the traction bound, over stick and slip areas."""
    _draw_areas(ax, sol)
    x, bound = sol.grid.x, sol.traction_bound[0]
    if np.all(np.isfinite(bound)):
        ax.plot(x, bound, "0.35", x, -bound, "0.35", linewidth=1)
        ax.plot([], [], "0.35", linewidth=1, label="traction bound")
    _draw_components(ax, sol, sol.traction[:, 0])
    ax.set_title("Tangential traction on body 1")
    _frame(ax, sol, label("traction", "pressure", sol))


def _draw_line_slip(ax: Axes, sol: Solution) -> None:
    """Slip along x in the contact, over stick and slip areas."""
    _draw_areas(ax, sol)
    _draw_components(ax, sol, np.where(sol.state[0] > 0, sol.slip[:, 0], np.nan))
    shift = sol.motion is not None and sol.motion.rolls == 0
    ax.set_title(f"{'Shift' if shift else 'Relative slip'} of body 1 over body 2")
    _frame(ax, sol, label("shift", "length", sol) if shift else "relative slip")


def _draw_areas(ax: Axes, sol: Solution) -> None:
    """Stick and slip areas as strips over the whole height."""
    edges = np.append(sol.grid.x - sol.grid.sides[0] / 2, sol.grid.box[1])
    for number, colour, name in ((1, STICK_COLOUR, "stick"), (2, SLIP_COLOUR, "slip")):
        changes = np.flatnonzero(np.diff(sol.state[0] == number, prepend=False, append=False))
        for left, right in edges[changes].reshape(-1, 2):
            ax.axvspan(left, right, color=colour, linewidth=0, zorder=0, label=name)
            name = "_" + name  # matplotlib lists the first of them only


def _draw_components(ax: Axes, sol: Solution, values: np.ndarray) -> None:
    """Values (2, nx) along x; their second component where there is lateral motion."""
    motion = sol.motion
    assert motion is not None
    ax.plot(sol.grid.x, values[0], "o-", color=TRACTION_COLOUR, markersize=3, label="along x")
    if motion.rigid[1] != 0 or motion.Fy is not None:
        ax.plot(sol.grid.x, values[1], "s--", color="C1", markersize=3, label="along y")


def _frame(ax: Axes, sol: Solution, name: str) -> None:
    """Labels, and the contact with a margin."""
    from varcontact.plotting.ticks import readable_ticks

    readable_ticks(ax)
    contact = sol.grid.x[sol.state[0] > 0] if sol.state.any() else sol.grid.x
    margin = 0.05 * (contact[-1] - contact[0]) + 1.5 * sol.grid.sides[0]
    ax.set_xlim(contact[0] - margin, contact[-1] + margin)
    ax.axhline(0, color="k", linewidth=0.5)
    ax.set_ylabel(name)
    ax.set_xlabel(label("x", "length", sol) + ROLLING.get(sol.motion.rolls if sol.motion is not None else 0, ""))
