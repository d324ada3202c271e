"""Derivatives on a grid that follows the contact, as the continuum has them.

The continuum's output J does not depend on the grid. On a fixed grid, elements enter at the
leading edge by jumps, which hold most of the derivative by load or shape. On a grid that is
stretched and shifted with the moments of the pressure none enters: ``dJ/dtheta = partial
J/partial theta + J_grid . d(extent)/dtheta``, the last by a second adjoint. With Hertz's pressure
the grid is stretched with his ellipse, which is known.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from varcontact.gradients.adjoint import RELATIVE_STEP, Adjoint, LinearisedSolution, SceneOf
from varcontact.gradients.contact_fields import ContactFields
from varcontact.gradients.outputs import Output, Partial
from varcontact.scene.grid import Grid
from varcontact.scene.scene import Scene
from varcontact.scene.surfaces import SampledDistance

GRID_STEP = 1e-5
"""Step of the central difference with respect to the grid, relative to its width or an element's
side."""


@dataclass(frozen=True, eq=False)
class Extent(Output):
    """Weighted sum of the logarithms of the widths of the pressure along x and y, and of its centre
    (x, y), by moments: `weights` (4,). Only its derivative is of use.
    """

    weights: np.ndarray

    def value(self, fields: ContactFields) -> float:
        return 0.0

    def partial(self, fields: ContactFields) -> Partial:
        pressure = fields.pressure
        total = pressure.sum()
        found = np.zeros_like(pressure)
        for axis, along in enumerate(fields.places):
            middle = (pressure * along).sum() / total
            from_middle = along - middle
            variance = (pressure * from_middle**2).sum() / total
            if variance > 0:
                widening = (from_middle**2 / variance - 1) / (2 * total)
                found += self.weights[axis] * widening
            found += self.weights[2 + axis] * from_middle / total
        return Partial(pressure=found)


@dataclass(frozen=True, eq=False)
class Following:
    """Output on a grid that moves and stretches with the contact."""

    held: Adjoint
    extent: Adjoint

    @classmethod
    def of(cls, about: LinearisedSolution, output: Output) -> Following:
        held = about.adjoint(output)
        by_grid = np.zeros(4)
        axes = range(2 - about.fields.disc.grid.line)
        for axis in axes:
            by_grid[axis] = _by_grid(held, axis, stretched=True)
            by_grid[2 + axis] = _by_grid(held, axis, stretched=False)
        return cls(held, about.adjoint(Extent(by_grid)))

    def along(self, scene_of: SceneOf, value: float) -> float:
        """Derivative with respect to any number of the scene."""
        return self.held.along(scene_of, value) + self.extent.along(scene_of, value)

    def between(self, above: Scene, below: Scene) -> float:
        """Difference of the output between two scenes, one on either side."""
        return self.held.between(above, below) + self.extent.between(above, below)


def along_with_ellipse(adjoint: Adjoint, scene_of: SceneOf, value: float) -> float:
    """Derivative with respect to any number of the scene, on a grid that is stretched with Hertz's
    ellipse.
    """
    step = RELATIVE_STEP * (abs(value) or 1.0)
    scenes = [scene_of(value + step), scene_of(value - step)]
    above, below = (adjoint.lagrangian(scene, _with_ellipse(adjoint, scene)) for scene in scenes)
    return (above - below) / (2 * step)


def _with_ellipse(adjoint: Adjoint, scene: Scene) -> Grid:
    """The grid of the solution, stretched as Hertz's ellipse is in another scene."""
    own = adjoint.about.fields.disc.hertz
    other = scene.hertz
    assert own is not None
    assert other is not None
    grid = adjoint.about.solution.grid
    dx, dy = grid.sides
    along_x = other.a / own.a
    changes: dict[str, Any] = {"dx": dx * along_x, "x0": grid.lines[0][0] * along_x}
    if not grid.line:
        along_y = other.b / own.b
        changes |= {"dy": dy * along_y, "y0": grid.lines[1][0] * along_y}
    return replace(grid, **changes)


def _by_grid(held: Adjoint, axis: int, *, stretched: bool) -> float:
    """Derivative of the Lagrangian as the grid is stretched about the centre of pressure along an
    axis, or shifted.
    """
    step = GRID_STEP
    if not stretched:
        step *= held.about.solution.grid.sides[axis]
    above = _on_moved_grid(held, axis, step, stretched)
    below = _on_moved_grid(held, axis, -step, stretched)
    return (above - below) / (2 * step)


def _on_moved_grid(held: Adjoint, axis: int, step: float, stretched: bool) -> float:
    """The Lagrangian on a grid that is stretched or shifted, with the fields carried along."""
    fields = held.about.fields
    scene = fields.scene
    grid = held.about.solution.grid
    places = fields.places[axis]
    middle = float((fields.pressure * places).sum() / fields.pressure.sum())

    # the grid
    side = ("dx", "dy")[axis]
    corner = ("x0", "y0")[axis]
    first = getattr(grid, corner)
    changes: dict[str, Any] = {corner: first + step}
    shift: np.ndarray | float = step
    if stretched:
        changes = {
            side: getattr(grid, side) * (1 + step),
            corner: middle + (first - middle) * (1 + step),
        }
        shift = step * (places - middle)
    moved = replace(grid, **changes)

    # fields given by element keep their places in space
    def in_place(field: np.ndarray) -> np.ndarray:
        slope = np.gradient(field, grid.sides[axis], axis=1 - axis, edge_order=2)
        carried: np.ndarray = field + shift * slope
        return carried

    entries: dict[str, Any] = {"grid": moved}
    surface = scene.surface
    if isinstance(surface, SampledDistance):
        if surface.x is None:
            samples = in_place(surface.samples)
        else:
            samples = surface.distance(moved, beyond=max(moved.sides))
        if grid.line:
            samples = samples[0]
        entries["surface"] = SampledDistance(samples, reference_depth=surface.reference_depth)
    if isinstance(scene.friction, np.ndarray):
        entries["friction"] = in_place(np.broadcast_to(scene.friction, grid.shape))
    return held.lagrangian(replace(scene, **entries), moved)
