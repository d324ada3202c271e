"""Rigid bodies that move against each other: distance, rigid slip, creepages
(paper, sections 1.1 to 1.5 and 2.2).

Positions and velocities are arrays of three components in one global frame, in
any consistent units.
"""

from varcontact.kinematics.discs import twin_discs
from varcontact.kinematics.rigid import (
    Creepages,
    Frame,
    RigidBody,
    creepages,
    distance,
    rigid_slip,
    rotation,
    spin_pole,
)
from varcontact.kinematics.wheel_set import WheelSetMotion, ball_between_planes, klingel_wavelength

__all__ = [
    "Creepages", "Frame", "RigidBody", "WheelSetMotion", "ball_between_planes", "creepages",
    "distance", "klingel_wavelength", "rigid_slip", "rotation", "spin_pole", "twin_discs"
]  # fmt: skip
