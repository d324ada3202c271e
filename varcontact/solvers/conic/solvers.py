"""Every conic and QP solver as a solver of contact problems, by name."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

from varcontact.discrete.problems import NormalProblem, RawSolution, TangentialProblem
from varcontact.solvers.conic import clarabel, cvxpy, osqp, qpsolvers, scs
from varcontact.solvers.conic.programs import (
    ConicProgram,
    gap_program,
    normal_potential,
    normal_program,
    shift_potential,
    shift_program,
)
from varcontact.solvers.settings import Settings, check_time

NORMAL_PROGRAMS: dict[str, Callable[[NormalProblem], ConicProgram]] = {
    "complementary": normal_program,
    "potential": normal_potential,
}
TANGENTIAL_PROGRAMS: dict[str, Callable[[TangentialProblem], ConicProgram]] = {
    "complementary": shift_program,
    "potential": shift_potential,
    "gap": gap_program,
}

Backend = Callable[[ConicProgram, Settings], RawSolution]


def backend(name: str) -> Backend:
    """The solver of programs behind a method's name, as "scs" or "cvxpy:SCS".

    Parameters
    ----------
    name : str
        Of a method that `states_programs`.

    Returns
    -------
    callable
        From a program and `Settings` to a `RawSolution`.
    """
    family, _, solver = name.partition(":")
    if family == "qpsolvers":
        return partial(qpsolvers.solve, name=solver)
    if family == "cvxpy":
        return partial(cvxpy.solve, name=solver)
    return {"clarabel": clarabel.solve, "osqp": osqp.solve, "scs": scs.solve}[family]


def solve_program(name: str, program: ConicProgram, settings: Settings) -> RawSolution:
    """A program by the solver of a name; one that ends at the deadline has no answer.

    Parameters
    ----------
    name : str
        As for `backend`.
    program : ConicProgram
    settings : Settings

    Raises
    ------
    OutOfTime
        At the deadline.
    """
    raw = backend(name)(program, settings)
    check_time(settings.deadline)
    return raw


def solve_normal(name: str, problem: NormalProblem, settings: Settings) -> RawSolution:
    """The normal problem through its QP.

    Parameters
    ----------
    name : str
        "clarabel", "osqp", "scs", or behind an interface as "cvxpy:SCS".
    problem : NormalProblem
    settings : Settings
        Formulation, accuracy and set-ups.

    Returns
    -------
    RawSolution
        Pressures (n,) and the approach (1,), dimensionless, not yet judged.
    """
    formulation = "potential" if settings.formulation == "potential" else "complementary"
    return solve_program(name, NORMAL_PROGRAMS[formulation](problem), settings)


def solve_tangential(name: str, problem: TangentialProblem, settings: Settings) -> RawSolution:
    """The tangential problem through a second-order-cone program; with one component, a quadratic program.

    One of its own: complementary energy for a symmetric problem (a shift, a step of a march), else the gap.

    Parameters
    ----------
    name : str
        As for `solve_normal`, a solver with second-order cones if c = 2.
    problem : TangentialProblem
    settings : Settings
        Formulation, accuracy and set-ups.

    Returns
    -------
    RawSolution
        Tractions (c, n) and rigid shifts (c,), dimensionless, not yet judged.
    """
    formulation = settings.formulation
    if formulation not in TANGENTIAL_PROGRAMS:
        formulation = "complementary" if problem.symmetric else "gap"
    return solve_program(name, TANGENTIAL_PROGRAMS[formulation](problem), settings)
