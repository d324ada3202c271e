"""Sweeps: many scenes, or a grid of parameters, solved on one machine or a cluster into one
file.
"""

from __future__ import annotations

import hashlib
import json
import time
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Executor
from contextlib import ExitStack
from dataclasses import asdict, dataclass
from datetime import timedelta
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from varcontact import checks
from varcontact.errors import Interrupted, VarcontactError, WorkersLost
from varcontact.io.records import (
    LONGEST_REASON,
    blank,
    finished,
    read_sweep_file,
    record_type,
    sweep_file,
    tabulated,
)
from varcontact.io.scene_toml import scene_to
from varcontact.results.solution import Solution
from varcontact.scene.motion import Shift, Steady
from varcontact.scene.scene import Scene
from varcontact.solvers.registry import load_packages
from varcontact.solving import adaptive
from varcontact.solving.batched_to_accuracy import solve_batches
from varcontact.solving.methods import AUTO, CouplingName, FormulationName, MethodName, Methods
from varcontact.solving.options import (
    DEFAULT_ACCURACY,
    TOLERANCE,
    CertifyName,
    SolveOptions,
)
from varcontact.solving.warm_start import Series
from varcontact.study.methods import failure, figures, outcome
from varcontact.study.parallel import CHUNK, opened, results
from varcontact.study.parameters import scenes_over
from varcontact.system.process import imported

if TYPE_CHECKING:
    import xarray as xr

ENTRIES = {
    "normal_force": "force",
    "motion.Fx": "force",
    "motion.Fy": "force",
    "approach": "length",
    "motion.dq": "length",
    "motion.ux": "length",
    "motion.uy": "length",
    "grid.dx": "length",
    "grid.dy": "length",
    "surface.Rx": "length",
    "surface.Ry": "length",
    "surface.R": "length",
    "surface.a": "length",
    "surface.b": "length",
    "bodies.G": "pressure",
    "motion.spin": "spin",
    "friction": "1",
    "bodies.nu": "1",
    "motion.vx": "1",
    "motion.vy": "1",
    "motion.rotation": "1",
}
"""Quantities of entries that vary."""


@dataclass(frozen=True)
class Standing:
    """Progress of a sweep. As a string it is a line for people.

    Attributes
    ----------
    done, of, failed : int
        Number of finished scenes, of all scenes, and of finished ones that are
        not solved.
    left : float or None
        Estimated seconds left; None before the first scene is finished.

    Examples
    --------
    >>> print(Standing(120, 500, 2, 95.0))
    120 of 500 scenes, 2 not solved, 0:01:35 left
    """

    done: int
    of: int
    failed: int
    left: float | None = None

    def __str__(self) -> str:
        text = f"{self.done} of {self.of} scenes"
        if self.failed:
            text += f", {self.failed} not solved"
        if self.left is not None:
            text += f", {timedelta(seconds=round(self.left))} left"
        return text


