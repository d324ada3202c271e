"""The maker of the file of references: ``python -m varcontact.data.make_references [--runs RUNS.csv] [FILE]``.

Each scene is solved on many grids, which takes minutes for some and most of an hour for all; with ``--runs`` solves are
kept after every scene, and the same command resumes from there.
"""

from __future__ import annotations

import argparse
import json
import math
import sys
import time
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

import varcontact
from varcontact.data.benchmark_scenes import Posed, reference_scenes
from varcontact.errors import VarcontactError
from varcontact.results.quantities_of_interest import NORMAL, units
from varcontact.scene.grid import Grid
from varcontact.solving.solve import solve
from varcontact.study.csv_table import Table
from varcontact.study.extrapolate import extrapolate_series
from varcontact.study.references import COMMAND, FILE, VERSION, signature
from varcontact.study.refinement import TOLERANCE, series_of, solves
from varcontact.system.files import write_whole

COLUMNS = ("scene", "cells", "position", "values", "seconds", "identity")
WORDS = ("scene", "values", "identity")
ROUNDED = 1e-12
"""Error bar of closed forms, relative."""
SOLVED = 100 * TOLERANCE
"""Least error bar of what solves have found, in units of the value: what they may miss by their tolerance."""
USUAL_CELLS = 48


def main(arguments: list[str] | None = None) -> int:
    """Make the file; the exit status is 0, or 2 for bad input."""
    parser = argparse.ArgumentParser(prog=COMMAND, description=__doc__)
    own = Path(__file__).with_name(FILE)
    parser.add_argument("file", nargs="?", type=Path, default=own, help="where to write [the package's own file]")
    parser.add_argument("--runs", type=Path, help="CSV file of the solves, to go on from")
    given = parser.parse_args(arguments)
    try:
        content = make(given.runs)
        write_whole("file", given.file, (json.dumps(content, indent=1) + "\n").encode())
    except VarcontactError as error:
        print(error, file=sys.stderr)
        return 2
    return 0


def make(runs: Path | None = None, scenes: Mapping[str, Posed] | None = None) -> dict[str, Any]:
    """The content of the file: solve what the table of solves lacks, and extrapolate."""
    found = {}
    with Table.opened(runs, COLUMNS, WORDS, "a table of the solves of references") as table:
        for name, posed in (reference_scenes() if scenes is None else scenes).items():
            key = signature(posed)
            known = [row for row in table.rows if row["scene"] == name and row["identity"] == key]
            if not _closed(posed):
                fresh = _solved(name, posed, {(row["cells"], row["position"]) for row in known})
                if fresh:
                    table.add(*fresh)
                known += fresh
            found[name] = {"scene": key, **(_hertz(posed) if _closed(posed) else _extrapolated(posed, known))}
    return {
        "version": VERSION,
        "made": f"{COMMAND}, varcontact {varcontact.__version__}",
        "references": found,
    }


def _solved(name: str, posed: Posed, known: set[tuple[int, int]]) -> list[dict[str, Any]]:
    """The solves of a scene that are not known yet, as rows of the table."""
    rows: list[dict[str, Any]] = []
    started = time.perf_counter()
    for cells, position, values in solves(posed, known):
        if not rows:
            print(name, flush=True)
        rows.append(
            {
                "scene": name,
                "cells": cells,
                "position": position,
                "values": json.dumps(values),
                "seconds": round(time.perf_counter() - started, 3),
                "identity": signature(posed),
            }
        )
        started = time.perf_counter()
    return rows


def _closed(posed: Posed) -> bool:
    """Whether Hertz has the answer."""
    return posed.scene.frictionless and posed.scene.hertz is not None


def _hertz(posed: Posed) -> dict[str, Any]:
    hertz, scene = posed.scene.hertz, posed.scene
    assert hertz is not None
    area = 2 * hertz.a if scene.line else math.pi * hertz.a * hertz.b
    load = {"approach": hertz.approach} if scene.approach is None else {"normal_force": hertz.force}
    values = load | {"peak_pressure": hertz.peak_pressure, "contact_area": area}
    sizes = {name: value for name, value in values.items() if name in NORMAL}
    bars = {name: ROUNDED * value for name, value in values.items()}
    return {"values": values, "bars": bars, "units": sizes, "how": "closed form (Hertz)"}


def _extrapolated(posed: Posed, rows: list[dict[str, Any]]) -> dict[str, Any]:
    """Values, bars and units of a scene from its solves."""
    cells = np.array([float(row["cells"]) for row in rows])
    found = [json.loads(row["values"]) for row in rows]
    limits = {name: extrapolate_series(1 / cells, np.array([each[name] for each in found])) for name in found[0]}
    sizes = _units(posed, {name: value for name, (value, _) in limits.items()})
    bars = {name: max(bar, SOLVED * sizes.get(name, abs(value))) for name, (value, bar) in limits.items()}
    how = f"extrapolated from {len(rows)} solves with {cells.min():.0f} to {cells.max():.0f} elements across; "
    return {
        "values": {name: _figures(value, bars[name]) for name, (value, _) in limits.items()},
        "bars": {name: float(f"{bar:.3g}") for name, bar in bars.items()},
        "units": {name: float(f"{size:.9g}") for name, size in sizes.items()},
        "how": how + series_of(posed.scene).why,
    }


def _units(posed: Posed, values: dict[str, float]) -> dict[str, float]:
    """What an error of one is; of non-Hertzian contacts by the area on a usual grid, normal contact by itself."""
    scene = posed.scene
    grid = Grid(nx=USUAL_CELLS, ny=None if scene.line else USUAL_CELLS)
    sizes = units(solve(replace(scene, grid=grid), certify=None), posed.steps or None)
    return {name: abs(values[name]) if name in NORMAL else size for name, size in sizes.items()}


def _figures(value: float, bar: float) -> float:
    """A number to a hundredth of its error bar."""
    return float(f"{value:.12g}") if bar <= 0 else round(value, 2 - math.floor(math.log10(bar)))


if __name__ == "__main__":
    sys.exit(main())
