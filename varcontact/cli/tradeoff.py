"""``varcontact tradeoff``."""

from __future__ import annotations

from typing import Annotated

import typer

from varcontact.cli.options import AsJson, Force, Picture, Table, names_of
from varcontact.cli.terminal import check_outputs, study
from varcontact.errors import SceneError


def tradeoff(
    kind: Annotated[
        str | None, typer.Option("--class", help="Class of scenes.  [default: all]", show_default=False)
    ] = None,
    methods: Annotated[
        str | None,
        typer.Option(
            help="Tangential methods and theories, separated by commas; auto and accuracy are possible.  [default: "
            "several kinds of grids, extrapolation, defect correction, all theories, accuracies of 10 to 0.1 %]",
            show_default=False,
        ),
    ] = None,
    cells: Annotated[
        str, typer.Option(help="Elements across the contact for --methods, separated by commas.")
    ] = "8,12,16,24,32,48",
    out: Table = None,
    plot: Picture = None,
    force: Force = False,
    as_json: AsJson = False,
) -> None:
    """Measure ways to answer the reference scenes: error against the continuum, seconds, memory."""
    from varcontact import checks
    from varcontact.data.benchmark_scenes import CLASSES
    from varcontact.plotting.style import write_picture
    from varcontact.study.references import references
    from varcontact.study.tradeoff import Tradeoff
    from varcontact.study.tradeoff import tradeoff as measure

    check_outputs(out, plot, [], force)
    if kind is not None:
        checks.choice("class", kind, CLASSES)
    bank = {name: each for name, each in references().items() if kind in (None, each.kind)}
    chosen = None if methods is None else names_of(methods)
    try:
        numbers = [int(n) for n in cells.split(",")]
    except ValueError:
        raise SceneError("cells", cells, "whole numbers separated by commas") from None
    found = study(
        lambda progress: measure(bank, chosen, cells=numbers, store=out, progress=progress),
        Tradeoff.to_json if as_json else Tradeoff.report,
        out,
        "--out FILE.csv",
        "scenes",
    )
    if plot is not None:
        write_picture(found.plot(), plot)
