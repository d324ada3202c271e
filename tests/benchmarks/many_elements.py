"""Seconds of active sets and of Newton's method without a matrix, side by side, over the number of elements.

    python tests/benchmarks/many_elements.py [REPEATS]

Each row is one grid: steady rolling of a circle and of an ellipse with a/b = 5, with mixed creepages, by both methods
in turn. The seconds are the least and the most of all repeats of the whole call, once without the certificate's bound
on forces. Active sets are left out where they would take minutes.
"""

import itertools
import platform
import sys
import time

import varcontact as vc

CELLS = (8, 12, 16, 20, 24, 28, 32, 36, 48, 64, 128, 256)
DENSE_CELLS = 36


def scene(cells: int, a: float, b: float) -> vc.Scene:
    """Rolling with creepages and spin that leave about half of the contact to slip."""
    return vc.Scene(
        bodies=vc.Bodies(G=1.0, nu=0.28),
        surface=vc.Ellipse(a=a, b=b),
        normal_force=1.0,
        friction=0.3,
        motion=vc.Steady(vx=0.05, vy=-0.03, spin=0.05),
        grid=vc.Grid(nx=cells, ny=cells),
    )


def seconds(posed: vc.Scene, method: str, repeats: int) -> str:
    """Least and most seconds of a solve."""
    taken = []
    for _ in range(repeats):
        begun = time.perf_counter()
        vc.solve(posed, tangential=method, certify="gap")
        taken.append(time.perf_counter() - begun)
    return f"{min(taken):.3f} to {max(taken):.3f}"


def main(repeats: int = 3) -> None:
    """Print the table, and the machine."""
    print(f"{platform.machine()}, Python {platform.python_version()}, varcontact {vc.__version__}")
    print(f"{'a/b':>5}{'elements':>10}{'tang-safeguarded':>20}{'newton':>20}")
    vc.solve(scene(8, 1.0, 1.0), tangential="newton")  # imports
    for (a, b), cells in itertools.product(((1.0, 1.0), (5.0, 1.0)), CELLS):
        posed = scene(cells, a, b)
        count = vc.plan(posed).sizes.elements["tangential"]
        dense = seconds(posed, "tang-safeguarded", repeats) if cells <= DENSE_CELLS else "-"
        print(f"{a / b:>5g}{count:>10}{dense:>20}{seconds(posed, 'newton', repeats):>20}", flush=True)


if __name__ == "__main__":
    main(*(int(argument) for argument in sys.argv[1:]))
