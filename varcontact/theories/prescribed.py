"""The inverse of a theory: creepages for prescribed forces."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from varcontact.checks import number, positive
from varcontact.errors import NotConverged, Saturated
from varcontact.theories.fastsim import fastsim
from varcontact.theories.inputs import either
from varcontact.theories.simplified import PEAK
from varcontact.theories.strips import Strips, printed

if TYPE_CHECKING:
    from collections.abc import Callable

    from varcontact.reference.creepage_coefficients import CreepageCoefficients

FARTHEST = 1e12
"""Farthest creepage looked for, in units of the one where friction is used up without spin."""


def creepage_for_force(
    a: float,
    b: float,
    G: float,
    friction_force: float,
    coefficients: CreepageCoefficients,
    *,
    vx: float | None = None,
    vy: float | None = None,
    spin: float = 0.0,
    Fx: float | None = None,
    Fy: float | None = None,
    m: int = 10,
    n: int = 10,
    bound: str = "parabolic",
    flexibility: str = "separate",
) -> np.ndarray:
    """Creepages for which `fastsim` gives the prescribed forces.

    Parameters
    ----------
    a, b, G, friction_force, coefficients, m, n, bound, flexibility
        As for `fastsim`, all single.
    vx, vy : float, optional
        Creepages that are given [-]; 0 where neither the creepage nor its force is given.
    spin : float
        Spin [1/length].
    Fx, Fy : float, optional
        Force on body 1 in place of vx and of vy.

    Returns
    -------
    ndarray, shape (3,)
        vx, vy, spin. As the weighted L depends on the creepages, another triple may give the same force with it.

    Raises
    ------
    SceneError
        As `fastsim`, or if a creepage and its force are both given.
    Saturated
        If the prescribed force is not below the sum of the traction bound over the points (near
        ``friction_force``, see `fastsim`).
    NotConverged
        If no creepages are found.

    Examples
    --------
    >>> from varcontact.reference import creepage_coefficients
    >>> contact = (6.8, 6.5, 8e4, 45000.0)
    >>> table = creepage_coefficients(6.8, 6.5, 0.25)
    >>> creepage = creepage_for_force(*contact, table, Fx=20000.0, Fy=0.0, spin=0.00054)
    >>> print(fastsim(*contact, creepage, table).force.round(3) + 0.0)
    [20000.     0.]
    """
    given_x, Fx = either("vx", vx, "Fx", Fx)
    given_y, Fy = either("vy", vy, "Fy", Fy)
    spin = number("spin", spin)
    strips = printed(m, n, bound)
    a, b, friction_force = positive("a", a), positive("b", b), positive("friction_force", friction_force)
    _check_carried(np.hypot(Fx or 0.0, Fy or 0.0), friction_force * _carried_part(strips))
    unit = 3 * friction_force / (positive("G", G) * a * b * coefficients.C11)  # w' = 1 in (123)

    def force(x: float, y: float) -> np.ndarray:
        creepage, options = (x, y, spin), {"bound": bound, "flexibility": flexibility}
        return fastsim(a, b, G, friction_force, creepage, coefficients, m=m, n=n, **options).force

    return np.array([*creepages_meeting(force, (given_x, given_y), (Fx, Fy), unit, friction_force), spin])


def creepages_meeting(
    force: Callable[[float, float], np.ndarray],
    given: tuple[float, float],
    prescribed: tuple[float | None, float | None],
    unit: float,
    friction_force: float,
) -> tuple[float, float]:
    """vx and vy at which a theory gives the prescribed forces; those that are given where there are none.

    Parameters
    ----------
    force : callable
        Fx and Fy of vx and vy, falling with them.
    given : pair of float
        Creepages for directions without a force.
    prescribed : pair of float or None
    unit : float
        A creepage at which it slips.
    friction_force : float
        By which a miss is judged.

    Raises
    ------
    NotConverged
        If none are found.
    """
    Fx, Fy = prescribed

    def lateral(x: float) -> float:
        return given[1] if Fy is None else _root(lambda y: float(force(x, y)[1]) - Fy, unit)

    if Fx is not None and Fy is not None:
        quick = _newton(lambda v: (force(*v) - (Fx, Fy)) / friction_force, unit)
        if quick is not None:
            return float(quick[0]), float(quick[1])
    x = given[0] if Fx is None else _root(lambda x: float(force(x, lateral(x))[0]) - Fx, unit)
    y = lateral(x)
    found = force(x, y)
    miss = max((abs(found[i] - F) for i, F in enumerate(prescribed) if F is not None), default=0.0)
    if miss > 1e-9 * friction_force:
        raise NotConverged("no creepages found for the prescribed force", miss / friction_force)
    return x, y


def _newton(miss: Callable[[np.ndarray], np.ndarray], unit: float) -> np.ndarray | None:
    """Both creepages at once by Powell's hybrid method; None where it fails, as it may near saturation."""
    from scipy.optimize import root

    result = root(lambda v: miss(unit * v), np.zeros(2), tol=1e-13, options={"maxfev": 60})
    return unit * result.x if np.all(np.abs(result.fun) < 1e-11) else None


def _carried_part(strips: Strips) -> float:
    """Sum of the traction bound over FASTSIM's points, as a part of f Fz."""
    across = np.sum(strips.width * strips.edge * strips.peak)
    return float(PEAK[strips.bound] * across * strips.step * np.sum(strips.bounds))


def _check_carried(force: float, limit: float) -> None:
    if force >= limit:
        raise Saturated(float(force), limit)


def _root(excess: Callable[[float], float], unit: float) -> float:
    """Where a function that falls from positive to negative is 0; it starts from ``[-unit, unit]``.

    Forces fall with their creepages from one limit of friction to the other, so that there is a root whatever
    the spin. One direction inside the other is slower than Newton's method in both, but it cannot get lost where
    slip sets in or the force is nearly saturated.
    """
    from scipy.optimize import brentq

    low, high = -unit, unit
    while excess(low) < 0:
        low *= 4
        if low < -FARTHEST * unit:
            raise NotConverged("no creepage found for the prescribed force", abs(excess(low)))
    while excess(high) > 0:
        high *= 4
        if high > FARTHEST * unit:
            raise NotConverged("no creepage found for the prescribed force", abs(excess(high)))
    return float(brentq(excess, low, high, xtol=1e-15 * unit, rtol=1e-14, maxiter=500))
