"""The application: exit statuses, and what every error becomes."""

from __future__ import annotations

from typing import Annotated, Any

import typer
from typer.core import TyperGroup

from varcontact import __version__
from varcontact.cli.terminal import BAD_INPUT, INTERRUPTED, NOT_SOLVED, fail, show
from varcontact.errors import NotConverged, VarcontactError


class _Commands(TyperGroup):
    """All commands: what goes wrong becomes one line on standard error and an exit status."""

    def invoke(self, ctx: Any) -> Any:
        try:
            return super().invoke(ctx)
        except NotConverged as error:
            fail(error, NOT_SOLVED)
        except VarcontactError as error:
            fail(error, BAD_INPUT)
        except MemoryError as error:
            fail(f"out of memory ({error or 'nothing is left'}); a smaller problem would fit", BAD_INPUT)
        except KeyboardInterrupt:
            fail("interrupted; nothing is kept, and the same command starts again from the beginning", INTERRUPTED)


app = typer.Typer(
    name="varcontact",
    cls=_Commands,
    no_args_is_help=True,
    rich_markup_mode=None,  # help is full of brackets
    pretty_exceptions_enable=False,
    help="Rolling contact of elastic bodies as convex optimisation, with a certificate of exactness.",
    epilog="Examples:\n\n"
    "  varcontact solve scene.toml\n\n"
    "  varcontact solve scene.toml --accuracy 0.01\n\n"
    "  varcontact solve scene.toml --json --out solution.nc\n\n"
    "  varcontact solve scene.toml --method convex --plot picture.png\n\n"
    "  varcontact plan scene.toml\n\n"
    "  varcontact compare scene.toml --methods convex,kalker,fastsim\n\n"
    "  varcontact converge scene.toml --cells 8,12,16,24\n\n"
    "  varcontact scan scene.toml --vx 0:5e-3:11 --plot curve.png\n\n"
    "  varcontact sweep sweep.toml --workers 2 --out sweep.nc\n\n"
    "  varcontact wheelrail case.toml --out table.csv\n\n"
    "Exit status: 0 solved, 2 bad input, or too large for the memory, 3 not solved to tolerance (the best iterate is "
    "reported), 130 interrupted (standard error says what is kept).",
)


def _print_version(wanted: bool) -> None:
    if wanted:
        show(f"varcontact {__version__}")
        raise typer.Exit


@app.callback()
def _options(
    version: Annotated[
        bool, typer.Option("--version", callback=_print_version, is_eager=True, help="Print the version and exit.")
    ] = False,
) -> None:
    pass
