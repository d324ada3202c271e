"""The methods by name: one dict per kind, and two families behind an interface."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from functools import partial
from importlib.util import find_spec

from varcontact import checks
from varcontact.discrete.problems import RawSolution, TangentialProblem
from varcontact.errors import SolverUnavailable
from varcontact.solvers.active_set.norm import norm
from varcontact.solvers.active_set.tang import tang, tang_safeguarded
from varcontact.solvers.conic.backends import (
    BACKENDS,
    OTHERS,
    WHEELS,
    solve_normal,
    solve_tangential,
)
from varcontact.solvers.interface import NormalSolver, Settings, TangentialSolver, counted
from varcontact.solvers.newton.normal import newton_normal
from varcontact.solvers.newton.tangential import newton_tangential
from varcontact.system.process import imported

NORMAL: dict[str, NormalSolver] = {
    "norm": lambda problem, settings, start: norm(problem, start, deadline=settings.deadline),
    "norm-single": lambda problem, settings, start: norm(
        problem, start, exchange="one", deadline=settings.deadline
    ),
    "newton": newton_normal,
}
TANGENTIAL: dict[str, TangentialSolver] = {
    "tang": lambda problem, settings, start: tang(problem, start, deadline=settings.deadline),
    "tang-exact": lambda problem, settings, start: tang(
        problem, start, newton="exact", deadline=settings.deadline
    ),
    "tang-safeguarded": lambda problem, settings, start: tang_safeguarded(
        problem, start, settings=settings
    ),
    "newton": newton_tangential,
}

MATRIX_FREE = ("newton",)
"""Methods of either kind that form no matrix, reach a given tolerance, and restart by
themselves."""

PROGRAM_SOLVERS = ("clarabel", "osqp", "scs")
"""Called directly; others through the families."""

CVXPY_SOLVERS = ("CLARABEL", "OSQP", "SCS", "PIQP", "PROXQP", "DAQP", "HIGHS")


def normal_methods() -> list[str]:
    """Names of all methods of the normal problem, installed or not; "hertz" is the closed form."""
    by_qpsolvers = [f"qpsolvers:{name}" for name in BACKENDS]
    by_cvxpy = [f"cvxpy:{name}" for name in CVXPY_SOLVERS]
    return ["hertz", *NORMAL, *PROGRAM_SOLVERS, *by_qpsolvers, *by_cvxpy]


def tangential_methods() -> list[str]:
    """Names of the methods that solve the tangential problem itself, installed or not."""
    conic = [name for name in PROGRAM_SOLVERS if BACKENDS[name].cones]
    by_cvxpy = [f"cvxpy:{name}" for name in CVXPY_SOLVERS if BACKENDS[name.lower()].cones]
    return [*TANGENTIAL, *conic, *by_cvxpy]


def normal_solver(name: str) -> NormalSolver:
    """The solver of the normal problem of that name, its calls counted."""
    return counted(
        name, NORMAL.get(name, lambda problem, settings, _: solve_normal(name, problem, settings))
    )


def tangential_solver(name: str) -> TangentialSolver:
    """The solver of the tangential problem of that name, its calls counted."""
    solver = counted(
        name,
        TANGENTIAL.get(
            name, lambda problem, settings, _: solve_tangential(name, problem, settings)
        ),
    )
    if name.startswith("tang"):
        return partial(_restarted, solver)
    return solver


def states_programs(name: str) -> bool:
    """True for a method that hands a convex program to a solver; its answer can be polished."""
    return name.split(":")[0] in (*PROGRAM_SOLVERS, "qpsolvers", "cvxpy")


def available(field: str, name: str, known: Iterable[str]) -> str:
    """A method's name, if there is such a method and what it needs is installed."""
    names = list(known)
    family, _, solver = str(name).partition(":")
    in_family = solver and any(other.startswith(f"{family}:") for other in names)
    if name not in names and not (in_family and _known_to(family, solver)):
        checks.choice(field, name, names)
    if states_programs(name):
        wheel = WHEELS.get(solver.lower(), "")
        missing = [package for package in (family, wheel) if package and find_spec(package) is None]
        if missing:
            raise SolverUnavailable(name, f"pip install {' '.join(missing)}")
    return name


def _known_to(interface: str, solver: str) -> bool:
    """True if an interface knows a solver that is not in our table, installed or not."""
    if solver.lower() in BACKENDS:
        return False  # in the table, which says that it is not suitable
    spelling = solver.upper() if interface == "cvxpy" else solver.lower()
    if solver.lower() in OTHERS and solver == spelling:
        return True
    if interface == "cvxpy":
        import cvxpy

        return solver in cvxpy.installed_solvers()
    import qpsolvers

    return solver in qpsolvers.available_solvers


def load_packages(*names: str) -> None:
    """Import what methods need, so that no time measured afterwards contains it."""
    for name in names:
        if states_programs(name):
            imported(name.partition(":")[0])


def _restarted(
    method: TangentialSolver,
    problem: TangentialProblem,
    settings: Settings,
    start: RawSolution | None,
) -> RawSolution:
    """TANG; where a start (the step, the pass or the creepage before) fails, TANG from its own
    start.
    """
    raw = method(problem, settings, start)
    if start is None or raw.solved:
        return raw
    restarted = method(problem, settings, None)
    return replace(restarted, iterations=raw.iterations + restarted.iterations)
