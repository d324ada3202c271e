"""Contact patches: where the contact locus is below the rail's surface, with their planes and
distances.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from varcontact.errors import NotConverged, SceneError
from varcontact.kinematics import Frame, RigidBody, rotation
from varcontact.scene.grid import Grid
from varcontact.wheel_rail.curve import Curve, growing, spline
from varcontact.wheel_rail.locus import Locus, Overlap
from varcontact.wheel_rail.locus import contact_locus as contact_locus
from varcontact.wheel_rail.slices import RailSurface, Surface

GUARD = 1
"""Elements beyond the overlap on every side."""
SAMPLES, AROUND = 100, 20
"""Samples across the overlap for grids of any size, and beyond it on every side, where the search
for a grid may go."""
STEPS, CLOSE = 12, 1e-5
"""Newton steps to the wheel's surface, and the error before the last one [mm], which squares it by
the radius."""
NOWHERE = 10.0
"""Distance where there is no rail, by the largest where there is one: a cliff, which is not taken
for noise."""
MOST = 400_000
"""Elements of a potential contact."""
FALL = 0.8
"""Exponent of the fall of a seam's weight with the distance of its parts, CONTACT's."""

Seams = tuple[tuple[float, float], ...]
"""Where parts of a patch meet along y, ascending, and the weights with which they feel each
other."""


def joined(overlaps: list[Overlap], nearer: float) -> list[list[Overlap]]:
    """Overlaps in groups that make one patch: neighbours on the rail are nearer to each other than
    a distance [mm].
    """
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
    """The plane of a contact patch: its contact angle about x [rad], and its frame; the angle about
    y of a slope.

    The origin is on the rail's surface at the weighted centre of the overlap; axes are as of
    `ContactPatch`.
    """

    frame: Frame
    angle: float
    slope: float = 0.0


def tangent_of(overlaps: list[Overlap], rail: Curve | RailSurface) -> Tangent:
    """The plane of a group of overlaps by itself."""
    weights = np.concatenate([each.weights for each in overlaps])
    weights = weights / weights.sum()
    points = np.concatenate([each.points for each in overlaps])
    angle = float(weights @ np.concatenate([each.locus.angles[each.run] for each in overlaps]))
    x, y = (float(weights @ points[:, i]) for i in (0, 1))
    if isinstance(rail, Curve):
        surface, slope = rail.points(rail.at(np.array([y])))[0], 0.0
    else:
        slopes = [each.locus.slopes[each.run] for each in overlaps if each.locus.slopes is not None]
        slope = -math.atan(float(weights @ np.concatenate(slopes)) * math.cos(angle))
        z = float(rail.along(np.array([[[x, y, 0.0]]]), np.array([0.0, 0.0, 1.0]))[0].item())
        # the nearest where there is a gap
        known = np.concatenate([each.surface for each in overlaps])
        surface = np.array([y, z]) if np.isfinite(z) else known[np.abs(known[:, 0] - y).argmin()]
    return Tangent(Frame(np.array([x, *surface]), rotation(roll=angle, pitch=slope)), angle, slope)


def tangents_of(
    groups: list[list[Overlap]], rail: Curve | RailSurface, separate: float, turn: float
) -> list[Tangent]:
    """The planes of all patches, those of near neighbours turned towards each other.

    Where the gap between two is `separate`, both have the angle that they would have as one patch,
    from `turn` on their own: so does CONTACT (D_TURN), and forces do not jump as patches become
    one.
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
    for i in np.flatnonzero(turned != angles).tolist():
        angle, slope = float(turned[i]), found[i].slope
        found[i] = Tangent(
            Frame(found[i].frame.origin, rotation(roll=angle, pitch=slope)), angle, slope
        )
    return found


def seams_of(overlaps: list[Overlap], frame: Frame, join: float, separate: float) -> Seams:
    """Seams between overlaps that are more than `join` apart; from `separate` on, parts do not feel
    each other.
    """
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
    reason = f"near y = {y:.4g} mm a profile is too rough to follow; smooth it, Profile(..., smoothing=...)"
    return SceneError("profile", y, message=reason)


def grid_over(
    overlaps: list[Overlap], frame: Frame, across: np.ndarray, sides: tuple[float, float] | None
) -> Grid:
    """Elements over the overlap and y `across` it, and around it; the frame's origin is in the
    middle of one.
    """
    along = np.concatenate([each.ends.ravel() for each in overlaps])
    dx, dy = sides or (float(np.ptp(along)) / SAMPLES, float(np.ptp(across)) / SAMPLES)
    if not min(dx, dy) > 0:
        raise NotConverged(
            "wheel and rail overlap by no more than their heights are rounded", math.nan
        )
    guard = GUARD if sides else AROUND
    left = math.floor((along.min() - frame.origin[0]) / dx) - guard
    right = math.ceil((along.max() - frame.origin[0]) / dx) + guard
    bottom, top = math.floor(across.min() / dy) - guard, math.ceil(across.max() / dy) + guard
    nx, ny = right - left + 1, top - bottom + 1
    if nx * ny > MOST:
        reason = f"dx = {dx:g}, dy = {dy:g} mm make {nx} x {ny} elements, more than {MOST}: give larger ones"
        raise SceneError("dx, dy", (dx, dy), message=reason)
    return Grid(nx=nx, ny=ny, dx=dx, dy=dy, x0=(left - 0.5) * dx, y0=(bottom - 0.5) * dy)


