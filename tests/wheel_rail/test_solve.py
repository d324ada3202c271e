"""Wheels solved to an accuracy, within a time, and by theories: errors, loads, and what is
refused.
"""

import warnings
from dataclasses import replace

import numpy as np
import pytest

from tests.scenes import refusals
from tests.wheel_rail import conditions
from tests.wheel_rail.conditions import circles
from varcontact import creep_forces, reference
from varcontact.errors import SceneError
from varcontact.results.error_estimate import with_bar
from varcontact.scene.bodies import Bodies
from varcontact.scene.grid import Grid
from varcontact.scene.surfaces import SampledDistance
from varcontact.wheel_rail import (
    FrictionByAngle,
    RoughProfile,
    Velocity,
    WheelSetOnTrack,
    wheel_geometry,
)
from varcontact.wheel_rail.wheel_on_elements import WheelOnElements

pytestmark = [
    pytest.mark.filterwarnings("ignore::varcontact.wheel_rail.CoarseElements"),
    pytest.mark.filterwarnings("ignore::varcontact.wheel_rail.ConformalContact"),
    pytest.mark.filterwarnings("ignore:normal forces of"),
]


def wheel(y, yaw=0.005, **more):
    return conditions.wheel(y, yaw=yaw, **{"vertical_force": 60e3} | more)


@pytest.mark.long
@pytest.mark.parametrize(("y", "patches"), [(-8.0, 1), (5.0, 2)])
def test_errors_hold_against_fine_elements(y, patches):
    """The other side, and two patches: elements of 0.2 by 0.1 mm."""
    case = wheel(y, vertical_force=10e3, separate=4.0, turn=4.0)
    found = case.solve(accuracy=0.02)
    assert len(found.patches) == patches
    assert found.force[2] == pytest.approx(10e3, rel=1e-6)
    assert found.error[2] == 0
    fine = replace(case, dx=0.2, dy=0.1).solve()
    for each, exact in zip(found.patches, fine.patches, strict=True):
        limit = 0.3 * exact.normal_force
        assert np.all(np.abs(each.force - exact.force) < each.error + 1e-3 * limit)
        assert np.all(each.error[:2] < 0.02 * limit)
    assert found.z == pytest.approx(fine.z, abs=0.01 * found.patches[0].patch.approach)


@pytest.mark.long
def test_hertz_contact_to_an_accuracy():
    """Of a prescribed height, normal forces are within their errors; those of one patch under a
    load follow from it.
    """
    held = circles(with_friction=False).solve(accuracy=0.02)
    (each,) = held.patches
    assert each.error[2] == 0
    high = replace(held.case, vertical_force=None, z=held.z).solve(accuracy=0.02)
    (other,) = high.patches
    hertz = reference.hertz(
        460.0, 1 / (1 / 300 + 1 / 500), held.case.bodies, approach=high.z - held.case.touching
    )
    assert 0 < abs(other.normal_force - hertz.force) < other.error[2] < 0.02 * hertz.force


@pytest.mark.long
@pytest.mark.parametrize("friction", [0.0, 0.3])
def test_unlike_bodies_and_no_friction_to_an_accuracy(friction):
    soft = wheel(
        2.0, vertical_force=20e3, bodies=Bodies(G=(40e3, 82e3), nu=(0.35, 0.28)), friction=friction
    )
    found = soft.solve(accuracy=0.05)
    assert found.force[2] == pytest.approx(20e3, rel=1e-6)
    assert np.isfinite(found.error).all()
    fine = replace(soft, dx=0.4, dy=0.2).solve()
    assert np.all(np.abs(found.force - fine.force) < found.error + 0.01 * 0.3 * 20e3)


@pytest.mark.long
def test_parts_of_a_patch_that_feel_each_other_in_part():
    """Within its errors the answer is that on fine elements."""
    case = wheel(5.0, yaw=0.012, vertical_force=10e3, join=1.0, separate=20.0)
    found, fine = case.solve(accuracy=0.1), replace(case, dx=0.6, dy=0.3).solve()
    assert len(found.patches[0].patch.interactions) == 1
    assert np.all(np.abs(found.force - fine.force) < found.error + 1e-3 * 0.3 * 10e3)


