"""Elastic stresses that pass through each point of a cross-section while a contact rolls over it.

Stresses have five coordinates in which the yield surface of von Mises is a ball of radius k, the
yield stress in shear:

    e = ((syy - szz)/2, (2 sxx - syy - szz)/(2 sqrt 3), sxy, sxz, syz),   |e|^2 = J2 .

Tractions are bilinear between the centres of elements: piecewise constant ones give sxx at the
surface an error of first order, -(2/pi) ln 2 q' h.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from varcontact import checks
from varcontact.elasticity.layered_field import SHALLOWEST
from varcontact.elasticity.subsurface import element_stresses
from varcontact.errors import SceneError
from varcontact.plasticity.half_space import HalfSpace
from varcontact.results.solution import Solution
from varcontact.results.stress import BodyField
from varcontact.scene.grid import Grid
from varcontact.system.process import one_blas_thread

ElasticStress = Callable[[np.ndarray], np.ndarray]
"""Stress (3, 3, ...) at points (3, ...), in the scene's axes."""
Strength = Callable[[np.ndarray], np.ndarray]
"""Yield stress in shear at depths."""

DEPTHS = 44
"""Number of depths of a passage: with 60 the limits change by less than 0.1 %."""
DEPTH_POWER = 1.6
"""Exponent of the depth as a function of its number: depths are closer near the surface."""
DEEPEST = 5.2
"""Depth of the section in half-widths: at 3 the limit of a circle at f = 0.15 is 5 % less."""
BESIDE = 3.2
"""Width of the section beside the contact, in half-widths."""
AHEAD = 3.0
"""Length of the passage before and behind the contact, in half-widths."""
NEAR_SURFACE = 1.2
"""Depth in elements above which tractions are made bilinear by Gauss's rule over the element."""
CLOSE = 0.5
"""Distance from the contact, in half-widths, within which all elements have a sample."""
ALONG_X = ((1, 0, 0), (0, 0, 1, 1, 0))
"""Number of indices x, modulo 2, of the three tractions and of the five stress coordinates."""
ALONG_Y = ((0, 1, 0), (0, 0, 1, 0, 1))
"""Number of indices y, modulo 2, of the three tractions and of the five stress coordinates."""
SYMMETRY_TOLERANCE = 1e-6
"""Largest difference of mirror images, divided by the largest stress coordinate."""
MIRRORED_IN_Y = np.array([1.0, 1.0, -1.0, 1.0, -1.0])
"""Signs of the five coordinates in the mirror image y -> -y."""


LEAST_STRENGTH = 1e-3
"""Least yield stress, divided by the peak pressure."""


@dataclass(frozen=True, eq=False)
class Passage:
    """Curves of elastic stress, divided by the yield stress at their depth, in a cross-section.

    Attributes
    ----------
    x, y, depth : ndarray
        Places of the samples, divided by `unit`.
    curves : ndarray, shape (nz, ny, nx, 5)
        At the load factor 1: the yield surface is the unit ball.
    strength : ndarray, shape (nz,)
        Yield stress, divided by the least.
    loaded : tuple of float
        Ends of the contact along x, and along y.
    unit : float
        Half the width of the contact, the less of both [length].
    symmetric : bool
        True where left and right are mirror images: y >= 0 is enough.
    field : HalfSpace or None
        The field in closed form, where it has one: lengths divided by `unit`, by the least yield
        stress.
    parts : int
        Intervals between samples in an element.
    """

    x: np.ndarray
    y: np.ndarray
    depth: np.ndarray
    curves: np.ndarray
    strength: np.ndarray
    loaded: tuple[float, float, float, float]
    unit: float
    symmetric: bool
    field: HalfSpace | None = None
    parts: int = 1

    @property
    def origin(self) -> int:
        """Number of the sample, beyond those along x, of the load far away."""
        return len(self.x)

    @property
    def elastic_limit(self) -> float:
        """Load factor at first yield."""
        return 1 / float(np.linalg.norm(self.curves, axis=-1).max())

    def half(self) -> Passage:
        """The part y >= 0, with one sample beyond, where the whole is symmetric."""
        first = int(np.searchsorted(self.y, -1e-9))
        right = np.arange(len(self.y)) >= first - 1
        return replace(self, y=self.y[right], curves=self.curves[:, right], symmetric=True)


