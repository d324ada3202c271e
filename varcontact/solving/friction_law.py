"""Friction laws: an outer loop of problems with a given coefficient of friction
in each element (paper, 1.7).

A pass solves the contact with the coefficients as they are, then gives each
element that slips the coefficient that the law has at its slip. An element that
sticks keeps its own: where ``|p| <= f pz`` and nothing slips, any larger
coefficient has the same tractions, the static one too.

The less friction, the more slip, and the less friction: solutions may be
several. From stick all over (the static coefficient) the passes come down to
one with much friction, from slip all over (the kinetic one) they rise to one
with little. With a static and a kinetic coefficient an element changes from
static to kinetic once and for all, so that the passes are no more than there
are elements; and the solution for the kinetic one alone is always one of the
solutions.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from varcontact.discrete.discretisation import Discretisation
from varcontact.discrete.operators import Operators
from varcontact.discrete.state import ContactState
from varcontact.discrete.stick_slip import (
    SLIP,
    STICK,
    friction_work,
    own_influence,
    shift_and_areas,
    unit_slip,
)
from varcontact.discrete.temperature import (
    RISE,
    Heat,
    background,
    surface_temperatures,
    temperature_rise,
)
from varcontact.errors import SceneError
from varcontact.interfaces.coulomb import FRICTION
from varcontact.interfaces.potential import magnitude, project
from varcontact.results.solution import Solution
from varcontact.scene.friction import Law
from varcontact.scene.motion import Steady, TimeStep
from varcontact.transports import further_along

POWER_STEPS = 15
"""Iterations for the largest eigenvalue, to a few per cent."""
SMALL_SLIP = 1e-6
"""Relative slip over which the slope of a law at no slip is taken that is known by its values
alone."""


def with_coefficients(
    disc: Discretisation, state: ContactState, start: str | Solution | None
) -> ContactState:
    """The state with coefficients to begin with: its own, or those of the start."""
    if state.friction is not None:
        return state
    law = _law(disc)
    grid = disc.grid
    if isinstance(start, Solution):
        if start.grid.shape != grid.shape:
            raise SceneError(
                "start",
                f"a Solution of shape {start.grid.shape}",
                f"on a grid of shape {grid.shape}",
            )
        friction = _of_slip(law, start)
    else:
        first = law.kinetic if start == "slip" else law.static
        friction = np.full(grid.shape, first)
    return replace(state.under(friction=friction), branch=branch_of(start))


def coefficients_after(disc: Discretisation, state: ContactState) -> np.ndarray:
    """The law's coefficients at the slip of a state, where it slips with those it had; elsewhere
    these.
    """
    assert state.friction is not None
    law = _law(disc)
    shift, areas = shift_and_areas(disc, state)
    slip = np.hypot(*shift) * (areas == SLIP) / unit_slip(disc)
    own, rest = _own(disc, state, slip)
    if law.memory_distance > 0:
        return _with_memory(disc, state, own, rest, slip)
    if law.local:
        return own
    return np.where(areas == SLIP, own, state.friction)


def coefficient(disc: Discretisation, state: ContactState) -> np.ndarray:
    """The law's own coefficient (ny, nx) at the slip of a state from any source; the static one
    where it sticks.

    An element slips where its traction is nearer to the law's at its shift than its shift is to
    none; and where it would slip even under the static coefficient: then that is not what it should
    have.
    """
    law = _law(disc)
    if law.memory_distance > 0:
        friction = disc.loading.coefficient if state.friction is None else state.friction
        shift, areas = shift_and_areas(disc.under(friction=np.asarray(friction)), state)
        slip = np.hypot(*shift) * (areas == SLIP) / unit_slip(disc)
        return _with_memory(disc, state, *_own(disc, state, slip), slip)
    shift, _ = shift_and_areas(disc, replace(state, slips=None))
    change = shift / own_influence(disc)
    own, static = _own(disc, state, np.hypot(*shift) / unit_slip(disc))
    trial = (state.traction - change).reshape(2, -1)
    static_bound = (static * state.pressure).ravel()
    beyond = magnitude(trial) > static_bound * (1 + 1e-8) + 1e-12 * magnitude(trial).max()
    projected = project(trial, (own * state.pressure).ravel())
    off_law = magnitude(state.traction.reshape(2, -1) - projected)
    nearer = off_law < magnitude(change.reshape(2, -1))
    return np.where((beyond | nearer).reshape(own.shape), own, static)


def branch_of(start: str | Solution | None) -> str:
    if isinstance(start, Solution):
        return "solution"
    return start or "stick"


def carried_coefficients(
    disc: Discretisation, before: Solution, heated: Sequence[Heat] = ()
) -> np.ndarray | None:
    """The coefficients (ny, nx) that particles bring along into a step of a history; None without a
    law.

    Slipping particles keep that of their slip; those from between two centres have the coefficients
    there, weighted as displacements are. With a memory they slide on the way as others at the same
    place did in the step before.
    """
    law = disc.loading.law
    motion = disc.loading.motion
    if law is None:
        return None
    assert motion is not None
    # the coefficients at the place where particles come from
    of_slip, of_particles = _coefficients(law, before)
    whole, part = _passed(disc)
    if law.memory_distance > 0:
        of_slip = of_particles
    fresh = None if law.local else law.static
    nearest = of_particles if whole == 0 else of_slip
    carried = further_along(nearest, motion.rolls * whole, fresh)
    if part != 0:
        next_one = further_along(of_slip, motion.rolls * (whole + 1), fresh)
        carried = (1 - part) * carried + part * next_one
    if law.memory_distance == 0 or disc.step is None:
        return carried

    # after sliding on the way
    slip = np.where(before.state == SLIP, np.hypot(*before.slip), 0.0)
    temperature = None
    thermal = disc.loading.thermal
    if law.warm and thermal is not None:
        rise = np.zeros(disc.grid.shape)
        if heated:
            rise = temperature_rise(heated, disc.grid.sides[0], thermal)
        temperature = rise + background(1.0, thermal)[0]
    places = np.meshgrid(disc.grid.x, disc.grid.y)
    own = law.on(slip, temperature, before.pressure, *places)
    return law.after(carried, own, slip, disc.step * disc.scales.length)


def weakening(disc: Discretisation, before: Solution | None, solution: Solution) -> np.ndarray:
    """The part of ``static - kinetic`` that the particles have lost, (ny, nx) in [0, 1]; `disc` has
    the coefficients.

    Without a memory those that slip have lost that of their slip. An element that sticks forgets as
    other particles fill it, and at once where nothing rolls.
    """
    law = _law(disc)
    left = np.asarray(disc.loading.coefficient)
    if law.memory_distance == 0 and not law.local:
        left = _of_slip(law, solution)
        whole, part = _passed(disc)
        if before is not None and whole == 0 and part > 0:
            _, own = _coefficients(law, before)
            left = np.where(solution.state == STICK, (1 - part) * own + part * law.static, left)
    span = max(law.static - law.kinetic, np.finfo(float).tiny)
    return np.clip((law.static - left) / span, 0.0, 1.0)


def stick_slip_warning(disc: Discretisation, state: ContactState) -> str:
    """A sentence where a step of rolling is so short for its law that it may have several
    solutions.

    With ``k = -f'(0) pz`` by the shift of unit slip, tractions of slipping elements change by ``dp
    <= k dE`` and their shift by ``dE = A dp - C dp'``: a step is unique, and what the step before
    left decays, as long as A < 1/k.
    """
    law = _law(disc)
    if not law.continuous or disc.step is None:
        return ""
    shift, areas = shift_and_areas(disc, state)
    dq = disc.step * disc.scales.length
    memory = law.memory_distance
    steepest = -float(law.slope(0.0)) or np.inf
    if law.local and memory == 0:
        own, rest = _own(disc, state, np.full(disc.grid.shape, SMALL_SLIP))
        steepest = float(np.max(rest - own)) / SMALL_SLIP
    by_memory = np.inf
    if memory > 0:
        by_memory = (law.static - law.kinetic) * dq / memory
    fall = min(steepest, by_memory) / unit_slip(disc) * state.pressure
    direction = shift / np.maximum(np.hypot(*shift), np.finfo(float).tiny)
    along = np.where(areas == SLIP, np.sqrt(fall) * direction, 0.0)
    weights = np.ones(disc.grid.shape)
    ratio = 0.0
    if not along.any():
        return ""
    for _ in range(POWER_STEPS):
        image = np.sum(along * disc.tangential_operator.apply(along * weights), axis=0)
        ratio = float(np.linalg.norm(image) / np.linalg.norm(weights))
        weights = image / np.abs(image).max()
    if ratio <= 1:
        return ""
    below = f"dq of about {ratio * dq:.2g}"
    if by_memory < steepest:
        below = f"a memory distance of about {ratio * memory:.2g}"
    return (
        f"friction falls fast with slip for so short a step: below {below} particles may "
        "stick and slip in turn, so that forces swing and depend on the start; take longer steps, "
        "a slower fall, a longer memory or steady rolling"
    )


def _law(disc: Discretisation) -> Law:
    assert disc.loading.law is not None
    return disc.loading.law


def _own(
    disc: Discretisation, state: ContactState, slip: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """The coefficients of a law at the temperatures, pressures and places of a state, with sizes of
    slip and without.

    In a history particles bring heat of earlier steps along.
    """
    law = _law(disc)
    temperature = _temperature(disc, state) if law.warm else None
    around = (
        temperature,
        state.pressure * disc.scales.pressure,
        *np.meshgrid(disc.grid.x, disc.grid.y),
    )
    own = law.on(slip, *around)
    if law.local:
        return own, law.on(0.0 * slip, *around)
    return own, np.full(slip.shape, law.static)


def _temperature(disc: Discretisation, state: ContactState) -> np.ndarray:
    """Temperatures (ny, nx) of the surface at the friction work of a state."""
    motion = disc.loading.motion
    thermal = disc.loading.thermal
    before = disc.loading.previous_step
    dx = disc.grid.sides[0]
    assert thermal is not None
    shift, _ = shift_and_areas(disc, state)
    density = friction_work(disc, state, shift) * disc.scales.pressure / unit_slip(disc)
    contact = state.pressure > 0
    if isinstance(motion, Steady):
        assert motion.speed is not None
        power = density * motion.speed
        return surface_temperatures(power, contact, dx, motion.speed, thermal)[0]
    assert isinstance(motion, TimeStep)
    rise = temperature_rise([Heat.of(density, contact, motion)], dx, thermal)
    if before is not None and RISE in before.arrived:
        rise = rise + before.arrived[RISE]
    return rise + background(1.0, thermal)[0]


def _with_memory(
    disc: Discretisation, state: ContactState, own: np.ndarray, rest: np.ndarray, slip: np.ndarray
) -> np.ndarray:
    """The coefficients of particles after a slip, with what they had a step ago; `own` of the law,
    `rest` in stick.

    In steady rolling they come along their rows, at rest at first. In a step that rolls they are
    `carried_coefficients`: short steps would have several solutions under the slip at their end.
    """
    law = _law(disc)
    motion = disc.loading.motion
    before = disc.loading.previous_step
    assert motion is not None
    remembers = (state.pressure > 0) | (not law.local)
    if disc.loading.steady:
        columns = range(slip.shape[1])
        if motion.rolls > 0:
            columns = columns[::-1]
        along = rest.copy()
        coefficients = along[:, columns[0]]
        for i in columns:
            after = law.after(coefficients, own[:, i], slip[:, i], disc.grid.sides[0])
            coefficients = along[:, i] = np.where(remembers[:, i], after, rest[:, i])
        return along
    carried = rest
    if before is not None:
        carried = before.arrived.get(FRICTION, rest)
    if not motion.rolls:
        carried = law.after(carried, own, slip, 1.0)
    return np.where(remembers, carried, rest)


def _of_slip(law: Law, solution: Solution) -> np.ndarray:
    """The coefficients of a solution where it slips, the static one where it sticks."""
    if not law.continuous:
        return np.where(solution.state == SLIP, law.kinetic, law.static)
    pressure = np.where(solution.pressure > 0, solution.pressure, np.inf)
    ratio = np.clip(np.hypot(*solution.traction) / pressure, law.kinetic, law.static)
    return np.where(solution.state == SLIP, ratio, law.static)


def _coefficients(law: Law, solution: Solution) -> tuple[np.ndarray, np.ndarray]:
    """Coefficients of the particles that slip, static elsewhere; and with those that particles in
    stick had before.
    """
    of_slip = _of_slip(law, solution)
    if solution.weakening is None:
        return of_slip, of_slip
    own = law.static - solution.weakening * (law.static - law.kinetic)
    slipping = solution.state != STICK
    if law.local:
        slipping = solution.state == SLIP
    return of_slip, np.where(slipping, of_slip, own)


def _passed(disc: Discretisation) -> tuple[int, float]:
    """Elements that particles pass in a step, and the weight of the next one at the point that they
    come from.

    A displacement at a point between two centres is the sum of those at the centres, with weights
    that are exact for tractions on these two elements.
    """
    if disc.step is None:
        return 0, 0.0
    dx = disc.lattice.sides[0]
    whole, rest = divmod(round(disc.step / dx, 9), 1.0)
    if rest == 0:
        return int(whole), 0.0
    two_elements = replace(disc.lattice, nx=2, ny=None if disc.grid.line else 1)
    pair = Operators(two_elements, disc.operators.medium)
    at_centres = pair.tangential()
    between = pair.carrying(rest * dx)
    _, own, other = np.mean([at_centres.table[i, i, 0] for i in (0, 1)], axis=0)
    beyond, near, _ = np.mean([between.table[i, i, 0] for i in (0, 1)], axis=0)
    return int(whole), float((beyond * own - near * other) / ((near + beyond) * (own - other)))
