"""Every conic and QP solver as a solver of contact problems: one table of settings, one of solvers
by name, and one function for each interface.

The table says what one requested accuracy of the tractions means to each
solver, and what has to be installed.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from importlib.util import find_spec
from typing import TYPE_CHECKING, Any

import numpy as np

from varcontact.discrete.problems import NormalProblem, RawSolution, TangentialProblem
from varcontact.solvers.interface import Settings, check_time
from varcontact.solvers.trace import Reporter
from varcontact.system.process import imported, interruptible

if TYPE_CHECKING:
    from varcontact.solvers.conic.programs import ConicProgram


@dataclass(frozen=True)
class Backend:
    """A solver behind one of the interfaces.

    `options` turns the relative accuracy wanted of the tractions into the solver's own keywords;
    `cones` says whether it takes second-order cones, which Coulomb's disks need.
    """

    options: Callable[[float], dict[str, Any]]
    cones: bool = False


def _interior(tol: float) -> float:
    """Interior-point backend: the error of tractions is at most the gap to the power 2/3 (1e-8 for
    a gap of 1e-12).
    """
    return max(tol**1.5, 1e-14)


def _splitting(tol: float) -> float:
    """Operator-splitting backend: residuals fall linearly, to 1e-12 at best."""
    return max(0.1 * tol, 1e-12)


def _clarabel(tol: float) -> dict[str, Any]:
    gap = max(_interior(tol), 1e-12)
    return {
        "tol_gap_abs": gap,
        "tol_gap_rel": gap,
        "tol_feas": gap,
        "max_iter": 200,
        "presolve_enable": False,
        # The programs come well scaled: a rough answer needs neither of these two, and takes a
        # fifth of the time less.
        "equilibrate_enable": gap < 1e-5,
        "iterative_refinement_enable": gap < 1e-5,
        # With steps of 0.99 of the way to the boundary, as it takes by default, iterates near the
        # end lie so close to it that rounding stops them, with tractions wrong by 1e-6 (at a shift
        # 1e-3); with shorter ones they are good to 1e-8, for twice the iterations.
        "max_step_fraction": 0.75 if gap < 1e-10 else 0.99,
        "direct_solve_method": "faer",  # dense factors: several times faster than qdldl
        # Its pool of threads does not survive a fork: the child would wait for it for ever. And the
        # same digits come out of any number of cores.
        "max_threads": 1,
    }


def _highs(tol: float) -> dict[str, Any]:
    residual = max(0.1 * tol, 1e-10)
    return {
        "primal_feasibility_tolerance": residual,
        "dual_feasibility_tolerance": residual,
        # tractions are as wrong as this, by default 1e-7
        "qp_regularization_value": min(residual, 1e-7),
    }


def _both(eps: float, **others: Any) -> dict[str, Any]:
    return {"eps_abs": eps, "eps_rel": eps, **others}


BACKENDS: dict[str, Backend] = {
    "clarabel": Backend(_clarabel, cones=True),
    "osqp": Backend(
        lambda tol: _both(
            _splitting(tol), polishing=True, max_iter=20_000, scaled_termination=False
        )
    ),
    "scs": Backend(lambda tol: _both(_splitting(tol), max_iters=50_000), cones=True),
    "piqp": Backend(lambda tol: _both(_interior(tol), check_duality_gap=True, max_iter=200)),
    # From 1e-9 on its residuals tell something of the tractions: in the potential form they are
    # wrong by 2e-2 at 1e-7.
    "proxqp": Backend(
        lambda tol: {
            "eps_abs": max(min(0.01 * tol, 1e-9), 1e-12),
            "eps_rel": 0.0,
            "max_iter": 10_000,
        }
    ),
    "daqp": Backend(
        lambda tol: (
            dict.fromkeys(("primal_tol", "dual_tol"), max(0.1 * tol, 1e-13))
            | {"iter_limit": 100_000}
        )
    ),
    "quadprog": Backend(lambda _: {}),  # an active-set method without a tolerance
    "highs": Backend(_highs),
}
"""Backends by name in lower case, whether called directly, by qpsolvers or by CVXPY."""

OTHERS = ("copt", "cvxopt", "ecos", "gurobi", "kvxopt", "mosek", "qoco", "qpalm", "xpress")
"""Other solvers that qpsolvers or CVXPY can call: they run if installed, with their own defaults,
untested here."""

WHEELS = {name: name for name in (*BACKENDS, *OTHERS)}
WHEELS |= {"copt": "coptpy", "gurobi": "gurobipy", "highs": "highspy", "proxqp": "proxsuite"}
"""Packages that solvers need."""

FORMULATIONS = {"complementary": (True, False), "potential": (False, True), "gap": (True, True)}
"""Formulations: conditions of tractions (true or false), and of shifts."""


@dataclass(frozen=True)
class ProgramSolver:
    """A solver of programs by its name, called directly or behind an interface.

    `cones`: whether it takes second-order cones. `needs`: packages that have to be installed.
    """

    name: str
    call: Callable[[ConicProgram, Settings], RawSolution]
    cones: bool
    needs: tuple[str, ...]

    def solve(self, program: ConicProgram, settings: Settings) -> RawSolution:
        """The answer to a program; one that ends at the deadline raises `OutOfTime`."""
        raw = self.call(program, settings)
        check_time(settings.deadline)
        return raw

    def normal(self, problem: NormalProblem, settings: Settings) -> RawSolution:
        """The normal problem through its QP."""
        from varcontact.solvers.conic.programs import normal_program

        formulation = "potential" if settings.formulation == "potential" else "complementary"
        if not problem.symmetric:
            formulation = "gap"
        return self.solve(normal_program(problem, *FORMULATIONS[formulation]), settings)

    def tangential(self, problem: TangentialProblem, settings: Settings) -> RawSolution:
        """The tangential problem through a second-order-cone program; with one component, a
        quadratic program.

        Without a formulation: complementary energy for a symmetric problem (a shift, a step of a
        march), else the gap.
        """
        from varcontact.solvers.conic.programs import tangential_program

        formulation = settings.formulation
        if formulation not in FORMULATIONS:
            formulation = "complementary" if problem.symmetric else "gap"
        return self.solve(tangential_program(problem, *FORMULATIONS[formulation]), settings)


def _options(name: str, tol: float) -> dict[str, Any]:
    backend = BACKENDS.get(name.lower())
    return {} if backend is None else backend.options(tol)


def _by_clarabel(program: ConicProgram, settings: Settings) -> RawSolution:
    import clarabel

    from varcontact.solvers.conic.languages import for_clarabel

    options = clarabel.DefaultSettings()
    options.verbose = False
    options.time_limit = settings.seconds_left
    for name, value in _options("clarabel", settings.tol).items():
        setattr(options, name, value)
    problem = for_clarabel(_with_spare_variables(program))
    solver = clarabel.DefaultSolver(*problem, options)
    report = settings.stats.reporter()
    if report is not None:
        solver.set_termination_callback(partial(_reported, report, program.energy))
    result = interruptible(solver.solve)
    traction, rigid = program.recover(np.array(result.x), np.array(result.z))
    solved = bool(result.status == clarabel.SolverStatus.Solved)
    return RawSolution(traction, rigid, int(result.iterations), str(result.status), solved)


def _reported(report: Reporter, energy: float, info: Any) -> bool:
    """Record an iterate as Clarabel reports it; returns False, so that Clarabel continues."""
    report(objective=info.cost_primal * energy, gap=info.gap_abs * energy)
    return False


def _by_osqp(program: ConicProgram, settings: Settings) -> RawSolution:
    """OSQP, without cones of two components."""
    import osqp

    from varcontact.solvers.conic.languages import for_osqp

    solver = osqp.OSQP()
    program = program.polyhedral()
    options = {
        "verbose": False,
        "time_limit": settings.seconds_left,
        **_options("osqp", settings.tol),
    }
    interruptible(lambda: solver.setup(**for_osqp(program), **options))
    result = interruptible(lambda: solver.solve(raise_error=False))
    info = result.info
    if info.status_val == osqp.SolverStatus.OSQP_SIGINT:
        raise KeyboardInterrupt
    traction, rigid = program.recover(np.array(result.x), np.array(result.y))
    solved = bool(info.status_val == osqp.SolverStatus.OSQP_SOLVED)
    return RawSolution(traction, rigid, int(info.iter), str(info.status), solved)


def _by_scs(program: ConicProgram, settings: Settings) -> RawSolution:
    import scs

    from varcontact.solvers.conic.languages import for_scs

    data, cone = for_scs(program)
    options = {
        "verbose": False,
        "time_limit_secs": settings.seconds_left,
        **_options("scs", settings.tol),
    }
    solver = interruptible(lambda: scs.SCS(data, cone, **options))
    result = interruptible(solver.solve)
    info = result["info"]
    if info["status_val"] == scs.SIGINT:
        raise KeyboardInterrupt
    traction, rigid = program.recover(np.array(result["x"]), np.array(result["y"]))
    return RawSolution(
        traction, rigid, int(info["iter"]), str(info["status"]), info["status_val"] == scs.SOLVED
    )


def _by_qpsolvers(name: str, program: ConicProgram, settings: Settings) -> RawSolution:
    """A solver behind qpsolvers, without cones of two components."""
    from varcontact.solvers.conic.languages import for_qpsolvers

    qpsolvers = imported("qpsolvers")
    program = program.polyhedral()
    equal = program.kinds == "zero"
    problem = for_qpsolvers(program, dense=name in qpsolvers.dense_solvers)
    options = _options(name, settings.tol)
    unsolved_x = np.full(program.q.size, np.nan)
    unsolved_z = np.full(program.b.size, np.nan)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # solvers that take no keyword say so at every call
        try:
            result = interruptible(lambda: qpsolvers.solve_problem(problem, name, **options))
        # a program it cannot take: quadprog wants P positive definite
        except qpsolvers.QPError as error:
            traction, rigid = program.recover(unsolved_x, unsolved_z)
            return RawSolution(traction, rigid, 0, f"{type(error).__name__}: {error}", False)
    x = unsolved_x if result.x is None else np.asarray(result.x, dtype=float)
    z = unsolved_z
    for rows, multipliers in ((equal, result.y), (~equal, result.z)):
        if multipliers is not None and len(multipliers):
            z[rows] = multipliers
    iterations = getattr(result.extras.get("info"), "iter", 0)
    status = "Solved" if result.found else "NotFound"
    return RawSolution(*program.recover(x, z), int(iterations), status, bool(result.found))


def _by_cvxpy(name: str, program: ConicProgram, settings: Settings) -> RawSolution:
    """A solver behind CVXPY."""
    from varcontact.solvers.conic.languages import for_cvxpy, rows_of_kinds

    cp = imported("cvxpy")
    program = program.polyhedral()
    problem = for_cvxpy(program)
    x = problem.var_dict["x"]
    try:
        with warnings.catch_warnings():
            # the warning of an inaccurate answer is replaced by the package's own residual
            warnings.simplefilter("ignore")
            interruptible(lambda: problem.solve(solver=name, **_options(name, settings.tol)))
        status = str(problem.status)
        iterations = problem.solver_stats.num_iters
    except cp.SolverError as error:
        status = f"SolverError: {str(error).splitlines()[0]}"
        iterations = 0
    z = np.full(program.b.size, np.nan)
    for rows, constraint in zip(rows_of_kinds(program), problem.constraints, strict=True):
        dual = constraint.dual_value
        # multipliers of the cones are not needed
        if isinstance(dual, np.ndarray) and dual.size == rows.size:
            z[rows] = dual.ravel()
    values = np.full(program.q.size, np.nan) if x.value is None else np.asarray(x.value)
    traction, rigid = program.recover(values, z)
    return RawSolution(traction, rigid, int(iterations or 0), status, status == cp.OPTIMAL)


def _with_spare_variables(program: ConicProgram) -> ConicProgram:
    """A program with variables, alone in the objective as x^2, that shorten Clarabel's
    factorisation.

    Clarabel orders its linear systems by minimum degree, and leaves to the last, as dense, the rows
    with more than 15 sqrt(size) entries. Up to 500 elements that holds for the tractions of the gap
    program (2 c n entries) but not for its shifts (c n), and the order it then finds takes two to
    four times as long as with no row called dense. Spare variables enlarge the size and cost
    nothing.
    """
    from scipy.sparse import block_diag, identity

    if not {"shift", "bound"} <= program.rows.keys():
        return program
    tractions = program.variables["traction"].stop
    size = sum(program.A.shape)
    if tractions + 2 >= 15 * np.sqrt(size):
        return program
    spare = max(int(((2 * tractions + 16) / 15) ** 2) - size, 0)
    A = program.A.copy()
    A.resize(A.shape[0], A.shape[1] + spare)
    P = block_diag([program.P, identity(spare)], format="csc")
    return replace(program, P=P, q=np.concatenate([program.q, np.zeros(spare)]), A=A)


def behind_qpsolvers(solver: str) -> ProgramSolver:
    """A solver that qpsolvers calls by this name, as "piqp"; it states no cones."""
    call = partial(_by_qpsolvers, solver)
    return ProgramSolver(f"qpsolvers:{solver}", call, False, ("qpsolvers", *_wheels(solver)))


def behind_cvxpy(solver: str) -> ProgramSolver:
    """A solver that CVXPY calls by this name, as "SCS"; of one without an entry cones are asked."""
    backend = BACKENDS.get(solver.lower())
    cones = backend is None or backend.cones
    call = partial(_by_cvxpy, solver)
    return ProgramSolver(f"cvxpy:{solver}", call, cones, ("cvxpy", *_wheels(solver)))


def _wheels(solver: str) -> tuple[str, ...]:
    """Packages of a solver behind an interface, as far as known."""
    known = [name for name in WHEELS if name == solver.lower()]
    return tuple(WHEELS[name] for name in known)


BEHIND = {"qpsolvers": behind_qpsolvers, "cvxpy": behind_cvxpy}
"""Solvers behind an interface: by "qpsolvers:<name>" and "cvxpy:<NAME>" any that is installed."""

CVXPY_SOLVERS = ("CLARABEL", "OSQP", "SCS", "PIQP", "PROXQP", "DAQP", "HIGHS")

PROGRAM_SOLVERS: dict[str, ProgramSolver] = {
    solver.name: solver
    for solver in (
        ProgramSolver("clarabel", _by_clarabel, True, ("clarabel",)),
        ProgramSolver("osqp", _by_osqp, False, ("osqp",)),
        ProgramSolver("scs", _by_scs, True, ("scs",)),
        *map(behind_qpsolvers, BACKENDS),
        *map(behind_cvxpy, CVXPY_SOLVERS),
    )
}
"""Solvers of programs by name, installed or not."""


def unlisted(name: str) -> ProgramSolver | None:
    """A solver out of the table that an interface knows, as "cvxpy:GUROBI"; None if none does."""
    interface, _, solver = name.partition(":")
    # one with settings is in the table, which says where it is suitable
    if interface not in BEHIND or not solver or solver.lower() in BACKENDS:
        return None
    spellings = {"cvxpy": solver.upper(), "qpsolvers": solver.lower()}
    if solver.lower() in OTHERS and solver == spellings[interface]:
        return BEHIND[interface](solver)
    if find_spec(interface) is None:  # the caller is told that it is not installed
        return BEHIND[interface](solver)
    if interface == "cvxpy":
        installed = imported("cvxpy").installed_solvers()
    else:
        installed = imported("qpsolvers").available_solvers
    if solver not in installed:
        return None
    return BEHIND[interface](solver)
