"""Pictures of studies: a comparison of methods, and a refinement of the grid."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from varcontact.errors import SceneError
from varcontact.plotting.style import MARKERS, PAGE, colour, legend_below, new_figure, settle, styled

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from varcontact.study.convergence import Convergence


LEAST = 1e-16
"""Distances below are rounding, and drawn here."""


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
    import pandas as pd

    from varcontact.plotting.ticks import readable_decades

    if not (isinstance(table, pd.DataFrame) and "traction_distance" in table):
        raise SceneError("table", table, "a table that compare made")
    measured = table[table["traction_distance"].notna()]
    with styled():
        figure, (ax,) = new_figure(1, 1, (0.75 * PAGE, 3.2))
        for i, (method, rows) in enumerate(measured.groupby("method", sort=False)):
            seconds = rows["normal_seconds"] + rows["tangential_seconds"]
            error = np.maximum(rows["traction_distance"], LEAST)
            look: dict[str, Any] = {
                "color": colour(i),
                "marker": MARKERS[i % len(MARKERS)],
                "linestyle": "",
                "alpha": 0.85,
            }
            failed = (rows["outcome"] == "not converged").to_numpy()
            if not failed.all():
                ax.plot(seconds[~failed], error[~failed], **look, label=f"{method}")
            if failed.any():
                words = f"{method}, not converged"
                ax.plot(seconds[failed], error[failed], **look, markerfacecolor="none", label=words)
        ax.set(xscale="log", yscale="log", xlabel="time of normal and tangential problem [s]")
        ax.set_ylabel("distance from the best tractions /\nlargest traction bound")
        ax.set_title(f"Each point is a scene; what is below {LEAST:.0e} is drawn there")
        ax.set_ylim(bottom=LEAST / 3)
        readable_decades(ax)
        ax.grid(visible=True)
        if not measured.empty:
            figure.legend(loc="outside right upper", title="method", alignment="left")
    return figure


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
    from varcontact.plotting.ticks import readable_decades

    limits = [row for row in study.limits.to_dict("records") if np.isfinite(row["order"])]
    names = list(dict.fromkeys(row["quantity"] for row in limits))
    methods = list(dict.fromkeys(study.runs["method"]))
    columns = min(max(len(names), 1), 3)
    rows = -(-max(len(names), 1) // columns)
    with styled():
        figure, axes = new_figure(rows, columns, (PAGE / 3 * columns * (1.4 if columns == 1 else 1), 0.5 + 2.5 * rows))
        for ax, name in zip(axes, names, strict=False):
            for row in (row for row in limits if row["quantity"] == name):
                _draw_limit(ax, study, row, methods.index(row["method"]))
            cells = sorted(set(study.runs["cells"]))
            ax.set(xscale="log", yscale="log", title=name, xlabel="elements across the contact")
            ax.set_xticks(cells, labels=_apart(cells, columns))
            readable_decades(ax)
            ax.xaxis.minorticks_off()
            ax.grid(visible=True)
            legend_below(ax, columns=1)
        for ax in axes[len(names) :]:
            ax.set_axis_off()
        for ax in axes[::columns]:
            ax.set_ylabel("distance from\nextrapolated value")
        if names:
            figure.legend(handles=_key(), ncols=4, loc="outside upper left")
        settle(figure)
    return figure


def _apart(cells: list[int], columns: int) -> list[str]:
    """Numbers of elements as labels on a logarithmic axis, without those that would touch the one before."""
    room = 0.11 if columns > 1 else 0.06
    spread = np.log(cells[-1] / cells[0]) if len(cells) > 1 else 1.0
    labels, last = [], -np.inf
    for n in cells:
        place = np.log(n / cells[0]) / spread
        shown = place - last >= room * max(1.0, len(str(n)) / 2)
        labels.append(str(n) if shown else "")
        last = place if shown else last
    return labels


def _key() -> list[Any]:
    """What the points, lines and shades of a panel are, whatever their colour."""
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    return [
        Line2D([], [], color="0.4", marker=".", markersize=3, ls="", alpha=0.5, label="single solve"),
        Line2D([], [], color="0.4", marker="o", ls="", label="mean of a grid"),
        Line2D([], [], color="0.4", ls="--", label="fitted order"),
        Patch(color="0.4", alpha=0.15, linewidth=0, label="error of the extrapolated value"),
    ]


def _draw_limit(ax: Axes, study: Convergence, row: dict[str, Any], number: int) -> None:
    """Errors of one quantity by one method."""
    name, method, value = row["quantity"], row["method"], row["value"]
    runs = study.runs[(study.runs["method"] == method) & study.runs["outcome"].isin(["solved", "approximate"])]
    grids = study.grids[(study.grids["method"] == method) & study.grids[name].notna()]
    cells, errors = grids["cells"].to_numpy(), (grids[name] - value).abs().to_numpy()
    look: dict[str, Any] = {"color": colour(number)}
    ax.plot(runs["cells"], (runs[name] - value).abs(), ".", **look, alpha=0.4, markersize=3)
    label = f"{method}, order {row['order']:.1f} ({row['order_low']:.1f} to {row['order_high']:.1f})"
    label = label if row["reason"] == "" else f"{method}, {row['reason']}"
    ax.plot(cells, errors, MARKERS[number % len(MARKERS)], **look, label=label)
    middle = np.exp(np.mean(np.log(np.maximum(errors, 1e-300)) + row["order"] * np.log(cells)))
    if row["reason"] == "":
        ax.plot(cells, middle / cells ** row["order"], "--", **look, linewidth=0.9)
    if np.isfinite(row["error"]):
        ax.axhspan(0, row["error"], **look, alpha=0.12, linewidth=0)
