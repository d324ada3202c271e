"""Batched tractions of contacts with known pressures."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import cast

import numpy as np

from varcontact.discrete.problems import RawSolution
from varcontact.elasticity.halfspace import HalfSpaces
from varcontact.scene.motion import Steady
from varcontact.solvers.batched.newton import solve_batch
from varcontact.solvers.batched.problem import BatchedProblem, side_by_side
from varcontact.solving.batched_on_grids import MOST_ELEMENTS
from varcontact.solving.contact_solver import record_answer
from varcontact.solving.on_grid import ContactOnGrid
from varcontact.system.process import changed, one_blas_thread
from varcontact.transports import DIFFERENCES

BATCHED = "side by side with other contacts, by newton"
"""Reason of a plan for Newton's method on a batch of contacts."""


@one_blas_thread()
def with_tractions_batched(contacts: Sequence[ContactOnGrid]) -> list[ContactOnGrid]:
    """Contacts in the given order; those that `_serves_batch` accepts have the tractions for their
    pressures.
    """
    batches: dict[str, list[int]] = {difference: [] for difference in DIFFERENCES}
    for k, contact in enumerate(contacts):
        motion = contact.disc.loading.motion
        if isinstance(motion, Steady) and _serves_batch(contact, motion):
            batches[motion.slip_difference].append(k)
    solved = list(contacts)
    for difference, numbers in batches.items():
        if not numbers:
            continue
        batch = _solve_batch([contacts[k] for k in numbers], difference)
        for k, contact in zip(numbers, batch, strict=True):
            solved[k] = contact
    return solved


def _solve_batch(contacts: list[ContactOnGrid], difference: str) -> list[ContactOnGrid]:
    """Contacts with tractions, where Newton's method converges."""
    from scipy.ndimage import find_objects

    # the elements in contact of each
    boxes = [find_objects((each.state.pressure > 0).astype(int))[0] for each in contacts]
    in_boxes = list(zip(contacts, boxes, strict=True))
    bounds = [(each.disc.coefficient * each.state.pressure)[box] for each, box in in_boxes]
    shifts = [each.disc.known_shift[:, *box] for each, box in in_boxes]
    starts = [each.state.traction[:, *box] for each, box in in_boxes]

    # one problem with given creepages
    dx, dy = np.array([each.disc.lattice.sides for each in contacts]).T
    media = [cast(HalfSpaces, each.disc.operators.medium) for each in contacts]
    nu = np.array([medium.nu for medium in media])
    force = np.full((2, len(contacts)), math.nan)
    problem = BatchedProblem(
        dx, dy, nu, side_by_side(shifts), side_by_side(bounds), force, difference
    )
    tol = contacts[0].solver.tol / 10
    batched = solve_batch(problem, tol, (side_by_side(starts), np.zeros_like(force)))

    # the tractions of each on its own grid
    solved = list(contacts)
    for j in np.flatnonzero(batched.converged).tolist():
        state = contacts[j].state
        traction = np.zeros_like(state.traction)
        ny, nx = traction[:, *boxes[j]].shape[1:]
        traction[:, *boxes[j]] = batched.traction[:, :ny, :nx, j]
        raw = RawSolution(
            traction,
            np.zeros(2),
            int(batched.iterations[j]),
            "Solved",
            solver="newton",
            reason=BATCHED,
        )
        state = changed(state, traction=traction, rigid=raw.rigid)
        solved[j] = changed(contacts[j], state=record_answer(state, "tangential", raw))
    return solved


def _serves_batch(contact: ContactOnGrid, motion: Steady) -> bool:
    """True for like half-spaces in steady rolling at given creepages, with coefficients of friction
    and few elements.
    """
    disc = contact.disc
    plan = contact.solver.plan
    if disc.implicit or disc.interface.flows:
        return False
    if not (motion.dq is motion.Fx is motion.Fy is None):
        return False
    if type(disc.operators.medium) is not HalfSpaces or disc.grid.edge != "centres":
        return False
    few = plan.solves and not disc.grid.line and disc.grid.size <= MOST_ELEMENTS
    finite = disc.coefficient is not None and bool(np.isfinite(disc.coefficient).all())
    return few and plan.coupling == "none" and finite
