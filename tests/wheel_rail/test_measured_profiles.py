"""Profiles as they are measured: with noise, cut at the flange's tip, with web and foot, with signs of a typesetter."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tests.wheel_rail.conditions import TRACK, WHEELSET
from varcontact.errors import SceneError
from varcontact.wheel_rail import Position, Profile, Track, Velocity, WheelOnRail, WheelSet, equivalent_conicity

RAIL, WHEEL = Profile.rail_60e1(step=0.1), Profile.s1002(step=0.1)
TIP = int(WHEEL.z.argmax())


def noisy(profile, seed, size=0.02):
    rng = np.random.default_rng(seed)
    y, z = profile.y + size * rng.normal(size=profile.y.size), profile.z + size * rng.normal(size=profile.y.size)
    return Profile(y=y, z=z, kind=profile.kind, smoothing=10.0)


@pytest.mark.parametrize("seed", [0, 1, 2, 3])
def test_noise_makes_no_kinks(seed):
    """With 0.02 mm of noise on points 0.1 mm apart nine and more were found, which no smoothing removed."""
    rail, wheel = noisy(RAIL, seed), noisy(WHEEL, seed + 10)
    assert rail.kink_points.size == wheel.kink_points.size == 0
    smooth = [Profile(y=each.y, z=each.z, kind=each.kind, smoothing=10.0) for each in (RAIL, WHEEL)]
    peaks = []
    for r, w in ((rail, wheel), smooth):
        case = WheelOnRail(
            track=Track(rail=r, cant=1 / 40), wheelset=WheelSet(wheel=w), z=0.0, position=Position(y=3.0)
        )
        peaks.append(replace(case, z=None, vertical_force=80e3).solve().patches[0].solution.pressure.max())
    assert peaks[0] == pytest.approx(peaks[1], rel=0.15)


def test_a_kink_is_found_all_the_same():
    y = np.linspace(-30.0, 30.0, 241)
    z = y**2 / 600 + np.maximum(y - 20.0, 0.0)
    rng = np.random.default_rng(1)
    for size in (0.0, 0.002):
        rail = Profile(y=y, z=z + size * rng.normal(size=y.size), kind="rail")
        assert rail.y[rail.kink_points] == pytest.approx([20.0], abs=0.3)


@pytest.mark.parametrize(("y", "z", "message"), [
    (1.0, -1.0, "the wheel's profile is upside down .* mirror_z=True"),
    (-1.0, 1.0, "the wheel's flange is at y = .* mirror_y=True"),
])  # fmt: skip
def test_a_wheel_cut_at_the_tip_of_its_flange_tells_which_way_it_lies(y, z, message):
    assert Profile(y=WHEEL.y[TIP:], z=WHEEL.z[TIP:], kind="wheel").running.s.size > 100
    with pytest.raises(SceneError, match=message):
        Profile(y=y * WHEEL.y[TIP:], z=z * WHEEL.z[TIP:], kind="wheel")


def test_cones_and_cylinders_have_no_flange():
    y = np.linspace(-60.0, 60.0, 121)
    for slope in (0.0, 0.1, -0.1):
        Profile(y=y, z=slope * y, kind="wheel")


def test_a_closed_contour_runs_either_way():
    """With web and foot the ends meet, and do not tell which way the points run."""
    below = [[9, 50], [9, 140], [75, 160], [75, 172], [-75, 172], [-75, 160], [-9, 140], [-9, 50]]
    points = np.roll(np.concatenate([np.stack([RAIL.y, RAIL.z], axis=1), below]), 4, axis=0)
    points = np.concatenate([points, points[:1]])
    one, other = (Profile(y=each[:, 0], z=each[:, 1], kind="rail") for each in (points, points[::-1]))
    assert one.y == pytest.approx(other.y) and one.z == pytest.approx(other.z)
    placed = Track(rail=other).placed("right")
    assert np.ptp(placed.points(placed.s)[:, 0]) > 70.0


def test_a_minus_of_a_typesetter_is_a_minus(tmp_path):
    lines = [f"{y:.3f}\t{z:.4f}".replace("-", "\N{MINUS SIGN}") for y, z in zip(RAIL.y, RAIL.z, strict=True)]
    (tmp_path / "rail.txt").write_text("\n".join(lines), encoding="utf-8")
    assert Profile.read(tmp_path / "rail.txt", "rail").y == pytest.approx(RAIL.y, abs=1e-3)


@pytest.mark.parametrize(("make", "message"), [
    (lambda: Velocity(speed=20e3, pitch_rate=43.0), "velocity.pitch_rate = 43.0 .* negative in rolling forward"),
    (lambda: Profile.s1002(step=0.0), "step = 0.0"),
    (
        lambda: WheelSet(wheel=Profile(y=WHEEL.y + 70.0, z=WHEEL.z, kind="wheel")),
        "wheelset.flange_back = -70 mm, but the tip of the wheel's flange is at y = 1",
    ),
    (lambda: Profile.s1002(step=-1.0), "step = -1.0"),
    (lambda: Profile.rail_60e1(step="a"), "step = 'a'"),
    (lambda: Profile.rail_60e1(step=float("nan")), "step = nan"),
])  # fmt: skip
def test_bad_input_is_refused(make, message):
    with pytest.raises(SceneError, match=message):
        make()


def test_a_locked_wheel_slides_and_no_amplitude_has_no_conicity():
    case = WheelOnRail(track=TRACK, wheelset=WHEELSET, z=0.0, velocity=Velocity(speed=1e3, pitch_rate=0.0))
    (patch,) = case.patches(case.touching + 0.05)
    assert patch.creepage.vx == pytest.approx(-2.0, rel=1e-3)
    assert equivalent_conicity(TRACK, WHEELSET, []).shape == (0,)
