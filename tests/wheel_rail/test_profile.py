"""Profiles: designed ones against measured points, curves in closed form, smoothing, noise, and
what is refused.
"""

import itertools
import warnings
from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import least_squares

from tests.scenes import refused
from tests.wheel_rail.conditions import DATA, RAIL, WHEEL
from tests.wheel_rail.conditions import wheel as on_track
from varcontact.wheel_rail import DoubtfulProfile, Profile, Track, WheelSet, flange_dimensions
from varcontact.wheel_rail.profile_shape import crossed, flange

PROFILES = DATA / "profiles"
FINE_RAIL, FINE_WHEEL = Profile.rail_60e1(step=0.1), Profile.s1002(step=0.1)
TIP = int(FINE_WHEEL.z.argmax())


def arc(radius=100.0, half=0.3, n=121, kind="rail", **more):
    angle = np.linspace(-half, half, n)
    sign = 1 if kind == "rail" else -1
    return Profile(
        y=radius * np.sin(angle), z=sign * radius * (1 - np.cos(angle)), kind=kind, **more
    )


def roof(**more):
    """Two lines of slope 1 and -1 that meet in a kink at y = 0."""
    y = np.linspace(-10.0, 10.0, 41)
    return Profile(y=y, z=np.abs(y), kind="rail", **more)


def test_an_arc_has_its_curvature_and_slope():
    y = np.linspace(-25.0, 25.0, 51)
    for kind in ("rail", "wheel"):
        profile = arc(kind=kind)
        assert profile.curvature_at(y) == pytest.approx(0.01, rel=1e-3)
    slopes = y / np.sqrt(100.0**2 - y**2)
    assert np.tan(arc().angle_at(y)) == pytest.approx(slopes, abs=1e-6)
    assert arc().z_at(y) == pytest.approx(100 - np.sqrt(100.0**2 - y**2), abs=1e-7)
    assert np.isnan(arc().z_at(40.0))


def test_s1002_from_its_definition_is_the_benchmarks_wheel():
    """Points of the Manchester benchmark's file, which are rounded to five decimals."""
    wheel = Profile.s1002(step=0.05)
    inside = (WHEEL.y > -69.0) & (WHEEL.y < 60.0)
    flank = np.abs(WHEEL.y + 60.0) > 9.5  # but for the flange's steep sides, where z is sensitive
    assert np.abs(wheel.z_at(WHEEL.y) - WHEEL.z)[inside & flank].max() < 3e-5
    assert np.abs(wheel.z_at(WHEEL.y) - WHEEL.z)[inside].max() < 5e-4


def test_s1002_has_the_dimensions_of_its_standard():
    """Flange height 28 mm; flange thickness 32.5 mm, 10 mm below the running circle; slope 1/15 at
    the outside.
    """
    wheel = Profile.s1002()
    assert wheel.z.max() == pytest.approx(28.0, abs=1e-3)
    side = np.interp(10.0, wheel.z[wheel.y > -50][::-1], wheel.y[wheel.y > -50][::-1])
    assert side + 70.0 == pytest.approx(32.5, abs=0.01)
    assert wheel.z_at(0.0) == pytest.approx(0.0, abs=1e-9)
    assert np.tan(wheel.angle_at(50.0)) == pytest.approx(-1 / 15, rel=1e-6)


def test_rail_60e1_is_symmetric_smooth_and_72_mm_wide():
    rail = Profile.rail_60e1()
    assert rail.y == pytest.approx(-rail.y[::-1], abs=1e-12)
    assert rail.z == pytest.approx(rail.z[::-1], abs=1e-12)
    assert rail.kink_points.size == 0
    assert np.interp(14.3, rail.z[rail.y > 0], rail.y[rail.y > 0]) == pytest.approx(36.0, abs=0.005)
    for y, radius in ((0.0, 300.0), (18.0, 80.0), (32.0, 13.0)):
        assert rail.curvature_at(y) == pytest.approx(1 / radius, rel=2e-3)


