"""Upper bounds by velocities: means of stress, what they miss, and compatible strains."""

from dataclasses import replace

import numpy as np
import pytest

import varcontact as vc
from tests.plasticity.fields import ellipse
from varcontact.plasticity.flow_mesh import flow_mesh, mean_weights
from varcontact.plasticity.koiter import _isochoric, _strain, upper_bound
from varcontact.plasticity.melan import lower_bound
from varcontact.plasticity.passage import passage
from varcontact.plasticity.residual_stress import ResidualSpace
from varcontact.plasticity.work import Means


def quiet(stage):
    pass


def ones(depth):
    return np.ones_like(depth)


@pytest.fixture(scope="module")
def way():
    return passage(ellipse(f=0.2, n=8), 2, ones, refined=2).half()


@pytest.fixture(scope="module")
def mesh(way):
    return flow_mesh(way, 4, 2, 5)


def gauss(corners, values, parts):
    """Means over a triangle with the weights 3 N, by its middles in parts^2 smaller ones."""
    at = [
        ((i + shift) / parts, (j + shift) / parts)
        for i in range(parts)
        for j in range(parts)
        for shift in (1 / 3, 2 / 3)
        if i + j + 2 * shift < parts
    ]
    first, second = np.array(at).T
    shape = np.array([1 - first - second, first, second])
    return 3 * shape @ values(*(corners.T @ shape)) / len(at)


@pytest.mark.parametrize("cells", [1, 2, 3])
@pytest.mark.parametrize("layers", [(0.0, 1.0), (0.0, 0.1, 0.4, 1.0)])
def test_means_of_quadratic_fields_are_exact(cells, layers):
    by_sample, shares = mean_weights(cells, layers)
    ends = np.array(layers)
    z = np.sort(np.concatenate([ends, (ends[1:] + ends[:-1]) / 2]))
    y = np.linspace(0, 1, 2 * cells + 1)
    field = (1 - 3 * z[:, None] ** 2) * (1 + y + 2 * y**2)
    found = np.einsum("svzy,zy->sv", by_sample, field)
    ring = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
    for side in range(4):
        corners = np.array([ring[side], ring[(side + 1) % 4], [0.5, 0.5]])
        own = gauss(corners, lambda y, z: (1 - 3 * z**2) * (1 + y + 2 * y**2), 200)
        assert found[side] == pytest.approx(own, abs=2e-4)
    assert shares.sum(axis=(2, 3)) == pytest.approx(1.0)


@pytest.mark.long
def test_work_misses_less_than_its_bound(way, mesh):
    """Against the field in closed form at many places of each triangle."""
    means = Means.of(way, mesh, ones)
    rng = np.random.default_rng(1)
    rows = len(mesh.depth) - 1
    columns = len(mesh.y) - 1
    # at the surface and below it, in the contact and beside it
    for column, row in ((0, 0), (3, 0), (columns - 2, 0), (2, 1), (3, 2)):
        side = int(rng.integers(4))
        triangle = (side * columns + column) * rows + row
        along = int(rng.integers(len(way.x)))
        corners = mesh.places[mesh.corners[triangle]]
        x = way.x[along]

        def stress(y, z, x=x):
            return way.field.stress(np.array([x + 0 * y, y, z]))

        exact = gauss(corners, stress, 24)
        found = means.curves[3 * triangle : 3 * triangle + 3, along]
        for vertex in range(3):
            for component in range(5):
                strain = np.eye(5)[component][None]
                number = np.array([3 * triangle + vertex])
                bound = means.missed(number, np.array([along]), strain)
                apart = abs(exact[vertex, component] - found[vertex, component])
                assert apart <= bound + 2e-4
                assert bound < 0.1


@pytest.mark.long
def test_yield_stress_of_a_triangle_is_no_less_than_its_mean(way, mesh):
    def strength(depth):
        return 1 + np.minimum(depth, 1.0)

    means = Means.of(way, mesh, strength)
    for triangle in range(0, len(mesh.area), 7):
        corners = mesh.places[mesh.corners[triangle]]
        mean = gauss(corners, lambda y, z: strength(z), 12)
        found = means.radius[3 * triangle : 3 * triangle + 3]
        assert (found >= mean - 1e-6).all()
        assert (found <= strength(corners[:, 1].max()) + 1e-12).all()


def test_velocities_change_no_volume(mesh):
    rng = np.random.default_rng(2)
    velocity = np.where(mesh.held, 0.0, rng.normal(size=mesh.held.shape))
    found = _isochoric(mesh, velocity)
    strain, volume = _strain(mesh, found)
    assert np.abs(volume).sum() < 1e-12 * np.abs(strain).sum()
    assert (found[mesh.held] == 0).all()
    assert found[0] == pytest.approx(velocity[0], abs=0)


@pytest.mark.long
def test_programs_bound_each_other(way):
    """Finer velocities are better, and no residual stress does more."""
    coarse, fine = (
        upper_bound(way, flow_mesh(way, *sizes), ones, quiet) for sizes in ((3, 2, 4), (6, 3, 6))
    )
    assert fine.factor < coarse.factor
    assert fine.ratchet > 0.9
    bound = lower_bound(way, ResidualSpace.around(way, 6, 3, 7), 0.95 * fine.factor, quiet)
    assert 0.9 * fine.factor < bound.factor <= bound.sampled <= fine.factor


@pytest.mark.parametrize(("n", "refined"), [(8, 1), (9, 1), (8, 2)])
def test_meshes_have_no_kink_inside_a_cell_at_the_surface(n, refined):
    """Whatever the number of elements: what is missed there has no bound."""
    own = passage(ellipse(f=0.3, n=n), 2, ones, refined=refined).half()
    closed = flow_mesh(own, 3, 2, 4)
    surface = [block for block in closed.blocks if block.row == 0]
    cells = np.concatenate([closed.samples(block)[0][:, ::2].ravel() for block in surface])
    kinks = own.field.grid.y[own.field.grid.y > 0]
    assert np.abs(kinks[:, None] - cells).min(axis=1) == pytest.approx(0.0, abs=1e-9)


def test_velocities_are_drawn(way):
    limit = vc.shakedown(ellipse(f=0.2, n=8), 1.0, gap=None)
    flow = upper_bound(way, flow_mesh(way, 3, 2, 4), ones, quiet)
    figure = replace(limit, mechanism=flow).plot()
    section = figure.axes[2]
    names = [text.get_text() for text in section.get_legend().get_texts()]
    assert names == ["velocity across x"]
    # both halves of the section, from the surface to where the flow ends
    left, right = section.get_xlim()
    assert left == pytest.approx(-right)
    assert 0.1 < section.get_ylim()[0] < 1.5
    assert section.get_ylim()[1] == 0
