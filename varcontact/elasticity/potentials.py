"""The elastic field inside a half-space z >= 0 whose surface carries uniform
tractions on rectangles or strips.

Boussinesq's and Cerruti's solutions are derivatives of three potentials of a
point force (Love's), here integrated over the loaded element, with R the
distance of its points from the field point:

    phi = integral of 1/R,   chi = integral of ln(R + z),   omega = integral of z ln(R + z) - R .

An x- or y-derivative undoes one integration, so all that is needed are
integrals along lines, which have closed forms. The difference of a line
integral over its two ends is written as a product, never as a difference of
nearly equal numbers (`_Ends`). In the second direction the difference over two
edges is taken as long as the field point is nearer than `FAR` sides, where
three digits cancel at the most; beyond that the line integrals are so smooth
that two Gauss points are as good.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from varcontact.system.process import lazy_property

FAR = 1024.0
"""Distance in element sides beyond which Gauss's rule is used: its error there is about 4096^-4 =
4e-15."""

SNAP = 1e-12
"""Distance in element sides below which a surface point counts as on an element's edge."""

KINDS = (
    *("omega_xx", "omega_xy", "omega_yy", "chi_x", "chi_y"),
    *("phi_x", "phi_y", "chi_xx", "chi_xy", "chi_yy", "omega_xxy", "omega_xyy"),
    *("phi_xx", "phi_xy", "phi_yy", "phi_xz", "phi_yz", "chi_xxy", "chi_xyy"),
)
"""Available derivatives; those of the last row are times z, which keeps them finite."""

TRIANGLE_FAR = 8.0
"""Distance in element sides from which triangles are means of strips by Gauss's rule of six points:
its error there is about 30^-12 = 2e-18."""

_GAUSS_POINTS, _GAUSS_WEIGHTS = np.polynomial.legendre.leggauss(2)
_TRIANGLE_POINTS, _TRIANGLE_WEIGHTS = np.polynomial.legendre.leggauss(6)


def rectangle_potentials(
    x: np.ndarray,
    y: np.ndarray | float,
    z: np.ndarray | float,
    dx: float,
    dy: float,
    kinds: Sequence[str] = KINDS,
) -> np.ndarray:
    """Derivatives of the potentials of a unit density on a rectangle.

    Parameters
    ----------
    x, y, z : array_like
        Field point minus element centre, and depth ``z >= 0`` [length];
        broadcast together.
    dx, dy : float
        Sides of the element [length].
    kinds : sequence of str
        Which derivatives.

    Returns
    -------
    ndarray, shape (kinds, ...)
        The first five of `KINDS` [length], the others [-].

    Notes
    -----
    On the surface itself, on an edge of the element, what jumps there has the mean of both sides.
    What is infinite there, like ``ln|x|``, has its mean over a width of the shorter side.

    Examples
    --------
    The solid angle under which a unit square is seen from half a side below its centre is a third
    of a half-space's.

    >>> values = dict(zip(KINDS, rectangle_potentials(0.0, 0.0, 0.5, 1.0, 1.0)))
    >>> print(f"{(values['chi_xx'] + values['chi_yy']) / (2 * np.pi):.12f}")
    0.333333333333
    """
    points = np.broadcast_arrays(*(np.asarray(v, dtype=float) for v in (x, y, z)))
    x, y, z = (v.ravel() for v in points)
    distance = _distance(x, y, z, dx, dy)
    far_x = distance >= FAR * dx
    far_y = ~far_x & (distance >= FAR * dy)
    near = ~(far_x | far_y)
    result = np.empty((len(kinds), x.size))
    at_once = _near(x[None, None, near], y[None, None, near], z[near], dx, dy, kinds)
    result[:, near] = at_once[:, 0, 0]
    if far_x.any():
        result[:, far_x] = _gauss(x[far_x], y[far_x], z[far_x], dx, dy, kinds)
    if far_y.any():
        mirrored = [exchanged(kind) for kind in kinds]
        result[:, far_y] = _gauss(y[far_y], x[far_y], z[far_y], dy, dx, mirrored)
    return result.reshape(len(kinds), *points[0].shape)


