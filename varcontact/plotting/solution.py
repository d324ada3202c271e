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
from varcontact.scene.friction import BRANCHES

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
    names = _panel_names(sol, what, ax)
    if y is not None and "section" not in names:
        raise SceneError("y", y, 'left out, or with the panel "section"')
    if ax is not None:
        with style.panel(ax, figsize, (1.0, 1.0)) as (figure, _):
            _draw(ax, sol, names[0], y)
        return figure
    with style.styled():
        if sol.scene.line:
            return _draw_stacked(sol, names, figsize, y)
        return _draw_side_by_side(sol, names, figsize, y)


def _draw_stacked(sol: Solution, names: list[str], figsize: Any, y: float | None) -> Figure:
    """Panels of a line contact below each other: one abscissa, and one legend at the foot."""
    size = (1.3 * style.COLUMN, 0.4 + 2.1 * len(names))
    figure, axes = style.new_figure(len(names), 1, size, figsize, sharex=True)
    entries: dict[str, Any] = {}
    for panel, name in zip(axes, names, strict=True):
        _draw(panel, sol, name, y)
        handles, labels = panel.get_legend_handles_labels()
        entries |= zip(labels, handles, strict=True)
        if handles:
            panel.legend().remove()
    for panel in axes[:-1]:
        panel.set_xlabel("")
    if entries:
        figure.legend(entries.values(), entries.keys(), ncols=5, loc="outside lower center")
    return figure


def _draw_side_by_side(sol: Solution, names: list[str], figsize: Any, y: float | None) -> Figure:
    """Panels of one height, in the shape of the contact where axes are to one scale."""
    box = box_of(sol.state > 0, sol.grid)
    left, right, bottom, top = box
    shape = 1.0
    if to_scale(box):
        shape = float(np.clip((top - bottom) / (right - left), 0.7, 1.3))
    side = 2.8 if len(names) == 1 else 1.45  # labels and a colour bar stand beside the panel
    figure, axes = style.new_panels(len(names), shape * side + 1.3, figsize, names)
    for panel, name in zip(axes, names, strict=False):
        panel.set_box_aspect(shape)
        _draw(panel, sol, name, y)
    figure.draw_without_rendering()
    return figure


def _panel_names(sol: Solution, what: Any, ax: Any) -> list[str]:
    """Names of the panels, chosen by the scene or checked."""
    if what is None:
        return _default_panels(sol, alone=ax is not None)
    several = isinstance(what, Sequence) and not isinstance(what, str)
    names = list(what) if several else [what]
    for name in names:
        _check_panel(sol, name)
    if not names:
        raise SceneError("what", what, "one panel at least")
    if ax is not None and len(names) > 1:
        raise SceneError("what", what, "one panel for one ax")
    return names


def _default_panels(sol: Solution, alone: bool) -> list[str]:
    """Panels of a picture, or the one that stands `alone`."""
    if sol.scene.motion is None:
        return ["pressure"] if sol.scene.line or alone else ["pressure", "section"]
    if alone:
        return ["traction"]
    if sol.scene.line:
        return ["traction", "slip"]
    return ["pressure", "traction", "section"]


def _check_panel(sol: Solution, name: Any) -> None:
    checks.choice("what", name, PANELS)
    if sol.scene.motion is None and name not in ("pressure", "distance", "section"):
        raise SceneError("what", name, "pressure, distance or section, where there is no motion")
    if name == "temperature" and sol.temperature is None:
        allowed = "another panel: temperatures need thermal data, and steady rolling"
        raise SceneError("what", name, allowed)
    if name == "power_density" and np.isnan(sol.power_density).all():
        allowed = f"another panel: {sol.plan.tangential} has no moment, and so no power of spin"
        raise SceneError("what", name, allowed)


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
        message = (
            f"solution has no passes to plot (coupling {sol.plan.coupling}): "
            "loops and laws of friction have them"
        )
        raise SceneError("solution", sol.plan.coupling, message=message)
    if sol.branch:
        loop = f"{sol.plan.friction} friction, from {BRANCHES[sol.branch]}"
        changed = "coefficients"
    else:
        loop = f"{sol.plan.coupling}, {sol.scene.difference}"
        changed = "pressure" if sol.plan.coupling == "joint" else "tractions"
    title = f"Passes: {loop}"
    if not sol.converged:
        title += " (not converged)"
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
        ax.set_title(title)
        ax.legend()
    return figure
