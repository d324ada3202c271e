"""Hertz's contact of two cylinders with parallel axes, in plane strain (paper, section 6.1).

Source: K. L. Johnson, Contact Mechanics, Cambridge University Press 1985.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from varcontact.checks import elastic, exactly_one, kind, positive
from varcontact.errors import Saturated, SceneError
from varcontact.reference.hertz import CombinedConstants


@dataclass(frozen=True)
class LineContact:
    """One line contact without friction, per unit length along y.

    Attributes
    ----------
    a : float
        Half-width of the contact strip [length].
    force : float
        Normal force per unit length [force/length].
    peak_pressure : float
        Pressure on the centre line [force/area].
    R : float
        Combined radius, ``1/R = 1/R1 + 1/R2`` [length].
    bodies : Bodies
        Elastic constants.
    """

    a: float
    force: float
    peak_pressure: float
    R: float
    bodies: CombinedConstants

    def pressure(self, x: np.ndarray) -> np.ndarray:
        """Semi-elliptical pressure [force/area] at points `x` [length], zero outside the
        contact.
        """
        return self.peak_pressure * np.sqrt(np.maximum(1 - (np.asarray(x) / self.a) ** 2, 0.0))

    def approach(self, depth: float) -> float:
        """Approach [length] where displacements count from the `depth` d of the logarithm,
        ``-ln(|x|/d)``, positive.

        ``a^2/(2 R) (ln(2 d/a) + 1/2)``, the displacement on the centre line. A material point below
        it, at a depth z far larger than a, has moved as a point of the surface at ``d = z exp(-1/(2
        (1 - nu_i)))`` has, nu_i that of its own body: with that d it is Johnson's formula (Johnson
        1985).
        """
        return self.a**2 / (2 * self.R) * (math.log(2 * positive("depth", depth) / self.a) + 0.5)


def line_contact(
    R: float,
    bodies: CombinedConstants,
    *,
    force: float | None = None,
    a: float | None = None,
    approach: float | None = None,
    depth: float | None = None,
) -> LineContact:
    """Hertz's solution for the undeformed distance ``x^2/(2 R)`` in plane strain.

    Parameters
    ----------
    R : float
        Combined radius of the cylinders [length].
    bodies : Bodies
        Elastic constants; unlikeness (K) has no part in Hertz's theory.
    force, a, approach : float
        Exactly one of the three: normal force per unit length, half-width of
        the contact [length], or approach of the bodies [length].
    depth : float, optional
        With the approach: the depth from which displacements count, see
        `LineContact.approach`.

    Returns
    -------
    LineContact

    Raises
    ------
    SceneError
        If a number is not positive and finite, or not exactly one of force,
        half-width and approach is given.

    Notes
    -----
    ``a^2 = 4 (1 - nu) N R / (pi G)`` and ``p0 = 2 N / (pi a) = G a / (2 (1 - nu) R)`` with the
    combined constants (58), (59); ``G/(1 - nu)`` is the E* of Johnson (1985). In plane strain the
    approach depends on the bodies as a whole: here through the depth.

    Examples
    --------
    >>> from varcontact import Bodies
    >>> contact = line_contact(0.25, Bodies(G=80e9, nu=0.25), force=1e6)
    >>> print(f"{contact.a:.6f} {contact.peak_pressure:.4g}")
    0.001727 3.685e+08
    """
    R = positive("R", R)
    elastic(bodies)
    exactly_one(force=force, a=a, approach=approach)
    if approach is not None:
        from scipy.special import lambertw

        if depth is None:
            raise SceneError("depth", None, "given: the approach is measured from a depth")
        approach = positive("approach", approach)
        depth = positive("depth", depth)
        if approach >= depth**2 / R:
            allowed = f"far below depth^2/R = {depth**2 / R:.6g}, where plane strain ends"
            raise SceneError("approach", approach, allowed)
        # approach = a^2/(2 R) (ln(2 d/a) + 1/2), which grows with a up to a = 2 d: by Lambert's
        # function
        branch = float(lambertw(-approach * R / (depth**2 * math.e), -1).real)
        a = 2 * depth * math.exp((1 + branch) / 2)
    stiffness = bodies.combined_G / (1 - bodies.combined_nu)
    if a is None:
        a = math.sqrt(4 * positive("force", force) * R / (math.pi * stiffness))
    else:
        a = positive("a", a)
    peak_pressure = stiffness * a / (2 * R)
    force = math.pi / 2 * a * peak_pressure if force is None else float(force)
    return LineContact(a, force, peak_pressure, R, bodies)


def friction_limit(contact: LineContact, friction: float) -> float:
    """The tangential force [force/length] that friction can carry between like bodies; others are
    refused.
    """
    kind("contact", contact, LineContact, more=", from line_contact")
    if contact.bodies.K != 0:
        raise SceneError("bodies.K", contact.bodies.K, "0: this closed form is for like bodies")
    return positive("friction", friction) * contact.force


def part_of_limit(force: float, limit: float) -> float:
    """Size of a tangential force divided by the friction limit, below 1 or `Saturated`."""
    if abs(force) >= limit:
        raise Saturated(abs(force), limit)
    return abs(force) / limit
