"""What every interface promises: potentials on the grid, fields by name, and who owns what
particles carry.
"""

from dataclasses import dataclass, field, replace

import numpy as np
import pytest

import varcontact as vc
from varcontact.discrete.discretisation import discretise
from varcontact.interfaces.coulomb import BoundByPressure, Coulomb
from varcontact.interfaces.heat import TEMPERATURE, FrictionalHeat
from varcontact.interfaces.interface import Several, StepBefore, Surroundings, together
from varcontact.interfaces.laws import FRICTION, FrictionByLaw
from varcontact.interfaces.third_body import DISPLACEMENT, YIELD_STRESS, YieldingLayer
from varcontact.scene.motion import TimeStep
from varcontact.scene.units import Scales
from varcontact.transports import SteadyRolling, Step

SHAPE = (4, 7)
GRID = vc.Grid(nx=7, ny=4, dx=0.3, dy=0.5, x0=-1.05, y0=-1.0)
SCALES = Scales(length=2.0, pressure=3.0, modulus=5.0, line=False)
FALLING = vc.LinearFalling(static=0.4, kinetic=0.2, half_velocity=0.01)
JUMPING = vc.StaticKinetic(static=0.4, kinetic=0.2)
REMEMBERING = replace(FALLING, memory_distance=0.5)
WARM = vc.TemperatureFalling(static=0.4, kinetic=0.2, reference=0.0, over=0.02)
STEEL = vc.Thermal(conductivity=50.0, density=7.85e-9, heat_capacity=4.5e8)
PLACES = np.meshgrid(np.linspace(-1, 1, SHAPE[1]), np.linspace(-1, 1, SHAPE[0]))


def by_law(law):
    return FrictionByLaw(law, GRID, SCALES, remembers=True)


HEAT = FrictionalHeat((STEEL, STEEL), TimeStep(dq=0.1, dt=0.01), 0.3, SCALES)
INTERFACES = {
    "a coefficient": Coulomb(0.3),
    "coefficients": Coulomb(np.linspace(0.1, 0.4, 28).reshape(SHAPE)),
    "no slip": Coulomb(np.inf),
    "a falling law": by_law(FALLING),
    "a law that jumps": by_law(JUMPING),
    "a law with memory": by_law(REMEMBERING),
    "heat alone": HEAT,
    "heat and a law by it": Several((HEAT, by_law(WARM))),
    "a strength": BoundByPressure(vc.ShearStrength(0.3, 0.2), SCALES, *PLACES),
    "a plastic layer": YieldingLayer(0.2, 0.0),
    "a hardening layer": YieldingLayer(0.2, 0.5),
    "a softening layer": YieldingLayer(0.2, -0.5),
    "friction and a layer": Several((Coulomb(0.3), YieldingLayer(0.2, 0.5))),
    "a law and a layer": Several((by_law(FALLING), YieldingLayer(0.2, 0.0))),
    "all": Several((HEAT, by_law(WARM), YieldingLayer(0.2, 0.5))),
}
TRANSPORTS = {
    "steady": SteadyRolling(0.1, 0.1),
    "step": Step(0.13, 0.1),
    "in place": Step(0.0, 0.1),
}
every_interface = pytest.mark.parametrize("interface", INTERFACES.values(), ids=INTERFACES)
every_transport = pytest.mark.parametrize("transport", TRANSPORTS.values(), ids=TRANSPORTS)


@dataclass
class Told:
    """A response in which half of the elements slip."""

    pressure: np.ndarray
    traction: np.ndarray
    shift: np.ndarray
    slip_bound: np.ndarray
    fields: dict = field(default_factory=dict)
    unit_slip: float = 1.0
    own_influence: float = 1.0

    @property
    def slips(self):
        return (self.pressure > 0) & (PLACES[0] > 0)

    @property
    def sticks(self):
        return (self.pressure > 0) & ~self.slips

    @property
    def slip_shift(self):
        return self.shift * (self.pressure > 0)

    @property
    def slip(self):
        return np.hypot(*self.slip_shift) * self.slips

    @property
    def flowed(self):
        return np.full((2, *SHAPE), 0.02)

    def work(self):
        return np.hypot(*self.traction) * self.slip

    def elastic_shift(self, traction):
        return traction

    def under(self, fields):
        return self


def pressure():
    return np.maximum(1 - PLACES[0] ** 2 - PLACES[1] ** 2, 0.0)


def response(interface, at):
    rng = np.random.default_rng(0)
    bound = 0.3 * pressure()
    traction = interface.potential(pressure(), at).projected(rng.normal(size=(2, *SHAPE)), 1.0)
    traction = np.where(pressure() > 0, np.nan_to_num(traction), 0.0)
    return Told(pressure(), traction, 0.1 * rng.normal(size=(2, *SHAPE)), bound)


@every_transport
@every_interface
def test_bounds_are_on_the_grid_and_not_negative(interface, transport):
    at = Surroundings(transport)
    potential = interface.potential(pressure(), at)
    assert potential.bound.shape == SHAPE
    inside = pressure() > 0
    assert np.all(potential.bound[inside] >= 0)
    more = interface.potential(2 * pressure(), at).bound[inside]
    assert np.all(more >= potential.bound[inside])
    assert np.all(interface.slip_bound(pressure(), at)[inside] >= potential.bound[inside])
    assert interface.unbounded == np.isinf(potential.bound[inside]).all() or potential.flow


