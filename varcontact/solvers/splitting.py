"""Douglas and Rachford's splitting: contact problems by linear systems and projections in turn.

Normal and tangential problem alike ask for zeros of ``W + M p + N(p)``, N the normal cone of what p may be: pressures
that are not negative, tractions within their disks. A round solves with ``M + weight``, always the same factors, then
projects. Wherever M is monotone the rounds converge from any start, without a guess of contact, stick or slip. From
an interior-point answer some tens of rounds reach rounding (docs/speed.md).

Sources: J. Douglas and H. H. Rachford, Trans. Am. Math. Soc. 82 (1956) 421-439; P.-L. Lions and B. Mercier, SIAM J.
Numer. Anal. 16 (1979) 964-979; J. Eckstein and D. P. Bertsekas, Math. Program. 55 (1992) 293-318.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np

from varcontact.discrete.problems import NormalProblem, RawSolution, TangentialProblem
from varcontact.discrete.residuals import normal_residual, tangential_residual
from varcontact.solvers.interface import Settings, check_time
from varcontact.system.process import interruptible

ROUNDS, MOST_ROUNDS, PATIENCE = 20, 2000, 300
"""Rounds between two looks at the residual, in all, and without a better residual."""

ROUNDING = 1e-13
"""No smaller residual is asked for."""

_Answer = Callable[[np.ndarray, np.ndarray], tuple[np.ndarray, np.ndarray]]
_Residual = Callable[[np.ndarray, np.ndarray], float]


@dataclass(frozen=True, eq=False)
class Constraints:
    """What p (n,) may be, and what is prescribed of it: ``totals @ p = sums`` (k,), with multipliers added to W."""

    project: Callable[[np.ndarray, float], np.ndarray]  # by the weight
    totals: np.ndarray
    sums: np.ndarray

    @classmethod
    def of_normal(cls, problem: NormalProblem) -> Constraints:
        """The multiplier of a prescribed force is minus the approach."""
        sums = np.array([] if problem.force is None else [problem.force / problem.area])
        return cls(lambda p, _: np.maximum(p, 0.0), np.ones((sums.size, problem.distance.size)), sums)

    @classmethod
    def of_tangential(cls, problem: TangentialProblem) -> Constraints:
        """Tractions x before y; the multipliers of prescribed forces are the rigid shifts."""
        shape = problem.rigid_shift.shape
        totals = np.kron(np.eye(problem.components)[problem.free], np.ones(problem.size))
        sums = np.array([F / problem.area for F in problem.force if F is not None])
        return cls(lambda p, weight: problem.projected(p.reshape(shape), weight).ravel(), totals, sums)


@dataclass(frozen=True, eq=False)
class Splitting:
    """A problem made ready for rounds: W (n,), and the factors of ``M + weight`` with the prescribed totals around."""

    shift: np.ndarray
    constraints: Constraints
    weight: float
    factors: tuple[np.ndarray, np.ndarray]

    @classmethod
    def of(cls, matrix: np.ndarray, shift: np.ndarray, constraints: Constraints) -> Splitting:
        """With a dense matrix M; the root mean square length of its rows is the weight."""
        from scipy.linalg import lu_factor

        n, k = shift.size, constraints.sums.size
        weight = float(np.linalg.norm(matrix) / np.sqrt(n))
        system = np.zeros((n + k, n + k))
        system[:n, :n] = matrix
        system[np.arange(n), np.arange(n)] += weight
        system[:n, n:], system[n:, :n] = constraints.totals.T, constraints.totals
        factors = interruptible(lambda: lu_factor(system, overwrite_a=True, check_finite=False), len(system))
        return cls(shift, constraints, weight, factors)

    @classmethod
    def of_tangential(cls, problem: TangentialProblem) -> Splitting:
        return cls.of(problem.operator.matrix, problem.rigid_shift.ravel(), Constraints.of_tangential(problem))

    def moved(self, at: np.ndarray, rounds: int, deadline: float = math.inf) -> tuple[np.ndarray, np.ndarray]:
        """The point (n,) and the multipliers (k,) after a number of rounds.

        The point stands for ``p - E/weight``, E the shift ``W + M p`` with the multipliers; its projection is p.
        """
        from scipy.linalg import lu_solve

        multipliers = np.zeros(self.constraints.sums.size)
        for _ in range(rounds):
            check_time(deadline)
            p = self.constraints.project(at, self.weight)
            right = np.concatenate([self.weight * (2 * p - at) - self.shift, self.constraints.sums])
            step = lu_solve(self.factors, right, check_finite=False)
            at, multipliers = at + step[: p.size] - p, step[p.size :]
        return at, multipliers

    def refined(
        self, p: np.ndarray, shift: np.ndarray, answer: _Answer, residual: _Residual, settings: Settings
    ) -> RawSolution:
        """The best of many rounds from p with its shift E, by the residual of tractions and rigid shifts.

        `answer` makes these of p and multipliers; `iterations` counts rounds.
        """
        tol = max(settings.tol, ROUNDING)
        at, best, least, reached, count = p - shift / self.weight, None, np.inf, 0, 0
        while best is None or (least > tol and count < MOST_ROUNDS and count - reached < PATIENCE):
            at, multipliers = self.moved(at, ROUNDS, settings.deadline)
            count += ROUNDS
            found = answer(self.constraints.project(at, self.weight), multipliers)
            error = residual(*found)
            if best is None or error < least:
                best, least, reached = found, error, count
        return RawSolution(*best, count, "Solved" if least <= tol else "MaxRounds", least <= tol)


def refine_normal(problem: NormalProblem, settings: Settings, start: RawSolution) -> RawSolution:
    """Pressures by splitting from an answer that is near, to a natural-map residual of `settings.tol`."""
    shift = problem.distance - (problem.approach or 0.0)
    splitting = Splitting.of(problem.operator.matrix, shift, Constraints.of_normal(problem))
    return splitting.refined(
        start.traction,
        problem.distance - start.rigid[0] + problem.operator.apply(start.traction[None])[0],
        lambda p, multipliers: (p, -multipliers if problem.approach is None else np.array([problem.approach])),
        partial(normal_residual, problem),
        settings,
    )


def refine_tangential(problem: TangentialProblem, settings: Settings, start: RawSolution) -> RawSolution:
    """Tractions by splitting from an answer that is near, see `refine_normal`; M has to be monotone."""

    def answer(p: np.ndarray, multipliers: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        rigid = np.zeros(problem.components)
        rigid[problem.free] = multipliers
        return p.reshape(problem.rigid_shift.shape), rigid

    return Splitting.of_tangential(problem).refined(
        start.traction.ravel(),
        problem.shift(start.traction, start.rigid).ravel(),
        answer,
        partial(tangential_residual, problem),
        settings,
    )
