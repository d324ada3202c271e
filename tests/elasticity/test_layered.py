"""Compliance and influence numbers of layered bodies against closed forms, quadrature, limits and
printed numbers.
"""

import numpy as np
import pytest

import varcontact as vc
from varcontact.elasticity.halfspace import HalfSpaces
from varcontact.elasticity.layered import LayeredPair, Stack, half_space
from varcontact.elasticity.layered_field import layered_field_at, layered_field_below
from varcontact.elasticity.subsurface import field_at
from varcontact.scene.grid import Grid

UPPER = Stack(layers=((0.5, 2.0, 0.2), (1.0, 0.4 / 1.5, 0.45)), base=(0.8 / 1.5, 0.25))
LOWER = Stack(layers=((0.8, 1 / 1.5, 0.4),), base="rigid")
PAIR = LayeredPair(UPPER, LOWER, depth=3.0)
RIGID = Stack((), (np.inf, 0.3))
K = np.geomspace(1e-12, 1e3, 61)
NINE = ("xx", "xy", "xz", "yx", "yy", "yz", "zx", "zy", "zz")


def strips(dx):
    return Grid(nx=1, dx=dx, x0=0.0)


def rectangles(dx, dy):
    return Grid(nx=1, ny=1, dx=dx, dy=dy, x0=0.0, y0=0.0)


def on_rigid(nu, base="rigid", h=1.0, G=0.5):
    """A layer on a base, against a rigid body: the combined modulus of the surfaces is 1."""
    return LayeredPair(Stack(((h, G, nu),), base), RIGID)


# ----------------------------------------------------------------------------- compliance


@pytest.mark.parametrize("nu", [-0.5, 0.0, 0.3, 0.5])
def test_homogeneous_cut_into_layers(nu):
    stack = Stack(((0.3, 2.0, nu), (1e-5, 2.0, nu), (4.0, 2.0, nu)), base=(2.0, nu))
    np.testing.assert_allclose(
        stack.compliance(K), np.tile(half_space(2.0, nu)[:, None], K.size), rtol=0, atol=1e-13
    )


@pytest.mark.parametrize("nu", [-0.5, 0.0, 0.3, 0.5])
def test_closed_forms_of_one_layer(nu):
    k = np.geomspace(0.05, 20, 40)
    s, c, part = np.sinh(2 * k), np.cosh(2 * k), (1 - nu) / 0.5
    bonded = (
        part * ((3 - 4 * nu) * s - 2 * k) / ((3 - 4 * nu) * c + 2 * k**2 + 5 - 12 * nu + 8 * nu**2)
    )
    for base, F22, f in (
        ("rigid", bonded, np.tanh(k)),
        ("smooth", part * (c - 1) / (s + 2 * k), 1 / np.tanh(k)),
    ):
        found = Stack(((1.0, 0.5, nu),), base).compliance(k)
        np.testing.assert_allclose(found[2], F22, rtol=1e-10)
        np.testing.assert_allclose(found[3], f / 0.5, rtol=1e-14)


def test_long_waves_on_one_layer():
    k = np.array([1e-9, 1e-6])
    for nu in (0.0, 0.3, 0.45):
        np.testing.assert_allclose(
            on_rigid(nu).symbols(k)[2], k * (1 - 2 * nu) / (1 - nu), rtol=1e-10
        )
        np.testing.assert_allclose(on_rigid(nu, "smooth").symbols(k)[2], k * (1 - nu), rtol=1e-10)
    np.testing.assert_allclose(on_rigid(0.5).symbols(k)[2], k**3 / 1.5, rtol=1e-10)


def test_symbols_of_several_layers():
    """Computed by another program, checked there by integration of the differential equation;
    moduli times 1.5.
    """
    k = np.array([1e-6, 0.1, 0.5, 1.0, 2.0])
    upper = [
        [0.937499029853, 0.312498997248, 0.937499192030, 1.249999697913],
        [0.806280334632, 0.222871504400, 0.876327776002, 1.189977350530],
        [0.441292310640, 0.131411680867, 0.852919832948, 0.835721644927],
        [0.340908045554, 0.215677481090, 0.921461348157, 0.585171098271],
        [0.354170515100, 0.294939317090, 0.753317281971, 0.410006617824],
    ]
    both = [
        [0.937499829853, 0.312498997248, 0.937499325363, 1.250000497910],
        [0.885632226360, 0.224453282544, 0.889717474129, 1.269807119640],
        [0.775135586303, 0.162116079485, 0.925354311374, 1.215670607180],
        [0.804989095131, 0.281494902431, 1.084056177110, 1.249207868540],
        [0.867022340697, 0.336108049017, 1.104833413940, 1.331675172230],
    ]
    np.testing.assert_allclose(UPPER.compliance(k).T / 1.5, upper, atol=1e-11)
    np.testing.assert_allclose(PAIR.symbols(k).T / 1.5, both, atol=1e-11)


