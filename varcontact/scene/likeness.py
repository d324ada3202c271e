"""Almost like bodies: how much the coupling of pressure and tractions can change, and when it is left out."""

from __future__ import annotations

import numpy as np

from varcontact.scene.bodies import Bodies
from varcontact.scene.friction import Law
from varcontact.scene.motion import Transient
from varcontact.scene.scene import Scene

NEGLIGIBLE = 3e-4
"""The coupling is left out where it changes the forces by less, in parts of f Fz.

The forces on the default grid are known to about 1 %.
"""

SLOPE = 4.0
"""The forces change by less than this times ``|K| / (1 - nu) (1/f + f)``, in parts of f Fz.

Closed form gives 4/pi for a cylinder that rolls without slip; docs/theory.md has what was measured elsewhere.
"""

_RIGID = ("vx", "vy", "spin", "ux", "uy", "rotation", "Fx", "Fy")


def coupling_effect(bodies: Bodies, friction: float | np.ndarray) -> float:
    """What the coupling of pressure and tractions changes of the tangential forces at most, in parts of f Fz.

    Pressures shift the surfaces by K, which tractions of the order f answer: the part is of the order ``K/f``.
    Tractions change the pressures by the order ``K f``.
    """
    f = np.asarray(friction, dtype=float).ravel()
    f = f[f > 0]
    if bodies.K == 0 or f.size == 0:
        return 0.0
    return float(SLOPE * abs(bodies.K) / (1 - bodies.combined_nu) * np.max(f + 1 / f))


def left_out(scene: Scene) -> float:
    """The effect of the coupling on the forces, where it is so small that it is left out, else 0.

    It is kept whatever its size where it is all that moves the surfaces, and under a law of friction, where the
    least change may lead to another solution.
    """
    if scene.bodies.K == 0 or scene.frictionless or scene.under_law or not _moves(scene):
        return 0.0
    effect = max(coupling_effect(scene.bodies, f) for f in scene.frictions if not (f is None or isinstance(f, Law)))
    return effect if effect <= NEGLIGIBLE else 0.0


def almost_like(K: float, effect: float) -> tuple[tuple[str, str], str]:
    """What a plan says where the coupling is left out: the kind of the bodies with its reason, and of the coupling."""
    kind = "almost like", f"K = {K:.3g} is so small that pressure and tractions are taken to be independent"
    reason = f"left out: it changes the tangential force at given creepages by less than {effect:.1e} of f Fz"
    return kind, f'{reason}; coupling="panagiotopoulos" includes it'


def _moves(scene: Scene) -> bool:
    """Whether a creepage, a shift or a force is prescribed that is not zero, or tractions are there at the start."""
    motion = scene.motion
    names = [name for name in _RIGID if hasattr(motion, name)]
    if isinstance(motion, Transient):
        started = motion.start is not None and bool(motion.start.traction.any())
        return started or any(value for name in names for value in motion.every(name))
    return any(getattr(motion, name) for name in names)
