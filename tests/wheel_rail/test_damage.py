"""Damage: laws of wear, full slip, energy, the shakedown diagram, worn profiles, and wear that
makes profiles fit.
"""

from dataclasses import replace

import numpy as np
import pytest

import varcontact as vc
from tests.scenes import refusals
from tests.wheel_rail.conditions import circles, wheel
from varcontact.errors import SceneError
from varcontact.wheel_rail import (
    Archard,
    ArchardMap,
    Profile,
    Velocity,
    british_rail_wear,
    fatigue_damage,
    shakedown,
    sheffield_wear,
    wear,
    wear_down,
    worn_profile,
)

pytestmark = pytest.mark.filterwarnings("ignore")  # elements are few to be fast
LAW = Archard(k=3e-4, hardness=3000.0)


@pytest.fixture(scope="module")
def right():
    """A right wheel on tread and gauge corner."""
    return wheel(5.0, yaw=0.004, dx=0.5, dy=0.5).solve()


@pytest.fixture(scope="module")
def rolling():
    return wheel(2.0, yaw=0.002, dx=0.5, dy=0.5).solve()


@pytest.fixture(scope="module")
def left(right):
    """Its mirror image."""
    place = replace(right.case.position, y=-5.0, yaw=-0.004)
    return replace(right.case, side="left", position=place).solve()


def removed(before, after):
    """Area between two profiles of the same points."""
    ring = [np.concatenate([getattr(before, name), getattr(after, name)[::-1]]) for name in "yz"]
    return abs(float(np.sum(ring[0] * np.roll(ring[1], -1) - ring[1] * np.roll(ring[0], -1)))) / 2


@pytest.mark.parametrize("kind", ["rail", "wheel"])
@pytest.mark.parametrize("smoothing", [0.0, 3.0])
def test_the_area_that_is_worn_off_is_the_volume_by_distance(right, left, kind, smoothing):
    before = right.case.track.rail if kind == "rail" else right.case.wheelset.wheel
    found = worn_profile([right], LAW, kind, passages=2e4, smoothing=smoothing)
    assert removed(before, found) == pytest.approx(2e4 * wear(right, LAW).volume, rel=0.02)
    assert (
        (found.z - before.z).min() >= -1e-12
        if kind == "rail"
        else (found.z - before.z).max() <= 1e-12
    )
    mirrored = worn_profile([left], LAW, kind, passages=2e4, smoothing=smoothing)
    assert mirrored.z == pytest.approx(found.z, abs=1e-5)
    both = worn_profile([left, right], LAW, kind, passages=2e4, smoothing=smoothing)
    assert removed(before, both) == pytest.approx(2 * removed(before, found), rel=5e-3)


def test_a_map_of_one_coefficient_is_archards_law(right):
    alike = ArchardMap(hardness=3000.0, velocities=(100.0,), k=(3e-4, 3e-4), k_seizure=3e-4)
    one, other = wear(right, LAW), wear(right, alike)
    assert other.volume == pytest.approx(one.volume, rel=1e-12)
    slow, fast = (replace(alike, k=(1e-4, 3e-4), velocities=(each,)) for each in (1e-3, 1e9))
    assert wear(right, slow).volume == pytest.approx(one.volume, rel=1e-2)
    assert wear(right, fast).volume == pytest.approx(one.volume / 3, rel=1e-12)


@pytest.mark.long
def test_a_locked_wheel_in_closed_form():
    """Creepage -2: power f N V at the speed V over the rail; the depth k/H p0 (pi/2) a in the
    middle.
    """
    sliding = circles(velocity=Velocity(speed=5000.0, pitch_rate=0.0), dx=0.25, dy=0.25).solve()
    (worn,) = wear(sliding, LAW).patches
    (each,) = sliding.patches
    rolled = each.patch.creepage
    assert abs(rolled.vx) * rolled.speed == pytest.approx(5000.0, rel=1e-6)
    assert worn.power == pytest.approx(0.3 * 80e3 * 5.0, rel=1e-4)
    hertz = vc.reference.hertz(460.0, 1 / (1 / 300 + 1 / 500), sliding.case.bodies, force=80e3)
    middle = 1e-7 * abs(rolled.vx) * hertz.peak_pressure * np.pi / 2 * hertz.a
    assert worn.depth.max() == pytest.approx(middle, rel=0.01)
    assert worn.volume == pytest.approx(1e-7 * abs(rolled.vx) * 80e3, rel=0.005)
    assert worn.area == pytest.approx(np.pi * hertz.a * hertz.b, rel=0.02)
    assert worn.power_by_area.max() == pytest.approx(0.3 * hertz.peak_pressure * 5.0, rel=0.01)


