"""Line contacts in closed form, put back into the integral equations of plane strain by
quadrature.
"""

from itertools import pairwise

import numpy as np
import pytest

import varcontact as vc
from tests.scenes import refusals
from varcontact.elasticity.halfspace import influence_numbers
from varcontact.reference import bufler, carter, cattaneo_line, hertz_ellipse, line_contact

LIKE = vc.Bodies(G=3.0, nu=0.3)
UNLIKE = [
    vc.Bodies(G=(1.0, np.inf), nu=(0.286, 0.0)),
    vc.Bodies(G=(np.inf, 2.0), nu=(0.3, 0.0)),
    vc.Bodies(G=(82e9, 26e9), nu=(0.28, 0.33)),
    vc.Bodies(G=(1.0, 50.0), nu=(-0.9, 0.4)),
]
X = np.array([-0.999, -0.9, -0.62, -0.3, 0.0, 0.1, 0.55, 0.85, 0.99, 0.9999])
STEP = 0.05
NODES = (np.arange(-800, 800) + 0.5) * STEP


def nodes(left, right, around=None):
    """Points and weights after t = tanh(s), the trapezoidal rule in s; a pole `around` lies
    halfway: its PV.
    """
    middle, half = (left + right) / 2, (right - left) / 2
    s = NODES + (np.arctanh((around - middle) / half) if around is not None else 0.0)
    with np.errstate(over="ignore"):
        return middle + half * np.tanh(s), half / np.cosh(s) ** 2 * STEP


def integral(function, edges):
    total = 0.0
    for left, right in pairwise(edges):
        t, weights = nodes(left, right)
        total += np.sum(weights * function(t))
    return total


def finite_part(function, x, edges):
    """PV of the integral of function(t)/(x - t), which may have roots at the edges."""
    total = 0.0
    for left, right in pairwise(edges):
        t, weights = nodes(left, right, x if left < x < right else None)
        used = weights > 1e-14 * weights.max()
        total += np.sum(weights[used] * function(t[used]) / (x - t[used]))
    return total


def strains(bodies, x, edges, pressure, traction):
    """du/dx and dw/dx at x of the displacement difference: the x-derivative of (70), (71)
    integrated over y.
    """
    nu, G, K = bodies.combined_nu, bodies.combined_G, bodies.K
    constant = -2 * (1 - nu) / (np.pi * G)
    return (
        constant * finite_part(traction, x, edges) - 2 * K / G * pressure(x),
        constant * finite_part(pressure, x, edges) + 2 * K / G * traction(x),
    )


def test_the_integral_kernels_are_those_of_the_package():
    """The plane-strain kernel of K and the logarithm: a long strip of influence numbers."""
    B = influence_numbers(
        np.array([0.5, 1.0]), 0.0, 1e-3, 1e5, nu=0.3, K=0.2, components=("xx", "zz", "xz", "zx")
    )
    logarithm = -2 * 0.7 / np.pi * np.log(0.5) * 1e-3
    assert B["xx"][0] - B["xx"][1] == pytest.approx(logarithm, rel=1e-6)
    assert B["zz"][0] - B["zz"][1] == pytest.approx(logarithm, rel=1e-6)
    np.testing.assert_allclose(B["xz"], -0.2 * 1e-3, rtol=1e-4)
    np.testing.assert_allclose(B["zx"], 0.2 * 1e-3, rtol=1e-4)


@pytest.mark.parametrize("scale", [1.0, 1e-3])
def test_hertz(scale):
    contact = line_contact(5.0, LIKE, a=scale)
    edges = [-contact.a, contact.a]
    assert integral(contact.pressure, edges) == pytest.approx(contact.force, rel=1e-12)
    assert contact.peak_pressure == pytest.approx(
        2 * contact.force / (np.pi * contact.a), rel=1e-14
    )
    for x in X * scale:
        slope = strains(LIKE, x, edges, contact.pressure, np.zeros_like)[1]
        assert slope == pytest.approx(-x / 5.0, abs=1e-10 * scale)
    again = line_contact(5.0, LIKE, force=contact.force)
    assert again.a == pytest.approx(contact.a, rel=1e-14)
    assert again.peak_pressure == pytest.approx(contact.peak_pressure, rel=1e-14)
    np.testing.assert_array_equal(contact.pressure(np.array([-1.1, 1.0, 2.0]) * scale), 0.0)


