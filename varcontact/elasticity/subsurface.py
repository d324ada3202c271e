"""Displacements, their gradients and stresses inside a half-space z >= 0 by
tractions on its surface.

The body takes up z >= 0, and the tractions act on it: pz > 0 presses.
Everything is a combination of the derivatives of three potentials
(`varcontact.elasticity.potentials`), summed over the elements with the
tractions as weights: directly for points anywhere, by FFT for grids of points
below the element centres. With the combinations of Boussinesq and Cerruti for a
unit point force along x,

    4 pi G u = (2 phi - z chi_xx + 2 nu omega_xx,  -z chi_xy + 2 nu omega_xy,  -z phi_x + (1 - 2 nu)
    chi_x),

and along z

    4 pi G u = (-z phi_x - (1 - 2 nu) chi_x,  -z phi_y - (1 - 2 nu) chi_y,  2 (1 - nu) phi - z
    phi_z).

Stresses are combined by themselves, without G: they do not suffer where a body
is nearly rigid or incompressible, and they satisfy the surface's conditions
exactly.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from varcontact.elasticity.fft_products import fft_box, fields_of, spectrum_of, wrapped
from varcontact.elasticity.potentials import KINDS, exchanged, lattice_potentials, strip_potentials
from varcontact.scene.grid import Grid
from varcontact.system.process import one_blas_thread

Y_FIRST = [1, 0, 2]
_PAIRS_AT_ONCE = 8192  # of points and elements: the intermediate arrays stay in the cache


@dataclass(frozen=True, eq=False)
class ElasticField:
    """Displacement, its gradient and stress at points.

    Attributes
    ----------
    displacement : ndarray, shape (3, ...)
        [length]
    gradient : ndarray, shape (3, 3, ...)
        du_i/dx_j at [i, j] [-].
    stress : ndarray, shape (3, 3, ...)
        [force/area]
    """

    displacement: np.ndarray
    gradient: np.ndarray
    stress: np.ndarray


@one_blas_thread()
def field_at(
    points: np.ndarray,
    grid: Grid,
    tractions: np.ndarray,
    *,
    G: float,
    nu: float,
    reference: float = 1.0,
) -> ElasticField:
    """The elastic field at points anywhere in the half-space, summed over the loaded elements.

    Parameters
    ----------
    points : ndarray, shape (3, n)
        x, y, and depth ``z >= 0`` [length]; in line contact y does not matter.
    grid : Grid
        Explicit lattice; one of line contact stands for strips.
    tractions : ndarray, shape (3, ny, nx)
        On the half-space, x, y, z [force/area].
    G, nu : float
        Modulus of rigidity (``inf``: no displacements) and Poisson's ratio of
        the body.
    reference : float
        In line contact the length in the logarithms of the displacements.

    Returns
    -------
    ElasticField

    Examples
    --------
    Below the centre of a square under a unit pressure:

    >>> grid = Grid(nx=1, ny=1, dx=1.0, dy=1.0, x0=-0.5, y0=-0.5)
    >>> load = np.array([0.0, 0.0, 1.0]).reshape(3, 1, 1)
    >>> field = field_at(np.array([[0.0], [0.0], [0.0]]), grid, load, G=1.0, nu=0.28)
    >>> print(np.diag(field.stress[..., 0]).round(6))
    [-0.78 -0.78 -1.  ]
    """
    potentials = _potentials(grid, reference)
    sums = np.zeros((len(KINDS), 3, points.shape[1]))
    loaded = np.argwhere(np.any(tractions != 0, axis=0))
    if loaded.size:
        bottom, left = loaded.min(axis=0)
        top, right = loaded.max(axis=0) + 1
        x = grid.x[left:right, None, None]
        y = grid.y[None, bottom:top, None]
        weights = np.swapaxes(tractions[:, bottom:top, left:right], 1, 2).reshape(3, -1)
        at_once = max(1, _PAIRS_AT_ONCE // (x.size * y.size))
        for start in range(0, points.shape[1], at_once):
            part = slice(start, start + at_once)
            px, py, pz = points[:, part]
            values = potentials(px - x, py - y, pz)
            sums[:, :, part] += weights @ values.reshape(len(KINDS), -1, pz.size)
    return _combined(sums, points[2], G, nu)


def field_below(
    depths: np.ndarray,
    grid: Grid,
    tractions: np.ndarray,
    *,
    G: float,
    nu: float,
    reference: float = 1.0,
) -> ElasticField:
    """The elastic field below all element centres at some depths, by FFT.

    Parameters
    ----------
    depths : ndarray, shape (n,), n >= 1
        ``z >= 0`` [length].
    grid, tractions, G, nu, reference
        As in `field_at`.

    Returns
    -------
    ElasticField
        Its arrays have the trailing shape (n, ny, nx).
    """
    ny, nx = grid.shape
    dx, dy = grid.sides
    x = np.arange(nx - 1, -nx, -1) * dx
    y = np.arange(ny - 1, -ny, -1) * dy
    box = fft_box(ny, nx)
    spectrum = spectrum_of(tractions, box)
    potentials = _potentials(grid, reference)
    fields = []
    for depth in depths:
        sums = np.empty((len(KINDS), 3, ny, nx))
        values = potentials(x[:, None, None], y[None, :, None], np.array([depth]))[:, ::-1, ::-1, 0]
        for kind, table in enumerate(values):
            product = spectrum_of(wrapped(table.T, box), box) * spectrum
            sums[kind] = fields_of(product, box, (ny, nx))
        fields.append(_combined(sums, depth, G, nu))
    return ElasticField(
        np.stack([field.displacement for field in fields], axis=1),
        np.stack([field.gradient for field in fields], axis=2),
        np.stack([field.stress for field in fields], axis=2),
    )


def _potentials(grid: Grid, reference: float) -> Callable[[Any, Any, Any], np.ndarray]:
    """Function of the distances (nx, 1, n), (1, ny, n) and depths (n,), see
    `lattice_potentials`.
    """
    dx, dy = grid.sides
    if grid.line:
        return lambda x, y, z: strip_potentials(x, z, dx, reference)
    return partial(lattice_potentials, dx=dx, dy=dy)


_Sum = Callable[[str], Any]


def _combined(sums: np.ndarray, z: np.ndarray | float, G: float, nu: float) -> ElasticField:
    """The field from the sums of the potentials' derivatives by each of the three tractions."""
    along_x = _tangential(_by_kind(sums[:, 0]), z, nu)
    along_y = _tangential(_by_kind(sums[:, 1], exchange=True), z, nu)
    turned = (along_y[0][Y_FIRST], along_y[1][Y_FIRST][:, Y_FIRST], _turned(along_y[2]))
    down = _normal(_by_kind(sums[:, 2]), z, nu)
    u, gradient, stress = (x + y + z for x, y, z in zip(along_x, turned, down, strict=True))
    return ElasticField(u / (4 * np.pi * G), gradient / (4 * np.pi * G), stress / (2 * np.pi))


