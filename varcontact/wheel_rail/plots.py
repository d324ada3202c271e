"""Plots of profiles, wheels on rails, series of positions, and wear."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from varcontact.errors import SceneError
from varcontact.plotting.fields import box_of
from varcontact.plotting.style import (
    PAGE,
    colour,
    colour_bar,
    empty_figure,
    legend_below,
    look,
    new_figure,
    new_panels,
    styled,
)
from varcontact.plotting.unit_labels import measure
from varcontact.results.solution import Panel
from varcontact.wheel_rail.curve import Curve
from varcontact.wheel_rail.patch_solution import PatchSolution
from varcontact.wheel_rail.quantities import Quantity, panels_of

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from varcontact.wheel_rail.geometry_table import GeometryTable
    from varcontact.wheel_rail.profile import Profile
    from varcontact.wheel_rail.result import WheelForces, WheelRailSolution
    from varcontact.wheel_rail.wear_depth import Wear
    from varcontact.wheel_rail.wheel_set import WheelSetOnTrack
    from varcontact.wheel_rail.wheel_set_solution import WheelSetSolution

STEP = 0.05
"""Spacing of the points of a drawn curve [mm]."""
NORMAL = 12.0
"""Length of the arrow of the largest normal force [mm]."""
ACROSS = 3
"""Number of panels in a row in pictures of many positions."""
ROW = 0.2625
"""Height of a row of panels over positions, relative to the width of the page."""
ROW_OF_SWEEP = 0.3
"""Height of a row of panels over a sweep, relative to the width of the page; each panel has an
axis."""
OF_TABLE = {
    "radius_difference": ("rolling radius difference [mm]", 1.0),
    "angle": ("contact angle [mrad]", 1e3),
    "conicity": ("equivalent conicity", 1.0),
    "rolling_radius": ("rolling radius [mm]", 1.0),
    "on_rail": ("contact on the rail, y [mm]", 1.0),
    "on_wheel": ("contact on the wheel, y [mm]", 1.0),
}
"""Panels of a table of contacts, with labels and factors to their units."""
CONTACTS = ("on_rail", "on_wheel")
TITLES: dict[Panel, str] = {
    "pressure": "Patch {number}: {force}, up to {solved.peak_pressure:.4g} MPa",
    "traction": "Traction on the rail",
}


def plot_profile(profile: Profile) -> Figure:
    """Points, curve and kinks of a profile, and below them the curvature of the part that can be
    touched.
    """
    with styled():
        figure, (above, below) = new_figure(
            2, 1, (PAGE, 0.75 * PAGE), sharex=True, height_ratios=[3, 2]
        )
        above.plot(profile.y, profile.z, ".", color="0.6", markersize=3, label="points")
        curve = profile.curve.points(profile.curve.sampled(STEP))
        above.plot(*curve.T, label="spline")
        kinks = profile.kink_points
        if kinks.size:
            above.plot(profile.y[kinks], profile.z[kinks], "x", color=colour(3), label="kinks")
        outliers = profile.outliers()
        if outliers.size:
            above.plot(
                profile.y[outliers],
                profile.z[outliers],
                "o",
                markersize=7,
                markerfacecolor="none",
                color=colour(1),
                label=f"outliers ({outliers.size})",
            )
        above.set(ylabel="z [mm]", aspect="equal", title=profile.name or profile.kind)
        above.invert_yaxis()
        legend_below(above)
        for side, x, place in (("track side", 0.01, "left"), ("field side", 0.99, "right")):
            above.text(x, 0.03, side, transform=above.transAxes, ha=place, color="0.4")
        at = profile.running.sampled(STEP)
        curvatures = profile.running.curvatures(at)
        if profile.kind == "wheel":
            curvatures = -curvatures
        below.axhline(0, color="0.7", linewidth=0.8)
        below.plot(profile.running.points(at)[:, 0], curvatures)
        below.set(xlabel="y [mm]", ylabel="curvature [1/mm], convex +")
        figure.draw_without_rendering()
    return figure


def plot_wheel_on_rail(solution: WheelRailSolution) -> Figure:
    """Rail and wheel, seen in the direction of travel, and the patches at their place; pressure and
    tractions.
    """
    count = len(solution.patches)
    with styled():
        figure = empty_figure((PAGE, 2.4 + 2.6 * count))
        spaces = figure.add_gridspec(count + 1, 2, height_ratios=[1.0, *[1.2] * count])
        _draw_profiles(figure.add_subplot(spaces[0, :]), solution)
        for i, each in enumerate(solution.patches, 1):
            for column, (panel, title) in enumerate(TITLES.items()):
                ax = figure.add_subplot(spaces[i, column])
                each.solution.plot(panel, ax=ax)
                force = measure(each.solution.scene, "force", each.normal_force).text(
                    each.normal_force, digits=4
                )
                ax.set(xlabel="x, forward [mm]", ylabel="s, to the right [mm]")
                ax.set_title(title.format(number=i, force=force, solved=each))
        figure.draw_without_rendering()
    return figure


def _draw_profiles(ax: Axes, solution: WheelForces) -> None:
    """The rail, the points of the wheel nearest to it, and the patches with the directions of their
    normal forces.
    """
    case = solution.case
    # rails and wheel
    if isinstance(case.rail, Curve):
        curves = [case.rail]
    else:
        curves = case.rail.sections(0.0)
    shapes = [curve.points(curve.sampled(STEP)) for curve in curves]
    for number, shape in enumerate(shapes):
        label = "rail" if number == 0 else None
        ax.plot(*shape.T, color="0.25", label=label)
    wheel = case.locus.points[:, 1:] + [0.0, solution.z]
    ax.plot(*wheel.T, color=colour(0), label="wheel")
    # patches
    largest = max(float(each.force[2]) for each in solution.patches)
    for number, each in enumerate(solution.patches, 1):
        _draw_patch(ax, each, number, NORMAL * float(each.force[2]) / largest)
    y, z = np.concatenate(shapes).T
    place = f"y = {case.position.y:.4g} mm, yaw = {1e3 * case.position.yaw:.4g} mrad"
    ax.set(
        xlim=(y.min() - 5, y.max() + 5),
        ylim=(z.max() * 0.6, z.min() - 18),
        aspect="equal",
        xlabel="y, to the right [mm]",
        ylabel="z, downwards [mm]",
        title=f"{case.side.capitalize()} wheel, {place}",
    )
    legend_below(ax)


def _draw_patch(ax: Axes, patch: Any, number: int, length: float) -> None:
    """The line of a patch, and its normal force as an arrow of a length [mm]."""
    if isinstance(patch, PatchSolution):
        grid = patch.solution.grid
        rows = np.flatnonzero(patch.solution.pressure.max(axis=1) > 0)
        ends = grid.y[rows[[0, -1]]] + np.array([-0.5, 0.5]) * grid.sides[1]
    else:
        ends = patch.ellipse.b * np.array([-1.0, 1.0])
    frame = patch.frame
    line = frame.globally(np.array([[0.0, s, 0.0] for s in ends]))[:, 1:]
    label = "contact patch" if number == 1 else None
    red = colour(3)
    ax.plot(*line.T, color=red, linewidth=4, solid_capstyle="butt", label=label)
    foot = frame.origin[1:]
    outwards = -frame.normal[1:]
    ax.annotate(
        str(number),
        tuple(foot),
        tuple(foot + length * outwards),
        color=red,
        ha="center",
        va="center",
        arrowprops={"arrowstyle": "-|>", "color": red},
    )


def plot_wheel_set(solution: WheelSetSolution) -> Figure:
    """Both wheels on their rails, with the patches and the directions of their normal forces."""
    with styled():
        figure, axes = new_figure(2, 1, (PAGE, 0.8 * PAGE))
        for ax, wheel in zip(axes, solution.wheels, strict=True):
            _draw_profiles(ax, wheel)
        figure.draw_without_rendering()
    return figure


def plot_positions(table: pd.DataFrame) -> Figure:
    """Contact points, creepages and forces over a sequence of positions; wheels that are not solved
    are left out.

    `table` is that of `varcontact.wheel_rail.case_file.solve_cases`.
    """
    solved = table[table["outcome"] == "solved"]
    over = "position"
    label = "Position"
    if solved["y"].nunique() > 1:
        over = "y"
        label = "Lateral displacement [mm]"
    panels = panels_of("positions")
    rows = math.ceil(len(panels) / ACROSS)
    with styled():
        figure, axes = new_figure(rows, ACROSS, (PAGE, rows * ROW * PAGE), sharex=True)
        _draw_panels(axes, solved, over, panels)
        for ax in axes[-ACROSS:]:
            ax.set_xlabel(label)
        legend_below(axes[-2], columns=4)
        figure.draw_without_rendering()
    return figure


def _draw_panels(
    axes: Sequence[Axes], rows: pd.DataFrame, over: str, panels: Sequence[Quantity]
) -> None:
    """Quantities over a column, with error bars if there are any: a line for each patch of each
    wheel.
    """
    for ax, quantity in zip(axes, panels, strict=False):
        panel = quantity.panel
        assert panel is not None
        for i, (side, of_side) in enumerate(rows.groupby("side")):
            for patch, each in of_side.groupby("patch"):
                line = "o-"
                label = f"{side} wheel"
                if patch != 1:
                    line = "^:"
                    label = f"{side} wheel, patch {patch}"
                bars = None
                error = each.get(quantity.error_column)
                if error is not None and not error.isna().all():
                    bars = panel.factor * error
                ax.errorbar(
                    each[over],
                    panel.factor * each[quantity.name],
                    bars,
                    fmt=line,
                    color=colour(i),
                    markersize=3,
                    capsize=2,
                    label=label,
                )
        ax.set_ylabel(panel.label)
    for ax in axes[len(panels) :]:
        ax.set_visible(False)


def plot_wear(worn: Wear) -> Figure:
    """Friction power per area of each patch, and the depth of wear across it where there is a
    law.
    """
    columns = 1
    if worn.patches[0].archard is not None:
        columns = 2
    with styled():
        figure, axes = new_figure(
            len(worn.patches), columns, (PAGE * columns / 2, 2.8 * len(worn.patches))
        )
        for i, each in enumerate(worn.patches):
            ax = axes[columns * i]
            grid = each.solved.solution.grid
            contact = each.solved.solution.pressure > 0
            shown = np.where(contact, each.power_by_area, np.nan)
            image = ax.imshow(
                shown, origin="lower", extent=grid.box, cmap="inferno_r", aspect="equal"
            )
            image.set_clim(vmin=min(0.0, float(np.nanmin(shown))))
            colour_bar(ax, image, "W/mm²")
            left, right, bottom, top = box_of(contact, grid)
            ax.set(
                xlim=(left, right),
                ylim=(bottom, top),
                xlabel="x, forward [mm]",
                ylabel="s, to the right [mm]",
                title=f"Patch {i + 1}: T-gamma {each.t_gamma:.4g} N, {each.power:.4g} W",
            )
            if each.archard is not None:
                ax = axes[columns * i + 1]
                depth = 1e6 * each.depth
                ax.plot(depth, grid.y)
                ax.set(
                    xlim=(min(0.0, float(depth.min())), None),
                    ylim=(bottom, top),
                    title=type(each.archard).__name__,
                )
                ax.set(xlabel="depth of wear per passage [nm]", ylabel="s, to the right [mm]")
        figure.draw_without_rendering()
    return figure


def plot_geometry(table: GeometryTable, figsize: tuple[float, float] | None = None) -> Figure:
    """Rolling radius difference, contact angle, conicity and contacts on the profiles of the right
    wheel, over the lateral displacement, at the middle node of yaw.
    """
    data = table.to_xarray().isel(yaw=table.yaw.size // 2)
    yaw = f"yaw = {1e3 * float(data['yaw']):.3g} mrad"
    with styled():
        figure, axes = new_panels(len(OF_TABLE), 2.4, figsize, tuple(OF_TABLE))
        for ax, (name, (label, factor)) in zip(axes, OF_TABLE.items(), strict=False):
            if "patch" not in data[name].dims:
                ax.plot(table.y, factor * data[name], "o-", markersize=3)
                ax.set_title("wheel set, without yaw")
            else:
                for k, patch in enumerate(data["patch"].values):
                    values = factor * data[name].sel(patch=patch)
                    if np.isfinite(values).any():
                        marks = look(k) | {"linestyle": "", "markersize": 3}
                        ax.plot(table.y, values, **marks, label=f"patch {patch}")
                ax.set_title(f"right wheel, {yaw}")
            ax.set(xlabel="lateral displacement [mm]", ylabel=label)
        handles, labels = axes[-1].get_legend_handles_labels()
        if len(labels) > 1:
            figure.legend(handles, labels, ncols=3, loc="outside lower center")
        figure.draw_without_rendering()
    return figure


def plot_wheel_sets(swept: xr.Dataset, case: WheelSetOnTrack | None = None) -> Figure:
    """Contact points, forces and damage of a sweep of wheel sets over its entry, error bars
    included.

    `swept` is that of `varcontact.wheel_rail.sweep_wheel_sets` over one entry (take others by
    ``sel``); with its `case` the contact points are drawn on both profiles, too.
    """
    entries = [str(name) for name in swept["z"].dims]
    if len(entries) != 1:
        raise SceneError("swept", entries, "a sweep over one entry: take the others by sel(...)")
    (entry,) = entries
    rows = swept.to_dataframe().reset_index().dropna(subset="FN")
    cosine = np.abs(np.cos(rows["angle"]))
    sine = np.abs(np.sin(rows["angle"]))
    rows["error_track_Fx"] = rows["error_Fx"]
    rows["error_track_Fy"] = cosine * rows["error_Fs"] + sine * rows["error_FN"]
    rows["error_track_Fz"] = sine * rows["error_Fs"] + cosine * rows["error_FN"]
    panels = panels_of("sweep")
    height = math.ceil(len(panels) / ACROSS)
    drawn = height * ACROSS
    if case is not None:
        height += 1
    with styled():
        figure, axes = new_figure(height, ACROSS, (PAGE, height * ROW_OF_SWEEP * PAGE))
        _draw_panels(axes[:drawn], rows, entry, panels)
        for ax in axes[:drawn]:
            ax.set_xlabel(entry)
        if case is not None:
            _draw_contacts(axes[drawn:], rows, case)
        legend_below(axes[drawn - 2], columns=4)
        figure.draw_without_rendering()
    return figure


def _draw_contacts(axes: Sequence[Axes], rows: pd.DataFrame, case: WheelSetOnTrack) -> None:
    """The contact points of a sweep on both profiles."""
    profiles = (case.track.profile, case.wheelset.profile)
    for ax, profile, name in zip(axes, profiles, CONTACTS, strict=False):
        shape = profile.running.points(profile.running.sampled(STEP))
        ax.plot(*shape.T, color="0.4")
        for i, (_, y) in enumerate(rows.groupby("side")[name]):
            ax.plot(y, profile.z_at(y), "o", color=colour(i), markersize=3)
        ax.invert_yaxis()
        ax.set(xlabel="y [mm]", ylabel="z [mm]", title=f"contacts on the {profile.kind}")
    for ax in axes[len(profiles) :]:
        ax.set_visible(False)
