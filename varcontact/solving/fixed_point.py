"""Passes repeated until one of the fields no longer changes, accelerated where they converge slowly."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from varcontact.discrete.state import ContactState
from varcontact.errors import Saturated, VarcontactError

Step = Callable[[ContactState], ContactState]
Judge = Callable[[ContactState], float]

SLOW = 0.2
"""A pass that leaves more than this part of the residual is slow: from then on passes are accelerated."""
HELD = 15
"""Accelerated passes in a row without gain after which passes stay plain: where two solutions have just vanished,
acceleration would hold them there."""


@dataclass(frozen=True)
class Unknown:
    """The field of a state that goes into a pass and comes out of it, and the values that it may have.

    Attributes
    ----------
    name : str
        Of the field, as `ContactState` has it.
    least, greatest : float
        In the unit of the field.
    """

    name: str
    least: float = -np.inf
    greatest: float = np.inf

    def of(self, state: ContactState) -> np.ndarray:
        """Its values in a state.

        Parameters
        ----------
        state : ContactState

        Returns
        -------
        ndarray
            In the shape and unit of the field.
        """
        return np.asarray(getattr(state, self.name))

    def put(self, state: ContactState, values: np.ndarray) -> ContactState:
        """The state with other values of it, cut off at the least and the greatest.

        Parameters
        ----------
        state : ContactState
        values : ndarray
            In the shape and unit of the field.
        """
        return replace(state, **{self.name: np.clip(values, self.least, self.greatest)})


@dataclass(frozen=True)
class Limits:
    """When passes end, and from when on they may be accelerated.

    Attributes
    ----------
    tol : float
        Residual to stop at.
    passes : int
        The most there may be.
    patience : int
        Passes in a row without gain after which they end.
    plain : int
        Passes in which nothing is accelerated before the residual is below `near`; a force that friction cannot carry
        is an error in them.
    near : float
    """

    tol: float
    passes: int = 100
    patience: int = 12
    plain: int = 0
    near: float = 0.0


class _Anderson:
    """Anderson's acceleration of a fixed point (D. G. Anderson, J. ACM 12 (1965) 547-560), with a limited memory."""

    def __init__(self, memory: int = 6) -> None:
        self._memory = memory
        self._given: list[np.ndarray] = []
        self._found: list[np.ndarray] = []

    def remember(self, given: np.ndarray, found: np.ndarray) -> None:
        """What went into a pass, and what came out."""
        self._given = [*self._given, given][-self._memory :]
        self._found = [*self._found, found][-self._memory :]

    def mixed(self) -> np.ndarray:
        """The combination of found values for which the same combination of changes is smallest."""
        given, found = np.array(self._given), np.array(self._found)
        if len(found) == 1:
            return np.asarray(found[-1])
        changes = (found - given).reshape(len(found), -1)
        weights, *_ = np.linalg.lstsq(np.diff(changes, axis=0).T, changes[-1], rcond=1e-10)
        return np.asarray(found[-1] - np.tensordot(weights, np.diff(found, axis=0), axes=1))


def fixed_point(state: ContactState, one_pass: Step, unknown: Unknown, residual: Judge, limits: Limits) -> ContactState:
    """Repeat a pass from one value of the unknown field to the next.

    It ends at the tolerance, where passes bring nothing any more, where solvers give up twice in a row with nothing
    gained or altogether, or after the most passes.

    Parameters
    ----------
    state : ContactState
        After the first pass.
    one_pass : callable
        From one state to the next.
    unknown : Unknown
        The field by which a pass depends on the one before.
    residual : callable
        Natural-map residual of the whole in a state.
    limits : Limits

    Returns
    -------
    ContactState
        That of the least residual; its `passes` tells how all went.
    """
    best = state = replace(state, passes=((1.0, residual(state)),))
    lost, failures, held, accelerated, anderson = 0, 0, 0, False, _Anderson()
    while (
        best.passes[-1][1] > limits.tol
        and len(state.passes) < limits.passes
        and lost < limits.patience
        and failures < 2
    ):
        try:
            after = one_pass(state)
        except VarcontactError as error:  # an iterate that is no contact any more
            if isinstance(error, Saturated) and len(state.passes) <= limits.plain and not accelerated:
                raise
            break
        given, found = unknown.of(state), unknown.of(after)
        anderson.remember(given, found)
        step = (distance(found, given), residual(after))
        after = replace(after, passes=(*state.passes, step))
        gained = step[1] < best.passes[-1][1]
        best, lost = (after, 0) if gained else (best, lost + 1)
        failures = 0 if gained or all(after.solved.values()) else failures + 1
        ready = len(state.passes) > limits.plain or step[1] < limits.near
        held = 0 if gained and held < HELD else held + accelerated
        accelerated = held < HELD and (accelerated or (ready and not step[1] < SLOW * state.passes[-1][1]))
        state = unknown.put(after, anderson.mixed()) if accelerated else after
    return replace(best, passes=state.passes)


def distance(one: np.ndarray, other: np.ndarray) -> float:
    """Largest difference of two fields by the largest of the first.

    Parameters
    ----------
    one, other : ndarray
        In one shape and unit.

    Returns
    -------
    float
        [-]
    """
    size, apart = float(np.abs(one).max()), float(np.abs(one - other).max())
    return apart / max(size, apart * np.finfo(float).eps, np.finfo(float).tiny)  # of nothing, not beyond all numbers
