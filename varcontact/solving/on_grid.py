"""A scene on its own grid: a grid that holds the contact, the contact on it, and its certified
solution.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from itertools import product

import numpy as np

from varcontact.checks import LARGE
from varcontact.discrete import contact_grid
from varcontact.discrete.certificate import certificate_of
from varcontact.discrete.discretisation import Discretisation, discretise
from varcontact.discrete.operators import Operators
from varcontact.discrete.penetration import outside
from varcontact.discrete.residuals import normal_residual
from varcontact.discrete.state import ContactState, unloaded
from varcontact.discrete.stick_slip import unit_slip
from varcontact.errors import NotConverged, SceneError
from varcontact.results.physical import solution_of
from varcontact.results.report import no_guarantee
from varcontact.results.solution import Solution
from varcontact.scene.bodies import BodyPair
from varcontact.scene.grid import Grid
from varcontact.scene.motion import Steady, TimeStep
from varcontact.scene.scene import Scene
from varcontact.scene.surfaces import Cylinders, SampledDistance
from varcontact.solvers.registry import MATRIX_FREE
from varcontact.solving.contact_solver import ContactSolver, contact, with_normal_force
from varcontact.solving.coupling import PASSES_MAX
from varcontact.solving.friction_law import coefficient, weakening
from varcontact.solving.options import SolveOptions
from varcontact.solving.surface_noise import noise_warning
from varcontact.system.process import lazy_property

FOUND = 1e-4
"""Residual of a pressure that only tells where the contact is, before it is solved for on parts of
the elements."""
ROUNDING = 1e-9
"""Part of an element by which a sample may miss its border and still lie on it."""
LOOK, LOOKS = 24, 60
"""Elements across on a grid by which a contact is looked for, and the most looks."""
ACROSS = 8
"""Elements across the contact with which a look is close enough."""
GRIDS, CLOSER = 20, 3
"""The most grids that are tried, and how often one that lies closer around the contact."""
ROOM = 0.1
"""Room that a contact is given where tractions move it, by its length: only the next elements are
seen."""
WIDEST = 2.0
"""How far the reference surface may turn over a conformal contact [rad]."""
ROUNDED = 1e-3
"""The part of the approach that the rounding of distances may be."""


@dataclass(frozen=True, eq=False)
class ContactOnGrid:
    """A contact with pressure and tractions that has not been judged yet."""

    scene: Scene
    disc: Discretisation
    state: ContactState
    solver: ContactSolver

    @classmethod
    def of(
        cls,
        scene: Scene,
        options: SolveOptions,
        near: Solution | Near | None = None,
        known: Operators | None = None,
    ) -> ContactOnGrid:
        """See `solve_on_grid`; operators that are `known` serve again."""
        solver = options.solver(scene)
        return cls(scene, *solve_contact(scene, solver, known, near=near), solver)

    def loaded(
        self, scene: Scene, options: SolveOptions, near: Solution | Near | None
    ) -> ContactOnGrid | None:
        """With the tractions to begin with of the same scene with friction, if these leave the
        pressure as it is.
        """
        solver = options.solver(scene)
        disc = discretise(scene, self.disc.grid, self.disc.operators)
        exact = (
            self.solver.plan.normal == solver.plan.normal == "norm" and self.disc.subgrid is None
        )
        if not exact or solver.plan.coupling != "none":
            return None
        state = self.state if near is None else _with_tractions_of(near, disc, self.state)
        return ContactOnGrid(scene, disc, state, solver)

    def settled(self) -> ContactOnGrid:
        """With the tractions that go with the pressure."""
        return replace(self, state=contact(self.disc, self.solver, self.state))

    @lazy_property
    def near(self) -> Near:
        """Where the contact in a similar scene begins."""
        return Near.of(self.disc, self.state)

    @property
    def force(self) -> np.ndarray:
        """Fx, Fy and the normal force, physical."""
        fields = (self.near.traction, self.near.pressure)
        surface = self.scene.surface
        if isinstance(surface, SampledDistance):
            fields = surface.along_axes(self.disc.grid, *fields)
        return np.array([*fields[0].sum(axis=(1, 2)), fields[1].sum()]) * self.disc.grid.area

    def solution(self) -> Solution:
        solution = finish(self.scene, self.disc, self.state, self.solver)
        if not isinstance(self.scene.surface, SampledDistance):
            return solution
        warning = noise_warning(self.scene, self.disc, self.state, self.solver)
        return replace(solution, warnings=(warning,)) if warning else solution


def solve_on_grid(
    scene: Scene, options: SolveOptions, near: Solution | Near | None = None
) -> Solution:
    """A scene, which is no history, on its own grid: from the plan to the certified solution.

    A solution `near` is of the same scene on another grid.
    """
    found = ContactOnGrid.of(scene, options, near)
    try:
        return (
            found.solution()
            if options.final
            else finish(scene, found.disc, found.state, found.solver)
        )
    finally:
        found.disc.operators.forget()


def solve_contact(
    scene: Scene,
    solver: ContactSolver,
    known: Operators | None = None,
    before: np.ndarray | None = None,
    near: Solution | Near | None = None,
) -> tuple[Discretisation, ContactState]:
    """The contact on a grid that holds it: where it goes on outside a grid of our choice, that is
    enlarged.

    The contact without tractions settles the grid; of unlike bodies it is then that with tractions.
    Operators that are `known` serve again on the same lattice. Tractions of like bodies begin from
    those `before`, on as many elements. A solution `near`, on another grid, gives the place of the
    contact, its pressure and its tractions. In conformal contact the force along the normal of the
    plane is prescribed: the sum of the pressures is sought with which they and the tractions bear
    it.
    """
    coupled = solver.plan.coupling != "none"
    conformal = False
    with solver.stats.stage("grid"):
        grid, found = place(scene, solver, near)
    moved = 0
    for attempt in range(GRIDS):
        disc = discretise(scene, grid, known)
        known = disc.operators
        conformal = disc.conformal
        state = unloaded(grid) if found is None else _on(found, disc)
        if solver.plan.cells(scene) == (1, 1):
            state = solver.pressure(disc, state)
        else:
            disc, state = solver.pressure_on_subgrid(disc, state)
        if conformal and scene.normal_force is not None:
            _, state = with_normal_force(
                disc, replace(solver, tol=max(solver.tol, FOUND)), state, coupled=False
            )
        with solver.stats.stage("grid"):
            settled = coupled and moved > 0
            wanted = (
                None
                if settled
                else adjust(scene, disc, state, attempt < CLOSER, solver.plan.closed_form)
            )
        if wanted is None:
            if near is not None:
                state = _with_tractions_of(near, disc, state)
            elif before is not None and solver.plan.has_friction and disc.K == 0:
                state = (
                    replace(state, traction=before)
                    if before.shape == state.traction.shape
                    else state
                )
            state = contact(disc, solver, state)
            if coupled:
                with solver.stats.stage("grid"):
                    wanted = adjust(scene, disc, state, 0 < moved <= CLOSER, with_tractions=True)
            moved += 1
        if wanted is None:
            break
        known.forget()
        grid = wanted
        found = Near.of(disc, state)
    else:
        message = (
            "grid: no potential contact was found that holds the contact; give an explicit grid"
        )
        message += contact_grid.if_noise(scene, grid)
        raise SceneError("grid", scene.grid, "explicit", message=message)
    if conformal and scene.normal_force is not None:
        disc, state = with_normal_force(disc, solver, state, coupled)
    if conformal and isinstance(scene.surface, SampledDistance):
        angles = scene.surface.inclination_at(disc.grid)[state.pressure.any(axis=1)]
        turn = float(np.ptp(angles)) if angles.size else 0.0
        if turn > WIDEST:
            reason = "no influence numbers hold for a smaller radius of curvature"
            raise SceneError(
                "surface.inclination", turn, f"at most {WIDEST:g} rad over the contact: {reason}"
            )
    return disc, state


def place(
    scene: Scene, solver: ContactSolver, near: Solution | Near | None = None
) -> tuple[Grid, Solution | Near | None]:
    """The first grid: the scene's own, or one across the contact, and the contact, where one was
    looked for.

    A Hertzian contact has its ellipse, and other bodies begin with that of half-spaces as soft. For
    sampled distances looks at the frictionless contact tell, first across all samples, then closer
    and closer; or a solution `near`.
    """
    spec = contact_grid.known_grid(scene)
    surface = scene.surface
    if near is not None and not solver.plan.closed_form:
        if spec.explicit:
            return spec, near
        return contact_grid.within(
            spec.spread(contact_grid.contact_box(near.grid, near.pressure)), surface
        ), near
    if spec.explicit:
        return spec, None
    if not isinstance(surface, SampledDistance):
        assert isinstance(scene.bodies, BodyPair)
        if isinstance(surface, Cylinders) and scene.approach is not None:
            half = math.sqrt(2 * surface.R * scene.approach)
            return spec.spread((-half, half, -math.inf, math.inf)), None
        bodies = scene.bodies.softest
        force = scene.normal_force
        approach = scene.approach
        hertz = Scene(bodies=bodies, surface=surface, normal_force=force, approach=approach).hertz
        assert hertz is not None
        return spec.spread((-hertz.a, hertz.a, -hertz.b, hertz.b)), None
    plan = solver.plan if solver.plan.method == "convex" else replace(solver.plan, normal="norm")
    look = ContactSolver(plan, 1e-6, True, solver.stats, deadline=solver.deadline)
    box = surface.box
    last = None
    relaxes = scene.bodies.relaxes
    bare = replace(
        scene,
        motion=Steady(speed=scene.speed) if relaxes else None,
        friction=0.0 if relaxes else None,
    )
    # which may lie within the samples
    depth = None if scene.approach is None else surface.reference_depth
    for _ in range(LOOKS):
        grid = Grid(nx=LOOK, ny=None if scene.line else LOOK, margin=0).spread(box)
        disc = discretise(
            replace(bare, surface=_lowest_in_elements(surface, grid, depth), grid=grid), grid
        )
        state = look.pressure(disc, unloaded(grid) if last is None else _on(last, disc))
        last = Near.of(disc, state)
        columns_and_rows = contact_grid.across(state.pressure)
        if (
            min(columns_and_rows) >= (1 if scene.line else ACROSS)
            and max(columns_and_rows) >= ACROSS
        ):
            break
        box = contact_grid.clipped(
            contact_grid.contact_box(grid, state.pressure, around=1), surface
        )
    return contact_grid.within(
        spec.spread(contact_grid.contact_box(grid, state.pressure)), surface
    ), last


def adjust(
    scene: Scene,
    disc: Discretisation,
    state: ContactState,
    closer: bool,
    closed_form: bool = False,
    with_tractions: bool = False,
) -> Grid | None:
    """A larger grid where the contact goes on outside, or a `closer` one where it has few elements;
    None: it fits.
    """
    if closed_form and not contact_grid.given_grid(scene).explicit:
        return None  # placed around Hertz's contact
    overlap = outside(disc, state, closed_form)
    if overlap is not None:
        return contact_grid.enlarged(
            scene, disc.grid, state.pressure, overlap, ROOM * with_tractions
        )
    return (
        contact_grid.fitted(scene, disc.grid, state.pressure, any_surface=with_tractions)
        if closer
        else None
    )


@dataclass(frozen=True, eq=False)
class Near:
    """A contact that was found on a grid, physical: where that on the next one is found from."""

    grid: Grid
    pressure: np.ndarray
    approach: float
    traction: np.ndarray
    creepage: tuple[float, ...]

    @classmethod
    def of(cls, disc: Discretisation, state: ContactState) -> Near:
        scales = disc.scales
        motion = disc.loading.motion
        creepage = (0.0, 0.0) if motion is None else state.rigid / unit_slip(disc)
        approach = state.approach * scales.displacement + disc.base
        fields = state.pressure * scales.pressure, approach, state.traction * scales.pressure
        return cls(disc.grid, *fields, tuple(creepage))


def _on(near: Solution | Near, disc: Discretisation) -> ContactState:
    """The pressure and the approach of a contact on another grid."""
    pressure = (
        contact_grid.interpolated(near.grid, near.pressure[None], disc.grid)[0]
        / disc.scales.pressure
    )
    approach = (
        (near.approach - disc.base) / disc.scales.displacement
        if np.isfinite(near.approach)
        else 0.0
    )
    return replace(unloaded(disc.grid), pressure=pressure, approach=approach)


def _with_tractions_of(
    near: Solution | Near, disc: Discretisation, state: ContactState
) -> ContactState:
    """The state with the tractions of a solution on another grid; under a law of friction they
    choose no branch.
    """
    motion = disc.loading.motion
    if motion is None or disc.loading.law is not None:
        return state
    traction = contact_grid.interpolated(near.grid, near.traction, disc.grid) / disc.scales.pressure
    found = np.nan_to_num(near.creepage[:2]) * unit_slip(disc)
    given = [motion.Fx is None, motion.Fy is None]
    return replace(
        state, traction=traction * (state.pressure > 0), rigid=np.where(given, 0.0, found)
    )


def _lowest_in_elements(
    surface: SampledDistance, grid: Grid, depth: float | None
) -> SampledDistance:
    """The lowest distance known in each element: no summit falls between the centres of a coarse
    look.

    A sample on the border of elements counts in all of them: a surface and its mirror image have
    mirrored grids.
    """
    distance = np.clip(surface.distance(grid), -LARGE, LARGE)  # splines swing
    x, y = surface.coordinates
    (dx, dy), (x0, _, y0, _) = grid.sides, grid.box
    for way_x, way_y in product((-ROUNDING, ROUNDING), repeat=2):
        ix = np.floor((x - x0) / dx + way_x).astype(int)
        iy = np.floor((y - y0) / dy + way_y).astype(int)
        columns = (ix >= 0) & (ix < grid.nx)
        rows = (iy >= 0) & (iy < grid.rows)
        flat = (iy[rows, None] * grid.nx + ix[None, columns]).ravel()
        np.minimum.at(distance.ravel(), flat, surface.samples[np.ix_(rows, columns)].ravel())
    return SampledDistance(distance[0] if grid.line else distance, reference_depth=depth)


def finish(
    scene: Scene,
    disc: Discretisation,
    state: ContactState,
    solver: ContactSolver,
    before: Solution | None = None,
) -> Solution:
    """The solution, after a step `before`, with its certificate; `NotConverged` if it misses the
    tolerance.

    The residual that counts is that of the problems which the plan poses.
    """
    plan = solver.plan
    tol = solver.tol
    approach = state.approach * disc.scales.displacement
    if np.finfo(float).eps * abs(disc.base) > ROUNDED * abs(approach):
        rounded = f"it is rounded to {np.spacing(abs(disc.base)):.1g}, and the bodies approach by only {approach:.3g}"
        raise SceneError(
            "surface.h",
            disc.base,
            f"counted from a level near the contact, less a constant: {rounded}",
        )
    law = disc.loading.law
    in_time = isinstance(disc.loading.motion, TimeStep)
    if law is not None and plan.has_friction:
        disc = disc.under(friction=coefficient(disc, state))
    lazily = plan.tangential in MATRIX_FREE and solver.certify == "auto"
    with solver.stats.stage("certificate"):
        certificate = certificate_of(disc, state, plan.closed_form, solver.certify, lazily)
    residual = certificate.residual
    if not plan.has_friction or plan.theory is not None:  # theories are formulas
        residual = 0.0 if plan.closed_form else certificate.normal_residual
    # also where friction is zero all over the contact, and there is nothing but pressure
    elif plan.closed_form:
        residual = certificate.tangential_residual
    # which poses the normal problem without tractions; the certificate has the rest
    elif plan.coupling == "johnson":
        alone = normal_residual(
            disc.normal_problem(), state.pressure.ravel(), np.array([state.approach])
        )
        residual = float(np.max([alone, certificate.tangential_residual]))  # NaN where one is
    # it may tell why
    if residual > tol and certificate.level != "full" and solver.certify == "auto":
        certificate = certificate_of(disc, state, plan.closed_form, "full", lazily)
    if not plan.has_moment:
        certificate = certificate.without_moment()
    if not in_time:  # the steps of a history share its plan
        found = {
            problem: f"{plan.reasons[problem]}; {why}"
            for problem, why in state.reasons.items()
            if why
        }
        plan = replace(plan, reasons=plan.reasons | found)
    stats = solver.stats
    solution = solution_of(
        scene, disc, plan, state, certificate, residual <= tol, stats.timing, stats.calls
    )
    if law is not None and plan.has_friction and (in_time or law.memory_distance > 0):
        solution = replace(solution, weakening=weakening(disc, before, solution))
    if not solution.converged:
        words = [
            f"{getattr(plan, problem)} says {word!r}"
            for problem, word in solution.status.items()
            if word
        ]
        if certificate.level == "full":
            words.append(no_guarantee(solution))
        if state.passes:
            change = state.passes[-1][0]
            best = f"this is the best of {len(state.passes)} passes"
            words = [f"{best}, the last of which changed {change:.1e}"]
            if state.pass_count >= PASSES_MAX:
                words.append(f"no more than {PASSES_MAX} passes are made in all loops together")
        why = "".join(f"; {word}" for word in words if word)
        raise NotConverged(f"the residual is not below tol = {tol:.3g}{why}", residual, solution)
    return solution
