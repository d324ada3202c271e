"""A clock for budgets of time."""

from types import SimpleNamespace

import pytest

from varcontact.solvers import settings
from varcontact.solving.on_demand import climb
from varcontact.solving.on_demand.ladder import Ladder


@pytest.fixture
def clock(monkeypatch):
    """Time that goes by with the elements solved, as Newton's method takes it: the same however busy the machine is."""
    clock, posed = SimpleNamespace(now=0.0), Ladder.posed

    def timed(ladder, scene, n):
        clock.now += 0.01 + 5e-6 * ladder.elements(n) ** 1.1
        return posed(ladder, scene, n)

    monkeypatch.setattr(Ladder, "posed", timed)
    for module in (climb, settings):
        monkeypatch.setattr(module, "time", SimpleNamespace(perf_counter=lambda: clock.now))
    return clock
