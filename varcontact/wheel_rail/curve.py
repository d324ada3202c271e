"""Plane curves (y, z) by their arc length: cubic splines between kinks."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.polynomial.polynomial import polyfit, polyval

from varcontact.errors import SceneError
from varcontact.system.process import lazy_property

ACROSS = np.array([1.0, 0.0])
"""Unit vector along y."""
STEP = 0.05
"""Spacing of the points of a curve, and of the circles of a wheel [mm]."""
LAST_STEP = 1e-7
"""Length of the last of Newton's steps, relative to the curve's length: the error after it is about
its square.
"""
STEPS = 30
HELD = 1e6
"""Weight of a kink relative to other points: smoothing keeps it in place, with both sides meeting
there."""
FEWEST = 5
"""Least number of points of a section that can be smoothed."""
NOISE = 1.0
"""Width below which a part may be noise on a steep side [mm]."""


@dataclass(frozen=True, eq=False)
class Curve:
    """A piecewise cubic curve over a parameter s, very nearly its arc length [mm].

    `coefficients` has shape (4, n - 1, 2): the cubics of y and z in ``s - s[i]``, highest power
    first.
    """

    s: np.ndarray
    coefficients: np.ndarray

    @lazy_property
    def _curve(self) -> Any:
        from scipy.interpolate import PPoly

        return PPoly(self.coefficients, self.s)

    @lazy_property
    def _breakpoints(self) -> np.ndarray:
        a, b, c, d = self.coefficients[:, -1]
        width = self.s[-1] - self.s[-2]
        last = ((a * width + b) * width + c) * width + d
        return np.concatenate([self.coefficients[3], last[None]])

    @lazy_property
    def _middle_directions(self) -> np.ndarray:
        return self.directions((self.s[1:] + self.s[:-1]) / 2)

    def points(self, s: np.ndarray) -> np.ndarray:
        """(y, z) at parameters, shape (..., 2)."""
        return np.asarray(self._curve(s))

    def directions(self, s: np.ndarray) -> np.ndarray:
        """(dy/ds, dz/ds) at parameters, shape (..., 2), very nearly of unit length."""
        return np.asarray(self._curve(s, 1))

    def points_and_directions(self, s: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """(y, z) and (dy/ds, dz/ds) at parameters (n,), shape (2, n)."""
        cell = self.s[1:-1].searchsorted(s, side="right")
        t = s - self.s[cell]
        a, b, c, d = self._by_coordinate.take(cell, axis=2)
        points = ((a * t + b) * t + c) * t + d
        directions = (3 * a * t + 2 * b) * t + c
        return points, directions

    @lazy_property
    def _by_coordinate(self) -> np.ndarray:
        """Coefficients, shape (4, 2, n - 1)."""
        return np.ascontiguousarray(self.coefficients.swapaxes(1, 2))

    def cubics(self, begin: np.ndarray, within: np.ndarray) -> np.ndarray:
        """The cubics at parameters `within`, in ``s - begin``: coefficients, shape (4, n, 2),
        highest power first.
        """
        cell = self.s[1:-1].searchsorted(within, side="right")
        return shifted(self.coefficients[:, cell], (begin - self.s[cell])[:, None])

    def angles(self, s: np.ndarray) -> np.ndarray:
        """Inclination atan2(dz, dy) at parameters [rad]."""
        along = self.directions(s)
        return np.asarray(np.arctan2(along[..., 1], along[..., 0]))

    def curvatures(self, s: np.ndarray) -> np.ndarray:
        """Signed curvature at parameters [1/mm]: positive where the inclination grows along the
        curve.
        """
        first = self.directions(s)
        second = np.asarray(self._curve(s, 2))
        turn = first[..., 0] * second[..., 1] - first[..., 1] * second[..., 0]
        return np.asarray(turn / np.hypot(first[..., 0], first[..., 1]) ** 3)

    def moved(self, matrix: np.ndarray, shift: np.ndarray) -> Curve:
        """The curve after ``matrix @ point + shift``."""
        coefficients = np.asarray(self.coefficients @ np.asarray(matrix).T)
        coefficients[3] += shift
        return Curve(self.s, coefficients)

    @lazy_property
    def mirrored(self) -> Curve:
        """The mirror image at y = 0, run through the other way: y keeps its direction."""
        width = np.diff(self.s)[:, None]
        # the cubic in width - t
        a, b, c, d = shifted(self.coefficients * [-1.0, 1.0], width)
        turned = np.array([-a, b, -c, d])
        return Curve(self.s[-1] - self.s[::-1], turned[:, ::-1])

    def sampled(self, step: float) -> np.ndarray:
        """Parameters from end to end, about a step [mm] apart."""
        intervals = int(np.ceil((self.s[-1] - self.s[0]) / step))
        return np.linspace(self.s[0], self.s[-1], max(2, intervals + 1))

    @lazy_property
    def finely(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Parameters `STEP` apart, with the points and directions there."""
        s = self.sampled(STEP)
        return s, self.points(s), self.directions(s)

    def single_valued(self, y: float, direction: np.ndarray) -> Curve:
        """The part around a place `y` of a curve along which y grows, along which ``direction . (y,
        z)`` keeps growing, too.
        """
        place = int(self._breakpoints[:, 0].searchsorted(y))
        breakpoint_near = min(max(place, 1), self.s.size - 1)
        return self._part(growing(self._grows(direction), breakpoint_near))

    def highest(self) -> Curve:
        """The highest part along which y keeps growing; one within the noise of a steep
        side does not count.
        """
        runs = self._runs()
        widest = max(self._width(run) for run in runs)
        wide = [run for run in runs if self._width(run) > min(NOISE, widest / 2)]
        return self._part(min(wide, key=lambda run: float(self._breakpoints[run, 1].min())))

    def widest(self) -> Curve:
        """The widest part along which y keeps growing."""
        return self._part(max(self._runs(), key=self._width))

    def _runs(self) -> list[slice]:
        """The runs of breakpoints along which y keeps growing."""
        grows = self._grows(ACROSS)
        if not grows.any():
            message = "no part of the profile can be touched: y grows nowhere along it"
            raise SceneError("profile.y", float(self._breakpoints[0, 0]), message=message)
        starts = np.flatnonzero(grows & ~np.append(False, grows[:-1]))
        stops = np.flatnonzero(grows & ~np.append(grows[1:], False))
        return [slice(a, b + 2) for a, b in zip(starts.tolist(), stops.tolist(), strict=True)]

    def _grows(self, direction: np.ndarray) -> np.ndarray:
        """True where ``direction . (y, z)`` grows from a breakpoint to the next, without a turning
        point between them.
        """
        along = self._breakpoints @ direction
        larger = along[1:] > along[:-1]
        return larger & (self._middle_directions @ direction > 0)

    def _width(self, run: slice) -> float:
        return float(self._breakpoints[run.stop - 1, 0] - self._breakpoints[run.start, 0])

    def _part(self, run: slice) -> Curve:
        return Curve(self.s[run], self.coefficients[:, run.start : run.stop - 1])

    def at(self, value: np.ndarray, direction: np.ndarray = ACROSS) -> np.ndarray:
        """Parameters where ``direction . (y, z)``, which has to grow along the curve, has values;
        NaN beyond its ends.

        Newton's method, kept within the cubic that has the value.
        """
        value = np.asarray(value)
        ends = self._breakpoints @ direction
        inside = (value >= ends[0]) & (value <= ends[-1])
        wanted = value[inside]
        cell = ends[1:-1].searchsorted(wanted, side="right")
        low = self.s[cell]
        width = self.s[cell + 1] - low
        a, b, c, d = self.coefficients.take(cell, axis=1) @ direction
        t = width * (wanted - ends[cell]) / (ends[cell + 1] - ends[cell])
        for _ in range(STEPS):
            step = (((a * t + b) * t + c) * t + d - wanted) / ((3 * a * t + 2 * b) * t + c)
            t = np.minimum(np.maximum(t - step, 0.0), width)
            if step.size == 0 or np.abs(step).max() <= LAST_STEP * (self.s[-1] - self.s[0]):
                break
        s = np.full(value.shape, np.nan)
        s[inside] = low + t
        return s


