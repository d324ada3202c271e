"""Times: solvers by number of elements, many elements, problems in rows, sweeps, fast theories,
wheels on rails.
"""

import itertools
import multiprocessing
import tempfile
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np

import varcontact as vc
from tests.benchmarks.small_work import alternating, small_work
from tests.benchmarks.table import Table, least
from tests.scenes import make_scene, wheel_on_rail
from tests.wheel_rail.conditions import benchmark, manchester, wheel
from varcontact.theories.creep_forces import VECTORISED
from varcontact.wheel_rail import Position
from varcontact.wheel_rail.case_file import CaseFile, solve_cases

SHAPES = (0.2, 1.0, 5.0)
CREEPAGES = (
    (0.22, 0.0, 0.0),
    (0.08, 0.08, 0.1),
    (0.0, 0.0, 0.1),
    (0.0, 0.0, 0.8),
    (0.05, 0.1, -0.3),
)
OF_SLENDER = (
    (0.1, 0.0, 0.0),
    (0.04, 0.05, 0.03),
    (0.0, 0.0, 0.03),
    (0.0, 0.0, 0.4),
    (0.03, 0.05, -0.12),
)
TANGENTIAL = ("newton", "tang-safeguarded", "tang", "tang-exact", "clarabel", "scs")
CONTACT = {"a": 6e-3, "b": 4e-3, "G": 82e9, "nu": 0.28, "normal_force": 1e5, "friction": 0.3}
TRIPLES = 100_000


def with_friction(cells: int, shape: float, motion: vc.Steady | vc.Shift) -> vc.Scene:
    """An elliptic contact with a b = 1."""
    return make_scene(
        vc.Ellipse(a=shape**0.5, b=shape**-0.5), 50 / 27, motion, vc.Grid(nx=cells, ny=cells)
    )


def steady(cells: int) -> list[vc.Scene]:
    """Fifteen cases of rolling."""
    return [
        with_friction(
            cells, shape, vc.Steady(**dict(zip(("vx", "vy", "spin"), creepages, strict=True)))
        )
        for shape in SHAPES
        for creepages in (OF_SLENDER if shape == SHAPES[-1] else CREEPAGES)
    ]


def shifts(cells: int) -> list[vc.Scene]:
    return [with_friction(cells, shape, vc.Shift(ux=0.1, uy=0.05)) for shape in SHAPES]


def solvers(quick: bool) -> Table:
    """Seconds of every tangential solver by the number of elements, and the exponent of their
    growth.
    """
    cells, rows = (8, 12) if quick else (12, 20, 32), []
    sizes = [vc.solve(steady(n)[6], certify="none").elements["contact"] for n in cells]
    for name in TANGENTIAL:
        options = {"tangential": name, "polish": False, "tol": 1e-6, "certify": "gap"}
        seconds = [least(partial(vc.solve, steady(n)[6], **options), 2) for n in cells]
        growth = np.polyfit(np.log(sizes), np.log(seconds), 1)[0]
        rows.append([f"`{name}`", *seconds, f"$N^{{{growth:.1f}}}$"])
    return Table(
        ["tangential solver", *(f"{n} elements" for n in sizes), "growth"],
        ["", *(len(cells) * [".2g"]), ""],
        rows,
    )


def small_contacts(quick: bool) -> Table:
    """Milliseconds of each of many small contacts by `solve_many`, beside those of `solve`."""
    rows = []
    for cells in (8, 12) if quick else (8, 12, 16, 32):
        scenes = steady(cells) * (2 if quick else 20)
        together = least(lambda s=scenes: vc.solve_many(s), 2) / len(scenes)
        alone = least(lambda s=scenes: [vc.solve(each, certify="gap") for each in s[:15]], 1) / 15
        rows.append([f"{cells} x {cells}", 1e3 * together, 1e3 * alone, alone / together])
    return Table(
        ["elements across", "`solve_many`", "`solve`", "gain"], ["", ".2f", ".1f", ".0f"], rows
    )


def many_elements(quick: bool) -> Table:
    """Median seconds of `newton` by the number of elements, of rolling and of shifts."""
    cells = (32, 64) if quick else (32, 64, 128, 256, 512)
    sizes = [
        vc.solve(steady(n)[6], tangential="newton", certify="none").elements["contact"]
        for n in cells
    ]
    rows = []
    for name, made in (("steady rolling", steady), ("shift", shifts)):
        seconds = [
            [least(lambda s=s: vc.solve(s, tangential="newton"), 1) for s in made(n)] for n in cells
        ]
        rows.append([f"{name}, seconds", *map(float, map(np.median, seconds))])
    return Table(["elements", *map(str, sizes)], ["", *(len(cells) * [".3g"])], rows)


def most_memory() -> int:
    """Kibibytes that this process had at most, as Linux counts them; `ru_maxrss` would count its
    parent's, too.
    """
    lines = Path("/proc/self/status").read_text().splitlines()
    return int(next(line for line in lines if line.startswith("VmHWM")).split()[1])


