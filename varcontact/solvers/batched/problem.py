"""Tangential problems of one shape, with the problem as the last axis of every array, and their
solution.
"""

from __future__ import annotations

from collections.abc import Iterator
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
        """Some of the problems."""
        return type(self)(*(np.compress(mask, each, axis=-1) for each in self))

    def joined(self, other: Self) -> Self:
        """With others behind."""
        return type(self)(*(np.concatenate(both, -1) for both in zip(self, other, strict=True)))

    def put(self, ids: np.ndarray, other: Self) -> None:
        """Write others in the places of some."""
        for each, values in zip(self, other, strict=True):
            each[..., ids] = values


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
        return ((0, 1.0),) if self.difference is None else DIFFERENCES[self.difference]

    @property
    def inside(self) -> tuple[slice, slice]:
        """The rows and the columns between the first and the last in which a problem has
        contact.
        """
        lines = (np.flatnonzero(self.bound.any(axis=(axis, 2))) for axis in (1, 0))
        rows, columns = (slice(min(each, default=0), max(each, default=-1) + 1) for each in lines)
        return rows, columns

    def within(self, rows: slice, columns: slice) -> BatchedProblem:
        """The problems on some of the elements, without those where none has contact."""
        shift, bound = self.rigid_shift[:, rows, columns], self.bound[rows, columns]
        compliance = None if self.compliance is None else self.compliance[rows, columns]
        return replace(self, rigid_shift=shift, bound=bound, compliance=compliance)

    def of(self, ids: np.ndarray) -> BatchedProblem:
        """Some of the problems."""
        given = ("dx", "dy", "nu", "rigid_shift", "bound", "force")
        return replace(self, **{name: getattr(self, name)[..., ids] for name in given})

    def coarser(self) -> BatchedProblem:
        """With elements twice as large, and a step of rolling that is so, too."""
        shift, bound = (
            (1.0 if self.difference is None else 2.0) * halved(self.rigid_shift),
            halved(self.bound),
        )
        force, dy = (self.force / 2, self.dy) if self.line else (self.force / 4, 2 * self.dy)
        return replace(
            self,
            dx=2 * self.dx,
            dy=dy,
            rigid_shift=shift,
            bound=bound,
            force=force,
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
        """To be written to as problems are solved."""
        n, nothing = problem.dx.size, np.zeros_like(problem.rigid_shift)
        far, no, none = np.full((2, n), np.inf), np.zeros(n, bool), np.zeros(n, int)
        return cls(
            nothing,
            np.zeros((2, n)),
            far[0],
            far[1],
            no,
            none,
            np.zeros_like(problem.bound),
            np.zeros(n),
        )

    def within(self, rows: slice, columns: slice) -> BatchedSolution:
        """A view on some of the elements."""
        return replace(
            self, traction=self.traction[:, rows, columns], slip=self.slip[rows, columns]
        )


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
    first, second, mixed = (
        np.diff(np.diff(f, axis=0), axis=1) for f in (y * np.log(x + R), x * np.log(y + R), R)
    )
    return np.stack([first + (1 - nu) * second, -nu * mixed, second + (1 - nu) * first])


def halved(field: np.ndarray) -> np.ndarray:
    """Means of 2 x 2 elements (2 in line contact), with zeros beyond an odd end."""
    return np.moveaxis(hierarchy.halved(np.moveaxis(field, -1, 0)), 0, -1)


def doubled(field: np.ndarray, contact: np.ndarray, shape: tuple[int, int]) -> np.ndarray:
    """Linear interpolation on elements half as large, over the elements in contact only."""
    found = hierarchy.doubled(
        np.moveaxis(field, -1, 0), np.moveaxis(contact, -1, 0)[:, None], shape
    )
    return np.moveaxis(found, 0, -1)
