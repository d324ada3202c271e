"""Where a contact state sticks, flows and slips, by how much, and the work that friction takes.

A third body that yields flows before it slips: its yield stress goes with the
particles, and the local shift of the bodies is that of the slip less what
flows.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from varcontact.discrete.discretisation import Discretisation
from varcontact.discrete.state import ContactState
from varcontact.interfaces.potential import Flow
from varcontact.transports import along_rows, further_along, mirrored

EXTERIOR, STICK, SLIP, PLASTIC = 0, 1, 2, 3


def shift_and_areas(disc: Discretisation, state: ContactState) -> tuple[np.ndarray, np.ndarray]:
    """Shift by slip in the contact, (2, ny, nx), dimensionless, and 0, 1, 2, 3 for exterior, stick, slip, plastic.

    An element slips where the natural map leaves the bound: ``|p - E/rho| > g``, true where traction is at the
    bound and slip opposes it. The slip is the local shift E, less what a third body flows.
    """
    shift, contact = local_shift(disc, state), state.pressure > 0
    areas = contact.astype(np.int8)
    if disc.loading.motion is None:
        return shift, areas
    if state.slips is not None:
        areas[contact & state.slips] = SLIP
    elif not disc.loading.no_slip:
        own, disc = own_influence(disc), with_yield_stress(disc, state)
        limit, stress = np.asarray(disc.loading.coefficient) * state.pressure, disc.loading.yield_stress
        trial = state.traction - shift / own
        size, noise, flows = np.hypot(*trial), 1e-12 * np.abs(trial).max(), np.zeros_like(contact)
        bound = limit if stress is None or disc.hardening > 0 else np.minimum(limit, stress)
        if stress is not None and disc.hardening > 0:
            flows = size > stress * (1 + 1e-8) + noise
            size = Flow(stress, disc.hardening).sizes(size, own)
        slips = size > bound * (1 + 1e-8) + noise
        areas[contact & flows] = PLASTIC
        areas[contact & slips] = SLIP
        areas[contact & slips & (bound < limit)] = PLASTIC
    if disc.loading.third_body is None:
        return shift, areas
    return shift + plastic_flow(disc, state, shift, areas), areas


def local_shift(disc: Discretisation, state: ContactState) -> np.ndarray:
    """Local shift E in the contact, (2, ny, nx), dimensionless."""
    contact = state.pressure > 0
    shift = np.zeros((2, *contact.shape))
    if disc.loading.motion is None:
        return shift
    shift[:] = disc.known_shift + state.rigid[:, None, None]
    if not disc.loading.frictionless:
        shift += disc.tangential_operator.apply(state.traction)
        if disc.edge_compliance is not None:
            shift += disc.edge_compliance * state.traction
    if disc.K != 0:
        shift += disc.pressure_to_shift.apply(state.pressure[None])
    shift *= contact
    return shift


def with_yield_stress(disc: Discretisation, state: ContactState) -> Discretisation:
    """The same with the yield stress that goes with the tractions of a state, where a third body yields.

    In steady rolling particles harden along their rows, from the leading edge; one that softens does so in the step.
    """
    layer = disc.loading.third_body
    if layer is None or not layer.yields:
        return disc
    stress = disc.known_yield_stress
    if disc.hardening > 0 and disc.loading.steady:
        stress = Flow(stress, disc.hardening, disc.transport.columns).after(np.hypot(*state.traction))
    elif disc.hardening < 0:
        flows = np.asarray(disc.loading.coefficient) * state.pressure > stress
        softened = np.maximum(stress + disc.hardening * np.hypot(*local_shift(disc, state)), 0.0)
        stress = np.where(flows, softened, stress)
    return disc.with_loading(yield_stress=stress)


def plastic_flow(disc: Discretisation, state: ContactState, shift: np.ndarray, areas: np.ndarray) -> np.ndarray:
    """What a third body flows in a step, (2, ny, nx), dimensionless, under the local shift of a state."""
    stress = None if disc.loading.frictionless else with_yield_stress(disc, state).loading.yield_stress
    if stress is None:
        return np.zeros_like(shift)
    if disc.hardening <= 0:
        return np.where(areas == PLASTIC, -shift, 0.0)
    return Flow(stress, disc.hardening).shift(state.traction)


def plastic_state(disc: Discretisation, state: ContactState) -> np.ndarray | None:
    """Plastic displacement and yield stress of the particles at the end of a step, (3, ny, nx), dimensionless."""
    stress = with_yield_stress(disc, state).loading.yield_stress
    if stress is None:
        return None
    shift, (_, areas) = local_shift(disc, state), shift_and_areas(disc, state)
    if disc.hardening > 0:
        stress = np.maximum(stress, np.hypot(*state.traction))
    flow, before = plastic_flow(disc, state, shift, areas), disc.loading.previous_step
    if disc.loading.steady:
        columns = disc.transport.columns
        flow = along_rows(flow / min(columns, 1.0), columns, 0.0, np.add)
    elif before is not None and before.plastic is not None:
        flow = flow + before.plastic[:2]
    return np.concatenate([flow, stress[None]])


def arriving(disc: Discretisation, field: np.ndarray, fresh: float) -> np.ndarray:
    """Values (..., ny, nx) of the particles where they were a step ago, `fresh` beyond the grid."""
    return further_along(field, disc.transport.columns, fresh)


def friction_work(disc: Discretisation, state: ContactState, shift: np.ndarray) -> np.ndarray:
    """Work that the tractions p of a state lose by friction in a step, by area, (ny, nx), dimensionless.

    In place it is ``-p.E`` by the shift E. In rolling ``-(p.E + p'.E')/2``: p and E of the particles there at the end
    of the step, p' and E' of those at its beginning, with spin in the middle of their paths. The sum is the work put
    in less the elastic energy stored.
    """
    motion, before, traction = disc.loading.motion, disc.loading.previous_step, state.traction
    if motion is None or motion.rolls == 0 or disc.loading.frictionless:
        shift = shift if disc.loading.third_body is None else local_shift(disc, state)
        return np.asarray(0.0 - np.sum(traction * shift, axis=0))
    assert disc.step is not None
    rolled, (x, y), scales = motion.rolls * disc.step, disc.points, disc.scales
    fields = traction if disc.K == 0 else np.concatenate([traction, state.pressure[None]])
    elastic_now = _elastic_shift(disc, fields)
    if not disc.operators.medium.even:
        traction_then = traction
        backwards = mirrored(disc.transport.stencil)
        elastic_then = -disc.operators.tangential(backwards).apply(traction)
        if disc.K != 0:
            elastic_then = elastic_then - disc.operators.pressure_to_shift(backwards).apply(fields[2:])
    elif disc.loading.steady:
        traction_then = traction
        elastic_then = -_mirrored(_elastic_shift(disc, _mirrored(fields)))
    else:
        traction_then = np.zeros_like(traction)
        elastic_then = _mirrored(disc.operators.carrying(rolled).apply(_mirrored(fields)))
    if before is not None:
        elastic_now = elastic_now - before.displacement
        elastic_then = elastic_then - (_elastic_shift(disc, before.traction) if before.left is None else before.left)
        traction_then = before.traction[:2]
    path = replace(motion.step(disc.step * scales.length), spin_offset=0.5)
    free = state.rigid[:, None, None] + disc.slip_of_elements / scales.displacement
    rigid_now, rigid_then = (path.shift(at, y, scales.length) / scales.displacement + free for at in (x, x - rolled))
    lost = traction * (rigid_now + elastic_now) + traction_then * (rigid_then + elastic_then)
    return np.asarray(0.0 - 0.5 * np.sum(lost, axis=0))


def _elastic_shift(disc: Discretisation, fields: np.ndarray) -> np.ndarray:
    """By tractions and, where the bodies differ, pressures; without edge compliance."""
    shift = disc.tangential_operator.apply(fields[:2])
    return shift if len(fields) == 2 else shift + disc.pressure_to_shift.apply(fields[2:])


def _mirrored(fields: np.ndarray) -> np.ndarray:
    """Mirrored in a plane across x: between mirrored fields bodies roll the other way, whatever varies along y."""
    mirrored = fields[..., ::-1].copy()
    mirrored[0] *= -1
    return mirrored


def own_influence(disc: Discretisation) -> float:
    """Mean of an element's influence on itself along x and y; any, where there is no traction to compare with."""
    return 1.0 if disc.loading.frictionless else disc.tangential_operator.on(np.arange(1)).diagonal


def unit_slip(disc: Discretisation) -> float:
    """Dimensionless shift that is a relative slip of 1; in a shift, that is one unit of length."""
    return (1.0 if disc.step is None else disc.step * disc.scales.length) / disc.scales.displacement
