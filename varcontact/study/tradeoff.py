"""Speed against accuracy: the error of ways to answer the reference scenes, and what each costs."""

from __future__ import annotations

import time
import tracemalloc
from collections import Counter
from collections.abc import Callable, Iterable, Mapping
from concurrent.futures import Executor
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from varcontact import checks
from varcontact.errors import Interrupted, NotConverged, SceneError, VarcontactError
from varcontact.planning.choice import make_plan
from varcontact.planning.roads import TOLERANCE
from varcontact.results.history import History
from varcontact.scene.motion import Shift, Steady
from varcontact.solvers.registry import tangential_methods
from varcontact.solving.discretisation_variants import Answered, Way, answer
from varcontact.solving.options import polished_by
from varcontact.solving.series import Series
from varcontact.study.compare import neighbour
from varcontact.study.engine import alone, opened, results
from varcontact.study.front import COLUMNS, TARGETS, WORDS, Tradeoff
from varcontact.study.reference_scenes import Posed
from varcontact.study.references import Reference, references, signature
from varcontact.study.store import Table
from varcontact.theories.methods import THEORIES

SECOND_ORDER = (("slip_difference", "second-order"), ("spin_offset", None))
REPEATED = 3
"""Scenes of each class on which a repeat is measured."""
CELLS = (8, 12, 16, 24, 32, 48)


