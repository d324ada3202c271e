"""Parts of a patch that are so near to each other that they feel each other in part."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from varcontact.discrete.discretisation import discretise
from varcontact.errors import NotConverged
from varcontact.scene.grid import Grid
from varcontact.scene.scene import Scene
from varcontact.scene.surfaces import SampledDistance
from varcontact.solvers.active_set.norm import norm
from varcontact.solvers.interface import Settings
from varcontact.solvers.newton.driver import DENSE
from varcontact.solvers.newton.normal import newton_normal
from varcontact.wheel_rail.patches import Seams

WEAK_ROUNDS, WEAK_CLOSE = 40, 1e-6
"""Rounds for the pressures of parts, and the change of the distance, relative to the approach, that
ends them."""


def weakened(scene: Scene, seams: Seams) -> Scene:
    """The scene with the undeformed distance in which each part of a patch feels the others by the
    seams' weights.

    Parts lie in one plane. The displacement that the pressure of one makes in another is multiplied
    by a weight, from 1 where they are so near as to be one patch to 0 where they are two: forces do
    not jump when parts come nearer, as in CONTACT (D_COMB, D_SEP). What a part would feel too much
    is taken off its distance, with the pressures of the round before.
    """
    surface, grid = scene.surface, scene.grid
    assert isinstance(surface, SampledDistance)
    if not isinstance(grid, Grid):
        x, y = surface.coordinates
        dx, dy = x[1] - x[0], y[1] - y[0]
        grid = Grid(nx=x.size, ny=y.size, dx=dx, dy=dy, x0=x[0] - dx / 2, y0=y[0] - dy / 2)
    assert scene.approach is not None
    places, weights = np.array(seams).T
    count = weights.size + 1
    missing = np.array(
        [[1 - np.prod(weights[min(i, j) : max(i, j)]) for j in range(count)] for i in range(count)]
    )
    part = np.searchsorted(places, grid.y)
    on_grid = replace(
        scene, motion=None, friction=None, grid=grid, surface=replace(surface, x=None, y=None)
    )
    disc = discretise(on_grid, grid)
    problem = disc.normal_problem()
    assert problem.approach is not None
    taken, raw = np.zeros(grid.shape), None
    for _ in range(WEAK_ROUNDS):
        near = replace(problem, distance=problem.distance - taken.ravel())
        # NORM is the fastest where the contact hardly changes from round to round, unless elements
        # are many
        few = np.count_nonzero(near.distance < problem.approach) <= DENSE
        found = norm(near, raw) if few else None
        raw = (
            found
            if found is not None and found.solved
            else newton_normal(near, Settings(loose_tolerance=True), raw)
        )
        pressure, before = raw.traction.reshape(grid.shape), taken
        parts = [
            disc.operators.normal.apply((pressure * (part == j)[:, None])[None])[0]
            for j in range(count)
        ]
        taken = sum(missing[part, j][:, None] * felt for j, felt in enumerate(parts))
        change = float(np.abs(taken - before).max()) * disc.scales.displacement / scene.approach
        if change <= WEAK_CLOSE:
            return replace(
                scene, surface=replace(surface, h=surface.h - taken * disc.scales.displacement)
            )
    raise NotConverged("the pressures of the parts of a patch did not settle", change)
