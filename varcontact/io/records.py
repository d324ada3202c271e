"""Files of records, of a history's steps and a sweep's scenes: classic netCDF, each record in one piece.

scipy makes and reads them, but a record is written in its place here: no library adds one safely. scipy's own mode for
that rewrites the whole file for every step (1 ms for the first of 40 x 40 elements, 800 ms for the four hundredth), and
of 20 files whose program was killed 8 could not be read. HDF5 groups lost 4 of 14 such files, and HDF5 datasets that
grow while others read them (SWMR) lost none of 20, but none of these could be extended.

The steps of a history are appended, and counted when they are on the disk. The file of a sweep has its full length from
the beginning; a record is filled in any order, and is valid if its checksum fits, so that the same sweep gives the same
bytes, and no disk is too full for it later on.
"""

from __future__ import annotations

import io
import json
import os
import zlib
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, BinaryIO, cast

import numpy as np

from varcontact.errors import OutputError
from varcontact.io.scene_toml import scene_to
from varcontact.io.solution import FIELDS, solution_to_bytes, variables_of
from varcontact.results.plan import Plan
from varcontact.results.solution import Solution
from varcontact.scene.motion import Transient
from varcontact.scene.scene import Scene
from varcontact.system.files import check_writable, only_writer, reading, replacing

MAGIC = b"CDF\x02"
COUNT_AT = 4
"""Place of the number of records in a classic netCDF file: four bytes, the highest first."""
HISTORY_FORMAT, SWEEP_FORMAT = "varcontact history 1", "varcontact sweep 1"

# Steps of a history
RECORD, RECORD_OF_PASSES, LAST_PASSES, LONGEST_WORD = 2048, 8192, 100, 200
"""Characters for how a step was found, without and with passes, of which the last are kept, or an estimate of its
error; and for a solver's message."""
SERIES = {**FIELDS, "friction_work": ((), "force", "work lost by friction: by distance rolled, in a shift as it is")}
"""The fields of each step: dimensions, quantity, description."""

# Scenes of a sweep
OUTCOMES = ("", "solved", "approximate", "not converged", "refused", "unavailable", "failed")
"""Outcomes by number; none while a scene is not solved."""
LONGEST_REASON = 240
NUMBERS = {
    "normal_force": "force",
    "approach": "length",
    "Fx": "force",
    "Fy": "force",
    "Mz": "moment",
    "vx": "1",
    "vy": "1",
    "spin": "1",
    "gap": "1",
    "relative_gap": "1",
    "residual": "1",
    "Fx_bound": "force",
    "Fy_bound": "force",
    "Mz_bound": "moment",
}
COUNTS = ("contact", "stick", "slip", "iterations")
ERRORS = {"Fx_error": "force", "Fy_error": "force", "Mz_error": "moment", "vx_error": "1", "vy_error": "1"}
"""Error bars, of sweeps to an accuracy or within a time."""


@contextmanager
def storing(path: Path) -> Iterator[None]:
    """Errors while records are written become those of the store."""
    try:
        yield
    except OSError as error:
        raise OutputError("store", path, f"cannot be written ({error.strerror or error})") from None


@contextmanager
def _draft(form: str) -> Iterator[tuple[Any, list[bytes]]]:
    """A netCDF file in memory, and a list that gets the header and the single record of the finished file."""
    from scipy.io import netcdf_file

    buffer, parts = io.BytesIO(), list[bytes]()
    file = netcdf_file(buffer, "w", version=2)
    file.format = form
    yield file, parts
    file.flush()
    content = buffer.getvalue()
    buffer.close()  # else the file writes itself once more when it goes, where Ctrl-C would be lost
    parts += [content[: -file._recsize], content[-file._recsize :]]


def first_step(scene: Scene, plan: Plan, settings: dict[str, Any], sol: Solution) -> bytes:
    """The file with the first step, and with the position of that."""
    header, _ = _step(scene, plan, settings, sol, 0)
    return b"".join(_step(scene, plan, settings, sol, len(header)))


