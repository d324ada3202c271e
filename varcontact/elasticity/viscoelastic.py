"""Influence numbers of viscoelastic bodies in steady rolling and in time: standard linear solids.

The creep compliance is ``J(t) = J0 (1 + sum f (1 - exp(-t/tau)))`` with
constant Poisson's ratio. A particle now at x was at x + s when the bodies had
rolled a distance s less, so that with ``l = V tau`` displacements are elastic
ones and means of these over what lies ahead:
``u(x) = u_e(x) + sum f integral_0^inf u_e(x + s) exp(-s/l) ds/l``.

In a history particles remember tractions P, ``tau dP/dt = p - P``, and
``u = u_e(p) + sum f u_e(P)``.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass

import numpy as np

from varcontact.elasticity.operators import Homogeneous
from varcontact.scene.grid import Grid

FAR = 40.0
"""Relaxation lengths after which past tractions are neglected."""
NEAR = 5.0
"""Distance in element sides up to which Gauss points are dense near an element's edges."""
BATCH = 100_000
"""Points at which influence numbers are evaluated at a time."""

Numbers = Callable[[np.ndarray, np.ndarray], np.ndarray]
"""Influence numbers (components, ...) at x and y, which broadcast together."""


@dataclass(frozen=True)
class Lagging:
    """Part of the displacements that follows with one relaxation length: a factor of those of an
    elastic medium.

    In a history the length stands for the relaxation time; 0 follows at once.
    """

    length: float
    factor: float
    medium: Homogeneous


@dataclass(frozen=True)
class ViscoelasticMedium(Homogeneous):
    """Two bodies that roll steadily: their instantaneous (glassy) response, and delayed
    displacements.

    Attributes
    ----------
    glassy : Medium
    lagging : tuple of Lagging
        One for each relaxation length.
    """

    glassy: Homogeneous
    lagging: tuple[Lagging, ...]

    @property
    def K(self) -> float:
        """Size of the coupling, at least its value at any frequency."""
        return abs(self.glassy.K) + sum(each.factor * abs(each.medium.K) for each in self.lagging)

    @property
    def even(self) -> bool:
        """False for bodies that relax: the history of a particle lies ahead of it along x."""
        return self.glassy.even and not any(each.length for each in self.lagging)

    @property
    def at_once(self) -> Homogeneous:
        return self.glassy

    def at_end(self, time: float) -> ViscoelasticMedium:
        """Medium of the tractions at the end of a step of a history: the part of their delayed
        displacements that follows within the step counts as instantaneous.
        """
        at_once = []
        for each in self.lagging:
            _, _, weight = relaxed(time / each.length)
            at_once.append(Lagging(0.0, each.factor * weight, each.medium))
        return ViscoelasticMedium(self.glassy, tuple(at_once))

    def influence(
        self, grid: Grid, x: np.ndarray, y: np.ndarray, components: Iterable[str]
    ) -> dict[str, np.ndarray]:
        """Influence numbers at places x (n,) and rows y (m, 1): elastic ones, and their means over
        what lies ahead.
        """
        names = list(components)
        numbers = self.glassy.influence(grid, x, y, names)
        for each in self.lagging:
            if each.length == 0:
                lagged = each.medium.influence(grid, x, y, names)
            else:
                lagged = _lagged_numbers(
                    each, grid, np.asarray(x, dtype=float), np.asarray(y, dtype=float), names
                )
            numbers = {name: numbers[name] + each.factor * lagged[name] for name in names}
        return numbers


def relaxed(ratio: float) -> tuple[float, float, float]:
    """Weights of P, p before and p now in P at the end of a step of ``ratio`` relaxation times, p
    linear in time.
    """
    left = math.exp(-ratio)
    mean = -math.expm1(-ratio) / ratio if ratio > 0 else 1.0
    return left, mean - left, 1 - mean


def moved(fields: np.ndarray, columns: float) -> np.ndarray:
    """Fields (..., n) of particles that were `columns` further along x; zero for those from beyond
    the lattice.

    Interpolated by cubics through four points, which keep the sum, the centre and the width of what
    moves.
    """
    count = fields.shape[-1]
    whole = math.floor(max(-count - 2.0, min(count + 2.0, columns)))
    c = min(max(columns - whole, 0.0), 1.0)
    weights = (
        -c * (c - 1) * (c - 2) / 6,
        (c + 1) * (c - 1) * (c - 2) / 2,
        -(c + 1) * c * (c - 2) / 2,
        (c**3 - c) / 6,
    )
    shifted = np.zeros_like(fields)
    for ahead, weight in enumerate(weights, whole - 1):
        if weight:
            target = slice(max(0, -ahead), max(0, count - ahead))
            source = slice(max(0, ahead), max(0, count + ahead))
            shifted[..., target] += weight * fields[..., source]
    return shifted


