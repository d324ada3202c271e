"""Influence numbers of the elastic half-space: displacement difference by a uniform traction on a rectangle.

The integrals of Boussinesq and Cerruti (217) over a rectangle have closed forms (219)-(224) as corner
differences. Far from the element these cancel: at a distance of 10^4 elements the textbook forms lose all
but five digits. Here one direction is always integrated in closed form, with every difference taken before
it can cancel; in the other direction, where the field point is four or more element sides away, the
integrand is so smooth that seven Gauss points are exact to rounding, and nearer than that the closed form is
harmless.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable

import numpy as np

NEAR = 4.0
"""Distance in element sides from which Gauss's rule is used: its error there is below (1/15.9)^14 = 1.5e-17."""

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
    result = {kind: np.empty(x.shape) for kind in kinds - {"J3"}}
    for kind in result:
        result[kind][near] = _NEAR_FORMS[kind](x[near], y[near], dx, dy)
        result[kind][gauss_y] = _gauss(x[gauss_y], y[gauss_y], dx, dy, _LINE_FORMS[kind])
        result[kind][gauss_x] = _gauss(y[gauss_x], x[gauss_x], dy, dx, _LINE_FORMS[_SWAPPED[kind]])
    if "J3" in kinds:
        result["J3"] = _mixed(x, y, dx, dy)
    return result


def _mixed(x: np.ndarray, y: np.ndarray, dx: float, dy: float) -> np.ndarray:
    """J3 = -[[r]], with both differences of r written as products: nothing cancels, near or far."""
    x1, x2, y1, y2 = x - dx / 2, x + dx / 2, y - dy / 2, y + dy / 2
    r11, r21, r12, r22 = np.hypot(x1, y1), np.hypot(x2, y1), np.hypot(x1, y2), np.hypot(x2, y2)
    return 4 * dx * dy * x * y * (1 / (r11 + r12) + 1 / (r21 + r22)) / ((r11 + r21) * (r12 + r22))


_Line = Callable[[np.ndarray, np.ndarray, float], np.ndarray]


def _gauss(x: np.ndarray, y: np.ndarray, dx: float, dy: float, line: _Line) -> np.ndarray:
    """Closed form along x, Gauss's rule along y."""
    total = np.zeros(x.shape)
    for point, weight in zip(_GAUSS_POINTS, _GAUSS_WEIGHTS, strict=True):
        total += 0.5 * dy * weight * line(x, y - 0.5 * dy * point, dx)
    return total


def _edges(line: _Line, x: np.ndarray, y: np.ndarray, dx: float, dy: float) -> np.ndarray:
    """Difference over the two edges along x of the edge's distance times its line integral."""
    total = np.zeros(x.shape)
    for sign, edge in ((1.0, y + dy / 2), (-1.0, y - dy / 2)):
        off = edge != 0  # an edge through the field point adds nothing
        total[off] += sign * edge[off] * line(x[off], edge[off], dx)
    return total


# Integrals over a segment of length dx, centred at the distance x along it and y across it. The integrands are
# even or odd in x: with |x| the far end has x2 > 0, and differences over the ends are written as products.


def _ends(x: np.ndarray, y: np.ndarray, dx: float) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    x1, x2 = np.abs(x) - dx / 2, np.abs(x) + dx / 2
    return x1, x2, np.hypot(x1, y), np.hypot(x2, y)


def _line_inverse(x: np.ndarray, y: np.ndarray, dx: float) -> np.ndarray:
    """Integral of 1/R along the segment."""
    x1, x2, r1, r2 = _ends(x, y, dx)
    with np.errstate(divide="ignore", invalid="ignore"):
        beside = np.log1p((dx + dx * (x1 + x2) / (r1 + r2)) / (x1 + r1))
        around = np.arcsinh(x2 / np.abs(y)) - np.arcsinh(x1 / np.abs(y))
    return np.where(x1 > 0, beside, around)


def _line_across(x: np.ndarray, y: np.ndarray, dx: float) -> np.ndarray:
    """Integral of y^2/R^3 along the segment, the difference of x/r over its ends."""
    x1, x2, r1, r2 = _ends(x, y, dx)
    with np.errstate(divide="ignore", invalid="ignore"):
        beside = y**2 * dx * (x1 + x2) / (r1 * r2 * (x2 * r1 + x1 * r2))
        around = x2 / r2 - x1 / r1
    return np.where(x1 > 0, beside, around)


def _line_along(x: np.ndarray, y: np.ndarray, dx: float) -> np.ndarray:
    """Integral of x^2/R^3 along the segment."""
    return _line_inverse(x, y, dx) - _line_across(x, y, dx)


def _line_log(x: np.ndarray, y: np.ndarray, dx: float) -> np.ndarray:
    """Integral of x/R^2 along the segment, ln(r2/r1)."""
    x1, x2, r1, _ = _ends(x, y, dx)
    return np.sign(x) * 0.5 * np.log1p(dx * (x1 + x2) / r1**2)


def _line_angle(x: np.ndarray, y: np.ndarray, dx: float) -> np.ndarray:
    """Integral of y/R^2 along the segment: the angle under which it is seen."""
    x1, x2, _, _ = _ends(x, y, dx)
    return np.arctan2(y * dx, y**2 + x1 * x2)


_LINE_FORMS = {"J1": _line_inverse, "J2": _line_along, "J4": _line_across, "J5": _line_log, "J6": _line_angle}
_SWAPPED = {"J1": "J1", "J2": "J4", "J4": "J2", "J5": "J6", "J6": "J5"}
_NEAR_FORMS: dict[str, Callable[..., np.ndarray]] = {
    "J1": lambda x, y, dx, dy: _edges(_line_inverse, x, y, dx, dy) + _edges(_line_inverse, y, x, dy, dx),
    "J4": lambda x, y, dx, dy: _edges(_line_inverse, y, x, dy, dx),
    "J5": lambda x, y, dx, dy: _edges(_line_log, x, y, dx, dy) + _edges(_line_angle, y, x, dy, dx),
    "J6": lambda x, y, dx, dy: _edges(_line_log, y, x, dy, dx) + _edges(_line_angle, x, y, dx, dy),
}
