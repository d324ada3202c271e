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


def plot_profiles(comparison: Any, tol: float) -> Figure:
    """Performance profiles of a `SolverComparison`, a panel for each group of problems."""
    tried = comparison.tried
    groups = [name for name in GROUPS_DRAWN if name in set(tried["group"])]
    if not groups or tol not in set(tried["tol"]):
        raise SceneError("tol", tol, "one of the tolerances compared")
    solvers = list(dict.fromkeys(tried["solver"]))
    factors = np.geomspace(1.0, FACTOR_MAX, 200)
    figure, axes = style.new_panels(len(groups), 3.4, None)
    for ax, group in zip(axes, groups, strict=True):
        profile = comparison.profile(group, tol, factors=factors)
        for number, name in enumerate(solvers):
            if name in profile:
                dashes = ("-", "--", ":")[number // 10 % 3]
                ax.step(factors, profile[name], dashes, where="post", color=f"C{number % 10}")
        ax.set_xscale("log")
        ax.set_xlabel("time by the least")
        ax.set_title(f"{group}, to {tol:g}")
    axes[0].set_ylabel("fraction of problems")
    handles = []
    for number, _ in enumerate(solvers):
        dashes = ("-", "--", ":")[number // 10 % 3]
        handles += axes[0].plot([], [], dashes, color=f"C{number % 10}")
    figure.legend(handles, solvers, ncols=4, loc="outside lower center")
    return figure
