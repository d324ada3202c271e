"""Operators on a curved reference surface against R(t/2) A R(t/2), written out element by
element.
"""

import numpy as np
import pytest

from varcontact.discrete.problems import TangentialProblem, mirror_of
from varcontact.elasticity.by_element import ELEMENTS_MAX, turned_operator
from varcontact.elasticity.conformal import (
    Conformal,
    ConformalOperator,
    Inclination,
    conformal_operator,
)
from varcontact.elasticity.halfspace import HalfSpaces
from varcontact.elasticity.operators import GridOperator, influence_operator
from varcontact.errors import SceneError
from varcontact.interfaces.potential import Potential
from varcontact.scene.frames import frames_of_elements
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


# ----------------------------------------------------------------------------- along x


SIDEWAYS = Grid(nx=17, ny=11, dx=0.2, dy=0.3, x0=0.0, y0=0.0)
EXCHANGED = {"x": "y", "y": "x", "z": "z"}


def sideways(fields):
    """Fields (components, ny, nx) with x and y exchanged, of components as in `EXCHANGED`."""
    return fields.swapaxes(-2, -1)


@pytest.mark.parametrize("K", [0.0, 0.1])
@pytest.mark.parametrize(
    ("angles", "kind"), [(CONSTANT, GridOperator), (VARYING, ConformalOperator)]
)
def test_curved_along_x_is_curved_along_y_with_axes_exchanged(angles, kind, K):
    def flat(grid):
        return lambda *to: influence_operator(grid, *to, nu=0.28, K=K)

    field = np.random.default_rng(1).normal(size=(3, *SIDEWAYS.shape))
    for rows, columns in (
        ("z", "z"),
        ("xy", "xy"),
        ("xy", "z"),
        ("z", "xy"),
        ("xyz", "xyz"),
        ("y", "y"),
    ):
        own = conformal_operator(rows, columns, angles, flat(SIDEWAYS), "x")
        names = ["".join(EXCHANGED[name] for name in each) for each in (rows, columns)]
        other = conformal_operator(*names, angles, flat(GRID))
        assert type(own) is kind
        given = field[: len(columns)]
        product = own.apply(given)
        np.testing.assert_allclose(sideways(product), other.apply(sideways(given)), atol=1e-13)
        every = np.arange(SIDEWAYS.size)
        dense = own.dense(every) @ given.ravel()
        np.testing.assert_allclose(dense, product.ravel(), atol=1e-13)
        by_transposed = own.transposed.dense(every)
        np.testing.assert_allclose(by_transposed, own.dense(every).T, atol=1e-16)


@pytest.mark.parametrize("K", [0.0, 0.1])
def test_curved_along_both_axes_every_pair_of_elements_is_turned(K):
    from scipy.spatial.transform import Rotation

    grid = Grid(nx=5, ny=4, dx=0.3, dy=0.2, x0=0.0, y0=0.0)
    every = np.arange(grid.size)
    frames = frames_of_elements(0.4 * np.sin(grid.y), 0.9 * grid.x)
    flat = influence_operator(grid, "xyz", "xyz", nu=0.28, K=K)
    numbers = flat.dense(every).reshape(3, grid.size, 3, grid.size)
    axes = Rotation.from_matrix(frames.reshape(3, 3, -1).transpose(2, 0, 1))
    expected = np.empty_like(numbers)
    for i, j in np.ndindex(grid.size, grid.size):
        half = Rotation.from_rotvec((axes[i].inv() * axes[j]).as_rotvec() / 2).as_matrix()
        expected[:, i, :, j] = half @ numbers[:, i, :, j] @ half
    own = turned_operator("xyz", "xyz", frames, flat)
    matrix = own.dense(every)
    np.testing.assert_allclose(matrix, expected.reshape(matrix.shape), atol=1e-15)
    np.testing.assert_allclose(matrix, matrix.T, atol=1e-16)
    assert np.linalg.eigvalsh(matrix).min() > 0
    field = np.random.default_rng(1).normal(size=(3, *grid.shape))
    np.testing.assert_allclose(own.apply(field).ravel(), matrix @ field.ravel(), atol=1e-14)
    some, loaded = np.array([3, 7]), np.array([0, 5, 19])
    part = turned_operator("xy", "z", frames, flat)
    np.testing.assert_allclose(
        part.dense(some, loaded), expected[:2][:, some][:, :, 2, loaded].reshape(4, 3), atol=1e-15
    )
    np.testing.assert_array_equal(own.between((0, 1), (2,)).numbers, part.numbers)
    blocks = [[own.between(i, j) for j in ((2,), (0, 1))] for i in ((2,), (0, 1))]
    np.testing.assert_array_equal(
        type(own).in_blocks(blocks).numbers, own.numbers[[2, 0, 1]][:, :, [2, 0, 1]]
    )
    np.testing.assert_array_equal(own.transposed.numbers.reshape(matrix.shape), matrix.T)


def test_a_straight_axis_does_not_turn():
    """By element where the other axis is straight: the operators of one axis."""
    grid = Grid(nx=5, ny=4, dx=0.3, dy=0.2, x0=0.0, y0=0.0)
    every = np.arange(grid.size)
    level = {
        name: Inclination(tuple(at.tolist()), (0.0,) * at.size)
        for name, at in (("by_row", grid.y), ("by_column", grid.x))
    }
    curved = {
        name: Inclination(tuple(at.tolist()), tuple((0.3 * at**2).tolist()))
        for name, at in (("by_row", grid.y), ("by_column", grid.x))
    }
    for name, other in (("by_row", "by_column"), ("by_column", "by_row")):
        for lag in (((0.0, 1.0),), ((0.0, 1.0), (0.3, -1.0))):
            one = Conformal(HalfSpaces(0.28, 0.1), **{name: curved[name]})
            both = Conformal(HalfSpaces(0.28, 0.1), **{name: curved[name], other: level[other]})
            matrices = [each.operator(grid, "xyz", "xyz", lag).dense(every) for each in (one, both)]
            np.testing.assert_allclose(*matrices, atol=1e-15)


def test_a_matrix_by_element_has_a_largest_size():
    grid = Grid(nx=ELEMENTS_MAX, ny=2, dx=0.3, dy=0.2, x0=0.0, y0=0.0)
    flat = GridOperator(grid.shape, np.zeros((3, 3, 1, 1)))
    with pytest.raises(SceneError, match="elements"):
        turned_operator("z", "z", np.zeros((3, 3, *grid.shape)), flat)


@pytest.mark.parametrize("axis", ["x", "y"])
def test_under_a_constant_curvature_numbers_depend_on_the_offset_alone(axis):
    """A table is all of the operator; where the curvature varies it is not."""
    places = {"x": GRID.x, "y": GRID.y}[axis]

    def flat(rows, columns):
        return influence_operator(GRID, rows, columns, nu=0.28)

    constant = conformal_operator("xyz", "xyz", 0.3 * places, flat, axis)
    varying = conformal_operator("xyz", "xyz", 0.1 * places**2, flat, axis)
    assert constant.toeplitz
    assert type(constant) is GridOperator
    assert isinstance(varying, ConformalOperator)
