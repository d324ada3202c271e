"""Equal parts of the elements of a grid: the pressure on them, and derivatives of displacement between them."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from varcontact.discrete.discretisation import Discretisation
from varcontact.discrete.operators import Operators
from varcontact.elasticity.ellipsoidal import rooted_gradients
from varcontact.elasticity.operators import GridOperator
from varcontact.scene.grid import Cells, Grid
from varcontact.scene.motion import Steady
from varcontact.solving.defect_correction.pressed import Pressed, derivative, hertz_pressed, solved_pressed
from varcontact.solving.defect_correction.rooted import Rooted, RootMeans, mean_gradients, root_means, rooted


@dataclass(frozen=True, eq=False)
class Brought:
    """What a step of a history finds on the parts, dimensionless.

    Attributes
    ----------
    displacement : ndarray, shape (2, ny rows, nx columns)
        The displacement differences that the particles bring along to the centres of the parts.
    operators : Operators
        Of the parts, the same for all steps.
    """

    displacement: np.ndarray
    operators: Operators


@dataclass(frozen=True, eq=False)
class Parts:
    """A contact in steady rolling, in a shift or in a step of a history, on equal parts of the elements of its grid.

    Attributes
    ----------
    disc : Discretisation
        Of the coarse elements, with quasi-identical bodies.
    cells : tuple of int
        (rows, columns): parts of an element along y and x.
    elements : ndarray, shape (ny, nx)
        Pressure on the elements, dimensionless.
    finer : ndarray, optional
        The pressure that was solved for, on parts of the parts, dimensionless. None: Hertz's in closed form.
    brought : Brought, optional
        In a step of a history: what the step before left.
    """

    disc: Discretisation
    cells: Cells
    elements: np.ndarray
    finer: np.ndarray | None = None
    brought: Brought | None = None

    @cached_property
    def grid(self) -> Grid:
        """The parts, physical."""
        return self.disc.grid.divided(self.cells)

    @cached_property
    def lattice(self) -> Grid:
        """The parts, dimensionless."""
        return self.disc.lattice.divided(self.cells)

    @cached_property
    def root_means(self) -> RootMeans:
        """Means over the parts by the root of Hertz's pressure."""
        return root_means(self.lattice, *self.axes)

    @property
    def axes(self) -> tuple[float, float]:
        """Semi-axes of Hertz's contact, dimensionless."""
        hertz = self.disc.hertz
        assert hertz is not None
        return hertz.a / self.disc.scales.length, hertz.b / self.disc.scales.length

    @cached_property
    def pressed(self) -> Pressed:
        """The pressure on the parts, and what it says of its edge."""
        if self.finer is None:
            return hertz_pressed(self.disc, self.cells, self.root_means.weight)
        return solved_pressed(self.disc, self.cells, self.elements, self.finer)

    @cached_property
    def rooted(self) -> Rooted | None:
        """Tractions over the root of the distance from the edge, of Hertz's contact in rolling."""
        if not self.disc.loading.steady or self.finer is not None:
            return None
        gradients = rooted_gradients(*self.axes, nu=self.disc.operators.nu)
        return rooted(self.root_means.over, gradients, self.lattice.sides[0], self.derivative)

    @cached_property
    def sloped(self) -> Rooted | None:
        """Hertz's pressure times 1, x and y, in rolling; in line contact the pressure alone is as exact."""
        if not self.disc.loading.steady or self.finer is not None or self.disc.line:
            return None
        gradients = mean_gradients(self.lattice, *self.axes, self.disc.operators.nu)
        return rooted(self.root_means.times, gradients, self.lattice.sides[0], self.derivative)

    @property
    def weights(self) -> tuple[np.ndarray, np.ndarray]:
        """What tractions are in proportion to without slip, on the elements and on the parts; in a step it slips."""
        return self.pressed.weights if self.disc.loading.steady else (self.elements, self.pressed.pressure)

    @cached_property
    def known_shift(self) -> np.ndarray:
        """Shift in a step of the coarse grid but for that by tractions, at the centres of the parts, (2, ...)."""
        disc, motion = self.disc, self.disc.loading.motion
        assert motion is not None
        if isinstance(motion, Steady):
            motion = replace(motion, spin_offset=0.0)  # the derivative is exact: nothing is sampled ahead
        x, y = np.meshgrid(self.lattice.x, self.lattice.y)
        rigid = (
            motion.step((disc.step or 0.0) * disc.scales.length).shift(x, y, disc.scales.length)
            / disc.scales.displacement
        )
        return rigid if self.brought is None else rigid - self.brought.displacement

    def elastic_shift(self, traction: np.ndarray) -> np.ndarray:
        """What a traction adds to the shift, means over the parts.

        Around each part it is in proportion to the pressure, in rolling under Hertz's by a linear factor.

        Parameters
        ----------
        traction : ndarray, shape (2, ny rows, nx columns)
            Dimensionless.

        Returns
        -------
        ndarray, shape (2, ny rows, nx columns)
            In steady rolling by a step of the coarse grid; in a shift or a step at the centres of the parts.
        """
        if not self.disc.loading.steady:
            return self.displacement.apply(traction)
        if self.sloped is not None:
            return (self.derivative.apply(traction) + self.sloped.lacking(traction)) * self.steps
        pressure = self.pressed.pressure
        missing = np.einsum("ij...,j...->i...", self.missing, traction / np.where(pressure > 0, pressure, 1.0))
        return (self.derivative.apply(traction) + missing) * self.steps

    @property
    def steps(self) -> float:
        """Length of a step of rolling by that of a part."""
        assert self.disc.step is not None
        return self.disc.step / self.lattice.sides[0]

    @cached_property
    def displacement(self) -> GridOperator:
        """Displacement at the centres of the parts."""
        return (self.disc.operators.on(self.lattice) if self.brought is None else self.brought.operators).tangential()

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
