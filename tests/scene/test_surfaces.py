"""Distances between samples: accurate where they are smooth, and without phantoms beside cliffs."""

import pickle

import numpy as np
import pytest

import varcontact as vc
from tests.scenes import refusals, refused
from varcontact.scene.interpolation import smoothed

X = np.linspace(-1.0, 1.0, 41)
FINE = vc.Grid(nx=160, ny=15, dx=0.0125, dy=0.05, x0=-1.0, y0=-0.375)


def step(x, y):
    """A flat at zero that ends in a cliff of 10 at x = 0.12."""
    return np.where(x > 0.12, 10.0, 0.0) + 0.0 * y


def bowl_with_an_edge(x, y):
    return np.where(x > 0.12, 10.0, (x**2 + y**2) / 2)


def ditch(x, y):
    """Cliffs in both directions, with a corner."""
    return np.where((np.abs(x) < 0.33) & (np.abs(y) < 0.22), 0.0, 5.0)


@pytest.mark.parametrize("turned", [False, True])
@pytest.mark.parametrize("shape", [step, bowl_with_an_edge, ditch])
def test_no_point_lies_below_the_samples_around_it(shape, turned):
    """Beside a cliff of 10 a spline swings 1 below: that would be contact where there is none."""
    h = shape(X[None, :], X[:, None])
    grid = FINE
    if turned:
        h = h.T
        grid = vc.Grid(nx=FINE.ny, ny=FINE.nx, dx=FINE.dy, dy=FINE.dx, x0=FINE.y0, y0=FINE.x0)
    distance = vc.SampledDistance(h, X, X).distance(grid)
    cell = X[1] - X[0]
    assert distance.min() >= h.min() - cell**2 / 2, (
        "no lower than the samples, but for a paraboloid's curvature"
    )
    assert distance.max() <= h.max() + cell**2 / 2


def test_beside_a_cliff_the_surface_stays_what_it_is():
    """The bowl up to its edge, to the accuracy of one cell's curvature."""
    distance = vc.SampledDistance(bowl_with_an_edge(X[None, :], X[:, None]), X, X).distance(FINE)
    known = FINE.x < 0.09
    exact = (FINE.x[None, known] ** 2 + FINE.y[:, None] ** 2) / 2
    assert np.abs(distance[:, known] - exact).max() < 5e-4


def test_smooth_samples_keep_the_splines_accuracy():
    """Fourth order: halving the samples' spacing divides the largest error by more than ten."""

    def exact(x, y):
        return (
            x[None, :] ** 2 / 2
            + y[:, None] ** 2
            + 0.1 * np.sin(3 * x)[None, :] * np.cos(2 * y)[:, None]
        )

    errors = []
    for n in (21, 41, 81):
        x = np.linspace(-1.0, 1.0, n)
        distance = vc.SampledDistance(exact(x, x), x, x).distance(FINE)
        inner = np.abs(FINE.x) < 0.8
        errors.append(np.abs(distance - exact(FINE.x, FINE.y))[:, inner].max())
    assert errors[1] < 1e-5
    assert np.all(np.divide(errors[:-1], errors[1:]) > 10)


def test_far_from_a_cliff_the_spline_is_kept():
    """A cliff at one end does not cost the other end its accuracy."""
    x = np.linspace(-1.0, 1.0, 101)
    h = np.where(x > 0.8, 10.0, 0.1 * np.sin(3 * x))[None, :] + 0.0 * x[:, None]
    grid = vc.Grid(nx=101, ny=3, dx=0.01, dy=0.1, x0=-0.9, y0=-0.15)
    near = grid.x < 0.4
    error = vc.SampledDistance(h, x, x).distance(grid) - 0.1 * np.sin(3 * grid.x)
    assert np.abs(error[:, near]).max() < 1e-6


@pytest.mark.parametrize("pair", [1.0, None, (1.0,), (1.0, 2.0, 3.0), "ab"])
def test_radii_of_the_bodies_come_in_pairs(pair):
    refused(
        lambda: vc.Paraboloids.from_bodies(Rx=pair, Ry=(1.0, 1.0)),
        "surface.Rx",
        match="a pair of radii",
    )


def test_surfaces_go_to_other_processes():
    surface = vc.SampledDistance(bowl_with_an_edge(X, X[:, None]), X, X)
    first = surface.distance(FINE)
    np.testing.assert_array_equal(pickle.loads(pickle.dumps(surface)).distance(FINE), first)


