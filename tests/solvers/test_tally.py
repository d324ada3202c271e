"""Counts of calls: by name, and each solver's own time."""

import pytest

from varcontact.solvers.tally import Tally


def test_a_call_inside_another_takes_its_own_time(monkeypatch):
    """By a clock that the test sets: the seconds of all solvers add up to those that passed, none counted twice."""
    tally, now = Tally(), [0.0]
    monkeypatch.setattr("varcontact.solvers.tally.time.perf_counter", lambda: now[0])
    for _ in range(2):
        with tally.called("outer"):
            now[0] += 1.0
            with tally.called("inner"):
                now[0] += 3.0
            now[0] += 0.5
    outer, inner = tally.calls["outer"], tally.calls["inner"]
    assert (outer.count, inner.count) == (2, 2)
    assert (outer.seconds, inner.seconds) == (3.0, 6.0)


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
