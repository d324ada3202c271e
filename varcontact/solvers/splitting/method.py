"""Projection and contraction: the method of the room, for the normal and the tangential problem.

With ``e = u - P(u - gamma (W + M u))``, P the projection on what is admissible,
and ``q = (I + gamma M')e``, every u has ``(u - u*)'q >= |e|^2`` for the solution
u*. So the step ``u - a (|e|^2/q's) s`` with ``s = H^-1 q``, 0 < a < 2, leads
nearer to u* in the norm of any symmetric positive definite H, whether M is
symmetric or not. Here H^-1 is a circulant. Such a contraction needs no start
and no linear system, but many rounds; Anderson's extrapolation needs few, but
has no proof. Candidates of the extrapolation are taken as long as they lower
the least ``|e|``, and contractions where they do not: the proof then holds for
both together (docs/proofs.md).

Sources: B. He, Appl. Math. Optim. 35 (1997) 69-76; M. V. Solodov and P. Tseng,
SIAM J. Control Optim. 34 (1996) 1814-1830.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any

import numpy as np

from varcontact.discrete.problems import NormalProblem, RawSolution, TangentialProblem
from varcontact.solvers.interface import Settings, check_time
from varcontact.solvers.newton.driver import (
    NOISE_DOUBLE,
    ROUNDED,
    GridConditions,
    GridProblem,
    Problem,
)
from varcontact.solvers.newton.globalisation import Point
from varcontact.solvers.newton.normal import scaled_normal
from varcontact.solvers.newton.tangential import scaled_tangential
from varcontact.solvers.splitting.anderson import Extrapolation
from varcontact.solvers.splitting.inequality import FixedPoint, Inequality, Iterate

CONTRACTION = 1.5
"""Factor a of the contractions: any between 0 and 2 contracts."""
RECORD = 0.9
"""Part of the least ``|e|`` that counts as a new record."""
PATIENCE = 12
"""Candidates in a row without a record after which contractions are made."""
ASTRAY = 4.0
"""Factor on the record above which a candidate is discarded at once."""
CONTRACTIONS_MIN = 5
"""Contractions at least before candidates are tried again."""
ROUNDS_MAX = 5000
COARSE_TOL = 1e-2
COARSE_ROUNDS_MAX = 300
"""Residual, and rounds at most, on coarse grids."""
NOISE_SINGLE = 3e-7
"""Error of a product in single precision, relative to the largest traction."""
NOISE_PART = 0.05
"""Part of the residual up to which such errors may add up."""
JUDGEMENTS_MAX = 20
"""Largest number of evaluations by the certificate's measure, each with a smaller goal for the
rounds."""


def splitting_normal(
    problem: NormalProblem, settings: Settings, start: RawSolution | None = None
) -> RawSolution:
    """Solve the normal problem."""
    scaled = scaled_normal(problem)
    if isinstance(scaled, RawSolution):
        return scaled
    return solve(scaled, settings, start)


def splitting_tangential(
    problem: TangentialProblem, settings: Settings, start: RawSolution | None = None
) -> RawSolution:
    """Solve the tangential problem: convex wherever the symmetric part of M is positive definite.

    A yield stress that the tractions of the same pass raise is none of a convex problem.
    """
    scaled = scaled_tangential(problem)
    if isinstance(scaled, RawSolution):
        return scaled
    raw = solve(scaled, settings, start)
    if raw.solved or problem.symmetric or problem.symmetric_part is not None:
        return raw
    return replace(raw, status=f"{raw.status}: no proof, as the symmetric part is not definite")


def solve(problem: GridProblem[Any], settings: Settings, start: RawSolution | None) -> RawSolution:
    """Rounds from a start, or from coarse grids, until the answer reaches the tolerance as a
    certificate measures it.
    """
    symmetric = problem.problem.symmetric
    # the first point, and the step gamma for the share of elements that stick there
    count = 0
    if start is not None and start.finite:
        first = problem.initial_guess(start)
    else:
        first, count = _from_coarse_grids(problem.conditions, settings, symmetric)
    inequality = Inequality.of(problem, symmetric)
    inequality.choose_gamma(first)
    iterate = inequality.start(first)
    if first.noise > NOISE_DOUBLE:
        iterate = inequality.in_double_precision(iterate)
    return rounds_to_goal(problem, inequality, iterate, settings, count)


def rounds_to_goal(
    problem: Problem[Any],
    fixed_point: FixedPoint,
    start: Iterate,
    settings: Settings,
    count: int = 0,
) -> RawSolution:
    """Rounds to a goal, which is lowered while the certificate's error misses the tolerance;
    `count` rounds came before.
    """
    tol = ROUNDED * settings.tol
    goal = tol
    iterate = start
    status = "MaxRounds"
    follow = _follower(problem, fixed_point, settings)
    for _ in range(JUDGEMENTS_MAX):
        run = rounds(fixed_point, iterate, goal, settings, ROUNDS_MAX, follow)
        iterate = run.best
        count += run.count
        point = fixed_point.point(iterate)
        point = replace(point, shift=problem.shift(point.traction, point.rigid))
        error = problem.error(point)
        if error <= tol:
            status = "Solved"
            break
        if not run.reached:
            break
        goal *= min(0.5, 0.5 * tol / error)
    if not np.isfinite(iterate.size):
        status = "NotANumber"
    solved = status == "Solved"
    return RawSolution(*problem.physical(point.traction, point.rigid), count, status, solved)


def _ignored(iterate: Iterate) -> None:
    """Follower that records nothing."""


def _follower(
    problem: Problem[Any], fixed_point: FixedPoint, settings: Settings
) -> Callable[[Iterate], None]:
    """The function that records iterates on the finest grid."""
    if not settings.stats.traces:
        return _ignored
    follow = problem.follower(settings.stats)
    return lambda iterate: follow(fixed_point.point(iterate))


def _from_coarse_grids(
    conditions: GridConditions, settings: Settings, symmetric: bool
) -> tuple[Point, int]:
    """A point on the finest grid, and the rounds on the coarse ones."""
    grids = [conditions]
    while grids[-1].coarsens:
        grids.append(grids[-1].coarser())
    at = grids[-1].first()
    count = 0
    for coarse, fine in pairwise(reversed(grids)):
        inequality = Inequality.coarse(coarse, symmetric)
        inequality.choose_gamma(at)
        start = inequality.start(at)
        run = rounds(inequality, start, COARSE_TOL, settings, COARSE_ROUNDS_MAX)
        at = fine.refined(inequality.point(run.best), coarse)
        count += run.count
    return at, count


@dataclass(frozen=True, eq=False)
class Run:
    """The best iterate of some rounds, their number, and whether they have reached their goal."""

    best: Iterate
    count: int
    reached: bool


def rounds(
    fixed_point: FixedPoint,
    start: Iterate,
    goal: float,
    settings: Settings,
    most: int,
    follow: Callable[[Iterate], None] = _ignored,
) -> Run:
    """Candidates of the extrapolation, and contractions where these gain nothing, until a residual
    is below the goal.

    Only an inequality has contractions; rounds of others end there.
    """
    extrapolation = Extrapolation(start.u.size)
    now = start
    best = start
    record = start.size
    idle = 0
    count = 0
    while count < most:
        check_time(settings.deadline)
        # the final iterate, evaluated in double precision
        follow(now)
        settings.stats.tell(f"{fixed_point.words}, round {count}, residual {now.residual:.1e}")
        if now.residual <= goal and now.noise > 0:
            now = fixed_point.in_double_precision(now)
        if now.residual <= goal:
            return Run(now, count, True)
        # a candidate, and whether it is a record
        now = _candidate(fixed_point, now, extrapolation)
        count += 1
        idle += 1
        best = min(best, now, key=_size)
        if now.size <= RECORD * record:
            record = now.size
            idle = 0
        # where candidates do not improve, contractions from the best point
        if idle > PATIENCE or not now.size <= ASTRAY * record:
            if not isinstance(fixed_point, Inequality):
                break
            extrapolation.forget()
            if best.noise > 0:
                best = fixed_point.in_double_precision(best)
            now, contractions = _contracted(fixed_point, best, goal, settings, most - count)
            count += contractions
            idle = 0
            best = min(best, now, key=_size)
            record = best.size
    return Run(best, count, False)


def _size(at: Iterate) -> float:
    """Norm of e; infinite if it is not finite."""
    return at.size if np.isfinite(at.size) else np.inf


def _candidate(fixed_point: FixedPoint, now: Iterate, extrapolation: Extrapolation) -> Iterate:
    """Extrapolation of ``u - Q e``, with Q the circulant near ``(I + gamma M)^-1``; its product in
    single precision where that suffices.
    """
    # fields are scaled to the size of one, as single precision has a short range
    step = -now.size * fixed_point.inverse(now.error / now.size)
    u = extrapolation.next_point(now.u, step)
    change = u - now.u
    moved = _size_or_one(change)
    noise = now.noise + NOISE_SINGLE * moved / _size_or_one(now.projection)
    if noise <= NOISE_PART * now.residual * fixed_point.least_gamma:
        part = (change / moved).astype(np.float32)
        image = now.image + moved * fixed_point.product.apply(part).astype(float)
        candidate = fixed_point.iterate(u, image, now.multipliers, noise)
        if noise <= candidate.residual:
            return candidate
    return fixed_point.iterate(u, fixed_point.product.apply(u), now.multipliers)


def _size_or_one(field: np.ndarray) -> float:
    """Largest absolute value of a field; one for a zero field."""
    return float(np.abs(field).max()) or 1.0


def _contracted(
    inequality: Inequality, best: Iterate, goal: float, settings: Settings, most: int
) -> tuple[Iterate, int]:
    """Contractions from the best point until there is a record, and their number."""
    now = best
    for count in range(most):
        check_time(settings.deadline)
        is_record = now.size <= RECORD * best.size
        if now.residual <= goal or (is_record and count >= CONTRACTIONS_MIN):
            return now, count
        now = contraction(inequality, now)
    return now, most


def contraction(inequality: Inequality, now: Iterate) -> Iterate:
    """A step from a point in double precision, nearer to the solution in the norm of H."""
    q = now.error + inequality.gamma * inequality.product.transposed(now.error)
    step = now.size * inequality.metric(q / now.size)
    length = CONTRACTION * now.size**2 / float(np.vdot(q, step))
    image = now.image - length * inequality.product.apply(step)
    return inequality.iterate(now.u - length * step, image, now.multipliers)
