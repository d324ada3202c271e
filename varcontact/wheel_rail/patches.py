"""From overlaps of wheel and rail to contact patches: place, frame, potential contact and undeformed distance."""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from varcontact.errors import NotConverged, SceneError
from varcontact.kinematics import Frame, rotation
from varcontact.scene.grid import Grid
from varcontact.wheel_rail.curve import Curve
from varcontact.wheel_rail.seams import Seams, seam_weight
from varcontact.wheel_rail.search import Locus, Overlap

GUARD = 1
"""Elements beyond the overlap on every side."""
SAMPLES, AROUND = 100, 20
"""Samples across the overlap for grids of any size, and beyond it on every side, where the search for one may reach."""
STEPS, CLOSE = 12, 1e-9
"""Newton steps to the wheel's surface, and how near they come [mm]."""
MOST = 400_000
"""Elements of a potential contact."""


@dataclass(frozen=True, eq=False)
class Tangent:
    """The plane of a contact patch.

    Attributes
    ----------
    frame : Frame
        See `Place`, as for the rest.
    angle, theta : float
    """

    frame: Frame
    angle: float
    theta: float

    def turned(self, angle: float) -> Tangent:
        """The same about the same origin, at another angle.

        Parameters
        ----------
        angle : float
            [rad]
        """
        return Tangent(Frame(self.frame.origin, rotation(roll=angle)), angle, self.theta)


@dataclass(frozen=True, eq=False)
class Place:
    """Where a contact patch is, and the shape of the bodies there.

    Attributes
    ----------
    frame : Frame
        Origin on the rail's surface at the weighted centre of the overlap; x forward, y (also called s) along the
        rail's surface to the right, z into the rail.
    angle : float
        Contact angle: of the frame about x [rad].
    grid : Grid
        Potential contact in the frame [mm].
    distance : ndarray, shape (ny, nx)
        From the wheel to the rail along z, undeformed and without the approach: 0 at its least [mm].
    approach : float
        How deep the wheel is in the rail [mm].
    theta : float
        Angle of the contact on the wheel's circle, forward from the bottom [rad].
    seams : tuple of pairs of float
        Where parts of the patch meet along y, and how much they feel each other, see `varcontact.wheel_rail.seams`.
    """

    frame: Frame
    angle: float
    grid: Grid
    distance: np.ndarray
    approach: float
    theta: float
    seams: Seams


def joined(overlaps: list[Overlap], nearer: float) -> list[list[Overlap]]:
    """Overlaps in groups that make one patch: the gap between neighbours on the rail is shorter than a distance.

    Parameters
    ----------
    overlaps : list of Overlap
        From left to right.
    nearer : float
        [mm]

    Returns
    -------
    list of list of Overlap
    """
    groups = [[overlaps[0]]]
    for left, right in pairwise(overlaps):
        if _apart(left, right) < nearer:
            groups[-1].append(right)
        else:
            groups.append([right])
    return groups


def _apart(left: Overlap, right: Overlap) -> float:
    """The gap between neighbours on the rail's surface."""
    return math.hypot(*(right.surface[0] - left.surface[-1]))


def place(
    overlaps: list[Overlap],
    tangent: Tangent,
    wheel: Curve,
    rail: Curve,
    axle: np.ndarray,
    centre: np.ndarray,
    sides: tuple[float, float] | None = None,
    distances: tuple[float, float] = (math.inf, math.inf),
) -> Place:
    """The patch of a group of overlaps.

    Parameters
    ----------
    overlaps : list of Overlap
    tangent : Tangent
        As of `tangents_of`.
    wheel : Curve
        (y along the axle, radius).
    rail : Curve
        (y, z) in track coordinates.
    axle : ndarray, shape (3, 3)
        Axes of the axle in track coordinates.
    centre : ndarray, shape (3,)
        Middle of the axle in track coordinates.
    sides : tuple of float, optional
        (dx, dy) of an element [mm]; fine enough to interpolate the distance on any grid if not given.
    distances : tuple of float
        Up to which overlaps are one part, and from which they do not feel each other [mm].

    Returns
    -------
    Place

    Raises
    ------
    SceneError
        If the elements are too many, or none is where the bodies overlap; if a profile is too rough.
    """
    frame = tangent.frame
    grid = _grid(overlaps, frame, sides)
    gap = _rail_heights(rail, frame, grid)[:, None] - _wheel_heights(
        overlaps[0].locus, wheel, frame, grid, axle, centre
    )
    known = np.isfinite(gap)
    if not known.any():
        raise too_rough(float(frame.origin[1]))
    if gap[known].min() >= 0:
        raise SceneError(
            "dx, dy",
            grid.sides,
            message=f"dx = {grid.sides[0]:g}, dy = {grid.sides[1]:g} mm: no element's centre is where wheel and rail "
            f"overlap near y = {frame.origin[1]:.4g} mm; give smaller ones, or smooth a rough profile, "
            "Profile(..., smoothing=...)",
        )
    gap = np.where(known, gap, gap[known].max() + abs(gap[known]).max())  # beside a profile's end nothing touches
    seams = _seams(overlaps, frame, *distances)
    return Place(frame, tangent.angle, grid, gap - gap.min(), -float(gap.min()), tangent.theta, seams)