def wheel_heights(
    locus: Locus,
    wheel: Curve | Surface,
    frame: Frame,
    lines: tuple[np.ndarray, np.ndarray],
    axle: np.ndarray,
    centre: np.ndarray,
) -> np.ndarray:
    """z of the wheel's surface in the frame, where lines of x and y cross: Newton's method for
    (theta, s) of each.

    It begins with the locus at the rows of the grid, turned by x; NaN where that does not reach,
    and where the surface faces away from the rail.
    """
    points = locus.points + np.array([0.0, 0.0, float(centre[2]) - locus.height])
    along, across, _ = ((points - frame.origin) @ frame.axes).T
    forward = frame.axes.T @ axle[:, 0]
    across = across - along * forward[1] / forward[0]  # of circles at x = 0
    run = growing(
        np.diff(across) > 0, int(np.hypot(*(points[:, 1:] - frame.origin[1:]).T).argmin())
    )
    grid_x, grid_y = lines
    shape = grid_y.size, grid_x.size
    by_row = locus.s, locus.theta, along, locus.radii
    rows = [
        np.interp(grid_y, across[run], each[run], left=np.nan, right=np.nan)[:, None]
        for each in by_row
    ]
    known = np.broadcast_to(np.isfinite(rows[0]), shape)
    heights = np.full(shape, np.nan)
    if not known.any():
        return heights
    starts: Sequence[np.ndarray] = (
        rows[0],
        rows[1] + (grid_x - rows[2]) / rows[3],
        grid_x,
        grid_y[:, None],
    )
    s, theta, to_x, to_y = (np.broadcast_to(each, shape)[known] for each in starts)
    axes = frame.axes.T @ axle  # of the frame, along the axle's
    middle = frame.axes.T @ (centre - frame.origin)
    for _ in range(STEPS):
        if isinstance(wheel, Curve):
            (y, r), (ty, tr), (dy, dr) = (
                wheel.points(s).T,
                np.zeros((2, s.size)),
                wheel.directions(s).T,
            )
        else:
            (y, r), (ty, tr), (dy, dr) = np.moveaxis(wheel.points(theta, s), -1, 1)
        sine, cosine = np.sin(theta), np.cos(theta)
        point = axes @ np.array([r * sine, y, r * cosine]) + middle[:, None]
        by_theta = axes @ np.array([r * cosine + tr * sine, ty, tr * cosine - r * sine])
        by_s = axes @ np.array([dr * sine, dy, dr * cosine])
        off_x, off_y = to_x - point[0], to_y - point[1]
        determinant = by_theta[0] * by_s[1] - by_s[0] * by_theta[1]
        turned = (off_x * by_s[1] - off_y * by_s[0]) / determinant
        along = (off_y * by_theta[0] - off_x * by_theta[1]) / determinant
        theta, s, off = theta + turned, s + along, np.hypot(off_x, off_y)
        if off.max() < CLOSE:
            break
    inside = (s >= wheel.s[0]) & (s <= wheel.s[-1]) & (off < CLOSE) & (determinant > 0)
    heights[known] = np.where(inside, point[2] + by_theta[2] * turned + by_s[2] * along, np.nan)
    return heights


@dataclass(frozen=True, eq=False)
class ReferenceSurface:
    """The plane or curved surface that a patch is solved on, with the distance of the bodies; y is
    its arc length.

    The distance, shape (ny, nx), is 0 at its least [mm]. The inclination is that of each row of
    elements relative to the frame's y [rad], `lateral` its place along that (NaN beyond a profile's
    end), and `on_wheel` are the points (ny, 3) of the wheel opposite, in track coordinates.
    """

    grid: Grid
    distance: np.ndarray
    approach: float
    inclination: np.ndarray
    lateral: np.ndarray
    on_wheel: np.ndarray

    def rigid_slip(self, frame: Frame, body: RigidBody, speed: float) -> np.ndarray:
        """Velocity of the rail over the wheel in the frames of the elements, divided by a speed,
        (2, ny, nx).
        """
        along = self.grid.x[:, None] * frame.axes[:, 0]
        velocity = -body.velocity_at(self.on_wheel[:, None] + along) @ frame.axes / speed
        c, s = np.cos(self.inclination)[:, None], np.sin(self.inclination)[:, None]
        return np.array([velocity[..., 0], c * velocity[..., 1] + s * velocity[..., 2]])