# ----------------------------------------------------------------------------- influence numbers


def by_quadrature(pair, x, dx, depth):
    """What layers add to a strip's numbers, from the integral over wave numbers with the strip's
    own transform.
    """
    points, weights = np.polynomial.legendre.leggauss(20)
    top = 20.0 / pair.thickness
    graded = np.geomspace(top * 1e-15, top, 200)
    edges = np.unique([0.0, *graded, *np.arange(0.0, top, 2 / (x + depth))])
    k = ((edges[:-1, None] + edges[1:, None]) / 2 + np.diff(edges)[:, None] / 2 * points).ravel()
    weights = (np.diff(edges)[:, None] / 2 * weights).ravel() * dx / (np.pi * k)
    alpha, kappa, gamma, beta = (pair.symbols(k) - pair.symbols()[:, None]) * weights
    mean = np.sinc(k * dx / (2 * np.pi))
    even = mean * np.cos(k * x) - np.cos(k * depth)
    return {
        "xx": even @ alpha,
        "yy": even @ beta,
        "zz": even @ gamma,
        "xz": -(mean * np.sin(k * x)) @ kappa,
    }


@pytest.mark.parametrize("dx", [0.02, 0.4, 9.0])
def test_strips_by_quadrature(dx):
    half_spaces = HalfSpaces(1 - PAIR.symbols()[0] / 2, PAIR.symbols()[1] / 2, 3.0)
    for x in (0.0, dx, 0.3 + dx, 20.0 * dx):
        found = PAIR.influence(strips(dx), np.array([x]), np.zeros(1), NINE)
        closed = half_spaces.influence(strips(dx), np.array([x]), np.zeros(1), NINE)
        for name, added in by_quadrature(PAIR, x, dx, 3.0).items():
            assert found[name][0] - closed[name][0] == pytest.approx(
                added, rel=1e-9, abs=1e-12 * dx
            )


def test_strips_and_rectangles():
    """Computed by another program; moduli times 1.5."""
    found = PAIR.influence(strips(0.4), np.array([0.0, 0.4, 4.0]), np.zeros(3), NINE)
    expected = {
        "xx": [0.392216254506, 0.208944861437, -0.028865393510],
        "yy": [0.603943726763, 0.324546389339, -0.044413149899],
        "zz": [0.470003481201, 0.274085136756, -0.026356460864],
        "xz": [0.0, -0.044230463029, -0.035186383030],
    }
    for name, numbers in expected.items():
        np.testing.assert_allclose(found[name] / 1.5, numbers, atol=1e-12)
    x, y = np.array([0.0, 0.25, 0.25, 5.0]), np.array([0.0, 0.0, 0.35, 3.5])
    found = PAIR.influence(rectangles(0.25, 0.35), x, y, NINE)
    expected = {
        "xx": [0.176312091978, 0.068832251554, 0.033481510907, 0.002680481758],
        "xy": [0.0, 0.0, 0.006809192715, 0.000469278134],
        "xz": [0.0, -0.003642823985, -0.003065583212, -0.000297805404],
        "yy": [0.184020298248, 0.051080518534, 0.037438830419, 0.002338316680],
        "yz": [0.0, 0.0, -0.004232383781, -0.000208424107],
        "zz": [0.152456546205, 0.056728364499, 0.035878895738, 0.002033057502],
    }
    for name, numbers in expected.items():
        np.testing.assert_allclose(found[name] / 1.5, numbers, atol=1e-12)
    larger = PAIR.influence(rectangles(3.0, 2.0), np.array([0.0, 3.0]), np.array([0.0, 2.0]), NINE)
    np.testing.assert_allclose(larger["zz"] / 1.5, [1.381181264137, 0.224952465373], atol=1e-11)
    np.testing.assert_allclose(larger["xx"] / 1.5, [1.444877534671, 0.306972779763], atol=1e-11)


def test_across_a_strip_on_a_rigid_base():
    """Anti-plane shear of a layer, a line force: -ln(tanh(pi |x|/(4 h)))/(pi G)."""
    pair, x, dx = on_rigid(0.3), np.array([0.3, 1.0, 2.5]), 1e-4
    found = pair.influence(strips(dx), x, np.zeros(3), ["yy"])["yy"] / dx
    np.testing.assert_allclose(found, -np.log(np.tanh(np.pi * x / 4)) / (np.pi * 0.5), rtol=1e-7)


