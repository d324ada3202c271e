"""Solutions of a wheel on a rail: forces, errors and report; T-gamma, friction power and Archard's
wear.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from varcontact import checks
from varcontact.errors import SceneError
from varcontact.html import Reported
from varcontact.io.labelled import Labelled
from varcontact.kinematics import Creepages, Frame
from varcontact.plasticity.limits import Shakedown, shakedown
from varcontact.results.error_estimate import with_bar
from varcontact.results.quantities_of_interest import units
from varcontact.results.solution import Solution
from varcontact.scene.plausibility import warn
from varcontact.scene.surfaces import SampledDistance, along_axes
from varcontact.system.process import lazy_property
from varcontact.wheel_rail import plausibility
from varcontact.wheel_rail.position import Position
from varcontact.wheel_rail.quantities import exact_values, report_lines
from varcontact.wheel_rail.wear_laws import Archard, ArchardMap
from varcontact.wheel_rail.wheel_geometry import ContactPatch, WheelGeometry

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure


@dataclass(frozen=True, eq=False)
class PatchSolution:
    """A contact patch and its tractions, which act on the rail.

    Attributes
    ----------
    patch : ContactPatch
    solution : Solution
        Of the patch's scene, in mm and N.
    normal_error : float or None
        Estimated relative error of the normal force; None where it was not
        estimated.
    """

    body_names: ClassVar = ("rail", "wheel")
    patch: ContactPatch
    solution: Solution
    normal_error: float | None = None

    def __repr__(self) -> str:
        x, y, z = self.patch.location
        Fx, Fs, FN = self.force
        return (
            f"PatchSolution(location=({x:.4g}, {y:.6g}, {z:.4g}), angle={self.patch.angle:.4g}, "
            f"force=({Fx:.6g}, {Fs:.6g}, {FN:.6g}))"
        )

    @property
    def frame(self) -> Frame:
        """Frame of the patch."""
        return self.patch.frame

    @property
    def location(self) -> np.ndarray:
        """Origin of the frame in track coordinates [mm]."""
        return self.patch.location

    @property
    def angle(self) -> float:
        """Contact angle [rad]."""
        return self.patch.angle

    @property
    def on_rail(self) -> np.ndarray:
        """(y, z) of the origin in the coordinates of the rail's profile [mm]."""
        return self.patch.on_rail

    @property
    def on_wheel(self) -> np.ndarray:
        """(y, z) of the origin in the coordinates of the wheel's profile [mm]."""
        return self.patch.on_wheel

    @property
    def rolling_radius(self) -> float:
        """Radius of the wheel at the origin, undeformed [mm]."""
        return self.patch.rolling_radius

    @property
    def creepage(self) -> Creepages:
        """Creepages of the rail over the wheel."""
        return self.patch.creepage

    @property
    def approach(self) -> float:
        """How deep the undeformed wheel is in the rail [mm]."""
        return self.patch.approach

    @property
    def area(self) -> float:
        """Area of the contact [mm^2]."""
        return float(np.count_nonzero(self.solution.pressure > 0) * self.solution.grid.area)

    @property
    def t_gamma(self) -> float:
        """``-(Fx vx + Fs vy + Mz spin)`` [N]."""
        return self.solution.power

    @property
    def normal_force(self) -> float:
        """FN [N]."""
        return self.solution.normal_force

    @property
    def force(self) -> np.ndarray:
        """(Fx, Fs, FN) on the rail in the contact frame [N]."""
        return np.array([*self.solution.force, self.solution.normal_force])

    @property
    def force_on_track(self) -> np.ndarray:
        """(Fx, Fy, Fz) on the rail in track coordinates [N]; the wheel feels the opposite."""
        return np.asarray(self.patch.frame.axes @ self.force)

    @property
    def error(self) -> np.ndarray:
        """Estimated errors of `force` against the continuum [N]; NaN where grids were not chosen
        for an accuracy.

        Those of the tangential forces on the grid, and what the error of the normal force changes
        in them.
        """
        estimate = self.solution.error_estimate
        share = self.normal_error
        if estimate is None or share is None:
            return np.full(3, np.nan)
        limit = units(self.solution)
        own = [estimate.errors.get(name, 0.0) * limit.get(name, 0.0) for name in ("Fx", "Fy")]
        return np.array([*own, 0.0]) + share * np.abs(self.force)

    @property
    def moment(self) -> float:
        """Moment on the rail about the normal at the frame's origin [N mm]."""
        return self.solution.moment

    @property
    def friction_power(self) -> float:
        """At the rolling velocity of the patch [W]."""
        return self.solution.power * self.patch.creepage.speed / 1e3

    @property
    def tilting(self) -> np.ndarray:
        """Moment about x and y of the frame's origin, (Mx, My, 0) [N mm]: in a plane that of the
        pressure alone.
        """
        grid = self.solution.grid
        tangential, normal = along_axes(
            self.solution.scene.surface, grid, self.solution.traction, self.solution.pressure
        )
        force = np.concatenate([tangential, normal[None]]) * grid.area
        points = np.array(np.broadcast_arrays(grid.x, *(each[:, None] for each in self.rows)))
        return np.cross(points, force, axis=0).sum(axis=(1, 2)) - np.array([0.0, 0.0, self.moment])

    @property
    def rows(self) -> tuple[np.ndarray, np.ndarray]:
        """y and z in the frame of the rows of elements, whose coordinate is the arc length on a
        curved surface.
        """
        from scipy.integrate import cumulative_trapezoid

        surface = self.solution.scene.surface
        along = self.solution.grid.y
        if not isinstance(surface, SampledDistance) or surface.inclination is None:
            return along, np.zeros(along.size)
        angle = surface.inclination_at(self.solution.grid)
        y, z = (
            cumulative_trapezoid(slope, along, initial=0.0)
            for slope in (np.cos(angle), np.sin(angle))
        )
        # from the origin, where the arc length is 0
        return y - np.interp(0.0, along, y), z - np.interp(0.0, along, z)

    @property
    def peak_pressure(self) -> float:
        """Largest pressure, by the error estimate where there is one [N/mm^2]."""
        return self.solution.max_pressure

    @property
    def peak_pressure_error(self) -> float:
        """Estimated error of `peak_pressure` against the continuum [N/mm^2]; NaN where it was not
        estimated.

        That of the grid, and what the error of the normal force changes: the
        peak of Hertz's contact grows by the power 1/3 of the force.
        """
        estimate = self.solution.error_estimate
        share = self.normal_error
        if estimate is None or share is None:
            return np.nan
        return estimate.bars.get("peak_pressure", np.nan) + share / 3 * self.peak_pressure

    @property
    def half_width(self) -> float:
        """Half the width of the contact across the rail [mm]."""
        rows = np.flatnonzero(self.solution.pressure.max(axis=1) > 0)
        if not rows.size:
            return 0.0
        return float(rows[-1] - rows[0] + 1) * self.solution.grid.sides[1] / 2

    def plot(self) -> Figure:
        """Pressure, tractions and the section along x."""
        return self.solution.plot()


