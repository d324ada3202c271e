"""Balance of the loads of wheel sets: by the fast way, and then with a few exact solutions.

Derivatives are the fast way's; Broyden's method corrects these from one exact solution to the next.
Exact derivatives at the start save none or one of the four to six exact solutions, and cost more.
"""

from __future__ import annotations

import math
import warnings
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np

from varcontact.errors import NoContact, NotConverged, PlausibilityWarning, SceneError
from varcontact.scene.plausibility import warn_plausibility
from varcontact.solving.options import CertifyName
from varcontact.theories.creep_forces import TheoryName
from varcontact.wheel_rail.bearing_height import JUMP_MAX
from varcontact.wheel_rail.equilibrium import STEP, BroydenIterate, LoadBalance, Solver, broyden
from varcontact.wheel_rail.equilibrium_search import (
    BEGINNING,
    ROUGH,
    FastTheories,
    Search,
    balanced_wheels,
    unbalanced,
    warn_unbalanced,
)
from varcontact.wheel_rail.plausibility import warnings_of
from varcontact.wheel_rail.result import WheelForces, WheelRailSolution
from varcontact.wheel_rail.solve import TARGETS
from varcontact.wheel_rail.wheel_geometry import ELEMENT
from varcontact.wheel_rail.wheel_on_rail import WheelOnRail
from varcontact.wheel_rail.wheel_set_loads import LoadedWheelSet
from varcontact.wheel_rail.wheel_set_solution import WheelSetSolution

CHOSEN_GRID_TOL = 1e-4
"""Least tolerance of the imbalance where grids are chosen for an accuracy: forces then jump by a
part of their error bars."""
LARGEST_CONDITION = 1e10
"""Condition number of the derivatives above which the unknowns cannot balance the loads."""
AGAIN = 2.0
"""Largest growth of the imbalance as wheels are solved again, by rounding of their solvers."""
JUMPS = "forces jump there, as elements come into contact; those of smaller elements jump less"
"""Why exact solutions do not balance the loads to the tolerance."""
ROUNDS = 20
"""Largest number of steps with exact solutions."""
FIRST_SIDEWAYS = 1.0
"""First step sideways to a bracket of the lateral force, in units of the displacement."""
STEPS_SIDEWAYS = 7
"""Largest number of sideways steps, each twice the one before: 13 mm in all."""
ROUNDING_SIDEWAYS = 1e-9
"""Length of the bracket, in units of the displacement, below which it contains only a jump."""


class _Exact:
    """Exact solutions of wheels, each side started from its previous one; `entries` of the wheels
    are replaced.
    """

    def __init__(self, methods: dict[str, Any], **entries: Any) -> None:
        self._methods = methods
        self._entries = entries
        self._last: dict[str, WheelRailSolution] = {}

    def __call__(self, wheel: WheelOnRail) -> WheelForces:
        before = self._last.get(wheel.side)
        wheel = replace(wheel, **self._entries)
        # plane or curved surface is chosen once: forces jump where the choice changes
        if before is not None:
            wheel = wheel.with_surface_of(before.case)
        methods = self._methods
        # solves on grids chosen for an accuracy start afresh
        if wheel.dx is not None or wheel.dy is not None:
            methods = {"start": before} | methods
        self._last[wheel.side] = wheel.solve(**methods)
        return self._last[wheel.side]


def solve_wheel_set(
    case: LoadedWheelSet, tol: float, certify: CertifyName | None, methods: dict[str, Any]
) -> WheelSetSolution:
    """See `WheelSetOnTrack.solve`."""
    warn_plausibility(warnings_of(case))
    # the balance by the fast way
    fast = FastTheories(kinetic=True)
    balance, x = Search(case, fast, BEGINNING).found()
    derivatives = _derivatives(balance, x, fast)
    # exact solutions; grids that are chosen for an accuracy come last
    solvers = [_Exact(methods | {"certify": certify})]
    if x.size and case.dx is None and case.dy is None:
        tol = max(tol, CHOSEN_GRID_TOL)
        on_usual_grid = {name: value for name, value in methods.items() if name not in TARGETS}
        solvers.insert(0, _Exact(on_usual_grid, dx=ELEMENT, dy=ELEMENT))
    solved = 0
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        for solver in solvers if x.size else ():
            x, rounds = _corrected(balance, x, derivatives, solver, tol)
            solved += rounds
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", PlausibilityWarning)  # of each wheel
        found = _solution(balance, x, solvers[-1], solved, np.linalg.inv(derivatives))
    _warn_of_patches(found)
    warn_unbalanced(found.imbalance, AGAIN * tol, JUMPS)
    return found


def _warn_of_patches(found: WheelSetSolution) -> None:
    """Plausibility warnings of the patches of both wheels, each once."""
    texts = (text for each in found.wheels for text in each.patch_warnings)
    warn_plausibility(dict.fromkeys(texts))


