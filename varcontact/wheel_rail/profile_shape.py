"""Shape of profiles: order of points, crossings, plausibility of kind, sides and z."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from varcontact.errors import DoubtfulProfile, SceneError, warn
from varcontact.wheel_rail.curve import growing
from varcontact.wheel_rail.profile_files import Z_UP, Kind, read_points

if TYPE_CHECKING:
    from varcontact.wheel_rail.profile import Profile

NARROWEST = 1.0
"""Smallest width of a profile [mm], above that of any profile in metres."""
WIDEST = 1000.0
"""Largest width of a profile [mm], below that of any in micrometres, and of both rails of a
track."""
ON_LINE = 1e-6
"""Distance below which a point lies on a line [mm]."""
FLANGE = 0.1
"""Least distance of a wheel's flange from the middle, relative to the width."""
TIP = 10.0
"""Least depth of a flange's tip below the median of the points [mm]."""
FLANGE_WIDTH = 3.0
"""Least width of a flange within a millimetre of its tip [mm]."""
FLANGE_FACE = 5.0
"""Least height of a flange's face that is steeper than 45 degrees [mm]: balls, cones, and hollow or
barrelled treads have none."""
FINE = 0.1
"""Step along the points in the search for a flange [mm]."""
WIDE = 10.0
"""Least width of a further part of a rail, beside the highest one, that a wheel may touch [mm]."""
BACK = 3.0
"""Smallest rise of a wheel's flange behind its tip, where that is part of the profile [mm]."""
FLAT_DEPTH = 1 / 5
"""Part of a rail's depth, from its lowest point, within which the points of an upside-down rail are
flat."""
FLAT_WIDTH = 2 / 3
"""Part of the width above which a profile counts as flat, as rail heads are; for a groove, even
half a circle, it is at most 0.6."""
OUTWARDS = 1 / 80
"""Slope to the field side above which the sides of a rail are probably exchanged; 1:20 and 1:40 to
the track side are usual."""
TOGETHER = 0.02
"""Spacing relative to the usual one below which two points lie on each other: their direction would
be rounding."""
BESIDE = 50
"""Divisor for the number of points on either side of a rail's top, or a wheel's lowest point, that
show the order of points; at least three are used."""


def check_shape(points: np.ndarray) -> None:
    """Refuse lengths in metres or micrometres, points that come twice, and segments that cross each
    other.
    """
    width = float(np.ptp(points[:, 0]))
    if width < NARROWEST:
        message = (
            f"the profile is {width:.3g} mm wide: give millimetres; "
            "a file in metres is read with scale=1000"
        )
        raise SceneError("profile.y", width, message=message)
    if width > WIDEST:
        message = (
            f"the profile is {width:.5g} mm wide: give millimetres, and each rail by itself; "
            "a file in micrometres is read with scale=0.001"
        )
        raise SceneError("profile.y", width, message=message)
    different, times = np.unique(points[:-1], axis=0, return_counts=True)
    if times.max() > 1:
        y, z = different[times.argmax()].tolist()
        message = (
            f"the profile comes back to y = {y:.4g}, z = {z:.4g} mm: "
            "points must be ordered along it"
        )
        raise SceneError("profile", (y, z), message=message)
    crossings = crossed(points[:-1], points[1:])
    if crossings.size:
        y, z = points[crossings.min() :][:2].mean(axis=0).tolist()
        message = (
            f"the profile crosses itself near y = {y:.4g}, z = {z:.4g} mm: "
            "order, or thin, its points"
        )
        raise SceneError("profile", (y, z), message=message)


