"""``varcontact curve SCENE.toml ...``."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Annotated, Any

import typer

from varcontact.cli import options as opt
from varcontact.cli.options import given, names_of, values_of
from varcontact.cli.terminal import check_outputs, show, with_progress


def curve(
    scene: opt.SceneFile,
    vx: opt.Vx = None,
    vy: opt.Vy = None,
    spin: opt.Spin = None,
    methods: Annotated[
        str, typer.Option(help="Theories, and methods as for compare, separated by commas.")
    ] = "auto,fastsim,fastrip",
    out: Annotated[Path | None, typer.Option(help="Dataset (.nc).")] = None,
    plot: opt.Picture = None,
    force: opt.Force = False,
    as_json: opt.AsJson = False,
) -> None:
    """Forces and moment against creepages, by fast theories and exact methods side by side.

    Creepages that are not given are taken from the scene.
    """
    from varcontact.io.scene_toml import read_scene
    from varcontact.plotting.studies import plot_curve
    from varcontact.plotting.style import write_picture
    from varcontact.study.csv_table import columns_of_text
    from varcontact.study.scan import creep_curve
    from varcontact.system.files import write_whole

    check_outputs(out, plot, [scene], force, ".nc")
    described, _ = read_scene(scene)
    ranges = {name: values_of(f"--{name}", text) for name, text in given(vx=vx, vy=vy, spin=spin).items()}
    found = with_progress(lambda progress: creep_curve(described, names_of(methods), progress=progress, **ranges))
    if out is not None:
        write_whole("--out", out, bytes(found.to_netcdf(engine="scipy")))
    if plot is not None:
        write_picture(plot_curve(found, normalised=bool(found.limit > 0)), plot)
    columns = ["theory", "vx", "vy", "spin", "Fx", "Fy", "Mz"]
    rows: list[dict[str, Any]] = found.to_dataframe().reset_index()[columns].to_dict("records")
    if as_json:
        plain = [{key: None if each != each else each for key, each in row.items()} for row in rows]
        show(json.dumps(plain, indent=2, allow_nan=False))
    else:
        cells = [[str(each) if isinstance(each, str) else f"{each:.5g}" for each in row.values()] for row in rows]
        show("\n".join(columns_of_text([columns, *cells], 1)))
