"""Hertz's contact of two paraboloids in closed form (paper, section 2.1).

Source: H. Hertz, Über die Berührung fester elastischer Körper, J. reine angew.
Math. 92 (1882) 156-171.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache
from typing import Any, Protocol

import numpy as np

from varcontact.checks import elastic, exactly_one, positive
from varcontact.errors import SceneError

LEAST_RATIO = 1e-100
"""Least axial ratio of a contact ellipse."""

LEAST_SHARE = 1e-14
"""Least share of the force on an element that counts as touched; less may be rounding."""

WHOLE = 1e-12
"""Part of a covered element that may be missing due to rounding."""


LANDEN_STEPS = 14
"""Landen's steps: each squares the difference of two means from their ratio, and 14 make them equal
to rounding from ratios of 1e-300 on."""


class CombinedConstants(Protocol):
    """Constants of two bodies in closed forms (58)-(60)."""

    @property
    def combined_G(self) -> float: ...
    @property
    def combined_nu(self) -> float: ...
    @property
    def K(self) -> float: ...


@dataclass(frozen=True)
class EllipticIntegrals:
    """Kalker's complete elliptic integrals (95)-(99) at one axial ratio m' (Table 1)."""

    B: float  # [-]
    C: float  # [-]
    D: float  # [-]
    E: float  # [-]
    K: float  # [-]


def elliptic_integrals(axial_ratio: float) -> EllipticIntegrals:
    """Complete elliptic integrals B, C, D, E, K of the axial ratio, (95)-(99).

    Parameters
    ----------
    axial_ratio : float
        m' = (minor / major semi-axis), in (0, 1]; the modulus is
        ``m = sqrt(1 - m'^2)``.

    Returns
    -------
    EllipticIntegrals
        Each to rounding: Bulirsch's terms are all positive, so nothing cancels
        at m' -> 0.

    Raises
    ------
    SceneError
        If it is not in that range.

    Examples
    --------
    >>> integrals = elliptic_integrals(0.5)
    >>> print(f"{integrals.B:.4f} {integrals.C:.4f} {integrals.D:.4f}")
    0.8959 0.4863 1.2606
    >>> print(f"{integrals.E:.4f} {integrals.K:.4f}")
    1.2111 2.1565
    """
    axial_ratio = positive("axial_ratio", axial_ratio)
    if axial_ratio > 1:
        raise SceneError("axial_ratio", axial_ratio, "in (0, 1]")
    return _elliptic_integrals(axial_ratio)


@lru_cache(maxsize=64)
def _elliptic_integrals(axial_ratio: float) -> EllipticIntegrals:
    on_cos = np.array([1.0, 0.0, 1.0, 1.0])
    on_sin = np.array([0.0, 1.0, axial_ratio**2, 1.0])
    B, D, E, K = complete_integral(axial_ratio, on_cos, on_sin).tolist()
    m2 = (1 - axial_ratio) * (1 + axial_ratio)
    if m2 > 0.1:
        C = (D - B) / m2
    else:  # there D - B cancels, and the trapezoidal rule is exact to rounding
        t = (np.arange(32) + 0.5) * math.pi / 64
        C = float(
            np.sum(np.sin(t) ** 2 * np.cos(t) ** 2 / (1 - m2 * np.sin(t) ** 2) ** 1.5)
            * math.pi
            / 64
        )
    return EllipticIntegrals(B, C, D, E, K)


def complete_integral(
    axial_ratio: np.ndarray | float, on_cos: np.ndarray | float, on_sin: np.ndarray | float
) -> Any:
    """``int_0^(pi/2) (a cos^2 t + b sin^2 t) / (cos^2 t + m'^2 sin^2 t)^(1/2) dt``, a and b those
    on cos and on sin, by Landen's transformation.

    R. Bulirsch, Numer. Math. 13 (1969) 305-315: cel(m', 1, a, b).
    """
    a: Any = on_cos
    b: Any = on_sin
    q: Any = axial_ratio
    e = q
    mean = 1.0
    p = 1.0
    for _ in range(LANDEN_STEPS):
        g = e / p
        last = a
        a = last + b / p
        b = 2 * (b + last * g)
        p = p + g
        mean = mean + q
        q = 2 * np.sqrt(e)
        e = q * mean
    return np.pi / 2 * (b + a * mean) / (mean * (mean + p))


@dataclass(frozen=True)
class HertzContact:
    """One Hertzian contact.

    Attributes
    ----------
    a, b : float
        Semi-axes of the ellipse along x and y [length].
    approach : float
        [length]
    force : float
        Normal force [force].
    peak_pressure : float
        In the middle [force/area].
    Rx, Ry : float
        Combined radii of curvature along x and y [length].
    """

    a: float
    b: float
    approach: float
    force: float
    peak_pressure: float
    Rx: float
    Ry: float

    def pressure(self, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        """Semi-ellipsoidal pressure (88) [force/area] at points `x`, `y` [length], zero outside the
        ellipse.
        """
        inside = 1 - (np.asarray(x) / self.a) ** 2 - (np.asarray(y) / self.b) ** 2
        return self.peak_pressure * np.sqrt(np.maximum(inside, 0.0))

    def mean_pressure(self, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        """Mean of the pressure over each rectangle between lines.

        Zero where less than 1e-14 of the force falls on a rectangle. Together
        they carry the force to rounding.

        Parameters
        ----------
        x, y : ndarray, shapes (nx + 1,) and (ny + 1,)
            Lines, rising [length].

        Returns
        -------
        ndarray, shape (ny, nx)
            [force/area]

        Notes
        -----
        With X = x/a, Y = y/b and R^2 = 1 - X^2 - Y^2 (0 outside the circle), the volume under the
        pressure between the axes and a corner is ``2XYR + X(3 - X^2) atan(Y/R) + Y(3 - Y^2)
        atan(X/R) - 2 atan(XY/R)`` times p_max a b/6. Outside the circle this is what two caps leave
        of a quarter. In line contact the area is ``X R + asin X`` times p_max a/2.

        Examples
        --------
        >>> from varcontact import Bodies
        >>> contact = hertz(1.0, 1.0, Bodies(G=1.0, nu=0.3), force=1e-3)
        >>> lines = np.linspace(-0.2, 0.2, 5)
        >>> print(f"{contact.mean_pressure(lines, lines).sum() * 0.1**2:.15f}")
        0.001000000000000
        """
        # elements are differences of corners: digits that the platform has beyond double are
        # welcome
        x = np.asarray(x, dtype=np.longdouble)
        y = np.asarray(y, dtype=np.longdouble)
        X = np.clip(x / self.a, -1.0, 1.0)
        Y = np.clip(y / self.b, -1.0, 1.0)
        if math.isinf(self.b):
            share = np.diff(X * np.sqrt(1 - X**2) + np.arcsin(X))[None, :] / math.pi
            total = self.force / np.diff(x)[None, :]
        else:
            X = X[None, :]
            Y = Y[:, None]
            R = np.sqrt(np.maximum(1 - X**2 - Y**2, 0.0))
            caps = X * (3 - X**2) * np.arctan2(Y, R) + Y * (3 - Y**2) * np.arctan2(X, R)
            volume = np.asarray(2 * X * Y * R + caps - 2 * np.arctan2(X * Y, R)) / (4 * math.pi)
            share = np.diff(np.diff(volume, axis=0), axis=1)
            total = self.force / (np.diff(x)[None, :] * np.diff(y)[:, None])
        return np.where(share > LEAST_SHARE, share * total, 0.0).astype(float)

    def covered(self, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        """Part of each rectangle between lines that the contact covers.

        Parameters
        ----------
        x, y
            As of `mean_pressure`.

        Returns
        -------
        ndarray, shape (ny, nx)
            Between 0 and 1.

        Notes
        -----
        With X = x/a, Y = y/b, the area of the ellipse between the axes and a corner is X Y within
        it, and outside what two half caps ``(acos X - X sqrt(1 - X^2))/2`` leave of a quarter,
        pi/4.

        Examples
        --------
        >>> from varcontact import Bodies
        >>> contact = hertz_ellipse(2.0, 1.0, Bodies(G=1.0, nu=0.3), force=1e-3)
        >>> contact.covered(np.linspace(-2.0, 2.0, 3), np.linspace(-1.0, 1.0, 3)) * 4 / np.pi
        array([[1., 1.],
               [1., 1.]])
        """
        x = np.asarray(x, dtype=float)
        y = np.asarray(y, dtype=float)
        X = np.clip(x / self.a, -1.0, 1.0)
        Y = np.clip(y / self.b, -1.0, 1.0)
        if math.isinf(self.b):
            part = np.diff(X)[None, :] * self.a / np.diff(x)[None, :]
            return np.where(part > 1 - WHOLE, 1.0, part)
        X = X[None, :]
        Y = Y[:, None]
        along = np.arccos(np.abs(X)) - np.abs(X) * np.sqrt(1 - X**2)
        across = np.arccos(np.abs(Y)) - np.abs(Y) * np.sqrt(1 - Y**2)
        beyond = np.sign(X) * np.sign(Y) * (math.pi / 4 - along / 2 - across / 2)
        corners = np.where(X**2 + Y**2 <= 1, X * Y, beyond)
        area = np.diff(np.diff(corners, axis=0), axis=1) * self.a * self.b
        part = np.maximum(area / (np.diff(x)[None, :] * np.diff(y)[:, None]), 0.0)
        return np.where(part > 1 - WHOLE, 1.0, part)

    def on_elements(self, grid: Any) -> np.ndarray:
        """Pressure (ny, nx) [force/area] on elements of an explicit `grid`: at centres, or means,
        by `Grid.edge`.
        """
        if grid.edge != "centres":
            return self.mean_pressure(*grid.lines)
        return self.pressure(grid.x[None, :], grid.y[:, None])


def hertz(
    Rx: float,
    Ry: float,
    bodies: CombinedConstants,
    *,
    force: float | None = None,
    approach: float | None = None,
) -> HertzContact:
    """Hertz's solution for the undeformed distance ``x^2/(2 Rx) + y^2/(2 Ry)``.

    Parameters
    ----------
    Rx, Ry : float
        Combined radii of curvature [length].
    bodies : Bodies
        Elastic constants; friction and unlikeness (K) have no part in Hertz's
        theory.
    force, approach : float
        Exactly one of the two: normal force, or approach of the bodies
        [length].

    Returns
    -------
    HertzContact

    Raises
    ------
    SceneError
        If a length is not positive and finite, or not exactly one of force and
        approach is given.

    Notes
    -----
    With m' = S/L (minor over major semi-axis), (93) and (94) give the equation for the axial ratio
    ``larger / smaller curvature = B / (m'^2 D)``, and (104), (92) the size and the approach. The
    equation is solved in log m', for curvature ratios far beyond 1e-8..1e8.

    Examples
    --------
    A ball on a flat: a = sqrt(R d).

    >>> from varcontact import Bodies
    >>> contact = hertz(0.5, 0.5, Bodies(G=80e9, nu=0.25), approach=2e-6)
    >>> print(f"{contact.a:.6f} {contact.force:.4f}")
    0.001000 284.4444
    """
    Rx = positive("Rx", Rx)
    Ry = positive("Ry", Ry)
    _check_slender("Rx", Rx, "Ry", Ry, 1 / LEAST_RATIO**1.5)
    ratio = _axial_ratio(max(Rx, Ry) / min(Rx, Ry))
    integrals = elliptic_integrals(ratio)
    curvature = 0.5 / Rx + 0.5 / Ry
    exactly_one(force=force, approach=approach)
    n = _normal_constant(bodies)
    if force is not None:  # (104), A + B = n N E m' / S^3
        minor = (n * positive("force", force) * integrals.E * ratio / curvature) ** (1 / 3)
    else:  # with (92), q = n N K m' / S
        minor = math.sqrt(positive("approach", approach) * integrals.E / (integrals.K * curvature))
    by_force = n * integrals.K * ratio / minor
    if Rx <= Ry:
        return _contact(minor, minor / ratio, Rx, Ry, by_force, force, approach)
    return _contact(minor / ratio, minor, Rx, Ry, by_force, force, approach)


def semi_axes(
    Rx: np.ndarray, Ry: np.ndarray, G: np.ndarray, nu: np.ndarray, force: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Semi-axes along x and y of many contacts at once, as of `hertz`, with combined constants G
    and nu.
    """
    ratio = _axial_ratios(np.abs(np.log(Rx / Ry)))
    E = complete_integral(ratio, 1.0, ratio**2)
    curvature = 0.5 / Rx + 0.5 / Ry
    minor = (3 * (1 - nu) / (2 * math.pi * G) * force * E * ratio / curvature) ** (1 / 3)
    major = minor / ratio
    return np.where(Rx <= Ry, minor, major), np.where(Rx <= Ry, major, minor)


def _axial_ratios(log_radii: np.ndarray | float) -> np.ndarray | float:
    """m' from logarithms of the ratio of the larger to the smaller radius of curvature, by (93) /
    (94).
    """
    log_ratio = -0.5 * log_radii
    change = 1.0
    # contracts by a third or more
    while change > 4 * np.finfo(float).eps * (1 + np.max(log_radii)):
        ratio = np.exp(log_ratio)
        B = complete_integral(ratio, 1.0, 0.0)
        D = complete_integral(ratio, 0.0, 1.0)
        new = (np.log(B / D) - log_radii) / 2
        change = np.abs(new - log_ratio).max()
        log_ratio = np.minimum(new, 0.0)
    return np.exp(log_ratio)


@lru_cache(maxsize=64)
def _axial_ratio(radius_ratio: float) -> float:
    return float(_axial_ratios(math.log(radius_ratio)))


def approaches(
    a: np.ndarray, b: np.ndarray, G: np.ndarray, nu: np.ndarray, force: np.ndarray
) -> np.ndarray:
    """Approaches of many contacts at once (92), by their semi-axes."""
    major = np.maximum(a, b)
    K = complete_integral(np.minimum(a, b) / major, 1.0, 1.0)
    return np.asarray(3 * (1 - nu) / (2 * math.pi * G) * K / major * force)


def hertz_ellipse(
    a: float,
    b: float,
    bodies: CombinedConstants,
    *,
    force: float | None = None,
    approach: float | None = None,
) -> HertzContact:
    """The Hertzian contact whose semi-axes are given: the radii follow, see `hertz`.

    Parameters
    ----------
    a, b : float
        Semi-axes along x and y [length].
    bodies : Bodies
    force, approach : float
        Exactly one: the compressive force, or the approach [length].

    Returns
    -------
    HertzContact

    Raises
    ------
    SceneError
        If a value is not positive, or not exactly one of force and approach is
        given.

    Examples
    --------
    >>> from varcontact import Bodies
    >>> steel = Bodies(G=82e9, nu=0.28)
    >>> contact = hertz_ellipse(6e-3, 3e-3, steel, force=1e5)
    >>> again = hertz(contact.Rx, contact.Ry, steel, force=1e5)
    >>> print(f"{again.a:.6f} {again.b:.6f}")
    0.006000 0.003000
    """
    a = positive("a", a)
    b = positive("b", b)
    _check_slender("a", a, "b", b, 1 / LEAST_RATIO)
    integrals = elliptic_integrals(min(a, b) / max(a, b))
    n = _normal_constant(bodies)
    exactly_one(force=force, approach=approach)
    by_force = n * integrals.K / max(a, b)
    force = positive("approach", approach) / by_force if force is None else positive("force", force)
    scale = 2 * n * force / (a * b * min(a, b))
    smaller = 1 / (scale * integrals.B)
    larger = 1 / (scale * (min(a, b) / max(a, b)) ** 2 * integrals.D)
    if a <= b:
        return _contact(a, b, smaller, larger, by_force, force, approach)
    return _contact(a, b, larger, smaller, by_force, force, approach)


def _check_slender(x_name: str, x: float, y_name: str, y: float, most: float) -> None:
    """Refuse radii or semi-axes with a ratio above `most`: of contacts so slender powers of the
    axial ratio underflow.
    """
    if max(x, y) > most * min(x, y):
        raise SceneError(f"{x_name}, {y_name}", (x, y), f"at most {most:g} times one another")


def _normal_constant(bodies: CombinedConstants) -> float:
    """3 (1 - nu) / (2 pi G), the constant of (92)-(94)."""
    elastic(bodies)
    return 3 * (1 - bodies.combined_nu) / (2 * math.pi * bodies.combined_G)


def _contact(
    a: float, b: float, Rx: float, Ry: float, by_force: float, force: Any, approach: Any
) -> HertzContact:
    """Complete a contact by (92) and (89) from the ellipse and the force or the approach."""
    force = float(approach) / by_force if force is None else float(force)
    approach = by_force * force if approach is None else float(approach)
    peak_pressure = 1.5 * force / (math.pi * a * b)
    return HertzContact(a, b, approach, force, peak_pressure, Rx, Ry)
