"""Sweeps: many scenes, or a grid of parameters, on one machine or a cluster, into one store."""

from __future__ import annotations

import hashlib
import json
import threading
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import Executor
from contextlib import ExitStack
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from varcontact import checks
from varcontact.errors import Interrupted, NotConverged, SolverUnavailable, VarcontactError, WorkersLost
from varcontact.io.scene_toml import scene_to
from varcontact.io.sweep_file import (
    COUNTS,
    ERRORS,
    LONGEST_REASON,
    NUMBERS,
    OUTCOMES,
    SweepFile,
    blank,
    finished,
    read_sweep_file,
    record_type,
    sealed,
)
from varcontact.planning.plan import Plan
from varcontact.planning.roads import TOLERANCE
from varcontact.results.solution import Solution
from varcontact.scene.scene import Scene
from varcontact.solvers.registry import load_packages
from varcontact.solving import adaptive
from varcontact.solving.options import SolveOptions
from varcontact.solving.series import Series
from varcontact.solving.target import BY_DEFAULT
from varcontact.study.compare import carried
from varcontact.study.engine import CHUNK, opened, results
from varcontact.study.parameters import Swept
from varcontact.system.interrupts import imported

if TYPE_CHECKING:
    import xarray as xr


@dataclass(frozen=True)
class Standing:
    """How far a sweep is. As a string it is a line for people.

    Attributes
    ----------
    done, of, failed : int
        Scenes that are finished, in all, and how many of the finished ones are not solved.
    left : float or None
        Seconds that the rest will take; None before anything is known of it.

    Examples
    --------
    >>> print(Standing(120, 500, 2, 95.0))
    120 of 500 scenes, 2 not solved, 1:35 left
    """

    done: int
    of: int
    failed: int
    left: float | None = None

    def __str__(self) -> str:
        parts = [f"{self.done} of {self.of} scenes"]
        if self.failed:
            parts.append(f"{self.failed} not solved")
        if self.left is not None:
            minutes, seconds = divmod(round(self.left), 60)
            hours, minutes = divmod(minutes, 60)
            parts.append(f"{hours}:{minutes:02}:{seconds:02} left" if hours else f"{minutes}:{seconds:02} left")
        return ", ".join(parts)


