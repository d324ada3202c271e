"""Solutions as datasets and netCDF files."""

from __future__ import annotations

import hashlib
import io
import json
import sys
from collections.abc import Mapping
from dataclasses import asdict, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from varcontact import checks
from varcontact.discrete.certificate import LEVELS, Certificate, ForceBounds
from varcontact.discrete.stick_slip import EXTERIOR, PLASTIC, SLIP, STICK
from varcontact.errors import OutputError
from varcontact.io.export import EXPORTS
from varcontact.io.scene_toml import scene_from, scene_to
from varcontact.io.subgrid_fields import ON_PARTS, PRESSURE, refinement_from, refinement_to, with_pressure
from varcontact.results.error_estimate import ErrorEstimate
from varcontact.results.history import History
from varcontact.results.plan import Plan
from varcontact.results.report import plain_calls
from varcontact.results.solution import Solution
from varcontact.scene.friction import BRANCHES
from varcontact.scene.grid import Grid
from varcontact.scene.motion import TimeStep
from varcontact.scene.scene import Scene
from varcontact.scene.units import Units
from varcontact.solvers.interface import Calls
from varcontact.system.files import begins_with, check_replaceable, first_line, reading, regular, write_whole
from varcontact.system.process import need

if TYPE_CHECKING:
    import xarray as xr

FORMAT = "varcontact solution 1"
AS_STORED = "the certificate is as stored in the file, not measured again"

FIELDS = {
    "pressure": (("y", "x"), "pressure", "normal traction, compression positive"),
    "traction": (("component", "y", "x"), "pressure", "tangential traction on body 1"),
    "slip": (("component", "y", "x"), "slip", "relative slip of body 1 over body 2"),
    "power_density": (("y", "x"), "power density", "work lost by friction by area, by distance rolled"),
    "distance": (("y", "x"), "length", "deformed distance"),
    "state": (("y", "x"), "1", "0 exterior, 1 stick, 2 slip, 3 plastic"),
    "traction_bound": (("y", "x"), "pressure", "friction coefficient times pressure"),
    "normal_force": ((), "force", "total compressive force"),
    "force": (("component",), "force", "total tangential force on body 1"),
    "moment": ((), "moment", "twisting moment on body 1 about the origin"),
    "approach": ((), "length", "approach of the bodies"),
    "creepage": (("rigid",), "1", "longitudinal, lateral and spin creepage (of a shift: ux, uy, rotation)"),
}
WEAKENING = "weakening"
MEMORY = "memory"
PLASTIC_STATE = "plastic"
AT_TIMES = {
    WEAKENING: (("y", "x"), "1", "part of static - kinetic friction that particles have lost by slip"),
    MEMORY: (("relaxation", "axis", "y_around", "x_around"), "pressure", "tractions that viscoelastic bodies remember"),
    PLASTIC_STATE: (("flow", "y", "x"), "1", "third body: plastic displacement [length], yield stress [pressure]"),
}
"""Fields of histories: under laws of friction, and of viscoelastic bodies; of a third body that yields."""

ON_ELEMENTS = ("pressure", "traction", "slip", "power_density", "distance", "state", *AT_TIMES)
"""Fields that are read back; files of earlier versions have no power density."""
READ = (*ON_ELEMENTS, *ON_PARTS, PRESSURE, "approach", "creepage")


def dataset(sol: Solution) -> xr.Dataset:
    """A solution as an xarray dataset, see `Solution.to_xarray`.

    The attribute ``units`` of each variable is in the scene's units, or in words like "force/length^2" where the
    scene names none; forces of a line contact are per unit length.
    """
    import xarray as xr

    shift = sol.motion is not None and sol.motion.rolls == 0
    variables, places, record = variables_of(sol, FIELDS, shift)
    labels = {"component": ["x", "y"], "rigid": ["ux", "uy", "rotation"] if shift else ["vx", "vy", "spin"]}
    if sol.temperature is not None:
        words = {"long_name": "temperature of the surfaces of body 1 and body 2"}
        variables["temperature"] = ("body", "y", "x"), sol.temperature, words
        labels["body"] = ["upper", "lower"]
    coordinates = {"x": places["x"], "y": places["y"], **labels} | places
    rest = {"scene": scene_to(sol.scene), "grid": vars(sol.grid), "plan": asdict(sol.plan), **record}
    variables["record"] = ((), json.dumps(rest), {"long_name": "scene, plan, certificate and timing as JSON"})
    return xr.Dataset(variables, coordinates, {"format": FORMAT})


