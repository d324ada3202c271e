"""Histories whose program is killed, or whose disk is full, while they are written."""

import subprocess
import sys

import numpy as np
import pytest

import varcontact as vc

STEPS = 12
SCENE = f"""
import varcontact as vc
scene = vc.Scene(
    bodies=vc.Bodies(G=1.0, nu=0.28), surface=vc.Cylinders(R=100.0), normal_force=1.0, friction=0.3,
    motion=vc.Transient(steps={STEPS}, dq=0.5, Fx=-0.2), grid=vc.Grid(nx=12))
"""
ENDED = """
import os, resource, signal, sys
sys.dont_write_bytecode = True  # what the limit of size cuts off would stay
resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
for limit in {limits}:
    child = os.fork()
    if child == 0:
        signal.signal(signal.SIGXFSZ, signal.SIG_DFL)  # Python ignores it
        resource.setrlimit(resource.RLIMIT_FSIZE, (limit, limit))
        vc.solve(scene, store="run.nc")
        os._exit(0)
    assert os.WTERMSIG(os.waitpid(child, 0)[1]) == signal.SIGXFSZ
    print(os.path.getsize("run.nc"), len(vc.load("run.nc")))
"""
FULL = """
import resource, sys
sys.dont_write_bytecode = True
resource.setrlimit(resource.RLIMIT_FSIZE, ({limit}, {limit}))
try:
    vc.solve(scene, store="run.nc")
except vc.OutputError as error:
    assert str(error) == "step {step} of the history: store = 'run.nc': cannot be written (File too large)", error
    print(len(error.history))
"""


@pytest.fixture(scope="module")
def history():
    names = {}
    exec(SCENE, names)
    return vc.solve(names["scene"])


def run(folder, code):
    """Lines of numbers that a program prints."""
    done = subprocess.run(
        [sys.executable, "-c", SCENE + code],
        cwd=folder,
        capture_output=True,
        text=True,
        timeout=300,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    return [[int(word) for word in line.split()] for line in done.stdout.splitlines()]


def stored_size(history, folder):
    """Bytes of the whole history's file."""
    history.save(folder / "whole.nc")
    return (folder / "whole.nc").stat().st_size


def check_goes_on(history, path):
    """The rest is solved, and the whole is that of an uninterrupted run, bit for bit."""
    whole = vc.solve(history.scene, store=path)
    assert len(whole) == len(vc.load(path)) == STEPS
    for name in ("pressure", "traction", "slip", "distance", "state", "force"):
        stored, solved = ([getattr(step, name) for step in steps] for steps in (whole, history))
        np.testing.assert_array_equal(stored, solved, err_msg=name)


@pytest.mark.long
def test_ended_within_a_step(history, tmp_path):
    """The system ends the program in the middle of a write: behind the steps counted lies a part of
    the next.
    """
    size = stored_size(history, tmp_path)
    limits = [size // 3, size // 2, size // 2 + 1, size - 1]
    found = run(tmp_path, ENDED.format(limits=limits))
    assert [at for at, _ in found] == limits
    counts = [count for _, count in found]
    assert 0 < counts[0] < counts[1] <= counts[2] < counts[3] == STEPS - 1
    check_goes_on(history, tmp_path / "run.nc")


@pytest.mark.long
def test_a_full_disk(history, tmp_path):
    """An error says which step had no room; those before it are kept."""
    size = stored_size(history, tmp_path)
    assert run(tmp_path, FULL.format(limit=size - 1, step=STEPS - 1)) == [[STEPS - 1]]
    assert len(vc.load(tmp_path / "run.nc")) == STEPS - 1
    check_goes_on(history, tmp_path / "run.nc")
