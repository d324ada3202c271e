"""Two steps of every solution: the pressure for given tractions, and the tractions for a given
pressure.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np

from varcontact.discrete.contact_grid import interpolated, no_element_in_contact
from varcontact.discrete.discretisation import Discretisation, Subgrid
from varcontact.discrete.problems import RawSolution, TangentialProblem, mirror_of
from varcontact.discrete.residuals import residuals
from varcontact.discrete.state import ContactState, cells_of, divided, hertz_pressure, means
from varcontact.discrete.stick_slip import ContactResponse, with_implied_fields
from varcontact.errors import NotConverged, Saturated, SceneError
from varcontact.interfaces.interface import FROM_ONE_SIDE, JUMPS, Quantity
from varcontact.interfaces.potential import project
from varcontact.results.physical import step_before
from varcontact.results.plan import Plan
from varcontact.results.solution import Solution
from varcontact.scene.friction import BRANCHES
from varcontact.scene.motion import TimeStep
from varcontact.scene.pin import PinInHole
from varcontact.solvers import registry
from varcontact.solvers.interface import Settings, SolveStats
from varcontact.solving.coupling import (
    Limits,
    OuterIteration,
    distance,
    fixed_point,
    solve_at_once,
)
from varcontact.solving.pipeline import check_memory, solve_problem
from varcontact.system.process import changed

PASSES_TOL = 0.1
"""Factor on the tolerance at which passes end, and on that to which the last of them are solved."""
FIRST_TOL = 1e-3
"""Residual requested from solvers in the first pass."""
FORCING_TERM = 0.01
"""Residual requested from solvers in later passes, relative to that of the previous pass."""
TOL_MIN = 1e-12
"""Least residual requested from solvers."""
FORCE_TOL = 1e-9
"""Relative tolerance of the normal force in conformal contact."""
FORCE_SOLVES_MAX = 20
"""Largest number of solves for the normal force of a conformal contact."""
ALTERNATIONS_MAX = 50
"""Largest number of alternations of pressure and tractions within a joint pass."""
FIELD_PASSES_MAX = 500
"""Largest number of passes over interface fields that do not jump."""
PLAIN_PASSES = 100
"""Passes without acceleration to fields of which several may be solutions.

