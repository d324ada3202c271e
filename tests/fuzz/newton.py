"""Cases of random scenes: Newton's method without a matrix beside active sets, with the solvers that were called."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator

import numpy as np

import varcontact as vc
from tests.fuzz import scenes
from tests.fuzz.outcome import FAILED, PASSED, REFUSED, UNSOLVED, Outcome, crashed, numbers_that_overflow_are_errors

APART = 1e-7
"""How far tractions may be apart, in parts of the largest traction bound; pressures, in parts of the largest."""
LARGEST = 30
"""Cells across, at most."""


def case(seed: int, number: int) -> Outcome:
    """Draw a scene, solve it by both, compare."""
    with numbers_that_overflow_are_errors():
        words = ""
        try:
            chosen = drawn(seed, number)
            words = f"{chosen}"
            return _compared(chosen, words)
        except vc.VarcontactError as error:
            return Outcome(REFUSED, str(error), words)
        except Exception as error:
            return crashed(error, words)


def drawn(seed: int, number: int) -> vc.Scene:
    """A random scene; on a larger grid where elements are counted across the contact."""
    rng = np.random.default_rng([seed, number])
    chosen = scenes.scene(rng)
    grid = chosen.grid
    if not isinstance(grid, vc.Grid) or grid.explicit or isinstance(chosen.friction, np.ndarray):
        return chosen
    rows = None if grid.ny is None else int(rng.integers(1, LARGEST))
    return dataclasses.replace(chosen, grid=dataclasses.replace(grid, nx=int(rng.integers(2, LARGEST)), ny=rows))


def _compared(chosen: vc.Scene, words: str) -> Outcome:
    plan = vc.plan(chosen)
    normal = "hertz" if plan.normal == "hertz" else "newton"
    tangential = plan.tangential if plan.tangential == "none" else "newton"
    try:
        free = vc.solve(chosen, normal=normal, tangential=tangential)
    except vc.NotConverged as error:
        return Outcome(UNSOLVED, str(error), words)
    try:
        dense = vc.solve(chosen, method="active-set")
    except vc.NotConverged:
        return Outcome(PASSED, f"{_called(free)}; active sets did not converge", words)
    found = [wrong for pair in zip(_steps(free), _steps(dense), strict=True) for wrong in _differences(*pair)]
    unique = _steps(dense)[-1].plan.friction in ("given", "none") and np.isfinite(_worst_bound(dense))
    if found and unique:
        return Outcome(FAILED, "; ".join(found), words)
    return Outcome(
        PASSED, f"{_called(free)}; another solution, with no proof that there is one" if found else _called(free)
    )


def _steps(solved: vc.Solution | vc.History) -> list[vc.Solution]:
    return [solved] if isinstance(solved, vc.Solution) else list(solved)


def _worst_bound(solved: vc.Solution | vc.History) -> float:
    """The largest bound on a force: infinite where there may be several solutions."""
    return float(max(step.certificate.force_bound.max() for step in _steps(solved)))


def _differences(one: vc.Solution, other: vc.Solution) -> Iterator[str]:
    if not other.pressure.any():
        return
    bound = np.where(np.isfinite(other.traction_bound), other.traction_bound, np.hypot(*other.traction))
    for name, scale in (("pressure", other.pressure.max()), ("traction", bound.max())):
        apart = float(np.abs(getattr(one, name) - getattr(other, name)).max())
        if apart > APART * scale:
            yield f"{name} {apart / scale:.1e} apart"


def _called(solved: vc.Solution | vc.History) -> str:
    """The solvers that were called, Newton's own safeguard and fallback included."""
    names = {name for step in _steps(solved) for each in step.calls.values() for name in each}
    return ", ".join(sorted(names - {"hertz"})) or "none"
