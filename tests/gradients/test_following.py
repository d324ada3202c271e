"""Gradients on grids that follow the contact: closed forms, samples, and where they are refused."""

from dataclasses import replace
from functools import partial

import numpy as np
import pytest

import varcontact as vc
from tests.gradients.differences import COARSE, EXACT, LIKE, ROLLING, contact, difference, solved
from varcontact.errors import SceneError

MOVING = ("normal_force", "bodies.G")
"""Inputs that change the size of the contact, and that all surfaces have."""
ALONG = vc.Steady(vx=4e-4)
LINE = vc.Grid(nx=30, dx=0.1, x0=-1.52)
LOADED = vc.SurfaceLoad(x=(3.0, 4.0), y=(-0.5, 0.5), pressure=0.01)


def paraboloid(x, y):
    """Distance of the surface of `contact`."""
    return x**2 / 200 + y[:, None] ** 2 / 180


def loaded(scene, force):
    """The scene under another load."""
    return replace(scene, normal_force=force)


@pytest.mark.parametrize("motion", [ROLLING, None], ids=["rolling", "without motion"])
def test_outputs_of_pressure_have_the_powers_of_hertz(motion):
    """p_0 ~ (N G^2)^(1/3), area and approach ~ (N/G)^(2/3); sums to rounding."""
    scene = contact(motion=motion, grid=vc.Grid(nx=16, ny=16))
    outputs = ["peak_pressure", "contact_area", "approach", "normal_force"]
    found = vc.solve(scene, **EXACT).gradient(outputs, MOVING, error=True)
    of_load = found.normal_force * 0.02 / found.value
    assert np.allclose(of_load, [1 / 3, 2 / 3, 2 / 3, 1], atol=1e-8)
    of_modulus = found["bodies.G"] * 1.0 / found.value
    assert np.allclose(of_modulus, [2 / 3, -2 / 3, -2 / 3, 0], atol=1e-8)
    rounding = 1e-5  # a centre of the larger elements is on the edge of the ellipse
    for name in MOVING:
        assert (found[f"{name}_error"] <= 0.1 * np.abs(found[name]) + rounding).all()


def test_outputs_of_pressure_have_the_powers_of_hertz_in_line_contact():
    """p_0 ~ (N G)^(1/2), width ~ (N/G)^(1/2)."""
    scene = contact(LIKE, ALONG, surface=vc.Cylinders(100.0), grid=vc.Grid(nx=30))
    found = vc.solve(scene, **EXACT).gradient(["peak_pressure", "contact_area"], MOVING)
    assert np.allclose(found.normal_force * 0.02 / found.value, 0.5, atol=1e-8)
    assert np.allclose(found["bodies.G"] / found.value, [0.5, -0.5], atol=1e-8)


@pytest.mark.parametrize("far", [2.0, float(COARSE.x[-1])], ids=["beyond the grid", "to its edge"])
def test_samples_with_places_are_a_paraboloid_in_closed_form(far):
    """Splines have paraboloids exactly, also where the samples end with the grid."""
    x = np.linspace(min(-far, COARSE.x[0]), far, 31)
    y = np.linspace(min(-far, COARSE.y[0]), max(far, COARSE.y[-1]), 25)
    samples = vc.SampledDistance(paraboloid(x, y), x, y)
    compare(contact(surface=samples, grid=COARSE), contact(grid=COARSE))


def test_samples_with_places_in_line_contact():
    x = np.linspace(-2.0, 2.0, 31)
    samples = vc.SampledDistance(x**2 / 200, x)
    line = contact(LIKE, ALONG, surface=vc.Cylinders(100.0), grid=LINE)
    compare(replace(line, surface=samples), line)


def test_samples_at_the_elements_beside_a_load():
    """The distance by loads beside the contact counts once."""
    scene = contact(loads=LOADED, grid=COARSE)
    samples = vc.SampledDistance(paraboloid(COARSE.x, COARSE.y))
    compare(replace(scene, surface=samples), scene)


def compare(samples, closed):
    """Both surfaces have the same derivatives."""
    outputs = ["Fx", "peak_pressure"]
    found, expected = (
        solved(each).gradient(outputs, MOVING, edge="following") for each in (samples, closed)
    )
    for name in MOVING:
        assert np.allclose(found[name], expected[name], rtol=1e-6)


def test_samples_with_places_have_the_derivative_of_the_continuum():
    """Without slip Fx by creepage is proportional to G and the area: N^(2/3) G^(1/3)."""
    x = y = np.linspace(-1.6, 1.6, 33)
    scene = contact(
        surface=vc.SampledDistance(paraboloid(x, y), x, y),
        friction=np.inf,
        motion=vc.Steady(vx=4e-4),
        grid=vc.Grid(nx=26, ny=26, dx=0.1, dy=0.1, x0=-1.3, y0=-1.27),
    )
    sol = solved(scene)
    found = sol.gradient("Fx", MOVING)
    assert float(found.normal_force) * 0.02 / sol.Fx == pytest.approx(2 / 3, abs=0.02)
    assert float(found["bodies.G"]) / sol.Fx == pytest.approx(1 / 3, abs=0.02)


def test_solved_pressures_have_the_derivative_of_the_grid():
    """Also of a rough surface, whose largest pressure changes as a grid moves over asperities."""
    x, y = np.meshgrid(COARSE.x, COARSE.y)
    rough = paraboloid(COARSE.x, COARSE.y) + 1e-3 * np.cos(7 * x + 1) * np.cos(6 * y)
    scene = contact(surface=vc.SampledDistance(rough), grid=COARSE)
    found = solved(scene).gradient("peak_pressure", "normal_force")
    expected = difference(partial(loaded, scene), 0.02, "peak_pressure")
    assert float(found.normal_force) == pytest.approx(expected, rel=1e-5)


def periodic(nx=16, **more):
    """A wavy surface that touches in a spot of each period."""
    grid = vc.Grid(nx=nx, ny=16, dx=0.1, dy=0.1, x0=0.0, y0=0.0, periodic=True)
    x, y = np.meshgrid(grid.x, grid.y)
    waves = np.cos(2 * np.pi * x / (0.1 * nx)) * np.cos(2 * np.pi * y / 1.6)
    surface = vc.SampledDistance(1e-3 * (1 - waves))
    return contact(LIKE, vc.Steady(vx=1e-4), surface=surface, normal_force=2e-4, grid=grid, **more)


def test_the_period_of_a_surface_stays():
    """The derivative is that of the grid; a period that follows the contact is refused."""
    scene = periodic()
    sol = solved(scene)
    found = float(sol.gradient("Fx", "normal_force").normal_force)
    expected = difference(partial(loaded, scene), 2e-4, "Fx")
    assert found == pytest.approx(expected, rel=1e-5)
    with pytest.raises(SceneError, match="periodic grid") as caught:
        sol.gradient("Fx", "normal_force", edge="following")
    assert caught.value.field == "edge"


def test_errors_need_a_period_of_larger_elements():
    with pytest.raises(SceneError, match="elements twice as large"):
        solved(periodic(nx=15)).gradient("Fx", "vx", error=True)
    found = solved(periodic()).gradient("approach", "normal_force", error=True)
    assert float(found.normal_force_error) < 0.15 * float(found.normal_force)


@pytest.mark.parametrize("name", ["surface", "surface.h", "surface.x"])
def test_samples_are_named_by_the_distance(name):
    samples = vc.SampledDistance(paraboloid(COARSE.x, COARSE.y))
    with pytest.raises(SceneError, match='must be "distance": the undeformed'):
        solved(contact(surface=samples, grid=COARSE)).gradient("Fx", name)
