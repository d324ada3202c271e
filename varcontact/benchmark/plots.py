"""Performance profiles of solvers."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.figure import Figure

from varcontact.errors import SceneError
from varcontact.plotting import style

GROUPS_DRAWN = ("pressures", "shifts", "rolling")
FACTOR_MAX = 1e3
"""Multiple of the least time up to which profiles are drawn."""
DASHES = ("-", "--", ":")
COLOURS = 10
"""Colours of lines, after which dashes change."""


def plot_profiles(comparison: Any, tol: float) -> Figure:
    """Performance profiles of a `SolverComparison`, a panel for each group of problems."""
    tried = comparison.tried
    groups = [name for name in GROUPS_DRAWN if name in set(tried["group"])]
    if not groups or tol not in set(tried["tol"]):
        raise SceneError("tol", tol, "one of the tolerances compared")
    solvers = list(dict.fromkeys(tried["solver"]))
    styles = {name: _line_style(number) for number, name in enumerate(solvers)}
    factors = np.geomspace(1.0, FACTOR_MAX, 200)
    figure, axes = style.new_panels(len(groups), 3.6, None)
    for ax, group in zip(axes, groups, strict=True):
        profile = comparison.profile(group, tol, factors=factors)
        for name in profile:
            ax.step(factors, profile[name], where="post", **styles[name])
        ax.set_xscale("log")
        ax.set_ylim(-0.02, 1.02)
        ax.set_xlabel("time relative to the fastest")
        ax.set_title(f"{group}, to {tol:g}")
    axes[0].set_ylabel("fraction of problems")
    # legend of all solvers, also those that are not in the last panel
    handles = [axes[0].plot([], [], **each)[0] for each in styles.values()]
    columns = min(3, len(groups) + 1)
    figure.legend(handles, solvers, ncols=columns, loc="outside lower center", fontsize="small")
    return figure


def _line_style(number: int) -> dict[str, Any]:
    """Colour and dashes of a line."""
    return {"color": f"C{number % COLOURS}", "linestyle": DASHES[number // COLOURS % len(DASHES)]}
