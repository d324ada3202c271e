"""Prescribed forces beyond what friction can carry, as far as they are known before a scene is solved."""

from __future__ import annotations

import numpy as np

from varcontact.errors import Saturated
from varcontact.scene.friction import Law
from varcontact.scene.motion import Shift, Steady, Transient
from varcontact.scene.scene import Scene


def check_saturation(scene: Scene) -> None:
    """Before any work: forces beyond f Fz, where both are numbers; forces in steps of a history without friction.

    Parameters
    ----------
    scene : Scene

    Raises
    ------
    Saturated
        If friction cannot carry them.
    """
    motion = scene.motion
    if isinstance(motion, Transient) and not (motion.Fx is None and motion.Fy is None):
        for k, friction in enumerate(scene.frictions):
            size = float(np.hypot(motion.of("Fx", k) or 0.0, motion.of("Fy", k) or 0.0))
            if size > 0 and np.all(np.asarray(friction) == 0):
                raise Saturated(size, 0.0).in_step(k, None)
    if not isinstance(motion, Steady | Shift):
        return
    size = float(np.hypot(motion.Fx or 0.0, motion.Fy or 0.0))
    limit = 0.0 if scene.frictionless else np.inf
    friction = scene.friction.static if isinstance(scene.friction, Law) else scene.friction
    if isinstance(friction, float) and scene.normal_force is not None:
        limit = friction * scene.normal_force
    if size > 0 and size >= limit:
        raise Saturated(size, limit)