Where two solutions have just vanished, many passes change little before they converge elsewhere;
acceleration would stop them there.
"""
ACCELERATED_BELOW = 1e-4
"""Residual below which passes over fields with several solutions are accelerated."""


@dataclass(frozen=True)
class ContactSolver:
    """The methods of a plan, each a step from one contact state to the next, dimensionless.

    `tol`: natural-map residual to reach. `polish`: whether answers of programs are taken to
    rounding. `start`: where passes under a law of friction begin. `certify`: how much of a
    certificate is wanted. `loose_tolerance`: whether nothing beyond `tol` is of use. `continuum`:
    whether the solution is to be near the continuum's; under a law the passes then begin with the
    kinetic coefficient (what the static one adds vanishes as the grid gets finer), but in a history
    with what particles had. `deadline`: when solvers raise `OutOfTime`, by `time.perf_counter` [s].
    """

    plan: Plan
    tol: float
    polish: bool
    stats: SolveStats
    start: str | Solution | None = None
    certify: str = "auto"
    loose_tolerance: bool = False
    continuum: bool = False
    deadline: float = math.inf

    def pressure(self, disc: Discretisation, state: ContactState) -> ContactState:
        """State with the pressure for its tractions."""
        with self.stats.stage("normal"):
            if self.plan.closed_form:
                with self.stats.called("hertz"):
                    state = hertz_pressure(disc, state)
                return changed(state, solved_by={**state.solved_by, "normal": "hertz"})
            coupled = disc.K != 0 and state.traction.any()
            traction = state.traction if coupled else None
            problem = disc.normal_problem(traction).reachable()
            elements = problem.operator.elements
            if elements.size == 0:
                raise no_element_in_contact(disc.surface, disc.loading.approach, disc.grid)
            normal = self.plan.solver_of("normal")
            check_memory("normal", normal, self.plan.formulation, elements.size)
            start = None
            if state.pressure.any():
                start = RawSolution(
                    state.pressure.ravel()[elements], np.array([state.approach]), 0, "start"
                )
            settings = self._settings(self._pressure_tol(disc, state), self.plan.loops)
            raw = solve_problem(problem, self.plan, self.polish, settings, start)
            if not (raw.finite and (raw.solved or raw.traction.any())):
                raise NotConverged(
                    f"{self.plan.normal} gave no pressure, it says: {raw.status}", np.inf
                )
            pressure = np.zeros(disc.grid.size)
            pressure[elements] = raw.traction
            pressure = pressure.reshape(disc.grid.shape)
            approach = float(raw.rigid[0])
            state = changed(state, pressure=pressure, approach=approach)
            return record_answer(state, "normal", raw)

    def _pressure_tol(self, disc: Discretisation, state: ContactState) -> float:
        """Residual asked for of a pressure; the first ones, without tractions, place the grid."""
        may_be_rough = self.plan.matrix_free("normal")
        if not (self.plan.loops and state.passes and may_be_rough):
            return self.tol
        # tractions see an error of the pressure K / friction times as large
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
        """State with the tractions for its pressure; `Saturated` if these cannot carry a force."""
        with self.stats.stage("tangential"):
            if self.plan.theory is not None:
                with self.stats.called(self.plan.tangential):
                    state = self.plan.theory(disc, state)
                return changed(
                    state, solved_by={**state.solved_by, "tangential": self.plan.tangential}
                )
            if disc.sought(by_slip=False):
                return self._iterate_implied_fields(disc, state)
            return self._under_fields(disc, state)

    def _iterate_implied_fields(self, disc: Discretisation, state: ContactState) -> ContactState:
        """The state whose tractions go with the fields that they imply: at once, or passes until
        these stay.

        Newton's method takes a potential that follows from the tractions as it is.
        """
        if self.plan.tangential == "newton" and disc.potential(state.pressure).implicit:
            at_once = self._under_fields(disc, state)
            if at_once.solved["tangential"]:
                return at_once
        sought = disc.sought(by_slip=False)
        those = disc.interface.those(by_slip=False)
        assert those is not None
        first = those.first(None, disc.surroundings, disc.grid.shape)
        start = state.under({**first, **state.fields})
        tol = PASSES_TOL * self.tol
        one_pass = pass_under_fields(disc, self._under_fields, by_slip=False)
        end = passes_over(sought, one_pass, start, Limits(tol, FIELD_PASSES_MAX, FIELD_PASSES_MAX))
        return changed(end, passes=state.passes)

    def _under_fields(self, disc: Discretisation, state: ContactState) -> ContactState:
        """State with the tractions under the present implicit fields."""
        marches = self.plan.formulation == "marching"
        problem = disc.tangential_problem(state.pressure, state.bound_pressure, marching=marches)
        size = math.hypot(*(force or 0.0 for force in problem.force))
        limit = problem.area * float(problem.bound.sum())
        if size > 0 and size >= limit:
            raise Saturated(size * disc.scales.force, limit * disc.scales.force)
        in_passes = self.plan.loops or bool(disc.sought(by_slip=True))
        tol = self._traction_tol(disc, state) if in_passes else self.tol
        raw = self._tractions(problem, state, self._settings(tol, in_passes))
        if not raw.finite:
            raise NotConverged(
                f"{self.plan.tangential} gave no tractions, it says: {raw.status}", np.inf
            )
        traction, rigid = problem.on_grid(raw.traction, raw.rigid)
        return record_answer(changed(state, traction=traction, rigid=rigid), "tangential", raw)

    def _traction_tol(self, disc: Discretisation, state: ContactState) -> float:
        """Residual asked for of tractions within passes."""
        if not self.plan.matrix_free("tangential"):
            return self.tol
        if not _jumps(disc.sought(by_slip=True)):
            return self._forcing_term(state)
        # with two coefficients an element that slips once keeps slipping: no pass may be inexact
        return PASSES_TOL**2 * self.tol

    def block_descent(self, disc: Discretisation, state: ContactState) -> ContactState:
        """Pressure and tractions of each other, under the traction bound of the pressure before.

        The two problems in turn: of a shift that is block descent of the complementary energy,
        which is convex.
        """
        # no more accurate than the next pass needs
        residual = 1.0
        if state.passes:
            residual = state.passes[-1][1]
        tol = FORCING_TERM * max(self.tol, residual)
        state = self.traction(disc, changed(state, bound_pressure=state.pressure))
        for _ in range(ALTERNATIONS_MAX):
            before = state
            state = self.traction(disc, self.pressure(disc, state))
            if distance(state.traction, before.traction) <= tol:
                break
        return changed(state, bound_pressure=None)

    def _tractions(
        self, problem: TangentialProblem, state: ContactState, settings: Settings
    ) -> RawSolution:
        if problem.size == 0 or not (any(problem.force) or problem.rigid_shift.any()):
            return RawSolution(
                np.zeros_like(problem.rigid_shift), np.zeros(problem.components), 0, "nothing moves"
            )
        start = None
        if state.traction.any():
            traction, rigid = problem.of_grid(state.traction, state.rigid)
            start = RawSolution(project(traction, problem.bound), rigid, 0, "start")
        mirror = None
        if not self.plan.matrix_free("tangential"):
            mirror = mirror_of(problem)
        if mirror is None:
            return self._solve_tangential(problem, settings, start)
        # one half of a symmetric contact
        if start is not None:
            start = changed(start, traction=start.traction[:, mirror.half])
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

    def _settings(self, tol: float, in_passes: bool) -> Settings:
        loose_tolerance = self.loose_tolerance or in_passes
        return Settings(tol, self.plan.formulation, self.stats, loose_tolerance, self.deadline)


def solve_pressure_and_tractions(
    disc: Discretisation, solver: ContactSolver, start: ContactState
) -> ContactState:
    """Pressure and tractions, from the pressure without tractions; `Saturated` if a force cannot be
    carried.

    Passes lie within each other: over what follows from slip, over pressure and tractions, over
    what tractions imply. Of a law several solutions may exist, and passes keep to one side only if
    those within them have ended.
    """
    plan = solver.plan
    if not plan.has_friction:
        return start
    sought = disc.sought(by_slip=True)
    if not sought:
        return _coupled(disc, solver, start, PASSES_TOL * solver.tol)
    if plan.theory is not None:
        return _coupled(disc, solver, changed(start, branch=branch_of(solver.start)), solver.tol)
    return _with_fields_of_slip(disc, solver, _first_pass(disc, solver, start))


def _first_pass(disc: Discretisation, solver: ContactSolver, state: ContactState) -> ContactState:
    """State with the first fields by slip: its own, those carried by particles, or those of the
    start.
    """
    sought = disc.sought(by_slip=True)
    begin = solver.start
    in_time = isinstance(disc.loading.motion, TimeStep)
    if solver.continuum and begin is None and (_jumps(sought) or not in_time):
        begin = "slip"
    elif all(each.name in state.fields for each in sought):
        return state
    if isinstance(begin, Solution) and begin.grid.shape != disc.grid.shape:
        allowed = f"on a grid of shape {disc.grid.shape}"
        raise SceneError("start", f"a Solution of shape {begin.grid.shape}", allowed)
    those = disc.interface.those(by_slip=True)
    assert those is not None
    choice = step_before(begin, disc) if isinstance(begin, Solution) else begin
    first = those.first(choice, disc.surroundings, disc.grid.shape)
    branch = branch_of(begin)
    if begin is None and disc.loading.arrived:
        branch = "history"
    return changed(state.under(first), branch=branch)


def branch_of(start: str | Solution | None) -> str:
    """Starting point of the search for a solution under a friction law, a name of `BRANCHES`."""
    if isinstance(start, Solution):
        return "solution"
    return start or "stick"


def _jumps(sought: tuple[Quantity, ...]) -> bool:
    return any(each.passes == JUMPS for each in sought)


def pass_under_fields(
    disc: Discretisation,
    solve: Callable[[Discretisation, ContactState], ContactState],
    *,
    by_slip: bool,
    whole: bool = False,
) -> OuterIteration:
    """A pass: the contact under the fields of the state, then the fields after it, and the residual
    of the tractions, or of the `whole`, under those that it implies.
    """
    names = [each.name for each in disc.sought(by_slip=by_slip)]
    those = disc.interface.those(by_slip=by_slip)
    assert those is not None

    def one_pass(state: ContactState) -> tuple[ContactState, float]:
        under_fields = disc.under({name: state.fields[name] for name in names})
        after = solve(under_fields, state)
        found = those.after(ContactResponse(under_fields, after), under_fields.surroundings)
        after = after.under({name: found[name] for name in names})
        of_problems = residuals(with_implied_fields(disc, after, by_slip=by_slip), after)
        return after, max(of_problems) if whole else of_problems[1]

    return one_pass


def passes_over(
    sought: tuple[Quantity, ...], one_pass: OuterIteration, start: ContactState, limits: Limits
) -> ContactState:
    """State after passes that end when implicit quantities have converged, within their limits."""
    names = tuple(each.name for each in sought)
    within = {each.name: (each.least, each.most) for each in sought}
    first, residual = one_pass(start)
    return fixed_point(one_pass, first, residual, names, replace(limits, within=within))


def _with_fields_of_slip(
    disc: Discretisation, solver: ContactSolver, start: ContactState
) -> ContactState:
    """Contact with the fields that follow from its slip, by passes from the start."""
    sought = disc.sought(by_slip=True)
    tol = PASSES_TOL * solver.tol

    def coupled(under_fields: Discretisation, state: ContactState) -> ContactState:
        # no more accurate than the next pass needs
        rough = FIRST_TOL
        if state.passes:
            rough = FORCING_TERM * state.passes[-1][1]
        return _coupled(under_fields, solver, state, max(tol, rough))

    one_pass = pass_under_fields(disc, coupled, by_slip=True, whole=solver.plan.loops)
    try:
        elements = int(np.count_nonzero(start.pressure)) + 2
        limits = limits_of_passes(sought, tol, elements)
        return passes_over(sought, one_pass, changed(start, passes=()), limits)
    except Saturated as error:
        raise Saturated(
            error.force, error.limit, f" under its law (sought from {BRANCHES[start.branch]})"
        ) from None


def limits_of_passes(sought: tuple[Quantity, ...], tol: float, elements: int) -> Limits:
    """Limits of passes over quantities, by the strictest of their rules."""
    if _jumps(sought):
        return Limits(tol, elements, elements, plain=elements)
    if any(each.passes == FROM_ONE_SIDE for each in sought):
        return Limits(
            tol,
            FIELD_PASSES_MAX,
            FIELD_PASSES_MAX,
            plain=PLAIN_PASSES,
            near=ACCELERATED_BELOW,
        )
    return Limits(tol, FIELD_PASSES_MAX, FIELD_PASSES_MAX)


def _coupled(
    disc: Discretisation, solver: ContactSolver, start: ContactState, tol: float
) -> ContactState:
    """Pressure and tractions by the plan's coupling, with known coefficients of friction.

    Joint passes have both under a fixed traction bound, until that stays; Panagiotopoulos's process
    has them in turn. Sources: P. D. Panagiotopoulos, Ing.-Arch. 44 (1975) 421-432; Kalker's paper,
    4.5.
    """
    plan = solver.plan
    state = start
    residual = np.inf
    if plan.at_once:
        if not start.traction.any():
            state = solver.traction(disc, state)
        spec = None
        if not plan.by_areas:
            spec = registry.solver("tangential", plan.coupling)
        check_memory("coupled", spec, "none", 3 * disc.grid.size)
        settings = Settings(tol, stats=solver.stats, deadline=solver.deadline)
        with solver.stats.stage("both"):
            disc, state, residual = solve_at_once(disc, state, plan.coupling, settings)
        if math.isnan(residual):
            residual = max(residuals(disc, state))
    if plan.coupling == "joint":
        state = solver.block_descent(disc, state)
    elif not residual <= tol:
        state = solver.traction(disc, state)
    if not plan.loops:
        return state

    def joint_pass(state: ContactState) -> tuple[ContactState, float]:
        after = solver.block_descent(disc, state)
        return after, max(residuals(disc, after))

    def alternating_pass(state: ContactState) -> tuple[ContactState, float]:
        after = solver.traction(disc, solver.pressure(disc, state))
        return after, max(residuals(disc, after))

    if not residual <= tol:
        residual = max(residuals(disc, state))
    if plan.coupling == "joint":
        limits = Limits(tol, within={"pressure": (0.0, np.inf)})
        return fixed_point(joint_pass, state, residual, ("pressure",), limits)
    return fixed_point(alternating_pass, state, residual, ("traction",), Limits(tol))


def record_answer(state: ContactState, problem: str, raw: RawSolution) -> ContactState:
    """The state with the record of the answer to one of its problems."""
    iterations = state.iterations.get(problem, 0) + raw.iterations
    return changed(
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
    if isinstance(disc.surface, PinInHole):
        return _with_force_on_pin(disc, solver, state, coupled)
    search = _ForceSearch(max(FORCE_TOL, solver.tol))
    total = float(state.pressure.sum()) * disc.lattice.area * disc.scales.force
    while True:
        excess = disc.excess_force(state.traction, state.pressure)
        after = search.next_value(total, excess)
        if after is None:
            return disc.at_approach(state.approach), state
        under_total = disc.with_loading(normal_force=after)
        state = replace(state, pressure=state.pressure * (after / total))
        if coupled:
            state = solve_pressure_and_tractions(under_total, solver, state)
        else:
            state = solver.pressure(under_total, state)
        total = after


def as_held(disc: Discretisation, state: ContactState) -> Discretisation:
    """Contact with the approach of a state, for a pin that a force presses; otherwise unchanged.

    Its approach changes the distance along the arc, so that its problem is one of a given approach.
    """
    if disc.loading.normal_force is None or not isinstance(disc.surface, PinInHole):
        return disc
    return disc.at_approach(state.approach)


def _with_force_on_pin(
    disc: Discretisation, solver: ContactSolver, state: ContactState, coupled: bool
) -> tuple[Discretisation, ContactState]:
    """The contact of a pin under its force: the secant finds the approach."""
    search = _ForceSearch(max(FORCE_TOL, solver.tol))
    approach = state.approach
    while True:
        held = disc.at_approach(approach)
        state = replace(state, approach=approach)
        if coupled:
            state = solve_pressure_and_tractions(held, solver, state)
        else:
            state = solver.pressure(held, state)
        after = search.next_value(approach, disc.excess_force(state.traction, state.pressure))
        if after is None:
            return held, state
        approach = max(after, approach / 2)  # at most half of the way back


@dataclass
class _ForceSearch:
    """Secant search for the value, a sum of pressures or an approach, at which a contact carries
    its normal force; `tol` is relative to that.
    """

    tol: float
    tried: list[tuple[float, float]] = field(default_factory=list)

    def next_value(self, value: float, excess: float) -> float | None:
        """Next value, from the relative excess of the force at this one; None where the search
        ends.
        """
        no_nearer = len(self.tried) > 1 and abs(excess) >= abs(self.tried[-1][1])
        if abs(excess) <= self.tol or len(self.tried) == FORCE_SOLVES_MAX or no_nearer:
            return None
        slope = (1 + excess) / value  # the force grows in proportion
        if self.tried:
            last_value, last_excess = self.tried[-1]
            slope = (excess - last_excess) / (value - last_value)
        self.tried.append((value, excess))
        return value - excess / slope
