"""The track of a wheel, or its roller, in the dimensions of an input file of CONTACT."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from varcontact.io.contact_cases import CaseInput
from varcontact.io.contact_words import Group, located
from varcontact.wheel_rail.track import SIGN, Irregularity, Side, Track


def check_roller(case: CaseInput) -> None:
    """Refuse a roller with a kept track or velocity that is not of a roller, or with a wheel that
    is not above the roller's axle.
    """
    track: Group = case.needs("track", "ZTRACK", "roller dimensions", "Z = 3")
    velocity: Group = case.needs("velocity", "EWHEEL", "a velocity", "E = 3")
    if track.names[3] != "NOMRAD" or velocity.names[0] != "VPITCH_ROL":
        why = "needs NOMRAD and VPITCH_ROL, and a track is kept: use Z = 3 and E = 2"
        case.controls.complain("CONFIG", why)
    place: Group = case.needs("position", "EWHEEL", "a position", "E = 3")
    if place.number(0) != 0:
        why = "is not supported: wheels here are above the roller's axle"
        place.refuse("X", place.number(0), why)


def track_of(
    dimensions: Group, deviations: Group, rail: Any, side: Side, rate: float
) -> tuple[Track, float]:
    """The track with its rails, and how far the rail's top is below CONTACT's height 0."""
    height, second, third = (dimensions.number(k) for k in range(3))
    rails: dict[str, Any] = {"rail": rail, side: _irregularity(deviations)}
    if dimensions.names[3] == "NOMRAD":
        rails |= {"roller_radius": dimensions.number(3), "roller_rate": rate}
    else:
        rails["cant"] = dimensions.angle(3)
    curvature = dimensions.option(0, 0.0)
    if curvature != 0:
        rails["curve_radius"] = 1 / curvature
    if height > 0:  # GAUGSQ has no effect in CONTACT
        return Track(gauge=third, gauge_height=height, **rails), 0.0
    # the rail's origin is given; its top has the height 0 here, and the gauge may be measured
    # anywhere
    track = Track(gauge_height=0.0, **rails)
    beside = SIGN[side] * second - float(track.origin[0])
    track = replace(track, gauge=track.gauge + 2 * beside)
    return track, third - float(track.origin[1])


def _irregularity(deviations: Group) -> Irregularity:
    places = {"y": 0, "z": 1, "lateral": 3, "vertical": 4}
    numbers = {name: deviations.number(k) for name, k in places.items()}
    angles = {"roll": deviations.angle(2), "roll_rate": deviations.angle(5)}
    with located(deviations):
        return Irregularity(**numbers, **angles)
