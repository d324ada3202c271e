"""Gradients of wheels on rails, through the geometry."""

import functools
from dataclasses import replace

import numpy as np
import pytest

import varcontact as vc
from tests.wheel_rail.conditions import cone, round_rail
from varcontact.wheel_rail import Position, ProfileSlices, Track, WheelOnRail, WheelSet

RAIL = round_rail().resampled(1.0)
CONE = cone(0.05).resampled(2.0)
OUTPUTS = ["normal_force", "Fx", "friction_work"]


@functools.cache
def wheel(side=0.8, rail=RAIL, load=60e3, profile=CONE, **place):
    case = WheelOnRail(
        track=Track(rail=rail, gauge=1433.0, gauge_height=2.0),
        wheelset=WheelSet(wheel=profile),
        position=Position(**{"y": 1.0, "yaw": 0.002} | place),
        vertical_force=load,
        dx=side,
        dy=side,
    )
    return case.solve(tol=1e-9)


def values(solution):
    (patch,) = solution.patches
    own = patch.solution
    return np.array([own.normal_force, own.Fx, own.friction_work])


@pytest.mark.long
@pytest.mark.parametrize(
    ("name", "entry", "at", "step"),
    [
        ("y", "y", 1.0, 0.5),
        ("yaw", "yaw", 0.002, 2e-4),
        ("roll", "roll", 0.0, 1e-3),
        ("vertical_force", "load", 60e3, 6e3),
    ],
)
def test_by_position_and_load(name, entry, at, step):
    """Against differences of solutions, which scatter as elements enter."""
    found = wheel().gradient(OUTPUTS, name)[name].to_numpy()[:, 0]
    above = values(wheel(**{entry: at + step}))
    below = values(wheel(**{entry: at - step}))
    expected = (above - below) / (2 * step)
    assert found == pytest.approx(expected, rel=0.06, abs=2e-4 * abs(values(wheel())).max() / 60e3)


@pytest.mark.long
def test_by_the_points_of_a_profile():
    """A rail that is lifted as a whole lifts the wheel; one with a bump is stiffer across."""
    found = wheel().gradient(["Fx", "peak_pressure"], "rail").rail
    whole = found.sum("rail_point")
    assert (abs(whole) < 1e-3 * abs(found).sum("rail_point")).all()
    middle = wheel().patches[0].patch.on_rail[0]
    bump = np.exp(-(((RAIL.y - middle - 1) / 6) ** 2))
    by_bump = (found * bump).sum("rail_point").to_numpy()[:, 0]

    def moved(height):
        solution = wheel(rail=replace(RAIL, z=RAIL.z + height * bump))
        own = solution.patches[0].solution
        return np.array([own.Fx, own.pressure.max()])

    expected = (moved(0.02) - moved(-0.02)) / 0.04
    assert by_bump == pytest.approx(expected, rel=0.12)


@pytest.mark.long
def test_by_the_points_of_a_wheel():
    """A profile that is lifted as a whole rolls on a smaller radius; one with a bump."""
    outputs = ["Fx", "peak_pressure", "friction_work"]
    found = wheel().gradient(outputs, "wheel").wheel
    middle = wheel().patches[0].patch.on_wheel[0]
    ways = {
        "whole": (np.ones(CONE.y.size), 0.05, [0, 2]),
        "bump": (np.exp(-(((CONE.y - middle - 1) / 6) ** 2)), 0.02, [0, 1]),
    }
    for way, height, compared in ways.values():
        by_way = (found * way).sum("wheel_point").to_numpy()[:, 0]

        def moved(height, way=way):
            solution = wheel(profile=replace(CONE, z=CONE.z + height * way))
            own = solution.patches[0].solution
            return np.array([own.Fx, own.pressure.max(), own.friction_work])

        expected = (moved(height) - moved(-height)) / (2 * height)
        assert by_way[compared] == pytest.approx(expected[compared], rel=0.05)


def test_a_round_wheel_is_the_same_at_each_pitch():
    found = wheel().gradient(OUTPUTS, "pitch").pitch
    assert (found == 0).all()


def test_friction_work_is_t_gamma_of_the_patch():
    found = wheel().gradient("friction_work", "vertical_force").value
    assert float(found.squeeze()) == pytest.approx(wheel().patches[0].t_gamma, rel=1e-6)
    assert "error=True" in wheel().gradient("Fx", "vertical_force").error


@pytest.mark.long
def test_errors_and_units():
    """The error is that of the elements: finer ones differ by less."""
    tangential = OUTPUTS[1:]
    inputs = ("y", "vertical_force")
    found = wheel().gradient(tangential, inputs, error=True)
    fine = wheel(side=0.5).gradient(tangential, inputs)
    for name in inputs:
        error = found[f"{name}_error"]
        assert (error > 0).all()
        assert (abs(found[name] - fine[name]) < error + 0.01 * abs(found[name])).all()
    assert found.y.units == "(N)/(mm); (N)/(mm)"
    assert found.vertical_force_error.units == "(N)/(N); (N)/(N)"


def test_under_a_given_height_forces_follow_it():
    """The vertical force by the height is the stiffness that the load's derivatives have."""
    loaded = wheel()
    held = replace(loaded, case=replace(loaded.case, vertical_force=None, z=loaded.z))
    by_load = loaded.gradient("normal_force", "vertical_force").vertical_force
    assert float(by_load.squeeze()) == pytest.approx(1.0, abs=0.02)
    with pytest.raises(vc.SceneError, match="prescribed by the case"):
        held.gradient("normal_force", "vertical_force")


def test_profiles_that_vary_have_no_gradient():
    """A rail whose slices rise by a micrometre."""
    slices = ProfileSlices(profiles=RAIL, positions=[-50.0, 0.0, 80.0], z=[0.0, 1e-3, 0.0])
    with pytest.raises(vc.SceneError, match="profiles that do not vary: others have no gradient"):
        wheel(side=1.0, rail=slices).gradient("normal_force", "y")


@pytest.mark.parametrize(("output", "by"), [("Fz", "y"), ("Fx", "position.v"), ("vx", "y")])
def test_what_a_wheel_has_not(output, by):
    with pytest.raises(vc.SceneError):
        wheel().gradient(output, by)
