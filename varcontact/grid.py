"""The potential contact and its division into equal rectangular elements (paper, section 5.1)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from varcontact.checks import number, positive, whole
from varcontact.errors import SceneError


@dataclass(frozen=True, kw_only=True)
class Grid:
    """The potential contact, divided into ``ny`` rows of ``nx`` equal rectangles.

    Two forms (the third is the word ``"auto"`` in its place):

    - ``Grid(nx=, ny=)``: so many elements across the bounding box of the contact, with `margin` more
      on every side;
    - ``Grid(nx=, ny=, dx=, dy=, x0=, y0=)``: the lattice itself, ``(x0, y0)`` its lower left corner.

    Parameters
    ----------
    nx, ny : int
        Numbers of elements along x (rolling direction) and y.
    dx, dy : float, optional
        Side lengths of an element [length].
    x0, y0 : float, optional
        Lower left corner of the potential contact [length].
    margin : int, optional
        Elements added on every side in the first form.

    Raises
    ------
    SceneError
        For lengths that are not positive and finite, or a form that is neither of the two.

    Examples
    --------
    >>> grid = Grid(nx=3, ny=2, dx=0.5, dy=1.0, x0=0.0, y0=-1.0)
    >>> grid.x
    array([0.25, 0.75, 1.25])
    >>> grid.y
    array([-0.5,  0.5])
    """

    nx: int
    ny: int
    dx: float | None = None
    dy: float | None = None
    x0: float | None = None
    y0: float | None = None
    margin: int = 1

    def __post_init__(self) -> None:
        set_ = object.__setattr__
        set_(self, "nx", whole("grid.nx", self.nx))
        set_(self, "ny", whole("grid.ny", self.ny))
        set_(self, "margin", whole("grid.margin", self.margin, least=0))
        lattice = {name: getattr(self, name) for name in ("dx", "dy", "x0", "y0")}
        missing = [name for name, value in lattice.items() if value is None]
        if len(missing) == 4:
            return
        if missing:
            raise SceneError(f"grid.{missing[0]}", None, "given, as dx, dy, x0 and y0 come together")
        for name in ("dx", "dy"):
            set_(self, name, positive(f"grid.{name}", lattice[name]))
        for name in ("x0", "y0"):
            set_(self, name, number(f"grid.{name}", lattice[name]))

    @property
    def explicit(self) -> bool:
        """Whether the lattice itself is given."""
        return self.dx is not None

    def _lattice(self) -> tuple[float, float, float, float]:
        if self.dx is None or self.dy is None or self.x0 is None or self.y0 is None:
            raise SceneError("grid", self, "an explicit lattice (dx, dy, x0, y0) where its elements are asked for")
        return self.dx, self.dy, self.x0, self.y0

    @property
    def sides(self) -> tuple[float, float]:
        """(dx, dy), the sides of an element."""
        return self._lattice()[:2]

    @property
    def shape(self) -> tuple[int, int]:
        """(ny, nx), the shape of fields on the grid."""
        return self.ny, self.nx

    @property
    def area(self) -> float:
        """Area of one element."""
        dx, dy, _, _ = self._lattice()
        return dx * dy

    @property
    def x(self) -> np.ndarray:
        """x of the element centres, shape (nx,)."""
        dx, _, x0, _ = self._lattice()
        return x0 + (np.arange(self.nx) + 0.5) * dx

    @property
    def y(self) -> np.ndarray:
        """y of the element centres, shape (ny,)."""
        _, dy, _, y0 = self._lattice()
        return y0 + (np.arange(self.ny) + 0.5) * dy

    @property
    def box(self) -> tuple[float, float, float, float]:
        """(left, right, bottom, top) of the potential contact."""
        dx, dy, x0, y0 = self._lattice()
        return x0, x0 + self.nx * dx, y0, y0 + self.ny * dy

    def extended(self, left: int = 1, right: int = 1, bottom: int = 1, top: int = 1) -> Grid:
        """The same lattice with more elements around it."""
        dx, dy, x0, y0 = self._lattice()
        return Grid(
            nx=self.nx + left + right, ny=self.ny + bottom + top, dx=dx, dy=dy, x0=x0 - left * dx, y0=y0 - bottom * dy
        )

    def spread(self, box: tuple[float, float, float, float]) -> Grid:
        """The lattice with `nx` by `ny` elements across a box (left, right, bottom, top), and the margin."""
        left, right, bottom, top = box
        dx, dy, m = (right - left) / self.nx, (top - bottom) / self.ny, self.margin
        return Grid(nx=self.nx + 2 * m, ny=self.ny + 2 * m, dx=dx, dy=dy, x0=left - m * dx, y0=bottom - m * dy)
