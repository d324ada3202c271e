"""All fast theories by name: slopes, full slip, symmetries, power, many contacts in one call,
refusals.
"""

from functools import partial

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import varcontact as vc
from tests.scenes import refusals
from varcontact.reference import creepage_coefficients
from varcontact.theories import (
    fastrip,
    fastsim,
    linear_forces,
    polach,
    strip,
    table_forces,
    vermeulen_johnson,
    vermeulen_johnson_traction,
)
from varcontact.theories.creep_forces import VECTORISED

CONTACT = {"a": 1.2, "b": 0.8, "G": 1.0, "nu": 0.28, "normal_force": 1.0, "friction": 0.3}
LIMIT = 0.3
TABLE = creepage_coefficients(1.2, 0.8, 0.28)
UNIT = 3 * LIMIT / (1.2 * 0.8 * TABLE.C11)
MIXED = ["fastrip", "fastsim", "fastsim-elliptic", "linear"]
BOUNDED = [name for name in VECTORISED if name != "linear"]
size = st.floats(-3.0, 3.0)


def parts(found: vc.CreepForces) -> np.ndarray:
    return np.array([found.Fx, found.Fy, found.Mz])


def spin_of(name: str, spin: float) -> float:
    return 0.0 if name == "vermeulen-johnson" else spin


@pytest.mark.parametrize("name", MIXED)
@pytest.mark.parametrize("ratio", [0.05, 0.5, 1.5, 20.0])
def test_slopes_of_mixed_creepages(name, ratio):
    """Forces by small creepages, however mixed, are those of the coefficients; by few strips and
    points, too.
    """
    contact = {**CONTACT, "a": ratio**0.5, "b": ratio**-0.5}
    rng = np.random.default_rng(3)
    vx, vy, spin = 1e-10 * rng.normal(size=(3, 20))
    exact = vc.creep_forces("linear", **contact, vx=vx, vy=vy, spin=spin)
    options = {} if name in ("linear", "table") else {"m": 7, "n": 5}
    found = vc.creep_forces(name, **contact, vx=vx, vy=vy, spin=spin, **options)
    scale = np.abs([exact.Fx, exact.Fy]).max()
    np.testing.assert_allclose(
        [found.Fx, found.Fy], [exact.Fx, exact.Fy], rtol=0, atol=1e-5 * scale
    )


def test_slopes_of_strip_theory_are_its_own():
    slopes = {
        "vx": np.pi**2 / 4 / 0.72 * 0.96,
        "vy": np.pi**2 / 4 * 0.96,
        "spin": np.pi / 3 * 1.5**0.5 * 0.96**1.5,
    }
    for name, slope in slopes.items():
        found = vc.creep_forces("strip", **CONTACT, **{name: 1e-12})
        assert found.Fx + found.Fy == pytest.approx(-slope * 1e-12, rel=1e-4)


@pytest.mark.parametrize("name", BOUNDED)
@pytest.mark.parametrize("division", [{}, {"m": 3, "n": 2}])
def test_full_slip_is_the_limit_of_friction(name, division):
    options = division if name not in ("polach", "vermeulen-johnson", "table") else {}
    to = 1e-6 if name == "table" else 1e-9  # a book is interpolated, and in single precision
    angles = np.linspace(0.1, 6.2, 13)
    found = vc.creep_forces(
        name, **CONTACT, vx=1e12 * np.cos(angles), vy=1e12 * np.sin(angles), **options
    )
    np.testing.assert_allclose(np.hypot(found.Fx, found.Fy), LIMIT, rtol=to)
    if name != "polach":
        np.testing.assert_allclose(found.Mz, 0.0, atol=max(1e-12, to - 1e-9))


