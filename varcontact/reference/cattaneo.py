"""Cattaneo's and Mindlin's shift of two like spheres or cylinders (paper,
sections 6.2.1 and 6.4.1).

Source: R. D. Mindlin, Compliance of elastic bodies in contact, J. Appl. Mech.
16 (1949) 259-268; K. L. Johnson, Contact Mechanics, Cambridge University Press
1985.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from varcontact.checks import elastic, kind, number, positive
from varcontact.reference.hertz import CombinedConstants, HertzContact
from varcontact.reference.line_contact import LineContact, friction_limit, part_of_limit


@dataclass(frozen=True)
class CattaneoMindlin:
    """A circular contact shifted by a tangential force: stick radius, shift, and traction.

    Attributes
    ----------
    contact : HertzContact
        The (circular) Hertzian contact.
    friction : float
        Coefficient of friction.
    force : float
        Tangential force on body 1 along x.
    stick_radius : float
        Radius of the stick area, ``a (1 - |F|/(f Fz))^(1/3)`` [length].
    shift : float
        Rigid shift of body 1 over body 2 along x, opposite to the force
        [length].
    """

    contact: HertzContact
    friction: float
    force: float
    stick_radius: float
    shift: float

    def traction(self, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        """Traction along x [force/area] at points `x`, `y` [length]: the bound, less Hertz's shape
        where it sticks.
        """
        r2 = np.asarray(x) ** 2 + np.asarray(y) ** 2
        p0 = self.friction * self.contact.peak_pressure
        a = self.contact.a
        c = self.stick_radius
        outer = np.sqrt(np.maximum(a**2 - r2, 0.0)) / a
        inner = np.sqrt(np.maximum(c**2 - r2, 0.0)) / a
        return math.copysign(p0, self.force) * (outer - inner)


def cattaneo_mindlin(
    contact: HertzContact, bodies: CombinedConstants, friction: float, force: float
) -> CattaneoMindlin:
    """Cattaneo's shift of like spheres under a tangential force along x.

    Parameters
    ----------
    contact : HertzContact
        A circular contact, from `hertz`.
    bodies : Bodies
        Like bodies (K = 0).
    friction : float
        Coefficient of friction.
    force : float
        Tangential force on body 1, below ``friction * contact.force`` in size.

    Raises
    ------
    SceneError
        If the contact is none, or friction is not positive.
    Saturated
        If the force is not below the limit of friction.

    Notes
    -----
    ``shift = -sign(F) 3 (2 - nu) f Fz / (8 G a) (1 - (1 - |F|/(f Fz))^(2/3))``, the displacement
    difference of both bodies (Johnson 1985). The lateral traction that keeps slip and traction
    opposite is neglected in it, as it vanishes for nu = 0 only: there the solution is exact.

    Examples
    --------
    The paper's spheres (6.4.1): the stick area has 0.7 of the contact's radius.

    >>> from varcontact import Bodies
    >>> from varcontact.reference import hertz
    >>> bodies = Bodies(G=1.0, nu=0.28)
    >>> contact = hertz(337.5 / 2, 337.5 / 2, bodies, force=(7 / 9) ** 3)
    >>> shift = cattaneo_mindlin(contact, bodies, 0.4013, -0.657 * 0.4013 * contact.force)
    >>> print(f"{contact.a:.3f} {shift.stick_radius / contact.a:.4f}")
    3.500 0.7000
    """
    kind("contact", contact, HertzContact, more=", from hertz")
    elastic(bodies)
    friction = positive("friction", friction)
    force = number("force", force)
    limit = friction * contact.force
    part = part_of_limit(force, limit)
    size = 3 * (2 - bodies.combined_nu) * limit / (8 * bodies.combined_G * contact.a)
    shift = -math.copysign(size * -math.expm1(2 / 3 * math.log1p(-part)), force)
    return CattaneoMindlin(contact, friction, force, contact.a * (1 - part) ** (1 / 3), shift)


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
        """Traction along x [force/area] at points `x` [length]: the bound, less Hertz's shape where
        it sticks.
        """
        x2 = np.asarray(x) ** 2
        a = self.contact.a
        c = self.stick_half_width
        outer = np.sqrt(np.maximum(a**2 - x2, 0.0)) / a
        inner = np.sqrt(np.maximum(c**2 - x2, 0.0)) / a
        peak = math.copysign(self.friction * self.contact.peak_pressure, self.force)
        return peak * (outer - inner)

    def slip(self, x: np.ndarray) -> np.ndarray:
        """Shift [length] of body 1 over body 2 at points `x` [length]: zero in the stick area, nan
        outside.
        """
        c = self.stick_half_width
        ratio = np.maximum(np.abs(np.asarray(x, dtype=float)) / c, 1.0)
        factor = self.friction * c**2 / (2 * self.contact.R)
        size = factor * (ratio * np.sqrt(ratio**2 - 1) - np.arccosh(ratio))
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
        Tangential force on body 1 per unit length, below
        ``friction * contact.force`` in size.

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
    ``-sign(F) f / (2 R) (|x| sqrt(x^2 - c^2) - c^2 arcosh(|x|/c))``. The rigid shift of the bodies
    is not given: in plane strain it depends on the bodies as a whole.

    Examples
    --------
    >>> from varcontact import Bodies
    >>> from varcontact.reference import line_contact
    >>> contact = line_contact(2.0, Bodies(G=1.0, nu=0.25), a=0.01)
    >>> print(f"{cattaneo_line(contact, 0.3, 0.75 * 0.3 * contact.force).stick_half_width:.6f}")
    0.005000
    """
    limit = friction_limit(contact, friction)
    force = number("force", force)
    part = part_of_limit(force, limit)
    return CattaneoLine(contact, float(friction), force, contact.a * math.sqrt(1 - part))
