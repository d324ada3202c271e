"""The command ``varcontact wheelrail``."""

import json

import numpy as np
import pandas as pd
import pytest

from tests.command import run
from varcontact.wheel_rail import Profile

CASE = """
vertical_force = 20e3
dx = 1.0
dy = 1.0
track = { rail = "60e1", cant = 0.025 }
wheelset = { wheel = "s1002" }
wear = { k = 3e-4, hardness = 3000.0 }
position = { y = 1.0, yaw = 1e-3 }
"""


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "one.toml").write_text(CASE)
    (tmp_path / "two.toml").write_text(
        'side = "both"\n' + CASE.replace("1.0, yaw", "[1.0, 2.0], yaw")
    )
    (tmp_path / "beside.toml").write_text(CASE.replace("1.0, yaw", "[1.0, 900.0], yaw"))
    return tmp_path


@pytest.mark.long
def test_one_wheel_with_its_pictures(folder):
    done = run(
        "wheelrail", "one.toml", "--plot", "wheel.png", "--plot-wear", "wear.png", folder=folder
    )
    assert (done.returncode, done.stderr) == (0, "")
    heading, row = done.stdout.splitlines()
    assert heading.split()[:5] == ["position", "side", "y", "on_rail", "on_wheel"]
    assert row.split()[:3] == ["1", "right", "1"]
    assert all((folder / name).stat().st_size > 20_000 for name in ("wheel.png", "wear.png"))


@pytest.mark.long
def test_a_rough_profile_is_told_once_with_the_table(folder):
    rail = Profile.rail_60e1()
    noise = 2e-3 * np.random.default_rng(1).normal(size=rail.z.size)
    np.savetxt(folder / "rough.csv", np.column_stack([rail.y, rail.z + noise]), delimiter=",")
    (folder / "rough.toml").write_text(CASE.replace('"60e1"', '"rough.csv"'))
    done = run("wheelrail", "rough.toml", "--plot", "wheel.png", folder=folder)
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout.count("a profile is rough there") == 1
    assert (folder / "wheel.png").stat().st_size > 20_000


@pytest.mark.long
def test_a_sequence_into_a_table_and_on_from_there(folder):
    first = run(
        "wheelrail", "two.toml", "--out", "table.csv", "--plot", "over.png", "--json", folder=folder
    )
    assert (first.returncode, first.stderr) == (0, "")
    rows = json.loads(first.stdout)
    assert [(row["position"], row["side"]) for row in rows] == [
        (1, "left"),
        (1, "right"),
        (2, "left"),
        (2, "right"),
    ]
    assert all(row["wear_depth"] > 0 for row in rows)
    assert (folder / "over.png").stat().st_size > 20_000
    content = (folder / "table.csv").read_bytes()
    assert pd.read_csv(folder / "table.csv")["FN"].tolist() == [row["FN"] for row in rows]
    again = run("wheelrail", "two.toml", "--out", "table.csv", "--json", folder=folder)
    assert json.loads(again.stdout) == rows
    assert (folder / "table.csv").read_bytes() == content


@pytest.mark.long
def test_an_accuracy_gives_errors_and_a_theory_none(folder):
    """As in the case file; elements that are given leave no choice."""
    (folder / "free.toml").write_text(CASE.replace("dx = 1.0\ndy = 1.0\n", ""))
    (folder / "file.toml").write_text(
        (folder / "free.toml").read_text() + "[solve]\naccuracy = 0.05\n"
    )
    done = run("wheelrail", "free.toml", "--accuracy", "0.05", "--json", folder=folder)
    (row,) = json.loads(done.stdout)
    assert row["track_Fz"] == pytest.approx(20e3, rel=1e-6)
    assert 0 < row["error_Fx"] < 0.05 * 0.3 * row["FN"]
    shown = run("wheelrail", "file.toml", folder=folder).stdout
    assert f"{row['Fx']:.0f} +- {row['error_Fx']:.0f}" in shown
    (fast,) = json.loads(
        run("wheelrail", "free.toml", "--tangential", "fastsim", "--json", folder=folder).stdout
    )
    assert fast["error_Fx"] is None
    assert fast["track_Fz"] == pytest.approx(20e3, rel=1e-6)
    refused = run("wheelrail", "one.toml", "--accuracy", "0.05", folder=folder)
    assert (refused.returncode, refused.stdout) == (2, "")
    assert "dx: the grids are chosen for the accuracy; leave dx and dy out" in refused.stderr


@pytest.mark.parametrize("option", ["tangential = 'fastsimm'", "tol = -1.0", "certify = 'foo'"])
def test_an_option_that_no_wheel_has_is_refused_once_before_a_table_is_made(folder, option):
    (folder / "wrong.toml").write_text((folder / "two.toml").read_text() + f"[solve]\n{option}\n")
    refused = run("wheelrail", "wrong.toml", "--out", "rows.csv", folder=folder)
    assert (refused.returncode, refused.stdout) == (2, "")
    assert refused.stderr.startswith(f"varcontact: {option} is not allowed")
    assert not (folder / "rows.csv").exists()


def test_a_wheel_that_is_not_solved(folder):
    done = run("wheelrail", "beside.toml", folder=folder)
    assert done.returncode == 3
    assert done.stdout.splitlines()[-1].startswith(
        "position 2, right, refused: the wheel is beside the rail"
    )
    assert done.stderr == "varcontact: 1 of 2 wheels are not solved, see the table\n"


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (
            ("two.toml", "--plot-wear", "wear.png"),
            "--plot-wear = 'wear.png' must be left out: there are 4 wheels",
        ),
        (("one.toml", "--out", "table.nc"), "--out"),
        (("three.toml",), "case file 'three.toml' cannot be read"),
    ],
)
def test_what_is_refused(folder, arguments, said):
    done = run("wheelrail", *arguments, folder=folder)
    assert done.returncode == 2
    assert done.stdout == ""
    assert said in done.stderr
