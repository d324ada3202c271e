"""Defect correction: what a field on parts lacks of the continuum's slip is
added to the coarse problem's.

Its error is estimated from half as many elements. Other scenes, methods and
grids are refused before any work.
"""

from __future__ import annotations

import time
from dataclasses import replace
from typing import Any

import numpy as np

from varcontact import checks
from varcontact.discrete.contact_grid import across, known_grid, sampled, within
from varcontact.discrete.discretisation import Discretisation, discretise
from varcontact.discrete.loading import PreviousStep
from varcontact.discrete.state import ContactState, means, unloaded
from varcontact.discrete.stick_slip import unit_slip
from varcontact.elasticity.operators import table_bytes
from varcontact.errors import Saturated, SceneError
from varcontact.results.error_estimate import ErrorEstimate, Refinement, Solve
from varcontact.results.plan import Plan
from varcontact.results.quantities_of_interest import creepage_names, units
from varcontact.results.solution import Solution
from varcontact.scene.grid import Grid
from varcontact.scene.motion import Steady
from varcontact.scene.scene import Scene
from varcontact.solvers.interface import SolveStats
from varcontact.solving.contact_solver import ContactSolver, contact
from varcontact.solving.defect_correction.fine_grid import PARTS, FineGrid, held_behind, resultants
from varcontact.solving.friction_law import coefficient
from varcontact.system.process import SMALLER, need

CONTINUUM = "continuum"
"""What can be asked for."""
LEAST = 8
"""Fewest elements across the contact each way: with fewer the estimate, from half of them, says nothing."""
FIELDS = 120
"""Numbers for each part, about: tractions whose displacement is known, and what parts miss of it."""
LOOSE = 1e-5
"""Residual of all coarse solves but the last: parts of a hundred of what a pass changes."""
DAMPING = np.array([1.0, 1.0, 0.7, 0.7])
"""Part of its defect that each pass adds: later ones would move to and fro."""
LATE = 2
"""Passes whose changes the estimate counts as a whole: those that are damped."""


def check_refine(scene: Scene, plan: Plan, refine: Any, chosen: bool, start: str | Solution | None) -> None:
    """Refuse defect correction where it does not apply; `chosen`: the grid is chosen for an accuracy or a time."""
    kind = checks.choice("refine", refine, (CONTINUUM,))
    reason, instead = "", "give accuracy in place of refine and of a grid"
    if scene.motion is None or scene.frictionless:
        reason = "without a motion or without friction there are no tractions to correct"
    elif not (plan.closed_form and isinstance(scene.motion, Steady)) or scene.line or scene.third_body is not None:
        where = "like bodies without a third one, under Hertz's pressure in closed form, not in line contact"
        reason = f"it is for steady rolling of {where}; {instead}"
    elif scene.no_slip:
        known = "forces under Hertz's pressure are known in closed form (varcontact.reference.no_slip_ellipse)"
        reason = f"with infinite friction {known}"
    elif plan.theory is not None:
        reason = f"it corrects exact methods, not the theory {plan.tangential!r}"
    elif scene.edge != "centres":
        reason = f'with grid.edge = "{scene.edge}" it gains less, or loses'
    if isinstance(start, Solution):
        reason = 'the estimate takes half as many elements, on which no start is known; give start = "stick" or "slip"'
    if chosen:
        reason = "it corrects on the scene's own grid, and accuracy or time_budget choose one"
    if reason:
        raise SceneError("refine", kind, f"left out: {reason}")
    grid, hertz = known_grid(scene), scene.hertz
    assert hertz is not None
    (dx, dy), parts = grid.sides, PARTS * PARTS * grid.size
    nx, ny = 2 * hertz.a / dx, 2 * hertz.b / dy
    if min(nx, ny) < LEAST * (1 - 1e-9):
        allowed = f"one with at least {LEAST} elements across the contact each way for refine, not {nx:.3g} by {ny:.3g}"
        raise SceneError("grid", scene.grid, allowed)
    size = 8 * table_bytes(PARTS * grid.rows, PARTS * grid.nx, 1) + 8 * FIELDS * parts
    need("the parts of the elements", size, SMALLER)


