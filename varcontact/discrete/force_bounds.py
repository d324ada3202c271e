"""Guaranteed bounds on the errors of forces and moment, by convex duality (docs/theory.md, "The certificate").

For the exact solution p* of a problem and any tractions p, ``|c'(p - p*)| <= (c'S^-1 c)^(1/2) |p - p*|_S``. The
distance in the norm of S follows from the gap, and from what the problem would have to be for p to be its solution.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from varcontact.discrete.positive_definite import PositiveDefinite, norm, positive_definite
from varcontact.discrete.problems import NormalProblem, TangentialProblem
from varcontact.discrete.residuals import ROUNDING, magnitude, project, shares
from varcontact.elasticity.operators import RestrictedOperator

EPS = float(np.finfo(float).eps)
TRANSFORM = 10.0
"""Rounding of a product by FFT, relative, in units of the machine's per doubling of its length (three transforms)."""

ON_BOUND = 1e-12
"""Relative distance from the bound at which a traction is put on it."""


# ----------------------------------------------------------------------------- tractions


def force_bound(problem: TangentialProblem, traction: np.ndarray, rigid: np.ndarray) -> np.ndarray:
    """Guaranteed bounds on the errors of Fx, Fy, Mz for the problem's traction bound, shape (3,), dimensionless.

    Infinite where the symmetric part is not found to be positive definite. Tractions that are not admissible are
    first made so; what that changes is added.
    """
    outputs, definite = outputs_of(problem), problem.symmetric_part
    if definite is None:
        return unknown(outputs)
    admissible = _admissible(problem, traction)
    moved = np.abs(np.sum(outputs * (traction - admissible), axis=(1, 2)))
    moved += ROUNDING * np.sum(np.abs(outputs) * magnitude(admissible), axis=(1, 2))
    return np.asarray(
        problem.area * (moved + np.sqrt(definite.energies(outputs)) * _distance(problem, definite, admissible, rigid))
    )


def outputs_of(problem: TangentialProblem) -> np.ndarray:
    """What Fx, Fy and Mz count of each traction component, (3, c, n), without the area of an element."""
    x, y = problem.points
    one, zero = np.ones(problem.size), np.zeros(problem.size)
    return np.array([[one, zero], [zero, one], [-y, x]])[:, list(problem.directions)]


def unknown(outputs: np.ndarray) -> np.ndarray:
    """Infinite bounds, for the outputs that exist."""
    return np.where(outputs.any(axis=(1, 2)), np.inf, 0.0)


def _admissible(problem: TangentialProblem, traction: np.ndarray) -> np.ndarray:
    """Tractions within the bound, on it where they nearly are, with the prescribed forces.

    What a force lacks goes to the elements below their bound, in the measure of what they can still carry. Where that
    is not enough all tractions are reduced first: without any there is room for every force that friction can carry.
    """
    near = project(traction, problem.bound)
    if not problem.no_slip:
        size = magnitude(near)
        on_bound = (size > (1 - ON_BOUND) * problem.bound) & (size > 0)
        near = near * np.where(on_bound, problem.bound / np.where(on_bound, size, 1.0), 1.0)
    force = np.array([0.0 if F is None else F for F in problem.force]) / problem.area
    held = np.isin(np.arange(problem.components), problem.free)
    lacking = np.where(held, force - near.sum(axis=1), 0.0)
    if np.linalg.norm(lacking) <= ROUNDING * magnitude(near).sum():
        return near
    if problem.no_slip:
        return near + lacking[:, None] / problem.size
    room = problem.bound - magnitude(near)
    short = np.linalg.norm(lacking) - room.sum()
    if short > 0:  # room less what is lacking is a concave function of the part by which tractions are reduced
        near = near * (1 - short / (short + problem.bound.sum() - np.linalg.norm(force)))
        lacking = np.where(held, force - near.sum(axis=1), 0.0)
        room = problem.bound - magnitude(near)
    return near + lacking[:, None] * room / room.sum()


