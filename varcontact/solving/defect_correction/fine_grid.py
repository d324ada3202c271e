"""Equal parts of the coarse elements: the field on them, reconstructed from the
coarse tractions, and its slip.

Tractions with the roots of Hertz's edge have known displacements: from these
follows what constant parts miss.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from varcontact.discrete.contact_grid import on_parts
from varcontact.discrete.discretisation import Discretisation
from varcontact.discrete.state import means
from varcontact.elasticity.ellipsoidal import ellipsoidal_gradients, rooted_gradients, sloped_gradients
from varcontact.elasticity.halfspace import HalfSpaces
from varcontact.elasticity.operators import GridOperator, influence_operator
from varcontact.scene.grid import Grid
from varcontact.scene.motion import Steady

PARTS = 2
"""Parts of an element along each side: with three the error is the same, and the time twice as long."""
CELLS = (PARTS, PARTS)
SLIPS = 1 - 1e-6
"""Part of its bound from which on a traction counts as slipping: coarse solves are exact to 1e-5 of the largest."""
REVERSED, TURNED = 0.5, 0.9
"""Size of the mean of two directions, a quarter and three quarters of them: opposite ones, and 60 degrees apart."""

NODES = 32
"""Of Gauss's rule across an element; along it means are in closed form."""
LEAST = 1e-7
"""Mean of a traction, by the largest, from which on an element counts as touched: less may be rounding."""


@dataclass(frozen=True, eq=False)
class FineField:
    """Tractions on the parts, dimensionless."""

    friction: np.ndarray  # (ny, nx) Coefficients on the elements
    traction: np.ndarray  # (2, ny PARTS, nx PARTS)
    bound: np.ndarray  # (ny PARTS, nx PARTS)


class FineGrid:
    """Parts of the elements in steady rolling under Hertz's pressure; dimensionless, but for `grid`.

    `derivative`: minus that of displacement along x, times a part's length, its mean over each part. `times_root`:
    Hertz's pressure times 1, x and y. `over_root`: tractions like those at a trailing edge that sticks. `weight`: means
    of what tractions without slip are like. `rigid_shift`: in a step of the coarse grid at the centres of the parts,
    (2, ...).
    """

    def __init__(self, disc: Discretisation, pressure: np.ndarray) -> None:
        hertz, medium, nu = disc.hertz, disc.operators.medium, disc.bodies.combined_nu
        assert hertz is not None and isinstance(medium, HalfSpaces)
        self.disc, self.pressure = disc, pressure  # of the elements
        self.grid, self.lattice = disc.grid.divided(CELLS), disc.lattice.divided(CELLS)
        axes = hertz.a / disc.scales.length, hertz.b / disc.scales.length
        self.pressure_on_parts = hertz.mean_pressure(*self.grid.lines) / disc.scales.pressure
        side = self.lattice.sides[0]
        self.derivative = influence_operator(self.lattice, "xy", "xy", medium=medium, lag=side, offset=-side / 2)
        times_root, over_root, self.weight = root_means(self.lattice, *axes)
        gradients = times_root_gradients(self.lattice, *axes, nu)
        self.times_root = KnownTractions.on(times_root, gradients, self.lattice, self.derivative)
        gradients = rooted_gradients(*axes, nu=nu)[..., None, None]
        self.over_root = KnownTractions.on(over_root, gradients, self.lattice, self.derivative)
        assert isinstance(disc.loading.motion, Steady)
        x, y = np.meshgrid(self.lattice.x, self.lattice.y)
        step = replace(disc.loading.motion, spin_offset=0.0).step((disc.step or 0.0) * disc.scales.length)
        self.rigid_shift = step.shift(x, y, disc.scales.length) / disc.scales.displacement

    def field(self, traction: np.ndarray, friction: np.ndarray) -> FineField:
        """The field from tractions on the elements, (2, ny, nx), and their coefficients of friction, (ny, nx).

        Where elements stick, the ratio of traction to weight is interpolated between the centres of the elements in
        contact, and multiplied by the weight on the parts, up to the bound: that keeps the roots at both edges. Where
        an element around slips, size and direction are interpolated apart; between slipping ones the size is the bound.
        Between slip and stick that is for tractions that turn; where they reverse, vectors are interpolated again.
        """
        bound = friction.repeat(PARTS, axis=0).repeat(PARTS, axis=1) * self.pressure_on_parts
        contact = friction * self.pressure > 0
        ratio, factor = (
            np.where(contact, traction / np.where(contact, by, 1.0), 0.0)
            for by in (friction * self.pressure, means(self.weight, CELLS))
        )
        slips = contact & (np.hypot(*ratio) >= SLIPS)
        near_slip, near_stick = (interpolated(1.0 * each, contact) > 0 for each in (slips, contact & ~slips))
        smooth = interpolated(factor, contact) * self.weight
        within = _of_size(smooth, np.minimum(np.hypot(*smooth), bound))
        size = np.minimum(interpolated(np.hypot(*factor), contact) * self.weight, bound)
        turned = _of_size(interpolated(ratio, contact), np.where(near_stick, size, bound))
        length = np.hypot(*interpolated(_of_size(ratio, 1.0 * contact), contact))
        turns = np.where(near_stick, np.clip((length - REVERSED) / (TURNED - REVERSED), 0.0, 1.0), 1.0)
        found = np.where(near_slip, turns * turned + (1 - turns) * within, within)
        return FineField(friction, found, bound)

    def shift(self, field: FineField, rigid: np.ndarray) -> np.ndarray:
        """The continuum's local shift under a field in a step of the coarse grid, means over the parts, (2, ...).

        Parts of constant traction miss some of it near the edge. That is known for Hertz's pressure times a linear
        factor, and, behind the middle of rows that stick at their trailing edge, for such factors over the root.
        """
        assert self.disc.step is not None
        missed, sticking = (known.missed(field.traction) for known in (self.times_root, self.over_root))
        # how far each row is from slip at its trailing edge: one less the ratio of traction to bound
        rows, rearmost = np.arange(len(field.bound)), (field.bound > 0).argmax(axis=1)
        bound = field.bound[rows, rearmost]
        ratio = np.hypot(*field.traction[:, rows, rearmost]) / np.where(bound > 0, bound, 1.0)
        behind = np.where(bound > 0, np.maximum(1 - ratio, 0.0), 0.0)[:, None] * (self.lattice.x < 0)
        elastic = self.derivative.apply(field.traction) + missed + behind * (sticking - missed)
        steps = self.disc.step / self.lattice.sides[0]
        return np.asarray(self.rigid_shift + rigid[:, None, None] + elastic * steps)

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


