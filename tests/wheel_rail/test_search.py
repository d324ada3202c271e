"""The contact of simple bodies in closed form, and that of the benchmark's profiles by published
results.
"""

from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import brentq

from tests.scenes import refused
from tests.wheel_rail.conditions import (
    RAIL,
    TRACK,
    WHEELSET,
    benchmark,
    cone,
    flat_track,
    manchester,
    round_rail,
    round_wheel,
    wheel,
)
from varcontact.errors import NoContact, SceneError
from varcontact.kinematics import RigidBody, rotation
from varcontact.wheel_rail import Position, Profile, Track, WheelOnRail, WheelSet
from varcontact.wheel_rail.patches import contact_locus, reference_surface, tangent_of

SLOPE, RADIUS = 0.05, 300.0


def wheel_on_rail(rail, wheel, **more):
    return WheelOnRail(track=flat_track(rail), wheelset=WheelSet(wheel=wheel), z=0.0, **more)


def axial_distance(case, patch, z):
    """Distances of the wheel's surface, rebuilt from the patch, from the axle; and their places
    along it.
    """
    grid = patch.scene.grid
    rows = rail_heights(case, patch)
    height = rows[:, None] - (patch.scene.surface.h - patch.approach)
    x, s = np.broadcast_arrays(grid.x[None, :], grid.y[:, None])
    points = patch.frame.globally(np.stack([x, s, height], axis=-1))
    middle = np.array([0.0, case.position.y, z - case.wheelset.radius])
    along = (points - middle) @ case.position.rotation
    return np.hypot(along[..., 0], along[..., 2]), along[..., 1]


def rail_heights(case, patch):
    """z of a circular rail in the frame, by its centre."""
    centre = (
        case.track.origin + np.array([0.0, RADIUS]) - patch.frame.origin[1:]
    ) @ patch.frame.axes[1:, 1:]
    return centre[1] - np.sqrt(RADIUS**2 - (patch.scene.grid.y - centre[0]) ** 2)


def test_cone_on_cylinder_in_closed_form():
    """They touch where the rail has the cone's slope."""
    case = wheel_on_rail(round_rail(), cone())
    angle = -np.arctan(SLOPE)
    y, z = RADIUS * np.sin(angle), RADIUS * (1 - np.cos(angle))
    assert case.touching == pytest.approx(z + SLOPE * y, abs=1e-6)
    (patch,) = case.patches(case.touching + 0.03)
    assert patch.angle == pytest.approx(angle, abs=1e-6)
    assert patch.location == pytest.approx([0.0, 750.0 + y, z], abs=1e-3)
    assert patch.on_rail == pytest.approx([y, z], abs=1e-3)
    assert patch.rolling_radius == pytest.approx(460.0 - SLOPE * y, abs=1e-3)
    assert patch.approach == pytest.approx(0.03 * np.cos(angle), abs=2e-6)
    # the surface that the distance was taken from is the cone
    radius, along = axial_distance(case, patch, case.touching + 0.03)
    assert radius == pytest.approx(460.0 - SLOPE * (along - 750.0), abs=1e-6)
    # rolling on the local radius leaves spin by the angle alone
    assert patch.creepage.spin * patch.creepage.speed == pytest.approx(
        -np.sin(angle) * 1000 / 460, rel=5e-5
    )
    quotient = (460.0 - SLOPE * y) / 460.0
    assert patch.creepage.vx == pytest.approx(2 * (quotient - 1) / (quotient + 1), rel=2e-4)


