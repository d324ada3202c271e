"""Dimensions of profiles in service: flange, wear of a rail's head, clearance of flanges."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from varcontact import checks
from varcontact.errors import SceneError
from varcontact.wheel_rail.profile import Profile
from varcontact.wheel_rail.profile_files import Kind
from varcontact.wheel_rail.profile_shape import flange
from varcontact.wheel_rail.track import SIGN, TO_RUNNING_CIRCLE, Track, WheelSet

STEP = 0.01
"""Distance of samples along a profile [mm]."""
AT_CORNER = np.radians(-45.0)
"""Inclination of the gauge corner where wear at 45 degrees is measured [rad]."""


@dataclass(frozen=True)
class FlangeDimensions:
    """Dimensions of a wheel's flange, as in EN 15313.

    Attributes
    ----------
    height : float
        Sh, of the tip above the running circle [mm].
    thickness : float
        Sd, from the flange's back to its face, 10 mm above the running circle
        [mm].
    qR : float
        Horizontal distance of the face there from the face 2 mm below the tip
        [mm].
    """

    height: float
    thickness: float
    qR: float


@dataclass(frozen=True)
class RailWear:
    """Wear of a rail's head against its nominal profile; positive where material is missing.

    Attributes
    ----------
    vertical : float
        W1, at the highest point of the nominal profile [mm].
    side : float
        W2, horizontal, on the track side, 14 mm below that point [mm].
    at_45 : float
        W3, along the normal of the nominal gauge corner at 45 degrees [mm].
    area : float
        Area of the head above those 14 mm [mm^2].
    """

    vertical: float
    side: float
    at_45: float
    area: float


@dataclass(frozen=True)
class FlangeClearance:
    """Play of a wheel set in a track.

    Attributes
    ----------
    gauge : float
        Track gauge [mm].
    over_flanges : float
        Distance of the flanges' faces, 10 mm above the running circles [mm].
    clearance : float
        From the middle to the contact of a flange, half the difference [mm].
    """

    gauge: float
    over_flanges: float
    clearance: float


@checks.named_options()
def flange_dimensions(
    wheel: Profile,
    *,
    back: float = -70.0,
    running_circle: float | None = None,
    above: float = 10.0,
    below_tip: float = 2.0,
) -> FlangeDimensions:
    """Height, thickness and qR of a flange.

    Parameters
    ----------
    wheel : Profile
        Upright, its flange at negative y.
    back : float
        y of the flange's back [mm].
    running_circle : float, optional
        y of the running circle [mm]; by default 70 mm from the back.
    above : float
        Height above the running circle of the thickness [mm].
    below_tip : float
        Depth below the tip of the upper point of qR [mm].

    Raises
    ------
    SceneError
        For a profile without a flange at negative y, and where it does not
        reach these places.

    Examples
    --------
    >>> flange = flange_dimensions(Profile.s1002())
    >>> print(f"{flange.height:.2f} {flange.thickness:.2f} {flange.qR:.2f} mm")
    28.00 32.50 10.79 mm
    """
    _check_profile("wheel", wheel, "wheel")
    if flange(wheel.y, wheel.z) != -1:
        raise SceneError("wheel", wheel.name or "a profile", "a wheel with a flange at negative y")
    back = checks.number("back", back)
    circle = back + TO_RUNNING_CIRCLE
    if running_circle is not None:
        circle = checks.number("running_circle", running_circle)
    tread = float(wheel.z_at(circle))
    if np.isnan(tread):
        raise SceneError("running_circle", circle, "a y of the part that can be touched [mm]")
    y, z = _samples(wheel)
    tip = float(z.max())
    levels = {
        "above": tread + checks.positive("above", above),
        "below_tip": tip - checks.positive("below_tip", below_tip),
    }
    face = slice(int(z.argmax()), None)
    lower, upper = (_first_at(y[face], z[face], *level) for level in levels.items())
    return FlangeDimensions(height=tip - tread, thickness=lower - back, qR=lower - upper)


def _first_at(y: np.ndarray, z: np.ndarray, field: str, level: float) -> float:
    """y where z first falls below a level from the flange's tip."""
    under = np.flatnonzero(z <= level)
    if under.size == 0 or under[0] == 0:
        allowed = "a height between the running circle and the tip, which the flange's face has"
        raise SceneError(field, level, allowed)
    i = int(under[0])
    part = (z[i - 1] - level) / (z[i - 1] - z[i])
    return float(y[i - 1] + part * (y[i] - y[i - 1]))


