"""The command ``varcontact scan``."""

import csv
import json

import numpy as np
import pytest

import varcontact as vc
from tests.command import run, scene_file
from tests.scenes import make_scene
from varcontact.io.scene_toml import read_scene

SCENE = scene_file("vy = 0.01", axes=(1.2, 0.9))


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "scene.toml").write_text(SCENE)
    return tmp_path


@pytest.mark.long
def test_a_range_of_creepages_as_table_json_and_picture(folder):
    done = run(
        "scan", "scene.toml", "--vx", "0:0.2:5", "--out", "c.csv", "--plot", "c.png", folder=folder
    )
    assert (done.returncode, done.stderr) == (0, "")
    lines = done.stdout.splitlines()
    assert lines[0] == "5 solutions"
    assert lines[1].split() == ["vx", "vy", "spin", "Fx", "Fy", "Mz", "stick", "slip", "residual"]
    with (folder / "c.csv").open() as file:
        rows = list(csv.DictReader(file))
    scene, _ = read_scene(folder / "scene.toml")
    expected = vc.scan(scene, [(vx, 0.01, 0.0) for vx in np.linspace(0.0, 0.2, 5)])
    np.testing.assert_allclose(
        [float(row["Fx"]) for row in rows], [sol.force[0] for sol in expected], atol=1e-15
    )
    np.testing.assert_allclose(
        [float(row["Fy"]) for row in rows], [sol.force[1] for sol in expected], atol=1e-15
    )
    assert [int(row["stick"]) for row in rows] == [sol.elements["stick"] for sol in expected]
    assert (folder / "c.png").stat().st_size > 5_000
    again = run("scan", "scene.toml", "--vx", "0:0.2:5", "--json", "--out", "c.csv", folder=folder)
    assert [row["Fx"] for row in json.loads(again.stdout)] == [float(row["Fx"]) for row in rows]


def test_rounding_is_shown_as_zero(folder):
    done = run(
        "scan", "scene.toml", "--vx", "0.05,0.1", "--vy", "0", "--out", "c.csv", folder=folder
    )
    printed = [line.split()[3:6] for line in done.stdout.splitlines()[2:]]
    assert [cells[1:] for cells in printed] == [["0", "0"]] * 2 and all(
        float(cells[0]) < -0.01 for cells in printed
    )


def test_the_table_says_its_units(folder):
    (folder / "mm.toml").write_text(SCENE + '[units]\nlength = "mm"\nforce = "N"\n')
    strips = SCENE.replace('"ellipse"\na = 1.2\nb = 0.9', '"cylinders"\nR = 1.0').replace(
        "ny = 8", ""
    )
    (folder / "line.toml").write_text(
        strips.replace("vy = 0.01", "") + '[units]\nlength = "mm"\nforce = "N"\n'
    )
    said = [
        run("scan", f"{name}.toml", "--vx", "0.1", folder=folder).stdout.splitlines()[0]
        for name in ("mm", "line")
    ]
    assert said == [
        "1 solution, forces in N, moments in N mm, spin in 1/mm",
        "1 solution, forces in N/mm",
    ]


def test_creepages_from_a_table(folder):
    (folder / "rows.csv").write_text("vx,vy,spin\n0.05, 0, 0\n\n0, 0.05, 0.1\n")
    done = run("scan", "scene.toml", "--creepages", "rows.csv", "--json", folder=folder)
    rows = json.loads(done.stdout)
    assert [(row["vx"], row["vy"], row["spin"]) for row in rows] == [
        (0.05, 0.0, 0.0),
        (0.0, 0.05, 0.1),
    ]
    assert rows[0]["Fx"] < 0
    assert rows[1]["Mz"] != 0


def test_an_accuracy_gives_each_solution_its_grid(folder):
    (folder / "free.toml").write_text(SCENE[: SCENE.index("[grid]")])
    rows = json.loads(
        run(
            "scan", "free.toml", "--vx", "0.05", "--accuracy", "0.1", "--json", folder=folder
        ).stdout
    )
    scene, _ = read_scene(folder / "free.toml")
    (expected,) = vc.scan(scene, [(0.05, 0.01, 0.0)], accuracy=0.1)
    assert rows[0]["Fx"] == pytest.approx(expected.force[0], rel=1e-9)
    assert rows[0]["contact"] == expected.elements["contact"]


@pytest.mark.long
def test_what_is_finished_is_kept_when_a_solution_fails(folder):
    """Without creepage nothing is left to solve, and any tolerance is met; with creepage there is
    rounding.
    """
    command = [
        "scan",
        "scene.toml",
        "--vx",
        "0,0.05",
        "--vy",
        "0",
        "--tol",
        "1e-100",
        "--out",
        "c.csv",
    ]
    done = run(*command, folder=folder)
    assert done.returncode == 3
    assert done.stdout.startswith("1 solution\n")
    assert "varcontact: " in done.stderr
    assert len((folder / "c.csv").read_text().splitlines()) == 2


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--vx", "0:1"], "--vx = '0:1' is not allowed: must be FROM:TO:N with two values or more"),
        ([], "--vx, --vy, --spin: give a range or several values for at least one"),
        (["--vx", "0,1", "--vy", "0,1,2"], "given: --vx (2,), --vy (3,)"),
        (["--creepages", "none.csv"], "cannot be read (No such file"),
        (["--creepages", "bad.csv"], "the number of columns changed from 3 to 2"),
        (["--creepages", "empty.csv"], "table of vx, vy, spin"),
        (["--creepages", "bad.csv", "--vx", "1"], "left out where --vx, --vy or --spin are given"),
        (["--vx", "0,1", "--out", "bad.csv"], "exists already and is no table of varcontact's"),
        (["--vx", "0,1", "--out", "scene.nc"], "must end in .csv"),
    ],
)
def test_what_is_refused(folder, arguments, words):
    (folder / "bad.csv").write_text("0,1,2\n0,1\n")
    (folder / "empty.csv").write_text("vx,vy,spin\n")
    done = run("scan", "scene.toml", *arguments, folder=folder)
    assert done.returncode == 2
    assert words in done.stderr


def test_plain_hertz_shows_no_alarming_residual():
    """The residual of a closed form says how coarse the grid is: it does not stand where errors are
    looked for.
    """
    sol = vc.solve(make_scene(vc.Ellipse(a=1.0, b=1.0), 1.0, None, vc.Grid(nx=8, ny=8), None))
    lines = sol.report().splitlines()
    (line,) = [line for line in lines if "certificate  " in line]
    assert line.split(None, 1)[1] == "Hertz's closed form, exact in the continuum; no iterations"
    sampled = f"residual {sol.certificate.normal_residual:.1e} and relative gap {sol.certificate.relative_gap:.1e}"
    assert (
        f"(residual of the discretised equations on this grid: {sampled})"
        in lines[lines.index(line) + 1]
    )
