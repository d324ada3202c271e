"""How all pictures look: the style file, the colours, sizes in print, and legends that cover nothing."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import AbstractContextManager
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

COLUMN, PAGE = 3.54, 7.48
"""Widths of one column and of a page of two columns of a journal [inch]: 90 and 190 mm."""

STICK_COLOUR, SLIP_COLOUR, TRACTION_COLOUR = "#cfe3f3", "#f6d3b8", "#17365d"
SLIP_INK, BOUND_COLOUR, LATERAL_COLOUR = "#c98a5a", "0.45", "#D55E00"
HATCH = "//////"
"""Of slip: its colour and that of stick are the same grey in print."""

ROLLING = {1: ", rolling to the right", -1: ", rolling to the left"}
MARKERS = "os^vDP*X<>hd"


def styled() -> AbstractContextManager[None]:
    """The style file, for what is drawn within."""
    from matplotlib import style

    context: AbstractContextManager[None] = style.context("varcontact.plotting.journal")
    return context


def colour(number: int) -> str:
    """One of the style's colours, which come round again; call it within `styled`.

    Parameters
    ----------
    number : int
        From 0.
    """
    import matplotlib as mpl

    colours: list[str] = mpl.rcParams["axes.prop_cycle"].by_key()["color"]
    return colours[number % len(colours)]


def new_figure(rows: int, columns: int, figsize: Any, **options: Any) -> tuple[Figure, list[Axes]]:
    """A figure and its axes, row by row; call it within `styled`.

    Parameters
    ----------
    rows, columns : int
    figsize : pair of float
        Width and height [inch].
    **options
        Of `matplotlib.figure.Figure.subplots`.
    """
    from varcontact.plotting.picture import empty_figure

    figure = empty_figure(figsize)
    return figure, list(figure.subplots(rows, columns, squeeze=False, **options).flat)


def settle(figure: Figure) -> None:
    """Lay a figure out: one pass is not enough for panels of a given shape, and a file is written after one.

    Parameters
    ----------
    figure : Figure
    """
    figure.draw_without_rendering()


def figure_of(ax: Axes) -> Figure:
    """The figure that axes belong to.

    Parameters
    ----------
    ax : Axes
    """
    figure = ax.get_figure(root=True)
    assert figure is not None
    return figure


def slip_patch(**options: Any) -> Any:
    """A patch in the colour and hatching of slip, for a legend.

    Parameters
    ----------
    **options
        Of `matplotlib.patches.Patch`.
    """
    from matplotlib.patches import Patch

    return Patch(facecolor=SLIP_COLOUR, edgecolor=SLIP_INK, hatch=HATCH, linewidth=0, **options)


def area_patches() -> list[Any]:
    """Entries of a legend for stick and slip."""
    from matplotlib.patches import Patch

    return [Patch(facecolor=STICK_COLOUR, linewidth=0, label="stick"), slip_patch(label="slip")]


def legend_below(ax: Axes, handles: Sequence[Any] | None = None, columns: int = 3) -> None:
    """A legend below axes and their labels, whatever the size of the letters.

    Parameters
    ----------
    ax : Axes
        With their labels.
    handles : sequence of Artist, optional
        All that have a label, if not given.
    columns : int
        Entries beside each other.
    """
    from matplotlib.transforms import ScaledTranslation

    found = list(ax.get_legend_handles_labels()[0] if handles is None else handles)
    if not found:
        return
    ticks = [float(text.get_fontsize()) for text in ax.get_xticklabels()[:1]] or [8.0]
    label = ax.get_xlabel()
    lines = label.count("\n") + 1 if label else 0
    points = 6 + 1.5 * max(ticks) + 1.5 * lines * float(ax.xaxis.label.get_fontsize())
    down = ScaledTranslation(0, -points / 72, figure_of(ax).dpi_scale_trans)
    ax.legend(
        handles=found,
        ncols=min(columns, len(found)),
        loc="upper center",
        bbox_to_anchor=(0.5, 0.0),
        bbox_transform=ax.transAxes + down,
        borderaxespad=0.0,
        columnspacing=1.2,
        handletextpad=0.5,
        frameon=False,
    )


def legend_beside(ax: Axes, handles: Sequence[Any] | None = None) -> None:
    """A legend to the right of axes.

    Parameters
    ----------
    ax : Axes
    handles : sequence of Artist, optional
        All that have a label, if not given.
    """
    found = list(ax.get_legend_handles_labels()[0] if handles is None else handles)
    if found:
        ax.legend(handles=found, loc="upper left", bbox_to_anchor=(1.01, 1.0), borderaxespad=0.0, frameon=False)


def colour_bar(ax: Axes, image: Any, label: str) -> None:
    """A colour bar to the right of axes, as high as they are.

    Parameters
    ----------
    ax : Axes
    image : ScalarMappable
    label : str
    """
    from varcontact.plotting.ticks import readable_numbers

    figure_of(ax).colorbar(image, cax=ax.inset_axes((1.03, 0.0, 0.05, 1.0)), label=label, format=readable_numbers())
