"""Cases of the certificate: tractions beside a known solution, whose true distance no bound may fall below.

The solution is that of active sets, exact to rounding. Distances in energy are taken with matrices made here.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

import varcontact as vc
from tests.conditions import Held
from tests.elasticity_again import influence
from tests.fuzz.judge import projected, untruths
from tests.fuzz.outcome import (
    FAILED,
    PASSED,
    REFUSED,
    UNSOLVED,
    Outcome,
    crashed,
    numbers_that_overflow_are_errors,
)
from tests.fuzz.scenes import scene
from varcontact.scene.motion import Shift, Steady

Random = np.random.Generator

EXACT = 1e-11
"""Largest residual of a solution that counts as exact."""


def case(seed: int, number: int) -> Outcome:
    """Draw a scene, solve it exactly, and judge tractions beside the solution, or those of a rough solver."""
    rng = np.random.default_rng([seed, number])
    with numbers_that_overflow_are_errors():
        words = ""
        try:
            rough = rng.random() < 0.3
            chosen = _scene(rng, forces=rough)
            words = str(chosen)
            exact = vc.solve(chosen, tangential="auto" if chosen.friction is np.inf else "tang-safeguarded")
            assert isinstance(exact, vc.Solution)
            if exact.certificate.residual > EXACT and exact.certificate.tangential_residual > EXACT:
                return Outcome(UNSOLVED, f"a residual of {exact.certificate.residual:.1e} is not exact", words)
            found, what = (_by_a_rough_solver if rough else _beside)(rng, exact)
            return Outcome(FAILED if found else PASSED, "; ".join(found), f"{words}: {what}")
        except vc.NotConverged as error:
            return Outcome(UNSOLVED, str(error), words)
        except vc.VarcontactError as error:
            return Outcome(REFUSED, str(error), words)
        except Exception as error:
            return crashed(error, words)


def _scene(rng: Random, forces: bool) -> vc.Scene:
    """A scene whose tractions can be certified; with prescribed forces only where they are wanted."""
    while True:
        try:
            chosen = scene(rng)
        except vc.SceneError:
            continue
        motion = chosen.motion
        if not isinstance(motion, Steady | Shift) or chosen.frictionless or chosen.under_law:
            continue
        hertzian = not chosen.bodies.coupled and not isinstance(chosen.surface, vc.SampledDistance)
        if forces and not hertzian:
            continue
        if isinstance(motion, Shift) and chosen.line and chosen.reference_depth is None:
            continue  # shifts by tractions are known but for a constant
        placed = hertzian or (isinstance(chosen.grid, vc.Grid) and chosen.grid.explicit)
        if placed and (forces or (motion.Fx is None and motion.Fy is None)):
            return chosen


# ----------------------------------------------------------------------------- tractions


def _beside(rng: Random, exact: vc.Solution) -> tuple[list[str], str]:
    """Tractions, and at times pressures, next to the solution or far from it, certified and compared with it."""
    traction, how = disturbed(rng, exact)
    pressure, spread = None, 0.0
    if not exact.plan.closed_form:
        pressure = exact.pressure
        if rng.random() < 0.4:
            spread = 10 ** rng.uniform(-12, 0)
            pressure = pressure * (1 + spread * rng.uniform(-1, 1, pressure.shape))
            elsewhere = rng.random(pressure.shape) < rng.choice([0.0, 0.1])
            pressure = np.where(elsewhere, spread * pressure.max() * rng.random(pressure.shape), pressure)
    grid = exact.grid
    certificate = vc.certify(replace(exact.scene, grid=grid), traction, pressure)
    found = bounded(certificate, exact, outputs(grid, traction))
    moved = replace(exact, traction=traction, certificate=certificate, converged=False)
    if pressure is not None:
        moved = replace(moved, pressure=pressure, approach=np.nan)
    if exact.scene.no_slip:
        return found, f"{how}, pressure by {spread:.0e}"
    found += untruths(Held(moved, None))
    if spread == 0:
        found += within_gap(Held(exact, None), Held(moved, None), certificate)
    return found, f"{how}, pressure by {spread:.0e}"


def disturbed(rng: Random, exact: vc.Solution) -> tuple[np.ndarray, str]:
    """Tractions beside a solution, by anything from rounding to all of them, and what was done."""
    size = float(10 ** rng.uniform(-13, 0.3))
    bound = np.where(np.isfinite(exact.traction_bound), exact.traction_bound, exact.pressure)
    shape, traction = exact.traction.shape, exact.traction
    noise = rng.normal(size=shape)
    kind = str(rng.choice(["all", "scaled", "turned", "one", "sparse", "other", "none", "outside"]))
    one = np.zeros(shape[1:])
    one.flat[rng.integers(one.size)] = 1
    turned = traction + size * np.array([-1, 1])[:, None, None] * traction[::-1]
    change = {
        "all": traction + size * bound * noise,
        "scaled": traction * (1 + size * rng.choice([-1, 1])),
        "turned": turned,
        "one": traction + size * bound * noise * one,
        "sparse": traction + size * bound * noise * (rng.random(shape[1:]) < 0.2),
        "other": bound * noise * rng.uniform(0, 1, shape[1:]),
        "none": np.zeros(shape),
        "outside": traction + size * bound.max() * noise,
    }[kind]
    if kind != "outside" and rng.random() < 0.6:  # tractions that friction can carry
        change = projected(change.reshape(2, -1), bound.ravel()).reshape(shape)
    return change, f"{kind}, by {size:.0e}"


def outputs(grid: vc.Grid, traction: np.ndarray) -> np.ndarray:
    """Fx, Fy, Mz."""
    x, y = grid.x[None, :], grid.y[:, None]
    return np.array([*traction.sum(axis=(1, 2)), np.sum(x * traction[1] - y * traction[0])]) * grid.area


def bounded(certificate: vc.Certificate, exact: vc.Solution, found: np.ndarray) -> list[str]:
    """The certified bounds hold, to what is known of the solution."""
    known = exact.certificate.force_bound
    if exact.scene.bodies.coupled and not exact.plan.left_out:
        return [] if np.isinf(certificate.force_bound).any() else ["a bound where none is known: unlike bodies"]
    away = np.abs(found - outputs(exact.grid, exact.traction))
    beyond = away > certificate.force_bound * (1 + 1e-9) + np.where(np.isfinite(known), known, 0.0)
    return [
        f"{name} is {error:.3e} away, certified {bound:.3e}"
        for name, error, bound, bad in zip(("Fx", "Fy", "Mz"), away, certificate.force_bound, beyond, strict=True)
        if bad
    ]


def within_gap(exact: Held, moved: Held, certificate: vc.Certificate) -> list[str]:
    """The squared distance ``(p - p*)'S(p - p*)`` of admissible tractions is not above the gap."""
    away = projected(moved.traction, exact.bound) - exact.traction
    sol = exact.sol
    less = exact.step if isinstance(sol.motion, Steady) else None
    matrix = influence(sol.grid, exact.constants, less=less, depth=sol.scene.reference_depth)
    n = exact.pressure.size
    squared = float(away.ravel() @ matrix[: 2 * n, : 2 * n] @ away.ravel()) * sol.grid.area
    noise = sol.grid.area * float(exact.bound @ np.full(n, 4 * exact.shift_noise)) + 1e-12 * certificate.gap
    if squared <= certificate.gap + noise:
        return []
    return [f"the squared distance is {squared:.3e}, above the gap of {certificate.gap:.3e} (rounding {noise:.0e})"]


# ----------------------------------------------------------------------------- answers of solvers


def _by_a_rough_solver(rng: Random, exact: vc.Solution) -> tuple[list[str], str]:
    """A solver's own answer to a loose tolerance, also under prescribed forces: its certificate bounds its errors."""
    keywords: dict[str, Any] = {
        "tangential": str(rng.choice(["scs", "clarabel", "newton"])),
        "polish": False,
        "tol": float(10 ** rng.uniform(-6, -0.5)),
    }
    sol = vc.solve(replace(exact.scene, grid=exact.grid), **keywords)
    assert isinstance(sol, vc.Solution)
    found = bounded(sol.certificate, exact, outputs(sol.grid, sol.traction))
    return found + untruths(Held(sol, None)), str(keywords)
