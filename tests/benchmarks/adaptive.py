"""What `accuracy=` keeps and takes, on random scenes whose continuum values come from finer grids.

    python -m tests.benchmarks.adaptive [KIND ...] [--count N] [--seed S] [--accuracies A,B,...] [--out FILE.json]

Each scene is solved on grids up to 162 elements across (line contact 1022, histories 108), the last three of which
tell the continuum's values and how well they are known. Then it is solved for each accuracy. Printed for each: how many
errors are above the request, the largest by the request and by its own estimate, and processor seconds. Where another
checkout of the package stands first in PYTHONPATH, it measures that.
"""

import argparse
import json
import platform
import time
import warnings
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

import varcontact as vc
from tests.benchmarks.random_scenes import KINDS, scenes
from varcontact.results.quantities_of_interest import units, values

CELLS, IN_LINE = (72, 108, 162), (454, 681, 1022)
"""Elements across on the grids that tell the continuum's values; of a history two thirds of them."""
KNOWN = 1 / 3
"""A scene counts for an accuracy if its continuum's values are known to this part of it."""


@dataclass(frozen=True)
class Exact:
    """Values of a scene in the continuum, what an error of one is, and the largest error of the values."""

    values: dict[str, float]
    units: dict[str, float]
    known: float


def exact(scene: vc.Scene) -> Exact:
    """From three grids by their order, second-order differences where it rolls."""
    moves = isinstance(scene.motion, vc.Transient)
    start = "slip" if scene.under_law and not moves else None
    cells = np.array(IN_LINE if scene.line else CELLS) * 2 // 3 if moves else np.array(IN_LINE if scene.line else CELLS)
    answers = [vc.solve(on(scene, int(n)), certify="none", start=start) for n in cells]
    per = units(answers[-1])
    found = np.array([[values(each)[name] for name in per] for each in answers])
    steps = np.diff(found, axis=0) / ((cells[1:] / cells[:-1]) ** 1.5 - 1)[:, None]
    best = found[-1] + steps[-1] / 2
    known = np.max(np.abs(steps[-1]) / 2 / np.array(list(per.values())), initial=0.0)
    return Exact(dict(zip(per, best, strict=True)), per, float(known))


def on(scene: vc.Scene, n: int) -> vc.Scene:
    """A scene on a grid with so many elements across the contact."""
    hertz, rolls = scene.hertz is not None and scene.bodies.K == 0, isinstance(scene.motion, vc.Steady)
    edge = "touched" if hertz and not scene.frictionless and not scene.line else "centres"
    grid = vc.Grid(nx=n) if scene.line else vc.Grid(nx=round(1.5 * n) if rolls else n, ny=n, edge=edge)
    gridded = replace(scene, grid=grid)
    return gridded.second_order() if rolls else gridded


def tried(scene: vc.Scene, accuracies: list[float]) -> list[dict[str, float]]:
    """Error, estimate and seconds for each accuracy."""
    truth, rows = exact(scene), []
    for accuracy in accuracies:
        begun = time.process_time()
        answer = vc.solve(scene, accuracy=accuracy)
        seconds = time.process_time() - begun
        found = values(answer)
        errors = [abs(found[name] - value) / truth.units[name] for name, value in truth.values.items()]
        row = {"accuracy": accuracy, "known": truth.known, "estimate": answer.error_estimate.largest}
        rows.append(row | {"error": max(max(errors) - truth.known, 0.0), "seconds": seconds})
    return rows


def main() -> None:
    """The command."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("kinds", nargs="*", metavar="KIND")
    parser.add_argument("--count", type=int, default=8)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--accuracies", default="0.1,0.03,0.01,0.003")
    parser.add_argument("--out", type=Path)
    given = parser.parse_args()
    warnings.simplefilter("ignore")
    accuracies, rows = [float(each) for each in given.accuracies.split(",")], []
    for kind in given.kinds or KINDS:
        for i, scene in enumerate(scenes(kind, given.count, given.seed)):
            try:
                rows += [{"kind": kind, "scene": i, **row} for row in tried(scene, accuracies)]
            except vc.VarcontactError as error:
                print(f"{kind} {i}: {type(error).__name__}: {error}")
    if given.out is not None:
        given.out.write_text(json.dumps(rows, indent=1))
    print(f"{len(rows)} calls; {platform.machine()}, Python {platform.python_version()}")
    print("accuracy  calls  above  largest error/accuracy  error/estimate  ms: median  90 %")
    for accuracy in accuracies:
        chosen = [row for row in rows if row["accuracy"] == accuracy and row["known"] < KNOWN * accuracy]
        errors, seconds = np.array([r["error"] for r in chosen]), np.array([r["seconds"] for r in chosen])
        estimates = np.maximum([r["estimate"] for r in chosen], 1e-12)
        print(
            f"{accuracy:8g}  {len(chosen):5d}  {np.sum(errors > accuracy):5d}  {np.max(errors) / accuracy:22.2f}  "
            f"{np.max(errors / estimates):14.2f}  {1e3 * np.median(seconds):10.0f}"
            f"  {1e3 * np.quantile(seconds, 0.9):4.0f}"
        )
        worst = sorted(chosen, key=lambda r: -r["error"])[:2]
        print("          " + "; ".join(f"{r['kind']} {r['scene']}: {r['error'] / accuracy:.2f}" for r in worst))


if __name__ == "__main__":
    main()
