"""Profiles that change along the rail, as of switches and crossings, or around the wheel, as with a
flat; and the surfaces through them.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any, ClassVar, Literal, cast

import numpy as np

from varcontact import checks
from varcontact.errors import SceneError
from varcontact.io.contact_words import located
from varcontact.system.process import lazy_property
from varcontact.wheel_rail.curve import Curve, growing, spline
from varcontact.wheel_rail.profile import Profile
from varcontact.wheel_rail.profile_files import Kind
from varcontact.wheel_rail.profile_shape import guess_mirror_z
from varcontact.wheel_rail.slices_file import read_slices_file

SLICES = (".slcs", ".slcw")
"""Endings of CONTACT's files of slices."""
TABLE = 0.25
"""Step of the table of a section, from which the search for its points starts [mm]."""
STEPS = 8
"""Newton steps in the projection on a section."""
STEP_TOL = 1e-11
"""Length of the last of these steps [mm]."""
OFF_TOL = 1e-3
"""Distance from the surface [mm] above which these steps have failed."""
LEAST_WEIGHT = 1e-10
"""Weight below which a slice is left out."""
BREAKPOINT_WEIGHT = 0.1
"""Weight above which the kinks and breakpoints of a slice are used."""
DIGITS = 10
"""Decimals of v in which breakpoints of two slices differ."""


@dataclass(frozen=True, eq=False, kw_only=True)
class ProfileSlices(checks.Checked, approximating=checks.flag):
    """Cross sections of a rail at positions along the track, or of a wheel at angles around it.

    Between slices, points at the same part of the arc length, or of that
    between two features, lie on a cubic spline. Two slices at one position are
    a step, or, if they are equal, a kink. Before the first slice and behind the
    last one a rail goes on unchanged, for patches that reach beyond them; the
    middle of the wheel, ``position.s``, has to be within the slices. The spline
    of a wheel is closed.

    Parameters
    ----------
    profiles : Profile, or sequence of Profile
        All in one coordinate system; one of them stands for all positions.
    positions : array_like, shape (n,)
        Ascending: along the track [mm], see `Position.s`, or around the wheel,
        as x = r sin(angle), z = r cos(angle) with the wheel at `Position.pitch`
        = 0 [rad].
    z : float or array_like, shape (n,)
        Added to the profiles' z: height of the rail, downwards, or change of
        the wheel's radius [mm].
    features : array_like, shape (n, m), optional
        Arc lengths from the first point of each profile at which they
        correspond [mm]; its ends if not given.
    kinks : sequence of int
        Inner features, from 0, at which sections have a kink: their direction
        jumps there, as it does at those of the profiles.
    approximating : bool
        Whether slices are the control points of a cubic B-spline, which passes
        near them, as CONTACT's approximating spline; the spline passes through
        them if False. Waves of measured slices are smoothed: those of four
        spacings lose a third, those of two two thirds.

    Raises
    ------
    SceneError
        For slices out of order, naming the first, three at one position,
        profiles of both kinds, angles of more than a turn, and features that do
        not ascend.

    Examples
    --------
    >>> import numpy as np
    >>> flat = np.linspace(-0.05, 0.05, 41)  # a chord of a wheel with a radius of 460 mm
    >>> angles = [-0.05, *flat, 0.05]  # twice at its ends, where it has kinks
    >>> depth = 460 * (np.cos(0.05) / np.cos(angles) - 1)
    >>> wheel = ProfileSlices(profiles=Profile.s1002(), positions=angles, z=depth)
    >>> print(wheel)
    ProfileSlices(wheel, 43 slices, -0.05 to 0.05 rad)
    """

    _words: ClassVar = {
        "profile": "profiles",
        "angles": "positions",
        "s": "positions",
        "dr": "z",
        "radii": "z",
    }
    profiles: Profile | Sequence[Profile]
    positions: Any
    z: Any = 0.0
    features: Any = None
    kinks: Sequence[int] = ()
    approximating: bool = False

    def __post_init__(self) -> None:
        set_ = object.__setattr__
        positions = checks.array("slices.positions", self.positions, 1)
        profiles = _checked_profiles(self.profiles, positions.size)
        _check_order(positions, profiles[0].kind)
        z = checks.numbers("slices.z", self.z)
        if z.ndim and z.shape != positions.shape:
            raise checks.wrong_shape(
                "slices.z", z.shape, f"a number, or one for each position, {positions.size}"
            )
        if self.features is not None:
            set_(self, "features", _checked_features(self.features, positions.size))
        set_(self, "kinks", _checked_kinks(self.kinks, self.features))
        set_(self, "profiles", profiles)
        set_(self, "positions", positions)
        set_(self, "z", np.broadcast_to(z, positions.shape) + 0.0)

    def __repr__(self) -> str:
        first, last = self.positions[[0, -1]]
        unit = "mm" if self.kind == "rail" else "rad"
        extent = f"{first:g} to {last:g} {unit}"
        return f"ProfileSlices({self.kind}, {self.positions.size} slices, {extent})"

    @property
    def kind(self) -> Kind:
        """The kind of all profiles: "rail" or "wheel"."""
        return self.first.kind

    @property
    def first(self) -> Profile:
        """The first slice, from which gauge, rail tops and the flange's place are measured."""
        assert isinstance(self.profiles, tuple)
        return self.profiles[0]

    @property
    def constant(self) -> bool:
        """True if all slices are one profile."""
        assert isinstance(self.profiles, tuple)
        return all(each is self.first for each in self.profiles) and not self.z.any()

    @classmethod
    @checks.named_options(lambda given: checks.options_of(Profile.read))
    def read(
        cls,
        path: str | Path,
        kind: Kind,
        *,
        mirror_y: bool | Literal["auto"] = "auto",
        mirror_z: bool | None = None,
        scale: float = 1.0,
        smoothing: float = 0.0,
        kinks: Literal["auto"] | Sequence[float] = "auto",
    ) -> ProfileSlices | tuple[ProfileSlices, ...]:
        """Read slices from a file of CONTACT (`.slcs` of rails, `.slcw` of wheels).

        Parameters
        ----------
        path : str or Path
            Profiles that it names are looked for from its folder.
        kind : {"rail", "wheel"}
        mirror_y, mirror_z, scale, smoothing, kinks
            Of all profiles, see `Profile.read`: `scale` has the millimetres by
            their unit of length, and not that of the positions. If `mirror_z`
            is not given, the first profile tells.

        Returns
        -------
        ProfileSlices, or tuple of ProfileSlices
            Several if features are missing in some slices, such as those before the
            nose of a crossing: rails beside each other.

        Raises
        ------
        SceneError
            If the file or a profile cannot be read, or slices are out of order,
            with the line.
        """
        file = checks.file_name("path", path)
        scale = checks.positive("scale", scale)
        mirrored = mirror_z

        def profile_of(path: Path) -> Profile:
            # all as the first one
            nonlocal mirrored
            if mirrored is None:
                mirrored = guess_mirror_z(path, kind, scale)
            return Profile.read(
                path,
                kind,
                mirror_y=mirror_y,
                mirror_z=mirrored,
                scale=scale,
                smoothing=smoothing,
                kinks=kinks,
            )

        found = read_slices_file(file, kind, profile_of)
        with located(found.header):
            whole = cls(
                profiles=found.profiles,
                positions=found.positions,
                approximating=found.approximating,
            )
            if found.features is None:
                return whole
            rails = tuple(_rails_of(whole, found.features, found.kinks))
        if len(rails) == 1:
            return rails[0]
        return rails


