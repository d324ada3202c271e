"""The arguments of `solve` by name, and the names of methods, for type checkers and editors."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Literal, TypedDict

from varcontact.results.solution import Solution

NormalName = Literal[
    "auto",
    "hertz",
    "norm",
    "norm-single",
    "newton",
    "clarabel",
    "osqp",
    "scs",
    "qpsolvers:clarabel",
    "qpsolvers:osqp",
    "qpsolvers:scs",
    "qpsolvers:piqp",
    "qpsolvers:proxqp",
    "qpsolvers:daqp",
    "qpsolvers:quadprog",
    "qpsolvers:highs",
    "cvxpy:CLARABEL",
    "cvxpy:OSQP",
    "cvxpy:SCS",
    "cvxpy:PIQP",
    "cvxpy:PROXQP",
    "cvxpy:DAQP",
    "cvxpy:HIGHS",
]
"""Methods of the normal problem."""
TangentialName = Literal[
    "auto",
    "tang",
    "tang-exact",
    "tang-safeguarded",
    "newton",
    "clarabel",
    "scs",
    "cvxpy:CLARABEL",
    "cvxpy:SCS",
    "fastsim",
    "fastsim-elliptic",
    "fastsim-weighted",
    "fastsim-weighted-elliptic",
    "linear",
    "vermeulen-johnson",
    "fastrip",
    "strip",
    "polach",
    "table",
]
"""Methods of the tangential problem, and theories."""
CouplingName = Literal["auto", "johnson", "panagiotopoulos", "joint", "newton"]
"""Loops around both problems."""
FormulationName = Literal["auto", "complementary", "potential", "gap", "marching"]
"""Formulations of the programs."""
MethodName = Literal["auto", "convex", "active-set", "kalker"]
"""Overall methods."""
CertifyName = Literal["auto", "full", "gap", "none"]
"""Levels of the certificate."""


class Options(TypedDict, total=False):
    """Arguments of `solve` that are given by name, see there."""

    formulation: FormulationName
    method: MethodName
    tol: float
    polish: bool | None
    start: Literal["stick", "slip"] | Solution | None
    certify: CertifyName | None
    refine: Literal["continuum"] | None
    progress: Callable[[str], None] | None
    store: str | Path | None
    accuracy: float | None
    time_budget: float | None
