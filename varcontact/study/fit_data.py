"""Fitted creep curves as datasets and pictures."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from varcontact.io.labelled import variable
from varcontact.plotting import style
from varcontact.plotting.studies import CREEPAGES
from varcontact.results.error_estimate import with_bar
from varcontact.scene.units import IN_WORDS

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure


def fit_dataset(fit: Any) -> xr.Dataset:
    """See `CreepCurveFit.to_xarray`."""
    import xarray as xr

    names = list(fit.values)
    units = fit.scene.units or IN_WORDS
    force = units.of("force", fit.scene.line)
    variables: dict[str, Any] = {
        "value": variable("parameter", list(fit.values.values()), "1", "fitted value"),
        "error": variable("parameter", list(fit.errors.values()), "1", "standard error"),
        "correlation": variable(
            ("parameter", "other"), fit.correlation, "1", "correlation of the errors"
        ),
        "on_bound": variable(
            "parameter", [name in fit.on_bounds for name in names], "1", "on a bound of its range"
        ),
        "rms": variable((), fit.rms, force, "root mean square of the residuals"),
    }
    for name, forces in fit.measured.items():
        variables[f"measured_{name}"] = variable("point", forces, force, f"measured {name}")
        fitted = fit.curve[name].to_numpy()[0]
        variables[f"fitted_{name}"] = variable("point", fitted, force, f"fitted {name}")
    coordinates: dict[str, Any] = {"parameter": names, "other": names}
    spin = units.of("spin")
    for name, unit in (("vx", "1"), ("vy", "1"), ("spin", spin)):
        coordinates[name] = variable("point", fit.curve[name], unit, f"creepage {name}")
    return xr.Dataset(variables, coordinates)


def plot_fit(fit: Any, figsize: tuple[float, float] | None = None) -> Figure:
    """Measured forces with bars of their standard error, and the fitted curve, over the creepage
    that changes most; with the fitted values as the title.
    """
    creepages = {name: fit.curve[name].to_numpy() for name in ("vx", "vy", "spin")}
    name = max(creepages, key=lambda each: float(np.ptp(creepages[each])))
    x = creepages[name]
    order = np.argsort(x)
    with style.styled():
        figure, (ax,) = style.new_figure(1, 1, (style.COLUMN * 1.15, 2.9), figsize)
        for k, (force, measured) in enumerate(fit.measured.items()):
            own = style.look(k)
            fitted = fit.curve[force].to_numpy()[0]
            ax.errorbar(
                x,
                measured,
                fit.sigma,
                fmt=own["marker"],
                color=own["color"],
                capsize=2,
                label=f"{force}, measured",
            )
            ax.plot(x[order], fitted[order], color=own["color"], label=f"{force}, fitted")
        values = [with_bar(value, fit.errors[each]) for each, value in fit.values.items()]
        lines = [f"{each} = {text}" for each, text in zip(fit.values, values, strict=True)]
        units = fit.scene.units or IN_WORDS
        ax.set(
            xlabel=CREEPAGES[name][0],
            ylabel=f"tangential force [{units.of('force', fit.scene.line)}]",
            title="\n".join(lines),
        )
        style.legend_below(ax, columns=2)
        figure.draw_without_rendering()
    return figure