def _checked_profiles(given: Any, count: int) -> tuple[Profile, ...]:
    """Profiles of one kind, one for each position."""
    profiles = (given,) * count if isinstance(given, Profile) else tuple(given)
    if not profiles or any(not isinstance(each, Profile) for each in profiles):
        raise SceneError("slices.profiles", given, "a Profile, or one for each position")
    if len(profiles) != count:
        raise SceneError("slices.profiles", len(profiles), f"as many as positions, {count}")
    kind = profiles[0].kind
    for number, each in enumerate(profiles, 1):
        if each.kind != kind:
            raise SceneError("slices.profiles", number, f"all of a {kind}: slice {number} is not")
    return profiles


def _check_order(positions: np.ndarray, kind: Kind) -> None:
    """Refuse positions that do not ascend, three that are equal, and angles of more than a turn."""
    step = np.diff(positions)
    equal = np.concatenate([[False], (step[1:] == 0) & (step[:-1] == 0)])[: step.size]
    wrong = np.flatnonzero((step < 0) | equal)
    if wrong.size:
        i = int(wrong[0])
        reason = f"slices.positions: slice {i + 2} at {positions[i + 1]:g} is out of order"
        raise SceneError("slices.positions", float(positions[i + 1]), message=reason)
    extent = float(np.ptp(positions))
    if kind == "wheel" and extent >= 2 * np.pi:
        raise SceneError("slices.positions", extent, "angles in rad, within less than a turn")


