"""Stresses by bilinear tractions in closed form, and lower bounds proved between samples."""

import numpy as np
import pytest

import varcontact as vc
from tests.plasticity.fields import ellipse
from varcontact.plasticity.balls import families
from varcontact.plasticity.derivatives import (
    Remainders,
    _Steps,
    derivative_bound,
    kernel_bounds,
)
from varcontact.plasticity.half_space import (
    HalfSpace,
    depth_matrix,
    point_derivatives,
    stress_matrix,
)
from varcontact.plasticity.passage import bilinear_layer, loaded_part, passage
from varcontact.plasticity.point_proof import TOLERANCE, PointProof
from varcontact.plasticity.residual_stress import CellResidual, ResidualSpace, cells

NU = 0.3


def ones(depth):
    return np.ones_like(depth)


@pytest.fixture(scope="module")
def field():
    """Hertz's ellipse with all three tractions."""
    return HalfSpace(*loaded_part(ellipse(b=1.3, f=0.4, n=10, spin=2.0, vx=0.2), 2), NU)


def point_stress(matrix, x, y, z):
    values = point_derivatives(x, y, z)
    values[7:] *= z
    return np.einsum("tcd,dn->tcn", matrix, values)


def hat(values, grid):
    load = np.zeros((3, 3, 3))
    load[:, 1, 1] = values
    return HalfSpace(load, grid, NU)


def test_a_hat_of_traction_is_a_sum_of_point_loads():
    grid = vc.Grid(nx=3, ny=3, dx=0.7, dy=0.5, x0=-1.05, y0=-0.75)
    place = np.array([[0.3], [-0.2], [0.45]])
    nodes, weights = np.polynomial.legendre.leggauss(30)
    total = 0.0
    for left, right in ((-0.7, 0.0), (0.0, 0.7)):
        for low, high in ((-0.5, 0.0), (0.0, 0.5)):
            x, y = np.meshgrid(
                (left + right) / 2 + (right - left) / 2 * nodes,
                (low + high) / 2 + (high - low) / 2 * nodes,
            )
            weight = np.outer(weights, weights) * (right - left) * (high - low) / 4
            weight = (weight * (1 - np.abs(x) / 0.7) * (1 - np.abs(y) / 0.5)).ravel()
            at = place - np.array([x.ravel(), y.ravel(), 0 * x.ravel()])
            total = total + point_stress(stress_matrix(NU), *at) @ weight
    for traction in range(3):
        found = hat(np.eye(3)[traction], grid).stress(place)[0]
        assert found == pytest.approx(total[traction], abs=1e-13)


def test_surface_stress_of_a_hat():
    """The shear stress is minus the traction; under a pressure sxx - szz is (1 - 2 nu) of a part."""
    grid = vc.Grid(nx=3, ny=3, dx=1.0, dy=1.0, x0=-1.5, y0=-1.5)
    at = np.array([[0.0, 0.25], [0.0, 0.0], [0.0, 0.0]])
    sheared = hat([0.3, 0.2, 0.0], grid).stress(at)
    assert sheared[:, 3] == pytest.approx([-0.3, -0.225], abs=1e-14)
    assert sheared[:, 4] == pytest.approx([-0.2, -0.15], abs=1e-14)
    pressed = hat([0.0, 0.0, 1.0], grid).stress(at)
    # at the middle sxx = syy = (1 + 2 nu)/2 szz
    assert pressed[0, 0] == pytest.approx(0.5 * (1 - (1 + 2 * NU) / 2), abs=1e-14)


def test_layers_are_the_stress_at_their_points(field):
    x, y = np.meshgrid(field.grid.x, field.grid.y)
    for depth in (0.0, 0.02, 0.7):
        layer = bilinear_layer(field, depth, (2, 3))[:, 2:-2, 3:-3]
        points = np.array([x.ravel(), y.ravel(), np.full(x.size, depth)])
        assert field.stress(points).T == pytest.approx(layer.reshape(5, -1), abs=1e-12)


def test_second_derivatives_along_z_by_those_along_x_and_y():
    x, y, z = np.array([[0.3, -0.4], [0.5, 0.1], [0.6, 0.9]])
    h = 1e-3
    own = stress_matrix(NU)
    down = depth_matrix(NU)

    def second(matrix, dx, dy, dz):
        return (
            point_stress(matrix, x + dx, y + dy, z + dz)
            - 2 * point_stress(matrix, x, y, z)
            + point_stress(matrix, x - dx, y - dy, z - dz)
        ) / h**2

    left = second(own, 0, 0, h)
    right = -second(down, h, 0, 0) - second(down, 0, h, 0)
    assert left == pytest.approx(right, abs=2e-4 * np.abs(left).max())


