"""Contact patches: where the contact locus is below the rail's surface, with their planes and
distances.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np

from varcontact.errors import NotConverged, SceneError
from varcontact.kinematics import Frame, RigidBody
from varcontact.kinematics.rigid import turned
from varcontact.scene.grid import Grid
from varcontact.system.process import changed
from varcontact.wheel_rail.curve import STEP, Curve, growing, spline
from varcontact.wheel_rail.locus import Locus, Overlap
from varcontact.wheel_rail.locus import contact_locus as contact_locus
from varcontact.wheel_rail.slices import RailSurface, Surface

AT_ORIGIN = Frame(np.zeros(3), np.eye(3))
ANY_GRID = Grid(nx=1, ny=1)
GUARD = 1
"""Margin around the overlap on every side [elements]."""
SAMPLES = 100
"""Samples across the overlap for grids of any size."""
SAMPLES_BESIDE = 20
"""Samples beyond the overlap on every side, for the search for a grid."""
NEWTON_STEPS = 12
"""Newton steps to the wheel's surface."""
NEWTON_TOL = 1e-5
"""Length on the surface of the last of these steps [mm]: the error after it is about its square,
divided by the radius."""
NOWHERE = 10.0
"""Distance where there is no rail, divided by the largest distance where there is one: a cliff, not
noise."""
MOST = 400_000
"""Largest number of elements of a potential contact."""
FALL = 0.8
"""Exponent of the decay of an interaction weight with the distance between parts, as in CONTACT."""

Interactions = tuple[tuple[float, float], ...]
"""Places along y between parts of a patch, ascending, and the weights of the interaction across
them."""
Sides = tuple[float, float] | None
"""Sides of an element [mm]; None for samples that are interpolated on any grid."""