@pytest.mark.long
def test_numbers_are_sums_of_those_of_parts():
    """An element of 4 x 3 parts, far larger than the thickness and far smaller."""
    for h in (0.02, 1.0, 40.0):
        layers = Stack(((h, 0.7, 0.45), (3 * h, 0.05, 0.5)), (40.0, 0.2))
        pair = LayeredPair(layers, Stack(((2 * h, 1.75, 0.1),), "rigid"))
        x, y = np.meshgrid((np.arange(4) - 1.5) * 0.5, (np.arange(3) - 1.0) * 0.5)
        for at in ((0.0, 0.0), (0.3, 1.1), (7.0, -2.0)):
            whole = pair.influence(rectangles(2.0, 1.5), np.array([at[0]]), np.array([at[1]]), NINE)
            parts = pair.influence(rectangles(0.5, 0.5), at[0] - x, at[1] - y, NINE)
            for name in NINE:
                assert whole[name][0] == pytest.approx(parts[name].sum(), rel=1e-9, abs=1e-12), (
                    h,
                    at,
                    name,
                )


def test_long_rectangles_are_strips():
    """A rectangle of the length 2 l over a layer on a rigid base: its ends are out of reach."""
    x = np.array([0.0, 0.2, 0.7])
    pair = on_rigid(0.3, h=0.3)
    strip = pair.influence(strips(0.2), x, np.zeros(3), NINE)
    long = pair.influence(rectangles(0.2, 20.0), x, np.zeros(3), NINE)
    for name in ("xx", "yy", "zz", "xz"):
        np.testing.assert_allclose(long[name], strip[name], atol=1e-11)


def matrix(pair, grid, lag=None):
    """Of all three components on a grid, or its difference over a step."""
    x, y = (
        (each.ravel() for each in np.meshgrid(grid.x, grid.y))
        if not grid.line
        else (grid.x, np.zeros(grid.nx))
    )
    from_x, from_y = x[:, None] - x, y[:, None] - y
    numbers = pair.influence(grid, from_x, from_y, NINE)
    if lag is not None:
        before = pair.influence(grid, from_x + lag, from_y, NINE)
        numbers = {name: numbers[name] - before[name] for name in NINE}
    return np.block([[numbers[row + column] for column in "xyz"] for row in "xyz"])


@pytest.mark.long
@pytest.mark.parametrize("nu", [0.0, 0.3, 0.5])
@pytest.mark.parametrize("ratio", [0.05, 1.0, 30.0])
def test_symmetric_and_positive_definite(nu, ratio):
    """The whole matrix, of elements `ratio` times as long as the layer is thick; in rolling its
    symmetric part.
    """
    layers = Stack(((1.0, 0.7, nu), (2.0, 0.1, 0.4)), (5.0, 0.2))
    for each in (on_rigid(nu), LayeredPair(layers, Stack(((0.5, 1.75, 0.1),), "rigid"), 400.0)):
        for grid in (
            Grid(nx=24, dx=ratio, x0=0.0),
            Grid(nx=5, ny=4, dx=ratio, dy=1.4 * ratio, x0=0.0, y0=0.0),
        ):
            A = matrix(each, grid)
            np.testing.assert_allclose(A, A.T, rtol=0, atol=1e-14 * np.abs(A).max())
            assert np.linalg.eigvalsh(A).min() > 0
            M = matrix(each, grid, lag=ratio)
            assert np.linalg.eigvalsh(M + M.T).min() > 0


def test_alike_means_no_coupling():
    assert LayeredPair(UPPER, UPPER).K == 0
    assert LayeredPair(UPPER, Stack(UPPER.layers, "rigid")).K > 0  # of like surfaces
    found = LayeredPair(UPPER, UPPER).influence(rectangles(1.0, 1.0), np.ones(1), np.ones(1), NINE)
    assert all(found[name][0] == 0 for name in ("xz", "zx", "yz", "zy"))


# --------------------------------------------------------------------- Fields inside layered bodies


RECTANGLES = Grid(nx=4, ny=3, dx=0.3, dy=0.2, x0=-0.7, y0=-0.4)
STRIPS = Grid(nx=5, dx=0.3, x0=-0.9)
LAYERS = ((0.3, 2.0, 0.3), (0.5, 0.4, 0.45))
X, Y = np.array([0.1, 0.2, -0.5, 2.0]), np.array([0.05, 0.3, 0.1, -1.0])


def loads(grid):
    return np.random.default_rng(5).normal(size=(3, grid.rows, grid.nx))


def at_depth(depth, grid, stack):
    return layered_field_at(np.array([X, Y, np.full(4, depth)]), grid, loads(grid), stack=stack)


@pytest.mark.parametrize("grid", [RECTANGLES, STRIPS])
@pytest.mark.parametrize("nu", [0.0, 0.3, 0.5])
def test_half_space_cut_into_layers(grid, nu):
    points = np.array([X, Y, [0.02, 0.31, 1.2, 0.4]])
    stack = Stack(((0.3, 1.7, nu), (0.5, 1.7, nu)), (1.7, nu))
    found = layered_field_at(points, grid, loads(grid), stack=stack)
    exact = field_at(points, grid, loads(grid), G=1.7, nu=nu)
    np.testing.assert_allclose(found.stress, exact.stress, atol=1e-11)
    np.testing.assert_allclose(found.gradient, exact.gradient, atol=1e-11)
    if not grid.line:
        np.testing.assert_allclose(found.displacement, exact.displacement, atol=1e-12)


