"""FASTSIM under laws of friction: closed form, limits, and what the paper says of it."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import quad

import varcontact as vc
from tests.scenes import make_scene
from varcontact.theories import fastsim_field, fastsim_under_law, flexibility

TABLE = vc.reference.creepage_coefficients(1.0, 1.0, 0.25)
A = B = G = 1.0
FZ = 10.0


def field(law, creepage=(1.0, 0.0, 0.0), **options):
    return fastsim_under_law(A, B, G, FZ, law, creepage, TABLE, **options)


def closed_form(v, static, kinetic):
    """Force of the simplified theory: stick from the leading edge to the static bound, the kinetic
    bound behind.
    """
    L = float(flexibility(A, B, G, (v, 0.0, 0.0), TABLE))
    peak = 2 * FZ / (np.pi * A * B)

    def strip(y):
        c = A * np.sqrt(1 - (y / B) ** 2)
        front = min(v * A**2 / (L * static * peak) - c, c)
        behind = kinetic * peak / A**2 * (c**2 * front - front**3 / 3 + 2 * c**3 / 3)
        return v * (c - front) ** 2 / (2 * L) + behind

    return quad(strip, -B, B, limit=200)[0]


@pytest.mark.long
@pytest.mark.parametrize("v", [0.3, 0.8, 2.0])
def test_closed_form(v):
    """The error goes down with the number of points, to the first order or better."""
    law = vc.StaticKinetic(0.36, 0.3)
    errors = [
        abs(-field(law, (v, 0.0, 0.0), m=m, n=m).force[0] / closed_form(v, 0.36, 0.3) - 1)
        for m in (20, 60, 180)
    ]
    assert errors[2] < 2e-3
    assert np.log(errors[0] / errors[2]) / np.log(9) > 0.9


@pytest.mark.parametrize("creepage", [(0.7, 0.2, 0.0), (0.2, -0.5, 0.8)])
@pytest.mark.parametrize("bound", ["parabolic", "elliptic"])
@pytest.mark.parametrize("flexibility", ["separate", "weighted"])
def test_limits(creepage, bound, flexibility):
    """One coefficient is plain FASTSIM; so is the kinetic one, from slip."""
    options = {"m": 20, "n": 15, "bound": bound, "flexibility": flexibility}
    plain = fastsim_field(A, B, G, 0.3 * FZ, creepage, TABLE, **options)
    for law, start in (
        (vc.StaticKinetic(0.3, 0.3), "stick"),
        (vc.ExponentialFalling(0.3, 0.3, 1.0), "stick"),
        (vc.StaticKinetic(0.4, 0.3), "slip"),
        (vc.LinearFalling(0.3, 0.1, 1e12), "stick"),
    ):
        found = field(law, creepage, **options, start=start)
        np.testing.assert_allclose(found.traction, plain.traction, atol=1e-9)
        np.testing.assert_array_equal(found.state, plain.state)
        np.testing.assert_allclose(found.slip, plain.slip, atol=1e-9)


@pytest.mark.parametrize("law", [vc.LinearFalling, vc.RationalFalling, vc.ExponentialFalling])
@pytest.mark.parametrize("start", ["stick", "slip"])
@pytest.mark.parametrize("flexibility", ["separate", "weighted"])
def test_law_holds_at_every_point(law, start, flexibility):
    friction = law(0.4, 0.2, half_velocity=0.5)
    found = field(friction, (0.6, 0.3, 0.5), m=30, n=10, start=start, flexibility=flexibility)
    size, slip = np.hypot(*found.traction), np.hypot(*found.slip)
    x = found.x / A
    pressure = 2 * FZ / (np.pi * A * B) * (1 - x**2 - (found.y[:, None] / B) ** 2)
    slips = found.state == 2
    assert slips.any()
    assert not slips.all()
    np.testing.assert_allclose(size[slips], (friction(slip) * pressure)[slips], rtol=1e-9)
    assert np.all(size[~slips] <= 0.4 * pressure[~slips] * (1 + 1e-12))
    np.testing.assert_allclose(np.sum(found.traction * found.slip, axis=0), -size * slip, atol=1e-9)


@pytest.mark.parametrize(
    "name", ["fastsim", "fastsim-elliptic", "fastsim-weighted", "fastsim-weighted-elliptic"]
)
def test_as_a_method(name):
    """On the grid of a scene: from slip it is FASTSIM for the kinetic coefficient."""
    round_contact = {"bodies": vc.Bodies(G=1.0, nu=0.25), "motion": vc.Steady(vx=0.1, spin=0.05)}
    posed = make_scene(vc.Ellipse(a=1.0, b=1.0), grid=vc.Grid(nx=16, ny=16), **round_contact)
    scene = replace(posed, friction=vc.StaticKinetic(0.36, 0.3))
    plain = vc.solve(posed, tangential=name)
    slip, stick = (vc.solve(scene, tangential=name, start=start) for start in ("slip", "stick"))
    np.testing.assert_allclose(slip.traction, plain.traction, atol=1e-13)
    assert -stick.force[0] >= -slip.force[0]
    assert stick.branch == "stick"


def test_separate_flexibilities_are_those_of_more_than_one_creepage():
    """The same field where one creepage acts alone, whatever the law; not where two do."""
    law, kinds = vc.LinearFalling(0.4, 0.2, half_velocity=0.5), ("separate", "weighted")
    for creepage in ((0.6, 0.0, 0.0), (0.0, 0.6, 0.0), (0.0, 0.0, 0.9)):
        one, other = (field(law, creepage, flexibility=kind) for kind in kinds)
        np.testing.assert_allclose(one.traction, other.traction, atol=1e-12)
        np.testing.assert_allclose(one.slip, other.slip, atol=1e-12)
    one, other = (field(law, (0.6, 0.6, 0.0), flexibility=kind).force for kind in kinds)
    assert np.hypot(*(one - other)) > 0.05 * 0.4 * FZ
    with pytest.raises(vc.SceneError, match=r"flexibility = 'one' .*separate, weighted"):
        field(law, flexibility="one")