def _turned(tensor: np.ndarray) -> np.ndarray:
    """A tensor (3, 3, ...) with x and y exchanged."""
    return tensor[Y_FIRST][:, Y_FIRST]


def _by_kind(values: np.ndarray, exchange: bool = False) -> _Sum:
    """Function of the names of derivatives, by those of `KINDS`; with x and y exchanged."""
    named = dict(zip(KINDS, values, strict=True))
    named["phi"] = -(named["omega_xx"] + named["omega_yy"])  # all three are harmonic
    named["phi_z"] = -(named["chi_xx"] + named["chi_yy"])
    named["phi_zz"] = -(named["phi_xx"] + named["phi_yy"])
    named["chi_xxx"] = -(named["phi_xz"] + named["chi_xyy"])
    named["chi_yyy"] = -(named["phi_yz"] + named["chi_xxy"])
    if exchange:
        return lambda kind: named[exchanged(kind)]
    return lambda kind: named[kind]


def element_stresses(
    x: np.ndarray, y: np.ndarray, depth: float, sides: tuple[float, float] | None, nu: float
) -> np.ndarray:
    """Stresses (3 tractions, 3, 3, y, x) at one depth by unit tractions on one element.

    Distances x and y from the element's centre ascend by its `sides`; without sides those in line
    contact, whose element is as wide as the step of x.
    """
    at = np.array([depth])
    if sides is None:
        values = strip_potentials(x, depth, float(x[1] - x[0]))[:, None]
    else:
        rows = y[None, ::-1, None]
        columns = x[::-1, None, None]
        values = lattice_potentials(columns, rows, at, *sides)[:, ::-1, ::-1, 0].swapaxes(1, 2)
    along_x = _tangential(_by_kind(values), depth, nu)[2]
    along_y = _turned(_tangential(_by_kind(values, exchange=True), depth, nu)[2])
    down = _normal(_by_kind(values), depth, nu)[2]
    return np.stack([along_x, along_y, down]) / (2 * np.pi)


