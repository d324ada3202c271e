"""Cases of random scenes: solved by random methods, and judged."""

from __future__ import annotations

from typing import Any

import numpy as np

import varcontact as vc
from tests.conditions import Held
from tests.fuzz.judge import faults, untruths
from tests.fuzz.methods import options
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


def drawn(seed: int, number: int) -> tuple[vc.Scene, dict[str, Any]]:
    """The scene of a case and the keywords of `solve`."""
    rng = np.random.default_rng([seed, number])
    chosen = scene(rng)
    return chosen, options(rng, chosen)


def case(seed: int, number: int) -> Outcome:
    """Draw a scene, solve it, judge it."""
    with numbers_that_overflow_are_errors():
        words, chosen = "", None
        keywords: dict[str, Any] = {}
        try:
            chosen, keywords = drawn(seed, number)
            words = f"{chosen} by {keywords}"
            return solved(chosen, keywords, words)
        except vc.VarcontactError as error:
            unjust = chosen is not None and not keywords and owed(chosen)
            return Outcome(FAILED if unjust else REFUSED, str(error), words)
        except Exception as error:
            return crashed(error, words)


def solved(chosen: vc.Scene, keywords: dict[str, Any], words: str) -> Outcome:
    """Solve a scene and judge the answer, or the last iterate of a solver that did not converge."""
    tol = keywords.get("tol", 1e-8)
    try:
        answer = vc.solve(chosen, **keywords)
    except vc.NotConverged as error:
        found = _of_iterate(error)
        return Outcome(FAILED if found else UNSOLVED, "; ".join(found) or str(error), words)
    steps = [answer] if isinstance(answer, vc.Solution) else list(answer)
    for number, (before, sol) in enumerate(zip([None, *steps], steps, strict=False)):
        found = faults(sol, tol, before)
        if not sol.converged:
            found.append("not converged, and no error")
        if found:
            where = f"step {number}: " if len(steps) > 1 else ""
            return Outcome(FAILED, where + "; ".join(found), words)
    return Outcome(PASSED, "", words)


def _of_iterate(error: vc.NotConverged) -> list[str]:
    """What the certificate of a last iterate states otherwise than it is."""
    sol = error.solution
    if sol is None or sol.scene.under_law or not sol.pressure.any():
        return []
    found = ["called converged"] if sol.converged else []
    before = None if error.history is None or len(error.history) == 0 else error.history[-1]
    return found + untruths(Held(sol, before))


def owed(chosen: vc.Scene) -> bool:
    """Whether an answer is owed by default: like bodies, analytic surfaces on a grid laid around them, no forces."""
    grid, motion = chosen.grid, chosen.motion
    explicit = isinstance(grid, vc.Grid) and (grid.explicit or grid.edge == "touched")
    prescribed = isinstance(motion, vc.Transient) or any(
        getattr(motion, name, None) is not None for name in ("Fx", "Fy")
    )
    needs_depth = chosen.line and chosen.reference_depth is None and isinstance(motion, vc.Shift)
    apart = explicit or prescribed or needs_depth or isinstance(chosen.surface, vc.SampledDistance)
    return not (apart or chosen.bodies.coupled)
