"""Ctrl-C while solvers in other languages compute: it is neither swallowed nor kept waiting."""

import subprocess
import sys
import threading

import numpy as np
import pytest

from varcontact.system.process import MANY, interruptible

START = """
import os, signal, sys, threading, time
signal.signal(signal.SIGINT, signal.default_int_handler)  # a shell's background jobs begin deaf to it

def ctrl_c():
    os.kill(os.getpid(), signal.SIGINT)
"""
SCENE = """
import varcontact as vc
scene = vc.Scene(bodies=vc.Bodies(G=1.0, nu=0.28), surface=vc.Ellipse(a=1.2, b=0.9), normal_force=1.0, friction=0.3,
                 motion=vc.Steady(vx=0.04, vy=-0.02, spin=0.05), grid=vc.Grid(nx={cells}, ny={cells}))
"""


def run(code):
    """What a program prints that ends well."""
    done = subprocess.run(
        [sys.executable, "-c", START + code],
        capture_output=True,
        text=True,
        timeout=300,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_results_and_errors_are_those_of_the_call():
    assert interruptible(lambda: 42) == 42
    with pytest.raises(ZeroDivisionError):
        interruptible(lambda: 1 / 0)
    with np.errstate(divide="raise"), pytest.raises(FloatingPointError):
        interruptible(lambda: np.ones(1) / 0)


def test_where_no_thread_is_made():
    """For small matrices, and beside the main thread, where signals never come."""
    here = threading.current_thread()
    assert interruptible(threading.current_thread, MANY - 1) is here
    assert interruptible(threading.current_thread, MANY) is not here
    inside = []
    other = threading.Thread(target=lambda: inside.append(interruptible(threading.current_thread)))
    other.start()
    other.join()
    assert inside == [other]


def test_work_that_never_ends_is_abandoned():
    """The program goes on, and ends, in spite of it."""
    code = """
from varcontact.system.process import interruptible
try:
    interruptible(lambda: (ctrl_c(), threading.Event().wait()))
except KeyboardInterrupt:
    print("interrupted", interruptible(lambda: 42))
"""
    assert run(code) == "interrupted 42\n"


def test_sigint_is_taken_back_from_who_took_it():
    """As SCS takes it behind the back of Python, also behind CVXPY, where nobody tells of it."""
    code = """
import ctypes
from varcontact.system.process import interruptible

def taking():
    handler, ignored = ctypes.CDLL(None).signal, ctypes.c_void_p(1).value
    handler.argtypes, handler.restype = [ctypes.c_int, ctypes.c_void_p], ctypes.c_void_p
    handler(signal.SIGINT, ignored)
    while (back := handler(signal.SIGINT, ignored)) == ignored:
        time.sleep(1e-3)
    handler(signal.SIGINT, back)
    ctrl_c()
    threading.Event().wait()

try:
    interruptible(taking)
except KeyboardInterrupt:
    print("interrupted")
"""
    assert run(code) == "interrupted\n"


def test_a_package_is_not_left_half_imported(tmp_path):
    (tmp_path / "slow_package.py").write_text(
        "started = True\nimport __main__\n__main__.ctrl_c()\n__main__.go.wait()\n"
    )
    code = f"""
sys.path.insert(0, {str(tmp_path)!r})
from varcontact.system.process import imported
go = threading.Event()
try:
    imported("slow_package")
except KeyboardInterrupt:
    go.set()
    print("interrupted", imported("slow_package").started)
"""
    assert run(code) == "interrupted True\n"


@pytest.mark.long
@pytest.mark.parametrize("back", [True, False])
@pytest.mark.parametrize("method", ["scs", "osqp|clarabel"])
def test_solvers_that_take_ctrl_c_for_themselves(method, back):
    """Taken back from them, or as their status tells: SCS and OSQP return as if they had failed."""
    code = """
import {package}
from types import SimpleNamespace
from unittest import mock
from varcontact.system import process

if not {back}:
    process.signal = SimpleNamespace(SIGINT=signal.SIGINT, getsignal=lambda _: None)

solve, calls, begun = {package}.{solver}.solve, [], threading.Event()

def press():
    begun.set()
    ctrl_c()

def pressed(self, *arguments, **options):
    calls.append(1)
    if len(calls) != {at}:
        return solve(self, *arguments, **options)
    pressing = threading.Timer(0.02, press)
    pressing.start()
    while True:  # until it has come while the solver computes
        result = solve(self, *arguments, **options)
        if begun.is_set():
            pressing.join()
            return result

with mock.patch.object({package}.{solver}, "solve", pressed):
    try:
        vc.compare(scene, ["linear", {method!r}], tol={tol})
    except vc.Interrupted as stopped:
        print(stopped, stopped.partial["method"].tolist(), flush=True)
        os._exit(0)  # whatever the solver is at
"""
    package, solver, at, tol = ("scs", "SCS", 2, 1e-3)
    if method.startswith("osqp"):
        package, solver, at, tol = ("osqp", "OSQP", 1, 1e-12)
    names = {
        "package": package,
        "solver": solver,
        "method": method,
        "at": at,
        "tol": tol,
        "back": back,
    }
    told = run(SCENE.format(cells=20) + code.format(**names))
    last = told.splitlines()[-1]  # the solvers themselves say a word before
    assert last == "interrupted after 0 of 1 scenes []"


@pytest.mark.long
def test_clarabel_is_not_waited_for():
    """When Ctrl-C has come through, it still computes, or whatever is called in its place."""
    code = """
from varcontact.solvers.conic import backends as module

waiting = module.interruptible
module.interruptible = lambda work: waiting(lambda: (ctrl_c(), work(), threading.Event().wait()))
try:
    vc.solve(scene, tangential="clarabel")
except KeyboardInterrupt:
    print(threading.active_count())
    sys.stdout.flush()
    os._exit(0)
"""
    assert run(SCENE.format(cells=6) + code) == "2\n"


def test_while_the_command_is_imported():
    """One line of nothing, and the status of an interrupted program."""
    code = """
import varcontact
from varcontact.__main__ import main

class Pressing:
    def find_spec(self, name, *rest):
        if name == "typer":
            ctrl_c()

sys.meta_path.insert(0, Pressing())
main()
"""
    done = subprocess.run(
        [sys.executable, "-c", START + code],
        capture_output=True,
        text=True,
        timeout=300,
        check=False,
    )
    assert (done.returncode, done.stdout, done.stderr) == (130, "", "")
