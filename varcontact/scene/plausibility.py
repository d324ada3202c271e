"""Plausibility warnings of a scene: likely mistakes in entries that can be solved, each with its
figures.

`CHECKS` are one small function each, which returns its sentence, or nothing.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING

import numpy as np

from varcontact.errors import PlausibilityWarning, warn
from varcontact.scene.bodies import Bodies
from varcontact.scene.friction import Law
from varcontact.scene.motion import Shift, Steady, TimeStep
from varcontact.scene.surfaces import SampledDistance
from varcontact.scene.transient import Transient
from varcontact.scene.units import Units

if TYPE_CHECKING:
    from varcontact.scene.scene import Scene

PASCALS = {
    ("m", "N"): 1.0,
    ("mm", "N"): 1e6,
    ("mm", "kN"): 1e9,
    ("m", "kN"): 1e3,
    ("in", "lbf"): 6894.757,
}
"""Pascals in some units of pressure."""

MODULUS_DIMENSIONLESS = 100.0
"""Modulus of rigidity without units below which a scene counts as dimensionless: strains may then
be large."""

MODULUS_MIN = 1e5
MODULUS_MAX = 1e12
"""Range of the modulus of rigidity of solids, from gels to diamond [Pa], `MODULUS_MIN` to this."""

YOUNG = (
    ("steel", (195e9, 217e9), (0.25, 0.33), 80e9),
    ("aluminium", (68e9, 73e9), (0.32, 0.36), 26e9),
)
"""Metals: name, ranges of Young's modulus [Pa] (no solid has it as its modulus of rigidity) and of
Poisson's ratio, and modulus of rigidity [Pa]."""

PSI = 1.1e7, 1.3e7
"""Modulus of rigidity of steel in pounds per square inch, as a range."""

LARGE_RADIUS = 20.0
"""Largest plausible radius in metres."""

LARGE_INCHES = 150.0
"""Largest plausible radius in inches."""

LARGE_CREEPAGE = 0.1

LARGE_FRICTION = 2.0
"""Coefficient of friction above that of dry solids."""

LARGE_SPIN = 1.0
"""Rotation [rad] while the bodies roll over half the contact length, above which spin is doubtful:
rigid slip is then that many times the rolling velocity."""

LARGE_CONTACT = 0.5
"""Semi-axis divided by the radius of curvature above which a half-space is a poor model of the
body."""


def warnings_of(scene: Scene) -> tuple[str, ...]:
    """Likely mistakes, see `Scene.doubts`."""
    return tuple(words for check in CHECKS if (words := check(scene)))


def warn_plausibility(texts: Iterable[str]) -> None:
    """Warn with a `PlausibilityWarning` for each text."""
    for text in texts:
        warn(text, PlausibilityWarning)


def _softening(scene: Scene) -> str:
    """Warning for a softening third body, under which several histories may be solutions."""
    if scene.third_body is None or scene.third_body.k_tau >= 0:
        return ""
    return "the third body softens (k_tau < 0): the history need not be the only one"


def _modulus(scene: Scene) -> str:
    """Warning for a modulus that no solid has in the given units, or in pascals beside lengths in
    millimetres.
    """
    G = scene.bodies.combined_G
    units = scene.units
    pascals = _pascals(units)
    if isinstance(units, Units) and pascals is not None:
        given = f"G = {G:.4g} {units.of('pressure')} is {G * pascals:.2g} Pa"
        if G * pascals < MODULUS_MIN:
            return f"{given}, softer than solids are"
        if not G * pascals <= MODULUS_MAX:
            return f"{given}, stiffer than solids are"
    if units is not None:
        return ""
    if G < PSI[0]:
        return ""
    radius = min(_radii(scene), default=0.0)
    if G >= 1e9 and radius >= LARGE_RADIUS:
        return f"G = {G:.4g} looks like pascals, a radius of {radius:.4g} like millimetres"
    if G <= PSI[1] and radius >= LARGE_INCHES:
        return (
            f"G = {G:.4g} looks like pounds by square inch, "
            f"a radius of {radius:.4g} like millimetres"
        )
    return ""


