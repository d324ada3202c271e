"""Histories as files to which steps are added.

A step is written behind the last one and forced to the disk, and only then
counted: whatever ends the program in between, and whoever reads beside it, the
file holds every finished step and no other. Nothing else of the file changes,
and nothing of it is kept in memory.
"""

from __future__ import annotations

import json
import operator
import os
import shutil
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING, Any, BinaryIO

import numpy as np

from varcontact import checks
from varcontact.errors import OutputError, SceneError
from varcontact.io.records import (
    COUNT_AT,
    EARLIER_HISTORIES,
    HISTORY_FORMAT,
    MAGIC,
    NOT_AS_WRITTEN,
    SERIES,
    Layout,
    check_steps,
    checked_layout,
    history_to_bytes,
    layout_of,
    step_to_bytes,
)
from varcontact.io.scene_toml import scene_from, scene_to
from varcontact.io.solution import (
    AS_STORED,
    READ,
    SIZES,
    assembled,
    refuse_corrected,
    solution_from_bytes,
)
from varcontact.results.history import History
from varcontact.results.plan import Plan
from varcontact.results.solution import Solution
from varcontact.scene.grid import Grid
from varcontact.scene.scene import Scene
from varcontact.scene.transient import Transient
from varcontact.system import files

if TYPE_CHECKING:
    import xarray as xr


@dataclass(frozen=True, eq=False)
class Stored(Sequence[Solution]):
    """The steps of a history in a file."""

    path: Path
    scene: Scene
    plan: Plan
    settings: dict[str, Any]  # tolerance and polish
    measured: Callable[[int, Solution | None, Solution], Solution] | None = None

    @classmethod
    @contextmanager
    def recording(
        cls, path: Path, scene: Scene, plan: Plan, settings: dict[str, Any]
    ) -> Iterator[Stored]:
        """Open a file for appending, exclusively: a new one, or one with the first steps of the
        same history.
        """
        files.check_writable("store", path, (".nc",))
        stored = cls(path, scene, plan, settings)
        with files.only_writer("store", path):
            if path.exists() and path.stat().st_size > 0:
                if not files.begins_with(path, MAGIC):
                    raise OutputError("store", path, "exists already and holds no history")
                other = cls.read(path)
                if not _is_of_today(path):
                    raise OutputError(
                        "store",
                        path,
                        "was written by an earlier version, and can only be read; name a new file",
                    )
                if _identity(stored) != _identity(other):
                    raise OutputError(
                        "store", path, "holds the history of another scene, or by other methods"
                    )
                other.check()
            yield stored

    @classmethod
    def read(cls, path: Path) -> Stored:
        """Steps of an existing file."""
        with _file(path) as file:
            form = getattr(file, "format", b"").decode(errors="replace")
            if form not in (HISTORY_FORMAT, *EARLIER_HISTORIES):
                raise OutputError("path", path, f"is not a {HISTORY_FORMAT!r} file")
            refuse_corrected(path, file.variables)
            with files.reading(path):
                if form != EARLIER_HISTORIES[0] and _layout(path) is None:
                    raise ValueError(NOT_AS_WRITTEN)
                scene = scene_from(_entry(file, "scene"))
                plan = Plan.of_record(_entry(file, "plan"))
                settings = _entry(file, "settings")
                settings["tol"] = checks.positive("tol", settings["tol"])
                settings["polish"] = checks.flag("polish", settings["polish"])
                motion = scene.motion
                if not isinstance(motion, Transient):
                    raise ValueError("steps of another motion than a Transient")
                if "start" in file.variables:
                    start = solution_from_bytes(
                        path, np.array(file.variables["start"][:]).tobytes()
                    )
                    scene = replace(scene, motion=replace(motion, start=start))
        return cls(path, scene, plan, settings)

    @property
    def grid(self) -> Grid:
        """The grid of all steps."""
        with _file(self.path) as file, files.reading(self.path):
            return Grid(**_entry(file, "grid"))

    def __len__(self) -> int:
        if not self.path.exists():
            return 0
        layout = _layout_by_header(self.path)
        count = _count(self.path)
        size = self.path.stat().st_size
        if layout is not None:
            # after the complete steps there may be a part of the next one; other processes may add
            # steps
            most = layout.begin + (_count(self.path) + 1) * layout.size
            if not layout.begin + count * layout.size <= size <= most:
                raise OutputError(
                    "path", self.path, f"is damaged (it has not the size of {count} steps)"
                )
        return count

    def __getitem__(self, k: Any) -> Any:
        """A step; it is `History` that takes slices."""
        k = range(len(self))[operator.index(k)]
        sol = self._read(k)
        if self.measured is None:
            return replace(sol, note=AS_STORED)
        before = self._read(k - 1) if k > 0 else None
        impossible = ValueError, SceneError
        with files.reading(self.path, f"is damaged in step {k}", errors=impossible):
            return self.measured(k, before, sol)

    def check(self, steps: Iterable[int] | None = None) -> None:
        """Refuse a file in which one of the `steps`, all by default, has other bytes than were
        written.
        """
        layout = _layout(self.path)
        if layout is not None:
            with files.reading(self.path, "cannot be read"):
                check_steps(self.path, layout, range(len(self)) if steps is None else steps)

    def _read(self, k: int) -> Solution:
        self.check([k])
        with _file(self.path) as file, files.reading(self.path, f"is damaged in step {k}"):
            grid = Grid(**_entry(file, "grid"))
            found = {
                name: _native(file.variables[name][k]) for name in READ if name in file.variables
            }
            record = json.loads(file.variables["record"][k].tobytes())
            return assembled(self.scene.step(k, grid), grid, self.plan, found, record)

    def series(self, name: str) -> np.ndarray:
        """A number or a few of each step, those called `name` in the file."""
        if len(self) == 0:
            return np.zeros([0, *(SIZES[dim] for dim in SERIES[name][0])])
        self.check()
        with _file(self.path) as file, files.reading(self.path):
            if name != "friction_work" or "power_density" in file.variables:
                return _native(file.variables[name][:])
        # an earlier version's was of another slip
        return np.array([sol.friction_work for sol in self])

    def put(self, k: int, sol: Solution) -> None:
        """Add the next step."""
        count = len(self)
        if count != k:
            reason = (
                f"has {count} steps where this run has written {k}: something else has changed it"
            )
            raise OutputError("store", self.path, reason)
        if k == 0:
            with files.replacing("store", self.path) as file:
                file.write(history_to_bytes(self.scene, self.plan, self.settings, sol))
            return
        layout = _layout_by_header(self.path)
        assert layout is not None
        step = step_to_bytes(self.scene, self.plan, sol)
        with files.writing("store", self.path), self.path.open("r+b") as file:
            file.seek(layout.begin + k * layout.size)
            file.write(step)
            file.truncate()
            file.flush()
            os.fsync(file.fileno())
            file.seek(COUNT_AT)
            file.write((k + 1).to_bytes(4, "big"))


