"""The distance h(x, y) between the undeformed bodies, from body 2 to body 1."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, ClassVar

import numpy as np

from varcontact import checks
from varcontact.checks import Checked, positive
from varcontact.errors import SceneError
from varcontact.scene.frames import along_axes_of_plane, frames_of_elements
from varcontact.scene.grid import Grid
from varcontact.scene.heights import REMOVED, Roughness, levelled, read_heights, roughness_of
from varcontact.scene.interpolation import Interpolation, continuation, smoothed_field
from varcontact.scene.pin import PinInHole
from varcontact.system.process import lazy_property

TURN_MAX = np.pi
"""Largest turn of a reference surface across its samples [rad]."""

STEP_TURN_MAX = 0.3
"""Largest turn of a reference surface from one row or column of samples to the next [rad]."""


@dataclass(frozen=True)
class Paraboloids(Checked, path="surface", Rx=positive, Ry=positive):
    """Undeformed distance ``x^2/(2 Rx) + y^2/(2 Ry)``, (82): a Hertzian contact.

    Parameters
    ----------
    Rx, Ry : float
        Combined radii of curvature along x and y [length], positive and finite.

    Examples
    --------
    >>> Paraboloids(Rx=0.46, Ry=0.30)
    Paraboloids(Rx=0.46, Ry=0.3)
    """

    Rx: float
    Ry: float
    line: ClassVar[bool] = False

    @classmethod
    @checks.named_options()
    def from_bodies(cls, Rx: tuple[float, float], Ry: tuple[float, float]) -> Paraboloids:
        """Paraboloids from the radii of the two bodies, (83)-(84); flat is ``inf``, hollow is
        negative.

        Parameters
        ----------
        Rx, Ry : pair of float
            Radii of body 1 and of body 2, in the planes of x and of y [length].

        Returns
        -------
        Paraboloids

        Raises
        ------
        SceneError
            If a radius is 0, or the bodies do not touch in a point.

        Examples
        --------
        A ball of radius 10 in a groove that is straight along x, hollow with radius 12 across.

        >>> surface = Paraboloids.from_bodies(Rx=(10.0, float("inf")), Ry=(10.0, -12.0))
        >>> print(f"{surface.Rx:.6g} {surface.Ry:.6g}")
        10 60
        """
        combined = []
        for name, pair in (("Rx", Rx), ("Ry", Ry)):
            if not checks.is_array(pair) or len(pair) != 2:
                raise SceneError(f"surface.{name}", pair, "a pair of radii, (body 1, body 2)")
            radii = [
                checks.real(f"surface.{name}", r, "a radius, not zero (inf is flat)") for r in pair
            ]
            if 0.0 in radii or 1 / radii[0] + 1 / radii[1] <= 0:
                raise SceneError(
                    f"surface.{name}",
                    pair,
                    "radii, not zero, with a positive sum of curvatures 1/R",
                )
            combined.append(1 / (1 / radii[0] + 1 / radii[1]))
        return cls(*combined)

    def distance(self, grid: Grid) -> np.ndarray:
        """Undeformed distance (ny, nx) at the centres of the elements of an explicit `grid`
        [length].
        """
        return (grid.x**2 / (2 * self.Rx))[None, :] + (grid.y**2 / (2 * self.Ry))[:, None]


@dataclass(frozen=True)
class Ellipse(Checked, path="surface", a=positive, b=positive):
    """A Hertzian contact given by its contact ellipse; the curvatures follow from the load.

    Parameters
    ----------
    a, b : float
        Semi-axes along x and y [length], positive and finite.

    Examples
    --------
    >>> Ellipse(a=6.8e-3, b=6.5e-3)
    Ellipse(a=0.0068, b=0.0065)
    """

    a: float
    b: float
    line: ClassVar[bool] = False


@dataclass(frozen=True)
class Cylinders(Checked, path="surface", R=positive, reference_depth=positive):
    """Line contact of cylinders with axes along y: undeformed distance
    ``x^2/(2 R)``, forces per unit length.

    Parameters
    ----------
    R : float
        Combined radius [length], ``1/R = 1/R1 + 1/R2``, positive and finite.
    reference_depth : float, optional
        d in the logarithm of plane strain, ``-ln(|x|/d)`` [length]:
        displacements count from the points of the surface at that distance from
        a line load. In plane strain they grow without end, and approaches and
        shifts mean something only with it; needed where one is prescribed.
        Tractions by prescribed forces, and all of steady rolling, do not depend
        on it.

    Examples
    --------
    >>> Cylinders(R=0.25)
    Cylinders(R=0.25, reference_depth=None)
    """

    R: float
    reference_depth: float | None = None
    line: ClassVar[bool] = True

    def distance(self, grid: Grid) -> np.ndarray:
        """Undeformed distance (1, nx) at the centres of the elements of an explicit `grid`
        [length].
        """
        return (grid.x**2 / (2 * self.R))[None, :]


@dataclass(frozen=True, eq=False)
class SampledDistance(Checked, path="surface", reference_depth=positive):
    """Any undeformed distance, measured or computed, by its samples.

    Parameters
    ----------
    h : array_like, shape (ny, nx), or (nx,) in line contact
        Undeformed distance [length], indexed [iy, ix].
    x, y : array_like, shape (nx,) and (ny,), optional
        Where the samples were taken [length], ascending. Given, they serve any
        grid within them, by interpolation (`distance`); not given, the samples
        are those at the element centres of the scene's explicit grid. Line
        contact has no y.
    reference_depth : float, optional
        In line contact only, see `Cylinders`.
    inclination : array_like, shape (ny,), optional
        Conformal contact: the reference surface, halfway between the bodies, is
        curved along y. Its inclination at each y of the samples [rad], positive
        where it turns from y to z; y is then the length of its arc, h the
        distance along its normals, tractions act in the frames of the elements,
        and forces are along the axes of the plane.
    inclination_x : array_like, shape (nx,), optional
        The same along x, the rolling direction: inclination at each x of the
        samples [rad], positive where it turns from x to z; x is then the length
        of its arc. Line contact has this one alone, and needs a
        reference_depth.

    Raises
    ------
    SceneError
        If a sample is not finite, or the shapes do not fit.

    Examples
    --------
    >>> import numpy as np
    >>> x = y = np.linspace(-1.0, 1.0, 41)
    >>> surface = SampledDistance(x**2 / 2 + y[:, None] ** 2 / 2, x, y)
    >>> surface.distance(Grid(nx=2, ny=1, dx=0.3, dy=0.2, x0=-0.3, y0=-0.1)).round(6)
    array([[0.01125, 0.01125]])
    """

    h: np.ndarray
    x: np.ndarray | None = None
    y: np.ndarray | None = None
    reference_depth: float | None = None
    inclination: np.ndarray | None = None
    inclination_x: np.ndarray | None = None

    __repr__ = checks.short_entries

    def __post_init__(self) -> None:
        super().__post_init__()
        set_ = object.__setattr__
        set_(self, "h", checks.array("surface.h", self.h, 1, 2))
        if self.line and self.y is not None:
            raise SceneError("surface.y", self.y, "left out in line contact, where h is one row")
        if not self.line and (self.x is None) != (self.y is None):
            raise SceneError("surface.x, surface.y", (self.x, self.y), "given both or neither")
        if not self.line and self.reference_depth is not None:
            raise SceneError(
                "surface.reference_depth",
                self.reference_depth,
                "left out: only line contact has one",
            )
        columns = self.h.shape[-1]
        rows = self.h.shape[0]
        if self.x is not None:
            set_(self, "x", checks.coordinates("surface.x", self.x, columns, "column of h"))
        if self.y is not None:
            set_(self, "y", checks.coordinates("surface.y", self.y, rows, "row of h"))
        self._check_inclinations()

    def _check_inclinations(self) -> None:
        """Refuse inclinations that turn too far, or that line contact cannot have."""
        set_ = object.__setattr__
        rows, columns = self.samples.shape
        if self.inclination_x is not None and self.line and self.reference_depth is None:
            allowed = (
                "given: where the surface is curved along x, forces along x move the bodies "
                "sideways, by an amount that depends on it"
            )
            raise SceneError("surface.reference_depth", None, allowed)
        if self.inclination is not None and self.line:
            allowed = "left out in line contact, which has no y; give inclination_x"
            raise SceneError("surface.inclination", self.inclination, allowed)
        for name, number, each in (
            ("inclination", rows, "row"),
            ("inclination_x", columns, "column"),
        ):
            if getattr(self, name) is not None:
                set_(self, name, _checked_inclination(name, getattr(self, name), number, each))

    @classmethod
    @checks.named_options()
    def from_heights(
        cls,
        source: Any,
        *,
        spacing: Any = None,
        remove: str | None = None,
        on: Surface | None = None,
        scale: float = 1.0,
        reference_depth: float | None = None,
    ) -> SampledDistance:
        """The distance of a smooth body from a measured surface.

        Parameters
        ----------
        source : object, str, Path or array_like
            An object with ``heights()`` and ``positions()``, as
            SurfaceTopography has them; a file of heights (`.npy`, of which
            nothing is unpickled, `.csv`, `.txt`), or of columns x, y, height
            (`.xyz`, or three columns without a `spacing`); or heights
            (ny, nx), upwards [length].
        spacing : float or (float, float), optional
            Distance of samples along x, and along y, of heights without
            positions [length].
        remove : {"mean", "plane", "curvature"}, optional
            Part that is removed by least squares before `on` is added.
        on : Paraboloids or Cylinders, optional
            The smooth distance on top of which the heights are; without it the
            other body is flat.
        scale : float
            Length by the unit of the heights: 1e-3 for micrometres on
            positions in millimetres.
        reference_depth : float, optional
            In line contact only, see `Cylinders`.

        Returns
        -------
        SampledDistance
            With its coordinates, the origin in the middle of the samples. It is
            not periodic: beyond the samples there is nothing.

        Raises
        ------
        SceneError
            For heights with holes, uneven steps, objects in `.npy`, and files
            that cannot be read.

        Examples
        --------
        >>> import numpy as np
        >>> heights = 1e-4 * np.random.default_rng(0).normal(size=(32, 32)) + 0.1
        >>> surface = SampledDistance.from_heights(
        ...     heights, spacing=0.1, remove="plane", on=Paraboloids(Rx=10.0, Ry=10.0))
        >>> print(f"Sq = {surface.roughness.Sq:.1e}, at least {surface.h.min():.1e}")
        Sq = 9.7e-05, at least 0.0e+00
        """
        heights, x, y = read_heights(source, spacing)
        heights = checks.positive("scale", scale) * heights
        if remove is not None:
            heights = levelled(heights, x, y, checks.choice("remove", remove, REMOVED))
        distance = -heights
        if on is not None:
            distance = distance + _smooth_distance(on, x, y)
        distance = distance - distance.min()
        if y.size == 1:
            return cls(distance[0], x, reference_depth=reference_depth)
        return cls(distance, x, y, reference_depth=reference_depth)

    @property
    def roughness(self) -> Roughness:
        """Root mean square height and slopes about a paraboloid; refused without coordinates."""
        if self.x is None:
            raise SceneError("surface.x", None, "given: slopes need the places of the samples")
        return roughness_of(self.samples, *self.coordinates)

    @property
    def line(self) -> bool:
        """True for line contact: one row of samples along x."""
        return self.h.ndim == 1

    @property
    def samples(self) -> np.ndarray:
        """The samples as (ny, nx), one row in line contact."""
        if self.line:
            return self.h[None]
        return self.h

    @property
    def coordinates(self) -> tuple[np.ndarray, np.ndarray]:
        """x and y of samples that carry them; y is 0 in line contact."""
        assert self.x is not None
        if self.y is None:
            return self.x, np.zeros(1)
        return self.x, self.y

    @property
    def box(self) -> tuple[float, float, float, float]:
        """(left, right, bottom, top) of the samples that carry their own coordinates."""
        x, y = self.coordinates
        if self.line:
            return float(x[0]), float(x[-1]), -0.5, 0.5
        return float(x[0]), float(x[-1]), float(y[0]), float(y[-1])

    def distance(self, grid: Grid, beyond: float = 0.0) -> np.ndarray:
        """Undeformed distance (ny, nx) at the centres of the elements of an explicit `grid`
        [length].

        A bicubic spline; beside cliffs, where splines swing below the samples, Akima's
        interpolation, which does not. Centres may go as far as `beyond` [length] past the samples:
        there the surface goes on straight, or level where that would be lower than at its end.
        SceneError if samples without coordinates are not of the grid's shape, or the grid reaches
        further.
        """
        if self.x is None:
            samples = self.samples
            if samples.shape != grid.shape:
                raise checks.wrong_shape(
                    "surface.h", self.h.shape, f"of the grid's shape {grid.shape}"
                )
            return samples
        left, right, bottom, top = self.box
        size = right - left
        if not self.line:
            size = max(size, top - bottom)
        slack = beyond + 1e-9 * size
        inside = left - slack <= grid.x[0] and grid.x[-1] <= right + slack
        if not (inside and bottom - slack <= grid.y[0] and grid.y[-1] <= top + slack):
            box = tuple(round(v, 12) for v in grid.box)
            raise SceneError(
                "grid", box, f"within the samples: left, right, bottom, top = {self.box}"
            )
        x = np.clip(grid.x, left, right)
        y = np.clip(grid.y, bottom, top)
        level = self._between.at(x, y)
        if np.array_equal(x, grid.x) and np.array_equal(y, grid.y):
            return level
        # beyond the samples: linear extrapolation by the mirror images of the points, only upwards
        mirrored = self._between.at(2 * x - grid.x, y), self._between.at(x, 2 * y - grid.y)
        return np.asarray(level + sum(np.maximum(level - each, 0.0) for each in mirrored))

    def inclination_at(self, grid: Grid) -> np.ndarray:
        """Inclination of each row of a `grid` [rad], shape (ny,): beyond the samples with the
        curvature at the end.
        """
        return _inclination_at(self.y, self.inclination, grid.y)

    def inclination_x_at(self, grid: Grid) -> np.ndarray:
        """Inclination of each column of a `grid` [rad], shape (nx,): beyond the samples with the
        curvature at the end.
        """
        return _inclination_at(self.x, self.inclination_x, grid.x)

    def frames(self, grid: Grid) -> np.ndarray | None:
        """Rotations (3, 3, ny, nx) from the axes of the elements of a `grid` to those of the plane;
        None where the reference surface is the plane.
        """
        if not is_curved(self):
            return None
        return frames_of_elements(self.inclination_at(grid), self.inclination_x_at(grid))

    @checks.named_options()
    def sampled(self, fields: np.ndarray, grid: Grid) -> np.ndarray:
        """Other `fields` (..., ny, nx) given at the samples, at the element centres of a `grid`."""
        if self.x is None:
            return fields
        x, y = self.coordinates
        places = np.clip(grid.x, x[0], x[-1]), np.clip(grid.y, y[0], y[-1])
        # splines of the last fields are reused on the next grid, if the fields are read-only
        of_fields, between = self.__dict__.get("_last_sampled", (None, []))
        if of_fields is not fields or fields.flags.writeable:
            flat = fields.reshape(-1, *self.samples.shape)
            between = [Interpolation.of(x, self.y, each) for each in flat]
            self.__dict__["_last_sampled"] = fields, between
        values = np.array([each.at(*places) for each in between])
        return values.reshape(*fields.shape[:-2], *grid.shape)

    @lazy_property
    def _between(self) -> Interpolation:
        assert self.x is not None
        return Interpolation.of(self.x, self.y, self.h)

    @checks.named_options()
    def smoothed(self, wavelength: float) -> SampledDistance:
        """The surface without waves shorter than a wavelength: for measured
        samples whose noise rules the pressure.

        A wave of length L keeps the part ``1/(1 + (wavelength/L)^6)`` of its
        amplitude, along x and along y; what is long stays as it is, parabolas
        exactly. Beside steps of the samples it swings.

        Parameters
        ----------
        wavelength : float
            [length]

        Returns
        -------
        SampledDistance

        Raises
        ------
        SceneError
            If the wavelength is not positive, or the samples have no
            coordinates.

        Examples
        --------
        >>> x = y = np.linspace(-1.0, 1.0, 41)
        >>> rough = x**2 + y[:, None] ** 2 + 1e-3 * np.random.default_rng(1).normal(size=(41, 41))
        >>> surface = SampledDistance(rough, x, y).smoothed(0.5)
        >>> bool(np.std(surface.h - x**2 - y[:, None] ** 2) < 0.3e-3)
        True
        """
        wavelength = checks.positive("wavelength", wavelength)
        if self.x is None:
            raise SceneError(
                "surface.x",
                None,
                "given: a wavelength in samples without coordinates has no meaning",
            )
        x, y = self.coordinates
        h = smoothed_field(self.samples, x, y, wavelength)
        if self.line:
            h = h[0]
        return replace(self, h=h)


def _smooth_distance(on: Any, x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """The distance of a smooth surface at samples, shape (ny, nx)."""
    if not hasattr(on, "distance") or isinstance(on, SampledDistance):
        raise SceneError("on", on, "a surface in closed form, such as Paraboloids")
    dx = float(x[1] - x[0])
    dy = 1.0
    if y.size > 1:
        dy = float(y[1] - y[0])
    # samples are centres of elements
    left = float(x[0]) - dx / 2
    bottom = float(y[0]) - dy / 2
    grid = Grid(nx=x.size, ny=y.size, dx=dx, dy=dy, x0=left, y0=bottom)
    return np.asarray(on.distance(grid))


Surface = Paraboloids | Ellipse | Cylinders | PinInHole | SampledDistance


def depth_of(surface: Surface) -> float | None:
    """Reference depth of displacements, if a surface of line contact has one."""
    if isinstance(surface, PinInHole):
        return surface.depth
    if isinstance(surface, Cylinders | SampledDistance):
        return surface.reference_depth
    return None


def frames_of(surface: Surface, grid: Grid) -> np.ndarray | None:
    """Rotations (3, 3, ny, nx) from the axes of elements to those of the plane; None: a plane."""
    if not isinstance(surface, PinInHole | SampledDistance):
        return None
    return surface.frames(grid)


def along_axes(
    surface: Surface, grid: Grid, traction: np.ndarray, pressure: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """A `traction` (2, ny, nx) and a `pressure` (ny, nx) on a `grid`, turned to the axes of the
    plane.
    """
    frames = frames_of(surface, grid)
    if frames is None:
        return traction, pressure
    turned = along_axes_of_plane(frames, np.concatenate([traction, pressure[None]]))
    return turned[:2], turned[2]


def is_curved(surface: Surface) -> bool:
    """True where the reference surface is curved: the contact is conformal."""
    return is_curved_along_x(surface) or is_curved_along_y(surface)


def is_curved_along_x(surface: Surface) -> bool:
    """True where the reference surface is curved along the rolling direction."""
    if isinstance(surface, PinInHole):
        return True
    return isinstance(surface, SampledDistance) and surface.inclination_x is not None


def is_curved_along_y(surface: Surface) -> bool:
    """True where the reference surface is curved across the rolling direction."""
    return isinstance(surface, SampledDistance) and surface.inclination is not None


def _checked_inclination(name: str, values: object, number: int, each: str) -> np.ndarray:
    """Inclinations of rows or columns, which turn no further than influence numbers hold."""
    angles = checks.array(
        f"surface.{name}", values, shape=(number,), meant=f"({number},), one for each {each} of h"
    )
    turn = float(np.ptp(angles))
    step = float(np.max(np.abs(np.diff(angles)), initial=0.0))
    if turn > TURN_MAX or step > STEP_TURN_MAX:
        value = f"a turn by {turn:.3g} rad, and by up to {step:.3g} from {each} to {each}"
        allowed = (
            f"at most {TURN_MAX:.3g} rad across the samples, "
            f"and {STEP_TURN_MAX:g} from {each} to {each}"
        )
        raise SceneError(f"surface.{name}", value, allowed)
    return angles


def _inclination_at(
    places: np.ndarray | None, angles: np.ndarray | None, at: np.ndarray
) -> np.ndarray:
    """Inclinations at the rows or columns of a grid; 0 where the surface is straight."""
    if angles is None:
        return np.zeros(at.size)
    if places is None:
        return angles
    return continuation(places, angles)(at)
