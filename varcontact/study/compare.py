"""Methods side by side on the same scenes, judged by the same measure, which belongs to none of them."""

from __future__ import annotations

import json
import zipfile
from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from varcontact import checks
from varcontact.errors import Interrupted, SceneError, VarcontactError
from varcontact.html import html_table
from varcontact.results.solution import Solution
from varcontact.scene.grid import Grid
from varcontact.scene.motion import TimeStep, Transient
from varcontact.scene.scene import Scene
from varcontact.solving.solve import solve
from varcontact.study.csv_table import Table, cell, columns_of_text, identity
from varcontact.study.methods import DEFAULT_METHODS, Method, attempted, figures, neighbour
from varcontact.study.parallel import opened, results
from varcontact.system.files import beside, clear, replacing

COLUMNS = (
    "scene", "method", "outcome", "reason", "Fx", "Fy", "Mz", "vx", "vy", "spin", "approach", "gap",
    "relative_gap", "residual", "force_bound", "force_distance", "traction_distance", "misclassified",
    "iterations", "normal_seconds", "tangential_seconds", "certificate_seconds", "setup_seconds",
    "repeat_seconds", "total_seconds", "calls", "identity"
)  # fmt: skip
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


def compare(
    scenes: Scene | Mapping[str, Scene] | Sequence[Scene],
    methods: Iterable[str] = DEFAULT_METHODS,
    *,
    tol: float = 1e-6,
    store: str | Path | None = None,
    progress: Callable[[str], None] | None = None,
    accuracy: float | None = None,
    time_budget: float | None = None,
    executor: Executor | None = None,
    workers: int = 1,
) -> Comparison:
    """Solve scenes by many methods, and measure each answer.

    Parameters
    ----------
    scenes : Scene, or dict of str to Scene, or list of Scene
        One scene, or several by name (as `standard_bank()`); those of a list are named "0", "1", ...
    methods : iterable of str
        Each a `method` of `solve` ("convex", "active-set", "kalker", also with a formulation, as "convex/marching") or
        ``[normal|]tangential[/formulation][+polish]``: "tang", "clarabel/gap", "clarabel+polish", "osqp|scs". A single
        name stands for both problems where a normal problem has to be solved (with "norm" for "tang"); where Hertz's
        closed form applies, that is used. Without "+polish" the answer is the method's own.
    tol : float
        Natural-map residual at which an answer counts as solved.
    store : str or Path, optional
        A CSV file, written after each method. Scenes and methods that it holds are not solved again.
    progress : callable, optional
        Called with scene and method.
    accuracy, time_budget : float, optional
        As for `solve`, for scenes without a grid of their own: they are compared on the grid that reaches this accuracy
        (1 %, if neither is given), or that is used within this time.
    executor, workers
        Where scenes are solved, as for `sweep`: each by one worker with all methods. The seconds are then those of
        processes that may share processors, and progress is called with finished scenes.

    Returns
    -------
    Comparison
        A pandas.DataFrame with one row per scene and method. `outcome` is "solved", "approximate" (a theory, or
        Hertz's pressure alone), "not converged", "refused" or "unavailable", `reason` why. Forces, moment, creepage and
        approach; gap, relative gap, residual and guaranteed bound on the force, all recomputed; distance of the force
        (relative to the friction limit) and of the tractions (relative to the largest traction bound) from the solution
        of the smallest residual on that scene, and the number of elements in another state than there; iterations;
        seconds by stage. `calls` lists the solvers called, and how often, as "normal: norm 1; tangential: clarabel 1 +
        splitting 1". `repeat_seconds` are those of a second scene with creepages (or forces) one per cent smaller and
        everything reused that can be, `setup_seconds` the additional time of the first.

    Raises
    ------
    SceneError
        For a method that does not exist, a scene that is a history or a store of another study, before any work starts.
    OutputError
        If the store cannot be written, or another process writes to it.
    WorkersLost
        If the executor ends early.
    Interrupted
        By Ctrl-C; its `partial` is the table of what is finished. The distances of a scene come with its last method.

    Examples
    --------
    >>> import varcontact as vc
    >>> scene = vc.Scene(
    ...     bodies=vc.Bodies(G=82e9, nu=0.28), surface=vc.Paraboloids(Rx=0.46, Ry=0.30), normal_force=106.7e3,
    ...     friction=0.33, motion=vc.Steady(vx=1e-3), grid=vc.Grid(nx=10, ny=10))
    >>> table = vc.compare(scene, ["clarabel", "tang", "fastsim"])
    >>> table["outcome"].tolist(), bool((table["force_distance"] < [1e-6, 1e-6, 0.15]).all())
    (['solved', 'solved', 'approximate'], True)
    """
    tol, progress = checks.positive("tol", tol), checks.progress(progress)
    named = _named(scenes)
    if isinstance(methods, str) or not isinstance(methods, Iterable):
        raise SceneError("methods", methods, "a list of names")
    chosen = [Method.named(method) for method in methods]
    if not chosen or not named:
        empty = "methods" if named else "scenes"
        raise SceneError(empty, [], "at least one")
    named = {name: _on_grid(scene, accuracy, time_budget) for name, scene in named.items()}
    with Table.opened(store, COLUMNS, WORDS, "a table of an earlier comparison") as table:
        comparison = _Comparison(table, chosen, tol, progress)
        comparison.check_same({name: identity(scene, tol) for name, scene in named.items()})
        try:
            with opened(executor, workers) as pool:
                if pool is None:
                    for name, scene in named.items():
                        comparison.solve(name, scene)
                else:  # of scenes that were begun nothing is reused
                    finished = comparison.finished()
                    tasks = [(name, scene, chosen, tol) for name, scene in named.items() if name not in finished]
                    stages = [f"{name}: all methods" for name, *_ in tasks]
                    for _, rows in results(_rows_of_scene, tasks, pool, progress=progress, names=stages):
                        comparison.put(rows)
        except KeyboardInterrupt:
            done = comparison.finished() & set(named)
            started = max((len(comparison.rows(name)) for name in set(named) - done), default=0)
            part = f" and {started} of {len(chosen)} methods of the next" if started else ""
            finished_part = f" after {len(done)} of {len(named)} scenes{part}"
            raise Interrupted(comparison.result(named), finished_part) from None
        if table.path is not None and comparison.finished() == {row["scene"] for row in table.rows}:
            forget_answers(table.path)
        return comparison.result(named)


