"""Newton's method for the normal problem, without a matrix.

With ``y = p - E``, E the deformed distance, the solution is ``p = max(y, 0)``. Where y is positive there is contact,
and Newton's equation is ``A d = -E``; elsewhere it is ``d = -p``.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from varcontact.discrete.problems import NormalProblem, RawSolution
from varcontact.discrete.residuals import normal_gap, normal_residual
from varcontact.solvers.active_set.norm import norm
from varcontact.solvers.interface import Settings
from varcontact.solvers.newton.driver import EXACT, GridProblem, point, solve
from varcontact.solvers.newton.gcr import Forces, System
from varcontact.solvers.newton.globalisation import Conditions, Point
from varcontact.solvers.newton.hierarchy import Box, doubled, halved, halved_mean, has_coarser, parts
from varcontact.solvers.newton.kernel import CurvedKernel, Kernel, kernel_on, unit

FIRST = 0.1
"""First pressure where the approach is given: this part of the overlap divided by an element's own influence."""


def newton_normal(problem: NormalProblem, settings: Settings, start: RawSolution | None = None) -> RawSolution:
    if not np.isfinite(problem.distance).all():
        return RawSolution(np.zeros(problem.distance.shape), np.zeros(1), 0, "NotANumber", False)
    scaled = ScaledNormal.of(problem, settings)
    if scaled is None:
        return RawSolution(np.zeros_like(problem.distance), np.array([problem.approach or 0.0]), 0, "Solved")
    return solve(scaled, start, settings)


@dataclass(frozen=True, eq=False)
class NormalConditions(Conditions):
    """The normal problem on a box: `known` is h, less the approach where that is given (1, ny, nx)."""

    kernel: Kernel | CurvedKernel
    within: np.ndarray

    def projected(self, trial: np.ndarray) -> np.ndarray:
        return np.maximum(trial, 0.0) * self.within

    def admissible(self, traction: np.ndarray, trial: np.ndarray) -> np.ndarray:
        """Positive only where the natural map has contact."""
        return np.where(trial > 0, np.maximum(traction, 0.0), 0.0)

    def linearised(self, traction: np.ndarray, shift: np.ndarray, trial: np.ndarray, damping: float) -> NormalSystem:
        contact = (trial[0] > 0) & self.within
        inside = contact.astype(np.float32)
        return NormalSystem(np.where(contact, -shift, -traction), self, inside, 1 - inside, damping)


@dataclass(frozen=True, eq=False)
class NormalSystem(System):
    """Newton's equations on a contact area: ones `inside` it (ny, nx), and ones `outside`."""

    conditions: NormalConditions
    inside: np.ndarray
    outside: np.ndarray
    damping: float

    def rows(self, image: np.ndarray, step: np.ndarray) -> np.ndarray:
        if self.damping:
            image = image + np.float32(self.damping) * step
        return self.inside * image + self.outside * step

    def border(self, component: int) -> np.ndarray:
        return self.inside[None].copy()

    def precondition(self, right: np.ndarray) -> np.ndarray:
        """The inverse of the circulant in the contact."""
        circulant = self.conditions.kernel.circulant
        found = circulant.apply(circulant.normal[:, None], (self.inside * right)[:, None])
        return self.inside * found[:, 0] + self.outside * right


@dataclass(frozen=True, eq=False)
class ScaledNormal(GridProblem[NormalConditions]):
    """A normal problem in its own units."""

    problem: NormalProblem

    @classmethod
    def of(cls, problem: NormalProblem, settings: Settings) -> ScaledNormal | None:
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
        within = box.field(np.ones(size, dtype=bool))
        sums = np.array([] if problem.force is None else [problem.force / (problem.area * load)])
        forces = Forces((0,) if sums.size else (), sums, 1 / np.sqrt(size))
        conditions = NormalConditions(kernel_on(problem.operator, box.shape), known, forces, within)
        return cls(conditions, box, load, displacement, settings, problem)

    def coarser(self, fine: NormalConditions) -> NormalConditions | None:
        """With elements twice as large, in units of displacement that are so, too."""
        if not has_coarser(fine.within.shape):
            return None
        known, within = halved_mean(fine.known, fine.within) / 2, halved(fine.within.astype(float)) > 0
        sums = fine.forces.sums / parts(fine.within.shape)
        forces = Forces(fine.forces.components, sums, 1 / np.sqrt(np.count_nonzero(within)))
        return NormalConditions(fine.kernel.halved, known, forces, within)

    def first(self, coarsest: NormalConditions) -> Point:
        """From the overlap, or from an even pressure that has the force."""
        level = np.zeros((1, 1, 1))
        if not coarsest.forces.components:
            return point(coarsest, coarsest.projected(-FIRST * coarsest.known), level)
        pressure = coarsest.within[None] * (coarsest.forces.sums[0] / np.count_nonzero(coarsest.within))
        distance = point(coarsest, pressure, level).shift[0]
        return point(coarsest, pressure, np.full((1, 1, 1), -distance[coarsest.within].mean()))

    def finer(self, at: Point, coarse: NormalConditions, fine: NormalConditions) -> Point:
        pressure = doubled(at.traction, coarse.within, fine.within.shape)
        return point(fine, fine.projected(pressure), 2.0 * at.rigid)

    def initial_guess(self, start: RawSolution) -> Point:
        """From given pressures, which may be near the solution: their distance is in double precision."""
        rigid = -start.rigid / self.displacement if self.problem.approach is None else np.zeros(1)
        pressure = self.box.field(np.maximum(start.traction, 0.0)[None]) / self.load
        rigid = rigid.reshape(1, 1, 1)
        return Point(pressure, self.shift(pressure, rigid), rigid, EXACT)

    def shift(self, traction: np.ndarray, rigid: np.ndarray) -> np.ndarray:
        pressure, approach = self.physical(traction, rigid)
        distance = self.problem.distance - approach[0] + self.problem.operator.apply(pressure[None])[0]
        return self.box.field(distance[None]) / self.displacement

    def error(self, at: Point) -> float:
        pressure, approach = self.physical(at.traction, at.rigid)
        elastic = self.box.values(at.shift)[0] * self.displacement - self.problem.distance + approach[0]
        residual = normal_residual(self.problem, pressure, approach, elastic)
        return max(residual, normal_gap(self.problem, pressure, approach, elastic)[1])

    def physical(self, traction: np.ndarray, rigid: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        approach = -rigid.ravel() * self.displacement
        if self.problem.approach is not None:
            approach = np.array([self.problem.approach])
        return self.box.values(traction)[0] * self.load, approach

    def residual(self, raw: RawSolution) -> float:
        return normal_residual(self.problem, raw.traction, raw.rigid)

    def by_active_sets(self, near: RawSolution) -> RawSolution:
        """NORM from what Newton's method has; one element at a time where that cycles."""
        deadline, stats = self.settings.deadline, self.settings.stats
        with stats.called("norm"):
            raw = norm(self.problem, near, deadline=deadline)
            raw = raw if raw.solved else norm(self.problem, exchange="one", deadline=deadline)
            stats.iterated("norm", raw.iterations)
        return replace(raw, solver="norm")