def crossed(start: np.ndarray, end: np.ndarray) -> np.ndarray:
    """Indices of segments that another one crosses, which is no neighbour."""
    low = np.minimum(start, end)
    high = np.maximum(start, end)
    # pairs that have a part of y in common, by the segment that begins first
    order = low[:, 0].argsort()
    after = np.arange(1, order.size + 1)
    counts = np.searchsorted(low[order, 0], high[order, 0], side="right") - after
    first = np.repeat(order, counts)
    offsets = np.repeat(after - (np.cumsum(counts) - counts), counts)
    second = order[np.arange(counts.sum()) + offsets]
    # of these, the ones that have a part of z in common
    near = (
        (low[first, 1] <= high[second, 1])
        & (low[second, 1] <= high[first, 1])
        & (np.abs(first - second) > 1)
    )
    lower = np.minimum(first, second)[near]
    higher = np.maximum(first, second)[near]
    # and of these, the ones whose ends are on both sides of each other
    lower_ends = start[lower], end[lower]
    higher_ends = start[higher], end[higher]
    across = _off(*lower_ends, higher_ends[0]) * _off(*lower_ends, higher_ends[1])
    along = _off(*higher_ends, lower_ends[0]) * _off(*higher_ends, lower_ends[1])
    return lower[(across < -(ON_LINE**2)) & (along < -(ON_LINE**2))]


def _off(first: np.ndarray, last: np.ndarray, point: np.ndarray) -> np.ndarray:
    """Distance of a point to the left of the line from one point to another."""
    line = last - first
    to = point - first
    area = line[..., 0] * to[..., 1] - line[..., 1] * to[..., 0]
    return area / np.hypot(line[..., 0], line[..., 1])


