"""Douglas and Rachford's splitting: contact problems by linear systems and projections in turn.

Normal and tangential problem alike ask for zeros of ``W + M p + N(p)``, N the normal cone of what p may be: pressures
that are not negative, tractions within their disks. A round solves with ``M + weight``, always the same factors, then
projects. Wherever M is monotone the rounds converge from any start, without a guess of contact, stick or slip. From
an interior-point answer some tens of rounds reach rounding (docs/measurements.md).

Sources: J. Douglas and H. H. Rachford, Trans. Am. Math. Soc. 82 (1956) 421-439; P.-L. Lions and B. Mercier, SIAM J.
Numer. Anal. 16 (1979) 964-979; J. Eckstein and D. P. Bertsekas, Math. Program. 55 (1992) 293-318.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from varcontact.discrete.problems import NormalProblem, RawSolution, TangentialProblem
from varcontact.discrete.residuals import normal_residual, project, tangential_residual
from varcontact.solvers.settings import Settings, check_time
from varcontact.system.interrupts import interruptible

ROUNDS, MOST_ROUNDS, PATIENCE = 20, 2000, 300
"""Rounds between two looks at the residual, in all, and without a better residual."""

ROUNDING = 1e-13
"""No smaller residual is asked for."""


_Answer = Callable[[np.ndarray, np.ndarray], tuple[np.ndarray, np.ndarray]]
_Residual = Callable[[np.ndarray, np.ndarray], float]


@dataclass(frozen=True, eq=False)
class Splitting:
    """A problem made ready for rounds.

    Attributes
    ----------
    shift : ndarray, shape (n,)
        W.
    project : callable
        Onto what p may be, (n,) to (n,).
    totals, sums : ndarray, shapes (k, n) and (k,)
        What is prescribed of p, ``totals @ p = sums``; its multipliers are added to W.
    weight : float
    factors : tuple of ndarray
        Of ``M + weight`` with the prescribed totals around it.
    """

    shift: np.ndarray
    project: Callable[[np.ndarray], np.ndarray]
    sums: np.ndarray
    weight: float
    factors: tuple[np.ndarray, np.ndarray]

    @classmethod
    def of(
        cls,
        matrix: np.ndarray,
        shift: np.ndarray,
        project: Callable[[np.ndarray], np.ndarray],
        totals: np.ndarray,
        sums: np.ndarray,
    ) -> Splitting:
        """A problem with a dense matrix; the root mean square length of its rows is the weight.

        Parameters
        ----------
        matrix : ndarray, shape (n, n)
            M.
        shift : ndarray, shape (n,)
            W.
        project : callable
            Onto what p may be, (n,) to (n,).
        totals, sums : ndarray, shapes (k, n) and (k,)
            What is prescribed of p.
        """
        from scipy.linalg import lu_factor

        n, k = shift.size, sums.size
        weight = float(np.linalg.norm(matrix) / np.sqrt(n))
        system = np.zeros((n + k, n + k))
        system[:n, :n] = matrix
        system[np.arange(n), np.arange(n)] += weight
        system[:n, n:], system[n:, :n] = totals.T, totals
        factors = interruptible(lambda: lu_factor(system, overwrite_a=True, check_finite=False), len(system))
        return cls(shift, project, sums, weight, factors)

    @classmethod
    def of_normal(cls, problem: NormalProblem) -> Splitting:
        """The pressures; the multiplier of a prescribed force is minus the approach.

        Parameters
        ----------
        problem : NormalProblem
        """
        n, known = problem.distance.size, problem.approach is not None
        totals = np.ones((0 if known else 1, n))
        sums = np.array([] if problem.force is None else [problem.force / problem.area])
        return cls.of(problem.operator.matrix, problem.distance - (problem.approach or 0.0), _positive, totals, sums)

    @classmethod
    def of_tangential(cls, problem: TangentialProblem) -> Splitting:
        """The tractions, x before y; the multipliers of prescribed forces are the rigid shifts.

        Parameters
        ----------
        problem : TangentialProblem
        """
        n, c, free = problem.size, problem.components, problem.free
        totals = np.kron(np.eye(c)[free], np.ones(n))
        sums = np.array([F / problem.area for F in problem.force if F is not None])
        return cls.of(problem.operator.matrix, problem.rigid_shift.ravel(), _within(problem), totals, sums)

    @classmethod
    def of_both(cls, normal: NormalProblem, tangential: TangentialProblem, coupling: np.ndarray) -> Splitting:
        """Pressures, then tractions, of a shift under a fixed traction bound.

        Parameters
        ----------
        normal : NormalProblem
            On m elements.
        tangential : TangentialProblem
            On n elements.
        coupling : ndarray, shape (m, c n)
            A_zt, distances by tractions, dimensionless.
        """
        one, other, m = cls.of_normal(normal), cls.of_tangential(tangential), normal.distance.size
        totals = np.zeros((one.sums.size + other.sums.size, m + other.shift.size))
        totals[: one.sums.size, :m] = 1.0
        totals[one.sums.size :, m:] = np.kron(np.eye(tangential.components)[tangential.free], np.ones(tangential.size))
        return cls.of(
            np.block([[normal.operator.matrix, coupling], [coupling.T, tangential.operator.matrix]]),
            np.concatenate([one.shift, other.shift]),
            lambda p: np.concatenate([one.project(p[:m]), other.project(p[m:])]),
            totals,
            np.concatenate([one.sums, other.sums]),
        )

    def moved(self, at: np.ndarray, rounds: int, deadline: float = math.inf) -> tuple[np.ndarray, np.ndarray]:
        """The point and the multipliers after a number of rounds.

        The point stands for ``p - E/weight``, E the shift ``W + M p`` with the multipliers; its projection is p.

        Parameters
        ----------
        at : ndarray, shape (n,)
            The point to begin from.
        rounds : int
            At least one.
        deadline : float
            See `Settings`.

        Returns
        -------
        ndarray, shape (n,)
        ndarray, shape (k,)
        """
        from scipy.linalg import lu_solve

        multipliers = np.zeros(self.sums.size)
        for _ in range(rounds):
            check_time(deadline)
            p = self.project(at)
            right = np.concatenate([self.weight * (2 * p - at) - self.shift, self.sums])
            step = lu_solve(self.factors, right, check_finite=False)
            at, multipliers = at + step[: p.size] - p, step[p.size :]
        return at, multipliers

    def refined(self, at: np.ndarray, answer: _Answer, residual: _Residual, settings: Settings) -> RawSolution:
        """The best of many rounds.

        Parameters
        ----------
        at : ndarray, shape (n,)
            The point to begin from, as of `moved`.
        answer : callable
            From p (n,) and multipliers (k,) to tractions and rigid shifts.
        residual : callable
            Natural-map residual of these [-].
        settings : Settings
            Its `tol` is the residual at which it ends.

        Returns
        -------
        RawSolution
            The best by the residual.
        """
        tol = settings.tol
        best, least, reached, count = None, np.inf, 0, 0
        while best is None or (least > max(tol, ROUNDING) and count < MOST_ROUNDS and count - reached < PATIENCE):
            at, multipliers = self.moved(at, ROUNDS, settings.deadline)
            count += ROUNDS
            found = answer(self.project(at), multipliers)
            error = residual(*found)
            if best is None or error < least:
                best, least, reached = found, error, count
        solved = least <= max(tol, ROUNDING)
        return RawSolution(*best, count, "Solved" if solved else "MaxRounds", solved)


def refine_normal(problem: NormalProblem, settings: Settings, start: RawSolution) -> RawSolution:
    """Pressures by splitting from an answer that is near, to a natural-map residual of `settings.tol`.

    Parameters
    ----------
    problem : NormalProblem
    settings : Settings
    start : RawSolution
        A solver's answer.

    Returns
    -------
    RawSolution
        The best of all rounds; `status` is "Solved" or "MaxRounds". `iterations` counts rounds.
    """
    splitting = Splitting.of_normal(problem)
    at = start.traction - _distance(problem, start) / splitting.weight

    def answer(p: np.ndarray, multipliers: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        return p, _approach(problem, multipliers)

    return splitting.refined(at, answer, partial(normal_residual, problem), settings)


def refine_tangential(problem: TangentialProblem, settings: Settings, start: RawSolution) -> RawSolution:
    """Tractions by splitting from an answer that is near, see `refine_normal`; M has to be monotone.

    Parameters
    ----------
    problem : TangentialProblem
        With a monotone M.
    settings : Settings
    start : RawSolution
        The answer, (c, n) and (c,), dimensionless.

    Returns
    -------
    RawSolution
        The nearest that was found.
    """
    splitting = Splitting.of_tangential(problem)
    at = start.traction - problem.shift(start.traction, start.rigid) / splitting.weight

    def answer(p: np.ndarray, multipliers: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        return p.reshape(problem.rigid_shift.shape), _rigid_shift(problem, multipliers)

    return splitting.refined(at.ravel(), answer, partial(tangential_residual, problem), settings)


def refine_both(
    normal: NormalProblem,
    tangential: TangentialProblem,
    coupling: np.ndarray,
    settings: Settings,
    start: tuple[RawSolution, RawSolution],
) -> tuple[RawSolution, RawSolution]:
    """Pressures and tractions of the joint program by splitting, see `refine_normal` and `Splitting.of_both`.

    Parameters
    ----------
    normal : NormalProblem
        On n elements.
    tangential : TangentialProblem
        A shift.
    coupling : ndarray
        Distances by tractions, dimensionless, as `joint_program` takes it.
    settings : Settings
    start : tuple of RawSolution
        The answer: pressures and tractions.

    Returns
    -------
    tuple of RawSolution
        The nearest that were found.
    """
    splitting, m, k = (
        Splitting.of_both(normal, tangential, coupling),
        normal.distance.size,
        int(normal.approach is None),
    )
    shape = tangential.rigid_shift.shape

    def posed(p: np.ndarray) -> tuple[NormalProblem, TangentialProblem]:
        """Each problem with what the other does to it."""
        return (
            replace(normal, distance=normal.distance + coupling @ p[m:]),
            replace(tangential, rigid_shift=tangential.rigid_shift + (coupling.T @ p[:m]).reshape(shape)),
        )

    def answer(p: np.ndarray, multipliers: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        rigid = _approach(normal, multipliers[:k]), _rigid_shift(tangential, multipliers[k:])
        return p, np.concatenate(rigid)

    def residual(p: np.ndarray, rigid: np.ndarray) -> float:
        pressing, rubbing = posed(p)
        errors = (
            normal_residual(pressing, p[:m], rigid[:1]),
            tangential_residual(rubbing, p[m:].reshape(shape), rigid[1:]),
        )
        return float(np.max(errors))

    pressed, rubbed = start
    p = np.concatenate([pressed.traction, rubbed.traction.ravel()])
    pressing, rubbing = posed(p)
    shifts = np.concatenate([_distance(pressing, pressed), rubbing.shift(rubbed.traction, rubbed.rigid).ravel()])
    found = splitting.refined(p - shifts / splitting.weight, answer, residual, settings)
    return (
        replace(found, traction=found.traction[:m], rigid=found.rigid[:1]),
        replace(found, traction=found.traction[m:].reshape(shape), rigid=found.rigid[1:]),
    )


def _distance(problem: NormalProblem, at: RawSolution) -> np.ndarray:
    """Deformed distances, (n,)."""
    return problem.distance - at.rigid[0] + problem.operator.apply(at.traction[None])[0]


def _approach(problem: NormalProblem, multipliers: np.ndarray) -> np.ndarray:
    return -multipliers if problem.approach is None else np.array([problem.approach])


def _rigid_shift(problem: TangentialProblem, multipliers: np.ndarray) -> np.ndarray:
    rigid = np.zeros(problem.components)
    rigid[problem.free] = multipliers
    return rigid


def _positive(p: np.ndarray) -> np.ndarray:
    return np.maximum(p, 0.0)


def _within(problem: TangentialProblem) -> Callable[[np.ndarray], np.ndarray]:
    """Projection of tractions, flat, on their disks."""
    shape, bound = problem.rigid_shift.shape, problem.bound
    return lambda p: project(p.reshape(shape), bound).ravel()
