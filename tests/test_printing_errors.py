"""Printing errors of the paper that docs/printing_errors.md derives, held against numbers."""

import numpy as np
import pytest

import varcontact as vc
from varcontact.elasticity.subsurface import field_at


def test_longitudinal_creepage_of_a_wheel_set():
    """(136), (137) lack a factor 1/2: against the velocity of the wheel where it touches, and in
    Klingel's motion.
    """
    V, omega, b, gamma = 20.0, 39.0, 0.75, 0.05
    mean, y, turning = 0.5, 0.004, 0.03
    left, right = mean + gamma * y, mean - gamma * y
    rotation = np.array([0.0, omega, turning])
    for side, radius in ((1, left), (-1, right)):
        place = np.array([0.0, side * b, -radius])
        velocity = np.array([V, 0.0, 0.0]) + np.cross(rotation, place)
        creepage = (-side * omega * (left - right) / 2 - side * turning * b + V - omega * mean) / V
        assert velocity[0] / V == pytest.approx(creepage, rel=1e-12)
        printed = (-side * omega * (left - right) - side * turning * b + V - omega * mean) / V
        assert printed - creepage == pytest.approx(-side * omega * gamma * y / V, rel=1e-9)
    klingel = -omega * gamma * y / b  # the turning without slip, V = omega mean
    assert -omega * (left - right) / 2 - klingel * b == pytest.approx(0.0, abs=1e-15)


def test_spin_pole():
    """6.3.1: rigid slip vanishes at (-vy/spin, vx/spin); at the printed opposite point it is twice
    the creepage.
    """
    motion = vc.Steady(vx=0.04, vy=-0.02, spin=0.1, spin_offset=0.0).step(1.0)
    pole = np.array([-motion.vy, motion.vx]) / motion.spin
    assert motion.shift(*pole) == pytest.approx([0.0, 0.0], abs=1e-16)
    assert motion.shift(*-pole) == pytest.approx([2 * motion.vx, 2 * motion.vy], rel=1e-12)


def test_decay_of_stress_with_depth():
    """6.3.2: 8.0 and 1.7 % of the largest at a depth of 3 sides, 3.0 and 0.63 % at 5, not 10, 2.5,
    1 and 0.25 %.
    """
    nu, depths = 0.28, np.array([*np.linspace(0.0, 1.0, 401), 3.0, 5.0])
    points = np.array([0 * depths, 0 * depths, depths])
    square = vc.Grid(nx=1, ny=1, dx=1.0, dy=1.0, x0=-0.5, y0=-0.5)
    field = field_at(points, square, np.reshape([0.0, 0.0, 1.0], (3, 1, 1)), G=1.0, nu=nu)
    stress = vc.SubsurfaceStress(1, points, field.displacement, field.gradient, field.stress)
    ideal, invariant = stress.ideal_stress, -stress.first_invariant
    assert ideal[-2:] / ideal.max() == pytest.approx([0.080, 0.030], abs=5e-4)
    assert invariant[-2:] / invariant.max() == pytest.approx([0.0172, 0.0063], abs=5e-5)
    far = np.pi * depths[-2:] ** 2
    axial, radial = -1.5 / far, (1 - 2 * nu) / 4 / far
    assert invariant[-2:] == pytest.approx(-(axial + 2 * radial), rel=0.03)
    assert ideal[-2:] == pytest.approx(np.sqrt(2 / 3) * (radial - axial), rel=0.06)
