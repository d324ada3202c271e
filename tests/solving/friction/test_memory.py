"""What particles remember in a history under a law of friction, where steps are no whole elements
long.
"""

import dataclasses
import re
from dataclasses import replace

import numpy as np
import pytest

import varcontact as vc
from tests.scenes import in_units, make_scene, refused
from varcontact.discrete.state import ContactState
from varcontact.io.records import SERIES
from varcontact.io.scene_toml import scene_from, scene_to
from varcontact.solving.contact_solver import (
    ACCELERATED_BELOW,
    FIELD_PASSES_MAX,
    PLAIN_PASSES,
)
from varcontact.solving.coupling import Limits, fixed_point

JUMP = vc.StaticKinetic(0.4, 0.2)
STEEP = [JUMP, vc.ExponentialFalling(0.4, 0.2, half_velocity=1e-5)]
"""With a jump, or a fall so steep that stick and slip are two branches."""
GENTLE = [
    vc.LinearFalling(0.4, 0.2, half_velocity=0.2),
    vc.RationalFalling(0.4, 0.2, half_velocity=0.2),
    vc.ExponentialFalling(0.4, 0.2, half_velocity=0.1),
]
"""Falls that are slow for all steps here."""
N, LOAD = 8, 1e-3


def rolling(law, motion, cells=N):
    bodies, grid = vc.Bodies(G=1.0, nu=0.25), vc.Grid(nx=cells, ny=cells)
    return make_scene(vc.Paraboloids(1.0, 1.0), LOAD, motion, grid, friction=law, bodies=bodies)


@pytest.fixture(scope="module")
def dx():
    return vc.solve(rolling(0.2, vc.Steady())).grid.sides[0]


def used(sol):
    return -sol.force[0] / sol.normal_force


def ends(law, part, vx, starts, cells=N):
    """Last steps of histories that go on from solutions."""
    dq = part * starts[0].grid.sides[0]
    motions = [
        vc.Transient(steps=int(2.5 * cells / part), dq=dq, vx=vx, start=start) for start in starts
    ]
    return [vc.solve(rolling(law, motion, cells=cells))[-1] for motion in motions]


@pytest.mark.long
@pytest.mark.parametrize(
    ("law", "part", "vx"),
    [(STEEP[1], 0.25, 5e-3), (STEEP[0], 0.6, 3e-3), (STEEP[0], 1.7, 5e-3)],
)
def test_the_end_under_a_steep_law_is_the_steady_solution_from_stick(law, part, vx, dx, holds):
    """From more slip, the other steady solution, and from more stick; to a tenth of what the two
    are apart.
    """
    steady = vc.Steady(vx=vx, dq=part * dx)
    stick, slip = (vc.solve(rolling(law, steady), start=start) for start in ("stick", "slip"))
    slower = vc.solve(rolling(law, replace(steady, vx=0.96 * vx)))
    apart = used(stick) - used(slip)
    assert apart > 0.015 * used(stick)
    for last in ends(law, part, vx, [slip, slower]):
        holds(last, tol=1e-6)
        assert used(last) == pytest.approx(used(stick), abs=0.1 * apart)


@pytest.mark.long
def test_a_history_may_end_in_another_steady_solution():
    """With a static and a kinetic coefficient there are several; each end solves the steady problem
    in one pass.
    """
    dx = vc.solve(rolling(0.2, vc.Steady(), cells=10)).grid.sides[0]
    steady = vc.Steady(vx=5e-3, dq=0.25 * dx)
    stick, slip = (
        vc.solve(rolling(JUMP, steady, cells=10), start=start) for start in ("stick", "slip")
    )
    slower = vc.solve(rolling(JUMP, replace(steady, vx=4.8e-3), cells=10))
    lower, upper = ends(JUMP, 0.25, 5e-3, [slip, slower], cells=10)
    assert used(upper) == pytest.approx(used(stick), rel=1e-3)
    assert used(slip) + 1e-3 < used(lower) < used(stick) - 1e-3
    again = vc.solve(rolling(JUMP, steady, cells=10), start=lower)
    assert len(again.passes) == 1
    assert used(again) == pytest.approx(used(lower), rel=1e-3)


