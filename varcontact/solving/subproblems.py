"""The two steps of every solution: the pressure for given tractions, the tractions for a given pressure."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from typing import TypeVar

import numpy as np

from varcontact.errors import NotConverged, Saturated, SceneError, TooLarge
from varcontact.planning import memory
from varcontact.planning.plan import Plan
from varcontact.problem.discretisation import Discretisation, out_of_reach
from varcontact.problem.gap import magnitude, normal_residual, project, residuals, tangential_residual
from varcontact.problem.mirror import mirror_of
from varcontact.problem.problem import NormalProblem, RawSolution, Settings, TangentialProblem
from varcontact.results.solution import Solution
from varcontact.scene.friction import Law
from varcontact.scene.grid import Grid
from varcontact.solvers.active_set.norm import norm
from varcontact.solvers.active_set.tang import no_slip, tang_safeguarded
from varcontact.solvers.conic.joint import solve_joint
from varcontact.solvers.conic.setups import Setups
from varcontact.solvers.marching import march
from varcontact.solvers.registry import MATRIX_FREE, normal_solver, states_programs, tangential_solver
from varcontact.solving.coupling import ContactState, alternating, joint, panagiotopoulos
from varcontact.solving.friction_loop import branch_of, under_law
from varcontact.solving.timing import Clock
from varcontact.theories.methods import THEORIES

UNPOLISHED = 1e-2
"""Part of the tolerance that is asked of a solver whose answer nothing improves."""

NEWTON_STEPS_FROM_START = 8
"""Newton steps of TANG from the pass or the step before, until it must have come nearer."""

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
        Whether the answers of solvers of programs are taken to rounding.
    clock : Clock
    setups : Setups, optional
        Where solvers keep their set-ups.
    start : str or Solution, optional
        Where the passes under a law of friction begin.
    """

    plan: Plan
    tol: float
    polish: bool
    clock: Clock
    setups: Setups | None = None
    start: str | Solution | None = None

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
            peak = memory.peak(self.plan.normal, self.plan.formulation, elements.size)
            memory.need("the normal problem", peak, "a grid with fewer elements would fit")
            start = None
            if np.any(state.pressure):
                start = RawSolution(state.pressure.ravel()[elements], np.array([state.approach]), 0, "start")
            raw = self._normal(problem, start)
            if not (np.isfinite(raw.traction).all() and np.isfinite(raw.rigid).all()):
                raise NotConverged(f"{self.plan.normal} gave no pressure, it says: {raw.status}", np.inf)
            pressure = np.zeros(disc.grid.size)
            pressure[elements] = raw.traction
            return replace(
                state,
                pressure=pressure.reshape(disc.grid.shape),
                approach=float(raw.rigid[0]),
                iterations=_counted(state, "normal", raw.iterations),
                status={**state.status, "normal": raw.status},
                solved={**state.solved, "normal": raw.solved},
            )

    def traction(self, disc: Discretisation, state: ContactState) -> ContactState:
        """The state with the tractions that go with its pressure."""
        with self.clock("tangential"):
            if self.plan.tangential in THEORIES:
                return THEORIES[self.plan.tangential](disc, state)
            problem = disc.tangential_problem(
                state.pressure, state.bearing, marching=self.plan.formulation == "marching"
            )
            _check_force(problem, disc.force)
            raw = self._tractions(problem, state)
            if not (np.isfinite(raw.traction).all() and np.isfinite(raw.rigid).all()):
                raise NotConverged(f"{self.plan.tangential} gave no tractions, it says: {raw.status}", np.inf)
            traction, rigid = problem.on_grid(raw.traction, raw.rigid)
            return replace(
                state,
                traction=traction,
                rigid=rigid,
                iterations=_counted(state, "tangential", raw.iterations),
                status={**state.status, "tangential": raw.status},
                solved={**state.solved, "tangential": raw.solved},
            )

    def together(self, disc: Discretisation, state: ContactState) -> ContactState:
        """The state with pressure and tractions of each other, under the traction bound of its `bearing`.

        One convex program for a shift, where the tangential solver takes programs, its answer polished; else the
        two problems in turn.
        """
        if self.plan.formulation == "complementary" and states_programs(self.plan.tangential):
            state = self._joint_program(disc, state)
            if not self.polish:
                return state
        enough = 0.01 * max(self.tol, state.passes[-1][1] if state.passes else 1.0)  # no more than the next pass sees
        return alternating(state, partial(self.pressure, disc), partial(self.traction, disc), tol=enough)

    def _joint_program(self, disc: Discretisation, state: ContactState) -> ContactState:
        assert state.bearing is not None
        nothing, shifted = unloaded(disc.grid), disc.pressure_to_shift.apply(state.bearing[None])
        normal = disc.normal_problem()  # the pressures are unknowns: tractions can arise wherever they shift particles
        tangential = disc.tangential_problem(nothing.pressure, state.bearing, acting=shifted)
        _check_force(tangential, disc.force)
        if tangential.size == 0:  # no friction where there is contact: no cones, and only the pressure is left
            return self.pressure(disc, self.traction(disc, state))
        size = normal.distance.size + tangential.rigid_shift.size
        peak = memory.peak(self.plan.tangential, "complementary", size)
        memory.need("the joint program", peak, "a grid with fewer elements would fit")
        asked = 1e-6 if self.polish else UNPOLISHED * self.tol
        with self.clock("joint"):
            bodies = disc.traction_to_distance.between((0,), tangential.directions)
            coupling = bodies.dense(normal.operator.elements, tangential.operator.elements)
            pressed, rubbed = solve_joint(self.plan.tangential, normal, tangential, coupling, self._settings(asked))
        traction, rigid = tangential.on_grid(rubbed.traction, rubbed.rigid)
        pressed = without_noise(disc.normal_problem(traction), pressed)
        if not (np.isfinite(traction).all() and np.isfinite(pressed.traction).all()):
            raise NotConverged(f"{self.plan.tangential} gave no tractions, it says: {rubbed.status}", np.inf)
        return replace(
            state,
            pressure=pressed.traction.reshape(disc.grid.shape),
            approach=float(pressed.rigid[0]),
            traction=traction,
            rigid=rigid,
            iterations=_counted(state, "tangential", rubbed.iterations),
            status={**state.status, "tangential": rubbed.status},
            solved={**state.solved, "tangential": rubbed.solved},
        )

    def _normal(self, problem: NormalProblem, start: RawSolution | None) -> RawSolution:
        solver = normal_solver(self.plan.normal)
        if not states_programs(self.plan.normal):
            return solver(problem, self._settings(self.tol), start)
        if self.polish:
            near = None if start is None else norm(problem, start)
            return self._polished(problem, solver, norm, normal_residual, start, near)
        return without_noise(problem, solver(problem, self._settings(UNPOLISHED * self.tol), start))

    def _tractions(self, problem: TangentialProblem, state: ContactState) -> RawSolution:
        if problem.size == 0 or not (np.any(problem.rigid_shift) or any(problem.force)):
            return RawSolution(np.zeros_like(problem.rigid_shift), np.zeros(problem.components), 0, "nothing moves")
        start = None
        if np.any(state.traction):
            known, rigid = problem.of_grid(state.traction, state.rigid)
            start = RawSolution(project(known, problem.bound), rigid, 0, "start")
        mirror = None if self.plan.tangential in MATRIX_FREE else mirror_of(problem)
        if mirror is None:
            return self._solved(problem, start)
        halved = None if start is None else mirror.fold_solution(start)
        return mirror.unfold(self._solved(mirror.fold(problem), halved))

    def _solved(self, problem: TangentialProblem, start: RawSolution | None) -> RawSolution:
        memory.need(
            "the tangential problem",
            memory.peak(self.plan.tangential, self.plan.formulation, problem.rigid_shift.size),
            "a grid with fewer elements would fit",
        )
        if problem.no_slip and self.plan.tangential not in MATRIX_FREE:
            return no_slip(problem)
        solver = tangential_solver(self.plan.tangential)
        if self.plan.formulation == "marching":
            solver = partial(march, solver)
        if not (self.polish and states_programs(self.plan.tangential)):
            if self.plan.formulation == "gap" and not problem.monotone:
                raise SceneError(
                    "formulation", "gap", "another: the gap is not convex for so long elements and short dq"
                )
            unpolished = 1.0 if self.plan.tangential in MATRIX_FREE else UNPOLISHED
            raw = solver(problem, self._settings(unpolished * self.tol), start)
            missed = self.plan.fallback != "none" and self.plan.formulation == "none"
            missed = missed and tangential_residual(problem, raw.traction, raw.rigid) > self.tol
            return self._by_program(problem, raw) if missed else raw
        if start is None or not problem.symmetric:
            sticking = no_slip(problem)
            if np.all(magnitude(sticking.traction) <= problem.bound):
                return sticking  # friction is nowhere exhausted: the linear solution is the solution
        if self.plan.formulation == "gap" and not problem.monotone:
            # No convex program: what finds a solution is tried, and the certificate judges it.
            return tang_safeguarded(problem)
        near = None if start is None else _from_start(problem, start)
        return self._polished(problem, solver, tang_safeguarded, tangential_residual, start, near)

    def _by_program(self, problem: TangentialProblem, near: RawSolution) -> RawSolution:
        """The polished answer of the plan's fallback, if there is a convex program and memory for it."""
        formulation = "complementary" if problem.symmetric else "gap"
        try:
            peak = memory.peak(self.plan.fallback, formulation, problem.rigid_shift.size)
            memory.need("the tangential program", peak, "a grid with fewer elements would fit")
        except TooLarge:
            return near
        if formulation == "gap" and not problem.monotone:
            return near
        steps = replace(self, plan=replace(self.plan, tangential=self.plan.fallback, formulation=formulation))
        solver = tangential_solver(self.plan.fallback)
        return steps._polished(problem, solver, tang_safeguarded, tangential_residual, None, near)

    def _settings(self, tol: float) -> Settings:
        return Settings(tol, self.plan.formulation, self.setups)

    def _polished(
        self,
        problem: _Problem,
        solver: Callable[[_Problem, Settings, RawSolution | None], RawSolution],
        polish: Callable[[_Problem, RawSolution | None], RawSolution],
        residual: Callable[[_Problem, np.ndarray, np.ndarray], float],
        start: RawSolution | None,
        near: RawSolution | None,
    ) -> RawSolution:
        """A solver's answer, polished: the solver is asked for no more than the polish needs to succeed.

        Where the polish takes a start (the pass or the step before) to the tolerance, `near`, no solver is needed. Near
        saturation the polish can be lost beside the solution, where almost nothing sticks: then it begins on its own.
        """
        enough = min(self.tol, 1e-9)
        best = None if near is None else replace(near, iterations=0)
        answer = start
        for asked in (1e-2, 1e-4, 1e-6):
            if best is not None and residual(problem, best.traction, best.rigid) <= enough:
                break
            answer = solver(problem, self._settings(asked), start)
            if not (np.isfinite(answer.traction).all() and np.isfinite(answer.rigid).all()):
                continue
            raw = replace(polish(problem, answer), iterations=answer.iterations)
            if best is None or residual(problem, raw.traction, raw.rigid) < residual(
                problem, best.traction, best.rigid
            ):
                best = raw
        assert answer is not None
        if best is None:
            return answer
        reached = residual(problem, best.traction, best.rigid)
        if reached > self.tol:
            alone = replace(polish(problem, None), iterations=answer.iterations)
            best = alone if residual(problem, alone.traction, alone.rigid) < reached else best
        return best


