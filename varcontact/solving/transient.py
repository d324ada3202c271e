"""Rolling in time: each step is a problem like that of a shift, from what the step before left (paper, 4.2, 6.2, 6.4).

The particle now at x was at ``x + dq`` a step ago and brings its displacement difference along, so the local shift is
``E = W - u' + A p`` with ``u' = C p'`` known: the operator is symmetric, and each step a convex program.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from varcontact.checks import file_name
from varcontact.discrete.contact_grid import common_grid, wanted_grid
from varcontact.errors import Interrupted, NoContact, SceneError, VarcontactError
from varcontact.io.history import Stored
from varcontact.results.history import History
from varcontact.results.plan import Plan
from varcontact.results.solution import Solution
from varcontact.scene.grid import Edge, Grid
from varcontact.scene.motion import Transient
from varcontact.scene.scene import Scene
from varcontact.solvers.statistics import SolveStats
from varcontact.solving.contact_solver import ContactSolver
from varcontact.solving.potential_contact import solve_contact
from varcontact.solving.time_step import marching_on
from varcontact.system.memory import need

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
    chosen: bool = False,
    deadline: float = math.inf,
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
    chosen : bool
        Whether the grid is chosen for an accuracy or a time: the progress is told the stages within a step, too, and
        the steps are those of `Steps.continuum`.
    deadline : float
        See `Steps`.

    Raises
    ------
    VarcontactError
        As of `solve`, with the step in its message.
    Interrupted
        With the steps that were finished.
    """
    if not isinstance(_motion(scene).start, Solution | None):
        raise SceneError("motion.start", _motion(scene).start, "a Solution")
    steps = ContactSolver(plan, tol, polish, SolveStats(), certify=certify, continuum=chosen, deadline=deadline)
    settings: dict[str, Any] = {"tol": tol, "polish": polish}
    if store is None:
        return _solved(scene, steps, settings, progress, None, chosen)
    with Stored.recording(file_name("store", store), scene, plan, settings) as stored:
        return _solved(scene, steps, settings, progress, stored, chosen)


def _solved(
    scene: Scene,
    steps: ContactSolver,
    settings: dict[str, Any],
    progress: Callable[[str], None] | None,
    recording: Stored | None,
    stages: bool,
) -> History:
    """The steps that are not solved yet, in memory or in the file that they are recorded in."""
    from varcontact.solving.verify import with_measured_steps

    motion, stored = _motion(scene), None if recording is None else with_measured_steps(recording)
    if stored is None:
        spec = wanted_grid(scene)
        kept = bytes_of_steps(motion, spec.nx * spec.rows)
        need("the history in memory", kept, "with store = a file, the steps are kept there")
    contacts = largest_contacts(scene)
    grid = stored.grid if stored is not None and len(stored) else _grid(scene, contacts, steps)
    march = marching_on(scene, contacts[0], grid, steps)
    in_memory: list[Solution] = []
    history = History(scene, grid, in_memory if stored is None else stored, settings)
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
        march.forget()
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


def _edge_of_steps(grid: Grid, steps: ContactSolver) -> Edge:
    """The edge of the start's `grid` as steps can have it: never softened, and by centres where tractions count."""
    if grid.edge == "centres" or steps.plan.coupling != "none":
        return "centres"
    return "touched"


def _grid(scene: Scene, contacts: list[Scene], steps: ContactSolver) -> Grid:
    """One grid for the whole history: the scene's own, that of the start, or one that holds every contact."""
    motion = _motion(scene)
    if isinstance(scene.grid, Grid) and scene.grid.explicit:
        return scene.grid
    if motion.start is not None and scene.grid == "auto" and not motion.interpolate:
        return replace(motion.start.grid, edge=_edge_of_steps(motion.start.grid, steps))
    plan = replace(steps.plan, tangential="none", coupling="none")
    found = [solve_contact(each, replace(steps, plan=plan, stats=SolveStats())) for each in contacts]
    for disc, _ in found:
        disc.operators.forget()
    grid = common_grid(scene, [disc.grid for disc, _ in found])
    if motion.start is not None and not motion.interpolate and np.allclose(motion.start.grid.sides, grid.sides, 1e-9):
        return replace(motion.start.grid, edge=grid.edge)  # the same lattice, with more or less room around
    return grid
