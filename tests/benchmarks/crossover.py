"""From how many elements Newton's method without a matrix is faster than active sets, for each kind of scene.

    python tests/benchmarks/crossover.py [REPEATS]

Processor seconds of the whole call of `solve`, the least of all repeats, both methods in turn. The bound on forces is
left out. The last column is the number of elements at which both take as long, between the two grids around it.
"""

import platform
import sys
import time
from collections.abc import Callable
from dataclasses import replace

import numpy as np

import varcontact as vc

CELLS = (6, 8, 10, 12, 14, 16, 20, 24, 28)
STRIPS = (25, 50, 100, 150, 200, 300, 400, 800)
REPEATS = 5


def elliptic(a: float, cells: int, motion: vc.Steady | vc.Shift) -> vc.Scene:
    """An elliptic contact with b = 1."""
    return vc.Scene(
        bodies=vc.Bodies(G=1.0, nu=0.28),
        surface=vc.Ellipse(a=a, b=1.0),
        normal_force=1.0,
        friction=0.3,
        motion=motion,
        grid=vc.Grid(nx=cells, ny=cells),
    )


def strips(cells: int, vy: float = 0.0) -> vc.Scene:
    """Line contact."""
    return vc.Scene(
        bodies=vc.Bodies(G=1.0, nu=0.28),
        surface=vc.Cylinders(R=100.0),
        normal_force=1.0,
        friction=0.3,
        motion=vc.Steady(vx=0.001, vy=vy),
        grid=vc.Grid(nx=cells),
    )


def unlike(scene: vc.Scene) -> vc.Scene:
    """The same pressed shape, of bodies of which one is three times as stiff."""
    hertz, bodies = scene.hertz, vc.Bodies(G=(1.0, 3.0), nu=0.28)
    shape = vc.Cylinders(hertz.Rx) if scene.line else vc.Paraboloids(hertz.Rx, hertz.Ry)
    return replace(scene, surface=shape, bodies=bodies)


def sampled(cells: int) -> vc.Scene:
    """A sphere with waves, given by samples: the pressure is solved for."""
    grid = vc.Grid(nx=cells + 2, ny=cells + 2, dx=2 / cells, dy=2 / cells, x0=-1 - 1 / cells, y0=-1 - 1 / cells)
    x, y = np.meshgrid(grid.x, grid.y)
    return vc.Scene(
        bodies=vc.Bodies(G=1.0, nu=0.28),
        surface=vc.SampledDistance(x**2 + 1.1 * y**2 + 0.03 * np.sin(9 * x) * np.cos(7 * y)),
        approach=0.8,
        grid=grid,
    )


MIXED, SPIN = {"vx": 0.05, "vy": -0.03, "spin": 0.05}, {"spin": 0.3}
KINDS: dict[str, tuple[Callable[[int], vc.Scene], tuple[int, ...]]] = {
    "normal, sampled": (sampled, CELLS),
    "shift, a/b = 1": (lambda cells: elliptic(1.0, cells, vc.Shift(ux=0.05, uy=0.02)), CELLS),
    "shift along x, a/b = 1": (lambda cells: elliptic(1.0, cells, vc.Shift(ux=0.05)), CELLS),
    "steady, a/b = 0.2": (lambda cells: elliptic(0.2, cells, vc.Steady(**MIXED)), CELLS),
    "steady, a/b = 1": (lambda cells: elliptic(1.0, cells, vc.Steady(**MIXED)), CELLS),
    "steady, a/b = 5": (lambda cells: elliptic(5.0, cells, vc.Steady(**MIXED)), CELLS),
    "steady, spin, a/b = 1": (lambda cells: elliptic(1.0, cells, vc.Steady(**SPIN)), CELLS),
    "steady, forces, a/b = 1": (lambda cells: elliptic(1.0, cells, vc.Steady(Fx=-0.15, Fy=0.1, spin=0.05)), CELLS),
    "steady along x, line contact": (strips, STRIPS),
    "steady, line contact": (lambda cells: strips(cells, vy=0.001), STRIPS),
    "steady, unlike bodies": (lambda cells: unlike(elliptic(1.0, cells, vc.Steady(**MIXED))), CELLS[:6]),
    "shift, unlike bodies": (lambda cells: unlike(elliptic(1.0, cells, vc.Shift(ux=0.05, uy=0.02))), CELLS[:6]),
    "steady, line contact of unlike bodies": (lambda cells: unlike(strips(cells)), STRIPS[:6]),
}


def seconds(scene: vc.Scene, normal: str, tangential: str, repeats: int) -> float:
    """Least processor seconds of a solve."""
    taken = []
    for _ in range(repeats):
        begun = time.process_time()
        vc.solve(scene, normal=normal, tangential=tangential, certify="gap")
        taken.append(time.process_time() - begun)
    return min(taken)


def measured(posed: Callable[[int], vc.Scene], cells: tuple[int, ...], repeats: int) -> list[tuple[int, float, float]]:
    """Elements in contact, seconds of active sets and of Newton's method on each grid."""
    rows = []
    for count in cells:
        scene = posed(count)
        pressures = (
            ("norm", "newton")
            if isinstance(scene.surface, vc.SampledDistance) or scene.bodies.K != 0
            else ("hertz", "hertz")
        )
        dense = seconds(scene, pressures[0], "auto" if scene.motion is None else "tang-safeguarded", repeats)
        free = seconds(scene, pressures[1], "auto" if scene.motion is None else "newton", repeats)
        contact = vc.solve(scene, method="active-set", certify="gap").elements["contact"]
        rows.append((contact, dense, free))
    return rows


def crossover(rows: list[tuple[int, float, float]]) -> str:
    """The elements beyond which Newton's method stays faster, on a logarithmic scale between two grids."""
    faster = [free < dense for _, dense, free in rows]
    if not faster[-1]:
        return f"more than {rows[-1][0]}"
    last = max((i for i, ahead in enumerate(faster) if not ahead), default=-1)
    if last < 0:
        return f"less than {rows[0][0]}"
    (n, *before), (m, *after) = rows[last : last + 2]
    lead, lag = np.log(after[0] / after[1]), np.log(before[1] / before[0])
    return f"{n * (m / n) ** (lag / (lag + lead)):.0f}"


def main(repeats: int = REPEATS) -> None:
    """Print the table, and the machine."""
    print(f"{platform.machine()}, Python {platform.python_version()}, varcontact {vc.__version__}")
    print("| kind | elements: milliseconds of active sets, of `newton` | as fast at |")
    print("|---|---|---|")
    vc.solve(elliptic(1.0, 8, vc.Steady(vx=0.01)), tangential="newton")  # imports
    for kind, (posed, cells) in KINDS.items():
        rows = measured(posed, cells, repeats)
        cases = "; ".join(f"{count}: {1e3 * dense:.3g}, {1e3 * free:.3g}" for count, dense, free in rows)
        print(f"| {kind} | {cases} | {crossover(rows)} |", flush=True)


if __name__ == "__main__":
    main(*(int(argument) for argument in sys.argv[1:]))
