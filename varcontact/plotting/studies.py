"""Pictures of studies: creep-force curves, comparisons of methods, refinements of the grid, and
tradeoffs.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.ticker import LogLocator, NullFormatter

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
"""Labels of methods whose names are not suitable as such."""
DISTANCE_MIN = 1e-16
"""Distances below this are rounding; they are drawn at it."""
ERROR_MIN = 1e-5
"""Errors [% of the unit] below this are within the references' own error bars; they are drawn at
it."""
ERROR_MAX = 100.0
"""Errors [% of the unit] above which a method is useless and not drawn."""
FORCE_MIN = 1e-6
"""Component, divided by the largest force, below which it is not drawn."""
MARKERS_OF_CURVE = 12
"""Approximate number of markers on a curve."""


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
        Forces are shown as parts of the friction limit,
        ``sum(f pz) dx dy`` (without slip: of the normal force).
    total : bool
        The size of the force is shown, too, where it has both components.
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
    ...     bodies=vc.Bodies(G=82e9, nu=0.28), surface=vc.Paraboloids(Rx=0.46, Ry=0.30),
    ...     normal_force=106.7e3, friction=0.33, motion=vc.Steady(), grid=vc.Grid(nx=10, ny=10),
    ...     units=vc.SI)
    >>> curve = vc.scan(scene, [(vx, 0.0, 0.0) for vx in (0.0, 1e-3, 2e-3, 6e-3)])
    >>> figure = vc.plot_curve(curve)
    >>> figure.axes[0].get_xlabel()
    'longitudinal creepage [$10^{-3}$]'
    """
    normalised = checks.flag("normalised", normalised)
    total = checks.flag("total", total)
    if hasattr(solutions, "data_vars"):
        curves = _curves_of_dataset(solutions, against, normalised)
    else:
        curves = _curves_of_solutions(solutions, against, normalised)
    with style.panel(ax, figsize, (style.COLUMN * 1.15, 2.9)) as (figure, ax):
        _draw_curves(ax, curves, total)
        if normalised:
            ax.axhline(1.0, color="0.45", linewidth=0.8, linestyle=(0, (1, 2)))
        ax.axhline(0.0, color="k", linewidth=0.5)
        ax.set(xlabel=curves.x_label, ylabel=_force_label(curves, normalised))
        style.legend_below(ax, columns=2)
        figure.draw_without_rendering()
    return figure


@dataclass(frozen=True)
class Curves:
    """Creep-force curves as shown: by name the creepages, and the forces (n, 2) with the sign
    turned.
    """

    of_name: dict[str, tuple[np.ndarray, np.ndarray]]
    x_label: str
    force: Measure
    limit: str
    """Name of the force that normalised ones are divided by."""

    @property
    def components(self) -> list[int]:
        """Components of the force that are drawn: 0 along x, 1 along y; x of none."""
        sizes = [np.nanmax(np.abs(forces), axis=0) for _, forces in self.of_name.values()]
        largest = np.nanmax(sizes, axis=0)
        drawn = [i for i in (0, 1) if largest[i] > FORCE_MIN * largest.max()]
        return drawn or [0]


FORCES = ("$-F_x$", "$-F_y$")
"""Labels of the components."""


