"""From measured profiles and a moving wheel set to contact patches, creepages and forces.

Lengths are in millimetres, forces in newtons, stresses in N/mm^2, angles in radians, velocities in mm/s.
"""

from varcontact.wheel_rail.profile import Profile

__all__ = ["Profile"]