def test_rail_60e1_is_the_benchmarks_rail_inclined_by_one_in_forty():
    """The best rigid motion of the standard's head onto the benchmark's points: 1/40, within 0.03
    mm.
    """
    head = np.abs(RAIL.y + 7.5) < 34.0
    rail = Profile.rail_60e1()

    def apart(motion):
        angle, dy, dz = motion
        y = np.cos(angle) * RAIL.y - np.sin(angle) * RAIL.z + dy
        z = np.sin(angle) * RAIL.y + np.cos(angle) * RAIL.z + dz
        return (rail.z_at(y) - z)[head]

    fit = least_squares(apart, [0.025, 7.5, 0.1])
    assert 1 / fit.x[0] == pytest.approx(40.0, abs=0.2)
    assert np.abs(fit.fun).max() < 0.03


def test_a_wheel_is_mirrored_by_its_flange_and_a_rail_as_told(tmp_path):
    points = np.genfromtxt(PROFILES / "wheel_S1002.csv", delimiter=",", skip_header=1)
    assert points[points[:, 1].argmax(), 0] > 0  # the file's y points to the flange
    assert WHEEL.y[WHEEL.z.argmax()] == pytest.approx(-55.0, abs=0.5)
    np.savetxt(tmp_path / "turned.csv", points * [-1, 1], delimiter=",")
    assert Profile.read(tmp_path / "turned.csv", "wheel").y == pytest.approx(WHEEL.y)
    with pytest.warns(
        DoubtfulProfile, match=r"the wheel's flange is at y = 54.89 mm, the outside: .* mirror_y"
    ):
        as_told = Profile.read(PROFILES / "wheel_S1002.csv", "wheel", mirror_y=False)
    assert as_told.y == pytest.approx(-WHEEL.y[::-1])
    mirrored = Profile.read(PROFILES / "rail_UIC60.csv", "rail", mirror_y=True)
    assert mirrored.z_at(-12.0) == pytest.approx(RAIL.z_at(12.0), abs=1e-9)


def test_smoothing_halves_the_wave_of_its_length():
    y = np.linspace(-100.0, 100.0, 2001)
    for length, kept in ((10.0, 0.5), (5.0, 16 / 17), (20.0, 1 / 17)):
        wave = Profile(
            y=y, z=np.cos(2 * np.pi * y / 10.0) * 1e-4 + 1e-5 * y**2, kind="rail", smoothing=length
        )
        inner = np.linspace(-40.0, 40.0, 401)
        ripple = wave.z_at(inner) - 1e-5 * inner**2
        assert (ripple.max() - ripple.min()) / 2e-4 == pytest.approx(kept, abs=0.01)


@pytest.mark.long
@pytest.mark.parametrize("smoothing", [5.0, 10.0])
def test_smoothing_does_not_straighten_the_ends(smoothing):
    """An arc has its curvature up to its ends, and beside a kink; noise counts no more there than
    inside.
    """
    smooth = arc(n=241, smoothing=smoothing)
    end = smooth.y[-1]
    assert smooth.curvature_at([-end + 0.5, end - 0.5, end - 1.0, 0.0]) == pytest.approx(
        0.01, rel=0.005
    )
    ridge = Profile(
        y=smooth.y, z=smooth.z + np.abs(smooth.y), kind="rail", kinks=[0.0], smoothing=smoothing
    )
    assert ridge.z_at(0.0) == pytest.approx(0.0, abs=1e-6)
    sharp = replace(ridge, smoothing=0.0)
    assert ridge.curvature_at([-1.0, 1.0]) == pytest.approx(
        sharp.curvature_at([-1.0, 1.0]), rel=0.05
    )
    noise = 0.002 * np.random.default_rng(0).normal(size=(20, smooth.z.size))
    found = [replace(smooth, z=smooth.z + each).curvature_at([end - 1.0, 0.0]) for each in noise]
    assert np.std(found, axis=0)[0] < 2 * np.std(found, axis=0)[1]


