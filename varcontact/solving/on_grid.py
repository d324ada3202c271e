"""A scene on its own grid: a grid that holds the contact, the contact on it, and its certified
solution.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from itertools import product
from typing import TypeGuard

import numpy as np

from varcontact.checks import LARGE
from varcontact.discrete import contact_grid
from varcontact.discrete.certificate import EPS, Certificate, certificate_of
from varcontact.discrete.discretisation import Discretisation, discretise
from varcontact.discrete.operators import Operators
from varcontact.discrete.penetration import outside
from varcontact.discrete.residuals import normal_residual
from varcontact.discrete.state import ContactState, unloaded
from varcontact.discrete.stick_slip import ContactResponse, with_implied_fields
from varcontact.errors import NotConverged, SceneError
from varcontact.results.physical import computed_when_read, solution_of
from varcontact.results.plan import Plan
from varcontact.results.report import no_guarantee
from varcontact.results.solution import Solution
from varcontact.scene.grid import Grid
from varcontact.scene.motion import TimeStep
from varcontact.scene.scene import Scene
from varcontact.scene.surfaces import Cylinders, SampledDistance, along_axes
from varcontact.solving.contact_solver import (
    ContactSolver,
    as_held,
    solve_pressure_and_tractions,
    with_normal_force,
)
from varcontact.solving.coupling import PASSES_MAX
from varcontact.solving.initial_guess import InitialGuess, state_on, with_tractions_of
from varcontact.solving.options import SolveOptions
from varcontact.solving.surface_noise import noise_warning
from varcontact.system.process import changed, lazy_property

PLACE_TOL = 1e-4
"""Residual in the search for the normal force of a conformal contact without tractions, which only
locates the contact."""
APPROACH_TOL = 1e-6
"""Residual of a pressure that is only used for the approach."""
BORDER_ROUNDING = 1e-9
"""Distance of a sample beyond its border, in elements, up to which it counts as on the border."""
SEARCH_ELEMENTS = 24
"""Elements across on a grid of the coarse search for a contact."""
SEARCH_GRIDS_MAX = 60
"""Largest number of grids of the coarse search."""
SEARCH_TOL = 1e-6
"""Residual of the pressures of the coarse search."""
SEARCH_ELEMENTS_ACROSS = 8
"""Elements across the contact with which the coarse search ends."""
GRIDS_MAX = 20
"""Largest number of grids that are tried."""
CLOSER_GRIDS_MAX = 3
"""Largest number of grids that are closer around the contact than the one before."""
ROOM = 0.1
"""Margin added where tractions move a contact beyond the grid, divided by its length: there only
the next elements are known."""
TURN_MAX = 2.0
"""Angle by which the reference surface may turn over a conformal contact [rad]."""
DISTANCE_ROUNDING_MAX = 1e-3
"""Largest rounding error of distances, divided by the approach."""


@dataclass(frozen=True, eq=False)
class ContactOnGrid:
    """Contact with pressure and tractions, not yet certified."""

    scene: Scene
    disc: Discretisation
    state: ContactState
    solver: ContactSolver

    @classmethod
    def of(
        cls,
        scene: Scene,
        options: SolveOptions,
        initial_guess: Solution | InitialGuess | None = None,
        operators: Operators | None = None,
    ) -> ContactOnGrid:
        """See `solve_on_grid`; `operators` serve again on the same lattice."""
        solver = options.solver(scene)
        disc, state = solve_contact(scene, solver, operators, initial_guess=initial_guess)
        return cls(scene, disc, state, solver)

    @classmethod
    def with_initial_guess(
        cls,
        scene: Scene,
        options: SolveOptions,
        initial_guess: Solution | InitialGuess,
        operators: Operators | None = None,
    ) -> ContactOnGrid:
        """Contact of an initial guess on the scene's own elements, before any solve."""
        disc = discretise(scene, scene.own_grid, operators)
        return cls(scene, disc, state_on(initial_guess, disc), options.solver(scene))

    def with_pressure(self) -> ContactOnGrid:
        """Contact with the pressure without tractions, checked to lie within the elements."""
        disc, state = _pressure_alone(self.scene, self.solver, self.disc, self.state)
        adjust(self.solver.plan, disc, state, closer=False)
        return changed(self, disc=disc, state=state)

    @property
    def keeps_pressure(self) -> bool:
        """True if tractions do not change the pressure, and it is solved on whole elements."""
        return self.solver.plan.coupling == "none" and self.disc.subgrid is None

    def starting_from(self, initial_guess: Solution | InitialGuess) -> ContactOnGrid:
        """Contact with the tractions of an initial guess as a start."""
        return changed(self, state=with_tractions_of(initial_guess, self.disc, self.state))

    def with_tractions(self) -> ContactOnGrid:
        """Contact with the tractions for its pressure."""
        return replace(self, state=solve_pressure_and_tractions(self.disc, self.solver, self.state))

    def under(self, normal_force: float) -> ContactOnGrid:
        """Frictionless contact on these elements under a normal force, to a residual of
        `APPROACH_TOL`, or the solver's tolerance if that is larger.
        """
        loading = changed(self.disc.loading, approach=None, normal_force=normal_force)
        disc = changed(self.disc, loading=loading)
        rough = changed(self.solver, tol=max(self.solver.tol, APPROACH_TOL), loose_tolerance=True)
        return changed(self, disc=disc, state=rough.pressure(disc, self.state))

    @property
    def approach(self) -> float:
        """Approach of the bodies, physical."""
        return self.initial_guess.approach

    @lazy_property
    def initial_guess(self) -> InitialGuess:
        """Start of the contact in a similar scene."""
        return InitialGuess.of(self.disc, self.state)

    @property
    def force(self) -> np.ndarray:
        """Fx, Fy and the normal force, physical."""
        guess = self.initial_guess
        traction, pressure = along_axes(
            self.scene.surface, self.disc.grid, guess.traction, guess.pressure
        )
        return np.array([*traction.sum(axis=(1, 2)), pressure.sum()]) * self.disc.grid.area

    def solution(self) -> Solution:
        solution = finish(self.scene, self.disc, self.state, self.solver)
        if not isinstance(self.scene.surface, SampledDistance):
            return solution
        warning = noise_warning(self.scene, self.disc, self.state, self.solver)
        if not warning:
            return solution
        return replace(solution, warnings=(warning,))


