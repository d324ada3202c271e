"""Order and limit from values whose law is known."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from varcontact.study.extrapolate import extrapolate

CELLS = np.repeat([8.0, 12.0, 16.0, 24.0, 32.0], 4)


@given(st.floats(0.7, 2.4), st.floats(-5, 5), st.sampled_from([-3.0, -0.2, 0.5, 4.0]), st.floats(1e-6, 1e6))
def test_a_power_is_found(order, limit, coefficient, unit):
    """Whatever the unit of the values and of h."""
    h = 1 / np.unique(CELLS)
    found = extrapolate(h * 7, unit * (limit + coefficient * h**order))
    assert found.order == pytest.approx(order, abs=0.013)
    assert abs(found.value / unit - limit) < 1e-3 * abs(coefficient)


@pytest.mark.parametrize("order", [1.0, 1.5, 2.0])
@pytest.mark.parametrize("steps", [False, True])
def test_error_bars_hold_what_they_promise(order, steps):
    """Of 200 noisy studies about 95 % hold the limit (190; fewer than 182 comes once in 500), order and bar alike."""
    rng = np.random.default_rng(1)
    h, holds, orders, errors = 1 / CELLS, 0, 0, []
    for _ in range(200):
        staircase = rng.normal(size=(h.size, 2)) * h[:, None] ** 1.5
        noise = 0.2 * rng.normal(size=h.size) * h**1.5 + (staircase @ [3.0, -1.0] if steps else 0)
        found = extrapolate(h, 1 + h**order + noise, staircase if steps else None)
        holds += abs(found.value - 1) <= found.error
        orders += found.order_low <= order <= found.order_high
        errors.append(found.error)
    assert holds >= 182
    assert orders >= 182
    assert np.median(errors) < 0.04, "smaller than the error of the finest grid by h^1"


def test_known_parts_of_the_noise_are_taken_out():
    """The error bar does not grow with noise that the staircase explains."""
    rng = np.random.default_rng(2)
    h = 1 / CELLS
    staircase, rest = rng.normal(size=(h.size, 1)) * h[:, None] ** 1.5, 0.01 * rng.normal(size=h.size) * h**1.5
    quiet, loud = (extrapolate(h, 1 + h + b * staircase[:, 0] + rest, staircase) for b in (0.0, 100.0))
    assert loud.error == pytest.approx(quiet.error, rel=1e-6)
    assert loud.value == pytest.approx(quiet.value, abs=1e-9)
    assert extrapolate(h, 1 + h + 100 * staircase[:, 0] + rest).error > 100 * quiet.error


@pytest.mark.parametrize(
    ("cells", "values", "words"),
    [
        ([8, 8, 16], [1.0, 1.1, 1.2], "no order: 2 grids"),
        ([8, 12, 16], [1.2, 1.1, 1.05], "no error"),
        ([8, 12, 16, 24], [2.0, 2.0, 2.0, 2.0], "the same on all grids"),
        ([8, 12, 16, 24], [1.0, 1.1, 0.9, 1.05], "hides the order"),
    ],
)
def test_what_cannot_be_said_is_not(cells, values, words):
    found = extrapolate(1 / np.array(cells, dtype=float), np.array(values))
    assert words in found.reason
    if "grids, three" in words or cells == [8, 8, 16]:
        assert np.isnan([found.value, found.order]).all()
    if words == "no error":
        assert np.isinf(found.error)
