"""Contact patches on a curved reference surface, halfway between rail and wheel, where a plane is too flat for them.

Points of both surfaces at equal arc lengths from the origin of the patch are opposite each other. The reference surface
runs through their means, its normals are the means of theirs, and it is straight along the rail. Source: Vollebregt,
Segal, VSD 52 (2014) 455-468; CONTACT's conformal method.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from varcontact.kinematics import RigidBody
from varcontact.scene.grid import Grid
from varcontact.wheel_rail.curve import Curve, spline
from varcontact.wheel_rail.patches import Overlap, Place, Tangent, grid_over, seams_of, too_rough, wheel_heights


@dataclass(frozen=True, eq=False)
class CurvedPlace:
    """A contact patch whose y is the arc length of its reference surface.

    `flat` has its frame, grid, distance and approach; the inclination is that of each row of elements relative to the
    frame's y [rad], and `on_wheel` are the points (ny, 3) of the wheel opposite their middles, in track coordinates.
    """

    flat: Place
    inclination: np.ndarray
    on_wheel: np.ndarray

    def rigid_slip(self, body: RigidBody, speed: float) -> np.ndarray:
        """Velocity of the rail over the wheel in the frames of the elements, divided by a speed, (2, ny, nx)."""
        frame, grid = self.flat.frame, self.flat.grid
        along = grid.x[:, None] * frame.axes[:, 0]
        velocity = -body.velocity_at(self.on_wheel[:, None] + along) @ frame.axes / speed
        c, s = np.cos(self.inclination)[:, None], np.sin(self.inclination)[:, None]
        return np.array([velocity[..., 0], c * velocity[..., 1] + s * velocity[..., 2]])


def place_curved(
    overlaps: list[Overlap],
    tangent: Tangent,
    wheel: Curve,
    rail: Curve,
    axle: np.ndarray,
    centre: np.ndarray,
    sides: tuple[float, float] | None = None,
    distances: tuple[float, float] = (math.inf, math.inf),
) -> CurvedPlace:
    """The patch of a group of overlaps on its curved reference surface, see `patches.place`."""
    frame = tangent.frame
    origin, along, normal = frame.origin[1:], frame.axes[1:, 1], frame.axes[1:, 2]
    on_rail, on_wheel = rail.single_valued(float(rail.at(origin[:1])[0]), along), _section(overlaps[0], tangent)
    begins = [float(curve.at(np.array([along @ origin]), along)[0]) for curve in (on_rail, on_wheel)]
    if not np.isfinite(begins).all():
        raise too_rough(float(origin[0]))
    across = [on_rail.at(each.surface @ along, along) - begins[0] for each in overlaps]
    grid = grid_over(overlaps, frame, np.concatenate(across), sides)
    points, directions = np.zeros((2, grid.rows, 2)), np.zeros((2, grid.rows, 2))
    for i, (curve, begin) in enumerate(zip((on_rail, on_wheel), begins, strict=True)):
        s = begin + grid.y
        known = np.where((s >= curve.s[0]) & (s <= curve.s[-1]), s, np.nan)
        points[i], directions[i] = curve.points(known), curve.directions(known)
        directions[i] /= np.hypot(*directions[i].T)[:, None]
    middle, (to_right, down) = points.mean(axis=0), directions.mean(axis=0).T
    known = np.isfinite(middle).all(axis=1)
    if not known.any():
        raise too_rough(float(origin[0]))
    inclination = np.interp(grid.y, grid.y[known], (np.arctan2(down, to_right) - tangent.angle)[known])
    lateral = np.where(known, (middle - origin) @ along, np.nan)
    rail_points = on_rail.points(on_rail.at(lateral + along @ origin, along))
    heights = wheel_heights(overlaps[0].locus, wheel, frame, (grid.x, lateral), axle, centre)
    gap = (((rail_points - origin) @ normal)[:, None] - heights) * np.cos(inclination)[:, None]
    inside = np.isfinite(gap)
    if not inside.any() or gap[inside].min() >= 0:
        raise too_rough(float(origin[0]))
    gap = np.where(inside, gap, gap[inside].max() + np.abs(gap[inside]).max())
    seams = seams_of(overlaps, across, *distances)
    flat = Place(frame, tangent.angle, grid, gap - gap.min(), -float(gap.min()), seams)
    return CurvedPlace(flat, inclination, _opposite(flat, grid, middle, heights, inclination))


def _section(overlap: Overlap, tangent: Tangent) -> Curve:
    """The wheel's part around the origin that grows along the plane: its contact locus, (y, z) in track coordinates."""
    frame = tangent.frame
    lowered = overlap.points[0] - overlap.locus.points[overlap.run][0]
    points = overlap.locus.points + lowered
    across = points[:, 1:] @ frame.axes[1:, 1]
    nearest = int(np.hypot(*(points[:, 1:] - frame.origin[1:]).T).argmin())
    falls = np.flatnonzero(np.diff(across) <= 0)
    first = int(max(falls[falls < nearest] + 1, default=0))
    last = int(min(falls[falls >= nearest], default=across.size - 1))
    return spline(points[first : last + 1, 1:], np.zeros(0, dtype=int), 0.0)


def _opposite(flat: Place, grid: Grid, middle: np.ndarray, heights: np.ndarray, inclination: np.ndarray) -> np.ndarray:
    """Points of the wheel along the normals of the reference surface, in track coordinates."""
    frame, at = flat.frame, int(np.abs(grid.x).argmin())
    across, height = np.nan_to_num((middle - frame.origin[1:]) @ frame.axes[1:, 1:]).T
    away = np.nan_to_num((heights[:, at] - height) * np.cos(inclination))
    found = [0.0 * across, across - np.sin(inclination) * away, height + np.cos(inclination) * away]
    return np.asarray(frame.globally(np.stack(found, axis=1)))
