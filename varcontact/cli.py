"""The command line: ``varcontact solve SCENE.toml``, ``plan``, ``compare`` and ``converge``."""

from __future__ import annotations

import contextlib
import json
import os
import sys
import textwrap
from collections.abc import Iterable
from pathlib import Path
from typing import Annotated, Any, NoReturn

import typer
from typer.core import TyperGroup

from varcontact import __version__
from varcontact.errors import Interrupted, NotConverged, OutputError, SceneError, VarcontactError
from varcontact.planning.choice import COUPLING_METHODS, FORMULATIONS
from varcontact.planning.roads import ROADS
from varcontact.solvers.registry import normal_methods, tangential_methods
from varcontact.theories.methods import THEORIES

BAD_INPUT, NOT_SOLVED, INTERRUPTED = 2, 3, 130


class _Commands(TyperGroup):
    """All commands: what goes wrong becomes one line on standard error and an exit status."""

    def invoke(self, ctx: Any) -> Any:
        try:
            return super().invoke(ctx)
        except NotConverged as error:
            _fail(error, NOT_SOLVED)
        except VarcontactError as error:
            _fail(error, BAD_INPUT)
        except MemoryError as error:
            _fail(f"out of memory ({error or 'nothing is left'}); a smaller problem would fit", BAD_INPUT)
        except KeyboardInterrupt:
            _fail("interrupted; nothing is kept, and the same command starts again from the beginning", INTERRUPTED)


app = typer.Typer(
    name="varcontact",
    cls=_Commands,
    add_completion=False,
    no_args_is_help=True,
    rich_markup_mode=None,  # help is full of brackets
    pretty_exceptions_enable=False,
    help="Rolling contact of elastic bodies as convex optimisation, with a certificate of exactness.",
    epilog="Examples:\n\n"
    "  varcontact solve scene.toml\n\n"
    "  varcontact solve scene.toml --json --out solution.nc\n\n"
    "  varcontact solve scene.toml --method convex --plot picture.png\n\n"
    "  varcontact plan scene.toml\n\n"
    "  varcontact compare scene.toml --methods convex,kalker,fastsim\n\n"
    "  varcontact converge scene.toml --cells 8,12,16,24\n\n"
    "Exit status: 0 solved, 2 bad input, or too large for the memory, 3 not solved to tolerance (the best iterate is "
    "reported), 130 interrupted (standard error says what is kept).",
)


def _print_version(wanted: bool) -> None:
    if wanted:
        _print(f"varcontact {__version__}")
        raise typer.Exit


@app.callback()
def _options(
    version: Annotated[
        bool, typer.Option("--version", callback=_print_version, is_eager=True, help="Print the version and exit.")
    ] = False,
) -> None:
    pass


def _listed(kind: str, names: Iterable[str]) -> str:
    """Names as lines that help does not fill again: it would break them at their hyphens."""
    return textwrap.fill(f"{kind}: {', '.join(names)}.", 76, subsequent_indent="    ", break_on_hyphens=False)


METHODS = "\b\n" + "\n".join(
    (
        _listed("Overall method", ROADS),
        _listed("Normal problem", ("auto", *normal_methods())),
        _listed("Tangential problem", ("auto", *tangential_methods())),
        _listed("Approximate theories of the tangential problem", THEORIES),
        _listed("Coupling, for unlike bodies", ("auto", *COUPLING_METHODS)),
        _listed("Formulation of the programs", ("auto", *FORMULATIONS)),
    )
)
"""All methods by name."""
FORCE = "Replace files that varcontact did not write; a table or a history is only ever added to."


