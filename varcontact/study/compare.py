"""Methods side by side on the same scenes, judged by the same measure, which belongs to none of
them.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from concurrent.futures import Executor
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
import pandas as pd

from varcontact import checks
from varcontact.errors import SceneError, VarcontactError
from varcontact.html import preformatted
from varcontact.results.quantities_of_interest import friction_limit
from varcontact.results.solution import Solution
from varcontact.scene.grid import Grid
from varcontact.scene.scene import Scene
from varcontact.solving.solve import solve
from varcontact.study.csv_table import Table, cell, columns_of_text, identity, of_another
from varcontact.study.methods import DEFAULT_METHODS, Method, attempted, figures, neighbour
from varcontact.study.parallel import Execution
from varcontact.study.parameters import named_scenes
from varcontact.system.progress import Progress

COLUMNS = (
    "scene", "method", "outcome", "reason", "Fx", "Fy", "Mz", "vx", "vy", "spin", "approach",
    "gap", "relative_gap", "residual", "force_bound", "force_distance", "traction_distance",
    "misclassified", "iterations", "normal_seconds", "tangential_seconds", "certificate_seconds",
    "setup_seconds", "repeat_seconds", "total_seconds", "calls", "identity"
)  # fmt: skip
STAGES = ("normal", "tangential", "certificate", "total")
WORDS = ("scene", "method", "outcome", "reason", "calls", "identity")
SHOWN = {
    "method": ("method", "s"),
    "outcome": ("outcome", "s"),
    "Fx": ("Fx", ".6g"),
    "Fy": ("Fy", ".6g"),
    "Mz": ("Mz", ".5g"),
    "rel. gap": ("relative_gap", ".0e"),
    "residual": ("residual", ".0e"),
    "force off": ("force_distance", ".0e"),
    "traction off": ("traction_distance", ".0e"),
    "areas off": ("misclassified", ".0f"),
    "iterations": ("iterations", ".0f"),
    "set-up s": ("setup_seconds", ".3f"),
    "repeat s": ("repeat_seconds", ".3f"),
    "calls": ("calls", "s"),
}
"""Headings of the printed table, with the columns under them and their format."""


@checks.named_options()
def compare(
    scenes: Scene | Mapping[str, Scene] | Sequence[Scene],
    methods: Iterable[str] = DEFAULT_METHODS,
    *,
    tol: float = 1e-6,
    store: str | Path | None = None,
    progress: Progress = None,
    accuracy: float | None = None,
    time_budget: float | None = None,
    executor: Executor | None = None,
    workers: int = 1,
    trace: bool = False,
) -> Comparison:
    """Solve scenes by many methods, and measure each answer.

    Parameters
    ----------
    scenes : Scene, or dict of str to Scene, or list of Scene
        One scene, or several by name (as `standard_bank()`); those of a list
        are named "0", "1", ...
    methods : iterable of str
        Each a `method` of `solve` ("conic", "convex", "active-set", "kalker",
        also with a formulation, as "conic/marching") or
        ``[normal|]tangential[/formulation][+polish]``: "tang", "clarabel/gap",
        "clarabel+polish", "osqp|scs". A single name stands for both problems
        where a normal problem has to be solved (with "norm" for "tang"); where
        Hertz's closed form applies, that is used. Without "+polish" the answer
        is the method's own.
    tol : float
        Natural-map residual at which an answer counts as solved.
    store : str or Path, optional
        A CSV file, written after each scene. Scenes that it holds are not
        solved again.
    progress : callable or true, optional
        Called with the scene.
    accuracy, time_budget : float, optional
        As in `solve`, for scenes without a grid of their own: they are
        compared on the grid that reaches this accuracy (1 %, if neither is
        given), or that is used within this time.
    executor, workers
        Where scenes are solved, as for `sweep`: each by one worker with all
        methods. The seconds are then those of processes that may share
        processors.
    trace : bool
        Whether to keep the iterates of the solvers, as `Comparison.traces`, see
        `plot_traces`; not of scenes that a store holds. Measuring takes several
        times as long as solving.

    Returns
    -------
    Comparison
        A pandas.DataFrame with one row per scene and method. `outcome` is
        "solved", "approximate" (a theory, or Hertz's pressure alone), "not
        converged", "refused" or "unavailable", `reason` why. Forces, moment,
        creepage and approach; gap, relative gap, residual and guaranteed bound
        on the force, all recomputed; distance of the force (relative to the
        friction limit) and of the tractions (relative to the largest traction
        bound) from the solution of the smallest residual on that scene, and the
        number of elements in another state than there; iterations; seconds by
        stage. `calls` lists the solvers called, and how often, as "normal: norm
        1; tangential: clarabel 1 + splitting 1". `repeat_seconds` are those of
        a second scene with creepages (or forces) one per cent smaller and
        everything reused that can be, `setup_seconds` the additional time of
        the first.

    Raises
    ------
    SceneError
        For a method that does not exist, a scene that is a history or a store
        of another study, before any work starts.
    OutputError
        If the store cannot be written, or another process writes to it.
    WorkersLost
        If the executor ends early.
    Interrupted
        By Ctrl-C; its `partial` is the table of the scenes that are finished.

    Examples
    --------
    >>> import varcontact as vc
    >>> scene = vc.Scene(
    ...     bodies=vc.Bodies(G=82e9, nu=0.28), surface=vc.Paraboloids(Rx=0.46, Ry=0.30),
    ...     normal_force=106.7e3, friction=0.33, motion=vc.Steady(vx=1e-3),
    ...     grid=vc.Grid(nx=10, ny=10))
    >>> table = vc.compare(scene, ["clarabel", "tang", "fastsim"])
    >>> table["outcome"].tolist(), bool((table["force_distance"] < [1e-6, 1e-6, 0.15]).all())
    (['solved', 'solved', 'approximate'], True)
    """
    tol = checks.positive("tol", tol)
    trace = checks.flag("trace", trace)
    execution = Execution(executor, workers, checks.progress(progress))
    named = {str(name): scene for name, scene in named_scenes(scenes).items()}
    chosen = _methods(methods)
    named = {name: _on_grid(scene, accuracy, time_budget) for name, scene in named.items()}

    def comparison(rows: list[dict[str, Any]]) -> Comparison:
        chosen_rows = [row for name in named for row in rows if row["scene"] == name]
        table = Comparison(chosen_rows, columns=list(COLUMNS))
        if trace:
            table.traces = _traces(chosen_rows)
        return table

    with Table.opened(store, COLUMNS, WORDS, "a table of an earlier comparison") as table:
        finished = _finished(table, named, chosen, tol)
        tasks = {
            name: (name, scene, chosen, tol, trace)
            for name, scene in named.items()
            if name not in finished
        }
        return table.fill(_rows, tasks, execution, comparison, len(named))


def _methods(names: Any) -> list[Method]:
    if isinstance(names, str) or not isinstance(names, Iterable):
        raise SceneError("methods", names, "a list of names")
    methods = [Method.named(name) for name in names]
    if not methods:
        raise SceneError("methods", [], "at least one")
    return methods


def _finished(
    table: Table, named: Mapping[str, Scene], methods: list[Method], tol: float
) -> set[str]:
    """Names of the scenes in a table, which must have these methods and be these scenes."""
    names = [method.name for method in methods]
    finished = {row["scene"]: row["identity"] for row in table.rows}
    for name, key in finished.items():
        if [row["method"] for row in table.rows if row["scene"] == name] != names:
            raise of_another(table.path, "compares other methods, or the same in another order")
        if name in named and identity(named[name], tol) != key:
            raise of_another(table.path, f"holds another scene named {name!r}")
    return set(finished)


def _on_grid(scene: Scene, accuracy: float | None, time_budget: float | None) -> Scene:
    """Scene on its own grid, or on one for an accuracy or a time; by default for 1 %."""
    by_default = accuracy is time_budget is None
    if isinstance(scene.grid, Grid) and by_default:
        return scene
    try:
        answer = solve(scene, certify=None, accuracy=accuracy, time_budget=time_budget)
    except VarcontactError:
        if by_default:  # each method's row says why
            return scene
        raise
    return answer.scene


def _traces(rows: list[dict[str, Any]]) -> dict[str, Any]:
    """Traces of rows by method, with the scene before it where there are several."""
    several = len({row["scene"] for row in rows}) > 1
    traces = {}
    for row in rows:
        name = row["method"]
        if several:
            name = f"{row['scene']}, {name}"
        if row.get("trace") is not None:
            traces[name] = row["trace"]
    return traces


def _rows(
    name: str, scene: Scene, methods: list[Method], tol: float, trace: bool
) -> list[dict[str, Any]]:
    """The rows of a scene by all methods, with distances from the solved answer of the smallest
    residual.
    """
    motion = scene.motion
    motions: list[Any] = [motion]
    if motion is not None:
        motions.append(neighbour(motion))
    attempts = [attempted(scene, method, tol, motions, trace) for method in methods]
    solved = [solutions[0] for outcome, _, solutions in attempts if outcome == "solved"]
    best = min(solved, key=lambda sol: sol.certificate.residual, default=None)
    rows = []
    for method, (outcome, reason, solutions) in zip(methods, attempts, strict=True):
        row: dict[str, Any] = {
            "scene": name,
            "method": method.name,
            "outcome": outcome,
            "reason": reason,
            "calls": "",
        }
        if solutions:
            row |= _measured(solutions, best)
            row["trace"] = solutions[0].trace
        rows.append(row | {"identity": identity(scene, tol)})
    return rows


def _measured(solutions: list[Solution], best: Solution | None) -> dict[str, Any]:
    """Figures of a solution, its cost, and its distance from the best answer on the same grid."""
    sol = solutions[0]
    seconds, *repeats = (
        each.timing.get("normal", 0.0) + each.timing.get("tangential", 0.0) for each in solutions
    )
    calls = {
        problem: " + ".join(f"{name} {n.count}" for name, n in each.items())
        for problem, each in sol.calls.items()
    }
    row: dict[str, Any] = {
        **figures(sol),
        "force_bound": float(np.max(sol.certificate.force_bound[:2])),
        **{f"{stage}_seconds": sol.timing.get(stage, 0.0) for stage in STAGES},
        "calls": "; ".join(f"{problem}: {count}" for problem, count in calls.items()),
    }
    if repeats:
        row["repeat_seconds"] = repeats[0]
        row["setup_seconds"] = max(seconds - repeats[0], 0.0)
    if best is None or vars(sol.grid) != vars(best.grid):
        return row
    return row | _distances(sol, best)


def _distances(sol: Solution, best: Solution) -> dict[str, Any]:
    """Distances of force and tractions from the best answer; without friction or slip that of the
    pressures.
    """
    row: dict[str, Any] = {"misclassified": int(np.sum(sol.state != best.state))}
    limit = friction_limit(best)
    if 0 < limit < np.inf:
        row["force_distance"] = float(np.hypot(*(sol.force - best.force)) / limit)
        largest = np.hypot(*(sol.traction - best.traction)).max()
        row["traction_distance"] = float(largest / best.traction_bound.max())
    else:
        largest = np.abs(sol.pressure - best.pressure).max()
        row["traction_distance"] = float(largest / best.pressure.max())
    return row


# pandas has no types
class Comparison(pd.DataFrame):  # type: ignore[misc]
    """A data frame with one row per scene and method, see `varcontact.compare`.

    Attributes
    ----------
    traces : dict of str to Dataset, or None
        Compared with ``trace=True``: the iterates of each method's solvers.

    Examples
    --------
    >>> import varcontact as vc
    >>> scene = vc.Scene(
    ...     bodies=vc.Bodies(G=82e9, nu=0.28), surface=vc.Paraboloids(Rx=0.46, Ry=0.30),
    ...     normal_force=106.7e3, friction=0.33, motion=vc.Steady(vx=1e-3),
    ...     grid=vc.Grid(nx=8, ny=8))
    >>> table = vc.compare(scene, ["tang", "fastsim"])
    >>> len(table[table["outcome"] == "solved"])
    1
    """

    _metadata: ClassVar = ["traces"]
    traces: dict[str, Any] | None = None

    @property
    def _constructor(self) -> Any:
        return Comparison

    def _repr_html_(self) -> str:
        """HTML of the `summary`; pandas' own if columns are missing."""
        if {"scene", *(name for name, _ in SHOWN.values())} <= set(self.columns):
            return preformatted(summary(self))
        frame: str = super()._repr_html_()
        return frame


def summary(table: pd.DataFrame) -> str:
    """A comparison as text: a block for each scene, then what was not solved and why."""
    blocks = []
    for scene, rows in table.groupby("scene", sort=False):
        records = rows.to_dict("records")
        cells = [[cell(row[name], form) for name, form in SHOWN.values()] for row in records]
        reasons = [f"  {row['method']}: {row['reason']}" for row in records if row["reason"]]
        blocks.append(
            "\n".join([str(scene), *columns_of_text([list(SHOWN), *cells], left=2), *reasons])
        )
    return "\n\n".join(blocks)
