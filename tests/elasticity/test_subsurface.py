"""The elastic field inside a half-space against point forces, integrals done another way, and
closed forms.
"""

import hypothesis
import numpy as np
import pytest
from hypothesis import strategies as st

import varcontact as vc
from varcontact.elasticity.potentials import lattice_potentials, rectangle_potentials
from varcontact.elasticity.subsurface import field_at, field_below
from varcontact.results.stress import FARTHEST

G, NU = 1.7, 0.31
LOADS = np.eye(3)


def field(points, sides=(1.0, 1.0), load=(0.3, -0.7, 1.0), G=G, nu=NU):
    """By one element centred at the origin."""
    grid = vc.Grid(nx=1, ny=1, dx=sides[0], dy=sides[1], x0=-sides[0] / 2, y0=-sides[1] / 2)
    points = np.reshape(np.asarray(points, dtype=float), (3, -1))
    return field_at(points, grid, np.reshape(load, (3, 1, 1)).astype(float), G=G, nu=nu)


def hooke(gradient, G=G, nu=NU):
    """(32) with the missing nu."""
    strain = (gradient + gradient.swapaxes(0, 1)) / 2
    unit = np.eye(3).reshape(3, 3, *(1,) * (gradient.ndim - 2))
    return 2 * G * (strain + nu / (1 - 2 * nu) * np.trace(strain) * unit)


def point_force(x, y, z, load, G=G, nu=NU):
    """Displacement by Boussinesq (53)-(55) and Cerruti, as Johnson prints them; complex arguments
    allowed.
    """
    r = np.sqrt(x * x + y * y + z * z)
    s, part = r + z, 1 - 2 * nu

    def along(x, y):
        return (
            1 / r + x * x / r**3 + part * (1 / s - x * x / (r * s * s)),
            x * y / r**3 - part * x * y / (r * s * s),
            x * z / r**3 + part * x / (r * s),
        )

    u, v = along(x, y), along(y, x)
    return np.array(
        [
            load[0] * u[0] + load[1] * v[1] + load[2] * (x * z / r**3 - part * x / (r * s)),
            load[0] * u[1] + load[1] * v[0] + load[2] * (y * z / r**3 - part * y / (r * s)),
            load[0] * u[2] + load[1] * v[2] + load[2] * (z * z / r**3 + 2 * (1 - nu) / r),
        ]
    ) / (4 * np.pi * G)


def point_gradient(x, y, z, load):
    """By complex steps: exact to rounding."""
    h = 1e-100
    steps = [(1j * h, 0, 0), (0, 1j * h, 0), (0, 0, 1j * h)]
    return np.stack([point_force(x + a, y + b, z + c, load).imag / h for a, b, c in steps], axis=1)


def panels(middle, width, z, centre):
    """Gauss points and weights over [-width/2, width/2], in panels growing away from `centre`."""
    ends = [-width / 2, width / 2]
    offsets = max(abs(z), 1e-9 * width) * 3.0 ** np.arange(0, 40)
    inside = [
        c
        for c in np.concatenate([[centre], centre - offsets, centre + offsets])
        if -width / 2 < c < width / 2
    ]
    breaks = np.unique([*ends, *inside])
    nodes, weights = np.polynomial.legendre.leggauss(14)
    half, mid = np.diff(breaks)[:, None] / 2, (breaks[1:] + breaks[:-1])[:, None] / 2
    return (middle + mid + half * nodes).ravel(), (half * weights).ravel()


def by_quadrature(point, sides, load):
    """Displacement and gradient by an integral over the element."""
    x, y, z = point
    xs, wx = panels(0.0, sides[0], np.hypot(z, max(abs(y) - sides[1] / 2, 0)), x)
    ys, wy = panels(0.0, sides[1], np.hypot(z, max(abs(x) - sides[0] / 2, 0)), y)
    X, Y, W = x - xs, y - ys[:, None], wx * wy[:, None]
    displacement = np.sum(point_force(X, Y, z, load) * W, axis=(-2, -1))
    return displacement, np.sum(
        point_gradient(X, Y, np.full(W.shape, z + 0j), load) * W, axis=(-2, -1)
    )


