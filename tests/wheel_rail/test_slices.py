"""Rails whose profile changes along the track, and wheels out of round: closed forms, symmetries,
one profile.
"""

from dataclasses import replace
from functools import partial
from typing import Any, ClassVar

import numpy as np
import pytest
from scipy.interpolate import CubicSpline

from tests.scenes import refusals
from varcontact.errors import NoContact, SceneError
from varcontact.wheel_rail import (
    Position,
    Profile,
    ProfileSlices,
    Track,
    Velocity,
    WheelOnRail,
    WheelSet,
    WheelSetOnTrack,
    geometry_table,
    rolling_radius_difference,
    worn_profile,
)
from varcontact.wheel_rail.curve import Curve
from varcontact.wheel_rail.slices import Surface
from varcontact.wheel_rail.wear_laws import Archard

R, HEAD = 460.0, 300.0
MIDDLE = 2 * (750.0 - np.sqrt(HEAD**2 - (HEAD - 14.0) ** 2))
"""The gauge with which a round rail's top is below the middle of the wheel."""


def round_rail(
    radius: float = HEAD, y: float = 0.0, z: float = 0.0, width: float = 120.0
) -> Profile:
    across = np.linspace(-width, width, 241)
    return Profile(y=across + y, z=radius - np.sqrt(radius**2 - across**2) + z, kind="rail")


RAIL = round_rail()
CYLINDER = Profile(y=np.linspace(-60.0, 60.0, 121), z=np.zeros(121), kind="wheel")
WHEEL = WheelSet(wheel=CYLINDER, radius=R)


def on(rail: Any, wheel: WheelSet = WHEEL, **more: Any) -> WheelOnRail:
    usual: dict[str, Any] = {"vertical_force": 80e3, "dx": 1.0, "dy": 1.0, "friction": 0.0}
    return WheelOnRail(track=Track(rail=rail, gauge=MIDDLE), wheelset=wheel, **usual | more)


def flat(half: float, wheel: Profile = CYLINDER) -> ProfileSlices:
    """A chord of the wheel over an angle to either side of 0."""
    angles = np.array([-half, *np.linspace(-half, half, 31), half])
    return ProfileSlices(
        profiles=wheel, positions=angles, z=R * (np.cos(half) / np.cos(angles) - 1)
    )


def standard(rail: Any, wheel: Any, **more: Any) -> WheelOnRail:
    given: dict[str, Any] = {
        "vertical_force": 80e3,
        "dx": 1.0,
        "dy": 1.0,
        "position": Position(y=3.0, yaw=0.003),
    }
    return WheelOnRail(
        track=Track(rail=rail, cant=1 / 40), wheelset=WheelSet(wheel=wheel), **given | more
    )


def test_equal_slices_are_one_profile_to_the_bit() -> None:
    rail, wheel = Profile.rail_60e1(), Profile.s1002()
    known = standard(rail, wheel).solve()
    slices = ProfileSlices(profiles=rail, positions=[-50.0, 0.0, 80.0])
    turned = ProfileSlices(profiles=wheel, positions=[0.0, 1.0, 2.0])
    assert np.array_equal(standard(slices, turned).solve().force, known.force)


@pytest.mark.long
@pytest.mark.parametrize("side", ["left", "right"])
def test_slices_that_hardly_vary_are_near_one_profile(side: str) -> None:
    rail, wheel = Profile.rail_60e1(), Profile.s1002()
    varied = ProfileSlices(profiles=rail, positions=[-50.0, 0.0, 80.0], z=[0.0, 1e-9, 0.0])
    known, found = (standard(each, wheel, side=side, dy=0.5).solve() for each in (rail, varied))
    assert found.force == pytest.approx(known.force, abs=1e-5 * 80e3)
    assert found.z == pytest.approx(known.z, abs=1e-6)
    one, other = known.patches[0].patch, found.patches[0].patch
    assert other.location == pytest.approx(one.location, abs=2e-3)
    assert other.rolling_radius == pytest.approx(one.rolling_radius, abs=0.1)
    assert found.case.touching == pytest.approx(known.case.touching, abs=1e-5)