# Each returns 4 pi G u (3, ...), 4 pi G du_i/dx_j (3, 3, ...) and 2 pi sigma (3, 3, ...).


def _tangential(
    Q: _Sum, z: np.ndarray | float, nu: float
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Fields by tractions along x; along y with x and y exchanged."""
    part = 1 - 2 * nu
    u = [
        2 * (1 - nu) * Q("phi") - 2 * nu * Q("omega_yy") - z * Q("chi_xx"),
        2 * nu * Q("omega_xy") - z * Q("chi_xy"),
        part * Q("chi_x") - z * Q("phi_x"),
    ]
    mixed = 2 * nu * Q("omega_xxy") - Q("chi_xxy")
    across = 2 * nu * Q("omega_xyy") - Q("chi_xyy")
    gradient = [
        [
            2 * (1 - nu) * Q("phi_x") - 2 * nu * Q("omega_xyy") - Q("chi_xxx"),
            2 * Q("phi_y") + mixed,
            2 * Q("phi_z") - part * Q("chi_xx") - Q("phi_xx"),
        ],
        [mixed, across, -part * Q("chi_xy") - Q("phi_xy")],
        [
            part * Q("chi_xx") - Q("phi_xx"),
            part * Q("chi_xy") - Q("phi_xy"),
            -2 * nu * Q("phi_x") - Q("phi_xz"),
        ],
    ]
    xx = 2 * Q("phi_x") - Q("chi_xxx") - 2 * nu * Q("omega_xyy")
    xy = Q("phi_y") + mixed
    xz = Q("phi_z") - Q("phi_xx")
    yy = across + 2 * nu * Q("phi_x")
    yz = -Q("phi_xy")
    zz = -Q("phi_xz")
    stress = [[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]
    return np.array(u), np.array(gradient), np.array(stress)


def _normal(Q: _Sum, z: np.ndarray | float, nu: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    part = 1 - 2 * nu
    u = [
        -z * Q("phi_x") - part * Q("chi_x"),
        -z * Q("phi_y") - part * Q("chi_y"),
        2 * (1 - nu) * Q("phi") - z * Q("phi_z"),
    ]
    xx, xy, yy = (-Q(f"phi_{ij}") - part * Q(f"chi_{ij}") for ij in ("xx", "xy", "yy"))
    turn_x = 2 * (1 - nu) * Q("phi_x")
    turn_y = 2 * (1 - nu) * Q("phi_y")
    xz = -Q("phi_xz")
    yz = -Q("phi_yz")
    gradient = [
        [xx, xy, xz - turn_x],
        [xy, yy, yz - turn_y],
        [xz + turn_x, yz + turn_y, part * Q("phi_z") - Q("phi_zz")],
    ]
    sides = 2 * nu * Q("phi_z")
    stress = [[xx + sides, xy, xz], [xy, yy + sides, yz], [xz, yz, Q("phi_z") - Q("phi_zz")]]
    return np.array(u), np.array(gradient), np.array(stress)