def test_kinks_are_found_and_kept():
    sharp = roof()
    assert sharp.y[sharp.kink_points] == pytest.approx([0.0])
    for profile in (sharp, roof(smoothing=5.0), roof(kinks=[0.0])):
        assert profile.z_at([-5.0, -0.25, 0.0, 3.0]) == pytest.approx(
            [5.0, 0.25, 0.0, 3.0], abs=1e-6
        )
    rounded = roof(kinks=[], smoothing=5.0)
    assert rounded.z_at(0.0) > 0.3
    assert RAIL.kink_points.size == WHEEL.kink_points.size == 0


@pytest.mark.parametrize("places", [[3.0], [-4.5], [-6.0, 2.0]])
def test_kinks_given_by_number_are_where_they_are(places):
    """Lines between kinks, turned by too little to be found; smoothing keeps them where they are
    given, and only there.

    Points nearest to the numbers count, whatever the order of the points.
    """
    y = np.linspace(-10.0, 10.0, 81)
    z = 0.2 * sum(np.abs(y - place) for place in places)
    assert Profile(y=y, z=z, kind="rail").kink_points.size == 0
    given = [place + 0.1 for place in places]
    for way in (slice(None), slice(None, None, -1)):
        kept = Profile(y=y[way], z=z[way], kind="rail", kinks=given, smoothing=4.0)
        assert kept.y[kept.kink_points] == pytest.approx(places)
        inner = y[np.abs(y) < 9.0]
        assert kept.z_at(inner) == pytest.approx(z[np.abs(y) < 9.0], abs=1e-6)
    elsewhere = Profile(y=y, z=z, kind="rail", kinks=[-place for place in places], smoothing=4.0)
    assert np.abs(elsewhere.z_at(places) - np.interp(places, y, z)).min() > 0.03


def test_points_on_top_of_each_other_are_left_out():
    profile = arc()
    twice = Profile(y=np.repeat(profile.y, 2), z=np.repeat(profile.z, 2) + 1e-6, kind="rail")
    assert twice.y.size == profile.y.size


def test_the_running_part_ends_where_the_profile_turns_under():
    """A head that comes back under itself: only what is seen from above can be touched."""
    angle = np.linspace(-2.5, 2.5, 201)
    bulb = Profile(y=20 * np.sin(angle), z=20 * (1 - np.cos(angle)), kind="rail")
    y = bulb.running.points(bulb.running.s)[:, 0]
    assert np.all(np.diff(y) > 0)
    assert y[-1] == pytest.approx(20.0, abs=0.05)
    assert bulb.z_at(10.0) == pytest.approx(20 - np.sqrt(300.0), abs=1e-6)


def test_profiles_that_look_like_those_of_the_other_kind_are_doubted():
    """Mirrored, and with the flange's back cut; they are taken as what they are said to be."""
    cut = WHEEL.y > -65.0
    for y, z in ((WHEEL.y, WHEEL.z), (-WHEEL.y, WHEEL.z), (WHEEL.y[cut], WHEEL.z[cut])):
        with pytest.warns(
            DoubtfulProfile,
            match=r'profile\.kind = "rail", but the points look like those of a wheel',
        ):
            assert Profile(y=y, z=z, kind="rail").kind == "rail"
    for rail in (RAIL, Profile.rail_60e1()):
        with pytest.warns(
            DoubtfulProfile,
            match=r'profile\.kind = "wheel", but the points look like those of a rail',
        ):
            assert Profile(y=-rail.y, z=rail.z, kind="wheel").kind == "wheel"


@pytest.mark.parametrize(("kind", "y", "z"), [
    ("rail", RAIL.y, -RAIL.z),
    ("wheel", WHEEL.y, -WHEEL.z),
    ("wheel", FINE_WHEEL.y[TIP:], -FINE_WHEEL.z[TIP:]),
])  # fmt: skip
def test_z_that_points_up_is_doubted(kind, y, z):
    with pytest.warns(
        DoubtfulProfile, match=f"the {kind}'s profile looks upside down: .* mirror_z"
    ):
        found = Profile(y=y, z=z, kind=kind)
    assert found.z == pytest.approx(z)


def ball(radius, half):
    """A roller, convex: its lowest point is in the middle."""
    y = np.linspace(-half, half, 201)
    return y, np.sqrt(radius**2 - y**2) - radius


