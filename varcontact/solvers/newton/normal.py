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
from varcontact.solvers.active_set.norm import norm
from varcontact.solvers.interface import Settings, counted
from varcontact.solvers.newton.driver import GridConditions, GridProblem, point, solve
from varcontact.solvers.newton.gcr import Forces
from varcontact.solvers.newton.globalisation import Point
from varcontact.solvers.newton.hierarchy import Box
from varcontact.solvers.newton.kernel import product_and_plain, unit
from varcontact.solvers.newton.tangential import TangentialSystem


def newton_normal(
    problem: NormalProblem, settings: Settings, start: RawSolution | None = None
) -> RawSolution:
    apart = RawSolution(
        np.zeros_like(problem.distance), np.array([problem.approach or 0.0]), 0, "Solved"
    )
    if not np.isfinite(problem.distance).all():
        return replace(apart, status="NotANumber", solved=False)
    scaled = ScaledNormal.of(problem)
    if scaled is None:
        return apart
    return solve(scaled, start, settings, counted("norm", _active_sets))


def _active_sets(problem: NormalProblem, settings: Settings, near: RawSolution) -> RawSolution:
    """NORM from what Newton's method has; one element at a time where that cycles."""
    raw = norm(problem, near, deadline=settings.deadline)
    return raw if raw.solved else norm(problem, exchange="one", deadline=settings.deadline)


@dataclass(frozen=True, eq=False)
class NormalConditions(GridConditions):
    """The normal problem on a box: `known` is h, less the approach where that is given (1, ny, nx).

    Kernels of viscoelastic bodies are as skew as those of a step of rolling; their relaxation
    length stays as it is.
    """

    @property
    def of_step(self) -> bool:
        return False

    def projected(self, trial: np.ndarray) -> np.ndarray:
        return np.maximum(trial, 0.0) * self.contact

    def admissible(self, traction: np.ndarray, trial: np.ndarray) -> np.ndarray:
        """Positive only where the natural map has contact."""
        return np.where(trial > 0, np.maximum(traction, 0.0), 0.0)

    def linearised(
        self, traction: np.ndarray, shift: np.ndarray, trial: np.ndarray
    ) -> TangentialSystem:
        """As of tractions that stick in contact, and elsewhere slip without a bound."""
        contact = (trial > 0) & self.contact
        right = np.where(contact, -shift, -traction)
        return TangentialSystem(
            right, self, contact[0], 1.0 * ~contact, np.zeros(trial.shape), np.ones(trial[0].shape)
        )

    def first(self) -> Point:
        """Without pressures; where a force is given, so near that all elements overlap."""
        level = -self.known.max() - 1 if self.forces.components else 0.0
        return point(self, np.zeros_like(self.known), np.full((1, 1, 1), level))


@dataclass(frozen=True, eq=False)
class ScaledNormal(GridProblem[NormalConditions]):
    """A normal problem in its own units; the rigid shift is minus an unknown approach."""

    problem: NormalProblem

    @classmethod
    def of(cls, problem: NormalProblem) -> ScaledNormal | None:
        """None where nothing touches."""
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
        box, displacement = Box.around(problem.operator), own * load
        known = box.field((problem.distance[None] - (problem.approach or 0.0)) / displacement)
        sums = np.array([] if problem.force is None else [problem.force / (problem.area * load)])
        forces = Forces((0,) if sums.size else (), sums, 1 / np.sqrt(size))
        product, plain = product_and_plain(problem.operator, box.shape)
        conditions = NormalConditions(product, known, forces, box.field(np.ones(size)), plain)
        return cls(conditions, problem, box, load, displacement, sign=-1.0)

    def error(self, at: Point) -> float:
        pressure, approach = self.physical(at.traction, at.rigid)
        elastic = (
            self.box.values(at.shift)[0] * self.displacement - self.problem.distance + approach[0]
        )
        residual = normal_residual(self.problem, pressure, approach, elastic)
        return max(residual, normal_gap(self.problem, pressure, approach, elastic)[1])

    def physical(self, traction: np.ndarray, rigid: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        pressure, approach = super().physical(traction, rigid)
        given = self.problem.approach
        return pressure[0], approach if given is None else np.array([given])
