"""A table book: forces of the exact theory, computed once on a grid of ellipses and creepages, and interpolated.

Source: the table books of Kalker's program CONTACT (USETAB), in variables of our own.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, NoReturn

import numpy as np

from varcontact import checks
from varcontact.checks import positive
from varcontact.errors import SceneError
from varcontact.reference.creepage_coefficients import CreepageCoefficients, no_slip_coefficients
from varcontact.theories.inputs import Resultants, triples
from varcontact.theories.table_book import TableBook, shipped
from varcontact.theories.table_nodes import scales

if TYPE_CHECKING:
    from varcontact.scene.grid import Grid

OUTSIDE = ("refuse", "clamp")


def table_forces(
    a: float,
    b: float,
    G: float,
    friction_force: Any,
    creepages: Any,
    *,
    nu: float | None = None,
    book: TableBook | None = None,
    outside: str = "refuse",
) -> Resultants:
    """Forces and moment by interpolation in a table of exact solutions.

    Parameters
    ----------
    a, b : float
        Semi-axes along the rolling direction and across it [length].
    G : float
        Combined modulus of rigidity [force/area].
    friction_force : float or array_like
        ``f Fz``, the most that friction can carry [force]; broadcasts with the leading shape of `creepages`.
    creepages : array_like, shape (..., 3)
        vx, vy [-] and spin [1/length].
    nu : float, optional
        Combined Poisson's ratio of the bodies, to be held against that of the book.
    book : TableBook, optional
        That of the package (nu = 0.28), if none is given.
    outside : {"refuse", "clamp"}
        What becomes of an a/b outside the book: an error, or the forces at the nearest a/b it has.

    Returns
    -------
    Resultants
        Force (..., 2) and moment (...) on body 1.

    Raises
    ------
    SceneError
        If a/b is outside the book, nu is not its, or a number is not finite, or not positive where it must be. Of
        several creepages the error has the place of the first.

    Notes
    -----
    The variables are those of `TableBook`. The slope at the origin is that of `linear_forces` with the coefficients of
    `no_slip_coefficients`, and infinite creepage gives the forces of full slip. The force never exceeds ``f Fz``: it is
    cut there.

    Examples
    --------
    >>> force = table_forces(6e-3, 4e-3, 82e9, 30e3, [[1e-3, 0.0, 0.0], [1.0, 0.0, 0.0]], nu=0.28).force
    >>> print((force[:, 0] / 30e3).round(2))
    [-0.28 -1.  ]
    """
    book = book_of(book)
    if outside not in OUTSIDE:
        checks.choice("outside", outside, OUTSIDE)
    if nu is not None:
        check_nu(book, checks.number("nu", nu))
    a, b, G = positive("a", a), positive("b", b), positive("G", G)
    ratio = _ratio(a / b, book, outside)
    creepage = triples(creepages)
    limit = _limit(friction_force)
    if creepage.ndim > 1:
        checks.broadcasting({"friction_force": limit, "vx": creepage[..., 0]})
    size, unit = math.sqrt(a * b), G * a * b / limit
    apart = creepage.tolist() if creepage.ndim == 1 else np.moveaxis(creepage, -1, 0)
    Fx, Fy, Mz = interpolated(book, ratio, size, unit, apart)
    force = np.empty((*np.shape(Fx), 2))
    force[..., 0], force[..., 1] = limit * Fx, limit * Fy
    return Resultants(force, limit * size * Mz)


def book_of(book: Any) -> TableBook:
    """The book that is asked for, or that of the package.

    Parameters
    ----------
    book : TableBook or None
    """
    if book is None:
        return shipped()
    if not isinstance(book, TableBook):
        raise SceneError("book", book, "a TableBook, as TableBook.read gives it")
    return book


def _limit(friction_force: Any) -> Any:
    """f Fz, checked: a float or an array."""
    if type(friction_force) is float and 0 < friction_force <= checks.LARGE:
        return friction_force
    limit = checks.positives("friction_force", friction_force, "positive")
    return limit if limit.ndim else float(limit)


def interpolated(
    book: TableBook, ratio: Any, size: Any, unit: Any, creepages: Any, coefficients: CreepageCoefficients | None = None
) -> tuple[Any, ...]:
    """Normalised forces in the shape of all arguments, which broadcast.

    Parameters
    ----------
    book : TableBook
    ratio : float or ndarray
        a/b, within the book.
    size : float or ndarray
        sqrt(ab) [length].
    unit : float or ndarray
        G ab / (f Fz).
    creepages : sequence of three floats or ndarrays
        vx, vy, spin.
    coefficients : CreepageCoefficients, optional
        Those that give the slopes, if not the ratio's own.

    Returns
    -------
    tuple of three floats or ndarrays
        Fx, Fy, Mz.
    """
    C = no_slip_coefficients(ratio, book.nu) if coefficients is None else coefficients
    x, y, z = (scale * creepage for scale, creepage in zip(scales(C, ratio), creepages, strict=True))
    x, y, z = unit * x, unit * y, unit * size * z
    if isinstance(x, float) and isinstance(y, float) and isinstance(z, float):
        return book.normalised(x, y, z, ratio, C)
    shape = np.broadcast_shapes(*map(np.shape, (x, y, z)))

    def each(value: Any) -> Any:
        """One for each place, or one for all."""
        return float(np.ravel(value)[0]) if np.size(value) == 1 else np.broadcast_to(value, shape).ravel()

    C = CreepageCoefficients(*map(each, (C.C11, C.C22, C.C23, C.C33)))
    x, y, z = (np.broadcast_to(value, shape).ravel() for value in (x, y, z))
    ratio = each(ratio)
    return tuple(part.reshape(shape) for part in book.normalised(x, y, z, ratio, C))


def equivalent_ellipse(grid: Grid, pressure: np.ndarray) -> tuple[float, float]:
    """Semi-axes of the ellipse that stands for a contact area of another shape, for those who ask for it.

    It has the area of the contact, and its ratio of the second moments about its centre, along x and across.

    Parameters
    ----------
    grid : Grid
        Explicit, as `Solution.grid`.
    pressure : array_like, shape (ny, nx)
        Positive in contact.

    Returns
    -------
    a, b : float
        Along the rolling direction and across it [length].

    Raises
    ------
    SceneError
        If the pressure is not of the grid's shape, or contact is nowhere.

    Examples
    --------
    >>> import varcontact as vc
    >>> sol = vc.solve(vc.Scene(
    ...     bodies=vc.Bodies(G=1.0, nu=0.28), surface=vc.Ellipse(a=2.0, b=1.0), normal_force=1.0,
    ...     grid=vc.Grid(nx=40, ny=40)))
    >>> a, b = equivalent_ellipse(sol.grid, sol.pressure)
    >>> print(f"{a:.1f} {b:.1f}")
    2.0 1.0
    """
    pressures = checks.array("pressure", pressure, 2)
    if pressures.shape != grid.shape:
        raise checks.wrong_shape("pressure", pressures.shape, f"of shape {grid.shape}")
    contact = pressures > 0
    if not contact.any():
        raise SceneError("pressure", float(pressures.max()), "positive somewhere")
    rows, columns = np.nonzero(contact)
    sides = np.array(grid.sides)
    spread = [
        grid.x[columns].var() + sides[0] ** 2 / 12,
        grid.y[rows].var() + sides[1] ** 2 / 12,
    ]  # each is a rectangle
    area, ratio = contact.sum() * grid.area, math.sqrt(spread[0] / spread[1])
    return math.sqrt(area * ratio / math.pi), math.sqrt(area / ratio / math.pi)


NEAR = 0.01
"""How far the Poisson's ratio of a contact may be from that of a book: coefficients change by less than 1 % over it."""


