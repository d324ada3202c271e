"""``varcontact sweep SWEEP.toml``."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from varcontact.cli import options as opt
from varcontact.cli.options import given
from varcontact.cli.terminal import NOT_SOLVED, check_outputs, cluster, fail, progress_bar, show, stop
from varcontact.errors import Interrupted, SceneError, WorkersLost

if TYPE_CHECKING:
    import xarray as xr

TAKEN = (
    "normal", "tangential", "coupling", "formulation", "method", "tol", "polish", "certify", "accuracy", "time_budget"
)  # fmt: skip
"""Entries of ``[solve]`` that a sweep accepts."""
SHOWN = 40
"""Scenes that are printed; the store has all of them."""
PRINTED = ("outcome", "Fx", "Fy", "Mz", "residual")


def sweep(
    scene: Annotated[
        Path, typer.Argument(help="Scene file with a table [over] of values (docs/sweeps.md).", show_default=False)
    ],
    workers: opt.Workers = 1,
    dask: opt.Dask = None,
    method: opt.MethodName = None,
    normal: opt.Normal = None,
    tangential: opt.Tangential = None,
    coupling: opt.Coupling = None,
    formulation: opt.Formulation = None,
    tol: opt.Tol = None,
    certify: opt.Certify = None,
    accuracy: opt.Accuracy = None,
    time_budget: opt.TimeBudget = None,
    chunk: Annotated[int, typer.Option(help="Scenes that a worker solves one after the other.")] = 8,
    out: Annotated[
        Path | None, typer.Option(help="Store (.nc), written as results come; scenes in it are not solved again.")
    ] = None,
    as_json: opt.AsJson = False,
) -> None:
    """Solve a scene for all combinations of values, in several processes or on a cluster."""
    from varcontact.io.scene_toml import read_sweep_scene
    from varcontact.study.sweep import sweep as sweep_over

    check_outputs(out, None, [scene], False, ".nc")
    described, over, options = read_sweep_scene(scene)
    if "start" in options:
        raise SceneError("solve.start", options["start"], "left out: a sweep has its own starts")
    for name, value in options.items():
        if name not in TAKEN:
            raise SceneError(f"solve.{name}", value, f"left out: of [solve] a sweep takes {', '.join(TAKEN)}")
    options |= given(method=method, normal=normal, tangential=tangential, coupling=coupling, formulation=formulation)
    options |= given(tol=tol, certify=certify, accuracy=accuracy, time_budget=time_budget)
    try:
        with cluster(dask, workers) as executor, progress_bar() as progress:
            options |= {"chunk": chunk, "workers": workers, "store": out, "progress": progress, "executor": executor}
            swept = sweep_over(described, over, **options)
    except Interrupted as stopped:
        stop(stopped, out, "--out FILE.nc", "scenes")
    except WorkersLost as lost:
        kept = "nothing is kept; with --out FILE.nc, finished scenes are kept"
        if out is not None:
            kept = f"finished scenes are kept in {out}, and the same command resumes from there"
        fail(f"{lost}; {kept}", NOT_SOLVED)
    show(_written(swept, as_json))


def _written(swept: xr.Dataset, as_json: bool) -> str:
    """All scenes as JSON; or the first as a table, the number of each outcome, and the reasons of failures."""
    from varcontact.study.csv_table import columns_of_text, plain_rows

    table = swept.to_dataframe().reset_index() if swept.dims else swept.expand_dims("scene").to_dataframe()
    if as_json:
        return json.dumps(plain_rows(table), indent=2, allow_nan=False)
    names = [*map(str, swept.dims), *PRINTED]
    words = ", ".join(f"{count} {outcome}" for outcome, count in table["outcome"].value_counts().items())
    lines = [[_cell(row[name], row.get(f"{name}_error")) for name in names] for row in table[:SHOWN].to_dict("records")]
    more = [f"... and {len(table) - SHOWN} more"] if len(table) > SHOWN else []
    failed = table[table["reason"] != ""].groupby("reason", sort=False).size()
    reasons = [f"{count} because: {reason}" for reason, count in failed.items()]
    return "\n".join([f"{len(table)} scenes: {words}", *columns_of_text([names, *lines], left=0), *more, *reasons])


def _cell(value: object, bar: float | None) -> str:
    from varcontact.results.report import with_bar

    if isinstance(value, float):
        return "" if value != value else with_bar(value, bar or 0.0)
    return str(value)
