"""Stores under two writers, and killed at random moments: what was in a store stays, and the whole
is as if alone.
"""

import os
import random
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

import varcontact as vc
from tests.scenes import make_scene, refused
from varcontact.study.csv_table import Table

ROOT = Path(__file__).parents[2]
KILLS = 3
KILLED = "import sys; from tests.study.test_stores import killed; killed(*sys.argv[1:])"
HELD_UP = """
import sys
from tests.study.test_stores import STUDIES

def held_up(word):
    print(word, flush=True)
    sys.stdin.readline()

STUDIES[sys.argv[1]](sys.argv[2], held_up)
"""


def scene(motion):
    return make_scene(vc.Paraboloids(Rx=100.0, Ry=100.0), 1.0, motion, vc.Grid(nx=6, ny=6))


def history(store, progress):
    return vc.solve(scene(vc.Transient(steps=6, dq=0.5, Fx=-0.2)), store=store, progress=progress)


def compare(store, progress):
    scenes = [scene(vc.Steady(vx=0.01 * k)) for k in range(6)]
    return vc.compare(scenes, ["tang"], store=store, progress=progress)


def converge(store, progress):
    return vc.converge(
        scene(vc.Steady(vx=0.02)), [4, 5, 6], offsets=2, store=store, progress=progress
    )


STUDIES = {"history": history, "compare": compare, "converge": converge}
TABLE_AND_HISTORY = pytest.mark.parametrize("study", ["history", "compare"], indirect=True)
"""A study of convergence writes the same table as a comparison."""
PIECES = 6
"""Of work in each study, of which it tells when it begins one."""


def name_of(study):
    return "store.nc" if study == "history" else "store.csv"


def contents(store):
    """The finished pieces, but for what takes another time or memory each time."""
    if store.suffix == ".nc":
        return [
            np.stack([sol.pressure, *sol.traction, *sol.slip]).tobytes() for sol in vc.load(store)
        ]
    table = pd.read_csv(store)
    return list(
        table[[name for name in table if "seconds" not in name and name != "memory"]]
        .astype(str)
        .agg(tuple, 1)
    )


@pytest.fixture(scope="module", params=STUDIES)
def study(request):
    return request.param


@pytest.fixture(scope="module")
def alone(study, tmp_path_factory):
    store = tmp_path_factory.mktemp("alone") / name_of(study)
    STUDIES[study](store, None)
    return contents(store)


@pytest.fixture
def first(study, tmp_path):
    """A process in the middle of a study: it has told of the fourth piece of work, and waits."""
    pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "text": True}
    command = [sys.executable, "-c", HELD_UP, study, str(tmp_path / name_of(study))]
    process = subprocess.Popen(command, cwd=ROOT, **pipes)
    for _ in range(3):
        process.stdout.readline()
        process.stdin.write("\n")
        process.stdin.flush()
    process.stdout.readline()
    yield process
    process.kill()
    process.communicate()


@pytest.mark.long
@TABLE_AND_HISTORY
def test_the_second_is_refused_and_the_first_goes_on(study, first, alone, tmp_path):
    store, before = tmp_path / name_of(study), (tmp_path / name_of(study)).read_bytes()
    words = rf"is being written by process {first.pid} on .*; wait until that is done"
    link = tmp_path / f"link{store.suffix}"
    link.symlink_to(store)
    for path in (store, link):
        with pytest.raises(vc.OutputError, match=words):
            STUDIES[study](path, pytest.fail)
    assert store.read_bytes() == before
    assert len(contents(store)) == 3, "a reader sees what is finished"
    first.communicate("\n" * 10)
    assert first.returncode == 0
    assert contents(store) == alone


@pytest.mark.long
@TABLE_AND_HISTORY
def test_when_the_first_is_killed_the_second_goes_on(study, first, alone, tmp_path):
    store, told = tmp_path / name_of(study), []
    first.kill()
    first.wait()
    assert len(os.listdir(tmp_path)) > 1
    STUDIES[study](store, told.append)
    assert len(told) == PIECES - 3
    assert os.listdir(tmp_path) == [store.name]
    assert contents(store) == alone


