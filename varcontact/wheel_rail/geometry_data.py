"""Tables of contacts as datasets with units."""

from __future__ import annotations

from contextlib import suppress
from typing import TYPE_CHECKING, Any

import numpy as np

from varcontact.errors import NoContact, SceneError
from varcontact.io.labelled import variable
from varcontact.wheel_rail.conicity import equivalent_conicity, rolling_radius_difference
from varcontact.wheel_rail.position import Position
from varcontact.wheel_rail.wheel_on_rail import WheelOnRail

if TYPE_CHECKING:
    import xarray as xr

TABLE = {
    "location_x": ("mm", "contact, forward in the track"),
    "location_y": ("mm", "contact, to the right in the track"),
    "location_z": ("mm", "contact, downwards in the track"),
    "angle": ("rad", "contact angle"),
    "a": ("mm", "semi-axis along the rail"),
    "b": ("mm", "semi-axis across the rail"),
    "FN": ("N", "normal force"),
    "approach": ("mm", "approach"),
    "on_rail": ("mm", "contact in the rail's profile, y"),
    "on_wheel": ("mm", "contact in the wheel's profile, y"),
    "rolling_radius": ("mm", "rolling radius"),
    "curvature_rail": ("1/mm", "curvature of the rail across, convex positive"),
    "curvature_wheel": ("1/mm", "curvature of the wheel across, convex positive"),
}
"""Variables of a table of contacts, with units and words, in the order of its patches."""


def table_dataset(table: Any) -> xr.Dataset:
    """See `GeometryTable.to_xarray`."""
    import xarray as xr

    ny, nyaw, slots = table.patches.shape[:3]
    values = np.full((ny, nyaw, slots, len(TABLE)), np.nan)
    values[..., : table.patches.shape[-1]] = table.patches
    rail = table.track.profile
    wheel = table.wheelset.profile
    for i, j in np.ndindex(ny, nyaw):
        position = Position(y=float(table.y[i]), yaw=float(table.yaw[j]))
        case = WheelOnRail(
            track=table.track, wheelset=table.wheelset, position=position, z=float(table.z[i, j])
        )
        for k in range(table.count[i, j]):
            point = table.patches[i, j, k, :3]
            on_rail = float(table.track.on_rail(point[1:], "right")[0])
            on_wheel, below = case.on_wheel(point, case.body(float(table.z[i, j]))).tolist()
            values[i, j, k, 8:] = [
                on_rail,
                on_wheel,
                table.wheelset.radius + below,
                float(rail.curvature_at(on_rail)),
                float(wheel.curvature_at(on_wheel)),
            ]
    # beyond the number of patches there is nothing
    values[np.arange(slots) >= table.count[..., None]] = np.nan
    dims = ("y", "yaw", "patch")
    variables: dict[str, Any] = {
        name: variable(dims, values[..., k], *words)
        for k, (name, words) in enumerate(TABLE.items())
    }
    variables["z"] = variable(("y", "yaw"), table.z, "mm", "height of the axle, downwards")
    variables["count"] = variable(("y", "yaw"), table.count, "1", "patches of the right wheel")
    difference, conicity = _conicity(table)
    words = "rolling radius of the right wheel less that of the left, without yaw"
    variables["radius_difference"] = variable(("y",), difference, "mm", words)
    words = "equivalent conicity for this amplitude"
    variables["conicity"] = variable(("y",), conicity, "1", words)
    coordinates = {
        "y": variable("y", table.y, "mm", "lateral displacement of the wheel set"),
        "yaw": variable("yaw", table.yaw, "rad", "yaw of the wheel set"),
        "patch": np.arange(1, slots + 1),
    }
    return xr.Dataset(variables, coordinates)


def _conicity(table: Any) -> tuple[np.ndarray, np.ndarray]:
    """Rolling radius difference and equivalent conicity over y; NaN from where wheels touch at the
    end of a profile, and in the middle.
    """
    difference = np.full(table.y.size, np.nan)
    conicity = np.full(table.y.size, np.nan)
    for i, y in enumerate(table.y.tolist()):
        with suppress(SceneError, NoContact):
            difference[i] = rolling_radius_difference(table.track, table.wheelset, y)
    # in one call, which computes the difference up to the largest amplitude
    reached = np.isfinite(difference) & (table.y != 0)
    with suppress(SceneError, NoContact):
        amplitudes = np.abs(table.y[reached])
        conicity[reached] = equivalent_conicity(table.track, table.wheelset, amplitudes)
    return difference, conicity
