"""The duality gap and the residuals of given tractions (paper, section 4).

Everything here is computed from the problem's own data, with products by FFT, for tractions from any source:
no solver's word enters.
"""

from __future__ import annotations

import math

import numpy as np

from varcontact.discrete.discretisation import Discretisation
from varcontact.discrete.problems import NormalProblem, TangentialProblem
from varcontact.discrete.subgrid import normal_as_solved
from varcontact.system.threads import one_blas_thread

ROUNDING = 4 * float(np.finfo(float).eps)
"""Relative difference of a traction from its bound that counts as rounding."""
FAINT = 1e-6
"""Part of the traction bound below which tractions are measured by the bound, as to what wrong pressures do to them."""


def residuals(
    disc: Discretisation, pressure: np.ndarray, approach: float, traction: np.ndarray, rigid: np.ndarray
) -> tuple[float, float, float]:
    """Natural-map residuals of the normal and of the tangential problem, each with the other's final tractions.

    The third is what the normal one does to the tractions of unlike bodies.

    Parameters
    ----------
    disc : Discretisation
    pressure : ndarray, shape (ny, nx)
        Dimensionless, as all that follow.
    approach : float
    traction : ndarray, shape (2, ny, nx)
    rigid : ndarray, shape (2,)
        Unknown part of the rigid shift.

    Returns
    -------
    normal, tangential, handed_on : float
        Relative to the largest pressure or traction.
    """
    normal, pressed, level = normal_as_solved(disc, pressure, approach, traction)
    normal_error = normal_residual(normal, pressed, level)
    tangential_error = _of_tractions(disc, pressure, traction, rigid)
    return normal_error, tangential_error, handed_on(disc, normal, pressure, level, traction, rigid)


def _of_tractions(disc: Discretisation, pressure: np.ndarray, traction: np.ndarray, rigid: np.ndarray) -> float:
    """Residual of the tangential problem under a pressure (ny, nx)."""
    tangential = disc.tangential_problem(pressure, acting=traction)
    size = magnitude(traction.reshape(2, -1))
    stray = np.delete(size, tangential.operator.elements).max(initial=0.0)  # where no friction can carry it
    error = relative(float(stray), float(size.max()))
    if tangential.size:
        error = worst(error, tangential_residual(tangential, *tangential.of_grid(traction, rigid)))
    return error


def handed_on(
    disc: Discretisation,
    normal: NormalProblem,
    pressure: np.ndarray,
    level: np.ndarray,
    traction: np.ndarray,
    rigid: np.ndarray,
) -> float:
    """What the residual of the normal problem does to the tractions of unlike bodies.

    A change of the pressures shifts the surfaces by K, and friction f makes that ``K/f`` times as large a part of the
    tractions: the less friction, the more exact the pressures have to be. So the tractions are judged under the
    pressures that the natural map has in place of these. Where a force is prescribed, the rigid shift follows what
    that moves the elements that stick, in the mean: that changes the creepage, and no traction. Tractions of less than
    `FAINT` of what friction bears are measured by that: where hardly anything rubs, they may be nothing but rounding.

    Parameters
    ----------
    disc : Discretisation
    normal : NormalProblem
    pressure : ndarray, shape (ny, nx)
        Dimensionless, as all that follow.
    level : ndarray, shape (1,)
        The approach.
    traction : ndarray, shape (2, ny, nx)
    rigid : ndarray, shape (2,)
        Unknown part of the rigid shift.

    Returns
    -------
    float
        Residual, relative to the largest traction; 0 for like bodies.
    """
    if disc.K == 0 or not np.any(traction):
        return 0.0
    image = _normal_image(normal, pressure.ravel(), level).reshape(pressure.shape)
    tangential = disc.tangential_problem(pressure, acting=traction)
    if tangential.size and tangential.free:
        tractions, shifts = tangential.of_grid(traction, rigid)
        trial = tractions - tangential.shift(tractions, shifts) / tangential.operator.diagonal
        sticks = tangential.operator.elements[magnitude(trial) <= tangential.bound * (1 + 1e-8)]
        free = [tangential.directions[i] for i in tangential.free]
        if sticks.size:
            moved = disc.pressure_to_shift.apply((image - pressure)[None]).reshape(2, -1)[:, sticks].mean(axis=1)
            rigid = rigid - np.where(np.isin((0, 1), free), moved, 0.0)
    largest, bound = float(magnitude(traction.reshape(2, -1)).max()), float(tangential.bound.max(initial=0.0))
    part = largest / max(largest, FAINT * bound) if np.isfinite(bound) else 1.0
    return part * _of_tractions(disc, image, traction, rigid)


