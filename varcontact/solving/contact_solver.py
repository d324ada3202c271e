"""The two steps of every solution: the pressure for given tractions, the tractions for a given
pressure.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from varcontact.discrete.contact_grid import interpolated, no_element_in_contact
from varcontact.discrete.discretisation import Discretisation, Subgrid
from varcontact.discrete.problems import RawSolution, TangentialProblem, mirror_of
from varcontact.discrete.residuals import residuals
from varcontact.discrete.state import ContactState, cells_of, divided, hertz_pressure, means
from varcontact.discrete.stick_slip import with_implied_fields
from varcontact.errors import NotConverged, Saturated
from varcontact.interfaces.coulomb import FRICTION
from varcontact.interfaces.potential import project
from varcontact.results.plan import Plan
from varcontact.results.solution import Solution
from varcontact.scene.friction import BRANCHES
from varcontact.scene.motion import TimeStep
from varcontact.solvers import registry
from varcontact.solvers.interface import Settings, SolveStats
from varcontact.solving.coupling import Limits, coupled_newton, distance, fixed_point
from varcontact.solving.friction_law import (
    branch_of,
    coefficient,
    coefficients_after,
    with_coefficients,
)
from varcontact.solving.pipeline import check_memory, solve_problem

PASSES_TOL = 0.1
"""Part of the tolerance at which passes end, and part of that to which the last of them are
exact."""
FIRST_TOL = 1e-3
"""Residual that solvers are asked for in the first pass."""
FORCING_TERM = 0.01
"""Residual that solvers are asked for in later passes, relative to that of the pass before."""
TOL_MIN = 1e-12
"""The least residual that solvers are asked for."""
FORCE_TOL = 1e-9
"""Part of the normal force that may be missing in conformal contact."""
FORCE_SOLVES_MAX = 20
"""Solutions at most to find the pressures that bear the normal force of a conformal contact."""
ALTERNATIONS_MAX = 50
"""Pressures and tractions in turn at most within a joint pass."""
LAW_PASSES_MAX = 500
"""Passes at most under a continuous law."""
LAW_PLAIN_PASSES = 100
"""Passes without acceleration under a continuous law.

