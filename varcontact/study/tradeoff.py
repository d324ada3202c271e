"""Speed against accuracy: the error of ways to answer the reference scenes, what each costs, and
Pareto fronts.
"""

from __future__ import annotations

import json
import time
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass
from functools import partial
from itertools import product
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from varcontact import checks
from varcontact.errors import SceneError, VarcontactError
from varcontact.html import Reported
from varcontact.results.history import History
from varcontact.scene.motion import Shift, Steady
from varcontact.scene.scene import Scene
from varcontact.solvers.registry import tangential_methods
from varcontact.solving.discretisation_variants import Way, answer
from varcontact.solving.methods import Methods
from varcontact.solving.options import TOLERANCE, polished_by
from varcontact.solving.own_solvers import solver_name
from varcontact.solving.selection import select
from varcontact.solving.warm_start import Series, solve_in_turn
from varcontact.study.csv_table import Table, cell, columns_of_text, identity, plain_rows
from varcontact.study.methods import failure, neighbour
from varcontact.study.parallel import Execution, traced
from varcontact.study.references import ContinuumValues, continuum_values
from varcontact.system.process import imported
from varcontact.system.progress import Progress
from varcontact.theories.on_grid import THEORIES

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.figure import Figure

COLUMNS = (
    "scene", "kind", "way", "family", "cells", "outcome", "reason", "error", "bar", "seconds",
    "processor_seconds", "setup_seconds", "repeat_seconds", "memory", "residual", "relative_gap",
    "identity"
)  # fmt: skip
WORDS = ("scene", "kind", "way", "family", "outcome", "reason", "identity")
TARGETS = (0.1, 0.03, 0.01, 0.003, 0.001)
"""Errors for which methods are recommended."""
MOST_MISSED = 0.2
"""Fraction of the scenes of a class that a method on its front may leave without an answer."""
SECOND_ORDER = (("slip_difference", "second-order"), ("spin_offset", None))
REPEATED = 3
"""Scenes of each class on which a repeat is measured."""
CELLS = (8, 12, 16, 24, 32, 48)
MEDIANS = ("error", "seconds", "processor_seconds", "repeat_seconds")
ADVISED = ("way", "largest_error", "median_error", "processor_seconds", "repeat_seconds", "memory")


