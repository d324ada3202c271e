"""A table book: forces of the exact theory, computed once for ellipses and creepages, and interpolated.

Source: the table books of Kalker's program CONTACT (USETAB), in variables of our own.
"""

from __future__ import annotations

import hashlib
import math
from dataclasses import dataclass
from functools import cache, cached_property, lru_cache
from importlib.resources import as_file, files
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING, Any, NoReturn

import numpy as np
from scipy.interpolate import BSpline, NdBSpline

from varcontact import checks
from varcontact.errors import OutputError, SceneError
from varcontact.reference.creepage_coefficients import CreepageCoefficients, no_slip_coefficients
from varcontact.system.reading import reading
from varcontact.theories.linear import Resultants, creepage_triples

if TYPE_CHECKING:
    from varcontact.scene.grid import Grid

FORMAT = "varcontact table 3"
OUTSIDE = ("refuse", "clamp")
NEAR = 0.01
"""How far the Poisson's ratio of a contact may be from that of a book: coefficients change by less than 1 % over it."""
AT_FULL, MORE = 3, 2.0**15
"""B-splines of t that are not zero at full slip, and by what part finer than the others a file has them."""
FEW = 64
"""Creepages of one ratio, up to which it does not pay to make the splines of that ratio first."""
HALFWAY = 1.5
"""The magnitude that is half of the way to full slip: Vermeulen and Johnson's line ends at 3, their full slip."""
KNEE, ROOM = 1.8, 0.35
"""A magnitude about which full slip begins, and what part of the way to full slip is kept for those about it."""
SPIN = 0.5
"""Spin counts by this part of the slip that it makes a distance sqrt(a^2 + b^2) away."""
TINY = 1e-200


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
        If a/b is outside the book, nu is not its, or a number is not finite, or not positive where it must be.

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
    if nu is not None:
        check_nu(book, checks.number("nu", nu))
    a, b, G = checks.positive("a", a), checks.positive("b", b), checks.positive("G", G)
    ratio = ratio_in_book(book, a / b, outside)
    creepage = creepage_triples(creepages)
    limit = checks.positives("friction_force", friction_force, "positive")
    checks.broadcasting({"friction_force": limit, "vx": creepage[..., 0]})
    size = math.sqrt(a * b)
    coefficients = no_slip_coefficients(ratio, book.nu)
    Fx, Fy, Mz = interpolated(book, ratio, size, G * a * b / limit, np.moveaxis(creepage, -1, 0), coefficients)
    return Resultants(np.stack([limit * Fx, limit * Fy], axis=-1), np.asarray(limit * size * Mz))


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


def book_of(book: Any) -> TableBook:
    """The book that is asked for, or that of the package."""
    if book is None:
        return shipped()
    if not isinstance(book, TableBook):
        raise SceneError("book", book, "a TableBook, as TableBook.read gives it")
    return book


def check_nu(book: TableBook, nu: Any) -> None:
    """Refuse contacts whose Poisson's ratio is not that of the book."""
    far = np.abs(np.asarray(nu) - book.nu) > NEAR
    if far.any():
        _refuse("nu", nu, far, f"within {NEAR:g} of the book's, {book.nu:g}; make a book of your own")


def ratio_in_book(book: TableBook, ratio: Any, outside: str) -> Any:
    """a/b within the book; elsewhere an error, or the nearest that it has."""
    least, greatest = book.range
    if isinstance(ratio, float) and least <= ratio <= greatest and outside in OUTSIDE:
        return ratio
    if checks.choice("outside", outside, OUTSIDE) == "refuse":
        out = (np.asarray(ratio) < least * (1 - 1e-12)) | (np.asarray(ratio) > greatest * (1 + 1e-12))
        if out.any():
            hint = 'outside="clamp" takes the nearest'
            _refuse("a/b", ratio, out, f"in [{least:.6g}, {greatest:.6g}], the range of the book ({hint})")
    inside = np.clip(ratio, least, greatest)
    return inside if np.ndim(ratio) else float(inside)


def _refuse(field: str, values: Any, bad: np.ndarray, allowed: str) -> NoReturn:
    """The error of the first bad value, by its index where there are several."""
    where = tuple(int(i) for i in np.argwhere(bad)[0])
    raise SceneError(f"{field}{list(where)}" if where else field, float(np.asarray(values)[where]), allowed)


