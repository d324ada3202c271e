"""What defect correction is for: other scenes, methods and grids are refused before any work."""

from __future__ import annotations

from typing import Any

from varcontact import checks
from varcontact.discrete.contact_grid import known_grid
from varcontact.elasticity.operators import table_bytes
from varcontact.errors import SceneError
from varcontact.results.plan import Plan
from varcontact.results.solution import Solution
from varcontact.scene.grid import Grid
from varcontact.scene.motion import Steady
from varcontact.scene.scene import Scene
from varcontact.solving.defect_correction.fine_grid import PARTS
from varcontact.system.memory import SMALLER, need

CONTINUUM = "continuum"
"""What can be asked for."""
LEAST = 8
"""Fewest elements across the contact each way: with fewer the estimate, from half of them, says nothing."""
FIELDS = 120
"""Numbers for each part, about: tractions whose displacement is known, and what parts miss of it."""
INSTEAD = "give accuracy in place of refine and of a grid"


def check_refine(scene: Scene, plan: Plan, refine: Any, chosen: bool, start: str | Solution | None) -> bool:
    """Whether defect correction is asked for; `chosen`: the grid is to be chosen for an accuracy or a time."""
    if refine is None:
        return False
    kind = checks.choice("refine", refine, (CONTINUUM,))
    reason = _why_not(scene, plan)
    if isinstance(start, Solution):
        reason = 'the estimate takes half as many elements, on which no start is known; give start = "stick" or "slip"'
    if chosen:
        reason = "it corrects on the scene's own grid; leave it out, or accuracy and time_budget"
    if reason:
        raise SceneError("refine", kind, "left out", message=f'refine = "{kind}": {reason}')
    grid, hertz = known_grid(scene), scene.hertz
    assert hertz is not None
    (dx, dy), parts = grid.sides, PARTS * PARTS * grid.size
    _check_count(scene, 2 * hertz.a / dx, 2 * hertz.b / dy)
    need(
        "the parts of the elements",
        8 * table_bytes(PARTS * grid.rows, PARTS * grid.nx, 1) + 8 * FIELDS * parts,
        SMALLER,
    )
    return True


def _check_count(scene: Scene, nx: float, ny: float) -> None:
    """There are enough elements along x and y across the contact."""
    if min(nx, ny) < LEAST * (1 - 1e-9):
        raise SceneError(
            "grid",
            scene.grid,
            f"at least {LEAST} elements across the contact each way",
            message=f'refine = "{CONTINUUM}" needs a grid with at least {LEAST} elements across the contact each way; '
            f"here it has {nx:.3g} by {ny:.3g}",
        )


def _why_not(scene: Scene, plan: Plan) -> str:
    """Why a scene cannot be corrected, and what to do instead; nothing where it can."""
    if scene.motion is None:
        return "it is for tractions, and without a motion there are none: leave refine out"
    if scene.frictionless:
        return "without friction there is nothing to correct: leave refine out"
    if not isinstance(scene.motion, Steady):
        return f"it is for steady rolling; {INSTEAD}"
    if scene.line:
        return f"in line contact an accuracy takes less time: {INSTEAD}"
    if scene.no_slip:
        return (
            "with infinite friction forces under Hertz's pressure are known in closed form "
            "(varcontact.reference.no_slip_ellipse); leave refine out"
        )
    if scene.coupled and not plan.left_out:
        return f"it is for quasi-identical bodies, and here {scene.difference}; {INSTEAD}"
    if not plan.closed_form:
        return f"it is for Hertz's pressure in closed form, and here the pressure is solved for; {INSTEAD}"
    if plan.theory is not None:
        return f"it corrects exact methods, not the theory {plan.tangential!r}; leave tangential or refine out"
    if isinstance(scene.grid, Grid) and scene.grid.edge != "centres":
        return f'with grid.edge = "{scene.grid.edge}" it gains less, or loses: leave grid.edge out'
    return ""
