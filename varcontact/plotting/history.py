"""The picture of a history."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from varcontact.discrete.stick_slip import SLIP
from varcontact.plotting.quantities import Measure, measure, measure_of
from varcontact.plotting.style import (
    COLUMN,
    SLIP_COLOUR,
    STICK_COLOUR,
    area_patches,
    legend_beside,
    new_figure,
    styled,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from varcontact.results.history import History


def plot_history(history: History, figsize: tuple[float, float] | None = None) -> Figure:
    """Forces, creepages where forces are prescribed, and the areas along the middle row, over one abscissa.

    Parameters
    ----------
    history : History
    figsize : pair of float, optional
        [inch]

    Returns
    -------
    matplotlib Figure
    """
    from varcontact.plotting.solution import figure_size

    along = abscissa(history)
    found = _creepages(history)
    panels = 3 if found else 2
    size = (COLUMN * 1.5, 0.4 + 1.7 * panels) if figsize is None else figure_size(figsize)
    with styled():
        figure, axes = new_figure(panels, 1, size, sharex=True)
        draw_forces(axes[0], history, along)
        if found:
            _draw_creepages(axes[1], found, along)
        _draw_areas(axes[-1], history, along)
        for ax in axes[:-1]:
            ax.set_xlabel("")
    return figure


@dataclass(frozen=True)
class Abscissa:
    """What a history is shown over.

    Attributes
    ----------
    values : ndarray, shape (steps,)
        As shown.
    edges : ndarray, shape (steps + 1,)
        Between which each step takes place.
    label : str
    """

    values: np.ndarray
    edges: np.ndarray
    label: str


def abscissa(history: History) -> Abscissa:
    """The distance rolled; the number of the step where steps after the first are in place.

    Parameters
    ----------
    history : History
    """
    if len(history) > 1 and np.all(history.dq[1:] > 0):
        measured = measure_of(history.scene, "length", history.rolled)
        rolled = measured(history.rolled)
        return Abscissa(rolled, np.append(0.0, rolled), measured.label("distance rolled"))
    steps = np.arange(len(history), dtype=float)
    return Abscissa(steps, np.arange(len(history) + 1) - 0.5, "step")


def draw_forces(ax: Axes, history: History, along: Abscissa) -> None:
    """Tangential forces, within what friction can carry.

    Parameters
    ----------
    ax : Axes
    history : History
    along : Abscissa
    """
    from varcontact.plotting.ticks import readable_ticks

    limit = np.array([np.sum(sol.traction_bound) * sol.grid.area for sol in history])
    finite = bool(np.all(np.isfinite(limit)))
    measured = measure_of(history.scene, "force", [*history.force.T, limit if finite else 0 * history.dq])
    looks: dict[str, Any] = {"markersize": 2.5} if len(history) < 40 else {"marker": ""}
    size = np.abs(history.force).max(initial=0.0)
    for i, (name, line) in enumerate((("$F_x$", "o-"), ("$F_y$", "s--"))):
        values = history.force[:, i]
        if i == 0 or np.abs(values).max(initial=0.0) > 1e-9 * size:
            ax.plot(along.values, measured(values), line, label=name, clip_on=False, **looks)
    if finite:
        ax.plot(along.values, measured(limit), color="0.45", linestyle=":", label="$\\pm$ friction's limit")
        ax.plot(along.values, -measured(limit), color="0.45", linestyle=":")
    readable_ticks(ax)
    ax.set(xlabel=along.label, ylabel=measured.label("tangential force"))
    legend_beside(ax)


def _creepages(history: History) -> dict[str, np.ndarray]:
    """Creepages that prescribed forces gave, by name: NaN in steps where none is sought or known."""
    motions, found = [sol.motion for sol in history], {}
    for i, (name, force) in enumerate((("$v_x$", "Fx"), ("$v_y$", "Fy"))):
        sought = [motion is not None and motion.rolls != 0 and getattr(motion, force) is not None for motion in motions]
        values = np.where(sought, history.creepage[:, i], np.nan)
        if np.isfinite(values).any():
            found[name] = values
    return found


def _draw_creepages(ax: Axes, found: dict[str, np.ndarray], along: Abscissa) -> None:
    from varcontact.plotting.ticks import readable_ticks

    looks = {"$v_x$": "o-", "$v_y$": "s--"}
    measured = measure("1", None, list(found.values()))
    for name, values in found.items():
        size = 2.5 if values.size < 40 else 0
        ax.plot(along.values, measured(values), looks[name], label=name, markersize=size, clip_on=False)
    ax.axhline(0, color="k", linewidth=0.5)
    readable_ticks(ax)
    ax.set(xlabel=along.label, ylabel=measured.label("creepage found"))
    legend_beside(ax)


def _draw_areas(ax: Axes, history: History, along: Abscissa) -> None:
    """Stick and slip of the middle row, slip hatched, from step to step."""
    from matplotlib.colors import ListedColormap

    from varcontact.plotting.ticks import readable_ticks

    lengths = measure_of(history.scene, "length", history.grid.box)
    row = history.grid.rows // 2
    areas = np.array([sol.state[row] for sol in history]).T
    left, right, _, _ = history.grid.box
    across = lengths(np.linspace(left, right, history.grid.nx + 1))
    colours = ListedColormap([STICK_COLOUR, SLIP_COLOUR])
    ax.pcolormesh(along.edges, across, np.ma.masked_equal(areas, 0), cmap=colours, vmin=1, vmax=2)
    _hatch(ax, areas == SLIP, along.edges, across)
    readable_ticks(ax)
    ax.set(xlabel=along.label, ylabel=_middle(history, lengths))
    legend_beside(ax, area_patches())


def _middle(history: History, lengths: Measure) -> str:
    return lengths.label("x" if history.scene.line else "x, middle row")


def _hatch(ax: Axes, slip: np.ndarray, across: np.ndarray, up: np.ndarray) -> None:
    """Hatching over what slips, between edges `across` (by column) and `up` (by row)."""
    from matplotlib.patches import PathPatch
    from matplotlib.path import Path

    from varcontact.plotting.style import HATCH, SLIP_INK

    vertices = []
    for column in range(slip.shape[1]):
        changes = np.flatnonzero(np.diff(slip[:, column], prepend=False, append=False))
        left, right = across[column], across[column + 1]
        for low, high in up[changes].reshape(-1, 2):
            vertices += [(left, low), (right, low), (right, high), (left, high), (left, low)]
    codes = [Path.MOVETO, Path.LINETO, Path.LINETO, Path.LINETO, Path.CLOSEPOLY] * (len(vertices) // 5)
    path = Path(np.array(vertices, dtype=float).reshape(-1, 2), codes)
    ax.add_patch(PathPatch(path, facecolor="none", edgecolor=SLIP_INK, hatch=HATCH, linewidth=0, gid="slip"))
