"""Errors of steady forces on coarse grids, by discretisation, and their time.

    python -m tests.benchmarks.coarse_forces [CELLS ...]
    python -m tests.benchmarks.coarse_forces --parts
    python -m tests.benchmarks.coarse_forces --references

Forty Hertzian scenes drawn at random: a/b from 0.2 to 5, Poisson's ratio from 0 to 0.5, creepages and spin from small
to beyond saturation, a quarter without spin. An error is the largest of those of Fx and Fy, by f Fz, and of Mz, by
f Fz sqrt(a b). References are extrapolated from 192 and 384 cells on touched elements, with order 1; on scenes where
both discretisations were taken that far, their limits were 1e-4 apart at most. ``--references`` computes them again;
``--parts`` has the difference and the edge each for itself, on every other scene.
"""

import csv
import sys
import time
from dataclasses import replace
from itertools import product
from pathlib import Path

import numpy as np

import varcontact as vc

REFERENCES = Path(__file__).parents[1] / "data" / "steady_forces.csv"
NAMES = ("a", "b", "nu", "vx", "vy", "spin")
FORCES = ("Fx", "Fy", "Mz")
FRICTION = 0.3


def drawn(count: int = 40, seed: int = 11) -> list[dict[str, float]]:
    """Scenes by their numbers; a b = 1."""
    rng, scenes = np.random.default_rng(seed), []
    for k in range(count):
        ratio, nu = np.exp(rng.uniform(np.log(0.2), np.log(5))), rng.uniform(0, 0.5)
        size, direction = np.exp(rng.uniform(np.log(0.2), np.log(3))), rng.normal(size=3)
        direction /= np.linalg.norm(direction)
        if k % 4 == 0:
            direction[2] = 0
            direction /= np.linalg.norm(direction)
        creepages = size * direction * FRICTION / np.array([4.0, 4.0, 1.5])
        scenes.append(dict(zip(NAMES, map(float, (ratio**0.5, ratio**-0.5, nu, *creepages)), strict=True)))
    return scenes


def scene(numbers: dict[str, float], nx: int, ny: int | None = None, edge: str = "centres") -> vc.Scene:
    """The scene of some numbers, with nx by ny cells across the contact."""
    return vc.Scene(
        bodies=vc.Bodies(G=1.0, nu=numbers["nu"]),
        surface=vc.Ellipse(a=numbers["a"], b=numbers["b"]),
        normal_force=1.0,
        friction=FRICTION,
        motion=vc.Steady(**{name: numbers[name] for name in ("vx", "vy", "spin")}),
        grid=vc.Grid(nx=nx, ny=nx if ny is None else ny, edge=edge),
    )


def forces(posed: vc.Scene, tol: float = 1e-6) -> np.ndarray:
    """Fx, Fy and Mz by f Fz; the ellipse has a b = 1."""
    sol = vc.solve(posed, certify="none", tol=tol)
    return np.array([*sol.force, sol.moment]) / FRICTION


def read() -> list[tuple[dict[str, float], np.ndarray]]:
    """Scenes by their numbers, with the forces on an infinitely fine grid."""
    with REFERENCES.open() as lines:
        rows = [{name: float(value) for name, value in row.items()} for row in csv.DictReader(lines)]
    return [({name: row[name] for name in NAMES}, np.array([row[name] for name in FORCES])) for row in rows]


def write() -> None:
    """The references, from fine grids."""
    with REFERENCES.open("w", newline="") as file:
        lines = csv.writer(file, lineterminator="\n")
        lines.writerow((*NAMES, *FORCES))
        for numbers in drawn():
            coarse, fine = (forces(scene(numbers, n, edge="touched")) for n in (192, 384))
            lines.writerow([*(repr(value) for value in numbers.values()), *(f"{F:.6f}" for F in 2 * fine - coarse)])


def extrapolated(coarse: np.ndarray, fine: np.ndarray, order: float) -> np.ndarray:
    """From n/2 and n cells."""
    return fine + (fine - coarse) / (2**order - 1)


def measured(nx: int, ny: int, second_order: bool) -> tuple[np.ndarray, float]:
    """Forces (scenes, 3), and milliseconds of the processor for one."""
    found, begun = [], time.process_time()
    for numbers, _ in read():
        posed = scene(numbers, nx, ny)
        found.append(forces(posed.second_order() if second_order else posed, tol=1e-4))
    return np.array(found), (time.process_time() - begun) * 1e3 / len(found)


def left(found: np.ndarray) -> np.ndarray:
    """Errors, (scenes,)."""
    return np.asarray(np.abs(found - np.array([reference for _, reference in read()])).max(axis=1))


def line(name: str, found: np.ndarray, milliseconds: float) -> str:
    """A row of the table: errors in per cent, median, of nine in ten, and largest."""
    errors = 100 * left(found)
    numbers = [np.median(errors), np.quantile(errors, 0.9), errors.max()]
    return f"{name:34s} " + " / ".join(f"{value:5.2f}" for value in numbers) + f"  {milliseconds:7.1f} ms"


def parts() -> None:
    """Errors by slip difference and edge."""
    for difference, edge in product(("first-order", "second-order"), ("centres", "touched", "softened")):
        for n in (12, 24, 32):
            posed = [scene(numbers, n, edge=edge) for numbers, _ in read()[::2]]
            motions = [replace(one.motion, slip_difference=difference, spin_offset=None) for one in posed]
            found = [forces(replace(one, motion=motion), 1e-4) for one, motion in zip(posed, motions, strict=True)]
            errors = np.abs(np.array(found) - [reference for _, reference in read()[::2]]).max(axis=1) * 100
            numbers = " / ".join(
                f"{value:.2f}" for value in (np.median(errors), np.quantile(errors, 0.9), errors.max())
            )
            print(f"{difference}, {edge}, {n}: {numbers}")


def main(cells: list[int]) -> None:
    """The table."""
    forces(scene(drawn(1)[0], 12))  # imports
    for name, second_order, wide in (
        ("first order", False, 1.0),
        ("second order", True, 1.0),
        ("1.5 n x n", True, 1.5),
    ):
        for n in cells:
            fine, spent = measured(int(wide * n), n, second_order)
            coarse, more = measured(int(wide * n / 2), n // 2, second_order)
            print(line(f"{name}, {n}", fine, spent), flush=True)
            both, change = extrapolated(coarse, fine, 2.0 if second_order else 1.0), np.abs(fine - coarse).max(axis=1)
            print(line(f"{name}, {n // 2} and {n}", both, spent + more), flush=True)
            if second_order:
                one = np.count_nonzero(left(fine) <= 0.75 * change + 0.003 * 16 / n)
                two = np.count_nonzero(left(both) <= 0.5 * change + 0.0025 * 16 / n)
                print(f"    bounds from the change between both grids: held by {one} and {two} of {len(fine)}")


if __name__ == "__main__":
    if "--references" in sys.argv:
        write()
    elif "--parts" in sys.argv:
        parts()
    else:
        main([int(word) for word in sys.argv[1:]] or [12, 16, 24, 32, 48])
