"""Temperature of the surfaces by frictional heat, which flows straight into bodies that pass fast.

Both bodies pass the contact at the same speed: they share the heat by their
effusivities, and have one temperature. Source: M. Ertz, K. Knothe, Wear 253
(2002) 498-508. Exact for ``V a/(2 kappa) >> 1``, 1e4 of a wheel on a rail.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Self

import numpy as np

from varcontact.interfaces.interface import (
    BetweenBodies,
    Fields,
    Interface,
    Response,
    StepBefore,
    Surroundings,
)
from varcontact.interfaces.potential import Potential
from varcontact.scene.interface import Thermal
from varcontact.scene.motion import Steady, TimeStep
from varcontact.scene.scene import Scene
from varcontact.scene.units import Scales
from varcontact.transports import further_along

TEMPERATURE = "temperature"
RISE = "temperature_rise"
"""Temperature rise of particles at the end of a step, due to the heat of earlier steps."""
TEMPERATURE_BEFORE = "temperature_before"
"""Temperature at the end of the step before, not moved along with the particles."""


@dataclass(frozen=True, eq=False)
class FrictionalHeat(Interface):
    """Temperature of the surfaces due to frictional heat, which other interfaces may read."""

    bodies: tuple[Thermal, Thermal]
    motion: Steady | TimeStep
    dx: float
    scales: Scales
    unbounded = True
    by_slip = True

    @classmethod
    def between(cls, bodies: BetweenBodies) -> Self | None:
        """The heat of a scene with thermal data, in a motion that takes time."""
        thermal = bodies.scene.thermal
        motion = bodies.motion
        assert thermal is not None
        rolls_in_time = isinstance(motion, Steady) and motion.speed is not None
        takes_time = isinstance(motion, TimeStep) and motion.dt is not None
        if not (rolls_in_time or takes_time):
            return None
        assert isinstance(motion, Steady | TimeStep)
        return cls(thermal, motion, bodies.grid.sides[0], bodies.scales)

    @property
    def gives(self) -> tuple[str, ...]:
        return (TEMPERATURE,)

    def potential(self, pressure: np.ndarray, at: Surroundings) -> Potential:
        return Potential(np.full(pressure.shape, np.inf))

    def implied(self, response: Response, at: Surroundings) -> Fields:
        """Temperature due to the friction work of a response; in a history also due to heat that
        particles carry.
        """
        density = response.work() * self.scales.pressure / response.unit_slip
        contact = response.pressure > 0
        motion = self.motion
        if isinstance(motion, Steady):
            assert motion.speed is not None
            power = density * motion.speed
            found = surface_temperatures(power, contact, self.dx, motion.speed, self.bodies)
            return {TEMPERATURE: found[0]}
        rise = temperature_rise([Heat.of(density, contact, motion)], self.dx, self.bodies)
        if RISE in at.arrived:
            rise = rise + at.arrived[RISE]
        return {TEMPERATURE: rise + background(1.0, self.bodies)[0]}

    def arrive(self, before: StepBefore, at: Surroundings) -> Fields:
        """Temperature at the end of the last step, and temperature rise at the end of this one,
        both due to the heat of all steps so far; nothing before the first heat.
        """
        if not before.heat:
            return {}
        assert isinstance(self.motion, TimeStep)
        last = temperature_rise(before.heat, self.dx, self.bodies)
        nothing = np.zeros(before.pressure.shape)
        path = [*before.heat, Heat.of(nothing, nothing > 0, self.motion)]
        return {
            TEMPERATURE_BEFORE: last + background(1.0, self.bodies)[0],
            RISE: temperature_rise(path, self.dx, self.bodies),
        }


@dataclass(frozen=True, eq=False)
class Heat:
    """Frictional heat in a step, per area and time, and the contact area, (ny, nx)."""

    power: np.ndarray
    contact: np.ndarray
    time: float
    rolled: float  # negative backwards

    @classmethod
    def of(cls, power_density: np.ndarray, contact: np.ndarray, step: TimeStep) -> Heat:
        """Heat of a power density: work per area and distance rolled, or of a step in place."""
        assert step.dt is not None
        power = power_density * ((step.dq or 1.0) / step.dt)
        return cls(power, contact, step.dt, step.rolls * step.dq)


def heating(scene: Scene, density: np.ndarray) -> np.ndarray:
    """Density of frictional work that heats the surfaces: zero under infinite friction, although
    energy is then lost at edges.
    """
    return density * (not scene.no_slip)


def temperature_rise(
    path: Sequence[Heat], dx: float, bodies: tuple[Thermal, Thermal]
) -> np.ndarray:
    """Rise of temperature by the heat of a history's steps, at the end of the last, (ny, nx).

    ``int q(t') dt'/sqrt(t - t') / ((beta_1 + beta_2) sqrt(pi))`` on the way of each particle, with
    heat that is linear between the elements' centres.
    """
    rise = np.zeros_like(path[-1].power)
    for heat, (now, then), (near, far) in _pieces(path, dx):
        if not heat.power.any() or min(abs(near), abs(far)) > rise.shape[1]:
            continue
        # heat q = q0 + slope t at the time t before the end
        last = further_along(heat.power, near)
        first = further_along(heat.power, far)
        slope = (first - last) / (then - now)
        constant_part = 2 * (last - slope * now) * (math.sqrt(then) - math.sqrt(now))
        linear_part = 2 / 3 * slope * (then**1.5 - now**1.5)
        rise += constant_part + linear_part
    return rise / (math.sqrt(math.pi) * sum(body.effusivity for body in bodies))


def temperatures_in_time(
    path: Sequence[Heat], dx: float, bodies: tuple[Thermal, Thermal]
) -> np.ndarray:
    """Temperatures (2, ny, nx) of both surfaces at the end of the last step of a history.

    A particle that has left the contact goes back to the temperature of its body by the times it
    was inside, and since it entered.
    """
    # times in contact, and since the particle entered it
    inside, since = np.zeros((2, *path[-1].contact.shape))
    for heat, (now, then), (near, far) in _pieces(path, dx):
        last = further_along(1.0 * heat.contact, near)
        first = further_along(1.0 * heat.contact, far)
        # part of the piece in which the particle is more in contact than out of it
        change = np.abs(first - last)
        excess = np.maximum(first, last) - 0.5
        part = np.clip(excess / np.where(change > 0, change, 1e-9), 0.0, 1.0)
        inside += part * (then - now)
        entered = np.where(first >= 0.5, then, now + part * (then - now))
        since = np.where(part > 0, entered, since)
    part = np.where(path[-1].contact, 1.0, inside / np.where(since > 0, since, 1.0))
    without_friction = background(2 / math.pi * np.arcsin(np.sqrt(part)), bodies)
    return temperature_rise(path, dx, bodies) + without_friction


def _pieces(
    path: Sequence[Heat], dx: float
) -> Iterator[tuple[Heat, tuple[float, float], tuple[float, float]]]:
    """The steps from the last one back, in pieces in which each particle is between the same two
    centres.

    With the times, and the numbers of columns ahead, at which a piece ends and begins.
    """
    now = near = 0.0
    for heat in reversed(path):
        far = round(near + heat.rolled / dx, 9)
        low, high = sorted((near, far))
        centres = np.arange(math.floor(low) + 1, math.ceil(high), dtype=float)
        if near >= far:
            centres = centres[::-1]
        for start, end in pairwise([near, *centres, far]):
            part = 1.0
            if high > low:
                part = abs(end - start) / (high - low)
            then = now + heat.time * part
            yield heat, (now, then), (start, end)
            now = then
        near = far


def surface_temperatures(
    heat: np.ndarray, contact: np.ndarray, dx: float, speed: float, bodies: tuple[Thermal, Thermal]
) -> np.ndarray:
    """Temperatures (2, ny, nx) of both surfaces in steady rolling, from the heat per area and
    time (ny, nx).

    ``T_mean + int q(x') dx'/sqrt(x' - x) / ((beta_1 + beta_2) sqrt(pi V))`` over what lies ahead,
    with heat that is linear between the elements' centres; behind the contact each body goes back
    to its own temperature.
    """
    # rise by friction: weights of column i on column j
    nx = heat.shape[1]
    k = np.arange(nx, dtype=float)
    weights = (k + 1) ** 1.5 - 2 * k**1.5 + np.abs(k - 1) ** 1.5
    weights[0] = 1.0
    ahead = np.tril(4 / 3 * math.sqrt(dx) * weights[np.abs(k[:, None] - k).astype(int)])
    effusivity = sum(body.effusivity for body in bodies)
    rise = heat @ ahead / (effusivity * math.sqrt(math.pi * speed))
    # columns from the leading edge, and the width of the contact
    last = nx - 1 - np.argmax(contact[:, ::-1], axis=1)[:, None]
    width = last + 1 - np.argmax(contact, axis=1)[:, None]
    passed = last + 0.5 - k
    # temperature without friction: common in the contact, behind it back to each body's own
    behind = 2 / math.pi * np.arcsin(np.sqrt(width / np.maximum(passed, width)))
    since = np.where(passed > width, behind, 1.0)
    since = np.where(contact.any(axis=1, keepdims=True) & (passed > 0), since, 0.0)
    return rise + background(since, bodies)


def background(since: np.ndarray | float, bodies: tuple[Thermal, Thermal]) -> np.ndarray:
    """Temperatures (2, ...) without friction: in contact (1) the mean weighted by effusivities,
    elsewhere a part of the way to it.
    """
    upper, lower = bodies
    weighted = upper.effusivity * upper.temperature + lower.effusivity * lower.temperature
    mean = weighted / (upper.effusivity + lower.effusivity)
    return np.array([body.temperature + (mean - body.temperature) * since for body in bodies])