SLOPE = np.linspace(-50.0, 50.0, 101)
WITHOUT_FLANGE = {
    "ball": ball(10.0, 9.9),
    "wide ball": ball(50.0, 49.9),
    "barrel": ball(100.0, 50.0),
    "cone": (SLOPE, 0.25 * SLOPE),
    "disc": (SLOPE[45:56], 0.0 * SLOPE[45:56]),
    "grooved roller": (SLOPE, -15.0 * np.cos(SLOPE / 20.0)),
    "edge": (SLOPE, -np.abs(SLOPE)),
}


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("name", WITHOUT_FLANGE)
@pytest.mark.parametrize("shift", [-90.0, 0.0, 500.0])
def test_wheels_without_a_flange_are_taken_as_they_are(name, shift, tmp_path):
    """Wherever their y counts from; balls of 50 and 100 mm were those of a rail, cones were
    mirrored.
    """
    y, z = WITHOUT_FLANGE[name]
    np.savetxt(tmp_path / "roller.csv", np.stack([y + shift, z], axis=1), delimiter=",")
    found = Profile.read(tmp_path / "roller.csv", "wheel")
    assert found.y == pytest.approx(y + shift) and found.z == pytest.approx(z)
    assert np.ptp(found.running.points(found.running.s)[:, 0]) == pytest.approx(np.ptp(y), rel=1e-3)


@pytest.mark.parametrize("shift", [-90.0, 0.0, 500.0])
def test_a_flange_is_found_wherever_y_counts_from(shift):
    assert flange(WHEEL.y + shift, WHEEL.z) == -1.0
    assert flange(shift - WHEEL.y, WHEEL.z) == 1.0
    assert flange(WHEEL.y + shift, -WHEEL.z) == 0.0


def nose(top, low):
    """A crossing's nose, or a wing: a narrow head beside a low plane."""
    y = np.linspace(-15.0, low, 200)
    return y, 38.0 * np.clip((np.abs(y) - top) / 8.0, 0.0, 1.0) ** 1.5


ARC = np.linspace(-20.0, 20.0, 201)
UNUSUAL = {
    "groove": (ARC, np.sqrt(np.maximum(10.02**2 - ARC**2, 0.0)) - 10.02),
    "nose": nose(5.0, 70.0),
    "wing": (-nose(12.0, 60.0)[0], nose(12.0, 60.0)[1]),
    "concave": (ARC, -(ARC**2) / 60.0),
    "half a circle": (20.0 * np.sin(ARC / 12.8), -20.0 * (1 - np.cos(ARC / 12.8))),
    "narrow": (ARC / 20.0, ARC**2 / 400.0),
}


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("name", UNUSUAL)
def test_rails_of_unusual_shapes_are_taken_as_they_are_told(name, tmp_path):
    """Hollow ones were refused as upside down, or turned; noses were those of a wheel."""
    y, z = UNUSUAL[name]
    np.savetxt(tmp_path / "rail.csv", np.stack([y, z], axis=1), delimiter=",")
    found = Profile.read(tmp_path / "rail.csv", "rail", mirror_z=False)
    order = slice(None) if y[0] < y[-1] else slice(None, None, -1)
    assert found.y == pytest.approx(y[order]) and found.z == pytest.approx(z[order])


# the other way up some look like wheels
@pytest.mark.filterwarnings("ignore::varcontact.wheel_rail.DoubtfulProfile")
@pytest.mark.parametrize("name", UNUSUAL)
def test_mirror_z_turns_what_it_is_told_to(name, tmp_path):
    y, z = UNUSUAL[name]
    np.savetxt(tmp_path / "rail.csv", np.stack([y, z], axis=1), delimiter=",")
    down, up = (Profile.read(tmp_path / "rail.csv", "rail", mirror_z=way) for way in (False, True))
    assert up.z == pytest.approx(-down.z)


