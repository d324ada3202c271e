"""The coupling loop by itself: where it ends."""

import dataclasses

import numpy as np
import pytest

from varcontact.coupling import ContactState, panagiotopoulos

START = ContactState(np.ones((1, 1)), 0.0, np.zeros((2, 1, 1)), np.zeros(2))


def passes(solved):
    """How many passes it makes of ``p = 1 - 0.9 q, q = p``, where solvers say so whether they solved it."""
    answers = iter(solved)

    def normal(state):
        return dataclasses.replace(state, pressure=1 - 0.9 * state.traction[0])

    def tangential(state):
        told = {"tangential": next(answers, True)}
        return dataclasses.replace(state, traction=np.stack([state.pressure] * 2), solved=told, status={})

    state = panagiotopoulos(START, normal, tangential, tol=1e-6, max_passes=500)
    return len(state.changes) - 1, state


def test_solvers_that_solve():
    """The linear iteration's rate 0.9, and its fixed point 1/1.9."""
    count, state = passes([])
    assert state.pressure[0, 0] == pytest.approx(1 / 1.9, rel=1e-6)
    rates = np.array(state.changes[2:]) / state.changes[1:-1]
    np.testing.assert_allclose(rates[-20:], 0.9, rtol=1e-3)
    assert 100 < count < 200


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