def test_bounds_of_derivatives():
    """Of the third and fourth order, at the distance 1."""
    rng = np.random.default_rng(3)
    place = rng.normal(size=(3, 20_000))
    place[2] = np.abs(place[2])
    values = np.abs(point_derivatives(*(place / np.linalg.norm(place, axis=0)))).max(axis=1)
    assert values[:7].max() < derivative_bound(3) < 10 * values[:7].max()
    assert values[7:].max() < derivative_bound(4) < 10 * values[7:].max()


@pytest.mark.parametrize("share", [0.3, 0.42, 0.5, 0.66, 0.7])
def test_constants_of_quadratic_interpolation(share):
    """The largest integrals of Peano's kernel, with second derivatives of 1, 1/t and 1/(1 - t)."""
    places = np.array([0.0, share, 1.0])
    t = (np.arange(4000) + 0.5) / 4000
    s = np.linspace(0, 1, 101)[1:-1, None]
    weights = [
        (s - share) * (s - 1) / share,
        s * (s - 1) / (share * (share - 1)),
        s * (s - share) / (1 - share),
    ]
    parts = (each * np.maximum(place - t, 0) for each, place in zip(weights, places, strict=True))
    kernel = np.abs(np.maximum(s - t, 0) - sum(parts))
    box = tuple(np.full((1, 1), place) for place in places)
    bounds = _Steps.along(box, 0)
    largest = [(kernel * weight).mean(axis=1).max() for weight in (1, 1 / t, 1 / (1 - t))]
    assert 0.98 * bounds.second < largest[0] < bounds.second
    assert 0.9 * bounds.touching < max(largest[1:]) < bounds.touching


@pytest.mark.long
@pytest.mark.parametrize("nu", [0.0, 0.28, 0.5])
def test_bounds_of_kernels(nu):
    rng = np.random.default_rng(2)
    place = rng.normal(size=(3, 20_000))
    place[2] = np.abs(place[2])
    place /= np.linalg.norm(place, axis=0)
    bounds = kernel_bounds(nu)
    # no more than 3 % above the largest value
    largest = np.abs(point_stress(stress_matrix(nu), *place)).max(axis=2)
    assert (bounds.stress < 1.03 * largest + 0.02 * largest.max()).all()
    assert (np.abs(point_stress(stress_matrix(nu), *place)).max(axis=2) <= bounds.stress).all()
    assert (np.abs(point_stress(depth_matrix(nu), *place)).max(axis=2) <= bounds.down).all()


@pytest.mark.parametrize(("depth", "thickness"), [(0.0, 0.02), (0.02, 0.02), (0.3, 0.1)])
@pytest.mark.parametrize("parts", [1, 4])
def test_interpolation_misses_less_than_its_bounds(field, depth, thickness, parts):
    rng = np.random.default_rng(3)
    dx, dy = field.grid.sides
    n = 12
    low = np.column_stack(
        [
            field.grid.x[rng.integers(1, 9, n)] + dx / parts * rng.integers(0, parts, n),
            field.grid.y[rng.integers(1, 9, n)] + dy / parts * rng.integers(0, parts, n),
            np.full(n, depth),
        ]
    )
    high = low + np.array([dx / parts, dy / parts, thickness])
    middle = (low + high) / 2
    middle[:, 2] = low[:, 2] + 0.4 * thickness
    bounds = Remainders(field).quadratic(low, middle, high)
    shares = np.array([0.0, 0.2, 0.4, 0.5, 0.8, 1.0])
    at = np.stack(np.meshgrid(shares, shares, shares, indexing="ij"), axis=-1).reshape(-1, 3)
    points = low[:, None] + at * (high - low)[:, None]
    stress = field.stress(points.reshape(-1, 3).T).reshape(n, 6, 6, 6, 5)
    for axis, third in ((0, 0.5), (1, 0.5), (2, 0.4)):
        values = np.moveaxis(stress, 1 + axis, 0)
        middles = values[3 if third == 0.5 else 2]
        interpolated = np.array(
            [
                (s - third) * (s - 1) / third * values[0]
                + s * (s - 1) / (third * (third - 1)) * middles
                + s * (s - third) / (1 - third) * values[-1]
                for s in shares
            ]
        )
        apart = np.abs(values - interpolated).max(axis=(0, 2, 3))
        assert (apart <= bounds[:, axis] + 1e-12).all()


