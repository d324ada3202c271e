"""Track and wheel set: their dimensions, and the places of rails and wheels.

Track coordinates: x forward, y to the right, z down; the origin is in the
middle of the track at the height of the rail tops. Lengths are in millimetres.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import partial
from typing import Any, ClassVar, Literal

import numpy as np

from varcontact import checks
from varcontact.errors import SceneError
from varcontact.kinematics import RigidBody, rotation
from varcontact.system.process import lazy_property
from varcontact.wheel_rail.curve import Curve
from varcontact.wheel_rail.position import angle
from varcontact.wheel_rail.profile import Profile
from varcontact.wheel_rail.profile_shape import flange
from varcontact.wheel_rail.slices import ProfileSlices, RailSurface, Surface, sliced, surface_of

Side = Literal["left", "right"]
SIGN: dict[Side, float] = {"left": -1.0, "right": 1.0}
NUMBERS = ("y", "z", "lateral", "vertical", "roll_rate")
TO_RUNNING_CIRCLE = 70.0
"""Distance of the running circle from the flange's back [mm]."""
WIDEST_FLANGE = 40.0
"""Largest distance from the back of a flange to its tip [mm]."""
ROLLER_REACH = 50.0
"""Distance from the top of a roller up to which its surface is described [mm]."""
ROLLER_SLICES = 101
FINE = 0.02
"""Step along the profile in the search for the gauge point [mm]."""


@dataclass(frozen=True, kw_only=True)
class Irregularity(
    checks.Checked, path="irregularity", roll=angle, **dict.fromkeys(NUMBERS, checks.number)
):
    """Displacement of a rail from its place in the track, and its velocity.

    Parameters
    ----------
    y, z : float
        To the right, and down [mm].
    roll : float
        About the origin of the rail's profile, right side down [rad].
    lateral, vertical : float
        Velocity of the rail's material [mm/s]: of a rail that gives way, not of
        one that lies crooked.
    roll_rate : float
        [rad/s]

    Raises
    ------
    SceneError
        If a number is not finite, or the roll more than half a radian.
    """

    _words: ClassVar = {"dy": "y", "dz": "z", "vy": "lateral", "vz": "vertical"}
    y: float = 0.0
    z: float = 0.0
    roll: float = 0.0
    lateral: float = 0.0
    vertical: float = 0.0
    roll_rate: float = 0.0


IN_PLACE = Irregularity()


