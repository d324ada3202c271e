"""What the main job costs: import, rolling as chosen and by the conic road at about 300 and 800 contact elements, FFT.

Run: python tests/benchmarks/main_job.py [repeats]

Each case runs in a fresh process, several times; printed are the median and the range of the seconds, and the
peak memory above that of the process before the case, in units of one dense matrix of its contact elements.
"""

from __future__ import annotations

import json
import os
import platform
import statistics
import subprocess
import sys
import time

CASES = {
    "import varcontact": "import",
    "steady rolling, as chosen, 316 elements": "auto 20",
    "steady rolling, as chosen, 812 elements": "auto 32",
    "steady rolling, conic, 316 elements": "clarabel 20",
    "steady rolling, conic, 812 elements": "clarabel 32",
    "pressure on 256 x 256 cells, Hertz, with certificate": "normal 256",
    "certificate of given tractions on 256 x 256 cells": "certify 256",
}


def scene(cells: int, rolling: bool = True):
    """Combined creepage and spin on a circle, half of it slipping."""
    import varcontact as vc

    return vc.Scene(
        bodies=vc.Bodies(G=1.0, nu=0.28),
        surface=vc.Ellipse(a=1.0, b=1.0),
        normal_force=1.0,
        friction=0.3,
        motion=vc.Steady(vx=0.06, vy=0.02, spin=0.08) if rolling else None,
        grid=vc.Grid(nx=cells, ny=cells),
    )


def peak_memory() -> float:
    """Peak memory of this process so far, bytes."""
    import resource

    return 1024.0 * resource.getrusage(resource.RUSAGE_SELF).ru_maxrss


def run(case: str) -> dict[str, float]:
    """Run one case in this process: seconds, memory and elements."""
    begun = time.perf_counter()
    import varcontact as vc

    if case == "import":
        return {"seconds": time.perf_counter() - begun}
    kind, cells = case.split()
    tangential = "clarabel" if kind == "clarabel" else "auto"
    vc.solve(scene(4), tangential=tangential)  # what is imported on first use is no part of the case
    job = scene(int(cells), rolling=kind != "normal")
    before = peak_memory()
    begun = time.perf_counter()
    if kind == "certify":
        import numpy as np

        grid = job.hertz
        cells_with_margin = int(cells) + 2
        x = (np.arange(cells_with_margin) + 0.5) * 2 * grid.a / int(cells) - grid.a - 2 * grid.a / int(cells)
        bound = 0.3 * grid.pressure(x[None, :], x[:, None])
        vc.certify(job, np.array([-0.5 * bound, -0.1 * bound]))
        return {"seconds": time.perf_counter() - begun, "bytes": peak_memory() - before}
    sol = vc.solve(job, tangential=tangential)
    seconds = time.perf_counter() - begun
    return {"seconds": seconds, "bytes": peak_memory() - before, "elements": sol.elements["contact"]}


def main(repeats: int = 5) -> None:
    """Run all cases and print the table."""
    print(f"{platform.machine()}, {os.cpu_count()} cores, Python {platform.python_version()}, {repeats} runs each")
    for name, case in CASES.items():
        results = []
        for _ in range(repeats):
            done = subprocess.run(
                [sys.executable, __file__, "--case", case], capture_output=True, text=True, check=True
            )
            results.append(json.loads(done.stdout))
        seconds = [result["seconds"] for result in results]
        line = f"{name:<54}{statistics.median(seconds):7.2f} s ({min(seconds):.2f} to {max(seconds):.2f})"
        if "bytes" in results[0]:
            used = max(result["bytes"] for result in results)
            line += f", {used / 2**20:.0f} MiB"
            if results[0].get("elements") and "normal" not in case:
                line += f" = {used / (8 * (2 * results[0]['elements']) ** 2):.1f} dense matrices"
        print(line)


if __name__ == "__main__":
    if sys.argv[1:2] == ["--case"]:
        print(json.dumps(run(sys.argv[2])))
    else:
        main(*(int(argument) for argument in sys.argv[1:]))
