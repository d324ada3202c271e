"""Where a wheel touches a rail: the contact locus, and the contact patches with their planes and distances.

On each circle of the wheel one point can touch a rail that is straight along x: the one whose normal has no component
along x (Wang 1984, "The track of wheel contact points and the calculation of wheel/rail geometric contact parameters").
These points are the contact locus. It depends on roll and yaw, and is moved up and down by the height of the axle.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from varcontact.errors import NoContact, NotConverged, SceneError
from varcontact.kinematics import Frame, rotation
from varcontact.scene.grid import Grid
from varcontact.system.process import one_blas_thread
from varcontact.wheel_rail.curve import Curve

STEP = 0.05
"""Distance of the circles of the wheel [mm]."""
GUARD = 1
"""Elements beyond the overlap on every side."""
SAMPLES, AROUND = 100, 20
"""Samples across the overlap for grids of any size, and beyond it on every side, where the search for a grid may go."""
STEPS, CLOSE = 12, 1e-9
"""Newton steps to the wheel's surface, and the error that ends them [mm]."""
MOST = 400_000
"""Elements of a potential contact."""
FALL = 0.8
"""Exponent of the fall of a seam's weight with the distance of its parts, CONTACT's."""

Seams = tuple[tuple[float, float], ...]
"""Where parts of a patch meet along y, ascending, and the weights with which they feel each other."""


@dataclass(frozen=True, eq=False)
class Locus:
    """The points of a wheel that come nearest to a rail, with the axle at the height 0.

    Attributes
    ----------
    s : ndarray, shape (n,)
        Parameters of the circles on the wheel's curve [mm].
    theta : ndarray, shape (n,)
        Their angles on the circles, forward from the bottom [rad].
    points : ndarray, shape (n, 3)
        In track coordinates [mm].
    radii : ndarray, shape (n,)
        Of the circles [mm].
    gap : ndarray, shape (n,)
        Height above the rail [mm]; infinite beside it.
    angles : ndarray, shape (n,)
        Inclination of the rail below [rad].
    height : float
        Of the middle of the axle in track coordinates, where its height z is 0 [mm].
    """

    s: np.ndarray
    theta: np.ndarray
    points: np.ndarray
    radii: np.ndarray
    gap: np.ndarray
    angles: np.ndarray
    height: float

    @property
    def touching(self) -> float:
        """The height of the axle, z down, at which the wheel just touches the rail [mm]."""
        return float(self.gap.min())

    def overlaps(self, z: float) -> list[Overlap]:
        """Runs of circles that are below the rail's surface, from left to right.

        Parameters
        ----------
        z : float
            Height of the axle, downwards [mm].

        Raises
        ------
        NoContact
            If the wheel is above the rail.
        SceneError
            If the contact reaches the end of a profile.
        """
        if z <= self.touching:
            reason = (
                f"no contact: with z = {z:.6g} mm the wheel is {self.touching - z:.3g} mm above the rail; "
                f"it touches at z = {self.touching:.6g} mm"
            )
            raise NoContact("z", z, message=reason)
        inside = np.concatenate([[False], self.gap < z, [False]])
        edges = np.flatnonzero(np.diff(inside.astype(int))).tolist()
        found = []
        for first, stop in zip(edges[::2], edges[1::2], strict=True):
            for end, beside in ((first, first - 1), (stop - 1, stop)):
                if not 0 <= beside < self.gap.size or not np.isfinite(self.gap[beside]):
                    reason = (
                        f"the contact reaches the end of a profile near y = {self.points[end, 1]:.4g} mm, where the "
                        f"wheel is {z - self.gap[end]:.3g} mm below the rail's surface: a profile is too narrow or too "
                        "rough, or the load too large"
                    )
                    raise SceneError("z", z, message=reason)
            found.append(overlap(self, slice(first, stop), z))
        return found