def coordinates(stress: np.ndarray) -> np.ndarray:
    """The five coordinates (..., 5) of stresses (3, 3, ...)."""
    xx = stress[0, 0]
    yy = stress[1, 1]
    zz = stress[2, 2]
    axial = (2 * xx - yy - zz) / (2 * np.sqrt(3))
    return np.stack([(yy - zz) / 2, axial, stress[0, 1], stress[0, 2], stress[1, 2]], axis=-1)


@one_blas_thread()
def passage(
    solution: Solution,
    side: int,
    strength: Strength,
    *,
    refined: int = 1,
    elastic: ElasticStress | None = None,
    deepest: float = math.inf,
) -> Passage:
    """The passage of a point contact, on its elements divided `refined` times, to the depth
    `deepest` in half-widths.

    Half-spaces and layers have the field of the solution's tractions; others need one, `elastic`.
    """
    whole, elements = loaded_part(solution, side)
    load, grid = divided(whole, elements, refined)
    dx, dy = grid.sides
    rows, columns = np.nonzero(load[2] > 0)
    x = grid.x
    y = grid.y
    ends = np.array([x[columns.min()], x[columns.max()], y[rows.min()], y[rows.max()]])
    unit = float(min(ends[1] - ends[0] + dx, ends[3] - ends[2] + dy)) / 2
    # the section: long contacts need a wider and deeper one
    slender = np.sqrt(max((ends[1] - ends[0]) / 2 / unit, 1.0))
    ahead = _beyond(AHEAD, unit / dx)
    beside = _beyond(BESIDE * slender, unit / dy)
    depth = DEEPEST * slender * unit * np.linspace(0, 1, DEPTHS) ** DEPTH_POWER
    depth = depth[depth <= deepest * unit]
    across = _places(y, dy, beside)
    along = _places(x, dx, ahead)
    kept_x = _samples(along, ends[0] - CLOSE * unit, ends[1] + CLOSE * unit)
    kept_y = _samples(across, ends[2] - CLOSE * unit, ends[3] + CLOSE * unit)
    if elastic is not None:
        curves = _given_curves(elastic, along[kept_x], across[kept_y], depth, side)
    else:
        field = BodyField(solution, side)
        curves = np.empty((len(depth), len(kept_y), len(kept_x), 5))
        for number, at in enumerate(depth):
            layer = _layer(field, load, grid, at, (beside, ahead))
            curves[number] = np.moveaxis(layer[:, kept_y][:, :, kept_x], 0, -1)
    k = strength(depth)
    curves = curves / k[:, None, None, None]
    closed = None
    if elastic is None and not field.layered:
        nu = field.constants["nu"]
        closed = HalfSpace(whole / k.min(), scaled_grid(elements, 1 / unit), nu)
    mirrored = _is_mirrored(across[kept_y], curves)
    return Passage(
        x=along[kept_x] / unit,
        y=across[kept_y] / unit,
        depth=depth / unit,
        curves=curves,
        strength=k / k.min(),
        loaded=tuple((ends + np.array([-dx, dx, -dy, dy]) / 2) / unit),
        unit=unit,
        symmetric=mirrored,
        field=closed,
        parts=refined,
    )


def _beyond(widths: float, elements: float) -> int:
    """Elements beyond the contact, of so many half-widths with so many elements in each; four at
    least, of which every second has a sample.
    """
    return max(math.ceil(widths * elements), math.ceil(CLOSE * elements) + 5)


def scaled_grid(grid: Grid, factor: float) -> Grid:
    """The grid with all lengths times a factor."""
    dx, dy = (factor * side for side in grid.sides)
    x0 = factor * float(grid.x[0]) - dx / 2
    y0 = factor * float(grid.y[0]) - dy / 2
    return Grid(nx=grid.nx, ny=grid.ny, dx=dx, dy=dy, x0=x0, y0=y0)