def _named(scenes: Scene | Mapping[str, Scene] | Sequence[Scene]) -> dict[str, Scene]:
    if isinstance(scenes, Scene):
        named = {"scene": scenes}
    elif isinstance(scenes, Mapping):
        named = dict(scenes)
    elif isinstance(scenes, list | tuple):
        named = {str(i): scene for i, scene in enumerate(scenes)}
    else:
        raise SceneError("scenes", scenes, "a Scene, a list of them, or a dict of them by name")
    for name, scene in named.items():
        if not isinstance(name, str):
            raise SceneError("scenes", name, "named by strings")
        if not isinstance(scene, Scene):
            raise SceneError(f"scenes[{name!r}]", scene, "a Scene")
        if isinstance(scene.motion, Transient | TimeStep):
            allowed = "Steady, Shift or none"
            message = f"scene {name!r} is a history: methods are compared on one problem (motion {allowed})"
            raise SceneError(f"motion of scene {name!r}", type(scene.motion).__name__, allowed, message=message)
    return named


def _on_grid(scene: Scene, accuracy: float | None, time_budget: float | None) -> Scene:
    """A scene on its own grid, or on that of an accuracy or a time; by default 1 %."""
    if isinstance(scene.grid, Grid) and accuracy is time_budget is None:
        return scene
    try:
        answer = solve(scene, certify=None, accuracy=accuracy, time_budget=time_budget)
    except VarcontactError:
        if accuracy is time_budget is None:  # each method's row says why
            return scene
        raise
    assert isinstance(answer, Solution)
    return answer.scene


