"""The two problems that solvers meet, what they return, and half of a symmetric one; all is dimensionless."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from varcontact.discrete.positive_definite import PositiveDefinite, positive_definite
from varcontact.elasticity.conformal import STRAIGHT, ConformalOperator
from varcontact.elasticity.operators import RestrictedOperator

ROUNDING = 1e-12
"""Differences of mirror images, relative to the largest value, that count as rounding."""


@dataclass(frozen=True, eq=False)
class NormalProblem:
    """Find ``p >= 0`` with ``e = h + A p - d >= 0`` and ``p e = 0``, on the potential contact of n elements."""

    operator: RestrictedOperator  # A, the influence numbers zz
    distance: np.ndarray
    area: float  # of an element
    force: float | None  # exactly one: prescribed ``area * sum(p)``, the approach d is then unknown; or prescribed d
    approach: float | None
    symmetric: bool = True  # whether A is: not of viscoelastic bodies

    def shift(self, pressure: np.ndarray, rigid: np.ndarray) -> np.ndarray:
        """Deformed distance e = h + A p - d under pressures (n,), with the approach d (1,)."""
        return self.distance - rigid[0] + self.operator.apply(pressure[None])[0]

    def reachable(self) -> NormalProblem:
        """The problem on the elements that can come into contact at all.

        Where pressures only push surfaces apart (A > 0), there is no contact where h exceeds the approach. With the
        force prescribed, the approach is at most that with all of it on the lowest element. Soft layers that keep their
        volume bulge beside a load: any element may come into contact.
        """
        if self.operator.grid_operator.table.min() < 0:
            return self
        highest = self.approach
        if highest is None:
            assert self.force is not None
            most = self.operator.diagonal if self.symmetric else self.operator.grid_operator.table.max()
            highest = self.distance.min() + most * self.force / self.area
        inside = self.distance < highest
        operator = self.operator.grid_operator.on(self.operator.elements[inside])
        return replace(self, operator=operator, distance=self.distance[inside])


@dataclass(frozen=True, eq=False)
class Yielding:
    """A hardening layer: elements flow along their traction, by ``(|p| - stress)/hardening``, from a stress on.

    Tractions are then those with least ``(|p| - stress)_+^2/(2 hardening)``, of which `projected` is the proximal map.
    """

    stress: np.ndarray  # (n,) or (ny, nx) the yield stress tau_v that particles bring along
    hardening: float  # k, positive
    columns: float = 0.0  # passed in a step of steady rolling, where the stress is that of fresh material

    def flow(self, traction: np.ndarray) -> np.ndarray:
        """Plastic shift (c, ...) under tractions."""
        size = magnitude(traction)
        beyond = np.maximum(size - self.stress, 0.0) / self.hardening
        return np.asarray(traction * (beyond / np.where(size > 0, size, 1.0)))

    def sizes(self, size: np.ndarray, weight: float) -> np.ndarray:
        """Sizes of tractions from those of trial tractions ``p - E/weight``, before friction limits them."""
        ratio = 1 / (self.hardening * weight)
        return np.where(size > self.stress, (size + ratio * self.stress) / (1 + ratio), size)

    def tangent(self, traction: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Derivatives of the flow by the traction, along it and across it; zero where nothing flows."""
        size = magnitude(traction)
        flows = size > self.stress
        across = np.where(flows, 1 - self.stress / np.where(flows, size, 1.0), 0.0) / self.hardening
        return flows / self.hardening, across

    def after(self, size: np.ndarray) -> np.ndarray:
        """The stress with which particles arrive, hardened along their rows by tractions of a size (ny, nx)."""
        fresh = float(self.stress.min())
        return further_along(along_rows(size, self.columns, fresh, np.maximum), self.columns, fresh)

    def on(self, elements: np.ndarray) -> Yielding:
        """That of some elements."""
        return replace(self, stress=self.stress.ravel()[elements])