@pytest.mark.long
@pytest.mark.parametrize(("law", "part"), list(zip(GENTLE, (0.6, 1.0, 1.7), strict=True)))
def test_the_end_under_a_gentle_law_is_the_one_steady_solution(law, part, dx, holds):
    steady = vc.Steady(vx=5e-3, dq=part * dx)
    only, other = (vc.solve(rolling(law, steady), start=start) for start in ("stick", "slip"))
    assert used(other) == pytest.approx(used(only), rel=1e-6)
    starts = [vc.solve(rolling(law, replace(steady, vx=vx))) for vx in (4.8e-3, 5.2e-3)]
    for start, last in zip(starts, ends(law, part, 5e-3, starts), strict=True):
        assert abs(used(start) / used(only) - 1) > 0.012
        holds(last, tol=1e-6)
        assert used(last) == pytest.approx(used(only), abs=0.003 * 0.4)
        assert used(last) == pytest.approx(used(only), abs=0.1 * abs(used(start) - used(only)))
        assert not any("so short a step" in warning for warning in last.warnings)


@pytest.mark.long
def test_where_the_law_is_too_steep_for_the_step_a_solution_says_so(line):
    """There the steady solution is not stable: rounding grows to a swing of stick and slip, on
    finer grids too.
    """
    dq = 2 * np.sqrt(4e-3 * (1 - 0.28) / np.pi) / 24
    deep, found = vc.Cylinders(R=1.0, reference_depth=1.0), {}
    for half in (0.02, 0.1):
        law = vc.ExponentialFalling(0.4, 0.2, half_velocity=half)
        rolling_steadily = vc.Steady(vx=5e-3, dq=dq)
        steady = vc.solve(replace(line(law), surface=deep, motion=rolling_steadily))
        motion = vc.Transient(steps=40, dq=dq, vx=5e-3, start=steady)
        history = vc.solve(replace(steady.scene, motion=motion))
        found[half] = np.ptp(history.force[20:, 0] / steady.force[0]), history[0].warnings
        assert history[0].force[0] == pytest.approx(steady.force[0], rel=1e-6)
    assert found[0.02][0] > 0.02
    assert found[0.1] == (pytest.approx(0, abs=1e-6), ())
    (warning,) = found[0.02][1]
    assert "stick and slip in turn" in warning
    least = float(re.search("below dq of about ([0-9.e-]+) ", warning)[1])
    assert least == pytest.approx(7.4e-3, rel=0.03)  # on both grids


FORGETFUL = {"memory_distance": 3e-4}
SLOW = [
    vc.StaticKinetic(0.4, 0.2, **FORGETFUL),
    vc.ExponentialFalling(0.4, 0.2, half_velocity=0.01, **FORGETFUL),
]
"""Laws whose steady solution is not stable, or not the only one, without their memory."""


@pytest.mark.long
@pytest.mark.parametrize(
    ("law", "part"), [(SLOW[1], 0.4), (SLOW[0], 0.6), (SLOW[1], 1.0), (SLOW[0], 1.7)]
)
def test_with_a_memory_the_end_does_not_depend_on_the_start(law, part, dx):
    """Under the steepest laws, with the shortest steps; with steps of an element it is the steady
    solution.
    """
    starts = [vc.solve(rolling(law, vc.Steady(vx=vx))) for vx in (4e-3, 6e-3)]
    motions = [
        vc.Transient(steps=int(4 * N / part), dq=part * dx, vx=5e-3, start=start)
        for start in starts
    ]
    histories = [vc.solve(rolling(law, motion)) for motion in motions]
    one, other = (history[-1] for history in histories)
    apart = used(starts[1]) - used(starts[0])
    assert apart > 0.1 * used(one)
    assert used(one) == pytest.approx(used(other), abs=2e-3 * apart)
    assert used(histories[0][-2]) == pytest.approx(used(one), abs=2e-3 * apart)
    size = np.hypot(*one.traction)
    np.testing.assert_allclose(
        size[one.state == 2], (one.friction * one.pressure)[one.state == 2], rtol=1e-6
    )
    assert np.all(size <= one.friction * one.pressure * (1 + 1e-6))
    if part == 1.0:
        stick, slip = (
            vc.solve(rolling(law, vc.Steady(vx=5e-3)), start=start) for start in ("stick", "slip")
        )
        assert used(slip) == pytest.approx(used(stick), rel=1e-7)
        assert used(one) == pytest.approx(used(stick), abs=2e-3 * apart)


