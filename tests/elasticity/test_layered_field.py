"""Fields inside layered bodies: those of half-spaces cut into layers, and the conditions on interfaces and bases."""

import numpy as np
import pytest

import varcontact as vc
from varcontact.elasticity.layered import Stack
from varcontact.elasticity.layered_field import layered_field_at, layered_field_below
from varcontact.elasticity.subsurface import field_at
from varcontact.scene.grid import Grid

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
    found, exact = (
        layered_field_at(points, grid, loads(grid), stack=stack),
        field_at(points, grid, loads(grid), G=1.7, nu=nu),
    )
    np.testing.assert_allclose(found.stress, exact.stress, atol=1e-11)
    np.testing.assert_allclose(found.gradient, exact.gradient, atol=1e-11)
    if not grid.line:
        np.testing.assert_allclose(found.displacement, exact.displacement, atol=1e-12)


@pytest.mark.parametrize("grid", [RECTANGLES, STRIPS])
def test_interfaces_are_bonded(grid):
    """Displacements, their gradients along the surface and the tractions go on, stresses along the surface jump."""
    above, below = (at_depth(0.3 + part, grid, Stack(LAYERS, (3.0, 0.2))) for part in (-1e-9, 1e-9))
    np.testing.assert_allclose(above.gradient[:, :2], below.gradient[:, :2], atol=1e-7)
    np.testing.assert_allclose(above.stress[:, 2], below.stress[:, 2], atol=1e-7)
    assert np.abs(above.stress[0, 0] - below.stress[0, 0]).max() > 0.05
    if not grid.line:
        np.testing.assert_allclose(above.displacement, below.displacement, atol=1e-7)


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
    points = layered_field_at(np.array([x.ravel(), y.ravel(), z.ravel()]), grid, loads(grid), stack=stack)
    for name in ("gradient", "stress"):
        np.testing.assert_allclose(getattr(below, name).reshape(3, 3, -1), getattr(points, name), atol=1e-12)


def test_below_a_contact():
    """In a coat of the base's own material stresses are those of the half-space; the lower body is its mirror image."""
    coat, plain = vc.Layered([vc.Layer(0.2, 1.0, 0.3)], base=(1.0, 0.3)), vc.Bodies(1.0, 0.3)
    entries = {"surface": vc.Paraboloids(1.0, 1.0), "normal_force": 0.1, "grid": vc.Grid(nx=10, ny=10)}
    rolling = {"friction": 0.3, "motion": vc.Steady(vx=0.01)}
    points = [[0.0, 0.1], [0.0, 0.05], [-0.05, -0.4]]
    sol = vc.solve(vc.Scene(bodies=(plain, coat), **entries, **rolling))
    layered = vc.stress(sol, points, body="lower")
    half_spaces = vc.solve(vc.Scene(bodies=plain, **entries | {"grid": sol.grid}, **rolling), normal="norm")
    expected = vc.stress(half_spaces, points, body="lower")
    np.testing.assert_allclose(layered.stress, expected.stress, atol=1e-8)
    np.testing.assert_allclose(
        vc.stress(sol, np.abs(points)).stress, vc.stress(half_spaces, np.abs(points)).stress, atol=1e-8
    )
    depth = vc.stress_below(sol, [0.05], body="lower")
    assert depth.stress.shape == (3, 3, 1, *sol.grid.shape)
    with pytest.raises(vc.SceneError, match=r"^body = 1 .* half-space.* Layered"):
        vc.stress(vc.solve(vc.Scene(bodies=("rigid", coat), **entries)), [0.0, 0.0, 0.1])