def solve_on_grid(
    scene: Scene, options: SolveOptions, initial_guess: Solution | InitialGuess | None = None
) -> Solution:
    """A scene, which is no history, on its own grid: from the plan to the certified solution.

    The initial guess is of the same scene on another grid.
    """
    kept = options.operators
    known = None
    if kept is not None and isinstance(scene.grid, Grid):
        known = kept.get(scene.grid)
    on_grid = ContactOnGrid.of(scene, options, initial_guess, known)
    if kept is not None:
        kept[on_grid.disc.grid] = on_grid.disc.operators
    if options.final:
        return on_grid.solution()
    return finish(scene, on_grid.disc, on_grid.state, on_grid.solver)


def solve_contact(
    scene: Scene,
    solver: ContactSolver,
    operators: Operators | None = None,
    traction: np.ndarray | None = None,
    initial_guess: Solution | InitialGuess | None = None,
) -> tuple[Discretisation, ContactState]:
    """Contact on a grid that contains it: a grid that the user did not choose is enlarged where the
    contact continues outside.

    The contact without tractions settles the grid; of unlike bodies it is then that with tractions.
    The `operators` serve again on the same lattice. Tractions of like bodies begin from `traction`,
    on as many elements. An initial guess, on another grid, gives the place of the contact, its
    pressure and its tractions. In conformal contact the force along the normal of the plane is
    prescribed: the sum of the pressures is sought with which they and the tractions balance it.
    """
    coupled = solver.plan.coupling != "none"
    with solver.stats.stage("grid"):
        grid, last_contact = place(scene, solver, initial_guess)
    contacts = 0
    for attempt in range(GRIDS_MAX):
        # the pressure without tractions
        disc = discretise(scene, grid, operators)
        operators = disc.operators
        placed = contacts > 0
        if _same_contact(last_contact, solver, disc):
            placed = True
            state = state_on(last_contact, disc)
        else:
            disc, state = _without_tractions(scene, solver, disc, last_contact)
        next_grid = None
        if not (coupled and placed):
            with solver.stats.stage("grid"):
                closer = attempt < CLOSER_GRIDS_MAX
                next_grid = adjust(solver.plan, as_held(disc, state), state, closer)

        # the tractions, on a grid that holds it; of unlike bodies they move the contact
        if next_grid is None:
            state = _with_start(disc, solver, state, traction, initial_guess)
            held = as_held(disc, state)
            state = solve_pressure_and_tractions(held, solver, state)
            if coupled:
                with solver.stats.stage("grid"):
                    closer = 0 < contacts <= CLOSER_GRIDS_MAX
                    next_grid = adjust(solver.plan, held, state, closer, with_tractions=True)
            contacts += 1
        if next_grid is None:
            break
        grid = next_grid
        last_contact = InitialGuess.of(disc, state)
    else:
        message = (
            "grid: no potential contact was found that holds the contact; give an explicit grid"
        )
        message += contact_grid.if_noise(scene.surface, grid)
        raise SceneError("grid", scene.grid, "explicit", message=message)
    if not disc.conformal:
        return disc, state
    if scene.normal_force is not None:
        disc, state = with_normal_force(disc, solver, state, coupled)
    _check_turn(scene, disc, state)
    return disc, state