def loaded_part(solution: Solution, side: int) -> tuple[np.ndarray, Grid]:
    """Tractions (3, ny, nx) on a body, and their elements, with one more all around."""
    load = np.concatenate([into_body(side) * solution.traction, solution.pressure[None]])
    grid = solution.grid
    dx, dy = grid.sides
    rows, columns = np.nonzero(solution.pressure > 0)
    load = load[:, rows.min() : rows.max() + 1, columns.min() : columns.max() + 1]
    x0 = float(grid.x[columns.min()] - 1.5 * dx)
    if grid.line:
        return np.pad(load, ((0, 0), (0, 0), (1, 1))), Grid(nx=load.shape[2] + 2, dx=dx, x0=x0)
    y0 = float(grid.y[rows.min()] - 1.5 * dy)
    padded = np.pad(load, ((0, 0), (1, 1), (1, 1)))
    return padded, Grid(nx=padded.shape[2], ny=padded.shape[1], dx=dx, dy=dy, x0=x0, y0=y0)


def divided(load: np.ndarray, grid: Grid, parts: int | tuple[int, int]) -> tuple[np.ndarray, Grid]:
    """Bilinear tractions and their grid on finer elements: sides divided by `parts`, one number or
    one along x and one along y.
    """
    if parts in (1, (1, 1)):
        return load, grid
    along, across = np.broadcast_to(parts, 2).tolist()
    dx, dy = grid.sides
    load = _interpolated(load, along, axis=2)
    x0 = float(grid.x[0]) - dx / along / 2
    if grid.line:
        return load, Grid(nx=load.shape[2], dx=dx / along, x0=x0)
    load = _interpolated(load, across, axis=1)
    y0 = float(grid.y[0]) - dy / across / 2
    ny, nx = load.shape[1:]
    return load, Grid(nx=nx, ny=ny, dx=dx / along, dy=dy / across, x0=x0, y0=y0)


def _interpolated(values: np.ndarray, parts: int, axis: int) -> np.ndarray:
    """Linear interpolation along an axis, with each interval divided into `parts`."""
    values = np.moveaxis(values, axis, -1)
    count = values.shape[-1]
    place = np.arange((count - 1) * parts + 1) / parts
    left = np.minimum(place.astype(int), count - 2)
    share = place - left
    between = values[..., left] * (1 - share) + values[..., left + 1] * share
    return np.moveaxis(between, -1, axis)


def _places(centres: np.ndarray, step: float, beyond: int) -> np.ndarray:
    """Centres of elements, with `beyond` more at both ends."""
    return centres[0] + step * np.arange(-beyond, len(centres) + beyond)


def _samples(places: np.ndarray, first: float, last: float) -> np.ndarray:
    """Numbers of the places that are kept: all from first to last, every second beyond."""
    number = np.arange(len(places))
    slack = 1e-6 * (places[1] - places[0])
    inside = (places >= first - slack) & (places <= last + slack)
    middle = number[inside]
    left = np.arange(middle[0] - 2, -1, -2)[::-1]
    right = np.arange(middle[-1] + 2, len(places), 2)
    return np.concatenate([left, middle, right])


def into_body(side: int) -> float:
    """Direction of z into a body."""
    return {1: 1.0, 2: -1.0}[side]


def _given_curves(
    elastic: ElasticStress, x: np.ndarray, y: np.ndarray, depth: np.ndarray, side: int
) -> np.ndarray:
    """The five coordinates of a stress field of the user's."""
    into = into_body(side)
    z, across, along = np.meshgrid(into * depth, y, x, indexing="ij")
    points = np.stack([along, across, z])
    stress = checks.numbers("elastic", elastic(points))
    if stress.shape != (3, *points.shape):
        raise checks.wrong_shape("elastic", stress.shape, f"{(3, *points.shape)}, by these points")
    return coordinates(stress) * np.array([1.0, 1.0, 1.0, into, into])


def _layer(
    field: BodyField, load: np.ndarray, grid: Grid, depth: float, beyond: tuple[int, int]
) -> np.ndarray:
    """The five coordinates (5, y, x) at one depth, `beyond` the elements by so many rows and
    columns: by bilinear tractions in closed form, in layered bodies by those of elements.
    """
    if not field.layered:
        return bilinear_layer(HalfSpace(load, grid, field.constants["nu"]), depth, beyond)
    farthest = _farthest(load, beyond)
    if depth >= NEAR_SURFACE * max(grid.sides):
        tables = _element_table(field, grid, depth, *farthest)
        return _summed(tables, _smoothed(load), (beyond[0] - 1, beyond[1] - 1))
    thickness, _, nu = field.constants["stack"].layers[0]
    if depth >= thickness:
        return _summed(_element_table(field, grid, depth, *farthest, nodes=3), load, beyond)
    # a half-space of the upper layer's material, and the smooth change by the other layers
    plain = bilinear_layer(HalfSpace(load, grid, nu), depth, beyond)
    changed = _element_table(field, grid, depth, *farthest, less=nu)
    return plain + _summed(changed, _smoothed(load), (beyond[0] - 1, beyond[1] - 1))


