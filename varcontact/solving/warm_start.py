"""Scenes solved one after the other: each uses what the ones before have made."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field, fields, replace
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

KEPT = 32
"""Solved scenes whose tractions are kept, to begin from."""


@dataclass
class Series:
    """Solves scenes one after the other, and keeps what the next may use; `tol`, `polish` and `certify` as of `solve`.

    Influence numbers serve all scenes on the same dimensionless lattice. Where scenes differ in their motion only, the
    pressure serves again, too (where tractions do not change it). Each tangential problem begins, with methods that can
    begin somewhere, from the tractions of that one of the last `KEPT` whose creepages are nearest. `operators` are
    influence numbers from elsewhere, then those of the last scene.
    """

    tol: float
    polish: bool
    certify: str = "auto"
    progress: Callable[[str], None] | None = None
    operators: Operators | None = None
    _last: tuple[Scene, Plan, Discretisation, ContactState] | None = None
    _found: deque[tuple[np.ndarray, np.ndarray]] = field(default_factory=lambda: deque(maxlen=KEPT))

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
            disc, state = solve_contact(scene, steps, self.operators, self._warm)
        else:
            disc, state = moved
            state = contact(disc, steps, self._warm(disc, state))
        if self.operators is not disc.operators:
            self.forget()
        self.operators, self._last = disc.operators, (scene, plan, disc, state)
        solution = finish(scene, disc, state, steps)
        self._found.append((_creepages(disc), state.traction))
        return solution

    def forget(self) -> None:
        """Let go of dense matrices and factors; influence numbers stay."""
        if self.operators is not None:
            self.operators.forget()

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

    def _warm(self, disc: Discretisation, state: ContactState) -> ContactState:
        """The state with the tractions of the solved scene with the nearest creepages, if it has as many elements.

        Not for unlike bodies: their pressure without tractions comes first.
        """
        found = [(at, traction) for at, traction in self._found if traction.shape == state.traction.shape]
        if not found or disc.loading.motion is None or disc.K != 0:
            return state
        distances = [float(np.linalg.norm(at - _creepages(disc))) for at, _ in found]
        nearest = len(found) - 1 - int(np.argmin(distances[::-1]))  # the last of these
        return replace(state, traction=found[nearest][1])


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


def _creepages(disc: Discretisation) -> np.ndarray:
    """Creepages or shifts along x and y, and what spin or rotation is half the grid's length from the origin."""
    motion = disc.loading.motion
    along_x, along_y, about_z = (0.0, 0.0, 0.0) if motion is None else motion.rigid
    return np.array([along_x, along_y, about_z * disc.scales.length / 2])