def _with_start(
    disc: Discretisation,
    solver: ContactSolver,
    state: ContactState,
    traction: np.ndarray | None,
    initial_guess: Solution | InitialGuess | None,
) -> ContactState:
    """State with tractions to start from: of an initial guess, or of another motion."""
    if initial_guess is not None:
        return with_tractions_of(initial_guess, disc, state)
    # of like bodies on as many elements
    like = solver.plan.has_friction and disc.K == 0
    if like and traction is not None and traction.shape == (2, *disc.grid.shape):
        return replace(state, traction=traction)
    return state


def _same_contact(
    before: Solution | InitialGuess | None, solver: ContactSolver, disc: Discretisation
) -> TypeGuard[Solution | InitialGuess]:
    """True if the pressure and the tractions before can be a start together: on the same grid,
    where one solver has both.
    """
    if before is None or not solver.plan.at_once or disc.sought(by_slip=True):
        return False
    return before.grid == disc.grid and bool(np.any(before.traction))


def _without_tractions(
    scene: Scene,
    solver: ContactSolver,
    disc: Discretisation,
    initial_guess: Solution | InitialGuess | None,
) -> tuple[Discretisation, ContactState]:
    """Pressure of the contact without tractions; in conformal contact under its force."""
    state = unloaded(disc.grid)
    if initial_guess is not None:
        state = state_on(initial_guess, disc)
    elif disc.hertz is not None and solver.plan.by_areas:
        # contact area of half-spaces with the same compliance
        pressure = disc.hertz.on_elements(disc.grid) / disc.scales.pressure
        state = changed(state, pressure=pressure)
    return _pressure_alone(scene, solver, disc, state)


def _pressure_alone(
    scene: Scene, solver: ContactSolver, disc: Discretisation, state: ContactState
) -> tuple[Discretisation, ContactState]:
    """Pressure of the contact without tractions, solved from a state."""
    if solver.plan.cells(scene) == (1, 1):
        state = solver.pressure(disc, state)
    else:
        disc, state = solver.pressure_on_subgrid(disc, state)
    if disc.conformal and scene.normal_force is not None:
        rough = replace(solver, tol=max(solver.tol, PLACE_TOL))
        _, state = with_normal_force(disc, rough, state, coupled=False)
    return disc, state


def _check_turn(scene: Scene, disc: Discretisation, state: ContactState) -> None:
    """Refuse a conformal contact over which the reference surface turns too far."""
    surface = scene.surface
    if not isinstance(surface, SampledDistance):
        return
    in_contact = state.pressure > 0
    turns = {
        "inclination": np.ptp(surface.inclination_at(disc.grid)[in_contact.any(axis=1)]),
        "inclination_x": np.ptp(surface.inclination_x_at(disc.grid)[in_contact.any(axis=0)]),
    }
    for name, turn in turns.items():
        if turn > TURN_MAX:
            reason = "no influence numbers hold for a smaller radius of curvature"
            allowed = f"at most {TURN_MAX:g} rad over the contact: {reason}"
            raise SceneError(f"surface.{name}", float(turn), allowed)


def place(
    scene: Scene, solver: ContactSolver, initial_guess: Solution | InitialGuess | None = None
) -> tuple[Grid, Solution | InitialGuess | None]:
    """The first grid: the scene's own, or one across the contact; and the contact, where one was
    found.

    A Hertzian contact has its ellipse, and other bodies begin with that of half-spaces as soft. The
    contact of sampled distances is searched for, or it is where the initial guess has it.
    """
    potential = solver.plan.potential_contact
    known = potential.known
    surface = scene.surface
    if initial_guess is not None and not solver.plan.closed_form:
        if known.explicit:
            return known, initial_guess
        box = contact_grid.contact_box(initial_guess.grid, initial_guess.pressure)
        return potential.around(box), initial_guess
    if known.explicit:
        return known, None
    if isinstance(surface, SampledDistance):
        return _coarse_search(scene, surface, solver)
    if isinstance(surface, Cylinders) and scene.approach is not None:
        half = math.sqrt(2 * surface.R * scene.approach)
        return known.spread((-half, half, -math.inf, math.inf)), None
    hertz = Scene(
        bodies=scene.bodies.softest,
        surface=surface,
        normal_force=scene.normal_force,
        approach=scene.approach,
    ).hertz
    assert hertz is not None
    return known.spread((-hertz.a, hertz.a, -hertz.b, hertz.b)), None


