"""The inverse of a theory: creepages for prescribed forces."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from varcontact.checks import number, positive
from varcontact.errors import NotConverged, Saturated
from varcontact.reference.creepage_coefficients import CreepageCoefficients
from varcontact.theories.fastsim import fastsim
from varcontact.theories.linear import creepage_or_force

FARTHEST = 1e12
"""Largest creepage tried, in units of the creepage at which friction saturates without spin."""
HYBRID = {"maxfev": 60}
"""Options of Powell's hybrid method: most evaluations of the forces."""


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
        Creepages that are given [-]; 0 where neither the creepage nor its force
        is given.
    spin : float
        Spin [1/length].
    Fx, Fy : float, optional
        Force on body 1 in place of vx and of vy.

    Returns
    -------
    ndarray, shape (3,)
        vx, vy, spin. As the weighted L depends on the creepages, another triple
        may give the same force with it.

    Raises
    ------
    SceneError
        As `fastsim`, or if a creepage and its force are both given.
    Saturated
        If the prescribed force is not below the sum of the traction bound over
        the points (near ``friction_force``, see `fastsim`).
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
    vx, Fx = creepage_or_force("vx", vx, "Fx", Fx)
    vy, Fy = creepage_or_force("vy", vy, "Fy", Fy)
    spin = number("spin", spin)
    a = positive("a", a)
    b = positive("b", b)
    friction_force = positive("friction_force", friction_force)
    unit = 3 * friction_force / (positive("G", G) * a * b * coefficients.C11)  # w' = 1 in (123)
    options: dict[str, Any] = {"m": m, "n": n, "bound": bound, "flexibility": flexibility}

    def force(creepage: np.ndarray) -> np.ndarray:
        return fastsim(a, b, G, friction_force, creepage, coefficients, **options).force

    carried = -float(force(np.array([FARTHEST * unit, 0.0, 0.0]))[0])
    return creepage_carrying(force, np.array([vx, vy, spin]), (Fx, Fy), unit, carried)


def creepage_carrying(
    force: Callable[[np.ndarray], np.ndarray],
    creepage: np.ndarray,
    prescribed: tuple[float | None, float | None],
    unit: float,
    carried: float,
) -> np.ndarray:
    """A creepage (3,) with vx and vy changed to where a theory gives the prescribed forces, of
    `carried` at most.

    The forces fall with vx and vy; at a creepage of about `unit` all slips.
    """
    Fx, Fy = prescribed
    if Fx is None and Fy is None:
        return creepage
    size = float(np.hypot(Fx or 0.0, Fy or 0.0))
    if size >= carried:
        raise Saturated(size, carried)
    vx, vy, spin = (float(value) for value in creepage)

    def at(x: float, y: float) -> np.ndarray:
        return force(np.array([x, y, spin]))

    if Fx is not None and Fy is not None:
        both = _both_at_once(at, np.array([Fx, Fy]), unit, carried)
        if both is not None:
            return np.array([*both, spin])
    x, y = _one_inside_the_other(at, (vx, vy), prescribed, unit)
    forces = at(x, y)
    error = max(abs(forces[i] - F) for i, F in enumerate(prescribed) if F is not None)
    if error > 1e-9 * carried:
        raise NotConverged("no creepages found for the prescribed force", error / carried)
    return np.array([x, y, spin])


def _one_inside_the_other(
    at: Callable[[float, float], np.ndarray],
    creepage: tuple[float, float],
    prescribed: tuple[float | None, float | None],
    unit: float,
) -> tuple[float, float]:
    """vx and vy of the prescribed forces, vy by a search within that of vx."""
    Fx, Fy = prescribed
    x, vy = creepage

    def lateral(x: float) -> float:
        """vy for the prescribed Fy, at a vx."""
        if Fy is None:
            return vy
        return _root(lambda y: float(at(x, y)[1]) - Fy, unit)

    if Fx is not None:
        x = _root(lambda x: float(at(x, lateral(x))[0]) - Fx, unit)
    return x, lateral(x)


def _both_at_once(
    at: Callable[[float, float], np.ndarray], forces: np.ndarray, unit: float, carried: float
) -> np.ndarray | None:
    """vx and vy of two prescribed forces by Powell's hybrid method, which may fail near
    saturation.
    """
    from scipy.optimize import root

    def excess(scaled: np.ndarray) -> np.ndarray:
        return np.asarray((at(*(unit * scaled)) - forces) / carried)

    hybrid = root(excess, np.zeros(2), tol=1e-13, options=HYBRID)
    if not np.all(np.abs(hybrid.fun) < 1e-11):
        return None
    return np.asarray(unit * hybrid.x)


def _root(excess: Callable[[float], float], unit: float) -> float:
    """Root of a function that falls from positive to negative, sought from ``[-unit, unit]``
    outwards.

    Forces fall with their creepages from one limit of friction to the other, so that there is a
    root whatever the spin. One direction inside the other is slower than Newton's method in both,
    but it cannot get lost where slip sets in or the force is nearly saturated.
    """
    from scipy.optimize import brentq

    ends = [-unit, unit]
    for i, sign in enumerate((-1, 1)):
        while sign * excess(ends[i]) > 0:
            ends[i] *= 4
            if abs(ends[i]) > FARTHEST * unit:
                raise NotConverged(
                    "no creepage found for the prescribed force", abs(excess(ends[i]))
                )
    return float(brentq(excess, *ends, xtol=1e-15 * unit, rtol=1e-14, maxiter=500))