@checks.named_options()
def sweep(
    scenes: Scene | Sequence[Scene] | Mapping[str, Scene],
    over: Mapping[str, Any] | None = None,
    normal: str = "auto",
    tangential: str = "auto",
    coupling: CouplingName = "auto",
    *,
    formulation: FormulationName = "auto",
    method: MethodName = "auto",
    methods: Methods | None = None,
    tol: float = TOLERANCE,
    polish: bool | None = None,
    certify: CertifyName | None = "gap",
    chunk: int = CHUNK,
    executor: Executor | None = None,
    workers: int = 1,
    store: str | Path | None = None,
    progress: Callable[[Standing], None] | bool | None = None,
    accuracy: float | None = None,
    time_budget: float | None = None,
) -> xr.Dataset:
    """Solve many scenes, in several processes or on a cluster if wanted, and
    collect their forces and certificates.

    Parameters
    ----------
    scenes : Scene, sequence of Scene, or mapping of str to Scene
        Scenes of one problem each: no histories.
    over : mapping, optional
        Values by name of an entry, as in a scene file:
        ``{"motion.vx": [0.0, 1e-3], "friction": [0.2, 0.3]}``. Each scene is
        solved for all combinations.
    normal, tangential, coupling, formulation, method, methods, tol, polish, certify
        As in `solve`, the same for all scenes; bounds on the forces only with
        `certify` = "full".
    chunk : int
        Number of scenes that one worker solves one after the other, each with
        the answers before as initial guesses; with 1, each alone. The last of
        the entries in `over` varies fastest.
    executor : concurrent.futures.Executor, optional
        Where the scenes are solved: a pool of processes, MPI's, or that of a
        dask client (``client.get_executor()``). It stays open.
    workers : int
        Without an executor, the number of processes; 1: this one alone.
    store : str or Path, optional
        A netCDF file (.nc) to which results are written as they come, which
        `xarray.open_dataset` opens at any time. Called again with the same
        scenes and settings, on any executor, the sweep resumes from it.
    progress : callable or true, optional
        Called with a `Standing` after every chunk, which as a string says how
        many scenes are done and the time left.
    accuracy, time_budget : float, optional
        As in `solve`, for each scene. Scenes without a grid are solved to 1 %
        if neither is given.

    Returns
    -------
    xarray.Dataset
        Over the entries that vary, and over "scene" where several are given.
        `outcome` is "solved", "approximate" (by a theory), "not converged",
        "refused", "unavailable" or "failed", `reason` why; figures are NaN
        where there is no solution. Forces, moment, creepages (of a shift:
        shifts) and approach; numbers of elements in contact, stick and slip,
        and their areas (`slip_area`); `max_pressure` and `friction_work`, as of
        a `Solution`; gap and residual, and guaranteed bounds on the forces, NaN
        where they are left out; iterations. Of scenes solved to an accuracy,
        ``Fx_error`` and others are the error bars. With the units that all
        scenes have in common.

    Raises
    ------
    SceneError
        For scenes, entries or settings that cannot be treated, or if no scene
        suits the methods, before any work.
    OutputError
        If the store cannot be written, is of another sweep, or is being written
        by another process.
    WorkersLost
        If the executor ends early. Its `partial` is what is finished, and the
        store has it.
    Interrupted
        By Ctrl-C, likewise.

    Notes
    -----
    Scenes are cut into chunks in their order, whatever the executor. Only within a chunk do answers
    depend on the ones before, by less than `tol`. So a sweep gives the same digits here, in
    processes and on a cluster, and a resumed sweep gives a file identical, byte for byte, to an
    uninterrupted one. An interruption loses at most the chunks that are being solved.

    Examples
    --------
    >>> import varcontact as vc
    >>> scene = vc.Scene(
    ...     bodies=vc.Bodies(G=82e9, nu=0.28), surface=vc.Paraboloids(Rx=0.46, Ry=0.30),
    ...     normal_force=106.7e3, friction=0.33, motion=vc.Steady(), grid=vc.Grid(nx=12, ny=12))
    >>> swept = vc.sweep(scene, {"friction": [0.2, 0.4], "motion.vx": [0.5e-3, 1e-3, 4e-3]})
    >>> dict(swept.sizes), bool((swept["outcome"] == "solved").all())
    ({'friction': 2, 'motion.vx': 3}, True)
    >>> print((swept["Fx"] / 106.7e3).sel(friction=0.4).values.round(3))
    [-0.07  -0.133 -0.362]
    """
    varied, every = scenes_over(scenes, over)
    named = Methods.given(
        methods,
        normal=normal,
        tangential=tangential,
        coupling=coupling,
        formulation=formulation,
        method=method,
    )
    options: dict[str, Any] = {
        "methods": named,
        "tol": tol,
        "polish": polish,
        "certify": certify,
        "accuracy": accuracy,
        "time_budget": time_budget,
    }
    settings = _settings(options, every)
    options |= {name: settings[name] for name in ("tol", "polish", "certify")}
    chunk = checks.whole("chunk", chunk)
    report = checks.progress(progress)
    path = None if store is None else checks.file_name("store", store)
    with ExitStack() as held:
        pool = held.enter_context(opened(executor, workers))
        imported("xarray")  # imported now: after Ctrl-C the import would have to be waited for
        coordinates, described = _described(varied, every, {**settings, "chunk": chunk})
        records = blank(len(every), record_type(settings, coordinates))
        put = None
        if path is not None:
            records, put = held.enter_context(sweep_file(path, records, coordinates, described))
        done = finished(records)
        firsts = [k for k in range(0, len(records), chunk) if not done[k : k + chunk].all()]
        for first in firsts:  # a chunk is solved as a whole
            records[first : first + chunk] = blank(1, records.dtype)
        tasks = {first: (options, records.dtype, every[first : first + chunk]) for first in firsts}
        started = time.monotonic()
        stored = int(np.count_nonzero(records["outcome"]))
        try:
            report(_standing(records, stored, 0.0))
            for first, chunk_records in results(_solve_chunk, tasks, pool):
                if put is not None:
                    put(first, chunk_records)
                records[first : first + len(chunk_records)] = chunk_records
                report(_standing(records, stored, time.monotonic() - started))
        except (KeyboardInterrupt, WorkersLost) as stopped:
            partial = tabulated(records, coordinates, described)
            so_far = f" after {np.count_nonzero(records['outcome'])} of {len(records)} scenes"
            if isinstance(stopped, KeyboardInterrupt):
                raise Interrupted(partial, so_far) from None
            stopped.args = (f"{stopped}{so_far}",)
            stopped.partial = partial
            raise
    return tabulated(records, coordinates, described)


