"""What one requested accuracy means to each solver: one table, and what has to be installed for each."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True)
class Backend:
    """A solver behind one of the interfaces.

    Attributes
    ----------
    install : str
        Name of its wheel.
    options : callable
        From the accuracy wanted of the tractions, relative, to the solver's own keywords.
    cones : bool
        Whether it takes second-order cones, which Coulomb's disks need.
    """

    install: str
    options: Callable[[float], dict[str, Any]]
    cones: bool = False


def _interior(tol: float) -> float:
    """Interior points: tractions are as wrong as the gap is to the power 2/3 or less (1e-8 for a gap of 1e-12)."""
    return max(tol**1.5, 1e-14)


def _splitting(tol: float) -> float:
    """Operator splitting: residuals fall linearly, and to 1e-12 at the best."""
    return max(0.1 * tol, 1e-12)


def _clarabel(tol: float) -> dict[str, Any]:
    asked = max(_interior(tol), 1e-12)
    # The programs come well scaled: a rough answer needs neither of the last two, and a fifth of the time less.
    return {
        "tol_gap_abs": asked,
        "tol_gap_rel": asked,
        "tol_feas": asked,
        "max_iter": 200,
        "presolve_enable": False,
        "equilibrate_enable": asked < 1e-5,
        "iterative_refinement_enable": asked < 1e-5,
        # With steps of 0.99 of the way to the boundary, as it takes by default, iterates near the end lie so close to
        # it that rounding stops them, with tractions wrong by 1e-6 (at a shift 1e-3); with shorter ones they are good
        # to 1e-8, for twice the iterations.
        "max_step_fraction": 0.75 if asked < 1e-10 else 0.99,
        "direct_solve_method": "faer",  # dense factors: several times faster than qdldl
        # Its pool of threads does not survive a fork: the child would wait for it for ever. And the same digits come
        # out of any number of cores.
        "max_threads": 1,
    }


def _osqp(tol: float) -> dict[str, Any]:
    asked = _splitting(tol)
    return {"eps_abs": asked, "eps_rel": asked, "polishing": True, "max_iter": 20_000, "scaled_termination": False}


def _scs(tol: float) -> dict[str, Any]:
    asked = _splitting(tol)
    return {"eps_abs": asked, "eps_rel": asked, "max_iters": 50_000}


def _piqp(tol: float) -> dict[str, Any]:
    asked = _interior(tol)
    return {"eps_abs": asked, "eps_rel": asked, "check_duality_gap": True, "max_iter": 200}


def _proxqp(tol: float) -> dict[str, Any]:
    # From 1e-9 on its residuals tell something of the tractions: in the potential form they are wrong by 2e-2 at 1e-7.
    return {"eps_abs": max(min(0.01 * tol, 1e-9), 1e-12), "eps_rel": 0.0, "max_iter": 10_000}


def _daqp(tol: float) -> dict[str, Any]:
    asked = max(0.1 * tol, 1e-13)
    return {"primal_tol": asked, "dual_tol": asked, "iter_limit": 100_000}


def _highs(tol: float) -> dict[str, Any]:
    asked = max(0.1 * tol, 1e-10)
    return {
        "primal_feasibility_tolerance": asked,
        "dual_feasibility_tolerance": asked,
        "qp_regularization_value": min(asked, 1e-7),  # tractions are as wrong as this, by default 1e-7
    }


def _exact(_: float) -> dict[str, Any]:
    """An active-set method without a tolerance."""
    return {}


BACKENDS: dict[str, Backend] = {
    "clarabel": Backend("clarabel", _clarabel, cones=True),
    "osqp": Backend("osqp", _osqp),
    "scs": Backend("scs", _scs, cones=True),
    "piqp": Backend("piqp", _piqp),
    "proxqp": Backend("proxsuite", _proxqp),
    "daqp": Backend("daqp", _daqp),
    "quadprog": Backend("quadprog", _exact),
    "highs": Backend("highspy", _highs),
}
"""By the name in lower case, whether called directly, by qpsolvers or by CVXPY."""


OTHERS = {
    "copt": "coptpy",
    "cvxopt": "cvxopt",
    "ecos": "ecos",
    "gurobi": "gurobipy",
    "kvxopt": "kvxopt",
    "mosek": "mosek",
    "qoco": "qoco",
    "qpalm": "qpalm",
    "xpress": "xpress",
}
"""Wheels of further solvers behind qpsolvers or CVXPY: they run where they are installed, untested here."""


def options(name: str, tol: float) -> dict[str, Any]:
    """A solver's keywords for an accuracy; none (its own defaults) for one that is not in the table.

    Parameters
    ----------
    name : str
        As `BACKENDS` has it, in any case of letters.
    tol : float
        Accuracy wanted of the tractions, relative [-].
    """
    backend = BACKENDS.get(name.lower())
    return {} if backend is None else backend.options(tol)
