"""Normal and tangential problem that solvers meet, their solutions, and one half of a symmetric
problem; all dimensionless.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import partial
from typing import ClassVar

import numpy as np

from varcontact.discrete.positive_definite import PositiveDefinite, positive_definite
from varcontact.elasticity.operators import RestrictedOperator
from varcontact.interfaces.potential import Potential, magnitude
from varcontact.system.process import changed, lazy_property

ROUNDING = 1e-12
"""Differences of mirror images, relative to the largest value, that count as rounding."""


@dataclass(frozen=True, eq=False)
class NormalProblem:
    """Find ``p >= 0`` with ``e = h + A p - d >= 0`` and ``p e = 0``, on the potential contact of n
    elements.
    """

    operator: RestrictedOperator  # A, the influence numbers zz
    distance: np.ndarray
    area: float  # of an element
    # exactly one: prescribed ``area * sum(p)``, the approach d is then unknown; or prescribed d
    force: float | None
    approach: float | None
    symmetric: bool = True  # whether A is symmetric: not for viscoelastic bodies

    def shift(self, pressure: np.ndarray, rigid: np.ndarray) -> np.ndarray:
        """Deformed distance e = h + A p - d under pressures (n,), with the approach d (1,)."""
        return self.distance - rigid[0] + self.operator.apply(pressure[None])[0]

    def mean_approach(self, pressure: np.ndarray) -> float:
        """Approach d: the prescribed one, or the mean of h + A p weighted by the pressures (n,);
        zero without any.
        """
        if self.approach is not None:
            return self.approach
        total = pressure.sum()
        if total == 0:
            return 0.0
        level = self.distance + self.operator.apply(pressure[None])[0]
        return float(pressure @ level / total)

    def reachable(self) -> NormalProblem:
        """The problem on the elements that can come into contact at all.

        Where pressures only push surfaces apart (A > 0), there is no contact where h exceeds the
        approach. With the force prescribed, the approach is at most that with all of it on the
        lowest element. Soft layers that keep their volume bulge beside a load: any element may come
        into contact.
        """
        if self.operator.grid_operator.smallest < 0:
            return self
        highest = self.approach
        if highest is None:
            assert self.force is not None
            largest = self.operator.grid_operator.largest
            highest = self.distance.min() + largest * self.force / self.area
        inside = self.distance < highest
        operator = self.operator.grid_operator.on(self.operator.elements[inside])
        return changed(self, operator=operator, distance=self.distance[inside])


@dataclass(frozen=True, eq=False)
class TangentialProblem:
    """Find ``|p_i| <= g_i`` with ``p_i = -g_i E_i/|E_i|`` where it slips, ``E = W + M p``, on n
    elements in contact.

    Tractions have c components: two, or one where elasticity does not couple them and nothing moves
    along the other.
    """

    # M: the influence numbers A of a shift, or A - C of steady rolling (230)-(231)
    operator: RestrictedOperator
    rigid_shift: np.ndarray  # (c, n) W, with the shift by pressures where the bodies differ
    # phi: the traction bound g (n,), positive, and the flow; ``inf`` everywhere: no slip
    potential: Potential
    points: np.ndarray  # (2, n) x and y of the elements
    area: float  # of an element
    # prescribed ``area * sum(p)`` by component; a uniform rigid shift along it is then unknown
    force: tuple[float | None, ...] = (None, None)
    symmetric: bool = False  # whether M is symmetric (a shift, or one step of a history)
    # A of steady rolling, for time stepping; then ``A - M`` is C
    instant: RestrictedOperator | None = None
    directions: tuple[int, ...] = (0, 1)  # which direction (0: x, 1: y) each component has

    @property
    def bound(self) -> np.ndarray:
        """The traction bound g (n,)."""
        return self.potential.bound

    @property
    def size(self) -> int:
        return self.bound.size

    @property
    def components(self) -> int:
        return len(self.directions)

    @lazy_property
    def free(self) -> list[int]:
        """The components whose force is prescribed and whose rigid shift is unknown."""
        return [i for i, force in enumerate(self.force) if force is not None]

    @lazy_property
    def no_slip(self) -> bool:
        return bool(np.isinf(self.bound).all())

    def under(self, traction: np.ndarray) -> TangentialProblem:
        """Problem with the potential that follows from tractions (c, n), where it depends on
        them.
        """
        flow = self.potential.flow
        if flow is None or not self.potential.implicit:
            return self
        size = np.zeros(self.operator.grid_operator.shape)
        size.flat[self.operator.elements] = magnitude(traction)
        raised = replace(flow, threshold=flow.after(size), columns=0.0)
        potential = replace(self.potential, flow=raised.on(self.operator.elements))
        return replace(self, potential=potential)

    @property
    def symmetric_part(self) -> PositiveDefinite | None:
        """The symmetric part of M, where it is positive definite: then the solution is the only
        one.

        It always is in a shift. In steady rolling it was in every mesh measured (docs/theory.md)
        with steps of 0.7 elements or more; with shorter ones it may not be, the less so the larger
        nu, the longer the elements along x, and the more of them there are. It is found once for an
        operator, which steps share.
        """
        return self.operator.once("symmetric part", partial(positive_definite, self.operator))

    def shift(self, traction: np.ndarray, rigid: np.ndarray) -> np.ndarray:
        """Local shift E = W + M p of tractions (c, n), with the unknown part (c,) of W."""
        return self.operator.apply(traction) + self.rigid_shift + rigid[:, None]

    def of_grid(self, traction: np.ndarray, rigid: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Tractions (c, n) and rigid shifts (c,) of the problem, from those (2, ny, nx) and (2,) of
        the grid.
        """
        chosen = list(self.directions)
        return traction.reshape(2, -1)[chosen].take(self.operator.elements, axis=1), rigid[chosen]

    def on_grid(self, traction: np.ndarray, rigid: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """The reverse of `of_grid`: zero elsewhere and in other directions."""
        ny, nx = self.operator.grid_operator.shape
        directions = np.array(self.directions)
        field = np.zeros((2, ny * nx))
        field[directions[:, None], self.operator.elements] = traction
        shifts = np.zeros(2)
        shifts[directions] = rigid
        return field.reshape(2, ny, nx), shifts


@dataclass(frozen=True, eq=False)
class RawSolution:
    """Answer of a solver, not yet judged.

    The traction is a pressure (n,) or tractions (c, n); rigid (1,) or (c,) is the approach, or the
    uniform rigid shift where the force is prescribed. The status is the solver's own word, `solved`
    what it means: whether the solver says that it reached all it was asked for. The reason tells
    why another solver than the one asked for has answered, where there was no choice. The residual
    is that of the natural map, or no less, where the solver measured it; else NaN.
    """

    traction: np.ndarray
    rigid: np.ndarray
    iterations: int = 0
    status: str = ""
    solved: bool = True
    solver: str = ""
    reason: str = ""
    residual: float = math.nan

    @property
    def finite(self) -> bool:
        return bool(np.isfinite(self.traction).all() and np.isfinite(self.rigid).all())


@dataclass(frozen=True, eq=False)
class FoldedOperator(RestrictedOperator):
    """An operator on half of its elements, whose mirror images have the same tractions but for a
    sign.

    The signs are of the images' tractions: (1, -1) is a mirror, (-1, 1) a mirror and a change of
    direction.
    """

    images: np.ndarray
    signs: tuple[float, float]
    copies: ClassVar[int] = 2

    @property
    def _places(self) -> tuple[np.ndarray | None, ...]:
        return self.elements, self.softening, self.images, np.array(self.signs)

    def _assembled(self) -> np.ndarray:
        """Dense matrix, (2 n, 2 n): from the elements, and from their images."""
        own = super()._assembled()
        own += self.grid_operator.dense(self.elements, self.images) * np.repeat(
            self.signs, self.elements.size
        )
        return own

    def apply(self, tractions: np.ndarray) -> np.ndarray:
        """Displacements (2, n) by tractions (2, n), both on one side."""
        both = RestrictedOperator(self.grid_operator, np.concatenate([self.elements, self.images]))
        product = both.apply(np.hstack([tractions, tractions * np.array(self.signs)[:, None]]))
        product = product[:, : self.elements.size]
        if self.softening is None:
            return product
        return product + self.softening * tractions


@dataclass(frozen=True, eq=False)
class Mirror:
    """The mirror symmetry of a problem: places of the elements on one side of the line, and of
    their images.
    """

    half: np.ndarray
    images: np.ndarray
    signs: tuple[float, float]

    def fold(self, problem: TangentialProblem) -> TangentialProblem:
        """The problem on one side, with half of a prescribed force."""
        instant = problem.instant
        if instant is not None:
            instant = self._folded(instant)
        return changed(
            problem,
            operator=self._folded(problem.operator),
            instant=instant,
            rigid_shift=problem.rigid_shift[:, self.half],
            potential=problem.potential.on(self.half),
            points=problem.points[:, self.half],
            force=tuple(None if force is None else force / 2 for force in problem.force),
        )

    def unfold(self, raw: RawSolution) -> RawSolution:
        """Tractions on both sides, from those on one side."""
        traction = np.empty((2, 2 * self.half.size))
        traction[:, self.half] = raw.traction
        traction[:, self.images] = raw.traction * np.array(self.signs)[:, None]
        return changed(raw, traction=traction)

    def _folded(self, operator: RestrictedOperator) -> FoldedOperator:
        """The operator on the elements of one side."""
        softening = operator.softening
        if softening is not None:
            softening = softening[:, self.half]
        return FoldedOperator(
            operator.grid_operator,
            operator.elements[self.half],
            operator.elements[self.images],
            self.signs,
            softening=softening,
        )


def mirror_of(problem: TangentialProblem) -> Mirror | None:
    """The mirror of a tangential problem, or None where it has none or a row of elements lies on
    the line.

    Influence numbers have every such symmetry: xx and yy are even in y, xy is odd; on a surface
    whose curvature varies where inclinations are odd.
    """
    operator = problem.operator.grid_operator
    elements = problem.operator.elements
    columns = operator.shape[1]
    if elements.size == 0 or len(problem.rigid_shift) != 2:
        return None
    if not _may_be_odd(problem.rigid_shift):
        return None
    if not operator.has_mirror(slice(elements[0] // columns, elements[-1] // columns + 1)):
        return None
    # each element has its mirror image among the elements, and none lies on the line
    row, column = np.divmod(elements, columns)
    reflected_row = row.min() + row.max() - row
    reflected = reflected_row * columns + column
    half = np.flatnonzero(row > reflected_row)
    images = np.minimum(np.searchsorted(elements, reflected), elements.size - 1)
    if 2 * half.size != elements.size or np.any(elements[images] != reflected):
        return None
    # the potential is even
    flow = problem.potential.flow
    if not _is_even(problem.bound, images):
        return None
    if flow is not None and not _is_even(flow.threshold, images):
        return None
    # the rigid shift along one direction is even, along the other odd
    signs = _signs_of_shift(problem, images)
    if signs is None:
        return None
    return Mirror(half, images[half], signs)


def _may_be_odd(values: np.ndarray) -> bool:
    """True if a component of values (c, n) may be odd: its sum is only rounding."""
    sums = np.abs(values.sum(axis=1))
    rounding = ROUNDING * values.shape[1] * np.abs(values).max()
    return bool(sums.min() <= rounding)


def _is_even(values: np.ndarray, images: np.ndarray) -> bool:
    """True if values (n,) equal those at the mirror images up to rounding; infinite ones are not
    compared.
    """
    largest = np.max(values, initial=0.0)
    if not np.isfinite(largest):
        return True
    return not np.abs(values - values[images]).max() > ROUNDING * largest


def _signs_of_shift(problem: TangentialProblem, images: np.ndarray) -> tuple[float, float] | None:
    """Signs of the images' rigid shifts along x and y, without a prescribed force along the odd
    one; None: no symmetry.
    """
    rigid_shift = problem.rigid_shift
    largest = np.abs(rigid_shift).max()
    for signs, odd in (((1.0, -1.0), 1), ((-1.0, 1.0), 0)):
        difference = rigid_shift[:, images] - np.array(signs)[:, None] * rigid_shift
        if problem.force[odd] is None and np.abs(difference).max() <= ROUNDING * largest:
            return signs
    return None
