"""Wheels on rails: from measured profiles and a moving wheel set to contact patches, creepages and
forces.

Lengths are in millimetres, forces in newtons, stresses in N/mm^2, angles in
radians, velocities in mm/s.
"""

from varcontact.errors import DoubtfulProfile
from varcontact.wheel_rail.contact_input import read_contact_input
from varcontact.wheel_rail.damage import JohnsonDiagram, johnson_diagram, wear_down, worn_profile
from varcontact.wheel_rail.geometry_table import (
    GeometryTable,
    WheelSetForces,
    equivalent_conicity,
    geometry_table,
    rolling_radius_difference,
)
from varcontact.wheel_rail.history import wheel_on_rail_history
from varcontact.wheel_rail.patch_solution import PatchSolution
from varcontact.wheel_rail.patch_warnings import CoarseElements, ConformalContact, RoughProfile
from varcontact.wheel_rail.position import Position, Velocity
from varcontact.wheel_rail.profile import Profile
from varcontact.wheel_rail.profile_dimensions import (
    FlangeClearance,
    FlangeDimensions,
    RailWear,
    flange_clearance,
    flange_dimensions,
    rail_wear,
)
from varcontact.wheel_rail.regions import FrictionByAngle
from varcontact.wheel_rail.result import WheelRailSolution, wear
from varcontact.wheel_rail.slices import ProfileSlices
from varcontact.wheel_rail.sweep import sweep_wheel_sets
from varcontact.wheel_rail.track import Irregularity, Track, WheelSet
from varcontact.wheel_rail.virtual_penetration import FastPatch, FastWheel
from varcontact.wheel_rail.wear_depth import PatchWear, Wear
from varcontact.wheel_rail.wear_laws import (
    Archard,
    ArchardMap,
    british_rail_wear,
    fatigue_damage,
    sheffield_wear,
)
from varcontact.wheel_rail.wheel_geometry import ContactPatch
from varcontact.wheel_rail.wheel_on_rail import WheelOnRail
from varcontact.wheel_rail.wheel_set import WheelSetOnTrack
from varcontact.wheel_rail.wheel_set_solution import WheelSetSolution

Shakedown = JohnsonDiagram
shakedown = johnson_diagram
"""Earlier names of Johnson's diagram; `varcontact.shakedown` bounds the limit itself."""

__all__ = [
    "Archard",
    "ArchardMap",
    "CoarseElements",
    "ConformalContact",
    "ContactPatch",
    "DoubtfulProfile",
    "FastPatch",
    "FastWheel",
    "FlangeClearance",
    "FlangeDimensions",
    "FrictionByAngle",
    "GeometryTable",
    "Irregularity",
    "JohnsonDiagram",
    "PatchSolution",
    "PatchWear",
    "Position",
    "Profile",
    "ProfileSlices",
    "RailWear",
    "RoughProfile",
    "Shakedown",
    "Track",
    "Velocity",
    "Wear",
    "WheelOnRail",
    "WheelRailSolution",
    "WheelSet",
    "WheelSetForces",
    "WheelSetOnTrack",
    "WheelSetSolution",
    "british_rail_wear",
    "equivalent_conicity",
    "fatigue_damage",
    "flange_clearance",
    "flange_dimensions",
    "geometry_table",
    "johnson_diagram",
    "rail_wear",
    "read_contact_input",
    "rolling_radius_difference",
    "shakedown",
    "sheffield_wear",
    "sweep_wheel_sets",
    "wear",
    "wear_down",
    "wheel_on_rail_history",
    "worn_profile",
]
