"""Potential and complementary energy of the two problems (paper, 4.4): equal at the solution, and nowhere else.

With the pressure or the traction bound fixed, U has its least and C its largest value there. U - C is the duality gap.
"""

from __future__ import annotations

import numpy as np

from varcontact.discrete.problems import NormalProblem, TangentialProblem
from varcontact.discrete.residuals import magnitude
from varcontact.errors import SceneError
from varcontact.system.threads import one_blas_thread


def complementary_energy(problem: NormalProblem | TangentialProblem, traction: np.ndarray) -> float:
    """C of pressures, or of the tractions of a shift (215), dimensionless.

    Parameters
    ----------
    problem : NormalProblem or TangentialProblem
    traction : ndarray, shape (n,) or (c, n)
        Admissible: pressures that are zero or positive, or tractions within the bound; with the prescribed force.

    Returns
    -------
    float
        ``-(1/2 p'A p + (h - d)'p)`` times the element's area, or ``-(1/2 p'A p + W'p)``; h or W alone where the force
        is prescribed.

    Raises
    ------
    SceneError
        In steady rolling, which has no energy.
    """
    _check(problem)
    elastic = problem.operator.apply(np.atleast_2d(traction))
    return -problem.area * float(np.sum(traction * (0.5 * elastic + _given(problem))))


@one_blas_thread()
def potential_energy(
    problem: NormalProblem | TangentialProblem, traction: np.ndarray, rigid: np.ndarray | None = None
) -> float:
    """U of the displacements that pressures, or the tractions of a shift, cause (214), dimensionless.

    Parameters
    ----------
    problem : NormalProblem or TangentialProblem
    traction : ndarray, shape (n,) or (c, n)
        Any: the displacements are ``A p``.
    rigid : ndarray, shape (c,), optional
        Of a tangential problem, the rigid shift that was found where a force is prescribed; zero if not given.

    Returns
    -------
    float
        ``1/2 p'A p`` times the element's area. Under a prescribed normal force less its work ``F d``, with the largest
        approach d without overlap; under a given approach, displacements that leave an overlap are not admissible, and
        U is not a bound. Of a shift with ``sum(g |E|)``, and under a prescribed force its work by `rigid` in addition.

    Raises
    ------
    SceneError
        In steady rolling, which has no energy.
    """
    _check(problem)
    elastic = problem.operator.apply(np.atleast_2d(traction))
    stored = 0.5 * problem.area * float(np.sum(traction * elastic))
    if isinstance(problem, NormalProblem):
        level = float(np.min(problem.distance + elastic[0]))
        return stored - (0.0 if problem.force is None else problem.force * level)
    free = np.zeros(problem.components) if rigid is None else rigid
    shift = magnitude(elastic + problem.rigid_shift + free[:, None])
    lost = 0.0 if problem.no_slip else problem.area * float(problem.bound @ shift)
    return stored + lost + sum(float(free[i]) * (problem.force[i] or 0.0) for i in problem.free)


def _given(problem: NormalProblem | TangentialProblem) -> np.ndarray:
    """The displacement that a problem begins with: h, h - d or W."""
    if isinstance(problem, TangentialProblem):
        return problem.rigid_shift
    return problem.distance - (problem.approach or 0.0)


def _check(problem: NormalProblem | TangentialProblem) -> None:
    if isinstance(problem, TangentialProblem) and not problem.symmetric:
        raise SceneError(
            "problem",
            "steady rolling",
            "of a shift, or of a step",
            message="problem: steady rolling has a gap, and no energy; give the problem of a shift or a step",
        )
