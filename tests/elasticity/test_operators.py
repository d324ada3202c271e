"""Products by FFT and by the matrix, dense blocks, and what the operators must be: symmetric,
definite.
"""

import gc
import weakref

import numpy as np
import pytest

import varcontact as vc
from varcontact.elasticity.by_element import ElementOperator
from varcontact.elasticity.fft_products import (
    fft_box,
    fields_of,
    spectrum_of,
    table_bytes,
    wrapped,
)
from varcontact.elasticity.halfspace import HalfSpaces, influence_numbers
from varcontact.elasticity.operators import GridOperator, influence_operator

GRID = vc.Grid(nx=9, ny=7, dx=0.3, dy=0.5, x0=0.0, y0=0.0)
LARGER = vc.Grid(nx=19, ny=13, dx=0.3, dy=0.5, x0=0.0, y0=0.0)
STRIPS = [vc.Grid(nx=nx, dx=0.1, x0=3.0) for nx in (37, 187)]


@pytest.mark.parametrize("grid", [GRID, LARGER, *STRIPS])
@pytest.mark.parametrize("lag", [None, 0.3, 0.1])
@pytest.mark.parametrize(
    ("rows", "columns"), [("z", "z"), ("xy", "xy"), ("xy", "z"), ("z", "xy"), ("xyz", "xyz")]
)
def test_product_is_the_dense_product(rows, columns, lag, grid):
    """By the matrix on the small grids, on the larger ones by FFT."""
    operator = influence_operator(grid, rows, columns, nu=0.3, K=0.2, depth=7.0, lag=lag)
    assert (operator.whole is None) == (grid.size > 160)
    tractions = np.random.default_rng(1).normal(size=(len(columns), *grid.shape))
    dense = operator.dense(np.arange(grid.size)) @ tractions.ravel()
    np.testing.assert_allclose(
        operator.apply(tractions).ravel(), dense, atol=1e-14 * np.abs(dense).max()
    )


@pytest.mark.parametrize(
    ("shape", "box"), [((8, 8), (15, 15)), ((7, 9), (14, 20)), ((1, 90), (1, 180))]
)
@pytest.mark.parametrize("kind", [np.float32, np.float64])
def test_transforms_of_small_boxes_are_those_of_an_fft(shape, box, kind):
    fields = np.random.default_rng(2).normal(size=(2, 3, *shape)).astype(kind)
    spectrum = spectrum_of(fields, box)
    by_fft = np.fft.rfft2(fields.astype(float), box)
    rounding = 10 * np.finfo(kind).eps
    assert np.abs(spectrum - by_fft).max() <= rounding * np.abs(by_fft).max()
    back = fields_of(spectrum, box, shape)
    assert back.dtype == kind
    assert np.abs(back - fields).max() <= rounding * np.abs(fields).max()


def test_dense_block_entry_by_entry():
    """Rows by field element, columns by loaded element, the lag in x."""
    operator = influence_operator(GRID, "xy", "xy", nu=0.3, lag=0.2)
    elements = np.array([3, 40, 12])
    x, y = (c.ravel()[elements] for c in np.meshgrid(GRID.x, GRID.y))
    block = operator.dense(elements)
    for i in range(3):
        for j in range(3):
            here = influence_numbers(x[i] - x[j], y[i] - y[j], 0.3, 0.5, nu=0.3, components=["xy"])[
                "xy"
            ]
            before = influence_numbers(
                x[i] - x[j] + 0.2, y[i] - y[j], 0.3, 0.5, nu=0.3, components=["xy"]
            )["xy"]
            assert block[i, 3 + j] == pytest.approx(here - before, rel=1e-12, abs=1e-15)


@pytest.mark.parametrize("grid", [GRID, STRIPS[0]])
@pytest.mark.parametrize(
    ("elements", "loaded"),
    [((2, 7), (1, 9)), ((0, 9), (9, 18)), ((4, 5), (0, 9)), ((3, 12), (5, 6))],
)
def test_elements_without_gaps_have_the_matrix_of_others(elements, loaded, grid):
    """As one after the other, and backwards; also from one row to the next."""
    operator = influence_operator(grid, "xyz", "xy", nu=0.3, K=0.2, lag=0.1)
    elements = np.arange(*elements)
    loaded = np.arange(*loaded)
    shape = (3, elements.size, 2, loaded.size)
    matrix = operator.dense(elements, loaded)
    backwards = operator.dense(elements[::-1], loaded[::-1]).reshape(shape)[:, ::-1, :, ::-1]
    np.testing.assert_array_equal(matrix.reshape(shape), backwards)
    assert matrix.flags.writeable


def test_a_stencil_of_one_entry_has_its_weight():
    bodies = HalfSpaces(nu=0.3, K=0.2)
    plain = bodies.operator(GRID, "xyz", "xyz", ((0.2, 1.0),))
    weighted = bodies.operator(GRID, "xyz", "xyz", ((0.2, -0.5),))
    np.testing.assert_array_equal(weighted.table, -0.5 * plain.table)


@pytest.mark.parametrize("offset", [0.0, 0.3, -0.6, 0.2])
@pytest.mark.parametrize("lag", [None, 0.3, 0.9, 0.1, 3000.0])
def test_numbers_of_one_place_are_made_once_and_are_right(lag, offset):
    """Steps of whole elements share theirs between tables, mirror images too: as if each had been
    made by itself.
    """
    operator = influence_operator(GRID, "xyz", "xyz", nu=0.3, K=0.2, lag=lag, offset=offset)
    x, y = (np.arange(1 - n, n) * side for n, side in ((9, 0.3), (7, 0.5)))
    names = [row + column for row in "xyz" for column in "xyz"]
    given = {"nu": 0.3, "K": 0.2, "components": names}
    one_by_one = influence_numbers(x + offset, y[:, None], 0.3, 0.5, **given)
    if lag is not None:
        before = influence_numbers(x + offset + lag, y[:, None], 0.3, 0.5, **given)
        one_by_one = {name: one_by_one[name] - before[name] for name in names}
    for name, numbers in zip(names, operator.table.reshape(9, 13, 17), strict=True):
        np.testing.assert_allclose(numbers, one_by_one[name], rtol=0, atol=1e-15)


