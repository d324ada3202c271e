"""Files of records, of a history's steps and a sweep's scenes: libraries make
and read them, bytes are put in here.

No library adds a record safely. scipy's own mode for that rewrites the whole
file for every step (1 ms for the first of 40 x 40 elements, 800 ms for the four
hundredth), and of 20 files whose program was killed 8 could not be read. HDF5
groups lost 4 of 14 such files, and HDF5 datasets that grow while others read
them (SWMR) lost none of 20, but none of these could be extended.

The steps of a history are appended to a classic netCDF file, and counted when
they are on the disk. The file of a sweep is the netCDF-4 file of its dataset,
of full length from the beginning. The values of a scene are written over those
of none, in any order, and count if their checksum fits: the same sweep gives
the same bytes, and no disk is too full for it later on.
"""

from __future__ import annotations

import io
import json
import os
import zlib
from collections.abc import Callable, Container, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

import numpy as np

from varcontact.errors import OutputError
from varcontact.io.quantities import COUNTS, ERRORS, FIELDS, NUMBERS
from varcontact.io.scene_toml import scene_to
from varcontact.io.solution import solution_to_bytes, variables_of
from varcontact.results.plan import Plan
from varcontact.results.solution import Solution
from varcontact.scene.scene import Scene
from varcontact.scene.transient import Transient
from varcontact.system.files import check_writable, only_writer, reading, replacing, writing

if TYPE_CHECKING:
    import xarray as xr

MAGIC = b"CDF\x02"
COUNT_AT = 4
"""Place of the number of records in a classic netCDF file: four bytes, the highest first."""
NOWHERE = "000000000000"
"""In place of the position of the first record."""
HISTORY_FORMAT, SWEEP_FORMAT = "varcontact history 1", "varcontact sweep 2"

# Steps of a history
RECORD, RECORD_OF_PASSES, LAST_PASSES, LONGEST_WORD = 2048, 8192, 100, 200
"""Characters for how a step was found, without and with passes, of which the last are kept, or an estimate of its
error; and for a solver's message."""
SERIES = {**FIELDS, "friction_work": ((), "force", "work lost by friction: by distance rolled, in a shift as it is")}
"""The fields of each step: dimensions, quantity, description."""

# Scenes of a sweep
OUTCOMES = ("solved", "approximate", "not converged", "refused", "unavailable", "failed")
LONGEST_OUTCOME, LONGEST_REASON = 16, 240


def step_to_bytes(scene: Scene, plan: Plan, settings: dict[str, Any], sol: Solution, first: bool) -> bytes:
    """The record of a step; of the first one the whole file, which says where that begins."""
    from scipy.io import netcdf_file

    start = cast(Transient, scene.motion).start
    variables, places, record = variables_of(sol, SERIES, shift=False)
    buffer = io.BytesIO()
    file = netcdf_file(buffer, "w", version=2)
    file.format = HISTORY_FORMAT
    file.first_step = NOWHERE
    file.scene, file.grid = json.dumps(scene_to(scene)), json.dumps(vars(sol.grid))
    file.plan, file.settings = json.dumps(asdict(plan)), json.dumps(settings)
    length = RECORD_OF_PASSES if plan.loops or scene.under_law or sol.error_estimate is not None else RECORD
    sizes = {"component": 2, "y": sol.grid.rows, "x": sol.grid.nx, "rigid": 3, "letters": 8, "characters": length}
    sizes |= {name: place[1].size for name, place in places.items()}
    for dims, values, _ in variables.values():
        sizes |= zip(dims, values.shape, strict=True)
    file.createDimension("step", None)
    for name, size in sizes.items():
        file.createDimension(name, size)
    for name, (_, values, said) in places.items():
        variable = file.createVariable(name, "d", (name,))
        variable[:], variable.units = values, said["units"]
    for name, labels in {"component": ("x", "y"), "rigid": ("vx", "vy", "spin")}.items():
        variable = file.createVariable(name, "c", (name, "letters"))
        variable[:] = np.array([list(label.ljust(8, "\0")) for label in labels], dtype="S1")
    if start is not None and first:
        content = np.frombuffer(solution_to_bytes(cast(Solution, start)), dtype=np.int8)
        file.createDimension("bytes", content.size)
        file.createVariable("start", "b", ("bytes",))[:] = content
    for name, (dims, values, said) in variables.items():
        variable = file.createVariable(name, "b" if values.dtype == np.int8 else "d", ("step", *dims))
        variable[0], variable.units, variable.long_name = values, said["units"], said["long_name"]
    record["status"] = {name: word[:LONGEST_WORD] for name, word in sol.status.items()}
    record["passes"] = sol.passes[-LAST_PASSES:]
    text = json.dumps(record).ljust(length)
    variable = file.createVariable("record", "c", ("step", "characters"))
    variable[0] = np.frombuffer(text.encode(), dtype="S1")
    file.flush()
    written = buffer.getvalue()
    buffer.close()  # else the file writes itself once more when it goes, where Ctrl-C would be lost
    header, record_bytes = written[: -file._recsize], written[-file._recsize :]
    place = f"{len(header):012d}"
    return header.replace(NOWHERE.encode(), place.encode(), 1) + record_bytes if first else record_bytes


def record_type(settings: Mapping[str, Any], coordinates: Container[Any] = ()) -> np.dtype:
    """The entries of a scene that are not coordinates, such as a load that varies."""
    numbers = NUMBERS | (ERRORS if {"accuracy", "time_budget"} & settings.keys() else {})
    return np.dtype(
        [(name, "f8") for name in numbers if name not in coordinates]
        + [(name, "i8") for name in COUNTS]
        + [("reason", f"S{LONGEST_REASON}"), ("outcome", f"S{LONGEST_OUTCOME}"), ("check", "u4")]
    )