def test_hertz_is_the_limit_of_a_long_ellipse():
    """Per unit length in the middle, where the force is that of a semi-elliptical pressure."""
    ellipse = hertz_ellipse(1.0, 1e4, LIKE, force=1.0)
    strip = line_contact(ellipse.Rx, LIKE, a=1.0)
    assert strip.peak_pressure == pytest.approx(ellipse.peak_pressure, rel=1e-6)


@pytest.mark.parametrize("creepage", [0.01, 0.05, -0.028, 0.0599, 0.06, -0.2])
def test_carter(creepage):
    """Stick ahead, slip against the traction behind, and the slip that the strain leaves of the
    creepage.
    """
    contact = line_contact(5.0, LIKE, a=1.0)
    rolling = carter(contact, 0.3, creepage=creepage)
    edges = sorted({-1.0, 1.0 - 2 * rolling.stick_half_width, 1.0})
    assert integral(rolling.traction, edges) == pytest.approx(rolling.force, rel=1e-10)
    assert rolling.force * creepage < 0, "positive creepage gives a negative force on body 1"
    assert rolling.full_sliding_creepage == pytest.approx(0.06)
    for x in X:
        slip = creepage - strains(LIKE, x, edges, contact.pressure, rolling.traction)[0]
        assert float(rolling.slip(x)) == pytest.approx(slip, abs=1e-9)
        if x > 1.0 - 2 * rolling.stick_half_width:
            assert slip == pytest.approx(0.0, abs=1e-9)
            assert abs(rolling.traction(x)) <= 0.3 * contact.pressure(x)
        else:
            assert slip * creepage > 0
            assert rolling.traction(x) == pytest.approx(
                -np.sign(creepage) * 0.3 * contact.pressure(x), rel=1e-12
            )
    assert np.isnan(rolling.slip(1.01))


@pytest.mark.parametrize("part", [-0.999, -0.4, -1e-9, 0.3, 0.7])
def test_carter_by_force_is_the_inverse(part):
    contact = line_contact(5.0, LIKE, a=1.0)
    rolling = carter(contact, 0.3, force=part * 0.3 * contact.force)
    again = carter(contact, 0.3, creepage=rolling.creepage)
    assert again.force == pytest.approx(rolling.force, rel=1e-12)
    assert again.stick_half_width == pytest.approx(rolling.stick_half_width, rel=1e-12)


def test_carter_limits():
    contact = line_contact(5.0, LIKE, a=1.0)
    small = carter(contact, 0.3, creepage=1e-9)
    stiffness = np.pi * LIKE.combined_G / (1 - LIKE.combined_nu) / 2
    assert small.force == pytest.approx(-stiffness * 1e-9, rel=1e-6), "no-slip rolling"
    assert carter(contact, 0.3, force=0.0).stick_half_width == contact.a
    assert carter(contact, 0.3, creepage=0.0).force == 0.0
    full = carter(contact, 0.3, creepage=0.06)
    assert full.force == pytest.approx(-0.3 * contact.force)
    assert full.stick_half_width == pytest.approx(0.0, abs=1e-15)


@pytest.mark.parametrize("part", [-0.95, -0.3, 0.01, 0.6])
def test_cattaneo(part):
    contact = line_contact(5.0, LIKE, a=1.0)
    shifted = cattaneo_line(contact, 0.3, part * 0.3 * contact.force)
    c = shifted.stick_half_width
    edges = [-1.0, -c, c, 1.0]
    assert integral(shifted.traction, edges) == pytest.approx(shifted.force, rel=1e-10)

    def strain(x):
        return strains(LIKE, x, edges, contact.pressure, shifted.traction)[0]

    for x in X:
        if abs(x) < c:
            assert strain(x) == pytest.approx(0.0, abs=1e-9)
            assert shifted.slip(x) == 0.0
        else:
            r, weights = np.polynomial.legendre.leggauss(20)
            r = (r + 1) / 2  # x' = c + (x - c) r^2 takes the root of the strain at c away
            start = np.sign(x) * c
            slip = np.sum(
                weights * r * (x - start) * [strain(start + (x - start) * part**2) for part in r]
            )
            assert float(shifted.slip(x)) == pytest.approx(slip, rel=1e-6, abs=1e-10)
            assert slip * shifted.traction(x) < 0
    np.testing.assert_allclose(shifted.traction(X), shifted.traction(-X))
    np.testing.assert_allclose(
        shifted.traction(X), -cattaneo_line(contact, 0.3, -shifted.force).traction(X)
    )


