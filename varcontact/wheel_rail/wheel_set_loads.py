"""Loads of a wheel set on a track: what is prescribed, what is free, and its wheels."""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from typing import Any, Self

from varcontact import checks
from varcontact.errors import SceneError
from varcontact.scene.friction import Coefficient
from varcontact.wheel_rail.regions import FrictionByAngle
from varcontact.wheel_rail.track import SIGN, Side
from varcontact.wheel_rail.wheel_geometry import OnTrack
from varcontact.wheel_rail.wheel_on_rail import WheelOnRail

Friction = Coefficient | FrictionByAngle
BALANCED = {
    "y": "lateral_force",
    "lateral": "lateral_force",
    "z": "vertical_force",
    "roll": "roll_moment",
    "yaw": "yaw_moment",
    "yaw_rate": "yaw_moment",
    "pitch_rate": "torque",
    "speed": "longitudinal_force",
}
"""Load that each free quantity balances."""
LOADS = ("lateral_force", "longitudinal_force", "roll_moment", "yaw_moment", "torque")


@dataclass(frozen=True, eq=False, kw_only=True)
class LoadedWheelSet(OnTrack, **dict.fromkeys(LOADS, checks.number)):
    """A wheel set under loads, as `WheelSetOnTrack` describes it, without its solution."""

    free: tuple[str, ...] = ("roll", "pitch_rate")
    lateral_force: float = 0.0
    longitudinal_force: float = 0.0
    roll_moment: float = 0.0
    yaw_moment: float = 0.0
    torque: float = 0.0
    friction: Friction | tuple[Friction, Friction] = 0.3

    def __post_init__(self) -> None:
        checks.exactly_one(vertical_force=self.vertical_force, z=self.z)
        super().__post_init__()
        allowed = [name for name in BALANCED if name != "z"]
        given: Any = self.free
        if not isinstance(given, tuple | list):
            raise SceneError("free", given, f"a tuple of names: {', '.join(allowed)}")
        object.__setattr__(
            self, "free", tuple(checks.choice("free", each, allowed) for each in given)
        )
        loads = [BALANCED[name] for name in self.free]
        for name, load in zip(self.free, loads, strict=True):
            if loads.count(load) > 1:
                raise SceneError(
                    "free",
                    self.free,
                    f"one quantity for each load: {name} is not alone with {load}",
                )
        if {"pitch_rate", "speed"} <= set(self.free):
            raise SceneError("free", self.free, "pitch_rate or speed: only their ratio counts")
        for name in LOADS:
            if getattr(self, name) != 0 and name not in loads:
                balancing = [each for each, load in BALANCED.items() if load == name]
                reason = (
                    f"{name}: nothing is free to balance it; add {' or '.join(balancing)} to free"
                )
                raise SceneError(name, getattr(self, name), message=reason)
        self._check_frictionless()

    def _check_frictionless(self) -> None:
        """Check the free quantities where friction is zero: only y and roll are determined, and a
        free pitch rate is that of free rolling.
        """
        # their entries are checked
        without = [self.wheel(side, 0.0).friction == 0 for side in SIGN]
        if any(without) and not set(self.free) <= {"y", "roll", "pitch_rate"}:
            allowed = "y, roll or pitch_rate: nothing else is determined where friction = 0"
            raise SceneError("free", self.free, allowed)
        if all(without):
            if self.torque != 0:
                raise SceneError(
                    "torque", self.torque, "0 where friction = 0: nothing else balances it"
                )
            object.__setattr__(
                self, "free", tuple(name for name in self.free if name != "pitch_rate")
            )

    @checks.named_options()
    def wheel(self, side: Side, z: float) -> WheelOnRail:
        """The wheel on a `side`, with the axle at a height `z` [mm]."""
        friction: Any = self.friction
        if isinstance(friction, tuple | list):
            if len(friction) != 2:
                raise SceneError(
                    "friction",
                    friction,
                    "one for both rails, or a pair for the left and the right one",
                )
            friction = friction[side == "right"]
        same: dict[str, Any] = {each.name: getattr(self, each.name) for each in fields(OnTrack)}
        return WheelOnRail(side=side, friction=friction, **{**same, "vertical_force": None, "z": z})

    def moved(self, values: dict[str, float]) -> Self:
        """The case with other `values` of positions and velocities, and of rails moved sideways and
        down, by name.
        """
        at = {name: values[name] for name in ("y", "roll", "yaw") if name in values}
        moving = {
            name: values[name]
            for name in ("lateral", "yaw_rate", "pitch_rate", "speed")
            if name in values
        }
        track = self.track
        for side in SIGN:
            if f"{side}_y" in values:
                rail = getattr(track, side)
                y = rail.y + values[f"{side}_y"]
                z = rail.z + values[f"{side}_z"]
                track = replace(track, **{side: replace(rail, y=y, z=z)})
        position = replace(self.position, **at)
        velocity = replace(self.velocity, **moving)
        return replace(self, track=track, position=position, velocity=velocity)
