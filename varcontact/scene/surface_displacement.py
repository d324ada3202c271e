"""Displacements that are prescribed on the surfaces beside the contact (paper, 1.8 and 4.1)."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from typing import Any, get_args

import numpy as np

from varcontact import checks
from varcontact.checks import Checked
from varcontact.errors import SceneError
from varcontact.scene.grid import Grid
from varcontact.scene.surface_load import LoadedBodies, equal_parts, interval, overlap

PARTS = 12
"""Equal parts of a rectangle along x where neither nx nor an array says how many."""


def _if_given(field: str, value: Any, *dimensions: int) -> np.ndarray | None:
    if value is None:
        return None
    return checks.array(field, value, *dimensions)


def _count(field: str, value: Any) -> int | None:
    if value is None:
        return None
    return checks.whole(field, value)


@dataclass(frozen=True, eq=False, kw_only=True)
class SurfaceDisplacement(
    Checked,
    path="displacements",
    x=interval,
    y=interval,
    normal=lambda field, value: _if_given(field, value, 0, 1, 2),
    tangential=lambda field, value: _if_given(field, value, 1, 2, 3),
    body=partial(checks.choice, options=get_args(LoadedBodies)),
    nx=_count,
    ny=_count,
):
    """Displacements that are prescribed on a rectangle beside the contact (paper, 1.8, region A_u):
    a clamp, a glued or pressed-in part, a rigid neighbour.

    The tractions that hold them are unknowns, uniform in each of nx by ny equal parts, whose
    centres have the prescribed displacements; they follow the tractions of the contact. Rectangles
    rest relative to the contact; in rolling they move along with it. In a shift they are displaced
    with it, from bodies without loads; in a history with the first step.

    Parameters
    ----------
    x : pair of float
        Sides of the rectangle along x, from and to [length].
    y : pair of float, optional
        Sides along y [length]; left out in line contact.
    normal : float or array_like, shape (ny, nx), or (nx,) in line contact, optional
        Displacement difference along the normal [length], positive where the surfaces are pushed
        apart, as by a pressure; not given: no pressure acts there.
    tangential : pair of float or array_like, shape (2, ny, nx), or (2, nx), optional
        Displacement differences along x and y, of the upper body relative to the lower one
        [length]; not given: no traction acts there.
    body : {"both", "upper", "lower"}
        The body that is held; of both the difference of their displacements, by tractions that act
        on both.
    nx, ny : int, optional
        Numbers of equal parts: those of arrays, else 12, and as many along y.

    Raises
    ------
    SceneError
        For sides that do not ascend, values that are not finite, shapes that do not fit, or neither
        displacement.

    Examples
    --------
    >>> clamp = SurfaceDisplacement(x=(2.0, 3.0), y=(-0.5, 0.5), normal=0.0, body="lower", nx=8)
    >>> clamp.grid.shape, clamp.components
    ((8, 8), 'z')
    """

    x: tuple[float, float]
    y: tuple[float, float] | None = None
    normal: Any = None
    tangential: Any = None
    body: LoadedBodies = "both"
    nx: int | None = None
    ny: int | None = None

    __repr__ = checks.short_entries

    def __post_init__(self) -> None:
        super().__post_init__()
        if not self.components:
            allowed = "a displacement: normal, tangential or both"
            raise SceneError("displacements.normal", None, allowed)
        if self.tangential is not None and self.tangential.shape[0] != 2:
            shape = self.tangential.shape
            raise checks.wrong_shape("displacements.tangential", shape, "(2,), or (2, ny, nx)")
        if self.y is None and self.ny is not None:
            raise SceneError("displacements.ny", self.ny, "left out without y")
        rows, columns = self._shape
        try:
            self._fields(rows, columns)
        except ValueError:
            words = {"normal": np.shape(self.normal), "tangential": np.shape(self.tangential)}
            allowed = f"numbers, or arrays of {rows} by {columns} parts, (ny, nx)"
            raise SceneError("displacements", words, allowed) from None

    @property
    def components(self) -> str:
        """Components that are prescribed: "xy", "z" or "xyz"."""
        names = {"xy": self.tangential, "z": self.normal}
        return "".join(name for name, given in names.items() if given is not None)

    @property
    def grid(self) -> Grid:
        """The equal parts, as an explicit grid."""
        rows, columns = self._shape
        return equal_parts(self.x, self.y, columns, rows)

    @property
    def displacement(self) -> np.ndarray:
        """Prescribed displacements of the parts by component, shape (components, ny, nx)
        [length].
        """
        return self._fields(*self._shape)

    @property
    def _shape(self) -> tuple[int, int]:
        """Rows and columns of parts."""
        given = [each for each in (self.normal, self._along) if each is not None]
        shapes = [np.atleast_2d(each).shape[-2:] for each in given]
        rows, columns = max(shapes, key=lambda shape: shape[0] * shape[1])
        if (rows, columns) == (1, 1):
            columns = self.nx or PARTS
            rows = self.ny or columns
        if self.y is None:
            rows = 1
        return self.ny or rows, self.nx or columns

    @property
    def _along(self) -> np.ndarray | None:
        """Tangential displacements with a row of parts, (2, ny, nx)."""
        along = self.tangential
        if along is None or along.ndim == 3:
            return along
        return along.reshape(2, 1, -1)

    def _fields(self, rows: int, columns: int) -> np.ndarray:
        parts: list[np.ndarray] = []
        if self._along is not None:
            parts.extend(np.broadcast_to(each, (rows, columns)) for each in self._along)
        if self.normal is not None:
            parts.append(np.broadcast_to(self.normal, (rows, columns)))
        return np.array(parts)

    def overlaps(self, grid: Grid, elements: np.ndarray) -> bool:
        """True where the part lies on one of some elements of a grid.

        Parameters
        ----------
        grid : Grid
        elements : ndarray of bool, shape (ny, nx)
        """
        return overlap(self.grid, np.ones(self._shape, dtype=bool), grid, elements)


def as_displacements(value: Any) -> tuple[SurfaceDisplacement, ...] | None:
    """Prescribed displacements of a scene as a tuple, None without any; one stands for itself."""
    if isinstance(value, SurfaceDisplacement):
        return (value,)
    if value is None:
        return None
    right = isinstance(value, list | tuple)
    if not right or not all(isinstance(each, SurfaceDisplacement) for each in value):
        raise SceneError("displacements", value, "a SurfaceDisplacement, or a list of them")
    return tuple(value) or None