def lattice_potentials(
    x: np.ndarray, y: np.ndarray, z: np.ndarray, dx: float, dy: float
) -> np.ndarray:
    """`rectangle_potentials` for all elements of a lattice at once: integrals
    along shared edges are found once.

    Parameters
    ----------
    x : ndarray, shape (nx, 1, n)
        Field points minus the centres of the columns, from left to right:
        falling by dx [length].
    y : ndarray, shape (1, ny, n)
        The same for the rows.
    z : ndarray, shape (n,)
        Depths.
    dx, dy : float
        Sides of an element.

    Returns
    -------
    ndarray, shape (19, nx, ny, n)
    """
    if np.all(_distance(x, y, z, dx, dy) < FAR * min(dx, dy)):
        return _near(x, y, z, dx, dy, KINDS)
    return rectangle_potentials(x, y, z, dx, dy)


def _distance(x: np.ndarray, y: np.ndarray, z: np.ndarray, dx: float, dy: float) -> np.ndarray:
    return np.sqrt(
        np.maximum(np.abs(x) - dx / 2, 0) ** 2 + np.maximum(np.abs(y) - dy / 2, 0) ** 2 + z**2
    )


def strip_potentials(
    x: np.ndarray, z: np.ndarray | float, dx: float, reference: float = 1.0
) -> np.ndarray:
    """Derivatives of the potentials of a unit density on an infinite strip
    along y: line contact, plane strain.

    Parameters
    ----------
    x, z : array_like
        Field point minus the strip's centre line, and depth ``z >= 0``
        [length]; broadcast together.
    dx : float
        Width of the strip [length].
    reference : float
        Length by which logarithms of distances are taken: the displacements'
        free constant [length].

    Returns
    -------
    ndarray, shape (19, ...)
        In the order of `KINDS`; on the edges as in `rectangle_potentials`.

    Examples
    --------
    >>> values = dict(zip(KINDS, strip_potentials(0.0, 0.5, 1.0)))
    >>> print(f"{values['chi_xx'] / np.pi:.12f} {values['chi_yy']}")
    1.000000000000 0.0
    """
    x, z = np.broadcast_arrays(np.asarray(x, dtype=float), np.asarray(z, dtype=float))
    z = np.where(z < SNAP * dx, 0.0, z)
    X = np.abs(x)
    ends = _Ends(_snapped(X - dx / 2, dx, z), X + dx / 2, np.full_like(X, dx))
    square = _Ends(ends.first**2 + z**2, ends.second**2 + z**2, 2 * X * dx)
    inverse = square.inverse()
    first = np.where(square.first > 0, square.first, (dx / (2 * np.e)) ** 2)
    logarithm = 0.5 * np.log1p(
        np.where(square.first > 0, square.step, square.second - first) / first
    )
    angle = np.arctan2(z * dx, z**2 + ends.first * ends.second)
    angle = np.where((z == 0) & (ends.first == 0), np.pi / 2, angle)
    mean_angle = 0.5 * (np.arctan2(ends.first, z) + np.arctan2(ends.second, z))
    mean_log = 0.25 * (np.log(first / reference**2) + np.log(square.second / reference**2))
    values = {
        "omega_xx": 2 * (dx * mean_log + X * logarithm - dx + z * angle),
        "chi_x": 2 * (dx * mean_angle + X * angle - z * logarithm),
        "phi_x": -2 * logarithm,
        "chi_xx": 2 * angle,
        "phi_xx": -2 * z * _step(ends, inverse),
        "phi_xz": -2 * z**2 * inverse.step,
    }
    result = np.zeros((len(KINDS), *X.shape))
    for kind, value in values.items():
        result[KINDS.index(kind)] = value
    result[_ODD_X] *= np.sign(x)
    return result