@checks.named_options()
def read_sweep(path: str | Path) -> xr.Dataset:
    """The results in the store of a sweep, also while it is running.

    Parameters
    ----------
    path : str or Path

    Returns
    -------
    xarray.Dataset
        Dataset as returned by `sweep`; `outcome` is empty where nothing is finished.

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
    ...     bodies=vc.Bodies(G=1.0, nu=0.3), surface=vc.Ellipse(a=1.0, b=1.0), normal_force=1.0,
    ...     friction=0.3, motion=vc.Steady(vx=0.1), grid=vc.Grid(nx=6, ny=6))
    >>> swept = vc.sweep(scene, {"motion.vx": [0.1, 0.2]}, store=path)
    >>> vc.read_sweep(path).identical(swept)
    True
    >>> folder.cleanup()
    """
    return tabulated(*read_sweep_file(checks.file_name("path", path)))


def _standing(records: np.ndarray, stored: int, seconds: float) -> Standing:
    """Progress after some seconds, of which the first `stored` records took none."""
    done = int(np.count_nonzero(records["outcome"]))
    failed = done - int(np.count_nonzero(np.isin(records["outcome"], [b"solved", b"approximate"])))
    left = None
    if done > stored:
        left = seconds / (done - stored) * (len(records) - done)
    return Standing(done, len(records), failed, left)


def _settings(options: dict[str, Any], scenes: Sequence[Scene]) -> dict[str, Any]:
    """The settings of the sweep, if they suit one of the scenes at least; else the error of the
    first.
    """
    errors: list[VarcontactError] = []
    for scene in scenes:
        try:
            checked = _checked(scene, options)
        except VarcontactError as error:
            errors.append(error)
            continue
        settings = asdict(options["methods"]) | options
        del settings["methods"]  # in files they are by their names
        settings["tol"] = checked.tol
        settings["polish"] = checked.polish
        settings["certify"] = checked.certify
        goals = {name: settings.pop(name) for name in ("accuracy", "time_budget")}
        without_grid = any(scene.grid == "auto" for scene in scenes)
        if checked.plan.theory is None and without_grid and not any(goals.values()):
            goals["accuracy"] = DEFAULT_ACCURACY
        return settings | {name: value for name, value in goals.items() if value is not None}
    raise errors[0]


def _checked(scene: Scene, options: dict[str, Any]) -> SolveOptions:
    """The options for a scene, whose solvers are installed."""
    checked = SolveOptions.checked(scene, **options)
    load_packages(checked.plan.normal, checked.plan.tangential)
    return checked