def sweep(
    scenes: Scene | Sequence[Scene] | Mapping[str, Scene],
    over: Mapping[str, Any] | None = None,
    normal: str = "auto",
    tangential: str = "auto",
    coupling: str = "auto",
    *,
    formulation: str = "auto",
    method: str = "auto",
    tol: float = TOLERANCE,
    polish: bool | None = None,
    certify: str | None = "gap",
    chunk: int = CHUNK,
    executor: Executor | None = None,
    workers: int = 1,
    store: str | Path | None = None,
    progress: Callable[[Standing], None] | None = None,
    accuracy: float | None = None,
    time_budget: float | None = None,
) -> xr.Dataset:
    """Solve many scenes, in several processes or on a cluster if wanted, and collect their forces and certificates.

    Parameters
    ----------
    scenes : Scene, sequence of Scene, or mapping of str to Scene
        Of one problem each: no histories.
    over : mapping, optional
        Values by name of an entry, as in a scene file: ``{"motion.vx": [0.0, 1e-3], "friction": [0.2, 0.3]}``. Each
        scene is solved for all combinations.
    normal, tangential, coupling, formulation, method, tol, polish, certify
        As for `solve`, the same for all scenes; bounds on the forces only with `certify` = "full".
    chunk : int
        Scenes that one worker solves one after the other, each from the answers of those before: 1, each alone. The
        last of the entries in `over` varies fastest.
    executor : concurrent.futures.Executor, optional
        Where the scenes are solved: a pool of processes, MPI's, or that of a dask client (``client.get_executor()``).
        It stays open.
    workers : int
        Without an executor, how many processes; 1: this one alone.
    store : str or Path, optional
        A netCDF file (.nc) to which results are written as they come. Called again with the same scenes and settings,
        on any executor, the sweep goes on from there.
    progress : callable, optional
        Told a `Standing` after every chunk, which as a string says how far the sweep is and how long it will take.
    accuracy, time_budget : float, optional
        As for `solve`, of each scene. Scenes without a grid are solved to 1 % if neither is given.

    Returns
    -------
    xarray.Dataset
        Over the entries that vary, and over "scene" where several are given. `outcome` is "solved", "approximate" (by
        a theory), "not converged", "refused", "unavailable" or "failed", `reason` why; figures are NaN where there is
        no solution. Forces, moment, creepages (of a shift: shifts) and approach; gap and residual, and guaranteed
        bounds on the forces, NaN where they are left out; elements in contact, stick and slip; iterations. Of scenes
        solved to an accuracy, ``Fx_error`` and others are the error bars.

    Raises
    ------
    SceneError
        For scenes, entries or settings that cannot be treated, or if no scene suits the methods, before any work.
    OutputError
        If the store cannot be written, is of another sweep, or is being written by another run.
    WorkersLost
        If the executor ends early. Its `partial` is what is finished, and the store has it.
    Interrupted
        By Ctrl-C, likewise.

    Notes
    -----
    Scenes are cut into chunks in their order, whatever the executor. Only within a chunk do answers depend on the ones
    before, by less than `tol`. So a sweep gives the same digits here, in processes and on a cluster, and a store that
    was gone on with is, byte for byte, the store of a sweep that nothing ended early. What ends a sweep loses at most
    the chunks that are being solved.

    Examples
    --------
    >>> import varcontact as vc
    >>> scene = vc.Scene(
    ...     bodies=vc.Bodies(G=82e9, nu=0.28), surface=vc.Paraboloids(Rx=0.46, Ry=0.30), normal_force=106.7e3,
    ...     friction=0.33, motion=vc.Steady(), grid=vc.Grid(nx=12, ny=12))
    >>> swept = vc.sweep(scene, {"friction": [0.2, 0.4], "motion.vx": [0.5e-3, 1e-3, 4e-3]})
    >>> dict(swept.sizes), bool((swept["outcome"] == "solved").all())
    ({'friction': 2, 'motion.vx': 3}, True)
    >>> print((swept["Fx"] / 106.7e3).sel(friction=0.4).values.round(3))
    [-0.07  -0.133 -0.362]
    """
    swept = Swept.of(scenes, over)
    choices = normal, tangential, coupling, formulation, method
    solver = _Solver(choices, tol, polish, certify, accuracy, time_budget).checked(swept.scenes)
    chunk = checks.whole("chunk", chunk)
    checks.progress(progress)
    path = None if store is None else checks.file_name("store", store)
    with ExitStack() as held:
        pool = held.enter_context(opened(executor, workers))  # first: processes take a while to begin
        imported("xarray")  # now: after Ctrl-C it would be waited for
        described, file = _described(swept, solver, chunk), None
        if path is not None:
            file = held.enter_context(SweepFile.opened(path, described, len(swept.scenes)))
        records = blank(len(swept.scenes), solver.record) if file is None else file.records(len(swept.scenes))
        try:
            for _ in _swept(swept.scenes, records, solver, chunk, pool, executor is None, file, progress):
                pass
        except KeyboardInterrupt:
            raise Interrupted(_dataset(described, records), _so_far(records)) from None
        except WorkersLost as lost:
            lost.args = (f"{lost}{_so_far(records)}",)
            lost.partial = _dataset(described, records)
            raise
    return _dataset(described, records)


def read_sweep(path: str | Path) -> xr.Dataset:
    """The results in the store of a sweep, as far as it is, also while it goes on.

    Parameters
    ----------
    path : str or Path

    Returns
    -------
    xarray.Dataset
        As `sweep` gives it; `outcome` is empty where nothing is finished.

    Raises
    ------
    OutputError
        If the file holds no sweep.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> import varcontact as vc
    >>> folder = tempfile.TemporaryDirectory()
    >>> path = pathlib.Path(folder.name) / "sweep.nc"
    >>> scene = vc.Scene(
    ...     bodies=vc.Bodies(G=1.0, nu=0.3), surface=vc.Ellipse(a=1.0, b=1.0), normal_force=1.0, friction=0.3,
    ...     motion=vc.Steady(vx=0.1), grid=vc.Grid(nx=6, ny=6))
    >>> swept = vc.sweep(scene, {"motion.vx": [0.1, 0.2]}, store=path)
    >>> vc.read_sweep(path).identical(swept)
    True
    >>> folder.cleanup()
    """
    return _dataset(*read_sweep_file(checks.file_name("path", path)))