@pytest.mark.parametrize("sides", [(1.0, 1.0), (1.0, 1e-3), (1.0, 1e3), (0.4, 1.0)])
@pytest.mark.parametrize("distance", [1e-3, 0.3, 1.0, 30.0, 300.0, 1e3, 1.1e3, 1e4])
def test_against_quadrature(sides, distance):
    """From 10^-3 to 10^4 element sizes, for slim elements too, in three directions: ten digits."""
    load = (0.6, -0.8, 1.0)
    for size in {min(sides), max(sides)}:
        for direction in ((0.48, -0.6, 0.64), (-0.28, 0.96, 0.01), (0.9, 0.1, 0.42)):
            point = distance * size * np.array(direction)
            u, gradient = by_quadrature(point, sides, load)
            found = field(point, sides, load)
            np.testing.assert_allclose(
                found.displacement[:, 0], u, rtol=0, atol=1e-11 * np.abs(u).max()
            )
            np.testing.assert_allclose(
                found.gradient[..., 0], gradient, rtol=0, atol=1e-10 * np.abs(gradient).max()
            )
            stress = hooke(gradient)
            np.testing.assert_allclose(
                found.stress[..., 0], stress, rtol=0, atol=1e-10 * np.abs(stress).max()
            )


@pytest.mark.parametrize("load", LOADS, ids="xyz")
def test_far_away_is_a_point_force(load):
    """Boussinesq and Cerruti, to the square of element size by distance."""
    for distance in (1e3, 1e5, 1e7, 1e30, FARTHEST):
        point = distance * np.array([0.36, -0.48, 0.8])
        found = field(point, load=load)
        u, gradient = point_force(*point, load), point_gradient(*point, load)
        allowed = (1 / distance**2 + 3e-16) * np.abs(u).max()
        np.testing.assert_allclose(found.displacement[:, 0], u, rtol=0, atol=allowed)
        allowed = (4 / distance**2 + 1e-14) * np.abs(gradient).max()
        np.testing.assert_allclose(found.gradient[..., 0], gradient, rtol=0, atol=allowed)


coordinate = st.floats(-3.0, 3.0)


@pytest.mark.long
@hypothesis.given(
    coordinate,
    coordinate,
    st.floats(0.05, 4.0),
    st.tuples(*[st.floats(-1, 1)] * 3),
    st.floats(-0.9, 0.49),
)
def test_equilibrium_and_hooke(x, y, z, load, nu):
    """Stresses are in equilibrium, by differences of the fourth order, and are Hooke's of the
    gradients.
    """
    h = 0.01 * z
    offsets = np.array([-2, -1, 1, 2]) * h
    weights = np.array([1, -8, 8, -1]) / (12 * h)
    divergence = np.zeros(3)
    for j in range(3):
        points = np.tile(np.reshape([x, y, z], (3, 1)), 4)
        points[j] += offsets
        divergence += field(points, load=load, nu=nu).stress[:, j] @ weights
    terms = np.abs(load).max() / (1 + x * x + y * y + z * z) / z
    assert np.abs(divergence).max() <= 1e-6 * terms
    here = field([x, y, z], load=load, nu=nu)
    allowed = 1e-13 * np.abs(here.gradient).max() * G / (1 - 2 * nu) + 1e-300
    np.testing.assert_allclose(here.stress, hooke(here.gradient, nu=nu), rtol=0, atol=10 * allowed)


def disc(cells, profile):
    """A square grid about the unit disc, and the mean of an axisymmetric pressure over each
    element.
    """
    grid = vc.Grid(nx=cells, ny=cells, dx=2 / cells, dy=2 / cells, x0=-1.0, y0=-1.0)
    fine = (np.arange(16 * cells) + 0.5) / (8 * cells) - 1
    radius = np.hypot(fine, fine[:, None])
    mean = profile(np.minimum(radius, 1.0)) * (radius < 1)
    pressure = mean.reshape(cells, 16, cells, 16).mean(axis=(1, 3))
    return grid, np.stack([0 * pressure, 0 * pressure, pressure])


def love_axis(z):
    """Love's stresses on the axis of a uniformly loaded unit disc: radial, axial."""
    s = z / np.hypot(1, z)
    return -(1 + 2 * NU) / 2 + (1 + NU) * s - s**3 / 2, s**3 - 1


def hertz_axis(z):
    """Stresses on the axis of a Hertzian circle (Johnson, 3.45): radial, axial."""
    return -(1 + NU) * (1 - z * np.arctan(1 / z)) + 0.5 / (1 + z**2), -1 / (1 + z**2)


