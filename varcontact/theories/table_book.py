"""The table book itself: normalised variables, entries, the splines through them, and its file."""

from __future__ import annotations

import hashlib
import math
from dataclasses import dataclass
from functools import cache, cached_property, lru_cache
from importlib.resources import as_file, files
from pathlib import Path
from typing import Any

import numpy as np

from varcontact.errors import OutputError
from varcontact.reference.creepage_coefficients import CreepageCoefficients

FORMAT = "varcontact table 2"
HALFWAY = 1.5
"""The magnitude that is half of the way to full slip: Vermeulen and Johnson's line ends at 3, their full slip."""
SPIN = 0.5
"""Spin counts by this part of the slip that it makes a distance sqrt(a^2 + b^2) away."""
AT_ONCE = 512
"""Creepages that are computed together: what they need stays in the processor's cache."""
FEW = 64
"""Creepages of one ratio, up to which it does not pay to make the splines of that ratio first."""
_WEIGHTS = np.array([[1, -3, 3, -1], [4, 0, -6, 3], [1, 3, 3, -3], [0, 0, 0, 1]]) / 6
"""Cubic B-splines on an interval: rows by spline, columns by power."""


@dataclass(frozen=True, eq=False)
class TableBook:
    """Forces of the exact theory for ellipses and creepages, of one Poisson's ratio.

    With ``c = sqrt(ab)`` the reduced creepage is ``u = G ab / (f Fz) (C11 vx, C22 vy, C11 R spin)``, where
    ``R = sqrt(a^2 + b^2)/2``: a magnitude ``|u|`` and a direction. Forces are in parts of ``f Fz``, the moment of
    ``f Fz c``. By symmetry Fx is odd in vx and even in (vy, spin), Fy and Mz are the other way round: the directions
    with vx >= 0 and half of the (vy, spin) stand for all. Magnitudes are ``1.5 t/(1 - t)`` at points of t in (0, 1),
    see `magnitudes`; t = 0 is the linear theory, t = 1 full slip. The ratios a/b are Chebyshev's points in log(a/b).

    With the linear theory's forces L(u), what is interpolated is S in ``F = (1 - t)^2 L(u) + t^2 S``: by cubic splines
    in t and in the two angles of the direction (that from vx, and that of (vy, spin)), and by a polynomial in log(a/b).

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
    splines : ndarray, shape (i, j, k, r, 3)
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

    def normalised(self, reduced: np.ndarray, ratio: Any, coefficients: CreepageCoefficients) -> np.ndarray:
        """Normalised forces for reduced creepages.

        Parameters
        ----------
        reduced : ndarray, shape (3, n)
        ratio : float or ndarray, shape (n,)
            a/b, within the book.
        coefficients : CreepageCoefficients
            Those of the ratio.

        Returns
        -------
        ndarray, shape (3, n)
            Fx, Fy, Mz; the force is cut at full friction.
        """
        n, several = reduced.shape[1], isinstance(ratio, np.ndarray)
        weights = lagrange(np.log(self.ratios), np.log(ratio)) if several else _weights_of(self, ratio)
        rows = self._rows if several or n <= FEW else _rows_of(self, ratio)
        linear, found = linear_part(reduced, ratio, coefficients), np.empty_like(reduced)
        for k in range(0, n, AT_ONCE):
            part = slice(k, k + AT_ONCE)
            found[:, part] = self._some(reduced[:, part], linear[:, part], rows, weights[part] if several else weights)
        return found

    def _some(self, reduced: np.ndarray, linear: np.ndarray, rows: np.ndarray, weights: np.ndarray) -> np.ndarray:
        """A block of `normalised`: `rows` of all ratios or of one, which `weights` are then not for."""
        x, y, z = reduced
        across = y * y + z * z
        magnitude, across = np.sqrt(x * x + across), np.sqrt(across)
        rest = HALFWAY / (magnitude + HALFWAY)
        t, angle = 1 - rest, np.arctan2(z, y)
        other = (angle < 0) | (angle >= math.pi)
        places = np.array(
            [t, np.arctan2(across, np.abs(x)) * (2 / math.pi), angle * (1 / math.pi) + (angle < 0) - (angle >= math.pi)]
        )
        places *= self._intervals
        interval = np.minimum(places.astype(np.intp), self._intervals - 1)
        f = places - interval
        square = f * f
        by_t, by_polar, by_angle = np.tensordot(
            _WEIGHTS, np.array([np.ones_like(f), f, square, square * f]), 1
        ).transpose(1, 2, 0)
        near = rows[(self._strides @ interval)[:, None] + self._offsets]
        both = (by_t[:, :, None] * by_polar[:, None, :]).reshape(-1, 1, 16)
        near = (both @ near).reshape(len(t), 4, -1)
        S = (by_angle[:, None, :] @ near)[:, 0]
        if S.shape[1] > 3:
            S = np.einsum("nri,nr->ni" if weights.ndim == 2 else "nri,r->ni", S.reshape(len(S), -1, 3), weights)
        found = S.T * (t * t)
        found[0] = np.where(x < 0, -found[0], found[0])
        found[1:] = np.where(other, -found[1:], found[1:])
        found += linear * (rest * rest)
        found[:2] /= np.maximum(np.sqrt(found[0] * found[0] + found[1] * found[1]), 1.0)
        return found

    @cached_property
    def _rows(self) -> np.ndarray:
        """Four neighbours along the last angle in a row, of all ratios."""
        return _in_rows(self.splines.reshape(-1, 3 * len(self.ratios)))

    @cached_property
    def _intervals(self) -> np.ndarray:
        return np.array(self.splines.shape[:3])[:, None] - 3

    @cached_property
    def _strides(self) -> np.ndarray:
        _, polar, angle = self.splines.shape[:3]
        return np.array([polar * angle, angle, 1])

    @cached_property
    def _offsets(self) -> np.ndarray:
        """Of the four times four rows that a place needs."""
        four = np.arange(4)
        return np.asarray((four[:, None] * self._strides[0] + four * self._strides[1]).ravel())

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
        names = ("ratio", "magnitude", "direction", "component", *_SPLINE)
        for name, size in zip(names, (*self.values.shape, *self.splines.shape[:3]), strict=True):
            file.createDimension(name, size)
        for name, (kind, dims, words) in _VARIABLES.items():
            variable = file.createVariable(name, kind, dims)
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
        kinds = ((name, np.dtype(kind).newbyteorder("<")) for name, (kind, _, _) in _VARIABLES.items())
        content = [np.ascontiguousarray(getattr(self, name), dtype=kind).tobytes() for name, kind in kinds]
        return hashlib.sha256(b"".join([repr(float(self.nu)).encode(), *content])).hexdigest()


_ENTRY = ("ratio", "magnitude", "direction")
_SPLINE = ("spline in t", "spline in the angle from vx", "spline in the angle of vy and spin")
_VARIABLES: dict[str, tuple[str, tuple[str, ...], str]] = {
    "ratios": ("d", ("ratio",), "a/b"),
    "directions": ("d", ("direction", "component"), "direction of reduced creepage: vx, vy, spin"),
    "values": ("f", (*_ENTRY, "component"), "Fx/(f Fz), Fy/(f Fz), Mz/(f Fz sqrt(ab))"),
    "accuracy": ("f", _ENTRY, "estimated error, in parts of f Fz"),
    "splines": ("f", (*_SPLINE, "ratio", "component"), "coefficients of B-splines"),
}
"""By name: single or double precision, dimensions, and what they are."""


@cache
def shipped() -> TableBook:
    """The book that comes with the package: nu = 0.28, steel."""
    with as_file(files("varcontact.theories") / "table_book.nc") as path:
        return TableBook.read(path)


def spin_scale(coefficients: CreepageCoefficients, ratio: Any) -> np.ndarray:
    """Scales of vx, vy and spin times sqrt(ab) in the reduced creepage, but for G ab / (f Fz).

    Parameters
    ----------
    coefficients : CreepageCoefficients
    ratio : float or ndarray, shape (n,)
        a/b.

    Returns
    -------
    ndarray, shape (3, ...)
    """
    C = coefficients
    return np.array([C.C11, C.C22, SPIN * C.C11 * np.sqrt(ratio + 1 / ratio)])


def linear_part(reduced: np.ndarray, ratio: Any, coefficients: CreepageCoefficients) -> np.ndarray:
    """Normalised forces of the linear theory.

    Parameters
    ----------
    reduced : ndarray, shape (3, ...)
    ratio : float or ndarray
        a/b.
    coefficients : CreepageCoefficients

    Returns
    -------
    ndarray, shape (3, ...)
    """
    C, by_spin = coefficients, spin_scale(coefficients, ratio)[2]
    x, y, z = reduced
    return np.stack([-x, -y - (C.C23 / by_spin) * z, (C.C23 / C.C22) * y - (C.C33 / by_spin) * z])


def magnitudes(count: int) -> np.ndarray:
    """Points t of the magnitudes ``1.5 t/(1 - t)`` of the entries, without 0 and 1.

    They are Chebyshev's; from five on two more are put around the one nearest to 2/3, where full slip begins without
    spin.

    Parameters
    ----------
    count : int
    """
    usual = count - 2 if count > 4 else count
    points = (1 - np.cos(math.pi * np.arange(1, usual + 1) / (usual + 1))) / 2
    if count > usual:
        nearest = min(max(int(np.abs(points - 2 / 3).argmin()), 1), usual - 2)
        points = np.sort([*points, *(points[nearest - 1 : nearest + 1] + points[nearest : nearest + 2]) / 2])
    return np.asarray(points)


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


def lagrange(nodes: np.ndarray, at: Any) -> np.ndarray:
    """Weights of values at some nodes in the value of the polynomial through them.

    Parameters
    ----------
    nodes : ndarray, shape (r,)
    at : float or ndarray

    Returns
    -------
    ndarray, shape (..., r)
    """
    differences = nodes[:, None] - nodes
    np.fill_diagonal(differences, 1.0)
    parts = (np.asarray(at)[..., None, None] - nodes) / differences
    parts[..., np.arange(len(nodes)), np.arange(len(nodes))] = 1.0
    return np.asarray(parts.prod(axis=-1))


def _in_rows(splines: np.ndarray) -> np.ndarray:
    """A view of coefficients (p, k) as rows of four neighbours (p - 3, 4 k): a row is read at once."""
    step = splines.strides[1]
    shape = len(splines) - 3, 4 * splines.shape[1]
    return np.lib.stride_tricks.as_strided(splines, shape, (splines.strides[0], step), writeable=False)


@lru_cache(maxsize=256)
def _weights_of(book: TableBook, ratio: float) -> np.ndarray:
    return lagrange(np.log(book.ratios), math.log(ratio))


@lru_cache(maxsize=32)
def _rows_of(book: TableBook, ratio: float) -> np.ndarray:
    """The splines of one ratio."""
    one = np.tensordot(book.splines, _weights_of(book, ratio), (3, 0))
    return _in_rows(np.ascontiguousarray(one.reshape(-1, 3)))
