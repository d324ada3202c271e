"""The extremes in their short form, and that wrong answers, NaN, hanging and dying processes are found out."""

import dataclasses
import os
import time
from functools import partial

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import varcontact as vc
from tests.extremes import harness
from tests.extremes.checks import distance, in_units
from tests.extremes.harness import FAILED, LIMIT, PASSED, REFUSED, extremes, judge
from tests.extremes.scenes import APPROXIMATE, LINE, MIRROR, ROLLING, Case, Reference, but, same

SMALL = dataclasses.replace(ROLLING, grid=vc.Grid(nx=5, ny=5))


@pytest.fixture(scope="module")
def short():
    return extremes(short=True)


def test_nothing_fails_at_the_extremes(short):
    failed = short[short["verdict"] == FAILED]
    assert failed.empty, harness.report(failed)
    assert set(short["group"]) == {case.group for case in harness.cases()}
    assert set(short["family"]) == set(harness.FAMILIES)


def test_each_exact_answer_is_held_against_something(short):
    exact = short[(short["verdict"] == PASSED) & ~short["family"].isin(APPROXIMATE)]
    assert len(exact) > 100
    assert (exact["error"].notna() | exact["agreement"].notna()).all()
    assert (exact["error"].isna() | (exact["error"] <= exact["cap"])).all()


def test_report_shows_every_scene_and_why_it_was_refused(short):
    text = harness.report(short)
    for case in short["case"]:
        assert case in text
    for reason in short["reason"]:
        assert reason in text


def test_names_of_cases_are_their_own():
    names = [(case.group, case.name) for case in harness.cases()]
    assert len(names) == len(set(names)) > 200


def names(table):
    """The verdicts and reasons by case and family."""
    rows = table.to_dict("records")
    return {(row["case"], row["family"]): (row["verdict"], row["reason"]) for row in rows}


def test_what_goes_wrong_is_found_out():
    """One after the other in one worker, which hangs and dies in between."""
    less = but(SMALL, friction=0.29)
    wrong = same("less friction", less())
    two = ("default", "active set")
    chosen = [
        Case("test", "right", but(SMALL), MIRROR, families=two),
        Case("test", "wrong", but(SMALL), wrong, families=two),
        Case("test", "hangs", partial(time.sleep, 60), families=("default",), seconds=0.5),
        Case("test", "dies", partial(os._exit, 7), families=("default",)),
        Case("test", "crashes", partial(int, "x"), families=("default",)),
        Case("test", "owed", but(LINE, surface=vc.Cylinders(1.0), motion=vc.Shift(ux=1.0)), families=two),
        Case("test", "not owed", but(SMALL, motion=vc.Steady(Fx=1.0)), answer=False, families=two),
        Case("test", "not there", but(SMALL), answer=False, families=two),
        Case("test", "limit", but(SMALL, normal_force=-1.0), families=("tang",), limits={"tang": "known"}),
        Case("test", "alone", but(SMALL), families=("active set",)),
        Case("test", "right again", but(SMALL), MIRROR, families=two),
    ]
    found = names(extremes(chosen=chosen))
    for case in ("right", "right again"):
        assert [found[case, family][0] for family in two] == [PASSED, PASSED]
    for family in two:
        verdict, reason = found["wrong", family]
        assert verdict == FAILED and "from less friction" in reason
        assert found["not owed", family][0] == REFUSED
        assert found["not there", family] == (FAILED, "an answer where there is none")
    assert found["hangs", "default"] == (FAILED, "no end within 0.5 s")
    assert found["dies", "default"] == (FAILED, "the process died with exit status 7")
    assert found["crashes", "default"][0] == FAILED and "ValueError" in found["crashes", "default"][1]
    assert found["owed", "default"][0] == FAILED and "reference_depth" in found["owed", "default"][1]
    assert ("owed", "active set") not in found  # a scene that cannot be made is refused once
    assert found["limit", "tang"][0] == LIMIT and found["limit", "tang"][1].startswith("known (normal_force = -1.0")
    assert found["alone", "active set"] == (FAILED, "nothing to hold it against")


def certified(sol, **changes):
    """A solution that was tampered with, under a certificate that says nothing of it."""
    return dataclasses.replace(sol, certificate=dataclasses.replace(sol.certificate, residual=0.0), **changes)


CASE = Case("test", "test", but(SMALL))


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
def test_no_certificate_hides_what_cannot_be(change, reason):
    sol = vc.solve(SMALL)
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


def test_a_residual_above_the_tolerance_is_no_pass():
    sol = vc.solve(SMALL)
    rough = dataclasses.replace(sol, certificate=dataclasses.replace(sol.certificate, residual=2e-8))
    assert judge(CASE, "default", rough)["verdict"] == FAILED
    assert judge(CASE, "conic", rough)["verdict"] == PASSED  # which is asked for less


def test_families_that_disagree_are_found_out():
    """Tractions that are wrong by a hundredth, admissible, and certified: the other families know better."""
    sol = vc.solve(SMALL)
    wrong = certified(sol, traction=0.99 * sol.traction)
    solutions = {"default": wrong, "active set": sol, "tang": sol}
    rows = [{"family": name, **judge(CASE, name, each)} for name, each in solutions.items()]
    assert [row["verdict"] for row in rows] == [PASSED] * 3
    rows = harness._agreeing(rows, solutions)
    assert rows[0]["verdict"] == FAILED and "from the answer of" in rows[0]["reason"]
    assert rows[0]["agreement"] == pytest.approx(0.01, rel=1e-6)


@settings(max_examples=20, deadline=None)
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


def test_a_table_is_gone_on_with(tmp_path):
    store, told = tmp_path / "extremes.csv", []
    chosen = [Case("test", name, but(SMALL), MIRROR, families=("active set",)) for name in ("one", "two")]
    extremes(chosen=chosen[:1], store=store)
    table = extremes(chosen=chosen, store=store, progress=told.append)
    assert told == ["2 of 2: test, two"]
    assert names(table) == {(case.name, "active set"): (PASSED, "") for case in chosen}
    assert len(harness.as_json(table)) > 200
    store.write_text("a,b\n1,2\n")
    with pytest.raises(vc.SceneError, match="earlier run"):
        extremes(chosen=chosen, store=store)


def test_an_interrupted_run_hands_over_what_is_finished():
    chosen = [Case("test", name, but(SMALL), MIRROR, families=("active set",)) for name in ("one", "two")]

    def interrupt(told):
        if "two" in told:
            raise KeyboardInterrupt

    with pytest.raises(vc.Interrupted) as stopped:
        extremes(chosen=chosen, progress=interrupt)
    assert names(stopped.value.partial) == {("one", "active set"): (PASSED, "")}


def test_nothing_chosen_is_refused():
    with pytest.raises(vc.SceneError, match="units, friction"):
        extremes(only="nonsense")


def test_references_take_the_grid_into_account():
    """A cap is added to what a residual may make of the tractions."""
    reference = Reference("one", lambda sol: 0.05, cap=0.05)
    sol = vc.solve(SMALL)
    assert judge(dataclasses.replace(CASE, reference=reference), "default", sol)["verdict"] == PASSED
    tight = dataclasses.replace(reference, cap=0.049)
    assert judge(dataclasses.replace(CASE, reference=tight), "default", sol)["verdict"] == FAILED
