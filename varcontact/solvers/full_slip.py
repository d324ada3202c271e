"""Full slip by products alone, without Newton's method: the usual state of wheels on rails.

Each is on its bound, against the shift: ``p = -g E/|E|``, ``E = W + M p``. Where bodies slide much
farther than they deform, this repeated converges, and its limit is the solution.
"""

from __future__ import annotations

import math

import numpy as np

from varcontact.discrete.problems import RawSolution, TangentialProblem
from varcontact.discrete.residuals import tangential_residual
from varcontact.interfaces.potential import dot, magnitude
from varcontact.solvers.interface import Settings, check_time

PRODUCTS_MAX = 60
"""Largest number of products."""
DENSE_ELEMENTS = 150
"""Elements up to which their dense matrix is faster than a product on the grid."""
RATIO_MAX = 0.6
"""Ratio of successive changes above which Newton's method is faster."""
CHANGE_MIN = 1e-13
"""Change of a traction, relative to its bound, that is rounding."""
RESIDUAL_SOLVED = 1e-12
"""Residual below which tractions in full slip solve the problem."""


def full_slip(
    problem: TangentialProblem, settings: Settings, start: RawSolution | None = None
) -> RawSolution | None:
    """Tractions in full slip; None where the iteration does not converge fast."""
    traction = _first(problem, start)
    if traction is None:
        return None
    rigid = np.zeros(problem.components)
    elastic = problem.operator.apply
    if problem.size <= DENSE_ELEMENTS:
        elastic = problem.operator.apply_densely
    largest = float(problem.bound.max())
    follow = settings.stats.follow(problem)
    last_change = math.inf
    count = 0
    while count < PRODUCTS_MAX:
        check_time(settings.deadline)
        count += 1
        shift = elastic(traction) + problem.rigid_shift
        size = magnitude(shift)
        if not size.min() > 0:
            return None
        # an element that moves with its traction sticks; a start may have such in new contact
        if start is None and np.any(dot(traction, shift) > 0):
            return None
        against = shift * (-problem.bound / size)
        change = float(np.abs(against - traction).max() / largest)
        traction = against
        if settings.stats.traces:
            follow(RawSolution(traction, rigid))
        if change <= CHANGE_MIN or not change < RATIO_MAX * last_change:
            break
        last_change = change
    shift = elastic(traction) + problem.rigid_shift
    residual = tangential_residual(problem, traction, rigid, shift)
    if not residual <= RESIDUAL_SOLVED:
        return None
    return RawSolution(traction, rigid, count, "Solved", residual=residual)


def _first(problem: TangentialProblem, start: RawSolution | None) -> np.ndarray | None:
    """Tractions of the start, or at the bound against the rigid shift; None where a force or a flow
    determines them, or that shift is at most an element's own compliance times its bound.
    """
    slip = magnitude(problem.rigid_shift)
    if problem.free or problem.potential.flow is not None:
        return None
    if not np.all(slip > problem.operator.diagonal * problem.bound):
        return None
    if start is not None:
        return start.traction
    return np.asarray(-problem.rigid_shift * (problem.bound / slip))