@pytest.mark.parametrize(
    ("profile", "exact"),
    [(lambda r: 1.0 + 0 * r, love_axis), (lambda r: np.sqrt(1 - r**2), hertz_axis)],
)
def test_axis_of_a_disc(profile, exact):
    """Love's and Hertz's axes: the error falls with the square of the element size."""
    z = np.array([0.2, 0.48, 1.0, 3.0])
    errors = []
    for cells in (16, 32, 64):
        stress = field_at(np.array([0 * z, 0 * z, z]), *disc(cells, profile), G=G, nu=NU).stress
        radial, axial = exact(z)
        expected = np.array([radial, radial, axial])
        errors.append(np.abs(stress[[0, 1, 2], [0, 1, 2]] - expected).max())
        assert np.abs(stress[[0, 0, 1], [1, 2, 2]]).max() < 1e-14
    rate = np.polyfit(np.log([16, 32, 64]), np.log(errors), 1)[0]
    assert rate < -1.7
    assert errors[-1] < 3e-4


def test_surface_has_the_tractions():
    """At z -> 0 below and beside the element, and at z = 0 to rounding."""
    load = np.array([0.3, -0.7, 1.0])
    inside, outside = [0.2, -0.4], [0.6, 0.1]
    for depth, allowed in ((0.0, 1e-15), (1e-13, 1e-12), (1e-6, 3e-5)):
        for (x, y), expected in ((inside, -load), (outside, 0 * load)):
            stress = field([x, y, depth], load=load).stress[:, 2, 0]
            np.testing.assert_allclose(stress, expected, atol=allowed)
    below, at = field([*inside, 1e-9], load=load), field([*inside, 0.0], load=load)
    np.testing.assert_allclose(below.stress, at.stress, atol=1e-7)
    np.testing.assert_allclose(below.gradient, at.gradient, atol=1e-7)


@pytest.mark.long
def test_edges_and_corners_on_the_surface():
    """Finite everywhere; what jumps has its mean, and ln|x| its mean over the element's width."""
    half = np.array([0.3, -0.7, 1.0]) / 2
    for x, y, part in (
        (0.5, 0.1, 1),
        (0.2, -0.5, 1),
        (-0.5, 0.5, 0.5),
        (0.5 * (1 + 1e-16), 0.0, 1),
    ):
        found = field([x, y, 0.0], load=2 * half)
        assert np.isfinite(found.stress).all()
        assert np.isfinite(found.gradient).all()
        np.testing.assert_allclose(found.stress[:, 2, 0], -half * part, atol=1e-14)
        near = field([x * (1 - 1e-9), y * (1 - 1e-9), 1e-9], load=2 * half)
        np.testing.assert_allclose(found.displacement, near.displacement, atol=1e-7)
    fine = (np.arange(100_000) + 0.5) / 100_000  # the other edge's part is no constant: 3 %
    across = field([fine, 0 * fine, 0 * fine], load=(1, 0, 0)).stress[0, 0].mean()
    assert field([0.5, 0.0, 0.0], load=(1, 0, 0)).stress[0, 0, 0] == pytest.approx(across, rel=0.04)


@pytest.mark.parametrize("z", [0.0, 0.3, 4.0, 2000.0])
def test_lattice_is_its_elements(z):
    """Edges that are shared, on both sides of the point and below it; near, and beyond the change
    of rules.
    """
    x = 0.2 - 0.5 * np.arange(-4, 5)[:, None, None] + np.array([0.0, 0.05])
    y = -0.1 - 2.0 * np.arange(-3, 3)[None, :, None] + np.array([0.0, 1.1])
    depths = np.full(2, z)
    together, alone = (
        lattice_potentials(x, y, depths, 0.5, 2.0),
        rectangle_potentials(x, y, depths, 0.5, 2.0),
    )
    assert together.shape == (19, 9, 6, 2)
    np.testing.assert_allclose(together, alone, rtol=0, atol=1e-14)


def test_pieces_of_a_long_grid():
    """Summed in tiles, near ones and far ones: the same as one element after the other."""
    grid = vc.Grid(nx=2100, ny=2, dx=0.5, dy=0.7, x0=-3.0, y0=-1.0)
    loaded = np.random.default_rng(8).choice(2100, 12, replace=False)
    tractions = np.zeros((3, 2, 2100))
    tractions[:, :, loaded] = np.random.default_rng(9).normal(size=(3, 2, 12))
    points = np.array([[-2.0, 0.3, 0.1], [600.0, 0.0, 2.0], [0.0, 0.0, 800.0]]).T
    found, sides = field_at(points, grid, tractions, G=G, nu=NU).stress, grid.sides
    expected = np.zeros_like(found)
    for column in loaded:
        for row in range(2):
            apart = points - np.array([[grid.x[column]], [grid.y[row]], [0.0]])
            expected += field(apart, sides, tractions[:, row, column]).stress
    np.testing.assert_allclose(found, expected, rtol=1e-9, atol=1e-13)