def too_rough(y: float) -> SceneError:
    """What to raise where the surfaces of the bodies cannot be followed.

    Parameters
    ----------
    y : float
        Place on the track [mm].

    Returns
    -------
    SceneError
    """
    return SceneError(
        "profile",
        y,
        message=f"wheel and rail cannot be followed along their surfaces near y = {y:.4g} mm: a profile is too rough "
        "there; smooth it, Profile(..., smoothing=...)",
    )


def tangents_of(groups: list[list[Overlap]], rail: Curve, separate: float, turn: float) -> list[Tangent]:
    """The planes of all patches, those of near neighbours turned towards each other.

    Where the gap between two is `separate`, both have the angle that they would have as one patch, from `turn` on their
    own: so does CONTACT (D_TURN), and forces do not jump as patches become one.

    Parameters
    ----------
    groups : list of list of Overlap
        As of `joined`.
    rail : Curve
        (y, z) in track coordinates.
    separate, turn : float
        [mm]

    Returns
    -------
    list of Tangent
    """
    found = [tangent_of(group, rail) for group in groups]
    angles = np.array([each.angle for each in found])
    loads = np.array([sum(float(each.weights.sum()) for each in group) for group in groups])
    turned = angles.copy()
    for i, (left, right) in enumerate(pairwise(groups)):
        apart, two = _apart(left[-1], right[0]), slice(i, i + 2)
        if apart < turn:
            together = float(angles[two] @ loads[two] / loads[two].sum())
            turned[two] += (turn - apart) / (turn - separate) * (together - angles[two])
    return [each.turned(float(angle)) for each, angle in zip(found, turned, strict=True)]


def tangent_of(overlaps: list[Overlap], rail: Curve) -> Tangent:
    """The plane of a group of overlaps by itself.

    Parameters
    ----------
    overlaps : list of Overlap
    rail : Curve
        (y, z) in track coordinates.
    """
    weights = np.concatenate([each.weights for each in overlaps])
    weights = weights / weights.sum()
    points = np.concatenate([each.points for each in overlaps])
    angle = float(weights @ np.concatenate([each.locus.angles[each.run] for each in overlaps]))
    theta = float(weights @ np.concatenate([each.locus.theta[each.run] for each in overlaps]))
    x, y = (float(weights @ points[:, i]) for i in (0, 1))
    at = rail.at(np.array([y]), np.array([1.0, 0.0]))
    return Tangent(Frame(np.array([x, *rail.points(at)[0]]), rotation(roll=angle)), angle, theta)


def _seams(overlaps: list[Overlap], frame: Frame, join: float, separate: float) -> Seams:
    """Between neighbours that are not as near as to be one part."""
    found = []
    for left, right in pairwise(overlaps):
        weight = seam_weight(_apart(left, right), join, separate)
        if weight < 1:
            middle = (left.surface[-1] + right.surface[0]) / 2
            found.append((float((middle - frame.origin[1:]) @ frame.axes[1:, 1]), weight))
    return tuple(found)


def _grid(overlaps: list[Overlap], frame: Frame, sides: tuple[float, float] | None) -> Grid:
    """Elements over the overlap, and around it; the frame's origin is in the middle of one."""
    along = np.concatenate([each.points[:, 0] + sign * each.half_lengths for each in overlaps for sign in (-1, 1)])
    surface = np.concatenate([each.surface for each in overlaps])
    across = (surface - frame.origin[1:]) @ frame.axes[1:, 1]
    dx, dy = sides or (float(np.ptp(along)) / SAMPLES, float(np.ptp(across)) / SAMPLES)
    if not min(dx, dy) > 0:
        raise NotConverged("wheel and rail overlap by no more than their heights are rounded", math.nan)
    guard = GUARD if sides else AROUND
    left, right, bottom, top = (
        (math.floor if low else math.ceil)(value) + (-guard if low else guard)
        for value, low in (
            ((along.min() - frame.origin[0]) / dx, True),
            ((along.max() - frame.origin[0]) / dx, False),
            (across.min() / dy, True),
            (across.max() / dy, False),
        )
    )
    nx, ny = right - left + 1, top - bottom + 1
    if nx * ny > MOST:
        raise SceneError(
            "dx, dy",
            (dx, dy),
            message=f"dx = {dx:g}, dy = {dy:g} mm make {nx} x {ny} elements of a contact of "
            f"{nx * dx:.3g} x {ny * dy:.3g} mm; {MOST} are allowed at most: give larger ones",
        )
    return Grid(nx=nx, ny=ny, dx=dx, dy=dy, x0=(left - 0.5) * dx, y0=(bottom - 0.5) * dy)


