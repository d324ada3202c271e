"""Cross sections of wheels and rails, measured or designed."""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING, Literal

import numpy as np

from varcontact import checks
from varcontact.errors import SceneError
from varcontact.html import preformatted
from varcontact.system.files import check_ending, write_whole
from varcontact.system.process import lazy_property
from varcontact.wheel_rail.curve import Curve, growing, spline
from varcontact.wheel_rail.profile_files import KINDS, Z_UP, Kind, rail_60e1, read_points, s1002

if TYPE_CHECKING:
    from matplotlib.figure import Figure

FEWEST = 10
"""Points a profile must have."""
KINK = np.radians(30.0)
"""Least angle by which a kink turns at its point [rad]."""
KINK_BESIDE = 1 / 3
"""Part of it by which the points beside turn less."""
KINK_BY_MEDIAN = 8.0
"""Least angle of a kink, divided by the median of those at all points."""
TOGETHER = 0.02
"""Spacing below which a point is left out, relative to the usual one: its direction is rounding."""
NARROWEST = 1.0
"""Smallest width of a profile [mm]; in metres none has it."""
ON_LINE = 1e-6
"""Distance below which a point lies on a line [mm]."""
FLANGE = 0.1
"""Least distance of a wheel's flange from the middle, relative to the width."""
TIP = 10.0
"""Least depth of its tip below the median of the points [mm]."""
FLANGE_WIDTH = 3.0
"""Least width of a flange within a millimetre of its tip [mm]."""
FLANGE_FACE = 5.0
"""Least height of its face, steeper than 45 degrees [mm]: balls, cones, and hollow or barrelled
treads have none."""
FINE = 0.1
"""Step along the points at which a flange is looked for [mm]."""
WIDE = 10.0
"""Width of a part beside the highest one of a rail that a wheel may touch as well [mm]."""
LOST = 1.0
"""Height of a wheel's flange that may be missing in what touches [mm]."""
BACK = 3.0
"""Smallest rise of a wheel's flange behind its tip, where that is part of the profile [mm]."""
FLAT_DEPTH = 1 / 5
"""Part of the depth of a rail from its lowest point in which it is flat if it is upside down."""
FLAT_WIDTH = 2 / 3
"""Part of the width above which it is: heads are flat on top. Of a groove, even half a circle, it
is 0.6 at most."""
OUTWARDS = 1 / 80
"""Slope to the field side above which the sides of a rail are probably exchanged; 1:20 and 1:40 to
the track side are usual."""
BESIDE = 50
"""The top of a rail, or the lowest point of a wheel, with one in BESIDE of the points to either
side, three at least, shows which way they run."""


