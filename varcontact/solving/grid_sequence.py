"""Sequence of finer grids for an accuracy, one rule for single scenes, batches and wheels: elements
across the contact on each, and the error from the last three.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from itertools import pairwise
from typing import Any, Generic, TypeVar

import numpy as np

from varcontact.scene.grid import Edge, Grid
from varcontact.scene.motion import Steady
from varcontact.scene.scene import Scene

COARSEST_ELEMENTS = 4
"""Elements across the contact on the coarsest grid."""
COARSEST_ELEMENTS_LINE = 48
"""Elements across the contact on the coarsest grid, in line contact."""
RATIO = 1.5
"""Ratio of the elements across on a grid to those on the grid before."""
GRIDS = 3
"""Number of grids from which an error is estimated."""
ORDER = 1.5
"""Order of Richardson's steps s; where a layer hardens it is 1."""
SAFETY = 1.25
"""The error is ``SAFETY max |s| + FLOOR n^-ORDER``, for the largest pressure with the n across the
patch that has it."""
FLOOR = 0.4
"""Constant of the error that no grid shows, see `SAFETY`."""
PART = 0.5
"""Share of Richardson's last step that is added to the value."""
FLOOR_PART = 0.5
"""Share of the accuracy that the floor may have on the third grid."""

Level = TypeVar("Level")


@dataclass
class GridSequence(Generic[Level]):
    """The grids of a solve to an accuracy: elements across on the next one, and the answers so far.

    `whole`: whether the number of elements across is rounded up to a whole number, or only
    determines the sides of elements.
    """

    n: float
    whole: bool = True
    levels: list[Level] = field(default_factory=list)
    across: list[float] = field(default_factory=list)

    @property
    def few(self) -> bool:
        """True where the grids are too few for an error estimate."""
        return len(self.levels) < GRIDS

    @property
    def last(self) -> list[Level]:
        """Answers from which the error is estimated."""
        return self.levels[-GRIDS:]

    def learn(self, level: Level, n: float | None = None) -> None:
        """Add the answer on the grid, or on one with n elements across; the next one is finer."""
        self.levels.append(level)
        self.across.append(n or self.n)
        self.n = self.finer()

    def finer(self, ratio: float = RATIO) -> float:
        """Elements across on a grid finer than the last one."""
        n = self.across[-1] * ratio
        if self.whole:
            return math.ceil(n)
        return n

    def extrapolated(self, value: Callable[[Level], Any]) -> tuple[Any, Any]:
        """Extrapolated value of the last answers and its error, see `richardson`."""
        return richardson([value(level) for level in self.last], self.across[-GRIDS:])


def gridded(scene: Scene, closed_form: bool, n: int) -> Scene:
    """The scene on the grid with `n` elements across the contact, with the discretisation of its
    kind.

    Rolling takes differences of the second order, but of layers that harden, and more elements
    along x; under Hertz's pressure elements at the contact's edge count in part.
    """
    motion = scene.motion
    rolls = isinstance(scene.motion, Steady)
    edge: Edge = "centres"
    if closed_form and motion is not None and (rolls or not scene.line):
        edge = "touched"
        if rolls and not scene.hardens:
            edge = "softened"
    if scene.line:
        grid = Grid(nx=n, edge=edge)
    elif rolls:
        grid = Grid(nx=round(RATIO * n), ny=n, edge=edge)
    else:
        grid = Grid(nx=n, ny=n, edge=edge)
    if isinstance(motion, Steady) and not scene.hardens:
        motion = motion.second_order()
    return replace(scene, grid=grid, motion=motion)


def order_of(scene: Scene) -> float:
    """Order of Richardson's steps for a scene."""
    if scene.first_order:
        return 1.0
    return ORDER


def richardson(
    values: Sequence[Any], across: Sequence[float], order: float = ORDER
) -> tuple[Any, Any]:
    """Extrapolated value and its error without the floor, by Richardson's steps between the last
    grids, three or two.
    """
    parts = [1 / ((fine / coarse) ** order - 1) for coarse, fine in pairwise(across)]
    steps = [
        (fine - coarse) * part for (coarse, fine), part in zip(pairwise(values), parts, strict=True)
    ]
    before = (across[-2] / across[-1]) ** order * np.abs(steps[0])
    return values[-1] + PART * steps[-1], SAFETY * np.maximum(np.abs(steps[-1]), before)


def coarsest(line: bool, accuracy: float | None) -> int:
    """Elements across on the first grid, chosen so that the floor is a given share of the accuracy
    on the third.
    """
    n = COARSEST_ELEMENTS_LINE if line else COARSEST_ELEMENTS
    if accuracy is None:
        return n
    return max(
        n, math.ceil((FLOOR / (FLOOR_PART * accuracy)) ** (1 / ORDER) / RATIO ** (GRIDS - 1))
    )
