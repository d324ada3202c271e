"""Rolling in time: each step is a problem like that of a shift, from what the step before left (paper, 4.2, 6.2, 6.4).

The particle now at x was at ``x + dq`` a step ago and brings its displacement difference along, so the local shift is
``E = W - u' + A p`` with ``u' = C p'`` known: the operator is symmetric, and each step a convex program.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import cast

import numpy as np

from varcontact.checks import file_name
from varcontact.errors import Interrupted, NoContact, Saturated, SceneError, VarcontactError
from varcontact.io.history_file import Stored
from varcontact.machine.memory import need
from varcontact.planning.plan import Plan
from varcontact.problem.certificate import Certificate, ForceBounds
from varcontact.problem.contact_grid import common_grid, enlarged, wanted_grid
from varcontact.problem.containment import outside
from varcontact.problem.discretisation import Carried, Discretisation
from varcontact.problem.discretise import discretise
from varcontact.problem.state import ContactState, unloaded
from varcontact.results.history import History
from varcontact.results.physical import solution_of
from varcontact.results.solution import Solution
from varcontact.scene.grid import Grid
from varcontact.scene.motion import TimeStep
from varcontact.scene.scene import Scene
from varcontact.scene.transient import Transient
from varcontact.solving import start_grid
from varcontact.solving.certify import judged
from varcontact.solving.friction_loop import remembered
from varcontact.solving.grid_search import on_a_grid_that_holds_it
from varcontact.solving.subproblems import Steps, contact
from varcontact.solving.timing import Clock

STEP_FIELDS, STEP_REST = 65.0, 1e4
"""Bytes of a step in memory: by element, and for the rest."""


def solve_transient(
    scene: Scene,
    plan: Plan,
    tol: float,
    polish: bool,
    progress: Callable[[str], None] | None = None,
    store: str | Path | None = None,
    certify: str = "auto",
    stages: bool = False,
) -> History:
    """Solve a transient scene step by step, see `solve`.

    Parameters
    ----------
    scene : Scene
        With a `Transient` motion.
    plan : Plan
    tol : float
        Residual to be reached in each step [-].
    polish : bool
        Whether active sets polish the answers of programs.
    progress : callable, optional
        Called with the name of each stage.
    store : str or Path, optional
        File to which each step is added.
    certify : str
        As of `solve`.
    stages : bool
        Whether the progress is told the stages within a step, too.

    Raises
    ------
    VarcontactError
        As of `solve`, with the step in its message.
    Interrupted
        With the steps that were finished.
    """
    if not isinstance(_motion(scene).start, Solution | None):
        raise SceneError("motion.start", _motion(scene).start, "a Solution")
    steps = Steps(plan, tol, polish, Clock(), certify=certify)
    if store is None:
        return _solved(scene, steps, progress, None, stages)
    with Stored.recording(file_name("store", store), scene, plan, tol, polish) as stored:
        return _solved(scene, steps, progress, stored, stages)


def _solved(
    scene: Scene, steps: Steps, progress: Callable[[str], None] | None, recording: Stored | None, stages: bool
) -> History:
    """The steps that are not solved yet, in memory or in the file that they are recorded in."""
    from varcontact.solving.remeasured import with_measured_steps

    motion, stored = _motion(scene), None if recording is None else with_measured_steps(recording)
    if stored is None:
        spec = wanted_grid(scene)
        kept = bytes_of_steps(motion, spec.nx * spec.rows)
        need("the history in memory", kept, "with store = a file, the steps are kept there")
    contacts = largest_contacts(scene)
    grid = stored.grid if stored is not None and len(stored) else _grid(scene, contacts, steps)
    march = marching_on(scene, contacts[0], grid, steps)
    in_memory: list[Solution] = []
    history = History(scene, grid, in_memory if stored is None else stored, {"tol": steps.tol, "polish": steps.polish})
    before = march.start() if len(history) == 0 else history[-1]
    try:
        for k in range(len(history), motion.steps):
            try:
                if progress is not None:
                    progress(f"{k} of {motion.steps} steps")
                before = march.step(k, before, _within(progress, k, motion.steps) if stages else None)
                if stored is None:
                    in_memory.append(before)
                else:
                    stored.put(k, before)
            except VarcontactError as error:
                raise error.in_step(k, history) from error.__cause__
            except KeyboardInterrupt:
                raise Interrupted(history, f" after {len(history)} of {motion.steps} steps") from None
    finally:
        march.disc.operators.forget()
    return history


def _within(progress: Callable[[str], None] | None, k: int, count: int) -> Callable[[str], None] | None:
    """Tells the stages of step k of so many."""
    return None if progress is None else lambda stage: progress(f"{k} of {count} steps: {stage}")


def bytes_of_steps(motion: Transient, elements: int) -> float:
    """What the answer of a history takes in memory, about.

    Parameters
    ----------
    motion : Transient
    elements : int
        Of the potential contact.
    """
    return motion.steps * (STEP_FIELDS * elements + STEP_REST)


def marching_on(scene: Scene, largest: Scene, grid: Grid, steps: Steps) -> March:
    """The march of a history on its grid, in the scales of one of its `largest_contacts`.

    Parameters
    ----------
    scene : Scene
        With a `Transient` motion.
    largest : Scene
        One of its `largest_contacts`.
    grid : Grid
        Explicit, physical.
    steps : Steps
    """
    return March(scene, _discretisation(largest, grid, coupled=not steps.plan.left_out), steps)


@dataclass(frozen=True, eq=False)
class March:
    """What all steps share: the grid and its scales, the operators, the methods.

    A step takes nothing but the solution before it, as it is in physical units: a history that goes on from its file
    is the same, bit for bit, as one that was not interrupted.

    Attributes
    ----------
    scene : Scene
        With a `Transient` motion.
    disc : Discretisation
        Without motion.
    steps : Steps
    """

    scene: Scene
    disc: Discretisation
    steps: Steps

    def start(self) -> Solution | None:
        """What the first step goes on from.

        Raises
        ------
        SceneError
            If that is on another grid, and not to be interpolated.
        """
        motion, grid = _motion(self.scene), self.disc.grid
        start = cast(Solution | None, motion.start)
        if start is None or start_grid.same(start.grid, grid):
            return start
        if not motion.interpolate or start.grid.line != grid.line:
            remedy = "" if start.grid.line != grid.line else ", or interpolate = True"
            raise SceneError(
                "motion.start",
                f"Solution on {start_grid.words(start.grid)}",
                f"on the grid of the history{remedy}",
                message=f"motion.start is a solution on {start_grid.words(start.grid)}, and the history is "
                f"on {start_grid.words(grid)}; use the same grid{remedy}",
            )
        fields = np.concatenate([start.traction, start.pressure[None]])
        fields = start_grid.interpolated(start.grid, fields, grid)
        state = start_grid.sampled(start.grid, start.state, grid)
        return replace(start, grid=grid, traction=fields[:2], pressure=fields[2], state=state)

    def step(self, k: int, before: Solution | None, told: Callable[[str], None] | None = None) -> Solution:
        """Solve step k.

        Parameters
        ----------
        k : int
            From 0.
        before : Solution or None
            The step before; None: bodies without tractions.
        told : callable, optional
            Called with the name of each stage.
        """
        steps = replace(self.steps, clock=Clock(told))
        with steps.clock("carried"):
            scene, disc = self.problem(k, before)
        state = _state(disc, before)
        if steps.plan.tangential in ("tang", "tang-exact") and steps.plan.coupling == "none":
            # As printed it does best from its own start: on the areas of the step before its Newton's method fails.
            state = replace(state, traction=np.zeros_like(state.traction))
        if without_load(disc, closed_form=steps.plan.closed_form):
            return _without_contact(scene, disc, steps)
        if steps.plan.one_pass:
            bare = steps.pressure(disc, replace(state, traction=np.zeros_like(state.traction)))
            state = replace(bare, traction=state.traction)
        else:
            state = steps.pressure(disc, state)
        state = contact(disc, steps, state)
        with steps.clock("grid"):
            overlap = outside(disc, state, steps.plan.closed_form)
        if overlap is not None:
            enlarged(scene, disc.grid, state.pressure, overlap)  # always an error: the step's grid is explicit
        return judged(scene, disc, state, steps)

    def problem(self, k: int, before: Solution | None) -> tuple[Scene, Discretisation]:
        """Step k by itself, with what the particles bring along from the step before.

        Parameters
        ----------
        k : int
            From 0.
        before : Solution or None
            The step before; None: bodies without tractions.
        """
        scene = self.scene.step(k, self.disc.grid)
        return scene, self.disc.at_step(scene, self._carried(scene, before))

    def _carried(self, scene: Scene, before: Solution | None) -> Carried | None:
        """Displacement differences that the particles bring along: u' = C p'."""
        if before is None:
            return None
        disc, motion = self.disc, scene.motion
        assert isinstance(motion, TimeStep)
        fields = before.traction
        if disc.K != 0:
            fields = np.concatenate([fields, before.pressure[None]])
        if not fields.any():
            return None
        distance = motion.direction * motion.dq / disc.length
        force = before.traction.sum(axis=(1, 2)) / disc.pressure * disc.lattice.area
        return Carried(disc.operators.carrying(distance).apply(fields / disc.pressure), force)


def _motion(scene: Scene) -> Transient:
    assert isinstance(scene.motion, Transient)
    return scene.motion


def largest_contacts(scene: Scene) -> list[Scene]:
    """The steps with the largest load on each surface, as frictionless scenes.

    Raises
    ------
    NoContact
        If there is none.

    Parameters
    ----------
    scene : Scene
        With a `Transient` motion.
    """
    largest: dict[tuple[int, bool], Scene] = {}
    for k in range(_motion(scene).steps):
        surface, force, approach = scene.contact(k)
        load = approach if force is None else force
        assert load is not None
        key = (id(surface), force is None)
        known = largest.get(key)
        before = None if known is None else known.approach if force is None else known.normal_force
        if force == 0 or (before is not None and before >= load):
            continue
        try:
            still = replace(scene, normal_force=force, approach=approach, friction=None, motion=None, surface=surface)
        except NoContact:
            continue
        largest[key] = still
    if not largest:
        raise NoContact(
            "motion",
            "no load in any step",
            "a history in which the bodies touch once at least",
            message="motion: the bodies never touch; give a load in one step at least",
        )
    return list(largest.values())


def _grid(scene: Scene, contacts: list[Scene], steps: Steps) -> Grid:
    """One grid for the whole history: the scene's own, that of the start, or one that holds every contact."""
    motion = _motion(scene)
    if isinstance(scene.grid, Grid) and scene.grid.explicit:
        return scene.grid
    if motion.start is not None and scene.grid == "auto" and not motion.interpolate:
        closed_form = steps.plan.closed_form
        return motion.start.grid if closed_form else replace(motion.start.grid, edge="centres")
    plan = replace(steps.plan, tangential="none", coupling="none")
    discs = [on_a_grid_that_holds_it(each, replace(steps, plan=plan, clock=Clock()))[0] for each in contacts]
    for disc in discs:
        disc.operators.forget()
    grid = common_grid(scene, [disc.grid for disc in discs])
    if motion.start is not None and not motion.interpolate and np.allclose(motion.start.grid.sides, grid.sides, 1e-9):
        return replace(motion.start.grid, edge=grid.edge)  # the same lattice, with more or less room around
    return grid


