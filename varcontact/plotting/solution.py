"""Pictures of a solution, in the field's way."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from varcontact.errors import SceneError
from varcontact.scene.friction import BRANCHES, Law, kind_of
from varcontact.scene.units import Units

if TYPE_CHECKING:
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from varcontact.results.solution import Solution

BELOW: dict[str, Any] = {"loc": "upper center", "bbox_to_anchor": (0.5, -0.14), "fontsize": "small", "frameon": False}
ROLLING = {1: ", rolling to the right", -1: ", rolling to the left"}
STICK_COLOUR, SLIP_COLOUR, TRACTION_COLOUR = "#cfe3f3", "#f6d3b8", "#17365d"


def plot(sol: Solution) -> Figure:
    """Pressure; traction arrows over stick and slip areas; the section along x with the traction bound.

    Of a line contact: the tractions within the traction bound, and below them the slip, both over the stick and slip
    areas; without a motion the pressure.

    Parameters
    ----------
    sol : Solution

    Returns
    -------
    matplotlib Figure
        Not shown: call its ``savefig``, or ``plt.show()``.
    """
    from matplotlib import pyplot as plt

    if sol.scene.line:
        from varcontact.plotting.line import plot_line

        return plot_line(sol)
    panels = 1 if sol.scene.motion is None else 2
    figure, axes = plt.subplots(1, panels + 1, figsize=(5.2 * (panels + 1), 4.6), layout="constrained", squeeze=False)
    draw_pressure(axes[0, 0], sol)
    if panels == 2:
        draw_areas(axes[0, 1], sol)
    _draw_section(axes[0, -1], sol)
    return figure


def draw_pressure(ax: Axes, sol: Solution) -> None:
    """Pressure over the contact.

    Parameters
    ----------
    ax : Axes
    sol : Solution
    """
    from varcontact.plotting.ticks import readable_numbers

    left, right, bottom, top = sol.grid.box
    pressure = np.ma.masked_less_equal(sol.pressure, 0)
    image = ax.imshow(pressure, origin="lower", extent=(left, right, bottom, top), cmap="viridis")
    assert ax.figure is not None
    pressures = label("pressure", "pressure", sol)
    ax.figure.colorbar(image, ax=ax, shrink=0.8, label=pressures, format=readable_numbers())
    ax.set_title("Pressure")
    _frame(ax, sol)


def draw_areas(ax: Axes, sol: Solution) -> None:
    """Stick and slip areas, traction arrows on them, and the spin pole where it lies in the picture.

    Parameters
    ----------
    ax : Axes
    sol : Solution
    """
    from matplotlib.colors import ListedColormap
    from matplotlib.patches import Patch

    left, right, bottom, top = sol.grid.box
    areas = np.ma.masked_equal(sol.state, 0)
    colours = ListedColormap([STICK_COLOUR, SLIP_COLOUR])
    ax.imshow(areas, origin="lower", extent=(left, right, bottom, top), cmap=colours, vmin=1, vmax=2)
    every = max(1, int(np.ceil(max(sol.grid.shape) / 26)))
    iy, ix = np.nonzero(sol.state[every // 2 :: every, every // 2 :: every])
    iy, ix = iy * every + every // 2, ix * every + every // 2
    px, py = sol.traction[:, iy, ix]
    largest = np.hypot(px, py).max(initial=0.0)
    if largest > 0:
        if _equal_axes(sol):
            length = 1.6 * every * max(sol.grid.sides)
            lengths = {"angles": "xy", "scale_units": "xy", "scale": largest / length}
        else:  # directions are kept on the page, and the longest arrow is a twentieth of its width
            lengths = {"angles": "uv", "scale_units": "width", "scale": 20 * largest}
        ax.quiver(sol.grid.x[ix], sol.grid.y[iy], px, py, color=TRACTION_COLOUR, width=0.004, pivot="tail", **lengths)
    handles: list[Artist] = [Patch(color=STICK_COLOUR, label="stick"), Patch(color=SLIP_COLOUR, label="slip")]
    first, second, turn = sol.creepage
    if turn != 0 and left < -second / turn < right and bottom < first / turn < top:
        handles += ax.plot(-second / turn, first / turn, "k.", markersize=8, label="spin pole")
    ax.legend(handles=handles, ncols=3, **BELOW)
    ax.set_title("Tangential traction on body 1")
    _frame(ax, sol)


def _draw_section(ax: Axes, sol: Solution) -> None:
    """The row of elements with the largest pressure: tractions between the traction bounds, or the pressure."""
    from varcontact.plotting.ticks import readable_ticks

    row = int(np.argmax(sol.pressure.max(axis=1)))
    contact = sol.pressure[row] > 0
    ends = np.flatnonzero(contact) if contact.any() else np.array([0, contact.size])
    shown = slice(max(ends[0] - 1, 0), ends[-1] + 2)
    x = sol.grid.x[shown]
    bound = sol.traction_bound[row, shown]
    if sol.scene.motion is None:
        ax.plot(x, sol.pressure[row, shown], "o-", color=TRACTION_COLOUR, markersize=3)
        ax.set_ylabel(label("pressure", "pressure", sol))
    else:
        if np.all(np.isfinite(bound)):
            ax.fill_between(x, -bound, bound, color="0.92", label="within the traction bound")
            ax.plot(x, bound, "0.5", x, -bound, "0.5", linewidth=1)
        for component, name, style in ((0, "along x", "o-"), (1, "along y", "s--")):
            ax.plot(x, sol.traction[component, row, shown], style, markersize=3, label=name)
        ax.set_ylabel(label("traction", "pressure", sol))
        ax.legend(ncols=3, **BELOW)
    ax.axhline(0, color="k", linewidth=0.5)
    readable_ticks(ax)
    ax.set_xlabel(label("x", "length", sol))
    ax.set_title(label(f"Section along x at y = {sol.grid.y[row]:.3g}", "length", sol, brackets=False))


def plot_passes(sol: Solution) -> Figure:
    """Change and residual of the whole against the passes, see `Solution.plot_passes`.

    Parameters
    ----------
    sol : Solution
    """
    from matplotlib import pyplot as plt

    if not sol.passes:
        found = f"coupling {sol.plan.coupling}, no passes"
        raise SceneError(
            "solution",
            found,
            "of a coupling loop, or under a law of friction",
            message=f"solution has no passes to plot (coupling {sol.plan.coupling}); coupling loops "
            "(panagiotopoulos, joint) and laws of friction have them",
        )
    if isinstance(sol.scene.friction, Law):
        shown, changed = f"{kind_of(sol.scene.friction)} friction, from {BRANCHES[sol.branch]}", "coefficients"
    else:
        shown = f"{sol.plan.coupling}, K = {sol.scene.bodies.K:.3g}"
        changed = "pressure" if sol.plan.joint else "tractions"
    figure, ax = plt.subplots(figsize=(5.2, 4.0), layout="constrained")
    changes, residuals = np.array(sol.passes).T
    passes = np.arange(1, len(residuals) + 1)
    ax.semilogy(passes, residuals, "o-", color=TRACTION_COLOUR, markersize=4, label="residual of the whole")
    ax.semilogy(passes[1:], changes[1:], "s--", color="0.5", markersize=3, label=f"change of the {changed}")
    ax.set_xlabel("pass")
    ax.set_title(f"Passes: {shown}" + ("" if sol.converged else " (not converged)"))
    ax.legend(frameon=False)
    return figure


def _frame(ax: Axes, sol: Solution) -> None:
    """Labels, and the contact with a margin of two elements."""
    from varcontact.plotting.ticks import readable_ticks

    readable_ticks(ax)
    ax.set_xlabel(label("x", "length", sol) + ROLLING.get(sol.motion.rolls if sol.motion is not None else 0, ""))
    ax.set_ylabel(label("y", "length", sol))
    left, right, bottom, top = _contact_box(sol)
    ax.set_xlim(left, right)
    ax.set_ylim(bottom, top)
    ax.set_aspect("equal" if _equal_axes(sol) else "auto")


def _contact_box(sol: Solution) -> tuple[float, float, float, float]:
    """The contact with a margin of two elements; of a step without contact, the grid."""
    contact, (dx, dy) = sol.state > 0, sol.grid.sides
    if not contact.any():
        return sol.grid.box
    x, y = sol.grid.x[contact.any(axis=0)], sol.grid.y[contact.any(axis=1)]
    return x[0] - 2.5 * dx, x[-1] + 2.5 * dx, y[0] - 2.5 * dy, y[-1] + 2.5 * dy


def _equal_axes(sol: Solution) -> bool:
    left, right, bottom, top = _contact_box(sol)
    return 0.2 < (right - left) / (top - bottom) < 5


def label(name: str, quantity: str, sol: Solution, brackets: bool = True) -> str:
    """`name` with the unit of a `quantity`, see `Units.of`, where the scene of `sol` names units; in `brackets`."""
    units: Units | None = sol.scene.units
    if units is None:
        return name
    unit = units.of(quantity, sol.scene.line).replace("$", r"\$")  # a dollar, and no formula
    return f"{name} [{unit}]" if brackets else f"{name} {unit}"
