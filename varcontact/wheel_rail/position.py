"""Position and velocity of a wheel set in track coordinates: x forward, y to the right, z down
[mm, rad, s].
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from varcontact import checks
from varcontact.errors import SceneError
from varcontact.kinematics import RigidBody, rotation
from varcontact.system.process import changed, lazy_property

if TYPE_CHECKING:
    from varcontact.wheel_rail.track import WheelSet

PLACES = ("y", "s", "pitch")
RATES = ("pitch_rate", "lateral", "vertical", "roll_rate", "yaw_rate")
AT_REST = RigidBody(position=np.zeros(3))
STEEPEST = 0.5
"""Largest angle of cant, roll and yaw [rad]."""


def angle(field: str, value: Any) -> float:
    """A small angle, checked."""
    angle = checks.number(field, value)
    if abs(angle) > STEEPEST:
        raise SceneError(field, angle, f"an angle in radians, within {STEEPEST} of 0")
    return angle


@dataclass(frozen=True, kw_only=True)
class Position(
    checks.Checked, path="position", roll=angle, yaw=angle, **dict.fromkeys(PLACES, checks.number)
):
    """Place of a wheel set in the track, but for its height.

    Parameters
    ----------
    y : float
        Lateral position of the middle of its axle, to the right [mm].
    roll, yaw : float
        About x (right wheel down) and z (turned to the right) [rad]: yawed
        first, then rolled about the track's x.
    s : float
        Along the track: where rails vary, see `ProfileSlices` [mm].
    pitch : float
        Angle about the axle, where wheels are out of round: negative when they
        have rolled forwards [rad].

    Raises
    ------
    SceneError
        If a number is not finite, or an angle is more than half a radian.
    """

    _words: ClassVar = {"z": "z, or vertical_force, of WheelOnRail", "lateral": "y"}
    y: float = 0.0
    roll: float = 0.0
    yaw: float = 0.0
    s: float = 0.0
    pitch: float = 0.0

    @lazy_property
    def rotation(self) -> np.ndarray:
        """The axle's axes in track coordinates, shape (3, 3)."""
        return rotation(roll=self.roll, yaw=self.yaw)


@dataclass(frozen=True, kw_only=True)
class Velocity(
    checks.Checked,
    path="velocity",
    speed=checks.at_least_zero,
    **dict.fromkeys(RATES, checks.number),
):
    """Velocities of a wheel set.

    Parameters
    ----------
    speed : float
        Along the track [mm/s]. Creepages depend only on the ratios of
        velocities to it; 0 in shifts alone, see `wheel_on_rail_history`.
    pitch_rate : float, optional
        About the axle [rad/s], negative in rolling forward, 0 of a locked
        wheel; -speed by the nominal radius if not given.
    lateral, vertical : float
        Velocities of the middle of the axle [mm/s].
    roll_rate, yaw_rate : float
        [rad/s]

    Raises
    ------
    SceneError
        If a number is not finite, the speed is negative, or the pitch rate is
        positive.
    """

    _words: ClassVar = {
        "vx": "speed",
        "vy": "lateral",
        "vz": "vertical",
        "pitch": "pitch_rate",
        "yaw": "yaw_rate",
    }
    speed: float = 1000.0
    pitch_rate: float | None = None
    lateral: float = 0.0
    vertical: float = 0.0
    roll_rate: float = 0.0
    yaw_rate: float = 0.0

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.pitch_rate is not None and self.pitch_rate > 0:
            allowed = (
                "zero or negative: negative in rolling forward, "
                "-speed by the radius in pure rolling"
            )
            raise SceneError("velocity.pitch_rate", self.pitch_rate, allowed)

    def body(
        self,
        wheelset: WheelSet,
        position: Position,
        z: float,
        *,
        pitching: bool = True,
        curve_radius: float = np.inf,
    ) -> RigidBody:
        """The `wheelset` at a `position` as a rigid body in track coordinates.

        Parameters
        ----------
        z : float
            Height of the axle, downwards: at 0 the nominal circles are at the
            height of the rail tops [mm].
        pitching : bool
            Whether it turns about its axle; without, it moves as the contacts
            do.
        curve_radius : float
            Curve radius of the track, with which the wheel set turns as it rolls [mm].
        """
        turning = turning_with_track(self, position, curve_radius)
        if pitching:
            pitch = self.pitch_rate
            if pitch is None:
                pitch = -self.speed / wheelset.radius
            turning = turning + position.rotation @ [0.0, pitch, 0.0]
        return changed(
            AT_REST,
            position=np.array([0.0, position.y, z - wheelset.radius]),
            rotation=position.rotation,
            velocity=np.array([self.speed, self.lateral, self.vertical]),
            angular_velocity=turning,
        )


def turning_with_track(velocity: Velocity, position: Position, curve_radius: float) -> np.ndarray:
    """Angular velocity of a wheel set that does not turn about its axle, in track coordinates
    [rad/s].
    """
    upright = np.array([0.0, -np.sin(position.roll), np.cos(position.roll)])
    turning = np.array([velocity.roll_rate, 0.0, velocity.speed / curve_radius])
    return np.asarray(turning + velocity.yaw_rate * upright)


def check_forward(rolling: float) -> None:
    """Refuse a wheel whose rolling velocity [mm/s] is not positive."""
    if not rolling > 0:
        reason = (
            f"velocity: a wheel does not roll forwards, its rolling velocity is {rolling:.6g} mm/s"
        )
        raise SceneError("velocity", rolling, message=reason)
