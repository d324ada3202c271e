"""Creepages that swing: limits, reciprocity, and influence numbers on elements with one phase."""

import numpy as np
import pytest

import varcontact as vc
from tests.scenes import refusals
from varcontact.elasticity.operators import influence_operator
from varcontact.reference import harmonic_coefficients, harmonic_line, no_slip_ellipse

NU = 0.28


@pytest.mark.parametrize("ratio", [0.1, 0.3, 1.0, 4.0, 10.0])
def test_slow_swings_are_steady_rolling(ratio):
    steady, slow = no_slip_ellipse(ratio, NU), harmonic_coefficients(ratio, NU, 1e-4)
    np.testing.assert_allclose(slow.real, steady, atol=2e-5 * np.abs(steady).max())
    assert np.abs(slow.imag).max() < 1e-3 * np.abs(steady).max()
    np.testing.assert_array_equal(harmonic_coefficients(ratio, NU, 0.0), steady)
    for kappa_a in (1e-8, 1e-300):  # the formulas divide by its square
        slower = harmonic_coefficients(ratio, NU, kappa_a) - steady
        np.testing.assert_allclose(slower.imag, slow.imag * kappa_a / 1e-4, rtol=1e-3, atol=1e-12)
        assert np.abs(slower.real).max() < 1e-12 + kappa_a * np.abs(steady).max()


@pytest.mark.parametrize(
    ("ratio", "frequency"),
    [(0.1, 20.0), (0.2, 1.0), (1.0, 0.01), (1.0, 20.0), (5.0, 3.0), (10.0, 20.0)],
)
def test_reciprocity(ratio, frequency):
    """C32 = -C23, which is not built in; nothing else couples."""
    C = harmonic_coefficients(ratio, NU, frequency)
    assert C[2, 1] == pytest.approx(-C[1, 2], abs=1e-5 * max(1.0, np.abs(C).max()))
    np.testing.assert_array_equal(np.abs(C[[0, 0, 1, 2], [1, 2, 0, 0]]) < 1e-9, True)


def test_fast_swings_are_those_of_a_spring():
    """Mindlin's circle that does not roll: C11 comes to 4/((2 - nu) i kappa a) as one by
    frequency.
    """
    differences = [
        harmonic_coefficients(1.0, NU, f)[0, 0] * 1j * f * (2 - NU) / 4 - 1 for f in (10.0, 20.0)
    ]
    assert abs(differences[1]) < 0.03
    assert abs(differences[0] / differences[1]) == pytest.approx(2, rel=0.15)


@pytest.mark.long
def test_an_ellipse_on_elements():
    """A - exp(-i Omega) C on 16 and 32 elements across, extrapolated: to what elements taken by
    centres allow.
    """
    ratio, frequency, found = 2.0, 0.7, []
    for n in (16, 32):
        dx, dy = 2 * ratio / n, 2 / n
        grid = vc.Grid(nx=n, ny=n, dx=dx, dy=dy, x0=-ratio, y0=-1.0)
        inside = np.flatnonzero((grid.x / ratio) ** 2 + grid.y[:, None] ** 2 < 1)
        iy, ix = np.divmod(inside, n)
        x, y = grid.x[ix], grid.y[iy]
        phase = frequency * dx / ratio
        here, before = (
            influence_operator(grid, "xy", "xy", nu=NU, offset=at).dense(inside) for at in (0.0, dx)
        )
        zero, one = np.zeros(x.size), np.ones(x.size)
        shift = (
            np.array([[one, zero], [zero, one], [-y, x + dx / 6]])
            * dx
            * (1 - np.exp(-1j * phase))
            / (1j * phase)
        )
        p = np.linalg.solve(here - np.exp(-1j * phase) * before, -shift.reshape(3, -1).T).reshape(
            2, x.size, 3
        )
        moment = x @ p[1] - y @ p[0]
        total = -np.array([p[0].sum(axis=0), p[1].sum(axis=0), moment]) * dx * dy
        size = np.array([ratio**0.5, ratio**0.5, ratio])
        found.append(total / np.outer(size, size))
    C = harmonic_coefficients(ratio, NU, frequency)
    np.testing.assert_allclose(2 * found[1] - found[0], C, atol=0.015 * np.abs(C).max())


@pytest.mark.parametrize(("frequency", "depth"), [(0.1, 4.0), (1.0, 4.0), (4.0, 30.0)])
def test_a_line_contact_on_elements(frequency, depth):
    found = []
    for n in (100, 200):
        grid, dx = vc.Grid(nx=n, dx=2 / n, x0=-1.0), 2 / n
        here, before = (
            influence_operator(grid, "x", "x", nu=NU, depth=depth, offset=at).dense(np.arange(n))
            for at in (0.0, dx)
        )
        phase = frequency * dx
        shift = dx * (1 - np.exp(-1j * phase)) / (1j * phase)
        found.append(
            -np.linalg.solve(here - np.exp(-1j * phase) * before, -shift * np.ones(n)).sum() * dx
        )
    assert 2 * found[1] - found[0] == pytest.approx(harmonic_line(frequency, NU, depth), rel=2e-4)


def test_a_slow_line_contact_needs_no_depth():
    assert harmonic_line(0.0, NU, 2.0) == harmonic_line(0.0, NU, 1e3) == np.pi / (2 * (1 - NU))


test_out_of_range = refusals(
    (lambda: harmonic_coefficients(0.05, NU, 1.0), "a_over_b"),
    (lambda: harmonic_coefficients(1.0, 0.6, 1.0), "nu"),
    (lambda: harmonic_coefficients(1.0, NU, -1.0), "kappa_a"),
    (lambda: harmonic_coefficients(1.0, NU, 21.0), "kappa_a"),
    by="field",
)
