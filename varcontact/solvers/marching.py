"""Rolling in time: steps from one state of the tractions to the next, until the steady state.

Source: J. J. Kalker, Three-Dimensional Elastic Bodies in Rolling Contact, Kluwer 1990.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from varcontact.discrete.problems import RawSolution, TangentialProblem
from varcontact.discrete.residuals import tangential_residual
from varcontact.solvers.interface import Settings

Solver = Callable[[TangentialProblem, Settings, RawSolution | None], RawSolution]

MAX_STEPS = 2000
IDLE_STEPS, NEARLY_STILL = 5, 1e-4
"""A march ends when it hardly moves, relative to the largest traction, and has come no nearer in this many steps."""


def march(solver: Solver, problem: TangentialProblem, settings: Settings, start: RawSolution | None) -> RawSolution:
    """Steady rolling without the gap program: transient steps, from no traction at all, until nothing changes.

    In a step the displacements ``u' = C p'`` of the step before are known, and the `solver` takes a problem like that
    of a shift with the rigid shift ``W - u'``: symmetric, and an optimisation. `status` is "Steady", "MaxSteps", or the
    solver's own word where it gave no number, or failed in a last step short of the tolerance.
    """
    assert problem.instant is not None
    inner = replace(settings, formulation="auto", tol=0.1 * settings.tol)
    at = start or RawSolution(np.zeros_like(problem.rigid_shift), np.zeros(problem.components), 0, "")
    iterations, status, least, idle = 0, "MaxSteps", np.inf, 0
    for _ in range(MAX_STEPS):
        previous = problem.instant.apply(at.traction) - problem.operator.apply(at.traction)  # C p'
        shift = problem.rigid_shift - previous
        step = replace(problem, operator=problem.instant, rigid_shift=shift, symmetric=True, instant=None)
        raw = solver(step, inner, at)
        iterations += raw.iterations
        if not (np.isfinite(raw.traction).all() and np.isfinite(raw.rigid).all()):
            status = raw.status
            break
        change = float(np.abs(raw.traction - at.traction).max())
        at = raw
        residual = tangential_residual(problem, raw.traction, raw.rigid)
        idle = 0 if residual < least else idle + 1
        least = min(least, residual)
        still = change <= NEARLY_STILL * float(np.abs(raw.traction).max())
        if residual <= settings.tol or (still and idle >= IDLE_STEPS):  # the solver comes no nearer
            # A solver that fails may give back its start: then nothing changes either.
            status = "Steady" if residual <= settings.tol or raw.solved else raw.status
            break
    return RawSolution(at.traction, at.rigid, iterations, status, status == "Steady", at.solver)
