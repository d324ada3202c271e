"""Cattaneo's shift: force and shift of its traction, by quadrature."""

import numpy as np
import pytest
from scipy.integrate import dblquad, quad

import varcontact as vc
from varcontact.reference import cattaneo_mindlin, hertz


@pytest.mark.parametrize("part", [0.1, 0.657, 0.99])
def test_traction_carries_the_force(part):
    bodies = vc.Bodies(G=2.0, nu=0.3)
    contact = hertz(1.0, 1.0, bodies, force=0.1)
    force = -part * 0.4 * contact.force
    solution = cattaneo_mindlin(contact, bodies, 0.4, force)
    total = (
        2
        * np.pi
        * quad(lambda r: r * float(solution.traction(r, 0.0)), 0, contact.a, points=[solution.stick_radius])[0]
    )
    assert total == pytest.approx(force, rel=1e-7)
    assert solution.shift > 0, "body 1 is shifted against the force that it feels"


def test_shift_is_the_displacement_in_the_middle():
    """In stick, shift + u = 0: u(0, 0) from the traction by (70), in polar coordinates."""
    bodies = vc.Bodies(G=2.0, nu=0.3)
    contact = hertz(1.0, 1.0, bodies, force=0.1)
    solution = cattaneo_mindlin(contact, bodies, 0.4, -0.02)
    u = dblquad(
        lambda r, t: (1 - 0.3 + 0.3 * np.cos(t) ** 2) * float(solution.traction(r, 0.0)) / (np.pi * 2.0),
        0, 2 * np.pi, 0, contact.a, epsabs=1e-9,
    )[0]  # fmt: skip
    assert u == pytest.approx(-solution.shift, rel=1e-6)


def test_saturated():
    bodies = vc.Bodies(G=2.0, nu=0.3)
    contact = hertz(1.0, 1.0, bodies, force=0.1)
    with pytest.raises(vc.Saturated, match=r"0\.04"):
        cattaneo_mindlin(contact, bodies, 0.4, 0.05)
