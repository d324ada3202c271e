"""Conjugate gradients with the symmetric part: right where it is positive definite, silent where it is not."""

import numpy as np
import pytest

import varcontact as vc
from varcontact.elasticity.operators import influence_operator
from varcontact.solvers.matrix_free.symmetric import solve_symmetric


def operator(dx, part, cells=12):
    grid = vc.Grid(nx=cells, ny=cells, dx=dx, dy=1.0, x0=0.0, y0=0.0)
    return influence_operator(grid, "xy", "xy", nu=0.28, lag=part * dx).on(np.arange(cells * cells))


def test_against_the_dense_matrix():
    M = operator(1.0, 1.0)
    right = np.random.default_rng(1).normal(size=(2, 2, M.elements.size))
    symmetric = (M.matrix + M.matrix.T) / 2
    expected = np.linalg.solve(symmetric, right.reshape(2, -1).T).T.reshape(right.shape)
    np.testing.assert_allclose(solve_symmetric(M, right, tol=1e-11), expected, rtol=1e-7, atol=1e-7)


@pytest.mark.parametrize(("dx", "part"), [(3.0, 0.1), (5.0, 0.2), (10.0, 0.4)])
def test_not_positive_definite(dx, part):
    """A negative curvature on the way: no solution is made up, and no thousand iterations are spent."""
    M = operator(dx, part)
    assert np.linalg.eigvalsh(M.matrix + M.matrix.T)[0] < 0
    right = np.random.default_rng(1).normal(size=(3, 2, M.elements.size))
    assert solve_symmetric(M, right) is None
