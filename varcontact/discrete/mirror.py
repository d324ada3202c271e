"""Half of a tangential problem, where it is its own mirror image about a line along x."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from varcontact.discrete.problems import RawSolution, TangentialProblem
from varcontact.elasticity.operators import RestrictedOperator

ROUNDING = 1e-12
"""Differences of mirror images, relative to the largest value, that count as rounding."""


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
        own = self._softened(self.grid_operator.dense(self.elements))
        own += self.grid_operator.dense(self.elements, self.images) * np.repeat(self.signs, self.elements.size)
        return own

    def apply(self, tractions: np.ndarray) -> np.ndarray:
        """Displacements (2, n) by tractions (2, n), both on one side."""
        ny, nx = self.grid_operator.shape
        field = np.zeros((2, ny * nx))
        field[:, self.elements] = tractions
        field[:, self.images] = tractions * np.array(self.signs)[:, None]
        product = self.grid_operator.apply(field.reshape(2, ny, nx)).reshape(2, -1)[:, self.elements]
        return self._with_own(product, tractions)


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
            points=problem.points[:, self.half],
            force=(None if along_x is None else along_x / 2, None if along_y is None else along_y / 2),
        )

    def fold_solution(self, raw: RawSolution) -> RawSolution:
        """Tractions on one side."""
        return replace(raw, traction=raw.traction[:, self.half])

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


def mirror(
    elements: np.ndarray,
    columns: int,
    rigid_shift: np.ndarray,
    bound: np.ndarray,
    force: tuple[float | None, ...] = (None, None),
) -> Mirror | None:
    """The mirror of a tangential problem, or None where it has none or a row of elements lies on the line.

    Influence numbers have every such symmetry: xx and yy are even in y, xy is odd.
    """
    if len(rigid_shift) != 2 or elements.size == 0:
        return None
    row, column = np.divmod(elements, columns)
    reflected = row.min() + row.max() - row
    half = np.flatnonzero(row > reflected)
    images = np.searchsorted(elements, reflected * columns + column)
    images = np.minimum(images, elements.size - 1)
    if 2 * half.size != elements.size or np.any(elements[images] != reflected * columns + column):
        return None
    largest = np.max(bound, initial=0.0)
    if np.isfinite(largest) and np.abs(bound - bound[images]).max() > ROUNDING * largest:
        return None
    for signs, odd in (((1.0, -1.0), 1), ((-1.0, 1.0), 0)):
        unlike = rigid_shift[:, images] - np.array(signs)[:, None] * rigid_shift
        if force[odd] is None and np.abs(unlike).max() <= ROUNDING * np.abs(rigid_shift).max():
            return Mirror(half, images[half], signs)
    return None


def mirror_of(problem: TangentialProblem) -> Mirror | None:
    """The mirror of a tangential problem, or None."""
    operator, elements = problem.operator.grid_operator, problem.operator.elements
    columns = operator.shape[1]
    if elements.size and not operator.has_mirror(elements[0] // columns, elements[-1] // columns):
        return None
    return mirror(elements, columns, problem.rigid_shift, problem.bound, problem.force)