def _solve_chunk(options: dict[str, Any], dtype: np.dtype, scenes: Sequence[Scene]) -> np.ndarray:
    """The records of a chunk of scenes, with the errors of those that fail: in batches by default,
    else in turn.
    """
    records = blank(len(scenes), dtype)
    done = _solve_in_batches(options, records, scenes)
    series = Series(options["tol"], options["polish"], options["certify"])
    for k in np.flatnonzero(~done).tolist():
        try:
            solution, solved_as = _solve_in_turn(options, series, scenes[k])
            _enter(records, k, figures(solution))
            records["outcome"][k] = solved_as
        except Exception as error:  # a sweep of days does not end with the error of one scene
            _enter_failure(records, k, error)
    return records


def _solve_in_batches(
    options: dict[str, Any], records: np.ndarray, scenes: Sequence[Scene]
) -> np.ndarray:
    """Enter the figures of the scenes that batches solve, if all methods are the default; True for
    these.
    """
    by_default = options["methods"] == AUTO
    certify = options["certify"]
    if not by_default or options["time_budget"] is not None or certify not in ("gap", "none"):
        return np.zeros(len(scenes), bool)
    columns, done = solve_batches(scenes, options["tol"], options["accuracy"])
    left_out = {"gap", "relative_gap"} if certify == "none" else set()
    for name in set(records.dtype.names or ()) & columns.keys() - left_out:
        records[name][done] = columns[name][done]
    records["outcome"][done] = b"solved"
    return done


def _solve_in_turn(options: dict[str, Any], series: Series, scene: Scene) -> tuple[Solution, str]:
    """The solution of a scene, and its outcome."""
    checked = _checked(scene, options)
    if checked.target is not None:
        solution = adaptive.solve(scene, checked)
    else:
        solution = series.solve(scene, checked.plan)
    assert isinstance(solution, Solution)
    return solution, outcome(checked.plan)


def _enter(records: np.ndarray, k: int, values: Mapping[str, Any]) -> None:
    """Enter figures into record k, as far as it has columns for them."""
    for name in set(records.dtype.names or ()) & values.keys():
        records[name][k] = values[name]


def _enter_failure(records: np.ndarray, k: int, error: Exception) -> None:
    """Enter the outcome and the reason of an error into record k."""
    records["outcome"][k] = "failed"
    reason = f"{type(error).__name__}: {error}"
    if isinstance(error, VarcontactError):
        records["outcome"][k] = failure(error)
        reason = str(error)
    # cut to the column, between characters
    cut = " ".join(reason.split()).encode()[:LONGEST_REASON].decode(errors="ignore")
    records["reason"][k] = cut.encode()


def _described(
    varied: dict[str, list[Any]], scenes: list[Scene], settings: dict[str, Any]
) -> tuple[xr.Coordinates, dict[str, Any]]:
    """Coordinates; and the settings that distinguish a sweep from others, with the units that all
    scenes have in common.
    """
    import xarray as xr

    units = _common_units(scenes)
    columns = {}
    for name, values in varied.items():
        quantity = ENTRIES.get(name)
        columns[name] = (name, values, {"units": units[quantity]} if quantity in units else {})
    content = json.dumps([varied, *(scene_to(scene) for scene in scenes)], sort_keys=True)
    digest = hashlib.sha256(content.encode()).hexdigest()[:16]
    return xr.Dataset(coords=columns).coords, {
        "scenes": digest,
        "settings": settings,
        "units": units,
    }


def _common_units(scenes: list[Scene]) -> dict[str, str]:
    """Units by quantity, as far as all scenes have them in common."""
    systems = {scene.units for scene in scenes}
    system = systems.pop()
    if systems or system is None:
        return {}
    motions = {type(scene.motion) for scene in scenes}
    shift = motions == {Shift}
    quantities = ["force", "length", "moment", "pressure", "area", "spin", "1"]
    if shift or motions == {Steady}:
        quantities += ["creepage", "spin creepage", "work"]
    line = any(scene.line for scene in scenes)
    return {each: system.of(each, line, shift) for each in quantities}