@dataclass(frozen=True)
class _Comparison:
    """A table of scenes by the same methods, written after each method."""

    kept: Table
    methods: list[Method]
    tol: float
    progress: Callable[[str], None] | None = None

    def rows(self, name: str) -> list[dict[str, Any]]:
        return [row for row in self.kept.rows if row["scene"] == name]

    def finished(self) -> set[str]:
        """Scenes with rows by all methods."""
        counts = Counter(row["scene"] for row in self.kept.rows)
        return {scene for scene, count in counts.items() if count == len(self.methods)}

    def result(self, names: Iterable[str]) -> Comparison:
        """The rows of some scenes, in their order."""
        return Comparison([row for name in names for row in self.rows(name)], columns=list(COLUMNS))

    def check_same(self, identities: dict[str, str]) -> None:
        """Refuse rows of other methods, or of other scenes of the same name; the last scene may lack methods."""
        names = [method.name for method in self.methods]
        scenes = list(dict.fromkeys(row["scene"] for row in self.kept.rows))
        what = ""
        for scene in scenes:
            rows = self.rows(scene)
            found = [row["method"] for row in rows]
            if found != (names[: len(found)] if scene == scenes[-1] else names):
                what = "compares other methods, or the same in another order"
                allowed = "a table by the same methods, in the same order"
            elif any(identities.get(scene, row["identity"]) != row["identity"] for row in rows):
                what, allowed = f"holds another scene named {scene!r}", f"a table with the same scene {scene!r}"
            if what:
                store = str(self.kept.path)
                message = f"store = {store!r} {what}; name a new file"
                raise SceneError("store", store, f"{allowed}, or a new file", message=message)

    def solve(self, name: str, scene: Scene) -> None:
        """Solve a scene by the methods without a row; distances are added with the last."""
        store, key, rows = self.kept.path, identity(scene, self.tol), self.rows(name)
        if len(rows) == len(self.methods):
            return
        answers = _kept_answers(store, key)[: len(rows)] if store is not None else []
        if len(answers) < len(rows):  # without the answers the rows are of no use
            rows, answers = [], []
        for method in self.methods[len(rows) :]:
            if self.progress is not None:
                self.progress(f"{name}: {method.name}")
            row, answer = _run(scene, method, self.tol)
            rows = [*rows, {"scene": name, "method": method.name, **row, "identity": key}]
            answers.append(answer)
            if len(rows) == len(self.methods):
                rows = _with_distances(rows, answers)
            elif store is not None:
                _keep_answers(store, key, answers)
            self.put(rows)

    def put(self, rows: list[dict[str, Any]]) -> None:
        """Write the rows of a scene, and drop those of other scenes that are not finished."""
        finished = self.finished()
        self.kept.write([*(row for row in self.kept.rows if row["scene"] in finished), *rows])


def _rows_of_scene(name: str, scene: Scene, methods: list[Method], tol: float) -> list[dict[str, Any]]:
    """The rows of a scene by all methods, in a worker."""
    comparison = _Comparison(Table(None, COLUMNS), methods, tol)
    comparison.solve(name, scene)
    return comparison.kept.rows


def _run(scene: Scene, method: Method, tol: float) -> tuple[dict[str, Any], _Answer | None]:
    motion = scene.motion
    assert not isinstance(motion, Transient | TimeStep)
    motions = [motion, neighbour(motion)] if motion is not None else [None]
    outcome, reason, solutions = attempted(scene, method, tol, motions)
    row: dict[str, Any] = {"outcome": outcome, "reason": reason, "calls": ""}
    if not solutions:
        return row, None
    sol, certificate = solutions[0], solutions[0].certificate
    work, *again = (each.timing.get("normal", 0.0) + each.timing.get("tangential", 0.0) for each in solutions)
    calls = {
        problem: " + ".join(f"{name} {n.count}" for name, n in each.items()) for problem, each in sol.calls.items()
    }
    row |= {
        **figures(sol),
        "gap": certificate.gap,
        "relative_gap": certificate.relative_gap,
        "force_bound": float(np.max(certificate.force_bound[:2])),
        "normal_seconds": sol.timing.get("normal", 0.0),
        "tangential_seconds": sol.timing.get("tangential", 0.0),
        "certificate_seconds": sol.timing.get("certificate", 0.0),
        "total_seconds": sol.timing["total"],
        "calls": "; ".join(f"{problem}: {count}" for problem, count in calls.items()),
    }
    if again:
        row |= {"repeat_seconds": again[0], "setup_seconds": max(work - again[0], 0.0)}
    return row, _Answer.of(sol)


@dataclass(frozen=True, eq=False)
class _Answer:
    """The fields of a solution by which answers are compared, with the grid as a string, and an element's area."""

    lattice: str
    area: float
    residual: float
    pressure: np.ndarray
    traction: np.ndarray
    state: np.ndarray
    traction_bound: np.ndarray
    force: np.ndarray

    @classmethod
    def of(cls, sol: Solution) -> _Answer:
        names = ("pressure", "traction", "state", "traction_bound", "force")
        arrays = {name: np.asarray(getattr(sol, name)) for name in names}
        return cls(json.dumps(vars(sol.grid)), float(sol.grid.area), float(sol.certificate.residual), **arrays)

    def distances(self, best: _Answer) -> dict[str, Any]:
        """From the best answer: of the forces and the tractions; without friction or slip of the pressures."""
        bound, misclassified = best.traction_bound, int(np.sum(self.state != best.state))
        limit = float(bound.sum() * best.area)
        if not 0 < limit < np.inf:
            apart = float(np.abs(self.pressure - best.pressure).max() / best.pressure.max())
            return {"traction_distance": apart, "misclassified": misclassified}
        return {
            "force_distance": float(np.hypot(*(self.force - best.force)) / limit),
            "traction_distance": float(np.hypot(*(self.traction - best.traction)).max() / bound.max()),
            "misclassified": misclassified,
        }


