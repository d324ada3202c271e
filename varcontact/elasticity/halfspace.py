"""Influence numbers of the elastic half-space: displacement difference by a uniform traction on a rectangle.

The integrals of Boussinesq and Cerruti (217) over a rectangle have closed forms (219)-(224) as corner
differences. Far from the element these cancel: at a distance of 10^4 elements the textbook forms lose all
but five digits. Here one direction is always integrated in closed form, with every difference taken before
it can cancel; in the other direction, where the field point is four or more element sides away, the
integrand is so smooth that seven Gauss points are exact to rounding, and nearer than that the closed form is
harmless.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from functools import cached_property
from operator import attrgetter
from typing import ClassVar, Protocol

import numpy as np

from varcontact.elasticity.plane_strain import strip_influence_numbers
from varcontact.scene.grid import Grid

NEAR = 4.0
"""Distance in element sides from which Gauss's rule is used: its error there is below (1/15.9)^14 = 1.5e-17."""

AT_A_TIME = 1000
"""Field points for which all of Gauss's points are evaluated together."""

_GAUSS_POINTS, _GAUSS_WEIGHTS = np.polynomial.legendre.leggauss(7)


def influence_numbers(
    x: np.ndarray,
    y: np.ndarray,
    dx: float,
    dy: float,
    *,
    nu: float,
    K: float = 0.0,
    G: float = 1.0,
    components: Iterable[str] = ("xx", "xy", "yy", "zz"),
) -> dict[str, np.ndarray]:
    """Influence numbers B_ij of a rectangle, (219)-(224) with the signs of (217).

    Parameters
    ----------
    x, y : array_like
        Field point minus element centre [length]; broadcast together.
    dx, dy : float
        Sides of the element [length].
    nu, K, G : float
        Combined constants (58)-(60).
    components : iterable of str
        Which of the nine: "xz" is the displacement difference along x by a unit pressure.

    Returns
    -------
    dict
        Component to array of the broadcast shape [length/(force/area)].

    Notes
    -----
    With ``J1 = [[1/R]]`` (the integral over the element of 1/R, and so on), ``J2 = [[x^2/R^3]]``,
    ``J3 = [[x y/R^3]]``, ``J4 = J1 - J2``, ``J5 = [[x/R^2]]``, ``J6 = [[y/R^2]]``:
    ``pi G B`` is ``J1 - nu J4`` (xx), ``J1 - nu J2`` (yy), ``nu J3`` (xy, yx), ``(1 - nu) J1`` (zz),
    ``-K J5`` (xz), ``K J5`` (zx), ``-K J6`` (yz), ``K J6`` (zy).

    Examples
    --------
    At the centre of a unit square, a unit pressure: ``(1 - nu)/(pi G) 4 asinh(1)``.

    >>> B = influence_numbers(0.0, 0.0, 1.0, 1.0, nu=0.3, components=["zz"])
    >>> print(f"{B['zz'] * np.pi / 0.7 / 4:.6f} {np.arcsinh(1):.6f}")
    0.881374 0.881374
    """
    x, y = np.broadcast_arrays(np.asarray(x, dtype=float), np.asarray(y, dtype=float))
    wanted = set(components)
    J = _integrals(x, y, dx, dy, {kind for component in wanted for kind in _NEEDS[component]})
    combine = {
        "xx": lambda: J["J1"] - nu * J["J4"],
        "yy": lambda: (1 - nu) * J["J1"] + nu * J["J4"],
        "xy": lambda: nu * J["J3"],
        "yx": lambda: nu * J["J3"],
        "zz": lambda: (1 - nu) * J["J1"],
        "xz": lambda: -K * J["J5"],
        "zx": lambda: K * J["J5"],
        "yz": lambda: -K * J["J6"],
        "zy": lambda: K * J["J6"],
    }
    return {component: combine[component]() / (np.pi * G) for component in wanted}


_NEEDS = {
    "xx": ("J1", "J4"),
    "yy": ("J1", "J4"),
    "xy": ("J3",),
    "yx": ("J3",),
    "zz": ("J1",),
    "xz": ("J5",),
    "zx": ("J5",),
    "yz": ("J6",),
    "zy": ("J6",),
}


