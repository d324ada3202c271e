"""Forces, creepages and pressure without dimension."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from varcontact.results.solution import Solution


@dataclass(frozen=True)
class Normalised:
    """What a solution has, without dimension, so that contacts of all sizes and loads fall on the same curves.

    With the friction limit ``L = sum(f pz) dx dy`` (of bodies that do not slip, or without friction, the normal force),
    ``c = sqrt(a b)`` of Hertz's ellipse (of other contacts ``c^2`` is their area by pi; in line contact c is half
    their width), and the combined modulus of rigidity G.

    Attributes
    ----------
    Fx, Fy : float
        Tangential force / L.
    Mz : float
        Twisting moment / (L c).
    vx, vy : float
        Creepage * G c^2 / L (line contact: G c / L). Small ones give ``Fx = -C11 vx``, with Kalker's coefficient of
        the creepage. Of a shift: u G c / L (line contact: u G / L).
    spin : float
        Spin * G c^3 / L (line contact: G c^2 / L); small ones give ``Fy = -C23 spin``. Of a shift: rotation * G c^2 / L
        (line contact: G c / L).
    max_pressure : float
        Largest / mean pressure in the contact: 3/2 of an ellipse of Hertz, 4/pi of a line.
    """

    Fx: float
    Fy: float
    Mz: float
    vx: float
    vy: float
    spin: float
    max_pressure: float


def normalised(sol: Solution) -> Normalised:
    """See `Solution.normalised`."""
    limit = float(sol.traction_bound.sum() * sol.grid.area)
    if not 0 < limit < math.inf:
        limit = sol.normal_force
    lattice, contact = sol.contact
    line, area = sol.scene.line, float(contact.sum()) * lattice.area
    hertz = sol.scene.hertz
    if hertz is not None:
        size, area = (hertz.a, 2 * hertz.a) if line else (math.sqrt(hertz.a * hertz.b), math.pi * hertz.a * hertz.b)
    else:
        size = area / 2 if line else math.sqrt(area / math.pi)
    if limit == 0 or area == 0:  # no contact
        return Normalised(*7 * (math.nan,))
    powers = (1 if line else 2) - (1 if sol.motion is not None and sol.motion.rolls == 0 else 0)
    stiffness = sol.scene.bodies.combined_G * size**powers / limit
    return Normalised(
        Fx=sol.Fx / limit,
        Fy=sol.Fy / limit,
        Mz=sol.Mz / (limit * size),
        vx=sol.vx * stiffness,
        vy=sol.vy * stiffness,
        spin=sol.spin * size * stiffness,
        max_pressure=sol.max_pressure * area / sol.normal_force,
    )
