"""The loading of a contact: load, motion and interface, and in a history the step before."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from varcontact.interfaces.coulomb import FRICTION
from varcontact.interfaces.interface import Fields
from varcontact.interfaces.third_body import YieldingLayer
from varcontact.scene.friction import FrictionBound, Law
from varcontact.scene.interface import Thermal
from varcontact.scene.motion import Motion, Steady
from varcontact.scene.scene import Scene
from varcontact.scene.transient import Transient
from varcontact.scene.units import Scales


@dataclass(frozen=True, eq=False)
class PreviousStep:
    """The step before in a history, dimensionless.

    The displacement differences u' (2, ny, nx) that the particles bring along, the tangential force
    (2,) of the step before, and its tractions: (2, ny, nx), or (3, ny, nx) with the pressure where
    the bodies differ. Of viscoelastic bodies u' is less what past tractions still add at the end,
    `left` (2, ny, nx) the same of the particles that were here at the beginning, and `distance`
    what they add to the distance, an element more all round. `arrived` are the other fields that
    particles bring along, by the names of their quantities.
    """

    displacement: np.ndarray
    force: np.ndarray
    traction: np.ndarray
    left: np.ndarray | None = None
    distance: np.ndarray | None = None
    arrived: Fields = field(default_factory=dict)


@dataclass(frozen=True, eq=False)
class Loading:
    """The loading of a contact: force or approach, motion, friction and layers; in a history the
    step before.

    Without a motion it is normal contact only. `implicit` are the fields of the interfaces that the
    contact itself determines, as they are taken in this pass.
    """

    normal_force: float | None
    approach: float | None
    motion: Motion | None
    friction: float | np.ndarray | Law | FrictionBound | None
    layer: YieldingLayer | None = None
    thermal: tuple[Thermal, Thermal] | None = None
    previous_step: PreviousStep | None = None
    implicit: Mapping[str, np.ndarray] = field(default_factory=dict)

    @classmethod
    def of(cls, scene: Scene, scales: Scales) -> Loading:
        """The loading of a scene; of a history without its motion."""
        motion = None
        if not isinstance(scene.motion, Transient):
            motion = scene.motion
        third_body = scene.third_body
        layer = None
        if third_body is not None and third_body.yields:
            layer = YieldingLayer.of(third_body, scales)
        return cls(scene.normal_force, scene.approach, motion, scene.friction, layer, scene.thermal)

    @property
    def law(self) -> Law | None:
        if isinstance(self.friction, Law):
            return self.friction
        return None

    @property
    def coefficient(self) -> float | np.ndarray | None:
        """The coefficient of friction, one number or (ny, nx): under a law that of this pass, or
        the static one.
        """
        if FRICTION in self.implicit:
            return self.implicit[FRICTION]
        if isinstance(self.friction, FrictionBound):
            return None
        if isinstance(self.friction, Law):
            return self.friction.static
        return self.friction

    @property
    def steady(self) -> bool:
        return isinstance(self.motion, Steady)

    @property
    def frictionless(self) -> bool:
        """No tangential traction can arise."""
        if self.motion is None:
            return True
        return not isinstance(self.friction, Law | FrictionBound) and not np.any(self.coefficient)

    @property
    def no_slip(self) -> bool:
        return isinstance(self.coefficient, float) and math.isinf(self.coefficient)