def shifted(cubics: np.ndarray, by: np.ndarray) -> np.ndarray:
    """Coefficients of cubics in t as those in ``t - by``, highest power first."""
    a, b, c, d = cubics
    return np.array(
        [a, b + 3 * a * by, c + (2 * b + 3 * a * by) * by, d + (c + (b + a * by) * by) * by]
    )


def growing(grows: np.ndarray, near: int) -> slice:
    """Run of points around `near` in which every step grows, according to `grows`."""
    falls = np.ones(grows.size + 2, dtype=bool)  # also before the first step and after the last
    falls[1:-1] = ~grows
    ends = falls.nonzero()[0]
    behind = int(ends.searchsorted(near + 1))
    return slice(int(ends[behind - 1]), int(ends[behind]))


def spline(points: np.ndarray, kinks: np.ndarray, smoothing: float) -> Curve:
    """The curve through points, shape (n, 2), whose direction jumps at the indices `kinks`.

    `smoothing` is the wavelength that is halved [mm]; 0: the curve goes through the points.
    """
    s = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(points, axis=0).T))])
    last = len(points) - 1
    fits = []
    for a, b in pairwise([0, *kinks.tolist(), last]):
        section = slice(a, b + 1)
        fits.append(_fit(s[section], points[section], smoothing, (a > 0, b < last)))
    return Curve(s, np.concatenate(fits, axis=1))