def test_energy_is_counted_twice(rolling):
    """By Coulomb's law f times pressure times slip is the work of friction; that is what motion
    puts in.
    """
    (worn,) = wear(rolling, LAW).patches
    (each,) = rolling.patches
    assert worn.volume == pytest.approx(1e-7 * worn.t_gamma / 0.3, rel=1e-11)
    assert worn.power_by_area.sum() * 0.25 == pytest.approx(worn.power, rel=1e-11)
    assert worn.depth.min() > -1e-3 * worn.depth.max()
    assert worn.depth.sum() * 0.5 == pytest.approx(worn.volume, rel=1e-12)
    assert worn.t_gamma == pytest.approx(each.solution.friction_work, rel=1e-12)
    assert worn.t_gamma - worn.t_gamma_without_spin == pytest.approx(
        -each.moment * each.patch.creepage.spin
    )
    assert worn.t_gamma_by_area == pytest.approx(worn.t_gamma / worn.area)
    assert wear(rolling).t_gamma == pytest.approx(worn.t_gamma)


def test_the_power_grows_with_the_speed_and_the_wear_by_distance_does_not(rolling):
    faster = replace(rolling.case, velocity=Velocity(speed=3000.0)).solve()
    one, other = wear(rolling, LAW), wear(faster, LAW)
    assert other.power == pytest.approx(3 * one.power, rel=1e-6)
    assert other.volume == pytest.approx(one.volume, rel=1e-6)


def test_functions_of_t_gamma():
    """Where their pieces meet: continuous but for British Rail's step to catastrophic wear."""
    assert sheffield_wear(77.2 - 1e-9) == pytest.approx(float(sheffield_wear(77.2)), rel=1e-6)
    assert british_rail_wear(100 - 1e-9, 900.0) == pytest.approx(
        float(british_rail_wear(100.0, 900.0)), rel=1e-6
    )
    assert british_rail_wear(200.0, 900.0) * 900 == pytest.approx(84.0)
    assert fatigue_damage([15.0, 65.0, 175.0]) == pytest.approx([0.0, 10.0, 0.0])
    with pytest.raises(SceneError, match="zero or positive"):
        sheffield_wear([-1.0])


@pytest.mark.long
def test_shakedown_of_circles():
    """Hertz: index = f - 2 pi a b k/(3 Fz), sliding all over with a friction of 0.3."""
    case = circles(300.0, dx=0.25, dy=0.25)
    found = replace(case, velocity=replace(case.velocity, pitch_rate=-1.0)).solve()
    (each,) = found.patches
    hertz = vc.reference.hertz(460.0, 1 / (1 / 300 + 1 / 500), case.bodies, force=each.normal_force)
    place = shakedown(each, 300.0)
    assert place.utilised == pytest.approx(0.3, rel=1e-4)
    exact = 0.3 - 2 * np.pi * hertz.a * hertz.b * 300.0 / (3 * each.normal_force)
    assert place.index == pytest.approx(exact, abs=2e-3)
    assert np.isnan(place.index_error)


@pytest.mark.long
def test_the_shakedown_index_has_the_error_of_the_peak_pressure():
    """Two patches, of which the narrow one has the larger: within its error it is that of fine
    elements.
    """
    case = wheel(5.0, vertical_force=10e3, separate=4.0, turn=4.0)
    found, fine = case.solve(accuracy=0.05), replace(case, dx=0.1, dy=0.05).solve()
    for own, exact in zip(found.patches, fine.patches, strict=True):
        place, best = shakedown(own, 300.0), shakedown(exact, 300.0)
        peak = own.peak_pressure_error / own.peak_pressure / place.load_factor
        assert place.index_error == pytest.approx(place.utilised_error + peak, rel=1e-12)
        assert abs(place.index - best.index) < place.index_error


@pytest.mark.long
def test_wear_step_by_step_makes_the_profiles_fit(tmp_path):
    case = circles(80.0, yaw=4e-3, dx=1.0, dy=0.5)
    cases = [replace(case, position=replace(case.position, y=y)) for y in (-1.0, 1.0)]
    worn = wear_down(cases, Archard(k=1e-3, hardness=3000.0), "rail", passages=1e3, steps=3)
    assert len(worn) == 3
    depth = [float(np.max(each.z - cases[0].track.rail.z)) for each in worn]
    assert 0.015 < depth[0] < depth[1] < depth[2]
    last = [
        replace(case, track=replace(case.track, rail=worn[-1])).solve().patches[0] for case in cases
    ]
    assert (
        max(each.peak_pressure for each in last) < 0.9 * cases[0].solve().patches[0].peak_pressure
    )
    worn[-1].save(tmp_path / "worn.csv")
    again = Profile.read(tmp_path / "worn.csv", "rail")
    assert again.z == pytest.approx(worn[-1].z, abs=1e-8)


