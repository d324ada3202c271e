"""Newton's method for pressure and tractions of unlike bodies together, without a matrix.

The fields are ``(p_z, p_t)``, pressure first, and their shifts ``E = (e, E_t)``, deformed distance and local shift.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from varcontact.discrete.problems import RawSolution
from varcontact.elasticity.operators import GridOperator
from varcontact.solvers.newton.kernel import kernel, unit, wrapped_transform
from varcontact.solvers.newton.krylov import Forces
from varcontact.solvers.newton.linearisation import TangentialConditions
from varcontact.solvers.newton.newton import newton, point
from varcontact.solvers.newton.normal import NormalConditions
from varcontact.solvers.newton.preconditioner import circulant
from varcontact.solvers.newton.safeguard import Point
from varcontact.solvers.newton.whole_linearisation import WholeConditions, WholeKernel, transform_lengths
from varcontact.solvers.settings import Settings

MOST_STEPS = 60
"""Newton steps: problems that take more are left to passes."""


@dataclass(frozen=True, eq=False)
class WholeProblem:
    """Find ``p_z >= 0``, ``|p_t| <= f p_z`` that press and rub each other, on all elements of a grid.

    Attributes
    ----------
    normal, traction_to_distance, pressure_to_shift, tangential : GridOperator
        The blocks zz, zt, tz and tt; c components t.
    distance : ndarray, shape (ny, nx)
        h, the undeformed distance.
    rigid_shift : ndarray, shape (c, ny, nx)
        W.
    friction : ndarray, shape (ny, nx)
        f, finite.
    area : float
        Of an element.
    approach : float or None
        Prescribed, or unknown.
    force : tuple of 1 + c (float or None)
        Prescribed ``area * sum(p)`` by field, the normal one where the approach is not.
    """

    normal: GridOperator
    traction_to_distance: GridOperator
    pressure_to_shift: GridOperator
    tangential: GridOperator
    distance: np.ndarray
    rigid_shift: np.ndarray
    friction: np.ndarray
    area: float
    approach: float | None
    force: tuple[float | None, ...]

    def shift(self, traction: np.ndarray) -> np.ndarray:
        """The shifts E without the unknown rigid ones, in double precision.

        Parameters
        ----------
        traction : ndarray, shape (1 + c, ny, nx)

        Returns
        -------
        ndarray, shape (1 + c, ny, nx)
        """
        pressure, rubbing = traction[:1], traction[1:]
        distance = self.normal.apply(pressure) + self.traction_to_distance.apply(rubbing)
        shift = self.pressure_to_shift.apply(pressure) + self.tangential.apply(rubbing)
        return np.concatenate([distance + self.distance - (self.approach or 0.0), shift + self.rigid_shift])


def newton_whole(
    problem: WholeProblem, settings: Settings, start: RawSolution, residual: Callable[[RawSolution], float]
) -> RawSolution:
    """Solve for pressure and tractions together by an inexact Newton method with products by FFT only.

    Parameters
    ----------
    problem : WholeProblem
    settings : Settings
    start : RawSolution
        Pressures that bear something, and tractions, (1 + c, ny, nx); less the approach, and rigid shifts, (1 + c,).
    residual : callable
        Of an answer.

    Returns
    -------
    RawSolution
        As the start. Where it is not "Solved" that is no more than a point on the way.
    """
    posed = _Posed.of(problem, start, residual)
    shapes = np.reshape(start.rigid, (-1, 1, 1)) / posed.displacement
    at = point(posed.conditions, start.traction / posed.load, shapes)
    result = newton(posed.conditions, at, settings.tol, settings, posed, MOST_STEPS)
    return posed.physical(result.at, result.steps, result.status)


@dataclass(frozen=True, eq=False)
class _Posed:
    """A problem in its own units: those of pressures and of tractions differ by friction."""

    problem: WholeProblem
    load: np.ndarray
    residual: Callable[[RawSolution], float]

    @classmethod
    def of(cls, problem: WholeProblem, start: RawSolution, residual: Callable[[RawSolution], float]) -> _Posed:
        pressure = float(start.traction[0].max())
        bound = float((problem.friction * start.traction[0]).max())
        load = np.full((len(start.traction), 1, 1), bound)
        load[0] = pressure
        return cls(problem, load, residual)

    @cached_property
    def displacement(self) -> np.ndarray:
        """The shifts that count as one."""
        units = np.full(self.load.shape, unit(self.problem.tangential))
        units[0] = unit(self.problem.normal)
        return units * self.load

    @cached_property
    def conditions(self) -> WholeConditions:
        problem, shape = self.problem, self.problem.distance.shape
        part = float(self.load[-1, 0, 0] / self.load[0, 0, 0])
        fields = problem.distance[None] - (problem.approach or 0.0), problem.rigid_shift
        known = np.concatenate(fields) / self.displacement
        free = [i for i, force in enumerate(problem.force) if force is not None]
        sums = [(problem.force[i] or 0.0) / (problem.area * self.load[i, 0, 0]) for i in free]
        weight = 1 / np.sqrt(problem.distance.size)

        def forces(wanted: list[int], first: int = 0) -> Forces:
            own = [i for i in free if i in wanted]
            return Forces(tuple(i - first for i in own), np.array([sums[free.index(i)] for i in own]), weight)

        tractions, nz, tt = list(range(1, len(self.load))), problem.normal, problem.tangential
        within = np.ones(shape, dtype=bool)
        return WholeConditions(
            WholeKernel(shape, _symbols(problem), part),
            NormalConditions(kernel(nz, shape), circulant(nz, shape), known[:1], within, forces([0])),
            TangentialConditions(
                kernel(tt, shape), circulant(tt, shape), known[1:], within * 0.0, forces(tractions, 1)
            ),
            problem.friction / part,
            forces([0, *tractions]),
        )

    def shift(self, traction: np.ndarray, rigid: np.ndarray) -> np.ndarray:
        """E, in double precision."""
        return self.problem.shift(traction * self.load) / self.displacement + rigid

    def error(self, at: Point) -> float:
        """The residual of an answer."""
        return self.residual(self.physical(at, 0, ""))

    def physical(self, at: Point, steps: int, status: str) -> RawSolution:
        """Tractions and rigid shifts as the problem has them."""
        rigid = (at.rigid * self.displacement).ravel()
        return RawSolution(at.traction * self.load, rigid, steps, status, status == "Solved")


def _symbols(problem: WholeProblem) -> np.ndarray:
    """Transforms of all blocks in their units; remembered by the block that only unlike bodies have."""
    blocks = problem.normal, problem.traction_to_distance, problem.tangential
    keeper = problem.pressure_to_shift.__dict__
    known, symbols = keeper.get("_symbols", ((), None))
    if symbols is None or any(one is not other for one, other in zip(known, blocks, strict=True)):
        symbols = _transformed(problem)
        keeper["_symbols"] = blocks, symbols
    return np.asarray(symbols)


def _transformed(problem: WholeProblem) -> np.ndarray:
    across, along = unit(problem.normal), unit(problem.tangential)
    top = np.concatenate([problem.normal.table, problem.traction_to_distance.table], axis=1) / across
    below = np.concatenate([problem.pressure_to_shift.table, problem.tangential.table], axis=1) / along
    table = np.concatenate([top, below]).astype(np.float32)
    flat = table.reshape(-1, *table.shape[2:])
    symbols = wrapped_transform(flat, transform_lengths(problem.distance.shape))
    return symbols.reshape(*table.shape[:2], *symbols.shape[1:])
