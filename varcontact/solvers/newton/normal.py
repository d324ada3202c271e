"""Newton's method for the normal problem, without a matrix.

With ``y = p - E``, E the deformed distance, the solution is ``p = max(y, 0)``. Where y is positive there is contact,
and Newton's equation is ``A d = -E``; elsewhere it is ``d = -p``.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from varcontact.discrete.problems import NormalProblem, RawSolution
from varcontact.discrete.residuals import normal_gap, normal_residual
from varcontact.solvers.active_set.norm import norm
from varcontact.solvers.newton.drive import COARSE_TOL, check_start, driven, not_a_number
from varcontact.solvers.newton.kernel import Kernel, kernel, unit
from varcontact.solvers.newton.krylov import Forces, Step
from varcontact.solvers.newton.levels import Box, doubled, halved, halved_mean, halvings, has_coarser, parts
from varcontact.solvers.newton.newton import EXACT, MAX_STEPS, newton, point
from varcontact.solvers.newton.preconditioner import Circulant, circulant
from varcontact.solvers.newton.safeguard import Point
from varcontact.solvers.settings import Settings

FIRST = 0.1
"""Part of the overlap, by an element's own influence, that is the first pressure where the approach is given."""


def newton_normal(problem: NormalProblem, settings: Settings, start: RawSolution | None = None) -> RawSolution:
    """Solve the normal problem by an inexact Newton method with products by FFT only.

    Parameters
    ----------
    problem : NormalProblem
    settings : Settings
        Its `tol` is reached by the residual and by the relative gap.
    start : RawSolution, optional
        Where to begin in place of a sequence of coarser grids.

    Returns
    -------
    RawSolution
        `iterations` counts Newton steps on all grids. `status` is "Solved", "MaxIterations" or "NotANumber". Where
        Newton's method ends short of the tolerance, and elements are few enough, it is the answer of NORM, as `solver`
        and `reason` say.

    Raises
    ------
    SceneError
        For a start of another problem.
    """
    check_start(start, problem.distance.shape, (1,))
    if not np.isfinite(problem.distance).all():
        return not_a_number(problem.distance.shape, 1)
    posed = _Posed.of(problem, settings)
    if posed is None:
        return RawSolution(np.zeros_like(problem.distance), np.array([problem.approach or 0.0]), 0, "Solved")

    def dense(near: RawSolution) -> RawSolution:
        with settings.stats.called("norm"):
            raw = norm(problem, near, deadline=settings.deadline)
            raw = raw if raw.solved else norm(problem, exchange="one", deadline=settings.deadline)
            settings.stats.iterated("norm", raw.iterations)
        return replace(raw, solver="norm")

    def residual(raw: RawSolution) -> float:
        return normal_residual(problem, raw.traction, raw.rigid)

    return driven(posed, start, settings, problem.distance.size, dense, residual)


@dataclass(frozen=True, eq=False)
class NormalConditions:
    """The normal problem on a box, dimensionless.

    Attributes
    ----------
    kernel : Kernel
    circulant : Circulant
    known : ndarray, shape (1, ny, nx)
        h, the undeformed distance; less the approach where that is given.
    within : bool ndarray, shape (ny, nx)
        The elements of the problem.
    forces : Forces
    """

    kernel: Kernel
    circulant: Circulant
    known: np.ndarray
    within: np.ndarray
    forces: Forces

    @property
    def linear(self) -> bool:
        """Contact is never known beforehand."""
        return False

    def projected(self, trial: np.ndarray) -> np.ndarray:
        """The pressures of the natural map."""
        return np.maximum(trial, 0.0) * self.within

    def admissible(self, traction: np.ndarray, trial: np.ndarray) -> np.ndarray:
        """Pressures, positive only where the natural map has contact."""
        return np.where(trial > 0, np.maximum(traction, 0.0), 0.0)

    def work(self, trial: np.ndarray, change: np.ndarray) -> tuple[float, np.ndarray, np.ndarray]:
        """The work of the natural map's pressures after a change of the approach, with slope and curvature."""
        pressure = self.projected(trial - self.forces.spread(change, 1))
        work = 0.5 * float(np.sum(pressure**2)) + float(self.forces.sums @ change)
        curvature = np.full((len(change), len(change)), float(np.count_nonzero(pressure)))
        return work, self.forces.sums - self.forces.of(pressure), curvature

    def linearised(self, traction: np.ndarray, shift: np.ndarray, trial: np.ndarray, damping: float) -> NormalSystem:
        """Newton's equations, and their right-hand sides."""
        contact = (trial[0] > 0) & self.within
        return NormalSystem(self, np.where(contact, -shift, -traction), contact, damping)


@dataclass(frozen=True, eq=False)
class NormalSystem:
    """Newton's equations at given pressures.

    Attributes
    ----------
    conditions : NormalConditions
    right : ndarray, shape (1, ny, nx)
    contact : bool ndarray, shape (ny, nx)
    damping : float
        Added to A.
    """

    conditions: NormalConditions
    right: np.ndarray
    contact: np.ndarray
    damping: float

    @cached_property
    def _areas(self) -> tuple[np.ndarray, np.ndarray]:
        """Ones in the contact, and ones elsewhere."""
        inside = self.contact.astype(np.float32)
        return inside, 1 - inside

    def product(self, step: np.ndarray) -> np.ndarray:
        """A times a step."""
        return self.conditions.kernel(step)

    def rows(self, image: np.ndarray, step: np.ndarray) -> np.ndarray:
        """Left-hand sides for a step and A times the step."""
        inside, outside = self._areas
        if self.damping:
            image = image + np.float32(self.damping) * step
        return inside * image + outside * step

    def border(self, component: int) -> np.ndarray:
        """Left-hand sides for a change of the approach."""
        return self._areas[0][None].copy()

    def precondition(self, right: np.ndarray) -> np.ndarray:
        """The inverse of the circulant in the contact."""
        inside, outside = self._areas
        circulant = self.conditions.circulant
        found = circulant.apply(circulant.floored[:, None], (inside * right)[:, None])
        return inside * found[:, 0] + outside * right

    def bent(self, traction: np.ndarray, step: Step) -> Step:
        """The step itself: pressures do not turn."""
        return step


