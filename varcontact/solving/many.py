"""One scene for one motion after the other, each begun from the nearest solution before."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import replace

import numpy as np

from varcontact.machine.threads import one_blas_thread
from varcontact.planning.expectations import check_fits
from varcontact.planning.plan import Plan
from varcontact.problem.discretisation import Discretisation
from varcontact.problem.state import ContactState
from varcontact.results.solution import Solution
from varcontact.scene.motion import Shift, Steady
from varcontact.scene.scene import Scene
from varcontact.solvers.conic.setups import Setups
from varcontact.solving.certify import judged
from varcontact.solving.grid_search import on_a_grid_that_holds_it
from varcontact.solving.saturation import check_saturation
from varcontact.solving.subproblems import Steps, contact
from varcontact.solving.timing import Clock


def solve_many(
    scene: Scene,
    motions: Iterable[Steady | Shift | None],
    plan: Plan,
    tol: float,
    polish: bool,
    progress: Callable[[str], None] | None = None,
    certify: str = "auto",
) -> Iterator[Solution]:
    """Solve a scene for one motion after the other, which differ in creepages or forces only.

    Influence numbers, the pressure (where tractions do not change it) and the set-ups of solvers are made once, and
    each begins, with methods that can begin somewhere, from the solution before with the nearest creepages.

    Parameters
    ----------
    scene : Scene
    motions : iterable of Steady, Shift or None
    plan : Plan
        For all of them.
    tol : float
        Residual to be reached [-].
    polish : bool
        Whether active sets polish the answers of programs.
    progress : callable, optional
        Called with the name of each stage.
    certify : str
        As of `solve`.

    Yields
    ------
    Solution
        One a motion, in their order.

    Raises
    ------
    Saturated
        If a prescribed force cannot be carried.
    NotConverged
        If a solver misses the tolerance.
    """
    setups = Setups()
    disc: Discretisation | None = None
    state: ContactState | None = None
    solved: list[Solution] = []
    creepages = np.empty((0, 3))
    try:
        for motion in motions:
            posed = replace(scene, motion=motion)
            check_saturation(posed)
            steps = Steps(plan, tol, polish, Clock(progress), setups, certify=certify, refined=False)
            with one_blas_thread():
                if disc is not None and state is not None and motion is not None and plan.coupling == "none":
                    disc = disc.moved(motion)
                    near = solved[_nearest(_creepages(disc), creepages)].traction / disc.pressure
                    state = replace(state, traction=near, iterations={}, status={}, solved={}, friction=None)
                    state = contact(disc, steps, state)
                else:
                    check_fits(posed, plan)
                    known = None if disc is None else disc.operators
                    disc, state = on_a_grid_that_holds_it(posed, steps, known)
                solution = judged(posed, disc, state, steps)
            solved.append(solution)
            creepages = np.vstack([creepages, _creepages(disc)])
            yield solution
    finally:
        if disc is not None:
            disc.operators.forget()


def _creepages(disc: Discretisation) -> np.ndarray:
    """Creepages or shifts along x and y, and what spin or rotation is half the grid's length from the origin."""
    along_x, along_y, about_z = (0.0, 0.0, 0.0) if disc.motion is None else disc.motion.rigid
    return np.array([along_x, along_y, about_z * disc.length / 2])


def _nearest(one: np.ndarray, others: np.ndarray) -> int:
    """Which of several points is nearest to one: the last of these."""
    distances = np.linalg.norm(others - one, axis=1)
    return len(others) - 1 - int(np.argmin(distances[::-1]))
