"""Shakedown of line contacts: residual stress depends on the depth alone, so that each depth has
its own limit, the smallest ball about its curve; the least of all is the limit from both sides.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from varcontact.plasticity.balls import ANY, FINE_STEPS, IN_PLANE, Balls, smallest_balls
from varcontact.plasticity.half_plane import HalfPlane
from varcontact.plasticity.passage import (
    NEAR_SURFACE,
    ElasticStress,
    Strength,
    coordinates,
    divided,
    into_body,
    loaded_part,
)
from varcontact.plasticity.proof import TOLERANCE, Proof
from varcontact.plasticity.remainder import excess
from varcontact.results.solution import Solution
from varcontact.results.stress import BodyField
from varcontact.scene.grid import Grid
from varcontact.system.process import one_blas_thread

ELEMENTS = 200
"""Least number of strips across the contact: coarser grids are divided."""
AHEAD = 6.0
"""Length of the passage before and behind the contact, in half-widths."""
CLOSED_AHEAD = 4.0
"""Length of the passage before and behind the contact on half-spaces, in half-widths; the stress
farther away is bounded."""
DEPTHS = np.concatenate([[0.0], np.geomspace(2e-3, 3.0, 80)])
"""Depths of the first search, in half-widths."""
FINE_DEPTHS = 21
"""Depths in the second search, between those beside the least limit."""

Curves = Callable[[np.ndarray], np.ndarray]
"""Coordinates (nz, nx, 5) of stress at depths (nz,)."""


@dataclass(frozen=True, eq=False)
class LineLimit:
    """The limit by depth.

    Attributes
    ----------
    lower, sampled, upper : float
        Bounds on the load factor: with what may lie between samples, at samples, by duality.
    depth : float
        Of the limit [length].
    net : ndarray, shape (2,)
        Net flow of a passage along x and y at this depth, by all plastic strain.
    critical, centre : ndarray, shapes (nx, 5) and (5,)
        Curve at this depth by the yield stress, and the centre of its ball.
    elastic : float
        Load factor at first yield.
    depths : ndarray, shape (n,)
        All depths [length].
    centres : ndarray, shape (n, 5)
        Negative residual stresses at the load factor 1, by the yield stress.
    proved : bool
        True where the lower bound is proved between samples, too.
    """

    lower: float
    sampled: float
    upper: float
    depth: float
    net: np.ndarray
    critical: np.ndarray
    centre: np.ndarray
    elastic: float
    depths: np.ndarray
    centres: np.ndarray
    proved: bool = False


@dataclass(frozen=True, eq=False)
class LinePassage:
    """Curves of a line contact at any depths, each computed once.

    Attributes
    ----------
    x : ndarray, shape (nx,)
        Samples [length].
    unit : float
        Half the width of the contact [length].
    compute : callable
        Coordinates (nz, nx, 5) of stress at depths (nz,).
    known : dict
        Those (nx, 5) by depth.
    field : HalfPlane or None
        Field of a half-space, whose stresses between samples can be bounded.
    """

    x: np.ndarray
    unit: float
    compute: Curves
    known: dict[float, np.ndarray]
    field: HalfPlane | None = None

    def at(self, depths: np.ndarray) -> np.ndarray:
        """Coordinates (nz, nx, 5) at depths."""
        new = np.array([depth for depth in depths if depth not in self.known])
        if new.size:
            self.known.update(zip(new, self.compute(new), strict=True))
        return np.stack([self.known[depth] for depth in depths])


@one_blas_thread()
def line_passage(
    solution: Solution, side: int, elastic: ElasticStress | None = None
) -> LinePassage:
    """Passage of a line contact, with strips divided if they are few."""
    load, grid = loaded_part(solution, side)
    unit = (grid.nx - 2) * grid.sides[0] / 2
    if elastic is not None:
        middle = (grid.x[0] + grid.x[-1]) / 2
        x = middle + unit * _graded_places()
        return LinePassage(x, unit, _given_curves(elastic, x, side), {})
    load, grid = divided(load, grid, max(1, -(-ELEMENTS // grid.nx)))
    body = BodyField(solution, side)
    if not body.layered:
        beyond = int(np.ceil(CLOSED_AHEAD * unit / grid.sides[0]))
        field = HalfPlane.of(load[:, 0], grid, body.constants["nu"], beyond)
        return LinePassage(field.x, unit, _closed_curves(field), {}, field)
    beyond = int(np.ceil(AHEAD * unit / grid.sides[0]))
    curves = _strip_curves(body, load, grid, beyond)
    x = grid.x[0] + grid.sides[0] * np.arange(-beyond, grid.nx + beyond)
    return LinePassage(x, unit, curves, {})


def _closed_curves(field: HalfPlane) -> Curves:
    """Curves of a half-space."""

    def curves(depths: np.ndarray) -> np.ndarray:
        return np.stack([field.curve(float(depth)) for depth in depths])

    return curves


@one_blas_thread()
def with_proof(line: LinePassage, strength: Strength, limit: LineLimit) -> LineLimit:
    """Limit with a lower bound that is also proved between samples, where that is possible."""
    if line.field is None:
        return limit
    proof = Proof(line.field, strength, limit.depths, limit.centres, line.unit)
    return replace(limit, lower=1 / proof.radius((1 + TOLERANCE) / limit.upper), proved=True)


@one_blas_thread()
def line_limit(line: LinePassage, strength: Strength, hardening: str) -> LineLimit:
    """The shakedown limit of a line contact."""
    free: tuple[int, ...] = IN_PLANE
    if hardening == "kinematic":
        free = ANY
    # all depths, then closer ones beside the least limit
    depths = DEPTHS * line.unit
    first = smallest_balls(_by_yield(line, depths, strength), free, FINE_STEPS)
    least = int(first.least.argmax())
    beside = depths[max(least - 1, 0)], depths[min(least + 1, len(depths) - 1)]
    depths = np.union1d(depths, np.linspace(*beside, FINE_DEPTHS))
    values = _by_yield(line, depths, strength)
    balls = smallest_balls(values, free, FINE_STEPS)
    return _limit(balls, values, line.x, depths)


def _limit(balls: Balls, curves: np.ndarray, x: np.ndarray, depths: np.ndarray) -> LineLimit:
    number = int(balls.least.argmax())
    moved = curves - balls.centres[:, None]
    size = np.linalg.norm(moved, axis=-1)
    between = size + excess(moved, moved, x, 1) + excess(moved, curves, depths, 0)
    far = float(np.linalg.norm(balls.centres, axis=-1).max())
    strain = balls.weights[number][:, None] * moved[number]
    origin = (1 - balls.weights[number].sum()) * np.linalg.norm(balls.centres[number])
    total = np.linalg.norm(strain, axis=1).sum() + origin
    return LineLimit(
        lower=1 / max(float(between.max()), far),
        sampled=1 / max(float(size.max()), far),
        upper=1 / float(balls.least[number]),
        depth=float(depths[number]),
        net=strain.sum(axis=0)[3:] / total,
        critical=curves[number],
        centre=balls.centres[number],
        elastic=1 / float(np.linalg.norm(curves, axis=-1).max()),
        depths=depths,
        centres=balls.centres,
    )


def _by_yield(line: LinePassage, depths: np.ndarray, strength: Strength) -> np.ndarray:
    return line.at(depths) / strength(depths)[:, None, None]


def _strip_curves(field: BodyField, load: np.ndarray, grid: Grid, beyond: int) -> Curves:
    """Curves by tractions that are linear between the centres of strips."""
    from scipy import fft

    count = grid.nx
    most = count - 1 + beyond
    dx = grid.sides[0]
    distances = np.arange(-most, most + 1) * dx
    length = fft.next_fast_len(2 * most + count, real=True)
    spectrum = fft.rfft(load[:, 0], length)
    smooth = np.pad(load[:, 0], ((0, 0), (1, 1)))
    smooth = load[:, 0] + np.diff(smooth, 2, axis=1) / 24
    smooth_spectrum = fft.rfft(smooth, length)

    def curves(depths: np.ndarray) -> np.ndarray:
        values = np.empty((len(depths), count + 2 * beyond, 5))
        for number, depth in enumerate(depths):
            near = depth < NEAR_SURFACE * dx
            table = _strip_table(field, distances, depth, grid, near)
            tractions = smooth_spectrum
            if near:
                tractions = spectrum
            product = fft.rfft(table, length) * tractions[:, None]
            whole = fft.irfft(product.sum(axis=0), length)
            values[number] = whole[:, count - 1 : 2 * count - 1 + 2 * beyond].T
        return values

    return curves


def _strip_table(
    field: BodyField, distances: np.ndarray, depth: float, grid: Grid, near: bool
) -> np.ndarray:
    """Coordinates (3 tractions, 5, x) by one strip; near the surface their mean over its width."""
    nodes = np.zeros(1)
    weights = np.ones(1)
    if near:
        nodes, weights = np.polynomial.legendre.leggauss(3)
        weights = weights / 2
    total = np.zeros((3, 5, len(distances)))
    for node, weight in zip(nodes, weights, strict=True):
        places = distances + node * grid.sides[0] / 2
        stress = field.of_element(places, np.zeros(1), depth, grid)
        each = stress.reshape(3, 3, 3, -1)
        total += weight * np.moveaxis(coordinates(np.moveaxis(each, 0, 2)), -1, 1)
    return total


def _graded_places() -> np.ndarray:
    """Places along x in half-widths: close at the contact's edges, where stresses have roots."""
    inside = -np.cos(np.linspace(0, np.pi, 801))
    outside = 1 + np.geomspace(1e-6, 30.0, 300)
    return np.concatenate([-outside[::-1], inside, outside])


def _given_curves(elastic: ElasticStress, x: np.ndarray, side: int) -> Curves:
    """Curves of a stress field of the user's."""
    into = into_body(side)
    signs = np.array([1.0, 1.0, 1.0, into, into])

    def curves(depths: np.ndarray) -> np.ndarray:
        z, along = np.meshgrid(into * depths, x, indexing="ij")
        return coordinates(np.asarray(elastic(np.stack([along, 0 * along, z])))) * signs

    return curves
