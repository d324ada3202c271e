"""Residuals, duality gap and energies of given tractions (paper, section 4).

Everything here is computed from the problem's own data, with products by FFT,
for tractions from any source: no solver's word enters.
"""

from __future__ import annotations

import math

import numpy as np

from varcontact.discrete.discretisation import Discretisation
from varcontact.discrete.positive_definite import positive_definite
from varcontact.discrete.problems import NormalProblem, TangentialProblem
from varcontact.discrete.state import ContactState, normal_as_solved
from varcontact.discrete.stick_slip import with_implied_fields
from varcontact.errors import SceneError
from varcontact.interfaces.potential import magnitude
from varcontact.system.process import changed, one_blas_thread

SMALL_TRACTION = 1e-6
"""Part of the traction bound below which errors of tractions due to wrong pressures are measured
relative to the bound."""


def residuals(disc: Discretisation, state: ContactState) -> tuple[float, float, float]:
    """Natural-map residuals of the normal and of the tangential problem, each with the other's
    final tractions.

    The third is what the normal one does to the tractions of unlike bodies. All are relative to the
    largest pressure or traction.
    """
    disc = with_implied_fields(disc, state)
    normal, pressure, approach = normal_as_solved(
        disc, state.pressure, state.approach, state.traction
    )
    elastic = normal.operator.apply(pressure[None])[0]
    tangential = disc.tangential_problem(state.pressure, acting=state.traction)
    shift = tangential.shift(*tangential.of_grid(state.traction, state.rigid))
    return (
        normal_residual(normal, pressure, approach, elastic),
        residual_on_grid(tangential, state, shift),
        coupling_residual(disc, normal, tangential, state, approach, elastic, shift),
    )


def residual_on_grid(
    problem: TangentialProblem, state: ContactState, shift: np.ndarray | None = None
) -> float:
    """Residual of the tangential problem; tractions where no friction can carry them are errors in
    full. The E (c, n) of the problem may be given.
    """
    error = outside_friction(problem, state)
    if problem.size:
        tractions, shifts = problem.of_grid(state.traction, state.rigid)
        error = worst(error, tangential_residual(problem, tractions, shifts, shift))
    return error


def outside_friction(problem: TangentialProblem, state: ContactState) -> float:
    """The largest traction where no friction can carry one, relative to the largest of all."""
    size = magnitude(state.traction.reshape(2, -1))
    largest = float(size.max())
    size[problem.operator.elements] = 0.0
    return relative(float(size.max()), largest)


def coupling_residual(
    disc: Discretisation,
    normal: NormalProblem,
    tangential: TangentialProblem,
    state: ContactState,
    approach: np.ndarray,
    elastic: np.ndarray,
    shift: np.ndarray | None = None,
) -> float:
    """Error of the tractions of unlike bodies by the residual of the normal problem; 0 for like
    bodies. With the E (c, n) of the tangential one where that is known.

    A change of the pressures shifts the surfaces by K, and friction f makes that ``K/f`` times as
    large a part of the tractions: the less friction, the more exact the pressures have to be. So
    the tractions are judged under the pressures that the natural map has in place of these. Where a
    force is prescribed, the rigid shift follows the mean shift of the elements that stick: that
    changes the creepage, and no traction. Tractions of less than `SMALL_TRACTION` of the bound are
    measured relative to it: where hardly anything rubs, they may be nothing but rounding.
    """
    if disc.K == 0 or not state.traction.any():
        return 0.0
    pressure = state.pressure
    rigid = state.rigid
    image = _normal_image(normal, pressure.ravel(), approach, elastic).reshape(pressure.shape)
    # rigid shift where a force is prescribed
    if tangential.size and tangential.free:
        tractions, shifts = tangential.of_grid(state.traction, rigid)
        if shift is None:
            shift = tangential.shift(tractions, shifts)
        trial = tractions - shift / tangential.operator.diagonal
        sticks = tangential.operator.elements[magnitude(trial) <= tangential.bound * (1 + 1e-8)]
        free = [tangential.directions[i] for i in tangential.free]
        if sticks.size:
            change = disc.pressure_to_shift.apply((image - pressure)[None])
            rigid = rigid.copy()
            rigid[free] -= change.reshape(2, -1)[free][:, sticks].mean(axis=1)
    # residual under these pressures
    problem = disc.tangential_problem(image, acting=state.traction)
    residual = residual_on_grid(problem, changed(state, rigid=rigid))
    largest = float(magnitude(state.traction.reshape(2, -1)).max())
    bound = float(tangential.bound.max(initial=0.0))
    if not np.isfinite(bound):
        return residual
    return largest / max(largest, SMALL_TRACTION * bound) * residual