@pytest.mark.parametrize("name", BOUNDED)
def test_directions_of_full_slip(name):
    """Against the creepage, or against the creepage weighted by what each theory weights its slopes
    with.
    """
    straight = name in ("polach", "table") or "weighted" in name
    weights = (
        (1.0, 1.0) if straight else (1 / 0.72, 1.0) if name == "strip" else (TABLE.C11, TABLE.C22)
    )
    found = vc.creep_forces(name, **CONTACT, vx=1e9, vy=-2e9)
    against = -np.array([weights[0], -2.0 * weights[1]])
    np.testing.assert_allclose(
        [found.Fx, found.Fy], LIMIT * against / np.hypot(*against), rtol=0, atol=1e-5 * LIMIT
    )


@pytest.mark.parametrize("name", VECTORISED)
@settings(max_examples=60, deadline=None)
@given(vx=size, vy=size, spin=size)
def test_symmetries_power_and_the_limit_of_friction(name, vx, vy, spin):
    """All creepages turned: all forces turned. Mirrored about x: Fx even, Fy and Mz odd in vy and
    spin.
    """
    creepage = np.array([vx, vy, spin_of(name, spin)]) * UNIT

    def forces(signs, creepage=creepage):
        return parts(
            vc.creep_forces(
                name, **CONTACT, **dict(zip(("vx", "vy", "spin"), creepage * signs, strict=True))
            )
        )

    here = forces((1, 1, 1))
    np.testing.assert_allclose(forces((-1, -1, -1)), -here, atol=1e-12)
    np.testing.assert_allclose(forces((1, -1, -1)), here * [1, -1, -1], atol=1e-12)
    assert name == "linear" or np.hypot(*here[:2]) <= LIMIT * (1 + 1e-9)
    if name == "polach":
        creepage = creepage * (1, 1, 0)
        here = forces((1, 1, 1), creepage)
    assert here[creepage != 0] @ creepage[creepage != 0] <= 1e-12


def test_moment_of_vermeulen_and_johnson():
    """That of their tractions, summed over points."""
    vy = 0.4 * UNIT
    x, y = np.meshgrid(np.linspace(-1.2, 1.2, 1201), np.linspace(-0.8, 0.8, 1201))
    py = vermeulen_johnson_traction(x, y, 1.2, 0.8, 1.0, LIMIT, (0.0, vy, 0.0), TABLE)[1]
    moment = np.sum(x * py) * 0.002 * 1.6 / 1200
    assert vc.creep_forces("vermeulen-johnson", **CONTACT, vy=vy).Mz == pytest.approx(
        moment, rel=1e-3
    )


@pytest.mark.parametrize("name", VECTORISED)
def test_shapes(name):
    """Any of the arguments may be an array of any shape, of no length as well; results are those of
    single calls.
    """
    nu, vx = np.array([[0.28], [0.281]]), np.array([0.1, 0.2, 0.0])
    found = vc.creep_forces(name, **{**CONTACT, "nu": nu, "vx": vx})
    each = [
        [parts(vc.creep_forces(name, **{**CONTACT, "nu": one, "vx": v})) for v in vx]
        for one in nu[:, 0]
    ]
    np.testing.assert_allclose(parts(found), np.moveaxis(each, -1, 0), rtol=1e-13, atol=1e-14)
    for empty in ("a", "nu", "vx", "spin"):
        assert vc.creep_forces(name, **{**CONTACT, empty: []}).Mz.shape == (0,)
    nothing = {key: np.zeros((0, 2)) for key in (*CONTACT, "vx", "vy", "spin")}
    assert vc.creep_forces(name, **nothing).Fy.shape == (0, 2)


@pytest.mark.parametrize("name", VECTORISED)
def test_the_smallest_creepages(name):
    """Nothing is divided by zero where sizes underflow."""
    with np.errstate(divide="raise", invalid="raise", over="raise"):
        found = vc.creep_forces(name, **CONTACT, vx=5e-324, vy=-1e-300, spin=spin_of(name, 5e-324))
        alone = vc.creep_forces(name, **CONTACT, vx=5e-324)
    assert max(abs(found.Fx), abs(found.Fy), abs(alone.Fx), abs(alone.Fy)) < 1e-298


