"""Files of records, of a history's steps and a sweep's scenes: libraries make
and read them, bytes are put in here.

No library adds a record safely. scipy's own mode for that rewrites the whole
file for every step (1 ms for the first of 40 x 40 elements, 800 ms for the four
hundredth), and of 20 files whose program was killed 8 could not be read. HDF5
groups lost 4 of 14 such files, and HDF5 datasets that grow while others read
them (SWMR) lost none of 20, but none of these could be extended.

The steps of a history are appended to a classic netCDF file, and counted when
they are on the disk. Each ends with its checksum, and the header has its own.

The file of a sweep is the netCDF-4 file of its dataset, of full length from the
beginning. The values of a scene are written over those of none, in any order,
and count if their checksum fits: the same sweep gives the same bytes, and no
disk is too full for it later on. All bytes but these values never change. Their
checksum stands behind them, with the places of the values: HDF5, which some
damaged files keep busy for ever, opens none whose checksum differs.
"""

from __future__ import annotations

import hashlib
import io
import json
import os
import re
import zlib
from collections.abc import Callable, Container, Iterable, Iterator, Mapping
from contextlib import contextmanager
from mmap import ACCESS_READ, mmap
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple, cast

import numpy as np

from varcontact.errors import OutputError
from varcontact.io.quantities import COUNTS, ERRORS, FIELDS, NUMBERS
from varcontact.io.scene_toml import scene_to
from varcontact.io.solution import netcdf_to_bytes, solution_to_bytes, variables_of
from varcontact.results.plan import Plan
from varcontact.results.solution import Solution
from varcontact.scene.scene import Scene
from varcontact.scene.transient import Transient
from varcontact.system.files import (
    check_regular,
    check_writable,
    only_writer,
    reading,
    replacing,
    writing,
)
from varcontact.system.process import need

if TYPE_CHECKING:
    import h5py
    import xarray as xr

MAGIC = b"CDF\x02"
CHECK_BYTES = 4
"""Size of the checksum at the end of a step [bytes]."""
COUNT_AT = 4
"""Place of the number of records in a classic netCDF file: four bytes, the highest first."""
HISTORY_FORMAT = "varcontact history 3"
SWEEP_FORMAT = "varcontact sweep 3"
EARLIER_HISTORIES = ("varcontact history 1", "varcontact history 2")
"""Formats that can only be read: without checksums, and with other fields carried by particles."""
LAYOUT = "steps of {:012d} bytes from {:012d}, sha256 {}"
"""Text in the header of a history: size and place of its steps, and the checksum of the header."""
LAYOUT_PATTERN = re.compile(rb"steps of (\d{12}) bytes from (\d{12}), sha256 ([0-9a-f]{64})")
NO_DIGEST = "0" * 64
LAYOUT_WITHIN = 4096
"""Bytes from the beginning of a file within which its header has the layout: dimensions come
first."""
INDEX_MARK = b"\nvarcontact sweep index "
"""Marker between the netCDF-4 file of a sweep and its index."""
NOT_AS_WRITTEN = "its bytes are not those that were written"

# Steps of a history
RECORD = 2048
"""Characters for the certificate, methods and times of a step."""
RECORD_OF_PASSES = 8192
"""Characters for the certificate, methods and times of a step with passes or an error estimate."""
BIG_ENDIAN = {"b": ">i1", "d": ">f8"}
"""The types of a netCDF file, whose numbers have the highest byte first."""
FILL = b"\x81"
"""Fill value of netCDF for fields of bytes."""
LAST_PASSES = 100
"""Largest number of passes that are stored, the last ones."""
LONGEST_WORD = 200
"""Longest message of a solver that is stored [characters]."""
SERIES = {
    **FIELDS,
    "friction_work": (
        (),
        "force",
        "work lost by friction: per distance rolled, in a shift as it is",
    ),
}
"""The fields of each step: dimensions, quantity, description."""

# Scenes of a sweep
OUTCOMES = ("solved", "approximate", "not converged", "refused", "unavailable", "failed")
LONGEST_OUTCOME = 16
LONGEST_REASON = 240


