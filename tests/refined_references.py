"""Twelve scenes of steady rolling with their forces in the continuum; ``python -m tests.refined_references``.

Five pure and mixed creepages on a circle, and seven random ones on ellipses, in saturation creepages. The references
are corrected solutions on 192 cells; their error is how far those on 160 are from them.
"""

import csv
from pathlib import Path

import numpy as np

import varcontact as vc
from tests.scenes import make_scene

REFERENCES = Path(__file__).parent / "data" / "refined_references.csv"
FRICTION = 0.3
VALUES = ("Fx", "Fy", "Mz")
NAMES = ("ratio", "nu", "vx", "vy", "spin")


def scene(case: dict[str, float], cells: int) -> vc.Scene:
    """An ellipse of area pi under a unit load; a creepage of one would give about the limit of friction."""
    unit = FRICTION / 3.7
    a, b = case["ratio"] ** 0.5, case["ratio"] ** -0.5
    motion = vc.Steady(vx=unit * case["vx"], vy=unit * case["vy"], spin=1.5 * unit * case["spin"])
    grid, bodies = vc.Grid(nx=cells, ny=cells), vc.Bodies(G=1.0, nu=case["nu"])
    return make_scene(vc.Ellipse(a, b), 1.0, motion, grid, FRICTION, bodies)


def corrected(posed: vc.Scene) -> vc.Solution:
    """The corrected solution, without bounds."""
    return vc.solve(posed, refine="continuum", certify=None)


def loads(solution: vc.Solution) -> np.ndarray:
    """Fx and Fy by f Fz, Mz by f Fz sqrt(a b)."""
    return np.array([*solution.force, solution.moment]) / FRICTION


def read_references() -> list[tuple[dict[str, float], dict[str, float]]]:
    """The cases, and what their file has of them."""
    with REFERENCES.open(newline="") as file:
        rows = [{name: float(value) for name, value in row.items()} for row in csv.DictReader(file)]
    return [({name: row[name] for name in NAMES}, row) for row in rows]


def write_references() -> None:
    """Compute the references anew."""
    cases = [case for case, _ in read_references()]
    with REFERENCES.open("w", newline="") as file:
        table = csv.writer(file, lineterminator="\n")
        table.writerow([*NAMES, *VALUES, "error"])
        for case in cases:
            best, other = (loads(corrected(scene(case, cells))) for cells in (192, 160))
            numbers = [f"{value:.7f}" for value in best]
            table.writerow([*case.values(), *numbers, f"{np.abs(best - other).max():.1e}"])


if __name__ == "__main__":
    write_references()
