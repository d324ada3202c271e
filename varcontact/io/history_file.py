"""Histories as files to which steps are added: classic netCDF, whose records lie one behind the other.

A step is written behind the last one, and only then counted: whatever ends the program in between, the file holds
every finished step. Nothing else of the file changes, and nothing of it is kept in memory.

scipy makes the bytes of a step and reads them; it can only write whole files, so the step is put in its place here. One
HDF5 group a step would not do: killed between two of its writes, HDF5 can leave a file that cannot be read.
"""

from __future__ import annotations

import io
import json
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast, overload

import numpy as np

from varcontact.errors import OutputError, SceneError, VarcontactError
from varcontact.io.scene_file import scene_from, scene_to
from varcontact.io.solution_file import (
    AS_STORED,
    FIELDS,
    assembled,
    check_ending,
    check_writable,
    first_line,
    record_of,
    solution_from_bytes,
    solution_to_bytes,
    units_of,
    write_whole,
)
from varcontact.planning.plan import Plan
from varcontact.results.history import History
from varcontact.results.solution import Solution
from varcontact.scene.grid import Grid
from varcontact.scene.motion import Transient
from varcontact.scene.scene import Scene

if TYPE_CHECKING:
    import xarray as xr

FORMAT = "varcontact history 1"
MAGIC = b"CDF\x02"
COUNT_AT = 4
"""Where a classic netCDF file has the number of its records: four bytes, the highest first."""
RECORD, RECORD_OF_PASSES, LAST_PASSES, LONGEST_WORD = 2048, 8192, 100, 200
"""Characters for what a step says of how it was found, without and with passes, of which the last are kept; and for a
solver's word."""

_SERIES = {**FIELDS, "friction_work": ((), "1", "work lost by friction: by distance rolled, in a shift as it is")}


@dataclass(frozen=True, eq=False)
class Stored(Sequence[Solution]):
    """The steps of a history in a file.

    Attributes
    ----------
    path : Path
    scene : Scene
    plan : Plan
    settings : dict
        Tolerance and polish.
    measured : callable, optional
        What each step, given with its number and the step before, becomes when it is read; else it is as stored.
    """

    path: Path
    scene: Scene
    plan: Plan
    settings: dict[str, Any]
    measured: Callable[[int, Solution | None, Solution], Solution] | None = None

    @classmethod
    def opened(cls, path: Path, scene: Scene, plan: Plan, tol: float, polish: bool) -> Stored:
        """A file to add to: a new one, or one that holds the first steps of the same history.

        Parameters
        ----------
        path : Path
            Ending in .nc.
        scene : Scene
            With a `Transient` motion.
        plan : Plan
        tol : float
            Residual to be reached in each step [-].
        polish : bool
            Whether active sets polish the answers of programs.

        Raises
        ------
        OutputError
            If it cannot be written, or holds something else.
        """
        check_ending("store", path, ".nc")
        check_writable("store", path)
        stored = cls(path, scene, plan, {"tol": tol, "polish": polish})
        if not path.exists() or path.stat().st_size == 0:
            return stored
        if not is_history(path):
            raise OutputError("store", path, "exists already and holds no history")
        other = _stored(path)
        if _identity(stored) != _identity(other) or not _same_start(scene, other.scene):
            raise OutputError("store", path, "holds the history of another scene, or by other methods")
        return stored

    @property
    def grid(self) -> Grid:
        """The grid of all steps."""
        with _file(self.path) as file:
            return Grid(**json.loads(file.grid))

    def __len__(self) -> int:
        try:
            with self.path.open("rb") as file:
                file.seek(COUNT_AT)
                return int.from_bytes(file.read(4), "big")
        except FileNotFoundError:
            return 0

    @overload
    def __getitem__(self, k: int) -> Solution: ...

    @overload
    def __getitem__(self, k: slice) -> list[Solution]: ...

    def __getitem__(self, k: int | slice) -> Solution | list[Solution]:
        count = len(self)
        if isinstance(k, slice):
            return [self[each] for each in range(*k.indices(count))]
        if not -count <= k < count:
            raise IndexError(f"step {k} of a history of {count}")
        k %= count
        sol = self._read(k)
        if self.measured is None:
            return replace(sol, note=AS_STORED)
        before = self._read(k - 1) if k > 0 else None
        with self._damaged_in(k):
            return self.measured(k, before, sol)

    def _read(self, k: int) -> Solution:
        """Step k as it is in the file."""
        with _file(self.path) as file:
            grid = Grid(**json.loads(file.grid))
            names = ("pressure", "traction", "slip", "distance", "state", "approach", "creepage")
            fields = {name: _native(file.variables[name][k]) for name in names}
            record = file.variables["record"][k].tobytes()
        approach, creepage = float(fields.pop("approach")), fields.pop("creepage")
        with self._damaged_in(k):
            step = self.scene.step(k, grid)
            return assembled(step, grid, self.plan, fields, approach, creepage, json.loads(record))

    @contextmanager
    def _damaged_in(self, k: int) -> Iterator[None]:
        """Errors become those of a file that is damaged in step k."""
        try:
            yield
        except (KeyError, TypeError, ValueError, VarcontactError) as error:
            raise OutputError("path", self.path, f"is damaged in step {k} ({first_line(error)})") from None

    def series(self, name: str) -> np.ndarray:
        """A number or a few of each step, those called `name` in the file."""
        if len(self) == 0:
            return np.zeros((0, *(np.zeros(3 if name == "creepage" else 2).shape if _SERIES[name][0] else ())))
        with _file(self.path) as file:
            return _native(file.variables[name][:])

    def append(self, sol: Solution) -> None:
        """Add the next step, solved by `sol`; an `OutputError` tells why it cannot be written."""
        count = len(self)
        if count == 0:
            write_whole("store", self.path, _first(self, sol))
            return
        step = _step(self, sol)
        with _file(self.path) as file:
            begin = int(file.first_step)
        try:
            with self.path.open("r+b") as file:
                file.seek(begin + count * len(step))
                file.write(step)
                file.truncate()
                file.flush()
                file.seek(COUNT_AT)
                file.write((count + 1).to_bytes(4, "big"))
        except OSError as error:
            raise OutputError("store", self.path, f"cannot be written ({error.strerror or error})") from None