def history_to_bytes(scene: Scene, plan: Plan, settings: dict[str, Any], sol: Solution) -> bytes:
    """The file of a history with its first step; its header has a checksum of its own."""
    from scipy.io import netcdf_file

    start = cast(Transient, scene.motion).start
    variables, places, _ = variables_of(sol, SERIES, shift=False)
    buffer = io.BytesIO()
    file = netcdf_file(buffer, "w", version=2)
    file.format = HISTORY_FORMAT
    file.layout = LAYOUT.format(0, 0, NO_DIGEST)
    file.scene = json.dumps(scene_to(scene))
    file.grid = json.dumps(vars(sol.grid))
    file.plan = json.dumps(plan.record())
    file.settings = json.dumps(settings)
    # dimensions and coordinates
    sizes = {
        "component": 2,
        "y": sol.grid.rows,
        "x": sol.grid.nx,
        "rigid": 3,
        "letters": 8,
        "characters": _record_length(scene, plan, sol),
    }
    sizes |= {name: place[1].size for name, place in places.items()}
    for dims, values, _ in variables.values():
        sizes |= zip(dims, values.shape, strict=True)
    file.createDimension("step", None)
    for name, size in sizes.items():
        file.createDimension(name, size)
    for name, (_, values, said) in places.items():
        variable = file.createVariable(name, "d", (name,))
        variable[:] = values
        variable.units = said["units"]
    for name, labels in {"component": ("x", "y"), "rigid": ("vx", "vy", "spin")}.items():
        variable = file.createVariable(name, "c", (name, "letters"))
        variable[:] = np.array([list(label.ljust(8, "\0")) for label in labels], dtype="S1")
    # the start of the history
    if start is not None:
        content = np.frombuffer(solution_to_bytes(cast(Solution, start)), dtype=np.int8)
        file.createDimension("bytes", content.size)
        file.createVariable("start", "b", ("bytes",))[:] = content
    # fields and record of a step, in the order of `step_to_bytes`
    for name, (dims, values, said) in variables.items():
        variable = file.createVariable(name, _kind(values), ("step", *dims))
        variable[0] = values
        variable.units = said["units"]
        variable.long_name = said["long_name"]
    variable = file.createVariable("record", "c", ("step", "characters"))
    variable[0] = np.full(sizes["characters"], b" ")
    variable = file.createVariable("check", "i", ("step",))
    variable[0] = 0
    variable.long_name = "CRC-32 of the other values of the step"
    file.flush()
    written = buffer.getvalue()
    buffer.close()  # else it writes the file again when deleted, where a Ctrl-C would be lost
    step = step_to_bytes(scene, plan, sol)
    return with_layout(written[: -file._recsize], len(step)) + step


def step_to_bytes(scene: Scene, plan: Plan, sol: Solution) -> bytes:
    """The record of a step, with its checksum: its fields one after the other, each filled up to
    four bytes, as netCDF has it.
    """
    variables, _, record = variables_of(sol, SERIES, shift=False)
    record["status"] = {name: word[:LONGEST_WORD] for name, word in sol.status.items()}
    record["passes"] = sol.passes[-LAST_PASSES:]
    length = _record_length(scene, plan, sol)
    text = json.dumps(record).ljust(length)
    if len(text) > length:
        raise OutputError("history", "the record of a step", f"has more than {length} characters")
    fields = [values for _, values, _ in variables.values()]
    parts = [field.astype(BIG_ENDIAN[_kind(field)]).tobytes() for field in fields]
    parts.append(text.encode())
    step = b"".join(part + FILL * (-len(part) % 4) for part in parts)
    return step + zlib.crc32(step).to_bytes(CHECK_BYTES, "big")


def _kind(values: np.ndarray) -> str:
    """The netCDF type of a field: bytes, or numbers in double precision."""
    return "b" if values.dtype == np.int8 else "d"


def _record_length(scene: Scene, plan: Plan, sol: Solution) -> int:
    """Characters for the record of each step of a history."""
    if plan.loops or scene.under_law or sol.error_estimate is not None:
        return RECORD_OF_PASSES
    return RECORD


class Layout(NamedTuple):
    """Size of a step and place of the first one in the file of a history [bytes]."""

    size: int
    begin: int


def with_layout(header: bytes, size: int) -> bytes:
    """The header of a history, with the place of its steps and its checksum filled in."""
    empty = LAYOUT.format(0, 0, NO_DIGEST).encode()
    unsigned = header.replace(empty, LAYOUT.format(size, len(header), NO_DIGEST).encode(), 1)
    return unsigned.replace(NO_DIGEST.encode(), header_digest(unsigned), 1)


def header_digest(header: bytes) -> bytes:
    """SHA-256 of the header of a history, but for its checksum and the number of steps, which
    grows.
    """
    found = LAYOUT_PATTERN.search(header)
    assert found is not None
    parts = header[:COUNT_AT], header[COUNT_AT + 4 : found.start(3)], header[found.end(3) :]
    return hashlib.sha256(b"".join(parts)).hexdigest().encode()


