"""One step of a history: a problem like that of a shift, from what the step
before left (paper, 4.2, 6.2, 6.4).

The particle now at x was at ``x + dq`` a step ago and brings its displacement
difference along, so the local shift is ``E = W - u' + A p`` with ``u' = C p'``
known: the operator is symmetric, and each step a convex program.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from varcontact.discrete.certificate import Certificate, ForceBounds
from varcontact.discrete.contact_grid import beyond, interpolated, sampled
from varcontact.discrete.discretisation import Discretisation, discretise
from varcontact.discrete.loading import PreviousStep
from varcontact.discrete.operators import Operators
from varcontact.discrete.penetration import outside
from varcontact.discrete.state import (
    ContactState,
    divided,
    hertz_approach,
    unloaded,
    with_subgrid,
)
from varcontact.discrete.stick_slip import STICK, ContactResponse, unit_slip
from varcontact.elasticity.beside import LoadsBeside, loads_beside
from varcontact.elasticity.fft_products import table_bytes
from varcontact.elasticity.of_scenes import FREE_DEPTH, medium_of, medium_on
from varcontact.elasticity.viscoelastic import Lagging, ViscoelasticMedium, moved, relaxed
from varcontact.errors import NoContact, Saturated, SceneError
from varcontact.interfaces.heat import Heat
from varcontact.interfaces.interface import BetweenBodies, Fields, Quantity
from varcontact.interfaces.kinds import interface_of
from varcontact.interfaces.laws import WEAKENING
from varcontact.results.physical import solution_of, step_before
from varcontact.results.solution import Solution
from varcontact.scene.bodies import BodyPair
from varcontact.scene.grid import Cells, Grid
from varcontact.scene.motion import TimeStep
from varcontact.scene.scene import Scene
from varcontact.scene.transient import Transient
from varcontact.solvers.interface import SolveStats
from varcontact.solving.contact_solver import ContactSolver, solve_pressure_and_tractions
from varcontact.solving.on_grid import finish
from varcontact.system.process import changed, lazy_property, need

INTERPOLATED = {WEAKENING}
"""Quantities of a start that particles need not bring along to another grid."""
RELAXATION_TIMES = 24.0
"""Relaxation times after which past tractions are neglected."""


LONG_STEP = 1.25
"""Length of a step of rolling, in elements, above which tractions that stick are wavy. Carter's
contact of 40 elements, rolled over three half-widths, has errors of 2 % of the traction bound up to
1.1, 6 % at 1.5, 10 % at 2, 16 % at 3."""


def largest_contacts(scene: Scene[Transient]) -> list[Scene]:
    """The steps of a history with the largest load on each surface, as frictionless scenes;
    `NoContact` if none.

    Viscoelastic bodies are relaxed: their contact then is the largest under a load.
    """
    largest: dict[tuple[int, bool], tuple[float, Scene]] = {}
    bodies = scene.bodies.relaxed if isinstance(scene.bodies, BodyPair) else scene.bodies
    bare: dict[str, Any] = {"bodies": bodies, "friction": None, "motion": None}
    for k in range(scene.motion.steps):
        surface, force, approach = scene.contact(k)
        load = force
        if force is None:
            load = approach
        assert load is not None
        key = (id(surface), force is None)
        if force == 0 or (key in largest and largest[key][0] >= load):
            continue
        loaded: dict[str, Any] = {"normal_force": force, "approach": approach, "surface": surface}
        with suppress(NoContact):
            largest[key] = load, replace(scene, **loaded, **bare)
    if not largest:
        allowed = "a history in which the bodies touch once at least"
        raise NoContact("motion", "no load in any step", allowed)
    return [frictionless for _, frictionless in largest.values()]


def time_stepping(scene: Scene[Transient], grid: Grid, solver: ContactSolver) -> TimeStepping:
    """The steps of a history on its explicit grid, in the scales of the first of its
    `largest_contacts`.

    Pressures are scaled by a power of two: a state survives the way to physical units and back bit
    for bit.
    """
    disc = discretise(replace(largest_contacts(scene)[0], grid=grid), grid)
    scales = replace(disc.scales, pressure=float(2.0 ** np.round(np.log2(disc.scales.pressure))))
    if not scene.bodies.relaxes:
        return TimeStepping(scene, replace(disc, scales=scales), solver)
    disc = replace(
        disc, bodies=scene.bodies, scales=replace(scales, modulus=scene.bodies.combined_G)
    )
    return _viscoelastic(scene, disc, solver)


def _viscoelastic(
    scene: Scene[Transient], disc: Discretisation, solver: ContactSolver
) -> TimeStepping:
    """The steps of viscoelastic bodies, with columns around the grid for tractions of the past."""
    grid = disc.grid
    length = disc.scales.length
    depth = scene.reference_depth
    time = scene.bodies.longest_relaxation
    depth_min = max(length, _rolled_within(scene.motion, time, grid))
    if depth is None:
        depth = FREE_DEPTH * depth_min
    elif depth < depth_min:
        rolled = "what is rolled in the longest relaxation time"
        allowed = f"at least the grid's length, and {rolled}: {depth_min:.6g}"
        raise SceneError("surface.reference_depth", depth, allowed)
    # relaxation lengths then are times
    medium = medium_of(scene.bodies, length, depth / length, speed=length)
    assert isinstance(medium, ViscoelasticMedium)

    # the columns, and their memory
    rolled_in_memory = _rolled_within(scene.motion, RELAXATION_TIMES * time, grid)
    columns = 1 + math.ceil(rolled_in_memory / grid.sides[0])
    start = scene.motion.start
    if start is not None and start.memory is not None:
        columns += max(0, start.memory.shape[-1] - grid.nx) // 2
    rows = grid.rows + 2
    numbers = 8 * 3 * scene.motion.steps * len(medium.lagging)
    wide = grid.nx + 2 * columns
    taken = table_bytes(rows, wide, 9) + numbers * rows * wide
    need(
        "what viscoelastic bodies remember", taken, "longer elements or steps, or fewer, need less"
    )
    on_lattice = medium_on(scene, grid, length, depth / length, speed=length)
    disc = replace(disc, operators=Operators(disc.lattice, on_lattice))
    return TimeStepping(scene, disc, solver, columns, medium.lagging)


def _rolled_within(motion: Transient, time: float, grid: Grid) -> float:
    """The greatest distance that the bodies roll within a time [length]."""
    steps = [motion.step(k, grid.sides[0]) for k in range(motion.steps)]
    t = np.cumsum([0.0, *(step.dt or 0.0 for step in steps)])
    rolled = np.cumsum([0.0, *(step.dq for step in steps)])
    return float(np.max(rolled - rolled[np.maximum(np.searchsorted(t, t - time) - 1, 0)]))


@dataclass(frozen=True, eq=False)
class TimeStepping:
    """The scene, the grid and its scales, the operators and the methods that all steps share.

    Past tractions of viscoelastic bodies are known on `columns` more on either side of the grid. A
    step takes nothing but the solutions before it, as they are in physical units: a history that
    goes on from its file is the same, bit for bit, as one that was not interrupted.
    """

    scene: Scene[Transient]
    disc: Discretisation
    solver: ContactSolver
    columns: int = 0
    lagging: tuple[Lagging, ...] = ()

    @lazy_property
    def _carried(self) -> list[Quantity]:
        """The quantities that particles carry in some step."""
        scene = self.scene
        grid = self.disc.grid
        motion = scene.motion.step(0, grid.sides[0])
        between = (
            BetweenBodies(scene, friction, motion, grid, self.disc.scales)
            for friction in scene.frictions
        )
        return [each for given in between for each in interface_of(given).carried]

    def start(self) -> Solution | None:
        """The solution before the first step; a `SceneError` refuses one on another grid, if it is
        not to be interpolated.
        """
        start = self.scene.motion.start
        if start is None:
            return None
        grid = self.disc.grid
        memory = start.memory
        if self.scene.bodies.relaxes:
            self._check_past(start)
        size = max(abs(side) for side in grid.box)
        same_box = np.allclose(start.grid.box, grid.box, rtol=0, atol=1e-9 * size)
        if start.grid.shape == grid.shape and same_box:
            if memory is None:
                return start
            more = self.columns - (memory.shape[-1] - grid.nx) // 2
            wider = np.pad(memory, 3 * [(0, 0)] + [(more, more)])
            return replace(start, carried={**start.carried, "memory": wider})
        self._check_interpolation(start)
        fields = interpolated(
            start.grid,
            np.concatenate([start.traction, [start.pressure, start.power_density], start.slip]),
            grid,
        )
        placed = {"traction": fields[:2], "pressure": fields[2], "power_density": fields[3]}
        placed |= {"slip": fields[4:]}
        placed |= {"state": sampled(start.grid, start.state, grid)}
        # its pressure is no solution on this grid
        return replace(start, grid=grid, **placed, pressure_on_parts=None, carried={}, solved_by={})

    def _check_past(self, start: Solution) -> None:
        if start.memory is None or start.scene.bodies != self.scene.bodies:
            allowed = (
                "a step of a history of these viscoelastic bodies: else their past is not known"
            )
            raise SceneError("motion.start", type(start.motion).__name__, allowed)

    def _check_interpolation(self, start: Solution) -> None:
        """Refuse a start on another grid unless interpolation was requested, and if particles'
        memory is on the start's own grid.
        """
        grid = self.disc.grid
        on_own_grid = not INTERPOLATED.issuperset(start.carried)
        if start.grid.line != grid.line or on_own_grid:
            remedy = ""
        elif not self.scene.motion.interpolate:
            remedy = ", or interpolate = True"
        else:
            return
        allowed = f"on the same grid as the history, {_described(grid)}{remedy}"
        raise SceneError("motion.start", f"a Solution on {_described(start.grid)}", allowed)

    def step(
        self,
        k: int,
        before: Solution | None,
        earlier: Solution | None = None,
        heated: Sequence[Heat] = (),
        progress: Callable[[str], None] | None = None,
    ) -> Solution:
        """Step k, from 0, after the step before, or bodies without tractions; under a law by
        temperature `heated`.

        The step `earlier` than that shows solvers where to begin.
        """
        solver = changed(self.solver, stats=SolveStats(progress))
        with solver.stats.stage("carried"):
            scene, disc = self.problem(k, before, heated)
        begin = initial_state(disc, before, earlier, solver)
        solution = self._solved(scene, disc, before, begin, solver)
        if self.lagging:
            motion = scene.motion
            weights = np.array(
                [relaxed((motion.dt or 0.0) / each.length)[2] for each in self.lagging]
            )
            memory = weights[:, None, None, None] * self._wide(solution)
            if before is not None:
                passed = motion.direction * motion.dq / self.disc.grid.sides[0]
                memory = memory + moved(self._kept(motion, before), passed)
            solution = changed(solution, carried={**solution.carried, "memory": memory})
        fresh = {
            each.name: np.full(self._shape(each), each.fresh * each.scale(self.disc.scales))
            for each in self._carried
            if each.name not in solution.carried
        }
        return changed(solution, carried={**solution.carried, **fresh})

    def problem(
        self, k: int, before: Solution | None, heated: Sequence[Heat] = ()
    ) -> tuple[Scene, Discretisation]:
        """Step k by itself, with the displacement differences ``u' = C p'`` and the heat that
        particles bring along.
        """
        scene = self._scene_of_step(k, before)
        step = self.disc.at_step(scene)
        if before is None:
            return scene, step
        arrived: Fields = {}
        if self._carried or heated:
            left = step_before(before, step, heated)
            arrived = step.interface.arrive(left, step.surroundings)
        loaded = step.with_loading(
            arrived=arrived,
            beside_before=self._beside(before.scene),
            previous_step=self._previous_step(scene.motion, before),
        )
        return scene, loaded

    def _previous_step(self, motion: TimeStep, before: Solution) -> PreviousStep | None:
        """Previous step as the next one uses it; None where it left no tractions."""
        disc = self.disc
        fields = before.traction
        if disc.K != 0:
            fields = np.concatenate([before.traction, before.pressure[None]])
        if before.memory is None and not fields.any():
            return None
        distance = motion.direction * motion.dq / disc.scales.length
        force = before.traction.sum(axis=(1, 2)) / disc.scales.pressure * disc.lattice.area
        fields = fields / disc.scales.pressure
        displacement = disc.operators.at_once.carrying(distance).apply(fields)
        previous = PreviousStep(displacement, force, fields)
        if before.memory is None:
            return previous
        return self._with_memory(previous, motion, before)

    def _beside(self, scene: Scene) -> LoadsBeside | None:
        """Loads beside the contact in the scene of a step."""
        if scene.loads_as(self.scene):
            return self.disc.loading.beside
        return loads_beside(scene, self.disc.scales.length)

    def _scene_of_step(self, k: int, before: Solution | None) -> Scene:
        """Step k by itself, with the motion that a control gives it."""
        grid = self.disc.grid
        motion = self.scene.motion
        if motion.control is None:
            return self.scene.step(k, grid)
        try:
            changes = motion.control(k, before)
        except Exception as error:  # the user's own code runs here
            message = f"motion.control failed: {type(error).__name__}: {error}"
            raise SceneError(
                "motion.control", k, "a function that works in every step", message=message
            ) from error
        alone = motion.alone(k, grid.sides[0], changes)
        return replace(self.scene, motion=alone).step(0, grid)

    def _with_memory(
        self, previous: PreviousStep, motion: TimeStep, before: Solution
    ) -> PreviousStep:
        """Previous step, with the displacements of viscoelastic bodies by past tractions."""
        disc = self.disc
        ahead = self.columns
        ny, nx = disc.grid.shape
        operators = disc.operators
        pressure = disc.scales.pressure
        passed = motion.direction * motion.dq / disc.grid.sides[0]
        window = disc.lattice.window(-ahead, nx + ahead, -1, ny + 1)
        inside = slice(0, 1) if disc.grid.line else slice(1, -1), slice(ahead, ahead + nx)
        around = 2, slice(None), slice(ahead - 1, ahead + nx + 1)
        left = operators.at_once.every.apply(self._wide(before)[:, *inside] / pressure)[:2]
        displacement = previous.displacement
        distance = np.zeros(1)
        force = previous.force
        stiffness = 1.0
        kept = self._kept(motion, before)
        for each, gone, stays in zip(self.lagging, before.memory - kept, kept, strict=True):
            every = operators.of(each.medium, window).every
            _, _, new = relaxed((motion.dt or 0.0) / each.length)
            fields = np.array([gone, moved(gone, passed), moved(stays, passed)])
            fields *= each.factor / pressure
            left = left + every.apply(fields[0])[:2, *inside]
            displacement = displacement + every.apply(fields[1])[:2, *inside]
            distance = distance + every.apply(fields[2])[around]
            stiffness = stiffness + each.factor * new
            force = force + fields[0, :2].sum(axis=(1, 2)) * disc.lattice.area
        return replace(
            previous,
            displacement=displacement,
            force=force / stiffness,
            left=left,
            distance=distance,
        )

    def _kept(self, motion: TimeStep, before: Solution) -> np.ndarray:
        """Past tractions (relaxations, 3, ..., ...) that particles remember after a step, at their
        places before it.
        """
        assert before.memory is not None
        weights = [relaxed((motion.dt or 0.0) / each.length) for each in self.lagging]
        then = self._wide(before)
        return np.array(
            [w[0] * memory + w[1] * then for w, memory in zip(weights, before.memory, strict=True)]
        )

    def _shape(self, quantity: Quantity) -> tuple[int, ...]:
        """The shape of a quantity on the grid."""
        shape = self.disc.grid.shape
        return (2, *shape) if quantity.dims[0] == "component" else shape

    def _wide(self, solution: Solution) -> np.ndarray:
        """Tractions and pressure (3, ..., ...) with as many elements around as particles are
        remembered on.
        """
        rows = (0, 0) if self.disc.grid.line else (1, 1)
        fields = np.concatenate([solution.traction, solution.pressure[None]])
        return np.pad(fields, ((0, 0), rows, (self.columns, self.columns)))

    def _keeps_pressure(self, scene: Scene, before: Solution) -> bool:
        """True where the normal problem is that of the previous step: like bodies under the same
        load.
        """
        was = before.scene
        if not isinstance(was.motion, TimeStep) or before.pressure_on_parts is not None:
            return False
        normal = before.solved_by.get("normal")
        solved = before.pressure.any() and normal is not None
        known = normal == "hertz" or math.isfinite(before.approach)
        if scene.coupled or scene.bodies.relaxes or not (solved and known):
            return False
        return scene.same_normal_contact(was)

    def _solved(
        self,
        scene: Scene,
        disc: Discretisation,
        before: Solution | None,
        state: ContactState,
        solver: ContactSolver,
    ) -> Solution:
        cells = solver.plan.cells(scene)
        if without_load(disc, solver.plan.closed_form, cells):
            return _without_contact(scene, disc, solver, cells)
        if before is not None and self._keeps_pressure(scene, before):
            state = _with_pressure_before(disc, state, before)
        else:
            disc, state = _with_pressure(disc, state, solver, cells)
        state = solve_pressure_and_tractions(disc, solver, state)
        with solver.stats.stage("grid"):
            overlap = outside(disc, state, solver.plan.closed_form)
        if overlap is not None:
            raise beyond(scene.surface, disc.grid, state.pressure, overlap)
        solution = finish(scene, disc, state, solver)
        if not solver.plan.has_friction:
            return solution
        response = ContactResponse(disc, state)
        sentences = [
            long_step_warning(solution),
            *disc.interface.warnings(response, disc.surroundings),
        ]
        return changed(solution, warnings=(*solution.warnings, *filter(None, sentences)))


def _without_contact(
    scene: Scene, disc: Discretisation, solver: ContactSolver, cells: Cells
) -> Solution:
    """Solution of a step at which the bodies are apart."""
    motion = scene.motion
    size = math.hypot(motion.Fx or 0.0, motion.Fy or 0.0)
    if size > 0:
        raise Saturated(size, 0.0)
    if cells != (1, 1):
        disc = with_subgrid(disc, np.zeros(disc.grid.divided(cells).shape))
    approach = 0.0
    if scene.approach is not None:
        approach = (scene.approach - disc.base) / disc.scales.displacement
    state = changed(unloaded(disc.grid), approach=approach)
    exact = Certificate(
        gap=0.0,
        relative_gap=0.0,
        residual=0.0,
        normal_relative_gap=0.0,
        normal_residual=0.0,
        tangential_residual=0.0,
        level="full",
        bounds=ForceBounds(np.zeros(3), np.zeros(3)),
    )
    response = ContactResponse(disc, state)
    return solution_of(scene, response, solver.plan, exact, True, solver.stats)


def _with_pressure_before(
    disc: Discretisation, state: ContactState, before: Solution
) -> ContactState:
    """The contact with the pressure of the step before, which the state has."""
    normal = before.solved_by["normal"]
    approach = state.approach
    if normal == "hertz":  # also where a solution has none
        approach = hertz_approach(disc)
    return changed(state, approach=approach, solved_by={"normal": normal})


def _with_pressure(
    disc: Discretisation, state: ContactState, solver: ContactSolver, cells: Cells
) -> tuple[Discretisation, ContactState]:
    """The contact with the pressure of a step."""
    if solver.plan.coupling == "johnson":
        bare = solver.pressure(disc, replace(state, traction=np.zeros_like(state.traction)))
        return disc, replace(bare, traction=state.traction)
    if cells != (1, 1):
        return solver.pressure_on_subgrid(disc, state)
    return disc, solver.pressure(disc, state)


def long_step_warning(solution: Solution) -> str:
    """A sentence where a step of rolling is longer than an element; or nothing.

    Particles that stick keep the shift they have had since their first step: those that entered the
    contact at other places of the same element row have other tractions, and only every dq/dx-th
    element goes on from the same particle.
    """
    motion = solution.motion
    dx = solution.grid.sides[0]
    assert isinstance(motion, TimeStep)
    if motion.dq <= LONG_STEP * dx or not np.any(solution.state == STICK):
        return ""
    return (
        f"steps of dq = {motion.dq:.4g} are longer than an element of {dx:.4g}: where the surfaces "
        "stick, tractions go up and down along x with the period dq, while forces hardly change; "
        f"take dq = {_below(dx):.4g} or less"
    )


def _described(grid: Grid) -> str:
    """The grid as an error names it."""
    box = tuple(float(f"{side:.6g}") for side in grid.box)
    return f"{grid.nx} x {grid.rows} elements over {box}"


def _below(value: float) -> float:
    """The value, rounded down to four digits."""
    unit = 10.0 ** (math.floor(math.log10(value)) - 3)
    return math.floor(value / unit) * unit


def initial_state(
    disc: Discretisation, before: Solution | None, earlier: Solution | None, solver: ContactSolver
) -> ContactState:
    """The state where the methods begin, in the scales of the discretisation: that of the step
    before, with tractions and creepages that change as in the step `earlier`.

    As printed, TANG does best from its own start: on the areas of the step before its Newton's
    method fails.
    """
    if before is None:
        return unloaded(disc.grid)
    motion = disc.loading.motion
    was = before.scene.motion
    scales = disc.scales
    rigid = np.zeros(2)
    assert motion is not None
    in_rolling = motion.rolls and getattr(was, "rolls", 0)
    traction = before.traction
    creepage = _known(before.creepage)
    if motion.rolls and _rolled_in_contact(before) and _rolled_in_contact(earlier):
        assert earlier is not None
        traction = 2 * traction - earlier.traction
        creepage = 2 * creepage - _known(earlier.creepage)
    traction = traction / scales.pressure
    if in_rolling:
        prescribed = [motion.Fx is not None, motion.Fy is not None]
        rigid = np.where(prescribed, creepage * unit_slip(disc), 0.0)
    approach = 0.0
    if np.isfinite(before.approach):
        approach = (before.approach - disc.base) / scales.displacement
    if solver.plan.tangential in ("tang", "tang-exact") and solver.plan.coupling == "none":
        traction = np.zeros_like(traction)
    return ContactState(before.pressure / scales.pressure, approach, traction, rigid)


def _known(creepage: Sequence[float]) -> np.ndarray:
    """Creepages along x and y; zero where they are not unique."""
    return np.array([0.0 if math.isnan(each) else each for each in creepage[:2]])


def _rolled_in_contact(step: Solution | None) -> bool:
    """True of a step in rolling with a contact."""
    if step is None or not getattr(step.scene.motion, "rolls", 0):
        return False
    return bool(step.pressure.any())


def without_load(disc: Discretisation, closed_form: bool, cells: Cells = (1, 1)) -> bool:
    """True if a step has no contact: no load, or an approach at which no element's centre is in
    contact.
    """
    if disc.loading.approach is None:
        return disc.loading.normal_force == 0
    distance = (disc if cells == (1, 1) else divided(disc, cells)).distance
    if disc.loading.approach <= float(
        np.min(distance + disc.known_distance * disc.scales.displacement)
    ):
        return True
    if not closed_form:
        return False
    assert disc.hertz is not None
    return not disc.hertz.on_elements(disc.grid).any()