def variables_of(
    sol: Solution, fields: Mapping[str, Any], shift: bool
) -> tuple[dict[str, Any], dict[str, Any], dict[str, Any]]:
    """Some fields, as `FIELDS` has them, with those on parts of the elements; their places; and `record_of`."""
    units, line, record = units_of(sol.scene), sol.scene.line, record_of(sol)
    grids, found = {"": sol.grid}, dict[str, tuple[tuple[str, ...], np.ndarray, str, str]]()
    added = {name: entry for name, entry in AT_TIMES.items() if getattr(sol, name) is not None}
    for name, (dims, quantity, words) in {**fields, **added}.items():
        found[name] = dims, np.asarray(getattr(sol, name)), quantity, words
    if sol.refinement is not None:
        refined, record["refinement"] = refinement_to(sol.refinement)
        found, grids["_parts"] = found | refined, sol.refinement.grid
    if sol.pressure_on_parts is not None:
        words = "normal traction, on parts of elements"
        found[PRESSURE] = ("y_parts", "x_parts"), sol.pressure_on_parts, "pressure", words
        grids["_parts"], _ = sol.contact
    if sol.memory is not None:
        ahead = (sol.memory.shape[-1] - sol.grid.nx) // 2
        grids["_around"] = sol.grid.window(-ahead, sol.grid.nx + ahead, -1, sol.grid.rows + 1)
    variables: dict[str, Any] = {
        name: (dims, values, {"units": units.of(quantity, line, shift), "long_name": words})
        for name, (dims, values, quantity, words) in found.items()
    }
    places: dict[str, Any] = {
        axis + parts: (axis + parts, getattr(grid, axis), {"units": units.of("length"), "long_name": words})
        for parts, grid in grids.items()
        for axis, words in (("x", "rolling direction"), ("y", "lateral direction"))
    }
    return variables, places, record


def units_of(scene: Scene) -> Units:
    """A scene's units, or words in their place."""
    return scene.units or Units(length="length", force="force")


def record_of(sol: Solution) -> dict[str, Any]:
    """How a solution was found: its plan, iterations, times and certificate, as plain data."""
    return {
        "certificate": sol.certificate.plain(),
        "converged": sol.converged,
        "iterations": sol.iterations,
        "status": sol.status,
        "timing": sol.timing,
        "passes": sol.passes,
        "branch": sol.branch,
        "warnings": list(sol.warnings),
        "solved_by": sol.solved_by,
        "calls": plain_calls(sol.calls),
        "error_estimate": None if sol.error_estimate is None else sol.error_estimate.plain(),
    }


ENDINGS = (".nc", *EXPORTS)
"""Of the files that a solution can be written to; only the first is read back."""


def save(sol: Solution, path: str | Path, field: str = "path", overwrite: bool = False) -> None:
    """Write a solution to a file in the format of its ending, whole or not at all, see `Solution.save`."""
    path = checks.file_name(field, path)
    check_solution_file(field, path, overwrite)
    export = EXPORTS.get(path.suffix.lower())
    write_whole(field, path, solution_to_bytes(sol) if export is None else export.content(sol))


def check_solution_file(field: str, path: Path, overwrite: bool) -> None:
    """Refuse a file to which no solution may be written, see `save`."""
    export = EXPORTS.get(path.suffix.lower())
    ours = is_solution if export is None else export.ours
    check_replaceable(field, path, ENDINGS, "solution", ours, overwrite)


def is_solution(path: Path) -> bool:
    """Whether the file at `path` says of itself that it holds a solution."""
    import h5py

    try:
        with h5py.File(path) as file:
            return str(file.attrs.get("format", "")).startswith("varcontact solution ")
    except (OSError, ValueError, RuntimeError, UnicodeError):  # whatever else is in the file
        return False


