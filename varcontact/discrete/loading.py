"""The loading of a contact: load and motion, and in a history the step before."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from varcontact.elasticity.beside import LoadsBeside
from varcontact.interfaces.interface import Fields
from varcontact.scene.friction import Friction
from varcontact.scene.motion import Motion
from varcontact.scene.scene import Scene


@dataclass(frozen=True, eq=False)
class PreviousStep:
    """The step before in a history, dimensionless.

    The displacement differences u' (2, ny, nx) that the particles bring along, the tangential force
    (2,) of the step before, and its tractions: (2, ny, nx), or (3, ny, nx) with the pressure where
    the bodies differ. Of viscoelastic bodies u' is less what past tractions still add at the end,
    `left` (2, ny, nx) the same of the particles that were here at the beginning, and `distance`
    what they add to the distance, an element more all round.
    """

    displacement: np.ndarray
    force: np.ndarray
    traction: np.ndarray
    left: np.ndarray | None = None
    distance: np.ndarray | None = None


@dataclass(frozen=True, eq=False)
class Loading:
    """The loading of a contact: force or approach, and motion; in a history the step before.

    Without a motion it is normal contact only. The scene says what lies between the bodies.
    `arrived` are fields of the interfaces that particles bring along, `implicit` those that the
    contact itself determines, as they are taken in this pass. `beside` are loads beside the
    contact, `beside_before` those of the step before.
    """

    scene: Scene
    friction: Friction | None
    normal_force: float | None
    approach: float | None
    motion: Motion | None
    previous_step: PreviousStep | None = None
    arrived: Fields = field(default_factory=dict)
    implicit: Fields = field(default_factory=dict)
    beside: LoadsBeside | None = None
    beside_before: LoadsBeside | None = None
