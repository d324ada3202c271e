"""The fast way for vehicle codes: an ellipse for each patch without an elastic solution, and a fast theory's forces.

Virtual penetration (Kik and Piotrowski 1996, "A fast, approximate method to calculate normal load at contact between
wheel and rail and creep forces during rolling"): the undeformed bodies, ``epsilon = 0.55`` times as deep in each other
as they approach, overlap over about the true contact. With the overlap ``g(s)`` across the rail, the half length of the
patch is ``l(s) = sqrt(2 R g)``, and the pressure is taken as semi-elliptic along x:

    p(x, s) = p0 sqrt(l(s)^2 - x^2) / max(l).

The deflection at the deepest point, (1 - nu)/(2 pi G) times the integral of p/distance for the combined constants, is
to be the approach delta; this gives p0 and the normal force. The integral along x is complete elliptic:
``int sqrt(l^2 - x^2)/sqrt(x^2 + s^2) dx = 2 q (K(m) - E(m))``, ``q^2 = l^2 + s^2``, ``m = l^2/q^2``.
The ellipse of the same area, and the same length by width, goes into the fast theory.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from varcontact import checks
from varcontact.errors import SceneError
from varcontact.kinematics import Creepages, Frame
from varcontact.theories.creep_forces import creep_forces
from varcontact.wheel_rail.curve import Curve
from varcontact.wheel_rail.locus import Overlap, overlap
from varcontact.wheel_rail.patches import joined, tangent_of, too_rough
from varcontact.wheel_rail.result import WheelForces
from varcontact.wheel_rail.solve import bearing_height
from varcontact.wheel_rail.track import check_sides
from varcontact.wheel_rail.wheel_on_rail import WheelOnRail

EPSILON = 0.55
"""Ratio of the virtual penetration to the approach, Kik and Piotrowski's."""
STRIPS = 60
"""Across the overlap, over which the deflection is summed up."""
NORMAL = ("virtual-penetration", "hertz")


@dataclass(frozen=True)
class Ellipse:
    """The ellipse that stands for a patch.

    Attributes
    ----------
    a, b : float
        Semi-axes along x and across the rail [mm].
    normal_force : float
        [N]
    peak_pressure : float
        [N/mm^2]
    """

    a: float
    b: float
    normal_force: float
    peak_pressure: float


@dataclass(frozen=True, eq=False)
class FastPatch:
    """A contact patch by the fast way.

    Attributes
    ----------
    frame : Frame
        As of `ContactPatch`.
    angle : float
        Contact angle [rad].
    creepage : Creepages
        Of the rail over the wheel.
    approach : float
        How deep the undeformed wheel is in the rail [mm].
    ellipse : Ellipse
    force : ndarray, shape (3,)
        (Fx, Fs, FN) on the rail in the contact frame [N].
    moment : float
        On the rail about the normal [N mm]; NaN by a theory that has none.
    """

    frame: Frame
    angle: float
    creepage: Creepages
    approach: float
    ellipse: Ellipse
    force: np.ndarray
    moment: float

    @property
    def force_on_track(self) -> np.ndarray:
        """(Fx, Fy, Fz) on the rail in track coordinates [N]."""
        return np.asarray(self.frame.axes @ self.force)

    @property
    def tilting(self) -> np.ndarray:
        """Moment about x and y of the frame's origin: none, the ellipse is in the middle."""
        return np.zeros(3)


@dataclass(frozen=True, eq=False, repr=False)
class FastWheel(WheelForces):
    """All patches of a wheel on a rail by the fast way.

    Attributes
    ----------
    case : WheelOnRail
    z : float
        Height of the axle, downwards [mm].
    patches : tuple of FastPatch
        From left to right.
    """

    patches: tuple[FastPatch, ...]


def estimate_wheel_on_rail(
    case: WheelOnRail, normal: str, tangential: str, tol: float, options: dict[str, Any]
) -> FastWheel:
    """See `WheelOnRail.estimate`; `options` are those of the theory."""
    check_sides(case.track, stacklevel=4)
    normal, tol = checks.choice("normal", normal, NORMAL), checks.positive("tol", tol)
    case.friction_at(0.0)  # refused if it is a law

    def patches(z: float) -> tuple[FastPatch, ...]:
        found = []
        for group in joined(case.locus.overlaps(z), case.join):
            tangent = tangent_of(group, case.rail)
            approach = max(float(each.depth.max()) for each in group) * float(np.cos(tangent.angle))
            rolled, ellipse = case.creepage(tangent.frame, approach, z), _ellipse(case, group, z, normal)
            Fx = Fy = moment = 0.0
            friction = case.friction_at(tangent.angle)
            if friction != 0:
                forces = creep_forces(
                    tangential,
                    a=ellipse.a,
                    b=ellipse.b,
                    normal_force=ellipse.normal_force,
                    friction=friction,
                    vx=rolled.vx,
                    vy=rolled.vy,
                    spin=rolled.spin,
                    bodies=case.bodies,
                    **options,
                )
                Fx, Fy, moment = forces.Fx, forces.Fy, forces.Mz
            force = np.array([Fx, Fy, ellipse.normal_force])
            found.append(FastPatch(tangent.frame, tangent.angle, rolled, approach, ellipse, force, moment))
        return tuple(found)

    def vertical(z: float) -> float:
        if case.with_friction:
            return float(sum(each.force_on_track[2] for each in patches(z)))
        groups = joined(case.locus.overlaps(z), case.join)
        angles = [tangent_of(group, case.rail).angle for group in groups]
        return float(np.cos(angles) @ [_ellipse(case, group, z, normal).normal_force for group in groups])

    z = bearing_height(case, tol, vertical)[0] if case.z is None else case.z
    return FastWheel(case, z, patches(z))