def _swept(
    scenes: Sequence[Scene],
    records: np.ndarray,
    solver: _Solver,
    chunk: int,
    pool: Executor | None,
    meanwhile: bool,
    file: SweepFile | None,
    progress: Callable[[Standing], None] | None,
) -> Iterator[None]:
    """Fill the records of the chunks that are not finished, one chunk at a time."""
    done = finished(records)
    firsts = [k for k in range(0, len(scenes), chunk) if not done[k : k + chunk].all()]
    for first in firsts:  # a chunk is solved as a whole
        records[first : first + chunk] = blank(len(records[first : first + chunk]), solver.record)
    tasks = [_Task(solver, tuple(scenes[first : first + chunk])) for first in firsts]
    begun, before = time.monotonic(), int(np.sum(records["outcome"] > 0))
    if progress is not None:
        progress(_standing(records, before, 0.0))
    for number, solved in results(_solved, tasks, pool, meanwhile):
        first = firsts[number]
        if file is not None:
            file.put(first, solved)
        records[first : first + len(solved)] = solved
        if progress is not None:
            progress(_standing(records, before, time.monotonic() - begun))
        yield


def _standing(records: np.ndarray, before: int, seconds: float) -> Standing:
    done, failed = int(np.sum(records["outcome"] > 0)), int(np.sum(records["outcome"] > OUTCOMES.index("approximate")))
    left = seconds / (done - before) * (len(records) - done) if done > before else None
    return Standing(done, len(records), failed, left)


def _so_far(records: np.ndarray) -> str:
    return f" after {np.sum(records['outcome'] > 0)} of {len(records)} scenes"


@dataclass(frozen=True)
class _Solver:
    """How all scenes are solved: arguments of `solve`."""

    choices: tuple[str, str, str, str, str]
    tol: float
    polish: bool | None
    certify: str | None
    accuracy: float | None = None
    time_budget: float | None = None
    default: bool = False  # whether scenes without a grid are solved to the default accuracy

    def options(self, scene: Scene) -> SolveOptions:
        """The options for a scene, checked."""
        rest: dict[str, Any] = {"accuracy": self.accuracy, "time_budget": self.time_budget}
        options = SolveOptions.checked(scene, *self.choices, self.tol, self.polish, certify=self.certify, **rest)
        load_packages(options.plan.normal, options.plan.tangential)
        return options

    def checked(self, scenes: Sequence[Scene]) -> _Solver:
        """The same, if it suits one of the scenes at least; else the error of the first."""
        first: VarcontactError | None = None
        for scene in scenes:
            try:
                known = self.options(scene)
            except VarcontactError as error:
                first = error if first is None else first
            else:
                default = known.plan.theory is None and any(scene.grid == "auto" for scene in scenes)
                return replace(self, tol=known.tol, polish=known.polish, certify=known.certify, default=default)
        assert first is not None
        raise first

    @property
    def record(self) -> np.dtype:
        """What there is of each scene."""
        return record_type(_rest(self))


@dataclass(frozen=True)
class _Task:
    """The scenes of a chunk, and how they are solved."""

    solver: _Solver
    scenes: tuple[Scene, ...]


_KEPT = threading.local()
"""Of each worker, the influence numbers of its last chunk: the next is mostly on the same lattice."""


def _solved(task: _Task) -> np.ndarray:
    """The records of a chunk of scenes; whatever happens to one of them stands in its record."""
    records, solver = blank(len(task.scenes), task.solver.record), task.solver
    series = Series(solver.tol, bool(solver.polish), str(solver.certify), operators=getattr(_KEPT, "operators", None))
    for record, scene in zip(records, task.scenes, strict=True):
        try:
            options = solver.options(scene)
            sol = series.solve(scene, options.plan) if options.target is None else adaptive.solve(scene, options)
            assert isinstance(sol, Solution)
            _note(record, sol, options.plan)
        except NotConverged as error:
            _failed(record, "not converged", str(error))
        except SolverUnavailable as error:
            _failed(record, "unavailable", str(error))
        except VarcontactError as error:
            _failed(record, "refused", str(error))
        except Exception as error:  # a sweep of days does not end with one scene
            _failed(record, "failed", f"{type(error).__name__}: {error}")
    series.forget()
    _KEPT.operators = series.operators
    return sealed(records)