def _derivatives(balance: LoadBalance, x: np.ndarray, fast: FastTheories) -> np.ndarray:
    """Derivatives of the imbalance, by fast theories."""
    columns = []
    for step in STEP * np.eye(x.size):
        behind = balance.imbalance(balance.wheels(x - step, fast))
        ahead = balance.imbalance(balance.wheels(x + step, fast))
        columns.append((ahead - behind) / (2 * STEP))
    derivatives = np.array(columns).reshape(x.size, x.size).T
    # as where friction is saturated
    if x.size and np.linalg.cond(derivatives) > LARGEST_CONDITION:
        missing = balance.imbalance(balance.wheels(x, fast))
        raise NotConverged(unbalanced(balance, missing), float(np.abs(missing).max()))
    return derivatives


def _corrected(
    balance: LoadBalance, x: np.ndarray, derivatives: np.ndarray, solver: Solver, tol: float
) -> tuple[np.ndarray, int]:
    """The unknowns at which exact solutions are balanced, and the number of solutions of both
    wheels.
    """
    solved = 0

    def imbalance(x: np.ndarray) -> np.ndarray:
        nonlocal solved
        solved += 1
        return balance.imbalance(balance.wheels(x, solver))

    at = broyden(imbalance, x, tol, ROUNDS, derivatives)
    if at.largest > tol and "y" in balance.names:
        start = BroydenIterate(x, imbalance(x), derivatives)
        held = _HeldSideways(imbalance, balance.names.index("y"), start, tol)
        at = _moved_sideways(held) or at
    if at.largest > max(tol, JUMP_MAX):
        raise NotConverged(unbalanced(balance, at.imbalance), at.largest)
    return at.x, solved


class _HeldSideways:
    """A wheel set held at one displacement after the other, where the other loads are balanced."""

    def __init__(
        self,
        imbalance: Callable[[np.ndarray], np.ndarray],
        y: int,
        start: BroydenIterate,
        tol: float,
    ) -> None:
        assert start.derivatives is not None
        self.at = start
        self.y = y
        self._imbalance = imbalance
        self._others = np.delete(np.arange(start.x.size), y)
        self._derivatives: np.ndarray | None = start.derivatives[np.ix_(self._others, self._others)]
        self._tol = tol

    def missing(self, y: float) -> float:
        """Unbalanced lateral force at a displacement; 0 within the tolerance."""
        x = self.at.x.copy()
        x[self.y] = y
        held = broyden(
            partial(self._of_others, x), x[self._others], self._tol / 2, ROUNDS, self._derivatives
        )
        if held.largest > self._tol / 2:
            raise NotConverged("the other loads are not balanced", held.largest)
        x[self._others] = held.x
        self.at = BroydenIterate(x, self._imbalance(x), None)
        self._derivatives = held.derivatives
        # unknowns and their loads have the same numbers
        lateral = float(self.at.imbalance[self.y])
        return lateral if abs(lateral) > self._tol else 0.0

    def _of_others(self, x: np.ndarray, others: np.ndarray) -> np.ndarray:
        moved = x.copy()
        moved[self._others] = others
        return self._imbalance(moved)[self._others]


def _moved_sideways(held: _HeldSideways) -> BroydenIterate | None:
    """The balance with the displacement bracketed; None where the other loads are not balanced.

    To the right rails push ever more to the left, but on treads by so little that elements rule the
    derivatives. Steps begin where the fast way has the balance, and are those of the mirror image.
    """
    from scipy.optimize import brentq

    y = float(held.at.x[held.y])
    try:
        missing = held.missing(y)
        step = math.copysign(FIRST_SIDEWAYS, missing)
        for _ in range(STEPS_SIDEWAYS):
            if missing == 0:
                break
            after = held.missing(y + step)
            if missing * after < 0:
                brentq(held.missing, y, y + step, xtol=ROUNDING_SIDEWAYS)
                break
            y += step
            missing = after
            step *= 2
    except (NoContact, NotConverged, SceneError):
        return None
    return held.at


def estimate_wheel_set(
    case: LoadedWheelSet, normal: str, tangential: TheoryName, tol: float, options: dict[str, Any]
) -> WheelSetSolution:
    """See `WheelSetOnTrack.estimate`."""
    warn_plausibility(warnings_of(case))
    fast = FastTheories(normal, tangential, tuple(options.items()))
    balance, x = Search(case, fast, ROUGH).found()
    estimate = _solution(balance, x, fast, 0, None)
    warn_unbalanced(estimate.imbalance, tol)
    _warn_of_patches(estimate)
    return estimate


def _solution(
    balance: LoadBalance, x: np.ndarray, solver: Solver, solved: int, inverse: np.ndarray | None
) -> WheelSetSolution:
    """The wheels at the balance; errors of forces there are errors of the unknowns."""
    left, right = balanced_wheels(balance, x, solver)
    imbalance = float(np.abs(balance.imbalance((left, right))).max(initial=0.0))
    errors = dict.fromkeys(balance.names, math.nan)
    if inverse is not None:
        errors = balance.errors(left, right, inverse)
    return WheelSetSolution(
        balance.case, left.z, left.patches + right.patches, left, right, imbalance, solved, errors
    )
