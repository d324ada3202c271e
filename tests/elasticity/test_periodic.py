"""Periodic bodies: Westergaard, wavy punches, superposed pressures under friction, and surfaces that
are moved along their period.
"""

from dataclasses import replace

import numpy as np
import pytest

import varcontact as vc
from varcontact.elasticity.periodic import periodic_kernel

STEEL = vc.Bodies(G=0.7, nu=0.3)  # E* = 1
AMPLITUDE = 0.01


def line(n):
    return vc.Grid(nx=n, dx=1 / n, x0=-0.5)


def square(n):
    return vc.Grid(nx=n, ny=n, dx=1 / n, dy=1 / n, x0=0.0, y0=0.0)


def cosines(n, force, bodies=STEEL, symbol="elements", **changes):
    grid = line(n)
    return vc.Scene(
        bodies=vc.Elasticity.periodic(bodies, grid, symbol=symbol),
        surface=vc.SampledDistance(AMPLITUDE * (1 - np.cos(2 * np.pi * grid.x))),
        grid=grid,
        normal_force=force,
        **changes,
    )


@pytest.mark.parametrize("symbol", ["elements", "spectral"])
@pytest.mark.parametrize("half_width", [0.1, 0.25, 0.4])
def test_westergaard(symbol, half_width):
    mean = np.pi * AMPLITUDE * np.sin(np.pi * half_width) ** 2
    found = vc.solve(cosines(128, mean, symbol=symbol))
    square_of_edge = np.sin(np.pi * half_width) ** 2
    x = found.grid.x
    inside = np.maximum(square_of_edge - np.sin(np.pi * x) ** 2, 0.0)
    exact = 2 * mean * np.cos(np.pi * x) / square_of_edge * np.sqrt(inside)
    assert found.pressure.max() == pytest.approx(exact.max(), rel=2e-3)
    off = np.sqrt(np.mean((found.pressure[0] - exact) ** 2))
    assert off < 5e-3 * exact.max()
    assert found.certificate.normal_relative_gap < 1e-9


@pytest.mark.parametrize(("symbol", "off"), [("elements", 2e-3), ("spectral", 1e-8)])
def test_a_wavy_punch_in_full_contact(symbol, off):
    """Johnson, Greenwood and Higginson 1985: full at ``sqrt(2) pi E* amplitude``."""
    grid = square(40)
    x, y = np.meshgrid(grid.x, grid.y)
    waves = np.cos(2 * np.pi * x) * np.cos(2 * np.pi * y)
    closing = np.sqrt(2) * np.pi * AMPLITUDE
    scene = vc.Scene(
        bodies=vc.Elasticity.periodic(STEEL, grid, symbol=symbol),
        surface=vc.SampledDistance(AMPLITUDE * (1 - waves)),
        grid=grid,
        normal_force=1.05 * closing,
    )
    found = vc.solve(scene)
    np.testing.assert_allclose(found.pressure, closing * (1.05 + waves), atol=off * closing)
    partial = vc.solve(replace(scene, normal_force=0.6 * closing))
    assert (partial.pressure > 0).mean() == pytest.approx(0.781, abs=0.01)
    assert scene.doubts == ()


def test_tangential_forces_superpose_pressures():
    """Ciavarella 1998: f times the pressure, less f times that under the load that sticks."""
    force, friction = 0.4 * np.pi * AMPLITUDE, 0.3
    scene = cosines(96, force, friction=friction, motion=vc.Shift(Fx=-0.5 * friction * force))
    found = vc.solve(scene, tol=1e-11)
    loads = [vc.solve(cosines(96, share * force)).pressure for share in (1.0, 0.5)]
    expected = -friction * (loads[0] - loads[1])
    np.testing.assert_allclose(found.traction[0], expected, atol=1e-8 * loads[0].max())
    assert np.max(found.certificate.force_bound) < 1e-9


