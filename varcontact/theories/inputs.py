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
    """Creepages, checked.

    Parameters
    ----------
    value : array_like, shape (..., 3)
        vx, vy [-] and spin [1/length].

    Returns
    -------
    ndarray, shape (..., 3)

    Raises
    ------
    SceneError
        If they are not finite numbers of that shape.
    """
    result = numbers("creepages", value)
    if result.ndim == 0 or result.shape[-1] != 3:
        raise wrong_shape("creepages", result.shape, "an array (..., 3) of vx, vy, spin")
    return result


def triple(value: Any) -> np.ndarray:
    """One creepage, checked.

    Parameters
    ----------
    value : array_like, shape (3,)
        vx, vy [-] and spin [1/length].

    Returns
    -------
    ndarray, shape (3,)

    Raises
    ------
    SceneError
        If it is not three finite numbers.
    """
    result = array("creepage", value, 1)
    if result.shape != (3,):
        raise wrong_shape("creepage", result.shape, "the three numbers vx, vy, spin")
    return result


def either(creepage: str, given: float | None, force: str, prescribed: float | None) -> tuple[float, float | None]:
    """A creepage and the force prescribed in its place.

    A creepage that is not given is 0.

    Parameters
    ----------
    creepage, force : str
        Their names, for the message.
    given : float or None
        The creepage [-].
    prescribed : float or None
        The force [force].

    Returns
    -------
    tuple of (float, float or None)
        None where no force is prescribed.

    Raises
    ------
    SceneError
        If both are given, or one is not finite.
    """
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
