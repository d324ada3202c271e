"""What a sweep costs, and what a second worker brings: ``python tests/benchmarks/sweep_speed.py [n]``.

500 scenes of 16 x 16 cells (25 frictions by 20 creepages) into a store, with one worker and with two, n times (3), each
in a new program, so that two workers have to begin. Imports of the program itself are not counted. Printed are wall
time and processor time, of the program and of the processes that it began. On a machine where nothing else runs, the
wall times are the answer; where something does, the processor times are: half of all that two workers and the program
spend is what they take together at best. Last, n times, the wall times of one process and of two that have begun, and
have solved a scene, before the sweep begins.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
import psutil

import varcontact as vc
from varcontact.study.parallel import processes

SCENE = vc.Scene(
    bodies=vc.Bodies(G=82e9, nu=0.28),
    surface=vc.Paraboloids(Rx=0.46, Ry=0.30),
    normal_force=106.7e3,
    friction=0.33,
    motion=vc.Steady(vx=1e-3, vy=2e-4, spin=0.1),
    grid=vc.Grid(nx=16, ny=16),
)
OVER = {"friction": np.linspace(0.2, 0.44, 25), "motion.vx": np.linspace(1e-4, 4e-3, 20)}
SCENES = int(np.prod([len(values) for values in OVER.values()]))


def spent(workers: int) -> dict[str, float]:
    """Wall seconds of a sweep, processor seconds of this process, and of the processes it began."""
    vc.sweep(SCENE, {"motion.vx": [1e-4, 2e-4]})  # what is imported when first used
    theirs = [0.0]

    def told(standing: object) -> None:
        if getattr(standing, "done", 0) == SCENES:  # while they are still there
            times = [child.cpu_times() for child in psutil.Process().children(recursive=True)]
            theirs[0] = sum(each.user + each.system for each in times)

    with tempfile.TemporaryDirectory() as folder:
        begun, own = time.perf_counter(), time.process_time()
        vc.sweep(SCENE, OVER, workers=workers, store=Path(folder) / "sweep.nc", progress=told)
        wall, own = time.perf_counter() - begun, time.process_time() - own
    return {"wall": wall, "own": own, "theirs": theirs[0]}


def once_begun(workers: int) -> float:
    """Wall seconds of a sweep in processes that have begun."""
    with processes(workers) as pool:
        list(pool.map(time.sleep, [0.3] * workers))
        vc.sweep(SCENE, {"motion.vx": np.linspace(1e-4, 3e-3, 16 * workers)}, executor=pool)
        begun = time.perf_counter()
        vc.sweep(SCENE, OVER, executor=pool)
        return time.perf_counter() - begun


def main() -> None:
    """Measure and print."""
    times = int(sys.argv[1]) if len(sys.argv) > 1 else 3
    print(f"{os.cpu_count()} processors, load {os.getloadavg()[0]:.1f}")
    print("workers  wall s  program's processor s  workers' processor s")
    found: dict[int, list[dict[str, float]]] = {1: [], 2: []}
    for _ in range(times):
        for workers, rows in found.items():
            call = [sys.executable, __file__, "--one", str(workers)]
            rows.append(json.loads(subprocess.run(call, check=True, capture_output=True, text=True).stdout))
            print(f"{workers:7} {rows[-1]['wall']:7.2f} {rows[-1]['own']:22.2f} {rows[-1]['theirs']:21.2f}")
    one, two = found.values()
    walls = sorted(a["wall"] / b["wall"] for a, b in zip(one, two, strict=True))
    shared = sorted(2 * a["own"] / (b["own"] + b["theirs"]) for a, b in zip(one, two, strict=True))
    print(f"two workers are {np.median(walls):.2f} ({walls[0]:.2f} to {walls[-1]:.2f}) times as fast by wall time,")
    print(f"{np.median(shared):.2f} ({shared[0]:.2f} to {shared[-1]:.2f}) by processor time if evenly shared")
    pairs = [(once_begun(1), once_begun(2)) for _ in range(times)]
    ratios = sorted(one / two for one, two in pairs)
    print("once begun, wall s: " + ", ".join(f"{one:.2f} and {two:.2f}" for one, two in pairs))
    print(f"two processes are {np.median(ratios):.2f} ({ratios[0]:.2f} to {ratios[-1]:.2f}) times as fast as one")


if __name__ == "__main__":
    if sys.argv[1:2] == ["--one"]:
        print(json.dumps(spent(int(sys.argv[2]))))
    else:
        main()
