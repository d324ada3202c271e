"""The command that prints JSON Schemas of input files."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Annotated

import typer

from varcontact import checks
from varcontact.cli.terminal import show


def schema(
    kind: Annotated[str, typer.Argument(help="scene, sweep or wheel.")] = "scene",
    out: Annotated[
        Path | None, typer.Option(help="File to write (.json); printed if not given.")
    ] = None,
) -> None:
    """Print the JSON Schema of scene, sweep or case files (of wheels), for editors that complete
    and check TOML.

    Name it in the first line of a file: #:schema ./scene.schema.json
    """
    from varcontact.cli.json_schema import SCHEMAS
    from varcontact.system.files import check_replaceable, write_whole

    text = json.dumps(SCHEMAS[checks.choice("KIND", kind, SCHEMAS)](), indent=1)
    if out is None:
        show(text)
        return
    check_replaceable("--out", out, (".json",), "schema", rb".*varcontact-\w+\.schema", False)
    write_whole("--out", out, text.encode())
