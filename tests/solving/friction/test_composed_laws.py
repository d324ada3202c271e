"""Friction by slip, temperature, pressure and place together: limits, fixed point, branches, units,
files, refusals.
"""

from dataclasses import replace

import numpy as np
import pytest

import varcontact as vc
from tests.scenes import refused
from tests.solving.test_temperature import rolling

GRID = vc.Grid(nx=24, ny=11, dx=0.56, dy=2.2, x0=-6.72, y0=-12.1)
MIXED = vc.Steady(vx=-2e-3, speed=3e4)  # sticks and slips
SCALE = 1e-8 * 0.3e5  # of f Fn


def mixed(friction, **changes):
    return rolling(**{"friction": friction, "grid": GRID, "motion": MIXED} | changes)


def exponential(slip_velocity):
    return 0.1 + 0.2 * 2.0 ** (-slip_velocity / 30.0)


def by_pressure(pressure):
    return 0.4 / (1 + pressure / 2000.0)


def by_place(x, y):
    return 1.0 - 0.02 * np.abs(y) + 0.01 * x


@pytest.mark.parametrize("start", ["stick", "slip"])
@pytest.mark.parametrize(
    "factors",
    [
        lambda: 0.3,
        lambda x: np.full_like(x, 0.3),
        [lambda: 0.3, vc.TemperatureFalling(1.0, 0.4, reference=1e5)],  # so hot it does not get
        np.full((11, 24), 0.3),
    ],
)
def test_constant_products_are_a_number(factors, start):
    number, sol = (
        vc.solve(mixed(0.3)),
        vc.solve(mixed(vc.FrictionLaw(0.3, 0.1, factors)), start=start),
    )
    assert np.all(np.abs(sol.force - number.force) < SCALE)
    assert np.all(sol.friction == 0.3) and sol.branch == start


def test_friction_by_pressure_is_that_of_its_field():
    sol = vc.solve(mixed(vc.FrictionLaw(0.4, 0.1, by_pressure)))
    field = vc.solve(mixed(by_pressure(sol.pressure)))
    assert np.all(np.abs(sol.force - field.force) < SCALE)
    assert np.allclose(sol.traction_bound, field.traction_bound, rtol=1e-12)
    film = vc.PressureFalling(0.4, 0.1, strength=100.0)
    sol = vc.solve(mixed(film))
    field = vc.solve(mixed(np.minimum(0.4, 0.1 + 100.0 / np.maximum(sol.pressure, 1.0))))
    assert (
        np.all(np.abs(sol.force - field.force) < SCALE)
        and sol.friction.min() < 0.3 < sol.friction.max() == 0.4
    )
    shift = {"motion": vc.Shift(ux=0.01), "thermal": None}
    sol = vc.solve(mixed(vc.FrictionLaw(0.4, 0.1, by_pressure), **shift))
    assert np.all(
        np.abs(sol.force - vc.solve(mixed(by_pressure(sol.pressure), **shift)).force) < SCALE
    )


@pytest.mark.parametrize("start", ["stick", "slip"])
def test_all_factors_hold_at_the_end(start):
    def hot(temperature):
        return 1 / (1 + np.maximum(temperature, 0.0) / 200.0)

    wet = np.where(np.arange(24) < 12, 0.8, 1.0) * np.ones((11, 1))
    law = vc.FrictionLaw(0.4, 0.0, [exponential, hot, by_place, wet], velocity=3e4)
    sol = vc.solve(mixed(law, motion=replace(MIXED, vx=-1.2e-3)), start=start)
    slips, slip_velocity = sol.state == 2, 3e4 * np.hypot(*sol.slip)
    f = (
        exponential(slip_velocity)
        * hot(sol.temperature[0])
        * by_place(*np.meshgrid(GRID.x, GRID.y))
        * wet
    )
    size = np.hypot(*sol.traction)
    assert slips.sum() > 30 and (sol.state == 1).sum() > 10
    assert np.allclose(size[slips], (f * sol.pressure)[slips], rtol=1e-6)
    assert np.all(size <= sol.traction_bound * (1 + 1e-7))


@pytest.mark.long
def test_scene_files_hold_laws_and_numbers_but_no_functions(tmp_path):
    factors = [
        vc.ExponentialFalling(0.3, 0.1, 30.0, 3e4),
        vc.TemperatureFalling(1.0, 0.5, over=300.0),
        vc.PressureFalling(1.0, 0.5, strength=300.0),
        np.ones((5, 14)),
    ]
    scene = mixed(vc.FrictionLaw(0.3, 0.0, factors), grid=COARSE)
    scene.save(tmp_path / "law.toml")
    again = vc.read_scene(tmp_path / "law.toml")[0]
    assert again.friction.factors[:3] == scene.friction.factors[:3]
    sol = vc.solve(scene)
    assert vc.solve(again).Fx == sol.Fx
    sol.save(tmp_path / "law.nc")
    assert vc.load(tmp_path / "law.nc").Fx == sol.Fx and not vc.load(tmp_path / "law.nc").note
    own = mixed(vc.FrictionLaw(0.3, 0.0, exponential, velocity=3e4), grid=COARSE)
    with pytest.raises(
        vc.SceneError, match=r"factors = 'exponential'.*laws and numbers.*sol\.friction"
    ):
        own.save(tmp_path / "own.toml")
    sol = vc.solve(own)
    refused(lambda: sol.save(tmp_path / "own.nc"), match=r"sol\.friction")
    plain = vc.solve(replace(own, friction=sol.friction))
    assert plain.Fx == pytest.approx(sol.Fx, rel=1e-8)
    plain.save(tmp_path / "own.nc")