@pytest.mark.parametrize("motion", [vc.Steady(vx=1e-3), vc.Shift(ux=1e-3), vc.Steady(Fx=-1e-3)])
def test_what_is_moved_along_the_period_moves_the_solution(motion):
    """Rolling over roughness that repeats: nothing begins or ends at the grid's edges."""
    grid = square(16)
    random = np.random.default_rng(3)
    h = AMPLITUDE * random.uniform(size=grid.shape)
    unlike = vc.Bodies(G=(0.7, 1.0), nu=(0.3, 0.2))
    scene = vc.Scene(
        bodies=vc.Elasticity.periodic(unlike, grid),
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


def test_spectral_numbers_are_the_compliance_itself():
    """A wave of tractions on like layers, resting on a rigid base."""
    grid = square(12)
    layer = vc.Layered([vc.Layer(h=0.3, G=1.0, nu=0.4)], base="rigid")
    table = periodic_kernel(layer, grid, spectral=True, mean=None)
    first = table[2, 2, 11:, 11:]
    wave = np.cos(2 * np.pi * grid.x)
    response = sum(
        (np.roll(first, (row, column), (0, 1)) * wave[column])[0]
        for row in range(12)
        for column in range(12)
    )
    assert np.allclose(response / wave, response[0] / wave[0])


def test_the_mean_moves_bodies_as_a_whole():
    force = 0.3 * np.pi * AMPLITUDE
    one = vc.solve(cosines(64, force))
    grid = line(64)
    bodies = vc.Elasticity.periodic(STEEL, grid, mean=5.0)
    other = vc.solve(replace(cosines(64, force), bodies=bodies))
    np.testing.assert_allclose(other.pressure, one.pressure, atol=1e-9)
    default = 1 / np.pi  # 2/(E* k) of the longest wave
    assert other.approach - one.approach == pytest.approx((5.0 - default) * force, rel=1e-6)
    again = vc.solve(
        replace(cosines(64, force), bodies=bodies, normal_force=None, approach=other.approach)
    )
    assert again.normal_force == pytest.approx(force, rel=1e-9)


def test_files_keep_the_period(tmp_path):
    found = vc.solve(cosines(32, 0.01, friction=0.3, motion=vc.Steady(vx=1e-3)))
    found.save(tmp_path / "periodic.nc")
    again = vc.load(tmp_path / "periodic.nc")
    assert again.note == "" and again.scene.bodies == found.scene.bodies
    assert again.scene.bodies.period


@pytest.mark.parametrize(
    ("make", "field", "words"),
    [
        (lambda: vc.Elasticity.periodic(STEEL, vc.Grid(nx=8)), "grid", "explicit"),
        (lambda: vc.Elasticity.periodic(STEEL, line(8), symbol="sine"), "symbol", "one of"),
        (lambda: vc.Elasticity.periodic(STEEL, line(8), mean=-1.0), "mean", "positive"),
        (
            lambda: vc.Elasticity.periodic(vc.Winkler(h=1.0, E=1.0, G=1.0), line(8)),
            "bodies",
            "half-spaces, elastic layers",
        ),
        (lambda: replace(cosines(16, 0.01), grid=vc.Grid(nx=8, dx=1 / 16, x0=0)), None, "8"),
        (
            lambda: replace(cosines(16, 0.01), surface=vc.Cylinders(1.0)),
            "surface",
            "SampledDistance",
        ),
        (
            lambda: cosines(16, 0.01, friction=0.3, motion=vc.Transient(steps=2, vx=1e-3)),
            "motion",
            "histories",
        ),
        (
            lambda: vc.solve(cosines(16, 0.01, friction=0.3, motion=vc.Steady(vx=1e-3, dq=0.03))),
            "motion.dq",
            "whole number",
        ),
    ],
)
def test_what_is_refused(make, field, words):
    with pytest.raises(vc.SceneError, match=words) as error:
        make()
    assert field is None or error.value.field == field
