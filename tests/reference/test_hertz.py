"""Hertz's theory against the paper's table, closed forms, and its own integral equation."""

from functools import partial
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import dblquad, quad
from scipy.special import elliprd, elliprf, elliprg

import varcontact as vc
from tests.scenes import refusals
from varcontact.reference import cattaneo_mindlin, elliptic_integrals, hertz, hertz_ellipse
from varcontact.reference.hertz import complete_integral

STEEL = vc.Bodies(G=82e9, nu=0.28)


def test_table_1(paper_table):
    """Within a unit of the last digit printed. B(1.0) = .7864 is a misprint of pi/4 = .7854."""
    for row in paper_table("table1_elliptic_integrals.csv"):
        integrals = elliptic_integrals(row["axial_ratio"])
        printed = {**row, "B": np.pi / 4 if row["axial_ratio"] == 1 else row["B"]}
        for name in "BCDEK":
            unit = 1e-3 if row["axial_ratio"] == 1 and name in "EK" else 1e-4
            assert getattr(integrals, name) == pytest.approx(printed[name], abs=unit), (name, row)


@pytest.mark.parametrize("ratio", [1e-6, 0.03, 0.5, 0.94, 0.9487, 0.95, 0.99999, 1.0])
def test_elliptic_integrals_by_quadrature(ratio):
    """The definitions (95)-(99), on both sides of where C changes its formula; the root written
    without loss.
    """
    integrals = elliptic_integrals(ratio)

    def root(t):
        return np.hypot(np.cos(t), ratio * np.sin(t))

    definitions = {
        "B": lambda t: np.cos(t) ** 2 / root(t),
        "C": lambda t: np.sin(t) ** 2 * np.cos(t) ** 2 / root(t) ** 3,
        "D": lambda t: np.sin(t) ** 2 / root(t),
        "E": root,
        "K": lambda t: 1 / root(t),
    }
    for name, integrand in definitions.items():
        breaks = np.pi / 2 - np.array([np.pi / 2, 1e-1, 1e-3, 1e-5, 1e-7, 0.0])
        value = sum(quad(integrand, a, b, epsrel=1e-12)[0] for a, b in pairwise(breaks))
        assert getattr(integrals, name) == pytest.approx(value, rel=1e-9), name


@pytest.mark.parametrize("ratio", [1e-100, 1e-30, 1e-6, 0.03, 0.5, 0.99999, 1.0])
def test_elliptic_integrals_to_rounding(ratio):
    """Against Carlson's symmetric forms."""
    integrals = elliptic_integrals(ratio)
    k2 = ratio**2
    carlson = {
        "B": k2 * elliprd(0, 1, k2) / 3,
        "D": elliprd(0, k2, 1) / 3,
        "E": 2 * elliprg(0, k2, 1),
        "K": elliprf(0, k2, 1),
    }
    for name, value in carlson.items():
        assert getattr(integrals, name) == pytest.approx(value, rel=5e-15), name


@pytest.mark.parametrize("t", [2, 10, 40, 70, 88, 90])
def test_table_2(t):
    """The axial ratio by cos t = |A - B|/(A + B): (103), cos t = m^2 (D - C)/E; 1 at 90 degrees."""
    half = np.radians(t / 2)
    contact = hertz(1 / np.cos(half) ** 2, 1 / np.sin(half) ** 2, STEEL, force=1.0)
    ratio = min(contact.a / contact.b, 1.0)
    integrals = elliptic_integrals(ratio)
    cosine = (1 - ratio**2) * (integrals.D - integrals.C) / integrals.E
    assert cosine == pytest.approx(np.cos(np.radians(t)), abs=1e-12)


def test_sphere():
    """a^3 = 3 F R/(4 E*), d = a^2/R, p0 = 3 F/(2 pi a^2), with E* = G/(1 - nu) for like bodies."""
    force, R = 123.0, 0.05
    stiffness = 82e9 / 0.72
    contact = hertz(R, R, STEEL, force=force)
    a = (3 * force * R / (4 * stiffness)) ** (1 / 3)
    assert contact.a == pytest.approx(a, rel=1e-14)
    assert contact.b == pytest.approx(a, rel=1e-14)
    assert contact.approach == pytest.approx(a**2 / R, rel=1e-14)
    assert contact.peak_pressure == pytest.approx(1.5 * force / (np.pi * a**2), rel=1e-14)


