"""BLAS has one thread while a scene is solved, and afterwards as many as before."""

import dataclasses
import dis
import os
import subprocess
import sys
from contextlib import contextmanager
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from threadpoolctl import ThreadpoolController, threadpool_info, threadpool_limits

import varcontact as vc
from tests.wheel_rail import conditions
from varcontact import energy
from varcontact.data.make_table_book import make_table_book
from varcontact.discrete.discretisation import discretise
from varcontact.reference.no_slip_ellipse import no_slip_ellipse
from varcontact.results.stress import stress
from varcontact.scene.interpolation import smoothed
from varcontact.system.process import VARIABLES, lazy_property, one_blas_thread


def counts():
    """Threads of the BLAS libraries, NumPy's and SciPy's; those of solvers may have one only."""
    libraries = [library for library in threadpool_info() if library["user_api"] == "blas"]
    return {
        each["num_threads"]
        for each in libraries
        if {"numpy.libs", "scipy.libs"} & set(Path(each["filepath"]).parts)
    }


@pytest.fixture
def two_threads(monkeypatch):
    """As on a machine of two cores, of which no environment variable tells otherwise."""
    for name in VARIABLES:
        monkeypatch.delenv(name, raising=False)
    # imports
    vc.solve(
        vc.Scene(bodies=vc.Bodies(G=1.0, nu=0.3), surface=vc.Ellipse(1.0, 1.0), normal_force=1.0)
    )
    with threadpool_limits(2, user_api="blas"):
        yield
        assert counts() == {2}


def test_one_thread_while_a_scene_is_solved(rolling, two_threads):
    seen = []
    vc.solve(rolling(), progress=lambda stage: seen.append(counts()))
    assert len(seen) > 2 and seen == [{1}] * len(seen)
    assert counts() == {2}


def test_threads_are_restored_after_an_error_and_between_the_scenes_of_a_scan(rolling, two_threads):
    with pytest.raises(vc.Saturated):
        vc.solve(rolling(motion=vc.Steady(Fx=1.0)))
    assert counts() == {2}
    seen = []
    vc.scan(
        rolling(),
        np.array([[0.01, 0.0, 0.0], [0.02, 0.0, 0.0]]),
        progress=lambda stage: seen.append(counts()),
    )
    assert {1} in seen and counts() == {2}


def test_two_solves_at_once(two_threads):
    """The first to come ends before the second: one thread until both have ended, then as many as
    before.
    """
    first, second = one_blas_thread(), one_blas_thread()
    first.__enter__()
    second.__enter__()
    first.__exit__(None, None, None)
    assert counts() == {1}
    second.__exit__(None, None, None)
    assert counts() == {2}


@pytest.mark.parametrize("name", VARIABLES)
def test_an_environment_variable_has_its_way(two_threads, monkeypatch, name):
    monkeypatch.setenv(name, "2")
    with one_blas_thread():
        assert counts() == {2}


@cache
def multiplies(code):
    """Whether a function of the package has a matrix product in it, or is one of NumPy's or SciPy's
    linear algebra.
    """
    if any(f"/{package}/linalg/" in code.co_filename for package in ("numpy", "scipy")):
        return True
    return "/varcontact/" in code.co_filename and any(
        step.argrepr == "@" for step in dis.get_instructions(code)
    )


@contextmanager
def threads_of_products():
    """A dictionary: threads that BLAS has in each function that multiplies or factors matrices
    within the block.
    """
    libraries = [
        each
        for each in ThreadpoolController().lib_controllers
        if Path(each.filepath).parent.stem in ("numpy", "scipy")
    ]
    seen = {}

    def look(frame, event, _):
        if event == "call" and multiplies(frame.f_code):
            seen.setdefault(frame.f_code.co_qualname, set()).update(
                each.num_threads for each in libraries
            )

    sys.setprofile(look)
    try:
        yield seen
    finally:
        sys.setprofile(None)


@pytest.fixture(scope="module")
def wheel():
    """A wheel on its rail, with the splines through its profiles and their locus."""
    case = conditions.wheel(3.0, dx=1.0, dy=1.0)
    assert case.touching > -1.0
    return case


def stored(sol, tmp_path):
    sol.save(tmp_path / "sol.nc")
    return tmp_path / "sol.nc"


def gap(posed):
    return energy.gap(posed.tangential, posed.traction, posed.rigid)


LATER = {
    "force_bound": lambda sol, *_: sol.certificate.force_bound,
    "sensitivity": lambda sol, *_: sol.sensitivity(),
    "stress": lambda sol, *_: stress(sol, [[0.0], [0.0], [0.1]]),
    "gap": lambda sol, *_: energy.gap(
        energy.posed(sol).tangential, energy.posed(sol).traction, energy.posed(sol).rigid
    ),
    "energy": lambda sol, *_: energy.potential_energy(
        energy.posed(sol).normal, energy.posed(sol).pressure
    ),
    "certify": lambda sol, *_: vc.certify(
        dataclasses.replace(sol.scene, grid=sol.grid), sol.traction
    ),
    "load": lambda sol, folder, _: vc.load(stored(sol, folder)),
    "scan": lambda sol, *_: [
        one.certificate.force_bound for one in vc.scan(sol.scene, [[0.02, 0.0, 0.0]])
    ],
    "sweep": lambda sol, *_: vc.sweep(sol.scene, {"friction": [0.2, 0.3]}, certify="full"),
    "product": lambda sol, *_: discretise(sol.scene, sol.grid).operators.normal.apply(
        sol.pressure[None]
    ),
    "wheel on rail": lambda *given: given[-1].solve(),
    "patches": lambda *given: given[-1].patches(0.05),
    "no slip": lambda *_: no_slip_ellipse(1.3, 0.28),
    "table book": lambda *_: make_table_book(
        0.3, least=0.9, greatest=1.1, ratios=2, steps=2, degree=3
    ),
    "smoothed": lambda *_: smoothed(np.ones(60), np.arange(60.0), 8.0),
}
"""What computes after a solve or without one, from a solution, an empty folder and a wheel on its
rail."""


