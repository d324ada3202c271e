"""Defect correction: what docs/refinement.md states, table by table.

    python -m tests.benchmarks.refinement TABLE ...        # front, twelve, sixty, forces
    python -m tests.benchmarks.refinement references FILE  # the references, tests/data/refined_references.csv

The references of the twelve scenes are corrected solutions on 192 cells; their error is how far those on 160 are from
them. Beside them stands what plain grids of touched elements extrapolate to, from 96 to 384 cells, with its own error:
how much it changes when one term of the fit is left out.
"""

import csv
import math
import sys
import time
from collections.abc import Callable, Iterable
from dataclasses import replace
from pathlib import Path

import numpy as np

import varcontact as vc
from varcontact.solving.discretisation_variants import Way

REFERENCES = Path(__file__).parents[1] / "data" / "refined_references.csv"
PLAIN = (96, 128, 192, 256, 384)
FRICTION = 0.3
VALUES = ("Fx", "Fy", "Mz")
NAMES = ("ratio", "nu", "vx", "vy", "spin")


def cases() -> list[dict[str, float]]:
    """Five pure and mixed creepages on a circle, and seven random ones on ellipses, in saturation creepages."""
    pure = [(1, 0, 0), (0, 1, 0), (0, 0, 1), (0.6, 0.6, 0), (0.5, -0.5, 0.7)]
    found = [(1.0, 0.28, *creepage) for creepage in pure]
    random = np.random.default_rng(7)
    for _ in range(7):
        ratio, nu = float(np.exp(random.uniform(-1.5, 1.5))), float(random.choice([0, 0.28, 0.5]))
        found.append((ratio, nu, *(random.normal(size=3) * 0.7 * np.exp(random.uniform(-0.8, 0.6)))))
    return [dict(zip(NAMES, (round(float(value), 3) for value in one), strict=True)) for one in found]


def scene(case: dict[str, float], cells: int, edge: str = "centres") -> vc.Scene:
    """An ellipse of area pi under a unit load; a creepage of one would give about the limit of friction."""
    unit = FRICTION / 3.7
    return vc.Scene(
        bodies=vc.Bodies(G=1.0, nu=case["nu"]),
        surface=vc.Ellipse(a=case["ratio"] ** 0.5, b=case["ratio"] ** -0.5),
        normal_force=1.0,
        friction=FRICTION,
        motion=vc.Steady(vx=unit * case["vx"], vy=unit * case["vy"], spin=1.5 * unit * case["spin"]),
        grid=vc.Grid(nx=cells, ny=cells, edge=edge),
    )


def plain(posed: vc.Scene) -> vc.Solution:
    """The solution on the grid, without bounds."""
    return vc.solve(posed, certify=None)


def corrected(posed: vc.Scene) -> vc.Solution:
    """The corrected solution, without bounds."""
    return vc.solve(posed, refine="continuum", certify=None)


def loads(solution: vc.Solution) -> np.ndarray:
    """Fx and Fy by f Fz, Mz by f Fz sqrt(a b)."""
    return np.array([*solution.force, solution.moment]) / FRICTION


def extrapolated(case: dict[str, float]) -> tuple[np.ndarray, float]:
    """What plain grids of touched elements tend to, and how sure that is."""
    sizes = 1 / np.array(PLAIN)
    forces = np.array([loads(vc.solve(scene(case, n, "touched"), tangential="newton", certify=None)) for n in PLAIN])

    def fitted(powers: tuple[float, ...]) -> np.ndarray:
        terms = np.column_stack([np.ones_like(sizes), *(sizes**power for power in powers)]) / sizes[:, None] ** 2
        return np.linalg.lstsq(terms, forces / sizes[:, None] ** 2, rcond=None)[0][0]

    best = fitted((1, 1.5, 2))
    return best, float(np.abs(best - fitted((1, 1.5))).max())


def write_references(path: Path) -> None:
    """Compute the references and write them."""
    with path.open("w", newline="") as file:
        table = csv.writer(file, lineterminator="\n")
        table.writerow([*NAMES, *VALUES, "error", *(f"plain_{name}" for name in VALUES), "plain_error"])
        for case in cases():
            best, other = (loads(corrected(scene(case, cells))) for cells in (192, 160))
            error, (limit, spread) = np.abs(best - other).max(), extrapolated(case)
            numbers = [f"{value:.7f}" for value in best] + [f"{error:.1e}"]
            table.writerow([*case.values(), *numbers, *(f"{value:.6f}" for value in limit), f"{spread:.1e}"])
            print(case, best, error, limit, spread, flush=True)


def read_references() -> list[tuple[dict[str, float], dict[str, float]]]:
    """The cases, and what their file has of them."""
    with REFERENCES.open(newline="") as file:
        rows = [{name: float(value) for name, value in row.items()} for row in csv.DictReader(file)]
    return [({name: row[name] for name in NAMES}, row) for row in rows]


