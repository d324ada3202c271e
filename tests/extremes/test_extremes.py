"""The extremes in their short form, and that wrong answers and NaN are found out."""

import dataclasses
from functools import partial

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import varcontact as vc
from tests.extremes.checks import distance, in_units
from tests.extremes.judge import FAILED, LIMIT, PASSED, REFUSED, agreeing, cases, judge, rows_of
from tests.extremes.scenes import APPROXIMATE, LINE, MIRROR, ROLLING, Case, Reference, but, same

SMALL = dataclasses.replace(ROLLING, grid=vc.Grid(nx=5, ny=5))
CASE = Case("test", "test", but(SMALL))


@pytest.fixture(scope="module")
def sol():
    return vc.solve(SMALL)


@pytest.mark.parametrize(
    "case", [case for case in cases() if case.short], ids=lambda case: f"{case.group}, {case.name}"
)
def test_nothing_fails_at_the_extremes(case):
    """Each exact answer is held against something."""
    rows = rows_of(case)
    assert not [row for row in rows if row["verdict"] == FAILED]
    for row in rows:
        if row["verdict"] == PASSED and row["family"] not in APPROXIMATE:
            assert "agreement" in row or row["error"] <= row["cap"]


def test_names_of_cases_are_their_own():
    names = [(case.group, case.name) for case in cases()]
    assert len(names) == len(set(names)) > 200


TWO = ("default", "active set")
CASES = {
    "right": (Case("", "", but(SMALL), MIRROR, families=TWO), PASSED, ""),
    "wrong": (Case("", "", but(SMALL), same("less", but(SMALL, friction=0.29)()), families=TWO), FAILED, "from less"),
    "crashes": (Case("", "", partial(int, "x"), families=("default",)), FAILED, "ValueError"),
    "owed": (
        Case("", "", but(LINE, surface=vc.Cylinders(1.0), motion=vc.Shift(ux=1.0)), families=TWO),
        FAILED,
        "reference_depth",
    ),
    "not owed": (Case("", "", but(SMALL, motion=vc.Steady(Fx=1.0)), answer=False, families=TWO), REFUSED, ""),
    "not there": (Case("", "", but(SMALL), answer=False, families=TWO), FAILED, "an answer where there is none"),
    "limit": (
        Case("", "", but(SMALL, normal_force=-1.0), families=("tang",), limits={"tang": "known"}),
        LIMIT,
        "known (normal_force = -1.0",
    ),
    "alone": (Case("", "", but(SMALL), families=("active set",)), FAILED, "nothing to hold it against"),
}


@pytest.mark.parametrize("name", CASES)
def test_what_goes_wrong_is_found_out(name):
    case, verdict, reason = CASES[name]
    rows = rows_of(case)
    assert len(rows) == (1 if name == "owed" else len(case.families))  # what cannot be made is refused once
    assert all(row["verdict"] == verdict and reason in row["reason"] for row in rows)


def certified(sol, **changes):
    """A solution that was tampered with, under a certificate that says nothing of it."""
    return dataclasses.replace(sol, certificate=dataclasses.replace(sol.certificate, residual=0.0), **changes)


@pytest.mark.parametrize(
    ("change", "reason"),
    [
        (lambda sol: {"traction": np.nan * sol.traction}, "NaN"),
        (lambda sol: {"pressure": np.where(sol.pressure > 0, sol.pressure, np.inf)}, "NaN"),
        (lambda sol: {"approach": np.nan}, "NaN"),
        (lambda sol: {"pressure": 0.9 * sol.pressure}, "normal force"),
        (lambda sol: {"pressure": sol.pressure - 1e-3}, "pull"),
        (lambda sol: {"traction": 2 * sol.traction}, "above f Fz"),
        (lambda sol: {"traction": sol.traction * np.linspace(0.0, 1.5, 7)}, "beyond their bound"),
    ],
)
def test_no_certificate_hides_what_cannot_be(sol, change, reason):
    assert judge(CASE, "default", sol)["verdict"] == PASSED
    row = judge(CASE, "default", certified(sol, **change(sol)))
    assert row["verdict"] == FAILED and reason in row["reason"]


def test_force_along_the_creepage_and_force_that_was_not_asked_for():
    slow = vc.solve(dataclasses.replace(SMALL, motion=vc.Steady(vx=0.01)))
    row = judge(CASE, "fastsim", certified(slow, traction=-slow.traction))
    assert (row["verdict"], row["reason"]) == (FAILED, "a force along the creepage")
    forced = vc.solve(dataclasses.replace(SMALL, motion=vc.Steady(Fx=-0.1)))
    row = judge(CASE, "default", certified(forced, traction=0.99 * forced.traction))
    assert row["verdict"] == FAILED and "in place of -0.1" in row["reason"]


def test_a_residual_above_the_tolerance_is_no_pass(sol):
    rough = dataclasses.replace(sol, certificate=dataclasses.replace(sol.certificate, residual=2e-8))
    assert judge(CASE, "default", rough)["verdict"] == FAILED
    assert judge(CASE, "conic", rough)["verdict"] == PASSED  # which is asked for less


def test_families_that_disagree_are_found_out(sol):
    """Tractions that are wrong by a hundredth, admissible, and certified: the other families know better."""
    solutions = {"default": certified(sol, traction=0.99 * sol.traction), "active set": sol, "tang": sol}
    rows = [{"family": name, **judge(CASE, name, each)} for name, each in solutions.items()]
    assert [row["verdict"] for row in rows] == [PASSED] * 3
    first = agreeing(rows, solutions)[0]
    assert first["verdict"] == FAILED and "from the answer of" in first["reason"]
    assert first["agreement"] == pytest.approx(0.01, rel=1e-6)


@settings(max_examples=10)
@given(length=st.floats(-9, 6), modulus=st.floats(-12, 15))
def test_units_do_not_matter(length, modulus):
    """Forces and approach of the same scene in any units; and back in its own it is the same scene."""
    length, modulus = 10.0**length, 10.0**modulus
    there = vc.solve(in_units(SMALL, length, modulus), tangential="tang-safeguarded")
    here = vc.solve(SMALL, tangential="tang-safeguarded")
    np.testing.assert_allclose(there.force, here.force * modulus * length**2, rtol=1e-10)
    assert there.approach == pytest.approx(here.approach * length, rel=1e-10)
    assert there.moment == pytest.approx(here.moment * modulus * length**3, rel=1e-10)
    assert distance(there, here, length, modulus) < 1e-10
    back = in_units(in_units(SMALL, length, modulus), 1 / length, 1 / modulus)
    assert back.motion.spin == pytest.approx(SMALL.motion.spin)
    assert back.normal_force == pytest.approx(SMALL.normal_force)


def test_references_take_the_grid_into_account(sol):
    """A cap is added to what a residual may make of the tractions."""
    for cap, verdict in ((0.05, PASSED), (0.049, FAILED)):
        reference = Reference("one", lambda sol: 0.05, cap=cap)
        assert judge(dataclasses.replace(CASE, reference=reference), "default", sol)["verdict"] == verdict