def peak(name: str, cells: int) -> float:
    """Bytes of a call beyond those of a small one, by the square of the number of unknowns."""
    options = {"tangential": name, "polish": False, "tol": 1e-6, "certify": "gap"}
    vc.solve(steady(6)[6], **options)
    before = most_memory()
    unknowns = 2 * vc.solve(steady(cells)[6], **options).elements["contact"]
    return (most_memory() - before) * 1024 / (8 * unknowns**2)


def memory(quick: bool) -> Table:
    """Peak memory in dense matrices of the unknowns, each call in a process of its own."""
    found = []
    for name, cells in itertools.product(("tang", "clarabel", "scs"), (12,) if quick else (20, 32)):
        with multiprocessing.get_context("spawn").Pool(1) as pool:
            found.append([name, f"{cells}", pool.apply(peak, (name, cells))])
    return Table(["method", "cells", "dense matrices"], ["", "", ".2g"], found)


def sweeps(quick: bool) -> Table:
    """Processor milliseconds a scene of a sweep, without and with a store."""
    scene = wheel_on_rail(vc.Steady(vx=1e-3, vy=2e-4, spin=0.1), vc.Grid(nx=16, ny=16))
    over = {
        "friction": np.linspace(0.2, 0.44, 5 if quick else 25),
        "motion.vx": np.linspace(1e-4, 4e-3, 20),
    }
    per = 1e3 / np.prod([len(each) for each in over.values()])
    with tempfile.TemporaryDirectory() as folder:
        stores = [None, *(Path(folder) / f"{k}.nc" for k in range(3))]
        alone = least(lambda: vc.sweep(scene, over))
        kept = min(least(lambda s=store: vc.sweep(scene, over, store=s), 1) for store in stores[1:])
    return Table(
        ["", "ms a scene"], ["", ".3g"], [["sweep", per * alone], ["with a store", per * kept]]
    )


def fast_theories(quick: bool) -> Table:
    """Triples a second in a call of 100 000, and microseconds of a single call, of the vectorised
    theories.
    """
    vx, vy, spin = (
        np.random.default_rng(0).normal(size=(3, TRIPLES))
        * 1e-3
        * np.array([[3.2], [3.5], [650.0]])
    )
    rows = []
    for name in VECTORISED:
        turns = name != "vermeulen-johnson"
        many = {"vx": vx, "vy": vy, "spin": spin if turns else 0.0}
        one = {"vx": 1e-3, "vy": 2e-4, "spin": 0.1 if turns else 0.0}
        together = least(
            lambda m=many, n=name: vc.creep_forces(n, **CONTACT, **m), 1 if quick else 7
        )
        single = (
            least(lambda m=one, n=name: [vc.creep_forces(n, **CONTACT, **m) for _ in range(20)])
            / 20
        )
        rows.append([f"`{name}`", TRIPLES / together, 1e6 * single])
    return Table(["theory", "triples/s", "single call, µs"], ["", ".1e", ".0f"], rows)


def wheel_rail(quick: bool) -> Table:
    """Milliseconds of a wheel on a rail with a given load, elements of 0.5 mm: the exact way and
    the fast one.
    """
    chosen = manchester()[:: 20 if quick else 3]
    fast = {
        theory: {"outside": "clamp"} if theory == "table" else {} for theory in ("fastsim", "table")
    }
    ways = {"exact": lambda case: case.solve()} | {
        theory: lambda case, t=theory, o=options: case.estimate("hertz", t, **o)
        for theory, options in fast.items()
    }
    rows = []
    for name, way in ways.items():
        found = [
            1e3 * least(lambda r=row, w=way: w(benchmark(r, dx=0.5, dy=0.5))) for row in chosen
        ]
        rows.append([name, [float(np.median(found)), max(found)]])
    return Table(["way", "ms: median, largest"], ["", "{:.3g}, {:.3g}"], rows)


def wheel_rail_sweep(quick: bool) -> Table:
    """Milliseconds of each position of a wheel with a given load, elements of 1 mm: in a sweep, and
    alone.
    """
    one, count = wheel(dx=1.0, dy=1.0), 50 if quick else 1000
    cases = [
        replace(one, position=Position(y=float(y), yaw=1e-3)) for y in np.linspace(-5.0, 5.0, count)
    ]
    file = CaseFile(tuple(cases), tuple(range(count)), {}, None)
    together = least(lambda: solve_cases(file), 1) / count
    alone = least(lambda: [case.solve() for case in cases[:: count // 25]], 1) / len(
        cases[:: count // 25]
    )
    rows = [
        [f"sweep of {count} positions", 1e3 * together, 1 / together],
        ["alone", 1e3 * alone, 1 / alone],
    ]
    return Table(
        ["wheel on a rail", "ms a position", "positions a second"], ["", ".1f", ".0f"], rows
    )


TABLES = {
    "solvers": solvers,
    "many_elements": many_elements,
    "small_contacts": small_contacts,
    "memory": memory,
    "sweeps": sweeps,
    "fast_theories": fast_theories,
    "wheel_rail": wheel_rail,
    "wheel_rail_sweep": wheel_rail_sweep,
    "small_work": small_work,
    "alternating": alternating,
}
