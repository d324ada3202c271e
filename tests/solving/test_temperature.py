"""Temperature of the surfaces: closed forms, their order, energy, partition, and histories."""

import math
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

import varcontact as vc
from tests.scenes import refused
from varcontact.interfaces.heat import surface_temperatures

HALF = vc.Thermal(1.0, 1.0, 0.25)  # two of effusivity 1/2
STEEL = vc.Thermal(conductivity=50.0, density=7.85e-9, heat_capacity=4.5e8)


def rolling(thermal=STEEL, **changes):
    entries = {
        "bodies": vc.Bodies(G=82e3, nu=0.28),
        "surface": vc.Paraboloids(1 / 0.00203, 1 / 0.000843),
        "normal_force": 1e5,
        "friction": 0.3,
        "thermal": thermal,
        "motion": vc.Steady(vx=-0.03333, speed=3e4),
        "grid": vc.Grid(nx=72, ny=21, dx=0.6, dy=1.1, x0=-36.0, y0=-11.55),
    }
    return vc.Scene(**entries | changes)


def heated(form, n):
    """Places across a contact of half-width 1, and the temperatures there."""
    x = -1 + (np.arange(n) + 0.5) * 2 / n
    return x, surface_temperatures(form(x)[None], np.ones((1, n), bool), 2 / n, 1.0, (HALF, HALF))[
        0, 0
    ]


def test_parabolic_heat_converges_to_its_maximum():
    exact = (1.5**1.5 + 2 / 3 * 1.5**1.5 - 2 / 5 * 1.5**2.5) / math.sqrt(math.pi)
    assert exact == pytest.approx(1.1056, abs=1e-4)
    errors = []
    for n in (30, 60, 120):
        x, T = heated(lambda x: 1 - x**2, n)
        u = 1 - x  # distance from the leading edge
        closed = (4 / 3 * u**1.5 * 2 - 16 / 15 * u**2.5) / math.sqrt(math.pi)
        errors.append(np.abs(T - closed)[x < 0.5].max())
    assert all(1.4 < np.log2(coarse / fine) for coarse, fine in pairwise(errors))
    assert errors[-1] < 2e-4


def test_elliptic_heat_has_the_known_maximum():
    x, T = heated(lambda x: np.sqrt(1 - x**2), 400)
    top = int(T.argmax())
    near = slice(top - 1, top + 2)
    assert np.polyval(np.polyfit(x[near], T[near], 2), x[top]) == pytest.approx(1.2346, rel=1e-4)
    assert x[top] == pytest.approx(-0.652, abs=0.01)


def test_uniform_heat_is_largest_behind():
    _, T = heated(np.ones_like, 400)
    assert T.argmax() == 0 and T[0] == pytest.approx(2 * math.sqrt(2 / math.pi), rel=2e-3)


