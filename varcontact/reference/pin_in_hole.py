"""A pin in a hole of nearly its radius, of one material and without friction: Persson's closed
form.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from varcontact import checks
from varcontact.errors import SceneError
from varcontact.reference.hertz import CombinedConstants


@dataclass(frozen=True)
class PinContact:
    """Pressures of a pin in a hole.

    Attributes
    ----------
    half_angle : float
        Angle of the contact either way [rad].
    force : float
        Compressive force per unit length [force/length].
    R : float
        Radius of the pin [length].
    """

    half_angle: float
    force: float
    R: float

    def pressure(self, angle: np.ndarray | float) -> np.ndarray:
        """Pressure [force/area]; 0 beyond the contact.

        Parameters
        ----------
        angle : array_like
            From the line of action of the force [rad].

        Returns
        -------
        ndarray

        Notes
        -----
        With ``b = tan(half_angle/2)``, ``y = tan(angle/2)``, ``w = sqrt(b^2 + 1)`` and ``r =
        sqrt(b^2 - y^2)``: ``force/R`` times ``2/(pi w) r/(1 + y^2) + ln((w + r)/(w - r))/(2 pi b^2
        w^2)``.
        """
        angle = np.asarray(angle, dtype=float)
        b = math.tan(self.half_angle / 2)
        inside = np.abs(angle) < self.half_angle
        y = np.tan(np.where(inside, angle, 0.0) / 2)
        w = math.sqrt(b * b + 1)
        r = np.sqrt(np.maximum(b * b - y * y, 0.0))
        shape = 2 / (math.pi * w) * r / (1 + y * y)
        shape = shape + 2 * np.arctanh(r / w) / (2 * math.pi * b * b * w * w)
        return np.asarray(np.where(inside, shape, 0.0) * self.force / self.R)

    @property
    def peak_pressure(self) -> float:
        """Largest pressure, on the line of action [force/area]."""
        return float(self.pressure(0.0))


@checks.named_options()
def pin_in_hole(
    R: float, clearance: float, bodies: CombinedConstants, *, force: float
) -> PinContact:
    """A pin of radius R in a hole of radius ``R + clearance``, in plane strain and
    without friction: Persson's closed form.

    Exact where both bodies are of one material, and the plate is large.

    Parameters
    ----------
    R, clearance : float
        Radius of the pin, and that of the hole less it [length].
    bodies : Bodies
    force : float
        Compressive force per unit length, at the centre of the pin.

    Returns
    -------
    PinContact

    Raises
    ------
    SceneError
        For numbers that are not positive (the clearance may be 0).

    Notes
    -----
    ``E' clearance/force = 2 (1 - b^2)/(pi b^2) - ln(b^2 + 1)/(pi b^2 (b^2 + 1))`` with ``b =
    tan(half_angle/2)`` and ``E' = 2 G/(1 - nu)``. Sources: A. Persson, On the stress distribution
    of cylindrical elastic bodies in contact, dissertation, Chalmers (1964); M. Ciavarella, P.
    Decuzzi, Int. J. Solids Struct. 38 (2001) 4507-4523.

    Examples
    --------
    A neat fit has the same contact under any force.

    >>> from varcontact.scene.bodies import Bodies
    >>> fit = pin_in_hole(1.0, 0.0, Bodies(G=1.0, nu=0.3), force=1e-3)
    >>> print(f"{np.degrees(fit.half_angle):.2f} degrees")
    84.83 degrees
    """
    from scipy.optimize import brentq

    R = checks.positive("R", R)
    clearance = checks.at_least_zero("clearance", clearance)
    force = checks.positive("force", force)
    modulus = 2 * bodies.combined_G / (1 - bodies.combined_nu)
    wanted = modulus * clearance / force
    if not math.isfinite(wanted):
        raise SceneError("force", force, "larger: the contact would be a point")

    def excess(b: float) -> float:
        """Pi b^2 times the difference of both sides."""
        square = b * b
        return 2 * (1 - square) - math.log1p(square) / (1 + square) - math.pi * square * wanted

    b = brentq(excess, 0.0, 1.0, xtol=1e-300, rtol=1e-14)
    return PinContact(half_angle=2 * math.atan(b), force=force, R=R)
