"""Initial guesses: contacts of a similar scene, or on another grid."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from varcontact.discrete import contact_grid
from varcontact.discrete.discretisation import Discretisation
from varcontact.discrete.state import ContactState, unloaded
from varcontact.discrete.stick_slip import unit_slip
from varcontact.results.solution import Solution
from varcontact.scene.grid import Grid
from varcontact.system.process import changed


@dataclass(frozen=True, eq=False)
class InitialGuess:
    """Contact on a grid, physical, from which that on another grid begins."""

    grid: Grid
    pressure: np.ndarray
    approach: float
    traction: np.ndarray
    creepage: tuple[float, ...]

    @classmethod
    def of(cls, disc: Discretisation, state: ContactState) -> InitialGuess:
        scales = disc.scales
        motion = disc.loading.motion
        creepage = (0.0, 0.0) if motion is None else state.rigid / unit_slip(disc)
        return cls(
            disc.grid,
            pressure=state.pressure * scales.pressure,
            approach=state.approach * scales.displacement + disc.base,
            traction=state.traction * scales.pressure,
            creepage=tuple(creepage),
        )


def state_on(initial_guess: Solution | InitialGuess, disc: Discretisation) -> ContactState:
    """The pressure of a contact on another grid, and its approach where the scene gives none."""
    pressure = contact_grid.interpolated(
        initial_guess.grid, initial_guess.pressure[None], disc.grid
    )
    approach = disc.loading.approach
    if approach is None:
        approach = initial_guess.approach
    if np.isfinite(approach):
        approach = (approach - disc.base) / disc.scales.displacement
    else:
        approach = 0.0
    return changed(
        unloaded(disc.grid), pressure=pressure[0] / disc.scales.pressure, approach=approach
    )


def with_tractions_of(
    initial_guess: Solution | InitialGuess, disc: Discretisation, state: ContactState
) -> ContactState:
    """The state with the tractions of a contact on another grid; under a law of friction they
    choose no branch.
    """
    motion = disc.loading.motion
    if motion is None or disc.sought(by_slip=True):
        return state
    traction = contact_grid.interpolated(initial_guess.grid, initial_guess.traction, disc.grid)
    traction = traction / disc.scales.pressure
    rigid = np.nan_to_num(initial_guess.creepage[:2]) * unit_slip(disc)
    creepage_prescribed = [motion.Fx is None, motion.Fy is None]
    return changed(
        state,
        traction=traction * (state.pressure > 0),
        rigid=np.where(creepage_prescribed, 0.0, rigid),
    )