def magnitude(vectors: np.ndarray) -> np.ndarray:
    """Lengths of vectors.

    Parameters
    ----------
    vectors : ndarray, shape (c, n)
        Of one or two components, in any unit.

    Returns
    -------
    ndarray, shape (n,)
    """
    return np.abs(vectors[0]) if len(vectors) == 1 else np.hypot(*vectors)


def project(traction: np.ndarray, bound: np.ndarray) -> np.ndarray:
    """Projection of tractions on the disks, or the intervals, that the bound leaves.

    Parameters
    ----------
    traction : ndarray, shape (c, n)
        Dimensionless, as the bound.
    bound : ndarray, shape (n,)
        Radii, not negative; ``inf`` for no bound.

    Returns
    -------
    ndarray, shape (c, n)
    """
    size = magnitude(traction)
    beyond = size > bound
    return traction * np.where(beyond, bound / np.where(beyond, size, 1.0), 1.0)


def relative(value: float, scale: float) -> float:
    """A value by a scale; zero where there is no scale.

    Parameters
    ----------
    value, scale : float
        In one unit.
    """
    return 0.0 if scale == 0 else float(value / scale)  # NaN stays NaN


def worst(*values: float) -> float:
    """The largest, and NaN where one is: so that NaN never passes for a small residual.

    Parameters
    ----------
    *values : float
    """
    return float(np.max(values))


def normal_residual(
    problem: NormalProblem, pressure: np.ndarray, rigid: np.ndarray, elastic: np.ndarray | None = None
) -> float:
    """Largest ``|p - max(p - e/rho, 0)|`` by the largest pressure; with the force, what it lacks.

    A p is taken from `elastic` where that is known already.

    Parameters
    ----------
    problem : NormalProblem
    pressure : ndarray, shape (n,)
        Dimensionless.
    rigid : ndarray, shape (1,)
        The approach, dimensionless.
    elastic : ndarray, shape (n,), optional
        A p, where it is known already.

    Returns
    -------
    float
    """
    image = _normal_image(problem, pressure, rigid, elastic)
    residual = relative(np.abs(pressure - image).max(), worst(np.abs(pressure).max(), image.max()))
    if problem.force is not None:
        residual = worst(residual, abs(pressure.sum() * problem.area / problem.force - 1))
    return residual


def _normal_image(
    problem: NormalProblem, pressure: np.ndarray, rigid: np.ndarray, elastic: np.ndarray | None = None
) -> np.ndarray:
    """The pressures ``max(p - e/rho, 0)`` that the natural map has in place of p."""
    elastic = problem.operator.apply(pressure[None])[0] if elastic is None else elastic
    distance = problem.distance - rigid[0] + elastic
    return np.maximum(pressure - distance / problem.operator.diagonal, 0.0)


def tangential_residual(
    problem: TangentialProblem, traction: np.ndarray, rigid: np.ndarray, shift: np.ndarray | None = None
) -> float:
    """Largest ``|p - Proj(p - E/rho)|`` by the largest traction; with forces prescribed, what they lack.

    E is taken from `shift` where that is known already.

    Parameters
    ----------
    problem : TangentialProblem
    traction : ndarray, shape (c, n)
        Dimensionless.
    rigid : ndarray, shape (c,)
        Unknown part of the rigid shift, dimensionless.
    shift : ndarray, shape (c, n), optional
        E, where it is known already.

    Returns
    -------
    float
    """
    shift = problem.shift(traction, rigid) if shift is None else shift
    with np.errstate(over="ignore", invalid="ignore"):  # an iterate that diverges ends at NaN, which is no residual
        image = project(traction - shift / problem.operator.diagonal, problem.bound)
    size = worst(magnitude(traction).max(), magnitude(image).max())
    residual = relative(float(magnitude(traction - image).max()), float(size))
    for i in problem.free:
        force = problem.force[i]
        assert force is not None
        lacking = abs(traction[i].sum() * problem.area - force)
        scale = size * problem.area * math.sqrt(problem.size)
        residual = worst(residual, relative(lacking, scale if scale > 0 else abs(force)))  # nothing carries nothing
    return residual