def why_not_in_book(ratio: float, nu: float) -> str:
    """Why the book of the package does not serve a contact, or nothing where it does."""
    book = shipped()
    least, greatest = book.range
    if abs(nu - book.nu) > NEAR:
        return f"its book is for nu = {book.nu:g}, and nu is {nu:.4g}; theories.table_forces takes books for others"
    if not least * (1 - 1e-12) <= ratio <= greatest * (1 + 1e-12):
        return f"its book has a/b from {least:.4g} to {greatest:.4g}, and a/b is {ratio:.4g}"
    return ""


def interpolated(
    book: TableBook, ratio: Any, size: Any, unit: Any, creepages: Any, coefficients: CreepageCoefficients
) -> tuple[Any, Any, Any]:
    """Normalised Fx, Fy and Mz in the shape of all arguments, which broadcast.

    `size` is sqrt(ab), `unit` is G ab / (f Fz), `creepages` are vx, vy and spin.
    """
    C = coefficients
    scale_x, scale_y, scale_z = reduced_scales(C, ratio)
    vx, vy, spin = creepages
    x, y, z = np.broadcast_arrays(unit * (scale_x * vx), unit * (scale_y * vy), unit * size * (scale_z * spin))
    shape = x.shape

    def each(value: Any) -> Any:
        """One for each place, or one for all."""
        return float(np.ravel(value)[0]) if np.size(value) == 1 else np.broadcast_to(value, shape).ravel()

    C = CreepageCoefficients(*map(each, (C.C11, C.C22, C.C23, C.C33)))
    Fx, Fy, Mz = book.normalised(x.ravel(), y.ravel(), z.ravel(), each(ratio), C)
    return Fx.reshape(shape), Fy.reshape(shape), Mz.reshape(shape)


def reduced_scales(coefficients: CreepageCoefficients, ratio: Any) -> tuple[Any, Any, Any]:
    """Scales of vx, vy and spin times sqrt(ab) in the reduced creepage, but for G ab / (f Fz)."""
    C = coefficients
    return C.C11, C.C22, SPIN * C.C11 * (ratio + 1 / ratio) ** 0.5


def linear_part(x: Any, y: Any, z: Any, ratio: Any, coefficients: CreepageCoefficients) -> tuple[Any, Any, Any]:
    """Normalised Fx, Fy and Mz of the linear theory for reduced creepages along vx, vy and the spin."""
    C, by_spin = coefficients, reduced_scales(coefficients, ratio)[2]
    return -x, -y - (C.C23 / by_spin) * z, (C.C23 / C.C22) * y - (C.C33 / by_spin) * z


def places(t: Any) -> Any:
    """Where ``t = r/(r + 1.5)`` of a magnitude r stands among the splines, from 0, no slip, to 1, full slip.

    It has more room than t for the magnitudes about `KNEE`, where full slip begins.
    """
    rest = (1 - t) * (KNEE / HALFWAY)
    cube = t * t * t
    return t + ROOM * (cube / (cube + rest * rest * rest) - t)