@dataclass(frozen=True, eq=False, kw_only=True)
class Track(
    checks.Checked, path="track", gauge=checks.number, gauge_height=checks.at_least_zero, cant=angle
):
    """Two rails.

    Parameters
    ----------
    rail : Profile, ProfileSlices, or tuple of these
        On both sides. Of several rails under one wheel, as the wing and the
        nose of a crossing, in one coordinate system, the highest counts; each
        ends with its slices where another one goes on. Gauge and rail tops are
        those of the first slice of the first one.
    gauge : float
        Distance of the rails' inner sides [mm]: negative where a rail is in the
        middle, as under the only wheel of a test rig.
    gauge_height : float
        Depth below the rail top down to which the gauge is measured [mm]:
        between the innermost points not deeper. 0: between the highest points,
        for rails that have no side towards the middle of the track.
    cant : float
        Inclination of the rails towards the middle of the track, on top of what
        the profile has in itself [rad]. The rail of the Manchester benchmark's
        file is inclined by 1:40 already; that of `Profile.rail_60e1` is not.
    curve_radius : float
        Curve radius of the middle of the track [mm]: positive in a curve to the right,
        infinite on straight track.
    left, right : Irregularity
        Irregularity of each rail.
    left_rail, right_rail : Profile, ProfileSlices, or tuple of these, optional
        Rail of one side where it differs, as in a switch; gauge and
        rail top are those of its own first slice.
    roller_radius : float, optional
        Radius of rollers in place of the rails: from their axle, which is across the
        track, to their top [mm].
    roller_rate : float
        About their axle [rad/s]: positive where their tops move backwards, as
        those of rails do under a wheel set that rolls forward. Give the wheel
        set ``roller_rate * roller_radius`` as its speed: track coordinates move
        with it.
    stiffness : pair of float, optional
        Force by which each rail is moved 1 mm to the side, and down, in the
        equilibrium of `WheelSetOnTrack` [N/mm]: infinite if not given.

    Raises
    ------
    SceneError
        If the profile is no rail's, a height is not positive, the cant is more
        than half a radian, the profile does not reach down to the gauge height,
        or the curve is tighter than the track is wide.

    Examples
    --------
    >>> track = Track(rail=Profile.rail_60e1(), cant=1 / 40)
    >>> inner = track.placed("right").points(track.placed("right").s)[:, 0].min()
    >>> print(f"{track.gauge / 2:.1f} {inner < 717.5}")
    717.5 True
    """

    _words: ClassVar = {
        "inclination": "cant",
        "profile": "rail",
        "width": "gauge",
        "radius": "curve_radius",
    }
    rail: Profile | ProfileSlices | tuple[Profile | ProfileSlices, ...]
    gauge: float = 1435.0
    gauge_height: float = 14.0
    cant: float = 0.0
    curve_radius: float = np.inf
    left: Irregularity = IN_PLACE
    right: Irregularity = IN_PLACE
    roller_radius: float | None = None
    roller_rate: float = 0.0
    stiffness: tuple[float, float] | None = None
    left_rail: Profile | ProfileSlices | tuple[Profile | ProfileSlices, ...] | None = None
    right_rail: Profile | ProfileSlices | tuple[Profile | ProfileSlices, ...] | None = None

    def __post_init__(self) -> None:
        set_ = object.__setattr__
        for name in ("rail", "left_rail", "right_rail"):
            given = getattr(self, name)
            if given is not None or name == "rail":
                _check_profile(f"track.{name}", given, "rail")
                set_(self, name, tuple(given) if isinstance(given, list) else given)
        super().__post_init__()
        if self.roller_radius is not None:
            set_(self, "roller_radius", checks.positive("track.roller_radius", self.roller_radius))
            if self.roller_radius <= ROLLER_REACH or not self._round:
                allowed = f"more than {ROLLER_REACH:g} mm, and rails of one profile"
                raise SceneError("track.roller_radius", self.roller_radius, allowed)
        set_(self, "roller_rate", checks.number("track.roller_rate", self.roller_rate))
        set_(self, "curve_radius", checks.real("track.curve_radius", self.curve_radius))
        if not abs(self.curve_radius) > self.gauge:
            allowed = (
                f"larger than the gauge, {self.gauge:g} mm: "
                "positive to the right, negative to the left"
            )
            raise SceneError("track.curve_radius", self.curve_radius, allowed)
        if self.stiffness is not None:
            stiffness = checks.positives("track.stiffness", self.stiffness)
            if stiffness.shape != (2,):
                raise checks.wrong_shape(
                    "track.stiffness", stiffness.shape, "two numbers, lateral and vertical"
                )
            set_(self, "stiffness", tuple(stiffness.tolist()))
        for side in SIGN:
            checks.kind(f"track.{side}", getattr(self, side), Irregularity)
        _ = self.origin, self.of_sides  # which check the gauge, and the rails of each side

    @lazy_property
    def of_sides(self) -> dict[Side, Track]:
        """Tracks with the rails of one side each; the track itself, if both sides have the same."""
        if self.left_rail is self.right_rail is None:
            return dict.fromkeys(SIGN, self)
        rails: dict[Side, Any] = {
            "left": self.left_rail or self.rail,
            "right": self.right_rail or self.rail,
        }
        return {
            side: replace(self, rail=rail, left_rail=None, right_rail=None)
            for side, rail in rails.items()
        }

    @property
    def _round(self) -> bool:
        """True where each rail has a single profile, from which a roller can be made."""
        given = (self.rail, self.left_rail, self.right_rail)
        return all(each is None or isinstance(each, Profile) for each in given)

    @lazy_property
    def rails(self) -> tuple[ProfileSlices, ...]:
        """Rails under one wheel; a roller's surface falls before and behind its top."""
        if self.roller_radius is not None:
            assert isinstance(self.rail, Profile)
            s = np.linspace(-ROLLER_REACH, ROLLER_REACH, ROLLER_SLICES)
            depth = self.roller_radius - np.sqrt(self.roller_radius**2 - s**2)
            return (ProfileSlices(profiles=self.rail, positions=s, z=depth),)
        if isinstance(self.rail, tuple):
            return tuple(map(sliced, self.rail))
        return (sliced(self.rail),)

    @property
    def profile(self) -> Profile:
        """Profile from which gauge and rail tops are measured."""
        return self.rails[0].first

    @property
    def constant(self) -> bool:
        """True if both rails are one profile along the track."""
        return (
            self.left_rail is self.right_rail is None
            and len(self.rails) == 1
            and self.rails[0].constant
        )

    @property
    def mirrored(self) -> bool:
        """True if the left rail is the mirror image of the right one."""
        left = self.left
        right = self.right
        same_rails = self.left_rail is self.right_rail is None
        return same_rails and (left.y, left.z, left.roll) == (-right.y, right.z, -right.roll)

    @lazy_property
    def origin(self) -> np.ndarray:
        """Origin of the right rail's profile, (y, z) in track coordinates [mm]."""
        curve = self.profile.curve.moved(rotation(roll=-self.cant)[1:, 1:], np.zeros(2))
        points = curve.points(curve.sampled(FINE))
        points = points[: int(points[:, 1].argmin()) + 1]  # from the track side to the top
        depth = points[:, 1] - points[-1, 1]
        if depth.max() < self.gauge_height:
            allowed = (
                f"at most {depth.max():.3g} mm, where the rail's profile, "
                f"{np.ptp(self.profile.y):.3g} mm wide, ends on the track side; "
                "0 measures the gauge between the highest points"
            )
            if self.profile.exchanged_sides:
                allowed += f"; {self.profile.exchanged_sides}"
            raise SceneError("track.gauge_height", self.gauge_height, allowed)
        if self.gauge_height == 0:
            return np.array([self.gauge / 2, 0.0]) - points[-1]
        deep = int(np.flatnonzero(depth >= self.gauge_height)[-1])
        part = (self.gauge_height - depth[deep + 1]) / (depth[deep] - depth[deep + 1])
        at_height = points[deep + 1, 0] + part * (points[deep, 0] - points[deep + 1, 0])
        innermost = min(float(at_height), float(points[deep + 1 :, 0].min()))
        return np.array([self.gauge / 2 - innermost, -points[-1, 1]])

    def placed(self, side: Side) -> Curve:
        """The part of the rail on a `side` that can be touched: a curve (y, z) in track
        coordinates, y growing.

        SceneError for slices, which have no such curve, unless all are one profile.
        """
        if not self.constant:
            raise SceneError(
                "track.rail", self.rail, "one profile along the track, the same on both sides"
            )
        return self._placed[side]

    @lazy_property
    def _placed(self) -> dict[Side, Curve]:
        """Curves of the rails that `placed` returns, by side: the same for all wheels on the
        track.
        """
        return {side: self._in_track(self.profile, side).highest() for side in SIGN}

    def _in_track(self, profile: Profile, side: Side) -> Curve:
        matrix, shift = self._motions[side]
        curve = profile.curve
        if side == "left":
            curve = curve.mirrored
        return curve.moved(matrix * [SIGN[side], 1.0], shift)

    def surface(self, side: Side, s: float) -> RailSurface:
        """Surface of all rails on a `side`, in track coordinates, x from a place `s` along the
        track.
        """
        placed = partial(self._in_track, side=side)
        return RailSurface(
            tuple(surface_of(each, placed, -s, backwards=side == "left") for each in self.rails)
        )

    @lazy_property
    def _motions(self) -> dict[Side, tuple[np.ndarray, np.ndarray]]:
        """Matrix and shift from (y, z) of the profile to those of the track, by its side."""
        return {"left": self._motion("left"), "right": self._motion("right")}

    def _motion(self, side: Side) -> tuple[np.ndarray, np.ndarray]:
        """Matrix and shift on a side: canted, mirrored, and out of place."""
        given: Irregularity = getattr(self, side)
        mirror = np.array([SIGN[side], 1.0])
        turned = rotation(roll=given.roll)[1:, 1:] * mirror
        return turned @ rotation(roll=-self.cant)[1:, 1:], self.origin * mirror + [given.y, given.z]

    def rail_body(self, side: Side) -> RigidBody:
        """The rail or roller on a `side` as a rigid body, with the velocities of its
        irregularity.
        """
        return self._rail_bodies[side]

    @lazy_property
    def _rail_bodies(self) -> dict[Side, RigidBody]:
        return {side: self._rail_body(side) for side in SIGN}

    def _rail_body(self, side: Side) -> RigidBody:
        given: Irregularity = getattr(self, side)
        if self.roller_radius is not None:
            return RigidBody(
                position=np.array([0.0, 0.0, self.roller_radius]),
                velocity=np.array(
                    [self.roller_radius * self.roller_rate, given.lateral, given.vertical]
                ),
                angular_velocity=np.array([given.roll_rate, self.roller_rate, 0.0]),
            )
        return RigidBody(
            position=np.array([0.0, *self._motions[side][1]]),
            velocity=np.array([0.0, given.lateral, given.vertical]),
            angular_velocity=np.array([given.roll_rate, 0.0, 0.0]),
        )

    def on_rail(self, point: np.ndarray, side: Side) -> np.ndarray:
        """A `point` (y, z) of the track in the coordinates of the profile on a `side`, before
        canting [mm].
        """
        matrix, shift = self._motions[side]
        return np.asarray((point - shift) @ matrix)


