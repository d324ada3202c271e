"""Periodic bodies: Westergaard, wavy punches, superposed pressures under friction, and surfaces that
are moved along their period.
"""

from dataclasses import replace

import numpy as np
import pytest

import varcontact as vc
from varcontact.elasticity.halfspace import HalfSpaces, influence_numbers
from varcontact.elasticity.periodic import Periodic

STEEL = vc.Bodies(G=0.7, nu=0.3)  # E* = 1
AMPLITUDE = 0.01


def line(n, tractions="constant"):
    return vc.Grid(nx=n, dx=1 / n, x0=-0.5, periodic=True, tractions=tractions)


def square(n, tractions="constant"):
    corner = {"x0": 0.0, "y0": 0.0}
    return vc.Grid(nx=n, ny=n, dx=1 / n, dy=1 / n, periodic=True, tractions=tractions, **corner)


def cosines(n, force, bodies=STEEL, tractions="constant", **changes):
    grid = line(n, tractions)
    return vc.Scene(
        bodies=bodies,
        surface=vc.SampledDistance(AMPLITUDE * (1 - np.cos(2 * np.pi * grid.x))),
        grid=grid,
        normal_force=force,
        **changes,
    )


def westergaard(x, mean):
    """Pressure of half-spaces with cosines of the period 1 and of the amplitude."""
    square_of_edge = mean / (np.pi * AMPLITUDE)
    inside = np.maximum(square_of_edge - np.sin(np.pi * x) ** 2, 0.0)
    return 2 * mean * np.cos(np.pi * x) / square_of_edge * np.sqrt(inside)


@pytest.mark.parametrize("tractions", ["constant", "trigonometric"])
@pytest.mark.parametrize("half_width", [0.1, 0.25, 0.4])
def test_westergaard(tractions, half_width):
    mean = np.pi * AMPLITUDE * np.sin(np.pi * half_width) ** 2
    found = vc.solve(cosines(128, mean, tractions=tractions))
    exact = westergaard(found.grid.x, mean)
    assert found.pressure.max() == pytest.approx(exact.max(), rel=2e-3)
    off = np.sqrt(np.mean((found.pressure[0] - exact) ** 2))
    assert off < 5e-3 * exact.max()
    assert found.certificate.normal_relative_gap < 1e-9


@pytest.mark.parametrize("bulk", [0.0, 0.3, 2.0])
def test_westergaard_with_bulk_pressure(bulk):
    """A cosine that is closed everywhere, at pi E* amplitude: bulk pressure adds to Westergaard's."""
    closing = np.pi * AMPLITUDE
    found = vc.solve(cosines(64, (1 + bulk) * closing, tractions="trigonometric"))
    exact = closing * (1 + bulk + np.cos(2 * np.pi * found.grid.x))
    np.testing.assert_allclose(found.pressure[0], exact, atol=1e-7 * closing)
    lowest = replace(found.scene, normal_force=0.9 * closing)
    assert vc.solve(lowest).pressure.min() == 0


@pytest.mark.parametrize(("tractions", "off"), [("constant", 2e-3), ("trigonometric", 1e-8)])
def test_a_wavy_punch_in_full_contact(tractions, off):
    """With a pressure beyond it, bulk pressure, and in part: Johnson, Greenwood and Higginson 1985: full at ``sqrt(2) pi E* amplitude``."""
    grid = square(40, tractions)
    x, y = np.meshgrid(grid.x, grid.y)
    waves = np.cos(2 * np.pi * x) * np.cos(2 * np.pi * y)
    closing = np.sqrt(2) * np.pi * AMPLITUDE
    scene = vc.Scene(
        bodies=STEEL,
        surface=vc.SampledDistance(AMPLITUDE * (1 - waves)),
        grid=grid,
        normal_force=1.05 * closing,
    )
    found = vc.solve(scene)
    np.testing.assert_allclose(found.pressure, closing * (1.05 + waves), atol=off * closing)
    partial = vc.solve(replace(scene, normal_force=0.6 * closing))
    assert (partial.pressure > 0).mean() == pytest.approx(0.781, abs=0.01)
    assert scene.doubts == ()