@pytest.mark.long
@given(
    ratio=st.floats(-4, 4), size=st.floats(-3, 3), load=st.floats(-3, 6), nu=st.floats(-0.9, 0.5)
)
def test_pressure_solves_the_contact_equation(ratio, size, load, nu):
    """For curvature ratios 1e-4..1e4: displacement at the centre and its curvatures, by Hertz's
    potential.

    The pressure p0 sqrt(1 - x^2/a^2 - y^2/b^2) raises the surface by (Johnson, Contact Mechanics,
    3.37) ``(1 - nu)/(2 G) p0 a b int_0^inf (1 - x^2/(a^2 + w) - y^2/(b^2 + w)) dw /
    sqrt((a^2+w)(b^2+w) w)`` from each body.
    """
    bodies = vc.Bodies(G=3.0, nu=nu)
    Rx, Ry = 10**size, 10 ** (size + ratio)
    contact = hertz(Rx, Ry, bodies, force=10**load)
    a, b = contact.a, contact.b

    def integral(power_a: int, power_b: int) -> float:
        """With w = exp(s)."""

        def integrand(s: float) -> float:
            w = np.exp(s)
            return w / ((a**2 + w) ** (0.5 + power_a) * (b**2 + w) ** (0.5 + power_b) * np.sqrt(w))

        low, high = 2 * np.log(min(a, b)), 2 * np.log(max(a, b))
        breaks = [low - 70, low - 10, low, high, high + 10, high + 70]
        return sum(quad(integrand, u, v, epsrel=1e-12)[0] for u, v in pairwise(breaks) if v > u)

    factor = 2 * (1 - nu) / (4 * bodies.G) * contact.peak_pressure * a * b
    assert factor * integral(0, 0) == pytest.approx(contact.approach, rel=1e-8)
    assert factor * integral(1, 0) == pytest.approx(1 / (2 * Rx), rel=1e-8)
    assert factor * integral(0, 1) == pytest.approx(1 / (2 * Ry), rel=1e-8)
    assert contact.force == pytest.approx(2 / 3 * np.pi * a * b * contact.peak_pressure, rel=1e-12)


@given(ratio=st.floats(-4, 4), load=st.floats(-3, 6))
def test_force_and_approach_belong_together(ratio, load):
    contact = hertz(1.0, 10**ratio, STEEL, force=10**load)
    again = hertz(1.0, 10**ratio, STEEL, approach=contact.approach)
    assert (again.a, again.b, again.force) == pytest.approx(
        (contact.a, contact.b, contact.force), rel=1e-11
    )


@given(ratio=st.floats(-3, 3))
def test_ellipse_gives_its_radii_and_back(ratio):
    given_ = hertz_ellipse(1e-3, 1e-3 * 10**ratio, STEEL, force=1e3)
    assert hertz(given_.Rx, given_.Ry, STEEL, force=1e3).b == pytest.approx(given_.b, rel=1e-9)
    by_approach = hertz_ellipse(1e-3, 1e-3 * 10**ratio, STEEL, approach=given_.approach)
    assert by_approach.force == pytest.approx(1e3, rel=1e-12)


test_bad_input = refusals(
    ({"Rx": -1.0, "Ry": 1.0, "force": 1.0}, "Rx"),
    ({"Rx": 1.0, "Ry": np.inf, "force": 1.0}, "Ry"),
    ({"Rx": 1.0, "Ry": 1.0}, "force, approach"),
    ({"Rx": 1.0, "Ry": 1.0, "force": 1.0, "approach": 1.0}, "force, approach"),
    ({"Rx": 1.0, "Ry": 1.0, "approach": 0.0}, "approach"),
    of=partial(hertz, bodies=STEEL),
    by="field",
)


@pytest.mark.long
@given(
    ratio=st.floats(0.01, 100.0),
    cells=st.tuples(st.integers(1, 40), st.integers(1, 40)),
    place=st.tuples(st.floats(0.0, 0.99), st.floats(0.0, 0.99)),
    force=st.floats(1e-9, 1e9),
)
def test_means_carry_the_force(ratio, cells, place, force):
    """Whatever the lattice, to 1e-12; and the mean of an element is that of its quarters."""
    contact = hertz_ellipse(ratio, 1.0, STEEL, force=force)
    x, y = (
        side * (-1 + 2 * (np.arange(n + 2) - part) / n)
        for side, n, part in zip((ratio, 1.0), cells, place, strict=True)
    )
    means, area = contact.mean_pressure(x, y), (x[1] - x[0]) * (y[1] - y[0])
    assert means.sum() * area == pytest.approx(force, rel=1e-12)
    assert np.all(means >= 0)
    finer = contact.mean_pressure(*(np.sort([*z, *((z[1:] + z[:-1]) / 2)]) for z in (x, y)))
    quarters = finer.reshape(means.shape[0], 2, means.shape[1], 2).mean(axis=(1, 3))
    assert quarters == pytest.approx(
        means, abs=1e-12 * contact.peak_pressure * max(1.0, ratio / area)
    )