@one_blas_thread()
def gap(
    problem: TangentialProblem, traction: np.ndarray, rigid: np.ndarray, shift: np.ndarray | None = None
) -> tuple[float, float]:
    """Duality gap of admissible tractions, absolute and relative (dimensionless).

    Each element's share ``g |E| + p'E`` is positive on its own (Cauchy and Schwarz), so nothing cancels in the
    sum. For a shift it is the potential energy (214) plus the complementary energy (215) of the tractions. With
    infinite friction the gap is ``E'S^-1 E``, the squared distance to the solution or more. E is taken from `shift`
    where that is known already.

    Parameters
    ----------
    problem : TangentialProblem
    traction : ndarray, shape (c, n)
        Dimensionless.
    rigid : ndarray, shape (c,)
        Unknown part of the rigid shift, dimensionless.
    shift : ndarray, shape (c, n), optional
        E, where it is known already.

    Returns
    -------
    absolute, relative : float
    """
    shift = problem.shift(traction, rigid) if shift is None else shift
    if problem.no_slip:
        definite = problem.symmetric_part
        error = np.inf if definite is None else float(definite.energies(shift[None])[0])
        work = abs(float(np.sum(traction * (problem.rigid_shift + rigid[:, None]))))
        return error * problem.area, relative(error, work)
    work = problem.bound @ magnitude(problem.rigid_shift + rigid[:, None])
    total = float(np.sum(np.maximum(shares(problem.bound, traction, shift), 0.0)))
    return total * problem.area, relative(total, float(work))


def shares(bound: np.ndarray, traction: np.ndarray, shift: np.ndarray) -> np.ndarray:
    """What each element has of the gap, ``g |E| + p'E``, (n,), without the cancellation of that form.

    It is ``(g - |p|) |E| + (|p| |E| + p'E)``. Where the traction goes against the shift, the second part is the square
    of their vector product by ``|p| |E| - p'E``: a traction turned by 1e-9 is seen, though the cosine of that is one.

    Parameters
    ----------
    bound : ndarray, shape (n,)
        Traction bound g.
    traction, shift : ndarray, shape (c, n)

    Returns
    -------
    ndarray, shape (n,)
    """
    size, length = magnitude(traction), magnitude(shift)
    with np.errstate(invalid="ignore"):  # infinite bounds
        slack = np.where(np.abs(bound - size) <= ROUNDING * bound, 0.0, bound - size)
    along, most = np.sum(traction * shift, axis=0), size * length
    across = traction[0] * shift[1] - traction[1] * shift[0] if len(traction) == 2 else np.zeros_like(size)
    against = along < 0
    turned = np.where(against, across * (across / np.where(against, most - along, 1.0)), most + along)
    return np.asarray(slack * length + turned)


@one_blas_thread()
def normal_gap(
    problem: NormalProblem, pressure: np.ndarray, rigid: np.ndarray, elastic: np.ndarray | None = None
) -> tuple[float, float]:
    """Duality gap of the normal problem, absolute and relative to ``p'A p`` (dimensionless).

    It bounds ``(p - p*)'A (p - p*)``. With the force prescribed it is ``sum(p) (d - min(h + A p))``, d the mean
    of ``h + A p`` weighted by p; with the approach prescribed ``p'e`` plus the deepest overlap times a bound on
    ``sum(p*)``, ``(d - min h) / min A``. A p is taken from `elastic` where that is known already.

    Parameters
    ----------
    problem : NormalProblem
    pressure : ndarray, shape (n,)
        Dimensionless.
    rigid : ndarray, shape (1,)
        The approach, dimensionless.
    elastic : ndarray, shape (n,), optional
        A p, where it is known already.

    Returns
    -------
    absolute, relative : float
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
    return value * problem.area, relative(value, float(pressure @ elastic))
