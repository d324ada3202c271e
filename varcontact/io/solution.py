"""Solutions as datasets and netCDF files."""

from __future__ import annotations

import hashlib
import io
import json
from collections.abc import Container, Mapping
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from varcontact import checks
from varcontact.discrete.certificate import LEVELS, Certificate, ForceBounds
from varcontact.discrete.state import means
from varcontact.discrete.stick_slip import EXTERIOR, PLASTIC, SLIP, STICK
from varcontact.errors import OutputError
from varcontact.io.export import EXPORTS
from varcontact.io.quantities import CARRIED, EARLIER, FIELDS, OPTIONAL
from varcontact.io.scene_toml import scene_from, scene_to
from varcontact.results.error_estimate import ErrorEstimate
from varcontact.results.history import History
from varcontact.results.plan import Plan
from varcontact.results.report import plain
from varcontact.results.solution import Solution
from varcontact.scene.friction import BRANCHES
from varcontact.scene.grid import Grid
from varcontact.scene.scene import Scene
from varcontact.scene.units import IN_WORDS
from varcontact.solvers.interface import Calls
from varcontact.system.files import (
    begins_with,
    check_regular,
    check_replaceable,
    reading,
    write_whole,
)
from varcontact.system.process import need

if TYPE_CHECKING:
    import xarray as xr

FORMAT = "varcontact solution 2"
EARLIER_FORMAT = "varcontact solution 1"
"""Earlier format, with plastic displacement and yield stress in one field; it can only be read."""
AS_STORED = "the certificate is as stored in the file, not measured again"

CORRECTED = "traction_on_parts"
"""Field by which solutions are recognised that earlier versions corrected towards the continuum
(``refine``)."""

DERIVED = ("traction_bound", "normal_force", "force", "moment")
"""Fields that are not read, as they follow from others."""
READ = [name for name in {**FIELDS, **OPTIONAL, **CARRIED, **EARLIER} if name not in DERIVED]
AS_IT_IS = ("converged", "iterations", "status", "timing")
"""Entries of the record that a solution takes over unchanged."""
SIZES = {"component": 2, "rigid": 3, "axis": 3, "flow": 3}
MAY_BE_UNKNOWN = ("power_density", "approach", "creepage")
ROUNDED = 1e-9
"""Relative difference between pressures as stored and as summed that counts as rounding."""


def dataset(sol: Solution) -> xr.Dataset:
    """A solution as an xarray dataset, see `Solution.to_xarray`.

    The attribute ``units`` of each variable is in the scene's units, or in words like
    "force/length^2" where the scene names none; forces of a line contact are per unit length.
    """
    import xarray as xr

    shift = sol.motion is not None and sol.motion.rolls == 0
    variables, places, record = variables_of(sol, FIELDS, shift)
    labels = {
        "component": ["x", "y"],
        "rigid": ["ux", "uy", "rotation"] if shift else ["vx", "vy", "spin"],
    }
    if sol.temperature is not None:
        words = {"long_name": "temperature of the surfaces of body 1 and body 2"}
        variables["temperature"] = ("body", "y", "x"), sol.temperature, words
        labels["body"] = ["upper", "lower"]
    coordinates = {"x": places["x"], "y": places["y"], **labels} | places
    rest = {
        "scene": scene_to(sol.scene),
        "grid": vars(sol.grid),
        "plan": sol.plan.record(),
        **record,
    }
    variables["record"] = (
        (),
        json.dumps(rest),
        {"long_name": "scene, plan, certificate and timing as JSON"},
    )
    return xr.Dataset(variables, coordinates, {"format": FORMAT})


def variables_of(
    sol: Solution, fields: Mapping[str, Any], shift: bool
) -> tuple[dict[str, Any], dict[str, Any], dict[str, Any]]:
    """Variables for some of the `FIELDS`, including those on parts of elements; their coordinates;
    and the record of the solution.
    """
    units = sol.scene.units or IN_WORDS
    line = sol.scene.line
    variables: dict[str, Any] = {}
    values_of = {name: getattr(sol, name) for name in {**fields, **OPTIONAL}} | sol.carried
    for name, (dims, quantity, words) in {**fields, **OPTIONAL, **CARRIED}.items():
        values = values_of.get(name)
        if values is not None:
            said = {"units": units.of(quantity, line, shift), "long_name": words}
            variables[name] = dims, np.asarray(values), said
    grids = {"": sol.grid}
    if sol.pressure_on_parts is not None:
        grids["_parts"], _ = sol.contact
    memory = sol.carried.get("memory")
    if memory is not None:
        ahead = (memory.shape[-1] - sol.grid.nx) // 2
        grids["_around"] = sol.grid.window(-ahead, sol.grid.nx + ahead, -1, sol.grid.rows + 1)
    places: dict[str, Any] = {
        axis + parts: (
            axis + parts,
            getattr(grid, axis),
            {"units": units.of("length"), "long_name": words},
        )
        for parts, grid in grids.items()
        for axis, words in (("x", "rolling direction"), ("y", "lateral direction"))
    }
    record = {
        "certificate": sol.certificate.plain(),
        **{name: getattr(sol, name) for name in (*AS_IT_IS, "passes", "branch")},
        "warnings": list(sol.warnings),
        "solved_by": sol.solved_by,
        "calls": plain(sol.calls),
        "error_estimate": None if sol.error_estimate is None else sol.error_estimate.plain(),
    }
    return variables, places, record