def triangle_potentials(x: np.ndarray, dx: float, reference: float = 1.0) -> dict[str, np.ndarray]:
    """Derivatives of the potentials at the surface, of a density that rises from zero to one over a
    length dx and falls again: the mean of strips over their width.

    Parameters
    ----------
    x : ndarray
        Field point minus the middle [length].
    dx : float
        Half of the base, the distance of elements [length].
    reference : float
        As of `strip_potentials`.

    Returns
    -------
    dict
        By kind, those of influence numbers.

    Examples
    --------
    >>> value = triangle_potentials(np.zeros(1), 1.0)["omega_xx"]
    >>> print(value)
    [-3.]
    """
    x = np.asarray(x, dtype=float)
    kinds = ("omega_xx", "omega_yy", "chi_x")
    values = dict.fromkeys(kinds, np.zeros(x.shape))
    # near, second differences of second antiderivatives of 2 ln|x| and pi sgn(x)
    ends = x[..., None] + dx * np.array([-1.0, 0.0, 1.0])
    size = np.where(ends == 0, reference, np.abs(ends))
    weights = np.array([1.0, -2.0, 1.0]) / dx
    values["omega_xx"] = (ends**2 * (np.log(size / reference) - 1.5)) @ weights
    values["chi_x"] = (np.pi / 2 * ends * np.abs(ends)) @ weights
    # far away, Gauss's rule
    far = np.abs(x) > TRIANGLE_FAR * dx
    places = x[far][:, None] + dx / 2 * _TRIANGLE_POINTS
    means = strip_potentials(places, 0.0, dx, reference) @ _TRIANGLE_WEIGHTS / 2
    for kind in kinds:
        values[kind] = values[kind].copy()
        values[kind][far] = means[KINDS.index(kind)]
    return values


def exchanged(kind: str) -> str:
    potential, underscore, letters = kind.partition("_")
    return f"{potential}{underscore}{''.join(sorted(letters.translate(str.maketrans('xy', 'yx'))))}"


_ODD_X = np.array([kind.count("x") % 2 == 1 for kind in KINDS])


def _snapped(distance: np.ndarray, side: float, z: np.ndarray) -> np.ndarray:
    """Distances from an edge, set to zero for points on the surface where they are only
    rounding.
    """
    if z.all():
        return distance
    return np.where((z == 0) & (np.abs(distance) < SNAP * side), 0.0, distance)


@dataclass(frozen=True, slots=True)
class _Ends:
    """Values of a function at both ends of a segment, and their difference without cancellation."""

    first: np.ndarray
    second: np.ndarray
    step: np.ndarray

    def __mul__(self, other: _Ends) -> _Ends:
        return _Ends(self.first * other.first, self.second * other.second, _step(self, other))

    def __add__(self, other: _Ends) -> _Ends:
        return _Ends(self.first + other.first, self.second + other.second, self.step + other.step)

    def inverse(self) -> _Ends:
        """Reciprocal; at a zero, which only a corner on the surface is, its mean over all
        directions: 0.
        """
        first = _reciprocal(self.first)
        second = _reciprocal(self.second)
        return _Ends(first, second, -self.step * first * second)


def _reciprocal(values: np.ndarray) -> np.ndarray:
    return np.divide(1.0, values, out=np.zeros_like(values), where=values != 0)


def _step(f: _Ends, g: _Ends) -> np.ndarray:
    """Difference of the product f g."""
    return f.first * g.step + f.step * g.second


