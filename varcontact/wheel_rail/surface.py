"""Surfaces of rails that vary along the track, and of wheels out of round."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np

from varcontact.kinematics import Frame
from varcontact.wheel_rail.curve import Curve, growing, spline
from varcontact.wheel_rail.profile import Profile
from varcontact.wheel_rail.slices import ProfileSlices

TABLE = 0.25
"""Step along a section where the search for its points begins [mm]."""
STEPS = 8
SMALL = 1e-10
"""Weight below which a slice does not count."""


@dataclass(frozen=True, eq=False)
class Surface:
    """A surface by its sections, each over v from 0 to the number of features less one.

    `curves` are the different sections, with their arc lengths at the features; `of` has the one of each position.
    """

    positions: np.ndarray
    curves: tuple[Curve, ...]
    features: np.ndarray
    of: np.ndarray
    z: np.ndarray
    period: float = np.inf

    @cached_property
    def _pieces(self) -> list[tuple[float, Callable[..., np.ndarray]]]:
        """Between steps: where each begins, and the spline of the weights of all curves and of z."""
        from scipy.interpolate import CubicSpline

        weights = np.concatenate([np.eye(len(self.curves))[self.of], self.z[:, None]], axis=1)
        at = self.positions
        if np.isfinite(self.period):  # closed
            at = np.concatenate([at - self.period, at, at + self.period])
            weights = np.tile(weights, (3, 1))
        ends = [0, *(np.flatnonzero(np.diff(at) == 0) + 1).tolist(), at.size]
        pieces: list[tuple[float, Callable[..., np.ndarray]]] = []
        for a, b in pairwise(ends):
            one = np.repeat(weights[a : a + 1], 2, axis=0)
            fit = CubicSpline(at[a:b], weights[a:b]) if b - a > 1 else CubicSpline([at[a], at[a] + 1.0], one)
            pieces.append((float(at[a]), fit))
        return pieces

    @property
    def steps(self) -> np.ndarray:
        """Positions of steps and kinks."""
        return self.positions[1:][np.diff(self.positions) == 0]

    def points(self, at: np.ndarray, v: np.ndarray) -> np.ndarray:
        """Points, and their derivatives by position and by v, shape (3, ..., 2)."""
        at, v = np.broadcast_arrays(at, v)
        closed = bool(np.isfinite(self.period))
        known = (at - self.positions[0]) % self.period if closed else np.clip(at, *self.positions[[0, -1]])
        known = known + self.positions[0] if closed else known
        piece = np.searchsorted([begin for begin, _ in self._pieces], known, side="right") - 1
        weights, slopes = (np.zeros((*at.shape, len(self.curves) + 1)) for _ in range(2))
        for k in range(len(self._pieces)):
            here, fit = piece == k, self._pieces[k][1]
            weights[here], slopes[here] = fit(known[here]), fit(known[here], 1)
        slopes[(known != at) & (not closed)] = 0.0
        found = np.zeros((3, *at.shape, 2))
        found[0, ..., 1], found[1, ..., 1] = weights[..., -1], slopes[..., -1]
        between = np.clip(v.astype(int), 0, self.features.shape[1] - 2)
        for i, (curve, features) in enumerate(zip(self.curves, self.features, strict=True)):
            weight, slope = weights[..., i, None], slopes[..., i, None]
            if np.abs(weight).max(initial=0.0) < SMALL and np.abs(slope).max(initial=0.0) < SMALL:
                continue
            stretch = np.diff(features)[between]
            s = features[between] + (v - between) * stretch
            point, along = curve.points(s), curve.directions(s) * stretch[..., None]
            if len(self.curves) == 1:
                found[0] += point
                found[2] = along
            else:
                found += np.array([weight * point, slope * point, weight * along])
        return found

    @cached_property
    def table(self) -> np.ndarray:
        """v along a section, `TABLE` apart."""
        count = int(np.diff(self.features, axis=1).sum(axis=1).max() / TABLE)
        return np.linspace(0.0, self.features.shape[1] - 1, max(count, 2) + 1)

    def section(self, at: float) -> Curve:
        """The section at a position, as a curve."""
        return spline(self.points(np.array(at), self.table)[0], np.zeros(0, dtype=int), 0.0)


def surface_of(slices: Profile | ProfileSlices, placed: Callable[[Profile], Curve], *, backwards: bool) -> Surface:
    """The surface of slices, or of one profile, each `placed`: `backwards` where that turns its direction."""
    if isinstance(slices, Profile):
        slices = ProfileSlices(profiles=slices, positions=[0.0])
    profiles: Sequence[Profile] = slices.profiles  # type: ignore[assignment]
    keys = [id(each) if slices.features is None else i for i, each in enumerate(profiles)]  # features are of slices
    different = list(dict.fromkeys(keys))
    curves = tuple(placed(profiles[keys.index(key)]) for key in different)
    features = np.array([curve.s[[0, -1]] for curve in curves])
    if slices.features is not None:
        whole = np.array([[curve.s[-1]] for curve in curves])
        features = whole - slices.features[:, ::-1] if backwards else slices.features
    of = np.array([different.index(key) for key in keys])
    period = 2 * np.pi if slices.kind == "wheel" else np.inf
    return Surface(slices.positions, curves, features, of, slices.z, period)


@dataclass(frozen=True, eq=False)
class RailSurface:
    """Rails under one wheel, each over its own positions; the highest counts. `s` is where the wheel set is."""

    parts: tuple[Surface, ...]
    s: float

    @property
    def steps(self) -> np.ndarray:
        """x of steps."""
        first, last = self._ends
        ends = [each.positions[i] for each in self.parts for i in (0, -1) if first < each.positions[i] < last]
        return np.unique(np.concatenate([np.array(ends), *(each.steps for each in self.parts)])) - self.s

    @property
    def _ends(self) -> tuple[float, float]:
        """Of all rails together, beyond which they go on."""
        return min(each.positions[0] for each in self.parts), max(each.positions[-1] for each in self.parts)

    def sections(self, x: float) -> list[Curve]:
        """Of all rails, (y, z)."""
        at = np.array([x + self.s])
        there = [each for each in self.parts if self._there(each, at).all()]
        return [each.section(x + self.s).about_top(TABLE) for each in there]

    def section(self, x: float, y: float) -> Curve:
        """Of the highest rail at a place."""
        found = self.sections(x)
        height = [float(curve.points(curve.at(np.array([y])))[0, 1]) for curve in found]
        return found[int(np.nanargmin(height))]

    def _there(self, part: Surface, at: np.ndarray) -> np.ndarray:
        first, last = self._ends
        below, above = part.positions[0], part.positions[-1]
        return ((at >= below) | (below == first)) & ((at <= above) | (above == last))

    def _starts(self, part: Surface, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        """v of a rail's section at each of the columns x where it is nearest to y, shape (rows, columns)."""
        sections = part.points((x + self.s)[None, :], part.table[:, None])[0]
        found = np.full(y.shape, np.nan)
        for j in np.flatnonzero(self._there(part, x + self.s)):
            across, height = sections[:, j].T
            run = growing(across, int(height.argmin()))
            found[:, j] = np.interp(y[:, j], across[run], part.table[run], left=np.nan, right=np.nan)
        return found

    def along(self, points: np.ndarray, direction: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """From points, shape (rows, columns, 3), each column near one x, along a direction to the highest rail.

        Distances, and slopes of the rail there along x and y; NaN where no rail is. Newton's method for the distance
        and v.
        """
        shape = points.shape[:2]
        far, by_x, by_y = (np.full(shape, np.nan) for _ in range(3))
        x = points[..., 0].mean(axis=0)
        for part in self.parts:
            v = self._starts(part, x, points[..., 1])
            here = np.isfinite(v)
            if not here.any():
                continue
            v, start = v[here], points[here]
            away, last = np.zeros(v.size), float(part.features.shape[1] - 1)
            for _ in range(STEPS):
                at = start + away[:, None] * direction
                point, turned, along = part.points(at[:, 0] + self.s, v)
                off = at[:, 1:] - point
                moved = direction[1:] - turned * direction[0]
                determinant = moved[:, 1] * along[:, 0] - moved[:, 0] * along[:, 1]
                step = (off[:, 0] * along[:, 1] - off[:, 1] * along[:, 0]) / determinant
                v = np.clip(v + (moved[:, 1] * off[:, 0] - moved[:, 0] * off[:, 1]) / determinant, 0.0, last)
                away = away + step
                if np.abs(step).max() < 1e-11:
                    break
            slope = along[:, 1] / along[:, 0]
            nearer = ~(far[here] <= away) & (np.abs(off).max(axis=1) < 1e-3)
            for whole, values in ((far, away), (by_y, slope), (by_x, turned[:, 1] - slope * turned[:, 0])):
                whole[here] = np.where(nearer, values, whole[here])
        return far, by_x, by_y

    def heights(self, frame: Frame, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        """z in a frame, where lines of x and y cross; NaN where no rail is."""
        points = frame.globally(np.stack([*np.meshgrid(x, y), np.zeros((y.size, x.size))], axis=-1))
        return self.along(points, frame.axes[:, 2])[0]

    def nearest(self, x: float, y: float, known: np.ndarray) -> np.ndarray:
        """(y, z) of the rail at a place, or of the nearest of `known` points where there is a gap."""
        z = float(self.along(np.array([[[x, y, 0.0]]]), np.array([0.0, 0.0, 1.0]))[0].item())
        return np.array([y, z]) if np.isfinite(z) else known[np.abs(known[:, 0] - y).argmin()]


@dataclass(frozen=True, eq=False)
class WheelSurface:
    """A wheel, turned by `pitch` about its axle: (y along the axle, radius) over the angle from the bottom and v."""

    surface: Surface
    pitch: float

    @property
    def s(self) -> np.ndarray:
        """The ends of v."""
        return np.array([0.0, self.surface.features.shape[1] - 1.0])

    def around(self, theta: np.ndarray, v: np.ndarray) -> np.ndarray:
        """(y, radius), and their derivatives by the angle and by v, shape (3, ..., 2)."""
        return self.surface.points(theta - self.pitch, v)

    def section(self, theta: float) -> Curve:
        """At an angle from the bottom."""
        return self.surface.section(theta - self.pitch)
