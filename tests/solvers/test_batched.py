"""Parts of the solver of many problems at once; its answers are those of single ones, see
tests/study/test_many.py.
"""

import numpy as np
import pytest

from varcontact.elasticity.operators import influence_operator
from varcontact.scene.grid import Grid
from varcontact.solvers.batched.newton import shift_before
from varcontact.solvers.batched.pool import inverse_of
from varcontact.solvers.batched.problem import BatchedProblem

GRID = Grid(nx=7, ny=5, dx=0.3, dy=0.5, x0=0.0, y0=0.0)


@pytest.mark.parametrize("ahead", [0, 1, 2])
def test_displacements_by_transforms_are_those_of_influence_numbers(ahead):
    """Of particles so many elements ahead."""
    problem = BatchedProblem(
        dx=np.array([GRID.dx]),
        dy=np.array([GRID.dy]),
        nu=np.array([0.3]),
        rigid_shift=np.zeros((2, *GRID.shape, 1)),
        bound=np.ones((*GRID.shape, 1)),
        force=np.full((2, 1), np.nan),
    )
    traction = np.random.default_rng(1).normal(size=(2, *GRID.shape, 1))
    operator = influence_operator(GRID, "xy", "xy", nu=0.3, offset=ahead * GRID.dx)
    found = shift_before(problem, traction, ahead)
    np.testing.assert_allclose(found[..., 0], operator.apply(traction[..., 0]), atol=1e-13)


def test_the_inverse_of_a_symbol():
    """Of the matrices xx, -i xy; -i xy, yy with a shift of the diagonal."""
    symbol = np.random.default_rng(1).uniform(1.0, 2.0, (3, 4, 6))
    real, imaginary = inverse_of(symbol, np.full((4, 6), 0.5))
    np.testing.assert_array_equal(imaginary[:, :, 0], -imaginary[:, :, 1])
    xx, xy, yy = symbol + np.array([0.5, 0.0, 0.5])[:, None, None]
    matrix = np.array([[xx, -1j * xy], [-1j * xy, yy]])
    off = real[2, :, 0] + 1j * imaginary[2, :, 1]
    inverse = np.array([[real[0, :, 0], off], [off, real[1, :, 0]]])
    product = np.einsum("ijsx,jksx->iksx", matrix, inverse)
    expected = np.eye(2)[:, :, None, None] * np.ones((4, 6))
    np.testing.assert_allclose(product, expected, atol=1e-6)