def default_ways() -> list[Way]:
    """The ways that are compared if none are named."""
    pairs = [(n // 2, n) for n in CELLS]
    return [
        *(Way(cells=n) for n in (*CELLS, 96)),
        *(Way(cells=n, coarser=coarser) for coarser, n in pairs[2:]),
        *(Way(cells=n, edge="touched", coarser=coarser) for coarser, n in pairs),
        *(Way(cells=n, edge="softened", motion=SECOND_ORDER) for n in CELLS),
        *(
            Way(cells=n, edge="softened", motion=SECOND_ORDER, coarser=m, order=1.2)
            for m, n in pairs[1:]
        ),
        *(Way(cells=n, motion=SECOND_ORDER) for n in CELLS),
        *_linear_ways(),
        *(Way(cells=n, options=(("tangential", each),)) for each in THEORIES for n in (10, 20)),
        *(Way(accuracy=each) for each in TARGETS),
    ]


def _linear_ways() -> list[Way]:
    """Linear tractions, of line contact."""
    return [
        Way(cells=n, tractions="linear", motion=motion)
        for motion in ((), SECOND_ORDER)
        for n in CELLS
    ]


@checks.named_options()
def tradeoff(
    scenes: Mapping[str, ContinuumValues] | Scene | None = None,
    methods: Iterable[str | Way] | None = None,
    *,
    cells: Iterable[int] = CELLS,
    store: str | Path | None = None,
    progress: Progress = None,
    executor: Executor | None = None,
    workers: int = 1,
) -> Tradeoff:
    """Measure the error of ways against the continuum, and their cost.

    Parameters
    ----------
    scenes : dict of str to ContinuumValues, or Scene, optional
        Some of `continuum_values()`; all of them, if not given; or a scene of
        one's own, without a grid.
    methods : iterable of str or Way, optional
        Ways, or names of tangential methods and theories, which are tried with
        each number of elements, or "accuracy", for accuracies of 10 to 0.1 %;
        if not given, plain and extrapolated grids, the second-order difference,
        the theories, and accuracies.
    cells : iterable of int
        Elements across the contact, for methods that are named.
    store : str or Path, optional
        A CSV file, written after each scene. What it holds is not measured
        again.
    progress : callable or true, optional
        Called with the scene.
    executor, workers
        As in `sweep`. Scenes are then finished in any order, and their seconds
        are of shared processors.

    Returns
    -------
    Tradeoff
        All measurements, the Pareto front of each class of scenes, and advice
        for a given error.

    Raises
    ------
    SceneError
        For scenes that are no references, or a store of another study, before
        any work starts.
    OutputError
        If the store cannot be written, or another process writes to it.
    Interrupted
        By Ctrl-C; its `partial` is the Tradeoff of the scenes that are
        finished.

    Notes
    -----
    Seconds are those of a first solve. The repeat is a second one with creepages one per cent
    smaller and everything reused that can be, measured on the first three scenes of each class. On
    a shared machine processor seconds are more reliable. Memory is the peak of arrays, measured on
    the first scene of each class, in a solve of its own.

    Examples
    --------
    >>> import varcontact as vc
    >>> name = "line, creepage 0.3"
    >>> study = vc.tradeoff({name: vc.continuum_values()[name]}, ["auto"], cells=[8, 16])
    >>> bool((study.runs["error"] < [0.06, 0.03]).all())
    True
    """
    if isinstance(scenes, Scene):
        scenes = continuum_values(scenes)
    if not isinstance(scenes, Mapping | None):
        raise SceneError(
            "scenes", scenes, "a dict of names and references, as continuum_values() has them"
        )
    bank = continuum_values() if scenes is None else dict(scenes)
    for name, each in bank.items():
        if not isinstance(each, ContinuumValues):
            raise SceneError(f"scenes[{name!r}]", each, "one of those that continuum_values() has")
    numbers = checks.wholes("cells", cells, least=2)
    ways = default_ways() if methods is None else _ways(methods, numbers)
    execution = Execution(executor, workers, checks.progress(progress))
    imported("pandas")  # imported now: after Ctrl-C the import would have to be waited for
    with Table.opened(store, COLUMNS, WORDS, "a table of an earlier tradeoff") as table:
        measured = {(row["scene"], row["way"], row["identity"]) for row in table.rows}
        of_kind: Counter[str] = Counter()
        tasks: dict[str, tuple[Any, ...]] = {}
        for name, reference in bank.items():
            key = identity(reference.scene, TOLERANCE)
            of_kind[reference.kind] += 1
            missing = [way for way in ways if (name, str(way), key) not in measured]
            tasks[name] = (name, reference, missing, of_kind[reference.kind], key)
        study = partial(Tradeoff.of, scenes=bank, ways=ways)
        return table.fill(_measured, tasks, execution, study, len(bank))


def _measured(
    name: str, reference: ContinuumValues, ways: list[Way], number: int, key: str
) -> list[dict[str, Any]]:
    common = {"scene": name, "kind": reference.kind, "identity": key}
    return [
        {
            **common,
            "way": str(way),
            "family": way.family,
            "cells": way.cells,
            **_costs(reference, way, number),
        }
        for way in ways
    ]


def _ways(methods: Iterable[str | Way], numbers: list[int]) -> list[Way]:
    if isinstance(methods, str) or not isinstance(methods, Iterable):
        raise SceneError("methods", methods, "a list of names or ways")
    ways: list[Way] = []
    for each in methods:
        if isinstance(each, Way):
            ways.append(each)
        else:
            ways += _parsed_ways(each, numbers)
    if not ways:
        raise SceneError("methods", [], "at least one name")
    by_name = {str(way): way for way in ways}
    for way in ways:
        if by_name[str(way)] != way:
            allowed = "one way of this name: what tells two of them apart is not in their names"
            raise SceneError("methods", str(way), allowed)
    return list(by_name.values())


def _parsed_ways(name: str, numbers: list[int]) -> list[Way]:
    """The ways of a method with all numbers of elements; or all accuracies."""
    solver_name("tangential", name)
    checks.choice("methods", name, ("auto", "accuracy", *tangential_methods(), *THEORIES))
    if name == "accuracy":
        return [Way(accuracy=target) for target in TARGETS]
    if name == "auto":
        return [Way(cells=n) for n in numbers]
    return [Way(cells=n, options=(("tangential", name),)) for n in numbers]


def _costs(reference: ContinuumValues, way: Way, number: int) -> dict[str, Any]:
    """The error and the costs of a way on a scene, which is that `number` of its class."""
    work = partial(answer, reference.scene, way, steps=reference.steps or None)
    try:
        started = time.perf_counter()
        started_processor = time.process_time()
        result = work()
        wall = time.perf_counter() - started
        processor = time.process_time() - started_processor
        repeat = _repeat_seconds(reference.scene, way) if number <= REPEATED else np.nan
        memory = traced(work)[1] if number == 1 else np.nan
    except VarcontactError as error:
        return {"outcome": failure(error), "reason": str(error)}
    missing = [name for name in reference.units if np.isnan(result.values.get(name, np.nan))]
    if missing:
        reason = f"no {' or '.join(missing)}, which the error counts"
        return {"outcome": "refused", "reason": reason}
    finest = result.solutions[-1]
    if isinstance(finest, History):
        finest = finest[-1]
    certificate = finest.certificate
    return {
        "outcome": "answered",
        "reason": "",
        "error": reference.error(result.values),
        "bar": reference.bar,
        "seconds": wall,
        "processor_seconds": processor,
        "repeat_seconds": repeat,
        "setup_seconds": max(processor - repeat, 0.0),
        "memory": memory,
        "residual": certificate.residual,
        "relative_gap": certificate.relative_gap,
    }


def _repeat_seconds(scene: Scene, way: Way) -> float:
    """Processor seconds of a second solve that reuses what the first has made; NaN where it cannot
    be separated.
    """
    options = dict(way.options)
    if (
        way.accuracy is not None
        or not isinstance(scene.motion, Steady | Shift)
        or set(options) - {"tangential"}
    ):
        return np.nan
    seconds = 0.0
    grids = [way.coarser, way.cells] if way.coarser else [way.cells]
    for n in grids:
        on_grid = way.of(scene, n)
        plan = select(on_grid, Methods(tangential=options.get("tangential", "auto")))
        motions = [on_grid.motion, neighbour(on_grid.motion)]
        series = Series(TOLERANCE, polished_by(plan, None))
        turns = solve_in_turn(on_grid, motions, plan, series)
        next(turns)
        started = time.process_time()
        next(turns)
        seconds += time.process_time() - started
    return seconds


@dataclass(frozen=True, eq=False)
class Tradeoff(Reported):
    """Errors against the continuum, and costs.

    Attributes
    ----------
    runs : pandas.DataFrame
        A row per scene and way: outcome and reason; error in the norm of
        `varcontact.results.quantities_of_interest`, and the reference's own
        error bar; seconds, processor seconds, those of a repeat and of the
        set-up, memory [bytes]; residual and relative gap, which bound the
        distance from the exact solution on the grid.
    classes : pandas.DataFrame
        A row per class and way: the requested accuracy, if any; numbers of
        scenes and answers; median, 90 % quantile and largest error; medians of
        the seconds; memory; whether it is on the Pareto front: no other way is
        both faster and more accurate in the worst scene.
    """

    runs: pd.DataFrame
    classes: pd.DataFrame

    @classmethod
    def of(cls, rows: list[dict[str, Any]], scenes: Iterable[str], ways: Iterable[Way]) -> Tradeoff:
        """Tradeoff from the rows of a table that belong to these scenes and ways."""
        import pandas as pd

        names = set(scenes)
        kept = {str(way): way for way in ways}
        chosen = [row for row in rows if row["scene"] in names and row["way"] in kept]
        runs = pd.DataFrame(chosen, columns=list(COLUMNS)).astype(dict.fromkeys(MEDIANS, float))
        by_way = runs.groupby(["kind", "way"], sort=False)
        classes = by_way.agg(
            family=("family", "first"),
            cells=("cells", "first"),
            scenes=("scene", "size"),
            answers=("error", "count"),
            median_error=("error", "median"),
            usual_error=("error", partial(pd.Series.quantile, q=0.9)),
            largest_error=("error", "max"),
            **{name: (name, "median") for name in MEDIANS[1:]},
            memory=("memory", "max"),
        ).reset_index()
        classes.insert(4, "accuracy", [kept[way].accuracy or np.nan for way in classes["way"]])
        classes = classes[classes["answers"] > 0].reset_index(drop=True)
        fast = _serving(classes).sort_values(["processor_seconds", "largest_error"])
        best = (
            fast.groupby("kind")["largest_error"]
            .cummin()
            .groupby(fast["kind"])
            .shift(fill_value=np.inf)
        )
        classes["front"] = classes.index.isin(fast.index[fast["largest_error"] < best])
        return cls(runs, classes)

    def front(self, kind: str) -> pd.DataFrame:
        """The ways on the Pareto front of a class, from fast to accurate.

        Parameters
        ----------
        kind : str
            Class of scenes.
        """
        part = self.classes[(self.classes["kind"] == kind) & self.classes["front"]]
        return part.sort_values("processor_seconds")

    @checks.named_options()
    def advice(self, targets: float | Sequence[float] = TARGETS) -> pd.DataFrame:
        """The fastest way of each class whose errors are below the `targets`, one or several, in
        all scenes.

        A table with a row per class and target, without a way where none is as accurate. An
        `accuracy` is never advised for a smaller error than it was requested for. SceneError if a
        target is not positive.
        """
        import pandas as pd

        wanted = np.atleast_1d(checks.positives("targets", targets)).tolist()
        fast = _serving(self.classes).sort_values("processor_seconds")
        rows = []
        for kind, target in product(self.classes["kind"].unique(), wanted):
            good = (
                (fast["kind"] == kind)
                & (fast["largest_error"] <= target)
                & ~(fast["accuracy"] > target)
            )
            best = fast[good].iloc[0].to_dict() if good.any() else {}
            rows.append(
                {"kind": kind, "target": target, **{name: best.get(name) for name in ADVISED}}
            )
        return pd.DataFrame(rows)

    def plot(self) -> Figure:
        """Picture of errors over processor seconds, a panel for each class, with its front."""
        from varcontact.plotting.studies import plot_tradeoff

        return plot_tradeoff(self)

    def to_json(self) -> str:
        """The tables of classes and of advice as one JSON object; null where nothing is known."""
        tables = {"classes": plain_rows(self.classes), "advice": plain_rows(self.advice())}
        return json.dumps(tables, indent=2, allow_nan=False, default=lambda value: value.item())

    def report(self) -> str:
        """Fronts of the classes in figures, for people; reasons for a class without an answer."""
        blocks = []
        for kind in self.runs["kind"].unique():
            front = self.front(kind)
            if front.empty:
                blocks.append("\n".join([kind, *self._reasons(kind)]))
                continue
            lines = [["method", "scenes", "median", "90 %", "largest", "ms", "repeat", "MiB"]]
            for row in front.to_dict("records"):
                errors = [
                    f"{100 * row[name]:.2g} %"
                    for name in ("median_error", "usual_error", "largest_error")
                ]
                costs = (
                    1e3 * row["processor_seconds"],
                    1e3 * row["repeat_seconds"],
                    row["memory"] / 2**20,
                )
                answered = f"{row['answers']} of {row['scenes']}"
                lines.append(
                    [row["way"], answered, *errors, *(cell(cost, ".3g") for cost in costs)]
                )
            blocks.append(
                "\n".join([kind, *(f"  {line}" for line in columns_of_text(lines, left=1))])
            )
        return "\n\n".join(blocks)

    def _reasons(self, kind: str) -> list[str]:
        """Reasons why ways have not answered scenes of a class."""
        failed = self.runs[(self.runs["kind"] == kind) & (self.runs["outcome"] != "answered")]
        reasons = failed.drop_duplicates(["way", "reason"])
        return [
            f"  {row['way']}: {row['outcome']}: {row['reason']}"
            for row in reasons.to_dict("records")
        ]

    def __repr__(self) -> str:
        return f"Tradeoff({self.runs['scene'].nunique()} scenes, {self.runs['way'].nunique()} ways)"


def _serving(classes: pd.DataFrame) -> pd.DataFrame:
    """The ways that answer most scenes of a class."""
    return classes[classes["answers"] >= (1 - MOST_MISSED) * classes["scenes"]]
