"""What every medium promises, whatever its bodies are: a new one joins the list."""

import numpy as np
import pytest

import varcontact as vc
from varcontact.elasticity.anisotropic import rotated_stiffness, transversely_isotropic_stiffness
from varcontact.elasticity.conformal import Conformal, Inclination
from varcontact.elasticity.halfspace import HalfSpaces
from varcontact.elasticity.of_scenes import medium_of
from varcontact.elasticity.shear_layer import ShearLayer
from varcontact.scene.bodies import as_bodies
from varcontact.scene.grid import Grid
from varcontact.transports import HERE, SteadyRolling

LATTICE = Grid(nx=6, ny=5, dx=0.1, dy=0.08, x0=-0.3, y0=-0.2)
EVERY = np.arange(LATTICE.size)


def of(*bodies, speed=None):
    given = bodies[0] if len(bodies) == 1 else bodies
    return medium_of(as_bodies(given), 1.0, 4.0, speed)


COATED = vc.Layered([vc.Layer(h=0.1, G=3.0, nu=0.3)], base=(1.0, 0.3))
RUBBER = vc.Viscoelastic(1.0, 0.4, [(2.0, 0.3)])
TILTED = rotated_stiffness(
    transversely_isotropic_stiffness(165.0, 31.1, 50.0, 61.8, 39.6),
    [[0.8, 0.0, 0.6], [-0.36, 0.8, 0.48], [-0.48, -0.6, 0.64]],
)


def layer(kx, ky):
    """Pressures and tractions on a layer that gives way by tanh(k)/k."""
    k = np.hypot(kx, ky)
    return (np.tanh(k) / k)[:, None, None] * np.diag([1.0, 1.0, 0.7])


MEDIA = {
    "half-spaces": HalfSpaces(0.3),
    "unlike half-spaces": HalfSpaces(0.3, K=0.2),
    "layered": of(COATED),
    "layered on a half-space": of(COATED, vc.Bodies(1.0, 0.3)),
    "graded": of(vc.Graded(G=1.0, nu=0.3, depth=0.2, G_deep=3.0)),
    "graded on a half-space": of(
        vc.Graded(G=1.0, nu=0.3, depth=0.2, exponent=1.0), vc.Bodies(1.0, 0.3)
    ),
    "winkler bedding": of(vc.Winkler(h=0.1, E=3.0, G=1.0)),
    "winkler bedding on a rigid body": of(vc.Winkler(h=0.1, E=3.0, G=2.0), "rigid"),
    "viscoelastic": of(RUBBER, speed=1.0),
    "viscoelastic on a half-space": of(RUBBER, vc.Bodies(1.0, 0.3), speed=1.0),
    "crystals": of(vc.Elasticity.of_stiffness(TILTED, "rigid")),
    "a symbol": of(vc.Elasticity(symbol=layer)),
    "curved": Conformal(HalfSpaces(0.3), Inclination((-0.2, 0.2), (-0.4, 0.4))),
    "curved unlike": Conformal(
        HalfSpaces(0.3, K=0.2), Inclination((-0.2, 0.0, 0.2), (-0.4, 0.1, 0.3))
    ),
    "curved both ways": Conformal(
        HalfSpaces(0.3, K=0.2),
        Inclination((-0.2, 0.2), (-0.4, 0.4)),
        Inclination((-0.2, 0.0, 0.2), (-0.4, 0.1, 0.3)),
    ),
    "with a layer that shears": ShearLayer(HalfSpaces(0.3, K=0.2), 0.7),
    "curved with a layer": Conformal(
        ShearLayer(HalfSpaces(0.3), 0.7), Inclination((-0.2, 0.2), (-0.4, 0.4))
    ),
}
every_medium = pytest.mark.parametrize("medium", MEDIA.values(), ids=MEDIA)


def dense(medium, rows="xyz", columns="xyz", stencil=HERE):
    return medium.operator(LATTICE, rows, columns, stencil).dense(EVERY)


@every_medium
def test_elastic_bodies_are_reciprocal_and_give_way(medium):
    """By Betti the matrix of all displacements by all tractions is symmetric; stored energy is
    positive.
    """
    matrix = dense(medium)
    if medium.reciprocal:
        np.testing.assert_allclose(matrix, matrix.T, atol=1e-10 * np.abs(matrix).max())
    assert np.linalg.eigvalsh(matrix + matrix.T).min() > 0


@every_medium
def test_pressures_shift_the_surfaces_only_where_it_says_so(medium):
    coupling = np.abs(dense(medium, "xy", "z")).max()
    if medium.K == 0:
        assert coupling == 0
    else:
        assert coupling > 1e-4 * np.abs(dense(medium, "xy", "xy")).max()


@every_medium
def test_numbers_are_even_or_odd_in_x_only_where_it_says_so(medium):
    table = medium.operator(LATTICE, "xyz", "xyz").table
    signs = np.where(np.arange(3) == 0, -1.0, 1.0)
    image = table[..., ::-1] * (signs[:, None] * signs)[..., None, None]
    assert np.allclose(table, image, atol=1e-12 * np.abs(table).max()) == medium.even


@every_medium
def test_a_stencil_is_the_sum_of_its_points(medium):
    stencil = SteadyRolling(0.13, 0.1, "second-order").stencil
    parts = sum(weight * dense(medium, "xy", "xyz", ((ahead, 1.0),)) for ahead, weight in stencil)
    np.testing.assert_allclose(
        dense(medium, "xy", "xyz", stencil), parts, atol=1e-13 * np.abs(dense(medium)).max()
    )


@every_medium
def test_displacements_further_along_are_those_of_the_elements_there(medium):
    """Of a step of whole elements, the numbers of the next column."""
    here, ahead = (medium.operator(LATTICE, "xyz", "xyz", ((at, 1.0),)).table for at in (0.0, 0.1))
    np.testing.assert_allclose(ahead[..., :-1], here[..., 1:], atol=1e-10 * np.abs(here).max())


@every_medium
def test_what_relaxes_is_stiffest_at_once(medium):
    at_once = np.diag(dense(medium.at_once, "z", "z"))
    at_end = np.diag(dense(medium.at_end(1.0), "z", "z"))
    assert np.all(at_once <= at_end * (1 + 1e-12))
    assert np.allclose(at_once, at_end) == (not getattr(medium, "lagging", ()))


@every_medium
def test_equal_media_are_equal_and_serve_as_keys(medium):
    assert medium == medium and hash(medium) == hash(medium)
    assert sum(medium == other for other in MEDIA.values()) == 1