def test_cone_on_cylinder_with_yaw_in_closed_form():
    """The locus is at sin(theta) = slope tan(yaw), and the normal of the wheel there is that of the
    rail.
    """
    yaw = 0.02
    case = wheel_on_rail(round_rail(), cone(), position=Position(y=2.0, yaw=yaw))
    theta = np.arcsin(SLOPE * np.tan(yaw))
    points = (case.locus.points - [0.0, 2.0, -460.0]) @ rotation(yaw=yaw)
    assert np.arctan2(points[:, 0], points[:, 2]) == pytest.approx(theta, abs=1e-9)
    normal = rotation(yaw=yaw) @ [np.sin(theta), SLOPE, np.cos(theta)]
    assert normal[0] == pytest.approx(0.0, abs=1e-12)
    angle = -np.arctan2(normal[1], normal[2])
    (patch,) = case.patches(case.touching + 0.02)
    assert patch.angle == pytest.approx(angle, abs=2e-6)
    assert patch.on_rail[0] == pytest.approx(RADIUS * np.sin(angle), abs=2e-3)
    assert patch.location[0] == pytest.approx(
        np.sin(theta) * patch.rolling_radius * np.cos(yaw)
        - np.sin(yaw) * (750 + patch.on_wheel[0]),
        abs=2e-3,
    )
    radius, along = axial_distance(case, patch, case.touching + 0.02)
    assert radius == pytest.approx(460.0 - SLOPE * (along - 750.0), abs=1e-6)
    assert patch.creepage.vy == pytest.approx(np.sin(yaw) / np.cos(angle), rel=2e-3)


def test_two_circles_touch_on_the_line_of_their_centres():
    offset = 12.0
    case = wheel_on_rail(round_rail(), round_wheel(), position=Position(y=-offset))
    # the wheel's centre of curvature is offset inside that of the rail
    angle = -np.arcsin(offset / (RADIUS + 500.0))
    y, z = RADIUS * np.sin(angle), RADIUS * (1 - np.cos(angle))
    assert case.touching == pytest.approx((RADIUS + 500.0) * (1 - np.cos(angle)), abs=1e-5)
    (patch,) = case.patches(case.touching + 0.02)
    assert patch.angle == pytest.approx(angle, abs=1e-6)
    assert patch.location == pytest.approx([0.0, 750.0 + y, z], abs=1e-3)
    assert patch.on_wheel[0] == pytest.approx(y + offset, abs=1e-3)
    # near the origin the distance is that of the combined curvatures
    grid, h = patch.scene.grid, patch.scene.surface.h
    rolling = 460.0 / np.cos(angle)
    hertz = grid.x[None, :] ** 2 / (2 * rolling) + grid.y[:, None] ** 2 / 2 * (
        1 / RADIUS + 1 / 500.0
    )
    assert h == pytest.approx(hertz, abs=2e-3 * hertz.max())


def test_left_and_right_are_mirror_images():
    right = benchmark(
        {"side": "right", "y_ws": 2.0, "roll": 1e-3, "yaw": 0.01, "pitch_rate": -4.34}
    )
    left = benchmark(
        {"side": "left", "y_ws": -2.0, "roll": -1e-3, "yaw": -0.01, "pitch_rate": -4.34}
    )
    z = right.touching + 0.03
    assert left.touching == pytest.approx(right.touching, abs=1e-12)
    (one,), (other,) = right.patches(z), left.patches(z)
    assert other.location == pytest.approx(one.location * [1, -1, 1], abs=1e-9)
    assert other.angle == pytest.approx(-one.angle, abs=1e-12)
    assert other.on_rail == pytest.approx(one.on_rail, abs=1e-9)
    assert other.on_wheel == pytest.approx(one.on_wheel, abs=1e-9)
    assert other.scene.surface.h == pytest.approx(one.scene.surface.h[::-1], abs=1e-9)
    mirrored = (other.creepage.vx, -other.creepage.vy, -other.creepage.spin)
    assert mirrored == pytest.approx(
        (one.creepage.vx, one.creepage.vy, one.creepage.spin), rel=1e-9
    )