def relative(value: float, scale: float) -> float:
    """Value divided by a scale; zero if the scale is zero."""
    if scale == 0:
        return 0.0
    return float(value / scale)  # NaN stays NaN


def worst(*values: float) -> float:
    """Largest value, NaN if any is NaN: a NaN must not pass for a small residual."""
    if any(map(math.isnan, values)):
        return math.nan
    return float(max(values))


def normal_residual(
    problem: NormalProblem,
    pressure: np.ndarray,
    rigid: np.ndarray,
    elastic: np.ndarray | None = None,
) -> float:
    """Largest ``|p - max(p - e/rho, 0)|`` relative to the largest pressure; under a prescribed
    force also its error.

    Parameters
    ----------
    problem, pressure, rigid, elastic
        As of `normal_gap`.

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
    problem: NormalProblem,
    pressure: np.ndarray,
    rigid: np.ndarray,
    elastic: np.ndarray | None = None,
) -> np.ndarray:
    """The pressures ``max(p - e/rho, 0)`` that the natural map has in place of p."""
    if elastic is None:
        elastic = problem.operator.apply(pressure[None])[0]
    distance = problem.distance - rigid[0] + elastic
    return np.maximum(pressure - distance / problem.operator.diagonal, 0.0)


def tangential_residual(
    problem: TangentialProblem,
    traction: np.ndarray,
    rigid: np.ndarray,
    shift: np.ndarray | None = None,
) -> float:
    """Largest ``|p - Proj(p - E/rho)|`` relative to the largest traction; under
    prescribed forces also their errors.

    Parameters
    ----------
    problem, traction, rigid, shift
        As of `gap`.

    Returns
    -------
    float
    """
    if shift is None:
        shift = problem.shift(traction, rigid)
    problem = problem.under(traction)
    # a diverging iterate ends at NaN, and so does its residual
    with np.errstate(over="ignore", invalid="ignore"):
        own = problem.operator.diagonal
        image = problem.potential.projected(traction - shift / own, own)
        fields = np.concatenate([traction, image, traction - image], axis=1)
        *sizes, largest = magnitude(fields).reshape(3, -1).max(axis=1).tolist()
    size = worst(*sizes)
    residual = relative(largest, size)
    for i in problem.free:
        force = problem.force[i]
        assert force is not None
        error = abs(traction[i].sum() * problem.area - force)
        scale = size * problem.area * math.sqrt(problem.size)
        # without tractions the force itself is the scale
        if not scale > 0:
            scale = abs(force)
        residual = worst(residual, relative(error, scale))
    return residual


@one_blas_thread()
def gap(
    problem: TangentialProblem,
    traction: np.ndarray,
    rigid: np.ndarray,
    shift: np.ndarray | None = None,
) -> tuple[float, float]:
    """Duality gap of admissible tractions, absolute and relative (dimensionless).

    Each element's share ``g |E| + p'E`` is positive on its own (Cauchy and
    Schwarz), so nothing cancels in the sum. For a shift it is the potential
    energy (214) plus the complementary energy (215) of the tractions. With
    infinite friction the gap is ``E'S^-1 E``, the squared distance to the
    solution or more.

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
    if shift is None:
        shift = problem.shift(traction, rigid)
    if problem.no_slip:
        definite = problem.symmetric_part
        error = np.inf
        if definite is not None:
            error = float(definite.energies(shift[None])[0])
        work = abs(float(np.sum(traction * (problem.rigid_shift + rigid[:, None]))))
        return error * problem.area, relative(error, work)
    work = problem.bound @ magnitude(problem.rigid_shift + rigid[:, None])
    shares = problem.under(traction).potential.shares(traction, shift)
    total = float(np.maximum(shares, 0.0).sum())
    return total * problem.area, relative(total, float(work))