def interpolated(values: np.ndarray, contact: np.ndarray) -> np.ndarray:
    """Values on the parts, bilinear between the centres of the elements in contact; zero far from these."""
    weight = on_parts(contact.astype(float), CELLS)
    known = weight > 1e-9
    return np.where(known, on_parts(values * contact, CELLS) / np.where(known, weight, 1.0), 0.0)


# ----------------------------------------------------------------------------- tractions with the roots of the edge


def root_means(grid: Grid, a: float, b: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Means over the elements of an explicit grid of 1, x and y times r, over r, (3, ny, nx), and of the weight.

    For an ellipse, ``r = sqrt(1 - (x/a)^2 - (y/b)^2)``, and the weight ``sqrt((e - x)/(e + x))`` with its half length e
    at y; zero outside of it.
    """
    (lines, across), (place, share) = grid.lines, np.polynomial.legendre.leggauss(NODES)
    y = (across[:-1, None] + np.diff(across)[:, None] * (place + 1) / 2)[:, None]
    half = a * np.sqrt(np.maximum(1 - (y / b) ** 2, 0.0))  # in closed form along x, by nodes across
    x = np.clip(lines[:, None], -half, half)
    angle, depth = np.arcsin(x / np.where(half > 0, half, 1.0)), np.sqrt(half**2 - x**2)
    lens = (x * depth + half**2 * angle) / (2 * a)
    times, over = (lens, -(depth**3) / (3 * a), lens * y), (a * angle, -a * depth, a * angle * y)
    integrals = np.array([*times, *over, half * angle + depth]) @ (share / 2)
    found = np.diff(integrals) / np.diff(lines)
    return found[:3], found[3:6], found[6]


@dataclass(frozen=True, eq=False)
class KnownTractions:
    """Tractions 1, x and y over the root, or times it, whose displacement is known in closed form."""

    means: np.ndarray  # (3, ny, nx) Over each part; zero outside the ellipse
    missing: np.ndarray
    sides: tuple[float, float]  # of a part

    @classmethod
    def on(cls, means: np.ndarray, gradients: np.ndarray, grid: Grid, derivative: GridOperator) -> KnownTractions:
        """From the exact gradients (3, 2, 2, ...) and the derivative on the parts."""
        nothing = np.zeros(means.shape[1:])
        found = [[derivative.apply(np.array(each)) for each in ((one, nothing), (nothing, one))] for one in means]
        missing = -grid.sides[0] * gradients - np.array(found).swapaxes(1, 2)
        return cls(means * (means[0] > LEAST * means[0].max()), missing, grid.sides)

    def missed(self, traction: np.ndarray) -> np.ndarray:
        """What parts miss of a traction (2, ny, nx): a factor of the first one, linear around each part."""
        root = self.means[0]
        within = np.where(root > 0, root, 1.0)
        factor, (x, y) = traction * (root > 0) / within, self.means[1:] / within  # where the first is centred
        (dx, dy), turned = self.sides, factor.swapaxes(1, 2)
        along, across = slope(factor, root > 0) / dx, slope(turned, root.T > 0).swapaxes(1, 2) / dy
        terms = np.array([factor - along * x - across * y, along, across])
        return np.einsum("kij...,kj...->i...", self.missing, terms)


def times_root_gradients(grid: Grid, a: float, b: float, nu: float) -> np.ndarray:
    """Derivatives along x of displacements by 1, x and y times the root, means over elements, (3, 2, 2, ny, nx).

    They are of second degree at most: four points give exact means.
    """
    x, y = np.meshgrid(grid.x, grid.y)
    dx, dy = (side / np.sqrt(12) for side in grid.sides)
    linear = ellipsoidal_gradients(x, y, a, b, nu=nu)[None]
    corners = [(-dx, -dy), (-dx, dy), (dx, -dy), (dx, dy)]
    bent = np.mean([sloped_gradients(x + right, y + up, a, b, nu=nu) for right, up in corners], axis=0)
    return np.concatenate([linear, bent])


def slope(values: np.ndarray, known: np.ndarray) -> np.ndarray:
    """Differences of values (n, rows, columns) along their rows, means of those to both neighbours that are known."""
    both = known[:, 1:] & known[:, :-1]
    rises = np.pad(np.diff(values) * both, ((0, 0), (0, 0), (1, 1)))
    count = np.pad(both.astype(int), ((0, 0), (1, 1)))
    return np.asarray((rises[..., 1:] + rises[..., :-1]) / np.maximum(count[:, 1:] + count[:, :-1], 1))
