"""Polish: a solver's answer taken to rounding.

An interior-point solution at a tolerance of 1e-5 already tells which elements are in contact, which stick and
which slip. With that as a start, Kalker's exchange for the normal problem and Newton's method for the
tangential one need one to four dense solves to reach rounding. The result is judged like any other: by its
residual and its gap.
"""

from __future__ import annotations

import numpy as np

from varcontact.conic.programs import RawSolution
from varcontact.energy import normal_residual, project, tangential_residual
from varcontact.problem import NormalProblem, TangentialProblem


def polish_normal(problem: NormalProblem, start: RawSolution, max_steps: int = 20) -> RawSolution:
    """Exchange elements between contact and exterior until every sign is right (paper, 5.2).

    Parameters
    ----------
    problem : NormalProblem
    start : RawSolution
        Its positive pressures are the first contact area.
    max_steps : int

    Returns
    -------
    RawSolution
        The best iterate by its residual, `start` included.
    """
    from scipy.linalg import cho_factor, cho_solve

    best, best_residual = start, normal_residual(problem, start.traction, start.rigid)
    contact = start.traction > 1e-6 * start.traction.max()
    for _ in range(max_steps):
        if not contact.any():
            break
        matrix = problem.operator.grid_operator.dense(problem.operator.elements[contact])
        factor = cho_factor(matrix, overwrite_a=True, check_finite=False)
        if problem.approach is not None:
            approach = problem.approach
            pressure = cho_solve(factor, approach - problem.distance[contact])
        else:
            assert problem.force is not None
            unit, given = cho_solve(factor, np.stack([np.ones(contact.sum()), problem.distance[contact]], axis=1)).T
            approach = (problem.force / problem.area + given.sum()) / unit.sum()
            pressure = approach * unit - given
        traction = np.zeros(contact.size)
        traction[contact] = np.maximum(pressure, 0.0)
        distance = problem.distance - approach + problem.operator.apply(traction[None])[0]
        raw = RawSolution(traction, np.array([approach]), start.iterations, start.status)
        residual = normal_residual(problem, traction, raw.rigid)
        if residual < best_residual:
            best, best_residual = raw, residual
        after = traction > 0
        if after[contact].all():  # all pressures right: now admit where bodies overlap (5.2, points 5-7)
            after = contact | (distance < -1e-13 * abs(distance).max())
        if np.array_equal(after, contact):
            break
        contact = after
    return best


def polish_tangential(
    problem: TangentialProblem, start: RawSolution, max_steps: int = 20, enough: float = 1e-14
) -> RawSolution:
    """Newton's method on the natural map ``p = Proj(p - E/rho)``, with the missing rigid shift as unknown.

    Where an element sticks its row reads E = 0; where it slips, traction along the bound. The map is
    piecewise smooth: near the solution the convergence is quadratic.

    Parameters
    ----------
    problem : TangentialProblem
    start : RawSolution
    max_steps : int
    enough : float
        Residual at which to stop.

    Returns
    -------
    RawSolution
        The best iterate by its residual, `start` included.
    """
    n, free, rho = problem.size, problem.free, problem.operator.diagonal
    matrix = problem.operator.matrix
    traction, rigid = start.traction.copy(), start.rigid.copy()
    best, best_residual = start, np.inf
    for _ in range(max_steps):
        residual = tangential_residual(problem, traction, rigid)
        if not residual < best_residual:
            break
        best, best_residual = RawSolution(traction, rigid, start.iterations, start.status), residual
        if residual < enough:
            break
        trial = traction - _shift(problem, traction, rigid) / rho
        mismatch = (traction - project(trial, problem.bound)).ravel()
        xx, xy, yy = _projection_derivative(trial, problem.bound)
        jacobian = np.zeros((2 * n + len(free), 2 * n + len(free)))
        # d(map) = dp - D (dp - (M dp + dv)/rho), D the derivative of the projection
        through = matrix / -rho
        through[np.diag_indices(2 * n)] += 1.0
        jacobian[:n, : 2 * n] = -(xx[:, None] * through[:n] + xy[:, None] * through[n:])
        jacobian[n : 2 * n, : 2 * n] = -(xy[:, None] * through[:n] + yy[:, None] * through[n:])
        jacobian[np.diag_indices(2 * n)] += 1.0
        lacking = []
        for k, direction in enumerate(free):
            jacobian[:n, 2 * n + k] = (xx, xy)[direction] / rho
            jacobian[n : 2 * n, 2 * n + k] = (xy, yy)[direction] / rho
            jacobian[2 * n + k, direction * n : (direction + 1) * n] = 1.0
            force = problem.force[direction]
            assert force is not None
            lacking.append(traction[direction].sum() - force / problem.area)
        try:
            step = np.linalg.solve(jacobian, np.concatenate([mismatch, lacking]))
        except np.linalg.LinAlgError:
            break
        traction = traction - step[: 2 * n].reshape(2, n)
        rigid = rigid.copy()
        rigid[free] -= step[2 * n :]
    return best


def no_slip(problem: TangentialProblem) -> RawSolution:
    """Tractions that stick everywhere, E = 0: one linear solve (infinite friction)."""
    n, free = problem.size, problem.free
    system = np.zeros((2 * n + len(free), 2 * n + len(free)))
    system[: 2 * n, : 2 * n] = problem.operator.matrix
    right = [-problem.rigid_shift.ravel()]
    for k, direction in enumerate(free):
        block = slice(direction * n, (direction + 1) * n)
        system[block, 2 * n + k] = system[2 * n + k, block] = 1.0
        force = problem.force[direction]
        assert force is not None
        right.append(np.array([force / problem.area]))
    solution = np.linalg.solve(system, np.concatenate(right))
    rigid = np.zeros(2)
    rigid[free] = solution[2 * n :]
    return RawSolution(solution[: 2 * n].reshape(2, n), rigid, 0, "linear solve")


def _shift(problem: TangentialProblem, traction: np.ndarray, rigid: np.ndarray) -> np.ndarray:
    """E by the dense matrix, which is there anyway."""
    elastic = (problem.operator.matrix @ traction.ravel()).reshape(2, -1)
    return elastic + problem.rigid_shift + rigid[:, None]


def _projection_derivative(trial: np.ndarray, bound: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Derivative of the projection on disks: identity inside, ``(g/|y|)(I - y y'/|y|^2)`` outside."""
    size = np.hypot(*trial)
    slips = size > bound
    x, y = trial / np.where(slips, size, 1.0)
    ratio = np.where(slips, bound / np.where(slips, size, 1.0), 1.0)
    return (
        np.where(slips, ratio * (1 - x**2), 1.0),
        np.where(slips, -ratio * x * y, 0.0),
        np.where(slips, ratio * (1 - y**2), 1.0),
    )
