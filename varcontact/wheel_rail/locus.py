"""Contact locus: the points of a wheel that come nearest to a rail, and the runs
of them that are below its surface.

On each circle of the wheel one point can touch a rail that is straight along x:
the one whose normal has no component along x (Wang 1984, "The track of wheel
contact points and the calculation of wheel/rail geometric contact parameters").
The locus depends on roll and yaw, and is moved up and down by the height of the
axle. Where the rail varies along the track, or the wheel is out of round, there
is no closed form: the points are looked for in planes across the track.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from varcontact.errors import NoContact, SceneError
from varcontact.system.process import lazy_property, one_blas_thread
from varcontact.wheel_rail.curve import Curve
from varcontact.wheel_rail.slices import RailSurface, Surface

CIRCLE = 0.2
"""Spacing of the circles of a wheel where surfaces vary [mm]."""
PLANES_REACH = 50.0
"""Largest distance of the planes from the axle [mm]."""
PLANE = 1.0
"""Spacing of the planes [mm]."""
CURVATURE_PLANES = 10
"""Planes before and behind over which the curvature along the track is averaged."""
LEAST_RISE = 1e-6
"""Least rise over these planes [mm], below which gaps count as equal."""
BESIDE = 1e-6
"""Distance of planes from a step [mm]."""
SHALLOW = 0.3
"""Depth at the end of a profile, relative to the greatest, up to which the contact ends before it:
Hertz's contacts end where it is 0.5 to 0.7."""
PRESSING_STEPS = 20
PRESSING_TOL = 1e-4
"""Relative tolerance of `Locus.pressing` in the search for its height."""
NEWTON_STEPS = 8
"""Largest number of Newton steps to the points where circles cross the planes."""


@dataclass(frozen=True, eq=False)
class Locus:
    """The points of a wheel that come nearest to a rail, with the axle at the height 0.

    Attributes
    ----------
    s : ndarray, shape (n,)
        Parameters of the circles on the wheel's curve [mm].
    points : ndarray, shape (n, 3)
        In track coordinates [mm].
    radii : ndarray, shape (n,)
        Radii of the circles [mm].
    curvature_radii : ndarray, shape (n,)
        Radii of the wheel relative to the rail, along x [mm]: of a straight rail, those
        of the circles.
    gap : ndarray, shape (n,)
        Height above the rail [mm]; infinite beside it.
    angles : ndarray, shape (n,)
        Inclination of the rail below [rad].
    height : float
        Height of the middle of the axle in track coordinates, where its own z is 0
        [mm].
    planes, gaps : ndarray, shapes (m,) and (n, m)
        Surfaces that vary: x of planes across the track [mm], and heights of
        the circles above the rail there.
    slopes : ndarray, shape (n,)
        Slopes of the rail below, along x: of one that varies [-].
    """

    s: np.ndarray
    points: np.ndarray
    radii: np.ndarray
    curvature_radii: np.ndarray
    gap: np.ndarray
    angles: np.ndarray
    height: float
    planes: np.ndarray | None = None
    gaps: np.ndarray | None = None
    slopes: np.ndarray | None = None

    @lazy_property
    def touching(self) -> float:
        """The height of the axle, z down, at which the wheel just touches the rail [mm]."""
        return float(self.gap.min())

    @lazy_property
    def _widths(self) -> np.ndarray:
        return np.abs(np.gradient(self.points[:, 1]))

    def pressing(self, z: float) -> float:
        """The volume of the overlap at a height, divided by the root of its area, but for a factor:
        normal forces are nearly in proportion, those of similar ellipses exactly.

        Parameters
        ----------
        z : float
            Height of the axle, downwards [mm].

        Returns
        -------
        float
            In mm^2.
        """
        depth = np.maximum(z - self.gap, 0.0)
        areas = np.sqrt(self.curvature_radii * depth) * self._widths
        return float(depth @ areas / np.sqrt(areas.sum()))

    def height_pressing(self, value: float, depth: float) -> float:
        """The height at which `pressing` has about a value.

        Parameters
        ----------
        value : float
            Value of `pressing` [mm^2].
        depth : float
            Depth of the wheel below the height of first contact from which it is found [mm].

        Returns
        -------
        float
            Height of the axle, downwards [mm].
        """
        for _ in range(PRESSING_STEPS):
            ratio = value / self.pressing(self.touching + depth)
            depth *= ratio ** (2 / 3)  # of ellipses
            if abs(ratio - 1) < PRESSING_TOL:
                break
        return self.touching + depth

    def part(self, run: slice) -> Locus:
        """The circles of a `run`, without planes across the track."""
        return Locus(
            self.s[run],
            self.points[run],
            self.radii[run],
            self.curvature_radii[run],
            self.gap[run],
            self.angles[run],
            self.height,
        )

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
                f"no contact: z = {z:.6g} mm is above the rail; "
                f"the wheel touches at z = {self.touching:.6g} mm"
            )
            raise NoContact("z", z, message=reason)
        if self.gaps is not None and (self.gaps[:, [0, -1]] < z).any():
            reason = (
                f"z = {z:.6g} mm: the wheel touches too far before or behind its axle; "
                "a step of the profile, or a rail beside it, is too high"
            )
            raise SceneError("z", z, message=reason)
        inside = np.zeros(self.gap.size + 2, dtype=bool)
        inside[1:-1] = self.gap < z
        edges = (inside[1:] != inside[:-1]).nonzero()[0].tolist()
        overlaps = []
        for first, stop in zip(edges[::2], edges[1::2], strict=True):
            self._check_ends(first, stop, z)
            overlaps.append(overlap(self, slice(first, stop), z))
        return overlaps

    def _check_ends(self, first: int, stop: int, z: float) -> None:
        """Refuse a run of circles that ends with a profile, where it is so deep that the contact
        may reach the end.
        """
        deepest = z - self.gap[first:stop].min()
        for end, beside in ((first, first - 1), (stop - 1, stop)):
            at_end = not 0 <= beside < self.gap.size or not np.isfinite(self.gap[beside])
            if at_end and z - self.gap[end] > SHALLOW * deepest:
                reason = (
                    f"the contact reaches the end of a profile near "
                    f"y = {self.points[end, 1]:.4g} mm: it is too narrow or rough"
                )
                raise SceneError("z", z, message=reason)


