"""Equal parts of the coarse elements: the field on them, and the continuum's slip under it."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from varcontact.discrete.discretisation import Discretisation
from varcontact.discrete.subgrid import means
from varcontact.elasticity.ellipsoidal import rooted_gradients
from varcontact.elasticity.operators import GridOperator, influence_operator
from varcontact.reference.hertz import HertzContact
from varcontact.scene.grid import Grid
from varcontact.scene.motion import Steady
from varcontact.solving.defect_correction.edge_singularity import (
    KnownTractions,
    RootMeans,
    root_means,
    times_root_gradients,
)
from varcontact.solving.defect_correction.reconstruction import Shape, reconstructed

PARTS = 2
"""Parts of an element along each side: with three the error is the same, and the time twice as long."""
CELLS = (PARTS, PARTS)


@dataclass(frozen=True, eq=False)
class FineField:
    """Tractions on the parts, dimensionless."""

    friction: np.ndarray  # (ny, nx) Coefficients on the elements
    traction: np.ndarray  # (2, ny PARTS, nx PARTS)
    bound: np.ndarray  # (ny PARTS, nx PARTS)


@dataclass(frozen=True, eq=False)
class FineGrid:
    """Parts of the elements in steady rolling under Hertz's pressure; dimensionless, but for `grid`."""

    disc: Discretisation  # of the elements
    pressure: np.ndarray  # (ny, nx) On the elements

    @cached_property
    def grid(self) -> Grid:
        """The parts, physical."""
        return self.disc.grid.divided(CELLS)

    @cached_property
    def lattice(self) -> Grid:
        """The parts."""
        return self.disc.lattice.divided(CELLS)

    @property
    def hertz(self) -> HertzContact:
        """The contact, physical."""
        assert self.disc.hertz is not None
        return self.disc.hertz

    @property
    def axes(self) -> tuple[float, float]:
        """Semi-axes of the contact along x and y."""
        return self.hertz.a / self.disc.scales.length, self.hertz.b / self.disc.scales.length

    @cached_property
    def pressure_on_parts(self) -> np.ndarray:
        """Means of the pressure over the parts."""
        return np.asarray(self.hertz.mean_pressure(*self.grid.lines) / self.disc.scales.pressure)

    @cached_property
    def derivative(self) -> GridOperator:
        """Minus the derivative of displacement along x, times a part's length: its mean over each part."""
        side, operators = self.lattice.sides[0], self.disc.operators
        return influence_operator(self.lattice, "xy", "xy", medium=operators.medium, lag=side, offset=-side / 2)

    @cached_property
    def root_means(self) -> RootMeans:
        """Means over the parts of tractions with the roots of the edge."""
        return root_means(self.lattice, *self.axes)

    @cached_property
    def times_root(self) -> KnownTractions:
        """Hertz's pressure times 1, x and y."""
        gradients = times_root_gradients(self.lattice, *self.axes, self.disc.operators.medium.nu)
        return KnownTractions.on(self.root_means.times, gradients, self.lattice.sides[0], self.derivative)

    @cached_property
    def over_root(self) -> KnownTractions:
        """Tractions like those at a trailing edge that sticks."""
        gradients = rooted_gradients(*self.axes, nu=self.disc.operators.medium.nu)[..., None, None]
        return KnownTractions.on(self.root_means.over, gradients, self.lattice.sides[0], self.derivative)

    @cached_property
    def rigid_shift(self) -> np.ndarray:
        """Rigid shift in a step of the coarse grid at the centres of the parts, (2, ...)."""
        disc = self.disc
        assert isinstance(disc.loading.motion, Steady)
        x, y = np.meshgrid(self.lattice.x, self.lattice.y)
        step = replace(disc.loading.motion, spin_offset=0.0).step((disc.step or 0.0) * disc.scales.length)
        return np.asarray(step.shift(x, y, disc.scales.length) / disc.scales.displacement)

    def field(self, traction: np.ndarray, friction: np.ndarray) -> FineField:
        """The field from tractions on the elements, (2, ny, nx), and their coefficients of friction, (ny, nx)."""
        bound = friction.repeat(PARTS, axis=0).repeat(PARTS, axis=1) * self.pressure_on_parts
        weight = self.root_means.weight
        coarse, fine = Shape(friction * self.pressure, means(weight, CELLS)), Shape(bound, weight)
        return FineField(friction, reconstructed(traction, coarse, fine, CELLS), bound)

    def shift(self, field: FineField, rigid: np.ndarray) -> np.ndarray:
        """The continuum's local shift under a field in a step of the coarse grid, means over the parts, (2, ...).

        Parts of constant traction miss some of it near the edge. That is known for Hertz's pressure times a linear
        factor, and, behind the middle of rows that stick at their trailing edge, for such factors over the root.
        """
        assert self.disc.step is not None
        steps, constant = self.disc.step / self.lattice.sides[0], self.derivative.apply(field.traction)
        sliding, sticking = (
            (constant + known.missed(field.traction)) * steps for known in (self.times_root, self.over_root)
        )
        behind = _sticking(field)[:, None] * (self.lattice.x < 0)
        elastic = sliding + behind * (sticking - sliding)
        return np.asarray(self.rigid_shift + rigid[:, None, None] + elastic)

    def on_elements(self, values: np.ndarray, bound: np.ndarray) -> np.ndarray:
        """Means over the elements of values on the parts, weighted by the bound; zero where there is none."""
        weight = means(bound, CELLS)
        return means(values * bound, CELLS) / np.where(weight > 0, weight, 1.0)

    def forces(self, field: FineField) -> np.ndarray:
        """Fx, Fy and Mz, physical."""
        return resultants(field.traction * self.disc.scales.pressure, self.grid)


def _sticking(field: FineField) -> np.ndarray:
    """How far each row is from slip at its trailing edge: one less the ratio of traction to bound, (ny PARTS,)."""
    rows, rearmost = np.arange(len(field.bound)), (field.bound > 0).argmax(axis=1)
    bound = field.bound[rows, rearmost]
    ratio = np.hypot(*field.traction[:, rows, rearmost]) / np.where(bound > 0, bound, 1.0)
    return np.where(bound > 0, np.maximum(1 - ratio, 0.0), 0.0)


def resultants(traction: np.ndarray, grid: Grid) -> np.ndarray:
    """Fx, Fy and the moment Mz about the origin of tractions (2, ny, nx) on a grid [force, force length]."""
    x, y = grid.x[None, :], grid.y[:, None]
    Fx, Fy = traction.sum(axis=(1, 2))
    return np.array([Fx, Fy, np.sum(x * traction[1] - y * traction[0])]) * grid.area
