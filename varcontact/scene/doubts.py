"""Likely mistakes in a scene that can be solved: units that do not go together, unusual sizes."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from varcontact.scene.motion import Shift, Steady, TimeStep
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
    """Likely mistakes, see `Scene.doubts`."""
    found: list[str] = []
    surface, motion, units, G = scene.surface, scene.motion, scene.units, scene.bodies.combined_G
    radii = [getattr(surface, name) for name in ("Rx", "Ry", "R") if hasattr(surface, name)]
    if scene.third_body is not None and scene.third_body.k_tau < 0:
        found.append("the third body softens (k_tau < 0): the history need not be the only one")
    # moduli in pascals beside lengths in millimetres, or the other way round
    smallest = min(radii, default=0.0)
    if isinstance(units, Units) and (units.length, units.force) in PASCALS:
        pascals = G * PASCALS[units.length, units.force]
        if not SOFTEST <= pascals <= STIFFEST:
            than = "softer" if pascals < SOFTEST else "stiffer"
            found.append(f"G = {G:.4g} {units.of('pressure')} is {pascals:.2g} Pa, {than} than solids are")
    elif units is None and G >= 1e9 and smallest >= LARGE_RADIUS:
        found.append(f"G = {G:.4g} looks like pascals, a radius of {smallest:.4g} like millimetres")
    # a contact as large as the bodies
    loaded = scene.normal_force is not None or scene.approach is not None
    if radii and loaded and scene.hertz is not None:
        axes = scene.hertz.a, scene.hertz.b
        part, size, radius = max((size / radius, size, radius) for size, radius in zip(axes, radii, strict=False))
        if LARGE_CONTACT <= part < math.inf:
            name = "normal_force" if scene.approach is None else "approach"
            words = f"{name} = {getattr(scene, name):.4g}: the contact's semi-axis {size:.4g} is {part:.2g} of"
            found.append(f"{words} the radius {radius:.4g}; half-spaces stand for bodies much larger than it")
    heights = motion.height_range if isinstance(motion, Transient) else 0.0
    if scene.approach is not None and 0 < scene.approach <= heights:
        words = f"carried heights of up to {heights:.4g} exceed the approach {scene.approach:.4g}"
        found.append(f"{words}: the bodies part, and forces are zero there")
    # creepages beyond those for which velocities are nearly those of rolling
    for name in ("vx", "vy") if isinstance(motion, Steady | TimeStep | Transient) else ():
        values = motion.every(name) if isinstance(motion, Transient) else [getattr(motion, name)]
        largest = max(values, key=abs)
        if abs(largest) > LARGE_CREEPAGE:
            found.append(f"{name} = {largest:.4g}: creepages are mostly below {LARGE_CREEPAGE:g}, and are no per cents")
            break
    # tangential forces on a strip that slides on its base
    slides = scene.line and scene.bodies.slides and not scene.frictionless
    if slides and isinstance(motion, Steady | Shift) and (motion.Fx != 0 or motion.Fy or motion.rigid[1]):
        found.append("a smooth base bears no shear: either end of the strip is taken to bear half of a shear force")
    return tuple(found)
