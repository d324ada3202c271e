"""The fast way for vehicle codes: an ellipse for each patch without an elastic
solution, and a fast theory's forces.

Virtual penetration (Kik and Piotrowski 1996, "A fast, approximate method to
calculate normal load at contact between wheel and rail and creep forces during
rolling"): the undeformed bodies, ``epsilon = 0.55`` times as deep in each other
as they approach, overlap over about the true contact. With the overlap ``g(s)``
across the rail, the half length of the patch is ``l(s) = sqrt(2 R g)``, and the
pressure is taken as semi-elliptic along x:

    p(x, s) = p0 sqrt(l(s)^2 - x^2) / max(l).

The deflection at the deepest point, (1 - nu)/(2 pi G) times the integral of
p/distance for the combined constants, is to be the approach delta; this gives
p0 and the normal force. The integral along x is complete elliptic:
``int sqrt(l^2 - x^2)/sqrt(x^2 + s^2) dx = 2 q (K(m) - E(m))``,
``q^2 = l^2 + s^2``, ``m = l^2/q^2``. "analyn" is closer to the pressure, after
ANALYN (M. Sh. Sichani, R. Enblom, M. Berg, Vehicle Syst. Dyn. 52 (2014) 1752):
with the distance z(s) of the undeformed bodies and the curvature
``B(s) = z/s^2``, which is the other half of Hertz's problem
``delta = A x^2 + B s^2``, the bodies touch where
``(1 + alpha) A x^2 + (1 + beta) z < delta``. There
``1 + alpha = delta/(A a^2)`` and ``1 + beta = delta/(B b^2)`` are those of
Hertz's ellipse, and its p0/a gives the pressure of a strip,
``p0/a sqrt(l(s)^2 - x^2)``. Where B is constant this is Hertz's solution.

The ellipse of the same area, and the same length by width, goes into the fast
theory.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any, ClassVar

import numpy as np

from varcontact import checks
from varcontact.errors import SceneError
from varcontact.kinematics import Creepages, Frame
from varcontact.reference.hertz import approaches, hertz, semi_axes
from varcontact.scene.plausibility import warn_plausibility
from varcontact.theories.creep_forces import TheoryName, creep_forces, formula_of
from varcontact.wheel_rail import plausibility
from varcontact.wheel_rail.bearing_height import BearingHeight
from varcontact.wheel_rail.curve import Curve
from varcontact.wheel_rail.locus import Overlap, overlap
from varcontact.wheel_rail.patches import joined, tangent_of, too_rough
from varcontact.wheel_rail.position import Velocity
from varcontact.wheel_rail.profile_shape import check_sides
from varcontact.wheel_rail.quantities import fast_values
from varcontact.wheel_rail.result import WheelForces
from varcontact.wheel_rail.wear_laws import Archard, ArchardMap
from varcontact.wheel_rail.wheel_geometry import WheelGeometry

EPSILON = 0.55
"""Ratio of the virtual penetration to the approach, Kik and Piotrowski's."""
STRIPS = 60
"""Strips across the overlap, over which the deflection is summed."""
FINER = 16
"""Subdivisions of the distance between circles, for the ends of a patch."""
NEAR = 3
"""Circles to either side of the deepest one over which the distance is too small for a
curvature."""
NORMAL = ("virtual-penetration", "analyn", "hertz")


