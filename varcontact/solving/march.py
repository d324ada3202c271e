"""One step of a history after the other: each is a problem like that of a shift, from what the step before left.

The particle now at x was at ``x + dq`` a step ago and brings its displacement difference along, so the local shift is
``E = W - u' + A p`` with ``u' = C p'`` known: the operator is symmetric, and each step a convex program (paper, 4.2,
6.2, 6.4).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import cast

import numpy as np

from varcontact.discrete.certificate import Certificate, ForceBounds
from varcontact.discrete.contact_grid import enlarged
from varcontact.discrete.discretisation import Discretisation, PreviousStep, discretise
from varcontact.discrete.penetration import outside
from varcontact.discrete.state import ContactState, unloaded
from varcontact.discrete.subgrid import divided, without_pressure
from varcontact.errors import Saturated, SceneError
from varcontact.results.physical import solution_of
from varcontact.results.solution import Solution
from varcontact.scene.grid import Cells, Grid
from varcontact.scene.motion import TimeStep, Transient
from varcontact.scene.scene import Scene
from varcontact.solvers.statistics import SolveStats
from varcontact.solving import start_grid
from varcontact.solving.contact_solver import ContactSolver, contact
from varcontact.solving.finish import finish
from varcontact.solving.friction_law import remembered, stick_slip_warning, weakening


def marching_on(scene: Scene, largest: Scene, grid: Grid, steps: ContactSolver) -> March:
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
    steps: ContactSolver

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
        known = {"traction": fields[:2], "pressure": fields[2], "state": state}
        return replace(start, grid=grid, **known, pressure_on_parts=None, weakening=None)

    def forget(self) -> None:
        """Let go of what the operators keep for the next step."""
        self.disc.operators.forget()

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
        steps = replace(self.steps, stats=SolveStats(told))
        with steps.stats.stage("carried"):
            scene, disc = self.problem(k, before)
        solution = self._solved(scene, disc, before, steps)
        if not self.scene.under_law:
            return solution
        return replace(solution, weakening=weakening(disc, before, solution))

    def _solved(self, scene: Scene, disc: Discretisation, before: Solution | None, steps: ContactSolver) -> Solution:
        """The solution of a step's problem."""
        state = begun(state_of(disc, before), steps)
        cells = steps.plan.cells(scene)
        if without_load(disc, steps.plan.closed_form, cells):
            return without_contact(scene, disc if cells == (1, 1) else without_pressure(disc), steps)
        if steps.plan.one_pass:
            bare = steps.pressure(disc, replace(state, traction=np.zeros_like(state.traction)))
            state = replace(bare, traction=state.traction)
        elif cells != (1, 1):
            disc, state = steps.pressed_on_parts(disc, state)
        else:
            state = steps.pressure(disc, state)
        state = contact(disc, steps, state)
        check_held(scene, disc, state, steps)
        solution = finish(scene, disc, state, steps)
        warning = "" if disc.loading.law is None or not steps.plan.has_friction else stick_slip_warning(disc, state)
        return replace(solution, warnings=(*solution.warnings, warning)) if warning else solution

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

    def _carried(self, scene: Scene, before: Solution | None) -> PreviousStep | None:
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
        distance = motion.direction * motion.dq / disc.scales.length
        force = before.traction.sum(axis=(1, 2)) / disc.scales.pressure * disc.lattice.area
        fields = fields / disc.scales.pressure
        return PreviousStep(disc.operators.carrying(distance).apply(fields), force, fields)


def _motion(scene: Scene) -> Transient:
    assert isinstance(scene.motion, Transient)
    return scene.motion


def _discretisation(scene: Scene, grid: Grid, coupled: bool) -> Discretisation:
    """The grid with scales for all steps.

    Pressures are scaled by a power of two: a state survives the way to physical units and back bit for bit.
    """
    disc = discretise(replace(scene, grid=grid), grid, coupled=coupled)
    return replace(disc, scales=replace(disc.scales, pressure=float(2.0 ** np.round(np.log2(disc.scales.pressure)))))


