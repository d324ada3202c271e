"""Scenes solved one after the other: each uses what the ones before have made."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np

from varcontact.discrete.discretisation import Discretisation
from varcontact.discrete.operators import Operators
from varcontact.discrete.state import ContactState
from varcontact.results.plan import Plan
from varcontact.results.solution import Solution
from varcontact.scene.motion import Shift, Steady
from varcontact.scene.scene import Scene
from varcontact.scene.transient import Transient
from varcontact.solvers.interface import SolveStats
from varcontact.solving.contact_solver import ContactSolver, contact
from varcontact.solving.on_grid import finish, solve_contact
from varcontact.solving.options import check_saturation
from varcontact.solving.selection import check_fits
from varcontact.system.process import one_blas_thread


@dataclass
class Series:
    """Solves scenes one after the other, and keeps what the next may use; `tol`, `polish` and `certify` as of `solve`.

    Influence numbers serve all scenes on the same dimensionless lattice. Where scenes differ in their motion only, the
    pressure serves again, too (where tractions do not change it). Methods that can begin somewhere begin from the
    tractions of the scene before.
    """

    tol: float
    polish: bool
    certify: str = "auto"
    progress: Callable[[str], None] | None = None
    _operators: Operators | None = None
    _last: tuple[Scene, Plan, Discretisation, ContactState] | None = None

    @one_blas_thread()
    def solve(self, scene: Scene, plan: Plan) -> Solution:
        """The solution of the next scene, which is no history; errors as of `solve`."""
        check_saturation(scene)
        moved = self._moved(scene, plan)
        if moved is None:
            check_fits(scene, plan)
        stats = SolveStats(self.progress)
        steps = ContactSolver(plan, self.tol, self.polish, stats, certify=self.certify, refined=False)
        if moved is None:
            before = None if self._last is None else self._last[-1].traction
            disc, state = solve_contact(scene, steps, self._operators, before)
        else:
            disc, state = moved
            state = contact(disc, steps, state)
        if self._operators is not disc.operators:
            self.forget()
        self._operators, self._last = disc.operators, (scene, plan, disc, state)
        return finish(scene, disc, state, steps)

    def forget(self) -> None:
        """Let go of dense matrices and factors; influence numbers stay."""
        if self._operators is not None:
            self._operators.forget()

    def _moved(self, scene: Scene, plan: Plan) -> tuple[Discretisation, ContactState] | None:
        """The contact of the scene before with another motion, where nothing else is different."""
        if self._last is None or scene.motion is None or plan.coupling != "none":
            return None
        before, planned, disc, state = self._last
        methods = ("normal", "tangential", "coupling", "formulation", "method")
        if any(getattr(plan, name) != getattr(planned, name) for name in methods):
            return None
        if not _same_but_motion(scene, before):
            return None
        assert not isinstance(scene.motion, Transient)
        state = replace(state, iterations={}, status={}, solved={}, friction=None)
        return disc.with_loading(motion=scene.motion), state


def solve_in_turn(
    scene: Scene,
    motions: Iterable[Steady | Shift | None],
    plan: Plan,
    tol: float,
    polish: bool,
    progress: Callable[[str], None] | None = None,
    certify: str = "auto",
) -> Iterator[Solution]:
    """The solutions of a scene for one motion after the other, with creepages or forces that differ, as a `Series`."""
    series = Series(tol, polish, certify, progress)
    try:
        for motion in motions:
            yield series.solve(replace(scene, motion=motion), plan)
    finally:
        series.forget()


def _same_but_motion(scene: Scene, other: Scene) -> bool:
    """Whether two scenes differ in creepages or forces only; arrays are the same if they are one."""
    one, two = scene.motion, other.motion
    if type(one) is not type(two) or getattr(one, "dq", None) != getattr(two, "dq", None):
        return False

    def same(one: Any, other: Any) -> bool:
        return one is other or (not isinstance(one, np.ndarray) and not isinstance(other, np.ndarray) and one == other)

    return all(same(getattr(scene, f.name), getattr(other, f.name)) for f in fields(Scene) if f.name != "motion")
