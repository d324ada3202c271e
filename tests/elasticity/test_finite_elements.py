"""Compliances by finite elements: Hertz on a flat block, and the gauge corner of a rail."""

import importlib.util
from pathlib import Path

import numpy as np
import pytest
import skfem

import varcontact as vc


@pytest.fixture(scope="module")
def example():
    """The example `gauge_corner` as a module."""
    path = Path(__file__).parents[2] / "examples" / "gauge_corner.py"
    spec = importlib.util.spec_from_file_location("gauge_corner", path)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.fixture(scope="module")
def block(example):
    """The loaded facets of a block of 140 x 70, 0.2 wide each, clamped at its bottom."""
    size, reach, side = 70.0, 3.0, 0.2
    middle = np.arange(reach, -reach - side / 2, -side)
    right = example.graded((reach, 0.0), (size, 0.0), side)[:0:-1]
    left = example.graded((-reach, 0.0), (-size, 0.0), side)[1:]
    top = np.concatenate([right[:, 0], middle, left[:, 0]])
    far = np.array([[-size, 0], [-size, -size], [0, -size], [size, -size], [size, 0]])
    outline = np.concatenate([np.stack([top, 0 * top], axis=1), far])
    return example.loaded_facets(
        example.star_mesh(outline, (0.0, -size / 2), side),
        skfem.ElementTriP2(),
        lambda p: p[1] < 1e-6 - size,
        lambda p: (p[1] > -1e-9) & (np.abs(p[0]) < reach),
    )


def test_a_cylinder_on_a_block_is_hertz(example, block):
    """Rigid on elastic, half width 2: peak pressure and area to half a per cent."""
    radius, half_width = 100.0, 2.0
    modulus = example.E / (1 - example.NU**2)
    force = np.pi * half_width**2 * modulus / (4 * radius)
    order = np.argsort(block.midpoints[:, 0])
    x = block.midpoints[order, 0]
    grid = vc.Grid(nx=x.size, dx=0.2, x0=-3.0)
    scene = vc.Scene(
        bodies=vc.Elasticity.from_compliance(block.midpoints[:, 0], block.compliance),
        surface=vc.SampledDistance(x**2 / (2 * radius)),
        normal_force=force,
        grid=grid,
    )
    found = vc.solve(scene)
    hertz = 2 * force / (np.pi * half_width)
    exact = hertz * np.sqrt(np.maximum(1 - (x / half_width) ** 2, 0))
    inside = np.abs(x) < 0.8 * half_width
    np.testing.assert_allclose(found.pressure[0, inside], exact[inside], atol=5e-3 * hertz)
    assert np.count_nonzero(found.pressure) * 0.2 == pytest.approx(2 * half_width, abs=0.2)
    assert found.certificate.normal_relative_gap < 1e-9


def test_compliances_of_finite_elements_are_reciprocal(block):
    np.testing.assert_allclose(block.sizes, 0.2, rtol=1e-9)
    work = block.sizes[:, None] * block.compliance
    assert np.linalg.eigvalsh(work).min() > 0


def test_half_spaces_at_the_gauge_corner(example):
    """Plane half-spaces lack 1.9 % of the peak pressure at half width 4, conformal ones have .5 %
    too much; published nowhere, and equal by two meshes of different kinds to .1 %.
    """
    corner = example.corner(4.0, step=0.4)
    plane, _ = corner.errors("plane")
    conformal, _ = corner.errors("conformal")
    assert plane == pytest.approx(-1.9, abs=0.15)
    assert conformal == pytest.approx(0.5, abs=0.15)