def save(sol: Solution, path: str | Path, field: str = "path", overwrite: bool = False) -> None:
    """Write a solution to a file in the format of its ending, atomically, see `Solution.save`."""
    path = checks.file_name(field, path)
    check_solution_file(field, path, overwrite)
    write_whole(field, path, FORMATS[path.suffix.lower()][0](sol))


def check_solution_file(field: str, path: Path, overwrite: bool) -> None:
    """Refuse a file to which no solution may be written, see `save`."""
    _, ours = FORMATS.get(path.suffix.lower(), (None, b""))
    check_replaceable(field, path, FORMATS, "solution", ours, overwrite)


def read(path: str | Path) -> Solution | History:
    """Solution or history as stored in its file; impossible fields are refused."""
    from varcontact.io.history import Stored
    from varcontact.io.records import MAGIC

    path = checks.file_name("path", path)
    with reading(path, "cannot be read"):
        check_regular("path", path)
        content = None if begins_with(path, MAGIC) else path.read_bytes()
    if content is None:
        stored = Stored.read(path)
        return History(stored.scene, stored.grid, stored, stored.settings)
    return replace(solution_from_bytes(path, content), note=AS_STORED)


def solution_to_bytes(sol: Solution) -> bytes:
    """A solution's file, in memory."""
    return with_checksum(netcdf_to_bytes(dataset(sol)))


def netcdf_to_bytes(data: xr.Dataset) -> bytes:
    """A dataset as a netCDF-4 file, in memory: on a full disk HDF5 itself would bring the
    interpreter down.

    Without xarray's lock: beside a client of dask, it would ask the cluster for one of that file.
    """
    from xarray.backends import H5NetCDFStore

    buffer = io.BytesIO()
    file = H5NetCDFStore.open(buffer, "w", lock=False)
    data.dump_to_store(file)
    file.close()
    return buffer.getvalue()


def solution_from_bytes(path: Path, content: bytes) -> Solution:
    """A solution from its file in memory, which was found in the file at `path`."""
    import h5py

    with reading(path):
        whole = without_checksum(content)
    with reading(path, "cannot be read as netCDF"), h5py.File(io.BytesIO(whole)) as file:
        form = file.attrs.get("format")
        if form not in (FORMAT, FORMAT.encode(), EARLIER_FORMAT, EARLIER_FORMAT.encode()):
            raise OutputError("path", path, f"is not a {FORMAT!r} file")
        refuse_corrected(path, file)
        stored = [file[name] for name in READ if name in file]
        size = 2.0 * sum(field.size * field.dtype.itemsize for field in stored)
        need("what the file declares", size, "it is damaged, or another program's")
        with reading(path):
            record = json.loads(file["record"][()])
            found = {field.name[1:]: field[()] for field in stored}
    with reading(path):
        scene = scene_from(record["scene"])
        grid = Grid(**record["grid"])
        plan = Plan.of_record(record["plan"])
        return assembled(scene, grid, plan, found, record)


def refuse_corrected(path: Path, variables: Container[Any]) -> None:
    """Refuse the variables of a solution, or of a history, that an earlier version corrected
    towards the continuum.
    """
    if CORRECTED in variables:
        reason = (
            'is of an earlier version, by refine = "continuum": '
            "solve its scene with accuracy in place of a grid, "
            "or read its fields by xarray.open_dataset"
        )
        raise OutputError("path", path, reason)


def assembled(
    scene: Scene, grid: Grid, plan: Plan, found: dict[str, Any], record: dict[str, Any]
) -> Solution:
    """Solution from the variables of `READ` in a file and its record; ValueError for impossible
    ones.
    """
    _check_fields(grid, found)  # `load` certifies the values
    certificate: dict[str, Any] = {"level": "full", "pressure_part": [np.nan] * 3}
    certificate |= record["certificate"]
    bounds = [np.array(certificate.pop(name)) for name in ("force_bound", "pressure_part")]
    carried = _carried(found)
    fields = {name: values for name, values in found.items() if name in {**FIELDS, **OPTIONAL}}
    fields |= {
        "carried": carried,
        "approach": float(found["approach"]),
        "creepage": tuple(map(float, found["creepage"])),
    }
    # files of earlier versions have none
    fields.setdefault("power_density", np.full(grid.shape, np.nan))
    estimate = record.get("error_estimate")
    if estimate is not None:
        estimate = ErrorEstimate.from_plain(estimate)
    sol = Solution(
        scene=scene,
        grid=grid,
        plan=plan,
        **fields,
        certificate=Certificate(**certificate, bounds=ForceBounds(*bounds)),
        **{name: record[name] for name in AS_IT_IS},
        passes=tuple((float(change), float(residual)) for change, residual in record["passes"]),
        branch=str(record.get("branch", "")),
        warnings=tuple(str(warning) for warning in record.get("warnings", [])),
        # absent in files written before these were counted
        solved_by=dict(record.get("solved_by", {})),
        calls={
            problem: {name: Calls(**each) for name, each in solvers.items()}
            for problem, solvers in record.get("calls", {}).items()
        },
        error_estimate=estimate,
    )
    check_entries(sol)
    return sol


