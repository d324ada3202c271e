"""What every interface promises: potentials on the grid, fields by name, and who owns what
particles carry.
"""

import dataclasses

import numpy as np
import pytest

import varcontact as vc
from varcontact.interfaces.coulomb import FRICTION, BoundByPressure, Coulomb, FrictionLaw
from varcontact.interfaces.interface import Response, Several, Surroundings
from varcontact.interfaces.third_body import DISPLACEMENT, YIELD_STRESS, YieldingLayer
from varcontact.scene.units import Scales
from varcontact.transports import SteadyRolling, Step

SHAPE = (4, 7)
SCALES = Scales(length=2.0, pressure=3.0, modulus=5.0, line=False)
LAW = vc.LinearFalling(static=0.4, kinetic=0.2, half_velocity=0.01)
PLACES = np.meshgrid(np.linspace(-1, 1, SHAPE[1]), np.linspace(-1, 1, SHAPE[0]))
INTERFACES = {
    "a coefficient": Coulomb(0.3),
    "coefficients": Coulomb(np.linspace(0.1, 0.4, 28).reshape(SHAPE)),
    "no slip": Coulomb(np.inf),
    "a law": FrictionLaw(LAW),
    "a strength": BoundByPressure(vc.ShearStrength(0.3, 0.2), SCALES, *PLACES),
    "a plastic layer": YieldingLayer(0.2, 0.0),
    "a hardening layer": YieldingLayer(0.2, 0.5),
    "a softening layer": YieldingLayer(0.2, -0.5),
    "friction and a layer": Several((Coulomb(0.3), YieldingLayer(0.2, 0.5))),
    "a law and a layer": Several((FrictionLaw(LAW), YieldingLayer(0.2, 0.0))),
}
TRANSPORTS = {
    "steady": SteadyRolling(0.1, 0.1),
    "step": Step(0.13, 0.1),
    "in place": Step(0.0, 0.1),
}
every_interface = pytest.mark.parametrize("interface", INTERFACES.values(), ids=INTERFACES)
every_transport = pytest.mark.parametrize("transport", TRANSPORTS.values(), ids=TRANSPORTS)


def pressure():
    return np.maximum(1 - PLACES[0] ** 2 - PLACES[1] ** 2, 0.0)


def response(interface, at):
    rng = np.random.default_rng(0)
    bound = 0.3 * pressure()
    traction = interface.potential(pressure(), at).projected(rng.normal(size=(2, *SHAPE)), 1.0)
    traction = np.where(pressure() > 0, np.nan_to_num(traction), 0.0)
    return Response(pressure(), traction, 0.1 * rng.normal(size=(2, *SHAPE)), bound)


@every_transport
@every_interface
def test_bounds_are_on_the_grid_and_not_negative(interface, transport):
    potential = interface.potential(pressure(), Surroundings(transport))
    assert potential.bound.shape == SHAPE
    inside = pressure() > 0
    assert np.all(potential.bound[inside] >= 0)
    more = interface.potential(2 * pressure(), Surroundings(transport)).bound[inside]
    assert np.all(more >= potential.bound[inside])


@every_transport
@every_interface
def test_what_is_implicit_is_implied_and_taken(interface, transport):
    """Each implicit field has a name; given in a pass, the potential has it."""
    at = Surroundings(transport)
    found = interface.implied(response(interface, at), at)
    for quantity in interface.implicit(transport):
        if quantity.name == FRICTION:  # of a law, by slip and temperature: solving.friction_law
            continue
        assert found[quantity.name].shape == SHAPE
        given = Surroundings(transport, implicit={quantity.name: 0.5 * found[quantity.name]})
        assert not interface.potential(pressure(), given).implicit
        own, other = (interface.potential(pressure(), each) for each in (at, given))
        lower = other.bound if other.flow is None else other.flow.threshold
        upper = own.bound if own.flow is None else own.flow.threshold
        assert np.any(lower < upper)


@every_transport
@every_interface
def test_what_particles_leave_is_what_they_carry(interface, transport):
    at = Surroundings(transport)
    left = interface.leave(response(interface, at), np.zeros((2, *SHAPE)), at)
    assert set(left) == {quantity.name for quantity in interface.carried}
    assert all(field.shape[-2:] == SHAPE for field in left.values())


@pytest.mark.parametrize("hardening", [-0.5, 0.0, 0.5])
def test_a_layer_goes_on_from_what_has_arrived(hardening):
    layer = YieldingLayer(0.2, hardening)
    arrived = {YIELD_STRESS: np.full(SHAPE, 0.35), DISPLACEMENT: np.full((2, *SHAPE), 0.01)}
    at = Surroundings(Step(0.1, 0.1), arrived)
    potential = layer.potential(pressure(), at)
    stress = potential.bound if potential.flow is None else potential.flow.threshold
    np.testing.assert_array_equal(stress, 0.35)
    flowed = np.full((2, *SHAPE), 0.02)
    stretched = dataclasses.replace(response(layer, at), friction_bound=2.0 * pressure())
    left = layer.leave(stretched, flowed, at)
    np.testing.assert_allclose(left[DISPLACEMENT], 0.03)
    if hardening == 0:
        np.testing.assert_array_equal(left[YIELD_STRESS], 0.35)
    else:
        assert np.any((left[YIELD_STRESS] - 0.35) * hardening > 0)
        assert np.all((left[YIELD_STRESS] - 0.35) * hardening >= 0)


def test_two_owners_of_a_quantity_are_refused():
    with pytest.raises(vc.SceneError, match=r"plastic_displacement.*YieldingLayer, YieldingLayer"):
        Several((YieldingLayer(0.2, 0.0), YieldingLayer(0.3, 0.5)))
