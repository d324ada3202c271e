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

ROUNDS, MOST_ROUNDS, PATIENCE = 20, 2000, 300
"""Rounds between two looks at the residual, in all, and without a better residual."""

ROUNDING = 1e-13
"""No smaller residual is asked for."""


class Splitting:
    """A problem made ready for rounds: W (c, n), and the factors of ``M + weight`` with the
    prescribed sums around.
    """

    def __init__(self, problem: NormalProblem | TangentialProblem) -> None:
        from scipy.linalg import lu_factor

        self.problem, self.weight = problem, problem.operator.row_size
        forces: tuple[float | None, ...]
        if isinstance(problem, NormalProblem):
            forces, self.shift = (
                (problem.force,),
                problem.distance[None] - (problem.approach or 0.0),
            )
        else:
            forces, self.shift = problem.force, problem.rigid_shift
        (c, n), size = self.shift.shape, self.shift.size
        self.free = [i for i, force in enumerate(forces) if force is not None]
        self.sums = np.array([force / problem.area for force in forces if force is not None])
        totals = np.kron(np.eye(c)[self.free], np.ones(n))
        system = np.pad(problem.operator.matrix, (0, len(totals)))
        system[np.arange(size), np.arange(size)] += self.weight
        system[:size, size:], system[size:, :size] = totals.T, totals
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

        problem, p, rigid = self.problem, self._projected(at), np.zeros(len(at))
        for _ in range(rounds):
            check_time(deadline)
            right = np.concatenate([(self.weight * (2 * p - at) - self.shift).ravel(), self.sums])
            step = lu_solve(self.factors, right, check_finite=False)
            at, rigid[self.free] = at + step[: at.size].reshape(at.shape) - p, step[at.size :]
            p = self._projected(at)
        if isinstance(problem, NormalProblem):
            return at, RawSolution(
                p[0], -rigid if self.free else np.array([problem.approach]), rounds, ""
            )
        return at, RawSolution(p, rigid, rounds, "")

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
    splitting, tol = Splitting(problem), max(settings.tol, ROUNDING)
    at = np.atleast_2d(
        start.traction - problem.shift(start.traction, start.rigid) / splitting.weight
    )
    best, least, reached, count = start, np.inf, 0, 0
    while least > tol and count < MOST_ROUNDS and count - reached < PATIENCE:
        at, found = splitting.moved(at, ROUNDS, settings.deadline)
        count += ROUNDS
        error = natural_residual(problem, found)
        if error < least:
            best, least, reached = found, error, count
    solved = least <= tol
    return replace(
        best, iterations=count, status="Solved" if solved else "MaxRounds", solved=solved
    )
