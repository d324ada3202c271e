"""What acts on a contact: its load, motion and friction, and in a history the step before; and the scales of both."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from varcontact.scene.friction import Law
from varcontact.scene.interface import Thermal, ThirdBody
from varcontact.scene.motion import Motion, Steady
from varcontact.scene.scene import Scene
from varcontact.scene.transient import Transient


@dataclass(frozen=True)
class Scales:
    """The physical quantities that are 1 in the dimensionless problems: the modulus is the combined G."""

    length: float
    pressure: float
    modulus: float
    line: bool

    @property
    def displacement(self) -> float:
        """[length]"""
        return self.pressure * self.length / self.modulus

    @property
    def force(self) -> float:
        """[force]; in line contact [force/length]."""
        return self.pressure * (self.length if self.line else self.length**2)


@dataclass(frozen=True, eq=False)
class PreviousStep:
    """What a step of a history finds, dimensionless.

    The displacement differences u' (2, ny, nx) that the particles bring along, the tangential force (2,) of the step
    before, and its tractions: (2, ny, nx), or (3, ny, nx) with the pressure where the bodies differ. Under a law of
    friction the coefficients (ny, nx) they bring along. Of viscoelastic bodies u' is less what past tractions still
    add at the end, `left` (2, ny, nx) the same of the particles that were here at the beginning, and `distance` what
    they add to the distance, an element more all round. Of a third body that yields their plastic displacement and
    yield stress (3, ny, nx). Under a law by temperature how much warmer they are at the end of the step by what heated
    them before (ny, nx).
    """

    displacement: np.ndarray
    force: np.ndarray
    traction: np.ndarray
    left: np.ndarray | None = None
    distance: np.ndarray | None = None
    friction: np.ndarray | None = None
    plastic: np.ndarray | None = None
    rise: np.ndarray | None = None


@dataclass(frozen=True, eq=False)
class Loading:
    """What acts on a contact, physical: force or approach, motion, friction; in a history also the step before.

    Without a motion it is normal contact only. The coefficient of friction is one number or one for each element,
    (ny, nx); under a law it is that taken at the moment, the static one where nothing is known of slip. So is the yield
    stress of a third body, dimensionless (ny, nx): that with which particles arrive; of one that does not harden, that
    which holds.
    """

    normal_force: float | None
    approach: float | None
    motion: Motion | None
    law: Law | None
    coefficient: float | np.ndarray | None
    previous_step: PreviousStep | None = None
    third_body: ThirdBody | None = None
    yield_stress: np.ndarray | None = None
    thermal: tuple[Thermal, Thermal] | None = None

    @classmethod
    def of(cls, scene: Scene) -> Loading:
        """That of a scene; of a history without its motion."""
        law = scene.friction if isinstance(scene.friction, Law) else None
        coefficient = scene.friction.static if isinstance(scene.friction, Law) else scene.friction
        motion, layer = None if isinstance(scene.motion, Transient) else scene.motion, scene.third_body
        load = scene.normal_force, scene.approach
        return cls(*load, motion, law, coefficient, third_body=layer, thermal=scene.thermal)

    @property
    def steady(self) -> bool:
        return isinstance(self.motion, Steady)

    @property
    def frictionless(self) -> bool:
        """Whether no tangential traction can arise."""
        return self.motion is None or (self.law is None and not np.any(self.coefficient))

    @property
    def no_slip(self) -> bool:
        return isinstance(self.coefficient, float) and math.isinf(self.coefficient)
