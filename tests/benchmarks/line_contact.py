"""What line contact costs: methods side by side, with tractions of one component and of both.

Run: python tests/benchmarks/line_contact.py [elements ...]

Unlike bodies with 200 elements, like ones with 500, 1000 and 2000 (or as many as asked for), rolling under a third of
the force that friction carries. A lateral force of zero, prescribed, keeps both components: the rows of two components.
Each case runs in a fresh process; memory is the peak above that of the process before the case.
"""

from __future__ import annotations

import json
import os
import platform
import resource
import subprocess
import sys
import time

METHODS = {
    "clarabel": {"normal": "clarabel", "tangential": "clarabel"},
    "norm, tang": {"normal": "norm", "tangential": "tang"},
    "norm, tang-safeguarded": {"normal": "norm", "tangential": "tang-safeguarded"},
}

BOTH_UNTIL = 1000
"""Elements up to which both components are run as well: beyond, interior points take minutes and gigabytes."""


def scene(elements: int, unlike: bool, both: bool = False):
    """Driven rolling in line contact, a third of friction's force."""
    import varcontact as vc

    bodies = vc.Bodies(G=(1.0, float("inf")), nu=(0.0, 0.3)) if unlike else vc.Bodies(G=1.0, nu=0.28)
    return vc.Scene(
        bodies=bodies,
        surface=vc.Cylinders(R=1.0),
        normal_force=0.01,
        friction=0.3,
        motion=vc.Steady(Fx=-0.001, Fy=0.0 if both else None),
        grid=vc.Grid(nx=elements),
    )


def run(elements: int, unlike: bool, method: str, both: bool) -> dict[str, float]:
    """Run one case in this process: seconds by the wall and by the processor, memory, the residual."""
    import varcontact as vc

    vc.solve(scene(10, unlike, both), **METHODS[method])  # what is imported on first use is no part of the case
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    wall, processor = time.perf_counter(), time.process_time()
    sol = vc.solve(scene(elements, unlike, both), **METHODS[method])
    return {
        "wall": time.perf_counter() - wall,
        "processor": time.process_time() - processor,
        "MiB": (resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before) / 1024,
        "residual": sol.certificate.residual,
    }


def main(sizes: list[int]) -> None:
    """Run all cases and print the table."""
    print(f"{platform.machine()}, {os.cpu_count()} cores, OMP_NUM_THREADS={os.environ.get('OMP_NUM_THREADS', 'unset')}")
    print(f"{'elements':<14}{'method':<26}{'components':>10}{'wall s':>9}{'CPU s':>9}{'MiB':>8}{'residual':>10}")
    for elements, unlike in [(200, True), *((size, False) for size in sizes)]:
        for method in METHODS:
            for both in (False, True) if elements <= BOTH_UNTIL else (False,):
                case = json.dumps([elements, unlike, method, both])
                done = subprocess.run([sys.executable, __file__, "--case", case], capture_output=True, text=True)
                name = f"{elements} {'unlike' if unlike else 'like'}"
                line = f"{name:<14}{method:<26}{2 if both else 1:>10}"
                if done.returncode:
                    print(line, done.stderr.strip().splitlines()[-1], flush=True)
                    continue
                result = json.loads(done.stdout)
                line += f"{result['wall']:>9.2f}{result['processor']:>9.2f}{result['MiB']:>8.0f}"
                print(f"{line}{result['residual']:>10.1e}", flush=True)


if __name__ == "__main__":
    if sys.argv[1:2] == ["--case"]:
        print(json.dumps(run(*json.loads(sys.argv[2]))))
    else:
        main([int(argument) for argument in sys.argv[1:]] or [500, 1000, 2000])