@app.command(epilog=f"{METHODS}\n\nExample: varcontact solve scene.toml --plot picture.png --json")
def solve(
    scene: Annotated[Path, typer.Argument(help="The scene, a TOML file (docs/scenes.md).", show_default=False)],
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
    out: Annotated[
        Path | None,
        typer.Option(
            help="Write the solution to this netCDF file (.nc). A history is written step by step and resumed."
        ),
    ] = None,
    plot: Annotated[Path | None, typer.Option(help="Write a picture to this file (.png, .pdf, .svg).")] = None,
    force: Annotated[bool, typer.Option("--force", help=FORCE)] = False,
    as_json: Annotated[bool, typer.Option("--json", help="Print one JSON object instead of the report.")] = False,
) -> None:
    """Solve one scene and report forces, areas and the certificate."""
    from varcontact.io.scene_file import read_scene
    from varcontact.io.solution_file import check_solution_file
    from varcontact.scene.motion import Transient
    from varcontact.solving.solve import solve as solve_scene

    _check_outputs(out, plot, [scene], force, ".nc")
    described, options = read_scene(scene)
    given: dict[str, Any] = {"method": method, "normal": normal, "tangential": tangential, "coupling": coupling}
    given |= {"formulation": formulation, "polish": polish, "tol": tol, "start": start, "certify": certify}
    options |= {name: value for name, value in given.items() if value is not None}
    if isinstance(described.motion, Transient):  # the file grows with the history, and is whole at any time
        options["store"], out = out, None
    if out is not None:
        check_solution_file("--out", out, force)
    try:
        solution = _with_progress(lambda progress: solve_scene(described, **options, progress=progress))
    except Interrupted as stopped:
        if stopped.partial:  # a history of one step at least
            _deliver(stopped.partial, out, plot, force, as_json)
        _stop(stopped, options["store"], "--out FILE.nc", "steps")
    except VarcontactError as failure:
        kept = getattr(failure, "solution", None) if failure.history is None else failure.history
        if kept:
            _deliver(kept, out, plot, force, as_json)
        raise
    _deliver(solution, out, plot, force, as_json)


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
    _print(json.dumps(planned.summary(), indent=2, allow_nan=False) if as_json else str(planned))
    if planned.sizes is not None:
        check_sizes(planned, planned.sizes)


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
    out: Annotated[
        Path | None,
        typer.Option(help="Table (.csv), written after each method; rows already in it are not solved again."),
    ] = None,
    plot: Annotated[Path | None, typer.Option(help="Picture of error against time (.png, .pdf, .svg).")] = None,
    force: Annotated[bool, typer.Option("--force", help=FORCE)] = False,
    as_json: Annotated[bool, typer.Option("--json", help="Print one JSON array instead of the table.")] = False,
) -> None:
    """Solve scenes by several methods and judge each by the same certificate."""
    from varcontact.io.scene_file import read_scene
    from varcontact.plotting.picture_file import write_picture
    from varcontact.plotting.studies import plot_comparison
    from varcontact.study.bank import standard_bank
    from varcontact.study.compare import DEFAULT_METHODS
    from varcontact.study.compare import compare as compare_methods
    from varcontact.study.store import as_json as table_as_json
    from varcontact.study.tables import summary

    files = scenes or []
    _check_outputs(out, plot, files, force)
    known = standard_bank() if bank else {}
    described = {name: read_scene(path)[0] for name, path in _by_name(files, set(known)).items()} | known
    if not described:
        raise SceneError(
            "scenes",
            [],
            "one file at least, or --bank",
            message="no scenes to compare: name a scene file or give --bank",
        )
    chosen = DEFAULT_METHODS if methods is None else tuple(name for name in methods.split(",") if name.strip())
    show = table_as_json if as_json else summary
    try:
        table = _with_progress(
            lambda progress: compare_methods(described, chosen, tol=tol, store=out, progress=progress)
        )
    except Interrupted as stopped:
        if len(stopped.partial):
            _print(show(stopped.partial))
        _stop(stopped, out, "--out FILE.csv", "methods")
    _print(show(table))
    if plot is not None:
        write_picture(plot_comparison(table), plot)


