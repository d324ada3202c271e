"""What came out for a wheel on a rail."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from varcontact.results.solution import Solution

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from varcontact.wheel_rail.wheel_on_rail import ContactPatch, WheelOnRail


@dataclass(frozen=True, eq=False)
class PatchSolution:
    """A contact patch and its tractions, which act on the rail.

    Attributes
    ----------
    patch : ContactPatch
    solution : Solution
        Of the patch's scene, in mm and N.
    """

    patch: ContactPatch
    solution: Solution

    def __repr__(self) -> str:
        x, y, z = self.patch.location
        Fx, Fs, FN = self.force
        return (
            f"PatchSolution(location=({x:.4g}, {y:.6g}, {z:.4g}), angle={self.patch.angle:.4g}, "
            f"force=({Fx:.6g}, {Fs:.6g}, {FN:.6g}))"
        )

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
    def moment(self) -> float:
        """Moment on the rail about the normal at the frame's origin [N mm]."""
        return self.solution.moment

    @property
    def tilting(self) -> np.ndarray:
        """Moment of the pressure about x and y of the frame's origin, (Mx, My, 0) [N mm]."""
        grid, pressure = self.solution.grid, self.solution.pressure * self.solution.grid.area
        return np.array([pressure.sum(axis=1) @ grid.y, -pressure.sum(axis=0) @ grid.x, 0.0])

    @property
    def peak_pressure(self) -> float:
        """[N/mm^2]"""
        return float(self.solution.pressure.max())

    @property
    def half_width(self) -> float:
        """Half the width of the contact across the rail [mm]."""
        rows = np.flatnonzero(self.solution.pressure.max(axis=1) > 0)
        return float(rows[-1] - rows[0] + 1) * self.solution.grid.sides[1] / 2 if rows.size else 0.0

    def plot(self) -> Figure:
        """Pressure, tractions and the section along x.

        Returns
        -------
        Figure
        """
        return self.solution.plot()


@dataclass(frozen=True, eq=False)
class WheelRailSolution:
    """All patches of a wheel on a rail, solved.

    Attributes
    ----------
    case : WheelOnRail
    z : float
        Height of the axle, downwards [mm].
    patches : tuple of PatchSolution
        From left to right.
    rounds : int
        Heights that were tried; 0 where it was given.
    """

    case: WheelOnRail
    z: float
    patches: tuple[PatchSolution, ...]
    rounds: int

    def __repr__(self) -> str:
        Fx, Fy, Fz = self.force
        return (
            f"WheelRailSolution({self.case.side} wheel, {len(self.patches)} patch{'es' * (len(self.patches) > 1)}, "
            f"force=({Fx:.6g}, {Fy:.6g}, {Fz:.6g}), z={self.z:.6g})"
        )

    @property
    def force(self) -> np.ndarray:
        """(Fx, Fy, Fz) on the rail in track coordinates, of all patches [N]."""
        return np.sum([each.force_on_track for each in self.patches], axis=0)

    @property
    def force_on_wheelset(self) -> np.ndarray:
        """Force on the wheel along the axes of the wheel set [N]."""
        return np.asarray(-self.case.position.rotation.T @ self.force)

    @property
    def moment_on_wheelset(self) -> np.ndarray:
        """Moment on the wheel about the middle of the axle, along the axes of the wheel set [N mm]."""
        centre = np.array([0.0, self.case.position.y, self.z - self.case.wheelset.radius])
        total = np.zeros(3)
        for each in self.patches:
            about_normal = each.patch.frame.normal * each.moment
            pressed = each.patch.frame.axes @ each.tilting
            total -= np.cross(each.patch.location - centre, each.force_on_track) + about_normal + pressed
        return np.asarray(self.case.position.rotation.T @ total)

    def plot(self) -> Figure:
        """Both profiles with the patches at their place, and the tractions of each patch.

        Returns
        -------
        Figure
        """
        from varcontact.wheel_rail.pictures import plot_wheel_on_rail

        return plot_wheel_on_rail(self)