def test_contaminated_rails():
    """Reduced coefficients: the slope falls, full slip does not."""
    for name in ("linear", "fastsim", "fastrip", "polach", "vermeulen-johnson"):
        clean, dirty = (
            vc.creep_forces(name, **CONTACT, vx=[1e-9, 1e6], slope=slope) for slope in (1.0, 0.4)
        )
        assert dirty.Fx[0] == pytest.approx(0.4 * clean.Fx[0], rel=1e-5)
        assert dirty.Fx[1] == pytest.approx(
            (0.4 if name == "linear" else 1.0) * clean.Fx[1], rel=1e-3
        )
    wet = vc.creep_forces("polach", **CONTACT, vx=1e-9, k_A=0.3, k_S=0.1)
    assert wet.Fx == pytest.approx(0.2 * vc.creep_forces("linear", **CONTACT, vx=1e-9).Fx, rel=1e-6)


def test_outside_the_table_book_the_ellipse_of_the_same_area_with_the_nearest_ratio_counts():
    """Long and broad ellipses and one between, in one call, with reduced slopes; each as a call for
    its stand-in.
    """
    a, b, within = np.array([12.0, 1.0, 0.3]), np.array([1.0, 0.8, 4.5]), np.array([5.0, 1.25, 0.2])
    rest = {"G": 1.0, "nu": 0.28, "normal_force": 1.0, "friction": 0.3, "slope": 0.6}
    rest |= {"vx": 0.1, "vy": -0.05, "spin": 0.03}
    found = vc.creep_forces("table", a=a, b=b, outside="clamp", **rest)
    nearest = vc.creep_forces("table", a=np.sqrt(a * b * within), b=np.sqrt(a * b / within), **rest)
    np.testing.assert_allclose(parts(found), parts(nearest), rtol=1e-9)
    single = vc.creep_forces("table", a=12.0, b=1.0, outside="clamp", **rest)
    np.testing.assert_allclose(parts(single), parts(found)[:, 0], rtol=1e-9)


test_bad_input = refusals(
    ({"theory": "fastsims"}, "theory = 'fastsims' .*fastsim"),
    ({"a": [1.0, -1.0]}, r"a\[1\] = -1"),
    ({"nu": 0.6}, r"nu = 0\.6 .*Poisson's ratio in \(-1, 0\.5\]"),
    ({"nu": -1.0}, r"nu = -1"),
    ({"vx": [[0.0, 1.0], [np.nan, 0.0]]}, r"vx\[1, 0\] = nan"),
    ({"spin": [0.0, np.inf]}, r"spin\[1\] = inf"),
    ({"friction": 0.0}, "friction = 0"),
    ({"normal_force": "heavy"}, "normal_force = 'heavy'"),
    ({"vx": [1.0, 2.0], "vy": [1.0, 2.0, 3.0]}, r"do not broadcast: vx \(2,\), vy \(3,\)"),
    ({"bodies": vc.Bodies(G=1.0, nu=0.3)}, "give bodies, or G and nu, not both"),
    ({"G": None}, "give bodies, or both G and nu"),
    ({"G": None, "nu": None, "bodies": vc.Bodies(G=(1.0, 2.0), nu=0.3)}, "quasi-identical .*K is"),
    ({"theory": "vermeulen-johnson", "spin": [0.0, 0.1]}, r"spin = 0\.1 .*must be 0"),
    ({"slope": 1.2}, r"slope = 1\.2 .*\(0, 1\]"),
    ({"theory": "strip", "slope": 0.5}, "no creepage coefficients"),
    ({"m": 1}, "m = 1 .*2 or more"),
    ({"k_A": 0.5}, "k_A is no option of fastsim: must be one of m, n"),
    (
        {"theory": "table", "a": [1.0, 9.0], "b": 1.0},
        r"a/b\[1\] = 9\.0 .*outside=.clamp. takes the nearest",
    ),
    ({"theory": "table", "outside": "extrapolate"}, "outside = 'extrapolate' .*refuse, clamp"),
    ({"theory": "linear", "m": 5}, "m is no option of linear: must be left out"),
    ({"theory": "polach", "k_A": 0.5, "k_S": 0.6}, "k_A, k_S"),
    ({"theory": "polach", "k_A": "dry"}, "k_A = 'dry'"),
    ({"theory": "polach", "k_S": [0.4, 0.4]}, r"k_S = \[0\.4, 0\.4\]"),
    ({"m": 10**9}, "m = 1000000000 .*from 2 to 100000"),
    ({"theory": "strip", "n": 10**9}, "n = 1000000000 .*from 1 to 100000"),
    ({"theory": "table", "nu": [0.28, 0.4]}, r"nu\[1\] = 0\.4 .*make a book"),
    ({"theory": "table", "book": "steel.nc"}, r"book = 'steel\.nc' .*must be a TableBook"),
    (
        {"theory": "fastrip", "a": 0.01, "b": 1.0, "nu": -0.9, "spin": 1.0},
        "C23 = -0.* must be positive",
    ),
    of=partial(vc.creep_forces, theory="fastsim", **CONTACT),
)


