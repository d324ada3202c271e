"""Equal parts of the elements of a grid: the pressure on them, and derivatives of displacement between them."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from varcontact.elasticity.operators import GridOperator
from varcontact.problem.discretisation import Discretisation
from varcontact.scene.grid import Grid
from varcontact.scene.motion import Steady
from varcontact.solving.refine.field import Cells
from varcontact.solving.refine.pressed import Pressed, derivative, divided, hertz_pressed, solved_pressed
from varcontact.solving.refine.rooted import Rooted, rooted


@dataclass(frozen=True, eq=False)
class Parts:
    """A contact that rolls steadily, on equal parts of the elements of its grid.

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
        pressure, nothing = self.pressed.pressure, np.zeros_like(self.pressed.pressure)
        found = [self.derivative.apply(np.array(each)) for each in ((pressure, nothing), (nothing, pressure))]
        return np.asarray(self.pressed.shift - np.array(found).swapaxes(0, 1))
