"""Refusals that no other test meets: the field, and what is wrong or to do instead."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import varcontact as vc
from varcontact import reference
from varcontact.energy import posed
from varcontact.theories import linear_creepage

BODIES = vc.Bodies(G=1.0, nu=0.3)
BALL = vc.Paraboloids(1.0, 1.0)
SCENE = vc.Scene(
    bodies=BODIES, surface=BALL, normal_force=1.0, friction=0.3, motion=vc.Steady(vx=0.01), grid=vc.Grid(nx=6, ny=6)
)
UNLIKE = vc.Bodies(G=(1.0, 3.0), nu=(0.3, 0.2))
SQUARE = vc.Grid(nx=3, ny=3, dx=1.0, dy=1.0, x0=-1.5, y0=-1.5)
BOWL = vc.SampledDistance(np.array([[0.5, 0.2, 0.5], [0.2, 0.0, 0.2], [0.5, 0.2, 0.5]]))
AXIS = np.array([-1.0, 0.0, 1.0])
FORCED = vc.Transient(steps=2, dq=0.1, normal_force=[1.0, None])
COUPLED = reference.line_contact(1.0, UNLIKE, a=0.1)
COEFFICIENTS = reference.creepage_coefficients(1.0, 1.0, 0.3)


def scene(**changes):
    return replace(SCENE, **changes)


def certified(traction, **changes):
    return vc.certify(scene(**changes), np.zeros(traction))


MESSAGES = [
    (lambda: vc.Grid(nx=3, ny=3, dx=1.0), "grid.dy", "come together"),
    (lambda: vc.Grid(nx=3, dy=1.0), "grid.dy", "without ny it is line contact"),
    (lambda: vc.Grid(nx=3, ny=3).x, "grid", "only such a grid has positions"),
    (lambda: vc.Transient(steps=2, surface=[BALL]), "motion.surface", "one surface for each of the 2 steps"),
    (lambda: vc.Transient(steps=2, surface=[BALL, vc.Cylinders(1.0)]), "motion.surface[1]", "in all steps or in none"),
    (lambda: vc.Paraboloids.from_bodies(Rx=(1.0, -0.5), Ry=(1.0, 1.0)), "surface.Rx", "positive sum of curvatures"),
    (lambda: vc.SampledDistance(np.zeros((3, 3)), x=AXIS), "surface.x, surface.y", "both or neither"),
    (lambda: vc.SampledDistance(np.ones((3, 3)), reference_depth=3.0), "surface.reference_depth", "only line contact"),
    (lambda: vc.SampledDistance(np.eye(3), AXIS / 2, AXIS / 2).distance(SQUARE), "grid", "within the samples"),
    (lambda: scene(motion=FORCED, normal_force=None), "", "step 1 has no load"),
    (lambda: scene(motion=replace(FORCED, approach=[0.1, 0.1])), "", "motion.approach[0] are both given"),
    (lambda: scene(surface=BOWL, grid=SQUARE, normal_force=None, approach=-0.5), "approach", "must exceed"),
    (lambda: scene(motion=vc.Transient(steps=1, surface=[vc.Cylinders(1.0)])), "motion.surface", "line contact"),
    (lambda: scene(grid=vc.Grid(nx=8)), "grid.ny", "only line contact has no rows"),
    (lambda: vc.plan(scene(surface=BOWL, grid=SQUARE), normal="hertz"), "", "for paraboloids, ellipses and cylinders"),
    (lambda: vc.plan(scene(surface=BOWL, grid=replace(SQUARE, edge="touched"))), "", "samples without coordinates"),
    (lambda: vc.plan(scene(), tangential="tang", formulation="gap"), "formulation", "does not solve a program"),
    (lambda: vc.plan(scene(), tangential="fastsim", formulation="gap"), "formulation", "no program is solved"),
    (lambda: vc.plan(scene(bodies=UNLIKE), tangential="fastsim"), "tangential", "quasi-identical"),
    (lambda: vc.plan(scene(motion=vc.TimeStep(dq=0.1))), "motion", "as a Transient"),
    (lambda: vc.solve(scene(), store="history.nc"), "store", "only a history"),
    (lambda: vc.solve(scene(), polish=True, method="convex"), "polish", "no active sets"),
    (lambda: vc.solve(scene(grid=replace(SQUARE, dx=0.1, dy=0.1, x0=5.0))), "grid", "does not contain the contact"),
    (lambda: certified((2, 3, 4), motion=vc.Steady(Fx=0.1)), "motion", "no prescribed force"),
    (lambda: certified((2, 8, 8), surface=BOWL, grid=vc.Grid(nx=8, ny=8)), "grid", "as surface.h is given on it"),
    (lambda: certified((2, 6, 6), surface=replace(BOWL, x=AXIS, y=AXIS)), "grid", "give its dx, dy, x0 and y0"),
    (lambda: certified((2, 4, 3), grid=SQUARE), "traction", "must be of shape (2, 3, 3)"),
    (lambda: vc.compare(scene(), ["convex+polish"]), "methods", "only a program solver called by name"),
    (lambda: vc.compare({1: scene()}, ["tang"]), "scenes", "named by strings"),
    (lambda: vc.converge(scene(motion=vc.Transient(steps=1, dq=0.1)), [8, 16]), "motion", "not on a history"),
    (lambda: vc.converge(scene(surface=BOWL, grid=SQUARE), [8, 16]), "surface.x", "fit one grid only"),
    (lambda: vc.converge(scene(), [8, 16], method=[]), "method", "at least one name"),
    (lambda: vc.scan(scene(motion=None), [(0.0, 0.0, 0.0)]), "motion", "a scan sets the creepages"),
    (lambda: vc.scan(scene(), [0.1, 0.2, 0.3]), "creepages", "a single solution is [[vx, vy, spin]]"),
    (lambda: vc.stress(vc.solve(scene()), [0.0, 1.0]), "points", "(3, ...)"),
    (lambda: vc.stress_below(vc.solve(scene()), []), "depths", "a number or several"),
    (lambda: vc.solve(scene()).plot_passes(), "solution", "no passes to plot"),
    (lambda: vc.solve(scene(motion=None)).sensitivity(), "motion", "no creepage"),
    (lambda: vc.solve(scene(), tangential="fastsim").sensitivity(), "solution", "an exact method"),
    (lambda: posed(vc.solve(scene(motion=vc.Transient(steps=1, dq=0.1)))[0]), "solution", "a step of a history"),
    (lambda: reference.carter(reference.line_contact(1.0, BODIES, a=0.1), 0.3), "", "neither creepage nor force"),
    (lambda: reference.carter(COUPLED, 0.3, creepage=0.01), "bodies.K", "like bodies"),
    (lambda: reference.bufler(1.0, BODIES, force=1.0, a=1.0), "", "force and a are both given"),
    (lambda: reference.line_contact(1.0, BODIES), "", "exactly one of force, a and approach"),
    (lambda: reference.line_contact(1.0, BODIES, approach=0.1), "depth", "measured from a depth"),
    (lambda: reference.hertz_ellipse(1.0, 1.0, BODIES), "", "neither force nor approach"),
    (lambda: linear_creepage(1.0, 1.0, 1.0, COEFFICIENTS, vx=0.1, Fx=2.0), "", "vx and Fx are both given"),
]  # fmt: skip


@pytest.mark.parametrize(("act", "field", "words"), MESSAGES)
def test_message(act, field, words):
    with pytest.raises(vc.SceneError) as refused:
        act()
    assert words in str(refused.value)
    assert not field or refused.value.field == field


def test_refusals_keep_their_parts():
    """A sentence of its own does not hide the field, the value and what would have been allowed."""
    with pytest.raises(vc.SceneError) as refused:
        vc.plan(scene(), formulation="potential")
    assert (refused.value.field, refused.value.value) == ("formulation", "potential")
    assert refused.value.allowed == '"gap" or "marching"'
