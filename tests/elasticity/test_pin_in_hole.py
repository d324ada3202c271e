"""Influence numbers of a disc in a hole of a plate against Kolosov's series, half-planes and
rigid motions.
"""

import numpy as np
import pytest

import varcontact as vc
from varcontact.elasticity.halfspace import HalfSpaces
from varcontact.elasticity.pin_in_hole import PinInHoleMedium
from varcontact.scene.grid import Grid

G, NU = (1.5, 0.75), (0.3, 0.2)
DIFFERENCE = ((0.0, 1.0), (0.07, -1.0))


def of_series(angle, tangential, side):
    """u_r + i u_theta at an angle by N or T = 1 over a side around 0, both radii 1, depth 2."""
    load = 1j if tangential else 1.0 + 0j
    c1, c2 = 0.5 / np.array(G)
    kappa1, kappa2 = 3 - 4 * np.array(NU)
    k = np.arange(1, 40_001)
    parts = np.sinc(k * side / (2 * np.pi)) * side / (2 * np.pi)
    s = np.exp(1j * angle)
    forward = (parts * s**k / (k + 1)).sum()
    backward = (parts[1:] * s ** (-k[1:].astype(float)) / (k[1:] - 1)).sum()
    inner = c1 * kappa1 + c2
    outer = c1 + c2 * kappa2
    total = load * (inner * forward + outer * backward)
    total += (c1 * (kappa1 - 1) / 2 + c2) * side / (2 * np.pi) * load.real
    total -= c1 * np.conj(load) * parts[0] * (s + 1 / s)
    return total + load * parts[0] / s * np.log(2) * (inner + outer)


def test_numbers_are_sums_of_kolosovs_series():
    grid = Grid(nx=9, dx=2 * np.pi / 9, x0=0.0)
    table = PinInHoleMedium(1.0, G, NU, 2.0).operator(grid, "xz", "xz").table[:, :, 0]
    for offset in (-8, 0, 1):
        by_radial, by_tangential = (
            of_series(offset * grid.dx, each, grid.dx) for each in (False, True)
        )
        expected = [[by_tangential.imag, -by_radial.imag], [-by_tangential.real, by_radial.real]]
        np.testing.assert_allclose(table[:, :, 8 + offset], expected, atol=1e-5)


@pytest.mark.parametrize("stencil", [((0.0, 1.0),), DIFFERENCE], ids=["shift", "rolling"])
def test_numbers_of_a_large_pin_are_those_of_half_planes(stencil):
    """But for a constant of the size of the load times 1/G, which rolling does not see."""
    grid = Grid(nx=6, dx=0.1, x0=0.0)
    bodies = vc.Bodies(G=G, nu=NU)
    pin = PinInHoleMedium(1e4, G, NU, 50.0).operator(grid, "xyz", "xyz", stencil).table
    flat = HalfSpaces(bodies.combined_nu, bodies.K, 50.0)
    difference = pin - flat.operator(grid, "xyz", "xyz", stencil).table
    if len(stencil) == 1:
        assert np.ptp(difference, axis=-1).max() < grid.nx * grid.dx / 1e4
    else:
        assert np.abs(difference).max() < 1e-5 * grid.dx


def test_displacements_are_reciprocal_and_store_energy():
    grid = Grid(nx=60, dx=2 * np.pi / 60, x0=0.0)
    every = np.arange(60)
    infinite = float("inf")
    for moduli, ratios in ((G, NU), ((1.0, infinite), (0.5, 0.3)), ((infinite, 1.0), (0.3, 0.0))):
        medium = PinInHoleMedium(1.0, moduli, ratios, 3.0)
        matrix = medium.operator(grid, "xyz", "xyz").dense(every)
        np.testing.assert_allclose(matrix, matrix.T, atol=1e-13)
        # but a torque, which turns the pin
        assert np.linalg.eigvalsh(matrix)[1:].min() > 0


def test_slip_is_that_of_vectors():
    """A depth moves the bodies as a whole: nothing slips."""
    grid = Grid(nx=9, dx=0.2, x0=0.0)
    rolling = [
        PinInHoleMedium(1.0, G, NU, depth).operator(grid, "xyz", "xyz", DIFFERENCE).table
        for depth in (3.0, 30.0)
    ]
    np.testing.assert_allclose(*rolling, atol=1e-14)