def along_rows(
    found: np.ndarray, columns: float, fresh: float, join: Callable[[np.ndarray, np.ndarray], np.ndarray]
) -> np.ndarray:
    """What particles have gathered on their way along the rows (..., ny, nx) of steady rolling, so many columns a step.

    From what a step adds, joined with what they had one step before, or where steps are shorter one column before.
    """
    nx, way = found.shape[-1], min(max(columns, 1.0), float(found.shape[-1]))
    whole, part = int(way), way % 1.0
    padded = np.pad(found, [(0, 0)] * (found.ndim - 1) + [(0, nx + 1)], constant_values=fresh)
    for i in range(nx - 1, -1, -1):
        near, far = padded[..., i + whole], padded[..., i + whole + 1]
        padded[..., i] = join(near + part * (far - near) if part else near, padded[..., i])
    return np.asarray(padded[..., :nx])


def further_along(field: np.ndarray, columns: float, beyond: float | None = 0.0) -> np.ndarray:
    """Values (..., ny, nx) so many columns further along x; `beyond` the grid, by default zero, None: as at its end."""
    nx = field.shape[-1]
    columns = max(-nx - 1.0, min(nx + 1.0, columns))
    whole = math.floor(columns)
    room, first = [(0, 0)] * (field.ndim - 1) + [(nx + 1, nx + 2)], nx + 1 + whole
    padded = np.pad(field, room, mode="edge") if beyond is None else np.pad(field, room, constant_values=beyond)
    near, far = padded[..., first : first + nx], padded[..., first + 1 : first + 1 + nx]
    return near if columns == whole else np.asarray(near + (columns - whole) * (far - near))


def magnitude(vectors: np.ndarray) -> np.ndarray:
    """Lengths of vectors."""
    return np.abs(vectors[0]) if len(vectors) == 1 else np.sqrt(vectors[0] ** 2 + vectors[1] ** 2)


def project(trial: np.ndarray, bound: np.ndarray, yielding: Yielding | None = None, weight: float = 1.0) -> np.ndarray:
    """Projection of tractions on the disks, or the intervals, that the bound leaves, less what flows.

    Where a layer yields, `trial` are trial tractions ``p - E/weight``.
    """
    size = magnitude(trial)
    most = bound if yielding is None else np.minimum(yielding.sizes(size, weight), bound)
    beyond = size > most
    return trial * np.where(beyond, most / np.where(beyond, size, 1.0), 1.0)