def test_partial_slip_on_waves_is_that_of_block_and_keer():
    """J. M. Block and L. M. Keer, J. Mech. Mater. Struct. 3 (2008) 1207: waves under a tangential
    force Q stick where ``sin^2(pi x) < sin^2(pi a) - Q/(f pi E* amplitude)``, |x| < a in contact.
    """
    force, friction, share = 0.4 * np.pi * AMPLITUDE, 0.3, 0.3
    scene = cosines(400, force, friction=friction, motion=vc.Shift(Fx=-share * friction * force))
    found = vc.solve(scene)
    x = found.grid.x
    in_contact = np.abs(x[found.pressure[0] > 0]).max()
    assert np.sin(np.pi * in_contact) ** 2 == pytest.approx(0.4, abs=0.02)
    sticks = np.abs(found.traction[0, 0]) < friction * found.pressure[0] * (1 - 1e-6)
    stick_edge = np.abs(x[sticks & (found.pressure[0] > 0)]).max()
    assert np.sin(np.pi * stick_edge) ** 2 == pytest.approx(0.4 * (1 - share), abs=0.02)
    # tractions in the middle of the stick area
    middle = np.argmin(np.abs(x))
    full, lower = (westergaard(x, part * force) for part in (1.0, 1 - share))
    expected = -friction * (full - lower)[middle]
    assert found.traction[0, 0, middle] == pytest.approx(expected, rel=1e-2)


def test_tangential_forces_superpose_pressures():
    """Ciavarella 1998: f times the pressure, less f times that under the load that sticks."""
    force, friction = 0.4 * np.pi * AMPLITUDE, 0.3
    scene = cosines(96, force, friction=friction, motion=vc.Shift(Fx=-0.5 * friction * force))
    found = vc.solve(scene, tol=1e-11)
    loads = [vc.solve(cosines(96, share * force)).pressure for share in (1.0, 0.5)]
    expected = -friction * (loads[0] - loads[1])
    np.testing.assert_allclose(found.traction[0], expected, atol=1e-8 * loads[0].max())
    # in closed form, with Westergaard's pressures
    x = found.grid.x
    exact = -friction * (westergaard(x, force) - westergaard(x, 0.5 * force))
    off = np.sqrt(np.mean((found.traction[0, 0] - exact) ** 2))
    assert off < 1e-2 * np.abs(exact).max()
    assert np.max(found.certificate.force_bound) < 1e-9


def test_rough_surfaces_are_those_of_tamaas():
    """A program of its own, spectral (the extra `tamaas`): pressures of a rough surface."""
    tamaas = pytest.importorskip("tamaas")
    n, mean = 64, 0.02
    waves = np.fft.fftfreq(n, 1 / n)
    k = np.hypot(waves, waves[:, None])
    random = np.random.default_rng(5)
    noise = np.fft.fft2(random.normal(size=(n, n))) * np.where((k >= 2) & (k <= 8), 1.0, 0.0)
    height = np.fft.ifft2(noise / np.maximum(k, 1) ** 1.8).real
    height = np.ascontiguousarray(0.01 / height.std() * height)
    tamaas.set_log_level(tamaas.LogLevel.error)
    model = tamaas.ModelFactory.createModel(tamaas.model_type.basic_2d, [1.0, 1.0], [n, n])
    model.E, model.nu = 1 - 0.3**2, 0.3
    tamaas.PolonskyKeerRey(model, height, 1e-12).solve(mean)
    expected = np.array(model.traction).reshape(n, n)
    scene = vc.Scene(
        bodies=STEEL,
        surface=vc.SampledDistance(height.max() - height),
        grid=square(n, "trigonometric"),
        normal_force=mean,
    )
    found = vc.solve(scene, tol=1e-10)
    largest = expected.max()
    np.testing.assert_allclose(found.pressure, expected, atol=1e-6 * largest)
    assert np.array_equal(found.pressure > 1e-6 * largest, expected > 1e-6 * largest)


