"""The command ``varcontact sweep``."""

import json
from pathlib import Path

import numpy as np
import pytest

import varcontact as vc
from tests.command import run, scene_file

SCENE = scene_file("spin = 0.05", axes=(1.2, 0.9), cells=6)
OVER = """
[over]
"motion.vx" = {from = 0.01, to = 0.16, count = 3, spacing = "log"}
motion.vy = [0.0, 0.02]
friction = {from = 0.1, to = 0.3, count = 2}
"""


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "sweep.toml").write_text(SCENE + OVER)
    return tmp_path


@pytest.mark.long
def test_all_combinations_into_a_store_and_on_from_there(folder):
    first = run("sweep", "sweep.toml", "--out", "sweep.nc", folder=folder)
    assert (first.returncode, first.stderr) == (0, "")
    lines = first.stdout.splitlines()
    assert lines[0] == "12 scenes: 12 solved"
    assert lines[1].split() == [
        "motion.vx",
        "motion.vy",
        "friction",
        "outcome",
        "Fx",
        "Fy",
        "Mz",
        "residual",
    ]
    assert len(lines) == 14
    swept = vc.read_sweep(folder / "sweep.nc")
    np.testing.assert_allclose(swept["motion.vx"], [0.01, 0.04, 0.16])
    np.testing.assert_allclose(swept["friction"], [0.1, 0.3])
    assert np.isnan(swept["Fx_bound"]).all()
    other = run("sweep", "sweep.toml", "--certify", "full", "--out", "sweep.nc", folder=folder)
    assert other.returncode != 0
    assert "holds another sweep (certify = 'gap', not 'full'); name a new file" in " ".join(
        other.stderr.split()
    )
    content = (folder / "sweep.nc").read_bytes()
    again = run("sweep", "sweep.toml", "--out", "sweep.nc", "--json", folder=folder)
    rows = json.loads(again.stdout)
    assert len(rows) == 12
    assert rows[0].keys() >= {
        "motion.vx",
        "motion.vy",
        "friction",
        "Fx",
        "outcome",
        "reason",
        "residual",
    }
    assert [row["Fx"] for row in rows] == swept["Fx"].values.ravel().tolist()
    assert (folder / "sweep.nc").read_bytes() == content


@pytest.mark.long
def test_failures_are_counted_with_their_reasons(folder):
    (folder / "sweep.toml").write_text(
        SCENE + "[over]\nmotion.Fx = [-0.1, -0.5]\n[solve]\ntol = 1e-7\n"
    )
    done = run("sweep", "sweep.toml", folder=folder)
    assert done.returncode == 0
    assert done.stdout.splitlines()[0] == "2 scenes: 1 solved, 1 refused"
    assert "1 because: motion: a tangential force of 0.5 cannot be carried" in done.stdout


@pytest.mark.parametrize(
    ("over", "options", "words"),
    [
        ("", [], "over is missing: add a table [over] of the entries that vary"),
        ("[over]\nmotion.vx = {from = 0.0, to = 1.0}", [], "over.motion.vx.count is missing"),
        (
            "[over]\nmotion.vx = {from = 0.0, to = 1.0, number = 3}",
            [],
            "over.motion.vx.number: there is no such key",
        ),
        (
            "[over]\nmotion.vx = {from = 0.0, to = 1.0, count = 1}",
            [],
            "over.motion.vx.count = 1 is not allowed",
        ),
        (
            '[over]\nmotion.vx = {from = 0.0, to = 1.0, count = 3, spacing = "log"}',
            [],
            'over.motion.vx.from = 0.0 is not allowed: must be of the same sign as "to", and neither zero',
        ),
        ("[over]\nmotion.vxx = [1.0]", [], 'over: the scene has no "motion.vxx"'),
        (
            '[over]\nfriction = [0.1]\n[solve]\nstart = "slip"',
            [],
            "solve.start = 'slip' must be left out",
        ),
        (
            "[over]\nfriction = [0.1]\n[solve]\naccuracy = 0.01",
            [],
            "left out: it is chosen for the accuracy",
        ),
        (OVER, ["--dask", "tcp://127.0.0.1:1", "--workers", "2"], "--workers = 2 must be left out"),
        (
            OVER,
            ["--dask", "nowhere"],
            "--dask = 'nowhere' is not allowed: must be the address of a running scheduler",
        ),
        (OVER, ["--workers", "0"], "workers = 0 is not allowed: must be a whole number, 1 or more"),
        (OVER, ["--out", "sweep.csv"], "the name must end in .nc"),
        (OVER, ["--out", "sweep.toml"], "the name must end in .nc"),
    ],
)
def test_bad_input(folder, over, options, words):
    (folder / "sweep.toml").write_text(SCENE + over)
    done = run("sweep", "sweep.toml", *options, folder=folder)
    assert (done.returncode, done.stdout) == (2, "")
    assert words in done.stderr
    assert [file.name for file in folder.iterdir()] == ["sweep.toml"]


@pytest.mark.long
def test_a_cluster_by_its_address(folder):
    """Its workers, here threads, give the bytes that this process gives."""
    from distributed import LocalCluster

    run("sweep", "sweep.toml", "--out", "here.nc", folder=folder)
    with LocalCluster(
        n_workers=1, threads_per_worker=2, processes=False, dashboard_address=None, protocol="tcp"
    ) as it:
        done = run(
            "sweep",
            "sweep.toml",
            "--dask",
            it.scheduler_address,
            "--out",
            "there.nc",
            folder=folder,
        )
    assert (done.returncode, done.stderr) == (0, "")
    assert (folder / "there.nc").read_bytes() == (folder / "here.nc").read_bytes()


def test_the_file_on_the_page(tmp_path):
    page = (Path(__file__).parents[1] / "docs/sweeps.md").read_text()
    (tmp_path / "sweep.toml").write_text(page.split("```toml\n")[1].split("```")[0])
    done = run("sweep", "sweep.toml", folder=tmp_path)
    assert done.stdout.splitlines()[0] == "15 scenes: 15 solved"