def layout_of(path: Path) -> Layout | None:
    """Layout of a history's steps from its header; None for an earlier format without it."""
    with path.open("rb") as file:
        found = LAYOUT_PATTERN.search(file.read(LAYOUT_WITHIN))
    if found is None:
        return None
    return Layout(int(found[1]), int(found[2]))


def checked_layout(path: Path) -> Layout | None:
    """Size and place of a history's steps, from a header whose checksum is correct; None without
    any.
    """
    layout = layout_of(path)
    if layout is None:
        return None
    with path.open("rb") as file:
        header = file.read(min(layout.begin, path.stat().st_size))
    found = LAYOUT_PATTERN.search(header)
    if found is None or header_digest(header) != found[3]:
        raise OutputError("path", path, f"is damaged ({NOT_AS_WRITTEN})")
    return layout


def check_steps(path: Path, layout: Layout, steps: Iterable[int]) -> None:
    """Refuse steps with a wrong checksum."""
    with path.open("rb") as file:
        for k in steps:
            file.seek(layout.begin + k * layout.size)
            record = file.read(layout.size)
            if (
                zlib.crc32(record[:-CHECK_BYTES]).to_bytes(CHECK_BYTES, "big")
                != record[-CHECK_BYTES:]
            ):
                raise OutputError("path", path, f"is damaged in step {k} ({NOT_AS_WRITTEN})")


def record_type(settings: Mapping[str, Any], coordinates: Container[Any] = ()) -> np.dtype:
    """Data type of the record of a scene: all numbers that are not coordinates, outcome, reason and
    checksum.
    """
    numbers = NUMBERS | (ERRORS if {"accuracy", "time_budget"} & settings.keys() else {})
    return np.dtype(
        [(name, "f8") for name in numbers if name not in coordinates]
        + [(name, "i8") for name in COUNTS]
        + [("reason", f"S{LONGEST_REASON}"), ("outcome", f"S{LONGEST_OUTCOME}"), ("check", "u4")]
    )


def blank(scenes: int, record: np.dtype) -> np.ndarray:
    """Records of scenes that are not solved yet."""
    records = np.zeros(scenes, record)
    for name in record.names or ():
        if record[name].kind == "f":
            records[name] = np.nan
    return records


def checksums(records: np.ndarray) -> np.ndarray:
    """CRC-32 of each record without its trailing checksum."""
    size = records.dtype["check"].itemsize
    return np.array(
        [zlib.crc32(record.tobytes()[:-size]) for record in records], records.dtype["check"]
    )


def finished(records: np.ndarray) -> np.ndarray:
    """Mask of complete records, of scenes that are solved or have failed."""
    return np.isin(records["outcome"], np.array(OUTCOMES, "S")) & (
        records["check"] == checksums(records)
    )


