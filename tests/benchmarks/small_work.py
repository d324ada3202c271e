"""Small work in sequence: histories, small contacts, wheels, a theory, commands; and whether what is
kept between solves ever answers for another scene.
"""

import math
import os
import resource
import subprocess
import sys
import tempfile
from collections.abc import Callable, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace
from functools import partial
from itertools import cycle, islice
from multiprocessing import get_context
from pathlib import Path

import numpy as np

import varcontact as vc
from tests.benchmarks.table import Table, least
from tests.random_scenes import KINDS, scenes
from tests.scenes import LIKE, make_scene
from tests.wheel_rail.conditions import benchmark, manchester
from varcontact.wheel_rail.case_file import CaseFile, solve_cases

UNLIKE = vc.Bodies(G=(1.0, math.inf), nu=(0.286, 0.286))
STEEL = vc.Bodies(G=82e3, nu=0.28)
ROLLING = vc.Steady(vx=4e-3, vy=1e-3, spin=2e-3)
SHIFT = vc.Shift(ux=5e-3, uy=2e-3)
LOAD = 0.4705
SPHERES = vc.Paraboloids(Rx=168.75, Ry=168.75)
THEORIES = "fastsim", "fastrip", "strip", "polach", "linear"
WHEEL = """
vertical_force = 80e3
[track]
rail = "60e1"
cant = 0.025
[wheelset]
wheel = "s1002"
radius = 460.0
[position]
y = 3.0
[velocity]
speed = 20e3
"""
LAYER = vc.ThirdBody(h=0.02, G=820.0, tau_c0=100.0, k_tau=2000.0)


def spheres(cells: int, motion: vc.Steady | vc.Shift | None) -> vc.Scene:
    """Kalker's spheres of figure 36, so many elements across."""
    return make_scene(SPHERES, LOAD, motion, vc.Grid(nx=cells, ny=cells), 0.4013, LIKE)


def cattaneo_to_carter(steps: int) -> vc.Scene:
    """The same of 616 elements: a shift, then rolling under its force."""
    side = 7.0 / 28
    motion = vc.Transient(steps=steps, dq=[0.0] + [side] * (steps - 1), Fx=-0.657 * 0.4013 * LOAD)
    grid = vc.Grid(nx=28, ny=28, dx=side, dy=side, x0=-3.5, y0=-3.5)
    return make_scene(SPHERES, LOAD, motion, grid, 0.4013, LIKE)


def cylinders(
    bodies: vc.Bodies, motion: vc.Steady | vc.Transient, friction: float, cells: int = 128
) -> vc.Scene:
    """Kalker's cylinders of half-width 1."""
    radius = bodies.combined_G / (2 * (1 - bodies.combined_nu))
    grid = vc.Grid(nx=round(1.2 * cells), dx=2 / cells, x0=-1.2)
    return make_scene(vc.Cylinders(R=radius), math.pi / 2, motion, grid, friction, bodies)


def line_history(steps: int) -> vc.Scene:
    """A shift of cylinders of 128 elements, then rolling."""
    motion = vc.Transient(steps=steps, dq=[0.0] + [2 / 128] * (steps - 1), Fx=-0.75 * math.pi / 2)
    return cylinders(LIKE, motion, 1.0)


def indentation(steps: int) -> vc.Scene:
    """Spence's: unlike cylinders pressed together step by step."""
    loads = [math.pi / 2 * ((k + 1) / steps) ** 2 for k in range(steps)]
    return cylinders(
        UNLIKE, vc.Transient(steps=steps, dq=0.0, Fx=0.0, normal_force=loads), 0.15, 64
    )


def with_layer() -> vc.Scene:
    """A ball over a third body that yields."""
    motion = vc.Steady(vx=-4e-3)
    return make_scene(
        vc.Paraboloids(625.0, 625.0),
        1e5,
        motion,
        vc.Grid(nx=14, ny=14),
        bodies=STEEL,
        third_body=LAYER,
    )


def of_histories(quick: bool) -> dict[str, float]:
    """Seconds of a step."""
    made: dict[str, tuple[Callable[[int], vc.Scene], int]] = {
        "history of 616 elements, a step": (cattaneo_to_carter, 57),
        "history of 128 elements in line, a step": (line_history, 129),
        "indentation of unlike cylinders, a step": (indentation, 35),
    }
    found = {}
    for name, (history, steps) in made.items():
        if quick:
            steps = 5
        found[name] = least(partial(vc.solve, history(steps))) / steps
    # as many steps as only a file holds: a step costs the same
    steps = 20 if quick else 4000
    line = line_history(steps)
    with tempfile.TemporaryDirectory() as folder:
        store = Path(folder) / "history.nc"
        stored = least(partial(vc.solve, line, store=store), 1)
    found[f"{steps} steps in line, in memory, a step"] = least(partial(vc.solve, line), 1) / steps
    found[f"{steps} steps in line, in a file, a step"] = stored / steps
    return found


