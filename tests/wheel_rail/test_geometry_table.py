"""Contacts tabulated: what the positions themselves give, at the nodes and between; mirror images;
speed of change.
"""

from dataclasses import replace
from functools import partial

import numpy as np
import pytest

from tests.scenes import refusals
from tests.wheel_rail.conditions import TRACK, WHEELSET, cone, flat_track, wheel
from varcontact.errors import NoContact, SceneError
from varcontact.theories import table_forces
from varcontact.wheel_rail import Position, Profile, Velocity, WheelOnRail, WheelSet
from varcontact.wheel_rail.geometry_table import (
    geometry_table,
)  # where doctests are collected, the package has a module

LOAD = 50e3
MOVING = Velocity(
    speed=20e3, pitch_rate=-43.4, lateral=12.0, vertical=-3.0, roll_rate=2e-3, yaw_rate=0.02
)


@pytest.fixture(scope="module")
def table():
    return geometry_table(
        TRACK,
        WHEELSET,
        y=np.linspace(-6.0, 6.0, 13),
        yaw=np.linspace(-0.01, 0.01, 5),
        vertical_force=LOAD,
    )


def wheels(y, yaw):
    common = {"velocity": MOVING, "vertical_force": LOAD, "with_friction": False}
    return [wheel(y, yaw=yaw, side=side, **common) for side in ("left", "right")]


@pytest.mark.long
@pytest.mark.parametrize(("y", "yaw"), [(2.0, 0.005), (-3.0, 0.01), (0.0, 0.0)])
def test_at_the_nodes_it_is_the_estimate_of_both_wheels(table, y, yaw):
    """Contacts of the left wheel from mirror images; creepages, forces and moment are its own."""
    found, direct = table.forces(y, yaw, MOVING), [case.estimate() for case in wheels(y, yaw)]
    force, moment = np.zeros(3), np.zeros(3)
    each = [(side, patch) for side in direct for patch in side.patches]
    for (side, patch), row, rolled, creep in zip(
        each, found.patches, found.creepages, found.creep_forces, strict=True
    ):
        assert row[:3] == pytest.approx(patch.frame.origin, abs=1e-6)
        ellipse = patch.ellipse
        assert row[3:] == pytest.approx(
            [patch.angle, ellipse.a, ellipse.b, ellipse.normal_force, patch.approach], rel=1e-6
        )
        wanted = patch.creepage
        assert rolled == pytest.approx([wanted.vx, wanted.vy, wanted.spin], rel=1e-6)
        assert creep == pytest.approx(patch.force[:2], rel=1e-6)
        on_wheel = -(patch.frame.axes @ [*creep, patch.force[2]])
        force += on_wheel
        arm = patch.frame.origin - [0.0, y, side.z - WHEELSET.radius]
        moment += np.cross(arm, on_wheel) - patch.moment * patch.frame.normal
    assert found.force == pytest.approx(force, rel=1e-6)
    assert found.moment == pytest.approx(moment, rel=1e-6)


def test_between_the_nodes_it_is_near_the_estimate(table):
    """Half way between nodes 1 mm apart, to a hundredth of the load."""
    found = table.forces(1.5, 0.0025, MOVING)
    direct = -sum(case.estimate().force for case in wheels(1.5, 0.0025))
    assert found.force == pytest.approx(direct, abs=0.01 * 2 * LOAD)


def test_forces_by_the_table_book_are_those_of_the_book_by_hand(table):
    found = table.forces(2.3, 0.004, MOVING, "table")
    for row, rolled, forces in zip(found.patches, found.creepages, found.creep_forces, strict=True):
        by_hand = table_forces(
            row[4], row[5], table.bodies.combined_G, table.friction * row[6], rolled
        )
        assert forces == pytest.approx(by_hand.force, rel=1e-9)


def test_a_flange_longer_than_the_ellipses_of_the_book():
    """Its a/b is refused by its place among the patches, and clamped as asked."""
    table = geometry_table(TRACK, WHEELSET, y=[-8.0, 8.0], yaw=[-0.01, 0.01], vertical_force=LOAD)
    with pytest.raises(SceneError, match=r"a/b\[1\] = \d+\.\d+ .* range of the book"):
        table.forces(8.0, 0.01, MOVING, "table")
    found = table.forces(8.0, 0.01, MOVING, "table", outside="clamp")
    by_hand = [
        table_forces(
            row[4],
            row[5],
            table.bodies.combined_G,
            table.friction * row[6],
            rolled,
            outside="clamp",
        ).force
        for row, rolled in zip(found.patches, found.creepages, strict=True)
    ]
    assert found.creep_forces == pytest.approx(np.array(by_hand), rel=1e-9)


def test_where_numbers_of_patches_differ_the_nearest_node_counts(table):
    changed = table.count.copy()
    changed[8:, :] = 0
    cut = replace(table, count=changed)
    with pytest.raises(
        NoContact, match=r"y = 1\.6 mm, yaw = 0: the right wheel has no contact there"
    ):
        cut.contacts(1.6, 0.0, "right")
    near = cut.contacts(1.4, 0.0, "right")[1]
    assert near == pytest.approx(table.contacts(1.0, 0.0, "right")[1])