@pytest.mark.long
def test_ramp_is_a_level_rail_turned() -> None:
    slope = 0.02
    ramp = ProfileSlices(profiles=RAIL, positions=[-200.0, 200.0], z=[-200 * slope, 200 * slope])
    found, angle = on(ramp).solve(), np.arctan(slope)
    (patch,) = found.patches
    assert found.case.touching == pytest.approx(R - R / np.cos(angle), abs=1e-7)
    assert patch.normal_force == pytest.approx(80e3 / np.cos(angle), rel=1e-6)
    assert found.force == pytest.approx([-80e3 * slope, 0.0, 80e3], abs=0.1)
    assert patch.patch.location[0] == pytest.approx(-R * np.sin(angle), abs=2e-3)
    level = on(RAIL, vertical_force=float(patch.normal_force)).solve().patches[0]
    assert patch.peak_pressure == pytest.approx(level.peak_pressure, rel=1e-4)


@pytest.mark.parametrize("pitch", [0.0, 0.01, -0.02, 0.05])
def test_flat_touches_at_its_chord(pitch: float) -> None:
    half = 0.03
    case = on(RAIL, replace(WHEEL, wheel=flat(half)), position=Position(pitch=pitch))
    # the corner, or the circle where the flat is beside the rail
    nearest = R * np.cos(max(half - abs(pitch), 0.0))
    assert case.touching == pytest.approx(R - nearest, abs=1e-7)


def test_distance_below_a_flat_is_that_of_the_chord() -> None:
    half, deep = 0.03, 0.05
    case = on(
        RAIL, replace(WHEEL, wheel=flat(half)), z=R * (1 - np.cos(half)) + deep, vertical_force=None
    )
    (patch,) = case.patches(case.z or 0.0)
    surface, grid = patch.scene.surface, patch.scene.grid
    row = int(np.abs(grid.y).argmin())
    x = patch.location[0] + grid.x
    chord = R * np.cos(half)
    expected = np.where(np.abs(x) <= R * np.sin(half), 0.0, chord - np.sqrt(R**2 - x**2))
    assert surface.h[row] - surface.h[row].min() == pytest.approx(expected, abs=1e-6)
    assert patch.approach == pytest.approx(deep, abs=1e-5)
    assert patch.location[0] == pytest.approx(0.0, abs=1e-6)


@pytest.mark.long
def test_rolling_back_and_forth_are_mirror_images() -> None:
    wheel = replace(WHEEL, wheel=flat(0.03))
    left, right = (
        on(RAIL, wheel, position=Position(pitch=sign * 0.02)).solve() for sign in (-1, 1)
    )
    assert left.z == pytest.approx(right.z, abs=1e-7)
    assert left.patches[0].patch.location[0] == pytest.approx(
        -right.patches[0].patch.location[0], abs=1e-6
    )
    rolled = on(RAIL, wheel, position=Position(pitch=0.02 - 4 * np.pi)).solve()
    assert rolled.z == pytest.approx(right.z, abs=1e-9)


@pytest.mark.parametrize("s", [0.0, 25.0, 80.0, 100.0])
def test_between_two_profiles_sections_are_their_means(s: float) -> None:
    """Heads of two radii with equal parts of the arc; linear between two slices."""
    slices = ProfileSlices(profiles=[RAIL, round_rail(200.0)], positions=[0.0, 100.0])
    (section,) = on(slices, position=Position(s=s)).rail.sections(0.0)
    at = section.sampled(5.0)
    y, z = section.points(at).T
    part = np.linspace(-1.0, 1.0, 20001)
    ends = [radius * np.array([np.sin(a), 1 - np.cos(a)]) for radius in (300.0, 200.0) for a in [
        part * np.arcsin(120.0 / radius)]]  # fmt: skip
    mean = (1 - s / 100) * ends[0] + s / 100 * ends[1]
    assert z == pytest.approx(np.interp(y - 750.0, *mean), abs=1e-4)


@pytest.mark.long
def test_two_rails_under_one_wheel_bear_it_together() -> None:
    """Wing and nose of equal heights to either side of the middle, each with half of the load."""
    wing, nose = (round_rail(y=y, width=20.0) for y in (-35.0, 35.0))
    track = Track(rail=(wing, nose), gauge=2 * (750.0 - 35.0 - 20.0), gauge_height=0.5)
    case = replace(on(RAIL), track=track)
    found = case.solve()
    assert len(found.patches) == 2
    assert [each.normal_force for each in found.patches] == pytest.approx([40e3, 40e3], rel=1e-6)
    alone = on(RAIL, vertical_force=40e3).solve()
    assert found.z == pytest.approx(alone.z, abs=1e-5)
    lower = replace(track, rail=(wing, replace(nose, z=nose.z + 1.0)))
    (patch,) = replace(case, track=lower).solve().patches
    assert patch.normal_force == pytest.approx(80e3, rel=1e-6)


