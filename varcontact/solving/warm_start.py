"""Scenes solved one after the other, each reusing the operators and the solution of earlier
ones.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np

from varcontact.discrete.discretisation import Discretisation
from varcontact.discrete.state import ContactState
from varcontact.results.plan import Plan
from varcontact.results.solution import Solution
from varcontact.scene.motion import Shift, Steady
from varcontact.scene.scene import Scene
from varcontact.solvers.interface import SolveStats
from varcontact.solvers.trace import Trace
from varcontact.solving.contact_solver import ContactSolver, solve_pressure_and_tractions
from varcontact.solving.on_grid import finish, solve_contact
from varcontact.solving.options import check_saturation
from varcontact.solving.pipeline import check_fits
from varcontact.system.process import one_blas_thread


@dataclass(frozen=True, eq=False)
class _Last:
    """The contact of the scene before."""

    scene: Scene
    plan: Plan
    disc: Discretisation
    state: ContactState


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
    trace: bool = False
    _last: _Last | None = None

    @one_blas_thread()
    def solve(self, scene: Scene, plan: Plan) -> Solution:
        """The solution of the next scene, which is no history; errors as of `solve`."""
        check_saturation(scene)
        solver = ContactSolver(
            plan,
            self.tol,
            self.polish,
            SolveStats(self.progress, Trace() if self.trace else None),
            certify=self.certify,
            loose_tolerance=True,
        )
        last = self._last
        if last is None:
            check_fits(scene, plan)
            disc, state = solve_contact(scene, solver)
        elif _same_pressure(scene, plan, last):
            disc = last.disc.with_motion(scene.motion)
            anew = {each.name for each in disc.sought(by_slip=True)}
            fields = {name: each for name, each in last.state.fields.items() if name not in anew}
            state = replace(last.state, iterations={}, status={}, solved={}, fields=fields)
            state = solve_pressure_and_tractions(disc, solver, state)
        else:
            check_fits(scene, plan)
            disc, state = solve_contact(scene, solver, last.disc.operators, last.state.traction)
        self._last = _Last(scene, plan, disc, state)
        return finish(scene, disc, state, solver)


def solve_in_turn(
    scene: Scene, motions: Iterable[Steady | Shift | None], plan: Plan, series: Series
) -> Iterator[Solution]:
    """The solutions of a scene for one motion after the other, with creepages or forces that
    differ, as a `Series`.
    """
    for motion in motions:
        yield series.solve(replace(scene, motion=motion), plan)


def _same_pressure(scene: Scene, plan: Plan, last: _Last) -> bool:
    """True if scenes differ in creepages or forces only, and tractions do not change the pressure;
    arrays are compared by identity.
    """
    if plan != last.plan or plan.coupling != "none":
        return False
    motion = scene.motion
    before = last.scene.motion
    if isinstance(motion, Steady):
        if not isinstance(before, Steady) or motion.dq != before.dq:
            return False
    elif not (isinstance(motion, Shift) and isinstance(before, Shift)):
        return False
    return all(
        _same(getattr(scene, field.name), getattr(last.scene, field.name))
        for field in fields(Scene)
        if field.name != "motion"
    )


def _same(entry: Any, other: Any) -> bool:
    if entry is other:
        return True
    if isinstance(entry, np.ndarray) or isinstance(other, np.ndarray):
        return False
    return bool(entry == other)