@dataclass(frozen=True, eq=False)
class TangentialProblem:
    """Find ``|p_i| <= g_i`` with ``p_i = -g_i E_i/|E_i|`` where it slips, ``E = W + M p``, on n elements in contact.

    Tractions have c components: two, or one where elasticity does not couple them and nothing moves along the other.
    """

    operator: RestrictedOperator  # M: the influence numbers A of a shift, or A - C of steady rolling (230)-(231)
    rigid_shift: np.ndarray  # (c, n) W, with the shift by pressures where the bodies differ
    bound: np.ndarray  # (n,) g, the traction bound, positive; ``inf`` all over: no slip
    points: np.ndarray  # (2, n) x and y of the elements
    area: float  # of an element
    # prescribed ``area * sum(p)`` by component; a uniform rigid shift along it is then unknown
    force: tuple[float | None, ...] = (None, None)
    symmetric: bool = False  # whether M is symmetric (a shift, or one step of a history)
    instant: RestrictedOperator | None = None  # A of steady rolling, for time stepping; then ``A - M`` is C
    directions: tuple[int, ...] = (0, 1)  # which direction (0: x, 1: y) each component has
    yielding: Yielding | None = None  # elements flow before they slip

    @property
    def size(self) -> int:
        return self.bound.size

    @property
    def components(self) -> int:
        return len(self.directions)

    @property
    def free(self) -> list[int]:
        """The components whose force is prescribed and whose rigid shift is unknown."""
        return [i for i, force in enumerate(self.force) if force is not None]

    @property
    def no_slip(self) -> bool:
        return bool(np.isinf(self.bound).all())

    def under(self, traction: np.ndarray) -> TangentialProblem:
        """The problem with the yield stress that tractions leave, where it follows from them."""
        if self.yielding is None or self.yielding.columns == 0:
            return self
        size = np.zeros(self.operator.grid_operator.shape)
        size.flat[self.operator.elements] = magnitude(traction)
        stress = self.yielding.after(size)
        return replace(self, yielding=Yielding(stress, self.yielding.hardening).on(self.operator.elements))

    @property
    def symmetric_part(self) -> PositiveDefinite | None:
        """The symmetric part of M, where it is positive definite: then the solution is the only one.

        It always is in a shift. In steady rolling it was in every mesh measured (docs/theory.md) with steps of 0.7
        elements or more; with shorter ones it may not be, the less so the larger nu, the longer the elements along
        x, and the more of them there are. It is found once for an operator, which steps share.
        """
        kept: dict[str, PositiveDefinite | None] = self.operator.__dict__
        if "_symmetric_part" not in kept:
            kept["_symmetric_part"] = positive_definite(self.operator)
        return kept["_symmetric_part"]

    def shift(self, traction: np.ndarray, rigid: np.ndarray) -> np.ndarray:
        """Local shift E = W + M p of tractions (c, n), with the unknown part (c,) of W."""
        return self.operator.apply(traction) + self.rigid_shift + rigid[:, None]

    def projected(self, trial: np.ndarray, weight: float) -> np.ndarray:
        """Tractions of the natural map, from trial tractions ``p - E/weight``: within the bound, less what flows."""
        return project(trial, self.bound, self.yielding, weight)

    def slips(self, trial: np.ndarray, weight: float) -> np.ndarray:
        """Where trial tractions ``p - E/weight`` are beyond the bound, (n,)."""
        size = magnitude(trial)
        beyond: np.ndarray = (size if self.yielding is None else self.yielding.sizes(size, weight)) > self.bound
        return beyond

    def of_grid(self, traction: np.ndarray, rigid: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Tractions (c, n) and rigid shifts (c,) of the problem, from those (2, ny, nx) and (2,) of the grid."""
        chosen = list(self.directions)
        return traction.reshape(2, -1)[chosen][:, self.operator.elements], rigid[chosen]

    def on_grid(self, traction: np.ndarray, rigid: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """The reverse of `of_grid`: zero elsewhere and in other directions."""
        ny, nx = self.operator.grid_operator.shape
        field, shifts, chosen = np.zeros((2, ny * nx)), np.zeros(2), np.array(self.directions)
        field[np.ix_(chosen, self.operator.elements)], shifts[chosen] = traction, rigid
        return field.reshape(2, ny, nx), shifts


@dataclass(frozen=True, eq=False)
class RawSolution:
    """What a solver returns, not yet judged.

    The traction is a pressure (n,) or tractions (c, n); rigid (1,) or (c,) is the approach, or the uniform rigid shift
    where the force is prescribed. The status is the solver's own word, `solved` what it means: whether the solver says
    that it reached all it was asked for. The reason tells why another solver than the one asked for has answered, where
    there was no choice.
    """

    traction: np.ndarray
    rigid: np.ndarray
    iterations: int = 0
    status: str = ""
    solved: bool = True
    solver: str = ""
    reason: str = ""

    @property
    def finite(self) -> bool:
        return bool(np.isfinite(self.traction).all() and np.isfinite(self.rigid).all())


@dataclass(frozen=True, eq=False)
class FoldedOperator(RestrictedOperator):
    """An operator on half of its elements, whose mirror images have the same tractions but for a sign.

    The signs are of the images' tractions: (1, -1) is a mirror, (-1, 1) a mirror and a change of direction.
    """

    images: np.ndarray
    signs: tuple[float, float]

    @cached_property
    def matrix(self) -> np.ndarray:
        """Dense matrix, (2 n, 2 n): from the elements, and from their images."""
        own = self._assembled()
        own += self.grid_operator.dense(self.elements, self.images) * np.repeat(self.signs, self.elements.size)
        return own

    def apply(self, tractions: np.ndarray) -> np.ndarray:
        """Displacements (2, n) by tractions (2, n), both on one side."""
        both = RestrictedOperator(self.grid_operator, np.concatenate([self.elements, self.images]))
        product = both.apply(np.hstack([tractions, tractions * np.array(self.signs)[:, None]]))
        product = product[:, : self.elements.size]
        return product if self.softening is None else product + self.softening * tractions


@dataclass(frozen=True, eq=False)
class Mirror:
    """How a problem is its own mirror image: places of the elements on one side of the line, and of their images."""

    half: np.ndarray
    images: np.ndarray
    signs: tuple[float, float]

    def fold(self, problem: TangentialProblem) -> TangentialProblem:
        """The problem on one side, with half of a prescribed force."""
        instant, (along_x, along_y) = problem.instant, problem.force
        return replace(
            problem,
            operator=self._folded(problem.operator),
            instant=None if instant is None else self._folded(instant),
            rigid_shift=problem.rigid_shift[:, self.half],
            bound=problem.bound[self.half],
            yielding=None if problem.yielding is None else problem.yielding.on(self.half),
            points=problem.points[:, self.half],
            force=(None if along_x is None else along_x / 2, None if along_y is None else along_y / 2),
        )

    def unfold(self, raw: RawSolution) -> RawSolution:
        """Tractions on both sides, from those on one."""
        traction = np.empty((2, 2 * self.half.size))
        traction[:, self.half] = raw.traction
        traction[:, self.images] = raw.traction * np.array(self.signs)[:, None]
        return replace(raw, traction=traction)

    def _folded(self, operator: RestrictedOperator) -> FoldedOperator:
        """The folded operator, made once for each operator, so that its matrix is, too."""
        kept: dict[tuple[float, float], FoldedOperator] = operator.__dict__.setdefault("_folded", {})
        if self.signs not in kept:
            half, images = operator.elements[self.half], operator.elements[self.images]
            soft = None if operator.softening is None else operator.softening[:, self.half]
            kept[self.signs] = FoldedOperator(operator.grid_operator, half, images, self.signs, softening=soft)
        return kept[self.signs]


def mirror_of(problem: TangentialProblem) -> Mirror | None:
    """The mirror of a tangential problem, or None where it has none or a row of elements lies on the line.

    Influence numbers have every such symmetry: xx and yy are even in y, xy is odd; on a surface whose curvature varies
    where inclinations are odd.
    """
    operator, elements, bound = problem.operator.grid_operator, problem.operator.elements, problem.bound
    rigid_shift, columns = problem.rigid_shift, operator.shape[1]
    if elements.size == 0 or len(rigid_shift) != 2:
        return None
    if isinstance(operator, ConformalOperator):
        angles = operator.angles[elements[0] // columns : elements[-1] // columns + 1]
        if np.ptp(angles + angles[::-1]) > STRAIGHT:
            return None
    row, column = np.divmod(elements, columns)
    reflected = row.min() + row.max() - row
    half = np.flatnonzero(row > reflected)
    images = np.searchsorted(elements, reflected * columns + column)
    images = np.minimum(images, elements.size - 1)
    if 2 * half.size != elements.size or np.any(elements[images] != reflected * columns + column):
        return None
    for even in (bound,) if problem.yielding is None else (bound, problem.yielding.stress):
        largest = np.max(even, initial=0.0)
        if np.isfinite(largest) and np.abs(even - even[images]).max() > ROUNDING * largest:
            return None
    for signs, odd in (((1.0, -1.0), 1), ((-1.0, 1.0), 0)):
        unlike = rigid_shift[:, images] - np.array(signs)[:, None] * rigid_shift
        if problem.force[odd] is None and np.abs(unlike).max() <= ROUNDING * np.abs(rigid_shift).max():
            return Mirror(half, images[half], signs)
    return None