def of_contacts(quick: bool) -> dict[str, float]:
    """Seconds of a contact."""
    found: dict[str, float] = {}
    times = 2 if quick else 7
    for cells, elements in ((8, 52), (11, 97), (16, 208), (26, 540), (32, 812)):
        name = f"rolling, {elements} elements"
        found[name] = least(partial(vc.solve, spheres(cells, ROLLING)), times)
    found["shift, 812 elements"] = least(partial(vc.solve, spheres(32, SHIFT)), times)
    normal = partial(vc.solve, spheres(32, None), normal="newton")
    found["normal problem, 812 elements"] = least(normal, times)
    line = cylinders(UNLIKE, vc.Steady(vx=1e-3), 0.15)
    found["unlike cylinders, 128 elements"] = least(partial(vc.solve, line), times)
    found["third body that yields"] = least(partial(vc.solve, with_layer()), times)
    for name in THEORIES:
        theory = partial(vc.solve, spheres(20, ROLLING), tangential=name)
        found[f"{name}, 20 x 20 elements"] = least(theory, times)
    for accuracy in (0.1, 0.03, 0.01):
        free = replace(spheres(8, ROLLING), grid="auto")
        name = f"accuracy = {accuracy:g}"
        found[name] = least(partial(vc.solve, free, accuracy=accuracy), times)
    return found


def of_wheels(quick: bool) -> dict[str, float]:
    """Seconds of a position of the Manchester benchmark, the mean of a side, and of 1 000 in a
    sweep.
    """
    rows = [row for row in manchester() if row["side"] == "left"]
    chosen = rows[:: 10 if quick else 2]
    found: dict[str, float] = {}
    for side in (0.2, 0.5, 1.0):
        cases = [benchmark(row, dx=side, dy=side) for row in chosen]
        seconds = least(lambda c=cases: [each.solve() for each in c], 1 if quick else 2)
        found[f"wheel, elements of {side:g} mm"] = seconds / len(cases)
    count = 42 if quick else 1000
    many = [benchmark(row, dx=1.0, dy=1.0) for row in islice(cycle(rows), count)]
    file = CaseFile(tuple(many), tuple(range(1, count + 1)), {}, None, False)
    found["1 000 wheels in a sweep, elements of 1 mm"] = least(
        partial(solve_cases, file), 1 if quick else 2
    ) * (1000 / count)
    return found


def of_commands(quick: bool) -> dict[str, float]:
    """Processor seconds of a command, from its start."""
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "scene.toml"
        file.write_text(spheres(8, ROLLING).to_toml())
        solve = [sys.executable, "-m", "varcontact", "solve", str(file)]
        started = [sys.executable, "-c", "import varcontact"]
        case = Path(folder) / "wheel.toml"
        case.write_text(WHEEL)
        wheel = [sys.executable, "-m", "varcontact", "wheelrail", str(case)]
        return {
            "import varcontact": min(_of_process(started) for _ in range(3)),
            "varcontact solve, 52 elements": min(_of_process(solve) for _ in range(3)),
            "varcontact wheelrail": min(_of_process(wheel) for _ in range(3)),
        }


def _of_process(arguments: Sequence[str]) -> float:
    """Processor seconds of a process that finds its modules compiled."""
    environment = {
        name: value for name, value in os.environ.items() if name != "PYTHONDONTWRITEBYTECODE"
    }
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    subprocess.run(arguments, check=True, capture_output=True, env=environment)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


GROUPS: tuple[Callable[[bool], dict[str, float]], ...] = (
    of_histories,
    of_contacts,
    of_wheels,
    of_commands,
)


def small_work(quick: bool) -> Table:
    """Processor milliseconds of small work: a step, a contact, a wheel, a command."""
    rows = [[name, 1e3 * each] for group in GROUPS for name, each in group(quick).items()]
    return Table(["work", "ms"], ["", ".3g"], rows)


# ----------------------------------------------------------------------------- what is kept


def answer(kind: str, number: int) -> bytes:
    """Tractions and pressure of a random scene on few elements, or its refusal."""
    scene = scenes(kind, number + 1, 58)[number]
    if scene.line:
        grid = vc.Grid(nx=14)
    else:
        grid = vc.Grid(nx=10, ny=9)
    try:
        found = vc.solve(replace(scene, grid=grid))
    except vc.VarcontactError as error:
        return str(error).encode()
    if isinstance(found, vc.History):
        found = found[-1]
    return found.traction.tobytes() + found.pressure.tobytes()


def answers_that_differ(count: int) -> list[tuple[str, int]]:
    """Random scenes whose answers among others are not those of a process of their own, to the
    bit.
    """
    chosen = [(KINDS[k % len(KINDS)], k // len(KINDS)) for k in range(count)]
    context = get_context("spawn")
    with ProcessPoolExecutor(1, mp_context=context, max_tasks_per_child=1) as pool:
        fresh = dict(zip(chosen, pool.map(answer, *zip(*chosen, strict=True)), strict=True))
    order = np.random.default_rng(0).permutation(2 * count) % count
    return [chosen[k] for k in order if answer(*chosen[k]) != fresh[chosen[k]]]


def alternating(quick: bool) -> Table:
    """Random scenes in one process, twice each in a random order: how many of their answers are not
    those of a fresh process, to the bit.
    """
    count = 4 if quick else 200
    return Table(
        ["scenes", "answers that differ"], ["", ""], [[count, len(answers_that_differ(count))]]
    )
