"""Coulomb's friction: tractions within a coefficient times the pressure."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from varcontact.interfaces.interface import Interface, Quantity, Surroundings
from varcontact.interfaces.potential import Potential
from varcontact.scene.friction import FrictionBound, Law
from varcontact.scene.units import Scales
from varcontact.transports import Transport

FRICTION = "friction"


@dataclass(frozen=True, eq=False)
class Coulomb(Interface):
    """A coefficient for all elements, or one for each, (ny, nx); infinite: no slip."""

    coefficient: float | np.ndarray

    def potential(self, pressure: np.ndarray, at: Surroundings) -> Potential:
        return Potential(friction_bound(self.coefficient, pressure))


@dataclass(frozen=True, eq=False)
class FrictionLaw(Interface):
    """A law of friction: the coefficients of this pass, or where nothing is known of slip the
    static one.
    """

    law: Law

    def implicit(self, transport: Transport) -> tuple[Quantity, ...]:
        return (Quantity(FRICTION, "coefficient", self.law.static),)

    def potential(self, pressure: np.ndarray, at: Surroundings) -> Potential:
        return Potential(friction_bound(at.implicit.get(FRICTION, self.law.static), pressure))


@dataclass(frozen=True, eq=False)
class BoundByPressure(Interface):
    """A traction bound of a scene, known by pressure and place (ny, nx)."""

    friction: FrictionBound
    scales: Scales
    x: np.ndarray
    y: np.ndarray

    def potential(self, pressure: np.ndarray, at: Surroundings) -> Potential:
        bound = self.friction.bound(pressure * self.scales.pressure, self.x, self.y)
        return Potential(np.asarray(bound / self.scales.pressure))


def friction_bound(coefficient: float | np.ndarray, pressure: np.ndarray) -> np.ndarray:
    """The traction bound of a coefficient under a pressure (ny, nx)."""
    with np.errstate(invalid="ignore"):  # inf * 0 outside the contact
        return np.broadcast_to(np.asarray(coefficient), pressure.shape) * np.maximum(pressure, 0.0)
