"""``varcontact solve SCENE.toml``."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from varcontact.cli.app import app
from varcontact.cli.methods import METHODS
from varcontact.cli.terminal import FORCE, check_outputs, show, stop, with_progress
from varcontact.errors import Interrupted, SceneError, VarcontactError

if TYPE_CHECKING:
    from varcontact.scene.scene import Scene

MOVING = (".gif", ".mp4")
"""Endings of the moving pictures of histories."""


@app.command(epilog=f"{METHODS}\n\nExample: varcontact solve scene.toml --plot picture.png --json")
def solve(
    scene: Annotated[
        Path,
        typer.Argument(
            help="The scene, a TOML file (docs/scenes.md); or an input file of CONTACT (.inp).", show_default=False
        ),
    ],
    method: Annotated[str | None, typer.Option(help="The overall method, one of those below.")] = None,
    normal: Annotated[str | None, typer.Option(help="Method of the normal problem, one of those below.")] = None,
    tangential: Annotated[
        str | None, typer.Option(help="Method of the tangential problem, or a theory, one of those below.")
    ] = None,
    coupling: Annotated[
        str | None, typer.Option(help="Coupling of the two problems for unlike bodies, see below.")
    ] = None,
    formulation: Annotated[str | None, typer.Option(help="Formulation of the programs, see below.")] = None,
    polish: Annotated[
        bool | None,
        typer.Option("--polish/--no-polish", help="Refine a solver's answer to rounding.  [default: polish]"),
    ] = None,
    tol: Annotated[float | None, typer.Option(help="Required natural-map residual.  [default: 1e-8]")] = None,
    start: Annotated[
        str | None, typer.Option(help="Under a law of friction, where the search for a solution begins: stick or slip.")
    ] = None,
    certify: Annotated[
        str | None,
        typer.Option(help="The certificate: full, gap (no bounds on forces), none (residuals alone).  [default: auto]"),
    ] = None,
    refine: Annotated[
        str | None,
        typer.Option(help="Correct towards the continuum, of like bodies: continuum.  [default: none]"),
    ] = None,
    accuracy: Annotated[
        float | None,
        typer.Option(
            help="Largest error against the continuum, by the friction limit; the grid is then chosen.",
            show_default=False,
        ),
    ] = None,
    time_budget: Annotated[
        float | None,
        typer.Option(help="Instead of --accuracy, seconds: the most accurate answer within them.", show_default=False),
    ] = None,
    case: Annotated[
        int | None,
        typer.Option(help="Of an input file of CONTACT with several scenes: which one, from 1.", show_default=False),
    ] = None,
    out: Annotated[
        Path | None,
        typer.Option(
            help="Write the solution to this file (.nc; for other programs .csv, .vtu, .vti, .mat). "
            "A history (.nc) on a grid is written step by step and resumed; one to an accuracy at the end."
        ),
    ] = None,
    plot: Annotated[
        Path | None, typer.Option(help="Write a picture to this file (.png, .pdf, .svg; of a history also .gif).")
    ] = None,
    force: Annotated[bool, typer.Option("--force", help=FORCE)] = False,
    as_json: Annotated[bool, typer.Option("--json", help="Print one JSON object instead of the report.")] = False,
) -> None:
    """Solve one scene and report forces, areas and the certificate."""
    from varcontact.io.history_file import check_history_file
    from varcontact.io.solution import ENDINGS, check_solution_file
    from varcontact.scene.motion import Transient
    from varcontact.solving.options import SolveOptions
    from varcontact.solving.solve import solve as solve_scene
    from varcontact.system.files import check_ending

    may_move = plot is not None and plot.suffix.lower() in MOVING
    check_outputs(out, None if may_move else plot, [scene], force, ENDINGS)
    described, options = _read(scene, case)
    if plot is not None and may_move:
        _check_moving(plot, described, [scene] if out is None else [scene, out], force)
    given: dict[str, Any] = {"method": method, "normal": normal, "tangential": tangential, "coupling": coupling}
    given |= {"formulation": formulation, "polish": polish, "tol": tol, "start": start, "certify": certify}
    given |= {"refine": refine, "accuracy": accuracy, "time_budget": time_budget}
    options |= {name: value for name, value in given.items() if value is not None}
    moves = isinstance(described.motion, Transient)
    several = SolveOptions.checked(described, **options).target is not None
    if moves and several:  # of several grids: the answer alone is kept
        if out is not None:
            check_history_file("--out", out, force)
    elif moves:  # the file grows with the history, and is whole at any time
        if out is not None:
            check_ending("--out", out, ".nc")
        options["store"], out = out, None
    elif out is not None:
        check_solution_file("--out", out, force)
    try:
        solution = with_progress(lambda progress: solve_scene(described, **options, progress=progress))
    except Interrupted as stopped:
        if stopped.partial:  # a history of one step at least
            deliver(stopped.partial, out, plot, force, as_json)
        stop(stopped, options.get("store"), "--out FILE.nc", "steps")
    except VarcontactError as failure:
        kept = getattr(failure, "solution", None) if failure.history is None else failure.history
        if kept:
            deliver(kept, out, plot, force, as_json)
        raise
    deliver(solution, out, plot, force, as_json)


def _read(path: Path, case: int | None) -> tuple[Scene, dict[str, Any]]:
    """A scene and how it is to be solved; of an input file of CONTACT one of its scenes."""
    from varcontact.io.contact_input import read_contact_input
    from varcontact.io.scene_toml import read_scene

    if path.suffix.lower() != ".inp":
        if case is not None:
            raise SceneError("--case", case, "left out: only an input file of CONTACT (.inp) has several scenes")
        return read_scene(path)
    scenes = read_contact_input(path)
    number = 1 if case is None and len(scenes) == 1 else case
    if number is None or not 1 <= number <= len(scenes):
        given = "" if number is None else f", not {number}"
        message = f"--case: {str(path)!r} holds {len(scenes)} scenes; give a number from 1 to {len(scenes)}{given}"
        raise SceneError("--case", case, message=message)
    return scenes[number - 1], {}


def deliver(solution: Any, out: Path | None, plot: Path | None, force: bool, as_json: bool) -> None:
    """Print a `solution`, or `as_json`, and write it to `out` and its picture to `plot`; `force` replaces any file."""
    from varcontact.io.solution import save
    from varcontact.plotting.animation import animate
    from varcontact.plotting.picture_file import write_picture
    from varcontact.results.history import History

    try:
        show(json.dumps(solution.summary(), indent=2, allow_nan=False) if as_json else solution.report())
    finally:  # what was computed is not lost with its reader
        if out is not None and isinstance(solution, History):
            solution.save(out, overwrite=force)
        elif out is not None:
            save(solution, out, "--out", force)
        if plot is not None and plot.suffix.lower() in MOVING and isinstance(solution, History):
            animate(solution, plot, field="--plot", overwrite=force)
        elif plot is not None:
            write_picture(solution.plot(), plot)


def _check_moving(plot: Path, scene: Scene, inputs: list[Path], force: bool) -> None:
    """Refuse a file to which a history cannot be written as a moving picture, or anything else as a still one."""
    from varcontact.plotting.animation import check_animation
    from varcontact.plotting.picture_file import check_picture
    from varcontact.scene.motion import Transient

    if isinstance(scene.motion, Transient):
        check_animation("--plot", plot, inputs, force)
    else:
        check_picture(plot, inputs, force)
