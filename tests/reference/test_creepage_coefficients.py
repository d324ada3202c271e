"""The computed coefficients: closed forms, limits, reciprocity, fine grids, and Table 3 of the
paper.
"""

import csv
from dataclasses import astuple, replace
from decimal import Decimal
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import varcontact as vc
from tests.scenes import make_scene, refusals
from varcontact.reference import creepage_coefficients, no_slip_coefficients, no_slip_ellipse
from varcontact.reference.no_slip_table import HEAD, POISSON, RATIOS, lines

NAMES = ("C11", "C22", "C23", "C33")
TABLE_3 = Path(__file__).parents[1] / "data" / "table3_creepage_coefficients.csv"


def values(ratio: float, nu: float) -> np.ndarray:
    return np.array(astuple(no_slip_coefficients(ratio, nu)))


def computed(ratio: float, nu: float, degree: int = 64) -> np.ndarray:
    C = no_slip_ellipse(ratio, nu, degree)
    return np.array([C[0, 0], C[1, 1], C[1, 2], C[2, 2]])


def test_circle_in_closed_form():
    """nu = 0: the equations are those of a sine series, whose first coefficients are integrals of
    sines.
    """
    exact = np.array([32 / (3 * np.pi), 32 / (3 * np.pi), 4 / 3, 512 / (135 * np.pi)])
    np.testing.assert_allclose(computed(1.0, 0.0, 128), exact, rtol=1e-6)
    np.testing.assert_allclose(values(1.0, 0.0), exact, rtol=1e-6)


def test_the_error_falls_with_the_fourth_power_of_the_degree():
    exact = 32 / (3 * np.pi)
    errors = [computed(1.0, 0.0, degree)[0] / exact - 1 for degree in (8, 16, 32)]
    orders = np.log2(np.divide(errors[:-1], errors[1:]))
    assert np.all((orders > 3.0) & (orders < 4.3))


@pytest.mark.parametrize(("ratio", "nu"), [(0.3, 0.5), (1.0, -0.9), (2.0, 0.28), (30.0, 0.4)])
def test_reciprocity_and_symmetry(ratio, nu):
    """C32 = -C23, which nothing builds in; Fx by vy and spin, and Fy and Mz by vx, vanish."""
    C = no_slip_ellipse(ratio, nu)
    assert C[2, 1] == pytest.approx(-C[1, 2], rel=1e-8)
    np.testing.assert_allclose([*C[0, 1:], *C[1:, 0]], 0.0, atol=1e-9 * C[0, 0])


@pytest.mark.parametrize(
    ("ratio", "nu"),
    [
        (0.0123, 0.28),
        (0.0123, 0.5),
        (0.0345, -0.9),
        (0.21, 0.2),
        (1.6, -0.5),
        (10.4, 0.45),
        (95.0, 0.5),
    ],
)
def test_between_the_entries_of_the_table(ratio, nu):
    np.testing.assert_allclose(
        values(ratio, nu), computed(ratio, nu, 192), rtol=2e-5 if ratio < 0.1 else 2e-6
    )


def test_the_table_is_what_its_command_makes():
    stored = (
        (Path(vc.reference.__file__).parent / "creepage_coefficients.csv")
        .read_text(encoding="utf-8")
        .splitlines()
    )
    assert len(stored) == 1 + RATIOS.size * POISSON.size
    made = lines()
    assert next(made) == stored[0] == HEAD
    for text in (stored[70 * 13 + 7], stored[-1]):  # within and at the end, computed again
        ratio, nu, *entries = map(float, text.split(","))
        np.testing.assert_allclose(entries, computed(ratio, nu, 128), rtol=1e-8)