def bilinear_layer(field: HalfSpace, depth: float, beyond: tuple[int, int]) -> np.ndarray:
    """The five coordinates (5, y, x) at one depth of a half-space, in closed form."""
    tables = field.table(depth, *_farthest(field.load, beyond))
    return _summed(tables, field.load, beyond)


def layer_at(
    field: HalfSpace, parts: tuple[int, int], x: np.ndarray, y: np.ndarray, depth: float
) -> np.ndarray:
    """Stresses (y, x, 5) at one depth and places on the lattice of `parts` (x, y) of an element."""
    load, grid = divided(field.load, field.grid, parts)
    columns = np.rint((x - grid.x[0]) / grid.sides[0]).astype(int)
    rows = np.rint((y - grid.y[0]) / grid.sides[1]).astype(int)
    assert np.allclose(grid.y[0] + rows * grid.sides[1], y, atol=1e-6)
    beyond = [
        int(max(0, -number.min(), number.max() - count + 1))
        for number, count in ((rows, grid.ny), (columns, grid.nx))
    ]
    closer = HalfSpace(load, grid, field.nu)
    whole = np.moveaxis(bilinear_layer(closer, depth, (beyond[0], beyond[1])), 0, -1)
    return np.asarray(whole[rows + beyond[0]][:, columns + beyond[1]])


def _farthest(load: np.ndarray, beyond: tuple[int, int]) -> tuple[int, int]:
    """Largest distances along y and x, in elements."""
    return load.shape[1] - 1 + beyond[0], load.shape[2] - 1 + beyond[1]


def _summed(tables: np.ndarray, load: np.ndarray, beyond: tuple[int, int]) -> np.ndarray:
    ny, nx = load.shape[1:]
    rows, columns = beyond
    whole = np.roll(_convolved(tables, load), (rows, columns), axis=(1, 2))
    return whole[:, : ny + 2 * rows, : nx + 2 * columns]


def _convolved(tables: np.ndarray, load: np.ndarray) -> np.ndarray:
    """Sums (5, y, x) in a period of loads (3, ...) times tables (3, 5, ...), even or odd in the
    distances.
    """
    from scipy import fft

    middle, half = (fft.next_fast_len(size, real=True) for size in tables.shape[2:])
    box = (2 * middle, 2 * half)
    odd_x = np.add.outer(ALONG_X[0], ALONG_X[1]) % 2
    odd_y = np.add.outer(ALONG_Y[0], ALONG_Y[1]) % 2
    acting = np.asarray(load.any(axis=(1, 2)))
    # spectra of tables, by their symmetries: those of odd ones are times i
    spectra = np.empty((3, 5, middle + 1, half + 1))
    for along_y in range(2):
        for along_x in range(2):
            chosen = (odd_y == along_y) & (odd_x == along_x) & acting[:, None]
            table = _half_spectra(tables[chosen], middle, along_y, axis=1)
            spectra[chosen] = _half_spectra(table, half, along_x, axis=2)
    # products with those of the loads
    spectrum = fft.rfft2(load, box)
    total = np.zeros((5, *spectrum.shape[1:]), dtype=complex)
    for each in np.flatnonzero(acting):
        for own in range(5):
            table = (-1j) ** (odd_y[each, own] + odd_x[each, own]) * spectra[each, own]
            total[own, : middle + 1] += spectrum[each, : middle + 1] * table
            above = (-1.0) ** odd_y[each, own] * table[middle - 1 : 0 : -1]
            total[own, middle + 1 :] += spectrum[each, middle + 1 :] * above
    return np.asarray(fft.irfft2(total, box))