@pytest.mark.long
def test_nodes_without_contact_are_nan_and_the_others_are_there(table):
    """A wheel beside the rail, at both ends of the table; what is between is what it is without
    them.
    """
    y = [-900.0, *table.y[4:9].tolist(), 900.0]
    with pytest.warns(
        UserWarning,
        match=r"10 of 35 nodes have no contact, the first at y = -900 mm, yaw = -0\.01: ",
    ):
        wide = geometry_table(TRACK, WHEELSET, y=y, yaw=table.yaw, vertical_force=LOAD)
    assert (
        np.isnan(wide.z[[0, -1]]).all()
        and np.isnan(wide.patches[[0, -1]]).all()
        and not wide.count[[0, -1]].any()
    )
    np.testing.assert_array_equal(wide.patches[1:-1], table.patches[4:9])
    np.testing.assert_array_equal(wide.z[1:-1], table.z[4:9])
    near, (z, found) = wide.contacts(20.0, 0.0, "right"), table.contacts(2.0, 0.0, "right")
    assert near[0] == pytest.approx(z) and near[1] == pytest.approx(found)
    with pytest.raises(NoContact, match="the left wheel has no contact"):
        wide.contacts(-850.0, 0.0, "left")


@pytest.mark.long
def test_of_more_patches_than_it_keeps_those_with_the_largest_force_count():
    """Five ridges of different heights under a cylinder."""
    y = np.linspace(-42.0, 42.0, 1681)
    z = 0.3 * (1 - np.cos(2 * np.pi * y / 16.0)) + 0.01 * np.cos(0.31 * y + 0.5)
    ridges, cylinder = Profile(y=y, z=z, kind="rail"), cone(0.0, half=40.0)
    track, wheelset = flat_track(ridges, 0.3), WheelSet(wheel=cylinder)
    given = {"track": track, "wheelset": wheelset, "vertical_force": 300e3, "with_friction": False}
    direct = WheelOnRail(position=Position(y=0.1, yaw=1e-3), **given).estimate()
    assert len(direct.patches) == 5
    largest = sorted(direct.patches, key=lambda each: each.force[2])[2:]
    with pytest.warns(UserWarning, match="of 5 patches, the 3 with the largest force count"):
        table = geometry_table(
            track, wheelset, y=[-0.1, 0.1], yaw=[-1e-3, 1e-3], vertical_force=300e3
        )
    wanted = sorted((each.frame.origin[1], each.ellipse.normal_force) for each in largest)
    assert table.patches[1, 1][:, [1, 6]] == pytest.approx(np.array(wanted), rel=1e-6)


test_what_is_refused = refusals(
    ({"y": [0.0, 1.0]}, "y = .*symmetric about 0"),
    ({"yaw": [0.01, -0.01]}, "yaw = .*ascending"),
    ({"friction": 0.0}, "friction = 0"),
    ({"normal": "herz"}, r"normal = 'herz' .*did you mean hertz"),
    ({"y": [-900.0, 900.0]}, "the wheel is beside the rail"),
    of=partial(
        geometry_table, TRACK, WHEELSET, y=[-1.0, 1.0], yaw=[-0.01, 0.01], vertical_force=LOAD
    ),
)


@pytest.mark.long
def test_each_wheel_bears_the_load_between_the_nodes():
    """Where contact passes to the flange, angles and forces interpolated apart bore up to 108 of 80
    kN.
    """
    coarse = geometry_table(
        TRACK, WHEELSET, y=np.arange(-8.0, 8.1), yaw=[-0.01, 0.0, 0.01], vertical_force=80e3
    )
    for y in np.linspace(-7.9, 7.9, 41):
        for side in ("left", "right"):
            _, found = coarse.contacts(float(y), 3e-3, side)
            assert found[:, 6] @ np.cos(found[:, 3]) == pytest.approx(80e3, rel=1e-5)
            assert (found[:, 4:] > 0).all()


test_bad_positions_and_velocities_are_refused = refusals(
    (lambda table: table.contacts(1.0, 0.0, "middle"), "side = 'middle' .* one of left, right"),
    (lambda table: table.contacts("a", 0.0, "left"), "y = 'a'"),
    (lambda table: table.forces(None, 0.0, MOVING), "y = None"),
    (lambda table: table.forces(0.0, np.array([0.0, 1e-3]), MOVING), "yaw = "),
    (lambda table: table.forces(0.0, 0.02, MOVING), "yaw = 0.02 .*within the table, -0.01 to 0.01"),
    (lambda table: table.forces(0.0, 0.0, 20e3), "velocity = 20000.0 .* a Velocity"),
    (
        lambda table: table.forces(0.0, 0.0, MOVING, "polach"),
        "theory = 'polach' .* a theory with a moment",
    ),
    (
        lambda table: table.forces(0.0, 0.0, Velocity(speed=100.0, yaw_rate=1.0)),
        r"does not roll forwards, .* is -\d",
    ),
    fixture="table",
)
