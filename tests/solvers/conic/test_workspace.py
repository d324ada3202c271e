"""Set-ups that are used again: with the same data, with new vectors, with new matrices; nothing stale."""

import dataclasses

import numpy as np
import pytest

import varcontact as vc
from varcontact.discrete.discretisation import discretise
from varcontact.discrete.state import hertz_pressure, unloaded
from varcontact.solvers.conic.backends import solve_normal, solve_tangential
from varcontact.solvers.conic.programs import Workspace, normal_potential, normal_program
from varcontact.solvers.interface import Settings

GRID = vc.Grid(nx=8, ny=8).spread((-1.2, 1.2, -0.9, 0.9))
CLOSE = {"normal": 1e-8, "tangential": 1e-5}
"""Both answers are near the one solution, not near each other: see tests/conic/test_accuracy.py."""


def fresh_and_kept(solve, name, problems, tol, **settings):
    """Answers in a row with one store of set-ups, and each from nothing."""
    workspace = Workspace()
    for posed in problems:
        kept = solve(name, posed, Settings(1e-8, workspace=workspace, **settings))
        fresh = solve(name, posed, Settings(1e-8, **settings))
        size = np.abs(fresh.traction).max()
        assert size > 0
        np.testing.assert_allclose(kept.traction, fresh.traction, atol=tol * size)
        np.testing.assert_allclose(kept.rigid, fresh.rigid, atol=tol * max(np.abs(fresh.rigid).max(), 1.0))
    return workspace


def normal_problems(rolling):
    """The same; other vectors; other matrices (another nu); the first again; another structure."""
    disc = discretise(rolling(), GRID)
    first = disc.normal_problem()
    x, y = disc.points
    bumpy = dataclasses.replace(first, distance=first.distance + 0.1 * np.sin(9 * x + 4 * y).ravel() + 0.1)
    heavier = dataclasses.replace(first, force=1.7 * first.force)
    softer = discretise(rolling(bodies=vc.Bodies(G=1.0, nu=-0.3)), GRID).normal_problem()
    by_approach = dataclasses.replace(first, force=None, approach=0.7 * float(np.median(first.distance))).reachable()
    return [first, first, bumpy, heavier, softer, softer, first, by_approach, first]


QP = [
    "clarabel",
    "osqp",
    "scs",
    *(f"qpsolvers:{name}" for name in ("piqp", "proxqp", "daqp", "quadprog", "osqp", "highs")),
    *(f"cvxpy:{name}" for name in ("CLARABEL", "OSQP", "SCS", "PIQP")),
]
NORMAL = [(name, formulation) for formulation in ("complementary", "potential") for name in QP]
NORMAL.remove(("qpsolvers:quadprog", "potential"))  # it takes no singular P, see tests/test_methods.py


@pytest.mark.parametrize(("name", "formulation"), NORMAL)
def test_normal(rolling, name, formulation):
    fresh_and_kept(solve_normal, name, normal_problems(rolling), CLOSE["normal"], formulation=formulation)


@pytest.mark.parametrize("name", ["clarabel", "scs", "cvxpy:CLARABEL", "cvxpy:SCS"])
@pytest.mark.parametrize("kind", ["steady", "shift"])
def test_tangential(rolling, name, kind):
    motions = (
        [vc.Steady(vx=0.05, vy=-0.02, spin=0.03), vc.Steady(vx=0.04, vy=0.03), vc.Steady(vx=0.5), vc.Steady(Fx=-0.1)]
        if kind == "steady"
        else [vc.Shift(ux=0.1, uy=-0.06, rotation=0.05), vc.Shift(ux=0.09), vc.Shift(uy=1.0), vc.Shift(Fx=-0.1)]
    )
    problems = []
    for motion in (motions[0], motions[0], motions[1], motions[2], motions[3], motions[0]):
        for nu in (0.28, 0.0) if motion is motions[1] else (0.28,):
            disc = discretise(rolling(motion=motion, bodies=vc.Bodies(G=1.0, nu=nu)), GRID)
            problems.append(disc.tangential_problem(hertz_pressure(disc, unloaded(GRID)).pressure))
    fresh_and_kept(solve_tangential, name, problems, CLOSE["tangential"])


def test_what_is_found(rolling):
    """Same matrices or not, same structure or not."""
    first, _, bumpy, _, softer, _, _, by_approach, _ = (normal_program(p) for p in normal_problems(rolling))
    workspace = Workspace()
    assert workspace.find("key", first) == (None, False)
    workspace.keep("key", first, "kept")
    assert workspace.find("key", first) == ("kept", True)
    assert workspace.find("key", bumpy) == ("kept", True)
    assert workspace.find("other", first) == (None, False)
    assert workspace.find("key", by_approach) == (None, False)
    assert workspace.find("key", normal_potential(normal_problems(rolling)[0])) == (None, False)
    changed = dataclasses.replace(first, P=first.P * 2.0)
    assert workspace.find("key", changed) == ("kept", False)
    assert workspace.find("key", softer)[0] == "kept"


def test_a_warm_start_saves_iterations(rolling):
    """Splitting begins where it ended: solving the same again takes fewer iterations."""
    posed = discretise(rolling(), GRID).normal_problem()
    workspace = Workspace()
    first, again = (solve_normal("scs", posed, Settings(1e-6, workspace=workspace)) for _ in range(2))
    assert again.iterations < first.iterations
