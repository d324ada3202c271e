"""Wheel sets whose loads are balanced: found by the fast way, and then with a few exact solutions.

Derivatives are the fast way's; Broyden's method corrects these from one exact solution to the next.
"""

from __future__ import annotations

import math
import warnings
from dataclasses import replace
from typing import Any

import numpy as np

from varcontact.errors import NotConverged, PlausibilityWarning, SceneError
from varcontact.scene.plausibility import warn
from varcontact.solving.options import CertifyName
from varcontact.theories.creep_forces import TheoryName
from varcontact.wheel_rail.equilibrium import STEP, Balance, Solver, broyden
from varcontact.wheel_rail.equilibrium_search import FastWay, Search, unbalanced
from varcontact.wheel_rail.plausibility import doubts
from varcontact.wheel_rail.result import WheelForces, WheelRailSolution
from varcontact.wheel_rail.solve import TARGETS
from varcontact.wheel_rail.wheel_geometry import ELEMENT
from varcontact.wheel_rail.wheel_on_rail import WheelOnRail
from varcontact.wheel_rail.wheel_set import WheelSetOnTrack
from varcontact.wheel_rail.wheel_set_solution import WheelSetSolution

NEAR = 1e-4
"""Least imbalance where grids are chosen for an accuracy, whose forces jump by a part of their
error bars."""
PRESSED = 0.02
"""Step to a greater depth, by the depth, at which a wheel must be borne by more."""
FLAT = 1e10
"""Condition of derivatives above which loads are not balanced by the unknowns."""
ROUNDS = 20
"""Steps with exact solutions."""


class _Exact:
    """Exact solutions of wheels, each side from the one before; `entries` of wheels are
    replaced.
    """

    def __init__(self, methods: dict[str, Any], **entries: Any) -> None:
        self._methods, self._entries = methods, entries
        self._last: dict[str, WheelRailSolution] = {}

    def __call__(self, wheel: WheelOnRail) -> WheelForces:
        before = self._last.get(wheel.side)
        wheel = replace(wheel, **self._entries)
        # chosen once: forces jump where that changes
        if before is not None and wheel.conformal == "auto":
            wheel = replace(wheel, conformal=before.case.conformal is True)
        on_elements = wheel.dx is not None or wheel.dy is not None
        # grids that are chosen for an accuracy start afresh
        start = {"start": before} if on_elements else {}
        self._last[wheel.side] = wheel.solve(**start | self._methods)
        return self._last[wheel.side]


def solve_wheel_set(
    case: WheelSetOnTrack, tol: float, certify: CertifyName | None, methods: dict[str, Any]
) -> WheelSetSolution:
    """See `WheelSetOnTrack.solve`."""
    warn(doubts(case), stacklevel=4)
    near = FastWay(kinetic=True)
    balance, x = Search(case, near).found()
    solvers = [_Exact(methods | {"certify": certify})]
    if x.size and case.dx is None and case.dy is None:
        # grids that are chosen for an accuracy come last
        tol = max(tol, NEAR)
        usual = {name: value for name, value in methods.items() if name not in TARGETS}
        solvers.insert(0, _Exact(usual, dx=ELEMENT, dy=ELEMENT))
    derivatives, solved = _derivatives(balance, x, near), 0
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        for solver in solvers if x.size else ():
            x, rounds = _corrected(balance, x, derivatives, solver, tol)
            solved += rounds
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", PlausibilityWarning)  # of each wheel
        found = _solution(balance, x, solvers[-1], solved, np.linalg.inv(derivatives))
    wheels = [each for each in found.wheels if isinstance(each, WheelRailSolution)]
    warn(dict.fromkeys(text for each in wheels for text in each.patch_doubts), stacklevel=4)
    return found


def _derivatives(balance: Balance, x: np.ndarray, near: FastWay) -> np.ndarray:
    """Of the imbalance, by the fast way."""
    columns = []
    for step in STEP * np.eye(x.size):
        behind, ahead = (
            balance.imbalance(balance.wheels(place, near)) for place in (x - step, x + step)
        )
        columns.append((ahead - behind) / (2 * STEP))
    derivatives = np.array(columns).reshape(x.size, x.size).T
    if x.size and np.linalg.cond(derivatives) > FLAT:  # as where friction is saturated
        missing = balance.imbalance(balance.wheels(x, near))
        raise NotConverged(unbalanced(balance, missing), float(np.abs(missing).max()))
    return derivatives


def _corrected(
    balance: Balance, x: np.ndarray, derivatives: np.ndarray, solver: Solver, tol: float
) -> tuple[np.ndarray, int]:
    """The unknowns at which exact solutions are balanced, and how often both wheels were solved."""
    solved = 0

    def imbalance(x: np.ndarray) -> np.ndarray:
        nonlocal solved
        solved += 1
        return balance.imbalance(balance.wheels(x, solver))

    at = broyden(imbalance, x, tol, ROUNDS, derivatives)
    if at.largest > tol:
        raise NotConverged(unbalanced(balance, at.imbalance), at.largest)
    return at.x, solved


def estimate_wheel_set(
    case: WheelSetOnTrack, normal: str, tangential: TheoryName, tol: float, options: dict[str, Any]
) -> WheelSetSolution:
    """See `WheelSetOnTrack.estimate`."""
    way = FastWay(normal, tangential, tuple(options.items()))
    balance, x = Search(case, way).found()
    found = _solution(balance, x, way, 0, None)
    if found.imbalance > tol:
        words = f"loads are balanced to {found.imbalance:.2g} only: forces of the fast way jump where patches join"
        warnings.warn(words, stacklevel=4)
    return found


def _solution(
    balance: Balance, x: np.ndarray, solver: Solver, solved: int, inverse: np.ndarray | None
) -> WheelSetSolution:
    """The wheels at the balance; errors of forces there are errors of what was found."""
    case, wheels = balance.case, balance.wheels(x, solver)
    for each in wheels:
        if each.case.touching >= each.z:
            if "roll" not in case.free:
                roll = case.position.roll
                reason = f"with roll = {roll:.4g} the {each.case.side} wheel is above its rail; add roll to free"
                raise SceneError("position.roll", roll, message=reason)
            reason = (
                f"the loads lift the {each.case.side} wheel off its rail: no position bears them"
            )
            raise SceneError("roll_moment", case.roll_moment, message=reason)
        deeper = replace(each.case, z=each.z + PRESSED * balance.depth)
        near = FastWay(kinetic=True)
        if near(deeper).force[2] < near(each.case).force[2]:
            reason = f"the {each.case.side} wheel is wedged: friction lifts it when pressed in; give another position"
            raise SceneError("position.y", each.case.position.y, message=reason)
    missed = float(np.abs(balance.imbalance(wheels)).max(initial=0.0))
    errors = (
        balance.errors(*wheels, inverse)
        if inverse is not None
        else dict.fromkeys(balance.names, math.nan)
    )
    left, right = wheels
    return WheelSetSolution(
        case, left.z, left.patches + right.patches, left, right, missed, solved, errors
    )
