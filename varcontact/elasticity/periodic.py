"""Influence numbers of bodies and surfaces that repeat: a grid is one period along x, or along x
and y.

Tractions that are constant on elements have, at the centres of elements, the
transform

    S(k) = sum over aliases f(k + K) sinc(x) sinc(y),

K whole multiples of the grid's own wave numbers, x and y half the wave numbers
times the sides. Signs alternate: Euler's means end each sum. Aliases beyond the
nearest are analytic on the first zone, and interpolated from Chebyshev nodes.
With tractions that are trigonometric polynomials S is f itself.

Where they repeat along x only, waves along x decay over rows like
exp(-k_x |y|): a period along y so long that they are gone serves. Their mean
over x is that of a line contact.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache
from typing import ClassVar

import numpy as np

from varcontact.elasticity.halfspace import HalfSpaces
from varcontact.elasticity.layered import LayeredPair
from varcontact.elasticity.operators import GridOperator
from varcontact.elasticity.symbol_medium import SymbolMedium
from varcontact.errors import SceneError
from varcontact.scene.grid import Grid
from varcontact.transports import HERE, Stencil

WHOLE = 12
"""Terms of a sum of aliases before Euler's means, which have as many again: error 5e-13."""
NODES = 18
"""Chebyshev nodes along each axis of the first zone."""
DECAY = 5.5
"""Periods along x after which the longest wave has decayed to 1e-15, exp(-2 pi 5.5)."""
LONG_WAVE = 1e-5
"""Wave number, times the thickness, that is used in place of 0 for bodies on a fixed base."""
ON_LATTICE = 1e-9
"""Difference from whole elements that counts as rounding."""

Repeating = HalfSpaces | LayeredPair | SymbolMedium
TimesK = Callable[[np.ndarray, np.ndarray], np.ndarray]
"""k times the compliances (n, names) at wave numbers and directions (n,)."""


@dataclass(frozen=True)
class Periodic:
    """A medium with a grid (ny, nx) as its period along x, and where `rows_repeat` along y."""

    flat: Repeating
    shape: tuple[int, int]
    rows_repeat: bool
    trigonometric: bool = False
    reciprocal: ClassVar[bool] = True

    @property
    def K(self) -> float:
        """Size of the coupling of pressure and tractions."""
        return self.flat.K

    @property
    def even(self) -> bool:
        """True where influence numbers are even or odd in x."""
        return self.flat.even

    @property
    def at_once(self) -> Periodic:
        """Elastic bodies do not relax."""
        return self

    def at_end(self, time: float) -> Periodic:
        """Elastic bodies do not relax."""
        return self

    def operator(
        self, lattice: Grid, rows: str, columns: str, stencil: Stencil = HERE
    ) -> GridOperator:
        """Displacements along `rows` by tractions along `columns`, combined over a stencil."""
        names = tuple(row + column for row in rows for column in columns)
        first = _numbers(self, lattice.sides, names)
        total = np.zeros_like(first)
        for ahead, weight in stencil:
            total += weight * np.roll(first, -_whole_elements(ahead / lattice.sides[0]), axis=-1)
        # offsets from -(n - 1) to n - 1
        ny, nx = lattice.shape
        columns_of = np.arange(1 - nx, nx) % self.shape[1]
        rows_of = np.arange(1 - ny, ny) % total.shape[1]
        table = total[:, rows_of[:, None], columns_of]
        whole = ny == self.shape[0], nx == self.shape[1]
        period = (self.rows_repeat and whole[0], whole[1])
        table = table.reshape(len(rows), len(columns), *table.shape[1:])
        return GridOperator(lattice.shape, table, period=period)


def _whole_elements(columns: float) -> int:
    whole = round(columns)
    if abs(columns - whole) > ON_LATTICE * max(1.0, abs(columns)):
        allowed = "a whole number of elements: a periodic grid has no numbers between them"
        raise SceneError("motion.dq", f"{columns:.6g} elements", allowed)
    return whole


