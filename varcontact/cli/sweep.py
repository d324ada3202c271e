"""``varcontact sweep SWEEP.toml``, and ``varcontact table make``, a sweep of a book's entries."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

import varcontact as vc
from varcontact.cli import options as opt
from varcontact.cli.options import given
from varcontact.cli.terminal import check_outputs, cluster, progress_line, show, stop
from varcontact.errors import Interrupted, SceneError, WorkersLost

if TYPE_CHECKING:
    import xarray as xr

TAKEN = (*opt.SETTINGS, "polish")
"""Entries of ``[solve]`` that a sweep accepts."""
SHOWN = 40
"""Number of scenes that are printed; the store has all of them."""
PRINTED = ("outcome", "Fx", "Fy", "Mz", "residual")


@opt.takes(*opt.SETTINGS)
def sweep(
    scene: Annotated[
        Path, opt.argument("Scene file with a table [over] of values (docs/sweeps.md).")
    ],
    workers: opt.Workers = 1,
    dask: opt.Dask = None,
    chunk: Annotated[
        int, typer.Option(help="Scenes that a worker solves one after the other.")
    ] = 8,
    out: Annotated[
        Path | None, opt.option("Store (.nc) that is written as results come, and resumed.")
    ] = None,
    as_json: opt.AsJson = False,
    **options: Any,
) -> None:
    """Solve a scene for all combinations of values, in several processes or on a cluster."""
    from varcontact.io.scene_toml import read_sweep_scene

    check_outputs(out, None, [scene], False, (".nc",))
    described, over, settings = read_sweep_scene(scene)
    for name, value in settings.items():
        if name not in TAKEN:
            raise SceneError(
                f"solve.{name}", value, f"left out: of [solve] a sweep takes {', '.join(TAKEN)}"
            )
    settings |= given(**options)
    try:
        with cluster(dask, workers) as executor, progress_line() as progress:
            settings |= {
                "chunk": chunk,
                "workers": workers,
                "store": out,
                "progress": progress,
                "executor": executor,
            }
            swept = vc.sweep(described, over, **settings)
    except (Interrupted, WorkersLost) as stopped:
        stop(stopped, out, "--out FILE.nc", "scenes")
    show(_written(swept, as_json))


def _written(swept: xr.Dataset, as_json: bool) -> str:
    from varcontact.study import csv_table

    table = (
        swept.to_dataframe().reset_index()
        if swept.dims
        else swept.expand_dims("scene").to_dataframe()
    )
    if as_json:
        return csv_table.as_json(table)
    names = [*map(str, swept.dims), *PRINTED]
    words = ", ".join(
        f"{count} {outcome}" for outcome, count in table["outcome"].value_counts().items()
    )
    lines = csv_table.rows_of_text(table[:SHOWN].to_dict("records"), names)
    more = [f"... and {len(table) - SHOWN} more"] if len(table) > SHOWN else []
    failed = table[table["reason"] != ""].groupby("reason", sort=False).size()
    reasons = [f"{count} because: {reason}" for reason, count in failed.items()]
    return "\n".join([f"{len(table)} scenes: {words}", *lines, *more, *reasons])


def make_table(
    nu: Annotated[
        float, typer.Option(help="Combined Poisson's ratio of the bodies.", show_default=False)
    ],
    out: Annotated[Path, typer.Option(help="The book, a netCDF file (.nc).", show_default=False)],
    least: Annotated[float, typer.Option(help="Least a/b.")] = 0.2,
    greatest: Annotated[float, typer.Option(help="Greatest a/b.")] = 5.0,
    ratios: Annotated[int, typer.Option(help="Number of ellipses.")] = 9,
    steps: Annotated[int, typer.Option(help="Magnitudes of creepage in each direction.")] = 21,
    degree: Annotated[
        int, typer.Option(help="Odd degree of polynomials that the directions determine.")
    ] = 17,
    workers: opt.Workers = 1,
    dask: opt.Dask = None,
    force: opt.Force = False,
) -> None:
    """Compute a table book. What is finished is kept beside it, and the same command resumes from
    there.
    """
    from varcontact.data.make_table_book import check_out, make_table_book, stores

    check_out("--out", out, force)
    try:
        with cluster(dask, workers) as executor, progress_line() as progress:
            book = make_table_book(
                nu,
                least=least,
                greatest=greatest,
                ratios=ratios,
                steps=steps,
                degree=degree,
                executor=executor,
                workers=workers,
                out=out,
                overwrite=force,
                progress=progress,
            )
    except Interrupted as stopped:
        stop(stopped, stores(out)[0], "--out FILE.nc", "entries")
    worst = float(book.accuracy.max())
    show(
        f"{book.entries} {book.provenance}; "
        f"estimated error at most {100 * worst:.1f} % of f Fz; in {out}"
    )
