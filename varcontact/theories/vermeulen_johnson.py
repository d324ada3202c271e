"""The creep-force line of Vermeulen and Johnson, and Kalker's (paper, section
2.1.2): creepage without spin.

Source: P. J. Vermeulen and K. L. Johnson, Contact of nonspherical elastic
bodies transmitting tangential forces, J. Appl. Mech. 31 (1964) 338-340.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from varcontact.checks import numbers, poisson_ratio, positive
from varcontact.errors import SceneError
from varcontact.reference.creepage_coefficients import CreepageCoefficients
from varcontact.theories.force_inversion import creepage_carrying
from varcontact.theories.linear import (
    Contact,
    Forces,
    as_resultants,
    checked_contact,
    creepage_or_force,
    creepage_triple,
)


@dataclass(frozen=True)
class VermeulenJohnsonCoefficients:
    """The slope of Vermeulen and Johnson's own line at the origin, as
    coefficients like Kalker's C11 and C22.

    Attributes
    ----------
    C11, C22 : float
        [-]
    """

    C11: float
    C22: float


def vermeulen_johnson_coefficients(a: float, b: float, nu: float) -> VermeulenJohnsonCoefficients:
    """The creepage coefficients that follow from Vermeulen and Johnson's assumption.

    Parameters
    ----------
    a, b : float
        Semi-axes along the rolling direction and across it [length].
    nu : float
        Poisson's ratio (combined), in (-1, 0.5].

    Returns
    -------
    VermeulenJohnsonCoefficients

    Raises
    ------
    SceneError
        If a length is not positive and finite, or nu is out of range.

    Notes
    -----
    A semi-ellipsoidal traction over the contact, less one of the same form over a similar ellipse
    that touches it in its foremost point, gives a ``du/dx`` that is constant in the smaller
    ellipse, as stick requires. With ``g = b/a`` and ``N = g^2 sin^2 s + cos^2 s``, the displacement
    of a semi-ellipsoidal traction gives

        pi / C11 = g int_0^(pi/2) [(1 - 3 nu) sin^2 s + 3 nu sin^4 s] N^(-1/2)
        ds pi / C22 = g int_0^(pi/2) [(1 - nu) sin^2 s N^(-1/2) + nu g^2 sin^4 s
        N^(-3/2)] ds.

    For a circle that is ``16/(4 - 3 nu)`` and ``16/(4 - nu)``, Johnson's of
    1958.

    Examples
    --------
    >>> coefficients = vermeulen_johnson_coefficients(1.0, 1.0, 0.0)
    >>> print(f"{coefficients.C11:.4f} {coefficients.C22:.4f}")
    4.0000 4.0000
    """
    g = positive("b", b) / positive("a", a)
    nu = poisson_ratio("nu", nu)
    # In u = ln tan s the integrands are analytic for |Im u| < pi/2 and decay exponentially: the
    # trapezoidal rule with a step of 3/16 is exact to rounding, and a slender contact takes a few
    # points more, not many times as many.
    step = 0.1875
    end = 40.0 + max(0.0, -math.log(g))
    u = np.arange(-20.0, end, step)
    sine = np.exp(-0.5 * np.logaddexp(0.0, -2 * u))
    cosine = np.exp(-0.5 * np.logaddexp(0.0, 2 * u))
    root = np.hypot(g * sine, cosine)  # N^(1/2)
    weight = step * sine * cosine * (g / root)  # g N^(-1/2) ds
    along = np.sum(weight * sine**2 * (1 - 3 * nu * cosine**2))
    across = np.sum(weight * sine**2 * ((1 - nu) + nu * (g * sine / root) ** 2))
    return VermeulenJohnsonCoefficients(float(math.pi / along), float(math.pi / across))


def vermeulen_johnson(
    a: Any,
    b: Any,
    G: Any,
    friction_force: Any,
    creepages: Any,
    coefficients: CreepageCoefficients | VermeulenJohnsonCoefficients,
) -> np.ndarray:
    """Force by the line (123)-(134).

    Parameters
    ----------
    a, b, G, friction_force, creepages
        As of `fastsim`; the spin must be 0.
    coefficients : CreepageCoefficients or VermeulenJohnsonCoefficients
        Kalker's line with `creepage_coefficients`, the original one with
        `vermeulen_johnson_coefficients`.

    Returns
    -------
    ndarray, shape (..., 2)
        Fx, Fy on body 1.

    Raises
    ------
    SceneError
        If there is spin, a number is not finite, or one that must be positive
        is not.

    Examples
    --------
    >>> from varcontact.reference import creepage_coefficients
    >>> table = creepage_coefficients(1.0, 1.0, 0.0)
    >>> print(vermeulen_johnson(1.0, 1.0, 1.0, 1.0, (1.5 / table.C11, 0.0, 0.0), table).round(12))
    [-0.875  0.   ]
    """
    contact = checked_contact(a, b, G, friction_force, creepages, coefficients)
    return as_resultants(vermeulen_johnson_forces(contact)).force + 0.0


def vermeulen_johnson_forces(c: Contact) -> Forces:
    """Fx, Fy and Mz; the moment is that of `vermeulen_johnson_traction`."""
    x, y = _normalised(c)
    w = np.hypot(x, y)
    inside = np.minimum(w, 1.0)
    # the force is f Fz (1 - r^3), r = 1 - w': the inner ellipse carries r^3 of f Fz against it, its
    # middle at a (1 - r)
    factor = c.limit * ((inside - 3) * inside + 3) * (inside / np.where(w == 0, 1.0, w))
    rest = 1 - inside
    return factor * x, factor * y, -c.a * c.limit * (rest * rest * rest) * np.where(w <= 1, y, 0.0)


def _normalised(c: Contact) -> tuple[Any, Any]:
    """xi' and eta' of (123)-(124); spin is refused."""
    if np.any(c.spin):
        first = float(np.ravel(c.spin)[np.flatnonzero(c.spin)[0]])
        raise SceneError("spin", first, "0 in the theory of Vermeulen and Johnson")
    scale = -c.a * c.b * c.G / (3 * c.limit)
    return (scale * c.table.C11) * c.vx, (scale * c.table.C22) * c.vy


def vermeulen_johnson_creepage(
    a: float,
    b: float,
    G: float,
    friction_force: float,
    coefficients: CreepageCoefficients | VermeulenJohnsonCoefficients,
    *,
    vx: float | None = None,
    vy: float | None = None,
    Fx: float | None = None,
    Fy: float | None = None,
) -> np.ndarray:
    """Creepages for which `vermeulen_johnson` gives the prescribed forces.

    Parameters
    ----------
    a, b, G, friction_force, coefficients
        As for `vermeulen_johnson`, all single.
    vx, vy : float, optional
        Creepages that are given [-]; 0 where neither the creepage nor its force
        is given.
    Fx, Fy : float, optional
        Force on body 1 in place of vx and of vy.

    Returns
    -------
    ndarray, shape (3,)
        vx, vy, and 0 for the spin.

    Raises
    ------
    SceneError
        As `vermeulen_johnson`, or if a creepage and its force are both given.
    Saturated
        If the prescribed force is not below ``friction_force``.

    Examples
    --------
    >>> from varcontact.reference import creepage_coefficients
    >>> table = creepage_coefficients(1.0, 1.0, 0.0)
    >>> creepage = vermeulen_johnson_creepage(1.0, 1.0, 1.0, 1.0, table, Fx=-0.875)
    >>> print((table.C11 / 3 * creepage).round(12))
    [0.5 0.  0. ]
    """
    vx, Fx = creepage_or_force("vx", vx, "Fx", Fx)
    vy, Fy = creepage_or_force("vy", vy, "Fy", Fy)
    limit = positive("friction_force", friction_force)
    contact = checked_contact(
        positive("a", a), positive("b", b), positive("G", G), limit, np.zeros(3), coefficients
    )
    unit = 3 * limit / (a * b * G * coefficients.C11)

    def force(creepage: np.ndarray) -> np.ndarray:
        along, across, _ = creepage.tolist()
        return np.array(vermeulen_johnson_forces(replace(contact, vx=along, vy=across))[:2])

    return creepage_carrying(force, np.array([vx, vy, 0.0]), (Fx, Fy), unit, limit)


def vermeulen_johnson_traction(
    x: Any,
    y: Any,
    a: float,
    b: float,
    G: float,
    friction_force: float,
    creepage: Any,
    coefficients: CreepageCoefficients | VermeulenJohnsonCoefficients,
) -> np.ndarray:
    """Tractions that Vermeulen and Johnson assume: the bound, less one of its
    form over the ellipse of stick.

    Parameters
    ----------
    x, y : array_like
        Points [length].
    a, b, G, friction_force, coefficients
        As for `vermeulen_johnson`, all single.
    creepage : array_like, shape (3,)
        vx, vy [-] and spin, which must be 0.

    Returns
    -------
    ndarray, shape (2, ...)
        px, py on body 1 [force/area]; their total is that of
        `vermeulen_johnson`.

    Raises
    ------
    SceneError
        As `vermeulen_johnson`, and where a point is not finite.

    Notes
    -----
    With ``r = 1 - w' = (1 - F/(f Fz))^(1/3)``, the ellipse of stick has the semi-axes r a and r b
    and its middle at ``x = a (1 - r)``: it touches the contact in its foremost point. All tractions
    have the direction of the force; ahead of the ellipse of stick that is the direction of the
    slip, and friction there does negative work, on any grid.

    Examples
    --------
    >>> table = vermeulen_johnson_coefficients(1.0, 1.0, 0.0)
    >>> points = [0.9, 0.0, -0.5]
    >>> traction = vermeulen_johnson_traction(points, 0.0, 1, 1, 1.0, 1.0, (0.375, 0, 0), table)
    >>> print(traction[0].round(4))
    [-0.0649 -0.4775 -0.4135]
    """
    x, y = np.broadcast_arrays(numbers("x", x), numbers("y", y))
    a = positive("a", a)
    b = positive("b", b)
    limit = positive("friction_force", friction_force)
    G = positive("G", G)
    contact = checked_contact(a, b, G, limit, creepage_triple(creepage), coefficients)
    xi, eta = _normalised(contact)
    w = math.hypot(xi, eta)
    part = min(w, 1.0)
    # both ellipsoids by their height squared; the inner one has the outer's form, r = 1 - part
    # times as large
    outer = 1 - (x / a) ** 2 - (y / b) ** 2
    inner = (1 - part) ** 2 - (x / a - part) ** 2 - (y / b) ** 2
    heights = np.sqrt(np.maximum(outer, 0.0)) + np.sqrt(np.maximum(inner, 0.0))
    # the difference of the roots by that of the squares, 2 part (1 - x/a) in stick: nothing cancels
    # for small creepage
    squares = np.where(inner > 0, 2 * part * (1 - x / a), np.maximum(outer, 0.0))
    size = squares / np.where(heights > 0, heights, 1.0)
    peak = 1.5 * limit / (math.pi * a * b)
    return peak * np.multiply.outer(np.array([xi, eta]) / (w or 1.0), size)
