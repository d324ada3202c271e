"""Displacements, their gradients and stresses inside a layered body by tractions on its surface.

The state at a depth by a wave of tractions follows from the stack cut there:
the compliance of what is below, and the part of the tractions that what is
above lets through. All fields are rotations of a few functions of the wave
number, which a point load turns into Bessel transforms of order 0 to 3, and a
line load into cosines and sines.
"""

from __future__ import annotations

import math
from functools import cache
from itertools import pairwise

import numpy as np

from varcontact.elasticity.fft_products import fft_box, fields_of, spectrum_of, wrapped
from varcontact.elasticity.layered import (
    DEGREE,
    Stack,
    _kernel_values,
    _products,
    _states,
    _transfer,
    wave_numbers,
)
from varcontact.elasticity.subsurface import ElasticField
from varcontact.errors import SceneError
from varcontact.scene.grid import Grid

SHALLOWEST = 1e-6
"""Least depth, divided by the side of an element: points above it get the field at this depth."""

SMALL_ARGUMENT = 0.5
"""Argument below which Bessel functions of orders 2 and 3 are not found by recurrence."""


def layered_field_at(
    points: np.ndarray, grid: Grid, tractions: np.ndarray, *, stack: Stack
) -> ElasticField:
    """The elastic field at points (3, n) in a layered body, summed over the loaded elements; see
    `field_at`.
    """
    fields = np.empty((13, points.shape[1]))
    loaded = np.flatnonzero(tractions.any(axis=0))
    rows, columns = np.divmod(loaded, grid.nx)
    for depth in np.unique(points[2]):
        at = points[2] == depth
        x = points[0, at, None] - grid.x[columns]
        y = points[1, at, None] - grid.y[rows]
        numbers = _element_fields(stack, depth, grid, x, y)
        fields[:, at] = np.einsum("flpe,le->fp", numbers, tractions.reshape(3, -1)[:, loaded])
    return _field(fields, points[2], stack)


def layered_field_below(
    depths: np.ndarray, grid: Grid, tractions: np.ndarray, *, stack: Stack
) -> ElasticField:
    """The elastic field below all element centres at some depths, by FFT; see `field_below`."""
    ny, nx = grid.shape
    dx, dy = grid.sides
    x = np.arange(1 - nx, nx) * dx
    y = np.arange(1 - ny, ny)[:, None] * dy
    box = fft_box(ny, nx)
    spectrum = spectrum_of(tractions, box)
    fields = np.empty((13, depths.size, ny, nx))
    for i, depth in enumerate(depths):
        for j, table in enumerate(_element_fields(stack, depth, grid, x, y)):
            product = spectrum_of(wrapped(table, box), box) * spectrum
            fields[j, i] = fields_of(product.sum(axis=0), box, (ny, nx))
    return _field(fields, np.broadcast_to(depths[:, None, None], fields.shape[1:]), stack)


def layered_element_stresses(
    x: np.ndarray, y: np.ndarray, depth: float, grid: Grid, stack: Stack
) -> np.ndarray:
    """Stresses (3 tractions, 3, 3, y, x) at one depth by unit tractions on one element of a
    grid.
    """
    fields = _element_fields(stack, depth, grid, x, y[:, None])
    at = np.full((1, 1), depth)
    return np.stack([_field(fields[:, load], at, stack).stress for load in range(3)])


def _field(fields: np.ndarray, depths: np.ndarray, stack: Stack) -> ElasticField:
    """Displacement, gradient and, by Hooke's law, stress, from displacements, gradients and
    sigma_zz (13, ...).
    """
    gradient = fields[3:12].reshape(3, 3, *fields.shape[1:])
    normal = fields[12]
    G = np.vectorize(lambda depth: _cut(stack, depth)[1][0], otypes=[float])(depths)
    shear = G * (gradient + gradient.swapaxes(0, 1))
    rest = np.eye(3).reshape(3, 3, *(1,) * depths.ndim) * (normal - shear[2, 2])
    return ElasticField(fields[:3], gradient, shear + rest)


# ----------------------------------------------------------------------------- waves


