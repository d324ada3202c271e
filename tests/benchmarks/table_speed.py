"""What the table book costs and how far it is off: ``python tests/benchmarks/table_speed.py [points] [seed]``.

Printed are the first call of a program, triples a second in one call of 100 000, microseconds of a single call, errors
at random points between the nodes against answers of an accuracy of 0.1 % on demand, and how far the resistance falls
along rays of creepages.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable

import numpy as np

import varcontact as vc
from varcontact.reference import no_slip_coefficients
from varcontact.theories import table_forces
from varcontact.theories.table_book import reduced_scales, shipped


def least(work: Callable[[], object], times: int) -> float:
    """Seconds of the fastest of several calls."""
    found = []
    for _ in range(times):
        begun = time.perf_counter()
        work()
        found.append(time.perf_counter() - begun)
    return min(found)


def errors(points: int, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Errors of Fx, Fy, Mz at random points, in parts of f Fz and f Fz sqrt(ab); and the ratios a/b."""
    generator, book = np.random.default_rng(seed), shipped()
    found, ratios = [], []
    for _ in range(points):
        ratio = float(np.exp(generator.uniform(np.log(0.2), np.log(5))))
        direction = generator.normal(size=3)
        magnitude = np.exp(generator.uniform(np.log(0.05), np.log(30)))
        scale = reduced_scales(no_slip_coefficients(ratio, book.nu), ratio)
        creepage = 1e-3 * magnitude * direction / np.linalg.norm(direction) / scale
        a, b = ratio**0.5, ratio**-0.5
        scene = vc.Scene(
            bodies=vc.Bodies(G=1.0, nu=book.nu),
            surface=vc.Ellipse(a=a, b=b),
            normal_force=1e-3,
            friction=1.0,
            motion=vc.Steady(vx=creepage[0], vy=creepage[1], spin=creepage[2]),
        )
        exact = vc.solve(scene, accuracy=0.001)
        table = table_forces(a, b, 1.0, 1e-3, creepage)
        found.append(np.array([*table.force, float(table.moment)]) - [*exact.force, exact.moment])
        ratios.append(ratio)
    return np.abs(found) / 1e-3, np.array(ratios)


def ripples(seed: int, turning: float) -> np.ndarray:
    """Of 2000 rays of creepages, what the resistance loses after it has risen, in parts of its largest value."""
    generator, book, t = np.random.default_rng(seed), shipped(), np.linspace(0.0, 0.995, 400)
    found = []
    for ratio in np.exp(generator.uniform(np.log(0.2), np.log(5), 20)):
        scale = reduced_scales(no_slip_coefficients(float(ratio), book.nu), ratio)
        rays = generator.normal(size=(100, 3)) * [1.0, 1.0, turning]
        rays /= np.linalg.norm(rays, axis=1)[:, None] * scale
        table = table_forces(ratio**0.5, ratio**-0.5, 1.0, 1.0, np.multiply.outer(1.5 * t / (1 - t), rays))
        resistance = -(table.force * rays[:, :2]).sum(axis=-1) - table.moment * rays[:, 2]
        lost = np.maximum.accumulate(resistance) - resistance
        found.append(lost.max(axis=0) / resistance.max(axis=0))
    return np.concatenate(found)


def main() -> None:
    """Measure and print."""
    points, seed = (int(word) for word in (sys.argv[1:] + ["300", "0"][len(sys.argv) - 1 :])[:2])
    contact = {"b": 4e-3, "G": 82e9, "nu": 0.28, "normal_force": 1e5, "friction": 0.3}
    generator = np.random.default_rng(0)
    creepages = generator.normal(size=(100_000, 3)) * [1e-3, 1e-3, 0.2]
    several, (vx, vy, spin) = {**contact, "a": generator.uniform(2e-3, 1e-2, 100_000)}, creepages.T
    one = {"vx": 1e-3, "vy": 2e-4, "spin": 0.1}
    ratios = iter(generator.uniform(0.3, 4.0, 10**6).tolist())
    first = least(lambda: table_forces(6e-3, 4e-3, 82e9, 3e4, (1e-3, 0.0, 0.0)), 1)
    many = least(lambda: table_forces(6e-3, 4e-3, 82e9, 3e4, creepages), 10)
    ellipses = least(lambda: vc.creep_forces("table", **several, vx=vx, vy=vy, spin=spin), 5)
    single = least(lambda: [table_forces(6e-3, 4e-3, 82e9, 3e4, (1e-3, 2e-4, 0.1)) for _ in range(20)], 100) / 20
    named = least(lambda: [vc.creep_forces("table", a=6e-3, **contact, **one) for _ in range(20)], 100) / 20
    fresh = least(lambda: [table_forces(next(ratios), 1.0, 1e9, 3e4, (1e-3, 2e-4, 0.1)) for _ in range(20)], 100) / 20
    rates = f"{1e5 / many:.3g} triples a second, {1e5 / ellipses:.3g} with as many ellipses"
    print(f"first call {1e3 * first:.0f} ms; {rates}")
    print(
        f"one call: {1e6 * single:.0f} microseconds, by name {1e6 * named:.0f}, of another a/b each {1e6 * fresh:.0f}"
    )
    for name, turning in (("with spin", 1.0), ("without", 0.0)):
        lost = 100 * np.quantile(ripples(seed, turning), (0.5, 0.95, 1.0))
        words = f"median {lost[0]:.3f} %, 95 % below {lost[1]:.3f} %, most {lost[2]:.3f} %"
        print(f"resistance lost along rays {name}: {words}")
    found, ratio = errors(points, seed)
    for least_ratio, greatest in ((0.2, 5.0), (0.4, 2.5)):
        chosen = found[(ratio >= least_ratio) & (ratio <= greatest)]
        quantiles = [np.quantile(chosen, q, axis=0) for q in (0.5, 0.95, 1.0)]
        cells = [" ".join(f"{100 * value:.2f}" for value in row) for row in quantiles]
        print(f"a/b {least_ratio:g} to {greatest:g}, {len(chosen)} points, errors of Fx, Fy, Mz in per cent of f Fz:")
        print(f"  median {cells[0]}; 95 % below {cells[1]}; largest {cells[2]}")


if __name__ == "__main__":
    main()
