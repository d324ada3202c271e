"""Simplified theory: displacement = flexibility times traction, in closed form
(paper, sections 3.2.2-3.2.5).

Source: J. J. Kalker, Simplified theory of rolling contact, Delft Progress
Report 1 (1973).
"""

from __future__ import annotations

from typing import Any

import numpy as np

from varcontact.checks import choice, number, numbers, positive, positives
from varcontact.errors import SceneError
from varcontact.reference.creepage_coefficients import CreepageCoefficients
from varcontact.theories.linear import Contact, creepage_triples

PEAK = {"parabolic": 2 / np.pi, "elliptic": 1.5 / np.pi}
"""Peak of the traction bound times ``a b / (f Fz)``: (167) and (166)."""


FLEXIBILITIES = ("separate", "weighted")
"""Each creepage by its own flexibility, or all by the single one of (164)."""


def flexibilities(a: Any, b: Any, G: Any, coefficients: CreepageCoefficients) -> np.ndarray:
    """The three flexibilities (161)-(163), each of which gives one creepage the
    slope of the linear theory.

    Parameters
    ----------
    a, b, G : float or array_like
        Semi-axes along the rolling direction and across it [length], and
        combined modulus of rigidity [force/area].
    coefficients : CreepageCoefficients
        From `creepage_coefficients`.

    Returns
    -------
    ndarray, shape (..., 3)
        L1, L2, L3: for vx, vy and spin [length^3/force]. L3 is as negative as
        C23, which happens in wide contacts (a/b of 0.01) with a negative
        Poisson's ratio: simplified theory cannot treat spin there.

    Raises
    ------
    SceneError
        If a, b or G is not positive and finite.

    Examples
    --------
    G L / a as in Table 4 at a/b = 1, which has .647, .534 and, for the second, the misprint .784.

    >>> from varcontact.reference import creepage_coefficients
    >>> print(flexibilities(1.0, 1.0, 1.0, creepage_coefficients(1.0, 1.0, 0.25)).round(3))
    [0.648 0.727 0.536]
    """
    a = positives("a", a)
    b = positives("b", b)
    G = positives("G", G)
    L1 = 8 * a / (3 * G * coefficients.C11)
    L2 = 8 * a / (3 * G * coefficients.C22)
    L3 = np.pi * a**2 / (4 * G * np.sqrt(a * b) * coefficients.C23)
    return np.stack(np.broadcast_arrays(L1, L2, L3), axis=-1)


def flexibility(
    a: Any, b: Any, G: Any, creepages: Any, coefficients: CreepageCoefficients
) -> np.ndarray:
    """The flexibility L, the mean (164) of (161)-(163), weighted with the creepages.

    Parameters
    ----------
    a, b, G, coefficients
        As for `flexibilities`.
    creepages : array_like, shape (..., 3)
        vx, vy [-] and spin [1/length].

    Returns
    -------
    ndarray, shape (...)
        L [length^3/force]. Without any creepage, where (164) is 0/0, it is L1.

    Raises
    ------
    SceneError
        If a, b or G is not positive and finite, creepages is no finite array
        (..., 3), or there is spin where C23 is not positive.

    Notes
    -----
    The weights ``|vx|/size`` and so on add up to one only where a creepage acts alone, else to up
    to ``sqrt(3)``: slopes are then too small by as much. See `flexibilities` for the three.

    Examples
    --------
    G L3 / a at a/b = 1; Table 4 has .534, from three digits of C23.

    >>> from varcontact.reference import creepage_coefficients
    >>> table = creepage_coefficients(1.0, 1.0, 0.25)
    >>> print(f"{flexibility(1.0, 1.0, 1.0, (0.0, 0.0, 0.001), table):.3f}")
    0.536
    """
    vx, vy, spin = np.abs(np.moveaxis(creepage_triples(creepages), -1, 0))
    L1, L2, L3 = np.moveaxis(flexibilities(a, b, G, coefficients), -1, 0)
    check_spin(spin, L3, coefficients)
    spin = spin * np.sqrt(positives("a", a) * positives("b", b))
    size = np.hypot(np.hypot(vx, vy), spin)
    still = size == 0
    size = np.where(still, 1.0, size)
    return np.where(still, L1, L1 * (vx / size) + L2 * (vy / size) + L3 * (spin / size))