def _with_distances(rows: list[dict[str, Any]], answers: Sequence[_Answer | None]) -> list[dict[str, Any]]:
    """The rows of a scene with the distance of each answer from the solved one of the smallest residual."""
    pairs = list(zip(rows, answers, strict=True))
    solved = [answer for row, answer in pairs if answer is not None and row["outcome"] == "solved"]
    if not solved:
        return rows
    best = min(solved, key=lambda answer: answer.residual)
    return [
        row | answer.distances(best) if answer is not None and answer.lattice == best.lattice else row
        for row, answer in pairs
    ]


def _keep_answers(store: Path, key: str, answers: Sequence[_Answer | None]) -> None:
    """Write the answers of the scene that is being compared to a hidden file beside the table."""
    arrays: dict[str, Any] = {"identity": key, "count": len(answers)}
    for i, answer in enumerate(answers):
        if answer is not None:
            arrays |= {f"{name} {i}": value for name, value in vars(answer).items()}
    with replacing("store", _answers_file(store)) as file:
        np.savez(file, **arrays)


def _kept_answers(store: Path, key: str) -> list[_Answer | None]:
    """The answers of an interrupted comparison of a scene; none if the file is of another scene."""
    names = [field.name for field in fields(_Answer)]
    try:
        with np.load(_answers_file(store), allow_pickle=False) as file:
            if str(file["identity"]) != key:
                return []
            return [
                _Answer(*(file[f"{name} {i}"][()] for name in names)) if f"lattice {i}" in file else None
                for i in range(int(file["count"]))
            ]
    except (OSError, ValueError, KeyError, EOFError, zipfile.BadZipFile):
        return []


def forget_answers(store: Path) -> None:
    """Remove the answers beside the table, and what killed writers left of them."""
    clear(_answers_file(store))
    _answers_file(store).unlink(missing_ok=True)


def _answers_file(store: Path) -> Path:
    return beside(store.resolve(), "answers")


class Comparison(pd.DataFrame):  # type: ignore[misc]
    """A data frame with one row per scene and method, see `varcontact.compare`.

    Examples
    --------
    >>> import varcontact as vc
    >>> scene = vc.Scene(
    ...     bodies=vc.Bodies(G=82e9, nu=0.28), surface=vc.Paraboloids(Rx=0.46, Ry=0.30), normal_force=106.7e3,
    ...     friction=0.33, motion=vc.Steady(vx=1e-3), grid=vc.Grid(nx=8, ny=8))
    >>> table = vc.compare(scene, ["tang", "fastsim"])
    >>> len(table[table["outcome"] == "solved"])
    1
    """

    @property
    def _constructor(self) -> Any:
        return Comparison

    def _repr_html_(self) -> str:
        """A table for each scene; pandas' own where columns are missing."""
        if not {"scene", *(name for name, _ in SHOWN.values())} <= set(self.columns):
            frame: str = super()._repr_html_()
            return frame
        blocks = []
        for scene, cells, reasons in _printed(self):
            table = pd.DataFrame(cells, columns=list(SHOWN)).to_html(index=False, border=0)
            blocks += [html_table(scene, []), table, *([html_table("not solved", reasons)] if reasons else [])]
        return "\n".join(blocks)


def summary(table: pd.DataFrame) -> str:
    """A comparison as text: a block for each scene, then what was not solved and why."""
    blocks = []
    for scene, cells, reasons in _printed(table):
        lines = columns_of_text([list(SHOWN), *cells], left=2)
        blocks.append("\n".join([scene, *lines, *(f"  {method}: {reason}" for method, reason in reasons)]))
    return "\n\n".join(blocks)


def _printed(table: pd.DataFrame) -> list[tuple[str, list[list[str]], list[tuple[str, str]]]]:
    """By scene: its name, the cells under the headings, methods without an answer and why."""
    found = []
    for scene, rows in table.groupby("scene", sort=False):
        records = rows.to_dict("records")
        cells = [[cell(row[name], form) for name, form in SHOWN.values()] for row in records]
        found.append((str(scene), cells, [(row["method"], row["reason"]) for row in records if row["reason"]]))
    return found