class DoubtfulProfile(UserWarning):
    """Points that look like a profile of the other kind, upside down, or of exchanged sides."""


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
        For points that look like those of the other kind, like z that points
        up, or like a flange on the wrong side. They are taken as they are.

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
            points = points[:: _direction(points, self.kind)]
            steps = np.hypot(*np.diff(points, axis=0).T)
            points = points[np.append(True, steps > TOGETHER * np.median(steps))]
        if len(points) < FEWEST:
            reason = f"the profile has {len(points)} different points; it needs {FEWEST} at least"
            raise SceneError("profile", len(points), message=reason)
        _check_shape(points)
        doubt = _doubt(points, self.kind)
        if doubt and self.name:
            doubt = f"{self.name}: {doubt}"
        if doubt:
            warnings.warn(doubt, DoubtfulProfile, stacklevel=3)
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
            Two columns, y and z, or three with a number of the point before
            them (`.txt`, `.csv`, `.dat`), SIMPACK (`.prr` of rails, `.prw` of
            wheels) or MiniProf (`.ban` of rails, `.whl` of wheels, `.mpt` with
            one profile).
        kind : {"rail", "wheel"}, optional
            Needed for columns and `.mpt`; the other formats show it by their
            suffix.
        mirror_y : bool or "auto"
            Whether y changes its sign. "auto": of wheels, where the flange is
            at positive y; never of rails: solving warns of those that lean to
            the field side, and the picture names the track side.
        mirror_z : bool, optional
            Whether z changes its sign, for files with z up. If neither it nor
            the file (``mirror.z`` of SIMPACK) says so, it is guessed, with a
            warning where it is changed: MiniProf's rails have z up unless that
            makes them hollow; others have it if they look upside down, as a
            head that is flat at its lowest point.
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
            Where a guess changes the sign of z, or a rail is hollow, and see
            `Profile`.
        """
        if mirror_z is not None:
            mirror_z = checks.flag("mirror_z", mirror_z)
        if mirror_y != "auto" and not isinstance(mirror_y, (bool, np.bool_)):
            raise SceneError("mirror_y", mirror_y, '"auto", true or false')
        points, kind, says_z = read_points(path, kind)
        y, z = checks.positive("scale", scale) * points.T
        if mirror_z is None:
            mirror_z = not says_z and _guess_mirror(y, z, kind, path)
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
        """Write the points to a file of two columns (.csv) at a `path`, as `read` takes it.

        Raises
        ------
        OutputError
            If the file cannot be written.
        """
        file = checks.file_name("path", path)
        check_ending("path", file, ".csv")
        lines = [f"# {self.name or self.kind}: y to the outside, z down [mm]"]
        lines += [f"{y:.10g},{z:.10g}" for y, z in zip(self.y, self.z, strict=True)]
        write_whole("path", file, ("\n".join(lines) + "\n").encode())

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
            warnings.warn(words, DoubtfulProfile, stacklevel=3)
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
        """The same points with another smoothing, of the wavelength `length` [mm], see
        `Profile`.
        """
        return replace(self, smoothing=length)

    def plot(self) -> Figure:
        """Points, curve and kinks, and the curvature below them."""
        from varcontact.wheel_rail.plots import plot_profile

        return plot_profile(self)


def _check_shape(points: np.ndarray) -> None:
    """Refuse lengths in metres, points that come twice, and segments that cross each other."""
    width = float(np.ptp(points[:, 0]))
    if width < NARROWEST:
        message = (
            f"the profile is {width:.3g} mm wide: give millimetres; "
            "a file in metres is read with scale=1000"
        )
        raise SceneError("profile.y", width, message=message)
    different, times = np.unique(points[:-1], axis=0, return_counts=True)
    if times.max() > 1:
        y, z = different[times.argmax()].tolist()
        message = (
            f"the profile comes back to y = {y:.4g}, z = {z:.4g} mm: "
            "points must be ordered along it"
        )
        raise SceneError("profile", (y, z), message=message)
    crossed = _crossed(points[:-1], points[1:])
    if crossed.size:
        y, z = points[crossed.min() :][:2].mean(axis=0).tolist()
        message = (
            f"the profile crosses itself near y = {y:.4g}, z = {z:.4g} mm: "
            "order, or thin, its points"
        )
        raise SceneError("profile", (y, z), message=message)


def _crossed(start: np.ndarray, end: np.ndarray) -> np.ndarray:
    """Indices of segments that another one crosses, which is no neighbour."""
    low = np.minimum(start, end)
    high = np.maximum(start, end)
    # pairs that have a part of y in common, by the segment that begins first
    order = low[:, 0].argsort()
    after = np.arange(1, order.size + 1)
    counts = np.searchsorted(low[order, 0], high[order, 0], side="right") - after
    first = np.repeat(order, counts)
    offsets = np.repeat(after - (np.cumsum(counts) - counts), counts)
    second = order[np.arange(counts.sum()) + offsets]
    # of these, the ones that have a part of z in common
    near = (
        (low[first, 1] <= high[second, 1])
        & (low[second, 1] <= high[first, 1])
        & (np.abs(first - second) > 1)
    )
    lower = np.minimum(first, second)[near]
    higher = np.maximum(first, second)[near]
    # and of these, the ones whose ends are on both sides of each other
    lower_ends = start[lower], end[lower]
    higher_ends = start[higher], end[higher]
    across = _off(*lower_ends, higher_ends[0]) * _off(*lower_ends, higher_ends[1])
    along = _off(*higher_ends, lower_ends[0]) * _off(*higher_ends, lower_ends[1])
    return lower[(across < -(ON_LINE**2)) & (along < -(ON_LINE**2))]


def _off(first: np.ndarray, last: np.ndarray, point: np.ndarray) -> np.ndarray:
    """Distance of a point to the left of the line from one point to another."""
    line = last - first
    to = point - first
    area = line[..., 0] * to[..., 1] - line[..., 1] * to[..., 0]
    return area / np.hypot(line[..., 0], line[..., 1])


def _direction(points: np.ndarray, kind: Kind) -> int:
    """1 where y grows from one end to the other, or, where these meet, on what can be touched; else
    -1.
    """
    y, z = points.T
    first = 0
    last = y.size - 1
    if abs(y[-1] - y[0]) <= np.ptp(y) / 2:
        touched = int(z.argmin() if kind == "rail" else z.argmax())
        beside = max(3, y.size // BESIDE)
        first = max(touched - beside, 0)
        last = min(touched + beside, y.size - 1)
    return 1 if y[first] < y[last] else -1


def _doubt(points: np.ndarray, kind: Kind) -> str:
    """A sentence on points that look like those of the other kind, z that points up, or a wheel's
    flange on the field side.
    """
    y, z = points.T
    other: Kind = "wheel" if kind == "rail" else "rail"
    if _is_of(other, y, z):
        return f'profile.kind = "{kind}", but the points look like those of a {other}'
    if _upside_down(y, z, kind):
        return (
            f"the {kind}'s profile looks upside down: z points down; "
            "read a file with z up with mirror_z=True"
        )
    if kind == "rail" and (parts := _parts(y, z))[1:]:
        (first, last), (left, right) = parts[:2]
        return (
            f"wheels touch the part at y = {first:.4g} to {last:.4g} mm, "
            f"not that at {left:.4g} to {right:.4g} mm, nearly as high: "
            "along what they touch y must keep growing; cut the other off"
        )
    if kind == "wheel" and flange(y, z) > 0:
        return (
            f"the wheel's flange is at y = {y[z.argmax()]:.4g} mm, the outside: "
            "change the sign of y, or give mirror_y=True"
        )
    return ""


def _parts(y: np.ndarray, z: np.ndarray) -> list[tuple[float, float]]:
    """The ends of the parts along which y keeps growing, wide, and nearly as high as the highest,
    which comes first.
    """
    grows = np.append(False, np.diff(y) > 0)
    starts = np.flatnonzero(~grows)
    runs = [slice(a, b) for a, b in pairwise([*starts.tolist(), y.size])]
    wide = [run for run in runs if np.ptp(y[run]) > WIDE]
    wide.sort(key=lambda run: float(z[run].min()))
    high = [run for run in wide if z[run].min() < z[wide[0]].min() + TIP]
    return [(float(y[run][0]), float(y[run][-1])) for run in high]


def guess_mirror_z(path: Path, kind: Kind, scale: float) -> bool:
    """True if the z of a file is to change its sign, where nobody says it."""
    points, kind, says_z = read_points(path, kind)
    y, z = scale * points.T
    return not says_z and _guess_mirror(y, z, kind, path)


def _guess_mirror(y: np.ndarray, z: np.ndarray, kind: Kind, path: str | Path) -> bool:
    """The same of the points of a file."""
    file = Path(path)
    suffix = file.suffix.lower()
    if kind == "rail" and suffix in Z_UP:
        mirrored = not (_hollow(-z) or _flat_below(y, -z))
        reason = f"{suffix} has z up"
    else:
        mirrored = _upside_down(y, z, kind)
        reason = "the profile looks upside down"
    words = ""
    if mirrored:
        words = f"the sign of z is changed, as {reason}; mirror_z=True or False says what is right"
    elif kind == "rail" and _hollow(z):
        words = (
            "the rail is hollow, with z down; "
            "mirror_z=False says that it is, mirror_z=True that z points up"
        )
    if words:
        warnings.warn(f"{file.name}: {words}", DoubtfulProfile, stacklevel=4)
    return mirrored


def _upside_down(y: np.ndarray, z: np.ndarray, kind: Kind) -> bool:
    """True for a wheel whose flange points up, or a hollow rail that is flat where it is lowest."""
    if kind == "wheel":
        return flange(y, -z) != 0 and flange(y, z) == 0
    return _hollow(z) and _flat_below(y, z)


def _flat_below(y: np.ndarray, z: np.ndarray) -> bool:
    """True if most of the width is near the lowest point."""
    width = np.abs(np.diff(y))
    low = z[1:] > z.max() - FLAT_DEPTH * np.ptp(z)
    return bool(width[low].sum() > FLAT_WIDTH * width.sum())


def _hollow(z: np.ndarray) -> bool:
    """True if the lowest point of a rail is inside, and its highest at an end."""
    ends = (0, len(z) - 1)
    return int(z.argmax()) not in ends and int(z.argmin()) in ends


def flange(y: np.ndarray, z: np.ndarray) -> float:
    """Side of a wheel's flange: -1 at the lesser y, 1 at the greater, 0 if it has none."""
    at = int(z.argmax())
    middle = (y.min() + y.max()) / 2
    width = y.max() - y.min()
    if abs(y[at] - middle) < FLANGE * width or z[at] < np.median(z) + TIP:
        return 0.0
    # on evenly spaced points: how blunt the tip is, and how high the face towards the middle
    s = np.append(0.0, np.cumsum(np.hypot(np.diff(y), np.diff(z))))
    along = np.linspace(0.0, s[-1], int(np.ceil(s[-1] / FINE)) + 1)
    across = np.diff(np.interp(along, s, y))
    down = np.diff(np.interp(along, s, z))
    tip = np.interp(along[1:], s, z) > z[at] - 1.0
    steep = np.abs(down) > np.abs(across)
    inwards = (along[1:] - s[at]) * (middle - y[at]) * (y[-1] - y[0]) > 0
    sharp = np.abs(across[tip]).sum() < FLANGE_WIDTH
    if sharp or np.abs(down[steep & inwards]).sum() < FLANGE_FACE:
        return 0.0
    return float(np.sign(y[at] - middle))