def _checked_features(given: Any, count: int) -> np.ndarray:
    features = checks.array("slices.features", given, 2)
    complete = len(features) == count and features.shape[1] >= 2
    if not complete or (np.diff(features, axis=1) <= 0).any():
        allowed = "two or more that ascend, for each position"
        raise SceneError("slices.features", features.shape, allowed)
    return features


def _checked_kinks(given: Any, features: np.ndarray | None) -> tuple[int, ...]:
    """Numbers of inner features, ascending."""
    numbers = np.unique(checks.numbers("slices.kinks", given))
    last = 0
    allowed = "none: there are no features"
    if features is not None:
        last = features.shape[1] - 1
        allowed = f"numbers of inner features, 1 to {last - 1}"
    if not np.all((numbers == np.rint(numbers)) & (numbers >= 1) & (numbers < last)):
        raise SceneError("slices.kinks", given, allowed)
    return tuple(numbers.astype(int).tolist())


def _rails_of(
    slices: ProfileSlices, features: np.ndarray, kinks: Sequence[int]
) -> Iterator[ProfileSlices]:
    """Slices of each rail with its features, by a table of arc lengths, negative where a slice
    lacks a feature; of `kinks` those of its own.
    """
    profiles = cast(Sequence[Profile], slices.profiles)
    present = (features[:, :-1] >= 0) & (features[:, 1:] >= 0)  # between two features
    ends = np.flatnonzero((present[:, 1:] != present[:, :-1]).any(axis=0)) + 1
    for first, last in pairwise([0, *ends.tolist(), features.shape[1] - 1]):
        rows = np.flatnonzero(present[:, first])
        if rows.size:
            own = features[rows, first : last + 1]
            ascends = (np.diff(own, axis=1) > 0).all(axis=0)
            counted = np.concatenate([[True], ascends])
            numbers = (first + np.flatnonzero(counted)).tolist()
            yield ProfileSlices(
                profiles=[profiles[i] for i in rows.tolist()],
                positions=slices.positions[rows],
                features=own[:, counted],
                kinks=[k for k, number in enumerate(numbers[:-1]) if k > 0 and number in kinks],
                approximating=slices.approximating,
            )


def sliced(given: Profile | ProfileSlices) -> ProfileSlices:
    """Slices unchanged; a profile as the only slice."""
    if isinstance(given, ProfileSlices):
        return given
    return ProfileSlices(profiles=given, positions=[0.0])


