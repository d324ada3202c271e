"""Elasticity written a second time, for the tests: nothing of the package's arithmetic is used
here.

Boussinesq and Cerruti over rectangles and strips in their textbook form, in extended precision
against the cancellation of that form; and Hertz's ellipse by Carlson's integrals.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.optimize import brentq
from scipy.special import elliprd, elliprf

from varcontact.scene.bodies import Bodies
from varcontact.scene.grid import Grid

Number = np.floating[Any]


@dataclass(frozen=True)
class Constants:
    """Combined elastic constants (58)-(60)."""

    G: float
    nu: float
    K: float

    @classmethod
    def of(cls, bodies: Bodies) -> "Constants":
        """Those of two bodies."""
        (G1, G2), (nu1, nu2) = bodies.pairs
        G = 2 / (1 / G1 + 1 / G2)
        nu = nu1 if nu1 == nu2 else G / 2 * (nu1 / G1 + nu2 / G2)
        return cls(G, nu, G / 4 * ((1 - 2 * nu1) / G1 - (1 - 2 * nu2) / G2))


def influence(
    grid: Grid,
    constants: Constants,
    sources: np.ndarray | None = None,
    *,
    ahead: float = 0.0,
    less: float | None = None,
    depth: float | None = None,
) -> np.ndarray:
    """Displacements at the centres by unit tractions on elements: x, y and z, one after the other,
    (3 n, 3 m).
    """
    nx, ny = grid.nx, grid.rows
    sources = np.arange(nx * ny) if sources is None else sources
    dx, dy = (np.longdouble(side) for side in grid.sides)
    x = np.arange(1 - nx, nx)[None, :] * dx
    y = np.arange(1 - ny, ny)[:, None] * dy

    def table(distance: float) -> np.ndarray:
        if grid.line:
            return _strips(
                x + np.longdouble(distance), dx, constants, np.longdouble(depth or 4 * nx * dx)
            )
        return _rectangles(x + np.longdouble(distance), y, dx, dy, constants)

    numbers = (table(ahead) - (0 if less is None else table(less))).astype(float)
    iy, ix = np.divmod(np.arange(nx * ny), nx)
    dense = numbers[:, :, iy[:, None] - iy[sources] + ny - 1, ix[:, None] - ix[sources] + nx - 1]
    return dense.transpose(0, 2, 1, 3).reshape(3 * nx * ny, 3 * sources.size)


def _rectangles(
    x: np.ndarray, y: np.ndarray, dx: Number, dy: Number, constants: Constants
) -> np.ndarray:
    """Influence numbers (3, 3, ...) of a rectangle at points from its centre."""
    nu, K = np.longdouble(constants.nu), np.longdouble(constants.K)
    xx, xy, xz, yy, yz, zz = (np.zeros(np.broadcast(x, y).shape, np.longdouble) for _ in range(6))
    for sx, sy in ((1, 1), (-1, 1), (1, -1), (-1, -1)):
        X, Y = np.broadcast_arrays(x + sx * dx / 2, y + sy * dy / 2)
        r, sign = np.hypot(X, Y), sx * sy
        with np.errstate(divide="ignore", invalid="ignore"):
            # x ln(y + r)
            by_y = np.where(X != 0, X * (np.arcsinh(Y / np.abs(X)) + np.log(np.abs(X))), 0)
            # y ln(x + r)
            by_x = np.where(Y != 0, Y * (np.arcsinh(X / np.abs(Y)) + np.log(np.abs(Y))), 0)
            log_r = np.where(r > 0, np.log(r), 0)
            xz -= sign * K * (Y * log_r + np.where(X != 0, X * np.arctan(Y / X), 0))
            yz -= sign * K * (X * log_r + np.where(Y != 0, Y * np.arctan(X / Y), 0))
        xx += sign * (by_x + (1 - nu) * by_y)
        yy += sign * (by_y + (1 - nu) * by_x)
        xy -= sign * nu * r
        zz += sign * (1 - nu) * (by_y + by_x)
    return np.array([[xx, xy, xz], [xy, yy, yz], [-xz, -yz, zz]]) / (
        np.longdouble(np.pi) * constants.G
    )


def _strips(x: np.ndarray, dx: Number, constants: Constants, depth: Number) -> np.ndarray:
    """Influence numbers (3, 3, ...) of a strip at points from its centre line; displacements count
    from a depth.
    """
    right, left = x + dx / 2, x - dx / 2

    def primitive(s: np.ndarray) -> np.ndarray:
        return np.where(s != 0, s * np.log(np.where(s != 0, np.abs(s), 1) / depth), 0) - s

    logarithm, sign = primitive(left) - primitive(right), np.abs(right) - np.abs(left)
    plane, coupled = (
        2 * (1 - np.longdouble(constants.nu)) * logarithm,
        np.longdouble(np.pi * constants.K) * sign,
    )
    zero = np.zeros_like(x)
    numbers = [[plane, zero, -coupled], [zero, 2 * logarithm, zero], [coupled, zero, plane]]
    return np.array(numbers) / (np.longdouble(np.pi) * constants.G)


@dataclass(frozen=True)
class Ellipse:
    """Hertz's contact: semi-axes, radii, force and approach; b and Ry are infinite in line
    contact.
    """

    a: float
    b: float
    Rx: float
    Ry: float
    force: float
    approach: float

    @property
    def peak(self) -> float:
        if np.isinf(self.b):
            return 2 * self.force / (np.pi * self.a)
        return 1.5 * self.force / (np.pi * self.a * self.b)


def hertz_by_radii(
    Rx: float,
    Ry: float,
    constants: Constants,
    *,
    force: float | None = None,
    approach: float | None = None,
) -> Ellipse:
    """The contact of paraboloids: one of force and approach is given."""

    def mismatch(log_k: float) -> float:
        k = np.exp(2 * log_k)
        return float(np.log(elliprd(0, k, 1) / elliprd(0, 1, k)) - np.log(Ry / Rx))

    k = float(np.exp(brentq(mismatch, -40, 40, xtol=1e-15, rtol=1e-14)))
    inner, compliance = elliprd(0, k**2, 1), (1 - constants.nu) / (np.pi * constants.G)
    if force is not None:
        a = (Rx * compliance * force * inner) ** (1 / 3)
    else:
        assert approach is not None
        a = np.sqrt(approach * Rx * inner / (1.5 * elliprf(0, 1, k**2)))
    return hertz_by_axes(a, k * a, constants, force=a**3 / (Rx * compliance * inner))


def hertz_by_axes(
    a: float,
    b: float,
    constants: Constants,
    *,
    force: float | None = None,
    approach: float | None = None,
) -> Ellipse:
    """The contact with semi-axes a, b: one of force and approach is given."""
    compliance, depth = (1 - constants.nu) / (np.pi * constants.G), float(elliprf(0, a**2, b**2))
    if force is None:
        assert approach is not None
        force = approach / (1.5 * compliance * depth)
    along_x, along_y = elliprd(0, b**2, a**2), elliprd(0, a**2, b**2)
    radii = 1 / (compliance * force * along_x), 1 / (compliance * force * along_y)
    return Ellipse(a, b, *radii, force, 1.5 * compliance * force * depth)


def hertz_line(
    R: float,
    constants: Constants,
    *,
    depth: float | None,
    force: float | None = None,
    approach: float | None = None,
) -> Ellipse:
    """The contact of cylinders, per unit length; the approach is open where no reference depth is
    given.
    """
    compliance = 2 * (1 - constants.nu) / (np.pi * constants.G)

    def half_width(force: float) -> float:
        return float(np.sqrt(2 * R * compliance * force))

    def sinks(force: float) -> float:
        return (
            np.nan
            if depth is None
            else compliance * force * (np.log(2 * depth / half_width(force)) + 0.5)
        )

    if force is None:
        assert depth is not None
        assert approach is not None
        most = np.log(depth**2 / (2 * R * compliance))  # a contact as wide as the depth
        force = float(
            np.exp(brentq(lambda log: sinks(np.exp(log)) - approach, most - 200, most, xtol=1e-14))
        )
    return Ellipse(half_width(force), np.inf, R, np.inf, force, sinks(force))
