"""Patches of very different size: grids are as fine as the smallest that carries needs, or the
error bar knows.
"""

from dataclasses import replace

import numpy as np
import pytest

import varcontact as vc
from varcontact.results.quantities_of_interest import error, units, values
from varcontact.solving import adaptive

X = np.linspace(-0.45, 0.45, 601)


def balls(radius, above=0.0, turned=0.0):
    """A ball of radius 2, and a small one 0.4 beside it, `above` its summit."""
    at = 0.2 * np.cos(turned), 0.2 * np.sin(turned)
    large = ((X[None, :] + at[0]) ** 2 + (X[:, None] + at[1]) ** 2) / 4
    small = ((X[None, :] - at[0]) ** 2 + (X[:, None] - at[1]) ** 2) / (2 * radius) + above
    return vc.SampledDistance(np.minimum(large, small), x=X, y=X)


def normal(radius, above=0.0, turned=0.0):
    return vc.Scene(
        bodies=vc.Bodies(G=1.0, nu=0.28), surface=balls(radius, above, turned), normal_force=5e-3
    )


@pytest.mark.long
@pytest.mark.parametrize(("radius", "above"), [(0.1, 3e-3), (0.04, 0.0)])
def test_the_peak_of_a_small_patch(radius, above):
    scene = normal(radius, above)
    exact = values(vc.solve(replace(scene, grid=vc.Grid(150, 100)), certify="none"))
    sol = vc.solve(scene, accuracy=0.05)
    for name, value in exact.items():
        assert abs(sol.error_estimate.values[name] / value - 1) <= 0.05 + 0.005
    assert sol.error_estimate.largest <= 0.05
    right = sol.pressure * (sol.grid.x > 0)
    assert right.max() == sol.pressure.max()
    assert np.count_nonzero((right > 0).any(axis=1)) >= 8


@pytest.mark.long
def test_forces_of_a_small_patch():
    scene = replace(normal(0.1, 1e-3), friction=0.3, motion=vc.Steady(vx=2e-2, vy=3e-3, spin=0.05))
    sol = vc.solve(scene, accuracy=0.02)
    fine = vc.solve(replace(scene, grid=vc.Grid(120, 80)).second_order(), certify="none")
    assert error(values(sol), values(fine), units(fine)) <= 0.02 + 0.002


@pytest.mark.long
def test_where_no_grid_fits_the_error_bar_knows(monkeypatch):
    """With few elements to be had, the error of a peak that they miss is stated."""
    monkeypatch.setattr(adaptive, "DEFAULT_ELEMENTS_MAX", 1000)
    scene = normal(0.02, 3e-3)
    estimate = vc.solve(scene).error_estimate
    fine = vc.solve(replace(scene, grid=vc.Grid(180, 120)), certify="none")
    missed = abs(estimate.values["peak_pressure"] / fine.max_pressure - 1)
    assert 0.05 < missed <= estimate.errors["peak_pressure"]
    assert "narrowest patch" in estimate.how


@pytest.mark.parametrize("turned", [0.0, 0.6, np.pi / 2])
def test_patches_are_as_wide_as_they_are_wherever_they_lie(turned):
    """Four standard deviations of an ellipse's elements are its width, turned or not."""
    squares = vc.Grid(nx=150, ny=150, dx=0.005, dy=0.005, x0=-0.375, y0=-0.375)
    sol = vc.solve(replace(normal(0.3, 0.0, turned), grid=squares), certify="none")
    patches = adaptive._patches(sol)
    assert len(patches) == 2 and sum(each.share for each in patches) == pytest.approx(1)
    assert min(patches, key=lambda each: each.across).peak
    area = sum(np.pi / 4 * each.across**2 for each in patches)  # nearly round
    assert area == pytest.approx(sol.elements["contact"], rel=0.05)


@pytest.mark.long
def test_a_patch_too_narrow_adds_its_share_by_its_elements():
    """0.3 of the load on a patch two elements wide: 0.15 on top of what the same grids have without
    it.
    """
    scene, levels = normal(0.1), []
    for n in (6, 9, 14):
        sol = vc.solve(replace(scene, grid=vc.Grid(nx=n, ny=n)))
        levels.append(adaptive.GridLevel(n, sol, values(sol), 0.0, ()))
    narrow = replace(levels[0], patches=(adaptive.ContactPart(2.0, 0.3, False),))
    target = adaptive.Target(accuracy=0.1)
    with_patch, without = (
        adaptive.estimated([each, *levels[1:]], target).errors for each in (narrow, levels[0])
    )
    assert with_patch == pytest.approx(
        {name: value + 0.15 for name, value in without.items()}, rel=1e-12
    )
