"""``varcontact tradeoff``."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from varcontact.cli.app import app
from varcontact.cli.terminal import FORCE, check_outputs, show, stop, with_progress
from varcontact.errors import Interrupted, SceneError


@app.command(
    short_help="Speed against accuracy: errors against the continuum and costs.",
    epilog='Example: varcontact tradeoff --class "line contact" --methods auto,fastsim --cells 8,16 --plot front.png',
)
def tradeoff(
    kind: Annotated[
        str | None, typer.Option("--class", help="Class of scenes; all of them, if not given.", show_default=False)
    ] = None,
    methods: Annotated[
        str | None,
        typer.Option(
            help="Tangential methods and theories separated by commas, auto among them, and accuracy, for grids found "
            "for 10 to 0.1 per cent; if not given, grids of several kinds, extrapolation, defect correction, all "
            "theories and accuracy."
        ),
    ] = None,
    cells: Annotated[
        str, typer.Option(help="Elements across the contact, separated by commas, for --methods.")
    ] = "8,12,16,24,32,48",
    out: Annotated[
        Path | None, typer.Option(help="Table (.csv), written after each scene; what it has is not measured again.")
    ] = None,
    plot: Annotated[Path | None, typer.Option(help="Picture of error against time (.png, .pdf, .svg).")] = None,
    force: Annotated[bool, typer.Option("--force", help=FORCE)] = False,
    as_json: Annotated[bool, typer.Option("--json", help="Print one JSON object instead of the tables.")] = False,
) -> None:
    """Measure ways to answer the reference scenes: error against the continuum, seconds, memory."""
    from varcontact import checks
    from varcontact.data.benchmark_scenes import CLASSES
    from varcontact.plotting.style import write_picture
    from varcontact.study.references import references
    from varcontact.study.tradeoff import tradeoff as measure

    check_outputs(out, plot, [], force)
    if kind is not None:
        checks.choice("class", kind, CLASSES)
    bank = {name: each for name, each in references().items() if kind in (None, each.kind)}
    chosen = None if methods is None else [name for name in methods.split(",") if name.strip()]
    try:
        numbers = [int(n) for n in cells.split(",")]
    except ValueError:
        raise SceneError("cells", cells, "whole numbers separated by commas") from None
    try:
        found = with_progress(lambda progress: measure(bank, chosen, cells=numbers, store=out, progress=progress))
    except Interrupted as stopped:
        if len(stopped.partial.classes):
            show(stopped.partial.to_json() if as_json else stopped.partial.report())
        stop(stopped, out, "--out FILE.csv", "scenes")
    show(found.to_json() if as_json else found.report())
    if plot is not None:
        write_picture(found.plot(), plot)
