"""From measured profiles and a moving wheel set to contact patches, creepages and forces.

Lengths are in millimetres, forces in newtons, stresses in N/mm^2, angles in radians, velocities in mm/s.
"""

from varcontact.wheel_rail.contact_input import read_contact_input
from varcontact.wheel_rail.geometry_table import (
    GeometryTable,
    WheelSetForces,
    equivalent_conicity,
    geometry_table,
    rolling_radius_difference,
)
from varcontact.wheel_rail.profile import Profile
from varcontact.wheel_rail.result import Archard, PatchSolution, PatchWear, Wear, WheelRailSolution, wear
from varcontact.wheel_rail.solve import CoarseElements, ConformalContact, RoughProfile
from varcontact.wheel_rail.track import Irregularity, Position, Track, Velocity, WheelSet
from varcontact.wheel_rail.virtual_penetration import FastPatch, FastWheel
from varcontact.wheel_rail.wheel_on_rail import ContactPatch, WheelOnRail
from varcontact.wheel_rail.wheel_set import WheelSetOnTrack
from varcontact.wheel_rail.wheel_set_solution import WheelSetSolution

__all__ = [
    "Archard",
    "CoarseElements",
    "ConformalContact",
    "ContactPatch",
    "FastPatch",
    "FastWheel",
    "GeometryTable",
    "Irregularity",
    "PatchSolution",
    "PatchWear",
    "Position",
    "Profile",
    "RoughProfile",
    "Track",
    "Velocity",
    "Wear",
    "WheelOnRail",
    "WheelRailSolution",
    "WheelSet",
    "WheelSetForces",
    "WheelSetOnTrack",
    "WheelSetSolution",
    "equivalent_conicity",
    "geometry_table",
    "read_contact_input",
    "rolling_radius_difference",
    "wear",
]
