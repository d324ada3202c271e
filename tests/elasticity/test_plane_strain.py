"""Influence numbers of strips against integrals done another way, and against long rectangles."""

import numpy as np
import pytest
from scipy.integrate import quad

import varcontact as vc
from varcontact.elasticity.halfspace import influence_numbers
from varcontact.elasticity.operators import influence_operator
from varcontact.elasticity.plane_strain import strip_influence_numbers

NU, K, DEPTH = 0.28, 0.17, 7.0
ALL = ("xx", "xy", "xz", "yx", "yy", "yz", "zx", "zy", "zz")
OF_LOGARITHM = {"xx": 2 * (1 - NU), "yy": 2.0, "zz": 2 * (1 - NU)}
OF_SIGN = {"xz": -np.pi * K, "zx": np.pi * K}


def by_quadrature(component: str, x: float, dx: float) -> float:
    """The integral over the strip of THEORY's kernel, piece by piece where it has a pole or a
    jump.
    """
    pieces = [(-dx / 2, x), (x, dx / 2)] if abs(x) < dx / 2 else [(-dx / 2, dx / 2)]

    def kernel(source: float) -> float:
        logarithm = -np.log(abs(x - source) / DEPTH)
        return OF_LOGARITHM.get(component, 0.0) * logarithm + OF_SIGN.get(component, 0.0) * np.sign(
            x - source
        )

    return (
        sum(quad(kernel, *piece, epsabs=0, epsrel=1e-13, limit=200)[0] for piece in pieces) / np.pi
    )


def numbers(x, dx=1.0, **others):
    return strip_influence_numbers(
        x, dx, **({"nu": NU, "K": K, "depth": DEPTH, "components": ALL} | others)
    )


@pytest.mark.parametrize("component", ALL)
@pytest.mark.parametrize("dx", [1.0, 1e-3, 30.0])
def test_quadrature(component, dx):
    """Inside the strip, on its edge, beside it, where the two formulae meet, and 10^4 widths
    away.
    """
    for widths in (0.0, 0.2, -0.49, 0.5, 0.51, -1.0, 7.99, 8.01, -30.0, 1e3, 1e4):
        expected = by_quadrature(component, widths * dx, dx)
        assert numbers(widths * dx, dx)[component] == pytest.approx(
            expected, rel=3e-13, abs=1e-15 * dx
        )


def test_differences_far_away():
    """What steady rolling needs, A - C, is a small difference: a line load's, to ten digits at 10^4
    widths.
    """
    for r in (1e2, 1e3, 1e4):
        values = numbers(np.array([r, r + 1.0]))["zz"]
        expected = 2 * (1 - NU) / np.pi * (np.log1p(1 / r) + (r**-2 - (r + 1) ** -2) / 24)
        assert values[0] - values[1] == pytest.approx(expected, rel=1e-10)


@pytest.mark.parametrize("component", ["xx", "yy", "zz", "xz", "zx"])
def test_limit_of_long_rectangles(component):
    """But for a constant of the logarithm, which the difference of two places does not have."""
    x = np.array([0.3, 2.4, -5.1])
    strip, error = numbers(x)[component], []
    for dy in (1e3, 1e4, 1e5):
        long = influence_numbers(x, 0.0, 1.0, dy, nu=NU, K=K, components=[component])[component]
        if component in OF_SIGN:
            error.append(np.abs(long - strip).max())
        else:
            error.append(np.abs((long - long[0]) - (strip - strip[0])).max())
    rate = 1 if component in OF_SIGN else 2
    np.testing.assert_allclose(
        np.array(error[:2]) / error[1:], 10.0**rate, rtol=0.05, err_msg=str(error)
    )
    assert error[-1] < 1e-4


def test_betti_and_positive_definiteness():
    """As an operator all nine blocks together are symmetric; positive definite where the depth is a
    length or more.
    """
    for nx, depth in ((12, 12.0), (60, 60.0), (60, 1e6)):
        grid = vc.Grid(nx=nx, dx=1.0, x0=0.0)
        matrix = influence_operator(grid, "xyz", "xyz", nu=NU, K=K, depth=depth).dense(
            np.arange(nx)
        )
        np.testing.assert_allclose(matrix, matrix.T, atol=1e-15 * np.abs(matrix).max())
        assert np.linalg.eigvalsh(matrix).min() > 0


def test_steady_rolling_is_monotone_and_knows_no_depth():
    grid = vc.Grid(nx=80, dx=0.025, x0=-1.0)
    for lag in (0.025, 0.05, 0.0125):
        first, second = (
            influence_operator(grid, "xy", "xy", nu=NU, depth=depth, lag=lag).dense(np.arange(80))
            for depth in (2.0, 1e4)
        )
        np.testing.assert_allclose(first, second, atol=1e-13 * np.abs(first).max())
        assert np.linalg.eigvalsh(first + first.T).min() > 0


def test_a_row_of_rectangles_is_the_strips_operator():
    """Steady rolling of rectangles 10^6 widths long: A - C has no constant, and what lacks is of
    order dx/dy with K.
    """
    row = vc.Grid(nx=9, ny=1, dx=1.0, dy=1e6, x0=0.0, y0=-5e5)
    strips = vc.Grid(nx=9, dx=1.0, x0=0.0)
    for rows, columns, allowed in (("xy", "xy", 1e-9), ("xy", "z", 4 * K / np.pi * 1.01e-6)):
        long = influence_operator(row, rows, columns, nu=NU, K=K, lag=1.0).table
        strip = influence_operator(strips, rows, columns, nu=NU, K=K, depth=DEPTH, lag=1.0).table
        np.testing.assert_allclose(long, strip, rtol=0, atol=allowed)


def test_modulus_and_depth():
    x = np.array([0.0, 0.7, 40.0])
    one, other = numbers(x), numbers(x, G=2.0, depth=2 * DEPTH)
    for component, factor in OF_LOGARITHM.items():
        raised = one[component] + factor / np.pi * np.log(2)
        np.testing.assert_allclose(2 * other[component], raised, rtol=1e-14)
    np.testing.assert_allclose(2 * other["xz"], one["xz"])
