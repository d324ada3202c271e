"""Patches in parts that feel each other less than on one half-space, between one patch and two.

The parts lie in one plane, with seams between them. The displacement that the pressure of one part makes in another is
multiplied by a weight, from 1 where they are as near as to be one patch to 0 where they are two. Forces then do not
jump when a wheel moves and parts come nearer; CONTACT does the same (D_COMB, D_SEP).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from varcontact.elasticity.operators import influence_operator
from varcontact.errors import NotConverged
from varcontact.results.solution import Solution
from varcontact.scene.grid import Grid
from varcontact.scene.scene import Scene
from varcontact.scene.surfaces import SampledDistance

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


def weakened(scene: Scene, seams: Seams, solve_normal: Callable[[Scene], Solution]) -> Scene:
    """The scene with the undeformed distance in which each part feels the others by their weights.

    What a part would feel too much of the others is taken off its distance, with the pressures of the round before.

    Parameters
    ----------
    scene : Scene
        With sampled distance and an explicit grid.
    seams : tuple of pairs of float
        Where they lie along y, ascending, and the weights across them.
    solve_normal : callable
        Solves a scene's normal problem.

    Returns
    -------
    Scene

    Raises
    ------
    NotConverged
        If the rounds do not end.
    """
    surface, grid, approach = scene.surface, scene.grid, scene.approach
    assert isinstance(surface, SampledDistance)
    assert isinstance(grid, Grid)
    assert approach is not None
    part, missing = _parts(grid, seams)
    influence = influence_operator(grid, "z", "z", nu=scene.bodies.combined_nu)
    taken = np.zeros(grid.shape)
    for _ in range(ROUNDS):
        scene = replace(scene, surface=SampledDistance(surface.h - taken))
        pressure = solve_normal(scene).pressure / scene.bodies.combined_G
        before, taken = taken, np.zeros(grid.shape)
        for j in range(len(missing)):
            felt = influence.apply((pressure * (part == j)[:, None])[None])[0]
            taken += missing[part, j][:, None] * felt
        change = float(np.abs(taken - before).max())
        if change <= CLOSE * approach:
            return scene
    raise NotConverged("the parts of a patch were not brought to rest", change / approach)


def _parts(grid: Grid, seams: Seams) -> tuple[np.ndarray, np.ndarray]:
    """The part of each row, and for each pair of parts what their influence lacks."""
    places, weights = (np.array(each) for each in zip(*seams, strict=True))
    count = len(weights) + 1
    felt = np.ones((count, count))
    for i in range(count):
        for j in range(count):
            felt[i, j] = np.prod(weights[min(i, j) : max(i, j)])
    return np.searchsorted(places, grid.y), 1 - felt