def save(history: History, path: str | Path) -> None:
    """Write a history to a file, whole or not at all.

    Parameters
    ----------
    history : History
    path : str or Path
        Ending in .nc.

    Raises
    ------
    OutputError
        If it cannot be written.
    """
    path = Path(path)
    check_ending("path", path, ".nc")
    check_writable("path", path)
    write_whole("path", path, _content(history, "path", path))


def is_history(path: Path) -> bool:
    """Whether the file at `path`, which exists, is classic netCDF, as histories are."""
    with path.open("rb") as file:
        return file.read(len(MAGIC)) == MAGIC


def load_history(path: Path) -> History:
    """A history from its file, each step as it is stored.

    Parameters
    ----------
    path : Path

    Raises
    ------
    OutputError
        If it holds no history that can be read.
    """
    stored = _stored(path)
    return History(stored.scene, stored.grid, stored, stored.settings)


def dataset(history: History) -> xr.Dataset:
    """A `history` as an xarray dataset, see `History.to_xarray`."""
    import xarray as xr

    source: Any = (
        history.solutions.path
        if isinstance(history.solutions, Stored)
        else io.BytesIO(_content(history, "history", Path("to_xarray")))
    )
    data = xr.open_dataset(source, engine="scipy")
    words = {name: data[name].astype(str).values for name in ("component", "rigid")}
    steps = {"step": np.arange(len(history)), "rolled": ("step", history.rolled)}
    return data.drop_vars("start", errors="ignore").assign_coords(words | steps)


def _content(history: History, field: str, path: Path) -> bytes:
    """The whole file."""
    if len(history) == 0:
        raise OutputError(field, path, "no step of the history is finished")
    stored = history.solutions
    if isinstance(stored, Stored):
        return stored.path.read_bytes()
    first = history[0]
    about = Stored(path, history.scene, first.plan, history.settings)
    content = bytearray(b"".join([_first(about, first), *(_step(about, sol) for sol in stored[1:])]))
    content[COUNT_AT : COUNT_AT + 4] = len(stored).to_bytes(4, "big")
    return bytes(content)


def _first(about: Stored, sol: Solution) -> bytes:
    """The file with the first step: it says where that begins, for those that follow."""
    content, size = _file_of(about, sol, 0)
    return _file_of(about, sol, len(content) - size)[0]


def _step(about: Stored, sol: Solution) -> bytes:
    """What a step adds to the file."""
    content, size = _file_of(about, sol, None)
    return content[-size:]


