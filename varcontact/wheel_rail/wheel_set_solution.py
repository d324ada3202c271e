"""Solutions of a wheel set on a track: total forces, derailment ratios, and the stiffness by which
it is centred.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from varcontact import checks
from varcontact.html import Reported
from varcontact.results.error_estimate import with_bar
from varcontact.wheel_rail.equilibrium_search import (
    ROUGH,
    FastTheories,
    Search,
    balanced_wheels,
    warn_unbalanced,
)
from varcontact.wheel_rail.patch_solution import forces_in_words
from varcontact.wheel_rail.plausibility import warnings_of
from varcontact.wheel_rail.position import Position, Velocity
from varcontact.wheel_rail.profile_shape import flange
from varcontact.wheel_rail.result import WheelForces, WheelRailSolution
from varcontact.wheel_rail.track import SIGN, Side, Track, WheelSet
from varcontact.wheel_rail.wear_laws import Archard, ArchardMap
from varcontact.wheel_rail.wheel_set_loads import LoadedWheelSet

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

BESIDE = 0.05
"""Displacement to either side for the difference in the gravitational stiffness [mm]."""
FAST_TOL = 1e-6
"""Largest imbalance of an estimate without a warning."""
FACE = 0.1
"""Distance of the points of the flange's face at which its angle is taken [mm]."""


