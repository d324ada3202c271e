"""CVXPY: the programs stated in its language, for any solver it knows."""

from __future__ import annotations

import warnings
from dataclasses import dataclass
from typing import Any

import numpy as np

from varcontact.discrete.problems import RawSolution
from varcontact.solvers.conic.accuracy import options
from varcontact.solvers.conic.programs import ConicProgram
from varcontact.solvers.settings import Settings
from varcontact.system.interrupts import imported, interruptible


def solve(program: ConicProgram, settings: Settings, name: str) -> RawSolution:
    """Solve a program; one with the same matrices is compiled once, and its vectors are parameters.

    Parameters
    ----------
    program : ConicProgram
    settings : Settings
        Its set-ups are where its model is kept.
    name : str
        Of the solver, as CVXPY has it.

    Returns
    -------
    RawSolution
        In the scales of the problem behind the program.
    """
    tol, setups = settings.tol, settings.setups
    cp = imported("cvxpy")
    key, program = ("cvxpy", name, tol), program.polyhedral()
    found = setups.find(key, program) if setups is not None else None
    model = found[0] if found is not None and found[1] else _Model.of(program)
    model.q.value, model.b.value = program.q, program.b
    if setups is not None:
        setups.keep(key, program, model)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # that an answer may be inaccurate is judged by our own residual
            interruptible(lambda: model.problem.solve(solver=name, warm_start=True, **options(name, tol)))
        status, iterations = str(model.problem.status), model.problem.solver_stats.num_iters
    except cp.SolverError as error:
        status, iterations = f"SolverError: {str(error).splitlines()[0]}", 0
    traction, rigid = program.recover(model.variables(), model.multipliers())
    return RawSolution(traction, rigid, int(iterations or 0), status, status == cp.OPTIMAL)


@dataclass(frozen=True, eq=False)
class _Model:
    """A program in CVXPY's terms."""

    problem: Any
    x: Any
    q: Any
    b: Any
    constraints: list[tuple[np.ndarray, Any]]

    @classmethod
    def of(cls, program: ConicProgram) -> _Model:
        import cvxpy as cp
        from scipy.sparse import triu

        x, q, b = cp.Variable(program.q.size), cp.Parameter(program.q.size), cp.Parameter(program.b.size)
        quadratic = program.P + triu(program.P, 1).T
        slack = b - program.A @ x
        constraints = []
        for kind in ("zero", "nonnegative", "second_order"):
            rows = np.flatnonzero(program.kinds == kind)
            if rows.size == 0:
                continue
            if kind == "zero":
                constraint = program.A[rows] @ x == b[rows]
            elif kind == "nonnegative":
                constraint = program.A[rows] @ x <= b[rows]
            else:  # all of them radius, x, y
                radius, along_x, along_y = (slack[rows[i::3]] for i in range(3))
                constraint = cp.SOC(radius, cp.vstack([along_x, along_y]), axis=0)
            constraints.append((rows, constraint))
        objective = 0.5 * cp.QuadForm(x, cp.psd_wrap(quadratic)) + q @ x
        return cls(cp.Problem(cp.Minimize(objective), [c for _, c in constraints]), x, q, b, constraints)

    def variables(self) -> np.ndarray:
        return np.full(self.x.size, np.nan) if self.x.value is None else np.asarray(self.x.value)

    def multipliers(self) -> np.ndarray:
        """Of equalities and inequalities; nobody asks for those of the cones."""
        z = np.full(self.b.size, np.nan)
        for rows, constraint in self.constraints:
            dual = constraint.dual_value
            if isinstance(dual, np.ndarray) and dual.size == rows.size:
                z[rows] = dual.ravel()
        return z