@pytest.mark.parametrize("bodies", UNLIKE)
@pytest.mark.parametrize("a", [1.0, 1e-3])
def test_bufler(bodies, a):
    """Stick and contact over the whole strip, at the creepage and the forces that are stated."""
    R = 50 * a
    rolling = bufler(R, bodies, a=a)
    edges = [-a, a]
    for x in X * a:
        along, slope = strains(bodies, x, edges, rolling.pressure, rolling.traction)
        assert along == pytest.approx(rolling.creepage, abs=1e-9)
        assert slope == pytest.approx(-x / R, abs=1e-9)
    assert integral(rolling.pressure, edges) == pytest.approx(rolling.force, rel=1e-10)
    assert integral(rolling.traction, edges) == pytest.approx(0.0, abs=1e-10 * rolling.force)
    assert np.sign(rolling.creepage) == -np.sign(bodies.K)
    assert bufler(R, bodies, force=rolling.force).a == pytest.approx(a, rel=1e-13)
    np.testing.assert_array_equal(rolling.traction(np.array([-2.0, -1.0, 1.0, 1.5]) * a), 0.0)
    np.testing.assert_array_equal(rolling.pressure(np.array([-2.0, -1.0, 1.0, 1.5]) * a), 0.0)


def test_bufler_of_like_bodies_is_hertz():
    contact, rolling = line_contact(5.0, LIKE, a=1.0), bufler(5.0, LIKE, a=1.0)
    assert rolling.creepage == 0
    assert rolling.force == pytest.approx(contact.force, rel=1e-14)
    np.testing.assert_allclose(rolling.pressure(X), contact.pressure(X), rtol=1e-12)
    np.testing.assert_array_equal(rolling.traction(X), 0.0)


def test_bufler_with_the_bodies_interchanged():
    """K changes its sign: so do creepage and traction, the pressure stays."""
    one = bufler(5.0, vc.Bodies(G=(1.0, 3.0), nu=(0.2, 0.4)), force=0.01)
    other = bufler(5.0, vc.Bodies(G=(3.0, 1.0), nu=(0.4, 0.2)), force=0.01)
    assert other.creepage == pytest.approx(-one.creepage, rel=1e-12)
    np.testing.assert_allclose(
        other.traction(X * one.a), -one.traction(X * one.a), rtol=1e-10, atol=1e-18
    )
    np.testing.assert_allclose(other.pressure(X * one.a), one.pressure(X * one.a), rtol=1e-10)
    np.testing.assert_allclose(
        one.traction(X * one.a), -one.traction(-X * one.a), rtol=1e-10, atol=1e-18
    )


@pytest.mark.parametrize("force", [0.31, -0.3, np.nextafter(0.3, 1)])
def test_saturated(force):
    contact = line_contact(5.0, LIKE, force=1.0)
    with pytest.raises(vc.Saturated, match=r"0\.3"):
        carter(contact, 0.3, force=force)
    with pytest.raises(vc.Saturated, match=r"0\.3"):
        cattaneo_line(contact, 0.3, force)


CONTACT, COUPLED = (line_contact(5.0, bodies, force=1.0) for bodies in (LIKE, UNLIKE[0]))

test_bad_input = refusals(
    (lambda: line_contact(-1.0, LIKE, force=1.0), "R"),
    (lambda: line_contact(1.0, LIKE, force=np.nan), "force"),
    (lambda: line_contact(1.0, LIKE, a=0.0), "a"),
    (lambda: line_contact(1.0, LIKE), "force, a, approach"),
    (lambda: line_contact(1.0, LIKE, force=1.0, a=1.0), "force, a, approach"),
    (lambda: bufler(np.inf, LIKE, force=1.0), "R"),
    (lambda: bufler(1.0, LIKE), "force, a"),
    (lambda: bufler(1.0, LIKE, force=-1.0), "force"),
    (lambda: carter(CONTACT, 0.3), "creepage, force"),
    (lambda: carter(CONTACT, 0.3, creepage=0.1, force=0.1), "creepage, force"),
    (lambda: carter(CONTACT, 0.0, creepage=0.1), "friction"),
    (lambda: carter(CONTACT, 0.3, creepage=np.inf), "creepage"),
    (lambda: carter(COUPLED, 0.3, creepage=0.1), "bodies.K"),
    (lambda: cattaneo_line(COUPLED, 0.3, 0.1), "bodies.K"),
    (lambda: cattaneo_line(CONTACT, -0.3, 0.1), "friction"),
    (lambda: cattaneo_line(CONTACT, 0.3, np.nan), "force"),
    by="field",
)