def test_what_others_did_to_the_store_is_not_written_over(study, tmp_path):
    """Where the file system has no locks, or somebody puts an older copy there."""
    store, told = tmp_path / name_of(study), []

    def meddle(word):
        told.append(word)
        if len(told) == 3:
            shutil.copy(store, tmp_path / "older")
        if len(told) == 5:
            shutil.copy(tmp_path / "older", store)

    words = (
        "has 2 steps where this run has written 4"
        if study == "history"
        else "has been changed by something else"
    )
    refused(lambda: STUDIES[study](store, meddle), match=words, error=vc.OutputError)
    assert store.read_bytes() == (tmp_path / "older").read_bytes()
    assert len(contents(store)) == 2


def test_the_process_itself_is_refused_as_well(tmp_path):
    store, found = tmp_path / "store.nc", []

    def again(word):
        if word.startswith("3 of"):
            with pytest.raises(vc.OutputError, match="is being written by this process"):
                history(store, None)
            found.append(word)

    assert len(history(store, again)) == 6
    assert len(found) == 1


def killed(study, folder):
    """Kill a study at random moments, in a process that is forked from this one, then let it
    end.
    """
    store, log, draw, before = (
        Path(folder) / name_of(study),
        Path(folder) / "log",
        random.Random(1),
        [],
    )
    begun = time.time()
    STUDIES[study](store.with_stem("alone"), None)
    seconds = time.time() - begun
    for number in range(KILLS + 1):
        child = os.fork()
        if not child:
            with log.open("a") as lines:
                STUDIES[study](store, lambda word: lines.write(f"{word}\n") and lines.flush())
            os._exit(0)
        if number < KILLS:
            time.sleep(draw.uniform(0, 2 * seconds / KILLS))
            os.kill(child, signal.SIGKILL)
        os.waitpid(child, 0)
        after = contents(store) if store.exists() else []
        assert all(piece in after for piece in before), "lost"
        before = after
    assert contents(store) == contents(store.with_stem("alone"))
    assert len(log.read_text().splitlines()) <= PIECES + KILLS, (
        "nothing is done twice but what a kill cut short"
    )
    assert set(os.listdir(folder)) == {store.name, log.name, store.with_stem("alone").name}


@pytest.mark.long
def test_killed_at_random_nothing_finished_is_lost(study, tmp_path):
    command = [sys.executable, "-c", KILLED, study, str(tmp_path)]
    done = subprocess.run(
        command, cwd=ROOT, capture_output=True, text=True, timeout=300, check=False
    )
    assert done.returncode == 0, done.stderr


TEXTS = ["=1+1", "+1", "-1", "@sum", "'=quoted", "'", "plain", "a=1", ""]


def test_no_text_of_a_table_is_a_formula(tmp_path):
    """A quote keeps spreadsheets from running it, and the table has the texts as they were."""
    store, columns, rows = (
        tmp_path / "store.csv",
        ["name", "Fx"],
        [{"name": text, "Fx": -1.5} for text in TEXTS],
    )
    with Table.opened(store, columns, ["name"], "a table") as table:
        table.write(rows)
    names = pd.read_csv(store, keep_default_na=False)["name"].tolist()
    assert [name for name in names if name[:1] in tuple("=+-@")] == []
    assert names[6:] == TEXTS[6:]
    assert "-1.5" in store.read_text() and "'-1.5" not in store.read_text()
    with Table.opened(store, columns, ["name"], "a table") as table:
        assert table.rows == rows
        before = store.read_bytes()
        table.write(table.rows)
    assert store.read_bytes() == before


def test_scenes_with_the_names_of_formulas_go_on(tmp_path):
    store, told = tmp_path / "store.csv", []
    scenes = {text: scene(vc.Steady(vx=0.01 * k)) for k, text in enumerate(TEXTS[:4], 1)}
    vc.compare(dict(list(scenes.items())[:2]), ["tang"], store=store)
    table = vc.compare(scenes, ["tang"], store=store, progress=told.append)
    assert len(told) == 2
    assert set(table["scene"]) == set(scenes)
