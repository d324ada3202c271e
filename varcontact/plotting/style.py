"""Style of all pictures and their files: figures, sizes in print, ticks, and legends that cover
nothing.
"""

from __future__ import annotations

import io
from collections.abc import Iterator, Sequence
from contextlib import AbstractContextManager, contextmanager
from pathlib import Path
from typing import Any, cast

import matplotlib as mpl
import numpy as np
from matplotlib import style
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter
from matplotlib.transforms import ScaledTranslation

from varcontact import checks
from varcontact.errors import SceneError, warn
from varcontact.system.files import check_replaceable, reading, write_whole

COLUMN = 3.54
"""Width of one column of a journal [inch]: 90 mm."""
PAGE = 7.48
"""Width of a page of two columns [inch]: 190 mm."""

PANEL_WIDTH = 2.3
PANEL_HEIGHT = 1.9
"""Smallest legible panel with its labels [inch]."""

STICK_COLOUR = "#cfe3f3"
SLIP_COLOUR = "#f6d3b8"
TRACTION_COLOUR = "#17365d"
BOUND_COLOUR = "0.45"
LATERAL_COLOUR = "#D55E00"
LOOKS: dict[str, dict[str, Any]] = {
    "stick": {"facecolor": STICK_COLOUR, "linewidth": 0},
    "slip": {"facecolor": SLIP_COLOUR, "edgecolor": "#c98a5a", "hatch": "//////", "linewidth": 0},
    "plastic": {"facecolor": "#d9c7e3", "edgecolor": "#7d5f91", "hatch": "....", "linewidth": 0},
}
"""Looks of areas, in the order of their states. Slip is hatched, as in print its colour and that of
stick are the same grey."""

ROLLING = {1: ", rolling to the right", -1: ", rolling to the left"}
MARKERS = "os^vDP*X<>hd"
BESIDE: dict[str, Any] = {"loc": "upper left", "bbox_to_anchor": (1.01, 1.0), "borderaxespad": 0.0}
"""Options of a legend to the right of the axes."""

FIELD = "--plot"
MARK = "Drawn by varcontact"
"""Mark in a picture, so that a later run may draw it again in the same file."""
OURS = b".*Drawn by varcontact"
"""Pattern of files with the mark."""
_SIGNED = {"png": "Software", "pdf": "Creator", "svg": "Creator", "ps": "Creator", "eps": "Creator"}
"""Metadata entry for the mark, by kind of picture; other kinds have none."""


class SmallFigure(UserWarning):
    """Figure size with no room for all panels."""


class Picture(Figure):
    """A figure outside pyplot's registry: a loop of pictures fills no memory, and a notebook shows
    each once.
    """

    def _repr_png_(self) -> bytes:
        image = io.BytesIO()
        self.savefig(image, format="png")
        return image.getvalue()


def styled() -> AbstractContextManager[None]:
    """Context with the style file, for everything drawn within."""
    context: AbstractContextManager[None] = style.context("varcontact.plotting.journal")
    return context


def colour(number: int) -> str:
    """Colour of the style with this number, repeated cyclically; call it within `styled`."""
    colours: list[str] = mpl.rcParams["axes.prop_cycle"].by_key()["color"]
    return colours[number % len(colours)]


def look(number: int) -> dict[str, Any]:
    """Colour and marker of one of many curves; call it within `styled`."""
    return {"color": colour(number), "marker": MARKERS[number % len(MARKERS)]}


def empty_figure(default: tuple[float, float], figsize: Any = None) -> Picture:
    """A figure without axes, of the width and height that are given or the default [inch]; call it
    within `styled`.
    """
    sizes = np.array(default)
    if figsize is not None:
        sizes = checks.numbers("figsize", figsize)
    if sizes.shape != (2,) or not np.all((sizes >= 0.5) & (sizes <= 100)):
        raise SceneError("figsize", figsize, "(width, height) in inches, each from 0.5 to 100")
    figure = Picture(figsize=tuple(sizes.tolist()), layout="constrained")
    FigureCanvasAgg(figure)
    return figure


def new_figure(
    rows: int, columns: int, default: tuple[float, float], figsize: Any = None, **options: Any
) -> tuple[Figure, list[Axes]]:
    """Figure with `rows` by `columns` axes, listed row by row; `options` are those of
    `Figure.subplots`.
    """
    figure = empty_figure(default, figsize)
    return figure, list(figure.subplots(rows, columns, squeeze=False, **options).flat)