@pytest.mark.parametrize("name", ["groove", "concave", "half a circle"])
def test_a_hollow_rail_is_not_turned_by_a_guess_and_doubted(name, tmp_path):
    y, z = UNUSUAL[name]
    np.savetxt(tmp_path / "rail.csv", np.stack([y, z], axis=1), delimiter=",")
    with pytest.warns(
        DoubtfulProfile, match="rail.csv: the rail is hollow, with z down; mirror_z=False says that"
    ):
        assert Profile.read(tmp_path / "rail.csv", "rail").z == pytest.approx(z)


@pytest.mark.parametrize("seed", range(3))
def test_noise_on_a_flanges_back_does_not_hide_the_tread(seed):
    """As measured from the back: its y is 0, and noise of 0.1 mm runs forth and back there.

    The running part was some of that noise, z_at(70) was NaN, or scipy failed.
    """
    back = np.linspace(-22.0, 10.0, 110)
    whole = FINE_WHEEL.y > -69.5
    y = np.concatenate([np.full(back.size, -70.0), FINE_WHEEL.y[whole]]) + 70.0
    z = np.concatenate([back, FINE_WHEEL.z[whole]])
    noise = 0.1 * np.random.default_rng(seed).normal(size=back.size)
    y[: back.size] += noise
    measured = Profile(y=y, z=z, kind="wheel")
    at = np.linspace(15.0, 125.0, 111)
    assert measured.z_at(at) == pytest.approx(FINE_WHEEL.z_at(at - 70.0), abs=1e-6)
    case = on_track(2.0, wheelset=WheelSet(wheel=measured, flange_back=0.0))
    assert case.touching == pytest.approx(
        on_track(2.0, wheelset=WheelSet(wheel=FINE_WHEEL)).touching, abs=1e-6
    )


def test_noise_that_hides_the_flange_is_doubted_until_it_is_smoothed():
    """On a face of 70 degrees noise of 0.1 mm runs back: the part with the tread counts, without
    the flange.
    """
    coarse = Profile.s1002(step=0.3)
    noise = 0.1 * np.random.default_rng(0).normal(size=coarse.y.size)
    measured = Profile(y=coarse.y + noise, z=coarse.z, kind="wheel")
    with pytest.warns(
        DoubtfulProfile, match=r"the wheel touches y = .* alone: .* smooth the profile"
    ):
        assert np.isnan(measured.z_at(-50.0))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert measured.smoothed(5.0).z_at(-50.0) == pytest.approx(coarse.z_at(-50.0), abs=0.2)


def test_the_highest_part_of_a_rail_is_no_noise_of_a_steep_side():
    """A channel whose sides are as high as they are measured: its floor can be touched."""
    rng, side = np.random.default_rng(0), np.linspace(-7.0, 0.0, 30)
    y = np.concatenate([np.full(30, -11.0), np.linspace(-10.5, 10.5, 80), np.full(30, 11.0)])
    z = np.concatenate([side, np.full(80, 0.02), side[::-1]])
    y[:30] += 0.02 * rng.normal(size=30)
    with pytest.warns(DoubtfulProfile, match="upside down"):
        channel = Profile(y=y, z=z, kind="rail")
    assert channel.z_at(np.linspace(-10.0, 10.0, 5)) == pytest.approx(0.02, abs=1e-3)


def test_a_part_that_is_left_out_is_doubted():
    """A guard rail beside a rail, behind an upright side."""
    head, gap, guard = (
        np.linspace(-60.0, 0.0, 121),
        np.linspace(0.5, 40.0, 80),
        np.linspace(40.0, 110.0, 141),
    )
    y = np.concatenate([head, np.zeros(20), gap, guard])
    z = np.concatenate(
        [np.zeros(121), np.linspace(2.0, 40.0, 20), np.full(80, 40.0), np.full(141, -1.0)]
    )
    z[121 + 20 + 80 :] += np.linspace(0.0, 1.0, 141) ** 2
    with pytest.warns(
        DoubtfulProfile,
        match="at y = 40 to 110 mm, not that at -60 to 0 mm, nearly as high: .* cut",
    ):
        beside = Profile(y=y, z=z, kind="rail")
    assert np.isnan(beside.z_at(-30.0)) and np.isfinite(beside.z_at(80.0))


