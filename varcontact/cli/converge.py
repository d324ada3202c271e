"""``varcontact converge SCENE.toml --cells 8,12,16``."""

from __future__ import annotations

from typing import Annotated, Any

import typer

from varcontact.cli.options import AsJson, Force, Picture, SceneFile, Solved, Table, names_of
from varcontact.cli.terminal import check_outputs, study


def converge(
    scene: SceneFile,
    cells: Annotated[str, typer.Option(help="Elements across the contact for each grid, separated by commas.")],
    method: Annotated[str, typer.Option(help="Methods, separated by commas, as for compare.")] = "tang-safeguarded",
    offsets: Annotated[int, typer.Option(help="Solves of each grid, at different offsets of the lattice.")] = 4,
    tol: Solved = 1e-6,
    store: Table = None,
    plot: Picture = None,
    force: Force = False,
    as_json: AsJson = False,
) -> None:
    """Solve a scene on successively finer grids: order of convergence, and extrapolated values with their errors."""
    from varcontact.io.scene_toml import read_scene
    from varcontact.plotting.style import write_picture
    from varcontact.study.converge import converge as converge_on
    from varcontact.study.convergence import Convergence

    check_outputs(store, plot, [scene], force, name_of_out="--store")
    described, _ = read_scene(scene)
    grids: list[Any] = [int(n) if n.strip().isdecimal() and len(n) < 20 else n for n in cells.split(",")]
    options: dict[str, Any] = {"offsets": offsets, "tol": tol, "store": store}
    found = study(
        lambda progress: converge_on(described, grids, names_of(method), progress=progress, **options),
        Convergence.to_json if as_json else Convergence.report,
        store,
        "--store FILE.csv",
        "solves",
    )
    if plot is not None:
        write_picture(found.plot(), plot)
