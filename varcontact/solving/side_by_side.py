"""Contacts with any pressure: their tractions are solved for side by side."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from varcontact.discrete.problems import RawSolution
from varcontact.elasticity.halfspace import HalfSpaces
from varcontact.scene.motion import Steady
from varcontact.solvers.batched.newton import solve_batch
from varcontact.solvers.batched.problem import BatchedProblem
from varcontact.solving.batch import MOST_ELEMENTS
from varcontact.solving.contact_solver import answered
from varcontact.solving.on_grid import ContactOnGrid
from varcontact.system.process import one_blas_thread
from varcontact.transports import DIFFERENCES

BESIDE = "side by side with other contacts, by newton"


@one_blas_thread()
def settled_together(contacts: Sequence[ContactOnGrid]) -> list[ContactOnGrid]:
    """The contacts, those that `_rolls_alike` tells with the tractions of their pressures, solved
    for side by side.
    """
    from scipy.ndimage import find_objects

    found = list(contacts)
    alike = [k for k, each in enumerate(contacts) if _rolls_alike(each)]
    for difference in DIFFERENCES:
        some = [
            k
            for k in alike
            if getattr(contacts[k].disc.loading.motion, "slip_difference", "") == difference
        ]
        if not some:
            continue
        discs, states = ([getattr(contacts[k], name) for k in some] for name in ("disc", "state"))
        boxes = [find_objects((state.pressure > 0).astype(int))[0] for state in states]
        shape = np.max(
            [state.pressure[box].shape for state, box in zip(states, boxes, strict=True)], axis=0
        )
        bound = np.zeros((*shape, len(some)))
        shift, start = np.zeros((2, 2, *bound.shape))
        for j, (disc, state, box) in enumerate(zip(discs, states, boxes, strict=True)):
            pressed = (disc.loading.coefficient * state.pressure)[box]
            here = np.s_[: pressed.shape[0], : pressed.shape[1], j]
            bound[here] = pressed
            shift[:, *here] = disc.known_shift[:, *box]
            start[:, *here] = state.traction[:, *box]
        dx, dy = np.array([disc.lattice.sides for disc in discs]).T
        nu = np.array([disc.operators.medium.nu for disc in discs])
        tol = contacts[some[0]].solver.tol / 10
        free = np.full((2, len(some)), math.nan)
        problem = BatchedProblem(dx, dy, nu, shift, bound, free, difference)
        answer = solve_batch(problem, tol, (start, np.zeros_like(free)))
        for j in np.flatnonzero(answer.converged).tolist():
            traction = np.zeros_like(states[j].traction)
            ny, nx = traction[:, *boxes[j]].shape[1:]
            traction[:, *boxes[j]] = answer.traction[:, :ny, :nx, j]
            count = int(answer.iterations[j])
            raw = RawSolution(
                traction, np.zeros(2), count, "Solved", solver="newton", reason=BESIDE
            )
            state = replace(
                states[j],
                traction=traction,
                rigid=raw.rigid,
                **answered(states[j], "tangential", raw),
            )
            found[some[j]] = replace(contacts[some[j]], state=state)
    return found


def _rolls_alike(contact: ContactOnGrid) -> bool:
    """Whether like half-spaces roll steadily at given creepages, under coefficients, and few
    elements touch.
    """
    disc = contact.disc
    plan = contact.solver.plan
    loading = disc.loading
    motion = disc.loading.motion
    if not (
        isinstance(motion, Steady)
        and motion.dq is motion.Fx is motion.Fy is None
        and loading.law is None
    ):
        return False
    plain = (
        type(disc.operators.medium) is HalfSpaces
        and loading.layer is None
        and disc.grid.edge == "centres"
    )
    few = plan.solves and not disc.grid.line and disc.grid.size <= MOST_ELEMENTS
    finite = loading.coefficient is not None and bool(np.isfinite(loading.coefficient).all())
    return plain and few and plan.coupling == "none" and finite
