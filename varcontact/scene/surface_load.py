"""Loads on the surfaces beside the contact (paper, 1.8): tractions that are prescribed there."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import partial
from typing import Any, Literal, get_args

import numpy as np

from varcontact import checks
from varcontact.checks import Checked
from varcontact.errors import SceneError
from varcontact.scene.grid import Grid

LoadedBodies = Literal["both", "upper", "lower"]
"""Bodies on which a load acts."""


def interval(field: str, value: Any) -> tuple[float, float]:
    """Two ascending coordinates."""
    ends = checks.array(field, value, shape=(2,), meant="of two numbers, from and to")
    if ends[1] <= ends[0]:
        raise SceneError(field, tuple(ends.tolist()), "two ascending numbers, from and to")
    return float(ends[0]), float(ends[1])


@dataclass(frozen=True, eq=False, kw_only=True)
class SurfaceLoad(
    Checked,
    path="loads",
    x=interval,
    y=interval,
    pressure=lambda field, value: checks.array(field, value, 0, 1, 2),
    traction=lambda field, value: checks.array(field, value, 1, 2, 3),
    body=partial(checks.choice, options=get_args(LoadedBodies)),
):
    """Tractions that are prescribed on a rectangle beside the contact (paper, 1.8): a second
    contact, a jack, a strain field of a neighbour.

    They stay where they are relative to the contact: in rolling they move along with it. Their
    displacements change the undeformed distance and the slip. In a shift they are applied with it,
    from bodies without loads; in a history with the first step, and between steps their increments
    count.

    Parameters
    ----------
    x : pair of float
        Sides of the rectangle along x, from and to [length].
    y : pair of float, optional
        Sides along y [length]; left out in line contact.
    pressure : float or array_like, shape (ny, nx), or (nx,) in line contact
        Pressure [force/area], positive where it compresses; uniform, or one value for each of ny
        by nx equal parts of the rectangle, indexed [iy, ix].
    traction : pair of float or array_like, shape (2, ny, nx), or (2, nx) in line contact
        Tractions along x and y as of a contact: on the upper body, and the opposite on the lower
        one [force/area].
    body : {"both", "upper", "lower"}
        Bodies on which it acts.

    Raises
    ------
    SceneError
        For sides that do not ascend, values that are not finite, or shapes that do not fit.

    Examples
    --------
    >>> load = SurfaceLoad(x=(2.0, 3.0), y=(-0.5, 0.5), pressure=4.0)
    >>> load.force
    (0.0, 0.0, 4.0)
    """

    x: tuple[float, float]
    y: tuple[float, float] | None = None
    pressure: Any = 0.0
    traction: Any = (0.0, 0.0)
    body: LoadedBodies = "both"

    __repr__ = checks.short_entries

    def __post_init__(self) -> None:
        super().__post_init__()
        shapes = self.pressure.shape, self.traction.shape
        if self.traction.shape[0] != 2:
            raise checks.wrong_shape("loads.traction", shapes[1], "(2,), or (2, ny, nx)")
        try:
            parts = self.parts
        except ValueError:
            words = f"pressure {shapes[0]}, traction {shapes[1]}"
            raise SceneError("loads", words, "numbers, or arrays of the same parts") from None
        if self.y is None and parts.shape[1] != 1:
            raise checks.wrong_shape("loads.pressure", parts.shape[1:], "(nx,) without y")

    @property
    def parts(self) -> np.ndarray:
        """Tractions along x and y and pressures of the equal parts, shape (3, ny, nx)."""
        pressure = np.atleast_2d(self.pressure)
        traction = self.traction
        if traction.ndim < 3:
            traction = traction.reshape(2, 1, -1)
        pressure, along_x, along_y = np.broadcast_arrays(pressure, *traction)
        return np.array([along_x, along_y, pressure])

    @property
    def grid(self) -> Grid:
        """The equal parts, as an explicit grid."""
        _, ny, nx = self.parts.shape
        return equal_parts(self.x, self.y, nx, ny)

    @property
    def force(self) -> tuple[float, float, float]:
        """Fx, Fy and normal force [force]; in line contact [force/length]."""
        total = self.parts.sum(axis=(1, 2)) * self.grid.area
        return float(total[0]), float(total[1]), float(total[2])

    @property
    def loaded(self) -> np.ndarray:
        """True for parts with any traction, (ny, nx)."""
        return np.asarray(self.parts.any(axis=0))

    def acts(self, *directions: int) -> bool:
        """True for a load with tractions along some of these directions.

        Parameters
        ----------
        *directions : int
            0: x, 1: y, 2: normal.
        """
        return bool(self.parts[list(directions)].any())

    @property
    def acts_alone(self) -> bool:
        """True where only one body is loaded: then pressures cause shifts, and tractions change the
        distance.
        """
        return self.body != "both" and bool(self.loaded.any())

    def overlaps(self, grid: Grid, elements: np.ndarray) -> bool:
        """True where a part with any traction lies on one of some elements.

        Parameters
        ----------
        grid : Grid
        elements : ndarray of bool, shape (ny, nx)
        """
        return overlap(self.grid, self.loaded, grid, elements)


def equal_parts(x: tuple[float, float], y: tuple[float, float] | None, nx: int, ny: int) -> Grid:
    """The grid of nx by ny equal parts of a rectangle; without y those of a line contact."""
    left, right = x
    grid = Grid(nx=nx, dx=(right - left) / nx, x0=left)
    if y is None:
        return grid
    bottom, top = y
    return replace(grid, ny=ny, dy=(top - bottom) / ny, y0=bottom)


def overlap(one: Grid, of_one: np.ndarray, other: Grid, of_other: np.ndarray) -> bool:
    """True where some elements (ny, nx) of a grid lie on some of another one."""
    return bool(np.any(of_other & covered(other, one, of_one)))


def covered(grid: Grid, other: Grid, of_other: np.ndarray) -> np.ndarray:
    """True for elements (ny, nx) of a grid that lie on some elements of another one."""
    x, y = grid.lines
    other_x, other_y = other.lines
    on_rows = of_other
    if not grid.line:
        on_rows = _common(y, other_y) @ of_other
    return np.asarray(on_rows @ _common(x, other_x).T > 0)


def _common(edges: np.ndarray, others: np.ndarray) -> np.ndarray:
    """True where intervals between edges (n + 1,) and others (m + 1,) overlap, (n, m); but for
    rounding.
    """
    rounding = 1e-9 * (np.ptp(edges) + np.ptp(others))
    begin = np.maximum(edges[:-1, None], others[None, :-1])
    end = np.minimum(edges[1:, None], others[None, 1:])
    return (end - begin) > rounding


def as_loads(value: Any) -> tuple[SurfaceLoad, ...] | None:
    """Loads of a scene as a tuple, None without any; one stands for itself."""
    if isinstance(value, SurfaceLoad):
        return (value,)
    if value is None:
        return None
    if not isinstance(value, list | tuple) or not all(isinstance(e, SurfaceLoad) for e in value):
        raise SceneError("loads", value, "a SurfaceLoad, or a list of them")
    return tuple(value) or None