def _draw_curves(ax: Axes, curves: Curves, total: bool) -> None:
    components = curves.components
    for number, (name, (x, forces)) in enumerate(curves.of_name.items()):
        lines = {FORCES[i]: forces[:, i] for i in components}
        if len(components) == 2 and total:
            lines["$|F|$"] = np.hypot(*forces.T)
        for j, (part, values) in enumerate(lines.items()):
            # a colour and marker for each curve; if there is only one, for each of its components
            look = style.look(number if len(curves.of_name) > 1 else j)
            label = name or part
            if name and len(lines) > 1:
                label = f"{name}: {part}"
            every = max(1, len(x) // MARKERS_OF_CURVE)
            ax.plot(x, values, **look, linestyle=STYLES[j], markevery=every, label=label)


def _force_label(curves: Curves, normalised: bool) -> str:
    label = "tangential force"
    if "" not in curves.of_name and len(curves.components) == 1:
        label = FORCES[curves.components[0]]
    if normalised:
        return f"{label} / {curves.limit}"
    return curves.force.label(label)


def _curves_of_solutions(solutions: Any, against: str, normalised: bool) -> Curves:
    """Curves of solutions, checked to be of one kind."""
    by_name = dict(solutions) if isinstance(solutions, Mapping) else {"": solutions}
    every = _checked_solutions(solutions, by_name)
    scene = every[0].scene
    name = checks.choice("against", against, ("auto", *CREEPAGES))
    if name == "auto":
        name = _varied_creepage(every)
    words, quantity = (SHIFTS if is_shift(every[0]) else CREEPAGES)[name]
    values = [getattr(sol, name) for sol in every]
    if quantity == "1":
        along = measure(None, "1", values)
    else:
        along = measure(scene, quantity, values)
    force = Measure(1.0, "")
    if not normalised:
        force = measure(scene, "force", [sol.force for sol in every])
    curves = {}
    for label, curve in by_name.items():
        creepage = along([getattr(sol, name) for sol in curve])
        curves[str(label)] = (creepage, force(_forces(curve, normalised)))
    limit = "friction limit"
    if scene.no_slip or scene.frictionless:
        limit = "normal force"
    return Curves(curves, along.label(words), force, limit)


def _forces(curve: Sequence[Solution], normalised: bool) -> np.ndarray:
    """Forces (n, 2) of a curve with the sign turned."""
    loads = [sol.normalised if normalised else sol for sol in curve]
    return -np.array([(each.Fx, each.Fy) for each in loads])


def _checked_solutions(solutions: Any, by_name: dict[Any, Any]) -> list[Solution]:
    """All solutions of some curves; refused unless all roll or all shift."""
    allowed = (
        "a list of solutions that all roll or all shift, as scan gives them, "
        "or a dict of such by name"
    )
    every: list[Solution] = []
    for curve in by_name.values():
        if not isinstance(curve, Sequence) or not curve:
            raise SceneError("solutions", solutions, allowed)
        if not all(isinstance(sol, Solution) for sol in curve):
            raise SceneError("solutions", solutions, allowed)
        every += curve
    if any(sol.motion is None for sol in every) or len({is_shift(sol) for sol in every}) != 1:
        raise SceneError("solutions", solutions, allowed)
    return every


def _varied_creepage(every: list[Solution]) -> str:
    """Name of the creepage that changes most; spin counts by its slip at the edge of the
    contact.
    """
    reach = max(max(abs(end) for end in sol.grid.box[:2]) for sol in every)
    creepages = np.array([sol.creepage for sol in every]) * (1.0, 1.0, reach)
    spread = np.nan_to_num(np.nanmax(creepages, axis=0) - np.nanmin(creepages, axis=0))
    return list(CREEPAGES)[int(np.argmax(spread))]


def _curves_of_dataset(dataset: Any, against: str, normalised: bool) -> Curves:
    """Curves of `creep_curve`, one for each method."""
    variables = {str(name) for name in dataset.variables}
    if not {"Fx", "Fy", *CREEPAGES} <= variables or dataset.Fx.dims != ("theory", "point"):
        message = "solutions: not a dataset of creep_curve"
        raise SceneError("solutions", type(dataset), message=message)
    limit = float(dataset.attrs.get("limit", np.nan))
    if normalised and not limit > 0:
        allowed = "False: these curves have no single limit of friction"
        raise SceneError("normalised", normalised, allowed)
    if against == "auto":  # lengths are unknown here: creepages are chosen before spin
        moving = [name for name in ("vx", "vy") if np.ptp(dataset[name].values) > 0] or ["spin"]
        against = max(moving, key=lambda name: float(np.ptp(dataset[name].values)))
    along = measure(None, "1", dataset[against].values)
    x = along(dataset[against].values)
    forces = -np.stack([dataset.Fx.values, dataset.Fy.values], axis=-1)
    if normalised:
        forces = forces / limit
    curves = {}
    for name, of_theory in zip(dataset.theory.values, forces, strict=True):
        spelled = str(name).replace("fastsim", "FASTSIM").replace("fastrip", "FaStrip")
        curves[LEGEND.get(str(name), spelled)] = (x, of_theory)
    label = along.label(CREEPAGES[against][0])
    return Curves(curves, label, Measure(1.0, ""), "friction limit")


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
            error = np.maximum(rows["traction_distance"], DISTANCE_MIN)
            look = style.look(i) | {"linestyle": "", "alpha": 0.85}
            failed = (rows["outcome"] == "not converged").to_numpy()
            hollow = {"label": f"{method}, not converged", "markerfacecolor": "none"}
            for which, words in ((~failed, {"label": f"{method}"}), (failed, hollow)):
                if which.any():
                    ax.plot(seconds[which], error[which], **(look | words))
        ax.set(xscale="log", yscale="log", xlabel="time of normal and tangential problem [s]")
        ax.set_ylabel("distance from the best tractions /\nlargest traction bound")
        ax.set_ylim(bottom=DISTANCE_MIN / 3)
        # at least one decade, with numbers at decades only: others would overlap
        low, high = ax.get_xlim()
        beyond = max(1.0, np.sqrt(10 * low / high))
        ax.set_xlim(low / beyond, high * beyond)
        ax.xaxis.set_minor_formatter(NullFormatter())
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
        ticks = 5 if len(names) > 1 else 8
        for ax, name in zip(axes, names, strict=True):
            for row in limits:
                if row["quantity"] == name:
                    _draw_limit(ax, study, row, methods.index(row["method"]))
            ax.set(xscale="log", yscale="log", title=name.replace("_", " "))
            ax.set_xlabel("elements across the contact")
            _label_cells(ax, sorted(set(study.runs["cells"])), ticks)
            ax.grid(visible=True)
            style.legend_below(ax, columns=1)
        for ax in axes[::3]:
            ax.set_ylabel("distance from\nextrapolated value")
        if names:
            figure.legend(handles=_convergence_key(), ncols=4, loc="outside upper left")
        figure.draw_without_rendering()
    return figure


def _label_cells(ax: Axes, cells: list[int], most: int) -> None:
    """Ticks at all numbers of elements, `most` of them with labels."""
    shown = cells[:: -(-len(cells) // most)]
    ax.set_xticks(cells, labels=[str(n) if n in shown else "" for n in cells])
    ax.xaxis.minorticks_off()


def _convergence_key() -> list[Line2D | Patch]:
    """Entries of the legend of all panels."""
    grey: dict[str, Any] = {"color": "0.4"}
    small: dict[str, Any] = {"marker": ".", "markersize": 3, "ls": "", "alpha": 0.5}
    return [
        Line2D([], [], **grey, **small, label="single solve"),
        Line2D([], [], **grey, marker="o", ls="", label="mean of a grid"),
        Line2D([], [], **grey, ls="--", label="fitted order"),
        Patch(**grey, alpha=0.15, linewidth=0, label="error of the extrapolated value"),
    ]


def _draw_limit(ax: Axes, study: Convergence, row: dict[str, Any], number: int) -> None:
    """Errors of one method for one quantity, against its extrapolated value."""
    name = row["quantity"]
    method = row["method"]
    value = row["value"]
    usable = study.runs["outcome"].isin(["solved", "approximate"])
    runs = study.runs[(study.runs["method"] == method) & usable]
    grids = study.grids[(study.grids["method"] == method) & study.grids[name].notna()]
    cells = grids["cells"].to_numpy()
    errors = (grids[name] - value).abs().to_numpy()
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
        looks = _family_styles(families)
        figure, axes = style.new_panels(len(kinds), 2.8)
        for ax, kind in zip(axes, kinds, strict=True):
            part = study.classes[study.classes["kind"] == kind]
            for name, rows in (*part.groupby("family", sort=False), ("front", study.front(kind))):
                error = np.maximum(100 * rows["largest_error"], ERROR_MIN)
                ax.plot(rows["processor_seconds"], error, **looks[str(name)])
            ax.set(xscale="log", yscale="log", title=kind)
            ax.xaxis.set_major_locator(LogLocator(subs=(1.0, 3.0)))
            ax.xaxis.set_major_formatter("{x:g}")
            ax.xaxis.minorticks_off()
            ax.set_ylim(top=min(ax.get_ylim()[1], ERROR_MAX))
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


def _family_styles(families: list[str]) -> dict[str, dict[str, Any]]:
    """Looks of the families of methods, and of the front."""
    points = {"markersize": 3.5, "linestyle": ""}
    looks = {name: style.look(i) | points for i, name in enumerate(families)}
    if "accuracy" in looks:  # hollow: the grid was chosen for it
        hollow = {"color": "k", "marker": "o", "markerfacecolor": "none", "markersize": 6.0}
        looks["accuracy"] |= hollow
    looks["front"] = {"color": "0.3", "lw": 0.8, "zorder": 0}
    return looks
