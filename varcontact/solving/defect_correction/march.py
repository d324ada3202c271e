"""Histories, corrected step by step: the field on the parts carries its displacements to the next step.

Each step is corrected as a shift is. What it finds at the centres of the parts is what the field of the step before
left there. The continuum of a history is that of the same steps on infinitely many elements. How far a step is from it
is told by a second march, of the same history on half as many elements each way.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np

from varcontact.discrete.contact_grid import across
from varcontact.discrete.discretisation import Discretisation, PreviousStep
from varcontact.discrete.operators import Operators
from varcontact.discrete.state import ContactState, unloaded
from varcontact.discrete.subgrid import means
from varcontact.results.refinement import Refinement
from varcontact.results.solution import Solution
from varcontact.scene.grid import Cells, Grid
from varcontact.scene.motion import TimeStep, Transient
from varcontact.scene.scene import Scene
from varcontact.scene.surfaces import Surface
from varcontact.solvers.statistics import SolveStats
from varcontact.solving.contact_solver import ContactSolver, contact
from varcontact.solving.defect_correction.check import KINDS, LEAST_OF_A_HISTORY, check_count
from varcontact.solving.defect_correction.cliffs import check_cliffs
from varcontact.solving.defect_correction.parts import Brought
from varcontact.solving.defect_correction.passes import PARTS, Corrected
from varcontact.solving.defect_correction.road import (
    estimated,
    finer_pressure,
    friction_on,
    from_a_depth,
    passed,
    recorded,
    roughly,
)
from varcontact.solving.defect_correction.sublattice import loads
from varcontact.solving.finish import finish
from varcontact.solving.march import March, begun, check_held, marching_on, state_of, without_contact, without_load

ROUGH = 1e-7
"""Residual of the coarse solves before the last of a step: what an element slips by or not, all later steps feel."""


@dataclass(frozen=True, eq=False)
class PartsMarch:
    """A march whose steps go on from a field on parts of the elements.

    Attributes
    ----------
    march : March
        On the elements.
    operators : Operators
        On their parts.
    """

    march: March
    operators: Operators
    _finer: dict[tuple[Surface, float | None, float | None], np.ndarray | None] = field(
        default_factory=dict, repr=False
    )

    @property
    def cells(self) -> Cells:
        """Parts of an element along y and along x."""
        (ny, nx), (rows, columns) = self.operators.lattice.shape, self.march.disc.grid.shape
        return ny // rows, nx // columns

    def problem(self, k: int, before: np.ndarray | None) -> tuple[Scene, Discretisation, Brought]:
        """Step k with what the particles bring along: on the parts, and the means of it on the elements.

        Parameters
        ----------
        k : int
            From 0.
        before : ndarray, shape (2, ny rows, nx columns), or None
            The field that the step before left, dimensionless; None: bodies without tractions.
        """
        scene, disc = self.march.problem(k, None)
        motion = scene.motion
        assert isinstance(motion, TimeStep)
        came, force = np.zeros((2, *self.operators.lattice.shape)), np.zeros(2)
        if before is not None and before.any():
            came = self.operators.carrying(motion.direction * motion.dq / disc.scales.length).apply(before)
            force = loads(before, self.operators.lattice)[:2]
        posed = disc.with_loading(previous_step=PreviousStep(means(came, self.cells), force))
        return scene, posed, Brought(came, self.operators)

    def pressed(self, scene: Scene, disc: Discretisation, start: ContactState, steps: ContactSolver) -> ContactState:
        """A step with its pressure, on a grid that holds its contact.

        Parameters
        ----------
        scene, disc
            As of `problem`.
        start : ContactState
            Where the methods begin.
        steps : Steps
        """
        state = steps.pressure(disc, begun(start, steps))
        check_held(scene, disc, state, steps)
        return state

    def corrected(
        self,
        scene: Scene,
        disc: Discretisation,
        state: ContactState,
        brought: Brought,
        steps: ContactSolver,
        last: ContactSolver,
    ) -> Corrected:
        """A step after its passes.

        Parameters
        ----------
        scene, disc, brought
            As of `problem`.
        state : ContactState
            As of `pressed`.
        steps, last : Steps
            The methods of all coarse solves but the last, and of that.
        """
        with last.stats.stage("refinement"):
            if scene.motion.Fx is not None or scene.motion.Fy is not None:
                state = contact(disc, steps, state)  # a force beyond friction is refused as without refinement
            return passed(disc, state, steps, last, self._pressed(scene, disc, last), brought)

    def _pressed(self, scene: Scene, disc: Discretisation, steps: ContactSolver) -> np.ndarray | None:
        """The pressure on parts of the parts: of the last load, as long as that stays."""
        load = scene.surface, scene.normal_force, scene.approach
        if load not in self._finer:
            self._finer.clear()
            self._finer[load] = finer_pressure(scene, disc, steps)
        return self._finer[load]


@dataclass(eq=False)
class Coarser:
    """The same history on half as many elements each way, as far as it has been asked for.

    Attributes
    ----------
    on : PartsMarch
    left : ContactState
        What the last step so far left on the elements.
    traction : ndarray, shape (2, ny rows, nx columns), or None
        What it left on the parts, dimensionless.
    found : list of ndarray
        Fx, Fy, Mz and creepages of the steps so far, physical, (5,) each.
    """

    on: PartsMarch
    left: ContactState
    traction: np.ndarray | None = None
    found: list[np.ndarray] = field(default_factory=list)

    def loads(self, k: int) -> np.ndarray:
        """Fx, Fy, Mz and creepages of step k, physical, (5,); the steps before are solved for it.

        Parameters
        ----------
        k : int
            From 0.
        """
        while len(self.found) <= k:
            self._go_on()
        return self.found[k]

    def _go_on(self) -> None:
        rough = replace(roughly(self.on.march.steps, ROUGH), stats=SolveStats())
        scene, disc, brought = self.on.problem(len(self.found), self.traction)
        if without_load(disc, closed_form=rough.plan.closed_form):
            self.left, self.traction = unloaded(disc.grid), None
            self.found.append(np.array([0.0, 0.0, 0.0, *_rigid(scene)]))
            return
        state = self.on.pressed(scene, disc, self.left, rough)
        found = self.on.corrected(scene, disc, state, brought, rough, rough)
        state = found.state
        self.left = ContactState(state.pressure, state.approach, state.traction, np.zeros(2))
        self.traction = found.traction
        self.found.append(np.concatenate([found.forces[-1], found.creepages[-1]]))


@dataclass(frozen=True, eq=False)
class CorrectedMarch:
    """A march whose steps are corrected towards the continuum. It goes on from its steps as they are in a file.

    Attributes
    ----------
    on : PartsMarch
    coarser : Coarser
    """

    on: PartsMarch
    coarser: Coarser

    def start(self) -> Solution | None:
        """Bodies without tractions: `check_refine` has refused anything else."""
        return None

    def forget(self) -> None:
        """Let go of what the operators keep for the next step."""
        for each in (self.on, self.coarser.on):
            each.march.forget()

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
        steps = replace(self.on.march.steps, stats=SolveStats(told))
        was = None if before is None else before.refinement
        with steps.stats.stage("carried"):
            scene, disc, brought = self.on.problem(
                k, None if was is None else was.traction / self.on.march.disc.scales.pressure
            )
        touches = not without_load(disc, closed_form=steps.plan.closed_form)
        if touches:
            state = self.on.pressed(scene, disc, state_of(disc, before), steps)
            check_cliffs(disc, state)
        with steps.stats.stage("error estimate"):
            coarser = self.coarser.loads(k)
        if not touches:
            bare = without_contact(scene, disc, steps)
            refinement = _nothing(scene, disc.grid.divided(self.on.cells), disc.grid, coarser)
            return replace(bare, refinement=refinement, error_estimate=estimated(bare, refinement))
        found = self.on.corrected(scene, disc, state, brought, roughly(steps, ROUGH), steps)
        refinement = recorded(found, coarser[:3], coarser[3:])
        if before is not None:
            refinement = _remembering(refinement, before, scene, found.state.pressure)
        return finish(scene, found.disc, found.state, steps, refinement)


def corrected_march(scene: Scene, contacts: list[Scene], grid: Grid, steps: ContactSolver) -> CorrectedMarch:
    """The corrected march of a history on its grid, in the scales of the first of its largest contacts.

    Parameters
    ----------
    scene : Scene
        That `check_refine` lets pass, with a `Transient` motion.
    contacts : list of Scene
        Its largest contacts, as frictionless scenes.
    grid : Grid
        Explicit, physical.
    steps : Steps

    Raises
    ------
    SceneError
        If there are too few elements across the largest contact.
    """
    coarser, largest = _halved(scene, contacts, grid), contacts[0]
    motion = scene.motion
    assert isinstance(motion, Transient)
    if motion.dq is None:
        motion = replace(motion, dq=grid.sides[0])
    other = replace(scene, grid=coarser, motion=motion, friction=friction_on(scene, grid, coarser))
    on = _on_parts(marching_on(scene, largest, grid, steps))
    beside = _on_parts(marching_on(other, from_a_depth(largest, on.march.disc), coarser, steps))
    return CorrectedMarch(on, Coarser(beside, unloaded(coarser)))


def _on_parts(march: March) -> PartsMarch:
    disc = march.disc
    return PartsMarch(march, disc.operators.on(disc.lattice.divided((1 if disc.line else PARTS, PARTS))))


def _halved(scene: Scene, contacts: list[Scene], grid: Grid) -> Grid:
    """Half as many elements each way across the largest contact, of which there have to be enough.

    Where contacts have to be solved for, half as many over the same rectangle.
    """
    hertz = [each.hertz for each in contacts if each.hertz is not None]
    (dx, dy), box, margin = grid.sides, grid.box, 0
    if len(hertz) == len(contacts):
        a, b = max(each.a for each in hertz), max(each.b for each in hertz)
        box, margin = (-a, a, -b, b), 1
    left, right, bottom, top = box
    count = (right - left) / dx, (top - bottom) / dy
    check_count(scene, count, LEAST_OF_A_HISTORY)
    nx, ny = math.ceil(count[0] / 2 - 1e-9), None if grid.line else math.ceil(count[1] / 2 - 1e-9)
    return Grid(nx=nx, ny=ny, margin=margin).spread(box)


def _remembering(found: Refinement, before: Solution, scene: Scene, pressure: np.ndarray) -> Refinement:
    """The same with the estimate of the step before, as far as its particles are still in contact.

    What is wrong with a step is in the displacements that its particles bring along, until they leave.
    """
    was, motion, came = before.refinement, scene.motion, before.scene.motion
    assert was is not None and isinstance(motion, TimeStep) and isinstance(came, TimeStep)
    length = across(pressure)[0] * before.grid.sides[0]
    still = max(1 - motion.dq / length, 0.0)
    found_for = [motion.Fx is not None, motion.Fy is not None]
    shifts = was.creepage_estimate * (came.dq or 1.0) / (motion.dq or 1.0) * found_for
    return replace(
        found,
        estimate=np.maximum(found.estimate, still * was.estimate),
        creepage_estimate=np.maximum(found.creepage_estimate, still * shifts),
    )


def _nothing(scene: Scene, parts: Grid, grid: Grid, coarser: np.ndarray) -> Refinement:
    """The record of a step without contact."""
    fields, creepages = np.zeros((2, *parts.shape)), np.array(_rigid(scene))
    return Refinement(
        kind=KINDS[0],
        grid=parts,
        traction=fields,
        slip=fields,
        correction=np.zeros((2, *grid.shape)),
        share=np.ones(grid.shape),
        forces=np.zeros((2, 3)),
        creepages=np.array([creepages, creepages]),
        estimate=np.abs(coarser[:3]),
        creepage_estimate=np.zeros(2),
        seconds=(0.0,),
    )


def _rigid(scene: Scene) -> tuple[float, float]:
    """vx and vy of a step, in place ux and uy, as given."""
    motion = scene.motion
    assert isinstance(motion, TimeStep)
    return motion.rigid[:2]
