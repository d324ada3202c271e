"""Transports: a motion on a lattice, as solvers meet it, and the fields that its particles carry.

A displacement difference over a step of rolling is a stencil: distances ahead at
which displacements are taken, and their weights. In steady rolling particles
meet on their way the fields that others meet now; in a step of a history those
of the step before are known; a shift is a step in place.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from varcontact.system.process import lazy_property

Stencil = tuple[tuple[float, float], ...]
"""Distances ahead at which displacements are taken, and their weights."""

HERE: Stencil = ((0.0, 1.0),)
"""Stencil of displacements at the same place."""

DIFFERENCES: dict[str, tuple[tuple[int, float], ...]] = {
    "first-order": ((0, 1.0), (1, -1.0)),
    "second-order": ((-1, 5 / 24), (0, 21 / 24), (1, -33 / 24), (2, 7 / 24)),
}
"""Differences of displacements over a step of rolling, in steps ahead.

The second is 5/12 of the central difference and 7/12 of the second-order one from here and ahead:
docs/sampling.md.
"""

Join = Callable[[np.ndarray, np.ndarray], np.ndarray]
"""The value of a particle after a step, from that before and that of the step."""


class Transport(Protocol):
    """A motion on a lattice, dimensionless."""

    @property
    def repeats(self) -> bool:
        """True in steady rolling, where the arriving fields equal those that leave a step."""

    @property
    def distance(self) -> float:
        """Distance rolled in a step: positive towards positive x, zero in place."""

    @property
    def dx(self) -> float:
        """Side of an element along x."""

    @property
    def difference(self) -> str:
        """Entry of `DIFFERENCES` for the slip over a step of rolling."""

    @property
    def stencil(self) -> Stencil:
        """Stencil of the differences of displacements by unknown tractions."""

    @property
    def columns(self) -> float:
        """Elements that particles pass in a step, with the sign of the distance."""


@dataclass(frozen=True)
class SteadyRolling:
    """A step that is repeated; particles come from further along x."""

    distance: float
    dx: float
    difference: str = "first-order"
    repeats = True

    @lazy_property
    def stencil(self) -> Stencil:
        return tuple(
            (ahead * self.distance, weight) for ahead, weight in DIFFERENCES[self.difference]
        )

    @property
    def columns(self) -> float:
        return round(self.distance / self.dx, 9)


@dataclass(frozen=True)
class Step:
    """One step of a history, or a shift: a step in place."""

    distance: float
    dx: float
    difference = "first-order"
    repeats = False
    stencil = HERE

    @property
    def columns(self) -> float:
        return round(self.distance / self.dx, 9)


def mirrored(stencil: Stencil) -> Stencil:
    """The stencil of bodies that roll the other way."""
    return tuple((-ahead, weight) for ahead, weight in stencil)


# ----------------------------------------------------------------------------- particles


def along_rows(own: np.ndarray, columns: float, fresh: float, join: Join) -> np.ndarray:
    """Values (..., ny, nx) that particles accumulate on their way along the rows in steady rolling.

    From the step's own values, joined with those one step of so many columns before; where steps
    are shorter than a column, one column before.
    """
    nx = own.shape[-1]
    columns = min(max(columns, 1.0), float(nx))
    whole = int(columns)
    part = columns % 1.0
    # columns first: each is then one piece of memory
    values = np.full((2 * nx + 1, *own.shape[:-1]), fresh, own.dtype)
    values[:nx] = np.moveaxis(own, -1, 0)
    for i in range(nx - 1, -1, -1):
        before = values[i + whole]
        if part > 0:
            # linear between the centres of two elements
            before = before + part * (values[i + whole + 1] - before)
        values[i] = join(before, values[i])
    return np.moveaxis(values[:nx], 0, -1)


def further_along(field: np.ndarray, columns: float, beyond: float | None = 0.0) -> np.ndarray:
    """Values (..., ny, nx) some columns further along x, linear between element centres.

    `beyond` is the value outside the grid; None: as at its end.
    """
    nx = field.shape[-1]
    columns = max(-nx - 1.0, min(nx + 1.0, columns))
    whole = math.floor(columns)
    first = nx + 1 + whole
    padded = np.empty((*field.shape[:-1], 3 * nx + 3), field.dtype)
    padded[..., nx + 1 : 2 * nx + 1] = field
    if beyond is None:
        padded[..., : nx + 1] = field[..., :1]
        padded[..., 2 * nx + 1 :] = field[..., -1:]
    else:
        padded[..., : nx + 1] = beyond
        padded[..., 2 * nx + 1 :] = beyond
    near = padded[..., first : first + nx]
    if columns == whole:
        return near
    far = padded[..., first + 1 : first + 1 + nx]
    return np.asarray(near + (columns - whole) * (far - near))