def _fit(
    s: np.ndarray, points: np.ndarray, smoothing: float, kinks: tuple[bool, bool]
) -> np.ndarray:
    """Coefficients of one smooth section; kinks at its ends stay in their places.

    A cubic smoothing spline, which minimises the integral of the squared distance plus ``lambda``
    times that of the squared second derivative, passes a wave of length L with the factor ``1/(1 +
    lambda (2 pi/L)^4)``. Its ends would be straight: it is fitted to a longer section, which goes
    on from each end with the curvature there.
    """
    from scipy.interpolate import CubicSpline, PPoly, make_smoothing_spline

    if smoothing == 0 or s.size < FEWEST:
        return np.asarray(CubicSpline(s, points).c)
    # the longer section
    before, points_before = _beyond(s, points, smoothing, 0)
    behind, points_behind = _beyond(s, points, smoothing, -1)
    longer = np.concatenate([s[0] + before[::-1], s, s[-1] - behind])
    along = np.concatenate([points_before[::-1], points, points_behind])
    # its smoothing splines, of y and of z
    first = before.size
    weights = np.gradient(longer)
    weights[[first, first + s.size - 1]] *= np.where(kinks, HELD, 1.0)
    strength = (smoothing / (2 * np.pi)) ** 4
    parts = []
    for coordinate in along.T:
        smooth = make_smoothing_spline(longer, coordinate, weights, strength)
        parts.append(PPoly.from_spline(smooth))
    # their cubics on the section itself
    knots = parts[0].x
    # from_spline repeats the end knots
    keep = (np.diff(knots) > 0) & (knots[:-1] >= s[0]) & (knots[:-1] < s[-1])
    return np.stack([part.c[:, keep] for part in parts], axis=-1)


def smoothed_in_third_order(points: np.ndarray, kinks: np.ndarray, smoothing: float) -> np.ndarray:
    """Points, shape (n, 2), on the cubic B-spline that minimises the integral of the squared
    distance plus ``lambda`` times that of the squared third derivative, between `kinks`.

    It passes a wave of length L with the factor ``1/(1 + (smoothing/L)^6)``, parabolas unchanged.
    """
    s = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(points, axis=0).T))])
    smooth = points.copy()
    for a, b in pairwise([0, *kinks.tolist(), len(points) - 1]):
        if b + 1 - a >= FEWEST:
            section = slice(a, b + 1)
            smooth[section] = _third_order(s[section], points[section], smoothing)
    smooth[kinks] = points[kinks]
    return smooth


def _third_order(s: np.ndarray, points: np.ndarray, smoothing: float) -> np.ndarray:
    """Points of one section, fitted to a longer one, see `_fit`."""
    from scipy.interpolate import BSpline
    from scipy.sparse import diags_array, eye_array
    from scipy.sparse.linalg import splu

    before, points_before = _beyond(s, points, smoothing, 0)
    behind, points_behind = _beyond(s, points, smoothing, -1)
    longer = np.concatenate([s[0] + before[::-1], s, s[-1] - behind])
    along = np.concatenate([points_before[::-1], points, points_behind])
    knots = np.concatenate([longer[:1].repeat(4), longer[2:-2], longer[-1:].repeat(4)])
    basis = BSpline.design_matrix(longer, knots, 3)
    # coefficients of the third derivative, which is constant between knots
    third = eye_array(longer.size, format="csr")
    for degree in (3, 2, 1):
        widths = knots[degree + 1 : -1] - knots[1 : -degree - 1]
        third = diags_array(degree / widths) @ (third[1:] - third[:-1])
        knots = knots[1:-1]
    strength = (smoothing / (2 * np.pi)) ** 6
    weighted = basis.T @ diags_array(np.gradient(longer))
    penalty = third.T @ diags_array(np.diff(knots)) @ third
    fitted = splu((weighted @ basis + strength * penalty).tocsc()).solve(weighted @ along)
    return np.asarray((basis @ fitted)[before.size : before.size + s.size])


def _beyond(
    s: np.ndarray, points: np.ndarray, smoothing: float, end: int
) -> tuple[np.ndarray, np.ndarray]:
    """Distances (negative) and points beyond an end, on the parabola through the points within the
    smoothed wavelength.
    """
    away = np.abs(s - s[end])
    near = np.argsort(away)[: max(FEWEST, int(np.count_nonzero(away <= smoothing)))]
    step = float(away[near].max()) / (len(near) - 1)
    out = -step * np.arange(1, int(np.ceil(2 * smoothing / step)) + 1)
    return out, polyval(out, polyfit(away[near], points[near], 2)).T
