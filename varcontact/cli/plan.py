"""``varcontact plan SCENE.toml``."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Annotated

import typer

from varcontact.cli import options as opt
from varcontact.cli.options import given
from varcontact.cli.terminal import show


def plan(
    scene: Annotated[Path, typer.Argument(help="Scene (docs/scenes.md) or sweep, a TOML file.", show_default=False)],
    method: opt.MethodName = None,
    normal: opt.Normal = None,
    tangential: opt.Tangential = None,
    coupling: opt.Coupling = None,
    formulation: opt.Formulation = None,
    as_json: opt.AsJson = False,
) -> None:
    """Show what a scene, or the first one of a sweep, requires, and why: methods, elements, matrices, memory."""
    from varcontact.io.scene_toml import read_sweep_scene
    from varcontact.solving.plan_report import check_planned
    from varcontact.solving.plan_report import plan as plan_scene
    from varcontact.study.parameters import Swept

    described, over, options = read_sweep_scene(scene, varies=False)
    scenes = Swept.of(described, over).scenes if over else (described,)
    choices = ("method", "normal", "tangential", "coupling", "formulation")
    options = {name: options[name] for name in choices if name in options}
    options |= given(method=method, normal=normal, tangential=tangential, coupling=coupling, formulation=formulation)
    planned = plan_scene(scenes[0], **options)
    if as_json:
        many = {"scenes": len(scenes)} if over else {}
        show(json.dumps({**many, **planned.summary()}, indent=2, allow_nan=False))
    else:
        show((f"A sweep of {len(scenes)} scenes; of the first:\n\n" if over else "") + str(planned))
    check_planned(planned)
