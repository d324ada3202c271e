"""Pressure and tractions of unlike bodies by one Newton's method, before any passes."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from varcontact.discrete.discretisation import Discretisation
from varcontact.discrete.problems import RawSolution
from varcontact.discrete.state import ContactState
from varcontact.solvers.interface import Settings
from varcontact.solvers.newton.coupled import CoupledProblem, newton_coupled


def at_once(
    disc: Discretisation, state: ContactState, residual: Callable[[ContactState], float], settings: Settings
) -> ContactState:
    """The state with pressure and tractions that go with each other, or as it was where that fails.

    Parameters
    ----------
    disc : Discretisation
    state : ContactState
        Near that: with pressures, and the tractions under these.
    residual : callable
        Of the whole in a state.
    settings : Settings
    """
    tangential = disc.tangential_problem(state.pressure)
    if tangential.size == 0 or not np.any(state.traction):
        return state
    chosen = tangential.directions
    load = disc.loading.normal_force
    free = load is not None
    operators = disc.operators
    problem = CoupledProblem(
        normal=disc.operators.normal,
        traction_to_distance=operators.traction_to_distance.between((0,), chosen),
        pressure_to_shift=disc.pressure_to_shift.between(chosen, (0,)),
        tangential=disc.tangential_operator.between(chosen, chosen),
        distance=(disc.distance - disc.base) / disc.scales.displacement,
        rigid_shift=disc.known_shift[list(chosen)],
        friction=np.broadcast_to(np.asarray(disc.loading.coefficient, dtype=float), disc.grid.shape),
        area=disc.lattice.area,
        approach=None if free else state.approach,
        force=(None if load is None else load / disc.scales.force, *tangential.force),
    )

    def found(raw: RawSolution) -> ContactState:
        traction, rigid = np.zeros((2, *disc.grid.shape)), np.zeros(2)
        traction[list(chosen)], rigid[list(chosen)] = raw.traction[1:], raw.rigid[1:]
        approach = -float(raw.rigid[0]) if free else state.approach
        return replace(state, pressure=raw.traction[0], approach=approach, traction=traction, rigid=rigid)

    level = np.concatenate([[-state.approach if free else 0.0], state.rigid[list(chosen)]])
    fields = np.concatenate([state.pressure[None], state.traction[list(chosen)]])
    start = RawSolution(fields, level, 0, "start")
    with settings.stats.called("newton"):
        raw = newton_coupled(problem, settings, start, lambda raw: residual(found(raw)))
        settings.stats.iterated("newton", raw.iterations)
    counted = {**state.iterations, "both": state.iterations.get("both", 0) + raw.iterations}
    finite = np.isfinite(raw.traction).all() and np.isfinite(raw.rigid).all() and np.any(raw.traction[0])
    better = finite and (raw.solved or residual(found(raw)) < residual(state))
    return replace(found(raw) if better else state, iterations=counted)