@checks.named_options()
def rail_wear(worn: Profile, nominal: Profile, *, gauge_height: float = 14.0) -> RailWear:
    """Wear of a rail's head against its nominal profile.

    Parameters
    ----------
    worn : Profile
        In the place of the nominal one: see `Profile.aligned`, over a part that
        does not wear, such as the field side.
    nominal : Profile
    gauge_height : float
        Depth below the highest point of `nominal` of the side wear, and of the
        head whose area counts [mm].

    Raises
    ------
    SceneError
        Where a profile does not reach one of these places.

    Examples
    --------
    >>> nominal = Profile.rail_60e1()
    >>> wear = rail_wear(nominal.shifted(y=1.0, z=2.0), nominal)
    >>> print(f"{wear.vertical:.2f} {wear.side:.2f} {wear.at_45:.2f} mm, {wear.area:.0f} mm^2")
    2.00 1.30 2.14 mm, 143 mm^2
    """
    _check_profile("worn", worn, "rail")
    _check_profile("nominal", nominal, "rail")
    below = checks.positive("gauge_height", gauge_height)
    reference = _samples(nominal)
    actual = _samples(worn)
    top = int(reference[1].argmin())
    level = float(reference[1][top]) + below
    # at 45 degrees on the gauge corner, between the top and the level
    corner = nominal.running.sampled(STEP)
    slopes = nominal.running.angles(corner)
    steep = np.flatnonzero(slopes <= AT_CORNER)
    if steep.size == 0:
        raise SceneError("nominal", nominal.name or "a rail", "with a gauge corner of 45 degrees")
    point = nominal.running.points(corner[steep[-1]])
    return RailWear(
        vertical=_along(actual, reference[:, top], np.array([0.0, 1.0])),
        side=_track_side(actual, level) - _track_side(reference, level),
        at_45=_along(actual, point, np.array([1.0, 1.0]) / np.sqrt(2.0)),
        area=_area_above(reference, level) - _area_above(actual, level),
    )


def _along(samples: np.ndarray, point: np.ndarray, direction: np.ndarray) -> float:
    """Distance along a direction from a point to the nearest crossing of a profile."""
    apart = samples - point[:, None]
    across = direction[0] * apart[1] - direction[1] * apart[0]
    far = direction @ apart
    crossing = np.flatnonzero(across[:-1] * across[1:] <= 0)
    if crossing.size == 0:
        y, z = point.tolist()
        allowed = f"a profile that reaches the normal at y = {y:.4g}, z = {z:.4g} mm"
        raise SceneError("worn", (y, z), allowed)
    span = across[crossing] - across[crossing + 1]
    part = across[crossing] / np.where(span == 0, 1.0, span)
    places = far[crossing] + part * (far[crossing + 1] - far[crossing])
    return float(places[np.abs(places).argmin()])


def _track_side(samples: np.ndarray, level: float) -> float:
    """y of the profile on its track side at a height."""
    y, z = samples
    top = int(z.argmin())
    lower = np.flatnonzero(z[: top + 1] >= level)
    if lower.size == 0:
        raise SceneError("gauge_height", level, "a depth that both profiles have on the track side")
    i = int(lower[-1])
    part = (z[i] - level) / (z[i] - z[i + 1])
    return float(y[i] + part * (y[i + 1] - y[i]))


def _area_above(samples: np.ndarray, level: float) -> float:
    """Area between the profile and a level below it; the field side may end above that."""
    y, z = samples
    height = np.maximum(level - z, 0.0)
    return float(np.sum((height[1:] + height[:-1]) / 2 * np.diff(y)))


@checks.named_options()
def flange_clearance(track: Track, wheelset: WheelSet) -> FlangeClearance:
    """Play between the flanges of a wheel set and the rails, by their gauges.

    Parameters
    ----------
    track : Track
        Its gauge is measured 14 mm below the rails' top by default; rails
        that are displaced sideways widen it, rolled ones are refused.
    wheelset : WheelSet
        Its flanges are measured 10 mm above their running circles, 70 mm from
        the back.

    Raises
    ------
    SceneError
        For rails that are rolled, and see `flange_dimensions`.

    Examples
    --------
    >>> track = Track(rail=Profile.rail_60e1(), cant=1 / 40)
    >>> play = flange_clearance(track, WheelSet(wheel=Profile.s1002()))
    >>> print(f"{play.over_flanges:.2f} mm over flanges, {play.clearance:.2f} mm to each side")
    1425.00 mm over flanges, 5.00 mm to each side
    """
    checks.kind("track", track, Track)
    checks.kind("wheelset", wheelset, WheelSet)
    flanges = flange_dimensions(wheelset.profile, back=wheelset.flange_back)
    over = wheelset.inside_distance + 2 * flanges.thickness
    for side in SIGN:
        roll = getattr(track, side).roll
        if roll != 0:
            raise SceneError(f"track.{side}.roll", roll, "0: a gauge is of upright rails")
    gauge = track.gauge + track.right.y - track.left.y
    return FlangeClearance(gauge=gauge, over_flanges=over, clearance=(gauge - over) / 2)


def _samples(profile: Profile) -> np.ndarray:
    """Points of the whole curve, shape (2, n)."""
    return profile.curve.points(profile.curve.sampled(STEP)).T


def _check_profile(field: str, given: object, kind: Kind) -> None:
    checks.kind(field, given, Profile)
    assert isinstance(given, Profile)
    if given.kind != kind:
        raise SceneError(field, f"a {given.kind}'s profile", f"a {kind}'s profile")
