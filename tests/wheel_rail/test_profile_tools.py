"""Tools for measured profiles: rigid motions, alignment, outliers, dimensions, files."""

import warnings
from dataclasses import replace

import numpy as np
import pytest

from tests.scenes import refused
from tests.wheel_rail.conditions import round_rail
from varcontact.errors import OutputError
from varcontact.wheel_rail import (
    Profile,
    Track,
    WheelSet,
    flange_clearance,
    flange_dimensions,
    rail_wear,
)

RAIL = Profile.rail_60e1()
WHEEL = Profile.s1002()
ENDINGS = {"rail": (".csv", ".txt", ".prr", ".ban"), "wheel": (".csv", ".txt", ".prw", ".whl")}


def points(profile):
    return np.stack([profile.y, profile.z])


def with_outliers(profile, places, height):
    z = profile.z.copy()
    z[places] += height
    return replace(profile, z=z)


def test_a_rotation_keeps_distances_and_turns_angles():
    turned = RAIL.rotated(0.1, about=(3.0, 5.0))
    assert np.hypot(turned.y - 3, turned.z - 5) == pytest.approx(np.hypot(RAIL.y - 3, RAIL.z - 5))
    arc = round_rail()
    inclination = arc.rotated(0.05).curve.angles(arc.rotated(0.05).curve.s)
    assert inclination == pytest.approx(arc.curve.angles(arc.curve.s) + 0.05, abs=1e-9)
    assert points(RAIL.rotated(0.1).rotated(-0.1)) == pytest.approx(points(RAIL), abs=1e-12)


def test_motions_take_kinks_along():
    y = np.linspace(-10.0, 10.0, 41)
    roof = Profile(y=y, z=np.abs(y), kind="rail", kinks=[0.0])
    moved = roof.rotated(0.3).shifted(y=40.0, z=-3.0)
    assert moved.kink_points.tolist() == roof.kink_points.tolist() == [20]
    finer = moved.resampled(0.1)
    assert finer.y[finer.kink_points] == pytest.approx([40.0])
    assert finer.z[finer.kink_points] == pytest.approx([-3.0])


@pytest.mark.parametrize("profile", [RAIL, WHEEL], ids=["rail", "wheel"])
def test_alignment_undoes_a_motion(profile):
    moved = profile.rotated(0.03).shifted(y=2.0, z=-1.5)
    assert points(moved.aligned(profile)) == pytest.approx(points(profile), abs=1e-9)
    shifted = profile.shifted(y=1.0, z=0.5).aligned(profile, rotate=False)
    assert points(shifted) == pytest.approx(points(profile), abs=1e-9)


def test_alignment_over_the_unworn_part_leaves_the_wear():
    """A head worn by up to 2 mm on its gauge side, measured out of place: the field side fits."""
    side = np.clip((10.0 - RAIL.y) / 20.0, 0.0, 1.0)
    worn = replace(RAIL, y=RAIL.y + 0.0, z=RAIL.z + 2.0 * side**2 * (RAIL.z < 5.0))
    measured = worn.rotated(0.02).shifted(y=3.0, z=1.0)
    again = measured.aligned(RAIL, over=(12.0, 37.0))
    assert points(again) == pytest.approx(points(worn), abs=1e-6)
    everywhere = measured.aligned(RAIL)
    assert np.abs(points(everywhere) - points(worn)).max() > 0.1


def test_distances_are_the_depth_of_wear_of_both_bodies():
    inside = round_rail(radius=299.0, half=30.0).shifted(z=1.0)
    assert inside.distances(round_rail()) == pytest.approx(1.0, abs=1e-5)
    inner = (WHEEL.y > -40.0) & (WHEEL.y < 50.0)
    lost = WHEEL.shifted(z=-0.5).distances(WHEEL)[inner]
    normal = 0.5 * np.cos(np.arctan(np.gradient(WHEEL.z, WHEEL.y)))[inner]
    tread = WHEEL.y[inner] > 0.0
    assert lost[tread] == pytest.approx(normal[tread], abs=2e-3)


@pytest.mark.parametrize("profile", [RAIL, WHEEL], ids=["rail", "wheel"])
def test_designed_profiles_have_no_outliers(profile):
    assert profile.outliers().size == 0
    assert profile.resampled(1.0).outliers().size == 0


@pytest.mark.long
def test_outliers_are_found_alone_and_beside_each_other_in_noise():
    generator = np.random.default_rng(0)
    noisy = replace(RAIL, z=RAIL.z + 2e-3 * generator.normal(size=RAIL.z.size))
    places = np.array([150, 200, 201, 202, 333, 400])
    dirty = with_outliers(noisy, places, 0.15)
    assert dirty.outliers().tolist() == places.tolist()
    clean = dirty.without_outliers()
    assert points(clean) == pytest.approx(np.delete(points(noisy), places, axis=1))
    assert dirty.outliers(distance=1.0).size == 0
    labels = dirty.plot().axes[0].get_legend_handles_labels()[1]
    assert "outliers (6)" in labels


def test_resampling_keeps_the_curve():
    finer = RAIL.resampled(0.1)
    assert np.hypot(*np.diff(points(finer))) == pytest.approx(0.1, rel=2e-3)
    assert finer.z_at(np.linspace(-30.0, 30.0, 61)) == pytest.approx(
        RAIL.z_at(np.linspace(-30.0, 30.0, 61)), abs=1e-6
    )


