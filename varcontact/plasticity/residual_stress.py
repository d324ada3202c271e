"""Residual stresses in equilibrium with nothing, the same in all cross-sections.

By Airy's function F and Prandtl's psi, with tensor products of cubic B-splines:

    r1 = (F_zz - F_yy)/2,   r5 = -F_yz,   r3 = psi_z,   r4 = -psi_y;   r2 (rho_xx) is free.

At the surface F = F_z = psi = 0: no tractions. F, its gradient and psi are zero at the other
edges of the section, so the stress ends there: equilibrium holds to infinity.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from varcontact.plasticity.passage import Passage

DEGREE = 3
GROWTH = 1.4
"""Exponent of the distance from the contact of the ends of intervals beside it."""
DEPTH_GROWTH = 1.6
"""Exponent of the depth of the ends of intervals as a function of their number."""
LEBESGUE = 2.0
"""Bound on quadratic interpolation between values of at most 1, the middle one anywhere between .3
and .7 of the length."""
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
        """Space with about these numbers of intervals across the contact, beside it on either side,
        and in depth; they end where cells of the passage do.
        """
        left, right = passage.loaded[2:]
        outermost = 0.98 * passage.y[-1]
        beyond = outermost - right
        first = left - beyond
        steps = (np.arange(1, outside + 1) / outside) ** GROWTH
        middle = np.linspace(left, right, inside + 1)
        y = np.concatenate([(left - beyond * steps)[::-1], middle, right + beyond * steps])
        y[0] = first
        depth = 0.98 * passage.depth[-1] * np.linspace(0, 1, down + 1) ** DEPTH_GROWTH
        # intervals end where cells do: splines are polynomials in a cell
        ends_y = cell_ends(passage.y)
        if passage.symmetric:
            ends_y = np.union1d(-ends_y[ends_y > 0], ends_y[ends_y >= 0])
        return cls(
            _nearest(y, ends_y), _nearest(depth, cell_ends(passage.depth)), passage.symmetric
        )

    def matrices(self, y: np.ndarray, depth: np.ndarray) -> tuple[np.ndarray, ...]:
        """Splines and their derivatives (4, places, splines): of F along y and z, of psi along y
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
        """Residual stress (nz, ny, 5) without its second component, divided by the yield stress."""
        yy, zz, yz, xy, xz = self.components(coefficients, passage.y, passage.depth)
        field = np.stack([(yy - zz) / 2, 0 * yy, xy, xz, yz], axis=-1)
        return field / passage.strength[:, None, None]

    def components(self, coefficients: np.ndarray, y: np.ndarray, depth: np.ndarray) -> np.ndarray:
        """rho_yy, rho_zz, rho_yz, rho_xy and rho_xz (5, nz, ny), divided by the least yield
        stress.
        """
        airy_y, airy_z, prandtl_y, prandtl_z = self.matrices(y, depth)
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
        """Residual stress (3, 3, nz, ny), divided by the least yield stress; its second coordinate
        is `axial` (nz, ny), divided by the yield stress.
        """
        yy, zz, yz, xy, xz = self.components(coefficients, passage.y, passage.depth)
        xx = np.sqrt(3) * axial * passage.strength[:, None] + (yy + zz) / 2
        return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])

    def by_cell(
        self, coefficients: np.ndarray, axial: np.ndarray, passage: Passage
    ) -> CellResidual:
        """Residual stress as a polynomial in each cell of the passage."""
        free = np.zeros((*axial.shape, 5))
        free[..., 1] = axial * passage.strength[:, None]
        return CellResidual(passage.y, passage.depth, free, self, coefficients)


def cells(places: np.ndarray, even: bool = True) -> np.ndarray:
    """First samples of cells of two intervals, of equal length if `even`; a cell overlaps the
    previous one where they do not fit exactly.
    """
    steps = np.diff(places)
    last = len(places) - 3
    starts = []
    at = 0
    while at <= last + 1:
        start = min(at, last)
        if even and not math.isclose(steps[start], steps[start + 1], rel_tol=1e-2):
            start -= 1
        starts.append(start)
        at = max(start + 2, at + 1)
    return np.array(starts)


def cell_ends(places: np.ndarray) -> np.ndarray:
    """Places that are in the middle of no cell."""
    starts = cells(places, even=places[0] < 0)
    ends = np.setdiff1d(np.union1d(starts, starts + 2), starts + 1)
    return np.asarray(places[ends])


def _nearest(wanted: np.ndarray, places: np.ndarray) -> np.ndarray:
    return np.asarray(np.unique(places[np.abs(wanted[:, None] - places).argmin(axis=1)]))


def _products(across: np.ndarray, down: np.ndarray) -> np.ndarray:
    """Tensor products of splines at points."""
    return (across[:, :, None] * down[:, None, :]).reshape(len(across), -1)


def _on(coefficients: np.ndarray, across: np.ndarray, down: np.ndarray) -> np.ndarray:
    """A tensor product on a lattice (nz, ny)."""
    return down @ coefficients.T @ across.T


def _splines(places: np.ndarray, ends: np.ndarray, dropped: tuple[int, int]) -> np.ndarray:
    """Values and three derivatives (4, places, splines), without the first and last splines; zero
    outside.
    """
    from scipy.interpolate import BSpline

    knots = np.concatenate([[ends[0]] * DEGREE, ends, [ends[-1]] * DEGREE])
    count = len(knots) - DEGREE - 1
    spline = BSpline(knots, np.eye(count), DEGREE, extrapolate=False)
    each = [spline(places), *(spline.derivative(order)(places) for order in (1, 2, 3))]
    return np.nan_to_num(np.array(each))[:, :, dropped[0] : count - dropped[1]]


