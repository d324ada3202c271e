"""Friction laws: coefficients that follow from slip, temperature, pressure and place (paper, 1.7).

A pass takes the coefficients as they are; then each element that slips has the
coefficient of its slip. An element that sticks keeps its own: where
``|p| <= f pz`` and nothing slips, any larger coefficient has the same
tractions, the static one too.

The less friction, the more slip, and the less friction: solutions may be
several. From stick all over (the static coefficient) the passes come down to
one with much friction, from slip all over (the kinetic one) they rise to one
with little. With a static and a kinetic coefficient an element changes from
static to kinetic once and for all, so that the passes are no more than there
are elements; and the solution for the kinetic one alone is always one of the
solutions.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Self

import numpy as np

from varcontact.interfaces.coulomb import friction_bound
from varcontact.interfaces.heat import TEMPERATURE, TEMPERATURE_BEFORE
from varcontact.interfaces.interface import (
    FROM_ONE_SIDE,
    JUMPS,
    BetweenBodies,
    Fields,
    Interface,
    Quantity,
    Response,
    Start,
    StepBefore,
    Surroundings,
)
from varcontact.interfaces.potential import Potential, magnitude, project
from varcontact.scene.friction import Law
from varcontact.scene.grid import Grid
from varcontact.scene.motion import TimeStep
from varcontact.scene.units import Scales
from varcontact.transports import Transport, further_along

FRICTION = "friction"
"""Coefficients of friction in the contact."""
WEAKENING = "weakening"
"""Part of ``static - kinetic`` that particles have lost by slip."""
OWN_BEFORE = "friction_before"
"""Coefficients of the particles at the end of the previous step, at their places then."""

POWER_STEPS = 15
"""Power iterations for the largest eigenvalue: accurate to a few per cent."""
SMALL_SLIP = 1e-6
"""Relative slip over which the slope at zero slip is taken for laws known by their values only."""


@dataclass(frozen=True, eq=False)
class FrictionByLaw(Interface):
    """Law of friction on a grid, with the coefficients of the present pass, or the static
    coefficient where slip is not yet known.
    """

    law: Law
    grid: Grid
    scales: Scales
    remembers: bool
    by_slip = True

    @classmethod
    def between(cls, bodies: BetweenBodies) -> Self:
        """The law of a scene."""
        law = bodies.friction
        assert isinstance(law, Law)
        remembers = isinstance(bodies.motion, TimeStep) or law.memory_distance > 0
        return cls(law, bodies.grid, bodies.scales, remembers)

    @property
    def needs(self) -> tuple[str, ...]:
        if self.law.warm:
            return (TEMPERATURE,)
        return ()

    @property
    def carried(self) -> tuple[Quantity, ...]:
        if not self.remembers:
            return ()
        words = "part of static - kinetic friction that particles have lost by slip"
        return (Quantity(WEAKENING, "1", 0.0, words),)

    def implicit(self, transport: Transport) -> tuple[Quantity, ...]:
        law = self.law
        passes = JUMPS
        if law.continuous:
            passes = FROM_ONE_SIDE
        least = law.kinetic
        most = law.static
        return (Quantity(FRICTION, "1", most, least=least, most=most, passes=passes),)

    def coefficient(self, at: Surroundings) -> float | np.ndarray:
        return at.implicit.get(FRICTION, self.law.static)

    def potential(self, pressure: np.ndarray, at: Surroundings) -> Potential:
        return Potential(friction_bound(self.coefficient(at), pressure))

    def first(self, start: Start, at: Surroundings, shape: tuple[int, int]) -> Fields:
        """Coefficients of the first pass: those of another solution, those that have arrived, or
        those of stick or slip everywhere.
        """
        if isinstance(start, StepBefore):
            return {FRICTION: self._of_slip(start)}
        if start is None and FRICTION in at.arrived:
            return {FRICTION: at.arrived[FRICTION]}
        coefficient = self.law.static
        if start == "slip":
            coefficient = self.law.kinetic
        return {FRICTION: np.full(shape, coefficient)}

    def after(self, response: Response, at: Surroundings) -> Fields:
        """Coefficients by the law in the slip area of a pass, elsewhere those of the pass; a local
        law holds everywhere, and with a memory particles have their own.
        """
        own, rest = self._own(response, response.slip, at)
        if self.law.memory_distance > 0:
            return {FRICTION: self._with_memory(response, own, rest, at)}
        if self.law.local:
            return {FRICTION: own}
        return {FRICTION: np.where(response.slips, own, at.implicit[FRICTION])}

    def implied(self, response: Response, at: Surroundings) -> Fields:
        """Coefficient of the law at the slip of a response, whatever its origin; the static one
        where it sticks.

        An element slips where its traction is nearer to the law's at its shift than its shift is to
        none; and where it would slip even under the static coefficient: then that is not what it
        should have.
        """
        if self.law.memory_distance > 0:
            found = response.fields.get(FRICTION, at.implicit.get(FRICTION))
            if found is None:
                found = np.asarray(self.law.static)
            under_own = response.under({FRICTION: found})
            own, rest = self._own(under_own, under_own.slip, at)
            return {FRICTION: self._with_memory(under_own, own, rest, at)}
        shift = response.slip_shift
        change = shift / response.own_influence
        own, static = self._own(response, np.hypot(*shift) / response.unit_slip, at)
        trial = (response.traction - change).reshape(2, -1)
        static_bound = (static * response.pressure).ravel()
        size = magnitude(trial)
        beyond = size > static_bound * (1 + 1e-8) + 1e-12 * size.max()
        projected = project(trial, (own * response.pressure).ravel())
        off_law = magnitude(response.traction.reshape(2, -1) - projected)
        nearer = off_law < magnitude(change.reshape(2, -1))
        return {FRICTION: np.where((beyond | nearer).reshape(own.shape), own, static)}

    def leave(self, response: Response, at: Surroundings) -> Fields:
        """The part of ``static - kinetic`` that particles have lost, in [0, 1], under the implied
        coefficients.

        Without a memory those that slip have lost that of their slip. An element that sticks
        forgets as other particles fill it, and at once where nothing rolls.
        """
        law = self.law
        if not self.remembers:
            return {}
        left = np.broadcast_to(at.implicit[FRICTION], response.pressure.shape)
        if law.memory_distance == 0 and not law.local:
            left = self._of_slip(response)
            whole, part = at.passed()
            if OWN_BEFORE in at.arrived and whole == 0 and part > 0:
                filled = (1 - part) * at.arrived[OWN_BEFORE] + part * law.static
                left = np.where(response.sticks, filled, left)
        span = max(law.static - law.kinetic, np.finfo(float).tiny)
        return {WEAKENING: np.clip((law.static - left) / span, 0.0, 1.0)}

    def arrive(self, before: StepBefore, at: Surroundings) -> Fields:
        """The coefficients that particles bring along into a step of a history.

        Slipping particles keep that of their slip; those from between two centres have the
        coefficients there, weighted as displacements are. With a memory they slide on the way as
        others at the same place did in the step before.
        """
        law = self.law
        # the coefficients at the place where particles come from
        of_slip, own_before = self._of_particles(before)
        whole, part = at.passed()
        if law.memory_distance > 0:
            of_slip = own_before
        fresh: float | None = law.static
        if law.local:
            fresh = None
        forward = np.sign(at.transport.distance)
        nearest = of_slip
        if whole == 0:
            nearest = own_before
        arrived = further_along(nearest, forward * whole, fresh)
        if part != 0:
            next_one = further_along(of_slip, forward * (whole + 1), fresh)
            arrived = (1 - part) * arrived + part * next_one
        # coefficients after sliding over the step
        if law.memory_distance > 0 and at.transport.distance != 0:
            places = np.meshgrid(self.grid.x, self.grid.y)
            temperature = at.arrived.get(TEMPERATURE_BEFORE)
            pressure = before.pressure * self.scales.pressure
            own = law.on(before.slip, temperature, pressure, *places)
            rolled = abs(at.transport.distance) * self.scales.length
            arrived = law.after(arrived, own, before.slip, rolled)
        return {FRICTION: arrived, OWN_BEFORE: own_before}

    def warnings(self, response: Response, at: Surroundings) -> tuple[str, ...]:
        """A sentence where a step of rolling is so short for the law that it may have several
        solutions.

        With ``k = -f'(0) pz`` by the shift of unit slip, tractions of slipping elements change by
        ``dp <= k dE`` and their shift by ``dE = A dp - C dp'``: a step is unique, and what the step
        before left decays, as long as A < 1/k.
        """
        law = self.law
        if not law.continuous or at.transport.distance == 0:
            return ()
        dq = abs(at.transport.distance) * self.scales.length
        memory = law.memory_distance
        steepest = -float(law.slope(0.0)) or np.inf
        if law.local and memory == 0:
            own, rest = self._own(response, np.full(self.grid.shape, SMALL_SLIP), at)
            steepest = float(np.max(rest - own)) / SMALL_SLIP
        by_memory = np.inf
        if memory > 0:
            by_memory = (law.static - law.kinetic) * dq / memory
        ratio = _growth(response, min(steepest, by_memory))
        if ratio <= 1:
            return ()
        below = f"dq of about {ratio * dq:.2g}"
        if by_memory < steepest:
            below = f"a memory distance of about {ratio * memory:.2g}"
        return (
            f"friction falls fast with slip for so short a step: below {below} particles may "
            "stick and slip in turn, so that forces swing and depend on the start; take longer "
            "steps, a slower fall, a longer memory or steady rolling",
        )

    def _own(
        self, response: Response, slip: np.ndarray, at: Surroundings
    ) -> tuple[np.ndarray, np.ndarray]:
        """Coefficients by the law at the temperatures, pressures and places of a response, for its
        slip and for zero slip.
        """
        law = self.law
        around = (
            at.implicit.get(TEMPERATURE),
            response.pressure * self.scales.pressure,
            *np.meshgrid(self.grid.x, self.grid.y),
        )
        own = law.on(slip, *around)
        if law.local:
            return own, law.on(0.0 * slip, *around)
        return own, np.full(slip.shape, law.static)

    def _with_memory(
        self, response: Response, own: np.ndarray, rest: np.ndarray, at: Surroundings
    ) -> np.ndarray:
        """Coefficients of particles after their slip, from those of a step ago; `own` are those of
        the law, `rest` those in stick.

        In steady rolling they come along their rows, at rest at first. In a step that rolls they
        have those that have arrived: short steps would have several solutions under the slip at
        their end.
        """
        law = self.law
        slip = response.slip
        remembers = (response.pressure > 0) | (not law.local)
        if at.transport.repeats:
            columns = range(slip.shape[1])
            if at.transport.distance > 0:
                columns = columns[::-1]
            along = rest.copy()
            coefficients = along[:, columns[0]]
            for i in columns:
                after = law.after(coefficients, own[:, i], slip[:, i], self.grid.sides[0])
                coefficients = along[:, i] = np.where(remembers[:, i], after, rest[:, i])
            return along
        arrived = at.arrived.get(FRICTION, rest)
        if at.transport.distance == 0:
            arrived = law.after(arrived, own, slip, 1.0)
        return np.where(remembers, arrived, rest)

    def _of_slip(self, contact: Response | StepBefore) -> np.ndarray:
        """Coefficients of a contact in its slip area, the static one in its stick area."""
        law = self.law
        if not law.continuous:
            return np.where(contact.slips, law.kinetic, law.static)
        pressure = np.where(contact.pressure > 0, contact.pressure, np.inf)
        ratio = np.clip(np.hypot(*contact.traction) / pressure, law.kinetic, law.static)
        return np.where(contact.slips, ratio, law.static)

    def _of_particles(self, before: StepBefore) -> tuple[np.ndarray, np.ndarray]:
        """Coefficients of slipping particles, static elsewhere; and the same with the earlier
        coefficients of sticking particles.
        """
        law = self.law
        of_slip = self._of_slip(before)
        if WEAKENING not in before.carried:
            return of_slip, of_slip
        own = law.static - before.carried[WEAKENING] * (law.static - law.kinetic)
        slipping = ~before.sticks
        if law.local:
            slipping = before.slips
        return of_slip, np.where(slipping, of_slip, own)


def _growth(response: Response, steepest: float) -> float:
    """Largest eigenvalue of the feedback from slip to slip, through coefficients that fall with
    slip at the slope `steepest`.
    """
    fall = steepest / response.unit_slip * response.pressure
    shift = response.slip_shift
    direction = shift / np.maximum(np.hypot(*shift), np.finfo(float).tiny)
    along = np.where(response.slips, np.sqrt(fall) * direction, 0.0)
    if not along.any():
        return 0.0
    weights = np.ones(response.pressure.shape)
    ratio = 0.0
    for _ in range(POWER_STEPS):
        image = np.sum(along * response.elastic_shift(along * weights), axis=0)
        ratio = float(np.linalg.norm(image) / np.linalg.norm(weights))
        weights = image / np.abs(image).max()
    return ratio
