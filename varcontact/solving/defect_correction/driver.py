"""Defect correction of a scene: the coarse solution corrected, and its error estimated from half as many elements."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from varcontact.discrete.contact_grid import across, within
from varcontact.discrete.discretisation import Discretisation, discretise
from varcontact.discrete.state import ContactState, unloaded
from varcontact.discrete.stick_slip import unit_slip
from varcontact.errors import Saturated, SceneError
from varcontact.results.error_estimate import ErrorEstimate, Solve
from varcontact.results.quantities_of_interest import creepage_names, units
from varcontact.results.refinement import Refinement
from varcontact.results.solution import Solution
from varcontact.scene.friction import Law
from varcontact.scene.grid import Grid
from varcontact.scene.scene import Scene
from varcontact.solvers.statistics import SolveStats
from varcontact.solving.contact_solver import ContactSolver, contact
from varcontact.solving.defect_correction.applicability import CONTINUUM
from varcontact.solving.defect_correction.iteration import Corrected, defect_correct, late_change

LOOSE = 1e-5
"""Residual of all coarse solves but the last: parts of a hundred of what a pass changes."""
ROUNDING = 1e-12
"""Shares of an element below this are due to rounding."""


def loosely(solver: ContactSolver) -> ContactSolver:
    """The same methods, as exact as the solves before the last need to be."""
    return replace(solver, tol=max(solver.tol, LOOSE), refined=False)


def run(
    scene: Scene, disc: Discretisation, state: ContactState, solver: ContactSolver
) -> tuple[Discretisation, ContactState, Refinement]:
    """The corrected problem on the elements, its solution to the solver's tolerance, and the field on parts."""
    with solver.stats.stage("refinement"):
        found = _corrected(disc, state, loosely(solver), solver)
    with solver.stats.stage("error estimate"):
        coarser = _on_half_as_many(scene, disc, solver)
    return found.disc, found.state, _record(found, coarser)


def _corrected(disc: Discretisation, state: ContactState, loose: ContactSolver, last: ContactSolver) -> Corrected:
    try:
        return defect_correct(disc, state, loose, last)
    except Saturated as beyond:
        raise SceneError(
            "refine",
            CONTINUUM,
            "left out",
            message=f'refine = "{CONTINUUM}": the tangential force is so near to what friction carries that the '
            f"corrected problem cannot carry it ({beyond}); leave refine out",
        ) from None


def _on_half_as_many(scene: Scene, disc: Discretisation, solver: ContactSolver) -> Corrected:
    """The same on about half as many elements across the contact each way."""
    grid, hertz, (dx, dy) = disc.grid, scene.hertz, disc.grid.sides
    assert hertz is not None
    coarser = Grid(nx=round(hertz.a / dx), ny=round(hertz.b / dy), margin=1)
    coarser = within(coarser.spread((-hertz.a, hertz.a, -hertz.b, hertz.b)), scene.surface)
    scene = replace(scene, grid=coarser, friction=_friction_on(scene, grid, coarser))
    loose = replace(loosely(solver), stats=SolveStats())
    other = discretise(scene, coarser, coupled=False)
    try:
        state = contact(other, loose, loose.pressure(other, unloaded(coarser)))
        return _corrected(other, state, loose, replace(loose, tol=solver.tol))
    finally:
        other.operators.forget()


def _friction_on(scene: Scene, grid: Grid, other: Grid) -> float | np.ndarray | Law | None:
    """The friction of a scene on another grid: of elements the means by overlap."""
    if not isinstance(scene.friction, np.ndarray):
        return scene.friction
    (x, y), (other_x, other_y) = grid.lines, other.lines
    return overlaps(other_y, y) @ scene.friction.reshape(grid.shape) @ overlaps(other_x, x).T


def overlaps(lines: np.ndarray, of: np.ndarray) -> np.ndarray:
    """Shares that the intervals between `lines` have of each interval between others; beyond, the nearest has.

    Shares that are due to rounding are left out: friction that is none where an interval ends would be next to nothing.
    """
    reached = of.copy()
    reached[[0, -1]] = min(of[0], lines[0]), max(of[-1], lines[-1])
    upper, lower = np.minimum(lines[1:, None], reached[None, 1:]), np.maximum(lines[:-1, None], reached[None, :-1])
    shares = (upper - lower) / np.diff(lines)[:, None]
    return np.where(shares > ROUNDING, shares, 0.0)


def _record(found: Corrected, coarser: Corrected) -> Refinement:
    """The record of the passes in physical units, with the estimate of its error.

    That is the difference from half as many elements, what late passes changed, or what the field misses of a force
    that is prescribed. The components of force, and of creepage, have one: the length of a vector.
    """
    motion, carried, rolled = found.fine.disc.loading.motion, found.disc.loading.previous_step, unit_slip(found.disc)
    assert motion is not None
    assert carried is not None
    last, prescribed = found.forces[-1], (motion.Fx, motion.Fy)
    wanted = [F if given is None else given for F, given in zip(last, (*prescribed, None), strict=True)]
    of_forces = np.max([np.abs(last - coarser.forces[-1]), late_change(found.forces), np.abs(last - wanted)], axis=0)
    of_creepages = np.maximum(np.abs(found.creepages[-1] - coarser.creepages[-1]), late_change(found.creepages))
    return Refinement(
        kind=CONTINUUM,
        grid=found.fine.grid,
        traction=found.field.traction * found.disc.scales.pressure,
        slip=found.shift / rolled,
        correction=-carried.displacement / rolled,
        share=np.ones(found.disc.grid.shape),
        forces=found.forces,
        creepages=found.creepages,
        estimate=np.array([*(2 * [np.hypot(*of_forces[:2])]), of_forces[2]]),
        creepage_estimate=np.where([given is None for given in prescribed], 0.0, np.hypot(*of_creepages)),
        seconds=found.seconds,
    )


def error_estimate(solution: Solution, found: Refinement) -> ErrorEstimate:
    """What a refinement says of a solution's forces and creepages: values of its field, with their estimated errors."""
    names, scales = ("Fx", "Fy", "Mz", *creepage_names(solution)[:2]), units(solution)
    scales = {name: unit for name, unit in scales.items() if unit > 0}  # without load there is none
    last, estimates = [*found.forces[-1], *found.creepages[-1]], [*found.estimate, *found.creepage_estimate]
    known = [name for name in names if name[0] in "FM" or name in scales]
    values = {name: float(value) for name, value in zip(names, last, strict=True) if name in known}
    errors = {name: float(e) / scales[name] for name, e in zip(names, estimates, strict=True) if name in scales}
    how = (
        "no bound: the difference from half as many elements across the contact, or what late ones of "
        f"{found.passes} passes changed"
    )
    nx, ny = across(solution.pressure)
    bars = {name: error * scales[name] for name, error in errors.items()}
    return ErrorEstimate(values, errors, how, (Solve(nx, ny, sum(found.seconds)),), bars=bars)
