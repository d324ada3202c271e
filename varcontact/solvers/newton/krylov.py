"""GCR: generalised conjugate residuals, in single precision, for one Newton step and its missing rigid shifts."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np

FEWEST, MOST = 60, 240
"""Directions, at most: of very large problems, and of all others."""
ROOM = 2e7
"""Numbers that all directions together may have, as long as they are not too few."""
LEAST = 1e-7
"""Length of a new direction, of itself, below which it is made of rounding."""


class System(Protocol):
    """The linear equations of a Newton step: a row for each traction component of each element."""

    def product(self, step: np.ndarray) -> np.ndarray:
        """M times a step.

        Parameters
        ----------
        step : ndarray, shape (c, ny, nx)
            Changes of the tractions, in single precision.

        Returns
        -------
        ndarray, shape (c, ny, nx)
        """

    def rows(self, image: np.ndarray, step: np.ndarray) -> np.ndarray:
        """Left-hand sides for a step and M times the step.

        Parameters
        ----------
        image, step : ndarray, shape (c, ny, nx)
            M times the step, and the step.

        Returns
        -------
        ndarray, shape (c, ny, nx)
        """

    def border(self, component: int) -> np.ndarray:
        """Left-hand sides for a uniform shift along one component.

        Parameters
        ----------
        component : int
            0 or, of two components, 1.

        Returns
        -------
        ndarray, shape (c, ny, nx)
        """

    def precondition(self, right: np.ndarray) -> np.ndarray:
        """Nearly the step that has these left-hand sides.

        Parameters
        ----------
        right : ndarray, shape (c, ny, nx)

        Returns
        -------
        ndarray, shape (c, ny, nx)
        """


@dataclass(frozen=True, eq=False)
class Forces:
    """Prescribed sums of traction components; a uniform rigid shift along each is unknown.

    Attributes
    ----------
    components : tuple of int
    sums : ndarray, shape (k,)
    weight : float
        Of their equations: one by the root of the number of elements.
    scale : ndarray, shape (ny, nx), optional
        Traction of each element that counts as one, and displacement that does; one if not given.
    """

    components: tuple[int, ...]
    sums: np.ndarray
    weight: float
    scale: np.ndarray | None = None

    def lacking(self, traction: np.ndarray) -> np.ndarray:
        """What tractions lack of the sums, weighted.

        Parameters
        ----------
        traction : ndarray, shape (c, ny, nx)
            In the unit of the sums.

        Returns
        -------
        ndarray, shape (k,)
        """
        return self.weight * (self.sums - self.of(traction))

    def of(self, traction: np.ndarray) -> np.ndarray:
        """The sums of tractions.

        Parameters
        ----------
        traction : ndarray, shape (c, ny, nx)

        Returns
        -------
        ndarray, shape (k,)
            In double precision, in the unit of the tractions.
        """
        scale = 1.0 if self.scale is None else self.scale
        return np.array([(traction[i] * scale).sum(dtype=float) for i in self.components])

    def moved(self, rigid: np.ndarray) -> np.ndarray:
        """Displacements by rigid shifts, as elements count them.

        Parameters
        ----------
        rigid : ndarray, shape (c, 1, 1)

        Returns
        -------
        ndarray, shape (c, 1, 1) or (c, ny, nx)
        """
        return rigid if self.scale is None else rigid * self.scale

    def spread(self, values: np.ndarray, components: int) -> np.ndarray:
        """Rigid shifts, zero where no force is prescribed.

        Parameters
        ----------
        values : ndarray, shape (k,)
            In the order of the prescribed forces.
        components : int
            c, of the tractions.

        Returns
        -------
        ndarray, shape (c, 1, 1)
        """
        shifts = np.zeros((components, 1, 1))
        shifts[list(self.components), 0, 0] = values
        return shifts


@dataclass(frozen=True, eq=False)
class Step:
    """A Newton step, in the units of the kernel.

    Attributes
    ----------
    traction, shift : ndarray, shape (c, ny, nx)
        Changes of the tractions and of the shift E.
    rigid : ndarray, shape (c, 1, 1)
        Changes of the rigid shifts.
    iterations : int
        Of GCR.
    """

    traction: np.ndarray
    shift: np.ndarray
    rigid: np.ndarray
    iterations: int


@dataclass(frozen=True, eq=False)
class Room:
    """Room for the directions of GCR.

    Attributes
    ----------
    directions, products : float32 ndarray, shape (most, n)
        The directions, and M times them.
    images : float32 ndarray, shape (most, n + k)
        What the equations make of them, those of the k forces last.
    """

    directions: np.ndarray
    products: np.ndarray
    images: np.ndarray

    @classmethod
    def of(cls, size: int, forces: Forces) -> Room:
        """For a number of unknowns; memory is taken only when it is used.

        Parameters
        ----------
        size : int
            Number n of unknowns.
        forces : Forces
        """
        most = min(int(np.clip(ROOM / size, FEWEST, MOST)), 2 * size + 10)  # rounding may take more than the unknowns
        directions, products = (np.empty((most, size), np.float32) for _ in range(2))
        return cls(directions, products, np.empty((most, size + len(forces.components)), np.float32))


def gcr(system: System, right: np.ndarray, forces: Forces, lacking: np.ndarray, enough: float, room: Room) -> Step:
    """Solve a Newton step's equations to a relative residual.

    Parameters
    ----------
    system : System
    right : ndarray, shape (c, ny, nx)
    forces : Forces
    lacking : ndarray, shape (k,)
        What the tractions lack of them, weighted.
    enough : float
        Relative residual to stop at.
    room : Room
        Overwritten.

    Notes
    -----
    Eisenstat, Elman and Schultz, SIAM J. Numer. Anal. 20 (1983) 345-357. The images of the directions are kept
    orthonormal, and M times each direction is kept: M times the step then costs no product.
    """
    shape, size, k = right.shape, right.size, len(lacking)
    length = float(np.sqrt(np.vdot(right, right) + lacking @ lacking))
    if length == 0:
        return Step(np.zeros(shape), np.zeros(shape), np.zeros((shape[0], 1, 1)), 0)
    residual = np.concatenate([(right / length).ravel(), lacking / length]).astype(np.float32)
    directions, products, images = room.directions, room.products, room.images
    most = len(images)
    rigid, triangle, along = np.zeros((most, k)), np.zeros((most, most)), np.zeros(most)
    bordered = _Bordered(system, forces)
    count = 0
    while count < most and float(np.linalg.norm(residual)) > enough:
        direction, shifts = bordered.precondition(residual[:size].reshape(shape), residual[size:])
        product = system.product(direction)
        image, old = images[count], images[:count]
        image[:size], image[size:] = bordered.rows(product, direction, shifts).ravel(), bordered.sums(direction)
        known = old @ image
        image -= known @ old
        own = float(np.linalg.norm(image))
        if not own > LEAST:
            break
        image /= np.float32(own)
        directions[count], products[count] = direction.ravel(), product.ravel()
        rigid[count], triangle[:count, count], triangle[count, count] = shifts, known, own
        along[count] = image @ residual
        residual -= np.float32(along[count]) * image
        count += 1
    parts = np.linalg.solve(triangle[:count, :count], along[:count]) * length
    change = forces.spread(parts @ rigid[:count], shape[0])
    single = parts.astype(np.float32)
    traction = (single @ directions[:count]).reshape(shape).astype(float)
    return Step(traction, (single @ products[:count]).reshape(shape) + forces.moved(change), change, count)


class _Bordered:
    """A system with the equations of prescribed forces: bordered by a column and a row for each."""

    def __init__(self, system: System, forces: Forces) -> None:
        self.system, self.forces = system, forces
        self.borders = [system.border(i) for i in forces.components]
        self.steps = [system.precondition(border) for border in self.borders]
        complement = np.array([self.sums(step) for step in self.steps], dtype=float).T
        usable = complement.size > 0 and np.isfinite(complement).all()
        self.inverse = np.linalg.pinv(complement) if usable else np.full_like(complement, np.nan)

    def sums(self, step: np.ndarray) -> np.ndarray:
        """The forces of a step, weighted, float32."""
        return (self.forces.weight * self.forces.of(step)).astype(np.float32)

    def precondition(self, right: np.ndarray, lacking: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Nearly the step and the rigid shifts that have these left-hand sides."""
        step = self.system.precondition(right)
        if not self.borders:
            return step, np.zeros(0)
        shifts = self.inverse @ (self.sums(step) - lacking)
        for shift, other in zip(shifts, self.steps, strict=True):
            step = step - np.float32(shift) * other
        return step, shifts

    def rows(self, image: np.ndarray, step: np.ndarray, shifts: np.ndarray) -> np.ndarray:
        """Left-hand sides for a step, M times the step, and rigid shifts."""
        rows = self.system.rows(image, step)
        for shift, border in zip(shifts, self.borders, strict=True):
            rows += np.float32(shift) * border
        return rows