def _metres(scene: Scene) -> str:
    """Warning for radii that are probably in millimetres, while the units are metres."""
    units = scene.units
    if not isinstance(units, Units) or units.length != "m":
        return ""
    radius = min(_radii(scene), default=0.0)
    if radius < LARGE_RADIUS:
        return ""
    return f"the smallest radius of curvature is {radius:.4g} m: it looks like millimetres"


def _young(scene: Scene) -> str:
    """Warning for a Young's modulus given as modulus of rigidity."""
    bodies = scene.bodies
    if not isinstance(bodies, Bodies):
        return ""
    pascals = _pascals(scene.units)
    if pascals is None:  # lengths may be of any unit, but for large radii, which are millimetres
        pascals = PASCALS["m", "N"]
        if min(_radii(scene), default=0.0) >= LARGE_RADIUS:
            pascals = PASCALS["mm", "N"]
    (G1, G2), (nu1, nu2) = bodies.pairs
    for G, nu in ((G1, nu1), (G2, nu2)):
        for metal, (E_min, E_max), (nu_min, nu_max), rigidity in YOUNG:
            if E_min <= G * pascals <= E_max and nu_min <= nu <= nu_max:
                return (
                    f"G = {G:.4g} is Young's modulus of {metal}, whose G is about "
                    f"{rigidity / pascals:.2g}; give Bodies.from_young(E, nu)"
                )
    return ""


def _large_contact(scene: Scene) -> str:
    """Warning for a contact as large as the bodies."""
    hertz = scene.hertz
    if hertz is None or _dimensionless(scene):
        return ""
    radii = _radii(scene)
    if not radii:
        return ""
    axes = hertz.a, hertz.b
    ratio, axis, radius = max(
        (axis / radius, axis, radius) for axis, radius in zip(axes, radii, strict=False)
    )
    if not LARGE_CONTACT <= ratio < math.inf:
        return ""
    if scene.approach is None:
        load = f"normal_force = {scene.normal_force:.4g}"
    else:
        load = f"approach = {scene.approach:.4g}"
    return (
        f"{load}: the contact's semi-axis {axis:.4g} is {ratio:.2g} of the radius {radius:.4g}; "
        "half-spaces stand for bodies much larger than it"
    )


def _upside_down(scene: Scene) -> str:
    """Warning for samples of an upward height instead of a distance: highest inside, lowest at all
    corners.
    """
    surface = scene.surface
    if not isinstance(surface, SampledDistance) or min(surface.samples.shape[1:]) < 3:
        return ""
    if scene.periodic:
        return ""
    h = surface.samples
    if surface.line:
        inner = h[:, 1:-1]
        corners = h[:, [0, -1]]
    else:
        inner = h[1:-1, 1:-1]
        corners = h[[0, 0, -1, -1], [0, -1, 0, -1]]
    if inner.size == 0 or not inner.max() > h.min() or corners.max() > (inner.max() + h.min()) / 2:
        return ""
    if inner.min() < corners.max():
        return ""
    figures = f"{inner.max() + 0.0:.4g} inside, and at most {corners.max():.4g} at its corners"
    return f"surface.h is up to {figures}: the distance of the bodies looks upside down; give -h"


def _parts_in_history(scene: Scene) -> str:
    """Warning for carried heights that separate the bodies."""
    if scene.approach is None or not isinstance(scene.motion, Transient):
        return ""
    heights = scene.motion.height_range
    if not 0 < scene.approach <= heights:
        return ""
    return (
        f"carried heights of up to {heights:.4g} exceed the approach {scene.approach:.4g}: "
        "the bodies part, and forces are zero there"
    )


def _friction(scene: Scene) -> str:
    """Warning for a coefficient above that of dry solids, such as one in per cent."""
    largest = _largest_friction(scene)
    if not LARGE_FRICTION < largest < math.inf or _dimensionless(scene):
        return ""
    return (
        f"friction = {largest:.4g}: coefficients are below {LARGE_FRICTION:g}, and are no per cents"
    )


