"""Influence numbers of layered bodies: compliance by wave number, and its transform.

Fields that vary as exp(i k s) along the surface, s the direction of the wave
vector, t across it and zeta into the body, have displacements
``u_s = i u, u_zeta = w`` by tractions ``q_s = i q``, a pressure p and q_t:

    (u, w) = F(k) (q, p)/k,  u_t = f(k) q_t/k,  F real, symmetric and positive definite, f > 0,

constants for a half-space. The state (u, w, -q, -p) obeys dy/dzeta = k M y in a
layer, and is carried upwards from the base by matrices that are finite for all
thicknesses, moduli and ratios (the impedance recursion of seismology).

Of two bodies half-spaces of the surfaces' materials are taken in closed form.
What layers add is smooth, on the scale of the thickness of the top layer:
kernels of the distance alone, which Gauss's rule integrates over elements.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, replace
from functools import lru_cache
from itertools import pairwise
from typing import Any

import numpy as np

from varcontact.elasticity.halfspace import HalfSpaces
from varcontact.elasticity.operators import Homogeneous
from varcontact.scene.grid import Grid
from varcontact.system.process import lazy_property

CUT = 20.0
"""Wave number times the thickness of the top layer above which layers below have no influence:
exp(-2 CUT) CUT^2 = 2e-15."""

DEEP = 25.0
"""Largest wave number times the thickness of an inner layer: beyond it rounding, which grows as its
square, would be visible."""

OCTAVES = 60
"""Halvings of the panels of wave numbers towards 0: enough for any ratio of thicknesses and
moduli."""

DEGREE = 20
"""Degree of the Chebyshev polynomials of kernels, each over a doubling of the distance: 5.8^-21 =
9e-17."""

_ORDERS = range(2, 10)
"""Orders of Gauss's rules on parts of elements."""

_GAUSS = np.zeros((2, _ORDERS.stop, _ORDERS.stop - 1))
for _order in _ORDERS:
    _GAUSS[:, _order, :_order] = np.polynomial.legendre.leggauss(_order)
_PANEL_POINTS, _PANEL_WEIGHTS = np.polynomial.legendre.leggauss(16)
_NODES_AT_ONCE = 200_000


@dataclass(frozen=True)
class Stack:
    """Layers (thickness, G, nu) from the surface downwards, and a base: a half-space (G, nu),
    "rigid" or "smooth".

    Moduli may be complex numbers, one for each wave number (n,).
    """

    layers: tuple[tuple[float, Any, float], ...]
    base: tuple[Any, float] | str

    @property
    def surface(self) -> np.ndarray:
        """Compliance of a half-space of the material at the surface."""
        if self.layers:
            _, G, nu = self.layers[0]
            return half_space(G, nu)
        return half_space(*self.base)

    @property
    def thickness(self) -> float:
        if not self.layers:
            return np.inf
        return self.layers[0][0]

    @property
    def rests_along(self) -> bool:
        """True for a base that does not move along the surface, as of a rigid body."""
        return not self.surface.any() or self.base == "rigid"

    @property
    def rests_down(self) -> bool:
        """True for a base that does not move into the body."""
        return self.rests_along or self.base == "smooth"

    def compliance(self, k: np.ndarray) -> np.ndarray:
        """F11, F12, F22 and f at wave numbers (n,), shape (4, n)."""
        F = np.zeros((4, k.size)) if isinstance(self.base, str) else half_space(*self.base, k)
        if not self.layers:
            return F
        # two states that the base admits, and displacement and load across the wave vector
        state = _states(F[:3])
        f = F[3]
        load = 1.0
        if self.base == "smooth":
            state[:, 0] = np.array([[1.0], [0.0], [0.0], [0.0]])
            f = np.ones(k.size)
            load = 0.0
        for h, G, nu in reversed(self.layers):
            # the states at the upper side of the layer
            state = np.einsum("abn,bcn->acn", _transfer(k * h, G, nu), state)
            u0, u1 = state[0]
            w0, w1 = state[1]
            q0, q1 = -state[2]
            p0, p1 = -state[3]
            # the compliance there, and states of unit loads
            determinant = q0 * p1 - q1 * p0
            F = np.array([u0 * p1 - u1 * p0, u1 * q0 - u0 * q1, w1 * q0 - w0 * q1]) / determinant
            F = np.where(k * h > DEEP, half_space(G, nu, k)[:3], F)
            state = _states(F)
            t = np.tanh(k * h)
            f = (f + t / G * load) / (load + G * t * f)
            load = 1.0
        return np.concatenate([F, [f]])