def test_means_by_quadrature():
    """Against the root itself: along y in closed form, along x numerically, split where the ellipse
    crosses.
    """
    contact = hertz_ellipse(2.0, 1.0, STEEL, force=1.0)
    x, y = np.linspace(-2.3, 2.2, 6), np.linspace(-1.1, 1.2, 5)

    def strip(at, low, high):
        half = np.sqrt(max(1 - (at / 2) ** 2, 0.0))

        def primitive(end):
            part = np.clip(end / half, -1, 1)
            return half**2 * (part * np.sqrt(1 - part**2) + np.arcsin(part)) / 2

        return primitive(high) - primitive(low) if half > 0 else 0.0

    means = contact.mean_pressure(x, y) / contact.peak_pressure
    for iy, (low, high) in enumerate(pairwise(y)):
        for ix, (left, right) in enumerate(pairwise(x)):
            crossings = [
                s * 2 * np.sqrt(max(1 - end**2, 0.0)) for s in (-1, 1) for end in (low, high, 0.0)
            ]
            inside = [at for at in crossings if left < at < right] or None
            volume = quad(strip, left, right, (low, high), points=inside, epsabs=1e-13, limit=200)[
                0
            ]
            assert means[iy, ix] == pytest.approx(
                volume / ((right - left) * (high - low)), abs=1e-11
            )


def test_means_in_line_contact():
    """The semi-ellipse over strips: the force exactly, and the mean at the middle of thin
    strips.
    """
    scene = vc.Scene(bodies=STEEL, surface=vc.Cylinders(R=1.0), normal_force=1e6)
    a = scene.hertz.a
    x = np.linspace(-1.3 * a, 1.1 * a, 38)
    means = scene.hertz.mean_pressure(x, np.array([-0.5, 0.5]))
    assert means.shape == (1, 37)
    assert means.sum() * (x[1] - x[0]) == pytest.approx(1e6, rel=1e-12)
    thin = np.array([0.3, 0.3001]) * a
    assert scene.hertz.mean_pressure(thin, np.array([-0.5, 0.5]))[0, 0] == pytest.approx(
        scene.hertz.peak_pressure * np.sqrt(1 - 0.30005**2), rel=1e-8
    )


# ----------------------------------------------------------------------------- Cattaneo's shift


ALIKE = vc.Bodies(G=2.0, nu=0.3)
PRESSED = hertz(1.0, 1.0, ALIKE, force=0.1)


@pytest.mark.parametrize("part", [0.1, 0.657, 0.99])
def test_traction_carries_the_force(part):
    force = -part * 0.4 * PRESSED.force
    solution = cattaneo_mindlin(PRESSED, ALIKE, 0.4, force)
    moments = quad(
        lambda r: r * float(solution.traction(r, 0.0)), 0, PRESSED.a, points=[solution.stick_radius]
    )
    total = 2 * np.pi * moments[0]
    assert total == pytest.approx(force, rel=1e-7)
    assert solution.shift > 0, "body 1 is shifted against the force that it feels"


def test_shift_is_the_displacement_in_the_middle():
    """In stick, shift + u = 0: u(0, 0) from the traction by (70), in polar coordinates."""
    solution = cattaneo_mindlin(PRESSED, ALIKE, 0.4, -0.02)
    u = dblquad(
        lambda r, t: (1 - 0.3 + 0.3 * np.cos(t) ** 2) * float(solution.traction(r, 0.0)) / (np.pi * 2.0),
        0, 2 * np.pi, 0, PRESSED.a, epsabs=1e-9,
    )[0]  # fmt: skip
    assert u == pytest.approx(-solution.shift, rel=1e-6)


def test_saturated():
    with pytest.raises(vc.Saturated, match=r"0\.04"):
        cattaneo_mindlin(PRESSED, ALIKE, 0.4, 0.05)


def test_integrals_of_no_number_end_and_spoil_no_others():
    found = complete_integral(np.array([0.5, np.nan, 0.0, 1e-300]), 1.0, 1.0)
    assert found[0] == pytest.approx(elliptic_integrals(0.5).K, rel=1e-14)
    assert np.isnan(found[1])
    assert found[3] == pytest.approx(np.log(4e300), rel=1e-14)
