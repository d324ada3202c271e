"""What defect correction found beside a coarse solution: the field on parts of its elements.

Files of earlier versions have it of shifts, too (slips and corrections are lengths then), and of steps of histories
(corrections then have what the particles bring along).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from varcontact.scene.grid import Grid


@dataclass(frozen=True, eq=False)
class Refinement:
    """A field on parts of the elements, near the continuum's (docs/refinement.md). In the scene's units.

    Attributes
    ----------
    kind : str
        What was asked for: "continuum".
    grid : Grid
        The parts of the elements, explicit.
    traction : ndarray, shape (2, ny, nx)
        On body 1, on the parts [force/area].
    slip : ndarray, shape (2, ny, nx)
        The continuum's slip under it by rolling velocity [-], means over the parts; zero outside the contact.
    correction : ndarray
        What was added to the rigid slip of the coarse elements, (2, ny, nx) of the coarse grid, in the unit of slip.
        The solution's fields and its certificate are those of the coarse problem with this correction.
    share : ndarray, shape (ny, nx)
        What the traction bound of the coarse elements was multiplied by [-]; one, but in files of earlier versions.
    forces : ndarray, shape (passes + 1, 3)
        Fx, Fy and Mz: of the coarse elements without correction, then of the field after each pass.
    creepages : ndarray, shape (passes + 1, 2)
        vx and vy then: as given, or found for the forces that are given.
    estimate : ndarray, shape (3,)
        Estimated error of the last Fx, Fy and Mz: how much they differ from those on half as many elements each way,
        what late passes changed or left out, or how far they are from those prescribed, whichever is most. Fx and Fy
        have the same, of the vector. No bound.
    creepage_estimate : ndarray, shape (2,)
        The same of vx and vy [-]; zero where they are given.
    seconds : tuple of float
        Of each pass.
    """

    kind: str
    grid: Grid
    traction: np.ndarray
    slip: np.ndarray
    correction: np.ndarray
    share: np.ndarray
    forces: np.ndarray
    creepages: np.ndarray
    estimate: np.ndarray
    creepage_estimate: np.ndarray
    seconds: tuple[float, ...]

    @property
    def passes(self) -> int:
        """Number of passes."""
        return len(self.forces) - 1

    @property
    def cells(self) -> tuple[int, int]:
        """Parts of an element along y and x."""
        (ny, nx), (rows, columns) = self.grid.shape, self.correction.shape[1:]
        return ny // rows, nx // columns

    @property
    def force(self) -> np.ndarray:
        """Total tangential force (Fx, Fy) of the field."""
        return self.forces[-1, :2].copy()

    @property
    def moment(self) -> float:
        """Twisting moment Mz of the field about the origin."""
        return float(self.forces[-1, 2])

    @property
    def change(self) -> np.ndarray:
        """Change of Fx, Fy and Mz by the last pass, absolute, (3,)."""
        return np.abs(self.forces[-1] - self.forces[-2])

    @property
    def power_density(self) -> np.ndarray:
        """Work lost by friction by area, ``-p.s``: by distance rolled [force/area]."""
        return np.asarray(0.0 - np.sum(self.traction * self.slip, axis=0))

    @property
    def friction_work(self) -> float:
        """Work lost by friction in the field, by distance rolled [force]."""
        return float(np.sum(self.power_density) * self.grid.area)

    def summary(self) -> dict[str, Any]:
        """Forces by pass, change and estimate as plain numbers."""
        return {
            "kind": self.kind,
            "parts": list(self.cells),
            "passes": self.passes,
            "forces": self.forces.tolist(),
            "creepages": self.creepages.tolist(),
            "change": self.change.tolist(),
            "error_estimate": self.estimate.tolist(),
            "creepage_estimate": self.creepage_estimate.tolist(),
            "seconds": list(self.seconds),
        }
