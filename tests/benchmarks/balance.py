"""Free wheel sets, at random: those that a scan of positions brackets, and those that the search
finds.
"""

import itertools
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
POINTS, QUICK_POINTS = 41, 13
BLOCK = 4
"""Positions between two of the coarse scan."""
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
    """Lateral force and yaw moment turn around zero along the edge of a cell of positions.

    Every fourth position is tried first; blocks whose loads may vanish inside are filled in.
    """
    held = replace(case, free=("roll", "pitch_rate"))
    y = np.linspace(-CLEARANCE, CLEARANCE, points)
    yaw = np.linspace(-YAW, YAW, points)
    loads = np.full((points, points, 2), np.nan)
    inside = np.zeros((points, points), dtype=bool)

    # The coarse scan.
    coarse = range(0, points, BLOCK)
    for i, j in itertools.product(coarse, coarse):
        loads[i, j] = loads_at(held, float(y[i]), float(yaw[j]))

    # Every position of the blocks in which both loads may vanish.
    for i, j in itertools.product(coarse[:-1], coarse[:-1]):
        corners = loads[i : i + BLOCK + 1 : BLOCK, j : j + BLOCK + 1 : BLOCK].reshape(-1, 2)
        if may_vanish(corners):
            inside[i : i + BLOCK + 1, j : j + BLOCK + 1] = True
    inside[::BLOCK, ::BLOCK] = False
    for i, j in np.argwhere(inside):
        loads[i, j] = loads_at(held, float(y[i]), float(yaw[j]))

    cells = np.stack([loads[:-1, :-1], loads[1:, :-1], loads[1:, 1:], loads[:-1, 1:]])
    return bool((np.abs(turns(cells)) > 0.5).any())


def loads_at(held: WheelSetOnTrack, y: float, yaw: float) -> tuple[float, float]:
    """Lateral force [N] and yaw moment [N mm] that the rails still owe, NaN without contact."""
    try:
        found = replace(held, position=Position(y=y, yaw=yaw)).estimate()
    except (NoContact, NotConverged, SceneError):
        return np.nan, np.nan
    return -found.force[1], found.moment_on_wheelset[2]


def may_vanish(corners: np.ndarray) -> bool:
    """Both loads reach zero within the range of their corners, widened by itself; a corner without
    contact leaves the block open.
    """
    known = corners[np.isfinite(corners).all(axis=-1)]
    if len(known) == 0:
        return False
    if len(known) < len(corners):
        return True
    low = known.min(axis=0)
    high = known.max(axis=0)
    spread = high - low
    return bool(((low - spread <= 0) & (high + spread >= 0)).all())


def turns(cells: np.ndarray) -> np.ndarray:
    """Winding number of the loads (4, m, n, 2) around zero along each cell, 0 where one is NaN."""
    angle = np.arctan2(cells[..., 1] / 750.0, cells[..., 0])
    turned = np.remainder(np.roll(angle, -1, axis=0) - angle + np.pi, 2 * np.pi) - np.pi
    return np.nan_to_num(turned.sum(axis=0) / (2 * np.pi))


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
            rows[str(seed)]["scanned"] = points
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
