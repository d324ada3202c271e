"""The slip of the continuum on parts of coarse elements."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from varcontact.elasticity.operators import GridOperator
from varcontact.problem.discretisation import Discretisation
from varcontact.scene.grid import Grid
from varcontact.scene.motion import Steady
from varcontact.solving.refine.field import Cells, Shape, means
from varcontact.solving.refine.pressed import Pressed, derivative, divided, hertz_pressed, solved_pressed
from varcontact.solving.refine.rooted import Rooted, rooted

UNBOUNDED = 1e9
"""Coefficient that stands for infinite friction: tractions are far below the bound, and it stays a number."""


@dataclass(frozen=True, eq=False)
class Sublattice:
    """A contact that rolls steadily, on equal parts of the elements of its grid.

    Slip is that of the continuum, but for the tractions' constancy on each part: the derivative of displacement along x
    by each part in closed form, its mean over each part. What that misses near the contact's edge is known for the
    pressure, acting as a traction: in closed form for Hertz's, and from a finer lattice where it is solved for. It is
    added in proportion to the traction's ratio to the pressure. In rows that stick up to their trailing edge, in
    Hertz's contact, what is known there of tractions over the root of the distance takes its place.

    Attributes
    ----------
    disc : Discretisation
        Of the coarse elements, in steady rolling, with quasi-identical bodies.
    cells : tuple of int
        (rows, columns): parts of an element along y and x.
    elements : ndarray, shape (ny, nx)
        Pressure on the elements, dimensionless.
    finer : ndarray, optional
        The pressure that was solved for, on parts of the parts, dimensionless. None: Hertz's in closed form.
    """

    disc: Discretisation
    cells: Cells
    elements: np.ndarray
    finer: np.ndarray | None = None

    @cached_property
    def grid(self) -> Grid:
        """The parts, physical."""
        return divided(self.disc.grid, self.cells)

    @cached_property
    def lattice(self) -> Grid:
        """The parts, dimensionless."""
        return divided(self.disc.lattice, self.cells)

    @cached_property
    def pressed(self) -> Pressed:
        """The pressure on the parts, and what it says of its edge."""
        if self.finer is None:
            return hertz_pressed(self.disc, self.cells)
        return solved_pressed(self.disc, self.cells, self.elements, self.finer)

    @cached_property
    def rooted(self) -> Rooted | None:
        """Tractions over the root of the distance from the edge, of Hertz's contact."""
        return rooted(self.disc, self.lattice, self.derivative) if self.finer is None else None

    @cached_property
    def bound(self) -> np.ndarray:
        """Mean of the traction bound over each part, dimensionless."""
        rows, columns = self.cells
        return np.asarray(self._coefficient.repeat(rows, axis=0).repeat(columns, axis=1) * self.pressed.pressure)

    @property
    def _coefficient(self) -> np.ndarray:
        """Of friction, on the elements."""
        coefficient, shape = np.asarray(UNBOUNDED if self.disc.no_slip else self.disc.coefficient), self.disc.grid.shape
        return coefficient.reshape(shape) if coefficient.ndim else np.full(shape, coefficient)

    @cached_property
    def shapes(self) -> tuple[Shape, Shape]:
        """What tractions are interpolated by, dimensionless: on the elements and on their parts."""
        on_elements, on_parts = self.pressed.weights
        return Shape(self._coefficient * self.elements, on_elements), Shape(self.bound, on_parts)

    @cached_property
    def rigid_shift(self) -> np.ndarray:
        """Rigid shift in a step of the coarse grid at the centres of the parts, dimensionless, (2, ...)."""
        disc, motion = self.disc, self.disc.motion
        assert isinstance(motion, Steady) and disc.step is not None
        still = replace(motion, spin_offset=0.0)  # the derivative is exact: nothing is sampled ahead
        x, y = np.meshgrid(self.lattice.x, self.lattice.y)
        return still.step(disc.step * disc.length).shift(x, y, disc.length) / disc.displacement

    @cached_property
    def derivative(self) -> GridOperator:
        """Minus the derivative of displacement along x, times a part's length: its mean over each part."""
        return derivative(self.disc, self.lattice)

    @cached_property
    def missing(self) -> np.ndarray:
        """What `derivative` misses of the pressure acting along x or y, (2, 2, ...)."""
        pressure, nothing = self.pressed.pressure, np.zeros_like(self.bound)
        found = [self.derivative.apply(np.array(each)) for each in ((pressure, nothing), (nothing, pressure))]
        return np.asarray(self.pressed.shift - np.array(found).swapaxes(0, 1))

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
        assert self.disc.step is not None
        pressure = self.pressed.pressure
        ratio = traction / np.where(pressure > 0, pressure, 1.0)
        missing = np.einsum("ij...,j...->i...", self.missing, ratio)
        if self.rooted is not None:
            behind = self.sticking(traction)[:, None] * (self.lattice.x < 0)
            missing += behind * (self.rooted.lacking(traction) - missing)
        elastic = self.derivative.apply(traction) + missing
        return np.asarray(self.rigid_shift + rigid[:, None, None] + elastic * (self.disc.step / self.lattice.sides[0]))

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
        """Whether nothing slips at any trailing edge, in Hertz's contact: there it is known how tractions grow.

        Parameters
        ----------
        traction : ndarray, shape (2, ny rows, nx columns)
            Dimensionless, within the bound.
        """
        rows = (self.bound > 0).any(axis=1)
        return self.rooted is not None and bool(self.sticking(traction)[rows].min() > 0.5)

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
        return loads(traction * self.disc.pressure, self.grid)


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