@dataclass(frozen=True, eq=False)
class TableBook:
    """Forces of the exact theory for ellipses and creepages, of one Poisson's ratio.

    With ``c = sqrt(ab)`` the reduced creepage is ``u = G ab / (f Fz) (C11 vx, C22 vy, C11 R spin)``, where
    ``R = sqrt(a^2 + b^2)/2``: a magnitude ``|u|`` and a direction. Forces are in parts of ``f Fz``, the moment of
    ``f Fz c``. By symmetry Fx is odd in vx and even in (vy, spin), Fy and Mz are the other way round: the directions
    with vx >= 0 and half of the (vy, spin) stand for all. Magnitudes are ``1.5 t/(1 - t)`` at points of t in (0, 1),
    equal steps of `places`; t = 0 is the linear theory, t = 1 full slip. The ratios are Chebyshev's points in log(a/b).

    With the linear theory's forces L(u), what is interpolated is S in ``F = (1 - t)^2 L(u) + t^2 S``: by cubic splines
    in log(a/b), in the place of t (see `places`), and in the two angles of the direction (that from vx, and that of
    (vy, spin)).

    Attributes
    ----------
    nu : float
        Combined Poisson's ratio.
    ratios : ndarray, shape (r,)
        a/b, ascending.
    directions : ndarray, shape (d, 3)
        Of reduced creepage, unit vectors.
    values : ndarray, shape (r, m, d, 3)
        Fx, Fy, Mz of the entries, normalised, by ratio, magnitude and direction.
    accuracy : ndarray, shape (r, m, d)
        Estimated error of each entry, in parts of f Fz.
    splines : ndarray, shape (h, i, j, k, 3)
        Coefficients of the B-splines of S.
    provenance : str
        How it was made.
    """

    nu: float
    ratios: np.ndarray
    directions: np.ndarray
    values: np.ndarray
    accuracy: np.ndarray
    splines: np.ndarray
    provenance: str

    def normalised(
        self, x: np.ndarray, y: np.ndarray, z: np.ndarray, ratio: Any, coefficients: CreepageCoefficients
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Normalised Fx, Fy and Mz for reduced creepages (n,) along vx, vy and the spin; the force is cut at f Fz.

        The ratio a/b and its coefficients are one for all, or (n,).
        """
        linear = linear_part(x, y, z, ratio, coefficients)
        across = y * y + z * z
        rest = HALFWAY / (np.sqrt(x * x + across) + HALFWAY)
        t, angle = 1 - rest, np.arctan2(z, y)
        other = (angle < 0) | (angle >= math.pi)
        half_turn = angle * (1 / math.pi) + (angle < 0) - (angle >= math.pi)
        polar = np.arctan2(np.sqrt(across), np.abs(x)) * (2 / math.pi)
        at = np.stack([places(t), polar, half_turn], axis=-1) * (np.array(self.splines.shape[1:4]) - 3)
        if isinstance(ratio, float) and len(x) > FEW:
            S = _splines_of(self, ratio)(at)
        else:
            S = self._spline(np.column_stack([np.broadcast_to(self._place(ratio), x.shape), at]))
        tt, rr, along, turn = t * t, rest * rest, 1 - 2 * (x < 0), 1 - 2 * other
        Fx = along * tt * S[:, 0] + rr * linear[0]
        Fy = turn * tt * S[:, 1] + rr * linear[1]
        Mz = turn * tt * S[:, 2] + rr * linear[2]
        cut = np.maximum(np.sqrt(Fx * Fx + Fy * Fy), 1.0)
        return Fx / cut, Fy / cut, Mz

    def _place(self, ratio: Any) -> Any:
        """Where a/b stands among the splines."""
        least, greatest = self.range
        return np.log(ratio / least) * ((len(self.splines) - 3) / math.log(greatest / least))

    @cached_property
    def _spline(self) -> NdBSpline:
        return _spline_of(self.splines)

    @cached_property
    def range(self) -> tuple[float, float]:
        """The least and the greatest a/b."""
        return float(self.ratios[0]), float(self.ratios[-1])

    @property
    def entries(self) -> int:
        """How many exact solutions it holds."""
        return int(self.accuracy.size)

    def to_bytes(self) -> bytes:
        """The book as a netCDF file."""
        from scipy.io import netcdf_file

        buffer = BytesIO()
        file = netcdf_file(buffer, "w", version=2)
        file.format, file.nu, file.provenance, file.digest = FORMAT, repr(self.nu), self.provenance, self._digest()
        names = ("ratio", "magnitude", "direction", "component", *_SPLINE, "spline at full slip")
        for name, size in zip(names, (*self.values.shape, *self.splines.shape[:4], AT_FULL), strict=True):
            file.createDimension(name, size)
        for name, (kind, dims, words) in _VARIABLES.items():
            variable = file.createVariable(name, kind, dims)
            variable[:], variable.long_name = self._packed(name), words
        file.flush()
        return buffer.getvalue()

    @classmethod
    def read(cls, path: str | Path) -> TableBook:
        """A book from its file.

        Parameters
        ----------
        path : str or Path

        Raises
        ------
        SceneError
            If the path is no name of a file.
        OutputError
            If the file is not there, is damaged, or is no book of this version.
        """
        from scipy.io import netcdf_file

        path = checks.file_name("path", path)
        with reading(path, "cannot be read as a table book"):
            if not path.exists():
                raise OutputError("path", path, "there is no such file")
            with netcdf_file(path, "r", mmap=False) as file:
                found = getattr(file, "format", b"").decode()
                if found == FORMAT:
                    arrays = {name: np.array(file.variables[name][:], dtype=float) for name in _VARIABLES}
                    arrays["splines"] = unpacked(*(arrays.pop(name) for name in _PACKED))
                    book = cls(nu=float(file.nu), provenance=file.provenance.decode(), **arrays)
                    whole = book._digest() == file.digest.decode()
        if found != FORMAT:
            kind = f"a {found!r} file" if found else "another netCDF file"
            raise OutputError("path", path, f"is {kind}, not a {FORMAT!r} one; make the book anew")
        if not whole:
            raise OutputError("path", path, "is damaged: its numbers are not those that were written")
        return book

    def _packed(self, name: str) -> np.ndarray:
        """A variable as the file has it."""
        array = packed(self.splines)[name] if name in _PACKED else getattr(self, name)
        return np.asarray(array).astype(f"<{np.dtype(_VARIABLES[name][0]).str[1:]}")

    def _digest(self) -> str:
        content = [self._packed(name).tobytes() for name in _VARIABLES]
        return hashlib.sha256(b"".join([repr(float(self.nu)).encode(), *content])).hexdigest()


_PACKED = ("units", "splines", "full_slip")
_ENTRY = ("ratio", "magnitude", "direction")
_SPLINE = (
    "spline in a/b",
    "spline in the place of t",
    "spline in the angle from vx",
    "spline in the angle of vy and spin",
)
_VARIABLES: dict[str, tuple[str, tuple[str, ...], str]] = {
    "ratios": ("d", ("ratio",), "a/b"),
    "directions": ("d", ("direction", "component"), "direction of reduced creepage: vx, vy, spin"),
    "values": ("f", (*_ENTRY, "component"), "Fx/(f Fz), Fy/(f Fz), Mz/(f Fz sqrt(ab))"),
    "accuracy": ("f", _ENTRY, "estimated error, in parts of f Fz"),
    "units": ("d", ("spline in the place of t", "component"), "of the splines"),
    "splines": ("h", (*_SPLINE, "component"), "coefficients of B-splines, in whole units"),
    "full_slip": ("h", (_SPLINE[0], "spline at full slip", *_SPLINE[2:], "component"), "to be added, in units by 2^15"),
}
"""By name: kind of number (d, f: floating; h: whole), dimensions, and what they are."""


def packed(splines: np.ndarray) -> dict[str, np.ndarray]:
    """Coefficients as a file has them: whole multiples of powers of two, with 15 binary digits and a sign.

    Those at full slip have 15 more digits: without spin it is known exactly.
    """
    largest = np.maximum(np.abs(splines).max(axis=(0, 2, 3)), TINY)
    units = np.ldexp(1.0, np.ceil(np.log2(largest / 32767)).astype(int))
    multiples = splines / units[:, None, None]
    whole = np.rint(multiples)
    return {"units": units, "splines": whole, "full_slip": np.rint((multiples - whole)[:, -AT_FULL:] * MORE)}


def unpacked(units: np.ndarray, splines: np.ndarray, full_slip: np.ndarray) -> np.ndarray:
    """Coefficients from what `packed` gives."""
    multiples = np.array(splines)
    multiples[:, -AT_FULL:] += full_slip / MORE
    return multiples * units[:, None, None]


@cache
def shipped() -> TableBook:
    """The book that comes with the package: nu = 0.28, steel."""
    with as_file(files("varcontact.theories") / "table_book.nc") as path:
        return TableBook.read(path)


@lru_cache(maxsize=32)
def _splines_of(book: TableBook, ratio: float) -> NdBSpline:
    """Those of one ratio."""
    return _spline_of(BSpline(_knots(len(book.splines)), book.splines, 3)(book._place(ratio)))


def _spline_of(coefficients: np.ndarray) -> NdBSpline:
    """Cubic B-splines in the variables of all axes but the last, over intervals of one from 0."""
    return NdBSpline(tuple(map(_knots, coefficients.shape[:-1])), coefficients, 3)


def _knots(count: int) -> np.ndarray:
    return np.arange(-3.0, count + 1)
