"""Gradients beside those of diffcp, which differentiates cone programs (Agrawal, Barratt, Boyd,
Busseti and Moursi, J. Appl. Numer. Optim. 1 (2019) 107-115).
"""

from dataclasses import dataclass, replace

import numpy as np
import pytest
import scipy.sparse as sp

import varcontact as vc
from tests.gradients.differences import EXACT, contact
from varcontact.gradients.adjoint import LinearisedSolution

GRID = vc.Grid(nx=12, ny=12, dx=0.227, dy=0.227, x0=-1.2939, y0=-1.362)
FRICTION = 0.3


@dataclass(frozen=True)
class Shift:
    """Tractions of a shift, divided by the largest bound, minimise ``q'Mq/2 + W'q`` within discs of
    radii g: (W, g) of the elements, one after the other.
    """

    matrix: np.ndarray
    rigid: np.ndarray
    bound: np.ndarray

    @property
    def cones(self) -> dict[str, list[int]]:
        return {"q": [3] * self.bound.size + [2 + self.rigid.size]}

    @property
    def constraints(self) -> sp.csc_matrix:
        """Of (q, t): q_i within its disc, and ``q'Mq/2 <= t`` as a cone by M's factor."""
        discs = np.kron(np.eye(self.bound.size), [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]])
        factor = np.sqrt(2) * np.linalg.cholesky(self.matrix).T
        size = self.rigid.size
        rows = np.zeros((3 * self.bound.size + 2 + size, size + 1))
        rows[: len(discs), :size] = discs
        rows[len(discs), size] = 1.0
        rows[len(discs) + 1 : -1, :size] = factor
        rows[-1, size] = 1.0
        return sp.csc_matrix(-rows)

    @property
    def offset(self) -> np.ndarray:
        discs = np.kron(self.bound, [1.0, 0.0, 0.0])
        return np.concatenate([discs, [1.0], np.zeros(self.rigid.size), [-1.0]])

    @property
    def objective(self) -> np.ndarray:
        return np.append(self.rigid, 1.0)


def test_a_shift_is_differentiated_as_its_cone_program():
    """dF/dux and dF/df of 60 elements, part of which slip."""
    diffcp = pytest.importorskip("diffcp")
    solution = vc.solve(contact(motion=vc.Shift(ux=2e-3, uy=1e-3), grid=GRID), **EXACT)
    fields = LinearisedSolution.of(solution, "held").fields
    inside = solution.pressure > 0
    assert inside.sum() == 60
    assert solution.elements["stick"] > 0 < solution.elements["slip"]

    def ordered(field):
        return field[:, inside].T.ravel()

    # M in columns, in units of the largest bound
    pressure = solution.pressure[inside]
    unit = FRICTION * pressure.max()
    columns = []
    for row, column in np.argwhere(inside):
        for component in range(2):
            traction = np.zeros_like(fields.traction)
            traction[component, row, column] = unit
            moved = replace(fields, traction=traction)
            columns.append(ordered(moved.local_shift - fields.rigid_shift))
    matrix = np.array(columns)
    size = np.abs(matrix).max()
    bound = FRICTION * pressure / unit
    program = Shift(matrix / size, ordered(fields.rigid_shift) / size, bound)
    constraints = program.constraints
    tractions, _, _, derivative, _ = diffcp.solve_and_derivative(
        constraints,
        program.offset,
        program.objective,
        program.cones,
        mode="dense",
        solve_method="SCS",
        eps_abs=1e-10,
        eps_rel=1e-10,
        max_iters=200_000,
    )
    np.testing.assert_allclose(tractions[:-1], ordered(solution.traction) / unit, atol=1e-6)

    # changes of the objective by ux, and of the offset by the coefficient of friction
    along_x = np.append(np.tile([1.0, 0.0], inside.sum()) / size, 0.0)
    by_friction = np.zeros_like(program.offset)
    by_friction[: 3 * inside.sum() : 3] = bound / FRICTION
    same = 0.0 * constraints
    changes = {
        "ux": derivative(same, 0.0 * program.offset, along_x)[0],
        "friction": derivative(same, by_friction, 0.0 * program.objective)[0],
    }
    found = solution.gradient(["Fx", "Fy"], ("ux", "friction"), edge="held")
    for name, change in changes.items():
        forces = change[:-1].reshape(-1, 2).sum(axis=0) * unit * GRID.dx * GRID.dy
        np.testing.assert_allclose(found[name], forces, rtol=1e-4, atol=1e-6 * abs(forces).max())