def test_a_rotation_of_everything_about_the_track_turns_the_patch():
    """Both bodies turned by 30 mrad about x: the same patch elsewhere, but for weights taken along
    the vertical.
    """
    wheel, rail = WHEELSET.placed("right"), TRACK.placed("right")
    axle, centre = rotation(yaw=0.005), np.array([0.0, 3.0, -460.0])
    turn = rotation(roll=0.03)
    # pushed along the same direction of the bodies, which is not the vertical of the turned ones
    pushed = centre + np.array([0.0, 0.0, contact_locus(wheel, rail, axle, centre).touching + 0.03])
    places = []
    for spin in (np.eye(3), turn):
        own = rail.moved(spin[1:, 1:], np.zeros(2))
        overlaps = contact_locus(wheel, own, spin @ axle, spin @ pushed).overlaps(0.0)
        tangent = tangent_of(overlaps, own)
        body = RigidBody(position=spin @ pushed, rotation=spin @ axle)
        surface = reference_surface(overlaps, tangent, wheel, own, body, (0.5, 0.5), curved=False)
        places.append((tangent, surface.distance, surface.approach))
    (plain, distance, approach), (turned, turned_distance, turned_approach) = places
    assert turned.angle == pytest.approx(plain.angle + 0.03, abs=2e-5)
    assert turned.frame.origin == pytest.approx(turn @ plain.frame.origin, abs=5e-3)
    assert turned_approach == pytest.approx(approach, rel=1e-3)
    assert turned_distance.shape == distance.shape
    assert np.abs(turned_distance - distance)[distance < approach].max() < 1e-4


@pytest.mark.parametrize("row", manchester(), ids=lambda row: f"{row['side']} {row['y_ws']}")
def test_the_benchmarks_positions_angles_and_creepages(row):
    """CONTACT's own: location within 0.01 mm, angle within 0.2 mrad, creepages within 0.5 % (of
    1e-4 at least).
    """
    case = benchmark(row)
    (patch,) = case.patches(row["z_ws"])
    assert patch.location == pytest.approx([row["x"], row["y"], row["z"]], abs=0.01)
    assert patch.angle == pytest.approx(row["angle"], abs=2e-4)
    found = patch.creepage
    assert found.vx == pytest.approx(row["cksi"], rel=5e-3, abs=5e-7)
    assert found.vy == pytest.approx(row["ceta"], rel=5e-3, abs=5e-7)
    assert found.spin == pytest.approx(row["cphi"], rel=5e-3, abs=5e-7)


def rigid(y, yaw=0.0, track=TRACK, wheelset=WHEELSET):
    """Roll of a rigid wheel set that touches both rails, and its rolling radii, left and right."""

    def loci(roll):
        position = Position(y=y, roll=roll, yaw=yaw)
        common = {"track": track, "wheelset": wheelset, "position": position, "z": 0.0}
        return [WheelOnRail(side=side, **common).locus for side in ("left", "right")]

    def mismatch(roll):
        left, right = loci(roll)
        return left.touching - right.touching

    roll = brentq(mismatch, -0.02, 0.02, xtol=1e-8)
    return roll, [float(locus.radii[locus.gap.argmin()]) for locus in loci(roll)]


@pytest.mark.parametrize(
    "row", [row for row in manchester() if row["side"] == "right" and row["y_ws"] in (2, 6, 8)]
)
def test_roll_and_rolling_radius_of_the_benchmark(row):
    """The benchmark prescribes the roll at which both wheels touch, and a speed of rotation by the
    mean radius.
    """
    roll, radii = rigid(row["y_ws"], row["yaw"])
    assert roll == pytest.approx(row["roll"], rel=0.02, abs=5e-6)
    assert np.mean(radii) == pytest.approx(-2000.0 / row["pitch_rate"], abs=0.25)


def test_wheels_on_a_track_share_its_curves():
    """Placed once, and each side's its own; those of another cant, or radius, are others."""
    track = Track(rail=RAIL, cant=0.025)
    near, far = (wheel(y, track=track, side="left") for y in (0.0, 3.0))
    assert near.rail is far.rail and near.wheel is far.wheel
    assert near.rail.points(near.rail.s)[:, 0].max() < 0
    assert wheel(track=track).rail.points(wheel(track=track).rail.s)[:, 0].min() > 0
    flat = replace(track, cant=0.0).placed("left")
    larger = replace(WHEELSET, radius=500.0).placed("left")
    at = np.array([-750.0])
    assert abs(flat.angles(flat.at(at)) - near.rail.angles(near.rail.at(at))) > 0.02
    grown = larger.points(larger.at(at)) - near.wheel.points(near.wheel.at(at))
    assert grown[0, 1] == pytest.approx(40.0, abs=1e-9)


