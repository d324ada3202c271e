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
from varcontact.solvers.interface import Settings, SolveStats
from varcontact.solvers.registry import MATRIX_FREE
from varcontact.solving.coupling import Limits, coupled_newton, distance, settled
from varcontact.solving.friction_law import (
    branch_of,
    coefficient,
    coefficients_after,
    with_coefficients,
)
from varcontact.solving.pipeline import check_memory, solve_problem

PASSES = 0.1
"""Part of the tolerance at which passes end, and part of that to which the last of them are
exact."""
FIRST, SEEN = 1e-3, 0.01
"""Residuals asked for in passes: in the first, and by the residual after the pass before."""
EXACTEST = 1e-12
"""The least residual that is asked for."""
FORCE, MOST = 1e-9, 20
"""Part of the normal force that may be missing in conformal contact, and the most solutions to find
it."""
MOST_ALTERNATIONS = 50
"""Pressures and tractions in turn within a joint pass."""
PLAIN, NEAR, MOST_UNDER_LAW = 100, 1e-4, 500
"""Passes without acceleration before the residual is so small, and all passes, under a law that is
continuous.

Where two solutions have just vanished, passes linger for a while, then go on; acceleration would
hold them there.
"""


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
            problem = disc.normal_problem(state.traction if coupled else None).reachable()
            elements = problem.operator.elements
            if elements.size == 0:
                raise no_element_in_contact(disc.surface, disc.loading.approach, disc.grid)
            check_memory("normal", self.plan.normal, self.plan.formulation, elements.size)
            start = None
            if np.any(state.pressure):
                start = RawSolution(
                    state.pressure.ravel()[elements], np.array([state.approach]), 0, "start"
                )
            # of the first pressures, those without tractions: they settle the grid
            enough = self.tol
            if self.plan.loops and state.passes and self.plan.normal in MATRIX_FREE:
                # tractions see errors of pressures K by friction times as large
                friction = float(np.abs(state.traction).max()) / float(state.pressure.max())
                enough = max(
                    self._seen(state) * min(1.0, friction / abs(disc.K) if disc.K else 1.0),
                    EXACTEST,
                )
            raw = solve_problem(
                problem, self.plan, self.polish, self._settings(enough, self.plan.loops), start
            )
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

    def pressure_on_subgrid(
        self, disc: Discretisation, state: ContactState
    ) -> tuple[Discretisation, ContactState]:
        """The contact with its pressure solved for on parts of the elements, which bear the
        means.
        """
        cells = cells_of(disc.grid.edge, disc.grid.line)
        parts = divided(disc, cells)
        initial_guess = interpolated(disc.grid, state.pressure[None], parts.grid)[0]
        higher = (disc.base - parts.base) / disc.scales.displacement
        solved = self.pressure(
            parts, replace(state, pressure=initial_guess, approach=state.approach + higher)
        )
        found = replace(
            solved, pressure=means(solved.pressure, cells), approach=solved.approach - higher
        )
        return replace(disc, subgrid=Subgrid(parts, solved.pressure)), found

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

        def one(state: ContactState) -> tuple[ContactState, float]:
            after = self._under_fields(
                disc.under(**{sought.name: state.fields[sought.name]}), state
            )
            then = with_implied_fields(disc, after)
            implied = then.surroundings.implicit[sought.name]
            return after.under(**{sought.name: implied}), residuals(then, after)[1]

        begun, residual = one(state.under(**{sought.name: first}))
        limits = Limits(PASSES * self.tol, MOST_UNDER_LAW, patience=MOST_UNDER_LAW, least=0.0)
        return replace(settled(one, begun, residual, sought.name, limits), passes=state.passes)

    def _under_fields(self, disc: Discretisation, state: ContactState) -> ContactState:
        """The tractions under the implicit fields as they are."""
        marches = self.plan.formulation == "marching"
        problem = disc.tangential_problem(state.pressure, state.bound_pressure, marching=marches)
        size = math.hypot(*(force or 0.0 for force in problem.force))
        limit = problem.area * float(problem.bound.sum())
        if size > 0 and size >= limit:
            raise Saturated(size * disc.scales.force, limit * disc.scales.force)
        law = disc.loading.law
        enough = self.tol
        in_passes = self.plan.loops or law is not None
        if in_passes and self.plan.tangential in MATRIX_FREE:
            # under a law with two coefficients who slips once slips for good: there no pass may be
            # rough
            enough = self._seen(state) if law is None or law.continuous else PASSES**2 * self.tol
        raw = self._tractions(problem, state, self._settings(enough, in_passes))
        if not raw.finite:
            raise NotConverged(
                f"{self.plan.tangential} gave no tractions, it says: {raw.status}", np.inf
            )
        traction, rigid = problem.on_grid(raw.traction, raw.rigid)
        return record_answer(replace(state, traction=traction, rigid=rigid), "tangential", raw)

    def joint_pass(self, disc: Discretisation, state: ContactState) -> ContactState:
        """Pressure and tractions of each other, under the traction bound of the pressure before.

        The two problems in turn: of a shift that is block descent of the complementary energy,
        which is convex.
        """
        # no more than the next pass sees
        enough = SEEN * max(self.tol, state.passes[-1][1] if state.passes else 1.0)
        state = self.traction(disc, replace(state, bound_pressure=state.pressure))
        for _ in range(MOST_ALTERNATIONS):
            before = state
            state = self.traction(disc, self.pressure(disc, state))
            if distance(state.traction, before.traction) <= enough:
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
            known, rigid = problem.of_grid(state.traction, state.rigid)
            start = RawSolution(project(known, problem.bound), rigid, 0, "start")
        mirror = None if self.plan.tangential in MATRIX_FREE else mirror_of(problem)
        unknowns = problem if mirror is None else mirror.fold(problem)
        check_memory(
            "tangential", self.plan.tangential, self.plan.formulation, unknowns.rigid_shift.size
        )
        if mirror is not None and start is not None:
            start = replace(start, traction=start.traction[:, mirror.half])
        raw = solve_problem(unknowns, self.plan, self.polish, settings, start)
        return raw if mirror is None else mirror.unfold(raw)

    def _seen(self, state: ContactState) -> float:
        """What the next pass sees, after the last one's residual."""
        return max(SEEN * state.passes[-1][1], PASSES**2 * self.tol) if state.passes else FIRST

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
        return _coupled(disc, solver, start, PASSES * solver.tol)
    if plan.theory is not None:
        return _coupled(disc, solver, replace(start, branch=branch_of(solver.start)), solver.tol)
    begin = solver.start
    if (
        solver.continuum
        and begin is None
        and not (law.continuous and isinstance(disc.loading.motion, TimeStep))
    ):
        start = replace(start, fields={})
        begin = "slip"
    return _under_law(disc, solver, with_coefficients(disc, start, begin))