def save(history: History, path: str | Path, overwrite: bool = False) -> None:
    """Write a history to a file atomically."""
    path = checks.file_name("path", path)
    check_history_file("path", path, overwrite)
    if len(history) == 0:
        raise OutputError("path", path, "no step of the history is finished")
    with files.only_writer("path", path, files.PATIENCE), files.replacing("path", path) as file:
        _write(history, file)


def check_history_file(field: str, path: Path, overwrite: bool) -> None:
    """Refuse a file to which no history may be written, see `save`."""
    files.check_replaceable(
        field, path, (".nc",), "history", MAGIC + b".*varcontact history ", overwrite
    )


def dataset(history: History) -> xr.Dataset:
    """A `history` as an xarray dataset, see `History.to_xarray`."""
    import xarray as xr

    if len(history) == 0:
        raise OutputError("history", "to_xarray", "no step of the history is finished")
    steps = history.solutions
    source: Path | BytesIO
    if isinstance(steps, Stored):  # data are read only on request
        steps.check()
        source = steps.path
    else:
        source = BytesIO()
        _write(history, source)
        source.seek(0)
    data = xr.open_dataset(source, engine="scipy")
    data = data.drop_vars(["start", "check"], errors="ignore")
    words = {name: data[name].astype(str).values for name in ("component", "rigid")}
    places = {"step": np.arange(len(history)), "rolled": ("step", history.rolled)}
    return data.assign_coords(words | places)


def _write(history: History, file: BinaryIO) -> None:
    """Write the whole file, of which no more than a step is in memory at a time."""
    steps = history.solutions
    if isinstance(steps, Stored):
        with steps.path.open("rb") as source:
            shutil.copyfileobj(source, file)
        return
    plan = steps[0].plan
    file.write(history_to_bytes(history.scene, plan, history.settings, steps[0]))
    for step in steps[1:]:
        file.write(step_to_bytes(history.scene, plan, step))
    file.seek(COUNT_AT)
    file.write(len(steps).to_bytes(4, "big"))


def _is_of_today(path: Path) -> bool:
    """True for a file in the current format, to which steps can be added."""
    with _file(path) as file:
        return bool(getattr(file, "format", b"").decode(errors="replace") == HISTORY_FORMAT)


def _layout_by_header(path: Path) -> Layout | None:
    """Layout of the steps from the header, without a check, as a step is added without reading
    the whole header; None for the first format.
    """
    with files.reading(path, "cannot be read"):
        return layout_of(path)


def _layout(path: Path) -> Layout | None:
    """Layout of the steps in a file, after a check of its header; None for the first format."""
    with files.reading(path, "cannot be read"):
        return checked_layout(path)


def _count(path: Path) -> int:
    """The number of steps in a file."""
    with files.reading(path, "cannot be read"), path.open("rb") as file:
        file.seek(COUNT_AT)
        return int.from_bytes(file.read(4), "big")


@contextmanager
def _file(path: Path) -> Iterator[Any]:
    """Open history file with a verified header; data are read only on request."""
    from scipy.io import netcdf_file

    _layout(path)
    # scipy maps the file before it reads the number of steps: one may be added in between
    for left in reversed(range(10)):
        try:
            file = netcdf_file(path, "r", mmap=True)
            break
        except Exception as error:  # scipy may raise anything for damaged bytes
            if left == 0:
                raise OutputError(
                    "path", path, f"cannot be read as netCDF ({files.first_line(error)})"
                ) from None
    with file:
        yield file


def _entry(file: Any, name: str) -> Any:
    return json.loads(bytes(getattr(file, name)).decode())


def _identity(stored: Stored) -> tuple[str, bytes]:
    """Data that must agree for a history to be continued: scene, methods and settings, and the
    initial state of the bodies.
    """
    methods = {name: value for name, value in stored.plan.record().items() if name != "reasons"}
    start = getattr(stored.scene.motion, "start", None)
    known = []
    if start is not None:
        carried = [start.carried[name] for name in sorted(start.carried)]
        known = [start.pressure, start.traction, *carried]
    fields = b"".join((each + 0.0).tobytes() for each in known)
    return json.dumps([scene_to(stored.scene), methods, stored.settings]), fields


def _native(values: Any) -> np.ndarray:
    """A copy in the machine's own order of bytes."""
    return np.array(values, dtype=values.dtype.newbyteorder("="))
