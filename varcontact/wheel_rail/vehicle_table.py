"""Tables of contacts in the columns that vehicle codes read."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np

from varcontact import checks
from varcontact.errors import SceneError
from varcontact.system.files import check_replaceable, write_whole

OF_SIDES = {
    "r": ("rolling_radius", "mm", 1.0),
    "gamma": ("angle", "rad", -1.0),
    "y_rail": ("on_rail", "mm", 1.0),
    "y_wheel": ("on_wheel", "mm", 1.0),
    "curvature_rail": ("curvature_rail", "1/mm", 1.0),
    "curvature_wheel": ("curvature_wheel", "1/mm", 1.0),
    "a": ("a", "mm", 1.0),
    "b": ("b", "mm", 1.0),
}
"""Columns of either side: the variable of the table, its unit, and its sign. The angle is positive
where the flange's side is lower, the same on both sides."""


def save_columns(table: Any, path: str | Path, yaw: float, overwrite: bool) -> None:
    """See `GeometryTable.save_columns`."""
    import pandas as pd

    file = checks.file_name("path", path)
    angle = checks.number("yaw", yaw)
    nodes = np.flatnonzero(np.abs(table.yaw - angle) < 1e-12)
    if nodes.size == 0:
        raise SceneError("yaw", yaw, f"a node of the table: {', '.join(map(str, table.yaw))}")
    node = int(nodes[0])
    data = table.to_xarray()
    # the left wheel is the right one's mirror image, at the opposite position
    at_side = {"r": data.isel(yaw=node), "l": data.isel(yaw=-1 - node, y=slice(None, None, -1))}
    columns = {"y [mm]": table.y}
    for side, each in at_side.items():
        largest = each["FN"].fillna(-1.0).argmax("patch")
        for name, (variable, unit, sign) in OF_SIDES.items():
            columns[f"{name}_{side} [{unit}]"] = sign * each[variable].isel(patch=largest).values
        columns[f"patches_{side}"] = each["count"].values
    columns["delta_r [mm]"] = columns["r_r [mm]"] - columns["r_l [mm]"]
    columns["conicity"] = data["conicity"].values
    frame = pd.DataFrame(columns)
    head = re.escape(",".join(frame.columns).encode())
    check_replaceable("path", file, (".csv",), "table for vehicle codes", head, overwrite)
    write_whole("path", file, frame.to_csv(index=False).encode())
