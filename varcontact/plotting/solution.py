"""Pictures of a solution, in the field's way."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, get_args

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from varcontact import checks
from varcontact.errors import SceneError
from varcontact.plotting import style
from varcontact.plotting.fields import box_of, draw_areas, draw_field, draw_section, to_scale
from varcontact.results.solution import Panel, Solution
from varcontact.scene.friction import BRANCHES, Law
from varcontact.scene.friction_laws import kind_of

PANELS = get_args(Panel)


def plot(
    sol: Solution,
    what: Panel | Sequence[Panel] | None = None,
    *,
    ax: Axes | None = None,
    figsize: tuple[float, float] | None = None,
    y: float | None = None,
) -> Figure:
    """The picture of a solution, see `Solution.plot`."""
    names, line = _names(sol, what, ax), sol.scene.line
    if y is not None and "section" not in names:
        raise SceneError("y", y, 'left out, or with the panel "section"')
    if ax is not None:
        with style.panel(ax, figsize, (1.0, 1.0)) as (figure, _):
            _draw(ax, sol, names[0], y)
        return figure
    with style.styled():
        if line:  # below each other over the same abscissa
            size = 1.3 * style.COLUMN, 0.4 + 2.1 * len(names)
            figure, axes = style.new_figure(len(names), 1, size, figsize, sharex=True)
        else:  # of one height
            left, right, bottom, top = box = box_of(sol.state > 0, sol.grid)
            shape = (
                float(np.clip((top - bottom) / (right - left), 0.7, 1.3)) if to_scale(box) else 1.0
            )
            side = 2.8 if len(names) == 1 else 1.45  # beside it are labels and a colour bar
            figure, axes = style.new_panels(len(names), shape * side + 1.3, figsize)
            for panel in axes:
                panel.set_box_aspect(shape)
        for panel, name in zip(axes, names, strict=True):
            _draw(panel, sol, name, y)
        if line:
            entries: dict[str, Any] = {}  # one legend at the foot, and the abscissa's label
            for panel in axes:
                handles, labels = panel.get_legend_handles_labels()
                entries |= zip(labels, handles, strict=True)
                if handles:
                    panel.legend().remove()
            for panel in axes[:-1]:
                panel.set_xlabel("")
            if entries:
                figure.legend(entries.values(), entries.keys(), ncols=5, loc="outside lower center")
        else:
            figure.draw_without_rendering()
        return figure


def _names(sol: Solution, what: Any, ax: Any) -> list[str]:
    if what is None:
        if sol.scene.motion is None:
            names = ["pressure"] if sol.scene.line else ["pressure", "section"]
        else:
            names = ["traction", "slip"] if sol.scene.line else ["pressure", "traction", "section"]
        return (
            names
            if ax is None
            else [names[0] if sol.scene.line or sol.scene.motion is None else "traction"]
        )
    names = [what] if isinstance(what, str) or not isinstance(what, Sequence) else list(what)
    for name in names:
        checks.choice("what", name, PANELS)
        if name not in ("pressure", "distance", "section") and sol.scene.motion is None:
            raise SceneError(
                "what", name, "pressure, distance or section, where there is no motion"
            )
        if name == "temperature" and sol.temperature is None:
            raise SceneError(
                "what", name, "another panel: temperatures need thermal data, and steady rolling"
            )
        if name == "power_density" and np.isnan(sol.power_density).all():
            allowed = f"another panel: {sol.plan.tangential} has no moment, and so no power of spin"
            raise SceneError("what", name, allowed)
    if not names or (ax is not None and len(names) > 1):
        raise SceneError(
            "what", what, "one panel" + (" for one ax" if ax is not None else " at least")
        )
    return names


def _draw(ax: Axes, sol: Solution, name: str, y: float | None) -> None:
    if name == "section" or (name == "traction" and sol.scene.line):
        draw_section(ax, sol, y)
    elif name == "traction":
        draw_areas(ax, sol)
    else:
        draw_field(ax, sol, name)


def plot_passes(sol: Solution) -> Figure:
    """Change and residual of the whole against the passes, see `Solution.plot_passes`."""
    if not sol.passes:
        message = f"solution has no passes to plot (coupling {sol.plan.coupling}): loops and laws of friction have them"
        raise SceneError("solution", sol.plan.coupling, message=message)
    if isinstance(sol.scene.friction, Law):
        shown, changed = (
            f"{kind_of(sol.scene.friction)} friction, from {BRANCHES[sol.branch]}",
            "coefficients",
        )
    else:
        shown = f"{sol.plan.coupling}, {sol.scene.difference}"
        changed = "pressure" if sol.plan.coupling == "joint" else "tractions"
    with style.styled():
        figure, (ax,) = style.new_figure(1, 1, (style.COLUMN, 2.6))
        changes, residuals = np.array(sol.passes).T
        passes = np.arange(1, len(residuals) + 1)
        ax.semilogy(
            passes, residuals, "o-", color=style.TRACTION_COLOUR, label="residual of the whole"
        )
        ax.semilogy(passes[1:], changes[1:], "s--", color="0.5", label=f"change of the {changed}")
        ax.xaxis.set_major_locator(MaxNLocator(6, integer=True))
        ax.set_xlabel("pass")
        ax.set_ylabel("relative")
        ax.set_title(f"Passes: {shown}" + ("" if sol.converged else " (not converged)"))
        ax.legend()
    return figure