def half_space(G: float, nu: float, k: np.ndarray | float = 0.0) -> np.ndarray:
    """F11, F12, F22 and f of a half-space, (4,), or (4, n) for moduli or wave numbers (n,)."""
    return np.multiply.outer([1 - nu, (1 - 2 * nu) / 2, 1 - nu, 1.0], 1 / (np.asarray(G) + 0.0 * k))


def _states(F: np.ndarray) -> np.ndarray:
    """States of a unit q and of a unit p, (4, 2, n)."""
    zero = np.zeros_like(F[0])
    one = np.ones_like(F[0])
    return np.array([[F[0], F[1]], [F[1], F[2]], [-one, zero], [zero, -one]])


def _transfer(kappa: np.ndarray, G: float, nu: float) -> np.ndarray:
    """exp(-kappa M) exp(-kappa), (4, 4, n): from the lower to the upper side of a layer.

    With N = M^2 - 1 and N^2 = 0: ``c - s M + kappa s N/2 - (kappa c - s) M N/2``, c and s
    hyperbolic functions.
    """
    # deeper layers have no influence, but rounding would have
    kappa = np.minimum(kappa, 60.0)
    eta = nu / (1 - nu)
    M = np.array(
        [[0, -1, 1, 0], [eta, 0, 0, (1 - eta) / 2], [2 / (1 - nu), 0, 0, -eta], [0, 0, 1, 0]]
    )
    N = M @ M - np.eye(4)
    terms = np.array([np.eye(4), -M, N / 2, -M @ N / 2])
    c = (1 + np.exp(-2 * kappa)) / 2
    s = -np.expm1(-2 * kappa) / 2
    # kappa c - s by its series where that cancels
    square = kappa**2
    series = 1 + square / 10 * (
        1 + square / 28 * (1 + square / 54 * (1 + square / 88 * (1 + square / 130)))
    )
    last = np.where(kappa < 0.7, np.exp(-kappa) * kappa * square / 3 * series, kappa * c - s)
    transfer = np.tensordot(terms, np.array([c, s, kappa * s, last]), axes=(0, 0))
    units = np.array([np.ones_like(G * kappa)] * 2 + [G * np.ones_like(kappa)] * 2)
    return np.asarray(transfer * (units[:, None] / units))


@dataclass(frozen=True)
class LayeredPair(Homogeneous):
    """Two stacks of layers, the upper and the lower: a `Medium`.

    Displacements by a wave of tractions are ``u_s = (alpha p_s + i kappa p_z)/k``, ``u_t = beta
    p_t/k`` and ``u_z = (-i kappa p_s + gamma p_z)/k``. Those of line contact count from the depth,
    but from bases that do not move.
    """

    upper: Stack
    lower: Stack
    depth: float = 1.0

    @lazy_property
    def K(self) -> float:
        """Largest size of the coupling over all wave numbers."""
        if self.upper == self.lower:
            return 0.0
        k = np.geomspace(1e-6, 1e3, 400) / self.thickness
        _, kappa, _, _ = self.symbols(k)
        largest = float(np.abs(kappa).max()) / 2
        return largest if largest > 1e-15 else 0.0

    @property
    def thickness(self) -> float:
        """Thickness of the thinner top layer: the scale of what layers add."""
        return min(self.upper.thickness, self.lower.thickness)

    @property
    def at_rest(self) -> tuple[bool, bool, bool]:
        """Directions (x, y, z) along which both bodies rest on bases that do not move."""
        along = all(stack.rests_along for stack in (self.upper, self.lower))
        down = all(stack.rests_down for stack in (self.upper, self.lower))
        return along, along, down

    def symbols(self, k: np.ndarray | None = None) -> np.ndarray:
        """alpha, kappa, gamma and beta at wave numbers (n,), shape (4, n); or in the limit of large
        ones.
        """
        if k is None:
            upper = self.upper.surface
            lower = self.lower.surface
        else:
            upper = self.upper.compliance(k)
            lower = self.lower.compliance(k)
        both = upper + lower
        both[1] = upper[1] - lower[1]
        return both

    def influence(
        self, grid: Grid, x: np.ndarray, y: np.ndarray, components: Iterable[str]
    ) -> dict[str, np.ndarray]:
        """Influence numbers: half-spaces of the surfaces in closed form, and what layers add."""
        alpha, kappa, *_ = self.symbols()
        half_spaces = HalfSpaces(float(1 - alpha / 2), float(kappa / 2), self.depth)
        numbers = half_spaces.influence(grid, x, y, components)
        for name, added in added_numbers(self, grid, x, y, [*numbers]).items():
            numbers[name] = numbers[name] + added
        return numbers


