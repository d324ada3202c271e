"""What the tests of wheels on rails share."""

import csv
from pathlib import Path

import numpy as np

from varcontact.wheel_rail import Position, Profile, Track, Velocity, WheelOnRail, WheelSet

DATA = Path(__file__).parents[1] / "data"
RAIL = Profile.read(DATA / "profiles" / "rail_UIC60.csv", "rail")
WHEEL = Profile.read(DATA / "profiles" / "wheel_S1002.csv", "wheel")
TRACK = Track(rail=RAIL)
WHEELSET = WheelSet(wheel=WHEEL)


def manchester():
    """The positions of the Manchester benchmark's case A-2.2 with the results of CONTACT, as
    published with it.
    """
    with open(DATA / "manchester_a22.csv", newline="") as file:
        return [
            {k: v if k == "side" else float(v) for k, v in row.items()}
            for row in csv.DictReader(file)
        ]


def published(side, y):
    """A position of the benchmark."""
    return next(each for each in manchester() if (each["side"], each["y_ws"]) == (side, y))


def benchmark(row, **more):
    more = {"vertical_force": 10e3, "dx": 0.2, "dy": 0.2, **more}
    return WheelOnRail(
        track=TRACK,
        wheelset=WHEELSET,
        side=row["side"],
        position=Position(y=row["y_ws"], roll=row["roll"], yaw=row["yaw"]),
        velocity=Velocity(speed=2000.0, pitch_rate=row["pitch_rate"]),
        **more,
    )


def round_rail(radius=300.0, half=35.0):
    """A circular arc, its top at y = 0."""
    angle = np.linspace(-np.arcsin(half / radius), np.arcsin(half / radius), 401)
    return Profile(y=radius * np.sin(angle), z=radius * (1 - np.cos(angle)), kind="rail")


def round_wheel(radius=500.0, half=35.0):
    """A circular arc, its lowest point at y = 0."""
    angle = np.linspace(-np.arcsin(half / radius), np.arcsin(half / radius), 401)
    return Profile(y=radius * np.sin(angle), z=radius * (np.cos(angle) - 1), kind="wheel")


def cone(slope=0.05, half=40.0):
    """A line: the radius falls to the outside."""
    y = np.linspace(-half, half, 161)
    return Profile(y=y, z=-slope * y, kind="wheel")


def flat_track(rail, height=1.0):
    """A track whose rail tops are at y = 750 mm, above the middles of the wheels."""
    track = Track(rail=rail, gauge_height=height)
    return Track(
        rail=rail, gauge_height=height, gauge=2 * (750.0 + track.gauge / 2 - track.origin[0])
    )


def wheel(y=0.0, roll=0.0, yaw=0.0, **more):
    """A wheel of the benchmark's profiles, with 80 kN unless more is given."""
    common = {"track": TRACK, "wheelset": WHEELSET, "vertical_force": 80e3}
    return WheelOnRail(**common | {"position": Position(y=y, roll=roll, yaw=yaw)} | more)


def circles(radius=300.0, y=0.0, yaw=0.0, **more):
    """A wheel of a radius of 500 mm across on a rail of another, both circular."""
    common = {"track": flat_track(round_rail(radius)), "wheelset": WheelSet(wheel=round_wheel())}
    return wheel(y, yaw=yaw, **common | more)
