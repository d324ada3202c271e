"""What defect correction is for: scenes, methods and grids that it does not hold for are refused before any work."""

from __future__ import annotations

import math
from typing import Any

from varcontact import checks
from varcontact.discrete.contact_grid import known_grid, wanted_grid
from varcontact.discrete.operators import KEPT_DISTANCES
from varcontact.elasticity.operators import table_bytes
from varcontact.errors import SceneError
from varcontact.results.plan import Plan
from varcontact.results.solution import Solution
from varcontact.scene.grid import Grid
from varcontact.scene.motion import Steady, Transient
from varcontact.scene.scene import Scene
from varcontact.solving.defect_correction.passes import PARTS
from varcontact.solving.defect_correction.pressed import FINER
from varcontact.system.memory import SMALLER, need

KINDS = ("continuum",)
"""What can be asked for."""
LEAST = 8
"""Fewest elements across the contact each way: with fewer the estimate, from half of them, says nothing."""
LEAST_OF_A_HISTORY = 16
"""The same in a history: on half of fewer, errors that steps hand on are no longer in proportion."""
FIELDS = 120
"""Numbers for each part, about, with which Hertz's contact without slip is known."""


def check_refine(scene: Scene, plan: Plan, refine: Any, chosen: bool, start: str | Solution | None) -> bool:
    """Whether defect correction is asked for; refused, before any work, where it does not hold.

    Parameters
    ----------
    scene : Scene
    plan : Plan
    refine : str or None
        As of `solve`.
    chosen : bool
        Whether the grid is to be chosen for an accuracy or a time.
    start : str, Solution or None
        As of `solve`.

    Raises
    ------
    SceneError
        For a kind that there is not, or a scene or method that cannot be corrected.
    """
    if refine is None:
        return False
    kind = checks.choice("refine", refine, KINDS)
    reason = _why_not(scene, plan)
    if isinstance(start, Solution):
        reason = 'the estimate takes half as many elements, on which no start is known; give start = "stick" or "slip"'
    if chosen:
        reason = "it corrects on the scene's own grid; leave it out, or accuracy and time_budget"
    if reason:
        raise SceneError("refine", kind, "left out", message=f'refine = "{kind}": {reason}')
    marches = isinstance(scene.motion, Transient)
    grid, hertz = wanted_grid(scene) if marches else known_grid(scene), scene.hertz
    if hertz is not None and not marches:
        dx, dy = grid.sides
        check_count(scene, (2 * hertz.a / dx, 2 * hertz.b / dy))
    elif not grid.explicit:  # otherwise the contact has to be solved for, or the largest of a history to be found
        check_count(scene, (grid.nx, grid.rows), LEAST_OF_A_HISTORY if marches else LEAST)
    parts = PARTS if plan.closed_form else PARTS * FINER
    blocks = 4 * table_bytes(parts * grid.rows, parts * grid.nx, 1)
    known = FIELDS * parts**2 * grid.size if plan.closed_form and not marches else 0
    kept = 2.0 + KEPT_DISTANCES if marches else 2.0
    need("the parts of the elements", kept * blocks + 8 * known, SMALLER)
    return True


def check_count(scene: Scene, count: tuple[float, float], least: int = LEAST) -> None:
    """There are enough elements along x and y across the contact; in line contact along x.

    Parameters
    ----------
    scene : Scene
    count : tuple of float
        Elements across the contact along x and y.
    least : int
        Fewest of them.

    Raises
    ------
    SceneError
        Naming the grid.
    """
    counted = count[:1] if scene.line else count
    if min(counted) < least * (1 - 1e-9):
        found = " by ".join(f"{each:.3g}" for each in counted)
        raise SceneError(
            "grid",
            scene.grid,
            f"at least {least} elements across the contact each way",
            message=f'refine = "{KINDS[0]}" needs a grid with at least {least} elements across the contact each way; '
            f"here it has {found}",
        )


def _why_not(scene: Scene, plan: Plan) -> str:
    """Why a scene cannot be corrected, and what to do instead; nothing where it can."""
    instead = "solve on several grids and extrapolate (converge), or leave refine out"
    motion = scene.motion
    if motion is None:
        return "it is for tractions, and without a motion there are none: leave refine out"
    if scene.frictionless:
        return "without friction there is nothing to correct: leave refine out"
    if scene.bodies.K != 0 and not plan.left_out:
        return f"it is for quasi-identical bodies, and here K = {scene.bodies.K:.3g}: it may lose then; {instead}"
    if not isinstance(motion, Steady) and any(isinstance(f, float) and math.isinf(f) for f in scene.frictions):
        return f"with infinite friction it is for steady rolling; {instead}"
    if scene.no_slip and not plan.closed_form:
        return f"with infinite friction it is for Hertz's pressure in closed form; {instead}"
    if plan.theory is not None:
        return f"it corrects exact methods, not the theory {plan.tangential!r}; leave tangential or refine out"
    if isinstance(scene.grid, Grid) and scene.grid.edge != "centres":
        return f'with grid.edge = "{scene.grid.edge}" it gains less, or loses: leave grid.edge out'
    return _why_no_history(scene, motion) if isinstance(motion, Transient) else ""


def _why_no_history(scene: Scene, motion: Transient) -> str:
    """Why a history cannot be corrected, and what to do instead; nothing where it can."""
    if scene.under_law:
        return "of histories it is for friction that is a number, not for laws of friction; leave refine out"
    if motion.start is not None:
        return (
            "motion.start has no tractions on parts of the elements to go on from; leave motion.start out, and begin "
            "with the steps that lead there"
        )
    return ""
