"""Newton's equations of the tangential problem on given stick and slip areas, as a dense matrix."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from varcontact.discrete.problems import TangentialProblem
from varcontact.discrete.residuals import magnitude
from varcontact.system.interrupts import interruptible


@dataclass(frozen=True, eq=False)
class Point:
    """Tractions (c, n) and missing rigid shifts (c,)."""

    traction: np.ndarray
    rigid: np.ndarray


@dataclass(frozen=True, eq=False)
class Step:
    """Changes of the stick tractions (c, nH), of the directions of those that turn (nT,), of the rigid shifts (c,)."""

    stick: np.ndarray
    angle: np.ndarray
    rigid: np.ndarray


@dataclass(frozen=True, eq=False)
class Equations:
    """Newton's equations for given areas, factored: good for steps from other points nearby.

    E = 0 where it sticks, E along the traction where it slips, the prescribed forces. Unknowns: the components of the
    traction where it sticks, its direction where it slips, the missing rigid shifts.
    """

    problem: TangentialProblem
    sticks: np.ndarray
    factors: tuple[np.ndarray, np.ndarray] | None

    @classmethod
    def of(cls, problem: TangentialProblem, sticks: np.ndarray, at: Point) -> Equations:
        """Those at a point; without factors where they are singular.

        Parameters
        ----------
        problem : TangentialProblem
            Dimensionless.
        sticks : bool ndarray, shape (n,)
            The stick area.
        at : Point
            With tractions on the bound in the slip area.
        """
        from scipy.linalg.lapack import dgetrf

        n, c, free, matrix = problem.size, problem.components, problem.free, problem.operator.matrix
        H, (T, across) = np.flatnonzero(sticks), turns(problem, sticks, at)
        h, g, shift = H.size, problem.bound[T], shift_of(problem, at)
        k, components = c * h + T.size, n * np.arange(c)[:, None]
        stuck, turning = (components + H).ravel(), components + T
        rows = np.empty((k, c * n))
        rows[: c * h] = matrix[stuck]
        rows[c * h :] = sum(across[i][:, None] * matrix[turning[i]] for i in range(c))
        jacobian = np.zeros((k + len(free), k + len(free)))
        jacobian[:k, : c * h] = rows.take(stuck, axis=1)
        jacobian[:k, c * h : k] = sum(rows.take(turning[i], axis=1) * (g * across[i]) for i in range(c))
        slip_rows = np.arange(c * h, k)
        jacobian[slip_rows, slip_rows] += magnitude(shift[:, T])
        for i, component in enumerate(free):
            part = slice(component * h, (component + 1) * h)
            jacobian[part, k + i] = jacobian[k + i, part] = 1.0
            jacobian[c * h : k, k + i] = across[component]
            jacobian[k + i, c * h : k] = g * across[component]
        if not len(jacobian):
            return cls(problem, sticks, None)
        factors, swaps, singular = interruptible(lambda: dgetrf(jacobian.T, overwrite_a=True), len(jacobian))
        return cls(problem, sticks, None if singular else (factors, swaps))

    def step(self, at: Point) -> Step:
        """The step from there; none where they are singular.

        Parameters
        ----------
        at : Point
            With tractions on the bound in the slip area.
        """
        from scipy.linalg.lapack import dgetrs

        problem, (T, across) = self.problem, turns(self.problem, self.sticks, at)
        H, c, free, shift = np.flatnonzero(self.sticks), problem.components, problem.free, shift_of(problem, at)
        forces = [F / problem.area for F in problem.force if F is not None]
        lacking = np.array(forces) - at.traction[free].sum(axis=1)
        error = np.concatenate([shift[:, H].ravel(), np.sum(across * shift[:, T], axis=0), -lacking])
        step = np.zeros(error.size)
        if self.factors is not None:
            step, _ = dgetrs(*self.factors, -error, trans=1)
        k, rigid = c * H.size + T.size, np.zeros(c)
        rigid[free] = step[k:]
        return Step(step[: c * H.size].reshape(c, H.size), step[c * H.size : k], rigid)


def moved(problem: TangentialProblem, sticks: np.ndarray, at: Point, step: Step, part: float = 1.0) -> Point:
    """A part of a step, turning the slip tractions on their bound.

    Parameters
    ----------
    problem : TangentialProblem
        Dimensionless.
    sticks : bool ndarray, shape (n,)
        The stick area.
    at : Point
    step : Step
    part : float
        In [0, 1].
    """
    traction, (T, across), angle = at.traction.copy(), turns(problem, sticks, at), part * step.angle
    traction[:, sticks] += part * step.stick
    traction[:, T] = np.cos(angle) * traction[:, T] + np.sin(angle) * problem.bound[T] * across
    return Point(traction, at.rigid + part * step.rigid)


def shift_of(problem: TangentialProblem, at: Point) -> np.ndarray:
    """E by the dense matrix, which Newton's method needs anyway, (c, n).

    Parameters
    ----------
    problem : TangentialProblem
        Dimensionless.
    at : Point
    """
    elastic = (problem.operator.matrix @ at.traction.ravel()).reshape(at.traction.shape)
    return elastic + problem.rigid_shift + at.rigid[:, None]


def turns(problem: TangentialProblem, sticks: np.ndarray, at: Point) -> tuple[np.ndarray, np.ndarray]:
    """The slip elements, whose traction turns, and unit vectors across it; none where there is but one component.

    Parameters
    ----------
    problem : TangentialProblem
        Dimensionless.
    sticks : bool ndarray, shape (n,)
        The stick area.
    at : Point
        With tractions on the bound in the slip area.

    Returns
    -------
    ndarray, shape (m,)
        Of the elements.
    ndarray, shape (2, m)
    """
    T = np.flatnonzero(~sticks & (problem.components > 1))
    across = at.traction[::-1, T] / problem.bound[T]
    across[0] *= -1
    return T, across