def no_number(pressure):
    return np.where(pressure > 100.0, np.nan, 0.3)


@pytest.mark.parametrize(
    ("factors", "words"),
    [
        (lambda depth: 0.3, r"<lambda>\(depth\).*slip_velocity, temperature, pressure, x, y"),
        (lambda x: "slippery", "numbers"),
        (lambda x: -0.1, r"<lambda> = -0.1.*zero or positive"),
        (lambda x: np.ones(4), r"<lambda>.*\(4,\).*shape \(2, 3\)"),
        (-np.ones((11, 24)), "zero or positive"),
        (vc.StaticKinetic(0.3, 0.2), "fall continuously"),
        (vc.LinearFalling(0.3, 0.2, 1.0, memory_distance=1.0), "without memory"),
        ([], "one factor"),
        ("linear", "laws, arrays"),
        ([0.3], "laws, arrays"),
        (lambda x: 1 / 0, "ZeroDivisionError"),
    ],
)
def test_factors_that_are_none(factors, words):
    with pytest.raises(vc.SceneError, match=f"(?s)friction.factors.*{words}"):
        vc.FrictionLaw(0.3, 0.1, factors)


@pytest.mark.parametrize(
    ("factors", "words"),
    [
        (no_number, "no_number = nan.*numbers"),
        (lambda x: 0.4, r"0.4 .*\[kinetic, static\] = \[0.1, 0.3\]"),
        (lambda temperature: 0.3 - temperature * 2e-3, r"\[kinetic, static\]"),
    ],
)
def test_products_that_do_not_do_on_the_elements(factors, words):
    with pytest.raises(vc.SceneError, match=f"(?s)friction.factors.*{words}"):
        vc.solve(mixed(vc.FrictionLaw(0.3, 0.1, factors), motion=vc.Steady(vx=-0.03, speed=3e4)))


def test_laws_where_they_do_not_belong():
    law = vc.FrictionLaw(0.3, 0.1, lambda x: 0.2)
    hot = vc.TemperatureFalling(0.3, 0.1, over=300.0)
    steps = vc.Transient(steps=2, dq=0.56, dt=1e-5, vx=1e-3)
    with pytest.raises(vc.SceneError, match=r"motion.start.*steady"):
        mixed(hot, motion=replace(steps, start=vc.solve(mixed(hot, motion=steps))[-1]))
    refused(lambda: mixed(law, motion=replace(steps, dq=0.0)), match=r"does not roll")
    with pytest.raises(vc.SceneError, match="thermal"):
        mixed(
            vc.FrictionLaw(0.3, 0.1, lambda temperature: 0.2),
            thermal=None,
            motion=vc.Steady(vx=1e-3),
        )
    with pytest.raises(vc.SceneError, match=r"factors.*\(3, 3\).*\(11, 24\)"):
        mixed(vc.FrictionLaw(0.3, 0.1, np.full((3, 3), 0.3)))
    with pytest.raises(vc.SceneError, match=r"factors.*\(3, 3\).*\(11, 24\)"):
        mixed(0.3, motion=replace(steps, friction=vc.FrictionLaw(0.3, 0.1, np.full((3, 3), 0.3))))
    for theory in ("fastsim", "linear", "polach", "table"):
        with pytest.raises(vc.SceneError, match=rf"{theory}.*another method.*by slip alone"):
            vc.solve(mixed(law), tangential=theory)


FACTORS = (
    vc.ExponentialFalling(0.3, 0.2, 200.0, 3e4),
    vc.TemperatureFalling(1.0, 0.4, over=400.0),
    lambda y: 0.99,
)
WARM = vc.FrictionLaw(0.3, 0.02, FACTORS, velocity=3e4)
COARSE = vc.Grid(nx=14, ny=5, dx=1.6, dy=4.4, x0=-14.0, y0=-11.0)


