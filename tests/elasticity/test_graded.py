"""Graded half-spaces: closed forms of their compliance, limits, and what is refused."""

import numpy as np
import pytest
from scipy.special import hyp2f1, k0e, k1e

import varcontact as vc
from varcontact.elasticity.layered import half_space

WAVES = np.geomspace(1e-3, 1e3, 61)


def scene(body, radius=1.0, force=1e-2, **more):
    given = {
        "surface": vc.Paraboloids(radius, radius),
        "normal_force": force,
        "grid": vc.Grid(nx=12, ny=12),
    }
    return vc.Scene(bodies=body, **given | more)


@pytest.mark.parametrize(
    ("exponent", "exact"),
    [(1, k0e(2 * WAVES) / k1e(2 * WAVES)), (2, 2 * WAVES / (2 * WAVES + 1))],
)
def test_waves_across_have_closed_forms(exponent, exact):
    """``(G u')' = k^2 G u`` with G = (1 + z/2)^n: u is ``K0(k (z + 2))``, or ``exp(-k z)/(1 +
    z/2)``.
    """
    body = vc.Graded(G=3.0, nu=0.3, depth=2.0, exponent=exponent)
    np.testing.assert_allclose(body.stack(1.0, 1.0).compliance(WAVES)[3], exact / 3.0, rtol=1e-4)


@pytest.mark.parametrize("deep", [4.0, 0.25])
def test_waves_across_an_exponential_change_are_hypergeometric(deep):
    """With x = exp(-z), G = deep (1 + c x): ``u = x^k F(a, b; 2 k + 1; -c x)``, a + b = 2 k + 1,
    a b = k.
    """
    k = WAVES[WAVES < 30]
    c = 1 / deep - 1
    root = np.sqrt((2 * k + 1) ** 2 - 4 * k)
    a, b = (2 * k + 1 + root) / 2, (2 * k + 1 - root) / 2
    slope = k / (2 * k + 1) * hyp2f1(a + 1, b + 1, 2 * k + 2, -c) / hyp2f1(a, b, 2 * k + 1, -c)
    body = vc.Graded(G=1.0, nu=0.3, depth=1.0, G_deep=deep)
    found = body.stack(1.0, 1.0).compliance(k)[3]
    np.testing.assert_allclose(found, k / (k - c * slope), rtol=2e-4)


@pytest.mark.long
def test_an_exponential_change_is_that_of_many_thin_layers():
    body = vc.Graded(G=1.0, nu=0.3, depth=1.0, G_deep=4.0)
    many = body._sliced(3000, 1.0, 1.0).compliance(WAVES)
    np.testing.assert_allclose(body.stack(1.0, 1.0).compliance(WAVES), many, rtol=2e-4)


@pytest.mark.long
@pytest.mark.parametrize("change", [{"exponent": 0.0}, {"G_deep": 2.0}])
def test_a_constant_modulus_is_a_half_space(change):
    body = vc.Graded(G=2.0, nu=0.3, depth=0.7, **change)
    np.testing.assert_allclose(
        body.stack(1.0, 1.0).compliance(WAVES), half_space(2.0, 0.3, 0 * WAVES), rtol=1e-12
    )
    grid = vc.Grid(nx=14, ny=14, dx=0.02, dy=0.02, x0=-0.14, y0=-0.14)
    own, plain = (
        vc.solve(scene(each, grid=grid), normal="norm") for each in (body, vc.Bodies(2.0, 0.3))
    )
    np.testing.assert_allclose(own.pressure, plain.pressure, atol=1e-9 * plain.pressure.max())


def test_short_waves_feel_the_surface_and_long_ones_what_is_below():
    body = vc.Graded(G=1.0, nu=0.3, depth=1.0, G_deep=4.0)
    found = body.stack(1.0, 1.0).compliance(np.array([1e-9, 1e9]))
    np.testing.assert_allclose(found[:, 0], half_space(4.0, 0.3), rtol=1e-3)
    np.testing.assert_allclose(found[:, 1], half_space(1.0, 0.3), rtol=1e-6)


@pytest.mark.long
def test_a_contact_is_as_stiff_as_the_surface_then_as_what_is_below():
    """Approach under a force: between those of both moduli, near the first for a small contact."""
    body = vc.Graded(G=1.0, nu=0.3, depth=0.2, G_deep=3.0)
    small, large = ({"radius": r, "force": 1e-3 * r**2} for r in (0.05, 20.0))
    for case, modulus in ((small, 1.0), (large, 3.0)):
        of_surface, of_depth = (
            vc.solve(scene(vc.Bodies(G, 0.3), **case)).approach for G in (1.0, 3.0)
        )
        own = vc.solve(scene(body, **case)).approach
        assert of_depth < own < of_surface
        near = of_surface if modulus == 1.0 else of_depth
        assert own == pytest.approx(near, rel=0.1)


@pytest.mark.long
def test_units_do_not_matter():
    own = vc.solve(scene(vc.Graded(G=1.0, nu=0.3, depth=0.2, exponent=0.5)))
    other = vc.solve(
        scene(
            vc.Graded(G=82e3, nu=0.3, depth=200.0, exponent=0.5),
            radius=1e3,
            force=1e-2 * 82e3 * 1e6,
        )
    )
    np.testing.assert_allclose(other.pressure / 82e3, own.pressure, atol=1e-8 * own.pressure.max())


@pytest.mark.long
def test_it_rolls_and_files_keep_it(tmp_path):
    rolling = {"friction": 0.3, "motion": vc.Steady(vx=2e-3)}
    pair = (vc.Graded(G=1.0, nu=0.3, depth=0.2, G_deep=3.0), vc.Bodies(1.0, 0.3))
    made = scene(pair, **rolling)
    made.save(tmp_path / "graded.toml")
    read, _ = vc.read_scene(tmp_path / "graded.toml")
    assert read.bodies == made.bodies
    found = vc.solve(made)
    found.save(tmp_path / "graded.nc")
    assert vc.load(tmp_path / "graded.nc").note == ""
    assert found.converged and found.certificate.residual < 1e-8


@pytest.mark.parametrize(
    ("entries", "field"),
    [
        ({}, "bodies.G_deep, bodies.exponent"),
        ({"G_deep": 2.0, "exponent": 1.0}, "bodies.G_deep, bodies.exponent"),
        ({"exponent": -0.1}, "bodies.exponent"),
        ({"exponent": 2.5}, "bodies.exponent"),
        ({"G_deep": 0.0}, "bodies.G_deep"),
        ({"G_deep": 2.0, "depth": 0.0}, "bodies.depth"),
        ({"G_deep": 2.0, "nu": 0.6}, "bodies.nu"),
    ],
)
def test_what_is_no_graded_body_is_refused(entries, field):
    with pytest.raises(vc.SceneError) as error:
        vc.Graded(**{"G": 1.0, "nu": 0.3, "depth": 1.0} | entries)
    assert error.value.field == field