def forces_in_words(names: str, values: np.ndarray, errors: np.ndarray) -> str:
    """Forces [N] in kN, with their error bars."""
    pairs = zip(names.split(), values / 1e3, errors / 1e3, strict=True)
    return ", ".join(f"{name} = {with_bar(value, error)} kN" for name, value, error in pairs)


@dataclass(frozen=True, eq=False)
class WheelForces(Labelled):
    """Members of solutions and estimates of wheels on rails, and of wheel sets."""

    case: Any
    z: float
    patches: tuple[Any, ...]

    def __repr__(self) -> str:
        Fx, Fy, Fz = self.force
        count = len(self.patches)
        patches = "1 patch" if count == 1 else f"{count} patches"
        return (
            f"{type(self).__name__}({self.case.side} wheel, {patches}, "
            f"force=({Fx:.6g}, {Fy:.6g}, {Fz:.6g}), z={self.z:.6g})"
        )

    @property
    def position(self) -> Position:
        """Position of the middle of the axle."""
        position: Position = self.case.position
        return position

    @property
    def wheels(self) -> tuple[WheelForces, ...]:
        """The wheels, from left to right."""
        return (self,)

    @property
    def warnings(self) -> tuple[str, ...]:
        """Plausibility warnings of the wheel and of its patches, each once."""
        return tuple(dict.fromkeys((*plausibility.doubts(self.case), *self.patch_doubts)))

    @property
    def patch_doubts(self) -> tuple[str, ...]:
        """Plausibility warnings of the patches, each once."""
        return ()

    def quantities(
        self,
        archard: Archard | ArchardMap | None = None,
        yield_in_shear: float | None = None,
    ) -> list[dict[str, float]]:
        """Quantities of each patch, as in tables of wheels.

        Parameters
        ----------
        archard : Archard or ArchardMap, optional
            For depth and volume of wear.
        yield_in_shear : float, optional
            k of the rail [N/mm^2], for the shakedown limit, see `varcontact.shakedown`: bounds of
            closed form, in about a second for each patch.

        Returns
        -------
        list of dict of str to float
            By the names in `varcontact.wheel_rail.quantities.QUANTITIES`, in
            mm, N, rad, N/mm^2 and W; NaN where an estimate has none.
        """
        raise NotImplementedError

    def to_xarray(
        self,
        archard: Archard | ArchardMap | None = None,
        yield_in_shear: float | None = None,
    ) -> xr.Dataset:
        """Quantities over the patches, those of the axle without dimension, with units: the
        variables of `quantities`, with `archard` for wear and `yield_in_shear` for the shakedown
        limit.
        """
        from varcontact.wheel_rail.datasets import wheels_dataset

        return wheels_dataset(self, archard, yield_in_shear, of_sets=False)

    @property
    def force(self) -> np.ndarray:
        """(Fx, Fy, Fz) on the rails in track coordinates, of all patches [N]."""
        return np.sum([each.force_on_track for each in self.patches], axis=0)

    @property
    def force_on_wheelset(self) -> np.ndarray:
        """Along the axes of the wheel set [N]."""
        return np.asarray(-self.position.rotation.T @ self.force)

    @property
    def moment_on_wheelset(self) -> np.ndarray:
        """About the middle of the axle, along the axes of the wheel set: roll, pitch (torque) and
        yaw [N mm].
        """
        centre = np.array([0.0, self.position.y, self.z - self.case.wheelset.radius])
        total = np.zeros(3)
        for each in self.patches:
            turning = each.frame.normal * each.moment + each.frame.axes @ each.tilting
            total -= np.cross(each.frame.origin - centre, each.force_on_track) + turning
        return np.asarray(self.position.rotation.T @ total)


