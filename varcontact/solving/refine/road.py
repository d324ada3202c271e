"""Defect correction of a scene: what it is for, the passes, the estimate of its error."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np

from varcontact import checks
from varcontact.elasticity.operators import table_bytes
from varcontact.errors import Saturated, SceneError
from varcontact.machine.memory import SMALLER, need
from varcontact.planning.plan import Plan
from varcontact.problem.contact_grid import across, known_grid, wanted_grid, within
from varcontact.problem.containment import contact_box
from varcontact.problem.discretisation import Discretisation
from varcontact.problem.discretise import discretise
from varcontact.problem.operators import KEPT_DISTANCES
from varcontact.problem.slip import unit_slip
from varcontact.problem.state import ContactState, unloaded
from varcontact.results.error_estimate import ErrorEstimate, Solve
from varcontact.results.refinement import Refinement
from varcontact.results.solution import Solution
from varcontact.scene.grid import Grid
from varcontact.scene.motion import Steady, TimeStep
from varcontact.scene.scene import Scene
from varcontact.scene.surfaces import Ellipse, Paraboloids, SampledDistance
from varcontact.scene.transient import Transient
from varcontact.solving.error_norm import creepage_names, units, units_of
from varcontact.solving.refine.cliffs import check_cliffs
from varcontact.solving.refine.parts import Brought
from varcontact.solving.refine.passes import PARTS, Corrected, defect_corrected
from varcontact.solving.refine.pressed import FINER, divided, within_parts
from varcontact.solving.subproblems import Steps, contact
from varcontact.solving.timing import Clock

KINDS = ("continuum",)
"""What can be asked for."""
LEAST = 8
"""Fewest elements across the contact each way: with fewer the estimate, from half of them, says nothing."""
LEAST_OF_A_HISTORY = 16
"""The same in a history: on half of fewer, errors that steps hand on are no longer in proportion."""
FIELDS = 120
"""Numbers for each part, about, with which Hertz's contact without slip is known."""
ROUGH = 1e-5
"""Residual of all coarse solves but the last: parts of a hundred of what a pass changes."""


def check_refine(scene: Scene, plan: Plan, refine: Any, chosen: bool, start: str | Solution | None) -> bool:
    """Whether defect correction is asked for; refused, before any work, where it does not hold.

    Parameters
    ----------
    scene : Scene
    plan : Plan
    refine : str or None
        As of `solve`.
    chosen : bool
        Whether the grid is to be chosen for an accuracy or a time.
    start : str, Solution or None
        As of `solve`.

    Raises
    ------
    SceneError
        For a kind that there is not, or a scene or method that cannot be corrected.
    """
    if refine is None:
        return False
    kind = checks.choice("refine", refine, KINDS)
    reason = _why_not(scene, plan)
    if isinstance(start, Solution):
        reason = 'the estimate takes half as many elements, on which no start is known; give start = "stick" or "slip"'
    if chosen:
        reason = "it corrects on the scene's own grid; leave it out, or accuracy and time_budget"
    if reason:
        raise SceneError("refine", kind, "left out", message=f'refine = "{kind}": {reason}')
    marches = isinstance(scene.motion, Transient)
    grid, hertz = wanted_grid(scene) if marches else known_grid(scene), scene.hertz
    if hertz is not None and not marches:
        dx, dy = grid.sides
        check_count(scene, (2 * hertz.a / dx, 2 * hertz.b / dy))
    elif not grid.explicit:  # otherwise the contact has to be solved for, or the largest of a history to be found
        check_count(scene, (grid.nx, grid.rows), LEAST_OF_A_HISTORY if marches else LEAST)
    parts = PARTS if plan.closed_form else PARTS * FINER
    blocks = 4 * table_bytes(parts * grid.rows, parts * grid.nx, 1)
    known = FIELDS * parts**2 * grid.size if plan.closed_form and not marches else 0
    kept = 2.0 + KEPT_DISTANCES if marches else 2.0
    need("the parts of the elements", kept * blocks + 8 * known, SMALLER)
    return True