def next_step(scene: Scene, plan: Plan, settings: dict[str, Any], sol: Solution) -> bytes:
    """The record of a further step."""
    return _step(scene, plan, settings, sol, None)[1]


def _step(scene: Scene, plan: Plan, settings: dict[str, Any], sol: Solution, begin: int | None) -> list[bytes]:
    """Header and record of a step; the header is of no use without the position where it ends."""
    start = cast(Transient, scene.motion).start
    variables, places, record = variables_of(sol, SERIES, shift=False)
    with _draft(HISTORY_FORMAT) as (file, parts_of_file):
        file.first_step = f"{begin or 0:012d}"
        file.scene, file.grid = json.dumps(scene_to(scene)), json.dumps(vars(sol.grid))
        file.plan, file.settings = json.dumps(asdict(plan)), json.dumps(settings)
        longer = plan.loops or scene.under_law or sol.error_estimate is not None
        length = RECORD_OF_PASSES if longer else RECORD
        sizes = {"component": 2, "y": sol.grid.rows, "x": sol.grid.nx, "rigid": 3, "letters": 8, "characters": length}
        sizes |= {name: place[1].size for name, place in places.items()}
        if sol.memory is not None:
            sizes |= {"relaxation": len(sol.memory), "axis": 3}
        if sol.plastic is not None:
            sizes["flow"] = 3
        file.createDimension("step", None)
        for name, size in sizes.items():
            file.createDimension(name, size)
        for name, (_, values, said) in places.items():
            variable = file.createVariable(name, "d", (name,))
            variable[:], variable.units = values, said["units"]
        for name, labels in {"component": ("x", "y"), "rigid": ("vx", "vy", "spin")}.items():
            variable = file.createVariable(name, "c", (name, "letters"))
            variable[:] = np.array([list(label.ljust(8, "\0")) for label in labels], dtype="S1")
        if start is not None and begin is not None:
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
    return parts_of_file


def record_type(settings: Mapping[str, Any]) -> np.dtype:
    """The entries of a scene, in the order and the bytes of its record."""
    numbers = NUMBERS | (ERRORS if {"accuracy", "time_budget"} & settings.keys() else {})
    return np.dtype(
        [(name, ">f8") for name in numbers]
        + [(name, ">i4") for name in (*COUNTS, "outcome")]
        + [("reason", f"S{LONGEST_REASON}"), ("check", ">u4")]
    )


def blank(scenes: int, record: np.dtype) -> np.ndarray:
    """Records of scenes that are not solved."""
    records = np.zeros(scenes, record)
    for name in record.names or ():
        if record[name] == ">f8":
            records[name] = np.nan
    return records


def sealed(records: np.ndarray) -> np.ndarray:
    """Records with their checksums."""
    records = records.copy()
    records["check"] = [_checksum(record) for record in records]
    return records


def finished(records: np.ndarray) -> np.ndarray:
    """Which records are of scenes that are solved, or have failed, and are whole."""
    there = (records["outcome"] > 0) & (records["outcome"] < len(OUTCOMES))
    there[there] = [record["check"] == _checksum(record) for record in records[there]]
    return there


def _checksum(record: np.void) -> int:
    return zlib.crc32(record.tobytes()[: -record.dtype["check"].itemsize])


