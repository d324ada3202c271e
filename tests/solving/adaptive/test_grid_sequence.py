"""The one rule of finer and finer grids."""

import numpy as np
import pytest

from varcontact.solving.grid_sequence import FLOOR, GRIDS, ORDER, GridSequence, coarsest


def test_elements_across_on_each_grid():
    """Counted, or as the sides of elements have them; narrow patches may ask for more."""
    counted = GridSequence(6)
    sides = GridSequence(14.0, whole=False)
    for _ in range(4):
        counted.learn("answer")
        sides.learn("answer")
    assert counted.across == [6, 9, 14, 21]
    assert sides.across == [14.0, 21.0, 31.5, 47.25]
    assert counted.finer(3.0) == 63
    counted.learn("answer", 40)  # on a finer grid than was proposed
    assert counted.n == 60


def test_the_last_grids_tell_the_error():
    """A value that tends to 1 by the order of the rule is found, and its error is a bound."""
    sequence = GridSequence(coarsest(False, 0.01))
    while len(sequence.levels) < 5:
        assert sequence.few == (len(sequence.levels) < GRIDS)
        sequence.learn({"Fx": 1 + 3 * sequence.n**-ORDER})
    assert sequence.last == sequence.levels[-GRIDS:]
    value, error = sequence.extrapolated(lambda level: level["Fx"])
    last = 3 * sequence.across[-1] ** -ORDER
    assert value == pytest.approx(1 + last / 2)
    assert error == pytest.approx(1.25 * last)
    assert np.abs(value - 1) < error


@pytest.mark.parametrize("accuracy", [0.1, 0.01, 0.001])
def test_the_floor_takes_half_of_the_accuracy_on_the_third_grid(accuracy):
    """Unless the coarsest grid is fine enough."""
    sequence = GridSequence(coarsest(False, accuracy))
    for _ in range(GRIDS):
        sequence.learn(None)
    assert FLOOR * sequence.across[-1] ** -ORDER <= 0.5 * accuracy