@pytest.mark.long
def test_nose_takes_over_where_it_begins() -> None:
    """A wing that descends and a nose that begins at s = 0 and rises."""
    wing = ProfileSlices(
        profiles=round_rail(y=-35.0, width=20.0), positions=[-200.0, 200.0], z=[-1.0, 1.0]
    )
    nose = ProfileSlices(
        profiles=round_rail(y=35.0, width=20.0), positions=[0.0, 400.0], z=[1.0, -1.0]
    )
    track = Track(rail=(wing, nose), gauge=2 * (750.0 - 35.0 - 20.0), gauge_height=0.5)
    shares = []
    for s in (-100.0, 100.0, 180.0):
        case = replace(on(RAIL, position=Position(s=s)), track=track)
        shares.append(
            {
                bool(each.patch.location[1] > 750.0): each.normal_force
                for each in case.solve().patches
            }
        )
    assert list(shares[0]) == [False]
    assert shares[1][False] == pytest.approx(shares[1][True], rel=1e-4)
    assert list(shares[2]) == [True]


@pytest.mark.long
def test_step_is_climbed_at_its_edge() -> None:
    """The circle comes down on the edge of a higher rail ahead."""
    height, ahead = 0.2, 8.0
    step = ProfileSlices(
        profiles=RAIL, positions=[-100.0, 0.0, 0.0, 100.0], z=[0.0, 0.0, -height, -height]
    )
    case = on(step, position=Position(s=-ahead))
    assert case.touching == pytest.approx(-height + R - np.sqrt(R**2 - ahead**2), abs=1e-6)
    (patch,) = case.solve().patches
    assert patch.patch.location[0] == pytest.approx(ahead, abs=3.0)
    assert on(step, position=Position(s=50.0)).touching == pytest.approx(-height, abs=1e-6)


@pytest.mark.long
def test_grids_are_chosen_for_an_accuracy_where_profiles_vary() -> None:
    waves = ProfileSlices(
        profiles=RAIL, positions=np.arange(-200.0, 201.0, 25.0), z=[0.0, 0.1] * 8 + [0.0]
    )
    found = on(
        waves, dx=None, dy=None, friction=0.3, velocity=Velocity(speed=1e3, yaw_rate=1e-3)
    ).solve(accuracy=0.02)
    assert np.isfinite(found.error).all()
    assert found.force[2] == pytest.approx(80e3, rel=1e-5)


@pytest.mark.long
def test_wheel_set_with_a_flat_is_balanced() -> None:
    wheel = flat(0.02, Profile.s1002())
    track = Track(rail=Profile.rail_60e1(), cant=1 / 40)
    case = WheelSetOnTrack(
        track=track, wheelset=WheelSet(wheel=wheel), vertical_force=160e3, free=()
    )
    found = case.estimate()
    assert found.force[1:] == pytest.approx([0.0, 160e3], abs=5.0)
    rounded = replace(case, wheelset=WheelSet(wheel=Profile.s1002())).estimate()
    assert found.z > rounded.z + 0.05  # the axle sinks by a part of the flat's depth, 0.092 mm


@pytest.mark.long
def test_a_crossing_on_one_side_alone() -> None:
    """The other wheel is as on equal rails; the axle rolls by the difference of the heights."""
    low = ProfileSlices(profiles=RAIL, positions=[-100.0, 100.0], z=[0.5, 0.5])
    track = Track(rail=RAIL, gauge=MIDDLE)
    usual: dict[str, Any] = {
        "wheelset": WHEEL,
        "vertical_force": 160e3,
        "friction": 0.0,
        "free": ("roll",),
    }
    for side, sign in (("left", -1), ("right", 1)):
        found = WheelSetOnTrack(track=replace(track, **{f"{side}_rail": low}), **usual).estimate()
        assert found.position.roll == pytest.approx(sign * 0.5 / 1500.0, rel=2e-3)
        assert {wheel.case.side: wheel.case.track.rail is low for wheel in found.wheels}[side]
        assert [wheel.case.track.rail is RAIL for wheel in found.wheels].count(True) == 1
        assert getattr(found.track, f"{side}_rail") is low
    with pytest.raises(SceneError, match="same on both sides"):
        rolling_radius_difference(found.track, WHEEL, 1.0)
    with pytest.raises(SceneError, match=r"track.left_rail"):
        replace(track, left_rail=CYLINDER)


