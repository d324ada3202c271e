"""The slip of the continuum on parts of coarse elements."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from varcontact.discrete.subgrid import means
from varcontact.scene.grid import Cells, Grid
from varcontact.solving.defect_correction.field import Shape, reconstructed
from varcontact.solving.defect_correction.parts import Parts


@dataclass(frozen=True, eq=False)
class Sublattice:
    """Tractions on parts of elements, with their bound.

    In steady rolling, slip is that of the continuum, but for the tractions' constancy on each part: the derivative of
    displacement along x by each part in closed form, its mean over each part. What that misses near the contact's edge
    is known for the pressure, acting as a traction: in closed form for Hertz's, and from a finer lattice where it is
    solved for. It is added in proportion to the traction's ratio to the pressure. In rows that stick up to their
    trailing edge, in Hertz's contact, what is known there of tractions over the root of the distance takes its place.
    In a shift, slip is that at the centres of the parts.

    Attributes
    ----------
    parts : Parts
    coefficient : ndarray, shape (ny, nx)
        Of friction, on the elements, finite.
    """

    parts: Parts
    coefficient: np.ndarray

    @property
    def cells(self) -> Cells:
        """Parts of an element along y and x."""
        return self.parts.cells

    @cached_property
    def bound(self) -> np.ndarray:
        """Mean of the traction bound over each part, dimensionless."""
        rows, columns = self.cells
        return np.asarray(self.coefficient.repeat(rows, axis=0).repeat(columns, axis=1) * self.parts.pressed.pressure)

    @property
    def shapes(self) -> tuple[Shape, Shape]:
        """What tractions are interpolated by, dimensionless: on the elements and on their parts."""
        on_elements, on_parts = self.parts.weights
        return Shape(self.coefficient * self.parts.elements, on_elements), Shape(self.bound, on_parts)

    def field(self, traction: np.ndarray) -> np.ndarray:
        """The traction on the parts, from that on the elements.

        Parameters
        ----------
        traction : ndarray, shape (2, ny, nx)
            Dimensionless, within the bound.

        Returns
        -------
        ndarray, shape (2, ny rows, nx columns)
        """
        return reconstructed(traction, *self.shapes, self.cells)

    def shift(self, traction: np.ndarray, rigid: np.ndarray) -> np.ndarray:
        """Local shift of the continuum in a step of the coarse grid.

        Parameters
        ----------
        traction : ndarray, shape (2, ny rows, nx columns)
            Dimensionless, within the bound.
        rigid : ndarray, shape (2,)
            Uniform rigid shift where a force is prescribed, dimensionless.

        Returns
        -------
        ndarray, shape (2, ny rows, nx columns)
            Dimensionless; means over the parts.
        """
        return np.asarray(self.parts.known_shift + rigid[:, None, None] + self.elastic_shift(traction))

    def elastic_shift(self, traction: np.ndarray) -> np.ndarray:
        """What a traction adds to the continuum's local shift in a step of the coarse grid, means over the parts.

        Parameters
        ----------
        traction : ndarray, shape (2, ny rows, nx columns)
            Dimensionless, within the bound.

        Returns
        -------
        ndarray, shape (2, ny rows, nx columns)
            Dimensionless.
        """
        parts = self.parts
        elastic = parts.elastic_shift(traction)
        if parts.rooted is None:
            return elastic
        behind = self.sticking(traction)[:, None] * (parts.lattice.x < 0)
        other = (parts.derivative.apply(traction) + parts.rooted.lacking(traction)) * parts.steps
        return np.asarray(elastic + behind * (other - elastic))

    def sticking(self, traction: np.ndarray) -> np.ndarray:
        """How far each row is from slip at its trailing edge: one less the ratio of traction to bound there.

        Parameters
        ----------
        traction : ndarray, shape (2, ny rows, nx columns)
            Dimensionless, within the bound.

        Returns
        -------
        ndarray, shape (ny rows,)
            Zero where nothing is in contact.
        """
        contact, rows = self.bound > 0, np.arange(len(self.bound))
        rearmost = contact.argmax(axis=1)
        bound = self.bound[rows, rearmost]
        ratio = np.hypot(*traction[:, rows, rearmost]) / np.where(bound > 0, bound, 1.0)
        return np.where(bound > 0, np.maximum(1 - ratio, 0.0), 0.0)

    def sticks(self, traction: np.ndarray) -> bool:
        """Whether nothing is near slip, in Hertz's contact: there it is known how tractions grow.

        Parameters
        ----------
        traction : ndarray, shape (2, ny rows, nx columns)
            Dimensionless, within the bound.
        """
        pressed = self.parts.pressed.pressure > 0
        return self.parts.rooted is not None and bool(np.all(np.hypot(*traction) < self.bound / 2, where=pressed))

    def on_elements(self, field: np.ndarray) -> np.ndarray:
        """Means over the elements, weighted by the traction bound.

        Parameters
        ----------
        field : ndarray, shape (..., ny rows, nx columns)

        Returns
        -------
        ndarray, shape (..., ny, nx)
            Zero where there is no bound.
        """
        weight = means(self.bound, self.cells)
        return means(field * self.bound, self.cells) / np.where(weight > 0, weight, 1.0)

    def forces(self, traction: np.ndarray) -> np.ndarray:
        """Fx, Fy and Mz of tractions on the parts, physical.

        Parameters
        ----------
        traction : ndarray, shape (2, ny rows, nx columns)
            Dimensionless.

        Returns
        -------
        ndarray, shape (3,)
        """
        return loads(traction * self.parts.disc.scales.pressure, self.parts.grid)


def loads(traction: np.ndarray, grid: Grid) -> np.ndarray:
    """Fx, Fy and the moment Mz about the origin of tractions on a grid.

    Parameters
    ----------
    traction : ndarray, shape (2, ny, nx)
        [force/area]
    grid : Grid
        Explicit.

    Returns
    -------
    ndarray, shape (3,)
        [force], the last [force length].
    """
    x, y = grid.x[None, :], grid.y[:, None]
    Fx, Fy = traction.sum(axis=(1, 2))
    return np.array([Fx, Fy, np.sum(x * traction[1] - y * traction[0])]) * grid.area