def read(path: str | Path) -> Solution | History:
    """A solution or a history from its file, as it is stored: fields that no solution can have are refused."""
    from varcontact.io.history import load_history
    from varcontact.io.records import MAGIC

    path = checks.file_name("path", path)
    try:
        if not regular(path):
            raise OutputError("path", path, "is not a regular file")
        stored_steps = begins_with(path, MAGIC)
    except OutputError:
        raise
    except OSError as error:
        raise OutputError("path", path, f"cannot be read ({error.strerror or error})") from None
    except ValueError as error:  # a null character in the name
        raise OutputError("path", path, f"cannot be read ({error})") from None
    if stored_steps:
        return load_history(path)
    with reading(path, "cannot be read"):
        content = path.read_bytes()
    return replace(solution_from_bytes(path, content), note=AS_STORED)


def _data(path: str | Path, content: bytes) -> xr.Dataset:
    import xarray as xr

    with reading(path):
        whole = without_checksum(content)
    _check_opens(path, whole)
    with (
        reading(path, "cannot be read as netCDF"),
        xr.open_dataset(io.BytesIO(whole), engine="h5netcdf", phony_dims="sort") as opened,
    ):
        need("what the file declares", 2.0 * opened.nbytes, "it is damaged, or another program's")
        data: xr.Dataset = opened.load()
    if data.attrs.get("format") != FORMAT:
        raise OutputError("path", path, f"is not a {FORMAT!r} file")
    return data


def _check_opens(path: str | Path, content: bytes) -> None:
    """Refuse what h5netcdf cannot open: half made, its file would print a traceback when it is let go of."""
    import h5netcdf

    hook, sys.unraisablehook = sys.unraisablehook, lambda _: None
    try:
        h5netcdf.File(io.BytesIO(content), "r", phony_dims="sort").close()
        return
    except Exception as error:  # h5netcdf lets through what HDF5 raises; kept past the hook, as the file goes with it
        reason = first_line(error)
    finally:
        sys.unraisablehook = hook
    raise OutputError("path", path, f"cannot be read as netCDF ({reason})")


def solution_to_bytes(sol: Solution) -> bytes:
    """A solution's file, in memory."""
    buffer = io.BytesIO()  # on a full disk HDF5 itself would bring the interpreter down
    dataset(sol).to_netcdf(buffer, engine="h5netcdf")
    return with_checksum(buffer.getvalue())


def solution_from_bytes(path: Path, content: bytes) -> Solution:
    """A solution from its file in memory, which was found in the file at `path`."""
    data = _data(path, content)
    with reading(path):
        record = json.loads(str(data["record"].values))
        scene, grid, plan = scene_from(record["scene"]), Grid(**record["grid"]), Plan.of_record(record["plan"])
        return assembled(scene, grid, plan, {name: data[name].values for name in READ if name in data}, record)


def assembled(scene: Scene, grid: Grid, plan: Plan, found: dict[str, Any], record: dict[str, Any]) -> Solution:
    """A solution from the variables of `READ` that a file has, and its record."""
    certificate: dict[str, Any] = {"level": "full", "pressure_part": [np.nan] * 3} | record["certificate"]
    bounds = [np.array(certificate.pop(name)) for name in ("force_bound", "pressure_part")]
    vx, vy, spin = (float(value) for value in found["creepage"])
    fields = {name: found[name] for name in ON_ELEMENTS if name in found}
    fields.setdefault("power_density", np.full(grid.shape, np.nan))
    estimate = record.get("error_estimate")
    sol = Solution(
        scene=scene,
        grid=grid,
        plan=plan,
        **fields,
        approach=float(found["approach"]),
        creepage=(vx, vy, spin),
        certificate=Certificate(**certificate, bounds=ForceBounds(*bounds)),
        converged=record["converged"],
        iterations=record["iterations"],
        status=record["status"],
        timing=record["timing"],
        passes=tuple((float(change), float(residual)) for change, residual in record["passes"]),
        branch=str(record.get("branch", "")),
        warnings=tuple(str(warning) for warning in record.get("warnings", [])),
        solved_by=dict(record.get("solved_by", {})),  # files written before these were counted have neither
        calls={
            problem: {name: Calls(**each) for name, each in solvers.items()}
            for problem, solvers in record.get("calls", {}).items()
        },
        error_estimate=None if estimate is None else ErrorEstimate.from_plain(estimate),
    )
    check_schema(sol)
    sol = with_pressure(sol, found.get(PRESSURE))
    if "refinement" in record:
        sol = replace(sol, refinement=refinement_from(found, record["refinement"], sol))
    return sol