test_slices_that_make_no_surface_are_refused = refusals(
    ({"positions": [0.0, 20.0, 10.0]}, "slice 3 at 10 is out of order"),
    ({"positions": [0.0, 0.0, 0.0]}, "slice 3 at 0 is out of order"),
    ({"positions": [0.0, 1.0], "profiles": [RAIL]}, "as many as positions"),
    ({"positions": [0.0, 1.0], "profiles": [RAIL, CYLINDER]}, "all of a rail: slice 2 is not"),
    ({"positions": [0.0, 7.0], "profiles": CYLINDER}, "less than a turn"),
    ({"positions": [0.0, 1.0], "z": [1.0, 2.0, 3.0]}, "one for each position"),
    ({"positions": [0.0, 1.0], "features": [[0.0, 5.0], [5.0, 0.0]]}, "ascend"),
    of=partial(ProfileSlices, profiles=RAIL),
)
RISING = ProfileSlices(profiles=RAIL, positions=[0.0, 100.0], z=[0.0, 1.0])
STEP = ProfileSlices(profiles=RAIL, positions=[0.0, 50.0, 50.0, 100.0], z=[0.0, 0.0, -9.0, -9.0])
NODES: dict[str, Any] = {"y": [-1.0, 1.0], "yaw": [-1e-3, 1e-3], "vertical_force": 1e4}
test_what_needs_one_profile_refuses_slices = refusals(
    (
        lambda: on(RISING, position=Position(s=101.0)),
        r"position\.s.*within the slices, 0 to 100 mm",
    ),
    (lambda: on(RISING, conformal=True), "straight along the rail"),
    (lambda: on(RISING, position=Position(s=50.0)).estimate("hertz"), r"normal = .hertz"),
    (lambda: geometry_table(Track(rail=RISING), WHEEL, **NODES), "one profile along the track"),
    (
        lambda: worn_profile([on(RISING).solve()], Archard(k=1e-4, hardness=2e3), "rail"),
        "which does not vary",
    ),
    (lambda: Track(rail=flat(0.01)), "a Profile of kind 'rail'"),
    (
        lambda: on(STEP, z=1.0, vertical_force=None, position=Position(s=10.0)).patches(1.0),
        "a step of the profile, or a rail beside it, is too high",
    ),
)


@pytest.mark.long
@pytest.mark.parametrize("spacing", [10.0, 25.0])
def test_approximating_splines_of_parabolas_are_above_them_by_a_third_of_the_spacing(
    spacing: float,
) -> None:
    """Schoenberg's spline of x^2 is x^2 + h^2/3, of a wave of four spacings two thirds at a slice;
    lines stay lines.
    """
    x = spacing * np.arange(-8, 9)
    wave = np.cos(np.pi / 2 * np.arange(-8, 9))
    for z, rise in ((1e-4 * x**2, 1e-4 * spacing**2 / 3), (1e-2 * x, 0.0), (0.1 * wave, -0.1 / 3)):
        through = ProfileSlices(profiles=RAIL, positions=x, z=z - z[8])
        tops = []
        for slices in (through, replace(through, approximating=True)):
            (section,) = on(slices).rail.sections(0.0)
            tops.append(section.points(section.at(np.array([750.0])))[0, 1])
        assert tops[1] - tops[0] == pytest.approx(rise, abs=1e-9)
    few = ProfileSlices(profiles=RAIL, positions=[-50.0, 50.0], z=[-1.0, 1.0], approximating=True)
    assert on(few).touching == pytest.approx(
        on(replace(few, approximating=False)).touching, abs=1e-9
    )


