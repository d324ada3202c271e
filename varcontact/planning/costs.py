"""What each road to a solution costs, before one is taken: seconds by measured laws, bytes at the peak."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from varcontact.errors import SceneError
from varcontact.planning import memory
from varcontact.planning.roads import ROADS
from varcontact.scene.motion import Transient
from varcontact.scene.scene import Scene
from varcontact.solvers.registry import MATRIX_FREE
from varcontact.system.memory import SMALLER

if TYPE_CHECKING:
    from varcontact.planning.plan import Plan

LAWS: dict[tuple[str, str], tuple[float, float, float]] = {
    ("newton", ""): (0.012, 6e-6, 1.1),
    ("norm", ""): (0.004, 3.5e-10, 3.0),
    ("norm-single", ""): (0.004, 7e-10, 3.0),
    ("tang", ""): (0.006, 1.2e-9, 3.0),
    ("tang-exact", ""): (0.006, 1.2e-9, 3.0),
    ("tang-safeguarded", ""): (0.006, 1.2e-9, 3.0),
    ("no-slip", ""): (0.006, 1e-9, 3.0),
    ("clarabel", memory.ONE_BLOCK): (0.01, 3.5e-9, 3.0),
    ("clarabel", memory.TWO_BLOCKS): (0.02, 2e-8, 3.0),
}
"""Seconds of a method on one core, ``c + factor n^exponent`` with n elements: docs/measurements.md has them."""

CLOSED_FORM = 0.004
"""Seconds of Hertz's pressure, and of an approximate theory."""
PASSES_OF_A_LOOP, AT_ONCE, PASSES_OF_A_LAW = 8, 2, 12
"""Solves that coupling loops, one Newton's method for both problems, and laws of friction usually take."""
WARM = 0.5
"""Part of its seconds that a solve takes from a start near its solution."""


@dataclass(frozen=True)
class Cost:
    """What a road costs, about.

    Attributes
    ----------
    method : str
        "auto", "convex", "active-set" or "kalker".
    normal, tangential : str
        Its solvers.
    seconds : float or None
        On one core; None where no law is known for one of them.
    bytes : float
        At the peak.
    """

    method: str
    normal: str
    tangential: str
    seconds: float | None
    bytes: float


def costs(scene: Scene, plan: Plan) -> tuple[Cost, ...]:
    """What a plan costs, and what other methods would.

    Parameters
    ----------
    scene : Scene
    plan : Plan
        With its sizes.

    Examples
    --------
    >>> import varcontact as vc
    >>> scene = vc.Scene(bodies=vc.Bodies(G=1.0, nu=0.3), surface=vc.Ellipse(a=1.0, b=1.0), normal_force=1.0,
    ...                  friction=0.3, motion=vc.Steady(vx=1e-3), grid=vc.Grid(nx=40, ny=40))
    >>> for cost in costs(scene, vc.plan(scene)):
    ...     print(cost.method, cost.tangential, f"{cost.seconds:.2g} s")
    auto newton 0.031 s
    convex clarabel 5.1 s
    active-set tang-safeguarded 0.31 s
    """
    from varcontact.planning.choice import make_plan
    from varcontact.planning.expectations import expected_sizes

    found = [_cost(scene, plan)]
    for method in ROADS:
        if method in (plan.method, "kalker"):
            continue
        try:
            other = make_plan(scene, method=method)
        except SceneError:  # that road does not lead there
            continue
        found.append(_cost(scene, replace(other, sizes=expected_sizes(scene, other))))
    return tuple(found)


def seconds_of(method: str, formulation: str, elements: int) -> float | None:
    """Seconds of one solve, about.

    Parameters
    ----------
    method : str
        Of the normal or of the tangential problem.
    formulation : str
        Of the program, where it states one.
    elements : int
    """
    blocks = memory.TWO_BLOCKS if formulation in ("gap", "potential") else memory.ONE_BLOCK
    law = LAWS.get((method, ""), LAWS.get((method, blocks)))
    if law is None:
        return None
    base, factor, exponent = law
    return base + factor * float(elements) ** exponent


def instead(method: str, elements: int, components: int = 1) -> str:
    """What fits where a method does not: for the end of a message.

    Parameters
    ----------
    method : str
        Of the normal or of the tangential problem.
    elements : int
    components : int
        Of a traction.
    """
    if method in MATRIX_FREE or elements == 0:
        return SMALLER
    taken = memory.peak("newton", "", components * elements)
    return f'"newton" needs about {taken / 2**30:.2g} GiB and {seconds_of("newton", "", elements):.2g} s; or {SMALLER}'


def _cost(scene: Scene, plan: Plan) -> Cost:
    """Of a plan with its sizes."""
    assert plan.sizes is not None
    elements = plan.sizes.elements
    parts = [CLOSED_FORM if plan.closed_form else seconds_of(plan.normal, plan.formulation, elements["normal"])]
    if plan.theory is not None:
        parts.append(CLOSED_FORM)
    elif plan.rubs:
        half = 2 if plan.sizes.mirrored else 1
        parts.append(seconds_of(plan.tangential, plan.formulation, elements["tangential"] // half))
    known = [part for part in parts if part is not None]
    if len(known) < len(parts) or plan.marches:
        return Cost(plan.method, plan.normal, plan.tangential, None, plan.sizes.peak)
    solves = 1.0
    if scene.under_law:
        solves += WARM * (PASSES_OF_A_LAW - 1)
    elif plan.loops:
        solves += WARM * ((AT_ONCE if plan.at_once else PASSES_OF_A_LOOP) - 1)
    if isinstance(scene.motion, Transient):
        solves += WARM * (scene.motion.steps - 1)
    return Cost(plan.method, plan.normal, plan.tangential, solves * sum(known), plan.sizes.peak)
