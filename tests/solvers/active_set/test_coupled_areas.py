"""Pressure and tractions of unlike bodies together, by active sets."""

import math
from dataclasses import replace

import numpy as np
import pytest

import varcontact as vc
from varcontact.solvers.active_set import coupled

BALL = {"surface": vc.Paraboloids(1.0, 0.7), "normal_force": 1.0}
ROLLER = {
    "surface": vc.Cylinders(R=5.0, reference_depth=10.0),
    "normal_force": 1.0,
    "grid": vc.Grid(nx=40),
}
UNLIKE = vc.Bodies(G=(1.0, 6.0), nu=(0.1, 0.35))
MOTIONS = [
    vc.Steady(vx=2e-3, vy=1e-3),
    vc.Steady(Fx=-0.1, vy=5e-4),
    vc.Shift(ux=5e-3, uy=-2e-3),
    vc.Shift(Fx=0.1, Fy=0.05),
]


def scene(where, motion, cells=9):
    given = {"grid": vc.Grid(nx=cells, ny=cells - 1)} | where
    return vc.Scene(bodies=UNLIKE, friction=0.25, motion=motion, **given)


def close(found, expected, tol):
    for name in ("pressure", "traction"):
        one, two = getattr(found, name), getattr(expected, name)
        np.testing.assert_allclose(one, two, atol=tol * np.abs(two).max())
    np.testing.assert_allclose(found.creepage, expected.creepage, rtol=1e-7, atol=1e-12)


@pytest.mark.parametrize("motion", MOTIONS, ids=repr)
@pytest.mark.parametrize("where", [BALL, ROLLER], ids=["ball", "roller"])
def test_the_answer_is_that_of_alternating_passes(where, motion):
    """Found by Newton steps alone: no pass follows them."""
    posed = scene(where, motion)
    sol = vc.solve(posed)
    assert sol.plan.coupling == "active-set"
    assert sol.passes == ((1.0, sol.passes[0][1]),)
    assert sol.calls["both"]["active-set"].iterations <= 8
    assert sol.certificate.residual < 1e-9
    close(sol, vc.solve(posed, coupling="panagiotopoulos", tol=1e-10), 1e-8)


STRONGLY_COUPLED = [
    (vc.Bodies(G=(math.inf, 7.0), nu=(0.49, 0.0)), 3.5, 0.7, vc.Shift(Fx=-0.3, Fy=0.09), 97),
    (vc.Bodies(G=(math.inf, 2.0), nu=(0.0, 0.1)), 80.0, 1.1, vc.Steady(Fx=0.86), 53),
    (vc.Bodies(G=(54.0, 0.02), nu=0.0), 5.0, 1.1, vc.Steady(vx=0.028), 99),
]


@pytest.mark.parametrize(("bodies", "radius", "friction", "motion", "cells"), STRONGLY_COUPLED)
def test_strong_coupling_under_much_friction_needs_no_pass(bodies, radius, friction, motion, cells):
    """The contact that tractions move is found from that without them."""
    sol = vc.solve(
        vc.Scene(
            bodies=bodies,
            surface=vc.Cylinders(R=radius),
            normal_force=1.0,
            friction=friction,
            motion=motion,
            grid=vc.Grid(nx=cells),
        ),
        coupling="active-set",
    )
    assert len(sol.passes) == 1
    assert sol.certificate.residual < 1e-9


@pytest.mark.parametrize("motion", MOTIONS, ids=repr)
def test_in_the_plane_as_by_the_method_without_a_matrix(motion):
    posed = scene(BALL, motion, cells=14)
    close(vc.solve(posed, coupling="active-set"), vc.solve(posed, coupling="newton"), 1e-7)


def test_one_step_on_the_right_areas_is_exact_in_line_contact(monkeypatch):
    """There the equations are linear: from an answer to three digits, one step."""
    steps = []
    search = coupled._line_search

    def followed(iterate):
        after = search(iterate)
        steps.append((iterate.merit, after.merit))
        return after

    monkeypatch.setattr(coupled, "_line_search", followed)
    vc.solve(scene(ROLLER, vc.Steady(vx=2e-3)))
    before, after = steps[-1]
    assert after < 1e-9 * before


def test_passes_follow_where_it_gives_up(monkeypatch):
    posed = scene(ROLLER, vc.Steady(vx=2e-3))
    expected = vc.solve(posed)
    monkeypatch.setattr(coupled, "MAX_STEPS", 0)
    sol = vc.solve(posed)
    assert len(sol.passes) > 3
    close(sol, expected, 1e-7)


def test_it_is_refused_with_other_solvers():
    with pytest.raises(vc.SceneError, match='needs "norm" and "tang-safeguarded"') as refused:
        vc.solve(scene(BALL, MOTIONS[0]), coupling="active-set", normal="clarabel")
    assert refused.value.field == "coupling"


def test_bodies_apart_have_no_step(monkeypatch):
    """Iterates that leave the contact altogether end the steps, and are no answer."""
    posed = []
    solve = coupled.active_set_coupled

    def kept(problem, *rest):
        posed.append((problem, *rest))
        return solve(problem, *rest)

    monkeypatch.setattr(coupled, "active_set_coupled", kept)
    vc.solve(scene(ROLLER, vc.Steady(vx=2e-3)))
    problem, settings, start, residual = posed[0]
    apart = replace(problem, distance=problem.distance + 1e3, approach=0.0, force=(None, None))
    raw = solve(apart, settings, start, residual)
    assert (raw.solved, raw.iterations) == (False, 2)