@pytest.mark.parametrize("grid", [RECTANGLES, STRIPS])
def test_interfaces_are_bonded(grid):
    """Displacements, their gradients along the surface and the tractions go on, stresses along the
    surface jump.
    """
    above, below = (at_depth(0.3 + part, grid, Stack(LAYERS, (3.0, 0.2))) for part in (-1e-9, 1e-9))
    np.testing.assert_allclose(above.gradient[:, :2], below.gradient[:, :2], atol=1e-7)
    np.testing.assert_allclose(above.stress[:, 2], below.stress[:, 2], atol=1e-7)
    assert np.abs(above.stress[0, 0] - below.stress[0, 0]).max() > 0.05
    if not grid.line:
        np.testing.assert_allclose(above.displacement, below.displacement, atol=1e-7)


@pytest.mark.long
@pytest.mark.parametrize("grid", [RECTANGLES, STRIPS])
def test_surface_and_bases(grid):
    centre = np.array([[grid.x[1]], [grid.y[0]], [0.0]])
    surface = layered_field_at(centre, grid, loads(grid), stack=Stack(LAYERS, "rigid"))
    np.testing.assert_allclose(surface.stress[:, 2, 0], -loads(grid)[:, 0, 1], atol=1e-4)
    rigid, smooth = (at_depth(0.8, grid, Stack(LAYERS, base)) for base in ("rigid", "smooth"))
    np.testing.assert_allclose(rigid.gradient[:, :2], 0, atol=1e-6)
    np.testing.assert_allclose(smooth.gradient[2, :2], 0, atol=1e-6)
    np.testing.assert_allclose(smooth.stress[:2, 2], 0, atol=1e-6)
    assert np.abs(smooth.gradient[:2, :2]).max() > 0.01
    if not grid.line:
        np.testing.assert_allclose(rigid.displacement, 0, atol=1e-6)
    with pytest.raises(vc.SceneError, match="within the layers"):
        at_depth(0.9, grid, Stack(LAYERS, "rigid"))


@pytest.mark.parametrize("grid", [RECTANGLES, STRIPS])
def test_by_fft(grid):
    stack, depths = Stack(LAYERS, (3.0, 0.2)), np.array([0.1, 0.7])
    below = layered_field_below(depths, grid, loads(grid), stack=stack)
    z, y, x = np.meshgrid(depths, grid.y, grid.x, indexing="ij")
    points = layered_field_at(
        np.array([x.ravel(), y.ravel(), z.ravel()]), grid, loads(grid), stack=stack
    )
    for name in ("gradient", "stress"):
        np.testing.assert_allclose(
            getattr(below, name).reshape(3, 3, -1), getattr(points, name), atol=1e-12
        )


@pytest.mark.long
def test_below_a_contact():
    """In a coat of the base's own material stresses are those of the half-space; the lower body is
    its mirror image.
    """
    coat, plain = vc.Layered([vc.Layer(0.2, 1.0, 0.3)], base=(1.0, 0.3)), vc.Bodies(1.0, 0.3)
    entries = {
        "surface": vc.Paraboloids(1.0, 1.0),
        "normal_force": 0.1,
        "grid": vc.Grid(nx=10, ny=10),
    }
    rolling = {"friction": 0.3, "motion": vc.Steady(vx=0.01)}
    points = [[0.0, 0.1], [0.0, 0.05], [-0.05, -0.4]]
    sol = vc.solve(vc.Scene(bodies=(plain, coat), **entries, **rolling))
    layered = vc.stress(sol, points, body="lower")
    half_spaces = vc.solve(
        vc.Scene(bodies=plain, **entries | {"grid": sol.grid}, **rolling), normal="norm"
    )
    expected = vc.stress(half_spaces, points, body="lower")
    np.testing.assert_allclose(layered.stress, expected.stress, atol=1e-8)
    np.testing.assert_allclose(
        vc.stress(sol, np.abs(points)).stress,
        vc.stress(half_spaces, np.abs(points)).stress,
        atol=1e-8,
    )
    depth = vc.stress_below(sol, [0.05], body="lower")
    assert depth.stress.shape == (3, 3, 1, *sol.grid.shape)
    with pytest.raises(vc.SceneError, match=r"^body = 1 .* half-space.* Layered"):
        vc.stress(vc.solve(vc.Scene(bodies=("rigid", coat), **entries)), [0.0, 0.0, 0.1])
