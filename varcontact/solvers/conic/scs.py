"""SCS: operator splitting for quadratic objectives over cones."""

from __future__ import annotations

import numpy as np

from varcontact.discrete.problems import RawSolution
from varcontact.solvers.conic.accuracy import BACKENDS
from varcontact.solvers.conic.programs import ConicProgram
from varcontact.solvers.settings import Settings
from varcontact.system.interrupts import interruptible

_ORDER = {"zero": "z", "nonnegative": "l", "second_order": "q"}


def solve(program: ConicProgram, settings: Settings) -> RawSolution:
    """Solve a program; a set-up with the same matrices is used again and starts at its last answer.

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
    import scs

    key = ("scs", tol)
    rows = np.concatenate([np.flatnonzero(program.kinds == kind) for kind in _ORDER])
    found = setups.find(key, program) if setups is not None else None
    if found is not None and found[1]:
        solver = found[0]
        solver.update(b=program.b[rows], c=program.q)
    else:
        data = {"P": program.P, "A": program.A.tocsr()[rows].tocsc(), "b": program.b[rows], "c": program.q}
        sizes: dict[str, list[int]] = {}
        for kind, size in program.cones:
            sizes.setdefault(_ORDER[kind], []).append(size)
        cone = {name: value if name == "q" else sum(value) for name, value in sizes.items()}
        options = BACKENDS["scs"].options(tol)
        solver = interruptible(
            lambda: scs.SCS(data, cone, verbose=False, time_limit_secs=settings.seconds_left, **options)
        )
    if setups is not None:
        setups.keep(key, program, solver)
    result = interruptible(solver.solve)
    info = result["info"]
    if info["status_val"] == scs.SIGINT:
        raise KeyboardInterrupt
    z = np.empty(rows.size)
    z[rows] = result["y"]
    traction, rigid = program.recover(np.array(result["x"]), z)
    return RawSolution(traction, rigid, int(info["iter"]), str(info["status"]), info["status_val"] == scs.SOLVED)
