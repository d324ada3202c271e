"""Forces by interpolation in a table book of the exact theory.

Source: the table books of Kalker's program CONTACT (USETAB), in variables of
our own.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from varcontact import checks
from varcontact.errors import SceneError
from varcontact.reference.creepage_coefficients import CreepageCoefficients
from varcontact.scene.grid import Grid
from varcontact.theories.linear import (
    Contact,
    Forces,
    Resultants,
    as_resultants,
    checked_contact,
    coefficients_of,
    float_or_array,
)
from varcontact.theories.table_book import TableBook, reduced_scales, shipped

OUTSIDE = ("refuse", "clamp")
NU_TOL = 0.01
"""Tolerance on the Poisson's ratio of a contact, against that of a book: coefficients change by
less than 1 % over it."""


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
        ``f Fz``, the most that friction can carry [force]; broadcasts with the
        leading shape of `creepages`.
    creepages : array_like, shape (..., 3)
        vx, vy [-] and spin [1/length].
    nu : float, optional
        Combined Poisson's ratio of the bodies, to be held against that of the
        book.
    book : TableBook, optional
        Table book; by default that of the package (nu = 0.28).
    outside : {"refuse", "clamp"}
        What becomes of an a/b outside the book: an error, or the forces at the
        nearest a/b it has.

    Returns
    -------
    Resultants
        Force (..., 2) and moment (...) on body 1.

    Raises
    ------
    SceneError
        If a/b is outside the book, nu is not its, or a number is not finite, or
        not positive where it must be.

    Notes
    -----
    The variables are those of `TableBook`. The slope at the origin is that of `linear_forces` with
    the coefficients of `no_slip_coefficients`, and infinite creepage gives the forces of full slip.
    The force never exceeds ``f Fz``: it is cut there.

    Examples
    --------
    >>> creepages = [[1e-3, 0.0, 0.0], [1.0, 0.0, 0.0]]
    >>> force = table_forces(6e-3, 4e-3, 82e9, 30e3, creepages, nu=0.28).force
    >>> print((force[:, 0] / 30e3).round(2))
    [-0.28 -1.  ]
    """
    book = book_of(book)
    if nu is not None:
        check_nu(book, checks.number("nu", nu))
    contact = checked_contact(a, b, G, friction_force, creepages, nu=book.nu)
    return as_resultants(table_resultants(contact, book, outside))


def table_resultants(c: Contact, book: TableBook | None = None, outside: str = "refuse") -> Forces:
    """Fx, Fy and Mz of `table_forces`."""
    book = book_of(book)
    check_nu(book, c.nu)
    clamps = checks.choice("outside", outside, OUTSIDE) == "clamp"
    ratio = _ratio_in_book(book, c.a / c.b, clamps)
    table = c.table
    if table is None or clamps:
        table = coefficients_of(ratio, c.nu, c.slope)
    # reduced creepages
    ab = c.a * c.b
    limit = c.limit
    size = ab**0.5
    unit = c.G * ab / limit
    by_x, by_y, by_spin = reduced_scales(table, ratio)
    x = unit * (by_x * c.vx)
    y = unit * (by_y * c.vy)
    z = unit * size * (by_spin * c.spin)
    if isinstance(x, float) and isinstance(y, float) and isinstance(z, float):
        Fx, Fy, Mz = book.normalised(x, y, z, ratio, table)
        return limit * Fx, limit * Fy, limit * size * Mz
    # arrays of one common shape, as vectors
    shape = np.broadcast_shapes(*map(np.shape, (x, y, z)))

    def single_or_each(value: Any) -> Any:
        """A number for all places, or a vector of numbers for each."""
        if np.size(value) == 1:
            return float(np.ravel(value)[0])
        return np.broadcast_to(value, shape).ravel()

    table = CreepageCoefficients(
        C11=single_or_each(table.C11),
        C22=single_or_each(table.C22),
        C23=single_or_each(table.C23),
        C33=single_or_each(table.C33),
    )
    x, y, z = (np.broadcast_to(value, shape).ravel() for value in (x, y, z))
    Fx, Fy, Mz = book.normalised(x, y, z, single_or_each(ratio), table)
    return limit * Fx.reshape(shape), limit * Fy.reshape(shape), limit * size * Mz.reshape(shape)


def _ratio_in_book(book: TableBook, ratio: Any, clamps: bool) -> Any:
    """Ratios a/b within the range of a book: others are refused, or clamped."""
    least, greatest = book.range
    if isinstance(ratio, float) and least <= ratio <= greatest:
        return ratio
    ratios = np.asarray(ratio)
    within = (ratios >= least * (1 - 1e-12)) & (ratios <= greatest * (1 + 1e-12))
    hint = 'outside="clamp" takes the nearest'
    allowed = f"in [{least:.6g}, {greatest:.6g}], the range of the book ({hint})"
    checks.require_all("a/b", ratios, within | clamps, allowed)
    return float_or_array(np.clip(ratios, least, greatest))


def equivalent_ellipse(grid: Grid, pressure: np.ndarray) -> tuple[float, float]:
    """Semi-axes of the ellipse that stands for a contact area of another shape,
    for those who ask for it.

    It has the area of the contact, and its ratio of the second moments about
    its centre, along x and across.

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
    pressures = checks.array("pressure", pressure, shape=grid.shape)
    contact = pressures > 0
    if not contact.any():
        raise SceneError("pressure", float(pressures.max()), "positive somewhere")
    rows, columns = np.nonzero(contact)
    sides = np.array(grid.sides)
    # each is a rectangle
    spread = np.array([grid.x[columns].var(), grid.y[rows].var()]) + sides**2 / 12
    area = contact.sum() * grid.area
    ratio = math.sqrt(spread[0] / spread[1])
    return math.sqrt(area * ratio / math.pi), math.sqrt(area / ratio / math.pi)


def book_of(book: Any) -> TableBook:
    """Table book, checked; the package's own by default."""
    if book is None:
        return shipped()
    return checks.kind("book", book, TableBook, more=", as TableBook.read gives it")


def check_nu(book: TableBook, nu: Any) -> None:
    """Refuse contacts whose Poisson's ratio is not that of the book."""
    if isinstance(nu, float) and abs(nu - book.nu) <= NU_TOL:
        return
    ratios = np.asarray(nu)
    allowed = f"within {NU_TOL:g} of the book's, {book.nu:g}; make a book of your own"
    checks.require_all("nu", ratios, np.abs(ratios - book.nu) <= NU_TOL, allowed)


def why_not_in_book(ratio: float, nu: float) -> str:
    """Reason why the package's book does not cover a contact; empty where it does."""
    book = shipped()
    least, greatest = book.range
    if abs(nu - book.nu) > NU_TOL:
        return (
            f"its book is for nu = {book.nu:g}, and nu is {nu:.4g}; "
            "theories.table_forces takes books for others"
        )
    if not least * (1 - 1e-12) <= ratio <= greatest * (1 + 1e-12):
        return f"its book has a/b from {least:.4g} to {greatest:.4g}, and a/b is {ratio:.4g}"
    return ""
