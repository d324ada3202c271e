"""Solutions as datasets and netCDF files."""

from __future__ import annotations

import io
import json
import os
from dataclasses import asdict, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from varcontact.errors import OutputError, VarcontactError
from varcontact.io.plausible import check_plausible
from varcontact.io.scene_file import scene_from, scene_to
from varcontact.planning.plan import Plan
from varcontact.problem.certificate import Certificate
from varcontact.results.solution import Solution, plain_calls
from varcontact.scene.grid import Grid
from varcontact.scene.scene import Scene
from varcontact.scene.units import Units
from varcontact.solvers.tally import Calls

if TYPE_CHECKING:
    import xarray as xr

    from varcontact.results.history import History

FORMAT = "varcontact solution 1"
AS_STORED = "the certificate is as stored in the file, not measured again"

FIELDS = {
    "pressure": (("y", "x"), "pressure", "normal traction, compression positive"),
    "traction": (("component", "y", "x"), "pressure", "tangential traction on body 1"),
    "slip": (("component", "y", "x"), "1", "relative slip of body 1 over body 2"),
    "distance": (("y", "x"), "length", "deformed distance"),
    "state": (("y", "x"), "1", "0 exterior, 1 stick, 2 slip"),
    "traction_bound": (("y", "x"), "pressure", "friction coefficient times pressure"),
    "normal_force": ((), "force", "total compressive force"),
    "force": (("component",), "force", "total tangential force on body 1"),
    "moment": ((), "moment", "twisting moment on body 1 about the origin"),
    "approach": ((), "length", "approach of the bodies"),
    "creepage": (("rigid",), "1", "longitudinal, lateral and spin creepage (of a shift: ux, uy, rotation)"),
}


def dataset(sol: Solution) -> xr.Dataset:
    """A solution as an xarray dataset, see `Solution.to_xarray`.

    The attribute ``units`` of each variable is in the scene's units, or in words like "force/length^2" where the
    scene names none; forces of a line contact are per unit length.

    Parameters
    ----------
    sol : Solution
    """
    import xarray as xr

    units = units_of(sol.scene)
    shift, line = sol.motion is not None and sol.motion.rolls == 0, sol.scene.line
    variables: dict[str, Any] = {}
    for name, (dims, quantity, words) in FIELDS.items():
        quantity = "length" if name == "slip" and shift else quantity
        variables[name] = (
            dims,
            np.asarray(getattr(sol, name)),
            {"units": units.of(quantity, line), "long_name": words},
        )
    coordinates = {
        "x": ("x", sol.grid.x, {"units": units.of("length"), "long_name": "rolling direction"}),
        "y": ("y", sol.grid.y, {"units": units.of("length"), "long_name": "lateral direction"}),
        "component": ["x", "y"],
        "rigid": ["ux", "uy", "rotation"] if shift else ["vx", "vy", "spin"],
    }
    rest = {"scene": scene_to(sol.scene), "grid": vars(sol.grid), "plan": asdict(sol.plan), **record_of(sol)}
    variables["record"] = ((), json.dumps(rest), {"long_name": "scene, plan, certificate and timing as JSON"})
    return xr.Dataset(variables, coordinates, {"format": FORMAT})


def units_of(scene: Scene) -> Units:
    """A scene's units, or words in their place.

    Parameters
    ----------
    scene : Scene
    """
    return scene.units or Units(length="length", force="force")


def record_of(sol: Solution) -> dict[str, Any]:
    """How a solution was found: its plan, iterations, times and certificate, as plain data.

    Parameters
    ----------
    sol : Solution
    """
    return {
        "certificate": {name: np.asarray(value).tolist() for name, value in vars(sol.certificate).items()},
        "converged": sol.converged,
        "iterations": sol.iterations,
        "status": sol.status,
        "timing": sol.timing,
        "passes": sol.passes,
        "branch": sol.branch,
        "solved_by": sol.solved_by,
        "calls": plain_calls(sol.calls),
    }


