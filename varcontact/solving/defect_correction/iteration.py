"""Defect correction: what a field on parts lacks of the continuum's slip is added to the coarse problem's."""

from __future__ import annotations

import time
from dataclasses import dataclass, replace

import numpy as np

from varcontact.discrete.discretisation import Discretisation, PreviousStep
from varcontact.discrete.state import ContactState
from varcontact.discrete.stick_slip import unit_slip
from varcontact.scene.motion import Steady
from varcontact.solving.contact_solver import ContactSolver, contact
from varcontact.solving.defect_correction.fine_grid import FineField, FineGrid, resultants
from varcontact.solving.defect_correction.reconstruction import continued, held_behind
from varcontact.solving.friction_law import coefficient

DAMPING = np.array([1.0, 1.0, 0.7, 0.7])
"""Part of its defect that each pass adds: later ones would move to and fro."""
LATE = 2
"""Passes whose changes the estimate counts as a whole: those that are damped."""


@dataclass(frozen=True, eq=False)
class Corrected:
    """A coarse solution after the passes, and its field on parts of the elements. Dimensionless, but for `forces`."""

    # the coarse problem as it was solved last, with the correction of its rigid shift in `previous_step`
    disc: Discretisation
    state: ContactState  # its solution
    fine: FineGrid
    field: FineField
    shift: np.ndarray  # (2, ny PARTS, nx PARTS) The continuum's local shift under the field
    forces: np.ndarray
    creepages: np.ndarray  # (passes + 1, 2) vx and vy then, given or found for forces that are given
    seconds: tuple[float, ...]  # of each pass


def defect_correct(coarse: Discretisation, state: ContactState, loose: ContactSolver, last: ContactSolver) -> Corrected:
    """Correct a coarse solution of steady rolling under Hertz's pressure: `loose` solves all passes but the last.

    Where forces are prescribed, those of the coarse problem are changed by what its elements carry more than the field.
    Under a law of friction the field has the coefficients that the law has at the corrected slip of the elements.
    """
    fine, disc = FineGrid(coarse, state.pressure), coarse
    field = fine.field(state.traction, _friction(disc, state))
    correction, excess = np.zeros(state.traction.shape), np.zeros(2)
    forces, creepages, seconds = [_loads(disc, state)], [_creepages(disc, state)], []
    for k, damping in enumerate(DAMPING):
        begun = time.perf_counter()
        correction = correction + damping * (_defect(coarse, state, fine, field) - correction)
        carried_more = (_loads(coarse, state) - fine.forces(field))[:2] / coarse.scales.force
        excess = excess + damping * (carried_more - excess)
        disc = with_correction(coarse, correction, excess * coarse.scales.force)
        state = contact(disc, last if k + 1 == len(DAMPING) else loose, state)
        field = fine.field(state.traction, _friction(disc, state))
        forces.append(fine.forces(field))
        creepages.append(_creepages(disc, state))
        seconds.append(time.perf_counter() - begun)
    shift = fine.shift(field, state.rigid) * (field.bound > 0)
    return Corrected(disc, state, fine, field, shift, np.array(forces), np.array(creepages), tuple(seconds))


def late_change(of_passes: np.ndarray) -> np.ndarray:
    """How much late passes would have changed forces or creepages, (passes + 1, n), without damping: (n,)."""
    return np.asarray((np.abs(np.diff(of_passes, axis=0)) / DAMPING[:, None])[-LATE:].max(axis=0))


def with_correction(coarse: Discretisation, correction: np.ndarray, excess: np.ndarray) -> Discretisation:
    """The coarse problem with a correction of its rigid shift, (2, ny, nx), and of prescribed forces, (2,)."""
    motion = coarse.loading.motion
    assert isinstance(motion, Steady)
    given = zip((motion.Fx, motion.Fy), excess, strict=True)
    Fx, Fy = (None if force is None else float(force + more) for force, more in given)
    carried = PreviousStep(0.0 - correction, np.zeros(2))
    return coarse.with_loading(motion=replace(motion, Fx=Fx, Fy=Fy), previous_step=carried)


def _defect(coarse: Discretisation, state: ContactState, fine: FineGrid, field: FineField) -> np.ndarray:
    """What the elements' slip lacks of the continuum's under a field, in the contact, (2, ny, nx)."""
    own = coarse.known_shift + state.rigid[:, None, None] + coarse.tangential_operator.apply(state.traction)
    lacking = fine.on_elements(fine.shift(field, state.rigid), field.bound) - own
    bound = field.friction * fine.pressure
    return held_behind(lacking, state.traction, bound) * (bound > 0)


def _friction(disc: Discretisation, state: ContactState) -> np.ndarray:
    """Coefficients on the elements, (ny, nx); under a law those found, continued beyond the contact."""
    if disc.loading.law is not None:
        return continued(coefficient(disc, state), state.pressure > 0)
    return np.broadcast_to(np.asarray(disc.loading.coefficient, dtype=float), disc.grid.shape)


def _loads(disc: Discretisation, state: ContactState) -> np.ndarray:
    """Fx, Fy and Mz of the elements, physical."""
    return resultants(state.traction * disc.scales.pressure, disc.grid)


def _creepages(disc: Discretisation, state: ContactState) -> np.ndarray:
    """vx and vy, given or found."""
    assert disc.loading.motion is not None
    return np.asarray(disc.loading.motion.rigid[:2] + state.rigid / unit_slip(disc))
