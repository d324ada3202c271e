"""A table book: normalised variables, entries, the splines through them, and its file."""

from __future__ import annotations

import hashlib
import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache, lru_cache
from importlib.resources import as_file, files
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np

from varcontact import checks
from varcontact.errors import OutputError
from varcontact.reference.creepage_coefficients import FOUR, CreepageCoefficients, near_splines
from varcontact.system.files import check_regular, reading
from varcontact.system.process import lazy_property

FORMAT = "varcontact table 3"
AT_ONCE = 512
"""Creepages that are computed together: their arrays fit into the processor's cache."""
AT_FULL = 3
"""Number of B-splines of t that are not zero at full slip."""
FULL_SLIP_FACTOR = 2.0**15
"""Ratio of the units of the others, in a file, to those of these splines."""
HALFWAY = 1.5
"""Magnitude halfway to full slip: Vermeulen and Johnson's line ends at 3, their full slip."""
KNEE = 1.8
"""Magnitude at which full slip begins, approximately."""
ROOM = 0.35
"""Part of the way to full slip that is kept for the magnitudes about `KNEE`."""
SPIN = 0.5
"""Weight of spin: part of the slip that it makes a distance sqrt(a^2 + b^2) away."""
TINY = 1e-200
"""Least unit of a file's splines."""
NearSplines = tuple[Any, tuple[Any, ...]]
"""The first of the splines that are not zero at a place, and their values there."""
FLOAT_FUNCTIONS = (math.sqrt, math.atan2, max)
ARRAY_FUNCTIONS = (np.sqrt, np.arctan2, np.maximum)


def reduced_scales(coefficients: CreepageCoefficients, ratio: Any) -> tuple[Any, Any, Any]:
    """Scales of vx, vy and spin times sqrt(ab) in the reduced creepage, but for G ab / (f Fz)."""
    C = coefficients
    return C.C11, C.C22, SPIN * C.C11 * (ratio + 1 / ratio) ** 0.5


def linear_part(
    x: Any, y: Any, z: Any, ratio: Any, coefficients: CreepageCoefficients
) -> tuple[Any, Any, Any]:
    """Normalised Fx, Fy and Mz of the linear theory for reduced creepages along vx, vy and the
    spin.
    """
    C = coefficients
    _, _, by_spin = reduced_scales(coefficients, ratio)
    Fx = -x
    Fy = -y - (C.C23 / by_spin) * z
    Mz = (C.C23 / C.C22) * y - (C.C33 / by_spin) * z
    return Fx, Fy, Mz


def places(t: Any) -> Any:
    """Place of ``t = r/(r + 1.5)`` of a magnitude r among the splines, from 0, no slip, to 1, full
    slip.

    It has more room than t for the magnitudes about `KNEE`, where full slip begins.
    """
    rest = (1 - t) * (KNEE / HALFWAY)
    cube = t * t * t
    return t + ROOM * (cube / (cube + rest * rest * rest) - t)


