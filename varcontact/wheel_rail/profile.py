"""Cross sections of wheels and rails, measured or designed."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Literal

import numpy as np

from varcontact import checks
from varcontact.errors import SceneError
from varcontact.wheel_rail import profile_points
from varcontact.wheel_rail.curve import Curve, spline
from varcontact.wheel_rail.profile_points import Kind

if TYPE_CHECKING:
    from matplotlib.figure import Figure

KINDS = ("rail", "wheel")
FEWEST = 10
"""Points a profile must have."""
KINK, CALM, RESTLESS = np.radians(30.0), 1 / 3, 8.0
"""A kink turns by so much in one point, the points beside it by less than this part of that, and the median of all
points by less than one part in so many."""


@dataclass(frozen=True, eq=False, kw_only=True)
class Profile:
    """The cross section of a rail or a wheel, in millimetres.

    y points to the outside of the track (the field side) and z down, for rails and wheels, left and right. A wheel's
    flange is at negative y, and its z counts from the nominal running circle: larger z is a larger radius.

    Parameters
    ----------
    y, z : array_like, shape (n,)
        Points one after the other along the profile, from either end [mm].
    kind : {"rail", "wheel"}
    smoothing : float
        Wavelength that smoothing halves [mm]: a wave of a third of it keeps one part in 80, one of three times its
        length loses one part in 80. 0: the curve goes through the points. Curvatures, and with them pressures, come
        from second differences of the points, so noise counts.
    kinks : "auto" or sequence of float
        Where the direction jumps: y of the points nearest to them; "auto": points that turn by more than 30 degrees
        while their neighbours hardly turn, and by more than noise does at the others. Kinks stay as they are, whatever
        the smoothing.
    name : str
        For reports and pictures.

    Raises
    ------
    SceneError
        For points that are too few, not finite, or cross or repeat themselves, a width of less than a millimetre, those
        of the other kind, z that points up, a flange on the wrong side, and smoothing shorter than the points' spacing.

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
        y, z = checks.array("profile.y", self.y, 1), checks.array("profile.z", self.z, 1)
        if y.size != z.size:
            raise checks.wrong_shape("profile.z", z.shape, f"as long as profile.y, {y.size} numbers")
        points = profile_points.ordered(np.stack([y, z], axis=1), self.kind)
        if len(points) < FEWEST:
            raise SceneError(
                "profile",
                len(points),
                message=f"the profile has {len(points)} different points; it needs {FEWEST} at least",
            )
        profile_points.check_width(points)
        profile_points.check_crossing(points)
        profile_points.check_upright(points, self.kind)
        points.flags.writeable = False
        set_(self, "y", points[:, 0])
        set_(self, "z", points[:, 1])
        spacing = float(np.median(np.hypot(*np.diff(points, axis=0).T)))
        smoothing = checks.number("profile.smoothing", self.smoothing)
        if smoothing != 0 and smoothing < spacing:
            raise SceneError(
                "profile.smoothing",
                smoothing,
                f"0 (none), or at least the points' spacing, {spacing:.3g} mm",
            )
        set_(self, "smoothing", smoothing)
        if not isinstance(self.kinks, str):
            kinks = checks.numbers("profile.kinks", self.kinks).ravel()
            if ((kinks < points[:, 0].min()) | (kinks > points[:, 0].max())).any():
                raise SceneError("profile.kinks", self.kinks, "y within the profile [mm]")
            set_(self, "kinks", tuple(kinks.tolist()))
        elif self.kinks != "auto":
            raise SceneError("profile.kinks", self.kinks, 'y of the kinks [mm], or "auto"')

    def __repr__(self) -> str:
        name = f"{self.name!r}, " if self.name else ""
        smoothed = f", smoothing={self.smoothing:g}" if self.smoothing else ""
        return f"Profile({self.kind}, {name}{self.y.size} points, y {self.y[0]:.4g} to {self.y[-1]:.4g} mm{smoothed})"

    @classmethod
    def read(
        cls,
        path: str | Path,
        kind: Kind | None = None,
        *,
        mirror_y: bool | Literal["auto"] = "auto",
        mirror_z: bool = False,
        scale: float = 1.0,
        smoothing: float = 0.0,
        kinks: Literal["auto"] | Sequence[float] = "auto",
    ) -> Profile:
        """Read a profile from a file.

        Parameters
        ----------
        path : str or Path
            Two columns, y and z (`.txt`, `.csv`, `.dat`), SIMPACK (`.prr` of rails, `.prw` of wheels) or MiniProf
            (`.ban` of rails, `.whl` of wheels).
        kind : {"rail", "wheel"}, optional
            Needed for columns; the other formats tell by their suffix.
        mirror_y : bool or "auto"
            Whether y changes its sign. "auto": of wheels, where the flange is at positive y; never of rails: solving
            warns of those that lean to the field side, and the picture names the track side.
        mirror_z : bool
            Whether z changes its sign, for files with z up.
        scale : float
            Millimetres by the file's unit of length, on top of what its header says.
        smoothing, kinks
            See `Profile`.

        Returns
        -------
        Profile

        Raises
        ------
        SceneError
            If there is no such file, its format is not known, it has no points, or they make no profile.
        """
        from varcontact.wheel_rail.profile_files import read_points

        mirror_z = checks.flag("mirror_z", mirror_z)
        if mirror_y != "auto" and not isinstance(mirror_y, (bool, np.bool_)):
            raise SceneError("mirror_y", mirror_y, '"auto", true or false')
        found = read_points(path, kind)
        factor = checks.positive("scale", scale)
        y, z = factor * found.points.T
        if mirror_z:
            z = -z
        mirrored = found.kind == "wheel" and profile_points.flange(y, z) > 0 if mirror_y == "auto" else mirror_y
        if mirrored:
            y = -y
        name = Path(path).name
        try:
            return cls(y=y, z=z, kind=found.kind, smoothing=smoothing, kinks=kinks, name=name)
        except SceneError as error:
            raise SceneError(error.field, error.value, message=f"{name}: {error}") from None

    @classmethod
    def s1002(cls, *, step: float = 0.25) -> Profile:
        """The wheel S1002 of EN 13715, see `varcontact.wheel_rail.standard_profiles`.

        Parameters
        ----------
        step : float
            Distance of its points [mm].

        Returns
        -------
        Profile
        """
        from varcontact.wheel_rail.standard_profiles import s1002

        y, z = s1002(checks.positive("step", step))
        return cls(y=y, z=z, kind="wheel", name="S1002")

    @classmethod
    def rail_60e1(cls, *, step: float = 0.25) -> Profile:
        """The head of the rail 60E1 (UIC 60) of EN 13674-1, upright: see `varcontact.wheel_rail.standard_profiles`.

        Parameters
        ----------
        step : float
            Distance of its points [mm].

        Returns
        -------
        Profile
        """
        from varcontact.wheel_rail.standard_profiles import rail_60e1

        y, z = rail_60e1(checks.positive("step", step))
        return cls(y=y, z=z, kind="rail", name="60E1")

    @cached_property
    def curve(self) -> Curve:
        """The spline, run through towards the outside."""
        return spline(np.stack([self.y, self.z], axis=1), self.kink_points, self.smoothing)

    @cached_property
    def kink_points(self) -> np.ndarray:
        """Indices of the points that are kinks."""
        if isinstance(self.kinks, str):
            return _kinks(np.stack([self.y, self.z], axis=1))
        nearest = {int(np.abs(self.y - y).argmin()) for y in self.kinks}
        return np.array(sorted(nearest - {0, self.y.size - 1}), dtype=int)

    @cached_property
    def running(self) -> Curve:
        """The part that can be touched from above (a rail) or from below (a wheel): y keeps growing along it."""
        tread = np.abs(self.y).argmin() if self.kind == "wheel" else self.z.argmin()
        curve = self.curve
        at = curve.sampled(0.5)
        away = curve.points(at) - [self.y[tread], self.z[tread]]
        return curve.single_valued(np.array([1.0, 0.0]), float(at[np.hypot(*away.T).argmin()]))

    def z_at(self, y: float | np.ndarray) -> np.ndarray:
        """Height at lateral positions on the part that can be touched [mm].

        Parameters
        ----------
        y : array_like, shape (...)
            [mm]

        Returns
        -------
        ndarray, shape (...)
            NaN beyond the profile.
        """
        return self.running.points(self._at(y))[..., 1]

    def angle_at(self, y: float | np.ndarray) -> np.ndarray:
        """Inclination atan(dz/dy) at lateral positions [rad].

        Parameters
        ----------
        y : array_like, shape (...)
            [mm]

        Returns
        -------
        ndarray, shape (...)
        """
        return self.running.angles(self._at(y))

    def curvature_at(self, y: float | np.ndarray) -> np.ndarray:
        """Curvature at lateral positions [1/mm]: positive where the body is convex.

        Parameters
        ----------
        y : array_like, shape (...)
            [mm]

        Returns
        -------
        ndarray, shape (...)
        """
        return (1 if self.kind == "rail" else -1) * self.running.curvatures(self._at(y))

    def _at(self, y: float | np.ndarray) -> np.ndarray:
        wanted = checks.numbers("y", y)
        return self.running.at(wanted.ravel(), np.array([1.0, 0.0])).reshape(wanted.shape)

    def smoothed(self, length: float) -> Profile:
        """The same points with another smoothing.

        Parameters
        ----------
        length : float
            See `Profile`.

        Returns
        -------
        Profile
        """
        return replace(self, smoothing=length)

    def plot(self) -> Figure:
        """Points, curve and kinks, and the curvature below them.

        Returns
        -------
        Figure
        """
        from varcontact.wheel_rail.pictures import plot_profile

        return plot_profile(self)


def _kinks(points: np.ndarray) -> np.ndarray:
    """Points that turn sharply between neighbours that do not, and more than points do that are noise."""
    along = np.diff(points, axis=0)
    direction = np.unwrap(np.arctan2(along[:, 1], along[:, 0]))
    turn = np.abs(np.diff(direction))
    beside = np.maximum(np.append(turn[1:], 0.0), np.insert(turn[:-1], 0, 0.0))
    least = max(KINK, RESTLESS * float(np.median(turn)))
    return np.flatnonzero((turn > least) & (beside < CALM * turn)) + 1
