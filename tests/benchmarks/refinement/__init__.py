"""Defect correction: what docs/refinement.md states, table by table.

    python -m tests.benchmarks.refinement TABLE            # twelve, sixty, small, no-slip, ...: its names without TABLE
    python -m tests.benchmarks.refinement references FILE  # the references, tests/data/refined_references.csv

The references of the twelve scenes are corrected solutions on 192 cells with elements in nine parts; their error is how
far those on 160 cells with four parts are from them. Beside them stands what plain grids of touched elements
extrapolate to, from 96 to 384 cells, with its own error: how much it changes when one term of the fit is left out.
"""

import csv
from dataclasses import replace
from pathlib import Path

import numpy as np

import varcontact as vc
from varcontact.discrete.discretisation import discretise
from varcontact.discrete.state import unloaded
from varcontact.solvers.statistics import SolveStats
from varcontact.solving.contact_solver import ContactSolver
from varcontact.solving.defect_correction.passes import PASSES, defect_corrected

REFERENCES = Path(__file__).parents[2] / "data" / "refined_references.csv"
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


def loads(solution: vc.Solution) -> np.ndarray:
    """Fx and Fy by f Fz, Mz by f Fz sqrt(a b)."""
    return np.array([*solution.force, solution.moment]) / FRICTION


def reference(case: dict[str, float]) -> tuple[np.ndarray, float]:
    """Corrected loads on 192 cells, and how far those on 160 are from them."""
    found = []
    for cells, parts in ((192, 3), (160, 2)):
        posed = scene(case, cells)
        plan = vc.plan(posed, tangential="newton")
        grid = plan.sizes.grid
        lattice = vc.Grid(nx=cells, ny=cells).spread((-posed.hertz.a, posed.hertz.a, -posed.hertz.b, posed.hertz.b))
        assert lattice.shape == (grid[1], grid[0])
        steps = ContactSolver(plan, 1e-7, False, SolveStats(), refined=False)
        disc = discretise(replace(posed, grid=lattice), lattice)
        state = steps.traction(disc, steps.pressure(disc, unloaded(lattice)))
        passed = defect_corrected(disc, state, steps.traction, steps.traction, parts, passes=PASSES + 2)
        found.append(passed.forces[-1] / FRICTION)
    return found[0], float(np.abs(found[0] - found[1]).max())


def extrapolated(case: dict[str, float]) -> tuple[np.ndarray, float]:
    """What plain grids of touched elements tend to, and how sure that is."""
    sizes = 1 / np.array(PLAIN)
    forces = np.array([
        loads(vc.solve(scene(case, cells, "touched"), tangential="newton", certify=None)) for cells in PLAIN
    ])  # fmt: skip

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
            (best, error), (plain, spread) = reference(case), extrapolated(case)
            numbers = [f"{value:.7f}" for value in best] + [f"{error:.1e}"]
            table.writerow([*case.values(), *numbers, *(f"{value:.6f}" for value in plain), f"{spread:.1e}"])
            print(case, best, error, plain, spread, flush=True)


def read_references() -> list[tuple[dict[str, float], dict[str, float]]]:
    """The cases, and what their file has of them."""
    with REFERENCES.open(newline="") as file:
        rows = [{name: float(value) for name, value in row.items()} for row in csv.DictReader(file)]
    return [({name: row[name] for name in NAMES}, row) for row in rows]
