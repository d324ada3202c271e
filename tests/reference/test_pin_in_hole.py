"""Persson's pin in a hole: equilibrium by quadrature, Hertz's limit, and the neat fit."""

import numpy as np
import pytest
from scipy.integrate import quad

import varcontact as vc
from varcontact.reference import line_contact, pin_in_hole

BODIES = vc.Bodies(G=80e9, nu=0.3)


@pytest.mark.parametrize("clearance", [0.0, 1e-6, 1e-5, 1e-3])
def test_pressures_carry_the_force(clearance):
    pin = pin_in_hole(0.01, clearance, BODIES, force=2e6)
    vertical, _ = quad(
        lambda angle: pin.pressure(angle) * np.cos(angle) * pin.R,
        -pin.half_angle,
        pin.half_angle,
        epsrel=1e-10,
    )
    assert vertical == pytest.approx(2e6, rel=1e-8)
    assert pin.pressure(1.001 * pin.half_angle) == 0
    assert pin.peak_pressure == pin.pressure(0.0)


def test_a_small_angle_is_hertzs_contact():
    """To first order in the square of the angle."""
    off = []
    for force in (1e3, 1e4):
        pin = pin_in_hole(0.01, 1e-4, BODIES, force=force)
        hertz = line_contact(0.01 * 0.01 / 1e-4, BODIES, force=force)
        off.append(
            (pin.half_angle * 0.01 / hertz.a - 1, pin.peak_pressure / hertz.peak_pressure - 1)
        )
    np.testing.assert_allclose(off[1], 10 * np.array(off[0]), rtol=0.05)
    assert np.abs(off).max() < 2e-3


def test_a_neat_fit_has_one_angle():
    angles = [pin_in_hole(0.01, 0.0, BODIES, force=force).half_angle for force in (1.0, 1e6)]
    b = np.tan(angles[0] / 2)
    assert angles[0] == angles[1]
    assert 2 * (1 - b**4) == pytest.approx(np.log(b**2 + 1), rel=1e-12)


@pytest.mark.parametrize(
    ("field", "change"),
    [
        ("R", {"R": 0.0}),
        ("clearance", {"clearance": -1e-6}),
        ("force", {"force": 0.0}),
        ("force", {"force": 1e-310, "clearance": 1.0}),
    ],
)
def test_bad_input_is_refused(field, change):
    entries = {"R": 0.01, "clearance": 1e-5, "bodies": BODIES, "force": 1e6} | change
    with pytest.raises(vc.SceneError) as error:
        pin_in_hole(**entries)
    assert error.value.field == field