def _folded(splines: np.ndarray, sign: float) -> np.ndarray:
    """Even (1) or odd (-1) sums of splines that are each other's mirror images."""
    count = splines.shape[2]
    half = count // 2
    folded = splines[:, :, :half] + sign * splines[:, :, : count - half - 1 : -1]
    if count % 2 and sign > 0:
        folded = np.concatenate([folded, splines[:, :, half : half + 1]], axis=2)
    return folded


@dataclass(frozen=True, eq=False)
class CellResidual:
    """A residual stress that is a polynomial in each cell of a passage.

    Attributes
    ----------
    y, depth : ndarray
        Samples of the passage, divided by the half-width.
    free : ndarray, shape (nz, ny, 5)
        Coordinates at the samples, quadratic in a cell: what equilibrium leaves free.
    space : ResidualSpace or None
        Of the other coordinates.
    coefficients : ndarray
        Of its splines.
    """

    y: np.ndarray
    depth: np.ndarray
    free: np.ndarray
    space: ResidualSpace | None = None
    coefficients: np.ndarray | None = None

    @property
    def starts(self) -> tuple[np.ndarray, np.ndarray]:
        """First samples of the cells along y and z."""
        return cells(self.y), cells(self.depth, even=False)

    def at_samples(self) -> np.ndarray:
        """Coordinates (nz, ny, 5) at the samples."""
        found = self.free.copy()
        if self.space is not None and self.coefficients is not None:
            yy, zz, yz, xy, xz = self.space.components(self.coefficients, self.y, self.depth)
            found += np.stack([(yy - zz) / 2, 0 * yy, xy, xz, yz], axis=-1)
        return found

    def at(self, y: np.ndarray, depth: np.ndarray, cell: np.ndarray) -> np.ndarray:
        """Coordinates (n, 3 y, 3 z, 5) at places (n, 3) of boxes in cells (n, 2)."""
        numbers = cell[:, :, None] + np.arange(3)
        nodes = self.free[numbers[:, 1, None, :], numbers[:, 0, :, None]]
        across = _quadratic_weights(self.y[numbers[:, 0]], y)
        down = _quadratic_weights(self.depth[numbers[:, 1]], depth)
        found = np.einsum("nai,nbj,nijq->nabq", across, down, nodes)
        if self.space is None:
            return found
        airy, prandtl, (airy_y, airy_z, prandtl_y, prandtl_z) = self._splines(y, depth)
        zz = _on_boxes(airy, airy_y[0], airy_z[2])
        found[..., 0] += (zz - _on_boxes(airy, airy_y[2], airy_z[0])) / 2
        found[..., 4] -= _on_boxes(airy, airy_y[1], airy_z[1])
        found[..., 2] += _on_boxes(prandtl, prandtl_y[0], prandtl_z[1])
        found[..., 3] -= _on_boxes(prandtl, prandtl_y[1], prandtl_z[0])
        return found

    def third_derivatives(self, y: np.ndarray, depth: np.ndarray) -> np.ndarray:
        """Bounds (n, 3 axes, 5) in boxes with the places (n, 3)."""
        found = np.zeros((len(y), 3, 5))
        if self.space is None:
            return found
        airy, prandtl, (airy_y, airy_z, prandtl_y, prandtl_z) = self._splines(y, depth)
        along_y = {0: (airy, airy_y[3], airy_z[2]), 2: (prandtl, prandtl_y[3], prandtl_z[1])}
        along_z = {0: (airy, airy_y[2], airy_z[3]), 3: (prandtl, prandtl_y[1], prandtl_z[3])}
        factor = np.array([0.5, 1.0, 1.0, 1.0, 1.0])
        for axis, derivatives in ((1, along_y), (2, along_z)):
            for component, each in derivatives.items():
                # constant along the axis, at most quadratic along the other
                values = np.take(_on_boxes(*each), 1, axis=axis)
                largest = LEBESGUE * np.abs(values).max(axis=1)
                found[:, axis, component] = factor[component] * largest
        return found

    def _splines(
        self, y: np.ndarray, depth: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray, list[np.ndarray]]:
        """Coefficients of F and psi, and their splines (4, n, 3, splines) along y and z."""
        assert self.space is not None
        assert self.coefficients is not None
        each = [
            values.reshape(4, len(y), 3, -1)
            for values in self.space.matrices(y.ravel(), depth.ravel())
        ]
        count = each[0].shape[-1] * each[1].shape[-1]
        airy = self.coefficients[:count].reshape(each[0].shape[-1], -1)
        prandtl = self.coefficients[count:].reshape(each[2].shape[-1], -1)
        return airy, prandtl, each


def _quadratic_weights(nodes: np.ndarray, places: np.ndarray) -> np.ndarray:
    """Weights (n, 3 places, 3 nodes) of quadratic interpolation."""
    weights = np.ones((*places.shape, 3))
    for own in range(3):
        for other in range(3):
            if own != other:
                apart = nodes[:, own] - nodes[:, other]
                weights[:, :, own] *= (places - nodes[:, other, None]) / apart[:, None]
    return weights


def _on_boxes(coefficients: np.ndarray, across: np.ndarray, down: np.ndarray) -> np.ndarray:
    """A tensor product (n, 3 y, 3 z) at places of boxes."""
    return np.asarray(np.einsum("nay,nby->nab", across, down @ coefficients.T))