def flexibilities_of(c: Contact, kind: str) -> np.ndarray:
    """Divisors of vx, vy and spin: the three flexibilities, or the weighted one three times."""
    if choice("flexibility", kind, FLEXIBILITIES) == "weighted":
        creepages = np.stack(np.broadcast_arrays(c.vx, c.vy, c.spin), axis=-1)
        weighted = flexibility(c.a, c.b, c.G, creepages, c.table)
        return np.broadcast_to(weighted[..., None], (*weighted.shape, 3))
    separate = flexibilities(c.a, c.b, c.G, c.table)
    check_spin(c.spin, separate[..., 2], c.table)
    return separate


def check_spin(spin: Any, L3: np.ndarray, coefficients: CreepageCoefficients) -> None:
    """Refuse spin with a flexibility that is not positive: its tractions would drive the slip."""
    if np.any((spin != 0) & ~(L3 > 0)):
        least = float(np.min(coefficients.C23))
        raise SceneError(
            "C23", least, "positive for simplified theory to treat spin; take an exact method"
        )


def slip_flexibility(a: float, b: float, L: np.ndarray, creepage: np.ndarray) -> float:
    """The flexibility by which tractions give the slip of one creepage: a mean of the three.

    With it the rigid slip is right in the mean square over the ellipse, ``int |c|^2 = L^2 int
    |c/L|^2``, so that full slip has the slip that it must have. It is their common value where they
    are the same; L1 without any creepage.
    """
    size = np.abs(creepage).max()
    if size == 0:
        return float(L[0])
    part = creepage / size * np.array([1.0, 1.0, np.hypot(a, b) / 2])
    return float(np.linalg.norm(part) / np.linalg.norm(part / L))


def simplified_linear_force(a: Any, b: Any, L: Any, creepages: Any) -> np.ndarray:
    """Force of the simplified theory without slip, (157)-(158): what FASTSIM
    tends to for small creepages.

    Parameters
    ----------
    a, b, L : float or array_like
        Semi-axes [length] and flexibility [length^3/force].
    creepages : array_like, shape (..., 3)
        vx, vy [-] and spin [1/length].

    Returns
    -------
    ndarray, shape (..., 2)
        Fx, Fy on body 1.

    Raises
    ------
    SceneError
        If a, b or L is not positive and finite, or creepages is no finite array
        (..., 3).

    Examples
    --------
    >>> print(simplified_linear_force(1.0, 1.0, 8.0, (0.003, 0.0, 0.0)))
    [-0.001  0.   ]
    """
    a = positives("a", a)
    b = positives("b", b)
    L = positives("L", L)
    vx, vy, spin = np.moveaxis(creepage_triples(creepages), -1, 0)
    by_creepage = 8 * a**2 * b / (3 * L)
    by_spin = np.pi * a**3 * b / (4 * L)
    # 0 - 0 is no negative zero
    Fx = 0.0 - by_creepage * vx
    Fy = 0.0 - by_creepage * vy - by_spin * spin
    return np.stack(np.broadcast_arrays(Fx, Fy), axis=-1)


