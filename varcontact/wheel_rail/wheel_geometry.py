"""A wheel of a moving wheel set on a rail: its contact patches, and the scene of each."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any, ClassVar, Literal, Self, cast

import numpy as np

from varcontact import checks
from varcontact.errors import SceneError
from varcontact.kinematics import Creepages, Frame, RigidBody
from varcontact.kinematics.rigid import creepages_of
from varcontact.scene.bodies import Bodies, BodyPair, Viscoelastic, as_bodies
from varcontact.scene.friction import Coefficient, coefficient
from varcontact.scene.grid import Grid
from varcontact.scene.interface import Thermal, ThirdBody
from varcontact.scene.motion import Steady
from varcontact.scene.scene import Scene
from varcontact.scene.surfaces import SampledDistance
from varcontact.scene.units import MM_N
from varcontact.system.process import changed, lazy_property, on_demand, one_blas_thread
from varcontact.wheel_rail.curve import Curve
from varcontact.wheel_rail.locus import Locus, Overlap, contact_locus, varied_locus
from varcontact.wheel_rail.patches import (
    Interactions,
    ReferenceSurface,
    Sides,
    Tangent,
    interactions_of,
    joined,
    reference_surface,
    tangents_of,
)
from varcontact.wheel_rail.position import Position, Velocity, check_forward, turning_with_track
from varcontact.wheel_rail.regions import FrictionByAngle
from varcontact.wheel_rail.slices import RailSurface, Surface
from varcontact.wheel_rail.track import SIGN, Side, Track, WheelSet

STEEL = Bodies(G=82000.0, nu=0.28)
STIFFEST = 1e6
"""Shear modulus [N/mm^2] above that of any material (diamond has half of it): larger ones are in
Pa."""
FLAT = SampledDistance(np.zeros((1, 1)))
"""Samples over a plane, which have been checked: those of patches are like them."""
STEADY = Steady()
ONE_ELEMENT = Grid(nx=1, ny=1, dx=1.0, dy=1.0, x0=-0.5, y0=-0.5)
MIDDLE = Position()
ROLLING = Velocity()
VARIES = (
    "friction: it varies over a patch, and grids are not chosen for an accuracy then; "
    "give dx and dy"
)
PARTS = {
    "track": Track,
    "wheelset": WheelSet,
    "position": Position,
    "velocity": Velocity,
}
ELEMENT = 0.5
"""Sides of an element [mm] where neither they nor an accuracy are given."""


@dataclass(frozen=True, eq=False, kw_only=True)
class ContactPatch:
    """One contact patch of a wheel on a rail.

    Attributes
    ----------
    location : ndarray, shape (3,)
        Origin of the frame in track coordinates, on the rail's surface [mm].
    angle : float
        Contact angle, about x in track coordinates: negative on the right
        rail's inner side [rad].
    frame : Frame
        x forward, y (also called s) along the rail's surface to the right, z
        into the rail, which is body 1.
    on_rail, on_wheel : ndarray, shape (2,)
        (y, z) of the origin in the coordinates of the profiles [mm].
    rolling_radius : float
        Rolling radius of the undeformed wheel at the origin [mm].
    creepage : Creepages
        Creepages of the rail over the wheel, in the frame, divided by the rolling velocity:
        CONTACT's CKSI, CETA and CPHI.
    approach : float
        Depth of the undeformed wheel in the rail [mm].
    scene : Scene
        The patch as a scene: undeformed distance on the potential contact,
        approach, friction and creepages. Lengths are in mm and forces in N;
        tractions act on the rail.
    interactions : tuple of pairs of float
        Where parts of the patch meet along y, and the weights with which they
        feel each other: none in nearly all patches.
    """

    location: np.ndarray
    angle: float
    frame: Frame
    on_rail: np.ndarray
    on_wheel: np.ndarray
    rolling_radius: on_demand[float] = field(default=on_demand())
    creepage: Creepages
    approach: float
    scene: Scene
    interactions: Interactions

    @property
    def in_plane(self) -> bool:
        """True where its elements lie in one plane."""
        return not self.scene.conformal

    @property
    def seams(self) -> Interactions:
        """Earlier name of `interactions`."""
        return self.interactions


LENGTHS = ("dx", "dy", "join", "separate", "turn")


@dataclass(frozen=True, eq=False, kw_only=True)
class OnTrack(
    checks.Checked,
    **dict.fromkeys(LENGTHS, checks.positive),
    vertical_force=checks.positive,
    z=checks.number,
):
    """Entries that a wheel and a wheel set have in common, see `WheelOnRail`."""

    _words: ClassVar = {
        **dict.fromkeys(("load", "axle_load", "normal_force"), "vertical_force"),
        "rail": "track",
        "wheel": "wheelset",
    }
    track: Track
    wheelset: WheelSet
    position: Position = MIDDLE
    velocity: Velocity = ROLLING
    bodies: Bodies | BodyPair = STEEL
    dx: float | None = None
    dy: float | None = None
    join: float = 4.0
    separate: float = 8.0
    turn: float | None = None
    conformal: Literal["auto"] | bool = "auto"
    vertical_force: float | None = None
    z: float | None = None


@dataclass(frozen=True, eq=False, kw_only=True)
class WheelGeometry(OnTrack, with_friction=checks.flag, slip_by_element=checks.flag):
    """The entries of `WheelOnRail`, checked, and what follows from them without elasticity."""

    side: Side = "right"
    with_friction: bool = True
    friction: Coefficient | FrictionByAngle = 0.3
    slip_by_element: bool = False
    third_body: ThirdBody | None = None
    thermal: Thermal | tuple[Thermal, Thermal] | None = None

    def __post_init__(self) -> None:
        set_ = object.__setattr__
        for name, kind in PARTS.items():
            checks.kind(name, getattr(self, name), kind)
        set_(self, "bodies", _checked_bodies(self.bodies))
        self._check_units_of_bodies()
        set_(self, "side", checks.choice("side", self.side, tuple(SIGN)))
        set_(self, "track", self.track.of_sides[self.side])
        checks.exactly_one(vertical_force=self.vertical_force, z=self.z)
        super().__post_init__()
        if not isinstance(self.friction, FrictionByAngle):
            set_(self, "friction", coefficient("friction", self.friction))
        if self.conformal != "auto":
            set_(self, "conformal", checks.flag("conformal", self.conformal))
        self._check_distances()
        if self.curved and not self._constant:
            reason = (
                "conformal: its curved surface is straight along the rail; "
                "give False where profiles vary"
            )
            raise SceneError("conformal", True, message=reason)

    def _check_units_of_bodies(self) -> None:
        """Refuse shear moduli in Pa, of both bodies or of one; a rigid one is infinite."""
        moduli = [self.bodies.combined_G]
        if isinstance(self.bodies, Bodies):
            moduli += np.atleast_1d(self.bodies.G).tolist()
        for G in moduli:
            if STIFFEST < G < np.inf:
                reason = (
                    f"bodies.G: {G:.3g} N/mm^2 is stiffer than any material: "
                    "give N/mm^2; 1 Pa is 1e-6 N/mm^2"
                )
                raise SceneError("bodies.G", G, message=reason)

    def _check_distances(self) -> None:
        """Refuse distances of patches that do not ascend, and a place beyond the slices."""
        if self.separate < self.join:
            raise SceneError("separate", self.separate, f"at least join, {self.join:g} mm")
        if self.turn is not None and self.turn < self.separate:
            raise SceneError("turn", self.turn, f"at least separate, {self.separate:g} mm")
        if not self.track.constant:
            first = min(each.positions[0] for each in self.track.rails)
            last = max(each.positions[-1] for each in self.track.rails)
            if not first <= self.position.s <= last:
                raise SceneError(
                    "position.s", self.position.s, f"within the slices, {first:g} to {last:g} mm"
                )

    @property
    def _constant(self) -> bool:
        return self.track.constant and self.wheelset.constant

    @lazy_property
    def rail(self) -> Curve | RailSurface:
        """The part of the rail that can be touched, (y, z) in track coordinates; a surface where a
        profile varies.
        """
        if self._constant:
            return self.track.placed(self.side)
        return self.track.surface(self.side, self.position.s)

    @lazy_property
    def wheel(self) -> Curve | Surface:
        """The part of the wheel that can be touched, (y along the axle, radius); a surface where a
        profile varies.
        """
        if self._constant:
            return self.wheelset.placed(self.side)
        return self.wheelset.surface(self.side, self.position.pitch)

    @checks.named_options()
    def sections(
        self, location: np.ndarray, on_wheel: np.ndarray
    ) -> dict[str, tuple[Curve, float]]:
        """Curves of rail and wheel at a `location` in the track, `on_wheel` that of the wheel; and
        its y on each.
        """
        rail = self.rail
        if not isinstance(rail, Curve):
            rail = rail.section(*location[:2].tolist())
        wheel = self.wheel
        if not isinstance(wheel, Curve):
            wheel = wheel.section(float(np.arcsin(location[0] / self.wheelset.radius)))
        axle_y = SIGN[self.side] * (float(on_wheel[0]) + self.wheelset.middle)
        return {"rail": (rail, float(location[1])), "wheel": (wheel, axle_y)}

    @lazy_property
    def locus(self) -> Locus:
        """The contact locus; NoContact if the wheel is beside the rail."""
        axle = np.array([0.0, self.position.y, -self.wheelset.radius])
        if isinstance(self.wheel, Curve) and isinstance(self.rail, Curve):
            return contact_locus(self.wheel, self.rail, self.position.rotation, axle)
        assert isinstance(self.wheel, Surface)
        assert isinstance(self.rail, RailSurface)
        return varied_locus(self.wheel, self.rail, self.position.rotation, axle)

    @property
    def touching(self) -> float:
        """The height of the axle at which the wheel just touches the rail [mm]."""
        return self.locus.touching

    @checks.named_options()
    @one_blas_thread()
    def patches(self, z: float, *, with_grid: bool = True) -> tuple[ContactPatch, ...]:
        """All contact patches at a height of the axle, from left to right.

        Parameters
        ----------
        z : float
            Downwards, see `WheelOnRail` [mm].
        with_grid : bool
            Whether scenes have the grid of `dx` and `dy`; without, samples that
            are interpolated on any grid.

        Raises
        ------
        NoContact
            If the wheel is above the rail, or beside it.
        SceneError
            If the contact reaches the end of a profile, or elements are too
            many.
        """
        z = checks.number("z", z)
        turn = self.turn
        if turn is None:
            turn = 2 * self.separate - self.join
        # overlaps that make one patch each, and their planes
        nearer = self.separate
        if self.curved:
            nearer = turn
        groups = joined(self.locus.overlaps(z), nearer)
        tangents = tangents_of(groups, self.rail, self.separate, turn)
        sides = None
        if with_grid:
            sides = (self.dx or ELEMENT, self.dy or ELEMENT)
        patches = []
        for group, tangent in zip(groups, tangents, strict=True):
            patches.append(self._patch(group, tangent, z, sides))
        return tuple(patches)

    def _patch(
        self, overlaps: list[Overlap], tangent: Tangent, z: float, sides: Sides
    ) -> ContactPatch:
        """The patch of some overlaps with its plane, on elements with `sides`, or on any grid."""
        # undeformed distance
        frame = tangent.frame
        body = self.body(z)
        surface = reference_surface(
            overlaps, tangent, self.wheel, self.rail, body, sides, self.curved
        )
        # creepages, and the interaction of parts
        creepage = self.creepage(frame, surface.approach, z)
        motion = self._motion(frame, creepage, surface, body)
        interactions = interactions_of(overlaps, frame, self.join, self.separate)
        inclination = None
        if self.curved:
            interactions = _at_arc_lengths(interactions, surface)
            inclination = surface.inclination
        # places on the profiles
        on_rail = self.track.on_rail(frame.origin[1:], self.side)
        on_wheel = self.on_wheel(frame.origin, body)
        sections = self.sections(frame.origin, on_wheel)
        # the scene
        grid = surface.grid
        friction = self._friction(
            tangent, sections["rail"][0], grid, inclination, with_grid=sides is not None
        )
        if sides is None:
            sampled = SampledDistance(surface.distance, grid.x, grid.y, inclination=inclination)
        elif self.curved:
            sampled = SampledDistance(surface.distance, inclination=inclination)
        else:
            surface.distance.setflags(write=False)
            sampled = changed(FLAT, h=surface.distance)
        entries: dict[str, Any] = {
            "surface": sampled,
            "approach": surface.approach,
            "friction": friction,
            "motion": motion,
            "grid": "auto" if sides is None else grid,
        }
        if self.curved:  # the turn of the surface is known here
            scene = replace(self._scene, **entries)
        else:
            scene = changed(self._scene, **entries)
        return ContactPatch(
            location=frame.origin,
            angle=tangent.angle,
            frame=frame,
            on_rail=on_rail,
            on_wheel=on_wheel,
            rolling_radius=partial(_height_of_section, *sections["wheel"]),
            creepage=creepage,
            approach=surface.approach,
            scene=scene,
            interactions=interactions,
        )

    @lazy_property
    def _scene(self) -> Scene[Steady]:
        """A patch of one element, whose bodies and interface are checked."""
        surface = FLAT
        motion = STEADY
        if self.curved:
            surface = changed(FLAT, inclination=np.zeros(1))
        if self.curved or self.slip_by_element:
            motion = changed(motion, rigid_slip=np.zeros((2, 1, 1)))
        if self.thermal is not None or self.bodies.relaxes:
            motion = changed(motion, speed=1.0)
        friction: Any = self.friction
        if isinstance(friction, FrictionByAngle):
            friction = 0.0
        return Scene(
            bodies=self.bodies,
            surface=surface,
            approach=1.0,
            friction=friction,
            third_body=self.third_body,
            thermal=self.thermal,
            motion=motion,
            grid=ONE_ELEMENT,
            units=MM_N,
        )

    def _motion(
        self, frame: Frame, creepage: Creepages, surface: ReferenceSurface, body: RigidBody
    ) -> Steady:
        """Rolling with the creepages of a patch, or the rigid slip of its elements."""
        motion = self._scene.motion
        if motion.speed is not None:
            motion = changed(motion, speed=creepage.speed)
        if motion.rigid_slip is not None:
            slip = surface.rigid_slip(frame, self._rail_body, body, self.velocity.speed)
            return changed(motion, rigid_slip=slip)
        return changed(motion, vx=creepage.vx, vy=creepage.vy, spin=creepage.spin)

    @property
    def half_spaces(self) -> Bodies:
        """The bodies; of viscoelastic ones those that they are at once."""
        if isinstance(self.bodies, Bodies):
            return self.bodies
        return self.bodies.surfaces

    @property
    def elastic_half_spaces(self) -> Bodies:
        """The bodies of an estimate; viscoelastic ones are refused."""
        if self.bodies.relaxes:
            raise SceneError("bodies", self.bodies, "elastic half-spaces: estimates are of these")
        return self.half_spaces

    @property
    def tractions_bear_load(self) -> bool:
        """True where tractions carry part of the vertical force, or change the pressures."""
        return self.with_friction or self.bodies.coupled or self.curved

    @property
    def patches_tell(self) -> bool:
        """True where the approach of a patch under a load gives the height that carries it: elastic
        bodies, in a plane.
        """
        return not (self.curved or self.bodies.relaxes)

    @property
    def curved(self) -> bool:
        """True where contacts are on a curved surface."""
        return self.conformal is True

    @property
    def plane_or_curved(self) -> bool:
        """True where the first solution decides between planes and curved surfaces."""
        return self.conformal == "auto"

    def in_planes(self) -> Self:
        """Copy whose contacts are in planes."""
        return replace(self, conformal=False)

    def on_curved_surface(self) -> Self:
        """Copy whose contact is on a curved surface."""
        return replace(self, conformal=True)

    def with_sides(self, dx: float, dy: float) -> Self:
        """Copy on elements with other sides [mm]; the place of the wheel stays."""
        names = ("rail", "wheel", "locus", "_bodies", "_scene")
        same = {name: getattr(self, name) for name in names}
        return changed(self, dx=dx, dy=dy, **same)

    def with_surface_of(self, before: WheelGeometry) -> Self:
        """Copy on a plane or a curved surface as the wheel `before`, where that is left open."""
        if not self.plane_or_curved:
            return self
        return replace(self, conformal=before.curved)

    def check_bare(self) -> None:
        """Refuse a third body or thermal data, which theories do not support here."""
        for name in ("third_body", "thermal"):
            if getattr(self, name) is not None:
                allowed = "left out of an estimate: fast theories have none here"
                raise SceneError(name, "given", allowed)

    def not_in_planes(self, allowed: str) -> SceneError:
        """Error for requests that are supported for contacts in planes only."""
        return SceneError("conformal", self.conformal, allowed)

    def check_in_steps(self, field: str) -> None:
        """Refuse what steps of a history do not support."""
        refused = {
            "conformal": self.curved,
            "slip_by_element": self.slip_by_element,
            "thermal": self.thermal is not None,
        }
        for name, given in refused.items():
            if given:
                allowed = "left out: a history has patches in planes, and no temperatures"
                raise SceneError(f"{field}.{name}", True, allowed)
        rails = self.track.rails
        profiles = [cast(tuple[object, ...], rail.profiles) for rail in rails]
        if len({id(profile) for along in profiles for profile in along}) > 1:
            raise SceneError(f"{field}.track", len(rails), "of one profile along the rail")

    def _friction(
        self,
        tangent: Tangent,
        rail: Curve,
        grid: Grid,
        inclination: np.ndarray | None,
        with_grid: bool,
    ) -> Coefficient | np.ndarray:
        """Coefficients of the elements, by the rail below or the `inclination` of rows of a curved
        surface.
        """
        if not isinstance(self.friction, FrictionByAngle):
            return self.friction
        if inclination is None and self.friction.by_patch:
            angles = np.array([tangent.angle])
        elif inclination is None:
            below = rail.at(tangent.frame.origin[1] + grid.y * tangent.frame.axes[1, 1])
            on_profile = np.isfinite(below)
            angles = np.interp(grid.y, grid.y[on_profile], rail.angles(below[on_profile]))
        else:
            angles = tangent.angle + inclination
        coefficients = self.friction(-SIGN[self.side] * angles)
        if np.ptp(coefficients) == 0:
            return float(coefficients[0])
        if not with_grid:
            raise SceneError("friction", None, message=VARIES)
        return np.repeat(coefficients[:, None], grid.nx, axis=1)

    def friction_at(self, angle: float) -> float:
        """The coefficient of friction at a contact `angle` [rad]: that of a fast theory, which has
        one.
        """
        if isinstance(self.friction, FrictionByAngle):
            return float(self.friction(-SIGN[self.side] * angle))
        if not isinstance(self.friction, float):
            raise SceneError(
                "friction", self.friction, "a number: fast theories have one coefficient"
            )
        return self.friction

    def body(self, z: float, *, pitching: bool = True) -> RigidBody:
        """The wheel set as a rigid body with its axle at a height `z`, `pitching` or not: see
        `Velocity.body`.
        """
        axle = np.array([0.0, self.position.y, z - self.wheelset.radius])
        return changed(self._bodies[pitching], position=axle)

    @lazy_property
    def _bodies(self) -> dict[bool, RigidBody]:
        """The wheel set as a rigid body at the height 0, pitching or not."""
        curve_radius = self.track.curve_radius
        pitching = self.velocity.body(self.wheelset, self.position, 0.0, curve_radius=curve_radius)
        turning = turning_with_track(self.velocity, self.position, curve_radius)
        return {True: pitching, False: changed(pitching, angular_velocity=turning)}

    @property
    def _rail_body(self) -> RigidBody:
        return self.track.rail_body(self.side)

    def on_wheel(self, point: np.ndarray, body: RigidBody) -> np.ndarray:
        """A `point` of the track in the coordinates of the wheel's profile, the wheel set being
        `body`: (y, z) [mm].
        """
        x, y, height = body.locally(point).T
        lateral = SIGN[self.side] * y - self.wheelset.middle
        return np.array([lateral, np.hypot(x, height) - self.wheelset.radius])

    def creepage(self, frame: Frame, approach: float, z: float) -> Creepages:
        """Creepages of the rail over the wheel in a `frame`, whose particle is in the rail by the
        `approach`; axle at `z`.
        """
        body = self.body(z)
        particle = frame.origin + approach * frame.normal
        # contacts move with the wheel set, but do not turn about its axle
        moving = self.body(z, pitching=False).velocity_at(particle)
        check_forward(float(moving[0] - body.velocity_at(particle)[0] / 2))
        bodies = (self._rail_body, body)
        return creepages_of(bodies, (frame.origin, particle), frame, moving)


def _height_of_section(section: Curve, y: float) -> float:
    """The height of a section of the wheel below its axle, which is the rolling radius [mm]."""
    return float(section.points(section.at(np.array([y])))[0, 1])


def _at_arc_lengths(interactions: Interactions, surface: ReferenceSurface) -> Interactions:
    """Interactions at the arc lengths of a curved surface."""
    inside = np.isfinite(surface.lateral)
    places = [y for y, _ in interactions]
    lengths = np.interp(places, surface.lateral[inside], surface.grid.y[inside]).tolist()
    weights = [weight for _, weight in interactions]
    return tuple(zip(lengths, weights, strict=True))


def _checked_bodies(given: Any) -> Bodies | BodyPair:
    """Half-spaces of both bodies, elastic or viscoelastic."""
    bodies = as_bodies(given)
    checks.kind("bodies", bodies, Bodies, BodyPair)
    if isinstance(bodies, BodyPair):
        for name, body in zip(("upper", "lower"), bodies.both, strict=True):
            checks.kind(f"bodies.{name}", body, Bodies, Viscoelastic)
    found: Bodies | BodyPair = bodies
    return found
