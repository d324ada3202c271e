"""Parts of a patch that are so close that the pressure of one displaces the other in part."""

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
"""Elements that overlap, up to which NORM is asked first."""

INTERACTION_ROUNDS = 40
"""Largest number of iterations for the pressures of parts."""
INTERACTION_TOL = 1e-6
"""Change of the distance that ends them, relative to the approach."""


def with_interaction(scene: Scene, interactions: Interactions) -> Scene:
    """The scene with the undeformed distance in which each part of a patch feels the others by the
    interactions' weights.

    Parts lie in one plane. The displacement that the pressure of one makes in another is multiplied
    by a weight, from 1 where they are so near as to be one patch to 0 where they are two: forces do
    not jump when parts come nearer, as in CONTACT (D_COMB, D_SEP). What a part would feel too much
    is taken off its distance, with the pressures of the round before.
    """
    surface = scene.surface
    assert isinstance(surface, SampledDistance)
    assert scene.approach is not None
    grid = scene.grid
    if not isinstance(grid, Grid):
        grid = _grid_of_samples(surface)
    # the part of each row of elements, and the displacement that it does not feel, by the two parts
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
        # pressures with the excess displacement of the round before
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
    """The grid whose elements have the samples of a surface at their centres."""
    x, y = surface.coordinates
    dx = x[1] - x[0]
    dy = y[1] - y[0]
    return Grid(nx=x.size, ny=y.size, dx=dx, dy=dy, x0=x[0] - dx / 2, y0=y[0] - dy / 2)


def _unfelt(weights: np.ndarray) -> np.ndarray:
    """Shares of the displacement by one part that another does not feel: 1 less the product of the
    weights of the interactions between them.
    """
    count = weights.size + 1
    shares = np.zeros((count, count))
    for i, j in np.ndindex(count, count):
        shares[i, j] = 1 - np.prod(weights[min(i, j) : max(i, j)])
    return shares


def _pressures(problem: NormalProblem, start: RawSolution | None) -> RawSolution:
    """NORM, the fastest where the contact hardly changes from round to round, or Newton's method
    where elements are many; splitting, where these fail.
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
