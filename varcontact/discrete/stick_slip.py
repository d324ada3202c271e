"""Where a contact state sticks and where it slips, by how much, and the work that friction takes."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from varcontact.discrete.discretisation import Discretisation
from varcontact.discrete.state import ContactState

EXTERIOR, STICK, SLIP = 0, 1, 2


def shift_and_areas(disc: Discretisation, state: ContactState) -> tuple[np.ndarray, np.ndarray]:
    """Local shift E in the contact, (2, ny, nx), dimensionless, and 0, 1, 2 for exterior, stick, slip, (ny, nx).

    An element slips where the natural map leaves the bound: ``|p - E/rho| > g``, true where traction is at the
    bound and slip opposes it.
    """
    contact = state.pressure > 0
    areas = contact.astype(np.int8)
    shift = np.zeros((2, *contact.shape))
    if disc.loading.motion is None:
        return shift, areas
    shift[:] = disc.known_shift + state.rigid[:, None, None]
    if not disc.loading.frictionless:
        shift += disc.shift_by_tractions(state.traction)
    if disc.K != 0:
        shift += disc.pressure_to_shift.apply(state.pressure[None])
    shift *= contact
    if state.slips is not None:
        areas[contact & state.slips] = SLIP
    elif not disc.loading.no_slip:
        bound = np.asarray(disc.loading.coefficient) * state.pressure
        trial = state.traction - shift / own_influence(disc)
        noise = 1e-12 * np.abs(trial).max()
        areas[contact & (np.hypot(*trial) > bound * (1 + 1e-8) + noise)] = SLIP
    return shift, areas


def friction_work(disc: Discretisation, state: ContactState, shift: np.ndarray) -> np.ndarray:
    """Work that the tractions p of a state lose by friction in a step, by area, (ny, nx), dimensionless.

    In place it is ``-p.E`` by the shift E. In rolling ``-(p.E + p'.E')/2``: p and E of the particles there at the end
    of the step, p' and E' of those at its beginning, with spin in the middle of their paths. The sum is the work put
    in less the elastic energy stored.
    """
    motion, before, traction = disc.loading.motion, disc.loading.previous_step, state.traction
    unknown = before is not None and before.traction is None
    if motion is None or motion.rolls == 0 or disc.loading.frictionless or unknown:
        return np.asarray(0.0 - np.sum(traction * shift, axis=0))
    assert disc.step is not None
    rolled, (x, y), scales = motion.rolls * disc.step, disc.points, disc.scales
    fields = traction if disc.K == 0 else np.concatenate([traction, state.pressure[None]])
    elastic_now = _elastic_shift(disc, fields)
    if not disc.operators.medium.even:
        traction_then, operators, difference = traction, disc.operators, disc.loading.slip_difference
        elastic_then = -operators.tangential(-rolled, difference).apply(traction)
        if disc.K != 0:
            elastic_then = elastic_then - operators.pressure_to_shift(-rolled, difference).apply(fields[2:])
    elif disc.loading.steady:
        traction_then = traction
        turned = _mirrored if disc.conformal else _turned
        elastic_then = -turned(_elastic_shift(disc, turned(fields)))
    else:
        traction_then = np.zeros_like(traction)
        elastic_then = _turned(disc.operators.carrying(rolled).apply(_turned(fields)))
    if before is not None and before.traction is not None:
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


def _turned(fields: np.ndarray) -> np.ndarray:
    """Turned half about the normal, but for the sign of all: the operator between turned fields is the transposed."""
    turned = fields[..., ::-1, ::-1].copy()
    turned[2:] *= -1
    return turned


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