def loosely(solver: ContactSolver) -> ContactSolver:
    """The same methods, as exact as the solves before the last need to be."""
    return replace(solver, tol=max(solver.tol, LOOSE), refined=False)


def run(
    scene: Scene, disc: Discretisation, state: ContactState, solver: ContactSolver
) -> tuple[Discretisation, ContactState, Refinement]:
    """The corrected problem on the elements, its solution to the solver's tolerance, and the field on parts."""
    with solver.stats.stage("refinement"):
        corrected, state, found = defect_correct(disc, state, loosely(solver), solver)
    with solver.stats.stage("error estimate"):
        coarser = _on_half_as_many(scene, disc, solver)
    # the error: the difference from half as many elements, what late passes changed, or what the field misses of a
    # prescribed force; the components of force, and of creepage, share the length of a vector
    motion, last = disc.loading.motion, found.forces[-1]
    assert motion is not None
    prescribed = motion.Fx, motion.Fy
    wanted = [F if given is None else given for F, given in zip(last, (*prescribed, None), strict=True)]
    changes = np.abs(np.diff(np.hstack([found.forces, found.creepages]), axis=0)) / DAMPING[:, None]
    late = changes[-LATE:].max(axis=0)  # without damping
    of_forces = np.max([np.abs(last - coarser.forces[-1]), late[:3], np.abs(last - wanted)], axis=0)
    of_creepages = np.maximum(np.abs(found.creepages[-1] - coarser.creepages[-1]), late[3:])
    estimate = np.array([*(2 * [np.hypot(*of_forces[:2])]), of_forces[2]])
    of_creepages = np.where([given is None for given in prescribed], 0.0, np.hypot(*of_creepages))
    return corrected, state, replace(found, estimate=estimate, creepage_estimate=of_creepages)


def _on_half_as_many(scene: Scene, disc: Discretisation, solver: ContactSolver) -> Refinement:
    """The same on about half as many elements across the contact each way."""
    grid, hertz, (dx, dy) = disc.grid, scene.hertz, disc.grid.sides
    assert hertz is not None
    coarser = Grid(nx=round(hertz.a / dx), ny=round(hertz.b / dy), margin=1)
    coarser = within(coarser.spread((-hertz.a, hertz.a, -hertz.b, hertz.b)), scene.surface)
    friction = scene.friction
    if isinstance(friction, np.ndarray):
        friction = sampled(grid, friction.reshape(grid.shape), coarser)
    scene = replace(scene, grid=coarser, friction=friction)
    loose = replace(loosely(solver), stats=SolveStats())
    other = discretise(scene, coarser)
    try:
        state = contact(other, loose, loose.pressure(other, unloaded(coarser)))
        return defect_correct(other, state, loose, replace(loose, tol=solver.tol))[-1]
    finally:
        other.operators.forget()


def refined(solution: Solution, found: Refinement) -> Solution:
    """The solution with its field on parts, whose forces and creepages are its values, with their estimated errors."""
    names, scales = ("Fx", "Fy", "Mz", *creepage_names(solution)[:2]), units(solution)
    scales = {name: unit for name, unit in scales.items() if unit > 0}  # without load there is none
    last, estimates = [*found.forces[-1], *found.creepages[-1]], [*found.estimate, *found.creepage_estimate]
    known = [name for name in names if name[0] in "FM" or name in scales]
    values = {name: float(value) for name, value in zip(names, last, strict=True) if name in known}
    errors = {name: float(e) / scales[name] for name, e in zip(names, estimates, strict=True) if name in scales}
    late = f"what late ones of {found.passes} passes changed"
    how = f"no bound: the difference from half as many elements across the contact, or {late}"
    nx, ny = across(solution.pressure)
    bars = {name: error * scales[name] for name, error in errors.items()}
    estimate = ErrorEstimate(values, errors, how, (Solve(nx, ny, sum(found.seconds)),), bars=bars)
    density = means(found.power_density, found.cells)
    return replace(solution, refinement=found, power_density=density, error_estimate=estimate)


