"""Stick, plastic flow and slip of a contact state, and the work of friction."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from varcontact.discrete.discretisation import Discretisation
from varcontact.discrete.state import ContactState
from varcontact.interfaces.interface import Fields
from varcontact.system.process import changed, lazy_property
from varcontact.transports import mirrored

EXTERIOR = 0
STICK = 1
SLIP = 2
PLASTIC = 3

SLIPS_TOL = 1e-8
"""Relative distance beyond the bound from which a trial traction slips."""


@dataclass(frozen=True, eq=False)
class ContactResponse:
    """Response of a contact state, as interfaces read it."""

    disc: Discretisation
    state: ContactState

    @property
    def pressure(self) -> np.ndarray:
        return self.state.pressure

    @property
    def traction(self) -> np.ndarray:
        return self.state.traction

    @property
    def fields(self) -> Fields:
        return self.state.fields

    @property
    def acting(self) -> np.ndarray:
        """Tractions, and for unlike bodies pressures: everything that shifts the surfaces."""
        if self.disc.K == 0:
            return self.traction
        return np.concatenate([self.traction, self.pressure[None]])

    @lazy_property
    def under_implied_fields(self) -> Discretisation:
        """Discretisation with the fields that the tractions imply, by which the contact is
        judged.
        """
        return with_implied_fields(self.disc, self.state)

    @lazy_property
    def distance(self) -> np.ndarray:
        """Change of the distance by the pressures, A_zz p, (ny, nx), dimensionless."""
        return np.asarray(self.disc.operators.normal.apply(self.pressure[None])[0])

    @lazy_property
    def elastic(self) -> np.ndarray:
        """Shift by tractions and, where the bodies differ, pressures, (2, ny, nx), dimensionless;
        without edge compliance.
        """
        return _elastic_shift(self.disc, self.acting)

    @lazy_property
    def shift(self) -> np.ndarray:
        """Local shift E in the contact, (2, ny, nx), dimensionless."""
        disc = self.disc
        contact = self.pressure > 0
        if disc.loading.motion is None:
            return np.zeros((2, *contact.shape))
        shift = disc.known_shift + self.state.rigid[:, None, None]
        if not disc.frictionless or disc.K != 0:
            shift = shift + self.elastic
        if disc.edge_compliance is not None:
            shift = shift + disc.edge_compliance * self.traction
        return np.asarray(shift * contact)

    @lazy_property
    def slip_shift(self) -> np.ndarray:
        """Shift by slip in the contact, (2, ny, nx), dimensionless: the local shift E, less what
        flows between the bodies.
        """
        flow = flow_of(self.disc, self.state, self.shift, self.areas)
        if flow is None:
            return self.shift
        return self.shift + flow

    @lazy_property
    def areas(self) -> np.ndarray:
        """0, 1, 2, 3 for exterior, stick, slip, plastic, (ny, nx)."""
        return _areas(self)

    @property
    def slips(self) -> np.ndarray:
        return np.asarray(self.areas == SLIP)

    @property
    def sticks(self) -> np.ndarray:
        return np.asarray(self.areas == STICK)

    @lazy_property
    def slip(self) -> np.ndarray:
        return np.asarray(np.hypot(*self.slip_shift) * self.slips / self.unit_slip)

    @lazy_property
    def flowed(self) -> np.ndarray:
        flow = flow_of(self.disc, self.state, self.shift, self.areas)
        if flow is None:
            return np.zeros_like(self.shift)
        return flow

    @lazy_property
    def unit_slip(self) -> float:
        return unit_slip(self.disc)

    @lazy_property
    def slip_bound(self) -> np.ndarray:
        return self.disc.interface.slip_bound(self.pressure, self.disc.surroundings)

    @property
    def own_influence(self) -> float:
        return own_influence(self.disc)

    def work(self) -> np.ndarray:
        """Work of friction in the step, per area."""
        return _friction_work(self)

    def elastic_shift(self, traction: np.ndarray) -> np.ndarray:
        """Shift by tractions."""
        return self.disc.tangential_operator.apply(traction)

    def without_matrices(self) -> ContactResponse:
        """Copy without the matrices that solvers assembled, to be kept after a solve."""
        return changed(self, disc=self.disc.without_matrices())

    def under(self, fields: Fields) -> ContactResponse:
        """Response of the same contact state with these implicit fields added."""
        return ContactResponse(self.disc.under(fields), self.state)


def _areas(response: ContactResponse) -> np.ndarray:
    """0, 1, 2, 3 for exterior, stick, slip, plastic.

    An element slips where the natural map leaves the bound: ``|p - E/rho| > g``, true where
    traction is at the bound and slip opposes it.
    """
    disc = response.disc
    state = response.state
    contact = state.pressure > 0
    areas = contact.astype(np.int8)
    if disc.loading.motion is None:
        return areas
    if state.slips is not None:
        areas[contact & state.slips] = SLIP
    elif not disc.interface.unbounded:
        disc = response.under_implied_fields
        potential = disc.potential(state.pressure)
        own = response.own_influence
        trial = state.traction - response.shift / own
        size = np.hypot(*trial)
        noise = 1e-12 * np.abs(trial).max()
        beyond = potential.sizes(size, own) > potential.bound * (1 + SLIPS_TOL) + noise
        areas[contact & beyond] = SLIP
        if disc.interface.flows:
            slip_bound = disc.interface.slip_bound(state.pressure, disc.surroundings)
            plastic = beyond & (potential.bound < slip_bound)
            if potential.flow is not None:
                flows = size > potential.flow.threshold * (1 + SLIPS_TOL) + noise
                plastic |= flows & ~beyond
            areas[contact & plastic] = PLASTIC
    return areas


def with_implied_fields(
    disc: Discretisation, state: ContactState, *, by_slip: bool = False
) -> Discretisation:
    """Discretisation with the implicit fields of a state from any source: those that its tractions
    imply, or with `by_slip` those that follow from its slip.
    """
    those = disc.interface.those(by_slip=by_slip)
    if those is None or disc.frictionless:
        return disc
    if by_slip:  # whatever slip area the state has
        state = replace(state, slips=None)
    fields = those.implied(ContactResponse(disc, state), disc.surroundings)
    if not fields:
        return disc
    return disc.under(fields)


def flow_of(
    disc: Discretisation, state: ContactState, shift: np.ndarray, areas: np.ndarray
) -> np.ndarray | None:
    """Plastic flow in a step, (2, ny, nx), dimensionless, under the local shift of a state; None
    where nothing can flow.
    """
    layers = disc.interface.those(by_slip=False)
    if disc.frictionless or not (layers is not None and layers.flows):
        return None
    flow = with_implied_fields(disc, state).potential(state.pressure).flow
    if flow is None:
        return np.where(areas == PLASTIC, -shift, 0.0)
    return flow.shift(state.traction)


def left_fields(response: ContactResponse) -> Fields:
    """Quantities of the particles at the end of a step, dimensionless, by their names."""
    return response.disc.interface.leave(response, response.disc.surroundings)


def _friction_work(response: ContactResponse) -> np.ndarray:
    """Work that the tractions p of a state lose by friction in a step, per area, (ny, nx),
    dimensionless.

    In place it is ``-p.E`` by the shift E. In rolling ``-(p.E + p'.E')/2``: p and E of the
    particles there at the end of the step, p' and E' of those at its beginning, with spin in the
    middle of their paths. The sum is the work put in less the elastic energy stored.
    """
    disc = response.disc
    motion = disc.loading.motion
    traction = response.traction
    if motion is None or motion.rolls == 0 or disc.frictionless:
        shift = response.slip_shift
        if disc.interface.flows:
            shift = response.shift
        return np.asarray(0.0 - np.sum(traction * shift, axis=0))
    assert disc.step is not None
    rolled = motion.rolls * disc.step
    # elastic part of E and E', and the tractions p'
    elastic_end = response.elastic
    elastic_start = _elastic_shift_at_start(disc, response.acting, rolled)
    previous = disc.loading.previous_step
    traction_start = traction
    if previous is None and not disc.transport.repeats and disc.operators.medium.reciprocal:
        traction_start = np.zeros_like(traction)
    elif previous is not None:
        traction_start = previous.traction[:2]
        elastic_end = elastic_end - previous.displacement
        left = previous.left
        if left is None:
            left = _elastic_shift(disc, previous.traction)
        elastic_start = elastic_start - left
    # rigid part
    scales = disc.scales
    x, y = disc.points
    path = changed(motion.step(disc.step * scales.length), spin_offset=0.5)
    free = response.state.rigid[:, None, None] + disc.slip_of_elements / scales.displacement
    rigid_end = path.shift(x, y, scales.length) / scales.displacement + free
    rigid_start = path.shift(x - rolled, y, scales.length) / scales.displacement + free
    # work, by the mean of both
    lost_end = traction * (rigid_end + elastic_end)
    lost_start = traction_start * (rigid_start + elastic_start)
    along_x, along_y = lost_end + lost_start
    return np.asarray(0.0 - 0.5 * (along_x + along_y))


def _elastic_shift(disc: Discretisation, fields: np.ndarray) -> np.ndarray:
    """Shift by tractions and, where the bodies differ, pressures; without edge compliance."""
    shift = disc.tangential_operator.apply(fields[:2])
    if len(fields) > 2:
        shift = shift + disc.pressure_to_shift.apply(fields[2:])
    return shift


def _elastic_shift_at_start(disc: Discretisation, fields: np.ndarray, rolled: float) -> np.ndarray:
    """Shift in a step, by the tractions at its end, of the particles that are there at its start;
    in a history without the past tractions.
    """
    repeats = disc.transport.repeats
    if not disc.mirrors and (repeats or not disc.operators.medium.reciprocal):
        backwards = mirrored(disc.transport.stencil)
        shift = -disc.operators.tangential(backwards).apply(fields[:2])
        if len(fields) > 2:
            shift = shift - disc.operators.pressure_to_shift(backwards).apply(fields[2:])
        return shift
    if repeats:
        return -_mirrored(_elastic_shift(disc, _mirrored(fields)))
    if not disc.mirrors:
        return disc.operators.carrying(-rolled).apply(fields)
    return _mirrored(disc.operators.carrying(rolled).apply(_mirrored(fields)))


def _mirrored(fields: np.ndarray) -> np.ndarray:
    """Fields mirrored in a plane across x: the mirrored bodies roll the other way, whatever varies
    along y.
    """
    mirrored = fields[..., ::-1].copy()
    mirrored[0] *= -1
    return mirrored


def own_influence(disc: Discretisation) -> float:
    """Mean of an element's influence on itself along x and y; an arbitrary one where there is no
    traction to compare with.
    """
    if disc.frictionless:
        return 1.0
    return disc.tangential_operator.diagonal


def unit_slip(disc: Discretisation) -> float:
    """Dimensionless shift that is a relative slip of 1; in a shift, that is one unit of length."""
    length = 1.0
    if disc.step is not None:
        length = disc.step * disc.scales.length
    return length / disc.scales.displacement