def _rail_heights(rail: Curve, frame: Frame, grid: Grid) -> np.ndarray:
    """z of the rail's surface in the frame, at the rows of the grid; NaN beyond the profile."""
    along, normal = frame.axes[1:, 1], frame.axes[1:, 2]
    near = float(rail.at(frame.origin[1:2], np.array([1.0, 0.0]))[0])
    part = rail.single_valued(along, near)
    s = part.at(grid.y + along @ frame.origin[1:], along)
    return np.asarray((part.points(s) - frame.origin[1:]) @ normal)


def _wheel_heights(
    locus: Locus, wheel: Curve, frame: Frame, grid: Grid, axle: np.ndarray, centre: np.ndarray
) -> np.ndarray:
    """z of the wheel's surface in the frame, at the elements' centres: Newton's method for (theta, s) of each."""
    axes = frame.axes.T @ axle  # of the frame, along the axle's
    middle = frame.axes.T @ (centre - frame.origin)
    s, theta = _start(locus, frame, grid, float(centre[2]))
    wanted_x, wanted_y = np.broadcast_arrays(grid.x[None, :], grid.y[:, None])
    known = np.broadcast_to(np.isfinite(s)[:, None], grid.shape)
    s, theta = (np.broadcast_to(each[:, None], grid.shape)[known] for each in (s, theta))
    x, y = wanted_x[known], wanted_y[known]
    heights = np.full(grid.shape, np.nan)
    if not known.any():
        return heights
    for _ in range(STEPS):
        point, by_theta, by_s = _surface(wheel, theta, s, axes, middle)
        off_x, off_y = x - point[0], y - point[1]
        if max(np.abs(off_x).max(), np.abs(off_y).max()) < CLOSE:
            break
        determinant = by_theta[0] * by_s[1] - by_s[0] * by_theta[1]
        theta = theta + (off_x * by_s[1] - off_y * by_s[0]) / determinant
        s = s + (off_y * by_theta[0] - off_x * by_theta[1]) / determinant
    inside = (s >= wheel.s[0]) & (s <= wheel.s[-1]) & (np.hypot(off_x, off_y) < 1e3 * CLOSE)
    heights[known] = np.where(inside, _surface(wheel, theta, s, axes, middle)[0][2], np.nan)
    return heights


def _start(locus: Locus, frame: Frame, grid: Grid, height: float) -> tuple[np.ndarray, np.ndarray]:
    """(s, theta) of the locus at the rows of the grid; NaN where it does not reach."""
    points = locus.points + np.array([0.0, 0.0, height - locus.height])
    across = (points - frame.origin) @ frame.axes[:, 1]
    nearest = int(np.hypot(*(points[:, 1:] - frame.origin[1:]).T).argmin())
    falls = np.flatnonzero(np.diff(across) <= 0)
    first = int(falls[falls < nearest][-1]) + 1 if (falls < nearest).any() else 0
    last = int(falls[falls >= nearest][0]) if (falls >= nearest).any() else across.size - 1
    run = slice(first, last + 1)
    return (
        np.interp(grid.y, across[run], locus.s[run], left=np.nan, right=np.nan),
        np.interp(grid.y, across[run], locus.theta[run], left=np.nan, right=np.nan),
    )


def _surface(
    wheel: Curve, theta: np.ndarray, s: np.ndarray, axes: np.ndarray, middle: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Points of the wheel in the frame, shape (3, ...), and their derivatives by theta and s."""
    y, r = np.moveaxis(wheel.points(s), -1, 0)
    dy, dr = np.moveaxis(wheel.directions(s), -1, 0)
    sine, cosine = np.sin(theta), np.cos(theta)
    return (
        np.tensordot(axes, np.array([r * sine, y, r * cosine]), 1) + middle.reshape(3, *[1] * np.ndim(s)),
        np.tensordot(axes, np.array([r * cosine, np.zeros_like(y), -r * sine]), 1),
        np.tensordot(axes, np.array([dr * sine, dy, dr * cosine]), 1),
    )