def _distance(problem: TangentialProblem, definite: PositiveDefinite, traction: np.ndarray, rigid: np.ndarray) -> float:
    """A bound on ``|p - p*|_S`` for admissible tractions.

    Where the shift is small beside an element's share of the gap, it is taken for a change of the rigid shift, of
    which the tractions then are the solution; what that changes is ``|E|`` in the norm of S^-1.
    """
    shift = problem.shift(traction, rigid)
    length = magnitude(shift)
    error = _rounding(problem.operator, traction, problem.rigid_shift + rigid[:, None]) / np.sqrt(definite.least)
    if problem.no_slip:
        return float(np.sqrt(definite.energies(shift[None])[0])) + error
    parts = np.maximum(shares(problem.bound, traction, shift), 0.0)
    error += ROUNDING * np.sqrt(problem.bound @ length)
    taken = length**2 < problem.operator.diagonal * parts
    changed = definite.energies(np.where(taken, shift, 0.0)[None])[0]
    return float(min(np.sqrt(parts.sum()), np.sqrt(parts[~taken].sum()) + np.sqrt(changed)) + error)


def _rounding(operator: RestrictedOperator, field: np.ndarray, known: np.ndarray) -> float:
    """A bound on the 2-norm of the rounding in ``known + M field``, by FFT or by the matrix (Higham 2002)."""
    own, softest = operator.grid_operator, 0.0 if operator.softening is None else float(operator.softening.max())
    if own.whole is None:
        product = TRANSFORM * np.log2(own.table[0, 0].size) * (norm(own) + softest)
    else:  # sums of so many products, in any order
        product = own.whole.shape[1] * (float(np.linalg.norm(own.whole)) + softest)
    return float(EPS * (product * np.linalg.norm(field) + 3 * np.linalg.norm(known)))


# ----------------------------------------------------------------------------- the pressure's own error


@dataclass(frozen=True, eq=False)
class PressureError:
    """How far a pressure is from the exact one of the discrete normal problem, dimensionless.

    The size bounds the Euclidean norm of ``p - p*``. Possible are the elements with pressure, and those where the
    exact one may have some.
    """

    size: float
    possible: np.ndarray


def pressure_error(problem: NormalProblem, pressure: np.ndarray, approach: float) -> PressureError | None:
    """A bound on the error of a pressure (n,); None where A is not symmetric, or rounding hides that it is definite.

    Where the pressure is small beside the distance, ``p e`` is that element's share of the gap; elsewhere the distance
    is taken for a change of the undeformed one, of which the pressure then is the solution.
    """
    definite = positive_definite(problem.operator, dense_limit=0) if problem.symmetric else None
    if definite is None:
        return None
    apply = problem.operator.apply
    admissible = np.maximum(pressure, 0.0)
    if problem.force is not None:
        admissible = admissible * (problem.force / problem.area / admissible.sum())
    else:
        assert problem.approach is not None
        approach = problem.approach
    moved, elastic = pressure - admissible, apply(admissible[None])[0]
    distance = problem.distance - approach + elastic
    apart = admissible * problem.operator.diagonal <= distance
    energy = float(admissible[apart] @ distance[apart])
    changed = float(definite.energies(np.where(apart, 0.0, distance)[None, None])[0])
    error = _rounding(problem.operator, admissible[None], problem.distance - approach) / np.sqrt(definite.least)
    inner = float(np.sqrt(energy) + np.sqrt(changed) + error)
    reach = inner * np.sqrt(problem.operator.diagonal)
    if problem.force is not None:  # the exact approach may be larger, and more elements in contact
        stored = np.sqrt(max(float(admissible @ elastic), 0.0))
        reach += max(float(admissible @ distance) + stored * inner, 0.0) / admissible.sum()
    outer = inner + np.sqrt(max(float(moved @ apply(moved[None])[0]), 0.0))
    return PressureError(float(outer / np.sqrt(definite.least)), (pressure > 0) | (distance <= reach))


def pressure_part(problem: TangentialProblem, spread: float) -> np.ndarray:
    """What a change of the traction bound by `spread` (2-norm) changes of Fx, Fy, Mz at most, (3,), dimensionless.

    The creepages are given, and the problem has all elements that may come to bear.
    """
    outputs, definite = outputs_of(problem), problem.symmetric_part
    if definite is None:
        return unknown(outputs)
    table = problem.operator.grid_operator
    stretch = np.sqrt(norm(table.symmetric_part())) + norm(table.symmetric_part(-1.0)) / np.sqrt(definite.least)
    lengths = np.sqrt(np.sum(outputs**2, axis=(1, 2)))
    return np.asarray(problem.area * spread * (lengths + np.sqrt(definite.energies(outputs)) * stretch))