def _discretisation(scene: Scene, grid: Grid, coupled: bool) -> Discretisation:
    """The grid with scales for all steps.

    Pressures are scaled by a power of two: a state survives the way to physical units and back bit for bit.
    """
    disc = discretise(replace(scene, grid=grid), grid, coupled=coupled)
    return replace(disc, pressure=float(2.0 ** np.round(np.log2(disc.pressure))))


def _state(disc: Discretisation, before: Solution | None) -> ContactState:
    """The state of the step before, in the scales of the discretisation: where the methods begin."""
    if before is None:
        return unloaded(disc.grid)
    motion, was = disc.motion, before.scene.motion
    rigid = np.zeros(2)
    assert motion is not None
    if motion.rolls and isinstance(was, TimeStep) and was.rolls:
        assert disc.step is not None
        creepage = np.nan_to_num(before.creepage[:2]) * disc.step * disc.length / disc.displacement
        prescribed = [motion.Fx is not None and was.Fx is not None, motion.Fy is not None and was.Fy is not None]
        rigid = np.where(prescribed, creepage, 0.0)
    approach = (before.approach - disc.base) / disc.displacement if np.isfinite(before.approach) else 0.0
    state = ContactState(before.pressure / disc.pressure, approach, before.traction / disc.pressure, rigid)
    known = remembered(disc, before)
    return state if known is None else replace(state, friction=known, branch="history")


