"""The duality gap, and the certificate: how exact given tractions are (paper, section 4).

Everything here is computed from the problem's own data, with products by FFT, for tractions from any source:
no solver's word enters.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from varcontact.problem.discretisation import Discretisation
from varcontact.problem.problem import NormalProblem, TangentialProblem
from varcontact.solvers.matrix_free.symmetric import solve_symmetric

if TYPE_CHECKING:
    from varcontact.planning.plan import Plan

DENSE_LIMIT = 1200
"""Elements up to which the symmetric part is factored densely for the bound on forces; beyond, CG by FFT."""


@dataclass(frozen=True, eq=False)
class Certificate:
    """How exact a solution of the discrete problem is.

    Attributes
    ----------
    gap : float
        Duality gap of the tangential problem, ``sum((g_i |E_i| + p_i'E_i) dx dy)`` [force length]: zero
        exactly at the solution, positive elsewhere. In normal contact without friction, that of the normal
        problem.
    relative_gap : float
        The gap by ``sum(g_i |W_i| dx dy)``, the work of the full bound against the rigid shift.
    force_bound : ndarray, shape (3,)
        Guaranteed bounds on the errors of Fx, Fy and Mz against the exact solution of the discrete tangential
        problem with the same pressure, ``sqrt(c'S^-1 c gap)``. Infinite where no such bound is known: for unlike
        bodies, whose pressure depends on the tractions, under a law of friction, whose coefficient depends on the
        slip, and where S is not positive definite.
    residual : float
        Natural-map residual, the largest ``|p - Proj(p - E/rho)|`` by the largest traction; the larger of the
        tangential and the normal one. With Hertz's closed form as the pressure of a tangential problem the
        normal one is left out: it is the grid's error, and found in `normal_residual`.
    normal_relative_gap, normal_residual, tangential_residual : float
        The same measures of the two problems.
    """

    gap: float
    relative_gap: float
    force_bound: np.ndarray
    residual: float
    normal_relative_gap: float
    normal_residual: float
    tangential_residual: float


def certify_problems(
    disc: Discretisation,
    pressure: np.ndarray,
    approach: float,
    traction: np.ndarray,
    rigid: np.ndarray,
    plan: Plan,
) -> Certificate:
    """The certificate of pressures (ny, nx) and tractions (2, ny, nx), given dimensionless.

    Both problems are judged with the other's final tractions: the residual is that of the whole.
    """
    coupled = disc.K != 0
    normal = disc.normal_problem(traction if coupled and np.any(traction) else None)
    level = np.array([approach])
    normal_error = normal_residual(normal, pressure.ravel(), level)
    absolute, normal_relative = normal_gap(normal, pressure.ravel(), level)
    energy = disc.force * disc.displacement
    scales = disc.force * np.array([1.0, 1.0, disc.length])
    tangential = None if disc.frictionless else disc.tangential_problem(pressure, acting=traction)
    bearing = np.zeros(0, dtype=int) if tangential is None else tangential.operator.elements
    flat = traction.reshape(2, -1)
    stray = np.delete(flat, bearing, axis=1)  # what acts where no friction can carry it is all error
    excess = disc.lattice.area * np.abs(_totals(np.delete(disc.points.reshape(2, -1), bearing, axis=1), stray))
    largest = float(magnitude(flat).max())
    residual = _relative(float(magnitude(stray).max(initial=0.0)), largest)
    if tangential is None or tangential.size == 0:
        return Certificate(
            gap=absolute * energy,
            relative_gap=normal_relative,
            force_bound=excess * scales,
            residual=_worst(residual, normal_error),
            normal_relative_gap=normal_relative,
            normal_residual=normal_error,
            tangential_residual=residual,
        )
    tractions, shifts = tangential.of_grid(traction, rigid)
    residual = _worst(residual, tangential_residual(tangential, tractions, shifts))
    absolute, relative = gap(tangential, project(tractions, tangential.bound), shifts)
    several = coupled or disc.law is not None
    bound = _unknown(_outputs(tangential)) if several else force_bound(tangential, tractions, shifts)
    return Certificate(
        gap=absolute * energy,
        relative_gap=relative,
        force_bound=(bound + excess) * scales,
        residual=residual if plan.normal == "hertz" else _worst(residual, normal_error),
        normal_relative_gap=normal_relative,
        normal_residual=normal_error,
        tangential_residual=residual,
    )


def residuals(
    disc: Discretisation, pressure: np.ndarray, approach: float, traction: np.ndarray, rigid: np.ndarray
) -> tuple[float, float]:
    """Natural-map residuals of the normal and of the tangential problem, each with the other's final tractions."""
    coupled = disc.K != 0 and np.any(traction)
    normal = disc.normal_problem(traction if coupled else None)
    normal_error = normal_residual(normal, pressure.ravel(), np.array([approach]))
    tangential = disc.tangential_problem(pressure, acting=traction)
    size = magnitude(traction.reshape(2, -1))
    stray = np.delete(size, tangential.operator.elements).max(initial=0.0)  # where no friction can carry it
    error = _relative(float(stray), float(size.max()))
    if tangential.size:
        error = _worst(error, tangential_residual(tangential, *tangential.of_grid(traction, rigid)))
    return normal_error, error


def magnitude(vectors: np.ndarray) -> np.ndarray:
    """Lengths (n,) of vectors (c, n) of one or two components."""
    return np.abs(vectors[0]) if len(vectors) == 1 else np.hypot(*vectors)


def project(traction: np.ndarray, bound: np.ndarray) -> np.ndarray:
    """Projection of tractions (c, n) on the disks, or the intervals, of radius `bound` (n,)."""
    size = magnitude(traction)
    beyond = size > bound
    return traction * np.where(beyond, bound / np.where(beyond, size, 1.0), 1.0)


def normal_residual(
    problem: NormalProblem, pressure: np.ndarray, rigid: np.ndarray, elastic: np.ndarray | None = None
) -> float:
    """Largest ``|p - max(p - e/rho, 0)|`` by the largest pressure; with the force, what it lacks.

    A p is taken from `elastic` where that is known already.
    """
    elastic = problem.operator.apply(pressure[None])[0] if elastic is None else elastic
    distance = problem.distance - rigid[0] + elastic
    image = np.maximum(pressure - distance / problem.operator.diagonal, 0.0)
    residual = _relative(np.abs(pressure - image).max(), _worst(np.abs(pressure).max(), image.max()))
    if problem.force is not None:
        residual = _worst(residual, abs(pressure.sum() * problem.area / problem.force - 1))
    return residual


def tangential_residual(
    problem: TangentialProblem, traction: np.ndarray, rigid: np.ndarray, shift: np.ndarray | None = None
) -> float:
    """Largest ``|p - Proj(p - E/rho)|`` by the largest traction; with forces prescribed, what they lack.

    E is taken from `shift` where that is known already.
    """
    shift = problem.shift(traction, rigid) if shift is None else shift
    image = project(traction - shift / problem.operator.diagonal, problem.bound)
    size = _worst(magnitude(traction).max(), magnitude(image).max())
    residual = _relative(float(magnitude(traction - image).max()), float(size))
    for i in problem.free:
        force = problem.force[i]
        assert force is not None
        lacking = abs(traction[i].sum() * problem.area - force)
        scale = size * problem.area * math.sqrt(problem.size)
        residual = _worst(residual, _relative(lacking, scale if scale > 0 else abs(force)))  # nothing carries nothing
    return residual


def _relative(value: float, scale: float) -> float:
    return 0.0 if scale == 0 else float(value / scale)  # NaN stays NaN


def _worst(*values: float) -> float:
    """The largest, and NaN where one is: what is not a number is never taken for a small residual."""
    return float(np.max(values))


def gap(
    problem: TangentialProblem, traction: np.ndarray, rigid: np.ndarray, shift: np.ndarray | None = None
) -> tuple[float, float]:
    """Duality gap of admissible tractions, absolute and relative (dimensionless).

    Each element's share ``g |E| + p'E`` is positive on its own (Cauchy and Schwarz), so nothing cancels in the
    sum. For a shift it is the potential energy (214) plus the complementary energy (215) of the tractions. With
    infinite friction the gap is ``E'S^-1 E``, the squared distance to the solution or more. E is taken from `shift`
    where that is known already.
    """
    shift = problem.shift(traction, rigid) if shift is None else shift
    if problem.no_slip:
        error = float(_compliance(problem, shift[None])[0])
        work = abs(float(np.sum(traction * (problem.rigid_shift + rigid[:, None]))))
        return error * problem.area, _relative(error, work)
    size = magnitude(shift)
    shares = problem.bound * size + np.sum(traction * shift, axis=0)
    work = problem.bound @ magnitude(problem.rigid_shift + rigid[:, None])
    total = float(np.sum(np.maximum(shares, 0.0)))
    return total * problem.area, _relative(total, float(work))


def force_bound(problem: TangentialProblem, traction: np.ndarray, rigid: np.ndarray) -> np.ndarray:
    """Guaranteed bounds on the errors of Fx, Fy, Mz, shape (3,), dimensionless.

    Tractions beyond the bound are first projected on it; what the projection changes is added.
    """
    admissible, outputs = project(traction, problem.bound), _outputs(problem)
    compliance = _compliance(problem, outputs)
    error = gap(problem, admissible, rigid)[0] / problem.area
    moved = np.abs(np.sum(outputs * (traction - admissible), axis=(1, 2)))
    known = np.isfinite(compliance)  # an infinite compliance tells nothing, even if the gap is zero
    bound = np.where(known, np.sqrt(np.where(known, compliance, 0.0) * error), np.inf)
    return problem.area * (bound + moved)


def _outputs(problem: TangentialProblem) -> np.ndarray:
    """What Fx, Fy and Mz count of each traction component, (3, c, n): nothing, where it cannot contribute."""
    x, y = problem.points
    one, zero = np.ones(problem.size), np.zeros(problem.size)
    return np.array([[one, zero], [zero, one], [-y, x]])[:, list(problem.directions)]


def _unknown(outputs: np.ndarray) -> np.ndarray:
    """Infinite, where there is an output at all."""
    return np.where(outputs.any(axis=(1, 2)), np.inf, 0.0)


def _totals(points: np.ndarray, traction: np.ndarray) -> np.ndarray:
    """Sums of tractions (2, n) along x, along y, and of their moments, shape (3,)."""
    moment = points[0] * traction[1] - points[1] * traction[0]
    return np.array([traction[0].sum(), traction[1].sum(), moment.sum()])


def normal_gap(
    problem: NormalProblem, pressure: np.ndarray, rigid: np.ndarray, elastic: np.ndarray | None = None
) -> tuple[float, float]:
    """Duality gap of the normal problem, absolute and relative to ``p'A p`` (dimensionless).

    It bounds ``(p - p*)'A (p - p*)``. With the force prescribed it is ``sum(p) (d - min(h + A p))``, d the mean
    of ``h + A p`` weighted by p; with the approach prescribed ``p'e`` plus the deepest overlap times a bound on
    ``sum(p*)``, ``(d - min h) / min A``. A p is taken from `elastic` where that is known already.
    """
    elastic = problem.operator.apply(pressure[None])[0] if elastic is None else elastic
    total, approach = float(pressure.sum()), float(rigid[0])
    if problem.force is not None:
        level = problem.distance + elastic
        value = float(pressure @ (level - level.min()))
    else:
        distance = problem.distance + elastic - approach
        overlap = max(-float(distance.min()), 0.0)
        least = float(problem.operator.grid_operator.table.min())
        value = float(pressure @ np.abs(distance)) + overlap * max(
            (approach - float(problem.distance.min())) / least, total
        )
    return value * problem.area, _relative(value, float(pressure @ elastic))


def _compliance(problem: TangentialProblem, outputs: np.ndarray) -> np.ndarray:
    """``o'S^-1 o`` for several o (c, n), S the symmetric part of M; infinite if S is not positive definite."""
    from scipy.linalg import LinAlgError, cho_factor, cho_solve

    if problem.size > DENSE_LIMIT:
        solution = solve_symmetric(problem.operator, outputs)
        if solution is None:
            return _unknown(outputs)
        return 1.001 * np.sum(outputs * solution, axis=(1, 2))  # what CG still lacks is orders of magnitude less
    matrix = problem.operator.matrix
    try:
        factor = cho_factor((matrix + matrix.T) / 2, overwrite_a=True, check_finite=False)
    except LinAlgError:
        return _unknown(outputs)
    solution = cho_solve(factor, outputs.reshape(len(outputs), -1).T).T.reshape(outputs.shape)
    return np.sum(outputs * solution, axis=(1, 2))
