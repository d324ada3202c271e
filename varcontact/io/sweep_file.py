"""Sweeps as files whose records are filled in any order.

The file is classic netCDF and has its full length from the beginning: a record for each scene, empty until that scene
is solved. A record lies in one piece and carries its own checksum, so it is there whole or not at all, whatever ends
the program; nothing else of the file changes, and no disk is too full for it later on. The order in which results come
leaves no trace: the same sweep gives the same bytes.
"""

from __future__ import annotations

import io
import json
import os
import zlib
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np

from varcontact.errors import OutputError
from varcontact.io.history_record import COUNT_AT, MAGIC
from varcontact.system.files import check_ending, check_writable, only_writer, reading, replacing

FORMAT = "varcontact sweep 1"
OUTCOMES = ("", "solved", "approximate", "not converged", "refused", "unavailable", "failed")
"""What becomes of a scene; nothing, while it is not solved."""
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


def record_type(settings: Mapping[str, Any]) -> np.dtype:
    """What the file of a sweep has of each scene, in the order and the bytes of its records."""
    numbers = NUMBERS | (ERRORS if {"accuracy", "time_budget"} & settings.keys() else {})
    return np.dtype(
        [(name, ">f8") for name in numbers]
        + [(name, ">i4") for name in (*COUNTS, "outcome")]
        + [("reason", f"S{LONGEST_REASON}"), ("check", ">u4")]
    )


RECORD = record_type({})
"""That of a sweep on given grids."""


def blank(scenes: int, record: np.dtype = RECORD) -> np.ndarray:
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
        check_ending("store", path, ".nc")
        check_writable("store", path)
        record = record_type(described["settings"])
        with only_writer("store", path):
            header = _header(described, scenes)
            if not path.exists() or path.stat().st_size == 0:
                with replacing("store", path) as file:
                    file.write(header)
                    file.write(blank(scenes, record).tobytes())
            elif (there := _read_store(path)[1]) != (asked := json.loads(json.dumps(described))):
                raise OutputError("store", path, f"holds another sweep{_difference(there, asked)}; name a new file")
            with path.open("r+b", buffering=0) as file:
                yield cls(path, len(header), record, file)

    def records(self, scenes: int) -> np.ndarray:
        """What is in the file; records that are not whole are as if nothing were there."""
        return _records(self._file, self.begin, scenes, self.record)

    def put(self, first: int, records: np.ndarray) -> None:
        """Put some records behind each other, and force them to the disk."""
        try:
            if not (self.path.exists() and os.path.samestat(os.fstat(self._file.fileno()), self.path.stat())):
                raise OutputError("store", self.path, "has been replaced by something else since this sweep opened it")
            self._file.seek(self.begin + first * self.record.itemsize)
            self._file.write(records.tobytes())
            os.fsync(self._file.fileno())
        except OutputError:
            raise
        except OSError as error:
            raise OutputError("store", self.path, f"cannot be written ({error.strerror or error})") from None


def read_sweep_file(path: Path) -> tuple[dict[str, Any], np.ndarray]:
    """What a sweep is, and its records, from its file."""
    begin, described, scenes = _read(path)
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


def _header(described: dict[str, Any], scenes: int) -> bytes:
    """The file up to its first record."""
    content, size = _file_of(described, 0)
    content, size = _file_of(described, len(content) - size)
    assert size == record_type(described["settings"]).itemsize
    return MAGIC + scenes.to_bytes(4, "big") + content[COUNT_AT + 4 : -size]


def _file_of(described: dict[str, Any], begin: int) -> tuple[bytes, int]:
    """A file of one empty record, and the bytes of that at its end."""
    from scipy.io import netcdf_file

    buffer = io.BytesIO()
    file = netcdf_file(buffer, "w", version=2)
    file.format, file.first_record, file.sweep = FORMAT, f"{begin:012d}", json.dumps(described)
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
    file.variables["outcome"].meaning = "; ".join(f"{k} {word or 'not solved yet'}" for k, word in enumerate(OUTCOMES))
    file.variables["check"].meaning = "CRC-32 of the other bytes of the record, unsigned"
    file.flush()
    return buffer.getvalue(), int(file._recsize)


def _difference(there: dict[str, Any], asked: dict[str, Any]) -> str:
    """The settings in which two sweeps differ, where it is these alone."""
    if {**there, "settings": None} != {**asked, "settings": None}:
        return ""
    old, new = there["settings"], asked["settings"]
    changed = [f"{name} = {old.get(name)!r}, not {new[name]!r}" for name in new if old.get(name) != new[name]]
    return f" ({', '.join(changed)})"


def _read_store(path: Path) -> tuple[int, dict[str, Any], int]:
    """What `_read` gives, of a file that is to be gone on with."""
    try:
        return _read(path)
    except OutputError as error:
        raise OutputError("store", path, f"exists already and {error.reason}; name a new file") from None


def _read(path: Path) -> tuple[int, dict[str, Any], int]:
    """Where the records of a file begin, what sweep it is of, and how many there are."""
    from scipy.io import netcdf_file

    if not path.exists():
        raise OutputError("path", path, "there is no such file")
    with reading(path, "cannot be read as a sweep"), netcdf_file(path, "r", mmap=False) as file:
        if getattr(file, "format", b"") != FORMAT.encode():
            raise OutputError("path", path, f"is not a {FORMAT!r} file")
        begin, described = int(file.first_record), json.loads(file.sweep.decode())
        scenes = int(file.variables["outcome"].shape[0])
    return begin, described, scenes