def save(sol: Solution, path: str | Path, field: str = "path") -> None:
    """Write a solution to a netCDF file, whole or not at all.

    Parameters
    ----------
    sol : Solution
    path : str or Path
        Ends in .nc.
    field : str
        What the path is called in an error.

    Raises
    ------
    OutputError
        If the name has another ending, or the file cannot be written.
    """
    path = Path(path)
    check_ending(field, path, ".nc")
    check_writable(field, path)
    write_whole(field, path, solution_to_bytes(sol))


def write_whole(field: str, path: Path, content: bytes) -> None:
    """Write a file under another name, then rename it: whole or not at all.

    Parameters
    ----------
    field : str
        What the path is called in an error.
    path : Path
    content : bytes

    Raises
    ------
    OutputError
        If the file cannot be written; an old file of that name stays as it was.
    """
    temporary = path.with_name(f".{os.getpid()}.part")
    try:
        temporary.write_bytes(content)
        os.replace(temporary, path)
    except OSError as error:
        raise OutputError(field, path, f"cannot be written ({error.strerror or error})") from None
    finally:
        temporary.unlink(missing_ok=True)


def read(path: str | Path) -> Solution | History:
    """A solution or a history from its file, as it is stored: fields that no solution can have are refused.

    Parameters
    ----------
    path : str or Path

    Raises
    ------
    OutputError
        If there is no such file, it was not written by varcontact, or its contents cannot be a solution.
    """
    from varcontact.io.history_file import is_history, load_history

    try:
        stored_steps = is_history(Path(path))
    except OSError as error:
        raise OutputError("path", path, f"cannot be read ({error.strerror or error})") from None
    except ValueError as error:  # a null character in the name
        raise OutputError("path", path, f"cannot be read ({error})") from None
    if stored_steps:
        return load_history(Path(path))
    data = _data(path, path)
    try:
        return replace(solution_from(data), note=AS_STORED)
    except (KeyError, TypeError, ValueError, VarcontactError) as error:
        raise damaged(path, error) from None


def damaged(path: str | Path, error: Exception) -> OutputError:
    """The error for a file whose contents cannot be a solution.

    Parameters
    ----------
    path : str or Path
    error : Exception
        What was found in reading it.

    Returns
    -------
    OutputError
        To be raised.
    """
    return OutputError("path", path, f"is damaged ({first_line(error)})")


def _data(path: str | Path, content: Any) -> xr.Dataset:
    """The dataset in a file, or in the bytes of one."""
    import xarray as xr

    try:
        with xr.open_dataset(content, engine="h5netcdf") as opened:
            data: xr.Dataset = opened.load()
    except (OSError, ValueError, KeyError, RuntimeError, TypeError, AttributeError) as error:  # all seen from HDF5
        raise OutputError("path", path, f"cannot be read as netCDF ({first_line(error)})") from None
    if data.attrs.get("format") != FORMAT:
        raise OutputError("path", path, f"is not a {FORMAT!r} file")
    return data


def solution_to_bytes(sol: Solution) -> bytes:
    """A solution's file, in memory.

    Parameters
    ----------
    sol : Solution
    """
    buffer = io.BytesIO()  # on a full disk HDF5 itself would bring the interpreter down
    dataset(sol).to_netcdf(buffer, engine="h5netcdf")
    return buffer.getvalue()


def solution_from_bytes(path: Path, content: bytes) -> Solution:
    """A solution from its file in memory, which was found in the file at `path`.

    Parameters
    ----------
    path : Path
        For messages.
    content : bytes
        Of a netCDF-4 file.

    Raises
    ------
    OutputError
        If it holds no solution.
    """
    return solution_from(_data(path, io.BytesIO(content)))


def solution_from(data: xr.Dataset) -> Solution:
    """A solution from its dataset.

    Parameters
    ----------
    data : Dataset
        As a file has it.
    """
    record = json.loads(str(data["record"].values))
    fields = {name: data[name].values for name in ("pressure", "traction", "slip", "distance", "state")}
    scene, grid, plan = scene_from(record["scene"]), Grid(**record["grid"]), Plan.of_record(record["plan"])
    return assembled(scene, grid, plan, fields, float(data["approach"].values), data["creepage"].values, record)