def joined(overlaps: list[Overlap], nearer: float) -> list[list[Overlap]]:
    """Overlaps in groups that form one patch: neighbours on the rail are closer than `nearer`
    [mm].
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
        slope = 0.0
        surface = rail.points(rail.at(np.array([y])))[0]
    else:
        slopes = [each.locus.slopes[each.run] for each in overlaps if each.locus.slopes is not None]
        slope = -math.atan(float(weights @ np.concatenate(slopes)) * math.cos(angle))
        z = float(rail.along(np.array([[[x, y, 0.0]]]), np.array([0.0, 0.0, 1.0]))[0].item())
        surface = np.array([y, z])
        if not np.isfinite(z):  # the nearest point of the overlaps where the rail has a gap
            touched = np.concatenate([each.surface for each in overlaps])
            surface = touched[np.abs(touched[:, 0] - y).argmin()]
    axes = turned(angle, 0.0, slope)
    return Tangent(changed(AT_ORIGIN, origin=np.array([x, *surface]), axes=axes), angle, slope)


def tangents_of(
    groups: list[list[Overlap]], rail: Curve | RailSurface, separate: float, turn: float
) -> list[Tangent]:
    """The planes of all patches, those of near neighbours turned towards each other.

    Where the gap between two is `separate`, both have the angle that they would have as one patch,
    from `turn` on their own: so does CONTACT (D_TURN), and forces do not jump as patches become
    one.
    """
    tangents = [tangent_of(group, rail) for group in groups]
    if len(groups) == 1:
        return tangents
    angles = np.array([each.angle for each in tangents])
    loads = np.array([sum(float(each.weights.sum()) for each in group) for group in groups])
    new_angles = angles.copy()
    for i, (left, right) in enumerate(pairwise(groups)):
        apart = _apart(left[-1], right[0])
        if apart < turn:
            two = slice(i, i + 2)
            together = float(angles[two] @ loads[two] / loads[two].sum())
            new_angles[two] += (turn - apart) / (turn - separate) * (together - angles[two])
    for i in np.flatnonzero(new_angles != angles).tolist():
        angle = float(new_angles[i])
        slope = tangents[i].slope
        frame = changed(tangents[i].frame, axes=turned(angle, 0.0, slope))
        tangents[i] = Tangent(frame, angle, slope)
    return tangents


def interactions_of(
    overlaps: list[Overlap], frame: Frame, join: float, separate: float
) -> Interactions:
    """Places between overlaps that are more than `join` apart, and interaction weights there, which
    are zero from `separate` on.
    """
    interactions = []
    for left, right in pairwise(overlaps):
        apart = _apart(left, right)
        if apart > join:
            middle = (left.surface[-1] + right.surface[0]) / 2
            weight = max(0.0, (separate - apart) / (separate - join)) ** FALL
            interactions.append((float((middle - frame.origin[1:]) @ frame.axes[1:, 1]), weight))
    return tuple(interactions)


def too_rough(y: float) -> SceneError:
    """Error for surfaces too rough to follow near a place on the track [mm]."""
    reason = (
        f"near y = {y:.4g} mm a profile is too rough to follow; "
        "smooth it, Profile(..., smoothing=...)"
    )
    return SceneError("profile", y, message=reason)


def grid_over(overlaps: list[Overlap], frame: Frame, across: np.ndarray, sides: Sides) -> Grid:
    """Grid over the overlap and y `across` it, with a margin; the frame's origin is the centre of
    an element.
    """
    along = np.concatenate([each.ends.ravel() for each in overlaps])
    dx, dy = sides or (float(np.ptp(along)) / SAMPLES, float(np.ptp(across)) / SAMPLES)
    if not min(dx, dy) > 0:
        rounded = "wheel and rail overlap by no more than their heights are rounded"
        raise NotConverged(f"{rounded}: give a larger vertical_force, or z", math.nan)
    guard = SAMPLES_BESIDE
    if sides:
        guard = GUARD
    left = math.floor((along.min() - frame.origin[0]) / dx) - guard
    right = math.ceil((along.max() - frame.origin[0]) / dx) + guard
    bottom = math.floor(across.min() / dy) - guard
    top = math.ceil(across.max() / dy) + guard
    nx, ny = right - left + 1, top - bottom + 1
    if nx * ny > MOST:
        reason = (
            f"dx = {dx:g}, dy = {dy:g} mm make {nx} x {ny} elements, "
            f"more than {MOST}: give larger ones"
        )
        raise SceneError("dx, dy", (dx, dy), message=reason)
    lattice = {"dx": dx, "dy": dy, "x0": (left - 0.5) * dx, "y0": (bottom - 0.5) * dy}
    return changed(ANY_GRID, nx=nx, ny=ny, **lattice)


def wheel_heights(
    locus: Locus,
    wheel: Curve | Surface,
    frame: Frame,
    lines: tuple[np.ndarray, np.ndarray],
    body: RigidBody,
) -> np.ndarray:
    """z of the wheel's surface in the frame, where lines of x and y cross: Newton's method for
    (z, s) of each.

    It begins with the circles of the locus; NaN where that does not reach, and where the surface
    faces away from the rail.
    """
    axle = body.rotation
    grid_x, grid_y = lines
    heights = np.full((grid_y.size, grid_x.size), np.nan)
    reached, s, z = _on_circles(locus, frame, lines, body)
    if not reached.any():
        return heights

    # the lines through the elements, in the axes of the axle
    to_x, to_y, down = (axle.T @ frame.axes).T
    middle = axle.T @ (frame.origin - body.position)
    rows = middle[:, None] + to_y[:, None] * grid_y[reached]
    columns = to_x[:, None] * grid_x
    at = (rows[:, :, None] + columns[:, None]).reshape(3, -1)

    # Newton's method for (z, s)
    for _ in range(NEWTON_STEPS):
        x, y, below = at + down[:, None] * z
        radius = np.hypot(x, below)
        (wheel_y, wheel_r), (by_theta_y, by_theta_r), (by_s_y, by_s_r) = _wheel_point(
            wheel, x, below, s
        )
        off_y = y - wheel_y
        off_r = radius - wheel_r
        theta_by_z = (below * down[0] - x * down[2]) / radius**2
        y_by_z = down[1] - by_theta_y * theta_by_z
        r_by_z = (x * down[0] + below * down[2]) / radius - by_theta_r * theta_by_z
        determinant = by_s_y * r_by_z - by_s_r * y_by_z
        lowered = (by_s_r * off_y - by_s_y * off_r) / determinant
        along = (r_by_z * off_y - y_by_z * off_r) / determinant
        z = z + lowered
        s = s + along
        # on the surface
        moved = np.hypot(along, radius * theta_by_z * lowered)
        if moved.max() < NEWTON_TOL:
            break
    inside = (s >= wheel.s[0]) & (s <= wheel.s[-1]) & (moved < NEWTON_TOL) & (determinant > 0)
    heights[reached] = np.where(inside, z, np.nan).reshape(-1, grid_x.size)
    return heights


def _on_circles(
    locus: Locus, frame: Frame, lines: tuple[np.ndarray, np.ndarray], body: RigidBody
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Rows of a grid that the circles of a locus reach; and their s, and z in the frame, at the
    elements there: those of the parabola along each circle.
    """
    grid_x, grid_y = lines
    # points of the locus in the frame, and before the lowest points of their circles
    centre = np.array([*body.position[:2], locus.height])
    points = locus.points - centre
    along, across, height = ((points - (frame.origin - body.position)) @ frame.axes).T
    before = points @ body.rotation[:, 0]
    # circles at x = 0
    forward, _, down = body.rotation.T @ frame.axes
    sideways, downhill = forward[1:] / forward[0]
    across = across - along * sideways
    height = height - along * downhill
    from_origin = np.hypot(across, height)
    run = growing(across[1:] > across[:-1], int(from_origin.argmin()))
    across = across[run]
    # at the elements
    reached = (grid_y >= across[0]) & (grid_y <= across[-1])
    rows = grid_y[reached, None]
    along, before, radius = (
        np.interp(rows, across, values[run]) for values in (along, before, locus.radii)
    )
    further = (grid_x - along) / forward[0]
    rise = further * (before + further / 2) / radius
    at = rows - grid_x * sideways + rise * down[1]
    s = np.interp(at, across, locus.s[run])
    z = np.interp(at, across, height[run]) + grid_x * downhill - rise * down[2]
    return reached, s.ravel(), z.ravel()


