"""Rolling in time: the steps of a transient scene one after the other, in memory or in a file."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np

from varcontact.checks import file_name
from varcontact.discrete.contact_grid import common_grid, wanted_grid
from varcontact.errors import Interrupted, SceneError, VarcontactError
from varcontact.io.history import Stored
from varcontact.results.history import History, heat_before, heat_of
from varcontact.results.solution import Solution
from varcontact.scene.grid import Grid
from varcontact.scene.scene import Scene
from varcontact.scene.transient import CONTROLLED, Transient
from varcontact.solvers.interface import SolveStats
from varcontact.solving.contact_solver import ContactSolver
from varcontact.solving.on_grid import solve_contact
from varcontact.solving.options import SolveOptions
from varcontact.solving.time_step import largest_contacts, time_stepping
from varcontact.solving.verify import with_verified_steps
from varcontact.system.process import need

STEP_FIELDS, STEP_REST = 65.0, 1e4
"""Bytes of a step in memory: by element, and for the rest."""


def solve_transient(scene: Scene[Transient], options: SolveOptions) -> History:
    """Solve a transient scene step by step, see `solve`; with a `store`, each step is added to that
    file.

    With a grid chosen for an accuracy or a time, the progress is told the stages within a step,
    too, and the steps are those of `ContactSolver.continuum`. Errors name the step; `Interrupted`
    has the steps that were finished.
    """
    if not isinstance(scene.motion.start, Solution | None):
        raise SceneError("motion.start", scene.motion.start, "a Solution")
    solver = replace(options.solver(scene), refined=True)
    settings = {"tol": solver.tol, "polish": solver.polish}
    progress = options.progress
    if options.store is not None:
        with Stored.recording(
            file_name("store", options.store), scene, solver.plan, settings
        ) as recording:
            stored = with_verified_steps(recording)
            grid = stored.grid if len(stored) else _grid(scene, solver)
            return _solved(History(scene, grid, stored, settings), stored.put, solver, progress)
    spec = wanted_grid(scene)
    steps = list[Solution]()
    kept = bytes_of_steps(scene.motion, spec.nx * spec.rows)
    need("the history in memory", kept, "with store = a file, the steps are kept there")
    history = History(scene, _grid(scene, solver), steps, settings)
    return _solved(history, lambda _, step: steps.append(step), solver, progress)


def _solved(
    history: History,
    keep: Callable[[int, Solution], None],
    solver: ContactSolver,
    progress: Callable[[str], None],
) -> History:
    """The history with the steps that are not solved yet."""
    scene = history.scene
    count = history.scene.motion.steps
    march = time_stepping(scene, history.grid, solver)
    start = march.start()
    before = start if len(history) == 0 else history[-1]
    heated = [*heat_before(start), *map(heat_of, history)] if scene.warm else []

    def tell(stage: str) -> None:
        progress(f"{len(history)} of {count} steps{stage}")

    try:
        for k in range(len(history), count):
            try:
                tell("")
                tell_stage = (lambda stage: tell(f": {stage}")) if solver.continuum else None
                before = march.step(k, before, heated, tell_stage)
                keep(k, before)
                heated += [heat_of(before)] if scene.warm else []
            except VarcontactError as error:
                raise error.in_step(k, history) from error.__cause__
            except KeyboardInterrupt:
                raise Interrupted(history, f" after {len(history)} of {count} steps") from None
    finally:
        march.disc.operators.forget()
    if scene.motion.control is None:
        return history
    solved = [sol.scene for sol in history]  # with the numbers that the control gave
    given: dict[str, Any] = {
        name: [getattr(each, name) for each in solved] for name in ("normal_force", "approach")
    }
    given |= {
        name: [getattr(each.motion, name) for each in solved]
        for name in CONTROLLED.keys() - given.keys()
    }
    return replace(
        history, scene=replace(scene, motion=replace(scene.motion, control=None, **given))
    )


def bytes_of_steps(motion: Transient, elements: int) -> float:
    """About the memory that a history takes, on so many elements of the potential contact."""
    return motion.steps * (STEP_FIELDS * elements + STEP_REST)


def _grid(scene: Scene[Transient], solver: ContactSolver) -> Grid:
    """One grid for the whole history: the scene's own, that of the start, or one that holds every
    contact.
    """
    start = scene.motion.start
    interpolate = scene.motion.interpolate
    if isinstance(scene.grid, Grid) and scene.grid.explicit:
        return scene.grid
    if start is not None and scene.grid == "auto" and not interpolate:
        centres = start.grid.edge == "centres" or solver.plan.coupling != "none"
        return replace(start.grid, edge="centres" if centres else "touched")
    plan = replace(solver.plan, tangential="none", coupling="none")
    grids = []
    for each in largest_contacts(scene):
        disc, _ = solve_contact(each, replace(solver, plan=plan, stats=SolveStats()))
        disc.operators.forget()
        grids.append(disc.grid)
    grid = common_grid(scene, grids)
    if start is not None and not interpolate and np.allclose(start.grid.sides, grid.sides, 1e-9):
        # the same lattice, with more or less room around
        return replace(start.grid, edge=grid.edge)
    return grid