@pytest.mark.long
@pytest.mark.parametrize("motion", [vc.Steady(vx=1e-3), vc.Shift(ux=1e-3), vc.Steady(Fx=-1e-3)])
def test_what_is_moved_along_the_period_moves_the_solution(motion):
    """Rolling over roughness that repeats: nothing begins or ends at the grid's edges."""
    grid = square(16)
    random = np.random.default_rng(3)
    h = AMPLITUDE * random.uniform(size=grid.shape)
    unlike = vc.Bodies(G=(0.7, 1.0), nu=(0.3, 0.2))
    scene = vc.Scene(
        bodies=unlike,
        surface=vc.SampledDistance(h),
        grid=grid,
        normal_force=0.02,
        friction=0.3,
        motion=motion,
    )
    one = vc.solve(scene)
    moved = vc.solve(replace(scene, surface=vc.SampledDistance(np.roll(h, (5, 3), (0, 1)))))
    for field in ("pressure", "traction"):
        expected = np.roll(getattr(one, field), (5, 3), (-2, -1))
        np.testing.assert_allclose(getattr(moved, field), expected, atol=1e-6)
    assert one.certificate.residual < 1e-7
    assert moved.friction_work == pytest.approx(one.friction_work, rel=1e-5)


def test_a_layer_on_a_rigid_base_gives_way_as_a_whole():
    """Under a mean pressure in full contact, by ``h (1 - 2 nu)/(2 G (1 - nu))`` (no strain across)."""
    layer = vc.Layered([vc.Layer(h=0.3, G=1.0, nu=0.4)], base="rigid")
    found = vc.solve(cosines(32, 1.0, bodies=(layer, "rigid")))
    assert found.pressure.min() > 0
    expected = 0.3 * 0.2 / (2 * 0.6)
    assert found.approach - AMPLITUDE == pytest.approx(expected, rel=1e-6)
    prescribed = vc.solve(
        replace(found.scene, normal_force=None, approach=found.approach, friction=None)
    )
    assert prescribed.normal_force == pytest.approx(1.0, rel=1e-9)


def test_a_wave_of_tractions_has_the_compliance_of_its_wave_number():
    medium = Periodic(HalfSpaces(0.3, 0.1), (12, 16), rows_repeat=True, trigonometric=True)
    grid = vc.Grid(nx=16, ny=12, dx=0.2, dy=0.3, x0=0, y0=0, periodic=True)
    operator = medium.operator(grid, "xyz", "xyz")
    x, y = np.meshgrid(grid.x, grid.y)
    kx, ky = 2 * np.pi * 3 / 3.2, 2 * np.pi * 2 / 3.6
    k = np.hypot(kx, ky)
    phase = kx * x + ky * y
    waves = np.zeros((3, 12, 16))
    waves[2] = np.cos(phase)
    expected = [-0.2 * kx / k, -0.2 * ky / k, 0.0]
    expected = np.multiply.outer(expected, np.sin(phase))
    expected[2] = 1.4 * np.cos(phase)
    np.testing.assert_allclose(operator.apply(waves), expected / k, atol=1e-13)


@pytest.mark.long
def test_products_are_those_of_the_matrix():
    """Without padding along axes that repeat, also after steps of rolling."""
    for rows_repeat in (True, False):
        medium = Periodic(HalfSpaces(0.3, 0.1, 50.0), (14, 15), rows_repeat=rows_repeat)
        grid = vc.Grid(nx=15, ny=14, dx=0.2, dy=0.3, x0=0, y0=0)
        operator = medium.operator(grid, "xyz", "xyz", ((0.0, 1.0), (0.4, -1.0)))
        fields = np.random.default_rng(2).normal(size=(3, 14, 15))
        expected = operator.dense(np.arange(210)) @ fields.ravel()
        np.testing.assert_allclose(operator.apply(fields).ravel(), expected, atol=1e-12)
        assert operator.period == (rows_repeat, True)


