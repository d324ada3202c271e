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
"""Relaxation lengths after which the past counts no longer."""
NEAR = 5.0
"""Sides of an element up to which points of a Gauss's rule are dense about its edges."""
BATCH = 100_000
"""Points at which influence numbers are evaluated in one go."""

Numbers = Callable[[np.ndarray, np.ndarray], np.ndarray]
"""Influence numbers (components, ...) at x and y, which broadcast together."""


@dataclass(frozen=True)
class Lagging:
    """What of the displacements follows with one relaxation length: a factor of those of an elastic
    medium.

    In a history the length stands for the relaxation time; 0 follows at once.
    """

    length: float
    factor: float
    medium: Homogeneous


@dataclass(frozen=True)
class ViscoelasticMedium(Homogeneous):
    """Two bodies that roll steadily: as they are at once (glassy), and what lags behind.

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
        """Size of the coupling, no less than it has at any frequency."""
        return abs(self.glassy.K) + sum(each.factor * abs(each.medium.K) for each in self.lagging)

    @property
    def even(self) -> bool:
        """Unless something lags: the past lies ahead."""
        return self.glassy.even and not any(each.length for each in self.lagging)

    @property
    def at_once(self) -> Homogeneous:
        return self.glassy

    def at_end(self, time: float) -> ViscoelasticMedium:
        """The bodies at the end of a step of a history: what follows the tractions' change in it,
        as if at once.
        """
        followed = (each.factor * relaxed(time / each.length)[2] for each in self.lagging)
        parts = zip(followed, self.lagging, strict=True)
        return ViscoelasticMedium(
            self.glassy, tuple(Lagging(0.0, part, each.medium) for part, each in parts)
        )

    def influence(
        self, grid: Grid, x: np.ndarray, y: np.ndarray, components: Iterable[str]
    ) -> dict[str, np.ndarray]:
        """Influence numbers at places x (n,) and rows y (m, 1): elastic ones, and their means over
        what lies ahead.
        """
        names = list(components)
        found = self.glassy.influence(grid, x, y, names)
        for each in self.lagging:
            if each.length == 0:
                later = each.medium.influence(grid, x, y, names)
            else:
                later = _lagged_numbers(
                    each, grid, np.asarray(x, dtype=float), np.asarray(y, dtype=float), names
                )
            found = {name: found[name] + each.factor * later[name] for name in names}
        return found


def relaxed(ratio: float) -> tuple[float, float, float]:
    """Weights of P, p before and p now in P at the end of a step of ``ratio`` relaxation times, p
    linear in time.
    """
    left = math.exp(-ratio)
    mean = -math.expm1(-ratio) / ratio if ratio > 0 else 1.0
    return left, mean - left, 1 - mean


def moved(fields: np.ndarray, columns: float) -> np.ndarray:
    """Fields (..., n) of particles that were so many columns further along x; nothing comes from
    beyond.

    By cubics through four points, which keep the sum, the centre and the width of what moves.
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
    found = np.zeros_like(fields)
    for ahead, weight in enumerate(weights, whole - 1):
        if weight:
            to, come = (
                slice(max(0, -ahead), max(0, count - ahead)),
                slice(max(0, ahead), max(0, count + ahead)),
            )
            found[..., to] += weight * fields[..., come]
    return found


# ----------------------------------------------------------------------- means over what lies ahead


def _lagged_numbers(
    each: Lagging, grid: Grid, x: np.ndarray, y: np.ndarray, names: list[str]
) -> dict[str, np.ndarray]:
    """At places x (n,) and rows y (m, 1): by recursion from the front backwards on each lattice of
    places.
    """

    def numbers(x: np.ndarray, y: np.ndarray) -> np.ndarray:
        found = each.medium.influence(grid, x, y, names)
        return np.stack(np.broadcast_arrays(*(found[name] for name in names)))

    dx, dy = grid.sides
    found = np.empty((len(names), y.size, x.size))
    places = np.round((x / dx) % 1.0, 9) % 1.0
    for place in np.unique(places):
        chosen = np.flatnonzero(places == place)
        steps = np.round(x[chosen] / dx - place).astype(int)
        last = max(int(steps.max()), 0 if place + 0.5 >= 1 else 1)  # beyond the element
        rows = _lagged_rows(
            numbers, (np.arange(steps.min(), last + 1) + place) * dx, y, dx, dy, each.length
        )
        found[:, :, chosen] = rows[:, :, steps - steps.min()]
    return dict(zip(names, found, strict=True))


def _lagged_rows(
    numbers: Numbers, x: np.ndarray, y: np.ndarray, dx: float, dy: float, length: float
) -> np.ndarray:
    """Means (components, ny, nx) over what lies ahead, at x that rise by dx and rows y (ny, 1).

    ``C(x) = integral_0^dx B(x + s) exp(-s/l) ds/l + exp(-dx/l) C(x + dx)``. B has logarithms at the
    element's edges, one of which lies in each step near it: there Gauss's rule is dense.
    """
    found = np.empty((*numbers(x[:1], y[:1]).shape[:1], y.size, x.size))
    near_x, near_y = np.abs(x + dx / 2) < NEAR * dx, np.abs(y.ravel()) < NEAR * dy
    edge = (dx / 2 - x[0]) % dx
    dense = _rule([0.0, edge, dx] if 0 < edge < dx else [0.0, dx], length, 16, True)
    plain = _rule([0.0, dx], length, 6, False)
    for rows, columns, (s, weights) in (
        (near_y, near_x, dense),
        (near_y, ~near_x, plain),
        (~near_y, np.ones(x.size, dtype=bool), plain),
    ):
        places = (x[columns, None] + s).ravel()
        each = max(1, BATCH // max(places.size, 1))
        for some in (
            np.array_split(np.flatnonzero(rows), math.ceil(rows.sum() / each))
            if places.size and rows.any()
            else ()
        ):
            values = numbers(places, y[some]).reshape(len(found), some.size, -1, s.size)
            found[np.ix_(np.arange(len(found)), some, np.flatnonzero(columns))] = values @ weights
    least, most = min(dx, length) / 4, FAR * length + dx
    s, weights = _rule(
        [0.0, *(least * 2.0 ** np.arange(math.ceil(math.log2(most / least)) + 1))],
        length,
        16,
        False,
    )
    later = numbers(x[-1] + dx + s, y).reshape(len(found), y.size, s.size) @ weights
    decay = math.exp(-dx / length)
    for i in range(x.size - 1, -1, -1):
        later = found[..., i] = found[..., i] + decay * later
    return found


def _rule(
    ends: list[float], length: float, points: int, dense: bool
) -> tuple[np.ndarray, np.ndarray]:
    """Points and weights of integrals with ``exp(-s/l)/l``, on panels that resolve it; dense: about
    their ends.
    """
    first, last = ends[0], ends[-1]
    cuts = first + length * 2.0 ** np.arange(6)
    edges = np.unique([*ends, *cuts[cuts < last]])
    nodes, weights = np.polynomial.legendre.leggauss(points)
    if dense:
        nodes, weights = (
            -np.cos(np.pi * (1 + nodes) / 2),
            weights * np.pi / 2 * np.sin(np.pi * (1 + nodes) / 2),
        )
    half = np.diff(edges)[:, None] / 2
    s = (edges[:-1, None] + half * (1 + nodes)).ravel()
    return s, (half * weights).ravel() * np.exp(-s / length) / length
