"""Friction by region of a rail (tread, gauge corner, gauge face), from the inclination of its
surface.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from varcontact import checks
from varcontact.errors import SceneError


@dataclass(frozen=True)
class FrictionByAngle:
    """Coefficients of friction by the inclination of the rail's surface, as of
    a lubricated gauge face.

    Parameters
    ----------
    angles : sequence of float
        Inclinations to the track side, ascending [rad]: 0 is level, negative on
        the field side. With the cant.
    coefficients : sequence of float
        At the angles; linear in between, and constant beyond [-].
    by_patch : bool
        Whether a patch in a plane has one coefficient, by the plane's angle, as
        in CONTACT; otherwise each row of elements has that of the rail below.

    Raises
    ------
    SceneError
        For angles that do not ascend, and coefficients that are not positive.

    Examples
    --------
    >>> lubricated = FrictionByAngle.regions(tread=0.35, gauge_corner=0.25, gauge_face=0.1)
    >>> print(lubricated(0.05), lubricated(0.6), lubricated(1.2))
    0.35 0.25 0.1
    """

    angles: Sequence[float]
    coefficients: Sequence[float]
    by_patch: bool = False

    def __post_init__(self) -> None:
        angles = checks.numbers("friction.angles", self.angles)
        values = checks.positives("friction.coefficients", self.coefficients)
        if (
            angles.ndim != 1
            or angles.shape != values.shape
            or not angles.size
            or (np.diff(angles) <= 0).any()
        ):
            raise SceneError(
                "friction.angles", self.angles, "ascending, one for each coefficient [rad]"
            )
        object.__setattr__(self, "angles", tuple(angles.tolist()))
        object.__setattr__(self, "coefficients", tuple(values.tolist()))
        object.__setattr__(self, "by_patch", checks.flag("friction.by_patch", self.by_patch))

    @classmethod
    def regions(
        cls,
        tread: float,
        gauge_corner: float,
        gauge_face: float,
        *,
        corner: float = 0.3,
        face: float = 0.9,
    ) -> FrictionByAngle:
        """Three regions, which go over into each other within 0.1 rad to either side of a border.

        Parameters
        ----------
        tread, gauge_corner, gauge_face : float
            Coefficients [-].
        corner, face : float
            Inclinations where gauge corner and gauge face begin [rad].
        """
        borders = (corner - 0.1, corner + 0.1, face - 0.1, face + 0.1)
        return cls(borders, (tread, gauge_corner, gauge_corner, gauge_face))

    def __call__(self, inclination: np.ndarray | float) -> np.ndarray:
        """Coefficients at inclinations to the track side [rad]."""
        return np.asarray(np.interp(inclination, self.angles, self.coefficients))
