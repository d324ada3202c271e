"""What a solution is to reach: an accuracy, or the most accurate answer within a time."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

from varcontact import checks
from varcontact.errors import SceneError
from varcontact.results.plan import Plan
from varcontact.results.quantities_of_interest import check_measurable
from varcontact.scene.friction import StaticKinetic
from varcontact.scene.grid import Grid
from varcontact.scene.motion import Shift, Steady, Transient
from varcontact.scene.scene import Scene

BY_DEFAULT = 0.01
"""The accuracy of an answer where neither a grid nor an accuracy is given."""


@dataclass(frozen=True)
class Target:
    """An accuracy, or seconds: one of the two.

    Attributes
    ----------
    accuracy : float or None
        Largest error against the continuum [-], in the units of `varcontact.results.quantities_of_interest`.
    time_budget : float or None
        Seconds.
    by_default : bool
        Whether nothing was given: then an accuracy that is not reached is no error, but a larger error bar.
    """

    accuracy: float | None = None
    time_budget: float | None = None
    by_default: bool = False

    @property
    def least(self) -> float:
        """The part of the load with which a patch of the contact counts."""
        return BY_DEFAULT if self.accuracy is None else self.accuracy


def target_of(
    scene: Scene,
    plan: Plan,
    accuracy: float | None,
    time_budget: float | None,
    start: Any = None,
    store: Any = None,
    refine: Any = None,
) -> Target | None:
    """The target of a solution, checked against the scene; None where it is solved on its own grid.

    Parameters
    ----------
    scene : Scene
    plan : Plan
    accuracy, time_budget, start, store, refine
        As of `solve`.

    Raises
    ------
    SceneError
        If both are given, or one is not positive; for an accuracy of one and more; or where the scene or the method
        leaves no choice.
    """
    if accuracy is None and time_budget is None:
        own = refine is not None or _names_a_difference(scene.motion)
        return None if own or _refusal(scene, plan, "accuracy", start, store) else DEFAULT
    if accuracy is not None and time_budget is not None:
        message = "accuracy and time_budget are both given: give one of them, as each decides on the grid"
        raise SceneError("time_budget", time_budget, "left out", message=message)
    if accuracy is not None:
        field, accuracy = "accuracy", _below_one(checks.positive("accuracy", accuracy))
    else:
        field, time_budget = "time_budget", checks.positive("time_budget", time_budget)
    refusal = _refusal(scene, plan, field, start, store)
    if refusal is not None:
        raise refusal
    return Target(accuracy, time_budget)


DEFAULT = Target(BY_DEFAULT, by_default=True)


def _names_a_difference(motion: Any) -> bool:
    """Whether the slip of steady rolling is discretised as the scene says."""
    return isinstance(motion, Steady) and replace(motion, slip_difference="first-order", spin_offset=None) != motion


def _refusal(scene: Scene, plan: Plan, field: str, start: Any, store: Any) -> SceneError | None:
    """Why a scene has a grid already, or needs one, or the error of its answer is not that of a grid."""
    try:
        _check_choice(scene, plan, field, start, store)
        check_measurable(scene)
    except SceneError as refusal:
        return refusal
    return None


def _below_one(accuracy: float) -> float:
    """An accuracy, of which no answer at all is worse: an error of one is all of what errors are counted by."""
    if accuracy < 1:
        return accuracy
    allowed = "below 1: it is a part of the largest friction force (without friction of the approach), as 0.01"
    raise SceneError("accuracy", accuracy, allowed)


def _check_history(motion: Transient, field: str, store: Any) -> None:
    """Refuse histories whose steps depend on a grid, and their files, which have one grid."""
    if motion.dq is None:
        message = f"motion.dq: the length of the steps is an element's, unless it is given; with {field} give it"
        raise SceneError("motion.dq", None, "a length, or one for each step", message=message)
    if motion.start is not None:
        message = f"motion.start: a solution belongs to its own grid, and {field} chooses one; leave one of them out"
        raise SceneError("motion.start", motion.start, "left out", message=message)
    if store is not None:
        message = f"store: with {field} a history is solved on several grids; leave store out, and save the answer"
        raise SceneError("store", store, "left out", message=message)


def _check_known(motion: Shift, field: str) -> None:
    """Refuse forces in line contact without a depth, where what is asked for is known but for a constant."""
    for name in ("Fx", "Fy"):
        if getattr(motion, name) is not None:
            message = (
                f"surface.reference_depth: in line contact the shift for motion.{name} is known but for a constant, "
                f"which no {field} is for; give the depth from which displacements count"
            )
            raise SceneError("surface.reference_depth", None, "a depth", message=message)


def _check_choice(scene: Scene, plan: Plan, field: str, start: Any, store: Any) -> None:
    """Refuse what is a grid, or needs one, and methods whose error is not that of a grid."""
    motion = scene.motion
    if isinstance(scene.grid, Grid):
        message = f"grid: the grid is chosen for the {field}; leave the grid out, or {field}"
        raise SceneError("grid", scene.grid, '"auto"', message=message)
    if isinstance(motion, Transient):
        _check_history(motion, field, store)
    if isinstance(motion, Steady) and motion.dq is not None:
        message = f"motion.dq: the step is chosen for the {field}; leave dq out, or {field}"
        raise SceneError("motion.dq", motion.dq, "left out", message=message)
    if isinstance(motion, Shift) and scene.line and scene.reference_depth is None:
        _check_known(motion, field)
    if plan.marches and isinstance(motion, Steady):
        message = (
            f'formulation = "marching" takes the slip of first order, and with {field} it is of second order; '
            "leave formulation out, or give a grid"
        )
        raise SceneError("formulation", "marching", '"auto"', message=message)
    if plan.theory is not None:
        message = (
            f'tangential = "{plan.tangential}": a theory has an error that no grid removes; '
            f"with {field} take a method of the exact theory, or leave tangential out"
        )
        raise SceneError("tangential", plan.tangential, "a method of the exact theory", message=message)
    if start is not None and not isinstance(start, str):
        message = f'start: with {field} it is "stick" or "slip"; a solution belongs to its own grid'
        raise SceneError("start", start, '"stick" or "slip"', message=message)
    if start == "stick" and isinstance(scene.friction, StaticKinetic):
        message = (
            'start = "stick": under a static and a kinetic coefficient what the static one adds vanishes as the grid '
            f"gets finer, and {field} counts errors against the continuum; leave start out, or give a grid"
        )
        raise SceneError("start", start, 'left out, or "slip"', message=message)
