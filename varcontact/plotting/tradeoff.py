"""Picture of a tradeoff: errors over seconds, a panel for each class of scenes."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from varcontact.plotting.style import MARKERS, PAGE, colour, new_figure, settle, styled

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from varcontact.study.tradeoff import Tradeoff

LEAST = 1e-5
"""Errors in per cent of the unit below which the references' own bars are all that is seen: drawn here."""

MOST = 100.0
"""Errors in per cent above which a way is of no use: not drawn."""


def plot_tradeoff(study: Tradeoff) -> Figure:
    """Errors of ways over processor seconds: the largest of each class of scenes, and the front.

    Parameters
    ----------
    study : Tradeoff

    Returns
    -------
    matplotlib.figure.Figure
    """
    from varcontact.plotting.ticks import readable_decades

    classes = study.classes
    kinds = list(dict.fromkeys(classes["kind"] if len(classes) else []))
    families = list(dict.fromkeys(classes["family"] if len(classes) else []))
    columns = min(max(len(kinds), 1), 3)
    rows = -(-max(len(kinds), 1) // columns)
    with styled():
        figure, axes = new_figure(rows, columns, (PAGE, 1.2 + 2.3 * rows))
        for ax, kind in zip(axes, kinds, strict=False):
            _draw(ax, study, kind, families)
            ax.set(xscale="log", yscale="log", title=kind)
            ax.set_ylim(top=min(ax.get_ylim()[1], MOST))
            readable_decades(ax)
            ax.grid(visible=True)
        for ax in axes[len(kinds) :]:
            ax.set_axis_off()
        for ax in axes[::columns]:
            ax.set_ylabel("largest error [%]")
        for ax in axes[max(len(kinds) - columns, 0) : len(kinds)]:
            ax.set_xlabel("processor time [s]")
        if kinds:
            figure.legend(handles=_key(families), ncols=3, loc="outside lower left")
        settle(figure)
    return figure


def _draw(ax: Axes, study: Tradeoff, kind: str, families: list[str]) -> None:
    part = study.classes[study.classes["kind"] == kind]
    for family, ways in part.groupby("family", sort=False):
        error = np.maximum(100 * ways["largest_error"], LEAST)
        ax.plot(ways["processor_seconds"], error, **_look(families, str(family)))
    front = study.front(kind)
    ax.plot(front["processor_seconds"], np.maximum(100 * front["largest_error"], LEAST), color="0.3", lw=0.8, zorder=0)


def _look(families: list[str], family: str) -> dict[str, Any]:
    """Hollow where the grid was found for an accuracy."""
    if family == "accuracy":
        return {"color": "k", "marker": "o", "markerfacecolor": "none", "markersize": 6.0, "linestyle": ""}
    number = families.index(family)
    return {"color": colour(number), "marker": MARKERS[number % len(MARKERS)], "markersize": 3.5, "linestyle": ""}


def _key(families: list[str]) -> list[Any]:
    from matplotlib.lines import Line2D

    ways = [Line2D([], [], label=family, **_look(families, family)) for family in families]
    return [*ways, Line2D([], [], color="0.3", lw=0.8, label="front")]
