"""The grids that an accuracy chooses from: how a scene is put on each, and which error is to be expected there."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Literal

from varcontact.planning.plan import Plan
from varcontact.scene.grid import Grid
from varcontact.scene.motion import Steady
from varcontact.scene.scene import Scene
from varcontact.scene.transient import Transient


@dataclass(frozen=True)
class Law:
    """How errors fall with the number n of elements across the contact, measured.

    Attributes
    ----------
    order : float
        The error falls like the size of the elements to this power: with it two grids are extrapolated.
    share : float
        Largest error of the extrapolated value by the step to it from the finer grid's.
    floor, fall : float
        What is added to that: ``floor n^-fall``.
    usual : float
        The step to the extrapolated value, usually: ``usual n^-order``.
    single : float
        Largest error of an answer on one grid: ``single n^-order``.
    """

    order: float
    share: float
    floor: float
    fall: float
    usual: float
    single: float

    def remainder(self, n: float) -> float:
        """The part of the estimate that two answers do not show, with `n` elements across the contact."""
        return self.floor * n**-self.fall

    def expected(self, n: float) -> float:
        """The estimate of the error that `n` elements across the contact usually lead to."""
        return self.share * self.usual * n**-self.order + self.remainder(n)

    def alone(self, n: float) -> float:
        """Estimated error of an answer on a single grid of `n` elements across the contact."""
        return self.single * n**-self.order

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


@dataclass(frozen=True)
class Ladder:
    """Grids of one shape, from coarse to fine, with the law of their errors.

    The laws are measured: `tests/benchmarks/on_demand.py` fits them on random scenes, docs/tutorials/accuracy.md has
    what they keep on others.

    Attributes
    ----------
    name : str
        The scenes it is for.
    law : Law
    coarsest : int
        Fewest elements across the contact.
    along : float
        Elements along x by those along y.
    edge : str
        As of `Grid`.
    second_order : bool
        Whether the slip of steady rolling is a difference of the second order, see `Scene.second_order`.
    line : bool
        Whether it is for line contact.
    """

    name: str
    law: Law
    coarsest: int
    along: float = 1.0
    edge: Literal["centres", "touched", "softened"] = "centres"
    second_order: bool = False
    line: bool = False

    def posed(self, scene: Scene, n: int) -> Scene:
        """The `scene` on the grid with `n` elements across the contact."""
        grid = Grid(nx=n) if scene.line else Grid(nx=round(self.along * n), ny=n, edge=self.edge)
        posed = replace(scene, grid=grid)
        return posed.second_order() if self.second_order else posed

    def elements(self, n: float) -> int:
        """Elements of the grid with `n` across the contact."""
        return round(n) if self.line else round(self.along * n) * round(n)

    def coarser(self, n: int, part: float) -> int:
        """Elements across the contact on the first of two grids, `part` of the `n` on the second."""
        return max(self.coarsest, math.ceil(part * n))

    def first(self, accuracy: float) -> int:
        """Fewest elements across the contact that usually reach an `accuracy`, on two grids."""
        n = math.ceil(1.5 * self.coarsest)
        while self.law.expected(n) > accuracy:
            n = math.ceil(1.05 * n)
        return n


EXACT = Law(1.0, 0.0, 0.0, 1.0, 0.0, 0.0)
"""The law of what has no error."""
LADDERS = {
    (False, True, "none"): Ladder("Hertz's contact", EXACT, 24),
    (True, True, "none"): Ladder("Hertz's contact", EXACT, 100, line=True),
    (False, True, "steady"): Ladder(
        "rolling under Hertz's pressure",
        Law(1.75, 1.0, 0.029, 1.0, 0.13, 1.0),
        coarsest=4,
        along=1.5,
        edge="softened",
        second_order=True,
    ),
    (False, True, "shift"): Ladder(
        "shifts under Hertz's pressure", Law(2.0, 0.25, 1.6, 2.0, 0.53, 1.9), coarsest=4, edge="touched"
    ),
    (False, False, "steady"): Ladder(
        "rolling under computed pressure",
        Law(2.0, 0.25, 1.6, 1.5, 0.47, 3.1),
        coarsest=6,
        along=1.5,
        second_order=True,
    ),
    (False, False, "shift"): Ladder("shifts under computed pressure", Law(2.0, 3.0, 0.39, 2.0, 0.23, 1.2), coarsest=6),
    (False, False, "none"): Ladder("normal contact", Law(2.0, 3.0, 4.4, 2.0, 0.76, 7.1), coarsest=6),
    (True, True, "steady"): Ladder(
        "line contact, rolling under Hertz's pressure",
        Law(1.75, 0.5, 0.12, 1.25, 0.077, 0.67),
        coarsest=8,
        second_order=True,
        line=True,
    ),
    (True, True, "shift"): Ladder(
        "line contact, shifts under Hertz's pressure", Law(2.0, 0.25, 0.43, 2.0, 0.084, 0.41), coarsest=8, line=True
    ),
    (True, False, "steady"): Ladder(
        "line contact, rolling under computed pressure",
        Law(2.0, 1.0, 0.64, 1.0, 2.2, 6.6),
        coarsest=12,
        second_order=True,
        line=True,
    ),
    (True, False, "shift"): Ladder(
        "line contact, shifts under computed pressure", Law(2.0, 2.0, 0.013, 1.0, 0.021, 2.8), coarsest=8, line=True
    ),
    (True, False, "none"): Ladder("line contact, normal", Law(2.0, 1.0, 0.64, 1.0, 2.2, 6.6), coarsest=8, line=True),
    (False, True, "history"): Ladder(
        "histories under Hertz's pressure", Law(1.75, 3.0, 0.1, 1.5, 0.5, 2.5), coarsest=6, edge="touched"
    ),
    (False, False, "history"): Ladder(
        "histories under computed pressure", Law(2.0, 3.0, 0.5, 2.0, 0.63, 7.1), coarsest=6
    ),
    (True, True, "history"): Ladder(
        "line contact, histories under Hertz's pressure", Law(1.75, 2.0, 1.1, 2.0, 0.15, 1.5), coarsest=8, line=True
    ),
    (True, False, "history"): Ladder(
        "line contact, histories under computed pressure", Law(1.75, 2.0, 1.1, 2.0, 0.15, 1.5), coarsest=8, line=True
    ),
}
"""By whether it is line contact, whether Hertz's pressure is taken, and motion."""


def kind_of(scene: Scene, plan: Plan) -> tuple[bool, bool, str]:
    """The key of a scene's ladder.

    Parameters
    ----------
    scene : Scene
    plan : Plan
    """
    motion = scene.motion
    steps = "history" if isinstance(motion, Transient) else "steady" if isinstance(motion, Steady) else "shift"
    return scene.line, plan.closed_form, steps if plan.rubs else "none"


def ladder_of(scene: Scene, plan: Plan) -> Ladder:
    """The ladder for a scene.

    Parameters
    ----------
    scene : Scene
    plan : Plan
    """
    return LADDERS[kind_of(scene, plan)]