def state_of(disc: Discretisation, before: Solution | None) -> ContactState:
    """The state of the step before, in the scales of the discretisation: where the methods begin.

    Parameters
    ----------
    disc : Discretisation
        Of the step.
    before : Solution or None
    """
    if before is None:
        return unloaded(disc.grid)
    motion, was = disc.loading.motion, before.scene.motion
    rigid = np.zeros(2)
    assert motion is not None
    if motion.rolls and isinstance(was, TimeStep) and was.rolls:
        assert disc.step is not None
        creepage = np.nan_to_num(before.creepage[:2]) * disc.step * disc.scales.length / disc.scales.displacement
        prescribed = [motion.Fx is not None and was.Fx is not None, motion.Fy is not None and was.Fy is not None]
        rigid = np.where(prescribed, creepage, 0.0)
    approach = (before.approach - disc.base) / disc.scales.displacement if np.isfinite(before.approach) else 0.0
    state = ContactState(
        before.pressure / disc.scales.pressure, approach, before.traction / disc.scales.pressure, rigid
    )
    known = remembered(disc, before)
    return state if known is None else replace(state, friction=known, branch="history")


def begun(state: ContactState, steps: ContactSolver) -> ContactState:
    """The state of the step before as the methods can begin with it.

    As printed, TANG does best from its own start: on the areas of the step before its Newton's method fails.

    Parameters
    ----------
    state : ContactState
    steps : Steps
    """
    as_printed = steps.plan.tangential in ("tang", "tang-exact") and steps.plan.coupling == "none"
    return replace(state, traction=np.zeros_like(state.traction)) if as_printed else state


def check_held(scene: Scene, disc: Discretisation, state: ContactState, steps: ContactSolver) -> None:
    """Refuse a contact that goes on beyond the grid.

    Parameters
    ----------
    scene : Scene
        Of the step.
    disc : Discretisation
    state : ContactState
        With its pressure.
    steps : Steps

    Raises
    ------
    SceneError
        Naming the grid.
    """
    with steps.stats.stage("grid"):
        overlap = outside(disc, state, steps.plan.closed_form)
    if overlap is not None:
        enlarged(scene, disc.grid, state.pressure, overlap)  # always an error: the step's grid is explicit


def without_load(disc: Discretisation, closed_form: bool, cells: Cells = (1, 1)) -> bool:
    """Whether a step has no contact: no load, or an approach at which no element's centre is in contact.

    Parameters
    ----------
    disc : Discretisation
        Of the step.
    closed_form : bool
        Whether Hertz's pressure is taken, of which elements may see nothing.
    cells : tuple of int
        Parts of an element along y and x on which the pressure is solved for.
    """
    if disc.loading.approach is None:
        return disc.loading.normal_force == 0
    if disc.loading.approach <= (disc if cells == (1, 1) else divided(disc, cells)).base:
        return True
    if not closed_form:
        return False
    assert disc.hertz is not None
    return not disc.hertz.on_elements(disc.grid).any()


def without_contact(scene: Scene, disc: Discretisation, steps: ContactSolver) -> Solution:
    """A step in which the bodies are apart, or just touch: no tractions.

    Parameters
    ----------
    scene : Scene
        Of the step.
    disc : Discretisation
    steps : Steps

    Raises
    ------
    Saturated
        If a tangential force is prescribed all the same.
    """
    motion = scene.motion
    assert isinstance(motion, TimeStep)
    size = float(np.hypot(motion.Fx or 0.0, motion.Fy or 0.0))
    if size > 0:
        raise Saturated(size, 0.0)
    level = 0.0 if scene.approach is None else (scene.approach - disc.base) / disc.scales.displacement
    exact = Certificate(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, "full", ForceBounds(np.zeros(3), np.zeros(3)))
    state = replace(unloaded(disc.grid), approach=level)
    return solution_of(scene, disc, steps.plan, state, exact, True, steps.stats.timing, steps.stats.calls)
