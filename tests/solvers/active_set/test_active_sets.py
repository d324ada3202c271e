"""TANG: with exact Newton steps as printed, with inexact ones, where the first fail, and the
safeguarded version.
"""

import dataclasses

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import varcontact as vc
from varcontact.discrete.discretisation import discretise
from varcontact.discrete.problems import RawSolution
from varcontact.discrete.residuals import normal_residual, tangential_residual
from varcontact.discrete.state import hertz_pressure, unloaded
from varcontact.solvers.active_set.norm import norm
from varcontact.solvers.active_set.tang import no_slip, tang, tang_safeguarded
from varcontact.solvers.conic.backends import PROGRAM_SOLVERS
from varcontact.solvers.full_slip import full_slip
from varcontact.solvers.interface import Settings

HARD = 1.0644223380502587


def posed(scene, marching=False):
    half = scene.hertz
    grid = vc.Grid(nx=8, ny=8).spread((-half.a, half.a, -half.b, half.b))
    disc = discretise(scene, grid)
    return disc.tangential_problem(hertz_pressure(disc, unloaded(grid)).pressure, marching=marching)


@pytest.mark.parametrize(
    "motion",
    [
        vc.Steady(vx=0.05, vy=-0.02),
        vc.Steady(Fx=-0.1, vy=0.02),
        vc.Shift(ux=0.1, uy=-0.06, rotation=0.05),
        vc.Shift(Fx=0.1, Fy=0.1, rotation=0.1),
    ],
)
def test_all_versions_agree(rolling, motion):
    problem = posed(rolling(motion=motion))
    printed, inexact, safe = tang(problem, newton="exact"), tang(problem), tang_safeguarded(problem)
    assert inexact.iterations < printed.iterations
    for raw in (printed, inexact, safe):
        assert raw.status == "Solved" and raw.solved
        assert tangential_residual(problem, raw.traction, raw.rigid) < 1e-12
        again = tang(problem, raw)
        assert again.status == "Solved"
        assert again.iterations <= 3, "from the answer there is nothing left to exchange"
    for raw in (printed, inexact):
        np.testing.assert_allclose(raw.traction, safe.traction, atol=1e-12)
        np.testing.assert_allclose(raw.rigid, safe.rigid, atol=1e-12)


def test_where_the_printed_version_fails(rolling, check_kkt):
    """Its Newton steps do not converge on the areas they are given (one of 150 random scenes); it
    says so, and what it has stays with the error, certified. With rough steps it ends on the way,
    and the safeguarded version does, too.
    """
    motion = vc.Steady(vx=0.17206842471240194, vy=-0.008071772446747002, spin=-0.6875214986851099)
    scene = rolling(
        surface=vc.Ellipse(a=HARD, b=1 / HARD), motion=motion, grid=vc.Grid(nx=12, ny=12)
    )
    with pytest.raises(
        vc.NotConverged, match=r"tang-exact says '(NewtonFailed|Cycled)'"
    ) as failure:
        vc.solve(scene, tangential="tang-exact")
    best = failure.value.solution
    assert best.status["tangential"] in ("NewtonFailed", "Cycled")
    assert not best.converged
    assert best.certificate.relative_gap > 1e-4 and np.isfinite(best.certificate.relative_gap)
    assert failure.value.residual == best.certificate.residual > 1e-3
    assert np.all(np.hypot(*best.traction) <= best.traction_bound * (1 + 1e-12)), (
        "admissible all the same"
    )
    for other in ("tang", "tang-safeguarded"):
        sol = vc.solve(scene, tangential=other)
        assert sol.status["tangential"] == "Solved"
        check_kkt(sol, 1e-11)
        np.testing.assert_allclose(sol.traction, vc.solve(scene).traction, atol=1e-11)
    assert np.all(np.abs(sol.force - best.force) <= best.certificate.force_bound[:2]), (
        "the gap's bound holds"
    )


