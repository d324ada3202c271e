"""Influence numbers of bodies that are given by a symbol, see
`varcontact.elasticity.fourier_symbol`.

Each harmonic exp(i m theta) of the compliance has the kernel exp(i m phi) h(r),
in closed form: of a power k^(n-1) by Weber's integral,

    h = i^m 2^n Gamma((1 + m + n)/2) / (2 pi Gamma((1 + m - n)/2)) r^(-1-n),

of a pole b by Gradshteyn and Ryzhik, 6.552.1,

    h = i^m b I(b r/2) K(b r/2) / (2 pi), I and K of the order m/2.

Over an element near by it is integrated in polar coordinates about the field
point: the radius in closed form, the angle along each side by Gauss's rule;
over one far away by Gauss's rule.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from varcontact.elasticity.fourier_symbol import FourierSymbol, at_each
from varcontact.elasticity.operators import GridOperator, Homogeneous
from varcontact.elasticity.shear_layer import springs
from varcontact.scene.grid import Grid
from varcontact.system.process import lazy_property
from varcontact.transports import HERE, Stencil

NEAR = 4.5
"""Distance in elements up to which numbers are integrated in polar coordinates."""
NEAR_BY_HARMONIC = 1 / 6
"""Distance in elements per order of the highest harmonic up to which numbers are integrated in
polar coordinates, where it exceeds `NEAR`."""
RULES = ((3.0, 8), (12.0, 5), (np.inf, 3))
"""Gauss rules on elements farther away: end of the range, divided by the limit of polar
integration, and points."""
PANELS = 8
PANEL_POINTS, PANEL_WEIGHTS = np.polynomial.legendre.leggauss(20)
STRIP_PANELS = 40
"""Halvings of a quarter of a circle towards 0: the longest waves of line contacts."""
AT_ONCE = 256
"""Places whose influence numbers are computed at a time."""
DEGREE = 20
"""Degree of the Chebyshev polynomials of kernels, each over a doubling of the distance."""
SHORTEST = 1e-7
"""Distance in elements from which kernels are tabulated."""


class _Radial(NamedTuple):
    """Functions of the distance by poles, in each doubling of it: edges, and Chebyshev coefficients
    (doublings, degree, M + 1, 3, 3) of kernels and of their integrals times r.
    """

    edges: np.ndarray
    kernels: np.ndarray
    integrals: np.ndarray


@dataclass(frozen=True)
class SymbolMedium(Homogeneous):
    """Bodies by a dimensionless symbol: a `Medium`."""

    symbol: FourierSymbol
    depth: float = 1.0

    @property
    def K(self) -> float:
        return self.symbol.coupling

    @lazy_property
    def even(self) -> bool:
        return self.symbol.mirrored("x")

    @lazy_property
    def even_y(self) -> bool:
        return self.symbol.mirrored("y")

    @property
    def reciprocal(self) -> bool:
        return True

    def operator(
        self, lattice: Grid, rows: str, columns: str, stencil: Stencil = HERE
    ) -> GridOperator:
        operator = super().operator(lattice, rows, columns, stencil)
        if not any(self.symbol.local):
            return operator
        compliances = dict(zip("xyz", self.symbol.local, strict=True))
        sprung = springs(lattice, rows, columns, stencil, compliances)
        return GridOperator(operator.shape, operator.table + sprung.table)

    def influence(
        self, grid: Grid, x: np.ndarray, y: np.ndarray, components: Iterable[str]
    ) -> dict[str, np.ndarray]:
        sides = grid.sides
        if grid.line:
            return {name: self.of_strips(x + 0 * y, sides[0], name) for name in components}
        x, y = np.broadcast_arrays(np.asarray(x, float), np.asarray(y, float))
        names = tuple(components)
        radial = None
        if not self.symbol.homogeneous:
            reach = float(np.hypot(x, y).max()) + max(sides)
            first = math.floor(math.log2(SHORTEST * min(sides)))
            radial = _radial(self.symbol, first, math.ceil(math.log2(reach)))
        elements = _Elements(self.symbol, names, sides, radial)
        numbers = elements.numbers(x.ravel(), y.ravel())
        return {name: numbers[:, i].reshape(x.shape) for i, name in enumerate(names)}

    def of_strips(self, x: np.ndarray, dx: float, name: str, theta: float = 0.0) -> np.ndarray:
        """Numbers at places x from a strip of a width, along the direction theta across it."""
        ends = np.array([x + dx / 2, x - dx / 2])
        after, before = _Strips(self.symbol, self.depth, name, theta).integrals(ends)
        return np.asarray(after - before)


@lru_cache(maxsize=4)
def _radial(symbol: FourierSymbol, first: int, last: int) -> _Radial:
    """The tables of all poles, over distances between two powers of 2."""
    edges = 2.0 ** np.arange(first, last + 1)
    nodes = np.polynomial.chebyshev.chebpts1(DEGREE + 1)
    distances = edges[1:, None] * (3 + nodes) / 4
    orders = np.arange(len(symbol.harmonics))
    parts = symbol.harmonics_of_parts * (1j**orders)[:, None, None] / (2 * np.pi)
    kernels = np.zeros((*distances.shape, *parts.shape[1:]), complex)
    b = symbol.poles.array
    arguments = np.multiply.outer(distances, b) / 2
    for m in orders:
        if parts[:, m].any():
            kernels[:, :, m] = np.tensordot(_product(m / 2, arguments) * b, parts[:, m], axes=1)
    to_coefficients = np.linalg.inv(np.polynomial.chebyshev.chebvander(nodes, DEGREE))
    moments = kernels * distances[..., None, None, None]
    return _Radial(
        edges,
        np.einsum("cn,pn...->pc...", to_coefficients, kernels),
        _integrated(np.einsum("cn,pn...->pc...", to_coefficients, moments), edges),
    )


def _integrated(coefficients: np.ndarray, edges: np.ndarray) -> np.ndarray:
    """Chebyshev coefficients, by interval, of the integral from 0."""
    # half of an interval from e/2 to e is e/4
    halves = edges[1:] / 4
    integrals = np.polynomial.chebyshev.chebint(coefficients, lbnd=-1, axis=1)
    integrals *= halves.reshape(-1, *(1,) * (coefficients.ndim - 1))
    ends = integrals.sum(axis=1)
    integrals[1:, 0] += np.cumsum(ends, axis=0)[:-1]
    return np.asarray(integrals)


def _product(order: float, x: np.ndarray) -> np.ndarray:
    """``I K`` of an order; below the range of floating point by its series."""
    from scipy import special

    with np.errstate(invalid="ignore", over="ignore"):
        product = special.ive(order, x) * special.kve(order, x)
    lost = ~np.isfinite(product) | ((product == 0) & (order > 0))
    if lost.any():
        product[lost] = (1 - x[lost] ** 2 / (2 * (order**2 - 1))) / (2 * order)
    return np.asarray(product)


@dataclass(frozen=True)
class _Strips:
    """Integrals from 0 of the kernel of lines, between two components, across a direction theta.

    Of short waves, and of a pole b, with F the compliance along theta and ``s = sin(t)``,

        -Re F ln(|x|/depth)/pi - Im F sgn(x)/2,
        Re F (K - int_0^(pi/2) (1 - exp(-b |x| s))/s dt)/pi - Im F sgn(x) int_0^(b |x|) K_0/pi,

    as ``int sin(k x)/sqrt(k^2 + b^2) dk = int exp(-b x s) dt``. The level K makes displacements
    vanish on the surface at the depth; that of bodies at rest, ``ln(2 b depth) + gamma``, at
    infinity.
    """

    symbol: FourierSymbol
    depth: float
    name: str
    theta: float

    def integrals(self, ends: np.ndarray) -> np.ndarray:
        """Integrals from 0 to some places."""
        places, index = np.unique(np.abs(ends), return_inverse=True)
        even, odd = self._of_short_waves(places)
        b = self.symbol.poles.array
        if b.size:
            F = self._along(self.symbol.harmonics_of_parts)
            even = even + self._even_of_poles(places) @ F.real
            odd = odd + _odd_of_poles(places, b) @ F.imag
        index = index.reshape(ends.shape)
        return np.asarray(np.sign(ends) * even[index] + odd[index])

    def _along(self, harmonics: np.ndarray) -> np.ndarray:
        """Compliances (n,) along theta, from harmonics (n, M + 1, 3, 3)."""
        i, j = ("xyz".index(each) for each in self.name)
        return at_each(harmonics, np.full(len(harmonics), self.theta))[:, i, j]

    def _of_short_waves(self, places: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        from scipy import special

        (F,) = self._along(self.symbol.harmonics[None])
        n = self.symbol.degree
        if n > 0:
            power = special.gamma(n) * places ** (1 - n) / (np.pi * (1 - n))
            quarter = n * np.pi / 2
            return F.real * np.cos(quarter) * power, -F.imag * np.sin(quarter) * power
        logarithms = np.log(np.where(places > 0, places, 1.0) / self.depth)
        return -F.real / np.pi * (places * logarithms - places), -F.imag / 2 * places

    def _even_of_poles(self, places: np.ndarray) -> np.ndarray:
        """Integrals (places, poles) of the even part, by Re F."""
        b = self.symbol.poles.array
        nodes, weights = _sines()
        if self.symbol.at_rest:
            levels = np.log(2 * b * self.depth) + np.euler_gamma
        else:
            levels = -(np.expm1(-np.multiply.outer(b * self.depth, nodes)) / nodes) @ weights
        total = np.multiply.outer(places, levels)
        for place, x in enumerate(places):
            z = np.multiply.outer(b * x, nodes)
            total[place] -= ((z + np.expm1(-z)) / nodes**2) @ weights / b
        return total / np.pi


def _odd_of_poles(places: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Integrals (places, poles) of the odd part, by Im F: ``int_0^z K_0`` by Struve functions,
    pi/2 where the rest is below rounding.
    """
    from scipy import special

    z = np.multiply.outer(places, b)
    near = np.clip(z, 1e-300, 40.0)
    k0 = special.k0(near)
    k1 = special.k1(near)
    below = special.modstruve(1, near) + 2 / np.pi
    integral = np.pi / 2 * near * (k0 * below + k1 * special.modstruve(0, near))
    inner = 1 - near * k1
    return np.asarray((inner / b - places[:, None] * integral) / np.pi)


