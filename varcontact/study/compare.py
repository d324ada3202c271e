"""Methods side by side on the same scenes, judged by the same measure, which belongs to none of them."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from varcontact import checks
from varcontact.errors import Interrupted, NotConverged, SceneError, SolverUnavailable, VarcontactError
from varcontact.results.solution import Solution
from varcontact.scene.grid import Grid
from varcontact.scene.motion import Shift, Steady, TimeStep, Transient
from varcontact.scene.scene import Scene
from varcontact.solvers.registry import load_packages
from varcontact.solving.series import solve_many
from varcontact.solving.solve import solve
from varcontact.study.answers import Answer, distances, forget_answers, keep_answers, kept_answers
from varcontact.study.engine import opened, results
from varcontact.study.method import Method
from varcontact.study.store import COLUMNS, WORDS, Table, identity

if TYPE_CHECKING:
    from varcontact.study.comparison import Comparison

DEFAULT_METHODS = (
    "convex",
    "active-set",
    "kalker",
    "clarabel",
    "clarabel+polish",
    "scs",
    "cvxpy:CLARABEL",
    "tang",
    "fastsim",
    "fastsim-weighted",
    "linear",
    "vermeulen-johnson",
)


def compare(
    scenes: Scene | Mapping[str, Scene],
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
    scenes : Scene or dict of str to Scene
        One scene, or several by name (as `standard_bank()`).
    methods : iterable of str
        Each a `method` of `solve` ("convex", "active-set", "kalker", also with a formulation, as "convex/marching") or
        ``[normal|]tangential[/formulation][+polish]``: "tang", "clarabel/gap", "clarabel+polish",
        "osqp|scs". A name alone stands for both problems where a normal problem has to be solved (with "norm" for
        "tang"); where Hertz's closed form serves, that is taken. Without "+polish" the answer is the method's own.
    tol : float
        Natural-map residual at which an answer counts as solved.
    store : str or Path, optional
        A CSV file, written after each method: what it has of the same scenes and methods is not solved again.
    progress : callable, optional
        Told scene and method.
    accuracy, time_budget : float, optional
        As for `solve`, for scenes without a grid of their own: they are compared on the grid on which an answer
        of this accuracy (if neither is given, of 1 %), or within this time, is found.
    executor, workers
        Where scenes are solved, as for `sweep`: each by one worker with all methods. The seconds are then those of
        processes that may share processors, and progress tells finished scenes.

    Returns
    -------
    Comparison
        A pandas.DataFrame with one row per scene and method. `outcome` is "solved", "approximate" (a theory, or
        Hertz's pressure where that is all), "not converged", "refused" or "unavailable", `reason` why. Forces, moment,
        creepage and
        approach; gap, relative gap, residual and guaranteed bound on the force, all recomputed; distance of the
        force (by the largest friction force) and of the tractions (by the largest traction bound) from the
        solution of the smallest residual on that scene, and elements with another state than there; iterations;
        seconds by stage. `calls` says who was called, and how often, as "normal: norm 1; tangential: clarabel 1 +
        splitting 1". `repeat_seconds` are those of a second scene with creepages (or forces)
        one per cent smaller and everything kept that can be, `setup_seconds` what the first took longer.

    Raises
    ------
    SceneError
        For a method that does not exist, a scene that is a history or a store of another study, before any work starts.
    OutputError
        If the store cannot be written, or another run adds to it.
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
        raise SceneError(empty, [], "one at least", message=f"no {empty} to compare: name at least one")
    named = {name: _on_grid(scene, accuracy, time_budget) for name, scene in named.items()}
    with Table.opened(store, COLUMNS, WORDS, "a table of an earlier comparison") as table:
        comparison = _Comparison(table, chosen, tol, progress)
        comparison.check_same({name: identity(scene, tol) for name, scene in named.items()})
        try:
            with opened(executor, workers) as pool:
                for name, scene in named.items() if pool is None else ():
                    comparison.solve(name, scene)
                if pool is not None:
                    comparison.solve_all(named, pool)
        except KeyboardInterrupt:
            done = comparison.finished() & set(named)
            begun = max((len(comparison.rows(name)) for name in set(named) - done), default=0)
            part = f" and {begun} of {len(chosen)} methods of the next" if begun else ""
            finished = f" after {len(done)} of {len(named)} scenes{part}"
            raise Interrupted(comparison.table(named), finished) from None
        comparison.clear()
        return comparison.table(named)


def _named(scenes: Scene | Mapping[str, Scene]) -> dict[str, Scene]:
    """Scenes by name, each of them one problem."""
    if not isinstance(scenes, Scene | Mapping):
        raise SceneError("scenes", scenes, "a Scene, or a dict of them by name")
    named = {"scene": scenes} if isinstance(scenes, Scene) else dict(scenes)
    for name, scene in named.items():
        if not isinstance(name, str):
            raise SceneError("scenes", name, "named by strings", message=f"scenes: the name {name!r} must be a string")
        if not isinstance(scene, Scene):
            raise SceneError(f"scenes[{name!r}]", scene, "a Scene")
        if isinstance(scene.motion, Transient | TimeStep):
            allowed = "Steady, Shift or none"
            message = f"scene {name!r} is a history: methods are compared on one problem (motion {allowed})"
            raise SceneError(f"motion of scene {name!r}", type(scene.motion).__name__, allowed, message=message)
    return named


def _on_grid(scene: Scene, accuracy: float | None, time_budget: float | None) -> Scene:
    """A scene on its own grid; without one on that of an accuracy, a time, or the default's 1 %."""
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
    """A table of scenes by the same methods, to which each method's row is added when it has its answer."""

    kept: Table
    methods: list[Method]
    tol: float
    progress: Callable[[str], None] | None

    def rows(self, name: str) -> list[dict[str, Any]]:
        """Those of a scene."""
        return [row for row in self.kept.rows if row["scene"] == name]

    def finished(self) -> set[str]:
        """Scenes that have all methods. Of another one, begun and left, the answers are no longer kept."""
        counts = Counter(row["scene"] for row in self.kept.rows)
        return {scene for scene, count in counts.items() if count == len(self.methods)}

    def table(self, names: Iterable[str]) -> Comparison:
        """The rows of some scenes."""
        from varcontact.study.comparison import Comparison

        place = {name: k for k, name in enumerate(names)}
        rows = sorted((row for row in self.kept.rows if row["scene"] in place), key=lambda row: place[row["scene"]])
        return Comparison(rows, columns=list(COLUMNS))

    def check_same(self, identities: dict[str, str]) -> None:
        """Refuse rows of other methods, or of other scenes by the same names; the last scene may lack methods."""
        names = [method.name for method in self.methods]
        scenes = list(dict.fromkeys(row["scene"] for row in self.kept.rows))
        for scene in scenes:
            found = [row["method"] for row in self.rows(scene)]
            if found != (names[: len(found)] if scene == scenes[-1] else names):
                raise self._refused(
                    "compares other methods, or the same in another order",
                    "a table by the same methods, in the same order",
                )
        for row in self.kept.rows:
            if identities.get(row["scene"], row["identity"]) != row["identity"]:
                name = row["scene"]
                raise self._refused(f"holds another scene named {name!r}", f"a table with the same scene {name!r}")

    def _refused(self, what: str, allowed: str) -> SceneError:
        store = str(self.kept.path)
        return SceneError(
            "store", store, f"{allowed}, or a new file", message=f"store = {store!r} {what}; name a new file"
        )

    def solve(self, name: str, scene: Scene) -> None:
        """A scene by the methods whose rows are not there yet; when all are, each has its distance from the best."""
        store, key = self.kept.path, identity(scene, self.tol)
        rows = self.rows(name)
        if len(rows) == len(self.methods):
            return
        answers = kept_answers(store, key)[: len(rows)] if store is not None else []
        if len(answers) < len(rows):  # without the answers the rows are of no use
            rows, answers = [], []
        for method in self.methods[len(rows) :]:
            if self.progress is not None:
                self.progress(f"{name}: {method.name}")
            row, solution = _run(scene, method, self.tol)
            rows = [*rows, {"scene": name, "method": method.name, **row, "identity": key}]
            answers.append(None if solution is None else Answer.of(solution))
            finished = len(rows) == len(self.methods)
            if store is not None and not finished:
                keep_answers(store, key, answers)
            whole = self.finished()
            others = [each for each in self.kept.rows if each["scene"] in whole]
            self.kept.write([*others, *(distances(rows, answers) if finished else rows)])

    def solve_all(self, named: Mapping[str, Scene], pool: Executor) -> None:
        """All scenes that lack a method, by an executor; of those that were begun nothing is taken over."""
        finished = self.finished()
        tasks = [(name, scene, self.methods, self.tol) for name, scene in named.items() if name not in finished]
        for _, rows in results(_of_scene, tasks, pool):
            finished = self.finished()
            self.kept.write([*(row for row in self.kept.rows if row["scene"] in finished), *rows])
            if self.progress is not None:
                self.progress(f"{rows[0]['scene']}: all methods")

    def clear(self) -> None:
        """Remove the answers that were kept, if no scene waits for them."""
        if self.kept.path is not None and self.finished() == {row["scene"] for row in self.kept.rows}:
            forget_answers(self.kept.path)


