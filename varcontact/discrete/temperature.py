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

import numpy as np

from varcontact.scene.interface import Thermal
from varcontact.scene.motion import TimeStep
from varcontact.transports import further_along

RISE = "temperature_rise"
"""How much warmer particles are at the end of a step by what heated them before."""


@dataclass(frozen=True, eq=False)
class Heat:
    """What friction heats in a step, by area and time, and where it touches, (ny, nx)."""

    power: np.ndarray
    contact: np.ndarray
    time: float
    rolled: float  # negative backwards

    @classmethod
    def of(cls, power_density: np.ndarray, contact: np.ndarray, step: TimeStep) -> Heat:
        """That of a power density: work by area and distance rolled, in a step in place by area."""
        assert step.dt is not None
        return cls(
            power_density * ((step.dq or 1.0) / step.dt), contact, step.dt, step.rolls * step.dq
        )


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
        last, first = further_along(heat.power, near), further_along(heat.power, far)
        fall = (first - last) / (then - now)
        rise += 2 * (last - fall * now) * (math.sqrt(then) - math.sqrt(now)) + 2 / 3 * fall * (
            then**1.5 - now**1.5
        )
    return rise / (math.sqrt(math.pi) * sum(body.effusivity for body in bodies))


def temperatures_in_time(
    path: Sequence[Heat], dx: float, bodies: tuple[Thermal, Thermal]
) -> np.ndarray:
    """Temperatures (2, ny, nx) of both surfaces at the end of the last step of a history.

    A particle that has left the contact goes back to the temperature of its body by the times it
    was inside, and since it entered.
    """
    inside, since = np.zeros((2, *path[-1].contact.shape))
    for heat, (now, then), (near, far) in _pieces(path, dx):
        last, first = (
            further_along(1.0 * heat.contact, near),
            further_along(1.0 * heat.contact, far),
        )
        change = np.abs(first - last)
        part = np.clip(
            (np.maximum(first, last) - 0.5) / np.where(change > 0, change, 1e-9), 0.0, 1.0
        )
        inside += part * (then - now)
        entered = np.where(first >= 0.5, then, now + part * (then - now))
        since = np.where(part > 0, entered, since)
    part = np.where(path[-1].contact, 1.0, inside / np.where(since > 0, since, 1.0))
    return temperature_rise(path, dx, bodies) + background(
        2 / math.pi * np.arcsin(np.sqrt(part)), bodies
    )


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
        inner = np.arange(math.floor(low) + 1, math.ceil(high), dtype=float)
        stops = [near, *(inner if near < far else inner[::-1]), far]
        for one, other in pairwise(stops):
            then = now + heat.time * (abs(other - one) / (high - low) if high > low else 1.0)
            yield heat, (now, then), (one, other)
            now = then
        near = far


def surface_temperatures(
    heat: np.ndarray, contact: np.ndarray, dx: float, speed: float, bodies: tuple[Thermal, Thermal]
) -> np.ndarray:
    """Temperatures (2, ny, nx) of both surfaces in steady rolling, from the heat by area and time
    (ny, nx).

    ``T_mean + int q(x') dx'/sqrt(x' - x) / ((beta_1 + beta_2) sqrt(pi V))`` over what lies ahead,
    with heat that is linear between the elements' centres; behind the contact each body goes back
    to its own temperature.
    """
    nx, together = heat.shape[1], sum(body.effusivity for body in bodies)
    k = np.arange(nx, dtype=float)
    weights = (k + 1) ** 1.5 - 2 * k**1.5 + np.abs(k - 1) ** 1.5
    weights[0] = 1.0
    # from column i on column j
    ahead = np.tril(4 / 3 * math.sqrt(dx) * weights[np.abs(k[:, None] - k).astype(int)])
    rise = heat @ ahead / (together * math.sqrt(math.pi * speed))
    last = nx - 1 - np.argmax(contact[:, ::-1], axis=1)[:, None]
    width = last + 1 - np.argmax(contact, axis=1)[:, None]
    passed = last + 0.5 - k
    since = np.where(
        passed > width, 2 / math.pi * np.arcsin(np.sqrt(width / np.maximum(passed, width))), 1.0
    )
    return rise + background(
        np.where(contact.any(axis=1, keepdims=True) & (passed > 0), since, 0.0), bodies
    )


def background(since: np.ndarray | float, bodies: tuple[Thermal, Thermal]) -> np.ndarray:
    """Temperatures (2, ...) without friction: in contact (1) the mean by effusivities, else a part
    of the way.
    """
    one, other = bodies
    together = one.effusivity + other.effusivity
    mean = (one.effusivity * one.temperature + other.effusivity * other.temperature) / together
    return np.array([body.temperature + (mean - body.temperature) * since for body in bodies])