@one_blas_thread()
def normal_gap(
    problem: NormalProblem,
    pressure: np.ndarray,
    rigid: np.ndarray,
    elastic: np.ndarray | None = None,
) -> tuple[float, float]:
    """Duality gap of the normal problem, absolute and relative to ``p'A p`` (dimensionless).

    It bounds ``(p - p*)'A (p - p*)``. With the force prescribed it is
    ``sum(p) (d - min(h + A p))``, d the mean of ``h + A p`` weighted by p; with
    the approach prescribed ``p'e`` plus the deepest overlap times a bound on
    ``sum(p*)``, ``(d - min h) / min A``, or with numbers below zero n by the
    least eigenvalue in place of 1/min A.

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
    if elastic is None:
        elastic = problem.operator.apply(pressure[None])[0]
    if problem.force is not None:
        level = problem.distance + elastic
        value = float(pressure @ (level - level.min()))
    else:
        approach = float(rigid[0])
        distance = problem.distance + elastic - approach
        overlap = max(-float(distance.min()), 0.0)
        largest_sum = max(_largest_sum(problem, approach), float(pressure.sum()))
        value = float(pressure @ np.abs(distance)) + overlap * largest_sum
    return value * problem.area, relative(value, float(pressure @ elastic))


def _largest_sum(problem: NormalProblem, approach: float) -> float:
    """A bound on ``sum(p*)`` under a prescribed approach."""
    least = problem.operator.grid_operator.smallest
    if least <= 0:  # sum(p)^2 is at most n p'p
        definite = positive_definite(problem.operator)
        if definite is None:
            return math.inf
        least = definite.least / problem.distance.size
    if not least > 0:
        return math.inf
    return (approach - float(problem.distance.min())) / least


# ----------------------------------------------------------------------------- energies


def complementary_energy(problem: NormalProblem | TangentialProblem, traction: np.ndarray) -> float:
    """C of pressures, or of the tractions of a shift (215), dimensionless.

    Parameters
    ----------
    problem : NormalProblem or TangentialProblem
    traction : ndarray, shape (n,) or (c, n)
        Admissible: pressures that are zero or positive, or tractions within the
        bound; with the prescribed force.

    Returns
    -------
    float
        ``-(1/2 p'A p + (h - d)'p)`` times the element's area, or
        ``-(1/2 p'A p + W'p)``; h or W alone where the force is prescribed.

    Raises
    ------
    SceneError
        In steady rolling, which has no energy.
    """
    elastic = _elastic(problem, traction)
    if isinstance(problem, NormalProblem):
        rigid = problem.distance - (problem.approach or 0.0)
    else:
        rigid = problem.rigid_shift
    return -problem.area * float(np.sum(traction * (0.5 * elastic + rigid)))


@one_blas_thread()
def potential_energy(
    problem: NormalProblem | TangentialProblem,
    traction: np.ndarray,
    rigid: np.ndarray | None = None,
) -> float:
    """U of the displacements that pressures, or the tractions of a shift, cause
    (214), dimensionless.

    Parameters
    ----------
    problem : NormalProblem or TangentialProblem
    traction : ndarray, shape (n,) or (c, n)
        Any: the displacements are ``A p``.
    rigid : ndarray, shape (c,), optional
        Rigid shift of a tangential problem that was found where a force is
        prescribed; zero if not given.

    Returns
    -------
    float
        ``1/2 p'A p`` times the element's area. Under a prescribed normal force
        less its work ``F d``, with the largest approach d without overlap;
        under a given approach, displacements that leave an overlap are not
        admissible, and U is not a bound. Of a shift with ``sum(g |E|)``, and
        under a prescribed force its work by `rigid` in addition.

    Raises
    ------
    SceneError
        In steady rolling, which has no energy.
    """
    elastic = _elastic(problem, traction)
    stored = 0.5 * problem.area * float(np.sum(traction * elastic))
    if isinstance(problem, NormalProblem):
        if problem.force is None:
            return stored
        level = float(np.min(problem.distance + elastic[0]))
        return stored - problem.force * level
    if rigid is None:
        rigid = np.zeros(problem.components)
    shift = magnitude(elastic + problem.rigid_shift + rigid[:, None])
    lost = 0.0
    if not problem.no_slip:
        lost = problem.area * float(problem.bound @ shift)
    return stored + lost + sum(float(rigid[i]) * (problem.force[i] or 0.0) for i in problem.free)


def _elastic(problem: NormalProblem | TangentialProblem, traction: np.ndarray) -> np.ndarray:
    if isinstance(problem, TangentialProblem) and not problem.symmetric:
        raise SceneError(
            "problem",
            "steady rolling",
            "of a shift, or of a step: others have a gap, and no energy",
        )
    return problem.operator.apply(np.atleast_2d(traction))
