"""``varcontact table make``."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from varcontact.cli.app import app
from varcontact.cli.terminal import FORCE, show, stop
from varcontact.cli.workers import bar, cluster
from varcontact.errors import Interrupted

table_app = typer.Typer(
    no_args_is_help=True,
    rich_markup_mode=None,
    help="Table books: exact forces for many creepages.",
    epilog="Example: varcontact table make --nu 0.3 --out steel.nc --workers 2",
)
app.add_typer(table_app, name="table")


@table_app.callback()
def _table() -> None:
    pass


@table_app.command(epilog="Example: varcontact table make --nu 0.3 --out steel.nc --workers 2")
def make(
    nu: Annotated[float, typer.Option(help="Combined Poisson's ratio of the bodies.", show_default=False)],
    out: Annotated[Path, typer.Option(help="The book, a netCDF file (.nc).", show_default=False)],
    least: Annotated[float, typer.Option(help="Least a/b.")] = 0.2,
    greatest: Annotated[float, typer.Option(help="Greatest a/b.")] = 5.0,
    ratios: Annotated[int, typer.Option(help="Ellipses.")] = 9,
    steps: Annotated[int, typer.Option(help="Magnitudes of creepage in each direction.")] = 21,
    degree: Annotated[int, typer.Option(help="Of polynomials that the directions could determine, odd.")] = 17,
    workers: Annotated[int, typer.Option(help="Processes that solve entries.")] = 1,
    dask: Annotated[str | None, typer.Option(help="Address of a dask scheduler whose workers solve them.")] = None,
    force: Annotated[bool, typer.Option("--force", help=FORCE)] = False,
) -> None:
    """Compute a table book. What is finished is kept beside it, and the same command resumes from there."""
    from varcontact.data.make_table_book import check_out, make_table_book, stores

    check_out("--out", out, force)
    try:
        with cluster(dask, workers) as executor, bar() as progress:
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
    show(f"{book.entries} {book.provenance}; estimated error at most {100 * worst:.1f} % of f Fz; in {out}")
