"""Pictures of studies: creep-force curves, comparisons of methods, refinements of the grid, and
tradeoffs.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.ticker import LogLocator

from varcontact import checks
from varcontact.errors import SceneError
from varcontact.plotting import style
from varcontact.plotting.fields import is_shift
from varcontact.plotting.unit_labels import Measure, measure
from varcontact.results.solution import Solution

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from varcontact.study.convergence import Convergence
    from varcontact.study.tradeoff import Tradeoff

CREEPAGES = {
    "vx": ("longitudinal creepage", "1"),
    "vy": ("lateral creepage", "1"),
    "spin": ("spin", "spin"),
}
SHIFTS = {
    "vx": ("shift along x", "length"),
    "vy": ("shift along y", "length"),
    "spin": ("rotation", "1"),
}
STYLES = ("-", "--", ":")
LEGEND = {
    "auto": "exact",
    "linear": "linear theory",
    "vermeulen-johnson": "Vermeulen-Johnson",
    "polach": "Polach",
    "strip": "strip theory",
    "table": "table book",
}
"""Methods whose names are no words."""
LEAST_DISTANCE = 1e-16
"""Distances below are rounding, and drawn here."""
LEAST_ERROR = 1e-5
"""Errors in per cent of the unit below which the references' own bars are all that is seen: drawn
here."""
MOST_ERROR = 100.0
"""Errors in per cent above which a method is of no use: not drawn."""


@checks.named_options()
def plot_curve(
    solutions: Sequence[Solution] | Mapping[str, Sequence[Solution]] | xr.Dataset,
    *,
    against: str = "auto",
    normalised: bool = True,
    total: bool = True,
    ax: Axes | None = None,
    figsize: tuple[float, float] | None = None,
) -> Figure:
    """Creep-force curves: the tangential forces, with the sign turned, against a creepage.

    Parameters
    ----------
    solutions : sequence of Solution, or dict of str to such, or xarray.Dataset
        As `scan` gives them; several curves by name; or as `creep_curve` gives
        them, whose values are plain numbers without units.
    against : str
        "vx", "vy" or "spin" (of a shift ux, uy or the rotation); "auto": the
        one that changes most.
    normalised : bool
        Whether forces are shown as parts of what friction can carry,
        ``sum(f pz) dx dy`` (without slip: of the normal force).
    total : bool
        Whether the size of the force is shown, too, where it has both
        components.
    ax, figsize
        As for `Solution.plot`.

    Returns
    -------
    matplotlib Figure

    Raises
    ------
    SceneError
        For what are no solutions with a motion, or not all rolling or all
        shifts, or a creepage that there is not.

    Examples
    --------
    >>> import varcontact as vc
    >>> scene = vc.Scene(
    ...     bodies=vc.Bodies(G=82e9, nu=0.28), surface=vc.Paraboloids(Rx=0.46, Ry=0.30), normal_force=106.7e3,
    ...     friction=0.33, motion=vc.Steady(), grid=vc.Grid(nx=10, ny=10), units=vc.SI)
    >>> curve = vc.scan(scene, [(vx, 0.0, 0.0) for vx in (0.0, 1e-3, 2e-3, 6e-3)])
    >>> figure = vc.plot_curve(curve)
    >>> figure.axes[0].get_xlabel()
    'longitudinal creepage [$10^{-3}$]'
    """
    normalised, total = checks.flag("normalised", normalised), checks.flag("total", total)
    read = _of_dataset if hasattr(solutions, "data_vars") else _of_solutions
    curves, x_label, force, limit = read(solutions, against, normalised)
    largest = np.nanmax(
        [np.nanmax(np.abs(forces), axis=0) for _, forces in curves.values()], axis=0
    )
    shown = tuple(i for i in (0, 1) if largest[i] > 1e-6 * largest.max()) or (0,)
    several = len(curves) > 1
    y_label = (
        f"$-F_{'xy'[shown[0]]}$" if "" not in curves and len(shown) == 1 else "tangential force"
    )
    with style.panel(ax, figsize, (style.COLUMN * 1.15, 2.9)) as (figure, ax):
        for number, (name, (x, forces)) in enumerate(curves.items()):
            lines = [(f"$-F_{'xy'[i]}$", forces[:, i]) for i in shown]
            if len(shown) == 2 and total:
                lines.append(("$|F|$", np.hypot(*forces.T)))
            for j, (part, values) in enumerate(lines):
                words = f"{name}: {part}" if name and len(lines) > 1 else name or part
                every = max(1, len(x) // 12)
                ax.plot(
                    x,
                    values,
                    **style.look(number if several else j),
                    linestyle=STYLES[j],
                    markevery=every,
                    label=words,
                )
        if normalised:
            ax.axhline(1.0, color="0.45", linewidth=0.8, linestyle=(0, (1, 2)))
        ax.axhline(0.0, color="k", linewidth=0.5)
        ax.set(
            xlabel=x_label, ylabel=f"{y_label} / {limit}" if normalised else force.label(y_label)
        )
        style.legend_below(ax, columns=2)
        figure.draw_without_rendering()
    return figure


Curves = dict[str, tuple[np.ndarray, np.ndarray]]
"""By name, what is along x and the forces (n, 2) with the sign turned, as shown."""


def _of_solutions(
    solutions: Any, against: str, normalised: bool
) -> tuple[Curves, str, Measure, str]:
    """Curves, the label along x, how forces are shown, and the name of what they are divided by."""
    given = dict(solutions) if isinstance(solutions, Mapping) else {"": solutions}
    allowed = "a list of solutions that all roll or all shift, as scan gives them, or a dict of such by name"
    for curve in given.values():
        if (
            not isinstance(curve, Sequence)
            or not curve
            or not all(isinstance(sol, Solution) for sol in curve)
        ):
            raise SceneError("solutions", solutions, allowed)
    every = [sol for curve in given.values() for sol in curve]
    if any(sol.motion is None for sol in every) or len({is_shift(sol) for sol in every}) != 1:
        raise SceneError("solutions", solutions, allowed)
    name, scene = checks.choice("against", against, ("auto", *CREEPAGES)), every[0].scene
    if name == "auto":  # the one that changes most, spin by what it does at the edge of the contact
        reach = max(max(abs(end) for end in sol.grid.box[:2]) for sol in every)
        creepages = np.array([sol.creepage for sol in every]) * (1.0, 1.0, reach)
        spread = np.nan_to_num(np.nanmax(creepages, axis=0) - np.nanmin(creepages, axis=0))
        name = list(CREEPAGES)[int(np.argmax(spread))]
    words, quantity = (SHIFTS if is_shift(every[0]) else CREEPAGES)[name]
    values = [getattr(sol, name) for sol in every]
    along = measure(None, "1", values) if quantity == "1" else measure(scene, quantity, values)
    force = (
        Measure(1.0, "") if normalised else measure(scene, "force", [sol.force for sol in every])
    )
    curves = {}
    for label, curve in given.items():
        loads = [sol.normalised if normalised else sol for sol in curve]
        forces = -np.array([(each.Fx, each.Fy) for each in loads])
        curves[str(label)] = along([getattr(sol, name) for sol in curve]), force(forces)
    limit = "normal force" if scene.no_slip or scene.frictionless else "friction limit"
    return curves, along.label(words), force, limit


def _of_dataset(found: Any, against: str, normalised: bool) -> tuple[Curves, str, Measure, str]:
    """The same of the curves of `creep_curve`, one for each method."""
    if not {"Fx", "Fy", *CREEPAGES} <= {str(name) for name in found.variables} or found.Fx.dims != (
        "theory",
        "point",
    ):
        raise SceneError(
            "solutions", type(found), message="solutions: not a dataset of creep_curve"
        )
    limit = float(found.attrs.get("limit", np.nan))
    if normalised and not limit > 0:
        raise SceneError(
            "normalised", normalised, "False: these curves have no single limit of friction"
        )
    if against == "auto":  # lengths are unknown here: creepages come before the spin
        moving = [name for name in ("vx", "vy") if np.ptp(found[name].values) > 0] or ["spin"]
        against = max(moving, key=lambda name: float(np.ptp(found[name].values)))
    along = measure(None, "1", found[against].values)
    forces = -np.stack([found.Fx.values, found.Fy.values], axis=-1) / (limit if normalised else 1.0)
    x = along(found[against].values)
    names = [str(name) for name in found.theory.values]
    shown = [
        LEGEND.get(name, name.replace("fastsim", "FASTSIM").replace("fastrip", "FaStrip"))
        for name in names
    ]
    curves = {label: (x, each) for label, each in zip(shown, forces, strict=True)}
    return curves, along.label(CREEPAGES[against][0]), Measure(1.0, ""), "friction limit"


@checks.named_options()
def plot_comparison(table: pd.DataFrame) -> Figure:
    """Picture of a comparison: error of the tractions against time, a point for
    each scene and method.

    Parameters
    ----------
    table : pandas.DataFrame
        From `compare`.

    Returns
    -------
    matplotlib.figure.Figure
    """
    import pandas as pd

    if not (isinstance(table, pd.DataFrame) and "traction_distance" in table):
        raise SceneError("table", table, "a table that compare made")
    measured = table[table["traction_distance"].notna()]
    with style.styled():
        figure, (ax,) = style.new_figure(1, 1, (0.75 * style.PAGE, 3.2))
        for i, (method, rows) in enumerate(measured.groupby("method", sort=False)):
            seconds = rows["normal_seconds"] + rows["tangential_seconds"]
            error = np.maximum(rows["traction_distance"], LEAST_DISTANCE)
            look = style.look(i) | {"linestyle": "", "alpha": 0.85}
            failed = (rows["outcome"] == "not converged").to_numpy()
            hollow = {"label": f"{method}, not converged", "markerfacecolor": "none"}
            for which, words in ((~failed, {"label": f"{method}"}), (failed, hollow)):
                if which.any():
                    ax.plot(seconds[which], error[which], **(look | words))
        ax.set(xscale="log", yscale="log", xlabel="time of normal and tangential problem [s]")
        ax.set_ylabel("distance from the best tractions /\nlargest traction bound")
        ax.set_ylim(bottom=LEAST_DISTANCE / 3)
        ax.grid(visible=True)
        if not measured.empty:
            figure.legend(loc="outside right upper", title="method", alignment="left")
    return figure


def plot_convergence(study: Convergence, quantities: Sequence[str] | None = None) -> Figure:
    """A panel for each quantity with a limit, a colour for each method.

    Small points are single solves, large ones means over the offsets, each by its distance from the
    extrapolated value; the line has the fitted order. What is below the level of the shade is
    within the error of that value.
    """
    limits = [row for row in study.limits.to_dict("records") if np.isfinite(row["order"])]
    names = list(dict.fromkeys(row["quantity"] for row in limits))
    if quantities is not None:
        for each in quantities:
            checks.choice("quantities", each, names)
        names = [name for name in names if name in quantities]
    methods = list(dict.fromkeys(study.runs["method"]))
    with style.styled():
        figure, axes = style.new_panels(len(names), 2.7)
        for ax, name in zip(axes, names, strict=True):
            for row in (row for row in limits if row["quantity"] == name):
                _draw_limit(ax, study, row, methods.index(row["method"]))
            cells = sorted(set(study.runs["cells"]))
            ax.set(
                xscale="log",
                yscale="log",
                title=name.replace("_", " "),
                xlabel="elements across the contact",
            )
            shown = cells[:: -(-len(cells) // (5 if len(names) > 1 else 8))]
            ax.set_xticks(cells, labels=[str(n) if n in shown else "" for n in cells])
            ax.xaxis.minorticks_off()
            ax.grid(visible=True)
            style.legend_below(ax, columns=1)
        for ax in axes[::3]:
            ax.set_ylabel("distance from\nextrapolated value")
        if names:
            key = [
                Line2D(
                    [],
                    [],
                    color="0.4",
                    marker=".",
                    markersize=3,
                    ls="",
                    alpha=0.5,
                    label="single solve",
                ),
                Line2D([], [], color="0.4", marker="o", ls="", label="mean of a grid"),
                Line2D([], [], color="0.4", ls="--", label="fitted order"),
                Patch(
                    color="0.4", alpha=0.15, linewidth=0, label="error of the extrapolated value"
                ),
            ]
            figure.legend(handles=key, ncols=4, loc="outside upper left")
        figure.draw_without_rendering()
    return figure


def _draw_limit(ax: Axes, study: Convergence, row: dict[str, Any], number: int) -> None:
    name, method, value = row["quantity"], row["method"], row["value"]
    runs = study.runs[
        (study.runs["method"] == method) & study.runs["outcome"].isin(["solved", "approximate"])
    ]
    grids = study.grids[(study.grids["method"] == method) & study.grids[name].notna()]
    cells, errors = grids["cells"].to_numpy(), (grids[name] - value).abs().to_numpy()
    tint = style.colour(number)
    ax.plot(runs["cells"], (runs[name] - value).abs(), ".", color=tint, alpha=0.4, markersize=3)
    label = (
        row["reason"]
        or f"order {row['order']:.1f} ({row['order_low']:.1f} to {row['order_high']:.1f})"
    )
    if study.runs["method"].nunique() > 1:
        label = f"{method}, {label}"
    ax.plot(cells, errors, **style.look(number), linestyle="", label=label)
    middle = np.exp(np.mean(np.log(np.maximum(errors, 1e-300)) + row["order"] * np.log(cells)))
    if row["reason"] == "":
        ax.plot(cells, middle / cells ** row["order"], "--", color=tint, linewidth=0.9)
    if np.isfinite(row["error"]):
        ax.axhspan(0, row["error"], color=tint, alpha=0.12, linewidth=0)


def plot_tradeoff(study: Tradeoff) -> Figure:
    """Errors of methods over processor seconds: the largest of each class of scenes, and the front;
    a panel a class.
    """
    kinds, families = (list(dict.fromkeys(study.classes[name])) for name in ("kind", "family"))
    with style.styled():
        looks = {
            name: style.look(i) | {"markersize": 3.5, "linestyle": ""}
            for i, name in enumerate(families)
        }
        if "accuracy" in looks:  # hollow: the grid was found for it
            looks["accuracy"] |= {
                "color": "k",
                "marker": "o",
                "markerfacecolor": "none",
                "markersize": 6.0,
            }
        looks["front"] = {"color": "0.3", "lw": 0.8, "zorder": 0}
        figure, axes = style.new_panels(len(kinds), 2.8)
        for ax, kind in zip(axes, kinds, strict=True):
            part = study.classes[study.classes["kind"] == kind]
            for name, rows in (*part.groupby("family", sort=False), ("front", study.front(kind))):
                error = np.maximum(100 * rows["largest_error"], LEAST_ERROR)
                ax.plot(rows["processor_seconds"], error, **looks[str(name)])
            ax.set(xscale="log", yscale="log", title=kind)
            ax.xaxis.set_major_locator(LogLocator(subs=(1.0, 3.0)))
            ax.xaxis.set_major_formatter("{x:g}")
            ax.xaxis.minorticks_off()
            ax.set_ylim(top=min(ax.get_ylim()[1], MOST_ERROR))
            ax.grid(visible=True)
        for ax in axes[::3]:
            ax.set_ylabel("largest error [%]")
        for ax in axes[-3:]:
            ax.set_xlabel("processor time [s]")
        if kinds:
            key = [Line2D([], [], label=family, **look) for family, look in looks.items()]
            figure.legend(handles=key, ncols=3, loc="outside lower left")
        figure.draw_without_rendering()
    return figure