@pytest.mark.parametrize("grid", [GRID, LARGER])
def test_restricted_product(grid):
    operator = influence_operator(grid, "xy", "xy", nu=0.3, lag=0.3)
    elements = np.array([1, 5, 20, 21, 62])
    restricted = operator.on(elements)
    tractions = np.random.default_rng(2).normal(size=(2, 5))
    expected = (restricted.matrix @ tractions.ravel()).reshape(2, 5)
    np.testing.assert_allclose(restricted.apply(tractions), expected, rtol=1e-12, atol=1e-15)


@pytest.mark.parametrize(("nu", "K"), [(0.0, 0.0), (0.5, 0.0), (0.28, 0.2), (-0.9, 0.5)])
def test_influence_is_symmetric_and_positive_definite(nu, K):
    """Betti's theorem, and positive elastic energy, for all nine components together."""
    matrix = influence_operator(GRID, "xyz", "xyz", nu=nu, K=K).dense(np.arange(63))
    np.testing.assert_allclose(matrix, matrix.T, atol=1e-15)
    assert np.linalg.eigvalsh(matrix).min() > 0


@pytest.mark.parametrize("part", [0.1, 0.25, 0.5, 1.0, 2.0])
def test_symmetric_part_of_steady_rolling_is_positive_definite(part):
    """What makes the gap program convex and the solution unique; for steps of any size."""
    grid = vc.Grid(nx=16, ny=14, dx=1.0, dy=1.0, x0=-8.0, y0=-7.0)
    x, y = np.meshgrid(grid.x, grid.y)
    disc = np.flatnonzero((x**2 + (y / 0.9) ** 2 < 49).ravel())
    matrix = influence_operator(grid, "xy", "xy", nu=0.28, lag=part).dense(disc)
    assert np.linalg.eigvalsh(matrix + matrix.T).min() > 1e-3 * part**2 * np.abs(matrix).max()


# ---------------------------------------------------------------------- What operators keep


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_symmetric_part_of_numbers_by_element(sign):
    """(M + s M')/2 of a matrix without any order, entry by entry."""
    numbers = np.random.default_rng(4).standard_normal((2, 6, 2, 6))
    operator = ElementOperator((2, 3), np.zeros((2, 2, 3, 5)), numbers)
    matrix = operator.dense(np.arange(6))
    found = operator.symmetric_part(sign).dense(np.arange(6))
    assert np.allclose(found, (matrix + sign * matrix.T) / 2, rtol=1e-14)


@pytest.mark.parametrize("shape", [(1, 9), (7, 4), (16, 16)])
def test_memory_of_a_table_and_its_transform(shape):
    """As NumPy counts it."""
    grid = vc.Grid(nx=shape[1], ny=shape[0], dx=1.0, dy=1.0, x0=0.0, y0=0.0)
    table = influence_operator(grid, "xyz", "xyz", nu=0.3).table
    box = fft_box(*shape)
    transform = spectrum_of(wrapped(table, box), box)
    assert table_bytes(*shape, 9) == table.nbytes + transform.nbytes


def test_a_matrix_is_assembled_once_for_the_same_elements(monkeypatch):
    """Whoever restricts the operator; with another softening it is another one."""
    operator = influence_operator(GRID, "xy", "xy", nu=0.3)
    assembled, dense = [], GridOperator.dense
    monkeypatch.setattr(
        GridOperator, "dense", lambda *given: assembled.append(given[1].size) or dense(*given)
    )
    elements = np.array([3, 4, 9])
    first = operator.on(elements)
    assert operator.on(elements.copy()).matrix is first.matrix
    soft = operator.on(elements, np.full((2, 3), 0.1))
    np.testing.assert_allclose(soft.matrix, first.matrix + 0.1 * np.eye(6), rtol=1e-15)
    assert assembled == [3, 3]


def test_only_the_last_elements_are_kept(monkeypatch):
    operator = influence_operator(GRID, "z", "z", nu=0.3)
    parts = [operator.on(np.arange(n)) for n in (2, 3, 4)]
    whole = [each.matrix for each in parts]
    assert parts[0].matrix is whole[0], "whoever has an operator has its matrix"
    assert operator.on(np.arange(2)).matrix is not whole[0]
    assert operator.on(np.arange(4)).matrix is whole[2]


@pytest.mark.parametrize("methods", [{}, {"tangential": "tang-safeguarded"}, {"method": "conic"}])
def test_nothing_stays_in_memory_after_a_solve(rolling, methods):
    """Matrices go with the last reference to their operator, without a search for cycles."""
    vc.solve(rolling(grid=vc.Grid(nx=8, ny=8)), **methods)  # imports
    gc.collect()
    gc.disable()
    try:
        kept = []
        made = GridOperator.made_for

        def watched(self, *given):
            kept.append(weakref.ref(self))
            return made(self, *given)

        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(GridOperator, "made_for", watched)
            vc.solve(rolling(grid=vc.Grid(nx=8, ny=8)), **methods)
        assert kept and all(each() is None for each in kept)
    finally:
        gc.enable()