def test_trimming_leaves_one_piece():
    head = RAIL.trimmed(z=(0.0, 14.0), y=(-100.0, 20.0))
    assert head.z.max() <= 14.0 and head.y.max() <= 20.0
    refused(lambda: RAIL.trimmed(z=(5.0, 20.0)), "y, z")
    refused(lambda: RAIL.trimmed(y=(0.0, 1.0)), "profile")


def test_flange_of_s1002_and_its_wear():
    """EN 13715: Sh 28, Sd 32.5, qR 10.8 mm; a flange thinner by 2 mm, and a tread 1 mm lower."""
    flange = flange_dimensions(WHEEL)
    assert flange.height == pytest.approx(28.0, abs=1e-3)
    assert flange.thickness == pytest.approx(32.5, abs=1e-3)
    assert flange.qR == pytest.approx(10.794, abs=2e-3)
    moved = flange_dimensions(WHEEL.shifted(y=70.0), back=0.0, running_circle=70.0)
    assert moved.thickness == pytest.approx(flange.thickness, abs=1e-6)
    worn = replace(WHEEL, y=WHEEL.y - 2.0 * ((WHEEL.y > -57.5) & (WHEEL.y < -25.0)))
    assert flange_dimensions(worn).thickness == pytest.approx(30.5, abs=0.01)
    assert flange_dimensions(worn).height == pytest.approx(28.0, abs=1e-3)


def test_rail_wear_of_known_changes():
    lower = rail_wear(RAIL.shifted(z=1.0), RAIL)
    assert lower.vertical == pytest.approx(1.0, abs=1e-6)
    assert lower.at_45 == pytest.approx(1.0 / np.sqrt(2.0), abs=0.03)
    narrower = rail_wear(RAIL.shifted(y=0.5), RAIL)
    assert narrower.side == pytest.approx(0.5, abs=1e-6)
    assert narrower.vertical == pytest.approx(0.5**2 / 600.0, abs=1e-5)
    assert rail_wear(RAIL, RAIL).area == 0.0
    inside = round_rail(radius=299.0, half=60.0).shifted(z=1.0)
    outside = round_rail(half=60.0)
    refused(lambda: rail_wear(inside, outside), "nominal")  # no corner of 45 degrees
    # an arc inside another: the area between them above a chord
    whole = round_rail(radius=50.0, half=49.0)
    within = round_rail(radius=49.0, half=48.0).shifted(z=1.0)
    worn = rail_wear(within, whole, gauge_height=30.0)
    segments = [r**2 * np.arccos(20.0 / r) - 20.0 * np.sqrt(r**2 - 20.0**2) for r in (50.0, 49.0)]
    assert worn.area == pytest.approx(segments[0] - segments[1], rel=1e-4)
    assert worn.at_45 == pytest.approx(1.0, abs=1e-4)


def test_clearance_follows_gauge_and_flanges():
    play = flange_clearance(Track(rail=RAIL, gauge=1440.0), WheelSet(wheel=WHEEL))
    assert play.over_flanges == pytest.approx(1360.0 + 65.0, abs=1e-3)
    assert play.clearance == pytest.approx(7.5, abs=1e-3)


@pytest.mark.parametrize("kind", ["rail", "wheel"])
def test_files_come_back_without_a_word(kind, tmp_path):
    profile = {"rail": RAIL, "wheel": WHEEL}[kind].rotated(0.025)
    for ending in ENDINGS[kind]:
        path = tmp_path / f"profile{ending}"
        profile.save(path)
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            again = Profile.read(path, kind)
        assert points(again) == pytest.approx(points(profile), abs=1e-8), ending
    other = {"rail": ".prw", "wheel": ".ban"}[kind]
    with pytest.raises(OutputError, match="the name must end in"):
        profile.save(tmp_path / f"profile{other}")


def test_miniprofs_rails_have_z_up(tmp_path):
    RAIL.save(tmp_path / "rail.ban")
    last = (tmp_path / "rail.ban").read_text().splitlines()[-1]
    assert float(last.split()[1]) == pytest.approx(-RAIL.z[-1])


@pytest.mark.parametrize(
    ("call", "field"),
    [
        (lambda: RAIL.shifted(y=np.nan), "y"),
        (lambda: RAIL.rotated("much"), "angle"),
        (lambda: RAIL.rotated(0.1, about=(1.0,)), "about"),
        (lambda: RAIL.aligned(WHEEL), "to"),
        (lambda: RAIL.aligned(RAIL.shifted(y=200.0)), "to"),
        (lambda: RAIL.aligned(RAIL, over=(100.0, 200.0)), "over"),
        (lambda: RAIL.aligned(RAIL, over=(20.0, 10.0)), "over"),
        (lambda: RAIL.resampled(0.0), "step"),
        (lambda: RAIL.outliers(distance=-1.0), "distance"),
        (lambda: flange_dimensions(RAIL), "wheel"),
        (lambda: flange_dimensions(WHEEL.trimmed(y=(-20.0, 60.0))), "wheel"),
        (lambda: flange_dimensions(WHEEL, above=50.0), "above"),
        (lambda: rail_wear(RAIL.shifted(y=100.0), RAIL), "worn"),
        (lambda: rail_wear(RAIL, RAIL, gauge_height=100.0), "gauge_height"),
    ],
)
def test_bad_input_is_named(call, field):
    refused(call, field)