def _coarse_search(
    scene: Scene, surface: SampledDistance, solver: ContactSolver
) -> tuple[Grid, InitialGuess | None]:
    """Grid around the frictionless contact of samples, and that contact: on coarse grids across all
    samples, then on smaller and smaller ones around it.
    """
    plan = solver.plan
    if plan.method not in ("convex", "conic"):
        plan = replace(plan, normal="norm")
    coarse = ContactSolver(plan, SEARCH_TOL, True, solver.stats, deadline=solver.deadline)
    frictionless = scene.without_friction
    # which may lie within the samples
    depth = None if scene.approach is None else surface.reference_depth
    rows = None if scene.line else SEARCH_ELEMENTS
    narrowest = 1 if scene.line else SEARCH_ELEMENTS_ACROSS
    box = surface.box
    last_contact = None
    for _ in range(SEARCH_GRIDS_MAX):
        # the pressure on a coarse grid
        grid = Grid(nx=SEARCH_ELEMENTS, ny=rows, margin=0).spread(box)
        lowest = _lowest_in_elements(surface, grid, depth)
        disc = discretise(replace(frictionless, surface=lowest, grid=grid), grid)
        state = unloaded(grid)
        if last_contact is not None:
            state = state_on(last_contact, disc)
        state = coarse.pressure(disc, state)
        last_contact = InitialGuess.of(disc, state)

        # close enough, or once more with the contact and the elements around it
        across = contact_grid.across(state.pressure)
        if min(across) >= narrowest and max(across) >= SEARCH_ELEMENTS_ACROSS:
            break
        around = contact_grid.contact_box(grid, state.pressure, around=1)
        box = contact_grid.within_samples(around, surface)
    box = contact_grid.contact_box(grid, state.pressure)
    return plan.potential_contact.around(box), last_contact


def adjust(
    plan: Plan,
    disc: Discretisation,
    state: ContactState,
    closer: bool,
    with_tractions: bool = False,
) -> Grid | None:
    """Larger grid where the contact continues outside, or a `closer` one where it has few elements;
    None where it fits.
    """
    potential = plan.potential_contact
    closed_form = plan.closed_form and not with_tractions
    if closed_form and not potential.form.explicit:
        return None  # placed around Hertz's contact
    overlap = outside(disc, state, closed_form)
    if overlap is not None:
        more = 0.0
        if with_tractions:
            more = ROOM
        return potential.enlarged(disc.grid, state.pressure, overlap, more)
    if not closer:
        return None
    return potential.reduced(disc.grid, state.pressure, any_surface=with_tractions)


def _lowest_in_elements(
    surface: SampledDistance, grid: Grid, depth: float | None
) -> SampledDistance:
    """The lowest distance of the samples in each element: no summit falls between the centres of a
    coarse grid.

    A sample on the border of elements counts in all of them: a surface and its mirror image have
    mirrored grids.
    """
    distance = np.clip(surface.distance(grid), -LARGE, LARGE)  # splines oscillate
    x, y = surface.coordinates
    dx, dy = grid.sides
    x0, _, y0, _ = grid.box
    for way_x, way_y in product((-BORDER_ROUNDING, BORDER_ROUNDING), repeat=2):
        ix = np.floor((x - x0) / dx + way_x).astype(int)
        iy = np.floor((y - y0) / dy + way_y).astype(int)
        columns = (ix >= 0) & (ix < grid.nx)
        rows = (iy >= 0) & (iy < grid.rows)
        flat = (iy[rows, None] * grid.nx + ix[None, columns]).ravel()
        np.minimum.at(distance.ravel(), flat, surface.samples[np.ix_(rows, columns)].ravel())
    if grid.line:
        distance = distance[0]
    return SampledDistance(distance, reference_depth=depth)


