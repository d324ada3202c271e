"""Free wheel sets, at random: those that a scan of positions brackets, and those that the search
finds.
"""

import time
from dataclasses import replace

import numpy as np

from tests.benchmarks.table import Table
from varcontact.errors import NoContact, NotConverged, SceneError
from varcontact.wheel_rail import Position, Profile, Track, Velocity, WheelSet, WheelSetOnTrack

SETS, QUICK = 200, 10
POINTS, QUICK_POINTS = 41, 15
YAW = 0.01
"""Largest yaw of the scan [rad]."""
CLEARANCE = 7.0
"""Largest displacement of the scan [mm]."""
ALIKE = 1e-4
"""Largest difference of mirror images [mm, mrad]."""
FREE = ("y", "yaw", "roll", "pitch_rate")


def worn(rng: np.random.Generator) -> Profile:
    """S1002 with a tread up to 2 mm hollow, and a flange up to 2 mm thinner."""
    new = Profile.s1002()
    y, z = new.y, new.z
    hollow = rng.uniform(0.0, 2.0) * np.exp(-(((y - rng.uniform(-5.0, 15.0)) / 20.0) ** 2))
    thinner = rng.uniform(0.0, 2.0) / (1 + np.exp((y + 37.0) / 2.0))
    on_face = (y > y[z.argmax()]) & (y < 60.0)
    return Profile(
        y=y + np.where(on_face, thinner, 0.0) * (z < z.max() - 4),
        z=z - hollow * on_face,
        kind="wheel",
    )


def wheel_set(seed: int) -> WheelSetOnTrack:
    rng = np.random.default_rng(seed)
    wheel = Profile.s1002() if rng.random() < 0.5 else worn(rng)
    radius = 1 / rng.uniform(-1 / 150e3, 1 / 150e3)
    return WheelSetOnTrack(
        track=Track(rail=Profile.rail_60e1(), cant=1 / 40, curve_radius=radius),
        wheelset=WheelSet(wheel=wheel),
        velocity=Velocity(speed=20e3),
        vertical_force=float(rng.uniform(50e3, 200e3)),
        friction=float(rng.uniform(0.05, 0.5)),
        free=FREE,
    )


def scanned(case: WheelSetOnTrack, points: int) -> bool:
    """Whether lateral force and yaw moment change their sign between the corners of one cell,
    around 0 of both.
    """
    held = replace(case, free=("roll", "pitch_rate"))
    loads = np.full((points, points, 2), np.nan)
    for i, y in enumerate(np.linspace(-CLEARANCE, CLEARANCE, points)):
        for j, yaw in enumerate(np.linspace(-YAW, YAW, points)):
            try:
                found = replace(held, position=Position(y=float(y), yaw=float(yaw))).estimate()
            except (NoContact, NotConverged, SceneError):
                continue
            loads[i, j] = -found.force[1], found.moment_on_wheelset[2]
    corners = np.stack([loads[:-1, :-1], loads[1:, :-1], loads[1:, 1:], loads[:-1, 1:]])
    angle = np.arctan2(corners[..., 1] / 750.0, corners[..., 0])
    turned = np.remainder(np.roll(angle, -1, axis=0) - angle + np.pi, 2 * np.pi) - np.pi
    return bool((np.abs(turned.sum(axis=0)) > np.pi).any())


def outcome(case: WheelSetOnTrack) -> tuple[np.ndarray | None, str]:
    """y [mm] and yaw [mrad] of the balance, or why there is none."""
    try:
        found = case.estimate()
    except (NoContact, NotConverged, SceneError) as error:
        return None, str(error)
    return np.array([found.position.y, 1e3 * found.position.yaw]), ""


def random_sets(quick: bool) -> Table:
    """Sets found, those refused although a scan of y and yaw brackets a balance, mirror images, and
    the time.
    """
    sets, points = (QUICK, QUICK_POINTS) if quick else (SETS, POINTS)
    found, missed, unlike, seconds = 0, 0, 0, []
    for seed in range(sets):
        case = wheel_set(seed)
        start = time.process_time()
        balance, reason = outcome(case)
        seconds.append(time.process_time() - start)
        other, _ = outcome(
            replace(case, track=replace(case.track, curve_radius=-case.track.curve_radius))
        )
        found += balance is not None
        if balance is None or other is None:
            mirrored = balance is other
        else:
            mirrored = np.allclose(balance, -other, atol=ALIKE)
        unlike += not mirrored
        bracketed = balance is None and scanned(case, points)  # what is found needs no scan
        missed += bracketed
        if bracketed or not mirrored:
            print(seed, balance, other, reason, bracketed, flush=True)
    head = (
        "wheel sets",
        "found",
        "refused, but bracketed",
        "mirror images unlike",
        "time [s], median and largest",
    )
    row = (sets, found, missed, unlike, [float(np.median(seconds)), max(seconds)])
    return Table(head, ("", "", "", "", "{:.1f}, {:.1f}"), [row])


TABLES = {"random_sets": random_sets}