def test_a_rail_that_can_be_touched_nowhere_is_refused():
    z = np.linspace(0.0, 40.0, 41)
    leaning = Profile(y=-z / 20.0, z=z, kind="rail")
    assert leaning.z_at(-1.0) == pytest.approx(20.0)
    track = Track(rail=leaning, cant=0.2)
    refused(lambda: track.placed("right"), "profile.y", "no part of the profile can be touched")


def test_legal_profiles_of_all_shapes_are_taken():
    """One flank of a rail, its crown alone, head with web and foot, a grooved rail; a wheel of two
    flanges.
    """
    half = RAIL.y < 5.0
    crown = np.abs(RAIL.y + 7.5) < 25.0
    for part in (half, crown):
        Profile(y=RAIL.y[part], z=RAIL.z[part], kind="rail")
        Profile(y=-RAIL.y[part], z=RAIL.z[part], kind="rail")
    foot = np.array([[36.5, 40], [10, 52], [8, 120], [12, 140], [75, 160], [75, 172]], float)
    head = np.stack([RAIL.y + 7.5, RAIL.z], axis=1)
    whole = np.concatenate([foot[::-1] * [-1, 1], head, foot])
    Profile(y=whole[:, 0], z=whole[:, 1], kind="rail")
    y = np.linspace(-50.0, 80.0, 261)
    groove = np.where((y > 30) & (y < 66), 30.0, 0.0) * np.sin(np.pi * np.clip((y - 30) / 36, 0, 1))
    Profile(y=-y, z=groove + y**2 / 600, kind="rail")
    flange = 28 * np.exp(-(((y - 15) - 52) ** 2 / 300)) + 28 * np.exp(-(((y - 15) + 52) ** 2 / 300))
    Profile(y=y - 15, z=flange, kind="wheel")


@pytest.mark.parametrize("place", [-20.0, 20.0])
@pytest.mark.parametrize("up", [1, -1])
def test_hollow_and_barrelled_treads_without_a_flange_are_wheels(place, up):
    """Their deepest point is no flange, and a hollow is not upside down."""
    y = np.linspace(-60.0, 60.0, 241)
    tread = Profile(y=y, z=-up * 3 * np.exp(-((y - place) ** 2) / 400), kind="wheel")
    assert tread.curvature_at(place) == pytest.approx(-up * 6 / 400, rel=0.01)


def noisy(profile, seed, size=0.02):
    rng = np.random.default_rng(seed)
    y, z = (
        profile.y + size * rng.normal(size=profile.y.size),
        profile.z + size * rng.normal(size=profile.y.size),
    )
    return Profile(y=y, z=z, kind=profile.kind, smoothing=10.0)


@pytest.mark.long
@pytest.mark.parametrize("seed", [0, 1])
def test_noise_makes_no_kinks(seed):
    """With 0.02 mm of noise on points 0.1 mm apart nine and more were found, which no smoothing
    removed.
    """
    rail, wheel = noisy(FINE_RAIL, seed), noisy(FINE_WHEEL, seed + 10)
    assert rail.kink_points.size == wheel.kink_points.size == 0
    smooth = [
        Profile(y=each.y, z=each.z, kind=each.kind, smoothing=10.0)
        for each in (FINE_RAIL, FINE_WHEEL)
    ]
    peaks = []
    for r, w in ((rail, wheel), smooth):
        case = on_track(
            3.0, track=Track(rail=r, cant=1 / 40), wheelset=WheelSet(wheel=w), dx=0.5, dy=0.25
        )
        peaks.append(case.solve().patches[0].peak_pressure)
    assert peaks[0] == pytest.approx(peaks[1], rel=0.15)


def test_a_kink_is_found_all_the_same():
    y = np.linspace(-30.0, 30.0, 241)
    z = y**2 / 600 + np.maximum(y - 20.0, 0.0)
    rng = np.random.default_rng(1)
    for size in (0.0, 0.002):
        rail = Profile(y=y, z=z + size * rng.normal(size=y.size), kind="rail")
        assert rail.y[rail.kink_points] == pytest.approx([20.0], abs=0.3)


