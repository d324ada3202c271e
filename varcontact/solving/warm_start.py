"""Scenes solved one after the other: each uses what the ones before have made."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, fields, replace

import numpy as np

from varcontact.discrete.discretisation import Discretisation
from varcontact.discrete.state import ContactState
from varcontact.interfaces.coulomb import FRICTION
from varcontact.results.plan import Plan
from varcontact.results.solution import Solution
from varcontact.scene.motion import Shift, Steady
from varcontact.scene.scene import Scene
from varcontact.solvers.interface import SolveStats
from varcontact.solving.contact_solver import ContactSolver, contact
from varcontact.solving.on_grid import finish, solve_contact
from varcontact.solving.options import check_saturation
from varcontact.solving.selection import check_fits
from varcontact.system.process import one_blas_thread


@dataclass
class Series:
    """Solves scenes one after the other, and keeps what the next may use; `tol`, `polish` and
    `certify` as of `solve`.

    Influence numbers serve all scenes on the same dimensionless lattice. Where scenes differ in
    their motion only, the pressure serves again, too (where tractions do not change it). Methods
    that can begin somewhere begin from the tractions of the scene before.
    """

    tol: float
    polish: bool
    certify: str = "auto"
    progress: Callable[[str], None] | None = None
    _last: tuple[Scene, Plan, Discretisation, ContactState] | None = None

    @one_blas_thread()
    def solve(self, scene: Scene, plan: Plan) -> Solution:
        """The solution of the next scene, which is no history; errors as of `solve`."""
        check_saturation(scene)
        stats = SolveStats(self.progress)
        last = self._last
        steps = ContactSolver(
            plan, self.tol, self.polish, stats, certify=self.certify, refined=False
        )
        if (
            last is not None
            and plan == last[1]
            and plan.coupling == "none"
            and _same_but_motion(scene, last[0])
        ):
            disc = last[2].with_loading(motion=scene.motion)
            fields = {name: field for name, field in last[3].fields.items() if name != FRICTION}
            state = replace(last[3], iterations={}, status={}, solved={}, fields=fields)
            state = contact(disc, steps, state)
        else:
            check_fits(scene, plan)
            known, before = (None, None) if last is None else (last[2].operators, last[3].traction)
            disc, state = solve_contact(scene, steps, known, before)
            if known is not None and known is not disc.operators:
                known.forget()
        self._last = scene, plan, disc, state
        return finish(scene, disc, state, steps)

    def forget(self) -> None:
        """Let go of dense matrices and factors; influence numbers stay."""
        if self._last is not None:
            self._last[2].operators.forget()


def solve_in_turn(
    scene: Scene,
    motions: Iterable[Steady | Shift | None],
    plan: Plan,
    tol: float,
    polish: bool,
    progress: Callable[[str], None] | None = None,
    certify: str = "auto",
) -> Iterator[Solution]:
    """The solutions of a scene for one motion after the other, with creepages or forces that
    differ, as a `Series`.
    """
    series = Series(tol, polish, certify, progress)
    try:
        for motion in motions:
            yield series.solve(replace(scene, motion=motion), plan)
    finally:
        series.forget()


def _same_but_motion(scene: Scene, other: Scene) -> bool:
    """Whether two scenes differ in creepages or forces only; arrays are the same if they are
    one.
    """
    one = scene.motion
    two = other.motion
    if (
        one is None
        or type(one) is not type(two)
        or getattr(one, "dq", None) != getattr(two, "dq", None)
    ):
        return False
    pairs = [
        (getattr(scene, f.name), getattr(other, f.name))
        for f in fields(Scene)
        if f.name != "motion"
    ]
    arrays = [isinstance(own, np.ndarray) or isinstance(its, np.ndarray) for own, its in pairs]
    return all(
        own is its or not (array or own != its)
        for (own, its), array in zip(pairs, arrays, strict=True)
    )
