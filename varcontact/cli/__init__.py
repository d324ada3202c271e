"""Command line: its commands, and the conversion of errors to messages and exit statuses."""

from __future__ import annotations

import io
import logging
import sys
from collections.abc import Iterable
from functools import cache
from importlib import import_module
from typing import Annotated, Any, NamedTuple

import typer
from typer.core import TyperGroup

from varcontact import __version__
from varcontact.cli.options import METHODS
from varcontact.cli.terminal import BAD_INPUT, INTERRUPTED, NOT_SOLVED, fail, show
from varcontact.errors import NotConverged, VarcontactError

__all__ = ["INTERRUPTED", "app", "main"]

app: typer.Typer


class Command(NamedTuple):
    """A command: the module of its function, its line in the help, and an example."""

    module: str
    summary: str
    example: str
    names_methods: bool = True


COMMANDS = {
    "solve": Command(
        "solve",
        "Solve one scene.",
        "solve scene.toml --plot picture.png --json",
    ),
    "plan": Command(
        "solve",
        "Show what a scene requires, without solving it.",
        "plan scene.toml --normal clarabel",
    ),
    "compare": Command(
        "compare",
        "Compare methods on the same scenes.",
        "compare scene.toml --methods conic,convex,kalker,fastsim",
    ),
    "converge": Command(
        "compare",
        "Study convergence under grid refinement.",
        "converge scene.toml --cells 8,12,16,24,32",
    ),
    "tradeoff": Command(
        "compare",
        "Measure errors and cost.",
        'tradeoff --class "line contact" --methods auto,fastsim --cells 8,16',
        names_methods=False,
    ),
    "benchmark": Command(
        "benchmark",
        "Compare solvers on the package's set of problems.",
        "benchmark --quick --solver splitting --solver mine:my_solver --out mine.csv",
    ),
    "problems": Command(
        "benchmark",
        "Write the problems of benchmark to files, with solutions.",
        "problems contact_problems",
    ),
    "sweep": Command(
        "sweep",
        "Solve a scene for many values of its entries.",
        "sweep sweep.toml --workers 2 --out sweep.nc",
    ),
    "scan": Command(
        "scan",
        "Solve a scene for many creepages.",
        "scan scene.toml --vx 0:5e-3:11 --plot curve.png",
    ),
    "curve": Command(
        "scan",
        "Creep-force curves by several methods.",
        "curve scene.toml --vx 0:0.01:21 --methods auto,fastsim",
    ),
    "wheelrail": Command(
        "wheelrail",
        "Solve wheels on rails, from profiles.",
        "wheelrail case.toml --out table.csv --plot wheel.png",
        names_methods=False,
    ),
    "suite": Command(
        "contact_files",
        "Compare all input files of CONTACT in a folder with their published results.",
        "suite contact/examples",
        names_methods=False,
    ),
    "profiles": Command(
        "profiles",
        "Read the profiles of a folder, and say what is doubtful.",
        "profiles measured --kind rail",
        names_methods=False,
    ),
    "schema": Command(
        "schema",
        "Print the JSON Schema of input files, for editors.",
        "schema scene --out scene.schema.json",
    ),
    "serve": Command(
        "serve",
        "Solve wheels for a vehicle code, by lines of JSON.",
        "serve --port 5005",
        names_methods=False,
    ),
}
"""Commands by name; `table`, which has subcommands, is added later."""
MAKE_TABLE = "Example: varcontact table make --nu 0.3 --out steel.nc --workers 2"


class _Commands(TyperGroup):
    """Group of all commands: an error becomes one line on standard error and an exit status."""

    def invoke(self, ctx: Any) -> Any:
        try:
            return super().invoke(ctx)
        except VarcontactError as error:
            fail(error, NOT_SOLVED if isinstance(error, NotConverged) else BAD_INPUT)
        except MemoryError as error:
            fail(
                f"out of memory ({error or 'nothing is left'}); a smaller problem would fit",
                BAD_INPUT,
            )
        except KeyboardInterrupt:
            kept = "nothing is kept, and the same command starts again from the beginning"
            fail(f"interrupted; {kept}", INTERRUPTED)


def _print_version(wanted: bool) -> None:
    if wanted:
        show(f"varcontact {__version__}")
        raise typer.Exit


def _options(
    version: Annotated[
        bool,
        typer.Option(
            "--version", callback=_print_version, is_eager=True, help="Print the version and exit."
        ),
    ] = False,
) -> None:
    pass


def _app_of(names: Iterable[str]) -> typer.Typer:
    """Command line with the commands of these names, whose modules are imported."""
    app = typer.Typer(
        name="varcontact",
        cls=_Commands,
        callback=_options,
        no_args_is_help=True,
        rich_markup_mode=None,  # help is full of brackets
        pretty_exceptions_enable=False,
        help="Rolling contact of elastic bodies as convex optimisation, "
        "with a certificate of exactness.",
        epilog="\b\nExamples:\n"
        + "".join(f"  varcontact {each.example}\n" for each in COMMANDS.values())
        + "\nExit status: 0 solved, 2 bad input or too large for the memory, 3 not solved to "
        "tolerance (the best iterate is reported), 130 interrupted (standard error says what is "
        "kept).",
    )
    for name in names:
        command = COMMANDS[name]
        epilog = f"Example: varcontact {command.example}"
        if command.names_methods:
            epilog = f"{METHODS}\n\n{epilog}"
        function = getattr(import_module(f"varcontact.cli.{command.module}"), name)
        app.command(short_help=command.summary, epilog=epilog)(function)
    return app


def _with_tables(app: typer.Typer) -> typer.Typer:
    """The command line with the commands of `table`."""
    from varcontact.cli.sweep import make_table
    from varcontact.cli.vehicle_codes import export_table

    tables = typer.Typer(
        no_args_is_help=True,
        rich_markup_mode=None,
        help="Table books: exact forces for many creepages.",
        epilog=MAKE_TABLE,
    )
    tables.command("make", epilog=MAKE_TABLE)(make_table)
    tables.command("export", epilog="Example: varcontact table export --c vehicle_code")(
        export_table
    )
    app.add_typer(tables, name="table")
    return app


@cache
def _whole_app() -> typer.Typer:
    """The command line with all commands."""
    return _with_tables(_app_of(COMMANDS))


def __getattr__(name: str) -> typer.Typer:
    """`app`: the command line with all commands, built on first access."""
    if name != "app":
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return _whole_app()


def main() -> None:
    """Entry point."""
    if isinstance(sys.stdout, io.TextIOWrapper):  # a terminal may lack the characters of a unit
        sys.stdout.reconfigure(errors="backslashreplace")
    # matplotlib logs much about its caches, and nothing about the picture
    logging.getLogger("matplotlib").setLevel(logging.ERROR)
    # a command given by name needs no other modules
    if sys.argv[1:] and sys.argv[1] in COMMANDS:
        _app_of(sys.argv[1:2])()
    else:
        _whole_app()()
