"""What "auto" stands for: active sets, and Newton's method without a matrix where many elements are
in contact.
"""

import numpy as np
import pytest

import varcontact as vc
from varcontact.solvers.registry import matrix_free
from varcontact.solving.selection import NEWTON_ABOVE

MANY_CELLS = vc.Grid(nx=40, ny=40)
UNLIKE, BALL = vc.Bodies(G=(1.0, 3.0), nu=0.3), vc.Paraboloids(1.0, 1.0)
PLACES = np.linspace(-2, 2, 15)
TWO_ARCS = np.minimum((PLACES - 0.5) ** 2, (PLACES + 0.5) ** 2)
SAMPLES = vc.SampledDistance(TWO_ARCS[:, None] + PLACES**2 / 2, x=PLACES, y=PLACES)


@pytest.mark.parametrize(
    "changes",
    [
        {"grid": MANY_CELLS},
        {"grid": MANY_CELLS, "motion": vc.Shift(ux=0.01)},
        {"grid": MANY_CELLS, "motion": vc.Steady(Fx=-0.1)},
        {"grid": vc.Grid(nx=80, ny=80, dx=0.05, dy=0.05, x0=-2.0, y0=-2.0)},
        {"grid": MANY_CELLS, "friction": np.inf},
        {
            "surface": vc.Cylinders(R=1.0),
            "motion": vc.Steady(vx=0.01),
            "grid": vc.Grid(nx=3 * NEWTON_ABOVE),
        },
    ],
)
def test_auto_with_many_elements(rolling, changes):
    plan = vc.plan(rolling(**changes))
    assert (plan.normal, plan.tangential) == ("hertz", "newton")
    assert matrix_free("tangential", plan.tangential)
    assert "matrix-free" in plan.reasons["tangential"]
    assert not plan.sizes.mirrored


@pytest.mark.parametrize(
    ("changes", "choices", "words"),
    [
        (
            {"friction": np.inf},
            {},
            "infinite friction has no traction bound that follows the pressure",
        ),
        ({}, {"normal": "norm"}, 'it needs "newton" for both problems, not normal = "norm"'),
        ({}, {"method": "active-set"}, 'not normal = "norm" and tangential = "tang-safeguarded"'),
        (
            {},
            {"formulation": "marching", "tangential": "newton", "normal": "newton"},
            "a march solves its steps in",
        ),
    ],
)
def test_newton_for_both_is_refused_with_the_reason(rolling, changes, choices, words):
    with pytest.raises(vc.SceneError, match='"panagiotopoulos": ') as refused:
        vc.plan(rolling(bodies=UNLIKE, **changes), coupling="newton", **choices)
    assert words in str(refused.value)


@pytest.mark.parametrize("solver", ["newton", "splitting"])
def test_a_solver_for_both_brings_its_own_along(rolling, solver):
    plan = vc.plan(rolling(bodies=UNLIKE), coupling=solver)
    assert (plan.normal, plan.tangential, plan.coupling) == (solver, solver, solver)
    assert (
        "pressure and tractions together; falls back to alternating passes"
        in plan.reasons["coupling"]
    )


def test_auto_with_many_elements_jointly(rolling):
    plan = vc.plan(rolling(grid=MANY_CELLS, bodies=UNLIKE), coupling="joint")
    assert (plan.normal, plan.tangential, plan.coupling) == ("newton", "newton", "joint")
    few = vc.plan(rolling(bodies=UNLIKE), coupling="joint")
    assert (few.normal, few.tangential) == ("norm", "tang-safeguarded")


@pytest.mark.parametrize(
    ("cells", "friction", "methods"),
    [
        (13, 0.3, ("norm", "tang-safeguarded")),
        (14, 0.3, ("norm", "newton")),
        (22, 0.3, ("norm", "newton")),
        (23, 0.3, ("newton", "newton")),
        (22, None, ("norm", "none")),
        (23, None, ("newton", "none")),
    ],
)
def test_samples_by_elements(rolling, cells, friction, methods):
    """Pressures by active sets up to 400 elements in contact, tractions up to 140."""
    motion, grid = None if friction is None else vc.Steady(vx=0.01), vc.Grid(nx=cells, ny=cells)
    plan = vc.plan(rolling(motion=motion, surface=SAMPLES, friction=friction, grid=grid))
    assert (plan.normal, plan.tangential) == methods