def _integrals(x: np.ndarray, y: np.ndarray, dx: float, dy: float, kinds: set[str]) -> dict[str, np.ndarray]:
    """The integrals J over the element, each field point by the rule that suits it."""
    far_x, far_y = np.abs(x) / dx, np.abs(y) / dy
    near = np.maximum(far_x, far_y) < NEAR
    gauss_y = ~near & (far_y >= far_x)
    gauss_x = ~near & (far_y < far_x)
    lines = {kind: _LINE_FORMS[kind] for kind in kinds - {"J3"}}
    swapped = {kind: _LINE_FORMS[_SWAPPED[kind]] for kind in lines}
    result = {kind: np.empty(x.shape) for kind in lines}
    for kind in lines:
        result[kind][near] = _NEAR_FORMS[kind](x[near], y[near], dx, dy)
    for place, found in (
        (gauss_y, _gauss(x[gauss_y], y[gauss_y], dx, dy, lines)),
        (gauss_x, _gauss(y[gauss_x], x[gauss_x], dy, dx, swapped)),
    ):
        for kind, values in found.items():
            result[kind][place] = values
    if "J3" in kinds:
        # -[[r]], with both differences of r written as products: nothing cancels, near or far
        x1, x2, y1, y2 = x - dx / 2, x + dx / 2, y - dy / 2, y + dy / 2
        r11, r21, r12, r22 = _distance(x1, y1), _distance(x2, y1), _distance(x1, y2), _distance(x2, y2)
        result["J3"] = 4 * dx * dy * x * y * (1 / (r11 + r12) + 1 / (r21 + r22)) / ((r11 + r21) * (r12 + r22))
    return result