def test_the_gauge_is_measured_at_its_height():
    for gauge, height in ((1435.0, 14.0), (1440.0, 14.0), (1435.0, 16.0)):
        track = Track(rail=RAIL, gauge=gauge, gauge_height=height)
        curve = track.placed("right")
        points = curve.points(curve.sampled(0.005))
        assert points[points[:, 1] <= height, 0].min() == pytest.approx(gauge / 2, abs=0.01)
        assert points[:, 1].min() == pytest.approx(0.0, abs=1e-5)
        left = track.placed("left")
        assert left.points(left.s[-1])[0] == pytest.approx(-curve.points(curve.s[0])[0])


def test_cant_leans_the_rails_inwards():
    """A symmetric head of radius 300 has its highest point 300 sin(cant) outside of its middle."""
    track = Track(rail=Profile.rail_60e1(), cant=1 / 40)
    curve = track.placed("right")
    points = curve.points(curve.sampled(0.01))
    top = points[points[:, 1].argmin()]
    assert track.on_rail(top, "right") == pytest.approx(
        [300 * np.sin(1 / 40), 300 * (1 - np.cos(1 / 40))], abs=0.01
    )
    inclined = Track(rail=RAIL).placed("right")
    y = np.linspace(725.0, 785.0, 61)
    across = np.array([1.0, 0.0])
    apart = curve.points(curve.at(y, across))[:, 1] - inclined.points(inclined.at(y, across))[:, 1]
    assert np.abs(apart).max() < 0.15


@pytest.mark.parametrize(("make", "error", "field", "words"), [
    (lambda: wheel().patches(0.0), NoContact, "z", "above the rail; the wheel touches at z = 0.18213 mm"),
    (lambda: wheel(y=150.0).touching, NoContact, "position.y", "beside the rail: it is at y = 830.39 to 960 mm, the rail at 716.83 to 791.13 mm"),
    (lambda: wheel(y=-85.0).patches(7.0), SceneError, "z", "the contact reaches the end of a profile near y = "),
    (lambda: wheel(z=0.3), SceneError, None, "vertical_force and z are both given"),
    (lambda: wheel(vertical_force=None), SceneError, None, "neither vertical_force nor z is given"),
    (lambda: wheel(vertical_force=-1.0), SceneError, "vertical_force", "positive"),
    (lambda: wheel(friction=-1.0), SceneError, "friction", "zero or positive"),
    (lambda: wheel(side="middle"), SceneError, "side", "one of left, right"),
    (lambda: wheel(track=RAIL), SceneError, "track", r"track = Profile\(.* a Track"),
    (lambda: wheel(dx=1e-4, dy=1e-4).patches(0.3), SceneError, "dx, dy", "dx = 0.0001, dy = 0.0001 mm make "),
    (lambda: Track(rail=RAIL, gauge_height=50.0), SceneError, "track.gauge_height", "at most 38.5 mm"),
    (lambda: Track(rail=WHEELSET.wheel), SceneError, "track.rail", "a wheel's.* a Profile of kind 'rail'"),
    (lambda: WheelSet(wheel=RAIL), SceneError, "wheelset.wheel", "of kind 'wheel'"),
    (lambda: WheelSet(wheel=WHEELSET.wheel, radius=0.0), SceneError, "wheelset.radius", "positive"),
    (lambda: Position(yaw=1.2), SceneError, "position.yaw", "an angle in radians, within 0.5 of 0"),
])  # fmt: skip
def test_bad_cases_are_refused(make, error, field, words):
    refused(make, field, match=words, error=error)
