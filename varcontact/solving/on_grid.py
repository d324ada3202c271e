"""A scene on its own grid: from the plan to the certified solution."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

from varcontact.results.history import History
from varcontact.results.solution import Solution
from varcontact.scene.friction import Law
from varcontact.scene.motion import Transient
from varcontact.scene.scene import Scene
from varcontact.scene.surfaces import SampledDistance
from varcontact.solvers.conic.programs import Workspace
from varcontact.solvers.statistics import SolveStats
from varcontact.solving.contact_solver import ContactSolver
from varcontact.solving.defect_correction import driver as defect_correction
from varcontact.solving.finish import finish, finish_coarse
from varcontact.solving.history import solve_transient
from varcontact.solving.options import SolveOptions
from varcontact.solving.potential_contact import solve_contact
from varcontact.solving.selection import check_fits
from varcontact.solving.surface_noise import noise_warning

Answer = Solution | History

LOOSE = 1e-4
"""Residual of an answer that another one is extrapolated with: it changes forces by parts of a million at most."""


def solve_on_grid(
    scene: Scene,
    options: SolveOptions,
    progress: Callable[[str], None] | None = None,
    final: bool = True,
    near: Solution | None = None,
    deadline: float = math.inf,
) -> Answer:
    """A scene on its own grid: from the plan to the certified solution.

    Where it is not the `final` grid, without a certificate and to a loose tolerance; a solution `near` is of the same
    scene on another grid. Solvers raise `OutOfTime` at the `deadline`, by `time.perf_counter` [s].
    """
    plan = options.plan_for(scene)
    if final:  # a coarse grid fits where a finer one does
        check_fits(scene, plan)
    certify, tol = (options.certify, options.tol) if final else ("none", max(options.tol, LOOSE))
    continuum = options.target is not None or options.refine
    if isinstance(scene.motion, Transient):
        return solve_transient(
            scene, plan, tol, options.polish, progress, options.store, certify, options.target is not None,
            deadline,
        )  # fmt: skip
    workspace = Workspace() if isinstance(scene.friction, Law) or plan.loops or plan.marches else None
    solver = ContactSolver(
        plan, tol, options.polish, SolveStats(progress), workspace, options.start, certify, final, continuum, deadline
    )
    disc, state = solve_contact(scene, defect_correction.loosely(solver) if options.refine else solver, near=near)
    try:
        if not final:
            return finish_coarse(scene, disc, state, solver)
        if options.refine:
            disc, state, refinement = defect_correction.run(scene, disc, state, solver)
            return finish(scene, disc, state, solver, refinement)
        solution = finish(scene, disc, state, solver)
        if not isinstance(scene.surface, SampledDistance):
            return solution
        warning = noise_warning(scene, disc, state, solver)
        return replace(solution, warnings=(warning,)) if warning else solution
    finally:
        disc.operators.forget()