def _distance(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Lengths of vectors, as `numpy.hypot` in a quarter of its time: squares of them have to be numbers."""
    distance: np.ndarray = np.sqrt(x * x + y * y)
    return distance


class _Segment:
    """Integrals over a segment of length dx, centred at the distance x along it and y across it.

    The integrands are even or odd in x: with |x| the far end has x2 > 0, and differences over the ends are written as
    products. Beside the segment, where x1 > 0, they do not cancel; around it the plain differences do no harm.
    """

    def __init__(self, x: np.ndarray, y: np.ndarray, dx: float) -> None:
        self.x, self.y, self.dx = x, y, dx
        self.x1, self.x2 = np.abs(x) - dx / 2, np.abs(x) + dx / 2
        self.r1, self.r2 = _distance(self.x1, y), _distance(self.x2, y)  # of the ends
        self.around = self.x1 <= 0

    @cached_property
    def inverse(self) -> np.ndarray:
        """Integral of 1/R."""
        dx, x1, x2, r1, around = self.dx, self.x1, self.x2, self.r1, self.around
        with np.errstate(divide="ignore", invalid="ignore"):
            found: np.ndarray = np.log1p((dx + dx * (x1 + x2) / (r1 + self.r2)) / (x1 + r1))
        if around.any():
            y = np.abs(self.y[..., around])
            found[..., around] = np.arcsinh(x2[around] / y) - np.arcsinh(x1[around] / y)
        return found

    @cached_property
    def across(self) -> np.ndarray:
        """Integral of y^2/R^3, the difference of x/r over its ends."""
        x1, x2, r1, r2 = self.x1, self.x2, self.r1, self.r2
        with np.errstate(divide="ignore", invalid="ignore"):
            beside = self.y**2 * self.dx * (x1 + x2) / (r1 * r2 * (x2 * r1 + x1 * r2))
        return np.where(self.around, x2 / r2 - x1 / r1, beside)

    @property
    def along(self) -> np.ndarray:
        """Integral of x^2/R^3."""
        return self.inverse - self.across

    @property
    def log(self) -> np.ndarray:
        """Integral of x/R^2, ln(r2/r1)."""
        return np.sign(self.x) * 0.5 * np.log1p(self.dx * (self.x1 + self.x2) / self.r1**2)

    @property
    def angle(self) -> np.ndarray:
        """Integral of y/R^2: the angle under which the segment is seen."""
        return np.arctan2(self.y * self.dx, self.y**2 + self.x1 * self.x2)


_Form = Callable[[_Segment], np.ndarray]


def _gauss(x: np.ndarray, y: np.ndarray, dx: float, dy: float, forms: Mapping[str, _Form]) -> dict[str, np.ndarray]:
    """Closed forms along x, Gauss's rule along y: for so many field points (n,) at a time that they stay in cache."""
    totals = {kind: np.empty(x.shape) for kind in forms}
    points, weights = 0.5 * dy * _GAUSS_POINTS[:, None], 0.5 * dy * _GAUSS_WEIGHTS[:, None]
    for first in range(0, x.size, AT_A_TIME):
        some = slice(first, first + AT_A_TIME)
        line = _Segment(x[some], y[some] - points, dx)
        for kind, form in forms.items():
            totals[kind][some] = (weights * form(line)).sum(axis=0)
    return totals


def _edges(form: _Form, x: np.ndarray, y: np.ndarray, dx: float, dy: float) -> np.ndarray:
    """Difference over the two edges along x of the edge's distance times its line integral."""
    total = np.zeros(x.shape)
    for sign, edge in ((1.0, y + dy / 2), (-1.0, y - dy / 2)):
        off = edge != 0  # an edge through the field point adds nothing
        total[off] += sign * edge[off] * form(_Segment(x[off], edge[off], dx))
    return total


_INVERSE: _Form = attrgetter("inverse")
_LOG: _Form = attrgetter("log")
_ANGLE: _Form = attrgetter("angle")
_LINE_FORMS: dict[str, _Form] = {
    "J1": _INVERSE,
    "J2": attrgetter("along"),
    "J4": attrgetter("across"),
    "J5": _LOG,
    "J6": _ANGLE,
}
_SWAPPED = {"J1": "J1", "J2": "J4", "J4": "J2", "J5": "J6", "J6": "J5"}
_NEAR_FORMS: dict[str, Callable[..., np.ndarray]] = {
    "J1": lambda x, y, dx, dy: _edges(_INVERSE, x, y, dx, dy) + _edges(_INVERSE, y, x, dy, dx),
    "J4": lambda x, y, dx, dy: _edges(_INVERSE, y, x, dy, dx),
    "J5": lambda x, y, dx, dy: _edges(_LOG, x, y, dx, dy) + _edges(_ANGLE, y, x, dy, dx),
    "J6": lambda x, y, dx, dy: _edges(_LOG, y, x, dy, dx) + _edges(_ANGLE, x, y, dx, dy),
}


class Medium(Protocol):
    """Two bodies as solvers meet them, dimensionless: the combined modulus of rigidity of their surfaces is 1.

    Another kind of body is another medium, and nothing else. Media that are equal have equal influence numbers.

    Attributes
    ----------
    K : float
        Size of the coupling of pressure and tractions, of half-spaces the constant (60); 0: independent.
    even : bool
        Whether numbers are even or odd in x. All are even or odd in y.
    """

    @property
    def K(self) -> float: ...
    @property
    def even(self) -> bool: ...

    def influence(self, grid: Grid, x: np.ndarray, y: np.ndarray, components: Iterable[str]) -> dict[str, np.ndarray]:
        """Influence numbers of an element of a grid at points from its centre, which broadcast together.

        In line contact elements are strips, and y does not matter.
        """
        ...


@dataclass(frozen=True)
class HalfSpaces:
    """Two homogeneous, isotropic, elastic half-spaces (paper, section 2)."""

    nu: float
    K: float = 0.0
    depth: float = 1.0
    even: ClassVar[bool] = True  # as of all elastic bodies that are the same everywhere along x

    def influence(self, grid: Grid, x: np.ndarray, y: np.ndarray, components: Iterable[str]) -> dict[str, np.ndarray]:
        dx, dy = grid.sides
        if grid.line:
            return strip_influence_numbers(x, dx, nu=self.nu, K=self.K, depth=self.depth, components=components)
        return influence_numbers(x, y, dx, dy, nu=self.nu, K=self.K, components=components)
