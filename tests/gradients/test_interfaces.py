"""Gradients under laws of friction, with third bodies and of viscoelastic bodies."""

from dataclasses import replace

import numpy as np
import pytest

import varcontact as vc
from tests.gradients.differences import (
    COATED,
    EXACT,
    LIKE,
    ROLLING,
    UNLIKE,
    check_gradients,
    contact,
    solved,
)
from varcontact.errors import SceneError

FALLING = vc.RationalFalling(0.4, 0.2, half_velocity=1e-3)
COARSE = vc.Grid(nx=10, ny=10, dx=0.28, dy=0.28, x0=-1.4, y0=-1.37)
LAWS = {
    "rational": (FALLING, ("friction.static", "friction.kinetic", "friction.half_velocity")),
    "linear": (vc.LinearFalling(0.4, 0.2, half_velocity=3e-4), ("friction.kinetic",)),
    "exponential": (vc.ExponentialFalling(0.4, 0.2, half_velocity=1e-3), ("friction.static",)),
    "two coefficients": (vc.StaticKinetic(0.4, 0.3), ("friction.kinetic",)),
    "by pressure": (vc.PressureFalling(0.4, 0.1, 1e-3), ("friction.strength",)),
    "shear strength": (vc.ShearStrength(0.3, 1e-3), ("friction.strength",)),
}
LEAVES = vc.ThirdBody(h=0.05, G=0.1)
RELAXING = vc.Viscoelastic(1.0, 0.28, [(1.0, 0.5)])


def coarse(*bodies_and_motion, **more):
    return contact(*bodies_and_motion, grid=COARSE, **more)


@pytest.mark.parametrize("name", LAWS)
def test_parameters_of_a_law(name):
    law, parameters = LAWS[name]
    check_gradients(coarse(friction=law), ("vx", *parameters))


@pytest.mark.long
def test_a_law_beside_a_prescribed_force():
    scene = coarse(friction=FALLING, motion=vc.Steady(Fx=0.003, vy=3e-4, spin=6e-4))
    check_gradients(
        scene, ("normal_force", "friction.half_velocity"), ("vx", "Mz", "friction_work")
    )


@pytest.mark.long
def test_a_law_between_unlike_bodies():
    # by smaller steps the rounding of two solutions is 1e-6 of a small moment
    check_gradients(coarse(UNLIKE, friction=FALLING), ("friction.half_velocity",), step=1e-5)


@pytest.mark.long
def test_a_law_of_a_shift():
    law = vc.RationalFalling(0.4, 0.2, half_velocity=2e-3)
    scene = coarse(friction=law, motion=vc.Shift(ux=4e-3, uy=1e-3))
    check_gradients(scene, ("ux", "friction.half_velocity"))


@pytest.mark.parametrize("bodies", [LIKE, UNLIKE, COATED], ids=["like", "unlike", "coated"])
def test_an_elastic_third_body(bodies):
    scene = coarse(bodies, third_body=LEAVES)
    check_gradients(scene, ("normal_force", "third_body.h", "third_body.G"))


@pytest.mark.long
def test_a_third_body_under_a_law():
    scene = coarse(friction=FALLING, third_body=LEAVES)
    check_gradients(scene, ("third_body.h", "friction.kinetic"))


@pytest.mark.long
@pytest.mark.parametrize(
    "bodies",
    [RELAXING, vc.BodyPair(RELAXING, vc.Bodies(G=2.0, nu=0.3))],
    ids=["like", "unlike"],
)
def test_viscoelastic_bodies_in_steady_rolling(bodies):
    scene = coarse(bodies, replace(ROLLING, speed=2.0))
    check_gradients(scene, ("normal_force", "motion.speed"))


@pytest.mark.long
def test_a_law_on_a_grid_that_follows():
    """By load, against differences of solutions on grids that move with the contact."""
    fine = contact(friction=FALLING, motion=ROLLING.second_order(), grid=vc.Grid(nx=24, ny=24))
    forces = [vc.solve(replace(fine, normal_force=N), certify="none").Fx for N in (0.019, 0.021)]
    expected = (forces[1] - forces[0]) / 0.002
    sol = vc.solve(replace(fine, grid=vc.Grid(nx=16, ny=16)), **EXACT)
    found = float(sol.gradient("Fx", "normal_force").normal_force)
    assert found == pytest.approx(expected, rel=0.03)


@pytest.mark.parametrize(
    ("changes", "field"),
    [
        ({"friction": replace(FALLING, memory_distance=0.5)}, "friction.memory_distance"),
        ({"third_body": replace(LEAVES, tau_c0=5e-4, k_tau=0.01)}, "third_body.tau_c0"),
    ],
)
def test_what_has_a_memory_is_refused(changes, field):
    with pytest.raises(SceneError, match=field):
        vc.solve(contact(**changes), certify="none").gradient("Fx", "vx")


def test_a_law_by_temperature_is_refused():
    scene = contact(
        motion=replace(ROLLING, speed=1.0),
        friction=vc.TemperatureFalling(0.4, 0.2, over=100.0),
        thermal=vc.Thermal(conductivity=1.0, density=1.0, heat_capacity=1.0),
    )
    with pytest.raises(SceneError, match="does not depend on temperature"):
        vc.solve(scene, certify="none").gradient("Fx", "vx")


def test_full_slip_under_a_law_follows_the_mean_slip():
    """Far beyond saturation the slip is the creepage: dF/dvx is that of the law."""
    law = vc.RationalFalling(0.4, 0.2, half_velocity=0.1)
    scene = contact(friction=law, motion=vc.Steady(vx=0.5))
    found = solved(scene).gradient("Fx", ("vx", "friction.kinetic"), edge="held")
    slope = float(law.slope(0.5))
    assert float(found.vx) == pytest.approx(-0.02 * slope, rel=0.02)
    assert float(found["friction.kinetic"]) == pytest.approx(-0.02 * (1 - 1 / 6), rel=0.02)
    assert np.isfinite(float(found.value))