def reference_surface(
    overlaps: list[Overlap],
    tangent: Tangent,
    wheel: Curve | Surface,
    rail: Curve | RailSurface,
    axle: np.ndarray,
    centre: np.ndarray,
    sides: tuple[float, float] | None,
    curved: bool,
) -> ReferenceSurface:
    """The plane of a patch, or its `curved` surface, with the distance from the wheel to the rail
    along its normals.

    `axle` has the axes of the axle, shape (3, 3), and `centre` its middle in track coordinates;
    `sides` are those of an element, fine enough to interpolate on any grid if None.
    """
    frame = tangent.frame
    origin, along, normal = frame.origin[1:], frame.axes[1:, 1], frame.axes[1:, 2]
    if curved and isinstance(rail, Curve):
        grid, inclination, lateral, height = _halfway(overlaps, tangent, rail, sides)
    else:
        across = [(each.surface - origin) @ along for each in overlaps]
        grid = grid_over(overlaps, frame, np.concatenate(across), sides)
        lateral, (inclination, height) = grid.y, np.zeros((2, grid.rows))
    if isinstance(rail, Curve):
        part = rail.single_valued(float(rail.at(origin[:1])[0]), along)
        rail_heights = ((part.points(part.at(lateral + along @ origin, along)) - origin) @ normal)[
            :, None
        ]
    else:
        flat = np.stack([*np.meshgrid(grid.x, grid.y), np.zeros((grid.rows, grid.x.size))], axis=-1)
        rail_heights, *_ = rail.along(frame.globally(flat), frame.axes[:, 2])
    heights = wheel_heights(overlaps[0].locus, wheel, frame, (grid.x, lateral), axle, centre)
    cosine = np.cos(inclination)
    gap = (rail_heights - heights) * cosine[:, None]
    known = np.isfinite(gap)
    if not known.any():
        raise too_rough(float(origin[0]))
    if gap[known].min() >= 0:
        none = (
            f"no element's centre is in the overlap near y = {origin[0]:.4g} mm; give smaller ones"
        )
        reason = (
            f"dx = {grid.sides[0]:g}, dy = {grid.sides[1]:g} mm: {none}, or smooth a rough profile"
        )
        raise SceneError("dx, dy", grid.sides, message=reason)
    # where there is no rail, beside its profile and beyond its end, nothing touches
    gap = np.where(known, gap, NOWHERE * abs(gap[known]).max())
    # to the wheel, along normals
    away = (heights[:, int(np.abs(grid.x).argmin())] - height) * cosine
    opposite = np.stack(
        [0.0 * height, lateral - np.sin(inclination) * away, height + cosine * away], axis=1
    )
    on_wheel = frame.globally(np.nan_to_num(opposite))
    return ReferenceSurface(
        grid, gap - gap.min(), -float(gap.min()), inclination, lateral, on_wheel
    )


def _halfway(
    overlaps: list[Overlap], tangent: Tangent, rail: Curve, sides: tuple[float, float] | None
) -> tuple[Grid, np.ndarray, np.ndarray, np.ndarray]:
    """The grid, inclination, and place along y and z of the frame of a surface halfway between rail
    and wheel.

    Points of both surfaces at equal arc lengths from the origin of the patch are opposite each
    other. The surface runs through their means, its normals are the means of theirs, and it is
    straight along the rail. Source: Vollebregt, Segal, VSD 52 (2014) 455-468; CONTACT's conformal
    method.
    """
    origin, along = tangent.frame.origin[1:], tangent.frame.axes[1:, 1]
    on_rail = rail.single_valued(float(rail.at(origin[:1])[0]), along)
    # the wheel's part around the origin that grows along the plane: its contact locus, in track
    # coordinates
    locus = overlaps[0].locus
    places = (locus.points + (overlaps[0].points[0] - locus.points[overlaps[0].run][0]))[:, 1:]
    run = growing(np.diff(places @ along) > 0, int(np.hypot(*(places - origin).T).argmin()))
    on_wheel = spline(places[run], np.zeros(0, dtype=int), 0.0)
    begins = [
        float(curve.at(np.array([along @ origin]), along)[0]) for curve in (on_rail, on_wheel)
    ]
    surface = np.concatenate([each.surface for each in overlaps])
    arc = on_rail.at(surface @ along, along) - begins[0]
    if not np.isfinite([*arc, *begins]).all():
        raise too_rough(float(origin[0]))
    grid = grid_over(overlaps, tangent.frame, arc, sides)
    points, directions = np.zeros((2, grid.rows, 2)), np.zeros((2, grid.rows, 2))
    for i, (curve, begin) in enumerate(zip((on_rail, on_wheel), begins, strict=True)):
        s = begin + grid.y
        within = np.where((s >= curve.s[0]) & (s <= curve.s[-1]), s, np.nan)
        points[i], directions[i] = curve.points(within), curve.directions(within)
        directions[i] /= np.hypot(*directions[i].T)[:, None]
    middle, (to_right, down) = points.mean(axis=0), directions.mean(axis=0).T
    known = np.isfinite(middle).all(axis=1)
    inclination = np.interp(
        grid.y, grid.y[known], (np.arctan2(down, to_right) - tangent.angle)[known]
    )
    lateral, height = ((middle - origin) @ tangent.frame.axes[1:, 1:]).T
    return grid, inclination, lateral, height