@pytest.mark.long
def test_approximating_splines_of_wheels_are_closed() -> None:
    """Slices around the whole wheel, turned by one of them: the same wheel, also where they
    begin.
    """
    angles = np.linspace(-np.pi, np.pi, 60, endpoint=False)
    radii = 0.2 * np.cos(2 * angles) + 0.05 * np.cos(9 * angles)
    wheel = ProfileSlices(profiles=CYLINDER, positions=angles, z=radii, approximating=True)
    turned = ProfileSlices(
        profiles=CYLINDER, positions=angles, z=np.roll(radii, 1), approximating=True
    )
    pitch = np.array([3.1, 0.4])
    step = angles[1] - angles[0]
    one = [
        on(RAIL, replace(WHEEL, wheel=wheel), position=Position(pitch=p)).touching for p in pitch
    ]
    other = [
        on(RAIL, replace(WHEEL, wheel=turned), position=Position(pitch=p - step)).touching
        for p in pitch
    ]
    assert one == pytest.approx(other, abs=1e-9)


def joint(gap: float, rail: Profile = RAIL) -> tuple[ProfileSlices, ProfileSlices]:
    """A rail that ends at s = 0, and one that begins behind a gap."""
    first = ProfileSlices(profiles=rail, positions=[-400.0, -200.0, 0.0])
    return first, ProfileSlices(profiles=rail, positions=[gap, 200.0 + gap, 400.0 + gap])


STANDARD: dict[str, Any] = {
    "wheelset": WheelSet(wheel=Profile.s1002()), "velocity": Velocity(speed=2000.0), "friction": 0.3
}  # fmt: skip


@pytest.mark.long
@pytest.mark.filterwarnings("error::varcontact.wheel_rail.RoughProfile")
@pytest.mark.parametrize("load", [{"z": 0.198}, {"vertical_force": 10e3}])
@pytest.mark.parametrize("s", [-8.0, -3.2, 9.2])
def test_a_rail_that_ends_beside_the_contact_is_not_felt(s: float, load: dict[str, Any]) -> None:
    """The contact is 5 mm long; CONTACT's force of the endless rail, and its largest pressure."""
    track = Track(rail=joint(6.0, Profile.rail_60e1()), cant=1 / 40)
    case = WheelOnRail(track=track, position=Position(s=s), dx=0.2, dy=0.2, **STANDARD | load)
    found = case.solve()
    expected, peak = ([278.4, 35.7, 9937.2], 338.4) if "z" in load else ([277.6, 35.6, 10e3], 339.1)
    assert found.force == pytest.approx(expected, abs=0.6)
    assert found.patches[0].peak_pressure == pytest.approx(peak, abs=0.1)


@pytest.mark.parametrize("s", [-5.0, -0.5, 1.0, 3.0, 5.5])
def test_distances_at_a_joint_are_those_of_the_endless_rail(s: float) -> None:
    deep, gap, yaw = 0.15, 6.0, 0.004
    (patch,) = on(joint(gap), z=deep, vertical_force=None, position=Position(s=s, yaw=yaw)).patches(
        deep
    )
    x, y = np.meshgrid(patch.scene.grid.x, patch.scene.grid.y)
    x, y = x + patch.location[0], y + patch.location[1]
    across = x * np.cos(yaw) + y * np.sin(yaw)  # to the axis of the cylinder
    distance = R - np.sqrt(R**2 - across**2) + HEAD - np.sqrt(HEAD**2 - (y - 750.0) ** 2)
    there = (x + s <= 0) | (x + s >= gap)
    found = patch.scene.surface.h + deep - patch.approach
    assert found[there] == pytest.approx(distance[there], abs=2e-4)
    assert (found[~there] > deep).all()


@pytest.mark.long
@pytest.mark.filterwarnings("error::varcontact.wheel_rail.RoughProfile")
@pytest.mark.filterwarnings("ignore::varcontact.wheel_rail.CoarseElements")
@pytest.mark.parametrize("gap", [2.0, 30.0])
def test_forces_over_a_joint_are_continuous_and_mirror_images(gap: float) -> None:
    track = Track(rail=joint(gap), gauge=MIDDLE)
    usual: dict[str, Any] = {"wheelset": WHEEL, "friction": 0.0, "dx": 0.5, "dy": 1.0}

    def loaded(s: float) -> Any:
        return WheelOnRail(
            track=track, position=Position(s=s), vertical_force=20e3, **usual
        ).solve()

    ends = [loaded(s) for s in (-20.0, gap + 20.0)]
    assert ends[0].z == pytest.approx(ends[1].z, abs=1e-9)
    places = np.linspace(-7.0, gap / 2, 6)
    heights = np.array([loaded(float(s)).z for s in places])
    opposite = np.array([loaded(float(gap - s)).z for s in places[::3]])
    assert heights[0] == pytest.approx(ends[0].z, rel=1e-6)
    assert opposite == pytest.approx(heights[::3], rel=0.01)
    # it sinks as it rolls into the gap, by the slope of a circle on the edge at the most
    assert (np.diff(heights) > -1e-3).all()
    assert np.diff(heights).max() < np.diff(places)[0] * (gap / 2 / R + 0.01)