def assembled(
    scene: Scene,
    grid: Grid,
    plan: Plan,
    fields: dict[str, Any],
    approach: float,
    creepage: np.ndarray,
    record: dict[str, Any],
) -> Solution:
    """A solution from what a file holds.

    Parameters
    ----------
    scene : Scene
    grid : Grid
        Explicit, physical.
    plan : Plan
    fields : dict of ndarray
        By name, (ny, nx), traction and slip (2, ny, nx), in the scene's units.
    approach : float
        [length]
    creepage : ndarray, shape (3,)
        vx, vy [-] and spin [1/length]; in a shift ux, uy [length] and rotation.
    record : dict
        As `record_of` gives it.

    Raises
    ------
    ValueError
        If that cannot be.
    """
    vectors = ("force_bound", "pressure_part")
    certificate: dict[str, Any] = dict(record["certificate"])
    certificate |= {name: np.array(certificate[name]) for name in vectors if name in certificate}
    vx, vy, spin = (float(value) for value in creepage)
    shapes = {name: (2, *grid.shape) if name in ("traction", "slip") else grid.shape for name in fields}
    if any(field.shape != shapes[name] for name, field in fields.items()):
        raise ValueError("fields that are not of the grid's shape")
    if any(field.dtype.kind not in "iuf" or not np.isfinite(field).all() for field in fields.values()):
        raise ValueError("fields that are not finite numbers")
    if any(certificate[name].shape != (3,) for name in vectors if name in certificate):
        raise ValueError("a bound on the forces that is not three numbers")
    kinds = {"converged": bool, "iterations": dict, "status": dict, "timing": dict}
    if any(not isinstance(record[name], kind) for name, kind in kinds.items()):
        raise ValueError(f"{', '.join(kinds)} that are of other types")
    sol = Solution(
        scene=scene,
        grid=grid,
        plan=plan,
        **fields,
        approach=approach,
        creepage=(vx, vy, spin),
        certificate=Certificate(**certificate),
        converged=record["converged"],
        iterations=record["iterations"],
        status=record["status"],
        timing=record["timing"],
        passes=tuple((float(change), float(residual)) for change, residual in record["passes"]),
        branch=str(record.get("branch", "")),
        solved_by=dict(record.get("solved_by", {})),  # files written before these were counted have neither
        calls={
            problem: {name: Calls(**each) for name, each in solvers.items()}
            for problem, solvers in record.get("calls", {}).items()
        },
    )
    check_plausible(sol)
    return sol


FORMATS = {".nc": "solutions and histories are written as netCDF", ".csv": "tables are written as CSV"}


def check_ending(field: str, path: Path, ending: str) -> None:
    """Refuse a name that promises another format than the one that is written.

    Parameters
    ----------
    field : str
        Name of the entry, for the message.
    path : Path
    ending : str
        As ".nc".

    Raises
    ------
    OutputError
        If it has another.
    """
    if path.suffix.lower() != ending:
        raise OutputError(field, path, f"{FORMATS[ending]}, and the name must end in {ending}")


def check_writable(field: str, path: Path) -> None:
    """Refuse a file that could not be written, before any work is done for it.

    Parameters
    ----------
    field : str
        Name of the entry, for the message.
    path : Path

    Raises
    ------
    OutputError
        If there is no such folder, it may not be written, or is a folder itself.
    """
    folder = path.parent
    try:
        if not folder.is_dir():
            raise OutputError(field, path, f"there is no folder {str(folder)!r}")
        if path.is_dir():
            raise OutputError(field, path, "is a folder")
        if not os.access(folder, os.W_OK) or (path.exists() and not os.access(path, os.W_OK)):
            raise OutputError(field, path, "may not be written")
        trial = folder / f".{os.getpid()}.part"
        trial.touch()
        trial.unlink()
        path.stat()
    except FileNotFoundError:
        pass
    except OutputError:
        raise
    except (OSError, ValueError) as error:  # ValueError: a null character in the name
        raise OutputError(field, path, f"cannot be written ({getattr(error, 'strerror', None) or error})") from None


def first_line(error: Exception) -> str:
    """The first line of what an error says.

    Parameters
    ----------
    error : Exception
    """
    return str(error).split("\n")[0]
