"""Accuracies under laws of friction: the continuum's solution, to which what the static coefficient
adds vanishes.
"""

from dataclasses import replace

import numpy as np
import pytest

import varcontact as vc
from tests.scenes import refused
from varcontact.reference import carter, line_contact

BODIES = vc.Bodies(G=1.0, nu=0.28)
BOTH = vc.StaticKinetic(static=0.3, kinetic=0.09)
BALL = vc.Scene(bodies=BODIES, surface=vc.Ellipse(a=1.2, b=0.8), normal_force=1.0, friction=BOTH)
ROLLING = replace(BALL, motion=vc.Steady(vx=0.03, vy=-0.02, spin=0.05))
FORCE = 1e-3
HALF = line_contact(1.0, BODIES, force=FORCE).a


def line(friction, creepage, **changes):
    """Cylinders that roll, with a part of the creepage at which Carter's slip all over under
    0.3.
    """
    motion = vc.Steady(vx=creepage * 0.3 * HALF)
    cylinders = vc.Cylinders(1.0, reference_depth=10.0)
    scene = vc.Scene(
        bodies=BODIES, surface=cylinders, normal_force=FORCE, friction=friction, motion=motion
    )
    return replace(scene, **changes)


@pytest.mark.long
@pytest.mark.parametrize("start", ["stick", "slip"])
def test_what_the_static_coefficient_adds_vanishes_with_the_elements(start):
    """Of first order: the force tends to Carter's for the kinetic coefficient, from both starts."""
    exact = carter(line_contact(1.0, BODIES, force=FORCE), 0.09, creepage=0.06 * HALF).force
    cells = np.array([128, 256, 512])
    scenes = [line(BOTH, 0.2, grid=vc.Grid(nx=n)) for n in cells]
    beyond = [abs(vc.solve(scene, certify=None, start=start).force[0] - exact) for scene in scenes]
    order = -np.polyfit(np.log(cells), np.log(beyond), 1)[0]
    assert 0.8 < order < 2.2
    assert beyond[-1] < 0.003 * 0.3 * FORCE


@pytest.mark.parametrize("accuracy", [0.1, 0.001])
@pytest.mark.parametrize("part", [0.3, 0.7])
def test_carters_force_is_that_of_the_kinetic_coefficient(accuracy, part):
    exact = carter(line_contact(1.0, BODIES, force=FORCE), 0.09, creepage=part * 0.09 * HALF).force
    sol = vc.solve(line(BOTH, 0.3 * part), accuracy=accuracy)
    assert abs(sol.force[0] - exact) <= accuracy * 0.09 * FORCE
    assert sol.branch == "slip" and sol.certificate.residual < 1e-8


@pytest.mark.parametrize("distance", [2e-3, 6e-3])
def test_the_force_under_a_law_with_a_memory_is_within_its_bar(distance):
    """Its error is of first order: behind the leading edge friction falls within an element."""
    law = vc.StaticKinetic(0.4, 0.2, memory_distance=distance)
    scene = vc.Scene(
        bodies=vc.Bodies(G=82e3, nu=0.28),
        surface=vc.Paraboloids(200.0, 150.0),
        normal_force=1e4,
        friction=law,
        motion=vc.Steady(vx=4e-3, vy=2e-3),
    )
    sol = vc.solve(scene, accuracy=0.01)
    fine = vc.solve(replace(scene, grid=vc.Grid(nx=75, ny=75)), certify=None, start=sol.branch)
    assert abs(sol.Fx - fine.Fx) < sol.error_estimate.bars["Fx"] < 0.02 * 0.4 * 1e4


@pytest.mark.parametrize("changes", [
    {},
    {"motion": vc.Shift(ux=0.03, rotation=0.02)},
    {"bodies": vc.Bodies(G=(1.0, 3.0), nu=(0.3, 0.2)), "surface": vc.Paraboloids(1.3, 0.8), "normal_force": 1e-2},
    {"motion": vc.Transient(steps=3, dq=0.3, vx=[0.04, -0.05, 0.02], normal_force=[1.0, 0.7, 0.9])},
], ids=["steady", "shift", "unlike", "history"])  # fmt: skip
def test_answers_are_those_of_the_kinetic_coefficient(changes):
    scene = replace(ROLLING, **changes)
    both, one = (vc.solve(replace(scene, friction=f), accuracy=0.03) for f in (BOTH, 0.09))
    found, expected = both.error_estimate.values, one.error_estimate.values
    assert found == pytest.approx(expected, abs=0.03 * 0.3 * scene.normal_force)
    for sol in both if isinstance(both, vc.History) else [both]:
        assert np.all(np.hypot(*sol.traction) <= 0.09 * sol.pressure * (1 + 1e-6))
        assert sol.certificate.residual < 1e-8


@pytest.mark.long
@pytest.mark.parametrize(("law", "creepage"), [
    (vc.RationalFalling(0.3, 0.12, half_velocity=0.0377 * 0.3 * HALF), 0.37),
    (vc.ExponentialFalling(0.3, 0.14, half_velocity=0.0019 * 0.3 * HALF), 0.46),
    (vc.ExponentialFalling(0.3, 0.21, half_velocity=0.0066 * 0.3 * HALF), 0.59),
])  # fmt: skip
@pytest.mark.parametrize("accuracy", [0.03, 0.003])
def test_steep_falls_are_met_before_the_elements_resolve_them(law, creepage, accuracy):
    """From the static coefficient the first was 2.7 times as far off as asked for, the second 2.9
    times.
    """
    scenes = [line(law, creepage, grid=vc.Grid(nx=n)) for n in (512, 1024)]
    coarse, fine = (vc.solve(scene, certify=None, start="slip").force[0] for scene in scenes)
    sol = vc.solve(line(law, creepage), accuracy=accuracy)
    assert abs(sol.force[0] - (2 * fine - coarse)) <= accuracy * 0.3 * FORCE


def test_a_start_from_stick_is_refused_where_it_is_not_the_continuums():
    refused(
        lambda: vc.solve(ROLLING, accuracy=0.01, start="stick"),
        "start",
        match="vanishes as the grid gets finer",
    )
    falling = replace(ROLLING, friction=vc.RationalFalling(0.3, 0.2, half_velocity=0.1))
    assert vc.solve(falling, accuracy=0.03, start="stick").branch == "stick"
