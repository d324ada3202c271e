"""Accuracy on demand: the laws behind it fitted, and what it promises tried, on random scenes.

    python -m tests.benchmarks.on_demand rungs FILE KIND [KIND ...] [--count N] [--seed S] [--finest N]
    python -m tests.benchmarks.on_demand fit FILE
    python -m tests.benchmarks.on_demand prove FILE KIND [KIND ...] [--count N] [--seed S]

``rungs`` solves random scenes on all grids of their ladder and adds a line of JSON for each to the file: resumed, if it
is called again. The last three grids tell the continuum's values, and how sure they are. ``fit`` prints the laws of
`varcontact.solving.on_demand.ladder` with which accuracies take the least time on these scenes, of those that cover
their errors. ``prove`` asks for accuracies, and for times, on other scenes: errors against the continuum, and seconds
beside those of the cheapest single grid that happens to be accurate enough, of all grids and of those that `tradeoff`
compares, and of the coarsest one that is so for all scenes of the kind.
"""

import argparse
import itertools
import json
import math
import platform
import time
from dataclasses import replace
from pathlib import Path

import numpy as np

import varcontact as vc
from tests.benchmarks.random_scenes import KINDS, scenes
from varcontact.errors import SceneError, VarcontactError
from varcontact.planning.choice import make_plan
from varcontact.solving.error_norm import semi_axes, units, values
from varcontact.solving.on_demand.climb import BESIDE, COARSER, GREATEST_STEP, LEAST_STEP, LIKELY, SPARE
from varcontact.solving.on_demand.ladder import LADDERS, Ladder, Law, kind_of
from varcontact.solving.on_demand.severity import severity_of
from varcontact.study.tradeoff import CELLS as COMPARED

CELLS = (4, 6, 8, 12, 16, 24, 32, 48, 64, 96, 144, 216, 324)
CELLS_IN_LINE = (8, 12, 16, 24, 32, 48, 64, 96, 128, 192, 256, 512, 1024, 2048)
ACCURACIES = (0.1, 0.03, 0.01, 0.003)
BUDGETS = (0.03, 0.1, 0.3, 1.0)
COARSE = 4
"""Grids that may be solved alone, where there is no time for a second one."""
COVERED, BEYOND = 0.997, 1.5
"""The part of all errors that are below their estimates, and the largest error by its own."""
SAFETY = 1.3
"""By which the estimate of a single grid is larger than the scenes that it is fitted to ask for."""
SURE = 1e-3
"""Largest uncertainty of the continuum's values with which a scene counts; an error counts as far as it exceeds it."""


def ladder_for(scene: vc.Scene) -> tuple[tuple[bool, str, str], Ladder]:
    """The ladder of a scene, and its key."""
    key = kind_of(scene, make_plan(scene))
    return key, LADDERS[key]


def rung(scene: vc.Scene, ladder: Ladder, n: int) -> tuple[vc.Solution, float]:
    """The solution on a single grid, and processor seconds."""
    begun = time.process_time()
    sol = vc.solve(ladder.posed(scene, n), certify="none", start=_start(scene))
    return sol, time.process_time() - begun


def _start(scene: vc.Scene) -> str | None:
    """From where accuracies seek the solution under a law of friction; a history has no start."""
    return "slip" if scene.under_law and not isinstance(scene.motion, vc.Transient) else None


def largest_contact(answer: vc.Solution | vc.History) -> vc.Solution:
    """The solution, or that step of a history which has the largest contact."""
    return max(answer, key=lambda sol: sol.areas["contact"]) if isinstance(answer, vc.History) else answer


def extrapolated(n: np.ndarray, found: np.ndarray, order: float) -> np.ndarray:
    """From each grid and the one before it; found has a row for each grid."""
    part = 1 / ((n[1:] / n[:-1]) ** order - 1)
    return found[1:] + np.diff(found, axis=0) * part[:, None]


