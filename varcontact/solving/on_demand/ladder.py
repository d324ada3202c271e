"""The grids that an accuracy chooses from: how a scene is put on each, and which error is to be expected there."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Literal

from varcontact.planning.plan import Plan
from varcontact.scene.grid import Grid
from varcontact.scene.motion import Steady
from varcontact.scene.scene import Scene


@dataclass(frozen=True)
class Ladder:
    """Grids of one shape, from coarse to fine, with the law of their errors.

    The laws are measured: `tests/benchmarks/on_demand.py` fits them on random scenes, docs/accuracy.md has the figures.

    Attributes
    ----------
    name : str
        The scenes it is for.
    order : float
        The error falls like the size of the elements to this power: with it two grids are extrapolated.
    share : float
        Largest error of the extrapolated value by the step to it from the finer grid's.
    floor, fall : float
        What is added to that: ``floor n^-fall`` with n elements across the contact.
    usual : float
        The step to the extrapolated value, usually: ``usual n^-order``.
    coarsest : int
        Fewest elements across the contact.
    along : float
        Elements along x by those along y.
    edge : str
        As of `Grid`.
    """

    name: str
    order: float
    share: float
    floor: float
    fall: float
    usual: float
    coarsest: int
    along: float = 1.0
    edge: Literal["centres", "touched"] = "centres"

    def posed(self, scene: Scene, n: int) -> Scene:
        """The `scene` on the grid with `n` elements across the contact."""
        grid = Grid(nx=n) if scene.line else Grid(nx=round(self.along * n), ny=n, edge=self.edge)
        return replace(scene, grid=grid)

    def elements(self, n: float) -> int:
        """Elements of the grid with `n` across the contact."""
        return round(n) if self.name.startswith("line") else round(self.along * n) * round(n)

    def coarser(self, n: int, part: float) -> int:
        """Elements across the contact on the first of two grids, `part` of the `n` on the second."""
        return max(self.coarsest, math.ceil(part * n))

    def expected(self, n: float) -> float:
        """The estimate of the error that `n` elements across the contact usually lead to."""
        return self.share * self.usual * n**-self.order + self.remainder(n)

    def remainder(self, n: float) -> float:
        """The part of the estimate that two answers do not show, with `n` elements across the contact."""
        return self.floor * n**-self.fall

    def alone(self, n: float) -> float:
        """The error that an answer on a single grid of `n` elements across the contact usually has."""
        return self.usual * n**-self.order + self.remainder(n)

    def error(self, step: float, n: int) -> float:
        """Estimated error of an extrapolated value.

        Parameters
        ----------
        step : float
            Its distance from the value on the finer grid.
        n : int
            Elements across the contact on that grid.
        """
        return self.share * abs(step) + self.remainder(n)

    def first(self, accuracy: float) -> int:
        """Fewest elements across the contact that usually reach an `accuracy`, on two grids."""
        n = math.ceil(1.5 * self.coarsest)
        while self.expected(n) > accuracy:
            n = math.ceil(1.05 * n)
        return n


LADDERS = {
    (False, True, "none"): Ladder("Hertz's contact", 1.0, 0.0, 0.0, 1.0, 0.0, 24),
    (True, True, "none"): Ladder("Hertz's contact", 1.0, 0.0, 0.0, 1.0, 0.0, 100),
    (False, True, "steady"): Ladder("rolling under Hertz's pressure", 1.2, 1.5, 0.1, 1.2, 0.1, 6, 1.5, "touched"),
    (False, True, "shift"): Ladder("shifts under Hertz's pressure", 2.0, 1.5, 0.5, 2.0, 0.5, 6, 1.0, "touched"),
    (False, False, "steady"): Ladder("rolling under computed pressure", 1.2, 1.5, 0.3, 1.2, 0.5, 8),
    (False, False, "shift"): Ladder("shifts under computed pressure", 2.0, 1.5, 0.5, 2.0, 0.3, 8),
    (False, False, "none"): Ladder("normal contact", 2.0, 1.5, 0.5, 2.0, 0.3, 8),
    (True, True, "steady"): Ladder("line contact, rolling under Hertz's pressure", 1.0, 1.5, 0.3, 1.2, 0.2, 16),
    (True, True, "shift"): Ladder("line contact, shifts under Hertz's pressure", 2.0, 1.5, 0.5, 2.0, 0.5, 16),
    (True, False, "steady"): Ladder("line contact, rolling under computed pressure", 1.0, 1.5, 0.3, 1.0, 0.5, 16),
    (True, False, "shift"): Ladder("line contact, shifts under computed pressure", 1.0, 1.5, 0.5, 1.0, 0.5, 16),
    (True, False, "none"): Ladder("line contact, normal", 1.0, 1.5, 0.5, 1.0, 0.5, 16),
}
"""By whether it is line contact, whether Hertz's pressure is taken, and motion."""


def kind_of(scene: Scene, plan: Plan) -> tuple[bool, bool, str]:
    """The key of a scene's ladder.

    Parameters
    ----------
    scene : Scene
    plan : Plan
    """
    moves = "none" if not plan.rubs else "steady" if isinstance(scene.motion, Steady) else "shift"
    return scene.line, plan.closed_form, moves


def ladder_of(scene: Scene, plan: Plan) -> Ladder:
    """The ladder for a scene.

    Parameters
    ----------
    scene : Scene
    plan : Plan
    """
    return LADDERS[kind_of(scene, plan)]