# ---------------------------------------------------------------------- kernels of points and lines


def wave_numbers(thickness: float, near: float, far: float) -> tuple[np.ndarray, np.ndarray]:
    """Gauss points and weights (n,) for transforms at distances from `near` to `far`.

    At a distance only small wave numbers count: the integrand may end smoothly, over 12 of 1/near,
    which leaves an error of exp(-36).
    """
    top = CUT / thickness
    smooth = near * CUT > 144 * thickness
    if smooth:
        top = 144 / near
    # panels of each octave, so short that waves at the farthest distance are resolved
    edges = [0.0, *(top * 0.5 ** np.arange(OCTAVES, -1, -1))]
    parts = [
        np.arange(a, b, (b - a) / math.ceil((b - a) * far / (2 * np.pi)))
        for a, b in pairwise(edges)
    ]
    left = np.concatenate([*parts, [top]])
    half = np.diff(left)[:, None] / 2
    k = (left[:-1, None] + half * (1 + _PANEL_POINTS)).ravel()
    weights = (half * _PANEL_WEIGHTS).ravel()
    if smooth:
        from scipy import special

        weights = weights * special.erfc(near * k / 12 - 6) / 2
    return k, weights


@lru_cache(maxsize=8)
def _kernels(pair: LayeredPair, doublings: int, line: bool) -> tuple[np.ndarray, np.ndarray]:
    """Additions of layers to four functions of the distance: edges of intervals, and their
    Chebyshev coefficients.

    Those of point loads are the transforms I0[(alpha + beta)/2], I2[(alpha - beta)/2], I0[gamma]
    and I1[kappa] with Bessel functions; those of line loads are of alpha, beta and gamma with
    cosines, 0 at the last edge, and of kappa with sines.
    """
    from scipy import special

    edges = np.concatenate([[0.0], pair.thickness * 2.0 ** np.arange(doublings + 1)])
    nodes = np.polynomial.chebyshev.chebpts1(DEGREE + 1)
    coefficients = np.empty((doublings + 1, DEGREE + 1, 4))
    beyond = np.zeros(4)
    for i in range(doublings, -1, -1):
        near = edges[i]
        far = edges[i + 1]
        k, weights = wave_numbers(pair.thickness, near, far)
        alpha, kappa, gamma, beta = (pair.symbols(k) - pair.symbols()[:, None]) * weights
        r = np.append((near + far) / 2 + (far - near) / 2 * nodes, near)[:, None]
        if line:
            cosines = -2 * np.sin(k * (r + far) / 2) * np.sin(k * (r - far) / 2)
            even = [cosines @ (symbol / k) for symbol in (alpha, beta, gamma)]
            values = np.array([*even, np.sin(k * r) @ (kappa / k)]).T / np.pi
            values[:, :3] += beyond[:3]
            beyond = values[-1]
        else:
            J0 = special.j0(k * r)
            J1 = special.j1(k * r)
            J2 = special.jv(2, k * r)
            values = np.array(
                [J0 @ (alpha + beta) / 2, J2 @ (alpha - beta) / 2, J0 @ gamma, J1 @ kappa]
            )
            values = values.T / (2 * np.pi)
        coefficients[i] = np.polynomial.chebyshev.chebfit(nodes, values[:-1], DEGREE)
    return edges, coefficients


