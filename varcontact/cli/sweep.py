"""``varcontact sweep SWEEP.toml``."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from varcontact.cli.app import app
from varcontact.cli.methods import METHODS
from varcontact.cli.terminal import NOT_SOLVED, check_outputs, fail, show, stop
from varcontact.cli.workers import bar, cluster
from varcontact.errors import Interrupted, SceneError, WorkersLost

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr

TAKEN = (
    "normal", "tangential", "coupling", "formulation", "method", "tol", "polish", "certify", "accuracy", "time_budget"
)  # fmt: skip
"""Entries of ``[solve]`` that a sweep has too."""
SHOWN = 40
"""Scenes that are printed; the store has all of them."""
PRINTED = ("outcome", "Fx", "Fy", "Mz", "residual")


@app.command(
    short_help="Solve a scene for many values of its entries.",
    epilog=f"{METHODS}\n\nExample: varcontact sweep sweep.toml --workers 2 --out sweep.nc",
)
def sweep(
    scene: Annotated[
        Path, typer.Argument(help="A scene file with a table [over] of values (docs/sweeps.md).", show_default=False)
    ],
    workers: Annotated[int, typer.Option(help="Processes that solve scenes.")] = 1,
    dask: Annotated[
        str | None, typer.Option(help="Address of a dask scheduler whose workers solve them, as tcp://host:8786.")
    ] = None,
    method: Annotated[str | None, typer.Option(help="The overall method, as for solve.")] = None,
    normal: Annotated[str | None, typer.Option(help="Normal problem, as for solve.")] = None,
    tangential: Annotated[str | None, typer.Option(help="Tangential problem, as for solve.")] = None,
    coupling: Annotated[str | None, typer.Option(help="Coupling for unlike bodies, as for solve.")] = None,
    formulation: Annotated[str | None, typer.Option(help="Formulation of the programs, as for solve.")] = None,
    tol: Annotated[float | None, typer.Option(help="Required natural-map residual.  [default: 1e-8]")] = None,
    certify: Annotated[
        str | None,
        typer.Option(help="The certificate: full (with bounds on forces), gap, none, auto.  [default: gap]"),
    ] = None,
    accuracy: Annotated[
        float | None,
        typer.Option(help="Largest error of each against the continuum, as for solve.", show_default=False),
    ] = None,
    time_budget: Annotated[
        float | None, typer.Option(help="Instead of --accuracy, seconds for each of them.", show_default=False)
    ] = None,
    chunk: Annotated[int, typer.Option(help="Scenes that a worker solves one after the other.")] = 8,
    out: Annotated[
        Path | None,
        typer.Option(help="Store (.nc), written as results come; scenes already in it are not solved again."),
    ] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print one JSON array instead of the table.")] = False,
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
    given: dict[str, Any] = {"method": method, "normal": normal, "tangential": tangential, "coupling": coupling}
    given |= {"formulation": formulation, "tol": tol, "certify": certify}
    given |= {"accuracy": accuracy, "time_budget": time_budget}
    options |= {name: value for name, value in given.items() if value is not None}
    try:
        with cluster(dask, workers) as executor, bar() as progress:
            options |= {"chunk": chunk, "workers": workers, "store": out, "progress": progress, "executor": executor}
            swept = sweep_over(described, over, **options)
    except Interrupted as stopped:
        stop(stopped, out, "--out FILE.nc", "scenes")
    except WorkersLost as lost:
        kept = "nothing is kept; with --out FILE.nc, finished scenes are kept"
        if out is not None:
            kept = f"finished scenes are kept in {out}, and the same command resumes from there"
        fail(f"{lost}; {kept}", NOT_SOLVED)
    show(_json(swept) if as_json else _report(swept))


def _table(swept: xr.Dataset) -> pd.DataFrame:
    """A row for each scene: what varies, and what came out."""
    return swept.to_dataframe().reset_index() if swept.dims else swept.expand_dims("scene").to_dataframe()


def _json(swept: xr.Dataset) -> str:
    from varcontact.study.store import plain_rows

    return json.dumps(plain_rows(_table(swept)), indent=2, allow_nan=False)


def _report(swept: xr.Dataset) -> str:
    """The first scenes as a table, how many came to what, and why those that failed did."""
    from varcontact.study.tables import columns_of_text

    table, names = _table(swept), list(swept.dims)
    counts = table["outcome"].value_counts()
    words = ", ".join(f"{count} {outcome}" for outcome, count in counts.items())
    rows = table.head(SHOWN).to_dict("records")
    lines = [[*map(str, names), *PRINTED]]
    lines += [[_cell(row[name], row.get(f"{name}_error")) for name in (*names, *PRINTED)] for row in rows]
    more = [f"... and {len(table) - SHOWN} more"] if len(table) > SHOWN else []
    failed = table[table["reason"] != ""].groupby("reason", sort=False).size()
    reasons = [f"{count} because: {reason}" for reason, count in failed.items()]
    return "\n".join([f"{len(table)} scenes: {words}", *columns_of_text(lines, left=0), *more, *reasons])


def _cell(value: Any, bar: float | None) -> str:
    from varcontact.results.report import with_bar

    if isinstance(value, float):
        return "" if value != value else with_bar(value, bar or 0.0)
    return str(value)