def tabulated(
    records: np.ndarray,
    coordinates: xr.Coordinates,
    described: Mapping[str, Any],
    stored: bool = False,
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
    settings = {
        name: int(value) if isinstance(value, bool) else value for name, value in settings.items()
    }
    if stored:
        return xr.Dataset(
            columns,
            coordinates,
            settings | {"format": SWEEP_FORMAT, "sweep": json.dumps(described)},
        )
    return xr.Dataset(columns, coordinates, settings).drop_vars("check")


@contextmanager
def sweep_file(
    path: Path, records: np.ndarray, coordinates: xr.Coordinates, described: dict[str, Any]
) -> Iterator[tuple[np.ndarray, Callable[[int, np.ndarray], None]]]:
    """Open the file of the same sweep, or a new one, exclusively: its records, and a function that
    stores some.

    These are put behind each other from a number on, and forced to the disk; what other readers go
    by comes last.
    """
    check_writable("store", path, (".nc",))
    described = json.loads(json.dumps(described))
    with only_writer("store", path):
        if path.exists() and path.stat().st_size > 0:
            try:
                records, _, there = read_sweep_file(path)
            except OutputError as error:
                raise OutputError(
                    "store", path, f"exists already and {error.reason}; name a new file"
                ) from None
            if there != described:
                changed = _changed_settings(there, described)
                raise OutputError("store", path, f"holds another sweep{changed}; name a new file")
        else:
            content = netcdf_to_bytes(tabulated(records, coordinates, described, stored=True))
            with replacing("store", path) as new:
                new.write(with_index(content, records.dtype.names or ()))
        places = checked_index(path)
        with path.open("r+b", buffering=0) as file:

            def put(first: int, solved: np.ndarray) -> None:
                solved["check"] = checksums(solved)
                with writing("store", path):
                    if not (
                        path.exists() and os.path.samestat(os.fstat(file.fileno()), path.stat())
                    ):
                        reason = "has been replaced by something else since this sweep opened it"
                        raise OutputError("store", path, reason)
                    for name, (place, _) in places.items():
                        file.seek(place + first * solved.dtype[name].itemsize)
                        file.write(solved[name].tobytes())
                    os.fsync(file.fileno())

            yield records, put


def _changed_settings(stored: dict[str, Any], described: dict[str, Any]) -> str:
    """Settings that differ, in brackets; empty where the sweeps differ in more than these."""
    old = stored["settings"]
    new = described["settings"]
    if stored | {"settings": new} != described:
        return ""
    changed = [
        f"{name} = {old.get(name)!r}, not {new[name]!r}"
        for name in new
        if old.get(name) != new[name]
    ]
    return f" ({', '.join(changed)})" if changed else ""


def read_sweep_file(path: Path) -> tuple[np.ndarray, xr.Coordinates, dict[str, Any]]:
    """Records of a sweep, blank where they are damaged or not finished; their coordinates, and the
    description of the sweep.

    By h5py: xarray opens each of the thirty variables, which takes twenty times as long.
    """
    import h5py

    with reading(path, "cannot be read as a sweep"):
        checked_index(path)
        need(
            "the sweep in the file", 3.0 * path.stat().st_size, "a sweep of fewer scenes would fit"
        )
        with h5py.File(path) as file:
            described = json.loads(file.attrs["sweep"])
            coordinates = _coordinates(file)
            there = np.zeros(file["check"].size, record_type(described["settings"], coordinates))
            for name in there.dtype.names or ():
                stored = np.ascontiguousarray(file[name][()])
                there[name] = stored.view(there.dtype[name]).ravel()
    done = finished(there)
    records = blank(len(there), there.dtype)
    records[done] = there[done]
    return records, coordinates, described


def _coordinates(file: h5py.File) -> xr.Coordinates:
    """Coordinates of the sweep in a netCDF-4 file: values, units and names."""
    import h5py
    import xarray as xr

    found = {}
    for scales in file["check"].dims:
        scale = scales[0]
        values = scale[()]
        if h5py.check_string_dtype(scale.dtype):
            values = scale.asstr()[()].astype(str)
        said = {name: scale.attrs[name] for name in ("units", "long_name") if name in scale.attrs}
        dim = scale.name.removeprefix("/")
        found[dim] = dim, values, said
    return xr.Dataset(coords=found).coords


Index = dict[str, tuple[int, int]]
"""Place and size of the values in the file of a sweep, by their name [bytes]."""


def with_index(content: bytes, names: Iterable[str]) -> bytes:
    """File of a sweep followed by its index: the places of the values of these names, and the
    checksum of everything else.
    """
    import h5py

    with h5py.File(io.BytesIO(content)) as file:
        index = {
            name: (file[name].id.get_offset(), file[name].id.get_storage_size()) for name in names
        }
    return content + INDEX_MARK + f"{index_digest(content, index)} {json.dumps(index)}".encode()


def index_digest(content: bytes | memoryview, index: Index) -> str:
    """SHA-256 of the parts of a sweep file that never change: the index, and all bytes except the
    values.
    """
    digest = hashlib.sha256(json.dumps(index).encode())
    at = 0
    for place, size in sorted(index.values()):
        digest.update(content[at:place])
        at = place + size
    digest.update(content[at:])
    return digest.hexdigest()


def checked_index(path: Path) -> Index:
    """Places of the values in the file of a sweep, after a check of all other bytes."""
    check_regular("path", path)
    with path.open("rb") as file, mmap(file.fileno(), 0, access=ACCESS_READ) as content:
        end = content.rfind(INDEX_MARK)
        if end < 0:
            raise _of_no_sweep(path, content)
        digest, _, text = content[end + len(INDEX_MARK) :].decode().partition(" ")
        index: Index = {name: (place, size) for name, (place, size) in json.loads(text).items()}
        with memoryview(content) as whole, whole[:end] as own:
            if index_digest(own, index) != digest:
                raise OutputError("path", path, f"is damaged ({NOT_AS_WRITTEN})")
    return index


def _of_no_sweep(path: Path, content: mmap) -> OutputError:
    """The error of a file without an index."""
    version = re.search(rb"varcontact sweep (\d)", content)
    if version is None:
        return OutputError("path", path, f"is not a {SWEEP_FORMAT!r} file")
    if version[0].decode() == SWEEP_FORMAT:
        return OutputError("path", path, "is damaged (its index is missing)")
    reason = (
        "is a sweep of an earlier version: xarray.open_dataset reads it, but it cannot be continued"
    )
    return OutputError("path", path, reason)
