"""A solution, with its certificate, of a contact whose pressure and tractions are found."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from varcontact.discrete.certificate import Certificate, certificate_of
from varcontact.discrete.discretisation import Discretisation
from varcontact.discrete.residuals import normal_residual
from varcontact.discrete.state import ContactState, means
from varcontact.errors import NotConverged, SceneError
from varcontact.results.physical import solution_of
from varcontact.results.plan import Plan
from varcontact.results.refinement import Refinement
from varcontact.results.report import no_guarantee
from varcontact.results.solution import Solution
from varcontact.scene.motion import TimeStep
from varcontact.scene.scene import Scene
from varcontact.solving.contact_solver import ContactSolver
from varcontact.solving.defect_correction import driver as defect_correction
from varcontact.solving.friction_law import coefficient

ROUNDED = 1e-3
"""The part of the approach that the rounding of distances may be."""


def finish(
    scene: Scene, disc: Discretisation, state: ContactState, solver: ContactSolver, refinement: Refinement | None = None
) -> Solution:
    """The solution, with its certificate; `NotConverged` if its residual misses the tolerance."""
    plan, tol = solver.plan, solver.tol
    approach = state.approach * disc.scales.displacement
    if np.finfo(float).eps * abs(disc.base) > ROUNDED * abs(approach):
        rounded = f"it is rounded to {np.spacing(abs(disc.base)):.1g}, and the bodies approach by only {approach:.3g}"
        raise SceneError("surface.h", disc.base, f"counted from a level near the contact, less a constant: {rounded}")
    if disc.loading.law is not None and plan.has_friction:
        disc = disc.with_loading(coefficient=coefficient(disc, state))
    lazily = plan.matrix_free and solver.certify == "auto"
    with solver.stats.stage("certificate"):
        certificate = certificate_of(disc, state, plan.closed_form, solver.certify, lazily)
    residual = _residual_as_posed(disc, plan, state, certificate)
    if residual > tol and certificate.level != "full" and solver.certify == "auto":  # it may tell why
        certificate = certificate_of(disc, state, plan.closed_form, "full", lazily)
    if not plan.has_moment:
        certificate = certificate.without_moment()
    if not isinstance(disc.loading.motion, TimeStep):  # the solver of a history share its plan
        found = {problem: f"{plan.reasons[problem]}; {why}" for problem, why in state.reasons.items() if why}
        plan = replace(plan, reasons=plan.reasons | found)
    stats = solver.stats
    solution = solution_of(scene, disc, plan, state, certificate, residual <= tol, stats.timing, stats.calls)
    law = disc.loading.law
    followed = law is not None and (
        law.memory_distance > 0 or (law.local and isinstance(disc.loading.motion, TimeStep))
    )
    if law is not None and followed and plan.has_friction:
        lost = (law.static - np.asarray(disc.loading.coefficient)) / max(law.static - law.kinetic, np.finfo(float).tiny)
        solution = replace(solution, weakening=np.clip(lost, 0.0, 1.0))
    if refinement is not None:
        density = means(refinement.power_density, refinement.cells)
        solution = replace(solution, refinement=refinement, power_density=density)
        solution = replace(solution, error_estimate=defect_correction.error_estimate(solution, refinement))
    if not solution.converged:
        raise NotConverged(f"the residual is not below tol = {tol:.3g}{_why(solution, state)}", residual, solution)
    return solution


def finish_coarse(scene: Scene, disc: Discretisation, state: ContactState, solver: ContactSolver) -> Solution:
    """The solution on a coarse grid, as its solvers tell it: without a certificate.

    Where they are not done, and where no single solver can tell, it is judged as any other.
    """
    plan, stats = solver.plan, solver.stats
    if plan.loops or plan.marches or disc.loading.law is not None or not all(state.solved.values()):
        return finish(scene, disc, state, solver)
    return solution_of(scene, disc, plan, state, Certificate.none(), True, stats.timing, stats.calls)


def _why(solution: Solution, state: ContactState) -> str:
    if state.passes:
        change = state.passes[-1][0]
        return f"; this is the best of {len(state.passes)} passes, the last of which changed {change:.1e}"
    words = [f"{getattr(solution.plan, problem)} says {word!r}" for problem, word in solution.status.items() if word]
    reason = no_guarantee(solution) if solution.certificate.level == "full" else ""
    return "".join(f"; {part}" for part in [*words, *([reason] if reason else [])])


def _residual_as_posed(disc: Discretisation, plan: Plan, state: ContactState, certificate: Certificate) -> float:
    """The residual by which a solution is accepted: of the problems that the plan poses.

    Hertz's pressure is a formula, and so are the approximate theories; Johnson's process poses the normal problem
    without tractions, and what the whole then lacks is its own approximation, found in the certificate.
    """
    if not plan.has_friction or plan.theory is not None:
        return 0.0 if plan.closed_form else certificate.normal_residual
    if plan.closed_form:  # also where friction is zero all over the contact, and there is nothing but pressure
        return certificate.tangential_residual
    if not plan.one_pass:
        return certificate.residual
    alone = normal_residual(disc.normal_problem(), state.pressure.ravel(), np.array([state.approach]))
    return float(np.max([alone, certificate.tangential_residual]))  # NaN where one is
