"""Noise of sampled surfaces: said where it rules the pressure, with a smoothing that helps, and
nowhere else.
"""

import re
from dataclasses import replace

import numpy as np
import pytest

import varcontact as vc
from tests.scenes import STEEL, make_scene

X, Y = 1e-3 * np.arange(-10, 10.1, 0.25), 1e-3 * np.arange(-8, 8.1, 0.25)
WHEEL_ON_RAIL = X**2 / (2 * 0.46) + (Y**2 / (2 * 0.3))[:, None]
ON_SAMPLES = vc.Grid(nx=81, ny=65, dx=0.25e-3, dy=0.25e-3, x0=-10.125e-3, y0=-8.125e-3)
ROUGH = np.random.default_rng(3).normal(size=WHEEL_ON_RAIL.shape)
SCENE = make_scene(vc.SampledDistance(WHEEL_ON_RAIL, X, Y), 106.7e3, None, ON_SAMPLES, None, STEEL)


def noisy(amplitude):
    """The scene with noise of a standard deviation, another at each sample."""
    return replace(SCENE, surface=vc.SampledDistance(WHEEL_ON_RAIL + amplitude * ROUGH, X, Y))


def test_two_micrometres_of_noise_rule_the_pressure_and_the_smoothing_that_is_named_helps():
    scene = noisy(2e-6)
    rough = vc.solve(scene)
    (warning,) = rough.warnings
    assert (
        "noise rules the pressure: without waves of the surface shorter than 0.001, four elements"
        in warning
    )
    assert re.search(r"in \d patch(es)? in place of \d\d; smooth the samples", warning)
    assert warning in str(rough) and "WARNING" in str(rough)
    assert rough.summary()["warnings"] == [warning]
    wavelength = float(re.search(r"smoothing = ([\d.e-]+) in the file", warning)[1])
    smooth = vc.solve(replace(scene, surface=scene.surface.smoothed(wavelength)))
    assert smooth.warnings == ()
    exact = replace(SCENE, surface=vc.Paraboloids(Rx=0.46, Ry=0.3)).hertz.peak_pressure
    assert rough.pressure.max() > 2.5 * exact
    assert smooth.pressure.max() < 1.8 * exact


@pytest.mark.parametrize("amplitude", [0.0, 2e-8])
def test_a_smooth_wheel_on_a_rail_is_not_warned_of(amplitude):
    sol = vc.solve(noisy(amplitude))
    assert sol.warnings == ()
    assert "WARNING" not in str(sol)


def test_a_rough_surface_is_not_warned_of_where_it_is_resolved():
    """Waves of 3 micrometres and 4 mm make summits: 3.2 elements a wave do not resolve them, 16
    do.
    """
    waves = 3e-6 * np.cos(2 * np.pi * X / 4e-3 + 0.3) * np.cos(2 * np.pi * Y / 4e-3 + 0.5)[:, None]
    rough = replace(SCENE, surface=vc.SampledDistance(WHEEL_ON_RAIL + waves, X, Y))
    fine = vc.solve(rough)
    assert fine.warnings == ()
    assert fine.pressure.max() > 1.2 * vc.solve(SCENE).pressure.max()
    coarse = vc.solve(replace(rough, grid=vc.Grid(nx=12, ny=12)))
    assert len(coarse.warnings) == 1


def test_where_noise_makes_the_grid_too_coarse_the_message_says_so():
    scene = replace(noisy(2e-6), grid=vc.Grid(nx=24, ny=24))
    with pytest.raises(
        vc.SceneError,
        match=r"too coarse.*if this is noise, smooth the samples: smoothing = [\d.e-]+ in the file, .*, at least",
    ):
        vc.solve(scene)


@pytest.mark.long
def test_the_advice_of_a_file_is_a_key_of_it(tmp_path):
    """What a grid that is too coarse names is the least that may help; what the solution names then
    helps.
    """
    waves = noisy(5e-6).surface
    np.save(tmp_path / "h.npy", waves.h)
    text = (
        "normal_force = 106.7e3\n[bodies]\nG = 82e9\nnu = 0.28\n[grid]\nnx = 48\nny = 48\n[surface]\n"
        f"kind = 'sampled-distance'\nh = {{file = 'h.npy'}}\nx = {X.tolist()}\ny = {Y.tolist()}\n"
    )
    path, named = tmp_path / "noisy.toml", [0.0]
    path.write_text(text)
    with pytest.raises(vc.SceneError) as refused:
        vc.solve(vc.read_scene(path)[0])
    said = str(refused.value)
    while said:
        named.append(
            float(re.search(r"smooth the samples: smoothing = ([\d.e-]+) in the file", said)[1])
        )
        path.write_text(f"{text}smoothing = {named[-1]}\n")
        scene = vc.read_scene(path)[0]
        np.testing.assert_array_equal(scene.surface.h, waves.smoothed(named[-1]).h)
        said = "".join(vc.solve(scene).warnings)
    assert len(named) == 3 and named == sorted(named)
    path.write_text(f"{text}smoothing = -1.0\n")
    with pytest.raises(vc.SceneError, match=r"surface.smoothing = -1\.0 is not allowed"):
        vc.read_scene(path)