@dataclass(frozen=True, eq=False, repr=False)
class WheelRailSolution(Reported, WheelForces):
    """All patches of a wheel on a rail, solved.

    Attributes
    ----------
    case : WheelGeometry
    z : float
        Height of the axle, downwards [mm].
    patches : tuple of PatchSolution
        From left to right.
    rounds : int
        Heights that were tried; 0 where it was given.
    """

    case: WheelGeometry
    patches: tuple[PatchSolution, ...]
    rounds: int

    @property
    def warnings(self) -> tuple[str, ...]:
        """Plausibility warnings of the wheel, its patches and their scenes, and faults that rule a
        patch; each once.
        """
        faults = (text for each in self.patches for text in each.solution.warnings)
        return tuple(dict.fromkeys((*plausibility.doubts(self.case), *self.patch_doubts, *faults)))

    @property
    def patch_doubts(self) -> tuple[str, ...]:
        """Plausibility warnings of the patches and their scenes, each once."""
        texts: list[str] = []
        for each in self.patches:
            patch = each.patch
            y = float(patch.location[1])
            texts += plausibility.at_tip(y, patch.on_wheel, self.case.wheelset.profile)
            texts += patch.scene.doubts
        return tuple(dict.fromkeys(texts))

    @property
    def error(self) -> np.ndarray:
        """Estimated errors of `force` against the continuum [N], those of the patches added up; NaN
        if not estimated.

        That of the vertical force is 0 where it is prescribed.
        """
        found = np.sum(
            [np.abs(each.patch.frame.axes) @ each.error for each in self.patches], axis=0
        )
        prescribed = self.case.vertical_force is not None and self.case.with_friction
        return np.asarray(np.where([False, False, prescribed], found * 0.0, found))

    def quantities(
        self,
        archard: Archard | ArchardMap | None = None,
        yield_in_shear: float | None = None,
    ) -> list[dict[str, float]]:
        """Quantities of each patch, as in tables of wheels.

        Parameters
        ----------
        archard : Archard or ArchardMap, optional
            For depth and volume of wear.
        yield_in_shear : float, optional
            k of the rail [N/mm^2], for the shakedown limit, see `varcontact.shakedown`: bounds of
            closed form, in about a second for each patch.

        Returns
        -------
        list of dict of str to float
            By the names in `varcontact.wheel_rail.quantities.QUANTITIES`, in
            mm, N, rad, N/mm^2 and W; NaN where there is none.

        Examples
        --------
        >>> from varcontact.wheel_rail import Position, Profile, Track, WheelOnRail, WheelSet
        >>> case = WheelOnRail(
        ...     track=Track(rail=Profile.rail_60e1(), cant=1 / 40),
        ...     wheelset=WheelSet(wheel=Profile.s1002()),
        ...     position=Position(y=3.0), vertical_force=80e3, dx=1.0, dy=1.0)
        >>> patch, = case.solve().quantities()
        >>> print(f"{patch['on_rail']:.1f} mm, {patch['FN']:.0f} N")
        -12.4 mm, 79825 N
        """
        worn = wear(self, archard, yield_in_shear)
        return [exact_values(each) for each in worn.patches]

    def report(self) -> str:
        """Forces of the wheel and of its patches, with their estimated errors
        or guaranteed bounds, in words.

        Examples
        --------
        >>> from varcontact.wheel_rail import Position, Profile, Track, WheelOnRail, WheelSet
        >>> case = WheelOnRail(
        ...     track=Track(rail=Profile.rail_60e1(), cant=1 / 40),
        ...     wheelset=WheelSet(wheel=Profile.s1002()),
        ...     position=Position(y=3.0), vertical_force=80e3)
        >>> print(case.solve(accuracy=0.02).report().splitlines()[1])
        forces on the rail: Fx = -13.91 +- 0.13 kN, Fy = 1.84 +- 0.20 kN, Fz = 80 kN
        """
        at = self.position
        lines = [f"WARNING: {text}" for text in self.warnings]
        lines += [
            f"{self.case.side} wheel, y = {at.y:.6g} mm, roll = {at.roll:.6g}, yaw = {at.yaw:.6g}, "
            f"height of the axle {self.z:.6g} mm",
            f"forces on the rail: {forces_in_words('Fx Fy Fz', self.force, self.error)}",
        ]
        for k, worn in enumerate(wear(self).patches, 1):
            heading, *rest = report_lines(worn)
            lines.append(f"patch {k} {heading}")
            lines += [f"  {words}" for words in rest]
            each = worn.solved
            bound = each.solution.certificate.force_bound
            if np.isfinite(bound[:2]).all():
                within = f"Fx within {bound[0]:.1e} N, Fs within {bound[1]:.1e} N"
                lines.append(f"  guaranteed on this grid: {within}")
            if each.solution.error_estimate is None:
                reason = "no estimate of the error against the continuum"
                lines.append(f"  {reason}: give an accuracy instead of a grid")
        return "\n".join(lines)

    def plot(self) -> Figure:
        """Both profiles with the patches at their place, and the tractions of each patch."""
        from varcontact.wheel_rail.plots import plot_wheel_on_rail

        return plot_wheel_on_rail(self)


