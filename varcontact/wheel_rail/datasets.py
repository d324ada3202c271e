"""Wheels, wheel sets and wear as datasets with units."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from varcontact.io.labelled import variable
from varcontact.wheel_rail.quantities import (
    axle_values,
    quantities_of,
    wheel_values,
)
from varcontact.wheel_rail.wear_laws import Archard, ArchardMap

if TYPE_CHECKING:
    import xarray as xr


def wheels_dataset(
    found: Any,
    archard: Archard | ArchardMap | None,
    yield_in_shear: float | None,
    of_sets: bool,
) -> xr.Dataset:
    """Quantities of a wheel over its patches, or of a wheel set over side and patch."""
    import xarray as xr

    rows = [wheel.quantities(archard, yield_in_shear) for wheel in found.wheels]
    sides = [wheel.case.side for wheel in found.wheels]
    most = max(len(each) for each in rows)
    variables: dict[str, Any] = {}
    axle = axle_values(found, of_sets)
    for quantity in quantities_of("axle", of_sets):
        words = "of the axle"
        variables[quantity.name] = variable((), axle[quantity.name], quantity.unit, words)
    wheel = [wheel_values(found, side, of_sets) for side in sides]
    for quantity in quantities_of("wheel", of_sets):
        of_sides = [each[quantity.name] for each in wheel]
        variables[quantity.name] = variable(("side",), of_sides, quantity.unit, "of the wheel")
    for quantity in quantities_of("patch", of_sets):
        values = np.full((len(sides), most), np.nan)
        for i, patches in enumerate(rows):
            values[i, : len(patches)] = [each[quantity.name] for each in patches]
        dims = ("side", "patch")
        variables[quantity.name] = variable(dims, values, quantity.unit, "of the patch")
    data = xr.Dataset(variables, {"side": sides, "patch": np.arange(1, most + 1)})
    if not of_sets:
        data = data.isel(side=0)
    return data


def wear_dataset(worn: Any) -> xr.Dataset:
    """See `Wear.to_xarray`."""
    import xarray as xr

    count = len(worn.patches)
    names = {
        "t_gamma": ("N", "energy per distance rolled"),
        "t_gamma_without_spin": ("N", "the same without the moment"),
        "area": ("mm2", "area of contact"),
        "t_gamma_by_area": ("N/mm2", "energy per distance rolled and area"),
        "power": ("W", "friction power"),
    }
    law = all(each.archard is not None for each in worn.patches)
    if law:
        names["volume"] = ("mm3/mm", "volume of wear per distance rolled")
    variables: dict[str, Any] = {}
    for name, (unit, words) in names.items():
        values = [getattr(each, name) for each in worn.patches]
        variables[name] = variable(("patch",), values, unit, words)
    # rows of elements, which patches have in different numbers
    rows = [each.solved.solution.grid.y.size for each in worn.patches]
    shape = (count, max(rows))
    places = np.full(shape, np.nan)
    power = np.full(shape, np.nan)
    depth = np.full(shape, np.nan)
    for i, each in enumerate(worn.patches):
        places[i, : rows[i]] = _across(each.solved)
        power[i, : rows[i]] = each.power_by_area.sum(axis=1) * each.solved.solution.grid.sides[0]
        if law:
            depth[i, : rows[i]] = each.depth
    dims = ("patch", "row")
    variables["power_by_width"] = variable(dims, power, "W/mm", "friction power by width")
    if law:
        variables["depth"] = variable(dims, depth, "mm", "depth of wear per passage")
    coordinates = {
        "patch": np.arange(1, count + 1),
        "row": np.arange(max(rows)),
        "y": variable(dims, places, "mm", "row of elements, to the right in the track"),
    }
    return xr.Dataset(variables, coordinates)


def _across(solved: Any) -> np.ndarray:
    """y in the track of the rows of elements of a patch [mm]."""
    lateral, down = solved.rows
    points = solved.frame.globally(np.stack([0.0 * lateral, lateral, down], axis=1))
    return np.asarray(points[:, 1])
