"""Patches in parts that feel each other less than on one half-space, between one patch and two.

The parts lie in one plane, with seams between them. The displacement that the pressure of one part makes in another is
multiplied by a weight, from 1 where they are as near as to be one patch to 0 where they are two. Forces then do not
jump when a wheel moves and parts come nearer; CONTACT does the same (D_COMB, D_SEP).
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from varcontact.discrete.discretisation import discretise
from varcontact.discrete.problems import NormalProblem, RawSolution
from varcontact.errors import NotConverged
from varcontact.scene.grid import Grid
from varcontact.scene.scene import Scene
from varcontact.scene.surfaces import SampledDistance
from varcontact.solvers.active_set.norm import norm
from varcontact.solvers.interface import Settings
from varcontact.solvers.newton.driver import DENSE
from varcontact.solvers.newton.normal import newton_normal

FALL = 0.8
"""Exponent of the weight's fall with the distance of the parts, CONTACT's."""
ROUNDS, CLOSE = 40, 1e-6
"""Rounds at most, and the change of the distance that ends them, by the approach."""

Seams = tuple[tuple[float, float], ...]


def seam_weight(apart: float, join: float, separate: float) -> float:
    """How much parts feel each other.

    Parameters
    ----------
    apart : float
        Their distance [mm].
    join, separate : float
        Up to which they are one patch, and from which they are two [mm].

    Returns
    -------
    float
        From 1 to 0.

    Examples
    --------
    >>> [round(seam_weight(apart, 4.0, 8.0), 3) for apart in (3.0, 4.0, 6.0, 8.0)]
    [1.0, 1.0, 0.574, 0.0]
    """
    if apart <= join:
        return 1.0
    return max(0.0, (separate - apart) / (separate - join)) ** FALL


def weakened(scene: Scene, seams: Seams) -> Scene:
    """The scene with the undeformed distance in which each part feels the others by their weights.

    What a part would feel too much of the others is taken off its distance, with the pressures of the round before.

    Parameters
    ----------
    scene : Scene
        With sampled distance and an explicit grid.
    seams : tuple of pairs of float
        Where they lie along y, ascending, and the weights across them.

    Returns
    -------
    Scene

    Raises
    ------
    NotConverged
        If the rounds do not end.
    """
    surface, grid = scene.surface, scene.grid
    assert isinstance(surface, SampledDistance)
    assert isinstance(grid, Grid)
    assert scene.approach is not None
    disc = discretise(replace(scene, motion=None, friction=None), grid, coupled=False)
    problem, (part, missing) = disc.normal_problem(), _parts(grid, seams)
    taken, raw = np.zeros(grid.shape), None
    for _ in range(ROUNDS):
        raw = _pressed(replace(problem, distance=problem.distance - taken.ravel()), raw)
        pressure, before = raw.traction.reshape(grid.shape), taken
        parts = [disc.operators.normal.apply((pressure * (part == j)[:, None])[None])[0] for j in range(len(missing))]
        taken = sum(missing[part, j][:, None] * felt for j, felt in enumerate(parts))
        change = float(np.abs(taken - before).max()) * disc.scales.displacement / scene.approach
        if change <= CLOSE:
            return replace(scene, surface=SampledDistance(surface.h - taken * disc.scales.displacement))
    raise NotConverged("the parts of a patch were not brought to rest", change)


def _pressed(problem: NormalProblem, start: RawSolution | None) -> RawSolution:
    """By NORM, the fastest where the contact hardly changes from round to round, or with many elements by Newton."""
    assert problem.approach is not None
    if np.count_nonzero(problem.distance < problem.approach) <= DENSE:
        raw = norm(problem, start)
        if raw.solved:
            return raw
    return newton_normal(problem, Settings(rough=True), start)


def _parts(grid: Grid, seams: Seams) -> tuple[np.ndarray, np.ndarray]:
    """The part of each row, and for each pair of parts what their influence lacks."""
    places, weights = (np.array(each) for each in zip(*seams, strict=True))
    count = len(weights) + 1
    felt = np.ones((count, count))
    for i in range(count):
        for j in range(count):
            felt[i, j] = np.prod(weights[min(i, j) : max(i, j)])
    return np.searchsorted(places, grid.y), 1 - felt
