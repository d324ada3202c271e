"""The maker of the file of references: ``python -m tests.benchmarks.references [--runs RUNS.csv]
[FILE]``.

Each scene is solved on many grids, which takes minutes for some and most of an hour for all; with
``--runs`` solves are kept after every scene, and the same command resumes from there.
"""

import argparse
import json
import math
import sys
import time
from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Literal

import numpy as np

import varcontact
from varcontact.data.benchmark_scenes import reference_scenes
from varcontact.discrete.contact_grid import Box
from varcontact.errors import VarcontactError
from varcontact.results.history import History
from varcontact.results.quantities_of_interest import NORMAL, units, values
from varcontact.results.solution import Solution
from varcontact.scene.grid import Grid
from varcontact.scene.scene import Scene
from varcontact.scene.transient import Transient
from varcontact.solving.solve import solve
from varcontact.study.converge import contact_of, offset
from varcontact.study.csv_table import Table, identity
from varcontact.study.extrapolate import extrapolate_series
from varcontact.study.references import COMMAND, FILE, VERSION, steps_of
from varcontact.system.files import write_whole

Edge = Literal["centres", "touched"]
TOLERANCE = 1e-8
"""Residual of the solves."""
MARGIN = 0.15
"""Room on each side of a contact of unlike bodies, by its width, for where tractions move it."""


@dataclass(frozen=True)
class Series:
    """The grids on which a scene is solved."""

    # elements across the contact, and how many positions of the lattice are solved with each
    cells: dict[int, int]
    edge: Edge  # as of `Grid`
    why: str  # for people


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


COLUMNS = ("scene", "cells", "position", "values", "seconds", "identity")
WORDS = ("scene", "values", "identity")
ROUNDED = 1e-12
"""Error bar of closed forms, relative."""
SOLVED = 100 * TOLERANCE
"""Least error bar of what solves have found, in units of the value: what they may miss by their
tolerance."""
USUAL_CELLS = 48
"""Elements across a contact that is not Hertzian, whose area the units are of."""


def main(arguments: list[str] | None = None) -> int:
    """Make the file; the exit status is 0, or 2 for bad input."""
    parser = argparse.ArgumentParser(prog=COMMAND, description=__doc__)
    own = Path(varcontact.__file__).parent / "data" / FILE
    parser.add_argument(
        "file", nargs="?", type=Path, default=own, help="where to write [the package's own file]"
    )
    parser.add_argument("--runs", type=Path, help="CSV file of the solves, to go on from")
    given = parser.parse_args(arguments)
    try:
        content = make(given.runs)
        write_whole("file", given.file, (json.dumps(content, indent=1) + "\n").encode())
    except VarcontactError as error:
        print(error, file=sys.stderr)
        return 2
    return 0


def make(runs: Path | None = None, scenes: Mapping[str, Scene] | None = None) -> dict[str, Any]:
    """The content of the file: solve what the table of solves lacks, and extrapolate."""
    found = {}
    with Table.opened(runs, COLUMNS, WORDS, "a table of the solves of references") as table:
        given = (
            {name: scene for name, (_, scene) in reference_scenes().items()}
            if scenes is None
            else scenes
        )
        for name, scene in given.items():
            key = identity(scene, TOLERANCE)
            known = [row for row in table.rows if row["scene"] == name and row["identity"] == key]
            if not _closed(scene):
                fresh = _solved(name, scene, {(row["cells"], row["position"]) for row in known})
                if fresh:
                    table.write([*table.rows, *fresh])
                known += fresh
            found[name] = _hertz(scene) if _closed(scene) else _extrapolated(scene, known)
    made = f"{COMMAND}, varcontact {varcontact.__version__}"
    return {"version": VERSION, "made": made, "references": found}


def _solved(name: str, scene: Scene, known: set[tuple[int, int]]) -> list[dict[str, Any]]:
    rows: list[dict[str, Any]] = []
    started = time.perf_counter()
    for cells, position, found in solves(scene, known):
        if not rows:
            print(name, flush=True)
        row = {"scene": name, "cells": cells, "position": position, "values": json.dumps(found)}
        row |= {
            "seconds": round(time.perf_counter() - started, 3),
            "identity": identity(scene, TOLERANCE),
        }
        rows.append(row)
        started = time.perf_counter()
    return rows


def _closed(scene: Scene) -> bool:
    """Whether Hertz has the answer."""
    return scene.frictionless and scene.hertz is not None


def _hertz(scene: Scene) -> dict[str, Any]:
    hertz = scene.hertz
    assert hertz is not None
    area = 2 * hertz.a if scene.line else math.pi * hertz.a * hertz.b
    load = {"approach": hertz.approach} if scene.approach is None else {"normal_force": hertz.force}
    values = load | {"peak_pressure": hertz.peak_pressure, "contact_area": area}
    sizes = {name: value for name, value in values.items() if name in NORMAL}
    bars = {name: ROUNDED * value for name, value in values.items()}
    return {"values": values, "bars": bars, "units": sizes, "how": "closed form (Hertz)"}


