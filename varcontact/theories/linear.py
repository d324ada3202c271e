"""Kalker's linear theory: no slip at all, forces proportional to the creepages
(paper, section 2.1.1).

Source: J. J. Kalker, On the Rolling Contact of Two Elastic Bodies in the
Presence of Dry Friction, thesis, Delft 1967.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from varcontact.checks import (
    LARGE,
    SMALL,
    array,
    broadcasting,
    number,
    numbers,
    positive,
    positives,
    wrong_shape,
)
from varcontact.errors import SceneError
from varcontact.reference.creepage_coefficients import CreepageCoefficients, no_slip_coefficients


@dataclass(frozen=True, eq=False)
class Resultants:
    """Total tangential force and moment on body 1.

    Attributes
    ----------
    force : ndarray, shape (..., 2)
        Fx and Fy (116).
    moment : ndarray, shape (...)
        Mz about the contact's centre (117).
    """

    force: np.ndarray
    moment: np.ndarray


def creepage_triples(value: Any) -> np.ndarray:
    """Creepages (..., 3), checked: vx, vy and spin."""
    result = numbers("creepages", value)
    if result.ndim == 0 or result.shape[-1] != 3:
        raise wrong_shape("creepages", result.shape, "an array (..., 3) of vx, vy, spin")
    return result


def creepage_triple(value: Any) -> np.ndarray:
    """One creepage (3,), checked."""
    return array("creepage", value, shape=(3,), meant="the three numbers vx, vy, spin")


Forces = tuple[Any, Any, Any]
"""Fx, Fy and Mz."""


@dataclass(frozen=True, eq=False)
class Contact:
    """Checked arguments of a theory: arrays or floats, which broadcast."""

    a: Any
    b: Any
    G: Any
    nu: Any
    limit: Any
    vx: Any
    vy: Any
    spin: Any
    slope: Any
    table: Any


def positive_or_array(field: str, value: Any) -> Any:
    """A positive number as a float, or several as an array; single calls are frequent."""
    if type(value) is float and SMALL <= value <= LARGE:
        return value
    return float_or_array(positives(field, value))


def float_or_array(value: np.ndarray) -> Any:
    return value if value.ndim else float(value)


def checked_contact(
    a: Any, b: Any, G: Any, friction_force: Any, creepages: Any, table: Any = None, nu: Any = None
) -> Contact:
    """Arguments of a theory, checked, with the coefficients or the Poisson's ratio that it
    needs.
    """
    triples = creepage_triples(creepages)
    vx, vy, spin = triples.tolist() if triples.ndim == 1 else np.moveaxis(triples, -1, 0)
    a = positive_or_array("a", a)
    b = positive_or_array("b", b)
    G = positive_or_array("G", G)
    limit = positive_or_array("friction_force", friction_force)
    others = {"nu": nu} if table is None else {"coefficients": table.C11}
    broadcasting({"a": a, "b": b, "G": G, "friction_force": limit, "vx": vx, **others})
    return Contact(a, b, G, nu, limit, vx, vy, spin, 1.0, table)


def coefficients_of(ratio: Any, nu: Any, slope: Any) -> CreepageCoefficients:
    """Creepage coefficients of a ratio of axes, multiplied by a slope."""
    table = no_slip_coefficients(ratio, nu)
    if isinstance(slope, float) and slope == 1:
        return table
    return CreepageCoefficients(
        slope * table.C11, slope * table.C22, slope * table.C23, slope * table.C33
    )


def as_resultants(forces: Forces) -> Resultants:
    """Forces and moment as arrays."""
    Fx, Fy, Mz = forces
    return Resultants(np.stack(np.broadcast_arrays(Fx, Fy), axis=-1), np.asarray(Mz))


def creepage_or_force(
    creepage: str, given: float | None, force: str, prescribed: float | None
) -> tuple[float, float | None]:
    """A creepage, 0 if not given, and the force prescribed in its place, checked by their names."""
    if prescribed is None:
        return number(creepage, 0.0 if given is None else given), None
    if given is not None:
        message = f"{creepage} and {force} are both given: give one of them"
        raise SceneError(
            f"{creepage}, {force}", (given, prescribed), "at most one of the two", message=message
        )
    return 0.0, number(force, prescribed)


def linear_resultants(c: Contact) -> Forces:
    """Fx, Fy and Mz of `linear_forces`."""
    ab = c.a * c.b
    table = c.table
    unit = -c.G * ab
    by_spin = ab**0.5 * table.C23
    Fx = (unit * table.C11) * c.vx
    Fy = (unit * table.C22) * c.vy + (unit * by_spin) * c.spin
    Mz = (-unit * by_spin) * c.vy + (unit * ab * table.C33) * c.spin
    return Fx, Fy, Mz


def linear_forces(
    a: Any, b: Any, G: Any, creepages: Any, coefficients: CreepageCoefficients
) -> Resultants:
    """Forces and moment of the linear theory, (118)-(119). Friction has no part in it.

    Parameters
    ----------
    a, b, G : float or array_like
        Semi-axes along the rolling direction and across it [length], and
        combined modulus of rigidity [force/area].
    creepages : array_like, shape (..., 3)
        vx, vy [-] and spin [1/length]; the other arguments broadcast with its
        leading shape.
    coefficients : CreepageCoefficients
        From `creepage_coefficients`.

    Returns
    -------
    Resultants
        Force (..., 2) and moment (...) on body 1.

    Raises
    ------
    SceneError
        If a, b or G is not positive and finite, or creepages is no finite array
        (..., 3).

    Notes
    -----
    ``Fx = -G ab C11 vx``, ``Fy = -G ab C22 vy - G (ab)^1.5 C23 spin``,
    ``Mz = G (ab)^1.5 C23 vy - G (ab)^2 C33 spin`` (as C32 = -C23).

    Examples
    --------
    >>> from varcontact.reference import creepage_coefficients
    >>> table = creepage_coefficients(1.0, 1.0, 0.0)
    >>> result = linear_forces(1.0, 1.0, 1.0, (0.0, 0.001, 0.0), table)
    >>> print(f"{result.force[1]:.5f} {result.moment:.5f}")
    -0.00340 0.00133
    """
    return as_resultants(linear_resultants(checked_contact(a, b, G, 1.0, creepages, coefficients)))


def linear_creepage(
    a: float,
    b: float,
    G: float,
    coefficients: CreepageCoefficients,
    *,
    vx: float | None = None,
    vy: float | None = None,
    spin: float | None = None,
    Fx: float | None = None,
    Fy: float | None = None,
    Mz: float | None = None,
) -> np.ndarray:
    """Creepages of the linear theory for forces or a moment prescribed in place of some of them.

    Parameters
    ----------
    a, b, G, coefficients
        As for `linear_forces`.
    vx, vy, spin : float, optional
        Creepages that are given; 0 where neither the creepage nor its force is
        given.
    Fx, Fy, Mz : float, optional
        Force on body 1 in place of vx, in place of vy, and moment in place of
        spin.

    Returns
    -------
    ndarray, shape (3,)
        vx, vy, spin.

    Raises
    ------
    SceneError
        If a creepage and its force are both given, or a number is not finite
        (or, of a, b, G, not positive).

    Examples
    --------
    >>> from varcontact.reference import creepage_coefficients
    >>> table = creepage_coefficients(1.0, 1.0, 0.0)
    >>> creepage = linear_creepage(1.0, 1.0, 1.0, table, Fx=-0.001 * table.C11, Fy=0.0, spin=0.001)
    >>> print(" ".join(f"{value:.6f}" for value in creepage))
    0.001000 -0.000393 0.001000
    """
    size = math.sqrt(positive("a", a) * positive("b", b))
    vx, Fx = creepage_or_force("vx", vx, "Fx", Fx)
    vy, Fy = creepage_or_force("vy", vy, "Fy", Fy)
    spin, Mz = creepage_or_force("spin", spin, "Mz", Mz)
    prescribed = (Fx, Fy, Mz)
    # F/(G ab) = -matrix @ (vx, vy, size * spin), and the moment divided by size too
    c = coefficients
    matrix = np.array([[c.C11, 0.0, 0.0], [0.0, c.C22, c.C23], [0.0, -c.C23, c.C33]])
    units = np.array([1.0, 1.0, size])
    creepage = np.array([vx, vy, spin]) * units
    unknown = [i for i, value in enumerate(prescribed) if value is not None]
    force = np.array([0.0 if value is None else value for value in prescribed])
    force = force / (positive("G", G) * size**2 * units)
    right_side = (-force - matrix @ creepage)[unknown]
    creepage[unknown] = np.linalg.solve(matrix[np.ix_(unknown, unknown)], right_side)
    return creepage / units
