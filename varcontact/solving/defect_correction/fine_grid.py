"""Equal parts of the coarse elements: the field on them, reconstructed from the coarse tractions, and its slip."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from varcontact.discrete.discretisation import Discretisation
from varcontact.discrete.state import means
from varcontact.elasticity.ellipsoidal import rooted_gradients
from varcontact.elasticity.operators import influence_operator
from varcontact.scene.grid import Cells, Grid
from varcontact.scene.motion import Steady
from varcontact.solving.defect_correction.edge_singularity import (
    KnownTractions,
    root_means,
    times_root_gradients,
)

PARTS = 2
"""Parts of an element along each side: with three the error is the same, and the time twice as long."""
CELLS = (PARTS, PARTS)
SLIPS = 1 - 1e-6
"""Part of its bound from which on a traction counts as slipping: coarse solves are exact to 1e-5 of the largest."""
REVERSED, TURNED = 0.5, 0.9
"""Size of the mean of two directions, a quarter and three quarters of them: opposite ones, and 60 degrees apart."""


@dataclass(frozen=True, eq=False)
class FineField:
    """Tractions on the parts, dimensionless."""

    friction: np.ndarray  # (ny, nx) Coefficients on the elements
    traction: np.ndarray  # (2, ny PARTS, nx PARTS)
    bound: np.ndarray  # (ny PARTS, nx PARTS)


class FineGrid:
    """Parts of the elements in steady rolling under Hertz's pressure; dimensionless, but for `grid` and `hertz`.

    `derivative`: minus that of displacement along x, times a part's length, its mean over each part. `times_root`:
    Hertz's pressure times 1, x and y. `over_root`: tractions like those at a trailing edge that sticks.
    `rigid_shift`: in a step of the coarse grid at the centres of the parts, (2, ...).
    """

    def __init__(self, disc: Discretisation, pressure: np.ndarray) -> None:
        hertz, medium = disc.hertz, disc.operators.medium
        assert hertz is not None
        self.disc, self.pressure = disc, pressure  # of the elements
        self.grid, self.lattice = disc.grid.divided(CELLS), disc.lattice.divided(CELLS)
        self.hertz, self.axes = hertz, (hertz.a / disc.scales.length, hertz.b / disc.scales.length)
        self.pressure_on_parts = hertz.mean_pressure(*self.grid.lines) / disc.scales.pressure
        side = self.lattice.sides[0]
        self.derivative = influence_operator(self.lattice, "xy", "xy", medium=medium, lag=side, offset=-side / 2)
        self.root_means = root_means(self.lattice, *self.axes)
        gradients = times_root_gradients(self.lattice, *self.axes, medium.nu)
        self.times_root = KnownTractions.on(self.root_means.times, gradients, side, self.derivative)
        gradients = rooted_gradients(*self.axes, nu=medium.nu)[..., None, None]
        self.over_root = KnownTractions.on(self.root_means.over, gradients, side, self.derivative)
        assert isinstance(disc.loading.motion, Steady)
        x, y = np.meshgrid(self.lattice.x, self.lattice.y)
        step = replace(disc.loading.motion, spin_offset=0.0).step((disc.step or 0.0) * disc.scales.length)
        self.rigid_shift = step.shift(x, y, disc.scales.length) / disc.scales.displacement

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
        # how far each row is from slip at its trailing edge: one less the ratio of traction to bound
        rows, rearmost = np.arange(len(field.bound)), (field.bound > 0).argmax(axis=1)
        bound = field.bound[rows, rearmost]
        ratio = np.hypot(*field.traction[:, rows, rearmost]) / np.where(bound > 0, bound, 1.0)
        behind = np.where(bound > 0, np.maximum(1 - ratio, 0.0), 0.0)[:, None] * (self.lattice.x < 0)
        elastic = sliding + behind * (sticking - sliding)
        return np.asarray(self.rigid_shift + rigid[:, None, None] + elastic)

    def on_elements(self, values: np.ndarray, bound: np.ndarray) -> np.ndarray:
        """Means over the elements of values on the parts, weighted by the bound; zero where there is none."""
        weight = means(bound, CELLS)
        return means(values * bound, CELLS) / np.where(weight > 0, weight, 1.0)

    def forces(self, field: FineField) -> np.ndarray:
        """Fx, Fy and Mz, physical."""
        return resultants(field.traction * self.disc.scales.pressure, self.grid)


def resultants(traction: np.ndarray, grid: Grid) -> np.ndarray:
    """Fx, Fy and the moment Mz about the origin of tractions (2, ny, nx) on a grid [force, force length]."""
    x, y = grid.x[None, :], grid.y[:, None]
    Fx, Fy = traction.sum(axis=(1, 2))
    return np.array([Fx, Fy, np.sum(x * traction[1] - y * traction[0])]) * grid.area


@dataclass(frozen=True, eq=False)
class Shape:
    """What tractions are interpolated by: on elements or on their parts."""

    bound: np.ndarray  # (ny, nx) Traction bound, zero outside the contact
    weight: np.ndarray


def reconstructed(traction: np.ndarray, coarse: Shape, fine: Shape, cells: Cells) -> np.ndarray:
    """A traction on the parts of elements, (2, ny rows, nx columns), from that on the elements, (2, ny, nx).

    Where elements stick, the ratio of traction to weight is interpolated between the centres of the elements in
    contact, and multiplied by the weight on the parts, up to the bound: that keeps the roots at both edges. Where an
    element around slips, size and direction are interpolated apart, and between slipping ones the size is the bound.
    Between slip and stick that is for tractions that turn; where they reverse, vectors are interpolated again.
    """
    contact = coarse.bound > 0
    ratio, factor = (
        np.where(contact, traction / np.where(contact, by, 1.0), 0.0) for by in (coarse.bound, coarse.weight)
    )
    slips = contact & (np.hypot(*ratio) >= SLIPS)
    near_slip, near_stick = (interpolated(each.astype(float), contact, cells) > 0 for each in (slips, contact & ~slips))
    smooth = interpolated(factor, contact, cells)
    within = _of_size(smooth, np.minimum(np.hypot(*smooth) * fine.weight, fine.bound))
    size = np.minimum(interpolated(np.hypot(*factor), contact, cells) * fine.weight, fine.bound)
    turned = _of_size(interpolated(ratio, contact, cells), np.where(near_stick, size, fine.bound))
    length = np.hypot(*interpolated(_of_size(ratio, np.where(contact, 1.0, 0.0)), contact, cells))
    turns = np.where(near_stick, np.clip((length - REVERSED) / (TURNED - REVERSED), 0.0, 1.0), 1.0)
    return np.where(near_slip, turns * turned + (1 - turns) * within, within)


def _of_size(vectors: np.ndarray, size: np.ndarray) -> np.ndarray:
    """Vectors of the same direction and another size; zeros stay."""
    length = np.hypot(*vectors)
    return np.asarray(vectors * (size / np.where(length > 0, length, 1.0)))


def held_behind(correction: np.ndarray, traction: np.ndarray, bound: np.ndarray) -> np.ndarray:
    """Corrections (2, ny, nx) of which the rearmost element of a row has that of the element ahead, unless it slips.

    There the field on parts cannot follow tractions that grow without limit; and what is ahead hardly feels it.
    """
    contact = np.pad(bound > 0, ((0, 0), (1, 1)))
    rearmost = contact[:, 1:-1] & ~contact[:, :-2] & (np.hypot(*traction) < SLIPS * bound)
    ahead = np.pad(correction, ((0, 0), (0, 0), (0, 1)))[..., 1:] * contact[:, 2:]
    return np.where(rearmost, ahead, correction)


def interpolated(values: np.ndarray, contact: np.ndarray, cells: Cells) -> np.ndarray:
    """Values on the parts, bilinear between the centres of the elements in contact; zero far from these."""
    weight = _bilinear(contact.astype(float), cells)
    known = weight > 1e-9
    return np.where(known, _bilinear(values * contact, cells) / np.where(known, weight, 1.0), 0.0)


def continued(values: np.ndarray, contact: np.ndarray) -> np.ndarray:
    """Values in the contact, and around it the means of their neighbours in it; elsewhere as given."""
    sums, counts = (_around(each) for each in (values * contact, contact.astype(float)))
    return np.where(contact | (counts == 0), values, sums / np.where(counts > 0, counts, 1.0))


def _around(values: np.ndarray) -> np.ndarray:
    """Sums over each element and its eight neighbours."""
    padded = np.pad(values, 1)
    rows = padded[:-2] + padded[1:-1] + padded[2:]
    return np.asarray(rows[:, :-2] + rows[:, 1:-1] + rows[:, 2:])


def _bilinear(values: np.ndarray, cells: Cells) -> np.ndarray:
    """Interpolated along x, then along y, with zeros around the grid."""
    along_x = _linear(values, cells[1])
    return np.swapaxes(_linear(np.swapaxes(along_x, -1, -2), cells[0]), -1, -2)


def _linear(values: np.ndarray, parts: int) -> np.ndarray:
    """Interpolated along the last axis."""
    place = (np.arange(values.shape[-1] * parts) + 0.5) / parts - 0.5
    before = np.floor(place).astype(int)
    part = place - before
    padded = np.pad(values, [(0, 0)] * (values.ndim - 1) + [(1, 1)])
    return np.asarray(padded[..., before + 1] * (1 - part) + padded[..., before + 2] * part)
