"""``varcontact solve SCENE.toml``, and ``varcontact plan SCENE.toml``, which does not solve it."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Annotated, Any

import varcontact as vc
from varcontact.cli import options as opt
from varcontact.cli.options import given
from varcontact.cli.terminal import check_outputs, draw, progress_line, show, stop
from varcontact.errors import Interrupted, NotConverged, SceneError, VarcontactError

OUT = (
    "Solution (.nc; .csv, .vtu, .vti, .mat), or the report (.html). "
    "Histories on a grid are resumed (.nc)."
)
MOVING = (".gif", ".mp4")
"""Endings of the moving pictures of histories."""


@opt.takes(*opt.METHOD, "polish", "tol", "start", "certify", "refine", *opt.TARGET, *opt.CONTACT)
def solve(
    scene: Annotated[
        Path, opt.argument("Scene (TOML, docs/scenes.md) or CONTACT's input file (.inp).")
    ],
    case: Annotated[
        int | None, opt.option("Number of the scene in CONTACT's input file, from 1.")
    ] = None,
    out: Annotated[Path | None, opt.option(OUT)] = None,
    plot: Annotated[
        Path | None, opt.option("Picture (.png, .pdf, .svg; of a history also .gif).")
    ] = None,
    force: opt.Force = False,
    as_json: opt.AsJson = False,
    **options: Any,
) -> None:
    """Solve one scene and report forces, areas and the certificate; or all cases of CONTACT's
    input file, compared with its output.
    """
    for_contact = opt.for_contact(options)
    if any(for_contact.values()):
        from varcontact.cli.contact_files import solve_all

        solve_all(scene, **for_contact, as_json=as_json)
        return
    from varcontact.io.history import check_history_file
    from varcontact.io.solution import FORMATS, check_solution_file
    from varcontact.solving.options import SolveOptions
    from varcontact.system.files import check_ending

    described, settings = _read(scene, case)
    moves = isinstance(described.motion, vc.Transient)
    if moves and plot is not None and plot.suffix.lower() in MOVING:
        from varcontact.plotting.history import check_animation

        check_outputs(out, None, [scene], force, FORMATS)
        check_animation("--plot", plot, [scene] if out is None else [scene, out], force)
    else:
        check_outputs(out, plot, [scene], force, FORMATS)
    settings |= given(**options)
    several = SolveOptions.checked(described, **settings).target is not None
    if moves and not several:  # the file grows with the history, and is complete at any time
        if out is not None:
            check_ending("--out", out, ".nc")
        settings["store"] = out
        out = None
    elif out is not None:
        check = check_history_file if moves else check_solution_file
        check("--out", out, force)
    try:
        with progress_line() as progress:
            solution = vc.solve(described, **settings, progress=progress)
    except Interrupted as stopped:
        if stopped.partial:  # a history of one step at least
            deliver(stopped.partial, out, plot, force, as_json)
        stop(stopped, settings.get("store"), "--out FILE.nc", "steps")
    except VarcontactError as failure:
        kept = failure.history
        if kept is None and isinstance(failure, NotConverged):
            kept = failure.solution
        if kept:
            deliver(kept, out, plot, force, as_json)
        raise
    deliver(solution, out, plot, force, as_json)


def _read(path: Path, case: int | None) -> tuple[vc.Scene, dict[str, Any]]:
    if path.suffix.lower() != ".inp":
        if case is not None:
            raise SceneError(
                "--case", case, "left out: only an input file of CONTACT (.inp) has several scenes"
            )
        return vc.read_scene(path)
    scenes = vc.read_contact_input(path)
    number = 1 if case is None and len(scenes) == 1 else case
    if number is None or not 1 <= number <= len(scenes):
        instead = "" if number is None else f", not {number}"
        message = (
            f"--case: {str(path)!r} holds {len(scenes)} scenes; "
            f"give a number from 1 to {len(scenes)}{instead}"
        )
        raise SceneError("--case", case, message=message)
    return scenes[number - 1], {}


def deliver(solution: Any, out: Path | None, plot: Path | None, force: bool, as_json: bool) -> None:
    """Print a solution or a history, and write it and its picture to their files."""
    from varcontact.io.solution import save

    try:
        if as_json:
            show(json.dumps(solution.summary(), indent=2, allow_nan=False))
        else:
            show(solution.report())
    finally:  # computed results are kept if the reader has gone
        if out is not None and isinstance(solution, vc.History):
            solution.save(out, overwrite=force)
        elif out is not None:
            save(solution, out, "--out", force)
        if plot is not None and plot.suffix.lower() in MOVING and isinstance(solution, vc.History):
            from varcontact.plotting.history import animate

            animate(solution, plot, field="--plot", overwrite=force)
        else:
            draw(plot, solution.plot)


@opt.takes(*opt.METHOD)
def plan(
    scene: Annotated[Path, opt.argument("Scene (docs/scenes.md) or sweep, a TOML file.")],
    as_json: opt.AsJson = False,
    **options: Any,
) -> None:
    """Show what a scene, or the first one of a sweep, requires, and why: methods, elements,
    matrices, memory.
    """
    from varcontact.io.scene_toml import read_sweep_scene
    from varcontact.solving.plan_report import check_planned
    from varcontact.study.parameters import scenes_over

    described, over, settings = read_sweep_scene(scene, varies=False)
    scenes = scenes_over(described, over)[1] if over else [described]
    named = {name: value for name, value in settings.items() if name in opt.METHOD}
    planned = vc.plan(scenes[0], methods=vc.Methods(**named | given(**options)))
    if as_json:
        many = {"scenes": len(scenes)} if over else {}
        show(json.dumps({**many, **planned.summary()}, indent=2, allow_nan=False))
    else:
        heading = f"A sweep of {len(scenes)} scenes; of the first:\n\n" if over else ""
        show(heading + str(planned))
    check_planned(planned)