def check_nu(book: TableBook, nu: Any) -> None:
    """Refuse a contact whose Poisson's ratio is not that of the book.

    Parameters
    ----------
    book : TableBook
    nu : float or ndarray
    """
    if isinstance(nu, float) and abs(nu - book.nu) <= NEAR:
        return
    far = np.abs(np.asarray(nu) - book.nu) > NEAR
    if far.any():
        _refuse("nu", nu, far, f"within {NEAR:g} of the book's, {book.nu:g}; make a book of your own")


def check_ratio(book: TableBook, ratio: Any) -> None:
    """Refuse a contact whose ellipse is outside the book.

    Parameters
    ----------
    book : TableBook
    ratio : float or ndarray
        a/b.
    """
    least, greatest = book.range
    if isinstance(ratio, float) and least <= ratio <= greatest:
        return
    out = (np.asarray(ratio) < least * (1 - 1e-12)) | (np.asarray(ratio) > greatest * (1 + 1e-12))
    if out.any():
        hint = 'outside="clamp" takes the nearest'
        _refuse("a/b", ratio, out, f"in [{least:.6g}, {greatest:.6g}], the range of the book ({hint})")


def _refuse(field: str, values: Any, bad: np.ndarray, allowed: str) -> NoReturn:
    """Raise the error of the first bad value, by its index where there are several."""
    where = tuple(int(i) for i in np.argwhere(bad)[0])
    raise SceneError(f"{field}{list(where)}" if where else field, float(np.asarray(values)[where]), allowed)


def _ratio(ratio: float, book: TableBook, outside: str) -> float:
    least, greatest = book.range
    if outside == "refuse":
        check_ratio(book, ratio)
    return min(max(ratio, least), greatest)
