"""Every solver over the number of elements: seconds, fitted exponents, and memory.

    python -m tests.benchmarks.solvers [CELLS ...]

Steady rolling of a circle with creepages and spin by every tangential solver, and a wavy sphere pressed by every normal
one, each in a process of its own: processor seconds of the second of two calls of `solve` (the least of three up to 400
elements), with the gap but without the bound on forces, and mebibytes at the peak beyond those after a small call.
Solvers that are not installed are named. A solver is left out on grids where it would take more than a minute, judged
by the grid before.
"""

import multiprocessing
import platform
import sys
import time

import numpy as np

import varcontact as vc
from tests.benchmarks.many_elements import CREEPAGES, most_memory, pressed, rubbed

CELLS = (12, 20, 32, 48)
LONGEST = 60.0
NORMAL = ("norm", "newton", "clarabel", "scs", "osqp")
TANGENTIAL = ("tang", "tang-exact", "tang-safeguarded", "newton", "clarabel", "scs", "cvxpy:CLARABEL")


def scene(problem: str, cells: int) -> vc.Scene:
    """The scene of a normal or of a tangential problem."""
    if problem == "normal":
        return pressed(cells)
    vx, vy, spin = CREEPAGES[1]
    return rubbed(cells, 1.0, vc.Steady(vx=vx, vy=vy, spin=spin))


def solved(problem: str, name: str, cells: int) -> tuple[float, vc.Solution]:
    """Processor seconds of a call, and its solution, converged or not."""
    begun = time.process_time()
    try:
        solution = vc.solve(scene(problem, cells), **{problem: name}, polish=False, tol=1e-6, certify="gap")
    except vc.NotConverged as failure:
        solution = failure.solution
    return time.process_time() - begun, solution


def measured(problem: str, name: str, cells: int) -> tuple[int, float, float, float]:
    """Elements in contact, seconds, mebibytes, and the residual that was reached."""
    solved(problem, name, 6)
    before = most_memory()
    taken, solution = solved(problem, name, cells)
    peak = (most_memory() - before) / 1024
    for _ in range(3 if solution.elements["contact"] <= 400 else 1):
        taken = min(taken, solved(problem, name, cells)[0])
    return solution.elements["contact"], taken, peak, solution.certificate.residual


def main(*cells: int) -> None:
    """Print the table, and the machine."""
    print(f"{platform.machine()}, Python {platform.python_version()}, varcontact {vc.__version__}")
    print("| problem | solver | elements: seconds, MiB, residual | seconds grow like |")
    print("|---|---|---|---|")
    for problem, names in (("normal", NORMAL), ("tangential", TANGENTIAL)):
        for name in names:
            rows = []
            for count in cells:
                if len(rows) > 1 and rows[-1][1] ** 2 / rows[-2][1] > LONGEST:
                    break
                with multiprocessing.get_context("spawn").Pool(1) as pool:
                    try:
                        rows.append(pool.apply(measured, (problem, name, count)))
                    except vc.SolverUnavailable as missing:
                        print(missing)
                        break
            if not rows:
                continue
            figures = "; ".join(f"{n}: {taken:.2g}, {peak:.0f}, {residual:.0e}" for n, taken, peak, residual in rows)
            large = np.log([row[:2] for row in rows if row[0] > 100])
            growth = f"N^{np.polyfit(*large.T, 1)[0]:.1f}" if len(large) > 1 else ""
            print(f"| {problem} | {name} | {figures} | {growth} |", flush=True)


if __name__ == "__main__":
    main(*(tuple(int(argument) for argument in sys.argv[1:]) or CELLS))