# ----------------------------------------------------------------------- means over what lies ahead


def _lagged_numbers(
    each: Lagging, grid: Grid, x: np.ndarray, y: np.ndarray, names: list[str]
) -> dict[str, np.ndarray]:
    """Lagged numbers at places x (n,) and rows y (m, 1): by recursion from the front backwards on
    each lattice of places.
    """

    def numbers(x: np.ndarray, y: np.ndarray) -> np.ndarray:
        elastic = each.medium.influence(grid, x, y, names)
        return np.stack(np.broadcast_arrays(*(elastic[name] for name in names)))

    dx, dy = grid.sides
    lagged = np.empty((len(names), y.size, x.size))
    places = np.round((x / dx) % 1.0, 9) % 1.0
    for place in np.unique(places):
        chosen = np.flatnonzero(places == place)
        steps = np.round(x[chosen] / dx - place).astype(int)
        last = max(int(steps.max()), 0 if place + 0.5 >= 1 else 1)  # beyond the element
        lattice = (np.arange(steps.min(), last + 1) + place) * dx
        rows = _lagged_rows(numbers, lattice, y, dx, dy, each.length)
        lagged[:, :, chosen] = rows[:, :, steps - steps.min()]
    return dict(zip(names, lagged, strict=True))


def _lagged_rows(
    numbers: Numbers, x: np.ndarray, y: np.ndarray, dx: float, dy: float, length: float
) -> np.ndarray:
    """Means (components, ny, nx) over what lies ahead, at x that rise by dx and rows y (ny, 1).

    ``C(x) = integral_0^dx B(x + s) exp(-s/l) ds/l + exp(-dx/l) C(x + dx)``. B has logarithms at the
    element's edges, one of which lies in each step near it: there Gauss's rule is dense.
    """
    count, *_ = numbers(x[:1], y[:1]).shape
    lagged = np.empty((count, y.size, x.size))
    # means over the first step ahead
    near_x = np.abs(x + dx / 2) < NEAR * dx
    near_y = np.abs(y.ravel()) < NEAR * dy
    edge = (dx / 2 - x[0]) % dx
    ends = [0.0, edge, dx] if 0 < edge < dx else [0.0, dx]
    dense = _rule(ends, length, 16, True)
    plain = _rule([0.0, dx], length, 6, False)
    everywhere = np.ones(x.size, dtype=bool)
    for rows, columns, (s, weights) in (
        (near_y, near_x, dense),
        (near_y, ~near_x, plain),
        (~near_y, everywhere, plain),
    ):
        places = (x[columns, None] + s).ravel()
        if places.size == 0 or not rows.any():
            continue
        rows_at_once = max(1, BATCH // places.size)
        for some in np.array_split(np.flatnonzero(rows), math.ceil(rows.sum() / rows_at_once)):
            values = numbers(places, y[some]).reshape(count, some.size, -1, s.size)
            lagged[np.ix_(np.arange(count), some, np.flatnonzero(columns))] = values @ weights
    # the mean over all that lies ahead of the front, and from there backwards
    least = min(dx, length) / 4
    most = FAR * length + dx
    doublings = math.ceil(math.log2(most / least))
    s, weights = _rule([0.0, *(least * 2.0 ** np.arange(doublings + 1))], length, 16, False)
    mean = numbers(x[-1] + dx + s, y).reshape(count, y.size, s.size) @ weights
    decay = math.exp(-dx / length)
    for i in range(x.size - 1, -1, -1):
        mean = lagged[..., i] + decay * mean
        lagged[..., i] = mean
    return lagged


def _rule(
    ends: list[float], length: float, points: int, dense: bool
) -> tuple[np.ndarray, np.ndarray]:
    """Points and weights of integrals with ``exp(-s/l)/l``, on panels that resolve it; `dense`
    about their ends.
    """
    first = ends[0]
    last = ends[-1]
    cuts = first + length * 2.0 ** np.arange(6)
    edges = np.unique([*ends, *cuts[cuts < last]])
    nodes, weights = np.polynomial.legendre.leggauss(points)
    if dense:
        angles = np.pi * (1 + nodes) / 2
        nodes = -np.cos(angles)
        weights = weights * np.pi / 2 * np.sin(angles)
    half = np.diff(edges)[:, None] / 2
    s = (edges[:-1, None] + half * (1 + nodes)).ravel()
    return s, (half * weights).ravel() * np.exp(-s / length) / length
