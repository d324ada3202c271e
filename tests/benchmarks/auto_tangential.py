"""Which tangential solver `auto` should choose: Clarabel, polished, beside the safeguarded TANG.

Run with one thread, OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1 RAYON_NUM_THREADS=1:
python tests/benchmarks/auto_tangential.py [cells ...]

Both solve each scene of the standard bank, all of it by `varcontact.solving.solve`. Processor seconds of the tangential
problem, of all passes where the bodies differ; the least of three, one alone from 30 elements across.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager

import numpy as np

import varcontact as vc
from varcontact.solving.contact_solver import ContactSolver

METHODS = ("clarabel", "tang-safeguarded")


@contextmanager
def tangential_seconds() -> Iterator[list[float]]:
    """Processor seconds of each call of the tangential step while inside."""
    taken: list[float] = []
    step = ContactSolver.traction

    def timed(self, disc, state):
        begun = time.process_time()
        after = step(self, disc, state)
        taken.append(time.process_time() - begun)
        return after

    ContactSolver.traction = timed
    try:
        yield taken
    finally:
        ContactSolver.traction = step


def measured(scene: vc.Scene, method: str, times: int) -> tuple[float, int, vc.Solution]:
    """Least seconds of the tangential problem, its number of calls, and the solution, converged or not."""
    best = np.inf
    for _ in range(times):
        with tangential_seconds() as taken:
            try:
                solution = vc.solve(scene, tangential=method)
            except vc.NotConverged as failure:
                solution = failure.solution
        best = min(best, sum(taken))
    return best, len(taken), solution


def main(*cells: int) -> None:
    """One line for each scene and grid."""
    print("| scene | elements | clarabel, polished | tang-safeguarded | ratio | calls | distance of forces |")
    print("|---|---|---|---|---|---|---|")
    for count in cells:
        for name, scene in vc.standard_bank(count).items():
            rows = [measured(scene, method, 3 if count < 30 else 1) for method in METHODS]
            (slow, calls, one), (fast, _, other) = rows
            largest = np.max(scene.friction) * one.normal_force
            apart = np.hypot(*(one.force - other.force)) / largest
            timed = [f"{seconds:.3f} s, {sol.certificate.residual:.0e}" for seconds, _, sol in rows]
            print(
                f"| {name} | {one.elements['contact']} | {timed[0]} | {timed[1]} | {slow / fast:.1f} | {calls} | "
                f"{apart:.0e} |",
                flush=True,
            )


if __name__ == "__main__":
    main(*map(int, sys.argv[1:] or ("12", "20", "32")))