@dataclass(frozen=True, eq=False)
class PatchWear:
    """Indices of wear of one patch.

    Attributes
    ----------
    solved : PatchSolution
    archard : Archard, ArchardMap or None
        Needed for depth and volume alone.
    t_gamma : float
        Energy per distance rolled, ``-(Fx vx + Fs vy + Mz spin)`` [N]. It is
        also what friction dissipates, the sum of `power_by_area`.
    t_gamma_without_spin : float
        ``-(Fx vx + Fs vy)`` [N], as in vehicle codes that know no moment.
    area : float
        Of the contact [mm^2].
    t_gamma_by_area : float
        T-gamma by area of contact [N/mm^2]; Lewis and Olofsson (2004, Wear 257)
        classify regimes of wear by it.
    power : float
        Friction power at the speed of the case [W].
    power_by_area : ndarray, shape (ny, nx)
        Friction power by area [W/mm^2].
    sliding : ndarray, shape (ny, nx)
        Pressure times slip by distance rolled [N/mm^2]: `power_density` by the
        coefficient f. For constant f its integral is T-gamma / f. Where f is
        zero, it is that of the slip of the elements.
    yield_in_shear : float or None
        Needed for the shakedown limit alone [N/mm^2].
    """

    solved: PatchSolution
    archard: Archard | ArchardMap | None
    t_gamma: float
    t_gamma_without_spin: float
    area: float
    t_gamma_by_area: float
    power: float
    power_by_area: np.ndarray
    sliding: np.ndarray
    yield_in_shear: float | None = None

    @lazy_property
    def shakedown(self) -> Shakedown | None:
        """Shakedown limit of the rail by closed forms; None without a yield stress."""
        if self.yield_in_shear is None:
            return None
        return shakedown(self.solved, self.yield_in_shear, "rail", gap=None)

    @property
    def depth(self) -> np.ndarray:
        """Archard's depth of wear by one passage of the patch, at the rows of its grid, shape (ny,)
        [mm].

        A particle stays over an element for the time dx/V, and slides ``|s| dx`` meanwhile, see
        `sliding`. One body has all of it: the rail at each passing wheel, or the wheel at each
        revolution.
        """
        return (self._by_work * self.sliding).sum(axis=1) * self.solved.solution.grid.sides[0]

    @property
    def volume(self) -> float:
        """Archard's volume of wear by distance rolled [mm^3/mm]."""
        return float((self._by_work * self.sliding).sum() * self.solved.solution.grid.area)

    @property
    def t_gamma_error(self) -> float:
        """Estimated error of T-gamma, and so of the friction work, from those of the forces [N];
        NaN without them.
        """
        rolled = self.solved.patch.creepage
        error = self.solved.error
        estimate = self.solved.solution.error_estimate
        if estimate is None:
            return np.nan
        turned = estimate.errors.get("Mz", 0.0) * units(self.solved.solution).get("Mz", 0.0)
        return float(
            abs(rolled.vx) * error[0] + abs(rolled.vy) * error[1] + abs(rolled.spin) * turned
        )

    @property
    def _by_work(self) -> float | np.ndarray:
        if self.archard is None:
            raise SceneError(
                "archard",
                None,
                "given for depth and volume: wear(found, Archard(k=..., hardness=...))",
            )
        if isinstance(self.archard, Archard):
            return self.archard.by_work
        slip_velocity = np.hypot(*self.solved.solution.slip) * self.solved.patch.creepage.speed
        return (
            self.archard.coefficient(self.solved.solution.pressure, slip_velocity)
            / self.archard.hardness
        )


