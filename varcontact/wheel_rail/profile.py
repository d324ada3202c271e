"""Cross sections of wheels and rails, measured or designed."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING, Literal

import numpy as np

from varcontact import checks
from varcontact.errors import DoubtfulProfile, SceneError, warn
from varcontact.html import preformatted
from varcontact.system.files import check_ending, write_whole
from varcontact.system.process import lazy_property
from varcontact.wheel_rail.curve import Curve, spline
from varcontact.wheel_rail.profile_files import (
    KINDS,
    Kind,
    rail_60e1,
    read_points,
    s1002,
)
from varcontact.wheel_rail.profile_fit import fitted, normal_distances, outlying, turning
from varcontact.wheel_rail.profile_shape import (
    TOGETHER,
    check_shape,
    direction,
    doubt_of,
    exchanged_sides,
    flange,
    mirrors_z,
    start_opposite,
)
from varcontact.wheel_rail.profile_writers import endings_of, written

if TYPE_CHECKING:
    from matplotlib.figure import Figure

FEWEST = 10
"""Least number of points of a profile."""
KINK = np.radians(30.0)
"""Least change of direction at a kink [rad]."""
KINK_BESIDE = 1 / 3
"""Largest change of direction at the points beside a kink, divided by that at the kink."""
KINK_BY_MEDIAN = 8.0
"""Least change of direction at a kink, divided by the median of that at all points."""
LOST = 1.0
"""Height of a wheel's flange that may be missing in the part that can touch [mm]."""