@pytest.mark.long
def test_a_time_budget_is_kept_and_longer_is_nearer(clock):
    """For all patches and heights together: 1.5 times, and two seconds that coarse grids may
    take.
    """
    found = []
    for budget in (0.3, 8.0):
        begun = clock.now
        found.append(wheel(3.0).solve(time_budget=budget))
        assert clock.now - begun <= 1.5 * budget + 2.0
    short, long = found
    assert short.force[2] == pytest.approx(60e3, rel=1e-6)
    assert long.error[0] < short.error[0] < 0.05 * 0.3 * 60e3


def noisy(profile, size):
    """Noise of a standard deviation, another at each point [mm]."""
    noise = np.random.default_rng(1).normal(size=profile.z.size)
    return replace(profile, z=profile.z + size * noise)


def rough_wheel(**more):
    case = wheel(3.0, **more)
    return replace(case, track=replace(case.track, rail=noisy(case.track.rail, 2e-3)))


@pytest.mark.long
def test_noise_is_warned_of_before_grids_are_refined(clock):
    """The first solution tells it; three sets of elements the errors, then."""
    with warnings.catch_warnings():
        warnings.simplefilter("error", RoughProfile)
        with pytest.raises(RoughProfile, match="noise dominates the patch at y = "):
            rough_wheel().solve()
    first = clock.now
    with pytest.warns(RoughProfile) as caught:
        found = rough_wheel().solve()
    assert clock.now - first < 6 * first  # 1.5^2 times as many elements at most, at a few heights
    assert [each.category for each in caught].count(RoughProfile) == 1
    assert caught[0].filename == __file__
    assert np.isfinite(found.error).all()
    with pytest.warns(RoughProfile):
        fine = rough_wheel(dx=0.15, dy=0.05).solve()
    assert np.all(np.abs(found.force - fine.force) <= found.error + 1e-3 * 60e3)
    (own,), (exact,) = found.patches, fine.patches
    assert abs(own.peak_pressure - exact.peak_pressure) < own.peak_pressure_error


@pytest.mark.filterwarnings("ignore::varcontact.wheel_rail.RoughProfile")
def test_the_geometry_counts_as_time(clock, monkeypatch):
    """Of a locus that takes longer than the budget allows no contact is solved."""
    follow = wheel_geometry.contact_locus

    def slow(*arguments):
        clock.now += 3.0
        return follow(*arguments)

    def unsolved(*arguments, **options):
        raise AssertionError("solved after the budget")

    monkeypatch.setattr(wheel_geometry, "contact_locus", slow)
    monkeypatch.setattr(WheelOnElements, "_with_initial_guesses", unsolved)
    with pytest.raises(SceneError, match="more seconds") as refused:
        wheel(3.0).solve(time_budget=0.1)
    assert refused.value.field == "time_budget"


@pytest.mark.long
def test_a_time_budget_is_kept_on_rough_profiles(clock):
    for budget in (0.5, 4.0):
        begun = clock.now
        found = rough_wheel().solve(time_budget=budget)
        assert clock.now - begun <= 1.5 * budget + 2.0
        assert np.isfinite(found.error).all()


@pytest.mark.long
def test_peak_pressures_have_error_bars():
    """Of circles Hertz's; two patches are held against fine elements. Reports show them."""
    (each,) = circles(300.0).solve().patches
    hertz = reference.hertz(
        460.0, 1 / (1 / 300 + 1 / 500), each.patch.scene.bodies, force=each.normal_force
    )
    assert (
        abs(each.peak_pressure - hertz.peak_pressure)
        < each.peak_pressure_error
        < 0.03 * hertz.peak_pressure
    )
    case = wheel(5.0, vertical_force=10e3, separate=4.0, turn=4.0)
    found, fine = case.solve(), replace(case, dx=0.1, dy=0.05).solve()
    for own, exact in zip(found.patches, fine.patches, strict=True):
        assert (
            abs(own.peak_pressure - exact.peak_pressure)
            < own.peak_pressure_error
            < 0.1 * exact.peak_pressure
        )
        words = with_bar(own.peak_pressure, own.peak_pressure_error)
        assert f"largest pressure {words} N/mm^2" in found.report()
    assert np.isnan(exact.peak_pressure_error)


