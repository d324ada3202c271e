"""Newton's method for the normal problem, without a matrix.

With ``y = p - E``, E the deformed distance, the solution is ``p = max(y, 0)``.
Where y is positive there is contact, and Newton's equation is ``A d = -E``;
elsewhere it is ``d = -p``.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from varcontact.discrete.problems import NormalProblem, RawSolution
from varcontact.discrete.residuals import normal_gap, normal_residual
from varcontact.solvers.interface import Settings
from varcontact.solvers.newton.driver import GridConditions, GridProblem, point, solve
from varcontact.solvers.newton.gcr import Forces
from varcontact.solvers.newton.globalisation import Point
from varcontact.solvers.newton.hierarchy import Box
from varcontact.solvers.newton.kernel import product_and_plain, unit
from varcontact.solvers.newton.tangential import TangentialSystem


def newton_normal(
    problem: NormalProblem, settings: Settings, start: RawSolution | None = None
) -> RawSolution:
    scaled = scaled_normal(problem)
    if isinstance(scaled, RawSolution):
        return scaled
    return solve(scaled, start, settings)


def scaled_normal(problem: NormalProblem) -> ScaledNormal | RawSolution:
    """Problem divided by its units, or its answer where nothing touches or the input is not
    finite.
    """
    approach = np.array([problem.approach or 0.0])
    apart = RawSolution(np.zeros_like(problem.distance), approach, 0, "Solved")
    if not np.isfinite(problem.distance).all():
        return replace(apart, status="NotANumber", solved=False)
    return ScaledNormal.of(problem) or apart


@dataclass(frozen=True, eq=False)
class NormalConditions(GridConditions):
    """The normal problem on a box: `known` is h, less the approach where that is given (1, ny, nx).

    Kernels of viscoelastic bodies are as skew as those of a step of rolling; their relaxation
    length stays as it is.
    """

    @property
    def of_step(self) -> bool:
        return False

    @property
    def slides(self) -> bool:
        return False

    def projected(self, trial: np.ndarray) -> np.ndarray:
        return np.maximum(trial, 0.0) * self.contact

    def proximal(self, trial: np.ndarray, weight: float) -> np.ndarray:
        return self.projected(trial)

    def sticks(self, trial: np.ndarray, weight: float) -> np.ndarray:
        """Elements in contact."""
        contact: np.ndarray = self.contact & (trial[0] > 0)
        return contact

    def admissible(self, traction: np.ndarray, trial: np.ndarray) -> np.ndarray:
        """Positive only where the natural map has contact."""
        return np.where(trial > 0, np.maximum(traction, 0.0), 0.0)

    def linearised(
        self, traction: np.ndarray, shift: np.ndarray, trial: np.ndarray
    ) -> TangentialSystem:
        """Equations of tractions that stick in contact, and elsewhere slip without a bound."""
        contact = (trial > 0) & self.contact
        return TangentialSystem(
            right=np.where(contact, -shift, -traction),
            conditions=self,
            stick=contact[0],
            along=1.0 * ~contact,
            across=np.zeros(trial.shape),
            held=np.ones(trial[0].shape),
        )

    def first(self) -> Point:
        """Start without pressures; under a prescribed force at an approach where all elements
        overlap.
        """
        level = -self.known.max() - 1 if self.forces.components else 0.0
        return point(self, np.zeros_like(self.known), np.full((1, 1, 1), level))


@dataclass(frozen=True, eq=False)
class ScaledNormal(GridProblem[NormalConditions]):
    """A normal problem in its own units; the rigid shift is minus an unknown approach."""

    problem: NormalProblem

    @classmethod
    def of(cls, problem: NormalProblem) -> ScaledNormal | None:
        """The problem divided by its units; None where nothing touches."""
        size = problem.distance.size
        if size == 0:
            return None
        own = unit(problem.operator.grid_operator)
        if problem.force is not None:
            load = problem.force / (problem.area * size)
        else:
            assert problem.approach is not None
            load = (problem.approach - float(problem.distance.min())) / own
        if load <= 0:
            return None
        box = Box.around(problem.operator)
        displacement = own * load
        known = box.field((problem.distance[None] - (problem.approach or 0.0)) / displacement)
        forces = Forces((), np.array([]), 1 / np.sqrt(size))
        if problem.force is not None:
            sums = np.array([problem.force / (problem.area * load)])
            forces = replace(forces, components=(0,), sums=sums)
        product, plain = product_and_plain(problem.operator, box.shape)
        conditions = NormalConditions(product, known, forces, box.field(np.ones(size)), plain)
        return cls(conditions, problem, box, load, displacement, sign=-1.0)

    def error(self, at: Point) -> float:
        pressure, approach = self.physical(at.traction, at.rigid)
        shift = self.box.values(at.shift)[0] * self.displacement
        elastic = shift - self.problem.distance + approach[0]
        residual = normal_residual(self.problem, pressure, approach, elastic)
        _, relative_gap = normal_gap(self.problem, pressure, approach, elastic)
        return max(residual, relative_gap)

    def physical(self, traction: np.ndarray, rigid: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        pressure, approach = super().physical(traction, rigid)
        if self.problem.approach is not None:
            approach = np.array([self.problem.approach])
        return pressure[0], approach
