"""Two runs on one store: the second is refused at once, and what the first writes is what it would have written alone.

The first is a process of its own, held up at a step of its work by the pipe through which it tells of it.
"""

import os
import shutil
import subprocess
import sys

import numpy as np
import pandas as pd
import pytest

import varcontact as vc

SETUP = """
import sys
import varcontact as vc

def scene(motion):
    bodies, surface = vc.Bodies(G=1.0, nu=0.28), vc.Paraboloids(Rx=100.0, Ry=100.0)
    return vc.Scene(bodies=bodies, surface=surface, normal_force=1.0, friction=0.3, motion=motion,
                    grid=vc.Grid(nx=6, ny=6))

def history(store, progress):
    motion = vc.Transient(steps=6, dq=0.5, Fx=-0.2)
    return vc.solve(scene(motion), store=store, progress=progress)

def compare(store, progress):
    scenes = [scene(vc.Steady(vx=0.01 * k)) for k in range(6)]
    return vc.compare(scenes, ["tang"], store=store, progress=progress)

def converge(store, progress):
    return vc.converge(scene(vc.Steady(vx=0.02)), [4, 5, 6], offsets=2, store=store, progress=progress)
"""
FIRST = """
def held_up(word):
    print(word, flush=True)
    sys.stdin.readline()

{study}({store!r}, held_up)
"""
STUDIES = {}
exec(SETUP, STUDIES)
TOLD = {"history": 6, "compare": 6, "converge": 6}
"""How often each study tells of its progress."""


@pytest.fixture(params=["history", "compare", "converge"])
def study(request):
    return request.param


def name_of(study):
    return "store.nc" if study == "history" else "store.csv"


@pytest.fixture
def first(study, tmp_path):
    """A process in the middle of a study: it has told of the fourth piece of work, and waits."""
    code = SETUP + FIRST.format(study=study, store=name_of(study))
    pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "text": True}
    process = subprocess.Popen([sys.executable, "-c", code], cwd=tmp_path, **pipes)
    for _ in range(3):
        process.stdout.readline()
        process.stdin.write("\n")
        process.stdin.flush()
    process.stdout.readline()
    yield process
    process.kill()
    process.communicate()


def contents(study, store):
    """What a store holds, but for times."""
    if study == "history":
        loaded = vc.load(store)
        return [np.stack([step.pressure, *step.traction, *step.slip]) for step in loaded]
    table = pd.read_csv(store)
    return table[[name for name in table if "seconds" not in name and name != "memory"]]


def check_same(study, store, other):
    one, two = contents(study, store), contents(study, other)
    if study == "history":
        np.testing.assert_array_equal(one, two)
    else:
        pd.testing.assert_frame_equal(one, two)


def test_the_second_is_refused_and_the_first_goes_on(study, first, tmp_path):
    store, before = tmp_path / name_of(study), (tmp_path / name_of(study)).read_bytes()
    with pytest.raises(
        vc.OutputError, match=rf"is being written by process {first.pid} on .*; wait until that is done"
    ):
        STUDIES[study](store, pytest.fail)
    link = tmp_path / f"link{store.suffix}"
    link.symlink_to(store)
    with pytest.raises(vc.OutputError, match="is being written by process"):
        STUDIES[study](link, pytest.fail)
    assert store.read_bytes() == before
    assert len(contents(study, store)) == 3, "a reader sees what is finished"
    first.communicate("\n" * 10)
    assert first.returncode == 0
    STUDIES[study](tmp_path / f"alone{store.suffix}", None)
    check_same(study, store, tmp_path / f"alone{store.suffix}")


def test_when_the_first_is_killed_the_second_goes_on(study, first, tmp_path):
    """Nothing finished is solved again, and nothing but the store is left."""
    store, told = tmp_path / name_of(study), []
    first.kill()
    first.wait()
    assert len(os.listdir(tmp_path)) > 1
    STUDIES[study](store, told.append)
    assert len(told) == TOLD[study] - 3
    assert os.listdir(tmp_path) == [store.name]
    STUDIES[study](tmp_path / f"alone{store.suffix}", None)
    check_same(study, store, tmp_path / f"alone{store.suffix}")


def test_what_others_did_to_the_store_is_not_written_over(study, tmp_path):
    """Where the file system has no locks, or somebody puts an older copy there."""
    store, told = tmp_path / name_of(study), []

    def meddle(word):
        told.append(word)
        if len(told) == 3:
            shutil.copy(store, tmp_path / "older")
        if len(told) == 5:
            shutil.copy(tmp_path / "older", store)

    words = "has 2 steps where this run has written 4" if study == "history" else "has been changed by something else"
    with pytest.raises(vc.OutputError, match=words):
        STUDIES[study](store, meddle)
    assert store.read_bytes() == (tmp_path / "older").read_bytes()
    assert len(contents(study, store)) == 2


def test_the_process_itself_is_refused_as_well(tmp_path):
    store, found = tmp_path / "store.nc", []

    def again(word):
        if word.startswith("3 of"):
            with pytest.raises(vc.OutputError, match="is being written by this process"):
                STUDIES["history"](store, None)
            found.append(word)

    assert len(STUDIES["history"](store, again)) == 6
    assert len(found) == 1
