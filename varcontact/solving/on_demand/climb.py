"""From grid to grid until an answer's own estimate meets what is asked for, or the time is up."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from dataclasses import dataclass, replace

from varcontact.errors import NotConverged, SceneError, TooLarge
from varcontact.results.error_estimate import ErrorEstimate, Solve
from varcontact.results.solution import Solution
from varcontact.scene.scene import Scene
from varcontact.solving.error_norm import units, values
from varcontact.solving.on_demand.asked import Asked
from varcontact.solving.on_demand.ladder import Ladder

Solver = Callable[[Scene], Solution]
"""Solves a scene as `solve` does, without an accuracy."""

COARSER = 0.5
"""Elements across the contact on the first of two grids, by those on the second."""
LEAST_STEP, GREATEST_STEP = 1.35, 2.5
"""Elements of the next grid by those of the last, at least and at most."""


@dataclass(frozen=True)
class Rung:
    """An answer on one grid of a ladder.

    Attributes
    ----------
    n : int
        Elements across the contact.
    solution : Solution
    values, units : dict of str to float
        As of `varcontact.solving.error_norm`.
    seconds : float
    """

    n: int
    solution: Solution
    values: dict[str, float]
    units: dict[str, float]
    seconds: float


def solved_on(scene: Scene, ladder: Ladder, n: int, solve: Solver) -> Rung:
    """A scene on the grid with `n` elements across the contact.

    Parameters
    ----------
    scene : Scene
    ladder : Ladder
    n : int
    solve : callable
    """
    begun = time.perf_counter()
    solution = solve(ladder.posed(scene, n))
    return Rung(n, solution, values(solution), units(solution), time.perf_counter() - begun)


def joined(ladder: Ladder, coarse: Rung, fine: Rung, asked: Asked, before: tuple[Solve, ...]) -> Solution:
    """The answer on the finer of two grids, its values extrapolated, with the estimate of their errors.

    Parameters
    ----------
    ladder : Ladder
    coarse, fine : Rung
    asked : Asked
    before : tuple of Solve
        All solves so far.
    """
    part = 1 / ((fine.n / coarse.n) ** ladder.order - 1)
    changes = {name: (value - coarse.values[name]) * part for name, value in fine.values.items()}
    errors = {name: ladder.error(change / fine.units[name], fine.n) for name, change in changes.items()}
    best = {name: value + changes[name] for name, value in fine.values.items()}
    how = (
        f"extrapolated from {coarse.n} and {fine.n} elements across the contact with order {ladder.order:g}; "
        f"the error of that is taken as {ladder.share:g} of the step to it, and {ladder.floor * fine.n**-ladder.fall:.1e}"
    )
    estimate = ErrorEstimate(best, errors, how, before, asked.accuracy, asked.time_budget)
    return replace(fine.solution, error_estimate=estimate)
