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
"""A wheel's lowest point is a flange if it lies further from the middle than this part of the width; and, where the
profile ends there, so much below the middle of its points [mm]."""
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
    """Refuse z that points up, and a wheel's flange on the field side.

    Parameters
    ----------
    points : ndarray, shape (n, 2)
        y and z [mm].
    kind : {"rail", "wheel"}
    """
    y, z = points.T
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


def flange(y: np.ndarray, z: np.ndarray) -> float:
    """Where a wheel's flange is: -1 at the lesser y, 1 at the greater, 0 if it has none.

    Parameters
    ----------
    y, z : ndarray, shape (n,)
        [mm]
    """
    at, size = int(z.argmax()), len(z)
    middle, width = (y.min() + y.max()) / 2, y.max() - y.min()
    if abs(y[at] - middle) < FLANGE * width or not (_interior(at, size) or z[at] > np.median(z) + TIP):
        return 0.0
    return float(np.sign(y[at] - middle))
