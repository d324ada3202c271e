"""The grids that an accuracy chooses from: how a scene is put on each, and which error is to be expected there."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

from varcontact.planning.plan import Plan
from varcontact.scene.grid import Edge, Grid
from varcontact.scene.motion import Steady
from varcontact.scene.scene import Scene
from varcontact.scene.transient import Transient
from varcontact.solving.on_demand.severity import slenderness


@dataclass(frozen=True)
class Law:
    """How errors fall with the number n of elements across the contact, measured.

    Attributes
    ----------
    order : float
        The error falls like the size of the elements to this power: with it two grids are extrapolated.
    share : float
        Largest error of the value by the step from the finer grid's to the extrapolated one.
    floor, fall : float
        What is added to that: ``floor s^power n^-fall``, s as of `severity_of`.
    usual : float
        The step to the extrapolated value, usually: ``usual n^-order``.
    single : float
        Largest error of an answer on one grid: ``single s^power n^-order``.
    power : float
        By which power of their severity errors of scenes are larger: 1, as the arms of moments in slender contacts,
        or 0, 0.5 or 2.
    taken : float
        Which part of the step to the extrapolated value is taken: 1, or less where errors jump from grid to grid.
    """

    order: float
    share: float
    floor: float
    fall: float
    usual: float
    single: float
    power: float = 1.0
    taken: float = 1.0

    def remainder(self, n: float, severity: float = 1.0) -> float:
        """The part of the estimate that two answers do not show.

        Parameters
        ----------
        n : float
            Elements across the contact.
        severity : float
            As of `severity_of`.
        """
        return self.floor * severity**self.power * n**-self.fall

    def expected(self, n: float, severity: float = 1.0, likely: float = 1.0) -> float:
        """The estimate that `n` elements lead to in a scene of this `severity`, by a step `likely` times the usual."""
        return self.share * likely * self.usual * n**-self.order + self.remainder(n, severity)

    def alone(self, n: float, severity: float = 1.0) -> float:
        """Estimated error of an answer on a single grid of `n` elements across, in a scene of this `severity`."""
        return self.single * severity**self.power * n**-self.order

    def error(self, step: float, n: float, severity: float = 1.0) -> float:
        """Estimated error of a value from two grids.

        Parameters
        ----------
        step : float
            From the value on the finer grid to the extrapolated one, whatever part of it is `taken`.
        n : float
            Elements across the contact on that grid.
        severity : float
            As of `severity_of`.
        """
        return self.share * abs(step) + self.remainder(n, severity)


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
    edge: Edge = "centres"
    second_order: bool = False
    line: bool = False

    def posed(self, scene: Scene, n: int) -> Scene:
        """The `scene` on the grid with `n` elements across the contact."""
        grid = Grid(nx=n, edge=self.edge) if scene.line else Grid(nx=round(self.along * n), ny=n, edge=self.edge)
        motion = scene.motion
        if self.second_order and isinstance(motion, Steady):
            motion = motion.second_order()
        return replace(scene, grid=grid, motion=motion)

    def elements(self, n: float) -> int:
        """Elements of the grid with `n` across the contact."""
        return round(n) if self.line else round(self.along * n) * round(n)

    def coarser(self, n: int, part: float) -> int:
        """Elements across the contact on the first of two grids, `part` of the `n` on the second."""
        return max(self.coarsest, math.ceil(part * n))

    def first(self, accuracy: float, severity: float, likely: float = 1.0) -> int:
        """Fewest elements that reach an `accuracy` in a scene of this `severity`, by a step `likely` times usual."""
        n = math.ceil(1.5 * self.coarsest)
        while self.law.expected(n, severity, likely) > accuracy:
            n = math.ceil(1.05 * n)
        return n


EXACT = Law(1.0, 0.0, 0.0, 1.0, 0.0, 0.0)
"""The law of what has no error."""
SLENDER = math.sqrt(8)
"""Slenderness beyond which Hertz's contacts have laws of their own: a/b, or b/a, of 8."""
LADDERS = {
    (False, "hertz", "none"): Ladder("Hertz's contact", EXACT, 24),
    (True, "hertz", "none"): Ladder("Hertz's contact", EXACT, 100, line=True),
    (False, "hertz", "steady"): Ladder(
        "rolling under Hertz's pressure",
        Law(1.75, 0.5, 0.28, 1.5, 0.151, 2.4, taken=0.5),
        coarsest=4,
        along=1.5,
        edge="softened",
        second_order=True,
    ),
    (False, "hertz", "slender steady"): Ladder(
        "slender contacts, rolling under Hertz's pressure",
        Law(2.0, 1.0, 2.2, 2.0, 0.445, 4.3),
        coarsest=4,
        along=1.5,
        edge="softened",
        second_order=True,
    ),
    (False, "hertz", "shift"): Ladder(
        "shifts under Hertz's pressure",
        Law(2.0, 0.5, 1.25, 2.0, 0.50, 2.65, taken=0.5),
        coarsest=4,
        edge="touched",
    ),
    (False, "hertz", "slender shift"): Ladder(
        "slender contacts, shifts under Hertz's pressure",
        Law(2.0, 0.5, 1.5, 2.0, 0.67, 3.1, taken=0.5),
        coarsest=4,
        edge="touched",
    ),
    (False, "hertz", "history"): Ladder(
        "histories under Hertz's pressure",
        Law(2.0, 0.5, 1.7, 2.0, 0.95, 3.9, power=0.5, taken=0.5),
        coarsest=4,
        edge="touched",
    ),
    (False, "computed", "none"): Ladder(
        "normal contact", Law(2.0, 0.5, 0.11, 1.5, 0.67, 1.9, power=2.0, taken=0.5), coarsest=8
    ),
    (False, "computed", "steady"): Ladder(
        "rolling under computed pressure",
        Law(2.0, 0.5, 0.78, 1.5, 1.12, 3.9, power=0.0, taken=0.5),
        coarsest=4,
        along=1.5,
        second_order=True,
    ),
    (False, "computed", "shift"): Ladder(
        "shifts under computed pressure", Law(2.0, 1.0, 0.51, 2.0, 0.283, 1.6, taken=0.5), coarsest=4
    ),
    (False, "computed", "history"): Ladder(
        "histories under computed pressure", Law(2.0, 1.0, 0.61, 2.0, 0.76, 3.4, taken=0.5), coarsest=4
    ),
    (False, "coupled", "steady"): Ladder(
        "rolling of unlike bodies",
        Law(2.0, 0.5, 0.155, 1.25, 0.64, 1.8, taken=0.5),
        coarsest=4,
        along=1.5,
        second_order=True,
    ),
    (False, "coupled", "shift"): Ladder(
        "shifts of unlike bodies", Law(2.0, 0.5, 0.7, 2.0, 0.206, 1.4, taken=0.5), coarsest=4
    ),
    (False, "coupled", "history"): Ladder(
        "histories of unlike bodies", Law(2.0, 1.0, 1.7, 2.0, 0.79, 3.2, taken=0.5), coarsest=4
    ),
    (True, "hertz", "steady"): Ladder(
        "line contact, rolling under Hertz's pressure",
        Law(1.75, 0.5, 0.12, 1.25, 0.077, 0.67),
        coarsest=8,
        edge="softened",
        second_order=True,
        line=True,
    ),
    (True, "hertz", "shift"): Ladder(
        "line contact, shifts under Hertz's pressure", Law(2.0, 0.25, 0.43, 2.0, 0.084, 0.41), coarsest=8, line=True
    ),
    (True, "hertz", "history"): Ladder(
        "line contact, histories under Hertz's pressure", Law(1.75, 3.0, 1.1, 2.0, 0.14, 3.0), coarsest=8, line=True
    ),
    (True, "computed", "none"): Ladder(
        "line contact, normal", Law(2.0, 1.0, 0.64, 1.0, 2.2, 6.6), coarsest=8, line=True
    ),
    (True, "computed", "steady"): Ladder(
        "line contact, rolling under computed pressure",
        Law(2.0, 0.5, 1.6, 1.25, 1.15, 11.5, taken=0.5),
        coarsest=12,
        second_order=True,
        line=True,
    ),
    (True, "computed", "shift"): Ladder(
        "line contact, shifts under computed pressure", Law(2.0, 1.5, 1.0, 2.0, 0.067, 1.2), coarsest=8, line=True
    ),
    (True, "computed", "history"): Ladder(
        "line contact, histories under computed pressure", Law(2.0, 1.5, 3.5, 1.5, 2.7, 9.8), coarsest=8, line=True
    ),
    (True, "coupled", "steady"): Ladder(
        "line contact, rolling of unlike bodies",
        Law(2.0, 0.25, 2.5, 1.25, 2.45, 14.7),
        coarsest=12,
        second_order=True,
        line=True,
    ),
    (True, "coupled", "shift"): Ladder(
        "line contact, shifts of unlike bodies", Law(2.0, 3.0, 0.9, 1.5, 0.05, 6.5), coarsest=8, line=True
    ),
    (True, "coupled", "history"): Ladder(
        "line contact, histories of unlike bodies", Law(2.0, 1.5, 3.5, 1.5, 2.7, 9.8), coarsest=8, line=True
    ),
}
"""By whether it is line contact, pressure ("coupled": computed, and changed by tractions), and motion."""


def kind_of(scene: Scene, plan: Plan) -> tuple[bool, str, str]:
    """The key of a scene's ladder.

    Parameters
    ----------
    scene : Scene
    plan : Plan
    """
    motion = scene.motion
    moves = "history" if isinstance(motion, Transient) else "steady" if isinstance(motion, Steady) else "shift"
    pressure = "hertz" if plan.closed_form else "coupled" if plan.coupling != "none" else "computed"
    if not plan.rubs:
        return scene.line, pressure, "none"
    hertz = scene.hertz
    apart = (False, pressure, f"slender {moves}")
    if not scene.line and hertz is not None and slenderness(hertz.a, hertz.b) > SLENDER and apart in LADDERS:
        return apart
    return scene.line, pressure, moves


def ladder_of(scene: Scene, plan: Plan) -> Ladder:
    """The ladder for a scene.

    Parameters
    ----------
    scene : Scene
    plan : Plan
    """
    return LADDERS[kind_of(scene, plan)]
