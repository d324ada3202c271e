"""Friction with a known bound: a coefficient times the pressure, or another function of pressure
and place.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Self

import numpy as np

from varcontact.interfaces.interface import BetweenBodies, Interface, Surroundings
from varcontact.interfaces.potential import Potential
from varcontact.scene.friction import FrictionBound, Law
from varcontact.scene.units import Scales
from varcontact.system.process import lazy_property


@dataclass(frozen=True, eq=False)
class Coulomb(Interface):
    """A coefficient for all elements, or one for each, (ny, nx); infinite: no slip."""

    ratio: float | np.ndarray

    @classmethod
    def between(cls, bodies: BetweenBodies) -> Self:
        """Coulomb friction with the coefficient of a scene, zero if it has none."""
        friction = bodies.friction
        assert not isinstance(friction, Law | FrictionBound)
        if friction is None:
            friction = 0.0
        return cls(friction)

    def coefficient(self, at: Surroundings) -> float | np.ndarray:
        return self.ratio

    @lazy_property
    def frictionless(self) -> bool:
        return not np.count_nonzero(self.ratio)

    @lazy_property
    def unbounded(self) -> bool:
        return isinstance(self.ratio, float) and math.isinf(self.ratio)

    def potential(self, pressure: np.ndarray, at: Surroundings) -> Potential:
        return Potential(friction_bound(self.ratio, pressure))


@dataclass(frozen=True, eq=False)
class BoundByPressure(Interface):
    """A traction bound of a scene, known by pressure and place (ny, nx)."""

    friction: FrictionBound
    scales: Scales
    x: np.ndarray
    y: np.ndarray

    @classmethod
    def between(cls, bodies: BetweenBodies) -> Self:
        """The bound of a scene on its grid."""
        friction = bodies.friction
        assert isinstance(friction, FrictionBound)
        return cls(friction, bodies.scales, *np.meshgrid(bodies.grid.x, bodies.grid.y))

    def potential(self, pressure: np.ndarray, at: Surroundings) -> Potential:
        bound = self.friction.bound(pressure * self.scales.pressure, self.x, self.y)
        return Potential(np.asarray(bound / self.scales.pressure))


def friction_bound(coefficient: float | np.ndarray, pressure: np.ndarray) -> np.ndarray:
    """The traction bound of a coefficient under a pressure (ny, nx)."""
    with np.errstate(invalid="ignore"):  # inf * 0 outside the contact
        return np.asarray(coefficient * np.maximum(pressure, 0.0))
