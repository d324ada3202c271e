"""Smoothing of samples: parabolas stay, waves keep the stated part of their amplitude."""

import numpy as np
import pytest

import varcontact as vc
from varcontact.scene.interpolation import smoothed

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
    """Samples six times as dense in the middle: the wave keeps half of its amplitude all the same."""
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
    line = vc.SampledDistance(np.array([1.0, 0.0, 1.0]), np.array([0.0, 1.0, 2.0]), reference_depth=9.0)
    assert line.smoothed(5.0).reference_depth == 9.0
    assert line.smoothed(5.0).h == pytest.approx(line.h)


@pytest.mark.parametrize("wavelength", [0.0, -1.0, float("nan")])
def test_a_wavelength_is_positive(wavelength):
    surface = vc.SampledDistance(np.zeros((5, 5)), np.arange(5), np.arange(5))
    with pytest.raises(vc.SceneError, match="wavelength"):
        surface.smoothed(wavelength)


def test_samples_without_coordinates_have_no_wavelength():
    with pytest.raises(vc.SceneError, match=r"surface\.x"):
        vc.SampledDistance(np.zeros((5, 5))).smoothed(1.0)
