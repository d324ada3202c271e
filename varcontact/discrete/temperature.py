"""Temperature of the surfaces by frictional heat, which flows straight into bodies that pass fast.

Both bodies pass the contact at the same speed: they share the heat by their effusivities, and have one temperature.
Source: M. Ertz, K. Knothe, Wear 253 (2002) 498-508. Exact for ``V a/(2 kappa) >> 1``, 1e4 of a wheel on a rail.
"""

from __future__ import annotations

import math

import numpy as np

from varcontact.scene.interface import Thermal


def surface_temperatures(
    heat: np.ndarray, contact: np.ndarray, dx: float, speed: float, bodies: tuple[Thermal, Thermal]
) -> np.ndarray:
    """Temperatures (2, ny, nx) of both surfaces in steady rolling, from the heat by area and time (ny, nx).

    ``T_mean + int q(x') dx'/sqrt(x' - x) / ((beta_1 + beta_2) sqrt(pi V))`` over what lies ahead, with heat that is
    linear between the elements' centres; behind the contact each body goes back to its own temperature.
    """
    nx, together = heat.shape[1], sum(body.effusivity for body in bodies)
    k = np.arange(nx, dtype=float)
    weights = (k + 1) ** 1.5 - 2 * k**1.5 + np.abs(k - 1) ** 1.5
    weights[0] = 1.0
    ahead = np.tril(4 / 3 * math.sqrt(dx) * weights[np.abs(k[:, None] - k).astype(int)])  # from column i on column j
    rise = heat @ ahead / (together * math.sqrt(math.pi * speed))
    last = nx - 1 - np.argmax(contact[:, ::-1], axis=1)[:, None]
    width = last + 1 - np.argmax(contact, axis=1)[:, None]
    passed = last + 0.5 - k
    since = np.where(passed > width, 2 / math.pi * np.arcsin(np.sqrt(width / np.maximum(passed, width))), 1.0)
    return rise + background(np.where(contact.any(axis=1, keepdims=True) & (passed > 0), since, 0.0), bodies)


def background(since: np.ndarray, bodies: tuple[Thermal, Thermal]) -> np.ndarray:
    """Temperatures (2, ny, nx) without friction: in contact (1) the mean by effusivities, else a part of the way."""
    one, other = bodies
    together = one.effusivity + other.effusivity
    mean = (one.effusivity * one.temperature + other.effusivity * other.temperature) / together
    return np.array([body.temperature + (mean - body.temperature) * since for body in bodies])
