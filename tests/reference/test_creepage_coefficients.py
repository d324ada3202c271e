"""The coefficients against Tables 3 and 4 of the paper, and between their entries."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import varcontact as vc
from varcontact.reference import creepage_coefficients

NAMES = ("C11", "C22", "C23", "C33")
TABLE_4 = {
    "GL1/a": (0.806, 0.775, 0.647, 0.421, 0.228),
    "GL2/a": (1.06, 0.970, 0.784, 0.417, 0.208),
    "GL3/a": (0.525, 0.602, 0.534, 0.352, 0.170),
}
MISPRINTS = {("GL2/a", 2): 0.727, ("GL3/a", 3): 0.332}
"""By row and column of Table 4: .784 is 8/(3 C22) at nu = 0; .352 has one wrong digit (it would need C23 = 4.07)."""


@pytest.mark.parametrize(("nu", "suffix"), [(0.0, "nu0"), (0.5, "nu05")])
def test_table_3(paper_table, nu, suffix):
    for row in paper_table("table3_creepage_coefficients.csv"):
        found = creepage_coefficients(row["a_over_b"], 1.0, nu)
        for name in NAMES:
            # the file of the tests rounds 1/.9 to 1.11111
            assert getattr(found, name) == pytest.approx(row[f"{name}_{suffix}"], rel=1e-5)


def test_table_4():
    """8/(3 C11), 8/(3 C22) and pi sqrt(a/b)/(4 C23) at nu = 0.25 to the printed digit, two misprints apart."""
    ratios = (0.1, 0.3, 1.0, 1 / 0.3, 1 / 0.1)
    for column, ratio in enumerate(ratios):
        c = creepage_coefficients(ratio, 1.0, 0.25)
        found = (8 / (3 * c.C11), 8 / (3 * c.C22), np.pi * np.sqrt(ratio) / (4 * c.C23))
        for (name, row), value in zip(TABLE_4.items(), found, strict=True):
            printed = MISPRINTS.get((name, column), row[column])
            assert f"{value:.3g}" == f"{printed:.3g}", (name, ratio)


def test_misprints_are_misprints():
    at_zero, quarter = creepage_coefficients(1.0, 1.0, 0.0), creepage_coefficients(1.0, 1.0, 0.25)
    assert 8 / (3 * at_zero.C22) == pytest.approx(0.784, abs=5e-4)
    assert 8 / (3 * quarter.C22) == pytest.approx(0.727, abs=5e-4)
    # .352 would put C23 at nu = 0.25 far off the middle of its neighbours in nu
    needed = np.pi * np.sqrt(1 / 0.3) / (4 * 0.352)
    assert needed < 0.95 * 2 / (1 / 3.79 + 1 / 5.01)


@pytest.mark.parametrize("left_out", range(1, 18))
def test_between_the_rows(paper_table, left_out):
    """A spline without one row finds that row to within 2 %, so the full one is better than that between rows."""
    from scipy.interpolate import CubicSpline

    rows = paper_table("table3_creepage_coefficients.csv")
    keys = [key for key in rows[0] if key != "a_over_b"]
    kept = [row for i, row in enumerate(rows) if i != left_out]
    spline = CubicSpline(np.log([row["a_over_b"] for row in kept]), np.log([[row[k] for k in keys] for row in kept]))
    found = np.exp(spline(np.log(rows[left_out]["a_over_b"])))
    np.testing.assert_allclose(found, [rows[left_out][k] for k in keys], rtol=0.02)


@pytest.mark.parametrize("ratio", [0.1, 0.3, 1.0, 1 / 0.3, 10.0])
def test_between_the_columns(touched_coefficients, ratio):
    """nu between the printed columns, against this package's own no-slip solution.

    The error of its grid, known at nu = 0 and 0.5 from Table 3, is taken off by interpolation in nu.
    """

    def no_slip(ratio: float, nu: float) -> np.ndarray:  # extrapolated from two grids, as in tests/test_no_slip.py
        coarse, fine = (touched_coefficients(ratio, nu, cells, offset=0.5) for cells in (12, 24))
        return 2 * fine - coarse

    errors = [no_slip(ratio, nu) - table(ratio, nu) for nu in (0.0, 0.5)]
    for nu in (0.125, 0.25, 0.4):
        error = (1 - 2 * nu) * errors[0] + 2 * nu * errors[1]
        np.testing.assert_allclose(no_slip(ratio, nu) - error, table(ratio, nu), rtol=0.015)


def table(ratio: float, nu: float) -> np.ndarray:
    found = creepage_coefficients(ratio, 1.0, nu)
    return np.array([getattr(found, name) for name in NAMES])


@given(st.floats(0.1, 10), st.floats(0, 0.5))
def test_signs_and_growth(ratio, nu):
    """(122), and no wiggles: C22 and C23 grow with a/b, C33 falls."""
    here, there = table(ratio, nu), table(min(ratio * 1.01, 10.0), nu)
    assert np.all(here > 0)
    assert there[1] >= here[1] * (1 - 1e-9)
    assert there[2] >= here[2] * (1 - 1e-9)
    assert there[3] <= here[3] * (1 + 1e-9)


def test_arrays():
    a, nu = np.array([1.0, 2.0, 5.0]), np.array([[0.1], [0.3]])
    found = creepage_coefficients(a, 2.0, nu)
    assert np.shape(found.C33) == (2, 3)
    assert found.C33[1, 2] == pytest.approx(creepage_coefficients(5.0, 2.0, 0.3).C33, rel=1e-14)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ((0.99, 10.0, 0.3), r"a/b = 0\.099.*0\.1, 10"),
        ((10.1, 1.0, 0.3), r"a/b = 10\.1.*0\.1, 10"),
        ((1.0, 1.0, 0.51), r"nu = 0\.51.*0, 0\.5"),
        ((1.0, 1.0, -0.1), r"nu = -0\.1"),
        ((1.0, 1.0, float("nan")), "nu = nan"),
        ((0.0, 1.0, 0.3), "a = 0"),
        ((1.0, -1.0, 0.3), "b = -1"),
        ((1.0, "2", 0.3), "b = '2'"),
    ],
)
def test_bad_input(arguments, words):
    with pytest.raises(vc.SceneError, match=words):
        creepage_coefficients(*arguments)
