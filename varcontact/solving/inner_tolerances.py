"""How exact a pass of a loop has to be: no more than the next one sees.

Methods without a matrix take as long as they are asked to be exact; active sets and programs are exact in any case, or
improved beyond what they are asked for. Coupling loops and laws of friction solve the same problems again and again,
each time from the last answer.
"""

from __future__ import annotations

import numpy as np

from varcontact.discrete.discretisation import Discretisation
from varcontact.discrete.state import ContactState
from varcontact.results.plan import Plan
from varcontact.solvers.registry import MATRIX_FREE

WHOLE = 0.1
"""Part of the tolerance at which passes end, and part of that to which the last of them are exact."""
FIRST, SEEN = 1e-3, 0.01
"""Residuals asked for: in the first pass, and by the residual of the whole after the pass before."""
EXACTEST = 1e-12
"""The least residual that is asked for."""


def in_passes(plan: Plan, disc: Discretisation) -> bool:
    """Whether the problems of a plan are solved again and again.

    Parameters
    ----------
    plan : Plan
    disc : Discretisation
    """
    return plan.loops or disc.loading.law is not None


def enough_pressure(plan: Plan, disc: Discretisation, state: ContactState, tol: float) -> float:
    """The residual to ask of pressures in a pass: tractions see their errors K by friction times as large.

    The first pressures, those without tractions, settle the grid, and are as exact as any.

    Parameters
    ----------
    plan : Plan
    disc : Discretisation
    state : ContactState
        Dimensionless, with the passes so far.
    tol : float
        Residual of the whole to be reached [-].
    """
    if not (plan.loops and state.passes and plan.normal in MATRIX_FREE):
        return tol
    rubbed = float(np.abs(state.traction).max()) / float(state.pressure.max())
    return max(_seen(state, tol) * min(1.0, rubbed / abs(disc.K)), EXACTEST)


def enough_traction(plan: Plan, disc: Discretisation, state: ContactState, tol: float) -> float:
    """The residual to ask of tractions in a pass.

    Under a law with two coefficients who slips once slips for good: there no pass may be rough.

    Parameters
    ----------
    plan : Plan
    disc : Discretisation
    state : ContactState
        Dimensionless, with the passes so far.
    tol : float
        Residual of the whole to be reached [-].
    """
    if not (plan.matrix_free and in_passes(plan, disc)):
        return tol
    if disc.loading.law is not None and not disc.loading.law.continuous:
        return WHOLE * WHOLE * tol
    return _seen(state, tol)


def _seen(state: ContactState, tol: float) -> float:
    """What the next pass sees, after the last one's residual."""
    return max(SEEN * state.passes[-1][1], WHOLE * WHOLE * tol) if state.passes else FIRST