def _kernel_values(
    edges: np.ndarray, coefficients: np.ndarray, r: np.ndarray, which: list[int]
) -> np.ndarray:
    """Some of the four functions at distances (n,), shape (which, n)."""
    values = np.empty((len(which), r.size))
    place = np.searchsorted(edges[1:-1], r, side="right")
    for i in np.unique(place):
        inside = np.flatnonzero(place == i)
        a, b = edges[i : i + 2]
        at = (2 * r[inside] - a - b) / (b - a)
        values[:, inside] = np.polynomial.chebyshev.chebval(at, coefficients[i][:, which])
    return values


# ----------------------------------------------------------------------------- elements

_Component = Callable[[dict[int, np.ndarray], np.ndarray, np.ndarray], np.ndarray]
_OF_POINTS: dict[str, _Component] = {
    "xx": lambda f, c, s: f[0] - (c * c - s * s) * f[1],
    "yy": lambda f, c, s: f[0] + (c * c - s * s) * f[1],
    "xy": lambda f, c, s: -2 * c * s * f[1],
    "yx": lambda f, c, s: -2 * c * s * f[1],
    "zz": lambda f, c, s: f[2],
    "xz": lambda f, c, s: -c * f[3],
    "zx": lambda f, c, s: c * f[3],
    "yz": lambda f, c, s: -s * f[3],
    "zy": lambda f, c, s: s * f[3],
}
"""Components by the four functions, and cosine and sine of the direction from the load to the
point."""

_OF_LINES = {name: _OF_POINTS[name] for name in ("zz", "xz", "zx")} | {
    "xx": lambda f, c, s: f[0],
    "yy": lambda f, c, s: f[1],
}
_NEEDED = {"xx": (0, 1), "yy": (0, 1), "xy": (1,), "yx": (1,), "zz": (2,)}


def added_numbers(
    pair: LayeredPair, grid: Grid, x: np.ndarray, y: np.ndarray, components: list[str]
) -> dict[str, np.ndarray]:
    """Additions of layers to influence numbers: the kernels' integrals over the element."""
    x, y = np.broadcast_arrays(np.asarray(x, dtype=float), np.asarray(y, dtype=float))
    if x.size == 0:
        return {}
    dx, dy = grid.sides
    line = grid.line
    if line:
        forms = _OF_LINES
        reach = max(np.abs(x).max() + dx, pair.depth)
    else:
        forms = _OF_POINTS
        reach = np.hypot(np.abs(x).max() + dx, np.abs(y).max() + dy)
    forms = {name: form for name, form in forms.items() if name in components}
    # the kernels as functions of the distance
    doublings = max(math.ceil(math.log2(reach / pair.thickness)), 0)
    edges, coefficients = _kernels(replace(pair, depth=1.0), doublings, line)
    which = sorted({i for name in forms for i in _NEEDED.get(name, (3,))})
    numbers = {name: np.empty(x.shape) for name in forms}
    # their integrals over the element
    for part, starts, from_x, from_y, weights in _products(
        grid, x.ravel(), y.ravel(), pair.thickness
    ):
        r = np.hypot(from_x, from_y)
        away = np.maximum(r, np.finfo(float).tiny)
        values = dict(zip(which, _kernel_values(edges, coefficients, r, which), strict=True))
        for name, form in forms.items():
            integrand = form(values, from_x / away, from_y / away) * weights
            numbers[name].reshape(-1)[part] = np.add.reduceat(integrand, starts)
    if line:
        at_zero = _displacement_at_zero(pair, edges, coefficients)
        for i, name in enumerate(("xx", "yy", "zz")):
            if name in numbers:
                numbers[name] -= dx * at_zero[i]
    return numbers


