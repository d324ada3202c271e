"""Solutions of a wheel on a rail: forces, errors and report; T-gamma, friction power and Archard's
wear.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from varcontact import checks
from varcontact.html import Reported
from varcontact.io.labelled import Labelled
from varcontact.scene.plausibility import warn_plausibility
from varcontact.system.process import lazy_property
from varcontact.wheel_rail import plausibility
from varcontact.wheel_rail.patch_solution import PatchSolution, forces_in_words
from varcontact.wheel_rail.position import Position
from varcontact.wheel_rail.quantities import exact_values, report_lines
from varcontact.wheel_rail.wear_depth import PatchWear, Wear
from varcontact.wheel_rail.wear_laws import Archard, ArchardMap
from varcontact.wheel_rail.wheel_geometry import WheelGeometry

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

    from varcontact.gradients.outputs import Output

CONFORMAL = 3.0
"""Least radius of curvature of each profile, in half widths of a patch, for half-spaces."""


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
        return tuple(dict.fromkeys((*plausibility.warnings_of(self.case), *self.patch_warnings)))

    @property
    def patch_warnings(self) -> tuple[str, ...]:
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
        return tuple(
            dict.fromkeys((*plausibility.warnings_of(self.case), *self.patch_warnings, *faults))
        )

    @lazy_property
    def patch_warnings(self) -> tuple[str, ...]:
        """Plausibility warnings of the patches and their scenes, each once."""
        texts: list[str] = []
        for each in self.patches:
            patch = each.patch
            y = float(patch.location[1])
            texts += plausibility.at_tip(y, patch.on_wheel, self.case.wheelset.profile)
            texts += patch.scene.doubts
        return tuple(dict.fromkeys(texts))

    @lazy_property
    def too_wide(self) -> tuple[dict[str, float], ...]:
        """Radii of curvature [mm] of profiles that are small beside the patch, one dict a patch;
        empty for patches on a curved surface.
        """
        return tuple(_too_wide(self.case, each) for each in self.patches)

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
        forces on the rail: Fx = -13.91 +- 0.13 kN, Fy = 1.84 +- 0.20 kN, Fz = 80.0001 kN
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

    def gradient(
        self,
        output: str | Output | Sequence[str | Output],
        by: str | Sequence[str],
        *,
        error: bool = False,
    ) -> xr.Dataset:
        """Derivatives of outputs of each patch by position, load, profiles and
        other numbers of the case, each output from one transposed solve.

        Under a prescribed vertical force the height of the axle follows. Grids
        follow the contact, see `Solution.gradient`: on 14 elements across
        derivatives are within some per cent of those of fine grids.

        Parameters
        ----------
        output : str, Weighted or sequence of these
            Outputs of a patch, as of `Solution.gradient`: "Fx", "Fy" (along
            the patch), "normal_force", "peak_pressure", "friction_work" (the
            patch's T-gamma), ...
        by : str or sequence of str
            "y", "roll", "yaw", "pitch" of the wheel set; "vertical_force"; "rail" and
            "wheel", by the z of each point of the profile near a patch; and other
            numbers of the case by their paths, as "friction", "track.cant".
        error : bool
            Also an estimate of the error of each number, ``<name>_error``: the
            difference to elements twice as large. Of tangential forces by points
            of a profile it can be as large as the derivative, where shares of
            slip and load nearly cancel.

        Returns
        -------
        xarray.Dataset
            "value" and a variable for each input, over "output" and "patch", of
            profiles also "rail_point" or "wheel_point", with ``units`` of mm, N
            and rad.

        Raises
        ------
        SceneError
            As of `Solution.gradient`; without `dx` and `dy`, on curved
            surfaces, for profiles that vary, and where patches join or part.

        Examples
        --------
        >>> from varcontact.wheel_rail import Position, Profile, Track, WheelOnRail, WheelSet
        >>> case = WheelOnRail(
        ...     track=Track(rail=Profile.rail_60e1(), cant=1 / 40),
        ...     wheelset=WheelSet(wheel=Profile.s1002()),
        ...     position=Position(y=3.0), vertical_force=80e3, dx=1.0, dy=1.0)
        >>> found = case.solve().gradient("normal_force", "vertical_force")
        >>> print(f"{float(found.vertical_force.squeeze()):.2f}")
        1.00
        """
        from varcontact.wheel_rail.gradient import gradient

        return gradient(self, output, by, error)

    def plot(self) -> Figure:
        """Both profiles with the patches at their place, and the tractions of each patch."""
        from varcontact.wheel_rail.plots import plot_wheel_on_rail

        return plot_wheel_on_rail(self)


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
    >>> print(f"T-gamma = {worn.t_gamma:.1f} N, {1e6 * depth:.2f} nm per passage")
    T-gamma = 79.0 N, 5.53 nm per passage
    """
    more = ": of a wheel set its left or right wheel, found.left or found.right"
    checks.kind("found", found, WheelRailSolution, more=more)
    if archard is not None:
        checks.kind("archard", archard, Archard, ArchardMap)
        warn_plausibility(plausibility.of_hardness(archard.hardness))
    if yield_in_shear is not None:
        yield_in_shear = checks.positive("yield_in_shear", yield_in_shear)
        warn_plausibility(plausibility.of_yield_stress(yield_in_shear))
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


def _too_wide(case: WheelGeometry, solved: PatchSolution) -> dict[str, float]:
    """Radii of curvature [mm], by profile, that are small beside a patch in a plane."""
    patch = solved.patch
    half = solved.loaded_half_width
    radii: dict[str, float] = {}
    if not patch.in_plane or half == 0:
        return {}
    across = half * np.cos(patch.angle) * np.array([-1.0, 1.0])
    for kind, (curve, y) in case.sections(patch.location, patch.on_wheel).items():
        # averaged over the patch, within the ends of the profile, so that noise does not matter
        ends = curve.points(curve.s[[0, -1]])[:, 0]
        within = np.clip(y + across, *ends)
        part = np.ptp(within) / np.ptp(across)
        if part == 0:
            continue
        turned = curve.angles(curve.at(within))
        curvature = abs(np.sin(float(turned[1] - turned[0]) / 2)) / (part * half)
        if curvature * half * CONFORMAL > 1:
            radii[kind] = float(1 / curvature)
    return radii
