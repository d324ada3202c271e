"""Checks that the contents of a file can be a solution, before anything is made of them."""

from __future__ import annotations

import math

import numpy as np

from varcontact.checks import LARGE
from varcontact.discrete.certificate import LEVELS
from varcontact.discrete.stick_slip import EXTERIOR, SLIP, STICK
from varcontact.results.solution import Solution
from varcontact.scene.friction import BRANCHES, Law
from varcontact.scene.motion import Steady

ROUNDED = 1e-9
"""Relative difference that rounding in unit conversions may cause."""


def check_plausible(sol: Solution, share: np.ndarray | float = 1.0) -> None:
    """Refuse fields that no solution can have, whatever its scene.

    Solvers may miss a bound by what their residual says, and by no more.
    """
    _check_account(sol)
    _check_sizes(sol)
    _check_certificate(sol)
    _check_bounds(sol, share)
    _check_areas(sol)
    _check_approach(sol)
    _check_creepage(sol)


def _check_account(sol: Solution) -> None:
    """How a solution was found: words and numbers where the report has them."""
    plan, calls = sol.plan, [each for solvers in sol.calls.values() for each in solvers.values()]
    words = [plan.normal, plan.tangential, plan.coupling, plan.formulation, plan.method, *plan.special]
    words += [*plan.reasons.values(), *sol.status.values(), *sol.solved_by.values()]
    if not all(isinstance(word, str) for word in words):
        raise ValueError("methods or solvers' words that are no words")
    numbers = [plan.left_out, *sol.iterations.values(), *sol.timing.values()]
    numbers += [number for each in calls for number in (each.count, each.iterations, each.seconds)]
    if not all(type(number) in (int, float) and 0 <= number < math.inf for number in numbers):
        raise ValueError("iterations or times that are not numbers, zero or positive")
    if "total" not in sol.timing:
        raise ValueError("no time in total")
    if sol.branch and not (sol.branch in BRANCHES and isinstance(sol.scene.friction, Law)):
        raise ValueError(f"a branch {sol.branch[:20]!r} under no law of friction that has one")


def _check_sizes(sol: Solution) -> None:
    """Numbers whose products with others stay within floating point."""
    largest = max(float(np.abs(field).max()) for field in (sol.pressure, sol.traction, sol.slip, sol.distance))
    numbers = np.abs([largest, sol.approach, *sol.creepage])
    if np.any(numbers[np.isfinite(numbers)] > LARGE**2):
        raise ValueError("numbers beyond those that can be computed with")


def _check_certificate(sol: Solution) -> None:
    if sol.certificate.level not in LEVELS:
        raise ValueError(f"a certificate of the level {sol.certificate.level!r}")
    values = [value for name, value in sol.certificate.plain().items() if name != "level"]
    numbers = np.concatenate([np.ravel(value) for value in values])
    if numbers.dtype.kind not in "iuf" or np.any(numbers < 0):
        raise ValueError("a certificate that is not of numbers, zero or positive")


def _check_areas(sol: Solution) -> None:
    if not np.isin(sol.state, (EXTERIOR, STICK, SLIP)).all():
        raise ValueError("a state that is not 0 (exterior), 1 (stick) or 2 (slip)")
    if np.any((sol.state != EXTERIOR) != (sol.pressure > 0)):
        raise ValueError("a state that is exterior where there is pressure, or contact where there is none")
    if sol.weakening is not None and not np.all((sol.weakening >= 0) & (sol.weakening <= 1)):
        raise ValueError("a weakening of friction that is not between 0 and 1")


def _check_bounds(sol: Solution, share: np.ndarray | float) -> None:
    certificate, largest = sol.certificate, np.abs(sol.pressure).max()
    if np.any(sol.pressure < -(2 * certificate.normal_residual + ROUNDED) * largest):
        raise ValueError("negative pressures")
    size = np.hypot(*sol.traction)
    friction = sol.scene.friction.static if isinstance(sol.scene.friction, Law) else sol.scene.friction
    bound = np.zeros(size.shape)
    if friction is not None:
        contact = sol.pressure > 0
        bound[contact] = np.broadcast_to(np.asarray(friction), bound.shape)[contact] * sol.pressure[contact]
    bound *= share
    if np.any(size > bound * (1 + ROUNDED) + (2 * certificate.tangential_residual + ROUNDED) * size.max()):
        raise ValueError("tractions beyond what friction can bear")


def _check_approach(sol: Solution) -> None:
    open_ended = sol.scene.line and sol.scene.reference_depth is None
    given = sol.scene.approach
    if np.isinf(sol.approach) or (np.isnan(sol.approach) and not (open_ended and given is None)):
        raise ValueError(f"an approach of {sol.approach}")
    if given is not None and abs(sol.approach - given) > ROUNDED * abs(given):
        raise ValueError(f"an approach of {sol.approach:.6g} where {given:.6g} is prescribed")


def _check_creepage(sol: Solution) -> None:
    motion, creepage = sol.motion, np.array(sol.creepage)
    if motion is None:
        return
    free = np.array([motion.Fx is not None, motion.Fy is not None, False])
    if np.any(creepage[~free] != np.array(motion.rigid)[~free]):
        raise ValueError("creepages that are not those prescribed")
    open_ended = sol.scene.line and sol.scene.reference_depth is None and not isinstance(motion, Steady)
    unknown = open_ended or sol.scene.frictionless or not sol.pressure.any()
    if np.isinf(creepage).any() or (np.isnan(creepage).any() and not unknown):
        raise ValueError("creepages that are not finite numbers")