@app.command(
    short_help="Study the convergence of a scene under grid refinement.",
    epilog=f"{METHODS}\n\nExample: varcontact converge scene.toml --cells 8,12,16,24,32 --plot order.png",
)
def converge(
    scene: Annotated[Path, typer.Argument(help="The scene, a TOML file (docs/scenes.md).", show_default=False)],
    cells: Annotated[str, typer.Option(help="Elements across the contact for each grid, separated by commas.")],
    method: Annotated[str, typer.Option(help="Names separated by commas, as for compare.")] = "tang-safeguarded",
    offsets: Annotated[
        int, typer.Option(help="Solves of each grid, with the lattice shifted by fractions of an element.")
    ] = 4,
    tol: Annotated[float, typer.Option(help="Natural-map residual up to which an answer counts as solved.")] = 1e-6,
    store: Annotated[
        Path | None,
        typer.Option(help="Table of solves (.csv), written after each; solves already in it are not repeated."),
    ] = None,
    plot: Annotated[Path | None, typer.Option(help="Picture of the errors (.png, .pdf, .svg).")] = None,
    force: Annotated[bool, typer.Option("--force", help=FORCE)] = False,
    as_json: Annotated[bool, typer.Option("--json", help="Print one JSON object instead of the tables.")] = False,
) -> None:
    """Solve a scene on successively finer grids: order of convergence, and extrapolated values with their errors."""
    from varcontact.io.scene_file import read_scene
    from varcontact.plotting.picture_file import write_picture
    from varcontact.study.converge import converge as converge_on

    _check_outputs(store, plot, [scene], force, name_of_out="--store")
    described, _ = read_scene(scene)
    grids: list[Any] = [int(n) if n.strip().isdecimal() and len(n) < 20 else n for n in cells.split(",")]
    methods = [name for name in method.split(",") if name.strip()]

    def work(progress: Any) -> Any:
        return converge_on(
            described,
            grids,
            methods,
            offsets=offsets,
            tol=tol,
            store=store,
            progress=progress,
        )

    try:
        study = _with_progress(work)
    except Interrupted as stopped:
        if len(stopped.partial.runs):
            _print(stopped.partial.to_json() if as_json else stopped.partial.report())
        _stop(stopped, store, "--store FILE.csv", "solves")
    _print(study.to_json() if as_json else study.report())
    if plot is not None:
        write_picture(study.plot(), plot)


def main() -> None:
    """Entry point."""
    app()


def _by_name(files: list[Path], taken: set[str]) -> dict[str, Path]:
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


def _deliver(solution: Any, out: Path | None, plot: Path | None, force: bool, as_json: bool) -> None:
    """Print, and write what was asked for."""
    from varcontact.io.solution_file import save
    from varcontact.plotting.picture_file import write_picture

    try:
        _print(json.dumps(solution.summary(), indent=2, allow_nan=False) if as_json else solution.report())
    finally:  # what was computed is not lost with its reader
        if out is not None:
            save(solution, out, "--out", force)
        if plot is not None:
            write_picture(solution.plot(), plot)


def _print(text: str) -> None:
    try:
        try:
            print(text, flush=True)
        except UnicodeEncodeError:  # a terminal that does not have the letters of a unit
            encoding = sys.stdout.encoding
            print(text.encode(encoding, "backslashreplace").decode(encoding), flush=True)
    except BrokenPipeError:  # the reader has gone: nothing wrong, and nothing more to say
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    except OSError as error:
        raise OutputError("standard output", "", f"cannot be written ({error.strerror})") from None


def _with_progress(work: Any) -> Any:
    """Run with the name of the stage on standard error, where that is a terminal; solvers print there, too."""
    from rich.console import Console

    console = Console(stderr=True)
    with contextlib.redirect_stdout(sys.stderr):
        if not console.is_terminal:
            return work(None)
        with console.status("reading") as status:
            return work(status.update)


def _check_outputs(
    out: Path | None,
    plot: Path | None,
    inputs: list[Path],
    force: bool,
    ending: str = ".csv",
    name_of_out: str = "--out",
) -> None:
    """Refuse files that could not, or must not, be written, before any work is done for them."""
    from varcontact.io.outputs import check_ending, check_writable
    from varcontact.plotting.picture_file import check_picture

    if out is not None:
        check_ending(name_of_out, out, ending)
        check_writable(name_of_out, out, inputs)
    if plot is not None:
        check_picture(plot, inputs if out is None else [*inputs, out], force)


def _stop(stopped: Interrupted, store: Path | None, option: str, what: str) -> NoReturn:
    """After Ctrl-C: what is kept, and how to go on."""
    if store is None:
        kept = f"nothing is kept; with {option}, finished {what} are kept and the same command resumes from there"
    elif store.exists():
        kept = f"finished {what} are kept in {store}, and the same command resumes from there"
    else:
        kept = f"nothing is kept in {store} yet, and the same command starts again from the beginning"
    _fail(f"{stopped}; {kept}", INTERRUPTED)


def _fail(error: object, status: int) -> NoReturn:
    print(f"varcontact: {error}", file=sys.stderr)
    raise SystemExit(status)


if __name__ == "__main__":
    main()
