"""Ctrl-C at a terminal, in the middle of the work: what standard error says is kept, and that it
is.
"""

import os
import re
import subprocess
import sys

import pandas as pd
import pytest

import varcontact as vc
from varcontact.cli.terminal import stop

STEADY = """
normal_force = 1e-2
friction = 0.3
bodies = { G = [1.0, inf], nu = 0.3 }
surface = { kind = "paraboloids", Rx = 1.0, Ry = 1.0 }
motion = { kind = "steady", vx = 0.02, spin = 0.05 }
grid = { nx = 40, ny = 40 }
"""
HISTORY = """
normal_force = 1e-3
friction = 0.3
bodies = { G = 1.0, nu = 0.28 }
surface = { kind = "cylinders", R = 1.0 }
motion = { kind = "transient", steps = 4000, dq = 0.001, Fx = -1e-4 }
grid = { nx = 30 }
"""
METHOD = "tang/marching"

SOLVING = "varcontact/solvers/"
PRESSED = """
import os, re, signal, sys
from rich.status import Status
from varcontact.__main__ import main
from varcontact.study import parallel

at, within = sys.argv[1:3]
del sys.argv[1:3]

def telling(update):
    def told(display, *words, **more):
        update(display, *words, **more)
        if re.search(at, f"{words} {more}"):
            sys.setprofile(called)
    return told

def called(frame, event, _):
    if event == "call" and re.search(within, f"{frame.f_code.co_filename}:{frame.f_code.co_name}"):
        sys.setprofile(None)
        os.killpg(0, signal.SIGINT)  # as a terminal does: to every process that the command has begun

signal.signal(signal.SIGINT, signal.default_int_handler)  # a shell's background jobs begin deaf to it
parallel.PRELOAD.insert(0, "pressing")
Status.update = telling(Status.update)
main()
"""
"""The command, to which Ctrl-C comes in a function `within` a file, once the terminal has been told
`at`.

Or while the server of a pool imports a module of that name, where there is one.
"""


@pytest.fixture
def folder(tmp_path):
    for name, scene in {
        "one": STEADY.replace("40", "6"),
        "two": STEADY,
        "history": HISTORY,
    }.items():
        (tmp_path / f"{name}.toml").write_text(scene)
    return tmp_path


def interrupted(folder, *arguments, at, within=SOLVING):
    """What a command prints, and says, when Ctrl-C comes at a place of its work."""
    done = subprocess.run(
        [sys.executable, "-c", PRESSED, at, within, *arguments],
        cwd=folder,
        capture_output=True,
        text=True,
        env={**os.environ, "FORCE_COLOR": "1", "COLUMNS": "400"},  # as at a terminal
        start_new_session=True,
        check=False,
    )
    assert done.returncode == 130, done.stderr
    assert "Traceback" not in done.stderr
    return done.stdout, done.stderr.rsplit("varcontact: ", 1)[-1].strip()


@pytest.mark.long
def test_one_problem(folder):
    output, said = interrupted(
        folder, "solve", "two.toml", "--formulation", "marching", "--out", "a.nc", at="tangential"
    )
    assert (output, said) == (
        "",
        "interrupted; nothing is kept, and the same command starts again from the beginning",
    )
    assert not (folder / "a.nc").exists()


@pytest.mark.long
def test_history_with_a_file(folder):
    """The steps are printed, and stand in the file."""
    output, said = interrupted(
        folder, "solve", "history.toml", "--out", "a.nc", at="3 of 4000 steps"
    )
    kept = len(vc.load(folder / "a.nc"))
    assert kept >= 3
    assert f"4000 steps: {kept} FINISHED" in output
    how = "finished steps are kept in a.nc, and the same command resumes from there"
    assert said == f"interrupted after {kept} of 4000 steps; {how}"


@pytest.mark.long
def test_comparison_with_a_table(folder):
    call = ("compare", "one.toml", "two.toml", "--methods", METHOD, "--out", "t.csv")
    output, said = interrupted(folder, *call, at="two")
    how = "finished scenes are kept in t.csv, and the same command resumes from there"
    assert said == f"interrupted after 1 of 2 scenes; {how}"
    assert output.splitlines()[0] == "one" and "two" not in output
    assert pd.read_csv(folder / "t.csv")["scene"].tolist() == ["one"]


@pytest.mark.long
@pytest.mark.parametrize("at", ["nothing", r"[1-9]\d\d of 4000"])
def test_a_sweep_in_processes(folder, at):
    """While they begin and while they work: neither their tracebacks nor semaphores that nobody
    took away.
    """
    if at == "nothing":
        (folder / "pressing.py").write_text("import os, signal\nos.killpg(0, signal.SIGINT)\n")
    over = '[over]\n"motion.vx" = { from = 1e-4, to = 1e-2, count = 2000 }\nfriction = [0.2, 0.3]\n'
    like = STEADY.replace("inf", "1.0").replace("40", "20")
    (folder / "sweep.toml").write_text(like + over)
    _, said = interrupted(
        folder,
        "sweep",
        "sweep.toml",
        "--workers",
        "2",
        "--out",
        "a.nc",
        at=at,
        within="parallel.py:results",
    )
    how = "finished scenes are kept in a.nc, and the same command resumes from there"
    assert re.fullmatch(rf"interrupted after \d+ of 4000 scenes; {how}", said)


def test_before_anything_is_finished(tmp_path, capsys):
    """A file that was asked for, and is not there yet."""
    with pytest.raises(SystemExit) as status:
        stop(
            vc.Interrupted(None, " after 0 of 2 scenes"),
            tmp_path / "t.csv",
            "--out FILE.csv",
            "scenes",
        )
    assert status.value.code == 130
    said = capsys.readouterr().err
    assert said.startswith("varcontact: interrupted after 0 of 2 scenes; nothing is kept in ")
    assert said.endswith("t.csv yet, and the same command starts again from the beginning\n")
