"""Influence numbers against integrals done another way."""

import numpy as np
import pytest
from scipy.integrate import dblquad, quad

from varcontact.elasticity.halfspace import influence_numbers
from varcontact.elasticity.potentials import FAR

NU, K = 0.28, 0.17
ALL = ("xx", "xy", "xz", "yx", "yy", "yz", "zx", "zy", "zz")


def kernel(component: str, x: float, y: float) -> float:
    """Integrand of (217), with x, y = field point minus source."""
    r = np.hypot(x, y)
    values = {
        "xx": (1 - NU) / r + NU * x**2 / r**3,
        "yy": (1 - NU) / r + NU * y**2 / r**3,
        "xy": NU * x * y / r**3,
        "yx": NU * x * y / r**3,
        "zz": (1 - NU) / r,
        "xz": -K * x / r**2,
        "zx": K * x / r**2,
        "yz": -K * y / r**2,
        "zy": K * y / r**2,
    }
    return values[component] / np.pi


def by_polar_integration(component: str, x: float, y: float, dx: float, dy: float) -> float:
    """Around a field point inside the element: the radial integral of every kernel is the ray's
    length.
    """
    corners = [(sx * dx / 2 - x, sy * dy / 2 - y) for sx in (-1, 1) for sy in (-1, 1)]
    breaks = sorted(np.arctan2(cy, cx) for cx, cy in corners)

    def ray(angle: float) -> float:
        c, s = np.cos(angle), np.sin(angle)
        along = ((dx / 2 - x) / c if c > 0 else (-dx / 2 - x) / c) if c != 0 else np.inf
        across = ((dy / 2 - y) / s if s > 0 else (-dy / 2 - y) / s) if s != 0 else np.inf
        # the source is at field + ray, hence field minus source = -(c, s)
        return min(along, across) * kernel(component, -c, -s)

    sectors = zip(breaks, [*breaks[1:], breaks[0] + 2 * np.pi], strict=True)
    return sum(quad(ray, low, high, epsabs=1e-13, epsrel=1e-13)[0] for low, high in sectors)


def by_quadrature(component: str, x: float, y: float, dx: float, dy: float) -> float:
    return dblquad(
        lambda v, u: kernel(component, x - u, y - v),
        -dx / 2,
        dx / 2,
        -dy / 2,
        dy / 2,
        epsabs=0,
        epsrel=1e-12,
    )[0]


def numbers(x, y, dx, dy):
    return influence_numbers(x, y, dx, dy, nu=NU, K=K, components=ALL)


@pytest.mark.parametrize("component", ALL)
@pytest.mark.parametrize("size", [(1.0, 1.0), (1e3, 1.0), (1.0, 1e3), (0.3, 2.0)])
@pytest.mark.parametrize("place", [(0.0, 0.0), (0.2, -0.3), (0.49, 0.1)])
def test_inside_the_element(component, size, place):
    dx, dy = size
    x, y = place[0] * dx, place[1] * dy
    expected = by_polar_integration(component, x, y, dx, dy)
    scale = float(numbers(0.0, 0.0, dx, dy)["zz"])
    assert numbers(x, y, dx, dy)[component] == pytest.approx(expected, rel=1e-10, abs=1e-11 * scale)


@pytest.mark.parametrize("component", ALL)
@pytest.mark.parametrize("size", [(1.0, 1.0), (1e3, 1.0), (1.0, 1e3)])
@pytest.mark.parametrize("distance", [1.0, 3.9, 4.1, 30.0, 1e3, 1e4])
def test_beside_and_far_from_the_element(component, size, distance):
    """1 to 10^4 element sizes away, in three directions."""
    dx, dy = size
    for angle in (0.1, 0.8, 2.9):
        x, y = distance * max(dx, dy) * np.cos(angle), distance * max(dx, dy) * np.sin(angle)
        expected = by_quadrature(component, x, y, dx, dy)
        assert numbers(x, y, dx, dy)[component] == pytest.approx(expected, rel=1e-10)


@pytest.mark.parametrize("distance", [1e4, 1e5])
def test_far_away_is_a_point_force(distance):
    """Digits that the textbook's corner differences lose: they are off by 1e-5 at 10^4 elements."""
    x, y = distance * 0.6, distance * 0.8
    for component in ALL:
        point = kernel(component, x, y)
        assert numbers(x, y, 1.0, 1.0)[component] == pytest.approx(point, rel=2 / distance**2)


def test_corners_and_edges_are_finite():
    """Field points on element corners and edges (shifted by half an element) have finite limits."""
    x = np.array([0.5, 0.5, 0.0, -0.5, 0.5])
    y = np.array([0.5, 0.0, 0.5, -0.5, 1.5])
    near = numbers(x + 1e-12, y - 1e-12, 1.0, 1.0)
    for component, values in numbers(x, y, 1.0, 1.0).items():
        np.testing.assert_allclose(values, near[component], atol=1e-9)


def test_both_rules_agree_where_they_meet():
    """The closed form and Gauss's rule, extrapolated to each other: the closed form has lost three
    digits.
    """
    for angle in (0.0, 0.7, 1.5):
        direction = np.array([np.cos(angle), np.sin(angle)]) / max(
            abs(np.cos(angle)), abs(np.sin(angle))
        )
        near, far, further = (
            numbers(*((FAR + 0.5 + ahead) * direction), 1.0, 1.0) for ahead in (-0.1, 0.1, 0.3)
        )
        for component in ALL:
            jump = far[component] - near[component]
            size = 1e-12 * np.hypot(*(values[component] for values in (far, further)))
            assert jump == pytest.approx(further[component] - far[component], rel=1e-3, abs=size)


def test_only_what_is_asked_for():
    assert set(influence_numbers(1.0, 0.0, 1.0, 1.0, nu=NU, components=["zz"])) == {"zz"}


def test_modulus_and_size_scale():
    """B is homogeneous: twice the lengths, twice the numbers; twice the modulus, half."""
    one = influence_numbers(1.3, 0.4, 1.0, 2.0, nu=NU, K=K, components=ALL)
    two = influence_numbers(2.6, 0.8, 2.0, 4.0, nu=NU, K=K, G=2.0, components=ALL)
    for component in ALL:
        assert two[component] == pytest.approx(one[component], rel=1e-14)