def climbed(scene: vc.Scene, finest: int) -> dict[str, object]:
    """A scene on all grids up to the `finest`."""
    key, ladder = ladder_for(scene)
    cells = [n for n in (CELLS_IN_LINE if scene.line else CELLS) if n <= finest]
    answers = [rung(scene, ladder, n) for n in cells]
    per = units(answers[-1][0])
    nears = [largest_contact(answer) for answer, _ in answers]
    known = scene, make_plan(scene), semi_axes(nears[-1])
    found = np.array([[values(sol)[name] / unit for name, unit in per.items()] for sol, _ in answers])
    fine = extrapolated(np.array(cells[-3:], float), found[-3:], ladder.law.order)
    return {
        "key": list(key),
        "before": severity_of(*known),
        "severity": [severity_of(*known, near) for near in nears],
        "planned": [severity_of(*known, near, 1 / COARSER) for near in nears],
        "cells": cells,
        "names": list(per),
        "units": list(per.values()),
        "found": found.tolist(),
        "seconds": [seconds for _, seconds in answers],
        "continuum": fine[-1].tolist(),
        "sure": float(abs(fine[-1] - fine[-2]).max()),
    }


def add_rungs(path: Path, kinds: list[str], count: int, seed: int, finest: int) -> None:
    """Add a line for each scene that is not there yet."""
    known = {tuple(json.loads(line)["scene"]) for line in path.read_text().splitlines()} if path.exists() else set()
    for kind in kinds:
        for i, scene in enumerate(scenes(kind, count, seed)):
            if (kind, seed, i) in known:
                continue
            try:
                record = climbed(scene, finest)
            except VarcontactError as error:
                record = {"failed": f"{type(error).__name__}: {error}"}
            with path.open("a") as file:
                file.write(json.dumps({"scene": [kind, seed, i], **record}) + "\n")


def records(path: Path, sure: float) -> list[dict]:
    """Lines of the file whose continuum values are known to that."""
    lines = [json.loads(line) for line in path.read_text().splitlines()]
    failed = [each for each in lines if "failed" in each]
    unsure = [each for each in lines if each.get("sure", 0) > sure]
    print(f"{len(lines)} scenes; {len(failed)} failed, {len(unsure)} are not known to {sure:g}")
    for each in failed:
        print("  ", each["scene"], each["failed"][:100])
    return [each for each in lines if "failed" not in each and each["sure"] <= sure]


def part_of_step(cells: list[int], i: int, j: int, order: float) -> float:
    """What of the difference of two grids' values the step to the extrapolated one is."""
    return 1 / ((cells[j] / cells[i]) ** order - 1)


def pairs_of(chosen: list[dict], order: float, taken: float, coarsest: int) -> np.ndarray:
    """Severity, elements across on the finer one, extrapolating step and error of pairs of grids, (4, pairs)."""
    pairs = []
    for record in chosen:
        cells, found, exact = record["cells"], np.array(record["found"]), np.array(record["continuum"])
        for i, j in itertools.combinations(range(len(cells) - 1), 2):
            if cells[i] >= coarsest and 0.3 <= cells[i] / cells[j] <= 0.7:
                step = (found[j] - found[i]) * part_of_step(cells, i, j, order)
                error = max(abs(found[j] + taken * step - exact).max() - record["sure"], 0.0)
                pairs.append((record["severity"][j], cells[j], abs(step).max(), error))
    return np.array(pairs).T


def covering(chosen: list[dict], pairs: np.ndarray, order: float, share: float, fall: float, power: float) -> Law:
    """The law of that form with the least floor that covers nearly all errors, and none by less than a part of it."""
    severity, n, step, error = pairs
    scale = n**fall / severity**power
    lacking, beyond = (error - share * step) * scale, (error / BEYOND - share * step) * scale
    floor = max(float(np.quantile(lacking, COVERED)), float(beyond.max()), 1e-4)
    usual = max(float(np.median(step * n**order)), 1e-12)
    single = max(alone(record, order, power) for record in chosen)
    return Law(order, share, floor, fall, usual, SAFETY * single, power)


def alone(record: dict, order: float, power: float) -> float:
    """Largest error on one of the coarse grids, by powers of the size of its elements and of its severity."""
    scales = np.array(record["cells"]) ** order / np.array(record["severity"]) ** power
    return float((errors_of(record)[:COARSE] * scales[:COARSE]).max())