def test_a_wheel_cut_at_the_tip_of_its_flange_tells_which_way_it_lies():
    assert Profile(y=FINE_WHEEL.y[TIP:], z=FINE_WHEEL.z[TIP:], kind="wheel").running.s.size > 100
    with pytest.warns(DoubtfulProfile, match="the wheel's flange is at y = .* mirror_y"):
        Profile(y=-FINE_WHEEL.y[TIP:], z=FINE_WHEEL.z[TIP:], kind="wheel")


def test_cones_and_cylinders_have_no_flange():
    y = np.linspace(-60.0, 60.0, 121)
    for slope in (0.0, 0.1, -0.1):
        Profile(y=y, z=slope * y, kind="wheel")


def test_a_closed_contour_runs_either_way():
    """With web and foot the ends meet, and do not tell which way the points run."""
    below = [[9, 50], [9, 140], [75, 160], [75, 172], [-75, 172], [-75, 160], [-9, 140], [-9, 50]]
    points = np.roll(
        np.concatenate([np.stack([FINE_RAIL.y, FINE_RAIL.z], axis=1), below]), 4, axis=0
    )
    points = np.concatenate([points, points[:1]])
    one, other = (
        Profile(y=each[:, 0], z=each[:, 1], kind="rail") for each in (points, points[::-1])
    )
    assert one.y == pytest.approx(other.y) and one.z == pytest.approx(other.z)
    placed = Track(rail=other).placed("right")
    assert np.ptp(placed.points(placed.s)[:, 0]) > 70.0


def tyre(bottom=-60.0):
    """The closed outline of a tyre without its last point, long straight sides without points."""
    wheel = Profile.s1002(step=0.5)
    below = [[60.0, bottom], [-70.0, bottom]]
    return np.concatenate([np.stack([wheel.y, wheel.z], axis=1), below])


@pytest.mark.parametrize("begin", [0, 30, 60, 150, -1])
@pytest.mark.parametrize("side", [1, -1])
@pytest.mark.parametrize("order", [1, -1])
def test_the_flange_of_a_closed_wheel_is_found(begin, side, order, tmp_path):
    """Wherever the outline begins, on the flange or on the tread too, either way round, with z up
    too.
    """
    around = np.roll(tyre(), -begin, axis=0)
    points = np.concatenate([around, around[:1]])[::order] * [side, 1]
    assert flange(*points.T) == -side
    assert flange(*(points * [1, -1]).T) == 0
    for sign in (1, -1):
        np.savetxt(tmp_path / "tyre.csv", points * [1, sign], delimiter=",")
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            wheel = Profile.read(tmp_path / "tyre.csv", "wheel")
        words = [str(each.message) for each in caught]
        assert len(words) == (sign < 0) and all(
            "the sign of z is changed" in each for each in words
        )
        assert wheel.z_at([-50.0, 0.0, 50.0]) == pytest.approx(
            FINE_WHEEL.z_at([-50.0, 0.0, 50.0]), abs=1e-3
        )
        found = flange_dimensions(wheel)
        expected = flange_dimensions(FINE_WHEEL)
        assert found.height == pytest.approx(expected.height, abs=1e-3)
        assert found.thickness == pytest.approx(expected.thickness, abs=1e-3)
        assert found.qR == pytest.approx(expected.qR, abs=0.01)


def test_closed_rollers_have_no_flange():
    for slope in (0.0, 0.05):
        y = np.linspace(-60.0, 60.0, 121)
        tread = np.stack([y, slope * y], axis=1)
        points = np.concatenate([tread, [[60.0, -80.0], [-60.0, -80.0]], tread[:1]])
        for signs in ([1, 1], [-1, 1], [1, -1]):
            assert flange(*(points * signs).T) == 0


@pytest.mark.parametrize("begin", [0, 100, 300, -1])
def test_a_closed_rail_may_begin_on_its_head(begin):
    below = [[9, 50], [9, 140], [75, 160], [75, 172], [-75, 172], [-75, 160], [-9, 140], [-9, 50]]
    head = np.stack([FINE_RAIL.y, FINE_RAIL.z], axis=1)
    around = np.roll(np.concatenate([head, below]), -begin, axis=0)
    rail = Profile(y=[*around[:, 0], around[0, 0]], z=[*around[:, 1], around[0, 1]], kind="rail")
    at = np.linspace(-30.0, 30.0, 13)
    assert rail.z_at(at) == pytest.approx(FINE_RAIL.z_at(at), abs=1e-4)


