"""From measured profiles and a moving wheel set to contact patches, creepages and forces.

Lengths are in millimetres, forces in newtons, stresses in N/mm^2, angles in radians, velocities in mm/s.
"""

from varcontact.wheel_rail.conicity import equivalent_conicity, rolling_radius_difference
from varcontact.wheel_rail.contact_input import read_contact_input
from varcontact.wheel_rail.fast import FastPatch, FastWheel
from varcontact.wheel_rail.geometry_table import GeometryTable, WheelSetForces, geometry_table
from varcontact.wheel_rail.profile import Profile
from varcontact.wheel_rail.result import PatchSolution, WheelRailSolution
from varcontact.wheel_rail.rough import RoughProfile
from varcontact.wheel_rail.solve import CoarseElements, ConformalContact
from varcontact.wheel_rail.track import Position, Track, Velocity, WheelSet
from varcontact.wheel_rail.wear import Archard, PatchWear, Wear, wear
from varcontact.wheel_rail.wheel_on_rail import ContactPatch, WheelOnRail

__all__ = [
    "Archard",
    "CoarseElements",
    "ConformalContact",
    "ContactPatch",
    "FastPatch",
    "FastWheel",
    "GeometryTable",
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
    "equivalent_conicity",
    "geometry_table",
    "read_contact_input",
    "rolling_radius_difference",
    "wear",
]
