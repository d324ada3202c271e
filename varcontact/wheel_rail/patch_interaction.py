"""Interaction between parts of a patch: the pressure of one displaces the others in part."""

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
from varcontact.solvers.newton.normal import newton_normal
from varcontact.solvers.splitting.method import splitting_normal
from varcontact.wheel_rail.patches import Interactions

NORM_ELEMENTS_MAX = 2000
"""Number of overlapping elements up to which NORM is tried first."""

INTERACTION_ROUNDS = 40
"""Largest number of iterations for the pressures of parts."""
INTERACTION_TOL = 1e-6
"""Change of the distance, relative to the approach, below which the iteration over parts ends."""


def with_interaction(scene: Scene, interactions: Interactions) -> Scene:
    """Scene with the undeformed distance that represents the weighted interaction between the parts
    of a patch.

    Parts lie in one plane. The displacement that the pressure of one causes in another is
    multiplied by a weight, from 1 for parts so close that they are one patch to 0 for separate
    patches: forces do not jump when parts approach each other, as in CONTACT (D_COMB, D_SEP). The
    excess displacement is subtracted from the undeformed distance, with the pressures of the
    previous round.
    """
    surface = scene.surface
    assert isinstance(surface, SampledDistance)
    assert scene.approach is not None
    grid = scene.grid
    if not isinstance(grid, Grid):
        grid = _grid_of_samples(surface)
    # the part of each row of elements, and shares of displacements that do not act, by both parts
    places, weights = np.array(interactions).T
    part = np.searchsorted(places, grid.y)
    unfelt = _unfelt(weights)
    disc = discretise(
        replace(scene.without_friction, grid=grid, surface=replace(surface, x=None, y=None)),
        grid,
    )
    problem = disc.normal_problem()
    assert problem.approach is not None
    excess = np.zeros(grid.shape)
    raw = None
    for _ in range(INTERACTION_ROUNDS):
        # pressures with the excess displacement of the previous round
        posed = replace(problem, distance=problem.distance - excess.ravel())
        raw = _pressures(posed, raw)
        pressure = raw.traction.reshape(grid.shape)
        # the excess displacement of these pressures
        before = excess
        displaced = []
        for j in range(weights.size + 1):
            own = pressure * (part == j)[:, None]
            displaced.append(disc.operators.normal.apply(own[None])[0])
        excess = sum([unfelt[part, j][:, None] * u for j, u in enumerate(displaced)])
        change = float(np.abs(excess - before).max()) * disc.scales.displacement / scene.approach
        if change <= INTERACTION_TOL:
            distance = surface.h - excess * disc.scales.displacement
            return replace(scene, surface=replace(surface, h=distance))
    raise NotConverged("the pressures of the parts of a patch did not settle", change)


def _grid_of_samples(surface: SampledDistance) -> Grid:
    """Grid with the samples of a surface at its element centres."""
    x, y = surface.coordinates
    dx = x[1] - x[0]
    dy = y[1] - y[0]
    return Grid(nx=x.size, ny=y.size, dx=dx, dy=dy, x0=x[0] - dx / 2, y0=y[0] - dy / 2)


def _unfelt(weights: np.ndarray) -> np.ndarray:
    """Shares of a part's displacement that do not act on another part: 1 minus the product of the
    interaction weights between them.
    """
    count = weights.size + 1
    shares = np.zeros((count, count))
    for i, j in np.ndindex(count, count):
        shares[i, j] = 1 - np.prod(weights[min(i, j) : max(i, j)])
    return shares


def _pressures(problem: NormalProblem, start: RawSolution | None) -> RawSolution:
    """Pressures by NORM, the fastest where the contact hardly changes between rounds, or by
    Newton's method for many elements; by splitting, where these fail.
    """
    if np.count_nonzero(problem.distance < problem.approach) <= NORM_ELEMENTS_MAX:
        raw = norm(problem, start)
        if raw.solved:
            return raw
    settings = Settings(loose_tolerance=True)
    raw = newton_normal(problem, settings, start)
    if raw.solved:
        return raw
    return splitting_normal(problem, settings, raw)
