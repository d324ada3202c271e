"""NORM: as printed, from a guess, and one element at a time."""

import dataclasses

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import varcontact as vc
from varcontact.discrete.discretisation import discretise
from varcontact.discrete.problems import RawSolution
from varcontact.discrete.residuals import normal_residual
from varcontact.solvers.active_set.norm import norm

GRID = vc.Grid(nx=10, ny=10).spread((-1.2, 1.2, -0.9, 0.9))


def problem(rolling, prescribed, traction):
    """On the whole grid; with tractions of unlike bodies, which change the distance (point 1 of the paper)."""
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
    wrong = RawSolution(rng.random(posed.distance.size), np.array([1.0]), 0, "")  # everywhere
    corner = RawSolution(np.eye(1, posed.distance.size)[0], np.array([1.0]), 0, "")  # where there is none
    for start in (None, printed, wrong, corner):
        for exchange in ("set", "one"):
            again = norm(posed, start, exchange=exchange)
            assert again.status == "Solved"
            np.testing.assert_allclose(again.traction, printed.traction, atol=1e-12 * printed.traction.max())
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
