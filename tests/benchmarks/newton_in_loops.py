"""Active sets and Newton's method without a matrix where problems come in rows: unlike bodies, laws, histories, scans.

    python tests/benchmarks/newton_in_loops.py [MOST_CELLS]

Processor seconds, the least of two, of a whole solve of unlike bodies or under a law, of the median step of a history
after the first, and of each solution of a scan; without the certificate's bounds on forces. Active sets are left out
where they would take minutes.
"""

import dataclasses
import itertools
import platform
import sys
import time
from collections.abc import Callable

import numpy as np

import varcontact as vc

CELLS = (8, 12, 16, 20, 24, 28, 36, 48, 64, 128)
DENSE_CELLS = 28
REPEATS, STEPS, CREEPAGES = 2, 8, 200
METHODS = {"active sets": ("norm", "tang-safeguarded"), "newton": ("newton", "newton")}
LAWS = {
    "exponential law": vc.ExponentialFalling(static=0.3, kinetic=0.2, half_velocity=0.1),
    "static and kinetic": vc.StaticKinetic(static=0.3, kinetic=0.2),
}


def rolling(cells: int, **changes: object) -> vc.Scene:
    """Rolling with creepages and spin that leave about half of the contact to slip."""
    scene = vc.Scene(
        bodies=vc.Bodies(G=1.0, nu=0.28),
        surface=vc.Paraboloids(Rx=1.0, Ry=1.0),
        normal_force=1e-3,
        friction=0.3,
        motion=vc.Steady(vx=0.0075, vy=-0.0045, spin=0.09),
        grid=vc.Grid(nx=cells, ny=cells),
    )
    return dataclasses.replace(scene, **changes)


def unlike(**changes: object) -> dict[str, object]:
    """Bodies with K = 0.1."""
    return {"bodies": vc.Bodies(G=(1.0, 7.0 / 3.0), nu=0.25), **changes}


def spent(work: Callable[[], object]) -> float:
    """Processor seconds, the least of some."""
    taken = []
    for _ in range(REPEATS):
        begun = time.process_time()
        work()
        taken.append(time.process_time() - begun)
    return min(taken)


def of_a_solve(scene: vc.Scene, **methods: str) -> float:
    """Processor seconds of the whole call."""
    return spent(lambda: vc.solve(scene, certify="gap", **methods))


def of_a_step(scene: vc.Scene, **methods: str) -> float:
    """Processor seconds of the median step after the first."""
    told: list[float] = []
    vc.solve(scene, certify="gap", progress=lambda word: told.append(time.process_time()), **methods)
    return float(np.median(np.diff([*told, time.process_time()])[1:]))


def of_a_creepage(scene: vc.Scene, **methods: str) -> float:
    """Processor seconds of each of many random creepages."""
    triples = np.random.default_rng(0).uniform(-0.01, 0.01, (CREEPAGES, 3)) * [1.0, 1.0, 5.0]
    return spent(lambda: vc.scan(scene, triples, certify="gap", **methods)) / CREEPAGES


def cases(cells: int) -> dict[str, tuple[Callable[..., float], vc.Scene]]:
    """What is measured, and how, by name."""
    shift, history = vc.Shift(ux=6e-4, uy=-4e-4), vc.Transient(steps=STEPS, vx=0.0075, vy=-0.0045, spin=0.09)
    named = {
        "unlike bodies, steady": (of_a_solve, rolling(cells, **unlike())),
        "unlike bodies, shift": (of_a_solve, rolling(cells, **unlike(motion=shift))),
        **{name: (of_a_solve, rolling(cells, friction=law)) for name, law in LAWS.items()},
        "history, a step": (of_a_step, rolling(cells, motion=history)),
        "history of unlike bodies": (of_a_step, rolling(cells, **unlike(motion=history))),
    }
    if cells <= DENSE_CELLS:
        named["scan, a creepage"] = (of_a_creepage, rolling(cells))
    return named


def main(most: int = CELLS[-1]) -> None:
    """Print the table, and the machine."""
    print(f"{platform.machine()}, Python {platform.python_version()}, varcontact {vc.__version__}")
    print(f"{'':26}{'elements':>10}" + "".join(f"{name:>14}" for name in METHODS))
    vc.solve(rolling(8), normal="newton", tangential="newton")  # imports
    sizes = [cells for cells in CELLS if cells <= most]
    for name, cells in itertools.product(cases(8), sizes):
        if name not in cases(cells):
            continue
        measure, scene = cases(cells)[name]
        row = f"{name:26}{round(np.pi / 4 * cells**2):>10}"
        for method, (normal, tangential) in METHODS.items():
            methods = {"normal": normal if scene.bodies.K else "auto", "tangential": tangential}
            dense = method == "active sets" and cells > DENSE_CELLS
            row += f"{'-' if dense else format(measure(scene, **methods), '.3f'):>14}"
        print(row, flush=True)


if __name__ == "__main__":
    main(*(int(argument) for argument in sys.argv[1:]))
