"""Free wheel sets, at random: those that a scan of positions brackets, and those that the search
finds.
"""

import json
import time
from dataclasses import replace
from typing import Any

import numpy as np

from tests.benchmarks.table import RESULTS, Table
from varcontact.errors import NoContact, NotConverged, SceneError
from varcontact.wheel_rail import Position, Profile, Track, Velocity, WheelSet, WheelSetOnTrack

CASES = RESULTS / "balance_cases.json"
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


def outcome(case: WheelSetOnTrack) -> tuple[list[float] | None, str]:
    """y [mm] and yaw [mrad] of the balance, or why there is none."""
    try:
        found = case.estimate()
    except (NoContact, NotConverged, SceneError) as error:
        return None, str(error)
    return [found.position.y, 1e3 * found.position.yaw], ""


def judged(seed: int) -> dict[str, Any]:
    """The balance of a set and of its mirror image, or why there is none, and the time."""
    case = wheel_set(seed)
    track = case.track
    start = time.process_time()
    balance, reason = outcome(case)
    seconds = time.process_time() - start
    mirrored_track = replace(track, curve_radius=-track.curve_radius)
    mirrored, _ = outcome(replace(case, track=mirrored_track))
    return {
        "balance": balance,
        "mirrored": mirrored,
        "reason": reason,
        "friction": case.friction,
        "radius": track.curve_radius,
        "seconds": seconds,
    }


def alike(row: dict[str, Any]) -> bool:
    """Whether a set and its mirror image have mirrored balances, or none."""
    if row["balance"] is None or row["mirrored"] is None:
        return row["balance"] is row["mirrored"]
    return np.allclose(row["balance"], -np.array(row["mirrored"]), atol=ALIKE)


def random_sets(quick: bool) -> Table:
    """Sets found, those refused although a scan of y and yaw brackets a balance, mirror images, and
    the time.

    All sets are searched first; what is refused is scanned afterwards, minutes each. Each set that
    is judged is kept at once in results/balance_cases.json, where a stopped run goes on.
    """
    sets, points = (QUICK, QUICK_POINTS) if quick else (SETS, POINTS)
    rows: dict[str, dict[str, Any]] = {}
    if CASES.exists() and not quick:
        rows = json.loads(CASES.read_text())
    for seed in range(sets):
        if str(seed) not in rows:
            rows[str(seed)] = judged(seed)
            keep(rows, quick)
    refused = [seed for seed in range(sets) if rows[str(seed)]["balance"] is None]
    for seed in refused:
        if "bracketed" not in rows[str(seed)]:
            rows[str(seed)]["bracketed"] = scanned(wheel_set(seed), points)
            keep(rows, quick)
    own = [rows[str(seed)] for seed in range(sets)]
    head = (
        "wheel sets",
        "found",
        "refused, but bracketed",
        "mirror images unlike",
        "time [s], median and largest",
    )
    seconds = [row["seconds"] for row in own]
    line = (
        sets,
        sets - len(refused),
        sum(row.get("bracketed", False) for row in own),
        sum(not alike(row) for row in own),
        [float(np.median(seconds)), max(seconds)],
    )
    return Table(head, ("", "", "", "", "{:.1f}, {:.1f}"), [line])


def keep(rows: dict[str, dict[str, Any]], quick: bool) -> None:
    if not quick:
        CASES.write_text(json.dumps(rows, indent=1) + "\n")


TABLES = {"random_sets": random_sets}
