"""Strip theory and FaStrip: against Carter, the exact theory, on a grid; Polach against simplified
theory.
"""

import numpy as np
import pytest

import varcontact as vc
from varcontact.reference import carter, creepage_coefficients, line_contact
from varcontact.theories import fastrip, polach, simplified_force, strip


def test_without_spin_each_strip_is_carters():
    """Longitudinal creepage: the integral over y of the force of line contacts with Hertz's bound
    in the strip.
    """
    a, b, nu, limit = 0.5, 3.0, 0.28, 0.3
    p0 = 1.5 / (np.pi * a * b)  # Fz = 1
    y = (np.arange(4000) + 0.5) / 2000 - 1
    for vx in (0.02, 0.1, 0.4):
        total = 0.0
        for eta in y[::8]:
            edge = a * np.sqrt(1 - eta**2)
            contact = line_contact(a / (2 * (1 - nu) * p0), vc.Bodies(G=1.0, nu=nu), a=edge)
            total += carter(contact, limit, creepage=vx).force * b * 2 / 500
        found = strip(a, b, 1.0, nu, limit, (vx, 0.0, 0.0), n=100).force
        assert found[0] == pytest.approx(total, rel=1e-3)


def test_lateral_creepage_is_antiplane():
    """The same by vy, with 1 in place of 1 - nu."""
    x, y = (
        strip(1, 2, 1, 0.3, 1, (0.1, 0, 0)).force[0],
        strip(1, 2, 1, 0.3, 1, (0, 0.1 / 0.7, 0)).force[1],
    )
    assert x == pytest.approx(y, rel=1e-12)


@pytest.mark.parametrize(("spin", "away"), [(0.0, 0.02), (0.1, 0.06)])
def test_of_a_wide_contact_both_are_right(rolling, spin, away):
    """a/b = 0.1: within 2 % of f Fz of the exact theory by creepages alone, 6 % with spin."""
    motion = vc.Steady(vx=0.15, vy=0.1, spin=spin)
    surface, bodies = vc.Ellipse(0.3, 3.0), vc.Bodies(G=1.0, nu=0.0)
    scene = rolling(
        bodies=bodies, surface=surface, motion=motion, grid=vc.Grid(nx=40, ny=40), friction=0.3
    )
    limit = 0.3 * vc.solve(scene, certify=None).normal_force
    exact = vc.solve(scene, tangential="newton").force
    creepage = (0.15, 0.1, spin)
    np.testing.assert_allclose(
        strip(0.3, 3.0, 1.0, 0.0, limit, creepage).force, exact, atol=away * limit
    )
    table = creepage_coefficients(0.3, 3.0, 0.0)
    np.testing.assert_allclose(
        fastrip(0.3, 3.0, 1.0, limit, creepage, table).force, exact, atol=away * limit
    )


@pytest.mark.parametrize("name", ["strip", "fastrip", "polach"])
def test_on_a_grid(rolling, name):
    """`solve` by name: tractions within the bound, whose sums tend to the forces of the
    functions.
    """
    motion = vc.Steady(vx=0.1, vy=-0.05, spin=0.1)
    scene = rolling(
        surface=vc.Ellipse(1.2, 0.8), motion=motion, grid=vc.Grid(nx=80, ny=80), friction=0.3
    )
    sol = vc.solve(scene, tangential=name, certify=None)
    bodies = scene.bodies
    found = vc.creep_forces(
        name, a=1.2, b=0.8, bodies=bodies, normal_force=sol.normal_force, friction=0.3, vx=0.1, vy=-0.05, spin=0.1,
        **({} if name == "polach" else {"m": 80, "n": 40}),
    )  # fmt: skip
    limit = 0.3 * sol.normal_force
    np.testing.assert_allclose(
        sol.force, [found.Fx, found.Fy], atol=5e-3 * limit if name != "polach" else 1e-9 * limit
    )
    if name != "polach":
        assert np.all(np.hypot(*sol.traction) <= sol.traction_bound * (1 + 1e-9))
        assert sol.moment == pytest.approx(found.Mz, abs=5e-3 * limit)
    assert sol.elements["stick"] > 100
    assert sol.elements["slip"] > 100


def test_polach_without_spin_is_simplified_theory():
    """Under the elliptic bound, with L = 8 a/(3 G c): another route to the same closed form."""
    table = creepage_coefficients(1.2, 0.8, 0.28)
    for vx in (0.01, 0.1, 1.0):
        L = 8 * 1.2 / (3 * table.C11)
        expected = simplified_force(1.2, 0.8, L, 0.3, vx, 0.0, "elliptic")
        np.testing.assert_allclose(
            polach(1.2, 0.8, 1.0, 0.3, (vx, 0.0, 0.0), table), expected, rtol=1e-12, atol=1e-15
        )


def test_polach_pure_spin_rises_and_falls():
    """Kalker's slope first, and no lateral force at all by a large spin."""
    table = creepage_coefficients(1.0, 1.0, 0.28)
    spins = np.array([1e-9, 0.1, 0.4, 1e3])
    Fy = polach(1.0, 1.0, 1.0, 0.3, np.stack([0 * spins, 0 * spins, spins], axis=-1), table)[:, 1]
    assert Fy[0] == pytest.approx(-table.C23 * 1e-9, rel=1e-6)
    assert Fy[2] < Fy[1] < Fy[0] < 0
    assert abs(Fy[3]) < 1e-4
