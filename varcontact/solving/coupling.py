"""Where the bodies differ, pressure and traction depend on each other (paper, sections 2 and 4.5).

Johnson's process is a single pass: the pressure without tractions, then the tractions. The two loops here repeat
passes until the whole is solved. Both are fixed points, Panagiotopoulos's of the tractions, the joint one of the
traction bound; where a fixed point is approached slowly or not at all, Anderson's acceleration takes over.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np

from varcontact.errors import Saturated, VarcontactError


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
    solved_by : dict
        Whose answer it is, by problem, on the last pass.
    reasons : dict
        By problem, why that is another solver than the plan's, where there was no choice; else empty words.
    passes : tuple of (float, float)
        Of each pass of a coupling loop: its change, and the residual of the whole after it.
    bearing : ndarray, shape (ny, nx), optional
        The pressure that the traction bound counts with, where that is not `pressure`: within a joint pass.
    slips : bool ndarray, shape (ny, nx), optional
        The slip area where a theory tells it; otherwise the natural map does.
    friction : ndarray, shape (ny, nx), optional
        Under a law of friction: the coefficient of the next pass.
    branch : str
        Under a law of friction: where the search began.
    """

    pressure: np.ndarray
    approach: float
    traction: np.ndarray
    rigid: np.ndarray
    iterations: dict[str, int] = field(default_factory=dict)
    status: dict[str, str] = field(default_factory=dict)
    solved: dict[str, bool] = field(default_factory=dict)
    solved_by: dict[str, str] = field(default_factory=dict)
    reasons: dict[str, str] = field(default_factory=dict)
    passes: tuple[tuple[float, float], ...] = ()
    bearing: np.ndarray | None = None
    slips: np.ndarray | None = None
    friction: np.ndarray | None = None
    branch: str = ""


Step = Callable[[ContactState], ContactState]
Judge = Callable[[ContactState], float]

MEMORY, SLOW, PATIENCE = 5, 0.2, 12
"""Passes that the acceleration looks back; the least gain of a pass without it; passes without gain before the end."""


def panagiotopoulos(
    start: ContactState, normal: Step, tangential: Step, residual: Judge, tol: float, max_passes: int = 100
) -> ContactState:
    """Normal problem with the tractions fixed, tangential problem with the pressure fixed, until both stay.

    The paper's process (4.5), from the pressure without tractions.

    Parameters
    ----------
    start : ContactState
        With the pressure that goes with its tractions, or with none.
    normal, tangential : callable
        The two problems, from one state to the next.
    residual : callable
        Natural-map residual of the whole in a state.
    tol : float
        Residual to stop at.
    max_passes : int

    Returns
    -------
    ContactState
        That of the least residual; `passes` tells how it went.
    """

    def one_pass(state: ContactState) -> ContactState:
        return tangential(normal(state))

    def with_traction(state: ContactState, traction: np.ndarray) -> ContactState:
        return replace(state, traction=traction)

    return fixed_point(
        tangential(start), one_pass, lambda state: state.traction, with_traction, residual, tol, max_passes
    )


def joint(start: ContactState, together: Step, residual: Judge, tol: float, max_passes: int = 100) -> ContactState:
    """Pressure and tractions together with the traction bound fixed, until that stays.

    Parameters
    ----------
    start : ContactState
        With the pressure without tractions, which gives the first bound.
    together : callable
        Pressure and tractions under the bound that `bearing` gives.
    residual, tol, max_passes
        As in `panagiotopoulos`.
    """

    def one_pass(state: ContactState) -> ContactState:
        return replace(together(replace(state, bearing=state.pressure)), bearing=None)

    def with_pressure(state: ContactState, pressure: np.ndarray) -> ContactState:
        return replace(state, pressure=np.maximum(pressure, 0.0))

    return fixed_point(
        one_pass(start), one_pass, lambda state: state.pressure, with_pressure, residual, tol, max_passes
    )


def alternating(start: ContactState, normal: Step, tangential: Step, tol: float, max_passes: int = 50) -> ContactState:
    """A joint pass by alternation: both problems in turn under a fixed bound.

    In a shift that is block descent of the complementary energy, which is convex, and converges.
    """
    state = tangential(start)
    for _ in range(max_passes):
        after = tangential(normal(state))
        change = _distance(after.traction, state.traction)
        state = after
        if change <= tol:
            break
    return state


def fixed_point(
    state: ContactState,
    one_pass: Step,
    field_of: Callable[[ContactState], np.ndarray],
    with_field: Callable[[ContactState, np.ndarray], ContactState],
    residual: Judge,
    tol: float,
    max_passes: int,
    patience: int = PATIENCE,
    plain: int = 0,
    near: float = 0.0,
) -> ContactState:
    """Repeat a pass from one field to the next; the state of the least residual.

    It ends at the tolerance, where `patience` passes brought nothing, where solvers give up twice in a row with nothing
    gained or altogether, or after `max_passes`. In the first `plain` passes nothing is accelerated before the residual
    is below `near`, and until then a force that friction cannot carry is an error.
    """
    best = state = replace(state, passes=((1.0, residual(state)),))
    given: list[np.ndarray] = []
    found: list[np.ndarray] = []
    lost, failures, accelerated = 0, 0, False
    while best.passes[-1][1] > tol and len(state.passes) < max_passes and lost < patience and failures < 2:
        try:
            after = one_pass(state)
        except VarcontactError as error:  # an iterate that is no contact any more
            if isinstance(error, Saturated) and len(state.passes) <= plain and not accelerated:
                raise
            break
        given, found = [*given[-MEMORY:], field_of(state)], [*found[-MEMORY:], field_of(after)]
        step = (_distance(found[-1], given[-1]), residual(after))
        after = replace(after, passes=(*state.passes, step))
        gained = step[1] < best.passes[-1][1]
        best, lost = (after, 0) if gained else (best, lost + 1)
        failures = 0 if gained or all(after.solved.values()) else failures + 1
        ready = len(state.passes) > plain or step[1] < near
        accelerated = accelerated or (ready and not step[1] < SLOW * state.passes[-1][1])
        state = with_field(after, _mixed(given, found)) if accelerated else after
    return replace(best, passes=state.passes)


def _mixed(given: list[np.ndarray], found: list[np.ndarray]) -> np.ndarray:
    """Anderson's acceleration: the combination of what was found whose own combination of changes is least."""
    changes = np.array([(y - x).ravel() for x, y in zip(given, found, strict=True)])
    if len(changes) == 1:
        return found[-1]
    weights, *_ = np.linalg.lstsq(np.diff(changes, axis=0).T, changes[-1], rcond=1e-10)
    steps = np.diff(np.array(found), axis=0)
    return np.asarray(found[-1] - np.tensordot(weights, steps, axes=1))


def _distance(one: np.ndarray, other: np.ndarray) -> float:
    """Largest difference of two fields by the largest of the first."""
    size = max(float(np.abs(one).max()), np.finfo(float).tiny)
    return float(np.abs(one - other).max()) / size
