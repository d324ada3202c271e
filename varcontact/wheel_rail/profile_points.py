"""The points of a profile: put in order, and refused where they are no profile."""

from __future__ import annotations

from typing import Literal

import numpy as np

from varcontact.errors import SceneError

Kind = Literal["rail", "wheel"]
TOGETHER = 0.02
"""Points nearer to the one before than this part of the usual spacing are left out: their directions are rounding."""
NARROWEST = 1.0
"""Width a profile must have [mm]; in metres none has."""
SIDE = 1e-6
"""What is nearer to a line than this lies on it [mm]."""
FLANGE, TIP = 0.1, 10.0
"""A wheel's lowest point is a flange if it lies further from the middle than this part of the width, and so much below
the middle of its points [mm]: a hollow or barrelled tread has none."""
BACK = 3.0
"""By so much a wheel's flange rises again behind its tip at least, where that is part of the profile [mm]."""
BESIDE = 50
"""A rail's top with one in so many of its points to either side, three at least, tells which way they run."""


def ordered(points: np.ndarray, kind: Kind) -> np.ndarray:
    """The points from the track side to the outside, without those that lie on each other.

    Of a rail the points at its top tell: web and foot may go on below until the ends meet.

    Parameters
    ----------
    points : ndarray, shape (n, 2)
        y and z [mm].
    kind : {"rail", "wheel"}
    """
    if len(points) > 1:
        top = int(points[:, 1].argmin())
        beside = max(3, len(points) // BESIDE)
        first, last = (max(top - beside, 0), min(top + beside, len(points) - 1)) if kind == "rail" else (0, -1)
        if points[first, 0] > points[last, 0]:
            points = points[::-1]
    if len(points) < 3:
        return points
    gaps = np.hypot(*np.diff(points, axis=0).T)
    least = TOGETHER * float(np.median(gaps))
    keep, last = [0], 0
    for i in range(1, len(points)):
        if np.hypot(*(points[i] - points[last])) > least:
            keep.append(i)
            last = i
    return points[keep]


def check_width(points: np.ndarray) -> None:
    """Refuse lengths in metres, which make a profile of some tenths of a millimetre.

    Parameters
    ----------
    points : ndarray, shape (n, 2)
        y and z [mm].
    """
    width = float(np.ptp(points[:, 0]))
    if width < NARROWEST:
        raise SceneError(
            "profile.y",
            width,
            message=f"the profile is {width:.3g} mm wide: y and z must be in millimetres; multiply them by 1000 where "
            "they are in metres, or read the file with scale=1000",
        )


def check_crossing(points: np.ndarray) -> None:
    """Refuse a profile of which a segment crosses another, or a part is there twice.

    Parameters
    ----------
    points : ndarray, shape (n, 2)
        y and z [mm].
    """
    _, first, place = np.unique(points[:-1], axis=0, return_index=True, return_inverse=True)
    again = np.flatnonzero(first[place.ravel()] != np.arange(len(points) - 1))
    if again.size:
        i, j = int(first[place.ravel()[again[0]]]), int(again[0])
        raise SceneError(
            "profile",
            tuple(points[j].tolist()),
            message=f"the profile comes back to y = {points[j, 0]:.4g}, z = {points[j, 1]:.4g} mm, its points {i} and "
            f"{j}: the points must follow each other along the profile, once",
        )
    start, end = points[:-1], points[1:]
    for i in range(len(start) - 2):
        across = _off(start[i], end[i], start[i + 2 :]) * _off(start[i], end[i], end[i + 2 :])
        along = _off(start[i + 2 :], end[i + 2 :], start[i]) * _off(start[i + 2 :], end[i + 2 :], end[i])
        crossed = np.flatnonzero((across < -(SIDE**2)) & (along < -(SIDE**2)))
        if crossed.size:
            y, z = (start[i] + end[i]) / 2
            raise SceneError(
                "profile",
                (float(y), float(z)),
                message=f"the profile crosses itself near y = {y:.4g}, z = {z:.4g} mm, between its points {i} and "
                f"{i + 2 + int(crossed[0])}: the points must follow each other along the profile; of measured ones "
                "that are nearer to each other than their noise take every second or third",
            )


def _off(first: np.ndarray, last: np.ndarray, point: np.ndarray) -> np.ndarray:
    """How far a point is to the left of the line from one point to another."""
    way, to = last - first, point - first
    return (way[..., 0] * to[..., 1] - way[..., 1] * to[..., 0]) / np.hypot(way[..., 0], way[..., 1])


def _interior(at: int, size: int) -> bool:
    return 0 < at < size - 1


def check_upright(points: np.ndarray, kind: Kind) -> None:
    """Refuse the profile of the other kind, z that points up, and a wheel's flange on the field side.

    Parameters
    ----------
    points : ndarray, shape (n, 2)
        y and z [mm].
    kind : {"rail", "wheel"}
    """
    y, z = points.T
    looks: Kind = "wheel" if kind == "rail" else "rail"
    if any((_wheel if kind == "rail" else _rail_head)(y, each) for each in (z, -z)):
        what = "from its flange a tread goes on to one side" if kind == "rail" else "both sides fall from its top"
        raise SceneError(
            "profile.kind",
            kind,
            message=f'profile.kind = "{kind}", but the points are those of a {looks} ({what}): read them with '
            f'kind = "{looks}"',
        )
    low, high = int(z.argmax()), int(z.argmin())
    if kind == "wheel":
        inverted = flange(y, -z) != 0 and flange(y, z) == 0
    else:
        inverted = _interior(low, len(z)) and not _interior(high, len(z))
    if inverted:
        what, where = ("its flange points up", high) if kind == "wheel" else ("its head points down", low)
        raise SceneError(
            "profile.z",
            float(z[where]),
            message=f"the {kind}'s profile is upside down ({what}): z must point down; change the sign of z, or read "
            "the file with mirror_z=True",
        )
    if kind == "wheel" and flange(y, z) > 0:
        raise SceneError(
            "profile.y",
            float(points[low, 0]),
            message=f"the wheel's flange is at y = {points[low, 0]:.4g} mm: y must point to the outside, away from the "
            "flange; change the sign of y, or read the file with mirror_y=True",
        )


def _falls(y: np.ndarray, z: np.ndarray) -> tuple[np.ndarray, np.ndarray, int]:
    """Widths along the run of growing y around the highest point, depths below that, and where it is."""
    top = int(z.argmin())
    back = np.flatnonzero(np.diff(y) < 0)
    first, last = (int(part[k]) if part.size else end for part, k, end in (
        (back[back < top] + 1, -1, 0), (back[back >= top], 0, len(y) - 1)
    ))  # fmt: skip
    run = slice(first, last + 1)
    return np.gradient(y[run]) if last > first else np.zeros(1), z[run] - z[top], top - first


def _rail_head(y: np.ndarray, z: np.ndarray) -> bool:
    """Whether most of the width is near the top, from which both sides fall to their ends, without a flange's tip."""
    width, depth, top = _falls(y, z)
    near = width[depth < TIP].sum() > width.sum() / 2
    return bool(near) and all(side[-1] > TIP and side[-1] > side.max() - SIDE for side in (depth[top::-1], depth[top:]))


def _wheel(y: np.ndarray, z: np.ndarray) -> bool:
    """Whether most of the width is a tread, far above a flange's tip at one side; a grooved rail has a lip beyond."""
    width, height, tip = _falls(y, -z)
    sides = slice(tip + 1), slice(tip, None)
    back = min(height[side].max() for side in sides)
    far = width * (height > TIP)
    lip = min(far[side].sum() for side in sides)
    return flange(y, z) != 0 and bool(back > BACK and lip < TIP and far.sum() > width.sum() / 2)


def inclination(y: np.ndarray, z: np.ndarray) -> float:
    """How much a rail's head leans towards negative y in itself: the slope of its top around the middle of the head.

    Parameters
    ----------
    y, z : ndarray, shape (n,)
        [mm]

    Returns
    -------
    float
        [rad]; 0 where the points do not go down on both sides.
    """
    _, depth, top = _falls(y, z)
    at = y[int(z.argmin()) - top :][: depth.size]
    if min(depth[0], depth[-1]) < TIP:
        return 0.0
    left, right = np.interp(-TIP, -depth[: top + 1], at[: top + 1]), np.interp(TIP, depth[top:], at[top:])
    middle = np.abs(at - (left + right) / 2) < (right - left) / 4
    return -float(np.arctan(np.polyfit(at[middle], depth[middle], 1)[0])) if middle.sum() > 2 else 0.0


def flange(y: np.ndarray, z: np.ndarray) -> float:
    """Where a wheel's flange is: -1 at the lesser y, 1 at the greater, 0 if it has none.

    Parameters
    ----------
    y, z : ndarray, shape (n,)
        [mm]
    """
    at = int(z.argmax())
    middle, width = (y.min() + y.max()) / 2, y.max() - y.min()
    if abs(y[at] - middle) < FLANGE * width or z[at] < np.median(z) + TIP:
        return 0.0
    return float(np.sign(y[at] - middle))
