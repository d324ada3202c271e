"""The table book itself: normalised variables, entries, the polynomials through them, and its file."""

from __future__ import annotations

import hashlib
import math
from dataclasses import dataclass
from functools import cache, cached_property
from importlib.resources import as_file, files
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

import numpy as np

from varcontact.errors import OutputError

if TYPE_CHECKING:
    from varcontact.reference.creepage_coefficients import CreepageCoefficients

FORMAT = "varcontact table 1"
NAMES = ("C11", "C22", "C23", "C33")
HALFWAY = 1.5
"""The magnitude that is half of the way to full slip: Vermeulen and Johnson's line ends at 3, their full slip."""
SPIN = 0.5
"""Spin counts by this part of the slip that it makes a distance sqrt(a^2 + b^2) away."""
PURE = 10.0
"""Weight of creepages without spin in the fit, which are the most frequent."""


@dataclass(frozen=True, eq=False)
class TableBook:
    """Forces of the exact theory for ellipses and creepages, of one Poisson's ratio.

    With ``c = sqrt(ab)`` the reduced creepage is ``u = G ab / (f Fz) (C11 vx, C22 vy, C11 R spin)``, where
    ``R = sqrt(a^2 + b^2)/2``: a magnitude ``|u|`` and a direction. Forces are in parts of ``f Fz``, the moment of
    ``f Fz c``. By symmetry Fx is odd in vx and even in (vy, spin), Fy and Mz are the other way round: the directions
    with vx >= 0 and half of the (vy, spin) stand for all. Magnitudes are ``1.5 t/(1 - t)`` at Chebyshev's points of t
    in (0, 1); t = 0 is the linear theory, t = 1 full slip, both in closed form. The ratios a/b are Chebyshev's points
    in log(a/b).

    Attributes
    ----------
    nu : float
        Combined Poisson's ratio.
    ratios : ndarray, shape (r,)
        a/b, ascending.
    coefficients : ndarray, shape (r, 4)
        C11, C22, C23, C33.
    directions : ndarray, shape (d, 3)
        Of reduced creepage, unit vectors.
    values : ndarray, shape (r, m, d, 3)
        Fx, Fy, Mz of the entries, normalised, by ratio, magnitude and direction.
    accuracy : ndarray, shape (r, m, d)
        Estimated error of each entry, in parts of f Fz.
    full : ndarray, shape (r, d, 3)
        Full slip.
    provenance : str
        How it was made.
    """

    nu: float
    ratios: np.ndarray
    coefficients: np.ndarray
    directions: np.ndarray
    values: np.ndarray
    accuracy: np.ndarray
    full: np.ndarray
    provenance: str

    def normalised(self, reduced: np.ndarray, along: np.ndarray, across: np.ndarray) -> np.ndarray:
        """Normalised forces for reduced creepages.

        Parameters
        ----------
        reduced : ndarray, shape (3, n)
        along, across : ndarray
            The polynomials of one ratio, from `at`.

        Returns
        -------
        ndarray, shape (3, n)
            Fx, Fy, Mz; the force is cut at full friction.
        """
        magnitude = np.sqrt((reduced * reduced).sum(axis=0))
        n = reduced / np.where(magnitude > 0, magnitude, 1.0)
        t = magnitude / (magnitude + HALFWAY)
        even, odd = _powers(n[1], n[2], self.degree)
        radial = t * np.cos(np.arange(len(along))[:, None] * np.arccos(2 * t - 1))
        found = np.empty_like(reduced)
        found[0] = n[0] * (radial * (along @ even)).sum(axis=0)
        found[1:] = (radial[:, None] * (across @ odd).reshape(len(along), 2, -1)).sum(axis=0)
        found[:2] /= np.maximum(np.hypot(found[0], found[1]), 1.0)
        return found

    def at(self, ratio: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """What serves all creepages of one ratio.

        Parameters
        ----------
        ratio : float
            a/b, within the book.

        Returns
        -------
        scale : ndarray, shape (3,)
            Of vx, vy and spin times c in the reduced creepage.
        along, across : ndarray
            The polynomials of Fx, and of Fy and Mz.
        """
        weights = _lagrange(np.log(self.ratios), math.log(ratio))
        along, across = self._polynomials
        C = np.exp(weights @ np.log(self.coefficients))
        return spin_scale(C, ratio), np.tensordot(weights, along, 1), np.tensordot(weights, across, 1)

    def coefficients_at(self, ratio: float) -> CreepageCoefficients:
        """The creepage coefficients that are its slopes at the origin.

        Parameters
        ----------
        ratio : float
            a/b, within the book.
        """
        from varcontact.reference.creepage_coefficients import CreepageCoefficients

        C = np.exp(_lagrange(np.log(self.ratios), math.log(ratio)) @ np.log(self.coefficients))
        return CreepageCoefficients(*map(float, C))

    @property
    def degree(self) -> int:
        """Of the polynomials of the direction, odd: the greatest that the directions determine."""
        return degree_of(len(self.directions))

    @cached_property
    def _polynomials(self) -> tuple[np.ndarray, np.ndarray]:
        """Coefficients by ratio, power of t (Chebyshev's) and power of the direction: of Fx, and of Fy and Mz."""
        ratios, count = self.values.shape[:2]
        t = magnitudes(count)
        slopes = HALFWAY * np.stack([_linear(C, k, self.directions) for C, k in self._pairs])
        nodes = np.concatenate([slopes[:, None], self.values / t[:, None, None], self.full[:, None]], axis=1)
        nodes = np.einsum("jk,rkdi->rjdi", _to_chebyshev(count + 2), nodes)
        even, odd = _powers(self.directions[:, 1], self.directions[:, 2], self.degree)
        weight = np.where(self.directions[:, 2] == 0, PURE, 1.0)
        fit_even = np.linalg.pinv((even * self.directions[:, 0] * weight).T, rcond=1e-13) * weight
        fit_odd = np.linalg.pinv((odd * weight).T, rcond=1e-13) * weight
        along = np.einsum("pd,rjd->rjp", fit_even, nodes[..., 0])
        across = np.einsum("pd,rjdi->rjip", fit_odd, nodes[..., 1:])
        return along, across.reshape(ratios, -1, odd.shape[0])

    @property
    def _pairs(self) -> zip[tuple[np.ndarray, float]]:
        return zip(self.coefficients, self.ratios, strict=True)

    @property
    def entries(self) -> int:
        """How many exact solutions it holds."""
        return int(self.accuracy.size)

    def to_bytes(self) -> bytes:
        """The book as a netCDF file."""
        from io import BytesIO

        from scipy.io import netcdf_file

        buffer = BytesIO()
        file = netcdf_file(buffer, "w", version=2)
        file.format, file.nu, file.provenance, file.digest = FORMAT, repr(self.nu), self.provenance, self._digest()
        sizes = self.values.shape
        for name, size in {"ratio": sizes[0], "magnitude": sizes[1], "direction": sizes[2], "component": 3}.items():
            file.createDimension(name, size)
        file.createDimension("coefficient", 4)
        for name, (dims, words) in _VARIABLES.items():
            variable = file.createVariable(name, "d", dims)
            variable[:], variable.long_name = getattr(self, name), words
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
        OutputError
            If the file is not there, is damaged, or is no book of this version.
        """
        from scipy.io import netcdf_file

        try:
            with netcdf_file(path, "r", mmap=False) as file:
                found = getattr(file, "format", b"").decode()
                if found == FORMAT:
                    arrays = {name: np.array(file.variables[name][:], dtype=float) for name in _VARIABLES}
                    book = cls(nu=float(file.nu), provenance=file.provenance.decode(), **arrays)
                    whole = book._digest() == file.digest.decode()
        except FileNotFoundError:
            raise OutputError("path", path, "there is no such file") from None
        except Exception as error:  # whatever scipy makes of other files
            words = str(error).split("\n")[0] or type(error).__name__
            raise OutputError("path", path, f"cannot be read as a table book ({words})") from None
        if found != FORMAT:
            kind = f"a {found!r} file" if found else "another netCDF file"
            raise OutputError("path", path, f"is {kind}, not a {FORMAT!r} one; make the book anew")
        if not whole:
            raise OutputError("path", path, "is damaged: its numbers are not those that were written")
        return book

    def _digest(self) -> str:
        content = [np.ascontiguousarray(getattr(self, name), dtype="<f8").tobytes() for name in _VARIABLES]
        return hashlib.sha256(b"".join([repr(float(self.nu)).encode(), *content])).hexdigest()


_ENTRY = ("ratio", "magnitude", "direction")
_VARIABLES: dict[str, tuple[tuple[str, ...], str]] = {
    "ratios": (("ratio",), "a/b"),
    "coefficients": (("ratio", "coefficient"), "C11, C22, C23, C33"),
    "directions": (("direction", "component"), "direction of reduced creepage: vx, vy, spin"),
    "values": ((*_ENTRY, "component"), "Fx/(f Fz), Fy/(f Fz), Mz/(f Fz sqrt(ab))"),
    "accuracy": (_ENTRY, "estimated error, in parts of f Fz"),
    "full": (("ratio", "direction", "component"), "full slip"),
}


@cache
def shipped() -> TableBook:
    """The book that comes with the package: nu = 0.28, steel."""
    with as_file(files("varcontact.theories") / "table_book.nc") as path:
        return TableBook.read(path)


def spin_scale(C: np.ndarray, ratio: float) -> np.ndarray:
    """Scales of vx, vy and spin times sqrt(ab) in the reduced creepage, but for G ab / (f Fz).

    Parameters
    ----------
    C : ndarray, shape (4,)
        Coefficients.
    ratio : float
        a/b.
    """
    return np.array([C[0], C[1], SPIN * C[0] * math.sqrt(ratio + 1 / ratio)])


def magnitudes(count: int) -> np.ndarray:
    """Chebyshev's points t of the magnitudes ``1.5 t/(1 - t)`` of the entries, without 0 and 1.

    Parameters
    ----------
    count : int
    """
    return np.asarray((1 - np.cos(math.pi * np.arange(1, count + 1) / (count + 1))) / 2)


def ratio_nodes(least: float, greatest: float, count: int) -> np.ndarray:
    """Chebyshev's points in log(a/b), both ends included.

    Parameters
    ----------
    least, greatest : float
    count : int
    """
    middle, half = math.log(least * greatest) / 2, math.log(greatest / least) / 2
    return np.asarray(np.exp(middle - half * np.cos(math.pi * np.arange(count) / (count - 1))))


def direction_nodes(degree: int) -> np.ndarray:
    """Directions that determine polynomials of the direction: circles of (vy, spin), half of each.

    Parameters
    ----------
    degree : int
        Odd.

    Returns
    -------
    ndarray, shape (d, 3)
        From pure vx to none of it.
    """
    circles = (degree + 3) // 2
    found = [np.array([[1.0, 0.0, 0.0]])]
    for k in range(1, circles + 1):
        count = min(4 + 2 * k, degree + 3)
        angle, radius = math.pi * np.arange(count) / count, math.sin(math.pi * k / (2 * circles))
        height = math.cos(math.pi * k / (2 * circles)) if k < circles else 0.0
        found.append(np.stack([np.full(count, height), radius * np.cos(angle), radius * np.sin(angle)], axis=1))
    return np.concatenate(found)


@cache
def degree_of(directions: int) -> int:
    """The degree whose directions are so many.

    Parameters
    ----------
    directions : int
    """
    return next(degree for degree in range(3, 61, 2) if len(direction_nodes(degree)) >= directions)


def full_slip(directions: np.ndarray, scale: np.ndarray, ratio: float, points: int = 200) -> np.ndarray:
    """Normalised forces where all of the contact slips and elastic displacements no longer count.

    Tractions of the traction bound oppose the rigid slip: Gauss's rule along the radii, the trapezoidal one around.

    Parameters
    ----------
    directions : ndarray, shape (d, 3)
    scale : ndarray, shape (3,)
        From `spin_scale`.
    ratio : float
        a/b.
    points : int
        Along a radius; twice as many around.

    Returns
    -------
    ndarray, shape (d, 3)
    """
    height, weight = np.polynomial.legendre.leggauss(points)
    height, weight = (height + 1) / 2, weight / 2
    angle = 2 * math.pi * (np.arange(2 * points) + 0.5) / (2 * points)
    radius = np.sqrt(1 - height**2)[:, None]
    x, y = math.sqrt(ratio) * radius * np.cos(angle), radius * np.sin(angle) / math.sqrt(ratio)
    load = np.broadcast_to((1.5 * height**2 * weight)[:, None] / points, x.shape)
    found = []
    for vx, vy, spin in directions / scale:
        wx, wy = vx - spin * y, vy + spin * x
        bound = load / np.maximum(np.hypot(wx, wy), np.finfo(float).tiny)
        found.append([-np.sum(bound * wx), -np.sum(bound * wy), -np.sum(bound * (x * wy - y * wx))])
    return np.array(found)


def _linear(C: np.ndarray, ratio: float, directions: np.ndarray) -> np.ndarray:
    """Normalised forces of the linear theory for reduced creepages of magnitude 1."""
    vx, vy, spin = (directions / spin_scale(C, ratio)).T
    return np.stack([-C[0] * vx, -C[1] * vy - C[2] * spin, C[2] * vy - C[3] * spin], axis=-1)


def _powers(y: np.ndarray, z: np.ndarray, degree: int) -> tuple[np.ndarray, np.ndarray]:
    """Products of powers of two variables, of even degree below, and of odd degree up to `degree`; (p, n) each."""
    (first, second), (third, fourth) = _exponents(degree)
    of_y, of_z = np.ones((2, degree + 1, y.size))
    of_y[1:], of_z[1:] = y, z
    np.multiply.accumulate(of_y, axis=0, out=of_y)
    np.multiply.accumulate(of_z, axis=0, out=of_z)
    return of_y[first] * of_z[second], of_y[third] * of_z[fourth]


@cache
def _exponents(degree: int) -> tuple[tuple[np.ndarray, np.ndarray], tuple[np.ndarray, np.ndarray]]:
    pairs = [(i, j) for i in range(degree + 1) for j in range(degree + 1 - i)]
    even, odd = ([pair for pair in pairs if sum(pair) % 2 == parity] for parity in (0, 1))
    return cast(Any, (tuple(np.array(even).T), tuple(np.array(odd).T)))


def _to_chebyshev(count: int) -> np.ndarray:
    """From values at Chebyshev's points, ends included, to the coefficients of his polynomials."""
    points = -np.cos(math.pi * np.arange(count) / (count - 1))
    return np.linalg.inv(np.polynomial.chebyshev.chebvander(points, count - 1))


def _lagrange(nodes: np.ndarray, at: float) -> np.ndarray:
    """Weights of values at some nodes in the value of the polynomial through them."""
    differences = nodes[:, None] - nodes
    np.fill_diagonal(differences, 1.0)
    ratios = (at - nodes)[None, :] / differences
    np.fill_diagonal(ratios, 1.0)
    return np.asarray(ratios.prod(axis=1))