def _of_scene(task: tuple[str, Scene, list[Method], float]) -> list[dict[str, Any]]:
    """The rows of a scene by all methods, in a worker."""
    name, scene, methods, tol = task
    comparison = _Comparison(Table(None, COLUMNS), methods, tol, None)
    comparison.solve(name, scene)
    return comparison.kept.rows


def _run(scene: Scene, method: Method, tol: float) -> tuple[dict[str, Any], Solution | None]:
    """One method on one scene: its row of the table, and the solution, if any."""
    motion = scene.motion
    assert not isinstance(motion, Transient | TimeStep)
    motions = [motion, neighbour(motion)] if motion is not None else [None]
    outcome, reason, solutions = attempted(scene, method, tol, motions)
    row: dict[str, Any] = {"outcome": outcome, "reason": reason, "calls": ""}
    if not solutions:
        return row, None
    return row | _measured(solutions[0], solutions[1] if len(solutions) > 1 else None), solutions[0]


def attempted(
    scene: Scene, method: Method, tol: float, motions: Sequence[Steady | Shift | None]
) -> tuple[str, str, list[Solution]]:
    """A scene by one method, for one motion after the other as far as it gets.

    Parameters
    ----------
    scene : Scene
    method : Method
    tol : float
        Residual to be reached [-].
    motions : sequence of Steady, Shift or None
        At least one.

    Returns
    -------
    outcome, reason : str
        Of the first motion: "solved", "approximate", "not converged", "refused" or "unavailable", and why.
    solutions : list of Solution
        Where the first did not converge, its best iterate alone, if there is one.
    """
    try:
        plan = method.plan(scene)
        load_packages(plan.normal, plan.tangential)
    except SolverUnavailable as error:
        return "unavailable", str(error), []
    except SceneError as error:
        return "refused", str(error), []
    formula = plan.theory is not None or (not plan.rubs and plan.closed_form)
    outcome = "approximate" if formula or plan.one_pass else "solved"
    solutions: list[Solution] = []
    try:
        for solution in solve_many(scene, motions, plan, tol, method.polish):
            solutions.append(solution)  # noqa: PERF402  what is there stays when a later one fails
    except NotConverged as error:
        if not solutions:
            return "not converged", str(error), [] if error.solution is None else [error.solution]
    except VarcontactError as error:
        if not solutions:
            return "refused", str(error), []
    return outcome, "", solutions