def new_panels(
    count: int, height: float, figsize: Any = None, names: Sequence[str] = ()
) -> tuple[Figure, list[Axes]]:
    """A figure of so many axes, three to a row at most, each of this height with its labels [inch];
    of a given size those for which there is room, with a `SmallFigure` warning for the others.
    """
    columns = min(max(count, 1), 3)
    rows = -(-max(count, 1) // columns)
    default = (PAGE / 3 * max(columns, 1.4), rows * height)
    if figsize is None:
        figure, axes = new_figure(rows, columns, default)
    else:
        width, high = empty_figure(default, figsize).get_size_inches().tolist()
        rows, columns = _room(count, figsize, width, high)
        figure, axes = new_figure(rows, columns, default, figsize)
        if rows * columns < count:
            say_dropped(count, rows * columns, (width, high), names)
            count = rows * columns
    for ax in axes[count:]:
        ax.set_axis_off()
    return figure, axes[:count]


def _room(count: int, figsize: Any, width: float, height: float) -> tuple[int, int]:
    """Rows and columns of legible panels in a figure [inch]; SceneError if not one fits."""
    columns = min(count, 3, int(width / PANEL_WIDTH))
    rows = int(height / PANEL_HEIGHT)
    if columns == 0 or rows == 0:
        allowed = f"at least {PANEL_WIDTH:g} by {PANEL_HEIGHT:g} inches, for one panel"
        raise SceneError("figsize", figsize, allowed)
    return min(rows, -(-count // columns)), columns


def say_dropped(count: int, shown: int, size: tuple[float, float], names: Sequence[str]) -> None:
    """Warn of panels that a figure of a size [inch] has no room for."""
    width, height = size
    dropped = ", ".join(names[shown:]) or f"the last {count - shown} of {count} panels"
    words = f"figsize = {width:g} x {height:g} inches has no room for {dropped}: left out"
    warn(words, SmallFigure)


@contextmanager
def panel(
    ax: Axes | None, figsize: Any, default: tuple[float, float]
) -> Iterator[tuple[Figure, Axes]]:
    """Axes as given, or those of a new figure, after the figure; and the style for everything drawn
    within.
    """
    if not isinstance(ax, Axes | None):
        raise SceneError("ax", ax, "Axes of matplotlib, for one panel")
    with styled():
        if ax is None:
            _, (ax,) = new_figure(1, 1, default, figsize)
        yield cast(Figure, ax.get_figure(root=True)), ax


def plain_log_ticks(ax: Axes) -> None:
    """Numbers 1, 2 and 5 of each decade below a logarithmic axis."""
    ax.xaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
    ax.xaxis.set_major_formatter(FuncFormatter(lambda value, place: f"{value:g}"))
    ax.xaxis.set_minor_formatter(NullFormatter())


def legend_below(ax: Axes, columns: int = 3) -> None:
    """Legend below axes and their labels, with everything that has a label."""
    handles, _ = ax.get_legend_handles_labels()
    if not handles:
        return
    ticks = max((float(text.get_fontsize()) for text in ax.get_xticklabels()[:1]), default=8.0)
    lines = len(ax.get_xlabel().splitlines())
    points = 6 + 1.5 * ticks + 1.5 * float(ax.xaxis.label.get_fontsize()) * lines
    down = ScaledTranslation(0, -points / 72, ax.figure.dpi_scale_trans)
    ax.legend(
        ncols=min(columns, len(handles)),
        loc="upper center",
        bbox_to_anchor=(0.5, 0.0),
        bbox_transform=ax.transAxes + down,
        borderaxespad=0.0,
        columnspacing=1.2,
        handletextpad=0.5,
    )


def colour_bar(ax: Axes, image: Any, label: str) -> None:
    """Colour bar to the right of axes, of the same height."""
    ax.figure.colorbar(image, cax=ax.inset_axes((1.03, 0.0, 0.05, 1.0)), label=label)


def check_picture(path: Path, inputs: list[Path], overwrite: bool) -> None:
    """Refuse a picture that could not, or must not, be written, before any work is done for it.

    `inputs` are files that have to stay; `overwrite` is for a file that is no picture which
    varcontact drew.
    """
    kinds = sorted(set(FigureCanvasAgg.get_supported_filetypes()) - {"pgf"})  # which is for LaTeX
    check_replaceable(
        FIELD, path, [f".{kind}" for kind in kinds], "picture", OURS, overwrite, inputs
    )


def write_picture(figure: Figure, path: Path) -> None:
    """Write a figure atomically, in the format of the path's ending."""
    picture = io.BytesIO()
    kind = path.suffix[1:].lower()
    metadata = None
    if kind in _SIGNED:
        metadata = {_SIGNED[kind]: MARK}
    with reading(path, "cannot be drawn", FIELD, (OSError, RuntimeError, ValueError)):
        figure.savefig(
            picture,
            format=kind,
            dpi=300,
            metadata=metadata,
        )
    write_whole(FIELD, path, picture.getvalue())
