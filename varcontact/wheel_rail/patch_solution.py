"""A contact patch with its solution: forces along the track and the patch, errors, pressures."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from varcontact.kinematics import Creepages, Frame
from varcontact.results.error_estimate import with_bar
from varcontact.results.quantities_of_interest import units
from varcontact.results.solution import Solution
from varcontact.scene.surfaces import SampledDistance, along_axes
from varcontact.wheel_rail.wheel_geometry import ContactPatch

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@dataclass(frozen=True, eq=False)
class PatchSolution:
    """A contact patch and its tractions, which act on the rail.

    Attributes
    ----------
    patch : ContactPatch
    solution : Solution
        Solution of the patch's scene, in mm and N.
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
        """Depth of the undeformed wheel in the rail [mm]."""
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
        """Friction power at the rolling velocity of the patch [W]."""
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

    @property
    def loaded_half_width(self) -> float:
        """Half width [mm] of the Hertzian ellipse whose pressure has the same variance across the
        rail, at most `half_width`: of one ellipse it hardly depends on the elements.
        """
        by_row = self.solution.pressure.sum(axis=1)
        if not by_row.any():
            return 0.0
        part = by_row / by_row.sum()
        y = self.solution.grid.y
        dy = self.solution.grid.sides[1]
        variance = float(part @ (y - part @ y) ** 2) + dy**2 / 12
        # of Hertz's pressure over a half width b the variance is b^2/5
        return min(float(np.sqrt(5 * variance)), self.half_width)

    def plot(self) -> Figure:
        """Pressure, tractions and the section along x."""
        return self.solution.plot()


def forces_in_words(names: str, values: np.ndarray, errors: np.ndarray) -> str:
    """Forces [N] in kN, with their error bars."""
    pairs = zip(names.split(), values / 1e3, errors / 1e3, strict=True)
    return ", ".join(f"{name} = {with_bar(value, error)} kN" for name, value, error in pairs)
