"""What the theories share: their inputs, checked, and the resultants they return."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from varcontact.checks import array, number, numbers, wrong_shape
from varcontact.errors import SceneError


@dataclass(frozen=True, eq=False)
class Resultants:
    """Total tangential force and moment on body 1.

    Attributes
    ----------
    force : ndarray, shape (..., 2)
        Fx and Fy (116).
    moment : ndarray, shape (...)
        Mz about the contact's centre (117).
    """

    force: np.ndarray
    moment: np.ndarray


def triples(value: Any) -> np.ndarray:
    """Creepages (vx, vy, spin) as an array (..., 3)."""
    result = numbers("creepages", value)
    if result.ndim == 0 or result.shape[-1] != 3:
        raise wrong_shape("creepages", result.shape, "an array (..., 3) of vx, vy, spin")
    return result


def triple(value: Any) -> np.ndarray:
    """One creepage (vx, vy, spin) as an array (3,)."""
    result = array("creepage", value, 1)
    if result.shape != (3,):
        raise wrong_shape("creepage", result.shape, "the three numbers vx, vy, spin")
    return result


def either(creepage: str, given: float | None, force: str, prescribed: float | None) -> tuple[float, float | None]:
    """A creepage and the force prescribed in its place (None: not prescribed). A creepage that is not given is 0."""
    if prescribed is None:
        return (0.0 if given is None else number(creepage, given)), None
    if given is not None:
        raise SceneError(
            f"{creepage}, {force}",
            (given, prescribed),
            "at most one of the two",
            message=f"{creepage} and {force} are both given: give one of them",
        )
    return 0.0, number(force, prescribed)
