"""Clarabel: interior points for quadratic objectives over cones."""

from __future__ import annotations

import numpy as np

from varcontact.conic.programs import ConicProgram, gap_program, normal_program, shift_program
from varcontact.problem import NormalProblem, RawSolution, Settings, TangentialProblem


def solve_normal(problem: NormalProblem, settings: Settings) -> RawSolution:
    """The normal problem through its QP."""
    return _solve(normal_program(problem), settings)


def solve_tangential(problem: TangentialProblem, settings: Settings) -> RawSolution:
    """A shift through its SOCP, steady rolling through the gap program."""
    return _solve(shift_program(problem) if problem.symmetric else gap_program(problem), settings)


def _solve(program: ConicProgram, settings: Settings) -> RawSolution:
    import clarabel

    kinds = {
        "zero": clarabel.ZeroConeT,
        "nonnegative": clarabel.NonnegativeConeT,
        "second_order": clarabel.SecondOrderConeT,
    }
    options = clarabel.DefaultSettings()
    options.verbose = False
    options.max_iter = settings.max_iterations
    options.tol_gap_abs = options.tol_gap_rel = options.tol_feas = settings.tol
    options.presolve_enable = False
    # The programs come well scaled: a rough answer needs neither of these, and a fifth of the time less.
    options.equilibrate_enable = options.iterative_refinement_enable = settings.tol < 1e-5
    options.direct_solve_method = "faer"  # dense factors: several times faster than qdldl
    cones = [kinds[kind](size) for kind, size in program.cones]
    solver = clarabel.DefaultSolver(program.P, program.q, program.A, program.b, cones, options)
    recover = program.recover
    del program  # the solver has its own copy of the dense matrices
    result = solver.solve()
    traction, rigid = recover(np.array(result.x), np.array(result.z))
    return RawSolution(traction, rigid, int(result.iterations), str(result.status))
