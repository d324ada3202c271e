"""Warnings point at the line of the user's call, however deep in the package they arise."""

from dataclasses import replace
from pathlib import Path
from warnings import catch_warnings, simplefilter

import numpy as np
import pytest
from scipy.optimize import brentq

import varcontact as vc
from tests.command import ROLLING_SPHERES, run
from varcontact.errors import warn
from varcontact.wheel_rail import (
    Archard,
    Position,
    Profile,
    Track,
    WheelOnRail,
    WheelSet,
    WheelSetOnTrack,
    geometry_table,
    wear,
)

PACKAGE = Path(vc.__file__).parent
SCENE = vc.Scene(
    bodies=vc.Bodies(G=82e3, nu=0.28),
    surface=vc.Paraboloids(Rx=460.0, Ry=300.0),
    normal_force=80e3,
    friction=0.3,
    motion=vc.Steady(vx=0.2),
    grid=vc.Grid(nx=8, ny=8),
    units=vc.MM_N,
)
RAIL = Profile.rail_60e1()
LEANING = Profile(y=RAIL.y, z=RAIL.z + RAIL.y / 40, kind="rail")
"""Its sides are probably exchanged: it leans to the field side."""
with catch_warnings():
    simplefilter("ignore")
    UPSIDE_DOWN = Profile(y=RAIL.y, z=-RAIL.z, kind="rail")
TRACK = Track(rail=RAIL, cant=1 / 40)
AXLE = WheelSet(wheel=Profile.s1002())
WHEEL = WheelOnRail(
    track=TRACK, wheelset=AXLE, position=Position(y=3.0), vertical_force=80e3, dx=1.0, dy=1.0
)
SET = WheelSetOnTrack(track=TRACK, wheelset=AXLE, vertical_force=160e3, dx=1.0, dy=1.0)
OUTWARDS = replace(TRACK, cant=-1 / 40)


def upside_down(folder):
    np.savetxt(folder / "rail.csv", np.column_stack([RAIL.y, -RAIL.z]), delimiter=",")
    return folder / "rail.csv"


CALLS = {
    "solve": lambda _: vc.solve(SCENE),
    "solve, to an accuracy": lambda _: vc.solve(replace(SCENE, grid="auto"), accuracy=0.1),
    "history": lambda _: vc.solve(replace(SCENE, motion=vc.Transient(steps=2, dq=1.0, vx=0.2))),
    "plot": lambda _: vc.solve(replace(SCENE, motion=vc.Steady(vx=1e-3))).plot(figsize=(3.5, 2.6)),
    "profile": lambda _: Profile(y=RAIL.y, z=RAIL.z, kind="wheel"),
    "profile, moved": lambda _: UPSIDE_DOWN.rotated(0.01),
    "profile of a file": lambda folder: Profile.read(upside_down(folder), kind="rail"),
    "wheel": lambda _: replace(WHEEL, track=OUTWARDS).solve(),
    "few elements": lambda _: replace(WHEEL, dx=5.0, dy=5.0).solve(),
    "sides exchanged": lambda _: replace(WHEEL, track=Track(rail=LEANING)).solve(),
    "estimate": lambda _: replace(WHEEL, track=Track(rail=LEANING)).estimate(),
    "wheel set, estimate": lambda _: replace(SET, track=Track(rail=LEANING)).estimate(),
    "wear": lambda _: wear(WHEEL.solve(), Archard(k=3e-4, hardness=300.0)),
    "geometry table": lambda _: geometry_table(
        TRACK, AXLE, y=[-900.0, 0.0, 900.0], yaw=[-1e-3, 1e-3], vertical_force=80e3
    ),
}


@pytest.mark.parametrize("name", CALLS)
def test_warnings_are_at_the_line_of_the_call(name, tmp_path, recwarn):
    CALLS[name](tmp_path)
    assert {each.filename for each in recwarn} == {__file__}


def test_of_python_c_too(recwarn):
    """Its lines are of the file "<string>", as those of a dataclass's __init__."""
    words = "from varcontact.wheel_rail import Profile\np = Profile.rail_60e1()\n"
    words += "Profile(y=p.y, z=p.z, kind='wheel')"
    exec(compile(words, "<string>", "exec"), {"__name__": "__main__"})
    assert {(each.filename, each.lineno) for each in recwarn} == {("<string>", 3)}


def test_of_searches_for_a_root_too(recwarn):
    """Those of the package, whose function scipy calls."""
    inside = {"__name__": "varcontact.inside", "warn": warn}
    exec("def missing(z):\n    warn('a doubt')\n    return z", inside)
    brentq(inside["missing"], -1.0, 2.0)
    assert {each.filename for each in recwarn} == {__file__}


def test_commands_are_users_too(tmp_path, recwarn):
    """Their lines are the package's own, in place of those of the parser of options."""
    units = 'units = { length = "mm", force = "N" }'
    (tmp_path / "scene.toml").write_text(ROLLING_SPHERES.replace("vx = 0.05", "vx = 0.2") + units)
    run("solve", "scene.toml", folder=tmp_path)
    assert {each.filename for each in recwarn} == {str(PACKAGE / "cli" / "solve.py")}


def test_nothing_counts_frames():
    """`errors.warn` is the only place that does."""
    sources = {path: path.read_text() for path in PACKAGE.rglob("*.py")}
    assert [path.name for path, text in sources.items() if "stacklevel" in text] == ["errors.py"]