THREE = np.ones((3, 3)) * [0.1, 0.1, 0.0]
NAMED = r"do not broadcast: friction_force \(2,\), vx \(3,\)$"
test_shapes_that_do_not_broadcast_are_named_by_the_functions_behind = refusals(
    (lambda: fastrip(1.2, 0.8, 1.0, [0.3, 0.3], THREE, TABLE), NAMED),
    (lambda: fastsim(1.2, 0.8, 1.0, [0.3, 0.3], THREE, TABLE), NAMED),
    (lambda: polach(1.2, 0.8, 1.0, [0.3, 0.3], THREE, TABLE), NAMED),
    (lambda: strip(1.2, 0.8, 1.0, 0.28, [0.3, 0.3], THREE), NAMED),
    (lambda: vermeulen_johnson(1.2, 0.8, 1.0, [0.3, 0.3], THREE, TABLE), NAMED),
    (lambda: table_forces(1.2, 0.8, 1.0, [0.3, 0.3], THREE), NAMED),
    (
        lambda: linear_forces([1.2, 1.0], 0.8, 1.0, THREE, TABLE),
        r"do not broadcast: a \(2,\), vx \(3,\)$",
    ),
    (
        lambda: vc.no_slip_coefficients([1.0, 2.0], [0.1, 0.2, 0.3]),
        r"do not broadcast: a_over_b \(2,\), nu \(3,\)$",
    ),
)


def test_the_functions_behind():
    creepage = np.array([0.5, -0.3, 0.4]) * UNIT
    contact = (1.2, 0.8, 1.0, LIMIT)
    of = dict(zip(("vx", "vy", "spin"), creepage, strict=True))
    expected = {
        "linear": linear_forces(1.2, 0.8, 1.0, creepage, TABLE),
        "fastrip": fastrip(*contact, creepage, TABLE),
        "strip": strip(1.2, 0.8, 1.0, 0.28, LIMIT, creepage),
        "fastsim": fastsim(*contact, creepage, TABLE, division="calibrated"),
        "fastsim-weighted": fastsim(
            *contact, creepage, TABLE, division="calibrated", flexibility="weighted"
        ),
        "fastsim-elliptic": fastsim(
            *contact, creepage, TABLE, division="calibrated", bound="elliptic"
        ),
    }
    for name, exact in expected.items():
        found = vc.creep_forces(name, **CONTACT, **of)
        np.testing.assert_allclose(
            parts(found), [*exact.force, exact.moment], rtol=1e-12, err_msg=name
        )
    force = vc.creep_forces("polach", **CONTACT, **of)
    np.testing.assert_allclose([force.Fx, force.Fy], polach(*contact, creepage, TABLE), rtol=1e-12)
    assert np.isnan(force.Mz)
    without = vc.creep_forces("vermeulen-johnson", **CONTACT, vx=creepage[0], vy=creepage[1])
    exact = vermeulen_johnson(*contact, (*creepage[:2], 0.0), TABLE)
    np.testing.assert_allclose([without.Fx, without.Fy], exact, rtol=1e-12)
