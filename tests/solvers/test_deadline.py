"""Solvers end at a deadline, between two of their iterations."""

import math
import time

import numpy as np
import pytest

import varcontact as vc
from tests.scenes import make_scene
from varcontact.discrete.discretisation import discretise
from varcontact.solvers.active_set.norm import norm
from varcontact.solvers.active_set.tang import tang, tang_safeguarded
from varcontact.solvers.conic.backends import PROGRAM_SOLVERS
from varcontact.solvers.conic.programs import normal_program
from varcontact.solvers.interface import OutOfTime, Settings, SolveStats
from varcontact.solvers.newton.normal import newton_normal
from varcontact.solvers.newton.tangential import newton_tangential
from varcontact.solvers.splitting.method import splitting_normal, splitting_tangential

LATE = -math.inf


@pytest.fixture(scope="module")
def problems(rolling):
    """The normal and the tangential problem of a scene."""
    sol = vc.solve(rolling(grid=vc.Grid(nx=16, ny=16)))
    disc = discretise(sol.scene, sol.grid)
    return disc.normal_problem(), disc.tangential_problem(sol.pressure / disc.scales.pressure)


SOLVERS = {
    "norm": lambda normal, _, late: norm(normal, deadline=late.deadline),
    "norm-single": lambda normal, _, late: norm(normal, exchange="one", deadline=late.deadline),
    "tang": lambda _, tangential, late: tang(tangential, deadline=late.deadline),
    "tang-safeguarded": lambda _, tangential, late: tang_safeguarded(tangential, settings=late),
    "newton, pressures": lambda normal, _, late: newton_normal(normal, late),
    "newton, tractions": lambda _, tangential, late: newton_tangential(tangential, late),
    "splitting, pressures": lambda normal, _, late: splitting_normal(normal, late),
    "splitting, tractions": lambda _, tangential, late: splitting_tangential(tangential, late),
    "clarabel, pressures": lambda normal, _, late: PROGRAM_SOLVERS["clarabel"].normal(normal, late),
    "osqp, pressures": lambda normal, _, late: PROGRAM_SOLVERS["osqp"].normal(normal, late),
    "scs, tractions": lambda _, tangential, late: PROGRAM_SOLVERS["scs"].tangential(
        tangential, late
    ),
}


@pytest.mark.parametrize("name", SOLVERS)
def test_a_solver_ends_at_its_deadline(problems, name):
    assert np.isfinite(SOLVERS[name](*problems, Settings()).traction).all()
    with pytest.raises(OutOfTime):
        SOLVERS[name](*problems, Settings(deadline=LATE))


@pytest.mark.parametrize("name", ["clarabel", "osqp", "scs"])
def test_solvers_of_programs_are_given_the_time_that_is_left(problems, name):
    """None of it: they end by themselves, before they have solved the program."""
    program, solver = normal_program(problems[0]), PROGRAM_SOLVERS[name]
    assert solver.call(program, Settings()).solved
    ended = solver.call(program, Settings(deadline=LATE))
    assert not ended.solved and "time" in ended.status.lower(), ended.status


@pytest.mark.long
def test_a_time_budget_is_kept_within_a_solver():
    """One element at a time, NORM takes half a minute on the grid that is expected to take a
    second.
    """
    scene = make_scene(vc.Paraboloids(Rx=1.0, Ry=1.0), 1e-3, vc.Steady(vx=0.02, spin=0.05))
    begun = time.process_time()
    sol = vc.solve(scene, normal="norm-single", time_budget=1.0)
    assert len(sol.error_estimate.solves) > 1 and time.process_time() - begun < 5.0


# ----------------------------------------------------------------------------- Counts of calls


def test_a_call_inside_another_takes_its_own_time(monkeypatch):
    """By a clock that the test sets: the seconds of all solvers add up to those that passed, none
    counted twice.
    """
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