@dataclass(frozen=True)
class FastEllipse:
    """Ellipse that approximates a patch.

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
        Creepages of the rail over the wheel.
    approach : float
        Depth of the undeformed wheel in the rail [mm].
    ellipse : FastEllipse
    force : ndarray, shape (3,)
        (Fx, Fs, FN) on the rail in the contact frame [N].
    moment : float
        On the rail about the normal [N mm]; NaN by a theory that has none.
    on_rail, on_wheel : ndarray, shape (2,)
        (y, z) of the origin in the coordinates of the profiles [mm].
    rolling_radius : float
        Rolling radius of the undeformed wheel at the origin [mm].
    """

    frame: Frame
    angle: float
    creepage: Creepages
    approach: float
    ellipse: FastEllipse
    force: np.ndarray
    moment: float
    on_rail: np.ndarray
    on_wheel: np.ndarray
    rolling_radius: float
    tilting: ClassVar[np.ndarray] = np.zeros(3)
    """Moment about x and y of the frame's origin: none, the ellipse is in the middle."""

    @property
    def location(self) -> np.ndarray:
        """Origin of the frame in track coordinates [mm]."""
        return self.frame.origin

    @property
    def normal_force(self) -> float:
        """FN [N]."""
        return float(self.force[2])

    @property
    def peak_pressure(self) -> float:
        """Largest pressure [N/mm^2]."""
        return self.ellipse.peak_pressure

    @property
    def half_width(self) -> float:
        """Half the width of the ellipse across the rail [mm]."""
        return self.ellipse.b

    @property
    def area(self) -> float:
        """Area of the ellipse [mm^2]."""
        return math.pi * self.ellipse.a * self.ellipse.b

    @property
    def force_on_track(self) -> np.ndarray:
        """(Fx, Fy, Fz) on the rail in track coordinates [N]."""
        return np.asarray(self.frame.axes @ self.force)

    @property
    def t_gamma(self) -> float:
        """``-(Fx vx + Fs vy + Mz spin)`` [N]; NaN by a theory that has no moment."""
        rolled = self.creepage
        sliding = float(self.force[:2] @ [rolled.vx, rolled.vy])
        return 0.0 - sliding - self.moment * rolled.spin

    @property
    def friction_power(self) -> float:
        """T-gamma at the rolling velocity [W]; NaN by a theory that has no moment."""
        return self.t_gamma * self.creepage.speed / 1e3


@dataclass(frozen=True, eq=False, repr=False)
class FastWheel(WheelForces):
    """All patches of a wheel on a rail by the fast way.

    Attributes
    ----------
    case : WheelGeometry
    z : float
        Height of the axle, downwards [mm].
    patches : tuple of FastPatch
        From left to right.
    """

    case: WheelGeometry
    patches: tuple[FastPatch, ...]

    @property
    def patch_warnings(self) -> tuple[str, ...]:
        """Plausibility warnings of the patches, each once."""
        texts: list[str] = []
        for each in self.patches:
            y = float(each.frame.origin[1])
            texts += plausibility.at_tip(y, each.on_wheel, self.case.wheelset.profile)
        return tuple(dict.fromkeys(texts))

    def quantities(
        self,
        archard: Archard | ArchardMap | None = None,
        yield_in_shear: float | None = None,
    ) -> list[dict[str, float]]:
        """See `WheelRailSolution.quantities`; an estimate has no errors, no wear by `archard`, and
        no shakedown limit by `yield_in_shear`: NaN.
        """
        return [fast_values(each) for each in self.patches]


def estimate_wheel_on_rail(
    case: WheelGeometry, normal: str, tangential: TheoryName, tol: float, options: dict[str, Any]
) -> FastWheel:
    """See `WheelOnRail.estimate`; `options` are those of the theory."""
    warn_plausibility(plausibility.warnings_of(case))
    found = estimated(case, normal, tangential, tol, options)
    warn_plausibility(found.patch_warnings)
    return found


def estimated(
    case: WheelGeometry,
    normal: str = "virtual-penetration",
    tangential: TheoryName = "fastsim",
    tol: float = 1e-6,
    options: dict[str, Any] | None = None,
) -> FastWheel:
    """Estimate of a wheel without plausibility warnings, for searches and tables."""
    options = options or {}
    case.check_bare()
    check_sides(case.track.profile)
    normal = checks.choice("normal", normal, NORMAL)
    tol = checks.positive("tol", tol)
    formula_of(tangential, {name: value for name, value in options.items() if name != "slope"})
    case.friction_at(0.0)  # refused if it is a law

    search = BearingHeight(case, tol)
    while not search.done:
        found = rolling(pressed(case, search.propose(), normal), tangential, options)
        normal_forces = np.sum(
            [each.frame.normal * each.force[2] for each in found.patches], axis=0
        )
        bearing = found.force if case.with_friction else normal_forces
        search.learn(float(bearing[2]))
    return found


def pressed(case: WheelGeometry, z: float, normal: str) -> FastWheel:
    """The patches at a height of the axle, without tangential forces."""
    patches = []
    for group in joined(case.locus.overlaps(z), case.join):
        tangent = tangent_of(group, case.rail)
        approach = max(float(each.depth.max()) for each in group) * float(np.cos(tangent.angle))
        creepage = case.creepage(tangent.frame, approach, z)
        ellipse = fast_ellipse(case, group, z, normal)
        force = np.array([0.0, 0.0, ellipse.normal_force])
        origin = tangent.frame.origin
        on_wheel = case.on_wheel(origin, case.body(z))
        patch = FastPatch(
            frame=tangent.frame,
            angle=tangent.angle,
            creepage=creepage,
            approach=approach,
            ellipse=ellipse,
            force=force,
            moment=0.0,
            on_rail=case.track.on_rail(origin[1:], case.side),
            on_wheel=on_wheel,
            rolling_radius=case.wheelset.radius + float(on_wheel[1]),
        )
        patches.append(patch)
    return FastWheel(case, z, tuple(patches))


