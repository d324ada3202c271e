"""Rolling in time: the steps of a transient scene one after the other, in memory or in a file."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np

from varcontact.checks import file_name
from varcontact.discrete.contact_grid import PotentialContact, common_grid
from varcontact.errors import Interrupted, SceneError, VarcontactError
from varcontact.results.history import History, heat_matters, heat_of, heat_so_far
from varcontact.results.solution import Solution
from varcontact.scene.grid import Grid
from varcontact.scene.scene import Scene
from varcontact.scene.transient import CONTROLLED, Transient
from varcontact.solvers.interface import SolveStats
from varcontact.solving.contact_solver import ContactSolver
from varcontact.solving.on_grid import solve_contact
from varcontact.solving.options import SolveOptions
from varcontact.solving.time_step import largest_contacts, time_stepping
from varcontact.system.process import need

STEP_BYTES_PER_ELEMENT = 65.0
"""Bytes of a step in memory, per element."""
STEP_BYTES = 1e4
"""Bytes of a step in memory beside its fields."""


def solve_transient(scene: Scene[Transient], options: SolveOptions) -> History:
    """Solve a transient scene step by step, see `solve`; with a `store`, each step is added to that
    file.

    With a grid chosen for an accuracy or a time, the progress includes the stages within a step,
    and the steps are those of `ContactSolver.continuum`. Errors name the step; `Interrupted`
    has the steps that were finished.
    """
    if not isinstance(scene.motion.start, Solution | None):
        raise SceneError("motion.start", scene.motion.start, "a Solution")
    solver = replace(options.solver(scene), loose_tolerance=False)
    settings = {"tol": solver.tol, "polish": solver.polish}
    if options.store is not None:
        from varcontact.io.history import Stored
        from varcontact.solving.verify import with_verified_steps

        file = file_name("store", options.store)
        with Stored.recording(file, scene, solver.plan, settings) as recording:
            stored = with_verified_steps(recording)
            grid = stored.grid if len(stored) else _grid(scene, solver)
            history = History(scene, grid, stored, settings)
            return _solved(history, stored.put, solver, options.progress)
    potential = solver.plan.potential_contact
    potential.check_size()
    taken = bytes_of_steps(scene.motion, potential.form.nx * potential.form.rows)
    need("the history in memory", taken, "with store = a file, the steps are kept there")
    steps = list[Solution]()
    history = History(scene, _grid(scene, solver), steps, settings)
    return _solved(history, lambda _, step: steps.append(step), solver, options.progress)


def _solved(
    history: History,
    keep: Callable[[int, Solution], None],
    solver: ContactSolver,
    progress: Callable[[str], None],
) -> History:
    """The history with the steps that are not solved yet."""
    scene = history.scene
    count = history.scene.motion.steps
    stepping = time_stepping(scene, history.grid, solver)
    start = stepping.start()
    before = start if len(history) == 0 else history[-1]
    earlier = None if len(history) < 2 else history[-2]
    keeps_heat = heat_matters(scene)
    heated = heat_so_far(scene, start, map(heat_of, history))

    def tell_stage(stage: str) -> None:
        progress(f"{len(history)} of {count} steps: {stage}")

    for k in range(len(history), count):
        try:
            progress(f"{len(history)} of {count} steps")
            tell = tell_stage if solver.continuum else None
            solution = stepping.step(k, before, earlier, heated, tell)
            keep(k, solution)
            earlier = None if k == 0 else before
            before = solution
            if keeps_heat:
                heated.append(heat_of(before))
        except VarcontactError as error:
            raise error.in_step(k, history) from error.__cause__
        except KeyboardInterrupt:
            raise Interrupted(history, f" after {len(history)} of {count} steps") from None
    if scene.motion.control is None:
        return history
    return _with_controlled(history)


def _with_controlled(history: History) -> History:
    """The history with the numbers that the control gave, in place of the control."""
    scene = history.scene
    scenes = [sol.scene for sol in history]
    controlled: dict[str, Any] = {}
    for name in ("normal_force", "approach"):
        controlled[name] = [getattr(each, name) for each in scenes]
    for name in CONTROLLED.keys() - controlled.keys():
        controlled[name] = [getattr(each.motion, name) for each in scenes]
    motion = replace(scene.motion, control=None, **controlled)
    return replace(history, scene=replace(scene, motion=motion))


def bytes_of_steps(motion: Transient, elements: int) -> float:
    """About the memory that a history takes with a number of elements of the potential contact."""
    return motion.steps * (STEP_BYTES_PER_ELEMENT * elements + STEP_BYTES)


def _grid(scene: Scene[Transient], solver: ContactSolver) -> Grid:
    """Grid of the whole history: the scene's own, that of the start, or one that contains every
    contact.
    """
    start = scene.motion.start
    interpolate = scene.motion.interpolate
    if isinstance(scene.grid, Grid) and scene.grid.explicit:
        return scene.grid
    if start is not None and scene.grid == "auto" and not interpolate:
        centres = start.grid.edge == "centres" or solver.plan.coupling != "none"
        return replace(start.grid, edge="centres" if centres else "touched")
    grids = []
    for each in largest_contacts(scene):
        alone = PotentialContact.of(each)
        plan = replace(solver.plan, tangential="none", coupling="none", grid=alone)
        disc, _ = solve_contact(each, replace(solver, plan=plan, stats=SolveStats()))
        grids.append(disc.grid)
    grid = common_grid(scene, solver.plan.potential_contact, grids)
    if start is not None and not interpolate and np.allclose(start.grid.sides, grid.sides, 1e-9):
        # the same lattice, with a different margin
        return replace(start.grid, edge=grid.edge)
    return grid
