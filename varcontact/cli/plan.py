"""``varcontact plan SCENE.toml``."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Annotated

import typer

from varcontact.cli.app import app
from varcontact.cli.methods import METHODS
from varcontact.cli.terminal import show


@app.command(
    short_help="Say what a scene requires, without solving it.",
    epilog=f"{METHODS}\n\nExample: varcontact plan scene.toml --normal clarabel",
)
def plan(
    scene: Annotated[Path, typer.Argument(help="The scene, a TOML file (docs/scenes.md).", show_default=False)],
    method: Annotated[str | None, typer.Option(help="The overall method, as for solve.")] = None,
    normal: Annotated[str | None, typer.Option(help="Normal problem, as for solve.")] = None,
    tangential: Annotated[str | None, typer.Option(help="Tangential problem, as for solve.")] = None,
    coupling: Annotated[str | None, typer.Option(help="Coupling for unlike bodies, as for solve.")] = None,
    formulation: Annotated[str | None, typer.Option(help="Formulation of the programs, as for solve.")] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print one JSON object instead of the report.")] = False,
) -> None:
    """Say what a scene requires, and why, without solving it: methods, elements, matrices, memory."""
    from varcontact.io.scene_file import read_scene
    from varcontact.planning.expectations import check_sizes
    from varcontact.planning.plan import plan as plan_scene

    described, options = read_scene(scene)
    given = {"method": method, "normal": normal, "tangential": tangential, "coupling": coupling}
    given |= {"formulation": formulation}
    chosen = {name: options.get(name, "auto") if value is None else value for name, value in given.items()}
    planned = plan_scene(described, **chosen)
    show(json.dumps(planned.summary(), indent=2, allow_nan=False) if as_json else str(planned))
    if planned.sizes is not None:
        check_sizes(planned, planned.sizes)
