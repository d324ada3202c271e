"""A field of friction that rolls with the bodies: grease, leaves, a dry patch."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from varcontact import checks
from varcontact.scene.carried import Carried
from varcontact.scene.friction import FrictionBound
from varcontact.scene.grid import Grid


@dataclass(frozen=True, eq=False)
class CarriedFriction(
    checks.Checked, FrictionBound, path="friction", elsewhere=checks.at_least_zero
):
    """Coefficients of friction by samples along the way, which particles carry
    through the contact of a history.

    As with the heights of `Carried`, both bodies roll over the same distance q,
    and the particle at X passes ``x = X - q``. Each step is a problem with a
    field of friction: convex, and its certificate bounds forces.

    Parameters
    ----------
    coefficient : array_like, shape (n,) or (ny, n)
        Coefficients, zero or positive [-]; one row is the same for all y.
    x : array_like, shape (n,)
        Where the samples are along the way, X [length], ascending.
    y : array_like, shape (ny,), optional
        Where the rows are [length], ascending.
    period : float, optional
        The length after which they repeat [length].
    elsewhere : float
        Coefficient beyond the samples, zero or positive [-].

    Raises
    ------
    SceneError
        For coefficients that are negative, and samples that `Carried` refuses.

    Examples
    --------
    >>> patch = CarriedFriction([0.1, 0.1, 0.1], [2.0, 3.0, 4.0], elsewhere=0.4)
    >>> patch.at_step(Grid(nx=4, dx=1.0, x0=-2.0), rolled=3.0).round(3)
    array([[0.4, 0.1, 0.1, 0.4]])
    """

    coefficient: np.ndarray
    x: np.ndarray
    y: np.ndarray | None = None
    period: float | None = None
    elsewhere: float = 0.0
    rolls_along: ClassVar[bool] = True

    def __post_init__(self) -> None:
        super().__post_init__()
        dimension = 1
        if self.y is not None:
            dimension = 2
        values = checks.array("friction.coefficient", self.coefficient, dimension)
        checks.require_all("friction.coefficient", values, values >= 0, "zero or positive")
        object.__setattr__(self, "coefficient", values)
        _ = self._above_elsewhere  # which checks the places of the samples

    __repr__ = checks.short_entries

    @property
    def _above_elsewhere(self) -> Carried:
        return Carried(self.coefficient - self.elsewhere, self.x, self.y, self.period)

    def at_step(self, grid: Grid, rolled: float) -> np.ndarray:
        """The coefficients on a `grid`, (ny, nx), after a distance `rolled` towards positive x
        [length].
        """
        return np.maximum(self.elsewhere + self._above_elsewhere.on(grid, rolled), 0.0)

    def bound(self, pressure: np.ndarray, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        """The traction bound under a `pressure` where no sample is, whatever `x` and `y`."""
        return self.elsewhere * np.maximum(pressure, 0.0)
