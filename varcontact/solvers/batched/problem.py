"""Tangential problems of one shape, with the problem as the last axis of every array, and their
solution.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, fields, replace
from typing import Self

import numpy as np

from varcontact.solvers.newton import hierarchy
from varcontact.transports import DIFFERENCES


@dataclass(frozen=True, eq=False)
class Batch:
    """Arrays whose last axis is the problem."""

    def __iter__(self) -> Iterator[np.ndarray]:
        return (getattr(self, each.name) for each in fields(self))

    def where(self, mask: np.ndarray) -> Self:
        """Batch of some of the problems."""
        return type(self)(*(np.compress(mask, each, axis=-1) for each in self))

    def joined(self, other: Self) -> Self:
        """Batch of these problems followed by others."""
        return type(self)(*(np.concatenate(both, -1) for both in zip(self, other, strict=True)))

    def put(self, ids: np.ndarray, other: Self) -> None:
        """Copy others into the places of some problems."""
        for each, values in zip(self, other, strict=True):
            each[..., ids] = values


def side_by_side(fields: Sequence[np.ndarray]) -> np.ndarray:
    """Fields of problems on as many elements as each has, in one array with the problem as its last
    axis; zero beyond the elements of each.
    """
    shape = np.max([each.shape for each in fields], axis=0)
    together = np.zeros((*shape, len(fields)))
    for j, own in enumerate(fields):
        place: tuple[slice | int, ...] = (*(slice(size) for size in own.shape), j)
        together[place] = own
    return together


@dataclass(frozen=True, eq=False)
class BatchedProblem:
    """Tangential problems of like half-spaces, dimensionless with G = 1; n
    problems on (ny, nx) elements.

    Attributes
    ----------
    dx, dy, nu : ndarray, shape (n,)
        Sides of the elements, the strips' width in line contact, and Poisson's
        ratio.
    rigid_shift : ndarray, shape (2, ny, nx, n)
        W: of components whose force is prescribed, without what is unknown of
        it.
    bound : ndarray, shape (ny, nx, n)
        Traction bound, zero out of contact.
    force : ndarray, shape (2, n)
        Prescribed sums of the tractions over the elements; NaN where the rigid
        shift is given.
    difference : str or None
        Difference over a step of rolling by one element, see `DIFFERENCES`;
        None in a shift.
    line : bool
        Line contact, ny = 1.
    compliance : ndarray, shape (ny, nx), optional
        Of softened edges, by the element's own influence.
    """

    dx: np.ndarray
    dy: np.ndarray
    nu: np.ndarray
    rigid_shift: np.ndarray
    bound: np.ndarray
    force: np.ndarray
    difference: str | None = "first-order"
    line: bool = False
    compliance: np.ndarray | None = None

    @property
    def steps_ahead(self) -> tuple[tuple[int, float], ...]:
        """Points of the difference, in elements ahead, and their weights."""
        if self.difference is None:
            return ((0, 1.0),)
        return DIFFERENCES[self.difference]

    @property
    def inside(self) -> tuple[slice, slice]:
        """The rows and the columns between the first and the last in which a problem has
        contact.
        """
        rows = np.flatnonzero(self.bound.any(axis=(1, 2)))
        columns = np.flatnonzero(self.bound.any(axis=(0, 2)))
        return (
            slice(min(rows, default=0), max(rows, default=-1) + 1),
            slice(min(columns, default=0), max(columns, default=-1) + 1),
        )

    def within(self, rows: slice, columns: slice) -> BatchedProblem:
        """The problems on some of the elements, without those where none has contact."""
        compliance = self.compliance
        if compliance is not None:
            compliance = compliance[rows, columns]
        return replace(
            self,
            rigid_shift=self.rigid_shift[:, rows, columns],
            bound=self.bound[rows, columns],
            compliance=compliance,
        )

    def of(self, ids: np.ndarray) -> BatchedProblem:
        """Batch of some of the problems."""
        return replace(
            self,
            dx=self.dx[ids],
            dy=self.dy[ids],
            nu=self.nu[ids],
            rigid_shift=self.rigid_shift[..., ids],
            bound=self.bound[..., ids],
            force=self.force[:, ids],
        )

    def coarser(self) -> BatchedProblem:
        """Problems on elements twice as large, with a rolling step twice as long."""
        longer = 1.0 if self.difference is None else 2.0
        return replace(
            self,
            dx=2 * self.dx,
            dy=self.dy if self.line else 2 * self.dy,
            rigid_shift=longer * halved(self.rigid_shift),
            bound=halved(self.bound),
            force=self.force / (2 if self.line else 4),
            compliance=None,
        )


@dataclass(frozen=True, eq=False)
class BatchedSolution(Batch):
    """Tractions (2, ny, nx, n), unknown rigid shifts of prescribed forces (2, n), and how exact
    they are.

    The natural-map residual is relative to the largest traction, the gap to the work of the bound
    on the rigid shift. `slip` is the size of the shift where an element slips, (ny, nx, n), else 0;
    `dissipated` is the sum of ``-p.E`` with the shift E at the tractions p.
    """

    traction: np.ndarray
    rigid: np.ndarray
    residual: np.ndarray
    relative_gap: np.ndarray
    converged: np.ndarray
    iterations: np.ndarray
    slip: np.ndarray
    dissipated: np.ndarray

    @classmethod
    def unsolved(cls, problem: BatchedProblem) -> BatchedSolution:
        """Solution to be filled as problems are solved: zeros, with infinite residuals and gaps."""
        n = problem.dx.size
        return cls(
            traction=np.zeros_like(problem.rigid_shift),
            rigid=np.zeros((2, n)),
            residual=np.full(n, np.inf),
            relative_gap=np.full(n, np.inf),
            converged=np.zeros(n, bool),
            iterations=np.zeros(n, int),
            slip=np.zeros_like(problem.bound),
            dissipated=np.zeros(n),
        )

    def within(self, rows: slice, columns: slice) -> BatchedSolution:
        """A view on some of the elements."""
        traction = self.traction[:, rows, columns]
        return replace(self, traction=traction, slip=self.slip[rows, columns])


def influence(problem: BatchedProblem, columns: int) -> np.ndarray:
    """``pi G A/dx`` of xx, xy and yy by offset from 0 to ny - 1 and to `columns` - 1 elements: (3,
    ny, columns, n).

    Closed forms (217) as differences over corners, of strips over ends: on few elements nothing
    cancels that counts.
    """
    x = (np.arange(columns + 1) - 0.5)[:, None]
    nu = problem.nu
    if problem.line:
        log = -np.diff(x * np.log(np.abs(x)) - x, axis=0)[None]
        return np.stack([2 * (1 - nu) * log, 0 * nu * log, 2 * log + 0 * nu])
    y = (np.arange(problem.bound.shape[0] + 1) - 0.5)[:, None, None] * (problem.dy / problem.dx)
    R = np.sqrt(x * x + y * y)

    def over_corners(corners: np.ndarray) -> np.ndarray:
        return np.diff(np.diff(corners, axis=0), axis=1)

    first = over_corners(y * np.log(x + R))
    second = over_corners(x * np.log(y + R))
    mixed = over_corners(R)
    return np.stack([first + (1 - nu) * second, -nu * mixed, second + (1 - nu) * first])


def halved(field: np.ndarray) -> np.ndarray:
    """Means of 2 x 2 elements (2 in line contact), with zeros beyond an odd end."""
    return np.moveaxis(hierarchy.halved(np.moveaxis(field, -1, 0)), 0, -1)


def doubled(field: np.ndarray, contact: np.ndarray, shape: tuple[int, int]) -> np.ndarray:
    """Linear interpolation on elements half as large, over the elements in contact only."""
    fields = np.moveaxis(field, -1, 0)
    contacts = np.moveaxis(contact, -1, 0)[:, None]
    return np.moveaxis(hierarchy.doubled(fields, contacts, shape), 0, -1)
