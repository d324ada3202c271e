"""Pictures of studies: a comparison of methods, and a refinement of the grid."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from varcontact.errors import SceneError

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from varcontact.study.convergence import Convergence


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