Where two solutions have just vanished, passes linger for a while, then go on; acceleration would
hold them there.
"""
LAW_ACCELERATED_BELOW = 1e-4
"""Residual below which these are accelerated, too."""


@dataclass(frozen=True)
class ContactSolver:
    """The methods of a plan, each a step from one contact state to the next, dimensionless.

    `tol`: natural-map residual to reach. `polish`: whether answers of programs are taken to
    rounding. `start`: where passes under a law of friction begin. `certify`: how much of a
    certificate is wanted. `refined`: whether Newton's method goes on to rounding where that is
    cheap. `continuum`: whether the solution is to be near the continuum's; under a law the passes
    then begin with the kinetic coefficient (what the static one adds vanishes as the grid gets
    finer), but in a history with what particles had. `deadline`: when solvers raise `OutOfTime`, by
    `time.perf_counter` [s].
    """

    plan: Plan
    tol: float
    polish: bool
    stats: SolveStats
    start: str | Solution | None = None
    certify: str = "auto"
    refined: bool = True
    continuum: bool = False
    deadline: float = math.inf

    def pressure(self, disc: Discretisation, state: ContactState) -> ContactState:
        """The state with the pressure that goes with its tractions."""
        with self.stats.stage("normal"):
            if self.plan.closed_form:
                with self.stats.called("hertz"):
                    state = hertz_pressure(disc, state)
                return replace(state, solved_by={**state.solved_by, "normal": "hertz"})
            coupled = disc.K != 0 and np.any(state.traction)
            traction = state.traction if coupled else None
            problem = disc.normal_problem(traction).reachable()
            elements = problem.operator.elements
            if elements.size == 0:
                raise no_element_in_contact(disc.surface, disc.loading.approach, disc.grid)
            normal = self.plan.solver_of("normal")
            check_memory("normal", normal, self.plan.formulation, elements.size)
            start = None
            if np.any(state.pressure):
                start = RawSolution(
                    state.pressure.ravel()[elements], np.array([state.approach]), 0, "start"
                )
            settings = self._settings(self._pressure_tol(disc, state), self.plan.loops)
            raw = solve_problem(problem, self.plan, self.polish, settings, start)
            if not (raw.finite and (raw.solved or np.any(raw.traction))):
                raise NotConverged(
                    f"{self.plan.normal} gave no pressure, it says: {raw.status}", np.inf
                )
            pressure = np.zeros(disc.grid.size)
            pressure[elements] = raw.traction
            pressure = pressure.reshape(disc.grid.shape)
            approach = float(raw.rigid[0])
            state = replace(state, pressure=pressure, approach=approach)
            return record_answer(state, "normal", raw)

    def _pressure_tol(self, disc: Discretisation, state: ContactState) -> float:
        """Residual asked for of a pressure; the first ones, without tractions, place the grid."""
        may_be_rough = self.plan.matrix_free("normal")
        if not (self.plan.loops and state.passes and may_be_rough):
            return self.tol
        # errors of pressures are seen by tractions K by friction times as large
        friction = float(np.abs(state.traction).max()) / float(state.pressure.max())
        part = 1.0
        if disc.K:
            part = min(1.0, friction / abs(disc.K))
        return max(self._forcing_term(state) * part, TOL_MIN)

    def pressure_on_subgrid(
        self, disc: Discretisation, state: ContactState
    ) -> tuple[Discretisation, ContactState]:
        """The contact with its pressure solved for on parts of the elements, which have the means
        of these.
        """
        cells = cells_of(disc.grid.edge, disc.grid.line)
        parts = divided(disc, cells)
        initial_guess = interpolated(disc.grid, state.pressure[None], parts.grid)[0]
        higher = (disc.base - parts.base) / disc.scales.displacement
        on_parts = self.pressure(
            parts, replace(state, pressure=initial_guess, approach=state.approach + higher)
        )
        state = replace(
            on_parts, pressure=means(on_parts.pressure, cells), approach=on_parts.approach - higher
        )
        return replace(disc, subgrid=Subgrid(parts, on_parts.pressure)), state

    def traction(self, disc: Discretisation, state: ContactState) -> ContactState:
        """The state with the tractions that go with its pressure; `Saturated` if these cannot carry
        a force.
        """
        with self.stats.stage("tangential"):
            if self.plan.theory is not None:
                with self.stats.called(self.plan.tangential):
                    state = self.plan.theory(disc, state)
                return replace(
                    state, solved_by={**state.solved_by, "tangential": self.plan.tangential}
                )
            if any(each.name != FRICTION for each in disc.implicit):
                return self._with_layer(disc, state)
            return self._under_fields(disc, state)

    def _with_layer(self, disc: Discretisation, state: ContactState) -> ContactState:
        """The state whose tractions go with the fields of a layer that they imply: at once, or
        passes until these stay.

        Newton's method takes a potential that follows from the tractions as it is.
        """
        if self.plan.tangential == "newton" and disc.potential(state.pressure).implicit:
            at_once = self._under_fields(disc, state)
            if at_once.solved["tangential"]:
                return at_once
        (sought,) = (each for each in disc.implicit if each.name != FRICTION)
        fresh = np.full(disc.grid.shape, sought.fresh)
        first = state.fields.get(sought.name, disc.surroundings.arrived.get(sought.name, fresh))

        def one_pass(state: ContactState) -> tuple[ContactState, float]:
            under_field = disc.under(**{sought.name: state.fields[sought.name]})
            after = self._under_fields(under_field, state)
            with_layer = with_implied_fields(disc, after)
            implied = with_layer.surroundings.implicit[sought.name]
            return after.under(**{sought.name: implied}), residuals(with_layer, after)[1]

        limits = Limits(PASSES_TOL * self.tol, LAW_PASSES_MAX, patience=LAW_PASSES_MAX, least=0.0)
        start, residual = one_pass(state.under(**{sought.name: first}))
        end = fixed_point(one_pass, start, residual, sought.name, limits)
        return replace(end, passes=state.passes)

    def _under_fields(self, disc: Discretisation, state: ContactState) -> ContactState:
        """The tractions under the implicit fields as they are."""
        marches = self.plan.formulation == "marching"
        problem = disc.tangential_problem(state.pressure, state.bound_pressure, marching=marches)
        size = math.hypot(*(force or 0.0 for force in problem.force))
        limit = problem.area * float(problem.bound.sum())
        if size > 0 and size >= limit:
            raise Saturated(size * disc.scales.force, limit * disc.scales.force)
        in_passes = self.plan.loops or disc.loading.law is not None
        tol = self._traction_tol(disc, state) if in_passes else self.tol
        raw = self._tractions(problem, state, self._settings(tol, in_passes))
        if not raw.finite:
            raise NotConverged(
                f"{self.plan.tangential} gave no tractions, it says: {raw.status}", np.inf
            )
        traction, rigid = problem.on_grid(raw.traction, raw.rigid)
        return record_answer(replace(state, traction=traction, rigid=rigid), "tangential", raw)

    def _traction_tol(self, disc: Discretisation, state: ContactState) -> float:
        """Residual asked for of tractions within passes."""
        law = disc.loading.law
        if not self.plan.matrix_free("tangential"):
            return self.tol
        if law is None or law.continuous:
            return self._forcing_term(state)
        # of two coefficients: what slips once slips for good, so no pass may be rough
        return PASSES_TOL**2 * self.tol

    def block_descent(self, disc: Discretisation, state: ContactState) -> ContactState:
        """Pressure and tractions of each other, under the traction bound of the pressure before.

        The two problems in turn: of a shift that is block descent of the complementary energy,
        which is convex.
        """
        # no more than the next pass needs
        residual = 1.0
        if state.passes:
            residual = state.passes[-1][1]
        tol = FORCING_TERM * max(self.tol, residual)
        state = self.traction(disc, replace(state, bound_pressure=state.pressure))
        for _ in range(ALTERNATIONS_MAX):
            before = state
            state = self.traction(disc, self.pressure(disc, state))
            if distance(state.traction, before.traction) <= tol:
                break
        return replace(state, bound_pressure=None)

    def _tractions(
        self, problem: TangentialProblem, state: ContactState, settings: Settings
    ) -> RawSolution:
        if problem.size == 0 or not (np.any(problem.rigid_shift) or any(problem.force)):
            return RawSolution(
                np.zeros_like(problem.rigid_shift), np.zeros(problem.components), 0, "nothing moves"
            )
        start = None
        if np.any(state.traction):
            traction, rigid = problem.of_grid(state.traction, state.rigid)
            start = RawSolution(project(traction, problem.bound), rigid, 0, "start")
        mirror = None
        if not self.plan.matrix_free("tangential"):
            mirror = mirror_of(problem)
        if mirror is None:
            return self._solve_tangential(problem, settings, start)
        # one half of a symmetric contact
        if start is not None:
            start = replace(start, traction=start.traction[:, mirror.half])
        return mirror.unfold(self._solve_tangential(mirror.fold(problem), settings, start))

    def _solve_tangential(
        self, problem: TangentialProblem, settings: Settings, start: RawSolution | None
    ) -> RawSolution:
        unknowns = problem.rigid_shift.size
        tangential = self.plan.solver_of("tangential")
        check_memory("tangential", tangential, self.plan.formulation, unknowns)
        return solve_problem(problem, self.plan, self.polish, settings, start)

    def _forcing_term(self, state: ContactState) -> float:
        """Residual asked for in the next pass, after the last one's."""
        if not state.passes:
            return FIRST_TOL
        return max(FORCING_TERM * state.passes[-1][1], PASSES_TOL**2 * self.tol)

    def _settings(self, tol: float, rough: bool = False) -> Settings:
        return Settings(
            tol, self.plan.formulation, self.stats, rough or not self.refined, self.deadline
        )


