"""What stresses below the surface cost: points one by one, and layers below all elements by FFT.

Run: python tests/benchmarks/stress_speed.py [repeats]

Printed are the median and the range of the seconds of several runs in this process, and the least processor time: on a
busy machine it comes nearer to what an idle one needs.
"""

from __future__ import annotations

import os
import platform
import statistics
import sys
import time
from collections.abc import Callable

import numpy as np

import varcontact as vc
from varcontact.elasticity.subsurface import field_at, field_below


def cases() -> dict[str, Callable[[], object]]:
    """Names and jobs."""
    rng = np.random.default_rng(0)
    grid = vc.Grid(nx=40, ny=25, dx=0.05, dy=0.08, x0=-1.0, y0=-1.0)
    large = vc.Grid(nx=256, ny=256, dx=2 / 256, dy=2 / 256, x0=-1.0, y0=-1.0)
    tractions, many = rng.normal(size=(3, *grid.shape)), rng.normal(size=(3, *large.shape))
    near, deep = rng.uniform(-2, 2, size=(2, 3, 1000))
    near[2], deep[2] = np.abs(near[2]), np.abs(deep[2]) + 20.0  # deep: by Gauss's rule
    depths = np.linspace(0.0, 1.0, 10)
    return {
        "1000 elements at 1000 points": lambda: field_at(near, grid, tractions, G=1.0, nu=0.28),
        "1000 elements at 1000 points, 10 contacts deep": lambda: field_at(deep, grid, tractions, G=1.0, nu=0.28),
        "1000 elements, 10 layers by FFT": lambda: field_below(depths, grid, tractions, G=1.0, nu=0.28),
        "256 x 256 elements, 1 layer by FFT": lambda: field_below(depths[5:6], large, many, G=1.0, nu=0.28),
    }


def main(repeats: int = 5) -> None:
    """Run all cases and print the table."""
    print(f"{platform.machine()}, {os.cpu_count()} cores, Python {platform.python_version()}, {repeats} runs each")
    for name, job in cases().items():
        job()  # what is imported on first use is no part of the case
        seconds, busy = [], []
        for _ in range(repeats):
            begun, used = time.perf_counter(), time.process_time()
            job()
            seconds.append(time.perf_counter() - begun)
            busy.append(time.process_time() - used)
        spread = f"{statistics.median(seconds):7.2f} s ({min(seconds):.2f} to {max(seconds):.2f})"
        print(f"{name:<50}{spread}, processor {min(busy):.2f} s")


if __name__ == "__main__":
    main(*(int(argument) for argument in sys.argv[1:]))
