"""The judge of random scenes: Kalker's conditions, and whether the certificate says what they
are.
"""

from dataclasses import replace

import numpy as np

import varcontact as vc
from tests.conditions import Held, on_parts, undeformed, violations

DIFFER = 1e-3
"""Relative difference of the certificate's numbers from those found here that is none."""
ROUNDING = 1e-10
"""Residuals that are rounding."""


def faults(sol: vc.Solution, tol: float, previous: vc.Solution | None = None) -> list[str]:
    """What is wrong with a solution that is called converged; empty where nothing is."""
    found = violations(sol, 1.01 * tol, previous)
    return found + untruths(Held(sol, previous)) if sol.pressure.any() else found


def untruths(held: Held) -> list[str]:
    """What the certificate states otherwise than it is found here: residuals and gap."""
    sol = held.sol
    stated = sol.certificate
    found = (
        [] if np.all(stated.force_bound >= 0) else [f"bounds on the forces of {stated.force_bound}"]
    )
    if np.isfinite(sol.approach):
        residual, noise = normal_residual(on_parts(held))
        found += _differs("normal residual", stated.normal_residual, residual, noise)
    if sol.motion is None or not held.bound.any() or not np.isfinite(held.bound).all():
        return found
    if sol.scene.under_law and sol.plan.theory is not None:
        return found  # its slip is none that the law could be held against
    residual, noise = tangential_residual(held)
    found += _differs("tangential residual", stated.tangential_residual, residual, noise)
    # the bound of iterates under a law is another
    if stated.level != "none" and not sol.scene.under_law:
        value, noise = gap(held)
        found += _differs("gap", stated.gap, value, noise)
        found += ["a negative gap"] if stated.gap < 0 else []
    return found


def normal_residual(held: Held) -> tuple[float, float]:
    """Largest ``|p - max(p - e/rho, 0)|`` by the largest pressure, with what the force lacks; and
    its rounding.
    """
    values, sizes = held.displacement
    rho, flat = held.own[2], undeformed(held.sol, held.points)
    image = np.maximum(held.pressure - (flat + values[2] - held.sol.approach) / rho, 0.0)
    largest = max(held.pressure.max(), image.max())
    lacking = (
        0.0
        if (load := held.sol.scene.normal_force) is None
        else abs(held.sol.normal_force / load - 1)
    )
    noise = ROUNDING * (sizes[2].max() + np.abs(flat).max()) / rho / largest
    return max(float(np.abs(held.pressure - image).max() / largest), lacking), noise


def tangential_residual(held: Held) -> tuple[float, float]:
    """Largest ``|p - Proj(p - E/rho)|`` by the largest traction, with what forces lack; and its
    rounding.
    """
    bears = held.bound > 0
    stray = float(np.hypot(*held.traction[:, ~bears]).max(initial=0.0))
    if stray > 0:  # tractions that nothing can carry are error as a whole
        carried = replace(
            held.sol, traction=held.sol.traction * bears.reshape(held.sol.pressure.shape)
        )
        residual, noise = tangential_residual(Held(carried, held.previous))
        return max(residual, stray / float(np.hypot(*held.traction).max())), noise
    sol, traction, motion = held.sol, held.traction, held.sol.motion
    assert motion is not None
    asked = np.array([motion.Fx is not None, motion.Fy is not None])
    moves = (
        traction.any(axis=1) | asked | (np.abs(held.shift[:, bears]).max(axis=1) > held.shift_noise)
    )
    coupled = not held.sol.grid.line and held.sol.grid.rows > 1
    acts = np.ones(2, bool) if coupled or not moves.any() else moves
    rho = held.own[:2][acts].mean()
    image = projected(traction - held.shift / rho, held.bound)
    largest = max(np.hypot(*traction).max(), np.hypot(*image[:, bears]).max())
    if largest == 0:  # without tractions all of a prescribed force is lacking
        return float(bool(motion.Fx or motion.Fy)), 0.0
    residual = float(np.hypot(*(traction - image)).max() / largest)
    for force, wanted in zip(sol.force, (motion.Fx, motion.Fy), strict=True):
        if wanted is not None:
            residual = max(
                residual, abs(force - wanted) / (largest * sol.grid.area * np.sqrt(bears.sum()))
            )
    return residual, ROUNDING + held.shift_noise / rho / largest


def gap(held: Held) -> tuple[float, float]:
    """Duality gap of tractions within their bound, and its rounding."""
    traction = projected(held.traction, held.bound)
    admissible = replace(held.sol, traction=traction.reshape(held.sol.traction.shape))
    shift = held.shift + (Held(admissible, held.previous).elastic[0] - held.elastic[0])
    parts = held.bound * np.hypot(*shift) + np.sum(traction * shift, axis=0)
    work = float(np.sum(held.bound * (np.hypot(*shift) + held.shift_noise)))
    area = held.sol.grid.area
    return float(parts.sum()) * area, area * (
        1e-13 * work + float(held.bound.sum()) * 2 * held.shift_noise
    )


def projected(traction: np.ndarray, bound: np.ndarray) -> np.ndarray:
    """On the disks of radius `bound`."""
    size = np.hypot(*traction)
    return traction * np.where(size > bound, bound / np.where(size > 0, size, 1.0), 1.0)


def _differs(what: str, stated: float, found: float, noise: float) -> list[str]:
    """In words, where two numbers differ by more than rounding."""
    if abs(stated - found) <= DIFFER * max(abs(stated), abs(found)) + noise:
        return []
    return [f"the certificate's {what} is {stated:.3e}, found {found:.3e} (rounding {noise:.0e})"]
