"""OSQP: operator splitting for quadratic programs."""

from __future__ import annotations

import numpy as np

from varcontact.discrete.problems import RawSolution
from varcontact.solvers.conic.accuracy import BACKENDS
from varcontact.solvers.conic.programs import ConicProgram
from varcontact.solvers.settings import Settings
from varcontact.system.interrupts import interruptible


def solve(program: ConicProgram, settings: Settings) -> RawSolution:
    """Solve a program without cones of two components; a set-up with the same structure starts at its last answer.

    Parameters
    ----------
    program : ConicProgram
    settings : Settings
        Its set-ups are where its set-up is kept.

    Returns
    -------
    RawSolution
        In the scales of the problem behind the program.
    """
    tol, setups = settings.tol, settings.setups
    import osqp

    key, program = ("osqp", tol), program.polyhedral()
    lower = np.where(program.kinds == "zero", program.b, -np.inf)
    found = setups.find(key, program) if setups is not None else None
    if found is not None:
        solver, same = found
        matrices = {} if same else {"Px": program.P.data, "Ax": program.A.data}
        solver.update(q=program.q, l=lower, u=program.b, **matrices)
    else:
        solver = osqp.OSQP()
        options = BACKENDS["osqp"].options(tol)
        data = program.P, program.q, program.A, lower, program.b
        interruptible(lambda: solver.setup(*data, verbose=False, time_limit=settings.seconds_left, **options))
    if setups is not None:
        setups.keep(key, program, solver)
    result = interruptible(lambda: solver.solve(raise_error=False))
    info = result.info
    if info.status_val == osqp.SolverStatus.OSQP_SIGINT:
        raise KeyboardInterrupt
    traction, rigid = program.recover(np.array(result.x), np.array(result.y))
    solved = bool(info.status_val == osqp.SolverStatus.OSQP_SOLVED)
    return RawSolution(traction, rigid, int(info.iter), str(info.status), solved)
