"""Residual stresses in equilibrium with nothing, the same in all cross-sections.

By Airy's function F and Prandtl's psi, with tensor products of cubic B-splines:

    r1 = (F_zz - F_yy)/2,   r5 = -F_yz,   r3 = psi_z,   r4 = -psi_y;   r2 (rho_xx) is free.

At the surface F = F_z = psi = 0: no tractions. F, its gradient and psi are zero at the other
edges of the section, so the stress ends there: equilibrium holds to infinity.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from varcontact.plasticity.passage import Passage

DEGREE = 3
GROWTH = 1.4
"""Power of the intervals beside the contact."""
DEPTH_GROWTH = 1.6
"""Power of the intervals below it."""
FREE = [0, 2, 3, 4]
"""The components that splines describe."""


@dataclass(frozen=True, eq=False)
class ResidualSpace:
    """Splines of F and psi in a section.

    Attributes
    ----------
    y, depth : ndarray
        Ends of the intervals, divided by the half-width.
    symmetric : bool
        F even and psi odd in y.
    """

    y: np.ndarray
    depth: np.ndarray
    symmetric: bool

    @classmethod
    def around(cls, passage: Passage, inside: int, outside: int, down: int) -> ResidualSpace:
        """So many intervals across the contact, beside it on either side, and in depth."""
        left, right = passage.loaded[2:]
        outermost = 0.98 * passage.y[-1]
        beyond = outermost - right
        first = left - beyond
        steps = (np.arange(1, outside + 1) / outside) ** GROWTH
        middle = np.linspace(left, right, inside + 1)
        y = np.concatenate([(left - beyond * steps)[::-1], middle, right + beyond * steps])
        y[0] = first
        depth = 0.98 * passage.depth[-1] * np.linspace(0, 1, down + 1) ** DEPTH_GROWTH
        return cls(y, depth, passage.symmetric)

    def matrices(self, y: np.ndarray, depth: np.ndarray) -> tuple[np.ndarray, ...]:
        """Splines and their derivatives (3, places, splines): of F along y and z, of psi along y
        and z.
        """
        airy_y = _splines(y, self.y, (2, 2))
        prandtl_y = _splines(y, self.y, (1, 1))
        if self.symmetric:
            airy_y = _folded(airy_y, 1.0)
            prandtl_y = _folded(prandtl_y, -1.0)
        airy_z = _splines(depth, self.depth, (2, 2))
        prandtl_z = _splines(depth, self.depth, (1, 1))
        return airy_y, airy_z, prandtl_y, prandtl_z

    def rows(self, y: np.ndarray, depth: np.ndarray) -> np.ndarray:
        """r1, r3, r4, r5 (points, 4, coefficients) at points."""
        airy_y, airy_z, prandtl_y, prandtl_z = self.matrices(y, depth)
        r1 = (_products(airy_y[0], airy_z[2]) - _products(airy_y[2], airy_z[0])) / 2
        r5 = -_products(airy_y[1], airy_z[1])
        r3 = _products(prandtl_y[0], prandtl_z[1])
        r4 = -_products(prandtl_y[1], prandtl_z[0])
        airy = r1.shape[1]
        rows = np.zeros((len(y), 4, airy + r3.shape[1]))
        rows[:, 0, :airy] = r1
        rows[:, 3, :airy] = r5
        rows[:, 1, airy:] = r3
        rows[:, 2, airy:] = r4
        return rows

    def field(self, coefficients: np.ndarray, passage: Passage) -> np.ndarray:
        """The residual stress (nz, ny, 5) without its second component, by the yield stress."""
        yy, zz, yz, xy, xz = self.components(coefficients, passage)
        field = np.stack([(yy - zz) / 2, 0 * yy, xy, xz, yz], axis=-1)
        return field / passage.strength[:, None, None]

    def components(self, coefficients: np.ndarray, passage: Passage) -> np.ndarray:
        """rho_yy, rho_zz, rho_yz, rho_xy and rho_xz (5, nz, ny), by the least yield stress."""
        airy_y, airy_z, prandtl_y, prandtl_z = self.matrices(passage.y, passage.depth)
        count = airy_y.shape[2] * airy_z.shape[2]
        airy = coefficients[:count].reshape(airy_y.shape[2], -1)
        prandtl = coefficients[count:].reshape(prandtl_y.shape[2], -1)
        return np.array(
            [
                _on(airy, airy_y[0], airy_z[2]),
                _on(airy, airy_y[2], airy_z[0]),
                -_on(airy, airy_y[1], airy_z[1]),
                _on(prandtl, prandtl_y[0], prandtl_z[1]),
                -_on(prandtl, prandtl_y[1], prandtl_z[0]),
            ]
        )

    def tensor(self, coefficients: np.ndarray, axial: np.ndarray, passage: Passage) -> np.ndarray:
        """The residual stress (3, 3, nz, ny), by the least yield stress, with its second coordinate
        `axial` (nz, ny), by the yield stress.
        """
        yy, zz, yz, xy, xz = self.components(coefficients, passage)
        xx = np.sqrt(3) * axial * passage.strength[:, None] + (yy + zz) / 2
        return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])


def _products(across: np.ndarray, down: np.ndarray) -> np.ndarray:
    """Tensor products of splines at points."""
    return (across[:, :, None] * down[:, None, :]).reshape(len(across), -1)


def _on(coefficients: np.ndarray, across: np.ndarray, down: np.ndarray) -> np.ndarray:
    """A tensor product on a lattice (nz, ny)."""
    return down @ coefficients.T @ across.T


def _splines(places: np.ndarray, ends: np.ndarray, dropped: tuple[int, int]) -> np.ndarray:
    """Values and two derivatives (3, places, splines), without the first and last splines; zero
    outside.
    """
    from scipy.interpolate import BSpline

    knots = np.concatenate([[ends[0]] * DEGREE, ends, [ends[-1]] * DEGREE])
    count = len(knots) - DEGREE - 1
    spline = BSpline(knots, np.eye(count), DEGREE, extrapolate=False)
    each = [spline(places), spline.derivative(1)(places), spline.derivative(2)(places)]
    return np.nan_to_num(np.array(each))[:, :, dropped[0] : count - dropped[1]]


def _folded(splines: np.ndarray, sign: float) -> np.ndarray:
    """Even (1) or odd (-1) sums of splines that are each other's mirror images."""
    count = splines.shape[2]
    half = count // 2
    folded = splines[:, :, :half] + sign * splines[:, :, : count - half - 1 : -1]
    if count % 2 and sign > 0:
        folded = np.concatenate([folded, splines[:, :, half : half + 1]], axis=2)
    return folded
