"""Scenes that can be solved, but look like a slip of the pen: a word on each."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from varcontact.scene.motion import Steady, TimeStep
from varcontact.scene.surfaces import Cylinders, Paraboloids
from varcontact.scene.transient import Transient
from varcontact.scene.units import Units

if TYPE_CHECKING:
    from varcontact.scene.scene import Scene

PASCALS = {("m", "N"): 1.0, ("mm", "N"): 1e6, ("mm", "kN"): 1e9, ("m", "kN"): 1e3}
"""Pascals in the units of pressure of some scenes."""
SOFTEST, STIFFEST = 1e5, 1e12
"""Moduli of rigidity between which solids lie, from gels to diamond [Pa]."""
LARGE_RADIUS = 20.0
"""A radius of metres has fewer than this."""
LARGE_CREEPAGE = 0.1
LARGE_CONTACT = 0.5
"""Semi-axis by radius of curvature: a half-space is far from such a body."""


def doubts(scene: Scene) -> tuple[str, ...]:
    """What looks like a slip of the pen, see `Scene.doubts`."""
    found = (_modulus(scene), _size(scene), _creepage(scene))
    return tuple(word for word in found if word)


def _radii(scene: Scene) -> tuple[float, ...]:
    surface = scene.surface
    if isinstance(surface, Paraboloids):
        return surface.Rx, surface.Ry
    return (surface.R,) if isinstance(surface, Cylinders) else ()


def _modulus(scene: Scene) -> str:
    """Moduli in pascals beside lengths in millimetres, or the other way round."""
    G, units = scene.bodies.combined_G, scene.units
    if isinstance(units, Units) and (units.length, units.force) in PASCALS:
        pascals = G * PASCALS[units.length, units.force]
        if not SOFTEST <= pascals <= STIFFEST:
            than = "softer" if pascals < SOFTEST else "stiffer"
            return f"G = {G:.4g} {units.of('pressure')} is {pascals:.2g} Pa, {than} than solids are"
        return ""
    smallest = min(_radii(scene), default=0.0)
    if units is None and G >= 1e9 and smallest >= LARGE_RADIUS:
        return f"G = {G:.4g} looks like pascals, a radius of {smallest:.4g} like millimetres"
    return ""


def _size(scene: Scene) -> str:
    """A contact as large as the bodies."""
    radii = _radii(scene)
    if not radii or (scene.normal_force is None and scene.approach is None):
        return ""
    hertz = scene.hertz
    if hertz is None:
        return ""
    parts = [(size / radius, size, radius) for size, radius in zip((hertz.a, hertz.b), radii, strict=False)]
    part, size, radius = max(parts)
    if not LARGE_CONTACT <= part < math.inf:
        return ""
    load = f"normal_force = {scene.normal_force:.4g}" if scene.approach is None else f"approach = {scene.approach:.4g}"
    words = f"{load}: the contact's semi-axis {size:.4g} is {part:.2g} of the radius {radius:.4g}"
    return f"{words}; half-spaces stand for bodies much larger than it"


def _creepage(scene: Scene) -> str:
    """Creepages beyond those for which velocities are nearly those of rolling."""
    motion = scene.motion
    if not isinstance(motion, Steady | TimeStep | Transient):
        return ""
    for name in ("vx", "vy"):
        values = motion.every(name) if isinstance(motion, Transient) else [getattr(motion, name)]
        largest = max(values, key=abs)
        if abs(largest) > LARGE_CREEPAGE:
            return f"{name} = {largest:.4g}: creepages are mostly below {LARGE_CREEPAGE:g}, and are no per cents"
    return ""
