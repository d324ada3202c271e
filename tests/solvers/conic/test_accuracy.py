"""One request, the same meaning to every solver: errors of the tractions against those asked
for.
"""

import numpy as np
import pytest

import varcontact as vc
from varcontact.discrete.discretisation import discretise
from varcontact.discrete.problems import NormalProblem
from varcontact.discrete.state import hertz_pressure, unloaded
from varcontact.solvers.active_set.norm import norm
from varcontact.solvers.active_set.tang import tang_safeguarded
from varcontact.solvers.conic.backends import BACKENDS
from varcontact.solvers.interface import Settings, natural_residual
from varcontact.solvers.registry import solver

GRID = vc.Grid(nx=8, ny=8).spread((-1.2, 1.2, -0.9, 0.9))
REQUESTS = (1e-2, 1e-4, 1e-6, 1e-8)


def errors(solve, posed, exact, formulation):
    """Largest error of a traction by the largest traction, for each request."""
    found = []
    for tol in REQUESTS:
        raw = solve(posed, Settings(tol, formulation), None)
        found.append(np.abs(raw.traction - exact.traction).max() / np.abs(exact.traction).max())
    return np.array(found)


def falls(found, worse):
    """No error above its request by more than `worse`, and none much above that of a laxer
    request.
    """
    assert np.all(found <= worse * np.array(REQUESTS) + 1e-9), found
    # solvers that stop at whole iterations may be lucky at a lax request
    assert np.all(found[1:] <= 3 * np.maximum(found[:-1], np.array(REQUESTS[1:]))), found


QP = [
    *(f"qpsolvers:{name}" for name in BACKENDS),
    "clarabel",
    "osqp",
    "scs",
    "cvxpy:PROXQP",
    "cvxpy:HIGHS",
]
NORMAL = [(name, formulation) for formulation in ("complementary", "potential") for name in QP]
# it takes no singular P, see tests/test_methods.py
NORMAL.remove(("qpsolvers:quadprog", "potential"))


@pytest.mark.parametrize(("name", "formulation"), NORMAL)
def test_normal(rolling, name, formulation):
    posed = discretise(rolling(), GRID).normal_problem().reachable()
    # in the potential form the tractions are multipliers, known to fewer digits
    falls(
        errors(solver("normal", name), posed, norm(posed), formulation),
        1.0 if formulation == "complementary" else 10.0,
    )


@pytest.mark.parametrize("name", ["clarabel", "scs", "cvxpy:CLARABEL", "cvxpy:SCS"])
@pytest.mark.parametrize(
    ("kind", "formulation"),
    [("steady", "gap"), ("shift", "complementary"), ("shift", "potential"), ("shift", "gap")],
)
def test_tangential(rolling, name, kind, formulation):
    motion = (
        vc.Steady(vx=0.05, vy=-0.02, spin=0.03)
        if kind == "steady"
        else vc.Shift(ux=0.1, uy=-0.06, rotation=0.05)
    )
    disc = discretise(rolling(motion=motion), GRID)
    posed = disc.tangential_problem(hertz_pressure(disc, unloaded(GRID)).pressure)
    found = errors(solver("tangential", name), posed, tang_safeguarded(posed), formulation)
    # Cones: one traction where stick meets slip is worse than the gap to the power 2/3; 33 times
    # the request was seen.
    assert np.all(found <= 50 * np.array(REQUESTS) + 1e-6), found
    assert found[2] < 1e-2 * found[0] or found[0] < 1e-5
    assert found[3] <= 3 * max(found[2], 1e-7)


@pytest.mark.parametrize("name", ["circle, 8 across", "pure vx, 12 across"])
def test_operator_splitting_is_asked_for_more_than_the_tolerance(name):
    """SCS ends at residuals of its own, by which tractions are up to seven times as wrong."""
    posed = vc.benchmark_problems()[name].program().contact_problem
    kind = "normal" if isinstance(posed, NormalProblem) else "tangential"
    raw = solver(kind, "scs")(posed, Settings(1e-3), None)
    assert natural_residual(posed, raw) <= 1e-3


@pytest.mark.parametrize("name", sorted(BACKENDS))
def test_requests_turn_into_the_solvers_own(name):
    """Smaller requests, smaller numbers, and never below what doubles can do."""
    for tol in (1e-2, 1e-6, 1e-10, 1e-30):
        asked = BACKENDS[name].options(tol)
        laxer = BACKENDS[name].options(10 * tol)
        for key, value in asked.items():
            if isinstance(value, float):
                assert value <= laxer[key]
                assert value == 0 or value >= 1e-14