@every_transport
@every_interface
def test_what_is_implicit_is_implied_and_taken(interface, transport):
    """Each implicit field has a name, limits and a first value; given in a pass, the potential has
    it.
    """
    at = Surroundings(transport)
    found = interface.implied(response(interface, at), at)
    first = interface.first("stick", at, SHAPE)
    for quantity in interface.implicit(transport):
        assert found[quantity.name].shape == first[quantity.name].shape == SHAPE
        assert np.all(found[quantity.name] >= quantity.least - 1e-12)
        assert np.all(found[quantity.name] <= quantity.most + 1e-12)
        half = {**found, quantity.name: 0.5 * found[quantity.name]}
        own, other = (interface.potential(pressure(), at.under(each)) for each in (found, half))
        assert not own.implicit
        lower, upper = other.bound, own.bound
        if own.flow is not None and quantity.name != FRICTION:
            lower, upper = other.flow.threshold, own.flow.threshold
        assert np.any(lower < upper)


@every_transport
@every_interface
def test_a_pass_that_ends_has_what_the_response_implies(interface, transport):
    """Where the fields of a pass are those that the response implies, the next ones are the same,
    but where nothing slips: any larger coefficient has the same tractions.
    """
    at = Surroundings(transport)
    told = response(interface, at)
    implied = {**interface.implied(told, at)}
    told.fields = implied
    after = interface.after(told, at.under(implied))
    for quantity in interface.implicit(transport):
        slips = told.slips
        np.testing.assert_allclose(
            after[quantity.name][slips],
            interface.after(told, at.under(after))[quantity.name][slips],
        )


@every_transport
@every_interface
def test_what_particles_leave_is_what_they_carry_and_bring_along(interface, transport):
    at = Surroundings(transport)
    told = response(interface, at)
    left = interface.leave(told, at.under(interface.implied(told, at)))
    assert set(left) == {quantity.name for quantity in interface.carried}
    assert all(each.shape[-2:] == SHAPE for each in left.values())
    before = StepBefore(
        told.pressure, told.traction, told.slip, told.slips, told.sticks, carried=left
    )
    arrived = interface.arrive(before, at)
    assert all(each.shape[-2:] == SHAPE for each in arrived.values())
    first = interface.first(None, replace(at, arrived=arrived), SHAPE)
    for name in set(first) & set(arrived):
        np.testing.assert_array_equal(first[name], arrived[name])


@every_interface
def test_what_is_carried_has_a_name_a_unit_and_a_fresh_value(interface):
    for quantity in interface.carried:
        assert quantity.name
        assert quantity.words
        assert quantity.kind in ("1", "length", "pressure")
        assert np.isfinite(quantity.fresh)
        assert quantity.dims[-2:] == ("y", "x")


@pytest.mark.parametrize("hardening", [-0.5, 0.0, 0.5])
def test_a_layer_goes_on_from_what_has_arrived(hardening):
    layer = YieldingLayer(0.2, hardening)
    arrived = {YIELD_STRESS: np.full(SHAPE, 0.35), DISPLACEMENT: np.full((2, *SHAPE), 0.01)}
    at = Surroundings(Step(0.1, 0.1), arrived)
    potential = layer.potential(pressure(), at)
    stress = potential.bound if potential.flow is None else potential.flow.threshold
    np.testing.assert_array_equal(stress, 0.35)
    stretched = replace(response(layer, at), slip_bound=2.0 * pressure())
    left = layer.leave(stretched, at)
    np.testing.assert_allclose(left[DISPLACEMENT], 0.03)
    if hardening == 0:
        np.testing.assert_array_equal(left[YIELD_STRESS], 0.35)
    else:
        assert np.any((left[YIELD_STRESS] - 0.35) * hardening > 0)
        assert np.all((left[YIELD_STRESS] - 0.35) * hardening >= 0)


def test_a_law_by_temperature_reads_that_of_the_heat():
    """Colder surfaces have more friction; without work it is that of cold bodies."""
    at = Surroundings(Step(0.1, 0.1))
    both = Several((HEAT, by_law(WARM)))
    told = response(both, at)
    warm = both.implied(told, at)
    assert warm[TEMPERATURE].max() > 0.0
    cold = both.implied(replace(told, traction=0.0 * told.traction), at)
    assert np.all(cold[FRICTION] >= warm[FRICTION] - 1e-15)
    assert np.any(cold[FRICTION] > warm[FRICTION])


def test_a_start_chooses_a_branch():
    law = by_law(JUMPING)
    at = Surroundings(SteadyRolling(0.1, 0.1))
    assert np.all(law.first("stick", at, SHAPE)[FRICTION] == 0.4)
    assert np.all(law.first("slip", at, SHAPE)[FRICTION] == 0.2)


def test_two_owners_of_a_quantity_are_refused():
    with pytest.raises(vc.SceneError, match=r"plastic_displacement.*YieldingLayer, YieldingLayer"):
        Several((YieldingLayer(0.2, 0.0), YieldingLayer(0.3, 0.5)))


@pytest.mark.parametrize("parts", [(by_law(WARM),), (by_law(WARM), HEAT)])
def test_an_interface_without_a_field_that_it_reads_is_refused(parts):
    with pytest.raises(vc.SceneError, match=r"FrictionByLaw") as error:
        together(parts)
    assert (error.value.field, error.value.value) == ("interfaces", TEMPERATURE)


def test_only_interfaces_that_a_scene_has_are_made():
    scene = vc.Scene(
        bodies=vc.Bodies(G=1.0, nu=0.28),
        surface=vc.Paraboloids(Rx=1.0, Ry=1.3),
        normal_force=1e-3,
        friction=FALLING,
        motion=vc.Steady(vx=1e-3),
        grid=vc.Grid(nx=6, ny=6, dx=0.05, dy=0.05, x0=-0.15, y0=-0.15),
    )
    assert type(discretise(scene, scene.grid).interface) is FrictionByLaw
    plain = replace(scene, friction=0.3)
    assert type(discretise(plain, plain.grid).interface) is Coulomb