def _carried(found: dict[str, Any]) -> dict[str, np.ndarray]:
    """The quantities that particles carry, also from a file of an earlier version."""
    carried = {name: found[name] for name in CARRIED if name in found}
    if "plastic" in found:
        carried["plastic_displacement"] = found["plastic"][:2]
        carried["yield_stress"] = found["plastic"][2]
    return carried


def _check_fields(grid: Grid, fields: dict[str, Any]) -> None:
    """Refuse fields that are not of numbers on the grid, or on equal parts of its elements."""
    sizes = SIZES | {"y": grid.rows, "x": grid.nx}
    for name, values in fields.items():
        dims = EARLIER[name] if name in EARLIER else (FIELDS | OPTIONAL | CARRIED)[name][0]
        # the size of parts is that of the first field on them
        shape = tuple(
            sizes.setdefault(dim, size) for dim, size in zip(dims, values.shape, strict=True)
        )
        if values.shape != shape or values.dtype.kind not in "iuf":
            raise ValueError(f"{name} that is not of numbers on the grid")
        numbers = values[~np.isnan(values)] if name in MAY_BE_UNKNOWN else values
        if not np.all(np.abs(numbers) <= checks.LARGE**2):
            raise ValueError("numbers beyond those that can be computed with, or not finite")
    if sizes.get("y_parts", 0) % grid.rows or sizes.get("x_parts", 0) % grid.nx:
        raise ValueError("fields that are not on parts of the elements")


def check_entries(sol: Solution) -> None:
    """Refuse entries that no solution has."""
    _check_states(sol)
    _check_pressure_on_parts(sol)
    _check_rigid_motion(sol)
    _check_statistics(sol)


def _check_states(sol: Solution) -> None:
    states = np.isin(sol.state, (EXTERIOR, STICK, SLIP, PLASTIC))
    if not states.all() or np.any((sol.state != EXTERIOR) != (sol.pressure > 0)):
        raise ValueError(
            "a state that is not exterior (0) without pressure, and stick (1) or slip (2) under it"
        )


def _check_pressure_on_parts(sol: Solution) -> None:
    parts = sol.pressure_on_parts
    on_elements = sol.pressure
    if parts is not None:
        rows, columns = parts.shape
        ny, nx = sol.grid.shape
        on_elements = means(parts, (rows // ny, columns // nx))
    on_parts = sol.plan.cells(sol.scene) != (1, 1)
    rounding = ROUNDED * sol.pressure.max()
    if (parts is not None) != on_parts or np.any(np.abs(on_elements - sol.pressure) > rounding):
        raise ValueError(
            "a pressure on parts of the elements that is missing, "
            "or has other means than the elements"
        )


def _check_rigid_motion(sol: Solution) -> None:
    scene = sol.scene
    if not scene.approach_undetermined and np.isnan(sol.approach):
        raise ValueError("an approach that is not finite")
    undetermined = scene.shift_undetermined or scene.frictionless or not sol.pressure.any()
    if sol.motion is not None and not undetermined and np.isnan(sol.creepage).any():
        raise ValueError("creepages that are not finite")


def _check_statistics(sol: Solution) -> None:
    """Certificate, times, iterations and branch."""
    entries = sol.certificate.plain()
    level = entries.pop("level")
    values = [np.ravel(value) for value in entries.values()]
    numbers = np.concatenate([*values, [*sol.timing.values(), *sol.iterations.values()]])
    if level not in LEVELS or numbers.dtype.kind not in "iuf" or np.any(numbers < 0):
        raise ValueError(
            "a certificate, times or iterations that are not numbers, zero or positive"
        )
    if "total" not in sol.timing:
        raise ValueError("no total time")
    if not isinstance(sol.converged, bool):
        raise ValueError("converged that is neither true nor false")
    if sol.branch not in ("", *BRANCHES):
        raise ValueError("a branch that there is not")


MARK = b"\nvarcontact sha256 "
"""Marker between a file's bytes and their checksum, where netCDF and HDF5 do not read: HDF5 has no
checksum over the whole file."""


def with_checksum(content: bytes) -> bytes:
    """The bytes of a file with their checksum behind them."""
    return content + MARK + hashlib.sha256(content).hexdigest().encode()


def without_checksum(content: bytes) -> bytes:
    """Bytes of a file without their checksum, after checking it; unchanged if there is none.

    A file that another program has written anew has none.
    """
    own, mark, _ = content.rpartition(MARK)
    if mark and with_checksum(own) != content:
        raise ValueError("its bytes are not those that were written")
    return own if mark else content


FORMATS = {".nc": (solution_to_bytes, rb"\x89HDF.*varcontact solution "), **EXPORTS}
"""File formats by ending: the function that makes the bytes of a solution, and the pattern of how
they begin."""