def _extrapolated(scene: Scene, rows: list[dict[str, Any]]) -> dict[str, Any]:
    cells = np.array([float(row["cells"]) for row in rows])
    found = [json.loads(row["values"]) for row in rows]
    limits = {
        name: extrapolate_series(1 / cells, np.array([each[name] for each in found]))
        for name in found[0]
    }
    grid = Grid(nx=USUAL_CELLS, ny=None if scene.line else USUAL_CELLS)
    usual = units(solve(replace(scene, grid=grid), certify=None), steps_of(scene) or None)
    sizes = {name: abs(limits[name][0]) if name in NORMAL else size for name, size in usual.items()}
    bars = {
        name: max(bar, SOLVED * sizes.get(name, abs(value)))
        for name, (value, bar) in limits.items()
    }
    how = f"extrapolated from {len(rows)} solves with {cells.min():.0f} to {cells.max():.0f} elements across; "
    return {
        "values": {name: _figures(value, bars[name]) for name, (value, _) in limits.items()},
        "bars": {name: float(f"{bar:.3g}") for name, bar in bars.items()},
        "units": {name: float(f"{size:.9g}") for name, size in sizes.items()},
        "how": how + series_of(scene).why,
    }


def _figures(value: float, bar: float) -> float:
    """A number to a hundredth of its error bar."""
    return float(f"{value:.12g}") if bar <= 0 else round(value, 2 - math.floor(math.log10(bar)))


def series_of(scene: Scene) -> Series:
    """The grids that leave the smallest error for a scene.

    Touched elements with averaged bounds need Hertz's pressure; their errors fall as h, so
    regularly that two terms describe them to some 1e-5 of f Fz. Pressures that are computed need
    the centres, and averages over positions.
    """
    closed = scene.hertz is not None and not scene.coupled and not scene.frictionless
    if scene.line:
        return REGULAR_STRIPS if closed else STRIPS
    if isinstance(scene.motion, Transient):
        return STEPS
    return REGULAR if closed else COMPUTED


def solves(
    scene: Scene, known: Collection[tuple[int, int]] = ()
) -> Iterator[tuple[int, int, dict[str, float]]]:
    """Solve a scene on its grids, but those that are known: elements across, number of the
    position, values found.
    """
    series = series_of(scene)
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
            yield cells, i, followed(answer, steps_of(scene))


def lattice(scene: Scene, box: Box, cells: int, place: tuple[float, float], edge: Edge) -> Grid:
    """A lattice with so many elements across a box, moved by parts of an element in [0, 1), and
    room around it.
    """
    margin = math.ceil(MARGIN * cells) if scene.coupled or scene.hertz is None else 1
    left, right, bottom, top = box
    dx, dy = (right - left) / cells, (top - bottom) / cells
    x0, y0, n = (
        left - (margin + place[0]) * dx,
        bottom - (margin + place[1]) * dy,
        cells + 1 + 2 * margin,
    )
    if scene.line:
        grid = Grid(nx=n, dx=dx, x0=x0, edge=edge)
    else:
        grid = Grid(nx=n, ny=n, dx=dx, dy=dy, x0=x0, y0=y0, edge=edge)
    return grid


def followed(answer: Solution | History, steps: tuple[int, ...] = ()) -> dict[str, float]:
    """The values that are extrapolated: with the peak between the elements, and areas; of a
    history's steps.
    """
    found = values(answer, steps or None)
    if isinstance(answer, History):
        return found
    if "peak_pressure" in found:
        found["peak_pressure"] = peak_between(answer.pressure)
        return found | {"contact_area": answer.areas["contact"]}
    return found | {"stick_area": answer.areas["stick"]}


def peak_between(pressure: np.ndarray) -> float:
    """The largest pressure, by parabolas through the largest of the elements and its neighbours."""
    iy, ix = np.unravel_index(int(pressure.argmax()), pressure.shape)
    largest = float(pressure[iy, ix])
    return largest + sum(
        _rise(line, int(i)) for line, i in ((pressure[iy], ix), (pressure[:, ix], iy))
    )


def _rise(line: np.ndarray, i: int) -> float:
    """By how much a parabola through three points rises above the middle one, which is the
    largest.
    """
    if not 0 < i < line.size - 1:
        return 0.0
    before, middle, after = line[i - 1 : i + 2]
    bend = 2 * middle - before - after
    return float((after - before) ** 2 / (8 * bend)) if bend > 0 else 0.0


if __name__ == "__main__":
    sys.exit(main())
