"""The potential contact and its division into equal rectangular elements (paper, section 5.1)."""

from __future__ import annotations

from dataclasses import KW_ONLY, dataclass
from functools import partial
from typing import Any, ClassVar, Literal, get_args

import numpy as np

from varcontact.checks import Checked, choice, number, positive, whole
from varcontact.errors import SceneError
from varcontact.system.process import changed

Edge = Literal["centres", "touched", "softened"]
"""Treatments of the elements that are cut by the contact edge, see `Grid`."""
EDGES = get_args(Edge)
Tractions = Literal["constant", "linear", "trigonometric"]
"""Variation of tractions within elements, see `Grid`."""
Cells = tuple[int, int]
"""Equal parts of an element along y and along x."""


Periodic = bool | Literal["x"]
"""Axes along which a grid repeats, see `Grid`."""


def _periodic(field: str, value: Any) -> Periodic:
    if value is True or value is False or value == "x":
        return value
    raise SceneError(field, value, 'True, False or "x"')


@dataclass(frozen=True)
class Grid(
    Checked,
    path="grid",
    nx=whole,
    ny=whole,
    dx=positive,
    dy=positive,
    x0=number,
    y0=number,
    margin=partial(whole, least=0),
    edge=partial(choice, options=EDGES),
    tractions=partial(choice, options=get_args(Tractions)),
    periodic=_periodic,
):
    """The potential contact, divided into ``ny`` rows of ``nx`` equal
    rectangles; in line contact into ``nx`` strips.

    Two forms (the third is the word ``"auto"`` in its place):

    - ``Grid(nx=, ny=)``: so many elements across the bounding box of the contact, with `margin`
      more on every side;
    - ``Grid(nx=, ny=, dx=, dy=, x0=, y0=)``: the lattice itself, ``(x0, y0)`` its lower left
      corner.

    Line contact has no ny, dy, y0: ``Grid(nx=)`` or ``Grid(nx=, dx=, x0=)``.
    Its lattice is one row of unit width along y, so that forces are per unit
    length.

    Parameters
    ----------
    nx, ny : int
        Numbers of elements along x (rolling direction) and y; ny is left out in
        line contact.
    dx, dy : float, optional
        Side lengths of an element [length].
    x0, y0 : float, optional
        Lower left corner of the potential contact [length].
    margin : int, optional
        Elements added on every side in the first form.
    edge : {"centres", "touched", "softened"}
        Which elements that the contact's edge cuts belong to it: those with
        their centre inside, as in CONTACT, with the pressure at the centre; or
        every one that the contact touches, with the pressure averaged over the
        whole element: Hertz's in closed form, any other solved for on equal
        parts of the elements, 3 by 3, in line contact 7. "softened" has the
        second, and elements that are covered in part give way more to their own
        traction: with ``Steady(slip_difference="second-order")`` it is for
        accurate forces on coarse grids, see `Scene.second_order`. "touched" and
        "softened" are for pressures that tractions do not change, and not for
        samples without coordinates.
    tractions : {"constant", "linear", "trigonometric"}
        Course of pressures and tractions: constant in each element, as in CONTACT; or, in line
        contact of half-spaces, linear between the centres of elements (the overlapping triangles of
        Bentall and Johnson), zero from the next centre outside the contact on; or, on a periodic
        grid, trigonometric polynomials, as in spectral codes.
    periodic : bool or "x"
        True: bodies, surface and tractions repeat along x and y, with the explicit grid as their
        period; "x": along x only. In line contact both are the same.

    Raises
    ------
    SceneError
        For lengths that are not positive and finite, or a form that is neither
        of the two.

    Notes
    -----
    With "centres" errors jump from grid to grid, with "touched" they are larger and fall steadily
    with the size of the elements: to be extrapolated. Measured in docs/sampling.md.

    Examples
    --------
    >>> grid = Grid(nx=3, ny=2, dx=0.5, dy=1.0, x0=0.0, y0=-1.0)
    >>> grid.x
    array([0.25, 0.75, 1.25])
    >>> grid.y
    array([-0.5,  0.5])
    >>> Grid(24, 24).shape
    (24, 24)
    >>> Grid(nx=4, dx=0.5, x0=-1.0).shape
    (1, 4)
    """

    _words: ClassVar = {"mx": "nx", "my": "ny", "xl": "x0", "yl": "y0", "n": "nx and ny"}
    nx: int
    ny: int | None = None
    _: KW_ONLY
    dx: float | None = None
    dy: float | None = None
    x0: float | None = None
    y0: float | None = None
    margin: int = 1
    edge: Edge = "centres"
    tractions: Tractions = "constant"
    periodic: Periodic = False

    def __post_init__(self) -> None:
        super().__post_init__()
        names = ["dx", "dy", "x0", "y0"]
        if self.line:
            for name in ("dy", "y0"):
                names.remove(name)
                if getattr(self, name) is not None:
                    raise SceneError(
                        f"grid.{name}",
                        getattr(self, name),
                        "left out: without ny it is line contact, per unit length",
                    )
        if self.linear and not self.line:
            raise SceneError(
                "grid.tractions", self.tractions, '"constant": linear ones are for line contact'
            )
        if self.linear and self.edge != "centres":
            raise SceneError("grid.edge", self.edge, '"centres" with linear tractions')
        missing = [name for name in names if getattr(self, name) is None]
        if missing and len(missing) < len(names):
            raise SceneError(f"grid.{missing[0]}", None, f"given: {', '.join(names)} come together")
        self._check_periodic()

    def _check_periodic(self) -> None:
        """A period is an explicit grid of whole elements."""
        if self.tractions == "trigonometric" and self.periodic is False:
            raise SceneError("grid.tractions", self.tractions, "for grids with periodic=True")
        if self.tractions == "trigonometric" and self.periodic == "x" and not self.line:
            allowed = '"constant": rows do not repeat along y'
            raise SceneError("grid.tractions", self.tractions, allowed)
        if self.periodic is False:
            return
        if not self.explicit:
            raise SceneError("grid.periodic", self.periodic, "of an explicit grid: the period")
        if self.edge != "centres" or self.linear:
            allowed = 'False with grid.edge other than "centres", or linear tractions'
            raise SceneError("grid.periodic", self.periodic, allowed)

    @property
    def line(self) -> bool:
        """True for line contact: no rows."""
        return self.ny is None

    @property
    def linear(self) -> bool:
        """True where tractions are linear between the centres of elements."""
        return self.tractions == "linear"

    @property
    def explicit(self) -> bool:
        """True where the lattice itself is given."""
        return self.dx is not None

    @property
    def rows(self) -> int:
        """Number of rows: ny, or the one of line contact."""
        if self.ny is None:
            return 1
        return self.ny

    def _lattice(self) -> tuple[float, float, float, float]:
        if self.line and self.dx is not None and self.x0 is not None:
            return self.dx, 1.0, self.x0, -0.5
        if self.dx is None or self.dy is None or self.x0 is None or self.y0 is None:
            raise SceneError(
                "grid", self, "explicit, with dx, dy, x0 and y0: only such a grid has positions"
            )
        return self.dx, self.dy, self.x0, self.y0

    @property
    def sides(self) -> tuple[float, float]:
        """(dx, dy), the sides of an element."""
        return self._lattice()[:2]

    @property
    def shape(self) -> tuple[int, int]:
        """(ny, nx), the shape of fields on the grid."""
        return self.rows, self.nx

    @property
    def size(self) -> int:
        """Number of elements."""
        return self.rows * self.nx

    @property
    def area(self) -> float:
        """Area of one element; in line contact that of a strip of unit length."""
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
        return y0 + (np.arange(self.rows) + 0.5) * dy

    @property
    def lines(self) -> tuple[np.ndarray, np.ndarray]:
        """x, shape (nx + 1,), and y, shape (ny + 1,), of the lines that part the elements."""
        dx, dy, x0, y0 = self._lattice()
        return x0 + np.arange(self.nx + 1) * dx, y0 + np.arange(self.rows + 1) * dy

    @property
    def box(self) -> tuple[float, float, float, float]:
        """(left, right, bottom, top) of the potential contact."""
        dx, dy, x0, y0 = self._lattice()
        return x0, x0 + self.nx * dx, y0, y0 + self.rows * dy

    def window(self, left: int, right: int, bottom: int, top: int) -> Grid:
        """Grid on the same lattice from column `left` to before column `right`, from row `bottom`
        to before row `top`.

        Columns and rows beyond the grid (negative numbers) extend it; line contact has no rows to
        choose.
        """
        dx, dy, x0, y0 = self._lattice()
        return self._like(right - left, top - bottom, dx, dy, x0 + left * dx, y0 + bottom * dy)

    def extended(self) -> Grid:
        """Grid with one more element on every side."""
        return self.window(-1, self.nx + 1, -1, self.rows + 1)

    def divided(self, cells: Cells) -> Grid:
        """The lattice of equal parts of the elements, which count by their centres.

        Parameters
        ----------
        cells : tuple of int
            (rows, columns): parts of an element along y and x; one row in line
            contact.

        Returns
        -------
        Grid
            Explicit, in the same unit of length.

        Examples
        --------
        >>> Grid(nx=3, ny=2, dx=0.5, dy=1.0, x0=0.0, y0=-1.0).divided((2, 5)).shape
        (4, 15)
        """
        dx, dy, x0, y0 = self._lattice()
        rows, columns = cells
        parts = self._like(self.nx * columns, self.rows * rows, dx / columns, dy / rows, x0, y0)
        return changed(parts, edge="centres", tractions="constant")

    def scaled(self, length: float) -> Grid:
        """Grid in another unit of length; `length` is that unit in the old one."""
        dx, dy, x0, y0 = self._lattice()
        scaled: dict[str, float] = {"dx": dx / length, "x0": x0 / length}
        if not self.line:
            scaled |= {"dy": dy / length, "y0": y0 / length}
        return changed(self, margin=1, **scaled)

    @property
    def centres(self) -> np.ndarray:
        """x and y of the element centres, (2, ny, nx)."""
        centres = np.empty((2, *self.shape))
        centres[0] = self.x
        centres[1] = self.y[:, None]
        return centres

    def spread(self, box: tuple[float, float, float, float]) -> Grid:
        """The lattice with `nx` by `ny` elements across a `box` (left, right, bottom, top) and the
        margin around it.
        """
        left, right, bottom, top = box
        dx = (right - left) / self.nx
        dy = (top - bottom) / self.rows
        m = self.margin
        return self._like(
            self.nx + 2 * m, self.rows + 2 * m, dx, dy, left - m * dx, bottom - m * dy
        )

    def _like(self, nx: int, ny: int, dx: float, dy: float, x0: float, y0: float) -> Grid:
        """A lattice with the same edge, of which nothing but its numbers needs a check; in line
        contact without rows.
        """
        numbers = {"nx": nx, "ny": ny, "dx": dx, "dy": dy, "x0": x0, "y0": y0}
        tractions: Tractions = "constant"
        if self.line:
            numbers = {"nx": nx, "dx": dx, "x0": x0}
        if self.linear:
            tractions = "linear"
        lattice = {name: self._checks[name](f"grid.{name}", numbers[name]) for name in numbers}
        return changed(self, margin=1, tractions=tractions, periodic=False, **lattice)


def usual_grid(line: bool) -> Grid:
    """The grid of a scene that has none, where it is not chosen for an accuracy: 24 by 24, in line
    contact 100.
    """
    if line:
        return Grid(nx=100)
    return Grid(nx=24, ny=24)