def test_a_memory_is_lost_by_the_distance_slid(dx, tmp_path):
    """With two coefficients ``f = kinetic + (static - kinetic) exp(-slid/d)``, slid from the
    leading edge of a row.
    """
    law = vc.StaticKinetic(0.4, 0.2, memory_distance=5e-4)
    sol = vc.solve(rolling(law, vc.Steady(vx=8e-3, vy=3e-3)))
    slid = np.cumsum(np.where(sol.state == 2, np.hypot(*sol.slip) * dx, 0.0)[:, ::-1], axis=1)[
        :, ::-1
    ]
    expected = 0.2 + 0.2 * np.exp(-slid / 5e-4)
    assert np.ptp(expected[sol.state == 2]) > 0.05
    np.testing.assert_allclose(
        sol.friction[sol.pressure > 0], expected[sol.pressure > 0], rtol=1e-6
    )
    slips = sol.state == 2
    np.testing.assert_allclose(
        np.hypot(*sol.traction)[slips], (expected * sol.pressure)[slips], rtol=1e-6
    )
    sol.save(tmp_path / "sol.nc")
    again = vc.load(tmp_path / "sol.nc")
    assert again.converged
    np.testing.assert_array_equal(again.friction, sol.friction)


def test_particles_that_stick_regain_static_friction_by_the_least_velocity():
    """In place, in steps of unit duration: a slide that loses nearly all, then a wait."""
    law = vc.StaticKinetic(0.4, 0.2, memory_distance=1e-3, memory_velocity=5e-4)
    motion = vc.Transient(steps=3, dq=0.0, ux=[1e-1, -1e-6, 0.0])
    slide, wait, again = vc.solve(rolling(law, motion))
    assert slide.weakening[slide.pressure > 0].min() > 0.99
    stuck = wait.state == 1
    assert stuck.sum() > 50
    np.testing.assert_allclose(
        wait.weakening[stuck], (slide.weakening * np.exp(-0.5))[stuck], rtol=1e-6
    )
    np.testing.assert_allclose(
        again.weakening[stuck], (slide.weakening * np.exp(-1.0))[stuck], rtol=1e-6
    )


@pytest.mark.parametrize(
    "entries",
    [{"memory_distance": -1e-3}, {"memory_distance": np.nan}, {"memory_velocity": 1.0}],
    ids=str,
)
def test_what_no_memory_can_be(entries):
    refused(lambda: vc.StaticKinetic(0.4, 0.2, **entries), f"friction.{next(iter(entries))}")


@pytest.mark.long
def test_mirror_and_units(dx):
    lengths = np.tile([0.3, 0.6, 1.7, 0.25], 6) * dx
    way = np.repeat([1, 1, -1, 1], 6)
    motion = vc.Transient(steps=24, dq=lengths, direction=way, vx=8e-3)
    first = vc.solve(rolling(JUMP, motion))
    mirrored = vc.solve(rolling(JUMP, replace(motion, direction=-way, vx=-8e-3)))
    scaled = vc.solve(in_units(rolling(JUMP, motion), 1024.0, 2.0**-8))
    assert any((sol.weakening % 1 > 0).any() for sol in first)
    for k in (11, 17, 23):
        np.testing.assert_allclose(mirrored[k].weakening[:, ::-1], first[k].weakening, atol=1e-8)
        np.testing.assert_allclose(mirrored[k].force[0], -first[k].force[0], rtol=1e-7)
        np.testing.assert_allclose(scaled[k].weakening, first[k].weakening, atol=1e-8)
        np.testing.assert_allclose(
            scaled[k].force, 4096 * first[k].force, rtol=1e-7, atol=1e-9 * LOAD
        )