@dataclass(frozen=True, eq=False)
class SweepFile:
    """The file of a sweep, open for records to be put into it."""

    path: Path
    begin: int  # where the first record begins [bytes]
    record: np.dtype
    _file: BinaryIO

    @classmethod
    @contextmanager
    def opened(cls, path: Path, described: dict[str, Any], scenes: int) -> Iterator[SweepFile]:
        """The file at `path`, for nobody else meanwhile: a new one, or that of the same sweep."""
        check_writable("store", path, (".nc",))
        record = record_type(described["settings"])
        with only_writer("store", path):
            header = _sweep_header(described, len(_sweep_header(described, 0)))
            header = MAGIC + scenes.to_bytes(4, "big") + header[COUNT_AT + 4 :]
            if not path.exists() or path.stat().st_size == 0:
                with replacing("store", path) as file:
                    file.write(header)
                    file.write(blank(scenes, record).tobytes())
            else:
                _check_same_sweep(path, json.loads(json.dumps(described)))
            with path.open("r+b", buffering=0) as file:
                yield cls(path, len(header), record, file)

    def records(self, scenes: int) -> np.ndarray:
        """What is in the file; records that are not whole are as if nothing were there."""
        return _records(self._file, self.begin, scenes, self.record)

    def put(self, first: int, records: np.ndarray) -> None:
        """Put some records behind each other, and force them to the disk."""
        with storing(self.path):
            if not (self.path.exists() and os.path.samestat(os.fstat(self._file.fileno()), self.path.stat())):
                raise OutputError("store", self.path, "has been replaced by something else since this sweep opened it")
            self._file.seek(self.begin + first * self.record.itemsize)
            self._file.write(records.tobytes())
            os.fsync(self._file.fileno())


def read_sweep_file(path: Path) -> tuple[dict[str, Any], np.ndarray]:
    """What a sweep is, and its records, from its file."""
    begin, described, scenes = _read_header(path)
    with path.open("rb") as file:
        return described, _records(file, begin, scenes, record_type(described["settings"]))


def _records(file: BinaryIO, begin: int, scenes: int, record: np.dtype) -> np.ndarray:
    file.seek(begin)
    content = file.read(scenes * record.itemsize)
    records, whole = blank(scenes, record), len(content) // record.itemsize
    there = np.frombuffer(content[: whole * record.itemsize], record)
    done = np.flatnonzero(finished(there))
    records[done] = there[done]
    return records


def _sweep_header(described: dict[str, Any], begin: int) -> bytes:
    with _draft(SWEEP_FORMAT) as (file, parts):
        file.first_record, file.sweep = f"{begin:012d}", json.dumps(described)
        file.createDimension("number", None)
        file.createDimension("characters", LONGEST_REASON)
        units, record, quantities = described.get("units", {}), record_type(described["settings"]), NUMBERS | ERRORS
        for name in record.names or ():
            if name == "reason":
                file.createVariable(name, "c", ("number", "characters"))[0] = np.zeros(LONGEST_REASON, "S1")
                continue
            variable = file.createVariable(name, "d" if name in quantities else "i", ("number",))
            variable[0] = 0
            if units.get(quantities.get(name, "")):
                variable.units = units[quantities[name]]
        file.variables["outcome"].meaning = "; ".join(
            f"{k} {word or 'not solved yet'}" for k, word in enumerate(OUTCOMES)
        )
        file.variables["check"].meaning = "CRC-32 of the other bytes of the record, unsigned"
    return parts[0]


def _check_same_sweep(path: Path, wanted: dict[str, Any]) -> None:
    """Refuse the file of another sweep; the error has the settings that differ, where it is these alone."""
    try:
        _, there, _ = _read_header(path)
    except OutputError as error:
        raise OutputError("store", path, f"exists already and {error.reason}; name a new file") from None
    if there == wanted:
        return
    changed = ""
    if {**there, "settings": None} == {**wanted, "settings": None}:
        old, new = there["settings"], wanted["settings"]
        differ = [f"{name} = {old.get(name)!r}, not {new[name]!r}" for name in new if old.get(name) != new[name]]
        changed = f" ({', '.join(differ)})"
    raise OutputError("store", path, f"holds another sweep{changed}; name a new file")


def _read_header(path: Path) -> tuple[int, dict[str, Any], int]:
    from scipy.io import netcdf_file

    if not path.exists():
        raise OutputError("path", path, "there is no such file")
    with reading(path, "cannot be read as a sweep"), netcdf_file(path, "r", mmap=False) as file:
        if getattr(file, "format", b"") != SWEEP_FORMAT.encode():
            raise OutputError("path", path, f"is not a {SWEEP_FORMAT!r} file")
        begin, described = int(file.first_record), json.loads(file.sweep.decode())
        scenes = int(file.variables["outcome"].shape[0])
    return begin, described, scenes