@pytest.mark.long
@pytest.mark.parametrize(("ratio", "nu"), [(0.1, 0.5), (1.0, 0.28)])
def test_fine_grids_of_the_package_itself(ratio, nu):
    """No slip on elements, which knows nothing of polynomials, extrapolated: within 0.15 %, C33
    within 0.5 %.
    """
    cells = np.array([48, 64, 80, 96])
    found = np.array([on_elements(ratio, nu, int(n)) for n in cells])
    limit = np.linalg.lstsq(np.vander(1 / cells, 2), found, rcond=None)[0][1]
    np.testing.assert_allclose(limit[:3], values(ratio, nu)[:3], rtol=1.5e-3)
    assert limit[3] == pytest.approx(values(ratio, nu)[3], rel=5e-3)


def on_elements(ratio: float, nu: float, cells: int) -> np.ndarray:
    """C11, C22, C23, C33 on the elements that an ellipse touches, as one of their total area."""
    a, b = ratio**0.5, ratio**-0.5
    grid = vc.Grid(nx=cells, ny=cells, edge="touched").spread((-a, a, -b, b))
    scene = make_scene(
        vc.Ellipse(a=a, b=b),
        1.0,
        vc.Steady(),
        grid,
        friction=float("inf"),
        bodies=vc.Bodies(G=1.0, nu=nu),
    )
    motions = [vc.Steady(**{name: 1.0}) for name in ("vx", "vy", "spin")]
    along, across, turning = (
        vc.solve(replace(scene, motion=motion), tangential="newton", certify=None, tol=1e-6)
        for motion in motions
    )
    product = np.count_nonzero(along.state) * grid.area / np.pi
    forces = np.array([along.force[0], across.force[1], turning.force[1], turning.moment])
    return -forces / product ** np.array([1.0, 1.0, 1.5, 2.0])


def test_table_3():
    """To the printed digit for a/b from 0.8 to 1.2; elsewhere Kalker's last digits are off, by 1.1
    % at most.

    The error of ours is below 1e-5. In the worst entry, C22 = 16.0 at a/b = 10 and nu = 0.5, it is
    16.17; fine grids give 16.18 there.
    """
    met, far = 0, {}
    with TABLE_3.open(encoding="utf-8") as text:
        for row in csv.DictReader(text):
            ratio = float(row["a_over_b"])
            # the file of the tests rounds 1/.9 to 1.11111
            ratio = ratio if ratio <= 1 else 1 / round(1 / ratio, 2)
            for nu, suffix in ((0.0, "nu0"), (0.5, "nu05")):
                for name, value in zip(NAMES, values(ratio, nu), strict=True):
                    printed = row[f"{name}_{suffix}"]
                    half = 0.5 * 10.0 ** int(Decimal(printed).as_tuple().exponent)
                    difference = abs(value - float(printed))
                    met += difference <= half
                    if difference > half:
                        assert not 0.79 < ratio < 1.2, (ratio, name, nu)
                        far[ratio, name, nu] = value / float(printed) - 1
    assert met == 83
    assert len(far) == 69
    assert max(far, key=lambda entry: abs(far[entry])) == (10.0, "C22", 0.5)
    assert max(np.abs(list(far.values()))) < 0.011


@pytest.mark.parametrize("nu", [-0.9, -0.5, 0.0, 0.28, 0.5])
@pytest.mark.parametrize("ratio", [1e-3, 1e-5, 1e-30])
def test_wide_contacts_are_plane(ratio, nu):
    """C11 tends to pi^2/(4 (1 - nu)), as Carter's, C22, by antiplane strain, to pi^2/4, C33 as its
    -y px; C23 grows.
    """
    C11, C22, C23, C33 = values(ratio, nu)
    assert C11 == pytest.approx(np.pi**2 / 4 / (1 - nu), rel=3e-5)
    assert C22 == pytest.approx(np.pi**2 / 4, rel=3e-5)
    assert C33 * ratio == pytest.approx(np.pi**2 / 16 / (1 - nu), rel=2e-4)
    ten_times, growth = (
        values(ratio / 10, nu)[2] * np.sqrt(10),
        np.pi * nu * np.log(10) / (3 * (1 - nu)),
    )
    assert (ten_times - C23) / np.sqrt(ratio) == pytest.approx(growth, abs=1e-3)
    if nu == 0:
        assert C23 == pytest.approx(np.pi * np.sqrt(ratio) / 3, rel=2e-4)