def _ellipse(case: WheelOnRail, group: list[Overlap], z: float, normal: str) -> Ellipse:
    """The ellipse of a patch by either method, from the circle that is deepest in the rail."""
    deepest = max(group, key=lambda each: each.depth.max())
    k = int(deepest.depth.argmax())
    approach, point = float(deepest.depth[k]), deepest.points[k]
    circle = deepest.run.start + k
    angle, radius = float(deepest.locus.angles[circle]), float(deepest.locus.radii[circle])
    if normal == "hertz":
        if not isinstance(case.rail, Curve):
            raise SceneError("normal", "hertz", message='normal = "hertz": it is for one profile; take the other')
        return _by_curvatures(case, point, approach * np.cos(angle), radius / np.cos(angle), z)
    # with the circles beside, which are above the rail, and those between separate overlaps, which count together
    whole = overlap(deepest.locus, slice(group[0].run.start - 1, group[-1].run.stop + 1), z)
    across = (whole.surface - deepest.surface[k]) @ np.array([np.cos(angle), np.sin(angle)])
    if (np.diff(across) <= 0).any():
        raise too_rough(float(point[1]))
    virtual = whole.depth - (1 - EPSILON) * approach
    return _by_virtual_penetration(case, across, virtual, approach, angle, radius)


def _by_curvatures(case: WheelOnRail, point: np.ndarray, approach: float, rolling: float, z: float) -> Ellipse:
    """Hertz's ellipse where the profiles touch first, of the approach there."""
    from varcontact.reference import hertz

    on_rail = case.track.on_rail(point[1:], case.side)
    on_wheel = case.on_wheel(point, case.body(z))
    bent = float(case.track.profile.curvature_at(on_rail[0]) + case.wheelset.profile.curvature_at(on_wheel[0]))
    if not bent > 0:
        reason = (
            f"normal = 'hertz': at y = {point[1]:.4g} mm the profiles curve away from each other by {bent:.3g} 1/mm, "
            'no ellipse; take "virtual-penetration"'
        )
        raise SceneError("normal", "hertz", message=reason)
    found = hertz(rolling, 1 / bent, case.bodies, approach=approach)
    return Ellipse(found.a, found.b, found.force, found.peak_pressure)


def _by_virtual_penetration(
    case: WheelOnRail, across: np.ndarray, overlap: np.ndarray, approach: float, angle: float, radius: float
) -> Ellipse:
    """See the module; `overlap` is the virtual one over the places `across` the rail from the deepest point."""
    from scipy.special import ellipe, ellipkm1

    # the ends lie between the points: the force is to depend smoothly on the height
    inside = np.flatnonzero(overlap > 0)
    first, last = (
        float(across[i] + overlap[i] / (overlap[i] - overlap[j]) * (across[j] - across[i]))
        for i, j in ((inside[0], inside[0] - 1), (inside[-1], inside[-1] + 1))
    )
    step = (last - first) / STRIPS
    s = first + step * (np.arange(STRIPS) + 0.5)
    half = np.sqrt(2 * radius * np.maximum(np.interp(s, across, overlap), 0.0))
    s, half = s[half > 0], half[half > 0]
    away = np.exp((_log_integral(s + step / 2) - _log_integral(s - step / 2)) / step)
    q2 = half**2 + away**2
    felt = step * float(np.sum(2 * np.sqrt(q2) * (ellipkm1(away**2 / q2) - ellipe(half**2 / q2))))
    volume = step * float(np.sum(np.pi / 2 * half**2))
    longest = np.sqrt(2 * radius * EPSILON * approach)
    # delta = (1 - nu)/(pi G) * integral of p/distance, both bodies together
    modulus = np.pi * case.bodies.combined_G / (1 - case.bodies.combined_nu)
    by_length = approach * np.cos(angle) * modulus / felt
    area, width = step * float(np.sum(2 * half)), step * s.size
    a, b = np.sqrt(area * 2 * longest / (np.pi * width)), np.sqrt(area * width / (np.pi * 2 * longest))
    return Ellipse(float(a), float(b), float(by_length * volume), float(by_length * longest))


def _log_integral(t: np.ndarray) -> np.ndarray:
    """Of log |t|: its mean over a strip stands for the distance from the deepest point, where it has no bound."""
    return np.asarray(t * (np.log(np.abs(np.where(t == 0, 1.0, t))) - 1))
