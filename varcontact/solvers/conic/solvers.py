"""Every conic and QP solver as a solver of contact problems, by name."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

from varcontact.problem.problem import NormalProblem, RawSolution, TangentialProblem
from varcontact.solvers.conic import clarabel, cvxpy, osqp, qpsolvers, scs
from varcontact.solvers.conic.programs import (
    ConicProgram,
    gap_program,
    normal_potential,
    normal_program,
    shift_potential,
    shift_program,
)
from varcontact.solvers.conic.setups import Setups
from varcontact.solvers.settings import Settings

NORMAL_PROGRAMS: dict[str, Callable[[NormalProblem], ConicProgram]] = {
    "complementary": normal_program,
    "potential": normal_potential,
}
TANGENTIAL_PROGRAMS: dict[str, Callable[[TangentialProblem], ConicProgram]] = {
    "complementary": shift_program,
    "potential": shift_potential,
    "gap": gap_program,
}

Backend = Callable[[ConicProgram, float, Setups | None], RawSolution]


def backend(name: str) -> Backend:
    """The solver of programs behind a method's name, as "scs" or "cvxpy:SCS"."""
    family, _, solver = name.partition(":")
    if family == "qpsolvers":
        return partial(qpsolvers.solve, name=solver)
    if family == "cvxpy":
        return partial(cvxpy.solve, name=solver)
    return {"clarabel": clarabel.solve, "osqp": osqp.solve, "scs": scs.solve}[family]


def solve_normal(name: str, problem: NormalProblem, settings: Settings) -> RawSolution:
    """The normal problem through its QP."""
    formulation = "potential" if settings.formulation == "potential" else "complementary"
    return backend(name)(NORMAL_PROGRAMS[formulation](problem), settings.tol, settings.setups)


def solve_tangential(name: str, problem: TangentialProblem, settings: Settings) -> RawSolution:
    """The tangential problem through a second-order-cone program; with one component, a quadratic program.

    One of its own: complementary energy for a symmetric problem (a shift, a step of a march), else the gap.
    """
    formulation = settings.formulation
    if formulation not in TANGENTIAL_PROGRAMS:
        formulation = "complementary" if problem.symmetric else "gap"
    return backend(name)(TANGENTIAL_PROGRAMS[formulation](problem), settings.tol, settings.setups)