def climb(record: dict, law: Law, coarsest: int, accuracy: float) -> float:
    """Seconds of the grids of a record that are solved for an accuracy, as `varcontact.solving.on_demand` goes on."""
    cells, found = record["cells"][:-1], np.array(record["found"])
    seconds = np.maximum.accumulate(record["seconds"])

    def nearest(n: float) -> int:
        return int(np.argmin(abs(np.log(np.array(cells) / n))))

    def first(severity: float) -> int:
        n = math.ceil(1.5 * coarsest)
        while law.expected(n, severity, LIKELY) > accuracy and n < cells[-1]:
            n = math.ceil(1.05 * n)
        return n

    n = first(record["before"])
    solved = [min(nearest(max(coarsest, COARSER * n)), max(nearest(n), 1) - 1)]
    n = first(record["planned"][solved[0]])
    j = max(nearest(n), solved[0] + 1)
    while True:
        i = min(solved, key=lambda place: abs(math.log(cells[place] / (BESIDE * cells[j]))))
        step = abs(found[j] - found[i]).max() * part_of_step(cells, i, j, law.order)
        estimate = law.error(step, cells[j], record["severity"][j])
        solved.append(j)
        if estimate <= accuracy:
            return float(seconds[solved].sum())
        if j == len(cells) - 1:  # as many more elements as the law asks for, and as much more time
            while law.share * step * (cells[j] / n) ** law.order + law.remainder(n, record["severity"][j]) > accuracy:
                n = math.ceil(1.05 * n)
            return float(seconds[solved].sum() + seconds[j] * max(n / cells[j], 1.0) ** 2)
        more = SPARE * (estimate / accuracy) ** (1 / law.order)
        j = max(j + 1, nearest(cells[j] * min(max(more, LEAST_STEP), GREATEST_STEP)))


def fit(path: Path) -> None:
    """Print the law of each class with which the accuracies take the least time, by that of the cheapest grid."""
    every = records(path, SURE)
    for key in sorted({tuple(each["key"]) for each in every}):
        chosen = [each for each in every if tuple(each["key"]) == key]
        powers = (0.0, 0.5, 1.0, 2.0) if any(set(each["severity"]) != {1.0} for each in chosen) else (0.0,)
        best: tuple[float, Law] | None = None
        for order, taken in itertools.product((1.5, 1.75, 2.0), (0.5, 1.0)):
            pairs = pairs_of(chosen, order, taken, LADDERS[key].coarsest)
            for form in itertools.product((0.5, 1.0, 2.0, 3.0), (1.0, 1.25, 1.5, 2.0), powers):
                law = replace(covering(chosen, pairs, order, *form), taken=taken)
                cost = by_cheapest(chosen, law, LADDERS[key].coarsest)
                if best is None or cost < best[0]:
                    best = cost, law
        if best is not None:
            print(f"{key}: {len(chosen)} scenes, by the cheapest grid {best[0]:.2f}: {best[1]}", flush=True)


def by_cheapest(chosen: list[dict], law: Law, coarsest: int) -> float:
    """Seconds by those of the cheapest grid that happens to be accurate enough: the geometric mean."""
    ratios = []
    for record, accuracy in itertools.product(chosen, np.geomspace(min(ACCURACIES), max(ACCURACIES), 10)):
        enough = np.flatnonzero(errors_of(record) <= accuracy)
        if enough.size:
            seconds = np.maximum.accumulate(record["seconds"])[enough[0]]
            ratios.append(climb(record, law, coarsest, float(accuracy)) / seconds)
    return float(np.exp(np.mean(np.log(ratios))))


def prove(path: Path, kinds: list[str], count: int, seed: int) -> None:
    """Ask for accuracies and times on scenes whose continuum values the file has."""
    every = records(path, max(ACCURACIES) / 3)
    known = {tuple(each["scene"]): each for each in every if each["sure"] <= SURE}
    print(f"{platform.processor() or platform.machine()}, Python {platform.python_version()}")
    for kind in kinds:
        posed = [(known.get((kind, seed, i)), scene) for i, scene in enumerate(scenes(kind, count, seed))]
        tried = [(record, scene) for record, scene in posed if record is not None]
        for accuracy in ACCURACIES:
            enough = max(accuracy / 3, SURE)
            sure = fixed([each for each in every if each["scene"][0] == kind and each["sure"] <= enough], accuracy)
            outcomes = [asked(record, scene, accuracy, sure) for record, scene in tried]
            _print(f"{kind}, accuracy {accuracy:g}", np.array([o for o in outcomes if o is not None]), len(outcomes))
        for budget in BUDGETS:
            _print_times(f"{kind}, time_budget {budget:g}", [timed(record, scene, budget) for record, scene in tried])


def _print_times(name: str, outcomes: list[tuple[float, float] | None]) -> None:
    answered = [outcome for outcome in outcomes if outcome is not None]
    if not answered:
        print(f"{name}: all {len(outcomes)} given up")
        return
    ratio, error = np.array(answered).T
    print(
        f"{name}: {len(answered)} of {len(outcomes)} scenes, seconds by budget median {np.median(ratio):.2f}, "
        f"worst {ratio.max():.2f}; error median {np.median(error):.1e}, worst {error.max():.1e}"
    )