def contact(disc: Discretisation, solver: ContactSolver, start: ContactState) -> ContactState:
    """Pressure and tractions, from the pressure without tractions; `Saturated` if a force cannot be
    carried.
    """
    plan = solver.plan
    law = disc.loading.law
    if not plan.has_friction:
        return start
    if law is None:
        return _coupled(disc, solver, start, PASSES_TOL * solver.tol)
    if plan.theory is not None:
        return _coupled(disc, solver, replace(start, branch=branch_of(solver.start)), solver.tol)
    branch = solver.start
    particles_have_one = law.continuous and isinstance(disc.loading.motion, TimeStep)
    if solver.continuum and branch is None and not particles_have_one:
        start = replace(start, fields={})
        branch = "slip"
    return _under_law(disc, solver, with_coefficients(disc, start, branch))


def _under_law(disc: Discretisation, solver: ContactSolver, start: ContactState) -> ContactState:
    """The contact under the law of its scene: each pass takes the coefficients of the slip in the
    one before.
    """
    tol = PASSES_TOL * solver.tol
    law = disc.loading.law
    assert law is not None

    def one_pass(state: ContactState) -> tuple[ContactState, float]:
        under_field = disc.under(friction=state.fields[FRICTION])
        # no more than the next pass needs
        rough = FIRST_TOL
        if state.passes:
            rough = FORCING_TERM * state.passes[-1][1]
        after = _coupled(under_field, solver, state, max(tol, rough))
        after = after.under(friction=coefficients_after(under_field, after))
        of_problems = residuals(disc.under(friction=coefficient(disc, after)), after)
        return after, max(of_problems) if solver.plan.loops else of_problems[1]

    elements = int(np.count_nonzero(start.pressure)) + 2
    limits = Limits(tol, elements, elements, plain=elements, least=law.kinetic, greatest=law.static)
    if law.continuous:
        limits = replace(
            limits,
            passes=LAW_PASSES_MAX,
            patience=LAW_PASSES_MAX,
            plain=LAW_PLAIN_PASSES,
            near=LAW_ACCELERATED_BELOW,
        )
    try:
        first, residual = one_pass(replace(start, passes=()))
        return fixed_point(one_pass, first, residual, FRICTION, limits)
    except Saturated as error:
        raise Saturated(
            error.force, error.limit, f" under its law (sought from {BRANCHES[start.branch]})"
        ) from None