def simplified_traction(
    x: Any,
    y: Any,
    a: float,
    b: float,
    L: float,
    friction_force: float,
    vx: float,
    vy: float,
    bound: str = "parabolic",
) -> np.ndarray:
    """Traction of the simplified theory without spin (3.2.5): the lesser of no
    slip (168) and the bound.

    Parameters
    ----------
    x, y : array_like
        Points [length].
    a, b, L, friction_force, vx, vy, bound
        As for `simplified_force`.

    Returns
    -------
    ndarray, shape (2, ...)
        px, py on body 1, opposite to the creepage; 0 outside the ellipse.

    Raises
    ------
    SceneError
        As `simplified_force`, and where a point is not finite.

    Examples
    --------
    >>> tractions = simplified_traction([0.99, 0.0, -0.9], 0.0, 1.0, 1.0, 1.0, 1.0, 0.5, 0.0)
    >>> print(tractions[0].round(4))
    [-0.005 -0.5   -0.121]
    """
    x, y = np.broadcast_arrays(numbers("x", x), numbers("y", y))
    a = positive("a", a)
    b = positive("b", b)
    L = positive("L", L)
    friction_force = positive("friction_force", friction_force)
    vx = number("vx", vx)
    vy = number("vy", vy)
    peak = PEAK[choice("bound", bound, PEAK)] * friction_force / (a * b)
    inside = np.maximum(1 - (x / a) ** 2 - (y / b) ** 2, 0.0)
    limit = peak * (inside if bound == "parabolic" else np.sqrt(inside))
    creep = np.hypot(vx, vy)
    size = np.minimum(creep * (a * np.sqrt(np.maximum(1 - (y / b) ** 2, 0.0)) - x) / L, limit)
    return -np.multiply.outer(np.array([vx, vy]) / (creep or 1.0), size)


def simplified_force(
    a: float, b: float, L: float, friction_force: float, vx: Any, vy: Any, bound: str = "parabolic"
) -> np.ndarray:
    """Total force of the simplified theory without spin, in closed form (3.2.5).

    Parameters
    ----------
    a, b : float
        Semi-axes along the rolling direction and across it [length].
    L : float
        Flexibility [length^3/force].
    friction_force : float
        ``f Fz``, the most that friction can carry [force].
    vx, vy : float or array_like
        Creepages [-].
    bound : {"parabolic", "elliptic"}
        Form of the traction bound, (167) or (166).

    Returns
    -------
    ndarray, shape (..., 2)
        Fx, Fy on body 1.

    Raises
    ------
    SceneError
        If a length, L or the force is not positive and finite, a creepage is
        not finite, or the bound has no such form.

    Notes
    -----
    Over each strip the traction sticks from the leading edge ``a(y)`` to where it meets the bound.
    For the parabolic bound with peak g0 that is at ``x = 2 a t - a(y)``, ``t = |v| a / (2 L g0)``,
    and

        F / f Fz = 1 - 16/(3 pi) int_0^arccos(t) (cos s - t)^3 cos s ds,    1 where t >= 1.

    For the elliptic bound it is the same part of every strip, and with
    ``t = |v| a / (L g0)``

        F / f Fz = 2/pi (arctan t + t / (1 + t^2)).

    With separate flexibilities vx/L1 and vy/L2 take the places of vx and vy,
    and 1 that of L.

    Examples
    --------
    >>> for vx in (0.5, 2.0):
    ...     print(f"{simplified_force(1.0, 1.0, 1.0, 1.0, vx, 0.0)[0]:.6f}")
    -0.818490
    -1.000000
    """
    a = positive("a", a)
    b = positive("b", b)
    L = positive("L", L)
    friction_force = positive("friction_force", friction_force)
    vx, vy = np.broadcast_arrays(numbers("vx", vx), numbers("vy", vy))
    peak = PEAK[choice("bound", bound, PEAK)] * friction_force / (a * b)
    creep = np.hypot(vx, vy)
    t = creep * a / (L * peak)
    if bound == "elliptic":
        part = 2 / np.pi * (np.arctan(t) + t / (1 + t * t))
    else:  # with d = pi/2 - arccos(t) nothing of first order cancels
        t = np.minimum(t / 2, 1.0)
        d = np.arcsin(t)
        sine = np.sqrt(1 - t * t)
        # int cos^4, less the 3 pi / 16 at t = 0
        fourth = -3 * d / 8 + np.sin(2 * d) / 4 - np.sin(4 * d) / 32
        third = sine - sine**3 / 3
        second = (np.pi / 2 - d) / 2 + np.sin(2 * d) / 4
        part = -16 / (3 * np.pi) * (fourth - 3 * t * third + 3 * t**2 * second - t**3 * sine)
        part = np.where(t == 1, 1.0, part)
    size = friction_force * part / np.where(creep == 0, 1.0, creep)
    return 0.0 - np.stack([size * vx, size * vy], axis=-1)
