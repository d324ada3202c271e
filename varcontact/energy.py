"""Energies, duality gap and residuals of the discrete problems, and how to get
these from a solution.

Examples
--------
U and C of the paper's (214) and (215) are equal at the solution of a shift:

>>> import varcontact as vc
>>> from varcontact import energy
>>> scene = vc.Scene(
...     bodies=vc.Bodies(G=1.0, nu=0.28), surface=vc.Ellipse(a=1.0, b=1.0), normal_force=1.0,
...     friction=0.3, motion=vc.Shift(ux=0.05), grid=vc.Grid(nx=12, ny=12))
>>> posed = energy.posed(vc.solve(scene))
>>> U = energy.potential_energy(posed.tangential, posed.traction) * posed.unit
>>> C = energy.complementary_energy(posed.tangential, posed.traction) * posed.unit
>>> print(f"{U:.6f} {C:.6f}", energy.gap(posed.tangential, posed.traction, posed.rigid)[1] < 1e-12)
0.002796 0.002796 True
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from varcontact import checks
from varcontact.discrete.certificate import Certificate
from varcontact.discrete.discretisation import discretise
from varcontact.discrete.problems import NormalProblem, TangentialProblem
from varcontact.discrete.residuals import (
    complementary_energy,
    gap,
    normal_gap,
    normal_residual,
    potential_energy,
    tangential_residual,
)
from varcontact.discrete.state import normal_as_solved, with_subgrid
from varcontact.discrete.stick_slip import unit_slip
from varcontact.errors import SceneError
from varcontact.results.physical import approach_on_grid
from varcontact.results.solution import Solution
from varcontact.scene.motion import Shift, Steady

__all__ = [
    "Certificate", "Posed", "complementary_energy", "gap", "normal_gap", "normal_residual",
    "posed", "potential_energy", "tangential_residual"
]  # fmt: skip


@dataclass(frozen=True, eq=False)
class Posed:
    """The discrete problems that a solution solves, and the solution in their terms: dimensionless.

    Attributes
    ----------
    normal : NormalProblem
    pressure : ndarray, shape (n,)
        On all elements of the grid.
    approach : ndarray, shape (1,)
        From the least undeformed distance; NaN in line contact without a
        reference depth.
    tangential : TangentialProblem or None
        None without a motion, and without friction.
    traction : ndarray, shape (c, m)
        On the elements that can carry any.
    rigid : ndarray, shape (c,)
        Rigid shift that was found where a force is prescribed.
    unit : float
        The energy that a dimensionless one of 1 is [force length].
    """

    normal: NormalProblem
    pressure: np.ndarray
    approach: np.ndarray
    tangential: TangentialProblem | None
    traction: np.ndarray
    rigid: np.ndarray
    unit: float


def posed(solution: Solution) -> Posed:
    """The problems that a solution solves, each with the other's final tractions.

    Parameters
    ----------
    solution : Solution

    Returns
    -------
    Posed

    Raises
    ------
    SceneError
        For what is no Solution; for a step of a history, which begins with the
        displacements of the step before.
    """
    checks.kind("solution", solution, Solution)
    scene, motion = solution.scene, solution.motion
    if not isinstance(motion, Steady | Shift | None):
        raise SceneError(
            "solution", "a step of a history", "one of steady rolling, a shift or normal contact"
        )
    disc = discretise(scene, solution.grid)
    if not scene.force_is_sum:
        disc = disc.held_at(approach_on_grid(solution))
    disc = with_subgrid(disc, solution.pressure_on_parts)
    if solution.friction is not None:
        disc = disc.with_loading(friction=solution.friction)
    pressure = solution.pressure / disc.scales.pressure
    traction = solution.traction / disc.scales.pressure
    approach = (approach_on_grid(solution) - disc.base) / disc.scales.displacement
    normal, pressed, level = normal_as_solved(disc, pressure, approach, traction)
    unit = disc.scales.force * disc.scales.displacement
    if motion is None or scene.frictionless:
        return Posed(normal, pressed, level, None, np.zeros((2, 0)), np.zeros(2), unit)
    tangential = disc.tangential_problem(pressure, acting=traction)
    rigid = (np.array(solution.creepage[:2]) - motion.rigid[:2]) * unit_slip(disc)
    return Posed(normal, pressed, level, tangential, *tangential.of_grid(traction, rigid), unit)