def _note(record: np.void, sol: Solution, plan: Plan) -> None:
    """Put the figures of a solution into a record."""
    certificate = sol.certificate
    bound = certificate.force_bound if certificate.level == "full" else np.full(3, np.nan)
    figures = {
        **carried(sol),
        "normal_force": sol.normal_force,
        "approach": sol.approach,
        "gap": certificate.gap,
        "relative_gap": certificate.relative_gap,
        "residual": certificate.residual,
        **dict(zip(("Fx_bound", "Fy_bound", "Mz_bound"), bound, strict=True)),
        **sol.elements,
        "iterations": sum(sol.iterations.values()),
    }
    if sol.error_estimate is not None:
        figures |= {f"{name}_error": bar for name, bar in sol.error_estimate.bars.items()}
    for name in figures.keys() & set(record.dtype.names or ()):
        record[name] = figures[name]
    formula = plan.theory is not None or (not plan.rubs and plan.closed_form)
    record["outcome"] = OUTCOMES.index("approximate" if formula or plan.one_pass else "solved")


def _failed(record: np.void, outcome: str, reason: str) -> None:
    text = " ".join(reason.split()).encode()[:LONGEST_REASON].decode(errors="ignore")  # no half of a letter
    record["outcome"], record["reason"] = OUTCOMES.index(outcome), text.encode()


def _described(swept: Swept, solver: _Solver, chunk: int) -> dict[str, Any]:
    """What makes a sweep the same: its grid, its scenes, and how they are solved."""
    scenes = json.dumps([scene_to(scene) for scene in swept.scenes], sort_keys=True)
    units = {scene.units for scene in swept.scenes}
    unit = next(iter(units)) if len(units) == 1 else None
    line = any(scene.line for scene in swept.scenes)
    named = {} if unit is None else {kind: unit.of(kind, line) for kind in ("force", "length", "moment")}
    return {
        "coordinates": swept.coordinates,
        "scenes": hashlib.sha256(scenes.encode()).hexdigest()[:16],
        "settings": {**dict(zip(CHOICES, solver.choices, strict=True)), **_rest(solver), "chunk": chunk},
        "units": named,
    }


CHOICES = ("normal", "tangential", "coupling", "formulation", "method")


def _rest(solver: _Solver) -> dict[str, Any]:
    rest = {"tol": solver.tol, "polish": solver.polish, "certify": solver.certify}
    target = {"accuracy": solver.accuracy, "time_budget": solver.time_budget}
    if solver.default and solver.accuracy is solver.time_budget is None:
        target["accuracy"] = BY_DEFAULT
    return rest | {name: value for name, value in target.items() if value is not None}


def _dataset(described: Mapping[str, Any], records: np.ndarray) -> xr.Dataset:
    """Records as arrays over what varies."""
    import xarray as xr

    coordinates = described["coordinates"]
    dims, shape = tuple(coordinates), tuple(len(values) for values in coordinates.values())
    units = described["units"]
    columns: dict[str, tuple[Any, ...]] = {}
    for name, quantity in (NUMBERS | ERRORS).items():
        if name not in (records.dtype.names or ()):
            continue
        unit = {"units": units[quantity]} if units.get(quantity) else {}
        columns[name] = dims, records[name].astype(float).reshape(shape), unit
    for name in COUNTS:
        columns[name] = dims, records[name].astype(int).reshape(shape)
    words = {
        "outcome": np.array(OUTCOMES)[records["outcome"]],
        "reason": np.array([reason.decode() for reason in records["reason"]], dtype=str),
    }
    columns |= {name: (dims, values.reshape(shape)) for name, values in words.items()}
    settings = {name: value for name, value in described["settings"].items() if value is not None}
    columns = {name: column for name, column in columns.items() if name not in coordinates}  # a load that varies
    attributes = {name: int(value) if isinstance(value, bool) else value for name, value in settings.items()}
    return xr.Dataset(columns, coords=coordinates, attrs=attributes)
