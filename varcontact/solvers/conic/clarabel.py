"""Clarabel: interior points for quadratic objectives over cones."""

from __future__ import annotations

import numpy as np

from varcontact.discrete.problems import RawSolution
from varcontact.solvers.conic.accuracy import BACKENDS
from varcontact.solvers.conic.programs import ConicProgram
from varcontact.solvers.settings import Settings
from varcontact.system.interrupts import interruptible


def solve(program: ConicProgram, settings: Settings) -> RawSolution:
    """Solve a program; a set-up with the same structure takes new numbers, but no start.

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
    import clarabel

    key = ("clarabel", tol)
    found = setups.find(key, program) if setups is not None else None
    if found is not None:
        solver, same = found
        if same:
            solver.update(q=program.q, b=program.b)
        else:
            solver.update(P=program.P, q=program.q, A=program.A, b=program.b)
    else:
        kinds = {
            "zero": clarabel.ZeroConeT,
            "nonnegative": clarabel.NonnegativeConeT,
            "second_order": clarabel.SecondOrderConeT,
        }
        options = clarabel.DefaultSettings()
        options.verbose, options.time_limit = False, settings.seconds_left
        for name, value in BACKENDS["clarabel"].options(tol).items():
            setattr(options, name, value)
        cones = [kinds[kind](size) for kind, size in program.cones]
        solver = clarabel.DefaultSolver(program.P, program.q, program.A, program.b, cones, options)
    if setups is not None:
        setups.keep(key, program, solver)
    recover = program.recover
    del program  # the solver has its own copy of the dense matrices
    result = interruptible(solver.solve)
    traction, rigid = recover(np.array(result.x), np.array(result.z))
    solved = bool(result.status == clarabel.SolverStatus.Solved)
    return RawSolution(traction, rigid, int(result.iterations), str(result.status), solved)
