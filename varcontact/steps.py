"""The two steps of every solution: the pressure for given tractions, the tractions for a given pressure."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import TypeVar

import numpy as np

from varcontact import memory
from varcontact.active_set.norm import norm
from varcontact.active_set.tang import no_slip, tang_safeguarded
from varcontact.clock import Clock
from varcontact.conic.clarabel import solve_normal, solve_tangential
from varcontact.coupling import ContactState
from varcontact.energy import normal_residual, project, tangential_residual
from varcontact.errors import Saturated
from varcontact.grid import Grid
from varcontact.plan import Plan
from varcontact.problem import Discretisation, NormalProblem, RawSolution, Settings, TangentialProblem, out_of_reach

NORMAL_SOLVERS: dict[str, Callable[[NormalProblem, Settings], RawSolution]] = {"clarabel": solve_normal}
TANGENTIAL_SOLVERS: dict[str, Callable[[TangentialProblem, Settings], RawSolution]] = {"clarabel": solve_tangential}

_Problem = TypeVar("_Problem", NormalProblem, TangentialProblem)


def unloaded(grid: Grid) -> ContactState:
    """Bodies without pressure or traction."""
    return ContactState(np.zeros(grid.shape), 0.0, np.zeros((2, *grid.shape)), np.zeros(2))


@dataclass(frozen=True)
class Steps:
    """The methods of a plan, each a step from one contact state to the next.

    Attributes
    ----------
    plan : Plan
    tol : float
        Natural-map residual to reach.
    polish : bool
        Whether solvers' answers are taken to rounding.
    clock : Clock
    """

    plan: Plan
    tol: float
    polish: bool
    clock: Clock

    def pressure(self, disc: Discretisation, state: ContactState) -> ContactState:
        """The state with the pressure that goes with its tractions."""
        with self.clock("normal"):
            if self.plan.normal == "hertz":
                return hertz_pressure(disc, state)
            coupled = disc.scene.bodies.K != 0 and np.any(state.traction)
            problem = disc.normal_problem(state.traction if coupled else None).reachable()
            elements = problem.operator.elements
            if elements.size == 0:
                raise out_of_reach(disc.scene, disc.grid)
            memory.need("the normal QP", 120.0 * elements.size**2, "a grid with fewer elements would fit")
            start = None
            if np.any(state.pressure):
                start = RawSolution(state.pressure.ravel()[elements], np.array([state.approach]), 0, "start")
            raw = self._finish(problem, NORMAL_SOLVERS[self.plan.normal], norm, normal_residual, start)
            pressure = np.zeros(disc.grid.nx * disc.grid.ny)
            pressure[elements] = raw.traction
            return replace(
                state,
                pressure=pressure.reshape(disc.grid.shape),
                approach=float(raw.rigid[0]),
                iterations=_counted(state, "normal", raw.iterations),
            )

    def traction(self, disc: Discretisation, state: ContactState) -> ContactState:
        """The state with the tractions that go with its pressure."""
        with self.clock("tangential"):
            problem = disc.tangential_problem(state.pressure)
            _check_force(problem, disc.force)
            raw = self._tractions(problem, state)
            traction = np.zeros((2, disc.grid.nx * disc.grid.ny))
            traction[:, problem.operator.elements] = raw.traction
            return replace(
                state,
                traction=traction.reshape(2, *disc.grid.shape),
                rigid=raw.rigid,
                iterations=_counted(state, "tangential", raw.iterations),
            )

    def _tractions(self, problem: TangentialProblem, state: ContactState) -> RawSolution:
        if problem.size == 0 or not (np.any(problem.rigid_shift) or any(problem.force)):
            return RawSolution(np.zeros((2, problem.size)), np.zeros(2), 0, "nothing moves")
        memory.need("the tangential SOCP", 30 * 8 * 4.0 * problem.size**2, "a grid with fewer elements would fit")
        sticking = no_slip(problem)
        if np.all(np.hypot(*sticking.traction) <= problem.bound):
            return sticking  # friction is nowhere exhausted: the linear solution is the solution
        if not problem.monotone:  # no convex program: what finds a solution is tried, the certificate judges it
            return tang_safeguarded(problem)
        start = None
        if np.any(state.traction):
            known = state.traction.reshape(2, -1)[:, problem.operator.elements]
            start = RawSolution(project(known, problem.bound), state.rigid, 0, "start")
        solver = TANGENTIAL_SOLVERS[self.plan.tangential]
        return self._finish(problem, solver, tang_safeguarded, tangential_residual, start)

    def _finish(
        self,
        problem: _Problem,
        solver: Callable[[_Problem, Settings], RawSolution],
        polish: Callable[[_Problem, RawSolution], RawSolution],
        residual: Callable[[_Problem, np.ndarray, np.ndarray], float],
        start: RawSolution | None,
    ) -> RawSolution:
        """A solver's answer, polished: the solver is asked for no more than the polish needs to succeed.

        Where the polish takes a start (the pass before) to the tolerance, no solver is needed at all.
        """
        if not self.polish:
            return solver(problem, Settings(tol=1e-12))
        enough = min(self.tol, 1e-9)
        best = None if start is None else replace(polish(problem, start), iterations=0)
        for asked in (1e-3, 1e-6, 1e-9):
            if best is not None and residual(problem, best.traction, best.rigid) <= enough:
                break
            answer = solver(problem, Settings(tol=asked))
            raw = replace(polish(problem, answer), iterations=answer.iterations)
            if best is None or residual(problem, raw.traction, raw.rigid) < residual(
                problem, best.traction, best.rigid
            ):
                best = raw
        assert best is not None
        return best


def hertz_pressure(disc: Discretisation, state: ContactState) -> ContactState:
    """The state with Hertz's pressure: his values at the element centres, scaled to carry exactly his force."""
    assert disc.hertz is not None
    pressure = disc.hertz.pressure(disc.grid.x[None, :], disc.grid.y[:, None])
    if not pressure.any():
        raise out_of_reach(disc.scene, disc.grid)
    pressure *= disc.hertz.force / (pressure.sum() * disc.grid.area)
    approach = (disc.hertz.approach - disc.base) / disc.displacement
    return replace(state, pressure=pressure / disc.pressure, approach=approach)


def _check_force(problem: TangentialProblem, scale: float) -> None:
    """Refuse forces that friction cannot carry."""
    size = float(np.hypot(problem.force[0] or 0.0, problem.force[1] or 0.0))
    limit = problem.area * float(problem.bound.sum())
    if size > 0 and size >= limit:
        raise Saturated(size * scale, limit * scale)


def _counted(state: ContactState, problem: str, iterations: int) -> dict[str, int]:
    return {**state.iterations, problem: state.iterations.get(problem, 0) + iterations}
