"""Influence numbers that lag behind: quadrature, limits of the relaxation length, printed
numbers.
"""

import numpy as np
import pytest

import varcontact as vc
from varcontact.elasticity.halfspace import HalfSpaces
from varcontact.elasticity.of_scenes import _of_several_solids, medium_of
from varcontact.elasticity.viscoelastic import Lagging, ViscoelasticMedium
from varcontact.scene.bodies import BodyPair
from varcontact.scene.grid import Grid

ELASTIC = HalfSpaces(nu=0.3, K=0.1, depth=5.0)
STRIPS, RECTANGLES = Grid(nx=7, dx=0.2, x0=0.0), Grid(nx=7, ny=3, dx=0.2, dy=0.3, x0=0.0, y0=0.0)


def integral(integrand, cuts):
    """The integral over the last axis, by the double exponential rule between cuts."""
    t = np.linspace(-3.4, 3.4, 137)
    part = 1 / (1 + np.exp(-np.pi * np.sinh(t)))
    weight = np.pi * np.cosh(t) * part * (1 - part) * (t[1] - t[0])
    widths = np.diff(cuts)[:, None]
    points = np.array(cuts[:-1])[:, None] + widths * part
    return integrand(points.ravel()) @ (widths * weight).ravel()


def by_quadrature(grid, x, y, names, length):
    """The mean of elastic numbers over what lies ahead of a point, cut at the element's edges."""

    def integrand(s):
        elastic = ELASTIC.influence(grid, x + s, np.array([[y]]), names)
        return np.array([elastic[name].ravel() for name in names]) * np.exp(-s / length) / length

    edges = [edge - x for edge in (-0.1, 0.1) if 0 < edge - x < 40 * length]
    graded = [*(length * c for c in (1, 3, 10, 20)), *(0.2 * c for c in (1, 5, 20))]
    cuts = sorted({0.0, 40 * length, *edges, *(c for c in graded if c < 40 * length)})
    return integral(integrand, cuts)


@pytest.mark.parametrize(("length", "offset"), [(0.05, 0.07), (0.3, 0.0), (4.0, 0.07)])
@pytest.mark.parametrize("grid", [STRIPS, RECTANGLES], ids=["strips", "rectangles"])
def test_means_over_what_lies_ahead(grid, length, offset):
    medium = ViscoelasticMedium(ELASTIC, (Lagging(length, 0.5, ELASTIC),))
    x, y, names = (
        (np.arange(13) - 6) * 0.2 + offset,
        np.arange(grid.rows)[:, None] * 0.3,
        ["xx", "yy", "zz", "xz"],
    )
    found, elastic = (each.influence(grid, x, y, names) for each in (medium, ELASTIC))
    lagging = np.array(
        [np.broadcast_to((found[name] - elastic[name]) / 0.5, (grid.rows, 13)) for name in names]
    )
    for i, j in ((0, 1), (0, 6), (-1, 5), (-1, 12)):
        expected = by_quadrature(grid, x[j], y[i, 0], names, length)
        assert lagging[:, i, j] == pytest.approx(expected, abs=3e-9)


@pytest.mark.parametrize("grid", [STRIPS, RECTANGLES], ids=["strips", "rectangles"])
def test_short_and_long_relaxation_lengths(grid):
    """All of it follows at once, or nothing does; but for constants in line contact."""
    x, y = (np.arange(13) - 6) * 0.2, np.arange(grid.rows)[:, None] * 0.3
    elastic = ELASTIC.influence(grid, x, y, ["zz", "xz"])
    for length, part, off in ((1e-5, 2.0, 1e-3), (1e6, 1.0, 1e-4)):
        found = ViscoelasticMedium(ELASTIC, (Lagging(length, 1.0, ELASTIC),)).influence(
            grid, x, y, ["zz", "xz"]
        )
        for name in found:
            size, free = np.abs(elastic[name]).max(), length > 1 and grid.line
            constant = np.mean(found[name] - elastic[name]) if free else 0.0
            expected = np.broadcast_to(part * elastic[name], found[name].shape)
            np.testing.assert_allclose(found[name] - constant, expected, atol=off * size)


