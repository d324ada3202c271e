"""Carter's steady rolling of two like cylinders (paper, section 6.1.1).

Sources: F. W. Carter, On the action of a locomotive driving wheel, Proc. R.
Soc. Lond. A 112 (1926) 151-157; K. L. Johnson, Contact Mechanics, Cambridge
University Press 1985.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from varcontact.checks import exactly_one, number
from varcontact.reference.line_contact import LineContact, friction_limit, part_of_limit


@dataclass(frozen=True)
class Carter:
    """Steady rolling of like cylinders: one stick area at the leading edge, one
    slip area behind it.

    Attributes
    ----------
    contact : LineContact
        The Hertzian line contact.
    friction : float
        Coefficient of friction.
    creepage : float
        Longitudinal creepage vx.
    force : float
        Tangential force on body 1 along x, per unit length; opposite to the
        creepage.
    stick_half_width : float
        c; the stick area is ``a - 2 c <= x <= a`` [length]; zero in full
        sliding.
    """

    contact: LineContact
    friction: float
    creepage: float
    force: float
    stick_half_width: float

    @property
    def full_sliding_creepage(self) -> float:
        """Least creepage at which everything slides, ``f a / R``."""
        return self.friction * self.contact.a / self.contact.R

    def traction(self, x: np.ndarray) -> np.ndarray:
        """Traction along x [force/area] at points `x` [length]: the bound, less a Hertz-like one
        where it sticks.
        """
        a = self.contact.a
        c = self.stick_half_width
        outer = np.sqrt(np.maximum(a**2 - np.asarray(x) ** 2, 0.0)) / a
        inner = np.sqrt(np.maximum(c**2 - (np.asarray(x) - (a - c)) ** 2, 0.0)) / a
        peak = math.copysign(self.friction * self.contact.peak_pressure, -self.creepage)
        return peak * (outer - inner)

    def slip(self, x: np.ndarray) -> np.ndarray:
        """Relative slip [-] of body 1 over body 2 at points `x` [length]: zero in the stick area,
        nan outside.
        """
        x = np.asarray(x, dtype=float)
        a = self.contact.a
        c = self.stick_half_width
        beyond = np.maximum((x - (a - c)) ** 2 - c**2, 0.0)
        elastic = self.friction / self.contact.R * np.sqrt(beyond)
        excess = max(abs(self.creepage) - self.full_sliding_creepage, 0.0)
        size = np.where(x <= a - 2 * c, elastic, 0.0) + excess
        return np.where(np.abs(x) <= a, math.copysign(1.0, self.creepage) * size, np.nan)


def carter(
    contact: LineContact,
    friction: float,
    *,
    creepage: float | None = None,
    force: float | None = None,
) -> Carter:
    """Carter's steady rolling in the direction of x, like cylinders.

    Parameters
    ----------
    contact : LineContact
        From `line_contact`, with like bodies (K = 0).
    friction : float
        Coefficient of friction.
    creepage, force : float
        Exactly one of the two: longitudinal creepage, or tangential force on
        body 1 per unit length, below ``friction * contact.force`` in size.

    Returns
    -------
    Carter

    Raises
    ------
    SceneError
        For unlike bodies, friction that is not positive, or not exactly one of
        creepage and force.
    Saturated
        If the force is not below the limit of friction.

    Notes
    -----
    ``c = a (1 - |vx| R / (f a)) = a sqrt(1 - |F| / (f N))`` (Carter 1926; Johnson 1985). The
    relative slip is ``vx - du/dx``, in the slip area ``sign(vx) (f / R) sqrt((x - a + c)^2 -
    c^2)``. From a creepage of ``f a / R`` on, the whole contact slides, and the force is ``f N``.

    Examples
    --------
    >>> from varcontact import Bodies
    >>> from varcontact.reference import line_contact
    >>> contact = line_contact(2.0, Bodies(G=1.0, nu=0.25), a=0.01)
    >>> rolling = carter(contact, 0.3, force=-0.75 * 0.3 * contact.force)
    >>> print(f"{rolling.stick_half_width:.6f} {rolling.creepage:.6f}")
    0.005000 0.000750
    >>> print(f"{rolling.full_sliding_creepage:.6f}")
    0.001500
    """
    limit = friction_limit(contact, friction)
    friction = float(friction)
    full = friction * contact.a / contact.R
    exactly_one(creepage=creepage, force=force)
    if creepage is None:
        force = number("force", force)
        part = part_of_limit(force, limit)
        root = math.sqrt(1 - part)
        creepage = -math.copysign(full * part / (1 + root), force)
        return Carter(contact, friction, creepage, force, contact.a * root)
    creepage = number("creepage", creepage)
    part = min(abs(creepage) / full, 1.0)
    force = -math.copysign(limit * part * (2 - part), creepage)
    return Carter(contact, friction, creepage, force, contact.a * (1 - part))
