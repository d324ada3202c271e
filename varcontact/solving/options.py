"""The arguments of `solve`: their names for type checkers and editors, and checked together, once."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal, TypedDict

from varcontact import checks
from varcontact.discrete.certificate import LEVELS
from varcontact.errors import SceneError
from varcontact.results.plan import Plan
from varcontact.results.solution import Solution
from varcontact.scene.motion import Transient
from varcontact.scene.scene import Scene
from varcontact.solving.defect_correction.applicability import check_refine
from varcontact.solving.friction_law import check_start
from varcontact.solving.selection import select
from varcontact.solving.target import Target, target_of
from varcontact.solving.warm_start import check_saturation

TOLERANCE = 1e-8
"""Natural-map residual to reach if none is given. Every method reaches it, see docs/methods.md."""

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


@dataclass(frozen=True)
class SolveOptions:
    """How a scene is solved: the arguments of `solve`, checked once.

    Attributes
    ----------
    choices : tuple of str
        Names of the methods: normal, tangential, coupling, formulation, method.
    plan : Plan
        Of the scene as it is given.
    tol : float
    polish : bool
        Whether active sets take the answers of programs to rounding.
    start : str, Solution or None
    certify : str
    refine : bool
        Whether the solution is corrected towards the continuum.
    store : str, Path or None
    target : Target or None
        None: it is solved on its own grid.
    """

    choices: tuple[str, str, str, str, str]
    plan: Plan
    tol: float
    polish: bool
    start: str | Solution | None
    certify: str
    refine: bool
    store: str | Path | None
    target: Target | None

    @classmethod
    def checked(
        cls,
        scene: Scene,
        normal: str = "auto",
        tangential: str = "auto",
        coupling: str = "auto",
        formulation: str = "auto",
        method: str = "auto",
        tol: float = TOLERANCE,
        polish: bool | None = None,
        start: Any = None,
        certify: str | None = "auto",
        refine: str | None = None,
        store: str | Path | None = None,
        accuracy: float | None = None,
        time_budget: float | None = None,
    ) -> SolveOptions:
        """The arguments of `solve`, refused before any work where they do not suit the scene.

        Parameters
        ----------
        scene, normal, tangential, coupling, formulation, method, tol, polish, start, certify, refine, store
            As of `solve`.
        accuracy, time_budget : float or None
            As of `solve`.

        Raises
        ------
        SceneError, SolverUnavailable, Saturated, TooLarge
            As `solve`.
        """
        if not isinstance(scene, Scene):
            raise SceneError("scene", scene, "a Scene")
        choices = normal, tangential, coupling, formulation, method
        plan = select(scene, *choices)
        tol, polish, certify = checks.positive("tol", tol), polished_by(plan, polish), level(certify)
        check_start(scene, start, plan.theory is not None)
        check_saturation(scene)
        target = target_of(scene, plan, accuracy, time_budget, start, store, refine)
        corrects = check_refine(scene, plan, refine, target is not None, start)
        if store is not None and not isinstance(scene.motion, Transient):
            allowed = "left out: only a history of steps, motion Transient, is stored as it grows"
            raise SceneError("store", store, allowed)
        return cls(choices, plan, tol, polish, start, certify, corrects, store, target)

    def plan_for(self, scene: Scene) -> Plan:
        """The plan of the `scene` on another grid."""
        return select(scene, *self.choices)


def polished_by(plan: Plan, polish: bool | None) -> bool:
    """Whether active sets polish the answers of programs: unless `polish` is False or the method "convex".

    Parameters
    ----------
    plan : Plan
    polish : bool or None
        As asked for; None leaves it to the method.

    Raises
    ------
    SceneError
        If it is neither, or asked for with the method "convex".
    """
    convex = plan.convex
    polish = not convex if polish is None else checks.flag("polish", polish)
    if polish and convex:
        raise SceneError("polish", True, 'left out: method = "convex" calls no active sets')
    return polish


def level(certify: str | None) -> str:
    """How much of a certificate is wanted, checked.

    Parameters
    ----------
    certify : str or None
        As of `solve`.

    Returns
    -------
    str
        "auto", or one of `LEVELS`.

    Raises
    ------
    SceneError
        If there is no such level.
    """
    return checks.choice("certify", "none" if certify is None else certify, ("auto", *LEVELS))