def _under_law(disc: Discretisation, solver: ContactSolver, start: ContactState) -> ContactState:
    """The contact under the law of its scene: each pass takes the coefficients of the slip in the
    one before.
    """
    tol = PASSES * solver.tol
    law = disc.loading.law
    assert law is not None

    def one(state: ContactState) -> tuple[ContactState, float]:
        trial = disc.under(friction=state.fields[FRICTION])
        # no more than the next pass sees
        enough = SEEN * state.passes[-1][1] if state.passes else FIRST
        after = _coupled(trial, solver, state, max(tol, enough))
        after = after.under(friction=coefficients_after(trial, after))
        found = residuals(disc.under(friction=coefficient(disc, after)), after)
        return after, max(found) if solver.plan.loops else found[1]

    elements = int(np.count_nonzero(start.pressure)) + 2
    limits = Limits(tol, elements, elements, plain=elements, least=law.kinetic, greatest=law.static)
    if law.continuous:
        limits = replace(
            limits, passes=MOST_UNDER_LAW, patience=MOST_UNDER_LAW, plain=PLAIN, near=NEAR
        )
    try:
        return settled(one, *one(replace(start, passes=())), FRICTION, limits)
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
    together = solver.plan.coupling == "joint"
    if plan.coupling == "newton":
        start = solver.traction(disc, start)
        check_memory("coupled", "newton", "none", 3 * disc.grid.size)
        with solver.stats.stage("both"):
            disc, start = coupled_newton(
                disc, start, Settings(tol, stats=solver.stats, deadline=solver.deadline)
            )
    state = solver.joint_pass(disc, start) if together else solver.traction(disc, start)
    if not plan.loops:
        return state

    def one(state: ContactState) -> tuple[ContactState, float]:
        after = (
            solver.joint_pass(disc, state)
            if together
            else solver.traction(disc, solver.pressure(disc, state))
        )
        return after, max(residuals(disc, after))

    unknown, least = ("pressure", 0.0) if together else ("traction", -math.inf)
    return settled(one, state, max(residuals(disc, state)), unknown, Limits(tol, least=least))


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
    """The contact that bears its force along the normal of the plane; the approach is then as good
    as given.

    Newton's method for pressure and tractions has found it; of others pressures have the force as
    their sum, and the secant finds the sum.
    """
    tried: list[tuple[float, float]] = []
    total = float(state.pressure.sum()) * disc.lattice.area * disc.scales.force
    while True:
        excess = disc.excess_force(state.traction, state.pressure)
        no_nearer = len(tried) > 1 and abs(excess) >= abs(tried[-1][1])
        if abs(excess) <= max(FORCE, solver.tol) or len(tried) == MOST or no_nearer:
            return disc.at_approach(state.approach), state
        slope = (1 + excess) / total  # forces grow together
        if tried:
            slope = (excess - tried[-1][1]) / (total - tried[-1][0])
        tried.append((total, excess))
        total -= excess / slope
        one = disc.with_loading(normal_force=total)
        state = replace(state, pressure=state.pressure * (total / tried[-1][0]))
        state = contact(one, solver, state) if coupled else solver.pressure(one, state)
