"""qpsolvers: one call for many solvers of quadratic programs."""

from __future__ import annotations

import warnings
from typing import Any

import numpy as np

from varcontact.discrete.problems import RawSolution
from varcontact.solvers.conic.accuracy import options
from varcontact.solvers.conic.programs import ConicProgram
from varcontact.solvers.settings import Settings
from varcontact.system.interrupts import imported, interruptible


def solve(program: ConicProgram, settings: Settings, name: str) -> RawSolution:
    """Solve a program without cones of two components by a solver behind qpsolvers, started where it ended.

    Parameters
    ----------
    program : ConicProgram
    settings : Settings
        Its set-ups are where its answer is kept, as a start for the next program.
    name : str
        Of the solver, as qpsolvers has it.

    Returns
    -------
    RawSolution
        In the scales of the problem behind the program.
    """
    tol, setups = settings.tol, settings.setups
    qpsolvers = imported("qpsolvers")
    key, program = ("qpsolvers", name), program.polyhedral()
    equal = program.kinds == "zero"
    found = setups.find(key, program) if setups is not None else None
    quadratic = program.P + _strictly_upper(program.P).T
    parts: list[Any] = [quadratic, program.q, program.A[~equal], program.b[~equal], program.A[equal], program.b[equal]]
    if name in qpsolvers.dense_solvers:
        parts = [part.toarray() if hasattr(part, "toarray") else part for part in parts]
    else:
        parts = [part.tocsc() if hasattr(part, "tocsc") else part for part in parts]
    if not equal.any():
        parts[4:] = [None, None]
    problem = qpsolvers.Problem(*parts)
    start = None if found is None else found[0]
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # solvers that take no start, or no keyword, say so at every call
        try:
            result = interruptible(lambda: qpsolvers.solve_problem(problem, name, initvals=start, **options(name, tol)))
        except qpsolvers.QPError as error:  # a program it cannot take: quadprog wants P positive definite
            nothing = np.full(program.q.size, np.nan), np.full(program.b.size, np.nan)
            return RawSolution(*program.recover(*nothing), 0, f"{type(error).__name__}: {error}", False)
    x = np.full(program.q.size, np.nan) if result.x is None else np.asarray(result.x, dtype=float)
    z = np.full(program.b.size, np.nan)
    for rows, multipliers in ((equal, result.y), (~equal, result.z)):
        if multipliers is not None and len(multipliers):
            z[rows] = multipliers
    if setups is not None and result.found:
        setups.keep(key, program, x)
    iterations = getattr(result.extras.get("info"), "iter", 0)
    status = "Solved" if result.found else "NotFound"
    return RawSolution(*program.recover(x, z), int(iterations), status, bool(result.found))


def _strictly_upper(matrix: Any) -> Any:
    from scipy.sparse import triu

    return triu(matrix, 1)
