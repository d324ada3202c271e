"""Histories under laws of friction: memory of particles, laws that change in time, files."""

import dataclasses

import numpy as np
import pytest

import varcontact as vc
from varcontact.io.scene_toml import scene_from, scene_to

DEEP = vc.Cylinders(R=1.0, reference_depth=1.0)


def test_history_of_one_coefficient(line):
    motion = vc.Transient(steps=4, dq=[0.0, 0.01, 0.01, 0.01], Fx=-1.2e-4)
    plain, law = (vc.solve(dataclasses.replace(line(f), motion=motion)) for f in (0.2, vc.StaticKinetic(0.2, 0.2)))
    for one, other in zip(plain, law, strict=True):
        np.testing.assert_allclose(other.traction, one.traction, atol=1e-12 * one.traction_bound.max())
    assert [sol.branch for sol in law] == ["stick", "history", "history", "history"]


@pytest.mark.parametrize("law", [vc.ExponentialFalling(0.3, 0.2, 0.1), vc.StaticKinetic(0.2, 0.2)])
def test_long_history_is_steady(law, tmp_path, line, holds):
    """And read from its file it goes on as if nothing had happened."""
    steady = vc.solve(line(law, Fx=-1.5e-4))
    scene = dataclasses.replace(line(law), motion=vc.Transient(steps=100, Fx=-1.5e-4))
    history = vc.solve(scene, store=tmp_path / "history.nc")
    for sol in history[::25]:
        holds(sol)
    np.testing.assert_allclose(history[-1].traction, steady.traction, atol=1e-6 * steady.traction_bound.max())
    assert vc.load(tmp_path / "history.nc")[-1].branch == "history"


def test_who_slips_goes_on_slipping(ball, holds):
    """In small steps of a shift, friction rises to the static bound, falls to the kinetic one, and stays there."""
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
    np.testing.assert_allclose(force[sliding], 0.2, rtol=1e-4)  # directions still turn into that of the shift


def test_what_histories_refuse(ball):
    law = vc.LinearFalling(0.3, 0.2, 1e-3)
    with pytest.raises(vc.SceneError, match="step 1 does not roll"):
        ball(law, motion=vc.Transient(steps=2, dq=[0.1, 0.0]))
    with pytest.raises(vc.SceneError, match="goes on as it did"):
        vc.solve(ball(law, motion=vc.Transient(steps=2)), start="slip")


def test_laws_that_change_in_time(tmp_path, line, holds):
    """Dry, then wet, then dry again: each step has its own; the same from a scene file, and from the history's."""
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
    np.testing.assert_allclose(
        vc.solve(rest)[9].traction, history[51].traction, atol=1e-10 * history[51].pressure.max()
    )
    back = vc.load(tmp_path / "history.nc")
    assert back.scene.motion.friction == tuple(laws)
    np.testing.assert_array_equal(back[39].friction, history[39].friction)
    again = scene_from(scene_to(scene))
    assert again.motion.friction == tuple(laws)


@pytest.mark.parametrize("friction", [0.2, vc.StaticKinetic(0.3, 0.2)])
def test_start_from_another_grid(friction, line, holds):
    """Who slips there goes on slipping here."""
    coarse = vc.solve(line(friction, cells=20), **({} if friction == 0.2 else {"start": "slip"}))
    motion = vc.Transient(steps=1, vx=3e-3, start=coarse, interpolate=True)
    fine = vc.solve(dataclasses.replace(line(vc.StaticKinetic(0.3, 0.2), cells=40), surface=DEEP, motion=motion))[0]
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
