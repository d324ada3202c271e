"""``varcontact converge SCENE.toml --cells 8,12,16``."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

from varcontact.cli.app import app
from varcontact.cli.methods import METHODS
from varcontact.cli.terminal import FORCE, check_outputs, show, stop, with_progress
from varcontact.errors import Interrupted


@app.command(
    short_help="Study the convergence of a scene under grid refinement.",
    epilog=f"{METHODS}\n\nExample: varcontact converge scene.toml --cells 8,12,16,24,32 --plot order.png",
)
def converge(
    scene: Annotated[Path, typer.Argument(help="The scene, a TOML file (docs/scenes.md).", show_default=False)],
    cells: Annotated[str, typer.Option(help="Elements across the contact for each grid, separated by commas.")],
    method: Annotated[str, typer.Option(help="Names separated by commas, as for compare.")] = "tang-safeguarded",
    offsets: Annotated[
        int, typer.Option(help="Solves of each grid, with the lattice shifted by fractions of an element.")
    ] = 4,
    tol: Annotated[float, typer.Option(help="Natural-map residual up to which an answer counts as solved.")] = 1e-6,
    store: Annotated[
        Path | None,
        typer.Option(help="Table of solves (.csv), written after each; solves already in it are not repeated."),
    ] = None,
    plot: Annotated[Path | None, typer.Option(help="Picture of the errors (.png, .pdf, .svg).")] = None,
    force: Annotated[bool, typer.Option("--force", help=FORCE)] = False,
    as_json: Annotated[bool, typer.Option("--json", help="Print one JSON object instead of the tables.")] = False,
) -> None:
    """Solve a scene on successively finer grids: order of convergence, and extrapolated values with their errors."""
    from varcontact.io.scene_toml import read_scene
    from varcontact.plotting.picture_file import write_picture
    from varcontact.study.converge import converge as converge_on

    check_outputs(store, plot, [scene], force, name_of_out="--store")
    described, _ = read_scene(scene)
    grids: list[Any] = [int(n) if n.strip().isdecimal() and len(n) < 20 else n for n in cells.split(",")]
    methods = [name for name in method.split(",") if name.strip()]

    def work(progress: Any) -> Any:
        return converge_on(
            described,
            grids,
            methods,
            offsets=offsets,
            tol=tol,
            store=store,
            progress=progress,
        )

    try:
        study = with_progress(work)
    except Interrupted as stopped:
        if len(stopped.partial.runs):
            show(stopped.partial.to_json() if as_json else stopped.partial.report())
        stop(stopped, store, "--store FILE.csv", "solves")
    show(study.to_json() if as_json else study.report())
    if plot is not None:
        write_picture(study.plot(), plot)
