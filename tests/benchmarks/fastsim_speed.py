"""What the fast theories and the active-set methods cost: FASTSIM 10 x 20, NORM and TANG at about 800 elements.

Run: python tests/benchmarks/fastsim_speed.py [repeats]

Each case runs in a fresh process with one thread, several times; printed are the median and the range. NORM and
TANG solve problems that are set up before; the time is that of the method alone, with the assembly of its matrices.
"""

from __future__ import annotations

import json
import os
import platform
import statistics
import subprocess
import sys
import time
from typing import Any

TRIPLES = 100_000
CELLS = 32
CASES = {
    f"FASTSIM 10 x 20, {TRIPLES} triples in one call": "fastsim",
    "FASTSIM 10 x 20, one triple": "fastsim-one",
    "NORM, from no contact": "norm",
    "NORM, one element at a time, from no contact": "norm-single",
    "NORM, from the pressure at 1 % less force": "norm-near",
    "TANG as printed, creepage": "tang-exact creepage",
    "TANG, creepage": "tang creepage",
    "TANG safeguarded, creepage": "tang-safeguarded creepage",
    "TANG as printed, creepage and spin": "tang-exact combined",
    "TANG, creepage and spin": "tang combined",
    "TANG safeguarded, creepage and spin": "tang-safeguarded combined",
}
MOTIONS = {"creepage": (0.1, 0.0, 0.0), "combined": (0.06, 0.02, 0.08)}


def fastsim_seconds(count: int) -> dict[str, Any]:
    """So many triples in one call."""
    import numpy as np

    from varcontact.reference import creepage_coefficients
    from varcontact.theories import fastsim

    table = creepage_coefficients(6.8, 6.5, 0.28)
    creepages = np.random.default_rng(0).normal(size=(count, 3)) * (2e-3, 2e-3, 4e-4)
    fastsim(6.8, 6.5, 8.2e4, 45000.0, creepages[:2], table, m=10, n=20)
    begun = time.perf_counter()
    fastsim(6.8, 6.5, 8.2e4, 45000.0, creepages, table, m=10, n=20)
    return {"seconds": time.perf_counter() - begun, "triples": count}


def discretised(cells: int, motion: tuple[float, float, float]):
    """A circle with friction 0.3, so many elements across, as in main_job.py."""
    import varcontact as vc
    from varcontact.discrete.discretisation import discretise

    vx, vy, spin = motion
    scene = vc.Scene(
        bodies=vc.Bodies(G=1.0, nu=0.28),
        surface=vc.Ellipse(a=1.0, b=1.0),
        normal_force=1.0,
        friction=0.3,
        motion=vc.Steady(vx=vx, vy=vy, spin=spin),
        grid=vc.Grid(nx=cells, ny=cells),
    )
    return discretise(scene, scene.grid.spread((-1.0, 1.0, -1.0, 1.0)))


def norm_seconds(kind: str, cells: int) -> dict[str, Any]:
    """The normal problem with its force prescribed."""
    from dataclasses import replace

    from varcontact.discrete.residuals import normal_residual
    from varcontact.solvers.active_set.norm import norm

    problem = discretised(cells, (0.0, 0.0, 0.0)).normal_problem().reachable()
    exchange = "one" if kind == "norm-single" else "set"
    start = norm(replace(problem, force=0.99 * problem.force)) if kind == "norm-near" else None
    begun = time.perf_counter()
    raw = norm(problem, start, exchange=exchange)
    seconds = time.perf_counter() - begun
    residual = normal_residual(problem, raw.traction, raw.rigid)
    contact = int((raw.traction > 0).sum())
    return {
        "seconds": seconds,
        "elements": contact,
        "steps": raw.iterations,
        "residual": residual,
        "status": raw.status,
    }


def tang_seconds(kind: str, motion: str, cells: int) -> dict[str, Any]:
    """The tangential problem of steady rolling under Hertz's pressure."""
    import numpy as np

    from varcontact.discrete.residuals import tangential_residual
    from varcontact.discrete.state import hertz_pressure, unloaded
    from varcontact.solvers.interface import Settings
    from varcontact.solvers.registry import tangential_solver

    disc = discretised(cells, MOTIONS[motion])
    problem = disc.tangential_problem(hertz_pressure(disc, unloaded(disc.grid)).pressure)
    begun = time.perf_counter()
    raw = tangential_solver(kind)(problem, Settings(), None)
    seconds = time.perf_counter() - begun
    slipping = float(np.mean(np.hypot(*raw.traction) > (1 - 1e-9) * problem.bound))
    return {
        "seconds": seconds,
        "elements": problem.size,
        "slipping": slipping,
        "steps": raw.iterations,
        "residual": tangential_residual(problem, raw.traction, raw.rigid),
        "status": raw.status,
    }


def run(case: str, cells: int = CELLS) -> dict[str, Any]:
    """Run one case in this process."""
    kind, _, motion = case.partition(" ")
    if kind.startswith("fastsim"):
        return fastsim_seconds(1 if kind == "fastsim-one" else TRIPLES)
    if kind.startswith("norm"):
        norm_seconds(kind, 6)  # what is imported on first use is no part of the case
        return norm_seconds(kind, cells)
    tang_seconds(kind, motion, 6)
    return tang_seconds(kind, motion, cells)


def line(name: str, results: list[dict[str, Any]]) -> str:
    """One case in words."""
    seconds = [result["seconds"] for result in results]
    first = results[0]
    middle, least, most = statistics.median(seconds), min(seconds), max(seconds)
    text = f"{name:<48}{middle:10.4f} s ({least:.4f} to {most:.4f})"
    if "triples" in first:
        return text + f", {first['triples'] / middle:.0f} triples per second"
    text += f", {first['elements']} elements"
    if "slipping" in first:
        text += f", {100 * first['slipping']:.0f} % slip"
    return text + f", {first['steps']} steps, {first['status']}, residual {first['residual']:.0e}"


def main(repeats: int = 5) -> None:
    """Run all cases and print the table."""
    machine = f"{platform.machine()}, one thread of {os.cpu_count()} cores, Python {platform.python_version()}"
    print(f"{machine}, {repeats} runs each")
    one = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1")
    for name, case in CASES.items():
        results = []
        for _ in range(repeats):
            done = subprocess.run(
                [sys.executable, __file__, "--case", case],
                capture_output=True,
                text=True,
                check=True,
                env=os.environ | one,
            )
            results.append(json.loads(done.stdout))
        print(line(name, results), flush=True)


if __name__ == "__main__":
    if sys.argv[1:2] == ["--case"]:
        print(json.dumps(run(sys.argv[2])))
    else:
        main(*(int(argument) for argument in sys.argv[1:]))