@pytest.mark.long
def test_friction_that_varies_over_the_patch_has_errors_by_default():
    friction = FrictionByAngle((-0.1, 0.3), (0.2, 0.4))
    case = wheel(3.0, friction=friction)
    found, fine = case.solve(), replace(case, dx=0.25, dy=0.06).solve()
    assert np.all(np.abs(found.force - fine.force)[:2] < found.error[:2])
    assert np.all(found.error[:2] < 0.03 * 60e3 * 0.4)


def test_samples_are_the_distance_on_any_grid():
    """Interpolated, they are the distance that elements have, to a nanometre or so; the origin is
    the deepest.
    """
    case = wheel(3.0)
    z = case.touching + 0.08
    (sampled,), (own,) = case.patches(z, with_grid=False), replace(case, dx=0.7, dy=0.3).patches(z)
    assert sampled.scene.grid == "auto"
    surface, grid = sampled.scene.surface, own.scene.grid
    assert isinstance(surface, SampledDistance) and isinstance(grid, Grid)
    inside = own.scene.surface.h < own.approach
    apart = surface.distance(grid) - sampled.approach - (own.scene.surface.h - own.approach)
    assert np.abs(apart[inside]).max() < 2e-6
    assert sampled.approach == pytest.approx(own.approach, abs=1e-4)


@pytest.mark.long
def test_a_theory_on_the_ellipse_of_each_patch():
    """Of two circles it is Hertz's: the forces are those that the theory has there."""
    case = circles(y=-12.0, yaw=1e-3, velocity=Velocity(pitch_rate=-2.1739), dx=0.4, dy=0.4)
    found = case.solve(tangential="fastsim")
    assert found.force[2] == pytest.approx(80e3, rel=1e-6)
    (each,) = found.patches
    hertz = reference.hertz(460.0, 1 / (1 / 300 + 1 / 500), case.bodies, force=each.normal_force)
    rolled = each.patch.creepage
    exact = creep_forces(
        "fastsim", a=hertz.a, b=hertz.b, bodies=case.bodies, normal_force=each.normal_force, friction=0.3,
        vx=rolled.vx, vy=rolled.vy, spin=rolled.spin,
    )  # fmt: skip
    assert each.force[:2] == pytest.approx([exact.Fx, exact.Fy], abs=0.01 * 0.3 * each.normal_force)
    assert case.solve(tangential="table").force != pytest.approx(found.force, rel=1e-3)


test_what_is_refused = refusals(
    (
        lambda: wheel(2.0, dx=1.0).solve(accuracy=0.01),
        "dx: the grids are chosen for the accuracy; leave dx and dy out",
    ),
    (
        lambda: wheel(2.0, dy=1.0).solve(time_budget=1.0),
        "dy: the grids are chosen for the time_budget",
    ),
    (
        lambda: wheel(2.0).solve(accuracy=0.01, time_budget=1.0),
        "accuracy and time_budget are both given",
    ),
    (
        lambda: wheel(2.0).solve(accuracy=0.01, tangential="fastsim"),
        "a theory has an error that no grid removes",
    ),
    (
        lambda: WheelSetOnTrack(
            track=conditions.TRACK, wheelset=conditions.WHEELSET, vertical_force=160e3
        ).solve(time_budget=1.0),
        r"time_budget = 1\.0 must be left out: wheels are solved as often as the balance asks for",
    ),
    (lambda: wheel(2.0).solve(accuracy=-1.0), r"accuracy = -1\.0 is not allowed"),
    (
        lambda: wheel(2.0, dx=1.0, dy=1.0).solve(refine="continuum"),
        "refine = .* this version has accuracy",
    ),
    (lambda: wheel(2.0).solve(store="file.nc"), "store = .* must be left out"),
    (lambda: wheel(7.5).solve(tangential="table"), r"its book has a/b from 0\.2 to 5"),
)


@pytest.mark.long
def test_pressures_of_a_height_are_solved_for_once():
    """Tractions of the height that bears the load have the pressure that told it, of few elements
    and of many.
    """
    for side in (1.0, 0.3):
        (patch,) = wheel(0.0, vertical_force=10e3, dx=side, dy=side).solve().patches
        (calls,) = patch.solution.calls["normal"].values()
        assert calls.count == 1
        assert patch.solution.certificate.normal_residual < 1e-8
