"""Polach's formula for the creep force, with spin and with reduced slopes for contaminated rails.

Sources: O. Polach, A fast wheel-rail forces calculation computer code, Veh.
Syst. Dyn. Suppl. 33 (1999) 728-739; O. Polach, Creep forces in simulations of
traction vehicles running on adhesion limit, Wear 258 (2005) 992-1000.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from varcontact.checks import number
from varcontact.errors import SceneError
from varcontact.reference.creepage_coefficients import CreepageCoefficients
from varcontact.theories.linear import Contact, Forces, as_resultants, checked_contact


def polach(
    a: Any,
    b: Any,
    G: Any,
    friction_force: Any,
    creepages: Any,
    coefficients: CreepageCoefficients,
    *,
    k_A: float = 1.0,
    k_S: float = 1.0,
) -> np.ndarray:
    """Force by Polach's formula.

    Parameters
    ----------
    a, b, G, friction_force, creepages, coefficients
        As of `fastsim`. For friction that falls with the slip velocity, take f
        at the velocity of ``|(vx, vy)|``.
    k_A, k_S : float
        Factors on the gradient in the areas of adhesion and of slip,
        ``0 < k_S <= k_A <= 1``. Polach (2005) takes 1 and 0.4 for a dry rail,
        0.3 and 0.1 for a wet one. The slope at the origin is ``(k_A + k_S)/2``
        of Kalker's.

    Returns
    -------
    ndarray, shape (..., 2)
        Fx, Fy on body 1. The formula has no moment.

    Raises
    ------
    SceneError
        If a number is not finite (or, where it must be, positive), or the
        factors are not in that order.

    Notes
    -----
    With ``c^2 = ((C11 vx)^2 + (C22 vy)^2)/(vx^2 + vy^2)``, ``s^2 = vx^2 + s_y^2``, where s_y is the
    larger in size of vy and ``vy + spin a``, and ``e = pi G ab c s/(4 f Fz)``,

        F = 2/pi f Fz [k_A e/(1 + (k_A e)^2) + arctan(k_S e)],
        Fx = -F vx/s,    Fy = -F vy/s + F_s.

    For ``k_A = k_S = 1`` without spin that is the simplified theory under the
    elliptic bound. The part of spin is

        F_s = 9/16 a f Fz q K spin/s,    q = 1 + 6.3 (1 - exp(-a/b)),
        e_s = 8/3 G b (ab)^(1/2) C23 abs(s_y)/(f Fz q),
        K = e_s (d^3/3 - d^2/2 + 1/6) - (1 - d^2)^(3/2)/3,    d = (e_s^2 - 1)/(e_s^2 + 1),

    with the sign that gives pure spin Kalker's slope. A total beyond f Fz is
    cut to it; the source leaves it as it is. Where spin and creepage mix, the
    slopes are not those of the linear theory.

    Examples
    --------
    >>> from varcontact.reference import creepage_coefficients
    >>> table = creepage_coefficients(1.0, 1.0, 0.25)
    >>> creepages = [(0.1, 0, 0), (0, 0, 0.1), (1e3, 0, 0)]
    >>> print(polach(1.0, 1.0, 1.0, 1.0, creepages, table).round(4) + 0.0)
    [[-0.3851  0.    ]
     [ 0.     -0.1448]
     [-1.      0.    ]]
    """
    contact = checked_contact(a, b, G, friction_force, creepages, coefficients)
    return as_resultants(polach_forces(contact, k_A, k_S)).force


def polach_forces(c: Contact, k_A: float = 1.0, k_S: float = 1.0) -> Forces:
    """Fx and Fy of `polach`, which has no Mz; `k_A` and `k_S` are checked here."""
    k_A = number("k_A", k_A)
    k_S = number("k_S", k_S)
    if not 0 < k_S <= k_A <= 1:
        raise SceneError("k_A, k_S", (k_A, k_S), "in the order 0 < k_S <= k_A <= 1")
    a, b = c.a, c.b
    vx, vy, spin = c.vx, c.vy, c.spin
    G = c.G
    limit = c.limit
    table = c.table
    ab = a * b
    slip = np.hypot(vx, vy)
    front = vy + spin * a
    across = np.where(np.abs(front) > np.abs(vy), front, vy)
    total = np.hypot(vx, across)
    stiff = np.hypot(table.C11 * vx, table.C22 * vy)  # c |(vx, vy)|
    with np.errstate(divide="ignore", invalid="ignore"):
        # the force by creepage
        gradient = np.pi * ab * G / (4 * limit) * (stiff / slip * total)
        adhesion = k_A * gradient / (1 + (k_A * gradient) ** 2)
        force = 2 / np.pi * limit * (adhesion + np.arctan(k_S * gradient))
        by_creepage = np.where(slip > 0, force / total, 0.0)
        Fx = -by_creepage * vx
        Fy = -by_creepage * vy
        # the force by spin
        q = 1 - 6.3 * np.expm1(-a / b)
        e = 8 / 3 * G * b * np.sqrt(a * b) * table.C23 * np.abs(across) / (limit * q)
        rest = 2 / (e * e + 1)  # 1 - d, so that nothing cancels for large e
        d = 1 - rest
        # d^3/3 - d^2/2 + 1/6 = (1 - d)^2 (1 + 2 d)/6
        K = np.abs(e) * rest**2 * (1 + 2 * d) / 6 - (rest * (1 + d)) ** 1.5 / 3
        by_spin = np.where(total > 0, (-9 / 16 * a * limit * q * K * np.sign(e)) / total, 0.0)
    Fy = Fy - by_spin * spin
    cut = limit / np.maximum(np.hypot(Fx, Fy), limit)
    return Fx * cut + 0.0, Fy * cut + 0.0, np.nan
