"""``varcontact plan SCENE.toml``."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from varcontact.cli.app import app
from varcontact.cli.methods import METHODS
from varcontact.cli.terminal import show

if TYPE_CHECKING:
    from varcontact.scene.scene import Scene


@app.command(
    short_help="Say what a scene requires, without solving it.",
    epilog=f"{METHODS}\n\nExample: varcontact plan scene.toml --normal clarabel",
)
def plan(
    scene: Annotated[
        Path, typer.Argument(help="The scene, a TOML file (docs/scenes.md), or that of a sweep.", show_default=False)
    ],
    method: Annotated[str | None, typer.Option(help="The overall method, as for solve.")] = None,
    normal: Annotated[str | None, typer.Option(help="Normal problem, as for solve.")] = None,
    tangential: Annotated[str | None, typer.Option(help="Tangential problem, as for solve.")] = None,
    coupling: Annotated[str | None, typer.Option(help="Coupling for unlike bodies, as for solve.")] = None,
    formulation: Annotated[str | None, typer.Option(help="Formulation of the programs, as for solve.")] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print one JSON object instead of the report.")] = False,
) -> None:
    """Say what a scene, or the first one of a sweep, requires, and why, without solving it.

    Methods, elements, matrices, memory.
    """
    from varcontact.io.scene_toml import read_sweep_scene
    from varcontact.planning.expectations import check_sizes
    from varcontact.planning.plan import plan as plan_scene

    described, over, options = read_sweep_scene(scene, varies=False)
    scenes: tuple[Scene, ...] = (described,)
    if over:
        from varcontact.study.parameters import Swept

        scenes = Swept.of(described, over).scenes
    given = {"method": method, "normal": normal, "tangential": tangential, "coupling": coupling}
    given |= {"formulation": formulation}
    chosen = {name: options.get(name, "auto") if value is None else value for name, value in given.items()}
    planned = plan_scene(scenes[0], **chosen)
    if as_json:
        many = {"scenes": len(scenes)} if over else {}
        show(json.dumps({**many, **planned.summary()}, indent=2, allow_nan=False))
    else:
        show((f"A sweep of {len(scenes)} scenes; of the first:\n\n" if over else "") + str(planned))
    if planned.sizes is not None:
        check_sizes(planned, planned.sizes)
