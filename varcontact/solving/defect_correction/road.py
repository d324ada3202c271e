"""Defect correction of a scene: the passes, and the estimate of its error."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np

from varcontact.discrete.contact_grid import across, contact_box, within
from varcontact.discrete.discretisation import Discretisation, discretise
from varcontact.discrete.state import ContactState, unloaded
from varcontact.discrete.stick_slip import unit_slip
from varcontact.errors import Saturated, SceneError
from varcontact.results.error_estimate import ErrorEstimate, Solve
from varcontact.results.quantities_of_interest import creepage_names, units, units_of
from varcontact.results.refinement import Refinement
from varcontact.results.solution import Solution
from varcontact.scene.grid import Grid
from varcontact.scene.motion import Steady, TimeStep
from varcontact.scene.scene import Scene
from varcontact.scene.surfaces import Ellipse, Paraboloids, SampledDistance
from varcontact.solvers.statistics import SolveStats
from varcontact.solving.contact_solver import ContactSolver, contact
from varcontact.solving.defect_correction.check import KINDS, check_count
from varcontact.solving.defect_correction.cliffs import check_cliffs
from varcontact.solving.defect_correction.parts import Brought
from varcontact.solving.defect_correction.passes import PARTS, Corrected, defect_corrected
from varcontact.solving.defect_correction.pressed import within_parts

ROUGH = 1e-5
"""Residual of all coarse solves but the last: parts of a hundred of what a pass changes."""
SAFETY = 2.0
"""By how much estimates exceed the difference from half as many elements where nothing slips: errors of two grids may
happen to be alike."""
ROUNDING = 1e-12
"""Shares of an element below this are due to rounding."""


def refined(
    scene: Scene, disc: Discretisation, state: ContactState, steps: ContactSolver
) -> tuple[Corrected, Refinement]:
    """A coarse solution after the passes, and the record of these with an estimate of the error.

    Parameters
    ----------
    scene : Scene
    disc : Discretisation
        Of the coarse grid.
    state : ContactState
        Its solution.
    steps : Steps

    Returns
    -------
    Corrected
        Its `state` is solved to the tolerance of `steps`.
    Refinement
        In physical units.

    Raises
    ------
    SceneError
        For too few elements across the contact, or samples with a cliff in it.
    """
    if scene.hertz is None:
        check_count(scene, across(state.pressure))
    check_cliffs(disc, state)
    with steps.stats.stage("refinement"):
        finer = finer_pressure(scene, disc, steps)
        found = passed(disc, state, roughly(steps), steps, finer)
    with steps.stats.stage("error estimate"):
        coarser = corrected_on(*_halved(from_a_depth(scene, disc), disc, state), steps)
    return found, recorded(found, coarser.forces[-1], coarser.creepages[-1])


def recorded(found: Corrected, forces: np.ndarray, creepages: np.ndarray) -> Refinement:
    """The record of the passes, with the difference from other loads as the estimate, or what late passes changed.

    Where a force is prescribed, what the field carries more or less counts, too. The two components of force, or of
    creepage, have one estimate: the length of a vector.

    Parameters
    ----------
    found : Corrected
    forces : ndarray, shape (3,)
        Fx, Fy and Mz on half as many elements, physical.
    creepages : ndarray, shape (2,)
        vx and vy there.

    Returns
    -------
    Refinement
        In physical units.
    """
    rolled, carried, last = unit_slip(found.disc), found.disc.loading.previous_step, found.forces[-1]
    assert carried is not None
    prescribed = [getattr(found.parts.disc.loading.motion, name) for name in ("Fx", "Fy")]
    posed = [F if given is None else given for F, given in zip(last, [*prescribed, None], strict=True)]
    of_forces = np.max([np.abs(last - forces), found.unsettled(found.forces), np.abs(last - posed)], axis=0)
    of_creepages = np.maximum(np.abs(found.creepages[-1] - creepages), found.unsettled(found.creepages))
    if found.stuck:
        of_creepages, of_forces = SAFETY * of_creepages, SAFETY * of_forces
        if posed[:2] == list(last[:2]) and not found.disc.line:  # given forces are met, whatever the moment is
            arm = found.disc.scales.length * math.sqrt(math.prod(found.parts.axes))
            size = np.hypot(np.hypot(*of_forces[:2]), of_forces[2] / arm)
            of_forces = np.array([size, 0.0, size * arm])
    return Refinement(
        kind=KINDS[0],
        grid=found.parts.grid,
        traction=found.traction * found.disc.scales.pressure,
        slip=found.shift / rolled,
        correction=-carried.displacement / rolled,
        share=found.share,
        forces=found.forces,
        creepages=found.creepages,
        estimate=np.array([*(2 * [np.hypot(*of_forces[:2])]), of_forces[2]]),
        creepage_estimate=np.where([given is None for given in prescribed], 0.0, np.hypot(*of_creepages)),
        seconds=found.seconds,
    )


def estimated(solution: Solution, found: Refinement) -> ErrorEstimate:
    """What a refinement says of a solution's forces: those of its field, with their estimated errors.

    Parameters
    ----------
    solution : Solution
    found : Refinement
    """
    names = ("Fx", "Fy", "Mz", *creepage_names(solution)[:2])
    afloat = [name for name, creepage in zip(names[3:], solution.creepage, strict=False) if math.isnan(creepage)]
    scales = _of_the_force(solution, found) if solution.scene.no_slip else units(solution) | units_of(solution, afloat)
    scales = {name: unit for name, unit in scales.items() if unit > 0}  # without load there is none
    last, open_ended = [*found.forces[-1], *found.creepages[-1]], [*found.estimate, *found.creepage_estimate]
    known = [name for name in names if name[0] in "FM" or (name in scales and name not in afloat)]
    values = {name: float(value) for name, value in zip(names, last, strict=True) if name in known}
    errors = {name: float(e) / scales[name] for name, e in zip(names, open_ended, strict=True) if name in scales}
    how = (
        "no bound: the difference from half as many elements across the contact, or what late ones of "
        f"{found.passes} passes changed"
    )
    if isinstance(solution.motion, TimeStep):
        how += "; or that of the step before, as far as its particles are still in contact"
    if set(afloat) & set(errors):
        how += f"; without surface.reference_depth {' and '.join(afloat)} counts from a depth that is left open"
    nx, ny = across(solution.pressure)
    bars = {name: error * scales[name] for name, error in errors.items()}
    return ErrorEstimate(values, errors, how, (Solve(nx, ny, sum(found.seconds)),), bars=bars)


def _of_the_force(solution: Solution, found: Refinement) -> dict[str, float]:
    """Units of errors without a friction limit: the force itself, that times sqrt(ab), and creepages that are found."""
    size, hertz = float(np.hypot(*found.force)), solution.scene.hertz
    assert hertz is not None and isinstance(solution.motion, Steady)
    moment = {} if solution.scene.line else {"Mz": size * float(np.sqrt(hertz.a * hertz.b))}
    creepage = float(np.hypot(*found.creepages[-1]))
    forces = (solution.motion.Fx, solution.motion.Fy)
    names = [name for name, force in zip(creepage_names(solution), forces, strict=False) if force is not None]
    return {"Fx": size, "Fy": size} | moment | dict.fromkeys(names, creepage)


def corrected_on(scene: Scene, grid: Grid, steps: ContactSolver) -> Corrected:
    """The corrected solution on another grid, as fast as it is had: without certificate.

    Parameters
    ----------
    scene : Scene
        That `check_refine` lets pass.
    grid : Grid
        Explicit.
    steps : Steps

    Returns
    -------
    Corrected
    """
    rough = replace(roughly(steps), stats=SolveStats())
    disc = discretise(replace(scene, grid=grid), grid, coupled=False)
    try:
        state = contact(disc, rough, rough.pressure(disc, unloaded(grid)))
        return passed(disc, state, rough, replace(rough, tol=steps.tol), finer_pressure(scene, disc, rough))
    finally:
        disc.operators.forget()


def passed(
    disc: Discretisation,
    state: ContactState,
    rough: ContactSolver,
    last: ContactSolver,
    finer: np.ndarray | None,
    brought: Brought | None = None,
) -> Corrected:
    """A coarse solution after the passes.

    Parameters
    ----------
    disc : Discretisation
        Of the coarse grid; in a step of a history with what the particles bring along.
    state : ContactState
        Its solution.
    rough, last : Steps
        The methods of all coarse solves but the last, and of that.
    finer : ndarray or None
        As of `finer_pressure`.
    brought : Brought, optional
        In a step of a history: what the step before left on the parts.

    Raises
    ------
    SceneError
        If forces are so near to the limit that a corrected problem cannot carry them.
    """
    try:
        return defect_corrected(
            disc, state, partial(_solved, rough), partial(_solved, last), finer=finer, brought=brought
        )
    except Saturated as beyond:
        raise SceneError(
            "refine",
            KINDS[0],
            "left out",
            message=f'refine = "{KINDS[0]}": the tangential force is so near to what friction carries that the '
            f"corrected problem cannot carry it ({beyond}); leave refine out",
        ) from None


def _solved(steps: ContactSolver, disc: Discretisation, state: ContactState) -> ContactState:
    """The tractions that go with the pressure of a state, from those it has."""
    return contact(disc, steps, state)


def roughly(steps: ContactSolver, tol: float = ROUGH) -> ContactSolver:
    """The same methods, as exact as the solves before the last need to be.

    Parameters
    ----------
    steps : Steps
    tol : float
        Residual that is enough.
    """
    return replace(steps, tol=max(steps.tol, tol), refined=False)


def finer_pressure(scene: Scene, disc: Discretisation, steps: ContactSolver) -> np.ndarray | None:
    """The pressure on parts of the parts, dimensionless as on the elements; None where it is Hertz's.

    Parameters
    ----------
    scene : Scene
    disc : Discretisation
        Of the coarse grid.
    steps : Steps

    Raises
    ------
    SceneError
        For samples that are known on that grid only.
    """
    if steps.plan.closed_form:
        return None
    if isinstance(scene.surface, SampledDistance) and not scene.surface.placed:
        message = (
            f'refine = "{KINDS[0]}": samples without coordinates are known at the centres of the elements alone, and '
            "not on parts of them; give surface.x and surface.y, or leave refine out"
        )
        raise SceneError("refine", KINDS[0], "left out", message=message)
    rows, columns = within_parts(disc)
    grid = disc.grid.divided((rows if disc.line else rows * PARTS, columns * PARTS))
    posed = discretise(replace(scene, grid=grid, friction=None, motion=None), grid)
    quick = replace(steps, plan=replace(steps.plan, normal="newton"), stats=SolveStats(), workspace=None, refined=False)
    try:
        return quick.pressure(posed, unloaded(grid)).pressure * (posed.scales.pressure / disc.scales.pressure)
    finally:
        posed.operators.forget()


def _halved(scene: Scene, disc: Discretisation, state: ContactState) -> tuple[Scene, Grid]:
    """The scene on about half as many elements across the contact each way, and their grid."""
    grid, hertz, (dx, dy) = disc.grid, scene.hertz, disc.grid.sides
    box = contact_box(grid, state.pressure) if hertz is None else (-hertz.a, hertz.a, -hertz.b, hertz.b)
    left, right, bottom, top = box
    nx, ny = round((right - left) / dx / 2), None if grid.line else round((top - bottom) / dy / 2)
    coarser = within(Grid(nx=nx, ny=ny, margin=1).spread(box), scene.surface)
    return replace(scene, grid=coarser, friction=friction_on(scene, grid, coarser)), coarser


def from_a_depth(scene: Scene, disc: Discretisation) -> Scene:
    """The scene with the reference depth that its line contact has on a grid, so that others count from it, too.

    Shifts that are known but for a constant then differ by their errors alone.

    Parameters
    ----------
    scene : Scene
    disc : Discretisation
    """
    surface = scene.surface
    if not disc.undetermined_constant or isinstance(surface, Paraboloids | Ellipse):
        return scene
    return replace(scene, surface=replace(surface, reference_depth=disc.operators.depth * disc.scales.length))


def friction_on(scene: Scene, grid: Grid, other: Grid) -> Any:
    """The friction of a scene on another grid: of elements the means by overlap.

    Parameters
    ----------
    scene : Scene
    grid : Grid
        Explicit, that of its friction.
    other : Grid
        Explicit.
    """
    if not isinstance(scene.friction, np.ndarray):
        return scene.friction
    (x, y), (other_x, other_y) = grid.lines, other.lines
    friction = _shares(other_y, y) @ scene.friction.reshape(grid.shape) @ _shares(other_x, x).T
    return friction[0] if grid.line else friction


def _shares(lines: np.ndarray, of: np.ndarray) -> np.ndarray:
    """Shares that the intervals between other lines have of each interval between `lines`; beyond, the nearest has.

    Shares that are due to rounding are left out: friction that is none where an interval ends would be next to nothing.
    """
    reached = of.copy()
    reached[[0, -1]] = min(of[0], lines[0]), max(of[-1], lines[-1])
    upper, lower = np.minimum(lines[1:, None], reached[None, 1:]), np.maximum(lines[:-1, None], reached[None, :-1])
    shares = (upper - lower) / np.diff(lines)[:, None]
    return np.where(shares > ROUNDING, shares, 0.0)
