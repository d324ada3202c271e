"""The coupling loop by itself: where it ends."""

import dataclasses

import numpy as np
import pytest

from varcontact.discrete.state import ContactState
from varcontact.solving.coupling import FixedPoint, Limits, Unknown

SIZE = 40
START = ContactState(np.ones((1, SIZE)), 0.0, np.zeros((2, 1, SIZE)), np.zeros(2))
MATRIX = np.diag(np.linspace(-0.9, 0.9, SIZE))


def passes(solved, useless=True):
    """How many passes it makes of ``p = 1 + M q, q = p``, where solvers say so whether they solved it.

    What they did not solve is as useful as nothing, or as an answer nearly to the tolerance.
    """
    answers = iter(solved)

    def normal(state):
        return dataclasses.replace(state, pressure=1 + state.traction[0] @ MATRIX)

    def tangential(state):
        told = {"tangential": next(answers, True)}
        traction = np.stack([state.pressure] * 2)
        if useless and not told["tangential"]:
            traction = state.traction
        return dataclasses.replace(state, traction=traction, solved=told)

    def residual(state):
        return float(np.abs(state.traction[0] - 1 - state.traction[0] @ MATRIX).max())

    first = tangential(START)
    loop = FixedPoint(first, residual(first), Unknown("traction"), Limits(1e-8, passes=500))
    while loop.goes_on:
        after = tangential(normal(loop.state))
        loop.add(after, residual(after))
    return len(loop.best.passes) - 1, loop.best


def test_solvers_that_solve():
    """The fixed point ``(1 - M)^-1 1``, sooner than by repeating at the rate 0.9, which takes some 170 passes."""
    count, state = passes([])
    np.testing.assert_allclose(state.pressure[0], 1 / (1 - np.diag(MATRIX)), rtol=1e-6)
    assert 6 < count < 100


@pytest.mark.parametrize(
    ("solved", "expected"), [([True, True, False, False], 3), ([True, True, False, True, False, False], 5)]
)
def test_two_failures_in_a_row_end_it(solved, expected):
    """The first answer of all is the start of the loop, and no pass."""
    assert passes(solved)[0] == expected


def test_single_failures_do_not_end_it():
    count, state = passes([False, False, True, False])
    assert count > 6
    np.testing.assert_allclose(state.pressure[0], 1 / (1 - np.diag(MATRIX)), rtol=1e-6)


def test_solvers_that_fail_and_come_nearer_all_the_same():
    """An interior point may say AlmostSolved in every pass: while the whole comes nearer, that ends nothing."""
    count, state = passes([False] * 300, useless=False)
    assert count == passes([])[0]
    np.testing.assert_allclose(state.pressure[0], 1 / (1 - np.diag(MATRIX)), rtol=1e-6)
