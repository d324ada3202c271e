"""The surfaces of a pin in a hole: line contact that curves along the rolling direction."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np

from varcontact.checks import Checked, at_least_zero, positive
from varcontact.errors import SceneError
from varcontact.scene.frames import frames_of_elements
from varcontact.scene.grid import Grid

DEPTH = 4.0
"""Default reference depth of displacements, in radii of the pin."""

DEPTH_MIN = 3.0
"""Least reference depth, in radii of the pin: from there on stored energies are positive for any
bodies."""


CLEARANCE_MAX = 0.1
"""Largest clearance, in radii of the pin: displacements and clearances must be small compared with
the radius."""


@dataclass(frozen=True)
class PinInHole(
    Checked, path="surface", R=positive, clearance=at_least_zero, reference_depth=positive
):
    """Line contact of a pin, body 1, in the hole of body 2, in plane strain:
    forces per unit length.

    The contact may reach round nearly half of the pin: influence numbers are
    those of a disc and of an infinite plate with a round hole. x is the length
    of the arc of the pin from its lowest point, pressure and tractions act
    along the normals and tangents of the arc, and forces are along the axes at
    its lowest point. The load is carried by the centre of the pin, which moves
    along z.

    Parameters
    ----------
    R : float
        Radius of the pin [length], positive and finite.
    clearance : float
        Radius of the hole less that of the pin [length], up to a tenth of R; 0
        is a neat fit.
    reference_depth : float, optional
        Displacements count from the points at this distance from a line load
        [length], at least 3 R; 4 R if not given. It sets the level of
        approaches and shifts, and how far a tangential force moves the pin
        sideways.

    Raises
    ------
    SceneError
        For numbers out of range.

    Examples
    --------
    >>> import varcontact as vc
    >>> scene = vc.Scene(
    ...     bodies=vc.Bodies(G=80e9, nu=0.3), surface=PinInHole(R=0.010, clearance=5e-6),
    ...     normal_force=1e6)
    >>> solution = vc.solve(scene)
    >>> angles = np.degrees(solution.grid.x[solution.pressure[0] > 0] / 0.010)
    >>> print(f"{angles.max():.0f} degrees either way, {solution.max_pressure / 1e6:.0f} MPa")
    59 degrees either way, 72 MPa
    """

    R: float
    clearance: float
    reference_depth: float | None = None
    line: ClassVar[bool] = True

    def __post_init__(self) -> None:
        super().__post_init__()
        depth = self.reference_depth
        if depth is not None and depth < DEPTH_MIN * self.R:
            allowed = f"at least {DEPTH_MIN:g} R, {DEPTH_MIN * self.R:.6g}"
            raise SceneError("surface.reference_depth", depth, allowed)

    @property
    def depth(self) -> float:
        """Distance from a line load to the points from which displacements count."""
        return self.reference_depth or DEPTH * self.R

    def distance(self, grid: Grid) -> np.ndarray:
        """Undeformed distance (1, nx) along the normals, at the centres of the elements of an
        explicit `grid`, of bodies that touch at the lowest point [length].
        """
        # 1 - cos
        return (2 * self.clearance * np.sin(grid.x / (2 * self.R)) ** 2)[None, :]

    def lowered(self, approach: float) -> PinInHole:
        """Copy whose distance less a uniform `approach` is that of this surface with the pin moved
        along z by it: less by ``approach cos(angle)``.
        """
        return replace(self, clearance=self.clearance + approach)

    def frames(self, grid: Grid) -> np.ndarray:
        """Rotations (3, 3, 1, nx) from the axes of the elements of a `grid` to those at the lowest
        point.
        """
        return frames_of_elements(np.zeros(1), grid.x / self.R)