@dataclass(frozen=True, eq=False)
class Overlap:
    """A run of circles of the wheel that are below the rail's surface, with the axle at some height."""

    run: slice
    """Of the locus."""
    locus: Locus
    points: np.ndarray
    """Of the locus at this height, shape (n, 3)."""
    depth: np.ndarray
    """Below the rail's surface, shape (n,)."""
    surface: np.ndarray
    """(y, z) of the rail above the points, shape (n, 2)."""
    half_lengths: np.ndarray
    """Along x, over which the circles are below the surface, shape (n,)."""
    weights: np.ndarray
    """The squared depth, summed up along x and over the width of each circle, shape (n,): CONTACT has the origin of a
    patch at the weighted centre."""


def overlap(locus: Locus, run: slice, z: float) -> Overlap:
    """The overlap of a run of circles at a height of the axle; circles above the rail have negative depths."""
    points = np.asarray(locus.points[run] + [0.0, 0.0, z])
    depth = np.asarray(z - locus.gap[run])
    surface = np.stack([points[:, 1], points[:, 2] - depth], axis=1)
    half_lengths = np.sqrt(2 * locus.radii[run] * np.maximum(depth, 0.0))
    width = np.abs(np.gradient(points[:, 1])) if depth.size > 1 else np.ones(1)
    return Overlap(run, locus, points, depth, surface, half_lengths, depth**2 * half_lengths * width)


@one_blas_thread()
def contact_locus(wheel: Curve, rail: Curve, rotation: np.ndarray, centre: np.ndarray) -> Locus:
    """The contact locus of a wheel over a rail.

    Parameters
    ----------
    wheel : Curve
        (y along the axle, radius), y growing.
    rail : Curve
        (y, z) in track coordinates, y growing.
    rotation : ndarray, shape (3, 3)
        The axle's axes in track coordinates.
    centre : ndarray, shape (3,)
        The middle of the axle in track coordinates, at the height 0.

    Raises
    ------
    NoContact
        If no point of it is above the rail.

    Notes
    -----
    The normal of a surface of revolution of radius ``r(y)`` is along ``(sin(theta), -r', cos(theta))`` in the frame of
    the axle. That its component along the track is zero makes one equation for theta, solved in closed form.
    """
    s = wheel.sampled(STEP)
    y, r = wheel.points(s).T
    along = wheel.directions(s)
    a, b, c = rotation[0]
    slope = b * along[:, 1] / (along[:, 0] * np.hypot(a, c))
    possible = np.abs(slope) < 1
    s, y, r, slope = (each[possible] for each in (s, y, r, slope))
    theta = np.arcsin(slope) - np.arctan2(c, a)
    points = np.stack([r * np.sin(theta), y, r * np.cos(theta)], axis=1) @ rotation.T + centre
    below = rail.at(points[:, 1])
    over = np.isfinite(below)
    if not over.any():
        ends = rail.points(rail.s[[0, -1]])[:, 0]
        reason = (
            f"the wheel is beside the rail: it spans y from {points[:, 1].min():.5g} to {points[:, 1].max():.5g} mm, "
            f"the rail from {ends[0]:.5g} to {ends[1]:.5g} mm"
        )
        raise NoContact("position.y", float(centre[1]), message=reason)
    gap, angles = np.full(s.size, np.inf), np.zeros(s.size)
    gap[over] = rail.points(below[over])[:, 1] - points[over, 2]
    angles[over] = rail.angles(below[over])
    return Locus(s, theta, points, r, gap, angles, float(centre[2]))


def joined(overlaps: list[Overlap], nearer: float) -> list[list[Overlap]]:
    """Overlaps in groups that make one patch: neighbours on the rail are nearer to each other than a distance [mm]."""
    groups = [[overlaps[0]]]
    for left, right in pairwise(overlaps):
        if _apart(left, right) < nearer:
            groups[-1].append(right)
        else:
            groups.append([right])
    return groups


def _apart(left: Overlap, right: Overlap) -> float:
    """Gap between neighbours on the rail's surface [mm]."""
    return math.hypot(*(right.surface[0] - left.surface[-1]))


