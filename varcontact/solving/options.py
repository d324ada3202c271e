"""The arguments of `solve`: their names for type checkers and editors, and checked together,
once.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Literal, TypedDict

import numpy as np

from varcontact import checks
from varcontact.discrete.certificate import LEVELS
from varcontact.errors import Saturated, SceneError
from varcontact.results.plan import Plan
from varcontact.results.quantities_of_interest import not_measurable
from varcontact.results.solution import Solution
from varcontact.scene.friction import Law, StaticKinetic
from varcontact.scene.grid import Grid
from varcontact.scene.motion import Shift, Steady
from varcontact.scene.scene import Scene
from varcontact.scene.transient import Transient
from varcontact.solvers.interface import SolveStats
from varcontact.solving.contact_solver import ContactSolver
from varcontact.solving.selection import check_fits, select

TOLERANCE = 1e-8
"""Natural-map residual to reach if none is given. Every method reaches it, see docs/methods.md."""

LOOSE = 1e-4
"""Residual of an answer that another one is extrapolated with: it changes forces by parts of a
million at most."""

BY_DEFAULT = 0.01
"""The accuracy of an answer where neither a grid nor an accuracy is given."""

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
    progress: Callable[[str], None] | None
    store: str | Path | None
    accuracy: float | None
    time_budget: float | None


@dataclass(frozen=True)
class Target:
    """What an answer is to reach: an accuracy by the units of its quantities of interest, or
    seconds.

    `by_default`: nothing was given; then an accuracy that is not reached is no error, but a larger
    error bar. `of_pressure`: whether the largest pressure of a normal contact counts.
    """

    accuracy: float | None = None
    time_budget: float | None = None
    by_default: bool = False
    of_pressure: bool = True


@dataclass(frozen=True)
class SolveOptions:
    """How a scene is solved: the arguments of `solve`, checked once, with the scene's plan.

    `choices`: names of the methods, as `select` takes them. `target`: None where the scene has its
    own grid. `final`: false on coarser grids of an accuracy. `deadline`: when solvers raise
    `OutOfTime`, by `time.perf_counter` [s].
    """

    scene: Scene
    choices: tuple[str, str, str, str, str]
    plan: Plan
    tol: float
    polish: bool
    start: str | Solution | None
    certify: str
    store: str | Path | None
    target: Target | None
    progress: Callable[[str], None]
    final: bool = True
    deadline: float = math.inf

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
        refine: object = None,
        store: str | Path | None = None,
        accuracy: float | None = None,
        time_budget: float | None = None,
        progress: Callable[[str], None] | None = None,
    ) -> SolveOptions:
        """The arguments of `solve`, refused as there, before any work, where they do not suit the
        scene.
        """
        choices = normal, tangential, coupling, formulation, method
        plan = select(scene, *choices)
        tol = checks.positive("tol", tol)
        polish = polished_by(plan, polish)
        certify = checks.choice(
            "certify", "none" if certify is None else certify, ("auto", *LEVELS)
        )
        if start is not None and not scene.under_law:
            raise SceneError(
                "start", start, "left out: it chooses between the solutions under a law of friction"
            )
        if start is not None and isinstance(scene.motion, Transient):
            allowed = "left out: in a history each particle goes on as it did in the step before"
            raise SceneError("start", start, allowed)
        known = isinstance(start, Solution) and plan.theory is None
        if not (start is None or known or (isinstance(start, str) and start in ("stick", "slip"))):
            allowed = '"stick" or "slip"' + ", or a Solution" * (plan.theory is None)
            raise SceneError("start", start, allowed)
        check_saturation(scene)
        checks.gone("refine", refine, checks.REFINE_BECAME)
        target = _target(scene, plan, accuracy, time_budget, start, store)
        if store is not None and not isinstance(scene.motion, Transient):
            allowed = "left out: only a history of steps, motion Transient, is stored as it grows"
            raise SceneError("store", store, allowed)
        if store is not None and getattr(scene.motion, "control", None) is not None:
            allowed = "left out: a file cannot hold the function motion.control; save the answer"
            raise SceneError("store", store, allowed)
        told = checks.progress(progress)
        return cls(scene, choices, plan, tol, polish, start, certify, store, target, told)

    def solver(self, scene: Scene) -> ContactSolver:
        """The methods for the `scene`; on a coarser grid to a loose tolerance, without a
        certificate.
        """
        plan = self.plan_for(scene)
        certify = self.certify
        tol = self.tol
        if self.final:  # a coarse grid fits where a finer one does
            check_fits(scene, plan)
        else:
            certify = "none"
            tol = max(tol, LOOSE)
        stats = SolveStats(self.progress)
        chosen = self.target is not None
        refined = self.final and not chosen
        return ContactSolver(
            plan, tol, self.polish, stats, self.start, certify, refined, chosen, self.deadline
        )

    def plan_for(self, scene: Scene) -> Plan:
        """The plan of the `scene`, as on another grid."""
        return self.plan if scene is self.scene else select(scene, *self.choices)


def check_saturation(scene: Scene) -> None:
    """Before any work: `Saturated` for forces beyond f Fz, where both are numbers, or in steps
    without friction.
    """
    motion = scene.motion
    if isinstance(motion, Transient) and not (motion.Fx is None and motion.Fy is None):
        for k, own in enumerate(motion.every("friction")):
            friction = scene.friction if own is None else own
            size = float(np.hypot(motion.of("Fx", k) or 0.0, motion.of("Fy", k) or 0.0))
            if size > 0 and np.all(np.asarray(friction) == 0):
                raise Saturated(size, 0.0).in_step(k, None)
    if not isinstance(motion, Steady | Shift):
        return
    size = float(np.hypot(motion.Fx or 0.0, motion.Fy or 0.0))
    limit = 0.0 if scene.frictionless else np.inf
    friction = scene.friction.static if isinstance(scene.friction, Law) else scene.friction
    if isinstance(friction, float) and scene.normal_force is not None:
        limit = friction * scene.normal_force
    if size > 0 and size >= limit:
        raise Saturated(size, limit)


def polished_by(plan: Plan, polish: bool | None) -> bool:
    """Whether active sets polish the answers of programs: unless `polish` is False or the method
    "convex".
    """
    polish = plan.method != "convex" if polish is None else checks.flag("polish", polish)
    if polish and plan.method == "convex":
        raise SceneError("polish", True, 'left out: method = "convex" calls no active sets')
    return polish


def _target(
    scene: Scene,
    plan: Plan,
    accuracy: float | None,
    time_budget: float | None,
    start: Any,
    store: Any,
) -> Target | None:
    """The target of a solution; None where the scene or the method leaves no choice of a grid, and
    none was given.
    """
    motion = scene.motion
    if accuracy is None and time_budget is None:
        rolls = isinstance(motion, Steady)
        names_difference = (
            rolls and replace(motion, slip_difference="first-order", spin_offset=None) != motion
        )
        if isinstance(scene.grid, Grid) or names_difference or scene.hardens:
            return None  # on a finer grid hardening takes many times as long
        refusals = _refusals(scene, plan, "accuracy", start, store)
        return Target(BY_DEFAULT, by_default=True) if next(refusals, None) is None else None
    if accuracy is not None and time_budget is not None:
        raise SceneError(
            "time_budget", time_budget, "left out where accuracy is given: each decides on the grid"
        )
    if accuracy is not None:
        field = "accuracy"
        accuracy = checks.positive("accuracy", accuracy)
        if accuracy >= 1:
            allowed = "below 1: it is a part of the largest friction force (without friction of the approach), as 0.01"
            raise SceneError("accuracy", accuracy, allowed)
    else:
        field = "time_budget"
        time_budget = checks.positive("time_budget", time_budget)
    for refusal in _refusals(scene, plan, field, start, store):
        raise refusal
    return Target(accuracy, time_budget)


def _refusals(scene: Scene, plan: Plan, field: str, start: Any, store: Any) -> Iterator[SceneError]:
    """Why a scene has a grid already, or needs one, or the error of its answer is not that of a
    grid.
    """
    motion = scene.motion
    if isinstance(scene.grid, Grid):
        yield SceneError("grid", scene.grid, f"left out: it is chosen for the {field}")
    if isinstance(motion, Transient):
        several = f"left out: with {field} a history is solved on several grids"
        if motion.dq is None:
            yield SceneError(
                "motion.dq",
                None,
                f"given: with {field} the length of the steps is not an element's",
            )
        if motion.start is not None:
            yield SceneError("motion.start", "a Solution", f"{several}, and it belongs to its own")
        if store is not None:
            yield SceneError("store", store, f"{several}; save the answer")
        if motion.control is not None:
            yield SceneError("motion.control", "a function", several)
        if scene.bodies.relaxes:
            yield SceneError("bodies", "Viscoelastic", f"elastic in a history with {field}")
    if isinstance(motion, Steady) and motion.dq is not None:
        yield SceneError("motion.dq", motion.dq, f"left out: the step is chosen for the {field}")
    forces = [name for name in ("Fx", "Fy") if getattr(motion, name, None) is not None]
    if isinstance(motion, Shift) and scene.shift_undetermined and forces:
        known = f"the shift for motion.{forces[0]} is known but for a constant"
        if scene.bodies.slides:
            yield SceneError("bodies.base", "smooth", f"no base with {field}: {known}")
        yield SceneError(
            "surface.reference_depth", None, f"given with {field}: in line contact {known}"
        )
    if plan.formulation == "marching" and isinstance(motion, Steady):
        yield SceneError(
            "formulation", "marching", f"left out: with {field} the slip is of second order"
        )
    if scene.hardens and not plan.closed_form:
        allowed = f"0 with {field}, or the contact a Hertzian one of like bodies"
        yield SceneError("third_body.k_tau", scene.third_body, allowed)
    if plan.theory is not None:
        allowed = (
            f"a method of the exact theory with {field}: a theory has an error that no grid removes"
        )
        yield SceneError("tangential", plan.tangential, allowed)
    if start is not None and not isinstance(start, str):
        yield SceneError(
            "start",
            "a Solution",
            f'"stick" or "slip" with {field}: a solution belongs to its own grid',
        )
    if start == "stick" and isinstance(scene.friction, StaticKinetic):
        allowed = f"left out with {field}: what the static coefficient adds vanishes as the grid gets finer"
        yield SceneError("start", start, allowed)
    refusal = not_measurable(scene)
    if refusal is not None:
        yield refusal
