"""Where a contact state sticks and where it slips, and by how much."""

from __future__ import annotations

import numpy as np

from varcontact.problem.discretisation import Discretisation
from varcontact.problem.state import ContactState

EXTERIOR, STICK, SLIP = 0, 1, 2


def shift_and_areas(disc: Discretisation, state: ContactState) -> tuple[np.ndarray, np.ndarray]:
    """Local shift E in the contact (dimensionless), and 0, 1, 2 for exterior, stick, slip.

    An element slips where the natural map leaves the bound: ``|p - E/rho| > g``, true where traction is at the
    bound and slip opposes it.

    Parameters
    ----------
    disc : Discretisation
    state : ContactState

    Returns
    -------
    shift : ndarray, shape (2, ny, nx)
        Dimensionless, zero outside the contact.
    areas : ndarray of int8, shape (ny, nx)
    """
    contact = state.pressure > 0
    areas = contact.astype(np.int8)
    shift = np.zeros((2, *contact.shape))
    if disc.motion is None:
        return shift, areas
    shift[:] = disc.known_shift + state.rigid[:, None, None]
    if not disc.frictionless:
        shift += disc.shift_by_tractions(state.traction)
    if disc.K != 0:
        shift += disc.pressure_to_shift.apply(state.pressure[None])
    shift *= contact
    if state.slips is not None:
        areas[contact & state.slips] = SLIP
    elif not disc.no_slip:
        bound = np.asarray(disc.coefficient) * state.pressure
        trial = state.traction - shift / own_influence(disc)
        noise = 1e-12 * np.abs(trial).max()
        areas[contact & (np.hypot(*trial) > bound * (1 + 1e-8) + noise)] = SLIP
    return shift, areas


def own_influence(disc: Discretisation) -> float:
    """Mean of an element's influence on itself along x and y; any, where there is no traction to compare with.

    Parameters
    ----------
    disc : Discretisation

    Returns
    -------
    float
        Dimensionless.
    """
    return 1.0 if disc.frictionless else disc.tangential_operator.on(np.arange(1)).diagonal


def unit_slip(disc: Discretisation) -> float:
    """Dimensionless shift that is a relative slip of 1; in a shift, that is one unit of length.

    Parameters
    ----------
    disc : Discretisation
    """
    return (1.0 if disc.step is None else disc.step * disc.length) / disc.displacement