@dataclass(frozen=True, eq=False, kw_only=True)
class WheelSet(
    checks.Checked,
    path="wheelset",
    radius=checks.positive,
    **dict.fromkeys(("inside_distance", "flange_back"), checks.number),
):
    """Two wheels of the same profile on an axle.

    Parameters
    ----------
    wheel : Profile or ProfileSlices
        Slices of a wheel that is out of round.
    radius : float
        Nominal radius of the wheels, where the profile's z is 0 [mm].
    inside_distance : float
        Distance of the flange backs [mm]; of the only wheel of a test rig, whose
        profile is in the middle of the axle, twice `flange_back`.
    flange_back : float
        y of the flange back in the wheel's profile [mm].

    Raises
    ------
    SceneError
        If the profile is no wheel's, a length is not positive, the radius
        smaller than the profile is high, or the flange's back not where its
        flange is.

    Examples
    --------
    >>> wheelset = WheelSet(wheel=Profile.s1002())
    >>> print(wheelset.middle)
    750.0
    """

    _words: ClassVar = {
        "profile": "wheel",
        "nominal_radius": "radius",
        "back_to_back": "inside_distance",
    }
    wheel: Profile | ProfileSlices
    radius: float = 460.0
    inside_distance: float = 1360.0
    flange_back: float = -70.0

    def __post_init__(self) -> None:
        _check_profile("wheelset.wheel", self.wheel, "wheel")
        super().__post_init__()
        if self.inside_distance < 0 and self.middle < 0:
            allowed = "zero or positive, or twice flange_back of a single wheel"
            raise SceneError("wheelset.inside_distance", self.inside_distance, allowed)
        smallest = self.radius + float(self.profile.z.min())
        if smallest <= 0:
            allowed = (
                f"in millimetres: where the wheel's profile is highest it leaves {smallest:.3g} mm"
            )
            raise SceneError("wheelset.radius", self.radius, allowed)
        tip = flange_tip(self.profile)
        if tip is not None and not 0 <= tip - self.flange_back <= WIDEST_FLANGE:
            allowed = (
                "the y of the flange's back in the coordinates of the profile: "
                f"its tip is at y = {tip:.4g} mm"
            )
            raise SceneError("wheelset.flange_back", self.flange_back, allowed)

    @lazy_property
    def _slices(self) -> ProfileSlices:
        return sliced(self.wheel)

    @property
    def profile(self) -> Profile:
        """The wheel's profile, or its first slice."""
        return self._slices.first

    @property
    def constant(self) -> bool:
        """True if the wheel is round."""
        return self._slices.constant

    @property
    def running_circle(self) -> float:
        """y of the running circle in the wheel's profile, 70 mm from the flange's back [mm]."""
        return self.flange_back + TO_RUNNING_CIRCLE

    @property
    def middle(self) -> float:
        """Distance of a wheel profile's origin from the middle of the axle [mm]."""
        return self.inside_distance / 2 - self.flange_back

    def placed(self, side: Side) -> Curve:
        """The part of the wheel on a `side` that can be touched: (y from the middle of the axle,
        radius), y growing.

        SceneError for a wheel out of round.
        """
        if not self.constant:
            raise SceneError("wheelset.wheel", self.wheel, "a round wheel")
        return self._placed[side]

    @lazy_property
    def _placed(self) -> dict[Side, Curve]:
        """Curves of the wheels that `placed` returns, by side: the same in all positions."""
        return {side: self._on_axle(self.profile, side) for side in SIGN}

    def _on_axle(self, profile: Profile, side: Side) -> Curve:
        curve = profile.running.moved(np.eye(2), np.array([self.middle, self.radius]))
        if side == "left":
            curve = curve.mirrored
        return curve

    def surface(self, side: Side, pitch: float) -> Surface:
        """Surface of the wheel on a `side`, turned by `pitch`: (y from the middle of the axle,
        radius) over the angle.
        """
        return surface_of(
            self._slices, partial(self._on_axle, side=side), pitch, backwards=side == "left"
        )


def flange_tip(profile: Profile) -> float | None:
    """y of the tip of a wheel's flange [mm]; None for a wheel without one."""
    if flange(profile.y, profile.z) >= 0:
        return None
    return float(profile.y[profile.z.argmax()])


def _check_profile(field: str, given: Any, kind: str) -> None:
    """Refuse all but a profile of a kind, or slices; a rail may have several of them."""
    allowed = f"a Profile of kind {kind!r}, or slices of that"
    several = kind == "rail" and isinstance(given, tuple | list) and given
    for each in given if several else (given,):
        if not isinstance(each, Profile | ProfileSlices):
            raise SceneError(field, each, allowed)
        if each.kind != kind:
            raise SceneError(field, f"a {each.kind}'s", allowed)