@pytest.mark.parametrize("length", [1e4, 1e8])
def test_nothing_cancels_in_strips_with_a_long_memory(length):
    """In units of the relaxation length the elastic number is smooth but near the strip, where
    panels are graded.
    """
    medium = ViscoelasticMedium(ELASTIC, (Lagging(length, 1.0, ELASTIC),))

    names = ["zz", "xz"]

    def elastic(x):
        found = ELASTIC.influence(STRIPS, x, np.zeros((1, 1)), names)
        return np.array([found[name].ravel() for name in names])

    for x in (-8.0, -0.4, 0.0, 0.2, 8.0):
        edges = [at / length for at in (-x - 0.1, -x, -x + 0.1) if at > 0]
        cuts = sorted({0.0, 1e-4, 1e-2, 0.1, 1.0, 3.0, 10.0, 45.0, *edges})
        lagging = integral(lambda s, x=x: elastic(x + length * s) * np.exp(-s), cuts)
        found = medium.influence(STRIPS, np.array([x]), np.zeros((1, 1)), names)
        expected = elastic(np.array([x]))[:, 0] + lagging
        assert [found[name].item() for name in names] == pytest.approx(expected, abs=1e-13)


SIDES = ["xx", "yy", "zz", "xz", "zx"]


def test_layers_each_of_its_own_solid():
    """Numbers of an independent program, which counts displacements from elsewhere: by one constant
    for each.
    """
    coated = vc.Layered([vc.Layer(0.5, 1.0, 0.3, [(1.0, 1.0)])], base=(5.0, 0.25))
    pair = BodyPair(coated, vc.Bodies(3.0, 0.3))
    x = np.array([-0.2, 0.0, 1.0])
    numbers = medium_of(pair, 1.0, 5.0, speed=1.0).influence(STRIPS, x, np.zeros((1, 1)), SIDES)
    expected = {
        "xx": [0.185883001089, 0.270071840100, 0.059438082688],
        "yy": [0.239235656225, 0.360553342286, 0.066363079817],
        "zz": [0.123720385559, 0.209437786757, 0.040667875193],
        "xz": [0.005657412826, -0.002074831693, 0.002927210132],
    }
    for name, values in expected.items():
        off = numbers[name][0] / pair.combined_G - values
        np.testing.assert_allclose(off, 0.0 if name == "xz" else off[0], rtol=0, atol=2e-12)
    np.testing.assert_array_equal(numbers["zx"], -numbers["xz"])


@pytest.mark.parametrize("base", [(1.2, 0.3), "rigid", "smooth"])
def test_complex_moduli_are_means_over_what_lies_ahead(base):
    """Layers of one solid: by wave numbers, and by the means of elastic numbers along a row."""
    layers = [vc.Layer(0.05, 1.0, 0.3), vc.Layer(0.2, 3.0, 0.4)]
    pair = BodyPair(vc.Layered(layers, base, [(1.0, 0.1), (0.5, 1.0)]), "rigid")
    x = np.linspace(-2, 2, 21)
    found, means = (
        medium.influence(STRIPS, x, np.zeros((1, 1)), SIDES)
        for medium in (
            _of_several_solids(pair, 1.0, 5.0, 2.0),
            medium_of(pair, 1.0, 5.0, speed=2.0),
        )
    )
    for name in SIDES:
        off = found[name] - means[name]
        shifted = base == "smooth" and name in ("xx", "yy")  # no friction holds the body
        np.testing.assert_allclose(off, off[0, 0] if shifted else 0.0, rtol=0, atol=3e-8)


def test_the_coupling_is_no_smaller_at_any_frequency():
    """The lagging part may have the other sign: the sizes are added."""
    lagging = Lagging(0.3, 0.5, HalfSpaces(nu=0.3, K=-0.2, depth=5.0))
    assert ViscoelasticMedium(ELASTIC, (lagging,)).K == pytest.approx(0.1 + 0.5 * 0.2)
