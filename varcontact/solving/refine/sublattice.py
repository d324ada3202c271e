"""The slip of the continuum on parts of coarse elements."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from varcontact.elasticity.ellipsoidal import ellipsoidal_gradients
from varcontact.elasticity.operators import GridOperator, influence_operator
from varcontact.problem.discretisation import Discretisation
from varcontact.problem.state import hertz_pressure, unloaded
from varcontact.scene.grid import Grid
from varcontact.scene.motion import Steady
from varcontact.solving.refine.field import Cells, Shape, means

BEHIND = 0.25
"""Part of an element that is added to distances from the trailing edge.

With half of one, forces without slip are a third farther off, and with a thirtieth they are noise.
"""


@dataclass(frozen=True, eq=False)
class Sublattice:
    """A Hertzian contact that rolls steadily, on equal parts of the elements of its grid.

    Slip is that of the continuum, but for the tractions' constancy on each part: the derivative of displacement along x
    by each part in closed form, its mean over each part. What that misses near the contact's edge is known for the
    traction bound itself, whose derivative is linear in x and y, and is added in proportion to the traction's ratio to
    the bound.

    Attributes
    ----------
    disc : Discretisation
        Of the coarse elements, in steady rolling, with quasi-identical bodies and one coefficient of friction.
    cells : tuple of int
        (rows, columns): parts of an element along y and x.
    """

    disc: Discretisation
    cells: Cells

    @cached_property
    def grid(self) -> Grid:
        """The parts, physical."""
        return divided(self.disc.grid, self.cells)

    @cached_property
    def lattice(self) -> Grid:
        """The parts, dimensionless."""
        return divided(self.disc.lattice, self.cells)

    @cached_property
    def bound(self) -> np.ndarray:
        """Mean of the traction bound over each part, dimensionless."""
        assert self.disc.hertz is not None
        coefficient = float(np.asarray(self.disc.coefficient))
        return coefficient * self.disc.hertz.mean_pressure(*self.grid.lines) / self.disc.pressure

    @cached_property
    def shapes(self) -> tuple[Shape, Shape]:
        """What tractions are interpolated by, dimensionless: on the elements and on their parts."""
        assert self.disc.hertz is not None
        on_elements = (
            float(np.asarray(self.disc.coefficient)) * hertz_pressure(self.disc, unloaded(self.disc.grid)).pressure
        )
        return Shape(on_elements, self._behind(self.disc.grid)), Shape(self.bound, self._behind(self.grid))

    def _behind(self, grid: Grid) -> np.ndarray:
        """Distance from the trailing edge, and a little more, dimensionless."""
        hertz = self.disc.hertz
        assert hertz is not None
        edge = hertz.a * np.sqrt(np.maximum(1 - (grid.y[:, None] / hertz.b) ** 2, 0.0))
        return np.asarray(np.maximum(grid.x[None, :] + edge, 0.0) + BEHIND * self.disc.grid.sides[0]) / self.disc.length

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
        side, operators = self.lattice.sides[0], self.disc.operators
        return influence_operator(
            self.lattice, "xy", "xy", nu=operators.nu, depth=operators.depth, lag=side, offset=-side / 2
        )

    @cached_property
    def missing(self) -> np.ndarray:
        """What `derivative` misses of the traction bound along x or y, (2, 2, ...)."""
        disc, side = self.disc, self.lattice.sides[0]
        assert disc.hertz is not None
        x, y = np.meshgrid(self.lattice.x, self.lattice.y)
        a, b = disc.hertz.a / disc.length, disc.hertz.b / disc.length
        peak = float(np.asarray(disc.coefficient)) * disc.hertz.peak_pressure / disc.pressure
        exact = -side * peak * ellipsoidal_gradients(x, y, a, b, nu=disc.operators.nu)
        nothing = np.zeros_like(self.bound)
        found = [self.derivative.apply(np.array(each)) for each in ((self.bound, nothing), (nothing, self.bound))]
        return np.asarray(exact - np.array(found).swapaxes(0, 1))

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
        ratio = traction / np.where(self.bound > 0, self.bound, 1.0)
        elastic = self.derivative.apply(traction) + np.einsum("ij...,j...->i...", self.missing, ratio)
        return np.asarray(self.rigid_shift + rigid[:, None, None] + elastic * (self.disc.step / self.lattice.sides[0]))

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


def divided(grid: Grid, cells: Cells) -> Grid:
    """A grid whose elements are parts of those of another.

    Parameters
    ----------
    grid : Grid
        Explicit.
    cells : tuple of int
        (rows, columns): parts of an element along y and x; one row in line contact.
    """
    (dx, dy), (left, _, bottom, _), (rows, columns) = grid.sides, grid.box, cells
    if grid.line:
        return Grid(nx=grid.nx * columns, dx=dx / columns, x0=left)
    return Grid(nx=grid.nx * columns, ny=grid.rows * rows, dx=dx / columns, dy=dy / rows, x0=left, y0=bottom)


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
