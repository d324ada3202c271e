"""The two steps of every solution: the pressure for given tractions, the tractions for a given pressure."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np

from varcontact.discrete.contact_grid import no_element_in_contact
from varcontact.discrete.discretisation import Discretisation, Subgrid
from varcontact.discrete.mirror import mirror_of
from varcontact.discrete.problems import RawSolution, TangentialProblem
from varcontact.discrete.residuals import project, residuals
from varcontact.discrete.state import ContactState, hertz_pressure, unloaded
from varcontact.discrete.subgrid import cells_of, divided, means
from varcontact.errors import NotConverged, Saturated
from varcontact.results.plan import Plan
from varcontact.results.solution import Solution
from varcontact.scene.motion import Steady, TimeStep
from varcontact.solvers.conic.programs import Workspace
from varcontact.solvers.interface import Settings
from varcontact.solvers.statistics import SolveStats
from varcontact.solving.at_once import at_once
from varcontact.solving.coupling import alternating, joint, panagiotopoulos
from varcontact.solving.friction_law import branch_of, under_law
from varcontact.solving.grid_transfer import interpolated
from varcontact.solving.inner_tolerances import SEEN, WHOLE, enough_pressure, enough_traction, in_passes
from varcontact.solving.pipeline import (
    check_memory,
    solve_joint_program,
    solve_normal,
    solve_tangential,
    without_noise,
)


@dataclass(frozen=True)
class ContactSolver:
    """The methods of a plan, each a step from one contact state to the next.

    Attributes
    ----------
    plan : Plan
    tol : float
        Natural-map residual to reach.
    polish : bool
        Whether the answers of solvers of programs are taken to rounding.
    stats : SolveStats
    workspace : Workspace, optional
        Where solvers keep their set-ups.
    start : str or Solution, optional
        Where the passes under a law of friction begin.
    certify : str
        How much of a certificate is wanted.
    refined : bool
        Whether Newton's method goes on to rounding where that is cheap.
    continuum : bool
        Whether the solution is to be near the continuum's. Under a law of friction the passes then begin with the
        kinetic coefficient, where no `start` is given: what the static one adds to a coarse grid's solution vanishes as
        the grid gets finer. Under a law that falls continuously, particles of a history begin with what they had.
    deadline : float
        When solvers raise `OutOfTime`, by `time.perf_counter` [s].
    """

    plan: Plan
    tol: float
    polish: bool
    stats: SolveStats
    workspace: Workspace | None = None
    start: str | Solution | None = None
    certify: str = "auto"
    refined: bool = True
    continuum: bool = False
    deadline: float = math.inf

    def pressure(self, disc: Discretisation, state: ContactState) -> ContactState:
        """The state with the pressure that goes with its tractions.

        Raises
        ------
        SceneError
            If no element can come into contact.
        TooLarge
            If the memory does not suffice.
        NotConverged
            If the solver gives no numbers.

        Parameters
        ----------
        disc : Discretisation
        state : ContactState
            Dimensionless.
        """
        with self.stats.stage("normal"):
            if self.plan.closed_form:
                with self.stats.called("hertz"):
                    state = hertz_pressure(disc, state)
                return replace(state, solved_by={**state.solved_by, "normal": "hertz"})
            coupled = disc.K != 0 and np.any(state.traction)
            problem = disc.normal_problem(state.traction if coupled else None).reachable()
            elements = problem.operator.elements
            if elements.size == 0:
                raise no_element_in_contact(disc.surface, disc.loading.approach, disc.grid)
            check_memory("normal", self.plan.normal, self.plan.formulation, elements.size)
            start = None
            if np.any(state.pressure):
                start = RawSolution(state.pressure.ravel()[elements], np.array([state.approach]), 0, "start")
            enough = enough_pressure(self.plan, disc, state, self.tol)
            raw = solve_normal(problem, self.plan, self.polish, self._settings(enough, self.plan.loops), start)
            if not (np.isfinite(raw.traction).all() and np.isfinite(raw.rigid).all()):
                raise NotConverged(f"{self.plan.normal} gave no pressure, it says: {raw.status}", np.inf)
            pressure = np.zeros(disc.grid.size)
            pressure[elements] = raw.traction
            return replace(
                state,
                pressure=pressure.reshape(disc.grid.shape),
                approach=float(raw.rigid[0]),
                **_answered(state, "normal", raw),
            )

    def pressed_on_parts(self, disc: Discretisation, state: ContactState) -> tuple[Discretisation, ContactState]:
        """A contact with its pressure solved for on parts of the elements, where those at the edge count in part.

        Parameters
        ----------
        disc : Discretisation
        state : ContactState
            With a pressure to begin with, dimensionless.

        Returns
        -------
        Discretisation
            That knows the pressure on the parts.
        ContactState
            With its means.
        """
        cells = cells_of(disc.grid.edge, disc.line)
        parts = divided(disc, cells)
        begun = interpolated(disc.grid, state.pressure[None], parts.grid)[0]
        higher = (disc.base - parts.base) / disc.scales.displacement
        solved = self.pressure(parts, replace(state, pressure=begun, approach=state.approach + higher))
        found = replace(solved, pressure=means(solved.pressure, cells), approach=solved.approach - higher)
        return replace(disc, subgrid=Subgrid(parts, solved.pressure)), found

    def traction(self, disc: Discretisation, state: ContactState) -> ContactState:
        """The state with the tractions that go with its pressure.

        Parameters
        ----------
        disc : Discretisation
        state : ContactState
            Dimensionless.

        Raises
        ------
        Saturated
            If a prescribed force cannot be carried.
        TooLarge
            If the memory does not suffice.
        NotConverged
            If the solver gives no numbers.
        """
        with self.stats.stage("tangential"):
            if self.plan.theory is not None:
                with self.stats.called(self.plan.tangential):
                    state = self.plan.theory(disc, state)
                return replace(state, solved_by={**state.solved_by, "tangential": self.plan.tangential})
            problem = disc.tangential_problem(state.pressure, state.bound_pressure, marching=self.plan.marches)
            _check_force(problem, disc.scales.force)
            enough = enough_traction(self.plan, disc, state, self.tol)
            settings = self._settings(enough, in_passes(self.plan, disc))
            raw = self._tractions(problem, state, settings)
            if (
                isinstance(disc.loading.motion, Steady)
                and disc.loading.slip_difference == "second-order"
                and not raw.solved
            ):
                first = disc.with_loading(
                    motion=replace(disc.loading.motion, slip_difference="first-order", spin_offset=None)
                )
                easier = first.tangential_problem(state.pressure, state.bound_pressure, marching=self.plan.marches)
                raw = self._from_first_order(easier, problem, settings, raw)
            if not (np.isfinite(raw.traction).all() and np.isfinite(raw.rigid).all()):
                raise NotConverged(f"{self.plan.tangential} gave no tractions, it says: {raw.status}", np.inf)
            traction, rigid = problem.on_grid(raw.traction, raw.rigid)
            return replace(
                state,
                traction=traction,
                rigid=rigid,
                **_answered(state, "tangential", raw),
            )

    def _from_first_order(
        self, easier: TangentialProblem, problem: TangentialProblem, settings: Settings, missed: RawSolution
    ) -> RawSolution:
        """An answer from the tractions with the slip of first order; where that fails, too, what missed the tolerance.

        On elements much longer than wide the slip of second order may not be monotone, where that of first order is.
        """
        begun = self._solved(easier, None, settings)
        raw = self._solved(problem, begun, settings) if begun.solved else missed
        count = missed.iterations + begun.iterations + raw.iterations * begun.solved
        return replace(raw if raw.solved else missed, iterations=count)

    def together(self, disc: Discretisation, state: ContactState) -> ContactState:
        """The state with pressure and tractions of each other, under the traction bound of its `bound_pressure`.

        One convex program for a shift, where the tangential solver takes programs, its answer polished; else the
        two problems in turn.

        Parameters
        ----------
        disc : Discretisation
        state : ContactState
            With its `bound_pressure`, dimensionless.
        """
        if self.plan.formulation == "complementary" and self.plan.programs:
            state = self._joint_program(disc, state)
            if not self.polish or self.plan.convex:
                return state
        enough = SEEN * max(self.tol, state.passes[-1][1] if state.passes else 1.0)  # no more than the next pass sees
        return alternating(state, partial(self.pressure, disc), partial(self.traction, disc), tol=enough)

    def _joint_program(self, disc: Discretisation, state: ContactState) -> ContactState:
        assert state.bound_pressure is not None
        nothing, shifted = unloaded(disc.grid), disc.pressure_to_shift.apply(state.bound_pressure[None])
        normal = disc.normal_problem()  # the pressures are unknowns: tractions can arise wherever they shift particles
        tangential = disc.tangential_problem(nothing.pressure, state.bound_pressure, acting=shifted)
        _check_force(tangential, disc.scales.force)
        if tangential.size == 0:  # no friction where there is contact: no cones, and only the pressure is left
            return self.pressure(disc, self.traction(disc, state))
        size = normal.distance.size + tangential.rigid_shift.size
        check_memory("joint", self.plan.tangential, "complementary", size)
        with self.stats.stage("joint"):
            bodies = disc.operators.traction_to_distance.between((0,), tangential.directions)
            coupling = bodies.dense(normal.operator.elements, tangential.operator.elements)
            pressed, rubbed = solve_joint_program(
                normal, tangential, coupling, self.plan, self.polish, self._settings(self.tol)
            )
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
            **_answered(replace(state, solved_by={**state.solved_by, "normal": pressed.solver}), "tangential", rubbed),
        )

    def _tractions(self, problem: TangentialProblem, state: ContactState, settings: Settings) -> RawSolution:
        if problem.size == 0 or not (np.any(problem.rigid_shift) or any(problem.force)):
            return RawSolution(np.zeros_like(problem.rigid_shift), np.zeros(problem.components), 0, "nothing moves")
        start = None
        if np.any(state.traction):
            known, rigid = problem.of_grid(state.traction, state.rigid)
            start = RawSolution(project(known, problem.bound), rigid, 0, "start")
        mirror = None if self.plan.matrix_free else mirror_of(problem)
        if mirror is None:
            return self._solved(problem, start, settings)
        halved = None if start is None else mirror.fold_solution(start)
        return mirror.unfold(self._solved(mirror.fold(problem), halved, settings))

    def _solved(self, problem: TangentialProblem, start: RawSolution | None, settings: Settings) -> RawSolution:
        check_memory("tangential", self.plan.tangential, self.plan.formulation, problem.rigid_shift.size)
        return solve_tangential(problem, self.plan, self.polish, settings, start)

    def _settings(self, tol: float, rough: bool = False) -> Settings:
        rough = rough or not self.refined
        return Settings(tol, self.plan.formulation, self.workspace, self.stats, rough, self.deadline)


def contact(disc: Discretisation, steps: ContactSolver, start: ContactState) -> ContactState:
    """Pressure and traction, from the pressure without traction.

    Parameters
    ----------
    disc : Discretisation
    steps : ContactSolver
    start : ContactState
        With the pressure without traction, dimensionless.

    Raises
    ------
    Saturated
        If a prescribed force cannot be carried.
    """
    if not steps.plan.has_friction:
        return start
    if disc.loading.law is None:
        return _coupled(disc, steps, start, WHOLE * steps.tol)
    if steps.plan.theory is not None:
        return _coupled(disc, steps, replace(start, branch=branch_of(steps.start)), steps.tol)

    def solve(disc: Discretisation, state: ContactState, tol: float) -> ContactState:
        return _coupled(disc, steps, state, tol)

    judge = _tangential if not steps.plan.loops else _whole
    begin, remembered = steps.start, disc.loading.law.continuous and isinstance(disc.loading.motion, TimeStep)
    if steps.continuum and begin is None and not remembered:
        start, begin = replace(start, friction=None), "slip"
    return under_law(disc, solve, judge, start, begin, tol=WHOLE * steps.tol)


def _coupled(disc: Discretisation, steps: ContactSolver, start: ContactState, tol: float) -> ContactState:
    """Pressure and traction by the plan's coupling, with known coefficients of friction."""
    normal, tangential, whole = partial(steps.pressure, disc), partial(steps.traction, disc), partial(_whole, disc)
    if steps.plan.coupling == "joint":
        return joint(start, partial(steps.together, disc), whole, tol=tol)
    if steps.plan.coupling == "newton":
        start = tangential(start)
        check_memory("coupled", "newton", "none", 3 * disc.grid.size)
        with steps.stats.stage("both"):
            start = at_once(disc, start, whole, Settings(tol, stats=steps.stats, deadline=steps.deadline))
    if steps.plan.loops:
        return panagiotopoulos(start, normal, tangential, whole, tol=tol)
    return tangential(start)


def _whole(disc: Discretisation, state: ContactState) -> float:
    """The residual of the whole problem in a state, by FFT."""
    return max(residuals(disc, state))


def _tangential(disc: Discretisation, state: ContactState) -> float:
    """The residual of the tangential problem alone, under the pressure as it is."""
    return residuals(disc, state)[1]


def _check_force(problem: TangentialProblem, scale: float) -> None:
    """Refuse forces that friction cannot carry."""
    size = math.hypot(*(force or 0.0 for force in problem.force))
    limit = problem.area * float(problem.bound.sum())
    if size > 0 and size >= limit:
        raise Saturated(size * scale, limit * scale)


def _answered(state: ContactState, problem: str, raw: RawSolution) -> dict[str, Any]:
    """What a state says of the answer to one of its problems."""
    return {
        "iterations": {**state.iterations, problem: state.iterations.get(problem, 0) + raw.iterations},
        "status": {**state.status, problem: raw.status},
        "solved": {**state.solved, problem: raw.solved},
        "solved_by": {**state.solved_by, problem: raw.solver},
        "reasons": {**state.reasons, problem: raw.reason},
    }