def _falls(y: np.ndarray, z: np.ndarray) -> tuple[np.ndarray, np.ndarray, int]:
    """The run of growing y around the highest point: y, depths below that point, and its index."""
    top = int(z.argmin())
    run = growing(np.diff(y) > 0, top)
    return y[run], z[run] - z[top], top - run.start


def _is_of(kind: Kind, y: np.ndarray, z: np.ndarray) -> bool:
    """True if points are a rail's, both sides of which fall to their ends, or those of a wheel with
    a flange.

    Most of a rail's width is near its top, most of a wheel's far above its flange's tip; beyond the
    groove of a grooved rail there is a lip.
    """
    heights = z
    if kind == "wheel":
        heights = -z  # its flange's tip is its lowest point
    at, depth, top = _falls(y, heights)
    far = np.diff(at) * (depth[1:] > TIP)
    mostly_far = far.sum() > np.ptp(at) / 2
    deepest = np.array([depth[: top + 1].max(), depth[top:].max()])
    if kind == "rail":
        falls_to_ends = bool((depth[[0, -1]] > deepest - ON_LINE).all())
        return not mostly_far and deepest.min() > TIP and falls_to_ends
    lip = min(far[:top].sum(), far[top:].sum())
    return bool(mostly_far and deepest.min() > BACK and lip < TIP) and flange(y, z) != 0


def check_sides(rail: Profile, stacklevel: int) -> None:
    """Warn of a rail's head that leans to the field side around its middle, as of one whose sides
    are exchanged.
    """
    at, depth, top = _falls(rail.y, rail.z)
    left = np.interp(-TIP, -depth[: top + 1], at[: top + 1])
    right = np.interp(TIP, depth[top:], at[top:])
    middle = np.abs(at - (left + right) / 2) < (right - left) / 4
    if min(depth[0], depth[-1]) < TIP or middle.sum() < 3:  # it does not go down on both sides
        return
    slope = np.polyfit(at[middle], depth[middle], 1)[0]
    if slope > OUTWARDS:
        words = (
            f"track.rail: the profile leans to the field side by 1:{1 / slope:.0f}, "
            "so its gauge side is probably on the wrong side: "
            "change the sign of y, or read the file with mirror_y=True"
        )
        warnings.warn(words, stacklevel=stacklevel)