def _cut(
    stack: Stack, depth: float
) -> tuple[list[tuple[float, float, float]], tuple[float, float], Stack]:
    """A stack cut at a depth: the layers above, G and nu at the cut, and the stack below."""
    above: list[tuple[float, float, float]] = []
    left = depth
    for i, (h, G, nu) in enumerate(stack.layers):
        last = i == len(stack.layers) - 1 and isinstance(stack.base, str)
        if left < h or (last and left <= h * (1 + 1e-9)):
            left = min(left, h * (1 - 1e-9))
            below = Stack(((h - left, G, nu), *stack.layers[i + 1 :]), stack.base)
            return [*above, (left, G, nu)], (G, nu), below
        above.append((h, G, nu))
        left -= h
    if isinstance(stack.base, str):
        raise SceneError("points", depth, "within the layers, which end on a rigid base")
    return [*above, (left, *stack.base)], stack.base, Stack((), stack.base)


def _transfers(stack: Stack, depth: float, k: np.ndarray) -> np.ndarray:
    """Functions of the wave number at a depth, (17, n), in the order of `_directions`.

    By a unit q and by a unit p: -u_s,s, u_z,s, u_s,z, u_z,z, sigma_zz and k u_s, k u_z; by a unit
    q_t: u_t,s, u_t,z and k u_t.
    """
    above, (G, nu), below = _cut(stack, depth)
    # states at the cut, and the parts of loads that reach it through the layers above
    F11, F12, F22, f = below.compliance(k)
    at_cut = _states(np.array([F11, F12, F22]))
    across = f
    passed = np.ones(k.size)
    state = at_cut
    through = np.repeat(np.eye(2)[:, :, None], k.size, axis=2)
    for h, modulus, ratio in reversed(above):
        upper = np.einsum("abn,bcn->acn", _transfer(k * h, modulus, ratio), state)
        (a, b), (c, d) = -upper[2:]
        inverse = np.array([[d, -b], [-c, a]]) / (a * d - b * c)
        through = np.einsum("abn,bcn->acn", through, inverse) * np.exp(-k * h)
        u = np.einsum("abn,bcn->acn", upper[:2], inverse)
        state = _states(np.array([u[0, 0], u[0, 1], u[1, 1]]))
        t = np.tanh(k * h)
        passed = passed / (np.cosh(np.minimum(k * h, 300)) * (1 + modulus * t * f))
        f = (f + t / modulus) / (1 + modulus * t * f)
    # functions of the states, by Hooke's law
    y = np.einsum("abn,bcn->can", at_cut, through)
    eta = nu / (1 - nu)
    functions = []
    for u, w, tau, sigma in y:
        functions += [u, w, tau / G - w, eta * u + (1 - eta) / 2 * sigma / G, sigma, u / k, w / k]
    return np.array([*functions, across * passed, -passed / G, across * passed / k])


def _directions(angle: float) -> np.ndarray:
    """Displacements, gradients and sigma_zz of those functions, by tractions x, y, z: (17, 13,
    3).
    """
    c = math.cos(angle)
    s = math.sin(angle)
    along = np.array([c, s, 0])
    across = np.array([-s, c, 0])
    down = np.array([0, 0, 1])
    zero = np.zeros(3)

    def of(
        displacement: np.ndarray = zero,
        first: np.ndarray = zero,
        then: np.ndarray = zero,
        normal: int = 0,
    ) -> np.ndarray:
        return np.array([*displacement, *np.outer(first, then).ravel(), normal], dtype=complex)

    in_plane = [
        of(first=-along, then=along),
        of(first=1j * down, then=along),
        of(first=1j * along, then=down),
        of(first=down, then=down),
        of(normal=1),
        of(displacement=1j * along),
        of(displacement=down),
    ]
    anti_plane = [
        of(first=1j * across, then=along),
        of(first=across, then=down),
        of(displacement=across),
    ]
    by_shear = [np.outer(form, -1j * along) for form in in_plane]
    by_pressure = [np.outer(form, down) for form in in_plane]
    by_transverse = [np.outer(form, across) for form in anti_plane]
    return np.array([*by_shear, *by_pressure, *by_transverse])


