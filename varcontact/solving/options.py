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
from varcontact.discrete.contact_grid import PotentialContact
from varcontact.discrete.operators import Operators
from varcontact.errors import Saturated, SceneError
from varcontact.results.plan import Plan
from varcontact.results.quantities_of_interest import not_measurable
from varcontact.results.solution import Solution
from varcontact.scene.consistency import hardening_refused
from varcontact.scene.friction import StaticKinetic
from varcontact.scene.grid import Grid
from varcontact.scene.motion import Shift, Steady
from varcontact.scene.scene import Scene
from varcontact.scene.transient import Transient
from varcontact.solvers.interface import SolveStats
from varcontact.solvers.trace import Trace
from varcontact.solving.contact_solver import ContactSolver
from varcontact.solving.methods import AUTO, FormulationName, MethodName, Methods, taken_apart
from varcontact.solving.pipeline import check_fits
from varcontact.solving.selection import select
from varcontact.system.process import changed
from varcontact.system.progress import Progress

TOLERANCE = 1e-8
"""Natural-map residual to reach if none is given. Every method reaches it, see docs/methods.md."""

LOOSE = 1e-4
"""Residual of an answer used only for extrapolation: it changes forces by at most parts per
million."""

DEFAULT_ACCURACY = 0.01
"""The accuracy of an answer where neither a grid nor an accuracy is given."""
SAME_SIZE = 1.5
"""Ratio of elements up to which methods chosen by their number are kept."""

CertifyName = Literal["auto", "full", "gap", "none"]
"""Levels of the certificate."""


class Options(TypedDict, total=False):
    """Arguments of `solve` that are given by name, see there."""

    formulation: FormulationName
    method: MethodName
    methods: Methods | None
    tol: float
    polish: bool | None
    start: Literal["stick", "slip"] | Solution | None
    certify: CertifyName | None
    progress: Progress
    store: str | Path | None
    accuracy: float | None
    time_budget: float | None
    trace: bool


@dataclass(frozen=True, kw_only=True)
class Arguments:
    """Arguments of `solve` as given by the user."""

    methods: Methods = AUTO
    tol: float = TOLERANCE
    polish: bool | None = None
    start: Any = None
    certify: str | None = "auto"
    refine: object = None
    store: str | Path | None = None
    accuracy: float | None = None
    time_budget: float | None = None
    progress: Progress = None
    trace: bool = False


@dataclass(frozen=True)
class Target:
    """Aim of a solution: an accuracy in the units of its quantities of interest, or a time [s].

    `by_default`: nothing was given; then an accuracy that is not reached is no error, but a larger
    error bar. `of_pressure`: the largest pressure of a normal contact counts.
    """

    accuracy: float | None = None
    time_budget: float | None = None
    by_default: bool = False
    of_pressure: bool = True

    @property
    def seconds(self) -> float:
        """The time, infinite where none is given [s]."""
        return math.inf if self.time_budget is None else self.time_budget


@dataclass(frozen=True)
class SolveOptions:
    """Arguments of `solve`, checked once, with the scene's plan.

    `methods`: their names, as they are given. `target`: None where the scene has its
    own grid. `final`: false on coarser grids of an accuracy. `deadline`: when solvers raise
    `OutOfTime`, by `time.perf_counter` [s]. `operators`: influence numbers by their grid, kept for
    other loads where given.
    """

    scene: Scene
    methods: Methods
    plan: Plan
    tol: float
    polish: bool
    start: str | Solution | None
    certify: str
    store: str | Path | None
    target: Target | None
    progress: Callable[[str], None]
    trace: bool = False
    final: bool = True
    deadline: float = math.inf
    operators: dict[Grid, Operators] | None = None

    @classmethod
    def checked(cls, scene: Scene, **given: Any) -> SolveOptions:
        """Options from the arguments of `solve`, which are refused before any work if they do not
        suit the scene.
        """
        methods, others = taken_apart(given)
        arguments = Arguments(methods=methods, **others)
        plan = select(scene, methods)
        tol = checks.positive("tol", arguments.tol)
        polish = polished_by(plan, arguments.polish)
        certify = "none" if arguments.certify is None else arguments.certify
        certify = checks.choice("certify", certify, ("auto", *LEVELS))
        if arguments.start is not None:
            _check_start(scene, plan, arguments.start)
        check_saturation(scene)
        checks.gone("refine", arguments.refine, checks.REFINE_BECAME)
        target = _target(scene, plan, arguments)
        if arguments.store is not None:
            _check_store(scene, arguments.store)
        return cls(
            scene,
            methods,
            plan,
            tol,
            polish,
            arguments.start,
            certify,
            arguments.store,
            target,
            checks.progress(arguments.progress),
            _traced(scene, arguments.trace),
        )

    def solver(self, scene: Scene) -> ContactSolver:
        """Solver for the `scene`; on a coarser grid with a loose tolerance, without a
        certificate.
        """
        plan = self.plan_for(scene)
        certify = self.certify
        tol = self.tol
        if self.final:  # if the fine grid fits, so does a coarse one
            check_fits(scene, plan)
        else:
            certify = "none"
            tol = max(tol, LOOSE)
        stats = SolveStats(self.progress, Trace() if self.trace else None)
        chosen = self.target is not None
        loose_tolerance = chosen or not self.final
        return ContactSolver(
            plan,
            tol,
            self.polish,
            stats,
            start=self.start,
            certify=certify,
            loose_tolerance=loose_tolerance,
            continuum=chosen,
            deadline=self.deadline,
        )

    def suit(self, scene: Scene) -> bool:
        """True for a scene on about as many elements, on which the choice of methods depends; its
        kind is not checked.
        """
        before = self.scene.own_grid.size
        now = scene.own_grid.size
        return before < SAME_SIZE * now and now < SAME_SIZE * before

    def like(self, scene: Scene) -> SolveOptions:
        """Copy for another scene, which these options `suit`."""
        plan = changed(self.plan, grid=PotentialContact.of(scene))
        return changed(self, scene=scene, plan=plan)

    def plan_for(self, scene: Scene) -> Plan:
        """The plan of the `scene`, as on another grid."""
        if scene is self.scene:
            return self.plan
        return select(scene, self.methods)


