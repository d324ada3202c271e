"""Influence numbers of bodies and surfaces that repeat: a grid is one period along x and y.

Tractions that are constant on elements have, at the centres of elements, the
transform

    S(k) = sum over aliases f(k + K) sinc(x) sinc(y),

K whole multiples of the grid's own wave numbers, x and y half the wave numbers
times the sides. Signs alternate: Euler's means end each sum. Aliases beyond the
nearest are analytic on the first zone, and interpolated from Chebyshev nodes.
With tractions that are trigonometric polynomials S is f itself.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from varcontact.elasticity.halfspace import HalfSpaces
from varcontact.elasticity.layered import LayeredPair
from varcontact.elasticity.of_scenes import medium_of
from varcontact.elasticity.symbol_medium import SymbolMedium
from varcontact.errors import SceneError
from varcontact.scene.bodies import as_bodies
from varcontact.scene.grid import Grid

WHOLE = 12
"""Terms of a sum of aliases before Euler's means, of which there are as many: error 5e-13."""
NODES = 18
"""Chebyshev nodes along each axis of the first zone."""

TimesK = Callable[[np.ndarray, np.ndarray], np.ndarray]
"""k f (n, 3, 3) at wave numbers and directions (n,)."""


def periodic_kernel(bodies: Any, grid: Grid, spectral: bool, mean: float | None) -> np.ndarray:
    """Influence numbers (3, 3, 2 ny - 1, 2 nx - 1) of one period.

    The mean displacement by a mean traction is infinite without a base below both bodies; a finite
    one moves displacements as a whole, and makes the numbers positive definite: `mean`, or that of
    the longest wave.
    """
    times_k = _symbol_of(as_bodies(bodies))
    ny, nx = grid.shape
    dx, dy = grid.sides
    kx = 2 * np.pi * np.fft.fftfreq(nx, dx)
    ky = 2 * np.pi * np.fft.fftfreq(ny, dy)
    if spectral:
        total = _values(times_k, *np.meshgrid(kx, ky))
    else:
        total = _aliases(times_k, kx, ky, (dx, dy))
    # the mean displacement by the mean traction
    if mean is None:
        longest = nx * dx
        mean = float(times_k(np.ones(1) * 2 * np.pi / longest, np.zeros(1))[0, 2, 2].real)
        mean *= longest / (2 * np.pi)
    total[0, 0] = mean * np.eye(3)
    circulant = np.fft.ifft2(np.moveaxis(total, (-2, -1), (0, 1))).real
    rows = np.arange(1 - ny, ny) % ny
    columns = np.arange(1 - nx, nx) % nx
    return np.asarray(circulant[:, :, rows[:, None], columns])


def _symbol_of(bodies: Any) -> TimesK:
    """k f of a scene's bodies."""
    medium = medium_of(bodies, 1.0, 1.0)
    if isinstance(medium, SymbolMedium):
        symbol = medium.symbol.scaled(1 / bodies.combined_G, 1.0)
        if any(symbol.local) or symbol.degree != 0:
            raise SceneError("bodies.local", symbol.local, "without springs or powers of k")
        return symbol.times_k
    if isinstance(medium, HalfSpaces):
        nu = medium.nu
        constants = np.array([2 * (1 - nu), 2 * medium.K, 2 * (1 - nu), 2.0]) / bodies.combined_G
        return lambda k, theta: _isotropic(constants[:, None] + 0 * k, theta)
    if isinstance(medium, LayeredPair):
        pair = medium
        return lambda k, theta: _isotropic(pair.symbols(k) / bodies.combined_G, theta)
    allowed = "half-spaces, elastic layers, or an Elasticity by its symbol"
    raise SceneError("bodies", bodies, allowed)


def _isotropic(symbols: np.ndarray, theta: np.ndarray) -> np.ndarray:
    """k f from alpha, kappa, gamma and beta (4, n), see `LayeredPair`."""
    alpha, kappa, gamma, beta = symbols
    c = np.cos(theta)
    s = np.sin(theta)
    f = np.zeros((theta.size, 3, 3), complex)
    f[:, 0, 0] = alpha * c**2 + beta * s**2
    f[:, 1, 1] = alpha * s**2 + beta * c**2
    f[:, 0, 1] = f[:, 1, 0] = (alpha - beta) * c * s
    f[:, 2, 2] = gamma
    f[:, 0, 2] = 1j * kappa * c
    f[:, 1, 2] = 1j * kappa * s
    f[:, 2, 0] = -f[:, 0, 2]
    f[:, 2, 1] = -f[:, 1, 2]
    return f


def _values(times_k: TimesK, kx: np.ndarray, ky: np.ndarray) -> np.ndarray:
    """f (ny, nx, 3, 3) at wave numbers; zero at 0."""
    k = np.hypot(kx, ky).ravel()
    at = k > 0
    values = np.zeros((k.size, 3, 3), complex)
    theta = np.arctan2(ky, kx).ravel()
    values[at] = times_k(k[at], theta[at]) / k[at][:, None, None]
    return values.reshape(*kx.shape, 3, 3)


def _aliases(
    times_k: TimesK, kx: np.ndarray, ky: np.ndarray, sides: tuple[float, float]
) -> np.ndarray:
    """The sum over all aliases (ny, nx, 3, 3)."""
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
        return _values(times_k, at_x, at_y) * weight[..., None, None]

    # far aliases on the nodes
    far = np.zeros((node_y.size, NODES, 3, 3), complex)
    for n in rows:
        for m in every:
            if max(abs(m), abs(n)) > 1:
                weight = _euler(abs(m)) * _euler(abs(n))
                far += weight * term(nodes * np.pi / dx, node_y, m, n)
    to_x = _interpolation(nodes, kx * dx / np.pi)
    to_y = np.ones((1, 1))
    if ky.size > 1:
        to_y = _interpolation(nodes, ky * dy / np.pi)
    total = np.einsum("yb,baij,xa->yxij", to_y, far, to_x, optimize=True)
    # the nearest ones where they are
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