def without_load(disc: Discretisation, closed_form: bool) -> bool:
    """Whether a step has no contact: no load, or an approach at which no element's centre is in contact.

    Parameters
    ----------
    disc : Discretisation
        Of the step.
    closed_form : bool
        Whether Hertz's pressure is taken, of which elements may see nothing.
    """
    if disc.approach is None:
        return disc.normal_force == 0
    if disc.approach <= disc.base:
        return True
    if not closed_form:
        return False
    assert disc.hertz is not None
    return not disc.hertz.on_elements(disc.grid).any()


def _without_contact(scene: Scene, disc: Discretisation, steps: Steps) -> Solution:
    """A step in which the bodies are apart, or just touch: no tractions."""
    motion = scene.motion
    assert isinstance(motion, TimeStep)
    size = float(np.hypot(motion.Fx or 0.0, motion.Fy or 0.0))
    if size > 0:
        raise Saturated(size, 0.0)
    level = 0.0 if scene.approach is None else (scene.approach - disc.base) / disc.displacement
    exact = Certificate(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, "full", ForceBounds.known(np.zeros(3), np.zeros(3)))
    state = replace(unloaded(disc.grid), approach=level)
    return solution_of(scene, disc, steps.plan, state, exact, True, steps.clock.timing(), steps.clock.calls())
