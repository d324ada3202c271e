"""Creep-force curves: one scene for many creepages."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from concurrent.futures import Executor
from dataclasses import dataclass, replace
from typing import Any, cast

import numpy as np

from varcontact import checks
from varcontact.errors import SceneError
from varcontact.planning.choice import make_plan
from varcontact.planning.plan import Plan
from varcontact.planning.roads import TOLERANCE
from varcontact.results.solution import Solution
from varcontact.scene.motion import Shift, Steady
from varcontact.scene.scene import Scene
from varcontact.solving.options import level, polished_by
from varcontact.solving.series import solve_many
from varcontact.solving.solve import solve
from varcontact.study.engine import CHUNK, opened, results


def scan(
    scene: Scene,
    creepages: np.ndarray,
    normal: str = "auto",
    tangential: str = "auto",
    coupling: str = "auto",
    *,
    formulation: str = "auto",
    method: str = "auto",
    tol: float = TOLERANCE,
    polish: bool | None = None,
    certify: str | None = "gap",
    executor: Executor | None = None,
    workers: int = 1,
    progress: Callable[[str], None] | None = None,
    accuracy: float | None = None,
    time_budget: float | None = None,
) -> list[Solution]:
    """Solve a scene for many creepages, with influence numbers, pressure and set-ups of solvers made once.

    Each solution is where the next begins, with methods that can begin somewhere.

    Parameters
    ----------
    scene : Scene
        With a motion, whose creepages are replaced; no prescribed tangential force.
    creepages : array_like, shape (k, 3)
        vx, vy, spin; of a shift ux, uy, rotation.
    normal, tangential, coupling, formulation, method, tol, polish, certify
        As for `solve`; bounds on the forces only with `certify` = "full".
    executor, workers
        Where they are solved, as for `sweep`; there they are cut into chunks of eight, and only within a chunk does one
        begin from another.
    progress : callable, optional
        Told the name of each stage, or, of other processes, how many creepages are done.
    accuracy, time_budget : float, optional
        As for `solve`, of each solution. Each then has a grid of its own, and nothing is shared between them.

    Returns
    -------
    list of Solution

    Raises
    ------
    SceneError, SolverUnavailable, Saturated, NotConverged, TooLarge
        As `solve`; the first failure ends the scan.
    WorkersLost
        If the executor ends early.

    Examples
    --------
    >>> import varcontact as vc
    >>> scene = vc.Scene(
    ...     bodies=vc.Bodies(G=82e9, nu=0.28), surface=vc.Paraboloids(Rx=0.46, Ry=0.30), normal_force=106.7e3,
    ...     friction=0.33, motion=vc.Steady(), grid=vc.Grid(nx=12, ny=12))
    >>> curve = vc.scan(scene, [(vx, 0.0, 0.0) for vx in (0.5e-3, 1e-3, 4e-3)])
    >>> print([f"{sol.force[0] / (0.33 * sol.normal_force):.3f}" for sol in curve])
    ['-0.210', '-0.392', '-0.967']
    """
    motions = _motions(scene, creepages)
    if (accuracy is not None or time_budget is not None) and (executor is not None or workers != 1):
        name, value = ("workers", workers) if executor is None else ("executor", executor)
        raise SceneError(name, value, "left out: a scan to an accuracy, or within a time, is solved here")
    with opened(executor, workers) as pool:
        if pool is None:
            options: dict[str, Any] = {"formulation": formulation, "method": method, "tol": tol, "polish": polish}
            options |= {"certify": certify, "accuracy": accuracy, "time_budget": time_budget, "progress": progress}
            return list(scanned(scene, creepages, normal, tangential, coupling, **options))
        plan = _plan(scene, motions, normal, tangential, coupling, formulation, method)
        tol, polish, progress = checks.positive("tol", tol), polished_by(plan, polish), checks.progress(progress)
        parts = [motions[k : k + CHUNK] for k in range(0, len(motions), CHUNK)]
        solved: list[list[Solution]] = [[] for _ in parts]
        tasks = [_Part(scene, part, plan, tol, polish, level(certify)) for part in parts]
        for number, solutions in results(_Part.solved, tasks, pool):
            solved[number] = solutions
            if progress is not None:
                progress(f"{sum(map(len, solved))} of {len(motions)} creepages")
    return [solution for part in solved for solution in part]


def scanned(
    scene: Scene,
    creepages: np.ndarray,
    normal: str = "auto",
    tangential: str = "auto",
    coupling: str = "auto",
    *,
    formulation: str = "auto",
    method: str = "auto",
    tol: float = TOLERANCE,
    polish: bool | None = None,
    certify: str | None = "gap",
    progress: Callable[[str], None] | None = None,
    accuracy: float | None = None,
    time_budget: float | None = None,
) -> Iterator[Solution]:
    """The solutions of a `scan`, one after the other. What is wrong with the arguments is said before the first.

    Parameters
    ----------
    scene, creepages, normal, tangential, coupling, formulation, method, tol, polish, certify, progress
        As for `scan`.
    accuracy, time_budget : float, optional
        As for `scan`.
    """
    motions = _motions(scene, creepages)
    if accuracy is not None or time_budget is not None:
        rest: dict[str, Any] = {"tol": tol, "polish": polish, "certify": certify, "progress": progress}
        rest |= {"formulation": formulation, "method": method, "accuracy": accuracy, "time_budget": time_budget}
        posed = [replace(scene, motion=each) for each in motions]
        return (cast(Solution, solve(each, normal, tangential, coupling, **rest)) for each in posed)
    plan = _plan(scene, motions, normal, tangential, coupling, formulation, method)
    tol, polish, progress = checks.positive("tol", tol), polished_by(plan, polish), checks.progress(progress)
    return solve_many(scene, motions, plan, tol, polish, progress, level(certify))


@dataclass(frozen=True)
class _Part:
    """Some motions of a scan, and how they are solved."""

    scene: Scene
    motions: list[Steady | Shift]
    plan: Plan
    tol: float
    polish: bool
    certify: str

    def solved(self) -> list[Solution]:
        return list(solve_many(self.scene, self.motions, self.plan, self.tol, self.polish, certify=self.certify))


def _motions(scene: Scene, creepages: np.ndarray) -> list[Steady | Shift]:
    """The scene's motion with each of the creepages."""
    if not isinstance(scene, Scene):
        raise SceneError("scene", scene, "a Scene")
    motion = scene.motion
    if not isinstance(motion, Steady | Shift) or motion.Fx is not None or motion.Fy is not None:
        raise SceneError(
            "motion",
            motion,
            "Steady or Shift, with no prescribed force",
            message="motion: a scan sets the creepages; give Steady or Shift with no prescribed force",
        )
    triples = _triples(creepages, ("vx", "vy", "spin") if isinstance(motion, Steady) else ("ux", "uy", "rotation"))
    return [_with_rigid(motion, triple) for triple in triples]


def _plan(scene: Scene, motions: list[Steady | Shift], *choices: str) -> Plan:
    """The plan of the first motion, which serves all; what any of them cannot have is refused."""
    plans = [make_plan(replace(scene, motion=each), *choices) for each in motions]
    return plans[0]


def _triples(creepages: np.ndarray, names: tuple[str, str, str]) -> np.ndarray:
    """One row of three for each solution."""
    given = checks.numbers("creepages", creepages)
    if given.ndim != 2 or given.shape[1] != 3 or given.size == 0:
        words = ", ".join(names)
        meant = f"; a single solution is [[{words}]]" if given.shape == (3,) else ""
        raise checks.wrong_shape(
            "creepages", given.shape, f"of shape (k, 3), a row of {words} for each solution{meant}"
        )
    return given


def _with_rigid(motion: Steady | Shift, triple: np.ndarray) -> Steady | Shift:
    """A motion with other creepages."""
    first, second, third = (float(value) for value in triple)
    if isinstance(motion, Steady):
        return replace(motion, vx=first, vy=second, spin=third)
    return replace(motion, ux=first, uy=second, rotation=third)