@pytest.mark.parametrize("line", [False, True])
def test_fft_is_the_direct_sum(line):
    grid = (
        vc.Grid(nx=9, dx=0.3, x0=-1.0)
        if line
        else vc.Grid(nx=9, ny=7, dx=0.3, dy=0.5, x0=-1.0, y0=-2.0)
    )
    tractions = np.random.default_rng(4).normal(size=(3, *grid.shape))
    depths = np.array([0.0, 0.05, 2.0])
    fast = field_below(depths, grid, tractions, G=G, nu=NU)
    z, y, x = np.meshgrid(depths, grid.y, grid.x, indexing="ij")
    direct = field_at(np.array([x.ravel(), y.ravel(), z.ravel()]), grid, tractions, G=G, nu=NU)
    for name in ("displacement", "gradient", "stress"):
        expected = getattr(direct, name)
        np.testing.assert_allclose(
            getattr(fast, name).reshape(expected.shape), expected, rtol=0, atol=1e-13
        )


def strip(points, load=(0.3, -0.7, 1.0), reference=2.0):
    """By one strip of unit width, centred at x = 0."""
    points = np.reshape(np.asarray(points, dtype=float), (3, -1))
    grid = vc.Grid(nx=1, dx=1.0, x0=-0.5)
    return field_at(
        points, grid, np.reshape(load, (3, 1, 1)).astype(float), G=G, nu=NU, reference=reference
    )


STRIP_POINTS = np.array(
    [[0.1, 0.4, 0.2], [0.7, 0.0, 0.3], [-3.0, 1.0, 1e-3], [0.5, 0.0, 0.4], [-2.0, 0, 5.0]]
).T


def test_strip_is_a_long_rectangle():
    """Stresses and gradients of plane strain and anti-plane shear; in the limit also on the edges'
    surface.
    """
    long, plane = field(STRIP_POINTS, (1.0, 1e7)), strip(STRIP_POINTS)
    np.testing.assert_allclose(plane.stress, long.stress, atol=1e-7)
    np.testing.assert_allclose(plane.gradient, long.gradient, atol=1e-7)
    np.testing.assert_allclose(plane.stress, hooke(plane.gradient), atol=1e-14)
    assert not plane.gradient[:, 1].any()
    edges = np.transpose([[0.5, 0.0, 0.0], [-0.5, 0.3, 0.0]])
    np.testing.assert_allclose(strip(edges).stress, field(edges, (1.0, 1e7)).stress, atol=1e-6)


def test_strip_displacements_have_the_gradients():
    found, h = strip(STRIP_POINTS).gradient, 1e-5
    for j in (0, 2):
        step = np.zeros((3, 1))
        step[j] = h
        difference = (
            strip(STRIP_POINTS + step).displacement - strip(STRIP_POINTS - step).displacement
        )
        np.testing.assert_allclose(difference / (2 * h), found[:, j], atol=1e-6)


def test_strip_by_flamant():
    """Stresses by the integral over Flamant's line loads, here from Johnson (2.15), (2.23), near
    and very far.
    """
    for x, z in ((0.3, 0.2), (4.0, 1.0), (-300.0, 200.0), (1e5, 3e4)):
        nodes, weights = panels(0.0, 1.0, z, x)
        s = x - nodes
        for load, factor in (((0, 0, 1), z), ((1, 0, 0), s)):
            kernel = (
                -2 / np.pi * factor / (s**2 + z**2) ** 2 * np.array([s * s, s * z, z * z + 0 * s])
            )
            expected = kernel @ weights
            found = strip([x, 0.0, z], load).stress[[0, 0, 2], [0, 2, 2], 0]
            np.testing.assert_allclose(found, expected, rtol=0, atol=1e-11 * np.abs(expected).max())


def test_strip_on_the_surface():
    load = np.array([0.3, -0.7, 1.0])
    x = np.array([0.2, 0.5, 0.7])
    found = strip([x, 0 * x, 0 * x], load)
    np.testing.assert_allclose(
        found.stress[:, 2], -load[:, None] * np.array([1, 0.5, 0]), atol=1e-15
    )
    assert np.isfinite(found.gradient).all()
