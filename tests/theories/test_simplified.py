"""The closed forms of simplified theory by quadrature of their own tractions."""

import numpy as np
import pytest

import varcontact as vc
from varcontact.reference import creepage_coefficients
from varcontact.theories import (
    flexibilities,
    flexibility,
    linear_forces,
    simplified_force,
    simplified_linear_force,
    simplified_traction,
)

A, B, L, LIMIT = 1.3, 0.7, 0.4, 2.0


def integral(vx: float, vy: float, bound: str, points: int = 800) -> np.ndarray:
    """Total of the tractions by the midpoint rule along strips, strips by Gauss in the angle of y =
    b sin.
    """
    nodes, weights = np.polynomial.legendre.leggauss(80)
    angle = nodes * np.pi / 2
    y, width = B * np.sin(angle), weights * np.pi / 2 * B * np.cos(angle)
    half = A * np.cos(angle)
    x = half[:, None] * ((2 * np.arange(points) + 1) / points - 1)
    p = simplified_traction(x, y[:, None], A, B, L, LIMIT, vx, vy, bound)
    return np.sum(p * (width * 2 * half / points)[:, None], axis=(1, 2))


@pytest.mark.parametrize("bound", ["parabolic", "elliptic"])
@pytest.mark.parametrize("creepage", [(0.01, 0.0), (0.3, -0.4), (-0.8, 0.2), (0.0, 3.0)])
def test_total_of_the_tractions(bound, creepage):
    found = simplified_force(A, B, L, LIMIT, *creepage, bound)
    np.testing.assert_allclose(integral(*creepage, bound), found, atol=2e-4 * LIMIT)
    assert np.cross([*found, 0], [*creepage, 0])[2] == pytest.approx(0, abs=1e-12)


@pytest.mark.parametrize("bound", ["parabolic", "elliptic"])
def test_linear_limit(bound):
    """(157)-(158) to the first order, whatever the bound."""
    small = 1e-7
    force = simplified_force(A, B, L, LIMIT, small, -2 * small, bound)
    np.testing.assert_allclose(
        force, simplified_linear_force(A, B, L, (small, -2 * small, 0.0)), rtol=1e-5
    )
    tiny = simplified_force(A, B, L, LIMIT, 1e-200, 0.0, bound)
    assert tiny[0] == pytest.approx(-8 * A**2 * B * 1e-200 / (3 * L), rel=1e-12)


def test_full_slip():
    np.testing.assert_array_equal(simplified_force(A, B, L, LIMIT, 100.0, 0.0), [-LIMIT, 0.0])
    np.testing.assert_array_equal(simplified_force(A, B, L, LIMIT, 0.0, 0.0), [0.0, 0.0])
    assert simplified_force(A, B, L, LIMIT, 1e6, 0.0, "elliptic")[0] == pytest.approx(
        -LIMIT, rel=1e-12
    )


def test_linear_force_with_spin_by_quadrature():
    """(153)-(154) integrated give (157)-(158)."""
    vx, vy, spin = 0.01, -0.02, 0.05
    nodes, weights = np.polynomial.legendre.leggauss(40)
    angle = nodes * np.pi / 2
    half = A * np.cos(angle)[:, None]
    y, x = B * np.sin(angle)[:, None], half * nodes
    area = (weights * np.pi / 2 * B * np.cos(angle))[:, None] * half * weights
    px = (vx - spin * y) * (x - half) / L
    py = (vy * (x - half) + spin * (x**2 - half**2) / 2) / L
    found = simplified_linear_force(A, B, L, (vx, vy, spin))
    np.testing.assert_allclose([np.sum(px * area), np.sum(py * area)], found, rtol=1e-10)


def test_flexibility_ties_simplified_to_linear_theory():
    """By (161)-(163) both give the same force where one creepage acts alone."""
    table = creepage_coefficients(A, B, 0.28)
    for i, creepage in enumerate(np.eye(3)):
        L = flexibility(A, B, 3.0, creepage, table)
        assert L == flexibilities(A, B, 3.0, table)[i]
        linear = linear_forces(A, B, 3.0, creepage, table).force
        np.testing.assert_allclose(simplified_linear_force(A, B, L, creepage), linear, rtol=1e-14)


def test_flexibility_is_a_mean_of_three():
    """(164), for any size of the creepages; not defined without any."""
    table = creepage_coefficients(A, B, 0.28)
    L1, L2, L3 = (float(flexibility(A, B, 3.0, creepage, table)) for creepage in np.eye(3))
    creepage = np.array([3.0, -4.0, 12.0 / np.sqrt(A * B)])
    for size in (1.0, 1e-170, 1e98):
        assert flexibility(A, B, 3.0, size * creepage, table) == pytest.approx(
            (3 * L1 + 4 * L2 + 12 * L3) / 13
        )
    assert flexibility(A, B, 3.0, (0, 0, 0), table) == L1


def test_flexibilities_of_many_contacts():
    """Table 4 (nu = 0.25) in one call, within 1.1 %; .727 where it misprints .784, and .332 where
    .352.
    """
    ratios = np.array([0.1, 0.3, 1.0, 1 / 0.3, 10.0])
    found = (
        flexibilities(2 * ratios, 2.0, 5.0, creepage_coefficients(ratios, 1.0, 0.25))
        * 5
        / (2 * ratios[:, None])
    )
    printed = [
        (0.806, 1.06, 0.525),
        (0.775, 0.970, 0.602),
        (0.647, 0.727, 0.534),
        (0.421, 0.417, 0.332),
    ]
    np.testing.assert_allclose(found, [*printed, (0.228, 0.208, 0.170)], rtol=0.011)
    with pytest.raises(vc.SceneError, match="G = -5"):
        flexibilities(1.0, 1.0, -5.0, creepage_coefficients(1.0, 1.0, 0.25))


@pytest.mark.parametrize(("changes", "words"), [
    ({"a": 0.0}, "a = 0"),
    ({"b": np.inf}, "b = inf"),
    ({"L": -1.0}, "L = -1"),
    ({"friction_force": 0.0}, "friction_force = 0"),
    ({"vx": np.nan}, "vx = nan"),
    ({"vy": "much"}, "vy = 'much'"),
    ({"bound": "parabola"}, "bound = 'parabola'.*did you mean parabolic"),
])  # fmt: skip
def test_bad_input(changes, words):
    good = {"a": A, "b": B, "L": L, "friction_force": LIMIT, "vx": 0.1, "vy": 0.0}
    for call, more in ((simplified_force, {}), (simplified_traction, {"x": 0.0, "y": 0.0})):
        with pytest.raises(vc.SceneError, match=words):
            call(**more, **(good | changes))