@pytest.mark.long
@pytest.mark.parametrize(
    ("law", "part"), [(WARM, 1.0), (WARM, 1.7), (vc.PressureFalling(0.3, 0.1, 80.0), 1.0)]
)
def test_a_history_ends_in_steady_rolling(law, part):
    dq = part * 1.6
    steady = vc.solve(mixed(law, grid=COARSE, motion=vc.Steady(vx=-8e-3, dq=dq, speed=3e4)))
    assert 0.02 < np.ptp(steady.friction[steady.state == 2])
    for steps, start in ((int(30 / part), None), (3, steady)):
        motion = vc.Transient(steps=steps, vx=-8e-3, dq=dq, dt=dq / 3e4, start=start)
        last = vc.solve(mixed(law, grid=COARSE, motion=motion))[-1]
        touches = last.state > 0
        assert last.Fx == pytest.approx(steady.Fx, rel=1e-6)
        assert np.allclose(last.friction[touches], steady.friction[touches], atol=1e-7)


@pytest.mark.long
@pytest.mark.parametrize("law", [WARM, vc.TemperatureFalling(0.3, 0.02, over=400.0)])
def test_memory_of_all_that_friction_depends_on_goes_with_the_material(law):
    slow = replace(law, memory_distance=0.05)
    steady = vc.solve(mixed(slow, grid=COARSE, motion=vc.Steady(vx=-8e-3, speed=3e4)))
    last = vc.solve(
        mixed(slow, grid=COARSE, motion=vc.Transient(steps=24, vx=-8e-3, dq=1.6, dt=1.6 / 3e4))
    )[-1]
    touches = steady.state > 0
    assert last.Fx == pytest.approx(steady.Fx, rel=1e-7)
    assert np.allclose(last.friction[touches], steady.friction[touches], atol=1e-7)
    fast = vc.solve(mixed(law, grid=COARSE, motion=steady.motion))
    assert steady.Fx > 1.02 * fast.Fx
    # by hand along the rows, with the temperatures, pressures, slips and places of the solution
    slip = np.hypot(*steady.slip) * (steady.state == 2)
    own = law.on(slip, steady.temperature[0], steady.pressure, *np.meshgrid(COARSE.x, COARSE.y))
    came = np.where(touches[:, 1:], steady.friction[:, 1:], steady.friction[:, -1:])
    expected = own[:, :-1] + (came - own[:, :-1]) * np.exp(-slip[:, :-1] * 1.6 / 0.05)
    assert np.allclose(
        steady.friction[:, :-1][touches[:, :-1]], expected[touches[:, :-1]], atol=1e-6
    )


@pytest.mark.long
def test_a_stored_history_goes_on_as_if_it_had_not_ended(tmp_path):
    law = vc.TemperatureFalling(0.3, 0.12, over=400.0)
    motion = vc.Transient(steps=6, vx=-8e-3, dq=1.1, dt=1.1 / 3e4)
    scene = mixed(law, grid=COARSE, motion=motion)
    whole = vc.solve(scene)

    def stop(line):
        if line.startswith("3 of"):
            raise KeyboardInterrupt

    with pytest.raises(vc.Interrupted):
        vc.solve(scene, store=tmp_path / "warm.nc", progress=stop)
    vc.solve(scene, store=tmp_path / "warm.nc")
    again = vc.load(tmp_path / "warm.nc")
    assert np.array_equal(again.force, whole.force) and not any(step.note for step in again)
    assert np.array_equal(again.temperature(), whole.temperature())
    assert f"temperature at the end at most {whole.temperature().max():.4g}" in whole.report()


@pytest.mark.parametrize(
    "changes",
    [
        {"bodies": vc.Bodies((82e3, 30e3), (0.28, 0.35)), "grid": vc.Grid(nx=20, ny=16)},
        {"third_body": vc.ThirdBody(0.02, 820.0, 100.0, 2000.0)},
        {"motion": vc.Steady(Fx=-1e4, speed=3e4)},
    ],
)
def test_temperature_with_other_parts_of_a_scene(changes):
    law = vc.TemperatureFalling(static=0.3, kinetic=0.12, over=30.0)
    sol = vc.solve(mixed(law, **changes))
    slips = sol.state == 2
    expected = law.at(sol.temperature[0]) * sol.pressure
    assert np.allclose(np.hypot(*sol.traction)[slips], expected[slips], rtol=1e-6)
    assert sol.friction[slips].min() < 0.295


@pytest.mark.long
def test_temperature_to_an_accuracy_within_a_time_and_in_batches():
    law = vc.TemperatureFalling(static=0.3, kinetic=0.12, over=400.0)
    auto = rolling(friction=law, grid="auto")
    exact = vc.solve(replace(auto, grid=vc.Grid(nx=40, ny=20))).Fx
    sol = vc.solve(auto, accuracy=0.02)
    assert abs(sol.Fx / exact - 1) < 0.02 and sol.error_estimate.errors["Fx"] < 0.02
    assert vc.solve(auto, time_budget=1.0).Fx == pytest.approx(exact, rel=5e-3)
    many = vc.solve_many([mixed(law), mixed(0.3)])
    assert [str(by) for by in many["by"].values] == ["solve", "batched"]
    assert float(many["Fx"][0]) == pytest.approx(vc.solve(mixed(law)).Fx, rel=1e-8)