def direction(points: np.ndarray, kind: Kind) -> int:
    """1 where y grows from one end to the other, or, where these meet, on what can be touched; else
    -1.
    """
    y, z = points.T
    first = 0
    last = y.size - 1
    if _ends_meet(y):
        touched = int(z.argmin() if kind == "rail" else z.argmax())
        beside = max(3, y.size // BESIDE)
        first = max(touched - beside, 0)
        last = min(touched + beside, y.size - 1)
    return 1 if y[first] < y[last] else -1


def _ends_meet(y: np.ndarray) -> bool:
    """True for an outline that comes back to the side where it begins."""
    return bool(abs(y[-1] - y[0]) <= np.ptp(y) / 2)


def start_opposite(points: np.ndarray, kind: Kind) -> np.ndarray:
    """A closed outline, last point = first, begun at the point farthest from what is touched;
    others as they are.
    """
    steps = np.hypot(*np.diff(points, axis=0).T)
    if np.hypot(*(points[-1] - points[0])) > TOGETHER * np.median(steps):
        return points
    z = points[:-1, 1]
    start = int(z.argmax() if kind == "rail" else z.argmin())
    around = np.roll(points[:-1], -start, axis=0)
    return np.concatenate([around, around[:1]])


def _lower_half(y: np.ndarray, z: np.ndarray) -> np.ndarray:
    """The part of an outline whose ends meet, from its least y to its greatest, that has the
    greater z: what is touched of a wheel; (y, z), shape (2, n).
    """
    first, last = (np.lexsort([-z, sign * y])[0] for sign in (1, -1))
    points = np.roll([y, z], -first, axis=1)
    count = (last - first) % y.size
    one = points[:, : count + 1]
    other = np.roll(points, -1, axis=1)[:, count - 1 :][:, ::-1]
    return max(one, other, key=lambda part: float(part[1].mean()))


def doubt_of(points: np.ndarray, kind: Kind) -> str:
    """Sentence on points that look like the other kind, y and z exchanged, z pointing up, or a
    wheel's flange on the field side.
    """
    y, z = points.T
    other: Kind = "wheel" if kind == "rail" else "rail"
    if _is_of(other, y, z):
        return f'profile.kind = "{kind}", but the points look like those of a {other}'
    if not _is_of(kind, y, z) and _is_exchanged(kind, y, z):
        return f"the {kind}'s y and z look exchanged: z points down, and is the second column"
    if _upside_down(y, z, kind):
        return (
            f"the {kind}'s profile looks upside down: z points down; "
            "change the sign of z, or read the file with the other mirror_z (True or False)"
        )
    if kind == "rail" and (parts := _parts(y, z))[1:]:
        (first, last), (left, right) = parts[:2]
        return (
            f"wheels touch the part at y = {first:.4g} to {last:.4g} mm, "
            f"not that at {left:.4g} to {right:.4g} mm, nearly as high: "
            "along what they touch y must keep growing; cut the other off"
        )
    if kind == "wheel" and flange(y, z) > 0:
        return (
            f"the wheel's flange is at y = {y[z.argmax()]:.4g} mm, the outside: "
            'change the sign of y, or read the file with mirror_y="auto"'
        )
    return ""


def _parts(y: np.ndarray, z: np.ndarray) -> list[tuple[float, float]]:
    """The ends of the parts along which y keeps growing, wide, and nearly as high as the highest,
    which comes first.
    """
    grows = np.append(False, np.diff(y) > 0)
    starts = np.flatnonzero(~grows)
    runs = [slice(a, b) for a, b in pairwise([*starts.tolist(), y.size])]
    wide = [run for run in runs if np.ptp(y[run]) > WIDE]
    wide.sort(key=lambda run: float(z[run].min()))
    high = [run for run in wide if z[run].min() < z[wide[0]].min() + TIP]
    return [(float(y[run][0]), float(y[run][-1])) for run in high]


def guess_mirror_z(path: Path, kind: Kind, scale: float) -> bool:
    """`mirrors_z` of a file."""
    points, kind, z_up = read_points(path, kind)
    y, z = scale * points.T
    return mirrors_z(y, z, kind, path, z_up)


def mirrors_z(
    y: np.ndarray, z: np.ndarray, kind: Kind, path: str | Path, z_up: bool | None
) -> bool:
    """True if the z of a file's points is to change its sign: where the file says that it points
    up, or by a guess where it says nothing, of which a warning gives the reason.
    """
    if z_up is not None:
        return z_up
    file = Path(path)
    suffix = file.suffix.lower()
    if kind == "rail" and suffix in Z_UP:
        mirrored = not (_hollow(-z) or _flat_below(y, -z))
        reason = f"{suffix} has z up"
    else:
        mirrored = _upside_down(y, z, kind)
        reason = "the profile looks upside down"
    words = ""
    if mirrored:
        words = f"the sign of z is changed, as {reason}; mirror_z=True or False says what is right"
    elif kind == "rail" and _hollow(z):
        words = (
            "the rail is hollow, with z down; "
            "mirror_z=False says that it is, mirror_z=True that z points up"
        )
    if words:
        warn(f"{file.name}: {words}", DoubtfulProfile)
    return mirrored


def _upside_down(y: np.ndarray, z: np.ndarray, kind: Kind) -> bool:
    """True for a wheel whose flange points up, or a hollow rail that is flat where it is lowest."""
    if kind == "wheel":
        return flange(y, -z) != 0 and flange(y, z) == 0
    return _hollow(z) and _flat_below(y, z)


def _flat_below(y: np.ndarray, z: np.ndarray) -> bool:
    """True if most of the width is near the lowest point."""
    width = np.abs(np.diff(y))
    low = z[1:] > z.max() - FLAT_DEPTH * np.ptp(z)
    return bool(width[low].sum() > FLAT_WIDTH * width.sum())


def _hollow(z: np.ndarray) -> bool:
    """True if the lowest point of a rail is inside, and its highest at an end."""
    ends = (0, len(z) - 1)
    return int(z.argmax()) not in ends and int(z.argmin()) in ends


def flange(y: np.ndarray, z: np.ndarray) -> float:
    """Side of a wheel's flange: -1 at the lesser y, 1 at the greater, 0 if it has none."""
    if _ends_meet(y):
        y, z = _lower_half(y, z)
    at = int(z.argmax())
    middle = (y.min() + y.max()) / 2
    width = y.max() - y.min()
    if abs(y[at] - middle) < FLANGE * width or z[at] < np.median(z) + TIP:
        return 0.0
    # on evenly spaced points: how blunt the tip is, and how high the face towards the middle
    s = np.append(0.0, np.cumsum(np.hypot(np.diff(y), np.diff(z))))
    along = np.linspace(0.0, s[-1], int(np.ceil(s[-1] / FINE)) + 1)
    across = np.diff(np.interp(along, s, y))
    down = np.diff(np.interp(along, s, z))
    tip = np.interp(along[1:], s, z) > z[at] - 1.0
    steep = np.abs(down) > np.abs(across)
    inwards = (along[1:] - s[at]) * (middle - y[at]) * (y[-1] - y[0]) > 0
    sharp = np.abs(across[tip]).sum() < FLANGE_WIDTH
    if sharp or np.abs(down[steep & inwards]).sum() < FLANGE_FACE:
        return 0.0
    return float(np.sign(y[at] - middle))


def _falls(y: np.ndarray, z: np.ndarray) -> tuple[np.ndarray, np.ndarray, int]:
    """The run of growing y around the highest point: y, depths below that point, and its index."""
    top = int(z.argmin())
    run = growing(np.diff(y) > 0, top)
    return y[run], z[run] - z[top], top - run.start


def _is_of(kind: Kind, y: np.ndarray, z: np.ndarray) -> bool:
    """True if points are a rail's, both sides of which fall to their ends, or those of a wheel with
    a flange.

    Most of a rail's width is near its top, most of a wheel's far above its flange's tip; beyond the
    groove of a grooved rail there is a lip.
    """
    heights = z
    if kind == "wheel":
        heights = -z  # its flange's tip is its lowest point
    at, depth, top = _falls(y, heights)
    far = np.diff(at) * (depth[1:] > TIP)
    mostly_far = far.sum() > np.ptp(at) / 2
    deepest = np.array([depth[: top + 1].max(), depth[top:].max()])
    if kind == "rail":
        falls_to_ends = bool((depth[[0, -1]] > deepest - ON_LINE).all())
        return not mostly_far and deepest.min() > TIP and falls_to_ends
    lip = min(far[:top].sum(), far[top:].sum())
    return bool(mostly_far and deepest.min() > BACK and lip < TIP) and flange(y, z) != 0


def _is_exchanged(kind: Kind, y: np.ndarray, z: np.ndarray) -> bool:
    """True if points are a rail's, or a wheel's, with y and z exchanged, either of them with either
    sign.
    """
    orders = slice(None), slice(None, None, -1)
    return any(_is_of(kind, z[order], sign * y[order]) for order in orders for sign in (1, -1))


def check_sides(rail: Profile) -> None:
    """Warn of a rail whose sides are probably exchanged."""
    if rail.exchanged_sides:
        warn(rail.exchanged_sides)


def exchanged_sides(y: np.ndarray, z: np.ndarray) -> str:
    """Sentence on a rail whose sides are probably exchanged: it goes down on the field side alone,
    or its head leans that way; empty for others.
    """
    highest = int(z.argmin())
    track_side = float(z[: highest + 1].max() - z[highest])
    field_side = float(z[-1] - z[highest])
    at, depth, top = _falls(y, z)
    words = ""
    if track_side < TIP <= field_side:
        words = f"goes down by {field_side:.3g} mm on the field side, {track_side:.3g} on the other"
    elif min(depth[0], depth[-1]) >= TIP:
        slope = _slope_of_head(at, depth, top)
        if slope > OUTWARDS:
            words = f"leans to the field side by 1:{1 / slope:.0f}"
    if not words:
        return ""
    return (
        f"track.rail: the profile {words}, so its gauge side is probably on the wrong side: "
        "change the sign of y, or read the file with the other mirror_y (True or False)"
    )


def _slope_of_head(at: np.ndarray, depth: np.ndarray, top: int) -> float:
    """Slope of the middle half of a rail's head, positive where it falls to the field side; zero
    with too few points.
    """
    left = np.interp(-TIP, -depth[: top + 1], at[: top + 1])
    right = np.interp(TIP, depth[top:], at[top:])
    middle = np.abs(at - (left + right) / 2) < (right - left) / 4
    if middle.sum() < 3:
        return 0.0
    return float(np.polyfit(at[middle], depth[middle], 1)[0])