@dataclass(frozen=True, eq=False)
class Overlap:
    """A run of circles of the wheel that are below the rail's surface, with the axle at some
    height.
    """

    run: slice
    """Circles of the locus."""
    locus: Locus
    points: np.ndarray
    """Points of the locus at this height, shape (n, 3)."""
    depth: np.ndarray
    """Depth below the rail's surface, shape (n,)."""
    surface: np.ndarray
    """(y, z) of the rail above the points, shape (n, 2)."""
    ends: np.ndarray
    """x between which the circles are below the surface, shape (2, n)."""
    weights: np.ndarray
    """The squared depth, summed up along x and over the width of each circle, shape (n,): CONTACT
    has the origin of a patch at the weighted centre."""


def overlap(locus: Locus, run: slice, z: float) -> Overlap:
    """The overlap of a run of circles at a height of the axle; circles above the rail have negative
    depths.
    """
    points = np.asarray(locus.points[run] + [0.0, 0.0, z])
    depth = np.asarray(z - locus.gap[run])
    surface = points[:, 1:].copy()
    surface[:, 1] -= depth
    half_lengths = np.sqrt(2 * locus.curvature_radii[run] * np.maximum(depth, 0.0))
    width = np.ones(1)
    if depth.size > 1:
        width = np.abs(np.gradient(points[:, 1]))
    ends = points[:, 0] + np.multiply.outer([-1, 1], half_lengths)
    weights = depth**2 * half_lengths
    if locus.gaps is not None and locus.planes is not None:
        # surfaces that vary: sums over planes in place of parabolas along x
        x = locus.planes
        gaps = locus.gaps[run]
        inside = gaps < z
        # the end of a rail does not move the centre of the contact beside it
        away = x - points[:, :1]
        parabola = locus.gap[run, None] + away**2 / (2 * locus.curvature_radii[run, None])
        endless = np.where(np.isfinite(gaps), gaps, parabola)
        squared = np.maximum(z - endless, 0.0) ** 2 * np.gradient(x)
        some = inside.any(axis=1)
        points[some, 0] = squared[some] @ x / squared[some].sum(axis=1)
        weights = np.where(some, squared.sum(axis=1), weights)
        before = np.maximum(inside.argmax(axis=1) - 1, 0)
        last = x.size - 1 - inside[:, ::-1].argmax(axis=1)
        behind = np.minimum(last + 1, x.size - 1)
        ends = np.where(some, [x[before], x[behind]], ends)
    return Overlap(run, locus, points, depth, surface, ends, weights * width)


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
    The normal of a surface of revolution of radius ``r(y)`` is along ``(sin(theta), -r',
    cos(theta))`` in the frame of the axle. That its component along the track is zero makes one
    equation for theta, solved in closed form.
    """
    s, points, along = wheel.finely
    y, r = points.T
    a, b, c = rotation[0]
    length = np.hypot(a, c)
    a = a / length
    c = c / length
    slope = (b / length) * along[:, 1] / along[:, 0]
    possible = np.abs(slope) < 1
    if not possible.all():
        s, y, r, slope = (each[possible] for each in (s, y, r, slope))
    # theta = arcsin(slope) - arctan2(c, a)
    root = np.sqrt(1 - slope**2)
    sine = a * slope - c * root
    cosine = a * root + c * slope
    points = np.stack([r * sine, y, r * cosine], axis=1) @ rotation.T + centre
    below = rail.at(points[:, 1])
    over = np.isfinite(below)
    if not over.any():
        first, last = rail.points(rail.s[[0, -1]])[:, 0]
        reason = (
            "the wheel is beside the rail: it is at "
            f"y = {points[:, 1].min():.5g} to {points[:, 1].max():.5g} mm, "
            f"the rail at {first:.5g} to {last:.5g} mm"
        )
        raise NoContact("position.y", float(centre[1]), message=reason)
    gap = np.full(s.size, np.inf)
    angles = np.zeros(s.size)
    (_, height), (along_y, along_z) = rail.points_and_directions(below[over])
    gap[over] = height - points[over, 2]
    angles[over] = np.arctan2(along_z, along_y)
    return Locus(s, points, r, r, gap, angles, float(centre[2]))


def varied_locus(
    wheel: Surface, rail: RailSurface, rotation: np.ndarray, centre: np.ndarray
) -> Locus:
    """The contact locus of a wheel over a rail of which one varies; arguments as of
    `contact_locus`.
    """
    # circles, and planes across the track
    length = float(np.diff(wheel.features, axis=1).sum(axis=1).max())
    v = np.linspace(0.0, wheel.s[-1], int(np.ceil(length / CIRCLE)) + 1)
    radius = float(wheel.points(wheel.positions[:1], v[:1])[0, 0, 1])
    middle = float(wheel.points(wheel.positions[:1], np.array([v.mean()]))[0, 0, 0])
    lowest = float(centre[0] + rotation[0, 1] * middle + rotation[0, 2] * radius)
    planes = _planes(wheel, rail, lowest, radius)
    # points of the circles in the planes, and their heights above the rail
    begin = np.arcsin(np.clip((planes - lowest) / radius, -0.9, 0.9))[None, :]
    points, radii = _in_planes(wheel, v, begin + np.zeros((v.size, 1)), planes, rotation, centre)
    gaps, by_x, by_y = rail.along(points, np.array([0.0, 0.0, 1.0]))
    gaps = np.where(np.isfinite(gaps), gaps, np.inf)
    if not np.isfinite(gaps).any():
        reason = (
            "the wheel is beside the rail: it spans y from "
            f"{points[..., 1].min():.5g} to {points[..., 1].max():.5g} mm"
        )
        raise NoContact("position.y", float(centre[1]), message=reason)
    # the nearest plane of each circle; of a flat, the middle
    nearest = gaps <= gaps.min(axis=1, keepdims=True) + LEAST_RISE
    off = np.abs(planes - (nearest @ planes / nearest.sum(axis=1))[:, None])
    k = np.where(nearest, off, np.inf).argmin(axis=1)
    rows = np.arange(v.size)
    # the lowest point of a parabola beside it
    shift, lower = _lowest_beside(planes, gaps, k)
    gap = gaps[rows, k] - lower
    at = points[rows, k]
    at[:, 0] += shift
    radii = radii[rows, k]
    curvature_radii = _curvature_radii(planes, gaps, k, gap, radii)
    angles = np.arctan(np.nan_to_num(by_y[rows, k]))
    slopes = np.nan_to_num(by_x[rows, k])
    height = float(centre[2])
    return Locus(v, at, radii, curvature_radii, gap, angles, height, planes, gaps, slopes)


def _planes(wheel: Surface, rail: RailSurface, lowest: float, radius: float) -> np.ndarray:
    """x of planes across the track around the `lowest` place of a wheel; two at each step, kink and
    end of a rail.
    """
    turned, *along = (
        each.positions[1:][np.diff(each.positions) == 0] for each in (wheel, *rail.parts)
    )
    planes = lowest + np.arange(-PLANES_REACH, PLANES_REACH + PLANE / 2, PLANE)
    turned = np.remainder(turned + np.pi, 2 * np.pi) - np.pi
    on_wheel = lowest + radius * np.sin(turned[np.abs(turned) < PLANES_REACH / radius])
    ends = rail.ends[np.isfinite(rail.ends)]
    steps = np.concatenate([ends, *along, on_wheel])
    steps = steps[(steps > planes[0]) & (steps < planes[-1])]
    return np.unique(np.concatenate([planes, steps - BESIDE, steps + BESIDE]))


def _in_planes(
    wheel: Surface,
    v: np.ndarray,
    theta: np.ndarray,
    planes: np.ndarray,
    rotation: np.ndarray,
    centre: np.ndarray,
) -> tuple[np.ndarray, np.ndarray]:
    """Points and radii where circles `v` of a wheel cross planes, by Newton's method from
    angles `theta`.
    """
    a, b, c = rotation[0]
    for _ in range(NEWTON_STEPS):
        (y, r), (y_by, r_by) = np.moveaxis(wheel.points(theta, v[:, None])[:2], -1, 1)
        sine = np.sin(theta)
        cosine = np.cos(theta)
        off = a * r * sine + b * y + c * r * cosine + centre[0] - planes
        step = off / (a * (r * cosine + r_by * sine) + b * y_by + c * (r_by * cosine - r * sine))
        theta = theta - step
        if np.abs(step * r).max() < 1e-9:
            break
    y, r = np.moveaxis(wheel.points(theta, v[:, None])[0], -1, 0)
    points = np.stack([r * np.sin(theta), y, r * np.cos(theta)], axis=-1) @ rotation.T + centre
    points[..., 0] = planes
    return points, r


def _lowest_beside(
    planes: np.ndarray, gaps: np.ndarray, k: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Distances from the planes `k`, and depths below them, of the lowest points of parabolas
    through the gaps there and beside; 0 beside steps, kinks and ends of rails, which have none.
    """
    rows = np.arange(k.size)
    inside = np.clip(k, 1, planes.size - 2)
    left, middle, right = (gaps[rows, inside + i] for i in (-1, 0, 1))
    even = np.isclose(planes[inside + 1] - planes[inside - 1], 2 * PLANE) & (k == inside)
    with np.errstate(invalid="ignore", divide="ignore"):
        bend = (left - 2 * middle + right) / PLANE**2
        shift = (left - right) / (2 * PLANE * bend)
        even &= np.abs(shift) < PLANE  # nor NaN, beside the rail
        lower = bend * shift**2 / 2
    return np.where(even, shift, 0.0), np.where(even, lower, 0.0)


def _curvature_radii(
    planes: np.ndarray, gaps: np.ndarray, k: np.ndarray, gap: np.ndarray, radii: np.ndarray
) -> np.ndarray:
    """Radii of circles through the gaps in planes before and behind the planes `k`, for fast ways.

    Where the rail ends on one side the other one counts; where it ends on both, the circle of the
    wheel.
    """
    rows = np.arange(k.size)
    beside = np.clip([k - CURVATURE_PLANES, k + CURVATURE_PLANES], 0, planes.size - 1)
    with np.errstate(invalid="ignore", divide="ignore"):
        rises = np.maximum(gaps[rows, beside] - gap, LEAST_RISE)
        curvatures = 2 * rises / (planes[beside] - planes[k]) ** 2
        on_rail = np.isfinite(curvatures)
        means = on_rail.sum(axis=0) / np.where(on_rail, curvatures, 0.0).sum(axis=0)
    return np.where(np.isfinite(means), np.clip(means, 1.0, 10 * radii), radii)
