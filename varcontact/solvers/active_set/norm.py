"""NORM: Kalker's active-set algorithm for the normal problem (paper, section 5.2).

Source: J. J. Kalker, Three-Dimensional Elastic Bodies in Rolling Contact,
Kluwer 1990.
"""

from __future__ import annotations

import math
from typing import Literal

import numpy as np

from varcontact.discrete.problems import NormalProblem, RawSolution
from varcontact.discrete.residuals import normal_residual
from varcontact.solvers.interface import check_time, ignored
from varcontact.solvers.trace import Follower


def norm(
    problem: NormalProblem,
    start: RawSolution | None = None,
    exchange: Literal["set", "one"] = "set",
    max_exchanges: int = 10_000,
    deadline: float = math.inf,
    follow: Follower = ignored,
) -> RawSolution:
    """Find the contact area by exchanging elements between contact and exterior.

    Positive pressures of a start are the first contact area. Without it NORM starts as printed:
    from no contact at all, or, with the force prescribed, from the lowest element, which carries
    all of it (5.2.1). Tangential tractions, where they matter, are in the problem's distance (point
    1).

    By "set" all elements of a wrong sign are exchanged at once, as in CONTACT; no proof of
    convergence is known. By "one" it is one at a time, each step lowering the energy, so that no
    contact area comes twice and the end is reached after finitely many (the proof that the paper
    alludes to).

    `status` is "Solved", "Cycled" (a contact area came twice) or "MaxIterations"; pressures are
    always admissible.
    """
    if exchange == "one":
        return _one_at_a_time(problem, start, max_exchanges, deadline, follow)
    contact = _first_contact(problem, start)
    previous_areas: set[bytes] = set()
    status = "MaxIterations"
    for _ in range(max_exchanges):
        check_time(deadline)
        if contact.tobytes() in previous_areas:
            status = "Cycled"
            break
        previous_areas.add(contact.tobytes())
        pressure, approach = _pressure_on(problem, contact)
        follow(RawSolution(pressure, np.array([approach])))
        tension = pressure < 0
        if tension.any():  # points 5 and 6: elements in tension leave the contact area
            contact = contact & ~tension
            continue
        elastic = problem.operator.apply(pressure[None])[0]
        overlaps = _overlaps(problem, contact, approach, elastic)
        if not overlaps.any():  # point 7: all signs are right
            return _solved(problem, pressure, approach, elastic, len(previous_areas))
        contact = contact | overlaps
    return _unsolved(pressure, approach, len(previous_areas), status)


def _one_at_a_time(
    problem: NormalProblem,
    start: RawSolution | None,
    max_exchanges: int,
    deadline: float,
    follow: Follower,
) -> RawSolution:
    """Exchange one element a step: in goes the deepest overlap, out the first pressure that falls
    to zero.

    Pressures stay admissible, and each step goes down in energy: towards the minimum on the present
    contact area, as far as no pressure turns negative (the order of exchanges of C. L. Lawson and
    R. J. Hanson, Solving Least Squares Problems, Prentice-Hall 1974).
    """
    contact = _first_contact(problem, start)
    pressure = np.zeros(contact.size)
    if start is not None:
        pressure[contact] = start.traction[contact]
    elif problem.force is not None:
        pressure[contact] = problem.force / problem.area
    exchanges = 0
    while exchanges < max_exchanges:
        check_time(deadline)
        exchanges += 1
        # the minimum of the energy on the present contact area
        goal, approach = _pressure_on(problem, contact)
        falling = contact & (goal < 0)
        if falling.any():  # go towards it until the first pressure is zero: that element leaves
            reach = np.where(falling, pressure / np.where(falling, pressure - goal, 1.0), np.inf)
            first = int(np.argmin(reach))
            pressure = pressure + reach[first] * (goal - pressure)
            pressure[first] = 0.0
            contact[first] = False
            follow(RawSolution(pressure, np.array([approach])))
            continue
        pressure = goal
        follow(RawSolution(pressure, np.array([approach])))
        elastic = problem.operator.apply(pressure[None])[0]
        overlaps = _overlaps(problem, contact, approach, elastic)
        if not overlaps.any():
            return _solved(problem, pressure, approach, elastic, exchanges)
        # the deepest overlap enters
        contact[np.argmin(np.where(overlaps, problem.distance + elastic, np.inf))] = True
    return _unsolved(pressure, approach, exchanges, "MaxIterations")


def _solved(
    problem: NormalProblem,
    pressure: np.ndarray,
    approach: float,
    elastic: np.ndarray,
    iterations: int,
) -> RawSolution:
    """Answer with correct signs everywhere, with its residual."""
    rigid = np.array([approach])
    residual = normal_residual(problem, pressure, rigid, elastic)
    return RawSolution(pressure, rigid, iterations, "Solved", residual=residual)


def _unsolved(pressure: np.ndarray, approach: float, iterations: int, status: str) -> RawSolution:
    """Answer where the exchanges ended early, without tension."""
    admissible = np.maximum(pressure, 0.0)
    return RawSolution(admissible, np.array([approach]), iterations, status, solved=False)


def _first_contact(problem: NormalProblem, start: RawSolution | None) -> np.ndarray:
    if start is not None and (largest := start.traction.max()) > 0:
        return start.traction > 1e-6 * largest
    contact = np.zeros(problem.distance.size, dtype=bool)
    if problem.force is not None:
        contact[np.argmin(problem.distance)] = True
    return contact


def _pressure_on(problem: NormalProblem, contact: np.ndarray) -> tuple[np.ndarray, float]:
    """Pressures that close the gap on the contact area, zero elsewhere, and the approach: point
    4.
    """
    pressure = np.zeros(contact.size)
    if not contact.any():
        return pressure, problem.approach or 0.0
    inside = contact.nonzero()[0]
    operator = problem.operator.grid_operator.on(problem.operator.elements[inside])
    # pressures by a unit of approach, and by the distance
    right = np.array([np.ones(inside.size), problem.distance[inside]])
    if problem.symmetric:
        from scipy.linalg.lapack import dpotrs

        factor, lower = operator.cholesky
        solved, _ = dpotrs(factor, right.T, lower=lower)
    else:
        from scipy.linalg import lu_factor, lu_solve

        solved = lu_solve(lu_factor(operator.matrix, check_finite=False), right.T)
    by_approach, by_distance = solved.T
    if problem.approach is not None:
        pressure[inside] = problem.approach * by_approach - by_distance
        return pressure, problem.approach
    assert problem.force is not None
    approach = (problem.force / problem.area + by_distance.sum()) / by_approach.sum()
    pressure[inside] = approach * by_approach - by_distance
    return pressure, float(approach)


def _overlaps(
    problem: NormalProblem, contact: np.ndarray, approach: float, elastic: np.ndarray
) -> np.ndarray:
    """Exterior elements where the bodies overlap, beyond rounding."""
    undeformed = problem.distance - approach
    return ~contact & (undeformed + elastic < -1e-13 * float(np.abs(undeformed).max()))
