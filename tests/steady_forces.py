"""Forty scenes of steady rolling with their forces in the continuum; ``python -m
tests.steady_forces`` makes these.

They are drawn at random: a/b from 0.2 to 5, Poisson's ratio from 0 to 0.5, creepages and spin from
small to beyond saturation, a quarter without spin. Forces are extrapolated from 192 and 384 cells
on touched elements, with order 1; on scenes where both discretisations were taken that far, their
limits were 1e-4 apart at most.
"""

import csv
from pathlib import Path

import numpy as np

import varcontact as vc
from tests.scenes import make_scene

REFERENCES = Path(__file__).parent / "data" / "steady_forces.csv"
NAMES = ("a", "b", "nu", "vx", "vy", "spin")
FORCES = ("Fx", "Fy", "Mz")
FRICTION = 0.3


def scene(
    numbers: dict[str, float], nx: int, ny: int | None = None, edge: str = "centres"
) -> vc.Scene:
    """The scene of some numbers, with nx by ny cells across the contact."""
    motion = vc.Steady(**{name: numbers[name] for name in ("vx", "vy", "spin")})
    grid, bodies = (
        vc.Grid(nx=nx, ny=nx if ny is None else ny, edge=edge),
        vc.Bodies(G=1.0, nu=numbers["nu"]),
    )
    return make_scene(vc.Ellipse(numbers["a"], numbers["b"]), 1.0, motion, grid, FRICTION, bodies)


def forces(posed: vc.Scene, tol: float = 1e-6) -> np.ndarray:
    """Fx, Fy and Mz by f Fz; the ellipse has a b = 1."""
    sol = vc.solve(posed, certify="none", tol=tol)
    return np.array([*sol.force, sol.moment]) / FRICTION


def read() -> list[tuple[dict[str, float], np.ndarray]]:
    """Scenes by their numbers, with the forces on an infinitely fine grid."""
    with REFERENCES.open() as lines:
        rows = [
            {name: float(value) for name, value in row.items()} for row in csv.DictReader(lines)
        ]
    return [
        ({name: row[name] for name in NAMES}, np.array([row[name] for name in FORCES]))
        for row in rows
    ]


def write() -> None:
    """The references anew, from fine grids."""
    known = read()
    with REFERENCES.open("w", newline="") as file:
        lines = csv.writer(file, lineterminator="\n")
        lines.writerow((*NAMES, *FORCES))
        for numbers, _ in known:
            coarse, fine = (forces(scene(numbers, n, edge="touched")) for n in (192, 384))
            lines.writerow(
                [
                    *(repr(value) for value in numbers.values()),
                    *(f"{F:.6f}" for F in 2 * fine - coarse),
                ]
            )


if __name__ == "__main__":
    write()
