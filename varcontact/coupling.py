"""Where the bodies differ, pressure and traction depend on each other (paper, sections 2 and 4.5)."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace

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
    status : dict
        The solvers' own words on the last pass, by problem.
    solved : dict
        What those mean, by problem: whether the solver says that it reached all it was asked for.
    changes : tuple of float
        Change of the tractions in each pass, by the largest traction.
    slips : bool ndarray, shape (ny, nx), optional
        The slip area where a theory tells it; otherwise the natural map does.
    """

    pressure: np.ndarray
    approach: float
    traction: np.ndarray
    rigid: np.ndarray
    iterations: dict[str, int] = field(default_factory=dict)
    status: dict[str, str] = field(default_factory=dict)
    solved: dict[str, bool] = field(default_factory=dict)
    changes: tuple[float, ...] = ()
    slips: np.ndarray | None = None


Step = Callable[[ContactState], ContactState]


def panagiotopoulos(
    start: ContactState, normal: Step, tangential: Step, tol: float, max_passes: int = 100
) -> ContactState:
    """Tangential problem with the pressure fixed, normal problem with the tractions fixed, until both stay.

    The paper's process (4.5), from the pressure without tractions; a single tangential problem would be
    Johnson's process (74). It stops when the tractions change by less than `tol`, when they stop falling,
    when a solver gives up twice in a row, or after `max_passes`; the certificate of the whole tells which.

    Parameters
    ----------
    start : ContactState
        With the pressure that goes with no tractions.
    normal, tangential : callable
        The two problems, from one state to the next.
    tol : float
        Change of the tractions to stop at, by the largest traction.
    max_passes : int
    """
    state, changes, failures = tangential(start), [1.0], 0
    for _ in range(max_passes):
        after = tangential(normal(state))
        size = max(float(np.abs(after.traction).max()), np.finfo(float).tiny)
        changes.append(float(np.abs(after.traction - state.traction).max()) / size)
        state = replace(after, changes=tuple(changes))
        failures = 0 if all(state.solved.values()) else failures + 1
        if changes[-1] < tol or failures == 2 or _stalled(changes):
            break
    return state


def _stalled(changes: list[float], passes: int = 8) -> bool:
    """Whether the last passes brought nothing: it circles, or the solvers are no more exact than this."""
    return len(changes) > 2 * passes and min(changes[-passes:]) >= min(changes[:-passes])