LOOP = np.array(
    [[-5, 3], [-4, 2], [-3, 1], [0, 0], [4, 1], [4, -2], [1, -2], [1, 3], [5, 4], [6, 5], [7, 6]],
    float,
)


@pytest.mark.parametrize(("more", "field", "words"), [
    ({"y": [0.0, 1.0, 2.0], "z": [0.0, 1.0, 2.0]}, "profile", "3 different points; it needs 10"),
    ({"y": np.arange(20.0), "z": np.arange(19.0)}, "profile.z", "as long as profile.y, 20 numbers"),
    ({"y": [0.0, np.nan], "z": [0.0, 1.0]}, "profile.y[1]", "finite"),
    ({"y": LOOP[:, 0], "z": LOOP[:, 1]}, "profile", "itself near y = 2, z = 0.5 mm"),
    ({"smoothing": 0.1}, "profile.smoothing", r"at least the points' spacing, 0.\d+ mm"),
    ({"kinks": "none"}, "profile.kinks", '"auto"'),
    ({"kinks": [3.0, 300.0]}, "profile.kinks", "within the profile"),
    ({"y": RAIL.y / 1000, "z": RAIL.z / 1000}, "profile.y", "0.0743 mm wide: .* scale=1000"),
    ({"y": [*RAIL.y] * 2, "z": [*RAIL.z] * 2}, "profile", "must be ordered"),
    ({"kind": "tram"}, "profile.kind", "did you mean rail"),
])  # fmt: skip
def test_bad_profiles_are_refused(more, field, words):
    refused(
        lambda: Profile(**{"y": RAIL.y, "z": RAIL.z, "kind": "rail"} | more), field, match=words
    )


def test_entries_by_position_are_refused_in_words():
    refused(
        lambda: Profile(RAIL.y, RAIL.z, "rail"),
        match=r"by name: write Profile\(y=..., z=..., kind=...\)",
    )
    refused(lambda: Track(RAIL), match=r"Track takes its entries by name: write Track\(rail=...\)")


@pytest.mark.long
def test_segments_that_cross_are_found_as_one_by_one() -> None:
    """Of random lines, with points on a lattice in a third of them; and at once for 50 000
    points.
    """

    def by_hand(points: np.ndarray) -> set[int]:
        found = set()
        for i, j in itertools.combinations(range(len(points) - 1), 2):
            a, b, c, d = points[i], points[i + 1], points[j], points[j + 1]
            sides = [
                np.linalg.det([q - p, r - p])
                for p, q, r in ((a, b, c), (a, b, d), (c, d, a), (c, d, b))
            ]
            if j > i + 1 and sides[0] * sides[1] < -1e-12 and sides[2] * sides[3] < -1e-12:
                found.add(i)
        return found

    rng = np.random.default_rng(5)
    for k in range(60):
        points = np.cumsum(rng.normal(size=(20, 2)), axis=0)
        points = points.round() if k % 3 == 0 else points
        points = points[np.append(True, np.abs(np.diff(points, axis=0)).sum(axis=1) > 0)]
        assert set(crossed(points[:-1], points[1:]).tolist()) == by_hand(points)
    y = np.linspace(-35.0, 35.0, 50_000)
    assert Profile(y=y, z=y**2 / 600, kind="rail").y.size == y.size


@pytest.mark.parametrize("profile", [Profile.rail_60e1(), Profile.s1002()], ids=["rail", "wheel"])
@pytest.mark.parametrize(("first", "second"), [(1, 1), (1, -1), (-1, 1), (-1, -1)])
def test_exchanged_columns_are_doubted(profile, first, second):
    with pytest.warns(DoubtfulProfile, match=f"the {profile.kind}'s y and z look exchanged"):
        Profile(y=first * profile.z, z=second * profile.y, kind=profile.kind)
