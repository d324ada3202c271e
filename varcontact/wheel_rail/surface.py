"""Surfaces of rails that vary along the track, and of wheels out of round."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from typing import Any, cast

import numpy as np

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

    `curves` are the different sections, with their arc lengths at the `features`. `weights`, shape (n, m + 1), has
    those of the curves at each position, and what is added to z. Positions are x, or angles from a wheel's bottom.
    """

    positions: np.ndarray
    curves: tuple[Curve, ...]
    features: np.ndarray
    weights: np.ndarray
    period: float = np.inf

    @cached_property
    def _weights(self) -> Any:
        """The weights over all positions: cubics between steps, and constant before the first position and after."""
        from scipy.interpolate import CubicSpline, PPoly

        at, weights = self.positions, self.weights
        if np.isfinite(self.period):  # closed
            at = np.concatenate([at - self.period, at, at + self.period])
            weights = np.tile(weights, (3, 1))
        constant = np.zeros((4, 2, weights.shape[1]))
        constant[3] = weights[[0, -1]]
        breaks, cubics = [at[:1] - 1.0], [constant[:, :1]]
        steps = np.flatnonzero(np.diff(at) == 0) + 1
        for a, b in pairwise([0, *steps.tolist(), at.size]):
            if b - a > 1:
                breaks.append(at[a : b - 1])
                cubics.append(CubicSpline(at[a:b], weights[a:b]).c)
        breaks += [at[-1:], at[-1:] + 1.0]
        return PPoly(np.concatenate([*cubics, constant[:, 1:]], axis=1), np.concatenate(breaks))

    @property
    def steps(self) -> np.ndarray:
        """Positions of steps and kinks."""
        return self.positions[1:][np.diff(self.positions) == 0]

    @cached_property
    def s(self) -> np.ndarray:
        """v along a section, `TABLE` apart."""
        count = int(np.diff(self.features, axis=1).sum(axis=1).max() / TABLE)
        return np.linspace(0.0, self.features.shape[1] - 1, max(count, 2) + 1)

    def points(self, at: np.ndarray, v: np.ndarray) -> np.ndarray:
        """Points, and their derivatives by position and by v, shape (3, ..., 2)."""
        at, v = np.broadcast_arrays(at, v)
        if np.isfinite(self.period):
            at = self.positions[0] + (at - self.positions[0]) % self.period
        weights, slopes = self._weights(at), self._weights(at, 1)
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
            found += np.array([weight * point, slope * point, weight * along])
        return found

    def section(self, at: float) -> Curve:
        """The section at a position, as a curve."""
        return spline(self.points(np.array(at), self.s)[0], np.zeros(0, dtype=int), 0.0)

    def starts(self, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        """v of a rail's section at each of the columns x where it is nearest to y, shape (rows, columns)."""
        sections = self.points(x[None, :], self.s[:, None])[0]
        found = np.zeros(y.shape)
        for j in range(x.size):
            across, height = sections[:, j].T
            run = growing(across, int(height.argmin()))
            found[:, j] = np.interp(y[:, j], across[run], self.s[run], left=np.nan, right=np.nan)
        return found


def surface_of(slices: ProfileSlices, placed: Callable[[Profile], Curve], shift: float, *, backwards: bool) -> Surface:
    """The surface of slices, each `placed`, and their positions shifted: `backwards` where that turns its direction."""
    profiles, features = cast(Sequence[Profile], slices.profiles), slices.features
    keys = [id(each) if features is None else i for i, each in enumerate(profiles)]  # features are of slices
    different = list(dict.fromkeys(keys))
    curves = tuple(placed(profiles[keys.index(key)]) for key in different)
    if features is None:
        features = np.array([curve.s[[0, -1]] for curve in curves])
    elif backwards:
        features = np.array([[curve.s[-1]] for curve in curves]) - features[:, ::-1]
    weights = np.eye(len(curves))[[different.index(key) for key in keys]]
    period = 2 * np.pi if slices.kind == "wheel" else np.inf
    weights = np.concatenate([weights, slices.z[:, None]], axis=1)
    return Surface(slices.positions + shift, curves, features, weights, period)


@dataclass(frozen=True, eq=False)
class RailSurface:
    """Rails under one wheel, each over its own x; the highest counts."""

    parts: tuple[Surface, ...]

    @cached_property
    def ends(self) -> np.ndarray:
        """x between which each rail is, shape (n, 2): the first and the last one go on."""
        first, last = np.array([each.positions[[0, -1]] for each in self.parts]).T
        before, behind = np.where(first == first.min(), -np.inf, first), np.where(last == last.max(), np.inf, last)
        return np.stack([before, behind], axis=1)

    @property
    def steps(self) -> np.ndarray:
        """x of steps."""
        ends = self.ends[np.isfinite(self.ends)]
        return np.unique(np.concatenate([ends, *(each.steps for each in self.parts)]))

    def sections(self, x: float) -> list[Curve]:
        """Of all rails, (y, z)."""
        there = (self.ends[:, 0] <= x) & (x <= self.ends[:, 1])
        return [self.parts[i].section(x).about_top(TABLE) for i in np.flatnonzero(there)]

    def section(self, x: float, y: float) -> Curve:
        """Of the highest rail at a place."""
        found = self.sections(x)
        height = [float(curve.points(curve.at(np.array([y])))[0, 1]) for curve in found]
        return found[int(np.nanargmin(height))]

    def along(self, points: np.ndarray, direction: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """From points, shape (rows, columns, 3), each column near one x, along a direction to the highest rail.

        Distances, and slopes of the rail there along x and y; NaN where no rail is. Newton's method for the distance
        and v.
        """
        shape = points.shape[:2]
        far, by_x, by_y = (np.full(shape, np.nan) for _ in range(3))
        x = points[..., 0].mean(axis=0)
        for part, (first, last) in zip(self.parts, self.ends, strict=True):
            there, v = (first <= x) & (x <= last), np.full(shape, np.nan)
            v[:, there] = part.starts(x[there], points[:, there, 1])
            here = np.isfinite(v)
            if not here.any():
                continue
            v, start = v[here], points[here]
            away = np.zeros(v.size)
            for _ in range(STEPS):
                at = start + away[:, None] * direction
                point, turned, along = part.points(at[:, 0], v)
                off = at[:, 1:] - point
                moved = direction[1:] - turned * direction[0]
                determinant = moved[:, 1] * along[:, 0] - moved[:, 0] * along[:, 1]
                step = (off[:, 0] * along[:, 1] - off[:, 1] * along[:, 0]) / determinant
                further = (moved[:, 1] * off[:, 0] - moved[:, 0] * off[:, 1]) / determinant
                v, away = np.clip(v + further, 0.0, part.s[-1]), away + step
                if np.abs(step).max() < 1e-11:
                    break
            slope = along[:, 1] / along[:, 0]
            nearer = ~(far[here] <= away) & (np.abs(off).max(axis=1) < 1e-3)
            for whole, values in ((far, away), (by_y, slope), (by_x, turned[:, 1] - slope * turned[:, 0])):
                whole[here] = np.where(nearer, values, whole[here])
        return far, by_x, by_y
