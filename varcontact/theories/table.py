"""A table book: forces of the exact theory, computed once on a grid of ellipses and creepages, and interpolated.

Source: the table books of Kalker's program CONTACT (USETAB), in variables of our own.
"""

from __future__ import annotations

import math
from functools import lru_cache
from typing import TYPE_CHECKING, Any

import numpy as np

from varcontact import checks
from varcontact.checks import numbers, positive
from varcontact.errors import SceneError
from varcontact.theories.inputs import Resultants, triples
from varcontact.theories.table_book import TableBook, shipped

if TYPE_CHECKING:
    from varcontact.scene.grid import Grid

AT_ONCE = 256
"""Triples that are computed together: with more, memory is asked for anew each time, and a triple takes three times as
long."""
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
    In the variables of `TableBook` forces are polynomials: of the direction, of a bounded map of the magnitude, and of
    log(a/b). The slope at the origin is that of the linear theory, and infinite creepage gives the forces of full slip,
    both at the nodes in a/b. The force never exceeds ``f Fz``: it is cut there.

    Examples
    --------
    >>> force = table_forces(6e-3, 4e-3, 82e9, 30e3, [[1e-3, 0.0, 0.0], [1.0, 0.0, 0.0]], nu=0.28).force
    >>> print((force[:, 0] / 30e3).round(2))
    [-0.23 -1.  ]
    """
    book = shipped() if book is None else book
    if outside not in OUTSIDE:
        checks.choice("outside", outside, OUTSIDE)
    if nu is not None and abs(checks.number("nu", nu) - book.nu) > NEAR:
        raise SceneError("nu", nu, f"within {NEAR:g} of the book's, {book.nu:g}; make a book of your own")
    a, b, G = positive("a", a), positive("b", b), positive("G", G)
    ratio = _ratio(a / b, book, outside)
    creepage = triples(creepages)
    limit = numbers("friction_force", friction_force)
    if limit.size and not limit.min() > 0:
        raise SceneError("friction_force", float(limit.min()), "positive")
    scale, linear, radial = _of_ratio(book, ratio)
    size = math.sqrt(a * b)
    reduced = creepage * (scale * (1.0, 1.0, size)) * (G * a * b)
    reduced = (reduced / limit[..., None] if limit.ndim else reduced / limit).reshape(-1, 3)
    found = np.empty((3, len(reduced)))
    for k in range(0, len(reduced), AT_ONCE):
        found[:, k : k + AT_ONCE] = book.normalised(reduced[k : k + AT_ONCE].T, linear, radial)
    shape = np.broadcast_shapes(creepage.shape[:-1], limit.shape)
    forces = np.moveaxis(found[:2].reshape(2, *shape), 0, -1) * (limit[..., None] if limit.ndim else limit)
    return Resultants(forces, found[2].reshape(shape) * (limit * size))


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
    >>> print(f"{a:.2f} {b:.2f}")
    2.00 1.00
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


def _ratio(ratio: float, book: TableBook, outside: str) -> float:
    least, greatest = book.ratios[0], book.ratios[-1]
    if least * (1 - 1e-12) <= ratio <= greatest * (1 + 1e-12):
        return ratio
    if outside == "refuse":
        allowed = f'in [{least:.6g}, {greatest:.6g}], the range of the book (outside="clamp" takes the nearest)'
        raise SceneError("a/b", ratio, allowed)
    return float(min(max(ratio, least), greatest))


@lru_cache(maxsize=64)
def _of_ratio(book: TableBook, ratio: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    return book.at(ratio)