def test_a_transient_step(rolling):
    """As a march builds it: symmetric, with the displacements of the step before. Not the one of
    steady rolling.
    """
    problem = posed(rolling(), marching=True)
    before = 0.5 * tang_safeguarded(problem).traction
    carried = problem.instant.apply(before) - problem.operator.apply(before)
    step = dataclasses.replace(
        problem,
        operator=problem.instant,
        rigid_shift=problem.rigid_shift - carried,
        symmetric=True,
        instant=None,
    )
    matrix = step.operator.matrix
    np.testing.assert_allclose(matrix, matrix.T, atol=1e-14)
    printed, safe, program = (
        tang(step),
        tang_safeguarded(step),
        PROGRAM_SOLVERS["clarabel"].tangential(step, Settings(1e-8)),
    )
    assert printed.status == safe.status == "Solved"
    np.testing.assert_allclose(printed.traction, safe.traction, atol=1e-12)
    # A gap of 1e-12 bounds the energy of the error, not its largest element: 4e-5 where stick meets
    # slip.
    np.testing.assert_allclose(program.traction, safe.traction, atol=2e-4)
    np.testing.assert_allclose(tang_safeguarded(step, program).traction, safe.traction, atol=1e-12)
    assert np.abs(safe.traction - tang_safeguarded(problem).traction).max() > 1e-2


def test_what_is_not_solved_says_so(rolling):
    """Ended at its limit, even where the start it came from was called solved."""
    problem = posed(rolling())
    start = dataclasses.replace(no_slip(problem), solved=True)
    raw = tang_safeguarded(problem, start, max_steps=1)
    assert raw.status == "MaxIterations" and not raw.solved
    assert tang_safeguarded(problem, dataclasses.replace(raw, solved=False)).solved


@settings(max_examples=12)
@given(vx=st.floats(-0.2, 0.2), spin=st.floats(-0.3, 0.3), seed=st.integers(0, 10**6))
def test_safeguarded_from_any_start(rolling, vx, spin, seed):
    """Through its name: where a start leads nowhere, its own start is tried."""
    from varcontact.solvers.registry import solver

    problem = posed(rolling(motion=vc.Steady(vx=vx, spin=spin)))
    if not problem.rigid_shift.any():
        return
    start = RawSolution(np.random.default_rng(seed).normal(size=(2, problem.size)), np.zeros(2))
    raw = solver("tangential", "tang-safeguarded")(problem, Settings(), start)
    assert raw.status == "Solved"
    assert tangential_residual(problem, raw.traction, raw.rigid) < 1e-11


# ----------------------------------------------------------------------------- NORM


GRID = vc.Grid(nx=10, ny=10).spread((-1.2, 1.2, -0.9, 0.9))


def problem(rolling, prescribed, traction):
    """On the whole grid; with tractions of unlike bodies, which change the distance (point 1 of the
    paper).
    """
    scene = rolling(bodies=vc.Bodies(G=(1.0, np.inf), nu=(0.1, 0.3)), grid=GRID)
    if prescribed == "approach":
        scene = dataclasses.replace(scene, normal_force=None, approach=scene.hertz.approach)
    disc = discretise(scene, GRID)
    given = None
    if traction:
        x, y = disc.points
        given = 0.3 * np.array([np.cos(3 * x + y), np.sin(2 * y)])
    return disc.normal_problem(given)


@pytest.mark.parametrize("traction", [False, True])
@pytest.mark.parametrize("prescribed", ["force", "approach"])
def test_all_ways_lead_to_the_same_end(rolling, prescribed, traction):
    posed = problem(rolling, prescribed, traction)
    printed = norm(posed)
    assert printed.status == "Solved"
    assert normal_residual(posed, printed.traction, printed.rigid) < 1e-13
    assert printed.iterations <= 12, "whole sets: a few exchanges for a hundred elements"
    rng = np.random.default_rng(1)
    wrong = RawSolution(rng.random(posed.distance.size), np.array([1.0]))  # everywhere
    corner = RawSolution(np.eye(1, posed.distance.size)[0], np.array([1.0]))  # where there is none
    for start in (None, printed, wrong, corner):
        for exchange in ("set", "one"):
            again = norm(posed, start, exchange=exchange)
            assert again.status == "Solved"
            np.testing.assert_allclose(
                again.traction, printed.traction, atol=1e-12 * printed.traction.max()
            )
            assert again.rigid[0] == pytest.approx(printed.rigid[0], rel=1e-13)
    assert norm(posed, printed).iterations == 1, "the answer is its own first contact"


