"""What a sweep costs beside its solves, and what a second worker brings: ``python tests/benchmarks/sweep_speed.py``.

500 scenes of 16 x 16 cells (25 frictions by 20 creepages), with one worker process and with two. Printed are wall time
and processor time, of this process (the engine) and of the workers. Workers take about a second of processor time to
start, which a sweep of two scenes shows. On a machine where nothing else runs, the wall times are the answer; where
something does, the processor times are: those of the workers are shared by them, that of the engine is not.
"""

from __future__ import annotations

import os
import resource
import tempfile
import time
from pathlib import Path

import numpy as np

import varcontact as vc
from varcontact.study.engine import processes

SCENE = vc.Scene(
    bodies=vc.Bodies(G=82e9, nu=0.28),
    surface=vc.Paraboloids(Rx=0.46, Ry=0.30),
    normal_force=106.7e3,
    friction=0.33,
    motion=vc.Steady(vx=1e-3, vy=2e-4, spin=0.1),
    grid=vc.Grid(nx=16, ny=16),
)
OVER = {"friction": np.linspace(0.2, 0.44, 25), "motion.vx": np.linspace(1e-4, 4e-3, 20)}
FEW = {"motion.vx": [1e-4, 2e-4]}


def spent(over: dict[str, object], workers: int) -> tuple[float, float, float]:
    """Wall seconds of a sweep, processor seconds of this process, and of the processes it began."""
    with tempfile.TemporaryDirectory() as folder:
        before, begun, own = children(), time.perf_counter(), time.process_time()
        with processes(workers) as pool:
            vc.sweep(SCENE, over, executor=pool, chunk=1 if over is FEW else 8, store=Path(folder) / "sweep.nc")
        return time.perf_counter() - begun, time.process_time() - own, children() - before


def children() -> float:
    """Processor seconds of the processes that have ended."""
    usage = resource.getrusage(resource.RUSAGE_CHILDREN)
    return usage.ru_utime + usage.ru_stime


def main() -> None:
    """Measure and print."""
    vc.sweep(SCENE, FEW)  # what is imported when first used
    print(f"{os.cpu_count()} processors, load {os.getloadavg()[0]:.1f}")
    print("workers  scenes  wall s  engine s  engine ms a scene  workers' processor s")
    for workers in (1, 2):
        for over in (FEW, OVER):
            scenes = int(np.prod([len(values) for values in over.values()]))
            wall, own, theirs = spent(over, workers)
            print(f"{workers:7} {scenes:7} {wall:7.2f} {own:9.2f} {1e3 * own / scenes:18.2f} {theirs:21.2f}")


if __name__ == "__main__":
    main()
