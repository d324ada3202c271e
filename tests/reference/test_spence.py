"""Spence's ratio against minimal complementary energy of a flat punch, and at its limits."""

import numpy as np
import pytest
from scipy.optimize import lsq_linear

import varcontact as vc
from tests.scenes import refusals
from varcontact.reference import spence_ratio

PAPER = vc.Bodies(G=(1.0, np.inf), nu=(0.286, 0.0))
BETA = PAPER.K / (1 - PAPER.combined_nu)


def stick_of_punch_in_plane_strain(friction, n):
    """Odd tractions on a half-width 1 that minimise 1/2 p'A p + p'u(pz), |px| <= f pz: the least
    |x| that slips.
    """
    edges = np.linspace(0.0, 1.0, n + 1)
    x, h = (edges[1:] + edges[:-1]) / 2, 1.0 / n
    pressure = np.diff(np.arcsin(edges)) / h  # cell averages of 1/sqrt(1 - x^2)

    def kernel(d):
        def primitive(s):
            return s * np.log(np.abs(s)) - s

        return -(primitive(d + h / 2) - primitive(d - h / 2)) / np.pi

    A = kernel(x[:, None] - x[None, :]) - kernel(x[:, None] + x[None, :])
    pull = -BETA * np.arcsin(x)  # du/dx = -beta pz
    L = np.linalg.cholesky((A + A.T) / 2)
    bound = friction * pressure
    found = lsq_linear(L.T, -np.linalg.solve(L, pull), (-bound, bound), tol=1e-14, method="bvls").x
    return edges[np.argmax(np.abs(found) >= bound * (1 - 1e-9))]


def stick_of_round_punch(friction, n):
    """The same with rings: the energy is (1/pi) times the integral of (t Q)^2, Q Abel's transform
    of the traction.
    """
    edges = np.linspace(0.0, 1.0, n + 1)
    pressure = np.diff(-np.sqrt(1 - edges**2)) / np.diff(edges**2 / 2)
    t = (np.arange(8 * n) + 0.5) / (8 * n)

    def primitive(s):
        return np.arccosh(np.maximum(s[None, :] / t[:, None], 1.0))

    M = np.sqrt(2 / np.pi / (8 * n)) * t[:, None] * (primitive(edges[1:]) - primitive(edges[:-1]))
    r = np.linspace(0, 1, 64 * n + 1)
    r = (r[1:] + r[:-1]) / 2
    pull = -BETA * np.reshape((1 - np.sqrt(1 - r**2)) / (64 * n), (n, 64)).sum(axis=1)
    L = np.linalg.cholesky(M.T @ M)
    bound = friction * pressure
    found = lsq_linear(L.T, -np.linalg.solve(L, pull), (-bound, bound), tol=1e-14, method="bvls").x
    return edges[np.argmax(np.abs(found) >= bound * (1 - 1e-9))]


@pytest.mark.parametrize("part", [0.5, 0.8, 1.5])
@pytest.mark.parametrize(
    ("shape", "stick"), [("line", stick_of_punch_in_plane_strain), ("circle", stick_of_round_punch)]
)
def test_punch(shape, stick, part):
    """Within a cell and a half."""
    assert stick(part * BETA, 200) == pytest.approx(
        spence_ratio(PAPER, part * BETA, shape), abs=1.5 / 200
    )


def test_line_in_closed_form():
    """K' = K at the modulus sqrt(1/2); the moduli k and k' go with f/beta and beta/f."""
    assert spence_ratio(PAPER, BETA, "line") == pytest.approx(np.sqrt(0.5), rel=1e-13)
    for part in (0.3, 0.7):
        one, other = (spence_ratio(PAPER, f * BETA, "line") for f in (part, 1 / part))
        assert np.hypot(one, other) == pytest.approx(1.0, rel=1e-13)


@pytest.mark.parametrize(("shape", "rate"), [("line", np.pi / 2), ("circle", 1.0)])
def test_limits(shape, rate):
    for part in (0.02, 0.05):
        expected = 4 * np.exp(-rate / part)
        assert spence_ratio(PAPER, part * BETA, shape) == pytest.approx(expected, rel=1e-6)
    below, above = (spence_ratio(PAPER, rate / size * BETA, shape) for size in (351.3, 351.5))
    assert above / below == pytest.approx(np.exp(-0.2), rel=1e-6), (
        "on both sides of the bracket's end"
    )
    assert spence_ratio(PAPER, 1e3, shape) == pytest.approx(1.0, abs=1e-12)
    assert spence_ratio(PAPER, 1e-9, shape) == 0.0
    assert spence_ratio(vc.Bodies(G=1.0, nu=0.3), 0.1, shape) == 1.0
    ratios = [spence_ratio(PAPER, f, shape) for f in np.geomspace(0.01, 3, 50)]
    assert np.all(np.diff(ratios) > 0)


def test_units_and_order_of_the_bodies():
    expected = spence_ratio(vc.Bodies(G=(1.0, 3.0), nu=(0.2, 0.4)), 0.1)
    assert spence_ratio(vc.Bodies(G=(3e9, 1e9), nu=(0.4, 0.2)), 0.1) == pytest.approx(
        expected, rel=1e-12
    )


test_bad_input = refusals(
    (lambda: spence_ratio(PAPER, 0.0), "friction"),
    (lambda: spence_ratio(PAPER, 0.1, "lime"), "line"),
)
