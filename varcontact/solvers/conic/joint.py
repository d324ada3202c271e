"""Pressure and tractions of unlike bodies as one convex program, under a fixed traction bound (paper, 4.5)."""

from __future__ import annotations

import numpy as np

from varcontact.discrete.problems import NormalProblem, RawSolution, TangentialProblem
from varcontact.solvers.conic.programs import ConicProgram, normal_program, normal_scales, shift_program, shift_scale
from varcontact.solvers.conic.solvers import solve_program
from varcontact.solvers.settings import Settings


def joint_program(normal: NormalProblem, tangential: TangentialProblem, coupling: np.ndarray) -> ConicProgram:
    """A shift of unlike bodies: ``min 1/2 p'A p + h'p_z + W'p_t, p_z >= 0, |p_t| <= g``, (215) with its sign changed.

    Both programs side by side, with the coupling blocks of A between them; only that the bound g is fixed, and not
    ``f p_z``, makes them one convex program.

    Parameters
    ----------
    normal, tangential : NormalProblem, TangentialProblem
        Without the displacements that each causes in the other.
    coupling : ndarray, shape (m, c n)
        A_zt, from tractions on the n elements that bear them to distances on the m of the normal problem.
    """
    from scipy.sparse import bmat, csc_matrix

    pressing, rubbing = normal_program(normal), shift_program(tangential)
    bound = np.tile(tangential.bound, tangential.components)
    _, displacement = normal_scales(normal)
    energy = displacement**2 / normal.operator.diagonal
    part = shift_scale(tangential) * tangential.bound.max() / energy  # the programs count energies in their own units
    cross = csc_matrix(coupling * (bound / displacement))
    m, rows = normal.distance.size, pressing.b.size

    def recover(x: np.ndarray, z: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        pressure, approach = pressing.recover(x[:m], z[:rows])
        traction, rigid = rubbing.recover(x[m:], z[rows:] / part)
        return np.concatenate([pressure, traction.ravel()]), np.concatenate([approach, rigid])

    return ConicProgram(
        P=bmat([[pressing.P, cross], [None, part * rubbing.P]], format="csc"),
        q=np.concatenate([pressing.q, part * rubbing.q]),
        A=bmat([[pressing.A, None], [None, rubbing.A]], format="csc"),
        b=np.concatenate([pressing.b, rubbing.b]),
        cones=pressing.cones + rubbing.cones,
        recover=recover,
    )


def solve_joint(
    name: str, normal: NormalProblem, tangential: TangentialProblem, coupling: np.ndarray, settings: Settings
) -> tuple[RawSolution, RawSolution]:
    """Pressure and tractions by a conic solver, see `joint_program`.

    Parameters
    ----------
    name : str
        A conic solver.
    normal : NormalProblem
        Of m elements.
    tangential : TangentialProblem
        Of n elements, with the traction bound fixed.
    coupling : ndarray, shape (m, c n)
        A_zt, distances by tractions.
    settings : Settings

    Returns
    -------
    pressure, traction : RawSolution
        Dimensionless, not yet judged.
    """
    raw = solve_program(name, joint_program(normal, tangential, coupling), settings)
    m = normal.distance.size
    pressure = RawSolution(raw.traction[:m], raw.rigid[:1], raw.iterations, raw.status, raw.solved)
    traction = RawSolution(
        raw.traction[m:].reshape(tangential.components, -1), raw.rigid[1:], raw.iterations, raw.status, raw.solved
    )
    return pressure, traction