def check_schema(sol: Solution) -> None:
    """Refuse fields and entries of other shapes, types or ranges than a solution has; `load` certifies the values."""
    shape, certificate = sol.grid.shape, sol.certificate
    fields = {name: getattr(sol, name) for name in ON_ELEMENTS if getattr(sol, name) is not None}
    shapes = {"traction": (2, *shape), "slip": (2, *shape), MEMORY: np.asarray(sol.memory).shape}
    shapes[PLASTIC_STATE] = (3, *shape)
    if any(each.shape != shapes.get(name, shape) for name, each in fields.items()):
        raise ValueError("fields that are not of the grid's shape")
    if any(each.dtype.kind not in "iuf" for each in fields.values()):
        raise ValueError("fields that are not numbers")
    if any(not np.isfinite(each).all() for name, each in fields.items() if name != "power_density"):
        raise ValueError("fields that are not finite numbers")
    sizes = [np.abs(each).max() for name, each in fields.items() if name != "power_density"]
    if np.nanmax(np.abs([*sizes, sol.approach, *sol.creepage])) > checks.LARGE**2:
        raise ValueError("numbers beyond those that can be computed with")
    known = (EXTERIOR, STICK, SLIP, *((PLASTIC,) if sol.plastic is not None else ()))
    if not np.isin(sol.state, known).all() or np.any((sol.state != EXTERIOR) != (sol.pressure > 0)):
        raise ValueError("a state that is not exterior (0) without pressure, and stick (1) or slip (2) under it")
    if (sol.plastic is not None) != (sol.scene.third_body is not None and sol.scene.third_body.yields):
        raise ValueError("a plastic state of a third body that is missing, or should be")
    if sol.weakening is not None and not np.all((sol.weakening >= 0) & (sol.weakening <= 1)):
        raise ValueError("a weakening of friction that is not between 0 and 1")
    if (sol.memory is not None) != (sol.scene.bodies.relaxes and isinstance(sol.motion, TimeStep)):
        raise ValueError("a memory of viscoelastic bodies that is missing, or should be")
    if sol.memory is not None and (sol.memory.ndim != 4 or sol.memory.shape[1] != 3):
        raise ValueError("a memory that is not of tractions")
    if not (sol.scene.approach_undetermined or np.isfinite(sol.approach)):
        raise ValueError("an approach that is not finite")
    if sol.motion and not (
        sol.scene.shift_undetermined
        or sol.scene.frictionless
        or np.isfinite(sol.creepage).all()
        or not sol.pressure.any()
    ):
        raise ValueError("creepages that are not finite")
    values = [np.ravel(value) for name, value in certificate.plain().items() if name != "level"]
    numbers = np.concatenate([*values, [*sol.timing.values(), *sol.iterations.values()]])
    if certificate.level not in LEVELS or numbers.dtype.kind not in "iuf" or np.any(numbers < 0):
        raise ValueError("a certificate, times or iterations that are not numbers, zero or positive")
    if not all(isinstance(word, str) for word in (*sol.status.values(), *sol.solved_by.values())):
        raise ValueError("solvers' words that are no words")
    if "total" not in sol.timing or not isinstance(sol.converged, bool) or sol.branch not in ("", *BRANCHES):
        raise ValueError("no total time, or a branch that there is not")


MARK = b"\nvarcontact sha256 "
"""Between a file's bytes and their checksum, where netCDF and HDF5 do not look: HDF5 has none over the whole file."""


def with_checksum(content: bytes) -> bytes:
    """The bytes of a file with their checksum behind them."""
    return content + MARK + _digest(content)


def without_checksum(content: bytes) -> bytes:
    """The bytes of a file without the checksum, which they have to fit; as they are, where there is none.

    A file that another program has written anew has none.
    """
    own, digest = content[:-64], content[-64:]
    if not own.endswith(MARK):
        return content
    own = own.removesuffix(MARK)
    if _digest(own) != digest:
        raise ValueError("its bytes are not those that were written")
    return own


def _digest(content: bytes) -> bytes:
    return hashlib.sha256(content).hexdigest().encode()
