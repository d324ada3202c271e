"""Sizes of a scene's problems before they are posed: elements in contact, unknowns, memory."""

from __future__ import annotations

import numpy as np

from varcontact.results.plan import Plan
from varcontact.scene.bodies import Bodies
from varcontact.scene.friction import FrictionBound
from varcontact.scene.grid import Grid
from varcontact.scene.motion import Shift, Steady
from varcontact.scene.scene import Scene
from varcontact.scene.surfaces import SampledDistance
from varcontact.scene.transient import Transient
from varcontact.solving.pipeline import check_memory


def one_direction(scene: Scene) -> bool:
    """True if tractions can arise along x only or along y only: in line contact, where nothing
    moves along y or x.
    """
    motion = scene.motion
    if not scene.line or not isinstance(motion, (Steady, Shift)):
        return False
    along_x = motion.rigid[0] != 0 or motion.Fx is not None or scene.coupled
    along_y = motion.rigid[1] != 0 or motion.Fy is not None
    return not (along_x and along_y)


def own_image(scene: Scene) -> bool:
    """True if a Hertzian contact with an even number of rows is known to be its own mirror image
    about the x-axis.

    With x its tractions along x are even in y and those along y odd where nothing moves along y, or
    about z; and the other way round where nothing moves along x.
    """
    motion = scene.motion
    grid = scene.grid
    placed = isinstance(grid, Grid) and not grid.explicit and grid.rows % 2 == 0
    if not placed or scene.line or scene.hertz is None or not isinstance(motion, (Steady, Shift)):
        return False
    by_element = isinstance(scene.friction, np.ndarray | FrictionBound)
    if any((scene.coupled, scene.loaded, by_element)):
        return False
    along_x, along_y, about_z = motion.rigid
    straight = along_y == about_z == 0 and motion.Fy is None
    return straight or (along_x == 0 and motion.Fx is None)


def elements_in_contact(scene: Scene) -> tuple[float, float]:
    """About the number of elements in contact, and their length along x; zero where that is not
    known.
    """
    grid = scene.own_grid
    # each step of a history has its own
    hertz = None if isinstance(scene.motion, Transient) else scene.hertz
    if not grid.explicit:
        rows = 1.0 if grid.line else np.pi / 4 * grid.rows
        dx = 0.0 if hertz is None else 2 * hertz.a / grid.nx
        return grid.nx * rows, dx
    dx, dy = grid.sides
    if hertz is None:
        return _elements_overlapping(scene, grid), dx
    if grid.line:
        return 2 * hertz.a / dx, dx
    return np.pi * hertz.a * hertz.b / dy / dx, dx


def _elements_overlapping(scene: Scene, grid: Grid) -> float:
    """Half of the elements that overlap, which are in contact in Hertz's, and fewer in line
    contact; all where the approach is not known.
    """
    surface = scene.surface
    if type(scene.bodies) is not Bodies or not isinstance(surface, SampledDistance):
        return grid.size
    if not isinstance(scene.approach, float):
        return grid.size
    return float(np.count_nonzero(surface.distance(grid) < scene.approach)) / 2


def tangential_unknowns(scene: Scene, plan: Plan, elements: float) -> float:
    """Traction components on a number of elements, on one side of a line of symmetry where the plan
    uses it.
    """
    unknowns = elements
    if not one_direction(scene):
        unknowns = 2 * elements
    if plan.solves and not plan.matrix_free("tangential") and own_image(scene):
        return unknowns / 2
    return unknowns


def check_fits(scene: Scene, plan: Plan) -> None:
    """Refuse a contact that is known not to fit into memory before any work; of others each problem
    as it is posed.
    """
    plan.potential_contact.check_size()
    if plan.closed_form and plan.solves and not isinstance(scene.motion, Transient):
        unknowns = tangential_unknowns(scene, plan, elements_in_contact(scene)[0])
        check_memory("tangential", plan.solver_of("tangential"), plan.formulation, unknowns)
