"""``varcontact compare SCENE.toml ...``, ``converge SCENE.toml --cells 8,12,16`` and
``tradeoff``.
"""

from __future__ import annotations

from collections.abc import Container
from functools import partial
from pathlib import Path
from typing import Annotated, Any

import typer

import varcontact as vc
from varcontact.cli import options as opt
from varcontact.cli.options import counts_of, names_of
from varcontact.cli.terminal import check_outputs, draw, study
from varcontact.errors import SceneError


@opt.takes(*opt.TARGET)
def compare(
    scenes: Annotated[list[Path] | None, opt.argument("Scenes, TOML files.")] = None,
    bank: Annotated[
        bool, typer.Option("--bank", help="Include the standard bank of scenes.")
    ] = False,
    methods: opt.Methods = None,
    tol: opt.Solved = 1e-6,
    out: opt.Table = None,
    plot: opt.Picture = None,
    force: opt.Force = False,
    workers: opt.Workers = 1,
    as_json: opt.AsJson = False,
    **options: Any,
) -> None:
    """Solve scenes by several methods and judge each by the same certificate."""
    from varcontact.study.compare import summary
    from varcontact.study.csv_table import as_json as table_as_json
    from varcontact.study.methods import DEFAULT_METHODS

    files = scenes or []
    check_outputs(out, plot, files, force)
    standard = vc.standard_bank() if bank else {}
    if len({path.resolve() for path in files}) < len(files):
        raise SceneError("scenes", " ".join(map(str, files)), "each file once")
    read = {name: vc.read_scene(path) for name, path in _names(files, standard).items()}
    described = {name: scene for name, (scene, _) in read.items()} | standard
    if not described:
        raise SceneError("scenes", None, "given: name a scene file or give --bank")
    chosen = DEFAULT_METHODS if methods is None else names_of(methods)
    if options == dict.fromkeys(opt.TARGET) and read:
        options = _common_target([settings for _, settings in read.values()])
    work = partial(vc.compare, described, chosen, tol=tol, store=out, workers=workers, **options)
    written = table_as_json if as_json else summary
    found = study(work, written, out, "--out FILE.csv", "scenes")
    if plot is not None:
        draw(plot, vc.plot_comparison, found)


def _names(files: list[Path], others: Container[str]) -> dict[str, Path]:
    """Names of files: their stems, or their paths if stems are not unique."""
    stems = [path.stem for path in files]
    named = {}
    for path in files:
        unique = stems.count(path.stem) == 1 and path.stem not in others
        named[path.stem if unique else str(path)] = path
    return named


def _common_target(settings: list[dict[str, Any]]) -> dict[str, Any]:
    """Accuracy and time budget of the scene files, which must be the same for all."""
    targets = {tuple(each.get(name) for name in opt.TARGET) for each in settings}
    if len(targets) > 1:
        allowed = "the same for all scene files; give it with --accuracy or --time-budget"
        raise SceneError("accuracy", sorted(targets, key=str), allowed)
    return dict(zip(opt.TARGET, *targets, strict=True))


def converge(
    scene: opt.SceneFile,
    cells: Annotated[
        str, typer.Option(help="Elements across the contact for each grid, separated by commas.")
    ],
    method: Annotated[
        str, typer.Option(help="Methods, separated by commas, as for compare.")
    ] = "tang-safeguarded",
    offsets: Annotated[
        int, typer.Option(help="Solves of each grid, at different offsets of the lattice.")
    ] = 4,
    tol: opt.Solved = 1e-6,
    store: opt.Table = None,
    plot: opt.Picture = None,
    force: opt.Force = False,
    as_json: opt.AsJson = False,
) -> None:
    """Solve a scene on successively finer grids: order of convergence, and extrapolated values with
    their errors.
    """
    check_outputs(store, plot, [scene], force, name_of_out="--store")
    described, _ = vc.read_scene(scene)
    work = partial(
        vc.converge,
        described,
        counts_of(cells),
        names_of(method),
        offsets=offsets,
        tol=tol,
        store=store,
    )
    written = vc.Convergence.to_json if as_json else vc.Convergence.report
    draw(plot, vc.Convergence.plot, study(work, written, store, "--store FILE.csv", "solves"))


METHODS = "Tangential methods and theories, separated by commas; auto and accuracy are possible."
ALL = "several kinds of grids, extrapolation, all theories, accuracies of 10 to 0.1 %"


def tradeoff(
    kind: Annotated[str | None, opt.option("Class of scenes.", "--class", default="all")] = None,
    methods: Annotated[str | None, opt.option(METHODS, default=ALL)] = None,
    cells: Annotated[
        str, typer.Option(help="For --methods: elements across the contact.")
    ] = "8,12,16,24,32,48",
    out: opt.Table = None,
    plot: opt.Picture = None,
    force: opt.Force = False,
    as_json: opt.AsJson = False,
) -> None:
    """Measure ways to answer the reference scenes: error against the continuum, seconds, memory."""
    from varcontact import checks

    check_outputs(out, plot, [], force)
    bank = vc.continuum_values()
    if kind is not None:
        checks.choice("class", kind, dict.fromkeys(each.kind for each in bank.values()))
        bank = {name: each for name, each in bank.items() if each.kind == kind}
    chosen = None if methods is None else names_of(methods)
    work = partial(vc.tradeoff, bank, chosen, cells=counts_of(cells), store=out)
    written = vc.Tradeoff.to_json if as_json else vc.Tradeoff.report
    draw(plot, vc.Tradeoff.plot, study(work, written, out, "--out FILE.csv", "scenes"))