def neighbour(motion: Steady | Shift) -> Steady | Shift:
    """Creepages and forces one per cent smaller: a second scene, for which what can be kept is kept.

    Parameters
    ----------
    motion : Steady or Shift
    """
    names = ("vx", "vy", "spin") if isinstance(motion, Steady) else ("ux", "uy", "rotation")
    values = {name: getattr(motion, name) for name in (*names, "Fx", "Fy")}
    smaller: dict[str, Any] = {name: None if value is None else 0.99 * value for name, value in values.items()}
    return replace(motion, **smaller)


def carried(sol: Solution) -> dict[str, float]:
    """Forces, moment and creepages of `sol` by the names of the tables, in the scene's units; of a shift the shifts."""
    (Fx, Fy), (vx, vy, spin) = sol.force, sol.creepage
    return {"Fx": float(Fx), "Fy": float(Fy), "Mz": sol.moment, "vx": vx, "vy": vy, "spin": spin}


def _measured(sol: Solution, repeat: Solution | None) -> dict[str, Any]:
    certificate = sol.certificate
    work = sol.timing.get("normal", 0.0) + sol.timing.get("tangential", 0.0)
    row = {
        **carried(sol),
        "approach": sol.approach,
        "gap": certificate.gap,
        "relative_gap": certificate.relative_gap,
        "residual": certificate.residual,
        "force_bound": float(np.max(certificate.force_bound[:2])),
        "iterations": sum(sol.iterations.values()),
        "normal_seconds": sol.timing.get("normal", 0.0),
        "tangential_seconds": sol.timing.get("tangential", 0.0),
        "certificate_seconds": sol.timing.get("certificate", 0.0),
        "total_seconds": sol.timing["total"],
        "calls": _called(sol),
    }
    if repeat is not None:
        again = repeat.timing.get("normal", 0.0) + repeat.timing.get("tangential", 0.0)
        row |= {"repeat_seconds": again, "setup_seconds": max(work - again, 0.0)}
    return row


def _called(sol: Solution) -> str:
    """The solvers called for each problem, and how often, in words."""
    counts = {
        problem: " + ".join(f"{name} {calls.count}" for name, calls in solvers.items())
        for problem, solvers in sol.calls.items()
    }
    return "; ".join(f"{problem}: {count}" for problem, count in counts.items())
