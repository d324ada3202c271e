"""Operators on a curved reference surface against R(t/2) A R(t/2), written out element by
element.
"""

import numpy as np
import pytest

from varcontact.discrete.problems import TangentialProblem, mirror_of
from varcontact.elasticity.conformal import ConformalOperator, conformal_operator
from varcontact.elasticity.operators import GridOperator, influence_operator
from varcontact.interfaces.potential import Potential
from varcontact.scene.grid import Grid

GRID = Grid(nx=11, ny=17, dx=0.3, dy=0.2, x0=0.0, y0=0.0)
EVERY = np.arange(GRID.nx * GRID.rows)
CONSTANT = 0.3 * GRID.y
VARYING = 0.3 * np.sin(GRID.y) + 0.1 * GRID.y**2


def turn(angle):
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[1, 0, 0], [0, c, -s], [0, s, c]])


def written_out(angles, K, lag):
    """The matrix (3, n, 3, n), by rotations of each pair of elements."""
    flat = influence_operator(GRID, "xyz", "xyz", nu=0.28, K=K, lag=lag).dense(EVERY)
    matrix = flat.reshape(3, EVERY.size, 3, EVERY.size).copy()
    for i, j in np.ndindex(GRID.rows, GRID.rows):
        half = turn((angles[j] - angles[i]) / 2)
        rows, columns = slice(i * GRID.nx, (i + 1) * GRID.nx), slice(j * GRID.nx, (j + 1) * GRID.nx)
        matrix[:, rows, :, columns] = np.einsum(
            "ab,bicj,cd->aidj", half, matrix[:, rows, :, columns], half
        )
    return matrix


def operator(rows, columns, angles, K, lag):
    return conformal_operator(
        rows, columns, angles, lambda *to: influence_operator(GRID, *to, nu=0.28, K=K, lag=lag)
    )


@pytest.mark.parametrize("lag", [None, 0.3], ids=["shift", "rolling"])
@pytest.mark.parametrize("K", [0.0, 0.1])
@pytest.mark.parametrize(
    ("angles", "kind"), [(CONSTANT, GridOperator), (VARYING, ConformalOperator)]
)
def test_matrices_and_products_are_those_written_out(angles, kind, K, lag):
    expected, field = (
        written_out(angles, K, lag),
        np.random.default_rng(1).normal(size=(3, *GRID.shape)),
    )
    some, loaded = np.array([3, 40, 181]), np.array([0, 60, 100, 186])
    for rows, columns in (("z", "z"), ("xy", "xy"), ("xy", "z"), ("z", "xy"), ("xyz", "xyz")):
        i, j = (["xyz".index(name) for name in names] for names in (rows, columns))
        own, block = operator(rows, columns, angles, K, lag), expected[i][:, :, j]
        assert type(own) is kind
        np.testing.assert_allclose(
            own.dense(EVERY), block.reshape(len(i) * EVERY.size, -1), atol=1e-15
        )
        part = block[:, some][..., loaded].reshape(len(i) * some.size, -1)
        np.testing.assert_allclose(own.dense(some, loaded), part, atol=1e-15)
        product = np.einsum("aibj,bj->ai", block, field[j].reshape(len(j), -1))
        np.testing.assert_allclose(own.apply(field[j]).reshape(len(i), -1), product, atol=1e-13)
        whole = operator("xyz", "xyz", angles, K, lag).between(tuple(i), tuple(j))
        np.testing.assert_allclose(whole.apply(field[j]), own.apply(field[j]), atol=1e-13)


@pytest.mark.parametrize("K", [0.0, 0.1])
@pytest.mark.parametrize("angles", [CONSTANT, VARYING])
def test_the_matrix_of_a_shift_is_symmetric_and_that_of_rolling_is_positive(angles, K):
    matrix = operator("xyz", "xyz", angles, K, None).dense(EVERY)
    np.testing.assert_allclose(matrix, matrix.T, atol=1e-16)
    assert np.linalg.eigvalsh(matrix).min() > 0
    rolling = operator("xy", "xy", angles, K, 0.3)
    dense = rolling.dense(EVERY)
    assert np.linalg.eigvalsh(dense + dense.T).min() > 0
    np.testing.assert_allclose(
        rolling.symmetric_part().dense(EVERY), (dense + dense.T) / 2, atol=1e-16
    )
    np.testing.assert_allclose(
        rolling.symmetric_part(-1.0).dense(EVERY), (dense - dense.T) / 2, atol=1e-16
    )


def test_only_rows_whose_inclination_is_odd_have_a_mirror():
    own = operator("xy", "xy", np.sin(GRID.y - GRID.y[8]), 0.0, None)
    for last, mirrored in ((12, True), (13, False)):
        elements = np.arange(4 * GRID.nx, (last + 1) * GRID.nx)
        elements = elements[elements // GRID.nx != (4 + last) / 2]  # none on the line
        shift, bound = np.ones((2, elements.size)) * [[1.0], [0.0]], np.ones(elements.size)
        problem = TangentialProblem(
            own.on(elements), shift, Potential(bound), np.zeros((2, elements.size)), 1.0
        )
        assert (mirror_of(problem) is not None) is mirrored