def _half_velocity(scene: Scene) -> str:
    """Warning for a slip velocity of a law of friction that counts as a relative slip above 1."""
    half = getattr(scene.friction, "half_velocity", 0.0)
    velocity = getattr(scene.friction, "velocity", 1.0)
    if half <= 1 or velocity != 1 or isinstance(scene.motion, Shift):
        return ""
    return (
        f"friction.half_velocity = {half:.4g} is a slip relative to the rolling velocity, as "
        "friction.velocity is 1: give it the rolling velocity, in the unit of half_velocity"
    )


def _creepage(scene: Scene) -> str:
    """Warning for creepages at which velocities differ much from those of rolling; without slip
    everything is linear.
    """
    if scene.no_slip or _dimensionless(scene):
        return ""
    for name in ("vx", "vy"):
        largest = _largest(scene, name)
        if abs(largest) > LARGE_CREEPAGE:
            return (
                f"{name} = {largest:.4g}: creepages are mostly below {LARGE_CREEPAGE:g}, "
                "and are no per cents"
            )
    return ""


def _spin(scene: Scene) -> str:
    """Warning for spin by which the contact rotates more than it rolls."""
    spin = _largest(scene, "spin")
    hertz = scene.hertz
    if spin == 0 or hertz is None or scene.line or scene.no_slip or _dimensionless(scene):
        return ""
    size = math.sqrt(hertz.a * hertz.b)
    if abs(spin) * size <= LARGE_SPIN:
        return ""
    return (
        f"spin = {spin:.4g}: the rigid slip at the edge of the contact, of radius {size:.4g}, "
        f"is {abs(spin) * size:.3g} of the velocity; "
        "spin is an angle by length, in the unit of the scene"
    )


def _sliding_strip(scene: Scene) -> str:
    """Warning for tangential forces on a strip that slides on its base."""
    motion = scene.motion
    slides = scene.line and scene.bodies.slides and not scene.frictionless
    if not slides or not isinstance(motion, Steady | Shift):
        return ""
    if motion.Fx == 0 and not motion.Fy and not motion.rigid[1]:
        return ""
    return (
        "a smooth base carries no shear: "
        "either end of the strip is taken to carry half of a shear force"
    )


CHECKS: tuple[Callable[[Scene], str], ...] = (
    _softening,
    _modulus,
    _metres,
    _young,
    _large_contact,
    _upside_down,
    _parts_in_history,
    _friction,
    _half_velocity,
    _creepage,
    _spin,
    _sliding_strip,
)


def _radii(scene: Scene) -> list[float]:
    """Radii of curvature of the surface, if it has any."""
    surface = scene.surface
    return [getattr(surface, name) for name in ("Rx", "Ry", "R") if hasattr(surface, name)]


def _dimensionless(scene: Scene) -> bool:
    return scene.units is None and scene.bodies.combined_G < MODULUS_DIMENSIONLESS


def _pascals(units: Units | None) -> float | None:
    """Pascals in the scene's unit of pressure, if that is known."""
    if isinstance(units, Units):
        return PASCALS.get((units.length, units.force))
    return None


def _largest_friction(scene: Scene) -> float:
    """The largest coefficient, static of a law, of all steps; those of other bounds are not known
    beforehand.
    """
    largest = 0.0
    for each in scene.frictions:
        if isinstance(each, float):
            largest = max(largest, each)
        elif isinstance(each, np.ndarray):
            largest = max(largest, float(each.max()))
        elif isinstance(each, Law):
            largest = max(largest, each.static)
    return largest


def _largest(scene: Scene, name: str) -> float:
    """Creepage with the largest size, over all steps."""
    motion = scene.motion
    if isinstance(motion, Transient):
        return float(max(motion.every(name), key=abs))
    if isinstance(motion, Steady | TimeStep):
        return float(getattr(motion, name))
    return 0.0
