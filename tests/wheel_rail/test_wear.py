"""Indices of wear: full slip in closed form, energy counted twice, and what is refused."""

from dataclasses import replace

import numpy as np
import pytest

from tests.wheel_rail.conditions import circles, wheel
from varcontact import reference
from varcontact.errors import SceneError
from varcontact.wheel_rail import Archard, Velocity, wear

LAW = Archard(k=6e-4, hardness=3000.0)


@pytest.fixture(scope="module")
def sliding():
    """Two circles and a locked wheel: creepage -2, against which elastic slip is nothing."""
    return circles(velocity=Velocity(speed=5000.0, pitch_rate=0.0), dx=0.25, dy=0.25).solve()


@pytest.fixture(scope="module")
def rolling():
    return wheel(2.0, yaw=0.002, dx=0.5, dy=0.5).solve()


def test_a_locked_wheel_in_closed_form(sliding):
    """All slips at the speed V over the rail: power f N V, and the depth k/H p0 (pi/2) a at the middle by distance."""
    (worn,) = wear(sliding, LAW).patches
    (each,) = sliding.patches
    rolled = each.patch.creepage
    assert abs(rolled.vx) * rolled.speed == pytest.approx(5000.0, rel=1e-6)
    assert worn.power == pytest.approx(0.3 * 80e3 * 5.0, rel=1e-4)
    hertz = reference.hertz(460.0, 1 / (1 / 300 + 1 / 500), sliding.case.bodies, force=80e3)
    middle = 2e-7 * abs(rolled.vx) * hertz.peak_pressure * np.pi / 2 * hertz.a
    assert worn.depth.max() == pytest.approx(middle, rel=0.01)
    assert worn.volume == pytest.approx(2e-7 * abs(rolled.vx) * 80e3, rel=0.005)
    assert worn.area == pytest.approx(np.pi * hertz.a * hertz.b, rel=0.02)
    assert worn.power_by_area.max() == pytest.approx(0.3 * hertz.peak_pressure * 5.0, rel=0.01)


def test_energy_is_counted_twice(rolling):
    """By Coulomb's law f times pressure times slip is the work of friction; that is what motion puts in."""
    (worn,) = wear(rolling, LAW).patches
    (each,) = rolling.patches
    assert worn.volume == pytest.approx(2e-7 * worn.t_gamma / 0.3, rel=1e-11)
    assert worn.power_by_area.sum() * 0.25 == pytest.approx(worn.power, rel=1e-11)
    assert worn.depth.min() > -1e-3 * worn.depth.max()
    assert worn.depth.sum() * 0.5 == pytest.approx(worn.volume, rel=1e-12)
    assert worn.t_gamma == pytest.approx(each.solution.friction_work, rel=1e-12)
    assert worn.t_gamma - worn.t_gamma_without_spin == pytest.approx(-each.moment * each.patch.creepage.spin)
    assert worn.t_gamma_by_area == pytest.approx(worn.t_gamma / worn.area)
    assert wear(rolling).t_gamma == pytest.approx(worn.t_gamma)


def test_the_power_grows_with_the_speed_and_the_wear_by_distance_does_not(rolling):
    faster = replace(rolling.case, velocity=Velocity(speed=3000.0)).solve()
    one, other = wear(rolling, LAW), wear(faster, LAW)
    assert other.power == pytest.approx(3 * one.power, rel=1e-6)
    assert other.volume == pytest.approx(one.volume, rel=1e-6)


def test_what_is_refused(rolling):
    with pytest.raises(SceneError, match=r"archard is missing for depth and volume"):
        _ = wear(rolling).patches[0].depth
    with pytest.raises(SceneError, match=r"wear.k = -1"):
        Archard(k=-1.0, hardness=3000.0)
    with pytest.raises(SceneError, match=r"archard = 0.1 is not allowed: must be an Archard"):
        wear(rolling, 0.1)
    with pytest.raises(SceneError, match=r"must be a WheelRailSolution"):
        wear(rolling.patches[0])
