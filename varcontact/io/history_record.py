"""The bytes of a history's file: classic netCDF, whose records lie one behind the other, a record for each step.

scipy makes them and reads them, and a step is put in its place by `history_file`: no library adds a record safely.
scipy's own mode for that writes the whole file anew for every step (1 ms for the first of 40 x 40 elements, 800 ms for
the four hundredth), and of 20 files whose program was killed 8 could not be read. HDF5 groups lost 4 of 14 such files,
and HDF5 datasets that grow while others read them (SWMR) lost none of 20, but none of these could be added to again.
"""

from __future__ import annotations

import io
import json
from dataclasses import asdict
from typing import Any, cast

import numpy as np

from varcontact.io.scene_toml import scene_to
from varcontact.io.solution import FIELD_OF_LAWS, FIELDS, record_of, solution_to_bytes, units_of
from varcontact.io.subgrid_fields import pressure_to, refinement_to
from varcontact.results.plan import Plan
from varcontact.results.solution import Solution
from varcontact.scene.motion import Transient
from varcontact.scene.scene import Scene

FORMAT = "varcontact history 1"
MAGIC = b"CDF\x02"
COUNT_AT = 4
"""Where a classic netCDF file has the number of its records: four bytes, the highest first."""
RECORD, RECORD_OF_PASSES, LAST_PASSES, LONGEST_WORD = 2048, 8192, 100, 200
"""Characters for what a step says of how it was found, without and with passes, of which the last are kept, or an
estimate of its error; and for a solver's word."""

SERIES = {**FIELDS, "friction_work": ((), "force", "work lost by friction: by distance rolled, in a shift as it is")}
"""What the file has of each step: dimensions, quantity, and what it is."""


def first_step(scene: Scene, plan: Plan, settings: dict[str, Any], sol: Solution) -> bytes:
    """The file with the first step: it says where that begins, for those that follow."""
    content, size = _file_of(scene, plan, settings, sol, 0)
    return _file_of(scene, plan, settings, sol, len(content) - size)[0]


def next_step(scene: Scene, plan: Plan, settings: dict[str, Any], sol: Solution) -> bytes:
    """What a step adds to the file."""
    content, size = _file_of(scene, plan, settings, sol, None)
    return content[-size:]


def count_of(steps: int) -> bytes:
    """A number of `steps`, as it stands at `COUNT_AT`."""
    return steps.to_bytes(4, "big")


def _file_of(scene: Scene, plan: Plan, settings: dict[str, Any], sol: Solution, begin: int | None) -> tuple[bytes, int]:
    """A file of one step, and the bytes of that step at its end; without `begin` only these count."""
    from scipy.io import netcdf_file

    buffer, units, start = io.BytesIO(), units_of(scene), cast(Transient, scene.motion).start
    file = netcdf_file(buffer, "w", version=2)
    file.format, file.first_step = FORMAT, f"{begin or 0:012d}"
    file.scene, file.grid = json.dumps(scene_to(scene)), json.dumps(vars(sol.grid))
    file.plan, file.settings = json.dumps(asdict(plan)), json.dumps(settings)
    longer = plan.loops or scene.under_law or sol.error_estimate is not None
    length = RECORD_OF_PASSES if longer else RECORD
    sizes = {
        "component": 2,
        "y": sol.grid.rows,
        "x": sol.grid.nx,
        "rigid": 3,
        "letters": 8,
        "characters": length,
    }
    record, parts = record_of(sol), dict[str, Any]()
    places: dict[str, Any] = {"x": ("x", sol.grid.x, {}), "y": ("y", sol.grid.y, {})}
    if sol.refinement is not None:
        parts, places_of_parts, record["refinement"] = refinement_to(sol.refinement, units, scene.line, shift=False)
        (sizes["y_parts"], sizes["x_parts"]), places = sol.refinement.grid.shape, places | places_of_parts
    if sol.pressure_on_parts is not None:
        parts, places_of_parts, divided = pressure_to(sol, units)
        (sizes["y_parts"], sizes["x_parts"]), places = divided.shape, places | places_of_parts
    file.createDimension("step", None)
    for name, size in sizes.items():
        file.createDimension(name, size)
    for name, (_, values, _) in places.items():
        variable = file.createVariable(name, "d", (name,))
        variable[:], variable.units = values, units.of("length")
    for name, labels in {"component": ("x", "y"), "rigid": ("vx", "vy", "spin")}.items():
        variable = file.createVariable(name, "c", (name, "letters"))
        variable[:] = np.array([list(label.ljust(8, "\0")) for label in labels], dtype="S1")
    if start is not None and begin is not None:
        content = np.frombuffer(solution_to_bytes(cast(Solution, start)), dtype=np.int8)
        file.createDimension("bytes", content.size)
        file.createVariable("start", "b", ("bytes",))[:] = content
    for name, (dims, quantity, words) in (SERIES | (FIELD_OF_LAWS if sol.weakening is not None else {})).items():
        values = np.asarray(getattr(sol, name))
        variable = file.createVariable(name, "b" if values.dtype == np.int8 else "d", ("step", *dims))
        variable[0], variable.units, variable.long_name = values, units.of(quantity, scene.line), words
    for name, (dims, values, said) in parts.items():
        variable = file.createVariable(name, "d", ("step", *dims))
        variable[0], variable.units, variable.long_name = values, said["units"], said["long_name"]
    record["status"] = {name: word[:LONGEST_WORD] for name, word in sol.status.items()}
    record["passes"] = sol.passes[-LAST_PASSES:]
    text = json.dumps(record).ljust(length)
    variable = file.createVariable("record", "c", ("step", "characters"))
    variable[0] = np.frombuffer(text.encode(), dtype="S1")
    file.flush()
    written = buffer.getvalue()
    buffer.close()  # else the file writes itself once more when it goes, where Ctrl-C would be lost
    return written, int(file._recsize)