@dataclass(frozen=True, eq=False)
class TableBook:
    """Forces of the exact theory for ellipses and creepages, of one Poisson's ratio.

    With ``c = sqrt(ab)`` the reduced creepage is
    ``u = G ab / (f Fz) (C11 vx, C22 vy, C11 R spin)``, where
    ``R = sqrt(a^2 + b^2)/2``: a magnitude ``|u|`` and a direction. Forces are
    in parts of ``f Fz``, the moment of ``f Fz c``. By symmetry Fx is odd in vx
    and even in (vy, spin), Fy and Mz are the other way round: the directions
    with vx >= 0 and half of the (vy, spin) stand for all. Magnitudes are
    ``1.5 t/(1 - t)`` at points of t in (0, 1), equal steps of `places`; t = 0
    is the linear theory, t = 1 full slip. The ratios are Chebyshev's points in
    log(a/b).

    With the linear theory's forces L(u), what is interpolated is S in
    ``F = (1 - t)^2 L(u) + t^2 S``: by cubic splines in log(a/b), in the place
    of t (see `places`), and in the two angles of the direction (that from vx,
    and that of (vy, spin)).

    Attributes
    ----------
    nu : float
        Combined Poisson's ratio.
    ratios : ndarray, shape (r,)
        a/b, ascending.
    directions : ndarray, shape (d, 3)
        Of reduced creepage, unit vectors.
    values : ndarray, shape (r, m, d, 3)
        Fx, Fy, Mz of the entries, normalised, by ratio, magnitude and
        direction.
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
        self, x: Any, y: Any, z: Any, ratio: Any, coefficients: CreepageCoefficients
    ) -> tuple[Any, ...]:
        """Normalised Fx, Fy and Mz for reduced creepages `x`, `y` and spin `z`; the force is cut at
        f Fz.

        Creepages are floats or arrays (n,); `ratio` a/b and its `coefficients` are one for all or
        (n,).
        """
        linear = linear_part(x, y, z, ratio, coefficients)
        if isinstance(x, float):
            return self._normalised(x, y, z, linear, self._rows, self._near(ratio))
        several = isinstance(ratio, np.ndarray)
        rows = self._rows if several else _rows_of(self, ratio)
        forces = np.empty((3, len(x)))
        for k in range(0, len(x), AT_ONCE):
            part = slice(k, k + AT_ONCE)
            near: NearSplines = self._near(ratio[part]) if several else (0, (1.0,))
            linear_forces = [values[part] for values in linear]
            forces[:, part] = self._normalised(x[part], y[part], z[part], linear_forces, rows, near)
        return tuple(forces)

    def _normalised(
        self, x: Any, y: Any, z: Any, linear: Sequence[Any], rows: np.ndarray, near: NearSplines
    ) -> tuple[Any, ...]:
        functions: tuple[Any, ...] = FLOAT_FUNCTIONS if isinstance(x, float) else ARRAY_FUNCTIONS
        sqrt, atan2, greater = functions
        # places among the splines, and their values there
        across = y * y + z * z
        rest = HALFWAY / (sqrt(x * x + across) + HALFWAY)
        t = 1 - rest
        angle = atan2(z, y)
        other = (angle < 0) | (angle >= math.pi)
        turned = angle * (1 / math.pi) + (angle < 0) - (angle >= math.pi)
        steps, polar, half_turn = (n - 3 for n in self.splines.shape[1:4])
        ratio, in_ratio = near
        i, in_t = near_splines(places(t) * steps, steps)
        j, in_polar = near_splines(atan2(sqrt(across), abs(x)) * (polar * 2 / math.pi), polar)
        k, in_angle = near_splines(turned * half_turn, half_turn)
        first = ((ratio * (steps + 3) + i) * (polar + 3) + j) * (half_turn + 3) + k
        # the sum of coefficients times values
        count = 16 * len(in_ratio)
        items = rows[np.asarray(first)[..., None] + self._offsets[:count]]
        coefficients = items.view(float).reshape(-1, count, 12)
        weights = (np.array(in_t)[:, None] * np.array(in_polar)).reshape(16, -1)
        weights = (np.array(in_ratio).reshape(len(in_ratio), 1, -1) * weights).reshape(count, -1)
        by_angle = np.ascontiguousarray(weights.T)[:, None] @ coefficients
        S = np.array(in_angle).T[..., None, :] @ by_angle.reshape(-1, 4, 3)
        Sx, Sy, Sz = S.reshape(*np.shape(x), 3).T
        # forces, by symmetry of all directions, cut at full slip
        tt = t * t
        rr = rest * rest
        along = 1 - 2 * (x < 0)
        turn = 1 - 2 * other
        Fx = along * tt * Sx + rr * linear[0]
        Fy = turn * tt * Sy + rr * linear[1]
        Mz = turn * tt * Sz + rr * linear[2]
        cut = greater(sqrt(Fx * Fx + Fy * Fy), 1.0)
        return Fx / cut, Fy / cut, Mz

    def _near(self, ratio: Any) -> NearSplines:
        """The splines in log(a/b) that are not zero there."""
        least, greatest = self.range
        intervals = len(self.splines) - 3
        log: Any = math.log if isinstance(ratio, float) else np.log
        place = log(ratio / least) * (intervals / math.log(greatest / least))
        return near_splines(place, intervals)

    @lazy_property
    def _rows(self) -> np.ndarray:
        return _in_rows(self.splines)

    @lazy_property
    def _offsets(self) -> np.ndarray:
        """Offsets of the rows that a place needs: for each of four ratios four by t, for each of
        these four by the angle.
        """
        t, polar, angle = self.splines.shape[1:4]
        by_t = FOUR[:, None, None] * t + FOUR[:, None]
        return np.asarray(((by_t * polar + FOUR) * angle).ravel())

    @lazy_property
    def range(self) -> tuple[float, float]:
        """The least and the greatest a/b."""
        return float(self.ratios[0]), float(self.ratios[-1])

    @property
    def entries(self) -> int:
        """Number of exact solutions that it holds."""
        return int(self.accuracy.size)

    def to_bytes(self) -> bytes:
        """The book as a netCDF file."""
        from scipy.io import netcdf_file

        buffer = BytesIO()
        file = netcdf_file(buffer, "w", version=2)
        file.format = FORMAT
        file.nu = repr(self.nu)
        file.provenance = self.provenance
        file.digest = self.digest()
        dimensions = dict(zip((*_ENTRY, "component"), self.values.shape, strict=True))
        dimensions |= zip(_SPLINE, self.splines.shape[:4], strict=True)
        dimensions["spline at full slip"] = AT_FULL
        for name, size in dimensions.items():
            file.createDimension(name, size)
        for name, (kind, dims, words) in _VARIABLES.items():
            variable = file.createVariable(name, kind, dims)
            variable[:] = self._packed(name)
            variable.long_name = words
        file.flush()
        return buffer.getvalue()

    @classmethod
    def read(cls, path: str | Path) -> TableBook:
        """A book from its file at `path`; OutputError if it is not there, is damaged, or is no book
        of this version.
        """
        from scipy.io import netcdf_file

        path = checks.file_name("path", path)
        check_regular("path", path)
        with (
            reading(path, "cannot be read as a table book"),
            netcdf_file(path, "r", mmap=False) as file,
        ):
            file_format = getattr(file, "format", b"").decode()
            if file_format != FORMAT:
                kind = f"a {file_format!r} file" if file_format else "another netCDF file"
                reason = f"is {kind}, not a {FORMAT!r} one; make the book anew"
                raise OutputError("path", path, reason)
            arrays = {name: np.array(file.variables[name][:], dtype=float) for name in _VARIABLES}
            arrays["splines"] = unpacked(*(arrays.pop(name) for name in _PACKED))
            book = cls(nu=float(file.nu), provenance=file.provenance.decode(), **arrays)
            if book.digest() != file.digest.decode():
                raise OutputError(
                    "path", path, "is damaged: its numbers are not those that were written"
                )
        return book

    def _packed(self, name: str) -> np.ndarray:
        array = packed(self.splines)[name] if name in _PACKED else getattr(self, name)
        return np.asarray(array).astype(f"<{np.dtype(_VARIABLES[name][0]).str[1:]}")

    def digest(self) -> str:
        """SHA-256 of its numbers, which identifies the book in files and exports."""
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
    "full_slip": (
        "h",
        (_SPLINE[0], "spline at full slip", *_SPLINE[2:], "component"),
        "to be added, in units by 2^15",
    ),
}
"""Kind of number (d, f: floating; h: whole), dimensions and description, by name."""


def packed(splines: np.ndarray) -> dict[str, np.ndarray]:
    """Coefficients as a file has them: whole multiples of powers of two, with 15 binary digits and
    a sign.

    Those at full slip have 15 more digits: without spin it is known exactly.
    """
    largest = np.maximum(np.abs(splines).max(axis=(0, 2, 3)), TINY)
    units = np.ldexp(1.0, np.ceil(np.log2(largest / 32767)).astype(int))
    multiples = splines / units[:, None, None]
    whole = np.rint(multiples)
    return {
        "units": units,
        "splines": whole,
        "full_slip": np.rint((multiples - whole)[:, -AT_FULL:] * FULL_SLIP_FACTOR),
    }


def unpacked(units: np.ndarray, splines: np.ndarray, full_slip: np.ndarray) -> np.ndarray:
    """Coefficients from what `packed` gives."""
    multiples = np.array(splines)
    multiples[:, -AT_FULL:] += full_slip / FULL_SLIP_FACTOR
    return multiples * units[:, None, None]


@cache
def shipped() -> TableBook:
    """The book that comes with the package: nu = 0.28, steel."""
    with as_file(files("varcontact.theories") / "table_book.nc") as path:
        return TableBook.read(path)


def _in_rows(splines: np.ndarray) -> np.ndarray:
    """A view of coefficients (..., 3) as overlapping rows of four neighbours, each an item: it is
    copied at once.
    """
    each = np.ascontiguousarray(splines).reshape(-1, 3)
    row = np.dtype((np.void, 4 * each.strides[0]))
    return np.ndarray(len(each) - 3, row, each.data, strides=each.strides[:1])


@lru_cache(maxsize=32)
def _rows_of(book: TableBook, ratio: float) -> np.ndarray:
    first, values = book._near(ratio)
    return _in_rows(np.tensordot(values, book.splines[first : first + 4], 1))
