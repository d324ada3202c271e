"""What a user asks for: an accuracy, or the time it may take."""

from __future__ import annotations

from dataclasses import dataclass

from varcontact import checks
from varcontact.errors import SceneError
from varcontact.scene.grid import Grid
from varcontact.scene.motion import Transient
from varcontact.scene.scene import Scene
from varcontact.solving.error_norm import check_measurable


@dataclass(frozen=True)
class Asked:
    """An accuracy, or seconds: one of the two.

    Attributes
    ----------
    accuracy : float or None
        Largest error against the continuum [-], in the units of `varcontact.solving.error_norm`.
    time_budget : float or None
        Seconds.
    """

    accuracy: float | None = None
    time_budget: float | None = None


def asked_for(scene: Scene, accuracy: float | None, time_budget: float | None) -> Asked | None:
    """What is asked for, checked against the scene; None where nothing is.

    Parameters
    ----------
    scene : Scene
    accuracy, time_budget : float, optional
        As of `solve`.

    Raises
    ------
    SceneError
        If both are given, or one is not positive; or with an explicit grid, a history, or infinite friction.
    """
    if accuracy is None and time_budget is None:
        return None
    if accuracy is not None and time_budget is not None:
        raise SceneError(
            "time_budget",
            time_budget,
            "left out",
            message="accuracy and time_budget are both given: give one; each decides the grid",
        )
    field = "accuracy" if time_budget is None else "time_budget"
    if accuracy is not None:
        accuracy = checks.positive("accuracy", accuracy)
    else:
        time_budget = checks.positive("time_budget", time_budget)
    if isinstance(scene.grid, Grid):
        message = f"grid: with {field} the grid is chosen for you; leave it out, or leave out {field}"
        raise SceneError("grid", scene.grid, '"auto"', message=message)
    if isinstance(scene.motion, Transient):
        message = f"motion: {field} is for one contact problem; the grid of a history is part of what it describes"
        raise SceneError("motion", scene.motion, "Steady, Shift or None", message=message)
    check_measurable(scene)
    return Asked(accuracy, time_budget)