def rolling(
    wheel: FastWheel,
    tangential: TheoryName,
    options: dict[str, Any],
    velocity: Velocity | None = None,
) -> FastWheel:
    """The wheel with the creep forces at its velocity, or at another one, by a theory with its
    `options`.
    """
    case = wheel.case
    if velocity is not None:
        case = replace(case, velocity=velocity)
    patches = []
    for each in wheel.patches:
        creepage = each.creepage
        if velocity is not None:
            creepage = case.creepage(each.frame, each.approach, wheel.z)
        friction = case.friction_at(each.angle)
        normal_force = each.ellipse.normal_force
        Fx = Fy = moment = 0.0
        if friction != 0:
            arguments: dict[str, Any] = {
                "a": each.ellipse.a,
                "b": each.ellipse.b,
                "normal_force": normal_force,
                "vx": creepage.vx,
                "vy": creepage.vy,
                "spin": creepage.spin,
                "friction": friction,
            }
            bodies = case.elastic_half_spaces
            forces = creep_forces(tangential, bodies=bodies, **arguments | options)
            Fx = forces.Fx
            Fy = forces.Fy
            moment = forces.Mz
        force = np.array([Fx, Fy, normal_force])
        patches.append(replace(each, creepage=creepage, force=force, moment=moment))
    return FastWheel(case, wheel.z, tuple(patches))


def fast_ellipse(case: WheelGeometry, group: list[Overlap], z: float, normal: str) -> FastEllipse:
    """The ellipse of a patch by one of the methods, from the circle that is deepest in the rail."""
    deepest = max(group, key=lambda each: each.depth.max())
    k = int(deepest.depth.argmax())
    approach = float(deepest.depth[k])
    point = deepest.points[k]
    circle = deepest.run.start + k
    angle = float(deepest.locus.angles[circle])
    radius = float(deepest.locus.curvature_radii[circle])
    if normal == "hertz":
        bent = _relative_curvature(case, point, z)
        contact = hertz(
            radius / np.cos(angle), 1 / bent, case.half_spaces, approach=approach * np.cos(angle)
        )
        return FastEllipse(contact.a, contact.b, contact.force, contact.peak_pressure)
    # with the circles beside, which are above the rail, and those between separate overlaps, which
    # count together
    whole = overlap(deepest.locus, slice(group[0].run.start - 1, group[-1].run.stop + 1), z)
    across = (whole.surface - deepest.surface[k]) @ np.array([np.cos(angle), np.sin(angle)])
    if (np.diff(across) <= 0).any():
        raise too_rough(float(point[1]))
    if normal == "virtual-penetration":
        return _by_virtual_penetration(case, across, whole.depth, approach, angle, radius)
    return _by_hertz_of_each_strip(case, across, whole.depth, approach, angle, radius)


def _relative_curvature(case: WheelGeometry, point: np.ndarray, z: float) -> float:
    """Sum of the curvatures of both profiles at a point [1/mm], which Hertz's contact needs
    positive.
    """
    if not isinstance(case.rail, Curve):
        message = 'normal = "hertz": it is for one profile, and not on rollers; take the other'
        raise SceneError("normal", "hertz", message=message)
    on_rail = case.track.on_rail(point[1:], case.side)
    on_wheel = case.on_wheel(point, case.body(z))
    curvature = float(
        case.track.profile.curvature_at(on_rail[0])
        + case.wheelset.profile.curvature_at(on_wheel[0])
    )
    if not curvature > 0:
        reason = (
            f"normal = 'hertz': at y = {point[1]:.4g} mm the profiles curve away from each other; "
            "take another"
        )
        raise SceneError("normal", "hertz", message=reason)
    return curvature


