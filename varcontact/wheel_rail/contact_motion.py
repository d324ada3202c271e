"""Velocities, given forces and springs of the wheels of an input file of CONTACT."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from varcontact.io.contact_cases import CaseInput
from varcontact.io.contact_grammar import Controls
from varcontact.io.contact_words import Group, located
from varcontact.wheel_rail.contact_cases import RailSprings
from varcontact.wheel_rail.position import Position, Velocity
from varcontact.wheel_rail.track import SIGN, Side, WheelSet

SHIFT = 1
"""Value of the digit T for a shift without rolling."""


def check_forces(controls: Controls) -> None:
    """Refuse forces that no motion can give."""
    if controls["TANG"] == 0:
        controls.complain("FORCE", "needs friction, T = 3")
    if controls["FORCE"] in (1, 2):
        if controls["NORM"] == 0:
            controls.complain("FORCE", "needs the vertical force, N = 1")
        if controls["TANG"] == SHIFT:
            controls.complain("FORCE", "needs rolling, T = 2 or 3")


def velocity_of(case: CaseInput) -> Velocity:
    """Velocities of the wheel set, or of the roller's top below it."""
    group: Group = case.needs("velocity", "EWHEEL", "a velocity", "E = 3")
    _, lateral, vertical = (group.number(k) for k in range(3))
    speed = group.angle(0)
    if case.controls["CONFIG"] >= 4:  # speed of the roller's top, with which the coordinates move
        speed *= case.entries["track"].number(3)
    roll_rate = group.angle(3)
    yaw_rate = group.angle(4)
    pitch_rate = None
    if group.names[5] == "VPITCH":
        pitch_rate = group.angle(5)
    given = {1: "FX", 2: "MY"}.get(case.controls["FORCE"], "VPITCH")
    if group.names[5] != given:
        case.controls.complain("FORCE", f"needs a velocity with {given}: use E = 2")
    with located(group):
        return Velocity(
            speed=speed,
            lateral=lateral,
            vertical=vertical,
            roll_rate=roll_rate,
            yaw_rate=yaw_rate,
            pitch_rate=pitch_rate,
        )


def moved_to_wheel(
    case: CaseInput, position: Position, velocity: Velocity, wheelset: WheelSet, side: Side
) -> tuple[Position, Velocity, float]:
    """Position and motion of a rigid wheel set with the wheel at the place of the flexible one's,
    and how much lower it is; for small deviations.
    """
    place: Group = case.entries["wheel place"]
    rates: Group = case.entries["wheel rates"]
    arm = SIGN[side] * wheelset.middle
    roll, yaw, pitch = (place.angle(k) for k in range(3, 6))
    roll_rate, yaw_rate, pitch_rate = (rates.angle(k) for k in range(3, 6))
    with located(place):
        moved = replace(
            position,
            s=position.s + place.number(0) + arm * yaw,
            y=position.y + place.number(1),
            roll=position.roll + roll,
            yaw=position.yaw + yaw,
            pitch=position.pitch + pitch,
        )
    turning = velocity.pitch_rate
    if turning is not None:
        turning += pitch_rate
    with located(rates):
        moving = replace(
            velocity,
            speed=velocity.speed + rates.number(0) + arm * yaw_rate,
            lateral=velocity.lateral + rates.number(1),
            vertical=velocity.vertical + rates.number(2) - arm * roll_rate,
            roll_rate=velocity.roll_rate + roll_rate,
            yaw_rate=velocity.yaw_rate + yaw_rate,
            pitch_rate=turning,
        )
    return moved, moving, place.number(2) - arm * roll


def forces_of(case: CaseInput) -> dict[str, Any]:
    """Force, moment or springs that F = 1, 2 or 3 prescribes instead of the motion of the wheel or
    the place of the rail.
    """
    force = case.controls["FORCE"]
    if force in (1, 2):
        given = {1: "longitudinal_force", 2: "axle_moment"}[force]
        return {given: case.entries["velocity"].number(5)}
    if force == 3:
        return {"springs": _springs(case)}
    return {}


def _springs(case: CaseInput) -> RailSprings:
    """The springs of F = 3."""
    group: Group = case.needs("springs", "FORCE", "the springs of a rail", "Z = 3")
    lateral, sideways, vertical, down = group.numbers()
    if lateral < 0 or vertical < 0:
        group.refuse("KYRAIL, KZRAIL", (lateral, vertical), "is negative")
    if vertical == 0 and case.controls["NORM"] == 0:
        group.refuse("KZRAIL", vertical, "is zero, and the height of the wheel set is given")
    return RailSprings((lateral, vertical), (sideways, down))