def test_cells_overlap_where_intervals_differ():
    places = np.array([-4.0, -2.0, 0.0, 1.0, 2.0, 3.0, 5.0, 7.0])
    found = cells(places)
    assert found.tolist() == [0, 2, 3, 5]
    steps = np.diff(places)
    assert steps[found].tolist() == steps[found + 1].tolist()


@pytest.mark.long
def test_no_stress_is_above_the_proved_radius():
    way = passage(ellipse(f=0.3, n=6), 2, ones).half()
    closed = families(way)
    residual = CellResidual(way.y, way.depth, closed.axial_stress)
    proof = PointProof.of(way, residual, ones, closed.axial)
    radius = proof.radius(1.3)
    samples = proof._largest_sample()
    assert samples <= radius <= max(1.3, (1 + TOLERANCE) * samples) + 1e-12
    rng = np.random.default_rng(4)
    cell = np.zeros((400, 2), dtype=int)
    x = rng.uniform(-1.2, 1.2, 400)
    y = rng.uniform(way.y[0], way.y[2], 400)
    z = rng.uniform(0, way.depth[2], 400)
    at = residual_at(proof.residual, y, z, cell)
    size = np.linalg.norm(proof.field.stress(np.array([x, y, z])) + at, axis=1)
    assert size.max() <= radius


def residual_at(residual, y, z, cell):
    places = (np.repeat(each[:, None], 3, axis=1) for each in (y, z))
    return residual.at(*places, cell)[:, 0, 0]


def test_residual_stress_between_samples_is_that_of_the_splines():
    """Cubic functions at most in a cell, whose third derivatives are bounded."""
    way = passage(ellipse(f=0.3, n=8), 2, ones).half()
    space = ResidualSpace.around(way, 6, 3, 6)
    rows = space.rows(way.y[3:4], way.depth[3:4])
    rng = np.random.default_rng(5)
    coefficients = rng.normal(size=rows.shape[2])
    axial = np.zeros((len(way.depth), len(way.y)))
    residual = space.by_cell(coefficients, axial, way)
    starts = residual.starts
    assert set(space.depth.round(9)) <= set(
        way.depth[np.union1d(starts[1], starts[1] + 2)].round(9)
    )
    y = rng.uniform(0.1, 1.0, 5)
    z = rng.uniform(0.1, 1.0, 5)
    own = residual_at(residual, y, z, np.zeros((5, 2), dtype=int))
    expected = np.einsum("pqc,c->pq", space.rows(y, z), coefficients)
    assert own[:, [0, 2, 3, 4]] == pytest.approx(expected, abs=1e-10)


def test_bounds_before_and_behind_the_passage_hold():
    way = passage(ellipse(f=0.3, n=6), 2, ones).half()
    closed = families(way)
    residual = CellResidual(way.y, way.depth, closed.axial_stress)
    proof = PointProof.of(way, residual, ones, closed.axial)
    # an aim so low that the size of the stress is not enough next to the passage
    aim = 0.7 * proof._ahead(1.0)[1]
    boxes, found, added = proof._ahead(aim)
    assert boxes.low.size > 0
    bound = max(found, float(np.max(proof._bounded(boxes, aim).bound)) + added)
    # places to 300 times the half-length of the passage
    rng = np.random.default_rng(6)
    starts_y, starts_z = residual.starts
    cell = np.stack([rng.choice(starts_y, 4000), rng.choice(starts_z, 4000)], axis=1)
    y = rng.uniform(way.y[cell[:, 0]], way.y[cell[:, 0] + 2])
    z = rng.uniform(way.depth[cell[:, 1]], way.depth[cell[:, 1] + 2])
    middle = (way.x[0] + way.x[-1]) / 2
    reach = (way.x[-1] - way.x[0]) / 2
    x = middle + rng.choice([-1, 1], 4000) * reach * 10 ** rng.uniform(0, 2.5, 4000)
    stress = proof.field.stress(np.array([x, y, z])) + residual_at(residual, y, z, cell)
    assert np.linalg.norm(stress, axis=1).max() <= bound