@pytest.mark.long
@pytest.mark.filterwarnings("error::varcontact.wheel_rail.RoughProfile")
@pytest.mark.filterwarnings("ignore::varcontact.wheel_rail.CoarseElements")
def test_a_nose_that_begins_under_the_wheel_takes_its_load_step_by_step() -> None:
    wing, nose = (round_rail(y=y, width=20.0) for y in (-35.0, 35.0))
    begun = ProfileSlices(profiles=nose, positions=[0.0, 400.0], z=[0.0, 1e-9])
    track = Track(
        rail=(ProfileSlices(profiles=wing, positions=[-200.0, 200.0]), begun),
        gauge=1390.0,
        gauge_height=0.5,
    )
    shares = []
    for s in np.arange(-11.0, 8.0, 3.0):
        found = replace(on(RAIL, position=Position(s=float(s))), track=track).solve()
        shares.append(
            sum(each.normal_force for each in found.patches if each.patch.location[1] > 750.0)
            / 80e3
        )
    assert shares[0] == 0.0
    assert shares[-1] == pytest.approx(0.5, rel=1e-5)
    assert (np.diff(shares) >= -1e-6).all()
    assert np.diff(shares).max() < 0.25


class Counted(Curve):
    """A curve that counts how often it is asked."""

    asked: ClassVar[list[int]] = []

    def cubics(self, begin: np.ndarray, within: np.ndarray) -> np.ndarray:
        Counted.asked.append(begin.size)
        return super().cubics(begin, within)


@pytest.mark.long
@pytest.mark.parametrize("count", [5, 150])
def test_slices_are_the_sum_of_their_sections_and_added_up_once(count: int) -> None:
    """Heads with a kink and features, each of another radius; far from a place they are not looked
    at.
    """
    y = np.linspace(-40.0, 40.0, 81)
    radii = 250.0 + 50.0 * np.sin(np.arange(count))
    profiles = [
        Profile(y=y, z=np.where(y > 20.0, 2.5 * (y - 20.0), 0.0) + y**2 / 2 / r, kind="rail")
        for r in radii
    ]
    curves = tuple(Counted(each.curve.s, each.curve.coefficients) for each in profiles)
    features = np.array([[0.0, 30.0 + 0.01 * i, curve.s[-1]] for i, curve in enumerate(curves)])
    weights = np.concatenate([np.eye(count), np.zeros((count, 1))], axis=1)
    positions = 10.0 * np.arange(count)
    surface = Surface(positions, curves, features, weights)
    at, v = np.meshgrid(np.linspace(11.0, 29.0, 30), np.linspace(0.0, 2.0, 301))
    Counted.asked.clear()
    found = surface.points(at, v)
    asked = len(Counted.asked)
    surface.points(at + 0.1, v)
    assert len(Counted.asked) == asked <= 2 * 25
    by_hand = CubicSpline(positions, np.eye(count))(at)
    points = np.moveaxis(
        [c.points(np.interp(v, [0, 1, 2], f)) for c, f in zip(curves, features, strict=True)], 0, 2
    )
    # beside breakpoints of sections further away cubics are not theirs to the last digit
    assert found[0] == pytest.approx(np.einsum("ijk,ijkl->ijl", by_hand, points), abs=2e-5)
    step = 1e-4
    for along, by in ((1, (step, 0.0)), (2, (0.0, step))):
        ahead, behind = (surface.points(at + sign * by[0], v + sign * by[1])[0] for sign in (1, -1))
        smooth = np.abs(v - 1.0) > 0.01
        assert found[along][smooth] == pytest.approx(
            ((ahead - behind) / 2 / step)[smooth], abs=2e-2
        )


def test_a_wheel_beside_slices_has_no_contact() -> None:
    with pytest.raises(NoContact, match="beside the rail"):
        _ = on(RISING, position=Position(y=300.0)).touching