def test_tractions_change_the_pressure(rolling):
    """K != 0: what is given in point 1 matters."""
    without, with_ = (norm(problem(rolling, "force", traction)) for traction in (False, True))
    assert np.abs(with_.traction - without.traction).max() > 1e-2 * without.traction.max()


@pytest.mark.parametrize("exchange", ["set", "one"])
def test_too_few_exchanges_are_named(rolling, exchange):
    raw = norm(problem(rolling, "force", False), exchange=exchange, max_exchanges=2)
    assert raw.status == "MaxIterations" and not raw.solved
    assert raw.traction.min() >= 0, "admissible in any case"


def test_single_exchanges_are_one_element_each(rolling):
    """As printed (no contact at all), each exchange brings in one element at most."""
    posed = problem(rolling, "approach", False)
    one, many = norm(posed, exchange="one"), norm(posed)
    assert one.iterations > np.sum(one.traction > 0)
    assert many.iterations < one.iterations / 4


@pytest.mark.long
@settings(max_examples=20)
@given(seed=st.integers(0, 10**6), force=st.floats(1e-3, 10.0))
def test_rough_surfaces(rolling, seed, force):
    """Any distance at all: both kinds of exchange end at the one solution."""
    posed = problem(rolling, "force", False)
    rough = np.random.default_rng(seed).random(posed.distance.size)
    posed = dataclasses.replace(posed, distance=rough, force=force)
    one = norm(posed, exchange="one")
    assert one.status == "Solved"
    assert normal_residual(posed, one.traction, one.rigid) < 1e-11
    whole = norm(posed)
    if whole.status == "Solved":  # no proof is known for whole sets; when they end, they end there
        np.testing.assert_allclose(whole.traction, one.traction, atol=1e-10 * one.traction.max())
    else:
        assert whole.status == "Cycled"


SLIDING = 3.0, 1.0, 0.1
"""Creepages with which everything slips, and the shift is larger than elasticity gives way."""


@pytest.mark.parametrize("seed", range(0, 27, 3))
def test_full_slip_by_products_is_the_answer_of_newtons_method(seed, tangential_problem):
    problem = tangential_problem(seed, friction=0.1, creepage=SLIDING, rolling=True)
    if problem.free:
        assert full_slip(problem, Settings()) is None
        return
    found = full_slip(problem, Settings())
    printed = tang(problem, newton="exact")
    assert printed.solved
    largest = problem.bound.max()
    np.testing.assert_allclose(found.traction, printed.traction, atol=1e-10 * largest)
    assert tangential_residual(problem, found.traction, found.rigid) < 1e-11
    # from the answer one product more
    assert full_slip(problem, Settings(), found).iterations <= 2
    # an element that is new to the contact has no traction yet
    traction = found.traction.copy()
    traction[:, problem.size // 2] = 0.0
    again = full_slip(problem, Settings(), dataclasses.replace(found, traction=traction))
    np.testing.assert_allclose(again.traction, found.traction, atol=1e-12 * largest)


def test_what_sticks_is_left_to_newtons_method(tangential_problem):
    problem = tangential_problem(1, friction=0.6, creepage=(0.01, 0.0, 0.0), rolling=True)
    assert full_slip(problem, Settings()) is None
    # a shift large enough everywhere, but for one element
    problem = tangential_problem(0, friction=0.1, creepage=SLIDING, rolling=True)
    shift = problem.rigid_shift.copy()
    shift[:, shift.shape[1] // 2] = 0.0
    assert full_slip(dataclasses.replace(problem, rigid_shift=shift), Settings()) is None
