"""Roots of functions in closed form: with folds, kinks and jumps, and those that have none."""

import numpy as np
import pytest

from varcontact.wheel_rail.bracketing import Lattice


def last(functions, axes):
    """The last point that is tried, to the end of the first bracket."""
    found = [point for point, end in Lattice(functions, 400).brackets(axes) if end]
    return found[0] if found else None


def test_a_kink_and_a_jump_of_one_function():
    kinked = last(lambda x: np.array([min(3.3 - x[0], 10 * (3.3 - x[0]))]), 1)
    assert kinked == pytest.approx([3.3], abs=1e-4)
    jumps = last(lambda x: np.array([1.0 if x[0] < -2.7 else -1.0]), 1)
    assert jumps == pytest.approx([-2.7], abs=1e-5)


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_the_curve_on_which_the_first_function_is_zero_may_turn_back(sign):
    """A cubic, along which neither coordinate grows all the way, and its point reflection."""

    def functions(point):
        x, y = sign * np.array(point) / 4
        return sign * np.array([y - x + 3 * (np.tanh(2 * x) - np.tanh(x / 2)), 1.3 - y - 0.2 * x])

    found = last(functions, 2)
    assert found is not None
    assert functions(found) == pytest.approx([0.0, 0.0], abs=1e-2)


def test_without_a_root_the_nearest_point_is_known():
    lattice = Lattice(
        lambda x: np.array([2.5 - x[0], 2.0 + x[1] ** 2]) if abs(x[1]) < 9 else None, 400
    )
    assert list(lattice.brackets(2)) == []
    number, point, value = lattice.nearest
    assert (number, point.tolist(), value) == (1, [2.5, 0.0], 2.0)


def test_a_jump_beside_the_root_leaves_a_point_in_its_bracket():
    """Linear functions across the jump have their root elsewhere; what is tried last is near it."""

    def functions(point):
        x, y = point
        jump = 0.5 if x > 2.45 else 0.0
        return np.array([0.5 * (2.3 - x) - 0.8 * (y - 1.2) + jump, 1.7 - 0.7 * x - 2 * jump])

    assert last(functions, 2) == pytest.approx([2.43, 1.1], abs=0.4)


def test_a_jump_within_a_side_does_not_hide_the_root():
    """Between corners the first function jumps, so that it seems to vanish where the second has the
    other sign; it vanishes at x = -.5 - .2 y, and the second there at y = .75.
    """

    def functions(point):
        x, y = point
        first = 10.0 if x < -0.8 else -0.1 * (x + 0.2 * y + 0.5)
        return np.array([first, x + 0.65])

    points = [point for point, _ in Lattice(functions, 400).brackets(2)]
    assert points
    assert points[0] == pytest.approx([-0.65, 0.75], abs=1e-2)
