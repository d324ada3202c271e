"""Contact patches on a curved reference surface, halfway between rail and wheel, where a plane is too flat for them.

Points of both surfaces at equal arc lengths from the origin of the patch are opposite each other. The reference surface
runs through their means, its normals are the means of theirs, and it is straight along the rail. Source: Vollebregt,
Segal, VSD 52 (2014) 455-468; CONTACT's conformal method.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from varcontact.kinematics import Frame, RigidBody
from varcontact.scene.grid import Grid
from varcontact.wheel_rail.curve import Curve, growing, spline
from varcontact.wheel_rail.locus import Overlap
from varcontact.wheel_rail.patches import Tangent, grid_over, too_rough, wheel_heights


@dataclass(frozen=True, eq=False)
class CurvedSurface:
    """The reference surface of a patch, with what `patches.undeformed_distance` has of a plane; y is its arc length.

    The inclination is that of each row of elements relative to the frame's y [rad], `lateral` its place along that
    (NaN beyond a profile's end), and `on_wheel` are the points (ny, 3) of the wheel opposite, in track coordinates.
    """

    grid: Grid
    distance: np.ndarray
    approach: float
    inclination: np.ndarray
    lateral: np.ndarray
    on_wheel: np.ndarray

    def rigid_slip(self, frame: Frame, body: RigidBody, speed: float) -> np.ndarray:
        """Velocity of the rail over the wheel in the frames of the elements, divided by a speed, (2, ny, nx)."""
        along = self.grid.x[:, None] * frame.axes[:, 0]
        velocity = -body.velocity_at(self.on_wheel[:, None] + along) @ frame.axes / speed
        c, s = np.cos(self.inclination)[:, None], np.sin(self.inclination)[:, None]
        return np.array([velocity[..., 0], c * velocity[..., 1] + s * velocity[..., 2]])


def curved_surface(
    overlaps: list[Overlap],
    tangent: Tangent,
    wheel: Curve,
    rail: Curve,
    axle: np.ndarray,
    centre: np.ndarray,
    sides: tuple[float, float] | None = None,
) -> CurvedSurface:
    """The reference surface of a group of overlaps; the arguments are those of `patches.undeformed_distance`.

    The distance is that along the frame's z, multiplied by the cosine of the angle to the normals.
    """
    frame = tangent.frame
    origin, along, normal = frame.origin[1:], frame.axes[1:, 1], frame.axes[1:, 2]
    on_rail = rail.single_valued(float(rail.at(origin[:1])[0]), along)
    # the wheel's part around the origin that grows along the plane: its contact locus, in track coordinates
    locus = overlaps[0].locus
    places = (locus.points + (overlaps[0].points[0] - locus.points[overlaps[0].run][0]))[:, 1:]
    run = growing(np.diff(places @ along) > 0, int(np.hypot(*(places - origin).T).argmin()))
    on_wheel = spline(places[run], np.zeros(0, dtype=int), 0.0)
    begins = [float(curve.at(np.array([along @ origin]), along)[0]) for curve in (on_rail, on_wheel)]
    surface = np.concatenate([each.surface for each in overlaps])
    arc = on_rail.at(surface @ along, along) - begins[0]
    if not np.isfinite(arc).all():
        raise too_rough(float(origin[0]))
    grid = grid_over(overlaps, frame, arc, sides)
    points, directions = np.zeros((2, grid.rows, 2)), np.zeros((2, grid.rows, 2))
    for i, (curve, begin) in enumerate(zip((on_rail, on_wheel), begins, strict=True)):
        s = begin + grid.y
        within = np.where((s >= curve.s[0]) & (s <= curve.s[-1]), s, np.nan)
        points[i], directions[i] = curve.points(within), curve.directions(within)
        directions[i] /= np.hypot(*directions[i].T)[:, None]
    middle, (to_right, down) = points.mean(axis=0), directions.mean(axis=0).T
    known = np.isfinite(middle).all(axis=1)
    if not known.any():
        raise too_rough(float(origin[0]))
    inclination = np.interp(grid.y, grid.y[known], (np.arctan2(down, to_right) - tangent.angle)[known])
    lateral, height = ((middle - origin) @ frame.axes[1:, 1:]).T
    rail_heights = (on_rail.points(on_rail.at(lateral + along @ origin, along)) - origin) @ normal
    heights = wheel_heights(locus, wheel, frame, (grid.x, lateral), axle, centre)
    gap = (rail_heights[:, None] - heights) * np.cos(inclination)[:, None]
    inside = np.isfinite(gap)
    if not inside.any() or gap[inside].min() >= 0:
        raise too_rough(float(origin[0]))
    gap = np.where(inside, gap, gap[inside].max() + np.abs(gap[inside]).max())  # beside a profile's end nothing touches
    away = (heights[:, int(np.abs(grid.x).argmin())] - height) * np.cos(inclination)  # to the wheel, along normals
    opposite = [0.0 * height, lateral - np.sin(inclination) * away, height + np.cos(inclination) * away]
    opposite_points = frame.globally(np.nan_to_num(np.stack(opposite, axis=1)))
    return CurvedSurface(grid, gap - gap.min(), -float(gap.min()), inclination, lateral, opposite_points)