@dataclass(frozen=True, eq=False)
class Surface:
    """A surface by its sections, each over v from 0 to the number of features less one.

    `curves` are the different sections, with their arc lengths at the `features`. `weights`, shape
    (n, m + 1), has those of the curves at each position, and what is added to z. Positions are x,
    or angles from a wheel's bottom.
    """

    positions: np.ndarray
    curves: tuple[Curve, ...]
    features: np.ndarray
    weights: np.ndarray
    period: float = np.inf
    approximating: bool = False
    kinks: tuple[int, ...] = ()

    @lazy_property
    def _weights(self) -> Any:
        """The weights over all positions: cubics between steps, and constant before the first
        position and after.
        """
        from scipy.interpolate import CubicSpline, PPoly

        at = self.positions
        weights = self.weights
        if np.isfinite(self.period):  # closed
            at = np.concatenate([at - self.period, at, at + self.period])
            weights = np.tile(weights, (3, 1))
        constant = np.zeros((4, 2, weights.shape[1]))
        constant[3] = weights[[0, -1]]
        through = _approximation if self.approximating else CubicSpline
        breaks = [at[:1] - 1.0]
        cubics = [constant[:, :1]]
        steps = np.flatnonzero(np.diff(at) == 0) + 1
        for a, b in pairwise([0, *steps.tolist(), at.size]):
            if b - a > 1:
                between = through(at[a:b], weights[a:b])
                breaks.append(between.x[:-1])
                cubics.append(between.c)
        breaks += [at[-1:], at[-1:] + 1.0]
        return PPoly(np.concatenate([*cubics, constant[:, 1:]], axis=1), np.concatenate(breaks))

    @lazy_property
    def s(self) -> np.ndarray:
        """v along a section, `TABLE` apart."""
        count = int(np.diff(self.features, axis=1).sum(axis=1).max() / TABLE)
        v = np.linspace(0.0, self.features.shape[1] - 1, max(count, 2) + 1)
        if not self.kinks:
            return v
        # beside a kink nothing but the kink
        beside = np.abs(v[:, None] - np.array(self.kinks)).min(axis=1) < (v[1] - v[0]) / 2
        return np.sort(np.concatenate([v[~beside], self.kinks]))

    def points(self, at: np.ndarray, v: np.ndarray) -> np.ndarray:
        """Points, and their derivatives by position and by v, shape (3, ..., 2)."""
        at, v = np.broadcast_arrays(at, v)
        if np.isfinite(self.period):
            at = self.positions[0] + (at - self.positions[0]) % self.period
        breaks = self._weights.x
        strips = np.clip(np.searchsorted(breaks, at, side="right") - 1, 0, breaks.size - 2)
        points = np.empty((3, *at.shape, 2))
        for i in np.unique(strips).tolist():
            here = strips == i
            strip = self._strip(i)
            t = (at[here] - breaks[i])[:, None]
            a, b, c, d = np.moveaxis(strip(v[here]), 1, 0)
            points[0, here] = ((a * t + b) * t + c) * t + d
            points[1, here] = (3 * a * t + 2 * b) * t + c
            a, b, c, d = np.moveaxis(strip(v[here], 1), 1, 0)
            points[2, here] = ((a * t + b) * t + c) * t + d
        return points

    @lazy_property
    def _strips(self) -> dict[int, Any]:
        return {}

    def _strip(self, i: int) -> Any:
        """The cubic along x between two positions, (4, 2) by v: the sections are added up once, not
        at each point.
        """
        if i not in self._strips:
            from scipy.interpolate import PPoly

            width = float(np.diff(self._weights.x[i : i + 2])[0])
            weights = self._weights.c[:, i]
            largest = (np.abs(weights[:, :-1]) * width ** np.arange(3, -1, -1)[:, None]).sum(axis=0)
            # breakpoints of the sections nearby: those further away hardly matter
            nearby = np.flatnonzero(largest > BREAKPOINT_WEIGHT).tolist()
            ends = [self._at_features(k, self.curves[k].s) for k in nearby]
            v = np.unique(np.concatenate([np.arange(self.features.shape[1]), *ends]).round(DIGITS))
            cubics = np.zeros((4, v.size - 1, 4, 2))
            cubics[3, :, :, 1] = weights[:, -1]
            for k in np.flatnonzero(largest > LEAST_WEIGHT).tolist():
                cubics += weights[:, k, None] * self._cubics(k, v)[:, :, None]
            self._strips[i] = PPoly(cubics, v)
        return self._strips[i]

    def _at_features(self, k: int, s: np.ndarray) -> np.ndarray:
        """v at arc lengths of the curve k."""
        return np.interp(s, self.features[k], np.arange(self.features.shape[1]))

    def _cubics(self, k: int, v: np.ndarray) -> np.ndarray:
        """Coefficients of the curve k between v, shape (4, n - 1, 2)."""
        between = np.clip(v[:-1].astype(int), 0, self.features.shape[1] - 2)
        stretch = np.diff(self.features[k])[between]
        begin = self.features[k, between] + (v[:-1] - between) * stretch
        cubics = self.curves[k].cubics(begin, begin + stretch * np.diff(v) / 2)
        return cubics * stretch[:, None] ** np.arange(3, -1, -1)[:, None, None]

    def section(self, at: float) -> Curve:
        """The section at a position, as a curve."""
        kinks = np.searchsorted(self.s, np.array(self.kinks, dtype=float))
        return spline(self.points(np.array(at), self.s)[0], kinks, 0.0)


def _approximation(at: np.ndarray, values: np.ndarray) -> Any:
    """The cubic B-spline of which values are the control points; its knots are the places but the
    second from the ends.

    Of evenly spaced ones it has (1, 4, 1)/6 of three values at the middle one.
    """
    from scipy.interpolate import BSpline, PPoly

    degree = min(3, at.size - 1)
    knots = np.concatenate([at[:1].repeat(degree + 1), at[2:-2], at[-1:].repeat(degree + 1)])
    curve = BSpline(knots, values, degree)
    breaks = np.unique(knots)
    return PPoly([curve(breaks[:-1], k) / math.factorial(k) for k in (3, 2, 1, 0)], breaks)


