"""The command ``varcontact profiles``."""

import json
import os

import numpy as np
import pytest

from tests.command import assert_bad_input, run
from varcontact.wheel_rail import Profile


@pytest.fixture
def folder(tmp_path):
    """A rail and a wheel, a groove within another folder, a file in metres, one that is no profile,
    and slices.
    """
    rail, wheel = Profile.rail_60e1(step=1.0), Profile.s1002(step=1.0)
    rail.save(tmp_path / "head.csv")
    np.savetxt(tmp_path / "wheel.whl", np.stack([wheel.y, wheel.z], axis=1))
    (tmp_path / "rig").mkdir()
    y = np.linspace(-15.0, 15.0, 61)
    np.savetxt(tmp_path / "rig" / "groove.prr", y)
    points = "\n".join(f"{a} {b}" for a, b in zip(y, np.sqrt(20.0**2 - y**2), strict=True))
    (tmp_path / "rig" / "groove.prr").write_text(f"point.begin\n{points}\npoint.end\n")
    np.savetxt(tmp_path / "metres.txt", np.stack([rail.y, rail.z], axis=1) / 1000)
    slices = "0.0 1.0\n 2\n 0 0 0\n 1\n 0.0 'head.csv'\n 100.0 'head.csv'\n"
    (tmp_path / "switch.slcs").write_text(slices)
    (tmp_path / "notes.md").write_text("no profile")
    return tmp_path


def test_a_folder_as_a_table(folder):
    done = run("profiles", ".", "--kind", "rail", folder=folder)
    assert done.returncode == 0
    lines = done.stdout.splitlines()
    assert lines[0].split()[:3] == ["file", "kind", "points"]
    assert [line.split()[0] for line in lines[1:5]] == [
        "head.csv",
        "rig/groove.prr",
        "switch.slcs",
        "wheel.whl",
    ]
    assert lines[4].split()[1:5] == ["wheel", str(Profile.s1002(step=1.0).y.size), "-70", "60"]
    assert "2 slices" in lines[3]
    text = "\n".join(lines[5:])
    assert "metres.txt: refused: the profile is 0.0742 mm wide: give millimetres" in text
    assert "rig/groove.prr: the rail is hollow, with z down" in text
    assert lines[-1] == "4 read, 1 refused"


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="named pipes are of Unix")
def test_a_pipe_in_the_folder_is_refused(folder):
    """Reading it would wait for ever."""
    os.mkfifo(folder / "rig" / "pipe.prr")
    rows = json.loads(run("profiles", "rig", "--json", folder=folder).stdout)
    assert [row["file"] for row in rows] == ["groove.prr", "pipe.prr"]
    assert rows[0]["refused"] is None and "is not a regular file" in rows[1]["refused"]


def test_units_kinds_and_one_file(folder):
    rows = json.loads(
        run(
            "profiles", "metres.txt", "--kind", "rail", "--scale", "1000", "--json", folder=folder
        ).stdout
    )
    (row,) = rows
    assert row["refused"] is None and row["doubts"] == []
    assert (row["y_from"], row["y_to"]) == pytest.approx((-37.08, 37.08), abs=0.05)
    (row,) = json.loads(run("profiles", "head.csv", "--json", folder=folder).stdout)
    assert row["points"] is None and 'kind is missing: "rail" or "wheel"' in row["refused"]


def test_rails_with_exchanged_sides_are_doubted(tmp_path):
    """Those that solving warns of; a rail inclined to the track side by 1:20 is right."""
    rail = Profile.rail_60e1(step=1.0)
    rail.rotated(-0.05).save(tmp_path / "right.csv")
    rail.rotated(0.05).save(tmp_path / "wrong.csv")
    right, wrong = json.loads(
        run("profiles", ".", "--kind", "rail", "--json", folder=tmp_path).stdout
    )
    assert right["doubts"] == []
    (doubt,) = wrong["doubts"]
    assert doubt.startswith("the profile leans to the field side by 1:2")
    assert "mirror_y" in doubt


def test_a_folder_without_profiles_is_refused(folder):
    (folder / "empty").mkdir()
    assert_bad_input(run("profiles", "empty", folder=folder), "a folder with profiles")
    for option, value in (("kind", "bogus"), ("scale", "0")):
        done = run("profiles", ".", f"--{option}", value, folder=folder)
        assert_bad_input(done, f"{option} = ")
