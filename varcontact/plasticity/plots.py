"""Pictures of shakedown limits: the map, the section, and the critical curve."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Circle
from matplotlib.tri import LinearTriInterpolator, Triangulation

from varcontact import checks
from varcontact.plasticity.shakedown_result import Shakedown
from varcontact.plotting import style

MAP = np.array(
    [
        [0.0, 4.0000, 4.000],
        [0.1, 3.5642, 3.986],
        [0.2, 3.2024, 3.944],
        [0.3, 2.8996, 3.150],
        [0.35, 2.637, 2.733],
        [0.4, 2.316, 2.404],
        [0.5, 1.882, 1.935],
    ]
)
"""Friction, and p0/k of line contacts in full slip, nu = 0.3, von Mises: without hardening, and
with unlimited kinematic hardening; by `python -m tests.benchmarks shakedown line`."""


SMALL_FLOW = 0.08
"""Velocity, divided by the largest, of the nodes that set the limits of the picture; arrows are
drawn above half of it."""
ARROWS = (13, 7)
"""Largest number of arrows across the section and down."""


@checks.named_options()
def plot_shakedown_map(
    limits: Shakedown | Mapping[str, Shakedown],
    *,
    ax: Axes | None = None,
    figsize: tuple[float, float] | None = None,
) -> Figure:
    """Peak pressure against the largest local traction, with the limit of each patch as a bar from
    its lower to its upper bound.

    Parameters
    ----------
    limits : Shakedown, or mapping of str to Shakedown
        Several by name.
    ax, figsize
        As for `Solution.plot`.

    Returns
    -------
    matplotlib Figure
        A patch whose point lies below its bar shakes down, above it does not. The curves are those
        of line contacts in full slip (nu = 0.3), and Johnson's line 1/f.
    """
    if isinstance(limits, Shakedown):
        limits = {"": limits}
    checks.kind("limits", limits, Shakedown, Mapping)
    for name, limit in limits.items():
        checks.kind(f"limits[{name!r}]", limit, Shakedown)
    with style.panel(ax, figsize, (style.COLUMN, style.COLUMN)) as (figure, drawn):
        friction, perfect, kinematic = MAP.T
        drawn.plot(friction, perfect, color="0.3", label="line contact, full slip")
        drawn.plot(friction, kinematic, color="0.3", ls="--", label="with kinematic hardening")
        beyond = np.linspace(0.2, 0.6, 41)
        drawn.plot(beyond, 1 / beyond, color="0.6", ls=":", label="1/f")
        for number, (name, limit) in enumerate(limits.items()):
            colour = style.colour(number)
            pressure = limit.peak_pressure / limit.strength
            bounds = [limit.lower * pressure, limit.upper * pressure]
            drawn.plot([limit.local] * 2, bounds, color=colour, lw=4, solid_capstyle="butt")
            drawn.plot(limit.local, pressure, **style.look(number), ls="", label=name or None)
        drawn.plot([], [], color="0.5", lw=4, solid_capstyle="butt", label="bounds of the limit")
        drawn.set(
            xlabel="largest traction / largest pressure",
            ylabel="largest pressure / k",
            ylim=(0, None),
            xlim=(-0.02, 0.6),
        )
        style.legend_below(drawn, columns=2)
    return figure


def plot_limit(limit: Shakedown, figsize: tuple[float, float] | None = None) -> Figure:
    """The section with the residual stress, the critical curve with its circle, and the velocities
    of a mechanism if one was found.
    """
    rows = 1
    if limit.mechanism is not None:
        rows = 2
    with style.styled():
        size = (style.PAGE, 0.4 * rows * style.PAGE)
        figure, axes = style.new_figure(rows, 2, size, figsize)
        if limit.section.y.size > 1:
            _draw_section(axes[0], limit)
        else:
            _draw_depths(axes[0], limit)
        _draw_curve(axes[1], limit)
        if limit.mechanism is not None:
            _draw_velocities(axes[2], limit)
            axes[3].set_axis_off()
    return figure


def _draw_section(ax: Axes, limit: Shakedown) -> None:
    """Residual stress along x by k, and the place of the limit."""
    section = limit.section
    shown = section.stress[0, 0] / limit.strength
    largest = max(float(np.abs(shown).max()), 1e-9)
    levels = np.linspace(-largest, largest, 21)
    image = ax.contourf(section.y, section.depth, shown, levels, cmap="RdBu_r")
    name = {"none": "residual stress", "kinematic": "back stress"}[limit.hardening]
    style.colour_bar(ax, image, f"{name} $\\rho_{{xx}}/k$")
    ax.plot(limit.place, limit.depth, "k+", markersize=9, clip_on=False, label=limit.mode)
    half = 0.4 * np.ptp(section.y) / 2
    middle = float(section.y.mean())
    window = {"xlim": (middle - half, middle + half), "ylim": (float(section.depth[-1]) / 2.5, 0)}
    ax.set(xlabel="y", ylabel="depth", **window)
    style.legend_below(ax, columns=2)


def _draw_velocities(ax: Axes, limit: Shakedown) -> None:
    """Velocities in the part of the section that flows: along x by colour, across it by arrows."""
    flow: Any = limit.mechanism
    y, depth = flow.mesh.places.T * flow.unit
    velocity = flow.velocity
    if flow.mesh.places[:, 0].min() >= 0:  # half of a symmetric section
        other = y > 0
        y = np.concatenate([-y[other], y])
        depth = np.concatenate([depth[other], depth])
        mirrored = velocity[:, other] * [[1], [-1], [1]]
        velocity = np.concatenate([mirrored, velocity], axis=1)
    mesh = Triangulation(y, depth)
    image = ax.tricontourf(mesh, velocity[0], np.linspace(-1, 1, 21), cmap="PuOr_r")
    style.colour_bar(ax, image, "velocity along x by the largest")
    # arrows on a lattice in the part that flows
    counts = np.abs(velocity).max(axis=0) > SMALL_FLOW
    ends = (y[counts].min(), y[counts].max())
    lowest = depth[counts].max()
    across, down = ARROWS
    at = np.meshgrid(np.linspace(*ends, across), lowest * (np.arange(down) + 0.5) / down)
    arrows = [np.asarray(LinearTriInterpolator(mesh, each)(*at).filled(0)) for each in velocity[1:]]
    shown = np.hypot(*arrows) > SMALL_FLOW / 2
    places = [each[shown] for each in at]
    ax.quiver(*places, arrows[0][shown], -arrows[1][shown], scale=3.0, width=0.005, pivot="middle")
    ax.plot([], [], "k", marker="$\\rightarrow$", markersize=12, ls="", label="velocity across x")
    ax.set(xlabel="y", ylabel="depth", xlim=ends, ylim=(lowest, 0))
    style.legend_below(ax, columns=2)


def _draw_depths(ax: Axes, limit: Shakedown) -> None:
    """Residual stresses of a line contact over the depth."""
    section = limit.section
    for number, name in ((0, "xx"), (1, "yy")):
        stress = section.stress[number, number, :, 0] / limit.strength
        ax.plot(stress, section.depth, label=f"$\\rho_{{{name}}}/k$")
    ax.axhline(limit.depth, color="0.6", lw=0.6, label=limit.mode)
    ax.set(xlabel="residual stress / k", ylabel="depth", ylim=(section.depth[-1], 0))
    style.legend_below(ax, columns=3)


def _draw_curve(ax: Axes, limit: Shakedown) -> None:
    """The critical point's stresses at the upper bound, and the yield surface around the centre of
    their smallest ball, in the plane of the two coordinates that vary most.
    """
    names = ("(s_{yy} - s_{zz})/2", "\\sqrt{3}\\, s_{xx}/2", "s_{xy}", "s_{xz}", "s_{yz}")
    curve = limit.upper * limit.critical
    first, second = np.sort(np.argsort(-np.ptp(curve, axis=0))[:2])
    centre = limit.upper * limit.centre
    ax.plot(curve[:, first], curve[:, second], label="elastic stress, a passage")
    ax.add_patch(Circle((centre[first], centre[second]), 1.0, fill=False, color="0.5"))
    ax.plot(centre[first], centre[second], "k+", label="minus the residual stress")
    ax.set(xlabel=f"${names[first]}/k$", ylabel=f"${names[second]}/k$", aspect="equal")
    style.legend_below(ax, columns=2)