def _file_of(about: Stored, sol: Solution, begin: int | None) -> tuple[bytes, int]:
    """A file of one step, and the bytes of that step at its end; without `begin` only these count."""
    from scipy.io import netcdf_file

    buffer, units, start = io.BytesIO(), units_of(about.scene), _motion(about.scene).start
    file = netcdf_file(buffer, "w", version=2)
    file.format, file.first_step = FORMAT, f"{begin or 0:012d}"
    file.scene, file.grid = json.dumps(scene_to(about.scene)), json.dumps(vars(sol.grid))
    file.plan, file.settings = json.dumps(asdict(about.plan)), json.dumps(about.settings)
    loops = about.plan.loops or about.scene.under_law
    length = RECORD_OF_PASSES if loops else RECORD
    sizes = {
        "component": 2,
        "y": sol.grid.rows,
        "x": sol.grid.nx,
        "rigid": 3,
        "letters": 8,
        "characters": length,
    }
    file.createDimension("step", None)
    for name, size in sizes.items():
        file.createDimension(name, size)
    fixed = {"x": sol.grid.x, "y": sol.grid.y}
    for name, values in fixed.items():
        variable = file.createVariable(name, "d", (name,))
        variable[:], variable.units = values, units.of("length")
    for name, labels in {"component": ("x", "y"), "rigid": ("vx", "vy", "spin")}.items():
        variable = file.createVariable(name, "c", (name, "letters"))
        variable[:] = np.array([list(label.ljust(8, "\0")) for label in labels], dtype="S1")
    if start is not None and begin is not None:
        content = np.frombuffer(solution_to_bytes(cast(Solution, start)), dtype=np.int8)
        file.createDimension("bytes", content.size)
        file.createVariable("start", "b", ("bytes",))[:] = content
    for name, (dims, quantity, words) in _SERIES.items():
        values = np.asarray(getattr(sol, name))
        variable = file.createVariable(name, "b" if values.dtype == np.int8 else "d", ("step", *dims))
        variable[0], variable.units, variable.long_name = values, units.of(quantity, about.scene.line), words
    record = record_of(sol)
    record["status"] = {name: word[:LONGEST_WORD] for name, word in sol.status.items()}
    record["passes"] = sol.passes[-LAST_PASSES:]
    text = json.dumps(record).ljust(length)
    variable = file.createVariable("record", "c", ("step", "characters"))
    variable[0] = np.frombuffer(text.encode(), dtype="S1")
    file.flush()
    return buffer.getvalue(), int(file._recsize)


@contextmanager
def _file(path: Path) -> Iterator[Any]:
    """A file of ours, open; nothing of it is in memory but what is asked for."""
    from scipy.io import netcdf_file

    try:
        file = netcdf_file(path, "r", mmap=True)
    except (OSError, ValueError, TypeError, KeyError, IndexError, UnicodeDecodeError) as error:
        raise OutputError("path", path, f"cannot be read as netCDF ({first_line(error)})") from None
    try:
        yield _Header(file)
    finally:
        file.close()


class _Header:
    """Attributes of a file as text, and its variables."""

    def __init__(self, file: Any) -> None:
        self._file = file

    @property
    def variables(self) -> Any:
        return self._file.variables

    def __getattr__(self, name: str) -> str:
        return bytes(getattr(self._file, name)).decode()


def _stored(path: Path) -> Stored:
    """What is in a file."""
    with _file(path) as file:
        if getattr(file._file, "format", b"") != FORMAT.encode():
            raise OutputError("path", path, f"is not a {FORMAT!r} file")
        try:
            scene, plan = scene_from(json.loads(file.scene)), Plan.of_record(json.loads(file.plan))
            settings = json.loads(file.settings)
            if "start" in file.variables:
                start = solution_from_bytes(path, np.array(file.variables["start"][:]).tobytes())
                scene = replace(scene, motion=replace(_motion(scene), start=start))
        except (AttributeError, KeyError, TypeError, ValueError, VarcontactError) as error:
            raise OutputError("path", path, f"is damaged ({first_line(error)})") from None
    return Stored(path, scene, plan, settings)


def _identity(stored: Stored) -> str:
    """What has to be the same where a history goes on."""
    methods = {name: value for name, value in vars(stored.plan).items() if name != "reasons"}
    return json.dumps([scene_to(stored.scene), methods, stored.settings])


def _same_start(one: Scene, other: Scene) -> bool:
    first, second = _motion(one).start, _motion(other).start
    if first is None or second is None:
        return first is second
    fields = ("pressure", "traction")
    return all(np.array_equal(getattr(first, name), getattr(second, name)) for name in fields)


def _motion(scene: Scene) -> Transient:
    if not isinstance(scene.motion, Transient):
        raise SceneError("motion", scene.motion, "a Transient")
    return scene.motion


def _native(values: Any) -> np.ndarray:
    """A copy in the machine's own order of bytes."""
    array = np.array(values)
    return array.astype(array.dtype.newbyteorder("="))
