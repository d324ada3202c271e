"""A clock for budgets of time."""

from types import SimpleNamespace

import pytest

from varcontact.solvers import interface
from varcontact.solving import adaptive


@pytest.fixture
def clock(monkeypatch):
    """Time that goes by with the elements solved: the same however busy the machine is."""
    clock, solve = SimpleNamespace(now=0.0), adaptive._solved

    def timed(scene, *rest):
        clock.now += 0.01 + 5e-5 * scene.grid.size
        return solve(scene, *rest)

    monkeypatch.setattr(adaptive, "_solved", timed)
    for module in (adaptive, interface):
        monkeypatch.setattr(module, "time", SimpleNamespace(perf_counter=lambda: clock.now))
    return clock