def defect_correct(
    coarse: Discretisation, state: ContactState, loose: ContactSolver, last: ContactSolver
) -> tuple[Discretisation, ContactState, Refinement]:
    """Correct a coarse solution of steady rolling under Hertz's pressure: `loose` solves all passes but the last.

    Where forces are prescribed, those of the coarse problem are changed by what its elements carry more than the field.
    Under a law of friction the field has the coefficients that the law has at the corrected slip of the elements.
    """
    fine, disc = FineGrid(coarse, state.pressure), coarse
    field = fine.field(state.traction, _friction(disc, state))
    correction, excess = np.zeros(state.traction.shape), np.zeros(2)
    scale, seconds = coarse.scales.pressure, []
    forces, rigid = [resultants(state.traction * scale, coarse.grid)], [state.rigid]
    motion, rolled = coarse.loading.motion, unit_slip(coarse)
    assert isinstance(motion, Steady)
    for k, damping in enumerate(DAMPING):
        started = time.perf_counter()
        # what the elements' slip lacks of the continuum's under the field, in the contact
        own = coarse.known_shift + state.rigid[:, None, None] + coarse.tangential_operator.apply(state.traction)
        lacking = fine.on_elements(fine.shift(field, state.rigid), field.bound) - own
        bound = field.friction * fine.pressure
        correction = correction + damping * (held_behind(lacking, state.traction, bound) * (bound > 0) - correction)
        carried_more = resultants(state.traction * scale, coarse.grid) - fine.forces(field)
        excess = excess + damping * (carried_more[:2] / coarse.scales.force - excess)
        # the coarse problem with its rigid shift and prescribed forces corrected
        given = zip((motion.Fx, motion.Fy), excess * coarse.scales.force, strict=True)
        Fx, Fy = (None if force is None else float(force + more) for force, more in given)
        previous = PreviousStep(0.0 - correction, np.zeros(2))
        disc = coarse.with_loading(motion=replace(motion, Fx=Fx, Fy=Fy), previous_step=previous)
        try:
            state = contact(disc, last if k + 1 == len(DAMPING) else loose, state)
        except Saturated as beyond:
            allowed = f"left out: so near to saturation the corrected problem cannot carry the force ({beyond})"
            raise SceneError("refine", CONTINUUM, allowed) from None
        field = fine.field(state.traction, _friction(disc, state))
        forces.append(fine.forces(field))
        rigid.append(state.rigid)
        seconds.append(time.perf_counter() - started)
    found = Refinement(
        kind=CONTINUUM,
        grid=fine.grid,
        traction=field.traction * scale,
        slip=fine.shift(field, state.rigid) * (field.bound > 0) / rolled,
        correction=correction / rolled,
        share=np.ones(disc.grid.shape),
        forces=np.array(forces),
        creepages=motion.rigid[:2] + np.array(rigid) / rolled,
        estimate=np.zeros(3),
        creepage_estimate=np.zeros(2),
        seconds=tuple(seconds),
    )
    return disc, state, found


def _friction(disc: Discretisation, state: ContactState) -> np.ndarray:
    """Coefficients on the elements, (ny, nx); under a law those found, continued beyond the contact."""
    if disc.loading.law is not None:
        from scipy.ndimage import distance_transform_edt

        nearest = distance_transform_edt(state.pressure == 0, return_distances=False, return_indices=True)
        return coefficient(disc, state)[tuple(nearest)]
    return np.broadcast_to(np.asarray(disc.loading.coefficient, dtype=float), disc.grid.shape)