@dataclass(frozen=True, eq=False)
class Tangent:
    """The plane of a contact patch: its contact angle about x [rad], and its frame.

    The origin is on the rail's surface at the weighted centre of the overlap; axes are as of `ContactPatch`.
    """

    frame: Frame
    angle: float


def tangent_of(overlaps: list[Overlap], rail: Curve) -> Tangent:
    """The plane of a group of overlaps by itself."""
    weights = np.concatenate([each.weights for each in overlaps])
    weights = weights / weights.sum()
    points = np.concatenate([each.points for each in overlaps])
    angle = float(weights @ np.concatenate([each.locus.angles[each.run] for each in overlaps]))
    x, y = (float(weights @ points[:, i]) for i in (0, 1))
    surface = rail.points(rail.at(np.array([y])))[0]
    return Tangent(Frame(np.array([x, *surface]), rotation(roll=angle)), angle)


def tangents_of(groups: list[list[Overlap]], rail: Curve, separate: float, turn: float) -> list[Tangent]:
    """The planes of all patches, those of near neighbours turned towards each other.

    Where the gap between two is `separate`, both have the angle that they would have as one patch, from `turn` on their
    own: so does CONTACT (D_TURN), and forces do not jump as patches become one.
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
    return [
        Tangent(Frame(each.frame.origin, rotation(roll=angle)), angle)
        for each, angle in zip(found, turned.tolist(), strict=True)
    ]


def undeformed_distance(
    overlaps: list[Overlap],
    frame: Frame,
    wheel: Curve,
    rail: Curve,
    axle: np.ndarray,
    centre: np.ndarray,
    sides: tuple[float, float] | None = None,
) -> tuple[Grid, np.ndarray, float]:
    """Potential contact in the frame of a patch, the distance along its z from the wheel to the rail, and the approach.

    `axle` has the axes of the axle, shape (3, 3), and `centre` its middle in track coordinates; `sides` are those of an
    element, fine enough to interpolate on any grid if None. The distance, shape (ny, nx), is 0 at its least [mm].
    """
    along, normal = frame.axes[1:, 1], frame.axes[1:, 2]
    across = [(each.surface - frame.origin[1:]) @ along for each in overlaps]
    grid = grid_over(overlaps, frame, np.concatenate(across), sides)
    part = rail.single_valued(float(rail.at(frame.origin[1:2])[0]), along)
    on_rail = part.points(part.at(grid.y + along @ frame.origin[1:], along))
    rail_heights = np.asarray((on_rail - frame.origin[1:]) @ normal)
    gap = rail_heights[:, None] - wheel_heights(overlaps[0].locus, wheel, frame, (grid.x, grid.y), axle, centre)
    known = np.isfinite(gap)
    if not known.any():
        raise too_rough(float(frame.origin[1]))
    if gap[known].min() >= 0:
        reason = (
            f"dx = {grid.sides[0]:g}, dy = {grid.sides[1]:g} mm: no element's centre is where wheel and rail overlap "
            f"near y = {frame.origin[1]:.4g} mm; give smaller ones, or smooth a rough profile, "
            "Profile(..., smoothing=...)"
        )
        raise SceneError("dx, dy", grid.sides, message=reason)
    gap = np.where(known, gap, gap[known].max() + abs(gap[known]).max())  # beside a profile's end nothing touches
    return grid, gap - gap.min(), -float(gap.min())


def seams_of(overlaps: list[Overlap], frame: Frame, join: float, separate: float) -> Seams:
    """Seams between overlaps that are more than `join` apart; from `separate` on, parts do not feel each other."""
    seams = []
    for left, right in pairwise(overlaps):
        apart = _apart(left, right)
        if apart > join:
            middle = (left.surface[-1] + right.surface[0]) / 2
            weight = max(0.0, (separate - apart) / (separate - join)) ** FALL
            seams.append((float((middle - frame.origin[1:]) @ frame.axes[1:, 1]), weight))
    return tuple(seams)


def too_rough(y: float) -> SceneError:
    """The error of surfaces that cannot be followed near a place on the track [mm]."""
    reason = (
        f"wheel and rail cannot be followed along their surfaces near y = {y:.4g} mm: a profile is too rough there; "
        "smooth it, Profile(..., smoothing=...)"
    )
    return SceneError("profile", y, message=reason)


def grid_over(overlaps: list[Overlap], frame: Frame, across: np.ndarray, sides: tuple[float, float] | None) -> Grid:
    """Elements over the overlap and y `across` it, and around it; the frame's origin is in the middle of one."""
    along = np.concatenate([each.points[:, 0] + sign * each.half_lengths for each in overlaps for sign in (-1, 1)])
    dx, dy = sides or (float(np.ptp(along)) / SAMPLES, float(np.ptp(across)) / SAMPLES)
    if not min(dx, dy) > 0:
        raise NotConverged("wheel and rail overlap by no more than their heights are rounded", math.nan)
    guard = GUARD if sides else AROUND
    left = math.floor((along.min() - frame.origin[0]) / dx) - guard
    right = math.ceil((along.max() - frame.origin[0]) / dx) + guard
    bottom, top = math.floor(across.min() / dy) - guard, math.ceil(across.max() / dy) + guard
    nx, ny = right - left + 1, top - bottom + 1
    if nx * ny > MOST:
        reason = (
            f"dx = {dx:g}, dy = {dy:g} mm make {nx} x {ny} elements of a contact of {nx * dx:.3g} x {ny * dy:.3g} mm; "
            f"{MOST} are allowed at most: give larger ones"
        )
        raise SceneError("dx, dy", (dx, dy), message=reason)
    return Grid(nx=nx, ny=ny, dx=dx, dy=dy, x0=(left - 0.5) * dx, y0=(bottom - 0.5) * dy)