@dataclass(frozen=True, eq=False)
class WheelSetSolution(Reported, WheelForces):
    """Both wheels with all patches, where the loads are balanced.

    Attributes
    ----------
    case : WheelSetOnTrack
    z : float
        Height of the axle, downwards [mm].
    patches : tuple of PatchSolution or FastPatch
        From left to right.
    left, right : WheelRailSolution or FastWheel
        The wheels, in the position, velocity and track that were found.
    imbalance : float
        Largest one of the loads, see `WheelSetOnTrack.solve`.
    solved : int
        Number of exact solves of both wheels.
    errors : dict
        Estimated error of each free quantity, by its name: NaN where it was not
        estimated.
    """

    case: LoadedWheelSet
    left: WheelForces
    right: WheelForces
    imbalance: float
    solved: int
    errors: dict[str, float]

    def __repr__(self) -> str:
        Fx, Fy, Fz = self.force
        at = self.position
        return (
            f"WheelSetSolution(y={at.y:.4g}, roll={at.roll:.4g}, yaw={at.yaw:.4g}, z={self.z:.6g}, "
            f"force=({Fx:.6g}, {Fy:.6g}, {Fz:.6g}))"
        )

    @property
    def wheels(self) -> tuple[WheelForces, WheelForces]:
        """Left and right."""
        return self.left, self.right

    def quantities(
        self,
        archard: Archard | ArchardMap | None = None,
        yield_in_shear: float | None = None,
    ) -> list[dict[str, float]]:
        """See `WheelRailSolution.quantities`, with `archard` for wear and `yield_in_shear` for the
        shakedown limit; patches of the left wheel come first.
        """
        left = self.left.quantities(archard, yield_in_shear)
        return [*left, *self.right.quantities(archard, yield_in_shear)]

    def to_xarray(
        self,
        archard: Archard | ArchardMap | None = None,
        yield_in_shear: float | None = None,
    ) -> xr.Dataset:
        """Quantities over side and patch, those of wheels over side, those of the axle without
        dimension, with units; `archard` and `yield_in_shear` as of `quantities`.
        """
        from varcontact.wheel_rail.datasets import wheels_dataset

        return wheels_dataset(self, archard, yield_in_shear, of_sets=True)

    @property
    def warnings(self) -> tuple[str, ...]:
        """Warnings of the wheel set and of its wheels, each once."""
        texts = [text for each in self.wheels for text in each.warnings]
        return tuple(dict.fromkeys([*warnings_of(self.case), *texts]))

    @property
    def position(self) -> Position:
        """Place of the middle of the axle."""
        return self.left.case.position

    @property
    def velocity(self) -> Velocity:
        """Velocities of the middle of the axle."""
        return self.left.case.velocity

    @property
    def track(self) -> Track:
        """Track with the rails as displaced by the loads."""
        return replace(
            self.case.track, left=self.left.case.track.left, right=self.right.case.track.right
        )

    @property
    def error(self) -> np.ndarray:
        """Estimated errors of `force` against the continuum [N]: 0 where a load balances it, NaN if
        not estimated.
        """
        if not isinstance(self.left, WheelRailSolution) or not isinstance(
            self.right, WheelRailSolution
        ):
            return np.full(3, np.nan)
        free = self.case.free
        balanced = [
            "speed" in free,
            "y" in free or "lateral" in free,
            self.case.vertical_force is not None,
        ]
        return np.where(balanced, 0.0, self.left.error + self.right.error)

    @property
    def steering_moment(self) -> float:
        """Yaw moment of the longitudinal forces on the wheel set, positive to the right [N mm]."""
        return sum(
            float(each.force_on_track[0]) * (each.frame.origin[1] - self.position.y)
            for each in self.patches
        )

    @property
    def power(self) -> float:
        """Friction power of all patches [W]; NaN by a theory that has no moment."""
        return sum(each.friction_power for each in self.patches)

    @checks.named_options()
    def y_over_q(self, side: Side) -> float:
        """Lateral by vertical force of the wheel on a `side`, positive where it pushes its rail
        outwards [-].
        """
        force = getattr(self, side).force
        return float(SIGN[side] * force[1] / force[2])

    @checks.named_options()
    def nadal(self, side: Side) -> float:
        """Y/Q by Nadal's limit, ``(tan d - f)/(1 + f tan d)``, on a `side`.

        d is the greatest angle of the flange's face, between its tip and the tread. NaN of a wheel
        without a flange. M. J. Nadal, Annales des Mines 10 (1896) 232.
        """
        wheel = getattr(self, side).case
        steepest = _flange_angle(wheel.wheelset)
        f = wheel.friction_at(-SIGN[side] * steepest)
        slope = np.tan(steepest)
        return float(self.y_over_q(side) * (1 + f * slope) / (slope - f))

    def gravitational_stiffness(self) -> float:
        """Lateral force of the normal forces by displacement, by which the load centres the wheel
        set [N/mm].

        From the fast way without friction, beside the position that was found, with the same
        vertical force.
        """
        free: dict[str, Any] = dict.fromkeys(
            ("lateral_force", "longitudinal_force", "yaw_moment", "torque"), 0.0
        )
        free |= {
            "free": ("roll",),
            "friction": 0.0,
            "z": None,
            "vertical_force": float(self.force[2]),
        }
        case = replace(self.case, track=self.track, **free)
        places = [
            replace(self.position, y=self.position.y + beside) for beside in (-BESIDE, BESIDE)
        ]
        left, right = (_lateral_force(replace(case, position=at)) for at in places)
        return (right - left) / (2 * BESIDE)

    def report(self) -> str:
        """Positions, forces and ratios in words, with their errors where they were estimated."""
        at, moving = self.position, self.velocity
        values = {
            "y": at.y,
            "roll": at.roll,
            "yaw": at.yaw,
            "lateral": moving.lateral,
            "yaw_rate": moving.yaw_rate,
        }
        values |= {"z": self.z, "pitch_rate": moving.pitch_rate or 0.0, "speed": moving.speed}
        unknowns = [
            f"{name} = {with_bar(values[name], each)}"
            for name, each in self.errors.items()
            if name in values
        ]
        lines = [
            f"wheel set, y = {at.y:.6g} mm, roll = {at.roll:.4g}, yaw = {at.yaw:.4g}, "
            f"z = {self.z:.6g} mm"
        ]
        if unknowns:
            lines.append(f"found: {', '.join(unknowns)}")
        lines.append(f"forces on the rails: {forces_in_words('Fx Fy Fz', self.force, self.error)}")
        for side in SIGN:
            wheel = getattr(self, side)
            if isinstance(wheel, WheelRailSolution):
                lines += wheel.report().splitlines()
            else:
                lines.append(repr(wheel))
            lines.append(f"{side}: Y/Q = {self.y_over_q(side):.4g}")
        return "\n".join(lines)

    def plot(self) -> Figure:
        """Both wheels on their rails, and the patches at their place."""
        from varcontact.wheel_rail.plots import plot_wheel_set

        return plot_wheel_set(self)


def _lateral_force(case: LoadedWheelSet) -> float:
    """Fy of both wheels on the rails by the fast way [N]."""
    fast = FastTheories()
    balance, x = Search(case, fast, ROUGH).found()
    left, right = balanced_wheels(balance, x, fast)
    imbalance = np.abs(balance.imbalance((left, right))).max(initial=0.0)
    warn_unbalanced(float(imbalance), FAST_TOL)
    patches = left.patches + right.patches
    return float(np.sum([each.force_on_track for each in patches], axis=0)[1])


def _flange_angle(wheelset: WheelSet) -> float:
    """Greatest angle of a wheel's face from the flange's tip to the running circle [rad], NaN if it
    has no flange.
    """
    curve = wheelset.profile.running
    s = curve.sampled(FACE)
    y, z = curve.points(s).T
    if flange(y, z) >= 0:
        return math.nan
    face = s[z.argmax() : np.searchsorted(y, wheelset.running_circle) + 1]
    return float(-curve.angles(face).min())
