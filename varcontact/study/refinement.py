"""A scene on many grids, and what its values tend to: how references are made."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from varcontact.data.benchmark_scenes import Posed
from varcontact.discrete.contact_grid import Box
from varcontact.results.history import History
from varcontact.results.quantities_of_interest import values
from varcontact.results.solution import Solution
from varcontact.scene.grid import Grid
from varcontact.scene.motion import Transient
from varcontact.scene.scene import Scene
from varcontact.solving.solve import solve
from varcontact.study.converge import contact_of, offset

Edge = Literal["centres", "touched"]
TOLERANCE = 1e-8
"""Residual of the solves."""
SPARE = 0.15
"""Room on each side of a contact of unlike bodies, by its width, for where tractions move it."""


@dataclass(frozen=True)
class Series:
    """The grids on which a scene is solved.

    Attributes
    ----------
    cells : dict of int to int
        Elements across the contact, and how many positions of the lattice are solved with each.
    edge : str
        As of `Grid`.
    why : str
        For people.
    """

    cells: dict[int, int]
    edge: Edge
    why: str


REGULAR = Series(
    dict.fromkeys((32, 40, 48, 56, 64, 80, 96, 112, 128, 144, 160, 192, 224, 256), 1),
    "touched",
    "all touched elements, with the bound averaged, on lattices that end where the contact ends: errors fall regularly",
)
STEPS = Series(
    dict.fromkeys((24, 32, 40, 48, 56, 64, 72, 80, 96, 112, 128, 160, 192), 1),
    "touched",
    "all touched elements, dq a whole number of elements",
)
COMPUTED = Series(
    {24: 8, 32: 8, 40: 8, 48: 8, 64: 8, 80: 8, 96: 8, 128: 6, 160: 4, 192: 2},
    "centres",
    "elements by their centres, on lattices in several positions: the noise of the edge is averaged",
)
STRIPS = Series(
    {100: 4, 150: 4, 200: 4, 300: 4, 400: 4, 600: 4, 800: 2, 1200: 2, 1600: 2},
    "centres",
    "strips by their centres, on lattices in several positions",
)
REGULAR_STRIPS = Series(
    dict.fromkeys((100, 150, 200, 300, 400, 600, 800, 1200, 1600), 1),
    "touched",
    "strips with the contact's edges between them: errors fall regularly",
)


def series_of(scene: Scene) -> Series:
    """The grids that leave the smallest error for a scene.

    Parameters
    ----------
    scene : Scene

    Notes
    -----
    Touched elements with averaged bounds need Hertz's pressure; their errors fall as h, so regularly that two terms
    describe them to some 1e-5 of f Fz. Pressures that are computed need the centres, and averages over positions.
    """
    closed = scene.hertz is not None and scene.bodies.K == 0 and not scene.frictionless
    if scene.line:
        return REGULAR_STRIPS if closed else STRIPS
    if isinstance(scene.motion, Transient):
        return STEPS
    return REGULAR if closed else COMPUTED


def solves(posed: Posed, known: Collection[tuple[int, int]] = ()) -> Iterator[tuple[int, int, dict[str, float]]]:
    """Solve a scene on its grids.

    Parameters
    ----------
    posed : Posed
    known : collection of (int, int)
        Elements across and numbers of positions that need not be solved again.

    Yields
    ------
    tuple of int, int and dict of str to float
        Elements across, number of the position, and the values found.
    """
    scene, series = posed.scene, series_of(posed.scene)
    box = None if isinstance(scene.motion, Transient) else contact_of(scene)
    for cells, positions in series.cells.items():
        for i in range(positions):
            if (cells, i) in known:
                continue
            if box is None:
                grid = Grid(nx=cells, ny=cells, edge=series.edge)
            else:
                place = offset(cells, i) if series.edge == "centres" else (0.0, 0.0)
                grid = lattice(scene, box, cells, place, series.edge)
            answer = solve(replace(scene, grid=grid), tol=TOLERANCE, certify=None)
            yield cells, i, followed(answer, posed.steps)


def lattice(scene: Scene, box: Box, cells: int, place: tuple[float, float], edge: Edge) -> Grid:
    """A lattice with a number of elements across a box, moved by parts of an element, and room around it.

    Parameters
    ----------
    scene : Scene
    box : tuple of float
        left, right, bottom, top [length].
    cells : int
    place : tuple of float
        In [0, 1), along x and y.
    edge : str
        As of `Grid`.
    """
    spare = math.ceil(SPARE * cells) if scene.bodies.K != 0 or scene.hertz is None else 1
    left, right, bottom, top = box
    dx, dy = (right - left) / cells, (top - bottom) / cells
    x0, y0, n = left - (spare + place[0]) * dx, bottom - (spare + place[1]) * dy, cells + 1 + 2 * spare
    if scene.line:
        grid = Grid(nx=n, dx=dx, x0=x0, edge=edge)
    else:
        grid = Grid(nx=n, ny=n, dx=dx, dy=dy, x0=x0, y0=y0, edge=edge)
    return grid


def followed(answer: Solution | History, steps: tuple[int, ...] = ()) -> dict[str, float]:
    """The values that are extrapolated: those of `values`, with the peak between the elements, and areas.

    Parameters
    ----------
    answer : Solution or History
    steps : tuple of int
        Of a history: the steps that count.
    """
    found = values(answer, steps or None)
    if isinstance(answer, History):
        return found
    if "peak_pressure" in found:
        found["peak_pressure"] = peak_between(answer.pressure)
        return found | {"contact_area": answer.areas["contact"]}
    return found | {"stick_area": answer.areas["stick"]}


def peak_between(pressure: np.ndarray) -> float:
    """The largest pressure, by parabolas through the largest of the elements and its neighbours.

    Parameters
    ----------
    pressure : ndarray, shape (ny, nx)
        [force/area]
    """
    iy, ix = np.unravel_index(int(pressure.argmax()), pressure.shape)
    largest = float(pressure[iy, ix])
    return largest + sum(_rise(line, int(i)) for line, i in ((pressure[iy], ix), (pressure[:, ix], iy)))


def _rise(line: np.ndarray, i: int) -> float:
    """By how much a parabola through three points rises above the middle one, which is the largest."""
    if not 0 < i < line.size - 1:
        return 0.0
    before, middle, after = line[i - 1 : i + 2]
    bend = 2 * middle - before - after
    return float((after - before) ** 2 / (8 * bend)) if bend > 0 else 0.0