@pytest.mark.parametrize("name", LATER)
def test_one_thread_in_all_that_computes_after_a_solve_or_without_one(
    rolling, wheel, two_threads, tmp_path, name
):
    """Newton's method leaves the bounds to when they are asked for, and a file's fields are
    measured again.
    """
    sol = vc.solve(rolling(), tangential="newton")
    with threads_of_products() as seen:
        LATER[name](sol, tmp_path, wheel)
    assert seen and set.union(*seen.values()) == {1}, seen
    assert counts() == {2}


# -------------------- A scene solved in other processes and threads


PROGRAM = """
import multiprocessing
import sys
from concurrent.futures import ThreadPoolExecutor

import varcontact as vc

def solved(method):
    scene = vc.Scene(
        bodies=vc.Bodies(G=1.0, nu=0.3), surface=vc.Ellipse(a=1.0, b=1.2), normal_force=1.0, friction=0.3,
        motion=vc.Steady(vx=0.1, spin=0.1), grid=vc.Grid(nx=14, ny=14))
    sol = vc.solve(scene, method=method)
    return sol.pressure.tobytes() + sol.traction.tobytes()

if __name__ == "__main__":
    methods = ["convex", "active-set"]
    here = [solved(method) for method in methods]
    for way in ("fork", "spawn", "forkserver"):
        with multiprocessing.get_context(way).Pool(2) as processes:
            there = processes.map_async(solved, methods * 2).get(timeout=120)
        print(way, "the same" if here * 2 == there else "other digits")
    with ThreadPoolExecutor(2) as threads:
        there = list(threads.map(solved, methods * 2))
    print("threads", "the same" if here * 2 == there else "other digits")
"""


@pytest.mark.long
def test_the_same_digits_wherever_a_scene_is_solved(tmp_path):
    """After solves in the parent, whose solvers may have left threads and locks that a fork does
    not take along.
    """
    program = tmp_path / "program.py"
    program.write_text(PROGRAM)
    done = subprocess.run([sys.executable, program], capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout.splitlines() == [
        f"{way} the same" for way in ("fork", "spawn", "forkserver", "threads")
    ]


@pytest.mark.long
def test_no_thread_is_left_behind(tmp_path):
    """A fork takes along the thread that calls it, and no other: Clarabel's would be missed."""
    code = (
        f"{PROGRAM.split('if __name__')[0]}\nimport psutil, time\nsolved('active-set')\n"
        "before, until = psutil.Process().num_threads(), time.monotonic() + 10\nsolved('convex')\n"
        "while psutil.Process().num_threads() > before and time.monotonic() < until:  # one that ends takes a moment\n"
        "    time.sleep(0.01)\n"
        "print(psutil.Process().num_threads() - before)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout == "0\n"


FORKS = """
import os
import signal
import threading
import time

import varcontact as vc

def solve(cells):
    scene = vc.Scene(
        bodies=vc.Bodies(G=1.0, nu=0.3), surface=vc.Ellipse(a=1.0, b=1.2), normal_force=1.0, friction=0.3,
        motion=vc.Steady(vx=0.1, spin=0.1), grid=vc.Grid(nx=cells, ny=cells))
    vc.solve(scene, method="active-set")

def solve_for_ever():
    while True:
        solve(40)

def solve_in_child():
    beside = threading.Thread(target=solve, args=(8,))
    beside.start()
    solve(8)
    beside.join()
    os._exit(0)

solve(8)
for _ in range(2):
    threading.Thread(target=solve_for_ever, daemon=True).start()
waiting = set()
for _ in range(10):
    time.sleep(0.05)
    waiting.add(os.fork() or solve_in_child())
until = time.monotonic() + 60
while waiting and time.monotonic() < until:
    waiting -= {child for child in waiting if os.waitpid(child, os.WNOHANG)[0]}
    time.sleep(0.02)
for child in waiting:
    os.kill(child, signal.SIGKILL)
print(len(waiting), "children hang", flush=True)
os._exit(0)
"""


@pytest.mark.long
@pytest.mark.skipif(not hasattr(os, "fork"), reason="no fork on this system")
def test_processes_forked_while_threads_solve_end():
    """Threads solve, processes are forked from between, and solve in threads of their own."""
    done = subprocess.run(
        [sys.executable, "-c", FORKS], capture_output=True, text=True, check=False
    )
    assert (done.stdout, done.stderr) == ("0 children hang\n", "")


def test_no_attribute_has_a_lock():
    """`lazy_property` is for what the package computes once."""
    with_lock = [
        path
        for path in Path(vc.__file__).parent.rglob("*.py")
        if "@cached_property" in path.read_text()
    ]
    assert with_lock == []


def test_lazy_properties_are_computed_once_also_where_classes_are_frozen():
    computed = []

    @dataclasses.dataclass(frozen=True)
    class Square:
        side: float

        @lazy_property
        def area(self):
            """Of the square."""
            computed.append(self.side)
            return self.side**2

    square = Square(3.0)
    assert (square.area, square.area, computed) == (9.0, 9.0, [3.0])
    assert dataclasses.replace(square, side=2.0).area == 4.0
    assert (Square.area.__doc__, square) == ("Of the square.", Square(3.0))
