"""The picture of a history."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from varcontact.plotting.solution import BELOW, SLIP_COLOUR, STICK_COLOUR, label

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from varcontact.results.history import History


def plot_history(history: History) -> Figure:
    """Forces over the distance rolled (of shifts in place: over the steps), and stick and slip along the middle row.

    Parameters
    ----------
    history : History

    Returns
    -------
    matplotlib Figure
    """
    from matplotlib import pyplot as plt
    from matplotlib.colors import ListedColormap
    from matplotlib.patches import Patch

    from varcontact.plotting.ticks import readable_ticks

    rolls = bool(np.any(history.dq > 0))
    along = history.rolled if rolls else np.arange(len(history))
    last = history[-1]
    axis = label("distance rolled", "length", last) if rolls else "step"
    figure, (above, below) = plt.subplots(2, 1, figsize=(7.2, 7.2), layout="constrained")
    for name, values in {"$F_x$": history.force[:, 0], "$F_y$": history.force[:, 1]}.items():
        above.plot(along, values, label=name)
    bound = np.array([np.sum(sol.traction_bound) * sol.grid.area for sol in history])
    if np.all(np.isfinite(bound)):
        above.plot(along, bound, color="grey", linestyle="--", label="$\\pm$ friction's limit")
        above.plot(along, -bound, color="grey", linestyle="--")
    above.set(xlabel=axis, ylabel=label("tangential force", "force", last), title="Forces")
    above.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0), frameon=False)
    row = history.grid.rows // 2
    areas = np.ma.masked_equal(np.array([sol.state[row] for sol in history]).T, 0)
    left, right, _, _ = history.grid.box
    colours = ListedColormap([STICK_COLOUR, SLIP_COLOUR])
    edges = np.append(np.arange(len(history)), len(history)) - 0.5
    below.pcolormesh(edges, np.linspace(left, right, history.grid.nx + 1), areas, cmap=colours, vmin=1, vmax=2)
    below.set(xlabel="step", ylabel=label("x", "length", last), title="Areas along the middle of the contact")
    readable_ticks(above)
    readable_ticks(below)
    handles = [Patch(color=STICK_COLOUR, label="stick"), Patch(color=SLIP_COLOUR, label="slip")]
    below.legend(handles=handles, ncols=2, **BELOW)
    return figure
