"""The coupling loop by itself: where it ends."""

import dataclasses

import numpy as np
import pytest

from varcontact.coupling import ContactState, panagiotopoulos

SIZE = 40
START = ContactState(np.ones((1, SIZE)), 0.0, np.zeros((2, 1, SIZE)), np.zeros(2))
MATRIX = np.diag(np.linspace(-0.9, 0.9, SIZE))


def passes(solved):
    """How many passes it makes of ``p = 1 + M q, q = p``, where solvers say so whether they solved it."""
    answers = iter(solved)

    def normal(state):
        return dataclasses.replace(state, pressure=1 + state.traction[0] @ MATRIX)

    def tangential(state):
        told = {"tangential": next(answers, True)}
        return dataclasses.replace(state, traction=np.stack([state.pressure] * 2), solved=told)

    def residual(state):
        return float(np.abs(state.traction[0] - 1 - state.traction[0] @ MATRIX).max())

    state = panagiotopoulos(START, normal, tangential, residual, tol=1e-8, max_passes=500)
    return len(state.passes) - 1, state


def test_solvers_that_solve():
    """The fixed point ``(1 - M)^-1 1``, sooner than by repeating at the rate 0.9, which takes some 170 passes."""
    count, state = passes([])
    np.testing.assert_allclose(state.pressure[0], 1 / (1 - np.diag(MATRIX)), rtol=1e-6)
    assert 6 < count < 100


@pytest.mark.parametrize(
    ("solved", "expected"),
    [
        ([True, True, False, False], 3),
        ([True, True, False, True, False, False], 5),
        ([False, False, True, False], None),
    ],
)
def test_two_failures_in_a_row_end_it(solved, expected):
    """One alone does not; the first answer of all is the start of the loop, and no pass."""
    assert passes(solved)[0] == (expected if expected is not None else passes([])[0])