def test_a_step_in_place_without_slip_restores_static_friction(dx):
    motion = vc.Transient(steps=13, dq=[0.25 * dx] * 12 + [0.0], vx=[2e-2] * 11 + [-1e-3, 0.0])
    history = vc.solve(rolling(JUMP, motion))
    assert (
        (history[-2].weakening > 0) & (history[-2].weakening < 1) & (history[-2].state == 1)
    ).any()
    assert (history[-1].state != 2).all()
    assert (history[-1].weakening == 0).all()


@pytest.mark.long
def test_a_history_goes_on_bit_for_bit(tmp_path, dx):
    motion = vc.Transient(steps=20, dq=0.3 * dx, vx=[2e-2] * 8 + [4e-3] * 12)
    scene = rolling(JUMP, motion)
    history = vc.solve(scene)
    begun = replace(history, solutions=history[:12])
    begun.save(tmp_path / "begun.nc")
    again = vc.solve(scene, store=tmp_path / "begun.nc")
    history[11].save(tmp_path / "step.nc")
    start = vc.load(tmp_path / "step.nc")
    rest = vc.solve(rolling(JUMP, vc.Transient(steps=8, dq=0.3 * dx, vx=4e-3, start=start)))
    for name in ("traction", "slip", "weakening"):
        np.testing.assert_array_equal(getattr(again[19], name), getattr(history[19], name))
    np.testing.assert_allclose(
        rest[7].traction, history[19].traction, rtol=0, atol=1e-12 * history[19].pressure.max()
    )
    assert again.to_xarray()["weakening"].shape == (20, *history.grid.shape)

    earlier = replace(history, solutions=[replace(sol, carried={}) for sol in history[:12]])
    earlier.save(tmp_path / "earlier.nc")
    assert "weakening" not in vc.load(tmp_path / "earlier.nc").to_xarray()
    assert "weakening" not in SERIES


def test_passes_go_on_where_two_solutions_have_just_vanished():
    """A coefficient that falls by less and less towards .3, and then by more to the kinetic one: .3
    is no solution.
    """

    def after(friction):
        return np.clip(friction - 0.5 * ((friction - 0.3) ** 2 + 1e-4), 0.2, 0.4)

    def one_pass(state):
        found = after(state.fields["friction"])
        return state.under({"friction": found}), float(np.abs(after(found) - found).max())

    bare = ContactState(np.zeros((1, 1)), 0.0, np.zeros((2, 1, 1)), np.zeros(2))
    start = bare.under({"friction": np.array([[0.4]])})
    limits = Limits(
        1e-9,
        FIELD_PASSES_MAX,
        FIELD_PASSES_MAX,
        plain=PLAIN_PASSES,
        near=ACCELERATED_BELOW,
        within={"friction": (0.2, 0.4)},
    )
    best = fixed_point(one_pass, *one_pass(start), ("friction",), limits)
    assert best.fields["friction"] == 0.2
    assert len(best.passes) > PLAIN_PASSES


# ----------------------------------------------------------------- Histories under laws of friction


DEEP = vc.Cylinders(R=1.0, reference_depth=1.0)


@pytest.mark.long
@pytest.mark.parametrize("law", [vc.ExponentialFalling(0.3, 0.2, 0.1), vc.StaticKinetic(0.2, 0.2)])
def test_long_history_is_steady(law, tmp_path, line, holds):
    steady = vc.solve(line(law, Fx=-1.5e-4))
    scene = dataclasses.replace(line(law), motion=vc.Transient(steps=100, Fx=-1.5e-4))
    history = vc.solve(scene, store=tmp_path / "history.nc")
    for sol in history[::25]:
        holds(sol)
    np.testing.assert_allclose(
        history[-1].traction, steady.traction, atol=1e-6 * steady.traction_bound.max()
    )
    assert vc.load(tmp_path / "history.nc")[-1].branch == "history"