def _coupled(
    disc: Discretisation, solver: ContactSolver, start: ContactState, tol: float
) -> ContactState:
    """Pressure and tractions by the plan's coupling, with known coefficients of friction.

    Joint passes have both under a fixed traction bound, until that stays; Panagiotopoulos's process
    has them in turn. Sources: P. D. Panagiotopoulos, Ing.-Arch. 44 (1975) 421-432; Kalker's paper,
    4.5.
    """
    plan = solver.plan
    if plan.coupling == "newton":
        start = solver.traction(disc, start)
        check_memory("coupled", registry.solver("tangential", "newton"), "none", 3 * disc.grid.size)
        with solver.stats.stage("both"):
            disc, start = coupled_newton(
                disc, start, Settings(tol, stats=solver.stats, deadline=solver.deadline)
            )
    if plan.coupling == "joint":
        state = solver.block_descent(disc, start)
    else:
        state = solver.traction(disc, start)
    if not plan.loops:
        return state

    def joint_pass(state: ContactState) -> tuple[ContactState, float]:
        after = solver.block_descent(disc, state)
        return after, max(residuals(disc, after))

    def alternating_pass(state: ContactState) -> tuple[ContactState, float]:
        after = solver.traction(disc, solver.pressure(disc, state))
        return after, max(residuals(disc, after))

    residual = max(residuals(disc, state))
    if plan.coupling == "joint":
        return fixed_point(joint_pass, state, residual, "pressure", Limits(tol, least=0.0))
    return fixed_point(alternating_pass, state, residual, "traction", Limits(tol))


def record_answer(state: ContactState, problem: str, raw: RawSolution) -> ContactState:
    """The state with the record of the answer to one of its problems."""
    iterations = state.iterations.get(problem, 0) + raw.iterations
    return replace(
        state,
        iterations={**state.iterations, problem: iterations},
        status={**state.status, problem: raw.status},
        solved={**state.solved, problem: raw.solved},
        solved_by={**state.solved_by, problem: raw.solver},
        reasons={**state.reasons, problem: raw.reason},
    )


def with_normal_force(
    disc: Discretisation, solver: ContactSolver, state: ContactState, coupled: bool
) -> tuple[Discretisation, ContactState]:
    """The contact with its force along the normal of the plane; the approach is then prescribed.

    Newton's method for pressure and tractions has found it; of others pressures have the force as
    their sum, and the secant finds the sum.
    """
    tried: list[tuple[float, float]] = []
    total = float(state.pressure.sum()) * disc.lattice.area * disc.scales.force
    while True:
        excess = disc.excess_force(state.traction, state.pressure)
        no_nearer = len(tried) > 1 and abs(excess) >= abs(tried[-1][1])
        enough = abs(excess) <= max(FORCE_TOL, solver.tol)
        if enough or len(tried) == FORCE_SOLVES_MAX or no_nearer:
            return disc.at_approach(state.approach), state
        slope = (1 + excess) / total  # forces grow together
        if tried:
            slope = (excess - tried[-1][1]) / (total - tried[-1][0])
        tried.append((total, excess))
        total -= excess / slope
        under_total = disc.with_loading(normal_force=total)
        state = replace(state, pressure=state.pressure * (total / tried[-1][0]))
        if coupled:
            state = contact(under_total, solver, state)
        else:
            state = solver.pressure(under_total, state)