@dataclass(frozen=True, eq=False, kw_only=True)
class Profile(checks.Checked):
    """The cross section of a rail or a wheel, in millimetres.

    y points to the outside of the track (the field side) and z down, for rails
    and wheels, left and right. A wheel's flange is at negative y, and its z
    counts from the nominal running circle: larger z is a larger radius.

    Parameters
    ----------
    y, z : array_like, shape (n,)
        Points one after the other along the profile, from either end [mm].
    kind : {"rail", "wheel"}
    smoothing : float
        Wavelength that smoothing halves [mm]: a wave of a third of it keeps one
        part in 80, one of three times its length loses one part in 80. 0: the
        curve goes through the points. Curvatures, and with them pressures, come
        from second differences of the points, so noise counts.
    kinks : "auto" or sequence of float
        Where the direction jumps: y of the points nearest to them; "auto":
        points that turn by more than 30 degrees while their neighbours hardly
        turn, and by more than noise does at the others. Kinks stay as they are,
        whatever the smoothing.
    name : str
        For reports and pictures.

    Raises
    ------
    SceneError
        For points that are too few, not finite, or cross or repeat themselves,
        a width of less than a millimetre, and smoothing shorter than the
        points' spacing.

    Warns
    -----
    DoubtfulProfile
        For points that look like those of the other kind, like y and z
        exchanged, like z that points up, or like a flange on the wrong side.
        They are taken as they are.

    Examples
    --------
    >>> import numpy as np
    >>> angle = np.linspace(-0.5, 0.5, 101)
    >>> rail = Profile(y=300 * np.sin(angle), z=300 * (1 - np.cos(angle)), kind="rail")
    >>> print(f"{1 / rail.curvature_at(10.0):.2f} mm")
    300.00 mm
    """

    y: np.ndarray
    z: np.ndarray
    kind: Kind
    smoothing: float = 0.0
    kinks: Literal["auto"] | Sequence[float] = "auto"
    name: str = ""

    def __post_init__(self) -> None:
        set_ = object.__setattr__
        set_(self, "kind", checks.choice("profile.kind", self.kind, KINDS))
        y = checks.array("profile.y", self.y, 1)
        z = checks.array("profile.z", self.z, 1)
        if y.size != z.size:
            raise checks.wrong_shape(
                "profile.z", z.shape, f"as long as profile.y, {y.size} numbers"
            )
        points = np.stack([y, z], axis=1)
        if len(points) >= FEWEST:  # from the track side, without points that lie on each other
            points = start_opposite(points, self.kind)
            points = points[:: direction(points, self.kind)]
            steps = np.hypot(*np.diff(points, axis=0).T)
            points = points[np.append(True, steps > TOGETHER * np.median(steps))]
        if len(points) < FEWEST:
            reason = f"the profile has {len(points)} different points; it needs {FEWEST} at least"
            raise SceneError("profile", len(points), message=reason)
        check_shape(points)
        doubt = doubt_of(points, self.kind)
        if doubt and self.name:
            doubt = f"{self.name}: {doubt}"
        if doubt:
            warn(doubt, DoubtfulProfile)
        points.flags.writeable = False
        set_(self, "y", points[:, 0])
        set_(self, "z", points[:, 1])
        spacing = float(np.median(np.hypot(*np.diff(points, axis=0).T)))
        smoothing = checks.number("profile.smoothing", self.smoothing)
        if smoothing != 0 and smoothing < spacing:
            allowed = f"0 (none), or at least the points' spacing, {spacing:.3g} mm"
            raise SceneError("profile.smoothing", smoothing, allowed)
        set_(self, "smoothing", smoothing)
        if not isinstance(self.kinks, str):
            kinks = checks.numbers("profile.kinks", self.kinks).ravel()
            if ((kinks < points[:, 0].min()) | (kinks > points[:, 0].max())).any():
                raise SceneError("profile.kinks", self.kinks, "y within the profile [mm]")
            set_(self, "kinks", tuple(kinks.tolist()))
        elif self.kinks != "auto":
            raise SceneError("profile.kinks", self.kinks, 'y of the kinks [mm], or "auto"')

    def __repr__(self) -> str:
        words = [str(self.kind)]
        if self.name:
            words.append(repr(self.name))
        words.append(f"{self.y.size} points")
        words.append(f"y {self.y[0]:.4g} to {self.y[-1]:.4g} mm")
        if self.smoothing:
            words.append(f"smoothing={self.smoothing:g}")
        return f"Profile({', '.join(words)})"

    def _repr_html_(self) -> str:
        return preformatted(repr(self))

    @classmethod
    @checks.named_options()
    def read(
        cls,
        path: str | Path,
        kind: Kind | None = None,
        *,
        mirror_y: bool | Literal["auto"] = "auto",
        mirror_z: bool | None = None,
        scale: float = 1.0,
        smoothing: float = 0.0,
        kinks: Literal["auto"] | Sequence[float] = "auto",
    ) -> Profile:
        """Read a profile from a file.

        Parameters
        ----------
        path : str or Path
            Two columns, y and z, with a number of the point before them or
            words behind them (`.txt`, `.csv`, `.dat`), SIMPACK (`.prr` of
            rails, `.prw` of wheels) or MiniProf (`.ban` of rails, `.whl` of
            wheels, `.mpt` with one profile).
        kind : {"rail", "wheel"}, optional
            Needed for columns and `.mpt`; the other formats show it by their
            suffix.
        mirror_y : bool or "auto"
            Whether y changes its sign. "auto": of wheels, where the flange is
            at positive y; never of rails: solving warns of those that lean to
            the field side, and the picture names the track side.
        mirror_z : bool, optional
            Whether z changes its sign: True for files with z up. The header of
            SIMPACK, with its ``mirror.z``, is applied before. By default the
            file decides: ``mirror.z`` is all that is needed, and the words "z
            up" or "z down", such as "y, z up [mm]", say what z is. A file that
            says neither is guessed, with a warning where z is changed:
            MiniProf's rails have z up unless that makes them hollow; others
            have it if they look upside down, as a head that is flat at its
            lowest point.
        scale : float
            Millimetres by the file's unit of length, on top of what its header
            says.
        smoothing, kinks
            See `Profile`.

        Raises
        ------
        SceneError
            If there is no such file, its format is not known, it has no points,
            or they make no profile.

        Warns
        -----
        DoubtfulProfile
            Where a guess changes the sign of z, a rail is hollow, or a file of
            MiniProf has fewer points than its ``XYPoints``; and see `Profile`.
        """
        if mirror_z is not None:
            mirror_z = checks.flag("mirror_z", mirror_z)
        if mirror_y != "auto" and not isinstance(mirror_y, (bool, np.bool_)):
            raise SceneError("mirror_y", mirror_y, '"auto", true or false')
        points, kind, z_up = read_points(path, kind)
        y, z = checks.positive("scale", scale) * points.T
        if mirror_z is None:
            mirror_z = mirrors_z(y, z, kind, path, z_up)
        if mirror_z:
            z = -z
        if mirror_y == "auto":
            mirror_y = kind == "wheel" and flange(y, z) > 0
        if mirror_y:
            y = -y
        name = Path(path).name
        try:
            return cls(y=y, z=z, kind=kind, smoothing=smoothing, kinks=kinks, name=name)
        except SceneError as error:
            raise SceneError(error.field, error.value, message=f"{name}: {error}") from None

    @classmethod
    @checks.named_options()
    def s1002(cls, *, step: float = 0.25) -> Profile:
        """The wheel S1002 of EN 13715, its points a `step` apart [mm]."""
        y, z = s1002(checks.positive("step", step))
        return cls(y=y, z=z, kind="wheel", name="S1002")

    @classmethod
    @checks.named_options()
    def rail_60e1(cls, *, step: float = 0.25) -> Profile:
        """The head of the rail 60E1 (UIC 60) of EN 13674-1, upright, its points a `step` apart
        [mm].
        """
        y, z = rail_60e1(checks.positive("step", step))
        return cls(y=y, z=z, kind="rail", name="60E1")

    @checks.named_options()
    def save(self, path: str | Path) -> None:
        """Write the points to a file, as `read` takes it.

        Parameters
        ----------
        path : str or Path
            Two columns with z down (`.csv`, and `.txt` in the form of CONTACT),
            SIMPACK's (`.prr` of rails, `.prw` of wheels), or MiniProf's (`.ban`
            of rails, with z up, and `.whl` of wheels). An existing file is
            replaced.

        Raises
        ------
        OutputError
            If the file cannot be written, or the ending is none of these.
        """
        file = checks.file_name("path", path)
        check_ending("path", file, *endings_of(self.kind))
        points = np.stack([self.y, self.z], axis=1)
        text = written(points, self.kind, self.name, file.suffix.lower())
        write_whole("path", file, text.encode())

    @lazy_property
    def curve(self) -> Curve:
        """The spline, run through towards the outside."""
        return spline(np.stack([self.y, self.z], axis=1), self.kink_points, self.smoothing)

    @lazy_property
    def kink_points(self) -> np.ndarray:
        """Indices of the points that are kinks."""
        if not isinstance(self.kinks, str):
            nearest = {int(np.abs(self.y - y).argmin()) for y in self.kinks}
            return np.array(sorted(nearest - {0, self.y.size - 1}), dtype=int)
        turn = np.abs(np.diff(np.unwrap(np.arctan2(np.diff(self.z), np.diff(self.y)))))
        beside = np.maximum(np.append(turn[1:], 0.0), np.insert(turn[:-1], 0, 0.0))
        least = max(KINK, KINK_BY_MEDIAN * float(np.median(turn)))
        return np.flatnonzero((turn > least) & (beside < KINK_BESIDE * turn)) + 1

    @lazy_property
    def exchanged_sides(self) -> str:
        """The sentence on a rail whose sides are probably exchanged, or nothing."""
        return exchanged_sides(self.y, self.z)

    @lazy_property
    def running(self) -> Curve:
        """The part that can be touched from above (a rail) or from below (a wheel): y keeps growing
        along it.
        """
        if self.kind == "rail":
            return self.curve.highest()
        touched = self.curve.widest()
        y, z = touched.points(touched.s).T
        if np.ptp(y) < np.ptp(self.y) / 2 or z.max() < self.z.max() - LOST:
            words = (
                f"the wheel touches y = {y[0]:.4g} to {y[-1]:.4g} mm "
                f"of {self.y.min():.4g} to {self.y.max():.4g} mm alone: "
                "y has to keep growing, and noise runs back; smooth the profile"
            )
            warn(words, DoubtfulProfile)
        return touched

    def z_at(self, y: float | np.ndarray) -> np.ndarray:
        """Height at lateral positions `y` on the part that can be touched [mm]; NaN beyond the
        profile.
        """
        return self.running.points(self.running.at(checks.numbers("y", y)))[..., 1]

    def angle_at(self, y: float | np.ndarray) -> np.ndarray:
        """Inclination atan(dz/dy) at lateral positions `y` [rad]; NaN beyond the profile."""
        return self.running.angles(self.running.at(checks.numbers("y", y)))

    def curvature_at(self, y: float | np.ndarray) -> np.ndarray:
        """Curvature at lateral positions `y` [1/mm], positive where the body is convex; NaN beyond
        the profile.
        """
        curvatures = self.running.curvatures(self.running.at(checks.numbers("y", y)))
        if self.kind == "wheel":
            return -curvatures
        return curvatures

    @checks.named_options()
    def smoothed(self, length: float) -> Profile:
        """Copy with another smoothing, of the wavelength `length` [mm], see `Profile`."""
        return replace(self, smoothing=length)

    @checks.named_options()
    def shifted(self, *, y: float = 0.0, z: float = 0.0) -> Profile:
        """The profile moved by `y` and `z` [mm]."""
        shift = np.array([checks.number("y", y), checks.number("z", z)])
        return self._moved(0.0, shift)

    @checks.named_options()
    def rotated(self, angle: float, *, about: tuple[float, float] = (0.0, 0.0)) -> Profile:
        """The profile turned by an `angle` [rad], from y towards z, `about` a point (y, z) [mm].

        Examples
        --------
        >>> wheel = Profile.s1002()
        >>> back = wheel.rotated(0.02).aligned(wheel)
        >>> print(f"{abs(back.z - wheel.z).max():.6f} mm")
        0.000000 mm
        """
        turn = checks.number("angle", angle)
        centre = checks.array("about", about, shape=(2,))
        return self._moved(turn, centre - turning(turn) @ centre)

    @checks.named_options()
    def aligned(
        self,
        to: Profile,
        *,
        over: tuple[float, float] | None = None,
        rotate: bool = True,
    ) -> Profile:
        """The profile moved, and turned, onto another one, with the least squares of its points'
        normal distances.

        Parameters
        ----------
        to : Profile
            Such as the nominal one, of the same kind.
        over : (float, float), optional
            Only points opposite this part of `to` count, from a y to a greater
            one [mm]: one that does not wear. By default all do.
        rotate : bool
            False: shifts only.

        Raises
        ------
        SceneError
            For a profile of the other kind, and where fewer than ten points
            are within 20 mm of `to` and opposite the part `over`.
        """
        self._check_other(to)
        limits = (-np.inf, np.inf)
        if over is not None:
            low, high = checks.array("over", over, shape=(2,)).tolist()
            if low >= high:
                raise SceneError("over", over, "a y and a greater one [mm]")
            limits = (low, high)
        points = np.stack([self.y, self.z], axis=1)
        angle, shift = fitted(points, to.curve, limits, checks.flag("rotate", rotate))
        return self._moved(angle, shift)

    @checks.named_options()
    def distances(self, to: Profile) -> np.ndarray:
        """Normal distances of the points from another profile, `to`, shape (n,) [mm].

        Positive where material is missing; NaN beyond its ends, and farther
        than 20 mm from it.
        """
        self._check_other(to)
        points = np.stack([self.y, self.z], axis=1)
        below, _, _ = normal_distances(points, to.curve)
        if self.kind == "wheel":
            return -below
        return below

    @checks.named_options()
    def trimmed(
        self,
        *,
        y: tuple[float, float] | None = None,
        z: tuple[float, float] | None = None,
    ) -> Profile:
        """The part of the profile within ranges of `y` and `z`, each from a number to a greater
        one [mm].

        SceneError where what is left is not in one piece, or has fewer than ten
        points.
        """
        keep = np.full(self.y.size, True)
        for name, limits, values in (("y", y, self.y), ("z", z, self.z)):
            if limits is None:
                continue
            low, high = checks.array(name, limits, shape=(2,)).tolist()
            keep &= (values >= low) & (values <= high)
        pieces = np.count_nonzero(np.diff(keep.astype(int)) == 1) + int(keep[0])
        if pieces > 1:
            message = f"y, z: the part within these limits has {pieces} pieces, and must be one"
            raise SceneError("y, z", (y, z), message=message)
        return self._of_points(np.flatnonzero(keep))

    @checks.named_options()
    def resampled(self, step: float) -> Profile:
        """Points of the profile's curve a `step` apart [mm], nearly; kinks stay.

        The curve of a smoothed profile becomes points without smoothing.
        """
        spacing = checks.positive("step", step)
        ends = [0, *self.kink_points.tolist(), self.y.size - 1]
        places = [np.zeros(1)]
        for first, last in pairwise(self.curve.s[ends].tolist()):
            intervals = max(1, round((last - first) / spacing))
            places.append(np.linspace(first, last, intervals + 1)[1:])
        y, z = self.curve.points(np.concatenate(places)).T
        kinks = tuple(self.curve.points(self.curve.s[self.kink_points])[:, 0].tolist())
        return replace(self, y=y, z=z, smoothing=0.0, kinks=kinks)

    @checks.named_options()
    def outliers(self, *, distance: float | None = None) -> np.ndarray:
        """Indices of points that are far from the curve through their neighbours.

        Parameters
        ----------
        distance : float, optional
            Largest distance of a point that is kept [mm]. By default six robust
            standard deviations of all points, and at least 0.02 mm, or 0.01/mm
            times the square of the width of five intervals.

        Notes
        -----
        The curve is a parabola through eleven points, with Tukey's weights: up
        to four of them may be wrong. Kinks end it.

        Examples
        --------
        >>> rail = Profile.rail_60e1()
        >>> z = rail.z.copy()
        >>> z[[200, 300, 301]] += 0.1
        >>> from dataclasses import replace
        >>> print(replace(rail, z=z).outliers())
        [200 300 301]
        """
        if distance is not None:
            distance = checks.positive("distance", distance)
        return outlying(np.stack([self.y, self.z], axis=1), self.kink_points, distance)

    @checks.named_options()
    def without_outliers(self, *, distance: float | None = None) -> Profile:
        """The profile without its `outliers`, see there for `distance`."""
        keep = np.setdiff1d(np.arange(self.y.size), self.outliers(distance=distance))
        return self._of_points(keep)

    def _check_other(self, to: Profile) -> None:
        checks.kind("to", to, Profile)
        if to.kind != self.kind:
            raise SceneError("to", f"a {to.kind}'s profile", f"a {self.kind}'s profile")

    def _of_points(self, keep: np.ndarray) -> Profile:
        """Some of the points, with the kinks among them."""
        kinks = self.kinks
        if not isinstance(kinks, str):
            kinks = tuple(self.y[np.intersect1d(self.kink_points, keep)].tolist())
        if keep.size < FEWEST:
            reason = f"{keep.size} points are left of the profile; it needs {FEWEST} at least"
            raise SceneError("profile", int(keep.size), message=reason)
        return replace(self, y=self.y[keep], z=self.z[keep], kinks=kinks)

    def _moved(self, angle: float, shift: np.ndarray) -> Profile:
        """All points, and kinks, after ``turning(angle) @ point + shift``."""
        y, z = (np.stack([self.y, self.z], axis=1) @ turning(angle).T + shift).T
        kinks = self.kinks
        if not isinstance(kinks, str):
            kinks = tuple(y[self.kink_points].tolist())
        return replace(self, y=y, z=z, kinks=kinks)

    def plot(self) -> Figure:
        """Points, curve, kinks and outliers, and the curvature below them."""
        from varcontact.wheel_rail.plots import plot_profile

        return plot_profile(self)