def spread(name: str, errors: Iterable[float], note: str = "") -> None:
    """A row: median, nine in ten, largest."""
    numbers = np.quantile(np.array(list(errors)), [0.5, 0.9, 1.0])
    print(f"{name:48s} " + " / ".join(f"{value:.1e}" for value in numbers) + f"  {note}", flush=True)


def compared(scenes: list[Callable[[int], vc.Scene]], truth: np.ndarray, cells: Iterable[int]) -> None:
    """Errors of plain and corrected grids, with the estimates of these, and processor seconds."""
    for count in cells:
        begun = time.process_time()
        before = np.array([loads(plain(posed(count))) for posed in scenes])
        middle = time.process_time()
        found = [corrected(posed(count)) for posed in scenes]
        seconds = np.array([middle - begun, time.process_time() - middle]) / len(scenes)
        errors = np.abs(np.array([loads(one) for one in found]) - truth).max(axis=1)
        estimates = np.array([one.refinement.estimate.max() for one in found]) / FRICTION
        spread(f"{count} cells, plain", np.abs(before - truth).max(axis=1), f"{seconds[0]:.3f} s")
        spread(f"{count} cells, corrected", errors, f"{seconds[1]:.3f} s, {(errors > estimates).sum()} above estimates")
        spread(f"{count} cells, estimates", estimates)


def twelve() -> None:
    """The twelve scenes with references."""
    rows = read_references()
    truth = np.array([[row[name] for name in VALUES] for _, row in rows])
    compared([lambda n, case=case: scene(case, n) for case, _ in rows], truth, (8, 16, 32, 64))


def sixty() -> None:
    """Random scenes from partial to full slip, a/b from 0.2 to 5, any nu; against corrected ones on 128 cells."""
    rng, found = np.random.default_rng(60), []
    for _ in range(60):
        ratio, nu = np.exp(rng.uniform(math.log(0.2), math.log(5))), rng.uniform(0, 0.5)
        size, way = np.exp(rng.uniform(math.log(0.1), math.log(4))), rng.normal(size=3)
        creepages = map(float, size * way / np.linalg.norm(way))
        found.append(dict(zip(NAMES, (float(ratio), float(nu), *creepages), strict=True)))
    truth = np.array([loads(corrected(scene(case, 128))) for case in found])
    compared([lambda n, case=case: scene(case, n) for case in found], truth, (8, 12, 16, 24, 32))


def forces() -> None:
    """Creepages of scenes with both forces given, by those of saturation; and what the field carries."""
    for cells in (16, 32):
        before, after, carried = [], [], []
        for case, row in read_references()[::2]:
            wanted = scene(case, cells).motion
            motion = vc.Steady(Fx=FRICTION * row["Fx"], Fy=FRICTION * row["Fy"], spin=wanted.spin)
            posed = replace(scene(case, cells), motion=motion)
            for errors, one in ((before, plain(posed)), (after, found := corrected(posed))):
                errors.append(np.abs(np.subtract(one.creepage[:2], wanted.rigid[:2])).max() / (FRICTION / 3.7))
            carried.append(np.abs(found.force - [motion.Fx, motion.Fy]).max() / FRICTION)
        for name, errors in (("plain", before), ("corrected", after), ("forces carried", carried)):
            spread(f"{cells} cells, {name}", errors)


def front() -> None:
    """Error and processor seconds on the reference scenes that it serves, beside plain grids and `accuracy=`."""
    second = (("slip_difference", "second-order"), ("spin_offset", None))
    ways = [
        *(Way(cells=n, options=(("refine", "continuum"),)) for n in (32, 48, 64, 96)),
        *(Way(cells=n, edge="softened", motion=second) for n in (48, 96)),
        *(Way(cells=n, edge="softened", motion=second, coarser=n // 2, order=1.2) for n in (48, 96)),
        *(Way(accuracy=each) for each in (0.003, 0.001, 0.0003, 0.0001)),
    ]
    kinds = ("steady, circular", "steady, slender", "forces given")
    bank = {name: each for name, each in vc.references().items() if each.kind in kinds}
    found = vc.tradeoff(bank, ways).runs
    for kind in kinds:
        for way in ways:
            rows = (found["kind"] == kind) & (found["way"] == str(way))
            milliseconds = 1e3 * np.nanmedian(found["processor_seconds"][rows])
            spread(f"{kind}: {way}", found["error"][rows], f"{milliseconds:.0f} ms")


TABLES: dict[str, Callable[[], None]] = {"front": front, "twelve": twelve, "sixty": sixty, "forces": forces}


def main(words: list[str]) -> None:
    """Print the tables that are named, or write the references."""
    if words[:1] == ["references"]:
        return write_references(Path(words[1]))
    if not words or not set(words) <= set(TABLES):
        sys.exit(f"name tables, of {', '.join(TABLES)}; or references and a file")
    for word in words:
        TABLES[word]()
    return None


if __name__ == "__main__":
    main(sys.argv[1:])
