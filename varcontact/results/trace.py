"""Traces of solvers as datasets."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from varcontact.scene.units import Units
from varcontact.solvers.trace import FIGURES

if TYPE_CHECKING:
    import xarray as xr

WHERE = ("problem", "solver", "call", "iteration", "second")
ENERGIES = ("gap", "objective")
MEANINGS = {
    "problem": "problem: normal, tangential or both",
    "solver": "solver called",
    "call": "number of the call",
    "iteration": "iterate of the call",
    "second": "time since the solve began, without measuring",
    "residual": "residual of the natural map",
    "gap": "duality gap",
    "objective": "objective of the program",
    "changes": "elements whose area changed since the iterate before",
}


def trace_dataset(records: list[dict[str, Any]], energy: float, units: Units | None) -> xr.Dataset:
    """Records of a trace over the dimension "iterate", with energies in the scene's units."""
    import xarray as xr

    names = {"problem": str, "solver": str, "call": int, "iteration": int}
    data: dict[str, Any] = {}
    for name in (*WHERE, *FIGURES):
        values: Any = np.array(
            [record.get(name, np.nan) for record in records], names.get(name, float)
        )
        if name in ENERGIES:
            values = values * energy
        attributes = {"long_name": MEANINGS[name]}
        if name == "second":
            attributes["units"] = "s"
        if name in ENERGIES and units is not None:
            attributes["units"] = units.of("moment")
        data[name] = ("iterate", values, attributes)
    return xr.Dataset(data)
