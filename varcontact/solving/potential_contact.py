"""The size of the potential contact."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from itertools import product

import numpy as np

from varcontact.checks import LARGE
from varcontact.discrete.contact_grid import (
    across,
    clipped,
    contact_box,
    enlarged,
    fitted,
    if_noise,
    known_grid,
    within,
)
from varcontact.discrete.discretisation import Discretisation, discretise
from varcontact.discrete.operators import Operators
from varcontact.discrete.penetration import outside
from varcontact.discrete.state import ContactState, unloaded
from varcontact.discrete.stick_slip import unit_slip
from varcontact.errors import SceneError
from varcontact.results.solution import Solution
from varcontact.scene.grid import Grid
from varcontact.scene.scene import Scene
from varcontact.scene.surfaces import SampledDistance
from varcontact.solving.contact_solver import ContactSolver, contact
from varcontact.solving.grid_transfer import interpolated
from varcontact.solving.selection import many_pressures

FOUND = 1e-4
"""Residual of a pressure that only tells where the contact is, before it is solved for on parts of the elements."""

ROUNDING = 1e-9
"""Part of an element by which a sample may miss its border and still lie on it."""

PressureOn = Callable[[Discretisation, ContactState], ContactState]
"""Solves the frictionless normal problem of a discretisation, from a state that may have a pressure to begin with."""


def first_grid(scene: Scene, pressure_on: PressureOn) -> Grid:
    """An explicit grid for a scene: its own, or one across the bounding box of the contact.

    A Hertzian contact has its ellipse. For sampled distances the box is found by looks at the frictionless
    contact, first across all samples, then closer and closer.

    Parameters
    ----------
    scene : Scene
    pressure_on : callable
        Solves the frictionless normal problem of a discretisation.
    """
    return _looked_for(scene, pressure_on)[0]


def _looked_for(scene: Scene, pressure_on: PressureOn) -> tuple[Grid, _Found | None]:
    """The first grid of a scene, and the contact that the last look found, if one was needed."""
    spec = known_grid(scene)
    if spec.explicit:
        return spec, None
    surface = scene.surface
    assert isinstance(surface, SampledDistance)
    box, found = surface.box, None
    depth = None if scene.approach is None else surface.reference_depth  # which may lie within the samples
    for _ in range(60):
        look = Grid(nx=24, ny=None if scene.line else 24, margin=0).spread(box)
        lowest = _lowest_in_elements(surface, look, depth)
        disc = discretise(replace(scene, surface=lowest, grid=look, motion=None, friction=None), look)
        state = pressure_on(disc, unloaded(look) if found is None else found.on(disc))
        found = _Found.of(disc, state)
        contact = contact_box(look, state.pressure)
        if min(across(state.pressure)) >= (1 if scene.line else 8) and max(across(state.pressure)) >= 8:
            break
        box = clipped(contact_box(look, state.pressure, around=1), surface)
    return within(spec.spread(contact), surface), found


def solve_contact(
    scene: Scene,
    steps: ContactSolver,
    known: Operators | None = None,
    begun: Callable[[Discretisation, ContactState], ContactState] | None = None,
    near: Solution | None = None,
) -> tuple[Discretisation, ContactState]:
    """Solve; where the contact goes on outside a grid of our choice, enlarge that and solve again.

    Operators that are `known` from the scene before serve again, where they are of the same lattice.
    The contact without tangential tractions settles the grid; of unlike bodies it is then that with tractions.

    Parameters
    ----------
    scene : Scene
    steps : Steps
    known : Operators, optional
    begun : callable, optional
        Gives the state without tractions those to begin with.
    near : Solution, optional
        Of the same scene on another grid: the contact is looked for where that has it, from its pressure, and
        tractions are begun from its own.

    Returns
    -------
    Discretisation
    ContactState
        The solution, dimensionless.

    Raises
    ------
    SceneError
        If no grid is found that holds the contact.
    """
    closed_form, coupled = steps.plan.closed_form, steps.plan.coupling != "none"
    with steps.stats.stage("grid"):
        normal = steps.plan.normal if steps.plan.convex else "norm"
        looks = ContactSolver(replace(steps.plan, normal=normal), 1e-6, True, steps.stats, deadline=steps.deadline)
        beside = None if near is None or closed_form else _Found(near.grid, near.pressure, near.approach)
        grid, last = _looked_for(scene, looks.pressure) if beside is None else _near(scene, beside)
    if near is not None and begun is None:
        begun = partial(_rubbing_as, near)
    moved = 0
    for attempt in range(20):
        disc = discretise(scene, grid, known, coupled=not steps.plan.left_out)
        known = disc.operators
        disc, state = _pressed(scene, disc, steps, unloaded(grid) if last is None else last.on(disc), attempt < 3)
        with steps.stats.stage("grid"):
            overlap = outside(disc, state, closed_form)
            closer = fitted(scene, grid, state.pressure) if attempt < 3 else None
        if (overlap is None and closer is None) or (coupled and moved):
            state = contact(disc, steps, state if begun is None else begun(disc, state))
            if not coupled:
                return disc, state
            with steps.stats.stage("grid"):
                overlap = outside(disc, state)
                closer = fitted(scene, grid, state.pressure, any_surface=True) if 0 < moved < 4 else None
            if overlap is None and closer is None:
                return disc, state
            moved += 1
        known.forget()
        last = _Found.of(disc, state)
        if overlap is not None:
            grid = enlarged(scene, grid, state.pressure, overlap, 0.1 * (moved > 0))
        elif closer is not None:
            grid = closer
    raise SceneError(
        "grid",
        scene.grid,
        "explicit",
        message="grid: no potential contact was found that holds the contact; give an explicit grid"
        f"{if_noise(scene, grid)}",
    )


def _pressed(
    scene: Scene, disc: Discretisation, steps: ContactSolver, state: ContactState, may_move: bool
) -> tuple[Discretisation, ContactState]:
    """The pressure without tractions; on parts of the elements only where the grid is the last one, as far as known."""
    if steps.plan.cells(scene) == (1, 1):
        return disc, steps.pressure(disc, state)
    if known_grid(scene).explicit:
        return steps.pressed_on_parts(disc, state)
    few = not (steps.plan.convex or many_pressures(scene))
    plan = replace(steps.plan, normal="norm") if few else steps.plan
    with steps.stats.stage("grid"):
        look = replace(steps, plan=plan, tol=max(steps.tol, FOUND), refined=False)
        state = look.pressure(disc, state)
        moves = outside(disc, state) is not None or (may_move and fitted(scene, disc.grid, state.pressure) is not None)
    return (disc, state) if moves else steps.pressed_on_parts(disc, state)


@dataclass(frozen=True, eq=False)
class _Found:
    """A contact that was found on a grid, physical: where that on the next one is found from."""

    grid: Grid
    pressure: np.ndarray
    approach: float

    @classmethod
    def of(cls, disc: Discretisation, state: ContactState) -> _Found:
        """That of a state on a discretisation."""
        return cls(
            disc.grid, state.pressure * disc.scales.pressure, state.approach * disc.scales.displacement + disc.base
        )

    def on(self, disc: Discretisation) -> ContactState:
        """Its pressure on the elements of another grid."""
        pressure = interpolated(self.grid, self.pressure[None], disc.grid)[0] / disc.scales.pressure
        approach = (self.approach - disc.base) / disc.scales.displacement if np.isfinite(self.approach) else 0.0
        return replace(unloaded(disc.grid), pressure=pressure, approach=approach)


def _near(scene: Scene, found: _Found) -> tuple[Grid, _Found]:
    """The scene's grid, without a look: across the contact that was found, where it is not known anyway."""
    spec = known_grid(scene)
    grid = spec if spec.explicit else spec.spread(contact_box(found.grid, found.pressure))
    return within(grid, scene.surface), found