class _Segment:
    """Integrals along a segment in the surface, of length dy, with its middle at (xi, y) off the
    field point.

    They are those for ``|y|``: the differences of functions of R alone are odd in y, and want the
    factor `odd`. Nearly all points are beside the segment, both ends on one side of them. Those
    between its ends (`between`) need other products, put in afterwards.
    """

    def __init__(
        self, xi: np.ndarray, y: np.ndarray, z: np.ndarray, dy: float, floor: float
    ) -> None:
        self.xi = xi
        self.z = z
        self.dy = dy
        self.floor = floor
        self.odd = np.sign(y)
        y = np.abs(y)
        self.eta = _Ends(_snapped(y - dy / 2, dy, z), y + dy / 2, np.full_like(y, dy))
        self.square = xi * xi + z * z
        first = np.sqrt(self.square + self.eta.first * self.eta.first)
        second = np.sqrt(self.square + self.eta.second * self.eta.second)
        self.y_step = 2 * dy * y
        self.r = _Ends(first, second, self.y_step / (first + second))
        self.product = first * second
        self.between = np.nonzero(np.broadcast_to(self.eta.first <= 0, first.shape))

    def _between(self) -> list[np.ndarray]:
        """The squared distance from the segment's line, R and eta at both ends."""
        values = (self.square, self.r.first, self.r.second, self.eta.first, self.eta.second)
        return [np.broadcast_to(value, self.product.shape)[self.between] for value in values]

    @lazy_property
    def inverse(self) -> np.ndarray:
        """Integral of 1/R: the difference of ln(R + eta)."""
        increase = self.dy + self.r.step
        with np.errstate(divide="ignore", invalid="ignore"):
            result = np.log1p(increase / (self.r.first + self.eta.first))
        if self.between[0].size:
            square, r1, _, eta1, _ = self._between()
            through = square == 0  # the segment passes through the field point, or ends there
            square[through] = self.floor**2
            r1[through] = np.hypot(self.floor, eta1[through])
            result[self.between] = np.log1p(increase[self.between] * (r1 - eta1) / square)
        return result

    @lazy_property
    def cube(self) -> np.ndarray:
        """Integral of 1/R^3: the difference of eta/R, by the squared distance of the segment's
        line.
        """
        sum_ = self.eta.second * self.r.first + self.eta.first * self.r.second
        with np.errstate(divide="ignore", invalid="ignore"):
            result = self.y_step / (self.product * sum_)
        if self.between[0].size:
            square, r1, r2, eta1, eta2 = self._between()
            result[self.between] = (eta2 * r1 - eta1 * r2) * _reciprocal(square * r1 * r2)
        return result

    @lazy_property
    def fifth(self) -> np.ndarray:
        """Integral of 1/R^5."""
        eta = self.eta
        squares = self.square + eta.first * eta.first + eta.second * eta.second
        with np.errstate(divide="ignore", invalid="ignore"):
            mixed = squares / (self.product + eta.first * eta.second)
        if self.between[0].size:
            square, r1, r2, eta1, eta2 = self._between()
            mixed[self.between] = (r1 * r2 - eta1 * eta2) / square
        return self.cube * (self.u.first**2 + self.u.second**2 + mixed / self.product) / 3

    @lazy_property
    def angle(self) -> np.ndarray:
        """Integral of xi/(R (R + z)): the difference of atan(xi eta/(xi^2 + z (R + z)))."""
        above = self.xi * self.square * (self.dy + self.z * self.cube * self.product)
        first = self.square + self.z * self.r.first
        second = self.square + self.z * self.r.second
        below = first * second + self.xi * self.xi * self.eta.first * self.eta.second
        return np.arctan2(above, below)

    @lazy_property
    def logarithm(self) -> np.ndarray:
        """Difference of ln(R + z)."""
        sum_ = self.r.first + self.z
        if not sum_.all():
            sum_[sum_ == 0] = self.floor
        return np.log1p(self.r.step / sum_)

    @lazy_property
    def u(self) -> _Ends:
        """1/R."""
        return self.r.inverse()

    @lazy_property
    def v(self) -> _Ends:
        """1/(R + z)."""
        return _Ends(self.r.first + self.z, self.r.second + self.z, self.r.step).inverse()

    @lazy_property
    def w(self) -> _Ends:
        """1/(R (R + z))."""
        return self.u * self.v

    @property
    def fall(self) -> _Ends:
        """-1/R times the derivative of w by R."""
        return self.w * self.w + self.w * (self.u * self.u)


_Form = Callable[[_Segment], np.ndarray]

_BETWEEN_EDGES: dict[str, _Form] = {
    "omega_xx": lambda s: (s.z * s.angle if s.z.any() else 0.0) - s.xi * s.inverse,
    "omega_xy": lambda s: s.odd * ((s.z * s.logarithm if s.z.any() else 0.0) - s.r.step),
    "chi_x": lambda s: s.xi * s.angle + s.z * s.inverse,
    "phi_x": lambda s: s.inverse,
    "chi_xx": lambda s: s.angle,
    "chi_xy": lambda s: s.odd * s.logarithm,
    "omega_xxy": lambda s: -s.odd * s.xi * s.v.step,
    "omega_xyy": lambda s: -_step(s.eta, s.v),
    "phi_xx": lambda s: -s.z * s.xi * s.cube,
    "phi_xy": lambda s: s.odd * s.z * s.u.step,
    "phi_xz": lambda s: -(s.z**2) * s.cube,
    "chi_xxy": lambda s: s.odd * s.z * s.xi * s.w.step,
    "chi_xyy": lambda s: s.z * _step(s.eta, s.w),
}
"""Integrals along an edge in y, whose difference over two edges is that over the element; others
are `exchanged`.

To chi_x belongs what the edges in x have in addition, see `_near`.
"""

