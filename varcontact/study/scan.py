"""Creep-force curves: one scene for many creepages."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from concurrent.futures import Executor
from dataclasses import dataclass, replace
from typing import Any, cast

import numpy as np

from varcontact import checks
from varcontact.errors import SceneError
from varcontact.results.solution import Solution
from varcontact.scene.motion import Shift, Steady
from varcontact.scene.scene import Scene
from varcontact.solving import adaptive
from varcontact.solving.options import TOLERANCE, SolveOptions
from varcontact.solving.series import solve_many
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
        As for `solve`, of each solution; of a scene without a grid 1 %. Each then has a grid of its own, and nothing is
        shared between them.

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
    choices: dict[str, Any] = {
        "normal": normal,
        "tangential": tangential,
        "coupling": coupling,
        "formulation": formulation,
    }
    choices |= {"method": method, "tol": tol, "polish": polish, "certify": certify}
    choices |= {"accuracy": accuracy, "time_budget": time_budget}
    solutions = scanned(scene, creepages, **choices, progress=progress)
    with opened(executor, workers) as pool:
        if pool is None:
            return list(solutions)
        triples = checks.numbers("creepages", creepages)
        tasks = [_Part(scene, triples[k : k + CHUNK], choices) for k in range(0, len(triples), CHUNK)]
        solved: list[list[Solution]] = [[] for _ in tasks]
        for number, part in results(_Part.solved, tasks, pool):
            solved[number] = part
            if progress is not None:
                progress(f"{sum(map(len, solved))} of {len(triples)} creepages")
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
    scenes = [replace(scene, motion=each) for each in _motions(scene, creepages)]
    choices = normal, tangential, coupling, formulation, method
    target: dict[str, Any] = {"accuracy": accuracy, "time_budget": time_budget}
    options = SolveOptions.checked(scenes[0], *choices, tol, polish, certify=certify, **target)
    for each in scenes[1:]:  # what any of them cannot have is refused
        options.plan_for(each)
    progress = checks.progress(progress)
    if options.target is not None:
        return (cast(Solution, adaptive.solve(each, options, progress)) for each in scenes)
    motions = [cast(Steady | Shift, each.motion) for each in scenes]
    return solve_many(scene, motions, options.plan, options.tol, options.polish, progress, options.certify)


@dataclass(frozen=True)
class _Part:
    """Some creepages of a scan, and the arguments of `scanned`."""

    scene: Scene
    creepages: np.ndarray
    choices: dict[str, Any]

    def solved(self) -> list[Solution]:
        return list(scanned(self.scene, self.creepages, **self.choices))


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