test_what_is_refused = refusals(
    (lambda one: worn_profile([one, replace(one, case=circles())], LAW, "rail"), "found"),
    (lambda one: worn_profile(one, LAW, "rail"), "found"),
    (lambda one: worn_profile([one.case.estimate()], LAW, "rail"), "found[0]"),
    (lambda one: worn_profile([one], LAW, "rail", smoothing=-1.0), "smoothing"),
    (lambda one: worn_profile([one], 3.0, "rail"), "archard"),
    (lambda one: wear_down(one.case, LAW, "rail", passages=1.0), "cases"),
    (lambda one: wear_down([one], LAW, "rail", passages=1.0), "cases[0]"),
    (lambda one: shakedown(one, 300.0), "solved"),
    (lambda _: ArchardMap(velocities=(700.0, 200.0)), "wear.velocities"),
    (lambda _: ArchardMap().coefficient("a", 1.0), "pressure"),
    (lambda _: ArchardMap().coefficient(1e3, [2.0, -1.0]), "slip_velocity"),
    (lambda _: sheffield_wear(1.0, pieces="ab"), "pieces"),
    (lambda _: british_rail_wear(1.0, 900.0, pieces=[(0.0, 1.0, 0.0), (0.0, 2.0, 0.0)]), "pieces"),
    (lambda _: fatigue_damage(1.0, course=3), "course"),
    (lambda _: fatigue_damage([1.0, float("nan")]), "t_gamma[1]"),
    by="field",
    fixture="right",
)
test_wear_that_is_refused = refusals(
    (lambda one: wear(one).patches[0].depth, "archard is missing for depth and volume"),
    (lambda _: Archard(k=-1.0, hardness=3000.0), r"wear\.k = -1"),
    (lambda one: wear(one, 0.1), r"archard = 0\.1 is not allowed: must be an Archard"),
    (lambda one: wear(one.patches[0]), "must be a WheelRailSolution"),
    fixture="right",
)


def test_functions_of_t_gamma_take_other_numbers():
    """The first pieces alone go on as lines through 0."""
    assert british_rail_wear(400.0, 920.0, pieces=[(0.0, 0.25, 0.0)]) == pytest.approx(
        0.25 * 400 / 920
    )
    assert sheffield_wear(
        [1.0, 100.0], pieces=[(0.0, 2.0, 0.0), (50.0, 0.0, 7.0)]
    ) == pytest.approx([2.0, 7.0])
    assert fatigue_damage([5.0, 20.0], course=([0.0, 10.0], [0.0, 1.0])) == pytest.approx(
        [0.5, 2.0]
    )


@pytest.mark.long
def test_error_bars_of_damage():
    """They hold what a finer grid finds."""
    found, finer = (
        wheel(3.0, yaw=0.004).solve(accuracy=0.02),
        wheel(3.0, yaw=0.004, dx=0.15, dy=0.15).solve(),
    )
    (one,), (other,) = wear(found).patches, wear(finer).patches
    assert 0 < abs(one.t_gamma - other.t_gamma) < 1.5 * one.t_gamma_error < 0.05 * one.t_gamma
    places = [shakedown(each.patches[0], 300.0) for each in (found, finer)]
    assert abs(places[0].utilised - places[1].utilised) < 1.5 * places[0].utilised_error


@pytest.fixture(scope="module")
def patch():
    return circles(y=2.0, dx=1.0, dy=1.0).solve().patches[0]


@pytest.mark.long
def test_bodies_of_a_patch_are_the_rail_and_the_wheel(patch):
    """The rail is body 1, z points into it; both have the same pressure, so unlike tensions by
    friction alone.
    """
    for depth, (number, name, of_scene) in zip(
        (1.5, -1.5), ((1, "rail", "upper"), (2, "wheel", "lower")), strict=True
    ):
        by_name = vc.stress(patch, [0.0, 0.0, depth], body=name)
        for solved, body in ((patch, number), (patch.solution, of_scene)):
            np.testing.assert_array_equal(
                vc.stress(solved, [0.0, 0.0, depth], body=body).stress, by_name.stress
            )
        below = vc.stress_below(patch, [1.5], body=name)
        np.testing.assert_array_equal(
            below.stress, vc.stress_below(patch.solution, [1.5], body=of_scene).stress
        )
        (axes, *_) = vc.plot_stress(patch, plane="xy", depth=1.5, body=name).axes
        assert f"{depth:g}" in axes.get_title()
    assert "down into the rail" in vc.plot_stress(patch).axes[0].get_ylabel()


test_other_names_of_bodies_are_refused = refusals(
    (lambda patch: vc.stress(patch, [0, 0, 1], body="upper"), r"body = 'upper' is not allowed"),
    (lambda patch: vc.stress_below(patch, [1], body="lower"), 'one of 1 or "rail", 2 or "wheel"'),
    (lambda patch: vc.stress(patch, [0, 0, 1], body="wheel"), r"in the wheel, z <= 0"),
    (
        lambda patch: vc.plot_stress(patch.solution, body="rail"),
        'or "lower"; "rail" is one of a patch of a wheel',
    ),
    (
        lambda patch: vc.stress_below(patch.solution, [1], body="wheel"),
        "give the patch, not its solution",
    ),
    fixture="patch",
)