def blank(scenes: int, record: np.dtype) -> np.ndarray:
    """Records of scenes that are not solved."""
    records = np.zeros(scenes, record)
    for name in record.names or ():
        if record[name].kind == "f":
            records[name] = np.nan
    return records


def checksums(records: np.ndarray) -> np.ndarray:
    """Of each record, but for the checksum at its end."""
    size = records.dtype["check"].itemsize
    return np.array([zlib.crc32(record.tobytes()[:-size]) for record in records], records.dtype["check"])


def finished(records: np.ndarray) -> np.ndarray:
    """Which records are of scenes that are solved, or have failed, and are whole."""
    return np.isin(records["outcome"], np.array(OUTCOMES, "S")) & (records["check"] == checksums(records))


def tabulated(
    records: np.ndarray, coordinates: xr.Coordinates, described: Mapping[str, Any], stored: bool = False
) -> xr.Dataset:
    """Records by the coordinates; `stored` as in the file, with checksums, and words as bytes."""
    import xarray as xr

    columns: dict[str, tuple[Any, ...]] = {}
    for name in records.dtype.names or ():
        values = records[name].reshape([len(coordinates[dim]) for dim in coordinates])
        quantity, words = (NUMBERS | ERRORS | COUNTS).get(name, ("", name))
        said = {"long_name": words}
        if quantity in described["units"]:
            said["units"] = described["units"][quantity]
        if stored and values.dtype.kind == "S":
            said["_Encoding"] = "utf-8"
        elif values.dtype.kind == "S":
            values = np.char.decode(values, "utf-8")
        columns[name] = tuple(coordinates), values, said
    settings = {name: value for name, value in described["settings"].items() if value is not None}
    settings = {name: int(value) if isinstance(value, bool) else value for name, value in settings.items()}
    if stored:
        return xr.Dataset(columns, coordinates, settings | {"format": SWEEP_FORMAT, "sweep": json.dumps(described)})
    return xr.Dataset(columns, coordinates, settings).drop_vars("check")


@contextmanager
def sweep_file(
    path: Path, records: np.ndarray, coordinates: xr.Coordinates, described: dict[str, Any]
) -> Iterator[tuple[np.ndarray, Callable[[int, np.ndarray], None]]]:
    """The file of the same sweep, or a new one, for nobody else meanwhile: its records, and a function to put some.

    These are put behind each other from a number on, and forced to the disk; what other readers go by comes last.
    """
    import h5py

    check_writable("store", path, (".nc",))
    described = json.loads(json.dumps(described))
    with only_writer("store", path):
        if path.exists() and path.stat().st_size > 0:
            try:
                records, _, there = read_sweep_file(path)
            except OutputError as error:
                raise OutputError("store", path, f"exists already and {error.reason}; name a new file") from None
            if there != described:
                changed, old, new = "", there["settings"], described["settings"]
                if there | {"settings": new} == described:
                    names = [name for name in new if old.get(name) != new[name]]
                    changed = ", ".join(f"{name} = {old.get(name)!r}, not {new[name]!r}" for name in names)
                raise OutputError("store", path, f"holds another sweep{changed and f' ({changed})'}; name a new file")
        else:
            content = io.BytesIO()  # on a full disk HDF5 itself would bring the interpreter down
            tabulated(records, coordinates, described, stored=True).to_netcdf(content, engine="h5netcdf")
            with replacing("store", path) as new:
                new.write(content.getvalue())
        with h5py.File(path) as data:  # where the values of the first scene are [bytes]
            places = {name: data[name].id.get_offset() for name in records.dtype.names or ()}
        with path.open("r+b", buffering=0) as file:

            def put(first: int, solved: np.ndarray) -> None:
                solved["check"] = checksums(solved)
                with writing("store", path):
                    if not (path.exists() and os.path.samestat(os.fstat(file.fileno()), path.stat())):
                        reason = "has been replaced by something else since this sweep opened it"
                        raise OutputError("store", path, reason)
                    for name, place in places.items():
                        file.seek(place + first * solved.dtype[name].itemsize)
                        file.write(solved[name].tobytes())
                    os.fsync(file.fileno())

            yield records, put


def read_sweep_file(path: Path) -> tuple[np.ndarray, xr.Coordinates, dict[str, Any]]:
    """The records of a sweep, those that are not whole as if nothing were there; their coordinates, and what it is."""
    import h5py
    import xarray as xr

    with reading(path, "cannot be read as a sweep"):
        with path.open("rb") as file:
            if b"varcontact sweep 1" in file.read(100):
                reason = "is a sweep of an earlier version: xarray.open_dataset reads it, but it cannot be continued"
                raise OutputError("path", path, reason)
        form = ""
        if h5py.is_hdf5(path):
            with h5py.File(path) as file:
                form = file.attrs.get("format", "")
        if form != SWEEP_FORMAT:
            raise OutputError("path", path, f"is not a {SWEEP_FORMAT!r} file")
        as_stored: dict[str, Any] = {"concat_characters": False, "decode_times": False}
        with xr.open_dataset(path, engine="h5netcdf", **as_stored) as opened:
            data = opened.load()
        described = json.loads(data.attrs["sweep"])
        coordinates = xr.Dataset(coords={dim: data[dim] for dim in data["check"].dims}).coords
        there = np.zeros(data["check"].size, record_type(described["settings"], coordinates))
        for name in there.dtype.names or ():
            there[name] = np.ascontiguousarray(data[name].values).view(there.dtype[name]).ravel()
    done = finished(there)
    records = blank(len(there), there.dtype)
    records[done] = there[done]
    return records, coordinates, described
