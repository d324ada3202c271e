"""The names of methods as one object, wherever they are taken."""

import dataclasses

import numpy as np
import pytest

import varcontact as vc
from tests.scenes import refusals
from tests.wheel_rail.conditions import TRACK, WHEELSET
from varcontact.wheel_rail import Position, WheelOnRail, WheelSetOnTrack

GRID = vc.Grid(nx=8, ny=8)
TANG = vc.Methods(normal="norm", tangential="tang")
BY_NAME = {"normal": "norm", "tangential": "tang"}


def same(one, other):
    np.testing.assert_array_equal(one.traction, other.traction)
    assert one.plan == other.plan


def test_methods_say_what_names_say(rolling):
    """In every function that takes them, to the bit."""
    scene = rolling(grid=GRID)
    assert vc.plan(scene, methods=TANG) == vc.plan(scene, **BY_NAME)
    same(vc.solve(scene, methods=TANG), vc.solve(scene, **BY_NAME))
    creepages = [(0.01, 0.0, 0.0), (0.02, 0.0, 0.01)]
    scans = (vc.scan(scene, creepages, methods=TANG), vc.scan(scene, creepages, **BY_NAME))
    for one, other in zip(*scans, strict=True):
        same(one, other)
    over = {"motion.vx": [0.01, 0.02]}
    assert vc.sweep(scene, over, methods=TANG).identical(vc.sweep(scene, over, **BY_NAME))


def test_methods_of_wheels(rolling):
    case = WheelOnRail(
        track=TRACK, wheelset=WHEELSET, position=Position(y=2.0), vertical_force=8e4, dx=1.0, dy=1.0
    )
    one, other = (case.solve(**more) for more in ({"methods": TANG}, BY_NAME))
    for first, second in zip(one.patches, other.patches, strict=True):
        same(first.solution, second.solution)


def test_a_comparison_takes_methods_beside_names(rolling):
    joint = vc.Methods(tangential="tang-safeguarded", coupling="joint")
    scene = rolling(bodies=vc.Bodies(G=(1.0, 3.0), nu=(0.1, 0.3)), grid=GRID)
    table = vc.compare(scene, ["active-set", joint])
    assert table["method"].tolist() == ["active-set", "tangential=tang-safeguarded, coupling=joint"]
    assert table["outcome"].tolist() == ["solved", "solved"]
    assert table["traction_distance"].max() < 1e-6


def test_methods_are_frozen_and_by_name():
    assert vc.Methods() == vc.Methods(method="auto") and str(vc.Methods()) == "auto"
    assert str(TANG) == "normal=norm, tangential=tang"
    with pytest.raises(dataclasses.FrozenInstanceError):
        TANG.normal = "newton"


test_refused_when_they_are_made = refusals(
    ({"norml": "norm"}, "^Methods has no norml .*did you mean normal"),
    ({"normal": 3}, "^normal = 3 .*the name of a method"),
    ({"coupling": "jonson"}, "^coupling = .*did you mean johnson"),
    ({"formulation": "marchin"}, "^formulation = .*did you mean marching"),
    ({"method": "tang"}, '^method = .*did you mean tangential="tang"'),
    of=lambda **names: vc.Methods(**names),
)


test_refused_beside_each_other = refusals(
    ({"methods": TANG, "normal": "norm"}, r"^normal = .*left out beside methods"),
    ({"methods": TANG, "method": "convex"}, r"^method = .*left out beside methods"),
    ({"methods": "tang"}, "^methods = .*Methods"),
    of=lambda rolling, **more: [each(rolling(), **more) for each in (vc.solve, vc.plan)],
    fixture="rolling",
)


def test_refused_by_wheel_sets():
    case = WheelSetOnTrack(track=TRACK, wheelset=WHEELSET, vertical_force=1.6e5)
    with pytest.raises(vc.SceneError, match=r"^tangential = .*left out beside methods"):
        case.solve(methods=TANG, tangential="newton")
