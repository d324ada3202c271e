"""Cone programs of limit analysis: many second-order cones of six entries."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from varcontact.errors import NotConverged
from varcontact.system.process import interruptible

TOLERANCE = 1e-6
"""Relative gap and residual of a program: its answers are checked, and scaled to be feasible."""
ACCEPTED = ("Solved", "AlmostSolved", "InsufficientProgress")
"""Outcomes whose iterate is used."""


@dataclass(frozen=True, eq=False)
class Triplets:
    """Entries of a sparse matrix, collected piece by piece."""

    rows: list[np.ndarray]
    columns: list[np.ndarray]
    values: list[np.ndarray]

    @classmethod
    def empty(cls) -> Triplets:
        """Empty collection of entries."""
        return cls([], [], [])

    def add(self, rows: np.ndarray, columns: np.ndarray, values: np.ndarray) -> None:
        """Add entries."""
        for own, new in ((self.rows, rows), (self.columns, columns), (self.values, values)):
            own.append(np.broadcast_to(new, rows.shape).ravel())

    def matrix(self, shape: tuple[int, int]) -> Any:
        """The matrix, by columns."""
        from scipy import sparse

        places = (np.concatenate(self.rows), np.concatenate(self.columns))
        return sparse.csc_matrix((np.concatenate(self.values), places), shape=shape)


def yield_cones(
    entries: Triplets, first_row: int, curves: np.ndarray, first_columns: np.ndarray
) -> None:
    """Rows of ``|lambda e + r| <= radius`` for samples e (n, 5): lambda is variable 0, and the five
    of r begin at `first_columns` (n,).
    """
    row = first_row + 6 * np.arange(len(curves))
    for number in range(5):
        entries.add(row + 1 + number, np.zeros(len(curves), int), -curves[:, number])
        entries.add(row + 1 + number, first_columns + number, -np.ones(len(curves)))


def solve_cones(
    entries: Triplets, right: np.ndarray, equations: int, cost: np.ndarray, square: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Variables and multipliers of: minimise ``cost . x + square . x^2/2``, ``A x + s = right``, s
    zero in the `equations` that come first, and in cones of six after them.
    """
    import clarabel
    from scipy import sparse

    settings = clarabel.DefaultSettings()
    settings.verbose = False
    settings.max_threads = 1
    settings.presolve_enable = False
    settings.tol_gap_abs = TOLERANCE
    settings.tol_gap_rel = TOLERANCE
    settings.tol_feas = TOLERANCE
    cones = [clarabel.ZeroConeT(equations)]
    cones += [clarabel.SecondOrderConeT(6)] * ((len(right) - equations) // 6)
    matrix = entries.matrix((len(right), len(cost)))
    quadratic = sparse.diags(square).tocsc()
    solver = clarabel.DefaultSolver(quadratic, cost, matrix, right, cones, settings)
    found = interruptible(solver.solve)
    if str(found.status) not in ACCEPTED:
        residual = float(max(found.r_prim, found.r_dual))
        raise NotConverged(f"the cone program of the shakedown limit: {found.status}", residual)
    return np.array(found.x), np.array(found.z)