def test_beyond_its_samples_a_surface_goes_on_straight_but_never_down():
    """Parts of elements at the rim may lie there: level, a bowl would be touched where it rises."""
    near = np.linspace(-1.0, 1.0, 41)
    grid = vc.Grid(nx=21, ny=21, dx=0.104, dy=0.104, x0=-1.092, y0=-1.092)
    x, y = np.meshgrid(grid.x, grid.y)
    bowl = vc.SampledDistance(np.add.outer(near**2, near**2), near, near).distance(
        grid, beyond=0.06
    )
    exact, outside = x**2 + y**2, np.maximum(np.abs(x), np.abs(y)) > 1.0
    assert np.abs(bowl - exact)[outside].max() < 2 * 2 * 0.04**2 + 1e-9
    assert np.abs(bowl - exact)[~outside].max() < 1e-9
    hill = vc.SampledDistance(np.add.outer(-(near**2), -(near**2)), near, near).distance(
        grid, beyond=0.06
    )
    assert hill.min() == pytest.approx(-2.0)
    tilted = vc.SampledDistance(np.tile(near, (41, 1)), near, near).distance(grid, beyond=0.06)
    assert tilted[10, [0, -1]] == pytest.approx([-1.0, grid.x[-1]])


# ----------------------------------------------------------------------------- Smoothing of samples


UNEVEN = np.cumsum(np.random.default_rng(2).uniform(0.5, 1.5, 90))


@pytest.mark.parametrize("points", [np.linspace(-1, 1, 60), 1e-6 * np.arange(40.0), UNEVEN])
@pytest.mark.parametrize("part", [0.05, 0.3, 2.0])
def test_parabolas_stay_as_they_are_up_to_the_ends(points, part):
    length = np.ptp(points)
    x = (points - points[0]) / length
    parabola = 2 - x + 7 * x**2
    assert smoothed(parabola, points, part * length) == pytest.approx(parabola, abs=1e-9)


@pytest.mark.parametrize("ratio", [0.5, 1.0, 2.0])
def test_waves_keep_the_stated_part(ratio):
    """In the middle of many waves, away from the ends."""
    x = np.arange(600.0)
    wavelength = 24.0
    wave = np.sin(2 * np.pi * x / (ratio * wavelength))
    found = smoothed(wave, x, wavelength)
    assert found[250:350] == pytest.approx(wave[250:350] / (1 + ratio**-6), abs=0.01)


def test_uneven_samples_are_weighed_by_what_they_stand_for():
    """Samples six times as dense in the middle: the wave keeps half of its amplitude all the
    same.
    """
    t = np.linspace(-1, 1, 500)
    x = 150 + 100 * (0.3 * t + 0.7 * t**3)
    wave = np.sin(2 * np.pi * x / 20)
    found = smoothed(wave, x, 20.0)
    assert np.abs(found - wave / 2)[np.abs(x - 150) < 60].max() < 0.02


def test_a_surface_is_smoothed_along_both_axes_alike():
    x, y = np.linspace(-1, 1, 50), np.linspace(-2, 2, 70)
    h = np.random.default_rng(3).normal(size=(70, 50))
    surface = vc.SampledDistance(h, x, y).smoothed(0.4)
    turned = vc.SampledDistance(h.T, y, x).smoothed(0.4)
    assert surface.h == pytest.approx(turned.h.T, abs=1e-9)
    assert surface.x == pytest.approx(x) and surface.y == pytest.approx(y)


def test_nothing_depends_on_the_unit_of_length():
    x = np.linspace(-1, 1, 50)
    h = x**2 + 0.01 * np.random.default_rng(4).normal(size=50)
    small = vc.SampledDistance(1e-6 * h, 1e-6 * x).smoothed(0.3e-6)
    assert small.h * 1e6 == pytest.approx(vc.SampledDistance(h, x).smoothed(0.3).h, abs=1e-9)


def test_a_line_keeps_its_reference_depth_and_few_samples_stay():
    line = vc.SampledDistance(
        np.array([1.0, 0.0, 1.0]), np.array([0.0, 1.0, 2.0]), reference_depth=9.0
    )
    assert line.smoothed(5.0).reference_depth == 9.0
    assert line.smoothed(5.0).h == pytest.approx(line.h)


SAMPLES = vc.SampledDistance(np.zeros((5, 5)), np.arange(5), np.arange(5))
test_wavelengths_that_are_refused = refusals(
    (lambda: SAMPLES.smoothed(0.0), "wavelength"),
    (lambda: SAMPLES.smoothed(-1.0), "wavelength"),
    (lambda: SAMPLES.smoothed(float("nan")), "wavelength"),
    (lambda: vc.SampledDistance(np.zeros((5, 5))).smoothed(1.0), r"surface\.x"),
)


def test_fields_of_samples_in_line_contact():
    """Also rigid slip is given at the samples' own places."""
    x = np.linspace(-2.0, 2.0, 41)
    grid = vc.Grid(nx=5, dx=0.3, x0=-0.75)
    found = vc.SampledDistance(x**2, x).sampled(np.array([[x**3], [x]]), grid)
    np.testing.assert_allclose(found, [[grid.x**3], [grid.x]], rtol=1e-12, atol=1e-14)
