"""The grids that an accuracy chooses from: how a scene is put on each, and what error is to be expected there."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

from varcontact.scene.grid import Grid
from varcontact.scene.motion import Shift, Steady
from varcontact.scene.scene import Scene

COARSEST, COARSEST_IN_LINE = 6, 16
"""Elements across the contact of the first of two grids, at least."""


@dataclass(frozen=True)
class Ladder:
    """Grids of one shape from coarse to fine, with the law of their errors.

    Attributes
    ----------
    name : str
        The class of scenes it is for.
    order : float
        The error falls like the size of the elements to this power: by it two grids are extrapolated.
    share : float
        The error of the extrapolated value by its distance from the finer grid's value, at most.
    floor, fall : float
        What is added to that: ``floor n^-fall`` with n elements across the contact.
    usual : float
        Distance of the extrapolated value from the finer grid's, usually: ``usual n^-order``.
    along : float
        Elements along x by those along y.
    """

    name: str
    order: float
    share: float
    floor: float
    fall: float
    usual: float
    along: float = 1.0

    def expected(self, n: float) -> float:
        """The estimate that `n` elements across the contact usually lead to."""
        return self.share * self.usual * n**-self.order + self.floor * n**-self.fall

    def first(self, accuracy: float, least: int) -> int:
        """Fewest elements across the contact that usually reach an accuracy: `least`, or more.

        Parameters
        ----------
        accuracy : float
            [-]
        least : int
        """
        n = float(least)
        while self.expected(n) > accuracy:
            n *= 1.05
        return math.ceil(n)

    def error(self, change: float, n: int) -> float:
        """Estimated error of an extrapolated value.

        Parameters
        ----------
        change : float
            Its distance from the value on the finer grid.
        n : int
            Elements across the contact on that grid.
        """
        return self.share * abs(change) + self.floor * n**-self.fall
