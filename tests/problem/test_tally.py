"""Counts of calls: by name, and each solver's own time."""

import time

import pytest

from varcontact.solvers.tally import Tally


def test_a_call_inside_another_takes_its_own_time():
    """The seconds of all solvers add up to those that passed, none counted twice."""
    tally, begun = Tally(), time.perf_counter()
    for _ in range(2):
        with tally.called("outer"):
            time.sleep(0.01)
            with tally.called("inner"):
                time.sleep(0.03)
    lasted = time.perf_counter() - begun
    outer, inner = tally.calls["outer"], tally.calls["inner"]
    assert (outer.count, inner.count) == (2, 2)
    assert outer.seconds + inner.seconds == pytest.approx(lasted, abs=0.01)
    assert inner.seconds >= 0.06
    assert 0.02 <= outer.seconds < inner.seconds


def test_calls_that_fail_are_counted():
    tally = Tally()
    with pytest.raises(ZeroDivisionError), tally.called("outer"), tally.called("inner"):
        _ = 1 / 0
    tally.iterated("inner", 3)
    with tally.called("outer"):
        pass
    assert {name: (calls.count, calls.iterations) for name, calls in tally.calls.items()} == {
        "inner": (1, 3),
        "outer": (2, 0),
    }