def test_rows_that_do_not_repeat_sum_images_along_x():
    """Period 1.6: influence numbers of half-spaces at all periods, less those of far ones."""
    nx, ny, side = 8, 6, 0.2
    flat = HalfSpaces(0.3, 0.1, 40.0)
    grid = vc.Grid(nx=nx, ny=ny, dx=side, dy=side, x0=0, y0=0)
    found = Periodic(flat, (ny, nx), rows_repeat=False).operator(grid, "xyz", "xyz").table
    x = np.arange(nx) * side
    y = np.arange(1 - ny, ny) * side
    names = [a + b for a in "xyz" for b in "xyz"]
    images = np.arange(-400, 401) * nx * side
    numbers = influence_numbers(
        x[:, None] + images, y[:, None, None], side, side, nu=0.3, K=0.1, components=names
    )
    for i, name in enumerate(names):
        summed = numbers[name].sum(axis=-1)
        own = found[i // 3, i % 3][:, nx - 1 :]
        # far images are the same everywhere but for a constant, which counts from a depth
        level = (own - summed).mean() if name[0] == name[1] else 0.0
        np.testing.assert_allclose(own, summed + level, atol=5e-6)


@pytest.mark.parametrize("motion", [None, vc.Steady(vx=1e-3), vc.Shift(Fx=-1e-3, Fy=0.0)])
def test_a_cylinder_of_periodic_length(motion):
    """Waves along x on a cylinder along x; rolled along it they are where they were."""
    grid = vc.Grid(nx=16, ny=20, dx=1 / 16, dy=0.04, x0=0.0, y0=-0.4, periodic="x")
    h = grid.y[:, None] ** 2 / 2 + 1e-3 * np.cos(2 * np.pi * grid.x)
    friction = None if motion is None else 0.3
    scene = vc.Scene(
        bodies=STEEL,
        surface=vc.SampledDistance(h),
        grid=grid,
        normal_force=0.05,
        friction=friction,
        motion=motion,
    )
    found = vc.solve(scene)
    turned = vc.solve(replace(scene, surface=vc.SampledDistance(np.roll(h, 5, 1))))
    np.testing.assert_allclose(turned.pressure, np.roll(found.pressure, 5, 1), atol=1e-8)
    np.testing.assert_allclose(turned.traction, np.roll(found.traction, 5, 2), atol=1e-6)
    smooth = vc.solve(replace(scene, surface=vc.SampledDistance(0 * h + grid.y[:, None] ** 2 / 2)))
    line = vc.solve(
        vc.Scene(
            bodies=STEEL,
            surface=vc.SampledDistance(grid.y**2 / 2),
            grid=vc.Grid(nx=20, dx=0.04, x0=-0.4),
            normal_force=0.05,
        )
    )
    np.testing.assert_allclose(smooth.pressure, line.pressure.T + 0 * h, atol=1e-7)


def test_files_keep_the_period(tmp_path):
    found = vc.solve(cosines(32, 0.01, friction=0.3, motion=vc.Steady(vx=1e-3)))
    found.save(tmp_path / "periodic.nc")
    again = vc.load(tmp_path / "periodic.nc")
    assert again.note == "" and again.scene.grid == found.scene.grid
    assert again.scene.grid.periodic is True


SPHERE = vc.Paraboloids(Rx=1.0, Ry=1.0)


@pytest.mark.parametrize(
    ("make", "field", "words"),
    [
        (lambda: vc.Grid(nx=8, periodic=True), "grid.periodic", "explicit"),
        (lambda: vc.Grid(nx=8, dx=1, x0=0, periodic="y"), "grid.periodic", "True, False"),
        (
            lambda: vc.Grid(nx=8, dx=1, x0=0, periodic=True, edge="touched"),
            "grid.periodic",
            "edge",
        ),
        (
            lambda: vc.Grid(nx=8, dx=1, x0=0, tractions="trigonometric"),
            "grid.tractions",
            "periodic",
        ),
        (
            lambda: cosines(8, 0.01, bodies=(vc.Winkler(h=1.0, E=1.0, G=1.0), "rigid")),
            "bodies",
            "half-spaces",
        ),
        (lambda: replace(cosines(16, 0.01), surface=vc.Cylinders(1.0)), "surface", "Sampled"),
        (
            lambda: cosines(16, 0.01, friction=0.3, motion=vc.Transient(steps=2, vx=1e-3)),
            "motion",
            "histories",
        ),
        (
            lambda: cosines(
                8,
                0.01,
                bodies=vc.Elasticity(
                    kernel=np.eye(3)[..., None, None] * [0, 1.0, 0], sides=(1 / 8,)
                ),
            ),
            "grid.periodic",
            "kernel",
        ),
        (
            lambda: vc.solve(cosines(16, 0.01, friction=0.3, motion=vc.Steady(vx=1e-3, dq=0.03))),
            "motion.dq",
            "whole number",
        ),
        (
            lambda: vc.stress(vc.solve(cosines(16, 0.01)), [[0.0], [0.0], [1.0]]),
            "grid.periodic",
            "stresses",
        ),
    ],
)
def test_what_is_refused(make, field, words):
    with pytest.raises(vc.SceneError, match=words) as error:
        make()
    assert error.value.field == field
