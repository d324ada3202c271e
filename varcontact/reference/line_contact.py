"""Hertz's contact of two cylinders with parallel axes, in plane strain (paper, section 6.1)."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from varcontact.checks import positive
from varcontact.errors import SceneError

if TYPE_CHECKING:
    from varcontact.scene import Bodies


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
    bodies: Bodies

    def pressure(self, x: np.ndarray) -> np.ndarray:
        """Semi-elliptical pressure at x, zero outside the contact."""
        return self.peak_pressure * np.sqrt(np.maximum(1 - (np.asarray(x) / self.a) ** 2, 0.0))


def line_contact(R: float, bodies: Bodies, *, force: float | None = None, a: float | None = None) -> LineContact:
    """Hertz's solution for the undeformed distance ``x^2/(2 R)`` in plane strain.

    Parameters
    ----------
    R : float
        Combined radius of the cylinders [length].
    bodies : Bodies
        Elastic constants; unlikeness (K) has no part in Hertz's theory.
    force, a : float
        Exactly one of the two: normal force per unit length, or half-width of the contact [length].

    Returns
    -------
    LineContact

    Raises
    ------
    SceneError
        If a number is not positive and finite, or not exactly one of force and half-width is given.

    Notes
    -----
    ``a^2 = 4 (1 - nu) N R / (pi G)`` and ``p0 = 2 N / (pi a) = G a / (2 (1 - nu) R)`` with the combined constants
    (58), (59); ``G/(1 - nu)`` is the E* of Johnson, Contact Mechanics, section 4.2. There is no approach: in plane
    strain it depends on the bodies as a whole.

    Examples
    --------
    >>> from varcontact import Bodies
    >>> contact = line_contact(0.25, Bodies(G=80e9, nu=0.25), force=1e6)
    >>> print(f"{contact.a:.6f} {contact.peak_pressure:.4g}")
    0.001727 3.685e+08
    """
    R = positive("R", R)
    if (force is None) == (a is None):
        raise SceneError("force, a", (force, a), "exactly one of the two")
    stiffness = bodies.combined_G / (1 - bodies.combined_nu)
    a = math.sqrt(4 * positive("force", force) * R / (math.pi * stiffness)) if a is None else positive("a", a)
    peak_pressure = stiffness * a / (2 * R)
    return LineContact(a, math.pi / 2 * a * peak_pressure if force is None else float(force), peak_pressure, R, bodies)


def require_like(bodies: Bodies) -> None:
    """Raise where normal and tangential problem are coupled."""
    if bodies.K != 0:
        raise SceneError("bodies.K", bodies.K, "0 (like bodies: the closed form knows no coupling)")