@lru_cache(maxsize=4)
def _numbers(medium: Periodic, sides: tuple[float, float], names: tuple[str, ...]) -> np.ndarray:
    """Influence numbers (names, rows, nx) by offset, from zero on and back from the end."""
    times_k = _symbol_of(medium.flat, names)
    ny, nx = medium.shape
    dx, dy = sides
    rows = ny
    if not medium.rows_repeat:
        from scipy.fft import next_fast_len

        rows = next_fast_len(2 * ny + math.ceil(DECAY * nx * dx / dy), real=True)
    kx = 2 * np.pi * np.fft.rfftfreq(nx, dx)
    ky = 2 * np.pi * np.fft.fftfreq(rows, dy)
    if medium.trigonometric:
        total = _values(times_k, *np.meshgrid(kx, ky))
    else:
        total = _aliases(times_k, kx, ky, sides)
    if medium.rows_repeat:
        total[0, 0] = _of_mean(medium.flat, times_k, names, nx * dx)
        return np.asarray(np.fft.irfft2(np.moveaxis(total, -1, 0), (rows, nx)))
    total[:, 0] = 0.0
    numbers = np.fft.irfft2(np.moveaxis(total, -1, 0), (rows, nx))
    # the mean over x is that of strips along x
    offset = np.arange(rows)
    signed = np.where(offset > rows // 2, offset - rows, offset)
    strips = _strips_along_x(medium.flat, signed * dy, dy, names)
    return np.asarray(numbers + strips[..., None] / nx)


def _of_mean(
    flat: Repeating, times_k: TimesK, names: tuple[str, ...], longest: float
) -> np.ndarray:
    """Mean displacements by mean tractions: those of bodies on a base at rest, else as a wave as
    long as the period has by pressures.

    Without a base they are infinite, and finite ones only move displacements as a whole, and make
    the numbers positive definite.
    """
    k = 2 * np.pi / longest
    at_rest = (False, False, False)
    if isinstance(flat, LayeredPair):
        at_rest = flat.at_rest
    of_wave = float(_symbol_of(flat, ("zz",))(np.array([k]), np.zeros(1))[0, 0].real) / k
    mean = np.zeros(len(names))
    for place, name in enumerate(names):
        if name[0] != name[1]:
            continue
        mean[place] = of_wave
        if isinstance(flat, LayeredPair) and at_rest["xyz".index(name[0])]:
            long = LONG_WAVE / flat.thickness
            mean[place] = float(times_k(np.array([long]), np.zeros(1))[0, place].real) / long
    return mean


def _strips_along_x(
    flat: Repeating, y: np.ndarray, dy: float, names: tuple[str, ...]
) -> np.ndarray:
    """Influence numbers (names, n) of strips along x, as in a line contact across them."""
    if isinstance(flat, SymbolMedium):
        return np.stack([flat.of_strips(y, dy, name, np.pi / 2) for name in names])
    across = str.maketrans("xy", "yx")
    strips = Grid(nx=1, dx=dy, x0=0.0)
    turned = [name.translate(across) for name in names]
    numbers = flat.influence(strips, y, np.zeros(1), turned)
    return np.stack([np.broadcast_to(numbers[name], y.shape) for name in turned])


def _symbol_of(flat: Repeating, names: tuple[str, ...]) -> TimesK:
    """k f between some components."""
    if isinstance(flat, SymbolMedium):
        rows = ["xyz".index(name[0]) for name in names]
        columns = ["xyz".index(name[1]) for name in names]
        symbol = flat.symbol
        return lambda k, theta: symbol.times_k(k, theta)[:, rows, columns]
    if isinstance(flat, HalfSpaces):
        normal = 2 * (1 - flat.nu)
        constants = np.array([normal, 2 * flat.K, normal, 2.0])[:, None]
        return lambda k, theta: _isotropic(constants, theta, names)
    pair = flat
    return lambda k, theta: _isotropic(pair.symbols(k), theta, names)


def _isotropic(symbols: np.ndarray, theta: np.ndarray, names: tuple[str, ...]) -> np.ndarray:
    """k f (n, names) from alpha, kappa, gamma and beta (4, n), see `LayeredPair`."""
    alpha, kappa, gamma, beta = symbols
    along = {"x": np.cos(theta), "y": np.sin(theta)}
    f = np.zeros((theta.size, len(names)), complex)
    for place, name in enumerate(names):
        i = name[0]
        j = name[1]
        if i == j == "z":
            f[:, place] = gamma
        elif i == "z":
            f[:, place] = -1j * kappa * along[j]
        elif j == "z":
            f[:, place] = 1j * kappa * along[i]
        else:
            f[:, place] = (alpha - beta) * along[i] * along[j]
            f[:, place] += beta * (i == j)
    return f


def _values(times_k: TimesK, kx: np.ndarray, ky: np.ndarray) -> np.ndarray:
    """f (ny, nx, names) at wave numbers; zero at 0."""
    k = np.hypot(kx, ky).ravel()
    origin = k == 0
    k[origin] = 1.0
    theta = np.arctan2(ky, kx).ravel()
    values = times_k(k, theta) / k[:, None]
    values[origin] = 0.0
    return values.reshape(*kx.shape, -1)


def _aliases(
    times_k: TimesK, kx: np.ndarray, ky: np.ndarray, sides: tuple[float, float]
) -> np.ndarray:
    """The sum over all aliases (ny, nx, names)."""
    dx, dy = sides
    every = range(-2 * WHOLE, 2 * WHOLE + 1)
    nodes = np.polynomial.chebyshev.chebpts1(NODES)
    rows = range(1)
    near_rows = range(1)
    node_y = np.zeros(1)
    if ky.size > 1:
        rows = every
        near_rows = range(-1, 2)
        node_y = nodes * np.pi / dy
    step_x = 2 * np.pi / dx
    step_y = 2 * np.pi / dy

    def term(x: np.ndarray, y: np.ndarray, m: int, n: int) -> np.ndarray:
        at_x, at_y = np.meshgrid(x + step_x * m, y + step_y * n)
        weight = np.sinc(at_x * dx / (2 * np.pi)) * np.sinc(at_y * dy / (2 * np.pi))
        return _values(times_k, at_x, at_y) * weight[..., None]

    # far aliases at the nodes, all along x at once
    far: np.ndarray = np.zeros((), complex)
    weights_x = np.array([_euler(abs(m)) for m in every])
    shifted = np.add.outer(step_x * np.array(every), nodes * np.pi / dx)
    for n in rows:
        weights = weights_x * _euler(abs(n))
        if abs(n) <= 1:
            weights[np.abs(every) <= 1] = 0.0
        terms = term(shifted.ravel(), node_y, 0, n)
        terms = terms.reshape(node_y.size, *shifted.shape, -1)
        far = far + np.einsum("m,bmai->bai", weights, terms)
    to_x = _interpolation(nodes, kx * dx / np.pi)
    to_y = np.ones((1, 1))
    if ky.size > 1:
        to_y = _interpolation(nodes, ky * dy / np.pi)
    total = np.einsum("yb,bai,xa->yxi", to_y, far, to_x, optimize=True)
    # nearest aliases at the wave numbers themselves
    for n in near_rows:
        for m in (-1, 0, 1):
            total += term(kx, ky, m, n)
    return np.asarray(total)


def _euler(m: int) -> float:
    """Weight of the m-th term of an alternating sum: 1, then that of a mean of partial sums."""
    from scipy.special import bdtrc

    if m <= WHOLE:
        return 1.0
    return float(bdtrc(m - WHOLE - 1, WHOLE, 0.5))


def _interpolation(nodes: np.ndarray, at: np.ndarray) -> np.ndarray:
    """The matrix from values at Chebyshev nodes to those at some places."""
    degree = nodes.size - 1
    values = np.polynomial.chebyshev.chebvander(at, degree)
    return np.asarray(values @ np.linalg.inv(np.polynomial.chebyshev.chebvander(nodes, degree)))