@dataclass(frozen=True, eq=False)
class _Posed:
    """A normal problem in its own units.

    Attributes
    ----------
    problem : NormalProblem
    box : Box
    load : float
        The pressure that counts as one.
    settings : Settings
        Of the solve.
    """

    problem: NormalProblem
    box: Box
    load: float
    settings: Settings

    @classmethod
    def of(cls, problem: NormalProblem, settings: Settings) -> _Posed | None:
        """None where nothing touches."""
        if problem.distance.size == 0:
            return None
        if problem.force is not None:
            load = problem.force / (problem.area * problem.distance.size)
        else:
            assert problem.approach is not None
            load = (problem.approach - float(problem.distance.min())) / unit(problem.operator.grid_operator)
        return None if load <= 0 else cls(problem, Box.around(problem.operator), load, settings)

    @property
    def displacement(self) -> float:
        """The distance that counts as one."""
        return unit(self.problem.operator.grid_operator) * self.load

    @cached_property
    def conditions(self) -> NormalConditions:
        """The problem on its box."""
        problem, box = self.problem, self.box
        operator, size = problem.operator.grid_operator, problem.distance.size
        known = box.field((problem.distance[None] - (problem.approach or 0.0)) / self.displacement)
        within = box.field(np.ones(size, dtype=bool))
        sums = np.array([] if problem.force is None else [problem.force / (problem.area * self.load)])
        forces = Forces((0,) if sums.size else (), sums, 1 / np.sqrt(size))
        return NormalConditions(kernel(operator, box.shape), circulant(operator, box.shape), known, within, forces)

    def coarser(self, fine: NormalConditions) -> NormalConditions:
        """The problem with elements twice as large, in units of displacement that are so, too."""
        known, within = halved_mean(fine.known, fine.within) / 2, halved(fine.within.astype(float)) > 0
        sums = fine.forces.sums / parts(fine.within.shape)
        forces = Forces(fine.forces.components, sums, 1 / np.sqrt(np.count_nonzero(within)))
        operator, shape = self.problem.operator.grid_operator, within.shape
        times = halvings(self.box.shape, shape)
        return NormalConditions(
            kernel(operator, shape, times), circulant(operator, shape, times), known, within, forces
        )

    def begun(self, start: RawSolution) -> Point:
        """From given pressures, which may be near the solution: their distance is in double precision."""
        rigid = -start.rigid / self.displacement if self.problem.approach is None else np.zeros(1)
        pressure = self.box.field(np.maximum(start.traction, 0.0)[None]) / self.load
        rigid = rigid.reshape(1, 1, 1)
        return Point(pressure, self.shift(pressure, rigid), rigid, EXACT)

    def approached(self) -> tuple[Point, int]:
        """From coarser grids; also the Newton steps taken there."""
        grids = [self.conditions]
        while has_coarser(grids[-1].within.shape):
            grids.append(self.coarser(grids[-1]))
        coarse = grids.pop()
        at, steps = _first(coarse), 0
        while grids:
            fine = grids.pop()
            result = newton(coarse, at, COARSE_TOL, self.settings)
            pressure = doubled(result.at.traction, coarse.within, fine.within.shape)
            at = point(fine, fine.projected(pressure), 2.0 * result.at.rigid)
            coarse, steps = fine, steps + result.steps
        return at, steps

    def solved(self, at: Point, tol: float, most: int = MAX_STEPS) -> RawSolution:
        """By Newton's method on the problem itself."""
        result = newton(self.conditions, at, tol, self.settings, self, most)
        pressure, approach = self._physical(result.at.traction, result.at.rigid)
        return RawSolution(pressure, approach, result.steps, result.status, result.status == "Solved")

    def shift(self, traction: np.ndarray, rigid: np.ndarray) -> np.ndarray:
        """The deformed distance on the box, in double precision."""
        pressure, approach = self._physical(traction, rigid)
        distance = self.problem.distance - approach[0] + self.problem.operator.apply(pressure[None])[0]
        return self.box.field(distance[None]) / self.displacement

    def error(self, at: Point) -> float:
        """The residual or the relative gap of an answer, the larger."""
        pressure, approach = self._physical(at.traction, at.rigid)
        elastic = self.box.values(at.shift)[0] * self.displacement - self.problem.distance + approach[0]
        residual = normal_residual(self.problem, pressure, approach, elastic)
        return max(residual, normal_gap(self.problem, pressure, approach, elastic)[1])

    def _physical(self, traction: np.ndarray, rigid: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Pressures and approach as the problem has them."""
        approach = -rigid.ravel() * self.displacement
        if self.problem.approach is not None:
            approach = np.array([self.problem.approach])
        return self.box.values(traction)[0] * self.load, approach


def _first(conditions: NormalConditions) -> Point:
    """Where the coarsest grid begins: from the overlap, or from an even pressure that has the force."""
    if not conditions.forces.components:
        pressure = conditions.projected(-FIRST * conditions.known)
        return point(conditions, pressure, np.zeros((1, 1, 1)))
    size = np.count_nonzero(conditions.within)
    pressure = conditions.within[None] * (conditions.forces.sums[0] / size)
    at = point(conditions, pressure, np.zeros((1, 1, 1)))
    return point(conditions, pressure, np.full((1, 1, 1), -at.shift[0][conditions.within].mean()))
