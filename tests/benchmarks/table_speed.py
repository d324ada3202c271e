"""What the table book costs and how far it is off: ``python tests/benchmarks/table_speed.py [points]``.

Printed are triples a second in one call of 100 000, microseconds of a single call, and errors at random points between
the nodes against answers of an accuracy of 0.2 % on demand.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable

import numpy as np

import varcontact as vc
from varcontact.reference import no_slip_coefficients
from varcontact.theories import table_forces
from varcontact.theories.table_book import shipped, spin_scale


def least(work: Callable[[], object], times: int) -> float:
    """Seconds of the fastest of several calls."""
    found = []
    for _ in range(times):
        begun = time.perf_counter()
        work()
        found.append(time.perf_counter() - begun)
    return min(found)


def errors(points: int) -> tuple[np.ndarray, np.ndarray]:
    """Errors of Fx, Fy, Mz at random points, in parts of f Fz and f Fz sqrt(ab); and the ratios a/b."""
    generator, book = np.random.default_rng(0), shipped()
    found, ratios = [], []
    for _ in range(points):
        ratio = float(np.exp(generator.uniform(np.log(0.2), np.log(5))))
        direction = generator.normal(size=3)
        magnitude = np.exp(generator.uniform(np.log(0.05), np.log(30)))
        scale = spin_scale(no_slip_coefficients(ratio, book.nu), ratio)
        creepage = 1e-3 * magnitude * direction / np.linalg.norm(direction) / scale
        a, b = ratio**0.5, ratio**-0.5
        scene = vc.Scene(
            bodies=vc.Bodies(G=1.0, nu=book.nu),
            surface=vc.Ellipse(a=a, b=b),
            normal_force=1e-3,
            friction=1.0,
            motion=vc.Steady(vx=creepage[0], vy=creepage[1], spin=creepage[2]),
        )
        exact = vc.solve(scene, accuracy=0.002)
        table = table_forces(a, b, 1.0, 1e-3, creepage)
        found.append(np.array([*table.force, float(table.moment)]) - [*exact.force, exact.moment])
        ratios.append(ratio)
    return np.abs(found) / 1e-3, np.array(ratios)


def main() -> None:
    """Measure and print."""
    creepages = np.random.default_rng(0).normal(size=(100_000, 3)) * [1e-3, 1e-3, 0.2]
    many = least(lambda: table_forces(6e-3, 4e-3, 82e9, 3e4, creepages), 10)
    one = least(lambda: table_forces(6e-3, 4e-3, 82e9, 3e4, creepages[0]), 2000)
    print(f"{1e5 / many:.3g} triples a second, {1e6 * one:.0f} microseconds for one")
    found, ratios = errors(int(sys.argv[1]) if len(sys.argv) > 1 else 300)
    for least_ratio, greatest in ((0.2, 5.0), (0.4, 2.5)):
        chosen = found[(ratios >= least_ratio) & (ratios <= greatest)]
        quantiles = [np.quantile(chosen, q, axis=0) for q in (0.5, 0.95, 1.0)]
        cells = [" ".join(f"{100 * value:.2f}" for value in row) for row in quantiles]
        print(f"a/b {least_ratio:g} to {greatest:g}, {len(chosen)} points, errors of Fx, Fy, Mz in per cent of f Fz:")
        print(f"  median {cells[0]}; 95 % below {cells[1]}; largest {cells[2]}")


if __name__ == "__main__":
    main()
