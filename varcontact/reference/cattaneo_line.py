"""Cattaneo's and Mindlin's shift of two like cylinders (paper, section 6.2.1).

Source: K. L. Johnson, Contact Mechanics, Cambridge University Press 1985.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from varcontact.checks import number
from varcontact.reference.line_contact import friction_limit, part_of_limit

if TYPE_CHECKING:
    from varcontact.reference.line_contact import LineContact


@dataclass(frozen=True)
class CattaneoLine:
    """A line contact shifted by a tangential force: stick in the middle, slip on both sides.

    Attributes
    ----------
    contact : LineContact
        The Hertzian line contact.
    friction : float
        Coefficient of friction.
    force : float
        Tangential force on body 1 along x, per unit length.
    stick_half_width : float
        ``a sqrt(1 - |F|/(f N))`` [length].
    """

    contact: LineContact
    friction: float
    force: float
    stick_half_width: float

    def traction(self, x: np.ndarray) -> np.ndarray:
        """Traction along x: the bound, less a Hertz-like traction over the stick area.

        Parameters
        ----------
        x : array_like
            Points [length].

        Returns
        -------
        ndarray
            [force/area], in the shape of `x`.
        """
        x2, a, c = np.asarray(x) ** 2, self.contact.a, self.stick_half_width
        outer = np.sqrt(np.maximum(a**2 - x2, 0.0)) / a
        inner = np.sqrt(np.maximum(c**2 - x2, 0.0)) / a
        return math.copysign(self.friction * self.contact.peak_pressure, self.force) * (outer - inner)

    def slip(self, x: np.ndarray) -> np.ndarray:
        """Shift of body 1 over body 2; zero in the stick area.

        Parameters
        ----------
        x : array_like
            Points [length].

        Returns
        -------
        ndarray
            [length], in the shape of `x`; nan outside the contact.
        """
        c = self.stick_half_width
        ratio = np.maximum(np.abs(np.asarray(x, dtype=float)) / c, 1.0)
        size = self.friction * c**2 / (2 * self.contact.R) * (ratio * np.sqrt(ratio**2 - 1) - np.arccosh(ratio))
        return np.where(np.abs(x) <= self.contact.a, -math.copysign(1.0, self.force) * size, np.nan)


def cattaneo_line(contact: LineContact, friction: float, force: float) -> CattaneoLine:
    """Cattaneo's shift of like cylinders under a tangential force along x.

    Parameters
    ----------
    contact : LineContact
        From `line_contact`, with like bodies (K = 0).
    friction : float
        Coefficient of friction.
    force : float
        Tangential force on body 1 per unit length, below ``friction * contact.force`` in size.

    Returns
    -------
    CattaneoLine

    Raises
    ------
    SceneError
        For unlike bodies, or friction that is not positive.
    Saturated
        If the force is not below the limit of friction.

    Notes
    -----
    Johnson 1985. In the slip areas the local shift is
    ``-sign(F) f / (2 R) (|x| sqrt(x^2 - c^2) - c^2 arcosh(|x|/c))``. The rigid shift of the bodies is not given: in
    plane strain it depends on the bodies as a whole.

    Examples
    --------
    >>> from varcontact import Bodies
    >>> from varcontact.reference import line_contact
    >>> contact = line_contact(2.0, Bodies(G=1.0, nu=0.25), a=0.01)
    >>> print(f"{cattaneo_line(contact, 0.3, 0.75 * 0.3 * contact.force).stick_half_width:.6f}")
    0.005000
    """
    limit, force = friction_limit(contact, friction), number("force", force)
    part = part_of_limit(force, limit)
    return CattaneoLine(contact, float(friction), force, contact.a * math.sqrt(1 - part))
