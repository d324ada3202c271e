"""Bufler's rolling of two unlike cylinders without slip and without tangential
force (paper, section 6.1.2).

Sources: H. Bufler, Zur Theorie der rollenden Reibung, Ing.-Arch. 27 (1959); K.
L. Johnson, Contact Mechanics, Cambridge University Press 1985.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from varcontact.checks import elastic, exactly_one, positive
from varcontact.reference.hertz import CombinedConstants
from varcontact.reference.line_contact import line_contact


@dataclass(frozen=True)
class Bufler:
    """Free steady rolling of unlike cylinders that stick everywhere.

    Attributes
    ----------
    a : float
        Half-width of the contact strip [length].
    force : float
        Normal force per unit length; the tangential force is zero.
    creepage : float
        Longitudinal creepage vx, ``-2 eta a / R``.
    eta : float
        Exponent of the oscillation at the edges,
        ``ln((1 + beta)/(1 - beta)) / (2 pi)``.
    R : float
        Combined radius, ``1/R = 1/R1 + 1/R2`` [length].
    bodies : Bodies
        Elastic constants.
    """

    a: float
    force: float
    creepage: float
    eta: float
    R: float
    bodies: CombinedConstants

    def pressure(self, x: np.ndarray) -> np.ndarray:
        """Pressure pz [force/area] at points `x` [length], in their shape; zero outside the
        contact.
        """
        amplitude, phase = self._polar(x)
        return amplitude * np.cos(phase)

    def traction(self, x: np.ndarray) -> np.ndarray:
        """Traction px [force/area] at points `x` [length], in their shape; zero outside the
        contact.
        """
        amplitude, phase = self._polar(x)
        return amplitude * np.sin(phase)

    def _polar(self, x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Size and angle of pz + i px."""
        t = np.asarray(x, dtype=float) / self.a
        t = np.where(np.abs(t) < 1, t, 0.0)
        stiffness = self.bodies.combined_G / (1 - self.bodies.combined_nu)
        peak = stiffness * self.a / (2 * self.R) * math.cosh(math.pi * self.eta)
        root = np.sqrt((1 - t) * (1 + t))
        return np.where(np.abs(x) < self.a, peak * root, 0.0), 2 * self.eta * np.arctanh(t)


def bufler(
    R: float, bodies: CombinedConstants, *, force: float | None = None, a: float | None = None
) -> Bufler:
    """Free rolling of unlike cylinders in the direction of x, with friction so
    large that nothing slips.

    Parameters
    ----------
    R : float
        Combined radius of the cylinders [length].
    bodies : Bodies
        Elastic constants; like bodies give Hertz's contact without tractions.
    force, a : float
        Exactly one of the two: normal force per unit length, or half-width of
        the contact [length].

    Returns
    -------
    Bufler

    Raises
    ------
    SceneError
        If a number is not positive and finite, or not exactly one of force and
        half-width is given.

    Notes
    -----
    Stick ``du/dx = vx`` and contact ``dw/dx = -x/R`` over the strip, with the derivatives of the
    displacement differences in plane strain and ``beta = K / (1 - nu)`` (Dundurs), are one equation
    for ``P = pz + i px``::

        (1/pi) PV int P(t)/(x - t) dt + i beta P(x) = G/(2 (1 - nu)) (x/R - i vx),    |x| < a.

    Its solution that is bounded at both edges exists for one creepage,
    ``vx = -2 eta a / R``, and is
    ``P = G/(2 (1 - nu) R) cosh(pi eta) sqrt(a^2 - x^2) exp(i eta ln((a + x)/(a - x)))``,
    with ``cosh(pi eta) = 1/sqrt(1 - beta^2)``. Its normal force is
    ``pi a^2 G (1 + 4 eta^2) / (4 (1 - nu) R)``, its tangential force zero
    (Bufler 1959; Johnson 1985).

    Very near the edges the pressure changes its sign without end, first where
    ``1 - |x|/a`` is about ``2 exp(-pi / (2 |eta|))``: for one rigid body and nu
    = 0 at 2.5e-4, else nearer.

    With a tangential force P is singular at the trailing edge, like
    ``(a + x)^(-1/2 + i eta)``. The pressure then oscillates there without bound
    between both signs, whatever the width; the two forces are two real
    equations for three unknowns (half-width, middle of the contact, creepage),
    and neither boundedness nor ``pz >= 0`` can be the third. That case is
    therefore not offered.

    Examples
    --------
    The paper's bodies, the lower one rigid:

    >>> from varcontact import Bodies
    >>> rolling = bufler(100.0, Bodies(G=(1.0, float("inf")), nu=(0.286, 0.0)), a=1.0)
    >>> print(f"{rolling.eta:.5f} {rolling.creepage:.7f}")
    0.09843 -0.0019685
    """
    exactly_one(force=force, a=a)
    elastic(bodies)
    eta = math.atanh(bodies.K / (1 - bodies.combined_nu)) / math.pi
    more = 1 + 4 * eta**2  # so many times the force of Hertz's contact of the same half-width
    if force is None:
        hertz = line_contact(R, bodies, a=a)
        force = more * hertz.force
    else:
        hertz = line_contact(R, bodies, force=positive("force", force) / more)
        force = float(force)
    return Bufler(hertz.a, force, -2 * eta * hertz.a / hertz.R, eta, hertz.R, bodies)
