"""Pictures in frequency: Bode's and Nyquist's diagrams of a response, and the growth of corrugation
over wavelength.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from varcontact import checks
from varcontact.plotting import style
from varcontact.plotting.unit_labels import Measure, measure
from varcontact.results.frequency import FrequencyResponse

if TYPE_CHECKING:
    import xarray as xr

NAMES = {
    "Fx": "F_x",
    "Fy": "F_y",
    "Mz": "M_z",
    "Fz": "F_z",
    "vx": "v_x",
    "vy": "v_y",
    "spin": r"\varphi",
    "normal_force": "N",
    "roughness": "r",
    "approach": r"\delta",
}
"""Symbols of outputs and inputs."""


def plot_response(
    response: FrequencyResponse, output: str, by: str, figsize: tuple[float, float] | None = None
) -> Figure:
    """Size and phase over the wave number, and Nyquist's diagram."""
    values = response.of(output, by)
    k = response.wave_number
    quantity = "1"
    if output in ("Fx", "Fy", "Fz") and by in ("vx", "vy"):
        quantity = "force"
    measured = measure(response.scene, quantity, np.abs(values))
    waves = measure(response.scene, "spin", k)
    name = rf"$\partial {NAMES[output]}/\partial {NAMES[by]}$"
    with style.styled():
        figure = style.empty_figure((style.PAGE, 0.5 * style.PAGE), figsize)
        width, height = figure.get_size_inches().tolist()
        columns: Any = [["size", "plane"], ["phase", "plane"]]
        if width < 2 * style.PANEL_WIDTH:
            columns = [["size"], ["phase"]]
            style.say_dropped(3, 2, (width, height), ("size", "phase", "Nyquist's diagram"))
        panels = figure.subplot_mosaic(columns)
        size = panels["size"]
        phase = panels["phase"]
        size.loglog(waves(k), measured(np.abs(values)), color=style.colour(0))
        phase.semilogx(waves(k), np.degrees(np.unwrap(np.angle(values))), color=style.colour(0))
        if "plane" in panels:
            _draw_plane(panels["plane"], measured, values)
        size.set(ylabel=measured.label("size"), title=name)
        phase.set(xlabel=waves.label("wave number $k$"), ylabel="phase [degrees]")
    return figure


def _draw_plane(plane: Axes, measured: Measure, values: np.ndarray) -> None:
    """Nyquist's diagram."""
    plane.plot(
        measured(values.real), measured(values.imag), "o-", markersize=2, color=style.colour(0)
    )
    plane.axhline(0, color="k", linewidth=0.5)
    plane.axvline(0, color="k", linewidth=0.5)
    plane.set_aspect("equal", "datalim")
    plane.set(xlabel=measured.label("real part"), ylabel=measured.label("imaginary part"))


@checks.named_options()
def plot_growth(
    growth: xr.Dataset,
    *,
    label: str | None = None,
    ax: Axes | None = None,
    figsize: tuple[float, float] | None = None,
) -> Figure:
    """Picture of the growth of corrugation over the wavelength: above zero
    waves grow; with speeds a map of it.

    Parameters
    ----------
    growth : xarray.Dataset
        From `corrugation_growth`.
    label : str, optional
        For the legend; call again with `ax` for others.
    ax : matplotlib Axes, optional
        Where to draw; a new figure if not given.
    figsize : pair of float, optional
        Size of a new figure [inch].

    Raises
    ------
    SceneError
        For an `ax` or a size that is none.
    """
    with style.panel(ax, figsize, (1.3 * style.COLUMN, style.COLUMN)) as (figure, ax):
        unit = growth.attrs.get("length", "")
        x_label = "wavelength"
        y_label = "growth by depth worn off"
        if unit:
            x_label += f" [{unit}]"
            y_label += f" [1/{unit}]"
        ax.set(xscale="log", xlabel=x_label, ylabel=y_label)
        style.plain_log_ticks(ax)
        x = growth.wavelength
        values = growth.growth
        if values.ndim > 1:
            # colours for growth, or for decay where nothing grows
            most = float(values.max())
            if most <= 0:
                most = float(abs(values).max())
            image = ax.pcolormesh(x, growth.speed, values.T, cmap="RdBu_r", vmin=-most, vmax=most)
            style.colour_bar(ax, image, ax.get_ylabel())
            ax.set_ylabel("speed")
        else:
            ax.plot(x, values, "o-", color=style.colour(len(ax.lines)), markersize=3, label=label)
            ax.axhline(0, color="k", linewidth=0.5, zorder=0)
        style.legend_below(ax)
    return figure