def surface_of(
    slices: ProfileSlices, placed: Callable[[Profile], Curve], shift: float, *, backwards: bool
) -> Surface:
    """The surface of slices, each `placed`, and their positions shifted: `backwards` where that
    turns its direction.
    """
    profiles = cast(Sequence[Profile], slices.profiles)
    features = slices.features
    sections_kinks = tuple(slices.kinks)
    # one curve for each profile, or, as features are of slices, for each slice
    keys = list(range(len(profiles)))
    if features is None:
        keys = [id(each) for each in profiles]
    different = list(dict.fromkeys(keys))
    curves = tuple(placed(profiles[keys.index(key)]) for key in different)
    if features is None:
        features = np.array([curve.s[[0, -1]] for curve in curves])
    elif backwards:
        features = np.array([[curve.s[-1]] for curve in curves]) - features[:, ::-1]
        last = features.shape[1] - 1
        sections_kinks = tuple(last - k for k in reversed(sections_kinks))
    weights = np.eye(len(curves))[[different.index(key) for key in keys]]
    period = 2 * np.pi if slices.kind == "wheel" else np.inf
    weights = np.concatenate([weights, slices.z[:, None]], axis=1)
    return Surface(
        positions=slices.positions + shift,
        curves=curves,
        features=features,
        weights=weights,
        period=period,
        approximating=slices.approximating,
        kinks=sections_kinks,
    )


@dataclass(frozen=True, eq=False)
class RailSurface:
    """Rails under one wheel, each over its own x; the highest counts."""

    parts: tuple[Surface, ...]

    @lazy_property
    def ends(self) -> np.ndarray:
        """x between which each rail is, shape (n, 2): the first and the last one go on."""
        first, last = np.array([each.positions[[0, -1]] for each in self.parts]).T
        before = np.where(first == first.min(), -np.inf, first)
        behind = np.where(last == last.max(), np.inf, last)
        return np.stack([before, behind], axis=1)

    def sections(self, x: float) -> list[Curve]:
        """Sections of all rails, (y, z)."""
        there = (self.ends[:, 0] <= x) & (x <= self.ends[:, 1])
        return [self.parts[i].section(x).highest() for i in np.flatnonzero(there)]

    def section(self, x: float, y: float) -> Curve:
        """Section of the highest rail at a place, or of the nearest where it is between two."""
        beyond = np.maximum(np.maximum(self.ends[:, 0] - x, x - self.ends[:, 1]), 0.0)
        nearest = int(beyond.argmin())
        curves = self.sections(float(np.clip(x, *self.ends[nearest])))
        height = [float(curve.points(curve.at(np.array([y])))[0, 1]) for curve in curves]
        return curves[int(np.argmin(np.nan_to_num(height, nan=np.inf)))]

    def along(
        self, points: np.ndarray, direction: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Distances from points along a direction to the highest rail, and its slopes there along x
        and y; NaN where no rail is.

        Points have the shape (rows, columns, 3), each column near one x. Newton's method for the
        distance and v.
        """
        shape = points.shape[:2]
        far, by_x, by_y = (np.full(shape, np.nan) for _ in range(3))
        x = points[..., 0].mean(axis=0)
        for part, (first, last) in zip(self.parts, self.ends, strict=True):
            v = _begin_on_rail(part, points, x, (first <= x) & (x <= last))
            here = np.isfinite(v)
            if not here.any():
                continue
            v = v[here]
            start = points[here]
            away = np.zeros(v.size)
            for _ in range(STEPS):
                at = start + away[:, None] * direction
                point, turned, along = part.points(at[:, 0], v)
                off = at[:, 1:] - point
                moved = direction[1:] - turned * direction[0]
                determinant = moved[:, 1] * along[:, 0] - moved[:, 0] * along[:, 1]
                step = (off[:, 0] * along[:, 1] - off[:, 1] * along[:, 0]) / determinant
                further = (moved[:, 1] * off[:, 0] - moved[:, 0] * off[:, 1]) / determinant
                v = np.clip(v + further, 0.0, part.s[-1])
                away = away + step
                if np.abs(step).max() < STEP_TOL:
                    break
            # where this rail is higher than those before
            slope = along[:, 1] / along[:, 0]
            nearer = ~(far[here] <= away) & (np.abs(off).max(axis=1) < OFF_TOL)
            far[here] = np.where(nearer, away, far[here])
            by_y[here] = np.where(nearer, slope, by_y[here])
            by_x[here] = np.where(nearer, turned[:, 1] - slope * turned[:, 0], by_x[here])
        return far, by_x, by_y


def _begin_on_rail(
    part: Surface, points: np.ndarray, x: np.ndarray, present: np.ndarray
) -> np.ndarray:
    """v of a rail below points, by its sections at the x of columns where it is `present`; NaN
    elsewhere.
    """
    v = np.full(points.shape[:2], np.nan)
    sections = part.points(x[present], part.s[:, None])[0]
    for j, section in zip(np.flatnonzero(present), sections.swapaxes(0, 1), strict=True):
        across, height = section.T
        run = growing(np.diff(across) > 0, int(height.argmin()))
        v[:, j] = np.interp(points[:, j, 1], across[run], part.s[run], left=np.nan, right=np.nan)
    return v