def test_who_slips_goes_on_slipping(ball, holds):
    """In small steps of a shift, friction rises to the static bound, falls to the kinetic one, and
    stays there.
    """
    law = vc.StaticKinetic(0.3, 0.2)
    motion = vc.Transient(steps=24, dq=0.0, ux=2e-5)
    history = vc.solve(ball(law, motion=motion))
    force = -history.force[:, 0] / 1e-4
    for sol in history[::4]:
        holds(sol)
    assert history.dissipation.min() > -1e-12 * history.dissipation.max()
    assert force.max() > 0.2
    sliding = [k for k, sol in enumerate(history) if sol.elements["stick"] == 0]
    assert sliding == list(range(sliding[0], 24))
    # directions still turn into that of the shift
    np.testing.assert_allclose(force[sliding], 0.2, rtol=1e-4)


def test_what_histories_refuse(ball):
    law = vc.LinearFalling(0.3, 0.2, 1e-3)
    with pytest.raises(vc.SceneError, match="step 1 does not roll"):
        ball(law, motion=vc.Transient(steps=2, dq=[0.1, 0.0]))
    with pytest.raises(vc.SceneError, match="goes on as it did"):
        vc.solve(ball(law, motion=vc.Transient(steps=2)), start="history")


@pytest.mark.long
def test_laws_that_change_in_time(tmp_path, line, holds):
    """Dry, then wet, then dry again: each step has its own; the same from a scene file, and from
    the history's.
    """
    dry, wet = vc.RationalFalling(0.3, 0.2, half_velocity=0.1), vc.StaticKinetic(0.1, 0.08)
    laws = [None] * 10 + [wet] * 30 + [0.15] * 2 + [None] * 10
    motion = vc.Transient(steps=52, vx=8e-3, friction=laws)
    scene = dataclasses.replace(line(dry, cells=16), surface=DEEP, motion=motion)
    history = vc.solve(scene, store=tmp_path / "history.nc")
    for k in (9, 39, 51):
        holds(history[k])
    assert history[39].scene.friction == wet
    assert history[40].branch == ""
    assert history[41].friction is None
    force = -history.force[:, 0] / 1e-3
    assert force[39] == pytest.approx(0.08, rel=1e-9)
    assert force[9] > 1.5 * force[39]
    rest = dataclasses.replace(scene, motion=vc.Transient(steps=10, vx=8e-3, start=history[41]))
    last = vc.solve(rest)[9]
    np.testing.assert_allclose(
        last.traction, history[51].traction, atol=1e-10 * history[51].pressure.max()
    )
    back = vc.load(tmp_path / "history.nc")
    assert back.scene.motion.friction == tuple(laws)
    np.testing.assert_array_equal(back[39].friction, history[39].friction)
    again = scene_from(scene_to(scene))
    assert again.motion.friction == tuple(laws)


@pytest.mark.parametrize("friction", [0.2, vc.StaticKinetic(0.3, 0.2)])
def test_start_from_another_grid(friction, line, holds):
    coarse = vc.solve(line(friction, cells=20), **({} if friction == 0.2 else {"start": "slip"}))
    motion = vc.Transient(steps=1, vx=3e-3, start=coarse, interpolate=True)
    fine = vc.solve(
        dataclasses.replace(line(vc.StaticKinetic(0.3, 0.2), cells=40), surface=DEEP, motion=motion)
    )[0]
    holds(fine)
    assert fine.branch == "history"
    steady = vc.solve(line(0.2, cells=40))
    assert -fine.force[0] == pytest.approx(-steady.force[0], rel=0.02)


def test_unlike_bodies(ball, holds):
    law = vc.StaticKinetic(0.3, 0.2)
    bodies = vc.Bodies(G=(1.0, 0.4), nu=(0.28, 0.2))
    history = vc.solve(ball(law, bodies=bodies, motion=vc.Transient(steps=3, vx=3e-3)))
    for sol in history:
        holds(sol)
        assert sol.certificate.residual < 1e-8
    assert history.dissipation.min() > 0
