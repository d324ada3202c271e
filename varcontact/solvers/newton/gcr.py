"""GCR: generalised conjugate residuals, in single precision, for one Newton step and its missing
rigid shifts.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from dataclasses import dataclass

import numpy as np

from varcontact.solvers.newton.kernel import Product

MAX_DIRECTIONS = 240
MAX_DIRECTIONS_LARGE = 60
"""Largest number of directions for very large problems."""
MAX_NUMBERS = 2e7
"""Largest number of entries of all directions together, unless too few directions would be left."""
SHIFT_MAX = 1e18
"""Largest uniform shift, whose square fits single precision: in full slip no shift gives the
forces."""
LENGTH_MIN = 1e-7
"""Length of a new direction, relative to its image, below which it consists of rounding."""


@dataclass(frozen=True, eq=False)
class System(ABC):
    """Newton's equations at given tractions: a row for each traction component (c, ny, nx) of each
    element.
    """

    right: np.ndarray

    @abstractmethod
    def rows(self, image: np.ndarray, step: np.ndarray) -> np.ndarray:
        """Left-hand sides for a step and M times the step."""

    @abstractmethod
    def border(self, component: int) -> np.ndarray:
        """Left-hand sides for a uniform shift along one component."""

    @abstractmethod
    def precondition(self, right: np.ndarray) -> np.ndarray:
        """Step that approximately has these left-hand sides."""


@dataclass(frozen=True, eq=False)
class Forces:
    """Prescribed sums (k,) of traction components; a uniform rigid shift along each is unknown.

    `weight` is that of their equations; `scale` (ny, nx) the traction of each element that counts
    as one. Where the first sum is that of parts of all components, `shares` (c, ny, nx) are these.
    """

    components: tuple[int, ...]
    sums: np.ndarray
    weight: float
    scale: np.ndarray | float = 1.0
    shares: np.ndarray | None = None

    def lacking(self, traction: np.ndarray) -> np.ndarray:
        """Missing forces: prescribed sums minus those of the tractions, weighted (k,)."""
        return self.weight * (self.sums - self.of(traction))

    def of(self, traction: np.ndarray) -> np.ndarray:
        """The sums of tractions, in double precision (k,)."""
        sums = np.array([(traction[i] * self.scale).sum(dtype=float) for i in self.components])
        if self.shares is not None:
            sums[0] = (self.shares * traction).sum(dtype=float)
        return sums

    def spread(self, values: np.ndarray, components: int) -> np.ndarray:
        """Rigid shifts (c, 1, 1) from those of the prescribed forces (k,), zero elsewhere."""
        shifts = np.zeros((components, 1, 1))
        shifts[list(self.components), 0, 0] = values
        return shifts


@dataclass(frozen=True, eq=False)
class Step:
    """A Newton step: changes of the tractions and of the shift E (c, ny, nx), and of the rigid
    shifts (c, 1, 1).
    """

    traction: np.ndarray
    shift: np.ndarray
    rigid: np.ndarray

    @property
    def finite(self) -> bool:
        return bool(np.isfinite(self.traction).all() and np.isfinite(self.shift).all())


Room = tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]


def room_for(size: int, forces: Forces) -> Room:
    """Memory for directions, M times them, their images, and the triangle of their projections;
    allocated where used.
    """
    # rounding may take more than the unknowns
    most = min(
        int(np.clip(MAX_NUMBERS / size, MAX_DIRECTIONS_LARGE, MAX_DIRECTIONS)), 2 * size + 10
    )
    directions = np.empty((most, size), np.float32)
    products = np.empty((most, size), np.float32)
    images = np.empty((most, size + len(forces.components)), np.float32)
    return directions, products, images, np.zeros((most, most))


@dataclass(frozen=True, eq=False)
class _Border:
    """Prescribed forces in a Newton step's equations: columns of the unknown uniform shifts, steps
    by these, and the inverse of the sums that the steps have.
    """

    forces: Forces
    columns: list[np.ndarray]
    steps: list[np.ndarray]
    inverse: np.ndarray

    @classmethod
    def of(cls, system: System, forces: Forces) -> _Border:
        columns = [system.border(i) for i in forces.components]
        steps = [system.precondition(column) for column in columns]
        sums = [_weighted_sums(forces, step) for step in steps]
        complement = np.array(sums, dtype=float).reshape(len(steps), len(steps)).T
        return cls(forces, columns, steps, _inverse(complement))

    def sums(self, step: np.ndarray) -> np.ndarray:
        return _weighted_sums(self.forces, step)

    def shifts(self, direction: np.ndarray, lacking: np.ndarray) -> np.ndarray:
        """Uniform shifts with which a direction supplies the missing forces."""
        return np.asarray(self.inverse @ (self.sums(direction) - lacking))

    def moved(self, shifts: np.ndarray) -> np.ndarray:
        """Left-hand sides for uniform shifts."""
        moved = zip(shifts, self.columns, strict=True)
        return np.asarray(sum(np.float32(shift) * column for shift, column in moved))

    def balanced(self, direction: np.ndarray, shifts: np.ndarray) -> np.ndarray:
        """Direction combined with uniform shifts."""
        for shift, step in zip(shifts, self.steps, strict=True):
            direction = direction - np.float32(shift) * step
        return direction


def _inverse(matrix: np.ndarray) -> np.ndarray:
    """Inverse of a small matrix, or its pseudo-inverse; NaN if it is not finite."""
    if not np.isfinite(matrix).all():
        return np.full_like(matrix, np.nan)
    try:
        return np.linalg.inv(matrix)
    except np.linalg.LinAlgError:
        return np.linalg.pinv(matrix)


def _weighted_sums(forces: Forces, step: np.ndarray) -> np.ndarray:
    return (forces.weight * forces.of(step)).astype(np.float32)


def gcr(
    system: System, kernel: Product, forces: Forces, lacking: np.ndarray, tol: float, room: Room
) -> Step:
    """Solve a Newton step's equations, and those of the forces, which lack (k,), to a relative
    residual.

    Eisenstat, Elman and Schultz, SIAM J. Numer. Anal. 20 (1983) 345-357. The images of the
    directions are kept orthonormal, and M times each direction is kept: M times the step then costs
    no product.
    """
    right = system.right
    shape = right.shape
    size = right.size
    k = len(lacking)
    length = float(np.sqrt(np.vdot(right, right) + lacking @ lacking))
    if length == 0:
        return Step(np.zeros(shape), np.zeros(shape), np.zeros((shape[0], 1, 1)))
    residual = np.concatenate([(right / length).ravel(), lacking / length]).astype(np.float32)
    directions, products, images, triangle = room
    most = len(images)
    rigid = np.zeros((most, k))
    along = np.zeros(most)
    border = None
    if k:
        border = _Border.of(system, forces)
    count = 0
    while count < most and math.sqrt(residual @ residual) > tol:
        # a direction that keeps the forces, and its image by the equations
        direction = system.precondition(residual[:size].reshape(shape))
        image = images[count]
        if border is not None:
            shifts = border.shifts(direction, residual[size:])
            if not np.all(np.abs(shifts) <= SHIFT_MAX):  # no rigid shift changes the forces
                break
            direction = border.balanced(direction, shifts)
            rigid[count] = shifts
            image[size:] = border.sums(direction)
        product = kernel(direction)
        rows = system.rows(product, direction)
        if border is not None:
            rows += border.moved(rigid[count])
        image[:size] = rows.ravel()
        # orthogonal to earlier images, and of unit length
        earlier = images[:count]
        projections = earlier @ image
        image -= projections @ earlier
        image_length = math.sqrt(image @ image)
        if not image_length > LENGTH_MIN:
            break
        image /= np.float32(image_length)
        directions[count] = direction.ravel()
        products[count] = product.ravel()
        triangle[:count, count] = projections
        triangle[count, count] = image_length
        # its projection is subtracted from the residual
        along[count] = image @ residual
        residual -= np.float32(along[count]) * image
        count += 1
    # the step is a sum of directions
    parts = np.linalg.solve(triangle[:count, :count], along[:count]) * length
    change = forces.spread(parts @ rigid[:count], shape[0])
    single = parts.astype(np.float32)
    traction = (single @ directions[:count]).reshape(shape).astype(float)
    shift = (single @ products[:count]).reshape(shape) + change * forces.scale
    return Step(traction, shift, change)
