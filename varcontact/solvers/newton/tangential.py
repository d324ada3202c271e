"""Newton's method for the tangential problem, without a matrix: from coarse grids to the finest."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from varcontact.discrete.problems import RawSolution, TangentialProblem
from varcontact.discrete.residuals import gap, project, tangential_residual
from varcontact.elasticity.operators import RestrictedOperator
from varcontact.solvers.active_set.tang import tang_safeguarded
from varcontact.solvers.newton.drive import COARSE_TOL, check_start, driven, not_a_number
from varcontact.solvers.newton.kernel import SoftenedKernel, kernel, softened, unit
from varcontact.solvers.newton.krylov import Forces
from varcontact.solvers.newton.levels import Box, doubled, halved, halved_mean, halvings, has_coarser, parts
from varcontact.solvers.newton.linearisation import TangentialConditions
from varcontact.solvers.newton.newton import EXACT, MAX_STEPS, newton, point
from varcontact.solvers.newton.preconditioner import circulant
from varcontact.solvers.newton.safeguard import Point
from varcontact.solvers.settings import Settings

PATIENCE = 40
"""Steps after which active sets take over where they can: it takes 10 to 30, but for steps of rolling below dx/20."""
EXTRAPOLATED = 0.3
"""Part of the last change by a finer grid that is added when going to the next."""


def newton_tangential(problem: TangentialProblem, settings: Settings, start: RawSolution | None = None) -> RawSolution:
    """Solve the tangential problem by an inexact Newton method with products by FFT only.

    Memory is linear in the number of elements, and so, but for a small power, is the time.

    Parameters
    ----------
    problem : TangentialProblem
    settings : Settings
        Its `tol` is reached by the residual and by the relative gap.
    start : RawSolution, optional
        Where to begin in place of a sequence of coarser grids.

    Returns
    -------
    RawSolution
        `iterations` counts Newton steps on all grids. `status` is "Solved", "MaxIterations" or "NotANumber". Where
        Newton's method ends short of the tolerance, and elements are few enough, it is the answer of the safeguarded
        TANG, as `solver` and `reason` say.

    Raises
    ------
    SceneError
        For a start of another problem.
    """
    assert type(problem.operator) is RestrictedOperator, "a table by offset has no half problems"
    check_start(start, problem.rigid_shift.shape, (problem.components,))
    if not np.isfinite(problem.rigid_shift).all() or np.isnan(problem.bound).any():
        return not_a_number(problem.rigid_shift.shape, problem.components)
    posed = _Posed.of(problem, settings)
    if posed is None:
        return RawSolution(np.zeros_like(problem.rigid_shift), np.zeros(problem.components), 0, "Solved")

    def residual(raw: RawSolution) -> float:
        return tangential_residual(problem, raw.traction, raw.rigid)

    def dense(near: RawSolution) -> RawSolution:
        with settings.stats.called("tang-safeguarded"):
            raw = tang_safeguarded(problem, settings=settings)
            settings.stats.iterated("tang-safeguarded", raw.iterations)
        return replace(raw, solver="tang-safeguarded")

    return driven(posed, start, settings, problem.size, dense, residual, PATIENCE)


@dataclass(frozen=True, eq=False)
class _Posed:
    """A tangential problem in its own units.

    Attributes
    ----------
    problem : TangentialProblem
    box : Box
    load : float
        The traction that counts as one.
    settings : Settings
        Of the solve.
    """

    problem: TangentialProblem
    box: Box
    load: float
    settings: Settings

    @classmethod
    def of(cls, problem: TangentialProblem, settings: Settings) -> _Posed | None:
        """None where nothing moves, and no traction arises."""
        if problem.size == 0:
            return None
        forces = [abs(F) / (problem.area * problem.size) for F in problem.force if F is not None]
        moved = max(float(np.abs(problem.rigid_shift).max()) / unit(problem.operator.grid_operator), *forces, 0.0)
        if moved == 0:
            return None
        return cls(problem, Box.around(problem.operator), min(moved, float(problem.bound.max())), settings)

    @property
    def displacement(self) -> float:
        """The shift that counts as one."""
        return unit(self.problem.operator.grid_operator) * self.load

    @cached_property
    def conditions(self) -> TangentialConditions:
        """The problem on its box."""
        operator, shape = self.problem.operator.grid_operator, self.box.shape
        bound = self.box.field(self.problem.bound) / self.load
        known = self.box.field(self.problem.rigid_shift) / self.displacement
        sums = np.array([F for F in self.problem.force if F is not None]) / (self.problem.area * self.load)
        forces = Forces(tuple(self.problem.free), sums, 1 / np.sqrt(self.problem.size))
        own = self.problem.operator.softening
        soft = softened(kernel(operator, shape), None if own is None else self.box.field(own) / unit(operator))
        return _scaled(TangentialConditions(soft, circulant(operator, shape), known, bound, forces))

    def coarser(self, fine: TangentialConditions) -> TangentialConditions:
        """The problem with elements twice as large, in units of displacement that are so, too.

        In rolling a step becomes twice as long with the elements, and so does the rigid shift in it.
        """
        known = halved_mean(fine.known / fine.scale, fine.contact) * (1.0 if fine.circulant.rolling else 0.5)
        each = parts(fine.bound.shape)
        bound = halved(fine.bound * fine.scale) / each
        forces = Forces(fine.forces.components, fine.forces.sums / each, 1 / np.sqrt(np.count_nonzero(bound)))
        operator, shape = self.problem.operator.grid_operator, bound.shape
        times = halvings(self.box.shape, shape)
        own = fine.kernel.softening if isinstance(fine.kernel, SoftenedKernel) else None
        soft = softened(kernel(operator, shape, times), None if own is None else halved_mean(own, fine.contact))
        return _scaled(TangentialConditions(soft, circulant(operator, shape, times), known, bound, forces))

    def begun(self, start: RawSolution) -> Point:
        """From given tractions, which may be near the solution: their shift is in double precision."""
        traction = self.box.field(project(start.traction, self.problem.bound)) / (self.load * self.conditions.scale)
        rigid = np.reshape(start.rigid, (-1, 1, 1)) / self.displacement
        return Point(traction, self.shift(traction, rigid), rigid, EXACT)

    def approached(self) -> tuple[Point, int]:
        """From coarser grids, the coarsest begun without traction; also the Newton steps taken there."""
        grids = [self.conditions]
        while has_coarser(grids[-1].bound.shape) and np.isfinite(self.problem.bound).all():
            grids.append(self.coarser(grids[-1]))
        coarse = grids.pop()
        at, steps, expected = point(coarse, np.zeros_like(coarse.known), np.zeros((len(coarse.known), 1, 1))), 0, None
        while grids:
            fine = grids.pop()
            result = newton(coarse, at, COARSE_TOL, self.settings)
            part = result.at.traction / np.where(coarse.contact, coarse.bound, 1.0)
            if expected is not None:
                part += EXTRAPOLATED * (part - expected)
            expected = doubled(part, coarse.contact, fine.bound.shape)
            rigid = result.at.rigid * (1.0 if fine.circulant.rolling else 2.0)
            at = point(fine, fine.projected(expected * fine.bound), rigid)
            coarse, steps = fine, steps + result.steps
        return at, steps

    def solved(self, at: Point, tol: float, most: int = MAX_STEPS) -> RawSolution:
        """By Newton's method on the problem itself."""
        result = newton(self.conditions, at, tol, self.settings, self, most)
        traction, rigid = self._physical(result.at.traction, result.at.rigid)
        return RawSolution(traction, rigid, result.steps, result.status, result.status == "Solved")

    def shift(self, traction: np.ndarray, rigid: np.ndarray) -> np.ndarray:
        """E on the box, in double precision."""
        shift = self.box.field(self.problem.shift(*self._physical(traction, rigid))) / self.displacement
        return shift * self.conditions.scale

    def error(self, at: Point) -> float:
        """The residual or the relative gap of an answer, the larger."""
        traction, rigid = self._physical(at.traction, at.rigid)
        shift = self.box.values(at.shift / self.conditions.scale) * self.displacement
        residual = tangential_residual(self.problem, traction, rigid, shift)
        if self.problem.no_slip:
            return residual
        return max(residual, gap(self.problem, traction, rigid, shift)[1])

    def _physical(self, traction: np.ndarray, rigid: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Tractions and rigid shifts as the problem has them."""
        return self.box.values(traction * self.conditions.scale) * self.load, rigid.ravel() * self.displacement


def _scaled(conditions: TangentialConditions) -> TangentialConditions:
    """The same conditions with tractions and displacements as softened elements count them."""
    if not isinstance(conditions.kernel, SoftenedKernel):
        return conditions
    scale = conditions.kernel.scale.astype(float)
    return replace(
        conditions,
        known=conditions.known * scale,
        bound=conditions.bound / scale,
        forces=replace(conditions.forces, scale=scale),
    )
