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
        friction = _known(law, start)
    else:
        friction = np.full(grid.shape, law.kinetic if start == "slip" else law.static)
    return replace(state.under(friction=friction), branch=branch_of(start))


def coefficients_after(disc: Discretisation, state: ContactState) -> np.ndarray:
    """The law's coefficients at the slip of a state, where it slips with those it had; elsewhere
    these.
    """
    assert state.friction is not None
    law, (shift, areas) = _law(disc), shift_and_areas(disc, state)
    slip = np.hypot(*shift) * (areas == SLIP) / unit_slip(disc)
    own, rest = _own(disc, state, slip)
    if law.memory_distance > 0:
        return _with_memory(disc, state, own, rest, slip)
    return own if law.local else np.where(areas == SLIP, own, state.friction)


def coefficient(disc: Discretisation, state: ContactState) -> np.ndarray:
    """The law's own coefficient (ny, nx) at the slip of a state from any source; the static one
    where it sticks.

    An element slips where its traction is nearer to the law's at its shift than its shift is to
    none; and where it would slip even under the static coefficient: then that is not what it should
    have.
    """
    law = _law(disc)
    if law.memory_distance > 0:
        known = disc.loading.coefficient if state.friction is None else state.friction
        shift, areas = shift_and_areas(disc.under(friction=np.asarray(known)), state)
        slip = np.hypot(*shift) * (areas == SLIP) / unit_slip(disc)
        return _with_memory(disc, state, *_own(disc, state, slip), slip)
    shift, _ = shift_and_areas(disc, replace(state, slips=None))
    moved = shift / own_influence(disc)
    own, static = _own(disc, state, np.hypot(*shift) / unit_slip(disc))
    trial = (state.traction - moved).reshape(2, -1)
    size = magnitude(moved.reshape(2, -1))
    beyond = (
        magnitude(trial)
        > (static * state.pressure).ravel() * (1 + 1e-8) + 1e-12 * magnitude(trial).max()
    )
    nearer = (
        magnitude(state.traction.reshape(2, -1) - project(trial, (own * state.pressure).ravel()))
        < size
    )
    return np.where((beyond | nearer).reshape(own.shape), own, static)


def branch_of(start: str | Solution | None) -> str:
    return "solution" if isinstance(start, Solution) else start or "stick"