def _displacement_at_zero(
    pair: LayeredPair, edges: np.ndarray, coefficients: np.ndarray
) -> np.ndarray:
    """Displacements along x, y and z, added by layers, of line loads at the place where they are
    set to zero: at the depth, or on fixed bases.
    """
    from scipy import special

    distances = np.array([pair.depth, pair.thickness])
    at_depth, near = _kernel_values(edges, coefficients, distances, [0, 1, 2]).T
    # on a base: integrals of symbols times cos(k h)/(pi k), less those of half-spaces
    h = pair.thickness
    k, factors = wave_numbers(h, 0.0, h)
    beyond = np.log(h / pair.depth) - special.sici(CUT)[1]
    integrals = pair.symbols(k) @ (factors * np.cos(k * h) / k)
    on_base = ((integrals + pair.symbols() * beyond) / np.pi)[[0, 3, 2]]
    return np.where(pair.at_rest, near - on_base, at_depth)


def _rules(distance: np.ndarray, side: float, thickness: float) -> tuple[np.ndarray, ...]:
    """Gauss's rules over the side of an element, for distances (n,) of its middle from some points.

    Distances and weights of all nodes; the first of each point, and how many it has. Parts are no
    longer than 1.5 max(thickness, distance/2).
    """
    places, index = np.unique(distance, return_inverse=True)
    low = places[:, None] - side / 2
    high = places[:, None] + side / 2
    # parts of the side
    breaks = [0.0]
    while breaks[-1] < max(high[-1, 0], -low[0, 0]):
        breaks.append(breaks[-1] + 1.5 * max(thickness, breaks[-1] / 2))
    edges = np.clip([*(-each for each in breaks[:0:-1]), *breaks], low, high)
    owner, part = np.nonzero(np.diff(edges, axis=1))
    left = edges[owner, part]
    right = edges[owner, part + 1]
    # the order of the rule on each
    scale = np.maximum(thickness, np.minimum(np.abs(left), np.abs(right)) / 2)
    # singularities are 2 scale or more away
    order = np.ceil(15 / np.log(8 * scale / (right - left))).astype(int)
    order = np.clip(order, _ORDERS.start, _ORDERS[-1])
    # all nodes, one part after the other
    of = np.repeat(np.arange(order.size), order)
    points, weights = _GAUSS[:, order[of], _ramps(order)]
    half = (right - left)[of] / 2
    count = np.bincount(owner[of])
    first = np.cumsum(count) - count
    return left[of] + half * (1 + points), half * weights, first[index], count[index]


def _ramps(counts: np.ndarray) -> np.ndarray:
    """Numbers 0 to count - 1 for each of several counts, concatenated."""
    return np.arange(counts.sum()) - np.repeat(np.cumsum(counts) - counts, counts)


def _products(
    grid: Grid, x: np.ndarray, y: np.ndarray, scale: float
) -> Iterator[tuple[np.ndarray, ...]]:
    """Products of the rules along x and y over an element of a grid, for distances (n,), some
    points at a time.

    The points, where the nodes of each start, the nodes' distances along x and along y, and their
    weights.
    """
    dx, dy = grid.sides
    x_nodes, x_weights, x_first, x_count = _rules(x, dx, scale)
    if grid.line:  # one node
        y_nodes = np.zeros(1)
        y_weights = np.ones(1)
        y_first = np.zeros(y.size, dtype=int)
        y_count = np.ones(y.size, dtype=int)
    else:
        y_nodes, y_weights, y_first, y_count = _rules(y, dy, scale)
    sizes = x_count * y_count
    cuts = np.flatnonzero(np.diff(np.cumsum(sizes) // _NODES_AT_ONCE)) + 1
    for part in np.split(np.arange(sizes.size), cuts):
        node = _ramps(sizes[part])
        count = np.repeat(y_count[part], sizes[part])
        i = np.repeat(x_first[part], sizes[part]) + node // count
        j = np.repeat(y_first[part], sizes[part]) + node % count
        starts = np.cumsum(sizes[part]) - sizes[part]
        yield part, starts, x_nodes[i], y_nodes[j], x_weights[i] * y_weights[j]