def _half_spectra(tables: np.ndarray, half: int, odd: int, axis: int) -> np.ndarray:
    """Spectra (half + 1 along the axis) of even tables, or i times those of odd ones, of which
    distances from zero on are given.
    """
    from scipy import fft

    shape = list(tables.shape)
    count = shape[axis]
    shape[axis] = half + 1
    wide = np.zeros(shape)
    kept = np.moveaxis(wide, axis, 0)
    kept[:count] = np.moveaxis(tables, axis, 0)
    if not odd:
        return np.asarray(fft.dct(wide, 1, axis=axis, overwrite_x=True))
    # sines: the first and the last are zero
    inner = np.moveaxis(kept[1:half], 0, axis)
    found = fft.dst(inner, 1, axis=axis)
    kept[0] = kept[half] = 0.0
    kept[1:half] = np.moveaxis(found, axis, 0)
    return wide


def _element_table(
    field: BodyField,
    grid: Grid,
    depth: float,
    most_y: int,
    most_x: int,
    *,
    nodes: int = 1,
    less: float | None = None,
) -> np.ndarray:
    """Coordinates (3 tractions, 5, y, x) by one element, at distances from zero on: their mean over
    an element by so many nodes of Gauss's rule along each axis, which makes tractions bilinear;
    less those in a half-space of this Poisson's ratio.
    """
    dx, dy = grid.sides
    depth = max(depth, SHALLOWEST * min(dx, dy))
    x = np.arange(most_x + 1) * dx
    y = np.arange(most_y + 1) * dy
    places, weights = np.polynomial.legendre.leggauss(nodes)
    table = np.zeros((3, 5, most_y + 1, most_x + 1))
    for along, weight_x in zip(places, weights / 2, strict=True):
        for across, weight_y in zip(places, weights / 2, strict=True):
            at = (x + along * dx / 2, y + across * dy / 2, depth)
            stress = field.of_element(*at, grid)
            if less is not None:
                stress = stress - element_stresses(*at, grid.sides, less)
            each = np.moveaxis(coordinates(np.moveaxis(stress, 0, 2)), -1, 1)
            table += weight_x * weight_y * each
    return table


def _smoothed(load: np.ndarray) -> np.ndarray:
    """Tractions, with one more element all around, whose constant values act at a depth as bilinear
    ones: their mean over an element, to the sixth order.
    """
    smooth = np.pad(load, ((0, 0), (1, 1), (1, 1)))
    for axis in (1, 2):
        values = np.moveaxis(smooth, axis, 0)
        wide = np.pad(values, ((2, 2), (0, 0), (0, 0)))
        second = np.diff(wide, 2, axis=0)
        fourth = np.diff(second, 2, axis=0)
        smooth = np.moveaxis(values + second[1:-1] / 24 - 17 / 5760 * fourth, 0, axis)
    return smooth


def _is_mirrored(y: np.ndarray, curves: np.ndarray) -> bool:
    """True where the curves at y and -y are mirror images."""
    if not np.allclose(y, -y[::-1], atol=1e-6 * np.abs(y).max()):
        return False
    difference = curves[:, ::-1] * MIRRORED_IN_Y - curves
    return bool(np.abs(difference).max() < SYMMETRY_TOLERANCE * np.abs(curves).max())


def yield_strength(k: Any, peak: float) -> Strength:
    """The yield stress in shear by depth, from a number, a function, or depths and values."""
    if callable(k):
        at: Strength = lambda depth: checks.positives("k", k(depth)) + 0 * depth  # noqa: E731
    elif checks.is_array(k):
        depths, values = (checks.array("k", each, 1) for each in _pair(k))
        checks.positives("k", values)
        if depths.shape != values.shape or np.any(np.diff(depths) <= 0):
            raise SceneError("k", k, "a number, or ascending depths and as many values")
        at = lambda depth: np.interp(depth, depths, values)  # noqa: E731
    else:
        number = checks.positive("k", k)
        at = lambda depth: np.full(np.shape(depth), number)  # noqa: E731
    least = float(np.min(at(np.zeros(1))))
    if least < LEAST_STRENGTH * peak:
        raise SceneError(
            "k",
            least,
            f"at least {LEAST_STRENGTH:g} of the peak pressure, {peak:.4g}: is it in the unit of "
            "the scene's pressures?",
        )
    return at


def _pair(k: Any) -> Any:
    if len(k) != 2:
        raise SceneError("k", k, "a number, or a pair: depths and values")
    return k
