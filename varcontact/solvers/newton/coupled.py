"""Newton's method for pressure and tractions of unlike bodies together, without a matrix.

The fields are ``(p_z, p_t)``, pressure first, and their shifts
``E = (e, E_t)``, deformed distance and local shift. With ``y = p - E`` the
natural map is ``p_z = max(y_z, 0)``, ``p_t = Proj(y_t)`` on the disk of
``f max(y_z, 0)``: the traction bound is an unknown, too. Newton's equations are
those of the two problems, with all blocks of A, and with
``n.d_t - f d_z = f p_z - n.p_t`` where it slips. The preconditioner is that of
the pressures, then, with the bounds that go with these, that of the tractions.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from varcontact.discrete.problems import RawSolution
from varcontact.elasticity.operators import GridOperator
from varcontact.solvers.interface import Settings, SolveStats
from varcontact.solvers.newton.driver import Problem, ignored_point, point, solve_from
from varcontact.solvers.newton.gcr import Forces, System
from varcontact.solvers.newton.globalisation import Conditions, Point
from varcontact.solvers.newton.kernel import kernel, unit
from varcontact.solvers.newton.normal import NormalConditions
from varcontact.solvers.newton.tangential import TangentialConditions, TangentialSystem
from varcontact.system.process import changed, lazy_property

MAX_STEPS = 60
"""Largest number of Newton steps; harder problems are left to alternating solves."""


@dataclass(frozen=True, eq=False)
class CoupledProblem:
    """Find ``p_z >= 0``, ``|p_t| <= f p_z`` of bodies in contact with friction, on all elements of
    a grid.
    """

    operator: GridOperator  # displacements by tractions, (1 + c) of each, the normal ones first
    # of those, by pressures and by tangential tractions alone
    blocks: tuple[GridOperator, GridOperator]
    distance: np.ndarray  # (ny, nx) h, the undeformed distance
    rigid_shift: np.ndarray  # (c, ny, nx) W
    friction: np.ndarray  # (ny, nx) f, finite
    area: float  # of an element
    approach: float | None  # prescribed, or unknown
    # prescribed ``area * sum(p)`` by field, the normal one where the approach is not
    force: tuple[float | None, ...]
    # (1 + c, ny, nx) parts of the fields in the normal force, if not p_z alone
    in_normal_force: np.ndarray | None = None

    def shift(self, traction: np.ndarray) -> np.ndarray:
        """The shifts E (1 + c, ny, nx) without the unknown rigid ones, in double precision."""
        return self.operator.apply(traction) + self.known

    @lazy_property
    def known(self) -> np.ndarray:
        """The shifts (1 + c, ny, nx) without tractions and without the unknown rigid ones."""
        distance = self.distance - (self.approach or 0.0)
        return np.concatenate([distance[None], self.rigid_shift])


def newton_coupled(
    problem: CoupledProblem,
    settings: Settings,
    start: RawSolution,
    residual: Callable[[RawSolution], float],
) -> RawSolution:
    """Solve for pressure and tractions together by an inexact Newton method with products by FFT
    only.

    The start has pressures that carry a load, and tractions (1 + c, ny, nx); less the approach,
    and rigid shifts (1 + c,). So has the answer; where it is not "Solved" that is no more than a
    point on the way.
    """
    scaled = ScaledCoupled.of(problem, start, residual)
    rigid = np.reshape(start.rigid, (-1, 1, 1)) / scaled.displacement
    at = point(scaled.conditions, start.traction / scaled.load, rigid)
    return solve_from(scaled, at, settings.tol, settings, max_steps=MAX_STEPS)


@dataclass(frozen=True, eq=False)
class CoupledConditions(Conditions):
    """Conditions of both problems on a grid: the tangential bound is friction (ny, nx) times the
    unknown pressure.
    """

    normal: NormalConditions
    tangential: TangentialConditions
    friction: np.ndarray

    def under(self, pressure: np.ndarray) -> TangentialConditions:
        return changed(self.tangential, bound=self.friction * np.maximum(pressure, 0.0))

    def projected(self, trial: np.ndarray) -> np.ndarray:
        pressure = np.maximum(trial[:1], 0.0)
        return np.concatenate([pressure, self.under(trial[0]).projected(trial[1:])])

    def admissible(self, traction: np.ndarray, trial: np.ndarray) -> np.ndarray:
        """Pressures, positive only where the natural map has contact, and tractions within their
        bound.
        """
        pressure = self.normal.admissible(traction[:1], trial[:1])
        return np.concatenate([pressure, self.under(pressure[0]).projected(traction[1:])])

    def linearised(
        self, traction: np.ndarray, shift: np.ndarray, trial: np.ndarray
    ) -> CoupledSystem:
        normal = self.normal.linearised(traction[:1], shift[:1], trial[:1])
        under = self.under(trial[0])
        tangential = under.linearised(traction[1:], shift[1:], trial[1:])
        bound = self.friction * traction[0]
        # the bound of the pressure to be found
        right = tangential.right + (bound - under.bound) * tangential.along
        right = np.where(under.contact, right, -traction[1:])
        tied = (self.friction * tangential.along).astype(np.float32)
        return CoupledSystem(np.concatenate([normal.right, right]), normal, tangential, tied)


@dataclass(frozen=True, eq=False)
class CoupledSystem(System):
    """Newton's equations of both problems; `right` (1 + c, ny, nx).

    `tied`: the slip's direction times friction, which ties tractions to pressures, (c, ny, nx).
    """

    normal: TangentialSystem
    tangential: TangentialSystem
    tied: np.ndarray

    def rows(self, image: np.ndarray, step: np.ndarray) -> np.ndarray:
        normal = self.normal.rows(image[:1], step[:1])
        tangential = self.tangential.rows(image[1:], step[1:])
        return np.concatenate([normal, tangential - self.tied * step[0]])

    def border(self, component: int) -> np.ndarray:
        border = np.zeros(self.right.shape, np.float32)
        if component == 0:
            border[:1] = self.normal.border(0)
        else:
            border[1:] = self.tangential.border(component - 1)
        return border

    def precondition(self, right: np.ndarray) -> np.ndarray:
        """Step of the pressures, then that of the tractions under them."""
        pressure = self.normal.precondition(right[:1])
        tangential = self.tangential.precondition(right[1:] + self.tied * pressure[0])
        return np.concatenate([pressure, tangential])


@dataclass(frozen=True, eq=False)
class ScaledCoupled(Problem[CoupledConditions]):
    """A problem in its own units (1 + c, 1, 1): those of pressures and of tractions differ by
    friction.
    """

    problem: CoupledProblem
    load: np.ndarray
    displacement: np.ndarray
    residual: Callable[[RawSolution], float]

    @classmethod
    def of(
        cls, problem: CoupledProblem, start: RawSolution, residual: Callable[[RawSolution], float]
    ) -> ScaledCoupled:
        """The problem divided by the largest pressure, and the largest bound, of a start."""
        shape = problem.distance.shape
        # units of the fields
        bound = float((problem.friction * start.traction[0]).max())
        load = np.full((len(start.traction), 1, 1), bound)
        load[0] = float(start.traction[0].max())
        units = np.full(load.shape, unit(problem.blocks[1]))
        units[0] = unit(problem.blocks[0])
        displacement = units * load
        friction_unit = float(load[-1, 0, 0] / load[0, 0, 0])
        known = problem.known / displacement
        # prescribed forces: of all fields, of the pressures, of the tractions
        weight = 1 / np.sqrt(problem.distance.size)
        free = [i for i, force in enumerate(problem.force) if force is not None]
        sums = np.array([(problem.force[i] or 0.0) / (problem.area * load[i, 0, 0]) for i in free])
        shares = problem.in_normal_force
        if shares is not None:
            shares = shares * load / load[0]
        split = 1 if 0 in free else 0
        normal_forces = Forces(tuple(free[:split]), sums[:split], weight)
        tangential_forces = Forces(tuple(i - 1 for i in free[split:]), sums[split:], weight)
        # the two problems
        normal_kernel = kernel(problem.blocks[0], shape)
        tangential_kernel = kernel(problem.blocks[1], shape)
        normal = NormalConditions(
            normal_kernel, known[:1], normal_forces, np.ones(shape), normal_kernel
        )
        tangential = TangentialConditions(
            tangential_kernel, known[1:], tangential_forces, np.zeros(shape), tangential_kernel
        )
        conditions = CoupledConditions(
            kernel=CoupledKernel(problem.operator, units.astype(np.float32), friction_unit),
            known=known,
            forces=Forces(tuple(free), sums, weight, shares=shares),
            normal=normal,
            tangential=tangential,
            friction=problem.friction / friction_unit,
        )
        return cls(conditions, problem, load, displacement, residual)

    def shift(self, traction: np.ndarray, rigid: np.ndarray) -> np.ndarray:
        return self.problem.shift(traction * self.load) / self.displacement + rigid

    def error(self, at: Point) -> float:
        return self.residual(RawSolution(*self.physical(at.traction, at.rigid)))

    def follower(self, stats: SolveStats) -> Callable[[Point], None]:
        report = stats.reporter()
        if report is None:
            return ignored_point
        return lambda at: report(residual=self.error(at))

    def physical(self, traction: np.ndarray, rigid: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        return traction * self.load, (rigid * self.displacement).ravel()


@dataclass(frozen=True, eq=False)
class CoupledKernel:
    """The blocks of A as one operator, in the units (1 + c, 1, 1) of its rows.

    `load` is the traction that counts as one, divided by the pressure that does.
    """

    operator: GridOperator
    units: np.ndarray
    load: float

    def __call__(self, traction: np.ndarray) -> np.ndarray:
        """Displacements by tractions (1 + c, ny, nx), both float32."""
        scale = np.full(self.units.shape, self.load, np.float32)
        scale[0] = 1.0
        product: np.ndarray = self.operator.apply(traction * scale) / (self.units * scale)
        return product