def _wheel_point(wheel: Curve | Surface, x: np.ndarray, z: np.ndarray, s: np.ndarray) -> Any:
    """(y, radius) of a wheel at `s` in the direction (x, z), and their derivatives by the angle and
    by s, shape (3, 2, n).
    """
    if isinstance(wheel, Curve):
        points, directions = wheel.points_and_directions(s)
        return points, np.zeros(2), directions
    return np.moveaxis(wheel.points(np.arctan2(x, z), s), -1, 1)


@dataclass(frozen=True, eq=False)
class ReferenceSurface:
    """The plane or curved surface that a patch is solved on, with the distance of the bodies; y is
    its arc length.

    The distance, shape (ny, nx), is 0 at its least [mm]. The inclination is that of each row of
    elements relative to the frame's y [rad], `lateral` and `height` its place along y and z of the
    frame (NaN beyond a profile's end), and `away` how far the wheel is along its normal.
    """

    grid: Grid
    distance: np.ndarray
    approach: float
    inclination: np.ndarray
    lateral: np.ndarray
    height: np.ndarray
    away: np.ndarray

    def on_wheel(self, frame: Frame) -> np.ndarray:
        """The points (ny, 3) of the wheel opposite the rows, in track coordinates."""
        across = self.lateral - np.sin(self.inclination) * self.away
        below = self.height + np.cos(self.inclination) * self.away
        opposite = np.stack([np.zeros(across.size), across, below], axis=1)
        return frame.globally(np.nan_to_num(opposite))

    def rigid_slip(
        self, frame: Frame, rail: RigidBody, wheel: RigidBody, speed: float
    ) -> np.ndarray:
        """Velocity of the rail over the wheel in the frames of the elements, divided by a speed,
        (2, ny, nx).
        """
        along = self.grid.x[:, None] * frame.axes[:, 0]
        places = self.on_wheel(frame)[:, None] + along
        velocity = rail.velocity_at(places) - wheel.velocity_at(places)
        velocity = velocity @ frame.axes / speed
        cosine = np.cos(self.inclination)[:, None]
        sine = np.sin(self.inclination)[:, None]
        across = cosine * velocity[..., 1] + sine * velocity[..., 2]
        return np.array([velocity[..., 0], across])


