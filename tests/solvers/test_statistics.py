"""Counts of calls: by name, and each solver's own time."""

import pytest

from varcontact.solvers.interface import SolveStats


def test_a_call_inside_another_takes_its_own_time(monkeypatch):
    """By a clock that the test sets: the seconds of all solvers add up to those that passed, none counted twice."""
    stats, now = SolveStats(), [0.0]
    monkeypatch.setattr("varcontact.solvers.interface.time.perf_counter", lambda: now[0])
    for _ in range(2):
        with stats.called("outer"):
            now[0] += 1.0
            with stats.called("inner"):
                now[0] += 3.0
            now[0] += 0.5
    outer, inner = stats.calls[""]["outer"], stats.calls[""]["inner"]
    assert (outer.count, inner.count) == (2, 2)
    assert (outer.seconds, inner.seconds) == (3.0, 6.0)


def test_calls_that_fail_are_counted():
    stats = SolveStats()
    with pytest.raises(ZeroDivisionError), stats.called("outer"), stats.called("inner"):
        _ = 1 / 0
    stats.iterated("inner", 3)
    with stats.called("outer"):
        pass
    assert {name: (calls.count, calls.iterations) for name, calls in stats.calls[""].items()} == {
        "inner": (1, 3),
        "outer": (2, 0),
    }
