"""``varcontact compare SCENE.toml ...``."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

from varcontact.cli.app import app
from varcontact.cli.methods import METHODS
from varcontact.cli.terminal import FORCE, check_outputs, show, stop, with_progress
from varcontact.errors import Interrupted, SceneError


@app.command(
    short_help="Compare methods on the same scenes.",
    epilog=f"{METHODS}\n\nExample: varcontact compare scene.toml --methods clarabel,tang,fastsim --plot error.png",
)
def compare(
    scenes: Annotated[list[Path] | None, typer.Argument(help="Scenes, TOML files.", show_default=False)] = None,
    bank: Annotated[bool, typer.Option("--bank", help="Include the standard bank of scenes.")] = False,
    methods: Annotated[
        str | None,
        typer.Option(
            help="Names separated by commas: convex, active-set, kalker, [normal|]tangential[/formulation][+polish]."
        ),
    ] = None,
    tol: Annotated[float, typer.Option(help="Natural-map residual up to which an answer counts as solved.")] = 1e-6,
    accuracy: Annotated[
        float | None,
        typer.Option(help="Compare on the grid on which this accuracy is reached, as for solve.", show_default=False),
    ] = None,
    time_budget: Annotated[
        float | None,
        typer.Option(
            help="In its place, on the grid that solve takes in so many seconds; other methods may take longer on it.",
            show_default=False,
        ),
    ] = None,
    out: Annotated[
        Path | None,
        typer.Option(help="Table (.csv), written after each method; rows already in it are not solved again."),
    ] = None,
    plot: Annotated[Path | None, typer.Option(help="Picture of error against time (.png, .pdf, .svg).")] = None,
    force: Annotated[bool, typer.Option("--force", help=FORCE)] = False,
    workers: Annotated[int, typer.Option(help="Processes that solve scenes; the seconds then are of shared ones.")] = 1,
    as_json: Annotated[bool, typer.Option("--json", help="Print one JSON array instead of the table.")] = False,
) -> None:
    """Solve scenes by several methods and judge each by the same certificate."""
    from varcontact.io.scene_toml import read_scene
    from varcontact.plotting.picture_file import write_picture
    from varcontact.plotting.studies import plot_comparison
    from varcontact.study.bank import standard_bank
    from varcontact.study.compare import DEFAULT_METHODS
    from varcontact.study.compare import compare as compare_methods
    from varcontact.study.store import as_json as table_as_json
    from varcontact.study.tables import summary

    files = scenes or []
    check_outputs(out, plot, files, force)
    known = standard_bank() if bank else {}
    read = {name: read_scene(path) for name, path in by_name(files, set(known)).items()}
    described = {name: scene for name, (scene, _) in read.items()} | known
    if not described:
        raise SceneError(
            "scenes",
            [],
            "one file at least, or --bank",
            message="no scenes to compare: name a scene file or give --bank",
        )
    chosen = DEFAULT_METHODS if methods is None else tuple(name for name in methods.split(",") if name.strip())
    written = table_as_json if as_json else summary
    options: dict[str, Any] = {"accuracy": accuracy, "time_budget": time_budget}
    if accuracy is None and time_budget is None:
        options = asked_in([settings for _, settings in read.values()])
    options["workers"] = workers
    try:
        table = with_progress(
            lambda progress: compare_methods(described, chosen, tol=tol, store=out, progress=progress, **options)
        )
    except Interrupted as stopped:
        if len(stopped.partial):
            show(written(stopped.partial))
        stop(stopped, out, "--out FILE.csv", "methods")
    show(written(table))
    if plot is not None:
        write_picture(plot_comparison(table), plot)


def asked_in(settings: list[dict[str, Any]]) -> dict[str, Any]:
    """The accuracy or the time that scene files ask for, which is one for all of them.

    Parameters
    ----------
    settings : list of dict
        Of each file.

    Raises
    ------
    SceneError
        If they ask for different ones.
    """
    names = ("accuracy", "time_budget")
    wanted = {tuple(each.get(name) for name in names) for each in settings}
    if len(wanted) > 1:
        message = (
            "the scene files ask for different accuracies or times, and methods are compared by one: "
            "give it with --accuracy or --time-budget"
        )
        raise SceneError("accuracy", sorted(wanted, key=str), "one for all files", message=message)
    return dict(zip(names, wanted.pop() if wanted else (None, None), strict=True))


def by_name(files: list[Path], taken: set[str]) -> dict[str, Path]:
    """Scene files by the name of their scene: the file's own, or its path where that is not enough to tell them apart.

    Parameters
    ----------
    files : list of Path
    taken : set of str
        Names of other scenes.
    """
    if len({path.resolve() for path in files}) < len(files):
        given = " ".join(map(str, files))
        raise SceneError("scenes", given, "each file once", message=f"scenes: a file is given twice in {given}")
    stems = [path.stem for path in files]
    names = [path.stem if stems.count(path.stem) == 1 and path.stem not in taken else str(path) for path in files]
    if len({*names, *taken}) < len(names) + len(taken):
        names = [str(path.resolve()) for path in files]
    return dict(zip(names, files, strict=True))