def reference_surface(
    overlaps: list[Overlap],
    tangent: Tangent,
    wheel: Curve | Surface,
    rail: Curve | RailSurface,
    body: RigidBody,
    sides: Sides,
    curved: bool,
) -> ReferenceSurface:
    """The plane of a patch, or its `curved` surface, with the distance from the wheel to the rail
    along its normals.

    `body` is the wheel set, whose position is the middle of its axle.
    """
    # the surface: its grid, inclination, and place in the frame
    frame = tangent.frame
    origin = frame.origin[1:]
    along = frame.axes[1:, 1]
    if curved and isinstance(rail, Curve):
        grid, inclination, lateral, height = _halfway(overlaps, tangent, rail, sides)
    else:
        across = [(each.surface - origin) @ along for each in overlaps]
        grid = grid_over(overlaps, frame, np.concatenate(across), sides)
        lateral = grid.y
        inclination, height = np.zeros((2, grid.rows))

    # the distance along its normals; where there is no rail, beside its profile and beyond its end,
    # nothing touches
    rail_heights = _rail_heights(rail, frame, grid, lateral)
    circles = _circles_near(overlaps, grid)
    heights = wheel_heights(circles, wheel, frame, (grid.x, lateral), body)
    cosine = np.cos(inclination)
    gap = (rail_heights - heights) * cosine[:, None]
    reached = np.isfinite(gap)
    if not reached.any():
        raise too_rough(float(origin[0]))
    if gap[reached].min() >= 0:
        dx, dy = grid.sides
        reason = (
            f"dx = {dx:g}, dy = {dy:g} mm: no element's centre is in the overlap near "
            f"y = {origin[0]:.4g} mm; give smaller ones, or smooth a rough profile"
        )
        raise SceneError("dx, dy", grid.sides, message=reason)
    if not reached.all():
        gap = np.where(reached, gap, NOWHERE * abs(gap[reached]).max())
    away = (heights[:, int(np.abs(grid.x).argmin())] - height) * cosine
    least = float(gap.min())
    return ReferenceSurface(grid, gap - least, -least, inclination, lateral, height, away)


def _circles_near(overlaps: list[Overlap], grid: Grid) -> Locus:
    """The circles of overlaps, and those beside them as far as the grid is wide."""
    locus = overlaps[0].locus
    beside = math.ceil(grid.rows * grid.sides[1] / STEP)
    first = max(0, overlaps[0].run.start - beside)
    return locus.part(slice(first, overlaps[-1].run.stop + beside))


def _rail_heights(
    rail: Curve | RailSurface, frame: Frame, grid: Grid, lateral: np.ndarray
) -> np.ndarray:
    """z of the rail's surface in the frame: one for each row where it is straight, else for each
    element.
    """
    if isinstance(rail, Curve):
        origin = frame.origin[1:]
        along = frame.axes[1:, 1]
        part = rail.single_valued(float(origin[0]), along)
        points = rail.points(part.at(lateral + along @ origin, along))
        return ((points - origin) @ frame.axes[1:, 2])[:, None]
    flat = np.stack([*np.meshgrid(grid.x, grid.y), np.zeros((grid.rows, grid.x.size))], axis=-1)
    heights, *_ = rail.along(frame.globally(flat), frame.axes[:, 2])
    return heights


def _halfway(
    overlaps: list[Overlap], tangent: Tangent, rail: Curve, sides: Sides
) -> tuple[Grid, np.ndarray, np.ndarray, np.ndarray]:
    """The grid, inclination, and place along y and z of the frame of a surface halfway between rail
    and wheel.

    Points of both surfaces at equal arc lengths from the origin of the patch are opposite each
    other. The surface runs through their means, its normals are the means of theirs, and it is
    straight along the rail. Source: Vollebregt, Segal, VSD 52 (2014) 455-468; CONTACT's conformal
    method.
    """
    origin = tangent.frame.origin[1:]
    along = tangent.frame.axes[1:, 1]
    on_rail = rail.single_valued(float(origin[0]), along)
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
    # means of opposite points, and of the directions there
    points = np.zeros((2, grid.rows, 2))
    directions = np.zeros((2, grid.rows, 2))
    for i, (curve, begin) in enumerate(zip((on_rail, on_wheel), begins, strict=True)):
        s = begin + grid.y
        within = np.where((s >= curve.s[0]) & (s <= curve.s[-1]), s, np.nan)
        points[i] = curve.points(within)
        directions[i] = curve.directions(within)
        directions[i] /= np.hypot(*directions[i].T)[:, None]
    middle = points.mean(axis=0)
    to_right, down = directions.mean(axis=0).T
    # beyond the end of a profile the inclination at that end
    reached = np.isfinite(middle).all(axis=1)
    inclination = np.arctan2(down, to_right) - tangent.angle
    inclination = np.interp(grid.y, grid.y[reached], inclination[reached])
    lateral, height = ((middle - origin) @ tangent.frame.axes[1:, 1:]).T
    return grid, inclination, lateral, height