def check_count(scene: Scene, count: tuple[float, float], least: int = LEAST) -> None:
    """There are enough elements along x and y across the contact; in line contact along x.

    Parameters
    ----------
    scene : Scene
    count : tuple of float
        Elements across the contact along x and y.
    least : int
        Fewest of them.

    Raises
    ------
    SceneError
        Naming the grid.
    """
    counted = count[:1] if scene.line else count
    if min(counted) < least * (1 - 1e-9):
        found = " by ".join(f"{each:.3g}" for each in counted)
        raise SceneError(
            "grid",
            scene.grid,
            f"at least {least} elements across the contact each way",
            message=f'refine = "{KINDS[0]}" needs a grid with at least {least} elements across the contact each way; '
            f"here it has {found}",
        )


def _why_not(scene: Scene, plan: Plan) -> str:
    """Why a scene cannot be corrected, and what to do instead; nothing where it can."""
    instead = "solve on several grids and extrapolate (converge), or leave refine out"
    motion = scene.motion
    if motion is None:
        return "it is for tractions, and without a motion there are none: leave refine out"
    if scene.frictionless:
        return "without friction there is nothing to correct: leave refine out"
    if scene.bodies.K != 0 and not plan.left_out:
        return f"it is for quasi-identical bodies, and here K = {scene.bodies.K:.3g}: it may lose then; {instead}"
    if not isinstance(motion, Steady) and any(isinstance(f, float) and math.isinf(f) for f in scene.frictions):
        return f"with infinite friction it is for steady rolling; {instead}"
    if scene.no_slip and not plan.closed_form:
        return f"with infinite friction it is for Hertz's pressure in closed form; {instead}"
    if plan.theory is not None:
        return f"it corrects exact methods, not the theory {plan.tangential!r}; leave tangential or refine out"
    if isinstance(scene.grid, Grid) and scene.grid.edge != "centres":
        return f'with grid.edge = "{scene.grid.edge}" it gains less, or loses: leave grid.edge out'
    return _why_no_history(scene, motion) if isinstance(motion, Transient) else ""


def _why_no_history(scene: Scene, motion: Transient) -> str:
    """Why a history cannot be corrected, and what to do instead; nothing where it can."""
    if scene.under_law:
        return "of histories it is for friction that is a number, not for laws of friction; leave refine out"
    if motion.start is not None:
        return (
            "motion.start has no tractions on parts of the elements to go on from; leave motion.start out, and begin "
            "with the steps that lead there"
        )
    return ""


def refined(scene: Scene, disc: Discretisation, state: ContactState, steps: Steps) -> tuple[Corrected, Refinement]:
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
    with steps.clock("refinement"):
        finer = finer_pressure(scene, disc, steps)
        found = passed(disc, state, roughly(steps), steps, finer)
    with steps.clock("error estimate"):
        coarser = corrected_on(*_halved(from_a_depth(scene, disc), disc, state), steps)
    return found, recorded(found, coarser.forces[-1], coarser.creepages[-1])