def finish(
    scene: Scene,
    disc: Discretisation,
    state: ContactState,
    solver: ContactSolver,
) -> Solution:
    """The solution with its certificate; `NotConverged` if it misses the tolerance.

    The residual that counts is that of the problems which the plan poses.
    """
    plan = solver.plan
    _check_rounding(disc, state)
    contact_grid.check_loads(scene, disc.grid, state.pressure > 0, "contact")
    if plan.has_friction:
        disc = with_implied_fields(disc, state, by_slip=True)

    response = ContactResponse(disc, state)
    if computed_when_read(response, plan):
        response = response.without_matrices()
    certificate, residual = _certified(response, solver)

    # the solution in physical units
    if not isinstance(disc.loading.motion, TimeStep):  # the steps of a history share its plan
        plan = _with_reasons_of(state, plan)
    converged = residual <= solver.tol
    solution = solution_of(scene, response, plan, certificate, converged, solver.stats)
    if not solution.converged:
        why = _why_not_converged(solution, state)
        message = f"the residual is not below tol = {solver.tol:.3g}{why}"
        raise NotConverged(message, residual, solution)
    return solution


def _certified(
    response: ContactResponse, solver: ContactSolver
) -> tuple[Certificate | Callable[[], Certificate], float]:
    """Certificate (of a theory, a function that computes it) and residual of the plan's problems; a
    full certificate if that misses the tolerance, as it may show why.
    """
    plan = solver.plan
    # bounds often take longer than the solution, and are not always asked for
    lazily = solver.certify == "auto"
    if lazily and computed_when_read(response, plan):
        # of its own, which goes when it is read
        alone = response.without_matrices()
        return partial(_certificate, alone, plan, "auto", lazily), 0.0
    with solver.stats.stage("certificate"):
        certificate = _certificate(response, plan, solver.certify, lazily)
    residual = _residual_of_plan(plan, response.disc, response.state, certificate)
    if residual > solver.tol and certificate.level != "full" and lazily:
        certificate = _certificate(response, plan, "full", lazily)
    return certificate, residual


def _certificate(response: ContactResponse, plan: Plan, level: str, lazily: bool) -> Certificate:
    """The certificate of the forces that a plan gives."""
    certificate = certificate_of(response, plan.closed_form, level, lazily)
    if not plan.has_moment:
        return certificate.without_moment()
    return certificate


def _check_rounding(disc: Discretisation, state: ContactState) -> None:
    """Refuse distances from a level so far away that rounding changes the approach."""
    approach = state.approach * disc.scales.displacement
    base = disc.base
    if EPS * abs(base) > DISTANCE_ROUNDING_MAX * abs(approach):
        unit = np.spacing(abs(base))
        rounded = f"it is rounded to {unit:.1g}, and the bodies approach by only {approach:.3g}"
        allowed = f"counted from a level near the contact, less a constant: {rounded}"
        raise SceneError("surface.h", base, allowed)


def _residual_of_plan(
    plan: Plan, disc: Discretisation, state: ContactState, certificate: Certificate
) -> float:
    """The residual of the problems that a plan poses; theories are formulas."""
    if not plan.has_friction or plan.theory is not None:
        return 0.0 if plan.closed_form else certificate.normal_residual
    # also where friction is zero all over the contact, and there is nothing but pressure
    if plan.closed_form:
        return certificate.tangential_residual
    # which poses the normal problem without tractions; the certificate has the rest
    if plan.coupling == "johnson":
        normal = normal_residual(
            disc.normal_problem(), state.pressure.ravel(), np.array([state.approach])
        )
        return float(np.max([normal, certificate.tangential_residual]))  # NaN if one is NaN
    return certificate.residual


def _with_reasons_of(state: ContactState, plan: Plan) -> Plan:
    """Plan with the reasons for solvers that replaced others."""
    if not any(state.reasons.values()):
        return plan
    reasons = {
        problem: f"{plan.reasons[problem]}; {why}" for problem, why in state.reasons.items() if why
    }
    return replace(plan, reasons=plan.reasons | reasons)


def _why_not_converged(solution: Solution, state: ContactState) -> str:
    if state.passes:
        change = state.passes[-1][0]
        best = f"; this is the best of {len(state.passes)} passes"
        why = f"{best}, the last of which changed {change:.1e}"
        if state.pass_count >= PASSES_MAX:
            why += f"; no more than {PASSES_MAX} passes are made in all loops together"
        return why
    words = [
        f"{getattr(solution.plan, problem)} says {word!r}"
        for problem, word in solution.status.items()
        if word
    ]
    if solution.certificate.level == "full":
        words.append(no_guarantee(solution))
    return "".join(f"; {word}" for word in words if word)
