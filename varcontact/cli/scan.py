"""``varcontact scan SCENE.toml ...``, and ``varcontact curve SCENE.toml ...`` by several
methods.
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import typer

import varcontact as vc
from varcontact.cli import options as opt
from varcontact.cli.options import given, names_of, ranges_of
from varcontact.cli.terminal import check_outputs, draw, progress_line, show
from varcontact.errors import SceneError

PRINTED = ("Fx", "Fy", "Mz", "stick", "slip", "residual")
HEADING = b"(vx,vy,spin|ux,uy,rotation),Fx,Fy,Mz,"
ROUNDING = 1e-13
"""Relative rounding error of sums of tractions that cancel."""


@opt.takes(*opt.CREEPAGES, *opt.SETTINGS)
def scan(
    scene: opt.SceneFile,
    creepages: Annotated[
        Path | None, opt.option("Instead, a table (.csv): three numbers a line.")
    ] = None,
    out: Annotated[Path | None, typer.Option(help="Table (.csv).")] = None,
    plot: opt.Picture = None,
    force: opt.Force = False,
    as_json: opt.AsJson = False,
    **options: Any,
) -> None:
    """Solve one scene for many creepages, each with a certificate.

    Creepages that are not given are taken from the scene. The first failure ends the scan; what was
    solved before is printed and written. See also `curve` (several methods, fast theories) and
    `sweep` (other entries).
    """
    from varcontact.study.scan import creepages_over, scanned
    from varcontact.system.files import check_replaceable

    check_outputs(out, plot, [scene] if creepages is None else [scene, creepages], force)
    if out is not None:
        check_replaceable("--out", out, (".csv",), "table", HEADING, force)
    described, settings = vc.read_scene(scene)
    if "start" in settings:
        raise SceneError("solve.start", settings["start"], "left out: a scan has no start")
    settings |= given(**options)
    ranges = ranges_of(settings)
    if creepages is None:
        triples = creepages_over(described.motion, ranges, "--")
    elif ranges:
        raise SceneError("--creepages", creepages, "left out where --vx, --vy or --spin are given")
    else:
        triples = _table_of_triples(creepages)
    found: list[vc.Solution] = []
    try:
        with progress_line() as progress:
            for solution in scanned(described, triples, **settings):
                found.append(solution)
                progress(f"{len(found)} of {len(triples)} creepages")
    finally:  # computed results are kept if one creepage fails
        if found:
            _deliver(found, out, plot, as_json)


def _table_of_triples(path: Path) -> np.ndarray:
    from varcontact.system.files import text_of

    text = text_of("--creepages", path)
    try:
        lines = [line for line in text.splitlines() if line.strip(' ,;"')]
        heading = bool(lines) and lines[0].strip(' "')[0].isalpha()
        triples = np.loadtxt(lines[heading:] or ["nothing"], delimiter=",", ndmin=2)
        if triples.shape[1] != 3:
            raise ValueError(f"there are {triples.shape[1]} in a line")
    except ValueError as error:
        allowed = f"a readable table of vx, vy, spin, line by line ({error})"
        raise SceneError("--creepages", str(path), allowed) from None
    return triples


def _deliver(found: list[vc.Solution], out: Path | None, plot: Path | None, as_json: bool) -> None:
    import pandas as pd

    from varcontact.study import csv_table
    from varcontact.system.files import write_whole

    rows = [_row(solution) for solution in found]
    table = pd.DataFrame(rows)
    try:
        show(csv_table.as_json(table) if as_json else _table(found, rows))
    finally:  # computed results are kept if the reader has gone
        if out is not None:
            write_whole("--out", out, csv_table.as_csv(table))
        if plot is not None:
            draw(plot, vc.plot_curve, found)


def _row(solution: vc.Solution) -> dict[str, Any]:
    from varcontact.results.quantities_of_interest import creepage_names
    from varcontact.study.methods import BOUNDS, figures

    columns = figures(solution)
    columns |= zip(BOUNDS, map(float, solution.certificate.force_bound), strict=True)
    names = ["Fx", "Fy", "Mz", "normal_force", "approach", "residual", *BOUNDS]
    if solution.error_estimate is not None:
        names += ["Fx_error", "Fy_error", "Mz_error"]
    row = dict(zip(creepage_names(solution), solution.creepage, strict=True))
    return row | {name: columns.get(name, math.nan) for name in names} | solution.elements


def _table(found: list[vc.Solution], rows: list[dict[str, Any]]) -> str:
    from varcontact.study import csv_table

    names = [*list(rows[0])[:3], *PRINTED]
    cleared = []
    for sol, row in zip(found, rows, strict=True):
        arms = {"Fx": 1.0, "Fy": 1.0, "Mz": math.sqrt(sol.areas["contact"])}
        noise = [
            name for name, arm in arms.items() if abs(row[name]) < ROUNDING * sol.normal_force * arm
        ]
        cleared.append(row | dict.fromkeys(noise, 0.0))
    heading = "1 solution" if len(rows) == 1 else f"{len(rows)} solutions"
    units = found[0].scene.units
    line = found[0].scene.line
    if units is not None:
        heading += f", forces in {units.of('force', line)}"
        if not line:
            heading += f", moments in {units.of('moment')}, spin in {units.of('spin')}"
    return "\n".join([heading, *csv_table.rows_of_text(cleared, names)])


@opt.takes(*opt.CREEPAGES)
def curve(
    scene: opt.SceneFile,
    methods: Annotated[
        str, typer.Option(help="Theories, and methods as for compare.")
    ] = "auto,fastsim,fastrip",
    out: Annotated[Path | None, typer.Option(help="Dataset (.nc).")] = None,
    plot: opt.Picture = None,
    force: opt.Force = False,
    as_json: opt.AsJson = False,
    **options: Any,
) -> None:
    """Forces and moment against creepages, by fast theories and exact methods side by side.

    Creepages that are not given are taken from the scene.
    """
    from varcontact.study import csv_table
    from varcontact.system.files import write_whole

    check_outputs(out, plot, [scene], force, (".nc",))
    described, _ = vc.read_scene(scene)
    ranges = ranges_of(given(**options))
    with progress_line() as progress:
        found = vc.creep_curve(described, names_of(methods), progress=progress, **ranges)
    if out is not None:
        write_whole("--out", out, bytes(found.to_netcdf(engine="scipy")))
    if plot is not None:
        draw(plot, vc.plot_curve, found, normalised=bool(found.limit > 0))
    columns = ["theory", "vx", "vy", "spin", "Fx", "Fy", "Mz"]
    table = found.to_dataframe().reset_index()[columns]
    cells = [
        [name, *(f"{each:.5g}" for each in numbers)] for name, *numbers in table.to_numpy().tolist()
    ]
    if as_json:
        show(csv_table.as_json(table))
    else:
        show("\n".join(csv_table.columns_of_text([columns, *cells], 1)))