@cache
def _harmonics(line: bool) -> tuple[np.ndarray, np.ndarray]:
    """Cosine and sine parts (17, orders, 13, 3) of the directions, with the powers of i of their
    transforms.
    """
    orders = 2 if line else 4
    count = 2 if line else 8
    parts = np.fft.fft([_directions(2 * np.pi * i / count) for i in range(count)], axis=0) / count
    cosines, sines = np.zeros((2, orders, *parts.shape[1:]))
    for m in range(orders):
        plus = parts[m]
        if line or m == 0:
            cosines[m] = (1j**m * plus).real
        else:
            minus = parts[-m]
            cosines[m] = (1j**m * (plus + minus)).real
            sines[m] = (1j ** (m + 1) * (plus - minus)).real
    return cosines.swapaxes(0, 1), sines.swapaxes(0, 1)


# ----------------------------------------------------------------------------- elements


def _element_fields(
    stack: Stack, depth: float, grid: Grid, x: np.ndarray, y: np.ndarray
) -> np.ndarray:
    """Fields (13, 3, ...) at a depth and distances from an element by unit tractions on it."""
    x, y = np.broadcast_arrays(x, y)
    dx, dy = grid.sides
    depth = max(float(depth), SHALLOWEST * min(dx, dy))
    scale = depth / 2  # singularities are at +-i depth
    reach = np.abs(x).max() + dx
    if not grid.line:
        reach = np.hypot(reach, np.abs(y).max() + dy)
    # pairs (function, order) that are not zero, as functions of the distance
    cosines, sines = _harmonics(grid.line)
    sizes = np.abs([cosines, sines]).max(axis=(0, 3, 4))
    used = [tuple(pair) for pair in np.argwhere(sizes > 1e-12)]
    doublings = max(math.ceil(math.log2(reach / scale)), 0)
    edges = np.concatenate([[0.0], scale * 2.0 ** np.arange(doublings + 1)])
    coefficients = _transforms(stack, depth, edges, used, grid.line)
    # their integrals over the element
    forms = np.array([[part[pair] for pair in used] for part in (cosines, sines)])
    fields = np.empty((13, 3, x.size))
    for part, starts, from_x, from_y, weights in _products(grid, x.ravel(), y.ravel(), scale):
        r = np.hypot(from_x, from_y)
        turn = (from_x + 1j * from_y) / np.maximum(r, np.finfo(float).tiny)
        turns = np.array([turn**m for m in range(4)])[[m for _, m in used]]
        values = _kernel_values(edges, coefficients, r, [*range(len(used))])
        integrals = np.add.reduceat(values * turns * weights, starts, axis=1)
        fields[..., part] = np.einsum("chfl,chp->flp", forms, [integrals.real, integrals.imag])
    return fields.reshape(13, 3, *x.shape)


def _transforms(
    stack: Stack, depth: float, edges: np.ndarray, used: list[tuple[int, ...]], line: bool
) -> np.ndarray:
    """Chebyshev coefficients of the functions' transforms over each interval of distances."""
    nodes = np.polynomial.chebyshev.chebpts1(DEGREE + 1)
    coefficients = np.empty((len(edges) - 1, DEGREE + 1, len(used)))
    for i, (near, far) in enumerate(pairwise(edges)):
        k, weights = wave_numbers(edges[1], near, far)
        kr = k * ((near + far) / 2 + (far - near) / 2 * nodes)[:, None]
        if line:
            waves = [np.cos(kr), np.sin(kr)]
            factors = weights / np.pi
        else:
            waves = _bessel_functions(kr)
            factors = weights * k / (2 * np.pi)
        functions = _transfers(stack, depth, k) * factors
        values = np.array([waves[order] @ functions[index] for index, order in used])
        coefficients[i] = np.polynomial.chebyshev.chebfit(nodes, values.T, DEGREE)
    return coefficients


def _bessel_functions(x: np.ndarray) -> list[np.ndarray]:
    """Bessel functions J0 to J3 of x; J2 and J3 by recurrence where it does not cancel."""
    from scipy import special

    values = [special.j0(x), special.j1(x)]
    large = np.maximum(x, SMALL_ARGUMENT)
    small = x < SMALL_ARGUMENT
    for order in (2, 3):
        next_one = 2 * (order - 1) / large * values[-1] - values[-2]
        next_one[small] = special.jv(order, x[small])
        values.append(next_one)
    return values
