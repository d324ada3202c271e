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

def solvers():
    # Not the timer, which may still be on its way out.
    return [t for t in threading.enumerate() if t is not threading.main_thread() and not isinstance(t, threading.Timer)]
"""
SCENE = """
import varcontact as vc
scene = vc.Scene(bodies=vc.Bodies(G=1.0, nu=0.28), surface=vc.Ellipse(a=1.2, b=0.9), normal_force=1.0, friction=0.3,
                 motion=vc.Steady(vx=0.04, vy=-0.02, spin=0.05), grid=vc.Grid(nx={cells}, ny={cells}))
"""


def run(code):
    """What a program prints that ends well."""
    done = subprocess.run([sys.executable, "-c", START + code], capture_output=True, text=True, timeout=60, check=False)
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
out = threading.Event()

def taking():
    ctypes.CDLL(None).signal(signal.SIGINT, ctypes.c_void_p(1))  # 1: ignored
    while not out.wait(0.2):
        ctrl_c()

try:
    interruptible(taking)
except KeyboardInterrupt:
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    out.set()
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


@pytest.mark.parametrize("method", ["scs", "osqp|clarabel"])
def test_solvers_that_take_ctrl_c_for_themselves(method):
    """SCS and OSQP return as if they had failed: the second solve of `compare` was lost, and nobody knew."""
    code = """
import {package}
from unittest import mock

solve, calls = {package}.{solver}.solve, []

def pressed(self, *arguments, **options):
    calls.append(1)
    if len(calls) == {at}:
        threading.Timer(0.005, ctrl_c).start()
    return solve(self, *arguments, **options)

with mock.patch.object({package}.{solver}, "solve", pressed):
    try:
        vc.compare(scene, ["linear", {method!r}], tol={tol})
        time.sleep(60)
    except vc.Interrupted as stopped:
        print(stopped, stopped.partial["method"].tolist(), flush=True)
        os._exit(0)  # whatever the solver is at
"""
    package, solver, at, tol = ("scs", "SCS", 2, 1e-3)
    if method.startswith("osqp"):
        package, solver, at, tol = ("osqp", "OSQP", 1, 1e-12)
    names = {"package": package, "solver": solver, "method": method, "at": at, "tol": tol}
    told = run(SCENE.format(cells=20) + code.format(**names))
    last = told.splitlines()[-1]  # the solvers themselves say a word before
    assert last == "interrupted after 0 of 1 scenes []"


def test_clarabel_is_not_waited_for():
    """When Ctrl-C has come through, it still computes."""
    code = """
from varcontact.solvers.conic import backends as module

waiting = module.interruptible

def pressed(work):
    threading.Timer(0.05, ctrl_c).start()
    return waiting(work)

module.interruptible = pressed
try:
    vc.solve(scene, tangential="clarabel")
except KeyboardInterrupt:
    print(len(solvers()))
    sys.stdout.flush()
    os._exit(0)
"""
    assert run(SCENE.format(cells=22) + code) == "1\n"


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
    done = subprocess.run([sys.executable, "-c", START + code], capture_output=True, text=True, timeout=60, check=False)
    assert (done.returncode, done.stdout, done.stderr) == (130, "", "")
