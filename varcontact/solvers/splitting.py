"""Douglas and Rachford's splitting: contact problems by linear systems and projections in turn.

Normal and tangential problem alike ask for zeros of ``W + M p + N(p)``, N the
normal cone of what p may be: pressures that are not negative, tractions within
their disks. A round solves with ``M + weight``, always the same factors, then
projects. Wherever M is monotone the rounds converge from any start, without a
guess of contact, stick or slip. From an interior-point answer some tens of
rounds reach rounding (docs/speed.md).

Sources: J. Douglas and H. H. Rachford, Trans. Am. Math. Soc. 82 (1956) 421-439;
P.-L. Lions and B. Mercier, SIAM J. Numer. Anal. 16 (1979) 964-979; J. Eckstein
and D. P. Bertsekas, Math. Program. 55 (1992) 293-318.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from varcontact.discrete.problems import NormalProblem, RawSolution, TangentialProblem
from varcontact.solvers.interface import Settings, check_time, natural_residual
from varcontact.system.process import interruptible

CHECK_ROUNDS = 20
"""Rounds between two checks of the residual."""
MAX_ROUNDS = 2000
MAX_IDLE_ROUNDS = 300
"""Rounds without a better residual."""
TOL_MIN = 1e-13
"""Least residual: rounding."""


class Splitting:
    """A problem made ready for rounds: W (c, n), and the factors of ``M + weight`` with the
    prescribed sums around.
    """

    def __init__(self, problem: NormalProblem | TangentialProblem) -> None:
        from scipy.linalg import lu_factor

        self.problem = problem
        self.weight = problem.operator.row_size
        forces: tuple[float | None, ...]
        if isinstance(problem, NormalProblem):
            forces = (problem.force,)
            self.shift = problem.distance[None] - (problem.approach or 0.0)
        else:
            forces = problem.force
            self.shift = problem.rigid_shift
        c, n = self.shift.shape
        size = self.shift.size
        self.free = [i for i, force in enumerate(forces) if force is not None]
        self.sums = np.array([force / problem.area for force in forces if force is not None])
        totals = np.kron(np.eye(c)[self.free], np.ones(n))
        system = np.pad(problem.operator.matrix, (0, len(totals)))
        system[np.arange(size), np.arange(size)] += self.weight
        system[:size, size:] = totals.T
        system[size:, :size] = totals
        self.factors = interruptible(
            lambda: lu_factor(system, overwrite_a=True, check_finite=False), len(system)
        )

    def moved(
        self, at: np.ndarray, rounds: int, deadline: float = math.inf
    ) -> tuple[np.ndarray, RawSolution]:
        """A point (c, n) after a number of rounds, and the tractions that it stands for.

        It is ``p - E/weight``, E the shift ``W + M p`` with the multipliers of the sums; its
        projection is p.
        """
        from scipy.linalg import lu_solve

        p = self._projected(at)
        rigid = np.zeros(len(at))
        for _ in range(rounds):
            check_time(deadline)
            right = np.concatenate([(self.weight * (2 * p - at) - self.shift).ravel(), self.sums])
            step = lu_solve(self.factors, right, check_finite=False)
            at = at + step[: at.size].reshape(at.shape) - p
            rigid[self.free] = step[at.size :]
            p = self._projected(at)
        if isinstance(self.problem, TangentialProblem):
            return at, RawSolution(p, rigid, rounds, "")
        approach = -rigid if self.free else np.array([self.problem.approach])
        return at, RawSolution(p[0], approach, rounds, "")

    def _projected(self, at: np.ndarray) -> np.ndarray:
        if isinstance(self.problem, NormalProblem):
            return np.maximum(at, 0.0)
        return self.problem.potential.projected(at, self.weight)


def refine(
    problem: NormalProblem | TangentialProblem, settings: Settings, start: RawSolution
) -> RawSolution:
    """The best of many rounds from an answer that is near, by its residual; M has to be monotone.

    `iterations` counts rounds.
    """
    splitting = Splitting(problem)
    tol = max(settings.tol, TOL_MIN)
    shift = problem.shift(start.traction, start.rigid)
    at = np.atleast_2d(start.traction - shift / splitting.weight)
    best = start
    least = np.inf
    best_count = 0
    count = 0
    while least > tol and count < MAX_ROUNDS and count - best_count < MAX_IDLE_ROUNDS:
        at, raw = splitting.moved(at, CHECK_ROUNDS, settings.deadline)
        count += CHECK_ROUNDS
        residual = natural_residual(problem, raw)
        if residual < least:
            best = raw
            least = residual
            best_count = count
    solved = least <= tol
    status = "Solved" if solved else "MaxRounds"
    return replace(best, iterations=count, status=status, solved=solved)
