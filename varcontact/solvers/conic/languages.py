"""A convex program in the language of each solver, as its own interface takes it."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from varcontact.errors import SceneError
from varcontact.solvers.conic.programs import ConicProgram
from varcontact.system.process import imported

Matrices = Callable[[np.ndarray], np.ndarray]
KINDS = ("zero", "nonnegative", "second_order")
"""Kinds of cones, in the order of a program's rows."""


def full_quadratic(program: ConicProgram) -> Any:
    """Full matrix P, of which a program stores the upper triangle."""
    from scipy.sparse import triu

    return (program.P + triu(program.P, 1).T).tocsc()


def rows_of_kinds(program: ConicProgram) -> list[np.ndarray]:
    """Rows of the cones of each kind that a program has."""
    rows = [np.flatnonzero(program.kinds == kind) for kind in KINDS]
    return [each for each in rows if each.size]


def quadratic_only(program: ConicProgram, name: str) -> ConicProgram:
    """The program without second-order cones; a `SceneError` where it has some of two
    components.
    """
    program = program.polyhedral()
    if "second_order" in program.kinds:
        why = f"{name} solves QPs, and friction disks are second-order cones"
        raise SceneError("name", name, f"clarabel, cvxpy, scs or scipy here: {why}")
    return program


def for_clarabel(program: ConicProgram) -> tuple[Any, ...]:
    """(P, q, A, b, cones) of ``clarabel.DefaultSolver``."""
    import clarabel

    kinds = {
        "zero": clarabel.ZeroConeT,
        "nonnegative": clarabel.NonnegativeConeT,
        "second_order": clarabel.SecondOrderConeT,
    }
    cones = [kinds[kind](size) for kind, size in program.cones]
    return program.P, program.q, program.A, program.b, cones


def for_osqp(program: ConicProgram) -> dict[str, Any]:
    """Arguments of ``osqp.OSQP().setup``."""
    program = quadratic_only(program, "osqp")
    lower = np.where(program.kinds == "zero", program.b, -np.inf)
    return {"P": program.P, "q": program.q, "A": program.A, "l": lower, "u": program.b}


def for_scs(program: ConicProgram) -> tuple[dict[str, Any], dict[str, Any]]:
    """Data and cones of ``scs.SCS``."""
    data = {"P": program.P, "A": program.A, "b": program.b, "c": program.q}
    names = {"zero": "z", "nonnegative": "l", "second_order": "q"}
    sizes: dict[str, list[int]] = {}
    for kind, size in program.cones:
        sizes.setdefault(names[kind], []).append(size)
    cone: dict[str, Any] = {name: sum(sizes[name]) for name in ("z", "l") if name in sizes}
    if "q" in sizes:
        cone["q"] = sizes["q"]
    return data, cone


def for_qpsolvers(program: ConicProgram, dense: bool = False) -> Any:
    """A ``qpsolvers.Problem``, with `dense` matrices where its solver takes no others."""
    qpsolvers = imported("qpsolvers")
    program = quadratic_only(program, "qpsolvers")
    equal = program.kinds == "zero"
    matrices = [full_quadratic(program), program.A[~equal], program.A[equal]]
    if dense:
        P, G, A = (matrix.toarray() for matrix in matrices)
    else:
        P, G, A = (matrix.tocsc() for matrix in matrices)
    if not equal.any():
        return qpsolvers.Problem(P, program.q, G, program.b)
    return qpsolvers.Problem(P, program.q, G, program.b[~equal], A, program.b[equal])


def for_cvxpy(program: ConicProgram) -> Any:
    """A ``cvxpy.Problem`` of the variable "x", a constraint for each kind of cones."""
    cp = imported("cvxpy")
    program = program.polyhedral()
    x = cp.Variable(program.q.size, name="x")
    slack = program.b - program.A @ x
    constraints = []
    for rows in rows_of_kinds(program):
        kind = program.kinds[rows[0]]
        if kind == "zero":
            constraints.append(program.A[rows] @ x == program.b[rows])
        elif kind == "nonnegative":
            constraints.append(program.A[rows] @ x <= program.b[rows])
        else:  # all of them radius, x, y
            radius, along_x, along_y = (slack[rows[i::3]] for i in range(3))
            constraints.append(cp.SOC(radius, cp.vstack([along_x, along_y]), axis=0))
    objective = 0.5 * cp.QuadForm(x, cp.psd_wrap(full_quadratic(program))) + program.q @ x
    return cp.Problem(cp.Minimize(objective), constraints)


def for_scipy(program: ConicProgram) -> dict[str, Any]:
    """Arguments of ``scipy.optimize.minimize`` (SLSQP), for a few elements."""
    from scipy.optimize import LinearConstraint, NonlinearConstraint

    program = program.polyhedral()
    P = full_quadratic(program)
    A = program.A.tocsr()
    constraints: list[Any] = []
    for rows in rows_of_kinds(program):
        kind = program.kinds[rows[0]]
        if kind == "second_order":
            value, derivative = _squared_cones(A[rows].toarray(), program.b[rows])
            constraints.append(NonlinearConstraint(value, 0.0, np.inf, derivative))
            rows = rows[::3]  # and their radii are not negative
        limits = program.b[rows]
        lower = np.where(kind == "zero", limits, -np.inf)
        constraints.append(LinearConstraint(A[rows].toarray(), lower, limits))
    return {
        "fun": lambda x: float(x @ (0.5 * (P @ x) + program.q)),
        "jac": lambda x: P @ x + program.q,
        "x0": np.zeros(program.q.size),
        "method": "SLSQP",
        "constraints": constraints,
    }


def _squared_cones(A: np.ndarray, b: np.ndarray) -> tuple[Matrices, Matrices]:
    """Functions of x that have ``s_0^2 - s_1^2 - s_2^2`` of cones in turn, and its derivatives."""
    signs = np.array([1.0, -1.0, -1.0])

    def value(x: np.ndarray) -> np.ndarray:
        slack = (b - A @ x).reshape(-1, 3)
        return slack**2 @ signs

    def derivative(x: np.ndarray) -> np.ndarray:
        weights = -2 * (b - A @ x).reshape(-1, 3) * signs
        return np.einsum("ij,ijk->ik", weights, A.reshape(-1, 3, x.size))

    return value, derivative