def contact(disc: Discretisation, steps: Steps, start: ContactState) -> ContactState:
    """Pressure and traction, from the pressure without traction."""
    if steps.plan.tangential == "none":
        return start
    if not isinstance(disc.scene.friction, Law):
        return _coupled(disc, steps, start, steps.tol / 10)
    if steps.plan.tangential in THEORIES:
        return _coupled(disc, steps, replace(start, branch=branch_of(steps.start)), steps.tol)

    def solve(disc: Discretisation, state: ContactState, tol: float) -> ContactState:
        return _coupled(disc, steps, state, tol)

    judge = _tangential if steps.plan.coupling in ("none", "johnson") else _whole
    return under_law(disc, solve, judge, start, steps.start, tol=steps.tol / 10)


def _coupled(disc: Discretisation, steps: Steps, start: ContactState, tol: float) -> ContactState:
    """Pressure and traction by the plan's coupling, with known coefficients of friction."""
    normal, tangential, whole = partial(steps.pressure, disc), partial(steps.traction, disc), partial(_whole, disc)
    if steps.plan.coupling == "panagiotopoulos":
        return panagiotopoulos(start, normal, tangential, whole, tol=tol)
    if steps.plan.coupling == "joint":
        return joint(start, partial(steps.together, disc), whole, tol=tol)
    return tangential(start)