def default_ways() -> list[Way]:
    """The ways that are compared if none are named.

    Examples
    --------
    >>> [str(way) for way in default_ways()][:3]
    ['centres 8', 'centres 12', 'centres 16']
    """
    pairs = [(n // 2, n) for n in CELLS]
    refined = (("refine", "continuum"),)
    return [
        *(Way(cells=n) for n in (*CELLS, 96)),
        *(Way(cells=n, coarser=coarser) for coarser, n in pairs[2:]),
        *(Way(cells=n, edge="touched", coarser=coarser) for coarser, n in pairs),
        *(Way(cells=n, edge="softened", motion=SECOND_ORDER) for n in CELLS),
        *(Way(cells=n, edge="softened", motion=SECOND_ORDER, coarser=m, order=1.2) for m, n in pairs[1:]),
        *(Way(cells=n, motion=SECOND_ORDER) for n in CELLS),
        *(Way(cells=n, options=refined) for n in (8, 12, 16, 24, 32)),
        *(Way(cells=n, options=(("tangential", each),)) for each in THEORIES for n in (10, 20)),
        *(Way(accuracy=each) for each in TARGETS),
    ]


def tradeoff(
    scenes: Mapping[str, Reference] | None = None,
    methods: Iterable[str | Way] | None = None,
    *,
    cells: Iterable[int] = CELLS,
    store: str | Path | None = None,
    progress: Callable[[str], None] | None = None,
    executor: Executor | None = None,
    workers: int = 1,
) -> Tradeoff:
    """Measure the error of ways against the continuum, and what they cost.

    Parameters
    ----------
    scenes : dict of str to Reference, optional
        Some of `references()`; all of them, if not given.
    methods : iterable of str or Way, optional
        Ways, or names of tangential methods and theories, which are tried with each number of elements, or "accuracy",
        for which grids are found for 10 to 0.1 per cent; if not given, plain and extrapolated grids, the second-order
        difference, defect correction, the theories, and accuracies.
    cells : iterable of int
        Elements across the contact, for methods that are named.
    store : str or Path, optional
        A CSV file, written after each scene: what it has is not measured again.
    progress : callable, optional
        Told the scene.
    executor, workers
        As for `sweep`. Scenes are then finished in any order, and their seconds are of shared processors.

    Returns
    -------
    Tradeoff
        All measurements, the front of each class of scenes, and what to take for a given error.

    Raises
    ------
    SceneError
        For scenes that are no references, or a store of another study, before any work starts.
    OutputError
        If the store cannot be written, or another run adds to it.
    Interrupted
        By Ctrl-C; its `partial` is the Tradeoff of the scenes that are finished.

    Notes
    -----
    Seconds are those of a first solve. What a second one with creepages one per cent smaller takes, with everything
    kept that can be, is the repeat, measured on the first three scenes of each class. Processor seconds say more than
    seconds where a machine is shared. Memory is the peak of arrays, measured on the first scene of each class, in a
    solve of its own.

    Examples
    --------
    >>> import varcontact as vc
    >>> bank = {name: each for name, each in vc.references().items() if name == "line, creepage 0.3"}
    >>> found = vc.tradeoff(bank, ["auto"], cells=[8, 16])
    >>> bool((found.runs["error"] < [0.06, 0.03]).all())
    True
    """
    if not isinstance(scenes, Mapping | None):
        raise SceneError("scenes", scenes, "a dict of names and references, as references() has them")
    bank = references() if scenes is None else dict(scenes)
    for name, each in bank.items():
        if not isinstance(each, Reference):
            raise SceneError(f"scenes[{name!r}]", each, "a Reference, as references() has them")
    ways = default_ways() if methods is None else _ways(methods, cells)
    progress = checks.progress(progress)
    with Table.opened(store, COLUMNS, WORDS, "a table of an earlier tradeoff") as table:
        known = {(row["scene"], row["way"], row["identity"]) for row in table.rows}
        met: Counter[str] = Counter()
        tasks = []
        for name, reference in bank.items():
            key = signature(Posed(reference.kind, reference.scene, reference.steps))
            met[reference.kind] += 1
            lacking = [way for way in ways if (name, str(way), key) not in known]
            tasks.append(_Task(name, reference, lacking, met[reference.kind], key))
        done = 0
        try:
            with opened(executor, workers) as pool:
                if progress is not None and pool is None and tasks:
                    progress(tasks[0].name)
                for number, rows in results(_of_scene, tasks, pool):
                    if rows:
                        table.add(*rows)
                    done += 1
                    if progress is not None and (pool is not None or done < len(tasks)):
                        progress(tasks[number if pool is not None else done].name)
        except KeyboardInterrupt:
            raise Interrupted(Tradeoff.of(table.rows, bank, ways), f" after {done} of {len(tasks)} scenes") from None
        return Tradeoff.of(table.rows, bank, ways)


@dataclass(frozen=True)
class _Task:
    """A scene, the so many-th of its class, and the ways that it has not been answered in."""

    name: str
    reference: Reference
    ways: list[Way]
    number: int
    key: str


def _of_scene(task: _Task) -> list[dict[str, Any]]:
    """The rows of a scene."""
    common = {"scene": task.name, "kind": task.reference.kind, "identity": task.key}
    return [{**common, **_named(way), **_measured(task.reference, way, task.number)} for way in task.ways]


def _ways(methods: Iterable[str | Way], cells: Iterable[int]) -> list[Way]:
    numbers = checks.wholes("cells", cells, least=2)
    if isinstance(methods, str) or not isinstance(methods, Iterable):
        raise SceneError("methods", methods, "a list of names or ways")
    found: list[Way] = []
    for each in methods:
        if isinstance(each, Way):
            found.append(each)
            continue
        name = checks.choice("methods", each, ("auto", "accuracy", *tangential_methods(), *THEORIES))
        if name == "accuracy":
            found += [Way(accuracy=target) for target in TARGETS]
            continue
        options: tuple[tuple[str, Any], ...] = () if name == "auto" else (("tangential", name),)
        found += [Way(cells=n, options=options) for n in numbers]
    if not found:
        raise SceneError("methods", [], "one at least", message="no methods to measure: name at least one")
    by_name: dict[str, Way] = {}
    for way in found:
        if by_name.setdefault(str(way), way) != way:
            raise SceneError(
                "methods", str(way), "one way of this name: what tells two of them apart is not in their names"
            )
    return list(by_name.values())


def _named(way: Way) -> dict[str, Any]:
    return {"way": str(way), "family": way.family, "cells": way.cells}


def _measured(reference: Reference, way: Way, number: int) -> dict[str, Any]:
    """The row of a way on a scene, the so many-th of its class."""
    scene = reference.scene
    reason = way.why_not(scene)
    if reason:
        return {"outcome": "refused", "reason": reason}
    steps = reference.steps or None
    try:
        wall, processor = time.perf_counter(), time.process_time()
        found = answer(scene, way, steps=steps)
        wall, processor = time.perf_counter() - wall, time.process_time() - processor
        repeat = _repeat(reference, way) if number <= REPEATED else np.nan
        memory = _traced(reference, way) if number == 1 else np.nan
    except NotConverged as error:
        return {"outcome": "not converged", "reason": str(error)}
    except VarcontactError as error:
        return {"outcome": "refused", "reason": str(error)}
    missing = [name for name in reference.units if np.isnan(found.values.get(name, np.nan))]
    if missing:
        return {"outcome": "refused", "reason": f"no {' or '.join(missing)}, which the error counts"}
    return {
        "outcome": "answered",
        "reason": "",
        "error": reference.error(found.values),
        "bar": reference.bar,
        "seconds": wall,
        "processor_seconds": processor,
        "repeat_seconds": repeat,
        "setup_seconds": max(processor - repeat, 0.0),
        "memory": memory,
        **_certified(found),
    }


def _certified(found: Answered) -> dict[str, float]:
    """Residual and gap of the finest solution: how exact it is for its grid."""
    last = found.solutions[-1]
    solution = last[-1] if isinstance(last, History) else last
    return {"residual": solution.certificate.residual, "relative_gap": solution.certificate.relative_gap}


def _repeat(reference: Reference, way: Way) -> float:
    """Processor seconds of a second scene with what the first has made; NaN where that cannot be told apart."""
    scene, options = reference.scene, dict(way.options)
    if way.accuracy is not None or not isinstance(scene.motion, Steady | Shift) or set(options) - {"tangential"}:
        return np.nan
    seconds = 0.0
    for n in [way.coarser, way.cells] if way.coarser else [way.cells]:
        posed = way.of(scene, n)
        plan = make_plan(posed, tangential=options.get("tangential", "auto"))
        series = Series(TOLERANCE, polished_by(plan, None))
        series.solve(posed, plan)
        assert isinstance(posed.motion, Steady | Shift)
        started = time.process_time()
        series.solve(replace(posed, motion=neighbour(posed.motion)), plan)
        seconds += time.process_time() - started
        series.forget()
    return seconds


def _traced(reference: Reference, way: Way) -> float:
    """Peak memory of arrays during an answer [bytes]."""
    if tracemalloc.is_tracing() or not alone():
        return np.nan
    tracemalloc.start()
    try:
        answer(reference.scene, way, steps=reference.steps or None)
        return float(tracemalloc.get_traced_memory()[1])
    finally:
        tracemalloc.stop()