def _traced(scene: Scene, trace: Any) -> bool:
    """True where the iterates of solvers are kept; refused in a history."""
    trace = checks.flag("trace", trace)
    if trace and isinstance(scene.motion, Transient):
        raise SceneError("trace", trace, "left out in a history: solve a step by itself")
    return trace


def _check_start(scene: Scene, plan: Plan, start: Any) -> None:
    """Refuse a start without a law of friction, in a history, or of another kind."""
    if not scene.under_law:
        allowed = "left out: it chooses between the solutions under a law of friction"
        raise SceneError("start", start, allowed)
    if isinstance(start, str) and start in ("stick", "slip"):
        return
    if isinstance(scene.motion, Transient):
        allowed = '"stick", "slip" or left out: then each particle goes on as it did before'
        raise SceneError("start", start, allowed)
    if plan.theory is not None:
        raise SceneError("start", start, '"stick" or "slip"')
    if not isinstance(start, Solution):
        raise SceneError("start", start, '"stick" or "slip", or a Solution')


def _check_store(scene: Scene, store: Any) -> None:
    """Refuse a file that cannot hold the answer as it grows."""
    if not isinstance(scene.motion, Transient):
        allowed = "left out: only a history of steps, motion Transient, is stored as it grows"
        raise SceneError("store", store, allowed)
    if scene.motion.control is not None:
        allowed = "left out: a file cannot hold the function motion.control; save the answer"
        raise SceneError("store", store, allowed)


def check_saturation(scene: Scene) -> None:
    """Raise `Saturated` before any work for forces beyond f Fz, where both are numbers, or in steps
    without friction.
    """
    motion = scene.motion
    if isinstance(motion, Transient) and not (motion.Fx is None and motion.Fy is None):
        _check_saturation_of_steps(scene, motion)
    if not isinstance(motion, Steady | Shift):
        return
    size = float(np.hypot(motion.Fx or 0.0, motion.Fy or 0.0))
    limit = _static_friction_limit(scene)
    if size > 0 and size >= limit:
        raise Saturated(size, limit)


def _static_friction_limit(scene: Scene) -> float:
    """Friction force f Fz with the largest coefficient; infinite if it is not known before the
    solution.
    """
    largest = scene.largest_coefficient
    if isinstance(largest, float) and scene.normal_force is not None:
        return largest * scene.normal_force
    return 0.0 if scene.frictionless else np.inf


def _check_saturation_of_steps(scene: Scene, motion: Transient) -> None:
    for k, friction_of_step in enumerate(motion.every("friction")):
        friction = friction_of_step
        if friction is None:
            friction = scene.friction
        size = float(np.hypot(motion.of("Fx", k) or 0.0, motion.of("Fy", k) or 0.0))
        if size > 0 and np.all(np.asarray(friction) == 0):
            raise Saturated(size, 0.0).in_step(k, None)


def polished_by(plan: Plan, polish: bool | None) -> bool:
    """True if active sets polish the answers of programs: unless `polish` is False or the method
    "convex" or "conic".
    """
    without = plan.method in ("convex", "conic")
    if polish is None:
        return not without
    polish = checks.flag("polish", polish)
    if polish and without:
        allowed = f'left out: method = "{plan.method}" calls no active sets'
        raise SceneError("polish", True, allowed)
    return polish