@pytest.mark.long
def test_full_sliding_of_a_wheel_has_the_closed_form_maximum():
    sol = vc.solve(rolling(), normal="hertz")
    hertz = sol.scene.hertz
    q0 = 0.03333 * 3e4 * 0.3 * hertz.peak_pressure
    expected = 1.2346 * q0 / (2 * STEEL.effusivity) * math.sqrt(hertz.a / 3e4)
    # the elastic slip varies by that
    assert sol.temperature.max() == pytest.approx(expected, rel=0.02)
    hottest = sol.grid.x[sol.temperature[0].max(axis=0).argmax()]
    assert (
        f"at most {sol.temperature.max():.4g} in the contact, at x = {hottest:.4g}, y = 0"
        in sol.report()
    )
    assert np.array_equal(sol.to_xarray()["temperature"].sel(body="lower"), sol.temperature[1])
    image = sol.plot("temperature").axes[0].images[0].get_array()
    assert np.allclose(image, sol.temperature[0])
    with pytest.raises(vc.SceneError, match="thermal data"):
        vc.solve(rolling(None, motion=vc.Steady(vx=-0.03))).plot("temperature")
    far = sol.temperature[0, sol.grid.ny // 2]
    assert np.all(np.diff(far[: np.argmax(far)]) > 0)  # the tail cools off behind


def test_bodies_of_other_temperatures_meet_at_the_mean_and_part_again():
    cold, hot = replace(STEEL, temperature=20.0), vc.Thermal(30.0, 7.2e-9, 5e8, temperature=80.0)
    scene = rolling((cold, hot), friction=0.0)
    sol = vc.solve(scene)
    contact = sol.state != 0
    mean = (cold.effusivity * 20 + hot.effusivity * 80) / (cold.effusivity + hot.effusivity)
    assert np.allclose(sol.temperature[:, contact], mean, rtol=1e-14)
    row = sol.grid.ny // 2
    a = contact[row].sum() * sol.grid.dx / 2
    centre = sol.grid.x[contact[row]].mean()
    behind = sol.grid.x < centre - a
    part = 2 / np.pi * np.arcsin(np.sqrt(2 * a / (a + centre - sol.grid.x[behind])))
    assert np.allclose(sol.temperature[0, row, behind], 20 + (mean - 20) * part, rtol=1e-12)
    assert np.allclose(sol.temperature[1, row, behind], 80 + (mean - 80) * part, rtol=1e-12)
    assert np.allclose(sol.temperature[:, row, sol.grid.x > centre + a], [[20.0], [80.0]])


@pytest.mark.parametrize("part", [0.7, 1.0, 1.7])
@pytest.mark.parametrize("started", [False, True])
def test_history_has_the_temperatures_of_steady_rolling_whatever_its_steps(part, started):
    """Material is followed between the elements' centres: in histories temperatures have the order
    of steady ones.
    """
    grid = vc.Grid(nx=15, ny=3, dx=1.6, dy=6.0, x0=-15.0, y0=-9.0)
    pair, dq = (STEEL, replace(STEEL, temperature=100.0)), 1.6 * part
    steady = vc.solve(rolling(pair, grid=grid, motion=vc.Steady(vx=-0.03333, dq=dq, speed=3e4)))
    start, steps = (steady, 2) if started else (None, int(2.5 * 15 / part))
    motion = vc.Transient(steps=steps, dq=dq, dt=dq / 3e4, vx=-0.03333, start=start)
    history = vc.solve(rolling(pair, grid=grid, motion=motion))
    assert np.allclose(
        history.temperature(), steady.temperature, atol=1e-10 * steady.temperature.max()
    )
    assert started or history.temperature(0).max() < 0.9 * steady.temperature.max()
    refused(lambda: history.temperature(1.5), match="k = ")


def test_steps_in_place_heat_as_by_hand():
    """By ``2 q (sqrt(t - t') - sqrt(t - t''))/((beta_1 + beta_2) sqrt(pi))`` of each step; and
    friction falls.
    """
    distance, beta = np.ones((3, 3)), 2 * STEEL.effusivity
    distance[1, 1] = 0.0
    law = vc.TemperatureFalling(0.5, 0.1, over=200.0)
    scene = rolling(
        surface=vc.SampledDistance(h=distance),
        normal_force=900.0,
        friction=law,
        motion=vc.Transient(steps=3, dq=0.0, dt=[1e-3, 2e-3, 1e-3], ux=-1e-2),
        grid=vc.Grid(nx=3, ny=3, dx=1.0, dy=1.0, x0=-1.5, y0=-1.5),
    )
    history = vc.solve(scene)
    ends = np.cumsum([0.0, 1e-3, 2e-3, 1e-3])
    q = [step.friction_work / dt for step, dt in zip(history, np.diff(ends), strict=True)]
    for k in range(3):
        passed = np.sqrt(ends[k + 1] - ends[: k + 2])
        rise = sum(2 * q[j] * (passed[j] - passed[j + 1]) for j in range(k + 1)) / (
            beta * np.sqrt(np.pi)
        )
        assert history.temperature(k)[0, 1, 1] == pytest.approx(rise, rel=1e-12)
        assert history[k].Fx == pytest.approx(900.0 * law.at(rise), rel=1e-8)
        assert 0 < history[k].Fx < 0.99 * 450.0


@pytest.mark.parametrize("n", [20, 30, 56])
def test_history_without_friction_is_steady_rolling_whatever_the_rounding(n):
    grid = vc.Grid(nx=n, ny=3, dx=24 / n, dy=7.5, x0=-16.0, y0=-11.25)
    pair = STEEL, vc.Thermal(30.0, 7.2e-9, 5e8, temperature=50.0)
    steady = rolling(pair, grid=grid, friction=0.0)
    motion = vc.Transient(steps=n, dq=24 / n, dt=24 / n / 3e4, vx=-0.03333)
    history = vc.solve(replace(steady, motion=motion))
    assert np.allclose(history.temperature(), vc.solve(steady).temperature, rtol=1e-12)


def test_friction_by_temperature_is_a_fixed_point():
    law = vc.TemperatureFalling(static=0.3, kinetic=0.12, reference=0.0, over=400.0)
    grid = vc.Grid(nx=30, ny=15, dx=0.45, dy=1.6, x0=-6.75, y0=-12.0)
    sol = vc.solve(rolling(friction=law, grid=grid))
    contact = sol.state != 0
    expected = 0.3 - 0.18 * np.clip(sol.temperature[0] / 400.0, 0.0, 1.0)
    size = np.hypot(*sol.traction)
    assert np.allclose(size[sol.state == 2], (expected * sol.pressure)[sol.state == 2], rtol=1e-7)
    assert np.all(size[contact] <= (expected * sol.pressure)[contact] * (1 + 1e-7))
    # CONTACT's, whose temperatures are 9 % too high
    assert sol.Fx / 1e5 == pytest.approx(0.3 * 0.866, rel=0.02)
    hottest = f"temperature       at most {sol.temperature[0, contact].max():.4g} in the contact"
    assert hottest in sol.report() and "depends on the temperature" in sol.report()
    other = vc.solve(rolling(friction=law, grid=grid), start="slip")
    assert other.Fx == pytest.approx(sol.Fx, rel=1e-8)
    cold = vc.solve(rolling(friction=vc.TemperatureFalling(0.3, 0.12, 1e5, 1.0), grid=grid))
    assert cold.Fx == pytest.approx(vc.solve(rolling(grid=grid)).Fx, rel=1e-9)
    with pytest.raises(vc.SceneError, match="thermal data"):
        rolling(None, friction=law, motion=vc.Steady(vx=0.01))


@pytest.mark.parametrize(
    ("changes", "name"),
    [
        ({"thermal": (STEEL, None)}, "thermal"),
        ({"motion": vc.Steady(vx=0.01)}, "motion.speed"),
        ({"motion": vc.Shift(ux=0.01)}, "motion"),
        ({"motion": vc.Transient(steps=2, vx=0.01, dq=0.1)}, "motion.dt"),
        ({"motion": vc.Transient(steps=2, vx=0.01, dq=0.1, dt=[0.1, 0.0])}, "motion.dt"),
    ],
)
def test_thermal_data_that_do_not_do(changes, name):
    refused(lambda: rolling(**changes), match=name)
    refused(lambda: vc.Thermal(1.0, -1.0, 1.0), match="density")