_ALONG_Y: dict[str, _Form] = {
    "omega_xx": lambda s: _step(s.eta, s.v) - s.inverse,
    "omega_xy": lambda s: -s.xi * s.v.step,
    "omega_yy": lambda s: -_step(s.eta, s.v),
    "chi_x": lambda s: s.angle,
    "chi_y": lambda s: s.logarithm,
    "phi_x": lambda s: -s.xi * s.cube,
    "phi_y": lambda s: s.u.step,
    "chi_xx": lambda s: s.z * s.cube - _step(s.eta, s.w),
    "chi_xy": lambda s: s.xi * s.w.step,
    "chi_yy": lambda s: _step(s.eta, s.w),
    "omega_xxy": lambda s: s.xi**2 * (s.v * s.w).step - s.v.step,
    "omega_xyy": lambda s: s.xi * _step(s.eta, s.v * s.w),
    "phi_xx": lambda s: s.z * (3 * s.xi**2 * s.fifth - s.cube),
    "phi_xy": lambda s: -s.z * s.xi * (s.u * s.u * s.u).step,
    "phi_yy": lambda s: -s.z * _step(s.eta, s.u * s.u * s.u),
    "phi_xz": lambda s: 3 * s.xi * s.z**2 * s.fifth,
    "phi_yz": lambda s: -(s.z**2) * (s.u * s.u * s.u).step,
    "chi_xxy": lambda s: s.z * (s.w.step - s.xi**2 * s.fall.step),
    "chi_xyy": lambda s: -s.z * s.xi * _step(s.eta, s.fall),
}
"""The integrals of all kinds along a segment that the field point is not on."""


def _near(
    x: np.ndarray, y: np.ndarray, z: np.ndarray, dx: float, dy: float, kinds: Sequence[str]
) -> np.ndarray:
    """Differences over opposite edges of integrals along them; shapes as in
    `lattice_potentials`.
    """
    floor = min(dx, dy) / (2 * np.e)  # ln(floor) is the mean of ln|x| over the side
    z = np.where(z < SNAP * min(dx, dy), 0.0, z)
    columns = _snapped(np.concatenate([x + dx / 2, x[-1:] - dx / 2]), dx, z)
    rows = _snapped(np.concatenate([y + dy / 2, y[:, -1:] - dy / 2], axis=1), dy, z)
    along_y = _Segment(columns, y, z, dy, floor)
    along_x = _Segment(rows, x, z, dx, floor)
    differences = []
    for kind in kinds:
        if kind in _BETWEEN_EDGES:
            difference = -np.diff(_BETWEEN_EDGES[kind](along_y), axis=0)
        else:
            difference = -np.diff(_BETWEEN_EDGES[exchanged(kind)](along_x), axis=1)
        if kind == "chi_x":
            difference -= np.diff(along_x.odd * along_x.xi * along_x.logarithm, axis=1)
        elif kind == "chi_y":
            difference -= np.diff(along_y.odd * along_y.xi * along_y.logarithm, axis=0)
        differences.append(difference)
    return np.array(differences)


def _gauss(
    x: np.ndarray, y: np.ndarray, z: np.ndarray, dx: float, dy: float, kinds: Sequence[str]
) -> np.ndarray:
    """Closed forms along y, Gauss's rule along x."""
    total = np.zeros((len(kinds), x.size))
    for point, weight in zip(_GAUSS_POINTS, _GAUSS_WEIGHTS, strict=True):
        segment = _Segment(x - 0.5 * dx * point, y, z, dy, 0.0)
        total += 0.5 * dx * weight * np.array([_ALONG_Y[kind](segment) for kind in kinds])
    total[[kind.count("y") == 1 for kind in kinds]] *= np.sign(y)
    return total