def _by_virtual_penetration(
    case: WheelGeometry,
    across: np.ndarray,
    depth: np.ndarray,
    approach: float,
    angle: float,
    radius: float,
) -> FastEllipse:
    """Ellipse by virtual penetration (see the module); `depth` is the overlap over the places
    `across` the rail from the deepest point.
    """
    from scipy.special import ellipe, ellipkm1

    step, s, half = _strips(across, 2 * radius * (depth - (1 - EPSILON) * approach), 1)
    ends = s + step * np.array([[-0.5], [0.5]])
    log_integral = ends * (np.log(np.abs(np.where(ends == 0, 1.0, ends))) - 1)
    # the mean of log |s|, which has no bound at the deepest point
    away = np.exp(np.diff(log_integral, axis=0)[0] / step)
    q2 = half**2 + away**2
    felt = step * float(np.sum(2 * np.sqrt(q2) * (ellipkm1(away**2 / q2) - ellipe(half**2 / q2))))
    longest = float(np.sqrt(2 * radius * EPSILON * approach))
    # delta = (1 - nu)/(pi G) * integral of p/distance, both bodies together
    modulus = np.pi * case.bodies.combined_G / (1 - case.bodies.combined_nu)
    by_length = np.full(s.size, approach * np.cos(angle) * modulus / felt)
    return _alike(step, half, longest, by_length)


def _by_hertz_of_each_strip(
    case: WheelGeometry,
    across: np.ndarray,
    depth: np.ndarray,
    approach: float,
    angle: float,
    radius: float,
) -> FastEllipse:
    """Ellipse by Hertz's formulas for each strip (see the module)."""
    cosine = float(np.cos(angle))
    A = np.cos(angle) / (2 * radius)
    z = (approach - depth) * cosine
    # from the lowest point of a parabola through the deepest circles
    k = int(np.abs(across).argmin())
    tilt = z[k + 1] - z[k - 1]
    bend = z[k + 1] + z[k - 1]
    spacing = (across[k + 1] - across[k - 1]) / 2
    across = across + spacing * tilt / (2 * bend)
    lower = tilt**2 / (8 * bend)
    z = z + lower
    delta = approach * cosine + lower
    far = np.abs(np.arange(z.size) - k) > NEAR
    if not far.any():  # a patch of few circles
        contact = hertz(1 / (2 * A), spacing**2 / bend, case.half_spaces, approach=float(delta))
        return FastEllipse(contact.a, contact.b, contact.force, contact.peak_pressure)
    # Hertz's contact at each place across, for a force of 1
    B = np.interp(across, across[far], z[far] / across[far] ** 2)
    ones = np.ones(z.size)
    G = case.bodies.combined_G * ones
    nu = case.bodies.combined_nu * ones
    a, b = semi_axes(ones / (2 * A), 1 / (2 * B), G, nu, ones)
    unit = approaches(a, b, G, nu, ones)
    # strips with these half lengths and pressures
    step, s, half = _strips(across, (delta - unit / (B * b**2) * z) * a**2 / unit, 3)
    return _alike(step, half, float(half.max()), np.interp(s, across, 1.5 / (np.pi * a**2 * b)))


def _strips(
    across: np.ndarray, squares: np.ndarray, degree: int
) -> tuple[float, np.ndarray, np.ndarray]:
    """Width of the strips of a patch, their middles, and their half lengths, by a spline through
    the squares of these.

    The ends lie between the points: the force is to depend smoothly on the height.
    """
    from scipy.interpolate import make_interp_spline

    fit = make_interp_spline(across, squares, k=degree)
    inside = np.flatnonzero(squares > 0)
    ends = []
    for within, beyond in ((inside[0], inside[0] - 1), (inside[-1], inside[-1] + 1)):
        places = np.linspace(across[beyond], across[within], FINER + 1)
        ends.append(float(np.interp(0.0, fit(places), places)))
    step = (ends[1] - ends[0]) / STRIPS
    s = ends[0] + step * (np.arange(STRIPS) + 0.5)
    half = np.sqrt(np.maximum(fit(s), 0.0))
    return step, s[half > 0], half[half > 0]


def _alike(step: float, half: np.ndarray, longest: float, by_length: np.ndarray) -> FastEllipse:
    """The ellipse of the same area and length by width, from pressures by half lengths."""
    area = step * float(np.sum(2 * half))
    width = step * half.size
    a = np.sqrt(area * 2 * longest / (np.pi * width))
    b = np.sqrt(area * width / (np.pi * 2 * longest))
    force = step * np.pi / 2 * float(by_length @ half**2)
    peak = float((by_length * half).max())
    return FastEllipse(float(a), float(b), force, peak)
