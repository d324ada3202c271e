"""How a wheel set steers on straight track: rolling radius difference and equivalent conicity, as EN 15302 has them.

Wheels and rails are rigid, and the axle is level and square to the track. Displaced by y, the wheel set turns towards
the smaller radius, so that along the distance rolled

    y'' = -(r_right(y) - r_left(y)) / (e R),

with the distance e of the nominal circles and their radius R. The equivalent conicity for an amplitude is that of the
cones whose motion, Klingel's, is as long a wave: ``2 e R (pi / wavelength)^2``.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from varcontact import checks
from varcontact.errors import SceneError
from varcontact.wheel_rail.curve import Curve
from varcontact.wheel_rail.search import contact_locus
from varcontact.wheel_rail.track import Track, WheelSet, check_kind

NODES = 0.05
"""Between displacements whose difference is computed [mm]; between them it is linear."""
PHASES = 400
"""Points of a quarter of a wave."""


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
        If a displacement is not finite, or the wheels touch at the end of a profile.
    NoContact
        If a wheel is beside the rail.

    Examples
    --------
    >>> from varcontact.wheel_rail import Profile
    >>> track, wheelset = Track(rail=Profile.rail_60e1(), cant=1 / 40), WheelSet(wheel=Profile.s1002())
    >>> print(rolling_radius_difference(track, wheelset, [0.0, 1.0, 3.0, 5.0]).round(2))
    [0.   0.61 0.94 1.45]
    """
    check_kind("track", track, Track)
    check_kind("wheelset", wheelset, WheelSet)
    places = checks.numbers("y", y)
    wheel, rail = wheelset.placed("right"), track.placed("right")
    radii = {each: _radius(wheel, rail, each, wheelset.radius) for each in {*places.flat, *(-places).flat}}
    found = np.array([radii[each] - radii[-each] for each in places.flat]).reshape(places.shape)
    return found if found.ndim else float(found)


def equivalent_conicity(track: Track, wheelset: WheelSet, amplitude: Any) -> Any:
    """The conicity of the wheel set whose motion is as long a wave, by EN 15302.

    Parameters
    ----------
    track : Track
    wheelset : WheelSet
    amplitude : float or array_like
        Of the lateral motion; 3 mm is the usual one [mm].

    Returns
    -------
    float or ndarray
        In the shape of the amplitude [-]: 0 where nothing turns the wheel set back, NaN where it is turned away from
        the middle before it is as far out.

    Raises
    ------
    SceneError, NoContact
        See `rolling_radius_difference`; for an amplitude that is not positive.

    Examples
    --------
    >>> from varcontact.wheel_rail import Profile
    >>> track, wheelset = Track(rail=Profile.rail_60e1(), cant=1 / 40), WheelSet(wheel=Profile.s1002())
    >>> print(f"{equivalent_conicity(track, wheelset, 3.0):.2f}")
    0.17
    """
    wanted = checks.positives("amplitude", amplitude)
    if not wanted.size:
        return wanted
    nodes = np.linspace(0.0, wanted.max(), int(np.ceil(wanted.max() / NODES)) + 1)
    difference = rolling_radius_difference(track, wheelset, nodes)
    found = np.array([_conicity(nodes, difference, float(each)) for each in wanted.flat]).reshape(wanted.shape)
    return found if found.ndim else float(found)


def _radius(wheel: Curve, rail: Curve, y: float, height: float) -> float:
    """Of the right wheel where it touches first: at the lowest point of a parabola through the nearest circles."""
    locus = contact_locus(wheel, rail, np.eye(3), np.array([0.0, y, -height]))
    nearest = int(locus.gap.argmin())
    before, gap, after = (locus.gap[i] if 0 <= i < locus.gap.size else np.inf for i in range(nearest - 1, nearest + 2))
    if not np.isfinite(before + after):
        raise SceneError("y", y, message=f"y = {y:g} mm: the wheel touches at the end of a profile")
    step, bend = locus.s[nearest] - locus.s[nearest - 1], before - 2 * gap + after
    beside = step * (before - after) / (2 * bend) if bend > 0 else 0.0
    return float(wheel.points(locus.s[nearest] + beside)[1])


def _conicity(nodes: np.ndarray, difference: np.ndarray, amplitude: float) -> float:
    """From the wavelength, a quarter of which passes between the middle and the amplitude."""
    phase = (np.arange(PHASES) + 0.5) / PHASES * np.pi / 2
    left = _work(nodes, difference, np.array([amplitude])) - _work(nodes, difference, amplitude * np.sin(phase))
    if (left < 0).any():
        return float("nan")
    if not left.all():
        return 0.0
    # wavelength = 4 times the integral of dy/y' with y'^2 = 2 left / (e R); and e R drops out of the conicity
    quarter = np.pi / 2 * float(np.mean(amplitude * np.cos(phase) / np.sqrt(2 * left)))
    return float(2 * (np.pi / (4 * quarter)) ** 2)


def _work(nodes: np.ndarray, difference: np.ndarray, y: np.ndarray) -> np.ndarray:
    """The integral of the difference up to displacements."""
    up_to = np.concatenate([[0.0], np.cumsum(np.diff(nodes) * (difference[1:] + difference[:-1]) / 2)])
    cell = np.clip(np.searchsorted(nodes, y, side="right") - 1, 0, nodes.size - 2)
    beyond = y - nodes[cell]
    return np.asarray(up_to[cell] + beyond * (difference[cell] + np.interp(y, nodes, difference)) / 2)