def wheel_heights(
    locus: Locus,
    wheel: Curve,
    frame: Frame,
    lines: tuple[np.ndarray, np.ndarray],
    axle: np.ndarray,
    centre: np.ndarray,
) -> np.ndarray:
    """z of the wheel's surface in the frame, where lines of x and y cross: Newton's method for (theta, s) of each.

    It begins with the locus at the rows of the grid; NaN where that does not reach.
    """
    points = locus.points + np.array([0.0, 0.0, float(centre[2]) - locus.height])
    across = (points - frame.origin) @ frame.axes[:, 1]
    nearest = int(np.hypot(*(points[:, 1:] - frame.origin[1:]).T).argmin())
    falls = np.flatnonzero(np.diff(across) <= 0)
    first = int(max(falls[falls < nearest] + 1, default=0))
    run = slice(first, int(min(falls[falls >= nearest], default=across.size - 1)) + 1)
    grid_x, grid_y = lines
    shape = grid_y.size, grid_x.size
    rows = [np.interp(grid_y, across[run], each[run], left=np.nan, right=np.nan) for each in (locus.s, locus.theta)]
    known = np.broadcast_to(np.isfinite(rows[0])[:, None], shape)
    heights = np.full(shape, np.nan)
    if not known.any():
        return heights
    starts: Sequence[np.ndarray] = (rows[0][:, None], rows[1][:, None], grid_x[None, :], grid_y[:, None])
    s, theta, x, y = (np.broadcast_to(each, shape)[known] for each in starts)
    axes = frame.axes.T @ axle  # of the frame, along the axle's
    middle = frame.axes.T @ (centre - frame.origin)
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


def _surface(
    wheel: Curve, theta: np.ndarray, s: np.ndarray, axes: np.ndarray, middle: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Points of the wheel in the frame, shape (3, n), and their derivatives with respect to theta and s."""
    y, r = np.moveaxis(wheel.points(s), -1, 0)
    dy, dr = np.moveaxis(wheel.directions(s), -1, 0)
    sine, cosine = np.sin(theta), np.cos(theta)
    return (
        np.tensordot(axes, np.array([r * sine, y, r * cosine]), 1) + middle[:, None],
        np.tensordot(axes, np.array([r * cosine, np.zeros_like(y), -r * sine]), 1),
        np.tensordot(axes, np.array([dr * sine, dy, dr * cosine]), 1),
    )
