"""Rolling radius difference and equivalent conicity as in EN 15302.

Wheels and rails are rigid, and the axle is level and square to
the track. Displaced by y, the wheel set turns towards the smaller radius, so
that along the distance rolled

    y'' = -(r_right(y) - r_left(y)) / (e R),

with the distance e of the nominal circles and their radius R. The equivalent
conicity for an amplitude is that of the cones whose motion, Klingel's, is as
long a wave: ``2 e R (pi / wavelength)^2``.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from varcontact import checks
from varcontact.errors import SceneError
from varcontact.wheel_rail.locus import contact_locus
from varcontact.wheel_rail.track import Side, Track, WheelSet

STEP = 0.05
"""Distance of displacements whose rolling radius difference is computed [mm]; between them it is
linear."""
PHASES = 400
"""Points of a quarter of a wave."""


@checks.named_options()
def rolling_radius_difference(track: Track, wheelset: WheelSet, y: Any) -> Any:
    """Rolling radius of the right wheel less that of the left, both where they touch first.

    Parameters
    ----------
    track : Track
    wheelset : WheelSet
    y : float or array_like
        Lateral displacements, to the right [mm].

    Returns
    -------
    float or ndarray
        In the shape of y [mm].

    Raises
    ------
    SceneError
        If a displacement is not finite, or the wheels touch at the end of a
        profile.
    NoContact
        If a wheel is beside the rail.

    Examples
    --------
    >>> from varcontact.wheel_rail import Profile
    >>> track = Track(rail=Profile.rail_60e1(), cant=1 / 40)
    >>> wheelset = WheelSet(wheel=Profile.s1002())
    >>> print(rolling_radius_difference(track, wheelset, [1.0, 3.0, 5.0]).round(2))
    [0.61 0.94 1.45]
    """
    checks.kind("track", track, Track)
    checks.kind("wheelset", wheelset, WheelSet)
    places = checks.numbers("y", y)
    # the top of a roller is a rail
    track = replace(track, roller_radius=None, roller_rate=0.0)
    right, left = (
        np.array([_radius(track.of_sides[side], wheelset, side, y) for y in places.flat])
        for side in ("right", "left")
    )
    return _like(places, (right - left).reshape(places.shape))


def _radius(track: Track, wheelset: WheelSet, side: Side, y: float) -> float:
    """Radius of the wheel on a `side` where it touches first."""
    wheel = wheelset.placed(side)
    rail = track.placed(side)
    locus = contact_locus(wheel, rail, np.eye(3), np.array([0.0, y, -wheelset.radius]))
    nearest = int(locus.gap.argmin())
    gap = np.pad(locus.gap, 1, constant_values=np.inf)
    before, least, after = gap[nearest : nearest + 3]
    if not np.isfinite(before + after):
        raise SceneError("y", y, message=f"y = {y:g} mm: the wheel touches at the end of a profile")
    # at the lowest point of a parabola through the nearest circles
    step = locus.s[nearest] - locus.s[nearest - 1]
    bend = before - 2 * least + after
    beside = 0.0
    if bend > 0:
        beside = step * (before - after) / (2 * bend)
    return float(wheel.points(locus.s[nearest] + beside)[1])


def _like(given: np.ndarray, values: np.ndarray) -> Any:
    """Values as an array, or as a number where a number is given."""
    if given.ndim:
        return values
    return float(values)


@checks.named_options()
def equivalent_conicity(track: Track, wheelset: WheelSet, amplitude: Any) -> Any:
    """The conicity of the wheel set whose motion is as long a wave, by EN 15302.

    Parameters
    ----------
    track : Track
    wheelset : WheelSet
    amplitude : float or array_like
        Amplitude of the lateral motion [mm]; usually 3 mm.

    Returns
    -------
    float or ndarray
        In the shape of the amplitude [-]: 0 where nothing turns the wheel set
        back. Negative where it is turned away from the middle, as with hollow
        wheels: minus the conicity of the opposite difference of the radii.
        Where it is turned away on part of the way, so that it does not come
        back to the middle from there, that of harmonic linearisation,
        ``2/(pi a)`` times the integral of ``difference(a sin(t)) sin(t)`` over
        a quarter of the wave.

    Raises
    ------
    SceneError, NoContact
        See `rolling_radius_difference`; for an amplitude that is not positive,
        and for rails that are no mirror images of each other.

    Examples
    --------
    >>> from varcontact.wheel_rail import Profile
    >>> track = Track(rail=Profile.rail_60e1(), cant=1 / 40)
    >>> wheelset = WheelSet(wheel=Profile.s1002())
    >>> print(f"{equivalent_conicity(track, wheelset, 3.0):.2f}")
    0.17
    """
    from scipy.interpolate import make_interp_spline

    checks.kind("track", track, Track)
    if not track.mirrored:
        message = "track: a conicity is of a track whose rails are mirror images of each other"
        raise SceneError("track", (track.left, track.right), message=message)
    wanted = checks.positives("amplitude", amplitude)
    if not wanted.size:
        return wanted
    nodes = np.linspace(0.0, wanted.max(), int(np.ceil(wanted.max() / STEP)) + 1)
    difference = rolling_radius_difference(track, wheelset, nodes)
    between = make_interp_spline(nodes, difference, k=1)
    work = between.antiderivative()
    phase = (np.arange(PHASES) + 0.5) / PHASES * np.pi / 2
    y = wanted[..., None] * np.sin(phase)
    quickest = wanted[..., None] * np.cos(phase)
    left = work(wanted)[..., None] - work(y)
    # of the wave; where there is none, of that of the opposite difference; else linearised
    conicity = _of_wave(left, quickest)
    turned_away = -_of_wave(-left, quickest)
    linearised = np.mean(between(y) * np.sin(phase), axis=-1) / wanted
    conicity = np.where(np.isnan(conicity), turned_away, conicity)
    conicity = np.where(np.isnan(conicity), linearised, conicity)
    return _like(wanted, conicity)


def _of_wave(left: np.ndarray, quickest: np.ndarray) -> np.ndarray:
    """Conicity of the linear motion with the same wavelength; NaN if there is none.

    The wave is 4 times the integral of dy/y' with y'^2 = 2 left / (e R); and e R drops out of the
    conicity.
    """
    with np.errstate(divide="ignore", invalid="ignore"):
        quarter = np.pi / 2 * np.mean(quickest / np.sqrt(2 * left), axis=-1)
    return np.asarray(2 * (np.pi / (4 * quarter)) ** 2)
