"""``varcontact table make``."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

from varcontact.cli.options import Dask, Force, Workers
from varcontact.cli.terminal import cluster, progress_bar, show, stop
from varcontact.errors import Interrupted


def make(
    nu: Annotated[float, typer.Option(help="Combined Poisson's ratio of the bodies.", show_default=False)],
    out: Annotated[Path, typer.Option(help="The book, a netCDF file (.nc).", show_default=False)],
    least: Annotated[float, typer.Option(help="Least a/b.")] = 0.2,
    greatest: Annotated[float, typer.Option(help="Greatest a/b.")] = 5.0,
    ratios: Annotated[int, typer.Option(help="Number of ellipses.")] = 9,
    steps: Annotated[int, typer.Option(help="Magnitudes of creepage in each direction.")] = 21,
    degree: Annotated[int, typer.Option(help="Odd degree of polynomials that the directions determine.")] = 17,
    workers: Workers = 1,
    dask: Dask = None,
    force: Force = False,
) -> None:
    """Compute a table book. What is finished is kept beside it, and the same command resumes from there."""
    from varcontact.data.make_table_book import check_out, make_table_book, stores

    check_out("--out", out, force)
    where: dict[str, Any] = {"workers": workers, "out": out, "overwrite": force}
    size: dict[str, Any] = {"least": least, "greatest": greatest, "ratios": ratios, "steps": steps, "degree": degree}
    try:
        with cluster(dask, workers) as executor, progress_bar() as progress:
            book = make_table_book(nu, **size, **where, executor=executor, progress=progress)
    except Interrupted as stopped:
        stop(stopped, stores(out)[0], "--out FILE.nc", "entries")
    worst = float(book.accuracy.max())
    show(f"{book.entries} {book.provenance}; estimated error at most {100 * worst:.1f} % of f Fz; in {out}")
