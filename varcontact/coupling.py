"""Where the bodies differ, pressure and traction depend on each other (paper, sections 2 and 4.5)."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np


@dataclass(frozen=True, eq=False)
class ContactState:
    """Pressures and tractions on the whole grid, dimensionless.

    Attributes
    ----------
    pressure : ndarray, shape (ny, nx)
    approach : float
    traction : ndarray, shape (2, ny, nx)
    rigid : ndarray, shape (2,)
        Uniform rigid shift where a force is prescribed, else 0.
    iterations : dict
        Solver iterations by problem, summed over the passes.
    changes : tuple of float
        Change of the tractions in each pass, by the largest traction.
    """

    pressure: np.ndarray
    approach: float
    traction: np.ndarray
    rigid: np.ndarray
    iterations: dict[str, int] = field(default_factory=dict)
    changes: tuple[float, ...] = ()


NormalStep = Callable[[ContactState], ContactState]
TangentialStep = Callable[[ContactState], ContactState]


def johnson(start: ContactState, normal: NormalStep, tangential: TangentialStep) -> ContactState:
    """Normal problem without tractions, then the tangential problem: once (74)."""
    return tangential(normal(start))


def panagiotopoulos(
    start: ContactState, normal: NormalStep, tangential: TangentialStep, tol: float, max_passes: int = 100
) -> ContactState:
    """Normal problem with the tractions fixed, tangential problem with the pressure fixed, until both stay.

    The paper's process (4.5), with a pass counted as one of each. It stops when the tractions change by less
    than `tol`, or after `max_passes`; the certificate of the whole tells which.
    """
    state = start
    changes: list[float] = []
    for _ in range(max_passes):
        after = tangential(normal(state))
        size = max(float(np.abs(after.traction).max()), np.finfo(float).tiny)
        changes.append(float(np.abs(after.traction - state.traction).max()) / size)
        state = ContactState(
            after.pressure, after.approach, after.traction, after.rigid, after.iterations, tuple(changes)
        )
        if changes[-1] < tol:
            break
    return state