def _print(name: str, outcomes: np.ndarray, count: int) -> None:
    ratio, seconds, cheapest, compared, sure = outcomes.T
    print(
        f"{name}: {count} scenes, error/accuracy median {np.median(ratio):.2f}, worst {ratio.max():.2f}, "
        f"above 1: {np.mean(ratio > 1):.1%}; "
        f"ms median {1e3 * np.median(seconds):.0f}, worst {1e3 * seconds.max():.0f}; by the cheapest grid "
        f"median {np.median(seconds / cheapest):.1f}, 90 % {np.quantile(seconds / cheapest, 0.9):.1f}; "
        f"of those compared median {np.median(seconds / compared):.1f}, "
        f"90 % {np.quantile(seconds / compared, 0.9):.1f}; "
        f"by the one for all median {np.median(seconds / sure):.1f}, 90 % {np.quantile(seconds / sure, 0.9):.1f}"
    )


def error_of(record: dict, sol: vc.Solution) -> float:
    """Against the continuum, less what its values are not sure by."""
    found, exact = values(sol), zip(record["names"], record["units"], record["continuum"], strict=True)
    return max(max(abs(found[name] / unit - value) for name, unit, value in exact) - record["sure"], 0.0)


def errors_of(record: dict) -> np.ndarray:
    """Of single grids but the finest, less what the continuum's values are not sure by."""
    return np.maximum(abs(np.array(record["found"][:-1]) - record["continuum"]).max(axis=1) - record["sure"], 0.0)


def fixed(tried: list[dict], accuracy: float) -> int | None:
    """Place of the coarsest grid that is accurate enough for all of these scenes; None where no grid is."""
    common = min(len(record["cells"]) for record in tried) - 1
    worst = np.max([errors_of(record)[:common] for record in tried], axis=0)
    enough = np.flatnonzero(worst <= accuracy)
    return int(enough[0]) if enough.size else None


def asked(record: dict, scene: vc.Scene, accuracy: float, sure: int | None) -> tuple[float, ...] | None:
    """Error by the accuracy; seconds, and those of the cheapest grid that is accurate enough, of all and of those that
    are compared, and of the `sure` one.
    """
    begun = time.process_time()
    try:
        sol = vc.solve(scene, accuracy=accuracy)
    except VarcontactError as error:
        print("  ", record["scene"], accuracy, type(error).__name__, str(error)[:100])
        return None
    taken = time.process_time() - begun
    enough = np.flatnonzero(errors_of(record) <= accuracy)
    compared = [place for place in enough if record["cells"][place] >= min(COMPARED)]
    grids = [*enough[:1], *compared[:1]] if compared else [None, None]
    seconds = [np.nan if grid is None else spent_on(record, scene, int(grid)) for grid in (*grids, sure)]
    return error_of(record, sol) / accuracy, taken, *seconds


def spent_on(record: dict, scene: vc.Scene, place: int) -> float:
    """Processor seconds of a solve on a single grid, with its certificate."""
    _, ladder = ladder_for(scene)
    begun = time.process_time()
    vc.solve(ladder.posed(scene, record["cells"][place]), start=_start(scene))
    return time.process_time() - begun


def timed(record: dict, scene: vc.Scene, budget: float) -> tuple[float, float] | None:
    """Seconds by the budget, and error; a history that is given up has neither."""
    begun = time.perf_counter()
    try:
        sol = vc.solve(scene, time_budget=budget)
    except SceneError:
        return None
    return (time.perf_counter() - begun) / budget, error_of(record, sol)


def main() -> None:
    """The command."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("work", choices=("rungs", "fit", "prove"))
    parser.add_argument("file", type=Path)
    parser.add_argument("kinds", nargs="*", metavar="KIND")
    parser.add_argument("--count", type=int, default=40)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--finest", type=int, default=max(CELLS_IN_LINE), help="elements across on the finest grid")
    given = parser.parse_args()
    if given.work == "fit":
        fit(given.file)
    elif given.work == "rungs":
        add_rungs(given.file, given.kinds or list(KINDS), given.count, given.seed, given.finest)
    else:
        prove(given.file, given.kinds or list(KINDS), given.count, given.seed)


if __name__ == "__main__":
    main()
