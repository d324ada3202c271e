"""Twelve scenes of steady rolling with their forces in the continuum; ``python -m tests.refined_references``.

The references are corrected solutions on 192 cells; their error is how far those on 160 are from them. Beside them
stands what plain grids of touched elements extrapolate to, from 96 to 384 cells, with its own error: how much it
changes when one term of the fit is left out.
"""

import csv
from pathlib import Path

import numpy as np

import varcontact as vc
from tests.scenes import make_scene

REFERENCES = Path(__file__).parent / "data" / "refined_references.csv"
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
    return make_scene(
        vc.Ellipse(a=case["ratio"] ** 0.5, b=case["ratio"] ** -0.5),
        1.0,
        vc.Steady(vx=unit * case["vx"], vy=unit * case["vy"], spin=1.5 * unit * case["spin"]),
        vc.Grid(nx=cells, ny=cells, edge=edge),
        friction=FRICTION,
        bodies=vc.Bodies(G=1.0, nu=case["nu"]),
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


if __name__ == "__main__":
    write_references(REFERENCES)
