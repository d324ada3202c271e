"""``varcontact curve SCENE.toml ...``."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from varcontact.cli.app import app
from varcontact.cli.methods import METHODS
from varcontact.cli.terminal import FORCE, check_outputs, show, with_progress
from varcontact.cli.values import VALUES, values_of

if TYPE_CHECKING:
    import xarray as xr


@app.command(
    short_help="Creep-force curves by several methods.",
    epilog=f"{METHODS}\n\nExample: varcontact curve scene.toml --vx 0:0.01:21 --methods auto,fastsim --plot curve.png",
)
def curve(
    scene: Annotated[Path, typer.Argument(help="The scene, a TOML file (docs/scenes.md).", show_default=False)],
    vx: Annotated[str | None, typer.Option(help=f"Longitudinal creepage: {VALUES}", show_default=False)] = None,
    vy: Annotated[str | None, typer.Option(help="Lateral creepage, in the same way.", show_default=False)] = None,
    spin: Annotated[str | None, typer.Option(help="Spin, in the same way.", show_default=False)] = None,
    methods: Annotated[
        str, typer.Option(help="Names separated by commas: theories, and methods as for compare.")
    ] = "auto,fastsim,fastrip",
    out: Annotated[Path | None, typer.Option(help="Write the dataset to this netCDF file (.nc).")] = None,
    plot: Annotated[Path | None, typer.Option(help="Write a picture to this file (.png, .pdf, .svg).")] = None,
    force: Annotated[bool, typer.Option("--force", help=FORCE)] = False,
    as_json: Annotated[bool, typer.Option("--json", help="Print one JSON array instead of the table.")] = False,
) -> None:
    """Forces and moment against creepages, by fast theories and exact methods side by side.

    What is not given of vx, vy and spin is the scene's own.
    """
    from varcontact.io.scene_toml import read_scene
    from varcontact.plotting.curve import plot_curve
    from varcontact.plotting.picture_file import write_picture
    from varcontact.study.curve import creep_curve
    from varcontact.system.files import write_whole

    check_outputs(out, plot, [scene], force, ".nc")
    described, _ = read_scene(scene)
    given = {"vx": vx, "vy": vy, "spin": spin}
    ranges = {name: values_of(f"--{name}", text) for name, text in given.items() if text is not None}
    names = [name.strip() for name in methods.split(",") if name.strip()]
    found = with_progress(lambda progress: creep_curve(described, names, progress=progress, **ranges))
    if out is not None:
        write_whole("--out", out, bytes(found.to_netcdf(engine="scipy")))
    if plot is not None:
        write_picture(plot_curve(found, normalised=bool(found.limit > 0)), plot)
    show(_json(found) if as_json else _table(found))


def _rows(found: xr.Dataset) -> list[dict[str, object]]:
    table = found.to_dataframe().reset_index()
    return [dict(row) for row in table[["theory", "vx", "vy", "spin", "Fx", "Fy", "Mz"]].to_dict("records")]


def _json(found: xr.Dataset) -> str:
    rows = [{key: None if each != each else each for key, each in row.items()} for row in _rows(found)]
    return json.dumps(rows, indent=2, allow_nan=False)


def _table(found: xr.Dataset) -> str:
    from varcontact.study.tables import columns_of_text

    rows = _rows(found)
    cells = [[str(each) if isinstance(each, str) else f"{each:.5g}" for each in row.values()] for row in rows]
    return "\n".join(columns_of_text([list(rows[0]), *cells], 1))