@dataclass(frozen=True, eq=False)
class Wear(Labelled):
    """Indices of wear of all patches of a wheel.

    Attributes
    ----------
    patches : tuple of PatchWear
        From left to right.
    """

    patches: tuple[PatchWear, ...]

    @property
    def t_gamma(self) -> float:
        """T-gamma of all patches [N]."""
        return sum(each.t_gamma for each in self.patches)

    @property
    def power(self) -> float:
        """Friction power of all patches [W]."""
        return sum(each.power for each in self.patches)

    @property
    def volume(self) -> float:
        """Volume of wear of all patches, divided by the distance rolled [mm^3/mm]."""
        return sum(each.volume for each in self.patches)

    def to_xarray(self) -> xr.Dataset:
        """Indices over the patches, power and depth over their rows of elements, with units."""
        from varcontact.wheel_rail.datasets import wear_dataset

        return wear_dataset(self)

    def plot(self) -> Figure:
        """Friction power by area of each patch, and the depth of wear across it where there is a
        law.
        """
        from varcontact.wheel_rail.plots import plot_wear

        return plot_wear(self)


@checks.named_options()
def wear(
    found: WheelRailSolution,
    archard: Archard | ArchardMap | None = None,
    yield_in_shear: float | None = None,
) -> Wear:
    """Indices of wear of a solved wheel on a rail.

    Parameters
    ----------
    found : WheelRailSolution
    archard : Archard or ArchardMap, optional
        For depths and volumes.
    yield_in_shear : float, optional
        k of the rail [N/mm^2], for `PatchWear.shakedown`.

    Examples
    --------
    >>> from varcontact.wheel_rail import Position, Profile, Track, WheelOnRail, WheelSet
    >>> case = WheelOnRail(
    ...     track=Track(rail=Profile.rail_60e1(), cant=1 / 40),
    ...     wheelset=WheelSet(wheel=Profile.s1002()),
    ...     position=Position(y=3.0, yaw=0.003), vertical_force=80e3, dx=1.0, dy=1.0)
    >>> worn = wear(case.solve(), Archard(k=3e-4, hardness=3000.0))
    >>> depth = worn.patches[0].depth.max()
    >>> print(f"T-gamma = {worn.t_gamma:.1f} N, {1e6 * depth:.2f} nm by a passage")
    T-gamma = 79.0 N, 5.53 nm by a passage
    """
    checks.kind("found", found, WheelRailSolution)
    if archard is not None:
        checks.kind("archard", archard, Archard, ArchardMap)
        warn(plausibility.of_hardness(archard.hardness), stacklevel=2)
    if yield_in_shear is not None:
        yield_in_shear = checks.positive("yield_in_shear", yield_in_shear)
        warn(plausibility.of_yield_stress(yield_in_shear), stacklevel=2)
    patches = []
    for each in found.patches:
        solution = each.solution
        rolled = each.creepage
        area = each.area
        t_gamma = each.t_gamma
        density = solution.power_density
        friction: Any = solution.friction
        if friction is None:
            friction = solution.scene.friction
        f = np.asarray(friction, dtype=float)
        with np.errstate(divide="ignore", invalid="ignore"):
            sliding = np.where(f > 0, density / f, solution.pressure * np.hypot(*solution.slip))
        worn = PatchWear(
            solved=each,
            archard=archard,
            t_gamma=t_gamma,
            t_gamma_without_spin=float(
                0.0 - solution.force[0] * rolled.vx - solution.force[1] * rolled.vy
            ),
            area=area,
            t_gamma_by_area=t_gamma / area,
            power=each.friction_power,
            power_by_area=density * rolled.speed / 1e3,
            sliding=sliding,
            yield_in_shear=yield_in_shear,
        )
        patches.append(worn)
    return Wear(tuple(patches))
