"""Friction of adhesive contacts: a shear strength independent of the pressure."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from varcontact.checks import Checked, at_least_zero
from varcontact.errors import SceneError
from varcontact.scene.friction import FrictionBound


@dataclass(frozen=True)
class ShearStrength(
    Checked, FrictionBound, path="friction", coefficient=at_least_zero, strength=at_least_zero
):
    """The larger of Coulomb's bound and a shear strength within the contact:
    ``|p| <= max(coefficient pz, strength)``.

    With a coefficient of zero it is Tresca's law, of soft metals and of films
    that shear at one stress; with both that of adhesive contacts. The bound
    depends on the pressure alone: the tangential problem is convex, and its
    certificate bounds forces.

    Parameters
    ----------
    coefficient : float
        f, zero or positive [-].
    strength : float
        Shear strength of the interface, zero or positive [stress].

    Raises
    ------
    SceneError
        For entries that are negative, or both zero.

    Examples
    --------
    >>> import numpy as np
    >>> friction = ShearStrength(coefficient=0.3, strength=0.1)
    >>> friction.bound(np.array([0.0, 0.2, 1.0]), np.zeros(3), np.zeros(3))
    array([0. , 0.1, 0.3])
    """

    coefficient: float
    strength: float

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.coefficient == self.strength == 0:
            raise SceneError(
                "friction.strength", 0.0, "positive, or a positive friction.coefficient"
            )

    def bound(self, pressure: np.ndarray, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        """The traction bound under a `pressure` [stress], of the same shape; `x` and `y` do not
        matter.
        """
        return np.where(pressure > 0, np.maximum(self.coefficient * pressure, self.strength), 0.0)