def remembered(
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
    known, own = _coefficients(law, before)
    whole, part = _way(disc)
    if law.memory_distance > 0:
        known = own
    fresh = None if law.local else law.static
    near = further_along(own if whole == 0 else known, motion.rolls * whole, fresh)
    came = (
        near
        if part == 0
        else (1 - part) * near + part * further_along(known, motion.rolls * (whole + 1), fresh)
    )
    if law.memory_distance == 0 or disc.step is None:
        return came
    slip = np.where(before.state == SLIP, np.hypot(*before.slip), 0.0)
    temperature = None
    thermal = disc.loading.thermal
    if law.warm and thermal is not None:
        rise = (
            temperature_rise(heated, disc.grid.sides[0], thermal)
            if heated
            else np.zeros(disc.grid.shape)
        )
        temperature = rise + background(1.0, thermal)[0]
    there = law.on(slip, temperature, before.pressure, *np.meshgrid(disc.grid.x, disc.grid.y))
    return law.after(came, there, slip, disc.step * disc.scales.length)


def weakening(disc: Discretisation, before: Solution | None, solution: Solution) -> np.ndarray:
    """The part of ``static - kinetic`` that the particles have lost, (ny, nx) in [0, 1]; `disc` has
    the coefficients.

    Without a memory those that slip have lost that of their slip. An element that sticks forgets as
    other particles fill it, and at once where nothing rolls.
    """
    law = _law(disc)
    left = np.asarray(disc.loading.coefficient)
    if law.memory_distance == 0 and not law.local:
        left, (whole, part) = _known(law, solution), _way(disc)
        if before is not None and whole == 0 and part > 0:
            _, own = _coefficients(law, before)
            left = np.where(solution.state == STICK, (1 - part) * own + part * law.static, left)
    return np.clip(
        (law.static - left) / max(law.static - law.kinetic, np.finfo(float).tiny), 0.0, 1.0
    )


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
    by_memory = (law.static - law.kinetic) * dq / memory if memory > 0 else np.inf
    fall = min(steepest, by_memory) / unit_slip(disc) * state.pressure
    direction = shift / np.maximum(np.hypot(*shift), np.finfo(float).tiny)
    along = np.where(areas == SLIP, np.sqrt(fall) * direction, 0.0)
    weights = np.ones(disc.grid.shape)
    ratio = 0.0
    for _ in range(POWER_STEPS if along.any() else 0):
        image = np.sum(along * disc.tangential_operator.apply(along * weights), axis=0)
        ratio = float(np.linalg.norm(image) / np.linalg.norm(weights))
        weights = image / np.abs(image).max()
    if ratio <= 1:
        return ""
    short, least = ("a memory distance", memory) if by_memory < steepest else ("dq", dq)
    return (
        f"friction falls fast with slip for so short a step: below {short} of about {ratio * least:.2g} particles may "
        "stick and slip in turn, so that forces swing and depend on the start; take longer steps, a slower fall, a "
        "longer memory or steady rolling"
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
    motion = disc.loading.motion
    thermal = disc.loading.thermal
    temperature = None
    dx = disc.grid.sides[0]
    before = disc.loading.previous_step
    if law.warm:
        density = (
            friction_work(disc, state, shift_and_areas(disc, state)[0])
            * disc.scales.pressure
            / unit_slip(disc)
        )
        contact = state.pressure > 0
        if isinstance(motion, Steady):
            assert motion.speed is not None and thermal is not None
            temperature = surface_temperatures(
                density * motion.speed, contact, dx, motion.speed, thermal
            )[0]
        else:
            assert isinstance(motion, TimeStep) and thermal is not None
            rise = temperature_rise([Heat.of(density, contact, motion)], dx, thermal)
            known = None if before is None else before.arrived.get(RISE)
            temperature = (rise if known is None else rise + known) + background(1.0, thermal)[0]
    around = (
        temperature,
        state.pressure * disc.scales.pressure,
        *np.meshgrid(disc.grid.x, disc.grid.y),
    )
    return law.on(slip, *around), law.on(0.0 * slip, *around) if law.local else np.full(
        slip.shape, law.static
    )


def _with_memory(
    disc: Discretisation, state: ContactState, own: np.ndarray, rest: np.ndarray, slip: np.ndarray
) -> np.ndarray:
    """The coefficients of particles after a slip, with what they had a step ago; `own` of the law,
    `rest` in stick.

    In steady rolling they come along their rows, at rest at first. In a step that rolls they are
    `remembered`: problems of short steps would have several solutions under the slip at their end.
    """
    law = _law(disc)
    motion = disc.loading.motion
    before = disc.loading.previous_step
    assert motion is not None
    remembers = (state.pressure > 0) | (not law.local)
    if disc.loading.steady:
        found = rest.copy()
        known = found[:, -1 if motion.rolls > 0 else 0]
        for i in range(slip.shape[1])[:: -1 if motion.rolls > 0 else 1]:
            after = law.after(known, own[:, i], slip[:, i], disc.grid.sides[0])
            known = found[:, i] = np.where(remembers[:, i], after, rest[:, i])
        return found
    came = rest if before is None else before.arrived.get(FRICTION, rest)
    return np.where(remembers, came if motion.rolls else law.after(came, own, slip, 1.0), rest)


def _known(law: Law, solution: Solution) -> np.ndarray:
    """The coefficients of a solution where it slips, the static one where it sticks."""
    known = np.hypot(*solution.traction) / np.where(
        solution.pressure > 0, solution.pressure, np.inf
    )
    known = np.clip(known, law.kinetic, law.static) if law.continuous else law.kinetic
    return np.where(solution.state == SLIP, known, law.static)


def _coefficients(law: Law, solution: Solution) -> tuple[np.ndarray, np.ndarray]:
    """Those of the particles that slip, static elsewhere; and with what elements that stick
    remember.
    """
    known = _known(law, solution)
    if solution.weakening is None:
        return known, known
    own = law.static - solution.weakening * (law.static - law.kinetic)
    return known, np.where(
        solution.state == SLIP if law.local else solution.state != STICK, known, own
    )


def _way(disc: Discretisation) -> tuple[int, float]:
    """Elements that particles pass in a step, and the weight of the next one at the point from
    where they come.

    A displacement at a point between two centres is the sum of those at the centres, with weights
    that are exact for tractions on these two elements.
    """
    if disc.step is None:
        return 0, 0.0
    dx = disc.lattice.sides[0]
    whole, rest = divmod(round(disc.step / dx, 9), 1.0)
    if rest == 0:
        return int(whole), 0.0
    pair = Operators(
        replace(disc.lattice, nx=2, ny=None if disc.grid.line else 1), disc.operators.medium
    )
    at_centres, between = (
        np.mean([table.table[i, i, 0] for i in (0, 1)], axis=0)
        for table in (pair.tangential(), pair.carrying(rest * dx))
    )
    (_, own, other), (beyond, near, _) = at_centres, between
    return int(whole), float((beyond * own - near * other) / ((near + beyond) * (own - other)))