@pytest.mark.parametrize("nu", [-0.9, 0.0, 0.28, 0.5])
def test_slender_contacts(nu):
    """Asymptotes of C23 and C33 in closed form, of the computed entries; C11 and C22 nearly; and
    beyond the table.
    """
    for ratio in (1e3, 1e4):
        L = np.log(16 * ratio**2)
        less, D = L - 3 + np.log(4), (1 - nu) * L - 2 + 4 * nu
        C11, C22, C23, C33 = computed(ratio, nu)
        assert C23 == pytest.approx(2 * np.pi * ratio**1.5 / (3 * D), rel=2e-5)
        assert C33 == pytest.approx(np.pi / 4 * (1 - nu * (L - 4) / D) ** 2, rel=2e-4)
        assert C11 == pytest.approx(2 * np.pi * ratio / (less - 2 * nu), rel=2e-3)
        assert C22 == pytest.approx(2 * np.pi * ratio / ((1 - nu) * less + 2 * nu), rel=2e-3)
        np.testing.assert_allclose(values(ratio, nu), [C11, C22, C23, C33], rtol=5e-4)


@settings(max_examples=50)
@given(st.floats(0.01, 100), st.floats(0, 0.5))
def test_signs_and_growth(ratio, nu):
    """(122), and no wiggles: C22 and C23 grow with a/b, C33 falls."""
    here, there = values(ratio, nu), values(ratio * 1.01, nu)
    assert np.all(here > 0)
    assert there[1] >= here[1]
    assert there[2] >= here[2]
    assert there[3] <= here[3]


test_bad_input = refusals(
    (lambda: creepage_coefficients(0.0, 1.0, 0.3), "^a = 0"),
    (lambda: creepage_coefficients(1.0, -1.0, 0.3), "^b = -1"),
    (lambda: creepage_coefficients(1.0, "2", 0.3), "^b = '2'"),
    (lambda: no_slip_coefficients(np.inf, 0.3), "^a_over_b = inf"),
    (lambda: no_slip_coefficients([1.0, np.nan], 0.3), r"^a_over_b\[1\] = nan .*positive"),
    (lambda: no_slip_coefficients(1.0, -1.0), r"^nu = -1.* Poisson's ratio in \(-1, 0\.5\]"),
    (lambda: no_slip_coefficients(1.0, 0.51), r"^nu = 0\.51 "),
    (lambda: no_slip_coefficients(1.0, float("nan")), "^nu = nan"),
    (lambda: no_slip_coefficients(1.0, [[0.1, 0.2], [0.3, 0.6]]), r"^nu\[1, 1\] = 0\.6 .*Poisson"),
    (lambda: no_slip_coefficients(1.0, "steel"), "^nu = 'steel'"),
    (lambda: no_slip_ellipse(1e-5, 0.3), r"a_over_b = 1e-05 .*\[0\.0001, 10000\]"),
    (lambda: no_slip_ellipse(1.0, 0.6), r"nu = 0\.6 .*Poisson"),
    (lambda: no_slip_ellipse(1.0, 0.3, 1), "degree = 1 .*2 or more"),
)


def test_the_page_has_the_computed_values():
    page = (Path(__file__).parents[2] / "docs" / "fast_theories.md").read_text(encoding="utf-8")
    rows = [
        line.strip("| ").split(" | ")
        for line in page.splitlines()
        if line.startswith(("| 0.", "| 1"))
    ]
    assert len(rows) == 11
    for name, *figures in rows:
        ratio = 1 / float(name[2:]) if name.startswith("1/") else float(name)
        found = [no_slip_coefficients(ratio, nu) for nu in (0.0, 0.5)]
        assert figures == [f"{getattr(each, key):.5g}" for key in NAMES for each in found], name
