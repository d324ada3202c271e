"""A layer between the bodies that yields: it flows along the traction, and hardens or softens as it
flows.

Its yield stress goes with the particles. Sources: Hou, Kalousek, Magel, Wear 211
(1997) 134-140; Vollebregt, Wear 314 (2014) 87-95. The elastic shear of the layer
belongs to the medium.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Self

import numpy as np

from varcontact.interfaces.interface import (
    BetweenBodies,
    Fields,
    Interface,
    Quantity,
    Response,
    Surroundings,
)
from varcontact.interfaces.potential import Flow, Potential
from varcontact.transports import Transport, along_rows

YIELD_STRESS = "yield_stress"
DISPLACEMENT = "plastic_displacement"


@dataclass(frozen=True)
class YieldingLayer(Interface):
    """A layer that yields, dimensionless: the stress of fresh material, and its change per plastic
    shift.

    With a positive `hardening` elements flow within the bound of friction. Otherwise the yield
    stress is a bound like that of friction, and the whole shift flows.
    """

    fresh_stress: float
    hardening: float
    flows = True

    @classmethod
    def between(cls, bodies: BetweenBodies) -> Self:
        """The layer of a scene that yields."""
        layer = bodies.scene.third_body
        scales = bodies.scales
        assert layer is not None
        hardening = layer.k_tau * scales.displacement / scales.pressure
        return cls(layer.tau_c0 / scales.pressure, hardening)

    @property
    def carried(self) -> tuple[Quantity, ...]:
        words = "plastic displacement of the layer between the bodies"
        displacement = Quantity(DISPLACEMENT, "length", 0.0, words, ("component", "y", "x"))
        return displacement, self._yield_stress

    @property
    def _yield_stress(self) -> Quantity:
        words = "yield stress of the layer between the bodies"
        return Quantity(YIELD_STRESS, "pressure", self.fresh_stress, words, least=0.0)

    def implicit(self, transport: Transport) -> tuple[Quantity, ...]:
        """Yield stress, where tractions change it within the step: by softening, or along rows in
        rolling.
        """
        hardens_along_rows = self.hardening > 0 and transport.repeats
        if self.hardening < 0 or hardens_along_rows:
            return (self._yield_stress,)
        return ()

    def potential(self, pressure: np.ndarray, at: Surroundings) -> Potential:
        stress = at.implicit.get(YIELD_STRESS)
        columns = 0.0
        if stress is None:
            stress = self._arrived_stress(pressure.shape, at)
            if at.transport.repeats:  # it follows from the tractions
                columns = at.transport.columns
        if self.hardening <= 0:
            return Potential(stress)
        return Potential(np.full(pressure.shape, np.inf), Flow(stress, self.hardening, columns))

    def slip_bound(self, pressure: np.ndarray, at: Surroundings) -> np.ndarray:
        """None: from the yield stress on the layer flows."""
        return np.full(pressure.shape, np.inf)

    def implied(self, response: Response, at: Surroundings) -> Fields:
        """Yield stress implied by tractions: of particles hardened on their path, or softened in
        the step.
        """
        stress = self._arrived_stress(response.pressure.shape, at)
        if self.hardening > 0 and at.transport.repeats:
            flow = Flow(stress, self.hardening, at.transport.columns)
            stress = flow.after(np.hypot(*response.traction))
        elif self.hardening < 0:
            flows = response.slip_bound > stress
            softened = np.maximum(stress + self.hardening * np.hypot(*response.shift), 0.0)
            stress = np.where(flows, softened, stress)
        return {YIELD_STRESS: stress}

    def leave(self, response: Response, at: Surroundings) -> Fields:
        stress = self.implied(response, at)[YIELD_STRESS]
        flowed = response.flowed
        if self.hardening > 0:
            stress = np.maximum(stress, np.hypot(*response.traction))
        if at.transport.repeats:
            columns = at.transport.columns
            flowed = along_rows(flowed / min(columns, 1.0), columns, 0.0, np.add)
        elif DISPLACEMENT in at.arrived:
            flowed = flowed + at.arrived[DISPLACEMENT]
        return {DISPLACEMENT: flowed, YIELD_STRESS: stress}

    def _arrived_stress(self, shape: tuple[int, ...], at: Surroundings) -> np.ndarray:
        """The yield stress at the beginning of a step: of arriving particles, else of fresh
        material.
        """
        return at.arrived.get(YIELD_STRESS, np.full(shape, self.fresh_stress))