@lru_cache(maxsize=1)
def _sines() -> tuple[np.ndarray, np.ndarray]:
    """Sines and weights of Gauss's rule over a quarter of a circle, on panels that halve towards
    0.
    """
    edges = np.concatenate([[0.0], np.pi / 2 * 2.0 ** np.arange(-STRIP_PANELS, 1)])
    points, weights = np.polynomial.legendre.leggauss(12)
    halves = np.diff(edges)[:, None] / 2
    t = edges[:-1, None] + halves * (1 + points)
    return np.sin(t).ravel(), (halves * weights).ravel()


@dataclass(frozen=True, eq=False)
class _Elements:
    """Influence numbers of an element between some components (c,)."""

    symbol: FourierSymbol
    components: tuple[str, ...]
    sides: tuple[float, float]
    radial: _Radial | None

    def numbers(self, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        """Numbers (n, c) at places from the centre of the element."""
        numbers = np.zeros((x.size, len(self.components)))
        far = np.maximum(np.abs(x), np.abs(y)) / max(self.sides)
        order = len(self.symbol.harmonics) - 1
        limit = max(NEAR, NEAR_BY_HARMONIC * order)
        for some in _few(np.flatnonzero(far < limit)):
            numbers[some] = self._near(x[some], y[some])
        least = limit
        for most, points in RULES:
            for some in _few(np.flatnonzero((far >= least) & (far < most * limit))):
                numbers[some] = self._far(x[some], y[some], points)
            least = most * limit
        return numbers

    def _far(self, x: np.ndarray, y: np.ndarray, order: int) -> np.ndarray:
        points, weights = np.polynomial.legendre.leggauss(order)
        dx, dy = self.sides
        a = x[:, None, None] - dx / 2 * points[:, None]
        b = y[:, None, None] - dy / 2 * points
        r = np.hypot(a, b)
        toward = (a + 1j * b) / r
        values = self._sums(toward.ravel(), r.ravel(), integrated=False)
        values = values.reshape(x.size, order * order, -1)
        every = np.outer(weights, weights).ravel()
        return np.asarray(np.einsum("p,npc->nc", every, values) * dx * dy / 4)

    def _near(self, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        """The sum over the sides, at signed distances d, of integrals over the angle: with ``sinh s
        = t/d``, t along the side, that is ds/cosh s.
        """
        half_x = self.sides[0] / 2
        half_y = self.sides[1] / 2
        total = np.zeros((x.size, len(self.components)))
        for normal, d, first, last in (
            (1.0, x + half_x, y - half_y, y + half_y),
            (-1.0, half_x - x, -y - half_y, half_y - y),
            (1j, y + half_y, -x - half_x, half_x - x),
            (-1j, half_y - y, x - half_x, x + half_x),
        ):
            size = np.maximum(np.abs(d), 1e-300)
            start = np.arcsinh(first / size)
            end = np.arcsinh(last / size)
            half = (end - start)[:, None] / (2 * PANELS)
            middles = start[:, None] + half * (2 * np.arange(PANELS) + 1)
            s = (middles[..., None] + half[..., None] * PANEL_POINTS).reshape(x.size, -1)
            # outside the element, a side is seen against its normal
            seen = np.where(d < 0, -1.0, 1.0)[:, None]
            cosh = np.cosh(s)
            toward = (seen / cosh + 1j * np.tanh(s)) * normal
            values = self._sums(toward.ravel(), (size[:, None] * cosh).ravel(), integrated=True)
            weights = np.tile(PANEL_WEIGHTS, PANELS) * half / cosh
            integral = np.einsum("np,npc->nc", weights, values.reshape(*s.shape, -1))
            signs = np.where(size > 1e-14 * max(self.sides), np.sign(d), 0.0)
            total += signs[:, None] * integral
        return total

    def _sums(self, toward: np.ndarray, r: np.ndarray, integrated: bool) -> np.ndarray:
        """Kernels (n, c) in directions exp(i phi) at distances r (n,), or their integrals times r
        up to r.
        """
        waves = np.empty((r.size, len(self._limit)), complex)
        waves[:, 0] = 1.0
        for m in range(1, waves.shape[1]):
            waves[:, m] = waves[:, m - 1] * toward
        waves[:, 1:] *= 2.0
        n = self.symbol.degree
        power = r ** (-1 - n)
        if integrated:
            power = r ** (1 - n) / (1 - n)
        total = (waves @ self._limit).real * power[:, None]
        if self.radial is not None:
            total += self._of_poles(waves, r, integrated)
        return np.asarray(total)

    def _of_poles(self, waves: np.ndarray, r: np.ndarray, integrated: bool) -> np.ndarray:
        assert self.radial is not None
        edges = self.radial.edges
        coefficients = self.radial.kernels
        if integrated:
            coefficients = self.radial.integrals
        coefficients = coefficients[:, :, :, self._rows, self._columns]
        r = np.clip(r, edges[0], edges[-1])
        place = np.clip(np.floor(np.log2(r / edges[0])).astype(int), 0, len(edges) - 2)
        t = 4 * r / edges[place + 1] - 3
        total = np.empty((r.size, len(self.components)))
        for p in np.unique(place):
            at = place == p
            own = coefficients[p]
            polynomials = np.polynomial.chebyshev.chebvander(t[at], len(own) - 1)
            values = (polynomials @ own.reshape(len(own), -1)).reshape(-1, *own.shape[1:])
            total[at] = np.einsum("nm,nmc->nc", waves[at], values).real
        return total

    @property
    def _rows(self) -> list[int]:
        return ["xyz".index(name[0]) for name in self.components]

    @property
    def _columns(self) -> list[int]:
        return ["xyz".index(name[1]) for name in self.components]

    @lazy_property
    def _limit(self) -> np.ndarray:
        """Harmonics (M + 1, c) of the kernels of short waves."""
        from scipy import special

        n = self.symbol.degree
        m = np.arange(len(self.symbol.harmonics))
        gammas = special.gammaln((1 + m + n) / 2) - special.gammaln((1 + m - n) / 2)
        factors = 1j**m * 2.0**n * np.exp(gammas) / (2 * np.pi)
        return np.asarray(self.symbol.harmonics[:, self._rows, self._columns] * factors[:, None])


def _few(places: np.ndarray) -> list[np.ndarray]:
    """Places in batches that take little memory."""
    return [places[i : i + AT_ONCE] for i in range(0, places.size, AT_ONCE)]
