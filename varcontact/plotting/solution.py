"""Pictures: a solution in the field's way, and a comparison."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from varcontact.checks import choice, number, positive
from varcontact.errors import SceneError
from varcontact.scene.friction import BRANCHES, Law, kind_of
from varcontact.scene.units import Units

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from varcontact.results.solution import Solution
    from varcontact.results.stress import SubsurfaceStress
    from varcontact.study.convergence import Convergence

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
    _draw_pressure(axes[0, 0], sol)
    if panels == 2:
        draw_areas(axes[0, 1], sol)
    _draw_section(axes[0, -1], sol)
    return figure


def _draw_pressure(ax: Axes, sol: Solution) -> None:
    """Pressure over the contact."""
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


def plot_comparison(table: pd.DataFrame) -> Figure:
    """Picture of a comparison: error of the tractions against time, a point for each scene and method.

    Parameters
    ----------
    table : pandas.DataFrame
        From `compare`.

    Returns
    -------
    matplotlib.figure.Figure
    """
    import matplotlib.pyplot as plt
    import pandas as pd

    if not (isinstance(table, pd.DataFrame) and "traction_distance" in table):
        raise SceneError("table", table, "a table that compare made")
    figure, axes = plt.subplots(figsize=(9, 5.5), layout="constrained")
    measured = table[table["traction_distance"].notna()]
    markers = "os^vDP*X<>hd"
    for i, (method, rows) in enumerate(measured.groupby("method", sort=False)):
        seconds = rows["normal_seconds"] + rows["tangential_seconds"]
        error = np.maximum(rows["traction_distance"], 1e-16)
        color, marker = f"C{i % 10}", markers[i % len(markers)]
        failed = (rows["outcome"] == "not converged").to_numpy()
        axes.plot(seconds[~failed], error[~failed], marker, color=color, alpha=0.8, label=f"{method}")
        if failed.any():
            label = f"{method}, not converged"
            axes.plot(seconds[failed], error[failed], marker, color=color, markerfacecolor="none", label=label)
    axes.set(xscale="log", yscale="log", xlabel="time of normal and tangential problem [s]")
    axes.set_ylabel("distance of tractions from the best solution,\nby the largest traction bound")
    axes.set_ylim(bottom=1e-17)
    axes.grid(alpha=0.3)
    if not measured.empty:
        figure.legend(loc="outside right upper", fontsize="small")
    plt.close(figure)
    return figure


STRESSES = {
    "von_mises": "von Mises stress",
    "tresca": "Tresca stress",
    "ideal_stress": "Ideal stress $\\sigma_I$",
    "first_invariant": "First invariant $\\sigma_{ii}$",
}
COMPONENTS = ("xx", "yy", "zz", "xy", "xz", "yz")


def plot_stress(
    sol: Solution, quantity: str = "von_mises", *, y: float | None = None, depth: float | None = None
) -> Figure:
    """Contours of a stress in a section of both bodies along x, the upper body above the surface.

    Parameters
    ----------
    sol : Solution
    quantity : str
        "von_mises", "tresca", "ideal_stress", "first_invariant", or a component: "xx", "yy", "zz", "xy", "xz", "yz".
    y : float, optional
        Of the section [length]; that of the row with the largest pressure if not given.
    depth : float, optional
        Shown in either body [length]; three quarters of the contact's length along x if not given.

    Returns
    -------
    matplotlib Figure
        Not shown: call its ``savefig``, or ``plt.show()``.

    Raises
    ------
    SceneError
        For what is no Solution with contact, a quantity that does not exist, or a depth that is not positive.
    """
    from matplotlib import pyplot as plt
    from matplotlib.ticker import MaxNLocator

    from varcontact.plotting.ticks import readable_numbers, readable_ticks
    from varcontact.results.stress import one_solution, stress

    if not one_solution(sol).pressure.any():
        raise SceneError(
            "solution", sol, "with contact", message="solution: there is no contact, so nothing is stressed"
        )
    choice("quantity", quantity, [*STRESSES, *COMPONENTS])
    row = int(np.argmax(sol.pressure.max(axis=1)))
    y = float(sol.grid.y[row]) if y is None else number("y", y)
    x, length = _along_section(sol)
    depth = 0.75 * length if depth is None else positive("depth", depth)
    depths = depth * np.linspace(0, 1, 25) ** 1.5
    fields = {}
    for body, sign in ((1, 1.0), (2, -1.0)):
        z, across = np.meshgrid(sign * depths, x, indexing="ij")
        fields[body] = stress(sol, [across, np.full_like(z, y), z], body)
    values = {body: _stress_value(field, quantity) for body, field in fields.items()}
    both = np.stack(list(values.values()))
    signed = quantity in COMPONENTS
    levels = MaxNLocator(20, symmetric=signed).tick_values(both.min(), both.max())

    figure, ax = plt.subplots(figsize=(8.0, 6.4), layout="constrained")
    for body, part in values.items():
        place = fields[body].points
        image = ax.contourf(place[0], place[2], part, levels, cmap="RdBu_r" if signed else "viridis")
        ax.contour(place[0], place[2], part, levels[::2], colors="k", linewidths=0.4, negative_linestyles="solid")
    stresses = label(_stress_name(quantity), "pressure", sol)
    figure.colorbar(image, ax=ax, shrink=0.85, label=stresses, format=readable_numbers())
    ax.axhline(0, color="0.35", linewidth=0.8)
    contact = sol.grid.x[(sol.pressure > 0).any(axis=0)]
    half = sol.grid.sides[0] / 2
    ax.plot([contact[0] - half, contact[-1] + half], [0, 0], color="k", linewidth=2.5, solid_capstyle="butt")
    ax.set_xlabel(label("x", "length", sol))
    ax.set_ylabel(label("z, up into body 1", "length", sol))
    where = "" if sol.scene.line else label(f" at y = {y:.3g}", "length", sol, brackets=False)
    ax.set_title(f"{_stress_name(quantity)}{where}; the bar is the contact")
    readable_ticks(ax)
    ax.set_aspect("equal")
    return figure


def _along_section(sol: Solution) -> tuple[np.ndarray, float]:
    """Abscissae below element centres, half a contact's length beyond it on both sides, and that length."""
    dx = sol.grid.sides[0]
    contact = np.flatnonzero((sol.pressure > 0).any(axis=0))
    cells = contact[-1] - contact[0] + 1
    every = max(1, int(np.ceil(cells / 40)))
    beyond = (cells // 2 + 1) // every * every
    columns = np.arange(contact[0] - beyond, contact[-1] + beyond + 1, every)
    return sol.grid.x[0] + columns * dx, cells * dx


def _stress_value(field: SubsurfaceStress, quantity: str) -> np.ndarray:
    if quantity in STRESSES:
        return np.asarray(getattr(field, quantity))
    i, j = ("xyz".index(letter) for letter in quantity)
    return np.asarray(field.stress[i, j])


def _stress_name(quantity: str) -> str:
    return STRESSES.get(quantity, f"$\\sigma_{{{quantity}}}$")


def plot_convergence(study: Convergence) -> Figure:
    """Picture of a study of convergence: a panel for each quantity with a limit, a colour for each method.

    Small points are single solves, large ones means over the offsets, each by its distance from the extrapolated
    value; the line has the fitted order. What is below the level of the shade is within the error of that value.

    Parameters
    ----------
    study : Convergence

    Returns
    -------
    matplotlib.figure.Figure
    """
    import matplotlib.pyplot as plt

    limits = [row for row in study.limits.to_dict("records") if np.isfinite(row["order"])]
    names = list(dict.fromkeys(row["quantity"] for row in limits))
    methods = list(dict.fromkeys(study.runs["method"]))
    columns = min(max(len(names), 1), 3)
    size = (4.4 * columns, 3.6 * -(-max(len(names), 1) // columns) + 0.4)
    figure, axes = plt.subplots(
        -(-max(len(names), 1) // columns), columns, figsize=size, layout="constrained", squeeze=False
    )
    for ax, name in zip(axes.flat, names, strict=False):
        for row in (row for row in limits if row["quantity"] == name):
            _draw_limit(ax, study, row, f"C{methods.index(row['method']) % 10}")
        cells = sorted(set(study.runs["cells"]))
        ax.set(xscale="log", yscale="log", title=name, xlabel="elements across the contact", xticks=cells)
        ax.set_xticks(cells, labels=[str(n) for n in cells])
        ax.minorticks_off()
        ax.grid(alpha=0.3)
        ax.legend(fontsize="small", frameon=False)
    for ax in axes.flat[len(names) :]:
        ax.set_axis_off()
    for ax in axes[:, 0]:
        ax.set_ylabel("distance from the extrapolated value")
    plt.close(figure)
    return figure


def _draw_limit(ax: Axes, study: Convergence, row: dict[str, Any], colour: str) -> None:
    """Errors of one quantity by one method."""
    name, method, value = row["quantity"], row["method"], row["value"]
    runs = study.runs[(study.runs["method"] == method) & study.runs["outcome"].isin(["solved", "approximate"])]
    grids = study.grids[(study.grids["method"] == method) & study.grids[name].notna()]
    cells, errors = grids["cells"].to_numpy(), (grids[name] - value).abs().to_numpy()
    ax.plot(runs["cells"], (runs[name] - value).abs(), ".", color=colour, alpha=0.35, markersize=4)
    label = f"{method}, order {row['order']:.1f} ({row['order_low']:.1f} to {row['order_high']:.1f})"
    label = label if row["reason"] == "" else f"{method}, {row['reason']}"
    ax.plot(cells, errors, "o", color=colour, label=label)
    middle = np.exp(np.mean(np.log(np.maximum(errors, 1e-300)) + row["order"] * np.log(cells)))
    if row["reason"] == "":
        ax.plot(cells, middle / cells ** row["order"], "--", color=colour, linewidth=1)
    if np.isfinite(row["error"]):
        ax.axhspan(0, row["error"], color=colour, alpha=0.12, linewidth=0)