def _target(scene: Scene, plan: Plan, arguments: Arguments) -> Target | None:
    """The target that `adaptive.solve` chooses the grid for; None where the scene is solved on its
    own grid, or on the usual one (`scene.grid.usual_grid`).
    """
    accuracy = arguments.accuracy
    time_budget = arguments.time_budget
    if accuracy is None and time_budget is None:
        return _default_target(scene, plan, arguments)
    if accuracy is not None and time_budget is not None:
        allowed = "left out where accuracy is given: each decides on the grid"
        raise SceneError("time_budget", time_budget, allowed)
    if accuracy is not None:
        field = "accuracy"
        accuracy = checks.positive("accuracy", accuracy)
        if accuracy >= 1:
            unit = "the largest friction force (without friction of the approach)"
            raise SceneError("accuracy", accuracy, f"below 1: it is a part of {unit}, as 0.01")
    else:
        field = "time_budget"
        time_budget = checks.positive("time_budget", time_budget)
    for refusal in _refusals(scene, plan, field, arguments):
        raise refusal
    return Target(accuracy, time_budget)


def _default_target(scene: Scene, plan: Plan, arguments: Arguments) -> Target | None:
    """The target of a scene without a grid: `DEFAULT_ACCURACY` wherever one can be asked for."""
    motion = scene.motion
    if isinstance(scene.grid, Grid) or scene.hardens:
        return None  # on a finer grid hardening takes many times as long
    if isinstance(motion, Steady):
        plain = replace(motion, slip_difference="first-order", spin_offset=None)
        if plain != motion:
            return None
    if next(_refusals(scene, plan, "accuracy", arguments), None) is not None:
        return None
    return Target(DEFAULT_ACCURACY, by_default=True)


def _refusals(scene: Scene, plan: Plan, field: str, arguments: Arguments) -> Iterator[SceneError]:
    """Reasons why a grid cannot be chosen for an accuracy or a time."""
    if isinstance(scene.grid, Grid):
        yield SceneError("grid", scene.grid, f"left out: it is chosen for the {field}")
    if isinstance(scene.motion, Transient):
        yield from _refusals_of_history(scene, field, arguments.store)
    if isinstance(scene.motion, Steady):
        yield from _refusals_of_rolling(scene.motion, plan, field)
    if isinstance(scene.motion, Shift) and scene.shift_undetermined:
        yield from _refusals_of_shift(scene, scene.motion, field)
    if scene.hardens and not plan.closed_form:
        allowed = f"0 with {field}, or the contact a Hertzian one of like bodies"
        yield hardening_refused(scene, allowed)
    if plan.theory is not None:
        allowed = f"a method of the exact theory with {field}"
        why = "a theory has an error that no grid removes"
        yield SceneError("tangential", plan.tangential, f"{allowed}: {why}")
    yield from _refusals_of_start(scene, field, arguments.start)
    refusal = not_measurable(scene)
    if refusal is not None:
        yield refusal


def _refusals_of_start(scene: Scene, field: str, start: Any) -> Iterator[SceneError]:
    if isinstance(start, Solution):
        allowed = f'"stick" or "slip" with {field}: a solution belongs to its own grid'
        yield SceneError("start", "a Solution", allowed)
    elif start == "stick" and isinstance(scene.friction, StaticKinetic):
        why = "what the static coefficient adds vanishes as the grid gets finer"
        yield SceneError("start", "stick", f"left out with {field}: {why}")


def _refusals_of_history(scene: Scene[Transient], field: str, store: Any) -> Iterator[SceneError]:
    motion = scene.motion
    several = f"left out: with {field} a history is solved on several grids"
    if motion.dq is None:
        allowed = f"given: with {field} the length of the steps is not an element's"
        yield SceneError("motion.dq", None, allowed)
    if motion.start is not None:
        yield SceneError("motion.start", "a Solution", f"{several}, and it belongs to its own")
    if store is not None:
        yield SceneError("store", store, f"{several}; save the answer")
    if motion.control is not None:
        yield SceneError("motion.control", "a function", several)
    if scene.bodies.relaxes:
        yield SceneError("bodies", "Viscoelastic", f"elastic in a history with {field}")


def _refusals_of_rolling(motion: Steady, plan: Plan, field: str) -> Iterator[SceneError]:
    if motion.dq is not None:
        yield SceneError("motion.dq", motion.dq, f"left out: the step is chosen for the {field}")
    if plan.formulation == "marching":
        allowed = f"left out: with {field} the slip is of second order"
        yield SceneError("formulation", "marching", allowed)


def _refusals_of_shift(scene: Scene, motion: Shift, field: str) -> Iterator[SceneError]:
    """Refusals of a shift under a force in line contact without a depth: it is determined up to a
    constant only.
    """
    forces = [name for name in ("Fx", "Fy") if getattr(motion, name) is not None]
    if not forces:
        return
    undetermined = f"the shift for motion.{forces[0]} is known but for a constant"
    if scene.bodies.slides:
        yield SceneError("bodies.base", "smooth", f"no base with {field}: {undetermined}")
    allowed = f"given with {field}: in line contact {undetermined}"
    yield SceneError("surface.reference_depth", None, allowed)