def recorded(found: Corrected, forces: np.ndarray, creepages: np.ndarray) -> Refinement:
    """The record of the passes, with the difference from other loads as the estimate, or what the last pass changed.

    Where a force is prescribed, what the field carries more or less counts, too.

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
    rolled, carried, last = unit_slip(found.disc), found.disc.carried, found.forces[-1]
    assert carried is not None
    prescribed = [getattr(found.parts.disc.motion, name) for name in ("Fx", "Fy")]
    posed = [F if given is None else given for F, given in zip(last, [*prescribed, None], strict=True)]
    return Refinement(
        kind=KINDS[0],
        grid=found.parts.grid,
        traction=found.traction * found.disc.pressure,
        slip=found.shift / rolled,
        correction=-carried.displacement / rolled,
        share=found.share,
        forces=found.forces,
        creepages=found.creepages,
        estimate=np.abs(last - [forces, found.forces[-2], posed]).max(axis=0),
        creepage_estimate=np.abs(found.creepages[-1] - [creepages, found.creepages[-2]]).max(axis=0),
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
        "no bound: the difference from half as many elements across the contact, or what the last of "
        f"{found.passes} passes changed"
    )
    if isinstance(solution.motion, TimeStep):
        how += "; or that of the step before, as far as its particles are still in contact"
    if set(afloat) & set(errors):
        how += f"; without surface.reference_depth {' and '.join(afloat)} counts from a depth that is left open"
    nx, ny = across(solution.pressure)
    return ErrorEstimate(values, errors, how, (Solve(nx, ny, sum(found.seconds)),))


def _of_the_force(solution: Solution, found: Refinement) -> dict[str, float]:
    """Units of errors without a friction limit: the tangential force itself, and that times sqrt(ab)."""
    size, hertz = float(np.hypot(*found.force)), solution.scene.hertz
    assert hertz is not None
    if size == 0:
        return {}
    moment = {} if solution.scene.line else {"Mz": size * float(np.sqrt(hertz.a * hertz.b))}
    return {"Fx": size, "Fy": size} | moment


def corrected_on(scene: Scene, grid: Grid, steps: Steps) -> Corrected:
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
    rough = replace(roughly(steps), clock=Clock())
    disc = discretise(replace(scene, grid=grid), grid, coupled=False)
    try:
        state = contact(disc, rough, rough.pressure(disc, unloaded(grid)))
        return passed(disc, state, rough, replace(rough, tol=steps.tol), finer_pressure(scene, disc, rough))
    finally:
        disc.operators.forget()


def passed(
    disc: Discretisation,
    state: ContactState,
    rough: Steps,
    last: Steps,
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


def _solved(steps: Steps, disc: Discretisation, state: ContactState) -> ContactState:
    """The tractions that go with the pressure of a state, from those it has."""
    return contact(disc, steps, state)


def roughly(steps: Steps, tol: float = ROUGH) -> Steps:
    """The same methods, as exact as the solves before the last need to be.

    Parameters
    ----------
    steps : Steps
    tol : float
        Residual that is enough.
    """
    return replace(steps, tol=max(steps.tol, tol), refined=False)


def finer_pressure(scene: Scene, disc: Discretisation, steps: Steps) -> np.ndarray | None:
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
    grid = divided(disc.grid, (rows if disc.line else rows * PARTS, columns * PARTS))
    posed = discretise(replace(scene, grid=grid, friction=None, motion=None), grid)
    quick = replace(steps, plan=replace(steps.plan, normal="newton"), clock=Clock(), setups=None, refined=False)
    try:
        return quick.pressure(posed, unloaded(grid)).pressure * (posed.pressure / disc.pressure)
    finally:
        posed.operators.forget()


def _halved(scene: Scene, disc: Discretisation, state: ContactState) -> tuple[Scene, Grid]:
    """The scene on about half as many elements across the contact each way, and their grid."""
    grid, hertz, (dx, dy) = disc.grid, scene.hertz, disc.grid.sides
    if hertz is not None:
        box, margin = (-hertz.a, hertz.a, -hertz.b, hertz.b), 0 if state.solved_by.get("normal") == "hertz" else 1
    else:
        box, margin = contact_box(grid, state.pressure), 1
    left, right, bottom, top = box
    nx, ny = round((right - left) / dx / 2), None if grid.line else round((top - bottom) / dy / 2)
    coarser = within(Grid(nx=nx, ny=ny, margin=margin).spread(box), scene.surface)
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
    if not disc.afloat or isinstance(surface, Paraboloids | Ellipse):
        return scene
    return replace(scene, surface=replace(surface, reference_depth=disc.operators.depth * disc.length))


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
    """Shares that the intervals between other lines have of each interval between `lines`; beyond, the nearest has."""
    reached = of.copy()
    reached[[0, -1]] = min(of[0], lines[0]), max(of[-1], lines[-1])
    upper, lower = np.minimum(lines[1:, None], reached[None, 1:]), np.maximum(lines[:-1, None], reached[None, :-1])
    return np.asarray(np.maximum(upper - lower, 0.0) / np.diff(lines)[:, None])