def _rubbing_as(near: Solution, disc: Discretisation, state: ContactState) -> ContactState:
    """The state with the tractions of a solution on another grid; under a law of friction they choose no branch."""
    motion = disc.loading.motion
    if motion is None or disc.loading.law is not None:
        return state
    traction = interpolated(near.grid, near.traction, disc.grid) * (state.pressure > 0) / disc.scales.pressure
    found = np.nan_to_num(near.creepage[:2]) * unit_slip(disc)
    given = [motion.Fx is None, motion.Fy is None]
    return replace(state, traction=traction, rigid=np.where(given, 0.0, found))


def _lowest_in_elements(surface: SampledDistance, grid: Grid, depth: float | None) -> SampledDistance:
    """The lowest distance known in each element: no summit falls between the centres of a coarse look.

    A sample on the border of elements counts in all of them: a surface and its mirror image have mirrored grids.
    """
    distance = np.clip(surface.distance(grid), -LARGE, LARGE)  # splines swing
    x, y = surface.coordinates
    (dx, dy), (x0, _, y0, _) = grid.sides, grid.box
    for way_x, way_y in product((-ROUNDING, ROUNDING), repeat=2):
        ix, iy = np.floor((x - x0) / dx + way_x).astype(int), np.floor((y - y0) / dy + way_y).astype(int)
        columns, rows = (ix >= 0) & (ix < grid.nx), (iy >= 0) & (iy < grid.rows)
        flat = (iy[rows, None] * grid.nx + ix[None, columns]).ravel()
        np.minimum.at(distance.ravel(), flat, surface.samples[np.ix_(rows, columns)].ravel())
    return SampledDistance(distance[0] if grid.line else distance, reference_depth=depth)
