"""Newton's method without a matrix over the number of elements: seconds, products, memory, and how they grow.

    python tests/benchmarks/many_elements.py [CELLS ...]

For each number of cells across: normal contact of a wavy sphere given by samples, a shift, and steady rolling in 15
cases (a/b of 0.2, 1 and 5; five sets of creepages and spin). Processor seconds of the whole call of `solve`, set-up,
coarser grids, residual and gap included; the least of three up to 20 000 elements. Products with influence numbers are
counted on the finest grid, and in all, one of a grid with a quarter of the elements as a quarter. The last lines are
exponents fitted to the medians, and the peak memory of the last size, of a process of its own.
"""

import itertools
import multiprocessing
import platform
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import scipy

import varcontact as vc
from varcontact.solvers.newton.kernel import Kernel

CELLS = (32, 64, 128, 256)
SHAPES = (0.2, 1.0, 5.0)
CREEPAGES = ((0.22, 0.0, 0.0), (0.08, 0.08, 0.1), (0.0, 0.0, 0.1), (0.0, 0.0, 0.8), (0.05, 0.1, -0.3))
OF_SLENDER = ((0.1, 0.0, 0.0), (0.04, 0.05, 0.03), (0.0, 0.0, 0.03), (0.0, 0.0, 0.4), (0.03, 0.05, -0.12))
FORCE = 50 / 27


def rubbed(cells: int, shape: float, motion: vc.Steady | vc.Shift) -> vc.Scene:
    """An elliptic contact with a b = 1."""
    return vc.Scene(
        bodies=vc.Bodies(G=1.0, nu=0.28),
        surface=vc.Ellipse(a=shape**0.5, b=shape**-0.5),
        normal_force=FORCE,
        friction=0.3,
        motion=motion,
        grid=vc.Grid(nx=cells, ny=cells),
    )


def pressed(cells: int) -> vc.Scene:
    """A sphere with waves; about as many elements in contact as in a circle of so many cells across."""
    side = 2 / cells
    grid = vc.Grid(nx=cells + 2, ny=cells + 2, dx=side, dy=side, x0=-1 - side / 2, y0=-1 - side / 2)
    x, y = np.meshgrid(grid.x, grid.y)
    distance = x**2 + 1.1 * y**2 + 0.01 * np.sin(9 * x) * np.cos(7 * y)
    return vc.Scene(bodies=vc.Bodies(G=1.0, nu=0.28), surface=vc.SampledDistance(distance), approach=1.4, grid=grid)


def steady(cells: int) -> Iterator[vc.Scene]:
    """Fifteen cases."""
    for shape, case in itertools.product(SHAPES, range(len(CREEPAGES))):
        vx, vy, spin = (OF_SLENDER if shape == SHAPES[-1] else CREEPAGES)[case]
        yield rubbed(cells, shape, vc.Steady(vx=vx, vy=vy, spin=spin))


def shifts(cells: int) -> Iterator[vc.Scene]:
    """Three shapes."""
    for shape in SHAPES:
        yield rubbed(cells, shape, vc.Shift(ux=0.1, uy=0.05))


KINDS: dict[str, Callable[[int], Iterator[vc.Scene]]] = {
    "normal": lambda cells: iter([pressed(cells)]),
    "shift": shifts,
    "steady": steady,
}


@contextmanager
def products() -> Iterator[list[int]]:
    """Sizes of the boxes of all products while inside."""
    sizes, multiply = [], Kernel.__call__

    def counted(self, traction):
        sizes.append(traction[0].size)
        return multiply(self, traction)

    Kernel.__call__ = counted
    try:
        yield sizes
    finally:
        Kernel.__call__ = multiply


def measured(scene: vc.Scene) -> tuple[int, float, int, float]:
    """Elements in contact, seconds, products on the finest grid, and in all."""
    chosen = {"normal": "newton"} if scene.motion is None else {"tangential": "newton"}
    best, repeats = np.inf, 3
    while repeats > 0:
        with products() as sizes:
            begun = time.process_time()
            solution = vc.solve(scene, **chosen)
            best = min(best, time.process_time() - begun)
        repeats -= 1 if solution.elements["contact"] <= 20_000 else 3
    finest = max(sizes)
    return solution.elements["contact"], best, sizes.count(finest), sum(sizes) / finest


def peak(cells: int) -> float:
    """Mebibytes of a process that solves a steady case, beyond those after its imports."""
    with multiprocessing.get_context("spawn").Pool(1) as pool:
        return pool.apply(_peak, (cells,))


def _peak(cells: int) -> float:
    vc.solve(rubbed(8, 1.0, vc.Steady(vx=0.01)), tangential="newton")
    before = most_memory()
    vc.solve(rubbed(cells, 1.0, vc.Steady(vx=0.08, vy=0.08, spin=0.1)), tangential="newton")
    return (most_memory() - before) / 1024


def most_memory() -> int:
    """Kibibytes that this process had at most, as Linux counts them; `ru_maxrss` would count its parent's, too."""
    lines = Path("/proc/self/status").read_text().splitlines()
    return int(next(line for line in lines if line.startswith("VmHWM")).split()[1])


def main(*cells: int) -> None:
    """Print the table, and the machine."""
    versions = f"NumPy {np.__version__}, SciPy {scipy.__version__}, varcontact {vc.__version__}"
    print(f"{platform.machine()}, Python {platform.python_version()}, {versions}")
    print("| kind | cases | elements | seconds, median | most | products, finest grid, median | most | all, median |")
    print("|---|---|---|---|---|---|---|---|")
    vc.solve(rubbed(8, 1.0, vc.Steady(vx=0.01)), tangential="newton")  # imports
    for kind, scenes in KINDS.items():
        medians = []
        for count in cells:
            rows = np.array([measured(scene) for scene in scenes(count)])
            elements, seconds, finest, all_ = np.median(rows, axis=0)
            most = rows.max(axis=0)
            medians.append((elements, seconds, finest))
            print(
                f"| {kind} | {len(rows)} | {elements:.0f} | {seconds:.3f} | {most[1]:.3f} | {finest:.0f} | "
                f"{most[2]:.0f} | {all_:.0f} |",
                flush=True,
            )
        if len(cells) > 1:
            logs = np.log(medians).T
            exponents = [np.polyfit(logs[0], each, 1)[0] for each in logs[1:]]
            print(f"{kind}: seconds grow like N^{exponents[0]:.2f}, products like N^{exponents[1]:.2f}", flush=True)
    print(f"memory at {cells[-1]} cells, steady: {peak(cells[-1]):.0f} MiB")


if __name__ == "__main__":
    main(*(tuple(int(argument) for argument in sys.argv[1:]) or CELLS))