def _whole(disc: Discretisation, state: ContactState) -> float:
    """The residual of the whole problem in a state, by FFT."""
    return max(residuals(disc, state.pressure, state.approach, state.traction, state.rigid))


def _tangential(disc: Discretisation, state: ContactState) -> float:
    """That of the tangential problem alone, where the pressure is what it is."""
    return residuals(disc, state.pressure, state.approach, state.traction, state.rigid)[1]


def _from_start(problem: TangentialProblem, start: RawSolution) -> RawSolution:
    """TANG from the pass or the step before; given up soon where that leads nowhere, for a solver knows better."""
    near = tang_safeguarded(problem, start, max_steps=NEWTON_STEPS_FROM_START)
    before, after = (tangential_residual(problem, raw.traction, raw.rigid) for raw in (start, near))
    return near if near.solved or after > 1e-2 * before else tang_safeguarded(problem, near)


def without_noise(problem: NormalProblem, raw: RawSolution) -> RawSolution:
    """A solver's answer without the small pressures that it leaves where the bodies are apart.

    An element is in contact where the natural map ``p - e/rho`` is positive: the pressure outweighs the distance.
    """
    distance = problem.distance - raw.rigid[0] + problem.operator.apply(raw.traction[None])[0]
    return replace(raw, traction=raw.traction * (raw.traction > distance / problem.operator.diagonal))


def hertz_pressure(disc: Discretisation, state: ContactState) -> ContactState:
    """The state with Hertz's pressure: his values on the elements, scaled to carry exactly his force."""
    assert disc.hertz is not None
    pressure = disc.hertz.on_elements(disc.grid)
    if not pressure.any():
        raise out_of_reach(disc.scene, disc.grid)
    pressure *= disc.hertz.force / (pressure.sum() * disc.grid.area)
    approach = (disc.hertz_approach - disc.base) / disc.displacement
    return replace(state, pressure=pressure / disc.pressure, approach=approach)


def _check_force(problem: TangentialProblem, scale: float) -> None:
    """Refuse forces that friction cannot carry."""
    size = math.hypot(*(force or 0.0 for force in problem.force))
    limit = problem.area * float(problem.bound.sum())
    if size > 0 and size >= limit:
        raise Saturated(size * scale, limit * scale)


def _counted(state: ContactState, problem: str, iterations: int) -> dict[str, int]:
    return {**state.iterations, problem: state.iterations.get(problem, 0) + iterations}
